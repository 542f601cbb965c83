"""Move a STEP file by appending to its text: a new assembly places the roots, and no other byte changes.

Everything in the file (geometry, names, colours, layers, annotations, its unit) therefore stays. The new entities are
those of ISO 10303-44 for an assembly: one product, and for every root a ``NEXT_ASSEMBLY_USAGE_OCCURRENCE`` with an
``ITEM_DEFINED_TRANSFORMATION`` from a placement in the root's representation to one in the new product's.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from cad.step.part21 import Part21File
from cad.step.part21_values import Ref, StepRecord, encode_string, format_real
from cad.step.products import Root, argument, axis_placement, find_roots
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform

NOT_MOVED: Mapping[int, RigidTransform] = MappingProxyType({})  #: No root has moved within the part.

PARALLEL_SIN = 1e-6
"""An axis and a reference direction do not span a plane if the sine of their angle is less than this."""


@dataclass(slots=True)
class EntityWriter:
    """Collects new entities, numbered after those of the file."""

    next_id: int  #: Number of the next entity.
    lines: list[bytes] = field(default_factory=list)

    def add(self, body: str) -> str:
        """Add one entity ``KEYWORD(…)`` and return its reference ``#n``."""
        reference = f"#{self.next_id}"
        self.lines.append(f"{reference}={body};".encode("ascii"))
        self.next_id += 1
        return reference

    def add_vector(self, keyword: str, values: ArrayLike) -> str:
        """Add a point or a direction. `values`: shape (3,). In the unit of the file."""
        return self.add(f"{keyword}('',({','.join(format_real(v) for v in np.asarray(values).tolist())}))")

    def add_placement(self, placement: RigidTransform, *, unit_mm: float) -> str:
        """Add an ``AXIS2_PLACEMENT_3D``; its location is written in units of `unit_mm`."""
        location = self.add_vector("CARTESIAN_POINT", placement.t_mm / unit_mm)
        axis = self.add_vector("DIRECTION", placement.R[:, 2])
        reference = self.add_vector("DIRECTION", placement.R[:, 0])
        return self.add(f"AXIS2_PLACEMENT_3D('',{location},{axis},{reference})")


@dataclass(frozen=True, slots=True)
class Assembly:
    """The new assembly: what other appended products need to know of it."""

    #: `definition`, `representation`, `origin`: References of its ``PRODUCT_DEFINITION``, its ``SHAPE_REPRESENTATION``
    #: and the identity placement in the latter.
    definition: str
    representation: str
    origin: str
    root: Root  #: The first root. New products use its contexts and its unit.
    names: tuple[str, ...]  #: Names that were added: of the product and of its components.

    @property
    def unit_mm(self) -> float:
        """Length unit of the assembly, mm."""
        return self.root.unit_mm


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """What a file says of its roots: all moves of a file have it in common."""

    roots: tuple[Root, ...]  #: At least one.
    names: tuple[str, ...]  #: Of their products; empty if a product has none.
    T_part_axis: tuple[RigidTransform | None, ...]  #: Their own placements; None if a root has no usable one.

    @classmethod
    def of(cls, file: Part21File) -> Placed:
        """Find the roots of a file. Raises `FormatError` when the file has no product with a shape."""
        roots = find_roots(file)
        if not roots:
            raise FormatError("no product with a shape is found in its text", path=file.name)
        own = (None if root.axis is None else placement_of(file, root.axis, root.unit_mm) for root in roots)
        return cls(roots, tuple(product_name(file, root) for root in roots), tuple(own))


def append_placement(
    file: Part21File,
    T_base_part: RigidTransform,
    *,
    name: str,
    moves: Mapping[int, RigidTransform] = NOT_MOVED,
    placed: Placed | None = None,
) -> tuple[EntityWriter, Assembly]:
    """Write the entities of an assembly that holds the file's roots moved by a transform.

    Returns EntityWriter, Assembly. For `with_entities`. More entities can be added before.
    Raises `FormatError` when the file has no product with a shape.
    """
    placed = placed or Placed.of(file)
    roots = placed.roots
    writer = EntityWriter(int(file.ids[-1]) + 1)
    unit_mm = roots[0].unit_mm
    definition, shape = add_product(writer, file, roots[0], name)
    origin = writer.add_placement(RigidTransform.identity(target="base", source="base"), unit_mm=1.0)
    still = RigidTransform.identity(target="part", source="part")
    pairs = [
        _add_placements(
            writer, root, own, T_base_part @ moves.get(root.definition, still), origin=origin, unit_mm=unit_mm
        )
        for root, own in zip(roots, placed.T_part_axis, strict=True)
    ]
    items = ",".join([origin, *(moved for _, moved in pairs)])
    representation = writer.add(f"SHAPE_REPRESENTATION({_string(name)},({items}),#{roots[0].context})")
    writer.add(f"SHAPE_DEFINITION_REPRESENTATION({shape},{representation})")
    names = [own or name for own in placed.names]
    assembly = Assembly(definition, representation, origin, roots[0], (name, *names))
    for number, (root, (child, moved)) in enumerate(zip(roots, pairs, strict=True), start=1):
        add_component(
            writer, assembly, f"#{root.definition}", f"#{root.representation}",
            child=child, moved=moved, name=names[number - 1], number=number,
        )  # fmt: skip
    return writer, assembly


