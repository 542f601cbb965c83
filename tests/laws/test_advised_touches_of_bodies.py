"""Touches chosen for moved bodies, simulated on the full model: what they gain, and whether their promise holds."""

import pytest

from tests.benchmarks.bench_advise_bodies import compared, opened


def test_chosen_touches_of_the_uprights_are_better_than_two_on_each_plate_and_the_promise_holds() -> None:
    found = compared(opened("uprights"), runs=16)
    chosen = found["chosen for bodies"]
    assert chosen.worst_mm <= 0.6 * found["two on each plate"].worst_mm  # 0.38 in 400 weldments
    assert chosen.worst_mm <= 0.4 * found["chosen as one body"].worst_mm  # 0.22
    assert 0.85 <= chosen.covered <= 1.0


@pytest.mark.deep
@pytest.mark.parametrize("name", ["uprights", "drawbar"])
def test_the_promise_of_chosen_touches_covers(name: str) -> None:
    found = compared(opened(name), runs=300)
    assert found["chosen for bodies"].worst_mm <= found["two on each plate"].worst_mm
    for one in found.values():
        assert 0.93 <= one.covered <= 0.97
