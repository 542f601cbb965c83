"""The options of seams agree with the library."""

import pytest

from wpcal.cli.option_groups import command, takes
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions


def read(*words: str) -> SeamOptions:
    found: list[SeamOptions] = []
    command()(takes("value", SeamOptions)(lambda **given: found.append(given["value"]))).main(
        list(words), standalone_mode=False
    )
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
