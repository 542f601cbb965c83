"""Which touches locate a part: reads the part and finds its seams; `wpcal.touch.plan` makes the plan."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cad.workpiece.advise_bodies import tacked_bodies
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.step_file import draw_part
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.names import seams_named
from wpcal.taught.touched_face import touched_face
from wpcal.touch.plan.options import TouchOptions
from wpcal.touch.plan.part import TouchPart
from wpcal.touch.plan.plan_touches import plan_touches as plan_touches_of
from wpcal.touch.plan.reach import ArmReach
from wpcal.touch.searches import SearchKind, TouchPlan

USUAL, USUAL_SEAMS = TouchOptions(), SeamOptions()


def plan_touches(
    step: Openable,
    *,
    options: TouchOptions = USUAL,
    seam_options: SeamOptions = USUAL_SEAMS,
    choice: SeamChoice | None = None,
    seams: Sequence[str] = (),
    T_base_part: RigidTransform | None = None,
    cell: Cell | None = None,
    bodies: BodiesOptions | None = None,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> TouchPlan:
    """Plan the touches that locate a part for its seams.

    Raises `InputError` when the part cannot be read, or has no seam of a given name.
    Raises `GeometryError` when the part has no seam, or no plan holds it: what would help.

    `bodies`: The bodies that may move: touches are chosen for `wpcal calibrate --bodies`. Without it, the part moves as
    one.
    """
    asked = TouchesWanted(options, seam_options, choice, tuple(seams), T_base_part, cell, bodies)
    return draw_touches(step, asked=asked, cache=cache, progress=progress).plan


@dataclass(frozen=True, slots=True, eq=False)
class TouchesWanted:
    """What `plan_touches` plans for."""

    options: TouchOptions
    seam_options: SeamOptions
    choice: SeamChoice | None
    seams: tuple[str, ...]  #: Names; empty: the accepted ones.
    T_base_part: RigidTransform | None
    cell: Cell | None
    bodies: BodiesOptions | None


@dataclass(frozen=True, slots=True, eq=False)
class DrawnTouches:
    """A plan of touches, and what its page draws."""

    plan: TouchPlan
    part_glb: bytes | None  #: The triangles of the part.
    #: By name: points along each seam where the error counts, in `part`, mm, shape (n, 3).
    seams: dict[str, FloatArray]
    #: By the name of a search on the part: how far its contact is from the border of the face.
    border_mm: dict[str, float | None]


def draw_touches(
    step: Openable, *, asked: TouchesWanted, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress
) -> DrawnTouches:
    """Plan touches as `plan_touches` does, and return what their page draws, too."""
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    progress(f"finding seams: {workpiece.size}")
    # the touches are on the part as read: curves that the search for seams adds are no borders of faces
    found, with_curves = find_seams(workpiece, asked.seam_options, asked.choice)
    counted = _counted_seams(found, asked.seams)
    part_glb = _triangles(workpiece, progress)
    material = None if part_glb is None else TriangleMaterial.of(read_part_glb(part_glb))
    part = TouchPart(
        Path(step).name if isinstance(step, str | Path) else "part",
        workpiece.graph,
        workpiece.trimmed,
        counted,
        workpiece.features,
        material,
        None if asked.bodies is None else tacked_bodies(with_curves, counted, asked.bodies, asked.seam_options),
    )
    options, T_base_part, reach = asked.options, asked.T_base_part, None
    if asked.cell is not None:
        reach = ArmReach.of(asked.cell, T_base_part, material)
        options, T_base_part = replace(options, up_base=reach.up_base), reach.T_base_part
    plan = plan_touches_of(part, options=options, T_base_part=T_base_part, reach=reach, progress=progress)
    border_mm = {
        search.name: touched_face(workpiece.trimmed, search.contact_part, search.normal_part).border_mm
        for search in plan.searches
        if search.kind is SearchKind.PART
    }
    return DrawnTouches(plan, part_glb, {seam.name: seam.frames.p for seam in counted}, border_mm)


def _counted_seams(found: Sequence[Seam], names: Sequence[str]) -> list[Seam]:
    if names:
        by_name = {seam.name: seam for seam in found}
        return [by_name[name] for name in seams_named(names, list(by_name))]
    accepted = [seam for seam in found if seam.accepted]
    if found and not accepted:
        raise GeometryError(f"none of the {len(found)} seams is accepted; name those where the error counts (--only)")
    return accepted


def _triangles(workpiece: Workpiece, progress: Progress) -> bytes | None:
    """Return ``part.glb`` of a STEP file; None for shapes from a script, whose exact faces are compared."""
    if workpiece.source is None:
        return None
    progress(f"drawing the part: {workpiece.size}")
    return draw_part(workpiece.source)[0]
