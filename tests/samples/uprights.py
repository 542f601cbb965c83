"""A sample weldment whose plates moved: four long uprights on a base plate, with its true motions and seams.

`python -m tests.samples.uprights FOLDER` writes it.
"""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box
from cad.samples.parts import DARK, STEEL, T_BASE_PART, TEACHING_SEED, TRUTH_SCHEMA
from cad.step.new_file import Member, new_step_text
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.records import to_json, write_file

BASE_MM = (600.0, 400.0, 10.0)
"""The plate of the simulation in issue 19: its top is at z = 0, its middle at the origin."""
THICK_MM, HEIGHT_MM = 8.0, 120.0
TACK = TackTolerance(1.0, 4.0)  #: How far the plates are off, as in that simulation.
SIGMA_MM = 0.2  #: Error of a touch per axis, as in that simulation.
ROUNDED_MM = 0.01  #: What a controller shows.
LOW_MM, INSET_MM = 20.0, 20.0
"""A touch is so far above the base, where the nozzle still fits, and so far from the ends of its plate."""


@dataclass(frozen=True, slots=True)
class Upright:
    """A plate on edge."""

    name: str
    centre_mm: tuple[float, float]  #: x and y of its middle.
    length_mm: float
    along_y: bool  #: Whether it is long along y, otherwise along x.
    side: int  #: The side that is touched: 1 towards larger y (or x), otherwise -1.

    @property
    def axes(self) -> FloatArray:
        """Unit vectors along the plate, outwards of the touched side, and up, shape (3, 3)."""
        x, y, z = np.eye(3)
        return np.stack([y, self.side * x, z] if self.along_y else [x, self.side * y, z])

    @property
    def centre(self) -> FloatArray:
        """Its centroid, mm."""
        return np.array([*self.centre_mm, HEIGHT_MM / 2.0])

    def at(self, along: float, out: float, height: float) -> FloatArray:
        """Return a point: `along` its length from the middle, `out` of its middle plane, above the base; mm."""
        return np.array([along, out, height - HEIGHT_MM / 2.0]) @ self.axes + self.centre

    def shape(self) -> Any:
        """Return the solid."""
        x, y, z = np.abs(np.array([self.length_mm, THICK_MM, HEIGHT_MM]) @ self.axes).tolist()
        return box(x, y, z, (self.centre_mm[0] - x / 2.0, self.centre_mm[1] - y / 2.0, 0.0))


UPRIGHTS = (
    Upright("U1", (0.0, -140.0), 480.0, False, -1),
    Upright("U2", (0.0, 140.0), 480.0, False, 1),
    Upright("U3", (-160.0, 0.0), 200.0, True, -1),
    Upright("U4", (100.0, 0.0), 200.0, True, 1),
)


@dataclass(frozen=True, slots=True, eq=False)
class PlannedTouches:
    """Touches on the faces of the model."""

    names: tuple[str, ...]
    #: `p`, `normal`: shape (n, 3). In `part`, mm.
    p: FloatArray
    normal: FloatArray
    body: IntArray  #: shape (n,).


def members() -> list[Member]:
    """Return the base and its uprights."""
    x, y, z = BASE_MM
    base = box(x, y, z, (-x / 2.0, -y / 2.0, -z))
    return [("base", base, STEEL), *((plate.name, plate.shape(), DARK) for plate in UPRIGHTS)]


def bodies() -> Bodies:
    """Return them as bodies that may move, with the tolerances from which their motions are drawn."""
    names = ("base", *(plate.name for plate in UPRIGHTS))
    centroids = np.stack([np.array([0.0, 0.0, -BASE_MM[2] / 2.0]), *(plate.centre for plate in UPRIGHTS)])
    return Bodies(names, centroids, (TACK,) * len(names))


def planned_touches(each: int) -> PlannedTouches:
    """Return six touches on the base, and so many on every upright.

    The first two lie low on the large face, near both ends: they say most about the seam. The third lies high on it,
    two on the top, and the sixth on an end.
    """
    x, y, z = (size / 2.0 for size in BASE_MM)
    far, low = (x - INSET_MM, y - INSET_MM), -z
    up, front, left = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (-1.0, 0.0, 0.0)
    rows: list[tuple[str, Any, Any, int]] = [
        ("base 1", (-far[0], -far[1], 0.0), up, 0),
        ("base 2", (far[0], -far[1], 0.0), up, 0),
        ("base 3", (0.0, far[1], 0.0), up, 0),
        ("base 4", (-far[0], -y, low), front, 0),
        ("base 5", (far[0], -y, low), front, 0),
        ("base 6", (-x, 0.0, low), left, 0),
    ]
    for body, plate in enumerate(UPRIGHTS, 1):
        end, face = plate.length_mm / 2.0, THICK_MM / 2.0
        along, out, above = plate.axes
        own = [
            (plate.at(INSET_MM - end, face, LOW_MM), out),
            (plate.at(end - INSET_MM, face, LOW_MM), out),
            (plate.at(0.0, face, HEIGHT_MM - INSET_MM), out),
            (plate.at(INSET_MM - end, 0.0, HEIGHT_MM), above),
            (plate.at(end - INSET_MM, 0.0, HEIGHT_MM), above),
            (plate.at(end, 0.0, HEIGHT_MM / 2.0), along),
        ]
        rows += [(f"{plate.name} {number}", p, n, body) for number, (p, n) in enumerate(own[:each], 1)]
    names, p, normal, body_of = zip(*rows, strict=True)
    return PlannedTouches(names, np.array(p), np.array(normal), np.array(body_of))


