"""Linear systems of the active set: forces that meet the equalities of given node states, for many sets from few factors.

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
matrix A of a set differs from that of a base set, A_0, in a few rows R alone (Sherman-Morrison-Woodbury). With E the unit columns
of those rows and R_1 the rows as the set has them,

    z = A_0^-1 (b - E E^T b) + A_0^-1 E y,    (R_1 A_0^-1 E) y = b_R - R_1 A_0^-1 (b - E E^T b),

which is a column A_0^-1 e of the base for each changed row, kept with it, and one small system.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import InitVar, dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky
from scipy.linalg.lapack import dgetrf, dgetrs, dtrtrs

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK, ConvergenceError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]
Factors = tuple[Array, NDArray[np.int32]]

# Bytes of what sets add to the factors, and of factors of coupled systems: a cycle meets the same sets again and again.
_PREFIX_BYTES, _COUPLED_BYTES = 100_000_000, 300_000_000
# Rows in which a set may differ from its base: beyond that the set becomes a base itself.
_MOST_ROWS = 48


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""


def _lu(matrix: Array) -> Factors:
    factors, pivots, info = dgetrf(matrix)
    if info > 0:
        raise SingularSet(f"pivot {info} is zero")
    return factors, pivots


def _lu_solve(factors: Factors, right: Array) -> Array:
    return np.asarray(dgetrs(*factors, right)[0])


@dataclass(frozen=True, eq=False)
class Layer:
    """Elastic layer between the faces, the penalty method: compliance of each node; zero for the exact law.

    With it gap and slip in the law are those of the layer's inner faces, g + k_n p and s - k_t q.
    """

    normal: Array
    tangential: Array


# ------------------------------------------------------------------------------------------------------------- like bodies
@dataclass(eq=False)
class _Correction:
    """From a prefix of `size` nodes to a set: C, M_PP^-1 C and the factors of the m by m system, None where m is 0.

    `dropped` (in the prefix) and `added` (beyond it) are places in the order of elimination; `latest` is a right-hand side with its
    solution, `by_border` that of the border.
    """

    size: int
    dropped: Indices
    added: Indices
    columns: Array
    solved: Array
    factors: Factors | None
    by_border: Array | None = None
    latest: tuple[Array, Array] | None = None


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
        self._matrix, self._border, self._work = matrix, border, work
        try:
            lower = cholesky(matrix[np.ix_(self._order, self._order)], lower=True, check_finite=False)
        except LinAlgError as reason:
            raise ConvergenceError(f"contact: the compliance of the contact nodes is not positive definite: {reason}") from reason
        self._lower = np.asfortranarray(lower)  # so that its leading columns go to LAPACK without a copy
        self._work["factorisations"] += 1
        self._kept: dict[bytes, _Correction] = {}
        self._bytes = 0

    def solve(self, active: Mask, known: Array) -> Array:
        """f (n_active,) with M_AA f = known, rows by ascending node number; that of the latest `known` of a set is kept.

        The initial gap comes again with every load on a set of closed nodes.
        """
        return self._known(self._correction(active), active, known)

    def bordered(self, active: Mask, known: Array, total: float) -> tuple[Array, float]:
        """f (n_active,) and d with M_AA f - b d = known and b f = total, b the border."""
        correction, border = self._correction(active), self._border[active]
        if correction.by_border is None:
            correction.by_border = self._solve(correction, np.where(active, self._border, 0.0))[active]
        by_border = correction.by_border
        if not known.any():
            displacement = total / float(border @ by_border)
            return displacement * by_border, displacement
        by_known = self._known(correction, active, known)
        displacement = (total - float(border @ by_known)) / float(border @ by_border)
        return by_known + displacement * by_border, displacement

    def _known(self, correction: _Correction, active: Mask, known: Array) -> Array:
        if correction.latest is None or not np.array_equal(correction.latest[0], known):
            right = np.zeros(len(active))
            right[active] = known
            correction.latest = known, self._solve(correction, right)[active]
        return correction.latest[1]

    def _solve(self, correction: _Correction, right: Array) -> Array:
        """The solution (n,) of a right-hand side (n,) that is zero off the set, as it is itself."""
        self._work["linear solves"] += 1
        right, found = right[self._order], np.zeros_like(right)
        base = self._prefix_solve(right[: correction.size])
        if correction.factors is not None:
            lacking = -(correction.columns.T @ base)
            lacking[len(correction.dropped) :] -= right[correction.added]
            extra = _lu_solve(correction.factors, lacking)
            base += correction.solved @ extra
            base[correction.dropped] = 0.0
            found[self._order[correction.added]] = extra[len(correction.dropped) :]
        found[self._order[: correction.size]] = base
        return found

    def _prefix_solve(self, right: Array) -> Array:
        """M_PP^-1 right, P the first len(right) nodes of the order."""
        if not right.size:
            return right
        columns = self._lower[:, : len(right)]
        return np.asarray(dtrtrs(columns, dtrtrs(columns, right, lower=1)[0], lower=1, trans=1)[0])

    def _correction(self, active: Mask) -> _Correction:
        """That of the prefix which differs least from the set."""
        key = active.tobytes()
        if (known := self._kept.get(key)) is not None:
            return known
        wanted = active[self._order]
        differing = np.concatenate([[0], np.cumsum(~wanted)]) + np.concatenate([np.cumsum(wanted[::-1])[::-1], [0]])
        size = int(np.argmin(differing))
        dropped, added = np.flatnonzero(~wanted[:size]), size + np.flatnonzero(wanted[size:])
        columns, factors = np.zeros((size, len(dropped) + len(added)), order="F"), None
        columns[dropped, np.arange(len(dropped))] = 1.0
        columns[:, len(dropped) :] = -self._matrix[np.ix_(self._order[:size], self._order[added])]
        solved = self._prefix_solve(columns)
        if columns.shape[1]:
            self._work["factor updates"] += 1
            small = columns.T @ solved
            small[len(dropped) :, len(dropped) :] -= self._matrix[np.ix_(self._order[added], self._order[added])]
            factors = _lu(small)
        if self._bytes > _PREFIX_BYTES:
            self._kept.clear()
            self._bytes = 0
        self._bytes += 2 * columns.nbytes + 32 * len(active)
        self._kept[key] = _Correction(size, dropped, added, columns, solved, factors)
        return self._kept[key]


# ----------------------------------------------------------------------------------------------------------- unlike bodies
class _Change(NamedTuple):
    """From a base to a set: the changed rows, A_0^-1 E and the factors of the small system, None where nothing changes."""

    rows: Indices
    columns: Array
    factors: Factors | None


class _Rows(NamedTuple):
    """The rows of a set: those of gap, slip and loads that hold (2 n + 2,), and q over p of the nodes that slide (n,)."""

    held: Mask
    traction: Array


@dataclass(eq=False)
class _Base:
    """A set with factors of its own; A_0^-1 e of rows, (2 n + 2,), and the sets that were reached from it."""

    kinds: NDArray[np.int8]  # (2 n,) of its rows
    rows: _Rows
    factors: Factors
    nbytes: int
    columns: dict[int, Array] = field(default_factory=dict)
    changes: dict[bytes, _Change] = field(default_factory=dict)


@dataclass(eq=False)
class CoupledFactor:
    """Solves the coupled system of any set of states.

    Attributes
    ----------
    interface : normals and coupling
    normal, tangential, coupling : (n, n) compliance of interface and layer
    friction : coefficient f
    work : counts "linear solves", "factorisations" (of n^3) and "factor updates" (of m n^2)
    """

    interface: Interface
    normal: InitVar[Array]
    tangential: InitVar[Array]
    coupling: InitVar[Array]
    friction: float
    work: Counter[str]

    def __post_init__(self, normal: Array, tangential: Array, coupling: Array) -> None:
        (n_x, n_y), n = self.interface.normals, len(normal)
        # (2 n + 2, 2 n + 2) gap, slip and the two loads by z, as if all nodes stuck.
        self.matrix = np.zeros((2 * n + 2, 2 * n + 2))
        self.matrix[: 2 * n, : 2 * n] = np.block([[normal, -coupling.T], [coupling, -tangential]])
        self.matrix[: 2 * n, 2 * n :] = np.column_stack([np.concatenate([-n_y, n_x]), np.concatenate([n_x, n_y])])
        self.matrix[2 * n, : 2 * n] = np.concatenate([n_y, n_x])
        if self.interface.guided:
            self.matrix[2 * n + 1, 2 * n + 1] = 1.0
        else:
            self.matrix[2 * n + 1, : 2 * n] = np.concatenate([-n_x, n_y])
        self._bases: list[_Base] = []  # what was used last comes last

    def solve(self, states: States, gap: Array, slip: Array, loads: tuple[float, float]) -> Array:
        """(2 n + 2,) z with the given gap at closed nodes and the given slip at sticking ones, each (n,).

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.
        """
        self.work["linear solves"] += 1
        closed, n = states != OPEN, len(states)
        traction = np.asarray(slip_sign(states) * self.friction, dtype=np.float64)
        rows = _Rows(np.concatenate([closed, states == STICK, [True, True]]), traction)
        base, change = self._reached(states, rows)
        right = np.where(rows.held, np.concatenate([gap, slip, loads]), 0.0)
        wanted = right[change.rows]
        right[change.rows] = 0.0
        found = self._solve(base, right[:, None])[:, 0]
        if change.factors is not None:
            lacking = wanted - self._values(rows, change.rows, found[:, None])[:, 0]
            found += change.columns @ _lu_solve(change.factors, lacking)
        found[:n][~closed] = 0.0  # to the last digit, like q of what slides
        found[n : 2 * n] = np.where(states == STICK, found[n : 2 * n], rows.traction * found[:n])
        return found

    def _reached(self, states: States, rows: _Rows) -> tuple[_Base, _Change]:
        """A base and how to get from it to a set: kept, from the base nearest to it, or by making it a base."""
        key = states.tobytes()
        for number, base in enumerate(self._bases):
            if (known := base.changes.get(key)) is not None:
                self._bases.append(self._bases.pop(number))
                return base, known
        if not np.any(states == STICK):  # not left to the factors: an update of a base makes a pivot of rounding from a zero
            raise SingularSet("no node sticks: the bodies slide on each other")
        kinds = np.concatenate([states != OPEN, states], dtype=np.int8, casting="unsafe")
        apart = [np.flatnonzero(base.kinds != kinds) for base in self._bases]
        near = min(range(len(apart)), key=lambda number: len(apart[number]), default=-1)
        if near >= 0 and len(apart[near]) <= _MOST_ROWS:
            base, changed = self._bases.pop(near), apart[near]
        else:
            held, sliding = np.flatnonzero(rows.held), np.flatnonzero(rows.traction)
            own = self.matrix[np.ix_(held, held)]
            # Sliding nodes take their q along with p.
            own[:, np.searchsorted(held, sliding)] += self.matrix[np.ix_(held, len(states) + sliding)] * rows.traction[sliding]
            factors = _lu(own)
            base, changed = _Base(kinds, rows, factors, factors[0].nbytes), np.empty(0, dtype=np.int64)
            self.work["factorisations"] += 1
        self._bases.append(base)
        columns, update = np.empty((len(self.matrix), 0)), None
        if len(changed):
            self.work["factor updates"] += 1
            missing = [row for row in changed.tolist() if row not in base.columns]
            units = np.zeros((len(self.matrix), len(missing)))
            units[missing, np.arange(len(missing))] = 1.0
            base.columns.update(zip(missing, self._solve(base, units).T, strict=True))
            columns = np.stack([base.columns[row] for row in changed.tolist()], axis=1)
            update = _lu(self._values(rows, changed, columns))
            base.nbytes += units.nbytes + columns.nbytes
        if base.nbytes > _COUPLED_BYTES:
            base.changes.clear()
            base.nbytes = base.factors[0].nbytes + columns.nbytes + sum(column.nbytes for column in base.columns.values())
        base.changes[key] = change = _Change(changed, columns, update)
        while len(self._bases) > 1 and sum(one.nbytes for one in self._bases) > _COUPLED_BYTES:
            self._bases.pop(0)
        return base, change

    def _solve(self, base: _Base, right: Array) -> Array:
        """A_0^-1 right, both (2 n + 2, k)."""
        (held, traction), n = base.rows, len(base.rows.traction)
        found = np.where(held[:, None], 0.0, right)
        given = np.flatnonzero(found.any(axis=1))  # few, or none
        found[held] = _lu_solve(base.factors, right[held] - self.matrix[np.ix_(held, given)] @ found[given])
        found[n : 2 * n] += traction[:, None] * found[:n]
        return found

    def _values(self, rows: _Rows, changed: Indices, found: Array) -> Array:
        """The changed rows of a set times `found` (2 n + 2, k)."""
        n = len(rows.traction)
        slope = np.concatenate([np.zeros(n), rows.traction])[changed, None]
        own = found[changed] - slope * found[changed - n]  # p of open nodes, q - (+-f) p of others
        return np.where(rows.held[changed, None], self.matrix[changed] @ found, own)


# ----------------------------------------------------------------------------------------------------------- all equations
@dataclass(eq=False)
class Systems:
    """Compliance of interface and layer, with the factors that serve every set of nodes.

    `tangential_too` is False where there can be no shear: that half is then skipped.
    """

    interface: Interface
    layer: Layer
    friction: float
    work: Counter[str] = field(default_factory=Counter)
    tangential_too: bool = True

    def __post_init__(self) -> None:
        self.normal = self.interface.normal + np.diag(self.layer.normal)
        self.tangential = self.interface.tangential + np.diag(self.layer.tangential)
        self._nests: dict[str, NestedFactor] = {}
        self._coupled = None
        if self.tangential_too and self.interface.coupling is not None:
            parts = self.interface, self.normal, self.tangential, self.interface.coupling
            self._coupled = CoupledFactor(*parts, self.friction, self.work)

    def values(self, states: States, height: Array, slip: Array, loads: tuple[float, float]) -> Array:
        """(3 + 4 n,) values of an InterfaceState of given states over an initial gap, sticking nodes at a known slip.

        Gap and slip are those of the law, h - n_y delta + n_x U + N p - K^T q and n_y U + n_x delta + K p - T q; no tilt.
        """
        n, found = len(height), np.empty(3 + 4 * len(height))
        slips, pressure, shear, gaps = found[3:].reshape(4, -1)
        if self._coupled is not None:
            z = self._coupled.solve(states, -height, slip, loads)
            pressure[:], shear[:], found[:3] = z[:n], z[n : 2 * n], (*z[2 * n :], 0.0)
            gaps[:], slips[:] = (self._coupled.matrix[: 2 * n] @ z).reshape(2, -1)
            gaps += height
            return found
        pressure[:], approach = self.pressure_alone(states != OPEN, height, loads[0])
        shear[:], shift = self._shear_alone(states, pressure, slip, loads[1]) if self.tangential_too else (0.0, 0.0)
        found[:3] = approach, shift, 0.0
        gaps[:], slips[:] = self.interface.moved(approach, shift)
        gaps += height
        if pressure.any():
            gaps += self.normal @ pressure
        if shear.any():
            slips -= self.tangential @ shear
        if (coupling := self.interface.coupling) is not None:
            gaps -= coupling.T @ shear
            slips += coupling @ pressure
        return found

    def pressure_alone(self, closed: Mask, height: Array, load: float) -> tuple[Array, float]:
        """Pressure with n_y p = load, and approach, that close the given nodes over `height`, in which a known shift is."""
        return self._bordered("normal", closed, -height, load)

    def _shear_alone(self, states: States, pressure: Array, known_slip: Array, load: float) -> tuple[Array, float]:
        """Shear and shift of flat faces at known pressure: sticking nodes keep slip `known_slip`, sliding ones carry f p."""
        sliding, known = slip_sign(states) * self.friction * pressure, -known_slip
        if sliding.any():
            known = known - self.tangential @ sliding
        held, shift = self._bordered("tangential", states == STICK, known, load - float(sliding.sum()))
        return held + sliding, shift

    def held(self, stick: Mask, known: Array) -> Array:
        """Shear (n_stick,) of the sticking nodes with T_SS q = known there."""
        return self._nested("tangential").solve(stick, known)

    def _bordered(self, name: str, active: Mask, known: Array, total: float) -> tuple[Array, float]:
        """Forces f on the active nodes and rigid displacement d with matrix f - n_y d = known there, n_y f = total."""
        if not active.any():
            raise SingularSet(f"no node holds the {name} load")
        forces = np.zeros(len(active))
        forces[active], displacement = self._nested(name).bordered(active, known[active], total)
        return forces, displacement

    def _nested(self, name: str) -> NestedFactor:
        if name not in self._nests:
            self._nests[name] = NestedFactor(getattr(self, name), self.interface.x, self.interface.normals[1], self.work)
        return self._nests[name]
