"""The last cycle of a solution, one solution put on the points and instants of another, and the instants worth a picture."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from scenes import ContactSolution, InputError, freeze

Array = NDArray[np.float64]

FIELDS = ("pressure", "shear", "slip")
EDGES = ("contact_edges", "stick_edges")
SERIES = ("normal_load", "tangential_load", "tangential_displacement", "normal_approach")
# Only of scenes with bulk stress, tilt or an unsymmetric profile.
OF_BULK = ("bulk_stress_lower", "bulk_stress_upper", "tilt", "moment", "shear_moment")


@dataclass(frozen=True, eq=False)
class Cycle:
    """The last whole cycle of a solution (the whole path, where it is not periodic), both ends included.

    Attributes
    ----------
    time : (k,), the solution's own times; fraction : (k,), 0 at the start of the cycle and 1 at its end
    x : (n,) [length]; pressure, shear, slip, state : (k, n); contact_edges, stick_edges : (k, 2)
    normal_load, tangential_load, tangential_displacement, normal_approach : (k,)
    bulk_stress_lower, bulk_stress_upper, tilt, moment, shear_moment : (k,), or None, as in the solution
    dissipation_density : (n,)
    interpolation : estimated largest error of the re-sampling, over the field's largest value; empty where
        nothing was interpolated
    whole : False for the instants of a result that holds no whole cycle; `fraction` is then the time itself
    """

    time: Array
    fraction: Array
    x: Array
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    contact_edges: Array
    stick_edges: Array
    normal_load: Array
    tangential_load: Array
    tangential_displacement: Array
    normal_approach: Array
    dissipation_density: Array
    interpolation: Mapping[str, float] = field(default_factory=dict)
    whole: bool = True
    bulk_stress_lower: Array | None = None
    bulk_stress_upper: Array | None = None
    tilt: Array | None = None
    moment: Array | None = None
    shear_moment: Array | None = None

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series over time that it has."""
        return (*SERIES, *(name for name in OF_BULK if getattr(self, name) is not None))


def last_cycle(solution: ContactSolution) -> Cycle:
    """The last whole cycle of `solution`, or all instants where it says itself that it holds none; InputError where it has none."""
    if "whole_cycle" in solution.work.skipped:
        return instants(solution)
    steps = solution.last_cycle
    if len(steps) < 2:
        raise InputError(
            f"{solution.engine}: the solution holds no whole cycle (its times run from {solution.time[0]:.6g} to "
            f"{solution.time[-1]:.6g}); solve at least one revolution"
        )
    time = solution.time[steps]
    return _cycle(solution, steps, (time - time[0]) / (time[-1] - time[0]), whole=True)


def instants(solution: ContactSolution) -> Cycle:
    """Every instant of `solution`, `fraction` being the time."""
    return _cycle(solution, np.arange(len(solution.time)), solution.time, whole=False)


def sample_instants(reference: ContactSolution, like: Cycle) -> Cycle:
    """`reference` at the times of `like` (not whole) and on its points; times after its end are those of its last cycle."""
    cycle, period = instants(reference), reference.scene.load.path().period
    if len(cycle.time) == len(like.time) and np.array_equal(cycle.time, like.time):
        return sample(cycle, like, reference.engine)
    late = np.maximum(like.time - cycle.time[-1], 0.0)
    folded = like.time if period is None else like.time - period * np.ceil(late / period - 1e-9)
    return replace(sample(cycle, replace(like, fraction=freeze(folded)), reference.engine), time=like.time, fraction=like.time)


def _cycle(solution: ContactSolution, steps: NDArray[np.intp], fraction: Array, *, whole: bool) -> Cycle:
    def of_cycle(name: str) -> Any:
        """Those of a path that is one cycle are not copied: of a long record they take tens of megabytes each."""
        values = getattr(solution, name)
        return values if len(steps) == len(values) else freeze(values[steps], values.dtype)

    known = [name for name in OF_BULK if getattr(solution, name) is not None]
    picked: dict[str, Any] = {name: of_cycle(name) for name in (*FIELDS, *EDGES, *SERIES, *known)}
    return Cycle(
        time=freeze(solution.time[steps]),
        fraction=freeze(fraction),
        whole=whole,
        x=solution.x,
        state=of_cycle("state"),
        dissipation_density=solution.dissipation_density,
        **picked,
    )


def sample(cycle: Cycle, like: Cycle, engine: str) -> Cycle:
    """`cycle` on the points and instants of `like`; the same cycle where they are the same already.

    Instants are matched by the fraction of the cycle, since two engines may have needed different numbers of
    revolutions. Linear in x and in time; the state is that of the nearest point and instant. `interpolation` states
    what the same rule errs by when every second sample is left out: of 320 spacings at a square-root edge, where it
    converges slowest, one in a hundred at most errs by more.

    Raises
    ------
    InputError
        Where `like` asks for points at which `cycle` still carries pressure beyond its own range.
    """
    error: dict[str, float] = {}
    if len(cycle.fraction) != len(like.fraction) or not np.allclose(cycle.fraction, like.fraction, rtol=0, atol=1e-9):
        cycle, error = _at_instants(cycle, like)
    if len(cycle.x) != len(like.x) or not np.allclose(cycle.x, like.x, rtol=0, atol=1e-12 * np.ptp(like.x)):
        _refuse_cut_contact(cycle, like, engine)
        cycle, in_x = _at_points(cycle, like)
        error = {name: error.get(name, 0.0) + value for name, value in in_x.items()}
    return replace(cycle, interpolation=error)


