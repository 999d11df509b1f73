"""Where on the scene's load path the instants of a foreign result lie: by its times, else by its
loads, else by its resultants.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.surface import SurfaceResult
from scenes import InputError, LoadPath, Scene, freeze

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Loads = tuple[Array, Array]

# Largest distance in the plane of P and Q, over the largest P of the path: of loads as the file
# states them, printed to some digits; and of resultants, which the trapezoidal rule takes from the
# pressures of a mesh of perhaps ten elements.
_STATED, _INTEGRATED = 0.005, 0.05
_CORRECTIONS = 2  # of the trapezoidal rule: the first leaves a sixtieth of what it misses
_PRINTED_TIME = 1e-5  # of a cycle: times printed to six digits miss its ends by less
_PRINTED_LOAD = 1e-5  # of the largest load: those printed to six digits miss one another by less
_SAMPLES = 720  # of a revolution and of the initial loading
_SAME = 1e-6  # over the largest P: places as near as that are equally near
_PLACES = 64  # at which one instant may lie
# Costs of a place, over that of a mean step, and for each revolution gone ahead among equal
# matches; a step back by so small a part of a revolution costs as much as a mean step ahead.
_DISTANCE, _AHEAD, _BACK = 1e3, 1e-9, 3000.0


@dataclass(frozen=True, eq=False)
class History:
    """Times of the scene's path, (n_steps,), with P and Q there, sentences on how they were found,
    and what was guessed.

    `either_sign`: the shear itself told the instants, and turned round it would have told others,
    as well.
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    notes: tuple[str, ...]
    guess: str = ""
    either_sign: bool = False


def resultants(result: SurfaceResult) -> Loads:
    """int p dx and int q dx by the trapezoidal rule, (n_steps,) each [force / thickness]."""
    normal, tangential = (
        np.asarray(np.trapezoid(field, result.x, axis=1))
        for field in (result.pressure, result.shear)
    )
    return normal, tangential


def without_tangential_load(scene: Scene) -> bool:
    """Whether Q is 0 throughout the path of the scene, so that P alone says which instant is
    which.
    """
    path = scene.load.path()
    normal, tangential = path.at(_samples(path, 1))
    return float(np.max(np.abs(tangential))) <= _SAME * float(np.max(normal))


def matched(result: SurfaceResult, scene: Scene, *, sure_of_times: bool = True) -> History:
    """The instants of `result` on the path of `scene`.

    Times that nobody vouches for (a solver's own, counted from 0 in each step) are given up where
    they can't be the scene's and the loads or the tractions tell better.

    Raises
    ------
    InputError
        Naming the first instant that is not on the path in this order, with both loads there.
    """
    if result.time is not None:
        try:
            return _by_time(result, result.time, scene)
        except InputError as fault:
            if sure_of_times:
                raise
            try:
                other = matched(replace(result, time=None), scene)
            except InputError:
                raise fault from None
            why = str(fault).removeprefix(f"{result.source}: ").split(";", maxsplit=1)[0]
            return replace(
                other,
                guess=(
                    f"the file's times can't be those of the scene's path and were not used ({why})"
                ),
            )
    if result.normal_load is not None and result.tangential_load is not None:
        return _by_loads(
            result,
            scene,
            (result.normal_load, result.tangential_load),
            _STATED,
            "the loads that it states",
        )
    return _by_resultants(result, scene)


