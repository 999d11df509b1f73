"""Likely causes of the difference between a result and its reference, from the pattern of the
difference.

Each fault of a closed set is a hypothesis: "the result is the reference, but for this". It predicts
tractions p*, q* on the result's points and instants, its free figure fitted by least squares, and
explains the share

    e = 1 - |found - predicted|^2 / |found - expected|^2

of the discrepancy. The norm is that of p/p_ref and q/(f p_ref) over x and time, so that errors of
pressure and shear that are the same share of their scales count alike. A prediction is taken rather
than a linear mode, since large faults are not linear: a sign, a factor of a thousand, a contact
half as wide. The one that leaves least unexplained is named first; it is then mended, and the rest
looked at again, so that two faults at once are both found.

Faults of the file (a sign, two columns swapped, a factor) act on the reference's arrays. Faults of
the question (wrong modulus or friction, no memory, not yet steady, other instants) have the exact
answer of a neighbouring scene. A mesh too coarse at the edges and bodies that are not alike are
recognised by where the discrepancy lies. Faults of the model are recognised by what plainer ones
behind each other leave: creep changes the shear alone; soft faces widen the contact and a near base
narrows it, each in a way that another E*/R does not.
"""

from __future__ import annotations

import contextlib
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import resources
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from halfplane_fe.dundurs import dundurs
from reports.comparison import Comparison
from reports.comparison.measures import norm, over, shares
from reports.comparison.verdicts import Verdict, verdict_on
from reports.measured import noise_of
from reports.scoring.surface import spikes
from scenes import STICK, InputError, LineOfAction, Materials, PolygonLoad, Scene, Wave, WaveSum
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

Tractions = Array
"""(2, k, n): pressure and shear at instants and points [stress]."""

