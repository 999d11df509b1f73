"""Linear systems of the active set: what loads do to the interface while its nodes keep their
states, for many sets of states.

Unknowns z = (p, q, delta, U); each node has two rows, by its state:

    open    p = 0,             q = 0
    stick   gap = 0,           slip = known
    slip    gap = 0,           q - (+-f) p = 0

and two rows for the loads; U = 0 is the second where Q is zero by symmetry, or where there is no
shear. Where the movement of an actuator stands in the place of a load, its row is that of
`actuators`. A state of a node is a choice of rows, so that the matrix of a set differs from that of
a base set in a few rows alone (Sherman-Morrison-Woodbury).

Of a base the answers to a unit in a load or in a row are kept. In a row that holds, gap or slip is
known and the force follows; in one that does not hold, the other way round. An answer is what
follows, a number each row, for what is known is the unit in its own row and 0 elsewhere. With v the
base's answer to the loads, c_r that to a unit in row r, and R the rows of the set, its answer is

    v + sum_r y_r c_r,   sum_r R(c_r) y_r = b - R(v),

r being the rows in which set and base differ: one small system and one sum. Answers of a base are
found by factors of its own, or in the same way from those of another base.

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

from halfplane_fe.actuators import LOADS_ARE_GIVEN, Actuators
from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, SLIP_FORWARD, STICK, ConvergenceError, InputError
from scenes.array_types import Array, Indices, Mask, States

Factors = tuple[Array, NDArray[np.int32]]

# Bytes of bases, and so many at least: a cycle meets the same sets again and again. A record of
# 2,000 rows on a pad makes 22 bases then, as with any number of bytes beyond; with 40 MB it makes
# 136.
_BYTES = 80_000_000
_LEAST_BASES = 4
# Rows in which a set may differ from its base: beyond that the set becomes a base itself.
_MOST_ROWS = 110
# Bits of `_kinds` by state: OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE.
_NORMAL_KINDS = np.array([1, 2, 2, 2], dtype=np.int8)
_TANGENTIAL_KINDS = np.array([2 + 4, 1, 2, 4], dtype=np.int8)
# Rows in which a base may differ from one with factors for its answers to be updates of those: of
# 700 nodes updates cost less than factors up to there.
_MOST_ROWS_APART = 300
# Sets of which `corrections` keeps the factors: the iterations of an increment go to and fro
# between few of them.
_FACTORISED = 8
# Rows on either side of one that is needed whose answers are found along with it: edges of contact
# and stick travel from node to node.
_NEIGHBOURS = 16
# Rows that are multiplied with a matrix one by one: faster up to as many as P, Q and changes have.
_FEW_ROWS = 3
# Rows of a triangle that are multiplied at once: read from memory once for both products, and not
# beyond the diagonal.
_ROWS = 256


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""


def _lu(matrix: Array) -> Factors:
    factors, pivots, zero_pivot = dgetrf(matrix)
    if zero_pivot > 0:
        raise SingularSet(f"pivot {zero_pivot} is zero")
    return factors, pivots


def _lu_solve(factors: Factors, right: Array) -> Array:
    return np.asarray(dgetrs(*factors, right)[0])


def _few_rows_times(rows: Array, matrix: Array) -> Array:
    """(k, n) product of k rows (k, m) and a matrix (m, n): row by row if they are few, for the
    product of two matrices begins with a copy of both.
    """
    if len(rows) > _FEW_ROWS:
        return np.asarray(rows @ matrix)
    return np.stack([row @ matrix for row in rows])


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
    """A set of which answers are kept.

    Attributes
    ----------
    row_states
        (2 n,) states of the nodes for their normal rows, then for their tangential ones: there
        open nodes may count as sliding
    kinds
        (2 n,) of its rows, see `_kinds`
    traction
        (n,) q over p of the nodes that slide, open ones that count as sliding among them
    held
        (k,) rows of gap, slip and loads that hold; the unknowns of these numbers are solved for
    place
        (2 n + 5,) of each row among `held`, -1 of others
    holds
        (2 n,) rows of gap and slip that hold
    source
        of its answers: factors of the equations of `held`, or another base of whose answers they
        are updates
    free
        (n_free,) rows of gap and slip that do not hold
    number
        (2 n + 5,) place in `answers` of the answer to each row or load, -1 where it is unknown
    answers
        (m, 2 n + 3), of which `count` are known: the force of each row that holds, gap or slip
        of the others, then approach, shift and tilt. Of a node that slides the force beyond f p
        is known, and its row does not hold
    places
        (3 + 4 n,) of the values of interface states among the unknowns, (2 n + 3,) as those of
        `answers`, and the givens, (2 n,) of each row, behind them; shear as the force of its row
    met
        sets that were reached from it: met again, they have the same bits
    """

    row_states: States
    kinds: States
    traction: Array
    held: Indices
    place: Indices
    holds: Mask
    source: Factors | _Base
    free: Indices
    number: Indices
    answers: Array
    places: Indices
    met: set[bytes]
    count: int = 0

    @property
    def origin(self) -> _Base | None:
        """The base that its answers come from."""
        return self.source if isinstance(self.source, _Base) else None

    @property
    def nbytes(self) -> int:
        """Of the arrays that count."""
        of_factors = 0 if isinstance(self.source, _Base) else self.source[0].nbytes
        return of_factors + self.answers.nbytes


def _kinds(row_states: States) -> NDArray[np.int8]:
    """(2 n,) of the rows of a set as bits, normal ones first: rows without a bit in common are
    different ones.

    An open node has the bits of both senses of slip: with p = 0, q = (+-f) p is q = 0.
    """
    n = len(row_states) // 2
    return np.concatenate(
        [_NORMAL_KINDS.take(row_states[:n]), _TANGENTIAL_KINDS.take(row_states[n:])]
    )


def _sliding_where_open(states: States) -> States:
    """(n,) states, but open nodes slide as the nearest sliding node does: that is how they will
    when they touch.
    """
    sliding_nodes = np.flatnonzero(states > STICK)
    if not len(sliding_nodes):
        return np.where(states == OPEN, SLIP_FORWARD, states)
    distances = np.abs(np.subtract.outer(np.arange(len(states)), sliding_nodes))
    nearest_sliding = states[sliding_nodes[distances.argmin(axis=1)]]
    return np.where(states == OPEN, nearest_sliding, states)


class _Nested:
    """A compliance C (n, n) of which the first k nodes, for any k, are held at known displacements.

    Attributes
    ----------
    compliance
        (n, n) C
    inverse
        (n, n) X = L^-1 of C = L L^T
    uniform, moved
        (n, n) in row k - 1 the forces that move each of the first k nodes by 1, and what these
        forces move all nodes by
    stiffness
        (n,) sum of the forces of each row of `uniform`
    """

    def __init__(self, compliance: Array, factor: Array) -> None:
        self.compliance = compliance
        self.inverse = np.ascontiguousarray(dtrtri(factor, lower=1)[0])
        sum_of_row = self.inverse.sum(axis=1)[:, None]
        self.uniform = np.cumsum(self.inverse * sum_of_row, axis=0)
        self.moved = np.cumsum(factor.T * sum_of_row, axis=0)
        self.stiffness = self.uniform.sum(axis=1)

    def solved(
        self,
        n_held: int,
        n_touching: int,
        known_values: Array,
        total: Array,
        compliance_of_rig: float | None,
    ) -> tuple[Array, Array, Array]:
        """Forces F (n, m) that add up to a total, the rigid motion r (m,), and C F - r (n, m).

        Parameters
        ----------
        n_held
            the first nodes, whose C F - r is known; of the others F is known
        n_touching
            nodes beyond which the known F is most often 0
        known_values
            (n, m) what is known of each node
        total
            (m,) sum of F; with a compliance c of the rig, r + c times that sum
        """
        forces = known_values.copy()
        displacements = known_values.copy()
        displacements[n_held:] = 0.0
        rigid_of_known: Array | float = 0.0
        if known_values.any():
            n_loaded = len(known_values) if known_values[n_touching:].any() else n_touching
            right = (
                known_values[:n_held]
                - self.compliance[:n_held, n_held:n_loaded] @ known_values[n_held:n_loaded]
            )
            forces[:n_held] = 0.0
            for end in range(_ROWS, n_held + _ROWS, _ROWS):
                rows = self.inverse[end - _ROWS : min(end, n_held), : min(end, n_held)]
                forces[: rows.shape[1]] += rows.T @ (rows @ right[: rows.shape[1]])
            displacements[n_held:] = self.compliance[n_held:, :n_loaded] @ forces[:n_loaded]
            rigid_of_known = -forces.sum(axis=0) / self.stiffness[n_held - 1]
        if compliance_of_rig is not None:
            compliance = 1 / self.stiffness[n_held - 1] + compliance_of_rig
            if not compliance > 0:
                raise InputError(
                    "rig.datum_length: the contact moves against its load where the displacement is"
                    " prescribed, so that no load follows from it: state a longer distance"
                )
            total = (total - rigid_of_known) / compliance
        rigid_motion = total / self.stiffness[n_held - 1] + rigid_of_known
        forces[:n_held] += np.multiply.outer(self.uniform[n_held - 1, :n_held], rigid_motion)
        displacements[n_held:] += np.multiply.outer(
            self.moved[n_held - 1, n_held:] - 1, rigid_motion
        )
        return forces, rigid_motion, displacements


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
    actuators: Actuators = LOADS_ARE_GIVEN

    def __post_init__(self) -> None:
        faces = self.interface
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
        self._held_still = faces.guided or not self.shears
        self._holds_without_stick = self._held_still or self.actuators.tangential is not None
        self.matrix = self._assembled()
        self._bases: list[_Base] = []  # what was used last comes last
        self._factorised: dict[bytes, _Base] = {}  # of `corrections`, by states
        self._nested: list[_Nested] = []
        # p does not depend on q then
        if faces.coupling is None and faces.flat and faces.imposed is None:
            self._nested = [
                _Nested(compliance, factor)
                for compliance, factor in zip(compliances, factors, strict=True)
            ]

    def _assembled(self) -> Array:
        """(2 n + 2, 2 n + 5) gap, slip and the two loads by z, as if all nodes stuck, and by bulk
        stresses and tilt.
        """
        faces = self.interface
        n = len(faces.x)
        n_x, n_y = faces.normals
        matrix = np.zeros((2 * n + 2, 2 * n + 5))
        # rows; as columns those of pressure and shear
        gap = pressure = slice(0, n)
        slip = shear = slice(n, 2 * n)
        matrix[gap, pressure] = self.normal
        matrix[slip, shear] = -self.tangential
        if faces.coupling is not None:
            matrix[gap, shear] = -faces.coupling.T
            matrix[slip, pressure] = faces.coupling
        matrix[gap, 2 * n] = -n_y
        matrix[slip, 2 * n] = n_x
        matrix[gap, 2 * n + 1] = n_x
        matrix[slip, 2 * n + 1] = n_y
        if faces.imposed is not None:
            matrix[: 2 * n, 2 * n + 2 :] = faces.imposed.reshape(2 * n, 3)
        matrix[2 * n, pressure] = n_y
        matrix[2 * n, shear] = n_x
        if self._held_still:
            matrix[2 * n + 1, 2 * n + 1] = 1.0
        else:
            matrix[2 * n + 1, pressure] = -n_x
            matrix[2 * n + 1, shear] = n_y
        for number, compliance in enumerate(self.actuators):
            of_shear = number == 1
            if compliance is not None and not (of_shear and self._held_still):
                row = matrix[2 * n + number]
                row *= compliance
                row[2 * n + number] = 1.0
        return matrix

    def answers(
        self,
        states: States,
        n_loads: int,
        rows: Indices | None = None,
        changes: Array | None = None,
    ) -> Array:
        """(n_loads, 3 + 4 n) derivatives of the values of interface states by the loads, and a row
        for changes that are given.

        Parameters
        ----------
        states
            which the nodes keep
        n_loads
            2 (P and Q) or 5 (bulk stresses and tilt too)
        rows
            numbers of rows, that of the gap i and that of the slip n + i
        changes
            (len(rows),) of these rows while no load changes: one more row of what is returned

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.

        Examples
        --------
        >>> springs = np.eye(2)  # two nodes, each on a spring of its own: one sticks, one slips
        >>> none = np.zeros(2)
        >>> places, normals = np.array([0.0, 1.0]), np.array([[0.0, 0.0], [1.0, 1.0]])
        >>> flat = Interface(places, np.ones(2), normals, none, springs, springs, None)
        >>> by_loads = Systems(flat, Layer(none, none), 0.5).answers(
        ...     np.array([1, 2], dtype=np.int8), 2
        ... )
        >>> by_loads[:, 5:9].tolist()  # p and q by P, then by Q: the second node carries q = f p
        [[0.5, 0.5, -0.25, 0.25], [0.0, 0.0, 1.0, 0.0]]
        """
        self.work["linear solves"] += 1
        if self._is_nested(states):
            return self._answers_of_nested(states, n_loads, rows, changes)
        return self._answers_from_base(states, n_loads, rows, changes)

    def _is_nested(self, states: States) -> bool:
        """Whether the first nodes stick, the next ones slide and the last are open, and answers
        need no base then.
        """
        if not self._nested:
            return False
        n_touching = int(np.count_nonzero(states))
        n_sticking = int(np.count_nonzero(states == STICK))
        touching = states[:n_touching]
        return bool(n_sticking and touching.all() and (touching[:n_sticking] == STICK).all())

    def _answers_of_nested(
        self, states: States, n_loads: int, rows: Indices | None, changes: Array | None
    ) -> Array:
        """`answers` of states of which the first nodes stick, the next slip and the last are
        open.
        """
        n = len(states)
        n_touching = int(np.count_nonzero(states))
        n_sticking = int(np.count_nonzero(states == STICK))
        n_cases = n_loads + (rows is not None)
        known_gap, known_slip = known = np.zeros((2, n, n_cases))
        if rows is not None:
            known[rows // n, rows % n, n_loads] = changes
        values = np.zeros((n_cases, 3 + 4 * n))
        slip, pressure, shear, gap = values[:, 3:].reshape(-1, 4, n).transpose(1, 2, 0)
        normal_load, tangential_load, *_ = np.eye(n_loads, n_cases)
        pressure[:], values[:, 0], gap[:] = self._nested[0].solved(
            n_touching, n_touching, known_gap, normal_load, self.actuators.normal
        )
        if self.shears:
            known_slip[:n_sticking] *= -1
            known_slip += (slip_sign(states) * self.friction)[:, None] * pressure
            shear[:], values[:, 1], moved = self._nested[1].solved(
                n_sticking, n_touching, known_slip, tangential_load, self.actuators.tangential
            )
            slip[:] = -moved
        return values

    def _answers_from_base(
        self, states: States, n_loads: int, rows: Indices | None, changes: Array | None
    ) -> Array:
        """`answers` of any states: those of a base, and an update by the rows that differ
        (Sherman-Morrison-Woodbury).
        """
        n = len(states)
        base, differs = self._nearest(states)
        given = np.zeros((0, 2 * n))
        if rows is not None:
            differs[rows] = True
            differs[n + rows[rows < n]] = True  # an open node with a given p does not slide
            given = np.zeros((1, 2 * n))
            given[0, rows] = changes
        updated = differs.nonzero()[0]
        row_states = np.concatenate([states, states])
        loads = np.arange(2 * n, 2 * n + n_loads)
        return self._updated(base, row_states, updated, loads, given[:, updated])

    def _updated(
        self, base: _Base, row_states: States, updated: Indices, units: Indices, given: Array
    ) -> Array:
        """(k + c, 3 + 4 n) values of interface states of a set, by an update of a base
        (Sherman-Morrison-Woodbury).

        Parameters
        ----------
        row_states
            (2 n,) of the set, see `_Base`
        updated
            (m,) rows in which set and base differ, and those that are given
        units
            (k,) loads, or rows in which they do not differ: by a unit in each
        given
            (c, m) what is known of the rows of `updated`: by each of these
        """
        n = len(self.normal)
        self._find(base, np.concatenate([units, updated]))
        columns = base.answers.take(base.number[np.concatenate([units, updated])], axis=0)
        n_units = len(units)
        n_cases = n_units + len(given)
        # what is unknown of the base, then what is known of its rows
        in_base = np.zeros((n_cases, 4 * n + 3))
        unknowns = in_base[:, : 2 * n + 3]
        givens = in_base[:, 2 * n + 3 :]
        unknowns[:n_units] = columns[:n_units]
        is_row = (units < 2 * n).nonzero()[0]
        givens[is_row, units[is_row]] = 1.0
        if len(updated):
            self.work["factor updates"] += 1
            by_units = self._rows_of_set(base, row_states, updated, units, columns)
            small_system = by_units[n_units:].T
            right = np.concatenate([-by_units[:n_units], given])
            factors = _lu_solve(_lu(small_system), right.T).T
            unknowns += _few_rows_times(factors, columns[n_units:])
            givens[:, updated] = factors
        values = in_base.take(base.places, axis=1)
        _, pressure, shear, _ = values[:, 3:].reshape(-1, 4, n).transpose(1, 0, 2)
        shear += base.traction * pressure
        return values

    def _rows_of_set(
        self, base: _Base, row_states: States, rows: Indices, units: Indices, columns: Array
    ) -> Array:
        """(k + m, m) what m rows of a set read in answers of a base, (k + m, 2 n + 3), to k units
        and to a unit in each of the m rows.

        A normal row reads p of an open node, else the gap; a tangential one the slip of a node
        that sticks, else q - (+-f) p.
        """
        n = len(self.normal)

        def read(rows_read: Indices, is_unknown: Mask) -> Array:
            """(k + m, len(rows_read)) what the base does not know of these rows, or the units."""
            values = columns.take(rows_read, axis=1)
            if not is_unknown.all():
                all_units = np.concatenate([units, rows])
                values[:, ~is_unknown] = np.equal.outer(all_units, rows_read[~is_unknown])
            return values

        node = rows % n
        state = row_states[rows]
        is_normal = rows < n
        reads_displacement = np.where(is_normal, state != OPEN, (state == STICK) & self.shears)
        values = read(rows, base.holds[rows] != reads_displacement)
        # The force of a tangential row is q beyond what the base takes along with p.
        slope = base.traction[node] - self.friction * slip_sign(state)
        with_pressure = (~is_normal & ~reads_displacement & (slope != 0)).nonzero()[0]
        of_pressure = node[with_pressure]
        values[:, with_pressure] += slope[with_pressure] * read(
            of_pressure, base.holds[of_pressure]
        )
        return values

    def corrections(self, states: States, n_loads: int, changes: Array) -> Array:
        """`answers`, with changes of all rows: by the factors of the set itself.

        Parameters
        ----------
        states
            which the nodes keep
        n_loads
            2 (P and Q) or 5 (bulk stresses and tilt too)
        changes
            (2 n,) of all rows while no load changes

        Returns
        -------
        ndarray
            (n_loads + 1, 3 + 4 n), the last row by the changes

        Raises
        ------
        SingularSet
            If the states leave the bodies free to move.
        """
        n = len(states)
        self.work["linear solves"] += 1
        if self._is_nested(states):
            return self._answers_of_nested(states, n_loads, np.arange(2 * n), changes)
        if not (self._holds_without_stick or STICK in states):
            raise SingularSet("no node sticks: the bodies slide on each other")
        key = states.tobytes()
        base = self._factorised.pop(key, None)
        if base is None:
            base = self._new_base(np.concatenate([states, states]), None)
        self._factorised[key] = base  # what was used last comes last
        if len(self._factorised) > _FACTORISED:
            del self._factorised[next(iter(self._factorised))]
        rows_of_loads = np.arange(2 * n, 2 * n + n_loads)
        case_of_changes = n_loads
        z = np.zeros((2 * n + 5, n_loads + 1))
        z[rows_of_loads[2:], np.arange(2, n_loads)] = 1.0
        z[base.free, case_of_changes] = changes[base.free]
        right = -self.matrix[base.held] @ z
        right[base.place[rows_of_loads[:2]], np.arange(2)] += 1.0
        of_nodes = base.held < 2 * n
        right[of_nodes, case_of_changes] += changes[base.held[of_nodes]]
        assert not isinstance(base.source, _Base)  # for the type checker: it has no origin
        z[base.held] = _lu_solve(base.source, right)
        z[n : 2 * n] += base.traction[:, None] * z[:n]
        displacements = self.matrix[: 2 * n] @ z
        values = np.empty((n_loads + 1, 3 + 4 * n))
        values[:, :3] = z[[2 * n, 2 * n + 1, 2 * n + 4]].T  # approach, shift, tilt
        values[:, 3 : 3 + n] = displacements[n:].T  # slip
        values[:, 3 + n : 3 + 3 * n] = z[: 2 * n].T  # pressure and shear
        values[:, 3 + 3 * n :] = displacements[:n].T  # gap
        return values

    def _nearest(self, states: States) -> tuple[_Base, Mask]:
        """A base for a set, and the rows that differ: that from which the set was reached before,
        the nearest one or, where it is far, the set itself.
        """
        # An update of a base makes a pivot of rounding from the zero that this is.
        if not (self._holds_without_stick or STICK in states):
            raise SingularSet("no node sticks: the bodies slide on each other")
        key = states.tobytes()
        kinds = _kinds(np.concatenate([states, states]))
        base = next((base for base in self._bases if key in base.met), None)
        if base is None and self._bases:
            n_rows = len(kinds)
            rows_apart = [n_rows - np.count_nonzero(base.kinds & kinds) for base in self._bases]
            least_rows = min(rows_apart)
            if least_rows <= _MOST_ROWS:
                base = self._bases[rows_apart.index(least_rows)]
        if base is None:
            row_states = np.concatenate([states, _sliding_where_open(states)])
            base = self._new_base(row_states, self._origin(row_states))
        # what was used last comes last, and an origin after what has come from it
        for used in (base, base.origin):
            if used in self._bases:
                self._bases.remove(used)
            if used is not None:
                self._bases.append(used)
        base.met.add(key)
        return base, (base.kinds & kinds) == 0

    def _origin(self, row_states: States) -> _Base | None:
        """The nearest base with factors, from which answers of a new one can be found for less than
        its own factors cost.
        """
        origins = [base for base in self._bases if base.origin is None]
        if not origins:
            return None
        kinds = _kinds(row_states)
        rows_apart = [np.count_nonzero((base.kinds & kinds) == 0) for base in origins]
        least_rows = min(rows_apart)
        return origins[rows_apart.index(least_rows)] if least_rows <= _MOST_ROWS_APART else None

    def _new_base(self, row_states: States, origin: _Base | None) -> _Base:
        """A base without answers, and with factors if it has no origin."""
        n = len(self.normal)
        states = row_states[:n]
        traction = np.asarray(slip_sign(row_states[n:]) * self.friction, dtype=np.float64)
        sticks = (states == STICK) & self.shears
        holds = np.concatenate([states != OPEN, sticks, [True, True, False, False, False]])
        held_rows = np.flatnonzero(holds)
        free_rows = np.flatnonzero(~holds[: 2 * n])
        place = np.full(len(holds), -1)
        place[held_rows] = np.arange(len(held_rows))
        number_of_unknown = np.arange(2 * n)
        number_of_given = number_of_unknown + 2 * n + 3
        is_given = ~holds[: 2 * n]
        places_of_force = np.where(is_given, number_of_given, number_of_unknown)
        places_of_displacement = np.where(is_given, number_of_unknown, number_of_given)
        places = [
            np.arange(2 * n, 2 * n + 3),  # approach, shift, tilt
            places_of_displacement[n:],
            places_of_force,
            places_of_displacement[:n],
        ]
        return _Base(
            row_states=row_states,
            kinds=_kinds(row_states),
            traction=traction,
            held=held_rows,
            place=place,
            holds=holds[: 2 * n],
            source=self._factors(states, held_rows) if origin is None else origin,
            free=free_rows,
            number=np.full_like(place, -1),
            answers=np.empty((0, 2 * n + 3)),
            places=np.concatenate(places),
            met=set(),
        )

    def _factors(self, states: States, held_rows: Indices) -> Factors:
        """Of the equations of the rows of a set that hold."""
        self.work["factorisations"] += 1
        columns = self.matrix[np.ix_(held_rows, held_rows)]
        # Sliding nodes take their q along with p.
        sliding_nodes = np.flatnonzero(slip_sign(states))
        traction = slip_sign(states[sliding_nodes]) * self.friction
        columns[:, np.searchsorted(held_rows, sliding_nodes)] += (
            self.matrix[np.ix_(held_rows, len(states) + sliding_nodes)] * traction
        )
        return _lu(columns)

    def _find(self, base: _Base, required: Indices) -> None:
        """Have the answers of a base to a unit in these rows, or loads (from 2 n on)."""
        missing_rows = required[base.number[required] < 0]
        if not len(missing_rows):
            return
        n = len(base.traction)
        neighbours = np.add.outer(
            missing_rows[missing_rows < 2 * n], np.arange(-_NEIGHBOURS, _NEIGHBOURS + 1)
        ).clip(0, 2 * n - 1)
        rows = np.union1d(neighbours[base.number[neighbours] < 0], missing_rows)
        source = base.source
        if isinstance(source, _Base):
            answers = self._by_origin(base, source, rows)
        else:
            answers = self._by_factors(base, source, rows)
        end = base.count + len(rows)
        if end > len(base.answers):  # twice the room, so that it is seldom copied
            room = np.empty((end, 2 * n + 3))
            base.answers = np.concatenate([base.answers[: base.count], room])
        base.answers[base.count : end] = answers
        base.number[rows] = np.arange(base.count, end)
        base.count = end
        while len(self._bases) > _LEAST_BASES and sum(base.nbytes for base in self._bases) > _BYTES:
            self._bases.pop(0)

    def _by_factors(self, base: _Base, factors: Factors, rows: Indices) -> Array:
        """(len(rows), 2 n + 3) answers of a base by its factors."""
        n = len(self.normal)
        place = base.place[rows]
        is_held = place >= 0
        by_unknown = np.where(is_held, 0.0, self.matrix[:, np.where(is_held, 0, rows)])
        is_open = ~is_held & (rows < n)
        open_nodes = rows[is_open]
        by_unknown[:, is_open] += self.matrix[:, n + open_nodes] * base.traction[open_nodes]
        right = -by_unknown[base.held]
        right[place[is_held], is_held.nonzero()[0]] += 1.0
        solutions = _lu_solve(factors, right)
        forces = np.zeros((2 * n + 2, len(rows)))
        forces[base.held] = solutions
        forces[n : 2 * n] += base.traction[:, None] * forces[:n]
        displacements = self.matrix[base.free, : 2 * n + 2] @ forces + by_unknown[base.free]
        answers = np.empty((len(rows), 2 * n + 3))
        answers[:, base.held] = solutions.T
        answers[:, base.free] = displacements.T
        answers[:, 2 * n + 2] = rows == 2 * n + 4  # the tilt
        return answers

    def _by_origin(self, base: _Base, origin: _Base, rows: Indices) -> Array:
        """(len(rows), 2 n + 3) answers of a base by an update of those of its origin."""
        n = len(self.normal)
        updated = ((origin.kinds & base.kinds) == 0).nonzero()[0]
        is_updated = np.isin(rows, updated)
        given = np.equal.outer(rows[is_updated], updated).astype(np.float64)
        values = np.empty((len(rows), 3 + 4 * n))
        number = np.concatenate([(~is_updated).nonzero()[0], is_updated.nonzero()[0]])
        values[number] = self._updated(origin, base.row_states, updated, rows[~is_updated], given)
        # q of nodes that slide is known of the base, and left out
        in_base = np.empty_like(values)
        in_base[:, base.places] = values
        return in_base[:, : 2 * n + 3]
