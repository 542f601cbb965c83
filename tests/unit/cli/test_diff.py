"""`wpcal diff` and `wpcal.results.diff` on the golden results of the tee: every kind of change is found, and named."""

import copy
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from wpcal.cli.diff import diff
from wpcal.core.errors import FormatError, InputError
from wpcal.results.diff import assert_calibration_close, assert_seams_close, compare_folders, compare_seams

GOLDEN = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"
LIMIT_MM = 0.01
Record = dict[str, Any]


def kept(file: str) -> Record:
    record: Record = json.loads((GOLDEN / file).read_text(encoding="utf-8"))
    return record


def move_a_frame(record: Record) -> None:
    record["seams"][1]["frames"][3]["p_mm"][2] += 0.011


def turn_a_frame(record: Record) -> None:
    record["seams"][1]["frames"][3]["R"][0][1] += 1.1e-5


def drop_a_seam(record: Record) -> None:
    del record["seams"][2]


def add_a_seam(record: Record) -> None:
    record["seams"].append({**record["seams"][0], "name": "W9"})


def drop_a_frame(record: Record) -> None:
    del record["seams"][0]["frames"][-1]


def rename_the_joint(record: Record) -> None:
    record["seams"][0]["joint"] = "lap"


def lengthen(record: Record) -> None:
    record["seams"][3]["length_mm"] += 0.02


def lose_a_number(record: Record) -> None:
    record["seams"][1]["frames"][3]["p_mm"][2] = float("nan")


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (move_a_frame, "seam W2 frame 3 p_mm"),
        (turn_a_frame, "seam W2 frame 3 R"),
        (drop_a_seam, "seam W3"),
        (add_a_seam, "seam W9"),
        (drop_a_frame, "seam W1 frames"),
        (rename_the_joint, "seam W1 joint"),
        (lengthen, "seam W4 length_mm"),
        (lose_a_number, "seam W2 frame 3 p_mm"),
    ],
)
def test_a_change_of_the_seams_is_found(change: Callable[[Record], None], where: str) -> None:
    changed = copy.deepcopy(kept("seams.json"))
    change(changed)
    assert [d.where for d in compare_seams(changed, kept("seams.json"), atol_mm=LIMIT_MM)] == [where]
    with pytest.raises(AssertionError, match=where):
        assert_seams_close(changed, kept("seams.json"), atol_mm=LIMIT_MM)


@pytest.mark.parametrize(
    ("path", "off", "where"),
    [
        (("T_base_part", 0, 3), 0.011, "T_base_part origin"),
        (("T_base_part", 0, 1), 1.1e-5, "T_base_part rotation"),
        (("objective_mm",), 0.011, "objective_mm"),
        (("rms_mm",), float("nan"), "rms_mm"),
        (("points", 0, "residual_mm", 1), 0.011, "point V2 residual_mm"),
        (("points", 5, "p_base_mm", 1), 0.011, "point H1 p_base_mm"),
    ],
)
def test_a_change_of_the_calibration_is_found(path: tuple[Any, ...], off: float, where: str) -> None:
    changed = copy.deepcopy(kept("calibration.json"))
    inner: Any = changed
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] += off
    with pytest.raises(AssertionError, match=f"^{where}: found [^\n]*$"):
        assert_calibration_close(changed, kept("calibration.json"), atol_mm=LIMIT_MM)


def test_a_change_below_the_limit_is_none() -> None:
    changed = copy.deepcopy(kept("seams.json"))
    changed["seams"][1]["frames"][3]["p_mm"][2] += 0.9 * LIMIT_MM
    assert_seams_close(changed, kept("seams.json"), atol_mm=LIMIT_MM)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return Path(shutil.copytree(GOLDEN, tmp_path / "out"))


def test_the_command_ends_with_0_where_nothing_differs(out: Path) -> None:
    done = CliRunner().invoke(diff, [str(out), str(GOLDEN)], standalone_mode=False)
    assert done.return_value == 0
    assert "no difference" in done.output


def test_the_command_ends_with_1_and_says_what_differs(out: Path) -> None:
    changed = kept("seams.json")
    move_a_frame(changed)
    (out / "seams.json").write_text(json.dumps(changed), encoding="utf-8")
    done = CliRunner().invoke(diff, [str(out), str(GOLDEN), "--json"], standalone_mode=False)
    assert done.return_value == 1
    (difference,) = json.loads(done.output)["differences"]
    assert (difference["where"], difference["off_by"]) == ("seam W2 frame 3 p_mm", "0.011000 mm")


def test_only_the_files_that_were_kept_are_compared(out: Path, tmp_path: Path) -> None:
    only_seams = tmp_path / "kept"
    only_seams.mkdir()
    shutil.copy(GOLDEN / "seams.json", only_seams)
    (out / "calibration.json").write_text("{}", encoding="utf-8")
    assert compare_folders(out, only_seams, atol_mm=LIMIT_MM) == []


@pytest.mark.parametrize("atol_mm", [-1.0, float("nan"), float("inf")])
def test_a_limit_without_meaning_is_refused(atol_mm: float) -> None:
    with pytest.raises(InputError, match="atol_mm"):
        compare_folders(GOLDEN, GOLDEN, atol_mm=atol_mm)


def test_half_a_record_is_refused(out: Path) -> None:
    (out / "seams.json").write_text('{"schema": "wpcal/seams/1"}', encoding="utf-8")
    with pytest.raises(FormatError, match=r"seams\.json: lacks frame, units, "):
        compare_folders(out, GOLDEN, atol_mm=LIMIT_MM)
    (out / "seams.json").unlink()
    with pytest.raises(InputError, match=r"holds no seams\.json"):
        compare_folders(out, GOLDEN, atol_mm=LIMIT_MM)


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds neither calibration\.json nor seams\.json"):
        compare_folders(GOLDEN, tmp_path, atol_mm=LIMIT_MM)
