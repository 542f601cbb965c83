import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.identify.parameters import (
    KinematicModel,
    base_parameters,
    link_parameters,
    parameters_by_name,
    reflector_parameters,
    tool_parameters,
)
from wpcal.robot.kinematics.arm_file import find_arm, shipped_arms
from wpcal.robot.kinematics.forward import LINK_SYMBOLS, MDHChain, forward_kinematics

ROUND_OFF_MM = 1e-9  # three orders above the round-off of sums of a few metres
JACOBIAN_ATOL = 1e-6  # the bound on analytic against central differences
DIFFERENCE_STEP = 1e-5  # rad or mm: truncation (step²) and round-off (1e-12 / step) are both far below the bound
LINKS = [f"{symbol}{i}" for symbol in LINK_SYMBOLS for i in range(1, 7)]


def link_matrix(theta, d, a, alpha, beta):
    """One link written out as the product of Xiong 2015, eq. (2), in 4×4 matrices: shares no code with the package."""

    def turn(angles):
        T = np.eye(4)
        T[:3, :3] = rotation_from_zyx(*angles)
        return T

    def shift(x, z):
        T = np.eye(4)
        T[0, 3], T[2, 3] = x, z
        return T

    return turn((0, 0, theta)) @ shift(0, d) @ shift(a, 0) @ turn((alpha, 0, 0)) @ turn((0, beta, 0))


def crooked_model(seed):
    """A model with nothing special in it: every link, base and tool off any axis, three reflectors."""
    rng = np.random.default_rng(seed)
    nominal = find_arm("mh6").chain
    base = RigidTransform(exp_rotation([0.3, 0.2, -1.0]), [3000.0, 100.0, -500.0], "base", "dh0")
    tool = RigidTransform(exp_rotation([1.3, 0.2, -1.0]), [30.0, 100.0, -50.0], "dhn", "flange")
    theta, d, a, alpha, beta = nominal.table + rng.normal(0, 0.05, nominal.table.shape)
    return KinematicModel(MDHChain(theta, d, a, alpha, beta, nominal.hayati, base, tool), rng.normal(0, 50, (3, 3)))


def test_forward_kinematics_is_the_product_of_the_links():
    chain = crooked_model(0).chain
    theta = np.random.default_rng(1).uniform(-3, 3, (5, 6))
    for angles, found in zip(theta, forward_kinematics(chain, theta), strict=True):
        T = chain.T_base_dh0.matrix
        for angle, (offset, d, a, alpha, beta) in zip(angles, chain.table.T, strict=True):
            T = T @ link_matrix(angle + offset, d, a, alpha, beta)
        np.testing.assert_allclose(found, T @ chain.T_dhn_flange.matrix, rtol=0, atol=ROUND_OFF_MM)


def test_mh6_stretched_out_reaches_as_far_as_its_maker_says():
    arm = find_arm("mh6")
    elbow = np.arctan2(155, 640) - np.pi / 2  # puts shoulder, elbow and wrist on one line
    q = [[0, np.pi / 2, elbow, 0, 0, 0]]
    wrist = arm.forward(q)[0] @ [0, 0, -95, 1]
    np.testing.assert_allclose(wrist[:3], [150 + 614 + np.hypot(155, 640), 0, 450], rtol=0, atol=ROUND_OFF_MM)
    assert round(np.hypot(wrist[0], wrist[1])) == 1423  # published: 1422, the note in the arm file has the digits


@pytest.mark.parametrize("name", shipped_arms())
def test_joint_jacobian_is_the_central_difference(name):
    arm = find_arm(name)
    q = np.random.default_rng(2).uniform(-1, 1, (4, 6))
    point = np.array([10.0, -20.0, 300.0])
    J = arm.jacobian(q, point=point)
    np.testing.assert_array_equal(arm.jacobian(q), arm.jacobian(q, point=[0.0, 0.0, 0.0]))
    for joint in range(6):
        step = DIFFERENCE_STEP * np.eye(6)[joint]
        ahead, behind = arm.forward(q + step), arm.forward(q - step)
        turn = log_rotation(ahead[:, :3, :3] @ np.swapaxes(behind[:, :3, :3], 1, 2))
        shift = (ahead - behind)[:, :3, :3] @ point + (ahead - behind)[:, :3, 3]
        numeric = np.concatenate([turn, shift], axis=1) / (2 * DIFFERENCE_STEP)
        np.testing.assert_allclose(J[:, :, joint], numeric, rtol=0, atol=JACOBIAN_ATOL)


def test_jacobian_of_every_parameter_is_the_central_difference():
    model = crooked_model(3)
    parameters = (
        *parameters_by_name(model.chain, LINKS),
        *base_parameters(),
        *tool_parameters(),
        *reflector_parameters("ABC"),
    )
    rng = np.random.default_rng(4)
    theta, reflector = rng.uniform(-3, 3, (6, 6)), np.array([0, 1, 2, 0, 1, 2])
    J = model.jacobian(parameters, theta, reflector)
    for k, parameter in enumerate(parameters):
        step = DIFFERENCE_STEP * np.eye(len(parameters))[k]
        p_ahead, R_ahead = model.moved(parameters, step).poses(theta, reflector)
        p_behind, R_behind = model.moved(parameters, -step).poses(theta, reflector)
        turn = log_rotation(R_ahead @ np.swapaxes(R_behind, 1, 2))
        numeric = np.concatenate([turn, p_ahead - p_behind], axis=1) / (2 * DIFFERENCE_STEP)
        np.testing.assert_allclose(J[:, :, k], numeric, rtol=0, atol=JACOBIAN_ATOL, err_msg=parameter.name)


def test_a_chain_has_the_24_parameters_of_the_paper():
    names = [parameter.name for parameter in link_parameters(find_arm("mh6").chain)]
    assert len(names) == 24
    assert names[6:12] == ["d1", "beta2", "d3", "d4", "d5", "d6"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"d": [0]}, "expected 2 values"),
        ({"a": [np.nan, 0]}, "not finite"),
        ({"hayati": (False, True)}, "last link"),
        ({"theta": [], "d": [], "a": [], "alpha": [], "beta": [], "hayati": ()}, "at least one link"),
    ],
)
def test_a_chain_refuses_wrong_numbers(change, message):
    fields = {"theta": [0, 0], "d": [0, 0], "a": [1, 1], "alpha": [0, 0], "beta": [0, 0], "hayati": (True, False)}
    with pytest.raises(InputError, match=message):
        MDHChain(**(fields | change))


@pytest.mark.parametrize("names", [["theta7"], ["gamma1"], ["theta1", "theta1"]])
def test_unknown_parameter_names_are_refused(names):
    with pytest.raises(InputError, match="parameter"):
        parameters_by_name(find_arm("mh6").chain, names)
