"""The values of one weld: size, process, current, speed, weave, stitches, and names of data in the controller.

Every value may be missing (None): then nothing states it, and a program leaves it to the controller.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields
from difflib import get_close_matches
from enum import Enum
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.wording import listed


class WeldKind(Enum):
    """The weld in words of ISO 2553, without its symbol."""

    FILLET = "fillet weld"
    SQUARE = "square butt weld"
    SINGLE_V = "single-V butt weld"
    SINGLE_BEVEL = "single-bevel butt weld"
    DOUBLE_V = "double-V butt weld"
    DOUBLE_BEVEL = "double-bevel butt weld"
    FLARE_V = "flare-V weld"
    FLARE_BEVEL = "flare-bevel weld"


PREPARATIONS: Mapping[WeldKind, str] = {
    WeldKind.SINGLE_V: "V",
    WeldKind.SINGLE_BEVEL: "HV",
    WeldKind.DOUBLE_V: "X",
    WeldKind.DOUBLE_BEVEL: "K",
}
"""Letters of the grooves of butt welds, as files of other programs state them."""

ROUND_OFF = 1e-9  #: Relative: a last stretch that ends at the end of the seam is not lost to it.
MOST_STRETCHES = 10_000  #: More stretches on one seam are a mistake: a pitch in metres, for example.


class WeaveShape(Enum):
    """The path of the wire across the seam."""

    ZIGZAG = "zigzag"
    SINE = "sine"
    TRIANGLE = "triangle"
    CIRCLE = "circle"


@dataclass(frozen=True, slots=True)
class Weave:
    """How the wire swings across the seam."""

    shape: WeaveShape
    width_mm: float  #: From side to side.
    length_mm: float  #: Along the seam, per swing to and fro.
    #: `dwell_left_s`, `dwell_right_s`: Pause at the side of +y and at that of -y of the seam.
    dwell_left_s: float = 0.0
    dwell_right_s: float = 0.0

    def frequency_hz(self, speed_mm_s: float) -> float:
        """Swings to and fro per second at a speed along the seam."""
        return speed_mm_s / self.length_mm


@dataclass(frozen=True, slots=True)
class Crater:
    """How the crater at the end is filled before the arc ends."""

    time_s: float
    #: `current_a`, `voltage_v`: None: those of the weld.
    current_a: float | None = None
    voltage_v: float | None = None


@dataclass(frozen=True, slots=True)
class Stitch:
    """Stretches of one length, at one distance: ISO 2553 writes n × l (e) with e = pitch - length.

    Only whole ones are laid. Around a closed seam the pitch grows a little, so that they are at equal distances.
    """

    length_mm: float  #: Of each stretch.
    pitch_mm: float  #: From the start of a stretch to the start of the next.
    #: From the start of the seam to the first stretch. None: the same length is left free at both ends.
    offset_mm: float | None = None


@dataclass(frozen=True, slots=True)
class WeldValues:
    """The values of one weld; None where nothing states one."""

    thickness_mm: float | None = None  #: Of the thinner plate.
    position: str | None = None  #: ``PA`` … ``PG`` (ISO 6947).
    weld: WeldKind | None = None
    #: `throat_mm`, `leg_mm`: Size of a fillet, a or z of ISO 2553; one of the two.
    throat_mm: float | None = None
    leg_mm: float | None = None
    depth_mm: float | None = None  #: Of a butt weld, from its face to its root: s of ISO 2553.
    #: `root_gap_mm`, `root_face_mm`: b and c of ISO 2553.
    root_gap_mm: float | None = None
    root_face_mm: float | None = None
    groove_angle_deg: float | None = None  #: Between both sides of the groove.
    process: str | None = None  #: Number of ISO 4063: ``135`` is MAG with solid wire.
    wire_mm: float | None = None  #: Diameter of the wire.
    passes: int | None = None  #: Number of beads.
    #: Job of the power source, or number of the schedule or of the file of conditions in the controller.
    job: int | None = None
    #: `seam_data`, `weld_data`, `weave_data`: Names of data in the controller, instead of values.
    seam_data: str | None = None
    weld_data: str | None = None
    weave_data: str | None = None
    #: `current_a`, `voltage_v`, `wire_feed_m_min`, `speed_mm_s`: Of every bead.
    current_a: float | None = None
    voltage_v: float | None = None
    wire_feed_m_min: float | None = None
    speed_mm_s: float | None = None
    #: Free wire from the contact tip to the seam, for which the tool centre point is taught.
    stick_out_mm: float | None = None
    #: `work_angle_deg`, `travel_angle_deg`: Of the torch: from the bisector, positive towards y; positive is push.
    work_angle_deg: float | None = None
    travel_angle_deg: float | None = None
    #: `start_delay_s`, `end_delay_s`: The arc burns before the torch moves, and after it has stopped.
    start_delay_s: float | None = None
    end_delay_s: float | None = None
    weave: Weave | None = None
    crater: Crater | None = None
    stitch: Stitch | None = None  #: None: the whole seam is welded.
    tacks: Stitch | None = None  #: None: no tack welds.

    def to_record(self) -> dict[str, Any]:
        """Return names and values as JSON holds them, without those that nothing states."""
        return {name: plain(getattr(self, name)) for name in VALUE_NAMES if getattr(self, name) is not None}


VALUE_NAMES = tuple(field.name for field in fields(WeldValues))  #: Every name of a value, in the order of files.


def refuse_unknown(names: Mapping[str, Any], known: tuple[str, ...], *, what: str) -> None:
    """Refuse a mapping with a name that is not known: a misspelt value would be lost silently.

    Raises `InputError` with the nearest known name.
    """
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, n=1)
            raise InputError(f"{what}: unknown name {name!r}{f'; did you mean {near[0]}?' if near else ''}")


def values_from_record(record: Mapping[str, Any], *, what: str) -> WeldValues:
    """Return the values that a record holds, whose types and ranges were checked (`wpcal.core.record_check`).

    Raises `InputError` if a name is unknown, or a weave, crater or stitch lacks a value.
    """
    refuse_unknown(record, VALUE_NAMES, what=what)
    parts: Mapping[str, Callable[[Any], Any]] = {
        "weave": _weave,
        "crater": lambda record: Crater(float(record["time_s"]), record.get("current_a"), record.get("voltage_v")),
        "stitch": _stitch,
        "tacks": _stitch,
        "weld": WeldKind,
    }
    given = {name: value for name, value in record.items() if value is not None}
    try:
        return WeldValues(**{name: parts[name](value) if name in parts else value for name, value in given.items()})
    except KeyError as error:
        raise InputError(f"{what}: a weave, crater or stitch lacks {error.args[0]}") from None


def plain(value: Any) -> Any:
    """Return one value as JSON holds it."""
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, Weave | Crater | Stitch):
        return {name: plain(part) for name, part in asdict(value).items() if part is not None}
    return value


def _weave(record: Mapping[str, Any]) -> Weave:
    dwells = {name: float(record[name]) for name in ("dwell_left_s", "dwell_right_s") if name in record}
    return Weave(WeaveShape(record["shape"]), float(record["width_mm"]), float(record["length_mm"]), **dwells)


def _stitch(record: Mapping[str, Any]) -> Stitch:
    return Stitch(float(record["length_mm"]), float(record["pitch_mm"]), record.get("offset_mm"))


def describe_weld(values: WeldValues) -> str:
    """Return a weld in the words and letters of ISO 2553: ``a4 fillet weld, 3 × 50 (50), 135, PB``.

    >>> describe_weld(WeldValues(weld=WeldKind.FILLET, throat_mm=4.0, process="135", position="PB"))
    'a4 fillet weld, process 135, PB'
    """
    size = ""
    if values.leg_mm is not None:
        size = f"z{values.leg_mm:.3g} "
    elif values.throat_mm is not None:
        size = f"a{values.throat_mm:.3g} "
    elif values.depth_mm is not None:
        size = f"s{values.depth_mm:.3g} "
    words = [f"{size}{values.weld.value if values.weld else 'weld'}"]
    if values.passes is not None and values.passes > 1:
        words.append(f"{values.passes} passes")
    if values.stitch is not None:
        free = values.stitch.pitch_mm - values.stitch.length_mm
        words.append(f"stitches {values.stitch.length_mm:g} ({free:g})")
    if values.process is not None:
        words.append(f"process {values.process}")
    if values.position is not None:
        words.append(values.position)
    return ", ".join(words)


def require_one_size(values: WeldValues, *, what: str) -> None:
    """Refuse a fillet with a throat and a leg: one of them decides. Raises `InputError` if both are stated."""
    if values.throat_mm is not None and values.leg_mm is not None:
        sizes = listed([f"throat_mm {values.throat_mm:g}", f"leg_mm {values.leg_mm:g}"])
        raise InputError(f"{what}: gives {sizes}; expected one of the two")


def stretches(stitch: Stitch | None, length_mm: float, *, closed: bool = False) -> tuple[tuple[float, float], ...]:
    """Return where a seam is welded: lengths from its start, mm, in order.

    Raises `InputError` if the pitch is shorter than the stretch, the offset leaves no room for one, or there are more
    than 10 000.

    >>> stretches(Stitch(50.0, 100.0), 300.0)
    ((25.0, 75.0), (125.0, 175.0), (225.0, 275.0))
    """
    if stitch is None:
        return ((0.0, length_mm),)
    length, pitch, offset = stitch.length_mm, stitch.pitch_mm, stitch.offset_mm
    if pitch < length:
        raise InputError(f"stitch: the pitch of {pitch:g} mm is shorter than the stretch of {length:g} mm")
    if offset is None and length >= length_mm:
        return ((0.0, length_mm),)
    room = length_mm - (offset or 0.0)
    if room < length:
        what = f"an offset of {offset:g} mm leaves no room for {length:g} mm on a seam of {length_mm:.1f} mm"
        raise InputError(f"stitch: {what}")
    fits = room / pitch if closed else (room - length) / pitch + 1.0
    count = max(1, math.floor(fits * (1.0 + ROUND_OFF)))
    if count > MOST_STRETCHES:
        raise InputError(f"stitch: a pitch of {pitch:g} mm makes {count} stretches on a seam of {length_mm:.1f} mm")
    if closed and offset is None:
        pitch = length_mm / count
    first = max(0.0, (length_mm - (count - 1) * pitch - length) / 2.0) if offset is None else offset
    return tuple((first + k * pitch, min(first + k * pitch + length, length_mm)) for k in range(count))
