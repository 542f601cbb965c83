"""What a shop decides again and again becomes a rule, and what it decides only sometimes does not."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here
from wpcal.results.habits import decisions_in, learned_rules

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
