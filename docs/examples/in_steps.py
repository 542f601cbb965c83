"""The main job step by step, from files. Each step takes and returns plain values.

Usage: python in_steps.py PART.step TAUGHT.csv MOVED.step
"""

import sys
from pathlib import Path

import cad
import wpcal

part_step, taught_csv, moved_step = (Path(argument) for argument in sys.argv[1:])

part = cad.read_step(part_step)
for issue in part.issues:
    print("note:", issue.message)

graph = cad.to_brep((solid.name, solid.shape) for solid in part.solids)
features = wpcal.find_features(graph)
pairs, check = wpcal.pair_points(wpcal.read_taught(taught_csv), features)

result = wpcal.calibrate_points(pairs, check=check)
print(f"{result.verdict}: largest residual {result.residuals.largest_mm:.3f} mm at {result.residuals.worst}")
print(f"no rigid fit has a largest residual below {result.lower_bound_mm:.3f} mm")

seams = wpcal.detect_seams(graph, wpcal.SeamOptions(steps=wpcal.StepOptions(chord_mm=0.05)))
for seam in seams:
    frames = seam.frames.moved(result.T_base_part)
    u95 = result.predict_error_mm(seam.frames.p)
    print(f"{seam.name}: {seam.joint.value} {len(frames)} frames, 95 % error at most {u95.max():.3f} mm")

for issue in cad.write_moved_step(part, result.T_base_part, moved_step):
    print("note:", issue.message)
