"""What the products of a STEP file are made of: materials and densities, read from its text.

Four ways to write them are known. ``MATERIAL_DESIGNATION`` names the material of product definitions. A property named
material, or an attribute of that name, holds texts. A property named density, or a measure of that name, holds a
number. ``MAKE_FROM_USAGE_OPTION`` says that a product is made from another one, its material.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

from cad.step.part21 import Part21File
from cad.step.part21_values import Instance, Ref, StepRecord, Value
from cad.step.products import argument, follow
from cad.step.xcaf_tree import usable_name

MATERIAL = re.compile(r"material|werkstoff|mat[ée]riau|\bmatière\b|材料|材質|材质|материал", re.IGNORECASE)
"""Names of a property or an attribute that holds a material: English, Dutch, Spanish, Italian, Polish, German, French,
Chinese, Japanese, Russian."""
NOT_MATERIAL = re.compile(r"requirement|removal|condition|side|finish|thickness|id$", re.IGNORECASE)
"""What makes such a name say something else: the maximum material condition of a tolerance, for example."""
DENSITY = re.compile(r"densit|\bdichte\b|plotno|gęstość|密度|плотность", re.IGNORECASE)
MENTIONED = (b"werkstoff", b"materia", b"matiere", rb"mat\x\e9riau", b"densit", b"dichte", b"\\x2\\")
"""A file whose text has none of these names no material: it is not searched further."""
EMPTY = re.compile(
    r"\W*(none|unknown|default|generic|not specified|nicht festgelegt|undefined|user.?defined)?\W*", re.I
)
"""Texts that exporters write if no material was chosen."""
MOST_STEPS = 4  #: From a property to its product: shape, definition, formation, product.
KG_M3 = ((100.0, 25_000.0, 1.0), (0.05, 25.0, 1e3), (5e-8, 2.5e-5, 1e9), (5e-11, 2.5e-8, 1e12))
"""Least and largest number and the factor to kg/m³, for kg/m³, g/cm³, kg/mm³ and t/mm³. Real densities are from 50
(foam) to 23 000; so the number alone tells its unit, whatever unit the file names."""
POUND = re.compile(r"pound|lbm?\b|inch", re.IGNORECASE)
LB_IN3 = 27_679.9
"""kg/m³ of one pound per cubic inch: steel is 0.284, which is light wood in g/cm³. This unit has to be named."""


@dataclass(frozen=True, slots=True)
class ProductMaterial:
    """What a product is made of."""

    texts: tuple[str, ...] = ()  #: As written, in the order of the file; empty if the file does not say.
    density_kg_m3: float | None = None


def read_materials(file: Part21File) -> dict[str, ProductMaterial]:
    """Return the materials of the products of a file, by the product's name.

    Returns: Products about which the file says nothing are left out, and so are products of one name about which it
    says different things.
    """
    lowered = file.text.lower()
    if not any(word in lowered for word in MENTIONED):
        return {}
    texts: dict[int, list[str]] = defaultdict(list)
    densities: dict[int, float] = {}
    for product, text in _designated(file):
        texts[product].append(text)
    for product, found, density in _properties(file):
        texts[product] += found
        if density is not None:
            densities[product] = density
    for product, made_from in _made_from(file):
        texts[product] += [_text(argument(made_from.record("PRODUCT"), place)) for place in (0, 1)]
        if made_from.id in densities:
            densities.setdefault(product, densities[made_from.id])
    by_name: dict[str, set[ProductMaterial]] = defaultdict(set)
    for instance in file.instances("PRODUCT"):
        written = (text for text in texts.get(instance.id, ()) if not EMPTY.fullmatch(text))
        kept = tuple(dict.fromkeys(written))
        name = _product_name(instance)
        if name:
            by_name[name].add(ProductMaterial(kept, densities.get(instance.id)))
    return {name: one for name, (one, *others) in by_name.items() if not others and one != ProductMaterial()}


def _product_name(product: Instance) -> str:
    """Return the name under which the kernel knows a product: its name, or its identifier."""
    record = product.record("PRODUCT")
    texts = [usable_name(_text(argument(record, place))) for place in (1, 0)]
    return texts[0] or texts[1]


def _designated(file: Part21File) -> Iterator[tuple[int, str]]:
    for instance in file.instances("MATERIAL_DESIGNATION"):
        record = instance.record("MATERIAL_DESIGNATION")
        targets = argument(record, 1)
        for target in targets if isinstance(targets, tuple) else ():
            product = _product_of(file, target)
            if product is not None:
                yield product, _text(argument(record, 0))


def _made_from(file: Part21File) -> Iterator[tuple[int, Instance]]:
    """Yield products with the product that is their material."""
    for link in file.instances("MAKE_FROM_USAGE_OPTION"):
        record = link.record("MAKE_FROM_USAGE_OPTION")
        product, made_from = (_product_of(file, argument(record, place)) for place in (3, 4))
        source = None if made_from is None else file.instance(made_from)
        if product is not None and source is not None and _says_material(_text(argument(record, 0))):
            yield product, source


def _properties(file: Part21File) -> Iterator[tuple[int, list[str], float | None]]:
    """Yield for each property of a product the texts about its material and its density in kg/m³."""
    general = _general_names(file)
    for link in file.instances("PROPERTY_DEFINITION_REPRESENTATION"):
        record = link.record("PROPERTY_DEFINITION_REPRESENTATION")
        property_, representation = follow(file, argument(record, 0)), follow(file, argument(record, 1))
        if property_ is None or representation is None:
            continue
        head = property_.records[0]
        names = [*general.get(property_.id, ()), _text(argument(head, 0)), _text(argument(head, 1))]
        inner = representation.record("REPRESENTATION") or representation.records[0]
        names.append(_text(argument(inner, 0)))
        items = argument(inner, 1)
        found = [one for one in (follow(file, item) for item in _tuple(items)) if one is not None]
        texts = [text for item in found for text in _material_texts(names, item)]
        density = next((value for item in found for value in _densities(file, names, item)), None)
        if texts or density is not None:
            product = _product_of(file, argument(head, 2))
            if product is not None:
                yield product, texts, density


def _general_names(file: Part21File) -> dict[int, list[str]]:
    """Return the names of general properties, by number of the property that is derived from them."""
    names: dict[int, list[str]] = defaultdict(list)
    for link in file.instances("GENERAL_PROPERTY_ASSOCIATION"):
        record = link.record("GENERAL_PROPERTY_ASSOCIATION")
        base, derived = follow(file, argument(record, 2)), argument(record, 3)
        if base is not None and isinstance(derived, Ref):
            names[int(derived)] += [_text(argument(base.records[0], 0)), _text(argument(base.records[0], 1))]
    return names


def _material_texts(names: list[str], item: Instance) -> list[str]:
    record = item.record("DESCRIPTIVE_REPRESENTATION_ITEM")
    if record is None:
        return []
    name, value = _text(argument(record, 0)), _text(argument(record, 1))
    if _says_material(name):
        return [value]
    if any(_says_material(one) for one in names) and not any(DENSITY.search(one) for one in names):
        return [name, value]  # the kernel writes the material as the name of the item and its description as the value
    return []


def _says_material(name: str) -> bool:
    return MATERIAL.search(name) is not None and NOT_MATERIAL.search(name) is None


def _densities(file: Part21File, names: list[str], item: Instance) -> Iterator[float]:
    own = item.record("MEASURE_REPRESENTATION_ITEM")
    name = item.record("REPRESENTATION_ITEM")
    measure = item.record("MEASURE_WITH_UNIT")
    texts = [_text(argument(own, 0)), _text(argument(name, 0)), *names]
    if not any(DENSITY.search(text) for text in texts):
        return
    value, unit = (argument(measure, 0), argument(measure, 1)) if measure else (argument(own, 1), argument(own, 2))
    number = argument(value, 0) if isinstance(value, StepRecord) else value
    if isinstance(number, int | float) and number > 0:
        density = density_kg_m3(float(number), is_pound=_is_pound(file, unit, MOST_STEPS))
        if density is not None:
            yield density


def density_kg_m3(number: float, *, is_pound: bool = False) -> float | None:
    """Return a density in kg/m³; None if no unit makes it a density of a solid.

    >>> density_kg_m3(7.85), density_kg_m3(7850.0), density_kg_m3(7.85e-6), density_kg_m3(1e30)
    (7850.0, 7850.0, 7850.0, None)
    """
    if is_pound:
        return number * LB_IN3
    return next((round(number * factor, 6) for low, high, factor in KG_M3 if low <= number <= high), None)


def _is_pound(file: Part21File, value: Value, steps: int) -> bool:
    """Tell whether a unit, or one that it is made of, is named after the pound or the inch."""
    unit = follow(file, value)
    if unit is None or steps == 0:
        return False
    arguments = list(chain.from_iterable(record.arguments for record in unit.records))
    if any(isinstance(one, str) and POUND.search(one) for one in arguments):
        return True
    inner = [part for one in arguments for part in _tuple(one)] + arguments
    return any(_is_pound(file, one, steps - 1) for one in inner if isinstance(one, Ref))


_STEPS = {
    "PRODUCT_DEFINITION_SHAPE": 2, "SHAPE_ASPECT": 2, "NEXT_ASSEMBLY_USAGE_OCCURRENCE": 4, "PRODUCT_DEFINITION": 2,
    "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS": 2, "PRODUCT_DEFINITION_FORMATION": 2,
    "PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE": 2, "PROPERTY_DEFINITION": 2,
}  # fmt: skip
"""Which argument of an entity leads towards the product."""


def _product_of(file: Part21File, value: Value) -> int | None:
    """Return the number of the product to which a definition belongs."""
    for _ in range(MOST_STEPS + 1):
        instance = follow(file, value)
        if instance is None:
            return None
        if instance.record("PRODUCT") is not None:
            return instance.id
        place = _STEPS.get(instance.keyword)
        value = None if place is None else argument(instance.records[0], place)
    return None


def _text(value: Value) -> str:
    return usable_name(value) if isinstance(value, str) else ""


def _tuple(value: Value) -> tuple[Value, ...]:
    return value if isinstance(value, tuple) else ()
