"""Triangles against the kernel: closed, outward, as near as stated, with the edges of the model."""

import math
from pathlib import Path

import numpy as np
import pytest

from cad.kernel import tessellate as module
from cad.kernel.tessellate import ANGLE_RAD, mesh_part, tessellate
from cad.samples.parts import box, cut, cylinder
from cad.step.read import read_step
from cad.workpiece.step_file import StepFile, draw_part
from wpcal.brep.mesh import FINEST_MM, SolidMesh, vertex_normals
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import KernelError

FIXTURES = Path(__file__).parents[2] / "fixtures"
ROUND_OFF_MM3 = 1e-6  #: A box of 1e5 mm³ from 64-bit corners.
ON_CIRCLE_MM = 1e-9  #: Nodes are points of the surface itself.

NORMAL = 1e-7  #: The kernel keeps normals as 32-bit numbers.


def volume(solid: SolidMesh) -> float:
    """Volume inside the triangles: the tetrahedra that they span with the origin; negative when inside out."""
    a, b, c = (solid.points[solid.triangles[:, corner]] for corner in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def edge_lengths(solid: SolidMesh) -> FloatArray:
    ends = solid.points[solid.edges]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def test_a_box_has_its_volume_and_every_edge_once_a_face() -> None:
    (solid,) = tessellate([("a", box(100.0, 50.0, 20.0, (7.0, -3.0, 40.0)), None)]).solids
    assert volume(solid) == pytest.approx(1e5, rel=0, abs=ROUND_OFF_MM3)
    assert len(solid.triangles) == 12
    assert edge_lengths(solid).sum() == pytest.approx(2 * 4 * 170.0, rel=0, abs=1e-9)


def test_a_hole_is_as_round_as_stated_and_turns_its_normals_inward() -> None:
    radius = 8.0
    drilled = cut(box(60.0, 60.0, 10.0, (0.0, 0.0, 0.0)), cylinder(radius, 10.0, (30.0, 30.0, 0.0), (0.0, 0.0, 1.0)))
    mesh = tessellate([("a", drilled, None)])
    (solid,) = mesh.solids
    from_axis = solid.points[:, :2] - 30.0
    on_hole = np.linalg.norm(from_axis, axis=1) < radius + 1.0
    np.testing.assert_allclose(np.linalg.norm(from_axis[on_hole], axis=1), radius, rtol=0, atol=ON_CIRCLE_MM)
    n = solid.normals
    on_wall = on_hole & (np.abs(n[:, 2]) < 0.5)
    assert on_wall.sum() > 2 * 2 * math.pi / ANGLE_RAD
    to_axis = -from_axis[on_wall] / radius
    np.testing.assert_allclose(n[on_wall], np.pad(to_axis, ((0, 0), (0, 1))), rtol=0, atol=NORMAL)
    extra = volume(solid) - (60.0 * 60.0 - math.pi * radius**2) * 10.0
    assert 0.0 <= extra <= 2 * math.pi * radius * 10.0 * mesh.deflection_mm  # chords lie inside the hole's circle


def test_the_line_where_a_cylinder_closes_is_no_edge() -> None:
    radius, length = 20.0, 50.0
    (solid,) = tessellate([("a", cylinder(radius, length, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), None)]).solids
    assert np.ptp(solid.points[solid.edges][:, :, 2], axis=1).max() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("name", ["tee", "saddle", "frame"])
def test_samples_keep_names_colours_and_volumes(name: str) -> None:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    part = read_step(FIXTURES / name / f"{name}.step")
    mesh = tessellate((solid.name, solid.shape, solid.color_rgb) for solid in part.solids)
    assert [solid.name for solid in mesh.solids] == [solid.name for solid in part.solids]
    for found, solid in zip(mesh.solids, part.solids, strict=True):
        exact = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid.shape, exact)
        BRepGProp.SurfaceProperties_s(solid.shape, area := GProp_GProps())
        assert volume(found) == pytest.approx(exact.Mass(), rel=0, abs=area.Mass() * mesh.deflection_mm)
        assert found.color_rgb == solid.color_rgb
        assert found.normals is not None
        beside = vertex_normals(found.points, found.triangles)
        assert np.sum(found.normals * beside, axis=1).min() > math.cos(ANGLE_RAD)


def test_instances_of_an_assembly_stand_where_they_belong(shared_step: Path) -> None:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    file = StepFile.open(shared_step / "as1-oc-214.stp")  # of which several are copies, meshed once
    part, mesh = file.step, read_part_glb(draw_part(file)[0] or b"")
    for found, solid in zip(mesh.solids, part.solids, strict=True):
        limits = Bnd_Box()
        BRepBndLib.AddOptimal_s(solid.shape, limits, False, False)
        low, high = limits.CornerMin(), limits.CornerMax()
        expected = [[low.X(), low.Y(), low.Z()], [high.X(), high.Y(), high.Z()]]
        inside = [found.points.min(axis=0), found.points.max(axis=0)]
        np.testing.assert_allclose(inside, expected, rtol=0, atol=mesh.deflection_mm + FINEST_MM)


def test_a_kernel_that_fails_costs_the_picture_only(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise KernelError("meshing web: the CAD kernel failed")

    part = read_step(FIXTURES / "tee" / "tee.step")
    monkeypatch.setattr(module, "tessellate", fail)
    found, issues = mesh_part(part.solids)
    assert found is None
    assert [issue.code for issue in issues] == ["no-mesh"]
    assert "meshing web" in issues[0].message


def test_the_file_knows_which_model_it_is_of() -> None:
    part = read_step(FIXTURES / "tee" / "tee.step")
    found, issues = mesh_part(part.solids, sha256=part.sha256)
    assert found is not None
    assert issues == ()
    assert read_part_glb(found).sha256 == part.sha256
