"""Formats of planning libraries, read back by what reads them there: YAML, JSON and Python."""

import json

import numpy as np
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.record_checks import check_record
from wpcal.formats.compas import write_compas
from wpcal.formats.ros import write_ros
from wpcal.formats.tesseract import write_tesseract

ATOL_MM = 1e-6  #: Nine decimals of a metre in three coordinates: 0.9e-6.
ATOL_DEG = 2e-7  #: Nine decimals of a quaternion: 2e-9 rad.
ROUND_OFF_MM = 1e-9
ROUND_OFF_DEG = 1e-6  #: The angle between equal rotations comes out of a cosine: the root of round-off, in degrees.


def ros_poses(text):
    message = yaml.safe_load(text)
    assert message["header"]["frame_id"] == "base"
    p = [[pose["position"][key] * 1000.0 for key in "xyz"] for pose in message["poses"]]
    q = [[pose["orientation"][key] for key in "xyzw"] for pose in message["poses"]]
    return p, Rotation.from_quat(q).as_matrix()


@given(seed=st.integers(0, 2**32))
def test_pose_arrays_are_read_back(make_program, assert_same_poses, seed):
    program = make_program(seed)
    p, R = ros_poses(write_ros(program)["W1.pose_array.yaml"])
    assert_same_poses(p, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


def test_the_sidecar_has_names_roles_and_errors_row_by_row(make_program):
    program = make_program(n=5, names=('odd: "name"\n- x', "W2"))
    files = write_ros(program)
    sidecar = yaml.safe_load(files["WPCAL.sidecar.yaml"])
    check_record(sidecar)
    assert [seam["name"] for seam in sidecar["seams"]] == ['odd: "name"\n- x', "W2"]
    seam = sidecar["seams"][0]
    assert len(ros_poses(files[seam["file"]])[0]) == len(seam["roles"]) == len(seam["error_95_m"])
    assert seam["roles"] == ["approach", "weld", "weld", "weld", "retract"]
    assert seam["error_95_m"] == [None, 0.00025, 0.00025, 0.00025, None]
    assert sidecar["z_sense"] == "inward"


@given(seed=st.integers(0, 2**32))
def test_compas_frames_are_read_back(make_program, assert_same_poses, seed):
    program = make_program(seed)
    record = json.loads(write_compas(program)["WPCAL.compas.json"])
    assert record["units"] == {"length": "mm"}
    seam = record["seams"][0]
    frames = [seam["approach"], *seam["weld"], seam["retract"]]
    assert {frame["dtype"] for frame in frames} == {"compas.geometry/Frame"}
    data = [frame["data"] for frame in frames]
    x, y = (np.array([frame[key] for frame in data]) for key in ("xaxis", "yaxis"))
    R = np.stack([x, y, np.cross(x, y)], axis=2)
    assert_same_poses([frame["point"] for frame in data], R, program, atol_mm=ROUND_OFF_MM, atol_deg=ROUND_OFF_DEG)


@given(seed=st.integers(0, 2**32))
def test_the_tesseract_module_holds_the_poses(make_program, assert_same_poses, seed):
    program = make_program(seed, names=("it's \\ 'W1'",))
    module = {}
    exec(compile(write_tesseract(program)["WPCAL_tesseract.py"], "WPCAL_tesseract.py", "exec"), module)
    table = np.array(module["SEAMS"]["it's \\ 'W1'"])
    R = Rotation.from_quat(table[:, 3:], scalar_first=True).as_matrix()
    assert_same_poses(table[:, :3] * 1000.0, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)
