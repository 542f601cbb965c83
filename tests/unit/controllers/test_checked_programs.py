"""No program leads the torch into the part: at the seams, between them, and above them.

The distance here is found in another way than in wpcal: the part's triangles become a cloud of points, and each point
is compared with the torch's axis at short steps of every move.
"""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation, Slerp

from tests.few import few
from tests.unit.conftest import CONFIGURATIONS, box_mesh, plate
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb, write_part_glb
from wpcal.cli.main import run
from wpcal.controllers.program import ControllerSettings, MotionSettings, build_program
from wpcal.controllers.program.air_moves import LARGEST_TURN_RAD, AirSettings, TorchAtTool, _turn_between
from wpcal.controllers.program.checked_program import check_program
from wpcal.controllers.registry import exporter_named
from wpcal.core.errors import GeometryError, InputError
from wpcal.results.folder import read_finished
from wpcal.robot.torch.attitude import ToolAxis, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.weld.runs import RunChoice

pytestmark = pytest.mark.many
FIXTURES = Path(__file__).parents[3] / "fixtures"
PARTS = ("tee", "frame")
NOZZLE_MM, LENGTH_MM = 11.0, 300.0
LEAST_MM = 1.0
STEP_MM = 6.0
"""Of places along a move, and of points along the torch: at 14 mm from the part that misses at most 1 mm."""
CLOUD_MM = 1.5  #: Distance of neighbours in the cloud; no point of a triangle is farther than 0.6 of it from the cloud.


def cloud(program):
    """A tree of points on all triangles of the part, in base."""
    points = []
    for solid in read_part_glb(program.part_glb).solids:
        for a, b, c in program.T_base_part.apply(solid.points)[solid.triangles]:
            longest = max(np.linalg.norm(b - a), np.linalg.norm(c - a), np.linalg.norm(c - b))
            n = max(1, int(np.ceil(longest / CLOUD_MM)))
            i, j = (side[:, None] / n for side in np.triu_indices(n + 1))
            j = (j * n - i * n) / n
            points.append(a + i * (b - a) + j * (c - a))
    return KDTree(np.concatenate(points))


def least_distance(points, p0, p1, R0, R1):
    """Least distance of a cloud from a nozzle of 11 mm that is moved along a line, from the wire's tip on.

    What is farther than `LEAST_MM` is not measured: infinite.
    """
    turn = (Rotation.from_matrix(R0).inv() * Rotation.from_matrix(R1)).magnitude()
    n = max(2, int(np.ceil((np.linalg.norm(p1 - p0) + turn * LENGTH_MM) / STEP_MM)))
    t = np.linspace(0, 1, n + 1)
    wires = Slerp([0, 1], Rotation.from_matrix([R0, R1]))(t).as_matrix()[:, :, 2]
    tips = p0 + t[:, None] * (p1 - p0)
    back = np.arange(0.0, LENGTH_MM + STEP_MM, STEP_MM)
    axis = tips[:, None] - back[:, None] * wires[:, None]
    off = NOZZLE_MM + 0.6 * CLOUD_MM
    return points.query(axis.reshape(-1, 3), distance_upper_bound=off + 2 * LEAST_MM)[0].min() - off


def moves_in_the_air(program):
    """The linear moves of a checked program that are neither welded nor along the wire at a seam."""
    p, R = [program.safe_point.p_base], [program.safe_point.R_base]
    for path in program.paths:
        rows = path.weld_rows
        yield_p = np.concatenate([*p, path.p_base[: rows.start]])
        yield_R = np.concatenate([*R, path.R_base[: rows.start]])
        yield path.seam.name, yield_p, yield_R
        p, R = [path.p_base[rows.stop :]], [path.R_base[rows.stop :]]
    yield (
        "the safe point",
        np.concatenate([*p, program.safe_point.p_base]),
        np.concatenate([*R, program.safe_point.R_base]),
    )


def program_of(part):
    return build_program(read_finished(FIXTURES / part / "golden").select())


@pytest.mark.parametrize("part", few(PARTS, 1))
def test_no_move_between_seams_comes_near_the_part(part):
    program = check_program(program_of(part))
    points = cloud(program)
    for name, p, R in moves_in_the_air(program):
        for i in range(len(p) - 1):
            assert least_distance(points, p[i], p[i + 1], R[i], R[i + 1]) >= LEAST_MM, f"{part}, to {name}, move {i}"


