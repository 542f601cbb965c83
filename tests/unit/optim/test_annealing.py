import numpy as np
import pytest

from wpcal.core import InputError
from wpcal.optim import AnnealingSchedule, Neighbourhood, StopReason, anneal
from wpcal.optim.annealing import first_temperature
from wpcal.optim.search_box import SearchBox

BOX = SearchBox.of(np.full(2, -5.0), np.full(2, 5.0))


def rastrigin(states):
    return 10 * states.shape[1] + np.sum(states**2 - 10 * np.cos(2 * np.pi * states), axis=1)


def test_the_first_temperature_follows_from_the_sampled_costs():
    costs = np.array([1.0, 2.0, 6.0])
    t0 = first_temperature(costs, 0.95)
    assert np.exp((costs.mean() - costs.max()) / t0) == pytest.approx(0.95, rel=0, abs=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_the_global_minimum_among_many_local_ones_is_found(seed):
    report = anneal(rastrigin, BOX, rng=np.random.default_rng(seed))
    assert report.cost < 1e-2
    assert np.abs(report.state).max() < 1e-2


def test_the_published_schedule_has_the_printed_numbers():
    s = AnnealingSchedule.yin2003()
    assert (s.chains, s.samples, s.initial_acceptance, s.cooling) == (1, 120, 0.95, 0.85)
    assert (s.first_step, s.step_change, s.neighbourhood) == (0.01, 0.0002, Neighbourhood.LINEAR)


def test_the_trace_tells_every_temperature():
    report = anneal(rastrigin, BOX, rng=np.random.default_rng(0), schedule=AnnealingSchedule(cooling=0.8))
    t = report.trace.temperature
    assert np.allclose(t[1:] / t[:-1], 0.8, rtol=0, atol=1e-12)
    assert (np.diff(report.trace.best_cost) <= 0).all()
    assert report.trace.best_cost[-1] == report.cost
    assert report.temperatures == len(t) == AnnealingSchedule().most_temperatures


def test_chains_grow_as_it_cools():
    lengths = []

    def counted(states):
        lengths.append(len(states))
        return rastrigin(states)

    schedule = AnnealingSchedule(chains=1, least_moves=10, most_moves=200, most_acceptances=20, least_temperatures=40)
    report = anneal(counted, BOX, rng=np.random.default_rng(0), schedule=schedule)
    assert report.evaluations == sum(lengths)
    assert report.trace.accepted[0] > 0.8
    assert report.evaluations < 0.9 * 200 * report.temperatures


def test_it_settles_when_the_best_rests():
    schedule = AnnealingSchedule(least_temperatures=5, most_temperatures=60, tolerance=1e9)
    report = anneal(rastrigin, BOX, rng=np.random.default_rng(0), schedule=schedule)
    assert (report.stop, report.temperatures) == (StopReason.SETTLED, 5)


def test_states_stay_in_the_box_and_periodic_ones_wrap():
    seen = []

    def cost(states):
        seen.append(states)
        return np.abs(np.angle(np.exp(1j * (states[:, 0] - 3.1)))) + (states[:, 1] - 9.0) ** 2

    box = SearchBox.of([-np.pi, 0.0], [np.pi, 5.0], [True, False])
    report = anneal(cost, box, rng=np.random.default_rng(1))
    everything = np.vstack(seen)
    assert np.abs(report.state[0]) <= np.pi  # the cost may see a little more than a turn
    assert (everything[:, 1] >= 0).all()
    assert (everything[:, 1] <= 5).all()
    assert report.state == pytest.approx([3.1, 5.0], rel=0, abs=1e-2)


def test_equal_costs_everywhere_end_quietly():
    report = anneal(lambda states: np.ones(len(states)), BOX, rng=np.random.default_rng(0))
    assert report.cost == 1.0


@pytest.mark.parametrize(
    "options", [{"chains": 0}, {"cooling": 1.0}, {"least_moves": 9, "most_moves": 3}, {"least_step": 0.0}]
)
def test_a_schedule_that_is_none_is_refused(options):
    with pytest.raises(InputError, match="annealing schedule"):
        AnnealingSchedule(**options)


def test_an_empty_box_is_refused():
    with pytest.raises(InputError, match="box"):
        SearchBox.of([0.0, 0.0], [0.0, 1.0])
