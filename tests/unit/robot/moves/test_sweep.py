"""Places of a swept check: no point of the torch moves farther than a step, and a turn on the spot is seen."""

import numpy as np

from wpcal.core.tangent import exp_rotation
from wpcal.robot.moves import sweep
from wpcal.robot.moves.sweep import BODY_STEP_MM, STEP_MM
from wpcal.robot.torch.file import shipped_torches


def test_no_point_of_a_torch_moves_farther_than_a_step():
    rng = np.random.default_rng(3)
    p = np.cumsum(rng.normal(scale=2.0, size=(9, 3)), axis=0)
    R = np.stack([exp_rotation(rng.normal(scale=0.4, size=3)) for _ in p])
    for torch in (shipped.shape for shipped in shipped_torches()):
        found = sweep([(p, R)], torch.reaching, axis=2)
        np.testing.assert_allclose(found.R[np.isin(found.at, range(9))], R, rtol=0, atol=1e-12)
        corners = [[x, y, -torch.wire_mm - z] for tube in torch.tubes for x, y, z in (tube.start, tube.end)]
        for points, step in (([[0, 0, 0], [0, 0, -torch.wire_mm]], STEP_MM), (corners, BODY_STEP_MM)):
            for point in np.array(points, dtype=float):
                moved = np.linalg.norm(np.diff(found.p + found.R @ point, axis=0), axis=1)
                assert moved.max() <= step + 1e-9


def test_a_swing_of_40_degrees_in_a_millimetre_is_divided():
    swing = np.stack([exp_rotation(np.array([np.radians(angle), 0.0, 0.0])) for angle in (-20.0, 20.0)])
    torch = shipped_torches()[0].shape
    found = sweep([(np.array([[0.0, 0, 0], [1.0, 0, 0]]), swing)], torch.reaching, axis=2)
    assert len(found.at) > np.radians(40.0) * torch.length_mm / BODY_STEP_MM
