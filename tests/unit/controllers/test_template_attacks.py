"""Motions that a template adds, displaces or leaves out are named with file and line, and nothing is called checked."""

import json
import re

import pytest

from tests.few import few
from tests.running import run_here
from wpcal.controllers.language.post import shipped_templates

OPTIONS = ("--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0", "--only", "W1", "--json")
ATTACKS = {
    "rapid": (
        "MoveL [[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v7000,z0,tTorch;",
        "MoveAbsJ [[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v1000,fine,tTorch;",
        "MoveL Offs({{ point }},0,0,-50),{{ speed }},fine,{{ tool }}\\WObj:=wpPart;",
        "MoveL {{ point }},{{ speed }},fine,tool0\\WObj:=wpPart;",
        "MoveL {{ point }},{{ speed }},fine,{{ tool }};",
        "PDispSet [[0,0,50],[1,0,0,0],[0,0,0,0],[0,0,0,0]];",
        "wpPart.uframe.trans.x := 500;",
        "{{ point }}.trans.z := 0;",
        "FOR i FROM 1 TO 9 DO",
        "SoftAct 1,50;",
        "GOTO again;",
        "clean_torch;",
        "WaitTime 1; MoveJ home,v1000,fine,tool0;",
        "ENDMODULE",
        "MoveC {{ point }},[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tTorch;",
        "MoveL {{ point }},{{ speed }},z50,{{ tool }}\\WObj:=wpPart;",
        "{{ tool }}:=tool0;",
        "WHILE TRUE DO\nENDWHILE",
        "IF TRUE THEN\nMoveL Offs({{ point }},0,0,-9),v100,fine,{{ tool }}\\WObj:=wpPart;\nENDIF",
        "PDispOn {{ point }},{{ tool }};",
        "EOffsSet [10,0,0,0,0,0];",
        "MoveLDO {{ point }},v100,fine,tTorch,do1,1;",
        '%"clean"%;',
        "EXIT;",
        "WaitTime 1; MoveL Offs({{ point }},0,0,-9),v100,fine,{{ tool }}\\WObj:=wpPart; ! WaitTime 1;",
        r"SingArea\Wrist;",
        r"CirPathMode\WristFrame;",
        r"MoveL {{ point }},{{ speed }},fine\Z:=150,{{ tool }}\WObj:=wpPart;",
    ),
    "krl": (
        "LIN {X 0,Y 0,Z 0,A 0,B 0,C 0}",
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}",
        "LIN_REL {Z -50}",
        "$BASE.X=500",
        "$BASE=$NULLFRAME",
        "$TOOL=TOOL_DATA[2]",
        "LIN {{ point }}:{Z -50}",
        "CLEAN_TORCH()",
        "LIN {{ point }} C_DIS",
        "INTERRUPT ON 3",
        "SPTP {{ point }}",
        "CIRC {{ point }},{X 0,Y 0,Z 0}",
        "FOR I=1 TO 3",
        "WHILE TRUE\nENDWHILE",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO CLEAN()",
        "LIN_REL {Z -50} #TOOL",
        "$TOOL={X 0,Y 0,Z 0,A 0,B 0,C 0}",
        "$ORI_TYPE=#CONSTANT",
        "$CIRC_TYPE=#PATH",
        "$IPO_MODE=#TCP",
        "SLIN {{ point }} WITH $ORI_TYPE=#CONSTANT",
    ),
    "fanuc": (
        "L PR[5] 100mm/sec FINE",
        "{{ point and 'L ' }}{{ point }} {{ speed }} FINE Offset,PR[1]",
        "UFRAME_NUM=2",
        "UTOOL_NUM=3",
        "PR[5,3]=PR[5,3]-50",
        "OFFSET CONDITION PR[1]",
        "CALL CLEAN",
        "JMP LBL[1]",
        "J P[99] 10% FINE",
        "UFRAME[1]=PR[2]",
        "TOOL_OFFSET CONDITION PR[3]",
        "IF R[1]=1,JMP LBL[1]",
        "L PR[1] 100mm/sec FINE INC",
        "C P[1] P[2] 100mm/sec FINE",
        "{{ point and 'L ' }}{{ point }} {{ speed }} FINE Wjnt",
    ),
    "inform": (
        "MOVL P001 V=100.0",
        "IMOV P001 V=100.0",
        "SFTON P001",
        "CALL JOB:CLEAN",
        "JUMP *AGAIN",
        "MOVJ {{ point }} VJ=100.00 NWAIT",
        "MOVC P001 V=10.0",
        "SET P001 P002",
        "CALL JOB:HOME IF IN#(1)=ON",
        "MOVL {{ point }} {{ speed }} PL=8",
        "MOVL {{ point }} {{ speed }}",
        "MSHIFT PX001 BF PX002 PX003",
    ),
    "as": (
        "DRAW 0,0,-50",
        "HOME",
        "LMOVE SHIFT({{ point }} BY 0,0,-50)",
        "BASE NULL",
        "TOOL NULL",
        "LDEPART -50",
        "CALL clean",
        "ALIGN",
        "JAPPRO {{ point }},100",
        "DRIVE 1,10",
        "JMOVE #home",
    ),
    "urscript": (
        "movej([0,-1.57,1.57,0,1.57,0])",
        "movel(pose_trans({{ point }}, p[0,0,0.05,0,0,0]), {{ speed }})",
        "set_tcp(p[0,0,0,0,0,0])",
        "speedl([0,0,-0.1,0,0,0], 0.5, 1)",
        "force_mode(tool_pose(), [0,0,1,0,0,0], [0,0,10,0,0,0], 2, [1,1,1,1,1,1])",
        "clean_torch()",
        "movec(p[0,0,0,0,0,0], p[0,0,0.1,0,0,0], a=1, v=0.1)",
        "servoj([0,0,0,0,0,0])",
        "movel(p[0,0,0,0,0,0], a=1, v=0.1)",
        "while True:\n  sleep(0.1)\nend",
        "movel(get_inverse_kin(p[0,0,0,0,0,0]))",
    ),
    "val3": (
        "movej(jHome,{{ tool }},{{ speed }})",
        "movel(appro({{ point }},{0,0,-50,0,0,0}),{{ tool }},{{ speed }})",
        "{{ tool }}.trsf.z=0",
        "call clean()",
        "{{ point }}.trsf.z=0",
        "movec({{ point }},pOther,{{ tool }},{{ speed }})",
        "movel(compose({{ point }},fPart,{0,0,-50,0,0,0}),{{ tool }},{{ speed }})",
        "while true\nendWhile",
        "alterMoveTime(1)",
        "movej({0,0,0,0,0,0},{{ tool }},{{ speed }})",
    ),
    "pdl2": (
        "MOVE LINEAR TO POS(0, 0, 0, 0, 0, 0)",
        "MOVE RELATIVE VEC(0, 0, -50) IN TOOL",
        "$UFRAME := POS(0, 0, 50, 0, 0, 0)",
        "$TOOL := POS(0, 0, 0, 0, 0, 0)",
        "clean_torch",
        "MOVE CIRCULAR TO POS(0, 0, 0, 0, 0, 0) VIA POS(9, 0, 0, 0, 0, 0)",
        "WHILE TRUE DO\nENDWHILE",
        "MOVE JOINT TO {0, 0, 0, 0, 0, 0}",
        "MOVE AWAY 50",
        "MOVEFLY LINEAR TO POS(0, 0, 0, 0, 0, 0) ADVANCE",
        "GOTO again",
    ),
}
"""The first of each language are tried at each push."""
PUSHED = {(name, each) for name, rows in ATTACKS.items() for each in rows[:4]}
ALL = [(name, each) for name, rows in ATTACKS.items() for each in rows]
MOTIONS = {name: rows[0] for name, rows in ATTACKS.items()} | {"val3": "movej(jHome,tTorch,mAir)"}
COMMENTS = {
    "rapid": "!", "krl": ";", "fanuc": "!", "inform": "'", "as": ";", "urscript": "#", "val3": "//", "pdl2": "--",
}  # fmt: skip


