"""What a torch does in one go: one bead along one stretch of a seam, or one tack weld.

A weld with one bead and no stitches is the seam itself. Otherwise each bead is moved in the frame of the seam, and each
stretch is cut out of it. All stretches of a bead come before the next bead. Tack welds are short stretches in the seam
itself, without a weave; all of them come before the first weld.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.seam.seam import Seam, SeamFrames, WeldType
from wpcal.weld.passes import Bead
from wpcal.weld.seam_weld import SeamWeld
from wpcal.weld.values import WeldKind
from wpcal.weld.weave_points import woven_frames


class Tacks(Enum):
    """Which of tack welds and welds a program lays."""

    FIRST = "first"
    ONLY = "only"
    OFF = "off"


class WeaveBy(Enum):
    """Who makes a weave."""

    CONTROLLER = "controller"  #: An instruction of the language, or data in the controller.
    POINTS = "points"  #: Points of the program.


@dataclass(frozen=True, slots=True)
class RunChoice:
    """Which runs a program has. Raises `InputError` when the overlap is negative or not finite."""

    tacks: Tacks = opt(Tacks.FIRST, "Tack welds of the weld data: before all welds, only these, or none.")
    weave: WeaveBy = opt(
        WeaveBy.CONTROLLER,
        "Weaves of the weld data: an instruction of the controller, or points, for languages without weaves.",
    )
    overlap_mm: float = opt(
        0.0, "A closed seam is welded on over its start by this much. Weld data that fill the crater there need none."
    )

    def __post_init__(self) -> None:
        if not 0.0 <= self.overlap_mm < math.inf:
            raise InputError(f"overlap_mm: expected 0 or more, got {self.overlap_mm:g}")


@dataclass(frozen=True, slots=True, eq=False)
class WeldRun:
    """One bead along one stretch, or one tack weld."""

    #: What is welded, under the name of the run: ``W1``, ``W1.p2`` (second pass), ``W1.s3`` (third stretch), ``W1.t1``
    #: (first tack weld).
    seam: Seam
    weld: SeamWeld
    bead: Bead | None  #: None for the only bead.
    u95_mm: FloatArray | None  #: shape (n,). The 95 % error at the frames, mm.
    is_tack: bool = False
    middle: SeamFrames | None = None  #: What the points of a weave swing about; None for all other runs.

    @property
    def is_woven(self) -> bool:
        """Whether the frames of the seam are those of a weave."""
        return self.middle is not None

    @property
    def speed_ratio(self) -> float:
        """Of the wire to the travel: more than 1 for a weave that is made of points; 1 for all others."""
        return 1.0 if self.middle is None else float(self.seam.frames.s_mm[-1] / self.middle.s_mm[-1])


def chosen_runs(
    seams: Sequence[tuple[Seam, SeamWeld, FloatArray | None]], choice: RunChoice, speed_mm_s: float
) -> list[WeldRun]:
    """Return the runs of all welds in the order of welding: all tack welds before the first weld.

    `seams`: shape (n,) or None). Each with n frames, its weld, and the 95 % error at its frames, mm.
    Raises `InputError` when only tack welds are wanted and there are none, or a weave cannot be made of points.
    """
    tacks = [run for each in seams if choice.tacks is not Tacks.OFF for run in tack_runs(*each)]
    if choice.tacks is Tacks.ONLY:
        if not tacks:
            raise InputError("no weld data of the chosen seams states tacks")
        return tacks
    runs = [run for each in seams for run in weld_runs(*each)]
    if choice.weave is WeaveBy.POINTS:
        runs = [woven_run(run, run.weld.values.speed_mm_s or speed_mm_s) for run in runs]
    return [*tacks, *runs]


def laid_runs(
    seams: Sequence[tuple[Seam, FloatArray | None]],
    welds: Mapping[str, SeamWeld] | None,
    choice: RunChoice,
    speed_mm_s: float,
) -> list[tuple[Seam, FloatArray | None, WeldRun | None]]:
    """Return what is laid: every bead, stretch and tack weld, or the seams without weld data; rings with their overlap.

    `seams`: Each with n frames, and the 95 % error at its frames, shape (n,), mm.
    Raises `InputError` as `chosen_runs` does, or when an overlap is longer than its seam.
    """
    if welds is None:
        parts: list[tuple[Seam, FloatArray | None, WeldRun | None]] = [(*each, None) for each in seams]
    else:
        runs = chosen_runs([(seam, welds[seam.name], u95) for seam, u95 in seams], choice, speed_mm_s)
        parts = [(run.seam, run.u95_mm, run) for run in runs]
    return [(*_overlapped(seam, u95, choice.overlap_mm), run) for seam, u95, run in parts]


def weld_runs(seam: Seam, weld: SeamWeld, u95_mm: FloatArray | None = None) -> tuple[WeldRun, ...]:
    """Return the runs of a weld in the order of welding. `u95_mm`: shape (n,), optional."""
    beads: tuple[Bead | None, ...] = weld.beads or (None,)
    runs = []
    for bead in beads:
        of_bead = f"{seam.name}.p{bead.number}" if bead is not None and len(beads) > 1 else seam.name
        for number, (start, end) in enumerate(weld.stretches_mm, 1):
            name = f"{of_bead}.s{number}" if len(weld.stretches_mm) > 1 else of_bead
            frames = seam.frames if bead is None else _moved(seam.frames, bead)
            moved = replace(seam, frames=frames, lean_rad=_leans(seam, weld, bead))
            is_whole = start <= 0.0 and end >= seam.length_mm
            if is_whole:
                runs.append(WeldRun(replace(moved, name=name), weld, bead, u95_mm))
            else:
                cut, u95 = runs_of_seam(moved, start, end, u95_mm)
                runs.append(WeldRun(replace(cut, name=name), weld, bead, u95))
    return tuple(runs)


def tack_runs(seam: Seam, weld: SeamWeld, u95_mm: FloatArray | None = None) -> tuple[WeldRun, ...]:
    """Return the tack welds of a seam in their order. They have the values of the weld, but no weave.

    `u95_mm`: shape (n,), optional.
    """
    plain = replace(weld, values=replace(weld.values, weave=None, weave_data=None))
    leaning = replace(seam, lean_rad=_leans(seam, weld, None))
    runs = []
    for number, (start, end) in enumerate(weld.tacks_mm, 1):
        cut, u95 = runs_of_seam(leaning, start, end, u95_mm)
        runs.append(WeldRun(replace(cut, name=f"{seam.name}.t{number}"), plain, None, u95, is_tack=True))
    return tuple(runs)


def woven_run(run: WeldRun, speed_mm_s: float) -> WeldRun:
    """Return a run whose weave is made of points; a run without a weave is returned as it is.

    Raises `InputError` if the weave cannot be made of points, or is stated by the name of its data only. The message
    names the weld.
    """
    values, seam = run.weld.values, run.seam
    if values.weave is None:
        if values.weave_data is not None:
            raise InputError(f"weld {run.weld.name}: weave_data {values.weave_data}: points need the values of weave")
        return run
    try:
        frames = woven_frames(
            seam.frames,
            values.weave,
            speed_mm_s,
            bead=run.bead,
            between_plates=seam.weld is WeldType.FILLET and values.weld is WeldKind.FILLET,
        )
    except InputError as error:
        raise InputError(f"weld {run.weld.name}: {error}") from None
    own = seam.frames.s_mm
    s = frames.s_mm * own[-1] / frames.s_mm[-1]
    nearest = np.abs(own[None, :] - s[:, None]).argmin(axis=1)
    lean = None if seam.lean_rad is None else seam.lean_rad[nearest]
    plain = replace(run.weld, values=replace(values, weave=None, weave_data=None))
    return replace(
        run,
        seam=replace(seam, frames=frames, lean_rad=lean),
        weld=plain,
        u95_mm=None if run.u95_mm is None else np.interp(s, own, run.u95_mm),
        middle=seam.frames,
    )


def _leans(seam: Seam, weld: SeamWeld, bead: Bead | None) -> FloatArray | None:
    """Return the leans of the torch: those of the weld data where a straight torch is free, else those of the seam."""
    work = (weld.values.work_angle_deg or 0.0) + (0.0 if bead is None else bead.work_angle_deg)
    asked = np.radians([work, weld.values.travel_angle_deg or 0.0])
    if not asked.any():
        return seam.lean_rad
    if seam.lean_rad is None:
        return np.tile(asked, (len(seam.frames), 1))
    is_straight = (np.nan_to_num(seam.lean_rad) == 0.0).all(axis=1)
    return np.where(is_straight[:, None], asked, seam.lean_rad)


def _moved(frames: SeamFrames, bead: Bead) -> SeamFrames:
    p = frames.p + bead.y_mm * frames.R[:, :, 1] + bead.z_mm * frames.R[:, :, 2]
    return replace(frames, p=p)


def runs_of_seam(
    seam: Seam, start_mm: float, end_mm: float, u95_mm: FloatArray | None = None
) -> tuple[Seam, FloatArray | None]:
    """Cut a stretch out of a seam. Between two frames the position is on the chord, and the axes turn evenly.

    `u95_mm`: shape (n,), optional.
    Returns `seam`: Seam. Open, with lengths from its own start.
    Returns `u95_mm`: ndarray or None. At its frames.
    """
    frames = seam.frames
    own = frames.s_mm
    inner = own[(own > start_mm) & (own < end_mm)]
    s = np.concatenate([[start_mm], inner, [end_mm]])
    p = np.stack([np.interp(s, own, frames.p[:, axis]) for axis in range(3)], axis=1)
    angle = np.interp(s, own, frames.angle_rad)
    nearest = np.abs(own[None, :] - s[:, None]).argmin(axis=1)
    cut = replace(
        seam,
        closed=False,
        length_mm=float(end_mm - start_mm),
        frames=SeamFrames(s - start_mm, p, frames.axes_at(s), angle, frames.frame),
        lean_rad=None if seam.lean_rad is None else seam.lean_rad[nearest],
        spin_rad=None if seam.spin_rad is None else seam.spin_rad[nearest],
    )
    return cut, None if u95_mm is None else np.interp(s, own, u95_mm)


def _overlapped(seam: Seam, u95_mm: FloatArray | None, mm: float) -> tuple[Seam, FloatArray | None]:
    """Return a closed seam that goes on over its start, and the errors at its frames; any other as it is."""
    if not seam.closed or not mm:
        return seam, u95_mm
    if mm >= seam.length_mm:
        raise InputError(f"overlap_mm = {mm:g}: {seam.name} is a ring of {seam.length_mm:.0f} mm")
    again, u95_again = runs_of_seam(seam, 0.0, mm, u95_mm)
    on = again.frames.select(slice(1, None))
    frames = SeamFrames.joined([seam.frames, replace(on, s_mm=on.s_mm + seam.frames.s_mm[-1])])
    lean, spin, u95 = (
        None if first is None or more is None else np.concatenate([first, more[1:]])
        for first, more in ((seam.lean_rad, again.lean_rad), (seam.spin_rad, again.spin_rad), (u95_mm, u95_again))
    )
    length_mm = seam.length_mm + mm
    return replace(seam, closed=False, length_mm=length_mm, frames=frames, lean_rad=lean, spin_rad=spin), u95
