"""Cuts against all cuts there are; reasons, and changes that were tried; stretches that end at a singular arm."""

import dataclasses
import itertools
import re

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell, with_positioner, write_cell
from wpcal.core.errors import InputError
from wpcal.planning.cell.cell_clearance import CellClearance, Margins
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.shape import Shape
from wpcal.planning.sequence.cuts import Span, best_cuts, find_reason, out_of_reach
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.remedies import Help, RemedySearch, changed_cell
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.seam_task import seam_task
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets

pytest.importorskip("fcl", reason="python-fcl is not installed")


@pytest.fixture(scope="module")
def given():
    return read_sequence_input(TEE, fixed_cell(), ["W2", "W3"])


def value_of(s, spans):
    lengths = [s[b] - s[a] for a, b in spans]
    return round(sum(lengths), 6), -len(lengths), round(min(lengths, default=np.inf), 6)


def all_cuts(s, ways, least):
    """Every set of pieces that follow one another, each within one way."""
    n = len(s)
    spans = [
        (i, j)
        for i in range(n)
        for j in range(i + 1, n)
        if s[j] - s[i] >= least - 1e-6 and any(a <= i and j <= b for a, b in ways)
    ]

    def extend(chosen, at):
        yield chosen
        for span in spans:
            if span[0] >= at:
                yield from extend([*chosen, span], span[1])

    return extend([], 0)


def test_cuts_are_the_best_of_all_there_are():
    rng = np.random.default_rng(5)
    for _ in range(60):
        n = int(rng.integers(3, 8))
        s = np.concatenate([[0.0], np.cumsum(rng.integers(1, 12, n - 1))]).astype(float)
        ways = [Span(*sorted(rng.choice(n, 2, replace=False).tolist())) for _ in range(int(rng.integers(0, 4)))]
        least = float(rng.choice([0.0, 6.0, 15.0]))
        found = best_cuts(s, ways, least)
        assert value_of(s, found) == max(value_of(s, cuts) for cuts in all_cuts(s, ways, least))
        assert all(a[1] <= b[0] for a, b in itertools.pairwise(found))


@pytest.mark.parametrize("seed", range(5))
def test_round_off_is_no_reason_for_a_cut(seed):
    s = np.concatenate([[0.0], np.cumsum(np.random.default_rng(seed).uniform(1.0, 3.0, 300))])
    assert len(best_cuts(s, [Span(0, 131), Span(100, 300)], 15.0)) == 2


def test_a_rest_that_is_too_short_is_cut_longer():
    """From the start 90 mm can be welded, and from 60 mm to the end: the last 10 mm are no piece of their own."""
    s = np.arange(0.0, 101.0, 5.0)
    (first, last) = best_cuts(s, [Span(0, 18), Span(12, 20)], 15.0)
    assert s[first.last] - s[first.first] + s[last.last] - s[last.first] == 100.0
    assert s[last.last] - s[last.first] >= 15.0


def searched(given, cell):
    search = SeamSearch(cell, CellClearance(cell, given.part), SequenceTargets())
    return search, seam_task(given.seams[0].seam)


def test_a_move_that_is_told_was_tried_and_works(given, golden):
    cell = fixed_cell((1750.0, -100.0, 200.0))
    search, task = searched(given, cell)
    assert not search.whole(task)
    assert "out of reach of" in find_reason(search, task)
    found, is_searched = RemedySearch(search).find(task)
    assert is_searched
    (move,) = [each for each in found if any(each.move_mm)]
    place = cell.T_world_base
    moved = dataclasses.replace(
        cell, T_world_base=dataclasses.replace(place, t_mm=place.t_mm + np.array([*move.move_mm, 0.0]))
    )
    plan = plan_sequence(moved, given.part, given.seams[:1], SequenceTargets()).sequence
    assert plan.is_free
    assert not plan.unwelded
    golden(found)


def test_a_body_in_the_way_is_named_with_its_place_and_a_change_that_was_tried(given, golden):
    """A plate over the seam: the torch body cannot come near, wherever the arm is."""
    cell = given.placed(fixed_cell())
    corners = np.array(list(itertools.product((600.0, 1200.0), (-400.0, 400.0), (240.0, 250.0))))
    lid = Shape("lid", corners.mean(axis=0)[None], corners.mean(axis=0)[None], 280.0, hull=corners)
    search, task = searched(given, dataclasses.replace(cell, bench=(lid,)))
    assert not search.whole(task)
    why = find_reason(search, task)
    assert "lid" in why
    assert " mm at best, at " in why
    golden(why)


