"""The welds of a calibrated part: thickness and position are measured, then rules and the user's values are applied."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.errors import InputError
from wpcal.core.result_files import PART_FILE, SEAMS_FILE
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.seam.path.position import UP, usual_position
from wpcal.seam.seam import JointType, Seam, WeldType
from wpcal.weld.groove import Groove, measure_groove
from wpcal.weld.place import SeamPlace, StatedWeld, pair, place_of
from wpcal.weld.rules import RuleTable
from wpcal.weld.seam_weld import SeamWeld, Source, weld_for
from wpcal.weld.thickness import plate_thicknesses, thinner
from wpcal.weld.values import WeldKind

LEAST_GAP_MM = 0.05  #: A gap of less is none: contacts of exact solids have round-off.


@dataclass(frozen=True, slots=True)
class FoundWelds:
    """The welds of seams."""

    welds: tuple[SeamWeld, ...]  #: In the order of the seams.
    notes: tuple[str, ...]  #: What is not obvious, one line each.
    left: tuple[StatedWeld, ...]  #: Welds with values of the user whose seam is not there.
    #: Welds with values of the user whose seam is there, but not among the chosen ones.
    not_chosen: tuple[StatedWeld, ...] = ()

    def by_seam(self) -> dict[str, SeamWeld]:
        """Return the welds by the names of their seams."""
        return {weld.name: weld for weld in self.welds}


def find_welds(
    seams: Sequence[Seam],
    T_base_part: RigidTransform,
    rules: RuleTable,
    *,
    part_glb: bytes | None = None,
    stated: Sequence[StatedWeld] = (),
    names: Collection[str] | None = None,
    stated_in: str = "",
    positions: Mapping[str, tuple[str, str]] | None = None,
) -> FoundWelds:
    """Find the weld of every seam.

    `positions`: By the name of the seam: its weld position and the file that says so, where a robot turns the part.
    Without it the position is that of the seam in `base`.
    Raises `InputError` if a weld that was written by hand names a seam that is not there, or values contradict each
    other.
    """
    places = dict(seam_places(seams, T_base_part))
    _refuse_unknown(stated, places, stated_in)
    paired = pair(stated, [*places.items()])
    left = tuple(one for one in paired.left if one.is_telling)
    notes = [*paired.notes, *(f"{one.name} has no seam now; its values are kept under without_seam" for one in left)]
    wanted = places if names is None else names
    chosen = [seam for seam in seams if seam.name in wanted]
    not_chosen = [paired.welds[name] for name in places if name in paired.welds and name not in wanted]
    mesh = None if part_glb is None else read_part_glb(part_glb)
    material = None if mesh is None else TriangleMaterial.of(mesh, T_base_part)
    welds = []
    for seam in chosen:
        try:
            groove, laid = None, seam
            if mesh is not None and seam.joint is JointType.BUTT:
                groove = measure_groove(seam, mesh, T_base_part)
                laid = seam if groove is None else _in_groove(seam, groove)
            measured = _measured(laid, material)
            if positions and seam.name in positions:
                measured["position"] = positions[seam.name]
            own = paired.welds.get(seam.name, StatedWeld(seam.name, None, {}))
            welds.append(_weld(laid, places[seam.name], rules, measured, own, groove))
        except InputError as error:
            raise InputError(f"{stated_in}: {error}" if stated_in else str(error), code=error.code) from None
    return FoundWelds(tuple(welds), (*notes, *_of_welds(welds)), left, tuple(one for one in not_chosen if one.user))


def _refuse_unknown(stated: Sequence[StatedWeld], known: Collection[str], stated_in: str) -> None:
    """Refuse a weld that was written by hand and names no seam."""
    unknown = [one.name for one in stated if one.place is None and one.name not in known]
    if unknown:
        near = f"; there are {listed(sorted(known))}" if known else "; the result has no seams"
        raise InputError(f"{stated_in}: unknown seam {listed(unknown)}{near}")


def _of_welds(welds: Sequence[SeamWeld]) -> list[str]:
    """Return what is not obvious about welds, one line for all welds that it concerns."""
    unsized = [w.name for w in welds if w.weld is WeldType.FILLET and w.values.leg_mm is w.values.throat_mm is None]
    at_root = [w.name for w in welds if w.values.weld is WeldKind.SQUARE and w.origins["weld"].source is Source.MODEL]
    size = "thickness and size are not known; state thickness_mm, or leg_mm or throat_mm"
    root = "runs along the root of a groove; lay it or leave it out (--only), as the drawing says"
    return [f"{listed(names)}: {what}" for names, what in ((unsized, size), (at_root, root)) if names]


def seam_places(seams: Sequence[Seam], T_base_part: RigidTransform) -> list[tuple[str, SeamPlace]]:
    """Return the name and the place in `part` of every seam, whose frames are in `base`."""
    return [(seam.name, place_of(seam, T_base_part.inverse())) for seam in seams]


def _in_groove(seam: Seam, groove: Groove) -> Seam:
    """Return a seam with the frames of the groove: it runs along one edge at the root, or beside the groove."""
    R = seam.frames.R @ Rotation.from_euler("x", groove.tilt_rad).as_matrix()
    return replace(seam, frames=replace(seam.frames, R=R))


def _weld(
    seam: Seam,
    place: SeamPlace,
    rules: RuleTable,
    measured: Mapping[str, tuple[Any, str]],
    stated: StatedWeld,
    groove: Groove | None,
) -> SeamWeld:
    lower_side = 1 if float(np.mean(seam.frames.R[:, :, 1] @ np.array(UP))) < 0.0 else -1
    of_model = {} if groove is None else groove.values()  # exact, where the gap of a seam is to the nearest face
    own = {name: value for name, value in measured.items() if name not in of_model}
    stated = replace(stated, files={**own, **stated.files})
    return weld_for(seam, place, stated, rules, first_side=lower_side, groove=groove)


def _measured(seam: Seam, material: TriangleMaterial | None) -> dict[str, tuple[Any, str]]:
    """Return what the result folder says: thickness of the thinner plate, position, gap."""
    found: dict[str, tuple[Any, str]] = {}
    thickness = None if material is None else thinner(plate_thicknesses(seam.frames, material))
    if thickness:
        found["thickness_mm"] = (thickness, PART_FILE)
    position = usual_position(seam.frames.R, seam.weld)
    if position != "-":
        found["position"] = (position, SEAMS_FILE)
    gap = seam.gap_mm[1]
    if gap >= LEAST_GAP_MM:
        found["root_gap_mm"] = (round(gap, 2), SEAMS_FILE)
    return found
