"""Options of one subject reach a command as one typed value; a field says everything about each; numbers."""

import json
from dataclasses import asdict, dataclass
from enum import Enum

import click
import pytest
from click.testing import CliRunner

from tests.running import run_here
from wpcal.cli.main import wpcal
from wpcal.cli.number_options import with_strict_numbers
from wpcal.cli.option_groups import command, option_names, takes
from wpcal.cli.torch_options import TorchAsked
from wpcal.core.errors import InputError
from wpcal.core.options import group, opt, opt_deg
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import SeamOptions


class Word(Enum):
    SOFT = "soft"
    HARD = "hard"


@dataclass(frozen=True, slots=True, kw_only=True)
class Inner:
    depth_mm: float = opt(1.5, "How deep.")
    lean_rad: float = opt_deg(30.0, "How far it leans.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outer:
    names: tuple[str, ...] = opt((), "Names.", "--name", many=True)
    inner: Inner = group(Inner)
    is_loud: bool = opt(False, "Loud.", "--loud")
    word: Word = opt(Word.SOFT, "Which.")
    ends: tuple[float, float] = opt((0.0, 2.0), "Both.", metavar="FROM,TO")


@command()
@click.option("--first")
@takes("outer", Outer)
@takes("again", Inner, only=["depth_mm"])
@click.option("--last")
def shown(*, first: str | None, outer: Outer, again: Inner, last: str | None) -> None:
    """Show what arrives."""
    click.echo(json.dumps([first, asdict(outer), again.depth_mm, last], default=lambda word: word.value))


def answer(*words: str) -> list[object]:
    ended = CliRunner().invoke(shown, words)
    assert ended.exit_code == 0, ended.output
    return json.loads(ended.stdout)


def test_the_command_receives_the_groups_as_values():
    typed = ("--last", "z", "--name", "a", "--depth-mm", "2", "--name", "b", "--loud", "--word", "hard", "--ends=-1,4")
    inner = {"depth_mm": 2.0, "lean_rad": pytest.approx(0.5235987755982988)}
    outer = {"names": ["a", "b"], "inner": inner, "is_loud": True, "word": "hard", "ends": [-1.0, 4.0]}
    assert answer(*typed) == [None, outer, 2.0, "z"]


def test_options_that_are_not_given_have_their_defaults():
    assert answer()[1] == json.loads(json.dumps(asdict(Outer(inner=Inner())), default=lambda word: word.value))


def test_the_help_has_the_order_of_the_fields_and_each_option_once():
    flags = ["--first", "--name", "--depth-mm", "--lean-deg", "--loud", "--word", "--ends", "--last"]
    assert [parameter.opts[0] for parameter in shown.params] == flags
    assert option_names(Outer) == [flag.removeprefix("--").replace("-", "_") for flag in flags[1:-1]]


def test_every_option_of_every_command_has_a_help_text():
    context = click.Context(wpcal)
    for name in wpcal.list_commands(context):
        found = wpcal.get_command(context, name)
        without = [p.opts[0] for p in found.params if isinstance(p, click.Option) and not p.help]
        assert without == [], name


def test_the_default_torch_of_the_options_is_the_one_that_is_assumed_everywhere() -> None:
    @command()
    @takes("shape", TorchAsked)
    def torch(*, shape: TorchAsked) -> None:
        click.echo(shape.to_shape())

    assert CliRunner().invoke(torch).output.strip() == str(USUAL_TORCH)


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
