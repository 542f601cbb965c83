"""Which body is elsewhere? Wrong observations that share a body are first explained as a motion of that body.

One observation that the others contradict is mis-taught. Several of them on one body are more likely right: the body
was tacked elsewhere, or the part is of another revision than the model. That is so if all observations on the other
bodies agree, and if leaving out no other body makes the rest agree. Many observations on one body hide each other, so
that none stands out by itself: bodies are then tested as a whole.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from wpcal.calibrate.errors.robot_field import ResidualRows
from wpcal.calibrate.trust.blame import Diagnosis, Suspect
from wpcal.calibrate.trust.criteria import BLUNDER, NOT_NAMED, FitProblem
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.core.issue import Issue

OTHER_READINGS = {"swapped-names", "mirrored"}  #: Issues that explain all observations at once.
LEAST_ON_BODY = 2  #: Observations on a body: a single one is as likely mis-taught.


def explain_by_body(
    problem: FitProblem, found: Diagnosis, body_of: Mapping[str, str], rows: ResidualRows | None
) -> Diagnosis:
    """Return the findings with the body that explains the wrong observations, if one does.

    `body_of`: The body of the part that each observation lies on, by its name.
    `rows`: Residuals of the observations. If they are not of all, single ones alone show that something is wrong.
    """
    suspect = found.suspect or Suspect((), (), None, LEAST_ON_BODY, (), word=problem.word)
    is_single = len(suspect.names) == 1 or suspect.at_least < LEAST_ON_BODY
    if is_single or suspect.exchanges or found.tool or OTHER_READINGS & {issue.code for issue in found.issues}:
        return found
    body = np.array([body_of.get(name, "") for name in problem.names])
    apart = [name for name in dict.fromkeys(body[body != ""].tolist()) if _is_apart(problem, body, name, found, rows)]
    on_each = sorted(((int(np.sum(body == name)), name) for name in apart), key=lambda each: each[0])
    if not apart or len({count for count, _ in on_each[:2]}) < len(on_each[:2]):
        return found
    name = on_each[0][1]  # of two bodies beside each other, that with fewer touches moved
    on_it = tuple(np.array(problem.names)[body == name].tolist())
    told = replace(suspect, body=name, names=on_it, off_mm=problem.off_mm(on_it), probability=None, rivals=())
    issue = Issue(BLUNDER, told.sentence, on_it)
    kept = [each for each in found.issues if each.code not in (BLUNDER, NOT_NAMED)]
    return replace(found, issues=(issue, *kept), suspect=told)


def _is_apart(
    problem: FitProblem, body: NDArray[np.str_], name: str, found: Diagnosis, rows: ResidualRows | None
) -> bool:
    """Tell whether all that is wrong lies on a body, and the rest agrees."""
    own, names = body == name, np.array(problem.names)
    if found.suspect is None:
        is_wrong = _stands_out(problem, body, name, rows)
    else:
        is_wrong = set(found.suspect.names) <= set(names[own].tolist())
    return is_wrong and int(np.sum(own)) >= LEAST_ON_BODY and problem.agrees(np.flatnonzero(~own))


def _stands_out(problem: FitProblem, body: NDArray[np.str_], name: str, rows: ResidualRows | None) -> bool:
    """Tell whether a body is off by more than the others scatter and the robot is usually off (F test)."""
    if rows is None or len(rows.places) != len(body):
        return False
    K = np.flatnonzero(body[rows.owner] == name)
    left, Q = len(rows.y) - len(K), rows.rest[K]
    if left < 1:
        return False
    drop = float(rows.y @ Q.T @ np.linalg.lstsq(Q @ Q.T, Q @ rows.y, rcond=None)[0])
    unit = (float(rows.y @ rows.y) - drop) / left + problem.teaching.robot_residual_mm(rows.places) ** 2 * rows.unit2
    return float(fdtrc(len(K), left, drop / len(K) / unit)) * len(set(body)) < FALSE_ALARM
