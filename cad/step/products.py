"""The products of a STEP file, read from its text alone: roots, components, contexts and units."""

from dataclasses import dataclass

from cad.step.part21 import Part21File
from cad.step.part21_values import Enumeration, Instance, Ref, StepRecord, Value
from wpcal.core.errors import FormatError

SI_PREFIX_METRES = {
    "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3, "HECTO": 1e2, "DECA": 1e1,
    "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9, "PICO": 1e-12,
    "FEMTO": 1e-15, "ATTO": 1e-18,
}  # fmt: skip
"""SI prefixes of ISO 10303-41."""

UNIT_NAMES = {0.001: "um", 1.0: "mm", 10.0: "cm", 1000.0: "m", 25.4: "inch", 304.8: "ft"}
"""Names of units by their length in mm, as people write them."""

UNIT_RTOL = 1e-6
"""Relative. Files write the inch with five digits or more, and no two units of the table are this close."""


@dataclass(frozen=True, slots=True)
class Root:
    """A product with its shape. It is a root if it is not a component of another product."""

    definition: int  #: Its ``PRODUCT_DEFINITION``.
    representation: int  #: The ``SHAPE_REPRESENTATION`` (or a subtype) of its shape.
    context: int  #: The representation's context, which carries the units.
    axis: int | None  #: The first ``AXIS2_PLACEMENT_3D`` that the representation lists.
    unit_mm: float  #: Length unit of the context, mm.


def find_roots(file: Part21File) -> tuple[Root, ...]:
    """Products with a shape that are not components of another product, in the order of their numbers.

    Returns tuple of Root. Empty when the file has no product structure that leads to a shape.
    Raises `FormatError` when an instance on the way is not a Part 21 instance.
    """
    children = {
        child
        for usage in file.instances("NEXT_ASSEMBLY_USAGE_OCCURRENCE")
        if isinstance(child := argument(record_of(usage, "NEXT_ASSEMBLY_USAGE_OCCURRENCE"), 4), Ref)
    }
    return tuple(product for product in find_products(file) if product.definition not in children)


def find_products(file: Part21File) -> tuple[Root, ...]:
    """Products with a shape, roots and components, in the order of their numbers; errors as in `find_roots`."""
    shapes: dict[int, list[Root]] = {}
    for link in file.instances("SHAPE_DEFINITION_REPRESENTATION"):
        product = _product_of(file, link)
        if product is not None:
            shapes.setdefault(product.definition, []).append(product)
    # A definition may have several representations. An assembly needs one with a placement.
    return tuple(next((r for r in found if r.axis is not None), found[0]) for _, found in sorted(shapes.items()))


def _product_of(file: Part21File, link: Instance) -> Root | None:
    record = record_of(link, "SHAPE_DEFINITION_REPRESENTATION")
    definition = argument(record_of(follow(file, argument(record, 0)), "PRODUCT_DEFINITION_SHAPE"), 2)
    if not isinstance(definition, Ref):
        return None
    target = file.instance(definition)
    if target is None or target.record("NEXT_ASSEMBLY_USAGE_OCCURRENCE") is not None:
        return None  # the shape of one use of a product, not of the product
    representation = follow(file, argument(record, 1))
    context, items = (None, ()) if representation is None else context_and_items(representation)
    if representation is None or context is None:
        return None
    placements = (item for item in items if _is(file, item, "AXIS2_PLACEMENT_3D"))
    return Root(
        int(definition), representation.id, int(context), next(placements, None), unit_of_context(file, context)
    )


def context_and_items(representation: Instance) -> tuple[Ref | None, tuple[Ref, ...]]:
    """Context and items of a representation: ``(name, items, context)`` in a simple record or in ``REPRESENTATION``."""
    record = representation.record("REPRESENTATION") or representation.records[0]
    items, context = argument(record, 1), argument(record, 2)
    if not isinstance(context, Ref) or not isinstance(items, tuple):
        return None, ()
    return context, tuple(item for item in items if isinstance(item, Ref))


@dataclass(frozen=True, slots=True)
class Component:
    """How a root places one of its components."""

    transformation: int  #: The ``ITEM_DEFINED_TRANSFORMATION``.
    side: int  #: Which of its two placements is the root's: 0 or 1.
    placement: int  #: That placement.


