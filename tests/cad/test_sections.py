"""Sections through a part: where solids meet, and the pictures of seams."""

import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cad.kernel.to_brep import to_brep
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.few import few
from tests.samples.graphs import saddle
from tests.saved_graphs import saved_seams
from wpcal.pages.draw.section import MARGIN, SIZE, TOP, draw_section
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import SeamOptions
from wpcal.seam.explain import explain_seam
from wpcal.seam.member.note import MemberNotes
from wpcal.seam.options import Judging

LENGTH_MM = 0.01  #: The agreed accuracy of a seam's length.


@pytest.mark.parametrize(("tilt_deg", "trimmed"), few([(30.0, "saddle-60"), (0.0, "saddle-90")], 1))
def test_an_untrimmed_branch_has_the_seams_of_the_trimmed_one(tilt_deg: float, trimmed: str) -> None:
    solids = saddle(tilt_deg, trimmed=False)
    workpiece = Workpiece(to_brep(solids), shapes=tuple(SimpleNamespace(wrapped=shape) for _, shape in solids))
    found, _ = find_seams(workpiece, SeamOptions())
    expected = saved_seams(trimmed)
    assert [seam.accepted for seam in found] == [True, False]
    for mine, other in zip(found, expected, strict=True):
        assert mine.closed
        assert mine.length_mm == pytest.approx(other.length_mm, rel=0, abs=LENGTH_MM)


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


def test_a_picture_is_not_overwritten_without_force(wpcal: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "a.png").write_text("mine", encoding="utf-8")
    done = wpcal("seams", TEE, "--png", tmp_path / "a.png")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "(--force)" in done.stderr
    assert (tmp_path / "a.png").read_text(encoding="utf-8") == "mine"
    assert wpcal("seams", TEE, "--png", tmp_path / "a.png", "--force").returncode == 0
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
