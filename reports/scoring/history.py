"""Where on the scene's load path the instants of a foreign result lie: by its times, else by its loads, else by its resultants."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.branches import evenest, places
from reports.scoring.guesses import resultants
from reports.scoring.surface import SurfaceResult
from scenes import InputError, LoadPath, Scene

Array = NDArray[np.float64]

# Largest distance in the plane of P and Q, over the largest P of the path: of loads as the file states them, printed to some
# digits; and of resultants, which the trapezoidal rule takes from the pressures of a mesh of perhaps ten elements.
STATED, INTEGRATED = 0.005, 0.05
CORRECTIONS = 2  # of the trapezoidal rule: the first leaves a sixtieth of what it misses
PRINTED_TIME = 1e-5  # of a cycle: times printed to six digits miss its ends by less
_SAMPLES = 720  # of a revolution and of the initial loading
_SAME = 1e-6  # over the largest P: places as near as that are equally near
_AHEAD = 1e-9  # of the squared distance, for each revolution gone ahead: among equal matches the earliest


@dataclass(frozen=True, eq=False)
class History:
    """Times of the scene's path, (n_steps,), with P and Q there, sentences on how they were found, and what was guessed.

    `either_sign`: the shear itself told the instants, and turned round it would have told others, as well.
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    notes: tuple[str, ...]
    guess: str = ""
    either_sign: bool = False


def matched(result: SurfaceResult, scene: Scene, *, sure_of_times: bool = True) -> History:
    """The instants of `result` on the path of `scene`.

    Times that nobody vouches for (a solver's own, counted anew in each step) are given up where they can't be the scene's and the
    loads or the tractions tell better.

    Raises
    ------
    InputError
        Naming the first instant that is not on the path in this order, with both loads there.
    """
    path = scene.load.path()
    if result.time is not None:
        try:
            return _by_time(result, path, scene)
        except InputError as fault:
            other = None if sure_of_times else _without_times(result, scene)
            if other is None:
                raise
            why = str(fault).removeprefix(f"{result.source}: ").split(";", maxsplit=1)[0]
            return replace(other, guess=f"the file's times can't be those of the scene's path and were not used ({why})")
    if result.normal_load is not None and result.tangential_load is not None:
        return _by_loads(result, path, scene, (result.normal_load, result.tangential_load), STATED, "the loads that it states")
    return _by_resultants(result, path, scene)


def _without_times(result: SurfaceResult, scene: Scene) -> History | None:
    try:
        return matched(replace(result, time=None), scene)
    except InputError:
        return None


def _by_resultants(result: SurfaceResult, path: LoadPath, scene: Scene) -> History:
    """By the integrals of the tractions, less what the trapezoidal rule misses of theory at the instants so found."""
    by, found = "the integrals of its pressure and shear over x", None
    normal, tangential = resultants(result)
    normal, integrated = (normal, 1.0) if result.normal_load is None else (result.normal_load, 0.0)
    sense = 1.0
    try:
        found = _by_loads(result, path, scene, (normal, tangential), INTEGRATED, by)
    except InputError:
        # Shear on the other body: matched all the same, scored as it is, and named by `oddities`.
        sense = -1.0
        found = _turned(result, path, scene, (normal, -tangential), f"{by}, the latter turned")
        if found is None:
            raise
    for _ in range(CORRECTIONS):
        missed = _missed(result, scene, found)
        loads = normal - integrated * missed[0], sense * tangential - missed[1]
        found = _by_loads(result, path, scene, loads, INTEGRATED, f"{by}, less what that misses of theory")
    told = float(np.max(np.abs(tangential))) > INTEGRATED * float(np.max(normal))
    other = _turned(result, path, scene, (normal, -sense * tangential), by) if told else None
    return replace(found, either_sign=other is not None)


