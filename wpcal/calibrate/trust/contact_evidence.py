r"""Whether bodies stayed on each other: what the touches say of kept contacts.

A contact is an assumption: a gap of zero. Let P be the matrix of `Whitened.residual_matrix` of touches and contacts,
:math:`r` their residuals, and C some contacts. Without them, the other rows predict the gaps :math:`-P_{CC}^{-1}
(P r)_C`, in units of their sigma, and the sum of squares is smaller by

.. math:: D = (P r)_C^\top\, P_{CC}^{-1}\, (P r)_C,

twice the logarithm of the likelihood without over that with these contacts. If they hold, D is :math:`\chi^2` with as
many degrees of freedom as there are contacts of C that do not follow from each other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.special import chdtrc

from wpcal.calibrate.observe.bodies import KeptContacts
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.core.arrays import FloatArray, IntArray

LEAST_TESTED = 1e-9  #: Directions of contacts in which nothing else says anything leave no residual but round-off.


@dataclass(frozen=True, slots=True)
class BrokenContact:
    """Two bodies that do not stay on each other."""

    #: `first`, `second`: The bodies.
    first: int
    second: int
    #: How far apart the touches have them, where they are farthest from contact; negative: one is in the other.
    gap_mm: float
    expected_mm: float  #: Standard deviation of the gap that was allowed.
    p: float  #: Probability of such touches if the two stay on each other.


@dataclass(frozen=True, slots=True, eq=False)
class ContactEvidence:
    """What the touches say of all kept contacts."""

    gain: float  #: Twice the logarithm of the likelihood without over that with contacts.
    p: float  #: Probability of such a gain if all of them hold.
    is_tested: bool  #: Whether the touches see any of the gaps better than the tack tolerances tell them.
    broken: tuple[BrokenContact, ...]  #: Those that do not hold, the worst first.


def judge_contacts(touched: Whitened, contacts: KeptContacts, wrong: IntArray) -> tuple[ContactEvidence, Whitened]:
    """Judge whether kept contacts hold, with a false alarm in 1 % of the parts.

    The pair of bodies whose contacts contradict most is left out, and the others are judged again.

    `wrong`: shape (w,). Rows of touches that are wrong also without contacts; they are left out.

    Returns: The linear model from which touches are judged: without contacts if some of them do not hold.
    """
    is_contact = touched.touch < 0
    rows = np.flatnonzero(is_contact)
    ends = np.sort(np.stack([contacts.first, contacts.second]), axis=0)
    pairs, pair = np.unique(ends, axis=1, return_inverse=True)
    left = np.ones(len(touched.r), dtype=bool)
    left[wrong] = False
    all_of_them = np.flatnonzero(is_contact[left])
    gain, freedom, _ = _gain(touched.select(left), all_of_them)
    is_tested = _are_tested(touched.select(left), all_of_them)
    broken: list[BrokenContact] = []
    kept = set(range(pairs.shape[1]))
    while kept:
        judged, numbers = touched.select(left), np.cumsum(left) - 1
        found = {k: _gain(judged, numbers[rows[pair == k]]) for k in kept}
        p = {k: float(chdtrc(free, square)) if free else 1.0 for k, (square, free, _) in found.items()}
        worst = min(kept, key=lambda k: (p[k], -found[k][0]))
        if p[worst] * len(kept) > FALSE_ALARM:
            break
        own = np.flatnonzero(pair == worst)
        off = found[worst][2] * contacts.sigma_mm[own]
        most = int(np.argmax(np.abs(off)))
        i, j = int(contacts.first[own[most]]), int(contacts.second[own[most]])
        broken.append(BrokenContact(i, j, float(off[most]), float(contacts.sigma_mm[own[most]]), p[worst]))
        left[rows[own]] = False
        kept.remove(worst)
    p_all = float(chdtrc(freedom, gain)) if freedom else 1.0
    found_all = ContactEvidence(gain, p_all, is_tested, tuple(broken))
    return found_all, touched.without_contacts() if broken else touched


def _are_tested(touched: Whitened, rows: IntArray) -> bool:
    """Whether some gap is known from the touches with half the variance that the tack tolerances give it, or less."""
    P = touched.residual_matrix()[np.ix_(rows, rows)]
    prior = np.eye(len(rows)) + touched.B[rows] @ touched.B[rows].T
    return float(eigh(prior, np.linalg.pinv(P, rcond=LEAST_TESTED, hermitian=True), eigvals_only=True)[-1]) > 2.0


def _gain(touched: Whitened, rows: IntArray) -> tuple[float, int, FloatArray]:
    """Return D of some rows, its degrees of freedom, and the gaps that the other rows predict, in sigmas."""
    P = touched.residual_matrix()
    slope = (P @ touched.r)[rows]
    values, vectors = np.linalg.eigh(P[np.ix_(rows, rows)])
    tested = values > LEAST_TESTED
    along = np.where(tested, (vectors.T @ slope) / np.where(tested, values, 1.0), 0.0)
    return float(np.sum(along**2 * np.where(tested, values, 0.0))), int(tested.sum()), vectors @ along
