"""Lines meet a torus where the polynomial's roots are, and where the height above it changes sign."""

import numpy as np

from wpcal.brep.torus_rays import torus_roots
from wpcal.core.arrays import FloatArray

NEAR_MM = 1e-4  #: A line that touches the torus is this near to it over a millimetre.
COUNT = 4000


def lines(seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    o, d = rng.normal(size=(COUNT, 3)) * 60.0, rng.normal(size=(COUNT, 3))
    special = np.eye(3)[rng.integers(0, 3, COUNT // 4)]
    d[: COUNT // 4] = special  # along axes: even quartics
    o[: COUNT // 8, :] *= special[: COUNT // 8]  # and through the centre
    return o, d / np.linalg.norm(d, axis=1, keepdims=True), rng.uniform(20, 60, COUNT), rng.uniform(1, 19, COUNT)


def height(o: FloatArray, d: FloatArray, major: FloatArray, minor: FloatArray, t: FloatArray) -> FloatArray:
    p = o[:, None] + t[..., None] * d[:, None]
    return np.hypot(np.hypot(p[..., 0], p[..., 1]) - major[:, None], p[..., 2]) - minor[:, None]


def test_every_root_is_on_the_torus() -> None:
    o, d, major, minor = lines(1)
    t = torus_roots(o, d, major, minor)
    off = np.abs(height(o, d, major, minor, t))
    assert np.isfinite(t).any(axis=1).mean() > 0.15
    assert np.nanmax(off) < NEAR_MM


def test_no_crossing_is_missed() -> None:
    o, d, major, minor = lines(2)
    t = np.linspace(-300.0, 300.0, 6001)
    found = torus_roots(o, d, major, minor)
    for first in range(0, COUNT, 500):
        own = slice(first, first + 500)
        h = height(o[own], d[own], major[own], minor[own], np.broadcast_to(t, (500, len(t))))
        row, at = np.nonzero((h[:, 1:] > 0) != (h[:, :-1] > 0))
        nearest = np.nanmin(np.abs(found[own][row] - (t[at] + t[at + 1])[:, None] / 2), axis=1)
        assert nearest.max() <= 0.05 + 1e-6
