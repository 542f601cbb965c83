"""The main job link by link, from files: each step takes and returns plain values.

Usage: python in_steps.py PART.step TAUGHT.csv MOVED.step
"""

import sys
from pathlib import Path

from cad.kernel.to_brep import to_brep
from cad.step.read import read_step
from cad.step.write import write_moved_step
from wpcal.calibrate import calibrate
from wpcal.features import find_features
from wpcal.seam import SeamOptions, StepOptions, detect_seams
from wpcal.taught.table import pair_points, read_taught

part_step, taught_csv, moved_step = (Path(argument) for argument in sys.argv[1:])

part = read_step(part_step)
for issue in part.issues:
    print("note:", issue.message)

graph = to_brep((solid.name, solid.shape) for solid in part.solids)
features = find_features(graph)
pairs, check = pair_points(read_taught(taught_csv), features)

result = calibrate(pairs, check=check)
print(f"{result.verdict}: largest residual {result.residuals.largest_mm:.3f} mm at {result.residuals.worst}")
print(f"no rigid fit has a largest residual below {result.lower_bound_mm:.3f} mm")

seams = detect_seams(graph, SeamOptions(steps=StepOptions(chord_mm=0.05)))
for seam in seams:
    frames = seam.frames.moved(result.T_base_part)
    u95 = result.predict_error_mm(seam.frames.p)
    print(f"{seam.name}: {seam.joint.value} {len(frames)} frames, 95 % error at most {u95.max():.3f} mm")

for issue in write_moved_step(part, result.T_base_part, moved_step):
    print("note:", issue.message)
