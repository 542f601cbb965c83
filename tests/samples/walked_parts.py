"""The parts with which a newcomer is walked: three of our own, and three public ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.samples.hopper import make_hopper

ROOT = Path(__file__).parents[2]
BLIND = ROOT.parent / "shared" / "blind"
PARTS = {
    "hopper": None,
    "afpm_boom_vane": BLIND / "afpm_boom_vane.step",
    "frame": ROOT / "fixtures" / "frame" / "frame.step",
    "saddle": ROOT / "fixtures" / "saddle" / "saddle.step",
    "iron_footer": BLIND / "iron_Footer_Type_U_L70.step",
    "bench": BLIND / "wb_bench.step",
}


def put_part(part: str, path: Path) -> None:
    """Write a part as a STEP file, or skip the test if it is not here."""
    source = PARTS[part]
    if source is None:
        make_hopper(path)
    elif source.is_file():
        path.write_bytes(source.read_bytes())
    else:
        pytest.skip("the shared parts are not beside the project")
