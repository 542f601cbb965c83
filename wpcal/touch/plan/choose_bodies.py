"""The choice of searches for a weldment whose bodies may move, and of as many as a tolerance needs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.calibrate.errors.prediction import COVERAGE, joint_errors
from wpcal.calibrate.observe.bodies import Bodies
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian
from wpcal.core.wording import counted
from wpcal.touch.advise.moved_advice import MovedAdvice, TouchChoices, advise_moved
from wpcal.touch.advise.moved_model import MovedModel, Tacked
from wpcal.touch.advise.moved_search import MovedSearch
from wpcal.touch.plan.choose import TouchDesign, best_set
from wpcal.touch.plan.contacts import face_words
from wpcal.touch.plan.free import Strokes
from wpcal.touch.plan.options import MOST_TOUCHES, Pattern, TouchOptions


def advise_searches(
    graph: BrepGraph, strokes: Strokes, design: TouchDesign, tacked: Tacked, options: TouchOptions
) -> MovedAdvice:
    """Choose searches for a weldment whose bodies may move. The index of a touch is its row in `strokes`.

    Raises
    ------
    InputError : When a pattern is asked for.
    GeometryError : As in `advise_moved`.
    """
    if options.pattern is not Pattern.BEST:
        raise InputError(f"the pattern {options.pattern} is for a part that is one body: leave it or --bodies away")
    contacts, sigma = strokes.contacts, np.sqrt(design.variances)
    model = tacked.model(design.shared.shape[1])
    body = tacked.face_body[contacts.face]
    ways, common = contacts.normal / sigma[:, None], design.shared / sigma[:, None]
    rows = model.rows(contacts.p, ways[:, None, :], body, common[:, None, :])
    words = [face_words(graph, contacts.select(np.array([k])), int(face)) for k, face in enumerate(contacts.face)]
    choices = TouchChoices(tuple(f"S{k + 1}" for k in range(len(strokes))), tuple(words), body, rows)
    return advise_moved(
        model,
        choices,
        tacked.seams,
        count=options.count(len(tacked.bodies)),
        tolerance_mm=options.tolerance_mm,
        most=MOST_TOUCHES,
        usual=options.usual(len(tacked.bodies)),
    )


def fewest_set(
    design: TouchDesign, seam_points: FloatArray, options: TouchOptions, rng: np.random.Generator
) -> tuple[IntArray, str]:
    """Return few searches after which a part that is one body keeps all its seams within the tolerance.

    Parameters
    ----------
    seam_points : shape (k, 3). All of them, relative to the centre of the design, mm.

    Returns
    -------
    rows : ndarray of int, shape (n,)
    why : str. Why the tolerance is not reached; otherwise empty.
    """
    tolerance_mm, least = options.tolerance_mm or np.inf, min(options.count(), len(design))
    best, _ = best_set(design, least, slots=None, rng=rng)
    error = joint_error_of(design, best, seam_points)
    if error <= tolerance_mm or len(best) == 0:
        return best, ""
    search, start = _as_one_body(design)
    order = [int(row) for row in best]
    most = min(MOST_TOUCHES, len(design))
    while error > tolerance_mm and len(order) < most and (row := search.added(start, order)) is not None:
        order.append(row)
        error = joint_error_of(design, np.array(order), seam_points)
    if error > tolerance_mm:
        return best, _why_not(design, best, order, seam_points, tolerance_mm)
    chosen = np.array(order)
    for count in range(least + 1, len(order)):  # the exchange may need fewer than the single steps
        fewer = np.array(search.exchanged(start, order[:count]))
        if joint_error_of(design, fewer, seam_points) <= tolerance_mm:
            chosen = fewer
            break
    return chosen, ""


def joint_error_of(design: TouchDesign, rows: IntArray, seam_points: FloatArray) -> float:
    """Return what no seam point exceeds, with 95 % probability, mm.

    Parameters
    ----------
    rows : shape (n,). The touches.
    seam_points : shape (k, 3). About the centre of the design, mm.
    """
    covariances, free = design.covariances(rows[None])
    return float("inf") if free[0] else float(np.quantile(joint_errors(seam_points, covariances[0]), COVERAGE))


def _as_one_body(design: TouchDesign) -> tuple[MovedSearch, FloatArray]:
    """Return the search over the touches of a part that is one body, and the information before them."""
    count = design.shared.shape[1]
    model = MovedModel(Bodies((), np.zeros((0, 3)), ()), np.zeros(3), design.length_mm, count)
    scale = np.repeat([design.length_mm, 1.0], 3)
    rows = np.concatenate([design.rows / scale, design.shared], axis=1) / np.sqrt(design.variances)[:, None]
    J = point_jacobian(design.seam_points) / scale
    seams = np.concatenate([J, np.zeros((len(J), 3, count))], axis=2)
    return MovedSearch(rows[:, None, :], seams), model.prior()


def _why_not(
    design: TouchDesign, best: IntArray, order: list[int], seam_points: FloatArray, tolerance_mm: float
) -> str:
    few, many = (joint_error_of(design, np.array(rows), seam_points) for rows in (best, order))
    head = (
        f"{tolerance_mm:g} mm is not reached: {counted(len(best), 'touch')} leave {few:.2f} mm, {len(order)} leave "
        f"{many:.2f} mm"
    )
    exact = replace(design, variances=np.zeros(len(design)))
    common = joint_error_of(exact, np.array(order), seam_points)
    if common > tolerance_mm:
        return (
            f"{head}, of which {common:.2f} mm come from an error that all touches share: a touch on a --post, or a "
            "smaller stick_out_sigma_mm in the --setup, would help"
        )
    return f"{head}; a better repeatability of the touches would help"
