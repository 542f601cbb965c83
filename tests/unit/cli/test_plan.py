import csv
import json

import numpy as np
import pytest

from tests.saddle import CELL, SEAMS, THINNED, scan_coarsely, shared_search
from wpcal.cli.main import run
from wpcal.core.motion import WELD_SPEED_MM_S

pytestmark = pytest.mark.many

SHOWN = 8  #: Every eighth path of the shared sweep: enough to choose from.


@pytest.fixture(scope="module")
def few_points(tmp_path_factory):
    """The saddle with the points of the shared search."""
    record = json.loads(SEAMS.read_text(encoding="utf-8"))
    record["seams"][0]["frames"] = record["seams"][0]["frames"][::THINNED]
    file = tmp_path_factory.mktemp("seams") / "seams.json"
    file.write_text(json.dumps(record), encoding="utf-8")
    return file


@pytest.fixture
def swept(monkeypatch):
    """Give `wpcal plan` paths of the shared sweep instead of a search of its own; tests/e2e has the whole command."""
    paths = shared_search().swept

    def share(every):
        monkeypatch.setattr("wpcal.planning.search.plan_seam.sweep_paths", lambda *_: iter(paths[::every]))

    return share


def call(*arguments):
    with pytest.raises(SystemExit) as stopped:
        run([str(argument) for argument in arguments])
    return stopped.value.code


def changed_cell(tmp_path, change):
    record = json.loads(CELL.read_text(encoding="utf-8"))
    change(record)
    file = tmp_path / "cell.json"
    file.write_text(json.dumps(record), encoding="utf-8")
    return file


def test_a_plan_is_written_whole(tmp_path, few_points, swept, capsys):
    swept(SHOWN)
    out = tmp_path / "out"
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out, "--prefer", "position") == 0
    shown = capsys.readouterr().out
    assert "Plans of seam W1" in shown
    assert "together: " in shown
    record = json.loads((out / "pareto.json").read_text(encoding="utf-8"))
    chosen = record["plans"][record["chosen"] - 1]
    assert chosen["objectives"]["position_deg"] == min(plan["objectives"]["position_deg"] for plan in record["plans"])
    with (out / "plan.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["s_mm"]]
    assert len(rows) == len(chosen["s_mm"])
    np.testing.assert_allclose(
        [float(row["r2_T_deg"]) for row in rows], np.array(chosen["robot2_deg"])[:, 5], rtol=0, atol=1e-7
    )
    assert json.loads((out / "plan.json").read_text(encoding="utf-8"))["freedom"] == "free"
    assert {file.suffix for file in out.iterdir()} >= {".mod", ".jbi", ".json", ".csv"}


def test_without_a_name_every_accepted_seam_has_a_folder(tmp_path, few_points, swept, capsys):
    """W3 is refused, and W2 is the same weld as W1 under another name."""
    swept(SHOWN)
    record = json.loads(few_points.read_text(encoding="utf-8"))
    (first,) = record["seams"]
    copies = [{**first, "name": name} for name in ("W2", "W3")]
    copies[1] |= {"confidence": 0.0, "accepted": False}
    record["seams"] += copies
    file = tmp_path / "seams.json"
    file.write_text(json.dumps(record), encoding="utf-8")
    out = tmp_path / "out"
    assert call("plan", CELL, file, "-o", out, "-f", "rapid") == 0
    assert sorted(path.name for path in out.iterdir()) == ["W1", "W2"]
    for name in ("W1", "W2"):
        assert any(f"_{name}_" in path.name for path in (out / name).glob("*.mod"))
        assert json.loads((out / name / "plan.json").read_text(encoding="utf-8"))["freedom"] == "free"
    shown = capsys.readouterr().out
    assert "2 of 2 seams have programs: W1, W2; the ways from one seam to the next are not planned" in shown
    assert call("plan", CELL, file, "-o", out, "--json", "--force") == 2
    assert "name it with --seam; these are W1, W2" in capsys.readouterr().err


def test_json_is_the_record_alone(tmp_path, few_points, swept, capsys):
    swept(SHOWN)
    out = tmp_path / "out"
    values = {"thickness_mm": 8, "passes": 1, "tacks": {"length_mm": 10, "pitch_mm": 90}}
    welds = tmp_path / "welds.json"
    welds.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": values}]}))
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out, "--json", "--welds", welds) == 0
    told = capsys.readouterr()
    assert told.out == (out / "pareto.json").read_text(encoding="utf-8")
    assert "are not in this plan of two robots: weld them first" in told.err


