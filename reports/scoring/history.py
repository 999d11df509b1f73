"""Where on the scene's load path the instants of a foreign result lie: by its times, else by its
loads, else by its resultants.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.surface import SurfaceResult
from scenes import InputError, LoadPath, Scene, read_only_copy
from scenes.array_types import Array

Places = NDArray[np.intp]
Loads = tuple[Array, Array]

# Largest distance in the plane of P and Q, over the largest P of the path: of loads as the file
# states them, printed to some digits; and of resultants, which the trapezoidal rule takes from the
# pressures of a mesh of perhaps ten elements.
_LARGEST_MISFIT_OF_LOADS = 0.005
_LARGEST_MISFIT_OF_SUMS = 0.05
# Times that are stated for certain are believed where the pressures add up to 3 P and less: a wrong
# thickness or scale is then found by its cause. Others must agree better.
_LARGEST_MISFIT_AT_SURE_TIMES = 2.0
_LARGEST_MISFIT_AT_UNSURE_TIMES = 4 * _LARGEST_MISFIT_OF_SUMS
_N_CORRECTIONS = 2  # of the trapezoidal rule: the first leaves a sixtieth of what it misses
_ERROR_OF_PRINTED_TIME = 1e-5  # of a cycle: times printed to six digits miss its ends by less
_ERROR_OF_PRINTED_LOAD = 1e-5  # of the largest load, as of six digits
_N_SAMPLES = 720  # of a revolution and of the initial loading
_EQUAL_DISTANCE = 1e-6  # over the largest P: places as near as that are equally near
_MOST_PLACES = 64  # at which one instant may lie
# Costs of a place, over that of a mean step, and for each revolution gone ahead among equal
# matches; a step back by so small a part of a revolution costs as much as a mean step ahead.
_COST_OF_DISTANCE = 1e3
_COST_OF_A_CYCLE_AHEAD = 1e-9
_DIVISOR_OF_STEP_BACK = 3000.0


@dataclass(frozen=True, eq=False)
class History:
    """Where the instants of a result lie on the scene's load path.

    Attributes
    ----------
    time
        (n_steps,) times on the path
    normal_load, tangential_load
        (n_steps,) P and Q of the path there [force / thickness]
    notes
        sentences on how the times were found
    guess_in_words
        a sentence where the times of the file were not used; else empty
    has_either_sign
        whether the times follow from the shear, and with its sign changed it would lie on the path
        as well
    """

    time: Array
    normal_load: Array
    tangential_load: Array
    notes: tuple[str, ...]
    guess_in_words: str = ""
    has_either_sign: bool = False


def resultants(surface: SurfaceResult) -> Loads:
    """int p dx and int q dx by the trapezoidal rule, (n_steps,) each [force / thickness]."""
    normal_force = np.trapezoid(surface.pressure, surface.x, axis=1)
    tangential_force = np.trapezoid(surface.shear, surface.x, axis=1)
    return np.asarray(normal_force), np.asarray(tangential_force)


def has_no_tangential_load(scene: Scene) -> bool:
    """Whether the tangential load Q is 0 throughout the load path of a scene, below a millionth of
    the largest P. Then P alone tells the instants of a result apart.
    """
    path = scene.load.path()
    normal_load, tangential_load = path.at(_sample_times(path, 1))
    return float(np.max(np.abs(tangential_load))) <= _EQUAL_DISTANCE * float(np.max(normal_load))


def history_of_result(
    surface: SurfaceResult, scene: Scene, *, sure_of_times: bool = True
) -> History:
    """Find the instants of an external result (`surface`) on the load path of a scene: by its
    times, else by the loads that it states, else by the integrals of its tractions. Times, loads
    and shear are None where the file does not state them.

    `sure_of_times` False means that the times may be a solver's own, such as counted from 0 in each
    step. They are then given up where they can't be the scene's and the loads or the tractions fit
    better, and a sentence says so.

    Raises
    ------
    InputError
        Naming the first instant that is not on the path in this order, with both loads there. Also
        where the file has too little to find its instants by: no shear, or hardly any P.

    # notation: P normal load
    """
    if surface.time is not None:
        try:
            return _history_by_time(surface, surface.time, scene, sure_of_times=sure_of_times)
        except InputError as fault:
            if sure_of_times:
                raise
            try:
                history = history_of_result(replace(surface, time=None), scene)
            except InputError:
                raise fault from None
            reason = str(fault).removeprefix(f"{surface.source}: ").split(";", maxsplit=1)[0]
            guess = (
                f"the file's times can't be those of the scene's path and were not used ({reason})"
            )
            return replace(history, guess_in_words=guess)
    if surface.normal_load is not None and surface.tangential_load is not None:
        loads = (surface.normal_load, surface.tangential_load)
        # limit of the distance from the path: 0.5 % of the largest P
        return _history_by_loads(
            surface, scene, loads, _LARGEST_MISFIT_OF_LOADS, "the loads that it states"
        )
    return _history_by_resultants(surface, scene)


def _history_by_resultants(surface: SurfaceResult, scene: Scene) -> History:
    """Find the instants of an external result (`surface`) on the load path by its resultants, the
    integrals of its tractions over x. The error of the trapezoidal rule, found from theory at these
    instants, is subtracted, and they are found again, twice. Returns times and loads of the path,
    and whether the shear would fit the path with its other sign too.

    InputError where the resultants do not follow the path, to 5 % of the largest P, with either
    sign of the shear.

    # notation: P normal load
    """
    origin_of_loads = "the integrals of its pressure and shear over x"
    if not surface.has_shear and not has_no_tangential_load(scene):
        raise InputError(
            f"{surface.source}: without a shear the pressure alone does not say which instant is"
            " which: state the times of the scene's path, by a column or by times of a mapping, or"
            " P and Q"
        )
    if not surface.has_shear:
        origin_of_loads = "the integral of its pressure over x, with Q = 0 as throughout the scene"
        surface = replace(surface, shear=read_only_copy(np.zeros_like(surface.pressure)))
    # (n_steps,) each; a load P that is stated takes the place of its integral
    normal_load, tangential_load = resultants(surface)
    if surface.normal_load is not None:
        normal_load = surface.normal_load

    def history_with_sign(sign: float, trial_origin: str) -> History | None:
        """The history found with the shear multiplied by `sign`, 1 or -1; None where the loads do
        not follow the path then. `trial_origin` says where the loads come from.
        """
        loads = (normal_load, sign * tangential_load)
        try:
            return _history_by_loads(surface, scene, loads, _LARGEST_MISFIT_OF_SUMS, trial_origin)
        except InputError:
            return None

    shear_sign = 1.0
    loads = (normal_load, tangential_load)
    try:
        history = _history_by_loads(surface, scene, loads, _LARGEST_MISFIT_OF_SUMS, origin_of_loads)
    except InputError:
        # Shear on the other body: matched all the same, and scored as it is, with a sentence.
        shear_sign = -1.0
        history_with_turned_shear = history_with_sign(
            shear_sign, f"{origin_of_loads}, the latter turned"
        )
        if history_with_turned_shear is None:
            raise
        history = history_with_turned_shear
    # subtract the error of the rule on these points
    origin_of_corrected_loads = f"{origin_of_loads}, less what that misses of theory"
    for _ in range(_N_CORRECTIONS):
        # error of the trapezoidal rule on these points, by theory at these times
        error_of_normal_load, error_of_tangential_load = _errors_of_rule(surface, scene, history)
        corrected_normal_load = normal_load
        if surface.normal_load is None:
            corrected_normal_load = normal_load - error_of_normal_load
        corrected_tangential_load = shear_sign * tangential_load - error_of_tangential_load
        loads = (corrected_normal_load, corrected_tangential_load)
        history = _history_by_loads(
            surface, scene, loads, _LARGEST_MISFIT_OF_SUMS, origin_of_corrected_loads
        )
    # a shear whose integral exceeds 5 % of the largest P
    has_resultant_shear = float(np.max(np.abs(tangential_load))) > _LARGEST_MISFIT_OF_SUMS * float(
        np.max(normal_load)
    )
    has_either_sign = (
        has_resultant_shear and history_with_sign(-shear_sign, origin_of_loads) is not None
    )
    return replace(history, has_either_sign=has_either_sign)


def _errors_of_rule(surface: SurfaceResult, scene: Scene, history: History) -> tuple[Array, Array]:
    """Error of the trapezoidal rule on the points of an external result (`surface`): integral of
    half-plane theory's tractions minus the scene's loads, at the instants of `history`; (n_steps,)
    of P and of Q [force / thickness].

    # notation: P normal load, Q tangential load
    """
    import semi_analytic

    theory = semi_analytic.solve(
        scene, x=surface.x, time=history.time, fields=("pressure", "shear")
    )
    normal_force = np.trapezoid(theory.pressure, surface.x, axis=1)
    tangential_force = np.trapezoid(theory.shear, surface.x, axis=1)
    return normal_force - history.normal_load, tangential_force - history.tangential_load


def _history_by_time(
    surface: SurfaceResult, stated_time: Array, scene: Scene, *, sure_of_times: bool
) -> History:
    """Where the instants of a result lie on the scene's load path, by the times that its file
    states.

    InputError where these times do not ascend or are not on the path, or where loads and integrals
    of the pressure there are not the scene's.

    Parameters
    ----------
    surface
        the external result: its pressure, and P and Q where it states them, else None
    stated_time
        (n_steps,) times in the file
    scene
        the scene that it is a result of
    sure_of_times
        whether the times are known to be the scene's; the integrals of the pressure may then differ
        more from P

    # notation: P normal load, Q tangential load
    """
    path = scene.load.path()
    # times that miss a turning point by round-off are put on it
    time = _times_on_ends_of_segments(stated_time, path, scene)
    _require_times_on_path(time, scene, surface.source)
    normal_load, tangential_load = path.at(time)
    note = "its instants were matched by the times that it states"
    history = History(time, normal_load, tangential_load, (note,))
    _require_loads_of_scene(surface, history, sure_of_times=sure_of_times)
    return history


def _require_times_on_path(time: Array, scene: Scene, source: str) -> None:
    """InputError, naming the file `source` and the first instant at fault, where times (n_steps,)
    do not ascend or lie outside the load path of the scene.
    """
    path = scene.load.path()
    # end of the last load segment, or of the last cycle
    if path.period is None:
        last_time = path.initial_loading[-1].end
    else:
        last_time = path.cycle_start + scene.cycles * path.period
    if np.any(np.diff(time) <= 0):
        instant = int(np.flatnonzero(np.diff(time) <= 0)[0]) + 1
        raise InputError(
            f"{source}: time does not ascend: instant {instant + 1} is at"
            f" {time[instant]:.9g} after {time[instant - 1]:.9g}"
        )
    instants_beyond = np.flatnonzero((time < path.start) | (time > last_time))
    if len(instants_beyond):
        cycles_in_words = f" in {scene.cycles} cycles" if path.period is not None else ""
        raise InputError(
            f"{source}: instant {instants_beyond[0] + 1} is at time"
            f" {time[instants_beyond[0]]:.6g}, outside the scene's path, which goes from"
            f" {path.start:.6g} to {last_time:.6g}{cycles_in_words}; state each instant's time"
            " there by the key times of a mapping"
        )


def _require_loads_of_scene(
    surface: SurfaceResult, history: History, *, sure_of_times: bool
) -> None:
    """InputError where the loads that a result states, or the integrals of its pressure, are not
    the scene's at its times. Stated P and Q must be the scene's to 0.5 % of the largest P. The
    integral of the pressure must be P to 200 % of it, or to 20 % where the times are not sure.

    Parameters
    ----------
    surface
        the external result: its pressure, and P and Q where it states them, else None
    history
        times of its instants on the path, with P and Q of the scene there
    sure_of_times
        whether the times are known to be the scene's

    # notation: P normal load, Q tangential load
    """
    largest_normal_load = float(np.max(history.normal_load)) or 1.0
    # of the pressure over x, at each instant
    integral_of_pressure, _ = resultants(surface)
    limit_of_integral = (
        _LARGEST_MISFIT_AT_SURE_TIMES if sure_of_times else _LARGEST_MISFIT_AT_UNSURE_TIMES
    )
    for load_in_words, result_values, scene_values, largest_misfit in (
        ("P", surface.normal_load, history.normal_load, _LARGEST_MISFIT_OF_LOADS),
        ("Q", surface.tangential_load, history.tangential_load, _LARGEST_MISFIT_OF_LOADS),
        (
            "the integral of the pressure",
            integral_of_pressure,
            history.normal_load,
            limit_of_integral,
        ),
    ):
        if result_values is None:
            continue
        is_off_path = np.abs(result_values - scene_values) > largest_misfit * largest_normal_load
        instants_off_path = np.flatnonzero(is_off_path)
        if len(instants_off_path):
            instant = int(instants_off_path[0])
            raise InputError(
                f"{surface.source}: its history is not the scene's: at instant {instant + 1}, time"
                f" {history.time[instant]:.6g}, {load_in_words} is {result_values[instant]:.6g}"
                f" and the scene's {scene_values[instant]:.6g}"
                # likely reason where all loads differ by one factor; else ""
                f"{_hint_on_constant_ratio(result_values, scene_values, largest_normal_load)}"
            )


def _times_on_ends_of_segments(time: Array, path: LoadPath, scene: Scene) -> Array:
    """Times (k,) of a result's instants, put on a near end of a segment of the load path, where
    loads turn or a cycle ends. Near is a distance of less than 1e-5 of a cycle, by which a printed
    time may miss it.
    """
    ends = np.array([path.start, *(segment.end for segment in path.segments(scene.cycles))])
    largest_miss = (path.period or ends[-1] - ends[0]) * _ERROR_OF_PRINTED_TIME
    index_after = np.clip(np.searchsorted(ends, time), 1, len(ends) - 1)
    end_before = ends[index_after - 1]
    end_after = ends[index_after]
    nearest_end = np.where(time - end_before < end_after - time, end_before, end_after)
    return np.where(np.abs(time - nearest_end) <= largest_miss, nearest_end, time)


def _hint_on_constant_ratio(
    result_values: Array, scene_values: Array, largest_normal_load: float
) -> str:
    """A hint for an error message where the loads of a result are those of the scene times one
    factor at every instant: the factor and its likely reason. "" where there is no such factor.

    Parameters
    ----------
    result_values
        (k,) load P or Q of the result at its k instants
    scene_values
        (k,) that of the scene
    largest_normal_load
        smaller loads than 1 % of it are not looked at

    # notation: P normal load, Q tangential load
    """
    is_loaded = np.abs(scene_values) > 0.01 * largest_normal_load
    if not is_loaded.any():
        return ""
    ratios = result_values[is_loaded] / scene_values[is_loaded]
    factor = ratios[0]
    if np.ptp(ratios) > 0.01 * abs(factor) or abs(factor - 1) < 0.01 or factor == 0:
        return ""
    hint = "a thickness of that size (thickness), other units (factors), or half a model?"
    if factor < 0:
        hint = "the other sign?"
    return f", {factor:.4g} times as much at every instant: {hint}"


# --------------------------------------------------------------------------- by the loads, in order
def _history_by_loads(
    surface: SurfaceResult, scene: Scene, loads: Loads, largest_misfit: float, origin_of_loads: str
) -> History:
    """Find the instants of an external result (`surface`) on the load path by their loads P and Q,
    in order along the path; where every instant lies on the cycle, in its last one. Returns times
    and loads of the path, and notes.

    InputError where an instant is farther from the path than `largest_misfit` times the largest P
    of the path, or where no instant has more than a two-hundredth of that. `origin_of_loads` says
    where the loads come from. `loads` are P and Q of the instants, (n_steps,) each.
    """
    path = scene.load.path()
    normal_load, tangential_load = loads
    largest_normal_load = float(np.max(path.at(_sample_times(path, 1))[0]))
    if np.max(normal_load) <= _LARGEST_MISFIT_OF_LOADS * largest_normal_load:
        raise InputError(
            f"{surface.source}: its largest P is {np.max(normal_load):.4g} (from {origin_of_loads})"
            f" and the scene's {largest_normal_load:.4g}: too little to tell its instants by; see"
            " to thickness and factors of the mapping, or state the times"
        )
    misfit, time = _best_times(scene, loads, largest_normal_load, largest_misfit)
    # the last instant is put a period after an earlier one with the same loads
    time = _with_closed_cycle(time, scene, loads, misfit * largest_normal_load)
    normal_load_of_path, tangential_load_of_path = path.at(time)
    if misfit > largest_misfit:
        relative_distances = _distances_from_path(path, time, loads) / largest_normal_load
        instant = int(np.flatnonzero(relative_distances > largest_misfit)[0])
        raise InputError(
            f"{surface.source}: its history is not the scene's: at instant {instant + 1} P ="
            f" {normal_load[instant]:.6g} and Q = {tangential_load[instant]:.6g} (from"
            f" {origin_of_loads}),"
            f" and the nearest that the scene's path has, in order, is P ="
            f" {normal_load_of_path[instant]:.6g} and Q ="
            f" {tangential_load_of_path[instant]:.6g} at time {time[instant]:.6g}"
            f"{_hint_on_constant_ratio(normal_load, normal_load_of_path, largest_normal_load)}"
        )
    notes = [
        f"its instants were matched to the load path by {origin_of_loads}; the farthest is"
        f" {misfit:.1e} of the largest P away",
        *_notes_on_other_places(time, scene),
    ]
    return History(time, normal_load_of_path, tangential_load_of_path, tuple(notes))


def _best_times(
    scene: Scene, loads: Loads, largest_normal_load: float, largest_misfit: float
) -> tuple[float, Array]:
    """Ascending times (n_steps,) of the load path that are nearest to the loads of a result's
    instants; first, the largest distance of an instant from the path. They are searched in the last
    cycle, and on the whole path where the distance there exceeds the limit.

    Distances are in the plane of P and Q, over the largest P of the path.

    Parameters
    ----------
    scene
        gives the path, and the number of cycles
    loads
        P and Q of the instants, (n_steps,) each
    largest_normal_load
        largest P of the path
    largest_misfit
        largest distance that is near enough

    # notation: P normal load, Q tangential load
    """
    path = scene.load.path()
    best_match: tuple[float, Array] | None = None
    for sample_times in _times_to_search(path, scene):
        time = _times_in_order(sample_times, path, scene, loads, largest_normal_load)
        misfit = float(np.max(_distances_from_path(path, time, loads))) / largest_normal_load
        if best_match is None or misfit < best_match[0]:
            best_match = (misfit, time)
        if misfit <= largest_misfit:
            break
    assert best_match is not None
    return best_match


def _notes_on_other_places(time: Array, scene: Scene) -> list[str]:
    """Notes for the reader of a result that its instants may lie elsewhere on the load path with
    the same loads: in an earlier cycle, or on another pass of a path without cycles. `time`
    (n_steps,) are the times at which they were found.
    """
    path = scene.load.path()
    notes = []
    start_of_last_two_cycles = math.inf
    if path.period is not None:
        start_of_last_two_cycles = path.cycle_start + (scene.cycles - 2) * path.period
    if time[0] >= start_of_last_two_cycles - 1e-9:
        subject = "the instant lies" if len(time) == 1 else "all instants lie"
        notes.append(
            f"{subject} on the cycle, which comes back: one of the last of {scene.cycles} cycles"
            " was taken, the steady state; if it is an earlier one, state the times"
        )
    if path.period is None and len(time) > 1:
        notes.append(
            "where the path passes the same loads more than once between two instants, the wrong"
            " pass may have been taken"
        )
    return notes


def _with_closed_cycle(
    time: Array, scene: Scene, loads: Loads, largest_distance_from_path: float
) -> Array:
    """Times (n_steps,) of a result on the load path, the last one set to a whole period after an
    earlier one where its loads are the same.

    Next to a turning point a small error of a load is a large one of the time. Loads are the same
    where they differ by no more than twice `largest_distance_from_path`, that of any instant, or by
    what six printed digits leave open [force / thickness].
    """
    path = scene.load.path()
    if path.period is None or len(time) < 3:
        return time
    earlier_instant = int(np.argmin(np.abs(time[:-1] - (time[-1] - path.period))))
    time_a_period_later = time[earlier_instant] + path.period
    normal_load, tangential_load = loads
    load_change = np.hypot(
        normal_load[-1] - normal_load[earlier_instant],
        tangential_load[-1] - tangential_load[earlier_instant],
    )
    # a hundred-thousandth of the largest load
    print_error = _ERROR_OF_PRINTED_LOAD * float(np.max(np.abs(loads)))
    last_interval = time[-1] - time[-2]
    end_of_path = path.cycle_start + scene.cycles * path.period
    has_same_loads = load_change <= max(2 * largest_distance_from_path, print_error)
    is_on_path = time[-2] < time_a_period_later <= end_of_path
    is_close = abs(time[-1] - time_a_period_later) <= last_interval / 2
    if has_same_loads and is_on_path and is_close:
        return np.append(time[:-1], time_a_period_later)
    return time


def _times_to_search(path: LoadPath, scene: Scene) -> Iterator[Array]:
    """Times of the load path, (n,), among which instants are looked for: the last cycle, where
    there is one, then the whole path.
    """
    if path.period is not None:
        start = path.cycle_start + (scene.cycles - 1) * path.period
        # Twice round, so that a loop that starts elsewhere finds its end; the second is the first
        # again.
        yield start + path.period * np.linspace(-min(1, scene.cycles - 1), 1, 2 * _N_SAMPLES + 1)
    yield _sample_times(path, scene.cycles)


def _sample_times(path: LoadPath, n_cycles: int) -> Array:
    """Times (n,) of samples of the load path, ascending: of the initial loading and of `n_cycles`
    cycles; about 720 for each cycle, at least 8 for each load segment.
    """
    segments = list(path.segments(n_cycles if path.period is not None else 1))
    n_samples = max(_N_SAMPLES * (n_cycles + 1) // len(segments), 8)
    return np.unique(
        np.concatenate([np.linspace(segment.start, segment.end, n_samples) for segment in segments])
    )


def _times_in_order(
    sample_times: Array, path: LoadPath, scene: Scene, loads: Loads, largest_normal_load: float
) -> Array:
    """Find the time on the load path of each of k instants of a result by its loads P and Q:
    ascending times (k,), near to the loads, and with even steps where several places are as near.

    The places of an instant are samples of the path that are nearest to its loads. The cheapest
    sequence of places is chosen, and the times are refined beside them. Noise next to a turning
    point may put an instant before the last one, by a small part of a revolution.

    Parameters
    ----------
    sample_times
        (n,) times of samples of the path, ascending
    path
        the load path, which gives P and Q at a time
    scene
        its number of cycles says where load segments end
    loads
        P and Q of the instants, (k,) each
    largest_normal_load
        largest P of the path, by which distances between loads are divided
    """
    places, costs_by_distance = _places_near_loads(sample_times, path, loads, largest_normal_load)
    chosen_places = _cheapest_sequence(sample_times, places, costs_by_distance, path.period)
    # exact times near the samples; those that miss a turning point by round-off are put on it
    return np.maximum.accumulate(
        _times_on_ends_of_segments(
            _refined_times(sample_times, chosen_places, path, loads), path, scene
        )
    )


def _places_near_loads(
    sample_times: Array, path: LoadPath, loads: Loads, largest_normal_load: float
) -> tuple[list[Places], list[Array]]:
    """Where each of k instants of a result may lie on the load path: for each instant the indices
    of the samples that are nearest to its loads P and Q, (m,), and the cost of each, (m,).

    The cost is 1000 times (`_COST_OF_DISTANCE`) the square of the distance from the instant's loads
    in the plane of P and Q. It is counted over the square for the instant that lies farthest from
    the path.

    Parameters
    ----------
    sample_times
        (n,) times of samples of the path, ascending
    path
        the load path, which gives P and Q at a time
    loads
        P and Q of the instants, (k,) each
    largest_normal_load
        largest P of the path, by which distances between loads are divided
    """
    normal_load, tangential_load = path.at(sample_times)
    # of each instant: squared distance from the path at each sample, over P^2, (n,)
    squared_distances = [
        _squared_distances(normal_load - instant_p, tangential_load - instant_q)
        / largest_normal_load**2
        for instant_p, instant_q in zip(*loads, strict=True)
    ]
    least_squared_distances = [
        float(squares_of_instant.min()) for squares_of_instant in squared_distances
    ]
    # at least 1e-6 of the largest P, squared
    largest_square = max(least_squared_distances) + _EQUAL_DISTANCE**2
    places = [_nearest_samples(squares_of_instant) for squares_of_instant in squared_distances]
    costs_by_distance = [
        _COST_OF_DISTANCE * squares_of_instant[places_of_instant] / largest_square
        for squares_of_instant, places_of_instant in zip(squared_distances, places, strict=True)
    ]
    return places, costs_by_distance


def _cheapest_sequence(
    sample_times: Array, places: list[Places], costs_by_distance: list[Array], period: float | None
) -> Places:
    """One place on the load path for each of k instants, (k,): the sequence of samples that costs
    least in all, by dynamic programming.

    A place costs by its distance from the instant's loads. A step of time costs the square of its
    ratio to the mean step; a step back by a 3000th of a revolution costs as much as a mean step
    ahead. So of places that are equally near, to and fro on one line or in one revolution after
    another, the evenest are taken.

    Parameters
    ----------
    sample_times
        (n,) times of samples of the path, ascending
    places
        for each instant the indices of the samples at which it may lie, (m,)
    costs_by_distance
        for each instant the costs of these places, (m,)
    period
        length of a revolution of the path; None without one
    """
    duration = sample_times[-1] - sample_times[0]
    mean_step = duration / len(places)
    step_back = (period or duration) / _DIVISOR_OF_STEP_BACK
    # cost of the way to each place of an instant; of equal matches the earlier one counts
    cost = _COST_OF_A_CYCLE_AHEAD * (sample_times[places[0]] - sample_times[0]) / duration
    cost = cost + costs_by_distance[0]
    # for each place of an instant the best of the one before
    predecessors: list[Places] = []
    for instant_index in range(1, len(places)):
        # from each place of the instant before to each place of this one
        times_before = sample_times[places[instant_index - 1]]
        time_step = sample_times[places[instant_index]] - times_before[:, None]
        cost_of_pair = (
            cost[:, None] + (time_step / np.where(time_step < 0, step_back, mean_step)) ** 2
        )
        predecessors.append(np.argmin(cost_of_pair, axis=0))
        cost = np.min(cost_of_pair, axis=0) + costs_by_distance[instant_index]

    # back from the cheapest place of the last instant
    best_numbers_from_end = [int(np.argmin(cost))]
    for predecessor in reversed(predecessors):
        best_numbers_from_end.append(int(predecessor[best_numbers_from_end[-1]]))
    numbers_of_best = reversed(best_numbers_from_end)
    return np.array(
        [
            places_of_instant[place_number]
            for places_of_instant, place_number in zip(places, numbers_of_best, strict=True)
        ]
    )


def _nearest_samples(squares: Array) -> Places:
    """Indices of the samples of a load path at which the squared distance from an instant's loads
    (`squares`, (n,)) is least among its neighbours; of these at most the 64 nearest.

    >>> _nearest_samples(np.array([4.0, 1.0, 1.0, 4.0, 1.5])).tolist()
    [1, 4]
    """
    square_before = np.append(np.inf, squares[:-1])
    square_after = np.append(squares[1:], np.inf)
    indices_of_minima = np.flatnonzero((squares < square_before) & (squares <= square_after))
    nearest_first = np.argsort(squares[indices_of_minima], kind="stable")
    return np.sort(indices_of_minima[nearest_first[:_MOST_PLACES]])


def _nearest_on_chords(p_difference: Array, q_difference: Array) -> tuple[Array, Array]:
    """The point nearest to the origin on each chord between neighbouring samples of a path.

    Parameters
    ----------
    p_difference, q_difference
        (..., n) coordinates of the samples: P and Q minus the loads that are sought

    Returns
    -------
    share, square
        (..., n - 1) share of the chord up to the point, and squared distance of the point

    Examples
    --------
    >>> share, square = _nearest_on_chords(np.array([-1.0, 3.0]), np.array([2.0, 2.0]))
    >>> share.tolist(), square.tolist()
    ([0.25], [4.0])

    # notation: P normal load, Q tangential load
    """
    start_p = p_difference[..., :-1]
    start_q = q_difference[..., :-1]
    chord_p = np.diff(p_difference)
    chord_q = np.diff(q_difference)
    square_of_length = chord_p**2 + chord_q**2
    divisor = np.where(square_of_length > 0, square_of_length, 1.0)
    share = np.clip(-(start_p * chord_p + start_q * chord_q) / divisor, 0.0, 1.0)
    nearest_p = start_p + share * chord_p
    nearest_q = start_q + share * chord_q
    return share, nearest_p**2 + nearest_q**2


def _squared_distances(p_difference: Array, q_difference: Array) -> Array:
    """Squared distance of the origin from the path at each of its samples (n,): from the nearer of
    the chords that meet there.

    From the samples themselves it would be their luck on which of two branches, to and fro on one
    line, an instant lies.
    """
    _, squares = _nearest_on_chords(p_difference, q_difference)
    square_of_chord_before = np.insert(squares, 0, squares[0])
    square_of_chord_after = np.append(squares, squares[-1])
    return np.minimum(square_of_chord_after, square_of_chord_before)


def _refined_times(
    sample_times: Array, chosen_places: Places, path: LoadPath, loads: Loads
) -> Array:
    """Times (k,) at which the load path is nearest to the loads P and Q of a result's k instants:
    six times the nearest point on chords ten times shorter. They lie near the samples with indices
    `chosen_places` among `sample_times` (n,).

    A nearest point on a chord misses the path's by the square of its length; squares of distances
    alone are flat to 1e-8 of a cycle around it.
    """
    refined_times = sample_times[chosen_places]
    instant_indices = np.arange(len(chosen_places))
    time_below = sample_times[np.maximum(chosen_places - 1, 0)]
    time_above = sample_times[np.minimum(chosen_places + 1, len(sample_times) - 1)]
    for _ in range(6):
        step = (time_above - time_below) / 20
        fine_times = time_below[:, None] + step[:, None] * np.arange(21)
        normal_load, tangential_load = path.at(fine_times)
        # nearest point to the loads on each chord: share of the chord, squared distance
        share, squared_distance = _nearest_on_chords(
            normal_load - loads[0][:, None], tangential_load - loads[1][:, None]
        )
        nearest_chord = np.argmin(squared_distance, axis=1)
        refined_times = (
            fine_times[instant_indices, nearest_chord]
            + share[instant_indices, nearest_chord] * step
        )
        time_below = np.maximum(refined_times - step, sample_times[0])
        time_above = np.minimum(refined_times + step, sample_times[-1])
    return refined_times


def _distances_from_path(path: LoadPath, time: Array, loads: Loads) -> Array:
    """Distances (n_steps,) in the plane of P and Q of the loads from those of the path at these
    times [force / thickness].
    """
    normal_load, tangential_load = path.at(time)
    return np.hypot(normal_load - loads[0], tangential_load - loads[1])
