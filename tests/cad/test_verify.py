"""`wpcal verify`: any changed number in any file of a result folder is found, and named."""

import json
import math
import random
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from cad.batch.compare import compare_claim
from cad.batch.job_record import read_job_record
from tests.few import few
from tests.record_checks import check_record
from tests.running import kernel_work_here, run_here
from wpcal.core.input_file import sha256_of
from wpcal.pages.report import build_report
from wpcal.results.differences import differences_of, walk_records
from wpcal.seam.record import seams_csv

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
NUMBER = re.compile(rb"\d+")
VERSIONS = re.compile(rb'"versions": \{[^}]*\}')
LEAST_FIELDS = 800  #: Numbers of the records and cells of the table: the part has two seams of some twenty points.
TRIES = 60  #: Changed numbers of each file.


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Inputs, `out`, and `again` from the same command; commands work in this process."""
    folder = tmp_path_factory.mktemp("verify")
    for name in ("tee.step", "taught.csv"):
        shutil.copy(TEE / name, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr("cad.work.child.run_in_child", kernel_work_here)
        for out in ("out", "again"):
            run_here("calibrate", "tee.step", "taught.csv", "-o", out, "--tolerance-mm", "0.6")
        yield folder


@pytest.fixture
def changed(folder: Path) -> Iterator[Path]:
    """Return a copy of the results, beside their inputs."""
    path = folder / "changed"
    shutil.copytree(folder / "out", path)
    yield path
    shutil.rmtree(path)


def edit(path: Path, change: Callable[[dict], None]) -> None:
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record, indent=1) + "\n")


def claim_again(folder: Path, name: str) -> None:
    """Write the hash of a changed file into job.json, as a careful forger does."""
    sha256 = sha256_of((folder / name).read_bytes())
    edit(folder / "job.json", lambda record: record["files"].update({name: sha256}))


def test_the_request_is_in_the_folder_and_gives_the_same_bytes(folder: Path) -> None:
    assert {path.name: path.read_bytes() for path in (folder / "out").iterdir()} == {
        path.name: path.read_bytes() for path in (folder / "again").iterdir()
    }
    record = json.loads((folder / "out" / "job.json").read_text())
    check_record(record)
    assert record["inputs"]["options"] == ["--tolerance-mm=0.6"]
    done = run_here("verify", "out", "--json")
    assert done.returncode == 0, done.stdout
    assert [each["state"] for each in json.loads(done.stdout)["checked"]] == ["as claimed"]


@pytest.mark.parametrize(
    "name",
    few(
        ["calibration.json", "seams.csv", "part.glb", "seams.json", "tee.calibrated.step", "report.html", "job.json"], 3
    ),
)
def test_any_changed_number_is_found(folder: Path, changed: Path, name: str) -> None:
    """Numbers as they are in the file, of part.glb bytes; also when job.json has the new hash."""
    data, rng = (changed / name).read_bytes(), random.Random(name)
    record = json.loads((changed / "job.json").read_text())
    assert compare_claim(changed, folder / "again", record) == []
    places = [match.span() for match in NUMBER.finditer(data)]
    if versions := VERSIONS.search(data):  # results of other versions are compared within a tolerance
        places = [place for place in places if not versions.start() < place[0] < versions.end()]
    if name == "part.glb":
        places = [(at, at + 1) for at in range(len(data))]
    for begin, end in rng.sample(places, min(TRIES, len(places))):
        at = rng.randrange(begin, end)
        other = data[at] ^ 1 if name == "part.glb" else ord(rng.choice("0123456789".replace(chr(data[at]), "")))
        (changed / name).write_bytes(data[:at] + bytes([other]) + data[at + 1 :])
        if name != "job.json":
            record["files"][name] = sha256_of((changed / name).read_bytes())
        found = compare_claim(changed, folder / "again", record)
        assert found, (at, data[begin:end])
        assert all(each.where.startswith(name) and each.found != each.expected for each in found)


def test_every_number_of_every_record_and_table_is_named_by_its_field(folder: Path) -> None:
    """Each number by its last digit, all by themselves: exactly one place differs, and it is this field."""
    count = 0
    for path in sorted((folder / "out").glob("*.json")):
        record, expected = (json.loads(path.read_text()) for _ in range(2))
        for holder, key in numbers_in(record):
            value = holder[key]
            holder[key] = value + 1 if isinstance(value, int) else math.nextafter(value, math.inf)
            (only,) = walk_records(record, expected, path.name)
            assert only.where.startswith(path.name)
            assert only.where.endswith(f" {key}")
            holder[key] = value
            count += 1
    table = (folder / "out" / "seams.csv").read_text()
    titles, *rows = (line.split(",") for line in table.splitlines())
    for line, row in enumerate(rows, start=2):
        for column, title in enumerate(titles):
            cells = [*row[:column], row[column][:-1] + "x", *row[column + 1 :]]
            changed = table.replace(",".join(row), ",".join(cells), 1)
            (only,) = differences_of("seams.csv", changed.encode(), table.encode())
            assert only.where == f"seams.csv line {line} {title}"
            count += 1
    assert count > LEAST_FIELDS


def numbers_in(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the object or list, and the key or index, of each number of a record."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, one in list(inner):
        if isinstance(one, int | float) and not isinstance(one, bool):
            yield value, key
        else:
            yield from numbers_in(one)


def test_the_command_names_the_number(changed: Path) -> None:
    edit(changed / "calibration.json", lambda record: record["points"][0]["residual_mm"].__setitem__(0, 0.25))
    claim_again(changed, "calibration.json")
    done = run_here("verify", "changed")
    assert done.returncode == 1
    first = json.loads((changed / "calibration.json").read_text())["points"][0]["name"]
    assert re.search(rf"calibration.json points {first} residual_mm 0 is 0\.25, expected -?0\.\d+", done.stdout)
    assert "changed: different" in done.stdout


def test_another_request_is_not_what_gave_the_results(changed: Path) -> None:
    edit(changed / "job.json", lambda record: record["inputs"].update(options=["--tolerance-mm=0.7"]))
    assert run_here("verify", "changed").returncode == 1


@pytest.mark.deep
def test_a_damaged_or_missing_request(changed: Path) -> None:
    (changed / "job.json").write_text('{"schema": "wpcal/job/1"}')
    assert run_here("verify", "changed").returncode == 1
    (changed / "job.json").unlink()
    assert run_here("verify", "changed").returncode == 0  # of the usual options, with the tolerance that is stated
    edit(changed / "calibration.json", lambda record: record.update(rms_mm=record["rms_mm"] + 1e-9))
    assert run_here("verify", "changed").returncode == 1


@pytest.mark.usefixtures("folder")
def test_what_is_no_result_and_inputs_that_are_nowhere_are_one_line() -> None:
    Path("empty").mkdir()
    cases = {
        ("absent",): "absent: no such folder",
        ("tee.step",): "tee.step: is not a folder",
        ("empty",): "empty: holds no results of wpcal calibrate or wpcal batch",
        ("out", "--inputs", "nowhere"): "--inputs nowhere: no such file or folder",
    }
    for words, expected in cases.items():
        done = run_here("verify", *words)
        assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
        assert expected in done.stderr


def test_inputs_that_moved_or_changed(folder: Path, changed: Path) -> None:
    edit(changed / "job.json", lambda record: record["inputs"]["part"].update(sha256="0" * 64))
    done = run_here("verify", "changed")
    assert (done.returncode, "inputs part sha256" in done.stdout) == (1, True)
    shutil.copy(folder / "out" / "job.json", changed)
    text = (folder / "taught.csv").read_text()
    try:
        (folder / "taught.csv").rename(folder / "renamed.csv")
        done = run_here("verify", "changed")
        assert (done.returncode, "taught.csv': an input" in done.stdout) == (2, True)
        (folder / "taught.csv").write_text(text + "\n")
        done = run_here("verify", "changed")
        assert (done.returncode, "its SHA-256 is another" in done.stdout) == (2, True)
        assert run_here("verify", "changed", "--inputs", "renamed.csv").returncode == 0
    finally:
        (folder / "taught.csv").write_text(text)


@pytest.mark.deep
def test_results_of_another_version_are_compared_by_numbers(folder: Path, changed: Path) -> None:
    edit(changed / "job.json", lambda record: record.update(wpcal="0.0.1"))
    done = run_here("verify", "changed")
    assert (done.returncode, "written by wpcal 0.0.1" in done.stdout) == (0, True), done.stdout
    record = read_job_record(changed)
    assert record is not None
    (changed / "seams.csv").write_text((changed / "seams.csv").read_text().replace("1", "2"))
    assert [each.where for each in compare_claim(changed, folder / "again", record)] == ["seams.csv"]
    edit(changed / "seams.json", lambda seams: seams["seams"][0]["frames"][0]["p_mm"].__setitem__(0, 1.0))
    for name in ("seams.json", "seams.csv"):
        claim_again(changed, name)
    found = compare_claim(changed, folder / "again", json.loads((changed / "job.json").read_text()))
    assert "frame 0 p_mm" in found[0].where
    shutil.copy(folder / "out" / "seams.json", changed)
    claim_again(changed, "seams.json")
    done = run_here("verify", "changed", "--json")
    (checked,) = json.loads(done.stdout)["checked"]
    assert (done.returncode, [each.split()[0] for each in checked["unchecked"]]) == (0, ["seams.csv"])


def nudge(value: Any) -> Any:
    """Change the last digits of every number, as another library does."""
    if isinstance(value, dict):
        return {key: nudge(one) for key, one in value.items()}
    if isinstance(value, list):
        return [nudge(one) for one in value]
    return value + 1e-12 if isinstance(value, float) and 0.0 < abs(value) < 10.0 else value


@pytest.mark.parametrize("library", few(["numpy", "scipy"], 0))
def test_other_versions_of_libraries_may_change_last_digits(folder: Path, changed: Path, library: str) -> None:
    """Within one set of versions a last digit is a difference; across, a difference is what a person could see."""

    def restate() -> None:
        seams = json.loads((changed / "seams.json").read_text())
        record = json.loads((changed / "calibration.json").read_text())
        glb = (changed / "part.glb").read_bytes()
        (changed / "seams.csv").write_text(seams_csv(seams), encoding="utf-8")
        (changed / "report.html").write_text(build_report(record, seams, glb), encoding="utf-8")
        for name in ("calibration.json", "seams.json", "seams.csv", "report.html"):
            claim_again(changed, name)

    edit(changed / "seams.json", lambda record: record.update(seams=nudge(record["seams"])))
    edit(changed / "calibration.json", lambda record: record.update(points=nudge(record["points"])))
    restate()
    assert run_here("verify", "changed").returncode == 1
    edit(changed / "calibration.json", lambda record: record["versions"].update({library: "1.0.0"}))
    done = run_here("verify", "changed")
    assert (done.returncode, "changed: different" in done.stdout) == (1, True)  # the page says another version
    restate()
    done = run_here("verify", "changed", "--json")
    (checked,) = json.loads(done.stdout)["checked"]
    assert (done.returncode, checked["differences"]) == (0, [])
    assert checked["compared"].startswith(f"numbers, to 1e-5 mm: written by {library} 1.0.0, this is {library} ")
    edit(changed / "seams.json", lambda seams: seams["seams"][0]["frames"][0]["p_mm"].__setitem__(0, 1.0))
    restate()
    done = run_here("verify", "changed")
    assert (done.returncode, f"written by {library} 1.0.0" in done.stdout) == (1, True)
    assert re.search(r"seams.json seams W1 frames 0 p_mm 0 is 1\.0, expected", done.stdout)
    shutil.copy(folder / "out" / "seams.json", changed)
    (changed / "seams.csv").write_bytes((changed / "seams.csv").read_bytes().replace(b"yes", b"no", 1))
    for name in ("seams.json", "seams.csv"):
        claim_again(changed, name)
    (checked,) = json.loads(run_here("verify", "changed", "--json").stdout)["checked"]
    assert any(each["where"].startswith("seams.csv frames") for each in checked["differences"])
