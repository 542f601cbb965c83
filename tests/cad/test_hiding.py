"""A loose solid beside a joint takes part of its weld: it is named, with what is reached without it."""

import json
from pathlib import Path
from unittest.mock import Mock

import pytest
from build123d import Align, Box, Compound, Cylinder, Pos, export_step

from tests.running import run_here
from wpcal.seam.judge import hiding

LOW = (Align.CENTER, Align.CENTER, Align.MIN)
NEAR_MM = 1.5

pytestmark = pytest.mark.usefixtures("kernel_here")


@pytest.fixture
def ring_beside_a_catch(tmp_path: Path) -> Path:
    """A pipe on a plate; a block hangs beside its foot and touches neither."""
    base = Box(300, 120, 10, align=(Align.CENTER, Align.CENTER, Align.MAX))
    pipe = Cylinder(40, 80, align=LOW) - Cylinder(35, 80, align=LOW)
    catch = Pos(0, 62, 30) * Box(60, 20, 50)
    base.label, pipe.label, catch.label = "base", "pipe", "catch"
    export_step(Compound(label="ring", children=[base, pipe, catch]), tmp_path / "ring.step")
    return tmp_path / "ring.step"


def test_a_loose_solid_in_the_way_is_named_with_what_is_gained(ring_beside_a_catch: Path) -> None:
    shown = run_here("seams", ring_beside_a_catch, "--json", "--no-cache")
    record = json.loads(shown.stdout)
    outer = [s for s in record["seams"] if s["length_mm"] < 100 or s["length_mm"] > 230 or not s["closed"]]
    lost = [seam for seam in outer if not seam["accepted"]]
    gained = [one for seam in lost for one in seam["hiding"]]
    assert {(one["solid"], one["is_loose"]) for one in gained} == {("catch", True)}
    assert sum(one["length_mm"] for one in gained) == pytest.approx(sum(s["length_mm"] for s in lost), abs=NEAR_MM)
    for seam in lost:
        assert "without catch, which touches nothing, the torch would reach" in " ".join(seam["against"])


def test_seams_of_one_length_are_asked_in_their_order_and_not_by_round_off(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, graph = list[str](), Mock(solid_names=("catch",))
    monkeypatch.setattr(hiding, "is_loose", Mock(return_value=False))
    monkeypatch.setattr(hiding, "feel_seams", lambda _graph, _trimmed, seams, _reach: asked.extend(seams) or ())
    seams = [Mock(length_mm=8.0 + 1e-13 * row, inside=(), blocked_by=("catch",), solids=()) for row in range(12)]
    with pytest.raises(ValueError, match="zip"):
        hiding.with_hiding(graph, Mock(), seams, Mock())
    assert asked == seams[: hiding.MOST_ASKED]


def test_the_table_says_it_once_for_all_pieces(ring_beside_a_catch: Path) -> None:
    shown = " ".join(run_here("seams", ring_beside_a_catch).stdout.split())
    assert "mm more (W2, W4, W5)" in shown
