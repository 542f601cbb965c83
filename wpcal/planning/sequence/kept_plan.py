"""A plan as programs need it, and a plan that is kept: programs are written again without planning again.

``plan.json`` holds the states of the plan. The folder ``input`` beside it holds copies of what it was planned from, of
which ``plan.json`` has the SHA-256, so that the plan can be used wherever it is copied to.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.records import parse_json, read_json, to_json
from wpcal.core.result_files import CALIBRATION_FILE, PART_FILE, SEAMS_FILE
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.plan.seam_file import seams_in_part
from wpcal.planning.sequence.seam_task import SeamTask, seam_task, speed_along
from wpcal.planning.sequence.sequence_input import PlannedSeam, SequenceInput
from wpcal.planning.sequence.weld_sequence import Way, WeldSequence
from wpcal.robot.kinematics.arm_file import shipped_arms
from wpcal.robot.torch.file import CELL_SCHEMA, torch_of_seams
from wpcal.seam.record import errors_from_record

PLAN_FILE, PLAN_SCHEMA = "plan.json", "wpcal/weld-sequence/1"
INPUT = "input"  #: The folder with copies of what a plan was made from.
CELL_FILE, WELDS_FILE, RULES_FILE = "cell.json", "welds.json", "rules.toml"
SAME_MM = 1e-6  #: Arc lengths of one point, in the plan and in its seam.


@dataclass(frozen=True, slots=True, eq=False)
class KeptPiece:
    """One stretch with its approach and retract."""

    name: str
    task: SeamTask  #: The stretch in the direction of travel: n points.
    branch: int
    states: FloatArray  #: shape (a + n + b, k). All axes of approach, stretch and retract, rad and mm.
    before: int  #: `before`, `after`: the numbers a and b.
    after: int

    @property
    def q(self) -> FloatArray:
        """All axes along the stretch, shape (n, k)."""
        return self.states[self.before : self.before + len(self.task)]

    def speed_mm_s(self, cell: Cell, asked_mm_s: float) -> float:
        """Return the speed of the wire: that of the weld data or the asked one, if every axis can follow."""
        return speed_along(cell, self.q, self.task.s_mm, self.task.speed_mm_s or asked_mm_s)[0]


@dataclass(frozen=True, slots=True, eq=False)
class KeptPlan:
    """All that programs need of a plan."""

    cell: Cell  #: With the part in its place.
    pieces: tuple[KeptPiece, ...]  #: In the order of welding.
    air: tuple[FloatArray, ...]  #: shapes (m, k). From home to the first piece, between pieces, and home.
    ways: tuple[Way, ...]  #: One per piece.
    not_welded: tuple[tuple[str, float, float], ...]  #: Seam, from and to, mm.
    is_free: bool  #: Whether every move is proved free of collision.
    checked: str  #: What was compared with what.
    speed_mm_s: float  #: Of the wire, without weld data.
    approach_mm: float
    air_speed_mm_s: float

    @property
    def welded_mm(self) -> float:
        """Length of all pieces, mm."""
        return sum(piece.task.length_mm for piece in self.pieces)

    @classmethod
    def of(cls, sequence: WeldSequence) -> KeptPlan:
        """Return a plan that was just made."""
        targets = sequence.targets
        pieces = (
            KeptPiece(
                each.name, each.candidate.task, each.candidate.branch, each.states, len(each.before), len(each.after)
            )
            for each in sequence.pieces
        )
        return cls(
            sequence.cell,
            tuple(pieces),
            tuple(path.q for path in sequence.air),
            sequence.ways,
            tuple((gap.seam, gap.from_mm, gap.to_mm) for gap in sequence.unwelded),
            sequence.is_free,
            sequence.checked,
            targets.speed_mm_s,
            targets.approach_mm,
            targets.air_speed_mm_s,
        )

    def record(self) -> dict[str, Any]:
        """Return the states as ``plan.json`` keeps them: degrees, and a rail in mm."""
        factors = shown_units(self.cell)
        pieces = [
            {"before": each.before, "after": each.after, "states": (each.states * factors).tolist()}
            for each in self.pieces
        ]
        return {
            "speed_mm_s": self.speed_mm_s,
            "approach_mm": self.approach_mm,
            "air_speed_mm_s": self.air_speed_mm_s,
            "pieces": pieces,
            "air": [(q * factors).tolist() for q in self.air],
            "ways": [
                {"from_home": (way.from_home * factors).tolist(), "to_home": (way.to_home * factors).tolist()}
                for way in self.ways
            ],
        }


def shown_units(cell: Cell) -> FloatArray:
    """Return by what axes are multiplied in files, shape (k,): degrees per radian, and 1 for a rail."""
    factors = np.full(len(cell.axis_names), 180.0 / math.pi)
    if cell.rail_axis is not None:
        factors[cell.rail_axis] = 1.0
    return factors


def kept_plan_of(record: Mapping[str, Any], cell: Cell, seams: Mapping[str, PlannedSeam]) -> KeptPlan:
    """Return the plan of ``plan.json``.

    Raises `InputError` when the seams are cut into other runs than those that were planned.
    """
    kept, factors = record["kept"], shown_units(cell)
    return KeptPlan(
        cell,
        tuple(_piece(*rows, seams, factors) for rows in zip(record["seams"], kept["pieces"], strict=True)),
        tuple(np.array(q).reshape(-1, len(factors)) / factors for q in kept["air"]),
        tuple(
            Way(*(np.array(way[key]).reshape(-1, len(factors)) / factors for key in ("from_home", "to_home")))
            for way in kept["ways"]
        ),
        tuple((gap["seam"], gap["from_mm"], gap["to_mm"]) for gap in record["unwelded"]),
        record["freedom"] == "free",
        record["checked"],
        kept["speed_mm_s"],
        kept["approach_mm"],
        kept["air_speed_mm_s"],
    )


def _piece(
    row: Mapping[str, Any], kept: Mapping[str, Any], seams: Mapping[str, PlannedSeam], factors: FloatArray
) -> KeptPiece:
    of = seams.get(row["seam"])
    states = np.array(kept["states"]) / factors
    if of is not None:
        task = seam_task(of.seam, of.speed_mm_s, of.rank, of.run)
        first, last = (int(np.argmin(np.abs(task.s_mm - row[end]))) for end in ("from_mm", "to_mm"))
        found = task.part_of(first, last)
        ends = np.abs(found.s_mm[[0, -1]] - [row["from_mm"], row["to_mm"]]).max()
        if ends <= SAME_MM and len(found) == len(states) - kept["before"] - kept["after"]:
            found = found.backwards() if row["is_reversed"] else found
            return KeptPiece(row["name"], found, row["branch"], states, kept["before"], kept["after"])
    raise InputError(f"{row['name']}: the weld data cut the seams into other runs than the plan has: plan again")


@dataclass(frozen=True, slots=True, eq=False)
class KeptInput:
    """A plan that was kept, and what it was planned from."""

    record: Mapping[str, Any]  #: Of ``plan.json``.
    cell: Cell
    given: SequenceInput
    folder: Path  #: The folder ``input``.
    welds: Path | None  #: Weld data with which it was planned.
    rules: Path | None  #: The table of rules, if not that of wpcal.


def input_files(
    cell: Path, result: Path, part_glb: bytes | None, welds: Path | None, rules: Path | None
) -> Iterator[tuple[str, bytes]]:
    """Yield the files of the folder ``input``: names and contents. An arm that is not shipped lies beside the cell."""
    record = read_json(cell, schema=CELL_SCHEMA)
    for name in ("torch_robot", "holder_robot", "positioner"):
        arm = (record.get(name) or {}).get("arm")
        if arm is not None and arm not in shipped_arms():
            file = f"{name}{Path(arm).suffix}"
            yield file, read_bytes(cell.parent / arm)
            record[name]["arm"] = file
    yield CELL_FILE, to_json(record).encode()
    seams = result / SEAMS_FILE if result.is_dir() else result
    yield SEAMS_FILE, read_bytes(seams)
    if part_glb is not None:
        yield PART_FILE, part_glb
    for name, path in ((CALIBRATION_FILE, seams.parent / CALIBRATION_FILE), (WELDS_FILE, welds), (RULES_FILE, rules)):
        if path is not None and path.is_file():
            yield name, read_bytes(path)


def with_digest(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the record of ``plan.json`` with the SHA-256 of all else in it."""
    rest = {key: value for key, value in record.items() if key != "digest"}
    return {**rest, "digest": sha256_of(to_json(rest).encode())}


