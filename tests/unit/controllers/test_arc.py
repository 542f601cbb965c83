"""Arc instructions of every language: on along every seam, nowhere else, and an audit that finds each misplaced one."""

import json
import math
import re
from itertools import pairwise
from pathlib import Path

import pytest

from tests.few import few
from tests.running import run_here
from tests.unit.controllers.judging import arc_faults
from wpcal.controllers.registry import controllers

OPTIONS = ("--config", "fanuc=N U T, 0, 0, 0", "--config", "inform=1,0,0,0,0,0,0,0")
LANGUAGE_FILES = {
    "rapid": ("WPCAL.mod", "ArcLStart", "ArcLEnd"),
    "krl": ("WPCAL.src", "ARC_START", "ARC_END"),
    "fanuc": ("W1.ls", "Weld Start", "Weld End"),
    "inform": ("W1.jbi", "ARCON", "ARCOF"),
    "urscript": ("WPCAL.script", "arc_start", "arc_end"),
    "val3": ("start.pgx", "arcStart", "arcEnd"),
    "as": ("WPCAL.as", "LWS", "LWE"),
    "pdl2": ("WPCAL.pdl", "(?<=^  )arc_start", "(?<=^  )arc_end"),  # not where they are declared
}


@pytest.fixture
def exported(finished_folder, tmp_path):
    """Write weld data as stated, then programs in a language; return how the export ended and its folder."""
    folder = finished_folder()

    def make(language, *options, **values):
        stated = {"thickness_mm": 8, "job": 7, **values}
        file = tmp_path / "welds.json"
        file.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W1", "values": stated}]}))
        call = ("export", folder, "-f", language, *OPTIONS, "-o", folder, "--force", "--only", "W1", *options)
        return run_here(*call, "--welds", file), folder / language

    return make


SINE = {"shape": "sine", "width_mm": 3, "length_mm": 2}


def lines_of(text, pattern):
    return [number for number, line in enumerate(text) if re.search(pattern, line)]


@pytest.mark.parametrize("language", LANGUAGE_FILES)
def test_the_arc_is_on_along_the_seam_and_each_misplaced_instruction_is_found(exported, language):
    name, on_word, off_word = LANGUAGE_FILES[language]
    ended, folder = exported(language, "--arc", "on")
    assert ended.returncode == 0, ended.stderr
    path = folder / name
    text = path.read_bytes().decode().splitlines()
    assert arc_faults(path.read_bytes(), path) == []
    assert run_here("audit", folder).returncode == 0
    (on,), (off,) = lines_of(text, rf"^[^;!#'/]*\b{on_word}\b"), lines_of(text, rf"^[^;!#'/]*\b{off_word}\b")
    (start,), (end,) = lines_of(text, r"SEAM START[ ;]*$"), lines_of(text, r"SEAM END[ ;]*$")
    assert start < on < off < end
    planted = {
        "no arc on": [*text[:on], *text[on + 1 :]],
        "no arc off": [*text[:off], *text[off + 1 :]],
        "neither": [line for number, line in enumerate(text) if number not in (on, off)],
        "on twice": [*text[: on + 1], *text[on:]],
        "off twice": [*text[: off + 1], *text[off:]],
        "on before the seam": [*text[:start], text[on], *text[start:on], *text[on + 1 :]],
        "on after the seam": [*text[: end + 1], text[on], *text[end + 1 :]],
        "off after the seam": [*text[:off], *text[off + 1 : end + 1], text[off], *text[end + 1 :]],
        "off at once": [*text[: on + 1], text[off], *text[on + 1 : off], *text[off + 1 :]],
    }
    if language in ("rapid", "as"):  # the last move ends the arc
        del planted["off at once"]
    assert [what for what, lines in planted.items() if not arc_faults("\n".join(lines).encode(), path)] == []


