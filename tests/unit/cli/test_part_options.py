"""The options of seams agree with the library."""

import pytest

from cad.cli.options import ReachFlags, SeamFlags
from wpcal.cli.option_groups import option_names
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions


def flags(**changed):
    own, reach = (
        {
            each.name: each.metadata["option"][1].get("default")
            for each in group.__dataclass_fields__.values()
            if each.metadata
        }
        for group in (SeamFlags, ReachFlags)
    )
    assert [*own, *reach] == option_names(SeamFlags)
    return SeamFlags(**{**own, **changed}, reach=ReachFlags(**reach))


def test_the_defaults_are_those_of_the_library():
    assert flags().to_options() == SeamOptions()


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"turn_deg": 0.0}, "--turn-deg must be above 0"),
        ({"gap_mm": -1.0}, "--gap-mm must be positive"),
        ({"split_deg": 200.0}, "--split-deg must be between 0 and 180"),
        ({"min_length_mm": -1.0}, "min_length_mm must be 0 or more"),
    ],
)
def test_values_without_meaning_are_refused(changed, says):
    with pytest.raises(InputError, match=says):
        flags(**changed).to_options()