def _turned(result: SurfaceResult, path: LoadPath, scene: Scene, loads: tuple[Array, Array], by: str) -> History | None:
    try:
        return _by_loads(result, path, scene, loads, INTEGRATED, by)
    except InputError:
        return None


def _missed(result: SurfaceResult, scene: Scene, found: History) -> tuple[Array, Array]:
    """What the trapezoidal rule makes of theory's tractions on the result's points, less the loads that these carry."""
    import semi_analytic

    theory = semi_analytic.solve(scene, x=result.x, time=found.time, fields=("pressure", "shear"))
    integrals = (np.trapezoid(field, result.x, axis=1) for field in (theory.pressure, theory.shear))
    normal, tangential = integrals
    return normal - found.normal_load, tangential - found.tangential_load


def _by_time(result: SurfaceResult, path: LoadPath, scene: Scene) -> History:
    assert result.time is not None
    time, first = result.time, path.start
    last = path.initial_loading[-1].end if path.period is None else path.cycle_start + scene.cycles * path.period
    time = _snapped(time, path, scene)
    if np.any(np.diff(time) <= 0):
        step = int(np.flatnonzero(np.diff(time) <= 0)[0]) + 1
        raise InputError(
            f"{result.source}: time does not ascend: instant {step + 1} is at {time[step]:.9g} after {time[step - 1]:.9g}"
        )
    beyond = np.flatnonzero((time < first) | (time > last))
    if len(beyond):
        rounds = f" in {scene.cycles} cycles" if path.period is not None else ""
        raise InputError(
            f"{result.source}: instant {beyond[0] + 1} is at time {time[beyond[0]]:.6g}, outside the scene's path, which goes from "
            f"{first:.6g} to {last:.6g}{rounds}; state each instant's time there by the key times of a mapping"
        )
    normal, tangential = path.at(time)
    _refuse_other_loads(result, time, normal, tangential)
    return History(time, normal, tangential, ("its instants were matched by the times that it states",))


def _snapped(time: Array, path: LoadPath, scene: Scene) -> Array:
    """Times put on the ends of legs (where loads turn, where cycles end) that they miss by less than `PRINTED_TIME` of a cycle."""
    ends = np.array([path.start, *(leg.end for leg in path.legs(scene.cycles))])
    close = (path.period or ends[-1] - ends[0]) * PRINTED_TIME
    after = np.clip(np.searchsorted(ends, time), 1, len(ends) - 1)
    nearest = np.where(time - ends[after - 1] < ends[after] - time, ends[after - 1], ends[after])
    return np.where(np.abs(time - nearest) <= close, nearest, time)


def _refuse_other_loads(result: SurfaceResult, time: Array, normal: Array, tangential: Array) -> None:
    """At the times stated, loads stated must be the scene's, and so must the integral of the pressure."""
    size = float(np.max(normal)) or 1.0
    named = (("P", result.normal_load, normal, STATED), ("Q", result.tangential_load, tangential, STATED))
    integral = ("the integral of the pressure", resultants(result)[0], normal, 4 * INTEGRATED)
    for name, own, theirs, limit in (*named, integral):
        if own is not None and np.any(np.abs(own - theirs) > limit * size):
            step = int(np.flatnonzero(np.abs(own - theirs) > limit * size)[0])
            raise InputError(
                f"{result.source}: its history is not the scene's: at instant {step + 1}, time {time[step]:.6g}, {name} is "
                f"{own[step]:.6g} and the scene's {theirs[step]:.6g}{_constant_ratio(own, theirs, size)}"
            )


def _constant_ratio(own: Array, theirs: Array, size: float) -> str:
    """What to do, if all figures differ by one factor."""
    loaded = np.abs(theirs) > 0.01 * size
    if not loaded.any():
        return ""
    ratio = own[loaded] / theirs[loaded]
    if np.ptp(ratio) > 0.01 * abs(ratio[0]) or abs(ratio[0] - 1) < 0.01 or ratio[0] == 0:
        return ""
    hint = "the other sign?" if ratio[0] < 0 else "a thickness of that size (thickness), other units (factors), or half a model?"
    return f", {ratio[0]:.4g} times as much at every instant: {hint}"


