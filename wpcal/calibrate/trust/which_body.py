"""Which body is elsewhere? Wrong observations that share a body are first explained as a motion of that body.

One observation that the others contradict is mis-taught. Several of them on one body are more likely right: the body
was tacked elsewhere, or the part is of another revision than the model. That is so if all observations on the other
bodies agree, and if leaving out no other body makes the rest agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from wpcal.calibrate.trust.blame import Diagnosis
from wpcal.calibrate.trust.criteria import BLUNDER, NOT_NAMED, FitProblem
from wpcal.core.issue import Issue

LEAST_ON_BODY = 2  #: Observations on a body: a single one is as likely mis-taught.


def explain_by_body(problem: FitProblem, found: Diagnosis, body_of: Mapping[str, str]) -> Diagnosis:
    """Return the findings with the body that explains the wrong observations, if exactly one does.

    `body_of`: The body of the part that each observation lies on, by its name.
    """
    suspect = found.suspect
    if suspect is None or suspect.exchanges or len(suspect.names) == 1 or suspect.at_least < LEAST_ON_BODY:
        return found
    body = np.array([body_of.get(name, "") for name in problem.names])
    explaining = []
    for name in dict.fromkeys(body.tolist()):
        own = [problem.names[row] for row in np.flatnonzero(body == name)]
        is_apart = name and len(own) >= LEAST_ON_BODY and set(suspect.names) <= set(own)
        if is_apart and problem.agrees(np.flatnonzero(body != name)):
            explaining.append((name, tuple(own)))
    if len(explaining) != 1:
        return found
    name, on_it = explaining[0]
    told = replace(suspect, body=name, names=on_it, off_mm=problem.off_mm(on_it), probability=None, rivals=())
    issue = Issue(BLUNDER, told.sentence, on_it)
    kept = [each for each in found.issues if each.code not in (BLUNDER, NOT_NAMED)]
    return replace(found, issues=(issue, *kept), suspect=told)