def _by_resultants(result: SurfaceResult, scene: Scene) -> History:
    """By the integrals of the tractions, less what the trapezoidal rule misses of theory at the
    instants so found.
    """
    import semi_analytic

    by = "the integrals of its pressure and shear over x"
    alone = not result.sheared
    if alone and not without_tangential_load(scene):
        raise InputError(
            f"{result.source}: without a shear the pressure alone does not say which instant is"
            " which: state the times of the scene's path, by a column or by times of a mapping, or"
            " P and Q"
        )
    if alone:
        by = "the integral of its pressure over x, with Q = 0 as throughout the scene"
        result = replace(result, shear=freeze(np.zeros_like(result.pressure)))
    normal, tangential = resultants(result)
    normal, integrated = (normal, 1.0) if result.normal_load is None else (result.normal_load, 0.0)

    def turned(sense: float, words: str) -> History | None:
        try:
            return _by_loads(result, scene, (normal, sense * tangential), _INTEGRATED, words)
        except InputError:
            return None

    sense = 1.0
    try:
        found = _by_loads(result, scene, (normal, tangential), _INTEGRATED, by)
    except InputError:
        # Shear on the other body: matched all the same, scored as it is, and named by the oddities.
        sense, other = -1.0, turned(-1.0, f"{by}, the latter turned")
        if other is None:
            raise
        found = other
    for _ in range(_CORRECTIONS):
        theory = semi_analytic.solve(
            scene, x=result.x, time=found.time, fields=("pressure", "shear")
        )
        own = (np.trapezoid(field, result.x, axis=1) for field in (theory.pressure, theory.shear))
        missed = [
            integral - load
            for integral, load in zip(own, (found.normal_load, found.tangential_load), strict=True)
        ]
        loads = normal - integrated * missed[0], sense * tangential - missed[1]
        found = _by_loads(
            result, scene, loads, _INTEGRATED, f"{by}, less what that misses of theory"
        )
    sheared = float(np.max(np.abs(tangential))) > _INTEGRATED * float(np.max(normal))
    return replace(found, either_sign=sheared and turned(-sense, by) is not None)


def _by_time(result: SurfaceResult, stated: Array, scene: Scene) -> History:
    path = scene.load.path()
    last = (
        path.initial_loading[-1].end
        if path.period is None
        else path.cycle_start + scene.cycles * path.period
    )
    time = _snapped(stated, path, scene)
    if np.any(np.diff(time) <= 0):
        step = int(np.flatnonzero(np.diff(time) <= 0)[0]) + 1
        raise InputError(
            f"{result.source}: time does not ascend: instant {step + 1} is at {time[step]:.9g}"
            f" after {time[step - 1]:.9g}"
        )
    beyond = np.flatnonzero((time < path.start) | (time > last))
    if len(beyond):
        rounds = f" in {scene.cycles} cycles" if path.period is not None else ""
        raise InputError(
            f"{result.source}: instant {beyond[0] + 1} is at time {time[beyond[0]]:.6g}, outside"
            f" the scene's path, which goes from {path.start:.6g} to {last:.6g}{rounds}; state each"
            " instant's time there by the key times of a mapping"
        )
    normal, tangential = path.at(time)
    # At the times stated, loads stated must be the scene's, and so must the integral of the
    # pressure.
    size = float(np.max(normal)) or 1.0
    for name, own, theirs, limit in (
        ("P", result.normal_load, normal, _STATED),
        ("Q", result.tangential_load, tangential, _STATED),
        ("the integral of the pressure", resultants(result)[0], normal, 4 * _INTEGRATED),
    ):
        if own is not None and np.any(np.abs(own - theirs) > limit * size):
            step = int(np.flatnonzero(np.abs(own - theirs) > limit * size)[0])
            raise InputError(
                f"{result.source}: its history is not the scene's: at instant {step + 1}, time"
                f" {time[step]:.6g}, {name} is {own[step]:.6g} and the scene's"
                f" {theirs[step]:.6g}{_constant_ratio(own, theirs, size)}"
            )
    return History(
        time, normal, tangential, ("its instants were matched by the times that it states",)
    )


def _snapped(time: Array, path: LoadPath, scene: Scene) -> Array:
    """Times put on the ends of legs (where loads turn, where cycles end) that they miss by less
    than `_PRINTED_TIME` of a cycle.
    """
    ends = np.array([path.start, *(leg.end for leg in path.legs(scene.cycles))])
    close = (path.period or ends[-1] - ends[0]) * _PRINTED_TIME
    after = np.clip(np.searchsorted(ends, time), 1, len(ends) - 1)
    nearest = np.where(time - ends[after - 1] < ends[after] - time, ends[after - 1], ends[after])
    return np.where(np.abs(time - nearest) <= close, nearest, time)


def _constant_ratio(own: Array, theirs: Array, size: float) -> str:
    """What to do, if all figures differ by one factor."""
    loaded = np.abs(theirs) > 0.01 * size
    if not loaded.any():
        return ""
    ratio = own[loaded] / theirs[loaded]
    if np.ptp(ratio) > 0.01 * abs(ratio[0]) or abs(ratio[0] - 1) < 0.01 or ratio[0] == 0:
        return ""
    hint = (
        "the other sign?"
        if ratio[0] < 0
        else "a thickness of that size (thickness), other units (factors), or half a model?"
    )
    return f", {ratio[0]:.4g} times as much at every instant: {hint}"


