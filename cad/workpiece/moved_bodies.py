"""A calibrated workpiece whose plates moved: the fit of its bodies, and its seams where moved faces meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from cad.workpiece.bodies import BodiesOptions, BodiesSource, PartBodies, find_bodies
from cad.workpiece.fit_taught import CalibrateOptions, Observed
from cad.workpiece.touched_bodies import bodies_touched, on_two_bodies
from cad.workpiece.workpiece import Workpiece
from wpcal.brep.graph import BrepGraph
from wpcal.calibrate.errors.of_bodies import MeetingErrors, MeetingPoints, gap_errors_mm, meeting_errors
from wpcal.calibrate.errors.prediction import Sigma
from wpcal.calibrate.moved import MovedBodies, fit_moved_bodies
from wpcal.calibrate.observe.bodies import KeptContacts
from wpcal.calibrate.observe.contacts import find_kept_contacts
from wpcal.calibrate.observe.targets import points_as_touches
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.solver_report import SolverReport
from wpcal.calibrate.trust.bodies import BodiesEvidence
from wpcal.calibrate.trust.criteria import RIVAL, SILENT, TWO_BODIES, Criterion
from wpcal.calibrate.trust.verdict import judge_evidence
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.wording import counted, listed
from wpcal.seam.path.moved import MovedSeam, moved_seams
from wpcal.seam.seam import Seam
from wpcal.taught.table import TaughtPoints

STILL_TRUE = (RIVAL, SILENT, TWO_BODIES)
"""Codes of issues of the part as one body that hold for its bodies, too: another place of the whole is not excluded."""
USUAL_CONTACT_SHARE = 0.5
"""Of the gap up to which members count as in contact: 95 % of the tacked plates are then within this gap."""
OVERLAP_MM = 0.05  #: A smaller overlap of two plates is a burr or round-off, and is not told.


@dataclass(frozen=True, slots=True, eq=False)
class MovedWorkpiece:
    """What the bodies' motions change."""

    bodies: MovedBodies
    part: PartBodies
    result: CalibrationResult  #: With the pose, the residuals and the verdict of this fit.
    seams: tuple[MovedSeam, ...]  #: Where moved faces meet, in `part`.
    errors: tuple[MeetingErrors, ...]  #: At the frames of each seam.
    #: Members count as in contact up to this gap (`SeamOptions.gap_for`); a wider one is told per seam.
    gap_limit_mm: float
    contacts: KeptContacts | None = None  #: Where bodies were kept on each other.
    contact_sigma_mm: float = 0.0  #: How far they may come apart: standard deviation.
    source: BodiesSource | None = None  #: The file that names the bodies.

    @property
    def u95_mm(self) -> tuple[FloatArray, ...]:
        """The 95 % error at every frame of each seam, mm."""
        return tuple(error.total_mm for error in self.errors)

    def told_seams(self) -> tuple[Seam, ...]:
        """Return the moved seams, with what the motions did to each among their reasons."""
        return tuple(replace(moved.seam, reasons=(*moved.seam.reasons, self._told(moved))) for moved in self.seams)

    def solid_motions(self, graph: BrepGraph) -> tuple[FloatArray | None, tuple[Issue, ...]]:
        """Return where every solid moved within `part`, and which solids cannot be drawn apart.

        Returns ndarray, shape (solids, 4, 4), or None. mm; None if no solid moves as one.
        """
        R, t = self.bodies.fit.motions.moves()
        motions = np.tile(np.eye(4), (len(R) + 1, 1, 1))  # the last one: of solids that belong to no body
        motions[:-1, :3, :3], motions[:-1, :3, 3] = R, t
        of_solid = np.full(len(graph.solid_names), -1)
        of_solid[graph.face_solid] = self.part.face_body
        is_cut = np.zeros(len(of_solid), dtype=bool)
        is_cut[graph.face_solid[of_solid[graph.face_solid] != self.part.face_body]] = True
        of_solid[is_cut] = -1
        cut = [graph.solid_names[i] for i in np.flatnonzero(is_cut).tolist()]
        issues = [
            Issue(
                "solid-of-several-bodies",
                f"{listed(cut)}: members of one solid cannot be drawn apart; the moved STEP file has it as one, "
                "the seams are those of the moved members",
                tuple(cut),
            )
        ]
        return None if is_cut.all() else motions[of_solid], tuple(issues if cut else ())

    def columns(self) -> dict[str, list[FloatArray]]:
        """Return what ``seams.json`` says of each frame: two parts of the error, and the gap, mm."""
        return {
            "u95_across_mm": [error.across_mm for error in self.errors],
            "u95_placing_mm": [error.placing_mm for error in self.errors],
            "u95_unseen_mm": [error.unseen_mm for error in self.errors],
            "gap_mm": [moved.gap_mm for moved in self.seams],
        }

    def bodies_of_seam(self, moved: MovedSeam) -> list[str]:
        """Return the names of the bodies between which a seam lies."""
        names = self.bodies.fit.motions.bodies.names
        return [names[b] for b in dict.fromkeys([*moved.base_body.tolist(), *moved.wall_body.tolist()]) if b >= 0]

    def contact_notes(self) -> tuple[Issue, ...]:
        """Return how many contacts were kept, or that there is none."""
        if self.contacts is None:
            return ()
        if not len(self.contacts):
            return (Issue("no-contacts", "--contacts: no plane faces of two bodies lie on each other in the model"),)
        first, second = self.contacts.first.tolist(), self.contacts.second.tolist()
        pairs = {frozenset(pair) for pair in zip(first, second, strict=True)}
        what = f"{counted(len(pairs), 'pair')} of bodies {'is' if len(pairs) == 1 else 'are'} kept on each other"
        told = f"{what}, within {self.contact_sigma_mm:.2g} mm (standard deviation)"
        return (Issue("contacts-kept", f"{told}; {self.bodies.contacts_sentence()}"),)

    def gap_notes(self) -> tuple[Issue, ...]:
        """Return which accepted seams are wider than usual, and which overlap by more than errors explain."""
        accepted = [seam for seam in self.seams if seam.seam.accepted]
        wide = [seam for seam in accepted if seam.gap_mm.max() > self.gap_limit_mm]
        found = []
        if wide:
            worst = max(wide, key=lambda seam: float(seam.gap_mm.max()))
            message = (
                f"the gap of {listed([seam.seam.name for seam in wide])} is wider than {self.gap_limit_mm:g} mm "
                f"(--gap-mm); the widest is {worst.gap_mm.max():.2f} mm at {worst.seam.name}"
            )
            found.append(Issue("gap-too-wide", message, tuple(seam.seam.name for seam in wide)))
        into = [seam for seam in accepted if (seam.gap_mm + self._gap_errors(seam)).min() < -OVERLAP_MM]
        if into:
            worst = min(into, key=lambda seam: float(seam.gap_mm.min()))
            message = (
                f"the bodies of {listed([seam.seam.name for seam in into])} overlap by more than the errors explain, "
                f"by {-worst.gap_mm.min():.2f} mm at {worst.seam.name}: a plate is bent, shorter than its model, or a "
                "touch is wrong"
            )
            found.append(Issue("bodies-overlap", message, tuple(seam.seam.name for seam in into)))
        return tuple(found)

    def _gap_errors(self, moved: MovedSeam) -> FloatArray:
        return gap_errors_mm(self.bodies.fit, meeting_points(moved))

    def _told(self, moved: MovedSeam) -> str:
        least, most = float(moved.gap_mm.min()), float(moved.gap_mm.max())
        told = [f"gap {least:.2f} to {most:.2f} mm after its bodies moved"]
        if most > self.gap_limit_mm:
            told.append(f"wider than {self.gap_limit_mm:g} mm")
        if least < -OVERLAP_MM:
            told.append("a negative gap is an overlap")
        never = [name for name in self.bodies_of_seam(moved) if name in self.bodies.untouched]
        if never:
            verb = "was" if len(never) == 1 else "were"
            told.append(f"{listed(never)} {verb} never touched: the place rests on the tack tolerance")
        return "; ".join(told)


