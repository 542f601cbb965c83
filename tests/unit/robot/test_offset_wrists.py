"""Arms without a spherical wrist: all solutions, against a dense search from random starts."""

import dataclasses

import numpy as np
import pytest

from tests.samples.offset_wrists import crx10ia, ur5e, ur10e
from wpcal.core.errors import GeometryError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.inverse import TURN, own_branch, solve_inverse

ARMS = {arm.name: arm for arm in (ur5e(), ur10e(), crx10ia())}
MET_MM = 1e-6  #: A solution meets its pose: Newton steps and closed forms end far below.
SAME_RAD = 1e-5  #: Of two starts that end in one solution.
REGULAR = 1e-3  #: Least singular value, lengths in parts of a metre, of poses whose solutions are all apart.


@pytest.fixture(params=ARMS)
def arm(request):
    return ARMS[request.param]


def apart(a, b):
    return np.abs(a - b - TURN * np.rint((a - b) / TURN)).max(axis=-1)


def random_poses(arm, count, seed):
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, 6))
    return q, arm.forward(q)


def test_every_solution_meets_its_pose_and_the_given_joints_are_one_of_them(arm):
    q, T = random_poses(arm, 300, 1)
    found = solve_inverse(arm, T)
    rows = np.nonzero(found.reached)
    assert np.abs(arm.forward(found.joints[rows]) - T[rows[0]]).max() < MET_MM
    J = arm.jacobian(q)
    J[:, 3:] /= 1000.0
    regular = np.linalg.svd(J, compute_uv=False).min(axis=1) > REGULAR
    own = np.where(found.reached, apart(found.joints, q[:, None]), np.inf).min(axis=1)
    assert (own[regular] < SAME_RAD).all()
    assert regular.mean() > 0.9


def test_an_arm_on_a_slant_is_solved_as_one_that_stands(arm):
    T_base_dh0 = RigidTransform(rotation_from_zyx(0.9, -0.6, 0.35), [80.0, -130.0, 310.0], "base", "dh0")
    slant = dataclasses.replace(arm, chain=dataclasses.replace(arm.chain, T_base_dh0=T_base_dh0))
    q, T = random_poses(arm, 20, 4)
    found = solve_inverse(slant, T_base_dh0.matrix @ np.linalg.inv(arm.chain.T_base_dh0.matrix) @ T)
    own = np.where(found.reached, apart(found.joints, q[:, None]), np.inf).min(axis=1)
    assert np.count_nonzero(own < SAME_RAD) >= 18
    assert (found.reached.sum(axis=1) == solve_inverse(arm, T).reached.sum(axis=1)).all()


def test_no_start_leads_to_a_solution_that_is_not_found(arm):
    _, T = random_poses(arm, 6, 2)
    found = solve_inverse(arm, T)
    rng = np.random.default_rng(3)
    for pose, joints, reached in zip(T, found.joints, found.reached, strict=True):
        starts = rng.uniform(-np.pi, np.pi, (600, 6))
        ends = newton(arm, np.repeat(pose[None], len(starts), axis=0), starts)
        assert len(ends) > 50
        assert apart(ends[:, None], joints[reached][None]).min(axis=1).max() < SAME_RAD
        each = joints[reached]
        assert (apart(each[:, None], each[None]) + 9.0 * np.eye(len(each)) > SAME_RAD).all()  # none is there twice


def test_a_flange_that_looks_straight_down_has_as_many_solutions_as_one_beside_it(arm):
    T = np.repeat(np.diag([1.0, -1.0, -1.0, 1.0])[None], 3, axis=0)
    T[:, :3, 3] = 500.0, 60.0, 250.0
    for row, tilt in enumerate((0.0, 1e-7, 1e-3)):
        c, s = np.cos(tilt), np.sin(tilt)
        T[row, :3, :3] = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) @ T[row, :3, :3]
    count = solve_inverse(arm, T).reached.sum(axis=1)
    assert count.tolist() == [count[0]] * 3
    assert count[0] >= 8


def newton(arm, T, q):
    """Damped Newton steps, written for this test; the ends that meet their poses in regular states."""
    for _ in range(60):
        now = arm.forward(q)
        E = np.swapaxes(now[:, :3, :3], 1, 2) @ T[:, :3, :3]
        w = 0.5 * np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        error = np.concatenate([np.einsum("nij,nj->ni", now[:, :3, :3], w), (T - now)[:, :3, 3] / 1000.0], axis=1)
        J = arm.jacobian(q)
        J[:, 3:] /= 1000.0
        step = np.linalg.solve(
            np.swapaxes(J, 1, 2) @ J + 1e-9 * np.eye(6), np.einsum("nji,nj->ni", J, error)[..., None]
        )
        q = q + np.clip(step[..., 0], -0.5, 0.5)
    good = (np.abs(arm.forward(q) - T).max(axis=(1, 2)) < MET_MM) & (
        np.linalg.svd(J, compute_uv=False)[:, -1] > REGULAR
    )
    return q[good]


def test_joints_go_on_along_a_path_though_roots_have_no_names(arm):
    q = np.linspace([0.3, -0.4, 0.9, 0.5, 0.8, 0.2], [0.5, -0.2, 1.1, 0.9, 1.0, -0.3], 25)
    T = arm.forward(q)
    first = solve_inverse(arm, T[:1])
    branch = int(np.argmin(np.where(first.reached[0], apart(first.joints[0], q[0]), np.inf)))
    assert apart(own_branch(arm, T, branch, q[0]), q).max() < SAME_RAD


def test_an_identified_arm_meets_its_own_poses(arm):
    table = arm.chain.table.copy()
    table[1:3] += np.random.default_rng(4).normal(0.0, 0.3, table[1:3].shape)
    real = arm.as_identified(arm.chain.with_table(table))
    q, T = random_poses(real, 40, 5)
    found = solve_inverse(real, T)
    rows = np.nonzero(found.reached)
    assert np.abs(real.forward(found.joints[rows]) - T[rows[0]]).max() < MET_MM
    own = np.where(found.reached, apart(found.joints, q[:, None]), np.inf).min(axis=1)
    assert (own < SAME_RAD).mean() > 0.9


def test_another_arm_is_refused_with_its_axes():
    table = crx10ia().chain.table.copy()
    table[3, 1] += 0.2
    arm = crx10ia()
    with pytest.raises(GeometryError, match="axis 3 is not parallel to axis 2"):
        solve_inverse(dataclasses.replace(arm, chain=arm.chain.with_table(table)), np.eye(4)[None])
