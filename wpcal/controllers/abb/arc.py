r"""ArcWare data of a seam: ``seamdata``, ``welddata``, ``weavedata``, with values or named as on the controller.

``seamdata``: purge, preflow, ignition (arc data, delay, scrape start), heat (speed, time, distance, arc data), cooling
and filling (time, arc data), burn back, roll back (time, arc data), postflow. Arc data are schedule, mode, voltage,
wire feed, control, current, and three more. ``welddata``: speed, the same as first set, main arc data, the same again.
``weavedata``: shape, type, length, width, height, three dwells as lengths, direction, tilt, orientation, bias, and
three as first set. Units are those of the usual SI setting: mm, mm/s, V, A, wire feed in mm/s.

References: ABB, ArcWare product manuals: seamdata, welddata, weavedata, ArcLStart, ArcL, ArcC, ArcLEnd, ArcCEnd.
"""

from __future__ import annotations

from dataclasses import dataclass

from wpcal.controllers.language.naming import NameRules, own_name
from wpcal.controllers.program import WeldPath
from wpcal.controllers.program.arc import end_time_s
from wpcal.weld.values import WeaveShape, WeldValues

SHAPES = {WeaveShape.ZIGZAG: 1, WeaveShape.SINE: 1, WeaveShape.TRIANGLE: 3, WeaveShape.CIRCLE: 4}
"""Numbers of weave shapes; a zigzag is the nearest to a sine."""
NO_ARC = "[0,0,0,0,0,0,0,0,0]"
GAS_S = 0.5  #: Preflow and postflow of the gas, where the data are declared here: usual times of MAG.


@dataclass(frozen=True, slots=True)
class ArcData:
    """The data of one seam."""

    #: `seam`, `weld`: Names.
    seam: str
    weld: str
    weave: str  #: Name; empty without a weave.
    declared: tuple[str, ...]  #: Lines that declare those which the controller does not have.

    @property
    def text(self) -> str:
        r"""The arguments of an arc instruction: ``seam,weld\Weave:=weave``."""
        both = f"{self.seam},{self.weld}"
        return f"{both}\\Weave:={self.weave}" if self.weave else both


def arc_data(path: WeldPath, stem: str, speed_mm_s: float, rules: NameRules) -> ArcData:
    """Return the data of a seam. Raises `InputError` when RAPID does not allow the name of data that the user gave."""
    values, lines = path.values, list[str]()
    seam = _named(values.seam_data, "seam_data", rules)
    if not seam:
        seam = f"sm_{stem}"
        lines.append(f"  LOCAL PERS seamdata {seam}:={_seamdata(path)};")
    weld = _named(values.weld_data, "weld_data", rules)
    if not weld:
        weld = f"wd_{stem}"
        main = _arc(values.job, values.voltage_v, values.wire_feed_m_min, values.current_a)
        lines.append(f"  LOCAL PERS welddata {weld}:=[{speed_mm_s:g},0,{main},{NO_ARC}];")
    weave = _named(values.weave_data, "weave_data", rules)
    if not weave and values.weave is not None:
        weave = f"wv_{stem}"
        lines.append(f"  LOCAL PERS weavedata {weave}:={_weavedata(values, speed_mm_s)};")
    return ArcData(seam, weld, weave, tuple(lines))


def _named(name: str | None, what: str, rules: NameRules) -> str:
    return "" if name is None else own_name(name, rules, what=what)


def _arc(job: int | None, voltage_v: float | None, wire_feed_m_min: float | None, current_a: float | None) -> str:
    feed_mm_s = round((wire_feed_m_min or 0.0) * 1000.0 / 60.0, 1)
    return f"[{job or 0},0,{voltage_v or 0:g},{feed_mm_s:g},0,{current_a or 0:g},0,0,0]"


def _seamdata(path: WeldPath) -> str:
    values, crater = path.values, path.values.crater
    fill = NO_ARC
    if crater is not None and (crater.current_a is not None or crater.voltage_v is not None):
        fill = _arc(None, crater.voltage_v, None, crater.current_a)
    delay = f"{values.start_delay_s or 0:g}"
    begin = f"0,{GAS_S:g},{NO_ARC},{delay},0,0,0,0,{NO_ARC}"
    return f"[{begin},0,{end_time_s(path):g},{fill},0,0,{NO_ARC},{GAS_S:g}]"


def _weavedata(values: WeldValues, speed_mm_s: float) -> str:
    weave = values.weave
    if weave is None:
        return ""
    left, right = (round(dwell * speed_mm_s, 2) for dwell in (weave.dwell_left_s, weave.dwell_right_s))
    return f"[{SHAPES[weave.shape]},0,{weave.length_mm:g},{weave.width_mm:g},0,{left:g},0,{right:g},0,0,0,0,0,0,0]"
