"""Every value of fits, of what they are worth and of what was found wrong: points, touches, bodies, corrections."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep.graph import CurveKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate import Criterion, Solver, TeachingError, calibrate
from wpcal.calibrate.errors.prediction import ToolError
from wpcal.calibrate.errors.robot_field import FieldOrigin, RobotField
from wpcal.calibrate.observe.targets import GraphTargets, TargetKind
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.trust.silent import SilentSearches
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import RobotSpace
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

BODY = np.array(
    [[3, 5, 7], [611, 11, -13], [590, 402, 9], [17, 391, 61], [293, 207, 311], [431, 97, 158], [88, 333, 240.0]]
)
SEAMS = np.array([[100.0, 20, 30], [520, 340, 70], [700, -90, 41]])
R = exp_rotation([0.31, -1.17, 0.43])
PLACE = RigidTransform(R, np.array([1013.0, -207, 331]), "base", "part")
WRONG = np.array([0.6, -0.5, 0.62])
FIELD = RobotField(0.21, 430.0, FieldOrigin.STATED, 0.04)
SEAM: dict[str, Any] = {"seam_points": SEAMS, "seam_names": ["W1", "W2", "W2"]}
BODIES = {f"P{k}": "ab"[k % 2] for k in range(7)}


def noise(seed: int, shape: tuple[int, ...] = BODY.shape) -> Any:
    return 0.21 * np.random.default_rng(seed).normal(size=shape)


def points(
    seed: int,
    n: int = 7,
    *,
    own: bool = False,
    wrong: float = 0.0,
    scale: float = 1.0,
    order: Any = None,
    tip: Any = 0.0,
) -> PointPairs:
    """Taught points: with errors of their own, one wrong, of a warm part, in another order, or with a worn tool."""
    rng = np.random.default_rng(seed + 90)
    p = BODY[:n] if n <= 7 else rng.uniform(0.0, 600.0, (n, 3))
    q = scale * p @ R.T + PLACE.t_mm + noise(seed, p.shape) - tip
    q[n // 2] += wrong * WRONG
    A = noise(seed + 50, (n, 3, 3)) + 0.15 * np.eye(3)
    rows = np.arange(n) if order is None else np.array(order)
    return PointPairs(tuple(f"P{k}" for k in range(n)), p, q[rows], A @ A.swapaxes(1, 2) if own else None)


def postures(seed: int) -> dict[str, Any]:
    return {f"P{k}": exp_rotation(3.0 * turn) @ exp_rotation([2.9, 0.3, -0.2]) for k, turn in enumerate(noise(seed))}


def teaching(**known: Any) -> dict[str, Any]:
    return {"teaching": TeachingError(**known)}


def fit(observed: PointPairs | Touches, **options: Any) -> list[Any]:
    found = calibrate(observed, **options)
    return [found, found.to_record(), found.predict_error_mm(SEAMS), found.budget.covariances(SEAMS)]


POINTS: dict[str, Any] = {
    "plain": (points(1), SEAM),
    "bound": (points(3), {"criterion": Criterion.MINIMAX, **teaching(bound_mm=0.6)}),
    "own": (points(4, own=True), {"check": points(5, 3), **SEAM}),
    "robust": (points(6, wrong=6.3), {"criterion": Criterion.ROBUST, "features": {"H": BODY[3] + 4, "K": BODY[1] - 3}}),
    "neighbour": (points(6, wrong=6.3), {"features": {"H": BODY[3] + R.T @ WRONG * 6.2}, **teaching(sigma_mm=0.2)}),
    "bodies": (points(7, wrong=3.1), {"body_of": BODIES, **teaching(sigma_mm=0.2)}),
    "field": (points(8), {"postures": postures(8), **teaching(sigma_mm=0.25, tcp_bias_mm=0.3, robot=FIELD)}),
    "tool": (
        points(9, tip=np.array([each @ [1.1, -1.7, 0.9] for each in postures(9).values()])),
        {"postures": postures(9), **teaching(tool=ToolError(0.3, 0.7), sigma_mm=0.2)},
    ),
    "warm": (points(10, scale=1.004), teaching(sigma_mm=0.2)),
    "slips": (points(12, own=True, order=[3, 1, 2, 0, 4, 5, 6]), {"criterion": Criterion.WEIGHTED}),
    "many": (points(13, 45, wrong=5.1), {"criterion": Criterion.ROBUST, **SEAM}),
    "wrong check": (points(14, 5), {"check": points(15, 7, wrong=8.0).select([3, 6]), "tolerance_mm": 2.0}),
}
TRIMMED = {name: TrimmedFaces.of(saved_graph(name)) for name in ("drilled", "saddle-60")}


def touches(seed: int, kinds: str = "FFEP", *, part: str = "drilled", own: bool = False, wrong: float = 0.0) -> Touches:
    """Touches near vertices of each face (F), of each edge (E), and at some vertices (P), with their errors."""
    graph, rng = TRIMMED[part].graph, np.random.default_rng(seed)
    kind, index, at = [], [], np.zeros((0, 3))
    for row, what in enumerate(kinds):
        curves = np.flatnonzero(graph.edge_kind != CurveKind.DEGENERATE).tolist()
        for k in {"F": range(len(graph.face_kind)), "E": curves, "P": range(3)}[what]:
            edges = graph.coedge_edge[graph.coedge_face == k] if what == "F" else np.array([k])
            ends = graph.vertex_p[graph.edge_vertices[edges].ravel() if what != "P" else [k]]
            share = rng.uniform(0.5, 1.5 + row, len(ends))
            kind.append({"P": TargetKind.POINT, "F": TargetKind.FACE, "E": TargetKind.EDGE}[what])
            index.append(-1 if what == "P" else k)
            at = np.concatenate([at, share[None] @ ends / share.sum()])
    of, rows = np.array(kind), np.arange(len(at))
    targets = GraphTargets(TRIMMED[part], of, np.array(index), np.where(of[:, None] == TargetKind.POINT, at, np.nan))
    foot, radius = targets.nearest(rows, at), np.where(of == TargetKind.FACE, 0.7, 0.0)
    q = PLACE.apply(foot.p + radius[:, None] * foot.normal) + noise(seed, at.shape)
    q[1] += wrong * WRONG
    A = noise(seed + 9, (len(at), 3, 3)) + 0.12 * np.eye(3)
    names, words = (tuple(f"{word}{k}" for k in rows) for word in ("T", "target "))
    return Touches(names, q, radius, targets, words, A @ A.swapaxes(1, 2) if own else None, RobotSpace.NOMINAL, rows)


def silent(seed: int) -> SilentSearches:
    """Strokes through faces: some should have met them, some began in contact."""
    ends = touches(seed, "F")
    normal = ends.targets.nearest(ends.rows, (ends.p_base - PLACE.t_mm) @ R).normal @ R.T
    is_odd = np.arange(len(ends)) % 2 == 1
    return SilentSearches(replace(ends, p_base=ends.p_base - 9.0 * normal), ends.p_base + 14.0 * normal, is_odd)


TOUCHES: dict[str, Any] = {
    "plain": (touches(21), SEAM),
    "faces": (touches(2, "FFP"), {"solver": Solver.EXACT, "silent": silent(3), "check": touches(4, "P")}),
    "own": (touches(5, own=True), teaching(robot=FIELD)),
    "wrong": (touches(6, wrong=4.4), teaching(sigma_mm=0.3)),
    "robust": (touches(7, "FFP", wrong=7.7), {"criterion": Criterion.ROBUST}),
    "edges": (touches(8, "EP", part="saddle-60"), {"solver": Solver.EXACT}),
}


JOBS = {f"points-{name}": partial(fit, each, **options) for name, (each, options) in POINTS.items()}
JOBS |= {f"touches-{name}": partial(fit, each, **options) for name, (each, options) in TOUCHES.items()}


@pytest.mark.parametrize("job", JOBS.values(), ids=JOBS)
def test_values(job: Callable[[], Any], golden: Any) -> None:
    golden(job())
