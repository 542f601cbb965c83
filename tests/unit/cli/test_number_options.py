"""Values of options: numbers, and the options of a part."""

import pytest

from tests.running import run_here
from wpcal.cli.number_options import with_strict_numbers
from wpcal.cli.option_groups import command, takes
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions

NO_NUMBERS = ["nan", "inf", "1e400", "2e9", "81_2", "１２", "true", ""]
OPTIONS = {"--tolerance-mm": NO_NUMBERS, "--sigma-mm": NO_NUMBERS, "--seed": ["1.5", "1_0", "９", "1e3", "9" * 5000]}


@pytest.mark.parametrize(("option", "text"), [(option, text) for option, texts in OPTIONS.items() for text in texts])
def test_what_is_no_number_is_refused(option: str, text: str) -> None:
    ended = run_here(*(("study",) if option == "--seed" else ("fit", "pairs.csv")), option, text)
    assert (ended.returncode, ended.stdout, ended.stderr.count("\n")) == (2, "", 1)
    assert f"Invalid value for '{option}': expected a{' whole number' if option == '--seed' else ''}" in ended.stderr


def test_help_and_ranges_stay() -> None:
    import click

    @click.command()
    @click.option("--part", type=click.FloatRange(0, 1), default=0.5)
    def command(part: float) -> None:
        raise AssertionError(part)

    strict = with_strict_numbers(with_strict_numbers(command))
    assert "0<=x<=1" in strict.get_help(click.Context(strict))
    assert "FLOAT" in strict.get_help(click.Context(strict))
    for text, says in {"2": "is not in the range", "nan": "expected a finite number"}.items():
        with pytest.raises(click.BadParameter, match=says):
            strict.make_context("command", ["--part", text])
    assert strict.make_context("command", ["--part", "0.25"]).params == {"part": 0.25}


def read(*words: str) -> SeamOptions:
    found: list[SeamOptions] = []
    made = command()(takes("value", SeamOptions)(lambda **given: found.append(given["value"])))
    made.main(list(words), standalone_mode=False)
    return found[0]


def test_the_defaults_are_those_of_the_library():
    assert read() == SeamOptions()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--turn-deg", "0"], "--turn-deg must be above 0"),
        (["--gap-mm=-1"], "--gap-mm must be positive"),
        (["--split-deg", "200"], "--split-deg must be between 0 and 180"),
        (["--min-length-mm=-1"], "min_length_mm must be 0 or more"),
        (["--strict", "--generous"], "--strict and --generous exclude each other"),
        (["--work-range-deg", "1,2,3"], "--work-range-deg: expected FROM,TO in degrees, got '1,2,3'"),
    ],
)
def test_values_without_meaning_are_refused(words, says):
    with pytest.raises(InputError, match=says):
        read(*words)
