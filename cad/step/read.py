"""Read a STEP file: placed solids with names, colours and layers. Every oddity is reported as an `Issue`.

The file is read into an XCAF document (the kernel's tree of products, instances and attributes), which is kept for
writing. A *leaf* is a product without components. Each use of a leaf gives its solids once, placed.
"""

from __future__ import annotations

import io
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.XCAFDoc import XCAFDoc_ShapeTool

from cad.kernel.call import KernelObject, kernel_call, step_settings
from cad.kernel.geometry import location_matrix
from cad.kernel.topology import EDGE, FACE, SHAPE_KINDS, SOLID, WIRE, NumberedShapes, sub_shapes
from cad.kernel.xcaf import label_color, label_name, labels_of, new_document
from cad.step.distorted import refuse_distorted
from cad.step.materials import ProductMaterial, read_materials
from cad.step.occurrences import LeafUse
from cad.step.open_text import read_step_text
from cad.step.part21 import Part21File
from cad.step.products import find_roots, unit_name
from cad.step.solids import LeafShapes, leaf_shapes
from cad.step.xcaf_tree import Leaf, StepTree, Use, merged_layers, usable_name
from wpcal.brep.mesh import Rgb
from wpcal.brep.solid_facts import SolidFacts
from wpcal.core.errors import FormatError, InputError
from wpcal.core.given_names import is_given_name
from wpcal.core.input_file import MOST_STEP_MB, read_bytes, sha256_of
from wpcal.core.issue import Issue
from wpcal.core.process import give_memory_back

READ_SETTINGS: dict[str, int | str] = {"xstep.cascade.unit": "MM", "read.stepcaf.subshapes.name": 1}
"""Lengths in mm, and the names of faces and edges, which the kernel does not read by default."""

TRANSFERS, ENTITIES = 7, 1  #: What the kernel's session forgets: which entity became which shape, and the entities.

NO_FOLDER = os.devnull + "/"
"""A folder that cannot hold files: the kernel looks there for other files that a text refers to. They are not read."""


@dataclass(frozen=True, slots=True, eq=False)
class StepSolid:
    """One placed solid, or a shell where the file has no solid there."""

    #: The name of the body, or else of its product, as written. A name that a program gave, such as ``Body1``, gives
    #: way to that of the product. Further solids of the same name are called ``name#2``, ``name#3``, … A solid without
    #: a name is called by its number: ``S4`` is the fourth.
    name: str
    path: tuple[str, ...]  #: Names of the instances from the root down.
    shape: Any  #: ``TopoDS_Solid`` or ``TopoDS_Shell`` in the frame `part`, mm.
    color_rgb: Rgb | None  #: sRGB as the file writes it, in 0…1.
    layers: tuple[str, ...]
    #: Path, colour, and what else helps to tell whether the solid can be welded: products, material, density.
    facts: SolidFacts = field(default_factory=SolidFacts)


@dataclass(frozen=True, slots=True, eq=False)
class StepMark:
    """A face, wire or edge with a name, a colour or a layer of its own."""

    kind: str  #: ``face``, ``wire`` or ``edge``.
    name: str  #: As written; empty when it has none. Often without meaning: some exporters name every edge.
    color_rgb: Rgb | None  #: sRGB as the file writes it, in 0…1.
    layers: tuple[str, ...]
    path: tuple[str, ...]  #: Names of the instances from the root down.
    shape: Any  #: In the frame `part`, mm.


