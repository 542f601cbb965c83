"""The page of `wpcal welds --html`: every value of every weld, where it came from, and an editor of values.

The page gives away a ``welds.json`` that holds only what people and files stated. The commands take it with
``--values`` and ``--welds``, and compute anew what follows from it.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from wpcal.core.schemas import schema_text
from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import PLACE_DIGITS, TURN_DIGITS
from wpcal.results.folder import FinishedCalibration

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to edit the values; welds.json is a text file with the same values.</noscript>
"""
FILE = "welds-edited.json"
"""The name under which the browser saves. It is never that of the file that the commands write."""
GROUPS: Mapping[str, tuple[str, ...]] = {
    "size": ("weld", "throat_mm", "leg_mm", "passes"),
    "joint": ("thickness_mm", "position", "depth_mm", "root_gap_mm", "root_face_mm", "groove_angle_deg"),
    "arc": ("process", "wire_mm", "current_a", "voltage_v", "wire_feed_m_min", "speed_mm_s"),
    "controller": ("job", "seam_data", "weld_data", "weave_data"),
    "torch": ("stick_out_mm", "work_angle_deg", "travel_angle_deg", "weave"),
    "start and end": ("start_delay_s", "end_delay_s", "crater"),
    "stretches": ("stitch", "tacks"),
}
"""The columns of the table, in groups that can be shown alone."""
UNITS = {"_m_min": "m/min", "_mm_s": "mm/s", "_mm": "mm", "_deg": "°", "_s": "s", "_a": "A", "_v": "V"}
"""By the end of a name; the longer ends first."""


def build_welds_page(
    record: Mapping[str, Any],
    rules: Mapping[str, Any],
    chosen: FinishedCalibration,
    *,
    folder: str,
    found_again: Sequence[str],
    command: Sequence[str],
) -> str:
    """Return the page that shows and edits weld data, in the part's own frame.

    `found_again`: Files whose values are read anew by the command, and are not in what is saved.
    Returns: A self-contained HTML file, the same for the same record.
    """
    by_name = {seam.name: seam for seam in chosen.seams}
    given = {weld["name"]: {"values": weld["values"], "origin": weld["origin"]} for weld in rules["welds"]}
    T_part_base = chosen.T_base_part.inverse()
    entries, lines = [], []
    for weld in record["welds"]:
        seam = by_name[weld["name"]]
        own = {key: weld[key] for key in ("name", "words", "joint", "place", "values", "origin")}
        entries.append({**own, "rules": given[weld["name"]], "length_mm": seam.length_mm})
        p, R = T_part_base.apply(seam.frames.p), T_part_base.R @ seam.frames.R
        lines.append({"p": np.round(p, PLACE_DIGITS).tolist(), "R": np.round(R, TURN_DIGITS).tolist()})
    data = {
        "folder": folder,
        "file": FILE,
        "command": shlex.join([*command, "--values", FILE]),
        "head": {key: record[key] for key in ("schema", "units", "rules")},
        "welds": entries,
        "without_seam": record["without_seam"],
        "found_again": list(found_again),
        "fields": value_fields(record["schema"]),
    }
    blobs = {"lines": json_blob(lines)}
    if chosen.part_glb is not None:
        blobs["part"] = chosen.part_glb
    return build_page(title=f"Welds of {folder}", entry="welds", body=BODY, data=data, blobs=blobs)


def value_fields(of: str) -> list[dict[str, Any]]:
    """Return what can be typed for every value: its group, unit, meaning and limits, as the schema has them."""
    schema = json.loads(schema_text(of))
    definitions = schema["$defs"]
    properties = definitions["Values"]["properties"]
    group_of = {name: group for group, names in GROUPS.items() for name in names}
    found = []
    for name in sorted(properties, key=[*group_of].index):
        own = _stated(properties[name])
        inner = definitions[own["$ref"].rpartition("/")[2]] if "$ref" in own else None
        parts = (
            [_part(name, own, is_needed=True)]
            if inner is None
            else [_part(each, part, is_needed=each in inner["required"]) for each, part in inner["properties"].items()]
        )
        label, unit = _label(name)
        described = own.get("description") or ("" if inner is None else inner.get("description", ""))
        words = {"name": name, "label": label, "unit": unit, "group": group_of[name], "what": described}
        found.append({**words, "is_record": inner is not None, "parts": parts})
    return found


def _stated(schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a value that is stated: null, which states that there is none, is left out."""
    (own,) = (each for each in schema.get("anyOf", ({},)) if each != {"type": "null"})
    return {**schema, **own}


def _part(name: str, schema: Mapping[str, Any], *, is_needed: bool) -> dict[str, Any]:
    label, unit = _label(name)
    schema = _stated(schema)
    part = {"name": name, "label": label, "unit": unit, "is_needed": is_needed}
    if "enum" in schema:
        return {**part, "kind": "choice", "choices": schema["enum"]}
    if schema["type"] == "string":
        return {**part, "kind": "text", "pattern": schema.get("pattern", "")}
    low = schema.get("exclusiveMinimum", schema.get("minimum"))
    limits = {"low": low, "is_low_open": "exclusiveMinimum" in schema, "high": schema.get("maximum")}
    return {**part, "kind": "whole" if schema["type"] == "integer" else "number", **limits}


def _label(name: str) -> tuple[str, str]:
    """Return the words and the unit of a value's name."""
    end = next((end for end in UNITS if name.endswith(end)), "")
    return name.removesuffix(end).replace("_", " "), UNITS.get(end, "")
