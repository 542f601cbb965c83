"""What `seams` accepts on a bracket drawn at random, `export` writes and `plan` welds, on every millimetre."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.cluttered_cells import TOOL
from tests.few import few
from tests.judgements import calibrated
from tests.moves_of_programs import followed, welds_of
from tests.running import run_here
from tests.samples.brackets import write_bracket
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.sequence.plan_sequence import ways_of_seam
from wpcal.planning.sequence.remedies import RemedySearch
from wpcal.planning.sequence.seam_search import SeamSearch
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets

DRAWN = 200
OFF_MM = 0.3  #: The largest error of the programs, and half a step between the places that are compared.
ENDS_MM = 0.06  #: The largest error of the programs, and their digits.
STEP_MM = 0.25
SEARCHED = 105  #: Of the brackets that were looked at one by one.
LEFT_BY_THE_ARM = {23, 31, 41, 47, 58, 68, 69, 78, 96}  #: A joint or the bent torch leaves up to 29 mm, and it is told.
pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    """Return a robot in front of which every bracket is in reach, so that the torch alone decides."""
    path = tmp_path_factory.mktemp("cell") / "cell.json"
    made = run_here("cell", "new", "--torch-robot", "irb2600_12_165", "--tool", ",".join(map(str, TOOL)), "-o", path)
    assert made.returncode == 0, made.stderr
    return read_one_robot(path)


def dense(p):
    """Return places at steps of `STEP_MM` along lines."""
    counts = np.ceil(np.linalg.norm(np.diff(p, axis=0), axis=1) / STEP_MM).astype(int) + 1
    return np.concatenate([np.linspace(a, b, n + 1) for a, b, n in zip(p[:-1], p[1:], counts, strict=True)])


@pytest.mark.parametrize("seed", few([8, *(seed for seed in range(DRAWN) if seed != 8)], 1))
def test_every_accepted_millimetre_is_exported_and_planned(seed: int, cell, tmp_path: Path) -> None:
    pytest.importorskip("fcl", reason="python-fcl is not installed")
    out, _ = calibrated(write_bracket(seed, tmp_path), tmp_path)
    given = read_sequence_input(out, cell)
    assert len(given.seams) >= 4  # a web on the base has as many
    done = run_here("export", out, "-f", "rapid", "-o", tmp_path / "programs", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["seams"] == [each.name for each in given.seams]
    text = {path.name: path.read_text(encoding="utf-8") for path in (tmp_path / "programs").rglob("*.mod")}
    for each, weld in zip(given.seams, welds_of("rapid", text), strict=True):
        p, R = followed(weld, 25)
        wire, seam = p + each.seam.more_wire_mm * R.as_matrix()[:, :, 2], each.seam.frames.p
        assert np.linalg.norm(wire[[0, -1]] - seam[[0, -1]], axis=1).max() < ENDS_MM, each.name
        one, other = dense(wire), dense(seam)
        assert cKDTree(one).query(other)[0].max() < OFF_MM, each.name
        assert cKDTree(other).query(one)[0].max() < OFF_MM, each.name
    placed, targets = given.placed(cell), SequenceTargets()
    longest_mm = max(each.seam.more_wire_mm for each in given.seams)
    search = SeamSearch(placed, CellClearance(placed, given.part), targets, more_wire_mm=longest_mm)
    for each in given.seams:
        ways, left_out = ways_of_seam(search, each, RemedySearch(search.closer))
        told = [(gap.from_mm, gap.to_mm) for gap in left_out]
        told += [(float(way.candidates[0].task.s_mm.min()), float(way.candidates[0].task.s_mm.max())) for way in ways]
        ends = [0.0, *np.array(sorted(told)).ravel(), each.seam.frames.s_mm[-1]]
        np.testing.assert_allclose(ends[::2], ends[1::2], rtol=0, atol=1e-6, err_msg=each.name)
        if seed < SEARCHED and seed not in LEFT_BY_THE_ARM:
            assert [gap.describe() for gap in left_out] == []
