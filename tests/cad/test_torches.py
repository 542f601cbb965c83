"""Reach with torches that have a neck, with a longer wire, and the torch that is advised where one does not reach."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cad.kernel.primitives import box, prism
from cad.kernel.tessellate import tessellate
from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.bench_bracket import bench_bracket
from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import FloatArray
from wpcal.robot.torch.attitude import TorchSettings, tool_rotations
from wpcal.robot.torch.file import find_torch
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.judge.reach import find_in_ways
from wpcal.seam.judge.torch_neck import bend_directions
from wpcal.seam.options import Reach

Box = tuple[float, float, float, tuple[float, float, float]]
POINTS = 400  #: Random points in each piece of a torch, half of them on its surface.
ROOFED: dict[str, Box] = {
    "base": (400.0, 400.0, 10.0, (-200.0, 0.0, -10.0)),
    "web": (400.0, 8.0, 140.0, (-200.0, 0.0, 0.0)),
    "roof": (400.0, 400.0, 10.0, (-200.0, 0.0, 140.0)),
}
"""A channel on its side: the seam in its lower corner is open to one side, and the roof is over it."""


@cache
def found(torch: str, **ranges: tuple[float, float]) -> tuple[Seam, ...]:
    graph = to_brep([(name, box(*size)) for name, size in ROOFED.items()])
    return detect_seams(graph, SeamOptions(reach=replace(Reach(find_torch(torch)), **ranges)))


def in_corner(seams: tuple[Seam, ...]) -> list[Seam]:
    return [s for s in seams if np.abs(s.frames.p[:, 1:] - [8.0, 0.0]).max() < 1e-6]


def in_boxes(points: FloatArray, slack_mm: float = 1e-3) -> FloatArray:
    inside = np.zeros(len(points), dtype=bool)
    for x, y, z, low in ROOFED.values():
        corner, size = np.array(low), np.array([x, y, z])
        inside |= ((points > corner + slack_mm) & (points < corner + size - slack_mm)).all(axis=1)
    return inside


def points_of(torch: TorchShape, seam: Seam, rng: np.random.Generator) -> FloatArray:
    """Random points in nozzle, neck and body at all frames of a seam: built from the shape, not from the lines felt."""
    assert seam.lean_rad is not None
    torch = torch.with_more_wire(seam.more_wire_mm)
    n = len(seam.frames)
    back = back_directions(seam.frames.R, seam.lean_rad)
    bend = bend_directions(back, seam.frames.R, np.zeros(n) if seam.spin_rad is None else seam.spin_rad)
    frames = np.stack([bend, np.cross(back, bend), back], axis=2)
    low, front = torch.taper_mm, torch.front_mm
    tubes = [(tube.start, tube.end, tube.radius_mm) for tube in torch.tubes]
    tubes.append((np.array([0, 0, low]), np.array([0, 0, front]), torch.nozzle_radius_mm))
    points = []
    for start, end, radius in tubes:
        way = (end - start) / np.linalg.norm(end - start)
        across = np.cross(way, [0.0, 1.0, 0.0])
        turn, r = rng.uniform(0, 2 * np.pi, POINTS), radius * np.minimum(rng.uniform(0, 2, POINTS), 1.0)
        side = np.cos(turn)[:, None] * [0.0, 1.0, 0.0] + np.sin(turn)[:, None] * across
        points.append(start + rng.uniform(0, 1, (POINTS, 1)) * (end - start) + r[:, None] * side)
    own = np.concatenate(points)
    mouth = seam.frames.p + torch.wire_mm * back
    return (mouth[:, None] + np.einsum("nij,kj->nki", frames, own)).reshape(-1, 3)


@pytest.mark.deep
def test_under_a_roof_a_bent_neck_gets_where_a_straight_torch_does_not() -> None:
    (middle,) = [seam for seam in in_corner(found("straight")) if not seam.accepted]
    assert middle.length_mm > 100.0
    assert middle.blocked_by == ("roof",)
    assert f"{middle.other_torch.name} does, with {middle.other_torch.wire_mm:g} mm of wire" in middle.against[0]
    bent = in_corner(found(middle.other_torch.name))
    assert sum(seam.length_mm for seam in bent if seam.accepted) == pytest.approx(400.0, abs=1e-6)


@pytest.mark.parametrize("name", few(["robot-22", "robot-45", "robot-45-slim"], 1))
def test_no_point_of_the_whole_torch_is_in_material_along_accepted_seams(name: str) -> None:
    rng = np.random.default_rng(7)
    accepted = [seam for seam in found(name) if seam.accepted]
    assert accepted
    for seam in accepted:
        assert not in_boxes(points_of(find_torch(name), seam, rng)).any(), seam.name
    (corner,) = [seam for seam in in_corner(found(name)) if seam.accepted]
    spin = np.zeros(len(corner.frames)) if corner.spin_rad is None else corner.spin_rad
    turned = [replace(corner, spin_rad=spin + turn) for turn in (np.pi / 2, np.pi, -np.pi / 2)]
    assert any(in_boxes(points_of(find_torch(name), seam, rng)).any() for seam in turned)


@pytest.mark.parametrize(
    ("name", "count"),
    few([("robot-22", 3), *((name, 8) for name in ("robot-22", "robot-36", "machine", "robot-45-slim"))], 1),
)
def test_what_a_conical_nozzle_reaches_is_free_of_triangles_too(name: str, count: int) -> None:
    """The first plates of the bracket of the benchmark have corners between three of them, where the cone counts."""
    torch, bodies = find_torch(name), bench_bracket()[:count]
    seams = detect_seams(to_brep([(name, shape) for name, shape, _ in bodies]), SeamOptions(reach=Reach(torch)))
    accepted = [seam for seam in seams if seam.accepted]
    assert sum(seam.length_mm for seam in accepted) > 250.0 * count
    ways = [
        (seam, seam.frames.p, tool_rotations(seam.frames.R, TorchSettings(), seam.lean_rad, seam.spin_rad))
        for seam in accepted
    ]
    found = find_in_ways(TriangleMaterial.of(tessellate(bodies)), ways, torch)
    assert not any(found), [seam.name for seam, places in zip(accepted, found, strict=True) if places]


def test_ranges_bound_how_the_torch_leans_and_turns() -> None:
    seams = found("robot-45", work_deg=(0.0, 0.0), travel_deg=(-10.0, 15.0), spin_deg=(-90.0, 90.0))
    for seam in seams:
        lean = np.degrees(np.zeros((1, 2)) if seam.lean_rad is None else seam.lean_rad)
        lean = lean[~np.isnan(lean[:, 0])]
        assert (lean[:, 0] == 0).all()
        assert ((lean[:, 1] >= -10 - 1e-9) & (lean[:, 1] <= 15 + 1e-9)).all()
        if seam.spin_rad is not None:
            assert np.nanmax(np.abs(seam.spin_rad)) <= np.pi / 2 + 1e-9


def leaning_rib(angle_deg: float) -> tuple[Seam, ...]:
    """A rib of 8 mm that leans over a base by so many degrees from upright; its lower end is cut flat."""

    top = 80.0 * np.tan(np.radians(angle_deg))
    wide = 8.0 / np.cos(np.radians(angle_deg))
    section = [(0.0, 0.0, 0.0), (top, 80.0, 0.0), (top + wide, 80.0, 0.0), (wide, 0.0, 0.0)]
    rib = prism(section, (0.0, 0.0, 150.0))
    base = box(300.0, 10.0, 200.0, (-100.0, -10.0, -25.0))
    return detect_seams(to_brep([("base", base), ("rib", rib)]))


@pytest.mark.parametrize("acute_deg", few([58.0, 52.0], 1))
def test_the_acute_side_of_a_leaning_rib_is_welded_with_a_longer_wire(acute_deg: float) -> None:
    seams = leaning_rib(90.0 - acute_deg)
    acute = [s for s in seams if np.allclose(np.degrees(s.frames.angle_rad), 180.0 - acute_deg) and s.length_mm > 100]
    (seam,) = acute
    assert seam.accepted
    assert 0.0 < seam.more_wire_mm <= 5.0
    assert f"{20 + seam.more_wire_mm:g} mm of wire are needed" in seam.reasons[-1]
    assert all(other.more_wire_mm == 0.0 for other in seams if other.accepted and other is not seam)
