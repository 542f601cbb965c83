# SPDX-License-Identifier: MIT
"""Parts of a document as a STEP file for wpcal. Nothing in the document is changed.

The file is written once per change: `Exports` knows when an object of the part was changed, and the hash of the data
tells whether a later file says the same.
"""

from __future__ import annotations

import hashlib
import re
from pathlib import Path
from typing import Any, Iterator, NamedTuple, Sequence

import FreeCAD

from .kinds import is_ours

_COUNTER = re.compile(rb"Open CASCADE STEP translator [\d.]+( [\d.]+)*|NEXT_ASSEMBLY_USAGE_OCCURRENCE\('\d+'")
"""The kernel counts files and occurrences of a process, and writes the numbers."""
_PRODUCT = re.compile(rb"PRODUCT\('(?:[^']|'')*','(?:[^']|'')*'")
SAME_PLACEMENT = 1e-9
"""Largest difference of two entries of the matrices of equal placements, mm: round-off of products of a few of them."""
SHAPED = ("Part::Feature", "App::Part", "App::Link")  #: Objects that can have a solid.
CONTAINERS = ("App::DocumentObjectGroup", "App::DocumentObjectGroupPython")  #: Groups without a place of their own.
GEOMETRIC = (*SHAPED, CONTAINERS[0])  #: Objects whose change can change the part.


class NothingToExportError(ValueError):
    """The document, or what was selected, has no solid."""


class ExportedPart(NamedTuple):
    """A part as STEP."""

    path: Path
    objects: tuple[Any, ...]  #: The objects of the document that are in the file.
    frame: Any  #: Where the coordinates of the file lie in the document.
    hash: str  #: SHA-256 of the data, without what differs between two files of the same part.


def part_objects(document: Any, chosen: Sequence[Any] = ()) -> list[Any]:
    """Return the objects of the part: those chosen, or every visible one that is not part of another.

    Raises `NothingToExportError` when nothing has a solid.
    """
    candidates = list(chosen) if chosen else [obj for obj in _spread(roots(document)) if obj.Visibility]
    objects = [obj for obj in candidates if not is_ours(obj) and has_solid(obj)]
    if not objects:
        where = "the selection" if chosen else "the visible objects of the document"
        raise NothingToExportError(f"no solid in {where}")
    return objects


def roots(document: Any) -> list[Any]:
    """Return the objects that belong to no other; the links of this workbench to them do not count."""
    return [obj for obj in document.Objects if not is_ours(obj) and all(is_ours(user) for user in obj.InList)]


def has_solid(obj: Any) -> bool:
    """Tell whether an object, or a part of it, is a solid."""
    import Part

    if not any(obj.isDerivedFrom(name) for name in SHAPED):
        return False
    shape = Part.getShape(obj)
    return not shape.isNull() and len(shape.Solids) > 0


def frame_of(objects: Sequence[Any]) -> Any:
    """Return where the coordinates of a file with these objects lie in the document.

    FreeCAD writes an object at its place in its container. A single object, or several of one container, therefore come
    in the coordinates of that container.

    Raises `NothingToExportError` when the objects are in containers at different places.
    """
    frames = [_container_frame(obj) for obj in objects]
    if any(not is_same_placement(frames[0], frame) for frame in frames):
        raise NothingToExportError("the selected objects are in containers at different places; select the containers")
    return frames[0]


def _container_frame(obj: Any) -> Any:
    if not hasattr(obj, "getGlobalPlacement"):  # links in FreeCAD 0.20
        return FreeCAD.Placement()
    return obj.getGlobalPlacement().multiply(obj.Placement.inverse())


def is_same_placement(a: Any, b: Any) -> bool:
    """Tell whether two placements differ by round-off only."""
    return bool(max(abs(x - y) for x, y in zip(a.toMatrix().A, b.toMatrix().A)) <= SAME_PLACEMENT)


def export_part(objects: Sequence[Any], path: Path) -> ExportedPart:
    """Write objects as one STEP file, each with its label as the name of its product."""
    import Import

    frame = frame_of(objects)
    Import.export(list(objects), str(path))
    return ExportedPart(path, tuple(objects), frame, step_hash(path.read_bytes(), is_assembly=len(objects) > 1))


def step_hash(data: bytes, *, is_assembly: bool) -> str:
    """Return the hash of the data section of a STEP file; the header has the time of writing.

    The first product of several objects has the label of the document, which is that of its file: it does not count.
    """
    body = data[data.find(b"DATA;") :]
    if is_assembly:
        body = _PRODUCT.sub(b"", body, count=1)
    return hashlib.sha256(_COUNTER.sub(b"", body)).hexdigest()


def members(objects: Sequence[Any]) -> Iterator[Any]:
    """Yield the objects and everything that they are made of."""
    seen = set()
    todo = list(objects)
    while todo:
        obj = todo.pop()
        if obj.Name not in seen:
            seen.add(obj.Name)
            yield obj
            todo.extend(obj.OutList)


def _spread(objects: Sequence[Any]) -> Iterator[Any]:
    for obj in objects:
        if obj.TypeId in CONTAINERS:
            yield from _spread(obj.Group)
        else:
            yield obj


class Changes:
    """Counts the changes of the part's objects. A document observer of FreeCAD."""

    GEOMETRY = ("Shape", "Placement", "Group", "Visibility", "LinkedObject", "LinkPlacement", "Label")
    """A change of another property reaches the part through one of these; so does a new object."""

    def __init__(self, document: Any) -> None:
        self._document = document
        self.count = 0
        self.is_paused = False
        FreeCAD.addDocumentObserver(self)

    def stop(self) -> None:
        """Stop counting."""
        FreeCAD.removeDocumentObserver(self)

    def slotChangedObject(self, obj: Any, name: str) -> None:
        """Count a change of what is exported."""
        if name in self.GEOMETRY:
            self._count(obj)

    def slotDeletedObject(self, obj: Any) -> None:
        """Count a deleted object."""
        self._count(obj)

    def _count(self, obj: Any) -> None:
        if self.is_paused or obj.Document.Name != self._document.Name:
            return
        if any(obj.isDerivedFrom(name) for name in GEOMETRIC):
            self.count += 1
