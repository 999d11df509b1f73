"""Half-plane theory on a grid: contact with friction under any course of P, Q, bulk strain and
tilt, stick in any number of pieces.

The last resort: `memory` knows where stick ends and is exact to rounding; here cells stick, slip or
are open.

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
exact routines against `solve`. Edges err by a cell.

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
from semi_analytic.history import check
from semi_analytic.tilted_profile import TiltedProfile

CELLS = 160
"""Cells across the largest contact; half as many tell the error."""
INCREMENTS = 320
"""Increments a cycle; half as many tell the error."""

# Turns of an active set that are allowed: it takes about ten.
_TURNS = 200
# Numbers of cells in contact whose matrices are held: they take the square of them.
_ZONES = 120
# Share of the largest f p that rounding may leave of q beyond the limit: cells that stop to slip
# are there.
_ROUNDING = 1e-12
# Share of the slip of an increment that a cell makes before it is touched.
_TOUCHED = 1 / 3
# Increments of a leg of the cycle at least; each leg of the initial loading has a quarter of those
# of a cycle.
_OF_LEG = 4
# Share of its work by which a cycle may differ from the one before and repeat it: far below what
# the grid leaves.
STEADY = 1e-6
# Shares of a cell by which grids are moved, evenly, so that waves of a cell, a half, a third ...
# cancel in their mean; no two are mirror images under a symmetric contact. How many groups of them
# tell what is left.
_SHIFTS = (np.arange(16) + 0.25) / 16
_GROUPS = 4
# Cycles that grids take up before the last where a coarse one went first, and the last.
_RESUMED = 2
# Instants, out of those asked for, at which coarse grids are held against the others.
_COMPARED = 40
# Share of the largest slip of a cycle up to which a cell counts as permanently stuck.
_STAYS = 1e-3
_STATES = np.array([STICK, SLIP_FORWARD, SLIP_REVERSE])


class Fields(NamedTuple):
    """The answer at n instants and k cells.

    Attributes
    ----------
    x, step
        (k,) middles of the cells; their width
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
        (n, k) friction work of the increment that ends there, by the trapezoidal rule
    work, loop
        (n,) its sum, and Q dU - m_q d eps of the increment, also by the trapezoidal rule
    """

    x: Array
    step: float
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
    loop: Array

    def edges(self, instant: int, *, stick: bool = False) -> tuple[float, float]:
        """Outer edges of the cells in contact, or of those that stick, at an instant; NaN where
        there are none.
        """
        return self._ends(self.state[instant] == STICK if stick else self.state[instant] != OPEN)

    def permanent_stick(self, first: int, share: float = 1e-9) -> tuple[float, float]:
        """Outer edges of the cells that stay in contact from instant `first` on and slip at most
        `share` of the farthest.
        """
        slip_range = np.ptp(self.slip[first:], axis=0)
        stays_in_contact = np.all(self.state[first:] != OPEN, axis=0)
        return self._ends(stays_in_contact & (slip_range <= share * np.max(slip_range)))

    def cycle_work(self, increments: int, *, loop: bool = False) -> Array:
        """Friction work, or closed integral of Q dU - m_q d eps, of the last whole cycles of so
        many increments.
        """
        values = (self.loop if loop else self.work)[1:]
        return values[len(values) % increments :].reshape(-1, increments).sum(axis=1)

    def _ends(self, cells: NDArray[np.bool_]) -> tuple[float, float]:
        middles = self.x[cells]
        if not len(middles):
            return math.nan, math.nan
        return float(middles[0] - self.step / 2), float(middles[-1] + self.step / 2)


@dataclass(frozen=True, eq=False)
class Zone:
    """Cells side by side that are in contact.

    Attributes
    ----------
    root
        M with M^T M = C^-1
    rows, row_sum
        the row sums of C^-1, and their sum
    """

    root: Array
    rows: Array
    row_sum: float

    @cached_property
    def stiffness(self) -> Array:
        """G = C^-1 less what a shift of all cells does: t = total rows/row_sum + G b has C t = b +
        const and the sum `total`.
        """
        inverse = self.root.T @ self.root
        return np.asarray(inverse - np.outer(self.rows, self.rows / self.row_sum))


class ContactCells(NamedTuple):
    """The cells of each grid that are in contact, side by side, (g,): the first, and how many."""

    begin: NDArray[np.intp]
    number: NDArray[np.intp]

    @property
    def end(self) -> NDArray[np.intp]:
        """Number behind the last cell."""
        return self.begin + self.number

    def common_with(self, second: ContactCells) -> ContactCells:
        """Cells that are in both; a number <= 0 where there are none."""
        begin = np.maximum(self.begin, second.begin)
        return ContactCells(begin, np.minimum(self.end, second.end) - begin)


class Pressed(NamedTuple):
    """The answer of the normal problem: p (g, k), cells in contact, delta (g,)."""

    pressure: Array
    contact: ContactCells
    approach: Array


class Dragged(NamedTuple):
    """The answer of the tangential problem: q, s and direction of slip (g, k), U (g,)."""

    shear: Array
    slip: Array
    directions: NDArray[np.intp]
    shift: Array


class Grid:
    """Two half-planes that meet in equal cells, and where they stand: nothing touches at first.

    Several grids of the same cells, moved by shares of a cell, are followed side by side: their
    matrices are the same.

    Attributes
    ----------
    x, step
        (g, k) middles of the cells of g grids; their width
    """

    def __init__(
        self,
        height: Callable[[Array], Array],
        extent: ArrayLike,
        cells: int,
        friction: float,
        modulus: float = 1.0,
        dundurs: float = 0.0,
    ) -> None:
        """`extent` is (2,) the ends of one grid, or (g, 2) those of grids of one length."""
        ends = np.atleast_2d(np.asarray(extent, dtype=float))
        self.alone = np.ndim(extent) == 1
        self.cells = cells
        self.modulus = modulus
        self.friction = friction
        self.dundurs = dundurs
        self._length = float(ends[0, 1] - ends[0, 0])
        self.step = self._length / cells
        self.x: Array = ends[:, :1] + self.step * (np.arange(cells) + 0.5)
        self.datum = 2 / (math.pi * modulus) * math.log(self._length)
        self._height = height(self.x)
        self._numbers = np.arange(cells)
        self._compliance = self.compliance_at(self.x[0], 0)
        signs = np.sign(self._numbers[:, None] - self._numbers)
        self._coupling = dundurs / modulus * self.step * signs
        cholesky_factor = scipy.linalg.cholesky(self._compliance, lower=True)
        self._root: Array = scipy.linalg.solve_triangular(
            cholesky_factor, np.eye(cells), lower=True
        )
        self._zones: dict[int, Zone] = {}
        self._pressed: dict[tuple[float, float], Pressed] = {}
        # increments whose new cells did not slip before they were touched: `_drag`
        self.without_early_slip = 0
        # where the grids stand
        no_cells = np.zeros(len(self.x), dtype=int)
        self._contact = ContactCells(no_cells, no_cells)
        self._shear: Array = np.zeros(self.x.shape)
        self.slip: Array = np.zeros(self.x.shape)
        self._shift: Array = np.zeros(len(self.x))
        self._strain = 0.0
        self._directions: NDArray[np.intp] = np.zeros(self.x.shape, dtype=int)
        self._last: dict[str, Any] | None = None

    def compliance_at(self, x: Array, number: int) -> Array:
        """Displacement at points (m,) by a unit traction on each cell of a grid, (m, k); the grid's
        length is the datum length.
        """
        distance = (x[:, None] - self.x[number])[..., None]
        ends = (distance + self.step * np.array([-0.5, 0.5])) / self._length
        with np.errstate(divide="ignore", invalid="ignore"):
            primitive = np.where(ends == 0, 0.0, ends * (np.log(np.abs(ends)) - 1))
        integral = np.diff(primitive, axis=-1)[..., 0]
        return np.asarray(-2 * self._length / (math.pi * self.modulus) * integral)

    def _zone(self, count: int) -> Zone:
        """Of so many cells: equal cells have one C wherever they lie, and the root of C^-1 is a
        corner of that of all.
        """
        if count not in self._zones:
            root = self._root[:count, :count]
            rows = root.T @ np.sum(root, axis=1)
            self._zones[count] = Zone(root, rows, float(np.sum(rows)))
            if len(self._zones) > _ZONES:
                self._zones.pop(next(iter(self._zones)))
        return self._zones[count]

    def _inside(self, contact: ContactCells) -> NDArray[np.bool_]:
        """Which cells are in contact: (g, k)."""
        begin = contact.begin[:, None]
        end = contact.end[:, None]
        return (self._numbers >= begin) & (self._numbers < end)

    def _press(self, load: float, tilt: float, lifted: Array) -> Pressed:
        """Pressure, cells in contact and normal approach of each grid: p > 0 where g = 0."""
        height = lifted + tilt * self.x
        contact = self._contact
        if not contact.number.all():
            contact = ContactCells(np.argmin(height, axis=1) - 2, np.full(len(height), 5))
        for _ in range(_TURNS):
            pressure = np.zeros(height.shape)
            approach = np.zeros(len(height))
            for cells in np.unique(contact.number).tolist():
                zone = self._zone(cells)
                grids = np.flatnonzero(contact.number == cells)
                at = (grids[:, None], contact.begin[grids, None] + np.arange(cells))
                approach[grids] = (load / self.step + height[at] @ zone.rows) / zone.row_sum
                by_height = (height[at] @ zone.root.T) @ zone.root
                pressure[at] = approach[grids, None] * zone.rows - by_height
            inside = self._inside(contact)
            gap = height - approach[:, None] + pressure @ self._compliance
            touches = np.where(inside, pressure > 0, gap < 0)
            if np.array_equal(touches, inside):
                break
            begin = np.argmax(touches, axis=1)
            end = self.cells - np.argmax(touches[:, ::-1], axis=1)
            contact = ContactCells(begin, end - begin)
        else:
            raise ArithmeticError("the contact area does not converge")
        if np.any(contact.begin == 0) or np.any(contact.end == self.cells):
            raise ArithmeticError("the contact meets the end of the grid")
        return Pressed(pressure, contact, approach)

    def _drag(
        self, force: float, displacement: Array, limit: Array, earlier_cells: ContactCells
    ) -> Dragged:
        """Shear, slip, directions of slip and U: no slip where |q| < f p, once a cell is touched;
        the cells `earlier` were in contact before.

        Ahead of an edge that comes slip goes on as the root of the distance: a cell that is touched
        after a share t of the increment has then made 2/3 t of the way that it would have made, 1/3
        in the mean over all t.
        """
        contact = self._contact
        common = contact.common_with(earlier_cells)
        has_grown = (common.begin > contact.begin) | (common.end < contact.end)
        grown = np.flatnonzero((common.number > 0) & has_grown)
        start = self.slip.copy()
        waiting = [grown] if len(grown) else []
        while waiting:
            grids = waiting.pop()
            try:
                early_slip = self._dragged(force, displacement, limit, common, start, grids).slip
            except ArithmeticError:
                # more than the earlier ones can carry: the new ones start from where they were
                if len(grids) > 1:
                    waiting += np.split(grids, len(grids))
                else:
                    self.without_early_slip += 1
                continue
            is_new = self._inside(contact)[grids] & ~self._inside(common)[grids]
            start[grids] += np.where(is_new, _TOUCHED * (early_slip - start[grids]), 0.0)
        return self._dragged(force, displacement, limit, contact, start, np.arange(len(self.x)))

    def _dragged(
        self,
        force: float,
        displacement: Array,
        limit: Array,
        contact: ContactCells,
        start: Array,
        grids: NDArray[np.intp],
    ) -> Dragged:
        """`_drag` of some grids whose cells `contact` are in contact, with the slip `start`.

        q = q_0 - G v with q_0 of full stick and the slip v of the increment, that of few cells.
        Where grids have fewer cells in contact than others, open ones beside them slip without
        friction.
        """
        inside = self._inside(contact)[grids]
        cells = int(contact.number[grids].max())
        zone = self._zone(cells)
        first_column = np.minimum(contact.begin[grids], self.cells - cells)
        columns = first_column[:, None] + np.arange(cells)
        rows = np.arange(len(grids))[:, None]
        cells_at = (grids[:, None], columns)
        free_slip = (displacement - start)[cells_at]
        touching = inside[rows, columns]
        limit_here = np.where(touching, limit[cells_at], 0.0)
        allowed = _ROUNDING * limit.max()
        stuck_shear = force / self.step / zone.row_sum * zone.rows + free_slip @ zone.stiffness
        # Most cells go on as in the increment before: the first guess, unless it leaves none that
        # stick.
        direction = np.where(touching, self._directions[cells_at], 0)
        direction[np.all((direction != 0) | ~touching, axis=1)] = 0
        for _ in range(_TURNS):
            slides = (direction != 0) | ~touching
            if np.any(np.all(slides, axis=1)):
                raise ArithmeticError("all cells slip")
            fixed_shear = direction * limit_here
            slip = _slip_of_sliding(zone, slides, stuck_shear - fixed_shear)
            shear = stuck_shear
            if np.any(slides):
                shear = np.where(slides, fixed_shear, stuck_shear - slip @ zone.stiffness)
            exceeds = ~slides & (np.abs(shear) > limit_here + allowed)
            goes_on = np.where(direction * slip > 0, direction, 0)
            new_direction = np.where(exceeds, np.sign(shear), goes_on).astype(int)
            if np.array_equal(new_direction, direction):
                break
            direction = new_direction
        else:
            raise ArithmeticError("the slip zones do not converge")
        all_shear = np.zeros(inside.shape)
        all_directions = np.zeros(inside.shape, dtype=int)
        all_shear[rows, columns] = shear
        all_directions[rows, columns] = direction
        shift = (force / self.step + (slip - free_slip) @ zone.rows) / zone.row_sum
        all_slip = shift[:, None] + displacement[grids] - all_shear @ self._compliance
        return Dragged(all_shear, all_slip, all_directions, shift)

    def _increment(self, load: float, force: float, strain: float, tilt: float) -> dict[str, Any]:
        """One increment to P, Q, eps and alpha: a row of `Fields`."""
        strained: Array = -strain * self.x
        if load <= 0:
            pressed, dragged = self._open(strained)
        elif not self.dundurs:
            if (load, tilt) not in self._pressed:
                self._pressed[load, tilt] = self._press(load, tilt, self._height)
            pressed = self._pressed[load, tilt]
            earlier_cells = self._contact
            self._contact = pressed.contact
            dragged = self._drag(force, strained, self.friction * pressed.pressure, earlier_cells)
        else:
            pressed, dragged = self._press_and_drag_in_turn(load, force, tilt, strained)
        q, slip, directions, shift = dragged
        density = (self._shear + q) * (slip - self.slip) / 2
        state = np.where(self._inside(self._contact), _STATES[directions], OPEN).astype(np.int8)
        row: dict[str, Any] = {
            "loads": np.array([load, force, strain, tilt]),
            "pressure": pressed.pressure,
            "shear": q,
            "slip": slip,
            "state": state,
            "approach": pressed.approach - self.datum * load,
            "displacement": shift - self.datum * force,
            "moment": self.step * np.sum(self.x * pressed.pressure, axis=1),
            "shear_moment": self.step * np.sum(self.x * q, axis=1),
            "density": density,
            "work": self.step * np.sum(density, axis=1),
        }
        row["loop"] = _loop_between(self._last or row, row)
        self._shear = q
        self.slip = slip
        self._shift = shift
        self._strain = strain
        self._directions = directions
        self._last = row
        return row

    def _open(self, strained: Array) -> tuple[Pressed, Dragged]:
        """No contact: the bodies stay where they are, and strain."""
        no_cells = np.zeros(len(self.x), dtype=int)
        self._contact = ContactCells(self._contact.begin, no_cells)
        no_traction = np.zeros(self.x.shape)
        pressed = Pressed(no_traction, self._contact, np.zeros(len(self.x)))
        directions = np.zeros(self.x.shape, dtype=int)
        slip = self._shift[:, None] + strained
        return pressed, Dragged(no_traction, slip, directions, self._shift)

    def _press_and_drag_in_turn(
        self, load: float, force: float, tilt: float, strained: Array
    ) -> tuple[Pressed, Dragged]:
        """Pressure and shear of unlike bodies, by turns until the shear rests."""
        earlier_cells = self._contact
        shear_before = self._shear
        for _ in range(_TURNS):
            pressed = self._press(load, tilt, self._height + shear_before @ self._coupling.T)
            self._contact = pressed.contact
            displacement = strained + pressed.pressure @ self._coupling.T
            dragged = self._drag(
                force, displacement, self.friction * pressed.pressure, earlier_cells
            )
            change = float(np.max(np.abs(dragged.shear - shear_before)))
            shear_before = dragged.shear
            if change <= _ROUNDING * self.friction * pressed.pressure.max():
                return pressed, dragged
        raise ArithmeticError("pressure and shear by turns do not converge")

    def slip_field(self) -> Callable[[Array], Array]:
        """Mean slip of the grids as they stand, as a function of points (m,), in contact and
        outside.
        """
        shear = self._shear
        mean_shift = float(np.mean(self._shift))
        strain = self._strain

        def slip(x: Array) -> Array:
            by_shear = [self.compliance_at(x, number) @ row for number, row in enumerate(shear)]
            return np.asarray(mean_shift - strain * x - np.mean(by_shear, axis=0))

        return slip

    def resume(self, slip: Callable[[Array], Array], loads: Array) -> None:
        """Stand under P, Q, eps and alpha (4,) with a slip known from another grid, as far as
        friction holds it.
        """
        load, force, strain, tilt = loads.tolist()
        self.slip = np.stack([slip(x) for x in self.x])
        self._contact = self._press(load, tilt, self._height).contact
        self._increment(load, force, strain, tilt)

    def follow(self, loads: Array) -> Fields:
        """Increments to rows of P, Q, eps and alpha, (n, 4).

        Raises ArithmeticError where active sets do not converge, all cells slip, or the contact
        meets the end of the grid.
        """
        rows = []
        for load, force, strain, tilt in loads.tolist():
            try:
                rows.append(self._increment(load, force, strain, tilt))
            except ArithmeticError as fault:
                raise ArithmeticError(f"{fault} at P = {load:.6g}, Q = {force:.6g}") from fault
        fields = {}
        for name in rows[0]:
            fields[name] = np.array([row[name] for row in rows])
        if not self.alone:
            return Fields(self.x, self.step, **fields)
        for name in fields.keys() - {"loads"}:
            fields[name] = fields[name][:, 0]
        return Fields(self.x[0], self.step, **fields)


def _slip_of_sliding(zone: Zone, slides: NDArray[np.bool_], excess: Array) -> Array:
    """Slip v of the cells that slide, (g, k) and 0 elsewhere: G v = q_0 - q over them, `excess`."""
    slip = np.zeros(excess.shape)
    most_sliding = int(np.max(np.sum(slides, axis=1)))
    if not most_sliding:
        return slip
    # The cells that slip first, as many as of the grid with most of them: what is too much has the
    # matrix 1.
    cells = slides.shape[1]
    order = np.argsort(~slides, axis=1, kind="stable")[:, :most_sliding]
    is_sliding = np.take_along_axis(slides, order, axis=1)
    stiffness = zone.stiffness.ravel().take(order[:, :, None] * cells + order[:, None, :])
    if not is_sliding.all():
        stiffness *= is_sliding[:, :, None] & is_sliding[:, None, :]
        diagonal = np.arange(most_sliding)
        stiffness[:, diagonal, diagonal] += ~is_sliding
    right_side = np.where(is_sliding, np.take_along_axis(excess, order, axis=1), 0.0)
    solved_slip = np.linalg.solve(stiffness, right_side[..., None])[..., 0]
    np.put_along_axis(slip, order, solved_slip, axis=1)
    return slip


def _loop_between(row_before: dict[str, Any], row: dict[str, Any]) -> Array:
    """Q dU - m_q d eps between two rows of `Fields`, by the trapezoidal rule."""
    _, force_before, strain_before, _ = row_before["loads"]
    _, force, strain, _ = row["loads"]
    mean_moment = (row["shear_moment"] + row_before["shear_moment"]) / 2
    displaced = row["displacement"] - row_before["displacement"]
    return np.asarray(
        (force + force_before) / 2 * displaced - mean_moment * (strain - strain_before)
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
    dundurs: float = 0.0,
) -> Fields:
    """Follow instants (n,) of P, Q, eps and the tilt from bodies that have never touched.

    The first instant is one increment from nothing; where P = 0 there, its eps is in place at first
    touch. `extent` is the grid. Raises ArithmeticError as `Grid.follow`.

    >>> fields = follow_instants(
    ...     lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0]
    ... )  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(fields.edges(0)[1] - (1.6 / math.pi) ** 0.5) < fields.step
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    return Grid(height, extent, cells, friction, modulus, dundurs).follow(loads)


