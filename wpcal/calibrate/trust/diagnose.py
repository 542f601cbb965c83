"""Find what is wrong with point pairs: a wrong unit, swapped names, a mirrored set, a mis-taught point.

Every finding rests on a stated test. If no test can separate the cases, the finding says so and says what would
decide.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from types import MappingProxyType

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.errors.prediction import TeachingError, postures_of
from wpcal.calibrate.solve.error_rows import ErrorRows
from wpcal.calibrate.solve.least_squares import centred, distances, fit_least_squares, kabsch
from wpcal.calibrate.trust.blame import Diagnosis, Exchange, Suspect
from wpcal.calibrate.trust.criteria import BLUNDER, NEIGHBOUR, NOT_NAMED
from wpcal.calibrate.trust.left_out import Contradiction
from wpcal.calibrate.trust.neighbours import FeaturePlaces, Neighbour, find_neighbours
from wpcal.calibrate.trust.residuals import CLEAR_FACTOR, FALSE_ALARM, FLOOR_MM
from wpcal.calibrate.trust.robust import MOST_COMPARED, contradicted_points
from wpcal.calibrate.trust.tool_offset import LEAST_ROWS, TOOL_OFFSET, PosedRows, ToolOffset, find_tool_offset
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import UnitError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.tangent import point_jacobian
from wpcal.core.wording import short

UNIT_FACTORS = {1000.0: "metres", 25.4: "inches"}  #: Units that occur in practice besides the millimetre, in mm.
UNIT_TOLERANCE = 0.03
"""The factor of the sizes must lie this close to that of a unit: closer than any teaching error on a part of 100 mm."""
COPLANAR_RATIO = 0.02
"""Third to second spread below which points count as lying in one plane: 2 mm of relief on 100 mm."""
NO_POSTURES: Mapping[str, FloatArray] = MappingProxyType({})
UNSTATED = TeachingError()
MOST_SWAP_POINTS = 40  #: Swaps are tried among this many points with the largest residuals: 780 swaps.


def require_plausible_units(pairs: PointPairs) -> None:
    """Refuse pairs whose two sides are in different units.

    Raises `UnitError` when the distances among the taught points are 1000 or 25.4 times those of the model, or the
    inverse.
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


def diagnose_pairs(
    pairs: PointPairs,
    *,
    check: PointPairs | None = None,
    places: FeaturePlaces | None = None,
    postures: Mapping[str, FloatArray] = NO_POSTURES,
    teaching: TeachingError = UNSTATED,
    seed: int = 0,
) -> Diagnosis:
    """Name swaps, a mirrored set, mis-taught points, wrong features and a wrong tool, and what the data cannot show.

    `pairs`: At least three that are not collinear, mm. If they carry covariances, a mis-taught point is searched for
    with these, and swaps and mirrors with the largest standard deviation among them.
    `postures`: shape (3, 3), optional. The axes of the tool in the base by the name of the point: they show an error of
    the tool centre point.
    `teaching`: What is known of the errors of points without covariances, and of the tool.

    Returns: Codes ``swapped-names``, ``mirrored``, ``tool-centre-point``, ``neighbour-feature``, ``blunder``,
    ``blunder-not-named``, ``three-points``, ``four-coplanar``, ``coplanar-mirror``.
    """
    seen, sigma_mm = pairs if check is None else join_pairs(pairs, check), tested_error(pairs, teaching, postures)
    total = _sum_of_squares(seen.p_source, seen.p_target)
    most = sigma_mm
    if seen.covariances is not None:
        most = float(np.sqrt(np.linalg.eigvalsh(seen.covariances)[:, 2].max()))
    explained, suspect, tool = _swap(seen, total, most) or _mirror(seen, total, most), None, None
    if not explained:
        found = contradicted_points(seen, sigma_mm=sigma_mm, seed=seed)
        tool = _tool_offset(seen, postures, found, sigma_mm, teaching.tool_covariance)
    if tool is not None:
        explained = (Issue(TOOL_OFFSET, tool.sentence),)
    elif not explained:
        suspect = _suspect(seen, found, places, sigma_mm)
        explained = () if suspect is None else _suspect_issues(suspect)
    return Diagnosis((*explained, *_limits(pairs)), suspect, tool)


def tested_error(pairs: PointPairs, teaching: TeachingError, postures: Mapping[str, FloatArray]) -> float | None:
    """Return the error per axis against which a wrong point must stand out, if it is stated, mm.

    `postures`: shape (3, 3). The axes of the tool in the base, by the names of the points that say them.
    """
    known = postures_of(pairs.names, postures)
    return teaching.tested_sigma_mm(pairs.p_source if known is None else pairs.p_target, known)


