"""The table of the rules: what the docs show is what the code does, and the thresholds sort it as they say."""

from pathlib import Path

import pytest

from wpcal.seam.limits import Level
from wpcal.seam.rules import PRIOR, Rule, rules_table
from wpcal.seam.seam import SeamSource

SEAMS_PAGE = Path(__file__).parents[3] / "docs" / "seams.md"
DOUBTS = (
    Rule.TOO_SHORT,
    Rule.NAMED_PART,
    Rule.HOLE_RIM,
    Rule.BOLTED,
    Rule.LINED_UP,
    Rule.NAMED_ABOVE,
    Rule.FIXES_BOLTED,
)
KNOWN = (Rule.IN_MATERIAL, Rule.SAID_NOT, Rule.NOT_METAL_WRITTEN, Rule.FASTENER, Rule.NOT_REACHED, Rule.STANDARD_PART)


def test_the_page_of_seams_shows_the_table() -> None:
    assert rules_table() in SEAMS_PAGE.read_text(encoding="utf-8")


def test_the_rules_are_listed_from_the_strongest_to_the_weakest_but_for_the_gap() -> None:
    factors = [rule.factor for rule in Rule if rule is not Rule.GAP]
    assert factors == sorted(factors)


@pytest.mark.parametrize("rule", DOUBTS)
def test_a_doubt_refuses_a_contact_by_default_and_not_if_generous(rule: Rule) -> None:
    confidence = PRIOR[SeamSource.CONTACT] * rule.factor
    assert Level.GENEROUS.value <= confidence < Level.USUAL.value


@pytest.mark.parametrize("rule", KNOWN)
def test_what_is_known_refuses_a_contact_at_every_level(rule: Rule) -> None:
    assert PRIOR[SeamSource.CONTACT] * rule.factor < Level.GENEROUS.value


def test_strict_takes_what_nothing_speaks_against_but_no_bead() -> None:
    taken = {source for source, prior in PRIOR.items() if prior >= Level.STRICT.value}
    assert taken == set(PRIOR) - {SeamSource.BEAD}