@pytest.fixture
def export(finished_folder, tmp_path):
    folder = finished_folder()

    def make(language, block, text):
        own = tmp_path / "shop" / language
        own.mkdir(parents=True, exist_ok=True)
        (own / f"{block}.txt").write_text(text, encoding="utf-8")
        ended = run_here("export", folder, "-f", language, *OPTIONS, "-o", tmp_path, "--template", own.parent)
        folder_of_programs = tmp_path / language
        if ended.returncode == 2:
            assert not folder_of_programs.exists()
            return ended, {}, {}
        written = {p.name: p.read_bytes().decode("latin-1") for p in folder_of_programs.iterdir()}
        return ended, json.loads(ended.stdout), written

    return make


def require_named(answer, written, fragment):
    """The place that is told holds the line."""
    found = re.findall(r"NOT CHECKED: (\S+), lines? (\d+)[^:]*: '", answer["not_checked"])
    assert found, answer["not_checked"]
    texts = [written[file].splitlines()[int(number) - 1] for file, number in found]
    assert any(fragment in text for text in texts), (fragment, texts)


def require_refused_or_named(ended, answer, written, attack):
    if ended.returncode == 2:  # executed, it is no program, or one that leads elsewhere
        assert (ended.stderr.count("wpcal: "), "templates" in ended.stderr) == (1, True), ended.stderr
        return
    assert ended.returncode == 1
    assert answer["checked"] == []
    line = attack.split("\n")[0]
    start = re.split(r"\{\{|\{%", line)[0].split("'")[0] or line.rsplit("}}", 1)[1]
    require_named(answer, written, start.strip())
    assert not any("checked against" in text for text in written.values())