@dataclass(frozen=True, slots=True, eq=False)
class StepPart:
    """Everything read from one STEP file."""

    file_name: str  #: Without its folder.
    sha256: str  #: Of the file's bytes.
    unit: str  #: Length unit of the file: ``mm``, ``inch``, … The shapes are always in mm.
    schema: str  #: As the header names it: ``AUTOMOTIVE_DESIGN``.
    solids: tuple[StepSolid, ...]  #: In the order of the file.
    marks: tuple[StepMark, ...]  #: In the order of the file.
    issues: tuple[Issue, ...]  #: What is odd in the file.
    document: Any  #: The XCAF document.
    source: Part21File  #: The indexed text.
    leaves: tuple[LeafUse, ...] = ()  #: Every use of a product with faces.

    @property
    def text(self) -> bytes:
        """The file's bytes as read, without a byte order mark: the kernel refuses one."""
        return self.source.text

    def without_shapes(self) -> StepPart:
        """Return what is known without the kernel: the text, and what is odd in it."""
        return replace(self, solids=(), marks=(), document=None)

    def build123d_shapes(self) -> list[Any]:
        """Return the solids as build123d shapes with label and colour; the first call imports build123d (2 to 5 s).

        Raises `InputError` when build123d is not installed.
        """
        try:
            import build123d
        except ModuleNotFoundError:
            raise InputError("shapes need build123d: install wpcal[scripts]") from None
        found = []
        for solid in self.solids:
            shape = build123d.Shape.cast(solid.shape)
            shape.label = solid.name
            if solid.color_rgb is not None:
                shape.color = build123d.Color(*solid.color_rgb)
            found.append(shape)
        return found


def read_step(path: Path | str, *, data: bytes | None = None) -> StepPart:
    """Read a STEP file: placed solids in mm, names, colours, layers, and what is odd about it.

    Returns StepPart. The same names in the same order at every run.

    Raises `InputError` when the file cannot be read, is not a STEP file, has no face, or places a mirrored or scaled
    copy.
    Raises `FormatError` when the text is broken or cut off.
    Raises `KernelError` when the kernel fails.

    The kernel needs 0.1 to 0.2 s per megabyte. A fault of the kernel can crash the interpreter. A program that reads
    files of others therefore calls this through `cad.work.child.run_in_child`.
    """
    path = Path(path)
    file = read_step_text(path, data=data)
    refuse_distorted(file, str(path))
    with kernel_call(f"reading {path}"):
        document = read_document(path, file.text)
        tree = StepTree(document)
        leaves = list(tree.leaves())
        prepared = {leaf.entry: leaf_shapes(leaf.use.name, leaf.shape) for leaf in leaves}
        _refuse_without_faces(path, leaves, prepared)
        prepared, shell_issues = _without_open_shells(prepared)
        solids = tuple(_placed_solids(leaves, prepared, tree, read_materials(file)))
        marks = tuple(_placed_marks(leaves, prepared, tree))
    unit, unit_issues = _unit(file)
    issues = [*unit_issues, *_issues_of(leaves, prepared), *shell_issues]
    if not solids:
        issues.append(Issue("no-solid", "the file holds no solid and no shell with exact faces"))
    digest = sha256_of(file.byte_order_mark + file.text)
    uses = tuple(_leaf_uses(leaves, prepared))
    return StepPart(path.name, digest, unit, file.schema, solids, marks, tuple(issues), document, file, uses)


def read_document(path: Path, text: bytes | None = None) -> KernelObject:
    """Read a STEP file into a new XCAF document, in mm.

    Raises `FormatError` when the kernel does not read the file.

    `text`: The file's bytes as read before, so that the shapes come from the bytes whose SHA-256 is recorded, even if
    somebody changes the file meanwhile.
    """
    document = new_document()
    with step_settings(READ_SETTINGS), _without_automatic_names():
        reader = STEPCAFControl_Reader()
        for switch in (
            reader.SetNameMode, reader.SetColorMode, reader.SetLayerMode, reader.SetGDTMode, reader.SetSHUOMode,
        ):  # fmt: skip
            switch(True)
        stream = io.BytesIO(read_bytes(path, most_mb=MOST_STEP_MB) if text is None else text)
        if reader.ReadStream(NO_FOLDER + path.name, stream) != IFSelect_ReturnStatus.IFSelect_RetDone:
            # a transfer would now crash
            raise FormatError("the CAD kernel cannot read its text", path=str(path))
        if not reader.Transfer(document):
            raise FormatError("the CAD kernel finds no shape it can build", path=str(path))
        for what in (TRANSFERS, ENTITIES):  # the reader would keep them: 10 kB a face
            reader.Reader().WS().ClearData(what)
    give_memory_back()
    return document


