"""What each language asks for; `test_program_text` reads the programs back."""

import re
from dataclasses import replace

import pytest

from wpcal.controllers.abb.write import write_rapid
from wpcal.controllers.comau.write import write_pdl2
from wpcal.controllers.fanuc.write import write_fanuc
from wpcal.controllers.judge.asked import asked_of, compare
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.kuka.write import write_krl
from wpcal.controllers.program import ControllerSettings, MotionSettings
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.staubli.grammar import read_val3
from wpcal.controllers.staubli.write import write_val3
from wpcal.controllers.ur.write import write_urscript
from wpcal.controllers.yaskawa.write import write_inform
from wpcal.core.errors import FormatError, InputError
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.runs import WeldRun
from wpcal.weld.seam_weld import SeamWeld
from wpcal.weld.values import WeldValues


def test_the_file_says_what_each_name_was_and_what_it_does_not_know(make_program):
    (text,) = write_rapid(make_program(names=("naht\nMoveL home;", "W1"))).values()
    assert "ConfL\\Off" in text[text.index("PROC weld_W1") :]
    assert "naht\\x0aMoveL home; -> naht_MoveL_home" in text
    assert not re.search(r"^\s*MoveL home", text, re.MULTILINE)
    assert "confdata is not known" in text
    assert text.isascii()
    assert text.count("\r\n") == text.count("\n")


def test_long_names_are_cut_and_stay_apart(make_program):
    program = make_program(names=("x" * 40 + "1", "x" * 40 + "2"), controller=ControllerSettings(program_name="1 a"))
    ((name, text),) = write_rapid(program).items()
    assert name == "W_1_a.mod"
    identifiers = re.findall(r"(?:robtarget|PROC) (\w+)", text)
    assert max(map(len, identifiers)) <= 32
    assert len(set(map(str.lower, identifiers))) == len(identifiers)


def test_the_file_says_that_c_was_fixed_where_b_is_a_quarter_turn(make_program):
    files = write_krl(make_program(n=9))
    assert "C was fixed at 0" in re.sub(r"\r\n; +", " ", files["WPCAL.src"])
    assert re.search(r"B -?90\.000000,C 0\.000000", files["WPCAL.dat"])


def test_status_and_turn_are_not_guessed(make_program):
    data = write_krl(make_program())["WPCAL.dat"]
    assert not re.search(r"[,{][ST] ", data)
    assert "S and T are not known" in data


def test_names_are_at_most_24_characters_and_no_keywords(make_program):
    program = make_program(names=("y" * 40, "lin"), controller=ControllerSettings(program_name="for", tool_number=7))
    files = write_krl(program)
    assert sorted(files) == ["for_2.dat", "for_2.src"]
    names = re.findall(r"E6POS (\w+)=", files["for_2.dat"])
    assert max(map(len, names)) <= 24
    assert "$TOOL=TOOL_DATA[7]" in files["for_2.src"]


@pytest.mark.parametrize(
    ("write", "file", "example", "other", "written"),
    [
        (write_fanuc, "W1.ls", "N U T, 0, 0, 0", "N U T, 0, 0, -1", "CONFIG : 'N U T, 0, 0, -1'"),
        (write_inform, "W1.jbi", "1,0,0,0,0,0,0,0", "0,1,0,0,0,0,0,0", "///RCONF 0,1,0,0,0,0,0,0\r\n"),
    ],
)
def test_the_configuration_is_the_users(make_program, write, file, example, other, written):
    with pytest.raises(InputError, match=f'every position needs .*--config [a-z]*="{example}"'):
        write(make_program(controller=ControllerSettings()))
    text = write(make_program(controller=ControllerSettings(configurations={"": other})))[file]
    assert text.count(written) == (16 if write is write_fanuc else 1)  # an RCONF stands where it changes


@pytest.mark.parametrize(
    ("write", "changes", "says"),
    [
        (write_fanuc, {"motion": MotionSettings(speed_mm_s=7.3)}, r"nearest is 7\.333 mm/s"),
        (write_fanuc, {"n": 10_000}, "at most 9999"),
        (write_fanuc, {"controller": ControllerSettings(configurations={"fanuc": "0,0,0"})}, "as the pendant shows it"),
        (write_inform, {"motion": MotionSettings(speed_mm_s=7.25)}, r"multiple of 0\.1 mm/s"),
        (write_inform, {"n": 10_000}, "at most 9999"),
        (write_val3, {"n": 10_000}, "seam W1 has 10000 points"),
    ],
)
def test_what_a_language_cannot_hold_is_refused(make_program, write, changes, says):
    with pytest.raises(InputError, match=says):
        write(make_program(**changes))


