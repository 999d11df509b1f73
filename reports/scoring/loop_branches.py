"""Rows of a loop of Q over U: turning points of Q, and the branch each row lies on.

A row lies on the rising or on the falling branch between two turning points of Q, whatever the form
of Q over time. Turning points are those between which Q passes a quarter and three quarters of its
range: noise, and small reversals on the way, are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from scenes import InputError
from scenes.array_types import Array

# Levels of Q, as shares of its range, that rows must pass between two turning points: noise turns Q
# more often.
_LOWER = 0.25
_UPPER = 0.75
# Scatter of Q from row to row beyond this share of its amplitude hides the loop; rows of a cycle
# below which turning points can't be told.
_SCATTER = 0.15
_FEWEST_OF_CYCLE = 8
# Rows on each side of a turning point that two parabolas are fitted to: the fewest that leave a
# residual, and how they grow.
_WINDOW = 3
_GROWTH = 1.5
# Places of the joint of the two parabolas that are tried.
_JOINTS = 25
# Residuals of the parabolas over the noise of Q, beyond which the window is too long for parabolas.
_AS_NOISE = 1.15
# Variance of two joined parabolas at their joint, times the rows on each side over the variance of
# a row.
_AT_JOINT = 4.5
# Instants at which the size of a cycle is found: more than rows of a cycle are.
_INSTANTS_OF_CYCLE = 600


class TurningPoint(NamedTuple):
    """Q at a turning point, and its standard error."""

    load: float
    error: float


@dataclass(frozen=True, eq=False)
class Branches:
    """Where rows lie on a loop.

    Attributes
    ----------
    phase
        (n,) cycles since a lowest Q, by the share of the branch that Q has passed; grows with
        the rows but for noise
    rising
        (n,) whether Q grows along the row's branch
    highest, lowest
        turning points
    load_noise
        sigma of Q, as far as neighbouring rows show it
    """

    phase: Array
    rising: NDArray[np.bool_]
    highest: TurningPoint
    lowest: TurningPoint
    load_noise: float

    @property
    def cycles(self) -> float:
        """How many the rows cover."""
        return float(self.phase[-1] - self.phase[0])


# ----------------------------------------------------------------------------- branches of the rows
def row_noise(values: Array) -> float:
    """Standard deviation of white noise of rows (n,), from the median of their fourth differences,
    of variance 70 sigma^2.

    Of rows without noise it is what a smooth curve leaves in them, which is small.
    """
    return 1.4826 * float(np.median(np.abs(np.diff(values, 4)))) / math.sqrt(70)


def find_branches(
    shift: Array, load: Array, time: Array, resolution: float, source: str
) -> Branches:
    """Turning points and branches of rows of Q.

    Parameters
    ----------
    shift, load, time
        U, Q and time of the rows, (n,) each; time ascends
    resolution
        step of Q that the digits of the rows resolve

    Raises
    ------
    InputError
        Where Q does not go up and down, or where the rows cover less than a cycle.
    """
    noise = max(row_noise(load), resolution / math.sqrt(12))
    bottom, top = _range(load, noise)
    if noise > _SCATTER * (top - bottom) / 2:
        raise InputError(
            f"{source}: its Q goes up and down to {200 * noise / np.ptp(load):.0f} % of its"
            f" amplitude only (limit {100 * _SCATTER:.0f} %), the rest is scatter: give the rows in"
            " the order of time, and whole cycles"
        )
    begins, ends, upward = _crossings(load, bottom, top)
    cyclic_load = load
    cyclic_time = time
    period = math.inf
    copies = 1
    if len(begins) < 3:  # less than two cycles: the first one follows itself round
        end = _closing_row(shift, load, begins, upward, noise)
        if end is None:
            covered = float(
                np.sum(np.abs(np.diff(_turned(load, begins, ends)))) / (2 * (top - bottom))
            )
            raise InputError(
                f"{source}: its rows cover {covered:.2g} of a cycle: a loop needs a whole one"
            )
        closed = abs(load[end] - load[0]) < 0.5 * float(np.median(np.abs(np.diff(load))))
        step = 0.0 if closed else float(np.median(np.diff(time)))
        period = float(time[end]) - float(time[0]) + step
        begin = 1 if closed else 0
        cyclic_load = np.concatenate([load[: end + 1], load[begin : end + 1]])
        cyclic_time = np.concatenate([time[: end + 1], time[begin : end + 1] + period])
        copies = 2
        begins, ends, upward = _crossings(cyclic_load, bottom, top)
    middles = _middles(cyclic_load, cyclic_time, begins, ends, (bottom + top) / 2)
    if len(middles) < 3 or 2 * (ends[-1] - begins[0]) / (len(begins) - 1) < _FEWEST_OF_CYCLE:
        raise InputError(
            f"{source}: a loop needs at least {_FEWEST_OF_CYCLE} rows a cycle, in the order of time"
        )
    centres = (middles[1:] + middles[:-1]) / 2  # of the two crossings of a turning point
    is_top = upward[:-1]
    found = {
        side: _turning_point(
            cyclic_load,
            cyclic_time,
            centres[is_top == side],
            np.diff(middles)[is_top == side],
            side,
            noise,
            copies,
        )
        for side in (True, False)
    }
    highest, above = found[True]
    lowest, below = found[False]

    # Turning points in the order of time, with one before the first and one behind the last.
    half = {side: float(np.median(np.diff(middles)[is_top == side])) / 2 for side in (True, False)}
    place = {True: above, False: below}
    turns = centres + np.where(is_top, above, below)
    turns = np.concatenate(
        [
            [middles[0] - half[not upward[0]] + place[not upward[0]]],
            turns,
            [middles[-1] + half[bool(upward[-1])] + place[bool(upward[-1])]],
        ]
    )
    first_is_top = not bool(upward[0])
    # the record begins again: the turning points of the second time round belong to the first too
    if math.isfinite(period):
        first_is_top = not first_is_top
        turns = np.concatenate([turns[1:3] + period * lap for lap in range(-2, 3)])
    branch = np.asarray(np.searchsorted(turns, time, side="right") - 1)
    begins_at_top = (branch % 2 == 0) == first_is_top
    rising = ~begins_at_top
    start = np.where(begins_at_top, highest.load, lowest.load)
    passed = np.clip(np.abs(load - start) / (highest.load - lowest.load), 0.0, 1.0)
    return Branches(
        (branch + passed + (1 if first_is_top else 0)) / 2, rising, highest, lowest, noise
    )


def _range(load: Array, noise: float) -> tuple[float, float]:
    """Lowest and highest Q; what noise adds to them does not matter for levels within."""
    if not np.ptp(load) > 8 * noise:
        return float(load.min()), float(load.max())
    return float(load.min()) + 2 * noise, float(load.max()) - 2 * noise


def _crossings(
    load: Array, bottom: float, top: float
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
    """Crossings of the levels: last row before and first row behind each, and whether Q rises
    there.
    """
    low = load < bottom + _LOWER * (top - bottom)
    high = load > bottom + _UPPER * (top - bottom)
    rows = np.flatnonzero(low | high)
    state = high[rows]
    changes = np.flatnonzero(state[1:] != state[:-1])
    return rows[changes], rows[changes + 1], state[changes + 1]


def sizes_of_cycles(values: Array, load: Array, time: Array, noise: float) -> Array:
    """Root mean square over time of values (n,) from their mean, in each cycle from one crossing of
    the middle of Q to the next but one: (k,), each half a cycle later.

    Parameters
    ----------
    load, time, noise
        Q (n,), its time, and its sigma
    """
    bottom, top = _range(load, noise)
    begins, ends, _ = _crossings(load, bottom, top)
    middles = _middles(load, time, begins, ends, (bottom + top) / 2)
    instants = [
        np.linspace(begin, end, _INSTANTS_OF_CYCLE)
        for begin, end in zip(middles[:-2], middles[2:], strict=True)
    ]
    return np.array([float(np.std(np.interp(at, time, values))) for at in instants])


def _turned(load: Array, begins: NDArray[np.intp], ends: NDArray[np.intp]) -> Array:
    """First Q, the extreme of each stretch between crossings, last Q."""
    edges = [0, *((begins + ends) // 2 + 1).tolist(), len(load)]
    middle = float(load.max() + load.min()) / 2
    stretches = [load[first:last] for first, last in pairwise(edges) if last > first]
    extremes = [float(part[np.argmax(np.abs(part - middle))]) for part in stretches]
    return np.array([load[0], *extremes, load[-1]])


def _closing_row(
    shift: Array, load: Array, begins: NDArray[np.intp], upward: NDArray[np.bool_], noise: float
) -> int | None:
    """The row nearest to the first one, a cycle later on the same branch; None where the rows do
    not come back there.
    """
    if not len(begins):
        return None
    stretches = np.split(np.arange(len(load)), begins + 1)  # rows of high Q and of low Q by turns
    first_high = not bool(upward[0])
    first = load[stretches[0]]
    goes_on = (
        np.max(first) > load[0] + 4 * noise if first_high else np.min(first) < load[0] - 4 * noise
    )
    rising = bool(goes_on) == first_high
    # The branch of the first row begins again at the first lowest Q behind a highest one, or the
    # other way round.
    place = 1 if rising == first_high else 2
    if len(stretches) <= place:
        return None
    rows = stretches[place]
    turn = int(rows[np.argmin(load[rows]) if rising else np.argmax(load[rows])])
    # Behind the next turning point rows lie on the other branch, which is nearer than a step.
    rest = load[turn:]
    end = turn + int(np.argmax(rest) if rising else np.argmin(rest)) + 1
    apart = [values[turn:end] - values[0] for values in (load, shift)]
    steps = [float(np.max(np.abs(np.diff(values)))) for values in (load, shift)]
    # Along the branch U changes with Q, roughly as over the whole loop; across the loop it changes
    # alone.
    across = apart[1] - np.ptp(shift) / np.ptp(load) * apart[0]
    near = (np.abs(apart[0]) <= 2 * steps[0] + 4 * noise) & (
        np.abs(across) <= steps[1] + 5 * row_noise(shift)
    )
    if not np.any(near):
        return None
    distance = np.hypot(apart[0] / np.ptp(load), apart[1] / np.ptp(shift))
    return turn + int(np.argmin(np.where(near, distance, math.inf)))


def _middles(
    load: Array, time: Array, begins: NDArray[np.intp], ends: NDArray[np.intp], middle: float
) -> Array:
    """Time at which Q passes its middle at each crossing, by a straight line through the rows
    between the levels.
    """
    times = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        rows = slice(begin, end + 1)
        centre = float(np.mean(time[rows]))
        rate, level = np.polyfit(time[rows] - centre, load[rows], 1)
        at = centre + (middle - level) / rate if rate else centre
        times.append(min(max(float(at), float(time[begin])), float(time[end])))
    return np.array(times)


def _turning_point(
    load: Array, time: Array, centres: Array, lengths: Array, is_top: bool, noise: float, alike: int
) -> tuple[TurningPoint, float]:
    """Q at the turning points of a side, all laid over each other, and their place behind the
    middle of their crossings.

    Two parabolas that meet at the turning point describe a wave that is round there as well as one
    with a corner. The window is as long as they describe the rows to within the noise.
    """
    sign = 1.0 if is_top else -1.0
    count = len(centres)
    half = float(np.median(lengths)) / 2
    row = np.searchsorted(time, np.concatenate([centres - half, centres + half]))
    in_half = float(np.mean(row[count:] - row[:count])) / 2
    behind = np.searchsorted(centres, time)  # the nearest centre of each row
    nearest = np.clip(behind, 1, max(count - 1, 1)) if count > 1 else np.zeros(len(time), dtype=int)
    if count > 1:
        nearest = np.where(
            time - centres[nearest - 1] < centres[nearest] - time, nearest - 1, nearest
        )
    apart = (time - centres[nearest]) / half  # -1 and 1 at the crossings
    values = sign * load
    # Where the turning point is: the middle of the rows that are nearly as high as any.
    inside = np.abs(apart) < 1
    high = inside & (values >= np.max(values[inside]) - 0.05 * np.ptp(values) - 2 * noise)
    middle = float(np.median(apart[high]))
    window = float(_WINDOW)
    fits: list[tuple[float, float, float]] = []
    while window < max(in_half, _WINDOW + 0.5):
        reach = (window + 0.5) / in_half
        rows = np.abs(apart - middle) <= reach
        x = (apart[rows] - middle) / reach
        y = values[rows]
        fit = _two_parabolas(x, y)
        if fit is not None:
            height, where, residual = fit
            if fits and residual > _AS_NOISE * noise:
                break
            fits.append((height, middle + where * reach, window))
        window *= _GROWTH
    if not fits:
        height = float(np.max(values[inside]))
        where = middle
        window = 1.0
        return TurningPoint(sign * height, float(noise + np.ptp(values) / in_half)), where * half
    height, where, window = fits[-1]
    shorter = fits[-2][0] if len(fits) > 1 else float(np.max(values[inside]))
    error = math.hypot(
        noise * math.sqrt(_AT_JOINT / (window * max(count // alike, 1))), height - shorter
    )
    return TurningPoint(sign * height, error), where * half


def _two_parabolas(x: Array, y: Array) -> tuple[float, float, float] | None:
    """Highest value of two parabolas that meet, fitted to rows (n,), its place, and the root mean
    square of the residuals.
    """
    freedom = len(x) - 6
    if freedom < 1:
        return None
    best = (math.inf, 0.0, np.zeros(5))
    for joint in np.linspace(-0.5, 0.5, _JOINTS):
        left = np.minimum(x - joint, 0.0)
        right = np.maximum(x - joint, 0.0)
        columns = np.column_stack([np.ones_like(x), left, left**2, right, right**2])
        terms = np.linalg.lstsq(columns, y, rcond=None)[0]
        rest = y - columns @ terms
        squares = float(rest @ rest)
        if squares < best[0]:
            best = (squares, float(joint), terms)
    squares, joint, terms = best
    fine = np.linspace(-0.7, 0.7, 281)
    left = np.minimum(fine - joint, 0.0)
    right = np.maximum(fine - joint, 0.0)
    curve = terms[0] + terms[1] * left + terms[2] * left**2 + terms[3] * right + terms[4] * right**2
    place = int(np.argmax(curve))
    return float(curve[place]), float(fine[place]), math.sqrt(squares / freedom)
