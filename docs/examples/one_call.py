"""The main job in one call, with build123d shapes: a part and touched points in, the moved part and its seams out."""

from build123d import Box, Pos

from cad.workpiece.calibrate import calibrate_workpiece
from cad.workpiece.workpiece import open_workpiece
from wpcal.core import RigidTransform
from wpcal.features import feature_named
from wpcal.taught.table import TaughtPoints

# A web upright on a plate, as a script models it. A label becomes the name of the solid.
plate = Pos(100, 60, 5) * Box(200, 120, 10)
plate.label = "plate"
web = Pos(100, 60, 50) * Box(150, 8, 80)
web.label = "web"

# What can be taught, by the names that `wpcal features` shows.
features = open_workpiece([plate, web]).features
names = ["V2", "V4", "V16", "V12"]
model = [feature_named(features, name).p_mm for name in names]

# Here the robot would tell the touched coordinates; the example moves the model's points.
T_base_part = RigidTransform.from_six_tuple([900, 100, 50, 0.0, 0.0, 0.3], target="base", source="part")
touched = TaughtPoints.of_features(names, T_base_part.apply(model))

found = calibrate_workpiece([plate, web], touched)
print(f"{found.result.verdict}: largest residual {found.result.residuals.largest_mm:.6f} mm")
for seam in found.seams:
    start = found.T_base_part.apply(seam.frames.p[0])
    print(f"{seam.name}: {seam.joint.value}, {seam.length_mm:.1f} mm, starts at {start.round(3).tolist()} in base")
moved_plate, moved_web = found.moved_shapes()
print(f"the moved plate's centre: {moved_plate.center()}")