# A hypothesis that explains less is no pattern: a fault of the set, fitted, leaves far less behind.
_LEAST_EXPLAINED = 0.5
# What explains this much is exact but for rounding and the points taken; and for the rounding
# alone.
_CLEAR = 0.999
_EXACT = 1 - 1e-12
# Steps of one search: golden sections alone narrow its interval to 1e-6 in thirty.
_MOST_STEPS_OF_SEARCH = 60
# Faults looked for behind each other: behind two, what is left is the rounding of the first two
# fits.
_ROUNDS = 3
# A rival this much weaker than the winner is not worth a line.
_LEAST_STRENGTH = 0.05
# Behind a fault that was mended, tolerances that the rest must exceed to be looked at: a fit is not
# exact.
_REST = 2.0
UNKNOWN = "unknown"
NOISE = "noise"
# Faults that change the resultant of the pressure by their factor. Where it has moved by less than
# this share of the change, none of them is there.
_OF_LOAD = ("units", "traction_factor", "pressure_factor", "loads", "half_model")
_UNMOVED = 1 / 3
# Elements over the half-width below which the mesh itself is the first cause to look at, and those
# that an engineer should take.
_FEWEST_ELEMENTS = 4.0
_ENOUGH_ELEMENTS = 10
# Of f p, below which a point sticks for certain; of the largest step of the slip, below which it
# rests.
_STICKS = 0.9
_AT_REST = 1e-3
# Share of the creep that is proportional to the change of the shear, where a penalty makes it; over
# the largest step of slip, below which nobody need know; fewest points and instants that show it.
_PROPORTIONAL = 0.9
_NO_CREEP = 3e-3
_FEWEST_CREEPING = 20
# Share of the points that should stick and lie on the Coulomb limit, where nothing sticks; of f p,
# how
# near to the limit is on it: shear beyond it is another fault.
_ALL_SLIP = 0.9
_ON_LIMIT = 0.01
# Over P, to which the pressures of a mesh of any size add up: they are nodal forces over the
# elements.
_SAME_RESULTANT = 0.02
# Standard deviations of the noise by which a point may exceed the Coulomb limit and the contact law
# still be kept.
_BY_NOISE = 5.0
# A steady cycle has some ten features (turning points, ends of full stick); three instants to each
# are enough to tell faults apart.
_MOST_INSTANTS = 32
# A fitted factor counts as the round one that it is near: a mesh does not move a resultant by more.
# A factor of a hundred or more is one of units even farther off: what is left of it is another
# fault.
_NEAR = 0.02
_NEAR_OF_UNITS = 0.25
# Below this a factor is no fault of a file: modulus, radius or loads explain it better. A factor of
# p alone has no rival: no elastic contact has another pressure and the same width and shear.
_LEAST_FACTOR = 0.01
_LEAST_OF_PRESSURE = 1e-3
# A fitted factor of the question that is nearer to 1 is the error of a mesh, and no other question.
_FITTED_FACTORS = ("stiffness", "loads", "friction")
_LEAST_OF_FIT = 0.005
# Of the discrepancy, where a prediction has no solution: finite, for the parabolas of a search.
_NOTHING = 1e30
# Logarithms of the factors of E*/R or of the loads that are looked at first, and of f; those of f
# at which next to nothing slips: a mesh keeps the infinite shear of bonded faces finite, as a large
# f does.
_FACTORS = tuple(np.log([0.2, 0.5, 0.75, 0.9, 0.97, 1.0, 1.03, 1.1, 1.33, 2.0, 5.0]))
_OF_FRICTION = tuple(np.log([0.4, 0.7, 0.9, 1.0, 1.1, 1.4, 2.0, 4.0]))
_NO_SLIP = tuple(np.log([15.0, 50.0, 300.0]))
# Loads that differ by less than this share of the largest P are one: those of one revolution and
# the next differ by rounding.
_SAME_LOAD = 1e-9
# Longest cycle, in steps, whose steps may be too long as a solver takes them whose law holds at
# their ends.
_MOST_STEPS = 64
# Spacings to each side of an edge that a mesh can get wrong: the element with the edge in it, and
# its neighbour.
_REACH = 2.0
# A traction that leaves the edge as a root has an error of about sqrt(2 h/a) of its peak over the
# element with the edge: shear, at stick edges, up to 1.2 of that on meshes of a/5 to a/24, pressure
# up to 0.36, its edge being found to a part of an element. A soft layer or a short body moves the
# pressure's edge by 0.7 to 1.5 of that.
_MOST = (0.4, 1.0)
# Of the discrepancy that two plainer faults behind each other leave, above which the model is at
# fault: two planted ones leave a thousandth, soft layers, creep and small bodies 0.05 to 0.9. Least
# share that is even in x: of unlike bodies it is 0.3 at most.
_UNACCOUNTED = 0.04
_EVEN = 0.9
# What a hypothesis must explain more than a plainer one, for each figure fitted: of two that
# explain all, the plainer is named. A coarse edge and an odd part take what they find, point by
# point.
_COST = 0.01
_FITTED = {"coarse_edge": 10, "coupling": 5} | dict.fromkeys(
    (
        "traction_factor",
        "pressure_factor",
        "offset",
        "stiffness",
        "loads",
        "friction",
        "other_times",
    ),
    1,
)
# Sentences of each fault, of other findings, and quotients of E*/R with a likely cause.
_WORDS = tomllib.loads(
    (resources.files("reports") / "templates" / "faults.toml").read_text("utf-8")
)
FAULTS: dict[str, str] = _WORDS["faults"]
_NO_COUPLING = 1e-9


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """What is to be explained: some instants of the last cycle, all points."""

    comparison: Comparison
    rows: NDArray[np.intp]  # (k,), the instants taken, of the last cycle's
    expected: Tractions  # of the reference
    found: Tractions  # of the result; where it has no number, the reference's
    weight: Array  # (k, n) of the squares, 0 where the result has no number
    missing: float  # share of the result's tractions that are no numbers
    # the question that `expected` answers: the comparison's, or with a fault in it that was found
    # before
    scene: Scene
    exact: bool  # whether `expected` is half-plane theory of `scene`
    sheared: bool = True  # whether the shear counts

    @property
    def x(self) -> Array:
        """(n,) [length]."""
        return self.comparison.found.x

    @property
    def time(self) -> Array:
        """(k,) of the load path."""
        return self.comparison.found.time[self.rows]

    @property
    def fraction(self) -> Array:
        """(k,) of the cycle of the load path, from its start."""
        return fraction_of_cycle(self.comparison)[self.rows]

    @property
    def on_cycle(self) -> bool:
        """Whether the path repeats, and every instant lies on its cycle."""
        path = self.scene.load.path()
        return path.period is not None and bool(self.comparison.found.time[0] >= path.cycle_start)

    @property
    def normal_load(self) -> Array:
        """(k,) P of the reference [force / thickness]."""
        return self.comparison.expected.normal_load[self.rows]

    @property
    def resultants(self) -> Array:
        """(k,) integral of the pressure found over x [force / thickness]."""
        return np.asarray(np.trapezoid(self.found[0], self.x, axis=1))

    @property
    def loaded(self) -> NDArray[np.bool_]:
        """(k,) instants with more than a hundredth of the largest P."""
        return self.normal_load > 0.01 * self.comparison.scales.normal_load

    @property
    def unsymmetric(self) -> bool:
        """Whether bulk stress, tilt or unequal sides make tractions that are not even in x."""
        return self.comparison.pulled or self.comparison.turned

    @property
    def of_pressure(self) -> Discrepancy:
        """That of the pressure alone: between like bodies it knows nothing of friction, and tells
        the rest apart.
        """
        return replace(self, sheared=False)

    @property
    def units(self) -> Array:
        """(2, 1, 1): p_ref and f p_ref."""
        return _pair(self.comparison.scales.pressure, self.comparison.scales.shear)

    @cached_property
    def beyond_theory(self) -> Tractions | float:
        """What is expected less half-plane theory of the scene; 0 where it is that."""
        if self.exact:
            return 0.0
        found = semi_analytic.solve(
            self.scene, x=self.x, time=self.time, fields=("pressure", "shear")
        )
        return self.expected - np.array([found.pressure, found.shear])

    def product(self, one: Tractions, other: Tractions) -> float:
        """Weighted scalar product of two pairs of tractions over their units."""
        return float(np.sum(self.weight * one * other * _pair(1, self.sheared) / self.units**2))

    def apart(self, predicted: Tractions) -> float:
        """Weighted square of found less predicted; infinite where the prediction holds a NaN."""
        off = self.found - predicted
        value = self.product(off, off)
        return value if np.isfinite(value) else float("inf")

    def explained(self, predicted: Tractions) -> float:
        """Share of the discrepancy that `predicted` explains: 1 is all, 0 none, below 0 makes it
        worse.
        """
        whole = self.apart(self.expected)
        return 1 - self.apart(predicted) / whole if whole > 0 else 0.0

    def errors(self) -> tuple[float, float]:
        """||p - p_ref||/||p_ref|| and ||q - q_ref||/(f ||p_ref||) at the worst of the instants."""
        sizes = norm(self.x, self.expected[0]) * _pair(1, self.comparison.scales.friction)[:, :, 0]
        p, q = np.nanmax(
            over(norm(self.x, self.found - self.expected), sizes), axis=1, initial=0.0
        ).tolist()
        return p, q

    def within(self, times: float = 1.0) -> bool:
        """Whether both errors are within so many tolerances of the scene."""
        limits = [
            times * (self.comparison.scene.tolerances.limit(key) or 0.0)
            for key in ("pressure", "shear")
        ]
        return all(
            verdict_on(*pair) is Verdict.WITHIN for pair in zip(self.errors(), limits, strict=True)
        )


