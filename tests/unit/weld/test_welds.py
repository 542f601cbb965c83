"""`wpcal welds`: rules, the user's values, what follows from them, and seams that have changed."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.running import run_here
from tests.unit.conftest import box_mesh
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import read_finished
from wpcal.seam.seam import JointType, SeamFrames, WeldType
from wpcal.weld.place import SeamPlace, StatedWeld, pair, place_of
from wpcal.weld.record import welds_record
from wpcal.weld.rules import Case, read_rules, shipped_rules, shipped_text
from wpcal.weld.runs import RunChoice, Tacks, WeaveBy, laid_runs, runs_of_seam, weld_runs
from wpcal.weld.seam_weld import RECOVERY, weld_for
from wpcal.weld.thickness import plate_thicknesses, thinner

PLACE = SeamPlace((0.0, 0.0, 0.0), (50.0, 0.0, 0.0), 100.0)
HALF = math.sqrt(0.5)
ROUND_OFF = 1e-12  #: Of a turn that is none.
FILLET = np.array([[1.0, 0.0, 0.0], [0.0, HALF, HALF], [0.0, -HALF, HALF]]).T
"""Frame of a fillet along x between a plate below (normal z) and a wall behind (normal y reversed)."""


def straight(make_seam, R=FILLET, n=11, length=100.0):
    x = np.linspace(0.0, length, n)
    return make_seam("W1", np.stack([x, 0 * x, 0 * x], axis=1), np.broadcast_to(R, (n, 3, 3)), frame="base")


def weld(make_seam, user=None, thickness=6.0, position="PB", **settings):
    files = {"thickness_mm": (thickness, "part.glb"), "position": (position, "seams.json")}
    return weld_for(straight(make_seam), PLACE, StatedWeld("W1", None, user or {}, files), shipped_rules(), **settings)


def test_the_wire_that_is_fed_fills_the_section_of_every_bead(make_seam, golden):
    told = []
    for user in ({}, {"leg_mm": 12.0}, {"throat_mm": 3.0}, {"wire_feed_m_min": 10.0}, {"speed_mm_s": 5.0}):
        found = weld(make_seam, user)
        told += [found, welds_record([found], [], shipped_rules())]
        values = found.values
        leg = values.leg_mm or values.throat_mm * math.sqrt(2.0)
        wire_mm2 = math.pi / 4.0 * values.wire_mm**2 * RECOVERY
        fed = values.wire_feed_m_min * 1000.0 / 60.0 * wire_mm2
        assert fed == pytest.approx(leg**2 / 2.0 / values.passes * values.speed_mm_s, rel=0.02)  # both are rounded
    assert weld(make_seam, {"leg_mm": 12.0}).values.passes == 3
    assert len(weld(make_seam, {"leg_mm": 12.0}).beads) == 3
    golden([*told, weld(make_seam, {"wire_mm": 1.2, "process": "141"}, thickness=None)])


@pytest.mark.parametrize("thickness", [1.0, 2.3, 3.2, 4.5, 6.0, 8.0, 25.0])
@pytest.mark.parametrize("user", [{}, {"root_gap_mm": 0.3}, {"root_gap_mm": 4.0}, {"speed_mm_s": 5.0}])
def test_a_square_butt_has_a_wire_feed_and_no_more_speed_than_its_row(make_seam, thickness, user, golden):
    """A gap of 0.3 mm is not filled at four times the speed: the plates would not melt through."""
    seam = straight(make_seam, np.eye(3))
    flat = replace(seam.frames, angle_rad=np.zeros(len(seam.frames)))
    butt = replace(seam, joint=JointType.BUTT, weld=WeldType.GROOVE, frames=flat)
    files = {"thickness_mm": (thickness, "part.glb"), "position": ("PA", "seams.json")}
    values = weld_for(butt, PLACE, StatedWeld("W1", None, user, files), shipped_rules()).values
    _, row = shipped_rules().values_for(Case(JointType.BUTT, WeldType.GROOVE, thickness, "PA"))["speed_mm_s"]
    mm_per_a = values.wire_feed_m_min * 1000.0 / values.current_a * (values.wire_mm / 1.143) ** 2
    if "speed_mm_s" not in user:
        assert mm_per_a == pytest.approx(25.4, rel=0.03)  # of Miller: 1 inch per minute and ampere; the feed is rounded
    filled = values.wire_feed_m_min * 1000.0 / 60.0 * math.pi / 4.0 * values.wire_mm**2 * RECOVERY
    gap = values.root_gap_mm or 0.0
    bead = max(row.bead_mm2, gap * (values.depth_mm or 0.0) / values.passes)
    assert filled / values.speed_mm_s == pytest.approx(bead, rel=0.03)
    assert values.speed_mm_s <= row.values["speed_mm_s"]
    golden(values)


def test_the_rules_cover_every_thickness_and_position_of_a_fillet():
    for thickness in (0.8, 1.4, 3.0, 4.5, 6.0, 10.0, 25.0):
        for position in ("PA", "PB", "PC", "PD", "PE", "PF", "PG"):
            found = shipped_rules().values_for(Case(JointType.TEE, WeldType.FILLET, thickness, position))
            assert {"leg_mm", "current_a", "voltage_v", "speed_mm_s", "wire_mm", "process", "weld"} <= found.keys()
    assert all(row.source for row in shipped_rules().rows)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (("leg_mm = 2.75", "legmm = 2.75"), "rule PA fillet, to 1.4 mm: unknown name 'legmm'; did you mean leg_mm"),
        (("leg_mm = 2.75", "leg_mm = -1"), "rule PA fillet, to 1.4 mm: values.leg_mm: expected a number above 0"),
        (("leg_mm = 2.75", "leg_mm = 2, throat_mm = 2"), "gives throat_mm and leg_mm"),
        (("thickness_mm = [0, 1.4]", "thickness_mm = [2, 1.4]"), "expected two numbers that rise"),
        (('schema = "wpcal/weld-rules/1"', ""), 'expected schema = "wpcal/weld-rules/1"'),
        (('name = "PA fillet, to 2 mm"', 'name = "PA fillet, to 1.4 mm"'), "two rules are named"),
        (("[[rules]]", "[[rules"), "is not TOML"),
        (('source = "the same table: t 4.5"', ""), "rule PA fillet, to 4.5 mm: the field 'source' is missing"),
    ],
)
def test_a_table_of_the_user_with_a_fault_is_refused_in_one_line(tmp_path, changed, message):
    path = tmp_path / "mine.toml"
    path.write_text(shipped_text().replace(*changed), encoding="utf-8")
    with pytest.raises(FormatError, match=message.replace("[", r"\[")) as raised:
        read_rules(path)
    assert "\n" not in str(raised.value)
    assert str(path) in str(raised.value)


def test_the_thickness_of_both_plates_is_felt_on_a_fillet_and_on_a_butt(make_seam):
    wall, base = box_mesh("wall", (-10, 0, 0.0), (110, 6, 80)), box_mesh("base", (-10, -60, -12), (110, 60, 0))
    material = TriangleMaterial.of(PartMesh((wall, base), 0.01, 0.5))
    R = np.stack([np.array([1.0, 0.0, 0.0]), np.array([0.0, HALF, HALF]), np.array([0.0, -HALF, HALF])], axis=1)
    fillet = straight(make_seam, R).frames
    assert sorted(plate_thicknesses(fillet, material)) == pytest.approx([6.0, 12.0])
    left, right = box_mesh("left", (-10, -50, -5), (110, -0.5, 0)), box_mesh("right", (-10, 0.5, -8), (110, 50, 0))
    flat = straight(make_seam, np.eye(3)).frames
    butt = SeamFrames(flat.s_mm, flat.p, flat.R, np.zeros(len(flat)), "base")
    plates = TriangleMaterial.of(PartMesh((left, right), 0.01, 0.5))
    assert sorted(plate_thicknesses(butt, plates)) == pytest.approx([5.0, 8.0])
    assert thinner((5.04, None)) == 5.0
    assert thinner((None, None)) is None


def test_a_plate_that_is_seen_from_its_edge_is_as_thick_as_it_is(make_seam):
    base = box_mesh("base", (-50, -60, -15), (150, 60, 0))

    def felt(upper, length):
        material = TriangleMaterial.of(PartMesh((upper, base), 0.01, 0.5))
        return sorted(plate_thicknesses(straight(make_seam, length=length).frames, material))

    assert felt(box_mesh("lap", (-10, 0, 0), (110, 80, 10)), 100.0) == pytest.approx([10.0, 15.0])
    assert felt(box_mesh("end", (0, 0, 0), (12, 140, 90)), 12.0) == pytest.approx([12.0, 15.0])
    lug = box_mesh("lug", (0, 0, 0), (20, 5, 15))
    pointed = np.where((lug.points[:, 2:] > 1.0) & (lug.points[:, 1:2] > 1.0), lug.points - [0, 4.9, 0], lug.points)
    assert felt(SolidMesh("lug", pointed, lug.triangles, lug.edges), 20.0) == pytest.approx([15.0, 20.0])


def test_a_stretch_of_a_seam_is_cut_at_its_ends(make_seam):
    cut, u95 = runs_of_seam(straight(make_seam), 12.0, 55.5, np.linspace(0.0, 1.0, 11))
    assert (cut.length_mm, cut.frames.s_mm[0], cut.frames.s_mm[-1]) == (43.5, 0.0, 43.5)
    assert cut.frames.p[[0, -1], 0] == pytest.approx([12.0, 55.5])
    assert u95[[0, -1]] == pytest.approx([0.12, 0.555])
    assert np.abs(cut.frames.R - FILLET).max() <= ROUND_OFF


def test_every_bead_is_run_along_every_stretch_before_the_next_bead(make_seam, golden):
    found = weld(make_seam, {"leg_mm": 12.0, "stitch": {"length_mm": 20.0, "pitch_mm": 50.0}})
    runs = weld_runs(straight(make_seam), found)
    assert [run.seam.name for run in runs] == [f"W1.p{p}.s{s}" for p in (1, 2, 3) for s in (1, 2)]
    assert runs[0].seam.frames.p[0] == pytest.approx([15.0, 0.0, 0.0])
    bead = found.beads[1]
    assert runs[2].seam.frames.p[0] - runs[0].seam.frames.p[0] == pytest.approx(FILLET @ [0.0, bead.y_mm, bead.z_mm])
    assert [run.seam.name for run in weld_runs(straight(make_seam), weld(make_seam))] == ["W1"]
    weave = {"shape": "zigzag", "width_mm": 4.3, "length_mm": 7.1}
    woven = weld(make_seam, {"leg_mm": 5.0, "weave": weave, "tacks": {"length_mm": 9.0, "pitch_mm": 43.0}})
    choice = RunChoice(Tacks.FIRST, WeaveBy.POINTS, 23.0)
    golden([runs, laid_runs([(straight(make_seam), np.linspace(0.1, 0.4, 11))], {"W1": woven}, choice, 6.1)])


def test_welds_are_paired_by_place_then_by_name_and_what_changed_is_told():
    far = replace(PLACE, middle_mm=(500.0, 0.0, 0.0))
    near = replace(PLACE, middle_mm=(50.0, 3.0, 0.0))

    def stated(name, place):
        return StatedWeld(name, place, {"leg_mm": 5.0})

    old = [stated("W1", PLACE), stated("W2", far), stated("W3", PLACE)]
    found = pair(old, [("W5", PLACE), ("W2", near)])
    assert found.welds == {"W5": stated("W5", PLACE)}
    assert found.left == tuple(old[1:])
    assert found.notes == ("W5 is at the place of W1 and keeps its values",)
    moved = pair([stated("W1", PLACE)], [("W1", near)])
    assert moved.welds == {"W1": stated("W1", near)}
    assert moved.notes == ("W1 has changed by 3.0 mm and keeps its values",)
    assert pair([stated("W1", None)], [("W1", far)]).welds == {"W1": stated("W1", far)}
    assert pair([stated("W1", far)], [("W1", PLACE)]).left == (stated("W1", far),)


def test_a_place_is_that_of_the_part_and_not_of_the_cell(make_seam, random_place):
    T = random_place(3)
    seam = straight(make_seam)
    moved = replace(seam, frames=seam.frames.moved(RigidTransform(T.R, T.t_mm, "base", "base")))
    assert place_of(moved, T.inverse()).is_same(PLACE)


def test_a_file_is_written_edited_and_written_again(finished_folder, tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")  # no cell of the table is folded
    folder, file = finished_folder(), tmp_path / "welds.json"
    first = run_here("welds", folder, "-o", file)
    assert "W1, Kehlnaht Ü/3: thickness and size are not known; state thickness_mm, or leg_mm" in first.stderr
    assert run_here("welds", folder, "-o", file, "--set", "W1:thickness_mm=8").returncode == 0
    record = json.loads(file.read_text())
    assert [one["name"] for one in record["welds"]] == ["W1", "Kehlnaht Ü/3"]
    assert record["welds"][0]["origin"]["leg_mm"]["from"] == "rule"
    record["welds"][0]["values"].update(leg_mm=12, job=7, crater=None)
    del record["welds"][0]["values"]["voltage_v"]  # back to the rules
    file.write_text(json.dumps(record))
    again = run_here("welds", folder, "-o", file, "--set", 'Kehlnaht Ü/3:tacks={"length_mm":10,"pitch_mm":50}')
    assert again.returncode == 0, again.stderr
    first, second = json.loads(file.read_text())["welds"]
    assert (first["values"]["leg_mm"], first["values"]["job"], first["values"]["crater"]) == (12, 7, None)
    assert {name for name, origin in first["origin"].items() if origin["from"] == "user"} == {
        "thickness_mm",
        "leg_mm",
        "job",
        "crater",
    }
    assert first["values"]["passes"] == len(first["beads"]) == 3
    assert first["values"]["voltage_v"] > 0
    assert second["tacks_mm"] == [[20, 30], [70, 80]]
    assert run_here("welds", folder, "-o", file).stdout.count("3 passes") == 1
    seams = json.loads((folder / "seams.json").read_text())
    seams["seams"][0]["name"] = "W9"
    (folder / "seams.json").write_text(json.dumps(seams))
    assert "W9 is at the place of W1 and keeps its values" in run_here("welds", folder, "-o", file).stderr
    assert json.loads(file.read_text())["welds"][0]["values"]["job"] == 7


def test_values_of_a_seam_that_is_gone_are_kept(finished_folder, tmp_path):
    folder, file = finished_folder(), tmp_path / "welds.json"
    gone = {"start_part_mm": [0, 0, 9], "middle_part_mm": [900, 0, 9], "length_mm": 10}
    record = {"schema": "wpcal/welds/1", "welds": [{"name": "W7", "place": gone, "values": {"job": 3}}]}
    file.write_text(json.dumps(record))
    for _ in range(2):
        ended = run_here("welds", folder, "-o", file)
        assert "W7 has no seam now; its values are kept under without_seam" in ended.stderr
    assert json.loads(file.read_text())["without_seam"] == [{"name": "W7", "place": gone, "values": {"job": 3}}]


def test_a_second_file_adds_its_values_and_loses_none(finished_folder, tmp_path):
    folder = finished_folder(names=("W1", "W2", "W3"), accepted=(True, True, True), spacing_mm=20.0)
    first, second = tmp_path / "welds.json", tmp_path / "second.json"
    stated = ("W1:leg_mm=5", "W1:job=3", "W2:job=4", "W3:process=136", "W3:seam_data=null")
    assert run_here("welds", folder, "-o", first, *(f"--set={one}" for one in stated)).returncode == 0
    gone = {"start_part_mm": [0, 900, 0], "middle_part_mm": [50, 900, 0], "length_mm": 100}
    entries = [
        {"name": "W1", "values": {"throat_mm": 4}, "given_back": ["leg_mm"]},
        {"name": "W2", "values": {"leg_mm": 6}},
    ]
    left = [{"name": "W9", "place": gone, "values": {"job": 8}}]
    second.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": entries, "without_seam": left}))
    done = run_here("welds", folder, "-o", first, "--values", second)
    assert done.returncode == 0, done.stderr
    assert "W1: leg_mm 5 goes back to the rules" in done.stderr
    record = json.loads(first.read_text())
    by_user = [
        {name: weld["values"][name] for name, origin in weld["origin"].items() if origin["from"] == "user"}
        for weld in record["welds"]
    ]
    assert by_user == [{"throat_mm": 4, "job": 3}, {"leg_mm": 6, "job": 4}, {"process": "136", "seam_data": None}]
    assert record["without_seam"] == left
    second.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W7", "values": {"job": 1}}]}))
    before = first.read_bytes()
    done = run_here("welds", folder, "-o", first, "--values", second)
    assert done.returncode == 2
    assert "second.json: unknown seam W7" in done.stderr
    assert first.read_bytes() == before


def test_values_of_a_seam_that_is_not_chosen_are_kept(finished_folder, tmp_path):
    folder, file = finished_folder(), tmp_path / "welds.json"
    assert run_here("welds", folder, "-o", file, "--set", "W1:leg_mm=4").returncode == 0
    ended = run_here("welds", folder, "-o", file, "--only", "Kehlnaht Ü/3")
    assert "W1: not accepted or not chosen; values are kept under without_seam" in ended.stderr
    (kept,) = json.loads(file.read_text())["without_seam"]
    assert (kept["name"], kept["values"]) == ("W1", {"leg_mm": 4})
    ended = run_here("welds", folder, "-o", file)
    assert "without_seam" not in ended.stderr
    record = json.loads(file.read_text())
    assert record["without_seam"] == []
    assert {weld["name"]: weld["values"].get("leg_mm") for weld in record["welds"]}["W1"] == 4


@pytest.mark.parametrize(
    ("welds", "message"),
    [
        ([{"name": "W77", "values": {"job": 3}}], "unknown seam W77; there are Kehlnaht Ü/3, W1, W2"),
        ([{"name": "W1", "values": {"jobs": 3}}], "weld W1: unknown name 'jobs'; did you mean job?"),
        ([{"name": "W1", "values": {"job": "x"}}], "weld W1: values.job: expected a whole number from 0 to 9999"),
        ([{"name": "W1", "values": {"throat_mm": 3, "leg_mm": 4}}], "gives throat_mm 3, leg_mm 4; expected one"),
        ([{"name": "W1"}, {"name": "W1"}], "two welds are for seam W1"),
        ([{"values": {}}], "welds[0]: lacks the name of a seam"),
        ([{"name": "W1", "place": {"length_mm": 3}}], "weld W1: place: lacks start_part_mm"),
        ([{"name": "W1", "values": {"weave": {"shape": "sine"}}}], "weld W1: a weave, crater or stitch lacks width_mm"),
        ([{"name": "W2", "values": {"passes": 3, "weld": None}}], "passes 3: the section of this weld is not known"),
    ],
)
def test_a_file_with_a_fault_is_one_line_and_stays_as_it_is(finished_folder, tmp_path, welds, message):
    folder, file = finished_folder(), tmp_path / "welds.json"
    file.write_text(text := json.dumps({"schema": "wpcal/welds/1", "welds": welds}))
    ended = run_here("welds", folder, "-o", file, "--all")
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert message in ended.stderr
    assert str(file) in ended.stderr
    assert file.read_text() == text


def test_a_file_of_other_rules_is_not_taken_without_them(finished_folder, tmp_path):
    folder, file, rules = finished_folder(), tmp_path / "welds.json", tmp_path / "mine.toml"
    assert run_here("welds", folder, "--write-rules", rules).returncode == 0
    rules.write_text(rules.read_text(encoding="utf-8").replace("leg_mm = 6.5", "leg_mm = 6"), encoding="utf-8")
    assert run_here("welds", folder, "-o", file, "--weld-rules", rules).returncode == 0
    assert "give this file, or its values would be lost (--weld-rules)" in run_here("welds", folder, "-o", file).stderr
    rules.write_text(rules.read_text(encoding="utf-8").replace("out_mm = 15", "out_mm = 16"), encoding="utf-8")
    out = ("--welds", file, "--weld-rules", rules, "-f", "csv", "-o", tmp_path / "out")
    assert "the program has other values (stick_out_mm)" in run_here("export", folder, *out).stderr


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("W9:leg_mm=3", "unknown seam W9"),
        ("W1:legmm=3", "did you mean leg_mm?"),
        ("W1:leg_mm=-3", "expected a number above 0"),
        ("W1:leg_mm=NaN", "expected a finite number"),
        ("W1", "expected SEAMS:NAME=VALUE"),
        ("W1:position=PX", 'expected "PA"'),
    ],
)
def test_a_value_that_is_typed_wrong_is_refused_in_one_line(finished_folder, setting, message):
    ended = run_here("welds", finished_folder(), "--set", setting)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert message in ended.stderr


def test_a_seam_without_a_part_or_a_thickness_still_has_a_weld(finished_folder):
    folder = finished_folder()
    (folder / "part.glb").unlink()
    assert run_here("welds", folder).returncode == 0
    assert read_finished(folder).part_glb is None


def test_a_result_of_an_identified_robot_has_welds_too(finished_folder):
    folder = finished_folder()
    seams = json.loads((folder / "seams.json").read_text())
    (folder / "seams.json").write_text(json.dumps({**seams, "robot_space": "identified"}))
    ended = run_here("welds", folder)
    assert ended.returncode == 0, ended.stderr


def test_contradictions_of_the_user_are_refused(make_seam):
    with pytest.raises(InputError, match="weld W1: stitch: the pitch of 20 mm is shorter"):
        weld(make_seam, {"stitch": {"length_mm": 30.0, "pitch_mm": 20.0}})