def test_remarks_fit_the_pendant_and_cannot_end_an_instruction(make_program):
    files = write_fanuc(make_program(names=("a ; JMP LBL[1] ;", "wpcal")))
    for text in files.values():
        remarks = re.findall(r"!(.*) ;\r\n", text)
        assert max(map(len, remarks)) <= 32
        assert not any(";" in remark for remark in remarks)
    assert set(files) == {"WPCAL.ls", "A_JMP_LBL_1.ls", "WPCAL_2.ls"}


@pytest.mark.parametrize(("speed", "written"), [(8.0, "8mm/sec"), (7.5, "45cm/min"), (0.5, "3cm/min")])
def test_speeds_are_written_exactly(make_program, speed, written):
    files = write_fanuc(make_program(motion=MotionSettings(speed_mm_s=speed)))
    assert f"L P[3] {written} CNT100" in files["W1.ls"]


def test_the_program_sets_the_user_frame_to_the_part(make_program):
    program = make_program(controller=ControllerSettings(frame_number=4, configurations={"fanuc": "N U T, 0, 0, 0"}))
    remark = re.compile(r"(?m)^ *\d+: *!.*\n")
    files = {name: remark.sub("", text.replace("\r", "")) for name, text in write_fanuc(program).items()}
    main = next(iter(files.values()))
    assert main.index("UFRAME[4]=PR[51]") < main.index("UFRAME_NUM=4") < main.index("CALL ")
    found = compare(execute(files, tools=(program.controller.tool_number,)), asked_of(program))
    assert (found.missing, found.others) == ((), ())
    moved = {name: text.replace("PR[51,1]=", "PR[51,1]=1+") for name, text in files.items()}
    assert compare(execute(moved, tools=(program.controller.tool_number,)), asked_of(program)).others


def test_cartesian_positions_make_a_relative_job(make_program):
    lines = write_inform(make_program(controller=ControllerSettings(frame_number=5, configurations={"": "1,0"})))[
        "W1.jbi"
    ].splitlines()
    assert lines[lines.index("///ATTR SC,RW,RJ") + 1] == "////FRAME USER 5"
    with pytest.raises(InputError, match="as RCONF of a job has them"):
        write_inform(make_program(controller=ControllerSettings(configurations={"inform": "N U T"})))


def test_comments_fit_the_pendant(make_program):
    files = write_inform(make_program(names=("y" * 60,)))
    assert all(len(line) <= 33 for text in files.values() for line in text.split("\r\n") if line.startswith("'"))


def test_a_name_cannot_break_out_of_its_comment(make_program):
    text = write_urscript(make_program(names=("x\n  movej(home)",)))["WPCAL.script"]
    assert not re.search(r"^\s*movej\(home", text, re.MULTILINE)


def test_an_output_switches_the_arc_or_routines_of_the_user(make_program):
    (text,) = write_pdl2(make_program(n=5, arc=ArcSettings(output=0))).values()
    assert "$DOUT[0] switches the arc" in text
    assert text.index("  $DOUT[0] := TRUE") < text.index("TO W1_0002") < text.index("  $DOUT[0] := FALSE")
    assert "EXPORTED FROM" not in text
    (text,) = write_pdl2(make_program(n=5, arc=ArcSettings())).values()
    assert "ROUTINE arc_start(job : INTEGER) EXPORTED FROM wp_arc" in text


DATA = "{http://www.staubli.com/robotics/VAL3/Data/2}"
PROGRAM = "{http://www.staubli.com/robotics/VAL3/Program/2}"


def test_no_two_names_of_val3_and_urscript_differ_by_capitals_only(make_program):
    program = make_program(n=5, names=("W1", "w1", "mW1", "Weld", "TTORCH"))
    weld = SeamWeld("W1", None, JointType.TEE, WeldType.FILLET, WeldValues(speed_mm_s=5.0), {})
    paths = [replace(path, run=WeldRun(path.seam, weld, None, None)) for path in program.paths]
    text = write_val3(replace(program, paths=tuple(paths)))["WPCAL.dtx"]
    names = [name.lower() for name in (*re.findall(r'<Data name="(\w+)"', text), "tTorch")]
    assert len(names) == len(set(names)) == 5 + 2 * len(paths) + 1
    assert [*write_urscript(replace(program, controller=ControllerSettings("WP_Part")))] == ["WP_Part_2.script"]


@pytest.mark.parametrize("encoding", ["foo1", "utf-7", "idna", "hex"])
def test_an_encoding_that_no_reader_knows_is_one_line(encoding):
    with pytest.raises(FormatError, match="is not XML") as caught:
        read_val3(f'<?xml version="1.0" encoding="{encoding}"?><Database/>', "a.dtx")
    assert "\n" not in str(caught.value)
