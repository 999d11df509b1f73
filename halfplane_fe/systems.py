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

A row pairs a displacement with the force in its direction: gap with pressure, slip with shear. It
is *held* where the states prescribe the displacement, and *free* where they prescribe the force;
the other of the two is its response. Where a node slides the force of its tangential row is
q - (+-f) p.

Of a base the responses to unit cases are cached: to 1 in what it prescribes in one row, and to each
unit load. A set is reached from the base by amplitudes of its unit cases. With v the responses to a
load, c_r those to the unit case of row r, and R what the set prescribes in the rows in which it
differs from the base,

    responses = v + sum_r y_r c_r,    R(v) + sum_r y_r R(c_r) = given:

one small system for the amplitudes y, and one sum. The unit cases of a base are solved by equations
of its own, or in the same way from those of another base, its origin.

On one half of faces that are their own mirror image, without coupling, the first k nodes touch and
the first s of them stick, by ascending x, at almost all instants. Such nested sets need no base:
with N = L L^T and X = L^-1 the inverse of the leading k rows and columns of N is X_k^T X_k, X_k
being those of X; likewise of T.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cholesky
from scipy.linalg.lapack import dgetrf, dgetrs, dtrtri

from halfplane_fe.actuators import LOADS_ARE_GIVEN, Actuators
from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, SLIP_FORWARD, STICK, ConvergenceError, InputError
from scenes.array_types import Array, Indices, Mask, States

LuFactors = tuple[Array, NDArray[np.int32]]

# Bytes of bases, and so many at least: a cycle meets the same sets again and again. A record of
# 2,000 rows on a pad makes 22 bases then, as with any number of bytes beyond; with 40 MB it makes
# 136.
_MOST_BYTES = 80_000_000
_FEWEST_BASES = 4
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
_MOST_FACTORISED_SETS = 8
# Rows on either side of one that is needed whose answers are found along with it: edges of contact
# and stick travel from node to node.
_N_NEIGHBOURS = 16
# Room for responses of a base over what is needed when it is made.
_SPARE_ROOM = 1.5
# Rows that are multiplied with a matrix one by one: faster up to as many as P, Q and changes have.
_FEW_ROWS = 3
# Rows of a triangle that are multiplied at once: read from memory once for both products, and not
# beyond the diagonal.
_ROWS_PER_BLOCK = 256


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""


def _lu(matrix: Array) -> LuFactors:
    factors, pivots, zero_pivot = dgetrf(matrix)
    if zero_pivot > 0:
        raise SingularSet(f"pivot {zero_pivot} is zero")
    return factors, pivots


def _lu_solve(factors: LuFactors, right: Array) -> Array:
    return np.asarray(dgetrs(*factors, right)[0])


def _few_rows_times(rows: Array, matrix: Array) -> Array:
    """Product (k, n) of a matrix of few rows (k, m) and a matrix (m, n), row by row where k <= 3:
    numpy's product of two matrices would begin with a copy of both.
    """
    if len(rows) > _FEW_ROWS:
        return np.asarray(rows @ matrix)
    product = np.empty((len(rows), matrix.shape[1]))
    for row, row_of_product in zip(rows, product, strict=True):
        np.dot(row, matrix, out=row_of_product)
    return product


@dataclass(frozen=True, eq=False)
class Layer:
    """Elastic layer between the faces, the penalty method: compliance of each node; zero for the
    exact law.

    With it gap and slip in the law are those of the layer's inner faces, g + k_n p and s - k_t q.
    """

    normal: Array
    tangential: Array


class _HeldEquations(NamedTuple):
    """The equations of the k held rows of a base, P and Q among them, solved for their forces and
    for the rigid motion.

    Attributes
    ----------
    of_held
        factors of (k, k) displacements of held rows by forces of held rows
    free_by_held
        (n_free, k) displacements of free rows by forces of held rows
    """

    of_held: LuFactors
    free_by_held: Array

    @property
    def nbytes(self) -> int:
        """Of both matrices."""
        return self.of_held[0].nbytes + self.free_by_held.nbytes


