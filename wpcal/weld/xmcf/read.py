"""Read weld seams of an xMCF file (ISO/PAS 8329): lines, types, thicknesses, gaps, angles and stitches.

A file holds connections between parts. A connection along a line (``connection_1d``) with a ``seamweld`` is a weld
seam. Adhesive lines, spot welds, bolts and everything else is left out. Lengths become millimetres and angles degrees.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from wpcal.core.arrays import LARGEST_MM, FloatArray, frozen
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import parse_number
from wpcal.weld.values import Stitch

LENGTHS_MM = {"mm": 1.0, "m": 1000.0, "in": 25.4, "ft": 304.8}
"""The lengths that a file may be in; without a word it is in millimetres."""
ANGLES_DEG = {"deg": 1.0, "rad": math.degrees(1.0)}
"""The angles that a file may be in; without a word it is in degrees."""
TYPES = (
    "butt_joint",
    "corner_weld",
    "edge_weld",
    "i_weld",
    "overlap_weld",
    "y_joint",
    "k_joint",
    "cruciform_joint",
    "flared_joint",
)
"""The types of seams in a file."""
EVEN_MM = 1e-3  #: Segments of a list whose lengths and distances differ by less are stitches.


@dataclass(frozen=True, slots=True)
class WeldSide:
    """The weld at one side of a joint."""

    toward: tuple[float, float, float]  #: Direction in which the side is, as the file states it.
    section: str  #: Its word for the preparation: ``Fillet``, ``V``, ``HY``; empty if there is none.
    throat_mm: float | None
    width_mm: float | None
    angle_deg: float | None
    stitch: Stitch | None  #: None: the whole length.
    #: Whether it has a list of segments of different lengths or distances, which `stitch` does not hold.
    is_uneven: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class XmcfSeam:
    """One weld seam of a file."""

    label: str  #: As in the file; ``seam 3`` if it has none.
    kind: str  #: One of `TYPES`; empty if the file does not say.
    technology: str  #: ``arc``, ``laser``, …; empty if the file does not say.
    lines_mm: tuple[FloatArray, ...]  #: shape (n, 3). Points along its stretches, in the coordinates of the parts.
    parts: tuple[str, ...]  #: Labels of the parts that it joins.
    sides: tuple[WeldSide, ...]
    #: `thicknesses_mm`, `gaps_mm`: Of the sheets, where the file states them.
    thicknesses_mm: tuple[float, ...]
    gaps_mm: tuple[float, ...]

    @property
    def length_mm(self) -> float:
        """Length of its stretches together, mm."""
        return float(sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in self.lines_mm))


def read_xmcf(path: Path) -> tuple[XmcfSeam, ...]:
    """Read the weld seams of a file.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not xMCF, or a number or a unit cannot be used. The message names the line of the
    XML or the seam.
    """
    return parse_xmcf(read_bytes(path), path=str(path))


def parse_xmcf(raw: bytes, *, path: str) -> tuple[XmcfSeam, ...]:
    """Return the weld seams that the bytes of a file hold. Raises `FormatError` as `read_xmcf` does."""
    try:
        root = ET.fromstring(raw)
    except ET.ParseError as error:
        line, column = error.position
        raise FormatError(f"is not XML: {error.msg}", path=path, line=line, column=column) from None
    except (LookupError, ValueError):
        raise FormatError("is not XML: its encoding is not known", path=path) from None
    if root.tag != "xmcf":
        raise FormatError(f"expected an xMCF file (root element xmcf), found {root.tag[:60]}", path=path)
    try:
        units = _Units.of(root.find("units"))
        return tuple(_seams(root, units))
    except InputError as error:
        raise FormatError(str(error), path=path) from None


def places_of(seams: Sequence[XmcfSeam], *, file: str) -> tuple[str, ...]:
    """Return a place on every segment of welds, as a person picks edges: ``x,y,z``, mm.

    Raises `InputError` if there is no weld seam.
    """
    if not seams:
        raise InputError(f"{file}: has no weld seam")
    lines = (line for seam in seams for line in seam.lines_mm)
    middles = ((a + b) / 2.0 for line in lines for a, b in pairwise(line))
    return tuple(dict.fromkeys(",".join(f"{value:.6f}" for value in middle) for middle in middles))


@dataclass(frozen=True, slots=True)
class _Units:
    mm: float
    deg: float

    @classmethod
    def of(cls, element: ET.Element | None) -> _Units:
        given = {} if element is None else element.attrib
        length, angle = given.get("length", "mm"), given.get("angle", "deg")
        if length not in LENGTHS_MM or angle not in ANGLES_DEG:
            raise InputError(f"units: expected mm, m, in or ft, and deg or rad; got {length!r}, {angle!r}")
        return cls(LENGTHS_MM[length], ANGLES_DEG[angle])


def _seams(root: ET.Element, units: _Units) -> Iterator[XmcfSeam]:
    number = 0
    for group in root.iter("connection_group"):
        parts = tuple(_first(each, "label", "pid", "index") for each in group.iterfind("connected_to/*"))
        for connection in group.iterfind("connection_list/connection_1d"):
            weld = connection.find("seamweld")
            if weld is None:
                continue
            number += 1
            label = _first(connection, "label", "ident") or f"seam {number}"
            try:
                yield _seam(connection, weld, units, label, parts)
            except InputError as error:
                raise InputError(f"seam {label}: {error}") from None


def _first(element: ET.Element, *names: str) -> str:
    """Return the first attribute that is stated; empty if there is none."""
    return next(filter(None, map(element.get, names)), "")


def _seam(connection: ET.Element, weld: ET.Element, units: _Units, label: str, parts: tuple[str, ...]) -> XmcfSeam:
    joint = next(iter(weld), None)
    kind = "" if joint is None else joint.tag
    if kind and kind not in TYPES:
        raise InputError(f"expected one of {', '.join(TYPES)}, got {kind[:60]}")
    lines = tuple(_line(each, units) for each in connection.iterfind("loc_list"))
    if not lines:
        raise InputError("has no points (loc_list)")
    sheets = [] if joint is None else list(joint.iterfind("sheet_parameter"))
    sides = () if joint is None else tuple(_side(each, units) for each in joint.iterfind("weld_position"))
    return XmcfSeam(
        label,
        kind,
        "" if joint is None else joint.get("technology", ""),
        lines,
        parts,
        sides,
        _of_sheets(sheets, "sheet_thickness", units.mm),
        _of_sheets(sheets, "gap", units.mm),
    )


def _line(element: ET.Element, units: _Units) -> FloatArray:
    """Return the points of one stretch in the order of their parameter v."""
    rows = []
    for loc in element.iterfind("loc"):
        cells = (loc.text or "").split()
        if len(cells) != 3:
            raise InputError(f"loc: expected three numbers, got {(loc.text or '').strip()[:60]!r}")
        rows.append((_number(loc, "v") or 0.0, [_value(cell, "loc") * units.mm for cell in cells]))
    if len(rows) < 2:
        raise InputError(f"loc_list: expected at least two points, got {len(rows)}")
    points = np.array([p for _, p in sorted(rows, key=lambda row: row[0])])
    if np.abs(points).max() > LARGEST_MM:
        raise InputError(f"loc: expected coordinates of at most {LARGEST_MM:g} mm")
    return frozen(points)


def _side(element: ET.Element, units: _Units) -> WeldSide:
    x, y, z = (_number(element, axis) or 0.0 for axis in "xyz")
    throat, width, angle = (_number(element, name) for name in ("thickness", "width", "angle"))
    stitch, is_uneven = _stitch(element, units)
    return WeldSide(
        (x, y, z),
        element.get("section", ""),
        None if throat is None else throat * units.mm,
        None if width is None else width * units.mm,
        None if angle is None else angle * units.deg,
        stitch,
        is_uneven,
    )


def _stitch(element: ET.Element, units: _Units) -> tuple[Stitch | None, bool]:
    """Return the stitches of a side, and whether it has segments that are none."""
    regular = element.find("regular_segments")
    if regular is not None:
        length, spacing = _number(regular, "length"), _number(regular, "spacing")
        if not length or spacing is None or min(length, spacing) < 0.0:
            raise InputError("regular_segments: expected a length and a spacing above 0")
        first = _number(regular, "first_spacing")
        offset = None if first is None else first * units.mm
        return Stitch(length * units.mm, (length + spacing) * units.mm, offset), False
    listed = element.find("segment_list")
    if listed is None or len(listed) == 0:
        return None, False
    ends = np.array([[_number(one, "from") or 0.0, _number(one, "to") or 0.0] for one in listed]) * units.mm
    lengths, pitches = ends[:, 1] - ends[:, 0], np.diff(ends[:, 0])
    if lengths.min() <= 0.0:
        raise InputError("segment_list: a segment ends before it begins")
    if np.ptp(lengths) > EVEN_MM or (len(pitches) and np.ptp(pitches) > EVEN_MM):
        return None, True
    pitch = float(pitches[0]) if len(pitches) else float(ends[0, 1] + lengths[0])
    return Stitch(float(lengths[0]), pitch, float(ends[0, 0])), False


def _of_sheets(sheets: list[ET.Element], name: str, unit: float) -> tuple[float, ...]:
    values = (_number(sheet, name) for sheet in sheets)
    return tuple(value * unit for value in values if value is not None)


def _number(element: ET.Element, name: str) -> float | None:
    text = element.get(name)
    return None if text is None else _value(text, f"{element.tag} {name}")


def _value(text: str, what: str) -> float:
    try:
        value = parse_number(text.strip())
    except InputError as error:
        raise InputError(f"{what}: {error}") from None
    if not abs(value) <= LARGEST_MM:
        raise InputError(f"{what}: expected a number of at most {LARGEST_MM:g}, got {text.strip()[:60]}")
    return value