@pytest.mark.parametrize("language", LANGUAGE_FILES)
def test_a_dry_run_is_the_default_says_so_and_has_no_arc_instruction(finished_folder, tmp_path, language):
    out = tmp_path / "out"
    folder = finished_folder()
    assert run_here("export", folder, "-f", language, *OPTIONS, "-o", out).returncode == 0
    files = {path: path.read_bytes().decode() for path in (out / language).iterdir()}
    header = " ".join(re.sub(r"(?:[\s!;#'/]|\d+:|--)+", " ", text) for text in files.values())
    assert "DRY RUN the arc stays off" in header.replace(":", "")
    assert "RUN IT DRY FIRST" in header
    name, on_word, _ = LANGUAGE_FILES[language]
    path = out / language / name
    assert not any(re.search(rf"^[^;!#'/]*\b{on_word}\b", line) for line in files[path].splitlines())
    assert arc_faults(path.read_bytes(), path) == []
    instruction = {
        ".mod": r"    ArcLStart W1_0001,v10,seam1,weld1,fine,tTorch\WObj:=wpPart;", ".ls": "   9:  Weld Start[1,1] ;",
        ".jbi": "ARCON ASF#(1)", ".src": "ARC_START(1)", ".script": "  arc_start(1)", ".pgx": "  call arcStart(1)",
        ".as": "  LWS W1_0001", ".pdl": "  arc_start(1)",
    }  # fmt: skip
    lines = files[path].splitlines()
    on = lines_of(lines, r"ARC ON[ ;]*$")[-1]
    planted = "\n".join([*lines[: on + 1], instruction[path.suffix], *lines[on + 1 :]])
    (fault,) = arc_faults(planted.encode(), path)
    assert fault == "an arc instruction in a program of a dry run"


def test_the_audit_of_a_folder_reads_the_arcs(exported):
    ended, folder = exported("krl", "--arc", "on")
    assert ended.returncode == 0
    path = folder / "WPCAL.src"
    path.write_bytes(path.read_bytes().replace(b"ARC_END()", b"; ARC_END()"))
    audited = run_here("audit", folder)
    assert audited.returncode == 1
    assert "2 files, 1 fault" in audited.stdout
    assert "the arc is still on at the end of a seam" in audited.stdout


@pytest.mark.parametrize(
    ("language", "values", "message"),
    [
        ("fanuc", {"job": None}, "FANUC: weld W1: needs the number of a schedule of procedure 1; state it"),
        ("fanuc", {"weave": {"shape": "triangle", "width_mm": 3, "length_mm": 2}}, "weave: TP has no triangle"),
        ("fanuc", {"weave_data": "wv1"}, "weave_data: expected the number of a weave schedule"),
        ("inform", {"weave": SINE}, "weave: state weave_data"),
        ("inform", {"job": None, "current_a": None}, "INFORM: weld W1: without a job the values are written; state it"),
        ("krl", {"weave": SINE}, "weave: needs ArcTech (weld_data), or --weave points"),
        ("urscript", {"weave": SINE}, "the language has no weave"),
        ("val3", {"weave": SINE}, "the language has no weave"),
        ("as", {"job": None, "current_a": None}, "AS: weld W1: without a job the values are written; state it"),
        ("as", {"job": None, "weave": {**SINE, "dwell_left_s": 0.1}}, "weave: a weld condition has no dwells"),
        ("as", {"weave": SINE}, "weld condition 7 of the controller has the"),
        ("as", {"tacks": {"length_mm": 400, "pitch_mm": 500}}, "tacks: 400 mm is as long as the seam of 100.0 mm"),
        ("as", {"job": None, "weave_data": "2"}, "weave_data: a weave needs width_mm and length_mm"),
        ("rapid", {"weld_data": "while"}, "weld_data 'while': RAPID names have up to 32"),
    ],
)
def test_what_a_language_cannot_write_is_one_line(exported, language, values, message):
    ended, folder = exported(language, "--arc", "on", **values)
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert message in ended.stderr
    assert not folder.exists()


