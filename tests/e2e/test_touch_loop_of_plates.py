"""Plan, program, run, read, fit with plates that moved: every search finds its plate, and the band holds."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cad.workpiece.advise_bodies import tacked_bodies
from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from tests.running import run_here
from tests.touch_robots.loop import CONFIG, T_FLANGE_TOOL, displacement, planned_frame, run_program
from tests.touch_robots.robot import Torch
from tests.touch_robots.solid import Solid, triangles_of_solids
from wpcal.core.arrays import FloatArray
from wpcal.seam import SeamOptions
from wpcal.touch.searches import TouchPlan, read_touch_plan

UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"
PART, BODIES = UPRIGHTS / "uprights.step", UPRIGHTS / "bodies.json"
PLACE = "812,-240,156,1.1459,-2.005,34.377"
WHOLE = displacement((0.8, -0.6, 0.5), (0.15, -0.2, 0.2))
TACK_MM, TACK_RAD = 1.0, 4e-3
NOZZLE_MM = 11.0

pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> tuple[TouchPlan, Path]:
    """The plan of the uprights, and the folder with it and its programs."""
    folder = tmp_path_factory.mktemp("plates")
    ended = run_here("touches", PART, "--nominal", PLACE, "--bodies", BODIES, "-o", folder / "plan")
    assert ended.returncode == 0, ended.stderr
    ended = run_here("export", folder / "plan", "-f", "rapid", "-f", "krl", *CONFIG, "-o", folder)
    assert ended.returncode == 0, ended.stderr
    return read_touch_plan(folder / "plan"), folder


def drawn(seed: int) -> list[tuple[FloatArray, FloatArray]]:
    """Return the motion p → R p + t of each plate: one tack tolerance per axis, about the middle of the plate."""
    rng, motions = np.random.default_rng(seed), []
    for triangles in triangles_of_solids(PART):
        points = triangles.reshape(-1, 3)
        centre = (points.min(axis=0) + points.max(axis=0)) / 2.0
        R = Rotation.from_rotvec(rng.normal(size=3) * TACK_RAD).as_matrix()
        motions.append((R, centre - R @ centre + rng.normal(size=3) * TACK_MM))
    return motions


@cache
def seam_points() -> Any:
    """The points of the accepted seams in the model, with their faces' normals and bodies."""
    workpiece = open_workpiece(PART)
    seams, workpiece = find_seams(workpiece, SeamOptions())
    return tacked_bodies(workpiece, [seam for seam in seams if seam.accepted], BodiesOptions(), SeamOptions()).seams


def true_seams(motions: list[tuple[FloatArray, FloatArray]], T: FloatArray) -> dict[str, FloatArray]:
    """Return where the seams really are in the base: three moved planes meet at each point."""
    own = seam_points()
    points, found = own.points, {name: [] for name in own.seams}
    for k, name in enumerate(own.seams):
        (R, t), (R_base, t_base) = motions[points.wall_body[k]], motions[points.base_body[k]]
        rows = np.stack([R @ points.n_wall[k], R_base @ points.n_base[k], R @ points.x[k]])
        on_wall, on_base = R @ points.p_part[k] + t, R_base @ points.p_part[k] + t_base
        p = np.linalg.solve(rows, np.einsum("ij,ij->i", rows, [on_wall, on_base, on_wall]))
        found[name].append(T[:3, :3] @ p + T[:3, 3])
    return {name: np.array(places) for name, places in found.items()}


def test_the_plan_says_which_plate_each_touch_is_on_and_what_it_serves(planned: tuple[TouchPlan, Path]) -> None:
    plan, folder = planned
    assert [body.name for body in plan.bodies] == ["base", "U1", "U2", "U3", "U4"]
    assert {search.body for search in plan.searches} == {body.name for body in plan.bodies}
    triangles = dict(zip([body.name for body in plan.bodies], triangles_of_solids(PART), strict=True))
    for search in plan.searches:
        corners = triangles[search.body].reshape(-1, 3)
        assert (search.contact_part >= corners.min(axis=0) - 1e-6).all()
        assert (search.contact_part <= corners.max(axis=0) + 1e-6).all()
        assert search.serves is not None
    record = json.loads((folder / "plan" / "touches.json").read_text())
    assert record["predicted"]["joint_95_mm"] >= record["predicted"]["error_95_mm"]
    table = (folder / "plan" / "touches.csv").read_text().splitlines()
    assert table[0].endswith(",body")
    assert [line.rsplit(",", 1)[1] for line in table[1:]] == [search.body for search in plan.searches]


@pytest.mark.parametrize(
    ("brand", "seed"), few([("rapid", 0), ("krl", 1), *(("rapid", seed) for seed in range(2, 14))], 1)
)
def test_searches_meet_plates_that_moved_and_the_band_holds(
    brand: str, seed: int, planned: tuple[TouchPlan, Path], tmp_path: Path
) -> None:
    plan, folder = planned
    motions, T = drawn(seed), planned_frame(plan) @ WHOLE
    moved = [part @ R.T + t for part, (R, t) in zip(triangles_of_solids(PART), motions, strict=True)]
    torch = Torch(T_FLANGE_TOOL, stick_out_mm=plan.stick_out_mm, nozzle_radius_mm=NOZZLE_MM)
    ran = run_program(brand, folder / brand, Solid(np.concatenate(moved), T), tmp_path / "run", torch=torch)
    assert ran.run.is_finished
    assert ran.run.stops == []
    words = ("--touches", folder / "plan", "--bodies", BODIES, "-o", tmp_path / "out")
    ended = run_here("calibrate", PART, ran.results, *words)
    assert ended.returncode in {0, 1}, ended.stderr
    assert json.loads((tmp_path / "out" / "calibration.json").read_text())["bodies"]["wrong_touches"] == []
    seams = {each["name"]: each for each in json.loads((tmp_path / "out" / "seams.json").read_text())["seams"]}
    u95 = {name: np.array([frame["u95_mm"] for frame in seams[name]["frames"]]) for name in seams}
    inside = []
    for name, places in true_seams(motions, T).items():
        found = np.array([frame["p_mm"] for frame in seams[name]["frames"]])
        inside.append(np.linalg.norm(found - places, axis=1) <= u95[name])
    assert np.mean(np.concatenate(inside)) >= 0.7  # points of one plate move together: eight seams, not hundreds
    for name, error in plan.predicted.by_seam_mm:
        assert u95[name].max() == pytest.approx(error, rel=0.15)