@pytest.mark.parametrize(("language", "attack"), few(sorted(ALL, key=lambda one: one not in PUSHED), len(PUSHED)))
def test_a_line_that_a_template_adds_is_named(export, language, attack):
    found = export(language, "air_move", shipped_templates(language)["air_move.txt"] + attack + "\n")
    require_refused_or_named(*found, attack)


@pytest.mark.parametrize("language", few(MOTIONS, 2))
def test_a_move_by_the_joints_is_no_line(export, language):
    text = shipped_templates(language)["air_move.txt"].replace("if joint", "if true")
    require_refused_or_named(*export(language, "air_move", text), "W1_to" if language in {"rapid", "krl"} else " ")


NEVER_RUN = {
    "rapid": ("footer", "PROC on_call(num n)\n", "MoveJ home,v1000,fine,tool0;", "\nENDPROC\nENDMODULE\n"),
    "krl": ("footer", "INTERRUPT DECL 3 WHEN $STOPMESS DO OUT()\nEND\nDEF OUT()\n", "LIN {X 0,Y 0,Z 0}", "\nEND\n"),
    "urscript": ("footer", "end\nthread out():\n", "movej([0,0,0,0,0,0])", "\nend\n"),
    "fanuc": ("before_run", "JMP LBL[8]\n", "L PR[5] 100mm/sec FINE", "\nLBL[8]\n"),
    "inform": ("before_run", "JUMP *A\n", "MOVL P001 V=100.0", "\n*A\n"),
}
"""Blocks with a motion that no run of the program comes to: what is before it, the motion, and what is after it."""


@pytest.mark.parametrize("language", few(NEVER_RUN, 3))
def test_a_line_that_never_runs_is_named(export, language):
    block, *parts = NEVER_RUN[language]
    require_refused_or_named(*export(language, block, "".join(parts)), parts[1])


@pytest.mark.parametrize("block", few(["weld_start", "before_run", "weld_end", "after_weld"], 2))
@pytest.mark.parametrize("language", MOTIONS)
def test_a_motion_in_every_block_is_named(export, language, block):
    found = export(language, block, shipped_templates(language)[f"{block}.txt"] + MOTIONS[language] + "\n")
    require_refused_or_named(*found, MOTIONS[language])


