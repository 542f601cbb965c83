"""The commands of `wpcal`: found by entry point, listed in the order of the work, and near names for a mistyped one."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches
from importlib.metadata import EntryPoint
from itertools import pairwise

import click

from wpcal.cli.number_options import with_strict_numbers
from wpcal.core.installed import installed

ENTRY_POINT_GROUP = "wpcal.commands"
OUR_PACKAGES = ("wpcal", "cad")

SECTIONS: Mapping[str, Sequence[str]] = {
    "Begin": ("demo", "shop"),
    "Look at the part": ("features", "seams", "bodies", "torches"),
    "Choose and teach points": ("advise", "sheet", "touches", "pick", "teach", "taught", "match"),
    "Calibrate": ("calibrate", "report"),
    "Weld data, programs and plans": ("welds", "export", "touchup", "cell", "place", "plan", "bases"),
    "Batches and records": ("batch", "drift", "verify", "diff", "audit"),
    "A better robot": ("identify", "tcp", "correct"),
    "Without a part": ("fit", "study"),
    "For other programs": ("rpc",),
}
"""The help lists wpcal's own commands in this order."""
FROM_OTHERS = "From other packages"  #: The last heading of the help: commands that other packages bring.

HELP_FLAGS = frozenset({"-h", "--help", "--help-all"})
ORIGINS = "wpcal.origins"  #: Key in the memory of a call.

WHOLE_SENTENCE = 1000  #: Letters: the first sentence of a command's help is wrapped and never cut.

RENAMED_EVERYWHERE: Mapping[str, str] = {"--output": "--out"}
RENAMED: Mapping[str, Mapping[str, str]] = {
    "advise": {"--points": "--count", "--near": "--within", "--seams": "--only"},
    "sheet": {"--points": "--touch"},
    "pick": {"--force": "--other-part"},
    "export": {"--near": "--near-joints", "--seams": "--only"},
    "identify": {"--solver": "--method"},
    "plan": {"--work-deg": "--work-angle-deg", "--travel-deg": "--travel-angle-deg"},
}
"""By command: old names of options. They work in this version, with one line on stderr."""
FILE_NOW = ("advise", "--seams", ".json")
"""Command, option and ending: the option took names or a file, and takes a file only. Files still go to it."""


class CommandsByEntryPoint(click.Group):
    """A group whose commands are entry points `wpcal.commands`; a command's module is imported when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all installed commands in the order of the work."""
        return [name for names in self.by_section().values() for name in names]

    def by_section(self) -> dict[str, list[str]]:
        """Return the names of all installed commands by the headings of the help; none is empty."""
        installed = _installed()
        sections = {title: [name for name in names if name in installed] for title, names in SECTIONS.items()}
        ours = {name for names in sections.values() for name in names}
        sections[FROM_OTHERS] = sorted(set(installed) - ours)
        return {title: names for title, names in sections.items() if names}

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command."""
        entry = _installed().get(cmd_name)
        return None if entry is None else with_strict_numbers(_loaded(entry))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; say which names are near if there is none, and take old names of its options."""
        name = args[0]
        if name == "help":
            args = [*args[1:], "--help"]
            name = args[0]
        if not name.startswith("-") and name not in _installed():
            raise click.UsageError(_unknown(name))
        found, command, rest = super().resolve_command(ctx, args)
        if command is None:
            return found, command, rest
        rest = _with_new_names(command, rest)
        if _is_ours(_installed()[name]):
            _refuse_stream(rest)
        _take_shop(ctx, command, name, rest)
        return found, command, rest

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands under their headings."""
        sections = self.by_section()
        width = max(len(name) for names in sections.values() for name in names)
        for title, names in sections.items():
            with formatter.section(title):
                formatter.write_dl([(name.ljust(width), _summary(_installed()[name])) for name in names])


def _take_shop(ctx: click.Context, command: click.Command, name: str, words: Sequence[str]) -> None:
    """Let what the shop says be the default of the command's options, and say which of it counts."""
    from wpcal.cli.shop_file import find_shop, require_tables, require_variables, said_of, typed

    if HELP_FLAGS.intersection(words) or name == "shop" or isinstance(command, click.Group):
        return
    given = typed(command, words)
    shop = find_shop(given.arguments)
    require_tables(shop, _installed())
    require_variables()
    said = said_of(command, name, shop)
    ctx.default_map = {name: {parameter: each.value for parameter, each in said.items()}}
    counts = [each for parameter, each in said.items() if parameter not in given.options]
    ctx.meta[ORIGINS] = {each.flag: each.origin for each in counts}
    if counts:
        click.echo(f"wpcal: the shop says {', '.join(map(str, counts))}", err=True)