def fraction_of_cycle(comparison: Comparison) -> Array:
    """(k,) share of a period at each instant, from the start of the path's cycle.

    From 0 to 1, or from somewhere between to one period later. Of instants that are no whole
    cycle each counts from the start of its own revolution. The time itself where nothing repeats.
    """
    path = comparison.scene.load.path()
    found = comparison.found
    if path.period is None or found.whole:
        return found.fraction
    return np.asarray(np.mod((found.time - path.cycle_start) / path.period, 1.0))


def _pair(of_pressure: float, of_shear: float) -> Array:
    """(2, 1, 1): a factor for each of the tractions."""
    return np.array([of_pressure, of_shear], dtype=float)[:, None, None]


def discrepancy(comparison: Comparison) -> Discrepancy | None:
    """The discrepancy of `comparison`; None where the result has no instant with a contact or not
    one number.
    """
    usable = np.flatnonzero(comparison.judged if comparison.judged.any() else comparison.touching)
    if not len(usable):
        return None
    rows = usable[
        np.unique(
            np.linspace(0, len(usable) - 1, min(len(usable), _MOST_INSTANTS)).round().astype(int)
        )
    ]
    expected, found = (
        np.array([side.pressure[rows], side.shear[rows]])
        for side in (comparison.expected, comparison.found)
    )
    sheared = not np.isnan(found[1]).all()
    if not sheared:  # a file without shear: it counts for nothing
        found[1] = np.nan_to_num(expected[1])
    known = np.isfinite(expected).all(axis=0) & np.isfinite(found).all(axis=0)
    known &= ~(spikes(comparison.found.pressure) | spikes(comparison.found.shear))[rows]
    if not known.any():
        return None
    weight = known * shares(comparison.found.time[rows])[:, None] * shares(comparison.found.x)
    expected = np.nan_to_num(expected)
    exact = comparison.reference.engine == "semi_analytic"
    left_out = float(1 - known.mean())
    found = np.where(known, found, expected)
    return Discrepancy(
        comparison,
        rows,
        expected,
        found,
        weight / weight.sum(),
        left_out,
        comparison.scene,
        exact,
        sheared,
    )


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One fault, fitted."""

    fault: str  # its key, of `FAULTS`
    predicted: Tractions  # of a result that has just this fault
    # what was fitted or measured, by name
    figures: Mapping[str, float] = field(default_factory=dict)
    # Takes the fault out of the tractions found; None where the next fault is looked for beyond
    # what this one predicts.
    mend: Callable[[Tractions], Tractions] | None = None
    # the question that `predicted` is the exact answer of; None where there is no such scene
    scene: Scene | None = None

    def mended(self, what: Discrepancy) -> Discrepancy:
        """What is left to explain without this fault."""
        if self.mend is not None:
            return replace(
                what, found=np.where(what.weight > 0, self.mend(what.found), what.expected)
            )
        if self.scene is None or not what.exact:
            return replace(what, expected=self.predicted, exact=False)
        return replace(what, expected=self.predicted, scene=self.scene)


def _fitted(
    what: Discrepancy,
    predict: Callable[[float], Tractions],
    tries: Sequence[float],
    close: float = 1e-6,
) -> tuple[float, Tractions] | None:
    """The figure that leaves least of the discrepancy, to `close` of the range of the tries
    (ascending), and its prediction.

    Brent's search between the neighbours of the best of the tries; None where no try has a
    solution.
    """
    from scipy.optimize import minimize_scalar

    seen: dict[float, tuple[float, Tractions]] = {}

    def left(figure: float) -> float:
        with contextlib.suppress(InputError):  # gross sliding, separation
            tractions = predict(figure)
            seen[figure] = what.apart(tractions), tractions
        return min(seen[figure][0], _NOTHING) if figure in seen else _NOTHING

    best = int(np.argmin([left(figure) for figure in tries]))
    if not seen:
        return None
    bounds = tries[max(best - 1, 0)], tries[min(best + 1, len(tries) - 1)]
    closeness = {"xatol": close * (tries[-1] - tries[0]), "maxiter": _MOST_STEPS_OF_SEARCH}
    minimize_scalar(left, bounds=bounds, method="bounded", options=closeness)
    figure = min(seen, key=lambda figure: seen[figure][0])
    return figure, seen[figure][1]


def theory(
    what: Discrepancy,
    scene: Scene,
    time: Array | None = None,
    *,
    offset: float = 0.0,
    steps: Array | None = None,
) -> Tractions:
    """p and q of half-plane theory for another scene, at other times (in any order), with its
    centre at x = offset.

    `steps` are the ends of increments that go straight, (n,) ascending, among them the times. Where
    what is expected is not half-plane theory of the present scene, what the two differ by is added:
    the fault is then what the change of the scene changes.
    """
    wanted = what.time if time is None else time
    times = np.unique(wanted) if steps is None else steps
    found = semi_analytic.solve(
        scene,
        x=what.x - offset,
        time=times,
        fields=("pressure", "shear"),
        straight_steps=steps is not None,
    )
    at = np.abs(times[:, None] - wanted).argmin(axis=0)
    return np.array([found.pressure[at], found.shear[at]]) + what.beyond_theory


# ------------------------------------------------------------------------------- faults of the file
def _file_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """A sign, two columns swapped, a factor of both or of the pressure alone: k = <found,
    expected>/<expected, expected>.

    Widths set a factor apart from loads k times too large: no elastic contact carries k times the
    load on the same width.
    """
    expected = what.expected
    sheared = bool(np.any(what.expected[1]))

    def times(fault: str, of_pressure: float, of_shear: float, **figures: float) -> Hypothesis:
        factors = _pair(of_pressure, of_shear)
        return Hypothesis(fault, factors * expected, figures, mend=lambda found: found / factors)

    yield times("pressure_sign", -1, 1)
    if sheared:
        yield times("shear_sign", 1, -1)
        yield Hypothesis("swapped", expected[::-1], mend=lambda found: found[::-1])
        yield Hypothesis("frictionless", _pair(1, 0) * expected)
    k, of_p = (
        one.product(one.found, expected) / one.product(expected, expected)
        for one in (what, what.of_pressure)
    )
    if k > 0 and abs(k - 1) >= _LEAST_FACTOR:
        order = round(np.log10(k))
        off = abs(k / 10.0**order - 1)
        unit = order != 0 and off < (_NEAR_OF_UNITS if abs(order) >= 2 else _NEAR)
        factor = 10.0**order if unit and off >= _NEAR else k
        yield times(
            "units" if unit else "traction_factor",
            factor,
            factor,
            factor=10.0**order if unit else k,
        )
    if sheared and of_p > 0 and abs(of_p - 1) > _LEAST_OF_PRESSURE:
        yield times("pressure_factor", of_p, 1, factor=of_p)


# --------------------------------------------------------------------------- faults of the question
def stiffer(scene: Scene, factor: float) -> Scene:
    """E* times `factor`."""
    upper, lower = (
        body.vary(young_modulus=factor * body.young_modulus)
        for body in (scene.material.upper, scene.material.lower)
    )
    return scene.vary(material=Materials(upper=upper, lower=lower))


def with_friction(scene: Scene, coefficient: float) -> Scene:
    """The scene with another f."""
    return scene.vary(friction=coefficient)


def _question_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Every fault of the question that the discrepancy may have."""
    scene = what.scene
    path = what.scene.load.path()
    half_width = what.comparison.scales.half_width
    alone = what.of_pressure
    # Bulk stress, or tilt, of the other sign; left out.
    for name, keys in (
        ("bulk", ("bulk_stress_lower", "bulk_stress_upper")),
        ("tilt", ("tilt", "moment", "line_of_action")),
    ):
        stated = {key: value for key in keys if (value := getattr(scene.load, key)) is not None}
        wrong = {
            "sign": {key: _turned(value) for key, value in stated.items()},
            "left_out": dict.fromkeys(stated),
        }
        for how, changes in wrong.items() if stated else ():
            with contextlib.suppress(InputError):
                other = scene.vary(load=changes)
                yield Hypothesis(f"{name}_{how}", theory(what, other), scene=other)
    # E*/R times m: tractions know no more, since the gap scales with 1/R and the displacements with
    # 1/E*. Loads k times too large are the same with m = 1/k and every traction times k, by
    # linearity: their resultants are k times too large.
    if fit := _fitted(alone, lambda m: theory(what, stiffer(scene, np.exp(m))), _FACTORS):
        m = float(np.exp(fit[0]))
        yield Hypothesis("stiffness", fit[1], {"factor": m}, scene=stiffer(scene, m))
    if fit := _fitted(
        alone, lambda k: np.exp(k) * theory(what, stiffer(scene, np.exp(-k))), _FACTORS
    ):
        k = float(np.exp(fit[0]))
        yield Hypothesis(
            "half_model" if min(abs(k / 2 - 1), abs(2 * k - 1)) < 0.03 else "loads",
            fit[1],
            {"factor": k},
        )
    # p(x - d), q(x - d); d is looked for around what the centroid of the pressure has moved by.
    sums = [
        [float(np.sum(what.weight * p * by)) for by in (1.0, what.x)]
        for p in (what.found[0], what.expected[0])
    ]
    centres = [moment / total if total > 0 else 0.0 for total, moment in sums]
    centre = float(np.clip(centres[0] - centres[1], -2 * half_width, 2 * half_width))
    places = [centre + half_width * step for step in (-0.1, -0.02, 0.0, 0.02, 0.1)]
    fit = _fitted(alone, lambda d: theory(what, scene, offset=d), places)
    if fit and abs(fit[0]) > 1e-4 * half_width:
        yield Hypothesis("offset", fit[1], {"distance": fit[0] / half_width})
    if scene.friction.coefficient and np.any(what.expected[1]):
        yield from _history_faults(what)
    # so much of a period late
    if path.period is not None and what.on_cycle and len(what.rows) >= 4:
        start = path.cycle_start + 2 * path.period
        period = path.period

        def late(delay: float) -> Tractions:
            return theory(what, scene, start + np.mod(what.fraction - delay, 1.0) * period)

        fit = _fitted(what, late, np.linspace(-0.5, 0.5, 21).tolist())
        if fit and abs(fit[0]) > 1e-3:
            yield Hypothesis("other_times", fit[1], {"delay": fit[0]})


