"""Move the geometry of a STEP file in its text, without a new assembly level.

Single parts: every 3-D point p becomes R p + t, and every direction d becomes R d. Then every shape S becomes T S. Two
placements that together move a shape by A₂ A₁⁻¹ become T A₂ A₁⁻¹ T⁻¹, which moves the moved shape in the same way.
Points with two coordinates (curves in the parameters of a face) stay.

Assemblies: the parts keep their coordinates. The placements of the topmost assembly's components become T A₂.
"""

import re

import numpy as np

from cad.step.append import EntityWriter, placement_of, span_of, spliced, with_entities
from cad.step.part21 import Part21File, index_part21
from cad.step.part21_values import Instance, Ref, format_real
from cad.step.products import Component, Root, components_of, find_roots, unit_of_context
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform

NOT_BAKEABLE = (
    "COORDINATES_LIST",
    "CARTESIAN_TRANSFORMATION_OPERATOR_3D",
    "APLL_POINT",
    "APLL_POINT_WITH_SURFACE",
    "CYLINDRICAL_POINT",
    "SPHERICAL_POINT",
    "POLAR_POINT",
)
"""Entities with coordinates in another form. A file with one of them is not moved in place."""

_VECTOR = re.compile(rb"#[0-9]+\s*=\s*(CARTESIAN_POINT|DIRECTION)\s*\(\s*'(?:[^']|'')*'\s*,\s*\(([^()]*)\)\s*\)\s*;")


def bake_text(file: Part21File, T_base_part: RigidTransform) -> bytes:
    """Return the text of a STEP file with its geometry moved.

    Returns bytes. The text. Moved numbers are written with all their digits.

    Raises `FormatError` when the file holds coordinates in a form of `NOT_BAKEABLE`, its contexts have different units,
    or its roots are both assemblies and parts.
    """
    roots = find_roots(file)
    components = {root: components_of(file, root) for root in roots}
    if roots and all(components.values()):
        return _with_moved_components(file, T_base_part, components)
    if not roots or any(components.values()):
        raise FormatError("its geometry cannot be moved in place: parts beside an assembly", path=file.name)
    for keyword in NOT_BAKEABLE:
        if next(file.instances(keyword), None) is not None:
            raise FormatError(f"its geometry cannot be moved in place: it holds {keyword}", path=file.name)
    unit_mm = _one_unit_mm(file)
    completed = _with_explicit_directions(file)
    moved = index_part21(_moved_vectors(completed, T_base_part, unit_mm), name=file.name)
    return _with_root_axes_back(completed, moved, T_base_part)


def _with_moved_components(
    file: Part21File, T_base_part: RigidTransform, components: dict[Root, tuple[Component, ...]]
) -> bytes:
    """Give the components of every root new placements T A₂, listed in the root's representation."""
    writer = EntityWriter(int(file.ids[-1]) + 1)
    changes = []
    for root, parts in components.items():
        new = []
        for part in {part.transformation: part for part in parts}.values():
            T_part_axis = placement_of(file, part.placement, root.unit_mm)
            if T_part_axis is None:
                raise FormatError(f"the placement #{part.placement} is not complete", path=file.name)
            new.append(writer.add_placement(T_base_part @ T_part_axis, unit_mm=root.unit_mm))
            changes.append(_argument_changed(file, part.transformation, part.side, new[-1]))
        changes.append(_items_added(file, root.representation, new))
    return spliced(with_entities(file, writer), sorted(changes))


def _argument_changed(file: Part21File, transformation: int, side: int, new: str) -> tuple[int, int, bytes]:
    """Change one of the two placements, the last two references, of an ``ITEM_DEFINED_TRANSFORMATION``."""
    start, end = span_of(file, transformation)
    references = list(re.finditer(rb"#[0-9]+", file.clean[start:end]))[-2:]
    old = references[side]
    return start + old.start(), start + old.end(), new.encode("ascii")


def _items_added(file: Part21File, representation: int, new: list[str]) -> tuple[int, int, bytes]:
    """Add items to the list of a representation. The list ends at the last but one closing bracket."""
    start, end = span_of(file, representation)
    last = file.clean.rfind(b")", start, file.clean.rfind(b",", start, end))
    return last, last, ("," + ",".join(new)).encode("ascii")


def _one_unit_mm(file: Part21File) -> float:
    """Length unit that all contexts agree on, mm."""
    units = {
        unit_of_context(file, context.id)
        for context in file.instances("GLOBAL_UNIT_ASSIGNED_CONTEXT")
        if context.record("GEOMETRIC_REPRESENTATION_CONTEXT") is not None
    }
    if len(units) != 1:
        what = f"its contexts are in {len(units)} different length units"
        raise FormatError(f"its geometry cannot be moved in place: {what}", path=file.name)
    return units.pop()


