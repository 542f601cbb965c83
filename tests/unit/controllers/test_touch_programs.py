"""Touch programs in six languages: what they hold, what they check, and what is refused.

`tests/e2e/test_touch_programs.py` runs them.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from tests.running import run_here
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.unit.controllers.judging import judged
from wpcal.controllers.audit import audit_path
from wpcal.controllers.audit.touches import touch_faults
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import InputError
from wpcal.core.record_check import check_record
from wpcal.core.records import to_json
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.touch.searches import TouchSetup, touches_record
from wpcal.touch.searches.setup import FanucSetup, InformSetup, KrlSetup, RapidSetup, UrSetup

LANGUAGES = ("rapid", "krl", "fanuc", "inform", "urscript", "as")
NUMBERED = LANGUAGES[1:]
CONTROLLER = ControllerSettings(configurations={"fanuc": "N U T, 0, 0, 0", "inform": "1,0,0,0,0,0,0,0"})
HOME = np.radians([0.0, -20.0, 30.0, 0.0, 60.0, 0.0])


def written(language, plan=None, setup=None, **options):
    program = TouchProgram(plan or tee_plan(), setup or TouchSetup(), options.pop("controller", CONTROLLER), **options)
    return controller_named(language).write_touches(program), program


def text_of(language, *arguments, **options):
    return "\n".join(written(language, *arguments, **options)[0].values()).replace("\r", "")


def fewer(count=2, **changes):
    plan = tee_plan()
    searches = tuple(replace(search, **changes) for search in plan.searches[:count])
    return replace(plan, searches=searches)


@pytest.mark.parametrize("language", LANGUAGES)
def test_programs_hold_the_poses_of_the_plan_and_nothing_else(language):
    plan = replace(fewer(), home_joints=HOME)
    files, program = written(language, plan)
    assert judged(files, program, language).not_checked == ()
    moved = {name: text.replace("115.000", "114.000").replace("0.115000000", "0.114") for name, text in files.items()}
    with pytest.raises(WrittenWrongError, match="read back"):
        judged(moved, program, language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_ways_to_a_search_are_written_before_its_approach(language):
    plan = fewer(1, via=np.array([[0.0, 0.0, 150.0], [10.0, 20.0, 140.0]]))
    files, program = written(language, plan)
    assert judged(files, program, language).not_checked == ()
    turned = fewer(1, via=np.array([[10.0, 20.0, 140.0], [0.0, 0.0, 150.0]]))
    with pytest.raises(WrittenWrongError, match="not asked for"):
        judged(written(language, turned)[0], program, language)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_header_says_what_could_hurt_and_where_the_results_are(language):
    lines = " ".join(re.sub(r"^\s*\d*:?\s*[!;'#]?\s*", "", line).rstrip(" ;") for line in text_of(language).split("\n"))
    said = re.sub(r"\s+", " ", lines)
    for sentence in (
        f"fingerprint {tee_plan().fingerprint}",
        "hold the wire against the part by hand and see it turn on",
        "the sensing voltage is on the wire: keep away from wire and torch",
        "after a missed search the part may be elsewhere",
        "RUN IT DRY FIRST",
        "results:",
        "T4: plane, side of the wire, 16.0 mm along (0.00 1.00 0.00)",
    ):
        assert sentence in said, language


@pytest.mark.parametrize("language", LANGUAGES)
def test_sensing_is_switched_on_for_each_search_and_off_after_it(language):
    enable = "doSense" if language == "rapid" else "3"
    on, off = {
        "rapid": ("SetDO doSense,1;", "SetDO doSense,0;"),
        "krl": ("$OUT[3]=TRUE", "$OUT[3]=FALSE"),
        "fanuc": ("DO[3]=ON", "DO[3]=OFF"),
        "inform": ("DOUT OT#(3) ON", "DOUT OT#(3) OFF"),
        "urscript": ("set_digital_out(3, True)", "set_digital_out(3, False)"),
        "as": ("SIGNAL 3", "SIGNAL -3"),
    }[language]
    text = text_of(language, fewer(), TouchSetup(enable=enable))
    count = 1 if language in ("rapid", "krl") else 2  # these have a subprogram
    assert (text.count(on), text.count(off)) == (count, count)
    assert text.index(on) < text.index(off)
    assert on not in text_of(language, fewer())


@pytest.mark.parametrize("language", LANGUAGES)
def test_an_input_that_contact_turns_off(language):
    state = {
        "rapid": ("IF diTouch=low THEN", "diTouch\\NegFlank,"),
        "krl": ("IF $IN[1]<>FALSE THEN", "WHEN $IN[1]==FALSE DO"),
        "fanuc": ("IF DI[1]=OFF,JMP", "SKIP CONDITION DI[1]=OFF"),
        "inform": ("SRCH RIN#(1)=OFF",),
        "urscript": ("get_standard_digital_in(0) == False:",),
        "as": ("IF SIG(-1001) THEN", "TILL -1001"),
    }[language]
    text = text_of(language, setup=TouchSetup(is_on_high=False))
    assert all(part in text for part in state)


@pytest.mark.parametrize("language", LANGUAGES)
def test_speeds_of_the_setup_are_written(language):
    expected = {
        "rapid": "wptSearch:=[5,500,5,500]",
        "krl": "WPSEARCH(WPGOAL,0.005)",
        "fanuc": "5mm/sec FINE Skip",
        "inform": "V=5.0 SRCH",
        "urscript": ", 0.005)",
        "as": "SPEED 5 MM/S ALWAYS",
    }[language]
    assert expected in text_of(language, setup=TouchSetup(search_speed_mm_s=5.0))


@pytest.mark.parametrize("language", NUMBERED)
@pytest.mark.parametrize("name", ["diTouch", "0.5", "-1", "99999", "١"])
def test_a_name_where_the_language_numbers_inputs_is_one_line(language, name):
    with pytest.raises(InputError, match=r"signal = .* of the touch setup: .* numbers it: expected"):
        written(language, setup=TouchSetup(signal=name))


@pytest.mark.parametrize(
    ("language", "setup", "message"),
    [
        ("rapid", TouchSetup(signal="di touch"), "signal of the touch setup 'di touch': RAPID names"),
        ("rapid", TouchSetup(enable="1"), "enable of the touch setup '1': RAPID names"),
        ("rapid", TouchSetup(rapid=RapidSetup('HOME:";')), "results_folder"),
        ("krl", TouchSetup(krl=KrlSetup(interrupt=40)), "interrupt = 40 of the touch setup: KRL: expected 1 to 39"),
        ("fanuc", TouchSetup(frame_number=10), "FANUC has the user frames 1 to 9"),
        ("fanuc", TouchSetup(fanuc=FanucSetup(first_position_register=93)), "8 searches need 9 position registers"),
        ("fanuc", TouchSetup(fanuc=FanucSetup(first_register=0)), "8 searches need 14 registers from 0 on"),
        ("fanuc", TouchSetup(search_speed_mm_s=0.7), "0.7 mm/s is neither whole mm/s nor whole cm/min"),
        ("inform", TouchSetup(inform=InformSetup(first_byte_variable=95)), "8 searches need 8 byte variables"),
        ("inform", TouchSetup(inform=InformSetup(first_double_variable=95)), "6 double variables from 95 on"),
        ("inform", TouchSetup(search_speed_mm_s=0.05), "is not a multiple of 0.1 mm/s"),
        ("inform", TouchSetup(signal="7"), "expected 1 to 6"),
        ("urscript", TouchSetup(signal="8"), "expected 0 to 7"),
        ("urscript", TouchSetup(urscript=UrSetup('a"b')), "results_host"),
        ("as", TouchSetup(signal="1"), "expected 1001 to 2256"),
        *((name, TouchSetup(with_package=True), "no searches of a") for name in ("inform", "urscript", "as")),
    ],
)
def test_a_setup_that_a_language_cannot_hold_is_one_line(language, setup, message):
    with pytest.raises(InputError, match=re.escape(message)):
        written(language, setup=setup)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"end": np.array([40.0, 100.0, -600.0])}, "a stroke of 618 mm; at most 300 mm"),
        ({"end": np.array([40.0, 100.0, 30.0])}, "it runs away from the face that it should touch"),
        ({"end": np.array([40.0, 100.0, 11.0])}, "its planned contact is not between its start and its end"),
        ({"contact_part": np.array([48.0, 100.0, 10.0])}, "its planned contact is not between"),
    ],
)
def test_a_search_that_does_not_move_onto_its_face_is_refused(changes, message):
    with pytest.raises(InputError, match=f"search T1: .*{message}"):
        written("rapid", fewer(1, **changes))


def test_a_point_out_of_this_world_is_refused():
    files, program = written("rapid", fewer(1, approach=np.array([40.0, 1e9, 115.0])))
    with pytest.raises(InputError, match="rapid: a pose is more than"):
        judged(files, program, "rapid")


@pytest.mark.parametrize("language", ["fanuc", "inform"])
def test_the_configuration_is_never_guessed(language):
    with pytest.raises(InputError, match="every position needs the arm's configuration"):
        written(language, controller=ControllerSettings())


def test_joints_of_the_plan_give_the_configuration():
    joints = np.radians([[-100.0, 20.0, 10.0, 0.0, 60.0, 0.0]] * 3)
    plan = fewer(1, joints=joints)
    arm = find_arm("irb1600_6_12")
    assert "[0,0,0,0],[9E+09" in text_of("rapid", plan)
    text = text_of("rapid", plan, arm=arm)
    assert "ConfL\\Off" not in text
    assert re.search(r"wptT1_A:=\[.*\],\[-2,0,0,0\],", text)
    with pytest.raises(InputError, match="needs a coupling of J3 to J2"):
        written("fanuc", plan, arm=arm)


def test_smartac_searches_over_twice_half_of_the_stroke():
    text = text_of("rapid", setup=TouchSetup(with_package=True))
    assert "pMiddle.trans:=0.5*(pStart.trans+pEnd.trans);" in text
    assert "Search_1D peOff\\SearchStop:=pHit,pStart,pMiddle,wptAir,tTorch\\WObj:=wpPart;" in text
    assert "SearchL" not in text


def test_touch_sense_searches_over_the_middle_of_the_stroke_as_far_as_its_end():
    files, program = written("krl", fewer(), TouchSetup(with_package=True, krl=KrlSetup(sensor=3)))
    assert any("TS_Search" in line for line in judged(files, program, "krl").not_checked)
    source, data = files["WPCAL_touch.src"], files["WPCAL_touch.dat"]
    assert "TS_Search(XWPT_T1_M,ZSPWPT_T1_M,VCDWPT_T1_M)" in source
    assert "INTERRUPT" not in source
    assert "DECL E6POS XWPT_T1_M={X 40.00000,Y 100.00000,Z 10.00000," in data
    assert "SensorNum 3,SearchDepth_Tol 8.0000,bBackToStartPos TRUE" in data
    (reference,) = re.findall(r"VCDWPT_T1_M=\{.*Ref_W \{X (\S+),Y (\S+),Z (\S+),A", data)
    place = tee_plan().T_base_part.apply(np.array([40.0, 100.0, 10.0]))
    np.testing.assert_allclose(np.array(reference, dtype=float), place, rtol=0, atol=1e-4)  # degrees have 6 decimals


def test_touch_sensing_of_fanuc_searches_along_axes_from_the_start():
    text = text_of("fanuc", setup=TouchSetup(with_package=True))
    assert re.findall(r"Search\[(-?[XYZ])\]", text) == ["-Z", "-Z", "-Z", "Y", "Y", "X", "-X", "Y"]
    assert "L P[2] 10mm/sec FINE Search[-Z]" in text
    plan = fewer(1, end=np.array([41.0, 100.0, 2.0]))
    with pytest.raises(InputError, match=r"search T1 runs along .* an axis of the part only"):
        written("fanuc", plan, TouchSetup(with_package=True))


def test_results_are_also_sent_where_the_setup_says():
    text = text_of("urscript", setup=TouchSetup(urscript=UrSetup("192.168.0.2", 5000)))
    assert 'socket_open("192.168.0.2", 5000, "wpt")' in text
    assert text.count("socket_send_line") == 1
    assert "socket" not in text_of("urscript").replace("sockets", "")


def test_a_template_of_the_shop_switches_the_sensing(tmp_path):
    own = tmp_path / "krl"
    own.mkdir()
    (own / "touch_on.txt").write_text("SHOP_TOUCH_ON({{ signal }})\n", encoding="utf-8")
    controller = replace(CONTROLLER, templates=tmp_path)
    with pytest.raises(InputError, match=r"touch_off\.txt: no such file; .* come together, or it may stay on"):
        written("krl", controller=controller)
    (own / "touch_off.txt").write_text("SHOP_TOUCH_OFF()\n", encoding="utf-8")
    assert "SHOP_TOUCH_ON($IN[1])" in text_of("krl", controller=controller)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_audit_knows_a_program_of_another_plan(language, tmp_path):
    files, program = written(language)
    folder = tmp_path / language
    folder.mkdir()
    (tmp_path / "touches.json").write_bytes((TEE_PLAN / "touches.json").read_bytes())
    for name, text in files.items():
        raw, path = text.encode(), folder / name
        assert controller_named(language).load_grammar().is_touch_program(raw, path)
        assert touch_faults(raw, path) == []
        other = raw.replace(program.plan.fingerprint.encode(), b"00000000")
        if b"fingerprint" in other:
            (fault,) = touch_faults(other, path)
            assert "is of the plan 00000000" in fault.message


@pytest.mark.parametrize(("arm", "language", "word"), [("m10ia", "fanuc", "CONFIG"), ("mh6", "inform", "RCONF")])
def test_the_arm_of_the_plan_is_found_by_its_name(arm, language, word, tmp_path):
    joints = np.radians([[10.0, 20.0, -30.0, 5.0, 60.0, 0.0]] * 3)
    plan = replace(fewer(1, joints=joints), home_joints=HOME, robot=arm)
    (tmp_path / "touches.json").write_text(to_json(touches_record(plan)), encoding="utf-8")
    given = () if language == "fanuc" else ("--config", "1,0,0,0,0,0,0,0")
    ended = run_here("export", tmp_path, "-f", language, *given, "--json")
    assert ended.returncode == 0, ended.stderr
    record = json.loads(ended.stdout)
    check_record(record, "wpcal/export/1", path="export", is_complete=False)
    assert record["searches"] == ["T1"]
    text = " ".join(path.read_text(encoding="utf-8") for path in (tmp_path / language).iterdir())
    assert f"{word} computed" in text or f"{word} as given" in text
    assert "POSTYPE ANGLE" in text or "J1=" in text  # home
    ended = run_here("export", tmp_path, "-f", language, *given, "--force", "--robot", "kr5_arc")
    assert f"made for the arm {arm}" in ended.stderr


def test_what_a_person_types_wrong_is_one_line(tmp_path):
    def said(*arguments):
        ended = run_here("export", *arguments)
        assert ended.returncode == 2
        assert ended.stderr.count("\n") == 1
        return ended.stderr

    folder = tmp_path / "plan"
    folder.mkdir()
    (folder / "touches.json").write_bytes((TEE_PLAN / "touches.json").read_bytes())
    assert "csv has no touch programs; controllers that have: as, fanuc" in said(folder, "-f", "csv")
    assert "--only is for weld programs" in said(folder, "-f", "abb", "--only", "W1")
    assert "frame_number in the touch setup" in said(folder, "-f", "abb", "--frame-number", "3")
    assert "made without an arm" in said(folder, "-f", "abb", "--robot", "irb1600")
    assert "no such file" in said(folder, "-f", "abb", "--setup", tmp_path / "none.toml")
    (folder / "calibration.json").write_text("{}", encoding="utf-8")
    assert "name the plan" in said(folder, "-f", "abb")
    assert run_here("export", folder / "touches.json", "-f", "abb").returncode == 0
    assert "exists" in said(folder / "touches.json", "-f", "abb")
    again = run_here("export", folder / "touches.json", "-f", "abb", "--force", "--program-name", "NEW")
    assert "do not load them by mistake" in again.stderr


@pytest.mark.parametrize("language", LANGUAGES)
def test_an_audit_executes_touch_programs_beside_their_plan(language, tmp_path):
    files, _ = written(language, plan := fewer())
    (tmp_path / "touches.json").write_text(to_json(touches_record(plan)), encoding="utf-8")
    moved = {name: text.replace("115.000", "114.000").replace("0.115000000", "0.114") for name, text in files.items()}
    told = []
    for each in (files, moved):
        for name, text in each.items():
            (tmp_path / name).write_bytes(text.encode())
        told.append(sorted({fault.message for file in audit_path(tmp_path).files for fault in file.faults}))
    assert told == [[], ["leads where the plan of touches has no pose"]]
    (tmp_path / "touches.json").unlink()
    assert not any("executed" in file.checked for file in audit_path(tmp_path).files)
