"""Tours of one robot: the tee on the floor and in the air, judged by other kinematics and other distances."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

from tests.record_checks import check_record
from tests.station_cells import TEE, fixed_station, station_record, with_positioner, write_cell
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.records import to_json
from wpcal.planning.cell.station_clearance import StationClearance
from wpcal.planning.cell.station_file import read_station
from wpcal.planning.tour.order import Stop, find_order
from wpcal.planning.tour.place import Moved, map_places, place_svg
from wpcal.planning.tour.plan_tour import TourPreference, plan_tour
from wpcal.planning.tour.seam_task import seam_task
from wpcal.planning.tour.targets import TourTargets, WeldOrder, WeldPosition
from wpcal.planning.tour.timeline import TourPhase, build_timeline
from wpcal.planning.tour.tour_input import read_tour_input
from wpcal.planning.tour.tour_record import tour_csv, tour_record

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")

PATH_MM = 0.02
"""Between points that are 5 mm apart a straight line in the joints leaves a straight seam by less."""


@pytest.fixture(scope="module")
def given():
    return read_tour_input(TEE, fixed_station())


@pytest.fixture(scope="module")
def fixed(given):
    station = given.placed(fixed_station())
    return plan_tour(station, given.part, given.seams, TourTargets())


@pytest.fixture(scope="module")
def turned(given, tmp_path_factory):
    """The tee on a positioner, flat side down on the table."""
    record = with_positioner()
    record["positioner"]["T_flange_part"] = {"xyz_mm": [-75, -50, 10], "rpy_deg": [0, 0, 0]}
    station = read_station(write_cell(tmp_path_factory.mktemp("cell"), record))
    return plan_tour(station, given.part, given.seams, TourTargets(position=WeldPosition.PA))


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


@pytest.mark.parametrize("name", ["fixed", "turned"])
def test_the_wire_is_on_the_seam_at_every_point(name, request):
    tour = request.getfixturevalue(name).tour
    station = tour.station
    assert tour.welded_mm == pytest.approx(316.0, abs=1.0)
    assert not tour.unwelded
    for piece in tour.pieces:
        task = piece.candidate.task
        for row in range(0, len(task), 5):
            q = piece.candidate.q[row]
            T_tip = station.T_world_base.matrix @ dh_forward(station.arm, q[:6]) @ station.T_flange_tool.matrix
            T_carrier = np.eye(4)
            if station.positioner is not None:
                T_carrier = station.positioner.T_world_base.matrix @ dh_forward(station.positioner.arm, q[6:])
            p = (T_carrier @ station.T_part.matrix @ [*task.p[row], 1.0])[:3]
            assert np.linalg.norm(T_tip[:3, 3] - p) < 1e-6
            wire = (T_carrier @ station.T_part.matrix)[:3, :3] @ task.R[row][:, 2]
            assert T_tip[:3, 2] @ wire == pytest.approx(-1.0, abs=1e-9)  # no lean was needed


@pytest.mark.parametrize("name", ["fixed", "turned"])
def test_no_move_is_nearer_than_allowed_at_ten_times_finer_steps(name, request, given):
    tour = request.getfixturevalue(name).tour
    assert tour.is_free
    line = build_timeline(tour)
    clearance = StationClearance(tour.station, given.part)
    at = np.linspace(0, len(line) - 1, 10 * len(line))
    row = np.minimum(at.astype(int), len(line) - 2)
    fine = line.q[row] + (at - row)[:, None] * (line.q[row + 1] - line.q[row])
    assert clearance.margins(fine).margin_mm.min() > -tour.station.d1_mm / 2
    low, high = tour.station.limits
    assert ((fine >= low - 1e-9) & (fine <= high + 1e-9)).all()
    speed = np.abs(np.diff(line.q, axis=0)) / np.diff(line.t_s)[:, None]
    assert (speed <= tour.station.speeds * (1 + 1e-9)).all()


def test_the_arm_keeps_its_configuration_along_a_seam(fixed):
    for piece in fixed.tour.pieces:
        q = piece.candidate.q[:, :6]
        assert np.abs(np.diff(q, axis=0)).max() < np.radians(10.0)
        assert (np.sign(q[:, 4]) == np.sign(q[0, 4])).all()


def test_a_positioner_brings_every_seam_into_position(turned, fixed):
    for piece in turned.tour.pieces:
        assert piece.candidate.off_position_rad <= np.radians(10.0)
        assert np.ptp(piece.candidate.q[:, 6:], axis=0).max() == 0.0
    assert not turned.tour.out_of_position
    lying = TourTargets(position=WeldPosition.PA)
    flat = [lying.off_position(fixed.tour.station.part_places(p.candidate.q[:1])[0, :3, :3] @ p.candidate.task.R).max()
            for p in fixed.tour.pieces]  # fmt: skip
    assert min(flat) > np.radians(40.0)  # on the floor the same seams are not in PA


def test_the_tour_starts_and_ends_at_home_and_welds_at_the_speed(fixed):
    tour, line = fixed.tour, build_timeline(fixed.tour)
    assert np.array_equal(line.q[0], tour.station.home)
    assert np.allclose(line.q[-1], tour.station.home, rtol=0, atol=1e-12)
    assert (np.diff(line.t_s) > 0).all()
    rows = [i for i, phase in enumerate(line.phase) if phase is TourPhase.WELD and line.piece[i] == 0]
    inside = [i for i in rows[1:] if not np.isnan(line.s_mm[i - 1])]
    speed = [abs(line.s_mm[i] - line.s_mm[i - 1]) / (line.t_s[i] - line.t_s[i - 1]) for i in inside]
    assert np.allclose(speed, tour.pieces[0].speed_mm_s, rtol=0, atol=1e-9)
    assert fixed.values[TourPreference.BALANCED].time_s == pytest.approx(line.t_s[-1], rel=0.05)


def test_the_records_are_of_their_schema_and_the_same_again(fixed, given):
    line = build_timeline(fixed.tour)
    record = json.loads(to_json(tour_record(fixed, line, no_program={"fanuc": "why"})))
    check_record(record)
    rows = tour_csv(fixed.tour, line).splitlines()
    assert len(rows) == len(record["points"]) + 1
    again = plan_tour(fixed.tour.station, given.part, given.seams, TourTargets())
    assert tour_csv(again.tour, build_timeline(again.tour)).splitlines() == rows


def test_a_part_out_of_reach_is_told_with_what_helps(given):
    station = fixed_station((2300.0, 0.0, 200.0))
    with pytest.raises(
        GeometryError, match=r"no seam can be welded: seam W\d from 0 to \d+ mm .*out of reach of .* by \d+ mm"
    ):
        plan_tour(station, given.part, given.seams[:1], TourTargets())


def test_a_home_in_collision_and_unknown_seams_are_one_line(given):
    station = dataclasses.replace(given.placed(fixed_station()))
    with pytest.raises(InputError, match=r"no seam 'W77'|unknown seam"):
        read_tour_input(TEE, station, ["W77"])
    inside = dataclasses.replace(station, d1_mm=400.0)
    with pytest.raises(InputError, match=r"home is in collision: .*write another home_deg"):
        plan_tour(inside, given.part, given.seams[:1], TourTargets())


def test_points_are_added_where_frames_are_far_apart(given):
    for seam in given.seams:
        task = seam_task(seam)
        assert np.diff(task.s_mm).max() <= 5.0 + 1e-9
        assert task.is_source.sum() == len(seam.frames)
        back = task.backwards()
        assert np.allclose(back.p, task.p[::-1], rtol=0, atol=0)
        assert np.allclose(np.linalg.det(back.R), 1.0, rtol=0, atol=1e-9)


def test_the_best_order_of_few_stops_is_found():
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


def _seconds(stops):
    at, total = np.zeros(2), 0.0
    for stop in stops:
        total += np.abs(stop.start[0] - at).max()
        at = stop.end[0]
    return total + np.abs(at).max()


def test_skip_welding_goes_far_away_each_time():
    stops = [Stop(np.zeros((1, 2)), np.zeros((1, 2)), np.zeros(1), np.array([100.0 * i, 0, 0])) for i in range(6)]
    order = find_order(stops, np.zeros(2), np.ones(2), WeldOrder.SKIP).stops
    assert sorted(order) == list(range(6))
    assert min(abs(a - b) for a, b in itertools.pairwise(order[:3])) >= 2


def test_a_cell_without_tool_data_is_one_line(tmp_path):
    record = station_record()
    record["torch_robot"]["T_flange_tool"] = None
    with pytest.raises(InputError, match="T_flange_tool is missing"):
        read_station(write_cell(tmp_path, record))


def test_the_map_finds_a_place_for_a_part_out_of_reach(given):
    station = fixed_station((1900.0, 0.0, 200.0))
    found = map_places(station, given.part, given.seams[:2], TourTargets(), range_mm=1200.0, step_mm=300.0)
    assert found.now == 0.0
    x, y, turn, share = found.best
    assert share == 1.0
    assert x <= -600.0
    check_record(json.loads(to_json(found.to_record("a cell"))))
    part = np.array([1900.0 + x, y, 200.0])
    if turn == 0.0:
        moved = fixed_station(tuple(part))
        plan = plan_tour(moved, given.part, given.seams[:2], TourTargets())
        assert plan.tour.welded_mm > 0.0
    picture = place_svg(found)
    assert picture.count("<rect") == 1 + found.share.size
    by_robot = map_places(
        station, given.part, given.seams[:2], TourTargets(), moved=Moved.ROBOT, range_mm=1200.0, step_mm=600.0
    )
    assert by_robot.best[0] >= 600.0
