"""Solids that are none: an open surface, and a face turned inside out."""

from typing import Any

import pytest

from cad.kernel.topology import compound
from cad.samples.parts import box
from cad.step.solids import leaf_shapes


def solid_of(faces: list[Any]) -> Any:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    builder, shell, solid = BRep_Builder(), TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    builder.MakeSolid(solid)
    for face in faces:
        builder.Add(shell, face)
    builder.Add(solid, shell)
    return solid


def faces() -> list[Any]:
    from cad.kernel.topology import FACE, sub_shape_uses

    return [face for face, _ in sub_shape_uses(box(30, 20, 10, (0, 0, 0)), FACE)]


@pytest.mark.parametrize(
    ("solid", "codes"),
    [
        (solid_of(faces()), []),
        (solid_of(faces()[1:]), ["invalid-shape"]),
        (solid_of([faces()[0].Reversed(), *faces()[1:]]), ["invalid-shape"]),
    ],
    ids=["box", "open", "one face turned"],
)
def test_what_is_wrong_with_a_solid(solid: Any, codes: list[str]) -> None:
    found = leaf_shapes("plate", compound([solid]))
    assert [issue.code for issue in found.issues] == codes
