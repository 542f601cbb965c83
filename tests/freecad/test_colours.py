"""The workbench shows errors in the colours of the pages."""

import importlib.util
import json
import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
HALF_STEP = 0.5 / 255  #: The pages round to whole numbers from 0 to 255.


@pytest.fixture(scope="module")
def colours() -> ModuleType:
    path = ROOT / "cad/freecad/freecad/wpcal_wb/view/colours.py"
    spec = importlib.util.spec_from_file_location("workbench_colours", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_scale_is_that_of_the_pages(colours: ModuleType) -> None:
    source = (ROOT / "wpcal/pages/source/src/colours.js").read_text(encoding="utf-8")
    stops = re.search(r"STOPS = (\[.*?\]);", source, re.DOTALL)
    beyond = re.search(r'BEYOND = "#(\w{6})"', source)
    assert stops is not None
    assert beyond is not None
    listed = json.loads(re.sub(r",(\s*\])", r"\1", stops[1]))
    assert listed == [[share, list(colour)] for share, colour in colours.STOPS]
    assert bytes.fromhex(beyond[1]) == bytes(colours.BEYOND)


def test_errors_on_above_and_beside_the_scale(colours: ModuleType) -> None:
    for share, colour in colours.STOPS:
        assert colours.colour_of(share) == pytest.approx([value / 255 for value in colour], abs=HALF_STEP)
    between = colours.colour_of(0.15)
    assert between == pytest.approx([40 / 255, 144.5 / 255, 130.5 / 255], abs=HALF_STEP)
    assert colours.colour_of(1.01) == colours.unit(colours.BEYOND)
    assert colours.colour_of(None) == colours.colour_of(float("nan")) == colours.unit(colours.UNKNOWN)