@dataclass(eq=False)
class _Base:
    """A set of node states of which responses to unit cases are cached.

    Attributes
    ----------
    row_states
        (2 n,) states of the nodes for their normal rows, then for their tangential ones: there
        open nodes may count as sliding
    kinds
        (2 n,) of its rows, see `_kinds`
    traction
        (n,) q over p of the nodes that slide, open ones that count as sliding among them
    is_held
        (2 n,) whether the displacement of each row is prescribed
    held
        (k,) rows that are held, then P and Q: what responds to these is solved for
    free
        (n_free,) rows whose force is prescribed
    place_in_held
        (2 n + 5,) of each row and load, -1 of those that are not among `held`
    value_sources
        (3 + 4 n,) where each value of an interface state comes from: the 2 n + 3 responses, or
        the 2 n prescribed values of the rows, which follow them. Shear is the force of its row
    equations
        of its own, factorised; None where it has an origin
    origin
        the base from whose responses its own are found
    case_number
        (2 n + 5,) row of `responses` for the unit case of each row and load, -1 where that is
        not solved yet
    responses
        (m, 2 n + 3) to unit cases, of which `n_cases` are solved: of each row, then approach,
        shift and tilt
    n_cases
        unit cases that are solved
    sets_reached
        sets that were reached from it: met again, they have the same bits
    """

    row_states: States
    kinds: States
    traction: Array
    is_held: Mask
    held: Indices
    free: Indices
    place_in_held: Indices
    value_sources: Indices
    equations: _HeldEquations | None
    origin: _Base | None
    case_number: Indices
    responses: Array
    n_cases: int = 0
    sets_reached: set[bytes] = field(default_factory=set)

    @property
    def nbytes(self) -> int:
        """Of the arrays that count."""
        bytes_of_equations = 0 if self.equations is None else self.equations.nbytes
        return bytes_of_equations + self.responses.nbytes


