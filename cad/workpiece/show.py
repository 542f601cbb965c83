"""Seams, frames and taught points in the viewer of `ocp_vscode`, with the colours of the pages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from cad.draw.page_colours import AXES, PART, RESIDUAL, UNKNOWN, colour_of
from cad.workpiece.calibrate import WorkpieceCalibration
from cad.workpiece.to_build123d import seam_wire
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.seam import Seam
from wpcal.seam.seam import SeamFrames

if TYPE_CHECKING:
    from wpcal.core.transform import RigidTransform

AXIS_MM = 8.0  #: Length of the axes of a frame.
ARROW_SCALE = 20.0  #: Residuals are drawn this many times as long: they are tenths of a millimetre.
LEAST_ARROW_MM = 1e-6  #: The kernel makes no shorter line.


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """One object of the viewer."""

    name: str
    shape: Any
    color: str  #: ``#rrggbb``.
    alpha: float = 1.0


def show(found: WorkpieceCalibration | Openable, seams: Sequence[Seam] = (), *, port: int | None = None) -> None:
    """Show a part with its seams, their frames and the taught points in the viewer of `ocp_vscode`.

    Raises `InputError` when `ocp_vscode` is not installed (``pip install wpcal[viewer]``), or no viewer is open.

    `found`: A calibrated part is shown in `base`, with seams in the colour of their 95 % error. What
    `open_workpiece` takes is shown in `part`, with `seams`.
    """
    try:
        import ocp_vscode
    except ImportError as error:
        raise InputError(f"cad.show needs ocp_vscode ({error}); pip install wpcal[viewer]") from None
    if port is None:
        ocp_vscode.find_and_set_port()
        if ocp_vscode.get_port() is None:
            raise InputError("cad.show found no open viewer: open the OCP CAD Viewer in VS Code, or give its port")
    drawn = drawn_of(found, seams)
    ocp_vscode.show(
        *(each.shape for each in drawn),
        names=[each.name for each in drawn],
        colors=[each.color for each in drawn],
        alphas=[each.alpha for each in drawn],
        reset_camera=ocp_vscode.Camera.RESET,
        **({} if port is None else {"port": port}),
    )


def drawn_of(found: WorkpieceCalibration | Openable, seams: Sequence[Seam] = ()) -> list[Drawn]:
    """Return what `show` draws; parameters as there."""
    if not isinstance(found, WorkpieceCalibration):
        found = open_workpiece(found)
        shapes = found.shapes or found.file.step.build123d_shapes()
        colours = [colour_of(0.0) if seam.accepted else UNKNOWN for seam in seams]
        return [*_parts(shapes), *_seams(found, seams, None, colours), *_axes([seam.frames for seam in seams])]
    T, tolerance_mm = found.T_base_part, found.result.tolerance_mm
    colours = [
        colour_of(float(u95.max()) / tolerance_mm) if seam.accepted and len(u95) else UNKNOWN
        for seam, u95 in zip(found.candidates, found.candidate_u95_mm, strict=True)
    ]
    frames = [seam.frames.moved(T) for seam in found.candidates]
    lines = _polylines(found.candidates, frames, colours)
    if found.moved is None:
        lines = _seams(found.workpiece, found.candidates, T, colours)
    return [*_parts(found.moved_shapes()), *lines, *_axes(frames), *_points(found)]


def _parts(shapes: Sequence[Any]) -> Iterator[Drawn]:
    for number, shape in enumerate(shapes, 1):
        yield Drawn(getattr(shape, "label", "") or f"part {number}", shape, PART, 0.8)


def _seams(
    workpiece: Workpiece, seams: Sequence[Seam], T_base_part: RigidTransform | None, colours: Sequence[str]
) -> Iterator[Drawn]:
    for seam, colour in zip(seams, colours, strict=True):
        yield Drawn(seam.name, seam_wire(workpiece.graph, seam, T_base_part), colour)


def _polylines(seams: Sequence[Seam], frames: Sequence[SeamFrames], colours: Sequence[str]) -> Iterator[Drawn]:
    """Draw seams where moved faces meet: they are on no edge of the model."""
    from build123d import Wire

    for seam, each, colour in zip(seams, frames, colours, strict=True):
        yield Drawn(seam.name, Wire.make_polygon([tuple(p) for p in each.p.tolist()], close=False), colour)


def _axes(frames: Sequence[SeamFrames]) -> Iterator[Drawn]:
    """Draw the axes of all frames, one object per axis."""
    if not frames:
        return
    p, R = np.concatenate([each.p for each in frames]), np.concatenate([each.R for each in frames])
    for axis, colour in enumerate(AXES):
        yield Drawn(f"frames {'xyz'[axis]}", _lines(p, p + AXIS_MM * R[:, :, axis]), colour)


def _points(found: WorkpieceCalibration) -> Iterator[Drawn]:
    """Draw the taught points and their residuals, `ARROW_SCALE` times as long."""
    from build123d import Compound, Vertex

    points = found.result.to_record()["points"]
    p_base = np.array([point["p_base_mm"] for point in points])
    residuals = np.array([point["residual_mm"] for point in points])
    yield Drawn("taught points", Compound([Vertex(*p) for p in p_base.tolist()]), RESIDUAL)
    seen = np.linalg.norm(residuals, axis=1) * ARROW_SCALE > LEAST_ARROW_MM
    if seen.any():
        name = f"residuals x {ARROW_SCALE:g}"
        yield Drawn(name, _lines(p_base[seen], p_base[seen] + ARROW_SCALE * residuals[seen]), RESIDUAL)


def _lines(begins: FloatArray, ends: FloatArray) -> Any:
    """Return lines as one shape; points of shape (n, 3), mm."""
    from build123d import Compound, Edge

    pairs = zip(begins.tolist(), ends.tolist(), strict=True)
    return Compound([Edge.make_line(tuple(begin), tuple(end)) for begin, end in pairs])
