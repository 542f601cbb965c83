"""The CAD side of wpcal: everything that touches build123d, OCP, trimesh or ezdxf."""