def _turned(value: Any) -> Any:
    """A bulk stress, tilt or moment of the other sign, in the form that it was stated in.

    >>> _turned(0.5), _turned((0.0, 2.0)), _turned(LineOfAction(x=1.0, height=3.0))
    (-0.5, (-0.0, -2.0), LineOfAction(x=-1.0, height=-3.0))
    """
    match value:
        case Wave():
            phase = value.phase_degrees + (180 if value.phase_degrees <= 0 else -180)
            return value.vary(
                mean=-value.mean,
                phase_degrees=phase,
                initial_loading=_turned(value.initial_loading),
            )
        case WaveSum():
            waves = tuple((amplitude, phase + 180) for amplitude, phase in value.harmonics)
            return value.vary(
                mean=-value.mean, harmonics=waves, initial_loading=_turned(value.initial_loading)
            )
        case LineOfAction():
            return value.vary(x=-value.x, height=-value.height)
        case tuple():
            return tuple(-one for one in value)
        case _ if callable(value):
            return lambda time: -value(time)
    return -value


def _history_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Another f; nothing slips; no memory; not yet steady; steps too long."""
    scene = what.scene
    path = what.scene.load.path()
    f = what.scene.friction.coefficient

    def of_friction(log_factor: float) -> Tractions:
        return theory(what, with_friction(scene, f * np.exp(log_factor)))

    if fit := _fitted(what, of_friction, _OF_FRICTION, 1e-4):
        factor = float(np.exp(fit[0]))
        yield Hypothesis(
            "friction", fit[1], {"factor": factor}, scene=with_friction(scene, f * factor)
        )
    if fit := _fitted(what, of_friction, _NO_SLIP, 1e-2):
        yield Hypothesis("full_stick", fit[1])
    # Cattaneo's first loading at every instant: q = sign(Q) f [p(x, P) - p(x, P - |Q|/f)].
    normal, tangential = (np.asarray(load)[:, None] for load in path.at(what.time))
    stuck = normal - np.abs(tangential) / f
    if np.all(stuck > 0) and not what.unsymmetric:
        contact = contact_of(scene.profile, scene.material)
        shear = (
            np.sign(tangential)
            * f
            * (contact.pressure(what.x, normal) - contact.pressure(what.x, stuck))
        )
        yield Hypothesis("memoryless", np.array([what.expected[0], shear]))
    if path.period is not None and what.on_cycle:
        later = np.where(what.fraction > 1, what.fraction - 1, what.fraction)
        time = path.cycle_start + np.minimum(later, 1 - 1e-12) * path.period
        yield Hypothesis("not_steady", theory(what, scene, time))
        # straight lines, which not every bulk stress and tilt has
        with contextlib.suppress(InputError):
            yield from _long_steps(what, path.period)


def _long_steps(what: Discrepancy, period: float) -> Iterator[Hypothesis]:
    """The result's increments in place of the path: straight lines, and as a solver takes them
    whose law holds at their ends.

    While P rises such an increment is that of P first and then that of Q at the new pressure; while
    P falls it is a straight line. Finite elements in steps that end on no event follow it to 0.983
    of the discrepancy at 48 steps a cycle, to 0.9999 at 4.
    """
    path = what.scene.load.path()
    own = what.comparison.found
    whole = what.comparison.result.time
    times = whole[whole <= own.time[-1]]
    wanted = what.time
    steps = {"steps": float(len(own.time) - 1)}
    if whole[0] > path.cycle_start:  # the cycle alone: twice, after the initial loading
        fraction = fraction_of_cycle(what.comparison)
        cycles = [path.cycle_start + (turn + fraction) * period for turn in (0, 1)]
        times = np.concatenate([np.linspace(path.start, path.cycle_start, 9), *cycles])
        wanted = path.cycle_start + (1 + what.fraction) * period
    times = np.unique(times[times > path.start])
    yield Hypothesis("steps", theory(what, what.scene, wanted, steps=times), steps)
    if what.unsymmetric or len(own.time) - 1 > _MOST_STEPS:
        return
    points = [(0.0, 0.0)]
    ends = []
    least = _SAME_LOAD * float(np.max(path.at(times)[0]))
    for normal, tangential in np.transpose(path.at(times)).tolist():
        rises = normal > points[-1][0]
        for point in (
            ((normal, points[-1][1]), (normal, tangential)) if rises else ((normal, tangential),)
        ):
            if max(abs(point[0] - points[-1][0]), abs(point[1] - points[-1][1])) > least:
                points.append(point)
        ends.append(float(len(points) - 1))  # a polygon takes one unit of time a leg
    scene = what.scene.vary(load=PolygonLoad(initial_loading=tuple(points[1:])))
    yield Hypothesis(
        "steps",
        theory(what, scene, np.array(ends)[np.abs(times[:, None] - wanted).argmin(axis=0)]),
        steps,
    )


# -------------------------------------------------------------------- faults told by where they lie
def _odd_part(what: Discrepancy) -> Tractions:
    """Of found less expected, what turns round with x."""
    off = what.found - what.expected
    return (off - np.apply_along_axis(lambda row: np.interp(-what.x, what.x, row), 2, off)) / 2


def _unlike_bodies(what: Discrepancy) -> Iterator[Hypothesis]:
    """The odd part of the discrepancy in x: of p and q of like, symmetric bodies there is none,
    whatever else is wrong.

    It is 0.73 to 0.99 of what unlike materials change, and 0 of every other fault of a model
    (measured on the planted faults).
    """
    if what.scene.friction.coefficient and np.any(what.found[1]) and not what.unsymmetric:
        yield Hypothesis("coupling", what.expected + _odd_part(what))


def _coarse_edge(what: Discrepancy) -> Hypothesis:
    """The part of the discrepancy within two spacings of an edge, as far as the spacing can account
    for its size.

    An elastic traction leaves the edge of contact as (1 - x/a)^(1/2), and q the stick edge
    likewise. Interpolated on elements of length h its error is of the order of p_ref sqrt(2 h/a)
    over the element with the edge. What goes beyond that is not the mesh's. The edges are those of
    the instant, and those of the smallest stick zone: what a mesh gets wrong there stays locked in.
    """
    x = what.x
    scales = what.comparison.scales
    cycle = what.comparison.expected
    steps = np.diff(x)
    spacing = np.maximum(np.append(steps, steps[-1]), np.insert(steps, 0, steps[0]))
    places = [
        edge
        for edges in (cycle.contact_edges, cycle.stick_edges)
        for edge in edges[what.rows].T[:, :, None]
    ]
    if np.isfinite(cycle.stick_edges).any():
        least = np.nanmin(np.abs(cycle.stick_edges))
        inner = np.nanmax(cycle.stick_edges[:, 0]), np.nanmin(cycle.stick_edges[:, 1])
        places += inner if what.unsymmetric else (-least, least)
    with np.errstate(invalid="ignore"):
        near = np.any(
            [
                np.broadcast_to(np.abs(x - edge) <= _REACH * spacing, what.expected[0].shape)
                for edge in places
            ],
            axis=0,
        )
    most = _pair(*_MOST) * np.sqrt(2 * spacing / scales.half_width) * what.units
    part = np.where(near, np.clip(what.found - what.expected, -most, most), 0.0)
    edge = (
        float(np.median(spacing[near.any(axis=0)])) / scales.half_width
        if near.any()
        else float("nan")
    )
    return Hypothesis("coarse_edge", what.expected + part, {"spacing": edge})


# ------------------------------------------------------------------------------ faults of the model
def _model_fault(what: Discrepancy, best: Hypothesis | None, left: float) -> Iterator[Diagnosis]:
    """The fault of the model that a discrepancy looks like of which plainer faults leave a share
    `left`.

    `best` is the first of these, None where none explains half. Creep of faces that should stick
    does not move the pressure, and no fault of the question explains half of it. Faces that sink
    into each other make the contact wider than that of half-planes, as bodies less stiff do, but
    end the pressure without a root; a base too near makes it narrower, and holds shear and pressure
    back unlike. Theory of other stiffness explains 0.6 to 0.9 of either.
    """
    even = what.explained(what.found - _odd_part(what))
    if what.unsymmetric or even < _EVEN:
        return
    pressed = (
        verdict_on(what.errors()[0], what.comparison.scene.tolerances.limit("pressure") or 0.0)
        is Verdict.WITHIN
    )
    if (
        pressed
        and (best is None or best.fault == "coarse_edge")
        and what.scene.friction.coefficient
        and np.any(what.found[1])
    ):
        fault = "elastic_slip"
        trace = "the pressure is right"
    elif not pressed and best is not None and best.fault == "stiffness":
        factor = best.figures["factor"]
        fault = "soft_normal" if factor < 1 else "small_body"
        trace = (
            f"the contact is {'wider' if factor < 1 else 'narrower'}, most like that of bodies"
            f" {factor:.3g} times as stiff"
        )
    else:
        return
    yield Diagnosis(
        fault,
        FAULTS[fault],
        (f"{trace}, and plainer faults behind each other leave {left:.0%} unexplained",),
        even,
    )


# -------------------------------------------------------------------------------------- which it is
@dataclass(frozen=True)
class Diagnosis:
    """One fault that a result may suffer from."""

    fault: str  # its key, of `FAULTS`, or "unknown"
    sentence: str  # the likely cause, and what to do
    evidence: tuple[str, ...]  # measured figures, in words
    # 0 to 1: share of the squared discrepancy that it explains, less where a rival explains it
    # better
    strength: float


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Likely causes of the discrepancy of `comparison`, the strongest first.

    Empty where its tractions and its dissipation are within the scene's tolerances, or where it has
    no number to judge; a single "noise" or "unknown" where they are not, and no fault of the set
    explains half of it.
    """
    whole = discrepancy(comparison)
    if whole is None:
        return ()
    outliers = _outliers(comparison)
    signatures = [*outliers, *_full_slip(whole), *_elastic_slip(whole)]
    if whole.within():
        return (*signatures, *(() if signatures else _by_work(comparison)))
    causes = _causes(whole)
    known = {one.fault for one in signatures}
    others = [one for one in causes if one.fault not in known]
    if len(signatures) > len(outliers):  # what has no trace of its own is no cause beside what has
        others = [one for one in others if one.fault not in (UNKNOWN, "coupling", "friction")]
    return (*signatures, *others)


