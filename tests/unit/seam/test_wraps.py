"""Short ends of plates are wraps of the seams beside them; `wrap` welds them in one run round the corner."""

import numpy as np
import pytest

from tests.saved_graphs import saved_seams
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.path.corners import CORNER_STEP_RAD
from wpcal.seam.path.turning import rotation_angles
from wpcal.seam.record import seams_from_record, seams_record

ROUND_OFF = 1e-9


def seams_of(name: str, *, wrap: bool = False, **options: float) -> tuple[Seam, ...]:
    return saved_seams(name, SeamOptions(wrap=wrap, **options))


def test_the_ends_of_a_web_are_wraps_of_the_seams_along_it() -> None:
    seams = {seam.name: seam for seam in seams_of("tee")}
    assert {name: (seam.accepted, seam.wrap_of) for name, seam in seams.items()} == {
        "W1": (False, "W2"),
        "W2": (True, None),
        "W3": (True, None),
        "W4": (False, "W2"),
    }
    assert seams["W1"].against == ("the short end of W2: welded with it (--wrap), or left open",)
    again = seams_from_record(seams_record(tuple(seams.values())), path="seams.json")
    assert [seam.wrap_of for seam in again] == ["W2", None, None, "W2"]


@pytest.mark.parametrize("name", ["lap", "joint-lap", "frame"])
def test_sides_of_bars_and_tubes_are_no_short_ends(name: str) -> None:
    assert not any(seam.wrap_of for seam in seams_of(name))


@pytest.mark.parametrize(("name", "length"), [("tee", 316.0), ("joint-tee-in-one", 336.0), ("joint-butt", 416.0)])
def test_with_wrap_there_is_one_run_round_the_plate(name: str, length: float) -> None:
    (seam,) = seams_of(name, wrap=True, min_length_mm=10.0)
    assert (seam.closed, seam.accepted, seam.wrap_of) == (True, True, None)
    assert seam.length_mm == pytest.approx(length, rel=0, abs=ROUND_OFF)
    first, last = seam.frames.matrices[[0, -1]]
    np.testing.assert_array_equal(first, last)
    np.testing.assert_allclose(seam.frames.R[0], seam.frames.R[1], rtol=0, atol=ROUND_OFF)  # not at a corner


def test_at_a_corner_the_torch_turns_about_the_normal_of_the_base_at_a_constant_rate() -> None:
    (seam,) = seams_of("tee", wrap=True)
    frames = seam.frames
    turns = rotation_angles(frames.R[:-1], frames.R[1:])
    assert turns.max() <= CORNER_STEP_RAD + ROUND_OFF
    assert turns.sum() == pytest.approx(2 * np.pi, rel=0, abs=1e-6)
    np.testing.assert_allclose(frames.R[:, 2, 2], np.sqrt(0.5), rtol=0, atol=ROUND_OFF)  # 45 degrees to the base
    np.testing.assert_allclose(frames.R[:, 2, 0], 0.0, rtol=0, atol=ROUND_OFF)  # and x stays in its plane
    np.testing.assert_allclose(np.linalg.det(frames.R), 1.0, rtol=0, atol=ROUND_OFF)
    x, y, _ = frames.p.T
    off = np.maximum(np.abs(x - 100.0) - 75.0, np.abs(y - 60.0) - 4.0)
    np.testing.assert_allclose(off, 0.0, rtol=0, atol=ROUND_OFF)  # the tip stays on the edges of the web


def test_nothing_else_is_joined() -> None:
    """On a tube frame, accepted seams of one rail meet round its end; those of two rails do not become one."""
    plain, wrapped = seams_of("frame"), seams_of("frame", wrap=True)
    accepted = [sum(seam.length_mm for seam in seams if seam.accepted) for seams in (plain, wrapped)]
    assert accepted[0] == pytest.approx(accepted[1], rel=0, abs=1e-6)
    assert {seam.solids for seam in wrapped if seam.accepted} == {seam.solids for seam in plain if seam.accepted}
