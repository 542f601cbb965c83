"""``touches.json``, the record of a plan of touches, and ``touches.csv``, the same searches as a taught table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError, InputError
from wpcal.core.record_check import check_record
from wpcal.core.records import read_json
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm_file import arm_from_record, arm_record
from wpcal.touch.searches.plan import (
    Contact,
    FirstStage,
    PlannedBody,
    SeamPrediction,
    Search,
    SearchKind,
    Served,
    TouchPlan,
)

TOUCHES_SCHEMA = "wpcal/touches/1"
TOUCHES_FILE = "touches.json"
CSV_DIGITS = 4  #: Decimals of mm in the table: 0.1 µm.
_POINTS = ("approach", "start", "end", "retract")


def touches_record(plan: TouchPlan) -> dict[str, Any]:
    """Return the record of ``touches.json``: lengths in mm, joints in degrees."""
    known, rows = plan.first_stage, plan.first_stage and plan.first_stage.covariance.tolist()
    return {
        "schema": TOUCHES_SCHEMA,
        "units": {"length": "mm", "angle": "deg"},
        "part": plan.part,
        "fingerprint": plan.fingerprint,
        "T_base_part": plan.T_base_part.to_record(),
        "wire_mm": plan.wire_mm,
        "stick_out_mm": plan.stick_out_mm,
        **({"standoff_mm": plan.standoff_mm} if plan.standoff_mm else {}),
        "robot": plan.robot,
        "arm": None if plan.arm is None else arm_record(plan.arm),
        "home_joints_deg": _degrees(plan.home_joints),
        "predicted": None if plan.predicted is None else _prediction_record(plan.predicted),
        "notes": list(plan.notes),
        "bodies": [{"name": b.name, "tack_mm": b.tack_mm, "tack_mrad": b.tack_mrad} for b in plan.bodies],
        **({} if known is None else {"first_stage": {"centre_mm": known.centre_part.tolist(), "covariance": rows}}),
        "searches": [_search_record(search) for search in plan.searches],
    }


def _prediction_record(predicted: SeamPrediction) -> dict[str, Any]:
    by_seam = [{"seam": name, "error_95_mm": error} for name, error in predicted.by_seam_mm]
    return {
        "error_95_mm": predicted.error_95_mm,
        "seam": predicted.seam,
        "by_seam": by_seam,
        "joint_95_mm": predicted.joint_95_mm,
        "unseen_mm": predicted.unseen_mm,
        "why_not": predicted.why_not,
    }


def _search_record(search: Search) -> dict[str, Any]:
    return {
        "name": search.name,
        "kind": search.kind.value,
        "target": search.target,
        "feature": search.feature,
        "contact": search.contact.value,
        "contact_mm": search.contact_part.tolist(),
        "normal": search.normal_part.tolist(),
        "radius_mm": search.radius_mm,
        "R_part_tool": search.R_part_tool.tolist(),
        "via_mm": search.via.reshape(-1, 3).tolist(),
        **{f"{name}_mm": getattr(search, name).tolist() for name in _POINTS},
        "covariance_mm2": search.covariance_part.tolist(),
        "joints_deg": _degrees(search.joints),
        "via_joints_deg": _degrees(search.via_joints),
        "body": search.body,
        "serves": (at := search.serves) and {"seam": at.seam, "before_mm": at.before_mm, "after_mm": at.after_mm},
        "axis": None if search.axis is None else search.axis.tolist(),
    }


def plan_from_record(record: Mapping[str, Any], *, path: str = "") -> TouchPlan:
    """Return the plan that a record holds.

    Raises `FormatError` when a field is missing, or the searches are not usable.
    """
    try:
        own = record.get("first_stage")
        return TouchPlan(
            part=record["part"],
            searches=tuple(_search(each) for each in record["searches"]),
            T_base_part=RigidTransform.from_record(record["T_base_part"], target="base", source="part"),
            wire_mm=float(record["wire_mm"]),
            stick_out_mm=float(record["stick_out_mm"]),
            standoff_mm=float(record.get("standoff_mm", 0.0)),
            home_joints=_radians(record.get("home_joints_deg")),
            robot=record.get("robot", ""),
            arm=None if record.get("arm") is None else arm_from_record(record["arm"]),
            predicted=_prediction(record.get("predicted")),
            notes=tuple(record.get("notes", ())),
            bodies=tuple(PlannedBody(**each) for each in record.get("bodies", ())),
            first_stage=None if own is None else FirstStage(_array(own["centre_mm"]), _array(own["covariance"])),
        )
    except KeyError as error:
        raise FormatError(f"lacks the field {error.args[0]}", path=path) from None
    except (TypeError, AttributeError) as error:
        check_record(record, TOUCHES_SCHEMA, path=path, is_complete=True)  # says what is missing, and where
        raise FormatError(f"is not a complete plan of touches: {error}", path=path) from None
    except InputError as error:
        raise FormatError(str(error), path=path) from None


def read_touch_plan(path: Path) -> TouchPlan:
    """Read ``touches.json``.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not a plan of touches.
    """
    file = path / TOUCHES_FILE if path.is_dir() else path
    return plan_from_record(read_json(file, schema=TOUCHES_SCHEMA), path=str(file))


def touches_csv(plan: TouchPlan) -> str:
    """Return ``touches.csv``: a table for `wpcal calibrate`, the touched coordinates to be filled in.

    Further columns hold the search in `part`: its start, its end, and the axis z of the tool. The searches of posts are
    left out.
    """
    header = ["name", "kind", "x_mm", "y_mm", "z_mm", "model_x_mm", "model_y_mm", "model_z_mm", "radius_mm"]
    header += [f"{end}_{axis}_mm" for end in ("start", "end") for axis in "xyz"]
    header += [f"tool_z_{axis}" for axis in "xyz"]
    rows: list[list[object]] = [[*header, "contact", "feature_touched", *(["body"] if plan.bodies else [])]]
    for search in plan.searches:
        if search.kind is SearchKind.PART:
            numbers = [*search.contact_part, search.radius_mm, *search.start, *search.end, *search.R_part_tool[:, 2]]
            texts = [f"{round(v, CSV_DIGITS) + 0.0:.{CSV_DIGITS}f}" for v in numbers]
            own = [search.contact.value, search.feature, *([search.body] if plan.bodies else [])]
            rows.append([search.name, search.target, "", "", "", *texts, *own])
    return csv_text(rows)


def _search(record: Mapping[str, Any]) -> Search:
    R = _array(record["R_part_tool"])
    RigidTransform(R, np.zeros(3), "part", "tool")  # refuses what is not a rotation
    return Search(
        name=record["name"],
        target=record["target"],
        feature=record.get("feature", ""),
        contact_part=_array(record["contact_mm"]),
        normal_part=_array(record["normal"]),
        contact=Contact(record["contact"]),
        radius_mm=float(record["radius_mm"]),
        R_part_tool=R,
        via=_array(record.get("via_mm", [])).reshape(-1, 3),
        **{name: _array(record[f"{name}_mm"]) for name in _POINTS},
        covariance_part=_array(record["covariance_mm2"]),
        joints=_radians(record.get("joints_deg")),
        via_joints=_radians(record.get("via_joints_deg")),
        kind=SearchKind(record.get("kind", SearchKind.PART.value)),
        body=record.get("body", ""),
        serves=None if record.get("serves") is None else Served(**record["serves"]),
        axis=None if record.get("axis") is None else _array(record["axis"]),
    )


def _prediction(record: Mapping[str, Any] | None) -> SeamPrediction | None:
    if record is None:
        return None
    by_seam = tuple((each["seam"], float(each["error_95_mm"])) for each in record["by_seam"])
    others = {name: record[name] for name in ("joint_95_mm", "unseen_mm", "why_not") if name in record}
    return SeamPrediction(float(record["error_95_mm"]), record["seam"], by_seam, **others)


def _array(values: Any) -> FloatArray:
    try:
        return np.asarray(values, dtype=np.float64)
    except ValueError:
        raise InputError("joints: the rows have different lengths") from None


def _degrees(joints: FloatArray | None) -> list[Any] | None:
    return None if joints is None else list(np.degrees(joints).tolist())


def _radians(joints: Any) -> FloatArray | None:
    return None if joints is None else np.radians(_array(joints))
