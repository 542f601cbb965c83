"""The limit on skipped tests notices a new reason and a larger number."""

from tests.lint.skips import MOST_SKIPS, unexpected_skips


def test_allowed_skips_pass_and_others_are_listed():
    reason, most = next(iter(MOST_SKIPS.items()))
    assert unexpected_skips([reason] * most) == []
    assert unexpected_skips([reason] * (most + 1)) == [f"{most + 1} tests skipped, {most} allowed: {reason}"]
    assert unexpected_skips(["chromium is not here"]) == ["1 tests skipped, 0 allowed: chromium is not here"]