def test_arc_on_asks_for_weld_data(finished_folder):
    ended = run_here("export", finished_folder(), "-f", "rapid", "--arc", "on")
    assert ended.returncode == 2
    assert "arc instructions need weld data" in ended.stderr
    assert "(--welds)" in ended.stderr


def test_weld_data_of_a_seam_that_is_not_there_is_one_line(finished_folder, tmp_path):
    file = tmp_path / "welds.json"
    file.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W8", "values": {"job": 1}}]}))
    ended = run_here("export", finished_folder(), "-f", "rapid", "--welds", file)
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert f"{file}: unknown seam W8" in ended.stderr


WEAVE = {**SINE, "width_mm": 4, "dwell_left_s": 0.1, "dwell_right_s": 0.1}
WITHOUT_JOB = {"job": None, "current_a": 220, "voltage_v": 24, "crater": {"time_s": 0.4, "current_a": 160}}


@pytest.mark.parametrize(
    ("language", "values", "expected"),
    [
        (
            "rapid",
            {
                "weave": WEAVE,
                "speed_mm_s": 5,
                "current_a": 200,
                "voltage_v": 24,
                "wire_feed_m_min": 6,
                "end_delay_s": 0.2,
            },
            [
                "LOCAL PERS welddata wd_W1:=[5,0,[7,0,24,100,0,200,0,0,0],[0,0,0,0,0,0,0,0,0]];",
                "LOCAL PERS weavedata wv_W1:=[1,0,2,4,0,0.5,0,0.5,0,0,0,0,0,0,0];",
                "LOCAL CONST speeddata v_W1:=[5,500,5,500];",
                r"ArcLStart W1_0001,v_W1,sm_W1,wd_W1\Weave:=wv_W1,fine,tTorch\WObj:=wpPart;",
                r"ArcLEnd W1_0002,v_W1,sm_W1,wd_W1\Weave:=wv_W1,fine,tTorch\WObj:=wpPart;",
            ],
        ),
        (
            "rapid",
            {"seam_data": "sm5", "weld_data": "wd5", "weave_data": "wv5"},
            [r"ArcLStart W1_0001,v_W1,sm5,wd5\Weave:=wv5,fine,tTorch\WObj:=wpPart;"],
        ),
        (
            "fanuc",
            {"weave": WEAVE, "speed_mm_s": 5},
            ["  Weld Start[1,7] ;", "  Weave Sine[2.5Hz,2.0mm,0.100s,0.100s] ;", "5mm/sec FINE ;", "  Weave End ;"],
        ),
        ("fanuc", {"weave_data": "3"}, ["  Weave Sine[3] ;", "  Weave End ;"]),
        ("inform", {"weave_data": "3"}, ["ARCON ASF#(7)", "WVON WEV#(3)", "ARCOF AEF#(7)", "WVOF"]),
        (
            "inform",
            {"start_delay_s": 0.5, "end_delay_s": 0, **WITHOUT_JOB},
            ["ARCON AC=220 AV=24.0 T=0.50", "ARCOF AC=160 AV=24.0 T=0.40"],
        ),
        ("krl", {"end_delay_s": 0, "crater": None}, ["ARC_START(7)", "WAIT SEC 0.2", "ARC_END()"]),
        (
            "krl",
            {"weld_data": "WDAT1"},
            [
                ";FOLD ARCON WDAT1 LIN W1_0001 Vel=0.1 m/s CPDATW1_0001 Tool[1] Base[1];%{PE}",
                "ArcMainNG(#ArcOnAfterMoveStd,WDAT1,WW1_0001)",
                ";FOLD ARCOFF WDAT1 LIN W1_0002 CPDATW1_0002 Tool[1] Base[1];%{PE}",
                "LIN XW1_0002",
                "DECL E6POS XW1_0002={",
                'DECL stArcDat_T WW1_0002={WdatId[] "WW1_0002"}',
            ],
        ),
        ("as", {"end_delay_s": 0, "crater": None}, ["  LWS W1_0001\n  LWE W1_0002 ,7\n"]),
        (
            "as",
            {"speed_mm_s": 5, "end_delay_s": 0.2, "weave": {**SINE, "width_mm": 4}, **WITHOUT_JOB},
            ["  W1SET 1 = 30.0,220,24.0,4.0,2.5\n  W2SET 1 = 0.60,160,24.0\n  LWS W1_0001\n  LWE W1_0002 ,1,1\n"],
        ),
        ("urscript", {"speed_mm_s": 5}, ["  arc_start(7)", "  sleep(0.2)", ", v=0.005", "  arc_end()"]),
        ("val3", {"speed_mm_s": 5}, ["  call arcStart(7)", "  delay(0.2)", "mW1", "  call arcEnd()", 'tmax="5"']),
    ],
)
def test_the_values_are_written_as_the_language_has_them(exported, language, values, expected):
    ended, folder = exported(language, "--arc", "on", **values)
    assert ended.returncode == 0, ended.stderr
    text = "\n".join(path.read_bytes().decode().replace("\r\n", "\n") for path in sorted(folder.iterdir()))
    for line in expected:
        assert line in text
    assert all(arc_faults(path.read_bytes(), path) == [] for path in folder.iterdir())


