"""Linear systems of the active set: what loads do to the interface while its nodes keep their
states, for many sets of states.

Unknowns z = (p, q, delta, U); each node has two equations, by its state:

    open    p = 0,             q = 0
    stick   gap = 0,           slip = known
    slip    gap = 0,           q - (+-f) p = 0

and two equations for the loads; U = 0 is the second where Q is zero by symmetry, or where there is
no shear. Where the movement of an actuator stands in the place of a load, its equation is that of
`actuators`. A state of a node is a choice of equations, so that the matrix of a set differs from
that of a base set in a few rows alone (Sherman-Morrison-Woodbury).

An equation pairs a displacement with the force in its direction: gap with pressure, slip with
shear. It is *held* where the states prescribe the displacement, and *free* where they prescribe the
force; the other of the two is its response. Where a node slides, the force of its tangential
equation is q - (+-f) p.

Of a base the responses to unit cases are cached: to 1 in what it prescribes in one equation, and to
each unit load. A set is reached from the base by amplitudes of its unit cases. With v the responses
to a load, c_r those to the unit case of equation r, and R what the set prescribes in the equations
in which it differs from the base,

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

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import OPEN, SLIP_FORWARD, STICK, ConvergenceError, InputError
from scenes.array_types import Array, Indices, Mask, States

LuFactors = tuple[Array, NDArray[np.int32]]

# Bytes of bases, and so many at least: a cycle meets the same sets again and again. A record of
# 2,000 rows on a pad makes 22 bases then, as with any number of bytes beyond; with 40 MB it makes
# 136.
_MOST_BASE_BYTES = 80_000_000
_FEWEST_BASES = 4
# Equations in which a set may differ from its base: beyond that the set becomes a base itself.
_MOST_UPDATED_EQUATIONS = 110
# Bits of `_equation_bits` by state: OPEN, STICK, SLIP_FORWARD, SLIP_REVERSE.
_NORMAL_EQUATION_BITS = np.array([1, 2, 2, 2], dtype=np.int8)
_TANGENTIAL_EQUATION_BITS = np.array([2 + 4, 1, 2, 4], dtype=np.int8)
# Equations in which a base may differ from one with factors for its values to be updates of those:
# of 700 nodes updates cost less than factors up to there.
_MOST_EQUATIONS_FROM_ORIGIN = 300
# Sets of which `newton_correction` keeps the factors: the iterations of an increment go to and fro
# between few of them.
_MOST_FACTORISED_SETS = 8
# Nodes on either side of one that is needed whose values are found along with it: edges of contact
# and stick travel from node to node.
_N_NEIGHBOURS = 16
# Room for responses of a base over what is needed when it is made.
_SPARE_ROOM = 1.5
# Rows that are multiplied with a matrix one by one: faster up to as many as P, Q and changes have.
_FEW_ROWS = 3
# Rows of a triangle that are multiplied at once: read from memory once for both products, and not
# beyond the diagonal.
_ROWS_PER_BLOCK = 256


class Actuators(NamedTuple):
    """Which of the first two loads, P and Q, are replaced by movements of actuators; see
    `actuators` for the equations.

    Attributes
    ----------
    normal_compliance, tangential_compliance
        compliance between actuator and contact, times E*; None where P or Q is given
    """

    normal_compliance: float | None = None
    tangential_compliance: float | None = None

    @property
    def prescribe_approach(self) -> bool:
        """Whether a movement stands in the place of P."""
        return self.normal_compliance is not None

    @property
    def prescribe_displacement(self) -> bool:
        """Whether a movement stands in the place of Q."""
        return self.tangential_compliance is not None

    @property
    def prescribe_movements(self) -> bool:
        """Whether a movement stands in the place of P or of Q."""
        return self.prescribe_approach or self.prescribe_displacement


LOADS_ARE_GIVEN = Actuators()


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""


def _lu(matrix: Array) -> LuFactors:
    """LU factors of a square matrix; SingularSet where a pivot is exactly zero."""
    factors, pivots, zero_pivot = dgetrf(matrix)
    if zero_pivot > 0:
        raise SingularSet(f"pivot {zero_pivot} is zero")
    return factors, pivots


def _lu_solve(factors: LuFactors, right_side: Array) -> Array:
    """Solution X (k, m) of A X = `right_side`, by the LU factors of A (k, k)."""
    return np.asarray(dgetrs(*factors, right_side)[0])


def _few_rows_times(rows: Array, matrix: Array) -> Array:
    """Product (k, n) of a matrix of few rows (k, m) and a matrix (m, n), row by row where k <= 3
    (`_FEW_ROWS`). There numpy's product of two matrices would begin with a copy of both.
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

    normal_compliance: Array
    tangential_compliance: Array


class _HeldEquations(NamedTuple):
    """Compliance of the contact for one set of node states: displacements by forces in the k held
    equations, those that prescribe a gap, a slip, or the load P or Q.

    Attributes
    ----------
    held_by_held
        factors of (k, k) displacements of held equations by forces of held equations
    free_by_held
        (n_free, k) displacements of free equations by forces of held equations
    """

    held_by_held: LuFactors
    free_by_held: Array

    @property
    def nbytes(self) -> int:
        """Bytes of both matrices."""
        return self.held_by_held[0].nbytes + self.free_by_held.nbytes


@dataclass(eq=False)
class _Base:
    """A set of node states of which responses to unit cases are cached.

    Attributes
    ----------
    equation_states
        (2 n,) states of the nodes for their normal equations, then for their tangential ones: there
        open nodes may count as sliding
    equation_bits
        (2 n,) type of each equation, see `_equation_bits`
    signed_friction
        (n,) q over p: +f or -f of the nodes that slide, open ones that count as sliding among
        them; else 0
    prescribes_displacement
        (2 n,) whether the displacement of each equation is prescribed
    held_equations
        (k,) equations whose displacement is prescribed, then P and Q: what responds to these is
        solved for
    free_equations
        (n_free,) equations whose force is prescribed
    position_in_held
        (2 n + 5,) of each equation and load, -1 of those that are not among `held_equations`
    value_sources
        (3 + 4 n,) where each value of an interface state comes from: the 2 n + 3 responses, or
        the 2 n prescribed values of the equations, which follow them. Shear is the force of its
        equation
    factors
        of its own equations; None where it has an origin
    origin
        the base from whose responses its own are found
    response_row_of_case
        (2 n + 5,) row of `responses` for the unit case of each equation and load, -1 where that is
        not solved yet
    responses
        (m, 2 n + 3) to unit cases, of which `n_solved_cases` are solved: of each equation, then
        approach, U and tilt
    n_solved_cases
        number of unit cases that are solved
    sets_served
        bytes of the node states whose responses were computed from this base: met again, they are
        computed from it again, to the same last digit
    """

    equation_states: States
    equation_bits: States
    signed_friction: Array
    prescribes_displacement: Mask
    held_equations: Indices
    free_equations: Indices
    position_in_held: Indices
    value_sources: Indices
    factors: _HeldEquations | None
    origin: _Base | None
    response_row_of_case: Indices
    responses: Array
    n_solved_cases: int = 0
    sets_served: set[bytes] = field(default_factory=set)

    @property
    def nbytes(self) -> int:
        """Bytes of the large arrays of the base: factors of its equations and cached responses."""
        bytes_of_factors = 0 if self.factors is None else self.factors.nbytes
        return bytes_of_factors + self.responses.nbytes


