"""A folder whose seams are not poses is refused by every format; nothing is written."""

import json

import numpy as np
import pytest

from wpcal.cli.main import run
from wpcal.controllers.registry import exporter_names
from wpcal.core.errors import FormatError
from wpcal.results.folder import read_finished

SHEARED, MIRRORED = (np.eye(3) + np.eye(3, k=1) * 0.1).tolist(), np.diag([1.0, 1.0, -1.0]).tolist()
BAD_FRAMES = {
    "nan in p": ("p_mm", [float("nan"), 0, 0], "point 3: p_mm"),
    "inf in p": ("p_mm", [0, float("inf"), 0], "point 3: p_mm"),
    "kilometres": ("p_mm", [0, 0, 1e12], "point 3: p_mm"),
    "two numbers": ("p_mm", [0, 0], "point 3: p_mm"),
    "text in p": ("p_mm", [0, 0, "1"], "point 3: p_mm"),
    "no numbers": ("p_mm", None, "point 3: p_mm"),
    "a ragged R": ("R", [[1, 0, 0], [0, 1], [0, 0, 1]], r"point 3: R\[1\]: expected 3 entries, got 2"),
    "nan in R": ("R", [[float("nan")] * 3] * 3, r"point 3: R\[0\]\[0\]: expected a number"),
    "zero": ("R", np.zeros((3, 3)).tolist(), "point 3: R: is not a rotation"),
    "sheared": ("R", SHEARED, "point 3: R: is not a rotation"),
    "mirrored": ("R", MIRRORED, "point 3: R: is a mirror image"),
    "of another R": ("q_xyzw", [1, 0, 0, 0], "point 3: q_xyzw: expected the quaternion of R"),
    "nan in s": ("s_mm", float("nan"), "point 3: s_mm"),
    "a step back": ("s_mm", 5.0, "point 3: s_mm: expected more than 20"),
    "true for a number": ("angle_deg", True, "point 3: angle_deg"),
    "an angle in text": ("angle_deg", "90", "point 3: angle_deg"),
    "a negative error": ("u95_mm", -1.0, "point 3: u95_mm"),
}
BAD_SEAMS = {
    "no": ("accepted", "no", "accepted: expected true or false, got 'no'"),
    "zero for no": ("accepted", 0, "accepted: expected true or false"),
    "null": ("closed", None, "closed: expected true or false"),
    "an infinite length": ("length_mm", float("inf"), "length_mm"),
    "a nameless seam": ("name", None, "name: expected a text"),
    "the name of another": ("name", "W2", "two seams are named W2"),
    "frames that are no list": ("frames", 3, "seam W1: frames: expected a list, got 3"),
    "sure as text": ("confidence", "sure", "confidence: expected a number from 0 to 1"),
}


def edit(folder, change):
    record = json.loads((folder / "seams.json").read_text())
    change(record["seams"][0])
    (folder / "seams.json").write_text(json.dumps(record))


@pytest.mark.parametrize("case", BAD_FRAMES)
def test_a_point_that_is_no_pose_is_named(finished_folder, case):
    field, value, message = BAD_FRAMES[case]
    folder = finished_folder()
    edit(folder, lambda seam: seam["frames"][3].update({field: value}))
    with pytest.raises(FormatError, match=f"seams.json: seam W1: {message}"):
        read_finished(folder)


@pytest.mark.parametrize("case", BAD_SEAMS)
def test_a_seam_with_a_wrong_field_is_named(finished_folder, case):
    field, value, message = BAD_SEAMS[case]
    folder = finished_folder()
    edit(folder, lambda seam: seam.update({field: value}))
    with pytest.raises(FormatError, match=message):
        read_finished(folder)


@pytest.mark.parametrize("format_name", exporter_names())
def test_no_format_writes_it(finished_folder, format_name, tmp_path, capsys):
    folder = finished_folder()
    edit(folder, lambda seam: seam["frames"][3].update(R=MIRRORED))
    with pytest.raises(SystemExit) as ended:
        run(["export", str(folder), "-f", format_name, "-o", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert "seam W1: point 3: R: is a mirror image" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