def fit_weldment(
    workpiece: Workpiece,
    observed: Observed,
    rigid: CalibrationResult,
    seams: Sequence[Seam],
    options: CalibrateOptions,
    choice: BodiesOptions,
) -> MovedWorkpiece:
    """Fit the bodies of a part that was calibrated as one.

    `rigid`: The fit of the part as one body.
    `seams`: With frames in `part`.
    Raises `InputError` or `GeometryError` or `ConvergenceError` as in `find_bodies` and `fit_moved_bodies`.
    """
    part = find_bodies(workpiece.trimmed, choice)
    touches = _touches(workpiece, observed.fitted)
    checks = _touches(workpiece, observed.check)
    assert touches is not None  # of the rows that were fitted as one part
    solid_of = _solids_of_rows(observed.taught, workpiece)
    body = bodies_touched(touches, part.face_body, solid_of)
    shared = on_two_bodies(touches, part, solid_of)
    # a motion of bodies may pass for a wrong tool in the rigid fit: only a stated error of the tool counts here
    stated = replace(rigid.teaching, tcp_bias_mm=max(options.teaching.tcp_bias_mm, observed.taught.tcp_bias_mm))
    rigid = replace(rigid, issues=(*rigid.issues, *shared), teaching=stated, tool=None)
    usual = Sigma.expected(options.teaching.per_axis_mm)  # residuals of the part as one body hold its motions, too
    sigma = usual if touches.covariances is None else rigid.sigma
    gap_limit_mm = options.seams.gap_for(workpiece.graph)
    contacts, sigma_mm = None, choice.contact_sigma_mm or gap_limit_mm * USUAL_CONTACT_SHARE
    if choice.keeps_contacts:
        contacts = find_kept_contacts(workpiece.trimmed, part.face_body, gap_mm=gap_limit_mm, sigma_mm=sigma_mm)
    found = fit_moved_bodies(
        touches,
        body,
        part.bodies,
        rigid.T_base_part,
        sigma_mm=options.teaching.per_axis_mm or sigma.mm,  # a smaller one than the digits show is for exact touches
        estimate=not choice.is_stated,
        contacts=contacts,
        teaching=stated,
        seed=options.seed,
    )
    motions = found.fit.motions
    moved = tuple(moved_seams(workpiece.graph, seams, part.face_body, motions))
    errors = _errors_of_each(found, moved)
    observed_on = [
        (each, bodies_touched(each, part.face_body, solid_of)) for each in (touches, checks) if each is not None
    ]
    result = _judged(rigid, found, moved, sigma, observed_on)
    return MovedWorkpiece(found, part, result, moved, errors, gap_limit_mm, contacts, sigma_mm, choice.source)


