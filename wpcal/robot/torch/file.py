"""Torches as JSON files (schema ``wpcal/torch/1``), and the ones that come with wpcal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from wpcal.core.errors import FormatError, InputError, fields_of
from wpcal.core.input_file import read_bytes, require_name
from wpcal.core.record_check import check_record
from wpcal.core.records import parse_json, read_json
from wpcal.robot.torch.shape import Neck, TorchShape

TORCH_SCHEMA, TORCHES_SCHEMA, CELL_SCHEMA = "wpcal/torch/1", "wpcal/torches/1", "wpcal/cell/1"


@dataclass(frozen=True, slots=True)
class ShippedTorch:
    """A torch that comes with wpcal."""

    shape: TorchShape
    title: str  #: What it is, for people.
    source: str  #: Where its sizes come from.


@cache
def shipped_torches() -> tuple[ShippedTorch, ...]:
    """Return the torches that come with wpcal, the most usual first."""
    found = []
    with resources.as_file(resources.files("wpcal.robot.torch") / "torches") as folder:
        for path in sorted(folder.glob("*.json")):
            record = _record(path)
            found.append((record["rank"], ShippedTorch(_shape(record, path), record["title"], record["source"])))
    return tuple(torch for _, torch in sorted(found, key=lambda item: int(item[0])))


def find_torch(name_or_path: str) -> TorchShape:
    """Return a shipped torch by name (``robot-22``), or read a torch file.

    Raises `InputError` if it is neither a shipped name nor a file, or its sizes are not those of a torch. The message
    lists the names.
    Raises `FormatError` if the file breaks the format.
    """
    shipped = {torch.shape.name: torch.shape for torch in shipped_torches()}
    if name_or_path in shipped:
        return shipped[name_or_path]
    path = Path(name_or_path)
    require_name(path)
    if not path.exists():
        raise InputError(f"{name_or_path}: no such file, and no shipped torch; shipped are {', '.join(shipped)}")
    return read_torch(path)


def read_torch(path: Path) -> TorchShape:
    """Read a torch file, whose name it has, or the torch of a cell file.

    Raises `InputError` if the file cannot be opened, or its sizes are not those of a torch.
    Raises `FormatError` if the file breaks the format, or is a cell file that does not state a torch.
    """
    record = parse_json(read_bytes(path), path=str(path))
    if not isinstance(record, dict) or record.get("schema") != CELL_SCHEMA:
        return _shape(_record(path), path)
    found = torch_of_seams({"torch": read_json(path, schema=CELL_SCHEMA)["torch_robot"].get("torch_shape")}, path)
    if found is None:
        raise FormatError("torch_robot states no torch_shape: make the cell again with wpcal cell new", path=str(path))
    return found


def torches_record(shapes: Sequence[TorchShape]) -> dict[str, Any]:
    """Return torches as ``wpcal torches --json`` prints them, with the fields of ``torch`` in ``seams.json``."""
    return {"schema": TORCHES_SCHEMA, "torches": [without_none(asdict(shape)) for shape in shapes]}


def without_none(record: dict[str, Any]) -> dict[str, Any]:
    """Return a record without the fields, also inner ones, that hold nothing."""
    kept = {key: value for key, value in record.items() if value is not None}
    return {key: without_none(value) if isinstance(value, dict) else value for key, value in kept.items()}


def torch_from_fields(record: dict[str, Any]) -> TorchShape:
    """Return the torch that ``torch`` of a ``seams.json`` states (`wpcal.seam.record.seams_record` writes it)."""
    fields = dict(record)
    neck = fields.pop("neck", None)
    return TorchShape(**fields, neck=None if neck is None else Neck(**neck))


def torch_of_seams(record: Mapping[str, Any], path: Path) -> TorchShape | None:
    """Return the torch with which the seams of a ``seams.json`` were felt; None in files that do not state it.

    Raises `FormatError` if it is not complete, or its sizes are not those of a torch.
    """
    if record.get("torch") is None:
        return None
    try:
        return torch_from_fields(record["torch"])
    except InputError as error:
        raise FormatError(str(error), path=str(path)) from None
    except (AttributeError, TypeError, ValueError) as error:
        raise FormatError(f"torch is not complete: {error}", path=str(path)) from None


def _record(path: Path) -> dict[str, Any]:
    record = read_json(path, schema=TORCH_SCHEMA)
    check_record(record, TORCH_SCHEMA, path=str(path), is_complete=True)
    return record


def _shape(record: dict[str, Any], path: Path) -> TorchShape:
    with fields_of(str(path)):
        return shape_from_record(record, path.stem)


def shape_from_record(record: dict[str, Any], name: str) -> TorchShape:
    """Return the shape that a record of a torch describes: diameters become radii."""
    wire, nozzle, neck = record["wire"], record["nozzle"], record.get("neck")
    mouth = nozzle.get("mouth_diameter_mm")
    return TorchShape(
        wire_mm=float(wire["usual_mm"]),
        nozzle_radius_mm=nozzle["diameter_mm"] / 2.0,
        length_mm=float(record["length_mm"]),
        name=name,
        mouth_radius_mm=None if mouth is None else mouth / 2.0,
        taper_mm=float(nozzle.get("taper_mm", 0.0)),
        neck=None
        if neck is None
        else Neck(
            angle_deg=float(neck["angle_deg"]),
            from_mm=float(neck["from_mouth_mm"]),
            bend_mm=float(neck["bend_radius_mm"]),
            radius_mm=neck["diameter_mm"] / 2.0,
            body_from_mm=float(neck["body_from_mm"]),
            body_radius_mm=neck["body_diameter_mm"] / 2.0,
        ),
        most_wire_mm=float(wire.get("most_mm", wire["usual_mm"])),
    )
