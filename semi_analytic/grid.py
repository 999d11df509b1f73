"""Half-plane theory on a grid: contact with friction under any course of P, Q, bulk strain and
tilt, stick in any number of pieces.

The last resort: `memory` finds the stick edge itself, exact but for round-off; here cells stick,
slip or are open.

# notation: A = 2/E*; p, q tractions, constant over equal cells; C_ij = -(A/pi) int_cell ln|x_i -
#           xi| d xi, symmetric; g gap, s slip of the upper face over the lower, delta normal
#           approach, U displacement of the upper body, alpha tilt, eps = sigma_lower/E'_lower -
#           sigma_upper/E'_upper with E' = E/(1 - nu^2)

    g = h + alpha x - delta + C p + D q >= 0,   p >= 0,       p g = 0
    s = U - eps x - C q + D p,                  |q| <= f p,   slip only at |q| = f p and along q

D_ij = (beta/E*) sgn(x_i - x_j) times the cell couples both where Dundurs' beta is not 0 (Johnson,
Contact Mechanics, 1985, section 5.1; the sign of beta is that of the mirror image, which loads to
and fro between +-Q do not see): they take turns until q rests.

Each instant is one implicit increment from the one before. Active sets find the open, sticking and
slipping cells: nothing of superposition, memory curves or edges is used, so that the tests hold the
exact routines against `Grid`. Edges err by a cell.

The work of one grid errs by the place of the edges within their cells, 1e-4 to 5e-4 at 160 cells:
waves of a cell, which cancel in the mean over grids that are evenly moved. What is left, 1e-5 to
1e-4, has about the power 1.5 of cell and increment.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    InputError,
    LoadPath,
    LoadSegment,
)
from scenes.array_types import Array
from semi_analytic.bulk_and_tilt import PathLoads
from semi_analytic.history import require_admissible
from semi_analytic.tilted_profile import TiltedProfile

CELLS_ACROSS_CONTACT = 160
"""Cells across the largest contact; the difference from half as many gives the error."""
INCREMENTS_PER_CYCLE = 320
"""Increments a cycle; the difference from half as many gives the error."""

# Iterations of an active set that are allowed: it takes about ten.
_MOST_ACTIVE_SET_ITERATIONS = 200
# Sizes of contact, in cells, whose matrices are held: each takes the square of its size.
_MOST_CACHED_SIZES = 120
# Share of the largest f p by which round-off may leave |q| above f p: cells that stop slipping are
# there.
_ROUND_OFF_SHARE_OF_LIMIT = 1e-12
# Share of the slip of an increment that a cell makes before it is touched.
_SLIP_SHARE_BEFORE_TOUCH = 1 / 3
# Fewest increments of a segment of the cycle; each segment of the initial loading has a quarter of
# those of a cycle.
_FEWEST_INCREMENTS = 4
# Share of its work by which a cycle may differ from the one before and repeat it: far below what
# the grid leaves.
STEADY_WORK_SHARE = 1e-6
# Shares of a cell by which grids are moved, evenly, so that waves of a cell, a half, a third ...
# cancel in their mean; no two are mirror images under a symmetric contact. Number of groups of them
# whose means give the standard error of that mean.
_GRID_SHIFTS = (np.arange(16) + 0.25) / 16
_COUNT_OF_GRID_GROUPS = 4
# Errors by the change from coarse grids are taken times this: the true ones are 0.2 to 1.3 times
# what they would be without.
_SAFETY_OF_CHANGE = 2.0
# Order of convergence of q within a coarse cell of an edge of contact: between that of a root, 1/2,
# and of a logarithm, 0. With 1/2 the true error was up to 1.7 times the stated one, where next to
# nothing slips; with 1 up to 2.6.
_ORDER_OF_SHEAR_BESIDE_EDGE = 1 / 3
# Share of the friction work done in the outermost cells above which slip zones count as narrower
# than a cell: it is 1.00 in scenes of such zones, and 0.1 at most in others.
_SHARE_OF_MOST_WORK = 0.5
# Relative difference of two times below which they are one.
_ROUND_OFF_OF_TIME = 1e-12
# Cycles that the fine grids follow where coarse ones followed those before: the last two.
_CYCLES_RESUMED = 2
# Instants whose fields on all grids are found together.
_INSTANTS_AT_ONCE = 16
# Instants, out of those asked for, at which coarse and fine grids are compared.
_INSTANTS_COMPARED = 40
# Share of the longest slip path of a cycle up to which a cell counts as permanently stuck.
_STUCK_SLIP_PATH_SHARE = 1e-3
# By the direction of slip, 0, 1 or -1.
_STATES_BY_DIRECTION = np.array([STICK, SLIP_FORWARD, SLIP_REVERSE])


class GridFields(NamedTuple):
    """Tractions, slip and work at n instants and k cells.

    Attributes
    ----------
    x, cell_width
        (k,) middles of the cells; their width [length]
    loads
        (n, 4) P, Q, eps, alpha
    pressure, shear, slip
        (n, k)
    state
        (n, k) open, stick, forward or reverse slip
    approach, displacement
        (n,) delta, U (of x = 0, with the datum length 1 in the logarithm)
    moment, shear_moment
        (n,) int x p and m_q = int x q
    density
        (n, k) friction work per area of the increment that ends there, by the trapezoidal rule
    work, work_of_loads
        (n,) its integral over the cells, and Q dU - m_q d eps of the increment, also by the
        trapezoidal rule, 0 in the first increment of all
    """

    x: Array
    cell_width: float
    loads: Array
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    approach: Array
    displacement: Array
    moment: Array
    shear_moment: Array
    density: Array
    work: Array
    work_of_loads: Array

    def edges(self, instant_number: int, *, stick: bool = False) -> tuple[float, float]:
        """Left and right outer edge x of the cells in contact at instant number `instant_number`,
        or of those that stick if `stick` is true [length]; NaN where there are none.
        """
        contact_state = self.state[instant_number]
        return self._outer_edges(contact_state == STICK if stick else contact_state != OPEN)

    def permanent_stick_edges(
        self, first_instant_number: int, share: float = 1e-9
    ) -> tuple[float, float]:
        """Left and right outer edge x of the permanent stick zone [length]: of the cells that stay
        in contact from instant number `first_instant_number` on and whose slip then varies hardly
        at all. NaN without such cells.

        The slip of such a cell ranges over at most `share` of the largest range of slip of any
        cell, cells outside the contact included.
        """
        slip_range = np.ptp(self.slip[first_instant_number:], axis=0)
        stays_in_contact = np.all(self.state[first_instant_number:] != OPEN, axis=0)
        return self._outer_edges(stays_in_contact & (slip_range <= share * np.max(slip_range)))

    def cycle_work(self, n_increments: int) -> Array:
        """Friction work of each of the last whole cycles, (c,), if a cycle has `n_increments`
        increments [energy per thickness]; the first increment of all belongs to none.
        """
        works = self.work[1:]
        return works[len(works) % n_increments :].reshape(-1, n_increments).sum(axis=1)

    def _outer_edges(self, cells: NDArray[np.bool_]) -> tuple[float, float]:
        """Left edge of the first and right edge of the last of some cells [length]; NaN if there
        are none. `cells` (k,) is true for these cells, which lie in ascending x.
        """
        middles_of_cells = self.x[cells]
        if not len(middles_of_cells):
            return math.nan, math.nan
        return float(middles_of_cells[0] - self.cell_width / 2), float(
            middles_of_cells[-1] + self.cell_width / 2
        )


@dataclass(frozen=True, eq=False)
class CellStiffness:
    """Cells side by side that are in contact, with the inverse of their compliance matrix C.

    Attributes
    ----------
    root_of_stiffness
        (k, k) M with M^T M = C^-1
    traction_per_shift, total_per_shift
        (k,) tractions by the same unit displacement of all cells, the row sums of C^-1; their
        sum
    """

    root_of_stiffness: Array
    traction_per_shift: Array
    total_per_shift: float

    @cached_property
    def matrix(self) -> Array:
        """G, (k, k) [stress/length]: C^-1 without the traction that the same displacement of all
        cells takes.

        C is the compliance matrix of k cells side by side in contact. The tractions t =
        total traction_per_shift/total_per_shift + G b make the displacements C t = b + constant;
        their sum is `total`.
        """
        # root_of_stiffness (k, k): M with M^T M = C^-1; traction_per_shift (k,): tractions that
        # displace all cells by 1; total_per_shift: their sum.
        inverse_compliance = self.root_of_stiffness.T @ self.root_of_stiffness
        return np.asarray(
            inverse_compliance
            - np.outer(self.traction_per_shift, self.traction_per_shift / self.total_per_shift)
        )


class ContactCells(NamedTuple):
    """The cells of each grid that are in contact, side by side, (g,): the number of the first, and
    how many.
    """

    begin: NDArray[np.intp]
    n_cells: NDArray[np.intp]

    @property
    def end(self) -> NDArray[np.intp]:
        """Number behind the last cell."""
        return self.begin + self.n_cells

    def common_with(self, other_cells: ContactCells) -> ContactCells:
        """Cells that are in contact both here and in `other_cells`, on each of g grids: number of
        the first cell and how many; 0 or a negative number of them where there are none.
        """
        begin = np.maximum(self.begin, other_cells.begin)
        return ContactCells(begin, np.minimum(self.end, other_cells.end) - begin)


class NormalSolution(NamedTuple):
    """Solution of the normal problem on g grids of k cells: pressure p (g, k), the cells in
    contact, normal approach delta (g,).
    """

    pressure: Array
    contact: ContactCells
    approach: Array


class TangentialSolution(NamedTuple):
    """Solution of the tangential problem on g grids of k cells: shear q, slip s and direction of
    slip, +1, -1 or 0, (g, k) each; displacement U of the upper body (g,).
    """

    shear: Array
    slip: Array
    directions: NDArray[np.intp]
    displacement: Array


class Grid:
    """Contact of two half-planes in equal cells, and the state that it is in: nothing touches at
    first.

    Several grids of the same cells, moved by shares of a cell, are followed side by side: their
    matrices are the same.

    Attributes
    ----------
    x, cell_width
        (g, k) middles of the cells of g grids; their width [length]
    slip
        (g, k) slip s of the upper face over the lower in the present state [length]
    increments_without_early_slip
        number of increments whose newly touched cells were given no slip before the touch, each
        counted once for every grid
    """

    def __init__(
        self,
        height: Callable[[Array], Array],
        extent: ArrayLike,
        n_cells: int,
        friction: float,
        modulus: float = 1.0,
        dundurs_beta: float = 0.0,
    ) -> None:
        """Grids of `n_cells` equal cells each on two half-planes, which nothing touches yet.

        Several grids of equal cells, moved by parts of a cell, share their compliance matrices.

        Parameters
        ----------
        height
            initial gap h(x) between the unloaded faces [length]
        extent
            (2,) ends of one grid, or (g, 2) those of g grids of one length [length]
        n_cells
            number k of cells of a grid
        friction, modulus
            f and E* [stress]
        dundurs_beta
            Dundurs' beta of unlike materials, by which pressure shears the faces apart
        """
        self.friction = friction
        self.modulus = modulus
        self.dundurs_beta = dundurs_beta
        self.is_single_grid = np.ndim(extent) == 1
        self._place_cells(np.atleast_2d(np.asarray(extent, dtype=float)), n_cells)
        self._unloaded_gap = height(self.x)
        self._assemble_matrices()
        self._set_untouched_state()

    def _place_cells(self, ends_of_grids: Array, n_cells: int) -> None:
        """Divide each grid into `n_cells` equal cells: their number, width and middles x (g, k).

        `ends_of_grids` (g, 2) are the left and right ends of g grids of one length [length].
        """
        self.n_cells = n_cells
        self._length = float(ends_of_grids[0, 1] - ends_of_grids[0, 0])
        self.cell_width = self._length / n_cells
        self.x: Array = ends_of_grids[:, :1] + self.cell_width * (np.arange(n_cells) + 0.5)
        self._cell_numbers = np.arange(n_cells)

    def _assemble_matrices(self) -> None:
        """Matrices of the k cells of any of the grids, (k, k) each, from E* (`modulus`) and
        Dundurs' beta: compliance C, coupling D of unlike bodies, and the root M of the stiffness,
        M^T M = C^-1.

        Also empty caches for what is solved with them, and `datum_compliance`: the change of the
        displacement U per Q if its datum moves from distance 1 to the grid's length.
        """
        self.datum_compliance = 2 / (math.pi * self.modulus) * math.log(self._length)
        self._compliance = self.displacement_per_traction_at(self.x[0], 0)
        signs = np.sign(self._cell_numbers[:, None] - self._cell_numbers)
        self._coupling = self.dundurs_beta / self.modulus * self.cell_width * signs
        cholesky_factor = scipy.linalg.cholesky(self._compliance, lower=True)
        self._root_of_stiffness: Array = scipy.linalg.solve_triangular(
            cholesky_factor, np.eye(self.n_cells), lower=True
        )
        self._stiffness_by_size: dict[int, CellStiffness] = {}
        self._normal_by_load: dict[tuple[float, float], NormalSolution] = {}

    def _set_untouched_state(self) -> None:
        """State of g grids of k cells before anything touches: no cells in contact, no shear q,
        slip s and displacement U, no bulk strain.

        The directions of slip are those of the last increment, +1, -1 or 0. U is stored against a
        datum at the grid's length.
        """
        # Number of increments whose newly touched cells were given no slip before the touch.
        self.increments_without_early_slip = 0
        no_cells = np.zeros(len(self.x), dtype=int)
        self._contact = ContactCells(no_cells, no_cells)
        self._shear: Array = np.zeros(self.x.shape)
        self.slip: Array = np.zeros(self.x.shape)
        self._displacement: Array = np.zeros(len(self.x))
        self._strain = 0.0
        self._directions: NDArray[np.intp] = np.zeros(self.x.shape, dtype=int)
        self._last_fields: dict[str, Any] | None = None

    def displacement_per_traction_at(self, x: Array, grid_number: int) -> Array:
        """Surface displacement at points x (m,) by a unit traction on each of the k cells of grid
        `grid_number`, (m, k) [length/stress]. It is 0 at the distance of the grid's length L.

        It is the integral of -(2/(pi E*)) ln(|x - xi|/L) over the cell, the half-plane's Green's
        function.
        """
        distance_to_middle = (x[:, None] - self.x[grid_number])[..., None]
        # distances d of both ends of the cell over L, (m, k, 2)
        end_distances = (
            distance_to_middle + self.cell_width * np.array([-0.5, 0.5])
        ) / self._length
        # integral of ln|d| from 0 to both ends, 0 at d = 0
        with np.errstate(divide="ignore", invalid="ignore"):
            log_integrals_to_ends = np.where(
                end_distances == 0,
                0.0,
                end_distances * (np.log(np.abs(end_distances)) - 1),
            )
        log_integral = np.diff(log_integrals_to_ends, axis=-1)[..., 0]
        return np.asarray(-2 * self._length / (math.pi * self.modulus) * log_integral)

    def _stiffness_of_cells(self, n_cells: int) -> CellStiffness:
        """Inverse compliance (stiffness) of `n_cells` equal cells side by side in contact, as a
        `CellStiffness`; those of the last 120 numbers of cells are cached.

        Equal cells have one compliance matrix C wherever they lie. The root M of its inverse, M^T M
        = C^-1, is a corner of that of all cells of a grid.
        """
        if n_cells not in self._stiffness_by_size:
            # The part of M for all cells that belongs to the first `n_cells`.
            root_of_stiffness = self._root_of_stiffness[:n_cells, :n_cells]
            # Tractions that displace all cells by 1: row sums of C^-1.
            traction_per_shift = root_of_stiffness.T @ np.sum(root_of_stiffness, axis=1)
            self._stiffness_by_size[n_cells] = CellStiffness(
                root_of_stiffness, traction_per_shift, float(np.sum(traction_per_shift))
            )
            if len(self._stiffness_by_size) > _MOST_CACHED_SIZES:
                self._stiffness_by_size.pop(next(iter(self._stiffness_by_size)))
        return self._stiffness_by_size[n_cells]

    def _contact_mask(self, contact: ContactCells) -> NDArray[np.bool_]:
        """Which cells are in contact, (g, k)."""
        begin = contact.begin[:, None]
        end = contact.end[:, None]
        return (self._cell_numbers >= begin) & (self._cell_numbers < end)

    def _solve_normal(
        self, normal_load: float, tilt: float, gap_without_tilt: Array
    ) -> NormalSolution:
        """Pressure, cells in contact and normal approach of each grid under the load P and the tilt
        alpha: p > 0 where the gap is 0, and p = 0 where it is open.

        Solved by an active set: cells with tension are opened and cells that overlap are closed,
        until none changes. All cells from the first to the last that touches count as contact.

        Parameters
        ----------
        normal_load, tilt
            P [force per thickness]; alpha
        gap_without_tilt
            (g, k) gap between the unloaded faces without tilt, with what the shear adds, of g grids
            of k cells [length]

        Raises
        ------
        ArithmeticError
            Where the active set does not converge, or the contact meets the end of the grid.
        """
        unloaded_gap = gap_without_tilt + tilt * self.x
        # First guess: the cells in contact before; else five cells about the least gap.
        contact = self._contact
        if not contact.n_cells.all():
            contact = ContactCells(
                np.argmin(unloaded_gap, axis=1) - 2, np.full(len(unloaded_gap), 5)
            )

        for _ in range(_MOST_ACTIVE_SET_ITERATIONS):
            pressure, approach = self._pressure_on_cells(contact, normal_load, unloaded_gap)
            is_in_contact = self._contact_mask(contact)
            displacement_by_pressure = pressure @ self._compliance
            loaded_gap = unloaded_gap - approach[:, None] + displacement_by_pressure
            is_touching = np.where(is_in_contact, pressure > 0, loaded_gap < 0)
            if np.array_equal(is_touching, is_in_contact):
                break
            contact = _cells_from_first_to_last(is_touching)
        else:
            raise ArithmeticError("the contact area does not converge")
        # `begin` and `end`: number of the first cell in contact, and of the cell behind the last
        if np.any(contact.begin == 0) or np.any(contact.end == self.n_cells):
            raise ArithmeticError("the contact meets the end of the grid")
        return NormalSolution(pressure, contact, approach)

    def _pressure_on_cells(
        self, contact: ContactCells, normal_load: float, unloaded_gap: Array
    ) -> tuple[Array, Array]:
        """Pressure p (g, k) and normal approach delta (g,) that close the gap over given cells in
        contact of g grids under the load P. The pressure may come out as tension.

        Over the cells in contact C p = delta - unloaded gap, with their compliance matrix C; the
        sum of p is P over the cell width. p is 0 in all other cells.

        Parameters
        ----------
        contact
            cells in contact of each grid: number of the first (`begin`), and how many (`n_cells`)
        normal_load
            P [force per thickness]
        unloaded_gap
            (g, k) gap between the unloaded faces, tilt included [length]
        """
        pressure = np.zeros(unloaded_gap.shape)
        approach = np.zeros(len(unloaded_gap))
        # Grids with equally many cells in contact have one C. For m cells `root_of_stiffness` is
        # M with M^T M = C^-1, `traction_per_shift` (m,) the tractions that displace all m by
        # 1, `total_per_shift` their sum.
        for n_cells in np.unique(contact.n_cells).tolist():
            cell_stiffness = self._stiffness_of_cells(n_cells)
            grid_numbers = np.flatnonzero(contact.n_cells == n_cells)
            cells_in_contact = (
                grid_numbers[:, None],
                contact.begin[grid_numbers, None] + np.arange(n_cells),
            )
            approach[grid_numbers] = (
                normal_load / self.cell_width
                + unloaded_gap[cells_in_contact] @ cell_stiffness.traction_per_shift
            ) / cell_stiffness.total_per_shift
            pressure_by_gap = (
                unloaded_gap[cells_in_contact] @ cell_stiffness.root_of_stiffness.T
            ) @ cell_stiffness.root_of_stiffness
            pressure[cells_in_contact] = (
                approach[grid_numbers, None] * cell_stiffness.traction_per_shift - pressure_by_gap
            )
        return pressure, approach

    def _solve_tangential(
        self,
        tangential_load: float,
        displacement_without_shear: Array,
        friction_limit: Array,
        contact_before: ContactCells,
    ) -> TangentialSolution:
        """Shear q, slip s, direction of slip and displacement U of all grids after an increment to
        the tangential load Q, where the pressure is known.

        Newly touched cells start with the slip that they have made before the touch.

        Parameters
        ----------
        tangential_load
            Q at the end of the increment [force per thickness]
        displacement_without_shear
            (g, k) tangential displacement of the faces by bulk strain and pressure, of g grids of k
            cells [length]
        friction_limit
            (g, k) f p at the end of the increment [stress]
        contact_before
            cells in contact before the increment

        Raises
        ------
        ArithmeticError
            Where all cells in contact slip, or the active set does not converge.
        """
        slip_at_begin = self._slip_with_early_slip(
            tangential_load, displacement_without_shear, friction_limit, contact_before
        )
        all_grids = np.arange(len(self.x))
        return self._solve_increment_of(
            tangential_load,
            displacement_without_shear,
            friction_limit,
            self._contact,
            slip_at_begin,
            all_grids,
        )

    def _slip_with_early_slip(
        self,
        tangential_load: float,
        displacement_without_shear: Array,
        friction_limit: Array,
        contact_before: ContactCells,
    ) -> Array:
        """Slip at the begin of an increment, (g, k) for g grids of k cells [length]. Cells that are
        newly touched in the increment have the slip that they make before the touch.

        Ahead of an edge of contact that advances, slip grows as the root of the distance. A cell
        that is touched after a fraction t of the increment has then made 2/3 t of the slip that it
        would have made without contact: 1/3 in the mean over all t. That slip without contact is
        solved for with the earlier cells alone. Where they cannot carry Q, new cells start without
        slip.

        Parameters
        ----------
        tangential_load
            Q at the end of the increment [force per thickness]
        displacement_without_shear
            (g, k) tangential displacement of the faces by bulk strain and pressure [length]
        friction_limit
            (g, k) f p at the end of the increment [stress]
        contact_before
            cells in contact before the increment; those after it are stored in the grid. `begin`
            and `end` are numbers of cells: the first in contact, and the one behind the last
        """
        contact = self._contact
        earlier_contact = contact.common_with(contact_before)
        has_grown = (earlier_contact.begin > contact.begin) | (earlier_contact.end < contact.end)
        grown_grids = np.flatnonzero((earlier_contact.n_cells > 0) & has_grown)
        slip_at_begin = self.slip.copy()

        # A group of grids in which one fails is split into its single grids.
        groups_to_solve = [grown_grids] if len(grown_grids) else []
        while groups_to_solve:
            grid_numbers = groups_to_solve.pop()
            try:
                slip_without_contact = self._solve_increment_of(
                    tangential_load,
                    displacement_without_shear,
                    friction_limit,
                    earlier_contact,
                    slip_at_begin,
                    grid_numbers,
                ).slip
            except ArithmeticError:
                if len(grid_numbers) > 1:
                    groups_to_solve += np.split(grid_numbers, len(grid_numbers))
                else:
                    self.increments_without_early_slip += 1
                continue
            is_new_cell = (
                self._contact_mask(contact)[grid_numbers]
                & ~self._contact_mask(earlier_contact)[grid_numbers]
            )
            slip_at_begin[grid_numbers] += np.where(
                is_new_cell,
                _SLIP_SHARE_BEFORE_TOUCH * (slip_without_contact - slip_at_begin[grid_numbers]),
                0.0,
            )
        return slip_at_begin

    def _solve_increment_of(
        self,
        tangential_load: float,
        displacement_without_shear: Array,
        friction_limit: Array,
        contact: ContactCells,
        slip_at_begin: Array,
        grid_numbers: NDArray[np.intp],
    ) -> TangentialSolution:
        """Shear q, slip s, direction of slip and displacement U of some grids under a tangential
        load, where the cells in contact are known. Which of them slip is found by an active set.

        q = q_0 - G v, with q_0 of full stick and the slip v of the increment. G is the stiffness of
        the cells in contact. It is solved on blocks of cells, as many in each grid as the largest
        contact has.

        Parameters
        ----------
        tangential_load
            Q [force per thickness]
        displacement_without_shear
            (g, k) tangential displacement of the faces by all but q, of g grids of k cells [length]
        friction_limit
            (g, k) f p of the cells [stress]
        contact
            the cells in contact of each of the g grids
        slip_at_begin
            (g, k) slip before the increment [length]
        grid_numbers
            (n,) numbers of the grids that are solved: shapes of the returned fields are (n, k), of
            the displacement U (n,)

        Raises
        ------
        ArithmeticError
            Where all cells in contact slip, or the active set does not converge.
        """
        n_cells_of_grid = self.n_cells  # k
        block = _BlockOfCells.around(contact, grid_numbers, n_cells_of_grid)
        n_cells_of_block = block.n_cells  # m <= k
        # of the m cells of a block: G, and the tractions that displace all of them by 1
        cell_stiffness = self._stiffness_of_cells(n_cells_of_block)
        # slip of the increment if there were neither shear nor U
        free_slip = block.values_of(displacement_without_shear - slip_at_begin)

        directions_in_block, shear_in_block, increment_slip = _slipping_cells(
            cell_stiffness,
            self._shear_in_full_stick(tangential_load, free_slip, cell_stiffness),
            np.where(block.is_touching, block.values_of(friction_limit), 0.0),
            block.is_touching,
            _first_guess_of_directions(block, self._directions),
            tolerance=_ROUND_OFF_SHARE_OF_LIMIT * friction_limit.max(),
        )

        # U from equilibrium: the sum of q is Q over the cell width.
        displacement_of_body = (
            tangential_load / self.cell_width
            + (increment_slip - free_slip) @ cell_stiffness.traction_per_shift
        ) / cell_stiffness.total_per_shift
        # from the block to all k cells
        shear = block.on_all_cells(shear_in_block, n_cells_of_grid)
        directions = block.on_all_cells(directions_in_block, n_cells_of_grid)
        displacement_by_shear = shear @ self._compliance
        slip = (
            displacement_of_body[:, None]
            + displacement_without_shear[grid_numbers]
            - displacement_by_shear
        )
        return TangentialSolution(shear, slip, directions, displacement_of_body)

    def _shear_in_full_stick(
        self, tangential_load: float, free_slip: Array, cell_stiffness: CellStiffness
    ) -> Array:
        """Shear q_0 of m cells side by side on each of n grids if no cell slipped in an increment,
        (n, m) [stress].

        One part carries Q, and displaces all cells alike. The other part undoes the differences of
        `free_slip` between the cells, and has the sum 0.

        Parameters
        ----------
        tangential_load
            Q at the end of the increment [force per thickness]
        free_slip
            (n, m) slip of the increment if there were neither shear nor U [length]
        cell_stiffness
            of m cells: `traction_per_shift` (m,), the tractions that displace all of them by 1, and
            `total_per_shift`, their sum; `matrix` (m, m), by which equal displacements of all cells
            make no traction
        """
        return np.asarray(
            tangential_load
            / self.cell_width
            / cell_stiffness.total_per_shift
            * cell_stiffness.traction_per_shift
            + free_slip @ cell_stiffness.matrix
        )

    def _step_to_loads(
        self, normal_load: float, tangential_load: float, strain: float, tilt: float
    ) -> dict[str, Any]:
        """Bring all grids by one implicit increment to the loads P and Q, the bulk strain eps and
        the tilt alpha; the fields at its end, by their names in `GridFields`.

        Tractions, slip and state of contact are (g, k) for g grids of k cells; approach, U, moments
        and friction work (g,). Work is taken by the trapezoidal rule. The next increment starts
        from the shear, slip and cells in contact that are stored here. Where P is not positive
        nothing touches, and Q makes neither shear nor slip. Q still enters the field "displacement"
        by its datum, and the work of the loads.

        Parameters
        ----------
        normal_load, tangential_load
            P and Q at the end of the increment [force per thickness]
        strain, tilt
            eps and alpha there

        Raises
        ------
        ArithmeticError
            Where active sets do not converge, all cells slip, or the contact meets the end of the
            grid.
        """
        # (g, k) of the faces, if there were no shear
        displacement_by_strain: Array = -strain * self.x
        normal_solution, tangential_solution = self._solve_under_loads(
            normal_load, tangential_load, tilt, displacement_by_strain
        )
        loads = np.array([normal_load, tangential_load, strain, tilt])
        fields = self._fields_at_end(loads, normal_solution, tangential_solution)

        # Work of the loads in the increment, Q dU - m_q d eps, to compare the friction work with.
        # There are no fields before the first increment: its work of the loads is 0.
        fields_before = self._last_fields or fields
        fields["work_of_loads"] = _work_of_loads_between(fields_before, fields)
        self._shear = tangential_solution.shear
        self.slip = tangential_solution.slip
        self._displacement = tangential_solution.displacement
        self._strain = strain
        self._directions = tangential_solution.directions
        self._last_fields = fields
        return fields

    def _solve_under_loads(
        self, normal_load: float, tangential_load: float, tilt: float, displacement_by_strain: Array
    ) -> tuple[NormalSolution, TangentialSolution]:
        """Normal and tangential solution of all grids at the end of an increment. For like bodies
        the normal problem is solved first, then the tangential one; for unlike bodies both in turn,
        until the shear rests. Where P is not positive there is no contact.

        The new cells in contact are stored in the grid. Without coupling the normal solution
        depends on P and the tilt only: it is cached for the next cycle.

        Parameters
        ----------
        normal_load, tangential_load, tilt
            P and Q [force per thickness] and the tilt alpha at the end of the increment
        displacement_by_strain
            tangential displacement of the faces by bulk strain, (g, k) for g grids of k cells
            [length]

        Raises
        ------
        ArithmeticError
            Where the solution does not converge, all cells slip, or the contact meets the end of
            the grid.
        """
        if normal_load <= 0:
            return self._solution_without_contact(displacement_by_strain)
        if self.dundurs_beta:
            return self._solve_in_turn(normal_load, tangential_load, tilt, displacement_by_strain)
        if (normal_load, tilt) not in self._normal_by_load:
            self._normal_by_load[normal_load, tilt] = self._solve_normal(
                normal_load, tilt, self._unloaded_gap
            )
        normal_solution = self._normal_by_load[normal_load, tilt]
        contact_before = self._contact
        self._contact = normal_solution.contact
        tangential_solution = self._solve_tangential(
            tangential_load,
            displacement_by_strain,
            self.friction * normal_solution.pressure,
            contact_before,
        )
        return normal_solution, tangential_solution

    def _fields_at_end(
        self,
        loads: Array,
        normal_solution: NormalSolution,
        tangential_solution: TangentialSolution,
    ) -> dict[str, Any]:
        """Fields at the end of an increment by their names in `GridFields`, but for the work of the
        loads. The grids still have the shear and slip from before the increment.

        Parameters
        ----------
        loads
            (4,) P, Q, bulk strain and tilt at the end
        normal_solution
            pressure (g, k) of g grids of k cells, and normal approach (g,) against a datum at the
            distance of the grid's length
        tangential_solution
            shear, slip and directions of slip, +1, -1 or 0, (g, k) each, and displacement U (g,)
            against that datum

        Returns
        -------
        dict
            "approach" and "displacement" are against a datum at distance 1
        """
        normal_load, tangential_load, _, _ = loads.tolist()
        pressure = normal_solution.pressure
        shear = tangential_solution.shear
        # Friction work: mean shear times the slip of the increment.
        slip_of_increment = tangential_solution.slip - self.slip
        work_per_area = (self._shear + shear) * slip_of_increment / 2
        # stick, forward or reverse slip
        state_in_contact = _STATES_BY_DIRECTION[tangential_solution.directions]
        contact_state = np.where(self._contact_mask(self._contact), state_in_contact, OPEN)
        # datum_compliance: change of the displacement per load as the datum moves
        return {
            "loads": loads,
            "pressure": pressure,
            "shear": shear,
            "slip": tangential_solution.slip,
            "state": contact_state.astype(np.int8),
            "approach": normal_solution.approach - self.datum_compliance * normal_load,
            "displacement": (
                tangential_solution.displacement - self.datum_compliance * tangential_load
            ),
            "moment": self.cell_width * np.sum(self.x * pressure, axis=1),
            "shear_moment": self.cell_width * np.sum(self.x * shear, axis=1),
            "density": work_per_area,
            "work": self.cell_width * np.sum(work_per_area, axis=1),
        }

    def _solution_without_contact(
        self, displacement_by_strain: Array
    ) -> tuple[NormalSolution, TangentialSolution]:
        """Normal and tangential solution of all grids while the bodies are apart: no traction, no
        cells in contact, normal approach 0. The displacement U of the upper body stays.

        The faces move by the bulk strain alone: `displacement_by_strain` (g, k) is that movement
        on g grids of k cells [length]. The grids are left without cells in contact.
        """
        no_cells = np.zeros(len(self.x), dtype=int)
        self._contact = ContactCells(self._contact.begin, no_cells)
        no_traction = np.zeros(self.x.shape)
        no_approach = np.zeros(len(self.x))
        normal_solution = NormalSolution(no_traction, self._contact, no_approach)
        directions = np.zeros(self.x.shape, dtype=int)
        slip = self._displacement[:, None] + displacement_by_strain
        tangential_solution = TangentialSolution(no_traction, slip, directions, self._displacement)
        return normal_solution, tangential_solution

    def _solve_in_turn(
        self, normal_load: float, tangential_load: float, tilt: float, displacement_by_strain: Array
    ) -> tuple[NormalSolution, TangentialSolution]:
        """Normal and tangential solution of all grids after an increment between unlike bodies,
        solved in turn until the shear changes no more.

        The normal problem takes the gap that the shear adds, the tangential problem the
        displacement that the pressure adds (Dundurs' beta). The first turn takes the shear from
        before the increment. The cells in contact are stored in the grid in each turn, since the
        tangential problem reads them there.

        Parameters
        ----------
        normal_load, tangential_load, tilt
            P and Q [force per thickness] and the tilt alpha at the end of the increment
        displacement_by_strain
            tangential displacement of the faces by bulk strain, (g, k) for g grids of k cells
            [length]

        Raises
        ------
        ArithmeticError
            Where the shear still changes after 200 turns. Also where in one turn an active set
            does not converge, all cells slip, or the contact meets the end of the grid.
        """
        contact_before = self._contact
        shear_of_last_turn = self._shear
        for _ in range(_MOST_ACTIVE_SET_ITERATIONS):
            # _coupling (k, k): normal displacement of the cells by shear, and tangential one by
            # pressure
            gap_by_shear = shear_of_last_turn @ self._coupling.T
            normal_solution = self._solve_normal(
                normal_load, tilt, self._unloaded_gap + gap_by_shear
            )
            self._contact = normal_solution.contact
            friction_limit = self.friction * normal_solution.pressure
            displacement_by_pressure = normal_solution.pressure @ self._coupling.T
            tangential_solution = self._solve_tangential(
                tangential_load,
                displacement_by_strain + displacement_by_pressure,
                friction_limit,
                contact_before,
            )
            shear_change = float(np.max(np.abs(tangential_solution.shear - shear_of_last_turn)))
            shear_of_last_turn = tangential_solution.shear
            # 1e-12 of the largest f p
            largest_round_off = (
                _ROUND_OFF_SHARE_OF_LIMIT * self.friction * normal_solution.pressure.max()
            )
            if shear_change <= largest_round_off:
                return normal_solution, tangential_solution
        raise ArithmeticError("pressure and shear by turns do not converge")

    def slip_field(self) -> Callable[[Array], Array]:
        """Function that returns the slip s [length] at any points x (m,), in contact and outside:
        the mean over the grids in their present state. For like materials, which pressure does not
        shear.

            s = U - eps x - sum over cells of compliance times q

        U is the displacement of the upper body, eps the bulk strain, q the shear of the cells.
        """
        # The present state, which later increments replace: q (g, k), mean of U, and eps.
        shear = self._shear
        mean_displacement = float(np.mean(self._displacement))
        strain = self._strain

        def slip(x: Array) -> Array:
            """Slip at points x (m,), (m,) [length]."""
            displacements_by_shear = [
                self.displacement_per_traction_at(x, grid_number) @ shear_of_grid
                for grid_number, shear_of_grid in enumerate(shear)
            ]
            return np.asarray(
                mean_displacement - strain * x - np.mean(displacements_by_shear, axis=0)
            )

        return slip

    def resume(self, slip: Callable[[Array], Array], loads: Array) -> None:
        """Bring the grids to the loads P, Q, bulk strain eps and tilt alpha (4,), starting from a
        slip that is known from other grids.

        `slip` returns that slip at points x. Where |q| would exceed f p, cells slip further in the
        increment that is made here. It raises ArithmeticError where an active set does not
        converge, all cells slip, or the contact meets the end of the grid.
        """
        normal_load, tangential_load, strain, tilt = loads.tolist()
        self.slip = np.stack([slip(cell_middles) for cell_middles in self.x])
        # The contact of these loads counts as touched before, so that no cell slips before a touch.
        self._contact = self._solve_normal(normal_load, tilt, self._unloaded_gap).contact
        self._step_to_loads(normal_load, tangential_load, strain, tilt)

    def follow(self, loads: Array) -> GridFields:
        """Pressure, shear, slip, work and displacements of the grids at the end of each of n
        increments, one to each row of `loads` (n, 4): P, Q, bulk strain eps and tilt alpha.

        Tractions are (n, k) of a single grid and (n, g, k) of g grids of k cells. The grids start
        from their present state and are left in the last one.

        Raises
        ------
        ArithmeticError
            Where active sets do not converge, all cells slip, or the contact meets the end of
            the grid.
        """
        fields_of_increments = []
        for normal_load, tangential_load, strain, tilt in loads.tolist():
            try:
                fields_of_increments.append(
                    self._step_to_loads(normal_load, tangential_load, strain, tilt)
                )
            except ArithmeticError as fault:
                raise ArithmeticError(
                    f"{fault} at P = {normal_load:.6g}, Q = {tangential_load:.6g}"
                ) from fault
        # From one dictionary per increment to one array per field.
        fields = {}
        for name in fields_of_increments[0]:
            fields[name] = np.array([fields_at_end[name] for fields_at_end in fields_of_increments])
        if not self.is_single_grid:
            return GridFields(self.x, self.cell_width, **fields)
        # Of a single grid without the axis of the grids; loads have none.
        for name in fields.keys() - {"loads"}:
            fields[name] = fields[name][:, 0]
        return GridFields(self.x[0], self.cell_width, **fields)


def _cells_from_first_to_last(is_touching: NDArray[np.bool_]) -> ContactCells:
    """All cells from the first to the last that touches, on each of g grids.

    `is_touching` (g, k) marks the cells that touch; at least one on each grid.
    """
    n_cells = is_touching.shape[1]
    first_cell = np.argmax(is_touching, axis=1)
    number_after_last_cell = n_cells - np.argmax(is_touching[:, ::-1], axis=1)
    return ContactCells(first_cell, number_after_last_cell - first_cell)


class _BlockOfCells(NamedTuple):
    """Cells that a tangential problem is solved on: on each of n grids m cells side by side, the
    cells in contact among them.

    m is the number of cells of the largest contact, so that one stiffness serves all grids. Where a
    grid has fewer cells in contact, open cells beside them are in the block. They slip without
    friction.

    Attributes
    ----------
    grids
        (n,) numbers of the grids
    columns
        (n, m) numbers of the cells on each grid
    is_touching
        (n, m) whether the cell is in contact
    """

    grids: NDArray[np.intp]
    columns: NDArray[np.intp]
    is_touching: NDArray[np.bool_]

    @classmethod
    def around(
        cls, contact: ContactCells, grid_numbers: NDArray[np.intp], n_cells_of_grid: int
    ) -> _BlockOfCells:
        """The block of cells that holds the cells in contact of some grids: on each grid as many
        cells as the largest of these contacts has.

        Parameters
        ----------
        contact
            cells in contact of each grid: number of the first (`begin`), of the cell behind the
            last (`end`), and how many (`n_cells`)
        grid_numbers
            (n,) numbers of those grids
        n_cells_of_grid
            number of cells of a grid
        """
        n_cells = int(contact.n_cells[grid_numbers].max())
        first_column = np.minimum(contact.begin[grid_numbers], n_cells_of_grid - n_cells)
        columns = first_column[:, None] + np.arange(n_cells)
        is_touching = (columns >= contact.begin[grid_numbers, None]) & (
            columns < contact.end[grid_numbers, None]
        )
        return cls(grid_numbers, columns, is_touching)

    @property
    def n_cells(self) -> int:
        """Number m of cells of the block on each grid."""
        return self.columns.shape[1]

    def values_of(self, field_of_grids: NDArray[Any]) -> NDArray[Any]:
        """Values of a field (g, k) on all cells of all grids in the cells of the block, (n, m)."""
        return np.asarray(field_of_grids[self.grids[:, None], self.columns])

    def on_all_cells(self, values: NDArray[Any], n_cells_of_grid: int) -> NDArray[Any]:
        """Values (n, m) in the block spread to all `n_cells_of_grid` cells of its n grids; 0 in
        cells outside the block.
        """
        all_values = np.zeros((len(self.grids), n_cells_of_grid), dtype=values.dtype)
        all_values[np.arange(len(self.grids))[:, None], self.columns] = values
        return all_values


def _first_guess_of_directions(
    block: _BlockOfCells, directions_before: NDArray[np.intp]
) -> NDArray[np.intp]:
    """First guess of the directions of slip, +1, -1 or 0 (stick), in the m cells of a block on each
    of n grids, (n, m): cells slip as in the increment before.

    `directions_before` (g, k) are those on all cells of all grids. Where they would leave no cell
    that sticks on a grid, all its cells stick; open cells have 0.
    """
    directions = np.where(block.is_touching, block.values_of(directions_before), 0)
    directions[np.all((directions != 0) | ~block.is_touching, axis=1)] = 0
    return directions


def _slipping_cells(
    cell_stiffness: CellStiffness,
    shear_in_full_stick: Array,
    friction_limit: Array,
    is_touching: NDArray[np.bool_],
    directions: NDArray[np.intp],
    tolerance: float,
) -> tuple[NDArray[np.intp], Array, Array]:
    """Which cells slip in an increment, by an active set: direction of slip (0 in stick), shear,
    and slip in the increment of all cells, (g, k) each for g grids of k cells.

    A cell slips where |q| would be above f p; it sticks where its slip would go against its
    direction. The problem is solved again until no cell changes.

    Parameters
    ----------
    cell_stiffness
        `matrix` (k, k): stiffness of the k cells in contact, by which equal displacements of all
        cells make no traction
    shear_in_full_stick
        (g, k) q if no cell slipped [stress]
    friction_limit
        (g, k) f p [stress]
    is_touching
        (g, k) which cells are in contact; open ones slip without friction
    directions
        (g, k) first guess of the directions of slip, +1, -1 or 0
    tolerance
        excess of |q| over f p that is round-off [stress]

    Raises
    ------
    ArithmeticError
        Where all cells slip, or the active set does not converge.
    """
    for _ in range(_MOST_ACTIVE_SET_ITERATIONS):
        is_slipping = (directions != 0) | ~is_touching
        if np.any(np.all(is_slipping, axis=1)):
            raise ArithmeticError("all cells slip")
        shear_in_slip = directions * friction_limit
        # Slip of the increment that brings the shear of the slipping cells to the limit.
        increment_slip = _increment_slip_of(
            cell_stiffness, is_slipping, shear_in_full_stick - shear_in_slip
        )
        shear = shear_in_full_stick
        if np.any(is_slipping):
            shear_in_stick = shear_in_full_stick - increment_slip @ cell_stiffness.matrix
            shear = np.where(is_slipping, shear_in_slip, shear_in_stick)
        is_beyond_limit = ~is_slipping & (np.abs(shear) > friction_limit + tolerance)
        # A cell whose slip is against its direction sticks again.
        directions_along_slip = np.where(directions * increment_slip > 0, directions, 0)
        new_directions = np.where(is_beyond_limit, np.sign(shear), directions_along_slip)
        new_directions = new_directions.astype(int)
        if np.array_equal(new_directions, directions):
            return directions, shear, increment_slip
        directions = new_directions
    raise ArithmeticError("the slip zones do not converge")


def _increment_slip_of(
    cell_stiffness: CellStiffness, is_slipping: NDArray[np.bool_], shear_excess: Array
) -> Array:
    """Slip v of the slipping cells in an increment, (g, k) for g grids of k cells, 0 in all cells
    that stick [length]: the solution of G v = q_0 - q over the slipping cells.

    All grids are solved at once. They have different numbers of slipping cells: their systems are
    filled up to one size with rows v = 0.

    Parameters
    ----------
    cell_stiffness
        `matrix` (k, k): the stiffness G of the cells in contact
    is_slipping
        (g, k) which cells slip
    shear_excess
        (g, k) q_0 - q [stress]: q_0 is the shear if no cell slipped, q = +-f p
    """
    increment_slip = np.zeros(shear_excess.shape)
    most_slipping_cells = int(np.max(np.sum(is_slipping, axis=1)))
    if not most_slipping_cells:
        return increment_slip
    # Numbers of the cells in each system, (g, n): slipping cells, then others that fill it up.
    n_cells = is_slipping.shape[1]
    cell_numbers = np.argsort(~is_slipping, axis=1, kind="stable")[:, :most_slipping_cells]
    grid_numbers = np.arange(len(is_slipping))[:, None]
    is_slipping_row = is_slipping[grid_numbers, cell_numbers]
    # Rows and columns of G of these cells, (g, n, n).
    stiffness = cell_stiffness.matrix.ravel().take(
        cell_numbers[:, :, None] * n_cells + cell_numbers[:, None, :]
    )
    if not is_slipping_row.all():
        stiffness *= is_slipping_row[:, :, None] & is_slipping_row[:, None, :]
        diagonal = np.arange(most_slipping_cells)
        stiffness[:, diagonal, diagonal] += ~is_slipping_row
    right_hand_side = np.where(is_slipping_row, shear_excess[grid_numbers, cell_numbers], 0.0)
    slip_of_rows = np.linalg.solve(stiffness, right_hand_side[..., None])[..., 0]
    increment_slip[grid_numbers, cell_numbers] = slip_of_rows
    return increment_slip


def _work_of_loads_between(fields_before: dict[str, Any], fields_at_end: dict[str, Any]) -> Array:
    """Work of the loads in an increment, Q dU - m_q d eps, of g grids, (g,) [energy per unit
    thickness], by the trapezoidal rule.

    Both arguments hold fields by name, before the increment and at its end: "loads" (P, Q, bulk
    strain eps, tilt); "shear_moment", m_q = int x q dx, and "displacement", U, (g,) each.
    """
    _, tangential_load_before, strain_before, _ = fields_before["loads"]
    _, tangential_load, strain, _ = fields_at_end["loads"]
    mean_moment = (fields_at_end["shear_moment"] + fields_before["shear_moment"]) / 2
    displacement_change = fields_at_end["displacement"] - fields_before["displacement"]
    return np.asarray(
        (tangential_load + tangential_load_before) / 2 * displacement_change
        - mean_moment * (strain - strain_before)
    )


def follow_instants(
    height: Callable[[Array], Array],
    extent: tuple[float, float],
    cells: int,
    friction: float,
    normal: ArrayLike,
    shear: ArrayLike,
    strain: ArrayLike = 0.0,
    tilt: ArrayLike = 0.0,
    *,
    modulus: float = 1.0,
    dundurs_beta: float = 0.0,
) -> GridFields:
    """Fields at n instants of P, Q, bulk strain and tilt on one grid of two half-planes that have
    never touched before.

    Each instant is one implicit increment from the one before, the first from no load. Where P = 0
    at the first instant, the bulk strain of that instant is in place at first touch.

    Parameters
    ----------
    height
        h(x), the gap between the unloaded faces [length]
    extent, cells
        the two ends of the grid [length], and its number of equal cells
    friction
        f
    normal, shear, strain, tilt
        (n,) P, Q, bulk strain eps and tilt alpha; a single number holds at every instant
    modulus, dundurs_beta
        E* [stress]; Dundurs' second constant, by which pressure shears the faces apart

    Raises
    ------
    ArithmeticError
        Where the active sets do not converge, all cells slip, or the contact meets the end of
        the grid.

    Examples
    --------

    >>> fields = follow_instants(
    ...     lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0]
    ... )  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(fields.edges(0)[1] - (1.6 / math.pi) ** 0.5) < fields.cell_width
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    return Grid(height, extent, cells, friction, modulus, dundurs_beta).follow(loads)


