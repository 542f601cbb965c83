"""Plain formats, and those of planning libraries, read back by what reads them there."""

import csv
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.record_checks import check_record
from tests.running import run_here
from wpcal.formats.compas import write_compas
from wpcal.formats.plain import write_program_csv, write_program_json
from wpcal.formats.ros import write_ros
from wpcal.formats.tesseract import write_tesseract


def test_json_keeps_every_digit_and_follows_its_schema(make_program):
    program = make_program(1)
    files = write_program_json(program)
    record = json.loads(files["WPCAL.program.json"])
    jsonschema.Draft202012Validator(json.loads(files["program-1.schema.json"])).validate(record)
    poses = record["seams"][0]["poses"]
    np.testing.assert_array_equal([pose["p_mm"] for pose in poses], program.paths[0].p_base)
    np.testing.assert_array_equal([pose["R"] for pose in poses], program.paths[0].R_base)


def test_csv_keeps_every_digit_and_says_frame_and_sense(make_program):
    program = make_program(1, names=('a,"b"\n', "W2"))
    rows = list(csv.DictReader(io.StringIO(write_program_csv(program)["WPCAL.program.csv"])))
    assert [row["seam"] for row in rows[:16]] == ['a,"b"\n'] * 16
    assert {(row["frame"], row["z_sense"]) for row in rows} == {("base", "inward")}
    p = np.array([[float(row[key]) for key in ("x_mm", "y_mm", "z_mm")] for row in rows])
    R = np.array([[float(row[f"r{i}{j}"]) for i in (1, 2, 3) for j in (1, 2, 3)] for row in rows]).reshape(-1, 3, 3)
    np.testing.assert_array_equal(p, np.concatenate([path.p_base for path in program.paths]))
    np.testing.assert_array_equal(R, np.concatenate([path.R_base for path in program.paths]))
    assert [row["role"] for row in rows[:3]] == ["approach", "weld", "weld"]
    assert rows[0]["u95_mm"] == ""


GOLDEN = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("offset")
    done = run_here("export", GOLDEN, "-f", "offset", "-o", folder)
    assert done.returncode == 0, done.stderr
    return folder / "offset"


@pytest.mark.parametrize(
    ("name", "place", "turn", "sequence"),
    [
        ("WPCAL.SPF", r"CTRANS\(X,(.*?),Y,(.*?),Z,(.*?)\)", r"CROT\(X,(.*?),Y,(.*?),Z,(.*?)\)", "ZYX"),
        ("WPCAL.H", r"7\.1 X(\S+)\n.*7\.2 Y(\S+)\n.*7\.3 Z(\S+)\n", r"SPA(\S+) SPB(\S+) SPC(\S+) ", "xyz"),
    ],
)
def test_the_datum_is_the_pose(written: Path, name: str, place: str, turn: str, sequence: str) -> None:
    text = (written / name).read_text()
    p, angles = (np.array(re.search(each, text).groups(), dtype=float) for each in (place, turn))  # type: ignore[union-attr]
    # Sinumerik: about Z, then the new Y, then the new X; Heidenhain: about fixed X, then Y, then Z
    R = Rotation.from_euler(sequence, angles if sequence == "xyz" else angles[::-1], degrees=True).as_matrix()
    T = np.array(json.loads((GOLDEN / "calibration.json").read_text())["T_base_part"])
    assert np.abs(p - T[:3, 3]).max() <= 1e-4
    assert np.abs(R - T[:3, :3]).max() <= 1e-7


def test_a_tilt_that_a_rotation_about_z_leaves_out_is_told(written: Path) -> None:
    text = (written / "WPCAL.nc").read_text()
    T = np.array(json.loads((GOLDEN / "calibration.json").read_text())["T_base_part"])
    tilt = np.arccos(T[2, 2])
    (off,) = re.findall(r"NOT LEVEL: .* 100 mm away that is (\S+) mm", text)
    assert float(off) == pytest.approx(100.0 * np.sin(tilt), abs=0.01)
    assert max(map(len, text.splitlines())) <= 120


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
    """Each seam has the speed of its own weld data or plan; the file, which has no arc, does not say that one burns."""
    first, second = make_program(n=5, names=('odd: "name"\n- x', "W2")).paths
    leaning = replace(second.seam, lean_rad=np.radians([[20.0, -10.0]] * 3))
    files = write_ros(replace(make_program(), paths=(first, replace(second, seam=leaning, speed_mm_s=3.0))))
    assert "work angle 0 to 20 deg, travel -10 to 0 deg" in files["WPCAL.sidecar.yaml"]
    assert not re.search("SEAM START|ARC ON", files["WPCAL.sidecar.yaml"])
    sidecar = yaml.safe_load(files["WPCAL.sidecar.yaml"])
    check_record(sidecar)
    assert [seam["name"] for seam in sidecar["seams"]] == ['odd: "name"\n- x', "W2"]
    seam = sidecar["seams"][0]
    assert len(ros_poses(files[seam["file"]])[0]) == len(seam["roles"]) == len(seam["error_95_m"])
    assert seam["roles"] == ["approach", "weld", "weld", "weld", "retract"]
    assert seam["error_95_m"] == [None, 0.00025, 0.00025, 0.00025, None]
    assert [seam["weld_speed_m_s"] for seam in sidecar["seams"]] == [0.008, 0.003]


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
