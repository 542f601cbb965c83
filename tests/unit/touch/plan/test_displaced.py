"""A part that is not where it is planned: the torch still passes it in the air, and every touch of eight is tested."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from tests.few import few
from tests.touch_parts import touch_part
from tests.touch_plans import tee_plan
from wpcal.brep.material import ExactMaterial
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.tangent import exp_rotation
from wpcal.robot.moves.sweep import poses_between
from wpcal.robot.torch.shape import TorchShape
from wpcal.touch.plan import NominalError, TouchOptions, plan_touches
from wpcal.touch.plan.displaced import DisplacedPart
from wpcal.touch.plan.free import torch_keeps_away
from wpcal.touch.searches import TouchPlan

NOMINAL = NominalError(1.0, np.radians(0.6))


def ways(plan: TouchPlan) -> tuple[FloatArray, FloatArray]:
    """Poses of the tip between the searches, 1 mm apart, as programs state the tool centre point."""
    p, R = [], []
    steps = TouchProgram(plan).steps(plan.T_base_part)
    for a, b in pairwise(steps):
        points, axes = np.stack([a.p[-1], *b.p[:-3]]), np.stack([a.R[-1], *b.R[:-3]])
        places, turned, _ = poses_between(points, axes, 1.0, np.radians(2.0))
        p.append(places + plan.standoff_mm * turned[:, :, 2]), R.append(turned)
    return np.concatenate(p), np.concatenate(R)


def test_the_tip_goes_on_an_arc_where_the_tool_turns() -> None:
    tips = np.array([[0.0, 0.0, -100.0], [100.0, 0.0, 0.0]])  # about a tool centre point at the origin
    R = np.array([np.diag([1.0, -1.0, -1.0]), [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]])
    at, *_ = poses_between(tips, R, 1.0, np.radians(2.0), 100.0)
    np.testing.assert_allclose(np.linalg.norm(at, axis=1), 100.0)


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


def test_the_tool_turns_over_the_part_and_not_on_the_rise(golden: Any) -> None:
    plan = replace(tee_plan(), standoff_mm=15.0)
    a, b = plan.searches[:2]
    tips = np.array([a.retract, b.approach]) + np.array([0.0, 0.0, 50.0])
    b = replace(b, R_part_tool=exp_rotation(np.array([0.0, 0.5, 0.0])) @ b.R_part_tool, via=tips)
    steps = TouchProgram(replace(plan, searches=(a, b))).steps(plan.T_base_part)[1]
    np.testing.assert_allclose(steps.R, [a.R_part_tool, *[b.R_part_tool] * 5], rtol=0, atol=1e-12)
    np.testing.assert_allclose((steps.p + 15.0 * steps.R[:, :, 2])[:2], tips, rtol=0, atol=1e-9)
    golden(steps)


@pytest.mark.parametrize("standoff_mm", few([200.0, 0.0], 1))
def test_the_torch_passes_a_displaced_part(standoff_mm: float) -> None:
    part = touch_part("saddle")
    options = TouchOptions(nominal=NOMINAL, standoff_mm=standoff_mm)
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


def test_a_tool_centre_point_behind_the_torch_is_one_line() -> None:
    part, long = touch_part("tee"), TorchShape(length_mm=500.0)
    with pytest.raises(InputError, match="the standoff: expected 0 to 300 mm, where the torch ends, got 400 mm"):
        plan_touches(part, options=TouchOptions(standoff_mm=400.0))
    assert plan_touches(part, options=replace(TouchOptions(standoff_mm=400.0), torch=long)).standoff_mm == 400.0
