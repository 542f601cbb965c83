"""A weldment: modelled, its seams edited, calibrated, moved to its real place, and exported as a robot program."""

import subprocess
from pathlib import Path

from build123d import Box, Compound, Pos, export_step

import cad
import wpcal
from cad.workpiece.calibrate import calibrate_files
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.seams import SeamChoice
from wpcal.seam.edit import PlacedEdit, SeamEdit

plate, web = Pos(100, 60, 5) * Box(200, 120, 10), Pos(100, 60, 50) * Box(150, 8, 80)
plate.label, web.label = "plate", "web"
export_step(Compound(label="weldment", children=[plate, web]), "weldment.step")
part = cad.open_workpiece("weldment.step")
seams, _ = cad.find_seams(part, wpcal.SeamOptions())
accepted = [seam for seam in seams if seam.accepted]
edits = (PlacedEdit(accepted[0].candidate, SeamEdit(reverse=True, name="root")),)  # as in seams.json
options = CalibrateOptions(choice=SeamChoice(edits))
p_base = [[900.20, 99.74, 60.04], [864.48, 214.60, 59.98], [1055.40, 273.72, 59.91], [1048.60, 212.88, 139.96]]
touched = wpcal.TaughtPoints.of_features(["V2", "V4", "V16", "V12"], p_base)
found = cad.calibrate_workpiece(part, touched, options=options)
print(f"{found.result.verdict}; the real plate ends at {found.moved_shapes()[0].bounding_box().max}")
written = calibrate_files(part, touched, Path("result"), overwrite=True, options=options)
print("wrote", *written.files)
subprocess.run(["wpcal", "export", "result", "-f", "rapid", "--force"], check=found.result.verdict == "PASS")
