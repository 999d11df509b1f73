"""From a scene to a ContactSolution: the fields at the points and instants that are asked for, and
the dissipations.

A scene's path is followed by `load_series` where all of it is straight, else by `history`; both
leave an `Along`, and the rest does not ask which it was.

Errors are estimates from above. A field is a sum of M' times differences of a kernel at the knots
of the memory: its error is that of the kernel, f times, twice a knot. Integrals over arcs come with
their error. The dissipation of a steady cycle is found as f int Lam dw and as closed-int Q dU: what
the two differ by counts as error. Of long series a sample of slip areas counts. Closed forms keep
1e-13 of their own value against forty digits and have no entry but for what arcs lose beyond 1e-12.

# notation: M' slope of the memory curve, |M'| <= f; W dissipation, Lam slip area of the normal
problem
"""

from __future__ import annotations

import math
import platform
import time as clock
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from scenes import (
    NORMAL_LOAD,
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ContactSolution,
    InputError,
    Materials,
    NotFoundError,
    Record,
    Scene,
    TimeSeriesLoad,
    Work,
    freeze,
    scene_of,
)
from scenes.arrays import LARGEST, real_numbers
from semi_analytic.bulk_and_tilt import OneCurve, PathLoads, one_curve, steady_curve, strain_of
from semi_analytic.elasticity import composite_modulus, coupling_constant
from semi_analytic.fields import Integrals
from semi_analytic.friction_work import (
    Loop,
    closed_integral,
    density_of_records,
    global_dissipation,
    pointwise_dissipation,
    slip_work,
    work_error,
)
from semi_analytic.grid import INCREMENTS, edges_along, follow_on_grid
from semi_analytic.history import History, Span, history_of, slipped_share
from semi_analytic.load_series import (
    LoadSeries,
    States,
    blocks,
    depth_of,
    series_of,
    straight_series,
)
from semi_analytic.loops_in_phase import WAY_NODES, Way, loop_of, ways_in_phase
from semi_analytic.memory import (
    LAST_DIGITS,
    PROMISED,
    Piece,
    Snapshot,
    level,
    pieces,
    rounding_of_shift,
    rounding_of_slip,
    value_on,
)
from semi_analytic.opposite_slip import OppositeSlip
from semi_analytic.profiles import Contact, SymmetricContact, contact_of, convex_profile
from semi_analytic.quadrature import NODES
from semi_analytic.steady_ellipse import digits_of_loop, ellipses_of, works_over_time
from semi_analytic.tilted_profile import NestedIntervals, TiltedProfile

Array = NDArray[np.float64]

_INSTANTS = 7
_PLACES = 25
_NEAR = 0.01
_TINY = float(np.finfo(float).tiny)
_EPS = float(np.finfo(float).eps)
# Rounding of the closed integral of Q dU over the dissipation, above which it is no second route
# any more.
_TOO_ROUGH = 1e-2
# So many times that rounding may be in it where U is no closed form: fifty last digits of each
# primitive in a difference of two.
_OF_LOOP = 100.0
# Below this share of P in P - P_c the integral of Q dU has been 1e-3 to 0.1 of W off where P nearly
# vanishes, more than its rounding: there Lam is an integral of positive terms over a range on which
# P(a) is a line, and needs no second route.
_SLIPS_ENOUGH = 1e-6
# Errors that a note says, share of the largest value.
_DOUBTFUL = 1e-9


# -------------------------------------------------------------------------------- what is asked for
Cycles = Literal["all", "steady"]

FIELDS = (
    "pressure",
    "shear",
    "slip",
    "state",
    "tangential_displacement",
    "normal_approach",
    "dissipation_density",
    "dissipation",
)
"""The fields that can be asked for one by one."""
POINTWISE = frozenset(("pressure", "shear", "slip", "state"))
"""Those that have a value at each point and instant."""

_POINTS = 200


@dataclass(frozen=True, eq=False)
class Request:
    """What is to be evaluated.

    Attributes
    ----------
    contact, modulus : normal contact, E*
    time : (n,) instants as asked for
    x : (m,) points as asked for
    distance, fold : (k,) different |x|, (m,) where each x finds its own; different x of an
    unsymmetric contact fields : what is wanted
    family : the path with bulk stress and tilt; None without
    """

    contact: Contact
    modulus: float
    time: Array
    x: Array
    distance: Array
    fold: NDArray[np.int64]
    fields: frozenset[str]
    family: OneCurve | None = None


def checked(fields: str | Iterable[str], cycles: Cycles) -> frozenset[str]:
    """The fields that are asked for; InputError for one that is not among `FIELDS`, or for other
    `cycles` than there are.
    """
    if cycles not in ("all", "steady"):
        raise InputError(f"cycles: {cycles!r} is neither 'all' nor 'steady'")
    wanted = frozenset([fields] if isinstance(fields, str) else fields)
    unknown = sorted(wanted - set(FIELDS))
    if unknown:
        raise InputError(f"fields: {unknown[0]!r} is not among {', '.join(FIELDS)}")
    return wanted


def vector(values: ArrayLike | None, name: str) -> Array | None:
    """Finite numbers (n,), one alone too, None where none are given; InputError with their `name`
    for anything else.
    """
    if values is None:
        return None
    array = np.atleast_1d(np.array(real_numbers(values, name)))
    if array.ndim != 1 or not len(array):
        raise InputError(
            f"{name}: a list of finite numbers is needed, not an array of shape {array.shape}"
        )
    wrong = array[~(np.abs(array) <= LARGEST)]
    if len(wrong):
        raise InputError(
            f"{name}: a list of finite numbers is needed, each at most {LARGEST:g}, and {wrong[0]}"
            " is none"
        )
    return array


def folded(x: Array) -> tuple[Array, NDArray[np.int64]]:
    """Different |x| (k,), ascending, and where each point (m,) finds its own; sides that differ by
    a last digit are one.

    >>> folded(np.array([-1.0, 0.0, 1.0 + 2.3e-16]))
    (array([0., 1.]), array([1, 0, 1]))
    """
    size, back = np.unique(np.abs(x), return_inverse=True)
    new = np.diff(size, prepend=-np.inf) > 2 * np.finfo(float).eps * size[-1]
    return size[new], (np.cumsum(new) - 1)[back]


