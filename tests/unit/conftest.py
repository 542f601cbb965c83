"""Weld programs made by hand: any poses, any names, any place of the part."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.controllers.program import ControllerSettings, WeldPath, WeldProgram
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.seam.record import seams_record
from wpcal.seam.seam import JointType, Seam, SeamFrames, SeamPieces, WeldType

TEE_GOLDEN = Path(__file__).parents[2] / "fixtures" / "tee" / "golden"
CONFIGURATIONS = {"fanuc": "N U T, 0, 0, 0", "inform": "1,0,0,0,0,0,0,0"}
QUARTER = np.pi / 2  #: Rotations about y by a quarter turn are where Rz Ry Rx angles lose one degree of freedom.


def _seam(name, p, R, *, accepted=True, frame="part"):
    pieces = SeamPieces(*(np.zeros(1, dtype=np.int64),) * 5, np.zeros((1, 3)))
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    frames = SeamFrames(s, p, R, np.full(len(p), np.pi / 2), frame)
    length = float(s[-1])
    return Seam(name, JointType.TEE, WeldType.FILLET, ("a", "b"), pieces, False, length, True, accepted, (), frames)


@pytest.fixture(scope="session")
def make_seam():
    return _seam


@pytest.fixture(scope="session")
def random_poses():
    """Poses up to 2 m from the base; every fourth is turned by a middle angle of ±90 degrees, exactly or nearly."""

    def make(seed, n=16):
        rng = np.random.default_rng(seed)
        p = rng.uniform(-2000, 2000, (n, 3))
        R = Rotation.random(n, rng=rng).as_matrix()
        sign = rng.choice([-1.0, 1.0], n)
        for i in range(0, n, 4):
            away = 0.0 if i % 8 == 0 else 10.0 ** rng.uniform(-9, -2)
            angles = [rng.uniform(-np.pi, np.pi), sign[i] * (QUARTER - away), rng.uniform(-np.pi, np.pi)]
            R[i] = Rotation.from_euler("ZYX", angles).as_matrix()
        return p, R

    return make


@pytest.fixture(scope="session")
def random_place():
    def make(seed):
        rng = np.random.default_rng(seed + 1_000_000)
        R = Rotation.random(rng=rng).as_matrix()
        return RigidTransform(R, rng.uniform(-2000, 2000, 3), "base", "part")

    return make


@pytest.fixture(scope="session")
def make_program(random_poses, random_place):
    """A program whose tool poses in the frame of the part are random: gimbal poses stay gimbal poses in the files."""

    def make(seed=0, *, n=16, names=("W1",), T_base_part=None, **settings):
        T = T_base_part or random_place(seed)
        paths = []
        for number, name in enumerate(names):
            p, R = random_poses(seed + number, n)
            p_base, R_base = T.apply(p), T.R @ R
            seam = _seam(name, p_base[1:-1], R_base[1:-1], frame="base")
            paths.append(WeldPath(seam, p_base, R_base, np.full(n - 2, 0.25)))
        record = {"verdict": "PASS", "tolerance_mm": 0.5}
        settings.setdefault("controller", ControllerSettings(configurations=CONFIGURATIONS))
        return WeldProgram(tuple(paths), T, calibration=record, **settings)

    return make


@pytest.fixture(scope="session")
def assert_same_poses():
    def check(found_p, found_R, program, *, atol_mm, atol_deg):
        p = np.concatenate([path.p_base for path in program.paths])
        R = np.concatenate([path.R_base for path in program.paths])
        off_mm = np.linalg.norm(np.asarray(found_p) - p, axis=1)
        off_deg = np.degrees((Rotation.from_matrix(R).inv() * Rotation.from_matrix(found_R)).magnitude())
        assert len(found_p) == len(p)
        assert off_mm.max() <= atol_mm
        assert off_deg.max() <= atol_deg

    return check


@pytest.fixture(scope="session")
def assert_is_the_part():
    """The frame of a file is the part as calibrated: points relative to it are then those of the STEP file."""

    def check(p, R, program, *, atol_mm, atol_deg):
        T = program.T_base_part
        assert np.linalg.norm(p - T.t_mm) <= atol_mm
        assert np.degrees((Rotation.from_matrix(T.R).inv() * R).magnitude()) <= atol_deg

    return check


BOX = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
BOX_TRIANGLES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def box_mesh(name, low, high):
    """A box of triangles, counter-clockwise seen from outside."""
    p = np.asarray(low) + BOX * (np.asarray(high, dtype=np.float64) - low)
    return SolidMesh(name, p, BOX_TRIANGLES, np.zeros((0, 2), dtype=np.int64))


def plate(*others, sha256=None):
    """The plate under the seams of a finished folder, and other solids."""
    return PartMesh((box_mesh("plate", (-20, -50, -10), (120, 50, 0)), *others), 0.01, 0.5, sha256)


def write_finished_folder(
    folder, T, *, verdict="PASS", names=("W1", "W2", "Kehlnaht Ü/3"), accepted=(True, False, True), spacing_mm=0.0
):
    """A folder like that of `wpcal calibrate`: an accepted seam, a candidate, and one with an awkward name."""
    x = np.linspace(0.0, 100.0, 11)
    R = np.broadcast_to(np.eye(3), (11, 3, 3))
    lines = [np.stack([x, np.full(11, row * spacing_mm), np.zeros(11)], axis=1) for row in range(len(names))]
    seams = [_seam(name, p, R, accepted=ok) for name, p, ok in zip(names, lines, accepted, strict=True)]
    folder.mkdir()
    record = seams_record(seams, T, [np.full(11, 0.2)] * len(seams))
    (folder / "seams.json").write_text(to_json(record), encoding="utf-8")
    kept = json.loads((TEE_GOLDEN / "calibration.json").read_text(encoding="utf-8"))
    calibration = {**kept, "verdict": verdict, "tolerance_mm": 0.5, "T_base_part": T.matrix.tolist()}
    (folder / "calibration.json").write_text(json.dumps(calibration), encoding="utf-8")
    (folder / "part.glb").write_bytes(write_part_glb(plate(sha256=kept["inputs"]["part"]["sha256"])))
    return folder


@pytest.fixture
def finished_folder(tmp_path, random_place):
    """A function that writes such a folder, its part at a random place."""
    return lambda **settings: write_finished_folder(tmp_path / "calibrated", random_place(7), **settings)
