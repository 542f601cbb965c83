"""Seams that a person marked in the CAD file or picks on the part."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cad.kernel.primitives import box as plate
from cad.kernel.to_brep import to_brep
from cad.samples.parts import box
from cad.workpiece.calibrate import calibrate_files
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.running import run_here
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import InputError
from wpcal.seam import Seam, SeamOptions, SeamSource, detect_seams
from wpcal.seam.find.marked import MarkedEdges
from wpcal.seam.judge.last_check import refuse_frames_in_material

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
pytestmark = pytest.mark.usefixtures("kernel_here")
EXACT_MM = 1e-6  #: Places on straight edges; a contact is bisected to 2e-9 mm.


def with_named_edges(folder: Path, names: dict[tuple[float, ...], str]) -> Path:
    """Name edges of the T-joint's STEP text by the coordinates of their two vertices, all six sorted."""
    text = (TEE / "tee.step").read_text(encoding="utf-8")
    entities = dict(re.findall(r"#(\d+) = ([A-Z_]+\(.*?\));", text, flags=re.DOTALL))

    def point(vertex: str) -> list[float]:
        place = entities[re.findall(r"#(\d+)", entities[vertex])[0]]
        return [round(float(v), 6) for v in re.findall(r"\(([-0-9.E+]+),([-0-9.E+]+),([-0-9.E+]+)\)", place)[0]]

    named = 0
    for number, entity in entities.items():
        if entity.startswith("EDGE_CURVE("):
            ends = re.findall(r"#(\d+)", entity)[:2]
            key = tuple(sorted(point(ends[0]) + point(ends[1])))
            if key in names:
                old = f"#{number} = EDGE_CURVE('',"
                assert text.count(old) == 1
                text = text.replace(old, f"#{number} = EDGE_CURVE('{names[key]}',")
                named += 1
    assert named == len(names)
    path = folder / "named.step"
    path.write_text(text, encoding="utf-8")
    return path


def chosen(part: Path, *marked: str, edges: tuple[str, ...] = ()) -> tuple[list[Seam], list[Seam]]:
    seams = find_seams(open_workpiece(part), SeamOptions(), SeamChoice((), marked, edges))[0]
    return [s for s in seams if s.accepted], [s for s in seams if not s.accepted]


FRONT = tuple(sorted([25.0, 56.0, 10.0, 175.0, 56.0, 10.0]))
TOP = tuple(sorted([25.0, 56.0, 90.0, 175.0, 56.0, 90.0]))


def test_a_named_edge_on_a_contact_is_that_contact(tmp_path: Path) -> None:
    part = with_named_edges(tmp_path, {FRONT: "WELD_1"})
    (seam,), others = chosen(part, "WELD_*")
    (twin,) = [s for s in find_seams(open_workpiece(part), SeamOptions())[0] if s.name == seam.name]
    assert (seam.source, seam.joint, seam.solids) == (SeamSource.MARKED, twin.joint, twin.solids)
    assert "marked: WELD_1" in seam.reasons
    np.testing.assert_array_equal(seam.frames.R, twin.frames.R)
    assert all("other edges are marked, and not this one" in other.against for other in others)
    assert len(others) == 3


def test_a_named_edge_off_any_contact_has_its_own_faces(tmp_path: Path) -> None:
    part = with_named_edges(tmp_path, {FRONT: "WELD_1", TOP: "WELD_2"})
    seams, _ = chosen(part, "WELD_2")
    (seam,) = seams
    assert (seam.solids, seam.weld.value, seam.accepted) == (("web",), "groove", True)
    z = np.array([0.0, -1.0, 1.0]) / np.sqrt(2)
    np.testing.assert_allclose(seam.frames.R[:, :, 2], np.broadcast_to(z, (len(seam.frames), 3)), rtol=0, atol=1e-9)
    assert len(chosen(part, "WELD_?")[0]) == 2


