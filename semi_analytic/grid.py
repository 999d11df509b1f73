"""Half-plane theory on a grid: contact with friction under any course of P, Q, bulk strain and tilt, stick in any number of pieces.

The last resort: `memory` and `fronts` know where stick ends and are exact to rounding; here cells stick, slip or are open.

# notation: A = 2/E*; p, q tractions, constant over equal cells; C_ij = -(A/pi) int_cell ln|x_i - xi| d xi, symmetric; g gap,
#           s slip of the upper face over the lower, delta normal approach, U displacement of the upper body, alpha tilt,
#           eps = sigma_lower/E'_lower - sigma_upper/E'_upper with E' = E/(1 - nu^2)

    g = h + alpha x - delta + C p + D q >= 0,   p >= 0,       p g = 0
    s = U - eps x - C q + D p,                  |q| <= f p,   slip only at |q| = f p and along q

D_ij = (beta/E*) sgn(x_i - x_j) times the cell couples both where Dundurs' beta is not 0 (Johnson, Contact Mechanics, 1985, section
5.1; the sign of beta is that of the mirror image, which loads to and fro between +-Q do not see): they take turns until q rests.

Each instant is one implicit increment from the one before. Active sets find the open, sticking and slipping cells: nothing of
superposition, memory curves or edges is used, so that the tests hold the exact routines against `solve`. Edges err by a cell; the
work errs by about the power 1.5 of cell and increment, which a second run on half the grid measures.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cholesky, solve_triangular
from scipy.linalg import solve as solve_symmetric

from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, InputError
from semi_analytic.fronts import Followed, PathLoads, remainder_of
from semi_analytic.history import check
from semi_analytic.tilted_profile import TiltedProfile

Array = NDArray[np.float64]

CELLS, INCREMENTS = 160, 320
"""Cells across the largest contact and increments a cycle; half of both tell the error."""

# Turns of an active set that are allowed: it takes about ten.
_TURNS = 200
# Share of the largest f p that rounding may leave of q beyond the limit: cells that stop to slip are there.
_ROUNDING = 1e-12
# Share of the slip of an increment that a cell makes before it is touched.
_TOUCHED = 1 / 3
# Increments of a leg of the cycle at least; each leg of the initial loading has a quarter of those of a cycle.
_OF_LEG = 4
# Share of its work by which a cycle may differ from the one before and repeat it: far below what the grid leaves.
STEADY = 1e-6
# Shares of a cell by which grids are moved, evenly, so that waves of a cell, a half and a third cancel in their mean; no two are
# mirror images under a symmetric contact.
_SHIFTS = (1 / 16, 5 / 16, 9 / 16, 13 / 16)
# Instants, out of those asked for, at which coarse grids are held against the others.
_COMPARED = 40
# Share of the largest slip of a cycle up to which a cell counts as permanently stuck.
_STAYS = 1e-3
_STATES = np.array([STICK, SLIP_FORWARD, SLIP_REVERSE])


class Fields(NamedTuple):
    """The answer at n instants and k cells.

    Attributes
    ----------
    x, step : (k,) middles of the cells; their width
    loads : (n, 4) P, Q, eps, alpha
    pressure, shear, slip : (n, k)
    state : (n, k) open, stick, forward or reverse slip
    approach, displacement : (n,) delta, U (of x = 0, with the datum length 1 in the logarithm)
    moment, shear_moment : (n,) int x p and m_q = int x q
    density : (n, k) friction work of the increment that ends there, by the trapezoidal rule
    work, loop : (n,) its sum, and Q dU - m_q d eps of the increment, also by the trapezoidal rule
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
        """Outer edges of the cells in contact, or of those that stick, at an instant; NaN where there are none."""
        return self._ends(self.state[instant] == STICK if stick else self.state[instant] != OPEN)

    def permanent_stick(self, first: int, share: float = 1e-9) -> tuple[float, float]:
        """Outer edges of the cells that stay in contact from instant `first` on and slip at most `share` of the farthest."""
        slid, stays = np.ptp(self.slip[first:], axis=0), np.all(self.state[first:] != OPEN, axis=0)
        return self._ends(stays & (slid <= share * np.max(slid)))

    def cycle_work(self, increments: int, *, loop: bool = False) -> Array:
        """Friction work, or closed integral of Q dU - m_q d eps, of the last whole cycles of so many increments."""
        values = (self.loop if loop else self.work)[1:]
        return values[len(values) % increments :].reshape(-1, increments).sum(axis=1)

    def _ends(self, cells: NDArray[np.bool_]) -> tuple[float, float]:
        here = self.x[cells]
        return (float(here[0] - self.step / 2), float(here[-1] + self.step / 2)) if len(here) else (math.nan, math.nan)


