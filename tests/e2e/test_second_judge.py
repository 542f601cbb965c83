"""The text of plans judged a second time, by readers, kinematics and a test of contact that are not wpcal's."""

from pathlib import Path

import numpy as np
import pytest

from tests.cluttered_cells import ROBOTS
from tests.second_judge import ARMS, BRACKETS, FIXED, LANGUAGES, Planned, planned, result_for, rows_of
from tests.unit.seam.test_material import box_of_triangles
from tests.whole_table import result_of

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytestmark = pytest.mark.skipif(
    not ROBOTS.is_dir(), reason="the folder of URDF files lies beside the checkout and is not here"
)

WELDED = 0.9  #: The least share of the accepted length: a program that welds little touches nothing.


@pytest.fixture(scope="module")
def tee(tmp_path_factory: pytest.TempPathFactory) -> Planned:
    folder = tmp_path_factory.mktemp("tee")
    return planned("irb1600_6_12", result_of("tee", folder), folder, ("krl", "urscript"))


@pytest.mark.parametrize("language", ["krl", "urscript"])
def test_no_program_of_a_plan_touches_the_part_with_wire_torch_or_links(tee: Planned, language: str) -> None:
    whole, *alone = tee.routines[language]
    assert len(whole) >= 16
    assert len(alone) == (4 if language == "krl" else 0)
    states = list(tee.judge.states(whole))
    assert tee.judge.contacts(states) == []
    assert tee.judge.welded_share(states, result_of("tee", Path())) >= WELDED


def test_a_program_without_its_retracts_is_found(tee: Planned) -> None:
    (steps,) = tee.routines["urscript"]
    last = {row for row, step in enumerate(steps[:-1]) if step.kind != "J" and steps[row + 1].kind == "J"}
    found = tee.judge.contacts(tee.judge.states([step for row, step in enumerate(steps) if row not in last]))
    assert {contact.body for contact in found} >= {"nozzle", "wire and floor"}  # a body alone meets the part


@pytest.mark.deep
@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("part", [*FIXED, *range(BRACKETS)])
def test_no_program_of_any_arm_touches_anything(part: str | int, arm: str, tmp_path: Path) -> None:
    for row in rows_of(str(part), arm, result_for(part, arm, tmp_path), tmp_path, LANGUAGES):
        print(row)
        assert row.contacts == ()
        assert row.refused or row.welded >= WELDED


def test_a_wire_in_a_plate_is_seen() -> None:
    from tests.wire_judge import off_surface, winding

    plate = box_of_triangles("plate", [50.0, 4.0, 30.0], np.eye(3))
    box = plate.points[plate.triangles]
    points = np.array([[0.0, 0.0, 0.0], [0.0, -6.0, 0.0]])
    assert list(np.abs(np.round(winding(points, box)))) == [1.0, 0.0]
    np.testing.assert_allclose(off_surface(points, box), [4.0, 2.0], rtol=0, atol=1e-9)