def test_wires_in_a_group_stand_for_the_contacts_they_lie_on(tmp_path: Path) -> None:
    """The edges that calibrate --mark-seams writes are read again by name, layer and colour."""
    calibrate_files(TEE / "tee.step", TEE / "taught_exact.csv", tmp_path / "out", overwrite=False, mark_seams=True)
    moved = tmp_path / "out" / "tee.calibrated.step"
    for pattern, count in (("W*", 2), ("W2", 1), ("wpcal seams", 2)):
        seams, others = chosen(moved, pattern)
        assert (len(seams), len(others)) == (count, 4 - count)
        assert all(seam.source is SeamSource.MARKED and seam.joint.value == "tee" for seam in seams)
    marks = open_workpiece(moved).source.step.marks
    red, green, blue = (round(255 * v) for v in marks[0].color_rgb)
    assert len(chosen(moved, f"#{red:02x}{green:02x}{blue:02X}")[0]) == 2


def test_edges_are_picked_by_place_and_by_feature() -> None:
    (seam,), others = chosen(TEE / "tee.step", edges=("100,56.4,10.2",))
    assert len(others) == 3
    np.testing.assert_allclose(seam.frames.p[[0, -1]], [[25, 56, 10], [175, 56, 10]], rtol=0, atol=EXACT_MM)
    middle = next(
        feature.name
        for feature in open_workpiece(TEE / "tee.step").features
        if np.allclose(feature.p_mm, [100, 56, 90], rtol=0, atol=EXACT_MM)
    )
    (top,), _ = chosen(TEE / "tee.step", edges=(middle,))
    assert f"marked: picked at {middle}" in top.reasons
    assert len(chosen(TEE / "tee.step", edges=("100,56,10", "100,64,10"))[0]) == 2


@pytest.mark.parametrize(
    ("marked", "edges", "message"),
    [
        (("WELD_*",), (), "no edge or wire has the name, layer or colour 'WELD_*'"),
        ((), ("1,2",), "the edge '1,2': expected x,y,z in mm or the name of a feature"),
        ((), ("0,0,500",), "no edge is within 2 mm of 0,0,500; the nearest is"),
        ((), ("M999",), "M999"),
    ],
)
def test_what_is_not_there_is_refused(marked: tuple[str, ...], edges: tuple[str, ...], message: str) -> None:
    with pytest.raises(InputError) as caught:
        chosen(TEE / "tee.step", *marked, edges=edges)
    assert message in str(caught.value)


def test_shapes_from_a_script_have_no_marks() -> None:
    workpiece = Workpiece(to_brep([("block", box(50, 50, 10, (0, 0, 0)))]))
    with pytest.raises(InputError, match="none in this file has a name or a layer"):
        find_seams(workpiece, SeamOptions(), SeamChoice(marked=("W*",)))


def test_the_commands_take_marks() -> None:
    done = run_here("seams", TEE / "tee.step", "--edge", "100,56,10", "--edge", "25,60,10", "--all")
    assert (done.returncode, done.stderr) == (0, "")
    assert "other edges are" in done.stdout


@pytest.mark.parametrize("gap_mm", [0.8, 1.2, 2.6])
def test_an_edge_beyond_the_gap_takes_the_face_that_it_nearly_touches(gap_mm: float) -> None:
    """The gap was taken for the open air: the bisector of the edge's own faces led into the plate below."""
    solids = [("plate", box(300, 200, 10, (0, 0, -10))), ("wall", box(200, 8, 80, (50, 96, gap_mm)))]
    graph = to_brep(solids)
    middle = (graph.edge_range[:, 0] + graph.edge_range[:, 1]) / 2
    p = evaluate_edges(graph, np.arange(graph.edge_count), middle)[0]
    edge = int(np.argmin(np.linalg.norm(p - [150.0, 96.0, gap_mm], axis=1)))
    marked = MarkedEdges(np.array([edge]), ("picked",))
    (seam,) = [s for s in detect_seams(graph, marked=marked) if s.accepted]
    assert (seam.joint.value, seam.weld.value, set(seam.solids)) == ("tee", "fillet", {"plate", "wall"})
    assert seam.length_mm == pytest.approx(200.0, rel=0, abs=EXACT_MM)
    np.testing.assert_allclose(
        seam.frames.R[:, :, 2], np.tile([0, -(0.5**0.5), 0.5**0.5], (len(seam.frames), 1)), atol=1e-9
    )
    assert any(text.startswith(f"up to {gap_mm:.2f} mm from the other member") for text in seam.reasons)