# ------------------------------------------------------------------------------ a scene's load path
class _Increments(NamedTuple):
    """Increments of one cycle of a load path, and the wanted instants that lie in it.

    Attributes
    ----------
    loads_at_ends
        (n, 4) P, Q, bulk strain eps and tilt alpha at the ends of the increments
    increment_numbers, instant_numbers
        (i,) of each wanted instant that lies in this cycle: the number of the increment that ends
        there, and its number among all wanted instants
    """

    loads_at_ends: Array
    increment_numbers: NDArray[np.intp]
    instant_numbers: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _PathInIncrements:
    """A load path that is followed in about `increments_per_cycle` increments a cycle.

    `path_loads` has P, Q, bulk strain and tilt over time.
    """

    path_loads: PathLoads
    increments_per_cycle: int
    _loads_by_times: dict[bytes, Array] = field(default_factory=dict)

    @property
    def load_path(self) -> LoadPath:
        """Segments of the initial loading and of a cycle, between turning points of the loads. All
        cycles are like the first; `cycle` is empty for a path without cycles.
        """
        return self.path_loads.path

    def increments_of_cycle(self, cycle_number: int, wanted_times: Array) -> _Increments:
        """Increments of one cycle of the load path: the loads at their ends, and which of them end
        at wanted instants.

        Cycle -1 is the initial loading. Of the wanted instants (m,) those in this cycle are taken.
        An instant before first touch counts as first touch.
        """
        load_path = self.load_path
        is_initial_loading = cycle_number < 0
        segments = load_path.initial_loading if is_initial_loading else load_path.cycle
        cycle_start = segments[0].start
        cycle_end = segments[-1].end
        # wanted instants as times of the first cycle
        instants_in_first_cycle = _times_at_boundaries_made_exact(
            wanted_times - max(cycle_number, 0) * (load_path.period or 0.0), cycle_start, cycle_end
        )

        times_of_segments = [
            self._increment_times(
                segment, segment_number, is_initial_loading, instants_in_first_cycle
            )
            for segment_number, segment in enumerate(segments)
        ]
        loads_of_segments = [self._loads_at(times) for times in times_of_segments]

        # An instant at the start of a cycle belongs to the cycle before, which ends there.
        is_after_start = (instants_in_first_cycle > cycle_start) | is_initial_loading
        instant_numbers = np.flatnonzero((instants_in_first_cycle <= cycle_end) & is_after_start)
        # the increment whose end is nearest to each instant
        increment_ends = np.concatenate(times_of_segments)
        increment_numbers = [
            np.argmin(np.abs(increment_ends - max(wanted_instant, load_path.start)))
            for wanted_instant in instants_in_first_cycle[instant_numbers]
        ]
        return _Increments(
            np.concatenate(loads_of_segments),
            np.array(increment_numbers, dtype=int),
            instant_numbers,
        )

    def _loads_at(self, times: Array) -> Array:
        """P, Q, bulk strain and tilt at times (n,) of one segment of the load path, (n, 4).

        They are computed once and then cached by the times, since the segment returns in each
        cycle.
        """
        key_of_times = times.tobytes()
        if key_of_times not in self._loads_by_times:
            self._loads_by_times[key_of_times] = self.path_loads.loads_in_segment(times).T
        return self._loads_by_times[key_of_times]

    def _increment_times(
        self, segment: LoadSegment, segment_number: int, is_initial: bool, time_in_cycle: Array
    ) -> Array:
        """Times at the ends of the increments of one segment of the load path, (n,) ascending:
        evenly spaced ones, turning points of the loads, and wanted instants.

        An evenly spaced time next to a wanted instant is left out, as is a wanted instant next to a
        turning point. From first touch the contact grows in equal steps.

        Parameters
        ----------
        segment, segment_number
            the segment, and its number in the initial loading or in the cycle
        is_initial
            whether the segment belongs to the initial loading
        time_in_cycle
            (m,) wanted instants, as times of the first cycle
        """
        load_path = self.load_path
        begins_at_first_touch = segment is load_path.initial_loading[0]
        duration = segment.end - segment.start
        n_increments = self._number_of_increments(segment, segment_number, is_initial)
        # From first touch P grows as the square of the contact's size.
        exponent = 2 if begins_at_first_touch else 1
        shares_of_segment = np.linspace(0, 1, n_increments + 1)[1:] ** exponent
        even_times = segment.start + duration * shares_of_segment
        # turning points of the loads within the segment, and its end
        turning_times = self.path_loads.turning_times(segment)
        wanted_instants = time_in_cycle[
            (time_in_cycle > segment.start) & (time_in_cycle <= segment.end)
        ]
        if begins_at_first_touch and np.any(time_in_cycle <= load_path.start):
            wanted_instants = np.append(wanted_instants, load_path.start)

        time_to_instant = np.min(
            np.abs(even_times[:, None] - wanted_instants), axis=1, initial=math.inf
        )
        even_times = even_times[time_to_instant >= 0.5 * duration / n_increments]
        time_to_turning_point = np.min(
            np.abs(wanted_instants[:, None] - turning_times), axis=1, initial=math.inf
        )
        wanted_instants = wanted_instants[time_to_turning_point > 2e-9 * duration]
        return np.unique(np.concatenate([even_times, turning_times, wanted_instants]))

    def _number_of_increments(
        self, segment: LoadSegment, segment_number: int, is_initial: bool
    ) -> int:
        """Number of even increments of one segment of the load path: the share of a cycle's
        increments that its duration is of the cycle's, but at least 4.

        A segment of the initial loading before cycles has a quarter of a cycle's increments. A path
        without cycles counts as one cycle; its first segment has at least a quarter of the
        increments. `segment_number` is that in the initial loading (`is_initial`) or in the cycle.
        """
        load_path = self.load_path
        quarter_of_cycle = self.increments_per_cycle // 4
        if is_initial and load_path.cycle:
            return quarter_of_cycle
        is_first_of_path = is_initial and not segment_number
        fewest_increments = quarter_of_cycle if is_first_of_path else _FEWEST_INCREMENTS
        cycle_segments = load_path.cycle or load_path.initial_loading
        cycle_duration = cycle_segments[-1].end - cycle_segments[0].start
        share_of_cycle = (segment.end - segment.start) / cycle_duration
        return max(fewest_increments, math.ceil(self.increments_per_cycle * share_of_cycle))


