"""The whole answer for a weldment whose bodies may have moved: tolerances, fit, evidence, and wrong touches."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import Any

import numpy as np
from scipy.special import chdtrc

from wpcal.calibrate.errors.modes import ErrorModes
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.observe.bending import MODES
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.bodies import BodiesFit, begin_bodies, fit_begun
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.calibrate.trust.contact_evidence import ContactEvidence, judge_contacts
from wpcal.calibrate.trust.motion_evidence import SURE, MotionEvidence, estimated_tolerances, judge_motion
from wpcal.calibrate.trust.residuals import FALSE_ALARM
from wpcal.calibrate.trust.scale import ScaleFit, fit_scale
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed

BOW_POINTS = 13  #: Points along a body at which a record tells its bow: three on the shortest wave.
MOST_TOLD = 5  #: Bodies whose motions a sentence names; a table has all.


class ToleranceSource(Enum):
    """How the tack tolerances are known."""

    STATED = "stated"
    ASSUMED = "assumed"
    ESTIMATED = "estimated"


_IN_WORDS = {
    ToleranceSource.STATED: "as stated",
    ToleranceSource.ASSUMED: "assumed: too few touches to estimate them",
    ToleranceSource.ESTIMATED: "estimated from the touches",
}


@dataclass(frozen=True, slots=True, eq=False)
class MovedBodies:
    """A weldment and its bodies, as the touches show them."""

    fit: BodiesFit
    evidence: MotionEvidence
    source: ToleranceSource  #: How the tack tolerances are known.
    touches: IntArray  #: shape (b,). How many touches lie on each body.
    wrong: tuple[str, ...]  #: Touches that contradict the others, wherever their bodies are.
    far: tuple[str, ...] = ()  #: Bodies that are farther away than their tolerances explain.
    doubtful: tuple[str, ...] = ()  #: Touches on them that are wrong unless the tolerances are too small.
    contacts: ContactEvidence | None = None  #: Of kept contacts.
    scale: ScaleFit | None = None  #: How much larger the part is than its model, wherever its bodies are.

    @property
    def untouched(self) -> tuple[str, ...]:
        """Names of bodies that no touch lies on."""
        names = self.fit.motions.bodies.names
        return tuple(name for name, count in zip(names, self.touches.tolist(), strict=True) if count == 0)

    @property
    def moved(self) -> tuple[int, ...]:
        """Bodies that are shown to have moved, those with the strongest evidence first."""
        if not self.evidence.has_moved:
            return ()
        order = np.argsort(self.evidence.p_body, kind="stable")
        return tuple(int(b) for b in order if self.evidence.p_body[b] < SURE)

    def sentence(self) -> str:
        """Say whether plates moved, and which."""
        p = self.evidence.p_rigid
        shown = "p < 0.001" if p < 0.001 else f"p = {p:.2g}"
        if not self.evidence.has_moved:
            return f"the touches fit a rigid part ({shown})"
        if not self.moved:
            return f"bodies moved ({shown}); the touches do not tell which"
        motions = self.fit.motions
        told = [
            f"{motions.bodies.names[b]} by {np.linalg.norm(motions.v_mm[b]):.2f} mm and "
            f"{1e3 * np.linalg.norm(motions.omega[b]):.1f} mrad ({self.evidence.sigmas[b]:.1f} sigma)"
            for b in self.moved[:MOST_TOLD]
        ]
        more = f" and {len(self.moved) - MOST_TOLD} more" if len(self.moved) > MOST_TOLD else ""
        return f"bodies moved ({shown}): {', '.join(told)}{more}"

    def far_sentence(self) -> str:
        """Say which bodies are farther away than their tolerances explain, and what to do."""
        several = len(self.far) > 1
        those = "are farther from their places" if several else "is farther from its place"
        wrong = (
            f", or {listed(self.doubtful)} {'is' if len(self.doubtful) == 1 else 'are'} wrong" if self.doubtful else ""
        )
        return (
            f"{'bodies' if several else 'body'} {listed(self.far)} {those} in the model than the tack "
            f"tolerance explains{wrong}: touch {'these bodies' if several else 'this body'} again; if the new touches "
            "agree, state a larger tolerance"
        )

    def contacts_sentence(self) -> str:
        """Say whether the touches agree with the kept contacts, and which pairs do not stay on each other."""
        kept = self.contacts
        if kept is None:
            return ""
        shown = "p < 0.001" if kept.p < 0.001 else f"p = {kept.p:.2g}"
        if not kept.is_tested:
            return "no touch tests this"
        if not kept.broken:
            return f"the touches agree ({shown})"
        names = self.fit.motions.bodies.names
        told = [
            f"{names[each.first]} and {names[each.second]} ({abs(each.gap_mm):.1f} mm "
            f"{'apart' if each.gap_mm > 0 else 'into each other'})"
            for each in kept.broken[:MOST_TOLD]
        ]
        more = [f"{len(kept.broken) - MOST_TOLD} more"] if len(kept.broken) > MOST_TOLD else []
        return f"the touches contradict these contacts ({shown}): {listed([*told, *more])}"

    def tolerances_sentence(self) -> str:
        """Say which tack tolerances the answer rests on."""
        values = sorted({(t.mm, t.mrad) for t in self.fit.motions.bodies.tolerances})
        told = listed([f"{mm:.3g} mm and {mrad:.3g} mrad" for mm, mrad in values])
        rest = f"; never touched: {listed(list(self.untouched))}" if self.untouched else ""
        bends = self.fit.motions.bodies.bends
        bent = listed([self.fit.motions.bodies.names[b] for b in dict.fromkeys(bends.body.tolist())])
        bending = f"; bending {bends.sigma_mm:.3g} mm per plate of 1 m, of {bent}" if bent else ""
        return f"tack tolerance {told}, {_IN_WORDS[self.source]}{bending}{rest}"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for ``calibration.json``."""
        motions = self.fit.motions
        R, t = motions.moves()
        bent = self._bent()
        spread = np.sqrt(np.maximum(np.diag(self.fit.covariance)[6 : 6 + 6 * len(motions.bodies)].reshape(-1, 6), 0.0))
        return {
            "sentence": self.sentence(),
            "p_rigid": self.evidence.p_rigid,
            "tolerances": self.source.value,
            "tolerances_sentence": self.tolerances_sentence(),
            "motions_seen": self.evidence.seen,
            "wrong_touches": [*self.wrong, *self.doubtful],
            **({"far_bodies": list(self.far)} if self.far else {}),
            **({} if self.contacts is None else {"contacts": self._contacts_record(self.contacts)}),
            "bodies": [
                {
                    "name": name,
                    "touches": int(self.touches[b]),
                    "tack_mm": motions.bodies.tolerances[b].mm,
                    "tack_mrad": motions.bodies.tolerances[b].mrad,
                    "centre_part_mm": motions.bodies.centroid_part[b].tolist(),
                    "moved_mm": motions.v_mm[b].tolist(),
                    "turned_mrad": (1e3 * motions.omega[b]).tolist(),
                    "sigma_mm": spread[b, 3:].tolist(),
                    "sigma_mrad": (1e3 * spread[b, :3]).tolist(),
                    "p_still": float(self.evidence.p_body[b]),
                    "sigmas": max(float(self.evidence.sigmas[b]), 0.0),
                    "has_moved": b in self.moved,
                    "T_part_moved": _matrix(R[b], t[b]),
                    **({"bending": bent[b]} if bent[b] else {}),
                }
                for b, name in enumerate(motions.bodies.names)
            ],
        }

    def _contacts_record(self, kept: ContactEvidence) -> dict[str, Any]:
        names = self.fit.motions.bodies.names
        broken = [
            {
                "bodies": [names[each.first], names[each.second]],
                "gap_mm": each.gap_mm,
                "expected_mm": each.expected_mm,
                "p": each.p,
            }
            for each in kept.broken
        ]
        return {"gain": kept.gain, "p": kept.p, "is_tested": kept.is_tested, "broken": broken}

    def _bent(self) -> list[list[dict[str, Any]]]:
        """Return how each body bent: per direction, the bow along the body and its standard deviation."""
        motions, bends = self.fit.motions, self.fit.motions.bodies.bends
        first = 6 + 6 * len(motions.bodies)
        told: list[list[dict[str, Any]]] = [[] for _ in motions.bodies.names]
        for m, body in enumerate(bends.body.tolist()):
            s = np.linspace(-bends.half_mm[m], bends.half_mm[m], BOW_POINTS)
            w, _ = bends.shapes(m, s)
            own = slice(first + MODES * m, first + MODES * (m + 1))
            spread = np.sqrt(np.maximum(np.einsum("si,ij,sj->s", w, self.fit.covariance[own, own], w), 0.0))
            told[body].append(
                {
                    "axis_part": bends.axis[m].tolist(),
                    "normal_part": bends.normal[m].tolist(),
                    "s_mm": s.tolist(),
                    "bow_mm": (w @ motions.bend_mm[MODES * m : MODES * (m + 1)]).tolist(),
                    "sigma_mm": spread.tolist(),
                }
            )
        return told