@pytest.mark.parametrize(
    ("language", "on", "off"),
    [
        ("krl", "$OUT[4]=TRUE", "$OUT[4]=FALSE"),
        ("urscript", "set_standard_digital_out(4, True)", "set_standard_digital_out(4, False)"),
        ("val3", "doArc=true", "doArc=false"),
    ],
)
def test_a_digital_output_switches_the_arc(exported, language, on, off):
    ended, folder = exported(language, "--arc", "on", "--arc-output", "4")
    assert ended.returncode == 0, ended.stderr
    path = folder / LANGUAGE_FILES[language][0]
    text = path.read_text()
    assert text.index(on) < text.index(off)
    assert arc_faults(path.read_bytes(), path) == []
    if language == "val3":  # a variable of its own name
        return
    other = [line.replace("4", "7") for line in (on, off)]  # a gripper, and one that is on during a seam
    lines = text.splitlines()
    first, last = lines_of(lines, re.escape(on))[0], lines_of(lines, re.escape(off))[0]
    mixed = [*lines[: first - 2], *other, *lines[first - 2 : last], *other, *lines[last:]]
    assert arc_faults("\n".join(mixed).encode(), path) == []
    for planted in (
        [*mixed[: first - 2], "  " + on, *mixed[first - 2 :]],
        [*mixed[: first + 2], *mixed[first + 3 :]],
        [*lines[:last], *lines[last + 1 :]],
    ):
        assert arc_faults("\n".join(planted).encode(), path)
    for each in folder.iterdir():  # nothing states the number: a person does
        each.write_text(re.sub(r"(?m)^.*switches the arc.*$", "", each.read_text()))
    silent = path.read_text()
    assert arc_faults(silent.encode(), path)
    assert arc_faults(silent.encode(), path, 4) == []
    codes = [run_here("audit", path, *more).returncode for more in ((), ("--arc-output", "4"), ("--arc-output", "7"))]
    assert codes == [1, 0, 1]


WEAVES = {"shape": "zigzag", "width_mm": 4, "length_mm": 4}


