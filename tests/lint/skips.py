"""How many tests may be skipped, and why, where every tool is there (`--assert-skips` of tests/conftest.py)."""

from collections import Counter

MOST_SKIPS = {
    "published controller files are not beside the repository": 11,
    "no disk can be mounted": 2,
    "the sample files of xMCF are not here": 2,
    "rapidchecker is not installed": 4,
    "WPCAL_KRL_PARSER does not name a folder with krlParser.py": 3,
    "CadQuery is not installed for this kernel": 1,
    "ocp_vscode is not installed": 1,
    "no client of others is installed": 4,
    "root writes into a folder that nobody may write to": 1,
}


def unexpected_skips(reasons: list[str]) -> list[str]:
    """Return one line per reason for which more tests were skipped than allowed."""
    return [
        f"{count} tests skipped, {MOST_SKIPS.get(reason, 0)} allowed: {reason}"
        for reason, count in sorted(Counter(reasons).items())
        if count > MOST_SKIPS.get(reason, 0)
    ]