@pytest.mark.deep
def test_the_genetic_algorithm_is_run_when_it_is_asked_for(tmp_path, few_points, swept, capsys):
    swept(SHOWN)
    out = tmp_path / "out"
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out, "--json", "--generations", "1") == 0
    assert "nsga2" in json.loads((out / "pareto.json").read_text(encoding="utf-8"))["fronts"]
    assert capsys.readouterr().out == (out / "pareto.json").read_text(encoding="utf-8")


def test_no_feasible_plan_is_an_answer(tmp_path, few_points, swept, capsys):
    swept(1)
    out = tmp_path / "out"
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out, "--speed-mm-s", "5000", "--json") == 1
    said = capsys.readouterr()
    assert said.err.startswith("wpcal: no feasible plan: joint speeds fails most, on 15 of 15 paths: joint ")
    assert said.err.endswith(" mm, 5000 mm/s asked; use a lower --speed-mm-s\n")
    assert said.out == (out / "pareto.json").read_text(encoding="utf-8")
    record = json.loads((out / "pareto.json").read_text(encoding="utf-8"))
    assert (record["plans"], record["failed"].split(",")[0]) == ([], "no feasible plan: joint speeds fails most")
    assert record["obstacle"]["constraint"] == "joint speeds"
    assert (record["obstacle"]["asked"], record["obstacle"]["unit"]) == (5000.0, "mm/s")
    assert 0 < record["obstacle"]["best"] < 5000
    assert [file.name for file in out.iterdir()] == ["pareto.json"]


def odd(record):
    """An arm whose base frame is at axis 2."""
    record["torch_robot"]["arm"] = "ar2010"


def remove_torch(record):
    record["torch_robot"]["torch"] = []


@pytest.mark.deep
def test_a_plan_in_an_odd_cell_says_so_once_and_in_its_records(tmp_path, few_points, swept, capsys):
    swept(SHOWN)
    out = tmp_path / "out"
    assert call("plan", changed_cell(tmp_path, remove_torch), few_points, "--seam", "W1", "-o", out) == 0
    error = capsys.readouterr().err
    assert error.count("the torch has no bodies") == 1
    assert [line.split(":")[1] for line in error.splitlines()] == [" odd cell"]
    for name in ("pareto.json", "plan.json"):
        (issue,) = json.loads((out / name).read_text(encoding="utf-8"))["issues"]
        assert (issue["code"], issue["ids"]) == ("no-bodies", ["torch"])
    assert "the torch has no bodies" in (out / "plan.html").read_text(encoding="utf-8")


def test_tip_and_speed_between_points_are_in_the_table_and_in_the_record(tmp_path, few_points, swept, capsys):
    swept(SHOWN)
    out = tmp_path / "out"
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out, "--joints") == 0
    shown = " ".join(capsys.readouterr().out.split())
    found = json.loads((out / "plan.json").read_text(encoding="utf-8"))["between_points"]
    assert f"tip up to {found['largest_tip_error_mm']:.2f} mm off the line from point to point" in shown
    speeds = f"at {found['slowest_mm_s']:.1f} to {found['fastest_mm_s']:.1f} mm/s"
    assert f"{speeds} in the part ({WELD_SPEED_MM_S:g} mm/s planned)" in shown
    assert "smaller steps" in shown  # every fourth point of the saddle is too few
    assert found["slowest_mm_s"] < WELD_SPEED_MM_S < found["fastest_mm_s"]
    assert found["largest_tip_error_mm"] > 0.25


def test_the_check_of_a_cell_draws_it_and_ends_with_0(tmp_path, capsys):
    assert call("plan", "--check", CELL, "-o", tmp_path / "out") == 0
    assert "nothing odd" in capsys.readouterr().out
    page = (tmp_path / "out" / "cell.html").read_text(encoding="utf-8")
    assert "two MH6" in page
    assert call("plan", "--check", CELL, "-o", tmp_path / "out") == 2
    assert "--force" in capsys.readouterr().err


