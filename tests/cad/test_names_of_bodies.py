"""A body that a program named takes the name that a person gave to its product."""

from pathlib import Path

from build123d import Box, Compound, Pos, export_step

from cad.step.read import read_step


def named(label: str, x: float) -> Compound:
    solid = (Pos(x, 0, 0) * Box(10, 10, 10)).solid()
    solid.label = label
    return solid


def test_the_nearest_product_with_a_given_name_names_a_body(tmp_path: Path) -> None:
    rail = Compound(label="left rail", children=[named("Pad001", 0), named("Boss-Extrude2", 20), named("stop", 40)])
    frame = Compound(label="frame", children=[rail, named("Body7", 60), named("foot", 80)])
    export_step(frame, str(tmp_path / "frame.step"))
    names = [solid.name for solid in read_step(tmp_path / "frame.step").solids]
    assert names == ["left rail", "left rail#2", "stop", "Body7", "foot"]  # the name of the whole part names no body
