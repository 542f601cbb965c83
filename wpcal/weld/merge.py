"""What a second file states about welds, added to what the first one states: value by value, seam by seam."""

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from wpcal.weld.place import SeamPlace, StatedWeld, pair


def merge_stated(
    first: Sequence[StatedWeld], second: Sequence[StatedWeld], places: Sequence[tuple[str, SeamPlace]]
) -> tuple[tuple[StatedWeld, ...], tuple[str, ...]]:
    """Add what a second file states to what a first one states.

    Returns `notes`: tuple of str. One line per value of the first file that the second one changed.

    `first`, `second`: The second counts where both state a value; what only the first one states stays, unless the
    second gives the value back to the rules.
    """
    rows = [pair(stated, places) for stated in (first, second)]
    merged, notes = list[StatedWeld](), list[str]()
    for name, _ in places:
        old, new = (found.welds.get(name) for found in rows)
        if old is None or new is None:
            merged += filter(None, (old, new))
            continue
        merged.append(_added(old, new))
        notes += [f"{name}: {change}" for change in _changes(old, new)]
    left = {(one.name, one.place): one for one in rows[0].left}
    for new in rows[1].left:
        old = left.pop((new.name, new.place), None)
        merged.append(new if old is None else _added(old, new))
    return (*merged, *left.values()), tuple(notes)


def _added(old: StatedWeld, new: StatedWeld) -> StatedWeld:
    user = {name: value for name, value in old.user.items() if name not in new.given_back}
    files = {name: value for name, value in {**old.files, **new.files}.items() if name not in new.user}
    return replace(new, user={**user, **new.user}, files=files)


def _changes(old: StatedWeld, new: StatedWeld) -> list[str]:
    """Return what becomes of values of a person, in words."""
    found = []
    for name, value in old.user.items():
        if name in new.user and new.user[name] != value:
            found.append(f"{name} {_shown(value)} becomes {_shown(new.user[name])}")
        elif name in new.given_back and name not in new.user:
            found.append(f"{name} {_shown(value)} goes back to the rules")
    return found


def _shown(value: Any) -> str:
    return "none" if value is None else value if isinstance(value, str) else json.dumps(value)
