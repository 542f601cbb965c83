"""Which seams a torch reaches; `wpcal plan --part` compares seams without a part.glb with the part of a STEP file."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.cli.part_mesh import mesh_of_step
from cad.kernel.primitives import box, cut, cylinder
from cad.kernel.to_brep import to_brep
from cad.workpiece.answer_cache import NO_CACHE
from tests.few import few
from tests.one_robot_cells import TEE, fixed_cell
from wpcal.brep.material import ExactMaterial
from wpcal.brep.trim import TrimmedFaces
from wpcal.cli.part_option import read_part_option
from wpcal.core.errors import InputError
from wpcal.core.progress import no_progress
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import Seam, detect_seams
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.judge.material import find_poses_in_material


def seams_of(*solids: tuple[str, Any]) -> tuple[Seam, ...]:
    graph = to_brep(solids)
    seams = detect_seams(graph)
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    for seam in seams:
        assert seam.lean_rad is not None  # the record says of every frame whether a torch gets there
        assert len(seam.lean_rad) == len(seam.frames)
        if seam.accepted:
            back = back_directions(seam.frames.R, seam.lean_rad)
            torch = USUAL_TORCH.with_more_wire(seam.more_wire_mm)
            assert len(find_poses_in_material(material, seam.frames.p, back, torch)) == 0
    return seams


def rails_on_a_post(clear_mm: float) -> tuple[Seam, ...]:
    post = box(50.0, 50.0, 600.0, (0.0, 0.0, 0.0))
    rails = [box(550.0, 50.0, 50.0, (50.0, 0.0, z)) for z in (100.0, 150.0 + clear_mm)]
    return seams_of(("post", post), ("low", rails[0]), ("up", rails[1]))


@pytest.mark.parametrize("clear_mm", few([80.0, 400.0, 125.0, 180.0], 2))
def test_fillets_between_rails_are_reached_by_a_torch_that_leans(clear_mm: float) -> None:
    seams = rails_on_a_post(clear_mm)
    assert sum(seam.length_mm for seam in seams if seam.accepted) == pytest.approx(8 * 50.0, abs=1e-6)
    assert sum(seam.length_mm for seam in seams) == pytest.approx(8 * 50.0, abs=1e-6)
    between = [s for s in seams if s.frames.p[0, 2] in (150.0, 150.0 + clear_mm)]
    leans = np.degrees(np.concatenate([seam.lean_rad for seam in between if seam.lean_rad is not None]))
    assert leans.any() == (clear_mm < 250.0)  # 350 mm at 45 degrees, with the approach


def test_between_rails_that_touch_the_nozzle_no_torch_gets() -> None:
    seams = rails_on_a_post(15.0)
    refused = [seam for seam in seams if seam.frames.p[0, 2] in (150.0, 165.0) and not seam.accepted]
    assert sum(seam.length_mm for seam in refused) > 0
    assert all(np.isnan(seam.lean_rad).all() for seam in refused if seam.lean_rad is not None and seam.blocked_by)
    assert all(seam.blocked_by and not seam.reachable for seam in refused)


def through_a_hole(diameter_mm: float, slot_mm: float = 0.0) -> list[Seam]:
    """The seams under a plate of 6 mm with a hole over the joint of two others; `slot_mm` makes the hole longer."""
    left, right = (box(100.0, 200.0, 10.0, (x, 0.0, 0.0)) for x in (-100.0, 0.0))
    radius = diameter_mm / 2
    holes = [cylinder(radius, 6.0, (0.0, 100.0, 10.0), (0.0, 0.0, 1.0))]
    if slot_mm:
        holes.append(box(diameter_mm, slot_mm, 6.0, (-radius, 100.0 - slot_mm / 2, 10.0)))
    plate = cut(box(160.0, 160.0, 6.0, (-80.0, 20.0, 10.0)), *holes)
    seams = seams_of(("left", left), ("right", right), ("plate", plate))
    middle = [0.0, 100.0]
    reach = max(diameter_mm, slot_mm) / 2 + 1.0
    return [seam for seam in seams if (np.linalg.norm(seam.frames.p[:, :2] - middle, axis=1) < reach).all()]


@pytest.mark.parametrize("diameter_mm", few([6.0, 12.7, 20.0], 1))
def test_what_is_seen_through_a_bolt_hole_only_is_refused(diameter_mm: float) -> None:
    seams = through_a_hole(diameter_mm)
    assert seams
    for seam in seams:
        assert not seam.accepted
        if seam.length_mm > 5.0 and not seam.inside:
            assert "the torch does not get there" in " ".join(seam.against)


def test_through_a_wide_hole_or_a_slot_a_torch_gets() -> None:
    assert any(seam.accepted for seam in through_a_hole(60.0))
    assert any(seam.accepted and set(seam.solids) == {"left", "right"} for seam in through_a_hole(26.0, 90.0))


STEP = TEE.parent / "tee.step"
OTHER = TEE.parents[1] / "lap" / "lap.step"


@pytest.fixture
def alone(tmp_path):
    """The seams of the tee without its part.glb, as of `wpcal seams --json`."""
    shutil.copy(TEE / "seams.json", tmp_path)
    return tmp_path / "seams.json"


def test_the_part_of_a_step_file_is_the_one_of_the_result(alone):
    cell = fixed_cell()
    assert read_sequence_input(alone, cell).part is None
    glb = mesh_of_step(STEP, cache=NO_CACHE, progress=no_progress)
    given = read_sequence_input(alone, cell, part_glb=glb)
    for side in (0, 1):
        own = given.part.boxes[side]
        assert np.allclose(own, read_sequence_input(TEE, cell).part.boxes[side], rtol=0, atol=1e-3)
    assert given.part.names == read_sequence_input(TEE, cell).part.names


def test_another_part_is_one_line(alone):
    glb = mesh_of_step(OTHER, cache=NO_CACHE, progress=no_progress)
    with pytest.raises(InputError, match="mm outside of this part"):
        read_sequence_input(alone, fixed_cell(), part_glb=glb)


@pytest.mark.parametrize(("name", "says"), [("part.stl", "expected one of .glb, .step"), ("no.step", "no.step")])
def test_a_file_that_is_no_part_is_one_line(tmp_path, monkeypatch, name, says):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=says):
        read_part_option(Path(name))
