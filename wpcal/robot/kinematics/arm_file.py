"""Arms as JSON files (schema ``wpcal/arm/1``), and the ones that come with wpcal."""

from __future__ import annotations

from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from wpcal.core.errors import FormatError, InputError, fields_of
from wpcal.core.input_file import require_name
from wpcal.core.records import read_json
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm, Coupling, Joint
from wpcal.robot.kinematics.forward import MDHChain
from wpcal.robot.kinematics.urdf import read_urdf

ARM_SCHEMA = "wpcal/arm/1"
T = TypeVar("T")


def shipped_arms() -> list[str]:
    """Return the names of the arms that come with wpcal: what `find_arm` takes beside a path."""
    return sorted(file.name.removesuffix(".json") for file in _folder().iterdir() if file.name.endswith(".json"))


def _folder() -> resources.abc.Traversable:
    return resources.files("wpcal.robot") / "arms"


def find_arm(name_or_path: str) -> Arm:
    """Return a shipped arm by name (``mh6``), or read an arm file or a URDF file.

    Raises `InputError` when it is neither a shipped name nor a file; the message lists the names.
    Raises `FormatError` when the file breaks the format.

    A URDF file knows no couplings of joints: a J3 that is shown against the horizontal is then counted as the elbow
    turns.
    """
    if name_or_path in shipped_arms():
        with resources.as_file(_folder() / f"{name_or_path}.json") as path:
            return read_arm(path)
    path = Path(name_or_path)
    require_name(path)
    if not path.exists():
        raise InputError(f"{name_or_path}: no such file, and no shipped arm; shipped are {', '.join(shipped_arms())}")
    return read_urdf(path) if path.suffix.lower() == ".urdf" else read_arm(path)


def read_arm(path: Path) -> Arm:
    """Read an arm file.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when a field is missing or wrong, or the numbers of links and joints differ.
    """
    record = read_json(path, schema=ARM_SCHEMA)
    with fields_of(str(path), FormatError):
        return arm_from_record(record)


def arm_from_record(record: dict[str, Any]) -> Arm:
    """Return the arm of a record; `KeyError`, `TypeError` or `InputError` when a field is missing or wrong."""
    nominal = record.get("nominal")
    return Arm(
        name=str(record["name"]),
        chain=_chain(record),
        joints=tuple(_joint(joint) for joint in record["joints"]),
        couplings=tuple(
            Coupling(str(c["joint"]), str(c["adds"]), float(c["factor"])) for c in record.get("couplings", ())
        ),
        source=str(record.get("source", "")),
        licence=str(record.get("licence", "")),
        notes=tuple(str(note) for note in record.get("notes", ())),
        mount_mm=record.get("mount_mm", (0.0, 0.0, 0.0)),
        space=RobotSpace.parse(record["robot_space"]),
        nominal=None if nominal is None else _chain(nominal),
        unseen_tool_mm=float(record.get("unseen_tool_mm", 0.0)),
    )


def _chain(record: dict[str, Any]) -> MDHChain:
    links = record["links"]
    if not isinstance(links, list) or not links:
        raise InputError("links: expected a list with one entry a joint")
    return MDHChain(
        theta=np.deg2rad([float(link["theta_deg"]) for link in links]),
        d=[float(link["d_mm"]) for link in links],  # type: ignore[arg-type]  # frozen in __post_init__
        a=[float(link["a_mm"]) for link in links],  # type: ignore[arg-type]
        alpha=np.deg2rad([float(link["alpha_deg"]) for link in links]),
        beta=np.deg2rad([float(link.get("beta_deg", 0.0)) for link in links]),
        hayati=tuple(_flag(link.get("parallel_to_next", False)) for link in links),
        T_base_dh0=_transform(record.get("T_base_dh0"), target="base", source="dh0"),
        T_dhn_flange=_transform(record.get("T_dhn_flange"), target="dhn", source="flange"),
    )


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"parallel_to_next is true or false, got {value!r}")
    return value


def _joint(record: dict[str, Any]) -> Joint:
    speed, pulses = record.get("speed_deg_s"), record.get("pulses_per_deg")
    return Joint(
        name=str(record["name"]),
        sign=int(record.get("sign", 1)),
        min_rad=float(np.deg2rad(float(record["min_deg"]))),
        max_rad=float(np.deg2rad(float(record["max_deg"]))),
        speed_rad_s=None if speed is None else float(np.deg2rad(float(speed))),
        pulses_per_deg=None if pulses is None else float(pulses),
    )


def _transform(record: dict[str, Any] | None, *, target: str, source: str) -> RigidTransform:
    if record is None:
        return RigidTransform.identity(target=target, source=source)
    return RigidTransform.from_record(record, target=target, source=source)


def arm_record(arm: Arm) -> dict[str, Any]:
    """Return an arm as plain values for a JSON file; `read_arm` reads them back to round-off."""
    record: dict[str, Any] = {
        "schema": ARM_SCHEMA,
        "name": arm.name,
        "source": arm.source,
        "licence": arm.licence,
        "robot_space": arm.space.value,
        **_chain_record(arm.chain),
        "joints": [_joint_record(joint) for joint in arm.joints],
        "couplings": [{"joint": c.joint, "adds": c.adds, "factor": c.factor} for c in arm.couplings],
        "mount_mm": arm.mount_mm.tolist(),
        "notes": list(arm.notes),
    }
    if arm.nominal is not None:
        record["nominal"] = _chain_record(arm.nominal)
        record["unseen_tool_mm"] = arm.unseen_tool_mm
    return record


def _chain_record(chain: MDHChain) -> dict[str, Any]:
    links = [
        {
            "theta_deg": float(np.rad2deg(theta)),
            "d_mm": float(d),
            "a_mm": float(a),
            "alpha_deg": float(np.rad2deg(alpha)),
            "beta_deg": float(np.rad2deg(beta)),
            "parallel_to_next": parallel,
        }
        for (theta, d, a, alpha, beta), parallel in zip(chain.table.T, chain.hayati, strict=True)
    ]
    return {"links": links, "T_base_dh0": chain.T_base_dh0.to_record(), "T_dhn_flange": chain.T_dhn_flange.to_record()}


def _joint_record(joint: Joint) -> dict[str, Any]:
    return {
        "name": joint.name,
        "sign": joint.sign,
        "min_deg": float(np.rad2deg(joint.min_rad)),
        "max_deg": float(np.rad2deg(joint.max_rad)),
        "speed_deg_s": None if joint.speed_rad_s is None else float(np.rad2deg(joint.speed_rad_s)),
        "pulses_per_deg": joint.pulses_per_deg,
    }
