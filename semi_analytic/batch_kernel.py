"""Friction work of many steady ellipses by one rule: as few passes over the nodes as there can be.

# notation: letters as in `batch`; h = D/2, g = (pi - D)/2, y node of [0, 1], nodes along axis 0, members along axis 1;
#           alpha = sqrt(2 P1) sin(t_E/2), beta = sqrt(2 P1) cos(t_E/2), k = 4 alpha beta = 4 P1 sin(t_E)

With S = sin(h y), C = cos(h y) at the nodes and a bar for the node 1 - y, which is one of the same rule:

    E-G  s = D (1 - y)    rate 2 f v S C       P_c = P_T + v S^2                  P - P_c = u S-bar^2
    J-M  s = D y          rate 2 f u S C       P_c = P_T + u S^2                  P - P_c = v S-bar^2 + k S C
    I-J  s = 2 g y        rate 2 f u s c       P_c = P_min + (alpha c - beta s)^2   P - P_c = k s c,   s, c = sin, cos (g y)

No difference is taken but one that is squared. One tangent a node stands for sine and cosine: numpy has it in vector code.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Area = Callable[[Array, Array, Array], Array]
"""Some multiple of Lam(P, P_c) from P_c, P - P_c and a free array of their shape; may overwrite all but the second."""

ROWS = 9
"""h, g, P_T, P_min, u, v, alpha, beta, k."""

_ELEMENTS = 16384


class Room:
    """Memory for one call of `sums`, used again and again: what is not fetched anew stays in the cache."""

    def __init__(self) -> None:
        self._memory = np.empty(0)

    def of(self, *shape: int) -> Array:
        """An array of that shape, with whatever is in it."""
        size = math.prod(shape)
        if len(self._memory) < size:
            self._memory = np.empty(size)
        return self._memory[:size].reshape(shape)


def members_at_once(nodes: int) -> int:
    """How many members make arrays that fit into the cache."""
    return max(_ELEMENTS // nodes, 64)


def sums(loops: Array, nodes: Array, weights: Array, area: Area, room: Room) -> tuple[Array, Array, Array]:
    """Weighted sums of `area` times S C in E-G and J-M, times P - P_c in I-J; `loops` (9, m) are rows h to k. Arrays (m,)."""
    half, rest, permanent, least, u, v, alpha, beta, k = loops
    front, slipped, (tangent, both, spare), free = room.of(4, 3, len(nodes), len(half))
    column = nodes[:, None]
    np.multiply(column, half, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, tangent, out=spare)
    spare += 1
    np.divide(tangent, spare, out=both)
    tangent *= both  # S^2
    np.multiply(tangent, v, out=front[0])
    np.multiply(tangent, u, out=front[1])
    np.multiply(both, k, out=slipped[1])
    slipped[1] += front[0][::-1]
    slipped[0] = front[1][::-1]
    front[:2] += permanent
    _early(column, (rest, least, alpha, beta, k), front[2], slipped[2], (tangent, spare))
    worth = area(front, slipped, free)
    worth[:2] *= both
    worth[2] *= slipped[2]
    return weights @ worth[0], weights @ worth[1], weights @ worth[2]


def _early(column: Array, loops: tuple[Array, ...], front: Array, slipped: Array, free: tuple[Array, Array]) -> None:
    """P_c and P - P_c of I-J, in place."""
    rest, least, alpha, beta, k = loops
    tangent, spare = free
    np.multiply(column, rest, out=tangent)
    np.tan(tangent, out=tangent)
    np.multiply(tangent, beta, out=front)
    np.subtract(alpha, front, out=front)
    front *= front
    np.multiply(tangent, tangent, out=spare)
    spare += 1
    front /= spare
    front += least
    np.divide(tangent, spare, out=slipped)
    slipped *= k


def bracket(front: Array, slipped: Array, free: Array) -> Array:
    """P ln(P/P_c) - P + P_c, to rounding of P - P_c: n Lam of the power law |x|^n, 2 Lam of Hertz."""
    np.divide(slipped, front, out=free)
    np.log1p(free, out=free)
    front += slipped
    free *= front
    free -= slipped
    return free
