"""`wpcal batch` on real parts: the same bytes as one command for each job, and nothing lost when something breaks."""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cad.batch.job_list import OF_THE_BATCH, read_jobs, words_of
from cad.batch.summary_check import check_summary, read_summary
from cad.cli.calibrate_jobs import NOT_OF_A_JOB, open_part, option_columns, run_job
from tests.record_checks import check_record
from tests.running import TIMEOUT_S, run_here
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.issue import Issue

WPCAL = Path(sys.executable).with_name("wpcal")
FIXTURES = Path(__file__).parents[2] / "fixtures"
JOBS = 6
KILLS = 2
KILLS_DEEP = 50
ORPHAN_S = 10.0
"""Within this time the processes of a batch that was killed end and remove what they began; without other work on the
machine in less than a second."""
EVER_DIFFERENT = "seconds"
"""The only field of the summary that is not the same in the next run."""


def write_parts(folder: Path) -> None:
    """Write a part and points that were touched on it, each time with other errors."""
    shutil.copy(FIXTURES / "tee" / "tee.step", folder)
    rows = (FIXTURES / "tee" / "taught.csv").read_text().splitlines()
    at = rows[0].split(",").index("x_mm")
    for number in range(JOBS):
        rng, moved = np.random.default_rng(number), [rows[0]]
        for row in rows[1:]:
            cells = row.split(",")
            cells[at] = f"{float(cells[at]) + rng.normal(0, 0.1):.4f}"
            moved.append(",".join(cells))
        (folder / f"day{number}.csv").write_text("\n".join(moved) + "\n")
    lines = [f"j{k},tee.step,day{k}.csv,{'robust' if k == 1 else ''},{'x' if k == 2 else ''}" for k in range(JOBS)]
    (folder / "jobs.csv").write_text("\n".join(["job,part,taught,criterion,wrap", *lines]) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A list of jobs, and in `whole` what a batch makes of it that nobody disturbs."""
    folder = tmp_path_factory.mktemp("batch")
    write_parts(folder)
    done = run_here("batch", folder / "jobs.csv", "-o", folder / "whole", "-j", "2", "--report", "none")
    assert done.returncode in (0, 1), done.stderr
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files of a folder, of the summary without what is ever different."""
    found = {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    lines = [json.loads(line) for line in found.pop("summary.jsonl").splitlines()]
    for line in lines:
        check_record(line)
        line[EVER_DIFFERENT] = None
    found["summary"] = json.dumps(lines).encode()
    rows = [row.split(",") for row in found.pop("summary.csv").decode().splitlines()]
    at = rows[0].index(EVER_DIFFERENT)
    return {**found, "table": json.dumps([[*row[:at], *row[at + 1 :]] for row in rows]).encode()}


def processes_in(folder: Path) -> list[int]:
    """Return the processes that were started for a batch into a folder."""
    found = []
    for each in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(folder).encode() in each.read_bytes():
                found.append(int(each.parent.name))
        except OSError:
            continue
    return found


def test_a_job_writes_what_the_command_writes(folder: Path, tmp_path: Path) -> None:
    """To the byte, apart from job.json and the page."""
    for number, options in ((1, ("--criterion", "robust")), (2, ("--wrap",))):
        one = tmp_path / f"one{number}"
        run_here("calibrate", folder / "tee.step", folder / f"day{number}.csv", "-o", one, *options)
        single = {path.name: path.read_bytes() for path in one.iterdir() if path.name != "report.html"}
        job = {path.name: path.read_bytes() for path in (folder / "whole" / f"j{number}").iterdir()}
        ours, theirs = (json.loads(files.pop("job.json")) for files in (job, single))
        check_record(ours)
        assert ours["result"] == theirs["result"]
        assert job == single


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
    assert states == {name: "as claimed" if name in {"j1", "j2"} else "different" for name in names}
    told = {each["name"]: [one["where"] for one in each["differences"]] for each in record["checked"]}
    assert told["j0"][0].startswith("seams.csv line 2 ")
    assert told["j3"][0] == told["j4"][0] == "job.json job"
    assert told["j5"] == ["job.json"]
    assert told["summary.jsonl"][0] == "summary.jsonl j0 bound_mm"
    assert any(where.startswith("summary.csv line 2 bound_mm") for where in told["summary.jsonl"])


def test_another_folder_order_of_work_and_surroundings_give_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "another place"
    elsewhere.mkdir()
    write_parts(elsewhere)
    surroundings = {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "LC_ALL": "C", "OMP_NUM_THREADS": "2"}
    command = [WPCAL, "batch", "jobs.csv", "-o", "out", "-j", "8", "--report", "none"]
    subprocess.run(command, cwd=elsewhere, env={**os.environ, **surroundings}, check=False, timeout=TIMEOUT_S)
    assert contents(elsewhere / "out") == contents(folder / "whole")


def disturbed(folder: Path, out: Path, number: int, after_s: float) -> subprocess.CompletedProcess[str]:
    """Start a batch, send it a signal, and return how it ended; nothing but finished work may be left."""
    out.mkdir(exist_ok=True)
    command = [WPCAL, "batch", folder / "jobs.csv", "-o", out, "-j", "2", "--report", "none", "--resume"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(after_s)
    process.send_signal(number)
    stdout, stderr = process.communicate(timeout=TIMEOUT_S)
    until = time.monotonic() + ORPHAN_S
    while time.monotonic() < until and (processes_in(out) or list(out.glob(".wpcal*"))):
        time.sleep(0.01)
    assert processes_in(out) == []
    assert [path.name for path in out.rglob(".wpcal*")] == []
    for job in (each for each in out.iterdir() if each.is_dir()):
        assert {path.name: path.read_bytes() for path in job.iterdir()} == {
            path.name: path.read_bytes() for path in (folder / "whole" / job.name).iterdir()
        }
    return subprocess.CompletedProcess(command, process.returncode, stdout, stderr)


def resumed(folder: Path, out: Path) -> None:
    done = run_here("batch", folder / "jobs.csv", "-o", out, "-j", "2", "--report", "none", "--resume")
    assert done.returncode in (0, 1), done.stderr
    assert contents(out) == contents(folder / "whole")


def moments(kills: int, folder: Path) -> Iterator[tuple[Path, int, float]]:
    rng = random.Random(kills)
    for k in range(kills):
        number = (signal.SIGKILL, signal.SIGINT, signal.SIGTERM)[k % 3]
        yield folder / f"out{k}", number, rng.uniform(0.2, 6.0)


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_a_batch_that_is_ended_at_any_moment_is_continued_as_if_it_had_not_been(folder: Path, tmp_path: Path) -> None:
    check_ends(KILLS, folder, tmp_path)


@pytest.mark.deep
@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_the_same_at_fifty_moments(folder: Path, tmp_path: Path) -> None:
    check_ends(KILLS_DEEP, folder, tmp_path)


def check_ends(kills: int, folder: Path, tmp_path: Path) -> None:
    for out, number, after_s in moments(kills, tmp_path):
        ended = disturbed(folder, out, number, after_s)
        assert "Traceback" not in ended.stderr
        if ended.returncode not in (0, 1, -number):
            assert ended.returncode == 128 + number
            assert len([line for line in ended.stderr.splitlines() if line.startswith("wpcal: ")]) == 1
        resumed(folder, out)


def test_what_is_complete_is_not_done_again_unless_an_input_changed(folder: Path, tmp_path: Path) -> None:
    write_parts(tmp_path)
    shutil.copytree(folder / "whole", tmp_path / "out")
    (tmp_path / "day3.csv").write_bytes((tmp_path / "day4.csv").read_bytes())  # another input
    (tmp_path / "out" / "j4" / "seams.csv").write_text("half")  # the disk lost it
    shutil.rmtree(tmp_path / "out" / "j5")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*.json")}
    done = run_here("batch", tmp_path / "jobs.csv", "-o", tmp_path / "out", "--report", "none", "--resume", "--json")
    record = json.loads(done.stdout)
    assert record["kept"] == 3
    changed = {path.parent.name for path, at in before.items() if not path.exists() or path.stat().st_mtime_ns != at}
    assert changed == {"j3", "j4"}
    assert record["jobs"][3]["pose"] == record["jobs"][4]["pose"]
    assert contents(tmp_path / "out").keys() == contents(folder / "whole").keys()


def test_an_input_that_changes_while_it_is_read_fails_its_job_and_nothing_is_left(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_parts(tmp_path)
    monkeypatch.chdir(tmp_path)
    opened = open_part("tee.step", (), use_cache=False)

    def changing(*arguments: object, **settings: object) -> tuple[Issue, ...]:
        (tmp_path / "day0.csv").write_bytes((tmp_path / "day1.csv").read_bytes())
        return opened.means.write_moved(*arguments, **settings)

    job = {"name": "j0", "part": "tee.step", "taught": "day0.csv", "words": (), "out": tmp_path / "j0"}
    changed = replace(opened, means=replace(opened.means, write_moved=changing))
    with pytest.raises(InputError, match="changed while it was read"):
        run_job(changed, folder=tmp_path / "w0", pages="none", **job)
    assert not (tmp_path / "j0").exists()
    run_job(opened, folder=tmp_path / "w1", pages="none", **job)
    record = json.loads((tmp_path / "j0" / "calibration.json").read_text())
    assert record["inputs"]["taught"]["sha256"] == sha256_of((tmp_path / "day1.csv").read_bytes())


def test_a_disk_that_takes_no_more_ends_the_batch_in_one_line(folder: Path, tmp_path: Path) -> None:
    """Files may have 30 kB only: calibration.json fits, the moved part does not."""
    shutil.copytree(folder, tmp_path / "list", ignore=shutil.ignore_patterns("whole"))
    command = f"ulimit -f 30; exec {WPCAL} batch {tmp_path}/list/jobs.csv -o {tmp_path}/out -j 2"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False, timeout=TIMEOUT_S)
    assert (done.returncode, done.stdout) == (2, "")
    [line] = [each for each in done.stderr.splitlines() if each.startswith("wpcal: ")]
    assert "cannot be written: file too large; 0 of 6 jobs are done; continue with: wpcal batch" in line
    assert not (tmp_path / "out").exists()


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
    assert {name.replace("json", "as_json") for name in OF_THE_BATCH} == NOT_OF_A_JOB - {"help"}
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