class _Update(NamedTuple):
    """A set as reached from a base, for several load cases.

    Attributes
    ----------
    responses
        (c, 2 n + 3) of each case: what the base does not prescribe
    rows
        (m,) in which the set differs from the base
    amplitudes
        (c, m) of the unit cases of these rows: what the base would prescribe there
    """

    responses: Array
    rows: Indices
    amplitudes: Array


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
        """Solve for nodal forces of m load cases where the first nodes are held at known
        displacements and the other nodes carry known forces.

        With the compliance C (n, n) of all nodes, forces F, and a rigid motion r of the body, the
        displacement of a node is (C F - r). The inverse of the first k rows and columns of C is
        X_k^T X_k for every k, X_k being those of one triangular matrix.

        Parameters
        ----------
        n_held
            number of the first nodes, whose displacement is known; of the others F is known
        n_touching
            number of nodes beyond which the known F is most often 0
        known_values
            (n, m) the known displacement or force of each node
        total
            (m,) sum of F; where an actuator with the compliance c moves the body, r + c times
            that sum
        compliance_of_rig
            c; None where the load is given

        Returns
        -------
        forces, rigid_motion, displacements
            F (n, m), r (m,), C F - r (n, m).
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
            for end in range(_ROWS_PER_BLOCK, n_held + _ROWS_PER_BLOCK, _ROWS_PER_BLOCK):
                rows = self.inverse[end - _ROWS_PER_BLOCK : min(end, n_held), : min(end, n_held)]
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
        """Assemble the matrix of all equations; where pressure and shear do not act on each other,
        factorise both compliances for sets of nodes that are nested by ascending x.
        """
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
        self._held_still = faces.has_odd_shear or not self.shears
        self._holds_without_stick = self._held_still or self.actuators.tangential is not None
        self.matrix = self._assembled()
        self._bases: list[_Base] = []  # what was used last comes last
        self._factorised: dict[bytes, _Base] = {}  # of `corrections`, by states
        self._nested: list[_Nested] = []
        # Pressure does not depend on shear then.
        if faces.coupling is None and faces.flat and faces.imposed is None:
            self._nested = [
                _Nested(compliance, factor)
                for compliance, factor in zip(compliances, factors, strict=True)
            ]

    def _assembled(self) -> Array:
        """Matrix of the linear equations of the contact as if all n nodes stuck, (2 n + 2,
        2 n + 5).

        Rows: gap of the nodes, slip of the nodes, P, Q. Columns: p and q of the nodes, normal
        approach, tangential displacement, both bulk stresses, tilt. Where an actuator's movement
        stands in the place of a load, its row is c times the load plus the rigid motion, c being
        the compliance between actuator and contact.
        """
        faces = self.interface
        n = len(faces.x)
        n_x, n_y = faces.normals
        matrix = np.zeros((2 * n + 2, 2 * n + 5))
        # One range numbers the rows of gap and the columns of pressure; likewise slip and shear.
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
        for direction, compliance in enumerate(self.actuators):  # normal, tangential
            is_tangential = direction == 1
            if compliance is not None and not (is_tangential and self._held_still):
                row = matrix[2 * n + direction]
                row *= compliance
                row[2 * n + direction] = 1.0
        return matrix

    def answers(
        self,
        states: States,
        n_loads: int,
        rows: Indices | None = None,
        changes: Array | None = None,
    ) -> Array:
        """Derivatives of the contact's values by its loads while the n nodes keep their states, and
        the values' response to given changes of single equations.

        The values are approach, displacement U and tilt, then slip, p, q and gap of the nodes. A
        node has two equations, by its state: p = 0 or gap = 0; q = 0, constant slip, or q = +-f p.

        Parameters
        ----------
        states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (bulk stresses and tilt too)
        rows
            numbers of equations whose right side changes: i is the normal one of node i, n + i the
            tangential one
        changes
            (len(rows),) these changes, at constant loads

        Returns
        -------
        ndarray
            (n_loads, 3 + 4 n), with one more row for the changes if there are any

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.

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
            return self._values_of_nested(states, n_loads, rows, changes)
        return self._values_from_base(states, n_loads, rows, changes)

    def _is_nested(self, states: States) -> bool:
        """Whether, by ascending x, the first nodes stick, the next ones slide and the last are
        open, as on one half of a symmetric contact: a faster solution then exists.
        """
        if not self._nested:
            return False
        n_touching = int(np.count_nonzero(states))
        n_sticking = int(np.count_nonzero(states == STICK))
        touching = states[:n_touching]
        return bool(n_sticking and touching.all() and (touching[:n_sticking] == STICK).all())

    def _values_of_nested(
        self, states: States, n_loads: int, rows: Indices | None, changes: Array | None
    ) -> Array:
        """Derivatives of the contact's values by its loads, (n_loads, 3 + 4 n), where the first
        nodes stick, the next slide, the last are open, and p does not depend on q.

        Two problems follow each other. In the normal one touching nodes are held. In the tangential
        one sticking nodes are held, and sliding ones carry q = (+-f) p. The values are approach, U
        and tilt, then slip, p, q and gap of the nodes.

        Parameters
        ----------
        states
            (n,) open, stick or slip
        n_loads
            2, of P and Q
        rows, changes
            equations whose right side changes at constant loads (i normal, n + i tangential), and
            by how much: one more row of what is returned; None for none
        """
        n = len(states)
        n_touching = int(np.count_nonzero(states))
        n_sticking = int(np.count_nonzero(states == STICK))
        n_cases = n_loads + (rows is not None)
        prescribed = np.zeros((2, n, n_cases))
        if rows is not None:
            prescribed[rows // n, rows % n, n_loads] = changes
        prescribed_normal, prescribed_tangential = prescribed
        normal_load, tangential_load, *_ = np.eye(n_loads, n_cases)

        values = np.zeros((n_cases, 3 + 4 * n))
        slip, pressure, shear, gap = values[:, 3:].reshape(-1, 4, n).transpose(1, 2, 0)
        pressure[:], values[:, 0], gap[:] = self._nested[0].solved(
            n_touching, n_touching, prescribed_normal, normal_load, self.actuators.normal
        )
        if self.shears:
            # Shear of the contact moves the faces against the slip.
            prescribed_tangential[:n_sticking] *= -1
            friction_of_states = slip_sign(states) * self.friction
            prescribed_tangential += friction_of_states[:, None] * pressure
            shear[:], values[:, 1], opposite_slip = self._nested[1].solved(
                n_sticking,
                n_touching,
                prescribed_tangential,
                tangential_load,
                self.actuators.tangential,
            )
            slip[:] = -opposite_slip
        return values

    def _values_from_base(
        self, states: States, n_loads: int, rows: Indices | None, changes: Array | None
    ) -> Array:
        """Derivatives of the contact's values by its loads, (n_loads, 3 + 4 n), for any states of
        the nodes, from those of a similar set of states by an update of low rank.

        The values are approach, U and tilt, then slip, p, q and gap of the n nodes.

        Parameters
        ----------
        states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (bulk stresses and tilt too)
        rows, changes
            equations whose right side changes at constant loads (i normal, n + i tangential), and
            by how much: one more row of what is returned; None for none
        """
        n = len(states)
        base, differs = self._base_for(states)
        given = np.zeros((0, 2 * n))
        if rows is not None:
            differs[rows] = True
            # An open node with a given p has q = 0, not q = (+-f) p.
            differs[n + rows[rows < n]] = True
            given = np.zeros((1, 2 * n))
            given[0, rows] = changes
        rows_apart = differs.nonzero()[0]
        row_states = np.concatenate([states, states])
        unit_loads = np.arange(2 * n, 2 * n + n_loads)
        update = self._updated(base, row_states, rows_apart, unit_loads, given[:, rows_apart])

        n_responses = 2 * n + 3
        responses_and_prescribed = np.zeros((len(update.responses), n_responses + 2 * n))
        responses_and_prescribed[:, :n_responses] = update.responses
        responses_and_prescribed[:, n_responses + rows_apart] = update.amplitudes
        values = responses_and_prescribed.take(base.value_sources, axis=1)
        _, pressure, shear, _ = values[:, 3:].reshape(-1, 4, n).transpose(1, 0, 2)
        shear += base.traction * pressure  # so far the force of its row
        return values

    def _updated(
        self, base: _Base, row_states: States, rows: Indices, unit_cases: Indices, given: Array
    ) -> _Update:
        """Responses of the contact for one set of node states from cached ones for another set, the
        base, by an update of low rank (Sherman-Morrison-Woodbury).

        The base's response to a unit right side of each equation in which the sets differ is added
        with an amplitude, so that the equations of the new set are met:

            readings of unit_cases + amplitudes @ readings of rows = given (0 in unit_cases)
            responses = responses to unit_cases + amplitudes @ responses to rows

        Parameters
        ----------
        base
            the set whose responses are cached
        row_states
            (2 n,) states of the n nodes in the new set, for their normal equations, then for their
            tangential ones
        rows
            (m,) equations in which the sets differ, or whose right side is given
        unit_cases
            (k,) loads, or equations common to both sets: the first k cases
        given
            (c, m) right sides of the equations `rows` in c further cases
        """
        n_units = len(unit_cases)
        cases = np.concatenate([unit_cases, rows])
        self._solve_cases(base, cases)
        case_responses = base.responses.take(base.case_number[cases], axis=0)
        responses = np.zeros((n_units + len(given), case_responses.shape[1]))
        responses[:n_units] = case_responses[:n_units]
        if not len(rows):
            return _Update(responses, rows, np.zeros((len(responses), 0)))
        self.work["factor updates"] += 1
        readings = self._readings(base, row_states, rows, cases, case_responses)
        readings_of_rows = readings[n_units:].T
        missing = np.concatenate([-readings[:n_units], given])
        amplitudes = _lu_solve(_lu(readings_of_rows), missing.T).T
        responses += _few_rows_times(amplitudes, case_responses[n_units:])
        return _Update(responses, rows, amplitudes)

    def _readings(
        self, base: _Base, row_states: States, rows: Indices, cases: Indices, responses: Array
    ) -> Array:
        """Left sides of m equations of one set of node states, evaluated in c responses of another
        set, the base: (c, m).

        In a normal equation that is p of an open node, else the gap; in a tangential one the slip
        of a node that sticks, else q - (+-f) p.

        Parameters
        ----------
        base
            the set whose responses they are
        row_states
            (2 n,) states of the n nodes in the set whose equations are meant, for normal equations,
            then for tangential ones
        rows
            (m,) numbers of the equations: i normal, n + i tangential
        cases
            (c,) equation or load whose right side is 1 in each response of the base
        responses
            (c, 2 n + 3) what the base does not prescribe: gap or p, slip or q of each node, then
            approach, U, tilt
        """
        n = len(self.normal)

        def read(rows_read: Indices, is_response: Mask) -> Array:
            """(c, len(rows_read)) the responses of rows, or what the base prescribes in them."""
            values = responses.take(rows_read, axis=1)
            if not is_response.all():
                prescribed_rows = rows_read[~is_response]
                values[:, ~is_response] = np.equal.outer(cases, prescribed_rows)
            return values

        node = rows % n
        state = row_states[rows]
        is_normal = rows < n
        reads_displacement = np.where(is_normal, state != OPEN, (state == STICK) & self.shears)
        readings = read(rows, base.is_held[rows] != reads_displacement)
        # The force of a tangential row is q beyond what the base takes along with p.
        traction_apart = base.traction[node] - self.friction * slip_sign(state)
        takes_pressure = ~is_normal & ~reads_displacement & (traction_apart != 0)
        with_pressure = takes_pressure.nonzero()[0]
        nodes = node[with_pressure]
        pressure = read(nodes, base.is_held[nodes])
        readings[:, with_pressure] += traction_apart[with_pressure] * pressure
        return readings

    def corrections(self, states: States, n_loads: int, changes: Array) -> Array:
        """Derivatives of the contact's values by its loads while the nodes keep their states, and
        their response to changes of all equations, by a factorisation of this set's own equations.

        The values are approach, U and tilt, then slip, p, q and gap of the n nodes.

        Parameters
        ----------
        states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (bulk stresses and tilt too)
        changes
            (2 n,) changes of the right sides at constant loads: of p or gap of each node, then of
            slip or q - (+-f) p

        Returns
        -------
        ndarray
            (n_loads + 1, 3 + 4 n), the last row by the changes

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.
        """
        n = len(states)
        self.work["linear solves"] += 1
        if self._is_nested(states):
            return self._values_of_nested(states, n_loads, np.arange(2 * n), changes)
        if not (self._holds_without_stick or STICK in states):
            raise SingularSet("no node sticks: the bodies slide on each other")
        key = states.tobytes()
        base = self._factorised.pop(key, None)
        if base is None:
            base = self._new_base(np.concatenate([states, states]), None)
        self._factorised[key] = base  # what was used last comes last
        if len(self._factorised) > _MOST_FACTORISED_SETS:
            del self._factorised[next(iter(self._factorised))]
        rows_of_loads = np.arange(2 * n, 2 * n + n_loads)
        case_of_changes = n_loads
        # Columns are load cases, then the changes; rows p, q, approach, U, bulk stresses, tilt.
        unknowns = np.zeros((2 * n + 5, n_loads + 1))
        unknowns[rows_of_loads[2:], np.arange(2, n_loads)] = 1.0
        unknowns[base.free, case_of_changes] = changes[base.free]
        right_side = -self.matrix[base.held] @ unknowns
        right_side[base.place_in_held[rows_of_loads[:2]], np.arange(2)] += 1.0
        is_of_node = base.held < 2 * n
        right_side[is_of_node, case_of_changes] += changes[base.held[is_of_node]]
        assert base.equations is not None  # for the type checker: it has no origin
        unknowns[base.held] = _lu_solve(base.equations.of_held, right_side)
        # So far q - (+-f) p stands where a node slides.
        unknowns[n : 2 * n] += base.traction[:, None] * unknowns[:n]
        displacements = self.matrix[: 2 * n] @ unknowns
        values = np.empty((n_loads + 1, 3 + 4 * n))
        values[:, :3] = unknowns[[2 * n, 2 * n + 1, 2 * n + 4]].T  # approach, U, tilt
        values[:, 3 : 3 + n] = displacements[n:].T  # slip
        values[:, 3 + n : 3 + 3 * n] = unknowns[: 2 * n].T  # pressure and shear
        values[:, 3 + 3 * n :] = displacements[:n].T  # gap
        return values

    def _base_for(self, states: States) -> tuple[_Base, Mask]:
        """Choose the set of node states whose cached responses those of a new set `states` (n,) are
        computed from, the base; and the equations (2 n,) in which the two differ.

        It is the base from which the new set was reached before, else the one that differs in the
        fewest equations. Where that is far, the new set becomes a base itself.

        Raises
        ------
        SingularSet
            Where no node sticks and nothing else holds the bodies.
        """
        # An update of a base makes a pivot of rounding from the zero that this is.
        if not (self._holds_without_stick or STICK in states):
            raise SingularSet("no node sticks: the bodies slide on each other")
        key = states.tobytes()
        kinds = _kinds(np.concatenate([states, states]))
        base = next((base for base in self._bases if key in base.sets_reached), None)
        if base is None:
            base = self._nearest(self._bases, kinds, _MOST_ROWS)
        if base is None:
            row_states = np.concatenate([states, _sliding_where_open(states)])
            factorised_bases = [base for base in self._bases if base.origin is None]
            origin = self._nearest(factorised_bases, _kinds(row_states), _MOST_ROWS_APART)
            base = self._new_base(row_states, origin)
        # Bases are dropped from the front: what was used last comes last, and the base from which
        # this one is computed after it.
        for used_base in (base, base.origin):
            if used_base in self._bases:
                self._bases.remove(used_base)
            if used_base is not None:
                self._bases.append(used_base)
        base.sets_reached.add(key)
        return base, (base.kinds & kinds) == 0

    @staticmethod
    def _nearest(
        bases: Sequence[_Base], kinds: NDArray[np.int8], most_rows_apart: int
    ) -> _Base | None:
        """Of several sets of node states, the one that differs in the fewest equations from a new
        set, if these are `most_rows_apart` or fewer; else None.

        `kinds` (2 n,) are the equations of the new set as bits: two equations differ if they have
        no bit in common.
        """
        if not bases:
            return None
        rows_apart = [len(kinds) - np.count_nonzero(base.kinds & kinds) for base in bases]
        least_rows = min(rows_apart)
        return bases[rows_apart.index(least_rows)] if least_rows <= most_rows_apart else None

    def _new_base(self, row_states: States, origin: _Base | None) -> _Base:
        """Prepare a set of node states whose responses are to be cached: which displacements and
        forces it prescribes, and where each value of a contact state comes from.

        Its equations are factorised, unless its responses are to be computed from those of an
        `origin`, another such set. `row_states` (2 n,) are the states of the n nodes for their
        normal equations, then for their tangential ones.
        """
        n = len(self.normal)
        states = row_states[:n]
        sticks = (states == STICK) & self.shears
        is_held = np.concatenate([states != OPEN, sticks])
        held = np.concatenate([is_held.nonzero()[0], [2 * n, 2 * n + 1]])
        free = (~is_held).nonzero()[0]
        traction = np.asarray(slip_sign(row_states[n:]) * self.friction, dtype=np.float64)
        place_in_held = np.full(2 * n + 5, -1)
        place_in_held[held] = np.arange(len(held))
        response_of_row = np.arange(2 * n)
        prescribed_of_row = 2 * n + 3 + response_of_row
        source_of_force = np.where(is_held, response_of_row, prescribed_of_row)
        source_of_displacement = np.where(is_held, prescribed_of_row, response_of_row)
        sources_in_order = [
            np.arange(2 * n, 2 * n + 3),  # approach, shift, tilt
            source_of_displacement[n:],  # slip
            source_of_force,  # pressure and shear
            source_of_displacement[:n],  # gap
        ]
        return _Base(
            row_states=row_states,
            kinds=_kinds(row_states),
            traction=traction,
            is_held=is_held,
            held=held,
            free=free,
            place_in_held=place_in_held,
            value_sources=np.concatenate(sources_in_order),
            equations=self._factorise(states, held, free) if origin is None else None,
            origin=origin,
            case_number=np.full(2 * n + 5, -1),
            responses=np.empty((0, 2 * n + 3)),
        )

    def _factorise(self, states: States, held: Indices, free: Indices) -> _HeldEquations:
        """LU factors of the equations of a set of node states: displacements of the held equations
        by their forces; and displacements of the others by these forces.

        Parameters
        ----------
        states
            (n,) open, stick or slip
        held
            (k,) equations that prescribe a displacement (gap or slip), then P and Q
        free
            (n_free,) equations that prescribe a force
        """
        self.work["factorisations"] += 1
        # Of a sliding node q = (+-f) p is no unknown: its effect is added to that of p.
        sliding_nodes = slip_sign(states).nonzero()[0]
        traction = slip_sign(states[sliding_nodes]) * self.friction
        places_of_pressure = np.searchsorted(held, sliding_nodes)
        columns_of_shear = len(states) + sliding_nodes

        def displacements_by_held(rows: Indices) -> Array:
            """(len(rows), k) displacements of some rows by forces of the k held ones."""
            displacements = self.matrix[np.ix_(rows, held)]
            by_shear = self.matrix[np.ix_(rows, columns_of_shear)]
            displacements[:, places_of_pressure] += by_shear * traction
            return displacements

        return _HeldEquations(_lu(displacements_by_held(held)), displacements_by_held(free))

    def _solve_cases(self, base: _Base, required: Indices) -> None:
        """Compute and cache responses of a set of node states, the base, to unit right sides of
        single equations or unit loads, where they are not cached yet.

        Responses of neighbouring nodes are computed along with them, since edges of contact and
        stick travel from node to node. `required` are numbers: i normal, n + i tangential, 2 n and
        above loads. Old bases are dropped beyond a number of bytes.
        """
        missing_cases = required[base.case_number[required] < 0]
        if not len(missing_cases):
            return
        n = len(base.traction)
        missing_rows = missing_cases[missing_cases < 2 * n]
        steps_to_neighbours = np.arange(-_N_NEIGHBOURS, _N_NEIGHBOURS + 1)
        neighbours = np.add.outer(missing_rows, steps_to_neighbours).clip(0, 2 * n - 1)
        unsolved_neighbours = neighbours[base.case_number[neighbours] < 0]
        cases = np.union1d(unsolved_neighbours, missing_cases)
        if base.equations is not None:
            responses = self._responses_by_equations(base, base.equations, cases)
        else:
            assert base.origin is not None  # for the type checker: it has factors or an origin
            responses = self._responses_by_origin(base, base.origin, cases)
        n_cases = base.n_cases + len(cases)
        if n_cases > len(base.responses):  # more room than is needed, so that it is seldom copied
            solved_responses = base.responses[: base.n_cases]
            base.responses = np.empty((int(_SPARE_ROOM * n_cases), 2 * n + 3))
            base.responses[: base.n_cases] = solved_responses
        base.responses[base.n_cases : n_cases] = responses
        base.case_number[cases] = np.arange(base.n_cases, n_cases)
        base.n_cases = n_cases
        while (
            len(self._bases) > _FEWEST_BASES
            and sum(base.nbytes for base in self._bases) > _MOST_BYTES
        ):
            self._bases.pop(0)

    def _responses_by_equations(
        self, base: _Base, equations: _HeldEquations, cases: Indices
    ) -> Array:
        """Responses (c, 2 n + 3) of a set of node states to c unit right sides, by its factorised
        equations.

        In an equation that prescribes a force (free) that is a unit force, which moves all nodes;
        in one that prescribes a displacement (held) it is a unit displacement. Forces of the held
        equations follow, and with them the free displacements:

            of_held @ forces = prescribed displacement - displacements_by_force of held ones
            free_displacements = free_by_held @ forces + displacements_by_force of free ones

        `cases` are numbers of equations (i normal, n + i tangential) and, from 2 n on, loads.
        """
        n = len(self.normal)
        place_in_held = base.place_in_held[cases]
        is_held = place_in_held >= 0
        displacements_by_force = np.zeros((2 * n + 2, len(cases)))
        displacements_by_force[:, ~is_held] = self.matrix[:, cases[~is_held]]
        is_open = ~is_held & (cases < n)
        open_nodes = cases[is_open]
        by_shear = self.matrix[:, n + open_nodes]
        displacements_by_force[:, is_open] += by_shear * base.traction[open_nodes]
        held_displacements = -displacements_by_force[base.held]
        held_displacements[place_in_held[is_held], is_held.nonzero()[0]] += 1.0
        forces = _lu_solve(equations.of_held, held_displacements)
        free_displacements = equations.free_by_held @ forces + displacements_by_force[base.free]
        responses = np.empty((len(cases), 2 * n + 3))
        responses[:, base.held] = forces.T  # approach and U come last in both
        responses[:, base.free] = free_displacements.T
        responses[:, 2 * n + 2] = cases == 2 * n + 4  # the tilt
        return responses

    def _responses_by_origin(self, base: _Base, origin: _Base, cases: Indices) -> Array:
        """Responses (c, 2 n + 3) of a set of node states, the base, to c unit right sides, from
        those of another set, its origin, by an update of low rank.

        Where one of the two prescribes a displacement and the other the force, the amplitude that
        the update finds for the origin is the response of the base. `cases` are numbers of
        equations (i normal, n + i tangential) and, from 2 n on, loads.
        """
        n = len(self.normal)
        rows_apart = ((origin.kinds & base.kinds) == 0).nonzero()[0]
        is_apart = np.isin(cases, rows_apart)
        given = np.equal.outer(cases[is_apart], rows_apart).astype(np.float64)
        update = self._updated(origin, base.row_states, rows_apart, cases[~is_apart], given)
        order_of_update = np.concatenate([(~is_apart).nonzero()[0], is_apart.nonzero()[0]])
        responses = np.empty_like(update.responses)
        responses[order_of_update] = update.responses
        changes_roles = origin.is_held[rows_apart] != base.is_held[rows_apart]
        rows_with_roles_changed = rows_apart[changes_roles]
        responses[np.ix_(order_of_update, rows_with_roles_changed)] = update.amplitudes[
            :, changes_roles
        ]
        # The force that the origin prescribes in a tangential row is q - (+-f) p; where it slides
        # and the base sticks, q is the response.
        sticking_nodes = rows_with_roles_changed[rows_with_roles_changed >= n] - n
        sticking_nodes = sticking_nodes[base.is_held[n + sticking_nodes]]
        pressure = responses[:, sticking_nodes]
        responses[:, n + sticking_nodes] += origin.traction[sticking_nodes] * pressure
        return responses
