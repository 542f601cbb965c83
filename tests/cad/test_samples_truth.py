"""The sample parts against closed forms: where the calibrated seams stand is known without wpcal."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cad.workpiece.calibrate import WorkpieceCalibration, calibrate_workpiece
from tests.few import few
from wpcal.core.arrays import FloatArray
from wpcal.core.records import read_json
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam, SeamFrames

FIXTURES = Path(__file__).parents[2] / "fixtures"
PARTS = ("tee", "lap", "saddle", "frame")

EXACT_MM = 1e-6
"""Asked of exact points; they are written with 1e-9 mm, which a short base of points turns into at most 1e-8 mm."""
EXACT_RAD = 1e-6  #: Asked of tangent and bisector; the kernel's saddle curve is good to 1e-7 mm on a radius of 25 mm.
U95_FACTOR = 1.0
"""The seam error under the stated teaching error stays within its predicted 95 % bound at every frame. One draw with a
fixed seed; the bound is wide because four points say little about their own spread."""

UP, DOWN, LEFT, RIGHT, FRONT, BACK = (
    np.array(v, dtype=float) for v in [(0, 0, 1), (0, 0, -1), (-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0)]
)


@cache
def calibrated(name: str, taught: str) -> WorkpieceCalibration:
    return calibrate_workpiece(FIXTURES / name / f"{name}.step", FIXTURES / name / taught)


def truth(name: str) -> RigidTransform:
    record = read_json(FIXTURES / name / "truth.json", schema="wpcal/truth/1")
    return RigidTransform.from_matrix(record["T_base_part"], target="base", source="part")


def seams_in_truth(name: str) -> list[tuple[Seam, SeamFrames]]:
    """Accepted seams and their short ends, with their calibrated frames seen from where the part truly stands."""
    found = calibrated(name, "taught_exact.csv")
    T_part_base = truth(name).inverse()
    return [
        (seam, seam.frames.moved(found.T_base_part).moved(T_part_base))
        for seam in found.candidates
        if seam.accepted or seam.wrap_of
    ]


Line = tuple[FloatArray, FloatArray, FloatArray, FloatArray]  #: Start, end, and the outward normals of the two faces.


def tee_lines() -> list[Line]:
    """The web stands on x 25 to 175, y 56 to 64 of the plate's top, z 10."""
    a, b, c, d = (np.array([x, y, 10.0]) for x, y in ((25, 56), (175, 56), (25, 64), (175, 64)))
    return [(a, c, LEFT, UP), (a, b, FRONT, UP), (c, d, BACK, UP), (b, d, RIGHT, UP)]


def lap_lines() -> list[Line]:
    """The plates overlap on x 70 to 120, y 0 to 50, z 6; at the sides they end flush."""
    a, b, c, d = (np.array([x, y, 6.0]) for x, y in ((70, 0), (120, 0), (70, 50), (120, 50)))
    return [(a, c, LEFT, UP), (a, b, FRONT, FRONT), (c, d, BACK, BACK), (b, d, RIGHT, DOWN)]


def frame_lines() -> list[Line]:
    """At each mitre: the upright edge outside, the one inside, and the diagonal on top and below."""
    lines: list[Line] = []
    for x_out, x_in, across in ((0.0, 40.0, LEFT), (600.0, 560.0, RIGHT)):
        for y_out, y_in, along in ((0.0, 40.0, FRONT), (400.0, 360.0, BACK)):
            for x, y, sign in ((x_out, y_out, 1.0), (x_in, y_in, -1.0)):
                lines.append((np.array([x, y, 0.0]), np.array([x, y, 40.0]), sign * across, sign * along))
            for z, normal in ((0.0, DOWN), (40.0, UP)):
                ends = sorted([(x_out, y_out, z), (x_in, y_in, z)])
                lines.append((np.array(ends[0]), np.array(ends[1]), normal, normal))
    return lines


