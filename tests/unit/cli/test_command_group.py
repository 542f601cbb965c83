"""Mistyped commands, old names of options, the order of the help, errors as data, standard input, narrow screens."""

import io
import json
import random
import re
import string
import sys
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

import pytest
from rich.table import Table

from tests.running import run_here
from wpcal.cli import command_group
from wpcal.cli.command_group import ENTRY_POINT_GROUP, FROM_OTHERS, SECTIONS, CommandsByEntryPoint
from wpcal.cli.console import PlainConsole
from wpcal.cli.main import wpcal

TABLE = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        ("calibrat", "did you mean calibrate?"),
        ("feature", "did you mean features?"),
        ("Sheet", "did you mean sheet?"),
        ("exprot", "did you mean export or report?"),
        ("qqqq", "`wpcal --help` lists them"),
    ],
)
def test_a_mistyped_command_gets_the_near_ones(typed: str, says: str) -> None:
    done = run_here(typed, "part.step")
    assert (done.returncode, done.stdout) == (2, "")
    assert re.fullmatch(f"wpcal: there is no command '{typed}'; .*{re.escape(says)}\n", done.stderr)


def test_the_help_lists_every_command_once_in_the_order_of_the_work() -> None:
    done = run_here("--help")
    listed = re.findall(r"^  ([a-z]+)  ", done.stdout, re.MULTILINE)
    installed = set(CommandsByEntryPoint().list_commands(None))  # type: ignore[arg-type]  # unused
    assert sorted(listed) == sorted(installed)
    assert listed.index("features") < listed.index("pick") < listed.index("calibrate") < listed.index("plan")
    assert [title for title in SECTIONS if f"{title}:" in done.stdout] == list(SECTIONS)
    assert "..." not in done.stdout.partition("Begin:")[2]


def test_every_command_of_wpcal_has_its_heading() -> None:
    ours = {
        entry.name for entry in entry_points(group=ENTRY_POINT_GROUP) if entry.module.startswith(("wpcal.", "cad."))
    }
    assert sorted(name for names in SECTIONS.values() for name in names) == sorted(ours)


@pytest.fixture
def two_other_packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package with a good command and one that has the name of ours, and a package that is broken."""
    (tmp_path / "acme_welds.py").write_text(
        'import click\n\n\n@click.command\ndef acme():\n    """Paint the welds."""\n    click.echo(\'painted\')\n'
    )
    (tmp_path / "acme_broken.py").write_text("1 / 0\n")
    (tmp_path / "acme_odd.py").write_text("odd = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    words = {"paint": "acme_welds:acme", "fit": "acme_welds:acme", "broken": "acme_broken:acme", "odd": "acme_odd:odd"}
    others = [EntryPoint(name, place, ENTRY_POINT_GROUP) for name, place in words.items()]
    monkeypatch.setattr(command_group, "installed", lambda group: [*entry_points(group=group), *others])


@pytest.mark.usefixtures("two_other_packages")
def test_commands_of_other_packages_come_last_and_replace_none() -> None:
    shown = " ".join(run_here("--help").stdout.partition(f"{FROM_OTHERS}:")[2].split())
    assert shown == (
        "broken the command broken of the package acme_broken cannot be loaded: division by zero; ask its authors "
        "odd the command odd of the package acme_odd cannot be loaded: acme_odd:odd is not a click command; ask its "
        "authors paint Paint the welds."
    )
    assert run_here("paint").stdout == "painted\n"
    assert "PAIRS.csv" in run_here("fit", "--help").stdout


@pytest.mark.usefixtures("two_other_packages")
@pytest.mark.parametrize("name", ["broken", "odd"])
def test_a_broken_command_of_another_package_is_one_line(name: str) -> None:
    done = run_here(name)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert f"of the package acme_{name} cannot be loaded" in done.stderr


def test_every_output_is_called_out() -> None:
    context = wpcal.make_context("wpcal", ["--help"], resilient_parsing=True)
    for name in wpcal.list_commands(context):
        command = wpcal.get_command(context, name)
        short = [parameter for parameter in command.params if "-o" in parameter.opts]
        assert all("--out" in parameter.opts for parameter in short), name


def test_an_output_is_no_stream_and_another_name_of_an_option_is_told(tmp_path: Path) -> None:
    for words in (["-o", "-"], ["--out=-"]):
        assert "not standard output" in run_here("fit", TABLE, *words).stderr
    assert "--force'. (--resume)" in run_here("batch", "jobs.csv", "-o", tmp_path, "--force").stderr
    assert run_here("plan", "--help").stdout.count("--out DIR") == 1


def test_an_old_name_works_and_says_the_new_one(tmp_path: Path) -> None:
    for words in (["--output", str(tmp_path / "a.json")], [f"--output={tmp_path / 'b.json'}"]):
        done = run_here("study", TABLE, "--trials", "5", *words)
        assert (done.returncode, done.stderr) == (
            0,
            "wpcal: --output is now --out; the next version knows only that name\n",
        )
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


@pytest.mark.parametrize(
    ("is_there", "expected"), [(True, ("format", 2, "model_z_mm", "x")), (False, ("input", None, None, "no such file"))]
)
def test_an_error_is_also_json(
    is_there: bool, expected: tuple[object, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if is_there:
        Path("bad.csv").write_text(TABLE.read_text(encoding="utf-8").splitlines()[0] + "\nA,1,2,x,4,5,6\n")
    done = run_here("fit", "bad.csv", "--json")
    record = json.loads(done.stdout)
    assert (*(record[key] for key in ("file", "code", "line", "column")),) == ("bad.csv", *expected[:3])
    assert str(expected[3]) in record["message"]
    assert (record["exit_code"], done.returncode, done.stderr.count("\n")) == (2, 2, 1)
    assert record["message"] in done.stderr


def test_a_hint_and_wrong_use_are_data_too(tmp_path: Path) -> None:
    (tmp_path / "out.json").write_text("mine")
    done = run_here("study", TABLE, "-o", tmp_path / "out.json", "--json")
    exists = json.loads(done.stdout)
    assert (exists["code"], exists["hint"], exists["file"]) == ("exists", "--force", str(tmp_path / "out.json"))
    assert done.stderr == f"wpcal: {tmp_path / 'out.json'}: exists; allow overwriting to replace it (--force)\n"
    assert (tmp_path / "out.json").read_text() == "mine"
    wrong = json.loads(run_here("fit", "--json", "--wrong").stdout)
    assert (wrong["code"], wrong["hint"]) == ("usage", None)


def test_a_minus_is_standard_input(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(TABLE.read_bytes())))
    assert run_here("fit", "-").stdout == run_here("fit", TABLE).stdout


@pytest.mark.parametrize(
    ("typed", "word", "expected"), [("wpcal cal", 1, "calibrate"), ("wpcal fit --crit", 2, "--criterion")]
)
def test_a_shell_can_complete(typed: str, word: int, expected: str) -> None:
    from click.shell_completion import BashComplete

    words = typed.split()
    complete = BashComplete(wpcal, {}, "wpcal", "_WPCAL_COMPLETE")
    assert expected in [item.value for item in complete.get_completions(words[1:word], words[word])]


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