def true_motions(rng: np.random.Generator) -> Motions:
    """Draw where the plates are: each off by `TACK`; the part is where all samples are."""
    own = bodies()
    u = rng.standard_normal((len(own), 6)) * own.scales
    return Motions(own, T_BASE_PART, u[:, :3], u[:, 3:])


def true_seams(motions: Motions) -> list[dict[str, Any]]:
    """Return where each upright meets the base, in `base`: its ends are corners of three moved planes, mm."""
    R, t = motions.moves()
    found: list[dict[str, Any]] = []
    for body, plate in enumerate(UPRIGHTS, 1):
        along, out, up = plate.axes
        for side in (1.0, -1.0):
            ends = []
            for end in (-1.0, 1.0):
                foot = R[body] @ plate.at(end * plate.length_mm / 2.0, side * THICK_MM / 2.0, 0.0) + t[body]
                planes = np.stack([R[body] @ along, R[body] @ out, R[0] @ up])
                heights = [planes[0] @ foot, planes[1] @ foot, planes[2] @ t[0]]
                ends.append(motions.T_base_part.apply(np.linalg.solve(planes, heights)).tolist())
            found.append({"solids": [plate.name, "base"], "ends_base_mm": ends})
    return found


def touched(planned: PlannedTouches, motions: Motions, error_mm: FloatArray | float) -> FloatArray:
    """Return where the robot touches the real part, in `base`, shape (n, 3), mm."""
    R, t = motions.poses_of(planned.body)
    return np.asarray(np.einsum("nij,nj->ni", R, planned.p) + t + error_mm)


def write_uprights(folder: Path) -> None:
    """Write the STEP file, its bodies, three tables of touches and the truth; files that exist are replaced."""
    folder.mkdir(parents=True, exist_ok=True)
    with kernel_call("making uprights"):
        step = new_step_text(members(), "uprights")
    rng = np.random.default_rng(TEACHING_SEED)
    motions = true_motions(rng)
    six, two = planned_touches(6), planned_touches(2)
    error = SIGMA_MM * rng.standard_normal(six.p.shape)
    is_of_two = np.isin(six.names, two.names)
    record = {
        "schema": "wpcal/bodies/1",
        "bodies": [{"name": name, "tack_mm": TACK.mm, "tack_mrad": TACK.mrad} for name in motions.bodies.names],
    }
    files: dict[str, str | bytes] = {
        "uprights.step": step,
        "bodies.json": to_json(record),
        "taught.csv": _table(two, touched(two, motions, error[is_of_two]), digits=2),
        "taught_six.csv": _table(six, touched(six, motions, error), digits=2),
        "taught_exact.csv": _table(six, touched(six, motions, 0.0), digits=9),
        "truth.json": to_json(_truth(motions)),
    }
    for name, text in files.items():
        write_file(folder / name, text, overwrite=True)


def _truth(motions: Motions) -> dict[str, Any]:
    own = motions.bodies
    return {
        "schema": TRUTH_SCHEMA,
        "about": "four long uprights on a base plate; all plates moved",
        "T_base_part": motions.T_base_part.matrix.tolist(),
        "teaching_sigma_mm": SIGMA_MM,
        "teaching_seed": TEACHING_SEED,
        "teaching_rounded_to_mm": ROUNDED_MM,
        "bodies": [
            {
                "name": name,
                "centre_part_mm": own.centroid_part[b].tolist(),
                "moved_mm": motions.v_mm[b].tolist(),
                "turned_mrad": (1e3 * motions.omega[b]).tolist(),
            }
            for b, name in enumerate(own.names)
        ],
        "seams": true_seams(motions),
    }


def _table(planned: PlannedTouches, p_base: FloatArray, *, digits: int) -> str:
    head = "name,kind,x_mm,y_mm,z_mm,model_x_mm,model_y_mm,model_z_mm"
    rows = [
        f"{name},plane,{','.join(f'{v:.{digits}f}' for v in p)},{','.join(f'{v:g}' for v in model)}"
        for name, p, model in zip(planned.names, p_base.tolist(), planned.p.tolist(), strict=True)
    ]
    return "\n".join([head, *rows, ""])


if __name__ == "__main__":
    write_uprights(Path(sys.argv[1]))
