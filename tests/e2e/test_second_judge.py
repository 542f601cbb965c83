"""The text of plans judged a second time, by readers, kinematics and a test of contact that are not wpcal's."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cluttered_cells import ROBOTS
from tests.second_judge import ARMS, FIXED, READERS, SecondJudge, Step, rows_of
from tests.whole_table import result_of

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")
pytestmark = pytest.mark.skipif(
    not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"
)


def test_no_program_of_a_plan_touches_the_part_with_wire_torch_or_links(tmp_path: Path) -> None:
    for row in rows_of("tee", "irb1600_6_12", result_of("tee", tmp_path), tmp_path, ("krl", "urscript")):
        assert (row.refused, row.contacts) == ("", ())
        assert row.moves >= 16


def test_a_program_without_its_retracts_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = list[str]()
    whole = SecondJudge.contacts

    def without(judge: SecondJudge, steps: list[Step]) -> list[object]:
        lines = [row for row, step in enumerate(steps) if step.kind != "J"]
        last = {row for row in lines if row + 1 < len(steps) and steps[row + 1].kind == "J"}
        return list(whole(judge, [step for row, step in enumerate(steps) if row not in last]))

    monkeypatch.setattr(SecondJudge, "contacts", without)
    for row in rows_of("tee", "irb1600_6_12", result_of("tee", tmp_path), tmp_path, ("urscript",)):
        found += [contact.body for contact in row.contacts]
    assert "wire" in found


@pytest.mark.deep
@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("part", FIXED)
def test_no_program_of_any_arm_touches_anything(part: str, arm: str, tmp_path: Path) -> None:
    for row in rows_of(part, arm, result_of(part, tmp_path), tmp_path, tuple(READERS)):
        assert row.contacts == (), row