def _root(compliance: Array) -> Array:
    """M with M^T M = C^-1: C is positive definite where its cells lie within its datum length."""
    return np.asarray(solve_triangular(cholesky(compliance, lower=True), np.eye(len(compliance)), lower=True))


class Grid:
    """Two half-planes that meet in equal cells, and where they stand: nothing touches at first.

    Attributes
    ----------
    x, step : (k,) middles of the cells; their width
    """

    def __init__(
        self,
        height: Callable[[Array], Array],
        extent: tuple[float, float],
        cells: int,
        friction: float,
        modulus: float = 1.0,
        dundurs: float = 0.0,
    ) -> None:
        self.step, self.modulus, self.friction, self.dundurs = (extent[1] - extent[0]) / cells, modulus, friction, dundurs
        self.x: Array = np.asarray(extent[0] + self.step * (np.arange(cells) + 0.5))
        self._height, self._length = height(self.x), extent[1] - extent[0]
        self.datum = 2 / (math.pi * modulus) * math.log(self._length)
        self._compliance = self.compliance_at(self.x)
        self._coupling = dundurs / modulus * self.step * np.sign(self.x[:, None] - self.x)
        self._direction, self._touching = np.zeros(cells, dtype=int), np.zeros(cells, dtype=bool)
        self.without_early_slip = 0  # increments whose new cells did not slip before they were touched: `_drag`
        self._shear: Array = np.zeros(cells)
        self.slip: Array = np.zeros(cells)
        self._root = _root(self._compliance)
        self._known: dict[bytes, tuple[Array, Array, float]] = {}
        self._shift = 0.0
        self._last: dict[str, Any] | None = None
        self._pressed: dict[tuple[float, float], tuple[Array, NDArray[np.bool_], float]] = {}

    def compliance_at(self, x: Array) -> Array:
        """Displacement at points (m,) by a unit traction on each cell, (m, k); the length of the grid is the datum length."""
        ends = ((x[:, None] - self.x)[..., None] + self.step * np.array([-0.5, 0.5])) / self._length
        with np.errstate(divide="ignore", invalid="ignore"):
            primitive = np.where(ends == 0, 0.0, ends * (np.log(np.abs(ends)) - 1))
        return np.asarray(-2 * self._length / (math.pi * self.modulus) * np.diff(primitive, axis=-1)[..., 0])

    def _stiffness(self, here: NDArray[np.bool_]) -> tuple[Array, Array, float]:
        """M of the cells `here` with M^T M = C^-1, the row sums of C^-1 and their sum: t = C^-1 (right + b), and b by a total.

        Equal cells have one C wherever they lie: M of cells side by side is a corner of that of all.
        """
        cells = np.flatnonzero(here)
        key = (cells - cells[0]).tobytes()
        if key not in self._known:
            count = len(cells)
            side_by_side = cells[-1] - cells[0] + 1 == count
            root = self._root[:count, :count] if side_by_side else _root(self._compliance[np.ix_(here, here)])
            rows = root.T @ np.sum(root, axis=1)
            self._known[key] = root, rows, float(np.sum(rows))
        return self._known[key]

    def _press(self, load: float, tilt: float, lifted: Array) -> tuple[Array, NDArray[np.bool_], float]:
        """Pressure, the cells that touch and the normal approach: p > 0 where g = 0."""
        height = lifted + tilt * self.x
        touching = self._touching if self._touching.any() else height <= np.sort(height)[5]
        for _ in range(_TURNS):
            root, rows, whole = self._stiffness(touching)
            approach = (load / self.step + float(rows @ height[touching])) / whole
            p = np.zeros(len(self.x))
            p[touching] = approach * rows - root.T @ (root @ height[touching])
            wanted = np.where(touching, p > 0, height - approach + self._compliance @ p < 0)
            if np.array_equal(wanted, touching):
                break
            touching = wanted
        else:
            raise ArithmeticError("the contact area does not converge")
        if touching[0] or touching[-1]:
            raise ArithmeticError("the contact meets the end of the grid")
        return p, touching, approach

    def _drag(self, force: float, moved: Array, limit: Array, earlier: NDArray[np.bool_]) -> tuple[Array, Array, Array, float]:
        """Shear, slip, directions of slip and U: no slip where |q| < f p, once a cell is touched; `earlier` were so at first.

        Ahead of an edge that comes slip goes on as the root of the distance: a cell that is touched after a share t of the
        increment has then made 2/3 t of the way that it would have made, 1/3 in the mean over all t.
        """
        start, new = self.slip, self._touching & ~earlier
        if new.any() and earlier.any():
            try:
                start = np.where(new, start + _TOUCHED * (self._dragged(force, moved, limit, ~new, start)[1] - start), start)
            except ArithmeticError:  # more than the earlier ones can carry: the new ones start from where they were
                self.without_early_slip += 1
        return self._dragged(force, moved, limit, self._touching, start)

    def _dragged(
        self, force: float, moved: Array, limit: Array, touching: NDArray[np.bool_], start: Array
    ) -> tuple[Array, Array, Array, float]:
        """`_drag` where all of `touching` was in contact, with the slip `start`.

        q = q_0 - [G - (G 1)(G 1)^T/(1 G 1)] v, G = C^-1, with q_0 of full stick and the slip v of the increment, that of few cells.
        """
        touching = touching & self._touching
        root, rows, whole = self._stiffness(touching)
        free, most = (moved - start)[touching], limit[touching]
        shift = (force / self.step - float(rows @ free)) / whole
        stuck = root.T @ (root @ free) + shift * rows
        direction, allowed = np.zeros(len(most), dtype=int), most + _ROUNDING * limit.max()
        for _ in range(_TURNS):
            slides = np.flatnonzero(direction)
            if len(slides) == len(most):
                raise ArithmeticError("all cells slip")
            shear, v = stuck, np.zeros(len(most))
            if len(slides):
                some, fixed = root[:, slides], direction[slides] * most[slides]
                stiff = some.T @ some - np.outer(rows[slides], rows[slides] / whole)
                v[slides] = solve_symmetric(stiff, stuck[slides] - fixed, assume_a="pos", check_finite=False)
                shear = stuck - root.T @ (some @ v[slides]) + rows * (float(rows @ v) / whole)
                shear[slides] = fixed
            exceeds = (direction == 0) & (np.abs(shear) > allowed)
            wanted = np.where(exceeds, np.sign(shear), np.where(direction * v > 0, direction, 0)).astype(int)
            if np.array_equal(wanted, direction):
                break
            direction = wanted
        else:
            raise ArithmeticError("the slip zones do not converge")
        q, directions, shift = np.zeros(len(self.x)), np.zeros(len(self.x), dtype=int), shift + float(rows @ v) / whole
        q[touching], directions[touching] = shear, direction
        return q, shift + moved - self._compliance @ q, directions, shift

    def _increment(self, load: float, force: float, strain: float, tilt: float) -> dict[str, Any]:
        """One increment to P, Q, eps and alpha: a row of `Fields`."""
        cells, last = len(self.x), self._shear
        strained: Array = -strain * self.x
        p: Array
        s: Array
        if load <= 0:
            self._touching, self._direction = np.zeros(cells, dtype=bool), np.zeros(cells, dtype=int)
            p, q, s, approach, shift = np.zeros(cells), np.zeros(cells), self._shift + strained, 0.0, self._shift
        elif not self.dundurs:
            if (load, tilt) not in self._pressed:
                self._pressed[load, tilt] = self._press(load, tilt, self._height)
            earlier, (p, self._touching, approach) = self._touching, self._pressed[load, tilt]
            q, s, self._direction, shift = self._drag(force, strained, self.friction * p, earlier)
        else:  # in turn
            earlier = self._touching
            for _ in range(_TURNS):
                p, self._touching, approach = self._press(load, tilt, self._height + self._coupling @ last)
                q, s, self._direction, shift = self._drag(force, strained + self._coupling @ p, self.friction * p, earlier)
                change, last = float(np.max(np.abs(q - last))), q
                if change <= _ROUNDING * self.friction * p.max():
                    break
            else:
                raise ArithmeticError("pressure and shear by turns do not converge")
        density = (self._shear + q) * (s - self.slip) / 2
        self._shear, self.slip, self._shift = q, s, shift
        found: dict[str, Any] = {
            "loads": np.array([load, force, strain, tilt]),
            "pressure": p,
            "shear": q,
            "slip": s,
            "state": np.where(self._touching, _STATES[self._direction], OPEN).astype(np.int8),
            "approach": approach - self.datum * load,
            "displacement": shift - self.datum * force,
            "moment": self.step * float(self.x @ p),
            "shear_moment": self.step * float(self.x @ q),
            "density": density,
            "work": self.step * float(np.sum(density)),
        }
        before = self._last or found
        turned = (found["shear_moment"] + before["shear_moment"]) / 2 * (strain - before["loads"][2])
        found["loop"] = (force + before["loads"][1]) / 2 * (found["displacement"] - before["displacement"]) - turned
        self._last = found
        return found

    def follow(self, loads: Array) -> Fields:
        """Increments to rows of P, Q, eps and alpha, (n, 4).

        Raises ArithmeticError where active sets do not converge, all cells slip, or the contact meets the end of the grid.
        """
        rows = []
        for row in loads.tolist():
            try:
                rows.append(self._increment(*row))
            except ArithmeticError as fault:
                raise ArithmeticError(f"{fault} at P = {row[0]:.6g}, Q = {row[1]:.6g}") from fault
        return Fields(self.x, self.step, **{name: np.array([row[name] for row in rows]) for name in rows[0]})


