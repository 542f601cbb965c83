"""The files and names that CONTRIBUTING.md points to exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROWS = [line for line in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines() if line.startswith("| ")]


@pytest.mark.parametrize("row", ROWS)
def test_the_places_exist_and_hold_the_names(row):
    words = re.findall(r"`([^`]+)`", row.split("|")[2])
    places = [ROOT / word.removesuffix("/<brand>") for word in words if "/" in word]
    assert all(place.exists() for place in places), row
    texts = [place.read_text(encoding="utf-8") for place in places if place.is_file()]
    names = [word for word in words if re.fullmatch(r"[A-Za-z_]+", word) and not (ROOT / word).exists()]
    assert all(any(name in text for text in texts) for name in names), row