def _by_loads(result: SurfaceResult, path: LoadPath, scene: Scene, loads: tuple[Array, Array], limit: float, by: str) -> History:
    """In order along the path; where every instant lies on the cycle, in its last one."""
    size = float(np.max(path.at(_samples(path, 1, whole=True))[0]))
    if np.max(loads[0]) <= STATED * size:
        raise InputError(
            f"{result.source}: its largest P is {np.max(loads[0]):.4g} (from {by}) and the scene's {size:.4g}: too little to tell "
            "its instants by; see to thickness and factors of the mapping, or state the times"
        )
    best: tuple[float, Array] | None = None
    for times in _windows(path, scene):
        found = _in_order(times, path, scene, loads, size)
        off = _distance(path, found, loads) / size
        if off.max() <= limit:
            return _found(path, scene, found, float(off.max()), by, len(loads[0]))
        if best is None or off.max() < best[0]:
            best = float(off.max()), found
    assert best is not None
    off = _distance(path, best[1], loads) / size
    step = int(np.flatnonzero(off > limit)[0])
    normal, tangential = path.at(best[1])
    raise InputError(
        f"{result.source}: its history is not the scene's: at instant {step + 1} P = {loads[0][step]:.6g} and "
        f"Q = {loads[1][step]:.6g} (from {by}), and the nearest that the scene's path has, in order, is P = {normal[step]:.6g} and "
        f"Q = {tangential[step]:.6g} at time {best[1][step]:.6g}{_constant_ratio(loads[0], normal, size)}"
    )


def _windows(path: LoadPath, scene: Scene) -> Iterator[Array]:
    """Times among which instants are looked for: the last cycle, then the whole path."""
    if path.period is not None:
        start = path.cycle_start + (scene.cycles - 1) * path.period
        # Twice round, so that a loop that starts elsewhere finds its end; the second is the first again.
        yield start + path.period * np.linspace(-min(1, scene.cycles - 1), 1, 2 * _SAMPLES + 1)
    yield _samples(path, scene.cycles, whole=True)


