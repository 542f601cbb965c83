"""The calibrator without CAD: the same points in model coordinates and as touched, mm."""

import wpcal

p_part = [[0, 0, 0], [400, 0, 0], [400, 300, 0], [0, 300, 0], [200, 150, 80]]
p_base = [[1000.1, 200, 50], [1399.9, 200.1, 50], [1400, 500, 50.1], [1000, 500.1, 49.9], [1200, 350, 130]]
nominal = wpcal.RigidTransform.from_six_tuple([1000, 200, 50, 0, 0, 0], target="nominal", source="part")
try:
    pairs = wpcal.PointPairs(("A", "B", "C", "D", "E"), p_part, p_base)
    result = wpcal.calibrate_points(pairs, criterion=wpcal.Criterion.MINIMAX, T_nominal_part=nominal)
except wpcal.WpcalError as error:
    raise SystemExit(f"{error.code}: {error}") from None
print("the model's origin in base:", result.T_base_part.t_mm.round(3).tolist(), "mm")
print("correction of the cell's model:", result.T_base_nominal.six_tuple)
print(f"{result.verdict}: {result.largest_mm:.3f} mm at {result.worst}; no fit is below {result.lower_bound_mm:.3f} mm")
print(f"its error is below {result.predict_error_mm([[0, 0, 0]])[0]:.3f} mm with 95 % probability")