# --------------------------------------------------------------------------- by the loads, in order
def _by_loads(result: SurfaceResult, scene: Scene, loads: Loads, limit: float, by: str) -> History:
    """In order along the path; where every instant lies on the cycle, in its last one."""
    path = scene.load.path()
    size = float(np.max(path.at(_samples(path, 1))[0]))
    if np.max(loads[0]) <= _STATED * size:
        raise InputError(
            f"{result.source}: its largest P is {np.max(loads[0]):.4g} (from {by}) and the scene's"
            f" {size:.4g}: too little to tell its instants by; see to thickness and factors of the"
            " mapping, or state the times"
        )
    best: tuple[float, Array] | None = None
    for times in _windows(path, scene):
        found = _in_order(times, path, scene, loads, size)
        off = float(np.max(_distance(path, found, loads))) / size
        if best is None or off < best[0]:
            best = off, found
        if off <= limit:
            break
    assert best is not None
    off, time = best
    time = _closed(time, scene, loads, off * size)
    normal, tangential = path.at(time)
    if off > limit:
        step = int(np.flatnonzero(_distance(path, time, loads) / size > limit)[0])
        raise InputError(
            f"{result.source}: its history is not the scene's: at instant {step + 1} P ="
            f" {loads[0][step]:.6g} and Q = {loads[1][step]:.6g} (from {by}), and the nearest that"
            f" the scene's path has, in order, is P = {normal[step]:.6g} and Q ="
            f" {tangential[step]:.6g} at time"
            f" {time[step]:.6g}{_constant_ratio(loads[0], normal, size)}"
        )
    notes = [
        f"its instants were matched to the load path by {by}; the farthest is {off:.1e} of the"
        " largest P away"
    ]
    if (
        path.period is not None
        and time[0] >= path.cycle_start + (scene.cycles - 2) * path.period - 1e-9
    ):
        what = "the instant lies" if len(time) == 1 else "all instants lie"
        notes.append(
            f"{what} on the cycle, which comes back: one of the last of {scene.cycles} cycles was"
            " taken, the steady state; if it is an earlier one, state the times"
        )
    if path.period is None and len(time) > 1:
        notes.append(
            "where the path passes the same loads more than once between two instants, the wrong"
            " pass may have been taken"
        )
    return History(time, normal, tangential, tuple(notes))


def _closed(time: Array, scene: Scene, loads: Loads, apart: float) -> Array:
    """Times of which the last is a whole period after an earlier one, where its loads are the same.

    Next to a turning point a small error of a load is a large one of the time. Loads are the same
    where they differ by no more than the instants lie `apart` from the path, or by what six
    printed digits leave open [force / thickness].
    """
    path = scene.load.path()
    if path.period is None or len(time) < 3:
        return time
    earlier = int(np.argmin(np.abs(time[:-1] - (time[-1] - path.period))))
    closed = time[earlier] + path.period
    across = loads[0][-1] - loads[0][earlier]
    up = loads[1][-1] - loads[1][earlier]
    printed = _PRINTED_LOAD * float(np.max(np.abs(loads)))
    same = np.hypot(across, up) <= max(2 * apart, printed)
    step = time[-1] - time[-2]
    end_of_path = path.cycle_start + scene.cycles * path.period
    if not same or not time[-2] < closed <= end_of_path or abs(time[-1] - closed) > step / 2:
        return time
    return np.append(time[:-1], closed)


def _windows(path: LoadPath, scene: Scene) -> Iterator[Array]:
    """Times among which instants are looked for: the last cycle, then the whole path."""
    if path.period is not None:
        start = path.cycle_start + (scene.cycles - 1) * path.period
        # Twice round, so that a loop that starts elsewhere finds its end; the second is the first
        # again.
        yield start + path.period * np.linspace(-min(1, scene.cycles - 1), 1, 2 * _SAMPLES + 1)
    yield _samples(path, scene.cycles)


