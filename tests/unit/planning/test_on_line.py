"""Between the states of a weld the wire stays on lines in the part, also while the torch and the part turn."""

import numpy as np
import pytest

from tests.one_robot_cells import TEE, random_axes, with_positioner, write_cell
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.timeline import ON_LINE_MM, states_on_lines

SCALE = np.array([1.0, 1.0, 1.0, 500.0, 500.0, 500.0])[:, None]
FAR_FROM_SINGULAR = 0.2
"""Least singular value of a Jacobian with lengths in these units: welds are planned away from singular states."""


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    read = read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), with_positioner()))
    return read_sequence_input(TEE, read).placed(read)


def tips(cell, q):
    return (np.linalg.inv(cell.part_places(q)) @ cell.tool_places(q))[:, :3, 3]


def test_the_wire_stays_on_lines_where_the_torch_turns(cell):
    rng = np.random.default_rng(2)
    every = 0.9 * random_axes(cell, 60, seed=8)
    stretched = np.linalg.svd(cell.arm.jacobian(every[:, :6]) / SCALE)[1]
    for q in every[stretched[:, -1] > FAR_FROM_SINGULAR][:12]:
        states = q + np.cumsum(rng.uniform(-0.06, 0.06, (5, len(q))), axis=0)
        fine, at = states_on_lines(cell, states)
        whole = at == np.round(at)
        assert np.array_equal(fine[whole], states)
        ends = tips(cell, states)
        for share in (0.25, 0.5, 0.75):
            place = at[:-1] + share * np.diff(at)
            row = np.minimum(place.astype(int), len(states) - 2)
            step = ends[row + 1] - ends[row]
            off = tips(cell, fine[:-1] + share * np.diff(fine, axis=0)) - ends[row]
            beside = off - np.einsum("ij,ij->i", off, step)[:, None] / (step**2).sum(axis=1)[:, None] * step
            assert np.linalg.norm(beside, axis=1).max() < 1.5 * ON_LINE_MM  # thirds of a step are not quite even
        coarse = tips(cell, (states[:-1] + states[1:]) / 2) - (ends[:-1] + ends[1:]) / 2
        assert (len(fine) > len(states)) == (np.linalg.norm(coarse, axis=1).max() > ON_LINE_MM)