def mirrored_points(edge: float) -> Array:
    """Points from -edge to edge, mirrored to the last digit."""
    right = np.linspace(edge / (_POINTS - 1), edge, _POINTS // 2)
    return np.concatenate([-right[::-1], right])


# --------------------------------------------------------------------------------- the whole answer
def solve(
    scene: Scene | str | Path,
    x: ArrayLike | None = None,
    time: ArrayLike | None = None,
    *,
    cycles: Cycles = "all",
    fields: str | Iterable[str] = FIELDS,
    straight_steps: bool = False,
) -> ContactSolution:
    """The half-plane answer to a scene, exact to rounding at every point and instant asked for.

    Bulk stress and tilt are taken where the memory of friction stays one curve, see
    `bulk_and_tilt.one_curve`. The loop is then that of Q over U minus that of m_q over the bulk
    strain, and edges need not be mirrored.

    Parameters
    ----------
    scene : the question, or its name in the library, or the path of its file
    x : (n_points,) contact points, or one [length]; 200 across the largest contact and a little
    beyond if None time : (n_steps,) instants, in any order, or one; about 400 a cycle, all events
    among them, if None
    cycles : "all" (the initial loading and every cycle up to the first steady one) or "steady"
        (that one only: where bulk stress and tilt are constant in it, of fields that do not depend
        on the initial loading, without grids); no effect where `time` is given
    fields : a name out of `FIELDS`, or several; the others come back as NaN (state: open) and are
    counted in `work.skipped` straight_steps : follow straight lines between the given times
    (ascending) instead of the scene's path: the polygon that a
        step-by-step solver saw, so that its step error can be told apart

    Returns
    -------
    ContactSolution. Its dissipations are those of the last whole cycle within `time`; where `time`
    holds none, or is not given, those of the steady cycle (of cycle number `scene.cycles` if none
    is steady before). Cycles after the steady one are looked up, not solved. A path of more than
    1,000 rows is answered at every row where no `time` is given, at about 400 of them with
    pointwise fields; a million rows take some seconds and memory for the rows asked for, W(x) of
    them at 200 points half a minute to minutes: leave "dissipation_density" out of `fields` where
    it is not wanted.

    Raises
    ------
    InputError
        For a scene that does not pass its own check, an unknown field, a time outside the path, a
        profile that this engine does not know, bulk stress or tilt of another memory.
    InadmissibleLoadError
        For gross sliding or separation anywhere in the path, with the instant and the loads.

    >>> solution = solve("hertz-normal", x=0.0, time=1.0, fields="pressure")
    >>> round(
    ...     solution.pressure.item() / (2 * 90.62286500739786 / math.pi), 12
    ... )  # 2 P/(pi a) with a = 1
    1.0
    """
    scene = scene_of(scene)
    wanted, points, asked = checked(fields, cycles), vector(x, "x"), vector(time, "time")
    started = clock.perf_counter()
    family = None
    if scene.unsymmetric:
        family = one_curve(scene)
        if family is None:
            if straight_steps:
                raise InputError(
                    "straight_steps: without one memory curve half-plane theory takes the scene's"
                    " own path; leave it out"
                )
            return _followed(scene, wanted, points, asked, cycles)
    return _remembered(scene, family, wanted, points, asked, cycles, straight_steps, started)


def _remembered(
    scene: Scene,
    family: OneCurve | None,
    wanted: frozenset[str],
    points: Array | None,
    asked: Array | None,
    cycles: Cycles,
    straight_steps: bool,
    started: float,
) -> ContactSolution:
    """The answer where one curve is the memory of friction: of the scene, or of `family` under bulk
    stress and tilt.
    """
    contact = family.contact if family is not None else contact_of(scene.profile, scene.material)
    friction = scene.friction.coefficient
    path: LoadSeries | History
    if straight_steps:
        if asked is None:
            raise InputError("straight_steps: give the times between which the steps are straight")
        path = straight_series(
            scene.load.path() if family is None else family.path, friction, asked
        )
    elif family is not None:
        path = history_of(family.path, friction, scene.cycles, asked)
    else:
        path = _path_of(scene, asked)
    pointwise, left_out = not wanted.isdisjoint(POINTWISE), 0
    if asked is None:
        asked, left_out = path.default_times(cycles == "steady", pointwise)
        path = replace(path, covered=path.covered[-1:]) if cycles == "steady" else path
    if points is None:
        needed = pointwise or "dissipation_density" in wanted or not path.long
        points = _points_of(contact, path.largest) if needed else np.zeros(1)
    every = folded(points) if family is None else np.unique(points, return_inverse=True)
    request = Request(
        contact, composite_modulus(scene.material), asked, points, *every, wanted, family
    )
    followed = clock.perf_counter()
    found = (
        _along_series(path, request)
        if isinstance(path, LoadSeries)
        else _along_spans(path, request)
    )
    worked = clock.perf_counter()
    series = _series_of(request, found.snapshot)
    grids, arcs = _grids_of(request, found.snapshot, series)
    evaluated = clock.perf_counter()
    work, loop = float(found.each[-1]), math.nan
    if found.loop is not None:
        # Where rounding leaves less than two digits of the closed integral it is no second route
        # any more.
        value, rounding = found.loop
        loop = (value if rounding < _TOO_ROUGH * work else math.nan) if work else 0.0
    errors = _errors(request, found, series, grids, arcs, work, loop)
    left_out_of_memory = sum(family.neglected.values()) if family is not None else 0.0
    if left_out_of_memory > PROMISED:
        errors |= {
            name: errors.get(name, 0.0) + left_out_of_memory
            for name in sorted(wanted & _OF_FRICTION)
        }
    notes = list(_neglected_loads(family))
    steady = path.steady_from is not None and path.covered[-1] >= path.steady_from
    if "dissipation" in wanted and path.period is not None and not steady:
        notes.append(
            "the last cycle is not steady: no closed integral of Q dU to compare the dissipation"
            " with"
        )
    if left_out:
        notes.append(
            f"with pointwise fields the answer is given at {len(asked)} rows, {left_out} were left"
            " out; `time` chooses others"
        )
    for name, error in errors.items():
        if error > _DOUBTFUL and "edge" not in name:
            size = "it" if name in ("dissipation", "loop_work") else "the largest value"
            notes.append(
                f"{name}: quadratures and rounding may have left an error of {error:.1e} of {size}"
            )
    # A front that is nothing but the last digits of P is none.
    least = found.least if found.least > LAST_DIGITS * path.largest else 0.0
    stick = float(contact.half_width(least))
    more: dict[str, Any] = {}
    if isinstance(contact, TiltedProfile):
        more["permanent_stick_edges"] = (
            contact.interval(least) if stick > 0 else np.full(2, math.nan)
        )
    ending = "end of path", "the path was followed to its end"
    if path.period is not None:
        ending = "end of path", f"no steady cycle among the first {len(path.cycles)}"
        if path.steady_from is not None:
            ending = "steady", f"cycle {path.steady_from + 1} ends in the state it started from"
    skipped = {}
    copies = max(scene.cycles, len(path.covered)) - len(path.cycles)
    if path.repeats and path.steady_from is not None and copies > 0:
        skipped["cycles"] = (copies, f"copies of cycle {path.steady_from + 1}, which is steady")
    if found.stick:
        skipped["quadratures"] = (found.stick, "full stick: nothing slips")
    seconds = {"history": followed - started, "fields": evaluated - worked}
    seconds["dissipation"] = worked - followed + clock.perf_counter() - evaluated
    return _answer(
        scene,
        wanted,
        *ending,
        [*neglected_coupling(scene.material), *notes],
        errors,
        {"points_evaluated": len(request.distance), "cycles_solved": len(path.cycles)}
        | found.counts,
        skipped,
        seconds,
        series | grids | more,
        cycles=cycles,
        straight_steps=straight_steps,
        certificates=_admissibility(friction, found, grids, wanted),
        energy={"dissipation": freeze(found.increments)} if len(found.increments) else {},
        time=asked,
        x=points,
        dissipation=work,
        loop_work=loop,
        cycle_dissipation=found.each,
        dissipation_density=found.density[request.fold],
        permanent_stick_half_width=stick if stick > 0 else math.nan,
        steady_from=path.steady_from,
    )


def _answer(
    scene: Scene,
    wanted: frozenset[str],
    termination: str,
    message: str,
    notes: Sequence[str],
    errors: Mapping[str, float],
    counts: Mapping[str, int],
    skipped: Mapping[str, tuple[int, str]],
    seconds: Mapping[str, float],
    fields: Mapping[str, Any],
    *,
    cycles: Cycles,
    straight_steps: bool = False,
    certificates: Mapping[str, Array] | None = None,
    energy: Mapping[str, Array] | None = None,
    time: Array,
    x: Array,
    **numbers: Any,
) -> ContactSolution:
    """The answer, its arrays read-only; fields that were not asked for are among what was
    skipped.
    """
    arrays: dict[str, Any] = {"time": time, "x": x} | dict(fields) | numbers
    frozen: dict[str, Any] = {
        name: (
            freeze(values, values.dtype)
            if isinstance(values, np.ndarray) and values.flags.writeable
            else values
        )
        for name, values in arrays.items()
    }
    return ContactSolution(
        engine="semi_analytic",
        scene=scene,
        record=Record(
            converged=True,
            termination=termination,
            message=message,
            iterations=freeze(np.zeros(len(time)), np.int64),
            certificates=certificates or {},
            energy=energy or {},
            notes=tuple(notes),
            errors=errors,
        ),
        work=Work(
            {"instants": len(time), "points": len(x), **counts},
            {name: (len(time), "not asked for") for name in FIELDS if name not in wanted}
            | dict(skipped),
            seconds,
        ),
        settings={"cycles": cycles, "fields": sorted(wanted), "straight_steps": straight_steps},
        versions=dict(_versions()),
        **frozen,
    )


def require_followable(scene: Scene) -> None:
    """Nothing for a scene with bulk stress, tilt or unequal sides that half-plane theory takes; its
    history is not followed here.

    Raises
    ------
    InputError
        For a profile that theory does not know so, and for a contact that leaves the profile.
    """
    if one_curve(scene) is None:
        edges_along(*leaning_profile(scene))


def leaning_profile(scene: Scene) -> tuple[PathLoads, TiltedProfile]:
    """P, Q, eps and alpha of a scene that theory takes, and its profile under any tilt."""
    shape, path = convex_profile(scene.profile), scene.load.path()
    legs = (*path.initial_loading, *path.cycle)
    largest = max(
        float(leg.loads(time)[0])
        for leg in legs
        for time in (leg.end, *leg.turning_points(NORMAL_LOAD))
    )
    intervals = NestedIntervals(shape, 2 / composite_modulus(scene.material), 0.0, 0.0, largest)
    profile = TiltedProfile(intervals, scene.profile.datum_length)
    return PathLoads(path, strain_of(scene.material), profile), profile


_OF_FRICTION = frozenset(
    ("shear", "slip", "tangential_displacement", "dissipation", "dissipation_density")
)
"""Those that bulk strain and tilt change in the first order."""

STEADY_FIELDS = frozenset(
    ("pressure", "state", "normal_approach", "dissipation", "dissipation_density")
)
"""Those that are the same in the steady cycle however it was reached; traction and slip that stay
locked in are not.
"""

_OF_STEADY_CYCLE = (
    *("dissipation", "loop_work", "dissipation_density"),
    *("permanent_stick_half_width", "permanent_stick_edges"),
)


def _followed(
    scene: Scene, wanted: frozenset[str], points: Array | None, asked: Array | None, cycles: Cycles
) -> ContactSolution:
    """The answer where bulk stress and tilt make no one memory curve: on grids of cells."""
    if asked is None and cycles == "steady" and wanted <= STEADY_FIELDS:
        steady_cycle = _steady_alone(scene, wanted, points)
        if steady_cycle is not None:
            return steady_cycle
    started, path, friction = clock.perf_counter(), scene.load.path(), scene.friction.coefficient
    modulus, datum = composite_modulus(scene.material), scene.profile.datum_length
    loads, leaning = leaning_profile(scene)
    if points is None:
        points = mirrored_points(1.05 * float(np.max(np.abs(edges_along(loads, leaning)))))
    notes, most = [*neglected_coupling(scene.material)], max(scene.cycles, 2)
    exact: ContactSolution | None = None
    steady_only = asked is None and cycles == "steady" and wanted <= STEADY_FIELDS
    pointwise = not wanted.isdisjoint(("shear", "slip", "state"))
    found = follow_on_grid(
        loads,
        leaning,
        scene.profile.height,
        friction,
        points,
        asked,
        most=most,
        steady=steady_only,
        pointwise=pointwise,
    )
    cells, pieces = found.counts["cells"], found.counts["pieces"]
    error_of_work = f"dissipation to {found.errors['dissipation']:.1e}, "
    of_work = wanted & {"dissipation", "dissipation_density"}
    if found.steady_from is not None and of_work:
        exact = _steady_alone(scene, of_work, points)
        error_of_work = error_of_work if exact is None else ""
    notes.append(
        f"no one memory curve: half-plane theory on grids of {cells} cells and {INCREMENTS}"
        f" increments a cycle, {error_of_work}edges of stick to about {2 / cells:.2g} a"
        + (f"; they are the outer ones of up to {pieces} zones" if pieces > 1 else "")
        + (
            "; W, W(x) and permanent stick are those of the steady cycle, without grids"
            if exact
            else ""
        )
    )
    period, rows = path.period, slice(None)
    if asked is None and cycles == "steady" and period is not None:
        first = path.cycle_start + (len(found.works) - 1) * period
        rows = slice(int(np.searchsorted(found.time, first * (1 + 1e-12))), None)
    time, (load, shear_load, _, tilt) = found.time[rows], found.loads[:, rows]
    contact_edges, stick_edges = found.contact_edges[rows], found.stick_edges[rows]
    middle, half = np.mean(contact_edges, axis=1), np.diff(contact_edges)[:, 0] / 2
    lower, upper = loads.stresses(time)
    series: dict[str, Any] = {
        "tangential_displacement": (
            found.displacement[rows] + 2 / (math.pi * modulus) * shear_load * math.log(datum)
        ),
        "normal_approach": leaning.approach(middle, half, load, tilt),
    } | {name: getattr(found, name)[rows] for name in ("pressure", "shear", "slip")}
    series = {
        name: values if name in wanted else np.full_like(values, np.nan)
        for name, values in series.items()
    }
    works = found.works[-1:] if steady_only else found.works
    work, steady = float(works[-1]), found.steady_from is not None
    if period is not None and not steady:
        notes.append(
            f"the last cycle, number {len(found.works)}, is not steady: by the trend its"
            f" dissipation is within {found.remainder / work:.1e} of the steady one"
        )
    apart = abs(found.loop / work - 1) if steady and work > 0 else 0.0
    errors = found.errors | {"dissipation": found.errors["dissipation"] + apart}
    # unloaded, nothing sticks
    stays = found.permanent_stick_edges if period is not None else np.full(2, math.nan)
    ending = "end of path", "the path was followed to its end"
    if found.steady_from is not None:
        ending = (
            "steady",
            (
                f"cycle {found.steady_from + 1} repeats the one before to {found.steady_to:.0e} of"
                " its work"
            ),
        )
    answer = _answer(
        scene,
        wanted,
        *ending,
        notes,
        {name: error for name, error in errors.items() if name in wanted},
        {"cycles_solved": len(found.works), **found.counts},
        {},
        {"history": clock.perf_counter() - started},
        series,
        cycles=cycles,
        time=time,
        x=points,
        normal_load=load,
        tangential_load=shear_load,
        state=found.state[rows] if "state" in wanted else np.full_like(found.state[rows], OPEN),
        contact_edges=contact_edges,
        stick_edges=stick_edges,
        contact_half_width=half,
        stick_half_width=np.diff(stick_edges)[:, 0] / 2,
        dissipation=work if "dissipation" in wanted else math.nan,
        loop_work=found.loop if steady and "dissipation" in wanted else math.nan,
        cycle_dissipation=works if "dissipation" in wanted else np.full_like(works, np.nan),
        dissipation_density=(
            found.density
            if "dissipation_density" in wanted
            else np.full_like(found.density, np.nan)
        ),
        permanent_stick_half_width=float(stays[1] - stays[0]) / 2,
        permanent_stick_edges=stays,
        steady_from=found.steady_from,
        bulk_stress_lower=lower,
        bulk_stress_upper=upper,
        tilt=tilt,
        moment=found.moment[rows],
        shear_moment=found.shear_moment[rows],
    )
    if exact is None:
        return answer
    number = np.arange(len(works))
    better_works = np.where(
        number < (found.steady_from or 0), answer.cycle_dissipation, exact.dissipation
    )
    better = {name: getattr(exact, name) for name in _OF_STEADY_CYCLE}
    record = replace(
        answer.record,
        errors=dict(answer.record.errors) | dict.fromkeys(of_work, 0.0) | dict(exact.record.errors),
    )
    return replace(answer, cycle_dissipation=freeze(better_works), record=record, **better)


def _steady_alone(
    scene: Scene, wanted: frozenset[str], points: Array | None
) -> ContactSolution | None:
    """The steady cycle where it does not take its initial loading: of one memory curve, or of loads
    in phase; None of others.
    """
    started = clock.perf_counter()
    family = steady_curve(scene)
    if family is not None:
        way = "one memory curve"
        answer = _remembered(scene, family, wanted, points, None, "steady", False, started)
    elif (ways := ways_in_phase(scene)) is not None:
        way = "quadratures of loads in phase"
        answer = _in_phase(scene, ways, wanted, points, started)
    else:
        return None
    note = (
        f"the steady cycle by {way}; the initial loading has another memory and was not followed:"
        " the number of cycles until then and the moment of the shear are not known,"
        ' `cycles="all"` finds them on grids'
    )
    record = replace(
        answer.record,
        termination="steady",
        message="the steady cycle alone: it does not depend on the initial loading",
        notes=(*answer.record.notes, note),
    )
    skipped = dict(answer.work.skipped)
    skipped["initial loading"] = (
        len(scene.load.path().initial_loading),
        "the steady cycle does not depend on it",
    )
    unknown = freeze(np.full(len(answer.time), math.nan))
    return replace(
        answer, record=record, work=replace(answer.work, skipped=skipped), shear_moment=unknown
    )


_INSTANTS_IN_PHASE = 400


def _instants_in_phase(loads: PathLoads) -> tuple[Array, Array]:
    """Times of the first cycle (n,), evenly over each leg and at every turning point, and P, Q, eps
    and alpha at them (4, n).
    """
    legs = loads.path.cycle
    times = []
    for leg in legs:
        even = np.linspace(leg.start, leg.end, _INSTANTS_IN_PHASE // len(legs) + 2)[1:]
        times.append(np.unique(np.append(even, loads.turns(leg))))
    return np.concatenate(times), np.concatenate([loads.values(time) for time in times], axis=1)


def _work_in_phase(ways: tuple[Way, Way]) -> tuple[float, float]:
    """W of a cycle, and by what share of it half as many nodes change it."""
    work = math.fsum(way.work(WAY_NODES) for way in ways)
    by_half_the_nodes = math.fsum(way.work(WAY_NODES // 2) for way in ways)
    return work, abs(by_half_the_nodes / work - 1)


def _density_in_phase(ways: tuple[Way, Way], x: Array) -> tuple[Array, float]:
    """W(x) of a cycle at points (k,), and by what share of the largest half as many nodes change
    it.
    """
    forward, reverse = ways
    density = forward.density(x, WAY_NODES) + reverse.density(x, WAY_NODES)
    by_half_the_nodes = forward.density(x, WAY_NODES // 2) + reverse.density(x, WAY_NODES // 2)
    largest = float(np.max(density))
    change = _largest(np.abs(by_half_the_nodes - density))
    return density, change / largest if largest > 0 else 0.0


def _in_phase(
    scene: Scene,
    ways: tuple[Way, Way],
    wanted: frozenset[str],
    points: Array | None,
    started: float,
) -> ContactSolution:
    """The second cycle of loads in phase, which is steady: what of it does not depend on the
    initial loading.
    """
    path = scene.load.path()
    loads, leaning = leaning_profile(scene)
    forward, reverse = ways
    time, (load, force, _, tilt) = _instants_in_phase(loads)
    period = path.cycle[-1].end - path.cycle_start
    lowest, highest = time[np.argmin(force)], time[np.argmax(force)]
    rises = (time - lowest) % period <= (highest - lowest) % period
    share = np.clip((force - forward.begin[1]) / forward.change[1], 0, 1)
    middle, half = leaning.under(load, tilt)
    stick_middle, stick_half = np.where(rises, forward.stick(share), reverse.stick(1 - share))
    contact_edges = np.stack([middle - half, middle + half], axis=-1)
    stick_edges = np.stack([stick_middle - stick_half, stick_middle + stick_half], axis=-1)
    x = (
        points
        if points is not None
        else mirrored_points(1.05 * float(np.max(np.abs(contact_edges))))
    )
    nothing = np.broadcast_to(np.nan, (len(time), len(x)))
    pressure = leaning.pressure_over(x, middle, half) if "pressure" in wanted else nothing
    state = np.full(nothing.shape, np.int8(OPEN))
    if "state" in wanted:
        slides = np.where(rises, np.int8(SLIP_FORWARD), np.int8(SLIP_REVERSE))[:, None]
        state = np.where(
            _within(contact_edges, x),
            np.where(_within(stick_edges, x), np.int8(STICK), slides),
            state,
        )
    approach = (
        leaning.approach(middle, half, load, tilt) if "normal_approach" in wanted else nothing[:, 0]
    )
    work = math.nan
    loop = math.nan
    density = np.full(len(x), math.nan)
    errors = {}
    if "dissipation" in wanted:
        loop = loop_of(ways)
        work, errors["dissipation"] = _work_in_phase(ways)
    if "dissipation_density" in wanted:
        density, errors["dissipation_density"] = _density_in_phase(ways, x)
    stays = stick_edges[np.argmax(force)]
    lower, upper = loads.stresses(time)
    return _answer(
        scene,
        wanted,
        "steady",
        "the second cycle ends in the state it started from",
        list(neglected_coupling(scene.material)),
        {name: error for name, error in errors.items() if error > PROMISED},
        {"quadrature_nodes": 4 * WAY_NODES**2, "cycles_solved": 1},
        {},
        {"dissipation": clock.perf_counter() - started},
        {"pressure": pressure, "shear": nothing, "slip": nothing},
        cycles="steady",
        time=time + period,
        x=x,
        normal_load=load,
        tangential_load=force,
        state=state,
        contact_edges=contact_edges,
        stick_edges=stick_edges,
        contact_half_width=half,
        stick_half_width=stick_half,
        tangential_displacement=nothing[:, 0],
        normal_approach=approach,
        dissipation=work,
        loop_work=loop,
        cycle_dissipation=np.array([work]),
        dissipation_density=density,
        permanent_stick_half_width=float(np.diff(stays)[0]) / 2,
        permanent_stick_edges=stays,
        steady_from=1,
        bulk_stress_lower=lower,
        bulk_stress_upper=upper,
        tilt=tilt,
        moment=leaning.moment(middle, half, load, tilt),
    )


def memory_at(scene: Scene, time: Array) -> tuple[SymmetricContact, Snapshot]:
    """Normal contact of a scene, and its memory curves at instants (n,) of its load path.

    Raises
    ------
    InputError, InadmissibleLoadError
        As `solve`.
    """
    contact, path = contact_of(scene.profile, scene.material), _path_of(scene, time)
    if isinstance(path, History):
        return contact, path.snapshot(time)
    point, fold = folded(np.zeros(1))
    request = Request(
        contact, composite_modulus(scene.material), time, point, point, fold, frozenset({"shear"})
    )
    return contact, _along_series(path, request).snapshot


def _path_of(scene: Scene, time: Array | None) -> LoadSeries | History:
    """The scene's own path, followed by straight steps where no leg is curved: on a curved one some
    sum of P and Q turns round.
    """
    if not isinstance(scene.load, TimeSeriesLoad):
        path = scene.load.path()
        if any(leg.most_turns for leg in (*path.initial_loading, *path.cycle)):
            return history_of(path, scene.friction.coefficient, scene.cycles, time)
    return series_of(scene, time)


# ----------------------------------------------------------------- what a path leaves for an answer
@dataclass(frozen=True, eq=False)
class Along:
    """What a followed path leaves for an answer, whichever way it was followed.

    Attributes
    ----------
    snapshot : memory curves at the instants; without their pieces where no field needs them
    balance : (n,) M(P) - Q there
    least, slipped_share : least P_c of the last cycle, largest (P - P_c)/P of all that was followed
    each, each_error : (n_cycles,) friction work of the covered cycles, NaN where it was not wanted;
    largest relative error density, density_error : (k,) W(x) of the last cycle, NaN likewise; its
    error over its largest value
    loop : closed integral of Q dU of the last cycle and what rounding may have left in it; None
    where it is not steady spans : of the last cycle, none for straight steps
    increments : (n,) friction work since the instant before, empty where instants lie between rows
    counts, stick : what was done; how many quadratures were not, since nothing slips
    """

    snapshot: Snapshot
    balance: Array
    least: float
    slipped_share: float
    each: Array
    each_error: float
    density: Array
    density_error: float
    loop: tuple[float, float] | None
    spans: Sequence[Span]
    increments: Array
    counts: dict[str, int]
    stick: int


def _along_series(series: LoadSeries, request: Request) -> Along:
    """States at the instants of the request and the friction work of the cycles; parts are followed
    once more where it is needed.

    Raises
    ------
    InputError
        For a time outside the path.
    """
    contact, fields, friction, starts = (
        request.contact,
        request.fields,
        series.friction,
        series.starts,
    )
    unit, whole, pointwise = (
        2 / (math.pi * request.modulus),
        "dissipation" in fields,
        "dissipation_density" in fields,
    )
    step, share, near = series.locate(request.time)
    order = np.lexsort((share, step))
    back, step, share, near = np.argsort(order), step[order], share[order], near[order]
    at_rows = whole and bool(np.all((share == 1) | ((share == 0) & (step == 0))))
    covered = [number + series.first for number in series.covered]
    looked = np.searchsorted(starts, step[[0, -1]], side="right") - 1
    needed = sorted({*covered, *range(int(looked[0]), int(looked[1]) + 1)})
    steady = series.steady_from is not None and series.covered[-1] >= series.steady_from
    states = States(friction, not fields.isdisjoint(("shear", "slip", "tangential_displacement")))
    works, errors, shares = (np.zeros(len(series.parts)) for _ in range(3))
    each = np.zeros(1 + (starts[-1] if at_rows else 0))
    density, least, stick = np.zeros(len(request.distance)), math.inf, 0
    largest = float(np.max(series.parts[covered[-1]].rows[:, 1]))
    loop = Loop(contact, request.modulus, friction, largest) if whole and steady else None
    counts = dict.fromkeys(
        (
            "spans",
            "slips",
            "pieces_alive",
            "pieces_dropped",
            "slip_quadratures",
            "quadrature_nodes",
        ),
        0,
    )
    for k in needed:
        part, last, worked = series.parts[k], k == covered[-1], whole and (at_rows or k in covered)
        alive = depth_of(part.curve)
        for begin, block in blocks(part, friction, states.curves):
            records, slips, steps = block.records, block.records.slipping(), len(block.rows) - 1
            here = slice(
                *np.searchsorted(step, [starts[k] + begin, starts[k] + begin + steps]).tolist()
            )
            states.add(block, step[here] - starts[k] - begin, share[here], near[here])
            shares[k] = max(shares[k], block.deepest / float(np.max(part.rows[:, 1])))
            integrals = worked + (pointwise and last)
            counts["spans"] += len(records.row)
            counts["slips"] += len(slips.row)
            counts["slip_quadratures"] += integrals * len(slips.row)
            stick += integrals * (len(records.row) - len(slips.row))
            # each step puts one on
            counts["pieces_dropped"] += steps + alive - depth_of(block.curve)
            counts["pieces_alive"], alive = (
                max(counts["pieces_alive"], block.alive),
                depth_of(block.curve),
            )
            if worked:
                work, nodes = slip_work(contact, slips)
                works[k] += unit * friction * float(np.sum(work))
                errors[k] += unit * friction * work_error(contact, slips)
                counts["quadrature_nodes"] += nodes
                if at_rows:
                    first = starts[k] + begin + 1
                    each[first : first + steps] = (
                        unit * friction * np.bincount(slips.row, work, steps)
                    )
            if last:
                fronts = records.load - records.slipped, records.load_after - records.slipped_after
                least = min(least, *(float(np.min(front)) for front in fronts))
                if loop is not None:
                    loop.add(block)
                if pointwise:
                    density += (
                        unit * friction * density_of_records(contact, slips, request.distance)
                    )
    rounding = 3 * np.array([rounding_of_slip(share) for share in shares.tolist()])
    errors = np.divide(errors, works, out=np.zeros(len(works)), where=works > 0) + rounding
    so_far = np.cumsum(each)[(step + (share == 1))[back]] if at_rows else np.empty(0)
    snapshot, balance = states.snapshot(request.time, back)
    return Along(
        snapshot=snapshot,
        balance=balance,
        least=least,
        slipped_share=float(np.max(shares)),
        each=works[covered] if whole else np.full(len(covered), math.nan),
        each_error=float(np.max(errors[covered])) if whole else 0.0,
        density=density if pointwise else np.full(len(density), math.nan),
        density_error=rounding[covered[-1]] if pointwise else 0.0,
        loop=loop.value if loop is not None else None,
        spans=(),
        increments=np.diff(so_far, prepend=so_far[:1]),
        counts={
            "rows": len(series.times),
            **counts,
            "curves": len(snapshot.actives) if states.curves else 0,
        },
        stick=stick,
    )


def _along_spans(history: History, request: Request) -> Along:
    """States at the instants of the request and the friction work of the cycles, span by span.

    W of a steady ellipse comes from formulas that keep their digits, however small the slip.
    """
    contact, modulus, fields, last = (
        request.contact,
        request.modulus,
        request.fields,
        history.covered[-1],
    )
    snapshot, friction = history.snapshot(request.time), history.spans[0].friction
    balance = snapshot.direction * friction * snapshot.slipped - snapshot.force
    for piece, here in snapshot.groups():
        assert isinstance(piece, Piece)  # for the type checker: a history has no others
        balance[here] += value_on(piece, (snapshot.load - snapshot.slipped)[here])
    unit, ellipse = 2 / (math.pi * modulus) * friction**2, None
    turn = history.loop.ellipse if history.loop is not None else None
    if turn is not None and friction > 0:
        ellipse = ellipses_of(
            *(
                np.array([v])
                for v in (turn.mean[0], turn.amplitude[0], turn.amplitude[1], turn.phase, friction)
            )
        )
    works: dict[int, tuple[float, float]] = {}
    used: list[Span] = []
    for number in set(history.covered) if "dissipation" in fields else ():
        spans = history.cycles[number]
        used.extend(spans)
        if (
            ellipse is not None
            and history.steady_from is not None
            and number >= history.steady_from
        ):
            own = float(digits_of_loop(ellipse)[0])
            works[number] = (
                unit * float(sum(part[0] for part in works_over_time(ellipse, contact))),
                (own if own > PROMISED else 0.0),
            )
        else:
            split = global_dissipation(contact, modulus, spans)
            own = float(split.error / split.total) if split.error else 0.0
            works[number] = float(split.total), own + 3 * rounding_of_slip(slipped_share(spans))
    density: Array = np.full(len(request.distance), np.nan)
    density_error, spans = 0.0, history.cycles[last]
    if "dissipation_density" in fields:
        used.extend(spans)
        split = pointwise_dissipation(contact, modulus, spans, request.distance)
        density, worst = split.total, float(np.max(split.error))
        density_error = (worst / float(np.max(density)) if worst else 0.0) + 3 * rounding_of_slip(
            slipped_share(spans)
        )
    steady = bool(works) and history.steady_from is not None and last >= history.steady_from
    loop = closed_integral(contact, modulus, spans) if steady and works[last][0] else (0.0, 0.0)
    slipping = sum(span.direction != 0 for span in used)
    fronts = [
        span.leg.loads(time)[0] - span.slipped(time)
        for span in spans
        for time in (span.begin.time, span.end.time)
    ]
    return Along(
        snapshot=snapshot,
        balance=balance,
        least=float(min(fronts)),
        slipped_share=slipped_share(history.spans),
        each=np.array([works[number][0] if works else math.nan for number in history.covered]),
        each_error=max((error for _, error in works.values()), default=0.0),
        density=density,
        density_error=density_error,
        loop=loop if steady else None,
        spans=spans,
        increments=np.empty(0),
        counts={
            "spans": len(history.spans),
            "pieces_alive": max(sum(1 for _ in pieces(span.active)) for span in history.spans),
            "slip_quadratures": slipping,
            "quadrature_nodes": slipping * NODES,
        },
        stick=len(used) - slipping,
    )


# ------------------------------------------------------------------------------- fields at instants
def _series_of(request: Request, snapshot: Snapshot) -> dict[str, Array]:
    """Loads, half-widths, edges and rigid movements: (n,) or (n, 2); NotFoundError where no
    half-width was found for a load.
    """
    contact, fields = request.contact, request.fields
    factor, nothing = 2 / (math.pi * request.modulus), np.full(len(request.time), np.nan)
    front = snapshot.load - snapshot.slipped
    half = _half_width(contact, snapshot.load)
    slid = np.flatnonzero(snapshot.slipped)
    stick = half.copy()
    stick[slid] = _half_width(contact, front[slid])
    stick[(front <= 0) & (stick == 0)] = np.nan
    shift = (
        Integrals(contact, np.zeros(1), "shift").over(snapshot)[:, 0]
        if "tangential_displacement" in fields
        else nothing
    )
    sides, approach, more = np.array([-1.0, 1.0]), nothing, {}
    if "normal_approach" in fields:
        approach = factor * contact.log_distance(snapshot.load)
    edges, fronts = half[:, None] * sides, stick[:, None] * sides
    if (family := request.family) is not None:
        more = family.series(request.time, snapshot.load)
        more["shear_moment"] = Integrals(
            replace(family.contact, rigid="moment"), np.zeros(1), "shift"
        ).over(snapshot)[:, 0]
        edges = more.pop("contact_edges")
        half = np.diff(edges)[:, 0] / 2
        fronts = np.where(
            ((snapshot.slipped > 0) | np.isnan(stick))[:, None],
            family.contact.centre(front)[:, None] + fronts,
            edges,
        )
        approach = more.pop("normal_approach") if "normal_approach" in fields else nothing
    return more | {
        "normal_load": snapshot.load,
        "tangential_load": snapshot.force * (1.0 if family is None else family.contact.share),
        "tangential_displacement": factor * shift,
        "normal_approach": approach,
        "contact_half_width": half,
        "stick_half_width": stick,
        "contact_edges": edges,
        "stick_edges": fronts,
    }


def _half_width(contact: Contact, load: Array) -> Array:
    """a(P), (n,): an inverse that was not found, NaN, must not go on as an answer."""
    half = contact.half_width(load)
    lost = np.flatnonzero(~np.isfinite(half))
    if len(lost):
        raise NotFoundError(
            f"no half-width was found for the normal load {float(load[lost[0]]):.17g}"
        )
    return half


def _grids_of(
    request: Request, snapshot: Snapshot, series: Mapping[str, Array]
) -> tuple[dict[str, NDArray[Any]], dict[str, float]]:
    """pressure, shear, slip, state: (n, m), read-only; whatever was not asked for is NaN (open) and
    takes no room. Errors of arcs.

    NotFoundError where a value that is due was not found; tractions are infinite at the tip of a
    sharp wedge.
    """
    contact, x, fields = request.contact, request.distance, request.fields
    shape = (len(request.time), len(request.fold))
    grids: dict[str, NDArray[Any]] = {
        name: np.broadcast_to(np.nan, shape) for name in ("pressure", "shear", "slip")
    }
    grids["state"] = np.broadcast_to(np.int8(OPEN), shape)
    found: dict[str, NDArray[Any]] = {}
    if "pressure" in fields:
        if (family := request.family) is not None:
            m, c = np.mean(series["contact_edges"], axis=1), series["contact_half_width"]
            found["pressure"] = family.contact.pressure_over(x, m, c)
        else:
            found["pressure"] = contact.pressure(x, snapshot.load[:, None])
    shear, slip = Integrals(contact, x, "shear"), Integrals(contact, x, "slip")
    if "shear" in fields:
        found["shear"] = shear.over(snapshot)
    if "slip" in fields:
        found["slip"] = 2 / (math.pi * request.modulus) * slip.over(snapshot)
    if "state" in fields:
        # Where the ends slip opposite ways a direction is that of one side.
        sense = contact.sense(x).astype(int) if isinstance(contact, OppositeSlip) else 1
        sliding = np.array((SLIP_REVERSE, STICK, SLIP_FORWARD), dtype=np.int8)[
            snapshot.direction[:, None] * sense + 1
        ]
        sticks, touches = (_within(series[name], x) for name in ("stick_edges", "contact_edges"))
        inner = np.where(sticks, np.int8(STICK), sliding)
        found["state"] = np.where(touches & (snapshot.load[:, None] > 0), inner, np.int8(OPEN))
    for name, values in found.items():
        due = np.isfinite(values)
        if name in ("pressure", "shear"):
            due |= np.isinf(values) & (x == 0)
        if not np.all(due):
            instant, point = (int(each[0]) for each in np.nonzero(~due))
            raise NotFoundError(
                f"no {name} was found at |x| = {x[point]:.17g}, time {request.time[instant]:.17g}"
            )
        grid = values.take(request.fold, axis=1)
        grid.flags.writeable = False
        grids[name] = grid
    return grids, {"shear": shear.arc_error, "slip": slip.arc_error}


def _within(edges: Array, x: Array) -> NDArray[np.bool_]:
    """Whether points (k,) are between two edges (n, 2): (n, k); of no stick zone only its middle x
    = 0 is within.
    """
    low, high = (np.nan_to_num(edges[:, [side]]) for side in (0, 1))
    return (x >= low) & (x <= high)


def _points_of(contact: Contact, largest: float) -> Array:
    """Points across the largest contact and a little beyond; an unsymmetric one is not mirrored."""
    points = mirrored_points(1.05 * float(contact.half_width(largest)))
    return points + float(contact.centre(largest)) if isinstance(contact, TiltedProfile) else points


# ------------------------------------------------------------------- what a solution says of itself
def _errors(
    request: Request,
    found: Along,
    series: dict[str, Array],
    grids: dict[str, NDArray[Any]],
    arcs: Mapping[str, float],
    work: float,
    loop: float,
) -> dict[str, float]:
    """Estimated errors of what was asked for over the largest p, f p, s, U, W(x) or W, where closed
    forms promise less.

    Those of pressure, shear and slip from a sample of instants and points. Tractions start like
    roots at the edges of contact and stick, so that a last digit of an edge counts for much more
    next to it: "... at the edge" is for the points that are asked for, however near; without these
    words for points 1 % of a away. `arcs` are the errors of integrals over arcs.

    Raises
    ------
    NotFoundError
        For an error that is not a number.
    """
    contact, fields, snapshot, friction = (
        request.contact,
        request.fields,
        found.snapshot,
        found.snapshot.friction,
    )
    errors, unit = {"dissipation_density": found.density_error}, 2 / (math.pi * request.modulus)
    if not fields.isdisjoint(("pressure", *arcs)):
        chosen = np.unique(np.linspace(0, len(snapshot.load) - 1, _INSTANTS).astype(int))
        loads = np.unique(np.append(snapshot.load[chosen], np.max(snapshot.load)))[:, None]
        x = request.distance[
            np.unique(np.linspace(0, len(request.distance) - 1, _PLACES).astype(int))
        ]
        p, slip = contact.pressure(x, loads), np.abs(grids["slip"])
        # p is infinite at the tip of a sharp wedge, s NaN where it was not asked for.
        top, size = (
            float(np.max(values, where=np.isfinite(values), initial=_TINY))
            for values in (p, slip / unit)
        )
        slips = size > _TINY
        along = {"shear": _largest(arcs["shear"]) / (friction * top) if friction else 0.0}
        along["slip"] = _largest(arcs["slip"]) / size if slips else 0.0
        if contact.closed_form or isinstance(contact, TiltedProfile):
            errors |= {name: value for name, value in along.items() if value > PROMISED}
        elif top > _TINY:
            knots = (
                2
                * max(
                    (sum(1 for _ in pieces(snapshot.actives[k])) for k in snapshot.which[chosen]),
                    default=0,
                )
                + 2
            )
            away = np.abs(x - contact.half_width(loads)) > _NEAR * contact.half_width(loads)
            kernel = (
                _largest(np.where(away, contact.quadrature_error("pressure", x, loads), 0.0)) / top
            )
            for words, near in (("", _NEAR), (" at the edge", 0.0)):
                halves = (series["contact_half_width"], series["stick_half_width"])
                edges, fronts = (
                    _at_edges(contact, request.distance, half, near) / top for half in halves
                )
                errors[f"pressure{words}"] = kernel + edges
                errors[f"shear{words}"] = along["shear"] + knots * kernel + edges + 2 * fronts
            if "slip" in fields and slips:
                left = _largest(contact.quadrature_error("slip_integral", x, loads))
                errors["slip"] = along["slip"] + knots * friction * left / size
    errors["slip"] = errors.get("slip", 0.0) + 8 * rounding_of_slip(found.slipped_share)
    if "tangential_displacement" in fields:
        shifts = series["tangential_displacement"] / unit
        errors["tangential_displacement"] = rounding_of_shift(
            friction, contact.log_distance(series["normal_load"]), shifts
        )
    if "dissipation" in fields:
        # Of the two routes W keeps more digits where slip is tiny: what they differ by is the error
        # of the other one.
        apart = abs(loop / work - 1) if math.isfinite(loop) and work > 0 else 0.0
        errors["loop_work"] = (
            found.each_error + apart if found.each_error + apart > PROMISED else 0.0
        )
        errors["dissipation"] = found.each_error
        if work > 0 and not contact.closed_form:
            # What the last digits of U leave in the loop says nothing of W.
            rounding = _OF_LOOP * found.loop[1] / work if found.loop is not None else 0.0
            if apart > rounding and slipped_share(found.spans) > _SLIPS_ENOUGH:
                errors["dissipation"] += apart
            errors["dissipation"] += (
                unit * math.fsum(_left_of_work(contact, span) for span in found.spans) / work
            )
        errors["dissipation_density"] += errors["dissipation"]
    names = (*fields, "loop_work", *(f"{name} at the edge" for name in fields))
    return {name: error for name, error in errors.items() if error and name in names}


def _largest(values: ArrayLike) -> float:
    largest = float(np.max(np.asarray(values, dtype=float), initial=0.0))
    if not math.isfinite(largest):
        raise NotFoundError(
            "an error that is to be estimated is not a number: what it is of cannot be trusted"
        )
    return largest


def _at_edges(contact: SymmetricContact, x: Array, half: Array, least: float) -> float:
    """What the error of a half-width does to a pressure (g/pi) sqrt(2 d/a) at the small distance d
    of the nearest point.
    """
    inside = half[np.isfinite(half) & (half > 0)]
    after = np.clip(np.searchsorted(x, inside), 1, max(len(x) - 1, 1))
    near = np.minimum(
        np.abs(x[after - 1] - inside), np.abs(x[np.minimum(after, len(x) - 1)] - inside)
    )
    near = np.maximum(near, least * inside)
    rate = contact.stiffness(inside)
    doubt = 40 * _EPS * inside + contact.noise * contact.load(inside) / np.where(
        rate > 0, rate, np.inf
    )
    return _largest(rate / np.pi * np.sqrt(2 / inside) * (np.sqrt(near + doubt) - np.sqrt(near)))


def _left_of_work(contact: Contact, span: Span) -> float:
    """What the quadratures of Lam leave out of f int w' Lam dt over a span."""
    if not span.direction or span.active is None:
        return 0.0
    times = np.linspace(span.begin.time, span.end.time, 9)[1:-1]
    growth = np.maximum(span.leg.rate_of(level(span.direction, span.friction), times), 0.0)
    error = contact.quadrature_error(
        "dissipation_kernel", span.leg.loads(times)[0], span.slipped(times)
    )
    return span.friction * _largest(growth * error) * (span.end.time - span.begin.time)


def _neglected_loads(family: OneCurve | None) -> Iterator[str]:
    """A sentence for each load that is below rounding and was left out, so that the memory of
    friction is one curve.
    """
    for name, share in (family.neglected if family is not None else {}).items():
        size = f"{share:.1e} of what makes an edge of contact slip"
        yield f"{name}: {size} is below rounding and was left out of the memory of friction"


def neglected_coupling(material: Materials) -> Iterator[str]:
    """A sentence where the materials couple normal and shear tractions, which half-plane theory
    here leaves out.
    """
    beta = coupling_constant(material)
    if beta != 0:
        yield (
            f"Dundurs' beta = {beta:.6g}: the bodies are unlike, and the coupling of normal and"
            " shear tractions is neglected"
        )


def _admissibility(
    friction: float, found: Along, grids: Mapping[str, NDArray[Any]], fields: frozenset[str]
) -> dict[str, Array]:
    """|M(P) - Q| over f max P, and the largest |q| - f p over f max p where both were asked for;
    both (n,) and 0 at best.
    """
    tiny = np.finfo(float).tiny
    checks = {
        "tangential_balance": freeze(
            np.abs(found.balance) / max(friction * float(np.max(found.snapshot.load)), tiny)
        )
    }
    if "pressure" in fields and "shear" in fields:
        # At the tip of a wedge p is infinite: no q is outside the cone there, and none is a measure
        # of the others.
        with np.errstate(invalid="ignore"):
            beyond = np.fmax.reduce(
                np.abs(grids["shear"]) - friction * grids["pressure"], axis=1, initial=0.0
            )
        largest = np.max(grids["pressure"], where=np.isfinite(grids["pressure"]), initial=0.0)
        checks["cone"] = freeze(beyond / max(friction * float(largest), tiny))
    return checks


@cache
def _versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    try:
        own = metadata.version("halfplane")
    except metadata.PackageNotFoundError:
        own = "not installed"
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "halfplane": own,
    }