class _Update(NamedTuple):
    """Responses of a set of node states in c load cases, computed from those of another set, the
    base.

    Attributes
    ----------
    responses
        (c, 2 n + 3) of each case: what the base does not prescribe
    equation_numbers
        (m,) in which the set differs from the base
    amplitudes
        (c, m) factors of the base's responses to unit right sides in these: what the base
        would prescribe there
    """

    responses: Array
    equation_numbers: Indices
    amplitudes: Array


def _equation_bits(equation_states: States) -> NDArray[np.int8]:
    """Type of each equation of a set of node states, as bits (2 n,): normal equations, then
    tangential ones. Two sets differ in an equation where their bits have none in common.

    Normal: 1 where p = 0 (open), 2 where the gap is 0. Tangential: 1 for stick, 2 and 4 for slip in
    either sense. An open node has both bits of slip: with p = 0, q = (+-f) p is q = 0.
    """
    n = len(equation_states) // 2
    # _NORMAL_EQUATION_BITS: bits by the number of a state
    return np.concatenate(
        [
            _NORMAL_EQUATION_BITS.take(equation_states[:n]),
            _TANGENTIAL_EQUATION_BITS.take(equation_states[n:]),
        ]
    )


def _sliding_where_open(node_states: States) -> States:
    """States (n,) of the nodes, with each open node in the state of the nearest sliding node, or
    slipping forward where none slides: it will probably slide like that once it touches.
    """
    # States are numbered 0 open, 1 stick, 2 and 3 slip forward and in reverse.
    sliding_nodes = np.flatnonzero(node_states > STICK)
    if not len(sliding_nodes):
        return np.where(node_states == OPEN, SLIP_FORWARD, node_states)
    distances = np.abs(np.subtract.outer(np.arange(len(node_states)), sliding_nodes))
    state_of_nearest_sliding_node = node_states[sliding_nodes[distances.argmin(axis=1)]]
    return np.where(node_states == OPEN, state_of_nearest_sliding_node, node_states)


class _NestedCompliance:
    """A compliance C (n, n) in one direction, solved with the first k nodes, for any k, held at
    known displacements.

    Attributes
    ----------
    compliance
        (n, n) C
    inverse_factor
        (n, n) X = L^-1 of C = L L^T
    unit_motion_forces
        (n, n) in row k - 1 the forces at the first k nodes that displace each of these by 1
    unit_motion_displacements
        (n, n) in row k - 1 the displacements of all nodes by these forces
    load_per_motion
        (n,) sum of these forces: load per rigid motion where the first k nodes are held
    """

    def __init__(self, compliance: Array, factor: Array) -> None:
        self.compliance = compliance
        self.inverse_factor = np.ascontiguousarray(dtrtri(factor, lower=1)[0])
        sum_of_row = self.inverse_factor.sum(axis=1)[:, None]
        self.unit_motion_forces = np.cumsum(self.inverse_factor * sum_of_row, axis=0)
        self.unit_motion_displacements = np.cumsum(factor.T * sum_of_row, axis=0)
        self.load_per_motion = self.unit_motion_forces.sum(axis=1)

    def forces_and_displacements(
        self,
        n_held: int,
        n_touching: int,
        known_values: Array,
        load_or_actuator_movement: Array,
        actuator_compliance: float | None,
    ) -> tuple[Array, Array, Array]:
        """Nodal forces F, rigid motion r of the body and nodal displacements C F - r under a load,
        in m load cases. The first k nodes are held at known displacements, the others carry known
        forces.

        Forces at r = 0 are found first. Then the body is moved by the r at which all forces add up
        to the load. C is the compliance matrix (`self.compliance`).

        Prepared for each k, in row k - 1, is a motion of the k held nodes by 1: the forces on them
        (`unit_motion_forces`), the sum of these (`load_per_motion`), and the displacements of all
        nodes by these forces (`unit_motion_displacements`).

        Parameters
        ----------
        n_held
            k: of the first k nodes the displacement is known, of the others F
        n_touching
            number of nodes beyond which the known F is most often 0
        known_values
            (n, m) the known displacement or force of each node
        load_or_actuator_movement
            (m,) the load, sum of F; or, where an actuator moves the body, the actuator's
            movement r + c times the load
        actuator_compliance
            c between actuator and body; None where the load is given

        Returns
        -------
        forces, rigid_motion, displacements
            F (n, m), r (m,), C F - r (n, m).

        Raises
        ------
        InputError
            If the actuator's movement does not grow with the load, since c is negative.
        """
        forces = known_values.copy()
        displacements = known_values.copy()
        displacements[n_held:] = 0.0

        # Forces by the known values at r = 0, and the rigid motion that then makes their sum 0.
        motion_by_known_values: Array | float = 0.0
        if known_values.any():
            n_loaded = len(known_values) if known_values[n_touching:].any() else n_touching
            displacements_by_held_forces = (
                known_values[:n_held]
                - self.compliance[:n_held, n_held:n_loaded] @ known_values[n_held:n_loaded]
            )
            forces[:n_held] = self._held_forces(displacements_by_held_forces)
            displacements[n_held:] = self.compliance[n_held:, :n_loaded] @ forces[:n_loaded]
            motion_by_known_values = -forces.sum(axis=0) / self.load_per_motion[n_held - 1]

        # The load, where an actuator moves the body: the actuator's movement is r + c times it.
        load = load_or_actuator_movement
        if actuator_compliance is not None:
            actuator_movement_per_load = 1 / self.load_per_motion[n_held - 1] + actuator_compliance
            if not actuator_movement_per_load > 0:
                raise InputError(
                    "rig.datum_length: the contact moves against its load where the displacement is"
                    " prescribed, so that no load follows from it: state a longer distance"
                )
            load = (load_or_actuator_movement - motion_by_known_values) / actuator_movement_per_load

        # Forces and displacements by the rigid motion are added.
        rigid_motion = load / self.load_per_motion[n_held - 1] + motion_by_known_values
        forces[:n_held] += np.multiply.outer(
            self.unit_motion_forces[n_held - 1, :n_held], rigid_motion
        )
        displacements[n_held:] += np.multiply.outer(
            self.unit_motion_displacements[n_held - 1, n_held:] - 1, rigid_motion
        )
        return forces, rigid_motion, displacements

    def _held_forces(self, displacements_of_held: Array) -> Array:
        """Forces (k, m) on the first k nodes that displace these nodes by given amounts (k, m), in
        m load cases, without forces on the others.

        They are the inverse of the leading k x k block of the compliance C times the amounts. No k
        needs a factorisation of its own: with C = L L^T that inverse is X_k^T X_k, X_k being the
        leading block of L^-1 (`self.inverse_factor`). 256 rows of X_k are taken at a time.
        """
        n_held = len(displacements_of_held)
        forces = np.zeros_like(displacements_of_held)
        for row_end in range(_ROWS_PER_BLOCK, n_held + _ROWS_PER_BLOCK, _ROWS_PER_BLOCK):
            n_columns = min(row_end, n_held)
            rows_of_inverse = self.inverse_factor[row_end - _ROWS_PER_BLOCK : n_columns, :n_columns]
            forces[:n_columns] += rows_of_inverse.T @ (
                rows_of_inverse @ displacements_of_held[:n_columns]
            )
        return forces


