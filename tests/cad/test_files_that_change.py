"""A recorded SHA-256 is that of the bytes that were used, whatever happens to the files during the run."""

import hashlib
import shutil
from pathlib import Path

import numpy as np
import pytest

import cad.step.read
from cad.step.part21 import Part21File
from cad.workpiece.calibrate import WorkpieceCalibration, calibrate_files, calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.controllers.taught_program import read_taught_program
from wpcal.controllers.user_frames import ProgramReading, parse_uframes
from wpcal.core.errors import InputError
from wpcal.results.folder import read_result_folder
from wpcal.taught.table import read_taught

FIXTURES = Path(__file__).parents[2] / "fixtures"


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    return tuple(Path(shutil.copy(FIXTURES / "tee" / name, tmp_path)) for name in ("tee.step", "taught.csv"))


def recorded(found: WorkpieceCalibration) -> tuple[str, str]:
    inputs = found.to_record()["inputs"]
    return inputs["part"]["sha256"], inputs["taught"]["sha256"]


@pytest.mark.parametrize("change", ["edited", "removed"])
def test_a_table_changed_at_every_step_of_the_run(files: tuple[Path, Path], change: str) -> None:
    part, taught = files
    before, text, steps = (sha256(part), sha256(taught)), taught.read_text(), list[str]()

    def at(step: str) -> None:
        steps.append(step.split(maxsplit=1)[0])
        if change == "edited":
            taught.write_text(text.replace("812.29", f"{900 + len(steps)}.00"))
        else:
            taught.unlink(missing_ok=True)

    assert recorded(calibrate_workpiece(part, taught, progress=at)) == before
    assert {"reading", "finding", "fitting"} <= {*steps}


def test_a_part_swapped_between_its_text_and_the_kernel(
    files: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    part, taught = files
    before = sha256(part), sha256(taught)
    expected = calibrate_workpiece(part, taught)
    read_step_text = cad.step.read.read_step_text

    def read_and_swap(path: Path, *, data: bytes | None = None) -> Part21File:
        file = read_step_text(path, data=data)
        shutil.copy(FIXTURES / "lap" / "lap.step", path)
        return file

    monkeypatch.setattr(cad.step.read, "read_step_text", read_and_swap)
    found = calibrate_workpiece(part, taught)
    assert recorded(found) == before
    assert [seam.name for seam in found.seams] == [seam.name for seam in expected.seams]
    for mine, other in zip(found.seams, expected.seams, strict=True):
        np.testing.assert_array_equal(mine.frames.p, other.frames.p)


def test_points_of_a_program_carry_the_hash_of_the_program(tmp_path: Path) -> None:
    path = tmp_path / "points.mod"
    target = "[[812.29,-240.62,165.80],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    path.write_text(f"MODULE M\n  CONST robtarget V2:={target};\nENDMODULE\n")
    found = read_taught_program(path, ProgramReading(uframes=parse_uframes(("base",))))
    assert found.sha256 == sha256(path)


def test_points_of_a_table_carry_the_hash_of_the_table() -> None:
    path = FIXTURES / "tee" / "taught.csv"
    assert read_taught(path).sha256 == sha256(path)


def test_the_record_lists_the_files_of_its_run(files: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    calibrate_files(*files, out, overwrite=False)
    listed = read_result_folder(out).calibration["files"]
    assert listed == {name: sha256(out / name) for name in ("part.glb", "tee.calibrated.step")}
    before = {path.name: path.read_bytes() for path in out.iterdir()}
    shutil.copy(out / "part.glb", out / "mine.glb")
    (out / "report.html").unlink()
    (out / "report.html").mkdir()
    with pytest.raises(InputError, match=r"report\.html: is a folder"):
        calibrate_files(*files, out, overwrite=True, options=CalibrateOptions(seed=1))
    (out / "report.html").rmdir()
    assert {path.name: path.read_bytes() for path in out.iterdir()} == {
        **{name: data for name, data in before.items() if name != "report.html"},
        "mine.glb": before["part.glb"],
    }