@pytest.mark.parametrize(("part", "hits"), few([("tee", {"W2-W3"}), ("frame", None)], 1))
def test_the_check_of_this_test_finds_what_direct_moves_hit(part, hits):
    program = program_of(part)
    points = cloud(program)
    found = {
        f"{a.seam.name}-{b.seam.name}"
        for a, b in zip(program.paths[:-1], program.paths[1:], strict=True)
        if least_distance(points, a.p_base[-1], b.p_base[0], a.R_base[-1], b.R_base[0]) < 0
    }
    assert found == hits if hits else len(found) >= 4


def in_part(finished, *solids, **by):
    """The finished folder's program with more solids in its part."""
    solids = plate(*solids, sha256=read_part_glb(finished.part_glb).sha256)
    return dataclasses.replace(build_program(finished, **by), part_glb=write_part_glb(solids))


@pytest.mark.parametrize(
    ("solid", "where", "what"),
    [
        (((40.5, -30, 30), (56, 30, 60)), "point 3", "nozzle"),
        (((44, -5, 0), (46, 5, 9)), "between points 4 and 5", "tip"),
        (((44, -5, 3), (46, 5, 9)), "between points 4 and 5", "wire"),
        (((-900, -900, 0), (900, 900, 900)), "point 0", "tip"),
    ],
)
def test_a_seam_that_runs_through_another_solid_is_refused(finished_folder, solid, where, what):
    program = in_part(read_finished(finished_folder()).select(["W1"]), box_mesh("block", *solid))
    message = rf"seam W1: {where}, base .*: the {what} is inside 'block' \(a straight torch"
    with pytest.raises(GeometryError, match=message):
        check_program(program)


def test_what_cannot_be_written_is_left_out_by_name(finished_folder):
    finished = read_finished(finished_folder()).select(everything=True)
    program = in_part(finished, box_mesh("block", (44, -5, 0), (46, 5, 9)))
    first, other, *_ = program.paths
    above = dataclasses.replace(other, p_base=other.p_base + 100.0 * program.T_base_part.R[:, 2])
    found = check_program(dataclasses.replace(program, paths=(first, above)), strict=False)
    assert [path.seam.name for path in found.paths] == [other.seam.name]
    assert "the tip is inside 'block'" in found.left_out.pop(first.seam.name)
    assert not found.left_out


@pytest.mark.parametrize(
    ("ceiling_mm", "from_mm", "asked_mm", "back_mm"),
    [(352, -150, 50, (25, 25)), (420, -150, 50, (50, 50)), (420, -150, 400, (100, 100)), (345, 60, 50, (50, 25))],
)
def test_an_approach_is_nearer_where_no_way_leads_on_from_it(finished_folder, ceiling_mm, from_mm, asked_mm, back_mm):
    """At 50 mm the torch of 300 mm ends less than 3 mm below the lower ceiling; from 400 mm on it goes through it."""
    ceiling = box_mesh("ceiling", (from_mm, -200, ceiling_mm), (250, 200, ceiling_mm + 5))
    motion = MotionSettings(approach_mm=asked_mm, retract_mm=asked_mm)
    program = in_part(read_finished(finished_folder()).select(["W1"]), ceiling, motion=motion)
    checked = check_program(program, air=AirSettings(up_base=tuple(program.T_base_part.R[:, 2])))
    ends = zip(("approach", "retract"), back_mm, strict=True)
    shorter = ", ".join(f"{word} {mm} mm" for word, mm in ends if mm < asked_mm)
    assert [f"SHORTER at W1: {shorter}: no room for more"] * bool(shorter) == [
        line for line in checked.checked if "SHORTER" in line
    ]
    (path,) = checked.paths
    first, stop = path.weld_rows.start, path.weld_rows.stop
    back = path.p_base[[first - 1, stop]] - path.p_base[[first, stop - 1]]
    np.testing.assert_allclose(back @ program.T_base_part.R[:, 2], back_mm, rtol=0, atol=1e-9)


def test_a_torch_with_less_room_than_the_least_way_is_refused(finished_folder):
    ceiling = box_mesh("ceiling", (-150, -200, 303.5), (250, 200, 310))
    program = in_part(read_finished(finished_folder()).select(["W1"]), ceiling)
    with pytest.raises(GeometryError, match="line of the wire, from 5 mm on, before it"):
        check_program(program, air=AirSettings(up_base=tuple(program.T_base_part.R[:, 2])))


