"""What a person says about members, and what the commands say about seams and members, typed as a user does."""

import json
from pathlib import Path

import pytest
from step_samples import box, write_part

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"


def test_one_seam_is_explained_in_words_in_json_and_as_a_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    ended = run_here("seams", TEE, "--explain", "w1", "--json")
    assert ended.returncode == 0, ended.stderr
    record = json.loads(ended.stdout)
    told = record["explained"]
    assert (told["seam"], told["picture"]) == ("W1", "tee.W1.svg")
    assert (tmp_path / "tee.W1.svg").read_text(encoding="utf-8").startswith("<svg")
    assert record["judging"] == {"weld": [], "not": [], "level": "usual", "least_confidence": 0.8}
    assert {member["taken_as"] for member in record["members"]} == {"a member"}
    section = {"wall_thickness_mm": 150.0, "base_thickness_mm": 10.0, "gap_mm": 0.0, "opening_deg": 90.0}
    assert told["section"] == {**section, "largest_throat_mm": 7.0}
    assert any(
        "wall 150 mm and base 10 mm thick, opening 90 degrees; throat of a fillet up to 7 mm" in w
        for w in told["chain"]
    )
    again = run_here("seams", TEE, "--explain", "W1")
    assert again.returncode == 2
    assert "tee.W1.svg" in again.stderr
    shown = run_here("seams", TEE, "--explain", "W1", "--force")
    assert "found as: contact of two solids" in " ".join(shown.stdout.split())


def test_what_is_said_about_solids_is_kept_in_the_record() -> None:
    ended = run_here("seams", TEE, "--not", "WEB*", "--json")
    record = json.loads(ended.stdout)
    assert record["judging"]["not"] == ["WEB*"]
    assert not any(seam["accepted"] for seam in record["seams"])
    assert {member["said"] for member in record["members"]} == {None, False}


def test_wrong_words_about_members_are_one_line() -> None:
    ended = run_here("seams", TEE, "--weld", "wbe")
    assert ended.returncode == 2
    assert ended.stderr.count("\n") == 1
    assert "has the name 'wbe'; the nearest are" in ended.stderr
    both = run_here("seams", TEE, "--strict", "--generous")
    assert (both.returncode, both.stderr) == (2, "wpcal: --strict and --generous exclude each other\n")


def test_a_part_without_an_inner_corner_says_so(tmp_path: Path) -> None:
    ended = run_here("seams", write_part(tmp_path / "block.step", box()))
    assert "no candidate; --all lists what the solids are taken for" in ended.stdout
    assert "is one solid without an inner corner" in " ".join((ended.stdout + ended.stderr).split())
