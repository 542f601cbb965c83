"""Clearance by capsules: against bounded least squares on matrices, and the laws of a distance."""

from dataclasses import replace

import numpy as np

from tests.saddle import changed
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.bodies import Owner, body_pairs
from wpcal.planning.cell.clearance import STATES, capsule_clearance

ROUND_OFF_MM = 1e-9  #: Coordinates of some metres: three orders above float64's own round-off.
SOLVER_MM = 1e-6  #: What the bounded least squares keeps of coordinates of some metres.


def random_state(n, seed=0, spread=1.5):
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.uniform(-spread, spread, (n, 6)), rng.uniform(-spread, spread, (n, 6))], axis=1)


def test_a_state_has_one_answer_alone_and_among_many(cell):
    state = random_state(STATES + 3)
    together = capsule_clearance(cell, state)
    for i in (0, 5, STATES - 1, STATES, STATES + 2):
        alone = capsule_clearance(cell, np.concatenate([state[i : i + 1, :6], state[i : i + 1, 6:]], axis=1))
        np.testing.assert_allclose(alone.margin_mm[0], together.margin_mm[i], rtol=0, atol=ROUND_OFF_MM)
        assert alone.pair[0] == together.pair[i]


def test_a_cell_moved_as_a_whole_has_the_same_clearances(cell):
    move = RigidTransform(rotation_from_zyx(0.3, -0.4, 0.5), [300, -200, 100], "world", "world")
    table = tuple(replace(shape, p=move.apply(shape.p), q=move.apply(shape.q)) for shape in cell.bench)
    moved = changed(cell, T_world_base=move @ cell.T_world_base, T_world_base2=move @ cell.T_world_base2, bench=table)
    state = random_state(50)
    expected, found = capsule_clearance(cell, state), capsule_clearance(moved, state)
    np.testing.assert_allclose(found.margin_mm, expected.margin_mm, rtol=0, atol=ROUND_OFF_MM)
    assert found.pair.tolist() == expected.pair.tolist()


def test_thicker_capsules_and_longer_safety_take_the_same_from_the_margin(cell):
    state = random_state(50)
    before = capsule_clearance(cell, state).margin_mm

    def thicker(shapes):
        return tuple(replace(shape, radius_mm=shape.radius_mm + 2.5) for shape in shapes)

    more = {name: thicker(getattr(cell, name)) for name in ("links", "torch", "part", "bench")}
    thick = changed(cell, links2=thicker(cell.carrier.links), **more)
    np.testing.assert_allclose(capsule_clearance(thick, state).margin_mm, before - 5.0, rtol=0, atol=ROUND_OFF_MM)
    strict = replace(
        cell, d1_mm=cell.d1_mm + 5, torch=tuple(replace(s, to_part_mm=s.to_part_mm and 8.0) for s in cell.torch)
    )
    np.testing.assert_allclose(capsule_clearance(strict, state).margin_mm, before - 5.0, rtol=0, atol=ROUND_OFF_MM)


def test_the_nozzle_alone_has_its_own_distance_to_the_part(cell):
    pairs = body_pairs(cell)
    own = {pairs.names(row) for row in range(len(pairs)) if pairs.safety_mm[row] != cell.d1_mm}
    assert own == {("robot 1 nozzle", "robot 2 run pipe"), ("robot 1 nozzle", "robot 2 branch pipe")}


def test_which_bodies_are_compared(cell):
    pairs = body_pairs(cell)
    named = {pairs.names(row) for row in range(len(pairs))}
    assert ("robot 1 forearm", "robot 1 torch body") in named  # a torch folded back
    assert ("robot 1 upper arm", "robot 1 wrist") in named
    assert ("robot 1 forearm", "robot 1 wrist") not in named  # they touch at the wrist's centre
    assert ("robot 1 wrist", "robot 1 torch body") not in named
    assert ("robot 1 pedestal", "robot 2 pedestal") in named
    assert ("robot 1 pedestal", "table") not in named
    assert ("robot 1 upper arm", "table") in named
    owners = {(pairs.bodies[i].owner, pairs.bodies[j].owner) for i, j in zip(pairs.first, pairs.second, strict=True)}
    assert (Owner.BENCH, Owner.BENCH) not in owners


def test_a_cell_without_bodies_has_nothing_to_meet(cell):
    bare = changed(cell, links=(), links2=(), torch=(), part=(), bench=())
    found = capsule_clearance(bare, random_state(3))
    assert found.is_clear.all()
    assert found.pair.tolist() == [-1, -1, -1]
    assert np.isinf(found.margin_mm).all()


def test_a_state_is_clear_only_beyond_the_safety_distance(cell):
    found = capsule_clearance(cell, np.concatenate([np.zeros((3, 6)), np.zeros((3, 6))], axis=1))
    assert replace(found, margin_mm=np.array([-0.1, 0.0, 0.1])).is_clear.tolist() == [False, False, True]
