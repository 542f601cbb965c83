"""VAL3, read back by an XML parser that knows the language and nothing of the writer."""

import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from wpcal.controllers.staubli.write import write_val3
from wpcal.core.errors import InputError

ATOL_MM = 1e-5
"""Five decimals in three coordinates: 0.9e-5."""
ATOL_DEG = 1e-6
"""Six decimals: √3/2 units."""
DATA = "{http://www.staubli.com/robotics/VAL3/Data/2}"
PROGRAM = "{http://www.staubli.com/robotics/VAL3/Program/2}"


def place(element):
    v = [float(element.get(key)) for key in ("x", "y", "z", "rx", "ry", "rz")]
    return np.array(v[:3]), Rotation.from_euler("XYZ", v[3:], degrees=True)


def part_frame(files):
    database = ET.fromstring(files["WPCAL.dtx"].encode())
    return next(place(element[0]) for element in database.iter(f"{DATA}Data") if element.get("name") == "fPart")


def parse(files):
    """Positions and axes in the base of all points in the order of the program, whose code comes along."""
    database = ET.fromstring(files["WPCAL.dtx"].encode())
    data = {element.get("name"): element for element in database.iter(f"{DATA}Data")}
    p_base, R_base = part_frame(files)
    code = ET.fromstring(files["start.pgx"].encode()).find(f".//{PROGRAM}Code").text
    positions, axes = [], []
    for name in dict.fromkeys(re.findall(r"move[jl]\((\w+)\[", code)):
        assert int(data[name].get("size")) == len(data[name])
        for key, value in enumerate(data[name]):
            assert (value.get("key"), value.get("fatherId")) == (str(key), "fPart[0]")
            p, R = place(value)
            positions.append(R_base.apply(p) + p_base)
            axes.append((R_base * R).as_matrix())
    return positions, axes, code, data


@given(seed=st.integers(0, 2**32))
def test_what_is_written_is_read_back(make_program, assert_same_poses, seed):
    program = make_program(seed, names=("W1", "Rib 7/ä"))
    p, R, _, _ = parse(write_val3(program))
    assert_same_poses(p, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


@given(seed=st.integers(0, 2**32))
def test_the_frame_is_the_part(make_program, assert_is_the_part, seed):
    program = make_program(seed)
    p, R = part_frame(write_val3(program))
    assert_is_the_part(p, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


def test_the_program_goes_along_the_seam_and_keeps_the_configuration(make_program):
    _, _, code, data = parse(write_val3(make_program(n=5, names=("a]]>b", "W1"))))
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