def fit_moved_bodies(
    touches: Touches,
    body: IntArray,
    bodies: Bodies,
    start: RigidTransform,
    *,
    sigma_mm: float | None = None,
    estimate: bool = True,
    contacts: KeptContacts | None = None,
    teaching: TeachingError | None = None,
    seed: int = 0,
) -> MovedBodies:
    """Fit a weldment whose bodies may have moved, and judge whether they did.

    `body`: shape (n,). The body that each touch lies on.
    `teaching`: What is stated of the robot and the tool. By default they are without errors, as in a simulation.
    Raises `InputError` or `GeometryError` or `ConvergenceError` as in `begin_bodies` and `fit_begun`.
    """
    begin = partial(begin_bodies, touches, body, start=start, sigma_mm=sigma_mm, contacts=contacts)
    begun, modes, scale = begin(bodies), None, None
    if teaching is not None:
        rigid = begun[0].whitened(begun[1]).without_contacts()
        rows = rigid.select(~np.isin(np.arange(len(rigid.r)), wrong_rows(rigid))).error_rows(touches.p_base)
        modes = ErrorModes.of(touches.p_base, teaching.believe(rows, 1.0), teaching.tool_mm)
        scale = fit_scale(rows, len(touches), 1.0, teaching.robot)
    seen = begun[0].whitened(begun[1], modes).without_contacts()
    evidence = judge_motion(seen, seed=seed)
    estimated = estimated_tolerances(seen, bodies) if estimate else None
    fit = fit_begun(*(begun if estimated is None else begin(estimated)), modes)
    source = ToleranceSource.ASSUMED if estimate else ToleranceSource.STATED
    source = source if estimated is None else ToleranceSource.ESTIMATED
    kept, judged = None, fit.whitened
    if contacts is not None and len(contacts):
        kept, judged = judge_contacts(judged, contacts, wrong_rows(judged.without_contacts()))
    off = wrong_rows(judged)
    far = far_bodies(judged, body, off)
    wrong = [i for i in np.unique(judged.touch[off]).tolist() if i >= 0]
    names, doubtful = ([touches.names[i] for i in wrong if (body[i] in far) is is_far] for is_far in (False, True))
    counts = np.bincount(body[body >= 0], minlength=len(bodies))
    return MovedBodies(
        fit, evidence, source, counts, tuple(names), tuple(bodies.names[b] for b in far), tuple(doubtful), kept, scale
    )