@pytest.mark.parametrize(
    "solids",
    [
        [((-13, -30, 0), (-12, 30, 500))],
        [
            ((-30, -30, 380), (130, 30, 390)),
            *(((x, -200, 0), (x + 9, 300, 60)) for x in (-200, 291)),
            *(((-200, y, 0), (300, y + 9, 60)) for y in (-200, 291)),
        ],
    ],
)
def test_a_torch_leaves_a_narrow_place(finished_folder, solids):
    """Beside the wall it has 1 mm of room; under the ceiling it can only go askew."""
    boxes = [box_mesh(f"solid {i}", *corners) for i, corners in enumerate(solids)]
    program = in_part(read_finished(finished_folder()).select(["W1"]), *boxes)
    program = check_program(program, air=AirSettings(up_base=tuple(program.T_base_part.R[:, 2])))
    points = cloud(program)
    ways = [
        [least_distance(points, *p[i : i + 2], *R[i : i + 2]) for i in range(len(p) - 1)]
        for _, p, R in moves_in_the_air(program)
    ]
    near = max(sum(each < LEAST_MM for each in least) for least in ways)
    assert min(map(min, ways)) >= 0.0
    assert near == any(note.startswith("NEARER") and "W1" in note for note in program.checked)


def test_a_seam_that_the_torch_cannot_leave_is_named(finished_folder):
    low, high, thick = np.array([-500, -500, -70]), np.array([600, 500, 430]), 10 * np.eye(3)
    flat = np.diag(high - low)
    corners = [(low, high - flat[i] + thick[i]) for i in range(3)] + [
        (low + flat[i] - thick[i], high) for i in range(3)
    ]
    walls = [box_mesh(f"wall {i}", *map(tuple, each)) for i, each in enumerate(corners)]
    program = in_part(read_finished(finished_folder()).select(["W1"]), *walls)
    with pytest.raises(GeometryError, match="seam W1: no checked way leads to it"):
        check_program(program)


def test_a_folder_without_the_parts_triangles_is_refused(finished_folder, capsys, tmp_path):
    folder = finished_folder()
    (folder / "part.glb").unlink()
    with pytest.raises(InputError, match=r"has no part\.glb.*run wpcal calibrate again"):
        check_program(build_program(read_finished(folder).select()))
    with pytest.raises(SystemExit) as ended:
        run(["export", str(folder), "-f", "rapid", "-o", str(tmp_path / "out")])
    assert ended.value.code == 2
    assert not (tmp_path / "out").exists()


JOINT_MOVES = {
    "rapid": ("MoveJ ", 1),
    "krl": ("PTP ", 3),  # home, the safe point, home
    "fanuc": ("J P[", 1),
    "inform": ("MOVJ ", 1),
    "urscript": ("movej(", 1),
    "val3": ("movej(", 1),
    "as": ("JMOVE ", 1),
    "pdl2": ("MOVE JOINT ", 1),
}


@pytest.mark.parametrize("name", [*JOINT_MOVES, "json", "csv", "ros", "compas", "tesseract"])
def test_a_program_has_one_joint_move_and_says_what_was_not_checked(name):
    program = build_program(
        read_finished(FIXTURES / "tee" / "golden").select(),
        controller=ControllerSettings(configurations=CONFIGURATIONS),
    )
    files = exporter_named(name).write(check_program(program))
    text = "\n".join(files.values())
    if name != "csv":
        assert "RUN IT DRY FIRST" in re.sub(r"[^A-Z]+", " ", text)
    if name in JOINT_MOVES:
        word, count = JOINT_MOVES[name]
        code = [
            line for line in text.splitlines() if not line.lstrip(" 0123456789:").startswith(("!", ";", "'", "#", "//"))
        ]
        assert sum(line.count(word) for line in code) == count


def points_on(corners, count):
    """Return points on triangles, shape (n, m, 3), with so many steps along each side."""
    i, j = np.array([(i, j) for i in range(count + 1) for j in range(count + 1 - i)]).T[..., None] / count
    return corners[:, :1] + i * (corners[:, 1:2] - corners[:, :1]) + j * (corners[:, 2:] - corners[:, :1])


