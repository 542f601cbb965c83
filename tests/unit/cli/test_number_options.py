"""An option takes numbers only, by the rule of all input."""

import pytest

from tests.running import run_here
from wpcal.cli.number_options import with_strict_numbers


@pytest.mark.parametrize("text", ["nan", "inf", "1e400", "2e9", "81_2", "１２", "true", ""])
@pytest.mark.parametrize("option", ["--tolerance-mm", "--sigma-mm"])
def test_what_is_no_number_is_refused(option: str, text: str) -> None:
    ended = run_here("fit", "pairs.csv", option, text)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert f"Invalid value for '{option}': expected a" in ended.stderr
    assert ended.stderr.count("\n") == 1


@pytest.mark.parametrize("text", ["1.5", "1_0", "９", "1e3", "9" * 5000])
def test_what_is_no_whole_number_is_refused(text: str) -> None:
    ended = run_here("study", "--seed", text)
    assert ended.returncode == 2
    assert "Invalid value for '--seed': expected a whole number" in ended.stderr


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
