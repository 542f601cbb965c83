"""What touches chosen for moved bodies gain, and whether their predicted error holds, where weldments are simulated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tests.weldments import Weldment
from tests.weldments_of_parts import (
    SIGMA_MM,
    PartWeldment,
    face_candidates,
    on_faces,
    part_weldment,
    simulated,
    uprights_weldment,
)
from wpcal.calibrate.errors.of_bodies import MeetingPoints
from wpcal.calibrate.observe.bodies import Bodies
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.observe.targets import GraphTargets
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.touch.design import farthest_rows
from wpcal.touch.weldment import MovedModel, MovedSearch, SeamPoints, Tacked, deciding_points, inverse

PARTS = Path(__file__).parents[2] / "fixtures" / "welds" / "parts"
SHARED = Path(__file__).parents[3] / "shared"
BENCHED = {
    "uprights": None,
    "drawbar": PARTS / "drawbar.step",
    "box_sides": SHARED / "step" / "box_sides.STEP",
    "boom and vane": SHARED / "blind" / "afpm_boom_vane.step",
}
ON_BASE, EACH = 6, 2
PER_BODY = 30  #: Places on each body that may be touched, far from one another.


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Places on the faces of a part that may be touched."""

    #: `face`, `body`: shape (n,).
    face: IntArray
    body: IntArray
    #: `p`, `n`: shape (n, 3). Points and outward normals, in `part`, mm.
    p: FloatArray
    n: FloatArray


@dataclass(frozen=True, slots=True)
class Compared:
    """Touches of one choice, simulated."""

    #: `worst_mm`, `across_mm`: Error of the worst seam point and of the same across the seam, median over the
    #: weldments.
    worst_mm: float
    across_mm: float
    predicted_mm: float  #: Largest predicted 95 % error of a point.
    covered: float  #: Share of the points that are within the error predicted for them.


def opened(name: str) -> PartWeldment:
    """Open a part with the touches of the hand rule."""
    path = BENCHED[name]
    return uprights_weldment(EACH) if path is None else part_weldment(path, each=EACH)


def compared(part: PartWeldment, runs: int) -> dict[str, Compared]:
    """Compare the hand rule, a choice for a part that is one body, and one for moved bodies: as many touches each."""
    weldment = part.weldment
    places, seams = _places(part), _seam_points(part)
    tacked = Tacked(weldment.bodies, part.seams.graph.face_solid, seams)
    count = len(weldment.p)
    as_one = replace(tacked.model(), bodies=Bodies((), np.zeros((0, 3)), ()))
    still = replace(places, body=np.full(len(places.body), -1))
    none = replace(seams, points=replace_bodies(seams.points))
    choices = {
        "two on each plate": weldment,
        "chosen as one body": _with(part, places, _chosen(as_one, still, none, count)),
        "chosen for bodies": _with(part, places, _chosen(tacked.model(), places, seams, count)),
    }
    found = {}
    for name, own in choices.items():
        predicted = _predicted(tacked, own.p, own.n, own.body)
        fits = [fit for (fit,) in simulated(replace(part, weldment=own), np.random.default_rng(7), runs, (1.0,))]
        worst, across = (np.median([getattr(fit, key).max() for fit in fits]) for key in ("off_mm", "across_mm"))
        covered = np.mean([fit.off_mm <= predicted for fit in fits])
        found[name] = Compared(float(worst), float(across), float(predicted.max()), float(covered))
    return found


def replace_bodies(points: MeetingPoints) -> MeetingPoints:
    """Return the points as of a part that is one body."""
    none = np.full(len(points.wall_body), -1)
    return replace(points, wall_body=none, base_body=none)


def _places(part: PartWeldment) -> Places:
    targets = part.weldment.targets
    assert isinstance(targets, GraphTargets)
    found = []
    for b in range(len(part.weldment.bodies)):
        face, p, n = face_candidates(targets.trimmed, np.flatnonzero(part.seams.graph.face_solid == b))
        size = float(np.ptp(p, axis=0).max())
        some = farthest_rows(np.concatenate([p, size * n], axis=1), PER_BODY)
        found.append((face[some], np.full(len(some), b), p[some], n[some]))
    return Places(*(np.concatenate([each[k] for each in found]) for k in range(4)))


def _seam_points(part: PartWeldment) -> SeamPoints:
    T = RigidTransform.identity(target="base", source="part")
    moved = part.met(Motions.rigid(part.weldment.bodies, T))
    points = [
        MeetingPoints(s.seam.frames.p, s.wall_body, s.base_body, s.n_wall, s.n_base, s.x_wall, s.is_met) for s in moved
    ]
    return SeamPoints(
        MeetingPoints.joined(points), tuple(s.seam.name for s in moved for _ in range(len(s.seam.frames)))
    )


def _chosen(model: MovedModel, places: Places, seams: SeamPoints, count: int) -> list[int]:
    rows = model.rows(places.p, places.n[:, None, :] / SIGMA_MM, places.body)
    start = model.prior()
    deciding = model.seam_rows(seams.points.select(deciding_points(seams.points)))
    return MovedSearch.with_floor(rows, deciding, start).chosen(start, count)


def _with(part: PartWeldment, places: Places, rows: Sequence[int]) -> Weldment:
    targets, k = part.weldment.targets, list(rows)
    assert isinstance(targets, GraphTargets)
    own = on_faces(targets.trimmed, places.face[k])
    return replace(part.weldment, p=places.p[k], n=places.n[k], body=places.body[k], targets=own)


def _predicted(tacked: Tacked, p: FloatArray, n: FloatArray, body: IntArray) -> FloatArray:
    model = tacked.model()
    search = MovedSearch(model.rows(p, n[:, None, :] / SIGMA_MM, body), model.seam_rows(tacked.seams.points))
    return search.errors(inverse(model.prior() + search.information(range(len(p)))))


RUNS = 120


def main() -> None:
    """Print the table."""
    for name, path in BENCHED.items():
        if path is None or path.exists():
            for choice, one in compared(opened(name), RUNS).items():
                print(
                    f"{name}, {choice}: worst {one.worst_mm:.2f} mm, across {one.across_mm:.2f} mm; predicted 95 % "
                    f"{one.predicted_mm:.2f} mm, covers {100 * one.covered:.1f} %"
                )
