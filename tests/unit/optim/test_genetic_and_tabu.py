import numpy as np

from wpcal.optim import GeneticOptions, TabuOptions, solve_genetic, solve_tabu

LOW, HIGH = np.array([-1.0, -2.0, -3.0]), np.array([1.0, 2.0, 3.0])
TARGET = np.array([0.3, -1.1, 2.2])
FOUND = 1e-4  # the radius shrinks with the cost: 400 iterations on a bowl leave about 1e-5
SHORT = TabuOptions(iterations=400)


def bowl(states):
    """Distance to the target in parts of the bounds: not smooth at its least, as sums of distances are not."""
    return np.linalg.norm((states - TARGET) / (HIGH - LOW), axis=1)


def two_bowls(states):
    """A shallow wide bowl at -0.5 and a deep narrow one at +0.5 of the first coordinate."""
    return np.minimum(0.2 + np.abs(states[:, 0] + 0.5), 5.0 * np.abs(states[:, 0] - 0.5)) + np.abs(states[:, 1])


def test_same_seed_same_answer_and_another_seed_another():
    runs = [solve_genetic(bowl, LOW, HIGH, rng=np.random.default_rng(seed)) for seed in (5, 5, 6)]
    assert runs[0].state.tobytes() == runs[1].state.tobytes() != runs[2].state.tobytes()
    tabu = [solve_tabu(bowl, np.zeros(3), LOW, HIGH, rng=np.random.default_rng(s), options=SHORT) for s in (5, 5, 6)]
    assert tabu[0].state.tobytes() == tabu[1].state.tobytes() != tabu[2].state.tobytes()


def test_both_come_down_and_stay_within_the_bounds():
    seen = []

    def watched(states):
        seen.append(states)
        return bowl(states)

    genetic = solve_genetic(watched, LOW, HIGH, rng=np.random.default_rng(1))
    tabu = solve_tabu(watched, genetic.state, LOW, HIGH, rng=np.random.default_rng(1), options=SHORT)
    states = np.concatenate(seen)
    assert (states >= LOW).all()
    assert (states <= HIGH).all()
    assert (np.diff(genetic.best_costs) <= 0).all()  # the elite passes on
    assert (np.diff(tabu.best_costs) <= 0).all()
    assert len(states) == genetic.evaluations + tabu.evaluations
    assert genetic.cost == bowl(genetic.state[None])[0] == genetic.best_costs[-1]
    assert tabu.cost == bowl(tabu.state[None])[0] == tabu.best_costs[-1]
    assert genetic.cost < 0.05
    np.testing.assert_allclose(tabu.state, TARGET, rtol=0, atol=FOUND)


def test_the_genetic_algorithm_leaves_a_wide_shallow_bowl():
    found = [solve_genetic(two_bowls, LOW, HIGH, rng=np.random.default_rng(seed)).state[0] for seed in range(10)]
    assert sum(abs(x - 0.5) < 0.05 for x in found) >= 9


def test_tabu_search_accepts_worse_places_and_remembers():
    result = solve_tabu(bowl, np.zeros(3), LOW, HIGH, rng=np.random.default_rng(2), options=SHORT)
    assert (np.diff(result.current_costs) > 0).any()
    assert result.forbidden > 0
    assert (result.current_costs >= result.best_costs).all()


def test_a_start_that_is_the_answer_stays():
    result = solve_tabu(bowl, TARGET, LOW, HIGH, rng=np.random.default_rng(3), options=TabuOptions(iterations=5))
    assert result.cost == 0.0
    assert result.state.tolist() == TARGET.tolist()


def test_selection_alone_lets_the_best_take_over():
    options = GeneticOptions(crossover=0.0, mutation_first=0.0, mutation_last=0.0, elite=0)
    result = solve_genetic(bowl, LOW, HIGH, rng=np.random.default_rng(4), options=options)
    np.testing.assert_allclose(result.mean_costs[-1], result.best_costs[-1], rtol=0, atol=1e-12)  # a mean of equals
    assert result.best_costs[-1] < 0.5 * result.mean_costs[0]
