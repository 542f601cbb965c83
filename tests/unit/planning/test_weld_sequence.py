"""Weld sequences of one robot: the tee on the floor and in the air, judged by other kinematics and other distances."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

from tests.few import few
from tests.one_robot_cells import TEE, TEE_ON_TABLE, fixed_cell, one_robot_record, with_positioner, write_cell
from tests.record_checks import check_record
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.records import to_json
from wpcal.pages.draw.place import place_svg
from wpcal.planning.cell.bodies import with_torch_at, with_wire
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.run import Phase
from wpcal.planning.sequence.kept_plan import kept_plan_of, with_digest
from wpcal.planning.sequence.motion_check import MotionChecker
from wpcal.planning.sequence.order import Stop, find_order
from wpcal.planning.sequence.place import MapOptions, Moved, map_places
from wpcal.planning.sequence.plan_sequence import SequencePreference, _Work, plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets, WeldOrder, WeldPosition
from wpcal.planning.sequence.timeline import build_timeline, sequence_csv, sequence_record
from wpcal.weld.runs import RunChoice

pytest.importorskip("fcl", reason="python-fcl is not installed")

PATH_MM = 0.02  #: Between points that are 5 mm apart a straight line in the joints leaves a straight seam by less.


@pytest.fixture(scope="module")
def given():
    return read_sequence_input(TEE, fixed_cell())


@pytest.fixture(scope="module")
def fixed(given):
    cell = given.placed(fixed_cell())
    return plan_sequence(cell, given.part, given.seams, SequenceTargets())


@pytest.fixture(scope="module")
def turned(given, tmp_path_factory):
    """The tee on a positioner, flat side down on the table."""
    cell = read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), with_positioner(TEE_ON_TABLE)))
    return plan_sequence(cell, given.part, given.seams, SequenceTargets(position=WeldPosition.PA))


def dh_forward(arm, q):
    """The flange by the textbook product of matrices; nothing of `wpcal.robot` but the numbers of the table."""

    def rotation(axis, angle):
        c, s = np.cos(angle), np.sin(angle)
        T = np.eye(4)
        i, j = [k for k in range(3) if k != axis]
        T[[i, i, j, j], [i, j, i, j]] = (c, s, -s, c) if axis == 1 else (c, -s, s, c)
        return T

    def shift(x, z):
        T = np.eye(4)
        T[0, 3], T[2, 3] = x, z
        return T

    T = arm.chain.T_base_dh0.matrix
    for angle, (theta, d, a, alpha, beta) in zip(arm.model_angles(q), arm.chain.table.T, strict=True):
        T = T @ rotation(2, angle + theta) @ shift(a, d) @ rotation(0, alpha) @ rotation(1, beta)
    return T @ arm.chain.T_dhn_flange.matrix


@pytest.mark.parametrize("name", few(["fixed", "turned"], 1))
def test_the_wire_is_on_the_seam_at_every_point(name, request):
    sequence = request.getfixturevalue(name).sequence
    cell = sequence.cell
    assert sequence.welded_mm == pytest.approx(316.0, abs=1.0)
    assert not sequence.unwelded
    for piece in sequence.pieces:
        task = piece.candidate.task
        for row in range(0, len(task), 5):
            q = piece.candidate.q[row]
            T_tip = cell.T_world_base.matrix @ dh_forward(cell.arm, q[:6]) @ cell.T_flange_tool.matrix
            T_carrier = np.eye(4)
            if cell.carrier is not None:
                T_carrier = cell.carrier.T_world_base.matrix @ dh_forward(cell.carrier.arm, q[6:])
            p = (T_carrier @ cell.T_part.matrix @ [*task.p[row], 1.0])[:3]
            assert np.linalg.norm(T_tip[:3, 3] - p) < 1e-6
            wire = (T_carrier @ cell.T_part.matrix)[:3, :3] @ task.R[row][:, 2]
            assert T_tip[:3, 2] @ wire == pytest.approx(-1.0, abs=1e-9)  # no lean was needed


@pytest.mark.parametrize("name", ["fixed", "turned"])
def test_no_move_is_nearer_than_allowed_at_ten_times_finer_steps(name, request, given, golden):
    sequence = request.getfixturevalue(name).sequence
    assert sequence.is_free
    line = build_timeline(sequence)
    clearance = CellClearance(sequence.cell, given.part)
    at = np.linspace(0, len(line) - 1, 10 * len(line))
    row = np.minimum(at.astype(int), len(line) - 2)
    fine = line.q[row] + (at - row)[:, None] * (line.q[row + 1] - line.q[row])
    assert clearance.margins(fine).margin_mm.min() > -sequence.cell.d1_mm / 2
    low, high = sequence.cell.limits
    assert ((fine >= low - 1e-9) & (fine <= high + 1e-9)).all()
    speed = np.abs(np.diff(line.q, axis=0)) / np.diff(line.t_s)[:, None]
    assert (speed <= sequence.cell.speeds * (1 + 1e-9)).all()
    golden([sequence, line])


def test_the_arm_keeps_its_configuration_along_a_seam(fixed):
    for piece in fixed.sequence.pieces:
        q = piece.candidate.q[:, :6]
        assert np.abs(np.diff(q, axis=0)).max() < np.radians(10.0)
        assert (np.sign(q[:, 4]) == np.sign(q[0, 4])).all()


def test_a_positioner_brings_every_seam_into_position(turned, fixed):
    for piece in turned.sequence.pieces:
        assert piece.candidate.off_position_rad <= np.radians(10.0)
        assert np.ptp(piece.candidate.q[:, 6:], axis=0).max() == 0.0
    assert not turned.sequence.out_of_position
    lying = SequenceTargets(position=WeldPosition.PA)
    flat = [lying.off_position(fixed.sequence.cell.part_places(p.candidate.q[:1])[0, :3, :3] @ p.candidate.task.R).max()
            for p in fixed.sequence.pieces]  # fmt: skip
    assert min(flat) > np.radians(40.0)  # on the floor the same seams are not in PA


def test_the_sequence_starts_and_ends_at_home_and_welds_at_the_speed(fixed):
    sequence, line = fixed.sequence, build_timeline(fixed.sequence)
    assert np.array_equal(line.q[0], sequence.cell.home)
    assert np.allclose(line.q[-1], sequence.cell.home, rtol=0, atol=1e-12)
    assert (np.diff(line.t_s) > 0).all()
    rows = [i for i, phase in enumerate(line.phase) if phase is Phase.WELD and line.piece[i] == 0]
    inside = [i for i in rows[1:] if not np.isnan(line.s_mm[i - 1])]
    speed = [abs(line.s_mm[i] - line.s_mm[i - 1]) / (line.t_s[i] - line.t_s[i - 1]) for i in inside]
    assert np.allclose(speed, sequence.pieces[0].speed_mm_s, rtol=0, atol=1e-9)
    assert fixed.values[SequencePreference.BALANCED].time_s == pytest.approx(line.t_s[-1], rel=0.05)


def test_a_short_approach_or_retract_is_told_with_its_length(fixed):
    assert fixed.sequence.short_ways == ()
    first, second, *rest = fixed.sequence.pieces
    pieces = (dataclasses.replace(first, before=first.before[-2:]), dataclasses.replace(second, after=second.after[:3]))
    (told,) = dataclasses.replace(fixed.sequence, pieces=(*pieces, *rest)).short_ways
    assert told.endswith(f"below 50 mm, to where the wire is clear: {first.name} 20 mm, {second.name} 30 mm")


def test_the_records_are_of_their_schema(fixed, given):
    line = build_timeline(fixed.sequence)
    made = {"inputs": {"part.glb": b""}, "planned": [each.name for each in given.seams], "runs": RunChoice()}
    record = json.loads(to_json(with_digest(sequence_record(fixed, line, **made))))
    check_record(record)
    assert [each[:12] for each in record["open"]] == ["OFF POSITION"] * len(record["open"])
    kept = kept_plan_of(record, fixed.sequence.cell, {each.name: each for each in given.seams})
    for piece, way in zip(kept.pieces, kept.ways, strict=True):
        assert np.allclose(way.from_home[[0, -1]], [kept.cell.home, piece.states[0]], rtol=0, atol=1e-9)
        assert np.allclose(way.to_home[[0, -1]], [piece.states[-1], kept.cell.home], rtol=0, atol=1e-9)
    rows = sequence_csv(fixed.sequence, line).splitlines()
    assert len(rows) == len(record["points"]) + 1


def test_ways_of_each_piece_are_free_at_fine_steps(fixed, given):
    cell = with_wire(fixed.sequence.cell, SequenceTargets().air_clearance_mm)
    clearance = CellClearance(cell, given.part)
    for way in fixed.sequence.ways:
        for states in (way.from_home, way.to_home):
            fine = [a + t * (b - a) for a, b in itertools.pairwise(states) for t in np.linspace(0.0, 1.0, 200)]
            assert clearance.margins(np.array(fine)).is_clear.all()


def test_a_piece_that_is_not_free_is_left_out_by_name_and_the_rest_is_planned(given, monkeypatch, golden):
    cell = given.placed(fixed_cell())
    one = _Work._piece
    blocked = lambda self, ways, row: "a wall" if ways.name == "W2" else one(self, ways, row)  # noqa: E731
    monkeypatch.setattr(_Work, "_piece", blocked)
    plan = plan_sequence(cell, given.part, given.seams, SequenceTargets()).sequence
    names = {each.name for each in given.seams}
    assert {piece.candidate.task.name for piece in plan.pieces} == names - {"W2"}
    (gap,) = plan.unwelded
    assert gap.describe().startswith("seam W2 from 0 to 150 mm is not welded: no way along it is free: a wall")
    assert plan.is_free
    assert plan.open_points(has_part=False)[0].startswith("NOT CHECKED: the part")
    assert plan.open_points(has_part=True)[0].startswith("NOT WELDED: 150 of ")
    golden([plan.unwelded, plan.open_points(has_part=False)])


def test_a_piece_is_named_that_is_welded_in_another_position_or_slower_than_its_weld_data_are_for(given):
    plan = plan_sequence(given.placed(fixed_cell()), given.part, given.seams, SequenceTargets()).sequence
    piece, now = plan.pieces[0], plan.pieces[0].position(plan.cell)
    slow = f"SLOWER THAN ITS WELD DATA: {piece.name} (60 mm/s, is 8.0); the same wire feed lays a larger bead"
    for position, mm_s, told in (
        (now, None, []),
        ("PG", None, [f"WELD DATA OF ANOTHER POSITION: {piece.name} (PG, is {now})"]),
        (None, 60.0, [slow]),
    ):
        task = dataclasses.replace(piece.candidate.task, position=position, speed_mm_s=mm_s)
        candidate = dataclasses.replace(piece.candidate, task=task)
        welded = dataclasses.replace(piece, candidate=candidate, slowed_by=mm_s and "R")
        changed = dataclasses.replace(plan, pieces=(welded, *plan.pieces[1:]))
        assert [line for line in changed.open_points(has_part=True) if "DATA" in line] == told


def test_a_torch_without_its_usual_room_beside_a_seam_leaves_with_that_of_its_wire(given):
    """A body of the torch asks for twice of what the farthest way back along the wire, 40 mm, gives it."""
    cell, targets = given.placed(fixed_cell()), SequenceTargets(approach_mm=10.0)
    wide = dataclasses.replace(cell, torch=(dataclasses.replace(cell.torch[0], to_part_mm=80.0), *cell.torch[1:]))
    plan = plan_sequence(wide, given.part, given.seams[:1], targets).sequence
    assert plan.unwelded == ()
    near = with_wire(with_torch_at(cell, targets.air_clearance_mm), targets.air_clearance_mm)
    checker = MotionChecker(near, CellClearance(near, given.part))
    (way,) = plan.ways
    assert all(checker.check(q).is_free for q in (*(path.q for path in plan.air), way.from_home, way.to_home))


def test_a_part_out_of_reach_is_told_with_what_helps(given):
    cell = fixed_cell((2300.0, 0.0, 200.0))
    with pytest.raises(
        GeometryError, match=r"no seam can be welded: seam W\d from 0 to \d+ mm .*out of reach of .* by \d+ mm"
    ):
        plan_sequence(cell, given.part, given.seams[:1], SequenceTargets())


def test_a_home_in_collision_and_unknown_seams_are_one_line(given):
    cell = dataclasses.replace(given.placed(fixed_cell()))
    with pytest.raises(InputError, match=r"no seam 'W77'|unknown seam"):
        read_sequence_input(TEE, cell, ["W77"])
    inside = dataclasses.replace(cell, d1_mm=400.0)
    with pytest.raises(InputError, match=r"home is in collision: .*write another home_deg"):
        plan_sequence(inside, given.part, given.seams[:1], SequenceTargets())


def test_the_best_order_of_few_stops_is_found(golden):
    rng = np.random.default_rng(2)
    stops = [Stop(p[:1], p[:1] + 0.01, np.zeros(1), np.append(p[0], 0.0)) for p in rng.uniform(-1, 1, (6, 1, 2))]
    found = find_order(stops, np.zeros(2), np.ones(2), WeldOrder.TIME)
    import itertools

    best = min(_seconds([stops[i] for i in order]) for order in itertools.permutations(range(6)))
    assert found.seconds <= 1.1 * best
    assert find_order(stops, np.zeros(2), np.ones(2), WeldOrder.LISTED).stops == (0, 1, 2, 3, 4, 5)
    blocked = [(found.stops[0], 0, found.stops[1], 0)]
    other = find_order(stops, np.zeros(2), np.ones(2), WeldOrder.TIME, blocked)
    assert other.stops[:2] != found.stops[:2]
    assert np.isfinite(other.seconds)
    golden([found, other])


def _seconds(stops):
    at, total = np.zeros(2), 0.0
    for stop in stops:
        total += np.abs(stop.start[0] - at).max()
        at = stop.end[0]
    return total + np.abs(at).max()


def test_skip_welding_goes_far_away_each_time(golden):
    stops = [Stop(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros(1), np.array([100.0 * i, 0, 0])) for i in range(6)]
    order = find_order(stops, np.zeros(2), np.ones(2), WeldOrder.SKIP).stops
    assert sorted(order) == list(range(6))
    assert min(abs(a - b) for a, b in itertools.pairwise(order[:3])) >= 2
    golden(order)


def _stop(x, y, rank=1):
    return Stop(np.array([[x, y]]) / 100, np.array([[x, y]]) / 100, np.zeros(1), np.array([x, y, 0.0]), rank)


def test_pairs_are_opposite_and_far_from_one_another():
    places = [(100.0 * i, side) for i in range(4) for side in (-50.0, 50.0)]
    stops = [_stop(*place) for place in places]
    order = find_order(stops, np.zeros(2), np.ones(2), WeldOrder.PAIRS).stops
    assert sorted(order) == list(range(8))
    for a, b in zip(order[::2], order[1::2], strict=True):
        assert np.allclose(stops[a].middle + stops[b].middle, [300.0, 0.0, 0.0])


@pytest.mark.parametrize("rule", [WeldOrder.TIME, WeldOrder.SKIP, WeldOrder.PAIRS])
def test_tack_welds_are_first_and_a_bead_is_before_the_one_on_it(rule):
    rng = np.random.default_rng(8)
    ranks = [2, 1, 0, 1, 2, 0, 1]
    stops = [_stop(*rng.uniform(0.0, 500.0, 2), rank) for rank in ranks]
    order = find_order(stops, np.zeros(2), np.ones(2), rule).stops
    assert [ranks[row] for row in order] == sorted(ranks)


def test_a_cell_without_tool_data_is_one_line(tmp_path):
    record = one_robot_record()
    record["torch_robot"]["T_flange_tool"] = None
    with pytest.raises(InputError, match="T_flange_tool is missing"):
        read_one_robot(write_cell(tmp_path, record))


def test_a_part_that_is_too_high_is_lowered_as_far_as_nothing_is_below(given, golden):
    cell, seams = fixed_cell((900.0, 0.0, 2000.0)), [each for each in given.seams if each.name == "W2"]
    options, targets = MapOptions(range_mm=100.0, step_mm=100.0), SequenceTargets()
    table = Shape("table", np.array([[900.0, 0.0, 1900.0]]), np.array([[1000.0, 0.0, 1900.0]]), np.array([40.0]))
    cells = cell, dataclasses.replace(cell, bench=(table,))
    found, above = (map_places(each, given.part, seams, targets, options) for each in cells)
    assert (found.now, found.best.share, above.best.height_mm >= 0.0) == (0.0, 1.0, True)
    assert 2000.0 > found.best_at.t_mm[2] == 2000.0 + found.best.height_mm
    check_record(json.loads(to_json(found.to_record("a cell"))))
    golden([found, above])


@pytest.mark.deep
def test_a_place_where_a_body_is_in_the_way_does_not_count(given):
    """A lid over the part: the arm would reach the seams there. A plan finds the same."""
    cell, seams = given.placed(fixed_cell()), [each for each in given.seams if each.name == "W2"]
    one = MapOptions(range_mm=400.0, step_mm=400.0)
    before = map_places(cell, given.part, seams, SequenceTargets(), one)
    assert before.now == 1.0
    at = cell.part_places(cell.home[None])[0] @ [100.0, 10.0, 70.0, 1.0]
    lid = Shape("lid", at[None, :3] - [200.0, 0.0, 0.0], at[None, :3] + [200.0, 0.0, 0.0], np.array([40.0]))
    covered = dataclasses.replace(cell, bench=(*cell.bench, lid))
    found = map_places(covered, given.part, seams, SequenceTargets(), one)
    assert found.now == 0.0
    assert found.best.share == 1.0
    with pytest.raises(GeometryError, match="lid"):
        plan_sequence(covered, given.part, seams, SequenceTargets(torch_range_rad=0.0))
    assert (found.share <= before.share).all()


@pytest.mark.deep
def test_the_map_finds_a_place_for_a_part_out_of_reach(given):
    cell = fixed_cell((1900.0, 0.0, 200.0))
    options = MapOptions(range_mm=1200.0, step_mm=300.0)
    found = map_places(cell, given.part, given.seams[:2], SequenceTargets(), options)
    assert found.now == 0.0
    assert (found.best.height_mm, found.best.share) == (0.0, 1.0)
    assert found.best.x_mm <= -600.0
    check_record(json.loads(to_json(found.to_record("a cell"))))
    moved = dataclasses.replace(cell, T_carrier_part=found.best_at)
    assert plan_sequence(moved, given.part, given.seams[:2], SequenceTargets()).sequence.welded_mm > 0.0
    picture = place_svg(found)
    assert picture.count("<rect") == 1 + found.share.size
    coarse = MapOptions(moved=Moved.ROBOT, range_mm=1200.0, step_mm=600.0)
    by_robot = map_places(cell, given.part, given.seams[:2], SequenceTargets(), coarse)
    assert by_robot.best[0] >= 600.0
