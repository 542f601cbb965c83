"""A plate with chamfers at its foot is prepared for a weld: the torch leans towards the plate into the chamfer."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build123d import Align, Axis, Box, Compound, chamfer, export_step

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from wpcal.seam import JointType, SeamOptions, WeldType

LENGTH_MM, THICK_MM, HIGH_MM = 150.0, 12.0, 60.0
TEES = [(leg, base, (JointType.TEE, WeldType.FILLET)) for leg, base in ((0.5, 120), (2, 120), (5, 120), (5, 24))]
BUTTS = [(leg, THICK_MM, (JointType.BUTT, WeldType.GROOVE)) for leg in (2, 5)]


@pytest.mark.parametrize(("leg_mm", "base_mm", "words"), TEES + BUTTS)
def test_a_chamfer_at_the_foot_of_a_plate_is_welded(tmp_path: Path, leg_mm: float, base_mm: float, words: Any) -> None:
    """On a base that is as thick as the plate, which stands on its edge, the chamfers are the sides of grooves."""
    base = Box(200, base_mm, 40, align=(Align.CENTER, Align.CENTER, Align.MAX))
    plate = Box(LENGTH_MM, THICK_MM, HIGH_MM, align=(Align.CENTER, Align.CENTER, Align.MIN))
    plate = chamfer([edge for edge in plate.edges().filter_by(Axis.X) if abs(edge.center().Z) < 1e-6], leg_mm)
    base.label, plate.label = "base", "plate"
    export_step(Compound(label="tee", children=[base, plate]), tmp_path / "tee.step")
    seams, _ = find_seams(open_workpiece(tmp_path / "tee.step"), SeamOptions())
    along = [seam for seam in seams if seam.length_mm > 100]
    assert [(seam.accepted, seam.length_mm) for seam in along] == [(True, pytest.approx(LENGTH_MM))] * 2
    assert {(seam.joint, seam.weld) for seam in along} == {words}
    root_mm = THICK_MM / 2 - leg_mm
    for seam in along:
        np.testing.assert_allclose(np.abs(seam.frames.p[:, 1]), root_mm, rtol=0, atol=1e-6)
        np.testing.assert_allclose(seam.frames.R[:, 2, 2], np.sin(np.radians(22.5)), rtol=0, atol=1e-9)
        assert seam.lean_rad is not None
        assert np.isfinite(seam.lean_rad).all()
