"""Pictures and drawings of a part and its seams: PNG (`picture`), DXF (`dxf`), GLB (`glb`). No kernel is needed."""
