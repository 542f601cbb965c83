"""The law of one judgement: whatever two faces of wpcal say about the same fact of the same part, they say the same."""

from pathlib import Path

import pytest

from tests.few import few
from tests.judgements import Printed, Said, agree, everything_said
from tests.running import kernel_work_here

ROOT = Path(__file__).parents[2]
SHARED = ROOT.parent / "shared"
OURS = [ROOT / "fixtures" / f"{name}/{name}.step" for name in ("tee", "saddle", "frame", "lap", "uprights")]
OF_OTHERS = [
    *(SHARED / "step" / name for name in ("box_sides.STEP", "as1-oc-214.stp", "featuretype.STEP")),
    *(SHARED / "blind" / f"{name}.step" for name in ("wb_bench", "iron_Footer_Type_U_L70", "afpm_boom_vane")),
]
MINI = [SHARED / f"blind/mini/{name}.step" for name in ["em_re", "g80", "g125", "hcol", "lfoot", "lug", "t0", "t90"]]


@pytest.mark.parametrize("part", few([*OURS, *MINI, *OF_OTHERS], 1), ids=lambda part: part.stem)
def test_all_say_the_same_of_a_part(part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cad.work.child.run_in_child", kernel_work_here)
    if not part.is_file():
        pytest.skip("the shared parts are not beside the repository")
    assert everything_said(part, tmp_path, is_whole=part not in OF_OTHERS).disagreements() == []


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
