"""For scripts: which touches of a weldment to make, from arrays of places on plane faces, without a CAD part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.of_bodies import MeetingPoints
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.core.arrays import as_points
from wpcal.core.errors import InputError
from wpcal.touch.advise.moved_advice import MovedAdvice, TouchChoices, advise_moved
from wpcal.touch.advise.moved_model import SeamPoints, Tacked


def advise_touches(
    p_part: ArrayLike,
    normal_part: ArrayLike,
    body: Sequence[str],
    seam_p: ArrayLike,
    seam_normals: tuple[ArrayLike, ArrayLike],
    seam_bodies: tuple[Sequence[str], Sequence[str]],
    *,
    count: int | None = None,
    tolerance_mm: float | None = None,
    sigma_mm: float = 0.3,
    tack_mm: float = 1.0,
    tack_mrad: float = 3.0,
) -> MovedAdvice:
    """Choose touches on plane faces that lower the largest error of the seams of a weldment most.

    Parameters
    ----------
    p_part, normal_part : shape (n, 3). Places that may be touched, and outward normals there; `part`, mm.
    body : length n. The body of each place. A body turns about the middle of its places.
    seam_p : shape (k, 3). Points of seams, in `part`, mm.
    seam_normals : shape (k, 3) each. Outward normals of the two faces that meet there: of the wall, of the base.
    seam_bodies : length k. The bodies of these faces.

    Returns
    -------
    MovedAdvice. The index of a touch is its row in `p_part`; seams are named by their bodies: ``web on plate``.

    Raises
    ------
    InputError, GeometryError
        When lengths differ, a body of a seam has no place, or as in `wpcal.touch.advise.moved_advice.advise_moved`.
    """
    p, n, at = (as_points(each, name="points") for each in (p_part, normal_part, seam_p))
    wall_normal, base_normal = (as_points(each, name="normals") for each in seam_normals)
    lengths = (len(wall_normal), len(base_normal), *(len(each) for each in seam_bodies))
    if not len(p) == len(n) == len(body) or any(each != len(at) for each in lengths):
        raise InputError("the places, or the points of the seams, have normals or bodies of another number")
    names = tuple(dict.fromkeys(body))
    unknown = [name for each in seam_bodies for name in each if name not in names]
    if unknown:
        raise InputError(f"body {unknown[0]!r} of a seam has no place that may be touched")
    own, wall, base = (np.array([names.index(name) for name in each], dtype=np.int64) for each in (body, *seam_bodies))
    boxes = [p[own == b] for b in range(len(names))]
    middle = np.stack([(each.min(axis=0) + each.max(axis=0)) / 2.0 for each in boxes])
    bodies = Bodies(names, middle, (TackTolerance(tack_mm, tack_mrad),) * len(names))
    x = np.cross(wall_normal, base_normal)
    length = np.linalg.norm(x, axis=1)
    points = MeetingPoints(at, wall, base, wall_normal, base_normal, x / np.maximum(length, 1e-12)[:, None], length > 0)
    seams = SeamPoints(points, tuple(f"{a} on {b}" for a, b in zip(*seam_bodies, strict=True)))
    tacked = Tacked(bodies, np.zeros(0, dtype=np.int64), seams)
    model = tacked.model()
    unit = n / np.linalg.norm(n, axis=1, keepdims=True)
    rows = model.rows(p, unit[:, None, :] / sigma_mm, own)
    words = tuple(f"({' '.join(f'{v:g}' for v in place)}) on {name}" for place, name in zip(p, body, strict=True))
    choices = TouchChoices(tuple(f"P{k + 1}" for k in range(len(p))), words, own, rows)
    return advise_moved(model, choices, seams, count=count, tolerance_mm=tolerance_mm)
