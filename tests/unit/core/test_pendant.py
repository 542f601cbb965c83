"""A pose in the notations of the pendants gives the pose back, and is what the programs state."""

import re
from pathlib import Path

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.core.pendant import NOTATIONS
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

SAME = 1e-9
PAGES = Path(__file__).parents[3] / "docs" / "how-to"
TEE = RigidTransform.from_six_tuple(  # of fixtures/tee/golden
    [812.498203, -240.210720, 155.805057, 0.0191139, -0.0353406, 0.5993390], target="base", source="part"
)
BY_MAKER = {notation.maker: notation for notation in NOTATIONS}


def poses():
    rng = np.random.default_rng(3)
    turns = [exp_rotation(v) for v in rng.normal(size=(40, 3)) * rng.uniform(0, 2, (40, 1))]
    quarter = [
        rotation_from_zyx(a, b, c) for a in (0, np.pi / 2) for b in (np.pi / 2, -np.pi / 2) for c in (0.3, np.pi)
    ]
    half = [np.diag(d) for d in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1], [1, 1, 1])]
    return [RigidTransform(R, rng.normal(size=3) * 1000, "base", "part") for R in (*turns, *quarter, *half)]


@pytest.mark.parametrize("notation", NOTATIONS, ids=lambda notation: notation.maker)
def test_the_numbers_give_the_pose_back(notation):
    for T in poses():
        back = notation.transform(notation.numbers(T), target="base", source="part")
        np.testing.assert_allclose(back.R, T.R, rtol=0, atol=SAME)
        np.testing.assert_allclose(back.t_mm, T.t_mm, rtol=0, atol=SAME)


@pytest.mark.parametrize("notation", NOTATIONS, ids=lambda notation: notation.maker)
def test_what_a_person_copies_is_within_two_hundredths_two_metres_away(notation):
    for T in poses():
        typed = [float(number) for number in re.findall(r"-?\d+\.\d+", notation.text(T))]
        back = notation.transform(typed, target="base", source="part")
        far = 2000 * np.eye(3)
        assert np.linalg.norm(back.rotate(far) - T.rotate(far), axis=1).max() <= 0.02
        assert not re.search(r"-0\.0+\b", notation.text(T))
        assert [len(one.split(".")[1]) for one in re.findall(r"\d+\.\d+", notation.text(T))][:3] == [3] * 3  # µm


def test_a_known_turn_in_every_notation():
    T = RigidTransform(rotation_from_zyx(0, 0, np.pi / 2), np.array([1.0, 2.0, 3.0]), "base", "part")
    half = np.sqrt(0.5)
    known = {
        "ABB": [half, 0, 0, half],
        "KUKA": [90, 0, 0],
        "FANUC": [0, 0, 90],
        "Yaskawa": [0, 0, 90],
        "Staubli": [0, 0, 90],
        "Kawasaki": [90, 0, 0],
        "UR": [0, 0, np.pi / 2],
    }
    assert known.keys() == BY_MAKER.keys()
    for maker, numbers in known.items():
        np.testing.assert_allclose(BY_MAKER[maker].numbers(T), [1, 2, 3, *numbers], rtol=0, atol=SAME)


def test_the_makers_differ_in_the_order_of_the_turns():
    T = RigidTransform(rotation_from_zyx(*np.deg2rad([10, 20, 30])), np.zeros(3), "base", "part")
    np.testing.assert_allclose(BY_MAKER["FANUC"].numbers(T)[3:], [10, 20, 30], rtol=0, atol=SAME)
    np.testing.assert_allclose(BY_MAKER["KUKA"].numbers(T)[3:], [30, 20, 10], rtol=0, atol=SAME)
    rx, ry, rz = np.deg2rad(BY_MAKER["Staubli"].numbers(T)[3:])
    Rx, Ry, Rz = rotation_from_zyx(rx, 0, 0), rotation_from_zyx(0, ry, 0), rotation_from_zyx(0, 0, rz)
    np.testing.assert_allclose(Rx @ Ry @ Rz, T.R, rtol=0, atol=SAME)


SHOWN = {  # where the page shows the pose of the part, and which numbers
    "abb.md": ("ABB", r"wpPart:=\[FALSE,TRUE,\"\",\[\[(.*?)\],\[(.*?)\]\]", 1.0),
    "kuka.md": ("KUKA", r"FRAME WP_PART=\{X (\S+?),Y (\S+?),Z (\S+?),A (\S+?),B (\S+?),C (\S+?)\}", 1.0),
    "fanuc.md": ("FANUC", r"! X (\S+) ;\s+\d+:  ! Y (\S+) ;\s+\d+:  ! Z (\S+) ;\s+\d+:  ! W (\S+) ;\s+\d+:  ! P (\S+) ;"
                 r"\s+\d+:  ! R (\S+) ;", 1.0),
    "yaskawa.md": ("Yaskawa", r"' X (\S+)\n' Y (\S+)\n' Z (\S+)\n' Rx (\S+)\n' Ry (\S+)\n' Rz (\S+)", 1.0),
    "kawasaki.md": ("Kawasaki", r"\nwp_part (\S+) (\S+) (\S+) (\S+) (\S+) (\S+)\n", 1.0),
    "universal-robots-and-staubli.md": ("UR", r"wp_part = p\[(.*?)\]", 1000.0),
}  # fmt: skip


@pytest.mark.parametrize("page", SHOWN)
def test_the_programs_of_the_how_to_pages_state_the_same_pose(page):
    maker, pattern, scale = SHOWN[page]
    found = re.search(pattern, (PAGES / page).read_text(encoding="utf-8"))
    numbers = np.array([float(number) for group in found.groups() for number in group.split(",")])
    numbers[:3] *= scale
    stated = BY_MAKER[maker].transform(numbers, target="base", source="part")
    np.testing.assert_allclose(stated.t_mm, TEE.t_mm, rtol=0, atol=6e-4)  # FANUC has three decimals
    np.testing.assert_allclose(stated.R, TEE.R, rtol=0, atol=2e-5)


def test_a_wrong_count_is_refused():
    with pytest.raises(InputError, match="ABB: expected X, Y, Z, q1, q2, q3, q4, got 6 numbers"):
        BY_MAKER["ABB"].transform(np.zeros(6), target="base", source="part")
