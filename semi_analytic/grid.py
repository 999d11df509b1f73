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
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, cho_solve

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
# Increments of a leg of the cycle at least; each leg of the initial loading has a quarter of those of a cycle.
_OF_LEG = 4
# Share of its work by which a cycle may differ from the one before and repeat it: far below what the grid leaves.
STEADY = 1e-6
# Shares of a cell by which grids are moved: no two are mirror images under a symmetric contact.
_SHIFTS = (0.0, 0.382, 0.764, 0.146)
# Instants, out of those asked for, at which coarse grids are held against the others.
_COMPARED = 40
# Share of the largest slip of a cycle up to which a cell counts as permanently stuck.
_STAYS = 1e-3
_STATES = np.array([STICK, SLIP_FORWARD, SLIP_REVERSE])


class Increment(NamedTuple):
    """The answer at an instant, k cells.

    Attributes
    ----------
    pressure, shear, slip : (k,)
    state : (k,) open, stick, forward or reverse slip
    approach, displacement, tilt : delta, U (of x = 0, with the datum length 1 in the logarithm), alpha
    moment, shear_moment : int x p and m_q = int x q
    density : (k,) friction work since the instant before, by the trapezoidal rule
    """

    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    approach: float
    displacement: float
    tilt: float
    moment: float
    shear_moment: float
    density: Array


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
        self._shear: Array = np.zeros(cells)
        self._slip: Array = np.zeros(cells)
        self._shift = 0.0
        self._pressed: dict[tuple[float, float], tuple[Array, NDArray[np.bool_], float]] = {}

    def compliance_at(self, x: Array) -> Array:
        """Displacement at points (m,) by a unit traction on each cell, (m, k); the length of the grid is the datum length."""
        ends = ((x[:, None] - self.x)[..., None] + self.step * np.array([-0.5, 0.5])) / self._length
        with np.errstate(divide="ignore", invalid="ignore"):
            primitive = np.where(ends == 0, 0.0, ends * (np.log(np.abs(ends)) - 1))
        return np.asarray(-2 * self._length / (math.pi * self.modulus) * np.diff(primitive, axis=-1)[..., 0])

    def _balanced(self, here: NDArray[np.bool_], right: Array, total: float) -> tuple[Array, float]:
        """Tractions t of the cells `here` with this total, C t = right + b, and the rigid movement b."""
        # C is positive definite: its cells lie within its datum length.
        factor = cho_factor(self._compliance[np.ix_(here, here)], overwrite_a=True, check_finite=False)
        own, unit = cho_solve(factor, np.stack([right[here], np.ones(np.count_nonzero(here))], axis=1), check_finite=False).T
        rigid = (total / self.step - float(np.sum(own))) / float(np.sum(unit))
        result = np.zeros(len(self.x))
        result[here] = own + rigid * unit
        return result, rigid

    def _press(self, load: float, tilt: float, lifted: Array) -> tuple[Array, NDArray[np.bool_], float]:
        """Pressure, the cells that touch and the normal approach: p > 0 where g = 0."""
        height = lifted + tilt * self.x
        touching = self._touching if self._touching.any() else height <= np.sort(height)[5]
        for _ in range(_TURNS):
            p, approach = self._balanced(touching, -height, load)
            wanted = np.where(touching, p > 0, height - approach + self._compliance @ p < 0)
            if np.array_equal(wanted, touching):
                break
            touching = wanted
        else:
            raise ArithmeticError("the contact area does not converge")
        if touching[0] or touching[-1]:
            raise ArithmeticError("the contact meets the end of the grid")
        return p, touching, approach

    def _drag(self, force: float, moved: Array, limit: Array, touching: NDArray[np.bool_]) -> tuple[Array, Array, Array, float]:
        """Shear, slip, directions of slip and U: no slip where |q| < f p."""
        direction = np.zeros(len(self.x), dtype=int)
        for _ in range(_TURNS):
            sticks = touching & (direction == 0)
            fixed = direction * limit
            if not sticks.any():
                raise ArithmeticError("all cells slip")
            q, shift = self._balanced(
                sticks, moved - self._slip - self._compliance @ fixed, force - self.step * float(np.sum(fixed))
            )
            q = q + fixed
            s = shift + moved - self._compliance @ q
            exceeds = sticks & (np.abs(q) > limit + _ROUNDING * limit.max())
            goes_on = touching & (direction * (s - self._slip) > 0)
            wanted = np.where(exceeds, np.sign(q), np.where(goes_on, direction, 0)).astype(int)
            if np.array_equal(wanted, direction):
                return q, s, direction, shift
            direction = wanted
        raise ArithmeticError("the slip zones do not converge")

    def advance(self, load: float, force: float, strain: float, tilt: float) -> Increment:
        """One increment to P, Q, eps and alpha.

        Raises ArithmeticError where active sets do not converge, all cells slip, or the contact meets the end of the grid.
        """
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
            p, self._touching, approach = self._pressed[load, tilt]
            q, s, self._direction, shift = self._drag(force, strained, self.friction * p, self._touching)
        else:  # in turn
            for _ in range(_TURNS):
                p, self._touching, approach = self._press(load, tilt, self._height + self._coupling @ last)
                q, s, self._direction, shift = self._drag(force, strained + self._coupling @ p, self.friction * p, self._touching)
                change, last = float(np.max(np.abs(q - last))), q
                if change <= _ROUNDING * self.friction * p.max():
                    break
            else:
                raise ArithmeticError("pressure and shear by turns do not converge")
        density = (self._shear + q) * (s - self._slip) / 2
        self._shear, self._slip, self._shift = q, s, shift
        state = np.where(self._touching, _STATES[self._direction], OPEN).astype(np.int8)
        moments = self.step * float(self.x @ p), self.step * float(self.x @ q)
        return Increment(p, q, s, state, approach - self.datum * load, shift - self.datum * force, tilt, *moments, density)


