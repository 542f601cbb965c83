"""The uses of products in a STEP file, read from its text alone: where each is placed, and which solids it holds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from cad.step.append import placement_of
from cad.step.part21 import Part21File
from cad.step.part21_values import Instance, Ref
from cad.step.products import (
    Root,
    argument,
    axis_placement,
    context_and_items,
    find_products,
    find_roots,
    follow,
    record_of,
    unit_of_context,
)
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform

SOLIDS = frozenset({"MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP"})
"""Entities of which the kernel makes one solid each."""

SURFACES = frozenset({"SHELL_BASED_SURFACE_MODEL", "FACE_BASED_SURFACE_MODEL"})
"""Entities of which it makes faces that belong to no solid."""

MOST_LEVELS = 100  #: Of assemblies within assemblies. A product that contains itself ends here.


@dataclass(frozen=True, slots=True)
class Solid:
    """A solid of a product."""

    item: int
    name: str
    representation: int  #: Which lists it.


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """How one product is placed in another."""

    usage: int  #: The ``NEXT_ASSEMBLY_USAGE_OCCURRENCE``.
    name: str  #: Of the use.
    child: int  #: The ``PRODUCT_DEFINITION`` that is placed.
    #: `relation`, `transformation`: The relationship of the two representations, and its
    #: ``ITEM_DEFINED_TRANSFORMATION``.
    relation: int
    transformation: int
    side: int  #: Which end of both is the parent's: 0 or 1.
    child_representation: int
    child_axis: int
    parent_axis: int
    T_parent_axis: RigidTransform  #: The placement `parent_axis`, mm.
    T_parent_child: RigidTransform  #: Where the child is in the parent, mm.


@dataclass(frozen=True, slots=True, eq=False)
class Occurrence:
    """One use of a product."""

    product: Root
    link: Link | None  #: None: a root.
    T_root_product: RigidTransform  #: Where the product is in its root, mm.
    solids: tuple[Solid, ...]  #: Of a product without components, in the order of the file.
    has_faces: bool  #: Whether a product without components holds solids, or faces without one.
    below: tuple[Occurrence, ...]  #: Its components, in the order of the file.

    def all(self) -> Iterator[Occurrence]:
        """Yield this use and all below it, in the order of the file."""
        yield self
        for child in self.below:
            yield from child.all()


@dataclass(frozen=True, slots=True, eq=False)
class LeafUse:
    """One use of a product without components, as the kernel reads it."""

    solids: tuple[int, ...]  #: Numbers of its solids in the part.
    T_part_product: FloatArray  #: shape (4, 4). Where the product is in `part`, mm.


def find_occurrences(file: Part21File) -> tuple[Occurrence, ...]:
    """Uses of products in a STEP file: one tree for each root.

    Raises `FormatError` when the text does not say where each component is.
    """
    return _Tree(file).roots()


def placement_mm(file: Part21File, number: int, unit_mm: float) -> RigidTransform:
    """A placement of the file, mm; without directions it is not turned.

    Raises `FormatError` when it leaves only one direction to the reader's default.
    """
    found = placement_of(file, number, unit_mm)
    if found is not None:
        return found
    location, axis, reference = axis_placement(file, number)
    if axis is not None or reference is not None:
        raise FormatError(f"the placement #{number} is not complete", path=file.name)
    return RigidTransform(np.eye(3), np.array(location) * unit_mm, "part", "axis")


@dataclass(slots=True)
class _Tree:
    """The text, and what refers to what in it."""

    file: Part21File
    products: dict[int, Root] = field(default_factory=dict)
    related: dict[int, list[int]] = field(default_factory=lambda: defaultdict(list))
    links: dict[int, list[Link]] = field(default_factory=lambda: defaultdict(list))

    def __post_init__(self) -> None:
        self.products = {product.definition: product for product in find_products(self.file)}
        for relation in self.file.instances("SHAPE_REPRESENTATION_RELATIONSHIP"):
            if relation.record("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION") is None:
                one, other = _ends(relation)
                self.related[one].append(other)
                self.related[other].append(one)
        placed = self._relations()
        starts = dict(zip(self.file.ids.tolist(), self.file.starts.tolist(), strict=True))  # in the kernel's order
        for usage in sorted(self.file.instances("NEXT_ASSEMBLY_USAGE_OCCURRENCE"), key=lambda one: starts[one.id]):
            record = record_of(usage, "NEXT_ASSEMBLY_USAGE_OCCURRENCE")
            parent, name = argument(record, 3), argument(record, 1)
            link = self._link(usage, name if isinstance(name, str) else "", placed.get(usage.id))
            self.links[int(parent) if isinstance(parent, Ref) else -1].append(link)

    def roots(self) -> tuple[Occurrence, ...]:
        """Return the tree of every root."""
        unmoved = RigidTransform.identity(target="part", source="part")
        return tuple(self._occurrence(root, None, unmoved, 0) for root in find_roots(self.file))

    def _occurrence(self, product: Root, link: Link | None, T: RigidTransform, level: int) -> Occurrence:
        if level > MOST_LEVELS:
            raise FormatError(f"the product of #{product.definition} contains itself", path=self.file.name)
        below = tuple(
            self._occurrence(self.products[each.child], each, T @ each.T_parent_child, level + 1)
            for each in self.links.get(product.definition, [])
        )
        solids, has_faces = ((), False) if below else self._shapes(product)
        return Occurrence(product, link, T, solids, has_faces, below)

    def _relations(self) -> dict[int, Instance | None]:
        """Return the relationship of representations for every use."""
        found = {}
        for link in self.file.instances("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
            record = record_of(link, "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")
            shape = record_of(follow(self.file, argument(record, 1)), "PRODUCT_DEFINITION_SHAPE")
            usage = argument(shape, 2)
            if isinstance(usage, Ref):
                found[int(usage)] = follow(self.file, argument(record, 0))
        return found

    def _representations(self, product: Root) -> list[int]:
        """Return the representation of a product and those that say the same of it."""
        others = {other.representation for other in self.products.values()} - {product.representation}
        found = [product.representation]
        for number in found:  # it grows
            found.extend(set(self.related.get(number, ())) - others - set(found))
        return found

    def _shapes(self, product: Root) -> tuple[tuple[Solid, ...], bool]:
        """Return the solids of a product, and whether it holds any face."""
        solids, has_faces = list[Solid](), False
        for number in self._representations(product):
            representation = self.file.instance(number)
            for item in () if representation is None else context_and_items(representation)[1]:
                instance = self.file.instance(item)
                if instance is not None and instance.keyword in SOLIDS:
                    name = argument(instance.records[0], 0)
                    solids.append(Solid(int(item), name if isinstance(name, str) else "", number))
                has_faces |= instance is not None and instance.keyword in SOLIDS | SURFACES
        return tuple(solids), has_faces

    def _link(self, usage: Instance, name: str, relation: Instance | None) -> Link:
        record = record_of(usage, "NEXT_ASSEMBLY_USAGE_OCCURRENCE")
        parent, child = (self.products.get(_number(argument(record, i))) for i in (3, 4))
        transformation = _transformation(self.file, relation)
        if parent is None or child is None or relation is None or transformation is None:
            raise FormatError(f"the text does not say where the component #{usage.id} is", path=self.file.name)
        ends, own = _ends(relation), self._representations(parent)
        side = 1 if ends[1] in own else 0
        axes = [_number(argument(transformation.records[0], 2 + i)) for i in (side, 1 - side)]
        if ends[side] not in own or ends[1 - side] in own or min(axes) < 0:
            raise FormatError(f"the text does not say where the component #{usage.id} is", path=self.file.name)
        at, of = (
            placement_mm(self.file, axis, self._unit_mm(end))
            for axis, end in zip(axes, (ends[side], ends[1 - side]), strict=True)
        )
        T = RigidTransform.from_matrix(at.matrix @ of.inverse().matrix, target="part", source="part")
        return Link(
            usage.id, name, child.definition, relation.id, transformation.id, side,
            ends[1 - side], axes[1], axes[0], at, T,
        )  # fmt: skip

    def _unit_mm(self, representation: int) -> float:
        instance = self.file.instance(representation)
        context = None if instance is None else context_and_items(instance)[0]
        return 1.0 if context is None else unit_of_context(self.file, context)


def _ends(relation: Instance) -> tuple[int, int]:
    """Numbers of the two representations of a relationship; -1 where it names none."""
    record = relation.record("REPRESENTATION_RELATIONSHIP") or relation.records[0]
    return _number(argument(record, 2)), _number(argument(record, 3))


def _transformation(file: Part21File, relation: Instance | None) -> Instance | None:
    number = argument(record_of(relation, "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"), 0)
    found = follow(file, number)
    return None if record_of(found, "ITEM_DEFINED_TRANSFORMATION") is None else found


def _number(value: object) -> int:
    return int(value) if isinstance(value, Ref) else -1
