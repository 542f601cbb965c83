"""Decisions about seams in the page: carried out by the library, kept in a file that the commands take."""

import json
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from cad.pick.shared_seams import SharedSeams, start_seams
from cad.session.part import PickPart
from cad.session.session import PickSession
from tests.running import run_here
from wpcal.core.errors import InputError
from wpcal.core.schemas import schema_text

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture
def shared(tee_for_the_picker: PickPart, tmp_path: Path) -> SharedSeams:
    return start_seams(PickSession(tee_for_the_picker), TEE, tmp_path / "taught.csv")[0]


def state(shared: SharedSeams) -> dict[str, Any]:
    return shared.changes_since(-1)


def decided(shared: SharedSeams, *edits: tuple[str, dict[str, Any]], revision: int | None = None) -> dict[str, Any]:
    now = state(shared)
    candidates = {seam.name: seam for seam in shared._part.candidates}
    known = {one["name"]: one["candidate"] for one in candidates_of(candidates)}
    decisions = [{"candidate": known[name], "edit": edit} for name, edit in edits]
    return shared.decide(decisions, revision=now["revision"] if revision is None else revision)


def candidates_of(seams: dict[str, Any]) -> list[dict[str, Any]]:
    from wpcal.seam.record import seams_record

    return list(seams_record(tuple(seams.values()))["seams"])


def accepted(answer: dict[str, Any]) -> dict[str, bool]:
    return {seam["name"]: seam["accepted"] for seam in answer["seams"]}


def test_decisions_are_carried_out_and_kept_for_the_commands(shared: SharedSeams, tmp_path: Path) -> None:
    cut = ("W2", {"range_mm": [0, 60], "name": "W2a"}), ("W2", {"range_mm": [60, 150], "name": "W2b", "reject": True})
    answer = decided(shared, ("W1", {"reject": True}), *cut, ("W3", {"join": [{"candidate": join_of(shared, "W4")}]}))
    assert accepted(answer) == {"W1": False, "W2a": True, "W2b": False, "W3": True}
    assert answer["warning"] == ""
    path = tmp_path / "tee.seams.json"
    assert (answer["file"], shared.used_file) == (str(path), path)
    record = json.loads(path.read_text(encoding="utf-8"))
    jsonschema.validate(record, json.loads(schema_text("wpcal/seams/1")))
    listed = run_here("seams", TEE, "--seams", path, "--json")
    assert (listed.returncode, listed.stderr) == (0, "")
    assert accepted(json.loads(listed.stdout)) == accepted(answer)
    again, notes = start_seams(PickSession(shared._part), TEE, tmp_path / "taught.csv")
    assert accepted(state(again)) == accepted(answer)
    assert notes == (f"{path}: the seams are shown with the decisions in it",)


def join_of(shared: SharedSeams, name: str) -> dict[str, Any]:
    return next(one["candidate"] for one in state(shared)["seams"] if one["name"] == name)


def test_the_page_is_not_believed(shared: SharedSeams, tmp_path: Path) -> None:
    """Frames and verdicts that a page would send are no part of a decision; a decision that does not fit is refused."""
    candidate = join_of(shared, "W2")
    before = state(shared)
    wrong: list[Any] = [
        [{"candidate": candidate, "edit": {"accepted": True}}],
        [{"candidate": candidate, "edit": {"frames": []}}],
        [{"candidate": {**candidate, "length_mm": 1.0}, "edit": {"accept": True}}],
        [{"candidate": {**candidate, "length_mm": float("nan")}, "edit": {"accept": True}}],
        [{"candidate": candidate, "edit": {"range_mm": [0, 1e9]}}],
        [{"candidate": candidate, "edit": {"range_mm": [0, float("inf")]}}],
        [{"candidate": candidate, "edit": {"join": [{"candidate": candidate}]}}],
        [{"candidate": candidate, "edit": {"join": "W3"}}],
        [{"candidate": candidate, "edit": {"name": "W1"}}],
        [{"candidate": candidate, "edit": {"name": "\x1b[31m"}}],
        [{"candidate": candidate, "edit": {"name": "W" * 1000}}],
        [{"candidate": candidate, "edit": {"join": [{"candidate": candidate, "range_mm": [0, 1]}] * 5000}}],
        [{"candidate": candidate, "edit": {"range_mm": [0, 10**400]}}],
        [{"candidate": {**candidate, "length_mm": 10**400}, "edit": {"accept": True}}],
        [{"candidate": candidate}],
        [{"candidate": 7, "edit": {}}],
        [3],
        "W1",
        None,
    ]
    for decisions in wrong:
        with pytest.raises(InputError) as caught:
            shared.decide(decisions, revision=before["revision"])
        assert str(caught.value).isprintable()
    assert state(shared) == before
    assert list(tmp_path.iterdir()) == []
    inside = decided(shared, ("W2", {"other_side": True, "accept": True}))
    assert accepted(inside)["W2"] is False  # no torch welds inside material, whatever the page says
    assert inside["seams"][1]["inside"]


