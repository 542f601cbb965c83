"""The triangles of a part whose bodies moved: what torches and robots are compared with."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np

from wpcal.brep.mesh_glb import read_part_glb
from wpcal.brep.moved_mesh import moved_glb, read_moved_glb

GOLDEN = Path(__file__).parents[3] / "fixtures" / "uprights" / "golden"
STEP_MM = 0.01  #: Larger than the step of the coordinates in the file.


def test_every_solid_is_where_its_body_is() -> None:
    data = (GOLDEN / "part.glb").read_bytes()
    calibration = json.loads((GOLDEN / "calibration.json").read_text())
    motion = {body["name"]: np.array(body["T_part_moved"]) for body in calibration["bodies"]["bodies"]}
    model, moved = read_part_glb(data), read_part_glb(moved_glb(data, calibration))
    assert moved.sha256 == model.sha256
    for old, new in zip(model.solids, moved.solids, strict=True):
        T = motion[old.name]
        np.testing.assert_allclose(new.points, old.points @ T[:3, :3].T + T[:3, 3], rtol=0, atol=STEP_MM)
        assert new.color_rgb == old.color_rgb
        assert len(new.triangles) == len(old.triangles)
    assert max(np.abs(new.points - old.points).max() for old, new in zip(model.solids, moved.solids, strict=True)) > 0.2


def test_a_rigid_part_stays_as_it_is() -> None:
    data = (GOLDEN / "part.glb").read_bytes()
    assert moved_glb(data, {"schema": "wpcal/calibration/1"}) is data


def test_triangles_without_a_calibration_beside_them_stay(tmp_path: Path) -> None:
    shutil.copy(GOLDEN / "part.glb", tmp_path)
    assert read_moved_glb(tmp_path / "part.glb") == (GOLDEN / "part.glb").read_bytes()
    shutil.copy(GOLDEN / "calibration.json", tmp_path)
    assert read_moved_glb(tmp_path / "part.glb") != (GOLDEN / "part.glb").read_bytes()