# ------------------------------------------------------------------------------ a scene's load path
class _Rows(NamedTuple):
    """Increments of a cycle: P, Q, eps, alpha at its instants (n, 4); rows `at` which instants that
    are asked for lie, and their numbers `instants` among these, (k,) each.
    """

    loads: Array
    at: NDArray[np.intp]
    instants: NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class _Path:
    """A load path in increments."""

    loads: PathLoads
    increments: int
    _known: dict[bytes, Array] = field(default_factory=dict)

    def rows(self, number: int, time: Array) -> _Rows:
        """Of a cycle (-1: before), with the instants `time` (k,) among its own."""
        path = self.loads.path
        time_in_cycle = time - max(number, 0) * (path.period or 0.0)
        legs = path.initial_loading if number < 0 else path.cycle
        times = [
            self._times_of_leg(leg, k, number < 0, time_in_cycle) for k, leg in enumerate(legs)
        ]
        loads = []
        for times_of_leg in times:
            key = times_of_leg.tobytes()
            if key not in self._known:
                self._known[key] = self.loads.values(times_of_leg).T
            loads.append(self._known[key])
        all_times = np.concatenate(times)
        is_behind_start = (time_in_cycle > legs[0].start) | (number < 0)
        instants = np.flatnonzero((time_in_cycle <= legs[-1].end) & is_behind_start)
        at = [np.argmin(np.abs(all_times - max(t, path.start))) for t in time_in_cycle[instants]]
        return _Rows(np.concatenate(loads), np.array(at, dtype=int), instants)

    def _times_of_leg(
        self, leg: LoadSegment, place: int, initial: bool, time_in_cycle: Array
    ) -> Array:
        """Times of the increments of a leg, number `place` of the initial loading or of the cycle.

        Increments of its own make way for instants that are asked for, but where a load turns
        round.
        """
        path = self.loads.path
        first_touch = leg is path.initial_loading[0]
        duration = leg.end - leg.start
        periodic_legs = path.cycle or path.initial_loading
        fewest = _OF_LEG
        if initial and (path.cycle or not place):
            fewest = self.increments // 4
        share = duration / (periodic_legs[-1].end - periodic_legs[0].start)
        if initial and path.cycle:
            share = 0.0
        count = max(fewest, math.ceil(self.increments * share))
        # From first touch in equal steps of the contact's size.
        places = np.linspace(0, 1, count + 1)[1:] ** (2 if first_touch else 1)
        spread_times = leg.start + duration * places
        turns = self.loads.turns(leg)
        asked_times = time_in_cycle[(time_in_cycle > leg.start) & (time_in_cycle <= leg.end)]
        if first_touch and np.any(time_in_cycle <= path.start):
            asked_times = np.append(asked_times, path.start)
        to_asked = np.min(np.abs(spread_times[:, None] - asked_times), axis=1, initial=math.inf)
        spread_times = spread_times[to_asked >= 0.5 * duration / count]
        to_turn = np.min(np.abs(asked_times[:, None] - turns), axis=1, initial=math.inf)
        asked_times = asked_times[to_turn > 2e-9 * duration]
        return np.unique(np.concatenate([spread_times, turns, asked_times]))