def _samples(path: LoadPath, cycles: int) -> Array:
    legs = list(path.legs(cycles if path.period is not None else 1))
    count = max(_SAMPLES * (cycles + 1) // len(legs), 8)
    return np.unique(np.concatenate([np.linspace(leg.start, leg.end, count) for leg in legs]))


def _in_order(times: Array, path: LoadPath, scene: Scene, loads: Loads, size: float) -> Array:
    """Ascending times, (n_steps,), among `times` (n,): of the places where the path is near to each
    load, those that cost least.

    A place costs the square of its distance, over that of the instant that lies farthest from the
    path, `_DISTANCE` times; a step the square of its length over the mean one. So of places that
    are equally near, to and fro on one line or in one revolution after another, the evenest are
    taken: two instants alike on both sides of a turn of the loads are one on each side. Noise next
    to a turn may put an instant before the last one, by a small part of a revolution.
    """
    normal, tangential = path.at(times)
    squares = [_squares(normal - p, tangential - q) / size**2 for p, q in zip(*loads, strict=True)]
    noise, whole = max(float(square.min()) for square in squares) + _SAME**2, times[-1] - times[0]
    mean, back = whole / len(squares), (path.period or whole) / _BACK
    places = [_nearest(square) for square in squares]
    cost, came = _AHEAD * (times[places[0]] - times[0]) / whole, list[Places]()
    for k, place in enumerate(places):
        if k:
            step = times[place] - times[places[k - 1]][:, None]
            total = cost[:, None] + (step / np.where(step < 0, back, mean)) ** 2
            came.append(np.argmin(total, axis=0))
            cost = np.min(total, axis=0)
        cost = cost + _DISTANCE * squares[k][place] / noise
    taken = [int(np.argmin(cost))]
    for way in reversed(came):
        taken.append(int(way[taken[-1]]))
    chosen = np.array([place[k] for place, k in zip(places, reversed(taken), strict=True)])
    return np.maximum.accumulate(_snapped(_refined(times, chosen, path, loads), path, scene))


def _nearest(squares: Array) -> Places:
    """The samples (k,) at which the squared distance is least among its neighbours, the `_PLACES`
    nearest of them.

    >>> _nearest(np.array([4.0, 1.0, 1.0, 4.0, 1.5])).tolist()
    [1, 4]
    """
    before, after = np.append(np.inf, squares[:-1]), np.append(squares[1:], np.inf)
    least = np.flatnonzero((squares < before) & (squares <= after))
    return np.sort(least[np.argsort(squares[least], kind="stable")[:_PLACES]])


def _chords(across: Array, up: Array) -> tuple[Array, Array]:
    """Of the chords between neighbouring samples (..., n), counted from the origin: where its foot
    lies on each, as a share of the chord, and its squared distance, (..., n - 1) each.
    """
    along, aside = np.diff(across), np.diff(up)
    length = along**2 + aside**2
    share = np.clip(
        -(across[..., :-1] * along + up[..., :-1] * aside) / np.where(length > 0, length, 1.0),
        0.0,
        1.0,
    )
    return share, (across[..., :-1] + share * along) ** 2 + (up[..., :-1] + share * aside) ** 2


def _squares(across: Array, up: Array) -> Array:
    """Squared distance of the origin from the path at each of its samples (n,): from the nearer of
    the chords that meet there.

    From the samples themselves it would be their luck on which of two branches, to and fro on one
    line, an instant lies.
    """
    chord = _chords(across, up)[1]
    return np.minimum(np.append(chord, chord[-1]), np.insert(chord, 0, chord[0]))


def _refined(times: Array, chosen: Places, path: LoadPath, loads: Loads) -> Array:
    """The nearest times between the neighbours of the samples `chosen`: the feet on chords ten
    times shorter, six times over.

    A foot misses the path's by the square of its chord; squares of distances alone are flat to 1e-8
    of a cycle around it.
    """
    time, rows = times[chosen], np.arange(len(chosen))
    low, high = times[np.maximum(chosen - 1, 0)], times[np.minimum(chosen + 1, len(times) - 1)]
    for _ in range(6):
        step = (high - low) / 20
        grid = low[:, None] + step[:, None] * np.arange(21)
        normal, tangential = path.at(grid)
        share, square = _chords(normal - loads[0][:, None], tangential - loads[1][:, None])
        at = np.argmin(square, axis=1)
        time = grid[rows, at] + share[rows, at] * step
        low, high = np.maximum(time - step, times[0]), np.minimum(time + step, times[-1])
    return time


def _distance(path: LoadPath, time: Array, loads: Loads) -> Array:
    normal, tangential = path.at(time)
    return np.hypot(normal - loads[0], tangential - loads[1])
