"""From a program as written and as it came back to what the corrections mean for every seam."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wpcal.calibrate.corrections import ALL_KINDS, END_MM, Corrections, Explanation, KindOffset, SeamPlaces, Touched
from wpcal.calibrate.errors.field_shift import FieldShift
from wpcal.calibrate.errors.robot_field import FieldOrigin, RobotField
from wpcal.controllers.touchup.poses import ProgramText, common_motion, pair_poses, seams_beside
from wpcal.controllers.touchup.seams import WeldedPart, apart_mm
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.core.same_bits import inverse_pose
from wpcal.results.folder import FinishedCalibration

MOVED_MM = 0.05  #: A pose that differs by less was not moved: programs round.
TURNED = 2e-3  #: The same for the elements of its rotation: 0.1°.
MOVED_ALONG_MM = 0.5  #: An end that was moved along its seam by more says where it is.
FARTHEST_MM = 25.0  #: Weld points as written are within this of their seam: wire and passes.
BETTER = 0.8  #: A seam is better where its error is at most this share of what it was.
KNOWN = 0.95  #: No more is known of it where the error is a larger share.


@dataclass(frozen=True)
class TouchUpOptions:
    """How corrections are read."""

    hand_mm: float | None = opt(
        None, "Error of a correction by hand per axis: 0.2, or from 8 points on what they show.", above=0.0
    )
    tack_mm: float | None = opt(
        None, "Tack tolerance of the place of a body: standard deviation. Without it few bodies moved."
    )
    tack_mrad: float = opt(3.0, "Tack tolerance of the turn of a body: standard deviation, with --tack-mm.")
    without: tuple[str, ...] = opt(
        (), "Corrections of this seam are kept, but say nothing of the part.", "--set-aside", many=True, metavar="SEAM"
    )
    smooth: bool = opt(False, "Put corrected points where the fit has them, all but exceptions.", "--smooth")
    keep_offset: bool = opt(False, "Give the offset that seams of a kind got to all of them.", "--keep-offset")


@dataclass(frozen=True, slots=True, eq=False)
class CorrectedPoint:
    """One weld point that a person moved or added."""

    seam: int
    frame: int  #: Of the seam.
    row: int  #: Of the changed program.
    place: str  #: File and line.
    at: FloatArray  #: shape (3,). Where it was, before the frame or tool was changed, mm.
    moved: FloatArray  #: shape (3,). From there, mm.
    in_seam: FloatArray  #: shape (3,). The same along x, y, z of the seam.
    is_added: bool
    is_end: bool
    is_used: bool


@dataclass(frozen=True, slots=True, eq=False)
class SeamAfter:
    """What the corrections say of one seam."""

    name: str
    corrected: int  #: Points.
    was_off_mm: float  #: How far the program as written was off, at most, as far as is known now.
    before_95_mm: float | None  #: The error that the calibration promised.
    after_95_mm: float

    @property
    def says(self) -> str:
        """The change in words."""
        before, after = self.before_95_mm, self.after_95_mm
        if before is None:
            return "corrected" if self.corrected else "not known before"
        if after > before / KNOWN:
            return "less sure than was promised"
        if after > KNOWN * before:
            return "no surer than before"
        return "better" if after <= BETTER * before else "a little better"


class TouchUp:
    """What a person corrected, and what follows from it.

    Raises `InputError` when the program does not weld the seams of the calibration, or holds no poses.
    """

    def __init__(
        self, finished: FinishedCalibration, written: ProgramText, changed: ProgramText, options: TouchUpOptions
    ) -> None:
        if not written.poses or not changed.poses:
            raise InputError("a program without poses of the tool: nothing can be compared")
        self.part, self.written, self.changed, self.options = WeldedPart.of(finished), written, changed, options
        self.pairs = pair_poses(written.poses, changed.poses)
        self._old, new = (np.array([pose.T for pose in program.poses]) for program in (written, changed))
        #: By which most poses moved together, shape (4, 4), and whether it is one of the tool.
        self.common = common_motion(self._old[list(self.pairs.old)], new[list(self.pairs.new)])
        self._new = new
        if self.common is not None:
            T, is_tool = self.common
            self._new = new @ inverse_pose(T) if is_tool else inverse_pose(T) @ new
        self._where = self.part.frames_at(self._old[:, :3, 3], seams_beside(written.poses))
        self._require_seams()
        #: Rows of the changed program that a person changed; they stay as they are.
        self.by_hand = frozenset({*self.pairs.added, *(row for _, row in self._changed())})
        self.points = (*self._moved(), *self._added())

    def _require_seams(self) -> None:
        """Refuse a program that was written from another calibration."""
        for row, pose in enumerate(self.written.poses):
            seam = self.part.seams[int(self._where[row, 0])]
            if pose.seam and apart_mm(seam, self._old[row, None, :3, 3])[0] > FARTHEST_MM:
                raise InputError(
                    f"{pose.where}: a weld point is more than {FARTHEST_MM:g} mm from every accepted seam of the "
                    "calibration; was this program written from another one?"
                )

    def _changed(self) -> Iterator[tuple[int, int]]:
        for before, row in zip(self.pairs.old, self.pairs.new, strict=True):
            is_turned = np.abs(self._new[row, :3, :3] - self._old[before, :3, :3]).max() > TURNED
            if is_turned or np.linalg.norm(self._new[row, :3, 3] - self._old[before, :3, 3]) > MOVED_MM:
                yield before, row

    def _moved(self) -> Iterator[CorrectedPoint]:
        written = self.written.poses
        for before, row in self._changed():
            at = self._old[before, :3, 3]
            if written[before].seam and np.linalg.norm(self._new[row, :3, 3] - at) > MOVED_MM:
                beside = [written[k].seam if 0 <= k < len(written) else 0 for k in (before - 1, before + 1)]
                is_end = any(seam != written[before].seam for seam in beside)
                yield self._point(row, at, self._where[before], is_end=is_end)

    def _added(self) -> Iterator[CorrectedPoint]:
        """Yield weld points that were added, as moved from the nearest place on the path as it was written."""
        seam = [pose.seam for pose in self.written.poses]
        own = [k for k in range(len(seam) - 1) if seam[k] and seam[k] == seam[k + 1]]
        a = self._old[own, :3, 3]
        along = self._old[[k + 1 for k in own], :3, 3] - a
        for row in self.pairs.added if own else ():
            if self.changed.poses[row].seam:
                p = self._new[row, :3, 3]
                share = np.einsum("ki,ki->k", p - a, along) / np.maximum(np.einsum("ki,ki->k", along, along), 1e-12)
                at = a + np.clip(share, 0.0, 1.0)[:, None] * along
                best = int(np.argmin(np.linalg.norm(p - at, axis=1)))
                yield self._point(row, at[best], self._where[own[best]], is_added=True)

    def _point(
        self, row: int, at: FloatArray, where: IntArray, *, is_end: bool = False, is_added: bool = False
    ) -> CorrectedPoint:
        number, frame = int(where[0]), int(where[1])
        seam, place = self.part.seams[number], self.changed.poses[row].where
        moved = self._new[row, :3, 3] - at
        is_used = seam.name not in self.options.without
        return CorrectedPoint(
            number, frame, row, place, at, moved, seam.frames.R[frame].T @ moved, is_added, is_end, is_used
        )

    @property
    def _used(self) -> list[CorrectedPoint]:
        return [point for point in self.points if point.is_used]

    @cached_property
    def explanation(self) -> Explanation | None:
        """What explains the corrections; None where nothing was corrected."""
        used = self._used
        if not used:
            return None
        where = np.array([(point.seam, point.frame) for point in used])
        at = self.part.places(where, np.array([point.at for point in used]))
        says_end = [point.is_end and abs(point.in_seam[0]) > MOVED_ALONG_MM for point in used]
        moved = np.array([point.moved for point in used]) + self._followed(at.p)
        found = Corrections(at, moved, np.where(says_end, END_MM, np.inf))
        everywhere = self.part.places(self.part.spread)
        return Explanation(found, self._touched(), self._field(), self.options.hand_mm, everywhere)

    def _followed(self, points_base: FloatArray) -> FloatArray:
        """Return by how much the calibration moved seams for the robot's own error, shape (k, 3), mm."""
        record = self.part.finished.calibration.get("field_shift")
        return np.zeros_like(points_base) if record is None else FieldShift.from_record(record).at(points_base)

    def _field(self) -> RobotField:
        robot = self.part.finished.calibration.get("budget", {}).get("robot")
        if robot is None:  # of a version before budgets
            return RobotField(0.0, 1000.0, FieldOrigin.ASSUMED)
        return RobotField(robot["amplitude_mm"], robot["length_mm"], FieldOrigin(robot["origin"]), robot["rest_mm"])

    def _touched(self) -> Touched:
        """Return what the record of the calibration knows of the part's place."""
        record = self.part.finished.calibration
        stated = record["teaching_error"]
        sigma = max(stated.get("used_sigma_mm") or stated.get("sigma_mm") or 0.0, 1e-3)
        used = [point for point in record.get("points", ()) if point["use"] == "yes"]
        if len(used) >= 3 and not record.get("bodies"):
            p, off = (np.array([point[key] for point in used]) for key in ("p_base_mm", "residual_mm"))
            return Touched(p, off, sigma, tack=self._tack())
        covariance = np.array(record["covariance"]["values"], dtype=np.float64)
        return Touched(np.zeros((0, 3)), np.zeros((0, 3)), sigma, covariance, self._tack())

    def _tack(self) -> dict[int, tuple[float, float]]:
        """Return how far bodies may be off, mm and rad: as stated, or as the calibration left it."""
        names = self.part.bodies
        if self.options.tack_mm is not None:
            return dict.fromkeys(range(len(names)), (self.options.tack_mm, 1e-3 * self.options.tack_mrad))
        found = [each for each in self.part.finished.calibration.get("bodies") or () if each["name"] in names]
        mean = [(float(np.mean(each["sigma_mm"])), 1e-3 * float(np.mean(each["sigma_mrad"]))) for each in found]
        return {names.index(each["name"]): tack for each, tack in zip(found, mean, strict=True)}

    @property
    def exceptions(self) -> tuple[CorrectedPoint, ...]:
        """Points that contradict the others."""
        explained = self.explanation
        return () if explained is None else tuple(self._used[row] for row in explained.causes.of("exception"))

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of bodies that moved."""
        explained = self.explanation
        return () if explained is None else tuple(self.part.bodies[body] for body in explained.moved_bodies)

    @property
    def offsets(self) -> dict[str, KindOffset]:
        """Offsets that a person prefers, by the kind of seam."""
        if (explained := self.explanation) is None:
            return {}
        names = {ALL_KINDS: "all seams", **dict(enumerate(self.part.kinds))}
        return {names[kind]: explained.preference(kind) for kind in explained.causes.of("preference")}

    @cached_property
    def seam_names(self) -> tuple[str, ...]:
        """The seam of each pose of the changed program that is on one, or just before or after; empty for others."""
        beside = seams_beside(self.changed.poses)
        at = self.part.frames_at(self._new[:, :3, 3], beside)[:, 0].tolist()
        return tuple(self.part.seams[i].name if seam else "" for i, seam in zip(at, beside, strict=True))

    @cached_property
    def seams(self) -> tuple[SeamAfter, ...]:
        """What the corrections say of each seam."""
        if self.explanation is None:
            return ()
        rows = self.part.spread
        places = self.part.places(rows)
        mean, covariance = self.explanation.seams_at(places)
        mean = mean - self._followed(places.p)
        off, errors = np.linalg.norm(mean, axis=1), self.explanation.errors_95_mm(covariance)
        counts = [sum(point.seam == number for point in self.points) for number in range(len(self.part.seams))]
        return tuple(
            SeamAfter(
                seam.name,
                counts[number],
                float(off[rows[:, 0] == number].max()),
                self.part.promised_mm.get(seam.name),
                float(errors[rows[:, 0] == number].max()),
            )
            for number, seam in enumerate(self.part.seams)
        )

    @cached_property
    def shifts(self) -> FloatArray:
        """By how much each pose of the changed program is to be moved, shape (n, 3), in `base`, mm.

        What was changed by hand stays; the other points of seams, and the ones just before and after, go along.
        """
        shifts, origin = np.zeros((len(self._new), 3)), self._new[:, :3, 3].copy()
        beside, smoothed = seams_beside(self.changed.poses), self._smoothed()
        moved_along = {row for row, seam in enumerate(beside) if seam and row not in self.by_hand}
        rows = sorted(moved_along.union(smoothed))
        if self.explanation is None or not rows:
            return shifts
        for row, at in smoothed.items():
            origin[row] = at
        places = self.part.places(self.part.frames_at(origin, beside)[rows], origin[rows])
        moved = self.explanation.seams_at(places)[0] - self._followed(places.p)
        moved += origin[rows] - self._new[rows, :3, 3]
        takes = np.array([self.options.keep_offset or row in smoothed for row in rows])
        moved += takes[:, None] * self._offsets_at(places)
        T, is_tool = self.common or (np.eye(4), False)
        shifts[rows] = moved if is_tool else moved @ T[:3, :3].T
        return shifts

    def _smoothed(self) -> dict[int, FloatArray]:
        """Return where points were that the fit puts in place of the hand, by their rows."""
        if not self.options.smooth or self.explanation is None:
            return {}
        exceptions = self.explanation.causes.of("exception")
        return {point.row: point.at for number, point in enumerate(self._used) if number not in exceptions}

    def _offsets_at(self, places: SeamPlaces) -> FloatArray:
        """Return the preferred offsets at places on seams, shape (k, 3), mm."""
        found, explained = np.zeros((len(places), 3)), self.explanation
        if explained is None:
            return found
        for kind in explained.causes.of("preference"):
            wanted = places.R[:, :, 1:] @ explained.preference(kind).mean_mm
            found += ((places.kind == kind) | (kind == ALL_KINDS))[:, None] * wanted
        return found
