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

from scenes import OPEN, SLIP_FORWARD, SLIP_REVERSE, STICK, InputError, LoadPath
from semi_analytic.bulk_and_tilt import PathLoads
from semi_analytic.history import check
from semi_analytic.tilted_profile import TiltedProfile

Array = NDArray[np.float64]

CELLS, INCREMENTS = 160, 320
"""Cells across the largest contact and increments a cycle; half of both tell the error."""

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
_SHIFTS, _GROUPS = (np.arange(16) + 0.25) / 16, 4
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
        """Outer edges of the cells in contact, or of those that stick, at an instant; NaN where
        there are none.
        """
        return self._ends(self.state[instant] == STICK if stick else self.state[instant] != OPEN)

    def permanent_stick(self, first: int, share: float = 1e-9) -> tuple[float, float]:
        """Outer edges of the cells that stay in contact from instant `first` on and slip at most
        `share` of the farthest.
        """
        slid, stays = np.ptp(self.slip[first:], axis=0), np.all(self.state[first:] != OPEN, axis=0)
        return self._ends(stays & (slid <= share * np.max(slid)))

    def cycle_work(self, increments: int, *, loop: bool = False) -> Array:
        """Friction work, or closed integral of Q dU - m_q d eps, of the last whole cycles of so
        many increments.
        """
        values = (self.loop if loop else self.work)[1:]
        return values[len(values) % increments :].reshape(-1, increments).sum(axis=1)

    def _ends(self, cells: NDArray[np.bool_]) -> tuple[float, float]:
        here = self.x[cells]
        return (
            (float(here[0] - self.step / 2), float(here[-1] + self.step / 2))
            if len(here)
            else (math.nan, math.nan)
        )


@dataclass(frozen=True, eq=False)
class Zone:
    """Cells side by side that are in contact: `root` M with M^T M = C^-1, the row sums of C^-1 and
    their sum.
    """

    root: Array
    rows: Array
    whole: float

    @cached_property
    def stiffness(self) -> Array:
        """G = C^-1 less what a shift of all cells does: t = total rows/whole + G b has C t = b +
        const and the sum `total`.
        """
        return np.asarray(self.root.T @ self.root - np.outer(self.rows, self.rows / self.whole))


