"""Groups that a part holds twice: searched once, with the same seams as if each had been searched."""

from dataclasses import replace

import numpy as np
import pytest

from tests.copied_groups import FAR, WITHIN_MM, check_same, shifted, together
from tests.few import few
from tests.samples.graphs import nothing_crosses
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.repeats import find_copies
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.rotations import rotation_from_zyx
from wpcal.seam import Seam, SeamOptions, search
from wpcal.seam.search import find_part_candidates


def seams_of(graph: BrepGraph) -> tuple[Seam, ...]:
    return find_part_candidates(graph, TrimmedFaces.of(graph), SeamOptions(), cross=nothing_crosses).judged(
        SeamOptions()
    )


def seams_of_each(graph: BrepGraph, monkeypatch: pytest.MonkeyPatch) -> tuple[Seam, ...]:
    """Return the seams when every group is searched by itself."""
    with monkeypatch.context() as patch:
        patch.setattr(search, "find_copies", lambda *_, **__: ())
        return seams_of(graph)


@pytest.mark.parametrize(
    "name", few(["bead-pipe", "bolted-plates", "frame", "saddle-60", "tee-under-bar", "bar-through-plates"], 2)
)
def test_seams_of_copies_are_those_of_a_search(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = saved_graph(name)
    twice = together(graph, shifted(graph, FAR))
    assert len(find_copies(twice, TrimmedFaces.of(twice), within_mm=WITHIN_MM)) == 1
    found = seams_of(twice)
    assert found
    check_same(found, seams_of_each(twice, monkeypatch))


def test_near_groups_are_judged_with_what_is_around_them(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = saved_graph("frame")
    pitch = np.array([float(np.ptp(graph.vertex_p[:, 0])) + 45.0, 0.0, 0.0])
    row = graph
    for number in (1, 2):
        row = together(row, shifted(graph, number * pitch))
    assert copies_of(row, within_mm=40.0) == 2
    found = seams_of(row)
    assert any(set(seam.blocked_by) - set(seam.solids) for seam in found)
    check_same(found, seams_of_each(row, monkeypatch))


def test_a_name_that_changes_the_judgement_of_a_copy_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = saved_graph("tee-under-bar")
    other = replace(shifted(graph, FAR), solid_names=tuple(f"plastic cap {name}" for name in graph.solid_names))
    twice = together(graph, other)
    found = seams_of(twice)
    assert len({seam.accepted for seam in found}) == 2
    check_same(found, seams_of_each(twice, monkeypatch))


def copies_of(graph: BrepGraph, within_mm: float = WITHIN_MM) -> int:
    return len(find_copies(graph, TrimmedFaces.of(graph), within_mm=within_mm))


def test_what_is_near_turned_or_not_the_same_is_no_copy() -> None:
    graph = saved_graph("saddle-60")
    far = shifted(graph, FAR)
    assert copies_of(together(graph, far)) == 1
    assert copies_of(together(graph, far), within_mm=2000.0) == 0
    turn = rotation_from_zyx(np.pi / 2, 0.0, 0.0)
    turned = replace(
        far, face_frame=far.face_frame @ turn.T, edge_frame=far.edge_frame @ turn.T, vertex_p=far.vertex_p @ turn.T
    )
    assert copies_of(together(graph, turned)) == 0
    for column, row in (("face_param", 0), ("edge_range", 3), ("vertex_p", 1)):
        values = getattr(far, column).copy()
        values[row] += 1e-6
        assert copies_of(together(graph, replace(far, **{column: values}))) == 0
    assert copies_of(together(graph, replace(far, face_outward=-far.face_outward))) == 0
