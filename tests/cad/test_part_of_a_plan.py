"""`wpcal plan --part`: seams without a part.glb beside them are compared with the part of a STEP file."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from cad.cli.part_mesh import mesh_of_step
from cad.workpiece.answer_cache import NO_CACHE
from tests.one_robot_cells import TEE, fixed_cell
from wpcal.cli.part_option import read_part_option
from wpcal.core.errors import InputError
from wpcal.core.progress import no_progress
from wpcal.planning.sequence.sequence_input import read_sequence_input

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
    assert given.part is not None
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