def _with_explicit_directions(file: Part21File) -> Part21File:
    """Write out the default directions of placements, because a default does not rotate with the part."""
    writer = EntityWriter(int(file.ids[-1]) + 1)
    changes: list[tuple[int, int, bytes]] = []
    for keyword in ("AXIS2_PLACEMENT_3D", "AXIS1_PLACEMENT"):
        for instance in file.instances(keyword):
            arguments = instance.records[0].arguments
            if len(instance.records) == 1 and None in arguments[2:]:
                at = int(np.searchsorted(file.ids, instance.id))
                change = _explicit(writer, file, instance)
                changes.append((int(file.starts[at]), int(file.ends[at]) + 1, change))
    if not changes:
        return file
    return index_part21(spliced(with_entities(file, writer), sorted(changes)), name=file.name)


def _with_root_axes_back(file: Part21File, moved: Part21File, T_base_part: RigidTransform) -> bytes:
    """Correct the placement that the representation of each root lists.

    The kernel places a root by the first placement A that its representation lists, so it read A S. With everything
    moved it would read T A T S instead of T A S. Therefore the list gets X = T A T⁻¹ in place of T A: X T S = T A S.
    """
    T, T_inverse = T_base_part.matrix, T_base_part.inverse().matrix
    writer = EntityWriter(int(moved.ids[-1]) + 1)
    changes = []
    for root in find_roots(file):
        A = None if root.axis is None else placement_of(file, root.axis, root.unit_mm)
        if A is None:
            continue
        X = RigidTransform.from_matrix(T @ A.matrix @ T_inverse, target="base", source="axis")
        new = writer.add_placement(X, unit_mm=root.unit_mm)
        start, end = span_of(moved, root.representation)
        text = re.sub(f"#{root.axis}\\b".encode("ascii"), new.encode("ascii"), moved.text[start:end], count=1)
        changes.append((start, end, text))
    return spliced(with_entities(moved, writer), sorted(changes))


def _explicit(writer: EntityWriter, file: Part21File, placement: Instance) -> bytes:
    """Text of a placement with its defaults written out (ISO 10303-42: build_axes, first_proj_axis)."""
    keyword, (_, location, *given) = placement.keyword, placement.records[0].arguments
    axis = _direction(file, given[0]) if isinstance(given[0], Ref) else np.array([0.0, 0.0, 1.0])
    directions = [_reference(writer, given[0], axis)]
    if keyword == "AXIS2_PLACEMENT_3D":
        seed = np.array([0.0, 1.0, 0.0] if np.allclose(np.abs(axis), (1, 0, 0), rtol=0, atol=1e-9) else [1.0, 0.0, 0.0])
        directions.append(_reference(writer, given[1], seed - (seed @ axis) * axis))
    if not isinstance(location, Ref):
        raise FormatError(f"the placement #{placement.id} has no location", path=file.name)
    return f"#{placement.id}={keyword}('',#{int(location)},{','.join(directions)});".encode("ascii")


def _reference(writer: EntityWriter, given: object, default: FloatArray) -> str:
    return f"#{int(given)}" if isinstance(given, Ref) else writer.add_vector("DIRECTION", default)


def _direction(file: Part21File, reference: Ref) -> FloatArray:
    instance = file.instance(reference)
    ratios = instance.records[0].arguments[1] if instance is not None else ()
    if not isinstance(ratios, tuple) or len(ratios) != 3:
        raise FormatError(f"the direction #{int(reference)} does not have three ratios", path=file.name)
    vector = np.array(ratios, dtype=np.float64)
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float64)


def _moved_vectors(file: Part21File, T_base_part: RigidTransform, unit_mm: float) -> bytes:
    """Replace the coordinates of all 3-D points and directions."""
    matches = list(_VECTOR.finditer(file.clean))
    begins = np.array([match.start() for match in matches], dtype=np.int64)
    is_instance = np.isin(begins, file.starts)  # a match inside a string does not begin an instance
    kept = [m for m, real in zip(matches, is_instance, strict=True) if real and m.group(2).count(b",") == 2]
    if not kept:
        return file.text
    try:
        numbers = np.array(b",".join(m.group(2) for m in kept).split(b",")).astype(np.float64).reshape(-1, 3)
    except ValueError:
        raise FormatError("a point has coordinates that are not numbers", path=file.name) from None
    is_point = np.array([m.group(1) == b"CARTESIAN_POINT" for m in kept])
    moved = T_base_part.rotate(numbers) + np.where(is_point[:, None], T_base_part.t_mm / unit_mm, 0.0)
    texts = [",".join(map(format_real, row)).encode("ascii") for row in moved.tolist()]
    return spliced(file.text, [(*m.span(2), text) for m, text in zip(kept, texts, strict=True)])
