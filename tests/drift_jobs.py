"""Jobs of one part with planted changes, as arrays and as folders of `wpcal batch`."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.study.drift import PartJobs

AT_MM = np.array([1200.0, 300.0, 400.0])
FIXTURE_MM, FIXTURE_DEG, TOUCH_MM = 0.3, 0.05, 0.1
"""Scatter from job to job of the part in its fixture and of one touch (one sigma)."""


@dataclass(frozen=True, slots=True)
class Planted:
    """A change from job `at` on: what is moved, and by how much (mm; of the robot mm per metre)."""

    what: str
    at: int
    size: float


def simulated_jobs(n: int, *, seed: int, points: int = 8, planted: tuple[Planted, ...] = ()) -> PartJobs:
    """Return jobs whose least-squares poses and residuals follow from simulated touches."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-250, 250, (points, 3))
    turns = Rotation.from_rotvec(np.radians(rng.normal(0, FIXTURE_DEG, (n, 3)))).as_matrix()
    moves = AT_MM + rng.normal(0, FIXTURE_MM, (n, 3))
    for change in (each for each in planted if each.what == "fixture"):
        moves[change.at :, 1] += change.size
    touched = np.einsum("nij,pj->npi", turns, places) + moves[:, None]
    for change in planted:
        if change.what == "robot":
            touched[change.at :] *= 1 + change.size / 1000
        elif change.what != "fixture":
            touched[change.at :, int(change.what[1:]), 2] += change.size
    touched += rng.normal(0, TOUCH_MM, touched.shape)
    around, middle = places - places.mean(axis=0), touched.mean(axis=1)
    U, _, Vt = np.linalg.svd(np.einsum("pi,npj->nij", around, touched - middle[:, None]))
    signs = np.ones((n, 3))
    signs[:, 2] = np.linalg.det(U @ Vt)
    T_base_part = np.tile(np.eye(4), (n, 1, 1))
    T_base_part[:, :3, :3] = np.einsum("nji,nj,nkj->nik", Vt, signs, U)
    T_base_part[:, :3, 3] = middle - T_base_part[:, :3, :3] @ places.mean(axis=0)
    fitted = np.einsum("nij,pj->npi", T_base_part[:, :3, :3], places) + T_base_part[:, None, :3, 3]
    return PartJobs(
        file="part.step",
        sha256="ab" * 32,
        names=tuple(f"j{row:04}" for row in range(n)),
        when=tuple(f"2026-03-{1 + row // 240 % 28:02}T{row // 10 % 24:02}:{row % 10:02}" for row in range(n)),
        by_time=False,
        T_base_part=T_base_part,
        points=tuple(f"P{row}" for row in range(points)),
        residuals=touched - fitted,
        places=places,
        seam_error_mm=0.3 + 0.02 * rng.normal(size=n),
        suspected=np.zeros(points),
    )


def write_batch(out: Path, jobs: PartJobs, *, failed: int = 0) -> None:
    """Write what `wpcal drift` reads of a folder of `wpcal batch`; the last jobs have failed."""
    out.mkdir()
    lines = []
    for row, name in enumerate(jobs.names):
        has_failed = row >= len(jobs.names) - failed
        line = {
            "schema": "wpcal/job-summary/1", "job": name, "line": row + 2, "part": jobs.file, "taught": "t.csv",
            "when": jobs.when[row] or None, "verdict": "ERROR" if has_failed else "PASS",
            "worst_seam_error_mm": None if has_failed else float(jobs.seam_error_mm[row]),
            "error": "t.csv: is empty" if has_failed else None,
        }  # fmt: skip
        lines.append(json.dumps(line))
        if has_failed:
            continue
        points = [
            {"name": point, "p_part_mm": jobs.places[at].tolist(), "residual_mm": jobs.residuals[row, at].tolist()}
            for at, point in enumerate(jobs.points)
        ]
        record = {
            "schema": "wpcal/calibration/1",
            "inputs": {"taught": {"file": "t.csv", "sha256": None},
                       "part": {"file": jobs.file, "sha256": jobs.sha256, "unit": "mm"}},
            "T_base_part": jobs.T_base_part[row].tolist(),
            "points": points,
        }  # fmt: skip
        (out / name).mkdir()
        (out / name / "calibration.json").write_text(json.dumps(record))
    (out / "summary.jsonl").write_text("".join(f"{line}\n" for line in lines))
