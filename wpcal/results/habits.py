"""What a shop decides again and again about seams, as rules on the names of solids.

A seam that is refused by hand at every clamp, and a seam that is accepted by hand at every pin, are one decision each
time. As a rule (``not``, ``weld`` in ``wpcal.toml``) it is made once, and stands in the reasons of every seam.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import chain
from pathlib import Path
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.records import read_json
from wpcal.core.result_files import SEAMS_FILE
from wpcal.core.wording import counted, listed
from wpcal.seam.record import SEAMS_SCHEMA

LEAST_SAVED = 3  #: Decisions of one kind before they are a habit.
LEAST_PARTS = 2  #: Different parts on which they were made: what is so on one part is in its own file of decisions.
MOST_WRONG = 0.1  #: Share of wrong decisions among all that a rule makes; beyond it, it is not proposed.
NUMBER = re.compile(
    r"[\s_.:#-]*\(?\d+\)?$"
)  #: What copies of one solid differ in: ``clamp 3``, ``PAD_02``, ``M8 (2)``.
LEAST_STEM = 3  #: Letters that a name with a star keeps.


@dataclass(frozen=True, slots=True)
class Decision:
    """What was decided about one seam, or about one solid."""

    part: str  #: By which parts are told apart.
    what: str  #: The seam and its solids, in words.
    solids: tuple[str, ...]
    kind: str  #: ``not``: refused by hand; ``weld``: accepted by hand at a solid that is no member; empty: by no hand.
    is_welded: bool


@dataclass(frozen=True, slots=True)
class Habit:
    """What is decided again and again, as a rule, with what it would have saved and got wrong."""

    option: str  #: ``not`` or ``weld``.
    pattern: str
    saved: tuple[str, ...]
    wrong: tuple[str, ...]
    parts: int  #: On how many parts it saves a decision.

    def describe(self) -> str:
        """Return the rule with its evidence in a line."""
        wrong = listed(self.wrong) if self.wrong else "none"
        return f"{self.option} {self.pattern}: saves {len(self.saved)} on {counted(self.parts, 'part')}, wrong {wrong}"

    def to_record(self) -> dict[str, Any]:
        """Return the rule as JSON holds it."""
        return {"option": self.option, "pattern": self.pattern, "saved": list(self.saved), "wrong": list(self.wrong),
                "parts": self.parts}  # fmt: skip


def decisions_in(paths: Sequence[Path]) -> list[Decision]:
    """Read the decisions in files of seams, and in all such files below folders; those of one part count once.

    Raises `InputError` when there is no such file, `FormatError` when one is not what it says.
    """
    names, files = (SEAMS_FILE, "*.seams.json"), list[Path]()  # of a result, and of the picker
    for path in paths:
        files += sorted(chain(*map(path.rglob, names))) if path.is_dir() else [path]
    if not files:
        raise InputError(f"{', '.join(map(str, paths))}: no seams.json in it, and none in a folder below")
    found: dict[tuple[str, ...], Decision] = {}
    for file in files:
        record = read_json(file, schema=SEAMS_SCHEMA)
        part = repr([one["solid"] for one in record.get("members", [])])  # its seams may have been cut by hand
        for decision in (*_of_seams(record, part), *_of_solids(record, part)):
            found[(part, decision.what)] = decision
    return list(found.values())


def _of_seams(record: dict[str, Any], part: str) -> Iterator[Decision]:
    others = {one["solid"] for one in record.get("members", []) if one["factor"] < 1.0}
    for seam in record["seams"]:
        edit, solids = seam.get("edit") or {}, tuple(dict.fromkeys(seam["solids"]))
        is_learned = bool(edit.get("accept") and others & set(solids))
        kind = "not" if edit.get("reject") else "weld" if is_learned else ""
        yield Decision(part, f"{seam['name']} ({', '.join(solids)})", solids, kind, seam["accepted"])


def _of_solids(record: dict[str, Any], part: str) -> Iterator[Decision]:
    for one in record.get("members", []):
        if one.get("said") is False:
            yield Decision(part, one["solid"], (one["solid"],), "not", is_welded=False)


def learned_rules(decisions: Sequence[Decision], known: Iterable[str] = ()) -> list[Habit]:
    """Return the rules that save decisions, the one that saves most first; no decision is saved twice.

    `known`: patterns that the shop says already; what they decide teaches nothing.
    """
    said = [pattern.casefold() for pattern in known]
    left = [one for one in decisions if not (one.kind and _matches(one, said))]
    rules: list[Habit] = []
    while best := _best_rule(left):
        rules.append(best)
        left = [one for one in left if one.kind != best.option or not _matches(one, [best.pattern.casefold()])]
    return sorted(rules, key=lambda rule: -len(rule.saved))


def _best_rule(decisions: Sequence[Decision]) -> Habit | None:
    tried = [
        _rule(option, pattern, decisions) for option in ("not", "weld") for pattern in _patterns(decisions, option)
    ]
    fitting = [rule for rule in tried if rule is not None]
    return max(fitting, key=lambda one: (len(one.saved) - len(one.wrong), -len(one.pattern), one.pattern), default=None)


def _patterns(decisions: Sequence[Decision], option: str) -> list[str]:
    """Return each name of a solid, and what is left of it without its number.

    With a star: a pattern with one may fit no solid of a part (`wpcal.seam.member.note`).
    """
    names = {name for one in decisions if one.kind == option for name in one.solids}
    stems = {NUMBER.sub("", name) for name in names}
    return sorted({f"{name}*" for name in names | stems if len(name) >= LEAST_STEM})


def _rule(option: str, pattern: str, decisions: Sequence[Decision]) -> Habit | None:
    fitting = [one for one in decisions if _matches(one, [pattern.casefold()])]
    saved = [one for one in fitting if one.kind == option]
    wrong = [one for one in fitting if one.kind != option and one.is_welded == (option == "not")]
    parts = len({one.part for one in saved})
    most_wrong = MOST_WRONG * (len(saved) + len(wrong))
    if min(len(saved) - LEAST_SAVED, parts - LEAST_PARTS, most_wrong - len(wrong)) < 0:
        return None
    return Habit(option, pattern, tuple(one.what for one in saved), tuple(one.what for one in wrong), parts)


def _matches(decision: Decision, patterns: Sequence[str]) -> bool:
    plain = [pattern.replace("[", "[[]") for pattern in patterns]  # as the judgement of solids reads them
    return any(fnmatchcase(name.casefold(), pattern) for name in decision.solids for pattern in plain)
