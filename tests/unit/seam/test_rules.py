"""The table of the rules: the docs show it, and the thresholds sort it as they say."""

from pathlib import Path

import numpy as np
import pytest

from wpcal.seam.limits import Level
from wpcal.seam.rules import SCORES, SHARES, Rule, confidence_of
from wpcal.seam.seam import SeamSource

SEAMS_PAGE = Path(__file__).parents[3] / "docs" / "seams.md"
DOUBTS = ("TOO_SHORT", "NAMED_PART", "HOLE_RIM", "BOLTED", "LINED_UP", "NAMED_ABOVE", "FIXES_BOLTED")
KNOWN = (Rule.IN_MATERIAL, Rule.SAID_NOT, Rule.NOT_METAL_WRITTEN, Rule.FASTENER, Rule.NOT_REACHED, Rule.STANDARD_PART)


def test_the_page_of_seams_shows_the_table() -> None:
    assert "\n.. rules-of-seams::\n" in SEAMS_PAGE.read_text(encoding="utf-8")


def test_the_rules_are_listed_from_the_strongest_to_the_weakest_but_for_the_gap() -> None:
    factors = [rule.factor for rule in Rule if rule is not Rule.GAP]
    assert factors == sorted(factors)


@pytest.mark.parametrize("rule", DOUBTS)
def test_a_doubt_refuses_a_contact_by_default_and_not_if_generous(rule: str) -> None:
    confidence = confidence_of(SeamSource.CONTACT, [Rule[rule].found("")])
    assert Level.GENEROUS.value <= confidence < Level.USUAL.value


@pytest.mark.parametrize("rule", KNOWN)
def test_what_is_known_refuses_a_contact_at_every_level(rule: Rule) -> None:
    assert confidence_of(SeamSource.CONTACT, [rule.found("")]) < Level.GENEROUS.value


def test_strict_takes_what_nothing_speaks_against_but_no_bead() -> None:
    taken = {source for source in SeamSource if confidence_of(source, ()) >= Level.STRICT.value}
    assert taken == set(SeamSource) - {SeamSource.BEAD}


def test_a_higher_score_is_a_higher_confidence() -> None:
    assert (np.diff(SCORES) > 0).all()
    assert (np.diff(SHARES) > 0).all()