def test_no_frame_that_points_into_material_is_left_accepted() -> None:
    graph = to_brep(
        [("base", plate(100.0, 60.0, 10.0, (0.0, 0.0, 0.0))), ("web", plate(100.0, 8.0, 60.0, (0.0, 20.0, 10.0)))]
    )
    trimmed = TrimmedFaces.of(graph)
    seams = [seam for seam in detect_seams(graph) if seam.accepted]
    assert len(seams) >= 2
    assert refuse_frames_in_material(graph, trimmed, seams, SeamOptions()) == tuple(seams)
    wrong = replace(seams[0], frames=replace(seams[0].frames, R=seams[0].frames.R * np.array([1.0, -1.0, -1.0])))
    refused, *others = refuse_frames_in_material(graph, trimmed, [wrong, *seams[1:]], SeamOptions())
    assert others == seams[1:]
    assert not refused.accepted
    assert not refused.reachable
    assert set(refused.inside) <= {"base", "web"}
    assert refused.inside
    assert "the wire would point into" in refused.against[0]


def test_an_added_edge_is_a_seam_beside_those_that_are_found() -> None:
    workpiece = open_workpiece(TEE / "tee.step")
    usual = find_seams(workpiece, SeamOptions())[0]
    more = find_seams(workpiece, SeamOptions(), SeamChoice(added_edges=("100,0,10",)))[0]
    *kept, added = more
    assert [(s.name, s.accepted, s.confidence, s.reasons) for s in kept] == [
        (s.name, s.accepted, s.confidence, s.reasons) for s in usual
    ]
    assert (added.name, added.accepted, added.source) == ("W5", True, SeamSource.ADDED)
    np.testing.assert_allclose(added.frames.p[[0, -1]], [[0, 0, 10], [200, 0, 10]], rtol=0, atol=EXACT_MM)
    on_refused = find_seams(workpiece, SeamOptions(), SeamChoice(added_edges=("25,60,10",)))[0]
    assert [(s.name, s.accepted) for s in on_refused] == [("W1", True), ("W2", True), ("W3", True), ("W4", False)]
    beside_named = find_seams(workpiece, SeamOptions(), SeamChoice(edges=("25,60,10",), added_edges=("100,0,10",)))[0]
    assert sum(s.accepted for s in beside_named) == 2


def test_an_added_edge_that_the_search_made_is_one_seam() -> None:
    """Candidates on edges that a search adds are not there twice."""
    lower = box(100, 60, 10, (0, 0, 0))
    upright = box(60, 8, 50, (20, 26, 5))  # stands 5 mm deep in the plate
    shapes = tuple(SimpleNamespace(wrapped=shape) for shape in (lower, upright))
    workpiece = Workpiece(to_brep([("plate", lower), ("upright", upright)]), shapes=shapes)
    usual, _ = find_seams(workpiece, SeamOptions())
    assert {s.source for s in usual} & {SeamSource.SECTION}
    longest = max(usual, key=lambda s: s.length_mm)
    x, y, z = longest.frames.p[len(longest.frames.p) // 2]
    more, _ = find_seams(workpiece, SeamOptions(), SeamChoice(added_edges=(f"{x},{y},{z}",)))
    middles = [tuple(np.round(s.frames.p.mean(axis=0), 3)) for s in more]
    assert len(middles) == len(set(middles)) == len(usual)
