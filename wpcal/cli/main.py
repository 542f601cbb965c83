"""The `wpcal` command group: finds its commands by entry point; every error is one line and an exit code."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from wpcal.cli.command_group import CommandsByEntryPoint
from wpcal.cli.outputs import print_json
from wpcal.cli.signals import Stopped, stopped_like_interrupted
from wpcal.cli.streams import protect_streams
from wpcal.core.process import collect_rarely, use_one_thread
from wpcal.core.version import __version__
from wpcal.core.wording import printable

EXIT_OUR_FAULT = 70
EXIT_OF_SIGNAL = 128  #: As in a shell: 143 after SIGTERM, 129 after SIGHUP.
EXIT_INTERRUPTED = EXIT_OF_SIGNAL + 2


def _install(ctx: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from wpcal.cli.shell_files import install

        install(ctx)


@click.command(
    cls=CommandsByEntryPoint, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, "-V", "--version", prog_name="wpcal")
@click.option(
    "--install-completion",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_install,
    help="Let this shell complete commands and options, and `man wpcal` list them.",
)
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
    collect_rarely()
    use_one_thread()
    output = protect_streams()
    code = _run(arguments)
    if output is not None:
        sys.stdout.flush()
        if output.lost_because:
            _say(f"standard output was not written: {output.lost_because}; exit code {code} is the result's", code)
    sys.exit(code)


def _run(arguments: list[str] | None) -> int:
    raised: list[KeyboardInterrupt] = []
    try:
        _require_unicode(sys.argv[1:] if arguments is None else arguments)
        with stopped_like_interrupted() as raised:
            code = wpcal.main(args=arguments, prog_name="wpcal", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        return _say_help(error)
    except click.Abort as abort:
        return _fail(abort, *_told_of_end(abort.__cause__), arguments)
    except KeyboardInterrupt as interruption:  # before or after the command itself
        return _fail(interruption, *_told_of_end(interruption), arguments)
    except Exception as error:  # the outermost place: an unforeseen error is one line, too
        told = _told(error) or (_told_of_end(raised[-1]) if raised else _told_of_fault(error))
        return _fail(error, *told, arguments)
    return code if isinstance(code, int) else 0


def _say_help(error: click.exceptions.NoArgsIsHelpError) -> int:
    """Print the help of a command that was typed alone; of wpcal itself also what comes next in this folder."""
    from wpcal.cli.begin import next_here

    click.echo(error.format_message())
    if error.ctx is not None and error.ctx.parent is None:
        click.echo("\n".join(next_here(Path())))
    return error.exit_code


def _told_of_end(interruption: BaseException | None) -> tuple[str, int]:
    """Return what is said of an interruption, and the exit code."""
    code, how = EXIT_INTERRUPTED, "interrupted"
    if isinstance(interruption, Stopped):
        code, how = EXIT_OF_SIGNAL + interruption.number, f"ended by {interruption}"
    notes = getattr(interruption, "__notes__", ())  # what a command says about what it did until then
    return "; ".join([how, *notes]), code


def _told(error: Exception) -> tuple[str, int] | None:
    """Return what is said of an error, and the exit code; None of an error that nobody foresaw."""
    from wpcal.core.errors import WpcalError

    if isinstance(error, click.MissingParameter) and error.ctx is not None:
        usage = error.ctx.get_usage().removeprefix("Usage: ")
        help_of_option = getattr(error.param, "help", None)  # an argument has none
        what = ": ".join(filter(None, [error.format_message().rstrip("."), help_of_option])).rstrip(".")
        return f"{what}; usage: {usage}; -h explains it", error.exit_code
    if isinstance(error, click.ClickException):
        return error.format_message(), error.exit_code
    if isinstance(error, WpcalError):
        return str(error), error.exit_code
    if isinstance(error, OSError) and error.filename is not None and not os.environ.get("WPCAL_DEBUG"):
        return f"{error.filename}: {(error.strerror or str(error)).lower()}", WpcalError.exit_code
    return None


def _told_of_fault(error: Exception) -> tuple[str, int]:
    """Return what is said of an error that nobody foresaw, and the exit code."""
    from wpcal.core.errors import fault_words

    if os.environ.get("WPCAL_DEBUG"):
        raise error
    return fault_words(error), EXIT_OUR_FAULT


def _fail(error: BaseException, message: str, code: int, arguments: list[str] | None) -> int:
    """Print one line on stderr, with ``--json`` also its record on stdout, and return the exit code."""
    from wpcal.cli.hints import error_record, with_hint

    words = sys.argv[1:] if arguments is None else arguments
    if "--json" in words:
        print_json(error_record(error, message, code, words))
    return _say(with_hint(error, message), code)


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