def _causes(whole: Discrepancy) -> tuple[Diagnosis, ...]:
    """Likely causes by what they explain of the discrepancy, the strongest first; never none."""
    found: list[Diagnosis] = []
    rest = whole
    winners = list[Hypothesis]()
    left = list[float]()
    for number in range(_ROUNDS):
        taken = {one.fault for one in found}
        ranked = _ranked(rest, taken)
        best, winner = ranked[0]
        if (
            number == 0
            and whole.explained(winner.predicted) < _CLEAR
            and (mesh := _too_coarse(whole))
        ):
            return (mesh,)
        if best < _LEAST_EXPLAINED:
            break
        winners.append(winner)
        left.append(1 - rest.explained(winner.predicted))
        # rivals are weaker by what the two leave unexplained
        for explained, one in ranked if number == 0 else ranked[:1]:
            rival = 1.0 if one is winner else min((1 - best) / max(1 - explained, 1e-12), 1.0)
            strength = max(explained, 0.0) * rival * 0.9**number
            if (
                explained >= _LEAST_EXPLAINED
                and strength >= _LEAST_STRENGTH
                and one.fault not in taken
            ):
                found.append(
                    Diagnosis(
                        one.fault,
                        sentence_of(one, rest),
                        tuple(_evidence(rest, one, explained, number)),
                        strength,
                    )
                )
        rest = winner.mended(rest)
        if rest.within(_REST):
            break
    pressure, shear = whole.errors()
    size = (
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant"
    )
    noise = [] if found else list(scatter(whole))
    if math.prod(left[:2]) > _UNACCOUNTED and not noise:
        found += _model_fault(whole, winners[0] if winners else None, math.prod(left[:2]))
    known = sorted(found, key=lambda one: -one.strength) or noise
    first, *others = known or [Diagnosis(UNKNOWN, _WORDS["others"][UNKNOWN], (size,), 0.0)]
    if whole.unsymmetric:
        words = (
            "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft"
            " penalties, bodies too small"
        )
        first = replace(first, evidence=(*first.evidence, words))
    return (first, *others)


