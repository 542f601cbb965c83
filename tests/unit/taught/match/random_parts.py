"""Random parts and touches for the tests of points without names."""

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.taught.features import FeatureKind, ReferenceFeature

BOX_MM = np.array([1000.0, 600.0, 300.0])


def as_features(points: FloatArray) -> tuple[ReferenceFeature, ...]:
    return tuple(
        ReferenceFeature(f"V{i}", FeatureKind.VERTEX, frozen(p), None, None, "S1") for i, p in enumerate(points, 1)
    )


def random_pose(rng: np.random.Generator) -> RigidTransform:
    return RigidTransform(exp_rotation(rng.normal(size=3) * 2.0), rng.uniform(-2000, 2000, 3), "base", "part")


def random_points(rng: np.random.Generator, n: int) -> FloatArray:
    return np.asarray(rng.uniform(0, 1, (n, 3)) * BOX_MM)


def pattern_points(rng: np.random.Generator) -> FloatArray:
    """A plate with corners on both faces and a grid of equal holes: as regular as parts are."""
    nx, ny = rng.integers(2, 7, 2)
    pitch = rng.uniform(40, 120, 2)
    size = np.array([(nx + 1) * pitch[0], (ny + 1) * pitch[1], rng.uniform(5, 60)])
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * size
    holes = np.array([[(i + 1) * pitch[0], (j + 1) * pitch[1], size[2]] for i in range(nx) for j in range(ny)])
    odd = rng.uniform(0.1, 0.9, (int(rng.integers(0, 4)), 3)) * size
    return np.concatenate([corners, holes, odd])


def touched(rng: np.random.Generator, points: FloatArray, n: int, sigma_mm: float) -> tuple[IntArray, FloatArray]:
    """Rows of n points that are not nearly on one line, and where they are seen in the base."""
    T = random_pose(rng)
    while True:
        rows = rng.choice(len(points), n, replace=False)
        spread = np.linalg.svd(points[rows] - points[rows].mean(axis=0), compute_uv=False)
        if spread[1] > 40.0 * max(sigma_mm, 0.1):
            return rows, T.apply(points[rows]) + sigma_mm * rng.standard_normal((n, 3))
