r"""The linear model of a weldment whose bodies may move, before it is touched.

The unknowns are (L ω, v) of the whole about a centre, the motion of every body in units of its tack tolerance, and
errors that all touches share, in standard deviations. A touch with the row h, in units of its error, adds
:math:`h h^\top` to the information :math:`M`, which begins with the tolerances and the kept contacts. Seam points with
the rows J are then off by :math:`J M^{-1} J^\top`, as after the fit of `wpcal.calibrate.solve.bodies`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_jacobian
from wpcal.calibrate.observe.bodies import Bodies, Contacts
from wpcal.calibrate.observe.motions import Motions
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform

UNKNOWN_MM = 1e3
"""Before the first touch the part is anywhere within this: enough that it changes no digit of what touches hold."""


@dataclass(frozen=True, slots=True, eq=False)
class MovedModel:
    """What the unknowns are."""

    bodies: Bodies  #: b bodies; none for a part that moves as one.
    centre_part: FloatArray  #: shape (3,). About which the whole turns, in `part`, mm.
    length_mm: float  #: Of the part: a turn of the whole counts as the way at this distance.
    shared: int = 0  #: Number s of errors that all touches share.
    contacts: Contacts = field(default_factory=Contacts.none)  #: Contacts between bodies that are kept.

    @property
    def size(self) -> int:
        """Number of unknowns, 6 + 6 b + s."""
        return 6 + 6 * len(self.bodies) + self.shared

    def prior(self) -> FloatArray:
        """Return the information before the first touch, shape (m, m)."""
        known = np.full(self.size, 1.0)
        known[:6] = UNKNOWN_MM**-2
        c = self.contacts
        n = c.normal_part[:, None, :]
        of_whole = slice(0, 6)
        G = self.rows(c.p_part, n, c.first) - self.rows(c.p_part, n, c.second)
        G[:, :, of_whole] = 0.0  # a contact is within the part
        G = G[:, 0] / c.sigma_mm[:, None]
        return np.asarray(np.diag(known) + G.T @ G)

    def rows(
        self, p_part: FloatArray, directions: FloatArray, body: IntArray, shared: FloatArray | None = None
    ) -> FloatArray:
        """Differentiate what touches measure by the unknowns, shape (n, q, m), mm.

        Parameters
        ----------
        p_part : shape (n, 3). Touched points, in `part`, mm.
        directions : shape (n, q, 3). In which each touch measures: its numbers are the displacements along them.
        body : ndarray of int, shape (n,)
            -1: the point does not move within the part.
        shared : shape (n, q, s). What each number sees of one standard deviation of the shared errors, mm.
        """
        n, b = len(p_part), len(self.bodies)
        whole = directions @ point_jacobian(p_part - self.centre_part) / self._scale
        own = np.zeros((n, directions.shape[1], b, 6))
        some = np.flatnonzero(body >= 0)
        if len(some):
            by = self._still().displacement_jacobian(body[some], p_part[some]) * self.bodies.scales[body[some]][:, None]
            own[some, :, body[some]] = directions[some] @ by
        common = np.zeros((n, directions.shape[1], self.shared)) if shared is None else shared
        return np.concatenate([whole, own.reshape(n, directions.shape[1], 6 * b), common], axis=2)

    def seam_rows(self, points: MeetingPoints) -> FloatArray:
        """Differentiate points of seams by the unknowns, shape (k, 3, m)."""
        k, b = len(points.p_part), len(self.bodies)
        J = np.zeros((k, 3, self.size))
        if b:
            scales = self.bodies.scales.ravel()
            J[:, :, 6 : 6 + 6 * b] = meeting_jacobian(self._still(), points)[:, :, 6 : 6 + 6 * b] * scales
        J[:, :, :6] = point_jacobian(points.p_part - self.centre_part) / self._scale
        return J

    @property
    def _scale(self) -> FloatArray:
        return np.repeat([self.length_mm, 1.0], 3)

    def _still(self) -> Motions:
        return Motions.rigid(self.bodies, RigidTransform.identity(target="base", source="part"))


@dataclass(frozen=True, slots=True, eq=False)
class SeamPoints:
    """The points where errors count."""

    points: MeetingPoints  #: k points in the model.
    seams: tuple[str, ...]  #: length k. The seam of each.


@dataclass(frozen=True, slots=True, eq=False)
class Tacked:
    """A part whose bodies may move: what a choice of touches needs to know of it."""

    bodies: Bodies
    face_body: IntArray  #: shape (F,). The body of every face; -1: it does not move.
    seams: SeamPoints  #: Where the error counts.
    contacts: Contacts = field(default_factory=Contacts.none)

    def model(self, shared: int = 0) -> MovedModel:
        """Return its linear model, with a number of errors that all touches share."""
        places = np.concatenate([self.seams.points.p_part, self.bodies.centroid_part])
        centre = (places.min(axis=0) + places.max(axis=0)) / 2.0
        length = float(np.linalg.norm(places - centre, axis=1).max())
        return MovedModel(self.bodies, centre, max(length, 1.0), shared, self.contacts)