def _errors_of_each(found: MovedBodies, moved: Sequence[MovedSeam]) -> tuple[MeetingErrors, ...]:
    """Return the errors at the frames of each seam, found for all seams at once."""
    if not moved:
        return ()
    every = meeting_errors(found.fit, MeetingPoints.joined([meeting_points(seam) for seam in moved]))
    ends = np.cumsum([len(seam.seam.frames) for seam in moved])[:-1]
    columns = (np.split(getattr(every, field.name), ends) for field in fields(every))
    return tuple(MeetingErrors(*each) for each in zip(*columns, strict=True))


def _touches(workpiece: Workpiece, of: PointPairs | Touches | None) -> Touches | None:
    """Return what was observed as touches, which know their face, edge or corner."""
    return of if of is None or isinstance(of, Touches) else points_as_touches(of, workpiece.trimmed)


def _solids_of_rows(taught: TaughtPoints, workpiece: Workpiece) -> dict[str, int]:
    """Return the solid of every row that names a feature: where corners of two bodies coincide, the name tells them."""
    solids = {feature.name: feature.solid for feature in workpiece.features}
    number = {name: i for i, name in enumerate(workpiece.graph.solid_names)}
    named = {row: solids.get(feature or row, "") for row, feature in zip(taught.names, taught.features, strict=True)}
    return {row: number[solid] for row, solid in named.items() if solid in number}


def meeting_points(moved: MovedSeam) -> MeetingPoints:
    """Return the frames of a moved seam as points whose error is known."""
    frames = moved.seam.frames
    return MeetingPoints(
        frames.p, moved.wall_body, moved.base_body, moved.n_wall, moved.n_base, moved.x_wall, moved.is_met
    )


def _judged(
    rigid: CalibrationResult,
    found: MovedBodies,
    moved: Sequence[MovedSeam],
    sigma: Sigma,
    observed: Sequence[tuple[Touches, IntArray]],
) -> CalibrationResult:
    """Return the result of this fit: what was judged of the part as one body does not hold any more.

    Its fitted points, then its check points, are on the moved bodies, with their errors there.
    """
    fit, T = found.fit, found.fit.T_base_part
    pairs = [fit.paired(touches, body) for touches, body in observed]
    points = [MeetingPoints.on(body, each.p_source) for (_, body), each in zip(observed, pairs, strict=True)]
    accepted = [seam for seam in moved if seam.seam.accepted]
    evidence = BodiesEvidence(
        found,
        observed[0][0].names,
        MeetingPoints.joined([meeting_points(seam) for seam in accepted]) if accepted else points[0],
        [seam.seam.name for seam in accepted for _ in range(len(seam.seam.frames))],
        sigma,
        (pairs[1], observed[1][1]) if len(pairs) > 1 else None,
        rigid.issues,
        rigid.tolerance_mm,
    )
    result = replace(
        rigid,
        pairs=pairs[0],
        check=pairs[1] if len(pairs) > 1 else None,
        T_base_part=T,
        T_base_nominal=T @ rigid.T_nominal_part.inverse(),
        criterion=Criterion.WEIGHTED,
        lower_bound_mm=0.0,
        solver=_then_bodies(rigid.solver),
        sigma=sigma,
        covariance=fit.covariance[:6, :6],
        judgement=judge_evidence(evidence),
        criteria=None,
        seams=(),
        issues=tuple(issue for issue in rigid.issues if issue.code in STILL_TRUE),
        scale=found.scale,
        distrusted=None,
        suspect=None,
        criterion_advice=None,
        known_errors_mm=meeting_errors(fit, MeetingPoints.joined(points)).total_mm,
    )
    return replace(result, objective_mm=result.residuals.rms_mm)


def _then_bodies(solver: SolverReport) -> SolverReport:
    """Return how this answer was found; the course of the search is that of the part as one body."""
    method = f"{solver.method}, then damped Gauss-Newton on the motions of the bodies"
    return replace(solver, method=method, trace=None, annealed_objective_mm=None)
