"""Every step that a command names while it works says a number: how much there is to do."""

import re
from pathlib import Path

from cad.workpiece.calibrate import calibrate_workpiece
from cad.workpiece.features import judge_workpiece
from cad.workpiece.workpiece import open_workpiece

TEE = Path(__file__).parents[2] / "fixtures" / "tee"


def test_steps_have_numbers() -> None:
    said: list[str] = []
    workpiece = open_workpiece(TEE / "tee.step", progress=said.append)
    judge_workpiece(workpiece, progress=said.append)
    calibrate_workpiece(workpiece, TEE / "taught.csv", progress=said.append)
    faces, features = workpiece.graph.face_count, len(workpiece.features)
    assert [re.sub(r"\d+\.\d MB|\d+ seams", "N", text) for text in said] == [
        "reading tee.step: N",
        f"judging {features} features",
        f"finding seams: {len(workpiece.graph.solid_names)} solids, {faces} faces",
        "fitting 6 points, N",
    ]