def solve(
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

    The first instant is one increment from nothing; where P = 0 there, its eps is in place at first touch. `extent` is the grid.
    Raises ArithmeticError as `Grid.follow`.

    >>> found = solve(lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0])  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(found.edges(0)[1] - (1.6 / math.pi) ** 0.5) < found.step
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    return Grid(height, extent, cells, friction, modulus, dundurs).follow(loads)


# ------------------------------------------------------------------------------------------------------ a scene's load path
@dataclass(frozen=True, eq=False)
class _Path:
    """A load path in increments; the tilt of a moment is that of `contact`."""

    loads: PathLoads
    contact: TiltedProfile
    increments: int
    _known: dict[bytes, Array] = field(default_factory=dict)

    def rows(self, number: int, asked: Array) -> tuple[Array, Array, NDArray[np.intp]]:
        """Of a cycle (-1: before): P, Q, eps, alpha at its instants (n, 4), rows of those `asked` for, and which they are."""
        path, first = self.loads.path, self.loads.path.initial_loading[0]
        whole = path.cycle or path.initial_loading
        length, own = whole[-1].end - whole[0].start, asked - max(number, 0) * (path.period or 0.0)
        legs, times = path.initial_loading if number < 0 else path.cycle, []
        for k, leg in enumerate(legs):
            least = self.increments // 4 if number < 0 and (path.cycle or not k) else _OF_LEG
            share = 0.0 if number < 0 and path.cycle else (leg.end - leg.start) / length
            # From first touch in equal steps of the contact's size.
            places = np.linspace(0, 1, max(least, math.ceil(self.increments * share)) + 1)[1:] ** (2 if leg is first else 1)
            base, turns = leg.start + (leg.end - leg.start) * places, self.loads.turns(leg)
            # Increments of its own make way for instants that are asked for, but where a load turns round.
            new = own[(own > leg.start) & (own <= leg.end)]
            new = np.append(new, path.start) if leg is first and np.any(own <= path.start) else new
            near = np.min(np.abs(base[:, None] - new), axis=1, initial=math.inf) < 0.5 * (leg.end - leg.start) / len(base)
            new = new[np.min(np.abs(new[:, None] - turns), axis=1, initial=math.inf) > 2e-9 * (leg.end - leg.start)]
            times.append(np.unique(np.concatenate([base[~near], turns, new])))
            if (key := times[-1].tobytes()) not in self._known:
                rows = self.loads.values(times[-1])
                if path.moment_given and self.contact.shape.radius is None:
                    rows[3] = self.contact.tilt_under(rows[0], -rows[3] * self.loads.radius * rows[0])
                self._known[key] = rows.T
        time = np.concatenate(times)
        here = np.flatnonzero((own <= legs[-1].end) & ((own > legs[0].start) | (number < 0)))
        nearest = np.array([np.argmin(np.abs(time - max(at, path.start))) for at in own[here]], dtype=int)
        return np.concatenate([self._known[each.tobytes()] for each in times]), nearest, here


