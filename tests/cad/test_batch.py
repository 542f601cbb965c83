"""`wpcal batch` on real parts: the same bytes as one command for each job, and nothing lost when something breaks."""

import json
import shutil
from collections.abc import Mapping
from pathlib import Path

import pytest

from cad.batch.job_list import OF_THE_BATCH, read_jobs, words_of
from cad.batch.jobs import option_columns
from cad.batch.request import NOT_OF_A_JOB
from cad.batch.summary_check import check_summary, read_summary
from tests.cad.batch_faults import WPCAL, contents, write_jobs
from tests.record_checks import check_record
from tests.running import kernel_work_here, run_command, run_here

JOBS, WRAPPED = 8, 2  #: Jobs, and the one with an option that changes the seams of the part.
CHANGED = {"j0", "j3", "j4", "j5", "summary.jsonl"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A list of jobs, and in `whole` what a batch makes of it that nobody disturbs."""
    folder = tmp_path_factory.mktemp("batch")
    write_jobs(folder, JOBS, wrapped=WRAPPED)
    done = run_here("batch", folder / "jobs.csv", "-o", folder / "whole", "-j", "8", "--report", "all")
    assert done.returncode == 1, done.stderr
    return folder


def test_a_job_writes_what_the_command_writes(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """To the byte, apart from job.json and the page."""
    monkeypatch.setattr("cad.work.child.run_in_child", kernel_work_here)
    for number, options in ((1, ("--criterion", "robust")), (2, ("--wrap",))):
        one = tmp_path / f"one{number}"
        run_here("calibrate", folder / "tee.step", folder / f"day{number}.csv", "-o", one, *options)
        single = {path.name: path.read_bytes() for path in one.iterdir() if path.name != "report.html"}
        job = {path.name: path.read_bytes() for path in (folder / "whole" / f"j{number}").iterdir()}
        del job["report.html"]
        ours, theirs = (json.loads(files.pop("job.json")) for files in (job, single))
        check_record(ours)
        assert ours["result"] == theirs["result"]
        assert job == single


@pytest.mark.deep
def test_verify_names_what_was_changed_in_a_batch(folder: Path) -> None:
    """A job, two folders that changed places, a request and the summary were changed; the others are as claimed."""
    out = folder / "changed"
    shutil.copytree(folder / "whole", out)
    for before, after in (("j3", "other"), ("j4", "j3"), ("other", "j4")):
        (out / before).rename(out / after)
    (out / "j5" / "job.json").unlink()
    path = out / "j0" / "seams.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([lines[0], lines[1].replace("1", "2"), *lines[2:]]))
    first = json.loads((out / "summary.jsonl").read_text().splitlines()[0])
    text = (out / "summary.jsonl").read_text()
    bound = f'"bound_mm": {first["bound_mm"]}'
    assert bound in text
    (out / "summary.jsonl").write_text(text.replace(bound, f'"bound_mm": {first["bound_mm"] + 0.1}'))
    done = run_here("verify", out, "-j", "2", "--json")
    assert done.returncode == 1, done.stderr
    record = json.loads(done.stdout)
    check_record(record)
    states = {each["name"]: each["state"] for each in record["checked"]}
    names = ("summary.jsonl", *(f"j{k}" for k in range(JOBS)))
    assert states == {name: "different" if name in CHANGED else "as claimed" for name in names}
    told = {each["name"]: [one["where"] for one in each["differences"]] for each in record["checked"]}
    assert told["j0"][0].startswith("seams.csv line 2 ")
    assert told["j3"][0] == told["j4"][0] == "job.json job"
    assert told["j5"] == ["job.json"]
    assert told["summary.jsonl"][0] == "summary.jsonl j0 bound_mm"
    assert any(where.startswith("summary.csv line 2 bound_mm") for where in told["summary.jsonl"])


@pytest.mark.deep
def test_another_folder_order_of_work_and_surroundings_give_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    """Of all records, programs and pages, and of the page of drift over them."""
    elsewhere = tmp_path / "another place"
    elsewhere.mkdir()
    write_jobs(elsewhere, JOBS, wrapped=WRAPPED)
    surroundings = {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "LC_ALL": "C", "OMP_NUM_THREADS": "2"}
    command = [WPCAL, "batch", "jobs.csv", "-o", "whole", "-j", "1", "--report", "all", "--no-cache"]
    run_command(*command, cwd=elsewhere, **surroundings)
    assert contents(elsewhere / "whole") == contents(folder / "whole")
    pages = []
    for place in (folder, elsewhere):
        drawn = run_here("drift", place / "whole", "-o", place / "drift.html", "--json")
        assert drawn.returncode in (0, 1), drawn.stderr
        pages.append((drawn.stdout.replace(str(place), ""), (place / "drift.html").read_bytes()))
    assert pages[0] == pages[1]


def test_what_is_complete_is_not_done_again_unless_an_input_changed(folder: Path, tmp_path: Path) -> None:
    write_jobs(tmp_path, JOBS, wrapped=WRAPPED)
    shutil.copytree(folder / "whole", tmp_path / "out")
    (tmp_path / "day3.csv").write_bytes((tmp_path / "day4.csv").read_bytes())  # another input
    (tmp_path / "out" / "j4" / "seams.csv").write_text("half")  # the disk lost it
    shutil.rmtree(tmp_path / "out" / "j5")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*.json")}
    done = run_here("batch", tmp_path / "jobs.csv", "-o", tmp_path / "out", "--report", "all", "--resume", "--json")
    record = json.loads(done.stdout)
    assert record["kept"] == JOBS - 3
    changed = {path.parent.name for path, at in before.items() if not path.exists() or path.stat().st_mtime_ns != at}
    assert changed == {"j3", "j4"}
    assert record["jobs"][3]["pose"] == record["jobs"][4]["pose"]
    assert contents(tmp_path / "out").keys() == contents(folder / "whole").keys()


def test_wrong_rows_fail_in_one_line_and_the_others_go_on(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "tee.step", tmp_path)
    shutil.copy(folder / "day0.csv", tmp_path)
    (tmp_path / "short.csv").write_text("name,x_mm,y_mm,z_mm\nV2,1,2,3\n")
    (tmp_path / "bad.step").write_text("ISO-10303-21;\nnonsense")
    rows = {
        "good": ("tee.step,day0.csv,,", None),
        "../up": ("tee.step,day0.csv,,", "holds '/'"),
        "GOOD": ("tee.step,day0.csv,,", "appears twice, first in line 2"),
        "good ": ("tee.step,day0.csv,,", "the name 'good' appears twice, first in line 2"),
        "": ("tee.step,day0.csv,,", "it is empty"),
        "nul": ("tee.step,day0.csv,,", "is the name of a device in Windows"),
        "no part": ("te.step,day0.csv,,", "no such file or directory; did you mean"),
        "no taught": ("tee.step,none.csv,,", "none.csv: no such file or directory"),
        "few": ("tee.step,short.csv,,", "short.csv"),
        "bad part": ("bad.step,day0.csv,,", "bad.step"),
        "criterion": ("tee.step,day0.csv,best,", "'best' is not one of 'minimax'"),
        "bake": ("tee.step,day0.csv,,maybe", "--bake: expected yes or no, got 'maybe'"),
        "stdin": ("-,day0.csv,,", "standard input cannot be used"),
    }
    lines = [f"{name},{cells}" for name, (cells, _) in rows.items()]
    (tmp_path / "jobs.csv").write_text("\n".join(["job,part,taught,criterion,bake", *lines]) + "\n")
    done = run_here("batch", tmp_path / "jobs.csv", "-o", tmp_path / "out", "--json", "-j", "2")
    assert done.returncode == 1
    found = json.loads(done.stdout)["jobs"]
    for line, (_, expected) in zip(found, rows.values(), strict=True):
        assert expected is None or expected in line["error"], line
        assert (line["error"] is None) == (expected is None)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["good", "summary.csv", "summary.jsonl"]
    lines = read_summary(tmp_path / "out")
    assert not list(check_summary(tmp_path / "out", lines))
    for copied in lines[:2]:
        assert "listed twice" in {each.found for each in check_summary(tmp_path / "out", [*lines, copied])}


def test_a_wrong_list_or_folder_is_refused_and_nothing_is_written(tmp_path: Path) -> None:
    refused: Mapping[str, tuple[str, str]] = {
        "empty": ("job,part,taught\n", "has a header and no rows"),
        "column": ("job,part,taught,criterium\na,b,c,d\n", "did you mean criterion?"),
        "missing": ("job,part\na,b\n", "missing column taught"),
        "out": ("job,part,taught,out\na,b,c,d\n", "column 'out': every job is written to OUT/JOB"),
        "holder": ("job,part,taught,zzz\na,b,c,d\n", "is not an option of wpcal calibrate that a job can have"),
        "short": (
            "job;part;taught;wrap\na;b;c\n",
            "line 2, column 3: expected 4 cells, got 3; an empty cell needs its ;",
        ),
    }
    for name, (text, expected) in refused.items():
        (tmp_path / f"{name}.csv").write_text(text)
        done = run_here("batch", tmp_path / f"{name}.csv", "-o", tmp_path / "out")
        assert (done.returncode, done.stdout) == (2, "")
        assert expected in done.stderr
        assert not (tmp_path / "out").exists()
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").touch()
    (tmp_path / "good.csv").write_text("job,part,taught\na,b,c\n")
    done = run_here("batch", tmp_path / "good.csv", "-o", tmp_path / "full")
    assert done.returncode == 2
    assert "exists and is not empty; continue its batch with --resume" in done.stderr
    assert "--force" not in done.stderr
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["notes.txt"]


def test_every_option_of_the_command_that_a_job_can_have_is_a_column() -> None:
    columns = option_columns()
    assert {"criterion", "sigma_mm", "nominal", "seams", "bodies", "mark_seams", "uframe"} <= set(columns)
    assert not {*OF_THE_BATCH, "help"} & set(columns)
    assert set(OF_THE_BATCH) == NOT_OF_A_JOB - {"help"}
    assert columns["bodies"].is_optional
    assert columns["weld"].is_multiple
    assert columns["wrap"].shapes_part
    assert not columns["criterion"].shapes_part


def test_numbers_are_typed_as_in_any_table(tmp_path: Path) -> None:
    """Only cells of options that take one number: those of others may hold commas of their own."""
    (tmp_path / "jobs.csv").write_bytes(
        "\ufeffjob;part;taught;sigma_mm;tolerance_mm;nominal;bending\r\n"
        "a;p;t;0,2;1,50 mm;1,2,3,0,0,0;yes\r\nb;p;t;;2;;0,5\r\nc;p;t;x;2;;\r\n".encode()
    )
    words = [words_of(job.cells, option_columns()) for job in read_jobs(tmp_path / "jobs.csv", option_columns())]
    assert words == [
        ("--sigma-mm=0.2", "--tolerance-mm=1.5", "--nominal=1,2,3,0,0,0", "--bending"),
        ("--tolerance-mm=2", "--bending=0.5"),
        ("--sigma-mm=x", "--tolerance-mm=2"),
    ]
