"""The `wpcal` command group: finds its commands by entry point; every error is one line and an exit code."""

from __future__ import annotations

import os
import sys
from importlib.metadata import EntryPoint, entry_points

import click

from wpcal import __version__
from wpcal.cli.number_options import with_strict_numbers
from wpcal.cli.signals import Stopped, stopped_like_interrupted
from wpcal.cli.streams import protect_streams
from wpcal.printable import printable

ENTRY_POINT_GROUP = "wpcal.commands"
OUR_PACKAGES = ("wpcal", "cad")
EXIT_OUR_FAULT = 70
EXIT_OF_SIGNAL = 128
"""As in a shell: 143 after SIGTERM, 129 after SIGHUP."""
EXIT_INTERRUPTED = EXIT_OF_SIGNAL + 2


class CommandsByEntryPoint(click.Group):
    """A group whose commands are entry points `wpcal.commands`; a command's module is imported when it is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all installed commands."""
        return sorted(_installed())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command."""
        entry = _installed().get(cmd_name)
        return None if entry is None else _loaded(entry)


def _loaded(entry: EntryPoint) -> click.Command:
    """Import a command. A package that hides ours, or that is not installed, is told by its name."""
    from wpcal.core.errors import InputError

    try:
        command: click.Command = entry.load()
    except ImportError as error:
        raise InputError(_why_not_loaded(entry, error)) from error
    return with_strict_numbers(command)


def _why_not_loaded(entry: EntryPoint, error: ImportError) -> str:
    from importlib.util import find_spec

    root = entry.module.partition(".")[0]
    ours = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    found = find_spec(root)
    places = () if found is None else (found.submodule_search_locations or [found.origin or ""])
    place = next(iter(places), "")
    if root in OUR_PACKAGES and os.path.dirname(os.path.abspath(place)) != ours:
        return (
            f"another package is called {root} and hides the one of wpcal: {place}; take its folder from PYTHONPATH, "
            "or install wpcal in an environment of its own"
        )
    return f"the command {entry.name} cannot be loaded: {error}"


def _installed() -> dict[str, EntryPoint]:
    return {entry.name: entry for entry in entry_points(group=ENTRY_POINT_GROUP)}


@click.command(
    cls=CommandsByEntryPoint,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)
@click.version_option(__version__, prog_name="wpcal")
def wpcal() -> None:
    """Put a real workpiece and its CAD model in the same place.

    Touch a few points with the torch. wpcal fits the STEP model to them, predicts the error of every weld, and writes
    the weld seams as pose frames in robot coordinates.
    """


def run(arguments: list[str] | None = None) -> None:
    """Run the command line and exit: 0 done, 1 misses its tolerance, 2 wrong use or input, 70 our own fault.

    After a signal it is 128 and the number of the signal. Otherwise it is the result's, also if nobody can read what
    is printed.
    """
    output = protect_streams()
    code = _run(arguments)
    if output is not None:
        sys.stdout.flush()
        if output.lost_because:
            _say(f"standard output was not written: {output.lost_because}; exit code {code} is the result's", code)
    sys.exit(code)


def _run(arguments: list[str] | None) -> int:
    try:
        _require_unicode(sys.argv[1:] if arguments is None else arguments)
        with stopped_like_interrupted():
            code = wpcal.main(args=arguments, prog_name="wpcal", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        return error.exit_code
    except click.ClickException as error:
        return _say(error.format_message(), error.exit_code)
    except click.Abort as abort:
        if isinstance(abort.__cause__, Stopped):
            return _say(f"ended by {abort.__cause__}", EXIT_OF_SIGNAL + abort.__cause__.number)
        return _say("interrupted", EXIT_INTERRUPTED)
    except Exception as error:  # the outermost place: an unforeseen error is one line, too
        return _say_error(error)
    return code if isinstance(code, int) else 0


def _say_error(error: Exception) -> int:
    from wpcal.cli.hints import with_hint
    from wpcal.core.errors import WpcalError

    if isinstance(error, WpcalError):
        return _say(with_hint(error), error.exit_code)
    if os.environ.get("WPCAL_DEBUG"):
        raise error
    if isinstance(error, OSError) and error.filename is not None:
        return _say(f"{error.filename}: {(error.strerror or str(error)).lower()}", WpcalError.exit_code)
    kind = type(error).__name__
    return _say(f"internal error ({kind}: {error}); this is our fault: set WPCAL_DEBUG=1 to see where", EXIT_OUR_FAULT)


def _say(message: str, code: int) -> int:
    """Print one line on stderr and return the exit code."""
    line = printable(" ".join(message.split()))
    click.echo(f"wpcal: {line}", err=True)
    return code


def _require_unicode(arguments: list[str]) -> None:
    """Refuse an argument that is not text: it would be the name of a file, and records hold these names."""
    for argument in arguments:
        try:
            argument.encode("utf-8")
        except UnicodeEncodeError:
            shown = os.fsencode(argument).decode("utf-8", errors="backslashreplace")
            raise click.UsageError(f"{shown}: the name is not UTF-8 text; rename the file or the folder") from None
