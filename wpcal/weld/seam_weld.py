"""The weld in one seam: its values, each with where it came from, its beads and its stretches.

What a person states counts first, then what a file states, then the rules. Passes, wire feed and speed follow from the
section of the weld unless they are stated: the wire that is fed fills it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from wpcal.core.errors import InputError
from wpcal.core.result_files import PART_FILE
from wpcal.seam.seam import JointType, Seam, SeamSource, WeldType
from wpcal.weld.groove import Groove
from wpcal.weld.passes import Bead, place_beads
from wpcal.weld.place import SeamPlace, StatedWeld
from wpcal.weld.rules import Case, Row, RuleTable
from wpcal.weld.section import Section, section_of
from wpcal.weld.values import WeldKind, WeldValues, require_one_size, stretches, values_from_record

RECOVERY = 0.95  #: Share of a solid wire that becomes weld: a few percent are lost as spatter and fume.
BOTH_SIDES_MM = 5.0  #: A thicker square butt is welded from both sides, so one side does not fill its whole depth.


class Source(Enum):
    """Where a value came from."""

    RULE = "rule"
    FILE = "file"
    MODEL = "model"
    USER = "user"


@dataclass(frozen=True, slots=True)
class Origin:
    """Where one value came from."""

    source: Source
    of: str  #: The rule or the file; empty for the user. The model is measured in ``part.glb``.
    given: Any  #: The value as it came, as JSON holds it. If a file holds another one, a person changed it.


@dataclass(frozen=True, slots=True)
class SeamWeld:
    """The weld in one seam."""

    name: str  #: Of the seam.
    place: SeamPlace  #: By which the seam is recognised under another name.
    #: `joint`, `weld`: Of the seam.
    joint: JointType
    weld: WeldType
    values: WeldValues
    #: By the name of a value: where it came from. A value that a person set to none has an origin, too.
    origins: Mapping[str, Origin]
    beads: tuple[Bead, ...] = ()  #: In the order of welding; empty if the section is not known, or for a single bead.
    #: `stretches_mm`, `tacks_mm`: Welded stretches and tack welds: lengths from the start of the seam.
    stretches_mm: tuple[tuple[float, float], ...] = ()
    tacks_mm: tuple[tuple[float, float], ...] = ()

    @property
    def by_user(self) -> dict[str, Any]:
        """The values that a person stated, as JSON holds them; null for one that was set to none."""
        return {name: origin.given for name, origin in self.origins.items() if origin.source is Source.USER}


@dataclass(slots=True)
class _Draft:
    """Values under construction."""

    given: dict[str, Any] = field(default_factory=dict)
    origins: dict[str, Origin] = field(default_factory=dict)

    def put(self, name: str, value: Any, source: Source, of: str) -> None:
        """State a value that nothing states yet."""
        if name not in self.origins:
            self.given[name] = value
            self.origins[name] = Origin(source, of, value)

    def is_stated(self, *names: str) -> bool:
        return any(self.given.get(name) is not None for name in names)


def weld_for(
    seam: Seam,
    place: SeamPlace,
    stated: StatedWeld,
    rules: RuleTable,
    *,
    first_side: int = -1,
    groove: Groove | None = None,
) -> SeamWeld:
    """Find the values of the weld in a seam at a place.

    Raises `InputError` if values contradict each other, or a stitch does not fit on the seam. The message begins with
    the weld.
    """
    what = f"weld {seam.name}"
    draft = _stated_values(stated, seam, groove)
    case = Case(seam.joint, seam.weld, draft.given.get("thickness_mm"), draft.given.get("position"))
    speed_row = _take_rules(draft, rules.values_for(case))
    _take_depth(draft, seam)
    values = values_from_record(draft.given, what=what)
    angle = float(np.median(seam.frames.angle_rad)) if len(seam.frames) else math.pi / 2.0
    section = section_of(values, joint=seam.joint, weld=seam.weld, normals_rad=angle, groove=groove)
    _take_passes(draft, section, rules, case)
    _take_speed(draft, section, speed_row)
    values = values_from_record(draft.given, what=what)
    require_one_size(values, what=what)
    try:
        passes = values.passes or 1
        is_placed = passes > 1 or groove is not None  # the one bead of a measured groove is at its root, too
        beads = place_beads(section, passes, first_side=first_side) if section is not None and is_placed else ()
        runs = stretches(values.stitch, seam.length_mm, closed=seam.closed)
        tacks = _tacks(values, seam)
    except InputError as error:
        raise InputError(f"{what}: {error}") from None
    if section is None and passes > 1:
        raise InputError(
            f"{what}: passes {passes}: the section of this weld is not known, so beads cannot be placed; state its "
            "size (leg_mm or throat_mm of a fillet; depth_mm and root_gap_mm or groove_angle_deg of a butt weld)"
        )
    return SeamWeld(seam.name, place, seam.joint, seam.weld, values, draft.origins, beads, runs, tacks)


def _stated_values(stated: StatedWeld, seam: Seam, groove: Groove | None) -> _Draft:
    """Return what a person, files and the model state; the first of them counts."""
    draft = _Draft()
    for name, value in stated.user.items():
        draft.put(name, value, Source.USER, "")
    for name, (value, file) in stated.files.items():
        if not _is_other_size(name, draft):
            draft.put(name, value, Source.FILE, file)
    for name, value in ({} if groove is None else groove.values()).items():
        draft.put(name, value, Source.MODEL, PART_FILE)
    if seam.bead_mm is not None and seam.source is SeamSource.DRAWN and not _is_other_size("throat_mm", draft):
        draft.put("throat_mm", seam.bead_mm, Source.MODEL, PART_FILE)
    return draft


def _tacks(values: WeldValues, seam: Seam) -> tuple[tuple[float, float], ...]:
    """Return the tack welds of a seam: lengths from its start."""
    if values.tacks is None:
        return ()
    if values.tacks.length_mm >= seam.length_mm:
        what = (
            f"{values.tacks.length_mm:g} mm is as long as the seam of {seam.length_mm:.1f} mm; expected shorter welds"
        )
        raise InputError(f"tacks: {what}")
    return stretches(values.tacks, seam.length_mm, closed=seam.closed)


def _is_other_size(name: str, draft: _Draft) -> bool:
    """Tell whether a fillet has the other one of its two sizes already."""
    other = {"throat_mm": "leg_mm", "leg_mm": "throat_mm"}.get(name)
    return other is not None and draft.is_stated(other)


def _take_rules(draft: _Draft, found: Mapping[str, tuple[Any, Row]]) -> Row | None:
    """Take what rules state, except the speed, which follows from the section. Return the row that states a speed."""
    for name, (value, row) in found.items():
        if name != "speed_mm_s" and not _is_other_size(name, draft):
            draft.put(name, value, Source.RULE, row.name)
    return found["speed_mm_s"][1] if "speed_mm_s" in found else None


def _take_depth(draft: _Draft, seam: Seam) -> None:
    thickness = draft.given.get("thickness_mm")
    if seam.weld is not WeldType.GROOVE or seam.joint is not JointType.BUTT or thickness is None:
        return
    if draft.given.get("weld") != WeldKind.SQUARE.value or thickness <= BOTH_SIDES_MM:
        draft.put("depth_mm", thickness, Source.RULE, "the thickness of the thinner plate")


def _take_passes(draft: _Draft, section: Section | None, rules: RuleTable, case: Case) -> None:
    most = rules.most_bead(case)
    if section is None or most is None:
        draft.put("passes", 1, Source.RULE, "one bead")
        return
    largest, row = most
    count = max(1, math.ceil(section.area_mm2 / largest - 1e-9))
    draft.put("passes", count, Source.RULE, f"{section.area_mm2:.1f} mm² / {largest:g} mm² of {row.name}")


def _take_speed(draft: _Draft, section: Section | None, row: Row | None) -> None:
    """State wire feed and speed: the wire that is fed fills the section of a bead."""
    speed = None if row is None else row.values["speed_mm_s"]
    wire = draft.given.get("wire_mm")
    bead = _bead_mm2(draft, section, row)
    wire_mm2 = None if wire is None else math.pi / 4.0 * wire * wire * RECOVERY
    if wire_mm2 is not None and "wire_feed_m_min" not in draft.origins:
        stated = draft.given.get("speed_mm_s")
        if stated is not None and bead is not None:
            draft.put("wire_feed_m_min", _feed(bead, stated, wire_mm2), Source.RULE, "fills the section at this speed")
        elif row is not None and speed is not None and row.bead_mm2 is not None:
            draft.put("wire_feed_m_min", _feed(row.bead_mm2, speed, wire_mm2), Source.RULE, row.name)
    feed = draft.given.get("wire_feed_m_min")
    origin = draft.origins.get("wire_feed_m_min")
    is_of_row = row is not None and origin is not None and origin.of == row.name and bead == row.bead_mm2
    if feed and bead and wire_mm2 and not is_of_row:
        filling = round(feed * 1000.0 / 60.0 * wire_mm2 / bead, 1)
        draft.put("speed_mm_s", max(filling, 0.1), Source.RULE, "the wire feed fills the section")
    elif row is not None and speed is not None:
        draft.put("speed_mm_s", speed, Source.RULE, row.name)


def _bead_mm2(draft: _Draft, section: Section | None, row: Row | None) -> float | None:
    """Return the section of one bead.

    A square butt is made by penetration and reinforcement: its bead is never smaller than that of the rules, however
    narrow the gap is. Otherwise a narrow gap would ask for a speed at which nothing melts through.
    """
    bead = None if section is None else section.area_mm2 / (draft.given.get("passes") or 1)
    if draft.given.get("weld") != WeldKind.SQUARE.value or row is None or row.bead_mm2 is None:
        return bead
    return max(bead or 0.0, row.bead_mm2)


def _feed(bead_mm2: float, speed_mm_s: float, wire_mm2: float) -> float:
    """Return the wire feed that fills a bead, m/min."""
    return round(bead_mm2 * speed_mm_s / wire_mm2 * 60.0 / 1000.0, 1)
