"""Linear systems of many active sets from one factor (Sherman-Morrison-Woodbury), with a cache bounded in bytes.

Like bodies (`NestedFactor`): solutions of M_AA f = b for many sets A of nodes from one Cholesky factor of M.

With the nodes ordered from the middle of the contact outwards, M = L L^T, the factor of the first k of them is the leading block of
L: every contact and every stick zone that is symmetric about the middle needs no factorisation of its own. Any other set is such a
prefix P with a few nodes D too many and a few nodes E too few. With a reaction r on D that makes f vanish there,

    M_PP f_P + M_PE f_E = b_P + I_D r,    M_EP f_P + M_EE f_E = b_E,    f_D = 0,

which is m = |D| + |E| columns of triangular solves, C = [I_D, -M_PE], and one m by m system:

    (C^T M_PP^-1 C - diag(0, M_EE)) (r, f_E) = -C^T M_PP^-1 b_P - (0, b_E).

Unlike bodies (`CoupledFactor`): normal and tangential problem in one system, for many sets of node states.

Unknowns z = (p, q, delta, U); each node has two rows, by its state:

    open    p = 0,             q = 0
    stick   gap = 0,           slip = known
    slip    gap = 0,           q - (+-f) p = 0

and two rows for the loads; U = 0 is the second where Q is zero by symmetry. A state of a node is a choice of rows, so that the
matrix A of a set differs from that of a base set, A_0, in a few rows R alone. With E the unit columns of those rows and R_1 the
rows as the set has them,

    z = A_0^-1 (b - E E^T b) + A_0^-1 E y,    (R_1 A_0^-1 E) y = b_R - R_1 A_0^-1 (b - E E^T b),

which is a column A_0^-1 e of the base for each changed row, kept with it, and one small system.
"""

from __future__ import annotations

import warnings
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, LinAlgWarning, cholesky, lu_factor, lu_solve
from scipy.linalg.lapack import dtrtrs

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK, ConvergenceError

T = TypeVar("T")


class Kept(Generic[T]):
    """Values by key; what was asked for last is forgotten last.

    >>> kept = Kept(bound=10)
    >>> for key in (b"a", b"b"):
    ...     _ = kept.put(key, key.decode(), 6)
    >>> kept.get(b"a"), kept.get(b"b")
    (None, 'b')
    """

    def __init__(self, bound: int) -> None:
        self._bound, self._bytes = bound, 0
        self._values: OrderedDict[bytes, tuple[T, int]] = OrderedDict()

    def get(self, key: bytes) -> T | None:
        """The value, which thereby counts as used; None where there is none."""
        if key not in self._values:
            return None
        self._values.move_to_end(key)
        return self._values[key][0]

    def put(self, key: bytes, value: T, nbytes: int) -> T:
        """Keep a value of so many bytes, in place of one that the key may have had, and give it back."""
        self._bytes -= self._values.pop(key, (None, 0))[1]
        self._values[key] = value, nbytes
        self._bytes += nbytes
        while self._bytes > self._bound and len(self._values) > 1:
            self._bytes -= self._values.popitem(last=False)[1][1]
        return value

    def keep_only(self, wanted: Callable[[T], bool]) -> None:
        """Forget all other values."""
        for key in [key for key, (value, _) in self._values.items() if not wanted(value)]:
            self._bytes -= self._values.pop(key)[1]

    def items(self) -> Iterable[tuple[bytes, T]]:
        """All there is."""
        return ((key, value) for key, (value, _) in self._values.items())


Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

# Bytes of corrections kept: a cycle meets the same sets of nodes again and again.
_PREFIX_BYTES = 100_000_000


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
    latest: tuple[Array, Array] | None = None  # right-hand side and solution

    @property
    def nbytes(self) -> int:
        """What it takes to keep it, roughly."""
        return self.solved.nbytes + self.coupling.nbytes + 32 * self.size


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
        self._kept: Kept[_Correction] = Kept(_PREFIX_BYTES)

    def solve(self, active: Mask, known: Array) -> Array:
        """f (n_active,) with M_AA f = known, rows by ascending node number; that of the latest `known` of a set is kept.

        The initial gap comes again with every load on a set of closed nodes.
        """
        correction = self._correction(active)
        if correction.latest is None or not np.array_equal(correction.latest[0], known):
            self._work["linear solves"] += 1
            right = np.zeros(len(active))
            right[active] = known
            correction.latest = known, self._solve(correction, right[self._order])[active]
        return correction.latest[1]

    def by_border(self, active: Mask) -> Array:
        """f (n_active,) with M_AA f = border; kept, since every load on a set needs it."""
        correction = self._correction(active)
        if correction.by_border is None:
            self._work["linear solves"] += 1
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


