"""A part that no sample of wpcal is like, made as a newcomer makes his."""

from __future__ import annotations

from pathlib import Path


def make_hopper(path: Path) -> None:
    """A plate with two holes, an upright, a sloped rib and a pipe: no sample of wpcal."""
    from build123d import (
        Align,
        BuildLine,
        BuildPart,
        BuildSketch,
        Compound,
        Hole,
        Locations,
        Plane,
        Polyline,
        export_step,
        extrude,
        make_face,
    )
    from build123d import Box as Block
    from build123d import Cylinder as Rod

    low = (Align.MIN, Align.MIN, Align.MIN)
    with BuildPart() as base:
        Block(220, 140, 12, align=low)
        with Locations((25, 25, 12), (195, 115, 12)):
            Hole(7)
    with BuildPart() as upright, Locations((60, 60, 12)):
        Block(130, 10, 110, align=low)
    with BuildPart() as rib:
        with BuildSketch(Plane.YZ.offset(115)):
            with BuildLine():
                Polyline((70, 12), (125, 12), (70, 80), (70, 12))
            make_face()
        extrude(amount=8)
    with BuildPart() as pipe, Locations((150, 25, 12)):
        Rod(18, 60, align=(Align.CENTER, Align.CENTER, Align.MIN))
    members = {"base": base, "upright": upright, "rib": rib, "pipe": pipe}
    for name, member in members.items():
        member.part.label = name
    whole = Compound(label="hopper", children=[member.part for member in members.values()])
    export_step(whole, str(path), timestamp="2026-01-01T00:00:00")  # the same file at each call
