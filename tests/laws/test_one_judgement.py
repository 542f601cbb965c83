"""The law of one judgement: whatever two faces of wpcal say about the same fact of the same part, they say the same."""

from pathlib import Path

import pytest

from tests.few import few
from tests.judgements import Printed, Said, agree, everything_said
from tests.running import kernel_work_here

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared"
OURS = few(["tee/tee", "saddle/saddle", "frame/frame", "lap/lap", "uprights/uprights"], 1)
SHARED_PARTS = (
    "step/box_sides.STEP",
    "step/as1-oc-214.stp",
    "step/featuretype.STEP",
    "blind/wb_bench.step",
    "blind/iron_Footer_Type_U_L70.step",
    "blind/afpm_boom_vane.step",
    *(f"blind/mini/{name}.step" for name in ("em_re", "g80", "g125", "hcol", "lfoot", "lug", "t0", "t90")),
)
SMALL = "blind/mini/"  #: Parts of which touches and motions are planned, too.


@pytest.fixture(autouse=True)
def kernel_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cad.work.child.run_in_child", kernel_work_here)


@pytest.mark.parametrize("name", OURS)
def test_all_say_the_same_of_a_part_of_ours(name: str, tmp_path: Path) -> None:
    assert everything_said(ROOT / "fixtures" / f"{name}.step", tmp_path, is_whole=True).disagreements() == []


@pytest.mark.deep
@pytest.mark.parametrize("name", SHARED_PARTS)
def test_all_say_the_same_of_a_part_of_others(name: str, tmp_path: Path) -> None:
    part = SHARED / name
    if not part.is_file():
        pytest.skip("the shared parts are not beside the repository")
    assert everything_said(part, tmp_path, is_whole=name.startswith(SMALL)).disagreements() == []


def test_two_places_that_differ_are_named() -> None:
    said = Said()
    said.add("seams", "length_mm", 40.0, "W1")
    said.add("welds", "length_mm", 40.0 + 1e-12, "W1")
    said.add("table", "length_mm", Printed("40.0"), "W1")
    assert said.disagreements() == []
    said.add("page", "length_mm", Printed("40.1"), "W1")
    assert said.disagreements() == [
        "length_mm W1: seams says 40.0, welds says 40.000000000001, table says 40.0, page says 40.1"
    ]
    assert not agree(Printed("0.256"), 0.208)
