r"""Solutions of M_AA f = b for many sets A of nodes from one Cholesky factor of M, updated as by Sherman-Morrison-Woodbury.

With the nodes ordered from the middle of the contact outwards, M = L L^T, the factor of the first k of them is the leading block of
L: every contact and every stick zone that is symmetric about the middle needs no factorisation of its own. Any other set is such a
prefix P with a few nodes D too many and a few nodes E too few. With a reaction r on D that makes f vanish there,

    M_PP f_P + M_PE f_E = b_P + I_D r,    M_EP f_P + M_EE f_E = b_E,    f_D = 0,

which is m = |D| + |E| columns of triangular solves, C = [I_D, -M_PE], and one m by m system:

    (C^T M_PP^-1 C - diag(0, M_EE)) (r, f_E) = -C^T M_PP^-1 b_P - (0, b_E).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky, lu_factor, lu_solve
from scipy.linalg.lapack import dtrtrs

from halfplane_fe.kept import Kept
from scenes import ConvergenceError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Bytes of corrections kept: a cycle meets the same sets of nodes again and again.
_KEPT_BYTES = 100_000_000


@dataclass(eq=False)
class _Correction:
    """What it takes to go from a prefix of `size` nodes to a set: M_PP^-1 C and the factors of the m by m system.

    `dropped` (in the prefix) and `added` (beyond it) are places in the order of elimination.
    """

    size: int
    dropped: Indices
    added: Indices
    solved: Array  # (size, m)
    coupling: Array  # (size, |E|), M_PE
    factors: tuple[Array, Array] | None
    by_border: Array | None = None

    @property
    def nbytes(self) -> int:
        """What it takes to keep it, roughly."""
        return self.solved.nbytes + self.coupling.nbytes + 16 * self.size


class NestedFactor:
    """One Cholesky factor of a symmetric positive definite matrix, serving any subset of its rows.

    Parameters
    ----------
    matrix : (n, n)
    x : (n,) places of the nodes, contact and stick zone lying about 0
    border : (n,) a right-hand side that every set is solved for
    work : counts "factorisations" (of n^3) and "factor updates" (of m n^2)

    Raises
    ------
    ConvergenceError
        If the matrix is not positive definite.

    >>> factor = NestedFactor(np.array([[2.0, 1.0], [1.0, 4.0]]), np.array([0.0, 1.0]), np.ones(2), Counter())
    >>> factor.solve(np.array([False, True]), np.array([8.0]))
    array([2.])
    """

    def __init__(self, matrix: Array, x: Array, border: Array, work: Counter[str]) -> None:
        self._order = np.argsort(np.abs(x), kind="stable")
        self._matrix, self._border = matrix, border
        self._work = work
        try:
            lower = cholesky(matrix[np.ix_(self._order, self._order)], lower=True, check_finite=False)
        except LinAlgError as reason:
            raise ConvergenceError(f"contact: the compliance of the contact nodes is not positive definite: {reason}") from reason
        self._lower = np.asfortranarray(lower)  # so that its leading columns go to LAPACK without a copy
        self._work["factorisations"] += 1
        self._kept: Kept[_Correction] = Kept(_KEPT_BYTES)

    def solve(self, active: Mask, known: Array) -> Array:
        """f (n_active,) with M_AA f = known, rows by ascending node number."""
        self._work["linear solves"] += 1
        right = np.zeros(len(active))
        right[active] = known
        return self._solve(self._correction(active), right[self._order])[active]

    def by_border(self, active: Mask) -> Array:
        """f (n_active,) with M_AA f = border; kept, since every load on a set needs it."""
        correction = self._correction(active)
        if correction.by_border is None:
            correction.by_border = self._solve(correction, np.where(active, self._border, 0.0)[self._order])[active]
        return correction.by_border

    def _solve(self, correction: _Correction, right: Array) -> Array:
        """The solution (n,) by node number, zero off the set; `right` (n,) in the order of elimination, zero off the set."""
        base = self._prefix_solve(right[: correction.size])
        found = np.zeros_like(right)
        if correction.factors is not None:
            reaction = np.concatenate([-base[correction.dropped], correction.coupling.T @ base - right[correction.added]])
            extra = lu_solve(correction.factors, reaction, check_finite=False)
            base += correction.solved @ extra
            base[correction.dropped] = 0.0
            found[self._order[correction.added]] = extra[len(correction.dropped) :]
        found[self._order[: correction.size]] = base
        return found

    def _prefix_solve(self, right: Array) -> Array:
        """M_PP^-1 right, P the first len(right) nodes of the order."""
        if not len(right):
            return right
        columns = self._lower[:, : len(right)]
        half, _ = dtrtrs(columns, right, lower=1)
        solved, _ = dtrtrs(columns, half, lower=1, trans=1)
        return np.asarray(solved)

    def _correction(self, active: Mask) -> _Correction:
        key = active.tobytes()
        if (known := self._kept.get(key)) is not None:
            return known
        made = self._make(active[self._order])
        return self._kept.put(key, made, made.nbytes)

    def _make(self, wanted: Mask) -> _Correction:
        """The correction of the prefix that differs least from the set; `wanted` is in the order of elimination."""
        differing = np.concatenate([[0], np.cumsum(~wanted)]) + np.concatenate([np.cumsum(wanted[::-1])[::-1], [0]])
        size = int(np.argmin(differing))
        dropped = np.flatnonzero(~wanted[:size])
        added = size + np.flatnonzero(wanted[size:])
        n_dropped, n_added = len(dropped), len(added)
        coupling = self._matrix[np.ix_(self._order[:size], self._order[added])]
        if n_dropped + n_added == 0:
            return _Correction(size, dropped, added, np.empty((size, 0)), coupling, None)
        self._work["factor updates"] += 1
        columns = np.zeros((size, n_dropped + n_added), order="F")
        columns[dropped, np.arange(n_dropped)] = 1.0
        columns[:, n_dropped:] = -coupling
        solved = self._prefix_solve(columns)
        small = columns.T @ solved
        places = self._order[added]
        small[n_dropped:, n_dropped:] -= self._matrix[np.ix_(places, places)]
        return _Correction(size, dropped, added, solved, coupling, lu_factor(small, check_finite=False))