def test_the_check_of_an_odd_cell_ends_with_2_and_says_what_to_write(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert call("plan", "--check", changed_cell(tmp_path, odd)) == 2
    shown = capsys.readouterr().out
    assert "505 mm below the floor" in shown
    assert '"mounting_face_z_mm": -505 in torch_robot' in shown
    assert "1 oddity" in shown
    assert "505 mm below the floor" in (tmp_path / "cell.html").read_text(encoding="utf-8")


def test_the_check_as_json_is_a_record(tmp_path, capsys):
    assert call("plan", "--check", changed_cell(tmp_path, remove_torch), "-o", tmp_path / "out", "--json") == 2
    record = json.loads(capsys.readouterr().out)
    assert record["schema"] == "wpcal/cell-check/1"
    assert [issue["code"] for issue in record["issues"]] == ["no-bodies"]


def test_a_plan_without_seams_says_what_is_missing(tmp_path, capsys):
    assert call("plan", CELL) == 2
    assert "a plan needs RESULT, -o; to check the cell alone, add --check" in capsys.readouterr().err


def far_away(record):
    record["holder_robot"]["T_world_base"]["xyz_mm"] = [8000, 0, 0]


def block(record):
    body = {"name": "block", "capsules": [{"p_mm": [0, 0, 60], "q_mm": [0, 0, 300], "radius_mm": 60}]}
    record["holder_robot"]["part"].append(body)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (far_away, "seam W1, point 1 (s = 0.0 mm): out of reach of robot"),
        (block, "every state at the start of the seam is in collision"),
    ],
)
def test_a_bad_cell_is_one_line_and_nothing_written(tmp_path, few_points, monkeypatch, capsys, change, says):
    scan_coarsely(monkeypatch)
    out = tmp_path / "out"
    assert call("plan", changed_cell(tmp_path, change), few_points, "--seam", "W1", "-o", out) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--seam", "W7"), "no seam 'W7'; the file has W1"),
        (("--seam", "W1", "--slope-deg", "60"), "slope: 60 deg is outside its range 30"),
        (("--seam", "W1", "--speed-mm-s", "0"), "--speed-mm-s"),
        (("--seam", "W1", "-f", "ur"), "ur has no coordinated programs of two robots; these have: fanuc, inform"),
        (("--seam", "W1", "-f", "kuka", "--joints"), "kuka has no joint programs of two robots; these have: inform"),
        (("--seam", "W1", "-f", "karel"), "unknown controller 'karel'"),
        (("--seam", "W1", "--arc", "on"), "arc instructions need weld data"),
        (("--seam", "W1", "--every-point"), "use --joints for every point"),
        (("--seam", "W1", "--template", "mine"), "have no templates"),
        (("--seam", "W1", "--config", "N U T, 0, 0, 0"), "leave out --config"),
        (("--seam", "W1", "--only", "W1"), "either --seam or --only"),
        (("--only", "W7"), "W7"),
        (("--part", "x.glb"), "--part is for one robot"),
        (("--seam", "W1", "--tacks", "only"), "leave out --tacks only"),
        (("--seam", "W1", "--weave", "points"), "leave out --weave points"),
        (("--seam", "W1", "--path-tol-mm", "-1"), "path tolerance: expected a positive number"),
    ],
)
def test_wrong_use_is_one_line_and_nothing_written(tmp_path, few_points, capsys, arguments, says):
    out = tmp_path / "out"
    for result in (few_points, few_points.parent):  # the seams, or the folder that has them
        assert call("plan", CELL, result, *arguments, "-o", out) == 2
        assert says in capsys.readouterr().err
        assert not out.exists()


def test_a_seam_file_of_another_version_is_refused(tmp_path, capsys):
    file = tmp_path / "seams.json"
    file.write_text(SEAMS.read_text(encoding="utf-8").replace("wpcal/seams/1", "wpcal/seams/9"), encoding="utf-8")
    assert call("plan", CELL, file, "--seam", "W1", "-o", tmp_path / "out") == 2
    assert "expected a record of schema wpcal/seams/1, found wpcal/seams/9" in capsys.readouterr().err


def test_results_are_not_overwritten(tmp_path, few_points, capsys):
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine", encoding="utf-8")
    assert call("plan", CELL, few_points, "--seam", "W1", "-o", out) == 2
    assert "(--force)" in capsys.readouterr().err