@pytest.mark.parametrize("language", MOTIONS)
def test_a_shop_has_its_own_lines_around_a_run_and_around_a_weld(export, language, tmp_path):
    hooks = ("before_run", "before_weld", "after_weld", "after_run")
    assert all(shipped_templates(language)[f"{hook}.txt"].startswith("{#") for hook in hooks)  # ours are empty
    own = tmp_path / "shop" / language
    own.mkdir(parents=True)
    for hook in hooks[1:]:
        (own / f"{hook}.txt").write_text(f"{COMMENTS[language]} here: {hook}\n", encoding="utf-8")
    ended, answer, written = export(language, hooks[0], f"{COMMENTS[language]} here: {hooks[0]}\n")
    assert (ended.returncode, bool(answer["checked"])) == (0, True), answer["not_checked"]
    text = "".join(written.values())
    assert [text.count(f"here: {hook}") for hook in hooks] == [1, 1, 1, 1]
    assert text.index(f"here: {hooks[1]}") < text.index(f"here: {hooks[2]}")


@pytest.mark.parametrize("language", MOTIONS)
def test_a_comment_that_looks_like_a_motion_is_none(export, language):
    line = f"{COMMENTS[language]}{MOTIONS[language][:28]}"
    ended, answer, _ = export(language, "air_move", shipped_templates(language)["air_move.txt"] + line + "\n")
    assert (ended.returncode, bool(answer["checked"])) == (0, True), answer["not_checked"]


@pytest.mark.parametrize(
    ("language", "block", "text", "line"),
    [
        ("rapid", "header", "ENDMODULE\n", "ENDMODULE"),
        ("rapid", "footer", "PROC again()\n  GOTO start;\nENDPROC\nENDMODULE\n", "GOTO start;"),
        ("krl", "footer", "END\nDEF EXTRA()\nLIN {X 0,Y 0,Z 0,A 0,B 0,C 0}\nEND\n", "LIN {X 0"),
        ("urscript", "footer", "end\nmovej([0,0,0,0,0,0])\n", "movej(["),
        ("fanuc", "header", "  !ours ;\n  10:L PR[5] 100mm/sec FINE ;\n", "L PR[5]"),
    ],
)
def test_text_around_the_program_is_executed_too(export, language, block, text, line):
    require_refused_or_named(*export(language, block, text), line)


@pytest.mark.parametrize(
    ("language", "line"),
    [
        ("rapid", "WaitTime 0.5;"),
        ("rapid", 'TPWrite "at {{ point }}";'),
        ("rapid", "! SetDO doClean,1;"),
        ("krl", "$OUT[7]=TRUE"),
        ("fanuc", "WAIT   1.00(sec)"),
        ("inform", "TIMER T=0.50"),
        ("as", "SIGNAL 12"),
        ("urscript", "sleep(0.5)"),
        ("val3", "delay(0.5)"),
        ("pdl2", "DELAY 500"),
    ],
)
def test_a_line_that_moves_nothing_leaves_the_program_checked(export, language, line):
    ended, answer, _ = export(language, "air_move", shipped_templates(language)["air_move.txt"] + line + "\n")
    assert answer["checked"], answer["not_checked"]
    assert ended.returncode == 0


def test_another_speed_is_no_other_motion(export):
    text = shipped_templates("rapid")["air_move.txt"].replace("{{ speed }}", "v200")
    ended, answer, _ = export("rapid", "air_move", text)
    assert (ended.returncode, bool(answer["checked"])) == (0, True)


def test_a_template_that_leaves_a_move_out_is_refused(export):
    ended, _, _ = export("krl", "weld_start", "; {{ point }} {{ mark }}\n; {{ mark }}\n$VEL.CP={{ speed }}\n")
    assert ended.returncode == 2
    assert "the templates break the program: krl: the pose at base" in ended.stderr
    assert "is missing in the written program" in ended.stderr
