"""The kernel's classifier agrees with the check of poses: what passes is outside the part, what is refused is not.

Random points in the wire and in the nozzle are classified. A pose that passes has none of them deeper inside than the
triangles' deflection; a pose that is refused has points inside, or within the deflection of a face.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_IN, TopAbs_OUT

from cad.kernel.tessellate import tessellate
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from wpcal.brep.material import ExactMaterial, TriangleMaterial
from wpcal.core.arrays import FloatArray
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.judge.material import TorchPart, find_poses_in_material
from wpcal.seam.judge.stations import start_mm

FIXTURES = Path(__file__).parents[2] / "fixtures"
POINTS = 24  #: Per pose, in each of wire and nozzle.
CLOSE = 20_000  #: Per refused pose, all in the part of the torch that was refused.
OUTERMOST = 1.16
"""The outermost of the lines that stand for a tube against exact faces is at most this much wider than the tube."""
PARTS = ("fixture:tee", "blind/mini/g180.step", "fixture:lap", "fixture:frame", "blind/mini/hole10.step")
MINI = ("g80", "hole3", "lug", "pp_narrow", "pp_over", "pp_tangent", "t0", "t30", "em_re")
MORE = (
    "fixture:saddle",
    *(f"step/{n}" for n in ("as1-oc-214.stp", "box_sides.STEP", "dm1-id-214.stp", "tail_section_asm.stp")),
    *(f"blind/mini/{name}.step" for name in MINI),
    *(f"blind/{name}.step" for name in ("afpm_boom_vane", "wb_bench")),
)


class Solids:
    """The solids of a part, to be asked for points."""

    def __init__(self, names: tuple[str, ...], shapes: tuple[Any, ...], boxes: FloatArray) -> None:
        self.names, self.boxes = names, boxes
        self.classifiers = [BRepClass3d_SolidClassifier(shape) for shape in shapes]

    def states(self, number: int, points: FloatArray, tolerance_mm: float) -> Iterator[Any]:
        low, high = self.boxes[number]
        near = points[((points >= low) & (points <= high)).all(axis=1)]
        for p in near:
            self.classifiers[number].Perform(gp_Pnt(*p.tolist()), tolerance_mm)
            yield self.classifiers[number].State()


def in_tube(
    rng: np.random.Generator, p: FloatArray, back: FloatArray, low: float, high: float, radius: float, count: int
) -> FloatArray:
    """Random points in a straight tube, a third of them on its surface."""
    u = np.cross(back, np.eye(3)[np.argmin(np.abs(back))])
    u /= np.linalg.norm(u)
    r = radius * np.minimum(np.sqrt(rng.uniform(0, 1.5, count)), 1.0)
    turn = rng.uniform(0, 2 * np.pi, count)
    side = np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * np.cross(back, u)
    return p + rng.uniform(low, high, count)[:, None] * back + r[:, None] * side


def tubes(seam: Seam) -> dict[TorchPart, tuple[float, float, float]]:
    start, torch = start_mm(seam), USUAL_TORCH
    mouth = max(start, torch.wire_mm)
    return {
        TorchPart.TIP: (start, start, 0.0),
        TorchPart.WIRE: (start, mouth, 0.3),
        TorchPart.NOZZLE: (mouth, torch.length_mm, torch.nozzle_radius_mm - 1e-3),
    }


def compare(
    solids: Solids, material: Any, seams: list[Seam], slack_mm: float, wider: float
) -> Iterator[tuple[str, bool]]:
    """Yield, per pose, what the check says of it and whether the classifier agrees."""
    rng = np.random.default_rng(5)
    for seam in seams:
        p, back = seam.frames.p, seam.frames.R[:, :, 2]
        found = find_poses_in_material(material, p, back, start_mm=start_mm(seam))
        own = tubes(seam)
        for row in sorted(set(range(0, len(p), max(1, len(p) // 3))) - set(found.row.tolist())):
            q = [in_tube(rng, p[row], back[row], *tube, POINTS) for tube in own.values()]
            every = np.concatenate(q)
            asked = (s for n in range(len(solids.names)) for s in solids.states(n, every, slack_mm))
            yield "passes", TopAbs_IN not in asked
        for row, name, part in list(zip(found.row.tolist(), found.solid, found.part, strict=True))[:1]:
            low, high, radius = own[part]
            q = in_tube(rng, p[row], back[row], low, high, wider * radius, CLOSE)
            yield "refused", any(s != TopAbs_OUT for s in solids.states(solids.names.index(name), q, slack_mm))


@pytest.mark.parametrize("name", few([*PARTS, *MORE], 2))
def test_a_classifier_agrees_with_the_check_of_poses(name: str, request: pytest.FixtureRequest) -> None:
    kind, _, part = name.partition(":")
    if kind == "fixture":
        step = FIXTURES / part / f"{part}.step"
    else:
        step = request.getfixturevalue("shared_step").parent / name
    workpiece = open_workpiece(step)
    seams, found = find_seams(workpiece, SeamOptions())
    accepted = [seam for seam in seams if seam.accepted]
    mesh = tessellate((s.name, s.shape, s.color_rgb) for s in workpiece.source.step.solids)
    low, high = found.trimmed.face_box
    of = found.graph.face_solid
    names = found.graph.solid_names
    boxes = np.array([[low[of == n].min(axis=0), high[of == n].max(axis=0)] for n in range(len(names))])
    solids = Solids(names, workpiece.solids, boxes)
    for material, slack_mm, wider in (
        (TriangleMaterial.of(mesh), mesh.deflection_mm, 1.0),
        (ExactMaterial(found.graph, found.trimmed), 1e-3, OUTERMOST),
    ):
        verdicts = list(compare(solids, material, accepted, slack_mm, wider))
        assert all(agrees for what, agrees in verdicts if what == "passes"), type(material).__name__
        assert all(agrees for what, agrees in verdicts if what == "refused"), type(material).__name__
