"""The structure that speed is measured on: its seams are those of the closed form, and the torch gets along them.

Deep: `test_samples_truth` has the closed form, `test_reach` the torch between rails, at each push.
"""

import numpy as np
import pytest

from cad.kernel.to_brep import to_brep
from tests.samples.steel_structure import seam_counts, steel_structure
from wpcal.brep.material import ExactMaterial
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.motion import APPROACH_MM
from wpcal.robot.torch.attitude import TorchSettings, tool_rotations
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import detect_seams
from wpcal.seam.judge.reach import find_in_ways

BAYS = 2
FACES = 456  #: 3 frames of 2 plates of 10 faces, 4 tubes of 18 and a pipe of 4; 2 bays of 4 tubes and 2 gussets of 6.
CUTS_MM = 2.0  #: Round the foot of a post the torch cannot pass under a rail: there a seam is cut, within this.

pytestmark = pytest.mark.deep


def test_every_seam_of_the_structure_is_found_and_the_torch_swings_through_no_rail() -> None:
    graph = to_brep((name, shape) for name, shape, _ in steel_structure(BAYS))
    assert graph.face_count == FACES
    material = ExactMaterial(graph, TrimmedFaces.of(graph))
    reached = [seam for seam in detect_seams(graph) if seam.accepted]
    for seam in reached:
        if seam.lean_rad is None or not np.ptp(seam.lean_rad, axis=0).any():
            continue  # where its lean does not change, other tests sweep it
        R = tool_rotations(seam.frames.R, TorchSettings(), seam.lean_rad)
        come, go = (np.stack([seam.frames.p[end] - APPROACH_MM * R[end, :, 2], seam.frames.p[end]]) for end in (0, -1))
        ways = [(seam, seam.frames.p, R), (seam, come, R[[0, 0]]), (seam, go, R[[-1, -1]])]
        assert not any(find_in_ways(material, ways, USUAL_TORCH)), seam.name
    count, length = seam_counts(BAYS)
    assert len(reached) >= count
    cuts = len(reached) - count
    assert length - cuts * CUTS_MM <= sum(seam.length_mm for seam in reached) <= length + 1e-6
    assert length == pytest.approx(7360.991, abs=1e-3)
