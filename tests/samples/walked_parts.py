"""The parts with which a newcomer is walked: three of our own, and three public ones."""

from pathlib import Path

import pytest

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


def make_hopper(path: Path) -> None:
    """Write a plate with two holes, an upright, a sloped rib and a pipe, as a newcomer makes them: like no sample."""
    import build123d as b  # takes long

    low = (b.Align.MIN, b.Align.MIN, b.Align.MIN)
    with b.BuildPart() as base:
        b.Box(220, 140, 12, align=low)
        with b.Locations((25, 25, 12), (195, 115, 12)):
            b.Hole(7)
    with b.BuildPart() as upright, b.Locations((60, 60, 12)):
        b.Box(130, 10, 110, align=low)
    with b.BuildPart() as rib:
        with b.BuildSketch(b.Plane.YZ.offset(115)):
            with b.BuildLine():
                b.Polyline((70, 12), (125, 12), (70, 80), (70, 12))
            b.make_face()
        b.extrude(amount=8)
    with b.BuildPart() as pipe, b.Locations((150, 25, 12)):
        b.Cylinder(18, 60, align=(b.Align.CENTER, b.Align.CENTER, b.Align.MIN))
    members = {"base": base, "upright": upright, "rib": rib, "pipe": pipe}
    for name, member in members.items():
        member.part.label = name
    whole = b.Compound(label="hopper", children=[member.part for member in members.values()])
    b.export_step(whole, str(path), timestamp="2026-01-01T00:00:00")  # the same file at each call


def put_part(part: str, path: Path) -> None:
    """Write a part as a STEP file, or skip the test if it is not here."""
    source = PARTS[part]
    if source is None:
        make_hopper(path)
    elif source.is_file():
        path.write_bytes(source.read_bytes())
    else:
        pytest.skip("the shared parts are not beside the project")