def join_pairs(pairs: PointPairs, check: PointPairs) -> PointPairs:
    """Put fitted and check points together; only the fitted ones where the errors of one group alone are stated."""
    if (pairs.covariances is None) != (check.covariances is None) or set(pairs.names) & set(check.names):
        return pairs
    covariances = None
    if pairs.covariances is not None and check.covariances is not None:
        covariances = np.concatenate([pairs.covariances, check.covariances])
    return PointPairs(
        (*pairs.names, *check.names),
        np.concatenate([pairs.p_source, check.p_source]),
        np.concatenate([pairs.p_target, check.p_target]),
        covariances,
        pairs.source,
        pairs.target,
        pairs.space,
    )


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
        message = f"the names {a} and {b} look swapped: with them exchanged the fit leaves an RMS of {short(left)} mm"
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
        f"the taught points are the mirror image of the model (mirrored they fit with an RMS of {short(left)} mm): the "
        "other hand of the part, an axis with the wrong sign, or a left-handed frame"
    )
    return (Issue("mirrored", message),)


def _suspect(
    pairs: PointPairs, found: Contradiction, places: FeaturePlaces | None, sigma_mm: float | None
) -> Suspect | None:
    named = found.named
    exchanges: tuple[Exchange, ...] = ()
    if places is not None and len(pairs) <= MOST_COMPARED:
        exchanges = tuple(
            _exchange(pairs, places, one) for one in find_neighbours(pairs, places, named=named, sigma_mm=sigma_mm)
        )
        if exchanges and exchanges[0].name not in {pairs.names[i] for i in named}:
            named = ()
    if not found.at_least and not exchanges:
        return None
    off: FloatArray = np.zeros(len(pairs))
    if named:
        T = fit_least_squares(pairs.select(np.setdiff1d(np.arange(len(pairs)), named)))
        off = Residuals.of(pairs, T).norms_mm
    return Suspect(
        tuple(pairs.names[i] for i in named),
        tuple(float(off[i]) for i in named),
        found.probabilities[0] if named else None,
        max(found.at_least, 1),
        found.rivals(pairs.names, named),
        exchanges,
    )


def _exchange(pairs: PointPairs, places: FeaturePlaces, one: Neighbour) -> Exchange:
    p = pairs.p_source.copy()
    p[one.row] = places.p[one.place]
    moved = replace(pairs, p_source=p)
    largest = Residuals.of(moved, fit_least_squares(moved)).largest_mm
    now = places.at(pairs.p_source[one.row])
    return Exchange(
        pairs.names[one.row], _alike(places.names[one.place], now), _alike(now, pairs.names[one.row]), largest
    )


def _alike(names: str, other: str) -> str:
    """Of features at one place, take the one whose kind (its first letter) is that of another feature."""
    found = names.split()
    alike = [name for name in found if other in {name, ""} or name[0] == other[0]]
    return (alike or found or [""])[0]


def _suspect_issues(suspect: Suspect) -> tuple[Issue, ...]:
    issues = [Issue(NEIGHBOUR, exchange.sentence, (exchange.name, exchange.feature)) for exchange in suspect.exchanges]
    if suspect.names:
        message = f"{replace(suspect, exchanges=()).sentence}: teach again"
        issues.append(Issue(BLUNDER, message, suspect.names))
    elif not issues:
        ids = tuple(dict.fromkeys(name for names, _ in suspect.rivals for name in names))
        issues.append(Issue(NOT_NAMED, f"{suspect.sentence}; teach one more point", ids))
    return tuple(issues)


def _tool_offset(
    pairs: PointPairs,
    postures: Mapping[str, FloatArray],
    found: Contradiction,
    sigma_mm: float | None,
    stated: FloatArray,
) -> ToolOffset | None:
    """Test the tool centre point on the points whose posture is known, against the points that look wrong."""
    at = [i for i, name in enumerate(pairs.names) if name in postures]
    if len(at) < LEAST_ROWS:
        return None
    posed = pairs.select(at)
    rows = ErrorRows.of(posed, sigma_mm)
    R, t = rows.fit()
    moved = rows.p @ R.T + t
    J = point_jacobian(moved - moved.mean(axis=0))
    J[:, :, :3] /= max(float(np.abs(moved - moved.mean(axis=0)).max()), 1.0)
    frames = np.array([postures[name] for name in posed.names])
    given = PosedRows(rows.q - moved, J, frames, rows.information, 3 * len(at), rows.scaled, stated)
    wrong = [at.index(i) for i in found.sets[0] if i in at] if found.sets else []
    worst = np.argsort(-np.linalg.norm(given.residuals, axis=1), kind="stable")[:MOST_COMPARED]
    tried = [wrong] if wrong else [[int(i)] for i in worst]
    rests = [rows.select(np.delete(np.arange(len(at)), out)).sum_of_squares() for out in tried]
    return find_tool_offset(given, rival_squares=min(rests), rival_count=len(tried[0]))


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
