"""Where a function of one number changes its sign. As scipy has it, without the tenth of a second
that its import takes.
"""

from __future__ import annotations

import math
from collections.abc import Callable

# Spacings of floating-point numbers within which a root is known, and the least width where the
# root is 0.
_SPACINGS = 4e-16
_LEAST_WIDTH = 1e-15
# The bracket is halved at least in every other step: from one number to the next takes fewer.
_MOST_STEPS = 200


def zero_between(function: Callable[[float], float], low: float, high: float) -> float:
    """The root of a function that has other signs at `low` and `high`, to rounding.

    Chandrupatla's method: inverse quadratic interpolation where the three last points allow it, and
    halving elsewhere (Chandrupatla 1997, Adv. Eng. Softw. 28, 145).

    >>> round(zero_between(lambda x: x**2 - 2, 1.0, 2.0), 12)
    1.414213562373
    """
    # notation: a the newest point, b the one on the other side of the root, c the point before
    a = low
    b = high
    at_a = function(a)
    at_b = function(b)
    share = 0.5
    for _ in range(_MOST_STEPS):
        x = a + share * (b - a)
        at_x = function(x)
        if math.copysign(1.0, at_x) == math.copysign(1.0, at_a):
            c = a
            at_c = at_a
        else:
            c = b
            at_c = at_b
            b = a
            at_b = at_a
        a = x
        at_a = at_x
        best = a if abs(at_a) < abs(at_b) else b
        width = _SPACINGS * abs(best) + _LEAST_WIDTH
        if 0.0 in (at_a, at_b) or abs(b - a) <= width:
            return best
        distance = (a - b) / (c - b)
        height = (at_a - at_b) / (at_c - at_b)
        share = 0.5
        if height**2 < distance and (1 - height) ** 2 < 1 - distance:
            from_b = at_a / (at_b - at_a) * at_c / (at_b - at_c)
            from_c = (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
            share = from_b + from_c
        least_share = width / (2 * abs(b - a))
        share = min(max(share, least_share), 1 - least_share)
    return best
