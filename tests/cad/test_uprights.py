"""The sample weldment whose plates moved, against the truth that was calculated without wpcal's seams.

Deep: `laws/test_moved_bodies` recovers moved bodies at each push.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.workpiece.bodies import BodiesOptions, read_bodies
from cad.workpiece.calibrate import WorkpieceCalibration, calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.calibrate import TeachingError
from wpcal.core.arrays import FloatArray
from wpcal.core.records import read_json
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

FOLDER = Path(__file__).parents[2] / "fixtures" / "uprights"
EXACT_MM = 1e-6  #: Asked of touches without errors; they are written with 1e-9 mm.
SURE_SIGMA_MM = 1e-4  #: With so small an error the tack tolerances pull the plates back by 1e-8 of their motion.

pytestmark = pytest.mark.deep


@pytest.fixture(scope="module")
def found() -> WorkpieceCalibration:
    options = CalibrateOptions(
        teaching=TeachingError(sigma_mm=SURE_SIGMA_MM),
        bodies=BodiesOptions(is_stated=True, groups=read_bodies(FOLDER / "bodies.json")),
    )
    return calibrate_workpiece(FOLDER / "uprights.step", FOLDER / "taught_exact.csv", options=options)


@pytest.fixture(scope="module")
def truth() -> dict[str, Any]:
    return read_json(FOLDER / "truth.json", schema="wpcal/truth/1")


def test_bodies_are_where_the_truth_has_them(found: WorkpieceCalibration, truth: dict[str, Any]) -> None:
    motions = found.moved.bodies.fit.motions
    T = RigidTransform.from_matrix(truth["T_base_part"], target="base", source="part")
    R, t = motions.poses()
    for b, body in enumerate(truth["bodies"]):
        assert motions.bodies.names[b] == body["name"]
        c = np.array(body["centre_part_mm"])
        assert np.allclose(motions.bodies.centroid_part[b], c, rtol=0, atol=EXACT_MM)
        corners = c + 250.0 * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]])
        turn = exp_rotation(1e-3 * np.array(body["turned_mrad"]))
        true = T.apply((corners - c) @ turn.T + c + body["moved_mm"])
        assert np.abs(corners @ R[b].T + t[b] - true).max() < EXACT_MM


def test_seams_are_where_the_moved_plates_really_meet(found: WorkpieceCalibration, truth: dict[str, Any]) -> None:
    lines = [(set(line["solids"]), np.array(line["ends_base_mm"])) for line in truth["seams"]]
    reached = np.zeros((len(lines), 2), dtype=bool)
    for seam in (seam for seam in found.seams if seam.accepted):
        p = found.T_base_part.apply(seam.frames.p)
        off = [_off(p, ends) if solids == set(seam.solids) else np.inf for solids, ends in lines]
        nearest = int(np.argmin(off))
        assert off[nearest] < EXACT_MM, seam.name
        ends = lines[nearest][1]
        reached[nearest] |= np.linalg.norm(ends[:, None] - p, axis=2).min(axis=1) < EXACT_MM
    assert reached.all(), "a seam does not follow the end of its plate"


def _off(p: FloatArray, ends: FloatArray) -> float:
    """Largest distance of points from a line, and beyond its ends."""
    way = ends[1] - ends[0]
    share = np.clip((p - ends[0]) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(p - ends[0] - share[:, None] * way, axis=1).max())
