"""The kept results of every fixture, made by the command from `taught.csv`.

`pytest tests/golden --regenerate` writes them anew; a person then reads the difference before it is committed.
"""

import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_command, run_here
from wpcal.core.records import read_json, to_json
from wpcal.core.result_files import PART_FILE
from wpcal.core.schemas import schema, schema_names
from wpcal.results.diff import assert_calibration_close, assert_seams_close
from wpcal.results.folder import RECORD_SCHEMAS

ROOT = Path(__file__).parents[2]
FIXTURES = ROOT / "fixtures"
pytestmark = pytest.mark.usefixtures("kernel_here")
PARTS = sorted(path.parent.name for path in FIXTURES.glob("*/truth.json"))

GOLDEN_MM = 1e-5
"""The polish ends within 1e-9 mm of the optimum; other versions of NumPy and of the kernel change last digits, and the
pose of a minimax fit is a thousand times softer than its value."""


OPTIONS: dict[str, tuple[str | Path, ...]] = {
    "tee": ("--generous",),
    "uprights": ("--bodies", FIXTURES / "uprights" / "bodies.json", "--sigma-mm", "0.2", "--accept-unsure"),
}
"""The short ends of the web are accepted in the result of the tee, so that programs made from it weld four seams. The
plates of the uprights moved."""


def run_wpcal(*arguments: Path | str) -> str:
    done = run_here(*arguments)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.parametrize("name", PARTS)
def test_a_part_gives_its_golden_results(name: str, tmp_path: Path, regenerate: bool) -> None:
    folder, golden = FIXTURES / name, FIXTURES / name / "golden"
    run_wpcal(
        "calibrate", folder / f"{name}.step", folder / "taught.csv", "-o", tmp_path / "out", *OPTIONS.get(name, ())
    )
    if regenerate:
        golden.mkdir(exist_ok=True)
        for file in (*RECORD_SCHEMAS, PART_FILE):
            shutil.copy(tmp_path / "out" / file, golden / file)
        # other tests put these records beside files of their own
        record = json.loads((golden / "calibration.json").read_text(encoding="utf-8"))
        del record["files"]
        (golden / "calibration.json").write_text(to_json(record), encoding="utf-8")
    for file, assert_close in zip(RECORD_SCHEMAS, (assert_calibration_close, assert_seams_close), strict=True):
        found, kept = (read_json(place / file, schema=RECORD_SCHEMAS[file]) for place in (tmp_path / "out", golden))
        assert_close(found, kept, atol_mm=GOLDEN_MM)
        assert found.get("judgement", {}).get("seam") == kept.get("judgement", {}).get("seam")


def test_the_papers_table_gives_its_golden_result(tmp_path: Path, regenerate: bool) -> None:
    folder = FIXTURES / "yin2003"
    golden = folder / "golden" / "calibration.json"
    (tmp_path / "calibration.json").write_text(
        run_wpcal("fit", folder / "table1.csv", "--json", "--accept-unsure"), encoding="utf-8"
    )
    if regenerate:
        golden.parent.mkdir(exist_ok=True)
        shutil.copy(tmp_path / "calibration.json", golden)
    found, kept = (read_json(path, schema=RECORD_SCHEMAS[golden.name]) for path in (tmp_path / golden.name, golden))
    assert_calibration_close(found, kept, atol_mm=GOLDEN_MM)


def test_the_golden_results_were_made_from_these_files() -> None:
    import hashlib

    for name in PARTS:
        record = read_json(FIXTURES / name / "golden" / "calibration.json", schema=RECORD_SCHEMAS["calibration.json"])
        for source in record["inputs"].values():
            path = FIXTURES / name / source["file"]
            assert hashlib.sha256(path.read_bytes()).hexdigest() == source["sha256"], path


BOUNDS = re.compile("const|pattern|default|(min|max|exclusiveM).*")


def bounds(node: Any, place: str) -> Iterator[str]:
    """Yield every bound of a schema with the fields on the way to it."""
    for key, value in node.items() if isinstance(node, dict) else enumerate(node if isinstance(node, list) else ()):
        if BOUNDS.fullmatch(str(key)) and not isinstance(value, dict):
            yield f"{place} {key} {value}\n"
        else:
            yield from bounds(
                value, place if isinstance(key, int) or key in ("properties", "$defs") else f"{place}.{key}"
            )


def test_the_bounds_of_all_fields_of_records_are_the_golden_ones(regenerate: bool) -> None:
    """A changed bound is a changed file format: CHANGELOG.md says it."""
    golden = FIXTURES / "record_bounds.txt"
    found = "".join(sorted({row for name in schema_names() for row in bounds(schema(name), name)}))
    if regenerate:
        golden.write_text(found, encoding="utf-8")
    assert found.splitlines() == golden.read_text(encoding="utf-8").splitlines()


def test_regenerating_is_refused_where_ci_is_set() -> None:
    command = [sys.executable, "-m", "pytest", "tests/golden", "--regenerate", "--collect-only", "-q"]
    done = run_command(*command, cwd=ROOT, CI="1")
    assert done.returncode == pytest.ExitCode.USAGE_ERROR
    assert "not regenerated where CI is set" in done.stderr + done.stdout
