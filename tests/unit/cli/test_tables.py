"""A narrow screen cuts no cell of a table."""

import io
import random
import string
from pathlib import Path

import pytest
from rich.table import Table

from tests.running import run_here
from wpcal.cli.console import PlainConsole

TABLE_CSV = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"
NARROW = 60


def words(text: str) -> set[str]:
    return {word for word in text.split() if any(letter in word for letter in string.ascii_letters + string.digits)}


def printed(table: Table, width: int) -> str:
    text = io.StringIO()
    PlainConsole(file=text, width=width, markup=False).print(table)
    return text.getvalue()


@pytest.mark.parametrize("seed", range(20))
def test_every_word_of_every_cell_is_there(seed: int) -> None:
    rng = random.Random(seed)
    columns = rng.randint(1, 12)

    def cell() -> str:
        return " ".join("".join(rng.choices("abcdef.0123", k=rng.randint(1, 9))) for _ in range(rng.randint(0, 4)))

    rows = [[cell() for _ in range(columns)] for _ in range(4)]
    tables = []
    for _ in range(2):
        table = Table()
        for column in range(columns):
            table.add_column(f"heading {column}", no_wrap=column % 2 == 0)
        for row in rows:
            table.add_row(*row)
        tables.append(table)
    assert words(printed(tables[0], NARROW)) == words(printed(tables[1], 1000))


def test_the_width_is_kept_where_the_words_allow_it() -> None:
    table = Table("seam", "joins", "length mm", "points", "gap mm", "sure", "95 % mm")
    table.add_row("W1", "base plate + web", "150.000", "16", "0.000", "95%", "0.224")
    lines = printed(table, NARROW).splitlines()
    assert max(map(len, lines)) <= NARROW
    assert "…" not in "".join(lines)


def test_a_command_keeps_its_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    found = []
    for width in ("1000", str(NARROW)):
        monkeypatch.setenv("COLUMNS", width)
        found.append(words(run_here("fit", TABLE_CSV, "--tolerance-mm", "100").stdout))
    assert found[0] == found[1]
