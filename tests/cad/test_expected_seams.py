"""The seams of real assemblies against lists made by hand: what is found of them, and what else is accepted."""

from pathlib import Path

import pytest
from seam_score import expected_seams, is_along, score

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.limits import Level
from wpcal.seam.options import Judging

PARTS = {"as1-oc-214": ".stp", "box_sides": ".STEP", "tail_section_asm": ".stp"}


BOLTED = ("as1-oc-214",)
"""Its brackets are held by bolts: the list says what could be welded, and `--generous` takes that."""


def seams_of(folder: Path, stem: str) -> tuple[Seam, ...]:
    judging = Judging(level=Level.GENEROUS if stem in BOLTED else Level.USUAL)
    return find_seams(open_workpiece(folder / f"{stem}{PARTS[stem]}"), SeamOptions(judging=judging))[0]


@pytest.mark.parametrize("stem", ["as1-oc-214", "box_sides", pytest.param("tail_section_asm", marks=pytest.mark.deep)])
def test_every_expected_seam_is_accepted_and_no_other(stem: str, shared_step: Path) -> None:
    found = score(stem, seams_of(shared_step, stem))
    assert (found.recall, found.precision) == (1.0, 1.0), found


def test_feet_of_the_brackets_have_the_expected_length_and_joint(shared_step: Path) -> None:
    accepted = [seam for seam in seams_of(shared_step, "as1-oc-214") if seam.accepted]
    for item in expected_seams("as1-oc-214"):
        runs = [seam for seam in accepted if is_along(seam, item)]
        assert {seam.joint.value for seam in runs} == {item["joint"]}
        assert len(runs) == (2 if "inside" in item["why"] else 1)  # the rod crosses both inner edges
        assert sum(seam.length_mm for seam in runs) == pytest.approx(item["length_mm"], rel=0, abs=0.01)


def test_every_candidate_that_is_not_accepted_says_why(shared_step: Path) -> None:
    for seam in seams_of(shared_step, "as1-oc-214"):
        assert seam.accepted == (seam.confidence >= 0.25 and not seam.blocked_by)
        assert seam.confidence < 0.5  # what is bolted is not welded by default
        assert seam.accepted or seam.against
        bolt = any("bolt" in name or "nut" in name or name == "rod" for name in seam.solids)
        assert (
            any("bolt or screw" in why or "nut or washer" in why or "rod with nuts" in why for why in seam.against)
            == bolt
        )