# ----------------------------------------------------------------- causes with a trace of their own
def _outliers(comparison: Comparison) -> list[Diagnosis]:
    """Single values that stand out of all others, the largest with its place."""
    found = comparison.found
    traces = [(name, spikes(getattr(found, name))) for name in ("pressure", "shear", "slip")]
    words = [
        f"{name} {getattr(found, name)[k, i]:.6g} at time {found.time[k]:.6g}, x = {found.x[i]:.6g}"
        for name, mask in traces
        for k, i in np.argwhere(mask)
    ]
    if not words:
        return []
    sentence = _WORDS["others"]["outlier"].format(count=len(words), first=words[0])
    return [Diagnosis("outlier", sentence, tuple(words[1:6]), 1.0)]


def _too_coarse(what: Discrepancy) -> Diagnosis | None:
    """The mesh, where too few elements lie over the contact to tell anything else, and the pressure
    adds up to P.
    """
    half_width = what.comparison.scales.half_width
    inside = what.x[np.abs(what.x) <= 1.5 * half_width]
    spacing = float(np.median(np.diff(inside if len(inside) > 1 else what.x)))
    elements = half_width / spacing
    if elements >= _FEWEST_ELEMENTS or not what.loaded.any():
        return None
    ratios = what.resultants[what.loaded] / what.normal_load[what.loaded]
    farthest = float(np.max(np.abs(ratios - 1)))
    if farthest > _SAME_RESULTANT:
        return None
    carrying = int(np.max(np.sum(what.found[0] > 1e-3 * np.max(what.found[0]), axis=1)))
    wanted = half_width / _ENOUGH_ELEMENTS
    sentence = _WORDS["others"]["coarse_mesh"].format(
        elements=elements, carrying=carrying, wanted=wanted, enough=_ENOUGH_ELEMENTS
    )
    evidence = (
        f"the sum of the pressures differs from P by {farthest:.2g} of it at most: no load, unit or"
        " thickness is wrong"
    )
    return Diagnosis("coarse_edge", sentence, (evidence,), 1.0)


