"""The bodies of a part that may have moved: solids, groups of solids, or the members of one solid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.bending import Bends, find_bends
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.calibrate.observe.members import find_members
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.records import read_json
from wpcal.core.wording import listed

BODIES_SCHEMA = "wpcal/bodies/1"
KNOWN = ("name", "solids", "tack_mm", "tack_mrad", "faces", "centre_mm", "size_mm")
"""What a body may have in a file. The last three are written to recognise it by, and are not read."""


@dataclass(frozen=True, slots=True)
class BodyGroup:
    """Solids that move as one."""

    name: str
    solids: tuple[str, ...]  #: Names; * and ? match any letters.
    tolerance: TackTolerance | None = None  #: None: the one of the part.


@dataclass(frozen=True, slots=True)
class BodiesSource:
    """The file that names bodies."""

    file: str  #: Its name, without folder.
    sha256: str

    @classmethod
    def of(cls, path: Path) -> BodiesSource:
        """Return the name and the hash of a file. Raises `InputError` when it cannot be read."""
        return cls(path.name, sha256_of(read_bytes(path)))


@dataclass(frozen=True, slots=True)
class BodiesOptions:
    """Which bodies may move, and how far. Raises `InputError` when `contact_sigma_mm` is not positive."""

    tolerance: TackTolerance = field(default_factory=TackTolerance)  #: Of bodies that state none.
    is_stated: bool = False  #: Whether a person stated it; otherwise it is estimated where there are enough touches.
    groups: tuple[BodyGroup, ...] = ()  #: Every solid that is in no group is a body of its own.
    bending_mm: float | None = None  #: Root mean square bow of a plate of 1 m; None: plates stay straight.
    keeps_contacts: bool = False  #: Whether plane faces of two bodies that touch in the model stay on each other.
    #: How far they may come apart or into each other: a standard deviation. None: half of the gap up to which members
    #: count as in contact.
    contact_sigma_mm: float | None = None
    source: BodiesSource | None = None  #: The file of the groups.

    def __post_init__(self) -> None:
        sigma_mm = self.contact_sigma_mm
        if sigma_mm is not None and not 0.0 < sigma_mm < math.inf:
            raise InputError(f"the gap that contacts may open must be a positive number of mm, got {sigma_mm:g}")

    @classmethod
    def of(cls, tack_mm: float | None, tack_mrad: float | None, groups: tuple[BodyGroup, ...] = ()) -> BodiesOptions:
        """Return the options for tolerances that a person states; None: not stated.

        Raises `InputError` when a tolerance is not positive.
        """
        usual = TackTolerance()
        tolerance = TackTolerance(
            usual.mm if tack_mm is None else tack_mm, usual.mrad if tack_mrad is None else tack_mrad
        )
        of_groups = any(group.tolerance is not None for group in groups)
        return cls(tolerance, of_groups or tack_mm is not None or tack_mrad is not None, groups)


def read_bodies(path: Path) -> tuple[BodyGroup, ...]:
    """Read a file of bodies: ``{"schema": "wpcal/bodies/1", "bodies": [{"name", "solids", "tack_mm", "tack_mrad"}]}``.

    Raises `FormatError` when the file breaks its schema, or a tolerance is not positive.
    """
    record = read_json(path, schema=BODIES_SCHEMA)
    usual = TackTolerance()
    entries, groups = record.get("bodies"), list[BodyGroup]()
    _refuse_unknown(record, ("schema", "bodies"), "the file", path)
    if not entries:
        raise FormatError("names no body; expected a list bodies with at least one", path=str(path))
    for number, entry in enumerate(entries, 1):
        name = entry.get("name")
        if not name:
            raise FormatError(f"body {number} has no name", path=str(path))
        _refuse_unknown(entry, KNOWN, f"body {name}", path)
        if any(group.name == name for group in groups):
            raise FormatError(f"body {name} is there twice: list all its solids once", path=str(path))
        tolerance = None
        if "tack_mm" in entry or "tack_mrad" in entry:
            try:
                tolerance = TackTolerance(entry.get("tack_mm", usual.mm), entry.get("tack_mrad", usual.mrad))
            except InputError as error:
                raise FormatError(f"body {name}: {error}", path=str(path)) from None
        groups.append(BodyGroup(name, tuple(entry.get("solids", [name])), tolerance))
    return tuple(groups)


def _refuse_unknown(record: dict[str, Any], known: tuple[str, ...], where: str, path: Path) -> None:
    unknown = [name for name in record if name not in known]
    if unknown:
        raise FormatError(f"{where} has {listed(unknown)}; expected {', '.join(known)}", path=str(path))


@dataclass(frozen=True, slots=True, eq=False)
class PartBodies:
    """The bodies of a part."""

    bodies: Bodies
    face_body: IntArray  #: shape (F,). The body of every face.


def find_bodies(trimmed: TrimmedFaces, options: BodiesOptions) -> PartBodies:
    """Divide a part into bodies: its solids or groups of them; a part of one solid at its concave edges.

    Returns PartBodies. In the order of the solids.

    Raises `InputError` when a group names no solid of the part, or two groups name the same one, or the part is one
    body, or no body can bend that is asked to.
    """
    units, face_unit = units_of(trimmed)
    body_of_unit, names, tolerances = _grouped(units, options)
    face_body = body_of_unit[face_unit]
    if len(names) < 2:
        raise InputError(_one_body(trimmed.graph, options))
    faces = [np.flatnonzero(face_body == body) for body in range(len(names))]
    borders = [_border(trimmed, own) for own in faces]
    boxes = [(p.min(axis=0) + p.max(axis=0)) / 2.0 for p in borders]
    bends = Bends.none()
    if options.bending_mm is not None:
        graph = trimmed.graph
        planes = [own[graph.face_kind[own] == SurfaceKind.PLANE] for own in faces]
        bends = find_bends(borders, [graph.face_frame[own, 3] for own in planes], options.bending_mm)
    return PartBodies(Bodies(tuple(names), np.stack(boxes), tuple(tolerances), bends), face_body)


def _one_body(graph: BrepGraph, options: BodiesOptions) -> str:
    what = "the part is one body: nothing can have moved in it"
    if options.groups:
        return f"{what}; put its solids into two bodies or more"
    return f"{what}; no concave edges divide its one solid (a face that runs over two plates joins them)"


def units_of(trimmed: TrimmedFaces) -> tuple[tuple[str, ...], IntArray]:
    """Return what can move by itself: the solids, or the members of a part of one solid.

    Returns `face_unit`: ndarray of int, shape (F,).
    """
    graph = trimmed.graph
    if len(graph.solid_names) > 1:
        return graph.solid_names, graph.face_solid
    return find_members(trimmed)


def _grouped(solids: Sequence[str], options: BodiesOptions) -> tuple[IntArray, list[str], list[TackTolerance]]:
    group_of: dict[int, BodyGroup] = {}
    for group in options.groups:
        found = [i for i, solid in enumerate(solids) if any(_is_named(solid, pattern) for pattern in group.solids)]
        if not found:
            raise InputError(
                f"body {group.name}: the part has no solid {', '.join(group.solids)}; it has {_few(solids)}"
            )
        for i in found:
            if i in group_of:
                raise InputError(f"solid {solids[i]} is in two bodies: {group_of[i].name} and {group.name}")
            group_of[i] = group
    taken = {group.name for group in options.groups}
    names: list[str] = []
    tolerances: list[TackTolerance] = []
    body = np.zeros(len(solids), dtype=np.int64)
    for i, solid in enumerate(solids):
        own = group_of.get(i, BodyGroup(solid, (solid,)))
        if i not in group_of and solid in taken:
            raise InputError(
                f"body {solid} does not hold the solid {solid}, which is in no body: give the body another name, or "
                "list the solid"
            )
        name = own.name
        if name not in names:
            names.append(name)
            tolerances.append(own.tolerance or options.tolerance)
        body[i] = names.index(name)
    return body, names, tolerances


def _is_named(solid: str, pattern: str) -> bool:
    """Whether a name is the one given; * and ? match any letters, and a bracket is a bracket."""
    return solid == pattern or fnmatchcase(solid, pattern.replace("[", "[[]"))


def _border(trimmed: TrimmedFaces, faces: IntArray) -> FloatArray:
    """Return points of the faces' borders, shape (k, 3), mm."""
    rows = np.concatenate([np.arange(trimmed.start[f], trimmed.start[f + 1]) for f in faces.tolist()])
    return np.asarray(trimmed.p0[rows] if len(rows) else trimmed.graph.face_frame[faces, 0])


def _few(names: Sequence[str]) -> str:
    more = f" and {len(names) - 5} more" if len(names) > 5 else ""
    return ", ".join(names[:5]) + more
