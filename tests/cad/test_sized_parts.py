"""Parts that are larger than their models: a stated temperature and a free scale give the seams the real size."""

from dataclasses import replace

import numpy as np
import pytest

from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.fit_part import fit_part
from cad.workpiece.fit_taught import CalibrateOptions, ScaleChoice, name_taught, prepare_fit
from cad.workpiece.workpiece import Workpiece
from tests.few import few
from tests.saved_graphs import saved_graph, saved_seams
from wpcal.calibrate import Criterion
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.scale import STEEL_PER_K
from wpcal.calibrate.trust.verdict import VerdictReason
from wpcal.core.transform import RigidTransform
from wpcal.taught.table import taught_points

T = RigidTransform.from_six_tuple((812.5, -310.25, 455.125, 0.02, -0.3, 1.1), target="base", source="part")
SCALE, SIGMA_MM, FREE = 1e-3, 0.02, {"scale": ScaleChoice.FREE}
WARM = {"part_celsius": 20.0 + SCALE / STEEL_PER_K}
BODIES = {"bodies": BodiesOptions.of(0.05, 0.05)}  # tacked well: the scale is all that moved their corners


def smooth_error(p_base):
    """An arm whose error changes over its working space, mm."""
    return 0.5 * np.sin(p_base[..., [1, 2, 0]] / 200.0)


def robot_off(*, wrong_mm=0.0, **asked):
    """Return the result, and the largest error of seams that a robot with `smooth_error` touched and welds."""
    part = Workpiece(saved_graph("frame"))
    corners = [each for each in part.features if each.kind.is_point][::4]
    touched = {each.name: (at := T.apply(each.p_mm)) + smooth_error(at) for each in corners}
    touched[corners[0].name] = touched[corners[0].name] + [wrong_mm, 0.0, 0.0]
    options = CalibrateOptions(teaching=TeachingError(sigma_mm=0.05), **asked)
    named = name_taught(taught_points(touched), part.features, options=options).taught
    found = fit_part(part, prepare_fit(named, part), seams := saved_seams("frame"), options)
    shown, real = (np.concatenate([s.frames.p for s in each]) for each in (found.seams, seams))
    off = found.result.T_base_part.apply(shown) - T.apply(real) - smooth_error(T.apply(real))
    return found.result, float(np.linalg.norm(off, axis=1).max())


@pytest.mark.deep
def test_seams_follow_the_robot_where_the_touches_tell():
    (result, after), (pose, before) = robot_off(), robot_off(rigid=True)
    assert after < 0.6 * before
    assert "field_shift" in result.to_record()
    assert "field_shift" not in pose.to_record()
    assert [issue.code for issue in result.issues if issue not in pose.issues] == ["field-followed"]
    for other in (robot_off(criterion=Criterion.MINIMAX), robot_off(wrong_mm=6.0)):
        assert other[0].field_shift is None


def fitted(**asked):
    part, rng = Workpiece(saved_graph("frame")), np.random.default_rng(5)
    corners = [each for each in part.features if each.kind.is_point]
    chosen = [corners[i] for i in rng.choice(len(corners), 24, replace=False)]
    touched = {each.name: T.apply((1.0 + SCALE) * each.p_mm) + SIGMA_MM * rng.standard_normal(3) for each in chosen}
    options = replace(CalibrateOptions(teaching=TeachingError(sigma_mm=SIGMA_MM, robot=RobotField.none())), **asked)
    named = name_taught(taught_points(touched), part.features, options=options).taught
    found = fit_part(part, prepare_fit(named, part), seams := saved_seams("frame"), options)
    shown, real = (np.concatenate([s.frames.p for s in each if s.accepted]) for each in (found.seams, seams))
    off = found.result.T_base_part.apply(shown) - T.apply((1.0 + SCALE) * real)
    return found.result, float(np.linalg.norm(off, axis=1).max())


@pytest.mark.parametrize("asked", few([WARM, FREE, {**WARM, **BODIES}, {**FREE, **BODIES}], 1))
def test_seams_have_the_size_of_the_part(asked):
    (model, before), (found, after) = fitted(), fitted(**asked)
    assert (model.judgement.reason, found.verdict) == (VerdictReason.SCALE, "PASS")
    assert after < found.judgement.error_95_mm < 0.25 * before
    assert abs(found.to_record()["applied_scale"]["scale"] - SCALE) < 1e-4
