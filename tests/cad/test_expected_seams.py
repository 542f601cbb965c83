"""The seams of real assemblies against lists made by hand: what is found of them, and what else is accepted."""

import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from tests.benchmarks.welds.score import COVERED, sampled
from tests.few import few
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.limits import Level
from wpcal.seam.options import Judging

PARTS = {"as1-oc-214": ".stp", "box_sides": ".STEP", "tail_section_asm": ".stp"}
BOLTED = ("as1-oc-214",)
"""Its brackets are held by bolts: the list says what could be welded, and `--generous` takes that."""
LENGTH_SHARE = 0.01
"""A whole loop has the expected length within this share: the list gives it to a tenth of a millimetre."""


@cache
def seams_of(folder: Path, stem: str) -> tuple[Seam, ...]:
    judging = Judging(level=Level.GENEROUS if stem in BOLTED else Level.USUAL)
    return find_seams(open_workpiece(folder / f"{stem}{PARTS[stem]}"), SeamOptions(judging=judging))[0]


def expected_seams(stem: str) -> list[dict[str, Any]]:
    path = Path(__file__).with_name("expected_seams") / f"{stem}.json"
    seams: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["seams"]
    return seams


def near(points: FloatArray, paths: Sequence[FloatArray], within_mm: float) -> float:
    """Return the share of points that are near one of some polylines; half a step of their samples is allowed."""
    every = np.concatenate([sampled(path).p for path in paths] or [np.full((1, 3), np.inf)])
    return float((cKDTree(every).query(points)[0] <= within_mm + 0.25).mean()) if np.isfinite(every).all() else 0.0


def is_found(item: dict[str, Any], told: Sequence[Seam]) -> bool:
    """Tell whether seams between the same solids run along an expected one, a loop in its whole length."""
    own = [seam for seam in told if sorted(seam.solids) == item["solids"]]
    points = sampled(np.array(item["path_mm"])).p if "path_mm" in item else np.array(item["points_mm"])
    mm = sum(seam.length_mm for seam in own)
    is_long = "path_mm" in item or abs(mm - item["length_mm"]) <= LENGTH_SHARE * item["length_mm"]
    return is_long and near(points, [seam.frames.p for seam in own], item["within_mm"]) >= COVERED


def is_along(seam: Seam, item: dict[str, Any], told: Sequence[Seam] = ()) -> bool:
    """Tell whether a seam runs along an expected one; a loop that is cut where no torch gets, with all in `told`."""
    if sorted(seam.solids) != item["solids"]:
        return False
    if "path_mm" in item:
        return near(sampled(seam.frames.p).p, [np.array(item["path_mm"])], item["within_mm"]) == 1.0
    return is_found(item, [seam] if seam.closed else told)


@pytest.mark.parametrize("stem", few(["as1-oc-214", "box_sides", "tail_section_asm"], 1))
def test_every_expected_seam_is_accepted_and_no_other(stem: str, shared_step: Path) -> None:
    wanted, seams = expected_seams(stem), seams_of(shared_step, stem)
    told = [seam for seam in seams if seam.accepted or seam.blocked_by]  # the list says where joints are, not torches
    assert [item for item in wanted if not is_found(item, told)] == []
    accepted = [seam for seam in seams if seam.accepted]
    assert [seam for seam in accepted if not any(is_along(seam, item, told) for item in wanted)] == []


def test_feet_of_the_brackets_have_the_expected_length_and_joint(shared_step: Path) -> None:
    accepted = [seam for seam in seams_of(shared_step, "as1-oc-214") if seam.accepted]
    for item in expected_seams("as1-oc-214"):
        runs = [seam for seam in accepted if is_along(seam, item)]
        assert {seam.joint.value for seam in runs} == {item["joint"]}
        assert len(runs) == (2 if "inside" in item["why"] else 1)  # the rod crosses both inner edges
        assert sum(seam.length_mm for seam in runs) == pytest.approx(item["length_mm"], rel=0, abs=0.01)


def test_every_candidate_that_is_not_accepted_says_why(shared_step: Path) -> None:
    for seam in seams_of(shared_step, "as1-oc-214"):
        assert seam.accepted == (seam.confidence >= Level.GENEROUS.value and not seam.blocked_by)
        assert seam.confidence < Level.USUAL.value  # what is bolted is not welded by default
        assert seam.accepted or seam.against
        bolt = any("bolt" in name or "nut" in name or name == "rod" for name in seam.solids)
        assert (
            any("bolt or screw" in why or "nut or washer" in why or "rod with nuts" in why for why in seam.against)
            == bolt
        )
