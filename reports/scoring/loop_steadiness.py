"""Whether the rows of a loop are of one steady loop of theory: drift of U, run-in, and cycles that
differ.

The distances of rows from the loop that fits them are scatter if the model holds: neighbours do
not know of each other. Where the model does not hold, neighbours lie on the same side of it, and
the correlation of neighbours says how much of the distances is no scatter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.scoring.loop_branches import Branches, row_noise, sizes_of_cycles
from scenes.array_types import Array

# Correlation of neighbours in its standard deviations, 1/sqrt(n): chance exceeds three once in
# 700.
BY_CHANCE = 3.0
# Neighbours that are alike to this leave one row's worth in 40: no interval is widened more.
_MOST_ALIKE = 0.95
# Singular values of columns that are alike, over the largest.
_ALIKE_COLUMNS = 1e-8
# Blocks of neighbours whose means show a smooth part of the distances, and their least rows.
_BLOCKS = 40
_ROWS_OF_BLOCK = 25
# Rows of which the branch is certain: this share of a branch is left out at both of its ends.
_AT_TURN = 0.1
# Pairs of rows a cycle apart that a drift is found from.
_FEWEST_PAIRS = 8
# Sizes of cycles that are alike differ by less: at 20 rows a cycle a size is known to 1 %.
_ALIKE = 0.03
# Largest difference between sizes of a few cycles by noise, in standard deviations of one.
_NOISE_OF_SIZES = 4.0
# Sizes, half a cycle after each other, that part a period of two cycles from a trend.
_SHOWS_A_PERIOD = 4


@dataclass(frozen=True)
class Misfit:
    """What the distances of rows (n,) from their fit say about the model.

    Attributes
    ----------
    correlation
        of neighbours, 0 where chance may have given it
    systematic
        rms of the part of the distances that is no scatter [length]
    """

    correlation: float
    systematic: float

    @property
    def widening(self) -> float:
        """Of an interval: the square root of rows over independent rows, (1 + r)/(1 - r)."""
        alike = min(self.correlation, _MOST_ALIKE)
        return math.sqrt((1 + alike) / (1 - alike))


def misfit_of(distances: Array, shift_noise: float, least_deviations: float = BY_CHANCE) -> Misfit:
    """The misfit that distances (n,) in sigma show; `shift_noise` is sigma of U [length].

    A correlation of fewer standard deviations than `least_deviations` is taken for chance.

    >>> bool(misfit_of(np.sin(np.arange(200) / 10), 1.0).correlation > 0.9)
    True
    >>> misfit_of(np.random.default_rng(1).standard_normal(200), 1.0).correlation
    0.0
    """
    apart = distances - np.mean(distances)
    squares = float(apart @ apart)
    if squares == 0:
        return Misfit(0.0, 0.0)
    correlation = float(apart[1:] @ apart[:-1]) / squares
    if correlation * math.sqrt(len(apart)) <= least_deviations:
        return Misfit(0.0, 0.0)
    variance = squares / len(apart)
    systematic = correlation * variance
    rows_of_block = len(apart) // _BLOCKS
    if rows_of_block >= _ROWS_OF_BLOCK:
        # Many rows show more than their neighbours do: a smooth part stays in the means of blocks.
        means = apart[: _BLOCKS * rows_of_block].reshape(_BLOCKS, rows_of_block).mean(axis=1)
        of_blocks = max(float(np.mean(means**2)) - variance / rows_of_block, 0.0)
        systematic = min(systematic, of_blocks)
    return Misfit(correlation, math.sqrt(systematic) * shift_noise)


@dataclass(frozen=True, eq=False)
class Change:
    """How a loop changes with a number of its rows, such as time.

    Attributes
    ----------
    chance
        with which scatter alone explains as much
    rms
        of the distances that the change explains, in sigma
    rates
        (k,) change of the parameters per unit of the number
    """

    chance: float
    rms: float
    rates: Array


NO_CHANGE = Change(1.0, 0.0, np.zeros(7))
"""Of rows of too few cycles to show one."""


def change_of(
    distances: Array, derivatives: Array, when: Array, varying: NDArray[np.bool_]
) -> Change:
    """Whether the parameters of a loop change with `when`: the F test of a fit in which each has a
    part in proportion to it.

    Parameters
    ----------
    distances, derivatives
        of rows from their fit (n,), and by its parameters (n, k)
    when
        (n,) a number of each row, such as time
    varying
        (k,) which of the parameters may change

    >>> random = np.random.default_rng(2)
    >>> rows = random.standard_normal((200, 2))
    >>> time = np.arange(200) / 200 - 0.5
    >>> steady = random.standard_normal(200)
    >>> both = np.array([True, True])
    >>> change_of(steady, rows, time, both).chance > 0.05
    True
    >>> change_of(steady + 3 * time * rows[:, 0], rows, time, both).chance < 1e-6
    True
    """
    from scipy.stats import f as fisher

    centred = when - np.mean(when)
    changes = derivatives[:, varying] * centred[:, None]
    wider = np.column_stack([derivatives, changes])
    squares = []
    ranks = []
    for columns in (derivatives, wider):
        terms, _, rank, _ = np.linalg.lstsq(columns, distances, rcond=_ALIKE_COLUMNS)
        rest = distances - columns @ terms
        squares.append(float(rest @ rest))
        ranks.append(int(rank))
    rates = np.zeros(len(varying))
    rates[varying] = -terms[len(varying) :]  # a parameter moves against what it leaves
    added = ranks[1] - ranks[0]
    freedom = len(distances) - ranks[1]
    if added < 1 or freedom < 1 or squares[1] == 0:
        return Change(1.0, 0.0, rates)
    gain = max(squares[0] - squares[1], 0.0)
    chance = float(fisher.sf(gain / added / (squares[1] / freedom), added, freedom))
    return Change(chance, math.sqrt(gain / len(distances)), rates)


def drift_of_shift(shift: Array, load: Array, time: Array, branches: Branches) -> float | None:
    """Rate of U [length per unit of time] by rows a cycle apart at the same Q; None where too few
    rows have another a cycle later.
    """
    phase = np.maximum.accumulate(branches.phase)
    place = np.mod(2 * branches.phase, 1.0)
    chosen = (place > _AT_TURN) & (place < 1 - _AT_TURN) & (branches.phase + 1 < phase[-1])
    if np.count_nonzero(chosen) < _FEWEST_PAIRS:
        return None
    later = branches.phase[chosen] + 1
    slope = float(np.polyfit(load, shift, 1)[0])
    opened = shift - slope * load
    moved = np.interp(later, phase, opened) - opened[chosen]
    passed = np.interp(later, phase, time) - time[chosen]
    return float(np.mean(moved) / np.mean(passed))


def differences_of_cycles(shift: Array, load: Array, time: Array, noise: float) -> str:
    """How the cycles of rows differ from each other in size, in words; "" where they are alike."""
    for name, values in (("Q", load), ("U", shift)):
        sizes = sizes_of_cycles(values, load, time, noise)
        if len(sizes) < 2:
            return ""
        middle = float(np.median(sizes))
        rows_of_cycle = 2 * len(load) / (len(sizes) + 1)
        by_noise = _NOISE_OF_SIZES * row_noise(values) / (middle * math.sqrt(rows_of_cycle))
        changes = sizes / middle - 1
        if float(np.ptp(changes)) < _ALIKE + by_noise:
            continue
        steps = np.diff(changes)
        extent = (
            f"{name} of one cycle goes up and down by {100 * float(np.ptp(changes)):.2g} % more"
            " than of another"
        )
        if np.all(steps > 0):
            return f"its cycles grow: {extent}"
        if np.all(steps < 0):
            return f"its cycles shrink: {extent}"
        apart = changes - np.mean(changes)
        if len(apart) > _SHOWS_A_PERIOD and float(apart[2:] @ apart[:-2]) < 0:
            return f"its period is another, every second cycle is alike: {extent}"
        return f"its cycles differ: {extent}"
    return ""
