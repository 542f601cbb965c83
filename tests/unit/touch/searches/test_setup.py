"""The touch setup of a cell: its template, and what is refused."""

import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest

from wpcal.core.errors import InputError
from wpcal.touch.searches import TouchSetup, read_touch_setup, setup_template


def test_template_has_every_key_with_its_default_and_a_sentence(tmp_path: Path) -> None:
    file = tmp_path / "touch-setup.toml"
    file.write_text(setup_template(), encoding="utf-8")
    assert read_touch_setup(file) == TouchSetup()
    record = tomllib.loads(setup_template())
    for each in fields(TouchSetup):
        value = getattr(TouchSetup(), each.name)
        written = record[each.name]
        assert written == ({k.name: getattr(value, k.name) for k in fields(value)} if is_dataclass(value) else value)
    lines = setup_template().splitlines()
    top = [n for n, line in enumerate(lines) if " = " in line and not line.startswith("#")][: len(record) - 5]
    assert all(lines[n - 1].startswith("# ") for n in top)
    assert all(lines[n - 1].endswith(".") for n in top)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('sgnal = "x"', "unknown key 'sgnal'; did you mean signal?"),
        ("interrupt = 3", "unknown key 'interrupt': it belongs into the section [krl]"),
        ('[krl]\nsignal = "1"', "unknown key '[krl] signal': it belongs before the first section"),
        ('hold_s = "a"', "hold_s: expected a number, got 'a'"),
        ("is_on_high = 1", "is_on_high: expected true or false, got 1"),
        ("search_speed_mm_s = 200", "search_speed_mm_s: expected a number of more than 0 and below 100, got 200"),
        ("search_speed_mm_s = nan", "got nan"),
        ("search_speed_mm_s = 0", "got 0"),
        ("krl = 3", "krl: expected a section [krl], got 3"),
        ("frame_number = -1", "frame_number: expected a number from 0 to 65535, got -1"),
        ("[fanuc]\nfirst_register = 300", "first_register = 300 is after last_register = 200"),
        ("x", "is not TOML"),
    ],
)
def test_a_wrong_setup_is_one_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "s.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_touch_setup(file)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_signal_may_be_typed_as_a_number(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text("signal = 7\n[krl]\ninterrupt = 21\n", encoding="utf-8")
    setup = read_touch_setup(file)
    assert (setup.signal, setup.krl.interrupt, setup.fanuc.first_register) == ("7", 21, 151)
