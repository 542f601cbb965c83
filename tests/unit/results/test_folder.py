import hashlib
import json

import numpy as np
import pytest

from wpcal.brep.mesh import PartMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.controllers.program import MotionSettings, build_program
from wpcal.core.errors import FormatError, FrameError, GeometryError, InputError
from wpcal.results.agree import SAME_POSE_MM, require_as_written
from wpcal.results.folder import read_finished, read_result_folder
from wpcal.robot.torch.attitude import TorchSettings

ROUND_OFF_MM = 1e-9


def test_the_seams_are_read_in_the_base_with_their_errors(finished_folder):
    finished = read_finished(finished_folder())
    assert [seam.name for seam in finished.seams] == ["W1", "W2", "Kehlnaht Ü/3"]
    assert finished.seams[0].frames.frame == "base"
    np.testing.assert_array_equal(finished.u95_mm[0], 0.2)


def test_accepted_seams_are_selected_unless_told_otherwise(finished_folder):
    finished = read_finished(finished_folder())
    assert [seam.name for seam in finished.select().seams] == ["W1", "Kehlnaht Ü/3"]
    assert [seam.name for seam in finished.select(["W2"]).seams] == ["W2"]
    assert len(finished.select(everything=True).seams) == 3
    with pytest.raises(InputError, match="unknown seam W9; there are W1, W2"):
        finished.select(["W9"])


def test_nothing_accepted_is_said(finished_folder):
    finished = read_finished(finished_folder(accepted=(False, False, False)))
    with pytest.raises(InputError, match="none of the 3 seams is accepted"):
        finished.select()


@pytest.mark.parametrize(
    ("file", "key", "value", "error", "message"),
    [
        ("seams.json", "frame", "part", FrameError, "expected seams in the frame 'base', got 'part'"),
        ("seams.json", "robot_space", "identified", FrameError, "give the file of that robot"),
        ("calibration.json", "T_base_part", np.eye(4).tolist(), FormatError, "two calibrations"),
        ("calibration.json", "T_base_part", [[1]], InputError, "T_base_part: expected 4 entries, got 1"),
        ("seams.json", "schema", "wpcal/seams/9", FormatError, "expected a record of schema wpcal/seams/1"),
    ],
)
def test_folders_that_do_not_fit_together_are_refused(finished_folder, file, key, value, error, message):
    folder = finished_folder()
    record = json.loads((folder / file).read_text())
    (folder / file).write_text(json.dumps({**record, key: value}))
    with pytest.raises(error, match=message):
        read_finished(folder)


@pytest.mark.parametrize("name", ["part.glb", "a.calibrated.step"])
def test_a_file_of_another_run_is_refused(finished_folder, name):
    folder = finished_folder()
    (folder / name).write_bytes(b"the file of this run")
    record = json.loads((folder / "calibration.json").read_text())
    record["files"] = {name: hashlib.sha256(b"the file of this run").hexdigest()}
    (folder / "calibration.json").write_text(json.dumps(record))
    require_as_written(folder, also=[name])
    (folder / name).write_bytes(b"the file of another run")
    with pytest.raises(FormatError, match=f"{name}: was changed after wpcal calibrate wrote it"):
        read_result_folder(folder)
    (folder / name).unlink()
    require_as_written(folder, also=[name])


@pytest.mark.parametrize(("name", "what"), [("none", "no such folder"), ("a", "is not a folder"), (".", "holds no c")])
def test_what_is_not_the_folder_of_a_result_is_refused(tmp_path, name, what):
    (tmp_path / "a").touch()
    with pytest.raises(InputError, match=f"{what}.*; expected the folder of a finished calibration$"):
        read_finished(tmp_path / name)


def test_approach_and_retract_stand_back_along_the_wire_and_the_tool_by_its_standoff(finished_folder, golden):
    finished = read_finished(finished_folder()).select(["W1"])
    torch, motion = TorchSettings(standoff_mm=15.0), MotionSettings(approach_mm=40.0, retract_mm=60.0)
    path = build_program(finished, torch=torch, motion=motion).paths[0]
    up = finished.seams[0].frames.R[:, :, 2]
    p = finished.seams[0].frames.p
    expected = np.concatenate([p[:1] + 55.0 * up[:1], p + 15.0 * up, p[-1:] + 75.0 * up[-1:]])
    np.testing.assert_allclose(path.p_base, expected, rtol=0, atol=ROUND_OFF_MM)
    golden(path)


def test_a_seam_of_one_frame_is_refused(finished_folder):
    folder = finished_folder()
    record = json.loads((folder / "seams.json").read_text())
    record["seams"][0]["frames"] = record["seams"][0]["frames"][:1]
    (folder / "seams.json").write_text(json.dumps(record))
    with pytest.raises(GeometryError, match="seam W1: expected at least 2 frames"):
        build_program(read_finished(folder).select(["W1"]))


@pytest.mark.parametrize("settings", [{"approach_mm": -1.0}, {"speed_mm_s": 0.0}, {"air_speed_mm_s": float("nan")}])
def test_impossible_motions_are_refused(settings):
    with pytest.raises(InputError):
        MotionSettings(**settings)


def test_a_mesh_of_another_part_is_refused_by_every_reader(finished_folder):
    folder = finished_folder()
    (folder / "part.glb").write_bytes(write_part_glb(PartMesh((), 0.1, 0.5, sha256="0" * 64)))
    for read in (read_finished, read_result_folder):
        with pytest.raises(FormatError, match=r"part\.glb: was made from another STEP file"):
            read(folder)


def test_a_difference_of_the_poses_beyond_round_off_is_refused_by_every_reader(finished_folder):
    folder = finished_folder()
    record = json.loads((folder / "calibration.json").read_text())
    pose = np.array(record["T_base_part"])
    for off_mm, agrees in ((0.5 * SAME_POSE_MM, True), (100 * SAME_POSE_MM, False)):
        pose[0, 3] += off_mm
        (folder / "calibration.json").write_text(json.dumps({**record, "T_base_part": pose.tolist()}))
        for read in (read_finished, read_result_folder):
            if agrees:
                read(folder)
                continue
            with pytest.raises(FormatError, match="two calibrations"):
                read(folder)


def test_a_record_that_lacks_a_field_is_refused(finished_folder):
    folder = finished_folder()
    record = json.loads((folder / "seams.json").read_text())
    del record["robot_space"]
    (folder / "seams.json").write_text(json.dumps(record))
    with pytest.raises(FormatError, match=r"seams\.json: lacks robot_space"):
        read_finished(folder)
