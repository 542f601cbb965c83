"""What a person sees of bodies that moved, after `wpcal calibrate --bodies`."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import Ended, run_here
from wpcal.core.input_file import sha256_of
from wpcal.core.records import read_json

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> tuple[Ended, Path]:
    """The sample part, of two solids; one touch is on its web."""
    folder = tmp_path_factory.mktemp("bodies")
    options = ("--bodies", "--sigma-mm", "0.3", "--details", "-o", folder / "out")
    ended = run_here("calibrate", TEE / "tee.step", TEE / "taught.csv", *options)
    return ended, folder / "out"


def test_first_line_says_whether_bodies_moved(run: tuple[Ended, Path]) -> None:
    first, second, *_ = run[0].stdout.splitlines()
    assert first.startswith("The touches fit a rigid part (p = ")
    assert second == "Tack tolerance 1 mm and 3 mrad, assumed: too few touches to estimate them."


def test_tables_say_motions_errors_and_gaps(run: tuple[Ended, Path]) -> None:
    record = json.loads((run[1] / "calibration.json").read_text(encoding="utf-8"))["bodies"]
    text = run[0].stdout
    assert "of 12 motions of the bodies" in text
    for seam in record["seams"]:
        row = next(line for line in text.split("error and gap")[1].splitlines() if seam["seam"] in line.split()[:2])
        assert f"{seam['u95_mm']:.3f}" in row
        assert f"{seam['u95_unseen_mm']:.3f}" in row
    for body in record["bodies"]:
        assert body["name"] in text


def test_summary_of_a_seam_is_that_of_its_frames(run: tuple[Ended, Path]) -> None:
    calibration = json.loads((run[1] / "calibration.json").read_text(encoding="utf-8"))
    seams = json.loads((run[1] / "seams.json").read_text(encoding="utf-8"))["seams"]
    told = {row["seam"]: row for row in calibration["bodies"]["seams"]}
    accepted = [seam for seam in seams if seam["accepted"]]
    assert (set(told), calibration["budget"]["seams"]) == ({seam["name"] for seam in accepted}, [])
    for seam in accepted:
        row = told[seam["name"]]
        assert row["u95_mm"] == max(frame["u95_mm"] for frame in seam["frames"])
        assert row["gap_max_mm"] == max(frame["gap_mm"] for frame in seam["frames"])
        assert row["bodies"] == ["base plate", "web"]


def test_points_with_a_column_of_kinds_fit_and_the_file_of_bodies_is_among_the_inputs(tmp_path: Path) -> None:
    bodies = tmp_path / "bodies.json"
    bodies.write_text('{"schema": "wpcal/bodies/1", "bodies": [{"name": "web"}]}', encoding="utf-8")
    head, *rows = (TEE / "taught.csv").read_text(encoding="utf-8").splitlines()
    taught = tmp_path / "taught.csv"
    taught.write_text("\n".join([f"{head},kind", *(f"{row},point" for row in rows)]), encoding="utf-8")
    options = ("--bodies", bodies, "--sigma-mm", "0.3", "--accept-unsure", "-o", tmp_path / "out")
    assert "radius" not in run_here("calibrate", TEE / "tee.step", taught, *options).stderr
    record = read_json(tmp_path / "out" / "calibration.json", schema="wpcal/calibration/1")
    assert record["inputs"]["bodies"] == {"file": "bodies.json", "sha256": sha256_of(bodies.read_bytes())}


def test_check_points_and_their_errors_are_on_the_moved_bodies(run: tuple[Ended, Path]) -> None:
    points = json.loads((run[1] / "calibration.json").read_text(encoding="utf-8"))["points"]
    errors = {point["name"]: point["error_95_mm"] for point in points}
    assert [point["name"] for point in points if point["use"] == "check"] == ["V6", "H1"]
    assert errors["V6"] > 2.0 * errors["H1"]  # a corner of the web, which one touch holds, and a hole of the base


def test_a_named_corner_is_of_its_own_solid_where_two_coincide(tmp_path: Path) -> None:
    """Two boxes that stand side by side share four corners: the name of a row says of which box its corner is."""
    from build123d import Box, Pos

    from cad.workpiece.bodies import BodiesOptions, find_bodies
    from cad.workpiece.moved_bodies import _solids_of_rows
    from cad.workpiece.touched_bodies import bodies_touched, on_two_bodies
    from cad.workpiece.workpiece import open_workpiece
    from wpcal.taught.resolve import touches_of
    from wpcal.taught.table import TaughtPoints

    workpiece = open_workpiece([Box(100, 50, 20), Pos(100, 0, 0) * Box(100, 50, 20)])
    part = find_bodies(workpiece.trimmed, BodiesOptions())
    corners = [feature for feature in workpiece.features if feature.kind.value == "V"]
    names = tuple(corner.name for corner in corners)
    p = np.array([corner.p_mm for corner in corners])
    model = np.full(p.shape, np.nan)
    taught = TaughtPoints(names, p, names, model, ("yes",) * len(names), "", ())
    touches = touches_of(taught, workpiece.trimmed, workpiece.features, use="yes")
    body = bodies_touched(touches, part.face_body, _solids_of_rows(taught, workpiece))
    assert [part.bodies.names[b] for b in body] == [corner.solid for corner in corners]
    assert (bodies_touched(touches, part.face_body) != body).any()  # what the place alone would say
    assert on_two_bodies(touches, part, _solids_of_rows(taught, workpiece)) == ()
    (issue,) = on_two_bodies(touches, part, {})
    twice = [corner.name for corner in corners if corner.p_mm[0] == pytest.approx(50.0)]
    assert list(issue.ids) == twice
    assert "write the name of the corner into the column feature" in issue.message
