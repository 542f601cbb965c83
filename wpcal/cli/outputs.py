"""What a command checks about the files that it reads and will write, and how programs are written."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Collection, Container, Mapping
from pathlib import Path
from typing import Any

import click

EXPORT_SCHEMA = "wpcal/export/1"


def print_json(record: Mapping[str, Any]) -> None:
    """Print a record on stdout, as files have it."""
    from wpcal.core.records import to_json

    click.echo(to_json(record), nl=False)


def require_new(path: Path, *, overwrite: bool) -> None:
    """Refuse a file that cannot be written, unless an existing one may be overwritten.

    Raises `InputError` if the file exists and `overwrite` is false, or there is no folder to write it into, or it
    cannot be written.
    """
    from wpcal.core.errors import ErrorCode, InputError
    from wpcal.core.records import require_place

    if path.exists() and not overwrite:
        raise InputError(f"{path}: exists; allow overwriting to replace it", code=ErrorCode.EXISTS)
    if not path.parent.is_dir():
        reason = os.strerror(errno.ENOTDIR if path.parent.exists() else errno.ENOENT).lower()
        raise InputError(f"{path}: cannot be written: {reason}")
    require_place(path)


def say_note(note: str | None) -> None:
    """Say a note of a result folder on stderr when the command has ended without an error, which is one line."""

    def say() -> None:
        if sys.exc_info()[1] is None:
            click.echo(f"wpcal: {note}", err=True)

    if note is not None:
        click.get_current_context().call_on_close(say)


def refuse_options(taken: Collection[str], why: Callable[[str], str], compared: Collection[str] = ()) -> None:
    """Refuse options of the command that what it was given does not take.

    `taken`: Names of the parameters that it takes.
    `why`: From the name of another one to what follows it in the message.
    `compared`: Names of others that may be said by the shop, as `require_as_planned` compares them.
    Raises `InputError` with the first of them that was typed; those that the shop says are named as not used.
    """
    from click.core import ParameterSource

    from wpcal.core.errors import InputError

    context, unused = click.get_current_context(), list[str]()
    for each in context.command.params:
        name = each.name or ""
        source = None if name in taken else context.get_parameter_source(name)
        if source is ParameterSource.COMMANDLINE:
            raise InputError(f"{each.opts[0]} {why(name)}")
        unused += [each.opts[0]] if source is ParameterSource.DEFAULT_MAP and name not in compared else []
    if unused:
        click.echo(f"wpcal: of what the shop says is not used here: {', '.join(unused)}", err=True)


def require_as_planned(planned: Mapping[str, float | str]) -> None:
    """Refuse options, typed or said by the shop, that are other than in a plan of touches: it has them already.

    Raises `InputError` with the first of them.
    """
    from click.core import ParameterSource

    from wpcal.cli.command_group import origins_of
    from wpcal.core.errors import InputError

    context = click.get_current_context()
    for name, value in planned.items():
        given = context.params[name]
        if context.get_parameter_source(name) is not ParameterSource.DEFAULT and given != value:
            flag = f"--{name.replace('_', '-')}"
            where = origins_of(context).get(flag, "the command line")
            words, has = (f"{each:g}" if isinstance(each, float) else str(each) for each in (given, value))
            raise InputError(f"{flag} {words} ({where}): the plan of touches has {has}: plan it again, or say the same")


def typed_options(context: click.Context, *, without: Container[str]) -> list[str]:
    """Return the options of a command line as they were typed, but those of the parameters `without`."""
    from click.core import ParameterSource

    words = list[str]()
    for each in context.command.params:
        name = each.name or ""
        is_typed = context.get_parameter_source(name) is ParameterSource.COMMANDLINE
        if isinstance(each, click.Option) and is_typed and name not in without:
            value = context.params[name]
            values = value if each.multiple else (value,)
            words += [each.opts[0]] if each.is_flag else [word for one in values for word in (each.opts[0], str(one))]
    return words


def require_result(seams: Path, *others: Path) -> None:
    """Refuse a result folder, or the file of its seams, that was changed; of other files only themselves.

    Raises `FormatError` as `wpcal.results.agree.require_as_written`.
    """
    from wpcal.core.result_files import CALIBRATION_FILE, PART_FILE
    from wpcal.results.agree import require_as_written

    say_note(require_as_written(seams, also=(CALIBRATION_FILE, PART_FILE)))
    for other in others:
        require_as_written(other)


def write_programs(
    contents: Mapping[str, Mapping[str, str | bytes]], targets: Mapping[str, Path], *, overwrite: bool
) -> None:
    """Write the files of every format into its folder, and say on stderr which jobs of an earlier export were there."""
    from wpcal.controllers.earlier_jobs import find_earlier_jobs
    from wpcal.core.records import new_directory

    earlier = {name: find_earlier_jobs(targets[name], tuple(files)) for name, files in contents.items()}
    for name, files in contents.items():
        with new_directory(targets[name], overwrite=overwrite, leave_out=earlier[name].ours) as temporary:
            for file, data in files.items():
                (temporary / file).write_bytes(data.encode("utf-8") if isinstance(data, str) else data)
    for name, jobs in earlier.items():
        if jobs.ours:
            click.echo(f"wpcal: {targets[name]}: removed jobs of an earlier export: {', '.join(jobs.ours)}", err=True)
        if jobs.others:
            what = f"kept, and not part of this export: {', '.join(jobs.others)}; do not load them by mistake"
            click.echo(f"wpcal: {targets[name]}: {what}", err=True)
