"""`report.html` from the records of the tee, and `wpcal report` with its refusals."""

import base64
import json
import re
import shutil
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from wpcal.cli.report import report
from wpcal.core.errors import FormatError, FrameError, InputError, WpcalError
from wpcal.core.pendant import NOTATIONS
from wpcal.core.transform import RigidTransform
from wpcal.pages.report import build_report
from wpcal.results.folder import read_result_folder

GOLDEN = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A finished calibration without a mesh."""
    for name in ("calibration.json", "seams.json"):
        shutil.copy(GOLDEN / name, tmp_path / name)
    return tmp_path


def change(path: Path, **changes: Any) -> None:
    record = json.loads(path.read_text(encoding="utf-8"))
    path.write_text(json.dumps({**record, **changes}), encoding="utf-8")


def frames_of(page: str) -> Any:
    found = re.search(r'id="blob-frames" data-kind="raw">([^<]*)<', page)
    return json.loads(zlib.decompress(base64.b64decode(found[1])))


def test_the_page_carries_the_numbers_of_the_files(folder: Path) -> None:
    files = read_result_folder(folder)
    page = build_report(files.calibration, files.seams, files.part_glb)
    assert files.part_glb is None
    for seam, columns in zip(files.seams["seams"], frames_of(page), strict=True):
        assert columns["u95"] == [round(frame["u95_mm"], 6) for frame in seam["frames"]]
        assert columns["s"] == [round(frame["s_mm"], 4) for frame in seam["frames"]]
        assert columns["position"] == [frame["position"] for frame in seam["frames"]]
    found = re.search(r'id="data">(.*?)</script>', page)
    assert json.loads(found[1])["calibration"] == files.calibration


def test_a_seam_in_vertical_travel_has_no_rotation(folder: Path) -> None:
    files = read_result_folder(folder)
    files.seams["seams"][1]["frames"][0]["rotation_deg"] = None
    columns = frames_of(build_report(files.calibration, files.seams))
    assert columns[1]["rotation"][0] is None
    assert columns[1]["rotation"][1] is not None


def test_the_command_writes_one_file_and_keeps_what_exists(folder: Path) -> None:
    run = CliRunner().invoke(report, [str(folder)], standalone_mode=False)
    assert run.return_value == 0
    assert run.output.startswith(f"wrote {folder / 'report.html'}\n")
    with pytest.raises(InputError, match="allow overwriting"):
        CliRunner().invoke(report, [str(folder)], standalone_mode=False, catch_exceptions=False)
    other = folder / "other.html"
    CliRunner().invoke(report, [str(folder), "-o", str(other)], standalone_mode=False, catch_exceptions=False)
    assert other.read_bytes() == (folder / "report.html").read_bytes()


def test_a_missed_tolerance_ends_with_code_1(folder: Path) -> None:
    change(folder / "calibration.json", verdict="FAIL")
    run = CliRunner().invoke(report, [str(folder)], standalone_mode=False)
    assert run.return_value == 1
    assert (folder / "report.html").exists()


def remove_seams(folder: Path) -> None:
    (folder / "seams.json").unlink()


def break_mesh(folder: Path) -> None:
    (folder / "part.glb").write_bytes(b"glTF")


def other_frame(folder: Path) -> None:
    change(folder / "seams.json", frame="part")


def other_pose(folder: Path) -> None:
    change(folder / "calibration.json", T_base_part=np.eye(4).tolist())


def drop_points(folder: Path) -> None:
    record = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))
    del record["points"]
    (folder / "calibration.json").write_text(json.dumps(record), encoding="utf-8")


def odd_seams(folder: Path) -> None:
    change(folder / "seams.json", seams=[{"name": "W1"}])


@pytest.mark.parametrize(
    ("spoil", "kind", "message"),
    [
        (remove_seams, InputError, "holds no seams.json"),
        (break_mesh, FormatError, "part.glb"),
        (other_frame, FrameError, "frame 'base'"),
        (other_pose, FormatError, "two calibrations"),
        (drop_points, FormatError, "lacks points"),
        (odd_seams, FormatError, "not a complete seams file"),
    ],
)
def test_files_that_do_not_fit_are_refused(folder: Path, spoil: Any, kind: type[WpcalError], message: str) -> None:
    spoil(folder)
    with pytest.raises(kind, match=message):
        CliRunner().invoke(report, [str(folder)], standalone_mode=False, catch_exceptions=False)
    assert not (folder / "report.html").exists()


def test_a_folder_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        read_result_folder(tmp_path / "none")


def test_the_pose_is_there_in_the_notation_of_every_pendant(folder: Path) -> None:
    files = read_result_folder(folder)
    found = re.search(r'id="data">(.*?)</script>', build_report(files.calibration, files.seams))
    T_base_part = RigidTransform.from_matrix(files.calibration["T_base_part"], target="base", source="part")
    assert json.loads(found[1])["pendant"] == {n.maker: n.orientation_text(T_base_part) for n in NOTATIONS}
