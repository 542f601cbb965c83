"""Names of seams as they are typed: single ones, ranges, and names that look like a range."""

import pytest

from wpcal.core.errors import InputError
from wpcal.seam.names import seams_named, split_names

KNOWN = ("W1", "W2", "W5", "W6a", "W6b", "W7", "W10", "rib-2", "Rib", "rib")


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("W2,W1", ["W2", "W1"]),
        ("W5-W7", ["W5", "W6a", "W6b", "W7"]),
        ("w5 - 7", ["W5", "W6a", "W6b", "W7"]),
        ("W1-W10, W2", ["W1", "W2", "W5", "W6a", "W6b", "W7", "W10"]),
        ("rib-2", ["rib-2"]),
        ("rib,RIB-2", ["rib", "rib-2"]),
        ("W6-W6", ["W6a", "W6b"]),
        ("", []),
    ],
)
def test_names_and_ranges(typed: str, meant: list[str]) -> None:
    assert list(seams_named(split_names(typed), KNOWN)) == meant


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        ("W9", "unknown seam W9; there are W1, W2"),
        ("W1-W9", "unknown seam W1-W9"),
        ("W7-W5", "W7-W5: the range runs backwards"),
        ("W6", "unknown seam W6; .*near: W6b, W6a"),
        ("RIB", "unknown seam RIB"),
        ("V1-V2", "unknown seam V1-V2"),
    ],
)
def test_what_is_no_seam_is_told(typed: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        seams_named(split_names(typed), KNOWN)
