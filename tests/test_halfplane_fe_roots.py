"""Where a function changes its sign: to rounding, in as few evaluations as scipy's."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from halfplane_fe.roots import zero_between

FUNCTIONS: dict[str, Callable[[float], float]] = {
    "next to linear": lambda x: x * (1 + 0.3 * math.sin(9 * x)),
    "saturates": lambda x: math.atan(300 * x),
    "triple root": lambda x: x**3 + 1e-9 * x,
    "grows by e^40": lambda x: math.expm1(20 * x),
    "falls": lambda x: -math.sinh(x),
}


@pytest.mark.parametrize("function", FUNCTIONS.values(), ids=FUNCTIONS)
def test_a_root_is_found_to_rounding_in_as_few_evaluations_as_by_brent(
    function: Callable[[float], float],
) -> None:
    evaluations = {zero_between: 0, brentq: 0}
    ends = np.random.default_rng(1).uniform(0.01, 2.0, (50, 2))
    for solver, options in ((zero_between, {}), (brentq, {"xtol": 1e-15, "rtol": 8.9e-16})):
        for below, above in ends.tolist():
            root = below / 3 - above / 5

            def counted(
                x: float, root: float = root, solver: Callable[..., float] = solver
            ) -> float:
                evaluations[solver] += 1
                return function(x - root)

            assert abs(solver(counted, root - below, root + above, **options) - root) < 2e-15
    assert evaluations[zero_between] <= 1.2 * evaluations[brentq]
