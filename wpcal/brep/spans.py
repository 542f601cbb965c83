"""NURBS as polynomials, one per knot span, evaluated on many curves or surfaces at once.

On a span every B-spline is a polynomial of the local parameter x in [0, 1]. A matrix gives its coefficients from the
poles. The matrix depends only on the knots around the span and is built by the recursion of de Boor and Cox (Piegl and
Tiller, The NURBS Book, 2nd ed., eq. 2.5). Rational splines are computed in homogeneous coordinates (w x, w y, w z, w).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import comb
from typing import Generic, TypeVar

import numpy as np

from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.core.arrays import FloatArray, IntArray

CHUNK = 20_000
"""Points evaluated together: 10 MB of coefficients of a bicubic surface, which fit the processor's cache."""


@dataclass(frozen=True, slots=True, eq=False)
class _Spans:
    """The knot spans of one parameter of splines of one degree, one spline after the other."""

    start: IntArray  #: shape (n + 1,). The spans of spline i are ``start[i]:start[i + 1]``.
    #: `low`, `width`: shape (s,). Where each span begins and how long it is.
    low: FloatArray
    width: FloatArray
    first_pole: IntArray  #: shape (s,). The first of the degree + 1 poles that act on it.
    #: shape (s, degree + 1, degree + 1). From those poles (last index) to the coefficients of the powers of x.
    basis: FloatArray
    keys: FloatArray  #: shape (s,). Numbers that increase from span to span: from 2 i to 2 i + 1 on spline i.

    @classmethod
    def of(cls, degree: int, knots: Sequence[FloatArray]) -> _Spans:
        """Take the spans of splines from their knots (not decreasing, with repetitions)."""
        at = [np.flatnonzero(np.diff(k[degree : len(k) - degree]) > 0) + degree for k in knots]
        start = np.concatenate([[0], np.cumsum([len(spans) for spans in at])]).astype(np.int64)
        around = np.arange(1 - degree, degree + 1)
        windows = np.concatenate([k[spans[:, None] + around] for k, spans in zip(knots, at, strict=True)])
        low = windows[:, degree - 1]
        width = windows[:, degree] - low
        spline = np.repeat(np.arange(len(knots)), np.diff(start))
        begin, end = np.array([k[degree] for k in knots]), np.array([k[-degree - 1] for k in knots])
        keys = 2.0 * spline + (low - begin[spline]) / (end - begin)[spline]
        basis = _basis_polynomials((windows - low[:, None]) / width[:, None], degree)
        return cls(start, low, width, np.concatenate(at) - degree, basis, keys)

    def locate(self, spline: IntArray, t: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return span and local parameter of each parameter; beyond the ends of a spline, its outermost span."""
        first, last = self.start[spline], self.start[spline + 1] - 1
        begin = self.low[first]
        whole = self.low[last] + self.width[last] - begin
        at = np.searchsorted(self.keys, 2.0 * spline + (t - begin) / whole, side="right") - 1
        at = np.minimum(np.maximum(at, first), last)
        return at, (t - self.low[at]) / self.width[at]


def _basis_polynomials(knots: FloatArray, degree: int) -> FloatArray:
    """Return the degree + 1 B-splines that live on the span [0, 1] as polynomials.

    Returns ndarray, shape (s, degree + 1, degree + 1). [span, power of x, B-spline].

    `knots`: shape (s, 2 degree). The knots around each span in its local parameter: the last one before it is 0, the
    first one after it 1.
    """
    count = len(knots)
    splines = np.zeros((count, degree + 1, degree + 1))
    splines[:, 0, 0] = 1.0
    for k in range(1, degree + 1):
        raised = np.zeros_like(splines)
        for j in range(k):  # spline j of degree k - 1 goes into j and j + 1 of degree k, by (x - t) and (t' - x)
            t0, t1 = knots[:, degree - k + j], knots[:, degree + j]
            share = splines[:, :, j] / (t1 - t0)[:, None]
            times_x = np.pad(share[:, :-1], ((0, 0), (1, 0)))
            raised[:, :, j] += t1[:, None] * share - times_x
            raised[:, :, j + 1] += times_x - t0[:, None] * share
        splines = raised
    return splines


def _shift(degree: int, begin: FloatArray, share: FloatArray) -> FloatArray:
    """Return matrices from coefficients of powers of x to those of powers of s, where x = begin + share · s."""
    matrix = np.zeros((len(begin), degree + 1, degree + 1))
    for power in range(degree + 1):
        for m in range(power + 1):
            matrix[:, m, power] = comb(power, m) * begin ** (power - m) * share**m
    return matrix


def _homogeneous(poles: FloatArray, weights: FloatArray) -> FloatArray:
    return np.concatenate([poles * weights[..., None], weights[..., None]], axis=-1).reshape(-1, 4)


def _divided(h: FloatArray, *slopes: FloatArray) -> tuple[FloatArray, ...]:
    """Return points and derivatives, (m, 3), from homogeneous ones, (4, m), by the quotient rule."""
    p = h[:3] / h[3]
    return tuple(np.ascontiguousarray(own.T) for own in (p, *((dh[:3] - p * dh[3]) / h[3] for dh in slopes)))


def _horner(coefficients: FloatArray, x: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return value and derivative of polynomials with coefficients (powers, …, m) at x (m,)."""
    value, slope = coefficients[-1], np.zeros_like(coefficients[-1])
    for own in coefficients[-2::-1]:
        slope = slope * x + value
        value = value * x + own
    return value, slope


@dataclass(frozen=True, slots=True, eq=False)
class _Curves:
    """Curves of one degree; coefficients (degree + 1, 4, s)."""

    spans: _Spans
    coefficients: FloatArray

    @classmethod
    def of(cls, curves: Sequence[NurbsCurve]) -> _Curves:
        degree = curves[0].degree
        spans = _Spans.of(degree, [curve.knots for curve in curves])
        poles = np.concatenate([_homogeneous(curve.poles, curve.weights) for curve in curves])
        offset = np.cumsum([0, *(len(curve.poles) for curve in curves)])[:-1]
        first = spans.first_pole + np.repeat(offset, np.diff(spans.start))
        own = poles[first[:, None] + np.arange(degree + 1)]
        return cls(spans, np.moveaxis(np.einsum("sai,sic->sac", spans.basis, own), 0, -1).copy())

    def evaluate(self, curve: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        span, x = self.spans.locate(curve, t)
        h, dh = _horner(np.take(self.coefficients, span, axis=-1), x)
        p, slope = _divided(h, dh / self.spans.width[span])
        return p, slope


@dataclass(frozen=True, slots=True, eq=False)
class _Surfaces:
    """Surfaces of one pair of degrees; coefficients (degree u + 1, degree v + 1, 4, patches), v fastest."""

    u: _Spans
    v: _Spans
    start: IntArray
    coefficients: FloatArray

    @classmethod
    def of(cls, surfaces: Sequence[NurbsSurface]) -> _Surfaces:
        du, dv = surfaces[0].degrees
        u, v = _Spans.of(du, [s.knots_u for s in surfaces]), _Spans.of(dv, [s.knots_v for s in surfaces])
        counts = np.diff(u.start) * np.diff(v.start)
        start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        surface = np.repeat(np.arange(len(surfaces)), counts)
        at_u, at_v = np.divmod(np.arange(start[-1]) - start[surface], np.diff(v.start)[surface])
        at_u, at_v = at_u + u.start[surface], at_v + v.start[surface]
        poles = np.concatenate([_homogeneous(s.poles, s.weights) for s in surfaces])
        columns = np.array([s.poles.shape[1] for s in surfaces])[surface]
        offset = np.cumsum([0, *(s.weights.size for s in surfaces)])[:-1][surface]
        row = (u.first_pole[at_u][:, None] + np.arange(du + 1)) * columns[:, None] + offset[:, None]
        own = poles[row[:, :, None] + (v.first_pole[at_v][:, None] + np.arange(dv + 1))[:, None, :]]
        half = np.einsum("sai,sijc->sajc", u.basis[at_u], own)
        return cls(u, v, start, np.moveaxis(np.einsum("sbj,sajc->sabc", v.basis[at_v], half), 0, -1).copy())

    def evaluate(self, surface: IntArray, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        at_u, x = self.u.locate(surface, uv[:, 0])
        at_v, y = self.v.locate(surface, uv[:, 1])
        patch = self._patches(surface, at_u, at_v)
        (h, dh_u), (dh_v, _) = _horner(np.stack(_horner(np.take(self.coefficients, patch, axis=-1), x), axis=1), y)
        p, du, dv = _divided(h, dh_u / self.u.width[at_u], dh_v / self.v.width[at_v])
        return p, du, dv

    def _patches(self, surface: IntArray, at_u: IntArray, at_v: IntArray) -> IntArray:
        first = self.v.start[surface]
        return self.start[surface] + (at_u - self.u.start[surface]) * (self.v.start[surface + 1] - first) + at_v - first

    def moved(self, surface: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the polynomials of rectangles of (u, v) inside patches (`SurfaceSet.moved_coefficients`)."""
        middle = (low + high) / 2
        at_u, at_v = (spans.locate(surface, middle[:, axis])[0] for axis, spans in enumerate((self.u, self.v)))
        patch, moves = self._patches(surface, at_u, at_v), []
        for axis, (spans, at) in enumerate(((self.u, at_u), (self.v, at_v))):
            begin = (low[:, axis] - spans.low[at]) / spans.width[at]
            share = (high - low)[:, axis] / spans.width[at]
            moves.append(_shift(self.coefficients.shape[axis] - 1, begin, share))
        half = np.einsum("kma,kabc->kmbc", moves[0], np.moveaxis(self.coefficients[..., patch], -1, 0).copy())
        return np.asarray(np.einsum("knb,kmbc->kmnc", moves[1], half), dtype=np.float64)


Group = TypeVar("Group", _Curves, _Surfaces)


@dataclass(frozen=True, slots=True, eq=False)
class _SplineSet(Generic[Group]):
    """Many splines as polynomials, in groups of equal degree."""

    #: `group`, `place`: shape (n,). The group of each spline, and its place there.
    group: IntArray
    place: IntArray
    groups: tuple[Group, ...]

    def _evaluate(self, spline: IntArray, t: FloatArray, columns: int) -> tuple[FloatArray, ...]:
        """Return point and derivatives on splines (m,) at parameters t, (m,) or (m, 2); arrays (m, 3)."""
        own = self.group[spline]
        if 0 < len(own) <= CHUNK and (own == own[0]).all():
            return tuple(self.groups[own[0]].evaluate(self.place[spline], t))
        found = tuple(np.empty((len(t), 3)) for _ in range(columns))
        for number, group in enumerate(self.groups):
            for rows in _chunks(np.flatnonzero(own == number)):
                for column, values in zip(found, group.evaluate(self.place[spline[rows]], t[rows]), strict=True):
                    column[rows] = values
        return found


class CurveSet(_SplineSet[_Curves]):
    """Many NURBS curves, evaluated together."""

    __slots__ = ()

    @classmethod
    def of(cls, curves: Sequence[NurbsCurve]) -> CurveSet:
        """Turn curves into polynomials."""
        group, place, members = _grouped([(curve.degree,) for curve in curves])
        return cls(group, place, tuple(_Curves.of([curves[i] for i in rows]) for rows in members))

    def evaluate(self, curve: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and first derivatives on curves.

        `curve`: ndarray of int, shape (m,).
        `t`: shape (m,). Parameters.
        Returns `p, slope`: ndarray, shape (m, 3). mm, and mm per unit of t.
        """
        p, slope = self._evaluate(curve, t, 2)
        return p, slope


class SurfaceSet(_SplineSet[_Surfaces]):
    """Many NURBS surfaces, evaluated together."""

    __slots__ = ()

    @classmethod
    def of(cls, surfaces: Sequence[NurbsSurface]) -> SurfaceSet:
        """Turn surfaces into polynomials."""
        group, place, members = _grouped([surface.degrees for surface in surfaces])
        return cls(group, place, tuple(_Surfaces.of([surfaces[i] for i in rows]) for rows in members))

    def evaluate(self, surface: IntArray, uv: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return points and the derivatives along u and v on surfaces.

        `surface`: ndarray of int, shape (m,).
        `uv`: shape (m, 2). Parameters.
        Returns `p, du, dv`: ndarray, shape (m, 3). mm, and mm per unit of u and v.
        """
        p, du, dv = self._evaluate(surface, uv, 3)
        return p, du, dv

    def moved_coefficients(
        self, surface: IntArray, low: FloatArray, high: FloatArray
    ) -> Iterator[tuple[IntArray, FloatArray]]:
        """Yield the polynomials of rectangles inside knot spans, as those of parameters that run from 0 to 1 there.

        `surface`: ndarray of int, shape (m,).
        `low`, `high`: shape (m, 2). Least and greatest u and v of each rectangle.

        Yields
        ------
        rows : ndarray of int, shape (k,). Rectangles of surfaces of equal degrees.
        coefficients : ndarray, shape (k, degree u + 1, degree v + 1, 4)
            Of the powers of both parameters, in homogeneous coordinates, mm.
        """
        for number, group in enumerate(self.groups):
            for rows in _chunks(np.flatnonzero(self.group[surface] == number)):
                yield rows, group.moved(self.place[surface[rows]], low[rows], high[rows])


def _chunks(rows: IntArray) -> list[IntArray]:
    return [rows[first : first + CHUNK] for first in range(0, len(rows), CHUNK)]


def _grouped(keys: list[tuple[int, ...]]) -> tuple[IntArray, IntArray, list[list[int]]]:
    """Return the group of each key, its place in the group, and the members of each group."""
    members: dict[tuple[int, ...], list[int]] = {}
    for row, key in enumerate(keys):
        members.setdefault(key, []).append(row)
    group, place = np.zeros(len(keys), dtype=np.int64), np.zeros(len(keys), dtype=np.int64)
    for number, rows in enumerate(members.values()):
        group[rows], place[rows] = number, np.arange(len(rows))
    return group, place, list(members.values())
