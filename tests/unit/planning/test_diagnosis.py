"""A cell that cannot be planned names the limit, the place, the bodies or the joint, and what would help."""

import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from tests.saddle import changed, scan_coarsely
from wpcal.core.records import to_json
from wpcal.core.schemas import schema_text
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import PLACE, TRAVEL, WORK
from wpcal.planning.cell.shape import Shape
from wpcal.planning.cell.workplace import LEAST_REGULARITY
from wpcal.planning.search.diagnosis import (
    Constraint,
    NoFeasiblePlanError,
    Obstacle,
    farthest_from_a_plan,
    nearest_to_a_plan,
    obstacle_at,
    too_near,
)
from wpcal.planning.search.ladder import build_ladder, ladder_obstacle, shortest_path
from wpcal.planning.search.pareto import failed_record
from wpcal.planning.search.path_diagnosis import no_plan, path_obstacle
from wpcal.planning.search.plan_seam import FIRST, judge_paths, sweep_paths
from wpcal.planning.search.reachable_states import ReachablePlace, find_reachable_places

BLOCKED = 4  #: Point of the coarse seam that a lug blocks: the last scanned points are 0, 2, 4, 5, 7 and 9.


@pytest.fixture
def way(coarse, searched):
    """A place and branches from which the coarse seam is planned."""
    path = searched.swept[7]
    return path.coordinates[len(path.coordinates) // 2, PLACE], path.branches


def with_lug(problem, point, radius_mm, beside_mm=14.0):
    """A ball beside the nozzle at one point of the seam."""
    R, p = problem.path.R[point], problem.path.p[point]
    centre = [p + 40.0 * R[:, 2] + beside_mm * R[:, 1]]
    lug = Shape("lug", centre, centre, [radius_mm])
    return replace(problem, cell=replace(problem.cell, part=(*problem.cell.part, lug)))


def narrowed(arm, joint, low_deg, high_deg):
    """The arm with other limits of one joint."""
    joints = list(arm.joints)
    joints[joint] = replace(joints[joint], min_rad=np.radians(low_deg), max_rad=np.radians(high_deg))
    return replace(arm, joints=tuple(joints))


def test_a_point_that_is_free_has_no_obstacle(coarse, way):
    assert obstacle_at(coarse, *way, BLOCKED) is None


def test_two_bodies_that_are_too_near_are_named_with_the_best_distance(coarse, way):
    blocked = with_lug(coarse, BLOCKED, 18.0)
    found = obstacle_at(blocked, *way, BLOCKED)
    assert found.constraint is Constraint.CLEARANCE
    assert found.between == ("robot 1 nozzle", "robot 2 lug")
    assert found.s_mm == pytest.approx(coarse.path.s_mm[BLOCKED], abs=1e-9)
    assert (found.asked, found.unit) == (3.0, "mm")
    assert found.best < 3.0
    assert f"at s = {found.s_mm:.1f} mm, 3 mm asked" in found.says
    # the distance is the truth: with a smaller one asked the point is free, with a torch that may lean
    wide = replace(blocked.cell.torch[0], to_part_mm=found.best - 1e-6)
    eased = replace(blocked, cell=replace(blocked.cell, torch=(wide, *blocked.cell.torch[1:])))
    after = obstacle_at(eased, *way, BLOCKED)
    assert after is None or after.constraint is Constraint.TORCH_ANGLES


def test_a_torch_that_would_have_to_lean_is_told_how_far(coarse, way):
    found = obstacle_at(with_lug(coarse, BLOCKED, 5.0), *way, BLOCKED)
    assert found.constraint is Constraint.TORCH_ANGLES
    assert found.between == ("robot 1 nozzle", "robot 2 lug")
    assert "--work-angle-deg" in found.advice
    assert "--travel-angle-deg" in found.advice


@pytest.mark.parametrize("robot", [1, 2])
def test_a_joint_limit_is_named_with_its_joint(coarse, way, robot):
    place, branches = way
    cell = coarse.cell
    name = "arm" if robot == 1 else "arm2"
    tight = replace(coarse, cell=changed(cell, **{name: narrowed(getattr(cell, name), 1, 178.0, 179.0)}))
    found = obstacle_at(tight, place, branches, BLOCKED, leans=(0.0,))
    assert found.constraint is Constraint.JOINT_LIMITS
    assert (found.robot, found.joint, found.unit) == (robot, "L", "deg")
    assert found.best > 0
    wide = narrowed(getattr(cell, name), 1, 178.0 - found.best - 1e-6, 179.0 + found.best + 1e-6)
    eased = replace(coarse, cell=changed(cell, **{name: wide}))
    after = obstacle_at(eased, place, branches, BLOCKED, leans=(0.0,))  # other joints may be beyond, by less
    assert after is None or after.constraint is not Constraint.JOINT_LIMITS or after.best < found.best


def test_a_place_out_of_reach_is_named_with_the_distance(coarse, way, golden):
    found = obstacle_at(coarse, way[0] + [0.0, 0.0, 3000.0], way[1], BLOCKED, leans=(0.0,))
    assert found.constraint is Constraint.REACH
    assert found.robot in {1, 2}
    assert found.best > 1000
    golden(found)


def test_a_singular_pose_is_named(coarse, way, monkeypatch):
    monkeypatch.setattr("wpcal.planning.search.diagnosis.LEAST_REGULARITY", 1.1)
    found = obstacle_at(coarse, *way, BLOCKED, leans=(0.0,))
    assert found.constraint is Constraint.SINGULAR_POSES
    assert LEAST_REGULARITY < found.best < 1.1


def test_a_ladder_names_its_worst_rung(coarse, way, golden):
    blocked = with_lug(coarse, BLOCKED, 18.0)
    ladder = build_ladder(blocked, ReachablePlace(*way, 0))
    assert shortest_path(blocked, ladder, FIRST) is None
    found = ladder_obstacle(blocked, ladder, FIRST)
    assert found.between == ("robot 1 nozzle", "robot 2 lug")
    assert abs(found.s_mm - coarse.path.s_mm[BLOCKED]) <= np.diff(coarse.path.s_mm).max()
    golden(found)


def test_a_torch_that_must_lean_at_one_place_leans_there_only(coarse, way):
    blocked = with_lug(coarse, BLOCKED, 5.0)
    assert shortest_path(blocked, build_ladder(blocked, ReachablePlace(*way, 0)), FIRST) is None
    ladder = build_ladder(blocked, ReachablePlace(*way, 0), leaning=True)
    assert shortest_path(blocked, ladder, FIRST) is not None
    for rung, attitude, joints in zip(ladder.rungs, ladder.attitude, ladder.joints, strict=True):
        assert capsule_clearance(blocked.cell, joints).is_clear.all()
        lean = np.abs(ladder.coordinates[attitude][:, [WORK, TRAVEL]]).max()
        assert lean <= blocked.targets.torch_range_rad + 1e-12
        assert (lean > 0) == (rung == BLOCKED)


def test_a_search_without_a_way_says_why_and_not_only_that(coarse, way, monkeypatch):
    blocked = with_lug(coarse, BLOCKED, 18.0)
    monkeypatch.setattr("wpcal.planning.search.plan_seam.find_reachable_places", lambda *_: [ReachablePlace(*way, 0)])
    with pytest.raises(NoFeasiblePlanError, match=r"robot 1 nozzle and robot 2 lug: at best .* mm asked") as failed:
        next(sweep_paths(blocked, lambda *_: None))
    record = failed_record(blocked, str(failed.value), failed.value.obstacle)
    jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/pareto/1"))).validate(json.loads(to_json(record)))
    assert record["obstacle"]["between"] == ("robot 1 nozzle", "robot 2 lug")
    assert record["obstacle"]["best"] < record["obstacle"]["asked"] == 3.0


def test_a_scan_without_a_clear_place_names_the_point(coarse, monkeypatch):
    scan_coarsely(monkeypatch)
    blocked = with_lug(coarse, BLOCKED, 18.0)
    with pytest.raises(NoFeasiblePlanError, match="no feasible plan: clearance fails most; from no place") as failed:
        find_reachable_places(blocked, 1)
    assert failed.value.obstacle.between == ("robot 1 nozzle", "robot 2 lug")
    assert failed.value.obstacle.s_mm == pytest.approx(coarse.path.s_mm[BLOCKED], abs=1e-9)


def test_paths_that_are_too_near_between_their_points_name_the_bodies(thin, searched):
    """Hulls larger than their capsules: the search does not see what the check measures."""
    nozzle = thin.cell.torch[0]
    hull = [[x, y, z] for x in (-19, 19) for y in (-19, 19) for z in (-90, -20)]
    wide = replace(nozzle, hull=hull)
    loose = replace(thin, cell=replace(thin.cell, torch=(wide, *thin.cell.torch[1:])))
    with pytest.raises(NoFeasiblePlanError, match="clearance fails most, between the points of every path: ") as failed:
        judge_paths(loose, searched.swept[:1])
    found = failed.value.obstacle
    assert found.between[0] == "robot 1 nozzle"
    assert found.best < found.asked == 3.0
    assert "the capsules of robot 1 nozzle do not hold its hull" in found.advice


@pytest.mark.parametrize("constraint", [c for c in Constraint if c is not Constraint.REACH])
def test_every_limit_names_where_the_best_path_breaks_it(thin, searched, constraint, monkeypatch, golden):
    path = searched.swept[7]
    broken = {
        Constraint.JOINT_LIMITS: replace(thin, cell=changed(thin.cell, arm2=narrowed(thin.cell.arm2, 5, 300.0, 301.0))),
        Constraint.CLEARANCE: with_lug(thin, 9, 18.0),
        Constraint.JOINT_SPEEDS: replace(thin, speed_mm_s=5000.0),
        Constraint.WELD_POSITION: replace(
            thin, targets=replace(thin.targets, slope_rad=0.0, slope_range_rad=0.001, rotation_range_rad=0.001)
        ),
        Constraint.TORCH_ANGLES: replace(thin, targets=replace(thin.targets, work_rad=0.5, torch_range_rad=0.001)),
    }.get(constraint, thin)
    if constraint is Constraint.SINGULAR_POSES:
        monkeypatch.setattr("wpcal.planning.search.problem.LEAST_REGULARITY", 1.1)
    if constraint is Constraint.WELD_ZONE:
        path = replace(path, coordinates=path.coordinates + np.eye(9)[0] * 900.0)
    found = path_obstacle(broken, [path], constraint)
    assert found.constraint is constraint
    assert thin.path.s_mm[0] <= found.s_mm <= thin.path.s_mm[-1]
    assert found.best is not None
    assert found.asked is not None
    assert str(no_plan(broken, [path])).startswith("no feasible plan: ")
    golden([found, str(no_plan(broken, [path]))])


def test_a_path_that_leaves_the_reach_names_the_robot(thin, searched):
    path = searched.swept[7]
    joints = path.joints.copy()
    joints[5:, 6:] = np.nan
    found = path_obstacle(thin, [replace(path, joints=joints)], Constraint.REACH)
    assert (found.robot, found.s_mm) == (2, thin.path.s_mm[5])


def test_a_later_limit_is_nearer_to_a_plan():
    far, near = (too_near(("a", "b"), 1.0, best, 3.0) for best in (-20.0, 2.0))
    reach = Obstacle(constraint=Constraint.REACH, says="out of reach", best=1.0, asked=0.0)
    assert nearest_to_a_plan([reach, far, None, near]) is near
    assert farthest_from_a_plan([near, None, far, reach]) is reach
    assert nearest_to_a_plan([None]) is None


def test_capsules_that_overlap_are_not_a_negative_distance():
    assert "overlapping by 20.0 mm at s = 1.0 mm, 3 mm asked" in too_near(("a", "b"), 1.0, -20.0, 3.0).says
