"""A result folder is one thing: every command that reads a file of it names the one that was changed, and the value."""

import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.running import kernel_work_here, run_here
from wpcal.results.agree import changed_files
from wpcal.results.folder import read_result_folder

ROOT = Path(__file__).parents[2]
CELL = ROOT / "fixtures" / "cells" / "two-mh6.json"
CHANGED = "was changed after wpcal calibrate wrote it"
READERS: dict[str, tuple[str, ...]] = {
    "export": ("export", "out", "-f", "rapid", "-o", "programs", "--force"),
    "welds": ("welds", "out"),
    "report": ("report", "out", "-o", "page.html", "--force"),
    "diff": ("diff", "out", "again"),
    "diff-golden": ("diff", "again", "out"),
    "plan": ("plan", "out/cell.json", "out", "--seam", "none", "-o", "plan"),
    "plan-file": ("plan", "again/cell.json", "out/seams.json", "--seam", "none", "-o", "plan"),
    "place": ("place", "out/cell.json", "out", "-o", "map.svg"),
    "audit": ("audit", "out"),
    "audit-program": ("audit", "out/rapid/WPCAL.mod"),
    "drift": ("drift", "batch", "-o", "drift.html"),
}
"""Commands that read `out`; they end at once where the folder is as it was, or for another reason."""
RECORDS = ("calibration.json", "seams.json", "part.glb")
ONLY = {
    "seams.csv": ("audit",),
    "report.html": ("audit",),
    "cell.json": ("plan", "place", "audit"),
    "tee.calibrated.step": ("export", "welds", "report", "audit", "audit-program"),
    "calibration.json": tuple(READERS),
}
"""Which commands read a file, where not all but `drift` do."""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """`out` and `again` from one command, and `batch` with `out` as a job."""
    folder = tmp_path_factory.mktemp("results")
    for name in ("tee.step", "taught.csv"):
        shutil.copy(ROOT / "fixtures" / "tee" / name, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("cad.work.child.run_in_child", kernel_work_here)
        for out in ("out", "again"):
            words = ("--tolerance-mm", "0.6", "--cell", str(CELL), "--holder-joints", "0,0,0,0,-60,0")
            assert run_here("calibrate", "tee.step", "taught.csv", "-o", out, *words).returncode == 0
        assert run_here("export", "out", "-f", "rapid").returncode == 0
        Path("batch").mkdir()
        Path("batch", "summary.jsonl").touch()
        Path("batch", "out").symlink_to(folder / "out")
        yield folder


@pytest.fixture
def out(results: Path) -> Iterator[Path]:
    """Return the folder whose files a test changes; they are put back."""
    kept = {path: path.read_bytes() for path in (results / "out").iterdir() if path.is_file()}
    yield results / "out"
    for path, data in kept.items():
        path.write_bytes(data)


def edit(path: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    record = json.loads(path.read_text(encoding="utf-8"))
    change(record)
    path.write_text(json.dumps(record, indent=1), encoding="utf-8")


def said(words: tuple[str, ...]) -> tuple[int | str | None, str]:
    done = run_here(*words)
    return done.returncode, done.stdout + done.stderr


def test_files_as_they_were_written_are_not_named(out: Path) -> None:
    assert list(changed_files(out)) == []
    for words in READERS.values():
        assert CHANGED not in said(words)[1], words


def test_every_reader_names_every_file_that_it_reads(out: Path) -> None:
    files = sorted(path for path in out.iterdir() if path.is_file() and path.name != "job.json")
    assert {path.name for path in files} == {*RECORDS, *ONLY}
    for path in files:
        kept = path.read_bytes()
        path.write_bytes(kept.replace(b"0.1", b"0.2", 1) if b"0.1" in kept else kept[:-1] + bytes([kept[-1] ^ 1]))
        assert path.read_bytes() != kept
        for name in ONLY.get(path.name, set(READERS) - {"drift"}):
            code, text = said(READERS[name])
            assert code == (1 if name.startswith("audit") else 2), (path.name, name, text)
            assert CHANGED in text, (path.name, name, text)
            assert path.name in text, (path.name, name, text)
        path.write_bytes(kept)


def move_point(record: dict[str, Any]) -> None:
    record["seams"][1]["frames"][3]["p_mm"][0] += 1.0


def accept_all(record: dict[str, Any]) -> None:
    for seam in record["seams"]:
        seam["accepted"] = True


@pytest.mark.parametrize(
    ("name", "change", "field"),
    [
        ("seams.json", move_point, "seam W2: point 3: x_mm ("),
        ("seams.json", accept_all, "accepted ("),
        ("seams.json", lambda record: record["seams"][0].update(joint="lap"), 'W1 joint ("lap", was "tee")'),
        ("calibration.json", lambda record: record.update(verdict="FAIL"), 'verdict ("FAIL", was "PASS")'),
        ("calibration.json", lambda record: record["T_base_part"][0].__setitem__(3, 1.0), "T_base_part 0 3 (1.0, was "),
    ],
)
def test_the_value_is_named(out: Path, name: str, change: Callable[[dict[str, Any]], Any], field: str) -> None:
    edit(out / name, change)
    for reader in ("export", "welds", "plan", "audit"):
        code, text = said(READERS[reader])
        assert (code, CHANGED in text) == (1 if reader == "audit" else 2, True), text
        assert field in text, text
    assert ("--seams" in text) is (name == "seams.json")


def test_another_result_or_hash_in_the_request_is_a_change(out: Path) -> None:
    edit(out / "job.json", lambda record: record["result"].update(worst_residual_mm=0.01))
    assert "worst_residual_mm (0.01, was 0.225" in said(READERS["audit"])[1]
    edit(out / "job.json", lambda record: record["files"].update({"seams.json": "0" * 64}))
    assert f"seams.json: {CHANGED} (SHA-256 in job.json)" in said(READERS["export"])[1]


@pytest.mark.parametrize("listed", [True, False])
def test_results_without_hashes_open_and_it_is_said(out: Path, listed: bool) -> None:
    """As scripts write them, and versions before job.json; a script lists the mesh and the moved part."""
    (out / "job.json").unlink()
    if not listed:
        edit(out / "calibration.json", lambda record: record.pop("files"))
    edit(out / "seams.json", move_point)
    note = "has no job.json: nothing says whether its records are as they were written"
    for reader in ("export", "welds", "report"):
        assert note in said(READERS[reader])[1], reader
    if listed:
        (out / "part.glb").write_bytes((out / "part.glb").read_bytes()[:-1] + b"\1")
        assert f"part.glb: {CHANGED} (SHA-256 in calibration.json)" in said(READERS["place"])[1]


def test_edited_seams_are_given_to_the_calibration_which_records_them(results: Path, out: Path) -> None:
    """The way that the message names: the edited file itself, into the same folder."""
    edit(out / "seams.json", lambda record: record["seams"][1].update(edit={"name": "root"}))
    assert CHANGED in said(READERS["export"])[1]
    words = ("calibrate", "tee.step", "taught.csv", "-o", "edited", "--seams", "out/seams.json")
    assert run_here(*words).returncode in (0, 1)
    assert [seam["name"] for seam in read_result_folder(results / "edited").seams["seams"]][1] == "root"
    record = json.loads((results / "edited" / "job.json").read_text(encoding="utf-8"))
    assert [each["file"] for each in record["inputs"]["files"]] == ["out/seams.json"]


def test_a_page_that_is_made_again_is_recorded(results: Path) -> None:
    shutil.copytree(results / "again", results / "paged")
    (results / "paged" / "report.html").unlink()
    edit(results / "paged" / "job.json", lambda record: record["files"].pop("report.html"))
    assert run_here("report", "paged").returncode == 0
    assert (results / "paged" / "job.json").read_bytes() == (results / "again" / "job.json").read_bytes()
    (results / "paged" / "report.html").write_text("another version", encoding="utf-8")
    assert "report.html" in said(("audit", "paged"))[1]
    assert run_here("report", "paged", "--force").returncode == 0
    assert list(changed_files(results / "paged")) == []