def _times_at_boundaries_made_exact(time: Array, start: float, end: float) -> Array:
    """Instants `time` (k,), with those that differ from the start or the end of a cycle by
    round-off only (1e-12 of it) set to it.

    Else an instant at the end of a cycle would lie in none, or in the next.
    """
    for boundary in (start, end):
        is_at_boundary = np.isclose(time, boundary, rtol=_ROUND_OFF_OF_TIME, atol=0)
        time = np.where(is_at_boundary, boundary, time)
    return time


@dataclass(eq=False)
class _GridSolution:
    """Solution by g grids along cycles of a load path, at n instants and m points.

    Attributes
    ----------
    friction_ratio, slip
        (n, m) means over the grids of q/(f p) and of slip s [length]
    friction_ratio_by_grid, slip_by_grid
        (g, n', m) q/(f p) and s of each grid, at every so many instants
    stick_edges
        (n, 2) means over the grids [length]
    loads
        (4, n) P, Q, bulk strain eps and tilt alpha
    displacement, shear_moment
        (n,) displacement U and m_q = int x q dx, means over the grids
    most_stick_zones
        the largest number of stick zones of a grid at any instant
    slip_at_starts
        mean slip, as a function of x, where each cycle starts
    n_increments
        number of increments that were solved
    works_of_cycles
        (g, c) friction work of each of the c cycles on each grid [energy per thickness]
    work_of_last_cycle, load_work_of_last_cycle
        (g,) friction work of the last cycle; its closed integral of Q dU - m_q d eps
    work_per_area
        (g, k) friction work per area of the k cells in the last cycle
    edge_work_share
        share of the friction work of the last cycle that is done in the outermost cells in contact
        and in cells that open
    permanent_stick_edges
        (2,) mean edges of the cells that stick through the last cycle [length]
    """

    friction_ratio: Array
    slip: Array
    friction_ratio_by_grid: Array
    slip_by_grid: Array
    stick_edges: Array
    loads: Array
    displacement: Array
    shear_moment: Array
    most_stick_zones: int = 1
    slip_at_starts: list[Callable[[Array], Array]] = field(default_factory=list)
    n_increments: int = 0
    works_of_cycles: Array = field(default_factory=lambda: np.empty(0))
    work_of_last_cycle: Array = field(default_factory=lambda: np.empty(0))
    load_work_of_last_cycle: Array = field(default_factory=lambda: np.empty(0))
    work_per_area: Array = field(default_factory=lambda: np.empty(0))
    edge_work_share: float = 0.0
    permanent_stick_edges: Array = field(default_factory=lambda: np.full(2, np.nan))

    @classmethod
    def empty_storage(
        cls, n_grids: int, n_instants: int, n_points: int, stride: int
    ) -> _GridSolution:
        """Storage for the solution by `n_grids` grids at so many instants and points, before any
        cycle is followed: zeros, and NaN for edges of stick.

        q/(f p) and slip of each single grid are stored at every `stride`-th instant, their means
        over the grids at all instants.
        """
        shape_by_grid = (n_grids, -(-n_instants // stride), n_points)
        return cls(
            friction_ratio=np.zeros((n_instants, n_points)),
            slip=np.zeros((n_instants, n_points)),
            friction_ratio_by_grid=np.zeros(shape_by_grid),
            slip_by_grid=np.zeros(shape_by_grid),
            stick_edges=np.full((n_instants, 2), np.nan),
            loads=np.zeros((4, n_instants)),
            displacement=np.zeros(n_instants),
            shear_moment=np.zeros(n_instants),
        )

    def store_cycle(
        self,
        grids: Grid,
        cell_fields: GridFields,
        increments: _Increments,
        x: Array,
        compliance: Array,
        stride: int,
    ) -> None:
        """Store the solution of one cycle at the wanted instants that lie in it: loads,
        displacement U, moment of the shear, slip, q/(f p) and stick edges.

        Parameters
        ----------
        grids
            g grids of k cells
        cell_fields
            tractions and slip of the cells, (n, g, k), at the ends of the n increments of the
            cycle; U and moment of the shear there, (n, g)
        increments
            for each wanted instant in the cycle: `increment_numbers`, that of the increment which
            ends there, and `instant_numbers`, its own among all wanted instants
        x, compliance
            (m,) points; (g, m, k) displacements there by unit tractions on the cells
        stride
            values of each single grid are stored at every `stride`-th instant
        """
        increment_numbers = increments.increment_numbers
        instant_numbers = increments.instant_numbers
        self.n_increments += len(increments.loads_at_ends)
        self.loads[:, instant_numbers] = cell_fields.loads[increment_numbers].T
        self.displacement[instant_numbers] = np.mean(
            cell_fields.displacement[increment_numbers], axis=1
        )
        self.shear_moment[instant_numbers] = np.mean(
            cell_fields.shear_moment[increment_numbers], axis=1
        )
        # 16 instants at once: their fields on all grids take memory
        for first_index in range(0, len(instant_numbers), _INSTANTS_AT_ONCE):
            chunk = slice(first_index, first_index + _INSTANTS_AT_ONCE)
            instants_of_chunk = instant_numbers[chunk]
            point_fields = _point_fields_at(
                grids, cell_fields, increment_numbers[chunk], x, compliance
            )
            # means over the grids
            self.friction_ratio[instants_of_chunk] = np.mean(point_fields.friction_ratio, axis=1)
            self.slip[instants_of_chunk] = np.mean(point_fields.slip, axis=1)
            self.stick_edges[instants_of_chunk] = np.mean(point_fields.stick_edges, axis=1)
            self.most_stick_zones = max(
                self.most_stick_zones, int(np.max(point_fields.n_stick_zones))
            )
            # and each grid at every so many instants
            is_stored_by_grid = instants_of_chunk % stride == 0
            stored_rows = instants_of_chunk[is_stored_by_grid] // stride
            self.friction_ratio_by_grid[:, stored_rows] = np.swapaxes(
                point_fields.friction_ratio[is_stored_by_grid], 0, 1
            )
            self.slip_by_grid[:, stored_rows] = np.swapaxes(
                point_fields.slip[is_stored_by_grid], 0, 1
            )

    def store_last_cycle(
        self,
        cell_fields: GridFields,
        works_of_cycles: Sequence[Array],
        permanent_stick_edges: Array,
    ) -> None:
        """Store the friction work of all cycles. Of the last cycle store friction work, work of the
        loads, friction work per area, the share of the outermost cells, and edges of permanent
        stick.

        Parameters
        ----------
        cell_fields
            of the n increments of the last cycle, on g grids of k cells: work of the loads
            (`work_of_loads`, (n, g)), and friction work per area (`density`, (n, g, k))
        works_of_cycles
            friction work of each cycle, (g,) each [energy per thickness]
        permanent_stick_edges
            (2,) outer edges of the cells that stick all through the last cycle, NaN without such
            cells [length]
        """
        self.works_of_cycles = np.array(works_of_cycles).T
        self.work_of_last_cycle = works_of_cycles[-1]
        self.load_work_of_last_cycle = np.sum(cell_fields.work_of_loads, axis=0)
        self.work_per_area = np.sum(cell_fields.density, axis=0)
        self.edge_work_share = _work_share_of_edge_cells(cell_fields)
        self.permanent_stick_edges = permanent_stick_edges


def _work_share_of_edge_cells(cell_fields: GridFields) -> float:
    """Share of the friction work that is done in the outermost cells in contact and in cells that
    open in an increment, of the sum over n increments on g grids of k cells; 0 without work.

    `cell_fields` has state and friction work per area (`density`) of the cells, (n, g, k) each.
    """
    work_per_area = cell_fields.density
    whole_work = float(np.sum(work_per_area))
    if not whole_work > 0:
        return 0.0
    is_touching = cell_fields.state != OPEN
    is_between_others = np.zeros(is_touching.shape, dtype=bool)
    is_between_others[..., 1:-1] = is_touching[..., :-2] & is_touching[..., 2:]
    return float(np.sum(work_per_area, where=~is_between_others)) / whole_work


class _PointFields(NamedTuple):
    """Fields at m points at n instants, by g grids.

    Attributes
    ----------
    friction_ratio, slip
        (n, g, m) q/(f p) and slip s [length]
    stick_edges
        (n, g, 2) left and right outer edge of stick [length], NaN where nothing sticks
    n_stick_zones
        (n, g) number of stick zones
    """

    friction_ratio: Array
    slip: Array
    stick_edges: Array
    n_stick_zones: NDArray[np.intp]


def _point_fields_at(
    grids: Grid,
    cell_fields: GridFields,
    increment_numbers: NDArray[np.intp],
    x: Array,
    compliance: Array,
) -> _PointFields:
    """Fields of g grids at points x (m,) at the ends of n increments: q/(f p) and slip s, the outer
    edges of stick, and the number of stick zones.

    q/(f p) is linear between the middles of the cells in contact, and 0 without contact. Edges are
    NaN where nothing sticks.

    Parameters
    ----------
    grids
        the g grids; their `x` (g, k) are the middles of the k cells
    cell_fields
        pressure, shear and state (open, stick or slip) of the cells at the ends of all increments,
        (g, k) at each
    increment_numbers
        (n,) those of the increments
    x, compliance
        (m,) points; (g, m, k) displacements there by unit tractions on the cells
    """
    cell_states = cell_fields.state[increment_numbers]
    is_touching = cell_states != OPEN
    friction_ratio_of_cells = np.zeros(cell_states.shape)
    np.divide(
        cell_fields.shear[increment_numbers],
        grids.friction * cell_fields.pressure[increment_numbers],
        out=friction_ratio_of_cells,
        where=is_touching,
    )
    stick_edges, n_stick_zones = _stick_edges_and_zones(cell_states, grids.x, grids.cell_width)
    return _PointFields(
        friction_ratio=_between_cells(friction_ratio_of_cells, is_touching, grids.x, x),
        slip=_slip_at_points(grids, cell_fields, increment_numbers, x, compliance),
        stick_edges=stick_edges,
        n_stick_zones=n_stick_zones,
    )


def _between_cells(
    values: Array, is_touching: NDArray[np.bool_], cell_middles: Array, x: Array
) -> Array:
    """Values at points x (m,), linear between the middles of the cells in contact and constant
    beyond the outermost of them, (n, g, m) at n instants on g grids; 0 without contact.

    Parameters
    ----------
    values
        (n, g, k) of the cells
    is_touching
        (n, g, k) cells in contact, side by side on each grid
    cell_middles
        (g, k) middles x of the cells [length]
    """
    n_instants, n_grids, n_cells = values.shape
    # the first and the last cell in contact, (n, g, 1)
    first_cell = np.argmax(is_touching, axis=-1)[..., None]
    last_cell = n_cells - 1 - np.argmax(is_touching[..., ::-1], axis=-1)[..., None]
    # (g, m) number of the last cell with its middle at or before each point, -1 without such a cell
    cell_before_point = np.stack(
        [np.searchsorted(middles, x, side="right") - 1 for middles in cell_middles]
    )
    is_between_cells = (cell_before_point >= first_cell) & (cell_before_point < last_cell)
    # (n, g, m) number of the nearest such cell in contact: on its own grid, among the cells of all
    # grids, and among those of all instants
    number_on_grid = np.clip(cell_before_point, first_cell, last_cell)
    number_in_grids = number_on_grid + n_cells * np.arange(n_grids)[:, None]
    number_in_instants = number_in_grids + n_grids * n_cells * np.arange(n_instants)[:, None, None]
    # slope from each cell to the next; 0 beyond the outermost cells in contact
    slopes_of_cells = np.zeros(values.shape)
    slopes_of_cells[..., :-1] = np.diff(values) / np.diff(cell_middles)
    slope = np.where(is_between_cells, slopes_of_cells.ravel().take(number_in_instants), 0.0)
    distance_from_cell = x - cell_middles.ravel().take(number_in_grids)
    values_at_points = slope * distance_from_cell + values.ravel().take(number_in_instants)
    values_at_points[~is_touching.any(axis=-1)] = 0.0
    return np.asarray(values_at_points)


def _slip_at_points(
    grids: Grid,
    cell_fields: GridFields,
    increment_numbers: NDArray[np.intp],
    x: Array,
    compliance: Array,
) -> Array:
    """Slip s = U - eps x - (displacement by the shear of all cells) at points x (m,), by each of g
    grids at the ends of n increments, (n, g, m) [length].

    Parameters
    ----------
    grids
        the g grids of k cells
    cell_fields
        at the end of each increment: P, Q, bulk strain eps and tilt (`loads`, (4,)), displacement U
        (g,) with its datum at distance 1, and shear (g, k)
    increment_numbers
        (n,) those of the increments
    x, compliance
        (m,) points; (g, m, k) displacements there by unit tractions on the cells, with their datum
        at the distance of the grid's length
    """
    _, tangential_load, strain, _ = cell_fields.loads[increment_numbers].T
    # `datum_compliance` Q: change of U as its datum moves to the distance of the grid's length
    datum_shift = grids.datum_compliance * tangential_load
    displacement = cell_fields.displacement[increment_numbers] + datum_shift[:, None]
    shear = cell_fields.shear[increment_numbers]
    displacement_by_shear = np.matmul(compliance, shear[..., None])[..., 0]
    displacement_by_strain = strain[:, None] * x
    return np.asarray(
        displacement[..., None] - displacement_by_strain[:, None] - displacement_by_shear
    )


def _stick_edges_and_zones(
    cell_states: NDArray[np.int8], cell_middles: Array, cell_width: float
) -> tuple[Array, NDArray[np.intp]]:
    """Left and right outer edge of stick [length], (n, g, 2) at n instants on g grids, and the
    number of stick zones, (n, g).

    Where the outermost cell in contact sticks, stick reaches the edge of contact, wherever that
    lies in the cell: the edge of stick is -inf on the left, +inf on the right. Both edges are NaN
    where nothing sticks.

    Parameters
    ----------
    cell_states
        (n, g, k) open, stick or slip of the k cells
    cell_middles, cell_width
        (g, k) middles x of the cells, and their width [length]
    """
    is_sticking = cell_states == STICK
    is_touching = cell_states != OPEN
    last_cell_of_grid = cell_states.shape[-1] - 1
    grid_numbers = np.arange(len(cell_middles))
    first_sticking_cell = np.argmax(is_sticking, axis=-1)
    last_sticking_cell = last_cell_of_grid - np.argmax(is_sticking[..., ::-1], axis=-1)
    first_touching_cell = np.argmax(is_touching, axis=-1)
    last_touching_cell = last_cell_of_grid - np.argmax(is_touching[..., ::-1], axis=-1)
    left_stick_edge = cell_middles[grid_numbers, first_sticking_cell] - cell_width / 2
    right_stick_edge = cell_middles[grid_numbers, last_sticking_cell] + cell_width / 2
    left_stick_edge[first_sticking_cell == first_touching_cell] = -math.inf
    right_stick_edge[last_sticking_cell == last_touching_cell] = math.inf
    stick_edges = np.stack([left_stick_edge, right_stick_edge], axis=-1)
    stick_edges[~is_sticking.any(axis=-1)] = math.nan
    # a stick zone begins with each cell that sticks behind one that does not
    begins_zone = is_sticking[..., 1:] & ~is_sticking[..., :-1]
    n_stick_zones = np.sum(begins_zone, axis=-1) + is_sticking[..., 0]
    return stick_edges, np.asarray(n_stick_zones)


def _follow_cycles(
    grids: Grid,
    path_in_increments: _PathInIncrements,
    x: Array,
    time: Array,
    cycle_numbers: range,
    least_cycles: int,
    stride: int = 1,
) -> _GridSolution:
    """Follow the cycles of a load path on g grids, until the friction work of a cycle repeats that
    of the one before: shear, slip and stick edges at points and instants, and the friction work.

    Parameters
    ----------
    grids
        the g grids of k cells, which start from their present state
    path_in_increments
        the load path, divided into increments
    x, time
        (m,) points and (n,) instants of the solution
    cycle_numbers
        cycles to follow at most, -1 for the initial loading
    least_cycles
        number of cycles to follow in any case
    stride
        values of each single grid are stored at every `stride`-th instant, means over the grids at
        all instants

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    n_grids = len(grids.x)
    solution = _GridSolution.empty_storage(n_grids, len(time), len(x), stride)
    # (g,) friction work of each cycle; of the whole path where it has no cycles
    works_of_cycles: list[Array] = []
    # (g, m, k) displacements at the points by unit tractions on the cells
    compliance = np.zeros(0)
    if len(time):
        compliance = np.array(
            [grids.displacement_per_traction_at(x, grid_number) for grid_number in range(n_grids)]
        )
    for cycle_number in cycle_numbers:
        if cycle_number >= 0:
            # slip as a function of x, mean over the grids, at the start of each cycle: finer grids
            # may resume from it
            solution.slip_at_starts.append(grids.slip_field())
        # loads at the ends of the increments, and which of them end at the instants `time`
        increments = path_in_increments.increments_of_cycle(cycle_number, time)
        slip_before = grids.slip
        cell_fields = _fields_of_cycle(grids, increments.loads_at_ends, cycle_number)
        solution.store_cycle(grids, cell_fields, increments, x, compliance, stride)
        if cycle_number >= 0 or not path_in_increments.load_path.cycle:
            works_of_cycles.append(np.sum(cell_fields.work, axis=0))
        if len(works_of_cycles) >= max(least_cycles, 2) and _last_cycle_repeats(works_of_cycles):
            break
    permanent_stick_edges = _permanent_edges(grids, cell_fields, slip_before)
    solution.store_last_cycle(cell_fields, works_of_cycles, permanent_stick_edges)
    return solution


def _fields_of_cycle(grids: Grid, loads: Array, cycle_number: int) -> GridFields:
    """Tractions, slip and work of the cells of g grids at the end of each of the n increments of a
    cycle. The grids are left at its end.

    `loads` (n, 4) are P, Q, bulk strain and tilt at the ends of the increments. `cycle_number` is
    -1 for the initial loading. Where an increment does not converge, InputError names the loads and
    the cycle.
    """
    try:
        return grids.follow(loads)
    except ArithmeticError as fault:
        raise InputError(
            f"load: half-plane theory takes grids for such bulk stress or tilt, and {fault} of"
            f" cycle {cycle_number + 1}; finite elements may take the scene"
        ) from fault


def _last_cycle_repeats(works_of_cycles: Sequence[Array]) -> bool:
    """Whether the friction work of the last cycle, in the mean over g grids, differs from that of
    the cycle before by at most 1e-6 of itself: the steady state.

    `works_of_cycles` has the work of each cycle, (g,) each [energy per thickness], two cycles or
    more.
    """
    work_change = abs(np.mean(works_of_cycles[-1] - works_of_cycles[-2]))
    # STEADY_WORK_SHARE: 1e-6.
    return bool(work_change <= STEADY_WORK_SHARE * np.mean(works_of_cycles[-1]))


def _permanent_edges(grids: Grid, cell_fields: GridFields, slip_before: Array) -> Array:
    """Left and right outer edge (2,) of the permanent stick zone: of the cells that stick all
    through a cycle, mean over g grids [length]; NaN if no grid has such a cell.

    The slip path of a cell is the sum of its |slip increments| over the cycle, while it is in
    contact. A cell sticks if it stays in contact, and its slip path is at most 0.1 % of the longest
    of such cells on all grids. Where that longest one is round-off, 0.1 % of the longest slip path
    of the cells that open takes its place.

    A grid without a cell that sticks counts as a zone of width 0 in the middle of that of the
    others.

    Parameters
    ----------
    grids
        the g grids of k cells: their middles `x` (g, k) and `cell_width` [length]
    cell_fields
        slip and state of the cells, (n, g, k), at the ends of the n increments of the cycle
    slip_before
        (g, k) slip at the begin of the cycle [length]
    """
    slip_increments = np.abs(np.diff(cell_fields.slip, axis=0, prepend=slip_before[None]))
    is_open = cell_fields.state == OPEN
    stays_in_contact = ~np.any(is_open, axis=0)
    slip_path = np.sum(np.where(is_open, 0.0, slip_increments), axis=0)
    # longest of the cells that stay in contact, or 0.1 % of the longest of all
    reference_slip_path = max(
        float(np.max(slip_path, where=stays_in_contact, initial=0.0)),
        _STUCK_SLIP_PATH_SHARE * float(np.max(slip_path)),
    )
    is_stuck = stays_in_contact & (slip_path <= _STUCK_SLIP_PATH_SHARE * reference_slip_path)
    has_stuck_cells = np.any(is_stuck, axis=1)
    if not has_stuck_cells.any():
        return np.full(2, np.nan)
    left_edges = np.min(grids.x, axis=1, where=is_stuck, initial=np.inf) - grids.cell_width / 2
    right_edges = np.max(grids.x, axis=1, where=is_stuck, initial=-np.inf) + grids.cell_width / 2
    zone_edges = np.stack([left_edges, right_edges], axis=1)
    middle = np.mean(zone_edges[has_stuck_cells])
    return np.asarray(np.mean(np.where(has_stuck_cells[:, None], zone_edges, middle), axis=0))


def contact_edges_along(loads: PathLoads, contact: TiltedProfile) -> Array:
    """Left and right edge of contact at the n ends of some 320 increments a cycle, and of those of
    the initial loading, (n, 2) [length]; instants without contact are left out.

    Parameters
    ----------
    loads
        P, Q, bulk strain and tilt along the path
    contact
        normal contact of the profile, whose centre and half-width follow from P and tilt
    """
    path_in_increments = _PathInIncrements(loads, INCREMENTS_PER_CYCLE)
    # -1 is the initial loading, 0 the first cycle
    cycle_numbers = (-1, 0) if path_in_increments.load_path.cycle else (-1,)
    no_instants = np.zeros(0)
    loads_at_ends = np.concatenate(
        [
            path_in_increments.increments_of_cycle(cycle_number, no_instants).loads_at_ends
            for cycle_number in cycle_numbers
        ]
    )
    loads_in_contact = loads_at_ends[loads_at_ends[:, 0] > 0]
    normal_load, _, _, tilt = loads_in_contact.T
    centre, half_width = contact.centre_and_half_width_under(normal_load, tilt)
    return np.stack([centre - half_width, centre + half_width], axis=-1)


@dataclass(frozen=True, eq=False)
class PathOnGrids:
    """Loads, edges, fields and friction work along a path that was followed on grids: n instants, k
    points; edges (n, 2), fields (n, k).

    Attributes
    ----------
    loads
        (4, n) P, Q, eps and alpha
    moment, shear_moment
        (n,) int x p and m_q = int x q
    displacement
        (n,) U of x = 0, with the datum length 1 in the logarithm
    contact_edges, stick_edges
        (n, 2)
    pressure, shear, slip, state
        (n, k), as in a ContactSolution
    works
        friction work of each cycle that was followed; of the whole path where it has no cycle
    loop_work
        closed integral of Q dU - m_q d eps of the last [energy per thickness]
    unsteady_work
        estimate of the difference of the last cycle's work from the steady one
    steady_from, steady_tolerance
        index of the first cycle that repeats the one before to this share of W, None if none
        does
    density
        (k,) friction work at the points, of the last cycle
    permanent_stick_edges
        (2,) of the last cycle; NaN where none
    permanent_stick_uncertainty
        of each of these edges [length]; NaN where none
    counts
        numbers of grids, cells, increments and zones that stick, by name
    errors
        relative, of dissipation, dissipation_density, shear and slip, as in a Record
    """

    time: Array
    loads: Array
    moment: Array
    shear_moment: Array
    displacement: Array
    contact_edges: Array
    stick_edges: Array
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    works: Array
    loop_work: float
    unsteady_work: float
    steady_from: int | None
    steady_tolerance: float
    density: Array
    permanent_stick_edges: Array
    permanent_stick_uncertainty: float
    counts: dict[str, int]
    errors: dict[str, float]


def cycles_needed(path: LoadPath, time: Array | None) -> int:
    """Number of cycles that must be followed to reach the last of the instants `time`, at least 1;
    1 for a path without cycles, and if no instants are given.
    """
    if path.period is None or time is None or not len(time):
        return 1
    return max(1, math.ceil((float(np.max(time)) - path.cycle_start) / path.period - 1e-9))


def first_repeated_cycle(works: Sequence[float] | Array, share: float) -> int | None:
    """Index of the first cycle whose friction work differs from that of the one before by at most
    `share` of itself; None where there is no such cycle. `works` (c,) are the works of the cycles.
    """
    for cycle in range(1, len(works)):
        if abs(works[cycle] - works[cycle - 1]) <= share * works[cycle]:
            return cycle
    return None


def remainder_of(works: Sequence[float]) -> float:
    """Estimated difference between the friction work W of the last cycle and that of the steady
    cycle, from the works `works` (c,) of the cycles so far; infinite after a single cycle.

    It is the rest of a geometric series if the last ratio of successive changes is below a half and
    0.8 to 1.05 times the ratio before. Else the changes may fall with the cycle number k as slowly
    as k^-4, however fast the first ones were. Then it is k/3 times the last change, or the rest of
    a geometric series, of a ratio of at most 0.9, if that is more. After two cycles it is the
    change between them.

    >>> round(remainder_of([1.5, 1.05, 1.005, 1.0005]), 12)  # W falls to 1
    0.0005
    >>> works = [1 + k**-3.0 for k in range(1, 41)]  # 1.6e-5 is left
    >>> 1e-5 < remainder_of(works) < 3e-5
    True
    """
    # |change of W| from each cycle to the next
    changes = np.abs(np.diff(works))
    if not len(changes):
        return math.inf
    last_change = float(changes[-1])
    if len(changes) < 2 or last_change == 0:
        return last_change
    # of each change to the one before it
    change_ratios = changes[1:] / np.maximum(changes[:-1], np.finfo(float).tiny)
    last_ratio = float(change_ratios[-1])
    ratio_before = float(change_ratios[-2]) if len(change_ratios) > 1 else 1.0
    is_geometric = last_ratio < 0.5 and 0.8 * ratio_before < last_ratio < 1.05 * ratio_before
    if is_geometric:
        return last_change * last_ratio / (1 - last_ratio)
    bounded_ratio = min(last_ratio, 0.9)
    return last_change * max(len(works) / 3, bounded_ratio / (1 - bounded_ratio))


@dataclass(frozen=True)
class GridRequest:
    """What is wanted of grids, and how fine they are.

    Attributes
    ----------
    most_cycles
        largest number of cycles
    steady
        whether the last cycle alone is wanted, without q and s; if there are more than two cycles,
        all works but the last are then of coarse grids
    pointwise
        whether q, s and the state are wanted at points; NaN and open otherwise
    cells, increments
        number of cells across the largest contact; number of increments in a cycle
    """

    most_cycles: int = 12
    steady: bool = False
    pointwise: bool = True
    cells: int = CELLS_ACROSS_CONTACT
    increments: int = INCREMENTS_PER_CYCLE


def follow_on_grid(
    loads: PathLoads,
    contact: TiltedProfile,
    height: Callable[[Array], Array],
    friction: float,
    x: Array,
    time: Array | None = None,
    request: GridRequest = GridRequest(),
) -> PathOnGrids:
    """Shear, slip and friction work of a load path with bulk stress and tilt, by cells from first
    touch, cycle by cycle until the friction work is steady to 1e-6; with their errors.

    Pressure and contact edges are exact. All else is the mean over 16 grids, each moved by another
    fraction of a cell, since the place of an edge in its cell makes an error that cancels in that
    mean. A coarse grid goes first and finds the number of cycles.

    Where only the last cycle is wanted, 16 coarse grids go first. If there are more than two
    cycles, the fine grids then follow the last two alone, from the mean slip of the coarse ones.
    The shear that is locked in is then not that of the whole path. This changes W and the stick
    zones by less than the stated error.

    Each error is twice a sum: twice the standard error of that mean, plus what is left of the
    change from coarse grids, of half as many cells and increments. That change is taken to fall
    with the cell width by the power 1.5 in W, 1 in q and W(x), 0.9 in s, as root mean squares over
    the points. Within a coarse cell of an edge of contact it is 1/3 in q.

    Parameters
    ----------
    loads
        P, Q, bulk strain eps and tilt alpha along the path; `loads.path` has its segments
    contact
        normal contact of the profile under load and tilt, tabulated up to a largest P that the path
        does not exceed; `intervals.compliance` is A = 2/E*
    height
        h(x), the gap between the unloaded faces [length]
    friction
        f
    x
        (k,) points
    time
        (n,) instants in any order; every second increment if None
    request
        which values are wanted at how many cycles, and how fine the grids are

    Raises
    ------
    InadmissibleLoadError
        For gross sliding and separation.
    InputError
        Where an increment does not converge, as at the limit of gross sliding.
    """
    require_admissible([*loads.path.initial_loading, *loads.path.cycle], friction)
    setup = _setup_along_path(loads, contact, height, friction)
    points_of_fields = x if request.pointwise else np.zeros(0)
    solutions = _run_coarse_and_fine(setup, loads, points_of_fields, time, request)
    normal_contact = _exact_normal_contact(contact, solutions.fine_solution.loads, x)
    fields = _fields_at_points(solutions, friction, normal_contact, request, x)
    friction_work = _work_on_grids(solutions, x)
    return _record_of_path(solutions, normal_contact, fields, friction_work, request.cells)


def _record_of_path(
    solutions: _CoarseAndFineSolutions,
    normal_contact: _NormalContact,
    fields: _FieldsAtPoints,
    friction_work: _WorkOnGrids,
    n_cells: int,
) -> PathOnGrids:
    """The record of a load path that was followed on grids, from its parts.

    Loads, moment of the shear, displacement U and stick edges are those of the fine grids, means
    over 16. Stick edges beyond the exact edges of contact are moved to these.

    Parameters
    ----------
    solutions
        solutions by coarse and fine grids
    normal_contact, fields
        exact normal contact; shear, slip and state, at n instants and k points
    friction_work
        W of each cycle and W(x) of the last, with their errors
    n_cells
        number of cells across the largest contact
    """
    fine_solution = solutions.fine_solution
    contact_edges = normal_contact.edges
    return PathOnGrids(
        time=solutions.plan.time,
        loads=fine_solution.loads,
        moment=normal_contact.moment,
        shear_moment=fine_solution.shear_moment,
        displacement=fine_solution.displacement,
        contact_edges=contact_edges,
        stick_edges=np.clip(fine_solution.stick_edges, contact_edges[:, :1], contact_edges[:, 1:]),
        pressure=normal_contact.pressure,
        shear=fields.shear,
        slip=fields.slip,
        state=fields.state,
        works=friction_work.works_of_cycles,
        loop_work=friction_work.loop_work,
        unsteady_work=friction_work.unsteady_work,
        steady_from=friction_work.steady_from,
        steady_tolerance=STEADY_WORK_SHARE,
        density=friction_work.work_per_area,
        permanent_stick_edges=fine_solution.permanent_stick_edges,
        permanent_stick_uncertainty=_uncertainty_of_permanent_stick(solutions),
        counts=_counts_of(solutions, n_cells),
        errors=friction_work.errors | fields.relative_errors,
    )


def _setup_along_path(
    loads: PathLoads, contact: TiltedProfile, height: Callable[[Array], Array], friction: float
) -> _GridSetup:
    """What all grids along a load path have in common: the gap h(x) between the unloaded faces
    (`height`), f, E*, and the leftmost and rightmost edge of contact along the path.

    `loads` has P, Q, bulk strain and tilt along the path. `contact` is the normal contact of the
    profile, whose edges of contact follow from P and tilt; its `intervals.compliance` is A = 2/E*.
    """
    contact_edges = contact_edges_along(loads, contact)
    return _GridSetup(
        height=height,
        outermost_edges=(float(np.min(contact_edges)), float(np.max(contact_edges))),
        friction=friction,
        modulus=2 / contact.intervals.compliance,
    )


class _NormalContact(NamedTuple):
    """Exact normal contact at n instants and k points.

    Attributes
    ----------
    edges
        (n, 2) left and right edge of contact x [length]
    moment
        (n,) int x p dx [force]
    pressure
        (n, k) p at the points [stress], 0 outside the contact
    is_in_contact
        (n, k) whether the point lies between the edges
    """

    edges: Array
    moment: Array
    pressure: Array
    is_in_contact: NDArray[np.bool_]


def _exact_normal_contact(contact: TiltedProfile, loads: Array, x: Array) -> _NormalContact:
    """Edges of contact, moment and pressure at points x (k,) under the loads of n instants, without
    any grid.

    `contact` is the profile: normal contact under P and tilt. `loads` (4, n) are P, Q, bulk strain
    and tilt at the instants; P and tilt alone count.
    """
    normal_load, _, _, tilt = loads
    centre, half_width = contact.centre_and_half_width_under(normal_load, tilt)
    edges = np.stack([centre - half_width, centre + half_width], axis=-1)
    return _NormalContact(
        edges=edges,
        moment=contact.moment(centre, half_width, normal_load, tilt),
        pressure=contact.pressure_over(x, centre, half_width),
        is_in_contact=(x >= edges[:, :1]) & (x <= edges[:, 1:]),
    )


def _fields_at_points(
    solutions: _CoarseAndFineSolutions,
    friction_coefficient: float,
    normal_contact: _NormalContact,
    request: GridRequest,
    x: Array,
) -> _FieldsAtPoints:
    """Shear q, slip s and state at n instants and k points, the means over the fine grids, with the
    relative errors of q and s.

    Shear and slip are NaN, and all points open, where no fields are wanted. Errors are estimated
    from the change between coarse and fine grids. There are none where the last cycle alone is
    wanted, since the coarse grids then have no fields at instants.

    Parameters
    ----------
    solutions
        solutions by coarse and fine grids
    friction_coefficient
        f
    normal_contact
        exact edges of contact (n, 2), pressure (n, k), and which points are in contact (n, k)
    request
        `pointwise`: whether shear, slip and state are wanted
    x
        (k,) points [length]
    """
    if not request.pointwise:
        return _FieldsAtPoints.nowhere_known(normal_contact.pressure.shape)
    friction_limit = friction_coefficient * normal_contact.pressure
    fields = _FieldsAtPoints.of_means(
        solutions.fine_solution, friction_limit, normal_contact.is_in_contact
    )
    if solutions.plan.is_last_cycle_alone:
        return fields
    # (n, k) distance of the points from the nearer edge of contact
    distance_from_edge = np.min(np.abs(x[:, None] - normal_contact.edges[:, None, :]), axis=2)
    is_beside_edge = distance_from_edge < solutions.coarse_grids.cell_width
    return fields._replace(
        relative_errors=_errors_of_fields(solutions, friction_limit, is_beside_edge)
    )


class _WorkOnGrids(NamedTuple):
    """Friction work of the cycles on grids.

    Attributes
    ----------
    works_of_cycles
        (c,) friction work of each cycle, the last by the fine grids [energy per thickness]
    loop_work
        closed integral of Q dU - m_q d eps of the last cycle
    unsteady_work
        estimated difference of the last cycle's work from the steady one; infinite after one cycle
    steady_from
        index of the first cycle that repeats the one before to 1e-6, None where there is none
    work_per_area
        (k,) W(x) of the last cycle at the points [energy per area]
    errors
        relative errors of W and W(x), by the names "dissipation" and "dissipation_density"
    """

    works_of_cycles: Array
    loop_work: float
    unsteady_work: float
    steady_from: int | None
    work_per_area: Array
    errors: dict[str, float]


def _work_on_grids(solutions: _CoarseAndFineSolutions, x: Array) -> _WorkOnGrids:
    """Friction work of each cycle, and W(x) of the last one at points x (k,), as means over the
    grids; their errors by the change from coarse grids to fine ones, and how far the last cycle is
    from the steady one.
    """
    # Whether the work is steady is judged by cycles that the same grids followed.
    works_by_same_grids = solutions.works_by_same_grids()
    # (g, k) W(x) by each of the fine grids
    work_per_area = _work_per_area_at(solutions.fine_grids, solutions.fine_solution, x)
    return _WorkOnGrids(
        works_of_cycles=solutions.works_with_last_by_fine_grids(),
        loop_work=float(np.mean(solutions.fine_solution.load_work_of_last_cycle)),
        unsteady_work=remainder_of(works_by_same_grids.tolist()),
        steady_from=first_repeated_cycle(works_by_same_grids, STEADY_WORK_SHARE),
        work_per_area=np.mean(work_per_area, axis=0),
        errors=_errors_of_work(solutions, work_per_area, x),
    )


@dataclass(frozen=True, eq=False)
class _GridSetup:
    """What all grids of a scene have in common.

    Attributes
    ----------
    height
        h(x), the gap between the unloaded faces
    outermost_edges
        the leftmost and the rightmost edge of contact along the load path [length]
    friction, modulus
        f; E* [stress]
    """

    height: Callable[[Array], Array]
    outermost_edges: tuple[float, float]
    friction: float
    modulus: float

    def moved_grids(self, n_cells: int, shifts: Array) -> Grid:
        """Grids with `n_cells` equal cells between the outermost edges of contact, and five more
        beyond them, two on the left and three on the right. Grid j is moved to the left by the
        fraction `shifts[j]` of a cell, between 0 and 1; (g,) for g grids.
        """
        left_edge, right_edge = self.outermost_edges
        cell_width = (right_edge - left_edge) / n_cells
        extents = np.stack(
            [left_edge - (2 + shifts) * cell_width, right_edge + (3 - shifts) * cell_width], axis=1
        )
        return Grid(self.height, extents, n_cells + 5, self.friction, self.modulus)


class _Plan(NamedTuple):
    """Cycles that the fine grids follow, and instants of their solution.

    Attributes
    ----------
    time
        (n,) instants of the solution
    stride
        values of each single grid, and those of coarse grids, are stored at every `stride`-th
        instant: about 40 of them
    cycle_numbers
        cycles to follow, -1 for the initial loading
    is_last_cycle_alone
        whether the last cycle only is wanted
    is_resumed
        whether the fine grids start from the slip of the coarse ones and follow the last cycles
        only
    """

    time: Array
    stride: int
    cycle_numbers: range
    is_last_cycle_alone: bool
    is_resumed: bool


@dataclass(frozen=True, eq=False)
class _CoarseAndFineSolutions:
    """Solutions by coarse and fine grids along one load path. Coarse grids have half as many cells
    and increments.

    Attributes
    ----------
    first_solution
        by the coarse grids that went first and found the number of cycles
    fine_grids, fine_solution
        the fine grids in their state at the end, and their solution
    coarse_grids, coarse_solution
        the coarse grids that the fine ones are compared with, and their solution; those that went
        first where the last cycle alone is wanted
    coarse_solution_in_all_increments
        by coarse grids in as many increments as the fine ones take, where slip zones are narrower
        than a cell; else None
    plan
        cycles that the fine grids followed, and instants of their solution
    """

    first_solution: _GridSolution
    fine_grids: Grid
    fine_solution: _GridSolution
    coarse_grids: Grid
    coarse_solution: _GridSolution
    coarse_solution_in_all_increments: _GridSolution | None
    plan: _Plan

    def works_by_same_grids(self) -> Array:
        """Friction work of each cycle from the first one on, the mean over the grids, (c,) [energy
        per thickness], with all cycles by the same grids.

        These are the fine grids; but the coarse ones where the fine grids followed the last cycles
        only (`plan.is_resumed`).
        """
        solution_of_all_cycles = self.first_solution if self.plan.is_resumed else self.fine_solution
        return np.asarray(np.mean(solution_of_all_cycles.works_of_cycles, axis=0))

    def works_with_last_by_fine_grids(self) -> Array:
        """Friction work of each cycle from the first one on, the mean over the grids, (c,) [energy
        per thickness], with the last cycle by the fine grids in any case.

        Earlier cycles are by coarse grids where the fine grids followed the last cycles only
        (`plan.is_resumed`).
        """
        works_by_fine_grids = np.mean(self.fine_solution.works_of_cycles, axis=0)
        if not self.plan.is_resumed:
            return np.asarray(works_by_fine_grids)
        return np.append(self.works_by_same_grids()[:-1], works_by_fine_grids[-1])


def _run_coarse_and_fine(
    setup: _GridSetup, loads: PathLoads, x: Array, time: Array | None, request: GridRequest
) -> _CoarseAndFineSolutions:
    """Solutions by 16 fine and by coarse grids along one load path. Coarse grids have half as many
    cells and increments; the difference gives the error.

    A coarse grid goes first and finds how many cycles there are until the work is steady. The fine
    grids follow as many, then 16 coarse ones for comparison. Where the last cycle alone is wanted,
    all 16 coarse grids go first, and are the comparison. If there are more than two cycles, the
    fine grids then start from their mean slip, where the last but one cycle begins.

    Where edge cells do most of the friction work, 16 coarse grids also follow the increments of the
    fine ones. So the effects of cell width and of increments are known apart.

    Parameters
    ----------
    setup
        profile, outermost edges of contact, f and E* that all grids have in common
    loads
        P, Q, bulk strain and tilt along the path
    x
        (m,) points at which q and s are wanted
    time
        (n,) instants of the solution; every second increment if None
    request
        how many cycles, cells and increments, and whether the last cycle alone is wanted

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    coarse_path = _PathInIncrements(loads, request.increments // 2)
    has_cycles = loads.path.period is not None
    is_last_cycle_alone = request.steady and time is None and has_cycles

    # 16 shifts of a grid by fractions of a cell, or the first of them alone
    shifts_of_first_grids = _GRID_SHIFTS if is_last_cycle_alone else _GRID_SHIFTS[:1]
    first_grids = setup.moved_grids(request.cells // 2, shifts_of_first_grids)
    first_solution = _follow_first_grids(first_grids, coarse_path, time, request)
    plan = _plan_of_fine_grids(loads.path, first_solution, time, request, is_last_cycle_alone)
    fine_grids = setup.moved_grids(request.cells, _GRID_SHIFTS)
    fine_solution = _follow_fine_grids(fine_grids, loads, x, plan, first_solution, request)

    coarse_grids = first_grids
    coarse_solution = first_solution
    if not is_last_cycle_alone:
        coarse_grids = setup.moved_grids(request.cells // 2, _GRID_SHIFTS)
        coarse_solution = _follow_cycles(
            coarse_grids,
            coarse_path,
            x,
            plan.time[:: plan.stride],
            plan.cycle_numbers,
            len(plan.cycle_numbers),
        )
    coarse_solution_in_all_increments = None
    if coarse_solution.edge_work_share > _SHARE_OF_MOST_WORK:
        n_cycles = first_solution.works_of_cycles.shape[1] if loads.path.cycle else 0
        coarse_solution_in_all_increments = _follow_cycles(
            setup.moved_grids(request.cells // 2, _GRID_SHIFTS),
            _PathInIncrements(loads, request.increments),
            x=np.zeros(0),
            time=np.zeros(0),
            cycle_numbers=range(-1, n_cycles),
            least_cycles=n_cycles + 1,
        )
    return _CoarseAndFineSolutions(
        first_solution=first_solution,
        fine_grids=fine_grids,
        fine_solution=fine_solution,
        coarse_grids=coarse_grids,
        coarse_solution=coarse_solution,
        coarse_solution_in_all_increments=coarse_solution_in_all_increments,
        plan=plan,
    )


def _follow_first_grids(
    coarse_grids: Grid,
    path_in_increments: _PathInIncrements,
    time: Array | None,
    request: GridRequest,
) -> _GridSolution:
    """Friction work of each cycle of a load path on coarse grids, until it is steady: how many
    cycles finer grids must follow. Shear and slip are not stored.

    Parameters
    ----------
    coarse_grids
        the grids, which nothing touches yet: one, or 16 that are moved by fractions of a cell
    path_in_increments
        the load path, divided into increments
    time
        (n,) instants that the cycles must reach; None if none are wanted
    request
        `most_cycles`: the largest number of cycles, unless `time` needs more

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    load_path = path_in_increments.load_path
    least_cycles = cycles_needed(load_path, time)
    # A path without cycles consists of the initial loading alone, which is cycle -1.
    most_cycles = max(request.most_cycles, least_cycles) if load_path.cycle else 0
    no_points = np.zeros(0)
    no_instants = np.zeros(0)
    return _follow_cycles(
        coarse_grids,
        path_in_increments,
        no_points,
        no_instants,
        range(-1, most_cycles),
        least_cycles,
    )


def _plan_of_fine_grids(
    load_path: LoadPath,
    first_solution: _GridSolution,
    time: Array | None,
    request: GridRequest,
    is_last_cycle_alone: bool,
) -> _Plan:
    """Which cycles of a load path the fine grids follow, and the instants of their solution.

    They follow all cycles that coarse grids took until the friction work was steady. Where the last
    cycle alone is wanted (`is_last_cycle_alone`) and there are more than two, they follow the last
    two.

    Parameters
    ----------
    load_path
        `cycle` has the segments of a cycle, none for a path without cycles
    first_solution
        by the coarse grids: `works_of_cycles` (g, c), friction work of each of c cycles on g grids
    time
        (n,) instants of the solution; about every second increment if None
    request
        `increments`, the number of increments a cycle
    """
    n_cycles = first_solution.works_of_cycles.shape[1]
    is_resumed = is_last_cycle_alone and n_cycles > _CYCLES_RESUMED
    # cycle -1 is the initial loading
    cycle_numbers = range(-1, n_cycles if load_path.cycle else 0)
    if is_resumed:
        cycle_numbers = range(n_cycles - _CYCLES_RESUMED, n_cycles)
    if time is None:
        time = _default_times(load_path, n_cycles, request.increments, is_last_cycle_alone)
    time = np.asarray(time, dtype=float)
    # Values of each single grid are compared with coarse ones at about 40 instants.
    stride = max(len(time) // _INSTANTS_COMPARED, 1)
    return _Plan(time, stride, cycle_numbers, is_last_cycle_alone, is_resumed)


def _follow_fine_grids(
    fine_grids: Grid,
    loads: PathLoads,
    x: Array,
    plan: _Plan,
    first_solution: _GridSolution,
    request: GridRequest,
) -> _GridSolution:
    """Solution by fine grids along the cycles of a plan: from first touch, or from the mean slip of
    the coarse grids where the first of these cycles begins (`plan.is_resumed`).

    Parameters
    ----------
    fine_grids
        16 grids, which nothing touches yet
    loads
        P, Q, bulk strain and tilt along the path; `path.cycle_start` is the time at which the first
        cycle begins
    x
        (m,) points at which q and s are wanted
    plan
        cycles to follow, instants of the solution; values of each single grid are stored at every
        `stride`-th of them
    first_solution
        by the coarse grids: `slip_at_starts`, the slip as a function of x where each cycle begins
    request
        `increments`, the number of increments a cycle

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    if plan.is_resumed:
        # All cycles begin with the same loads.
        loads_at_cycle_start = loads.loads_in_segment(np.array([loads.path.cycle_start]))[:, 0]
        slip_at_start = first_solution.slip_at_starts[plan.cycle_numbers[0]]
        fine_grids.resume(slip_at_start, loads_at_cycle_start)
    return _follow_cycles(
        fine_grids,
        _PathInIncrements(loads, request.increments),
        x,
        plan.time,
        plan.cycle_numbers,
        len(plan.cycle_numbers),
        plan.stride,
    )


class _FieldsAtPoints(NamedTuple):
    """Shear, slip and state of contact at n instants and k points.

    Attributes
    ----------
    shear, slip
        (n, k) q [stress]; s [length]
    state
        (n, k) open, stick, forward or reverse slip
    relative_errors
        of q and s, by the names "shear" and "slip"; empty where they are not estimated
    """

    shear: Array
    slip: Array
    state: NDArray[np.int8]
    relative_errors: dict[str, float]

    @classmethod
    def nowhere_known(cls, shape: tuple[int, ...]) -> _FieldsAtPoints:
        """Fields of which nothing is known, of shape (n, k): shear and slip are NaN, every point is
        open.
        """
        not_a_number = np.full(shape, np.nan)
        return cls(not_a_number, not_a_number, np.full(shape, OPEN, dtype=np.int8), {})

    @classmethod
    def of_means(
        cls, solution: _GridSolution, friction_limit: Array, is_in_contact: NDArray[np.bool_]
    ) -> _FieldsAtPoints:
        """Shear q = f p (q/(f p)), slip and state of contact at n instants and k points, without
        errors. q/(f p) and slip are the means over grids.

        Outside the contact the shear is 0. A point slips where |q| reaches f p.

        Parameters
        ----------
        solution
            `friction_ratio`, the mean of q/(f p), and `slip`, that of s [length], (n, k) each
        friction_limit
            (n, k) exact f p [stress]
        is_in_contact
            (n, k) which points are in contact
        """
        friction_ratio = np.where(is_in_contact, solution.friction_ratio, 0.0)
        state = _states_of(friction_ratio, is_in_contact)
        return cls(friction_limit * friction_ratio, solution.slip, state.astype(np.int8), {})


def _errors_of_work(
    solutions: _CoarseAndFineSolutions, work_per_area: Array, x: Array
) -> dict[str, float]:
    """Relative errors of the friction work W of the last cycle and of W(x), the work per area at
    points x (k,), from the change between coarse and fine grids.

    Where slip zones are narrower than a cell, the increments make as large an error of W as the
    cells do, of the first order, often of the other sign: the change by both at once may be next to
    nothing. There each makes a change of its own, and the squares of what they leave are added.

    `work_per_area` (g, k) is W(x) by each of g fine grids.
    """
    coarse_work_per_area = _work_per_area_at(solutions.coarse_grids, solutions.coarse_solution, x)
    work = solutions.fine_solution.work_of_last_cycle
    coarse_work = solutions.coarse_solution.work_of_last_cycle
    # convergence_order: power of the cell width, or of the increment, with which the error falls
    error_left_in_work = _error_left(work, coarse_work, convergence_order=1.5)
    if solutions.coarse_solution_in_all_increments is not None:
        work_by_cells = solutions.coarse_solution_in_all_increments.work_of_last_cycle
        error_left_in_work = np.hypot(
            _error_left(work, work_by_cells, convergence_order=1.5),
            _error_left(work_by_cells, coarse_work, convergence_order=1),
        )
    return {
        "dissipation": _relative_error(work, error_left_in_work),
        "dissipation_density": _relative_error(
            work_per_area, _error_left(work_per_area, coarse_work_per_area, convergence_order=1)
        ),
    }


def _errors_of_fields(
    solutions: _CoarseAndFineSolutions,
    friction_limit: Array,
    is_beside_edge: NDArray[np.bool_],
) -> dict[str, float]:
    """Relative errors of the shear q and the slip s at k points, by name, from the change between
    coarse and fine grids.

    Where a slip zone is narrower than a cell, q is the inverse root of the distance from the edge
    of contact up to that zone. Its mean square beside the edge grows with the logarithm of the
    cell width over that of the zone: the change from coarse grids is too small a part of it, and
    counts as if the order of convergence were 1/3.

    Parameters
    ----------
    solutions
        by coarse and fine grids; q/(f p) and slip by each single grid, (g, n', k), are at every
        `plan.stride`-th of n instants
    friction_limit
        (n, k) f p at all n instants [stress]
    is_beside_edge
        (n, k) whether a point lies within a coarse cell of an edge of contact
    """
    limit_at_instants = friction_limit[:: solutions.plan.stride]
    is_beside_edge_at_instants = is_beside_edge[:: solutions.plan.stride]
    fine_solution = solutions.fine_solution
    coarse_solution = solutions.coarse_solution
    shear = limit_at_instants * fine_solution.friction_ratio_by_grid
    coarse_shear = limit_at_instants * coarse_solution.friction_ratio_by_grid
    slip = fine_solution.slip_by_grid
    # convergence_order: power of the cell width with which the error falls
    order_of_shear = np.where(is_beside_edge_at_instants, _ORDER_OF_SHEAR_BESIDE_EDGE, 1.0)
    return {
        "shear": _relative_error(shear, _error_left(shear, coarse_shear, order_of_shear)),
        "slip": _relative_error(
            slip, _error_left(slip, coarse_solution.slip_by_grid, convergence_order=0.9)
        ),
    }


def _uncertainty_of_permanent_stick(solutions: _CoarseAndFineSolutions) -> float:
    """Uncertainty of an edge of the permanent stick zone [length]: twice its change from coarse
    grids to fine ones, plus the length by which one grid is moved against the next, 1/16 of a cell.

    Of the two edges the larger change counts. An edge errs by a fraction of a cell, so that half as
    many cells double its error; the mean over the grids does not resolve less than 1/16 of a cell.
    Where coarse grids have no such zone, the width of that of the fine ones stands for twice the
    change. NaN where fine grids have none.
    """
    fine_edges = solutions.fine_solution.permanent_stick_edges
    coarse_edges = solutions.coarse_solution.permanent_stick_edges
    zone_width = float(fine_edges[1] - fine_edges[0])
    shift_between_grids = solutions.fine_grids.cell_width / len(_GRID_SHIFTS)
    if np.isnan(coarse_edges).any():
        return zone_width + shift_between_grids
    change = float(np.max(np.abs(fine_edges - coarse_edges)))
    return _SAFETY_OF_CHANGE * change + shift_between_grids


def _counts_of(solutions: _CoarseAndFineSolutions, n_cells: int) -> dict[str, int]:
    """Numbers that describe the effort of a solution on grids, by name: grids, cells across the
    largest contact (`n_cells`), increments, and zones that stick ("pieces").

    Where there are any, also cycles that coarse grids alone followed, and increments of the fine
    grids whose newly touched cells were given no slip before the touch, counted for each grid.
    """
    first_solution = solutions.first_solution
    fine_solution = solutions.fine_solution
    counts = {
        "grids": 2 * len(_GRID_SHIFTS),  # 16 fine and 16 coarse ones
        "cells": n_cells,
        "increments": first_solution.n_increments + fine_solution.n_increments,
        "pieces": fine_solution.most_stick_zones,
    }
    # Where the last cycle alone is wanted, the coarse grids are those that went first.
    if not solutions.plan.is_last_cycle_alone:
        counts["increments"] += solutions.coarse_solution.n_increments
    if solutions.coarse_solution_in_all_increments is not None:
        counts["grids"] += len(_GRID_SHIFTS)
        counts["increments"] += solutions.coarse_solution_in_all_increments.n_increments
    if solutions.plan.is_resumed:
        # index of the first cycle that the fine grids followed
        counts["cycles on coarse grids alone"] = solutions.plan.cycle_numbers[0]
    if solutions.fine_grids.increments_without_early_slip:
        counts["increments without early slip"] = solutions.fine_grids.increments_without_early_slip
    return counts


def _states_of(friction_ratio: Array, is_in_contact: NDArray[np.bool_]) -> NDArray[np.int8]:
    """State of points by `friction_ratio` = q/(f p), arrays of one shape: open out of contact,
    stick below 1, else forward or reverse slip by its sign.
    """
    state_in_slip = np.where(friction_ratio > 0, SLIP_FORWARD, SLIP_REVERSE)
    contact_state = np.where(np.abs(friction_ratio) < 1 - 1e-12, STICK, state_in_slip)
    return np.where(is_in_contact, contact_state, OPEN)


def cycle_works(
    loads: PathLoads,
    outermost_edges: tuple[float, float],
    height: Callable[[Array], Array],
    friction: float,
    modulus: float,
    request: GridRequest,
) -> Array:
    """Friction work of each of the c cycles of a load path, (16, c), on 16 grids [energy per unit
    thickness], until one cycle repeats the one before. The grids are moved by fractions of a cell.

    Of a path without cycles it is the work of all of it, (16, 1).

    Parameters
    ----------
    loads
        P, Q, bulk strain and tilt along the path
    outermost_edges
        the leftmost and the rightmost edge of contact along the path [length]
    height
        h(x), the gap between the unloaded faces [length]
    friction, modulus
        f, E* [stress]
    request
        how fine the grids are, and the largest number of cycles

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    grids = _GridSetup(height, outermost_edges, friction, modulus).moved_grids(
        request.cells, _GRID_SHIFTS
    )
    path_in_increments = _PathInIncrements(loads, request.increments)
    n_cycles = request.most_cycles if path_in_increments.load_path.cycle else 0
    # Number -1 is the initial loading before the first cycle, 0.
    cycle_numbers = range(-1, n_cycles)
    no_points = np.zeros(0)
    no_instants = np.zeros(0)
    return _follow_cycles(
        grids, path_in_increments, no_points, no_instants, cycle_numbers, least_cycles=1
    ).works_of_cycles


class RatioOnGrids(NamedTuple):
    """q/(f p) at n instants and k points (n, k), the mean over 16 grids, 0 where a grid has no
    contact, and the width of their cells [length].
    """

    friction_ratio: Array
    cell_width: float


def friction_ratio_on_grids(
    loads: PathLoads,
    contact: TiltedProfile,
    height: Callable[[Array], Array],
    friction: float,
    x: Array,
    time: Array,
    request: GridRequest,
) -> RatioOnGrids:
    """q/(f p) at n instants and k points, the mean over 16 grids that are moved by fractions of a
    cell, without an error, along a known number of cycles.

    Parameters
    ----------
    loads
        P, Q, bulk strain and tilt along the path
    contact
        normal contact of the profile under load and tilt
    height
        h(x), the gap between the unloaded faces [length]
    friction
        f
    x, time
        (k,) points; (n,) instants
    request
        how fine the grids are; `most_cycles`, how many cycles are followed, steady or not

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    setup = _setup_along_path(loads, contact, height, friction)
    grids = setup.moved_grids(request.cells, _GRID_SHIFTS)
    path_in_increments = _PathInIncrements(loads, request.increments)
    n_cycles = request.most_cycles if path_in_increments.load_path.cycle else 0
    # Number -1 is the initial loading before the first cycle, 0.
    cycle_numbers = range(-1, n_cycles)
    solution = _follow_cycles(
        grids, path_in_increments, x, time, cycle_numbers, least_cycles=len(cycle_numbers)
    )
    return RatioOnGrids(solution.friction_ratio, grids.cell_width)


def _default_times(
    path: LoadPath, n_cycles: int, increments_per_cycle: int, last_cycle_alone: bool
) -> Array:
    """Times at which a solution on grids is given where the caller asks for none, (n,) ascending.

    They are as many as every second increment of all cycles, equally spaced, and fewer of the
    initial loading; of the last cycle only with `last_cycle_alone`. `n_cycles` is the number of
    cycles, `increments_per_cycle` that of the increments in each.
    """
    if last_cycle_alone and path.period is not None:
        start_of_last_cycle = path.cycle_start + (n_cycles - 1) * path.period
        return np.linspace(
            start_of_last_cycle, start_of_last_cycle + path.period, increments_per_cycle // 2 + 1
        )[1:]
    # A few instants in each segment of the initial loading, then the cycles.
    times_of_parts = [
        np.linspace(segment.start, segment.end, increments_per_cycle // 16 + 1)
        for segment in path.initial_loading
    ]
    if path.period is not None:
        end_of_last_cycle = path.cycle_start + n_cycles * path.period
        times_of_parts.append(
            np.linspace(
                path.cycle_start, end_of_last_cycle, n_cycles * (increments_per_cycle // 2) + 1
            )
        )
    return np.unique(np.concatenate(times_of_parts))


def _work_per_area_at(grids: Grid, solution: _GridSolution, x: Array) -> Array:
    """Friction work per area of the last cycle, W(x), by each of g grids at points x (m,), (g, m)
    [energy per area]: linear between the middles of cells, 0 beyond them.

    Parameters
    ----------
    grids
        `x` (g, k) are the middles of the k cells of each grid
    solution
        `work_per_area` (g, k) is that of the cells in the last cycle
    """
    by_grid = [
        np.interp(x, cell_middles, work_of_cells, left=0.0, right=0.0)
        for cell_middles, work_of_cells in zip(grids.x, solution.work_per_area, strict=True)
    ]
    return np.array(by_grid)


def _error_left(
    fine_values: Array, coarse_values: Array, convergence_order: float | Array
) -> Array:
    """Error that is left in the mean over fine grids: its change from coarse ones divided by
    2^order - 1 (Richardson).

    Parameters
    ----------
    fine_values, coarse_values
        values by each grid, with the grids along the first axis, of one shape
    convergence_order
        order with which the error falls if cells or increments are halved, one for all or one for
        each value
    """
    change_from_coarse_grids = np.mean(fine_values, axis=0) - np.mean(coarse_values, axis=0)
    return np.asarray(change_from_coarse_grids / (2**convergence_order - 1))


def _relative_error(fine_values: Array, error_left: Array) -> float:
    """Relative error of the mean over the fine grids: a root mean square over all points and
    instants, divided by the largest fine value. 0 where all fine values are 0.

    It is twice the sum of two parts, of which each is such a root mean square:

    - `error_left`, by the change from coarse grids to fine ones;
    - twice the standard error of the mean, from the means of four groups of grids.

    `fine_values` are by each grid, with the grids along the first axis; `error_left` has the other
    axes.
    """
    largest_value = float(np.max(np.abs(fine_values), initial=0.0))
    if largest_value <= 0:
        return 0.0
    # Every fourth grid forms a group.
    means_of_groups = np.array(
        [
            np.mean(fine_values[first_grid::_COUNT_OF_GRID_GROUPS], axis=0)
            for first_grid in range(_COUNT_OF_GRID_GROUPS)
        ]
    )
    squared_standard_error = np.var(means_of_groups, axis=0) / (_COUNT_OF_GRID_GROUPS - 1)
    standard_error = np.sqrt(np.mean(squared_standard_error))
    error_by_change = np.sqrt(np.mean(error_left**2))
    error = 2 * standard_error + error_by_change
    return _SAFETY_OF_CHANGE * float(error) / largest_value
