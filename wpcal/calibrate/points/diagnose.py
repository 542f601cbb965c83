"""Find what is wrong with point pairs: a wrong unit, swapped names, a mirrored set, a mis-taught point.

Every finding rests on a stated test. If no test can separate the cases, the finding says so and says what would
decide.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.criteria import BLUNDER
from wpcal.calibrate.outlier_limits import CLEAR_FACTOR, FALSE_ALARM, FLOOR_MM
from wpcal.calibrate.points.least_squares import centred, distances, kabsch
from wpcal.calibrate.points.robust import fit_robust
from wpcal.calibrate.points.weighted import refine_once
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import UnitError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs

UNIT_FACTORS = {1000.0: "metres", 25.4: "inches"}
"""Units that occur in practice besides the millimetre, in mm."""

UNIT_TOLERANCE = 0.03
"""The factor of the sizes must lie this close to that of a unit: closer than any teaching error on a part of 100 mm."""

COPLANAR_RATIO = 0.02
"""Third to second spread below which points count as lying in one plane: 2 mm of relief on 100 mm."""

MOST_SWAP_POINTS = 40
"""Swaps are tried among this many points with the largest residuals: 780 swaps."""


def require_plausible_units(pairs: PointPairs) -> None:
    """Refuse pairs whose two sides are in different units.

    Raises
    ------
    UnitError
        When the distances among the taught points are 1000 or 25.4 times those of the model, or the inverse.
    """
    p, q = centred(pairs.p_source), centred(pairs.p_target)
    factor = float(np.sqrt(np.sum(q**2) / np.sum(p**2)))
    for size, unit in UNIT_FACTORS.items():
        for ratio, side in ((size, "model"), (1.0 / size, "taught")):
            if abs(factor / ratio - 1.0) <= UNIT_TOLERANCE:
                raise UnitError(
                    f"the distances between the taught points are {factor:.6g} times those of the model: the {side} "
                    f"coordinates look like {unit}, expected mm"
                )


def find_issues(pairs: PointPairs, *, sigma_mm: float | None = None, seed: int = 0) -> tuple[Issue, ...]:
    """Name swaps, a mirrored set and mis-taught points, and what the data cannot show.

    Parameters
    ----------
    pairs : PointPairs
        At least three that are not collinear, mm. If they carry covariances, a mis-taught point is searched for with
        these, and swaps and mirrors with the largest standard deviation among them.
    sigma_mm : float, optional
        Teaching error per axis of pairs without covariances, where known.
    seed : int
        Of the random triples of the robust fit.

    Returns
    -------
    tuple of Issue
        Codes ``swapped-names``, ``mirrored``, ``blunder``, ``poor-fit``, ``three-points``, ``four-coplanar``,
        ``coplanar-mirror``.
    """
    total = _sum_of_squares(pairs.p_source, pairs.p_target)
    most = sigma_mm
    if pairs.covariances is not None:
        most = float(np.sqrt(np.linalg.eigvalsh(pairs.covariances)[:, 2].max()))
    explained = _swap(pairs, total, most) or _mirror(pairs, total, most) or _blunders(pairs, total, sigma_mm, seed)
    return (*explained, *_limits(pairs))


def is_coplanar(points: FloatArray) -> bool:
    """Tell whether points, shape (n, 3), mm, lie so near one plane that a mirrored set fits as well."""
    spread = np.sqrt(np.maximum(np.linalg.eigvalsh(centred(points).T @ centred(points)), 0.0))
    return bool(spread[0] <= COPLANAR_RATIO * spread[1])


def _sum_of_squares(p: FloatArray, q: FloatArray) -> float:
    R, t = kabsch(p, q, np.full(len(p), 1.0 / len(p)))
    return float(np.sum(distances(p, q, R, t) ** 2))


def _is_explained(total: float, rest: float, *, freedom: int, tests: int, sigma_mm: float | None) -> bool:
    """Tell whether the data contradict themselves as they are and fit under another reading.

    With a stated error both are χ² tests. Otherwise the ratio of the two sums is compared with F.
    """
    level = FALSE_ALARM / tests
    if sigma_mm is not None:
        limit = max(float(chdtri(freedom, level)) * sigma_mm**2, FLOOR_MM**2)
        return total > limit >= rest
    ratio = float(fdtri(freedom, freedom, 1.0 - level))
    return total > max(ratio * rest, FLOOR_MM**2)


def _swap(pairs: PointPairs, total: float, sigma_mm: float | None) -> tuple[Issue, ...]:
    R, t = kabsch(pairs.p_source, pairs.p_target, np.full(len(pairs), 1.0 / len(pairs)))
    d = distances(pairs.p_source, pairs.p_target, R, t)
    suspects = np.sort(np.argsort(-d, kind="stable")[:MOST_SWAP_POINTS])
    swaps = np.array(list(combinations(suspects, 2)))
    sums = _sums_with_swaps(pairs, swaps)
    order = np.argsort(sums, kind="stable")
    best = float(sums[order[0]])
    freedom = 3 * len(pairs) - 6
    if not _is_explained(total, best, freedom=freedom, tests=len(swaps), sigma_mm=sigma_mm):
        return ()
    rivals = order[sums[order] <= max(CLEAR_FACTOR * best, FLOOR_MM**2)]
    names = [tuple(pairs.names[i] for i in swaps[k]) for k in rivals]
    left = float(np.sqrt(best / len(pairs)))
    if len(names) == 1:
        a, b = names[0]
        message = f"the names {a} and {b} look swapped: with them exchanged the fit leaves an RMS of {left:.3g} mm"
    else:
        listed = " or ".join(f"{a} and {b}" for a, b in names[:4])
        message = (
            f"two names look swapped, and the points are too symmetric to tell which: {listed}; teach one more "
            "point off the lines of symmetry"
        )
    return (Issue("swapped-names", message, tuple(dict.fromkeys(name for pair in names for name in pair))),)


def _sums_with_swaps(pairs: PointPairs, swaps: IntArray) -> FloatArray:
    """Sum of squares of the least-squares fit with each of the swaps, from the change of 3×3 moments alone."""
    p, q = centred(pairs.p_source), centred(pairs.p_target)
    a, b = swaps.T
    # Σ q pᵀ changes by (q_b - q_a)(p_a - p_b)ᵀ
    B = q.T @ p + (q[b] - q[a])[:, :, None] * (p[a] - p[b])[:, None, :]
    values = np.linalg.svd(B, compute_uv=False)
    values[:, 2] *= np.sign(np.linalg.det(B))
    return np.asarray(np.maximum(np.sum(p**2) + np.sum(q**2) - 2.0 * values.sum(axis=1), 0.0))


def _mirror(pairs: PointPairs, total: float, sigma_mm: float | None) -> tuple[Issue, ...]:
    if is_coplanar(pairs.p_source):
        return ()
    rest = _sum_of_squares(-pairs.p_source, pairs.p_target)  # a reflection is a point reflection and a rotation
    if not _is_explained(total, rest, freedom=3 * len(pairs) - 6, tests=1, sigma_mm=sigma_mm):
        return ()
    left = float(np.sqrt(rest / len(pairs)))
    message = (
        f"the taught points are the mirror image of the model (mirrored they fit with an RMS of {left:.3g} mm): the "
        "other hand of the part, an axis with the wrong sign, or a left-handed frame"
    )
    return (Issue("mirrored", message),)


def _blunders(pairs: PointPairs, total: float, sigma_mm: float | None, seed: int) -> tuple[Issue, ...]:
    robust = fit_robust(pairs, sigma_mm=sigma_mm, seed=seed)
    wrong = np.flatnonzero(~robust.inlier)
    if len(wrong):
        listed = ", ".join(f"{pairs.names[i]} ({robust.deviation_mm[i]:.3g} mm off their fit)" for i in wrong[:6])
        more = f" and {len(wrong) - 6} more" if len(wrong) > 6 else ""
        message = f"the other points contradict {listed}{more}: teach again"
        return (Issue(BLUNDER, message, tuple(pairs.names[i] for i in wrong)),)
    return _poor_fit(pairs, total, sigma_mm)


def _poor_fit(pairs: PointPairs, total: float, sigma_mm: float | None) -> tuple[Issue, ...]:
    """Say that the stated errors do not explain the residuals, by a χ² test of their sum of squares."""
    limit = float(chdtri(3 * len(pairs) - 6, FALSE_ALARM))
    rms = float(np.sqrt(total / len(pairs)))
    if pairs.covariances is not None:
        information = np.asarray(np.linalg.inv(pairs.covariances))
        R, t = kabsch(pairs.p_source, pairs.p_target, np.full(len(pairs), 1.0 / len(pairs)))
        total = float(refine_once(pairs.p_source, pairs.p_target, information, R, t)[2])
        stated = "than the stated teaching errors of the points explain"
    elif sigma_mm:
        total /= sigma_mm**2
        stated = f"than the stated teaching error of {sigma_mm:.3g} mm per axis explains"
    else:
        return ()
    if total <= limit or rms <= FLOOR_MM:
        return ()
    message = (
        f"the residuals (RMS {rms:.3g} mm) are larger {stated}, and no single point can be named: one is mis-taught, "
        "the part differs from its model, or the stated error is too small; teach one more point"
    )
    return (Issue("poor-fit", message),)


def _limits(pairs: PointPairs) -> tuple[Issue, ...]:
    """What these points cannot show, whatever the numbers."""
    if len(pairs) == 3:
        message = (
            "three points: only their three mutual distances are checked. A point taught wrong normal to their plane "
            "leaves no residual, and which point is wrong cannot be known; a fourth point would tell"
        )
        return (Issue("three-points", message, pairs.names),)
    if not is_coplanar(pairs.p_source):
        return ()
    found = [
        Issue(
            "coplanar-mirror",
            "the points lie in one plane: a mirrored set would fit as a rotated one; a point off the plane would tell",
        )
    ]
    if len(pairs) == 4:
        message = (
            "four points in one plane: one that is off the plane spreads its error over all four (2 mm at a corner of "
            "a rectangle leave 0.5 mm at every corner), and which one cannot be known; a fifth point would tell"
        )
        found.insert(0, Issue("four-coplanar", message, pairs.names))
    return tuple(found)