def _refuse_cut_contact(cycle: Cycle, like: Cycle, engine: str) -> None:
    carries = np.max(cycle.pressure[:, [0, -1]], axis=0) > 1e-12 * np.max(cycle.pressure)
    beyond = like.x[0] < cycle.x[0], like.x[-1] > cycle.x[-1]
    if any(carries[side] and beyond[side] for side in (0, 1)):
        raise InputError(
            f"{engine}: its points end at x = {cycle.x[0]:.6g} and {cycle.x[-1]:.6g} where it still carries pressure, "
            "short of the points that it is compared at; give it points out to the largest contact"
        )


def _at_instants(cycle: Cycle, like: Cycle) -> tuple[Cycle, dict[str, float]]:
    error = {name: _halving(cycle.fraction, getattr(cycle, name)) for name in (*FIELDS, *EDGES)}
    nearest = np.abs(cycle.fraction[:, None] - like.fraction).argmin(axis=0)
    linear: dict[str, Any] = {
        name: freeze(_linear(like.fraction, cycle.fraction, getattr(cycle, name))) for name in (*FIELDS, *EDGES, *cycle.series)
    }
    return replace(cycle, time=like.time, fraction=like.fraction, state=freeze(cycle.state[nearest], np.int8), **linear), error


def _at_points(cycle: Cycle, like: Cycle) -> tuple[Cycle, dict[str, float]]:
    names = (*FIELDS, "dissipation_density")
    error = {name: _halving(cycle.x, getattr(cycle, name).T) for name in names}
    nearest = np.abs(cycle.x[:, None] - like.x).argmin(axis=0)
    state = np.where((like.x < cycle.x[0]) | (like.x > cycle.x[-1]), 0, cycle.state[:, nearest])
    linear: dict[str, Any] = {name: freeze(_linear(like.x, cycle.x, getattr(cycle, name).T).T) for name in names}
    return replace(cycle, x=like.x, state=freeze(state, np.int8), **linear), error


def _linear(to: Array, at: Array, values: Array) -> Array:
    """`values` (len(at), ...) at `to`, linear between samples and constant beyond them."""
    upper = np.clip(np.searchsorted(at, to, side="right"), 1, len(at) - 1)
    weight = np.clip((to - at[upper - 1]) / (at[upper] - at[upper - 1]), 0.0, 1.0)
    weight = weight.reshape(-1, *(1,) * (values.ndim - 1))
    # A weight of exactly 0 or 1 must not let a NaN of the other end in.
    low, high = values[upper - 1], values[upper]
    return np.where(weight == 0, low, np.where(weight == 1, high, (1 - weight) * low + weight * high))


def _halving(at: Array, values: Array) -> float:
    """Largest error of the linear rule when every second sample is left out, over the largest |value|.

    Both halves are tried: a square-root edge errs most where it falls into the middle of an interval.
    """
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    if len(at) < 4 or largest == 0.0:
        return 0.0
    worst = 0.0
    for first in (1, 2):
        left_out = np.arange(first, len(at) - 1, 2)
        coarse = np.delete(np.arange(len(at)), left_out)
        difference = np.abs(_linear(at[left_out], at[coarse], values[coarse]) - values[left_out])
        worst = max(worst, float(np.nanmax(difference, initial=0.0)))
    return worst / largest


# Instants of the last cycle that a page shows.
MOST_EVENTS = 6


@dataclass(frozen=True)
class Event:
    """An instant of the last cycle: its index in the cycle and what happens there."""

    index: int
    label: str


def events(cycle: Cycle, friction: float) -> tuple[Event, ...]:
    """At most `MOST_EVENTS` instants in the order of time: extremes of P, Q, Q - f P, Q + f P; then middles of gaps.

    Without bulk stress and tilt Q - f P is largest where forward slip ends, Q + f P least where reverse slip ends. A quantity that
    does not move has no extremes.
    """
    normal, tangential = cycle.normal_load, cycle.tangential_load
    # With bulk stress or tilt each edge has a law of its own, and slip ends elsewhere.
    plain = cycle.tilt is None and cycle.shear_moment is None
    wanted = (
        ("P largest", normal),
        ("P least", -normal),
        ("Q largest", tangential),
        ("Q least", -tangential),
        ("forward slip ends" if plain else "Q − f P largest", tangential - friction * normal),
        ("reverse slip ends" if plain else "Q + f P least", -tangential - friction * normal),
    )
    found: dict[int, str] = {}
    size = float(np.max(np.abs(normal)))
    for label, quantity in wanted:
        if np.ptp(quantity) > 1e-9 * size:
            # The first instant, to rounding: the end of a cycle repeats its start.
            found.setdefault(int(np.flatnonzero(quantity >= np.max(quantity) - 1e-12 * size)[0]), label)
    chosen = dict(list(found.items())[:MOST_EVENTS])
    if len(cycle.time) == 1:
        chosen = {0: "the only instant"}
    while len(chosen) < min(MOST_EVENTS, len(cycle.time) - 1):
        chosen.setdefault(_widest_gap(chosen, cycle.time), "between")
    return tuple(Event(index, chosen[index]) for index in sorted(chosen))


def _widest_gap(chosen: dict[int, str], time: NDArray[np.float64]) -> int:
    """The instant nearest to the middle of the longest time between chosen ones, the ends of the cycle counting as such."""
    last = len(time) - 1
    stops = sorted({-1, *chosen, last + 1})  # the ends themselves may be chosen too
    gaps = [(time[max(a, 0)], time[min(b, last)], np.arange(a + 1, b)) for a, b in itertools.pairwise(stops) if b - a > 1]
    start, end, inside = max(gaps, key=lambda gap: gap[1] - gap[0])
    return int(inside[np.argmin(np.abs(time[inside] - (start + end) / 2))])
