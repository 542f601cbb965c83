"""Library messages name what is missing; commands add the option."""

import re
from pathlib import Path

import click
import pytest

from tests.running import run_here
from wpcal.cli.hints import HINTS
from wpcal.cli.main import wpcal
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.options import named_option

TABLE1 = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"


def known_flags() -> set[str]:
    with click.Context(wpcal) as context:
        commands = [wpcal.get_command(context, name) for name in wpcal.list_commands(context)]
    return {flag for command in commands for parameter in command.params for flag in parameter.opts}


def test_every_hint_is_an_option_of_a_command():
    assert set(HINTS) <= set(ErrorCode)
    named = {flag for hint in HINTS.values() for flag in re.findall(r"--[a-z-]+", hint)}
    assert named <= known_flags()


def test_an_output_that_exists_names_the_option(tmp_path):
    (tmp_path / "out.json").write_text("mine")
    done = run_here("study", TABLE1, "--trials", "10", "-o", tmp_path / "out.json")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"wpcal: {tmp_path / 'out.json'}: exists; allow overwriting to replace it (--force)\n"
    assert (tmp_path / "out.json").read_text() == "mine"


def test_an_error_about_a_value_begins_with_the_flag():
    with pytest.raises(InputError, match="--uframe: expected NAME"), named_option("--uframe"):
        raise FormatError("expected NAME", code=ErrorCode.FORMAT)


def test_an_unreadable_user_frame_names_its_option(tmp_path):
    (tmp_path / "teach.dat").write_text("DEFDAT TEACH\nENDDAT\n")
    done = run_here("taught", tmp_path / "teach.dat", "--uframe", "7=")
    assert (done.returncode, done.stdout) == (2, "")
    assert "--uframe: user frame: expected [NAME=]VALUES, got '7='" in done.stderr
