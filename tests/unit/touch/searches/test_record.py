"""Plans of touches and touch setups as files: the same after writing and reading, and a wrong one is one line."""

import copy
import json
import tomllib
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.touch_plans import TEE_PLAN, tee_plan
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.taught.table import read_features_to_touch
from wpcal.touch.searches import (
    SeamPrediction,
    TouchPlan,
    TouchSetup,
    plan_from_record,
    read_touch_plan,
    read_touch_setup,
    setup_template,
    touches_csv,
    touches_record,
)

MOVED_MM = 1e-3


def with_all_fields() -> TouchPlan:
    """Return a plan in which no field is empty."""
    plan, joints = tee_plan(), np.linspace(-1.0, 1.0, 18).reshape(3, 6)
    first = replace(plan.searches[0], joints=joints, via=np.ones((2, 3)), via_joints=joints[:2])
    predicted = SeamPrediction(0.21, "W1", (("W1", 0.21), ("W2", 0.2)))
    searches = (first, *plan.searches[1:])
    return replace(
        plan,
        searches=searches,
        home_joints=joints[0],
        robot="MH6",
        arm=find_arm("mh6"),
        predicted=predicted,
        notes=("F1 left out",),
    )


def without_angles(record: dict[str, Any]) -> dict[str, Any]:
    """Leave out what is converted from radians: it comes back to round-off only."""
    searches = [{key: value for key, value in each.items() if "joints" not in key} for each in record["searches"]]
    return {**record, "searches": searches, "T_base_part": None, "home_joints_deg": None, "arm": None}


def test_a_plan_is_the_same_after_writing_and_reading() -> None:
    plan = with_all_fields()
    record = touches_record(plan)
    again = plan_from_record(json.loads(to_json(record)))
    assert again.fingerprint == plan.fingerprint
    first, second = (without_angles(json.loads(to_json(touches_record(each)))) for each in (plan, again))
    assert first == second
    assert again.T_base_part.is_close(plan.T_base_part, atol_mm=1e-9, atol_rad=1e-12)
    assert np.abs(again.arm.forward(plan.home_joints) - plan.arm.forward(plan.home_joints)).max() < 1e-9
    assert again.searches[0].joints is not None
    assert plan.searches[0].joints is not None
    np.testing.assert_allclose(again.searches[0].joints, plan.searches[0].joints, rtol=0, atol=1e-12)


def test_the_fixture_is_the_plan() -> None:
    assert read_touch_plan(TEE_PLAN).fingerprint == tee_plan().fingerprint
    assert (TEE_PLAN / "touches.csv").read_text(encoding="utf-8") == touches_csv(tee_plan())


def test_the_fingerprint_changes_with_what_the_program_depends_on() -> None:
    plan = tee_plan()
    first, second, *others = plan.searches
    moved = replace(first, end=first.end - MOVED_MM * first.normal_part)
    different = [
        replace(plan, searches=(moved, second, *others)),
        replace(plan, searches=(second, first, *others)),
        replace(plan, searches=(replace(first, name="T9"), second, *others)),
        replace(plan, stick_out_mm=plan.stick_out_mm + MOVED_MM),
    ]
    assert len({plan.fingerprint, *(each.fingerprint for each in different)}) == len(different) + 1
    assert replace(plan, notes=("a note",)).fingerprint == plan.fingerprint


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda r: r["searches"][0].pop("start_mm"), "lacks the field start_mm"),
        (lambda r: r["searches"][0].update(end_mm=r["searches"][0]["start_mm"]), "T1: its start and its end are"),
        (lambda r: r["searches"][0].update(normal=[0, 0, 2]), "T1: its normal is not a unit vector"),
        (lambda r: r["searches"][0].update(R_part_tool=[[1, 0, 0]] * 3), "not a rigid motion"),
        (lambda r: r["searches"][0].update(joints_deg=[[1, 2], [3]]), "rows have different lengths"),
        (lambda r: r["searches"][1].update(serves={}), "search T2: serves: the field 'seam' is missing"),
        (lambda r: r.update(bodies=[{}]), "body 0: the field 'name' is missing"),
        (lambda r: r["searches"][1].update(name="t1"), "two searches are named T1"),
        (lambda r: r["searches"][1].update(name="1x"), "search 1x: name: expected"),
    ],
)
def test_a_wrong_plan_is_one_line(tmp_path: Path, change: Callable[[Any], Any], says: str) -> None:
    record = copy.deepcopy(json.loads(to_json(touches_record(tee_plan()))))
    change(record)
    path = tmp_path / "touches.json"
    path.write_text(json.dumps(record), encoding="utf-8")
    with pytest.raises(FormatError, match=says) as caught:
        read_touch_plan(tmp_path)
    assert "touches.json" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_search_is_found_by_its_name() -> None:
    assert tee_plan().search("t3").name == "T3"
    with pytest.raises(InputError, match="no search 'T9' in the plan; it has T1, T2"):
        tee_plan().search("T9")


def test_the_table_names_what_is_touched(tmp_path: Path) -> None:
    path = tmp_path / "touches.csv"
    path.write_text(touches_csv(tee_plan()), encoding="utf-8")
    assert read_features_to_touch(path) == tuple(search.name for search in tee_plan().searches)


def test_template_has_every_key_with_its_default_and_a_sentence(tmp_path: Path) -> None:
    file = tmp_path / "touch-setup.toml"
    file.write_text(setup_template(), encoding="utf-8")
    assert read_touch_setup(file) == TouchSetup()
    record = tomllib.loads(setup_template())
    for each in fields(TouchSetup):
        value = getattr(TouchSetup(), each.name)
        written = record[each.name]
        assert written == ({k.name: getattr(value, k.name) for k in fields(value)} if is_dataclass(value) else value)
    lines = setup_template().splitlines()
    top = [n for n, line in enumerate(lines) if " = " in line and not line.startswith("#")][: len(record) - 5]
    assert all(lines[n - 1].startswith("# ") for n in top)
    assert all(lines[n - 1].endswith(".") for n in top)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('sgnal = "x"', "unknown key 'sgnal'; did you mean signal?"),
        ("interrupt = 3", "unknown key 'interrupt': it belongs into the section [krl]"),
        ('[krl]\nsignal = "1"', "unknown key '[krl] signal': it belongs before the first section"),
        ('hold_s = "a"', "hold_s: expected a number, got 'a'"),
        ("is_on_high = 1", "is_on_high: expected true or false, got 1"),
        ("search_speed_mm_s = 200", "search_speed_mm_s: expected a number of more than 0 and below 100, got 200"),
        ("search_speed_mm_s = nan", "got nan"),
        ("search_speed_mm_s = 0", "got 0"),
        ("krl = 3", "krl: expected a section [krl], got 3"),
        ("frame_number = -1", "frame_number: expected a number from 0 to 65535, got -1"),
        ("[fanuc]\nfirst_register = 300", "first_register = 300 is after last_register = 200"),
        ("x", "is not TOML"),
    ],
)
def test_a_wrong_setup_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "s.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_touch_setup(file)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_signal_may_be_typed_as_a_number(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text("signal = 7\n[krl]\ninterrupt = 21\n", encoding="utf-8")
    setup = read_touch_setup(file)
    assert (setup.signal, setup.krl.interrupt, setup.fanuc.first_register) == ("7", 21, 151)
