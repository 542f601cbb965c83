"""Move the solids of a STEP file by motions of their own, by editing its text: placements change, and no geometry.

Where all solids below a use of a product move alike, the placement of this use changes: the second item of its
``ITEM_DEFINED_TRANSFORMATION``. Where they do not, the placements within the product change. A product that is used
several times is then copied for each use that differs. A product that holds several solids becomes an assembly of one
product per solid. Nothing of the old structure stays visible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cad.step.append import (
    Assembly,
    EntityWriter,
    add_component,
    add_product,
    product_name,
    span_of,
    spliced,
    with_entities,
)
from cad.step.occurrences import LeafUse, Link, Occurrence, Solid, find_occurrences
from cad.step.part21 import Part21File
from cad.step.part21_values import Instance, Ref, StepRecord, Value, encode_string, format_instance
from cad.step.products import context_and_items
from cad.step.xcaf_tree import usable_name
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform

SAME_PLACE = 1e-6  #: Places of one use that the text and the kernel give differ by round-off only, mm.


def move_solids(
    file: Part21File, leaves: Sequence[LeafUse], T_part_moved: FloatArray
) -> tuple[bytes, dict[int, RigidTransform]]:
    """Return the text of a STEP file whose solids have moved within `part`.

    Raises `FormatError` when the text does not say where the solids are, or not as the kernel does.

    `T_part_moved`: shape (n, 4, 4). The motion of every solid, mm.

    Returns `roots`: Motions of whole roots, by their ``PRODUCT_DEFINITION``: they have no placement that could change.
    The assembly that holds them takes the motions (`append_placement`).
    """
    trees = find_occurrences(file)
    moves = _Moves.of(file, trees, leaves, T_part_moved)
    editor = _Editor(file, EntityWriter(int(file.ids[-1]) + 1), moves, _kept_as_they_are(trees, moves))
    roots = {}
    for tree in trees:
        motion = moves.motion(tree)
        if motion is None:
            editor.changed_product(tree, ())
        else:
            roots[tree.product.definition] = RigidTransform.from_matrix(motion, target="part", source="part")
    return editor.text(), roots


@dataclass(frozen=True, slots=True, eq=False)
class _Moves:
    """What every use does; uses are known by their identity."""

    places: Mapping[int, FloatArray]  #: shape (4, 4). Where each use is in `part`, mm.
    solids: Mapping[int, FloatArray]  #: shape (k, 4, 4). Motions of the solids of each use and of all below it.

    @classmethod
    def of(
        cls, file: Part21File, trees: Sequence[Occurrence], leaves: Sequence[LeafUse], T_part_moved: FloatArray
    ) -> _Moves:
        uses = [(tree, use) for tree in trees for use in tree.all() if use.has_faces]
        if len(uses) != len(leaves):
            raise FormatError("the text does not say which solid is where", path=file.name)
        places: dict[int, FloatArray] = {}
        solids: dict[int, FloatArray] = {}
        for (tree, use), leaf in zip(uses, leaves, strict=True):
            before = leaf.T_part_product @ np.linalg.inv(use.T_root_product.matrix)
            before = places.setdefault(id(tree), before)
            off = before @ use.T_root_product.matrix - leaf.T_part_product
            if np.abs(off).max() > SAME_PLACE:
                raise FormatError(f"the text does not say where #{use.product.definition} is", path=file.name)
            solids[id(use)] = T_part_moved[list(leaf.solids)]
        for tree in trees:
            _fill(tree, places.get(id(tree), np.eye(4)), places, solids)
        return cls(places, solids)

    def motion(self, use: Occurrence) -> FloatArray | None:
        """Return the motion of all solids of a use, shape (4, 4); None if they differ."""
        own = self.solids[id(use)]
        if not len(own):
            return np.eye(4)
        return own[0] if (own == own[0]).all() else None

    def within(self, use: Occurrence, motion: FloatArray) -> RigidTransform:
        """Turn a motion in `part` into one in the coordinates of a use."""
        W = self.places[id(use)]
        return RigidTransform.from_matrix(np.linalg.inv(W) @ motion @ W, target="part", source="part")


def _fill(use: Occurrence, root: FloatArray, places: dict[int, FloatArray], solids: dict[int, FloatArray]) -> None:
    places[id(use)] = root @ use.T_root_product.matrix
    for child in use.below:
        _fill(child, root, places, solids)
    own = solids.get(id(use), np.zeros((0, 4, 4)))
    solids[id(use)] = np.concatenate([own, *(solids[id(child)] for child in use.below)])


def _kept_as_they_are(trees: Sequence[Occurrence], moves: _Moves) -> set[int]:
    """Return the products that at least one use needs as they are."""
    return {
        use.product.definition for tree in trees for use in tree.all() if moves.motion(use) is not None
    }  # also of uses in an assembly that moves as one


@dataclass(slots=True)
class _Editor:
    """Changes of instances, and new ones."""

    file: Part21File
    writer: EntityWriter
    moves: _Moves
    taken: set[int]
    """Products that may not be changed: a use needs them as they are, or a use has changed them already."""
    changed: dict[int, Instance] = field(default_factory=dict)
    singles: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    count: int = 0

    def text(self) -> bytes:
        """Return the text with all changes."""
        changes = []
        for number, instance in self.changed.items():
            changes.append((*span_of(self.file, number), format_instance(instance)))
        return spliced(with_entities(self.file, self.writer), sorted(changes))

    def changed_product(self, use: Occurrence, axes: Sequence[int]) -> tuple[str, str]:
        """Move what is below a use, in its product or in a copy; return its definition and its representation."""
        is_copy = use.product.definition in self.taken
        self.taken.add(use.product.definition)
        if use.below and not is_copy:
            return self._in_place(use)
        origin = f"#{use.product.axis}" if use.product.axis is not None and use.below else self._origin()
        parts = [self._component(use, child) for child in use.below] or list(self._single_solids(use))
        items = list(dict.fromkeys([origin, *(f"#{axis}" for axis in axes), *(part.moved for part in parts)]))
        definition, representation = f"#{use.product.definition}", f"#{use.product.representation}"
        if is_copy:
            definition, representation = self._new_product(
                use, product_name(self.file, use.product), "SHAPE_REPRESENTATION", items
            )
        else:
            self._empty(use, items)
        assembly = Assembly(definition, representation, origin, use.product, ())
        for part in parts:
            self.count += 1
            add_component(
                self.writer, assembly, part.definition, part.representation,
                child=part.child, moved=part.moved, name=part.name, number=f"body.{self.count}",
            )  # fmt: skip
        return definition, representation

    def _in_place(self, use: Occurrence) -> tuple[str, str]:
        """Move the components of an assembly that no other use needs as it is."""
        new = []
        for child in use.below:
            link, motion = _link(child), self.moves.motion(child)
            if motion is None:
                self._refer(link, self.changed_product(child, (link.child_axis,)))
            elif not np.array_equal(motion, np.eye(4)):
                new.append(self._placed(use, link, motion))
                self._set(link.transformation, "ITEM_DEFINED_TRANSFORMATION", 2 + link.side, Ref(new[-1][1:]))
        if new:
            self._set_items(use.product.representation, (), new)
        return f"#{use.product.definition}", f"#{use.product.representation}"

    def _component(self, use: Occurrence, child: Occurrence) -> _Part:
        """Return what a copy of an assembly holds in place of a component."""
        link, motion = _link(child), self.moves.motion(child)
        definition, representation = f"#{link.child}", f"#{link.child_representation}"
        moved = f"#{link.parent_axis}"
        if motion is None:
            definition, representation = self.changed_product(child, (link.child_axis,))
        elif not np.array_equal(motion, np.eye(4)):
            moved = self._placed(use, link, motion)
        return _Part(link.name, definition, representation, f"#{link.child_axis}", moved)

    def _single_solids(self, use: Occurrence) -> list[_Part]:
        """Return a component for every solid of a product of several; what belongs to no solid is one more."""
        parts, motions = [], self.moves.solids[id(use)]
        if len(use.solids) != len(motions):
            raise FormatError(f"the text does not say which solid of #{use.product.definition} is which")
        for solid, motion in zip(use.solids, motions, strict=True):
            definition, representation, origin = self._single(use, solid)
            moved = self.writer.add_placement(self.moves.within(use, motion), unit_mm=use.product.unit_mm)
            parts.append(_Part(self._name(use, solid), definition, representation, origin, moved))
        rest = self._rest(use)
        if rest:
            if rest[0] not in self.singles:
                origin, name = self._origin(), product_name(self.file, use.product)
                items = [origin, *(f"#{item}" for item in rest)]
                self.singles[rest[0]] = (*self._new_product(use, name, "SHAPE_REPRESENTATION", items), origin)
            definition, representation, origin = self.singles[rest[0]]
            name = product_name(self.file, use.product)
            parts.append(_Part(name, definition, representation, origin, self._origin()))
        return parts

    def _single(self, use: Occurrence, solid: Solid) -> tuple[str, str, str]:
        """Return a product of one solid: its definition, its representation, and the placement in it."""
        if solid.item not in self.singles:
            origin = self._origin()
            keyword = "FACETED" if self._instance(solid.item).keyword == "FACETED_BREP" else "ADVANCED"
            keyword, items = f"{keyword}_BREP_SHAPE_REPRESENTATION", [origin, f"#{solid.item}"]
            self.singles[solid.item] = (*self._new_product(use, self._name(use, solid), keyword, items), origin)
        return self.singles[solid.item]

    def _name(self, use: Occurrence, solid: Solid) -> str:
        return usable_name(solid.name) or product_name(self.file, use.product)

    def _rest(self, use: Occurrence) -> list[int]:
        """Return what the representations of a product held beside solids and placements."""
        solids = {solid.item for solid in use.solids}
        found = []
        for number in dict.fromkeys(solid.representation for solid in use.solids):
            items = context_and_items(self._of_file(number))[1]
            found += [int(i) for i in items if i not in solids and self._of_file(i).keyword != "AXIS2_PLACEMENT_3D"]
        return found

    def _new_product(self, use: Occurrence, name: str, keyword: str, items: Sequence[str]) -> tuple[str, str]:
        definition, shape = add_product(self.writer, self.file, use.product, name)
        text = encode_string(name).decode("ascii")
        representation = self.writer.add(f"{keyword}({text},({','.join(items)}),#{use.product.context})")
        self.writer.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
        return definition, representation

    def _placed(self, use: Occurrence, link: Link, motion: FloatArray) -> str:
        """Add the placement of a component of a use after a motion."""
        T = self.moves.within(use, motion) @ link.T_parent_axis
        return self.writer.add_placement(T, unit_mm=use.product.unit_mm)

    def _origin(self) -> str:
        return self.writer.add_placement(RigidTransform.identity(target="part", source="part"), unit_mm=1.0)

    def _empty(self, use: Occurrence, items: Sequence[str]) -> None:
        """Take all shapes out of the representations of a product, and list these placements instead."""
        for number in dict.fromkeys(solid.representation for solid in use.solids):
            shapes = [*(solid.item for solid in use.solids), *self._rest(use)]
            self._set_items(number, shapes, [] if number == use.product.representation else items[:1])
        self._set_items(use.product.representation, (), items)

    def _refer(self, link: Link, product: tuple[str, str]) -> None:
        """Let a component refer to another product."""
        definition, representation = (Ref(text[1:]) for text in product)
        if definition != link.child:
            self._set(link.usage, "NEXT_ASSEMBLY_USAGE_OCCURRENCE", 4, definition)
            self._set(link.relation, "REPRESENTATION_RELATIONSHIP", 3 - link.side, representation)

    def _instance(self, number: int) -> Instance:
        return self.changed.get(number) or self._of_file(number)

    def _of_file(self, number: int) -> Instance:
        found = self.file.instance(number)
        if found is None:
            raise FormatError(f"#{number} is missing", path=self.file.name)
        return found

    def _set(self, number: int, keyword: str, index: int, value: Value) -> None:
        """Change one argument of an instance."""
        instance = self._instance(number)
        old = instance.record(keyword) or instance.records[0]
        arguments = (*old.arguments[:index], value, *old.arguments[index + 1 :])
        records = tuple(StepRecord(old.keyword, arguments) if record is old else record for record in instance.records)
        self.changed[number] = replace(instance, records=records)

    def _set_items(self, number: int, without: Sequence[int], new: Sequence[str]) -> None:
        """Change the items of a representation. Without a shape it is a plain one."""
        instance = self._instance(number)
        _, items = context_and_items(instance)
        kept = tuple(item for item in items if item not in set(without))
        self._set(number, "REPRESENTATION", 1, (*kept, *(Ref(text[1:]) for text in new)))
        if without:
            instance = self.changed[number]
            records: tuple[StepRecord, ...] = (StepRecord("SHAPE_REPRESENTATION", instance.records[0].arguments),)
            if len(instance.records) > 1:
                records = tuple(r for r in instance.records if not r.keyword.endswith("BREP_SHAPE_REPRESENTATION"))
            self.changed[number] = replace(instance, records=records)


@dataclass(frozen=True, slots=True)
class _Part:
    """A component to be added: its product, a placement in that, and the placement in the assembly that it gets."""

    name: str
    definition: str
    representation: str
    child: str
    moved: str


def _link(use: Occurrence) -> Link:
    assert use.link is not None  # of everything below a root
    return use.link
