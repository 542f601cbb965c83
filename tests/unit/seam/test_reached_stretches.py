"""Seams are cut where the nozzle has no room, and at every station that stays the torch with its lean meets nothing."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.material import ExactMaterial
from wpcal.brep.near_groups import NearBundles
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.motion import APPROACH_MM
from wpcal.core.records import to_json
from wpcal.core.tangent import exp_rotation
from wpcal.robot.torch.attitude import TorchSettings, tool_rotations, wire_directions
from wpcal.robot.torch.file import find_torch
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import Seam, SeamOptions, StepOptions
from wpcal.seam.judge.leans import Leans, back_directions
from wpcal.seam.judge.material import Necks, find_poses_in_material
from wpcal.seam.judge.reach import find_in_ways
from wpcal.seam.judge.stations import _path, start_mm
from wpcal.seam.judge.torch_neck import neck_faces
from wpcal.seam.options import Reach
from wpcal.seam.record import seams_from_record, seams_record

PARTS = (
    "tee-beside-block",
    "tee-under-bar",
    "crossed-tee",
    "gusseted-bracket",
    "boss-with-ribs",
    "tee-beside-bolt",
    "frame",
    "saddle",
)
LEANS_RAD = Leans.of(Reach()).rad
BETWEEN_MM = 0.7  #: The torch is checked at this step between stations, which is not the step with which it was felt.
CUT_MM = 1.01  #: Stretches end within this, on the free side, plus round-off.


def poses_between(seam: Seam) -> tuple[np.ndarray, np.ndarray]:
    """Tips and directions of the torch along a seam as a program moves it: linear from station to station."""
    assert seam.lean_rad is not None
    back = back_directions(seam.frames.R, seam.lean_rad)
    s = np.arange(0.0, seam.length_mm, BETWEEN_MM)
    p, way = (
        np.stack([np.interp(s, seam.frames.s_mm, column) for column in rows.T], axis=1)
        for rows in (seam.frames.p, back)
    )
    return p, way / np.linalg.norm(way, axis=1, keepdims=True)


@pytest.mark.parametrize("name", PARTS)
def test_the_torch_meets_nothing_along_accepted_seams(name: str) -> None:
    graph = saved_graph(name)
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    seams = [seam for seam in saved_seams(name) if seam.accepted]
    assert seams
    for seam in seams:
        torch = USUAL_TORCH.with_more_wire(seam.more_wire_mm)
        assert len(find_poses_in_material(material, *poses_between(seam), torch, start_mm=start_mm(seam))) == 0


def test_a_lean_changes_no_faster_than_asked_or_the_seam_says_where() -> None:
    changes = 0
    for name in ("boss-with-ribs", "tee-under-bar"):
        for seam in saved_seams(name):
            if not seam.accepted or seam.lean_rad is None:
                continue
            turn = np.degrees(np.linalg.norm(np.diff(seam.lean_rad, axis=0), axis=1))
            fast = turn > Reach().lean_deg_per_mm * np.diff(seam.frames.s_mm) + 1e-4
            changes += int((turn > 0.0).sum())
            assert fast.any() == any("it is not free there at 5 deg per mm" in reason for reason in seam.reasons)
            assert not fast.any(), (name, seam.name, turn[fast], np.diff(seam.frames.s_mm)[fast])
    assert changes > 0


def test_a_block_beside_the_joint_leaves_the_stretches_at_its_ends() -> None:
    graph = saved_graph("tee-beside-block")
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    on = [seam for seam in saved_seams("tee-beside-block") if seam.frames.p[0, 1] == seam.frames.p[-1, 1] == 46.0]
    assert [seam.accepted for seam in on] == [True, False, True]
    before, blocked, after = sorted(on, key=lambda seam: float(seam.frames.p[0, 0]))
    assert blocked.blocked_by == ("block",)
    assert not blocked.inside
    low, high = blocked.frames.p[[0, -1], 0]
    assert low + high == pytest.approx(240.0, abs=CUT_MM)  # the block is in the middle, from 100 to 140
    assert 90.0 < low < 110.0
    assert "with every lean it meets block, from (" in blocked.against[0]
    assert any(
        "30.0 mm of which the torch does not reach (85.0 to 115.0 mm from the start): block is in its way" in reason
        for reason in before.reasons
    )
    assert before.length_mm + blocked.length_mm + after.length_mm == pytest.approx(200.0, abs=1e-6)
    inner = blocked.frames.p + np.clip(120.0 - blocked.frames.p[:, :1], -CUT_MM, CUT_MM) * [1.0, 0.0, 0.0]
    for lean in LEANS_RAD:
        back = back_directions(blocked.frames.R, lean)
        assert len(find_poses_in_material(material, inner, back)) == len(inner)


def test_no_seam_passes_under_a_bar_that_the_torch_cannot_pass() -> None:
    found, graph = saved_seams("tee-under-bar"), saved_graph("tee-under-bar")
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    seams = [seam for seam in found if seam.frames.p[:, 1:].tolist() == [[46.0, 10.0]] * len(seam.frames)]
    accepted = [seam for seam in seams if seam.accepted]
    assert len(accepted) == 2
    for seam in accepted:
        travel = seam.lean_rad[:, 1]
        assert travel.any()  # it leans away from the bar, to one side only
        assert travel.min() >= 0 or travel.max() <= 0
        R = tool_rotations(seam.frames.R, TorchSettings(), seam.lean_rad)
        come, go = (np.stack([seam.frames.p[end] - APPROACH_MM * R[end, :, 2], seam.frames.p[end]]) for end in (0, -1))
        ways = [(seam, seam.frames.p, R), (seam, come, R[[0, 0]]), (seam, go, R[[-1, -1]])]
        assert not any(find_in_ways(material, ways, USUAL_TORCH))
        assert any("no torch passes bar without leaving it" in reason for reason in seam.reasons)
    assert sum(seam.length_mm for seam in accepted) == pytest.approx(200.0, abs=1e-6)


def test_the_torch_leans_away_from_a_wall_and_is_straight_elsewhere() -> None:
    seams = {s.name: s for s in saved_seams("crossed-tee") if s.accepted}
    (first,) = [s for s in seams.values() if s.frames.p[-1].tolist() == [80.0, 46.0, 10.0]]  # it ends at the block
    assert first.lean_rad[-1, 1] > 0  # push: the torch stays behind the wire
    assert first.lean_rad[-1, 0] == 0
    assert not first.lean_rad[:-3].any()
    assert any(np.array_equal(first.lean_rad[-1], lean) for lean in LEANS_RAD)


def test_coarse_stations_are_felt_between_them() -> None:
    coarse = SeamOptions(steps=StepOptions(chord_mm=1.0, max_step_mm=500.0))
    for options in (SeamOptions(), coarse):
        seams = saved_seams("tee-beside-block", options)
        blocked = [seam for seam in seams if seam.blocked_by == ("block",)]
        assert [round(seam.length_mm) for seam in blocked] == [30]


def test_leans_are_kept_in_the_record_and_taken_by_programs(golden: Any) -> None:
    found = [seam for seam in saved_seams("tee-beside-block") if seam.accepted or seam.blocked_by]
    read = seams_from_record(json.loads(to_json(seams_record(found))), path="seams.json")
    for seam, again in zip(found, read, strict=True):
        assert again.blocked_by == seam.blocked_by
        assert (again.lean_rad is None) == (seam.lean_rad is None)
        if seam.lean_rad is not None:
            np.testing.assert_allclose(again.lean_rad, seam.lean_rad, rtol=0, atol=1e-12)
        if seam.lean_rad is not None and not seam.blocked_by:
            torch = TorchSettings()
            wire = wire_directions(tool_rotations(again.frames.R, torch, again.lean_rad), torch.tool_axis)
            back = back_directions(seam.frames.R, seam.lean_rad)
            np.testing.assert_allclose(wire, -back, rtol=0, atol=1e-12)
    golden(read)


def test_a_lean_replaces_the_angles_of_the_user_only_where_there_is_one() -> None:
    R = np.tile(np.eye(3), (3, 1, 1))
    torch = TorchSettings(work_rad=0.1, travel_rad=-0.2)
    lean = np.array([[0.0, 0.0], [0.0, 0.3], [np.nan, np.nan]])
    found = tool_rotations(R, torch, lean)
    np.testing.assert_array_equal(found[[0, 2]], tool_rotations(R[:2], torch))
    np.testing.assert_array_equal(found[1:2], tool_rotations(R[:1], replace(torch, work_rad=0.0, travel_rad=0.3)))


@pytest.mark.parametrize(("bow_mm", "lean_rad"), [(0.0, 0.0), (0.01, 0.0), (0.0, 0.01)])
def test_only_along_a_straight_seam_that_does_not_turn_the_wire_is_felt_between_the_ends(bow_mm, lean_rad):
    frames = next(seam for seam in saved_seams("tee-beside-block") if seam.accepted).frames
    middle = np.arange(len(frames)) == len(frames) // 2
    turn = exp_rotation(lean_rad * frames.R[0, :, 0])
    R = np.where(middle[:, None, None], turn @ frames.R, frames.R)
    bent = replace(frames, p=frames.p + bow_mm * middle[:, None] * frames.R[0, :, 2], R=R)
    assert len(_path(bent)) == (2 if bow_mm == lean_rad == 0.0 else len(frames))


def test_a_neck_meets_no_face_beyond_those_that_are_compared_with_it(monkeypatch):
    trimmed, rng = TrimmedFaces.of(graph := saved_graph("crossed-tee")), np.random.default_rng(3)
    low, high = graph.vertex_p.min(axis=0) - 150.0, graph.vertex_p.max(axis=0) + 150.0
    back = rng.normal(size=(400, 3))
    bend = np.cross(back, rng.normal(size=back.shape))
    back, bend = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (back, bend))
    necks = Necks(find_torch("robot-22"), rng.uniform(low, high, back.shape), back, bend, np.zeros(len(back)))
    faces = neck_faces(graph, trimmed, np.arange(len(back)), necks, wider_mm=3.0)
    assert 0 < np.count_nonzero(faces >= 0) < len(faces)
    around = NearBundles.around
    monkeypatch.setattr(NearBundles, "around", lambda *given, within_mm: around(*given, within_mm=5000.0))
    np.testing.assert_array_equal(neck_faces(graph, trimmed, np.arange(len(back)), necks, wider_mm=3.0), faces)
