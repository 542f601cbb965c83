"""The same cell and seams give the same plan on every processor: round-off does not choose between equal ways."""

import json
import sys

import numpy as np
import pytest

from tests.one_robot_cells import TEE, one_robot_record, with_positioner, write_cell
from tests.running import run_command
from tests.saddle import CELLS
from wpcal.core.ladder import cheapest_way
from wpcal.core.same_bits import arc_tangent, first_least, inverse_pose, product, ranked, sine_cosine, solve
from wpcal.core.tangent import exp_rotation
from wpcal.planning.plan.banded import solve_chain
from wpcal.planning.sequence.seam_search import steps_of_branch

PROCESSORS = (
    {"OPENBLAS_CORETYPE": "Haswell"},
    {"OPENBLAS_CORETYPE": "SkylakeX"},
    {"OPENBLAS_CORETYPE": "Zen"},
    {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL X86_V3"},
)
"""Kernels of OpenBLAS, and the last one without the wide instructions of NumPy."""
ROUND_OFF = 1e-15
SOLVED = 1e-12
NOISE = 1e-12  #: Share of a cost: what kernels differ by, after some thousand sums.
TWO_ROBOTS = ["two-mh6-tee.json", str(TEE / "seams.json"), "--seam", "W2", "--arc", "on"]


@pytest.mark.deep
@pytest.mark.parametrize("cell", ["two robots", "saddle", "one robot", "positioner"])
def test_every_processor_gives_the_same_files(cell, tmp_path):
    pytest.importorskip("fcl", reason="python-fcl is not installed")
    if cell == "two robots":
        asked = [str(CELLS / TWO_ROBOTS[0]), *TWO_ROBOTS[1:], "--welds", str(TEE.parent / "welds.json")]
    elif cell == "saddle":  # the page shows more states, so a digit at the end of one is likelier to differ
        asked = [str(CELLS / "two-mh6.json"), str(CELLS / "saddle-seams.json"), "--seam", "W1"]
    else:
        fixed = {"xyz_mm": [800, -100, 200], "rpy_deg": [0, 0, 0]}
        record = with_positioner() if cell == "positioner" else one_robot_record(T_world_part=fixed)
        asked = [str(write_cell(tmp_path, record)), str(TEE)]
    found = []
    for number, processor in enumerate(PROCESSORS):
        out = tmp_path / str(number)
        code = f"from wpcal.cli.main import run; run({['plan', *asked, '-o', str(out)]})"
        done = run_command(sys.executable, "-c", code, timeout_s=900, **processor)
        assert (out / "plan.json").exists(), done.stderr
        found.append({path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()})
    for processor, files in zip(PROCESSORS, found, strict=True):
        assert sorted(files) == sorted(found[0])
        assert [name for name in files if files[name] != found[0][name]] == [], processor


def test_kernels_do_not_change_the_arithmetic_of_a_search():
    code = (
        "import json, numpy as np; from wpcal.core.same_bits import *; r = np.random.default_rng(0)\n"
        "A, v = r.normal(size=(50, 9, 9)), r.normal(size=(2, 5000))\n"
        "all = [product(A, A), solve(A, A)[0], *sine_cosine(v), arc_tangent(*v)]\n"
        "print(json.dumps([a.tobytes().hex() for a in all]))"
    )
    texts = [run_command(sys.executable, "-c", code, **one).stdout for one in PROCESSORS[1::2]]
    assert len(json.loads(texts[0])) == 5
    assert texts[0] == texts[1]


def test_costs_that_differ_by_round_off_are_equal_and_the_first_is_taken():
    rng = np.random.default_rng(0)
    costs = np.repeat(rng.uniform(1.0, 5.0, (200, 1)), 4, axis=1)
    costs[:, 2:] += 1e-3
    for sign in (1.0, -1.0):
        shaken = costs * (1.0 + sign * NOISE * rng.uniform(size=costs.shape))
        assert (first_least(shaken, axis=1) == 0).all()
    costs[:, 3] -= 2e-3
    assert (first_least(costs, axis=1) == 3).all()
    assert ranked([np.inf, 1.0, 1.0 + NOISE]).tolist()[1:] == ranked([1.0, 1.0]).tolist()
    assert first_least([np.inf, np.inf]) == 0
    assert first_least([0.0, 0.0]) == 0


def test_round_off_of_the_joints_leaves_the_way_over_a_ladder():
    """Two branches of a symmetric wrist cost the same on every rung."""
    rng = np.random.default_rng(1)
    one = np.cumsum(rng.uniform(-0.2, 0.2, (12, 1, 6)), axis=0)
    joints = np.concatenate([one, -one, one + np.pi, -one - np.pi], axis=1)
    usable, off = np.ones((12, 4), dtype=bool), np.zeros((12, 4))
    shaken = [joints + NOISE * rng.uniform(-1, 1, joints.shape) for _ in range(20)]
    ways = [cheapest_way(list(off), steps_of_branch(each, usable, np.ones(6))) for each in shaken]
    assert ways == [[0] * 12] * 20


def test_sines_and_arc_tangents_are_those_of_numpy_to_round_off():
    rng = np.random.default_rng(2)
    angle = np.concatenate([rng.uniform(-60.0, 60.0, 20_000), np.arange(-40, 41) * np.pi / 4, [0.0, 1e-300, -1e-9]])
    for ours, numpys in zip(sine_cosine(angle), (np.sin(angle), np.cos(angle)), strict=True):
        np.testing.assert_allclose(ours, numpys, rtol=0, atol=ROUND_OFF)
    y, x = rng.normal(size=(2, 20_000)) * np.exp(4.0 * rng.normal(size=(2, 20_000)))
    np.testing.assert_allclose(arc_tangent(y, x), np.arctan2(y, x), rtol=0, atol=ROUND_OFF)
    signs = np.array([[y, x] for y in (0.0, -0.0, 1.0, -1.0) for x in (0.0, -0.0, 1.0, -1.0)]).T
    assert arc_tangent(*signs).tolist() == np.arctan2(*signs).tolist()
    assert np.isnan(arc_tangent(np.nan, 1.0))


def test_products_and_solutions_are_those_of_numpy():
    rng = np.random.default_rng(3)
    for one, other in [((3, 4), (4,)), ((4,), (4,)), ((4,), (4, 3)), ((5, 3, 3), (3, 3)), ((4, 4), (5, 4, 2))]:
        a, b = rng.normal(size=one), rng.normal(size=other)
        np.testing.assert_allclose(product(a, b), a @ b, rtol=0, atol=SOLVED)
    A, b = rng.normal(size=(50, 6, 6)), rng.normal(size=(50, 6, 2))
    A[0, 0, 0] = 0.0
    x, det = solve(A, b)
    np.testing.assert_allclose(A @ x, b, rtol=0, atol=SOLVED * 1e3)
    np.testing.assert_allclose(det, np.abs(np.linalg.det(A)), rtol=1e-9, atol=0)
    T = np.tile(np.eye(4), (5, 1, 1))
    T[:, :3, :3], T[:, :3, 3] = exp_rotation(rng.normal(size=(5, 3))), rng.normal(size=(5, 3))
    np.testing.assert_allclose(inverse_pose(T) @ T, np.tile(np.eye(4), (5, 1, 1)), rtol=0, atol=SOLVED)


@pytest.mark.parametrize("n", [1, 2, 3, 4, 9, 16, 73])
def test_a_chain_of_blocks_is_solved(n):
    rng, k = np.random.default_rng(n), 4
    half, coupling = rng.normal(size=(n, k, k)), 0.3 * rng.normal(size=(n - 1, k, k))
    diagonal = half @ np.swapaxes(half, 1, 2) + 3.0 * np.eye(k)
    whole = np.zeros((n * k, n * k))
    for i in range(n):
        here, after = slice(i * k, (i + 1) * k), slice((i + 1) * k, (i + 2) * k)
        whole[here, here] = diagonal[i]
        if i < n - 1:
            whole[here, after], whole[after, here] = coupling[i], coupling[i].T
    right = rng.normal(size=(n, k, 1))
    np.testing.assert_allclose(whole @ solve_chain(diagonal, coupling, right).ravel(), right.ravel(), atol=SOLVED)
