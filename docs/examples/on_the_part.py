"""What can be taught and what can be welded on a part that a script models; everything in part coordinates."""

from build123d import Box, Pos

import cad
import wpcal

plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
plate.label, web.label = "plate", "web"
workpiece = cad.open_workpiece([plate, web])
for feature in workpiece.features:
    print(f"{feature.name}: {feature.kind.word} of {feature.solid} at {feature.p_mm.tolist()}")
print("V2 is at", wpcal.feature_named(workpiece.features, "V2").p_mm.tolist())
seams, workpiece = cad.find_seams(workpiece, wpcal.SeamOptions())
for seam in seams:
    print(f"{seam.name}: {'accepted' if seam.accepted else seam.against[0]}, first {cad.seam_planes(seam.frames)[0]}")
