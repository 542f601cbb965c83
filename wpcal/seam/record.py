"""Seams as `seams.json` (every number with all digits) and `seams.csv` (one row per frame)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.csv_text import cell_text, csv_text
from wpcal.core.errors import FormatError
from wpcal.core.record_check import check_record
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.robot.torch.file import without_none
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.frame_records import frame_records, frames_from_records, leans_from_records
from wpcal.seam.record_check import check_seams
from wpcal.seam.seam import Finding, FlareGroove, Hiding, JointType, OtherTorch, Seam, SeamPieces, SeamSource, WeldType
from wpcal.seam.seam_edit import Candidate, SeamEdit

if TYPE_CHECKING:
    from wpcal.seam.member.note import MemberNotes

SEAMS_SCHEMA = "wpcal/seams/1"


def seams_record(
    seams: Sequence[Seam],
    T_base_part: RigidTransform | None = None,
    u95_mm: Sequence[FloatArray] | None = None,
    *,
    space: RobotSpace = RobotSpace.NOMINAL,
    notes: MemberNotes | None = None,
    join_mm: float | None = None,
    torch: TorchShape = USUAL_TORCH,
    columns: Mapping[str, Sequence[FloatArray]] | None = None,
) -> dict[str, Any]:
    """Return the record of ``seams.json``.

    `u95_mm`: shape (n,). For each seam, the 95 % error at each of its n frames, mm.
    `join_mm`: A decision may join seams whose ends are at most this far apart, mm (`SeamOptions.most_join_mm`).
    `columns`: shape (n,). More numbers of the frames of each seam, by the name of their field.

    Returns: The columns of ``R`` are the axes x, y, z of the seam in `frame`; quaternions are x, y, z, w with w >= 0.
    Frames in `base` have the weld position, with gravity along -z of `base`; the rotation is null for vertical travel.
    ``torch`` is the one with which reach was felt; ``lean_deg`` is how it leans at a frame to meet nothing.
    """
    return {
        "schema": SEAMS_SCHEMA,
        "frame": "part" if T_base_part is None else T_base_part.target,
        "units": {"length": "mm", "angle": "deg"},
        "z_sense": "outward",
        "robot_space": space.value,
        "torch": without_none(asdict(torch)),
        "T_base_part": None if T_base_part is None else T_base_part.matrix.tolist(),
        **({} if notes is None else notes.to_record(seams)),
        **({} if join_mm is None else {"join_mm": join_mm}),
        "seams": [
            {**_seam_record(seam), "frames": frames}
            for seam, frames in zip(seams, frame_records(seams, T_base_part, u95_mm, columns), strict=True)
        ],
    }


def _seam_record(seam: Seam) -> dict[str, Any]:
    """Return the record of a seam without its frames."""
    least, mean, largest = seam.gap_mm
    return {
        "name": seam.name,
        "joint": seam.joint.value,
        "weld": seam.weld.value,
        "solids": list(seam.solids),
        "closed": seam.closed,
        "length_mm": seam.length_mm,
        "accepted": seam.accepted,
        "confidence": round(seam.confidence, 3),
        "reachable": seam.reachable,
        "source": seam.source.value,
        "reasons": list(seam.reasons),
        "against": list(seam.against),
        "findings": [{"rule": one.rule, "factor": round(one.factor, 3)} for one in seam.findings],
        "inside": list(seam.inside),
        "blocked_by": list(seam.blocked_by),
        **({"hiding": [asdict(one) for one in seam.hiding]} if seam.hiding else {}),
        "gap_mm": {"min": least, "mean": mean, "max": largest},
        **({} if seam.wrap_of is None else {"wrap_of": seam.wrap_of}),
        **({"more_wire_mm": seam.more_wire_mm} if seam.more_wire_mm else {}),
        **({} if seam.other_torch is None else {"other_torch": asdict(seam.other_torch)}),
        **({} if seam.bead_mm is None else {"bead_mm": seam.bead_mm}),
        **({} if seam.groove is None else {"groove": asdict(seam.groove)}),
        **({} if seam.candidate is None else {"candidate": _candidate_record(seam.candidate)}),
        **({} if seam.edit is None else {"edit": _edit_record(seam.edit)}),
    }


def _candidate_record(candidate: Candidate) -> dict[str, Any]:
    return {
        "name": candidate.name,
        "start_part_mm": list(candidate.start_mm),
        "middle_part_mm": list(candidate.middle_mm),
        "length_mm": candidate.length_mm,
    }


def _edit_record(edit: SeamEdit) -> dict[str, Any]:
    record: dict[str, Any] = {} if edit.accept is None else {"accept" if edit.accept else "reject": True}
    if edit.reverse:
        record["reverse"] = True
    if edit.name is not None:
        record["name"] = edit.name
    if edit.range_mm is not None:
        record["range_mm"] = list(edit.range_mm)
    if edit.other_side:
        record["other_side"] = True
    if edit.join:
        record["join"] = [
            {"candidate": _candidate_record(one.candidate)} | ({"range_mm": list(one.range_mm)} if one.range_mm else {})
            for one in edit.join
        ]
    return record


def _findings_from_record(seam: dict[str, Any]) -> tuple[Finding, ...]:
    """Return the findings; those of a file from before they had rules and factors have words only."""
    texts = seam.get("against", ())
    rows = seam.get("findings") or [{"rule": "", "factor": 1.0}] * len(texts)
    return tuple(
        Finding(str(row["rule"]), float(row["factor"]), str(text)) for row, text in zip(rows, texts, strict=True)
    )


def seams_csv(record: dict[str, Any]) -> str:
    """Return ``seams.csv`` with its `SEAMS_CSV_COLUMNS`: one row per frame, in the coordinates of the record."""
    row = f"{','.join(SEAMS_CSV_COLUMNS.values())}\n"
    texts = [csv_text([SEAMS_CSV_COLUMNS])]
    for seam in record["seams"]:
        name, accepted = cell_text(seam["name"]), "yes" if seam["accepted"] else "no"
        texts += [
            row % (name, number, frame["s_mm"], *frame["p_mm"], *frame["q_xyzw"], accepted)
            for number, frame in enumerate(seam["frames"])
        ]
    return "".join(texts)


_PLACE, _TURN = "%.9g", "%.12g"
SEAMS_CSV_COLUMNS = {
    "seam": "%s",
    "point": "%d",
    "s_mm": _PLACE,
    "x_mm": _PLACE,
    "y_mm": _PLACE,
    "z_mm": _PLACE,
    "qx": _TURN,
    "qy": _TURN,
    "qz": _TURN,
    "qw": _TURN,
    "accepted": "%s",
}
"""The columns of ``seams.csv`` in order, and how each is written. `seams_csv` fills them in this order."""


def seams_from_record(record: dict[str, Any], *, path: str) -> tuple[Seam, ...]:
    """Return the seams of a ``seams.json``, in the coordinates of the file and without pieces of edges.

    Raises `FormatError` if a field is missing or has the wrong shape, or a value is not what its field says
    (`check_seams`).
    """
    try:
        check_seams(record, path=path)
        return tuple(_seam_from_record(seam, record["frame"]) for seam in record["seams"])
    except FormatError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        check_record(record, SEAMS_SCHEMA, path=path, is_complete=True)  # says what is missing, and where
        raise FormatError(f"is not a complete seams file: {type(error).__name__} {error}", path=path) from None


def _seam_from_record(seam: dict[str, Any], frame: str) -> Seam:
    rows = seam["frames"]
    gap, (lean, spin), other = seam["gap_mm"], leans_from_records(rows), seam.get("other_torch")
    i, f = np.zeros(0, dtype=np.int64), np.zeros(0)
    pieces = SeamPieces(i, f, f, i, i, np.array([[gap["min"], gap["mean"], gap["max"]]], dtype=np.float64))
    return Seam(
        seam["name"],
        JointType(seam["joint"]),
        WeldType(seam["weld"]),
        tuple(seam["solids"]),
        pieces,
        seam["closed"],
        float(seam["length_mm"]),
        seam["reachable"],
        seam["accepted"],
        tuple(seam["reasons"]),
        frames_from_records(rows, frame),
        SeamSource(seam.get("source", SeamSource.CONTACT.value)),
        float(seam.get("confidence", 1.0)),
        _findings_from_record(seam),
        inside=tuple(seam.get("inside", ())),
        blocked_by=tuple(seam.get("blocked_by", ())),
        hiding=tuple(Hiding(**one) for one in seam.get("hiding", ())),
        lean_rad=lean,
        spin_rad=spin,
        more_wire_mm=float(seam.get("more_wire_mm", 0.0)),
        other_torch=None if other is None else OtherTorch(**other),
        groove=FlareGroove(**seam["groove"]) if "groove" in seam else None,
        bead_mm=seam.get("bead_mm"),
        wrap_of=seam.get("wrap_of"),
    )


def errors_from_record(record: Mapping[str, Any]) -> tuple[FloatArray | None, ...]:
    """Return the 95 % errors at the frames of every seam of a record, shape (n,), mm; None where it has none."""
    columns = [[frame.get("u95_mm") for frame in seam["frames"]] for seam in record["seams"]]
    return tuple(frozen(column) if column and None not in column else None for column in columns)
