"""VAL3: what the language asks for; `test_program_text` reads its programs back."""

import re
import xml.etree.ElementTree as ET

import pytest

from wpcal.controllers.staubli.grammar import read_val3
from wpcal.controllers.staubli.write import write_val3
from wpcal.core.errors import FormatError, InputError

DATA = "{http://www.staubli.com/robotics/VAL3/Data/2}"
PROGRAM = "{http://www.staubli.com/robotics/VAL3/Program/2}"


def test_the_program_goes_along_the_seam_and_keeps_the_configuration(make_program):
    files = write_val3(make_program(n=5, names=("a]]>b", "W1")))
    code = ET.fromstring(files["start.pgx"].encode()).find(f".//{PROGRAM}Code").text
    data = {element.get("name"): element for element in ET.fromstring(files["WPCAL.dtx"].encode()).iter(f"{DATA}Data")}
    assert "a]] >b -> a_b" in code
    order = re.findall(r"move[jl]\(W1\[(\w+)\]|// (ARC \w+)\n|for nPoint=(\d to \d)", code[code.index("movej(W1") :])
    assert order == [
        ("0", "", ""), ("1", "", ""), ("", "ARC ON", ""), ("", "", "2 to 3"), ("nPoint", "", ""), ("", "ARC OFF", ""),
        ("4", "", ""),
    ]  # fmt: skip
    assert {value.get("shoulder") for value in data["W1"]} == {"ssame"}
    assert "declare the tool tTorch" in code
    assert "tTorch" not in data


def test_an_array_holds_at_most_9999_points(make_program):
    with pytest.raises(InputError, match="seam W1 has 10000 points"):
        write_val3(make_program(n=10_000))


@pytest.mark.parametrize("encoding", ["foo1", "utf-7", "idna", "hex"])
def test_an_encoding_that_no_reader_knows_is_one_line(encoding):
    with pytest.raises(FormatError, match="is not XML") as caught:
        read_val3(f'<?xml version="1.0" encoding="{encoding}"?><Database/>', "a.dtx")
    assert "\n" not in str(caught.value)