def _samples(path: LoadPath, cycles: int, *, whole: bool) -> Array:
    legs = list(path.legs(cycles if path.period is not None else 1))
    count = max(_SAMPLES * (cycles + 1) // len(legs), 8) if whole else 8
    return np.unique(np.concatenate([np.linspace(leg.start, leg.end, count) for leg in legs]))


def _in_order(times: Array, path: LoadPath, scene: Scene, loads: tuple[Array, Array], size: float) -> Array:
    """Ascending times, (n_steps,), whose loads are nearest to `loads` in the sum of squares: dynamic programming, then refined."""
    normal, tangential = path.at(times)
    ahead = _AHEAD * (times - times[0]) / (times[-1] - times[0])
    steps, cost = [], np.zeros(len(times))
    for p, q in zip(*loads, strict=True):
        cost = cost + _squares(normal - p, tangential - q) / size**2
        # Least cost up to here, and where it was reached.
        least = np.minimum.accumulate(cost)
        where = np.maximum.accumulate(np.where(cost <= least, np.arange(len(times)), 0))
        steps.append(where)
        cost = least
    chosen = np.empty(len(steps), dtype=np.intp)
    chosen[-1] = steps[-1][int(np.argmin(cost + ahead))]
    for k in range(len(steps) - 2, -1, -1):
        chosen[k] = steps[k][chosen[k + 1]]

    def settled(picked: NDArray[np.intp]) -> tuple[Array, float]:
        time = np.maximum.accumulate(_snapped(_refined(times, picked, path, loads, size), path, scene))
        return time, float(np.max(_distance(path, time, loads))) / size

    found, off = settled(chosen)
    near = [places(_squares(normal - p, tangential - q) / size**2, off + _SAME) for p, q in zip(*loads, strict=True)]
    if (taken := evenest([times[place] for place in near])) is not None:
        even, farther = settled(np.array([place[k, 1] for place, k in zip(near, taken, strict=True)]))
        found = even if farther <= off + _SAME else found
    return found


def _squares(across: Array, up: Array) -> Array:
    """Squared distance of the origin from the path at each of its samples (n,): from the nearer of the chords that meet there.

    From the samples themselves it would be their luck on which of two branches, to and fro on one line, an instant lies.
    """
    along, aside = np.diff(across), np.diff(up)
    length = along**2 + aside**2
    foot = -(across[:-1] * along + up[:-1] * aside) / np.where(length > 0, length, 1.0)
    share = np.clip(foot, 0.0, 1.0)
    chord = (across[:-1] + share * along) ** 2 + (up[:-1] + share * aside) ** 2
    return np.minimum(np.append(chord, chord[-1]), np.insert(chord, 0, chord[0]))


def _refined(times: Array, chosen: NDArray[np.intp], path: LoadPath, loads: tuple[Array, Array], size: float) -> Array:
    """The nearest times between the neighbours of the samples `chosen`: ten times finer, twelve times over."""
    low, high = times[np.maximum(chosen - 1, 0)], times[np.minimum(chosen + 1, len(times) - 1)]
    first, last = times[0], times[-1]
    best = times[chosen]
    for _ in range(12):
        grid = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 21)
        normal, tangential = path.at(grid)
        away = ((normal - loads[0][:, None]) ** 2 + (tangential - loads[1][:, None]) ** 2) / size**2
        best = grid[np.arange(len(grid)), np.argmin(away, axis=1)]
        step = (high - low) / 20
        low, high = np.maximum(best - step, first), np.minimum(best + step, last)
    return _polished(best, path, loads, (float(first), float(last)))


def _polished(time: Array, path: LoadPath, loads: tuple[Array, Array], ends: tuple[float, float]) -> Array:
    """Newton's steps to the foot on the path: squares of distances are flat to 1e-8 of a cycle around it, their slopes are not."""
    reach = 1e-5 * (ends[1] - ends[0])
    for _ in range(3):
        low, high = np.maximum(time - reach, ends[0]), np.minimum(time + reach, ends[1])
        (p0, q0), (p1, q1), (p, q) = path.at(low), path.at(high), path.at(time)
        across, up = (p1 - p0) / (high - low), (q1 - q0) / (high - low)
        square = across**2 + up**2
        step = np.where(square > 0, ((loads[0] - p) * across + (loads[1] - q) * up) / np.where(square > 0, square, 1.0), 0.0)
        moved = np.clip(time + np.clip(step, -reach, reach), *ends)
        time = np.where(_distance(path, moved, loads) <= np.hypot(p - loads[0], q - loads[1]), moved, time)
    return np.asarray(time)


def _distance(path: LoadPath, time: Array, loads: tuple[Array, Array]) -> Array:
    normal, tangential = path.at(time)
    return np.hypot(normal - loads[0], tangential - loads[1])


def _found(path: LoadPath, scene: Scene, time: Array, off: float, by: str, count: int) -> History:
    notes = [f"its instants were matched to the load path by {by}; the farthest is {off:.1e} of the largest P away"]
    if path.period is not None and time[0] >= path.cycle_start + (scene.cycles - 2) * path.period - 1e-9:
        what = "the instant lies" if count == 1 else "all instants lie"
        notes.append(
            f"{what} on the cycle, which comes back: one of the last of {scene.cycles} cycles was taken, the steady state; "
            "if it is an earlier one, state the times"
        )
    if path.period is None and count > 1:
        notes.append("where the path passes the same loads more than once between two instants, the wrong pass may have been taken")
    normal, tangential = path.at(time)
    return History(time, normal, tangential, tuple(notes))
