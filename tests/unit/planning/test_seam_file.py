import json
from dataclasses import replace

import numpy as np
import pytest

from tests.saddle import CELLS
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.plan.seam_file import read_seam_path
from wpcal.robot.kinematics.arm_file import find_arm

ROUND_OFF_MM = 1e-9  #: There and back by a transform of a metre.


@pytest.fixture
def record():
    return json.loads((CELLS / "saddle-seams.json").read_text(encoding="utf-8"))


def written(tmp_path, record):
    file = tmp_path / "seams.json"
    file.write_text(json.dumps(record), encoding="utf-8")
    return file


def in_base(record):
    T = RigidTransform(rotation_from_zyx(0.1, 0.2, 0.3), [800.0, -200.0, 150.0], "base", "part")
    for frame in record["seams"][0]["frames"]:
        frame["p_mm"] = T.apply(frame["p_mm"]).tolist()
        frame["R"] = (T.R @ frame["R"]).tolist()
        frame["q_xyzw"] = quaternion_from_rotation(frame["R"]).tolist()
    return {**record, "frame": "base", "T_base_part": T.matrix.tolist()}


def test_frames_in_the_base_are_brought_back_to_the_part(tmp_path, cell, path, record):
    moved = read_seam_path(written(tmp_path, in_base(record)), "W1", cell)
    np.testing.assert_allclose(moved.p, path.p, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(moved.R, path.R, rtol=0, atol=ROUND_OFF_MM)


def test_bad_files_say_what_is_wrong(tmp_path, cell, record):
    with pytest.raises(InputError, match="no seam 'W9'; the file has W1"):
        read_seam_path(written(tmp_path, record), "W9", cell)
    with pytest.raises(FormatError, match="expected a record of schema wpcal/seams/1, found wpcal/seams/2"):
        read_seam_path(written(tmp_path, {**record, "schema": "wpcal/seams/2"}), "W1", cell)
    with pytest.raises(FormatError, match="T_base_part is missing"):
        read_seam_path(written(tmp_path, {**in_base(record), "T_base_part": None}), "W1", cell)


def test_seams_of_an_identified_robot_need_that_robot_in_the_cell(tmp_path, cell, path, record):
    identified = {**in_base(record), "robot_space": "identified"}
    with pytest.raises(FrameError, match="identified robot space and robot 1 of the cell"):
        read_seam_path(written(tmp_path, identified), "W1", cell)
    arm = find_arm("mh6")
    own = replace(cell, arm=arm.as_identified(arm.chain.with_table(arm.chain.table)))
    assert len(read_seam_path(written(tmp_path, identified), "W1", own)) == len(path)