def _full_slip(what: Discrepancy) -> Iterator[Diagnosis]:
    """A result that lies on the Coulomb limit at the points that stick in the reference."""
    comparison = what.comparison
    friction = what.comparison.scene.friction.coefficient
    if not friction or not what.sheared:
        return
    found = comparison.found
    expected = comparison.expected
    pressed = (found.pressure > 0.01 * comparison.scales.pressure) & comparison.judged[:, None]
    should_stick = (
        pressed
        & (expected.state == STICK)
        & (np.abs(expected.shear) < _STICKS * friction * expected.pressure)
    )
    limit = friction * found.pressure
    at_limit = np.abs(np.abs(found.shear) - limit) <= _ON_LIMIT * limit
    count = int(should_stick.sum())
    if not count or at_limit[pressed].mean() < _ALL_SLIP:
        return
    share = float((should_stick & at_limit).sum()) / count
    if share < _ALL_SLIP:
        return
    width = float(np.nanmax(np.diff(expected.stick_edges, axis=1))) / 2
    sentence = _WORDS["others"]["full_slip"].format(width=width / comparison.scales.half_width)
    evidence = (
        f"|q| is f p at {share:.0%} of the {count} points and instants at which the reference"
        " sticks"
    )
    yield Diagnosis("full_slip", sentence, (evidence,), 1.0)


def _elastic_slip(what: Discrepancy) -> Iterator[Diagnosis]:
    """Creep of points that stick, in proportion to the shear: a penalty of stiffness k moves them
    by dq/k.

    Points that stick from one instant to the next are those with |q| < 0.9 f p at both, in the
    result and in the reference, whose slip rests in the reference.
    """
    comparison = what.comparison
    friction = what.comparison.scene.friction.coefficient
    found = comparison.found
    expected = comparison.expected
    if not friction or not what.sheared or len(found.time) < 2:
        return
    if not (np.isfinite(found.slip).all() and np.isfinite(expected.slip).all()):
        return
    pressed = comparison.judged[:, None] & ~spikes(found.shear)
    for side in (found, expected):
        pressed &= side.pressure > 0.01 * comparison.scales.pressure
        pressed &= np.abs(side.shear) < _STICKS * friction * side.pressure
    moved = np.diff(found.slip, axis=0)
    moved_in_reference = np.diff(expected.slip, axis=0)
    sheared = np.diff(found.shear, axis=0)
    touching = (found.pressure[1:] > 0) & (found.pressure[:-1] > 0)
    largest = float(np.max(np.abs(moved), where=touching, initial=0.0))
    sticks = pressed[1:] & pressed[:-1] & (np.abs(moved_in_reference) <= _AT_REST * largest)
    creep = moved[sticks]
    change = sheared[sticks]
    if len(creep) < _FEWEST_CREEPING or not change.any() or not creep.any():
        return
    compliance = float(creep @ change / (change @ change))
    proportional = 1 - float(np.sum((creep - compliance * change) ** 2) / (creep @ creep))
    size = float(np.sqrt(np.mean(creep**2))) / largest
    if compliance <= 0 or proportional < _PROPORTIONAL or size < _NO_CREEP:
        return
    scales = comparison.scales
    stiffness = scales.compliance * scales.half_width / (2 * compliance)  # over E*/a, E* = 2/A
    evidence = (
        (
            f"{len(creep)} steps of points that stick: the slip moves by {size:.2g} of the largest"
            f" step, {proportional:.0%} of it in proportion to the shear"
        ),
        f"a tangential stiffness of {stiffness:.2g} E*/a_ref",
    )
    yield Diagnosis("elastic_slip", FAULTS["elastic_slip"], evidence, proportional)