class Grid:
    """Two half-planes that meet in equal cells, and where they stand: nothing touches at first.

    Several grids of the same cells, moved by shares of a cell, are followed side by side: their
    matrices are the same.

    Attributes
    ----------
    x, step : (g, k) middles of the cells of g grids; their width
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
        self.alone, self._length, self.cells = (
            np.ndim(extent) == 1,
            float(ends[0, 1] - ends[0, 0]),
            cells,
        )
        self.step, self.modulus, self.friction, self.dundurs = (
            self._length / cells,
            modulus,
            friction,
            dundurs,
        )
        self.x: Array = ends[:, :1] + self.step * (np.arange(cells) + 0.5)
        self._height, self._numbers = height(self.x), np.arange(cells)
        self.datum = 2 / (math.pi * modulus) * math.log(self._length)
        self._compliance = self.compliance_at(self.x[0], 0)
        self._coupling = (
            dundurs / modulus * self.step * np.sign(self._numbers[:, None] - self._numbers)
        )
        self._begin, self._count = np.zeros((2, len(self.x)), dtype=int)  # of the cells in contact
        # increments whose new cells did not slip before they were touched: `_drag`
        self.without_early_slip = 0
        self._shear: Array = np.zeros(self.x.shape)
        self.slip: Array = np.zeros(self.x.shape)
        self._root: Array = scipy.linalg.solve_triangular(
            scipy.linalg.cholesky(self._compliance, lower=True), np.eye(cells), lower=True
        )
        self._zones: dict[int, Zone] = {}
        self._shift: Array = np.zeros(len(self.x))
        self._strain = 0.0
        self._directions: NDArray[np.intp] = np.zeros(self.x.shape, dtype=int)
        self._last: dict[str, Any] | None = None
        self._pressed: dict[tuple[float, float], tuple[Array, Array, Array, Array]] = {}

    def compliance_at(self, x: Array, number: int) -> Array:
        """Displacement at points (m,) by a unit traction on each cell of a grid, (m, k); the grid's
        length is the datum length.
        """
        ends = (
            (x[:, None] - self.x[number])[..., None] + self.step * np.array([-0.5, 0.5])
        ) / self._length
        with np.errstate(divide="ignore", invalid="ignore"):
            primitive = np.where(ends == 0, 0.0, ends * (np.log(np.abs(ends)) - 1))
        return np.asarray(
            -2 * self._length / (math.pi * self.modulus) * np.diff(primitive, axis=-1)[..., 0]
        )

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

    def _inside(self, begin: Array, count: Array) -> NDArray[np.bool_]:
        """Which cells are among the `count` (g,) from `begin` (g,) on: (g, k)."""
        return (self._numbers >= begin[:, None]) & (self._numbers < (begin + count)[:, None])

    def _press(self, load: float, tilt: float, lifted: Array) -> tuple[Array, Array, Array, Array]:
        """Pressure, first cell in contact, how many there are, and the normal approach of each
        grid: p > 0 where g = 0.
        """
        height = lifted + tilt * self.x
        begin, count = self._begin.copy(), self._count.copy()
        if not count.all():
            begin, count = np.argmin(height, axis=1) - 2, np.full(len(begin), 5)
        for _ in range(_TURNS):
            p, approach = np.zeros(height.shape), np.zeros(len(height))
            for cells in np.unique(count).tolist():
                zone, grids = self._zone(cells), np.flatnonzero(count == cells)
                here = grids[:, None], begin[grids, None] + np.arange(cells)
                approach[grids] = (load / self.step + height[here] @ zone.rows) / zone.whole
                p[here] = (
                    approach[grids, None] * zone.rows - (height[here] @ zone.root.T) @ zone.root
                )
            inside = self._inside(begin, count)
            wanted = np.where(inside, p > 0, height - approach[:, None] + p @ self._compliance < 0)
            first = np.argmax(wanted, axis=1)
            many = self.cells - np.argmax(wanted[:, ::-1], axis=1) - first
            if np.array_equal(wanted, inside):
                break
            begin, count = first, many
        else:
            raise ArithmeticError("the contact area does not converge")
        if np.any(begin == 0) or np.any(begin + count == self.cells):
            raise ArithmeticError("the contact meets the end of the grid")
        return p, begin, count, approach

    def _drag(
        self, force: float, moved: Array, limit: Array, earlier: tuple[Array, Array]
    ) -> tuple[Array, Array, Array, Array]:
        """Shear, slip, directions of slip and U: no slip where |q| < f p, once a cell is touched;
        `earlier` were so at first.

        Ahead of an edge that comes slip goes on as the root of the distance: a cell that is touched
        after a share t of the increment has then made 2/3 t of the way that it would have made, 1/3
        in the mean over all t.
        """
        begin, end = self._begin, self._begin + self._count
        first, last = np.maximum(begin, earlier[0]), np.minimum(end, earlier[0] + earlier[1])
        start, grown = self.slip, np.flatnonzero((last > first) & ((first > begin) | (last < end)))
        start, left = start.copy(), [grown] if len(grown) else []
        while left:
            grids = left.pop()
            try:
                early = self._dragged(force, moved, limit, first, last - first, start, grids)[1]
            except (
                ArithmeticError
            ):  # more than the earlier ones can carry: the new ones start from where they were
                if len(grids) > 1:
                    left += np.split(grids, len(grids))
                else:
                    self.without_early_slip += 1
                continue
            new = (
                self._inside(begin, self._count)[grids] & ~self._inside(first, last - first)[grids]
            )
            start[grids] += np.where(new, _TOUCHED * (early - start[grids]), 0.0)
        return self._dragged(force, moved, limit, begin, self._count, start, np.arange(len(self.x)))

    def _dragged(
        self,
        force: float,
        moved: Array,
        limit: Array,
        begin: Array,
        count: Array,
        start: Array,
        some: NDArray[np.intp],
    ) -> tuple[Array, Array, Array, Array]:
        """`_drag` of some grids where `count` cells from `begin` on are in contact, with the slip
        `start`.

        q = q_0 - G v with q_0 of full stick and the slip v of the increment, that of few cells.
        Where grids have fewer cells in contact than others, open ones beside them slip without
        friction.
        """
        contact = self._inside(begin, count)[some]
        cells, every = int(count[some].max()), np.arange(len(some))[:, None]
        zone, here = (
            self._zone(cells),
            np.minimum(begin[some], self.cells - cells)[:, None] + np.arange(cells),
        )
        free, touching = (moved - start)[some[:, None], here], contact[every, here]
        most, allowed = np.where(touching, limit[some[:, None], here], 0.0), _ROUNDING * limit.max()
        stuck = force / self.step / zone.whole * zone.rows + free @ zone.stiffness
        # Most cells go on as in the increment before: the first guess, unless it leaves none that
        # stick.
        direction = np.where(touching, self._directions[some[:, None], here], 0)
        direction[np.all((direction != 0) | ~touching, axis=1)] = 0
        for _ in range(_TURNS):
            slides = (direction != 0) | ~touching
            number = np.sum(slides, axis=1)
            if np.any(number == cells):
                raise ArithmeticError("all cells slip")
            fixed, v, shear = direction * most, np.zeros(most.shape), stuck
            if np.any(number):
                # The cells that slip first, as many as of the grid with most of them: what is too
                # much has the matrix 1.
                order = np.argsort(~slides, axis=1, kind="stable")[:, : number.max()]
                real = np.take_along_axis(slides, order, axis=1)
                stiff = zone.stiffness.ravel().take(order[:, :, None] * cells + order[:, None, :])
                if not real.all():
                    stiff *= real[:, :, None] & real[:, None, :]
                    stiff[:, np.arange(order.shape[1]), np.arange(order.shape[1])] += ~real
                right = np.where(real, np.take_along_axis(stuck - fixed, order, axis=1), 0.0)
                np.put_along_axis(
                    v, order, np.linalg.solve(stiff, right[..., None])[..., 0], axis=1
                )
                shear = np.where(slides, fixed, stuck - v @ zone.stiffness)
            exceeds = ~slides & (np.abs(shear) > most + allowed)
            wanted = np.where(
                exceeds, np.sign(shear), np.where(direction * v > 0, direction, 0)
            ).astype(int)
            if np.array_equal(wanted, direction):
                break
            direction = wanted
        else:
            raise ArithmeticError("the slip zones do not converge")
        q, directions = np.zeros(contact.shape), np.zeros(contact.shape, dtype=int)
        q[every, here], directions[every, here] = shear, direction
        shift = (force / self.step + (v - free) @ zone.rows) / zone.whole
        return q, shift[:, None] + moved[some] - q @ self._compliance, directions, shift

    def _increment(self, load: float, force: float, strain: float, tilt: float) -> dict[str, Any]:
        """One increment to P, Q, eps and alpha: a row of `Fields`."""
        last = self._shear
        strained: Array = -strain * self.x
        p: Array
        s: Array
        shift: Array
        if load <= 0:
            self._count, directions = (
                np.zeros(len(self.x), dtype=int),
                np.zeros(self.x.shape, dtype=int),
            )
            p, q, approach, shift = (
                np.zeros(self.x.shape),
                np.zeros(self.x.shape),
                np.zeros(len(self.x)),
                self._shift,
            )
            s = shift[:, None] + strained
        elif not self.dundurs:
            if (load, tilt) not in self._pressed:
                self._pressed[load, tilt] = self._press(load, tilt, self._height)
            earlier, (p, self._begin, self._count, approach) = (
                (
                    self._begin,
                    self._count,
                ),
                self._pressed[load, tilt],
            )
            q, s, directions, shift = self._drag(force, strained, self.friction * p, earlier)
        else:  # in turn
            earlier = self._begin, self._count
            for _ in range(_TURNS):
                p, self._begin, self._count, approach = self._press(
                    load, tilt, self._height + last @ self._coupling.T
                )
                q, s, directions, shift = self._drag(
                    force, strained + p @ self._coupling.T, self.friction * p, earlier
                )
                change, last = float(np.max(np.abs(q - last))), q
                if change <= _ROUNDING * self.friction * p.max():
                    break
            else:
                raise ArithmeticError("pressure and shear by turns do not converge")
        inside = self._inside(self._begin, self._count)
        density = (self._shear + q) * (s - self.slip) / 2
        self._shear, self.slip, self._shift, self._strain = q, s, shift, strain
        self._directions = directions
        found: dict[str, Any] = {
            "loads": np.array([load, force, strain, tilt]),
            "pressure": p,
            "shear": q,
            "slip": s,
            "state": np.where(inside, _STATES[directions], OPEN).astype(np.int8),
            "approach": approach - self.datum * load,
            "displacement": shift - self.datum * force,
            "moment": self.step * np.sum(self.x * p, axis=1),
            "shear_moment": self.step * np.sum(self.x * q, axis=1),
            "density": density,
            "work": self.step * np.sum(density, axis=1),
        }
        before = self._last or found
        turned = (
            (found["shear_moment"] + before["shear_moment"]) / 2 * (strain - before["loads"][2])
        )
        found["loop"] = (force + before["loads"][1]) / 2 * (
            found["displacement"] - before["displacement"]
        ) - turned
        self._last = found
        return found

    def slip_field(self) -> Callable[[Array], Array]:
        """Mean slip of the grids as they stand, as a function of points (m,), in contact and
        outside.
        """
        shear, shift, strain = self._shear, float(np.mean(self._shift)), self._strain

        def slip(x: Array) -> Array:
            moved = [self.compliance_at(x, number) @ row for number, row in enumerate(shear)]
            return np.asarray(shift - strain * x - np.mean(moved, axis=0))

        return slip

    def resume(self, slip: Callable[[Array], Array], loads: Array) -> None:
        """Stand under P, Q, eps and alpha (4,) with a slip known from another grid, as far as
        friction holds it.
        """
        load, force, strain, tilt = loads.tolist()
        self.slip = np.stack([slip(x) for x in self.x])
        _, self._begin, self._count, _ = self._press(load, tilt, self._height)
        self._increment(load, force, strain, tilt)

    def follow(self, loads: Array) -> Fields:
        """Increments to rows of P, Q, eps and alpha, (n, 4).

        Raises ArithmeticError where active sets do not converge, all cells slip, or the contact
        meets the end of the grid.
        """
        rows = []
        for row in loads.tolist():
            try:
                rows.append(self._increment(*row))
            except ArithmeticError as fault:
                raise ArithmeticError(f"{fault} at P = {row[0]:.6g}, Q = {row[1]:.6g}") from fault
        found = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        if self.alone:
            found = {
                name: values if name == "loads" else values[:, 0] for name, values in found.items()
            }
        return Fields(self.x[0] if self.alone else self.x, self.step, **found)


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

    The first instant is one increment from nothing; where P = 0 there, its eps is in place at first
    touch. `extent` is the grid. Raises ArithmeticError as `Grid.follow`.

    >>> found = solve(
    ...     lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0]
    ... )  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(found.edges(0)[1] - (1.6 / math.pi) ** 0.5) < found.step
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    return Grid(height, extent, cells, friction, modulus, dundurs).follow(loads)


# ------------------------------------------------------------------------------ a scene's load path
@dataclass(frozen=True, eq=False)
class _Path:
    """A load path in increments."""

    loads: PathLoads
    increments: int
    _known: dict[bytes, Array] = field(default_factory=dict)

    def rows(self, number: int, asked: Array) -> tuple[Array, Array, NDArray[np.intp]]:
        """Of a cycle (-1: before): P, Q, eps, alpha at its instants (n, 4), rows of those `asked`
        for, and which they are.
        """
        path, first = self.loads.path, self.loads.path.initial_loading[0]
        whole = path.cycle or path.initial_loading
        length, own = whole[-1].end - whole[0].start, asked - max(number, 0) * (path.period or 0.0)
        legs, times = path.initial_loading if number < 0 else path.cycle, []
        for k, leg in enumerate(legs):
            least = self.increments // 4 if number < 0 and (path.cycle or not k) else _OF_LEG
            share = 0.0 if number < 0 and path.cycle else (leg.end - leg.start) / length
            # From first touch in equal steps of the contact's size.
            places = np.linspace(0, 1, max(least, math.ceil(self.increments * share)) + 1)[1:] ** (
                2 if leg is first else 1
            )
            base, turns = leg.start + (leg.end - leg.start) * places, self.loads.turns(leg)
            # Increments of its own make way for instants that are asked for, but where a load turns
            # round.
            new = own[(own > leg.start) & (own <= leg.end)]
            new = np.append(new, path.start) if leg is first and np.any(own <= path.start) else new
            near = np.min(np.abs(base[:, None] - new), axis=1, initial=math.inf) < 0.5 * (
                leg.end - leg.start
            ) / len(base)
            new = new[
                np.min(np.abs(new[:, None] - turns), axis=1, initial=math.inf)
                > 2e-9 * (leg.end - leg.start)
            ]
            times.append(np.unique(np.concatenate([base[~near], turns, new])))
            if (key := times[-1].tobytes()) not in self._known:
                self._known[key] = self.loads.values(times[-1]).T
        time = np.concatenate(times)
        here = np.flatnonzero((own <= legs[-1].end) & ((own > legs[0].start) | (number < 0)))
        nearest = np.array(
            [np.argmin(np.abs(time - max(at, path.start))) for at in own[here]], dtype=int
        )
        return np.concatenate([self._known[each.tobytes()] for each in times]), nearest, here


def _run(
    grid: Grid, path: _Path, x: Array, asked: Array, numbers: range, least: int, every: int = 1
) -> dict[str, Any]:
    """What grids answer along cycles (-1: the initial loading) until one repeats the one before,
    `least` cycles at any rate.

    By the names of `Followed`. With the grids as first axis: `works` of the cycles (g, c), `work`,
    `loop` and `density` of the last, and `share each`, `slip each` at every so many instants. As
    means over them at n instants and m points: all else; `share` is q over f p, and `pieces` the
    largest number of zones that stick. `begins` are the mean slips, as functions of x, where each
    cycle begins.
    """
    n, m, g, half, works = len(asked), len(x), len(grid.x), grid.step / 2, list[Array]()
    out: dict[str, Any] = {name: np.zeros((n, m)) for name in ("share", "slip")} | {
        "stick_edges": np.full((n, 2), np.nan)
    }
    out |= {f"{name} each": np.zeros((g, -(-n // every), m)) for name in ("share", "slip")} | {
        "loads": np.zeros((4, n)),
        "pieces": 1,
        "begins": [],
        "increments": 0,
    }
    out |= {name: np.zeros(n) for name in ("displacement", "shear_moment")}
    kernels = np.array([grid.compliance_at(x, k) for k in range(g)]) if n else np.zeros(0)
    for number in numbers:
        if number >= 0:
            out["begins"].append(grid.slip_field())
        rows, wanted, here = path.rows(number, asked)
        before = grid.slip
        try:
            found = grid.follow(rows)
        except ArithmeticError as fault:
            raise InputError(
                f"load: half-plane theory takes grids for such bulk stress or tilt, and {fault} of"
                f" cycle {number + 1}; finite elements may take the scene"
            ) from fault
        out["increments"] += len(rows)
        out["loads"][:, here] = found.loads[wanted].T
        for name in ("displacement", "shear_moment"):
            out[name][here] = np.mean(getattr(found, name)[wanted], axis=1)
        for i, k in zip(here.tolist(), wanted.tolist(), strict=True):
            _, force, strain, _ = found.loads[k]
            shift, share, ends = (
                found.displacement[k] + grid.datum * force,
                np.zeros((g, m)),
                np.full((g, 2), np.nan),
            )
            slip = (
                shift[:, None] - strain * x - np.matmul(kernels, found.shear[k][..., None])[..., 0]
            )
            for j, state in enumerate(found.state[k]):
                touching = np.flatnonzero(state != OPEN)
                runs = np.flatnonzero(
                    np.diff(np.concatenate([[False], state == STICK, [False]]).astype(int))
                )
                if len(touching):
                    limit = grid.friction * found.pressure[k, j, touching]
                    share[j] = np.interp(
                        x, grid.x[j, touching], found.shear[k, j, touching] / limit
                    )
                    out["pieces"] = max(out["pieces"], len(runs) // 2)
                if len(runs):
                    # A cell that sticks at the edge of contact sticks up to it.
                    low = -np.inf if runs[0] == touching[0] else grid.x[j, runs[0]] - half
                    high = (
                        np.inf if runs[-1] - 1 == touching[-1] else grid.x[j, runs[-1] - 1] + half
                    )
                    ends[j] = low, high
            out["share"][i], out["slip"][i], out["stick_edges"][i] = (
                np.mean(each, axis=0) for each in (share, slip, ends)
            )
            if i % every == 0:
                out["share each"][:, i // every], out["slip each"][:, i // every] = share, slip
        if number >= 0 or not path.loads.path.cycle:
            works.append(np.sum(found.work, axis=0))
        if len(works) >= max(least, 2) and abs(np.mean(works[-1] - works[-2])) <= STEADY * np.mean(
            works[-1]
        ):
            break
    slips = np.abs(np.diff(found.slip, axis=0, prepend=before[None]))
    # What opens does not stick: it counts as slip without end.
    slid = np.sum(np.where(found.state == OPEN, np.inf, slips), axis=0)
    density, stays = (
        np.sum(found.density, axis=0),
        slid <= _STAYS * np.max(slid, axis=1, where=np.isfinite(slid), initial=0.0)[:, None],
    )
    ends = np.array(
        [
            [np.min(own), np.max(own)] if len(own := each[some]) else [np.nan] * 2
            for each, some in zip(grid.x, stays, strict=True)
        ]
    )
    return out | {
        "works": np.array(works).T,
        "work": works[-1],
        "loop": np.sum(found.loop, axis=0),
        "density": density,
        "permanent": np.mean(ends + half * np.array([-1, 1]), axis=0),
    }


def edges_along(loads: PathLoads, contact: TiltedProfile) -> Array:
    """Edges of contact at instants of the initial loading and of a cycle, (n, 2)."""
    cut = _Path(loads, INCREMENTS)
    rows = np.concatenate(
        [cut.rows(number, np.zeros(0))[0] for number in ((-1, 0) if loads.path.cycle else (-1,))]
    )
    pressed = rows[rows[:, 0] > 0]
    middle, half = contact.under(pressed[:, 0], pressed[:, 3])
    return np.stack([middle - half, middle + half], axis=-1)


@dataclass(frozen=True, eq=False)
class Followed:
    """What was followed, n instants and k points; edges (n, 2), fields (n, k).

    Attributes
    ----------
    loads : (4, n) P, Q, eps and alpha
    moment, shear_moment : (n,) int x p and m_q = int x q
    displacement : (n,) U of x = 0, with the datum length 1 in the logarithm
    contact_edges, stick_edges : (n, 2)
    pressure, shear, slip, state : (n, k), as in a ContactSolution
    works : friction work of each cycle that was followed; of the whole path where none repeats
    loop : closed integral of Q dU - m_q d eps of the last
    remainder : estimate of what the work of the last cycle still is from the steady one
    steady_from, steady_to : index of the first cycle that repeats the one before to this share of
    W, None if none does density : (k,) friction work at the points, of the last cycle
    permanent_stick_edges : (2,) of the last cycle; NaN where none
    counts : grids, cells, increments, zones that stick
    errors : relative, of dissipation, dissipation_density, shear and slip, as in a Record
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
    return next(
        (k for k in range(1, len(works)) if abs(works[k] - works[k - 1]) <= share * works[k]), None
    )


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
    if len(changes) < 2 or changes[-1] == 0:
        return float(changes[-1]) if len(changes) else math.inf
    before, ratio = np.append(1.0, changes[1:] / np.maximum(changes[:-1], np.finfo(float).tiny))[
        -2:
    ].tolist()
    if ratio < 0.5 and 0.8 * before < ratio < 1.05 * before:
        return float(changes[-1]) * ratio / (1 - ratio)
    return float(changes[-1]) * max(len(works) / 3, min(ratio, 0.9) / (1 - min(ratio, 0.9)))


