"""Pictures and drawings of a calibrated part: PNG, DXF, GLB."""
