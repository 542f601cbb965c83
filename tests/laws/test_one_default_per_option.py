"""Law: an option has one default, on the field of the library that uses it; help and behaviour follow that field."""

import re
from dataclasses import fields
from pathlib import Path

import click
import pytest

from cad.workpiece.advise import AdviseOptions
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.options import FitOptions
from wpcal.cli.main import wpcal
from wpcal.cli.option_groups import command, takes
from wpcal.controllers.program.weld_program import MotionSettings
from wpcal.core.options import OPTION
from wpcal.planning.search.nsga2 import Nsga2Options
from wpcal.planning.search.objectives import WeldTargets
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.robot.identify.identification import IdentifyOptions
from wpcal.robot.moves.fit import PathTolerance
from wpcal.seam.options import SeamOptions, StepOptions
from wpcal.touch.plan.options import NominalError, TouchOptions

ROOT = Path(__file__).parents[2]
GROUPS = [
    *(SeamOptions, StepOptions, FitOptions, CalibrateOptions, TeachingError, AdviseOptions, MotionSettings),
    *(PathTolerance, SequenceTargets, WeldTargets, Nsga2Options, IdentifyOptions, TouchOptions, NominalError),
]
NUMBERS = [
    (group, each.name)
    for group in GROUPS
    for each in fields(group)
    if OPTION in each.metadata and isinstance(each.default, int | float) and not isinstance(each.default, bool)
]


@pytest.mark.parametrize(("group", "name"), NUMBERS, ids=lambda each: getattr(each, "__name__", each))
def test_help_and_value_follow_the_field(group, name, monkeypatch):
    each = group.__dataclass_fields__[name]
    step = 0.1 if name.endswith("_rad") else 1
    most = each.metadata[OPTION].most
    changed = each.default / 2 if most is not None and each.default + step > most else each.default + step
    monkeypatch.setattr(each, "default", changed)
    found = []
    fresh = command()(takes("value", group, only=[name])(lambda **given: found.append(given["value"])))
    fresh.main([], standalone_mode=False)
    assert getattr(found[0], name) == pytest.approx(changed)
    (option,) = [p for p in fresh.params if isinstance(p, click.Option)]
    in_degrees = name.endswith("_rad")
    assert option.default == pytest.approx(changed * 57.29577951308232 if in_degrees else changed)
    assert str(option.default) in fresh.get_help(click.Context(fresh))


@pytest.mark.parametrize("folder", ["wpcal/cli", "cad/cli", "cad/rpc"])
def test_no_file_of_a_command_says_a_number_as_a_default(folder):
    for path in sorted((ROOT / folder).glob("*.py")):
        said = re.findall(r"\bdefault=-?\d[\d._]*|opt(?:_deg)?\(\s*-?[1-9][\d.]*", path.read_text(encoding="utf-8"))
        assert [one for one in said if not re.search(r"=0$", one)] == [], path


def test_a_command_takes_the_defaults_of_the_library():
    context = click.Context(wpcal)
    seams = wpcal.get_command(context, "seams")
    shown = {p.name: p.default for p in seams.params}
    usual = SeamOptions()
    assert (shown["min_length_mm"], shown["join_mm"]) == (usual.min_length_mm, usual.join_mm)
    assert (shown["chord_mm"], shown["max_step_mm"]) == (usual.steps.chord_mm, usual.steps.max_step_mm)