def wrong_rows(touched: Whitened) -> IntArray:
    """Return the rows of the linear model that the other rows contradict, with a false alarm in 1 % of the parts.

    A row that is off by itself leaves a normalised residual; the largest one of m is a false alarm with the probability
    of each times m (Bonferroni). The row is left out, and the others are judged again.
    """
    P = touched.residual_matrix()
    left = np.arange(len(P))
    wrong: list[int] = []
    while len(left) > touched.J.shape[1] + 1:
        spread = np.diag(P)
        square = np.where(spread > 1e-9, (P @ touched.r[left]) ** 2 / np.maximum(spread, 1e-9), 0.0)
        worst = int(np.argmax(square))
        if float(chdtrc(1, square[worst])) * len(left) > FALSE_ALARM:
            break
        wrong.append(int(left[worst]))
        P -= np.outer(P[:, worst], P[worst]) / P[worst, worst]  # the model without this row
        P = np.delete(np.delete(P, worst, axis=0), worst, axis=1)
        left = np.delete(left, worst)
    return np.array(wrong, dtype=np.int64)


def far_bodies(touched: Whitened, body: IntArray, wrong: IntArray) -> tuple[int, ...]:
    r"""Return bodies that are farther away than their tolerances explain, with a false alarm in 1 % of the parts.

    With P as in `Whitened.residual_matrix`, the slope :math:`B_b^\top P r` has the covariance :math:`B_b^\top P B_b` if
    the tolerance is right. Only directions are judged in which the touches see more of the motion than of their own
    errors. A body of which touches stay wrong wherever it is does not count: they may be all that is wrong.

    `body`: shape (n,). The body that each touch lies on.
    """
    count = (touched.B.shape[1] - touched.bends - touched.modes) // 6
    PB = touched.residual_matrix() @ touched.B
    slope = PB.T @ touched.r
    far = []
    for b in range(count):
        own = slice(6 * b, 6 * b + 6)
        values, vectors = np.linalg.eigh(touched.B[:, own].T @ PB[:, own])
        seen = values > 0.5
        square = float(np.sum((vectors.T @ slope[own])[seen] ** 2 / values[seen]))
        if seen.any() and float(chdtrc(int(seen.sum()), square)) * count < FALSE_ALARM:
            far.append(b)
    return tuple(b for b in far if b not in _of_rows(touched, body, wrong) or _explains(touched, body, b))


def _explains(touched: Whitened, body: IntArray, b: int) -> bool:
    """Whether no touch on a body is wrong any more if this body may be anywhere."""
    freed = touched.with_free(b)
    return b not in _of_rows(freed, body, wrong_rows(freed))


def _of_rows(touched: Whitened, body: IntArray, rows: IntArray) -> set[int]:
    """Return the bodies that the touches of some rows of the linear model lie on."""
    touch = touched.touch[rows]
    return set(body[touch[touch >= 0]].tolist())


def _matrix(R: FloatArray, t: FloatArray) -> list[list[float]]:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = R, t
    return [list(row) for row in matrix.tolist()]
