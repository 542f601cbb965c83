"""The main job in one call: shapes of build123d and touched points in, weld seams in the robot's base out."""

from build123d import Box, Pos

import cad
import wpcal

plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
plate.label, web.label = "plate", "web"  # a label becomes the name of the solid
p_base = [[900.20, 99.74, 60.04], [864.48, 214.60, 59.98], [1055.40, 273.72, 59.91], [1048.60, 212.88, 139.96]]
touched = wpcal.TaughtPoints.of_features(["V2", "V4", "V16", "V12"], p_base)  # names as `on_the_part.py` prints them
found = cad.calibrate_workpiece([plate, web], touched)
print(f"{found.result.verdict}: largest residual {found.result.largest_mm:.3f} mm")
for seam in found.seams:
    frames = seam.frames.moved(found.T_base_part)  # frames.matrices: (n, 4, 4), mm; frames.rotations: SciPy
    wire = cad.seam_wire(found.workpiece.graph, seam, found.T_base_part)  # its exact curve in build123d
    print(f"{seam.name}: {seam.joint.value}, {wire.length:.1f} mm, starts at {cad.seam_locations(frames)[0]}")
