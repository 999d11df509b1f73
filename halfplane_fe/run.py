"""A whole load path through the interface: initial loading, then revolutions until the state
repeats.

Shakedown and ratcheting: where a series of one value a revolution goes, and how far from there its
last value is. With P and Q on like bodies the second revolution repeats the first. Unlike bodies
only approach their steady state, and so do loops with bulk stress or tilt out of phase:
geometrically, or as a power of the number k of revolutions. Then a small last change d_k is no
bound of what is left:

    geometric, d_k/d_(k-1) = r:             left = d_k r/(1 - r)
    algebraic, left in proportion to k^-m:     left = d_k/[(k/(k-1))^m - 1], about (k/m) d_k

The number m follows from the last ratio, d_k being about (k - 1/2)^-(m+1): r = ((k - 3/2)/(k -
1/2))^(m+1).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from halfplane_fe.arrays import Array, Indices
from halfplane_fe.between_nodes import Excess, excess
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.energy import certificates, increment_energies
from halfplane_fe.path import enclosed, scaled_loads, straight, stretches
from halfplane_fe.stepping import Increment, follow
from scenes import ConvergenceError, Interrupted, LoadPath, LoadSegment, freeze

Progress = Callable[[int, int | None, str], None]

# Two revolutions end alike when no nodal force differs by more than this share of the largest.
# Nodes at the rim of the permanent stick zone go on creeping towards the steady cycle. How fast is
# another matter (`trend`): the dissipation has to be there too.
REPEATS = 5e-4
# The same where they are equal but for round-off of the nodal forces.
_EQUAL = 1e-9
# Dissipation over f^2 P^2/E* below which the step error need not follow it down.
_LEAST_DISSIPATION = 3e-3
# Instants of a path of straight legs that keep pressure, shear and gap: a record of 2,000 rows has
# 40,000 increments, which would take gigabytes. No scene of the library comes near.
MOST_INSTANTS = 4000
# Share of the first leg of the initial loading after which its line of action is read.
_SOON = 1e-3
# Share of the largest value within which two values are the same but for round-off.
_SAME = 1e-12
# A ratio of a geometric series stays; that of m = 1 rises by a factor of 1 + 2/[k (k-2)] from one
# revolution to the next. Half-way between the two a series counts as algebraic.
_RISES = 1.0
# Steep ends of series look steeper than they are: k^-3 is the steepest seen. Slower than k^-1/2 is
# no trend.
_STEEPEST, _SLOWEST = 3.0, 0.5
# Drifts that vanish leave as much as themselves, to the trend's own error; those of ratcheting next
# to nothing.
_DRIFT, _FAR = 1e-3, 3.0


@dataclass(frozen=True)
class Trend:
    """What is left of a series after its last value.

    Attributes
    ----------
    kind : "steady" (the last two values are the same to round-off), "geometric", "algebraic", or
        "unclear": fewer than four values, or differences that do not fall
    left : limit minus the last value; of an unclear one k |d_k|, which is a size without a sign, or
    NaN of a single value limit : of the series, NaN of an unclear one
    """

    kind: str
    left: float
    limit: float


def trend(values: Sequence[float]) -> Trend:
    """The trend of a series by its last four values, one a revolution from the first one on.

    >>> trend([5.0, 3.0, 2.5, 2.375]).kind, trend([1.5, 1.25, 1.125, 1.0625])
    ('geometric', Trend(kind='geometric', left=-0.0625, limit=1.0))
    """
    k, apart = len(values), np.diff(values).tolist()
    if k < 2:
        return Trend("unclear", float("nan"), float("nan"))
    last = apart[-1]
    if k * abs(last) <= _SAME * max(map(abs, values)):
        return Trend("steady", 0.0, values[-1])
    unclear = Trend("unclear", k * abs(last), float("nan"))
    if k < 4 or not all(apart[-3:]):
        return unclear
    before, ratio = apart[-2] / apart[-3], apart[-1] / apart[-2]
    if not (0 < before < 1 and 0 < ratio < 1):
        return unclear
    if ratio <= before * (1 + _RISES / (k * (k - 2))):
        left = last * ratio / (1 - ratio)
        return Trend("geometric", left, values[-1] + left)
    power = min(float(np.log(ratio) / np.log((k - 1.5) / (k - 0.5))) - 1, _STEEPEST)
    if power < _SLOWEST:
        return unclear
    left = last / ((k / (k - 1)) ** power - 1)
    return Trend("algebraic", left, values[-1] + left)


def ratchets(drifts: Sequence[float], travel: float) -> bool:
    """Whether U goes on drifting: the last of its changes from start to end of each revolution is
    no step on a way to zero.

    Parameters
    ----------
    drifts : one a revolution
    travel : largest minus smallest U of the last revolution; a thousandth of it is no drift

    >>> ratchets([0.3, 0.11, 0.1, 0.1], 1.0), ratchets([0.4, 0.2, 0.1, 0.05], 1.0)
    (True, False)
    """
    last = abs(drifts[-1])
    return last > _DRIFT * travel and last > _FAR * abs(trend(drifts).left)


@dataclass(eq=False)
class PathRun:
    """What a load path left behind; the first of `states` is the unloaded one.

    A path of straight legs with more than `MOST_INSTANTS` increments is thinned while it is
    followed. The dropped states are left without pressure, shear and gap. Between the rows every
    second, fourth, ... state stays; of the rows too, where these alone are too many.

    Attributes
    ----------
    states : (n_steps + 1)
    bounded : whether states may be dropped
    blocks : energies (but for those of each node) and checks by name, (k,) of the k increments of
    each stretch iterations : (n_steps), of each increment
    density : (n,) dissipation of each node in the revolution so far
    cycle_starts : index of the state at which each revolution starts
    cycle_density : per revolution, (n,) dissipation of each node; one for the whole path where it
    is not periodic excess : per revolution, what edges between nodes would add to it
    steady_from : index of the first revolution that ended as it started, with what is left of the
        dissipation's way within its uncertainty
    cycle_change : per revolution, largest change of a nodal p or q/f (f < 1) from its start to its
    end, over the largest p failure : what stopped the run, or None
    """

    states: list[InterfaceState]
    bounded: bool = False
    blocks: list[dict[str, Array]] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    density: Array = field(default_factory=lambda: np.zeros(0))
    cycle_starts: list[int] = field(default_factory=list)
    cycle_density: list[Array] = field(default_factory=list)
    excess: list[Excess] = field(default_factory=list)
    steady_from: int | None = None
    cycle_change: list[float] = field(default_factory=list)
    failure: ConvergenceError | Interrupted | None = None
    # States at the ends of stretches by number, that of the largest P, how many are whole, and of
    # which every so many-th stays.
    _corners: dict[int, int] = field(default_factory=dict)
    _largest: int = 0
    _whole: int = 1
    _stride: int = 1
    _corner_stride: int = 1

    def column(self, name: str) -> Array:
        """(n_steps,) one energy or check of all increments."""
        return (
            np.concatenate([block[name] for block in self.blocks]) if self.blocks else np.zeros(0)
        )

    @property
    def trend(self) -> Trend:
        """Where the dissipation of the revolutions goes."""
        if self.cycle_change and self.cycle_change[-1] <= _EQUAL:
            return Trend("steady", 0.0, float(self.cycle_density[-1].sum()))
        return trend([float(density.sum()) for density in self.cycle_density])

    @property
    def ratchets(self) -> bool:
        """Whether each revolution leaves the upper body further along by the same distance."""
        ends = [self.states[index].shift for index in (*self.cycle_starts, len(self.states) - 1)]
        # the last one failed, or the path does not repeat
        if len(self.cycle_change) < len(self.cycle_starts) or len(ends) < 2:
            return False
        drifts = np.diff(ends).tolist()
        travel = float(np.ptp([state.shift for state in self.states[self.cycle_starts[-1] :]]))
        return ratchets([drifts[-1]] * 2 if self.cycle_change[-1] <= _EQUAL else drifts, travel)

    @property
    def kept(self) -> Indices:
        """Indices of the states that are whole, the first and the last among them."""
        return np.flatnonzero([state.is_complete for state in self.states])

    def take(
        self,
        problem: ContactProblem,
        increments: Sequence[Increment],
        leg: LoadSegment,
        units: tuple[float, ...],
    ) -> None:
        """Add the increments of a stretch with their energies and checks; all of them or, where
        Ctrl-C comes in between, none.
        """
        if not increments:
            return
        states = [self.states[-1], *(one.state for one in increments)]
        area = enclosed(leg, np.array([state.time for state in states]))
        if area is not None:
            area = area / np.multiply.outer(units[: len(area)], units[: len(area)])[:, :, None]
        energies = vars(
            increment_energies(problem, states, [one.solved for one in increments], area)
        ).copy()
        nodes = energies.pop("dissipation")
        block = certificates(problem, states) | energies | {"dissipation": nodes.sum(axis=1)}
        vars(self).update(
            states=self.states + states[1:],
            blocks=[*self.blocks, block],
            iterations=self.iterations + [one.iterations for one in increments],
            density=self.density + nodes.sum(axis=0),
        )
        if self.bounded:
            self._thin(len(self.states) - len(states))

    def close_cycle(self, found: Excess) -> None:
        """End a revolution and take off what edges between nodes add to its dissipation, of
        increments and nodes in proportion.
        """
        work = float(self.density.sum())
        share = 1 - found.value / work if work > 0 else 1.0
        first, end = self.cycle_starts[-1], len(self.iterations)
        for number in reversed(range(len(self.blocks))):
            block, end = self.blocks[number], end - len(self.blocks[number]["loop"])
            if end < first:
                break
            self.blocks[number] = block | {
                name: block[name] * share for name in ("dissipation", "loop")
            }
        self.cycle_density.append(self.density * share)
        self.excess.append(found)

    def _thin(self, before: int) -> None:
        """Drop states since that one, or others, where too many are whole; the last is the history
        of the next increment.
        """
        # a turning point, a vertex of a polygon, a row of a record
        self._corners[len(self.states) - 1] = len(self._corners)
        for index in range(before, len(self.states) - 1):
            if self.states[index].normal_load > self.states[self._largest].normal_load:
                self._largest = index
            if self._drop(index):
                continue
            self._whole += 1
            while self._whole > MOST_INSTANTS and max(self._stride, self._corner_stride) < len(
                self.states
            ):
                # Three quarters of the room are for the ends of the stretches.
                if 4 * len(self._corners) > 3 * MOST_INSTANTS * self._corner_stride:
                    self._corner_stride *= 2
                else:
                    self._stride *= 2
                self._whole -= sum(
                    self._drop(int(earlier)) for earlier in self.kept[:-1] if earlier <= index
                )

    def _drop(self, index: int) -> bool:
        """Whether this state is not to be kept; if so, it is whole no more. The largest P and the
        ends of the last cycle stay.
        """
        if index in (0, self._largest, *self.cycle_starts[-2:]):
            return False
        number = self._corners.get(index)
        if (index % self._stride if number is None else number % self._corner_stride) == 0:
            return False
        state = self.states[index]
        self.states[index] = replace(state, values=freeze(state.values[: 3 + len(state.state)]))
        return True


@dataclass(frozen=True)
class Pace:
    """How finely a path is stepped.

    Attributes
    ----------
    load : what loads are divided by
    steps_per_cycle : regular increments of one revolution, or of the longest leg of a polygon
    step_tolerance : step error of a revolution over its dissipation that calls for shorter
    increments half_width, modulus : units of length and of stress, with `load` those of bulk
    stress, tilt and moment dissipation : expected of a revolution, scaled; 0 if unknown
    """

    load: float
    steps_per_cycle: int
    step_tolerance: float
    half_width: float = 1.0
    modulus: float = 1.0
    dissipation: float = 0.0

    def units(self, moment_given: bool) -> tuple[float, ...]:
        """What each of the five loads of `path` is divided by."""
        stress = self.load / self.half_width
        return (
            self.load,
            self.load,
            stress,
            stress,
            self.load * self.half_width if moment_given else stress / self.modulus,
        )


def run_path(
    problem: ContactProblem,
    path: LoadPath,
    pace: Pace,
    cycles: int,
    progress: Progress,
    *,
    uncertainty: Callable[[PathRun], float] = lambda _run: np.inf,
    keep_all: bool = False,
) -> PathRun:
    """Follow `path` for at most `cycles` revolutions; stop once a revolution repeats; `keep_all`
    states of a long path.

    A revolution repeats where its nodal forces do, and what is left of the dissipation's way is
    less than the `uncertainty` that its mesh and steps give it (scaled; where that is unknown, NaN:
    `REPEATS` of itself).

    Neither a ConvergenceError nor Ctrl-C gets lost: it ends the run and is kept in `failure` with
    everything solved before it.
    """
    # Thinned only where theory on the straight steps between the instants is theory on the path
    # itself, whichever of them are kept.
    bounded = not keep_all and all(straight(leg) for leg in (*path.initial_loading, *path.cycle))
    run = PathRun([_at_rest(problem, path, pace)], bounded=bounded)
    try:
        _follow_legs(
            problem,
            run,
            path.initial_loading,
            pace.steps_per_cycle / 8,
            pace,
            progress,
            "initial loading",
        )
        if path.period is None:
            run.cycle_density.append(run.density)
            return run
        for number in range(cycles):
            before = run.states[-1]
            run.cycle_starts.append(len(run.iterations))
            _follow_legs(
                problem,
                run,
                path.cycle_legs(number),
                pace.steps_per_cycle,
                pace,
                progress,
                f"revolution {number + 1}",
            )
            run.close_cycle(excess(problem, run.states[run.cycle_starts[-1] :]))
            run.cycle_change.append(_change(before, run.states[-1], problem.friction))
            if run.cycle_change[-1] <= REPEATS:
                least = REPEATS * float(run.density.sum())
                if abs(run.trend.left) <= np.nan_to_num(uncertainty(run), nan=least, posinf=np.inf):
                    run.steady_from = number
                    break
    except ConvergenceError as failure:
        run.failure = failure
    except KeyboardInterrupt:
        run.failure = Interrupted(
            f"interrupted at time {run.states[-1].time:.6g}, after {len(run.iterations)} steps"
        )
    return run


def _at_rest(problem: ContactProblem, path: LoadPath, pace: Pace) -> InterfaceState:
    """The unloaded state; a line of action is where the resultant is soon after."""
    leg, units = path.initial_loading[0], pace.units(problem.moment_given)
    normal_load, *_, moment = scaled_loads(leg, leg.start + _SOON * (leg.end - leg.start), units)
    line = moment / normal_load if problem.moment_given and normal_load > 0 else 0.0
    return problem.at_rest(path.start, scaled_loads(leg, path.start, units), line)


def _follow_legs(
    problem: ContactProblem,
    run: PathRun,
    legs: tuple[LoadSegment, ...],
    steps: float,
    pace: Pace,
    progress: Progress,
    text: str,
) -> None:
    longest = max(leg.end - leg.start for leg in legs)
    pieces = [
        piece
        for leg in legs
        for piece in stretches(leg, problem.friction, steps * (leg.end - leg.start) / longest)
    ]
    duration, units = legs[-1].end - legs[0].start, pace.units(problem.moment_given)
    run.density = np.zeros_like(problem.height)
    # What the tolerance refers to: the dissipation of the revolution before, or the one expected,
    # or a share of f^2 P^2/E*.
    unit = max(problem.friction**2, 1e-300)
    expected = (
        float(run.cycle_density[-1].sum()) if run.cycle_density else pace.dissipation
    ) / unit
    # Rounded down to a power of two: what the initial loading left in the revolution before shall
    # not choose other increments. In units of f^2: Q in proportion to f has the same increments,
    # whatever f is.
    reference = max(2.0 ** np.floor(np.log2(max(expected, 1e-300))), _LEAST_DISSIPATION) * unit

    def allowed(time: float) -> float:
        return pace.step_tolerance * reference * time / duration

    def said() -> str:
        return (
            f"{text}, {len(run.iterations)} steps, {problem.work['contact iterations']} contact"
            " iterations"
        )

    for done, piece in enumerate(pieces):
        progress(done, len(pieces), said())
        found: list[Increment] = []
        try:
            found += follow(problem, run.states[-1], piece, units, allowed)
        finally:
            run.take(problem, found, piece.leg, units)
    progress(len(pieces), len(pieces), said())


def _change(before: InterfaceState, after: InterfaceState, friction: float) -> float:
    """Largest change of a nodal p, or of a nodal q over f, over the largest p: with little friction
    all of q is little.
    """
    pressure, shear = (
        np.abs(getattr(after, name) - getattr(before, name)).max() for name in ("pressure", "shear")
    )
    return float(
        max(pressure, shear / min(friction, 1.0) if shear > 0 else 0.0) / np.max(after.pressure)
    )