@pytest.mark.parametrize("radius", [8.0, (3.5, 9.0), (9.0, 5.0)], ids=["tube", "cone", "cone backwards"])
@pytest.mark.parametrize("seed", few(range(5), 2))
def test_a_tube_meets_what_a_cloud_of_points_meets(seed, radius, random_place):
    rng = np.random.default_rng(seed)
    mesh, T = plate(), random_place(seed)
    part = TriangleMaterial.of(mesh, T)
    tips, back = T.apply(rng.uniform((-60, -90, -40), (160, 90, 40), (60, 3))), rng.normal(size=(60, 3))
    back /= np.linalg.norm(back, axis=1)[:, None]
    low, high = np.full(60, 5.0), np.full(60, 60.0)
    first, last = radius if isinstance(radius, tuple) else (radius, radius)
    on = points_on(part.corners, 120).reshape(-1, 3)
    hits = part.tube_solids(tips, back, low, high, radius) >= 0
    for row in range(60):
        z = (on - tips[row]) @ back[row]
        r = np.linalg.norm(on - tips[row] - z[:, None] * back[row], axis=1)
        wide = first + (last - first) * (z - 5) / 55
        surely = ((z > 5) & (z < 60) & (r < wide)).any()
        maybe = ((z > 4) & (z < 61) & (r < wide + 1)).any()
        assert surely <= hits[row] <= maybe


def test_a_torch_that_is_no_torch_is_refused():
    for wrong in ({"wire_mm": 0.0}, {"nozzle_radius_mm": float("nan")}, {"wire_mm": 400.0}):
        with pytest.raises(InputError, match="torch"):
            TorchShape(**wrong)


def test_a_ring_is_welded_on_over_its_start():
    finished = read_finished(FIXTURES / "saddle" / "golden").select(["W1"])
    (ring,) = build_program(finished).paths
    (path,) = build_program(finished, choice=RunChoice(overlap_mm=12.0)).paths
    own, more = ring.p_base[ring.weld_rows], path.p_base[path.weld_rows]
    s = path.seam.frames.s_mm
    assert (ring.seam.closed, path.seam.closed, s[-1] - s[len(own) - 1]) == (True, False, pytest.approx(12.0))
    again = np.stack([np.interp(s[len(own) - 1 :] - s[len(own) - 1], s[: len(own)], axis) for axis in own.T], axis=1)
    assert np.abs(more[len(own) - 1 :] - again).max() < 0.2  # the torch also leans between two frames
    assert path.u95_mm is not None
    assert len(path.u95_mm) == len(more)
    with pytest.raises(InputError, match="is a ring of 160 mm"):
        build_program(finished, choice=RunChoice(overlap_mm=200.0))


def test_a_longer_wire_is_ahead_of_the_tool_on_the_way_to_its_seam():
    usual = TorchAtTool(USUAL_TORCH, ToolAxis.Z, 2.0)
    ends, radii = usual.pieces
    longer, same = dataclasses.replace(usual, more_wire_mm=15.0).pieces
    assert (longer - ends)[0, 0].tolist() == pytest.approx([0.0, 0.0, 15.0])
    assert (longer - ends).reshape(-1, 3)[1:] == pytest.approx(0.0)
    assert same == pytest.approx(radii)


@pytest.mark.parametrize("axis", ToolAxis)
def test_between_two_orientations_the_wire_swings_evenly_in_small_turns(axis):
    rng = np.random.default_rng(5)
    for a, b in Rotation.random(200, rng=rng).as_matrix().reshape(-1, 2, 3, 3):
        turns = _turn_between(a, b, axis)
        np.testing.assert_allclose(turns[[0, -1]], [a, b], rtol=0, atol=1e-12)
        steps = Rotation.from_matrix(turns[:-1].swapaxes(1, 2) @ turns[1:]).magnitude()
        assert steps.max() <= LARGEST_TURN_RAD + 1e-9
        if len(turns) > 2:
            wires = wire_directions(turns, axis)
            swung = np.arccos(np.clip(wires @ wires[0], -1, 1))
            np.testing.assert_allclose(swung, np.linspace(0, swung[-1], len(turns)), rtol=0, atol=1e-6)
            assert len(turns) <= 2 + 2 * np.pi / LARGEST_TURN_RAD
