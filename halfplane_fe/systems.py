"""Linear systems of the active set: what loads do to the interface while its nodes keep their
states, for many sets of states.

Unknowns z = (p, q, delta, U); each node has two rows, by its state:

    open    p = 0,             q = 0
    stick   gap = 0,           slip = known
    slip    gap = 0,           q - (+-f) p = 0

and two rows for the loads; U = 0 is the second where Q is zero by symmetry, or where there is no
shear. A state of a node is a choice of rows, so that the matrix of a set differs from that of a
base set in a few rows alone (Sherman-Morrison-Woodbury).

Of a base the answers to a unit in a load or in a row are kept, each as values of an
`InterfaceState`: approach, shift, tilt, then slip, pressure, shear and gap of the nodes. With v the
base's answer to the loads, c_r that to a unit in row r, and R the rows of the set, read off values,
its answer is

    v + sum_r y_r c_r,   sum_r R(c_r) y_r = b - R(v),

r being the rows in which set and base differ: one small system and one sum.

On one half of faces that are their own mirror image, without coupling, the first k nodes touch and
the first s of them stick, by ascending x, at almost all instants. Such nested sets need no base:
with N = L L^T and X = L^-1 the inverse of the leading k rows and columns of N is X_k^T X_k, X_k
being those of X; likewise of T.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky
from scipy.linalg.lapack import dgetrf, dgetrs, dtrtri

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, STICK, ConvergenceError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]
Factors = tuple[Array, NDArray[np.int32]]

# Bytes of bases: a cycle meets the same sets again and again.
_BYTES = 300_000_000
# Rows in which a set may differ from its base: beyond that the set becomes a base itself.
_MOST_ROWS = 96
# Rows next to one that is wanted whose answers are found along with it: edges of contact and stick
# travel from node to node.
_NEIGHBOURS = 12
# Rows of a triangle that are multiplied at once: read from memory once for both products, and not
# beyond the diagonal.
_ROWS = 256


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
    """Elastic layer between the faces, the penalty method: compliance of each node; zero for the
    exact law.

    With it gap and slip in the law are those of the layer's inner faces, g + k_n p and s - k_t q.
    """

    normal: Array
    tangential: Array


@dataclass(eq=False)
class _Base:
    """A set with factors of its own.

    Attributes
    ----------
    kinds : (2 n,) of its rows: closed, then the states
    traction : (n,) q over p of the nodes that slide
    held : (k,) rows of gap, slip and loads that hold, and at once the unknowns that are not given
    by others place : (2 n + 5,) of each row among them, -1 of others
    factors : of their equations
    free, beyond : rows of gap and slip that do not hold, and those rows of the matrix, (n_free, k)
    number, answers : (2 n + 5,) of each row or load whose answer is there, -1 of others; the
    answers, `count` of (m, 3 + 4 n) met : sets that were reached from it: met again, they have the
    same bits
    """

    kinds: NDArray[np.int8]
    traction: Array
    held: Indices
    place: Indices
    factors: Factors
    free: Indices
    beyond: Array
    number: Indices
    answers: Array
    met: set[bytes]
    count: int = 0

    @property
    def nbytes(self) -> int:
        """Of the arrays that count."""
        return self.factors[0].nbytes + self.beyond.nbytes + self.answers.nbytes


class _Nested:
    """A compliance C (n, n), and what holds some first nodes: those at known displacements carry
    what keeps them there.
    """

    def __init__(self, compliance: Array, factor: Array) -> None:
        self.compliance, self.inverse = compliance, np.ascontiguousarray(dtrtri(factor, lower=1)[0])
        # In row k - 1 the forces that move each of the first k nodes by 1, and what they move all
        # nodes by.
        by_row = self.inverse.sum(axis=1)[:, None]
        self.uniform, self.moved = (
            np.cumsum(self.inverse * by_row, axis=0),
            np.cumsum(factor.T * by_row, axis=0),
        )
        self.stiffness = self.uniform.sum(axis=1)

    def solved(
        self, held: int, touching: int, known: Array, total: Array
    ) -> tuple[Array, Array, Array]:
        """Forces F (n, m) that add up to `total` (m,), rigid motion r (m,), and C F - r: of the
        latter what the first `held` nodes have, of F what the others have, is `known` (n, m); most
        often nothing beyond the first `touching` ones."""
        forces, moved, rigid = known.copy(), known.copy(), total / self.stiffness[held - 1]
        moved[held:] = 0.0
        if known.any():
            reach = len(known) if known[touching:].any() else touching
            right, forces[:held] = (
                known[:held] - self.compliance[:held, held:reach] @ known[held:reach],
                0.0,
            )
            for end in range(_ROWS, held + _ROWS, _ROWS):
                rows = self.inverse[end - _ROWS : min(end, held), : min(end, held)]
                forces[: rows.shape[1]] += rows.T @ (rows @ right[: rows.shape[1]])
            moved[held:] = self.compliance[held:, :reach] @ forces[:reach]
            rigid = rigid - forces.sum(axis=0) / self.stiffness[held - 1]
        forces[:held] += np.multiply.outer(self.uniform[held - 1, :held], rigid)
        moved[held:] += np.multiply.outer(self.moved[held - 1, held:] - 1, rigid)
        return forces, rigid, moved


@dataclass(eq=False)
class Systems:
    """Compliance of interface and layer, and the answers of sets of node states.

    `shears` is False where there can be no shear: nodes then carry none, whether they stick or not.

    Raises
    ------
    ConvergenceError
        If a compliance is not positive definite.
    """

    interface: Interface
    layer: Layer
    friction: float
    work: Counter[str] = field(default_factory=Counter)
    shears: bool = True

    def __post_init__(self) -> None:
        faces, n = self.interface, len(self.interface.x)
        self.normal = faces.normal + np.diag(self.layer.normal)
        self.tangential = faces.tangential + np.diag(self.layer.tangential)
        compliances = (self.normal, self.tangential) if self.shears else (self.normal,)
        try:
            factors = [
                cholesky(compliance, lower=True, check_finite=False) for compliance in compliances
            ]
        except LinAlgError as reason:
            raise ConvergenceError(
                f"contact: the compliance of the contact nodes is not positive definite: {reason}"
            ) from reason
        n_x, n_y = faces.normals
        # (2 n + 2, 2 n + 5) gap, slip and the two loads by z, as if all nodes stuck, and by bulk
        # stresses and tilt.
        self.matrix = np.zeros((2 * n + 2, 2 * n + 5))
        self.matrix[:n, :n], self.matrix[n : 2 * n, n : 2 * n] = self.normal, -self.tangential
        if faces.coupling is not None:
            self.matrix[:n, n : 2 * n], self.matrix[n : 2 * n, :n] = (
                -faces.coupling.T,
                faces.coupling,
            )
        self.matrix[: 2 * n, 2 * n : 2 * n + 2] = np.column_stack(
            [np.concatenate([-n_y, n_x]), np.concatenate([n_x, n_y])]
        )
        self.matrix[2 * n, : 2 * n] = np.concatenate([n_y, n_x])
        if faces.imposed is not None:
            self.matrix[: 2 * n, 2 * n + 2 :] = faces.imposed.reshape(2 * n, 3)
        self._held_still = faces.guided or not self.shears
        if self._held_still:
            self.matrix[2 * n + 1, 2 * n + 1] = 1.0
        else:
            self.matrix[2 * n + 1, : 2 * n] = np.concatenate([-n_x, n_y])
        self._bases: list[_Base] = []  # what was used last comes last
        self._nested: list[_Nested] = []
        # p does not depend on q then
        if faces.coupling is None and faces.flat and faces.imposed is None:
            self._nested = [_Nested(*both) for both in zip(compliances, factors, strict=True)]

    def answers(
        self, states: States, n_loads: int, rows: Indices | None = None, given: Array | None = None
    ) -> Array:
        """(n_loads, 3 + 4 n) derivatives of the values of interface states by the loads, and a row
        for changes that are given.

        Parameters
        ----------
        states : which the nodes keep
        n_loads : 2 (P and Q) or 5 (bulk stresses and tilt too)
        rows, given : numbers of rows, that of the gap i and that of the slip n + i, and
            (len(rows),) what changes there while no load does: one more row of what is returned

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.

        >>> springs, none = (
        ...     np.eye(2),
        ...     np.zeros(2),
        ... )  # two nodes, each on a spring of its own: one sticks, one slips
        >>> flat = Interface(
        ...     np.array([0.0, 1.0]),
        ...     np.ones(2),
        ...     np.array([[0.0, 0.0], [1.0, 1.0]]),
        ...     none,
        ...     springs,
        ...     springs,
        ...     None,
        ... )
        >>> by_loads = Systems(flat, Layer(none, none), 0.5).answers(
        ...     np.array([1, 2], dtype=np.int8), 2
        ... )
        >>> by_loads[:, 5:9].tolist()  # p and q by P, then by Q: the second node carries q = f p
        [[0.5, 0.5, -0.25, 0.25], [0.0, 0.0, 1.0, 0.0]]
        """
        self.work["linear solves"] += 1
        n, touching, sticking = (
            len(states),
            int(np.count_nonzero(states)),
            int(np.count_nonzero(states == STICK)),
        )
        if (
            self._nested
            and sticking
            and states[:touching].all()
            and (states[:sticking] == STICK).all()
        ):
            known = np.zeros((2, n, n_loads + (rows is not None)))
            if rows is not None:
                known[rows // n, rows % n, n_loads] = given
            values, carried = np.zeros((known.shape[2], 3 + 4 * n)), np.eye(n_loads, known.shape[2])
            slip, force, shear, gap = values[:, 3:].reshape(-1, 4, n).transpose(1, 2, 0)
            force[:], values[:, 0], gap[:] = self._nested[0].solved(
                touching, touching, known[0], carried[0]
            )
            if self.shears:
                known[1, :sticking] *= -1
                known[1] += (slip_sign(states) * self.friction)[:, None] * force
                shear[:], values[:, 1], moved = self._nested[1].solved(
                    sticking, touching, known[1], carried[1]
                )
                slip[:] = -moved
            return values
        base, differs = self._nearest(states)
        if rows is not None:
            differs[rows] = True
        wanted, loads = np.flatnonzero(differs), np.arange(2 * n, 2 * n + n_loads)
        self._find(base, np.concatenate([wanted, loads]))
        found = np.zeros((n_loads + (rows is not None), 3 + 4 * n))
        found[:n_loads] = base.answers[base.number[loads]]
        if not len(wanted):
            return found
        self.work["factor updates"] += 1
        change = np.zeros(2 * n)
        if rows is not None:
            change[rows] = given
        # What values hold in a row: p or gap; of the tangential ones slip or q - (+-f) p.
        nodes, normal = wanted % n, wanted < n
        state = states[nodes]
        of_node = np.where(
            normal,
            np.where(state == OPEN, n, 3 * n),
            np.where((state == STICK) & self.shears, 0, 2 * n),
        )
        own, pressure, slope = (
            3 + of_node + nodes,
            3 + n + nodes,
            np.where(normal, 0, slip_sign(state)) * self.friction,
        )
        columns = base.answers[base.number[wanted]]
        right = found[:, pressure] * slope - found[:, own]
        right[n_loads:] += change[wanted]
        return np.asarray(
            found
            + _lu_solve(_lu((columns[:, own] - columns[:, pressure] * slope).T), right.T).T
            @ columns
        )

    def _nearest(self, states: States) -> tuple[_Base, Mask]:
        """A base for a set, and the rows that differ: that from which the set was reached before,
        the one used last or, where it is far, the nearest one, or the set itself."""
        # An update of a base makes a pivot of rounding from the zero that this is.
        if not (self._held_still or np.any(states == STICK)):
            raise SingularSet("no node sticks: the bodies slide on each other")
        key, kinds = (
            states.tobytes(),
            np.concatenate([states != OPEN, states], dtype=np.int8, casting="unsafe"),
        )
        found = next((base for base in self._bases if key in base.met), None)
        for near in (self._bases[-1:], self._bases):
            if found is None and near:
                apart = [np.count_nonzero(base.kinds != kinds) for base in near]
                found = near[int(np.argmin(apart))] if min(apart) <= _MOST_ROWS else None
        if found is None:
            found = self._made(states, kinds)
        else:
            self._bases.remove(found)
        self._bases.append(found)
        found.met.add(key)
        return found, found.kinds != kinds

    def _made(self, states: States, kinds: NDArray[np.int8]) -> _Base:
        """A new base."""
        self.work["factorisations"] += 1
        n = len(states)
        traction = np.asarray(slip_sign(states) * self.friction, dtype=np.float64)
        sticks = (states == STICK) & self.shears
        mask = np.concatenate([states != OPEN, sticks, [True, True, False, False, False]])
        held, free = np.flatnonzero(mask), np.flatnonzero(~mask[: 2 * n])
        columns, sliding = self.matrix[:, held], np.flatnonzero(traction)
        # Sliding nodes take their q along with p.
        columns[:, np.searchsorted(held, sliding)] += (
            self.matrix[:, n + sliding] * traction[sliding]
        )
        place = np.full(len(mask), -1)
        place[held] = np.arange(len(held))
        table = np.empty((0, 3 + 4 * n))
        return _Base(
            kinds,
            traction,
            held,
            place,
            _lu(columns[held]),
            free,
            columns[free],
            np.full_like(place, -1),
            table,
            set(),
        )

    def _find(self, base: _Base, wanted: Indices) -> None:
        """Have the answers of a base to a unit in these rows, or loads (from 2 n on)."""
        missing = wanted[base.number[wanted] < 0]
        if not len(missing):
            return
        n = len(base.traction)
        near = np.add.outer(
            missing[missing < 2 * n], np.arange(-_NEIGHBOURS, _NEIGHBOURS + 1)
        ).clip(0, 2 * n - 1)
        rows = np.union1d(near[base.number[near] < 0], missing)
        place, number = base.place[rows], np.arange(len(rows))
        held = place >= 0
        given = np.where(held, 0.0, self.matrix[:, np.where(held, 0, rows)])
        right = -given[base.held]
        right[place[held], number[held]] += 1.0
        unknown = _lu_solve(base.factors, right)
        z, moved = np.zeros((2 * n + 5, len(rows))), np.zeros((2 * n, len(rows)))
        z[base.held] = unknown
        z[rows[~held], number[~held]] = 1.0
        z[n : 2 * n] += base.traction[:, None] * z[:n]
        moved[base.free] = base.beyond @ unknown + given[base.free]
        inside = held & (rows < 2 * n)
        moved[rows[inside], number[inside]] = 1.0
        first = base.count
        base.count += len(rows)
        if base.count > len(base.answers):  # twice the room, so that it is seldom copied
            base.answers = np.concatenate([base.answers[:first], np.empty((base.count, 3 + 4 * n))])
        base.number[rows] = first + number
        for at, values in (
            (0, z[[2 * n, 2 * n + 1, 2 * n + 4]]),
            (3, moved[n:]),
            (3 + n, z[: 2 * n]),
            (3 + 3 * n, moved[:n]),
        ):
            base.answers[first : base.count, at : at + len(values)] = values.T
        while len(self._bases) > 1 and sum(one.nbytes for one in self._bases) > _BYTES:
            self._bases.pop(0)
