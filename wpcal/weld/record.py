"""`welds.json`: what is laid into every seam, edited by hand.

Change a value in ``values``: it is then stated by the user, and later runs keep it. Delete a value to get that of the
rules again; null states that there is none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.records import read_json
from wpcal.core.result_files import PART_FILE, SEAMS_FILE
from wpcal.core.wording import listed
from wpcal.weld.place import SeamPlace, StatedWeld
from wpcal.weld.rules import RuleTable
from wpcal.weld.seam_weld import SeamWeld
from wpcal.weld.values import VALUE_NAMES, describe_weld, plain, refuse_unknown

WELDS_SCHEMA = "wpcal/welds/1"
OWN_RULES = "wpcal"  #: In a file: the table of rules of wpcal.
OWN_FILES = (PART_FILE, SEAMS_FILE)
"""Files of a result folder that state values. These are found again at every run."""


def welds_record(welds: Sequence[SeamWeld], left: Sequence[StatedWeld], rules: RuleTable) -> dict[str, Any]:
    """Return the record of ``welds.json``."""
    return {
        "schema": WELDS_SCHEMA,
        "units": {"length": "mm", "angle": "deg", "time": "s"},
        "rules": rules.file or OWN_RULES,
        "welds": [_weld_record(weld) for weld in welds],
        "without_seam": [
            {"name": one.name, **({"place": one.place.to_record()} if one.place else {}), "values": dict(one.user)}
            for one in left
        ],
    }


def _weld_record(weld: SeamWeld) -> dict[str, Any]:
    stated = [name for name in VALUE_NAMES if name in weld.origins]
    return {
        "name": weld.name,
        "words": describe_weld(weld.values),
        "joint": weld.joint.value,
        "place": weld.place.to_record(),
        "values": {name: plain(getattr(weld.values, name)) for name in stated},
        "origin": {
            name: {"from": own.source.value, **({"of": own.of} if own.of else {}), "given": own.given}
            for name, own in ((name, weld.origins[name]) for name in stated)
        },
        "beads": [asdict(bead) for bead in weld.beads],
        "stretches_mm": [list(one) for one in weld.stretches_mm],
        "tacks_mm": [list(one) for one in weld.tacks_mm],
    }


def read_stated_welds(path: Path, rules: RuleTable) -> tuple[StatedWeld, ...]:
    """Read what a person stated in a ``welds.json``.

    Returns: One per weld of the file, also of those without a seam. A value counts as stated by the user if the file
    says so, or if it differs from what a rule or a file gave.

    Raises `InputError` if the file cannot be opened.
    Raises `FormatError` if it is not such a record, a value is not what its name says, a name is unknown, two welds
    have one name, or it was written with rules of the user, and `rules` are those of wpcal.
    """
    record = read_json(path, schema=WELDS_SCHEMA)
    if record.get("rules", OWN_RULES) != OWN_RULES and not rules.file:
        what = f"was written with the rules of {record['rules']}; give this file, or its values would be lost"
        raise FormatError(what, path=str(path), code=ErrorCode.WELD_RULES_MISSING)
    entries = [*record.get("welds", []), *record.get("without_seam", [])]
    found, seen = [], set[str]()
    for number, entry in enumerate(entries):
        name = entry.get("name")
        if name is None:
            raise FormatError(f"welds[{number}]: lacks the name of a seam", path=str(path))
        try:
            named = {**entry.get("values", {}), **dict.fromkeys(entry.get("given_back", ()))}
            refuse_unknown(named, VALUE_NAMES, what=f"weld {name}")
        except InputError as error:
            raise FormatError(str(error), path=str(path)) from None
        place = _place(entry.get("place"), name, path=str(path))
        given_back = tuple(entry.get("given_back", ()))
        found.append(StatedWeld(name, place, _stated_by_user(entry), _stated_by_files(entry), given_back))
    for entry in record.get("welds", []):
        if entry["name"] in seen:
            raise FormatError(f"two welds are for seam {entry['name']}; expected one", path=str(path))
        seen.add(entry["name"])
    return tuple(found)


def changed_since(path: Path, welds: Sequence[SeamWeld]) -> list[str]:
    """Name values in a ``welds.json`` that nobody stated and that are other ones today: one line, or none."""
    found, entries = dict[str, list[str]](), read_json(path, schema=WELDS_SCHEMA).get("welds", [])
    for weld, entry in ((weld, entry) for weld in welds for entry in entries if entry["name"] == weld.name):
        values, now = entry.get("values", {}), weld.values.to_record()
        if changed := [name for name in values if name not in _stated_by_user(entry) and now.get(name) != values[name]]:
            found[weld.name] = changed
    names = listed(dict.fromkeys(name for each in found.values() for name in each))
    what = f"the program has other values ({names}): rules, part or position have changed since this file was written"
    return [f"{listed(found)}: {what}"] if found else []


def _place(record: Any, name: str, *, path: str) -> SeamPlace | None:
    try:
        return None if record is None else SeamPlace.from_record(record)
    except KeyError as error:
        raise FormatError(f"weld {name}: place: lacks {error.args[0]}", path=path) from None


def _stated_by_user(entry: Mapping[str, Any]) -> dict[str, Any]:
    origins = entry.get("origin", {})
    return {
        name: value
        for name, value in entry.get("values", {}).items()
        if origins.get(name, {}).get("from", "user") == "user" or origins[name].get("given") != value
    }


def _stated_by_files(entry: Mapping[str, Any]) -> dict[str, tuple[Any, str]]:
    own, values = entry.get("origin", {}), entry.get("values", {})
    return {
        name: (origin["given"], str(origin.get("of", "")))
        for name, origin in own.items()
        if origin.get("from") == "file"
        and origin.get("of") not in OWN_FILES
        and name in values
        and values[name] == origin.get("given")
    }