States = NDArray[np.int8]
Factors = tuple[Array, Array]

# Rows in which a set may differ from its base: beyond that the set becomes a base itself.
_MOST_ROWS = 48
# Bytes kept, of bases and of what sets add to them: a cycle meets the same sets of nodes again and again.
_COUPLED_BYTES = 300_000_000


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""


class Rows(NamedTuple):
    """What the rows of a set of states say: which nodes are closed, which stick, and q over p of the others."""

    closed: Mask
    stick: Mask
    traction: Array

    def differing(self, other: Rows) -> Mask:
        """(2 n,) rows in which two sets differ."""
        tangential = (self.stick != other.stick) | (self.traction != other.traction)
        return np.concatenate([self.closed != other.closed, tangential])


@dataclass(eq=False)
class _Base:
    rows: Rows
    factors: Factors
    columns: dict[int, Array] = field(default_factory=dict)  # A_0^-1 e of a row, (2 n + 2,)


@dataclass(frozen=True, eq=False)
class _Change:
    """From a base to a set: the changed rows, A_0^-1 E and the factors of the small system."""

    base: _Base
    changed: Indices
    columns: Array
    factors: Factors | None


@dataclass(eq=False)
class CoupledFactor:
    """Solves the coupled system of any set of states.

    Attributes
    ----------
    interface : normals and coupling
    normal, tangential : (n, n) compliance of interface and layer
    friction : coefficient f
    work : counts "linear solves", "factorisations" (of n^3) and "factor updates" (of m n^2)
    """

    interface: Interface
    normal: Array
    tangential: Array
    coupling: Array
    friction: float
    work: Counter[str]

    def __post_init__(self) -> None:
        self._bases: Kept[_Base] = Kept(_COUPLED_BYTES)
        self._changes: Kept[_Change] = Kept(_COUPLED_BYTES)

    def solve(self, states: States, gap: Array, slip: Array, loads: tuple[float, float]) -> tuple[Array, Array, float, float]:
        """p, q, approach and shift with the given gap at closed nodes and the given slip at sticking ones, each (n,).

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.
        """
        self.work["linear solves"] += 1
        rows, change = self._rows(states), self._change(states)
        right = np.concatenate([np.where(rows.closed, gap, 0.0), np.where(rows.stick, slip, 0.0), loads])
        wanted = right[change.changed]
        right[change.changed] = 0.0
        found = self._solve(change.base, right[:, None])[:, 0]
        if change.factors is not None:
            lacking = wanted - self._values(rows, change.changed, found[:, None])[:, 0]
            found += change.columns @ lu_solve(change.factors, lacking, check_finite=False)
        n = len(states)
        pressure = np.where(rows.closed, found[:n], 0.0)
        shear = np.where(rows.stick, found[n : 2 * n], rows.traction * pressure)
        return pressure, shear, float(found[-2]), float(found[-1])

    def _rows(self, states: States) -> Rows:
        return Rows(
            states != OPEN,
            states == STICK,
            np.asarray(slip_sign(states) * self.friction, dtype=np.float64),
        )

    def _change(self, states: States) -> _Change:
        """How to get to a set of states: kept, from the base nearest to it, or by making it a base."""
        key = states.tobytes()
        if (known := self._changes.get(key)) is not None:
            return known
        rows = self._rows(states)
        if not rows.stick.any():  # not left to the factors: an update of a base makes a pivot of rounding from one that is zero
            raise SingularSet("no node sticks: the bodies slide on each other")
        made = self._from(self._nearest(rows) or self._new_base(key, rows), rows)
        return self._changes.put(key, made, made.columns.nbytes)

    def _nearest(self, rows: Rows) -> _Base | None:
        """The base that differs in the fewest rows, if they are few enough."""
        distance = {key: int(base.rows.differing(rows).sum()) for key, base in self._bases.items()}
        near = min(distance, key=distance.__getitem__, default=b"")
        return self._bases.get(near) if distance.get(near, _MOST_ROWS + 1) <= _MOST_ROWS else None

    def _new_base(self, key: bytes, rows: Rows) -> _Base:
        factors = _lu(self._matrix(rows))
        self.work["factorisations"] += 1
        # With all the columns that it can come to; and a change holds its base, so that it must not outlive it.
        base = self._bases.put(key, _Base(rows, factors), factors[0].nbytes + 8 * (2 * len(rows.closed) + 2) ** 2)
        kept = {id(one) for _, one in self._bases.items()}
        self._changes.keep_only(lambda change: id(change.base) in kept)
        return base

    def _from(self, base: _Base, rows: Rows) -> _Change:
        changed = np.flatnonzero(base.rows.differing(rows))
        n = len(rows.closed)
        if not len(changed):
            return _Change(base, changed, np.empty((2 * n + 2, 0)), None)
        self.work["factor updates"] += 1
        missing = np.array(sorted(set(changed.tolist()) - base.columns.keys()), dtype=np.int64)
        units = np.zeros((2 * n + 2, len(missing)))
        units[missing, np.arange(len(missing))] = 1.0
        base.columns.update(zip(missing.tolist(), self._solve(base, units).T, strict=True))
        columns = np.stack([base.columns[int(row)] for row in changed], axis=1)
        return _Change(base, changed, columns, _lu(self._values(rows, changed, columns)))

    def _matrix(self, rows: Rows) -> Array:
        """Rows: gap of closed nodes, slip of sticking ones, the two loads; columns: p, q of the same, approach, shift."""
        closed, stick, traction = rows
        n_x, n_y = self.interface.normals
        by_pressure = self.normal - self.coupling.T * traction  # gap by p, sliding nodes taking their q along
        slip_by_pressure = self.coupling - self.tangential * traction
        n, m = int(closed.sum()), int(stick.sum())
        matrix = np.zeros((n + m + 2, n + m + 2))
        matrix[:n, :n] = by_pressure[np.ix_(closed, closed)]
        matrix[:n, n : n + m] = -self.coupling.T[np.ix_(closed, stick)]
        matrix[:n, n + m], matrix[:n, n + m + 1] = -n_y[closed], n_x[closed]
        matrix[n : n + m, :n] = slip_by_pressure[np.ix_(stick, closed)]
        matrix[n : n + m, n : n + m] = -self.tangential[np.ix_(stick, stick)]
        matrix[n : n + m, n + m], matrix[n : n + m, n + m + 1] = n_x[stick], n_y[stick]
        matrix[n + m, :n], matrix[n + m, n : n + m] = (n_y + traction * n_x)[closed], n_x[stick]
        if self.interface.guided:
            matrix[n + m + 1, n + m + 1] = 1.0
        else:
            matrix[n + m + 1, :n], matrix[n + m + 1, n : n + m] = (traction * n_y - n_x)[closed], n_y[stick]
        return matrix

    def _solve(self, base: _Base, right: Array) -> Array:
        """A_0^-1 right, both (2 n + 2, k)."""
        closed, stick, traction = base.rows
        n, traction = len(closed), traction[:, None]
        pressure, shear = np.where(closed[:, None], 0.0, right[:n]), np.where(stick[:, None], 0.0, right[n : 2 * n])
        i, j = (np.flatnonzero(known.any(axis=1)) for known in (pressure, shear))  # few, or none
        gap = right[:n] - self.normal[:, i] @ pressure[i] + self.coupling[j].T @ shear[j]
        slip = right[n : 2 * n] - self.coupling[:, i] @ pressure[i] + self.tangential[:, j] @ shear[j]
        n_x, n_y = self.interface.normals
        tangential = 0.0 if self.interface.guided else n_y[j] @ shear[j] - n_x[i] @ pressure[i]
        loads = right[2 * n :] - np.stack(np.broadcast_arrays(n_y[i] @ pressure[i] + n_x[j] @ shear[j], tangential))
        found = lu_solve(base.factors, np.vstack([gap[closed], slip[stick], loads]), check_finite=False)
        n_closed = int(closed.sum())
        pressure[closed] = found[:n_closed]
        shear[stick] = found[n_closed:-2]
        return np.vstack([pressure, shear + traction * pressure, found[-2:]])

    def _values(self, rows: Rows, changed: Indices, found: Array) -> Array:
        """The changed rows of a set times `found` (2 n + 2, k)."""
        n = len(rows.closed)
        pressure, shear, rigid = found[:n], found[n : 2 * n], found[2 * n :]
        n_x, n_y = self.interface.normals
        i, j = changed[changed < n], changed[changed >= n] - n
        gap = self.normal[i] @ pressure - self.coupling.T[i] @ shear + np.stack([-n_y[i], n_x[i]], axis=1) @ rigid
        slip = self.coupling[j] @ pressure - self.tangential[j] @ shear + np.stack([n_x[j], n_y[j]], axis=1) @ rigid
        normal = np.where(rows.closed[i, None], gap, pressure[i])
        tangential = np.where(rows.stick[j, None], slip, shear[j] - rows.traction[j, None] * pressure[j])
        return np.vstack([normal, tangential])


def _lu(matrix: Array) -> Factors:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", LinAlgWarning)
            return lu_factor(matrix, check_finite=False)
    except LinAlgWarning as reason:
        raise SingularSet(str(reason)) from reason