def components_of(file: Part21File, root: Root) -> tuple[Component, ...]:
    """Placements of a root's components; empty for a single part.

    Raises `FormatError` when a component is not placed by an ``ITEM_DEFINED_TRANSFORMATION``, or the root also has a
    shape of its own.
    """
    usages = {
        usage.id
        for usage in file.instances("NEXT_ASSEMBLY_USAGE_OCCURRENCE")
        if argument(record_of(usage, "NEXT_ASSEMBLY_USAGE_OCCURRENCE"), 3) == root.definition
    }
    if not usages:
        return ()
    found = []
    for link in file.instances("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
        record = record_of(link, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")
        usage = argument(record_of(follow(file, argument(record, 1)), "PRODUCT_DEFINITION_SHAPE"), 2)
        if usage in usages:
            found.append(_component(file, root, follow(file, argument(record, 0))))
    placed = [component for component in found if component is not None]
    representation = file.instance(root.representation)
    items = () if representation is None else context_and_items(representation)[1]
    if len(placed) != len(usages) or not all(_is(file, item, "AXIS2_PLACEMENT_3D") for item in items):
        raise FormatError(f"the components of #{root.definition} are not all placed by transformations", path=file.name)
    return tuple(placed)


def _component(file: Part21File, root: Root, relation: Instance | None) -> Component | None:
    if relation is None:
        return None
    ends = record_of(relation, "REPRESENTATION_RELATIONSHIP")
    number = argument(record_of(relation, "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"), 0)
    transformation = record_of(follow(file, number), "ITEM_DEFINED_TRANSFORMATION")
    for side in (1, 0):
        placement = argument(transformation, 2 + side)
        is_root = argument(ends, 2 + side) == root.representation
        if is_root and isinstance(placement, Ref) and isinstance(number, Ref):
            return Component(int(number), side, int(placement))
    return None


def unit_of_context(file: Part21File, context: int) -> float:
    """Length unit of a representation context, mm; 1 when the context names none (the kernel assumes the same)."""
    instance = file.instance(context)
    record = None if instance is None else instance.record("GLOBAL_UNIT_ASSIGNED_CONTEXT")
    units = argument(record, 0) if record is not None else ()
    for unit in units if isinstance(units, tuple) else ():
        target = follow(file, unit)
        if target is not None and target.record("LENGTH_UNIT") is not None:
            return _unit_mm(file, target, depth=0)
    return 1.0


MAX_UNIT_DEPTH = 8
"""A unit can be based on a unit. No file seen goes past two steps; a circle of definitions ends here."""


def _unit_mm(file: Part21File, unit: Instance, *, depth: int) -> float:
    si = unit.record("SI_UNIT")
    if si is not None:
        prefix = argument(si, 0)
        return 1000.0 * (SI_PREFIX_METRES.get(prefix, 1.0) if isinstance(prefix, Enumeration) else 1.0)
    measure = follow(file, argument(unit.record("CONVERSION_BASED_UNIT"), 1))
    value, base = _measure(measure)
    base_unit = follow(file, base)
    if value is None or base_unit is None or depth >= MAX_UNIT_DEPTH:
        raise FormatError(f"the length unit #{unit.id} cannot be followed", path=file.name)
    return value * _unit_mm(file, base_unit, depth=depth + 1)


def _measure(measure: Instance | None) -> tuple[float | None, Value]:
    """Value and unit of a ``LENGTH_MEASURE_WITH_UNIT``, simple or complex."""
    for record in () if measure is None else measure.records:
        value, unit = argument(record, 0), argument(record, 1)
        number = argument(value, 0) if isinstance(value, StepRecord) else value
        if isinstance(unit, Ref) and isinstance(number, int | float) and number > 0:
            return float(number), unit
    return None, None


def unit_name(unit_mm: float) -> str:
    """Name of a length unit, such as ``inch``; a unit without a name is called by its length, such as ``2.5 mm``."""
    for length, name in UNIT_NAMES.items():
        if abs(unit_mm - length) <= UNIT_RTOL * length:
            return name
    return f"{unit_mm:g} mm"


def axis_placement(
    file: Part21File, number: int
) -> tuple[tuple[float, ...], tuple[float, ...] | None, tuple[float, ...] | None]:
    """Location (in the file's unit), axis and reference direction of an ``AXIS2_PLACEMENT_3D``; None where not given.

    Raises `FormatError` when the placement does not lead to three coordinates.
    """
    record = record_of(file.instance(number), "AXIS2_PLACEMENT_3D")
    location = _coordinates(file, argument(record, 1))
    if location is None:
        raise FormatError(f"the placement #{number} has no location", path=file.name)
    return location, _coordinates(file, argument(record, 2)), _coordinates(file, argument(record, 3))


def _coordinates(file: Part21File, value: Value) -> tuple[float, ...] | None:
    target = follow(file, value)
    numbers = None if target is None else argument(target.records[0], 1)
    if not isinstance(numbers, tuple):
        return None
    found = tuple(float(v) for v in numbers if isinstance(v, int | float))
    return found if len(found) == 3 else None


def _is(file: Part21File, number: int, keyword: str) -> bool:
    instance = file.instance(number)
    return instance is not None and instance.record(keyword) is not None


def follow(file: Part21File, value: Value) -> Instance | None:
    """Return the instance that a value refers to; None if it refers to none."""
    return file.instance(value) if isinstance(value, Ref) else None


def record_of(instance: Instance | None, keyword: str) -> StepRecord | None:
    """Return the record of an instance with a keyword; None if it has none."""
    return None if instance is None else instance.record(keyword)


def argument(record: StepRecord | None, index: int) -> Value:
    """Return an argument of a record; None if there is none."""
    return record.arguments[index] if record is not None and index < len(record.arguments) else None
