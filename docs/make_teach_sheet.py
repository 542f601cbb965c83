"""Draw docs/images/teach-sheet.png: the teach sheet of the T-joint, as the how-to page shows it."""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

from cad.sheet import SheetOptions, make_sheet
from cad.sheet.paper import A4

ROOT = Path(__file__).parents[1]
COLOURS = 16
"""Colours of the picture: enough for black, red and blue lines with soft edges."""


def main() -> None:
    sheet = make_sheet(ROOT / "fixtures" / "tee" / "tee.step", options=SheetOptions(".png", A4))
    picture = Image.open(io.BytesIO(sheet.data)).convert("RGB").quantize(COLOURS)
    picture.save(ROOT / "docs" / "images" / "teach-sheet.png", optimize=True)


main()