def with_entities(file: Part21File, writer: EntityWriter) -> bytes:
    """Return the file's text with the new entities at the end of its last data section, with the file's line ends."""
    newline = file.newline
    head = file.text[: file.data_end]
    gap = b"" if head.endswith(b"\n") else newline
    return head + gap + newline.join(writer.lines) + newline + file.text[file.data_end :]


def add_component(
    writer: EntityWriter, assembly: Assembly, definition: str, representation: str, *,
    child: str, moved: str, name: str, number: int | str,
) -> None:  # fmt: skip
    """Add one use of a product in the assembly: it is moved from the placement `child` to the placement `moved`."""
    text = _string(name)
    usage = writer.add(
        f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('wpcal.{number}',{text},'',{assembly.definition},{definition},$)"
    )
    shape = writer.add(f"PRODUCT_DEFINITION_SHAPE('Placement',{text},{usage})")
    transformation = writer.add(f"ITEM_DEFINED_TRANSFORMATION('','',{child},{moved})")
    relation = writer.add(
        f"(REPRESENTATION_RELATIONSHIP('','',{representation},{assembly.representation})"
        f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({transformation})SHAPE_REPRESENTATION_RELATIONSHIP())"
    )
    writer.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({relation},{shape})")


def add_product(writer: EntityWriter, file: Part21File, root: Root, name: str) -> tuple[str, str]:
    """Add a product in the contexts of a root's product; return its ``PRODUCT_DEFINITION`` and ``…_SHAPE``."""
    product, definition = _product_records(file, root)
    contexts, context = argument(product, 3), argument(definition, 3)
    if not isinstance(contexts, tuple) or not isinstance(context, Ref):
        raise FormatError(f"the product of #{root.definition} has no context", path=file.name)
    references = ",".join(f"#{item}" for item in contexts if isinstance(item, Ref))
    text = _string(name)
    new_product = writer.add(f"PRODUCT({text},{text},'',({references}))")
    writer.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({new_product}))")
    formation = writer.add(f"PRODUCT_DEFINITION_FORMATION('','',{new_product})")
    new_definition = writer.add(f"PRODUCT_DEFINITION('design','',{formation},#{int(context)})")
    return new_definition, writer.add(f"PRODUCT_DEFINITION_SHAPE('','',{new_definition})")


def _product_records(file: Part21File, root: Root) -> tuple[StepRecord | None, StepRecord | None]:
    """Records of a root's ``PRODUCT`` and ``PRODUCT_DEFINITION``."""
    instance = file.instance(root.definition)
    definition = None if instance is None else instance.records[0]
    formation = argument(definition, 2)
    instance = file.instance(formation) if isinstance(formation, Ref) else None
    product = argument(None if instance is None else instance.records[0], 2)
    instance = file.instance(product) if isinstance(product, Ref) else None
    return None if instance is None else instance.record("PRODUCT"), definition


def product_name(file: Part21File, root: Root) -> str:
    """Return the name of a product, or its id; empty when it has neither."""
    product, _ = _product_records(file, root)
    for index in (1, 0):
        value = argument(product, index)
        if isinstance(value, str) and value.strip():
            return value
    return ""


def _add_placements(
    writer: EntityWriter,
    root: Root,
    T_part_axis: RigidTransform | None,
    T_base_part: RigidTransform,
    *,
    origin: str,
    unit_mm: float,
) -> tuple[str, str]:
    """References of the root's own placement A and of the moved placement T A, which is added.

    A reader moves the root by the second placement times the inverse of the first: (T A) A⁻¹ = T. For a root without a
    usable placement, A is the identity placement of the new product.
    """
    if T_part_axis is None:
        return origin, writer.add_placement(T_base_part, unit_mm=unit_mm)
    return f"#{root.axis}", writer.add_placement(T_base_part @ T_part_axis, unit_mm=unit_mm)


def placement_of(file: Part21File, number: int, unit_mm: float) -> RigidTransform | None:
    """A placement of the file as ``T_part_axis``; None when it leaves a direction to the reader's default."""
    location, axis, reference = axis_placement(file, number)
    if axis is None or reference is None:
        return None
    R = _orthonormal(np.array(axis), np.array(reference))
    return None if R is None else RigidTransform(R, np.array(location) * unit_mm, "part", "axis")


def _orthonormal(axis: FloatArray, reference: FloatArray) -> FloatArray | None:
    """Rotation with z along `axis`, and x along `reference` made normal to z (ISO 10303-42, axis2_placement_3d)."""
    lengths = np.linalg.norm(axis), np.linalg.norm(reference)
    if min(lengths) == 0.0:
        return None
    z, x = axis / lengths[0], reference / lengths[1]
    x = x - (x @ z) * z
    if np.linalg.norm(x) < PARALLEL_SIN:
        return None
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _string(text: str) -> str:
    return encode_string(text).decode("ascii")


def span_of(file: Part21File, number: int) -> tuple[int, int]:
    """Return where an instance begins and where it ends, before its semicolon."""
    at = int(np.searchsorted(file.ids, number))
    return int(file.starts[at]), int(file.ends[at])


def spliced(text: bytes, changes: Sequence[tuple[int, int, bytes]]) -> bytes:
    """Replace ranges of a text; they are given in ascending order."""
    pieces, done = [], 0
    for start, end, new in changes:
        pieces += [text[done:start], new]
        done = end
    return b"".join([*pieces, text[done:]])
