"""The wire that the interpreters push against a part, compared with closed forms."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.touch_robots.robot import CrashError, Robot, Senses, Torch
from tests.touch_robots.solid import Solid, distance
from tests.touch_robots.sweep import way_to_contact
from wpcal.controllers.run.machine import ProgramError, rigid

ROUND_OFF_MM = 1e-6
RIM_MM = 2e-3
"""A rim of 90 corners is inside the circle of 0.6 mm by 0.4 µm, and twice that between two corners of two rims."""
RADIUS = 0.6
T_TOOL = rigid(Rotation.from_euler("xyz", [10, 35, 20], degrees=True).as_matrix(), [30.0, -5.0, 410.0])


def box(size=(100.0, 60.0, 40.0)):
    """Triangles of a box from the origin."""
    corners = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([corners[list(t)] for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def leaning(degrees, towards=(1.0, 0.0, 0.0)):
    """Return the axes of a tool whose z leans from straight down."""
    lean = Rotation.from_rotvec(np.radians(degrees) * np.cross([0.0, 0.0, -1.0], towards))
    return (lean * Rotation.from_euler("x", np.pi)).as_matrix()


def arm(at, rotation, senses=None, **torch):
    robot = Robot(Solid(box(), np.eye(4)), Torch(T_TOOL, **torch), senses)
    robot.move(rigid(rotation, at), T_TOOL, is_line=False)
    return robot


@pytest.mark.parametrize("degrees", [0.0, 20.0, 35.0, 60.0, 80.0])
def test_a_leaning_wire_meets_a_plane_with_its_rim(degrees):
    robot = arm([50.0, 30.0, 60.0], leaning(degrees))
    hit = robot.search(rigid(leaning(degrees), [50.0, 30.0, 30.0]), T_TOOL, 10.0)
    assert hit[2, 3] - 40.0 == pytest.approx(RADIUS * np.sin(np.radians(degrees)), abs=ROUND_OFF_MM)
    assert robot.is_on()


def test_the_side_of_an_upright_wire_meets_an_upright_face():
    robot = arm([-20.0, 30.0, 20.0], leaning(0.0))
    hit = robot.search(rigid(leaning(0.0), [10.0, 30.0, 20.0]), T_TOOL, 10.0)
    assert hit[0, 3] == pytest.approx(-RADIUS, abs=ROUND_OFF_MM)


def test_a_wire_meets_an_edge_above_its_tip():
    """The wire leans over the edge of the top face, 40 mm high: its side meets the edge."""
    tilt = leaning(-30.0)  # the tip is behind: the wire leans towards the part
    robot = arm([-20.0, 30.0, 35.0], tilt)
    hit = robot.search(rigid(tilt, [20.0, 30.0, 35.0]), T_TOOL, 10.0)
    along = tilt[:, 2]
    edge = np.cross(along, [0.0, 1.0, 0.0])
    gap = abs((hit[:3, 3] - [0.0, 30.0, 40.0]) @ edge) / np.linalg.norm(edge)
    assert gap == pytest.approx(RADIUS, abs=RIM_MM)


@pytest.mark.parametrize("seed", range(4))
def test_the_way_agrees_with_points_on_the_wire(seed):
    """Rays from very many points of the wire come close to the way from above, and are never shorter."""
    rng = np.random.default_rng(seed)
    triangles = np.concatenate([box(), rng.normal([50.0, 30.0, 60.0], 20.0, size=(30, 3, 3))])
    rotation = leaning(rng.uniform(0.0, 80.0), [np.cos(seed), np.sin(seed), 0.0])
    tip, axis = np.array([50.0, 30.0, 150.0]), rotation[:, 2]
    way = way_to_contact(triangles, tip, tip - 15.0 * axis, RADIUS, np.array([0.0, 0.0, -1.0]))
    angle, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 361), np.linspace(0.0, 15.0, 76))
    ring = np.cos(angle)[..., None] * rotation[:, 0] + np.sin(angle)[..., None] * rotation[:, 1]
    points = (tip + RADIUS * ring - height[..., None] * axis).reshape(-1, 3)
    ways = []
    for a, b, c in triangles:
        normal = np.cross(b - a, c - a)
        if abs(normal[2]) < ROUND_OFF_MM:
            continue
        t = (points - a) @ normal / normal[2]
        at = points - t[:, None] * [0.0, 0.0, 1.0]
        inside = np.all([np.cross(q - p, at - p) @ normal >= 0.0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
        ways.append(t[inside & (t > 0.0)].min(initial=np.inf))
    assert -RIM_MM < min(ways) - way < 0.1


def test_distances_agree_with_points():
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = rng.uniform(-40.0, 140.0, size=(2, 3))
        inside = np.all((a > 0.0) & (a < [100.0, 60.0, 40.0]))
        points = a + np.linspace(0.0, 1.0, 4001)[:, None] * (b - a)
        outside = np.maximum(0.0, np.maximum(-points, points - [100.0, 60.0, 40.0]))
        expected = np.linalg.norm(outside, axis=1).min()
        if not inside and expected > 0.0:
            assert distance(box(), a, b) == pytest.approx(expected, abs=1e-3)


def test_what_is_stored_is_late_and_scatters():
    late = arm([50.0, 30.0, 60.0], leaning(0.0), Senses(latency_s=0.02))
    assert late.search(rigid(leaning(0.0), [50.0, 30.0, 30.0]), T_TOOL, 10.0)[2, 3] == pytest.approx(39.8)
    stored = []
    rough = Senses(sigma_mm=0.1)
    for _ in range(200):
        robot = arm([50.0, 30.0, 45.0], leaning(0.0), rough)
        stored.append(robot.search(rigid(leaning(0.0), [50.0, 30.0, 35.0]), T_TOOL, 10.0)[:3, 3])
    assert np.std(stored, axis=0) == pytest.approx(np.full(3, 0.1), abs=0.015)


def test_a_search_beside_the_part_finds_nothing():
    robot = arm([-20.0, 30.0, 60.0], leaning(0.0))
    assert robot.search(rigid(leaning(0.0), [-20.0, 30.0, 20.0]), T_TOOL, 10.0) is None
    assert not robot.is_on()


def test_driving_into_the_part_is_told():
    robot = arm([50.0, 30.0, 60.0], leaning(0.0))
    with pytest.raises(CrashError, match=r"meets the part 20\.0"):
        robot.move(rigid(leaning(0.0), [50.0, 30.0, 39.0]), T_TOOL)
    robot = arm([-5.0, 30.0, 60.0], leaning(0.0), nozzle_radius_mm=10.0)
    with pytest.raises(CrashError, match="the nozzle meets the part"):
        robot.move(rigid(leaning(0.0), [-5.0, 30.0, 10.0]), T_TOOL)
    with pytest.raises(CrashError, match="signal does not come"):
        arm([50.0, 30.0, 60.0], leaning(0.0), Senses(never_on=True)).search(
            rigid(leaning(0.0), [50.0, 30.0, 30.0]), T_TOOL, 10.0
        )


def test_the_wire_leaves_what_it_touched():
    robot = arm([50.0, 30.0, 60.0], leaning(50.0), Senses(stop_s=0.05))
    robot.search(rigid(leaning(50.0), [50.0, 30.0, 30.0]), T_TOOL, 10.0)
    robot.move(rigid(leaning(50.0), [50.0, 30.0, 60.0]), T_TOOL)
    assert not robot.is_on()


def test_a_search_that_turns_is_refused():
    with pytest.raises(ProgramError, match="turns"):
        arm([50.0, 30.0, 60.0], leaning(0.0)).search(rigid(leaning(5.0), [50.0, 30.0, 30.0]), T_TOOL, 10.0)