@contextmanager
def _without_automatic_names() -> Iterator[None]:
    """Keep the kernel from naming nameless shapes SOLID or =>[0:1:1:2]."""
    before = XCAFDoc_ShapeTool.AutoNaming_s()
    XCAFDoc_ShapeTool.SetAutoNaming_s(False)
    try:
        yield
    finally:
        XCAFDoc_ShapeTool.SetAutoNaming_s(before)


def _issues_of(leaves: list[Leaf], prepared: dict[str, LeafShapes]) -> Iterator[Issue]:
    """Yield what is odd in the parts; that one is empty only if no other part of its name has the faces."""
    with_faces = {leaf.use.name for leaf in leaves if prepared[leaf.entry].has_faces}
    for found in prepared.values():
        yield from (
            issue for issue in found.issues if issue.code != "empty-part" or not with_faces.issuperset(issue.ids)
        )


def _refuse_without_faces(path: Path, leaves: list[Leaf], prepared: dict[str, LeafShapes]) -> None:
    if any(found.has_faces for found in prepared.values()):
        return
    names = ", ".join(dict.fromkeys(leaf.use.name for leaf in leaves if leaf.use.name)) or "none named"
    raise InputError(
        f"{path}: holds no face; its parts ({names}) may be in other files that are not read: export one single file"
    )


def _without_open_shells(prepared: dict[str, LeafShapes]) -> tuple[dict[str, LeafShapes], list[Issue]]:
    """Leave out open shells if the file has solids: such shells are datum planes and other supplemental geometry."""
    bodies = [body for found in prepared.values() for body in found.bodies]
    shells = sum(body.ShapeType() != SOLID for body in bodies)
    if shells in (0, len(bodies)):
        return prepared, []
    kept = {
        entry: replace(found, bodies=tuple(body for body in found.bodies if body.ShapeType() == SOLID))
        for entry, found in prepared.items()
    }
    return kept, [Issue("open-shells", f"{shells} open shells beside the solids are left out")]


def _placed_solids(
    leaves: list[Leaf], prepared: dict[str, LeafShapes], tree: StepTree, materials: Mapping[str, ProductMaterial]
) -> Iterator[StepSolid]:
    taken: set[str] = set()
    number = 0
    levels = zip(*(leaf.use.products for leaf in leaves if prepared[leaf.entry].bodies), strict=False)
    whole = sum(1 for _ in takewhile(lambda names: len(set(names)) == 1, levels))
    for leaf in leaves:
        bodies = prepared[leaf.entry].bodies
        for shape, own in zip(bodies, _own_attributes(leaf, bodies, tree), strict=True):
            number += 1
            name = unique_name(_best_name(own.name, leaf.use, whole) or f"S{number}", taken)
            placed = shape.Moved(leaf.use.location)
            layers = merged_layers(leaf.use.layers, own.layers)
            color = leaf.use.color or own.color
            made_of = materials.get(leaf.use.name, ProductMaterial())
            products = (*leaf.use.products, own.name) if own.name else leaf.use.products
            facts = SolidFacts(leaf.use.path, products, color, made_of.texts, made_of.density_kg_m3)
            yield StepSolid(name, leaf.use.path, placed, color, layers, facts)


def _leaf_uses(leaves: list[Leaf], prepared: dict[str, LeafShapes]) -> Iterator[LeafUse]:
    number = 0
    for leaf in leaves:
        count = len(prepared[leaf.entry].bodies)
        if prepared[leaf.entry].has_faces:
            yield LeafUse(tuple(range(number, number + count)), location_matrix(leaf.use.location))
        number += count