def follow_on_grid(
    loads: PathLoads,
    contact: TiltedProfile,
    height: Callable[[Array], Array],
    friction: float,
    x: Array,
    time: Array | None = None,
    *,
    most: int = 12,
    steady: bool = False,
    pointwise: bool = True,
    cells: int = CELLS,
    increments: int = INCREMENTS,
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
    loads : P, Q, eps and alpha of the path
    contact : the profile under load and tilt; its path is within its `intervals.most`
    height : h(x)
    friction : f
    x : (k,) points
    time : (n,) instants in any order; every second increment if None
    most : largest number of cycles
    steady : whether the last cycle alone is wanted, without q and s; of `works` all but the last
    are then of coarse grids pointwise : whether q, s and the state are wanted at points; NaN and
    open otherwise
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
    needed = cycles_needed(path, time)
    coarse, fine = (_Path(loads, count) for count in (increments // 2, increments))
    edges = edges_along(loads, contact)
    low, high = float(np.min(edges)), float(np.max(edges))
    modulus = 2 / contact.intervals.product

    def grids(cells: int, shifts: Array) -> Grid:
        cell = (high - low) / cells
        extents = np.stack([low - (2 + shifts) * cell, high + (3 - shifts) * cell], axis=1)
        return Grid(height, extents, cells + 5, friction, modulus)

    def run(
        cut: _Path, grid: Grid, asked: Array, numbers: range, least: int, every: int = 1
    ) -> dict[str, Any]:
        out = _run(grid, cut, x if pointwise else np.zeros(0), asked, numbers, least, every)
        rows = zip(grid.x, out["density"], strict=True)
        return out | {
            "density": np.array(
                [np.interp(x, middles, row, left=0.0, right=0.0) for middles, row in rows]
            )
        }

    whole = range(-1, max(most, needed)) if path.cycle else range(-1, 0)
    alone = steady and time is None and period is not None
    first = run(
        coarse, grids(cells // 2, _SHIFTS if alone else _SHIFTS[:1]), np.zeros(0), whole, needed
    )
    count = first["works"].shape[1]
    resumed = alone and count > _RESUMED
    numbers = range(count - _RESUMED, count) if resumed else range(-1, count if path.cycle else 0)
    if time is not None:
        asked = np.asarray(time, dtype=float)
    elif alone and period is not None:
        last = path.cycle_start + (count - 1) * period
        asked = np.linspace(last, last + period, increments // 2 + 1)[1:]
    else:
        legs = [
            np.linspace(leg.start, leg.end, increments // 16 + 1) for leg in path.initial_loading
        ]
        if period is not None:
            legs.append(
                np.linspace(
                    path.cycle_start,
                    path.cycle_start + count * period,
                    count * (increments // 2) + 1,
                )
            )
        asked = np.unique(np.concatenate(legs))
    every = max(len(asked) // _COMPARED, 1)
    grid = grids(cells, _SHIFTS)
    if resumed:
        grid.resume(first["begins"][numbers[0]], loads.values(np.array([path.cycle_start]))[:, 0])
    own = run(fine, grid, asked, numbers, len(numbers), every)
    rough = first
    if not alone:
        rough = run(coarse, grids(cells // 2, _SHIFTS), asked[::every], numbers, len(numbers))

    def error(name: str, order: float, factor: Array | float = 1.0) -> float:
        """Error of the mean over the grids, over the largest value; root mean squares.

        What it changes from coarse grids over 2^order - 1, and twice the standard error by the
        means over every fourth grid, which are evenly moved themselves.
        """
        fine_ones, coarse_ones = (factor * np.atleast_2d(each[name].T).T for each in (own, rough))
        size = float(np.max(np.abs(fine_ones), initial=0.0))
        quarters = np.array([np.mean(fine_ones[k::_GROUPS], axis=0) for k in range(_GROUPS)])
        changed, spread = (
            np.mean(fine_ones, axis=0) - np.mean(coarse_ones, axis=0),
            np.var(quarters, axis=0) / (_GROUPS - 1),
        )
        apart = np.sqrt(np.mean(changed**2)) / (2**order - 1)
        return float(2 * np.sqrt(np.mean(spread)) + apart) / size if size > 0 else 0.0

    given = own["loads"]
    middle, half = contact.under(given[0], given[3])
    contact_edges = np.stack([middle - half, middle + half], axis=-1)
    pressure = contact.pressure_over(x, middle, half)
    touching = (x >= contact_edges[:, :1]) & (x <= contact_edges[:, 1:])
    works = np.mean(own["works"], axis=0)
    trend = np.mean(first["works"], axis=0) if resumed else works
    if resumed:
        works = np.append(trend[:-1], works[-1])
    share = np.where(touching, own["share"], 0.0) if pointwise else np.full(touching.shape, np.nan)
    state = np.where(
        touching & pointwise,
        np.where(np.abs(share) < 1 - 1e-12, STICK, np.where(share > 0, SLIP_FORWARD, SLIP_REVERSE)),
        OPEN,
    )
    errors = {"dissipation": error("work", 1.5), "dissipation_density": error("density", 1)}
    if pointwise and not alone:
        errors["shear"] = error("share each", 1, friction * pressure[::every])
        errors["slip"] = error("slip each", 0.9)
    return Followed(
        time=asked,
        loads=given,
        moment=contact.moment(middle, half, given[0], given[3]),
        shear_moment=own["shear_moment"],
        displacement=own["displacement"],
        contact_edges=contact_edges,
        stick_edges=np.clip(own["stick_edges"], contact_edges[:, :1], contact_edges[:, 1:]),
        pressure=pressure,
        shear=friction * pressure * share,
        slip=own["slip"] if pointwise else np.full(touching.shape, np.nan),
        state=state.astype(np.int8),
        works=works,
        loop=float(np.mean(own["loop"])),
        remainder=remainder_of(trend.tolist()),
        steady_from=first_repeat(trend, STEADY),
        steady_to=STEADY,
        density=np.mean(own["density"], axis=0),
        permanent_stick_edges=own["permanent"],
        counts={
            "grids": 2 * len(_SHIFTS),
            "cells": cells,
            "increments": (
                first["increments"] + own["increments"] + (0 if alone else rough["increments"])
            ),
            "pieces": own["pieces"],
        }
        | ({"cycles on coarse grids alone": numbers[0]} if resumed else {})
        | ({"increments without early slip": early} if (early := grid.without_early_slip) else {}),
        errors=errors,
    )