def _run(grid: Grid, path: _Path, x: Array, asked: Array, least: int, most: int) -> dict[str, Any]:
    """What one grid answers, followed until a cycle repeats the one before, `least` cycles at any rate.

    At n instants and m points, by the names of `Followed`; `share` is q over f p, `works` that of the cycles, and `work`, `loop`,
    `density`, `permanent` those of the last; `pieces` is the largest number of zones that stick,
    `without_early_slip` how often cells that were touched in an increment did not slip before.
    """
    n, m, half, kernel, works = len(asked), len(x), grid.step / 2, grid.compliance_at(x), list[float]()
    out: dict[str, Any] = {name: np.zeros((n, m)) for name in ("share", "slip")} | {"stick_edges": np.full((n, 2), np.nan)}
    out |= {name: np.zeros(n) for name in ("displacement", "shear_moment")} | {"loads": np.zeros((4, n)), "pieces": 1}
    for number in range(-1, most if path.loads.path.cycle else 0):
        rows, wanted, here = path.rows(number, asked)
        before = grid.slip
        try:
            found = grid.follow(rows)
        except ArithmeticError as fault:
            raise InputError(
                f"load: half-plane theory takes grids for such bulk stress or tilt, and {fault} of cycle {number + 1}; "
                "finite elements may take the scene"
            ) from fault
        out["loads"][:, here], out["displacement"][here] = found.loads[wanted].T, found.displacement[wanted]
        out["shear_moment"][here] = found.shear_moment[wanted]
        for i, k in zip(here.tolist(), wanted.tolist(), strict=True):
            _, force, strain, _ = found.loads[k]
            out["slip"][i] = found.displacement[k] + grid.datum * force - strain * x - kernel @ found.shear[k]
            touching = np.flatnonzero(found.state[k] != OPEN)
            runs = np.flatnonzero(np.diff(np.concatenate([[False], found.state[k] == STICK, [False]]).astype(int)))
            if len(touching):
                share = found.shear[k, touching] / (grid.friction * found.pressure[k, touching])
                out["share"][i] = np.interp(x, grid.x[touching], share)
                out["pieces"] = max(out["pieces"], len(runs) // 2)
            if len(runs):
                # A cell that sticks at the edge of contact sticks up to it.
                low = -np.inf if runs[0] == touching[0] else grid.x[runs[0]] - half
                high = np.inf if runs[-1] - 1 == touching[-1] else grid.x[runs[-1] - 1] + half
                out["stick_edges"][i] = low, high
        if number >= 0 or not path.loads.path.cycle:
            works.append(float(np.sum(found.work)))
        if len(works) >= max(least, 2) and abs(works[-1] - works[-2]) <= STEADY * works[-1]:
            break
    slips = np.abs(np.diff(found.slip, axis=0, prepend=before[None]))
    # What opens does not stick: it counts as slip without end.
    slid = np.sum(np.where(found.state == OPEN, np.inf, slips), axis=0)
    stays = grid.x[slid <= _STAYS * float(np.max(slid, where=np.isfinite(slid), initial=0.0))]
    return out | {
        "without_early_slip": grid.without_early_slip,
        "works": np.array(works),
        "work": works[-1],
        "loop": float(np.sum(found.loop)),
        "density": np.interp(x, grid.x, np.sum(found.density, axis=0), left=0.0, right=0.0),
        "permanent": np.array([stays[0] - half, stays[-1] + half]) if len(stays) else np.full(2, np.nan),
    }


def edges_along(loads: PathLoads, contact: TiltedProfile) -> Array:
    """Edges of contact at instants of the initial loading and of a cycle, (n, 2)."""
    cut = _Path(loads, contact, INCREMENTS)
    rows = np.concatenate([cut.rows(number, np.zeros(0))[0] for number in ((-1, 0) if loads.path.cycle else (-1,))])
    pressed = rows[rows[:, 0] > 0]
    middle, half = contact.under(pressed[:, 0], pressed[:, 3])
    return np.stack([middle - half, middle + half], axis=-1)


def follow_on_grid(
    loads: PathLoads,
    contact: TiltedProfile,
    height: Callable[[Array], Array],
    friction: float,
    x: Array,
    time: Array | None = None,
    *,
    cycles: int = 1,
    most: int = 12,
    cells: int = CELLS,
    increments: int = INCREMENTS,
) -> Followed:
    """Follow a load path with bulk stress and tilt from first touch, cycle by cycle until it is steady to 1e-6 of its work.

    Pressure and contact edges are those of `contact`, exact. All else is the mean over grids that are moved by shares of a cell.
    Errors are twice their spread and what grids of half as many cells and increments change, of fields in the root mean square:
    next to an edge of stick q errs by the root of a cell.

    Parameters
    ----------
    loads : P, Q, eps and alpha of the path
    contact : the profile under load and tilt; its path is within its `intervals.most`
    height : h(x)
    friction, x, time, cycles, most : as `fronts.follow`; `time` None gives every second increment
    cells, increments : across the largest contact, a cycle

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
    needed = cycles
    if period is not None and time is not None and len(time):
        needed = max(cycles, math.ceil((float(np.max(time)) - path.cycle_start) / period - 1e-9))
    coarse, fine = (_Path(loads, contact, count) for count in (increments // 2, increments))
    edges = edges_along(loads, contact)
    low, high = float(np.min(edges)), float(np.max(edges))
    modulus = 2 / contact.intervals.product

    def run(cut: _Path, cells: int, shift: float, least: int, most: int, asked: Array) -> dict[str, Any]:
        cell = (high - low) / cells
        extent = low - (2 + shift) * cell, high + (3 - shift) * cell
        return _run(Grid(height, extent, cells + 5, friction, modulus), cut, x, asked, least, most)

    # The coarse grids are the cheap ones: they tell how many cycles it takes.
    none = np.zeros(0)
    count = len(run(coarse, cells // 2, 0.0, needed, max(most, needed), none)["works"])
    if time is not None:
        asked = np.asarray(time, dtype=float)
    else:
        legs = [np.linspace(leg.start, leg.end, increments // 16 + 1) for leg in path.initial_loading]
        if period is not None:
            legs.append(np.linspace(path.cycle_start, path.cycle_start + count * period, count * (increments // 2) + 1))
        asked = np.unique(np.concatenate(legs))
    every = max(len(asked) // _COMPARED, 1)
    own = [run(fine, cells, shift, count, count, asked) for shift in _SHIFTS]
    rough = [run(coarse, cells // 2, shift, count, count, asked[::every]) for shift in _SHIFTS]

    def mean(name: str) -> Array:
        return np.asarray(np.mean([each[name] for each in own], axis=0))

    def error(name: str, factor: Array | float = 1.0, every: int = 1) -> float:
        """Twice the standard deviation between grids and what the coarse ones change, over the largest value; root mean squares."""
        fine_ones = factor * np.array([np.atleast_1d(each[name])[::every] for each in own])
        coarse_ones = factor * np.array([np.atleast_1d(each[name]) for each in rough])
        size = float(np.max(np.abs(fine_ones), initial=0.0))
        changed = np.mean(fine_ones, axis=0) - np.mean(coarse_ones, axis=0)
        return float(2 * np.sqrt(np.mean(np.var(fine_ones, axis=0))) + np.sqrt(np.mean(changed**2))) / size if size > 0 else 0.0

    given = own[0]["loads"]
    middle, half = contact.under(given[0], given[3])
    contact_edges = np.stack([middle - half, middle + half], axis=-1)
    pressure = contact.pressure_over(x, middle, half)
    touching = (x >= contact_edges[:, :1]) & (x <= contact_edges[:, 1:])
    share, works = np.where(touching, mean("share"), 0.0), mean("works")
    state = np.where(touching, np.where(np.abs(share) < 1 - 1e-12, STICK, np.where(share > 0, SLIP_FORWARD, SLIP_REVERSE)), OPEN)
    changes = np.abs(np.diff(works)) <= STEADY * works[1:]
    steady = int(np.flatnonzero(changes)[0]) + 1 if np.any(changes) else None
    return Followed(
        time=asked,
        loads=given,
        moment=contact.moment(middle, half, given[0], given[3]),
        shear_moment=mean("shear_moment"),
        displacement=mean("displacement"),
        contact_edges=contact_edges,
        stick_edges=np.clip(mean("stick_edges"), contact_edges[:, :1], contact_edges[:, 1:]),
        pressure=pressure,
        shear=friction * pressure * share,
        slip=mean("slip"),
        state=state.astype(np.int8),
        works=works,
        loop=float(np.mean([each["loop"] for each in own])),
        remainder=remainder_of(works.tolist()),
        steady_from=steady,
        steady_to=STEADY,
        density=mean("density"),
        permanent_stick_edges=mean("permanent"),
        counts={
            "grids": 2 * len(_SHIFTS),
            "cells": cells,
            "increments": increments * count,
            "pieces": max(each["pieces"] for each in own),
        }
        | ({"increments without early slip": early} if (early := sum(each["without_early_slip"] for each in own)) else {}),
        errors={
            "dissipation": error("work"),
            "dissipation_density": error("density"),
            "shear": error("share", friction * pressure[::every], every),
            "slip": error("slip", 1.0, every),
        },
    )
