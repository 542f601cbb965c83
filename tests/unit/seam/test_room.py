"""Where there is room a torch is not compared with a part, and the answer is that of every place compared."""

from dataclasses import replace

import numpy as np
import pytest

from tests.few import few
from tests.unit.seam.test_material import box_of_triangles
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh
from wpcal.core.rotations import rotation_from_zyx
from wpcal.robot.torch.attitude import ToolAxis, neck_directions, wire_directions
from wpcal.robot.torch.file import shipped_torches
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.judge.reach import sweep_torch
from wpcal.seam.judge.room import _points, with_room

TORCHES = [each.shape for each in shipped_torches()]


def drawn(rng):
    """Return six boxes that stand anywhere, one of them large and one long and narrow."""
    solids = []
    for number in range(6):
        half = {0: rng.uniform(100.0, 400.0, 3), 1: [3.0, 600.0, 2.0]}.get(number, rng.uniform(2.0, 60.0, 3))
        box = box_of_triangles(f"box {number}", half, rotation_from_zyx(*rng.uniform(-3, 3, 3)))
        solids.append(replace(box, points=box.points + rng.uniform(-300, 300, 3)))
    return TriangleMaterial.of(PartMesh(tuple(solids), 0.1, 0.1))


@pytest.mark.parametrize("torch", TORCHES[:3], ids=str)
@pytest.mark.parametrize("seed", few(range(20), 2))
def test_a_swept_torch_meets_what_it_meets_at_every_place(seed, torch, golden):
    rng = np.random.default_rng(seed)
    part, axis = drawn(rng), (ToolAxis.Z, ToolAxis.X)[seed % 2]
    ways = [
        (rng.uniform(-600, 600, (4, 3)), rotation_from_zyx(*(rng.uniform(-3, 3, (3, 1)) + rng.uniform(-1, 1, (3, 4)))))
        for _ in range(6)
    ]
    swept, found = sweep_torch(part, ways, torch, axis=axis)
    bend = neck_directions(swept.R, axis) if torch.neck is not None else None
    all_of_it = find_poses_in_material(part, swept.p, -wire_directions(swept.R, axis), torch, bend=bend)
    assert 0 < len(found) < len(swept.at)
    assert (found.row.tolist(), found.solid, found.part) == (all_of_it.row.tolist(), all_of_it.solid, all_of_it.part)
    golden([swept, found])


def test_most_places_far_from_a_part_are_not_compared():
    rng = np.random.default_rng(1)
    part, p = drawn(rng), np.stack([np.linspace(-500, 500, 4000), np.full(4000, 900.0), np.zeros(4000)], axis=1)
    p = np.concatenate([p, part.corners[0, :1]])
    may = with_room(part).may_meet(p, np.add(p, [0.0, 20.0, 0.0]), np.broadcast_to([0.0, 1.0, 0.0], p.shape), 10.0)
    assert may[-1]
    assert may.sum() < 20
    long = np.array([[[0.0, 0.0, 0.0], [6000.0, 8.0, 0.0], [6000.0, 0.0, 0.0]]])
    assert sum(len(points) for points in _points(long, 8.0)) < 4000
