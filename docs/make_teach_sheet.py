"""Draw docs/images/teach-sheet.png and weld-list.png: the sheets of the T-joint, as the how-to page shows them.

The weld list needs the results of `wpcal demo -o out` and `wpcal welds out -o out/welds.json`.
"""

from __future__ import annotations

import io
from pathlib import Path

from PIL import Image

from cad.sheet import SheetOptions, make_sheet
from cad.sheet.paper import A4
from cad.sheet.welds import read_listed_welds

ROOT = Path(__file__).parents[1]
COLOURS = 16  #: Colours of the picture: enough for black, red and blue lines with soft edges.


def main() -> None:
    welds = read_listed_welds(ROOT / "out" / "welds.json")
    for name, options in (
        ("teach-sheet", SheetOptions(".png", A4)),
        ("weld-list", SheetOptions(".png", A4, welds=welds)),
    ):
        sheet = make_sheet(ROOT / "fixtures" / "tee" / "tee.step", options=options)
        picture = Image.open(io.BytesIO(sheet.data)).convert("RGB").quantize(COLOURS)
        picture.save(ROOT / "docs" / "images" / f"{name}.png", optimize=True)


main()