def origins_of(context: click.Context) -> Mapping[str, str]:
    """Return where options of a call that were not typed come from, by flag."""
    found: Mapping[str, str] = context.find_root().meta.get(ORIGINS, {})
    return found


def installed_commands() -> Iterator[tuple[str, click.Command]]:
    """Yield all commands of ours that are no groups, with their names."""
    for name, entry in _installed().items():
        command = _loaded(entry) if _is_ours(entry) else None
        if command is not None and not isinstance(command, click.Group):
            yield name, command


def _installed() -> dict[str, EntryPoint]:
    """Return the commands by name. No other package replaces one of ours."""
    found = sorted(installed(ENTRY_POINT_GROUP), key=_is_ours)
    return {entry.name: entry for entry in found}


def _is_ours(entry: EntryPoint) -> bool:
    return entry.module.partition(".")[0] in OUR_PACKAGES


def _summary(entry: EntryPoint) -> str:
    """Return the first sentence of a command's help; of another package's command that is broken, what is wrong."""
    from wpcal.core.errors import InputError

    try:
        return _loaded(entry).get_short_help_str(WHOLE_SENTENCE)
    except InputError as error:
        if _is_ours(entry):
            raise
        return str(error)


def _unknown(name: str) -> str:
    if os.path.exists(name):
        return f"{name} is a file; a command comes first, as in: wpcal features {name} (`wpcal --help` lists them)"
    near = get_close_matches(name.lower(), _installed(), n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else "`wpcal --help` lists them"
    return f"there is no command {name!r}; {hint}"


def _with_new_names(command: click.Command, words: Sequence[str]) -> list[str]:
    """Replace old names of options, and say so."""
    known = {flag for parameter in command.params for flag in (*parameter.opts, *parameter.secondary_opts)}
    name = command.name or ""
    kept = known - {FILE_NOW[1]} if name == FILE_NOW[0] else known
    renamed = {**RENAMED_EVERYWHERE, **RENAMED.get(name, {})}
    return list(_replaced(words, {old: new for old, new in renamed.items() if old not in kept and new in known}))


def _replaced(words: Sequence[str], renamed: Mapping[str, str]) -> Iterator[str]:
    for place, word in enumerate(words):
        if word == "--":
            yield from words[place:]
            return
        flag, equals, value = word.partition("=")
        given = value if equals else next(iter(words[place + 1 :]), "")
        if flag in renamed and not (flag == FILE_NOW[1] and given.endswith(FILE_NOW[2])):
            click.echo(f"wpcal: {flag} is now {renamed[flag]}; the next version knows only that name", err=True)
            flag = renamed[flag]
        yield f"{flag}{equals}{value}"


def _refuse_stream(words: Sequence[str]) -> None:
    """Refuse ``-`` as the name of an output: elsewhere it means standard output."""
    if any(pair in (("-o", "-"), ("--out", "-")) for pair in pairwise(words)) or "--out=-" in words:
        raise click.UsageError("-o -: outputs are files, not standard output; name one (--json prints a record)")


def _loaded(entry: EntryPoint) -> click.Command:
    """Import a command. A package that hides ours, that is not installed, or that is broken is told by its name."""
    from wpcal.core.errors import InputError

    try:
        command = entry.load()
    except ImportError as error:
        raise InputError(_why_not_loaded(entry, error)) from error
    except Exception as error:
        if _is_ours(entry):
            raise
        raise InputError(_why_not_loaded(entry, error)) from error
    if not isinstance(command, click.Command):
        raise InputError(_why_not_loaded(entry, TypeError(f"{entry.value} is not a click command")))
    return command


def _why_not_loaded(entry: EntryPoint, error: Exception) -> str:
    from importlib.util import find_spec

    if not _is_ours(entry):
        package = entry.module.partition(".")[0] if entry.dist is None else entry.dist.name
        return f"the command {entry.name} of the package {package} cannot be loaded: {error}; ask its authors"
    root = entry.module.partition(".")[0]
    ours = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    found = find_spec(root)
    places = () if found is None else (found.submodule_search_locations or [found.origin or ""])
    place = next(iter(places), "")
    if os.path.dirname(os.path.abspath(place)) != ours:
        return (
            f"another package is called {root} and hides the one of wpcal: {place}; take its folder from PYTHONPATH, "
            "or install wpcal in an environment of its own"
        )
    return f"the command {entry.name} cannot be loaded: {error}"