@dataclass(eq=False)
class _Answers:
    """What g grids answer at n instants and m points, along cycles.

    Attributes
    ----------
    share, slip
        (n, m) means over the grids of q over f p and of s
    share_of_each, slip_of_each
        (g, n', m) of each grid, at every so many instants
    stick_edges
        (n, 2) means
    loads
        (4, n) P, Q, eps and alpha
    displacement, shear_moment
        (n,) means
    zones
        the largest number of zones that stick
    begins
        mean slip, as a function of x, where each cycle begins
    increments
        how many were made
    works
        (g, c) friction work of the cycles
    work, loop
        (g,) of the last; its closed integral of Q dU - m_q d eps
    density
        (g, k) friction work of the cells in the last
    permanent
        (2,) mean edges of what sticks through the last
    """

    share: Array
    slip: Array
    share_of_each: Array
    slip_of_each: Array
    stick_edges: Array
    loads: Array
    displacement: Array
    shear_moment: Array
    zones: int = 1
    begins: list[Callable[[Array], Array]] = field(default_factory=list)
    increments: int = 0
    works: Array = field(default_factory=lambda: np.empty(0))
    work: Array = field(default_factory=lambda: np.empty(0))
    loop: Array = field(default_factory=lambda: np.empty(0))
    density: Array = field(default_factory=lambda: np.empty(0))
    permanent: Array = field(default_factory=lambda: np.full(2, np.nan))

    @classmethod
    def empty(cls, grids: int, instants: int, points: int, every: int) -> _Answers:
        """Before anything is followed."""
        of_each = (grids, -(-instants // every), points)
        return cls(
            share=np.zeros((instants, points)),
            slip=np.zeros((instants, points)),
            share_of_each=np.zeros(of_each),
            slip_of_each=np.zeros(of_each),
            stick_edges=np.full((instants, 2), np.nan),
            loads=np.zeros((4, instants)),
            displacement=np.zeros(instants),
            shear_moment=np.zeros(instants),
        )


class _State(NamedTuple):
    """The grids at an instant: q over f p and s at points (g, m), edges of stick (g, 2), the
    largest number of zones that stick.
    """

    share: Array
    slip: Array
    stick_edges: Array
    zones: int


def _state_at(grid: Grid, fields: Fields, instant: int, x: Array, kernels: Array) -> _State:
    """Of the instant of this number; `kernels` (g, m, k) are displacements by unit tractions."""
    grids = len(grid.x)
    _, force, strain, _ = fields.loads[instant]
    shift = fields.displacement[instant] + grid.datum * force
    by_shear = np.matmul(kernels, fields.shear[instant][..., None])[..., 0]
    slip = shift[:, None] - strain * x - by_shear
    share = np.zeros((grids, len(x)))
    edges = np.full((grids, 2), np.nan)
    zones = 1
    for number, state in enumerate(fields.state[instant]):
        touching = np.flatnonzero(state != OPEN)
        if not len(touching):
            continue
        middles = grid.x[number]
        limit = grid.friction * fields.pressure[instant, number, touching]
        ratio = fields.shear[instant, number, touching] / limit
        share[number] = np.interp(x, middles[touching], ratio)
        sticks = np.concatenate([[False], state == STICK, [False]]).astype(int)
        begins_and_ends = np.flatnonzero(np.diff(sticks))
        zones = max(zones, len(begins_and_ends) // 2)
        if len(begins_and_ends):
            first = begins_and_ends[0]
            last = begins_and_ends[-1] - 1
            # A cell that sticks at the edge of contact sticks up to it.
            left = -np.inf if first == touching[0] else middles[first] - grid.step / 2
            right = np.inf if last == touching[-1] else middles[last] + grid.step / 2
            edges[number] = (left, right)
    return _State(share, slip, edges, zones)


def _run(
    grid: Grid,
    path: _Path,
    x: Array,
    time: Array,
    numbers: range,
    least_cycles: int,
    every: int = 1,
) -> _Answers:
    """What grids answer along cycles (-1: the initial loading) until one repeats the one before,
    `least` cycles at any rate; each of them at every so many of the instants `time` (n,).
    """
    grids = len(grid.x)
    answers = _Answers.empty(grids, len(time), len(x), every)
    works: list[Array] = []
    kernels = np.zeros(0)
    if len(time):
        kernels = np.array([grid.compliance_at(x, number) for number in range(grids)])
    for number in numbers:
        if number >= 0:
            answers.begins.append(grid.slip_field())
        rows = path.rows(number, time)
        slip_before = grid.slip
        try:
            fields = grid.follow(rows.loads)
        except ArithmeticError as fault:
            raise InputError(
                f"load: half-plane theory takes grids for such bulk stress or tilt, and {fault} of"
                f" cycle {number + 1}; finite elements may take the scene"
            ) from fault
        answers.increments += len(rows.loads)
        answers.loads[:, rows.instants] = fields.loads[rows.at].T
        answers.displacement[rows.instants] = np.mean(fields.displacement[rows.at], axis=1)
        answers.shear_moment[rows.instants] = np.mean(fields.shear_moment[rows.at], axis=1)
        for i, instant in zip(rows.instants.tolist(), rows.at.tolist(), strict=True):
            state = _state_at(grid, fields, instant, x, kernels)
            answers.share[i] = np.mean(state.share, axis=0)
            answers.slip[i] = np.mean(state.slip, axis=0)
            answers.stick_edges[i] = np.mean(state.stick_edges, axis=0)
            answers.zones = max(answers.zones, state.zones)
            if i % every == 0:
                answers.share_of_each[:, i // every] = state.share
                answers.slip_of_each[:, i // every] = state.slip
        if number >= 0 or not path.loads.path.cycle:
            works.append(np.sum(fields.work, axis=0))
        if len(works) >= max(least_cycles, 2):
            change = abs(np.mean(works[-1] - works[-2]))
            if change <= STEADY * np.mean(works[-1]):
                break
    answers.works = np.array(works).T
    answers.work = works[-1]
    answers.loop = np.sum(fields.loop, axis=0)
    answers.density = np.sum(fields.density, axis=0)
    answers.permanent = _permanent_edges(grid, fields, slip_before)
    return answers


def _permanent_edges(grid: Grid, fields: Fields, slip_before: Array) -> Array:
    """Mean edges (2,) of the cells that stick all along the fields of a cycle; NaN where in some
    grid none do.
    """
    slips = np.abs(np.diff(fields.slip, axis=0, prepend=slip_before[None]))
    # What opens does not stick: it counts as slip without end.
    path_of_cell = np.sum(np.where(fields.state == OPEN, np.inf, slips), axis=0)
    is_finite = np.isfinite(path_of_cell)
    longest = np.max(path_of_cell, axis=1, where=is_finite, initial=0.0)
    stays = path_of_cell <= _STAYS * longest[:, None]
    edges = np.full((len(grid.x), 2), np.nan)
    for number, middles in enumerate(grid.x):
        stuck = middles[stays[number]]
        if len(stuck):
            edges[number] = (np.min(stuck) - grid.step / 2, np.max(stuck) + grid.step / 2)
    return np.asarray(np.mean(edges, axis=0))


def edges_along(loads: PathLoads, contact: TiltedProfile) -> Array:
    """Edges of contact at instants of the initial loading and of a cycle, (n, 2)."""
    path = _Path(loads, INCREMENTS)
    numbers = (-1, 0) if loads.path.cycle else (-1,)
    rows = np.concatenate([path.rows(number, np.zeros(0)).loads for number in numbers])
    loaded_rows = rows[rows[:, 0] > 0]
    load, _, _, tilt = loaded_rows.T
    middle, half_width = contact.under(load, tilt)
    return np.stack([middle - half_width, middle + half_width], axis=-1)


@dataclass(frozen=True, eq=False)
class Followed:
    """What was followed, n instants and k points; edges (n, 2), fields (n, k).

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
        friction work of each cycle that was followed; of the whole path where none repeats
    loop
        closed integral of Q dU - m_q d eps of the last
    remainder
        estimate of what the work of the last cycle still is from the steady one
    steady_from, steady_to
        index of the first cycle that repeats the one before to this share of W, None if none
        does
    density
        (k,) friction work at the points, of the last cycle
    permanent_stick_edges
        (2,) of the last cycle; NaN where none
    counts
        grids, cells, increments, zones that stick
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
    loop: float
    remainder: float
    steady_from: int | None
    steady_to: float
    density: Array
    permanent_stick_edges: Array
    counts: dict[str, int]
    errors: dict[str, float]


def cycles_needed(path: LoadPath, time: Array | None) -> int:
    """How many cycles reach the last of some instants, one at least."""
    if path.period is None or time is None or not len(time):
        return 1
    return max(1, math.ceil((float(np.max(time)) - path.cycle_start) / path.period - 1e-9))


def first_repeat(works: Sequence[float] | Array, share: float) -> int | None:
    """Index of the first cycle whose work is that of the one before, to a share of it."""
    for number in range(1, len(works)):
        if abs(works[number] - works[number - 1]) <= share * works[number]:
            return number
    return None


def remainder_of(works: Sequence[float]) -> float:
    """How far the work of the last cycle may be from that of the steady one, from the trend of the
    changes.

    Geometric where the last two ratios of changes are below a half, alike and not rising. Else they
    may fall as slowly as k^-4, however fast the first ones were: k/3 times the last.

    >>> round(remainder_of([1.5, 1.05, 1.005, 1.0005]), 12)  # W falls to 1
    0.0005
    >>> works = [1 + k**-3.0 for k in range(1, 41)]  # 1.6e-5 is left
    >>> 1e-5 < remainder_of(works) < 3e-5
    True
    """
    changes = np.abs(np.diff(works))
    if not len(changes):
        return math.inf
    last_change = float(changes[-1])
    if len(changes) < 2 or last_change == 0:
        return last_change
    ratios = changes[1:] / np.maximum(changes[:-1], np.finfo(float).tiny)
    ratio = float(ratios[-1])
    ratio_before = float(ratios[-2]) if len(ratios) > 1 else 1.0
    if ratio < 0.5 and 0.8 * ratio_before < ratio < 1.05 * ratio_before:
        return last_change * ratio / (1 - ratio)
    bounded = min(ratio, 0.9)
    return last_change * max(len(works) / 3, bounded / (1 - bounded))


@dataclass(frozen=True)
class GridRequest:
    """What is wanted of grids, and how fine they are.

    Attributes
    ----------
    most_cycles
        largest number of cycles
    steady
        whether the last cycle alone is wanted, without q and s; of `works` all but the last are
        then of coarse grids
    pointwise
        whether q, s and the state are wanted at points; NaN and open otherwise
    cells, increments
        across the largest contact, a cycle
    """

    most_cycles: int = 12
    steady: bool = False
    pointwise: bool = True
    cells: int = CELLS
    increments: int = INCREMENTS


def follow_on_grid(
    loads: PathLoads,
    contact: TiltedProfile,
    height: Callable[[Array], Array],
    friction: float,
    x: Array,
    time: Array | None = None,
    request: GridRequest = GridRequest(),
) -> Followed:
    """Follow a load path with bulk stress and tilt from first touch, cycle by cycle until it is
    steady to 1e-6 of its work.

    One coarse grid goes first and finds how many cycles that takes. Where only the last is asked
    for, all coarse ones do, and the fine ones take up their mean slip where the last but one
    begins: what that leaves locked in is not what the path leaves, and changes W and the zones by
    less than the fine ones differ from the coarse ones, which the stated error holds.

    Pressure and contact edges are those of `contact`, exact. All else is the mean over 16 grids
    that are moved by shares of a cell. Errors are twice the standard error of that mean and what is
    left of the change from half as many cells and increments, which falls by the power 1.5 in W, by
    the first in q and W(x), by 0.95 in s (root mean squares: at an edge of stick q errs by the root
    of a cell).

    Parameters
    ----------
    loads
        P, Q, eps and alpha of the path
    contact
        the profile under load and tilt; its path is within its `intervals.most`
    height
        h(x)
    friction
        f
    x
        (k,) points
    time
        (n,) instants in any order; every second increment if None
    request
        what is wanted, and how fine the grids are

    Raises
    ------
    InadmissibleLoadError
        For gross sliding and separation.
    InputError
        Where an increment does not converge, as at the limit of gross sliding.
    """
    path = loads.path
    check([*path.initial_loading, *path.cycle], friction)
    period = path.period
    needed = cycles_needed(path, time)
    cells = request.cells
    increments = request.increments
    coarse_path = _Path(loads, increments // 2)
    fine_path = _Path(loads, increments)
    edges = edges_along(loads, contact)
    left = float(np.min(edges))
    right = float(np.max(edges))
    modulus = 2 / contact.intervals.product
    points = x if request.pointwise else np.zeros(0)

    def grids(cells: int, shifts: Array) -> Grid:
        cell = (right - left) / cells
        extents = np.stack([left - (2 + shifts) * cell, right + (3 - shifts) * cell], axis=1)
        return Grid(height, extents, cells + 5, friction, modulus)

    # The coarse grid goes first: how many cycles are there?
    all_numbers = range(-1, max(request.most_cycles, needed)) if path.cycle else range(-1, 0)
    last_alone = request.steady and time is None and period is not None
    first_shifts = _SHIFTS if last_alone else _SHIFTS[:1]
    no_instants = np.zeros(0)
    first_grids = grids(cells // 2, first_shifts)
    first = _run(first_grids, coarse_path, points, no_instants, all_numbers, needed)
    cycles = first.works.shape[1]

    # The fine grids follow them, or take up the last ones.
    resumed = last_alone and cycles > _RESUMED
    numbers = range(-1, cycles if path.cycle else 0)
    if resumed:
        numbers = range(cycles - _RESUMED, cycles)
    if time is None:
        time = _default_times(path, cycles, increments, last_alone)
    time = np.asarray(time, dtype=float)
    every = max(len(time) // _COMPARED, 1)
    grid = grids(cells, _SHIFTS)
    if resumed:
        loads_at_begin = loads.values(np.array([path.cycle_start]))[:, 0]
        grid.resume(first.begins[numbers[0]], loads_at_begin)
    fine = _run(grid, fine_path, points, time, numbers, len(numbers), every)
    coarse_grids = first_grids
    coarse = first
    if not last_alone:
        coarse_grids = grids(cells // 2, _SHIFTS)
        coarse = _run(coarse_grids, coarse_path, points, time[::every], numbers, len(numbers))

    load, _, _, tilt = fine.loads
    middle, half_width = contact.under(load, tilt)
    contact_edges = np.stack([middle - half_width, middle + half_width], axis=-1)
    pressure = contact.pressure_over(x, middle, half_width)
    touching = (x >= contact_edges[:, :1]) & (x <= contact_edges[:, 1:])
    shear = np.full(touching.shape, np.nan)
    slip = shear
    state = np.full(touching.shape, OPEN)
    if request.pointwise:
        share = np.where(touching, fine.share, 0.0)
        shear = friction * pressure * share
        slip = fine.slip
        sliding = np.where(share > 0, SLIP_FORWARD, SLIP_REVERSE)
        in_contact = np.where(np.abs(share) < 1 - 1e-12, STICK, sliding)
        state = np.where(touching, in_contact, OPEN)

    works = np.mean(fine.works, axis=0)
    trend = works
    if resumed:
        trend = np.mean(first.works, axis=0)
        works = np.append(trend[:-1], works[-1])

    density = _density_at(grid, fine, x)
    coarse_density = _density_at(coarse_grids, coarse, x)
    errors = {
        "dissipation": _error(fine.work, coarse.work, order=1.5),
        "dissipation_density": _error(density, coarse_density, order=1),
    }
    if request.pointwise and not last_alone:
        limit = friction * pressure[::every]
        errors["shear"] = _error(limit * fine.share_of_each, limit * coarse.share_of_each, order=1)
        errors["slip"] = _error(fine.slip_of_each, coarse.slip_of_each, order=0.9)

    counts = {
        "grids": 2 * len(_SHIFTS),
        "cells": cells,
        "increments": first.increments + fine.increments,
        "pieces": fine.zones,
    }
    if not last_alone:
        counts["increments"] += coarse.increments
    if resumed:
        counts["cycles on coarse grids alone"] = numbers[0]
    if grid.without_early_slip:
        counts["increments without early slip"] = grid.without_early_slip
    return Followed(
        time=time,
        loads=fine.loads,
        moment=contact.moment(middle, half_width, load, tilt),
        shear_moment=fine.shear_moment,
        displacement=fine.displacement,
        contact_edges=contact_edges,
        stick_edges=np.clip(fine.stick_edges, contact_edges[:, :1], contact_edges[:, 1:]),
        pressure=pressure,
        shear=shear,
        slip=slip,
        state=state.astype(np.int8),
        works=works,
        loop=float(np.mean(fine.loop)),
        remainder=remainder_of(trend.tolist()),
        steady_from=first_repeat(trend, STEADY),
        steady_to=STEADY,
        density=np.mean(density, axis=0),
        permanent_stick_edges=fine.permanent,
        counts=counts,
        errors=errors,
    )


def cycle_works(
    loads: PathLoads,
    span: tuple[float, float],
    height: Callable[[Array], Array],
    friction: float,
    modulus: float,
    request: GridRequest,
) -> Array:
    """Friction work of each cycle (c,) on 16 grids that are moved by shares of a cell, (16, c),
    until one repeats the one before; of the whole path where none repeats, (16, 1).

    Parameters
    ----------
    span
        the outermost edges of contact, which the cells lie between [length]
    height
        h(x)
    friction, modulus
        f, E*
    request
        how fine the grids are, and the largest number of cycles

    Raises
    ------
    InputError
        Where an increment does not converge.
    """
    left, right = span
    cell = (right - left) / request.cells
    extents = np.stack([left - (2 + _SHIFTS) * cell, right + (3 - _SHIFTS) * cell], axis=1)
    grids = Grid(height, extents, request.cells + 5, friction, modulus)
    numbers = range(-1, request.most_cycles) if loads.path.cycle else range(-1, 0)
    nothing = np.zeros(0)
    return _run(grids, _Path(loads, request.increments), nothing, nothing, numbers, 1).works


def _default_times(path: LoadPath, cycles: int, increments: int, last_alone: bool) -> Array:
    """Every second increment of the last of so many cycles, or of all of them; fewer of the initial
    loading.
    """
    if last_alone and path.period is not None:
        begin = path.cycle_start + (cycles - 1) * path.period
        return np.linspace(begin, begin + path.period, increments // 2 + 1)[1:]
    times = [np.linspace(leg.start, leg.end, increments // 16 + 1) for leg in path.initial_loading]
    if path.period is not None:
        end = path.cycle_start + cycles * path.period
        times.append(np.linspace(path.cycle_start, end, cycles * (increments // 2) + 1))
    return np.unique(np.concatenate(times))


def _density_at(grid: Grid, answers: _Answers, x: Array) -> Array:
    """W(x) of each grid at points (m,): (g, m)."""
    rows = [
        np.interp(x, middles, density, left=0.0, right=0.0)
        for middles, density in zip(grid.x, answers.density, strict=True)
    ]
    return np.array(rows)


def _error(fine: Array, coarse: Array, order: float) -> float:
    """Error of the mean over the grids (first axis), over the largest value; root mean squares.

    What it changes from coarse grids over 2^order - 1, and twice the standard error by the means
    over every fourth grid, which are evenly moved themselves.
    """
    size = float(np.max(np.abs(fine), initial=0.0))
    if size <= 0:
        return 0.0
    change = np.mean(fine, axis=0) - np.mean(coarse, axis=0)
    quarters = np.array([np.mean(fine[k::_GROUPS], axis=0) for k in range(_GROUPS)])
    variance = np.var(quarters, axis=0) / (_GROUPS - 1)
    by_change = np.sqrt(np.mean(change**2)) / (2**order - 1)
    return float(2 * np.sqrt(np.mean(variance)) + by_change) / size