class Fields(NamedTuple):
    """The answer at n instants and k cells: as `Increment` with a first axis (n,) more.

    `work` and `loop` (n,) are the friction work of the increment that ends there and its Q dU - m_q d eps, both by the trapezoidal
    rule.
    """

    x: Array
    step: float
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    approach: Array
    displacement: Array
    tilt: Array
    moment: Array
    shear_moment: Array
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
    Raises ArithmeticError where active sets do not converge or the contact meets the end of the grid.

    >>> found = solve(lambda x: x**2 / 2, (-1.0, 1.0), 200, 1.0, [0.4], [0.0])  # Hertz: a = sqrt(4 P/pi), R = 1
    >>> abs(found.edges(0)[1] - (1.6 / math.pi) ** 0.5) < found.step
    True
    """
    loads = np.stack(np.broadcast_arrays(np.atleast_1d(normal), shear, strain, tilt), axis=1)
    grid = Grid(height, extent, cells, friction, modulus, dundurs)
    rows = [grid.advance(*row) for row in loads.tolist()]
    found: dict[str, Any] = {name: np.array([getattr(row, name) for row in rows]) for name in Increment._fields}
    work = grid.step * np.sum(found.pop("density"), axis=1)
    middles = [(values[1:] + values[:-1]) / 2 for values in (loads[:, 1], found["shear_moment"])]
    loop = np.append(0.0, middles[0] * np.diff(found["displacement"]) - middles[1] * np.diff(loads[:, 2]))
    return Fields(grid.x, grid.step, **found, work=work, loop=loop)


# ------------------------------------------------------------------------------------------------------ a scene's load path
@dataclass(frozen=True, eq=False)
class _Path:
    """A load path in increments; the tilt of a moment is that of `contact`."""

    loads: PathLoads
    contact: TiltedProfile
    increments: int
    _known: dict[bytes, Array] = field(default_factory=dict)

    def stretches(self, asked: Array, cycles: int) -> Iterator[tuple[int, Array, list[tuple[int, int]]]]:
        """Of each leg: the number of the cycle, -1 before; P, Q, eps, alpha of its instants (n, 4); (row, instant asked for)."""
        path = self.loads.path
        whole = path.cycle or path.initial_loading
        length, late = whole[-1].end - whole[0].start, path.period or 0.0
        for number in range(-1, cycles if path.cycle else 0):
            for k, leg in enumerate(path.initial_loading if number < 0 else path.cycle):
                least = self.increments // 4 if number < 0 and (path.cycle or not k) else _OF_LEG
                share = 0.0 if number < 0 and path.cycle else (leg.end - leg.start) / length
                # From first touch in equal steps of the contact's size.
                power = 2 if leg is path.initial_loading[0] else 1
                places = np.linspace(0, 1, max(least, math.ceil(self.increments * share)) + 1)[1:] ** power
                base = leg.start + (leg.end - leg.start) * places
                own = asked - max(number, 0) * late
                here = np.flatnonzero((own > leg.start) & (own <= leg.end) | (own <= path.start) & (leg is path.initial_loading[0]))
                # Increments of its own make way for instants that are asked for, but where a load turns round.
                new, slack = np.maximum(own[here], path.start), 0.5 * (leg.end - leg.start) / len(base)
                near = np.min(np.abs(base[:, None] - new), axis=1, initial=math.inf) < slack
                turns = self.loads.turns(leg)
                new = new[np.min(np.abs(new[:, None] - turns), axis=1, initial=math.inf) > 2e-9 * (leg.end - leg.start)]
                time = np.unique(np.concatenate([base[~near], turns, new]))
                key = time.tobytes()
                if key not in self._known:
                    self._known[key] = self._rows(time)
                yield number, self._known[key], [(int(np.argmin(np.abs(time - max(own[i], path.start)))), int(i)) for i in here]

    def _rows(self, time: Array) -> Array:
        rows = self.loads.values(time)
        if self.loads.path.moment_given and self.contact.shape.radius is None:
            rows[3] = self.contact.tilt_under(rows[0], -rows[3] * self.loads.radius * rows[0])
        return rows.T


class _Run(NamedTuple):
    """What one grid answers: `works` of the cycles, `work` and `loop` of the last; at n instants and m points as `Followed`."""

    works: Array
    work: float
    loop: float
    loads: Array
    share: Array
    slip: Array
    displacement: Array
    shear_moment: Array
    stick_edges: Array
    pieces: int
    density: Array
    permanent: Array


def _run(grid: Grid, path: _Path, x: Array, asked: Array, least: int, most: int) -> _Run:
    """Follow the path on one grid until a cycle repeats the one before, `least` cycles at any rate."""
    n, m, half = len(asked), len(x), grid.step / 2
    share, slip = np.zeros((n, m)), np.zeros((n, m))
    displacement, shear_moment, edges, pieces = np.zeros(n), np.zeros(n), np.full((n, 2), np.nan), 1
    kernel, works, now, loads = grid.compliance_at(x), [], -2, np.zeros((4, n))
    work = loop = 0.0
    density, slid = np.zeros(len(grid.x)), np.zeros(len(grid.x))
    last, force, strained = None, 0.0, 0.0
    for number, rows, wanted in path.stretches(asked, most):
        if number != now and number >= 0:
            if now >= 0:
                works.append(work)
                if len(works) >= max(least, 2) and abs(works[-1] - works[-2]) <= STEADY * works[-1]:
                    break
            work = loop = 0.0
            density, slid = np.zeros(len(grid.x)), np.zeros(len(grid.x))
        now = number
        where = dict.fromkeys(row for row, _ in wanted)
        for k, row in enumerate(rows.tolist()):
            try:
                found = grid.advance(*row)
            except ArithmeticError as fault:
                raise InputError(
                    f"load: half-plane theory takes grids for such bulk stress or tilt, and {fault} at P = {row[0]:.6g}, "
                    f"Q = {row[1]:.6g} of cycle {number + 1}; finite elements may take the scene"
                ) from fault
            density = density + found.density
            work += grid.step * float(np.sum(found.density))
            if last is not None:
                loop += (row[1] + force) / 2 * (found.displacement - last.displacement)
                loop -= (found.shear_moment + last.shear_moment) / 2 * (row[2] - strained)
            stick = found.state == STICK
            # What opens does not stick: it counts as slip without end.
            slid = slid + np.where(found.state == OPEN, np.inf, 0.0) + (np.abs(found.slip - last.slip) if last is not None else 0.0)
            last, force, strained = found, row[1], row[2]
            if k not in where:
                continue
            runs = np.flatnonzero(np.diff(np.concatenate([[False], stick, [False]]).astype(int)))
            touching = np.flatnonzero(found.state != OPEN)
            for i in (i for row_of, i in wanted if row_of == k):
                loads[:, i] = row
                displacement[i], shear_moment[i] = found.displacement, found.shear_moment
                slip[i] = found.displacement + grid.datum * row[1] - row[2] * x - kernel @ found.shear
                if not len(touching):
                    continue
                limit = grid.friction * found.pressure[touching]
                share[i] = np.interp(x, grid.x[touching], found.shear[touching] / limit)
                pieces = max(pieces, len(runs) // 2)
                if len(runs):
                    # A cell that sticks at the edge of contact sticks up to it.
                    low = -np.inf if runs[0] == touching[0] else grid.x[runs[0]] - half
                    high = np.inf if runs[-1] - 1 == touching[-1] else grid.x[runs[-1] - 1] + half
                    edges[i] = low, high
    else:
        works.append(work)
    most_slid = float(np.max(slid, where=np.isfinite(slid), initial=0.0))
    here = grid.x[slid <= _STAYS * most_slid]
    return _Run(
        np.array(works),
        works[-1],
        loop,
        loads,
        share,
        slip,
        displacement,
        shear_moment,
        edges,
        pieces,
        np.interp(x, grid.x, density, left=0.0, right=0.0),
        np.array([here[0] - half, here[-1] + half]) if len(here) else np.full(2, np.nan),
    )


def edges_along(loads: PathLoads, contact: TiltedProfile) -> Array:
    """Edges of contact at instants of the initial loading and of a cycle, (n, 2)."""
    rows = np.concatenate([rows for _, rows, _ in _Path(loads, contact, INCREMENTS).stretches(np.zeros(0), 1)])
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

    def run(cut: _Path, cells: int, shift: float, least: int, most: int, asked: Array) -> _Run:
        cell = (high - low) / cells
        extent = low - (2 + shift) * cell, high + (3 - shift) * cell
        return _run(Grid(height, extent, cells + 5, friction, modulus), cut, x, asked, least, most)

    # The coarse grids are the cheap ones: they tell how many cycles it takes.
    none = np.zeros(0)
    count = len(run(coarse, cells // 2, 0.0, needed, max(most, needed), none).works)
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
        return np.asarray(np.mean([getattr(each, name) for each in own], axis=0))

    def error(name: str, factor: Array | float = 1.0, every: int = 1) -> float:
        """Twice the standard deviation between grids and what the coarse ones change, over the largest value; root mean squares."""
        fine_ones = factor * np.array([np.atleast_1d(getattr(each, name))[::every] for each in own])
        coarse_ones = factor * np.array([np.atleast_1d(getattr(each, name)) for each in rough])
        size = float(np.max(np.abs(fine_ones), initial=0.0))
        changed = np.mean(fine_ones, axis=0) - np.mean(coarse_ones, axis=0)
        return float(2 * np.sqrt(np.mean(np.var(fine_ones, axis=0))) + np.sqrt(np.mean(changed**2))) / size if size > 0 else 0.0

    given = own[0].loads
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
        loop=float(np.mean([each.loop for each in own])),
        remainder=remainder_of(works.tolist()),
        steady_from=steady,
        steady_to=STEADY,
        density=mean("density"),
        permanent_stick_edges=mean("permanent"),
        counts={"grids": 2 * len(_SHIFTS), "cells": cells, "increments": increments * count, "pieces": max(r.pieces for r in own)},
        errors={
            "dissipation": error("work"),
            "dissipation_density": error("density"),
            "shear": error("share", friction * pressure[::every], every),
            "slip": error("slip", 1.0, every),
        },
    )
