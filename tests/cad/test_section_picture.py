"""The section of a joint in the picture of `--explain`: its outlines are on the members, with torch and numbers."""

import re
from pathlib import Path

import numpy as np

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from wpcal.draw.section import MARGIN, SIZE, TOP, draw_section
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import SeamOptions
from wpcal.seam.explain import explain_seam
from wpcal.seam.member.note import MemberNotes
from wpcal.seam.options import Judging

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
SEEN_MM = 0.1  #: A tenth of a millimetre is a pixel.


def test_the_outlines_are_on_the_faces_of_both_members() -> None:
    seams, workpiece = find_seams(open_workpiece(TEE), SeamOptions())
    seam = next(one for one in seams if one.accepted)
    record = explain_seam(workpiece.graph, seam, MemberNotes(Judging(), ()), (10.0, 10.0))
    drawn = draw_section(workpiece.graph, workpiece.trimmed, seam, USUAL_TORCH, record["section"])
    text = "\n".join(drawn)
    assert "opening 90 deg" in text
    assert "wire 20 mm" in text
    half = max(float(np.clip(2.5 * 10.0, 12.0, 60.0)), USUAL_TORCH.wire_mm + 14.0)
    outlines = [found for line in drawn if (found := re.match(r'<polyline points="(.*?)".*stroke-width="2"', line))]
    points = np.array([pair.split(",") for found in outlines for pair in found[1].split()], dtype=float)
    y = (points[:, 0] - MARGIN) / SIZE * 2 * half - half
    z = half - (points[:, 1] - TOP) / SIZE * 2 * half
    shown = (np.abs(y) < half) & (np.abs(z) < half)
    # both faces of the joint go away from the root at 45 degrees, below z = |y|; the members are below
    assert shown.sum() > 200
    assert (z[shown] <= np.abs(y[shown]) + SEEN_MM).all()
    for side in (-1.0, 1.0):
        on_face = np.abs(z - side * y)[shown & (side * y > 0.5)] < SEEN_MM
        assert on_face.sum() > 50