def read_kept_plan(folder: Path) -> KeptInput:
    """Read the folder of a plan.

    Raises `InputError` when a file cannot be opened, or is missing in ``input``.
    Raises `FormatError` when a file breaks its format, ``plan.json`` was changed after it was planned, or ``input`` has
    a file that is not, or not as it was, among those that were planned from: file and remedy are named.
    """
    path, source = folder / PLAN_FILE, folder / INPUT
    record = parse_json(read_bytes(path), path=str(path))
    if record.get("schema") != PLAN_SCHEMA:
        raise InputError(f"{path}: not a plan of one robot: programs of two robots are written when they are planned")
    if "kept" not in record:
        raise InputError(f"{path}: an earlier version of wpcal made this plan, without its states: plan again")
    record = read_json(path, schema=PLAN_SCHEMA)
    require_as_made(record, folder)
    cell, seams = read_cell(source / CELL_FILE), source / SEAMS_FILE
    listed, found, T_base_part = seams_in_part(seams, cell, with_place=True)
    errors = dict(zip((each.name for each in found), errors_from_record(listed), strict=True))
    planned = tuple(PlannedSeam(each, errors[each.name]) for each in found if each.name in record["planned"])
    raw = read_bytes(source / PART_FILE) if PART_FILE in record["made_from"] else None
    part = None if raw is None else TriangleMaterial.of(read_part_glb(raw))
    given = SequenceInput(planned, found, T_base_part, part, raw, torch_of_seams(listed, seams))
    has = {name: source / name if name in record["made_from"] else None for name in (WELDS_FILE, RULES_FILE)}
    return KeptInput(record, given.placed(cell), given, source, has[WELDS_FILE], has[RULES_FILE])


def require_as_made(record: Mapping[str, Any], folder: Path) -> None:
    """Require that the plan in a folder, and the files there that it was made from, are as they were written.

    Raises as `read_kept_plan` does.
    """
    path, source = folder / PLAN_FILE, folder / INPUT
    if record.get("digest") != with_digest(record)["digest"]:
        raise FormatError("was changed after wpcal plan wrote it (digest); plan again", path=str(path))
    for name, sha256 in record["made_from"].items() if source.is_dir() else ():
        if not (source / name).is_file():
            raise InputError(f"{source / name}: is missing; the plan was made from it: plan again")
        if sha256_of(read_bytes(source / name)) != sha256:
            raise FormatError(f"is not what {PLAN_FILE} was made from (SHA-256); plan again", path=str(source / name))
    for file in sorted(source.glob("*")):
        if file.name not in record["made_from"] and not file.name.startswith("."):
            raise FormatError(f"{PLAN_FILE} was not made from it: take it out, or plan again", path=str(file))
