"""One Cholesky factor for every set of nodes: against a dense solution of each set, and no second factorisation."""

from collections import Counter

import numpy as np
import pytest

from halfplane_fe.active_subsets import NestedFactor
from problems import fe_run
from scenes import ConvergenceError, load_scene

X = np.sort(np.random.default_rng(3).uniform(-1, 1, 60))
MATRIX = 2.0 - np.log(np.abs(X[:, None] - X) + 0.02)  # a logarithmic compliance, like that of a half-plane

SETS = {
    "all": np.ones(60, dtype=bool),
    "about the middle": np.abs(X) < 0.6,
    "one node": np.arange(60) == 41,
    "to the right": np.abs(X - 0.2) < 0.5,
    "two islands": np.abs(X) > 0.5,
    "a hole": (np.abs(X) < 0.8) & (np.arange(60) != 30),
    "an outlier": (np.abs(X) < 0.3) | (np.arange(60) == 58),
    "both": (np.abs(X) < 0.5) ^ (np.arange(60) % 9 == 0),
}


@pytest.mark.parametrize("active", SETS.values(), ids=SETS.keys())
def test_any_set_is_solved_as_if_it_had_its_own_factor(active):
    work = Counter()
    factor = NestedFactor(MATRIX, X, np.ones(len(X)), work)
    known = np.sin(3 * X[active]) + 2
    for right, found in ((known, factor.solve(active, known)), (1.0, factor.by_border(active))):
        exact = np.linalg.solve(MATRIX[np.ix_(active, active)], np.broadcast_to(right, known.shape))
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
    assert work["factorisations"] == 1


def test_a_symmetric_set_needs_no_update_and_another_one_needs_it_once():
    work = Counter()
    factor = NestedFactor(MATRIX, X, np.ones(len(X)), work)
    for _ in range(3):
        factor.solve(SETS["about the middle"], np.ones(SETS["about the middle"].sum()))
        assert work["factor updates"] == 0
    for _ in range(3):
        factor.solve(SETS["two islands"], np.ones(SETS["two islands"].sum()))
    assert work["factor updates"] == 1


def test_a_matrix_that_is_not_positive_definite_is_refused():
    with pytest.raises(ConvergenceError, match="not positive definite"):
        NestedFactor(-MATRIX, X, np.ones(len(X)), Counter())


def test_a_cycle_of_like_bodies_takes_two_dense_factorisations():
    """One of the normal compliance, one of the tangential, whatever the number of increments."""
    counts = fe_run(load_scene("hertz-paper")).work.counts
    assert counts["factorisations"] == 2
    assert counts["factor updates"] < counts["linear solves"] / 4
    assert counts["linear solves"] > counts["steps solved"]
