"""AS, read back by a parser that knows the language and nothing of the writer."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.program_text import as_values, kawasaki
from tests.unit.controllers.judging import arc_faults, judged
from wpcal.controllers.audit import audit_path
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.kawasaki.arc import conditions
from wpcal.controllers.kawasaki.write import write_as
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.few_moves import fit_program
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration
from wpcal.weld.place import StatedWeld, place_of
from wpcal.weld.rules import shipped_rules
from wpcal.weld.seam_weld import weld_for

ATOL_MM = 0.9e-5
ATOL_DEG = 0.9e-6


@pytest.mark.parametrize("a", [0.0, 1e-9, 1e-7, 1e-4, 90.0, 180.0 - 1e-7, 180.0])
def test_a_tool_along_z_keeps_its_turn(make_program, assert_same_poses, a):
    program = make_program(1, T_base_part=RigidTransform.identity(target="base", source="part"))
    (path,) = program.paths
    R = Rotation.from_euler("ZYZ", [[o, a, 33.3] for o in range(16)], degrees=True).as_matrix()
    program = replace(program, paths=(replace(path, R_base=R),))
    assert_same_poses(*kawasaki(write_as(program)).in_base(), program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


def test_names_have_fifteen_characters_and_stay_different(make_program):
    program = make_program(names=("a very long name of a seam 1", "a very long name of a seam 2", "Wp_Part", "2"))
    (text,) = write_as(program).values()
    names = [name.lower() for name in as_values(text)] + re.findall(r"^\.PROGRAM (\w+)", text.lower(), re.MULTILINE)
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[a-z][a-z0-9_.]{0,14}", name) for name in names)
    with pytest.raises(InputError, match="AS names have up to 15 letters"):
        write_as(make_program(controller=ControllerSettings(tool_name="a_torch_with_a_long_name"), safe_point=None))


def half_circle(make_seam, *, accepted=True):
    t = np.pi * np.linspace(0, 1, 33)
    x = np.stack([-np.sin(t), np.cos(t), 0 * t], axis=1)
    z = np.tile([0.0, 0.0, 1.0], (33, 1))
    p = 80 * np.stack([np.cos(t), np.sin(t), 0 * t], axis=1)
    return make_seam("W1", p, np.stack([x, np.cross(z, x), z], axis=2), accepted=accepted, frame="base")


def welding(make_seam, **values):
    seam = half_circle(make_seam)
    stated = {"thickness_mm": 8.0, "position": "PB", "end_delay_s": 0.0, "crater": None, **values}
    T = RigidTransform.identity(target="base", source="part")
    weld = weld_for(seam, place_of(seam, T), StatedWeld("W1", None, stated), shipped_rules())
    finished = FinishedCalibration(T, (seam,), (None,), {})
    return fit_program(build_program(finished, welds={"W1": weld}, arc=ArcSettings()))


def test_a_seam_that_ends_in_an_arc_ends_the_weld_at_the_same_point(make_seam, tmp_path):
    ((name, text),) = write_as(welding(make_seam, job=4)).items()
    (tmp_path / name).write_text(text)
    assert "NOT CHECKED: speeds of joint moves and of lines that take" in audit_path(tmp_path).files[0].checked
    along = text.split("; SEAM START")[1].split("; SEAM END")[0].split()
    moves = [word for word in along if word.isupper() and "_" not in word]
    assert moves == ["LWS", "C1WC", "C2WC", "LWE"]
    assert along[-2:] == [along[-5], ",4"]  # LWE to where C2WC ended
    assert arc_faults(text.encode(), tmp_path / "WPCAL.as") == []


def test_equal_welds_share_a_condition_and_jobs_keep_theirs(make_seam):
    program = welding(make_seam, leg_mm=12.0, job=1)
    found = {name: (own.weld, own.lines) for name, own in conditions(program).items()}
    assert found == {"W1.p1": (1, ()), "W1.p2": (1, ()), "W1.p3": (1, ())}
    program = welding(make_seam, leg_mm=12.0)
    assert {own.weld for own in conditions(program).values()} == {1}
    assert all(own.lines[0].startswith("  W1SET 1 = ") for own in conditions(program).values())


def test_a_text_without_a_break_goes_round_its_corners_and_is_refused(make_program):
    """With CP ON the tool leaves a motion within ACCURACY; with CP OFF it stops at every point."""
    program = make_program(5)
    ((name, text),) = write_as(program).items()
    judged({name: text}, program, "as")
    assert judged({name: text.replace("  BREAK\r\n", "").replace("CP ON", "CP OFF")}, program, "as").not_checked == ()
    blended = text.replace("  BREAK\r\n; SEAM START", "; SEAM START").replace("  BREAK\r\n; ARC ON", "; ARC ON")
    assert blended != text
    with pytest.raises(WrittenWrongError, match=r"as: WPCAL\.as, line \d+: does not stop where it should"):
        judged({name: blended}, program, "as")
    last = execute({name: text.replace("  BREAK\r\n", "")}, tools=(program.controller.tool_name,)).motions[1]
    assert last.place.blends
    assert last.place.zone == (1, 0.5)
