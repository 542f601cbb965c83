"""URScript, read back by a parser that knows the language and nothing of the writer."""

import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from wpcal.controllers.ur.write import write_urscript

ATOL_MM = 1e-6
"""Nine decimals of a metre in three coordinates: 0.9e-6."""
ATOL_DEG = 1e-7
"""Nine decimals of a rad in three components: 5e-8 deg."""
POSE = r"p\[([^\]]*)\]"


def place(text):
    v = [float(value) for value in text.split(",")]
    return np.array(v[:3]) * 1000.0, Rotation.from_rotvec(v[3:])


def part_frame(text):
    return place(re.search(rf"wp_part = {POSE}", text)[1])


def parse(text):
    """Positions and axes in the base, and moves with their markers."""
    p_base, R_base = part_frame(text)
    poses = [place(values) for values in re.findall(rf"move[jl]\(pose_trans\(wp_part, {POSE}\)", text)]
    moves = re.findall(r"^  (?:(move[jl])\(|# (ARC \w+)$)", text, re.MULTILINE)
    return [R_base.apply(p) + p_base for p, _ in poses], [(R_base * R).as_matrix() for _, R in poses], moves


@given(seed=st.integers(0, 2**32))
def test_what_is_written_is_read_back(make_program, assert_same_poses, seed):
    program = make_program(seed, names=("W1", "Rib 7/ä"))
    p, R, _ = parse(write_urscript(program)["WPCAL.script"])
    assert_same_poses(p, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


@given(seed=st.integers(0, 2**32))
def test_the_frame_is_the_part(make_program, assert_is_the_part, seed):
    program = make_program(seed)
    p, R = part_frame(write_urscript(program)["WPCAL.script"])
    assert_is_the_part(p, R, program, atol_mm=ATOL_MM, atol_deg=ATOL_DEG)


def test_moves_come_in_order_with_the_arc_along_the_seam(make_program):
    moves = parse(write_urscript(make_program(n=5))["WPCAL.script"])[2]
    assert [move or mark for move, mark in moves] == [
        "movej", "movel", "ARC ON", "movel", "movel", "ARC OFF", "movel",
    ]  # fmt: skip


def test_a_name_cannot_break_out_of_its_comment(make_program):
    text = write_urscript(make_program(names=("x\n  movej(home)",)))["WPCAL.script"]
    assert not re.search(r"^\s*movej\(home", text, re.MULTILINE)
