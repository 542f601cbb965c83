"""The torch that seams.json names is the one of the program: in its header, in its frames, in the check."""

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from tests.unit.conftest import box_mesh, plate
from wpcal.brep.mesh_glb import read_part_glb, write_part_glb
from wpcal.cli.main import run
from wpcal.controllers.judge.written import WrittenWrongError, write_judged
from wpcal.controllers.program import build_program
from wpcal.controllers.program.checked_program import check_program
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import GeometryError
from wpcal.results.folder import read_finished
from wpcal.robot.torch.attitude import TorchSettings, neck_directions, wire_directions
from wpcal.robot.torch.file import find_torch, without_none
from wpcal.seam.judge.torch_neck import bend_directions

TEE = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"
NECK = "robot-45"
ROUND_OFF = 1e-9
FIXED = TorchSettings(spin_range_rad=0.0)


def with_neck(folder: Path, spin_deg: float) -> Path:
    """The tee with seams that were felt with a bent neck, turned about the wire."""
    shutil.copytree(TEE, folder)
    record = json.loads((folder / "seams.json").read_text())
    record["torch"] = without_none(asdict(find_torch(NECK)))
    for seam in record["seams"]:
        for frame in seam["frames"]:
            if frame["lean_deg"] is not None:
                frame["lean_deg"]["spin"] = spin_deg
    (folder / "seams.json").write_text(json.dumps(record))
    return folder


@pytest.mark.parametrize("spin_deg", [0.0, 90.0])
def test_the_program_names_the_torch_of_the_seams_and_turns_it_as_felt(tmp_path: Path, spin_deg: float) -> None:
    finished = read_finished(with_neck(tmp_path / "tee", spin_deg)).select()
    assert finished.torch == find_torch(NECK)
    program = build_program(finished, torch=FIXED)
    for path in program.paths:
        R = path.R_base[path.weld_rows]
        back = -wire_directions(R, FIXED.tool_axis)
        felt = bend_directions(back, path.seam.frames.R, np.full(len(R), np.radians(spin_deg)))
        np.testing.assert_allclose(neck_directions(R, FIXED.tool_axis), felt, rtol=0, atol=ROUND_OFF)


def test_a_neck_that_points_into_the_part_is_found(finished_folder: Callable[[], Path]) -> None:
    """A block is beside the seam, above the nozzle: only a neck that bends towards it meets it."""
    finished = read_finished(finished_folder()).select(["W1"])
    torch, block = find_torch(NECK), box_mesh("block", (-20, 60, 150), (120, 100, 200))
    part_glb = write_part_glb(plate(block, sha256=read_part_glb(finished.part_glb).sha256))
    said = []
    for spin_deg in (0.0, 90.0, -90.0):
        turned = replace(finished.seams[0], spin_rad=np.full(len(finished.seams[0].frames), np.radians(spin_deg)))
        program = build_program(replace(finished, seams=(turned,), part_glb=part_glb), torch=FIXED)
        try:
            said.append(" ".join(check_program(program, torch=torch).checked))
        except GeometryError as error:
            said.append(str(error))
    assert [("the neck is inside 'block'" in words) for words in said] == [False, False, True]
    assert f"the neck of {NECK} bends towards -x of the tool" in said[0]
    with pytest.raises(WrittenWrongError, match=r"the neck of .* is inside 'block'"):
        write_judged("rapid", controller_named("rapid").write, replace(program, shape=torch))


def test_another_torch_in_the_options_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = with_neck(tmp_path / "tee", 0.0)
    arguments = ["export", str(folder), "-f", "rapid", "-o", str(tmp_path / "out")]
    for more, words in ((["--wire-mm", "15"], "wire_mm 15"), (["--spin-range-deg", "90"], "the neck of robot-45")):
        with pytest.raises(SystemExit, match="2"):
            run([*arguments, *more])
        told = capsys.readouterr().err.strip()
        assert words in told
        assert NECK in told
        assert "\n" not in told
    assert not (tmp_path / "out").exists()


def test_a_straight_torch_of_other_sizes_is_told_in_the_program(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="0"):
        run(["export", str(TEE), "-f", "rapid", "-o", str(tmp_path / "out"), "--wire-mm", "18"])
    text = next((tmp_path / "out").rglob("*.mod")).read_text()
    assert "wire 18 mm" in text
    assert "made for another torch" in text
