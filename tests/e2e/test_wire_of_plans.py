"""The wire on the joint moves of a plan: judged by the URDF file and the part's triangles, not by the planner."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.few import few
from tests.running import FINISHED, run_here
from tests.samples.plates import write_part
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.cli.part_option import read_part_option

pytest.importorskip("fcl", reason="python-fcl is not installed")
ROBOT = Path(__file__).parents[3] / "shared" / "robots" / "irb2600_12_165" / "irb2600_12_165.urdf"
pytestmark = pytest.mark.skipif(not ROBOT.is_file(), reason="the URDF files lie beside the checkout and are not here")
TORCH, WIRE_MM, WIRE_RADIUS_MM = "robot-22", 18.0, 0.6
PLACES = {"t_joint": "900,-50,500,0,0,30", "saddle": "1050,0,560,0,0,15"}
WELDED = 0.9  #: Share of the accepted length that is welded at least.


@pytest.mark.parametrize(
    "name", few(["t_joint", "saddle", "bracket", "box_frame"], 0)
)  # `test_second_judge` at each push
def test_the_wire_stays_out_of_the_part_between_welds(name: str, tmp_path: Path) -> None:
    from tests.real_cells import RealCell
    from tests.wire_judge import wire_in_the_air

    part, cell = write_part(name, tmp_path), tmp_path / "cell.json"
    new = ("cell", "new", "--torch-robot", ROBOT, "--tool", "60,10,370,0,40,0", "--torch", TORCH)
    table = ("--box", "700,-350,0,1500,550,480", "--part-at", PLACES.get(name, PLACES["t_joint"]))
    assert run_here(*new, *table, "-o", cell).returncode == 0
    found = run_here("seams", part, "--torch", TORCH, "--json").stdout
    (tmp_path / "seams.json").write_text(found, encoding="utf-8")
    plan = ("plan", cell, tmp_path / "seams.json", "--part", part, "-f", "rapid", "-o", tmp_path / "plan")
    assert run_here(*plan).returncode in FINISHED
    record = json.loads((tmp_path / "plan" / "plan.json").read_text(encoding="utf-8"))
    triangles = TriangleMaterial.of(read_part_glb(read_part_option(part) or b""))
    real = RealCell(cell, {"robot": ROBOT}, triangles.corners)
    on_the_way = wire_in_the_air(real, triangles.corners, record, WIRE_MM)
    assert on_the_way.deepest_mm == 0.0
    assert on_the_way.least_mm > WIRE_RADIUS_MM
    accepted = sum(seam["length_mm"] for seam in json.loads(found)["seams"] if seam["accepted"])
    assert record["welded_mm"] >= (WELDED if name in PLACES else 0.0) * accepted
    pieces = record["kept"]["pieces"]
    assert all(min(piece["before"], piece["after"]) > 0 for piece in pieces), "a joint move begins or ends in the pool"
    limits = np.degrees(real.robot.limits)[:, :2]
    axes = np.array([point["axes"] for point in record["points"]])
    assert (np.minimum(axes - limits[:, 0], limits[:, 1] - axes) > 1.0 - 1e-6).all()


def test_a_wire_in_a_plate_is_seen() -> None:
    from tests.wire_judge import off_surface, winding

    low, high = np.zeros(3), np.array([100.0, 8.0, 60.0])
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    box = corners[[face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]]
    points = np.array([[50.0, 4.0, 30.0], [50.0, -2.0, 30.0]])
    assert list(np.abs(np.round(winding(points, box)))) == [1.0, 0.0]
    np.testing.assert_allclose(off_surface(points, box), [4.0, 2.0], rtol=0, atol=1e-9)
