"""A seam for scripts of build123d: its frames as locations and planes, its curve as a wire.

The wire holds the edges of the part themselves (lines, circles, ellipses, NURBS curves), cut to the seam, and not a
polyline through the frames.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wpcal.brep import BrepGraph
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam
from wpcal.seam.seam import SeamFrames

if TYPE_CHECKING:
    from build123d import Location, Plane, Wire


def seam_locations(frames: SeamFrames | Seam) -> list[Location]:
    """Return the frames of a seam as locations of build123d.

    `frames`: n frames, mm; for example a seam or ``seam.frames`` in `part`, or ``seam.frames.moved(T_base_part)`` in
    `base`.
    Raises `InputError` when it is neither.
    Returns list of build123d.Location, length n. x along the seam, z out of the joint, in the frame of `frames`.
    """
    from build123d import Location

    from cad.kernel.geometry import to_location

    frames = _frames_of(frames)
    poses = (RigidTransform(R, p, target=frames.frame, source="seam") for p, R in zip(frames.p, frames.R, strict=True))
    return [Location(to_location(pose)) for pose in poses]


def seam_planes(frames: SeamFrames | Seam) -> list[Plane]:
    """Return the frames of a seam as planes of build123d: ``x_dir`` along the seam, ``z_dir`` out of the joint.

    `frames`: n frames, mm, as for `seam_locations`.
    Returns list of build123d.Plane, length n. In the frame of `frames`.
    """
    from build123d import Plane

    frames = _frames_of(frames)
    rows = zip(frames.p.tolist(), frames.R[:, :, 0].tolist(), frames.R[:, :, 2].tolist(), strict=True)
    return [Plane(origin=p, x_dir=x, z_dir=z) for p, x, z in rows]


def _frames_of(given: SeamFrames | Seam) -> SeamFrames:
    """Return the frames of a seam, or frames as they are."""
    if isinstance(given, Seam):
        return given.frames
    if not isinstance(given, SeamFrames):
        raise InputError(f"expected a seam or its frames, got {type(given).__name__}; seams are in found.seams")
    return given


def seam_wire(graph: BrepGraph, seam: Seam, T_base_part: RigidTransform | None = None) -> Wire:
    """Return the curve of a seam as a wire of build123d, in the direction of travel.

    Raises `InputError` when the seam has no pieces: it was read from a file.
    Raises `KernelError` when the kernel fails.

    `graph`: The graph in which the seam was found: ``found.workpiece.graph`` after `calibrate_workpiece`, the graph of
    the second result of `find_seams`, or that given to `detect_seams`.

    Returns: One edge per piece of the seam, mm. Where two pieces end up to 0.01 mm apart, they share a vertex of that
    size. The edges are those of the model: if bodies moved, the seam is where its frames are.
    """
    from build123d import Location, Wire

    from cad.kernel.from_brep import make_wire
    from cad.kernel.geometry import to_location

    pieces = seam.pieces
    if len(pieces) == 0:
        raise InputError(f"seam {seam.name} has no curve: it was read from a file; find it on the part")
    wire = Wire(make_wire(graph, pieces.edge, pieces.t0, pieces.t1, closed=seam.closed, what=f"seam {seam.name}"))
    return wire if T_base_part is None else wire.moved(Location(to_location(T_base_part)))
