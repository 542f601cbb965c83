"""A part that is not where it is planned: the torch still passes it in the air, and every touch of eight is tested."""

import numpy as np
import pytest

from tests.few import few
from tests.touch_parts import touch_part
from wpcal.brep.material import ExactMaterial
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.tangent import exp_rotation
from wpcal.touch.plan import NominalError, TouchOptions, plan_touches
from wpcal.touch.plan.displaced import DisplacedPart, poses_between
from wpcal.touch.plan.free import torch_keeps_away
from wpcal.touch.searches import TouchPlan

NOMINAL = NominalError(1.0, np.radians(0.6))


def ways(plan: TouchPlan) -> tuple[FloatArray, FloatArray]:
    """Poses between the searches, 1 mm apart; the torch turns in the middle of a way over the part."""
    p, R = [], []
    for a, b in zip(plan.searches, plan.searches[1:], strict=False):
        first = len(b.via) // 2
        points = np.stack([a.retract, *b.via, b.approach])
        axes = np.stack([a.R_part_tool] * (1 + first) + [b.R_part_tool] * (len(b.via) - first + 1))
        places, turned = poses_between(points, axes, 1.0, np.radians(2.0))
        p.append(places), R.append(turned)
    return np.concatenate(p), np.concatenate(R)


def test_a_way_beside_a_long_part_is_refused_if_the_part_may_turn() -> None:
    part = touch_part("frame")  # 600 mm long; its front rail stands at y = 0
    material = ExactMaterial(part.graph, part.trimmed)
    p = np.array([[20.0, -12.0, 25.0], [580.0, -12.0, 25.0]])
    down = np.tile(np.diag([1.0, -1.0, -1.0]), (2, 1, 1))
    centre = np.array([300.0, 200.0, 20.0])
    torch, wire_mm = TouchOptions().torch, 1.2
    for sigma_deg, passes in ((0.0, True), (0.3, True), (1.5, False)):
        displaced = DisplacedPart.of(material, centre, NominalError(0.0, np.radians(sigma_deg)))
        assert displaced.lets_pass(torch, wire_mm, p, down) is passes


def test_the_torch_passes_a_displaced_part() -> None:
    part = touch_part("saddle")
    options = TouchOptions(nominal=NOMINAL)
    plan = plan_touches(part, options=options)
    material = ExactMaterial(part.graph, part.trimmed)
    low, high = part.trimmed.face_box
    centre = (low.min(axis=0) + high.max(axis=0)) / 2.0
    tips, axes = ways(plan)
    rng = np.random.default_rng(7)
    for _ in range(6):
        d = rng.standard_normal(6)
        d *= 2.3 / np.linalg.norm(d)
        R, t = exp_rotation(d[:3] * NOMINAL.sigma_rad), d[3:] * NOMINAL.sigma_mm
        p = centre + (tips - centre - t) @ R
        A = R.T @ axes
        free = torch_keeps_away([material], options.torch, p, A, np.zeros(len(p)), wire_mm=options.wire_mm)
        assert free.all()


@pytest.mark.parametrize("name", few(["saddle", "tee", "lap"], 1))
def test_of_eight_touches_a_wrong_one_leaves_a_residual(name: str) -> None:
    plan = plan_touches(touch_part(name), options=TouchOptions(touches=8))
    p = np.stack([search.contact_part for search in plan.searches])
    n = np.stack([search.normal_part for search in plan.searches])
    rows = np.concatenate([np.cross(p - p.mean(axis=0), n) / 100.0, n], axis=1)
    kept = 1.0 - np.einsum("ni,ij,nj->n", rows, np.linalg.inv(rows.T @ rows), rows)
    assert kept.min() >= 0.01


def test_a_part_that_no_search_can_start_at_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(DisplacedPart, "lets_start", lambda _, strokes, *__: np.zeros(len(strokes), dtype=bool))
    with pytest.raises(GeometryError, match=r"at the start of every search .* --uncertainty-mm"):
        plan_touches(touch_part("tee"), options=TouchOptions())
