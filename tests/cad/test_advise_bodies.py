"""`wpcal advise --bodies` on the uprights: which plate, for which seam, how far, and what it cannot promise."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from build123d import Box, Pos

import cad
from cad.workpiece.touched_bodies import bodies_at
from cad.workpiece.workpiece import Workpiece
from tests.record_checks import check_record
from wpcal.core.errors import GeometryError
from wpcal.taught.table import read_taught

UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"
PART, BODIES = UPRIGHTS / "uprights.step", UPRIGHTS / "bodies.json"
Command = Callable[..., Any]


def advice(wpcal: Command, *words: Path | str, ends: int = 0) -> dict[str, Any]:
    done = wpcal("advise", PART, "--bodies", BODIES, *words, "--json")
    assert done.returncode == ends, done.stderr
    record: dict[str, Any] = json.loads(done.stdout)
    check_record(record)
    return record


def test_two_points_for_each_plate_in_the_order_of_what_they_gain(wpcal: Command, tmp_path: Path, golden: Any) -> None:
    out = tmp_path / "template.csv"
    found = advice(wpcal, "-o", out)
    touches = found["touches"]
    assert len(touches) == 10
    assert {touch["body"] for touch in touches} == {"base", "U1", "U2", "U3", "U4"}
    after = [touch["after_mm"] for touch in touches if touch["after_mm"] is not None]
    assert after[-1] < 0.5 * after[0]
    assert [line.split(",")[0] for line in out.read_text().splitlines()[1:]] == [touch["name"] for touch in touches]
    assert read_taught(UPRIGHTS / "taught.csv").names  # the template is filled in like this table
    text = " ".join(wpcal("advise", PART, "--bodies", BODIES).stdout.split())  # lines end where the window does
    assert "tack tolerance 1 mm and 4 mrad" in text
    assert f"after these, {found['next']['sentence']}" in " ".join(text.split())
    golden(found)


def test_the_plate_that_was_not_touched_comes_next(wpcal: Command) -> None:
    found = advice(wpcal, "--count", "1", "--have", "V1,V3,V39,V30,V6,V12,V36,V22,V24")
    (touch,) = found["touches"]
    assert touch["body"] == "U3"
    assert f"seam {touch['seam']} from {touch['before_mm']:.2f} mm to {touch['after_mm']:.2f} mm" in touch["sentence"]


def test_kept_contacts_tell_as_much_as_touches(wpcal: Command) -> None:
    free, kept = advice(wpcal, "--count", "8"), advice(wpcal, "--count", "8", "--contacts")
    assert kept["joint_95_mm"] < free["joint_95_mm"]


@pytest.mark.deep
def test_a_tolerance_takes_harder_places_if_it_must(wpcal: Command) -> None:
    loose, tight = advice(wpcal, "--tolerance-mm", "2.5"), advice(wpcal, "--tolerance-mm", "1.0")
    assert loose["joint_95_mm"] <= 2.5
    assert tight["joint_95_mm"] <= 1.0
    assert len(loose["touches"]) < len(tight["touches"])
    assert tight["why_not"] == ""


@pytest.mark.deep
def test_a_tolerance_below_the_errors_of_touches_says_why(wpcal: Command) -> None:
    found = advice(wpcal, "--tolerance-mm", "0.05", ends=1)
    assert found["why_not"].startswith("0.05 mm is not reached: ")
    assert len(found["touches"]) <= 60


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--tolerance-mm", "1"), "--tolerance-mm is for --bodies"),
        (("--bodies", "--tolerance-mm", "-1"), "must be a positive length"),
        (("--bodies", "--count", "0"), "1 touch or more"),
        (("--tack-mm", "1"), "for --bodies"),
        (("--bodies", "--exclude", "V999"), "no feature 'V999'"),
    ],
)
def test_what_cannot_be_asked_is_one_line(wpcal: Command, words: tuple[str, ...], says: str) -> None:
    done = wpcal("advise", PART, *words)
    assert done.returncode == 2
    assert says in done.stderr.strip().splitlines()[-1]


def test_middles_of_edges_are_on_the_body_of_their_edge(sample_part: Callable[[str], Workpiece]) -> None:
    """The ends of the edge of one plate are farther away than a vertex of the other plate."""
    tee = sample_part("tee")
    middles = [feature for feature in tee.features if feature.kind.value == "M"]
    body = bodies_at(tee.graph, np.array([feature.p_mm for feature in middles]), tee.graph.face_solid)
    assert [tee.graph.solid_names[b] for b in body] == [feature.solid for feature in middles]


def test_a_part_without_an_accepted_seam_is_one_line() -> None:
    apart = [Box(100, 60, 10), Pos(0, 0, 50) * Box(100, 60, 10)]
    for ask in (cad.advise_weldment, cad.plan_touches):
        with pytest.raises(GeometryError, match="the part has no seam to advise for; `wpcal seams` lists"):
            ask(apart, bodies=cad.BodiesOptions())