def scatter(what: Discrepancy) -> Iterator[Diagnosis]:
    """Tractions that scatter from point to point, where that is most of the discrepancy; how many
    exceed the Coulomb limit.
    """
    scales = what.comparison.scales
    inside = (what.expected[0] > 1e-3 * what.comparison.scales.pressure) & (what.weight > 0)
    pairs = [
        (what.found[0] - what.expected[0], scales.pressure),
        (what.found[1] - what.expected[1], scales.shear),
    ]
    pairs = pairs[: 1 + (what.sheared and scales.friction > 0)]
    sigma = [noise_of((off / scale)[inside]) for off, scale in pairs]
    whole = sum(float(np.mean((off / scale)[inside] ** 2)) for off, scale in pairs)
    share = sum(one**2 for one in sigma) / whole if whole else 0.0
    if share < _LEAST_EXPLAINED:
        return
    evidence = [
        f"noise from point to point makes {min(share, 1.0):.0%} of the square of the discrepancy"
    ]
    if len(pairs) > 1:
        # at all instants
        every = what.comparison.found
        touching = what.comparison.expected.pressure > 1e-3 * scales.pressure
        beyond = (np.abs(every.shear) / scales.shear - every.pressure / scales.pressure)[touching]
        count = int(np.sum(beyond > 0))
        most = float(np.max(beyond))
        limit = _BY_NOISE * sum(one**2 for one in sigma) ** 0.5
        kept = (
            "no more than noise makes: no fault of the contact law"
            if most <= limit
            else "more than noise alone makes"
        )
        evidence.insert(
            0,
            f"{count} of {len(beyond)} points in contact exceed the Coulomb limit, by {most:.2g} of"
            f" f p_ref at most: {kept}",
        )
    words = f"{sigma[0]:.2g} in p/p_ref" + (
        f" and {sigma[1]:.2g} in q/(f p_ref)" if len(sigma) > 1 else ""
    )
    yield Diagnosis(
        NOISE, _WORDS["others"][NOISE].format(size=words), tuple(evidence), min(share, 1.0)
    )


def _ranked(what: Discrepancy, taken: set[str]) -> list[tuple[float, Hypothesis]]:
    """The best hypothesis of every plain fault with the share it explains, the best first; none
    after one that is exact.

    Behind a fault of mesh or steps, an odd rest is what its prediction left.
    """
    best: dict[str, tuple[float, Hypothesis]] = {}
    odd = () if taken & {"coarse_edge", "coupling", "steps"} else _unlike_bodies(what)
    for one in chain(_file_faults(what), _question_faults(what), [_coarse_edge(what)], odd):
        if one.fault in _OF_LOAD and _contradicted(what, one.figures["factor"]):
            continue
        if one.fault in _FITTED_FACTORS and abs(one.figures["factor"] - 1) < _LEAST_OF_FIT:
            continue
        explained = what.explained(one.predicted)
        pair = explained - _COST * _FITTED.get(one.fault, 0), one
        best[one.fault] = max(best.get(one.fault, pair), pair, key=lambda pair: pair[0])
        if explained >= _EXACT:
            break
    return sorted(best.values(), key=lambda pair: -pair[0])


def _contradicted(what: Discrepancy, factor: float) -> bool:
    """Whether the sum of the pressures speaks against loads, units or a thickness of that factor.

    The pressure of a result adds up to `factor` P where they are wrong, and to P where they are
    not,
    on whatever mesh.
    """
    if not what.loaded.any():
        return False
    ratio = float(np.median(what.resultants[what.loaded] / what.normal_load[what.loaded]))
    return abs(ratio - 1) <= _UNMOVED * abs(factor - 1)


def sentence_of(one: Hypothesis, what: Discrepancy) -> str:
    """The likely cause, and what to do."""
    material = what.comparison.scene.material
    figures = dict(one.figures)
    if one.fault == "coupling" and abs(own := dundurs(material).beta) > _NO_COUPLING:
        in_reference = what.comparison.reference.engine == "halfplane_fe"
        which = "coupling_of_reference" if in_reference else "own_coupling"
        return str(_WORDS["others"][which].format(own=own, **figures))
    likely = ""
    if one.fault == "stiffness":
        factor = figures["factor"]
        nu = material.upper.poisson_ratio
        causes = [
            one["cause"]
            for one in _WORDS["stiffness"]
            if abs(factor / one["factor"] - 1) < one["within"]
        ]
        if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
            causes = [f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"]
        likely = (
            *causes,
            "contact widths go as the square root of its inverse for a Hertz contact",
        )[0]
    return FAULTS[one.fault].format(likely=likely, **figures)


def _evidence(what: Discrepancy, one: Hypothesis, explained: float, number: int) -> Iterator[str]:
    """The measured figures that speak for a fault."""
    behind = "what the faults above leave of the discrepancy" if number else "the discrepancy"
    yield (
        f"a result with just this fault explains {explained:.1%} of the square of {behind} in"
        " p/p_ref and q/(f p_ref)"
    )
    before, after = one.mended(what).errors()
    p_before, q_before = what.errors()
    yield (
        f"error of the pressure {p_before:.2g} of its norm, of the shear {q_before:.2g} of f times"
        " that, at the worst instant"
    )
    yield f"with the fault taken out, by {before:.2g} and {after:.2g}"
    if what.missing:
        yield f"{what.missing:.1%} of the tractions are no numbers and were left out"


def _by_work(comparison: Comparison) -> Iterator[Diagnosis]:
    """Steps too long where the tractions show nothing: the dissipation is off, and that of the
    polygon of the instants is not.

    Exact steps cut corners of the path alone, and tractions at their ends are right as soon as the
    corner is left behind.
    """
    values = {one.key: one.value for one in comparison.metrics}
    off = values.get("dissipation")
    less = values.get("dissipation_polygon")
    limit = comparison.scene.tolerances.limit("dissipation") or 0.0
    if off is None or less is None or not abs(off) > limit or not abs(less) < abs(off) / 2:
        return
    steps = len(comparison.found.time) - 1
    evidence = (
        (
            f"error of the dissipation {off:.2g}; against that of the straight lines between the"
            f" {steps} steps {less:.2g}"
        ),
        "the tractions are within their tolerances",
    )
    yield Diagnosis("steps", FAULTS["steps"].format(steps=steps), evidence, 1 - abs(less / off))
