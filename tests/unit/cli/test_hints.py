"""Library messages name what is missing; commands add the option."""

import re

import click
import pytest

from tests.running import run_here
from wpcal.cli.hints import HINTS, INSTEAD
from wpcal.cli.main import wpcal
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.options import named_option


def test_every_hint_is_an_option_of_a_command():
    assert set(HINTS) <= set(ErrorCode)
    with click.Context(wpcal) as context:
        commands = [wpcal.get_command(context, name) for name in wpcal.list_commands(context)]
    known = {flag for command in commands for parameter in command.params for flag in parameter.opts}
    assert {flag for hint in HINTS.values() for flag in re.findall(r"--[a-z-]+", hint)} | {*INSTEAD.values()} <= known


def test_an_error_about_a_value_begins_with_the_flag():
    with pytest.raises(InputError, match="--uframe: expected NAME"), named_option("--uframe"):
        raise FormatError("expected NAME", code=ErrorCode.FORMAT)


def test_an_unreadable_user_frame_names_its_option(tmp_path):
    (tmp_path / "teach.dat").write_text("DEFDAT TEACH\nENDDAT\n")
    done = run_here("taught", tmp_path / "teach.dat", "--uframe", "7=")
    assert (done.returncode, done.stdout) == (2, "")
    assert "--uframe: user frame: expected [NAME=]VALUES, got '7='" in done.stderr
