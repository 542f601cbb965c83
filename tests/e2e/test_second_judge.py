"""The text of plans judged a second time, by readers, kinematics and a test of contact that are not wpcal's."""

from pathlib import Path

import numpy as np
import pytest

from tests.cluttered_cells import ROBOTS
from tests.second_judge import ARMS, BRACKETS, FIXED, Planned, planned, result_for, rows_of
from tests.second_readers import READERS
from tests.whole_table import result_of

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytestmark = pytest.mark.skipif(
    not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"
)


@pytest.fixture(scope="module")
def tee(tmp_path_factory: pytest.TempPathFactory) -> Planned:
    folder = tmp_path_factory.mktemp("tee")
    return planned("irb1600_6_12", result_of("tee", folder), folder, ("krl", "urscript"))


@pytest.mark.parametrize("language", ["krl", "urscript"])
def test_no_program_of_a_plan_touches_the_part_with_wire_torch_or_links(tee: Planned, language: str) -> None:
    assert tee.judge is not None
    whole, *alone = tee.routines[language]
    assert len(whole) >= 16
    assert len(alone) == (4 if language == "krl" else 0)
    assert tee.judge.contacts(whole) == []


def test_a_program_without_its_retracts_is_found(tee: Planned) -> None:
    (steps,) = tee.routines["urscript"]
    last = {row for row, step in enumerate(steps[:-1]) if step.kind != "J" and steps[row + 1].kind == "J"}
    assert tee.judge is not None
    found = tee.judge.contacts([step for row, step in enumerate(steps) if row not in last])
    assert {contact.body for contact in found} >= {"torch", "wire and floor"}  # a body alone meets the part


@pytest.mark.deep
@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("part", [*FIXED, *range(BRACKETS)])
def test_no_program_of_any_arm_touches_anything(part: str | int, arm: str, tmp_path: Path) -> None:
    for row in rows_of(str(part), arm, result_for(part, tmp_path), tmp_path, tuple(READERS)):
        print(row)
        assert row.contacts == ()


def test_a_wire_in_a_plate_is_seen() -> None:
    from tests.wire_judge import off_surface, winding

    low, high = np.zeros(3), np.array([100.0, 8.0, 60.0])
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    box = corners[[face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]]
    points = np.array([[50.0, 4.0, 30.0], [50.0, -2.0, 30.0]])
    assert list(np.abs(np.round(winding(points, box)))) == [1.0, 0.0]
    np.testing.assert_allclose(off_surface(points, box), [4.0, 2.0], rtol=0, atol=1e-9)
