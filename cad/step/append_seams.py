"""Append seams to the text of a STEP file, as named, coloured edges of a product ``wpcal seams``.

Each seam is one product with one ``EDGE_CURVE`` over a ``POLYLINE`` in an edge-based wireframe model. It has the seam's
name, a colour and the layer ``wpcal seams``, so that another CAD system can find it by any of the three. The edge has
the name too, but the kernel does not read the names of wireframe edges. Therefore each seam is a product.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cad.step.append import Assembly, EntityWriter, add_component, add_product
from cad.step.part21 import Part21File
from cad.step.part21_values import encode_string, format_real
from wpcal.brep.mesh import Rgb
from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

SEAMS_NAME = "wpcal seams"  #: Name of the product and of the layer.

SAME_POINT_MM = 1e-6
"""Points closer than this are one vertex, as in a closed seam. It is ten times the kernel's tolerance of 1e-7 mm."""

LINE_WIDTH_MM = 0.7  #: Width of the drawn line: the thick line of ISO 128 on a sheet of this size.


@dataclass(frozen=True, slots=True, eq=False)
class SeamCurve:
    """A seam to be drawn into a STEP file. Raises `InputError` when there are fewer than two distinct points."""

    name: str
    points_part: FloatArray  #: shape (m, 3). Polyline in `part`, mm. A closed seam ends at its first point.
    color_rgb: Rgb  #: As a file writes it (sRGB), in 0…1.

    def __post_init__(self) -> None:
        points = as_points(self.points_part, name=f"seam {self.name}")
        moves = np.linalg.norm(np.diff(points, axis=0), axis=1) > SAME_POINT_MM
        points = np.concatenate([points[:1], points[1:][moves]])
        if len(points) < 2:
            raise InputError(f"seam {self.name}: expected a polyline of at least two distinct points")
        object.__setattr__(self, "points_part", points)

    @property
    def is_closed(self) -> bool:
        """Whether it ends where it starts."""
        return bool(np.linalg.norm(self.points_part[0] - self.points_part[-1]) <= SAME_POINT_MM)


def append_seams(
    writer: EntityWriter, file: Part21File, assembly: Assembly, T_base_part: RigidTransform, seams: Sequence[SeamCurve]
) -> None:
    """Add the product ``wpcal seams`` to an assembly, with one product of one edge per seam."""
    definition, shape = add_product(writer, file, assembly.root, SEAMS_NAME)
    origin = writer.add_placement(RigidTransform.identity(target="base", source="base"), unit_mm=1.0)
    representation = writer.add(f"SHAPE_REPRESENTATION('{SEAMS_NAME}',({origin}),#{assembly.root.context})")
    writer.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
    add_component(
        writer, assembly, definition, representation,
        child=origin, moved=assembly.origin, name=SEAMS_NAME, number=len(assembly.names),
    )  # fmt: skip
    group = Assembly(definition, representation, origin, assembly.root, (SEAMS_NAME,))
    first = len(assembly.names) + 1
    edges = [
        _add_seam(writer, file, group, T_base_part, seam, number=number)
        for number, seam in enumerate(seams, start=first)
    ]
    _add_styles(writer, seams, edges, assembly.root.context)
    writer.add(f"PRESENTATION_LAYER_ASSIGNMENT('{SEAMS_NAME}','',({','.join(edges)}))")


def _add_seam(
    writer: EntityWriter,
    file: Part21File,
    group: Assembly,
    T_base_part: RigidTransform,
    seam: SeamCurve,
    *,
    number: int,
) -> str:
    """Add one seam as a product of the group and return its edge."""
    definition, shape = add_product(writer, file, group.root, seam.name)
    edge = _add_edge(writer, seam, T_base_part, group.unit_mm)
    name = encode_string(seam.name).decode("ascii")
    edge_set = writer.add(f"CONNECTED_EDGE_SET({name},({edge}))")
    model = writer.add(f"EDGE_BASED_WIREFRAME_MODEL({name},({edge_set}))")
    origin = writer.add_placement(RigidTransform.identity(target="base", source="base"), unit_mm=1.0)
    representation = writer.add(
        f"EDGE_BASED_WIREFRAME_SHAPE_REPRESENTATION({name},({origin},{model}),#{group.root.context})"
    )
    writer.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
    add_component(
        writer, group, definition, representation, child=origin, moved=group.origin, name=seam.name, number=number
    )
    return edge


def _add_edge(writer: EntityWriter, seam: SeamCurve, T_base_part: RigidTransform, unit_mm: float) -> str:
    points = T_base_part.apply(seam.points_part) / unit_mm
    references = [writer.add_vector("CARTESIAN_POINT", point) for point in points[:-1]]
    references.append(references[0] if seam.is_closed else writer.add_vector("CARTESIAN_POINT", points[-1]))
    curve = writer.add(f"POLYLINE('',({','.join(references)}))")
    first = writer.add(f"VERTEX_POINT('',{references[0]})")
    last = first if seam.is_closed else writer.add(f"VERTEX_POINT('',{references[-1]})")
    name = encode_string(seam.name).decode("ascii")
    return writer.add(f"EDGE_CURVE({name},{first},{last},{curve},.T.)")


def _add_styles(writer: EntityWriter, seams: Sequence[SeamCurve], edges: list[str], context: int) -> None:
    """Give every edge the colour of its seam."""
    font = writer.add("DRAUGHTING_PRE_DEFINED_CURVE_FONT('continuous')")
    items = []
    for seam, edge in zip(seams, edges, strict=True):
        color = writer.add(f"COLOUR_RGB('',{','.join(format_real(v) for v in seam.color_rgb)})")
        width = f"POSITIVE_LENGTH_MEASURE({format_real(LINE_WIDTH_MM)})"
        style = writer.add(f"CURVE_STYLE('',{font},{width},{color})")
        assignment = writer.add(f"PRESENTATION_STYLE_ASSIGNMENT(({style}))")
        items.append(writer.add(f"STYLED_ITEM('color',({assignment}),{edge})"))
    listed = ",".join(items)
    writer.add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({listed}),#{context})")