def test_a_decision_on_older_seams_is_not_carried_out(shared: SharedSeams) -> None:
    first = state(shared)["revision"]
    decided(shared, ("W1", {"reject": True}))
    answer = decided(shared, ("W2", {"reject": True}), revision=first)
    assert answer["is_stale"]
    assert accepted(answer) == accepted(state(shared)) == {"W1": False, "W2": True, "W3": True, "W4": False}


def test_a_turned_seam_runs_the_other_way(shared: SharedSeams) -> None:
    plain, turned = state(shared)["frames"][1], decided(shared, ("W2", {"reverse": True}))["frames"][1]
    np.testing.assert_allclose(turned["p"], plain["p"][::-1])


def test_a_file_of_another_program_is_left_alone(shared: SharedSeams, tmp_path: Path) -> None:
    path = tmp_path / "tee.seams.json"
    path.write_text("precious", encoding="utf-8")
    assert "was changed by another program" in decided(shared, ("W1", {"reject": True}))["warning"]
    assert path.read_text(encoding="utf-8") == "precious"


def test_what_an_earlier_session_decided_is_kept_as_the_version_before(shared: SharedSeams, tmp_path: Path) -> None:
    decided(shared, ("W1", {"reject": True}))
    path = tmp_path / "tee.seams.json"
    before = path.read_bytes()
    again, _ = start_seams(PickSession(shared._part), TEE, tmp_path / "taught.csv")
    decided(again)
    assert again.used_file is None
    decided(again, ("W2", {"reject": True}))
    assert path.with_name("tee.seams.json.bak").read_bytes() == before


def test_decisions_that_no_longer_fit_are_told_and_kept(shared: SharedSeams, tmp_path: Path) -> None:
    decided(shared, ("W1", {"reject": True}))
    path = tmp_path / "tee.seams.json"
    path.write_text(path.read_text(encoding="utf-8").replace('"length_mm": 8.0', '"length_mm": 9.0'), encoding="utf-8")
    part, out = PickSession(shared._part), tmp_path / "taught.csv"
    again, (note,) = start_seams(part, TEE, out)
    assert "is not found on this part" in note
    assert accepted(state(again)) == {"W1": False, "W2": True, "W3": True, "W4": False}
    with pytest.raises(InputError, match="is not found on this part"):
        start_seams(part, TEE, out, given=path)


def test_a_given_file_is_read_and_never_written(shared: SharedSeams, tmp_path: Path) -> None:
    """It may be the seams.json of a result."""
    decided(shared, ("W1", {"reject": True}))
    given = (tmp_path / "tee.seams.json").rename(tmp_path / "seams.json")
    before = given.read_bytes()
    again, notes = start_seams(PickSession(shared._part), TEE, tmp_path / "taught.csv", given=given)
    assert (again.used_file, notes) == (given, ())
    decided(again, ("W1", {"reject": True}), ("W2", {"reject": True}))
    assert again.used_file == tmp_path / "tee.seams.json"
    assert given.read_bytes() == before
