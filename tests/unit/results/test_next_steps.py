"""What to do now, for every reason of a verdict; what a shop decides again and again becomes a rule."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.running import run_here
from wpcal.calibrate import Solver, TeachingError, calibrate
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.verdict import VerdictReason
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.results import next_steps as steps_module
from wpcal.results.habits import decisions_in, learned_rules
from wpcal.results.next_steps import next_steps

BODY = np.array([[0, 0, 0], [200, 0, 0], [200, 120, 10], [0, 120, 0], [20, 50, 90], [180, 62, 90.0]])
FEATURES = {f"V{i}": p for i, p in enumerate(BODY)} | {"V9": np.array([200.0, 120, 0])}
R = exp_rotation([0.3, -1.2, 0.4])


def fitted(off=(), *, n=6, noise_mm=0.1, seed=0, **options):
    q = BODY[:n] + noise_mm * np.random.default_rng(seed).normal(size=(n, 3))
    for row, vector in off:
        q[row] += vector
    pairs = PointPairs(tuple(FEATURES)[:n], BODY[:n], q @ R.T + [1000, -200, 300])
    return calibrate(pairs, solver=Solver.EXACT, **options).to_record()


def test_a_pass_needs_no_step():
    record = fitted(tolerance_mm=2.0)
    assert record["verdict"] == "PASS"
    assert next_steps(record) == []


def test_every_reason_but_within_has_steps():
    assert set(steps_module._STEPS) == {reason.value for reason in VerdictReason} - {"within"}


def test_the_help_page_explains_every_reason():
    text = (Path(__file__).parents[3] / steps_module.HELP_PAGE).read_text(encoding="utf-8")
    for reason in VerdictReason:
        assert reason is VerdictReason.WITHIN or f"(`{reason.value}`)" in text


def test_the_row_to_touch_again_is_named_and_what_leaving_it_out_would_give():
    steps = next_steps(fitted([(4, [0, 0, 4.0])]))
    assert steps[0].startswith("Touch V4 again")
    assert "write no into its column use: the seams are then predicted within 0." in steps[1]
    assert steps[-1] == "Then calibrate again."


def test_the_feature_to_write_is_named(golden):
    steps = next_steps(fitted([(2, [0, 0, -10.0])], features=FEATURES))
    assert steps[0] == "If V9 was touched, write V9 as the feature of row V2. If not, touch V2 again."
    golden(steps)


def test_the_sigma_that_would_be_enough_is_stated():
    record = fitted(teaching=TeachingError(sigma_mm=0.5), tolerance_mm=0.5)
    assert (record["verdict"], record["judgement"]["reason"]) == ("UNSURE", "error")
    step = next(step for step in next_steps(record) if "carefully" in step)
    enough = float(step.split(": ")[1].split(" mm")[0])
    again = fitted(teaching=TeachingError(sigma_mm=0.95 * enough), tolerance_mm=0.5, noise_mm=0.02)
    assert again["verdict"] == "PASS"


def test_the_sigma_to_state_is_that_of_the_residuals():
    teaching = TeachingError(sigma_mm=0.11, robot=RobotField.none())
    record = fitted(teaching=teaching, noise_mm=0.2, seed=5)
    assert record["judgement"]["reason"] == "stated-error"
    step = next(step for step in next_steps(record) if "--sigma-mm" in step)
    assert 0.1 <= float(step.split("--sigma-mm ")[1].split(")")[0]) <= 0.4


def test_a_sigma_that_is_stated_too_small_may_blame_a_point_and_that_is_said():
    exact_robot = TeachingError(sigma_mm=0.11, robot=RobotField.none())
    record = fitted(teaching=exact_robot, noise_mm=0.2, tolerance_mm=0.05)
    assert record["judgement"]["reason"] == "contradiction"
    assert any("--sigma-mm" in step for step in next_steps(record))
    assert not any("--sigma-mm" in step for step in next_steps(fitted([(4, [0, 0, 9.0])])))


def test_the_feature_to_touch_next_is_named():
    record = fitted(n=3, suggest=lambda _: ("V20", "V3"), tolerance_mm=0.3)
    assert next_steps(record)[0].startswith("Touch V20, V3 as well")


@pytest.mark.parametrize("record", [{}, {"verdict": "FAIL"}, {"verdict": "FAIL", "judgement": {"reason": None}}])
def test_an_older_record_has_no_steps(record):
    assert next_steps(record) == []


def moved(reason, *, never=(), unseen_mm=0.2, placing_mm=0.9, across_mm=0.8, tolerances="stated"):
    seam = {"seam": "W3", "bodies": ["base", "web"], "never_touched": list(never)}
    seam |= {"u95_mm": 2.2, "u95_across_mm": across_mm, "u95_unseen_mm": unseen_mm, "u95_placing_mm": placing_mm}
    bodies = {"seams": [seam], "tolerances": tolerances, "wrong_touches": ["T4"]}
    bodies["bodies"] = [{"name": "base", "touches": 6}, {"name": "web", "touches": 2}]
    return {"verdict": "UNSURE", "judgement": {"reason": reason, "seam": "W3"}, "bodies": bodies, "issues": []}


@pytest.mark.parametrize(
    ("record", "step"),
    [
        (moved("contradiction"), "Touch T4 again"),
        (moved("error", never=["web"]), "Touch web: no touch lies there yet."),
        (moved("error", unseen_mm=2.0), "Touch base, web on faces across W3"),
        (moved("error", unseen_mm=2.0, across_mm=2.1), "Touch web on more of its faces: 2 mm of the error of W3"),
        (moved("error"), "Touch base, web more often or more carefully"),
    ],
)
def test_steps_of_bodies_that_moved(record, step):
    assert next_steps(record)[0].startswith(step)


def test_contacts_that_do_not_hold_come_before_touches():
    record = moved("contradiction")
    record["bodies"]["contacts"] = {"broken": [{"bodies": ["base", "U3"]}]}
    first, second, *_ = next_steps(record)
    assert first == "Calibrate without --contacts: base and U3 do not stay on each other."
    assert second.startswith("Touch T4 again")
    record["bodies"]["wrong_touches"] = []
    assert not any("Touch" in step for step in next_steps(record))


def test_an_assumed_tack_tolerance_can_be_stated():
    assert any("--tack-mm" in step for step in next_steps(moved("error", tolerances="assumed")))
    assert not any("--tack-mm" in step for step in next_steps(moved("error")))


FRAME = json.loads((Path(__file__).parents[3] / "fixtures" / "frame" / "golden" / "seams.json").read_text())


def result(folder: Path, names: dict[str, str], refused: tuple[str, ...] = (), taken: tuple[str, ...] = ()) -> Path:
    """Seams of the frame with other names of its rails; those at a solid of `refused` are refused by hand."""
    record = json.loads(json.dumps(FRAME))
    for one in record["members"]:
        one["solid"] = names.get(one["solid"], one["solid"])
        one["factor"] = 0.1 if one["solid"] in taken else one["factor"]
    for seam in record["seams"]:
        seam["solids"] = [names.get(name, name) for name in seam["solids"]]
        if seam["accepted"] and set(refused) & set(seam["solids"]):
            seam.update(accepted=False, edit={"reject": True})
        if set(taken) & set(seam["solids"]):
            seam.update(accepted=True, edit={"accept": True})
    folder.mkdir(parents=True)
    (folder / "seams.json").write_text(json.dumps(record))
    return folder


def rules_of(*folders: Path, known: tuple[str, ...] = ()) -> list[tuple[str, str, int, int, int]]:
    found = learned_rules(decisions_in(folders), known)
    return [(one.option, one.pattern, len(one.saved), len(one.wrong), one.parts) for one in found]


def at(name: str) -> int:
    return sum(seam["accepted"] and name in seam["solids"] for seam in FRAME["seams"])


def test_what_is_refused_on_several_parts_is_one_rule(tmp_path: Path) -> None:
    first = result(tmp_path / "a", {"left rail": "clamp 1"}, ("clamp 1",))
    second = result(tmp_path / "b", {"right rail": "Clamp_02"}, ("Clamp_02",))
    saved = at("left rail") + at("right rail")
    assert rules_of(first, second) in ([("not", f"{name}*", saved, 0, 2)] for name in ("clamp", "Clamp"))
    again = result(tmp_path / "again", {"left rail": "clamp 1"}, ("clamp 1",))
    record = json.loads((again / "seams.json").read_text())
    (again / "seams.json").write_text(json.dumps({**record, "seams": record["seams"][:-1]}))
    assert rules_of(first, again) == []  # one part, with a seam joined: its decisions are in its own file
    assert rules_of(first, second, known=("CLAMP*",)) == []


def test_what_is_as_often_kept_is_no_rule(tmp_path: Path) -> None:
    parts = [result(tmp_path / name, {"left rail": f"PAD {name}"}, (f"PAD {name}",)) for name in "12"]
    parts += [result(tmp_path / name, {"left rail": f"PAD {name}"}) for name in "34"]
    assert rules_of(*parts) == []


def test_what_is_accepted_at_solids_that_look_bought_is_a_rule(tmp_path: Path) -> None:
    parts = [result(tmp_path / name, {"left rail": f"pin {name}"}, taken=(f"pin {name}",)) for name in "12"]
    [(option, pattern, _, wrong, on)] = rules_of(*parts)
    assert (option, pattern, wrong, on) == ("weld", "pin*", 0, 2)


def test_the_command_proposes_the_line_of_the_file_with_its_evidence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in "12":
        result(tmp_path / name, {"left rail": f"clamp {name}"}, (f"clamp {name}",))
    (tmp_path / "wpcal.toml").write_text('not = ["PAD*"]\n')
    monkeypatch.chdir(tmp_path)
    done = run_here("shop", "learn")
    assert done.returncode == 0, done.stderr
    assert f"not clamp*: saves {2 * at('left rail')} on 2 parts, wrong none" in done.stdout
    assert 'wpcal.toml: not = ["PAD*", "clamp*"]' in done.stdout
    record: dict[str, Any] = json.loads(run_here("shop", "learn", "1", "2", "--json").stdout)
    assert [(one["pattern"], len(one["saved"]), one["wrong"]) for one in record["rules"]] == [
        ("clamp*", 2 * at("left rail"), [])
    ]
    assert run_here("shop", "learn", "1").returncode == 1
    assert run_here("shop", "show", "1").returncode == 2
    (tmp_path / "none").mkdir()
    assert "no seams.json" in run_here("shop", "learn", "none").stderr
