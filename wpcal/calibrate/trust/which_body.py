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
from scipy.special import fdtrc

from wpcal.calibrate.trust.blame import Diagnosis, Suspect
from wpcal.calibrate.trust.criteria import BLUNDER, NOT_NAMED, Criterion, FitProblem
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.core.arrays import IntArray
from wpcal.core.issue import Issue

OTHER_READINGS = ("swapped-names", "mirrored")  #: Issues that explain all observations at once.
LEAST_ON_BODY = 2  #: Observations on a body: a single one is as likely mis-taught.


def explain_by_body(problem: FitProblem, found: Diagnosis, body_of: Mapping[str, str]) -> Diagnosis:
    """Return the findings with the body that explains the wrong observations, if one does.

    `body_of`: The body of the part that each observation lies on, by its name.
    """
    suspect = found.suspect or Suspect((), (), None, LEAST_ON_BODY, (), word=problem.word)
    is_else = suspect.exchanges or len(suspect.names) == 1 or suspect.at_least < LEAST_ON_BODY
    if is_else or found.tool is not None or any(issue.code in OTHER_READINGS for issue in found.issues):
        return found
    body = np.array([body_of.get(name, "") for name in problem.names])
    explaining = []
    for name in dict.fromkeys(body.tolist()):
        own = [problem.names[row] for row in np.flatnonzero(body == name)]
        rest = np.flatnonzero(body != name)
        is_apart = name and len(own) >= LEAST_ON_BODY and set(suspect.names) <= set(own) and problem.agrees(rest)
        if is_apart and (found.suspect is not None or _stands_out(problem, rest, len(set(body)))):
            explaining.append((name, tuple(own)))
    explaining.sort(key=lambda each: len(each[1]))  # of two bodies beside each other, that on fewer touches moved
    if not explaining or len({len(on_it) for _, on_it in explaining[:2]}) < len(explaining[:2]):
        return found
    name, on_it = explaining[0]
    told = replace(suspect, body=name, names=on_it, off_mm=problem.off_mm(on_it), probability=None, rivals=())
    issue = Issue(BLUNDER, told.sentence, on_it)
    kept = [each for each in found.issues if each.code not in (BLUNDER, NOT_NAMED)]
    return replace(found, issues=(issue, *kept), suspect=told)


def _stands_out(problem: FitProblem, rest: IntArray, bodies: int) -> bool:
    """Tell whether a body is off by more than the others scatter and the robot is usually off (F test)."""
    whole, others = problem.fit(Criterion.LEAST_SQUARES), problem.select(rest)
    all_of_them, left = problem.judge_residuals(whole), others.judge_residuals(others.fit(Criterion.LEAST_SQUARES))
    numbers = all_of_them.degrees_of_freedom - left.degrees_of_freedom
    unit = left.squares_mm2 / left.degrees_of_freedom + problem.teaching.robot_residual_mm(whole.budget.places) ** 2
    ratio = (all_of_them.squares_mm2 - left.squares_mm2) / numbers / unit
    return float(fdtrc(numbers, left.degrees_of_freedom, ratio)) * bodies < FALSE_ALARM