@dataclass(frozen=True, slots=True)
class _Attributes:
    """Name, colour and layers of one sub-shape."""

    name: str = ""
    color: Rgb | None = None
    layers: tuple[str, ...] = ()


def _own_attributes(leaf: Leaf, bodies: tuple[Any, ...], tree: StepTree) -> list[_Attributes]:
    """Attributes of the bodies of a leaf. A single body without a colour takes the one colour of its faces."""
    numbered = NumberedShapes(bodies)
    found = [_Attributes() for _ in bodies]
    face_colors = set()
    for label in labels_of(XCAFDoc_ShapeTool.GetSubShapes_s, leaf.label):
        shape, color = XCAFDoc_ShapeTool.GetShape_s(label), label_color(label)
        if shape.IsNull():
            continue
        number = numbered.number(shape)
        if number >= 0:
            found[number] = _Attributes(usable_name(label_name(label)), color, tree.layers_of(label))
        elif color is not None and shape.ShapeType() == FACE:
            face_colors.add(color)
    if len(found) == len(face_colors) == 1 and found[0].color is None:
        found[0] = replace(found[0], color=face_colors.pop())
    return found


def _best_name(own: str, use: Use, whole: int) -> str:
    """Return the name of a body that a person gave to it, or else to the nearest product that is not the whole part.

    The first `whole` products hold all bodies of the file.
    """
    above = (own, use.name, *reversed(use.products[whole:]))
    given = (name for name in above if name and is_given_name(name))
    return next(given, own or use.name)


def unique_name(name: str, taken: set[str]) -> str:
    """Return a name, with a number if it is taken, and take it."""
    candidate, count = name, 1
    while candidate in taken:
        count += 1
        candidate = f"{name}#{count}"
    taken.add(candidate)
    return candidate


def _placed_marks(leaves: list[Leaf], prepared: dict[str, LeafShapes], tree: StepTree) -> Iterator[StepMark]:
    for leaf in leaves:
        use = leaf.use
        if not prepared[leaf.entry].has_faces and not leaf.shape.IsNull():
            yield from _wire_marks(leaf, tree)
            continue
        for label in labels_of(XCAFDoc_ShapeTool.GetSubShapes_s, leaf.label):
            shape = XCAFDoc_ShapeTool.GetShape_s(label)
            if shape.IsNull() or shape.ShapeType() not in (FACE, WIRE, EDGE):
                continue
            name, color, layers = usable_name(label_name(label)), label_color(label), tree.layers_of(label)
            if name or color or layers:
                kind = SHAPE_KINDS[shape.ShapeType()]
                yield StepMark(kind, name, color, layers, use.path, shape.Moved(use.location))


def _wire_marks(leaf: Leaf, tree: StepTree) -> Iterator[StepMark]:
    """Every edge of a product without faces. An edge without a name, colour or layer of its own takes the product's."""
    edges = sub_shapes(leaf.shape, EDGE)
    use = leaf.use
    for edge, own in zip(edges, _own_attributes(leaf, tuple(edges), tree), strict=True):
        placed, layers = edge.Moved(use.location), merged_layers(use.layers, own.layers)
        yield StepMark("edge", own.name or use.name, own.color or use.color, layers, use.path, placed)


def _unit(file: Part21File) -> tuple[str, list[Issue]]:
    """Length unit of the file's roots, with an issue when it is not mm or the roots differ."""
    names = list(dict.fromkeys(unit_name(root.unit_mm) for root in find_roots(file)))
    if not names:
        return "mm", [Issue("no-product", "the file names no product with a shape; its unit is assumed to be mm")]
    if len(names) > 1:
        return names[0], [Issue("mixed-units", f"the file's products are in {', '.join(names)}; all were turned to mm")]
    if names[0] != "mm":
        return names[0], [Issue("unit-not-mm", f"the file is in {names[0]}; all lengths were turned to mm")]
    return "mm", []
