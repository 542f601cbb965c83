"""Laws of touches on curved faces of bodies that moved: what their tangents leave out."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.weldments import Weldment, uprights
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.observe.touches import Nearest, Touches
from wpcal.calibrate.solve.bodies_problem import Problem
from wpcal.calibrate.solve.curved import BOTH, on_curved_faces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform

SIGMA_MM, TACK_MM = 0.2, 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Hole:
    """The wall of a hole along z, through the origin."""

    radius_mm: float

    def nearest(self, rows: IntArray, points: FloatArray) -> Nearest:
        """As `TouchTargets.nearest`; `rows` has the shape (k,), `points` (k, 3)."""
        out = points * [1.0, 1.0, 0.0]
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        p = self.radius_mm * out + points * [0.0, 0.0, 1.0]
        return Nearest(p, -out, out[:, :, None] * out[:, None, :])


class HalfHole(Hole):
    """A hole whose wall goes on as a plane where y is negative."""

    def nearest(self, rows: IntArray, points: FloatArray) -> Nearest:
        """As `Hole.nearest`."""
        round_, out = Hole.nearest(self, rows, points), np.array([1.0, 0.0, 0.0])
        plane, way = points[:, 1] < 0.0, np.outer(out, out)
        p = np.where(plane[:, None], points * [0.0, 1.0, 1.0] + self.radius_mm * out, round_.p)
        normal = np.where(plane[:, None], -out, round_.normal)
        return Nearest(p, normal, np.where(plane[:, None, None], way, round_.projector))


def problem_of(part: Weldment, touches: Touches) -> Problem:
    touches = replace(touches, covariances=np.tile(SIGMA_MM**2 * np.eye(3), (len(touches), 1, 1)))
    return Problem.of(touches, part.body, part.bodies, KeptContacts.none())


def added(part: Weldment) -> FloatArray:
    """Return what the variance of each touch grows by."""
    still = Motions.rigid(part.bodies, RigidTransform.identity(target="base", source="part"))
    problem = problem_of(part, part.touched(still, 0.0, np.random.default_rng(0)))
    curved = on_curved_faces(problem, problem.state(still, problem.first))
    return curved.own[:, 0, 0] - problem.own[:, 0, 0]


def test_touches_on_planes_keep_their_errors() -> None:
    assert (added(uprights(6)) == 0.0).all()


def in_hole(hole: Hole) -> float:
    """Return what the variance of a touch on the wall grows by, at y = 0."""
    radius_mm = hole.radius_mm
    bodies = Bodies(("plate",), np.array([[radius_mm, 0.0, 0.0]]), (TackTolerance(TACK_MM, 1e-3),))
    p, n = np.array([[radius_mm, 0.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    return float(added(Weldment(bodies, p, n, np.zeros(1, dtype=np.int64), hole))[0])  # type: ignore[arg-type]


def test_a_wall_that_is_round_on_one_side_counts_half() -> None:
    assert in_hole(HalfHole(1.0)) == pytest.approx(in_hole(Hole(1.0)) / 2)


@pytest.mark.parametrize("radius_mm", [3.0, 10.0])
def test_a_touch_in_a_hole_is_less_sure_by_the_bow_of_its_wall(radius_mm: float) -> None:
    """The second moment of τ² / 2 ρ is 3 s⁴ / 4 ρ², with s the motion along the wall."""
    expected = 3.0 * BOTH**2 * TACK_MM**4 / (4.0 * radius_mm**2)
    found = in_hole(Hole(radius_mm))
    if expected < 0.02 * SIGMA_MM**2:
        assert found == 0.0
    else:
        assert found == pytest.approx(expected, rel=0.2)
