"""A law over all commands: an option has one type and one subject wherever it is, and a meaning has one name."""

import re
from collections import defaultdict
from collections.abc import Mapping

import click
import pytest

from tests.running import run_here
from wpcal.cli.command_group import RENAMED
from wpcal.cli.main import wpcal

Options = Mapping[str, list[tuple[str, click.Option]]]
NUMBER = "--touches"
"""How many touches `wpcal touches` plans; elsewhere the plan itself. The number and the file are not mistaken."""


@pytest.fixture(scope="module")
def options() -> Options:
    """Every flag with the commands that have it."""
    found: dict[str, list[tuple[str, click.Option]]] = defaultdict(list)
    with click.Context(wpcal) as context:
        for name in wpcal.list_commands(context):
            command = wpcal.get_command(context, name)
            for parameter in command.params:
                if isinstance(parameter, click.Option):
                    for flag in parameter.opts:
                        found[flag].append((name, parameter))
    return found


def subject(option: click.Option) -> str:
    """What the help says before the first stop: a command adds the rest."""
    return re.split(r"[.:;(\[]", option.help or "", maxsplit=1)[0].strip()


def form(option: click.Option) -> tuple[object, ...]:
    """What may be typed after the option; a choice is compared by its words."""
    kind = option.type
    words = "choice" if isinstance(kind, click.Choice) else repr(kind) if "Range" in repr(kind) else kind.name
    metavar = None if "-o" in option.opts else option.metavar
    return (words, option.nargs, option.is_flag, option.multiple, metavar)


def test_an_option_takes_the_same_in_every_command(options: Options) -> None:
    odd = {flag: {name: form(option) for name, option in uses} for flag, uses in options.items() if flag != NUMBER}
    assert {flag: forms for flag, forms in odd.items() if len(set(forms.values())) > 1} == {}


def test_the_choices_of_an_option_are_those_of_one_list(options: Options) -> None:
    for flag, uses in options.items():
        choices = [tuple(option.type.choices) for _, option in uses if isinstance(option.type, click.Choice)]
        longest = max(choices, key=len, default=())
        assert all([word for word in longest if word in some] == list(some) for some in choices), flag


def test_an_option_is_about_the_same_in_every_command(options: Options) -> None:
    subjects = {flag: {subject(option) for _, option in uses} for flag, uses in options.items() if flag != NUMBER}
    assert {flag: said for flag, said in subjects.items() if len(said) > 1} == {}
    assert all(subject(option) for uses in options.values() for _, option in uses)


def test_a_subject_has_one_option(options: Options) -> None:
    flags: dict[str, set[str]] = defaultdict(set)
    for uses in options.values():
        for _, option in uses:
            flags[subject(option)].add(option.opts[-1])
    general = {"Teaching error", "With --plan", "Write a page"}  # the rest of the sentence differs
    assert {said: names for said, names in flags.items() if len(names) > 1 and said not in general} == {}


def test_a_renamed_option_is_known_under_its_new_name_only(options: Options) -> None:
    for command, renamed in RENAMED.items():
        for old, new in renamed.items():
            assert command in [name for name, _ in options[new]]
            kept = [option for name, option in options.get(old, []) if name == command]
            assert all(option.metavar == "FILE" for option in kept), (command, old)


@pytest.mark.parametrize(
    ("words", "old", "new"),
    [
        (("advise", "nix.step", "--seams", "W1,W2"), "--seams", "--only"),
        (("advise", "nix.step", "--seams=W1"), "--seams", "--only"),
        (("advise", "nix.step", "--near", "1,2,3,4"), "--near", "--within"),
        (("export", "nix", "-f", "abb", "--seams", "W1"), "--seams", "--only"),
        (("identify", "mh6", "nix.csv", "-o", "x", "--solver", "ga-tabu"), "--solver", "--method"),
        (
            ("plan", "nix.json", "nix.json", "--seam", "W1", "-o", "x", "--work-deg", "5"),
            "--work-deg",
            "--work-angle-deg",
        ),
        (("pick", "nix.step", "--force"), "--force", "--other-part"),
    ],
)
def test_an_old_name_works_with_one_line(words: tuple[str, ...], old: str, new: str) -> None:
    notice, error = run_here(*words).stderr.splitlines()
    assert notice == f"wpcal: {old} is now {new}; the next version knows only that name"
    assert "no such" in error.lower()
    assert "option" not in error


def test_a_file_of_seams_is_no_old_name() -> None:
    (line,) = run_here("advise", "nix.step", "--seams", "nix.json").stderr.splitlines()
    assert "nix." in line
    assert "is now" not in line
