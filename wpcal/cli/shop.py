"""`wpcal shop`: what a shop says once, for every part."""

from __future__ import annotations

import json
import sys
import textwrap
from pathlib import Path

import click

from wpcal.cli.option_groups import command
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import path_argument, path_option
from wpcal.cli.shop_file import SHOP_FILE

ASKED = (
    ("tolerance_mm", "Tolerance of the seams, mm", "0.5"),
    ("sigma_mm", "Standard deviation of a touch per axis, mm", "0.15"),
    ("torch", "Torch: a name of `wpcal torches`, or a file", "straight"),
    ("robot", "Robot: the file of an arm", "kr16.json"),
    ("cell", "Cell: a file", "cell.json"),
    ("format", "Language of the programs", "csv"),
)
"""What `wpcal shop new` asks: key, question and example."""
HEAD = """\
# What is the same on every part. An option that is typed, and a variable such as WPCAL_TOLERANCE_MM, come first.
# `wpcal shop` lists what can be said here. A table, as [export], is for one command. Files are found from here.
"""


@command()
@click.argument("action", type=click.Choice(["show", "new", "learn"]), default="show")
@path_argument("results", nargs=-1)
@path_option("-o", "--out", default=Path(SHOP_FILE), help="Output: a file.")
@click.option("--force", is_flag=True, help="Replace what exists: the file.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout: the values, or the rules (learn).")
def shop(*, action: str, results: tuple[Path, ...], out: Path, force: bool, as_json: bool) -> int:
    """Show what the shop says once, with the origin of each value, or ask for it and write wpcal.toml (new).

    wpcal.toml is found upwards from the part, as pyproject.toml is. With learn, RESULTS are folders with results or
    files of seams: what was refused or accepted by hand on several parts at solids of one name is proposed as a rule,
    with the decisions that it would have saved and those that it would have got wrong.
    """
    if action == "learn":
        return _learn(results, as_json=as_json)
    if results:
        raise click.UsageError(f"wpcal shop {action} takes no results; wpcal shop learn does")
    return _new(out, force=force) if action == "new" else _shown(as_json=as_json)


def _shown(*, as_json: bool) -> int:
    """Print what is said."""
    from wpcal.cli.command_group import installed_commands
    from wpcal.cli.shop_file import SAID_ONCE, find_shop, require_tables, require_variables, said_of

    found = find_shop(())
    commands = dict(installed_commands())
    require_tables(found, commands)
    require_variables()
    said = [(name, each) for name, made in commands.items() for each in said_of(made, name, found).values()]
    rows: dict[tuple[str, str, str], list[str]] = {}
    for name, each in said:
        rows.setdefault((each.flag, str(each), each.origin), []).append(name)
    if as_json:
        values = [
            {"option": flag, "value": text.removeprefix(flag).strip(), "origin": origin, "commands": names}
            for (flag, text, origin), names in rows.items()
        ]
        file = None if found.path is None else str(found.path)
        print_json({"schema": "wpcal/shop/1", "file": file, "values": values})
        return 0
    where = "no wpcal.toml is above this folder; `wpcal shop new` writes one" if found.path is None else f"{found.path}"
    click.echo(where)
    for (_, text, origin), names in rows.items():
        click.echo(f"  {text}  ({origin}; {', '.join(names)})")
    click.echo(textwrap.fill(f"can be said: {', '.join(sorted(SAID_ONCE))}", 110, subsequent_indent="  "))
    return 0


def _learn(results: tuple[Path, ...], *, as_json: bool) -> int:
    """Propose rules from decisions about seams; ends with code 1 if there is none."""
    from wpcal.cli.shop_file import find_shop
    from wpcal.core.wording import counted
    from wpcal.results.habits import decisions_in, learned_rules

    found = find_shop([str(path) for path in results])
    own = {option: found.common.get(option, []) for option in ("not", "weld")}
    known = {option: [value] if isinstance(value, str) else value for option, value in own.items()}
    decisions = decisions_in(results or (Path(),))
    rules = learned_rules(decisions, [*known["not"], *known["weld"]])
    by_hand = sum(bool(one.kind) for one in decisions)
    if as_json:
        record = {"schema": "wpcal/shop-rules/1", "decisions": by_hand, "rules": [one.to_record() for one in rules]}
        print_json(record)
        return int(not rules)
    click.echo(
        f"{counted(by_hand, 'decision')} by hand, {counted(len(rules), 'rule')} that would have saved some of them"
    )
    for rule in rules:
        click.echo(f"  {rule.describe()}")
    for option in sorted({rule.option for rule in rules}):
        said = [*known[option], *(rule.pattern for rule in rules if rule.option == option)]
        click.echo(f"{found.path or 'wpcal.toml'}: {option} = {json.dumps(said, ensure_ascii=False)}")
    return int(not rules)


def _new(out: Path, *, force: bool) -> int:
    """Ask for the values and write the file; what is not answered is written as a comment."""
    from wpcal.cli.command_group import installed_commands
    from wpcal.cli.outputs import require_new
    from wpcal.cli.shop_file import said_of, shop_of
    from wpcal.core.records import write_file

    require_new(out, overwrite=force)
    lines = [HEAD.rstrip()]
    for key, question, example in ASKED:
        words = f"{question} (as {example}; empty: not said)"
        answer = click.prompt(words, default="", show_default=False) if sys.stdin.isatty() else ""
        line = f"{key} = {_toml(answer or example)}"
        lines.append(line if answer else f"# {line}  # {question}")
    text = "\n".join(lines) + "\n"
    shop = shop_of(text, out)
    for name, made in installed_commands():
        said_of(made, name, shop)
    write_file(out, text, overwrite=force)
    click.echo(f"wrote {out}")
    return 0


def _toml(text: str) -> str:
    """Return a value as TOML writes it: a number, or a quoted text."""
    try:
        return repr(float(text))
    except ValueError:
        return json.dumps(text, ensure_ascii=False)
