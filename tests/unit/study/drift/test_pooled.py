"""What earlier jobs of a cell tell of its touches and of its robot."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.calibrate import fit_least_squares
from wpcal.calibrate.errors.prediction import ToolError
from wpcal.calibrate.errors.robot_field import FieldOrigin, RobotField, correlation
from wpcal.core import InputError, PointPairs
from wpcal.core.record_check import check_record
from wpcal.core.records import to_json
from wpcal.core.tangent import point_jacobian
from wpcal.study.drift.jobs import PartJobs
from wpcal.study.drift.pooled import CELL_ERRORS_SCHEMA, pool_jobs

SIGMA_MM, JOBS = 0.15, 30
PLACES = np.array([[x, y, z] for x in (0.0, 900.0) for y in (0.0, 700.0) for z in (0.0, 300.0)])
NAMES = tuple(f"V{k}" for k in range(8))


def jobs_of_a_robot(amplitude_mm: float, seed: int, count: int = JOBS) -> PartJobs:
    """Calibrate jobs by one robot, whose own error at a place is the same in all jobs; one touch is mistyped."""
    rng = np.random.default_rng(seed)
    own = amplitude_mm * np.linalg.cholesky(correlation(PLACES, PLACES, 500.0) + 1e-9 * np.eye(8))
    field, poses, residuals = own @ rng.standard_normal((8, 3)), [], []
    for job in range(count):
        q = PLACES + field + rng.normal(0.0, SIGMA_MM, (8, 3)) + [0.0, 0.0, 25.0 * (job == 3)]
        fit = fit_least_squares(PointPairs(NAMES, PLACES, q))
        poses.append(fit.matrix)
        residuals.append(q - fit.apply(PLACES))
    jobs, seam = tuple(map(str, range(count))), np.full(count, 0.3)
    taken = (np.array(poses), NAMES, np.array(residuals), PLACES, seam, np.zeros(8))
    return PartJobs("part.step", "", jobs, jobs, True, *taken)


def test_scatter_is_the_touch_and_what_stays_is_the_robot() -> None:
    exact, rough = ([pool_jobs([jobs_of_a_robot(a, seed)]) for seed in range(12)] for a in (0.0, 0.5))
    for found in (*exact, *rough):
        assert found.sigma_mm == pytest.approx(SIGMA_MM, rel=0.15)
        assert found.field.origin is FieldOrigin.POOLED
    of_exact, of_rough = (np.mean([found.field.amplitude_mm for found in each]) for each in (exact, rough))
    assert of_exact < 0.2
    assert 0.35 < of_rough < 0.8


@pytest.mark.parametrize("tilt_deg", [30.0, 0.0])
def test_a_tool_that_varies_from_job_to_job_is_told_where_the_postures_show_it(tilt_deg: float, golden: Any) -> None:
    jobs, rng = jobs_of_a_robot(0.2, 3), np.random.default_rng(3)
    angles = np.radians(tilt_deg) * rng.normal(size=(JOBS, 8, 3))
    off = rng.normal(size=(JOBS, 1, 3)) * [0.1, 0.1, 0.6]
    shown = np.array([Rotation.from_euler("ZYX", angles[k]).apply(off[k, 0]) for k in range(JOBS)]).reshape(JOBS, -1)
    Q = np.linalg.qr(point_jacobian(PLACES - PLACES.mean(axis=0)).reshape(-1, 6))[0]  # what the fit takes out of it
    moved = jobs.residuals + (shown - shown @ Q @ Q.T).reshape(JOBS, -1, 3)
    pooled = pool_jobs([replace(jobs, residuals=moved, angles=angles)])
    found = pooled.tool
    if not tilt_deg:
        assert found is None
        return
    assert pooled.sigma_mm == pytest.approx(SIGMA_MM, rel=0.2)  # what the tool does is no scatter of touches
    assert found.along_mm == pytest.approx(0.6, rel=0.35)
    assert found.side_mm < 0.25
    golden(pooled)


def test_the_file_is_what_calibrate_takes(tmp_path: Path) -> None:
    found, path = pool_jobs([jobs_of_a_robot(0.3, 1)]), tmp_path / "cell.json"
    path.write_text(to_json(found.to_record()), encoding="utf-8")
    check_record(json.loads(path.read_text(encoding="utf-8")), CELL_ERRORS_SCHEMA, path=str(path))
    assert RobotField.read(str(path)) == found.field
    with pytest.raises(InputError, match="a file in which jobs tell of the tool"):
        ToolError.read(str(path))
    told = replace(found, tool=ToolError(0.1, 0.5))
    path.write_text(to_json(told.to_record()), encoding="utf-8")
    check_record(json.loads(path.read_text(encoding="utf-8")), CELL_ERRORS_SCHEMA, path=str(path))
    assert ToolError.read(str(path)) == told.tool == ToolError.read("0.1,0.5")
    path.write_text("[" * 100_000, encoding="utf-8")
    for read in (ToolError.read, RobotField.read):
        with pytest.raises(InputError, match=r"errors of the nominal arm|jobs tell of the tool"):
            read(str(path))
    with pytest.raises(InputError, match="8 jobs of one part"):
        pool_jobs([jobs_of_a_robot(0.3, 1, count=7)])