@pytest.mark.parametrize(
    ("name", "lines"), few([("tee", tee_lines()), ("lap", lap_lines()), ("frame", frame_lines())], 2)
)
def test_straight_seams_are_where_the_closed_form_has_them(name: str, lines: list[Line]) -> None:
    seams = seams_in_truth(name)
    assert len(seams) == len(lines)
    left = list(range(len(lines)))
    for seam, frames in seams:
        off = [np.abs(np.stack(lines[i][:2]) - frames.p[[0, -1]]).max() for i in left]
        start, end, n1, n2 = lines[left.pop(int(np.argmin(off)))]
        length = float(np.linalg.norm(end - start))
        assert seam.length_mm == pytest.approx(length, rel=0, abs=EXACT_MM)
        x, z = (end - start) / length, (n1 + n2) / np.linalg.norm(n1 + n2)
        np.testing.assert_allclose(frames.p, start + frames.s_mm[:, None] * x, rtol=0, atol=EXACT_MM)
        R = np.stack([x, np.cross(z, x), z], axis=1)
        np.testing.assert_allclose(frames.R, np.broadcast_to(R, frames.R.shape), rtol=0, atol=EXACT_RAD)
        angle = math.acos(np.clip(n1 @ n2, -1, 1))
        np.testing.assert_allclose(frames.angle_rad, angle, rtol=0, atol=EXACT_RAD)


def test_the_saddle_lies_on_both_pipes() -> None:
    ((seam, frames),) = seams_in_truth("saddle")
    assert seam.closed
    x, y, z = frames.p.T
    np.testing.assert_allclose(np.hypot(x, y), 25.0, rtol=0, atol=EXACT_MM)
    np.testing.assert_allclose(np.hypot(y, z), 50.0, rtol=0, atol=EXACT_MM)
    branch = np.stack([x / 25, y / 25, np.zeros_like(x)], axis=1)
    run = np.stack([np.zeros_like(x), y / 50, z / 50], axis=1)
    # seen from above the loop runs to the left: from (-25, 0) towards negative y
    tangent = np.cross(run, branch)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    bisector = (branch + run) / np.linalg.norm(branch + run, axis=1, keepdims=True)
    np.testing.assert_allclose(frames.R[:, :, 0], tangent, rtol=0, atol=EXACT_RAD)
    np.testing.assert_allclose(frames.R[:, :, 2], bisector, rtol=0, atol=EXACT_RAD)
    np.testing.assert_allclose(np.cos(frames.angle_rad), y * y / 1250, rtol=0, atol=EXACT_RAD)


def test_the_saddle_has_the_length_of_the_curve() -> None:
    ((seam, _),) = seams_in_truth("saddle")
    a = np.linspace(0, 2 * np.pi, 4097)[:-1]
    # p = (25 cos a, 25 sin a, sqrt(2500 - 625 sin² a)); a smooth periodic integrand: the trapezium rule is exact
    height = np.sqrt(2500 - 625 * np.sin(a) ** 2)
    speed = np.sqrt(625 + (625 * np.sin(a) * np.cos(a) / height) ** 2)
    assert seam.length_mm == pytest.approx(float(speed.mean() * 2 * np.pi), rel=0, abs=EXACT_MM)


@pytest.mark.parametrize("name", few(PARTS, 3))
def test_exact_points_find_the_place(name: str) -> None:
    found = calibrated(name, "taught_exact.csv")
    assert found.result.objective_mm <= EXACT_MM
    assert found.T_base_part.is_close(truth(name), atol_mm=EXACT_MM, atol_rad=EXACT_RAD)


@pytest.mark.parametrize("name", few(PARTS, 2))
def test_the_seam_error_is_within_what_was_predicted(name: str) -> None:
    found, T = calibrated(name, "taught.csv"), truth(name)
    for seam, u95_mm in zip(found.candidates, found.candidate_u95_mm, strict=True):
        off = np.linalg.norm(found.T_base_part.apply(seam.frames.p) - T.apply(seam.frames.p), axis=1)
        assert (off <= U95_FACTOR * u95_mm).all(), f"{seam.name}: {off.max():.3f} mm, predicted {u95_mm.max():.3f} mm"
        assert off.max() > EXACT_MM  # a taught point that is off by 0.1 mm leaves its mark
