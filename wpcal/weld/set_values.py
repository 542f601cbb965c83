"""Values of welds as a person types them on the command line: ``W1-W4:leg_mm=5``."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from wpcal.core.errors import FormatError, InputError
from wpcal.core.record_check import check_record, find_faults
from wpcal.seam.names import seams_named, split_names
from wpcal.weld.place import StatedWeld
from wpcal.weld.record import WELDS_SCHEMA
from wpcal.weld.values import VALUE_NAMES, refuse_unknown


def set_values(stated: Sequence[StatedWeld], settings: Sequence[str], seams: Sequence[str]) -> tuple[StatedWeld, ...]:
    """State values of the welds in some seams.

    Raises `InputError` if a setting is not of this form, or a seam, a name or a value cannot be used.

    `settings`: ``SEAMS:NAME=VALUE``. The value is JSON (a number, ``null``, an object) or a text, whichever the name
    takes: a process is the text ``135``. An empty one gives the value back to the rules.
    """
    welds = {weld.name: weld for weld in stated}
    others = [weld for weld in stated if welds[weld.name] is not weld]
    for setting in settings:
        words, colon, pair = setting.partition(":")
        name, equals, text = (part.strip() for part in pair.partition("="))
        if not (colon and equals and name):
            raise InputError(f"--set {setting}: expected SEAMS:NAME=VALUE, for example W1-W4:leg_mm=5")
        try:
            named = seams_named(split_names(words), seams)
            refuse_unknown({name: text}, VALUE_NAMES, what="a weld")
            values: dict[str, Any] = {name: text}
            record = {"welds": [{"name": words, "values": values}]}
            takes_text = not find_faults(record, WELDS_SCHEMA)
            values[name] = _value(text)
            if takes_text and find_faults(record, WELDS_SCHEMA):
                values[name] = text
            if text:
                check_record(record, WELDS_SCHEMA, path="--set")
        except FormatError as error:
            raise InputError(f"--set {setting}: {error.what}") from None
        except InputError as error:
            raise InputError(f"--set {setting}: {error}") from None
        for seam in named:
            old = welds.get(seam, StatedWeld(seam, None, {}))
            user = {key: kept for key, kept in old.user.items() if key != name}
            welds[seam] = replace(old, user={**user, **values} if text else user)
    return (*welds.values(), *others)


def _value(text: str) -> Any:
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return text
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"expected a finite number, got {text}")
    return value
