"""What a person says about members of a fused body: the seams follow, a file keeps it, and it can be undone."""

import json
from pathlib import Path
from typing import Any

import pytest
from build123d import Box, Pos, export_step

from tests.cad.test_real_parts import shared
from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
BASE, TUBE, WEB = "SOLID/1", "SOLID/2", "SOLID/3"  # by size


@pytest.fixture(scope="module")
def fused(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plate with a web and a square tube on it, as one body."""
    tube = Box(50, 50, 200) - Box(42, 42, 200)
    body = (Pos(0, 0, 5) * Box(300, 200, 10) + Pos(0, 40, 60) * Box(280, 8, 100) + Pos(0, -65, 110) * tube).clean()
    path = tmp_path_factory.mktemp("fused") / "fused.step"
    export_step(body.solid(), path)
    return path


def listed(part: Path, *words: str | Path) -> dict[str, Any]:
    ended = run_here("seams", part, *words, "--json")
    assert (ended.returncode, ended.stderr) == (0, "")
    return dict(json.loads(ended.stdout))


def members(record: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {one["name"]: one for solid in record["members"] for one in solid["listed"]}


def welds(record: dict[str, Any]) -> dict[str, float]:
    return {name: one["weld_mm"] for name, one in members(record).items()}


def test_members_are_listed_with_their_weights_and_welds(fused: Path) -> None:
    found = members(listed(fused))
    kinds = {name: one["kind"] for name, one in found.items()}
    assert kinds == {"SOLID": "", BASE: "plate 200 x 10 mm", TUBE: "tube 50 x 50 x 4 mm", WEB: "bar 100 x 8 mm"}
    kg = {name: one["mass_kg"] / 7850e-9 for name, one in found.items()}
    assert kg["SOLID"] == pytest.approx(600_000 + 224_000 + 147_200, abs=20)
    assert kg[BASE] + kg[TUBE] + kg[WEB] == pytest.approx(kg["SOLID"], abs=20)
    assert kg[BASE] == pytest.approx(600_000, rel=0.1)
    assert {name: one["weld_mm"] for name, one in found.items()} == {"SOLID": 760, BASE: 760, TUBE: 200, WEB: 560}


@pytest.mark.deep
def test_a_round_head_is_as_wide_as_it_is_and_what_is_bought_is_one_member() -> None:
    found = members(listed(shared("as1-oc-214.stp"), "--weld", "bolt#3"))  # each round face there is in two halves
    assert (found["bolt#3/1"]["kind"], found["bolt#3/2"]["kind"]) == ("round bar 10 x 10 mm", "plate 15 x 3 mm")
    assert (found["bolt"]["kind"], found["nut"]["kind"], "bolt/1" in found) == ("bought", "bought", False)


@pytest.mark.deep
def test_the_seams_follow_what_is_said(fused: Path) -> None:
    one = listed(fused, "--member", f"{WEB}={BASE}")
    assert welds(one) == {"SOLID": 200, BASE: 200, TUBE: 200, WEB: 0}
    assert welds(listed(fused, "--member", f"{TUBE}=cast")) == {"SOLID": 560, BASE: 560, TUBE: 0, WEB: 560}
    assert welds(listed(fused, "--member", "SOLID=piece"))["SOLID"] == 0
    chain = ("--member", f"{WEB}={BASE}", "--member", f"{BASE}={TUBE}")
    assert welds(listed(fused, *chain))["SOLID"] == 0


def test_what_is_said_of_a_whole_solid_is_told_once_for_each_seam() -> None:
    against = [text for one in listed(TEE, "--member", "web=cast")["seams"] for text in one["against"]]
    said = [text for text in against if "you said" in text]
    assert said == ["web is not welded: you said so (--member web=cast)"] * 4


def test_what_looks_milled_is_welded_if_a_person_says_so(tmp_path: Path) -> None:
    step = tmp_path / "step.step"
    export_step((Box(200, 200, 150) + Pos(0, 0, 125) * Box(100, 100, 100)).clean().solid(), step)
    assert listed(step)["seams"] == []
    assert welds(listed(step, "--member", "SOLID=weldment")) == {"SOLID": 400}


@pytest.mark.deep
def test_a_file_says_the_same_as_the_words_of_a_command_on_this_part_only(fused: Path, tmp_path: Path) -> None:
    said = listed(fused, "--member", f"{TUBE}=cast")
    file = tmp_path / "seams.json"
    file.write_text(json.dumps(said), encoding="utf-8")
    assert listed(fused, "--seams", file) == said
    assert welds(listed(fused, "--seams", file, "--member", f"{TUBE}=tube")) == welds(listed(fused))
    assert "no member has the name 'SOLID/2'; there is base plate" in refused(TEE, "--seams", file)
    said["judging"]["members"][0]["at_part_mm"][0] += 1.0
    file.write_text(json.dumps(said), encoding="utf-8")
    assert "the part has changed, or is another one" in refused(fused, "--seams", file)


def refused(part: Path, *words: str | Path) -> str:
    ended = run_here("seams", part, *words)
    assert (ended.returncode, ended.stdout, ended.stderr.count("\n")) == (2, "", 1)
    return str(ended.stderr)


def test_wrong_words_are_one_line(fused: Path) -> None:
    told = {
        "SOLID/9=plate": "no member has the name 'SOLID/9'; there is SOLID, SOLID/1",
        f"{TUBE}=SOLID/9": "no member has the name 'SOLID/9'",
        TUBE: "expected NAME=KIND, such as frame/2=plate",
    }
    for word, text in told.items():
        assert text in refused(fused, "--member", word)
    assert "once per name" in refused(fused, "--member", f"{TUBE}=bar", "--member", f"{TUBE}=tube")
