"""What a sequence starts from: the seams of a result folder or a ``seams.json``, the part's triangles, its place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.result_files import SEAMS_FILE
from wpcal.core.same_bits import inverse_pose, product
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.plan.seam_file import part_beside, seams_in_part
from wpcal.robot.torch.file import torch_of_seams
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam.names import seams_named
from wpcal.seam.record import errors_from_record
from wpcal.seam.seam import Seam
from wpcal.weld.runs import RunChoice, WeldRun, laid_runs
from wpcal.weld.seam_weld import SeamWeld

OFF_PART_MM = 10.0  #: A seam is this far from the box of its part at most: half of a wide gap.


@dataclass(frozen=True, slots=True, eq=False)
class PlannedSeam:
    """What is planned as one: a seam, or one bead along one stretch of it."""

    seam: Seam  #: With n frames in `part`.
    u95_mm: FloatArray | None = None  #: shape (n,). The 95 % error at the frames, mm.
    run: WeldRun | None = None  #: What is laid; None without weld data.

    @property
    def name(self) -> str:
        """Of the run, else of the seam."""
        return self.seam.name

    @property
    def speed_mm_s(self) -> float | None:
        """The speed of the wire that the weld data ask for."""
        speed = None if self.run is None else self.run.weld.values.speed_mm_s
        return speed if speed is None or self.run is None else speed * self.run.speed_ratio

    @property
    def rank(self) -> int:
        """Lower ranks are welded first: tack welds, then bead by bead."""
        if self.run is None or self.run.bead is None:
            return 0 if self.run is not None and self.run.is_tack else 1
        return self.run.bead.number


@dataclass(frozen=True, slots=True, eq=False)
class SequenceInput:
    """Seams to weld and the part."""

    seams: tuple[PlannedSeam, ...]  #: Chosen ones.
    found: tuple[Seam, ...]  #: All of the file, with frames in `part`.
    #: Where the robot found the part; None if the seams were found without a calibration.
    T_base_part: RigidTransform | None
    part: TriangleMaterial | None  #: In `part`; None if there is no ``part.glb``.
    part_glb: bytes | None
    #: With which reach was felt when the seams were found; None in files that do not state it.
    torch: TorchShape | None = None

    def placed(self, cell: Cell) -> Cell:
        """Return the cell with the part where the robot found it, or as the cell says.

        Raises `InputError` when neither is known.
        """
        found = cell if self.T_base_part is None else cell.with_touched_part(self.T_base_part)
        _ = found.T_part  # refuses a part whose place is not known
        return found

    def other_torch(self, cell: Cell) -> str | None:
        """Say that the seams were felt with another torch than that of the cell; None if they agree, or nobody says."""
        felt, own = self.torch, cell.torch_shape
        if felt is None or own is None or replace(felt, name=own.name) == own:
            return None
        return (
            f"the seams were felt with {felt.name} ({felt}), and the cell has {own.name} ({own}): the plan is made "
            "with the bodies of the cell; find the seams again with --torch and the cell file"
        )

    def in_base(self, cell: Cell) -> tuple[RigidTransform, tuple[Seam, ...]]:
        """Return ``T_base_part`` and all seams with frames in the base: as the robot found them, else as at home."""
        T = self.T_base_part
        if T is None:
            home = cell.home[None]
            place = product(inverse_pose(cell.base_places(home)[0]), cell.part_places(home)[0])
            T = RigidTransform.from_matrix(place, target="base", source="part")
        return T, tuple(replace(seam, frames=seam.frames.moved(T)) for seam in self.found)

    def with_welds(self, welds: Mapping[str, SeamWeld] | None, choice: RunChoice, speed_mm_s: float) -> SequenceInput:
        """Return the same with weld data: what `wpcal.weld.runs.laid_runs` returns is planned seam by seam."""
        runs = laid_runs([(each.seam, each.u95_mm) for each in self.seams], welds, choice, speed_mm_s)
        return replace(self, seams=tuple(PlannedSeam(*each) for each in runs))


def read_sequence_input(
    result: Path, cell: Cell, names: Sequence[str] | None = None, *, part_glb: bytes | None = None
) -> SequenceInput:
    """Read what is to be welded.

    Raises `InputError` when a file cannot be opened, a name is unknown, no seam is left, or a seam is outside of the
    given part.
    Raises `FormatError` when a file breaks its format.
    Raises `FrameError` when the seams were calibrated with a different model of the robot than the cell has.
    """
    path = result / SEAMS_FILE if result.is_dir() else result
    record, seams, T_base_part = seams_in_part(path, cell, with_place=True)
    known = [seam.name for seam in seams]
    chosen = None if names is None else set(seams_named(names, known))
    rows = [row for row, seam in enumerate(seams) if (seam.accepted if chosen is None else seam.name in chosen)]
    if not rows:
        raise InputError(f"{path}: none of the {len(known)} seams is accepted; name candidates with --only")
    raw, part = part_beside(path, part_glb)
    if part is not None and part_glb is not None:
        _require_on_part([seams[row] for row in rows], part)
    errors = errors_from_record(record)
    planned = tuple(PlannedSeam(seams[row], errors[row]) for row in rows)
    return SequenceInput(planned, seams, T_base_part, part, raw, torch_of_seams(record, path))


def _require_on_part(seams: Sequence[Seam], part: TriangleMaterial) -> None:
    corners = part.corners.reshape(-1, 3)
    low, high = corners.min(axis=0), corners.max(axis=0)
    for seam in seams:
        p = seam.frames.p
        off = float(np.maximum(np.maximum(low - p, p - high), 0.0).max())
        if off > OFF_PART_MM:
            raise InputError(
                f"--part: seam {seam.name} is {off:.0f} mm outside of this part; expected the part in which the seams "
                "were found"
            )