@dataclass(eq=False)
class Systems:
    """Linear equations of a contact while its nodes keep their states (open, stick, slip), and
    their solutions, cached for many sets of states.

    Attributes
    ----------
    interface, layer
        the two bodies as one compliance; the penalty layer between them
    friction
        coefficient f
    work_counts
        counts of factorisations, updates and solves, added to here
    has_shear
        False where there can be no shear: nodes then carry none, whether they stick or not
    actuators
        compliances of actuators whose movements stand in the place of loads
    normal_compliance, tangential_compliance
        (n, n) compliances of interface and layer together, gap by p and -slip by q
    contact_matrix
        of the equations, see `_assembled_matrix`

    Raises
    ------
    ConvergenceError
        If a compliance is not positive definite.
    """

    interface: Interface
    layer: Layer
    friction: float
    work_counts: Counter[str] = field(default_factory=Counter)
    has_shear: bool = True
    actuators: Actuators = LOADS_ARE_GIVEN

    def __post_init__(self) -> None:
        """Assemble the matrix of the contact's linear equations, and factorise the normal and the
        tangential compliance by Cholesky: ConvergenceError where one is not positive definite.

        The factors are kept where pressure does not depend on shear. There they serve contacts
        whose nodes, by ascending x, first stick, then slide, then are open.

        - `interface` (`faces` below): compliance matrices (n, n) of both bodies together; `layer`:
          compliances (n,) of a penalty layer between them.
        - `has_shear`: False where there can be no shear.
        - `faces.has_odd_shear`: by symmetry the shear has no resultant; `faces.coupling`: slip by
          pressure, None where uncoupled.
        - `_displacement_is_zero`: whether the tangential displacement U is 0: there is no shear, or
          it has no resultant. `_displacement_needs_no_stick`: whether U is determined though no
          node sticks, as an actuator's movement or 0.
        """
        # Compliance of bodies and layer together.
        faces = self.interface
        self.normal_compliance = faces.normal_compliance + np.diag(self.layer.normal_compliance)
        self.tangential_compliance = faces.tangential_compliance + np.diag(
            self.layer.tangential_compliance
        )
        compliances = (
            (self.normal_compliance, self.tangential_compliance)
            if self.has_shear
            else (self.normal_compliance,)
        )
        try:
            factors = [
                cholesky(compliance, lower=True, check_finite=False) for compliance in compliances
            ]
        except LinAlgError as reason:
            raise ConvergenceError(
                f"contact: the compliance of the contact nodes is not positive definite: {reason}"
            ) from reason

        self._displacement_is_zero = faces.has_odd_shear or not self.has_shear
        self._displacement_needs_no_stick = (
            self._displacement_is_zero or self.actuators.prescribe_displacement
        )
        self.contact_matrix = self._assembled_matrix()

        # Caches. Sets of node states with cached responses; the one used last comes last.
        self._bases: list[_Base] = []
        # Sets with factors of their own, from `newton_correction`, by the bytes of their states.
        self._factorised_sets: dict[bytes, _Base] = {}
        self._nested_compliances: list[_NestedCompliance] = []  # normal, then tangential
        # Only on uncoupled flat faces without bulk stress and tilt is p independent of q.
        if (
            faces.coupling is None
            and faces.is_flat
            and faces.gap_and_slip_per_stress_and_tilt is None
        ):
            self._nested_compliances = [
                _NestedCompliance(compliance, factor)
                for compliance, factor in zip(compliances, factors, strict=True)
            ]

    def _assembled_matrix(self) -> Array:
        """Matrix (2 n + 2, 2 n + 5) of the contact of n nodes: it turns nodal forces, rigid motions
        and bulk stresses into gaps, slips, P and Q, whatever the states of the nodes.

        Rows: gap of the nodes, slip of the nodes, P, Q. Columns: p and q of the nodes, normal
        approach, tangential displacement U, both bulk stresses, tilt. With an actuator the row of
        its load gives its movement instead: c times the load plus the rigid motion, c being the
        compliance between actuator and contact. Where U is known to be 0 (`_displacement_is_zero`:
        no shear, or one without a resultant) the row of Q gives U.

        # notation: n_x, n_y components of the unit normal of the faces at each node, out of the
        # lower body
        """
        faces = self.interface
        n = len(faces.x)
        n_x, n_y = faces.face_normals

        # Gap and slip by the nodal forces p and q; the coupling is slip by p.
        matrix = np.zeros((2 * n + 2, 2 * n + 5))
        # The gaps' rows have the numbers of the columns of p; likewise slip and q.
        gap_rows = p_columns = slice(0, n)
        slip_rows = q_columns = slice(n, 2 * n)
        matrix[gap_rows, p_columns] = self.normal_compliance
        matrix[slip_rows, q_columns] = -self.tangential_compliance
        if faces.coupling is not None:
            matrix[gap_rows, q_columns] = -faces.coupling.T
            matrix[slip_rows, p_columns] = faces.coupling

        # Gap and slip by approach, U, bulk stresses and tilt.
        matrix[gap_rows, 2 * n] = -n_y
        matrix[slip_rows, 2 * n] = n_x
        matrix[gap_rows, 2 * n + 1] = n_x
        matrix[slip_rows, 2 * n + 1] = n_y
        if faces.gap_and_slip_per_stress_and_tilt is not None:
            matrix[: 2 * n, 2 * n + 2 :] = faces.gap_and_slip_per_stress_and_tilt.reshape(2 * n, 3)

        # P and Q as resultants of the nodal forces.
        matrix[2 * n, p_columns] = n_y
        matrix[2 * n, q_columns] = n_x
        if self._displacement_is_zero:
            matrix[2 * n + 1, 2 * n + 1] = 1.0
        else:
            matrix[2 * n + 1, p_columns] = -n_x
            matrix[2 * n + 1, q_columns] = n_y

        # Movements of actuators; a compliance is None where the load is given.
        for direction, compliance in enumerate(self.actuators):  # normal, tangential
            is_tangential = direction == 1
            if compliance is not None and not (is_tangential and self._displacement_is_zero):
                row = matrix[2 * n + direction]
                row *= compliance
                row[2 * n + direction] = 1.0
        return matrix

    def value_derivatives(
        self,
        node_states: States,
        n_loads: int,
        equation_numbers: Indices | None = None,
        changes: Array | None = None,
    ) -> Array:
        """Change of the contact by a unit of each load while its n nodes keep their states, and by
        given changes of what single nodes prescribe; all scaled.

        The state of a node prescribes two quantities, by a normal and a tangential equation: p = 0
        or gap = 0; q = 0, constant slip, or q - (+-f) p = 0.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (both bulk stresses and tilt too)
        equation_numbers
            equations whose prescribed quantity changes: i is the normal one of node i, n + i the
            tangential one; None for none
        changes
            (len(equation_numbers),) these changes, at constant loads

        Returns
        -------
        ndarray
            A row for each load, and a last one for the changes, if there are any. Columns:
            approach, displacement U and tilt, then slip, nodal forces p and q, and gap: 3 + 4 n.

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.
        InputError
            If an actuator moves the contact against its load, so that no load follows from it.

        Examples
        --------
        >>> springs = np.eye(2)  # two nodes, each on a spring of its own: one sticks, one slips
        >>> zeros = np.zeros(2)
        >>> places, normals = np.array([0.0, 1.0]), np.array([[0.0, 0.0], [1.0, 1.0]])
        >>> flat = Interface(places, np.ones(2), normals, zeros, springs, springs, None)
        >>> by_loads = Systems(flat, Layer(zeros, zeros), 0.5).value_derivatives(
        ...     np.array([1, 2], dtype=np.int8), 2
        ... )
        >>> by_loads[:, 5:9].tolist()  # p and q by P, then by Q: the second node carries q = f p
        [[0.5, 0.5, -0.25, 0.25], [0.0, 0.0, 1.0, 0.0]]
        """
        self.work_counts["linear solves"] += 1
        # By ascending x first stick, then slip, then open: Cholesky factors made once serve all.
        if self._is_nested(node_states):
            return self._values_of_nested(node_states, n_loads, equation_numbers, changes)
        # Else by an update of low rank from cached responses for similar states.
        return self._values_from_base(node_states, n_loads, equation_numbers, changes)

    def _is_nested(self, node_states: States) -> bool:
        """Whether, by ascending x, the first nodes stick, the next ones slide and the last are
        open, as on one half of a symmetric contact: a faster solution then exists. False where
        pressure depends on shear: `_nested_compliances` is then empty.
        """
        if not self._nested_compliances:
            return False
        n_touching_nodes = int(np.count_nonzero(node_states))
        n_sticking_nodes = int(np.count_nonzero(node_states == STICK))
        touching_states = node_states[:n_touching_nodes]
        return bool(
            n_sticking_nodes
            and touching_states.all()
            and (touching_states[:n_sticking_nodes] == STICK).all()
        )

    def _values_of_nested(
        self,
        node_states: States,
        n_loads: int,
        equation_numbers: Indices | None,
        changes: Array | None,
    ) -> Array:
        """Change of the contact by a unit of P and by a unit of Q while its nodes keep their
        states, for nested states: by ascending x the first nodes stick, the next slide, the last
        are open.

        Here p does not depend on q, so the normal problem is solved first: touching nodes have a
        prescribed gap, open ones a prescribed p. In the tangential problem sticking nodes have a
        prescribed slip, and sliding ones carry q = (+-f) p.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip
        n_loads
            2, of P and Q
        equation_numbers, changes
            equations (i normal, n + i tangential) whose prescribed quantity changes at constant
            loads, and by how much; None for none

        Returns
        -------
        ndarray
            A row for P and for Q, and a last one for `changes`, if there are any. Columns:
            approach, U and tilt, then slip, nodal forces p and q, and gap of the n nodes; scaled.
        """
        n = len(node_states)
        n_touching_nodes = int(np.count_nonzero(node_states))
        n_sticking_nodes = int(np.count_nonzero(node_states == STICK))
        n_cases = n_loads + (equation_numbers is not None)

        # Prescribed quantities (n, n_cases), normal and tangential: 0 but for the changes.
        prescribed_quantities = np.zeros((2, n, n_cases))
        if equation_numbers is not None:
            prescribed_quantities[equation_numbers // n, equation_numbers % n, n_loads] = changes
        prescribed_gap_or_force, prescribed_slip_or_force = prescribed_quantities
        # (n_cases,) P of each case, and Q of each: 1 in its own, 0 in the others.
        normal_load_of_case, tangential_load_of_case, *_ = np.eye(n_loads, n_cases)

        values = np.zeros((n_cases, 3 + 4 * n))
        # views (n, n_cases): what is written to them is written to `values`
        slip, normal_forces, tangential_forces, gap = (
            values[:, 3:].reshape(-1, 4, n).transpose(1, 2, 0)
        )

        # Normal problem: p, approach (column 0 of the values) and gap. The arguments begin with
        # how many nodes have a prescribed displacement, and how many touch. A compliance of
        # `actuators` is None where the load is given, and no actuator's movement.
        normal_problem = self._nested_compliances[0]
        normal_forces[:], values[:, 0], gap[:] = normal_problem.forces_and_displacements(
            n_touching_nodes,
            n_touching_nodes,
            prescribed_gap_or_force,
            normal_load_of_case,
            self.actuators.normal_compliance,
        )

        # Tangential problem: q, displacement U (column 1) and slip.
        if self.has_shear:
            tangential_problem = self._nested_compliances[1]
            # q displaces the faces against the slip: with the tangential compliance T the slip
            # is U - T q, the opposite of the displacement that is solved for.
            prescribed_displacement_or_force = prescribed_slip_or_force
            prescribed_displacement_or_force[:n_sticking_nodes] *= -1
            signed_friction = slip_sign(node_states) * self.friction  # q/p; 0 unless sliding
            prescribed_displacement_or_force += signed_friction[:, None] * normal_forces
            tangential_forces[:], values[:, 1], opposite_slip = (
                tangential_problem.forces_and_displacements(
                    n_sticking_nodes,
                    n_touching_nodes,
                    prescribed_displacement_or_force,
                    tangential_load_of_case,
                    self.actuators.tangential_compliance,
                )
            )
            slip[:] = -opposite_slip
        return values

    def _values_from_base(
        self,
        node_states: States,
        n_loads: int,
        equation_numbers: Indices | None,
        changes: Array | None,
    ) -> Array:
        """Change of the contact by a unit of each load while its nodes keep their states; for any
        states, from cached responses of similar ones (the base).

        Each node has two equations, i normal and n + i tangential. An equation of the base
        prescribes a displacement or the force in its direction; the other of the two is its
        response. Amplitudes are what the base prescribes in the equations that differ: such that
        the equations of the new states are met.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (both bulk stresses and tilt too)
        equation_numbers, changes
            equations whose prescribed quantity changes at constant loads, and by how much; None
            for none

        Returns
        -------
        ndarray
            A row for each load, and a last one for `changes`, if there are any. Columns: approach,
            U and tilt, then slip, nodal forces p and q, and gap of the n nodes; scaled.
        """
        n = len(node_states)
        # The base, and (2 n,) whether each of its equations differs from that of these states; to
        # these come the equations with changes.
        base, needs_update = self._base_for(node_states)
        right_sides = np.zeros((0, 2 * n))
        if equation_numbers is not None:
            needs_update[equation_numbers] = True
            # An open node with a given p has q = 0, not q = (+-f) p.
            needs_update[n + equation_numbers[equation_numbers < n]] = True
            right_sides = np.zeros((1, 2 * n))
            right_sides[0, equation_numbers] = changes

        # Update: responses to each load and to the changes, a row each; amplitudes, likewise.
        updated_equations = needs_update.nonzero()[0]
        equation_states = np.concatenate([node_states, node_states])
        load_numbers = np.arange(2 * n, 2 * n + n_loads)
        update = self._updated_responses(
            base,
            equation_states,
            updated_equations,
            load_numbers,
            right_sides[:, updated_equations],
        )

        # Each value is a response or an amplitude: `value_sources` is its index in a row of 2 n + 3
        # responses (with approach, U and tilt), then 2 n amplitudes, 0 where nothing differs.
        n_responses = 2 * n + 3
        responses_and_amplitudes = np.zeros((len(update.responses), n_responses + 2 * n))
        responses_and_amplitudes[:, :n_responses] = update.responses
        responses_and_amplitudes[:, n_responses + updated_equations] = update.amplitudes
        values = responses_and_amplitudes.take(base.value_sources, axis=1)
        _, normal_forces, tangential_forces, _ = values[:, 3:].reshape(-1, 4, n).transpose(1, 0, 2)
        # So far the tangential force is that of its equation, q - (+-f) p.
        tangential_forces += base.signed_friction * normal_forces
        return values

    def _updated_responses(
        self,
        base: _Base,
        equation_states: States,
        equation_numbers: Indices,
        unit_cases: Indices,
        right_sides: Array,
    ) -> _Update:
        """Responses of the contact for one set of node states from cached ones for another set, the
        base, by an update of low rank (Sherman-Morrison-Woodbury).

        Each of n nodes has a normal equation, number i, and a tangential one, n + i; loads have the
        numbers from 2 n on. An equation prescribes a displacement or the force in its direction. A
        response is a row of what the base does not prescribe: in each equation the other of the
        two, then approach, U and tilt. A unit case is a 1 in one equation or load, else 0.

        Where the sets differ, the base's response to a 1 in the equation is added, times an
        amplitude. The amplitudes are such that the new set's equations are met there:

            left sides in unit_cases + amplitudes @ left sides in responses to a 1 = right sides
            responses = responses to unit_cases + amplitudes @ responses to a 1

        The right sides are 0 in the unit cases. What is returned (responses and amplitudes) has a
        row for each of `unit_cases`, then one for each further right side.

        Parameters
        ----------
        base
            the set whose responses are cached
        equation_states
            (2 n,) state in the new set of the node of each equation: those in the normal direction,
            then those in the tangential one
        equation_numbers
            (m,) numbers of the equations in which the sets differ, or whose right side is given
        unit_cases
            (k,) numbers of the loads, or of equations common to both sets, that are 1 in the first
            k rows of what is returned
        right_sides
            (c, m) of the equations `equation_numbers`, in c further rows of what is returned
        """
        # Responses of the base to the unit cases and to a 1 in each of the m equations, cached or
        # solved here: `base.response_row_of_case` is the row of `base.responses` of each case.
        n_units = len(unit_cases)
        base_cases = np.concatenate([unit_cases, equation_numbers])
        self._solve_cases(base, base_cases)
        base_responses = base.responses.take(base.response_row_of_case[base_cases], axis=0)
        updated_responses = np.zeros((n_units + len(right_sides), base_responses.shape[1]))
        updated_responses[:n_units] = base_responses[:n_units]
        if not len(equation_numbers):
            return _Update(
                updated_responses, equation_numbers, np.zeros((len(updated_responses), 0))
            )

        # The m equations for the amplitudes.
        self.work_counts["factor updates"] += 1
        # (k + m, m) left sides of the new set's equations in the base's responses
        left_sides = self._left_sides(
            base, equation_states, equation_numbers, base_cases, base_responses
        )
        left_sides_by_amplitudes = left_sides[n_units:].T
        residuals = np.concatenate([-left_sides[:n_units], right_sides])
        amplitudes = _lu_solve(_lu(left_sides_by_amplitudes), residuals.T).T
        updated_responses += _few_rows_times(amplitudes, base_responses[n_units:])
        return _Update(updated_responses, equation_numbers, amplitudes)

    def _left_sides(
        self,
        base: _Base,
        equation_states: States,
        equation_numbers: Indices,
        cases: Indices,
        responses: Array,
    ) -> Array:
        """Left sides (c, m) of m equations of a new set of node states, evaluated in c solutions
        for another set, the base.

        The left side is what an equation prescribes: the normal one p of an open node, else the
        gap; the tangential one the slip of a sticking node, else q - (+-f) p. A solution for the
        base holds both displacement and force of every node: one is prescribed, the other is the
        base's response. So the left side of any other state can be read from it.

        Parameters
        ----------
        base
            the set of the solutions: `prescribes_displacement` (2 n,) of its equations (else a
            force), `signed_friction` (n,) +-f of the nodes that slide in it, else 0
        equation_states
            (2 n,) states of the n nodes in the new set, whose equations are evaluated: for normal
            equations, then for tangential ones
        equation_numbers
            (m,) numbers of the equations: i normal, n + i tangential
        cases
            (c,) number of the equation or load that is 1 in each solution; all others are 0
        responses
            (c, 2 n + 3) what the base does not prescribe: gap or p, slip or q of each node, then
            approach, U, tilt
        """
        n = len(self.normal_compliance)

        def values_in_equations(equations_read: Indices, is_response: Mask) -> Array:
            """Displacements or forces (c, m) in m equations: a response where `is_response`, else
            what the base prescribes, 1 in the case of that equation and 0 in the others.
            """
            values = responses.take(equations_read, axis=1)
            if not is_response.all():
                prescribed_equations = equations_read[~is_response]
                values[:, ~is_response] = np.equal.outer(cases, prescribed_equations)
            return values

        # In each equation: does the new set prescribe a displacement, or a force?
        node_of_equation = equation_numbers % n
        state_of_equation = equation_states[equation_numbers]
        is_normal = equation_numbers < n
        new_prescribes_displacement = np.where(
            is_normal, state_of_equation != OPEN, (state_of_equation == STICK) & self.has_shear
        )
        # Where the base prescribes the displacement its response is the force, and vice versa.
        is_response = base.prescribes_displacement[equation_numbers] != new_prescribes_displacement
        left_sides = values_in_equations(equation_numbers, is_response)

        # The base's force in a tangential equation is q minus its own (+-f) p; the left side is q
        # minus that of the new set.
        friction_difference = base.signed_friction[node_of_equation] - self.friction * slip_sign(
            state_of_equation
        )
        needs_normal_force = ~is_normal & ~new_prescribes_displacement & (friction_difference != 0)
        columns_with_normal_force = needs_normal_force.nonzero()[0]
        normal_equations = node_of_equation[columns_with_normal_force]
        normal_forces = values_in_equations(
            normal_equations, base.prescribes_displacement[normal_equations]
        )
        left_sides[:, columns_with_normal_force] += (
            friction_difference[columns_with_normal_force] * normal_forces
        )
        return left_sides

    def newton_correction(self, node_states: States, n_loads: int, changes: Array) -> Array:
        """Change of the contact by a unit of each load while its nodes keep their states; also by
        given changes of what the states prescribe (a Newton step).

        A node's states prescribe two quantities: p (open) or the gap; the slip (stick) or
        q - (+-f) p. The equations of each set of states are factorised; the factors of the last
        eight sets are cached.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip
        n_loads
            2 (P and Q) or 5 (both bulk stresses and tilt too)
        changes
            (2 n,) changes of the prescribed quantities at constant loads: p or gap of each node,
            then slip or q - (+-f) p

        Returns
        -------
        ndarray
            (n_loads + 1, 3 + 4 n): a row for each load, the last one for `changes`. Columns:
            approach, U and tilt, then slip, nodal forces p and q, and gap of the n nodes; scaled.

        Raises
        ------
        SingularSet
            If so few nodes hold that the bodies are free to move.
        """
        n = len(node_states)
        self.work_counts["linear solves"] += 1
        # By ascending x first stick, then slip, then open: Cholesky factors made once serve all.
        if self._is_nested(node_states):
            return self._values_of_nested(node_states, n_loads, np.arange(2 * n), changes)
        if not (self._displacement_needs_no_stick or STICK in node_states):
            raise SingularSet("no node sticks: the bodies slide on each other")

        # Held equations of these states prescribe a displacement, or are P and Q; free ones
        # prescribe a force. `position_in_held`: place of an equation or load among the held ones.
        factorised_set = self._factorised_set(node_states)

        # What causes gaps, slips, P and Q, as the columns of the contact matrix: p, q, approach,
        # U, bulk stresses, tilt; one column here for each load and for the changes. First what is
        # known: forces of free equations, bulk stresses, tilt.
        load_numbers = np.arange(2 * n, 2 * n + n_loads)
        case_of_changes = n_loads
        forces_and_motions = np.zeros((2 * n + 5, n_loads + 1))
        forces_and_motions[load_numbers[2:], np.arange(2, n_loads)] = 1.0
        forces_and_motions[factorised_set.free_equations, case_of_changes] = changes[
            factorised_set.free_equations
        ]

        # Then the forces of the held equations, approach and U: they leave the prescribed
        # displacements, and P and Q. `held_by_held`: factors of displacements by these forces.
        right_side = -self.contact_matrix[factorised_set.held_equations] @ forces_and_motions
        right_side[factorised_set.position_in_held[load_numbers[:2]], np.arange(2)] += 1.0
        is_of_node = factorised_set.held_equations < 2 * n
        right_side[is_of_node, case_of_changes] += changes[
            factorised_set.held_equations[is_of_node]
        ]
        assert factorised_set.factors is not None  # for the type checker: it has no origin
        forces_and_motions[factorised_set.held_equations] = _lu_solve(
            factorised_set.factors.held_by_held, right_side
        )
        # So far q - (+-f) p stands at n + i where node i slides; now q.
        forces_and_motions[n : 2 * n] += (
            factorised_set.signed_friction[:, None] * forces_and_motions[:n]
        )
        displacements = self.contact_matrix[: 2 * n] @ forces_and_motions  # gaps, slips

        values = np.empty((n_loads + 1, 3 + 4 * n))
        values[:, :3] = forces_and_motions[[2 * n, 2 * n + 1, 2 * n + 4]].T  # approach, U, tilt
        values[:, 3 : 3 + n] = displacements[n:].T  # slip
        values[:, 3 + n : 3 + 3 * n] = forces_and_motions[: 2 * n].T  # p and q
        values[:, 3 + 3 * n :] = displacements[:n].T  # gap
        return values

    def _factorised_set(self, node_states: States) -> _Base:
        """Factorised equations of one set of node states (n,); those of the last eight sets are
        cached, of which the one used last comes last.
        """
        states_bytes = node_states.tobytes()
        factorised_set = self._factorised_sets.pop(states_bytes, None)
        if factorised_set is None:
            factorised_set = self._new_base(np.concatenate([node_states, node_states]), None)
        self._factorised_sets[states_bytes] = factorised_set
        if len(self._factorised_sets) > _MOST_FACTORISED_SETS:
            del self._factorised_sets[next(iter(self._factorised_sets))]
        return factorised_set

    def _base_for(self, node_states: States) -> tuple[_Base, Mask]:
        """Choose the base for new node states (n,): a similar set of states with cached responses,
        from which those of the new states are computed. Also whether each equation differs (2 n,).

        It is the base that served these states before, else the one that differs in the fewest
        equations. If these are more than 110 (`_MOST_UPDATED_EQUATIONS`), the new states become a
        base themselves. Its responses then come from its own factorised equations, or from a
        factorised base, its origin, that differs in no more than 300
        (`_MOST_EQUATIONS_FROM_ORIGIN`).

        Raises
        ------
        SingularSet
            Where no node sticks and nothing else holds the bodies.
        """
        # Refused here: the matrix of these states is singular, but in an update from a base the
        # zero pivot would be a small number of round-off.
        if not (self._displacement_needs_no_stick or STICK in node_states):
            raise SingularSet("no node sticks: the bodies slide on each other")

        # A cached base, that of these states before or the nearest one. Equation bits: type of each
        # equation; two differ if they have no bit in common.
        states_bytes = node_states.tobytes()
        equation_bits = _equation_bits(np.concatenate([node_states, node_states]))
        base = next(
            (cached_base for cached_base in self._bases if states_bytes in cached_base.sets_served),
            None,
        )
        if base is None:
            base = self._nearest_base(self._bases, equation_bits, _MOST_UPDATED_EQUATIONS)

        # A new base; open nodes count as sliding like their neighbours in it.
        if base is None:
            equation_states = np.concatenate([node_states, _sliding_where_open(node_states)])
            factorised_bases = [
                cached_base for cached_base in self._bases if cached_base.origin is None
            ]
            origin = self._nearest_base(
                factorised_bases, _equation_bits(equation_states), _MOST_EQUATIONS_FROM_ORIGIN
            )
            base = self._new_base(equation_states, origin)

        # The list is in order of use, as bases are dropped from its front. The origin, from which
        # this base's responses are computed, comes last.
        for used_base in (base, base.origin):
            if used_base in self._bases:
                self._bases.remove(used_base)
            if used_base is not None:
                self._bases.append(used_base)
        base.sets_served.add(states_bytes)
        return base, (base.equation_bits & equation_bits) == 0

    @staticmethod
    def _nearest_base(
        bases: Sequence[_Base], equation_bits: NDArray[np.int8], most_equations_apart: int
    ) -> _Base | None:
        """Of several sets of node states, the one that differs in the fewest equations from a new
        set, if these are `most_equations_apart` or fewer; else None.

        `equation_bits` (2 n,) are the types of equation of the new set, normal then tangential, as
        bits: two equations differ if they have no bit in common.
        """
        if not bases:
            return None
        n_equations_apart = [
            len(equation_bits) - np.count_nonzero(base.equation_bits & equation_bits)
            for base in bases
        ]
        fewest_equations = min(n_equations_apart)
        return (
            bases[n_equations_apart.index(fewest_equations)]
            if fewest_equations <= most_equations_apart
            else None
        )

    def _new_base(self, equation_states: States, origin: _Base | None) -> _Base:
        """Prepare a base, a set of node states whose responses are to be cached: which equations
        prescribe a displacement and which a force, and where each value of the contact is found.

        An equation prescribes one of displacement and force in its direction; the other is its
        response. Equations 0 to n - 1 are normal, n to 2 n - 1 tangential; 2 n and 2 n + 1 are the
        loads P and Q. `equation_states` (2 n,) are the states of the n nodes for their normal
        equations, then for their tangential ones, where open nodes may count as sliding. The
        equations are factorised, unless the responses come from another base, the `origin`.
        """
        n = len(self.normal_compliance)
        node_states = equation_states[:n]

        # Held equations prescribe a gap or a slip, free ones a force.
        has_given_slip = (node_states == STICK) & self.has_shear
        prescribes_displacement = np.concatenate([node_states != OPEN, has_given_slip])
        held_equations = np.concatenate([prescribes_displacement.nonzero()[0], [2 * n, 2 * n + 1]])
        free_equations = (~prescribes_displacement).nonzero()[0]
        signed_friction = np.asarray(
            slip_sign(equation_states[n:]) * self.friction, dtype=np.float64
        )
        position_in_held = np.full(2 * n + 5, -1)
        position_in_held[held_equations] = np.arange(len(held_equations))

        # Values are picked by index from the 2 n + 3 responses followed by the 2 n prescribed
        # values. Where the displacement is prescribed (held) the response is the force.
        index_of_response = np.arange(2 * n)
        index_of_prescribed = 2 * n + 3 + index_of_response
        source_of_force = np.where(prescribes_displacement, index_of_response, index_of_prescribed)
        source_of_displacement = np.where(
            prescribes_displacement, index_of_prescribed, index_of_response
        )
        sources_in_order = [
            np.arange(2 * n, 2 * n + 3),  # approach, U, tilt
            source_of_displacement[n:],  # slip
            source_of_force,  # p and q
            source_of_displacement[:n],  # gap
        ]

        # No response is cached yet: -1 in `response_row_of_case`.
        return _Base(
            equation_states=equation_states,
            equation_bits=_equation_bits(equation_states),
            signed_friction=signed_friction,
            prescribes_displacement=prescribes_displacement,
            held_equations=held_equations,
            free_equations=free_equations,
            position_in_held=position_in_held,
            value_sources=np.concatenate(sources_in_order),
            factors=self._factorised(node_states, held_equations, free_equations)
            if origin is None
            else None,
            origin=origin,
            response_row_of_case=np.full(2 * n + 5, -1),
            responses=np.empty((0, 2 * n + 3)),
        )

    def _factorised(
        self, node_states: States, held_equations: Indices, free_equations: Indices
    ) -> _HeldEquations:
        """Factorise the linear equations of the contact for one set of node states: LU factors of
        the displacements in the k equations that prescribe one, by unit forces in these; and the
        displacements that these forces make in all other equations.

        An equation pairs gap with p, or slip with q, of a node. By the factors, forces follow from
        prescribed displacements. The last two of the k equations pair P with the approach and Q
        with U.

        Parameters
        ----------
        node_states
            (n,) open, stick or slip
        held_equations
            (k,) equations that prescribe a displacement (gap or slip), then P and Q
        free_equations
            (n_free,) equations that prescribe a force
        """
        self.work_counts["factorisations"] += 1
        # contact_matrix: gap and slip of the nodes, P and Q, by p and q, approach, U, bulk, tilt.
        # Where a node slides q = (+-f) p is no unknown: what q displaces is added to what p
        # displaces. `positions_of_p`: of these nodes' p among the held equations.
        sliding_nodes = slip_sign(node_states).nonzero()[0]
        signed_friction = slip_sign(node_states[sliding_nodes]) * self.friction
        positions_of_p = np.searchsorted(held_equations, sliding_nodes)
        columns_of_q = len(node_states) + sliding_nodes

        def displacements_by_held_forces(equation_numbers: Indices) -> Array:
            """Displacements of some equations by unit forces of the k held ones, (m, k)."""
            displacements = self.contact_matrix[np.ix_(equation_numbers, held_equations)]
            displacements_by_q = self.contact_matrix[np.ix_(equation_numbers, columns_of_q)]
            displacements[:, positions_of_p] += displacements_by_q * signed_friction
            return displacements

        return _HeldEquations(
            _lu(displacements_by_held_forces(held_equations)),
            displacements_by_held_forces(free_equations),
        )

    def _solve_cases(self, base: _Base, required_cases: Indices) -> None:
        """Compute and cache responses of the contact in one set of node states, the base, to unit
        cases: a 1 in what one equation prescribes, or a unit load. Cached ones are not repeated.

        The state of a node prescribes a gap or p, and a slip or q; the response is the other of
        each two. `required_cases` are numbers: i the normal equation of node i, n + i the
        tangential one, 2 n and above loads. The cases of 16 neighbouring nodes on either side are
        solved along with them, since edges of contact and stick travel from node to node. Beyond
        80 MB (`_MOST_BASE_BYTES`) the bases unused for longest are dropped, but for four.

        `base.response_row_of_case` is the row of `base.responses` for each case, -1 where it is not
        solved; its first `n_solved_cases` rows are filled. `base.factors` are those of its
        own equations; a base without them is computed from another one, its `origin`.
        """
        # Cases to solve: those missing, and the unsolved ones of neighbouring nodes.
        missing_cases = required_cases[base.response_row_of_case[required_cases] < 0]
        if not len(missing_cases):
            return
        n = len(base.signed_friction)
        missing_equations = missing_cases[missing_cases < 2 * n]
        offsets_of_neighbours = np.arange(-_N_NEIGHBOURS, _N_NEIGHBOURS + 1)
        neighbouring_equations = np.add.outer(missing_equations, offsets_of_neighbours).clip(
            0, 2 * n - 1
        )
        unsolved_equations = neighbouring_equations[
            base.response_row_of_case[neighbouring_equations] < 0
        ]
        cases = np.union1d(unsolved_equations, missing_cases)

        # Solve them, by factors of this base or by an update from those of its origin.
        if base.factors is not None:
            new_responses = self._responses_by_equations(base, base.factors, cases)
        else:
            assert base.origin is not None  # for the type checker: it has factors or an origin
            new_responses = self._responses_by_origin(base, base.origin, cases)

        # Add them to the cache.
        n_solved_in_all = base.n_solved_cases + len(cases)
        if n_solved_in_all > len(base.responses):
            # more room than is needed, so that it is seldom copied
            solved_responses = base.responses[: base.n_solved_cases]
            # _SPARE_ROOM: 1.5 of the rows needed now
            base.responses = np.empty((int(_SPARE_ROOM * n_solved_in_all), 2 * n + 3))
            base.responses[: base.n_solved_cases] = solved_responses
        base.responses[base.n_solved_cases : n_solved_in_all] = new_responses
        base.response_row_of_case[cases] = np.arange(base.n_solved_cases, n_solved_in_all)
        base.n_solved_cases = n_solved_in_all

        # Drop the bases unused for longest, which stand first.
        while (
            len(self._bases) > _FEWEST_BASES
            and sum(cached_base.nbytes for cached_base in self._bases) > _MOST_BASE_BYTES
        ):
            self._bases.pop(0)

    def _responses_by_equations(
        self, base: _Base, factors: _HeldEquations, cases: Indices
    ) -> Array:
        """Responses (c, 2 n + 3) of the contact in one set of node states, the base, to c unit
        cases, by its factorised equations. In each case one equation prescribes 1, or a load is 1.

        An equation is held where it prescribes a displacement, free where it prescribes a force;
        the other of the two is its response. Cases that prescribe a force, a bulk stress or the
        tilt displace all nodes (`displacements_by_free_case`). Forces in the held equations make up
        for what is missing to the prescribed displacements there; then the free displacements
        follow:

            held_by_held @ forces = prescribed displacements - held displacements_by_free_case
            free displacements = free_by_held @ forces + free displacements_by_free_case

        `cases` are numbers of equations (i normal, n + i tangential) and, from 2 n on, loads.
        `base.signed_friction` (n,) is +-f of the nodes that slide in the base, else 0.
        """
        n = len(self.normal_compliance)
        position_in_held = base.position_in_held[cases]  # -1 of the free cases
        is_held_case = position_in_held >= 0

        # Displacements by what is prescribed in these cases. The contact matrix is gap and slip of
        # the nodes, P and Q, by p and q of the nodes, approach, U, bulk stresses and tilt.
        displacements_by_free_case = np.zeros((2 * n + 2, len(cases)))
        displacements_by_free_case[:, ~is_held_case] = self.contact_matrix[:, cases[~is_held_case]]
        # A unit p of an open node: where it counts as sliding in the base, q = (+-f) p acts too.
        has_unit_pressure = ~is_held_case & (cases < n)
        open_nodes = cases[has_unit_pressure]
        displacements_by_q = self.contact_matrix[:, n + open_nodes]
        displacements_by_free_case[:, has_unit_pressure] += (
            displacements_by_q * base.signed_friction[open_nodes]
        )

        # Forces in the held equations, then the displacements of the free ones.
        held_displacements = -displacements_by_free_case[base.held_equations]
        held_displacements[position_in_held[is_held_case], is_held_case.nonzero()[0]] += 1.0
        forces = _lu_solve(factors.held_by_held, held_displacements)
        free_displacements = (
            factors.free_by_held @ forces + displacements_by_free_case[base.free_equations]
        )

        responses = np.empty((len(cases), 2 * n + 3))
        responses[:, base.held_equations] = forces.T  # approach and U come last in both
        responses[:, base.free_equations] = free_displacements.T
        responses[:, 2 * n + 2] = cases == 2 * n + 4  # the tilt
        return responses

    def _responses_by_origin(self, base: _Base, origin: _Base, cases: Indices) -> Array:
        """Responses (c, 2 n + 3) of the contact in one set of node states, the base, to c unit
        cases. They are an update of low rank of the responses of another set, its origin.

        In a unit case one equation prescribes 1, or one load is 1. An equation prescribes a
        displacement or a force; the other of the two is its response. The update adds the origin's
        responses, times amplitudes: an amplitude is what the origin's equation would prescribe.
        Where the base prescribes the displacement and the origin the force, or the reverse, the
        amplitude is therefore the base's response.

        Parameters
        ----------
        base, origin
            the two sets: type of each equation as bits, of which two that differ have none in
            common (`equation_bits`); which ones prescribe a displacement
            (`prescribes_displacement`); +-f of sliding nodes (`signed_friction`)
        cases
            numbers of equations (i normal, n + i tangential) and, from 2 n on, loads
        """
        n = len(self.normal_compliance)

        # Update from the origin in the equations in which the sets differ.
        differing_equations = ((origin.equation_bits & base.equation_bits) == 0).nonzero()[0]
        is_of_differing_equation = np.isin(cases, differing_equations)
        right_sides = np.equal.outer(cases[is_of_differing_equation], differing_equations).astype(
            np.float64
        )
        update = self._updated_responses(
            origin,
            base.equation_states,
            differing_equations,
            cases[~is_of_differing_equation],
            right_sides,
        )

        # Its rows in the order of `cases`: it returns the cases common to both sets first.
        order_of_update = np.concatenate(
            [(~is_of_differing_equation).nonzero()[0], is_of_differing_equation.nonzero()[0]]
        )
        responses_of_base = np.empty_like(update.responses)
        responses_of_base[order_of_update] = update.responses

        # Where the sets prescribe different ones of displacement and force.
        is_swapped = (
            origin.prescribes_displacement[differing_equations]
            != base.prescribes_displacement[differing_equations]
        )
        swapped_equations = differing_equations[is_swapped]
        responses_of_base[np.ix_(order_of_update, swapped_equations)] = update.amplitudes[
            :, is_swapped
        ]

        # The force that the origin prescribes in a tangential equation is q - (+-f) p; where it
        # slides and the base sticks, q is the response.
        sticking_nodes = swapped_equations[swapped_equations >= n] - n
        sticking_nodes = sticking_nodes[base.prescribes_displacement[n + sticking_nodes]]
        normal_forces = responses_of_base[:, sticking_nodes]
        responses_of_base[:, n + sticking_nodes] += (
            origin.signed_friction[sticking_nodes] * normal_forces
        )
        return responses_of_base
