"""What every page of wpcal is made of: a part's mesh, the bundled 3-D view, and one self-contained HTML file."""

from wpcal.viewer.page import build_page, json_blob
from wpcal.viewer.part_glb import read_part_glb, write_part_glb
from wpcal.viewer.part_mesh import PartMesh, SolidMesh

__all__ = ["PartMesh", "SolidMesh", "build_page", "json_blob", "read_part_glb", "write_part_glb"]
