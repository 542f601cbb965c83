"""Append colours to the text of a STEP file, in the order of its solids.

The kernel's own writer writes colours in the order of memory addresses, which differs from run to run. Without colours,
its text is the same in every run.
"""

from collections.abc import Sequence

from cad.step.append import EntityWriter, with_entities
from cad.step.part21 import Part21File, index_part21
from cad.step.part21_values import Instance, Ref, format_real
from wpcal.brep.mesh import Rgb
from wpcal.core.errors import FormatError


def with_solid_colors(text: bytes, colors: Sequence[Rgb | None], *, name: str) -> bytes:
    """Give every solid of a STEP file a colour. The same text with the styles at the end of its data.

    Raises `FormatError` when the numbers of solids and colours differ.
    """
    file = index_part21(text, name=name)
    solids = [_solid_and_context(file, item) for item in file.instances("ADVANCED_BREP_SHAPE_REPRESENTATION")]
    if len(solids) != len(colors):
        raise FormatError(f"expected a solid for each of {len(colors)} colours, found {len(solids)}", path=name)
    writer = EntityWriter(int(file.ids[-1]) + 1)
    styles = {color: _add_style(writer, color) for color in dict.fromkeys(colors) if color is not None}
    for (solid, context), color in zip(solids, colors, strict=True):
        if color is None:
            continue
        item = writer.add(f"STYLED_ITEM('color',({styles[color]}),#{solid})")
        writer.add(f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',({item}),#{context})")
    return with_entities(file, writer)


def _solid_and_context(file: Part21File, representation: Instance) -> tuple[int, int]:
    """Numbers of the one ``MANIFOLD_SOLID_BREP`` or ``BREP_WITH_VOIDS`` of a representation and of its context."""
    _, items, context = representation.records[0].arguments
    solids = [
        item
        for item in (items if isinstance(items, tuple) else ())
        if isinstance(item, Ref)
        and (found := file.instance(item)) is not None
        and found.keyword in {"MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS"}
    ]
    if len(solids) != 1 or not isinstance(context, Ref):
        raise FormatError(f"#{representation.id}: expected one solid, found {len(solids)}", path=file.name)
    return int(solids[0]), int(context)


def _add_style(writer: EntityWriter, color: Rgb) -> str:
    """Add a style that fills both sides of every face with a colour, and return its assignment (ISO 10303-46)."""
    colour = writer.add(f"COLOUR_RGB('',{','.join(format_real(v) for v in color)})")
    fill = writer.add(f"FILL_AREA_STYLE_COLOUR('',{colour})")
    filled = writer.add(f"FILL_AREA_STYLE('',({fill}))")
    area = writer.add(f"SURFACE_STYLE_FILL_AREA({filled})")
    side = writer.add(f"SURFACE_SIDE_STYLE('',({area}))")
    usage = writer.add(f"SURFACE_STYLE_USAGE(.BOTH.,{side})")
    return writer.add(f"PRESENTATION_STYLE_ASSIGNMENT(({usage}))")
