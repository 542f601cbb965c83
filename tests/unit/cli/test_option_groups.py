"""Options of one subject reach a command as one typed value."""

import json
from dataclasses import asdict, dataclass

import click
from click.testing import CliRunner

from wpcal.cli.main import wpcal
from wpcal.cli.option_groups import option, option_names, takes
from wpcal.cli.torch_options import TorchShapeFlags
from wpcal.robot.torch.shape import USUAL_TORCH


@dataclass(frozen=True, slots=True, kw_only=True)
class Inner:
    depth_mm: float = option("--depth-mm", type=float, default=1.5, show_default=True, help="How deep.")


@dataclass(frozen=True, slots=True, kw_only=True)
class Outer:
    names: tuple[str, ...] = option("--name", multiple=True)
    inner: Inner
    is_loud: bool = option("--loud", is_flag=True)


@click.command()
@click.option("--first")
@takes("outer", Outer)
@click.option("--last")
def command(*, first: str | None, outer: Outer, last: str | None) -> None:
    """Show what arrives."""
    click.echo(json.dumps([first, asdict(outer), last]))


def test_the_command_receives_the_groups_as_values():
    shown = CliRunner().invoke(command, ["--last", "z", "--name", "a", "--depth-mm", "2", "--name", "b", "--loud"])
    assert json.loads(shown.stdout) == [
        None,
        {"names": ["a", "b"], "inner": {"depth_mm": 2.0}, "is_loud": True},
        "z",
    ]


def test_options_that_are_not_given_have_their_defaults():
    shown = CliRunner().invoke(command, [])
    assert json.loads(shown.stdout)[1] == {"names": [], "inner": {"depth_mm": 1.5}, "is_loud": False}


def test_the_help_has_the_order_of_the_fields():
    assert [parameter.opts[0] for parameter in command.params] == [
        "--first",
        "--name",
        "--depth-mm",
        "--loud",
        "--last",
    ]
    assert option_names(Outer) == ["names", "depth_mm", "is_loud"]


def test_every_option_of_every_command_has_a_help_text():
    context = click.Context(wpcal)
    for name in wpcal.list_commands(context):
        found = wpcal.get_command(context, name)
        assert found is not None
        without = [p.opts[0] for p in found.params if isinstance(p, click.Option) and not p.help]
        assert without == [], name


def test_the_default_torch_of_the_options_is_the_one_that_is_assumed_everywhere() -> None:
    @click.command()
    @takes("shape", TorchShapeFlags)
    def torch(*, shape: TorchShapeFlags) -> None:
        click.echo(shape.to_shape())

    assert CliRunner().invoke(torch).output.strip() == str(USUAL_TORCH)