@pytest.mark.parametrize("language", few(LANGUAGE_FILES, 1))
def test_tacks_come_first_then_every_bead_and_a_weave_is_made_of_points(exported, language):
    tacks = {"length_mm": 10, "pitch_mm": 45}
    stated = {"leg_mm": 12, "passes": 2, "weave": WEAVES, "tacks": tacks, "speed_mm_s": 5}
    ended, folder = exported(language, "--arc", "on", "--weave", "points", **stated)
    assert ended.returncode == 0, ended.stderr
    files = {path: path.read_bytes() for path in folder.iterdir()}
    assert all(arc_faults(raw, path) == [] for path, raw in files.items())
    assert run_here("audit", folder).returncode == 0
    text = "\n".join(raw.decode() for raw in files.values())
    assert "Weave" not in re.sub(r"(?m)^.*[!;#'].*$", "", text)  # an instruction of the controller
    starts = sum(len(re.findall(r"SEAM START[ ;]*\r?$", raw.decode(), re.MULTILINE)) for raw in files.values())
    assert starts == 5  # three tacks, two beads
    assert "corner of" not in text  # a weave has corners, its seam has none
    main = "".join(raw.decode() for path, raw in files.items() if path.stem in ("WPCAL", "start"))
    tack, bead = (re.search(rf"W1[._]{run}", main, re.IGNORECASE).start() for run in ("t1", "p1"))
    assert tack < bead
    ended, folder = exported(language, "--tacks", "only", "--weave", "points", **stated)
    assert ended.returncode == 0, ended.stderr
    assert f"{language}: 3 seams" in ended.stdout
    ended, folder = exported(language, "--tacks", "off", "--weave", "points", **stated)
    assert f"{language}: 2 seams" in ended.stdout


def test_the_wire_of_a_weave_of_points_goes_faster_than_the_travel(exported):
    ended, folder = exported("urscript", "--weave", "points", weave=WEAVES, speed_mm_s=5, leg_mm=4)
    assert ended.returncode == 0, ended.stderr
    text = (folder / "WPCAL.script").read_text()
    along = text.split("# ARC ON")[1].split("# ARC OFF")[0]
    points = [[float(v) * 1000 for v in row.split(",")[:3]] for row in re.findall(r"p\[(.*?)\]", along)]
    assert len(points) == 100  # 25 swings of four points
    speed = float(re.search(r"v=([\d.]+), r=0.0002", along)[1]) * 1000
    way = sum(math.dist(a, b) for a, b in pairwise([[0.0, 0.0, 0.0], *points]))
    assert speed * 100 / way == pytest.approx(5.0, abs=0.01)  # along the seam of 100 mm


@pytest.mark.parametrize(("options", "count"), [(("--weave", "points"), 1), ((), 0)])
def test_data_of_the_controller_beside_a_weave_of_points_is_told(exported, options, count):
    ended, folder = exported("rapid", *options, weave=WEAVES, speed_mm_s=5, leg_mm=12, passes=2, weld_data="wd5")
    assert ended.returncode == 0, ended.stderr
    header = " ".join(re.sub(r"\n\s*!", " ", (folder / "WPCAL.mod").read_text()).split())
    for told in (header, ended.stderr):
        said = re.findall(r"data of the controller must have no weave of their own, or there are two: (.*?\))", told)
        assert said == ["W1 (weld_data wd5, job 7)"] * count


def test_tacks_only_without_tacks_is_one_line(exported):
    ended, _ = exported("krl", "--tacks", "only")
    assert (ended.returncode, ended.stderr.count("wpcal: ")) == (2, 1)
    assert "no weld data of the chosen seams states tacks" in ended.stderr


def test_programs_of_others_are_not_judged():
    for suffix in (suffix for each in controllers() for suffix in each.program_suffixes):
        assert arc_faults(b"ARCON ASF#(1)\nMOVL C00001 V=5.0\n", Path(f"theirs{suffix}")) == []


def test_plain_json_holds_the_values_of_every_run(exported):
    ended, folder = exported("json", leg_mm=12)
    assert ended.returncode == 0, ended.stderr
    seams = json.loads((folder / "WPCAL.program.json").read_text())["seams"]
    assert [seam["name"] for seam in seams] == ["W1.p1", "W1.p2", "W1.p3"]
    assert all(seam["weld_data"]["leg_mm"] == 12 and seam["weld_data"]["speed_mm_s"] > 0 for seam in seams)
