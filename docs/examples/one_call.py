"""The main job in one call: shapes of build123d and touched points in, weld seams in the robot's base out."""

from build123d import Box, Pos

import cad

plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
plate.label, web.label = "plate", "web"  # a label becomes the name of the solid
touched = {  # names as `on_the_part.py` prints them
    "V2": (900.20, 99.74, 60.04),
    "V4": (864.48, 214.60, 59.98),
    "V16": (1055.40, 273.72, 59.91),
    "V12": (1048.60, 212.88, 139.96),
}
found = cad.calibrate_workpiece([plate, web], touched)
print(found)  # verdict, pose, worst seam; found.candidates are all that could be welds
for seam in found.seams:
    frames = seam.frames.moved(found.T_base_part)  # frames.matrices: (n, 4, 4), mm; frames.rotations: SciPy
    wire = cad.seam_wire(found.workpiece.graph, seam, found.T_base_part)  # its exact curve in build123d
    print(f"{seam.name}: {seam.joint.value}, {wire.length:.1f} mm, starts at {cad.seam_locations(frames)[0]}")
