import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import run_here
from wpcal.core.pendant import NOTATIONS
from wpcal.core.transform import RigidTransform

TABLE1 = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"
HEADER = TABLE1.read_text(encoding="utf-8").splitlines()[0]


def test_the_pose_in_the_record_is_that_of_the_pendants():
    record = json.loads(run_here("fit", TABLE1, "--json").stdout)
    assert list(record["pendant"]) == [notation.maker for notation in NOTATIONS]
    for notation in NOTATIONS:
        shown = record["pendant"][notation.maker]
        assert tuple(shown) == notation.labels
        back = notation.transform(list(shown.values()), target="base", source="part")
        np.testing.assert_allclose(back.matrix, record["T_base_part"], rtol=0, atol=1e-9)


def test_the_console_has_the_pose_and_only_on_request_the_proof():
    short, long = (run_here("fit", TABLE1, *details).stdout for details in ((), ("--details",)))
    record = json.loads(run_here("fit", TABLE1, "--json").stdout)
    T = RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")
    for notation in NOTATIONS:
        assert notation.orientation_text(T) in short
    for word in ("objective", "annealed", "gap", "rad │"):
        assert word in long
        assert word not in short.replace(notation.orientation_text(T), "")


def test_a_missed_tolerance_is_a_result_and_code_1():
    done = run_here("fit", TABLE1, "--tolerance-mm", "0.1")
    assert done.returncode == 1
    assert "FAIL" in done.stdout
    assert "tolerance is 0.1 mm" in " ".join(done.stdout.split())


@pytest.mark.parametrize(
    "options", [["--criterion", "robust"], ["--solver", "exact"], ["--criterion", "least_squares"]]
)
def test_other_criteria_and_solvers(options):
    assert run_here("fit", TABLE1, *options, "--tolerance-mm", "1").returncode == 0


BAD = {
    "empty": ("", "empty"),
    "header only": (HEADER, "no rows"),
    "two rows": (f"{HEADER}\na,0,0,0,0,0,0\nb,1,0,0,1,0,0", "at least 3 points"),
    "missing column": ("name,model_x_mm\na,1", "missing column model_y_mm"),
    "twice": (
        f"{HEADER}\na,0,0,0,0,0,0\na,1,0,0,1,0,0\nc,0,1,0,0,1,0",
        "line 3, column name: the name 'a' appears twice",
    ),
    "one line": (f"{HEADER}\na,0,0,0,0,0,0\nb,1,0,0,1,0,0\nc,2,0,0,2,0,0", "lie on one line"),
    "one place": (f"{HEADER}\na,1,1,1,0,0,0\nb,1,1,1,1,0,0\nc,1,1,1,2,0,0", "coincide"),
    "metres": (f"{HEADER}\na,0,0,0,0,0,0\nb,100,0,0,.1,0,0\nc,0,100,0,0,.1,0", "look like metres"),
}


BAD_FOR_STUDY = {name: case for name, case in BAD.items() if name != "metres"}  # it uses the shape of the points only


@pytest.mark.parametrize(
    ("command", "text", "words"),
    [("fit", *case) for case in BAD.values()] + [("study", *case) for case in BAD_FOR_STUDY.values()],
    ids=[f"fit-{name}" for name in BAD] + [f"study-{name}" for name in BAD_FOR_STUDY],
)
def test_bad_input_is_one_line_and_code_2(tmp_path, command, text, words):
    (tmp_path / "pairs.csv").write_text(text, encoding="utf-8")
    done = run_here(command, tmp_path / "pairs.csv")
    assert (done.returncode, done.stdout) == (2, "")
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["pairs.csv"]


def test_study_writes_its_distribution_and_keeps_an_existing_file(tmp_path):
    out = tmp_path / "study.json"
    first = run_here("study", TABLE1, "--trials", "500", "-o", out)
    assert first.returncode == 0
    assert "below 0.5 mm" in first.stdout
    record = json.loads(out.read_text(encoding="utf-8"))
    assert sum(record["histogram"]["counts"]) == record["trials"] == 500
    again = run_here("study", TABLE1, "--trials", "500", "-o", out)
    assert (again.returncode, again.stdout) == (2, "")
    assert "--force" in again.stderr
