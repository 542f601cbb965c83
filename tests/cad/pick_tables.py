"""Tables of the picker, small and without a part: what the tests of its table and of its draft need."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

from cad.pick.draft import Keyed
from cad.pick.opening import find_table, start_table
from cad.pick.shared_table import SharedTable
from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS, Rows

PART = cast(PickPart, SimpleNamespace(file_name="tee.step", sha256="a" * 64))


def table_of(*rows: str) -> Keyed:
    """Rows such as ``V2 1 2 3``; a name alone is a row without coordinates. The keys are the names."""
    cells = [(*row.split(), "", "", "")[:4] for row in rows]
    return Keyed(Rows(NEW_COLUMNS, tuple((*row, row[0], "yes") for row in cells)), tuple(row[0] for row in cells))


def opened(out: Path, part: PickPart = PART, **more: Any) -> SharedTable:
    return start_table(find_table(out), part, part_step=Path("none.step"), **more)[0]


def notes_of(out: Path, part: PickPart = PART, **more: Any) -> str:
    return "\n".join(start_table(find_table(out), part, part_step=Path("none.step"), **more)[1])


def kept(shared: SharedTable, table: Keyed, *, window: str = "w") -> dict[str, Any]:
    revision = shared.changes_since(-1)["revision"]
    return shared.keep(table, revision=revision, window=window, number=revision)


def saved(shared: SharedTable, **more: Any) -> dict[str, Any]:
    return shared.save(revision=shared.changes_since(-1)["revision"], **more)


def names(rows: Rows) -> list[str]:
    return [row[0] for row in rows.cells]


FOUR = table_of("V2 1 2 3", "V4 4 5 6", "V6 7 8 9", "V8 1 1 1")