def test_what_is_out_of_reach_is_told_before_the_search_and_nothing_else(given, golden):
    far, near = fixed_cell((1750.0, -100.0, 200.0)), fixed_cell()
    told = out_of_reach(far, given.seams, SequenceTargets())
    assert told
    assert all(re.fullmatch(r"seam W\d+ cannot be welded whole: .+, at \d+ mm", line) for line in told)
    search = SeamSearch(far, CellClearance(far, None), SequenceTargets())
    lost = {line.split()[1] for line in told}
    for seam in given.seams:
        assert bool(search.whole(seam_task(seam.seam))) <= (seam.name not in lost)
    assert out_of_reach(given.placed(near), given.seams, SequenceTargets()) == ()
    golden(told)


def test_where_nothing_helps_it_is_said(given):
    far, task = searched(given, fixed_cell((4000.0, 0.0, 200.0)))
    remedies = RemedySearch(far)
    assert remedies.find(task) == ((), True)


def test_a_part_through_the_floor_is_one_line(given):
    with pytest.raises(InputError, match=r"the part is through the floor, by \d+ mm: .*correct T_world_part"):
        plan_sequence(fixed_cell((800.0, 0.0, -60.0)), given.part, given.seams[:1], SequenceTargets())


def test_a_home_in_collision_is_told_with_one_that_is_free(tmp_path, given, golden):
    record = with_positioner()
    record["positioner"]["T_world_base"]["xyz_mm"] = [1000, 0, 100]
    record["positioner"]["home_deg"] = [-90, 0]
    cell = read_one_robot(write_cell(tmp_path, record))
    with pytest.raises(InputError, match=r"home is in collision: part and floor .* home is free with home_deg") as told:
        plan_sequence(cell, given.part, given.seams[:1], SequenceTargets())
    axes = [float(v) for v in str(told.value).split("home_deg [")[-1].split("]")[0].split(",")]
    record["positioner"]["home_deg"] = axes
    free = read_one_robot(write_cell(tmp_path, record))
    assert CellClearance(free, given.part).margins(free.home[None]).is_clear[0]
    golden(str(told.value))


def test_a_part_farther_from_the_table_turns_with_the_positioner(tmp_path):
    cell = read_one_robot(write_cell(tmp_path, with_positioner()))
    farther = changed_cell(cell, Help("", from_table_mm=150.0), np.zeros(3))
    q = cell.home[None].copy()
    q[0, -2:] = np.radians([40.0, 70.0])
    moved = farther.part_places(q)[0, :3, 3] - cell.part_places(q)[0, :3, 3]
    np.testing.assert_allclose(moved, 150.0 * cell.carrier_places(q)[0, :3, 2], atol=1e-9)


def test_a_slimmer_nozzle_is_slimmer_than_itself_and_not_than_what_is_around_it(tmp_path):
    hull = np.array([[11.0 * x, 11.0 * y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-60, -20) if x * y == 0])
    nozzle = Shape("nozzle", [[0.0, 0.0, -20.0]], [[0.0, 0.0, -60.0]], [34.0], hull=hull, to_part_mm=3.0)
    cell = dataclasses.replace(read_one_robot(write_cell(tmp_path, with_positioner())), torch=(nozzle,))
    (slim,) = changed_cell(cell, Help("", torch_scale=0.5), np.zeros(3)).torch
    np.testing.assert_allclose(slim.radius_mm, 5.5)


pytest.importorskip("fcl", reason="python-fcl is not installed")
BLOCKED = 5  #: The first point in collision.


def test_points_before_a_singular_one_are_checked(monkeypatch):
    given = read_sequence_input(TEE, fixed_cell(), ["W2"])
    cell = given.placed(fixed_cell())
    search = SeamSearch(cell, CellClearance(cell, given.part), SequenceTargets())
    task = seam_task(given.seams[0].seam)
    way = search.whole(task)[0]
    outer, branch = np.zeros((2, 0)), (way.branch, way.q[0, :6])
    assert search.checked(task, way.angles, outer, branch)[1] is None
    monkeypatch.setattr(
        "wpcal.planning.sequence.seam_search.is_regular", lambda _, q: np.arange(len(q)) < len(task) - 2
    )
    assert search.checked(task, way.angles, outer, branch)[1] == len(task) - 2
    measure = CellClearance.margins

    def margins(own, q):
        found = measure(own, q)
        at = np.linalg.norm(q - way.q[BLOCKED], axis=1) < 1e-9
        return Margins(np.where(at, -1.0, found.margin_mm), found.pair, found.by_carriers_mm)

    monkeypatch.setattr(CellClearance, "margins", margins)
    q, bad = search.checked(task, way.angles, outer, branch)
    assert (len(q), bad) == (BLOCKED, BLOCKED)
