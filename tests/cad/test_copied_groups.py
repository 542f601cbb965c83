"""Groups that a part holds twice: the kernel crosses solids of the first only; opposed faces need the whole part."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cad.kernel.geometry import to_location
from cad.kernel.primitives import box
from cad.kernel.to_brep import to_brep
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.copied_groups import FAR, MOVED_MM, check_same, shifted, together
from tests.samples.graphs import saddle
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.transform import RigidTransform
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam import SeamOptions, SeamSource, detect_seams, search
from wpcal.seam.judge import leans
from wpcal.seam.judge.alike import Alike
from wpcal.seam.judge.leans import feel_seams
from wpcal.seam.options import Reach

BLOCK = Path(__file__).parents[2] / "fixtures" / "welds" / "parts" / "machined-block.step"
CROSSED_MM = 1e-6  #: The kernel crosses the same solids at two places with curves that differ by 3e-8 mm.


def check(workpiece: Workpiece, monkeypatch: pytest.MonkeyPatch, within_mm: float = MOVED_MM) -> None:
    found, _ = find_seams(workpiece, SeamOptions())
    with monkeypatch.context() as patch:
        patch.setattr(search, "find_copies", lambda *_, **__: ())
        wanted, _ = find_seams(workpiece, SeamOptions())
    assert found
    check_same(found, wanted, within_mm)


@pytest.mark.deep
def test_opposed_faces_are_turned_by_the_whole_part(monkeypatch: pytest.MonkeyPatch) -> None:
    one = open_workpiece(BLOCK)
    twice = Workpiece(together(one.graph, shifted(one.graph, np.array([0.0, 0.0, 900.0]))))
    found, _ = find_seams(twice, SeamOptions())
    assert any("opposed" in text for seam in found for text in seam.reasons)
    check(twice, monkeypatch)


def test_crossed_solids_of_copies_have_the_curves_of_the_first(monkeypatch: pytest.MonkeyPatch) -> None:
    T = RigidTransform(np.eye(3), FAR, target="base", source="part")
    one = saddle(0.0, trimmed=False)
    solids = [*one, *((f"{name} of b", shape.Moved(to_location(T))) for name, shape in one)]
    shapes = tuple(SimpleNamespace(wrapped=shape) for _, shape in solids)
    workpiece = Workpiece(to_brep(solids), shapes=shapes)
    found, _ = find_seams(workpiece, SeamOptions())
    assert [seam.source for seam in found if seam.accepted] == [SeamSource.SECTION, SeamSource.SECTION]
    check(workpiece, monkeypatch, CROSSED_MM)


def test_pads_along_a_plate_are_felt_once_for_equal_surroundings(monkeypatch: pytest.MonkeyPatch) -> None:
    solids = [("plate", box(900.0, 900.0, 8.0, (0.0, 0.0, 0.0))), ("wall", box(6.0, 200.0, 150.0, (37.0, 30.0, 8.0)))]
    solids += [
        (f"pad {i}.{j}", box(30.0, 30.0, 25.0, (60.0 + 70.0 * i, 60.0 + 70.0 * j, 8.0)))
        for i in range(12)
        for j in range(12)
    ]
    graph = to_brep(solids)
    trimmed, reach = TrimmedFaces.of(graph), Reach(TorchShape(length_mm=120.0))
    seams = [seam for seam in detect_seams(graph, SeamOptions(reach=reach), trimmed=trimmed) if not seam.blocked_by]
    asked: list[int] = []
    felt_each = leans._felt_each
    monkeypatch.setattr(leans, "_felt_each", lambda *of: asked.append(len(set(of[2].owner))) or felt_each(*of))
    found = feel_seams(graph, trimmed, seams, reach)
    monkeypatch.setattr(leans, "find_alike", lambda _, __, poses, ___: Alike(np.unique(poses.owner), {}))
    for one, other in zip(found, feel_seams(graph, trimmed, seams, reach), strict=True):
        for name in ("lean_rad", "spin_rad", "solid", "solid_after"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert asked[0] < len(seams) / 3
    assert asked[1] == len(seams)
    assert len({one.solid.tobytes() + one.lean_rad.tobytes() for one in found}) > 2
