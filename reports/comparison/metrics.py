"""The last cycle of both solutions, and the metrics: one table, at the end of this file.

A row has its key, its words, what it needs, the function that measures it and its tolerance. Every
metric is a pure function of two last cycles on the same points and instants (a `Pair`),
dimensionless: result − reference over a scale, signed wherever a sign has a meaning. A NaN in a
solution means "no such thing at this instant" only where it is said so; any other NaN comes from
the data and goes on to the verdict, where it fails.

# notation: ref the reference, E the value of a metric, u its uncertainty
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property, partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.units import minus
from scenes import (
    OPEN,
    SLIP_FORWARD,
    SLIP_REVERSE,
    STICK,
    ContactSolution,
    EllipseLoad,
    InputError,
    Materials,
    Scene,
    freeze,
)
from scenes.scene import OWN_TOLERANCES
from scenes.solution import range_of_slip

if TYPE_CHECKING:
    from semi_analytic import Extremes

# ----------------------------------------------------------------------------------- the last cycle
_FIELDS = ("pressure", "shear", "slip")
_EDGES = ("contact_edges", "stick_edges")
_SERIES = ("normal_load", "tangential_load", "tangential_displacement", "normal_approach")
# Only of scenes with bulk stress, tilt or an unsymmetric profile.
OF_BULK = ("bulk_stress_lower", "bulk_stress_upper", "tilt", "moment", "shear_moment")


@dataclass(frozen=True, eq=False)
class Cycle:
    """The last whole cycle of a solution (the whole path, where it is not periodic), both ends
    included.
    """

    time: Array  # (k,), the solution's own times
    # (k,), 0 at the start of the path's cycle and 1 at its end; up to 2 where the instants start
    # elsewhere
    fraction: Array
    x: Array  # (n,) [length]
    # pressure, shear, slip, state: (k, n)
    pressure: Array
    shear: Array
    slip: Array
    state: NDArray[np.int8]
    # contact_edges, stick_edges: (k, 2)
    contact_edges: Array
    stick_edges: Array
    # normal_load, tangential_load, tangential_displacement, normal_approach: (k,)
    normal_load: Array
    tangential_load: Array
    tangential_displacement: Array
    normal_approach: Array
    dissipation_density: Array  # (n,)
    # estimated largest error of the re-sampling, over the field's largest value; empty where
    # nothing was interpolated
    interpolation: Mapping[str, float] = field(default_factory=dict)
    # False for the instants of a result that holds no whole cycle; `fraction` is then the time
    # itself
    whole: bool = True
    # bulk_stress_lower, bulk_stress_upper, tilt, moment, shear_moment: (k,), or None, as in the
    # solution
    bulk_stress_lower: Array | None = None
    bulk_stress_upper: Array | None = None
    tilt: Array | None = None
    moment: Array | None = None
    shear_moment: Array | None = None

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series over time that it has."""
        return (*_SERIES, *(name for name in OF_BULK if getattr(self, name) is not None))


def last_cycle(solution: ContactSolution) -> Cycle:
    """The last whole cycle of `solution`, or all instants where it says itself that it holds none;
    InputError where it has none.
    """
    if "whole_cycle" in solution.work.skipped:
        return _instants(solution)
    steps = solution.last_cycle
    if len(steps) < 2:
        raise InputError(
            f"{solution.engine}: the solution holds no whole cycle (its times run from"
            f" {solution.time[0]:.6g} to {solution.time[-1]:.6g}); solve at least one revolution"
        )
    time = solution.time[steps]
    fraction = (time - time[0]) / (time[-1] - time[0])
    return _cycle(solution, steps, fraction + _start_of_cycle(solution, time[0]), whole=True)


def _start_of_cycle(solution: ContactSolution, time: float) -> float:
    """Share of a period by which a cycle that starts at `time` is behind one of the load path."""
    path = solution.scene.load.path()
    if path.period is None:
        return 0.0
    behind = float(np.mod((time - path.cycle_start) / path.period, 1.0))
    return 0.0 if min(behind, 1 - behind) < 1e-9 else behind


def _instants(solution: ContactSolution) -> Cycle:
    """Every instant of `solution`, `fraction` being the time."""
    return _cycle(solution, np.arange(len(solution.time)), solution.time, whole=False)


def sample_instants(reference: ContactSolution, like: Cycle) -> Cycle:
    """`reference` at the times of `like` (not whole) and on its points; times after its end are
    those of its last cycle.
    """
    cycle, period = _instants(reference), reference.scene.load.path().period
    if len(cycle.time) == len(like.time) and np.array_equal(cycle.time, like.time):
        return sample(cycle, like, reference.engine)
    late = np.maximum(like.time - cycle.time[-1], 0.0)
    folded = like.time if period is None else like.time - period * np.ceil(late / period - 1e-9)
    return replace(
        sample(cycle, replace(like, fraction=freeze(folded)), reference.engine),
        time=like.time,
        fraction=like.time,
    )


def _cycle(
    solution: ContactSolution, steps: NDArray[np.intp], fraction: Array, *, whole: bool
) -> Cycle:
    def of_cycle(name: str) -> Any:
        """Those of a path that is one cycle are not copied: of a long record they take tens of
        megabytes each.
        """
        values = getattr(solution, name)
        return values if len(steps) == len(values) else freeze(values[steps], values.dtype)

    known = [name for name in OF_BULK if getattr(solution, name) is not None]
    picked: dict[str, Any] = {
        name: of_cycle(name) for name in (*_FIELDS, *_EDGES, *_SERIES, *known)
    }
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

    Instants are matched by the fraction of the cycle, since two engines may have needed different
    numbers of revolutions. Linear in x and in time; the state is that of the nearest point and
    instant. `interpolation` states what the same rule errs by when every second sample is left out:
    of 320 spacings at a square-root edge, where it converges slowest, one in a hundred at most errs
    by more.

    Raises
    ------
    InputError
        Where `like` asks for points at which `cycle` still carries pressure beyond its own range.
    """
    error: dict[str, float] = {}
    if like.fraction[-1] > cycle.fraction[-1] + 1e-9 and cycle.whole and like.whole:
        return _sample_from_elsewhere(cycle, like, engine)
    if len(cycle.fraction) != len(like.fraction) or not np.allclose(
        cycle.fraction, like.fraction, rtol=0, atol=1e-9
    ):
        cycle, error = _resampled(
            cycle, "fraction", like.fraction, (*_FIELDS, *_EDGES, *cycle.series)
        )
        cycle = replace(cycle, time=like.time)
    if len(cycle.x) != len(like.x) or not np.allclose(
        cycle.x, like.x, rtol=0, atol=1e-12 * np.ptp(like.x)
    ):
        carries = np.max(cycle.pressure[:, [0, -1]], axis=0) > 1e-12 * np.max(cycle.pressure)
        beyond = like.x[0] < cycle.x[0], like.x[-1] > cycle.x[-1]
        if any(carries[side] and beyond[side] for side in (0, 1)):
            raise InputError(
                f"{engine}: its points end at x = {cycle.x[0]:.6g} and {cycle.x[-1]:.6g} where it"
                " still carries pressure, short of the points that it is compared at; give it"
                " points out to the largest contact"
            )
        cycle, in_x = _resampled(cycle, "x", like.x, (*_FIELDS, "dissipation_density"))
        error = {name: error.get(name, 0.0) + value for name, value in in_x.items()}
    return replace(cycle, interpolation=error)


def _sample_from_elsewhere(cycle: Cycle, like: Cycle, engine: str) -> Cycle:
    """`cycle` on the points and instants of `like`, which starts later in the path's cycle."""
    later = like.fraction - np.where(like.fraction > 1 + 1e-9, 1.0, 0.0)
    order = np.argsort(later, kind="stable")
    sampled = sample(
        cycle, replace(like, fraction=freeze(later[order]), time=freeze(like.time[order])), engine
    )
    back = np.argsort(order, kind="stable")
    over_time: dict[str, Any] = {
        name: freeze(getattr(sampled, name)[back], getattr(sampled, name).dtype)
        for name in (*_FIELDS, "state", *_EDGES, *sampled.series)
    }
    return replace(sampled, time=like.time, fraction=like.fraction, **over_time)


def _resampled(
    cycle: Cycle, along: str, to: Array, names: Iterable[str]
) -> tuple[Cycle, dict[str, float]]:
    """Those of a cycle at other places of `along`, which is "fraction" or "x", and the error of
    that for its fields and edges.
    """
    at, across = getattr(cycle, along), along == "x"
    turned = {name: getattr(cycle, name).T if across else getattr(cycle, name) for name in names}
    nearest = np.abs(at[:, None] - to).argmin(axis=0)
    state = (
        np.where((to < at[0]) | (to > at[-1]), 0, cycle.state[:, nearest])
        if across
        else cycle.state[nearest]
    )
    linear: dict[str, Any] = {name: _linear(to, at, values) for name, values in turned.items()}
    fields: dict[str, Any] = {along: to} | {
        name: freeze(values.T if across else values) for name, values in linear.items()
    }
    error = {
        name: _halving(at, values) for name, values in turned.items() if name not in cycle.series
    }
    return replace(cycle, state=freeze(state, np.int8), **fields), error


def _linear(to: Array, at: Array, values: Array) -> Array:
    """`values` (len(at), ...) at `to`, linear between samples and constant beyond them."""
    upper = np.clip(np.searchsorted(at, to, side="right"), 1, len(at) - 1)
    weight = np.clip((to - at[upper - 1]) / (at[upper] - at[upper - 1]), 0.0, 1.0)
    weight = weight.reshape(-1, *(1,) * (values.ndim - 1))
    # A weight of exactly 0 or 1 must not let a NaN of the other end in.
    low, high = values[upper - 1], values[upper]
    return np.where(
        weight == 0, low, np.where(weight == 1, high, (1 - weight) * low + weight * high)
    )


def _halving(at: Array, values: Array) -> float:
    """Largest error of the linear rule when every second sample is left out, over the largest
    |value|.

    Both halves are tried: a square-root edge errs most where it falls into the middle of an
    interval.
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


@dataclass(frozen=True)
class Event:
    """An instant of the last cycle: its index in the cycle and what happens there."""

    index: int
    label: str


def events(cycle: Cycle, friction: float) -> tuple[Event, ...]:
    """Six instants (all, of fewer) in the order of time: extremes of P, Q, Q - f P, Q + f P, then
    those furthest from all chosen.

    Without bulk stress and tilt Q - f P is largest where forward slip ends, Q + f P least where
    reverse slip ends.
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
            found.setdefault(
                int(np.flatnonzero(quantity >= np.max(quantity) - 1e-12 * size)[0]), label
            )
    found = found or {0: "the only instant" if len(normal) == 1 else "between"}
    for _ in range(min(len(wanted), len(normal) - 1) - len(found)):
        apart = np.abs(cycle.fraction[:, None] - cycle.fraction[list(found)])
        # the end of a cycle is its start
        nearest = (np.minimum(apart, 1 - apart) if cycle.whole else apart).min(axis=1)
        farthest = int(np.argmax(nearest))
        # instants may share one time, where a result was placed on the path by its loads
        if nearest[farthest] <= 0:
            break
        found[farthest] = "between"
    return tuple(Event(index, found[index]) for index in sorted(found))


Array = NDArray[np.float64]
_Mask = NDArray[np.bool_]
_Measure = Callable[["Pair"], "_Measured"]

# Instants with less than this share of P_ref are shown and not judged: on its way from or to the
# unloaded state a contact passes through sizes of a few elements and of one, where an error
# relative to its own traction measures the mesh only.
LIGHT = 0.1
# Peaks of the reference within this share of its largest count as equal: a flat and rounded face
# has one at each edge, and it is the points that decide which of the two comes out higher.
_EQUAL_PEAKS = 0.05
# Differences of size that are rounding: engines repeat themselves to 1e-11.
_ALIKE = 1e-9
# Below this, in f p_ref, the shear of an instant is rounding and has no peak.
_NO_SHEAR = 1e-9
# Below this, in A f^2 P_ref^2, a dissipation of the reference is the rounding of a sum whose truth
# is 0.
_NO_DISSIPATION = 1e-12
# Of beta, at most 1/2: rounding of like moduli written with a few digits more or less.
_NO_COUPLING = 1e-9
_SIDES = ("left", "right")
_FULL_STICK = 2
# What a metric needs beside fields of a solution: a whole cycle, friction.
WHOLE_CYCLE, FRICTION = "whole_cycle", "friction"
# What a contact that carries no shear has no part of.
OF_FRICTION = ("shear", "slip", "state", "stick_edges", "dissipation", "dissipation_density")

_ENGINES = {"semi_analytic": "half-plane theory", "halfplane_fe": "finite elements"}


def name_of(engine: str) -> str:
    """What an engine is called on the page.

    >>> name_of("halfplane_fe"), name_of("somebody's code")
    ('finite elements', "somebody's code")
    """
    return _ENGINES.get(engine, engine)


def coupled(scene: Scene) -> bool:
    """Whether normal and shear tractions of these materials feel each other: Dundurs' beta is not
    0, and there is friction.
    """
    if scene.material.alike or not scene.friction.coefficient:
        return False
    from halfplane_fe.dundurs import dundurs

    return abs(dundurs(scene.material).beta) >= _NO_COUPLING


def are_half_planes(scene: Scene) -> bool:
    """Whether theory is exact for the bodies of `scene`: half-planes whose normal and shear
    tractions do not feel each other.

    Unlike materials couple the two by Dundurs' beta, which theory leaves out: that is an
    idealisation too.
    """
    return scene.bodies.half_planes and not coupled(scene)


# ------------------------------------------------------------------------------------------- values


def python_number(value: Any) -> Any:
    """A scalar of numpy, or a tuple of them, as Python's own number; anything else as it is.

    Page, JSON and tables take `True` for an index and `0.5` for a number; numpy's own scalars are
    neither everywhere.

    >>> python_number(np.float64(0.5)), python_number((np.bool_(True), 1)), python_number("within")
    (0.5, (True, 1), 'within')
    """
    if isinstance(value, np.generic):
        return value.item()
    return tuple(python_number(entry) for entry in value) if type(value) is tuple else value


class PythonNumbers:
    """A frozen record that leaves a computation for the page: its scalars become Python numbers
    when it is made.

    Arrays of shape (k,) and more stay arrays.
    """

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            object.__setattr__(self, name, python_number(value))


class Verdict(StrEnum):
    """What an error and its uncertainty say of a tolerance."""

    WITHIN = "within"
    OUTSIDE = "outside"
    UNDECIDED = "undecided"


def verdict_on(error: float, tolerance: float, uncertainty: float | None = None) -> Verdict:
    """Whether `error` lies within `tolerance`, both in one unit.

    Within if |E| + u <= tolerance, outside if |E| - u > tolerance, else undecided. Where no
    uncertainty u is known, |E| alone decides. An error that is not finite is outside; an
    uncertainty that is not finite decides nothing.

    >>> print(verdict_on(-0.016, 0.05), verdict_on(-0.016, 0.05, 0.75), verdict_on(0.9, 0.05, 0.75))
    within undecided outside
    """
    if not math.isfinite(error):
        return Verdict.OUTSIDE
    doubt = 0.0 if uncertainty is None else uncertainty
    if abs(error) + doubt <= tolerance:
        return Verdict.WITHIN
    return Verdict.OUTSIDE if abs(error) - doubt > tolerance else Verdict.UNDECIDED


@dataclass(frozen=True)
class _Scales(PythonNumbers):
    """What makes the comparison dimensionless."""

    # P_ref, mean load of an ellipse, else the largest load of the last cycle [force / thickness]
    normal_load: float
    half_width: float  # a_ref = a(P_ref) of the reference [length]
    pressure: float  # p_ref = 2 P_ref/(pi a_ref) [stress], the peak of a Hertz contact of that size
    # f, or 1 for a frictionless scene, so that a shear that should not be there still shows
    friction: float
    compliance: float  # A = 2/E* [1/stress]

    @property
    def shear(self) -> float:
        """f p_ref [stress]."""
        return self.friction * self.pressure

    @property
    def shift(self) -> float:
        """A f P_ref [length]."""
        return self.compliance * self.friction * self.normal_load

    @property
    def dissipation(self) -> float:
        """A f^2 P_ref^2 [energy / thickness]."""
        return self.compliance * (self.friction * self.normal_load) ** 2

    @property
    def density(self) -> float:
        """A f^2 P_ref^2/a_ref [energy / area]."""
        return self.dissipation / self.half_width

    @property
    def slip(self) -> float:
        """f p_ref a_ref/E* [length]."""
        return self.compliance * self.shear * self.half_width / 2


def compliance(materials: Materials) -> float:
    """A = 2/E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [1/stress].

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> round(2 / compliance(steel), 1)
    115384.6
    """
    return 2 * sum(
        (1 - m.poisson_ratio**2) / m.young_modulus for m in (materials.upper, materials.lower)
    )


def energy_scale(scene: Scene, load: float) -> float:
    """A f^2 P^2, f being 1 for a frictionless scene [energy / thickness]."""
    return compliance(scene.material) * ((scene.friction.coefficient or 1.0) * load) ** 2


def scales(reference: ContactSolution) -> _Scales:
    """The scales of `reference`; a(P_ref) is read off its own half-widths, linear in P between its
    instants.
    """
    load, friction = reference.scene.load, reference.scene.friction.coefficient
    if isinstance(load, EllipseLoad):
        normal_load = load.mean_normal_load
    else:
        normal_load = float(np.max(reference.normal_load[reference.last_cycle]))
    order = np.argsort(reference.normal_load, kind="stable")
    half_width = float(
        np.interp(normal_load, reference.normal_load[order], reference.contact_half_width[order])
    )
    return _Scales(
        normal_load=normal_load,
        half_width=half_width,
        pressure=2 * normal_load / (np.pi * half_width),
        friction=friction or 1.0,
        compliance=compliance(reference.scene.material),
    )


def bulk_strains(materials: Materials) -> tuple[float, float]:
    """What the bulk stress of the lower and of the upper body adds to eps: 1/E' and -1/E', E' =
    E/(1 - nu^2) [1/stress].

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> [round(1 / one) for one in bulk_strains(steel)]
    [230769, -230769]
    """
    lower, upper = (
        (1 - m.poisson_ratio**2) / m.young_modulus for m in (materials.lower, materials.upper)
    )
    return lower, -upper


def bulk_strain(of: ContactSolution | Cycle, materials: Materials) -> Array:
    """eps = sigma_lower/E'_lower - sigma_upper/E'_upper at every instant, (n_steps,); 0 without
    bulk stress.
    """
    stresses = (of.bulk_stress_lower, of.bulk_stress_upper)
    return sum(
        (c * s for c, s in zip(bulk_strains(materials), stresses, strict=True) if s is not None),
        start=np.zeros(len(of.time)),
    )


@dataclass(frozen=True, eq=False)
class Pair:
    """Reference and result, the one put on the other's points and instants: see `Comparison` for
    the names.
    """

    reference: ContactSolution
    result: ContactSolution
    polygon_reference: ContactSolution | None
    plain_reference: ContactSolution
    scales: _Scales
    expected: Cycle
    found: Cycle

    @cached_property
    def largest(self) -> Extremes | None:
        """Theory's own largest values, whatever points it is compared on; None where the reference
        is no theory.
        """
        import semi_analytic

        return (
            semi_analytic.extremes(self.plain_reference)
            if self.plain_reference.engine == "semi_analytic"
            else None
        )

    @property
    def has_external_result(self) -> bool:
        """Whether the result is no finite-element answer of this project: its points and instants
        are its own choice.
        """
        return self.result.engine != "halfplane_fe"

    @cached_property
    def touching(self) -> _Mask:
        """(k,) instants at which either carries pressure (a NaN counts as pressure: it must not
        hide).
        """
        return (self.expected.pressure != 0).any(axis=1) | (self.found.pressure != 0).any(axis=1)

    @cached_property
    def judged(self) -> _Mask:
        """(k,) instants that a verdict is taken from."""
        return self.touching & (self.expected.normal_load >= LIGHT * self.scales.normal_load)

    @cached_property
    def periodic(self) -> bool:
        """Whether the load path repeats."""
        return self.result.scene.load.path().period is not None

    @cached_property
    def pulled(self) -> bool:
        """Whether the scene states a bulk stress."""
        load = self.result.scene.load
        return load.bulk_stress_lower is not None or load.bulk_stress_upper is not None

    @cached_property
    def turned(self) -> bool:
        """Whether the scene states a tilt, a moment or a line of action, or has two unequal
        sides.
        """
        scene = self.result.scene
        stated = (scene.load.tilt, scene.load.moment, scene.load.line_of_action)
        return any(one is not None for one in stated) or not scene.profile.symmetric

    @property
    def unsymmetric(self) -> bool:
        """Either of both."""
        return self.pulled or self.turned


@dataclass(frozen=True, eq=False, kw_only=True)
class _Measured(PythonNumbers):
    """What the function of a metric finds.

    Attributes
    ----------
    value : of the last cycle, the worst where there is one at every instant; None where there is
        nothing to compare; not finite where the data is not
    time : instant of the worst value; None for a figure of the whole cycle
    series : (k,) values at the instants of the last cycle (NaN: nothing to compare), or None
    note : what a reader must not miss
    elements : value in local element sizes of the result, where it states one
    absolute : whether the value is in the row's absolute unit, the reference's own figure being 0
    place : where on the surface the worst value is, x/a_ref; None for what has no place
    uncertainty : how far the error budget, else the result's own statement or the spacing of points
        or instants, leaves the value open, in its unit; None where nobody states it
    spacings : value in local spacings of the result's points
    unmatched : whether a value that is not finite means an event without a counterpart, and not
    data that is no number amounts : (reference, result) of a row with a quantity, in units of the
    scene; None for the others
    """

    value: float | None
    time: float | None = None
    series: Array | None = None
    note: str = ""
    elements: float | None = None
    absolute: bool = False
    place: float | None = None
    uncertainty: float | None = None
    spacings: float | None = None
    unmatched: bool = False
    amounts: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class _Definition:
    """A row of the table."""

    # key, label: for programs and for people
    key: str
    label: str
    unit: str  # what its value is a share of
    norm: str  # how the differences at points and instants become one value
    region: str  # which points and instants count
    text: str  # how it is computed
    # fields of a solution without which it can't be had, `WHOLE_CYCLE` and `FRICTION` among them
    needs: tuple[str, ...]
    measure: _Measure  # the function, of a `Pair`
    signed: bool = True  # whether its sign has a meaning (result − reference); a norm has none
    # unit where the reference's own figure is 0 and nothing can be relative to it
    absolute_unit: str = ""
    # what its absolute values are: "stress", "length", "slip", "energy", "energy density"; "" for
    # none. A row with a quantity stands in the first table, the others are folded below it
    quantity: str = ""
    judged_by: str = ""  # key of the tolerance that judges it; the row's own
    # whether a pair has this row at all: not without bulk stress, say
    exists: Callable[[Pair], bool] = lambda _: True

    @property
    def headline(self) -> bool:
        """Whether it stands in the first table."""
        return bool(self.quantity)

    def __reduce__(self) -> tuple[Any, ...]:
        return _row_of, (self.key,)  # its functions have no names of their own


def _row_of(key: str) -> _Definition:
    return METRICS[key]


@dataclass(frozen=True, eq=False, kw_only=True)
class Metric(_Measured):
    """One discrepancy: what was measured, its row of the table, and the largest |value| admitted
    (None: not judged).

    `lacking`: a solution does not hold what the metric needs; with a tolerance it is then unscored.
    """

    definition: _Definition
    tolerance: float | None = None
    lacking: bool = False

    @property
    def key(self) -> str:
        """Name for programs."""
        return self.definition.key

    @property
    def label(self) -> str:
        """Name for people."""
        return self.definition.label

    @property
    def unit(self) -> str:
        """What the value is a share of, or its unit."""
        return self.definition.absolute_unit if self.absolute else self.definition.unit

    @property
    def verdict(self) -> Verdict | None:
        """`verdict_on` value, tolerance and uncertainty; None without a tolerance or a value. What
        is not finite is outside, tolerance or none, unless the only reason is that something has no
        counterpart.
        """
        if self.value is None:
            return None
        if self.tolerance is None:
            return None if np.isfinite(self.value) or self.unmatched else Verdict.OUTSIDE
        return verdict_on(self.value, self.tolerance, self.uncertainty)

    @property
    def accurate(self) -> bool | None:
        """Whether the verdict is "within": undecided counts as outside; None where there is no
        verdict.
        """
        return None if self.verdict is None else self.verdict is Verdict.WITHIN


def missing(solution: ContactSolution) -> dict[str, str]:
    """Quantity -> why the solution does not hold it.

    An engine that was not asked for a field, and a foreign result that lacks one, say so alike: in
    `work.skipped`.
    """
    known = {quantity for row in METRICS.values() for quantity in row.needs}
    return {name: reason for name, (_, reason) in solution.work.skipped.items() if name in known}


def judge(pair: Pair, tolerances: Mapping[str, float]) -> tuple[Metric, ...]:
    """Every metric of the table in its order: the first table's, then the others; by `tolerances`,
    key -> |E| admitted.

    Of one that needs what a solution does not hold, the reason; never a guess.
    """
    lacking = [
        (name_of(solution.engine), missing(solution)) for solution in (pair.result, pair.reference)
    ]
    found = []

    def admitted(row: _Definition) -> float | None:
        return tolerances.get(row.key, tolerances.get(row.judged_by))

    for row in sorted(METRICS.values(), key=lambda row: not row.headline):
        if not row.exists(pair):
            continue
        absent = [
            (quantity, engine, why[quantity])
            for engine, why in lacking
            for quantity in row.needs
            if quantity in why
        ]
        frictionless = not pair.result.scene.friction.coefficient
        shearless = not (
            np.abs(np.nan_to_num(pair.expected.shear)) > _NO_SHEAR * pair.scales.shear
        ).any()
        if FRICTION in row.needs and frictionless:
            found.append(
                Metric(
                    definition=row,
                    value=None,
                    note="frictionless: nothing sticks and nothing resists slip",
                )
            )
        elif absent:
            quantity, engine, reason = absent[0]
            words = (
                "pointwise dissipation"
                if quantity == "dissipation_density"
                else quantity.replace("_", " ")
            )
            note = f"{words}: {reason} ({engine})"
            # Of a contact that carries no shear a lacking shear or slip leaves nothing open.
            tolerance = None if shearless and set(row.needs) & set(OF_FRICTION) else admitted(row)
            found.append(
                Metric(definition=row, value=None, note=note, tolerance=tolerance, lacking=True)
            )
        else:
            measured = row.measure(pair)
            tolerance = None if measured.value is None else admitted(row)
            amounts = measured.amounts if row.headline else None
            found.append(
                Metric(
                    definition=row, tolerance=tolerance, **{**vars(measured), "amounts": amounts}
                )
            )
    return tuple(found)


def tolerances_of(
    scene: Scene, exact: bool, given: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Key -> largest |E| admitted: `given`, else the scene's, else the engines' own where theory is
    `exact` for the bodies.

    A given one that is infinite leaves the metric unjudged.
    """
    stated = {
        key: value for key, value in scene.tolerances.model_dump().items() if value is not None
    }
    admitted = {**(OWN_TOLERANCES if exact else {}), **stated, **(given or {})}
    return {key: value for key, value in admitted.items() if value < math.inf}


def markdown() -> str:
    """The table of docs/metrics.md: one row for each metric, in the order of the tables."""

    def unit(row: _Definition) -> str:
        return f"{row.unit}; {row.absolute_unit} where that is 0" if row.absolute_unit else row.unit

    def tolerance(row: _Definition) -> str:
        limit = OWN_TOLERANCES.get(row.judged_by)
        return (
            "–"
            if limit is None
            else f"{limit:g}" + ("" if row.judged_by == row.key else f" (`{row.judged_by}`)")
        )

    bar = "\\|"
    rows = (
        f"| {row.label}: `{row.key}` | {row.text.replace('|', bar)} | {unit(row)} | "
        f"{row.norm}; {row.region}{'' if row.signed else '; no sign'} | {tolerance(row)} |"
        for row in sorted(METRICS.values(), key=lambda row: not row.headline)
    )
    return "\n".join(
        ("| Metric | How | Unit | Norm; region | Tolerance |", "|---|---|---|---|---|", *rows)
    )


# --------------------------------------------------------------------------- what the metrics share


def norm(x: Array, values: Array) -> Array:
    """L2 norm over x, sqrt(int values^2 dx) by the trapezoidal rule: (..., n) -> (...)."""
    return np.sqrt(np.trapezoid(np.square(values), x, axis=-1))


def over(numerator: Array, denominator: Array) -> Array:
    """Quotient; 0/0 is NaN ("nothing to compare"), anything else over 0 is infinite."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.asarray(numerator / denominator, dtype=float)


def shares(at: Array) -> Array:
    """Weights of the trapezoidal rule on the points or instants `at`: (n,) -> (n,); 1 each where
    all are one, as loads alike are.

    >>> shares(np.array([0.0, 1.0, 3.0])).tolist(), shares(np.array([2.0])).tolist()
    ([0.5, 1.5, 1.0], [1.0])
    """
    if at[-1] == at[0]:
        return np.ones(len(at))
    steps = np.diff(at)
    return np.asarray(np.concatenate([steps, [0.0]]) + np.concatenate([[0.0], steps])) / 2


def _spacing_at(x: Array, place: float) -> float:
    """Distance of the two points around `place` (at the ends of `x`: of the last two) [length].

    >>> _spacing_at(np.array([0.0, 1.0, 3.0]), 2.5)
    2.0
    """
    right = int(np.clip(np.searchsorted(x, place, side="right"), 1, len(x) - 1))
    return float(x[right] - x[right - 1])


def _largest(size: Array) -> NDArray[np.intp]:
    """The first place along the last axis of what is largest but for rounding.

    A cycle that is its own mirror image has each difference twice, with both signs: which of them
    is larger is chance.
    """
    return np.argmax(size >= (1 - _ALIKE) * size.max(axis=-1, keepdims=True), axis=-1)


def _worst(series: Array, applies: _Mask, time: Array) -> tuple[float | None, float | None]:
    """The value of largest size and its instant, the first of like ones, among those that apply; a
    NaN is the worst there is.

    >>> _worst(np.array([1.0, -3.0, 9.0]), np.array([True, True, False]), np.array([0.0, 0.5, 1.0]))
    (-3.0, 0.5)
    """
    if not applies.any():
        return None, None
    at = int(_largest(np.where(applies, np.where(np.isnan(series), np.inf, np.abs(series)), -1.0)))
    return float(series[at]), float(time[at])


def _worst_point(difference: Array, x: Array) -> tuple[Array, Array]:
    """The entry of largest size in each row of (k, n) and its place: (k,), (k,). A NaN is the worst
    there is.

    >>> values, places = _worst_point(np.array([[1.0, -3.0]]), np.array([0.0, 0.5]))
    >>> values.tolist(), places.tolist()
    ([-3.0], [0.5])
    """
    column = _largest(np.where(np.isnan(difference), np.inf, np.abs(difference)))
    return np.asarray(difference[np.arange(len(difference)), column]), np.asarray(x[column])


def _peak_place(expected: Array, found: Array, x: Array) -> Array:
    """Place of the largest `found` less that of `expected` in each row of (k, n), to a point: (k,)
    [length].

    Where several peaks of `expected` lie within `_EQUAL_PEAKS` of its largest, the nearest of them
    counts. NaN where a row holds a NaN or where nothing of `expected` is above 0.

    >>> twin = np.array([[0.0, 1.0, 0.0, 0.99, 0.0]])
    >>> _peak_place(twin, np.array([[0.0, 1.0, 0.0, 0.0, 2.0]]), np.arange(5.0)).tolist()
    [1.0]
    """
    rim = np.full((len(expected), 1), -np.inf)
    rises, falls = (
        expected >= np.hstack([rim, expected[:, :-1]]),
        expected >= np.hstack([expected[:, 1:], rim]),
    )
    high = (expected >= (1 - _EQUAL_PEAKS) * expected.max(axis=1, keepdims=True)) & (expected > 0)
    apart = x[_largest(found)][:, None] - x
    size = np.where(rises & falls & high, np.abs(apart), np.inf)
    nearest = np.argmin(size, axis=1)
    rows = np.arange(len(expected))
    known = (
        np.isfinite(size[rows, nearest])
        & ~np.isnan(found).any(axis=1)
        & ~np.isnan(expected).any(axis=1)
    )
    return np.where(known, apart[rows, nearest], np.nan)


def _at_worst(
    pair: Pair,
    series: Array,
    applies: _Mask | None = None,
    *,
    places: Array | None = None,
    to_a_point: bool = False,
    **more: Any,
) -> _Measured:
    """`series` (k,) at the worst of the instants that are judged, or of those that apply.

    `places` (k,) [length] gives the place of that value; `to_a_point`: the spacing of the points
    there is the uncertainty.
    """
    value, time = _worst(series, pair.judged if applies is None else applies, pair.found.time)
    length, place, doubt = pair.scales.half_width, None, None
    if places is not None and time is not None:
        place = float(places[pair.found.time == time][0]) / length
        doubt = _spacing_at(pair.found.x, place * length) / length if to_a_point else None
    return _Measured(value=value, time=time, series=series, place=place, uncertainty=doubt, **more)


def _none(why: str) -> _Measured:
    """Nothing to compare, with the reason in words."""
    return _Measured(value=None, note=why)


def _of_amounts(expected: float, found: float, scale: float, **more: Any) -> _Measured:
    """Found less expected over expected; over `scale` where that is nothing beside it (1e-12)."""
    nothing = abs(expected) <= 1e-12 * scale
    value = (found - expected) / (scale if nothing else expected)
    return _Measured(value=value, absolute=nothing, amounts=(expected, found), **more)


def _of_common(pair: Pair, of: Callable[[Cycle], float], scale: str) -> _Measured:
    """A value `of` the last cycle of both on common points and instants, found less expected over
    expected.
    """
    return _of_amounts(float(of(pair.expected)), float(of(pair.found)), getattr(pair.scales, scale))


# Share of theory's own value by which its value on the result's points may miss it: above, these
# points say nothing of the value; below the second, both are the same to the digits of a table.
_UNRESOLVED, _SAME_DIGITS = 0.1, 1e-6


def _beside_own(
    extremum: float, common: float, measured: float, scale: float, *, external: bool, note: str = ""
) -> _Measured:
    """A value of the result beside the reference's own.

    Parameters
    ----------
    extremum, common : of the reference: its own, and by the rule, points and instants of the result
    measured : of the result
    scale : what the difference is over where the reference's own is 0
    external : whether the result has points and instants of its own choice. Then the difference is
        that from `common`, so that their error drops out, and a note says so; where they miss the
        reference's own by too much there is none
    """
    amounts = (extremum, measured)
    if math.isinf(extremum) and math.isfinite(measured):
        return _Measured(value=None, note="infinite in the reference", amounts=amounts)
    if not external:
        return _of_amounts(extremum, measured, scale, note=note)
    size = abs(extremum) if abs(extremum) > 1e-12 * scale else scale
    missed = abs(common - extremum) / size
    if missed > _UNRESOLVED:
        few = (
            f"the result's points and instants are too few: on them the reference has {common:.4g}"
            f" in place of {extremum:.4g}"
        )
        return _Measured(value=None, note=few, amounts=amounts)
    if missed > _SAME_DIGITS:
        note = (
            "the difference is that on the result's points and instants, where the reference has"
            f" {common:.5g}"
        )
    return replace(_of_amounts(common, measured, scale, note=note), amounts=amounts)


def _beside_theory(pair: Pair, name: str, common: float, measured: float, scale: str) -> _Measured:
    """The largest `name` of the result beside theory's own; of another reference, beside its value
    on common points.
    """
    extremum = common
    note = ""
    if pair.largest is not None:
        extremum = getattr(pair.largest, name)
        note = pair.largest.sampled
    return _beside_own(
        extremum,
        common,
        measured,
        getattr(pair.scales, scale),
        external=pair.has_external_result,
        note=note,
    )


def _place(pair: Pair, values: Array) -> float:
    """x/a_ref of the largest of (n,)."""
    return float(pair.found.x[np.argmax(values)]) / pair.scales.half_width


# --------------------------------------------------------- the first table: absolute values of both


def _of_stick_zone(pair: Pair, of: Callable[[ContactSolution], float]) -> _Measured:
    """A length of the permanent stick zone, result − reference over a_ref; NaN is that there is
    none.
    """
    own, expected, found = (
        float(of(solution)) for solution in (pair.plain_reference, pair.reference, pair.result)
    )
    lacking = [
        name_of(s.engine)
        for s, it in ((pair.reference, expected), (pair.result, found))
        if math.isnan(it)
    ]
    if lacking:
        amounts = None if len(lacking) == 2 else (own, found)
        return _Measured(value=None, note=f"none in {' and '.join(lacking)}", amounts=amounts)
    return _Measured(value=(found - expected) / pair.scales.half_width, amounts=(own, found))


def _middle_of_stick(solution: ContactSolution) -> float:
    return (
        math.nan
        if solution.permanent_stick_edges is None
        else float(np.mean(solution.permanent_stick_edges))
    )


def _largest_of_pressure(cycle: Cycle) -> float:
    return float(cycle.pressure.max())


def _largest_pressure(pair: Pair) -> _Measured:
    common, found = _largest_of_pressure(pair.expected), _largest_of_pressure(pair.found)
    return _beside_theory(pair, "pressure", common, found, "pressure")


def _largest_half_width(pair: Pair) -> _Measured:
    common = _largest_half_distance(pair.expected)
    measured = _largest_half_distance(pair.found)
    return _beside_theory(pair, "half_width", common, measured, "half_width")


def _largest_half_distance(cycle: Cycle) -> float:
    return float(np.nanmax(np.diff(cycle.contact_edges, axis=1), initial=0.0)) / 2


def _largest_slip(pair: Pair) -> _Measured:
    if not pair.result.scene.friction.coefficient:
        return _none("nothing resists slip")
    touching = pair.found.state != OPEN
    if not touching.any():
        return _none("no instant has points in contact in both")
    stroke = range_of_slip(pair.found.slip, touching)
    common = float(range_of_slip(pair.expected.slip, pair.expected.state != OPEN).max())
    measured = _beside_theory(pair, "slip", common, float(stroke.max()), "slip")
    return replace(measured, place=_place(pair, stroke))


def _largest_common_slip(pair: Pair) -> _Measured:
    touching = (pair.expected.state != OPEN) & (pair.found.state != OPEN)
    if not touching.any():
        return _none("no instant has points in contact in both")
    theirs, ours = (range_of_slip(cycle.slip, touching) for cycle in (pair.expected, pair.found))
    return _of_amounts(
        float(theirs.max()), float(ours.max()), pair.scales.slip, place=_place(pair, ours)
    )


def _dissipation(pair: Pair) -> _Measured:
    by_rule = pair.plain_reference is not pair.reference
    works = (pair.plain_reference.dissipation, pair.reference.dissipation, pair.result.dissipation)
    found = _beside_own(*works, pair.scales.dissipation, external=by_rule)
    if found.absolute:
        return replace(found, note="the reference dissipates nothing, so the value is absolute")
    return found


def _largest_of_density(cycle: Cycle) -> float:
    return float(cycle.dissipation_density.max())


def _largest_density(pair: Pair) -> _Measured:
    common, found = _largest_of_density(pair.expected), _largest_of_density(pair.found)
    measured = _beside_theory(pair, "dissipation_density", common, found, "density")
    return replace(measured, place=_place(pair, pair.found.dissipation_density))


def _edge_tension(pair: Pair) -> _Measured:
    if not pair.result.scene.friction.coefficient:
        return _none("frictionless: nothing stretches the faces")
    sides = [_largest_tension(solution, pair) for solution in (pair.plain_reference, pair.result)]
    lacking = [
        name_of(s.engine)
        for s, side in zip((pair.reference, pair.result), sides, strict=True)
        if side is None
    ]
    if lacking:
        return _none(f"not known of {' and '.join(lacking)}")
    (expected, known), (found, doubt) = [side for side in sides if side is not None]
    measured = _of_amounts(expected, found, pair.scales.shear)
    return replace(
        measured,
        uncertainty=(known + doubt) / (pair.scales.shear if measured.absolute else abs(expected)),
    )


def _largest_tension(solution: ContactSolution, pair: Pair) -> tuple[float, float] | None:
    """The largest tension at an edge of contact and its uncertainty [stress]."""
    import halfplane_fe

    if solution.engine == "semi_analytic" and pair.largest is not None:
        return pair.largest.edge_tension, pair.largest.edge_tension_uncertainty
    largest = (
        halfplane_fe.largest_edge_tension(solution) if solution.engine == "halfplane_fe" else None
    )
    return None if largest is None else (largest.value, largest.uncertainty)


# ------------------------------------------------------------------------------- pressure and shear


def _peak_pressure(pair: Pair) -> _Measured:
    # Both maxima over the same points: where these lie beside the true peak cancels. A reference at
    # its own peak would make every result look too low by up to (h/a)^2/8.
    expected, found = pair.expected.pressure.max(axis=1), pair.found.pressure.max(axis=1)
    return _at_worst(pair, over(found - expected, expected))


def _peak_shear(pair: Pair) -> _Measured:
    difference = np.abs(pair.found.shear).max(axis=1) - np.abs(pair.expected.shear).max(axis=1)
    return _at_worst(
        pair, over(difference, pair.scales.friction * pair.expected.pressure.max(axis=1))
    )


def _traction(pair: Pair, name: str, friction: float = 1.0) -> _Measured:
    """L2 norm of the difference of a traction, over `friction` times that of the pressure."""
    x, off = pair.found.x, getattr(pair.found, name) - getattr(pair.expected, name)
    return _at_worst(pair, over(norm(x, off), friction * norm(x, pair.expected.pressure)))


def _traction_maximum(pair: Pair, name: str, friction: float = 1.0) -> _Measured:
    peak = friction * pair.expected.pressure.max(axis=1, keepdims=True)
    series, places = _worst_point(
        over(getattr(pair.found, name) - getattr(pair.expected, name), peak), pair.found.x
    )
    return _at_worst(pair, series, places=places)


def _place_of_peak(pair: Pair, of: Callable[[Cycle], Array], least: float) -> _Measured:
    """Of instants at which the reference's peak is above `least`."""
    x, expected, found = pair.found.x, of(pair.expected), of(pair.found)
    # Asked the other way round, a NaN would count as no shear and hide.
    carries = pair.judged & ~(expected.max(axis=1) <= least)
    if not carries.any() and least >= 0:
        return _none("the reference carries no shear")
    series = _peak_place(expected, found, x) / pair.scales.half_width
    return _at_worst(pair, series, carries, places=x[_largest(found)], to_a_point=True)


def _resultants(cycle: Cycle, weights: Array | None, normals: Array | None) -> tuple[Array, Array]:
    """P and Q that the tractions of `cycle` carry, (k,) and (k,) [force / thickness].

    Parameters
    ----------
    weights : (n,) share of the surface of each point [length]; None: the trapezoidal rule
    normals : (2, n) out of the lower body, p acting along it and q across it; None: (0, 1)
        everywhere
    """
    surface = shares(cycle.x) if weights is None else weights
    along, across = (np.zeros_like(cycle.x), np.ones_like(cycle.x)) if normals is None else normals
    # Zero times no shear, which a pressure alone has, is nothing of P.
    normal = cycle.pressure @ (surface * across) + (
        cycle.shear @ (surface * along) if along.any() else 0.0
    )
    return normal, cycle.shear @ (surface * across) - cycle.pressure @ (surface * along)


def _resultant(pair: Pair, component: int) -> _Measured:
    """With the result's own weights nothing of the reference enters; by the trapezoidal rule the
    rule's own error is taken off.
    """
    weights, normals = (getattr(pair.result, name, None) for name in ("weights", "normals"))
    loads = [
        (cycle.normal_load, cycle.tangential_load)[component]
        for cycle in (pair.found, pair.expected)
    ]
    lacking, note = _resultants(pair.found, weights, normals)[component] - loads[0], ""
    if weights is None:
        lacking = lacking - _resultants(pair.expected, None, None)[component] + loads[1]
        note = (
            "the result states no weights, so by the trapezoidal rule, minus its error for the"
            " reference"
        )
    return _at_worst(pair, over(lacking, pair.found.normal_load), note=note)


# -------------------------------------------------------------------------- contact, stick and slip


def _edge(expected: Array, found: Array, length: float) -> Array:
    """Outward shift of the worse of two edges over `length`, (k,) from (k, 2); NaN where either
    lacks the edge.

    >>> _edge(np.array([[-1.0, 1.0]]), np.array([[-1.02, 1.01]]), 1.0).round(12).tolist()
    [0.02]
    """
    outward = (found - expected) * np.array([-1.0, 1.0]) / length
    worse = np.argmax(np.abs(outward), axis=1)
    return np.asarray(outward[np.arange(len(outward)), worse])


def _elements(pair: Pair, value: float | None) -> float | None:
    """An edge's shift in local element sizes of the result, which it states as
    `settings["element_size"]` [length].
    """
    size = pair.result.settings.get("element_size")
    return value * pair.scales.half_width / float(size) if size and value is not None else None


def _contact_edge(pair: Pair) -> _Measured:
    found = _at_worst(
        pair, _edge(pair.expected.contact_edges, pair.found.contact_edges, pair.scales.half_width)
    )
    return replace(found, elements=_elements(pair, found.value))


def _stick_status(cycle: Cycle, length: float) -> NDArray[np.int8]:
    """What the whole contact does at each instant, (k,): 0 full slip, 1 partial slip, 2 full stick,
    -1 out of contact.

    Full stick: the stick edges are the contact edges (to 1e-9 `length`). Full slip: they are NaN.
    """
    apart = np.max(np.abs(cycle.stick_edges - cycle.contact_edges), axis=1)
    status = np.where(np.isnan(apart), 0, np.where(apart <= 1e-9 * length, 2, 1))
    return np.where(cycle.pressure.max(axis=1) > 0, status, -1).astype(np.int8)


def _with_stick_edges(theirs: NDArray[np.int8], ours: NDArray[np.int8]) -> NDArray[np.bool_]:
    """Instants of a cycle at which edges of stick are compared, from the `_stick_status` of both,
    (k,).

    Both have edges, and it is not one step by which one of them comes to full stick, or leaves it,
    before the other: the edge jumps there, and that step is an error of an event.

    >>> _with_stick_edges(
    ...     np.array([1, 1, 2, 2, 1, 1], dtype=np.int8), np.array([1, 1, 1, 2, 1, 2], dtype=np.int8)
    ... ).tolist()
    [True, True, False, True, True, True]
    """

    def beside(one: NDArray[np.int8], other: NDArray[np.int8]) -> NDArray[np.bool_]:
        return (one == np.roll(other, 1)) | (one == np.roll(other, -1))

    return (
        (theirs != 0)
        & (ours != 0)
        & ~((theirs != ours) & beside(theirs, ours) & beside(ours, theirs))
    )


def _stick_edge(pair: Pair) -> _Measured:
    # Instants at which the two differ in full stick, partial slip or full slip are counted, not
    # hidden.
    length = pair.scales.half_width
    theirs, ours = (_stick_status(cycle, length) for cycle in (pair.expected, pair.found))
    series = _edge(pair.expected.stick_edges, pair.found.stick_edges, length)
    found = _at_worst(pair, series, pair.judged & _with_stick_edges(theirs, ours))
    differing, instants = int((theirs != ours)[pair.judged].sum()), int(pair.judged.sum())
    note = (
        f"{differing} of {instants} instants differ in full stick, partial slip or full slip"
        if differing
        else ""
    )
    if found.value is None and differing:
        return replace(found, value=math.nan, note=f"no instant has a stick edge in both: {note}")
    return replace(found, note=note, elements=_elements(pair, found.value))


def _edge_of_side(pair: Pair, kind: str, side: str) -> _Measured:
    """One edge by itself, also in local spacings, with the uncertainty that the result states."""
    length, column, applies = pair.scales.half_width, _SIDES.index(side), pair.judged
    if kind == "stick":
        applies = applies & _with_stick_edges(
            *(_stick_status(cycle, length) for cycle in (pair.expected, pair.found))
        )
        if not applies.any():
            return _none("no instant has a stick edge in both")
    expected, found = (
        getattr(cycle, f"{kind}_edges")[:, column] for cycle in (pair.expected, pair.found)
    )
    measured = _at_worst(
        pair, (found - expected) * (-1.0, 1.0)[column] / length, applies, places=found
    )
    if measured.place is None or measured.value is None or not np.isfinite(measured.place):
        return measured
    stated = getattr(pair.result, f"{kind}_edge_uncertainty", None)
    at = pair.found.time == measured.time
    return replace(
        measured,
        spacings=measured.value * length / _spacing_at(pair.found.x, measured.place * length),
        uncertainty=(
            None
            if stated is None
            else float(stated[pair.result.last_cycle][at, column][0]) / length
        ),
    )


def _state(pair: Pair) -> _Measured:
    expected, found, length = pair.expected.state, pair.found.state, np.gradient(pair.found.x)
    touching = (expected != OPEN) | (found != OPEN)
    series = over(((expected != found) * length).sum(axis=1), (touching * length).sum(axis=1))
    time = pair.found.time[pair.touching]
    passed = len(time) and time[-1] != time[0]
    value = (
        float(np.trapezoid(series[pair.touching], time) / (time[-1] - time[0])) if passed else None
    )
    return _Measured(value=value, series=series)


def _stick_set(pair: Pair) -> _Measured:
    theirs, ours = pair.expected.state == STICK, pair.found.state == STICK
    times, lengths = shares(pair.found.time), shares(pair.found.x)
    both, either = (float(times @ sticks @ lengths) for sticks in (theirs & ours, theirs | ours))
    return _Measured(value=1 - both / either) if either else _none("nothing sticks in either")


def _onsets(applies: _Mask, periodic: bool) -> NDArray[np.intp]:
    """First indices of the runs of at least two instants at which `applies` (k,); none if it does
    always.

    In a periodic cycle, whose last instant is the first of the next, a run may go on across the
    end.

    >>> (
    ...     _onsets(np.array([True, False, True, True, True]), True),
    ...     _onsets(np.array([True, False, True, True]), False),
    ... )
    (array([2]), array([2]))
    """
    now = applies[:-1] if periodic else applies
    before, after = np.roll(now, 1), np.roll(now, -1)
    if not periodic:
        before[:1], after[-1:] = False, False
    return np.flatnonzero(now & ~before & after) if not now.all() else np.zeros(0, np.intp)


def _lateness(
    pair: Pair, of: Sequence[Callable[[Cycle], NDArray[np.intp]]], none: str
) -> _Measured:
    """How late the result's instants (indices) of some kinds are, over the length of the cycle; the
    shorter way round if periodic.

    Each of the reference's against the nearest of its kind; not finite where the result has not as
    many.
    """
    fraction, late, at, counts = pair.found.fraction, list[float](), list[int](), [0, 0]
    for kind in of:
        theirs, ours = kind(pair.expected), kind(pair.found)
        counts = [
            counts[0] + max(len(theirs) - len(ours), 0),
            counts[1] + max(len(ours) - len(theirs), 0),
        ]
        apart = fraction[ours] - fraction[theirs][:, None]
        apart = (
            np.where(np.abs(apart) > 0.5, (apart + 0.5) % 1 - 0.5, apart)
            if pair.periodic
            else apart
        )
        lacking = len(ours) < len(theirs)
        late += [math.nan if lacking else float(row[np.argmin(np.abs(row))]) for row in apart]
        at += theirs.tolist()
    whose = zip(counts, ("the reference's", "the result's"), ("result", "reference"), strict=True)
    note = "; ".join(
        f"{count} of {one} without a counterpart in the {other}"
        for count, one, other in whose
        if count
    )
    if not late:
        return _none("; ".join(filter(None, (none, note))))
    value, time = _worst(np.array(late), np.ones(len(late), bool), pair.found.time[at])
    step = float(np.max(np.diff(fraction), initial=0.0))
    return _Measured(value=value, time=time, note=note, uncertainty=step, unmatched=bool(note))


def _full_stick(pair: Pair, *, ends: bool) -> _Measured:
    """Starts or ends of full stick."""

    def at(cycle: Cycle) -> NDArray[np.intp]:
        whole = _stick_status(cycle, pair.scales.half_width) == _FULL_STICK
        return (
            len(whole) - 1 - _onsets(whole[::-1], pair.periodic)[::-1]
            if ends
            else _onsets(whole, pair.periodic)
        )

    return _lateness(
        pair, [at], f"the reference does not come {'out of' if ends else 'into'} full stick"
    )


def _slip_reversal(pair: Pair) -> _Measured:
    """First instants of slip in each sense after slip in the other, whatever stick there was in
    between.
    """

    def turns(sense: int, cycle: Cycle) -> NDArray[np.intp]:
        forward, reverse = (
            (cycle.state == s) @ shares(cycle.x) for s in (SLIP_FORWARD, SLIP_REVERSE)
        )
        senses = np.sign(forward - reverse)  # of the longer slip zone
        slipping = np.flatnonzero(senses[:-1] if pair.periodic else senses)
        turned = (senses[slipping] == sense) & (np.roll(senses[slipping], 1) == -sense)
        if not pair.periodic:
            turned[:1] = False
        return np.asarray(slipping[turned])

    return _lateness(
        pair, [partial(turns, 1), partial(turns, -1)], "slip does not reverse in either"
    )


def _slip(pair: Pair, maximum: bool) -> _Measured:
    """s - s_ref over the range of s_ref, where both are in contact: apart from there it is a
    displacement and nothing slips.

    Absolute, over f p_ref a_ref/E*, where the range of s_ref is below 1e-12 of that.
    """
    touching = (pair.expected.state != OPEN) & (pair.found.state != OPEN)
    applies = pair.judged & touching.any(axis=1)
    if not applies.any():
        return _none("no instant has points in contact in both")
    largest = np.ptp(pair.expected.slip[touching])
    nothing = bool(largest <= 1e-12 * pair.scales.slip)
    difference = np.where(
        touching,
        (pair.found.slip - pair.expected.slip) / (pair.scales.slip if nothing else largest),
        0.0,
    )
    if maximum:
        series, places = _worst_point(difference, pair.found.x)
        return _at_worst(pair, series, applies, places=places, absolute=nothing)
    lengths = touching * shares(pair.found.x)
    mean = over((difference**2 * lengths).sum(axis=1), lengths.sum(axis=1))
    return _at_worst(pair, np.sqrt(mean), applies, absolute=nothing)


def _moved(pair: Pair, name: str, unit: Callable[[_Scales], float]) -> _Measured:
    """A series over time that not every solution states, result − reference."""
    expected, found = getattr(pair.expected, name), getattr(pair.found, name)
    if expected is None or found is None:
        return _none("a solution states none")
    return _at_worst(pair, (found - expected) / unit(pair.scales))


def _contact_centre(pair: Pair) -> _Measured:
    apart = (
        np.mean(pair.found.contact_edges - pair.expected.contact_edges, axis=1)
        / pair.scales.half_width
    )
    return _at_worst(pair, apart, places=np.mean(pair.found.contact_edges, axis=1))


# ---------------------------------------------------------------------------------- work and energy


def _stroke(pair: Pair) -> tuple[Array, _Mask, str]:
    """(U - U_ref) over the range of U_ref, (k,), NaN where that is nothing; the instants that
    count; a note.
    """
    expected, found = pair.expected.tangential_displacement, pair.found.tangential_displacement
    stroke = float(np.ptp(expected))
    # Asked the other way round, a NaN would count as standing still and hide.
    moves = not stroke <= 1e-12 * pair.scales.shift
    difference = (
        (found - expected) / stroke
        if stroke > 1e-12 * pair.scales.shift
        else np.full_like(expected, np.nan)
    )
    return (
        difference,
        pair.judged & moves,
        "" if (pair.judged & moves).any() else "the reference does not move sideways",
    )


def _displacement(pair: Pair, *, centred: bool) -> _Measured:
    """`centred`: without its mean over time."""
    difference, moves, note = _stroke(pair)
    weight = shares(pair.found.time)
    mean = (weight @ difference) / weight.sum() if centred else 0.0
    return _at_worst(pair, difference - mean, moves, note=note)


def loop_work(cycle: Cycle) -> float:
    """Closed integral of Q dU by the trapezoidal rule over the instants [energy / thickness]: a
    second way to W.
    """
    return float(np.trapezoid(cycle.tangential_load, cycle.tangential_displacement))


def bulk_work(of: ContactSolution | Cycle, materials: Materials) -> float:
    """-closed integral of m_q d(eps) by the trapezoidal rule over the instants [energy /
    thickness]: what bulk stress puts in.

    m_q is the moment of the shear about x = 0, where U is read: this and the closed integral of Q
    dU add up to the dissipation, which neither is alone. 0 without bulk stress.
    """
    if of.shear_moment is None:
        return 0.0
    return -float(np.trapezoid(of.shear_moment, bulk_strain(of, materials)))


def normal_work(solution: ContactSolution) -> float | None:
    """Closed integral of P dV - M d(tilt) over the last cycle, V the normal approach, by the
    trapezoidal rule [energy / thickness].

    What normal load and moment put in: with Q dU and the bulk term it adds up to the dissipation.
    None where it is 0 by nature (P and tilt constant; half-planes of like materials, where V and M
    hang on P and the tilt only) and where the solution is not of our finite elements, which alone
    know V.
    """
    steps = solution.last_cycle
    pairs = [(solution.normal_load, solution.normal_approach)]
    if solution.tilt is not None and solution.moment is not None:
        pairs.append((-solution.moment, solution.tilt))
    still = np.ptp(solution.normal_load[steps]) == 0 and (
        solution.tilt is None or np.ptp(solution.tilt[steps]) == 0
    )
    if (
        still
        or are_half_planes(solution.scene)
        or solution.engine != "halfplane_fe"
        or np.isnan(solution.loop_work)
    ):
        return None
    return sum(float(np.trapezoid(force[steps], way[steps])) for force, way in pairs)


def on_straight_steps(solution: ContactSolution) -> ContactSolution:
    """The solution with its dissipation on the straight lines between its instants: finite elements
    add what a curve makes.
    """
    curve = solution.record.energy.get("curve")
    if curve is None or not solution.dissipation > 0:
        return solution
    share = 1 - float(curve[solution.last_cycle[1:]].sum()) / solution.dissipation
    density = freeze(solution.dissipation_density * share)
    return replace(solution, dissipation=solution.dissipation * share, dissipation_density=density)


def _steps(pair: Pair, *, out: bool) -> _Measured:
    """W with the error of the steps taken `out`, or that error alone: of straight steps, with what
    the result adds for a curve.
    """
    polygon, straight = (
        pair.polygon_reference or pair.reference,
        on_straight_steps(pair.result).dissipation,
    )
    if out:
        return _of_amounts(polygon.dissipation, straight, pair.scales.dissipation)
    curved = pair.result.dissipation / straight if straight else 1.0
    return _of_amounts(
        pair.reference.dissipation, polygon.dissipation * curved, pair.scales.dissipation
    )


def _loop(pair: Pair, *, bulk: bool) -> _Measured:
    """`bulk`: with its bulk term."""
    works = _bulk_works(pair) if bulk else (0.0, 0.0) if pair.periodic else _NO_LOOP
    if isinstance(works, str):
        return _none(works)
    expected, found = (
        loop_work(c) + w for c, w in zip((pair.expected, pair.found), works, strict=True)
    )
    return _of_amounts(expected, found, pair.scales.dissipation)


_NO_LOOP = "the path is not periodic: no loop"


def _bulk_works(pair: Pair) -> tuple[float, float] | str:
    """The bulk term of the loop of both, or why there is none."""
    if not pair.periodic:
        return _NO_LOOP
    for cycle, solution in ((pair.expected, pair.reference), (pair.found, pair.result)):
        if cycle.shear_moment is None:
            return f"{name_of(solution.engine)} states no moment of its shear"
    materials = pair.result.scene.material
    return bulk_work(pair.expected, materials), bulk_work(pair.found, materials)


def _bulk_work(pair: Pair) -> _Measured:
    works = _bulk_works(pair)
    if isinstance(works, str):
        return _none(works)
    work, scale = pair.reference.dissipation, pair.scales.dissipation
    nothing = abs(work) <= _NO_DISSIPATION * scale
    return _Measured(value=(works[1] - works[0]) / (scale if nothing else work), absolute=nothing)


def _drift(pair: Pair) -> _Measured:
    both = [(name_of(s.engine), s.dissipation_drift) for s in (pair.reference, pair.result)]
    words = "; ".join(
        f"{name}: {'not known' if math.isnan(it) else minus(f'{it:+.1e}') + ' in its last cycle'}"
        for name, it in both
        if it
    )
    if any(math.isnan(it) for _, it in both):
        return _none(words)
    return _Measured(value=both[1][1] - both[0][1], note=words)


def _works_nowhere(pair: Pair) -> bool:
    """Whether the reference does no friction work anywhere (a NaN counts as work)."""
    return bool(
        np.max(np.abs(pair.expected.dissipation_density)) <= _NO_DISSIPATION * pair.scales.density
    )


def _density(pair: Pair) -> _Measured:
    nothing, expected, found = (
        _works_nowhere(pair),
        pair.expected.dissipation_density,
        pair.found.dissipation_density,
    )
    difference = (found - expected) / (pair.scales.density if nothing else np.max(np.abs(expected)))
    value, place = _worst(difference, np.ones(len(difference), bool), pair.found.x)
    return _Measured(
        value=value,
        absolute=nothing,
        place=None if place is None else place / pair.scales.half_width,
    )


def _density_norm(pair: Pair) -> _Measured:
    nothing, x = _works_nowhere(pair), pair.found.x
    expected, found = pair.expected.dissipation_density, pair.found.dissipation_density
    whole = pair.scales.density * np.sqrt(pair.scales.half_width) if nothing else norm(x, expected)
    return _Measured(value=float(norm(x, found - expected) / whole), absolute=nothing)


def _place_of_density(pair: Pair) -> _Measured:
    if _works_nowhere(pair):
        return _none("the reference dissipates nothing")
    x, length = pair.found.x, pair.scales.half_width
    expected, found = (
        np.atleast_2d(cycle.dissipation_density) for cycle in (pair.expected, pair.found)
    )
    place = float(x[np.argmax(found)])
    shift = float(_peak_place(expected, found, x)[0] / length)
    return _Measured(value=shift, place=place / length, uncertainty=_spacing_at(x, place) / length)


def _energy_balance(pair: Pair) -> _Measured:
    # From the record of the result, which alone knows what its bodies store.
    balance = pair.result.record.certificates.get("energy_balance")
    if balance is None:
        return _none("the result records none")
    series = np.asarray(balance, dtype=float)[pair.result.last_cycle]
    return _at_worst(pair, series, np.ones(len(series), bool))


# ---------------------------------------------------------------------------------------- the table


def _row(
    key: str,
    words: str,
    unit: str,
    where: tuple[str, str],
    needs: str,
    measure: _Measure,
    **more: Any,
) -> _Definition:
    """Of `words`, "label: how it is computed"; `where`: norm and region; `needs`: separated by
    blanks.
    """
    label, _, text = words.partition(": ")
    row: dict[str, Any] = {
        "unit": unit,
        "norm": where[0],
        "region": where[1],
        "needs": tuple(needs.split()),
    }
    return _Definition(
        key=key, label=label, text=text, measure=measure, **row, **{"judged_by": key, **more}
    )


_POINTS = "every point, edges included; judged instants"
_INSTANTS = "judged instants"
_STICK = (
    f"{_INSTANTS} at which both have one, but for a single step by which full stick comes or goes"
    " apart"
)
_WORST_INSTANT = "value at the worst instant"
_L2 = "L2 over x; worst instant"
_WORK = "A f² P_ref²"
# How the differences become one value, and which of them count.
_ONE_VALUE, _POINTS_OF_CYCLE = (
    ("one value", "last cycle"),
    (
        "one value",
        "every point, edges included; last cycle",
    ),
)
_AT_INSTANTS, _AT_POINTS, _IN_CYCLE = (
    (_WORST_INSTANT, region) for region in (_INSTANTS, _POINTS, "last cycle")
)
_WORST_POINT = "value at the worst point and instant"
_IN_CONTACT = "points in contact in both; judged instants"
_OF_SIDE = (
    "edge; also over the local spacing h of the result's points, and with the uncertainty that the"
    " result states"
)
_NEAREST = "to a point; of several peaks of the reference within 5 % the nearest"


_PULLED, _TURNED, _UNSYMMETRIC = (attrgetter(name) for name in ("pulled", "turned", "unsymmetric"))


def _has_polygon(pair: Pair) -> bool:
    return pair.polygon_reference is not None


METRICS = {
    row.key: row
    for row in (
        # The first table: absolute values of both.
        _row(
            "largest_pressure",
            "Peak pressure: max p / max p_ref − 1 over the cycle, that of the result over its"
            " points, that of theory its own",
            "of the reference",
            ("one value", "every point; last cycle"),
            "pressure",
            _largest_pressure,
            quantity="stress",
            judged_by="peak_pressure",
        ),
        _row(
            "largest_half_width",
            "Contact half-width: (largest half distance of the contact edges)/(that of the"
            " reference) − 1",
            "of the reference",
            _ONE_VALUE,
            "pressure",
            _largest_half_width,
            quantity="length",
            judged_by="contact_edge",
        ),
        _row(
            "permanent_stick",
            "Stick half-width, permanent: half-width that sticks through the whole last cycle,"
            " result − reference",
            "of a_ref",
            _ONE_VALUE,
            "state whole_cycle",
            partial(_of_stick_zone, of=lambda s: s.permanent_stick_half_width),
            quantity="length",
        ),
        _row(
            "stick_eccentricity",
            "Stick zone, centre: middle of what sticks through the whole last cycle, result −"
            " reference",
            "of a_ref",
            _ONE_VALUE,
            "state whole_cycle",
            partial(_of_stick_zone, of=_middle_of_stick),
            quantity="length",
            judged_by="permanent_stick",
            exists=_UNSYMMETRIC,
        ),
        _row(
            "largest_slip",
            "Largest slip: largest range of s of a point through the cycle, over that of the"
            " reference, − 1; that of the result over its points, that of theory its own",
            "of the reference",
            ("one value", "points while they are in contact; last cycle"),
            "slip state whole_cycle",
            _largest_slip,
            quantity="slip",
            absolute_unit="f p_ref a_ref/E*",
        ),
        _row(
            "dissipation",
            "Dissipation: W − W_ref",
            "of W_ref",
            _ONE_VALUE,
            "dissipation whole_cycle",
            _dissipation,
            quantity="energy",
            absolute_unit=_WORK,
        ),
        _row(
            "dissipation_density_peak",
            "Largest pointwise dissipation: max w / max w_ref − 1, that of the result over its"
            " points, that of theory its own; with its place",
            "of largest w_ref",
            _POINTS_OF_CYCLE,
            "dissipation_density whole_cycle",
            _largest_density,
            quantity="energy density",
            absolute_unit=f"{_WORK}/a_ref",
        ),
        _row(
            "edge_tension",
            "Tension at the trailing edge: largest stress along a face at an edge of contact"
            " through the cycle, over that of the reference, − 1; of half-plane theory and finite"
            " elements alone",
            "of the reference",
            ("one value", "both edges of contact, both bodies; last cycle"),
            "pressure shear whole_cycle",
            _edge_tension,
            quantity="stress",
            absolute_unit="f p_ref",
        ),
        # The others.
        _row(
            "largest_pressure_common",
            "Peak pressure, common points: max p / max p_ref − 1 over the cycle, both over the"
            " result's points and instants",
            "of the reference",
            ("one value", "every point; last cycle"),
            "pressure",
            partial(_of_common, of=_largest_of_pressure, scale="pressure"),
        ),
        _row(
            "largest_slip_common",
            "Largest slip, common points: largest range of s of a point through the cycle, over"
            " that of the reference, − 1, both over the result's points and instants",
            "of the reference",
            ("one value", "points in contact in both; last cycle"),
            "slip state whole_cycle friction",
            _largest_common_slip,
            absolute_unit="f p_ref a_ref/E*",
        ),
        _row(
            "dissipation_density_peak_common",
            "Largest pointwise dissipation, common points: max w / max w_ref − 1, both over the "
            "result's points",
            "of largest w_ref",
            _POINTS_OF_CYCLE,
            "dissipation_density whole_cycle",
            partial(_of_common, of=_largest_of_density, scale="density"),
            absolute_unit=f"{_WORK}/a_ref",
        ),
        _row(
            "peak_pressure",
            "Peak pressure, worst instant: max p / max p_ref − 1 of an instant, both over the same"
            " points",
            "of peak p_ref",
            _AT_POINTS,
            "pressure",
            _peak_pressure,
        ),
        _row(
            "pressure",
            "Pressure, L2: ‖p − p_ref‖/‖p_ref‖, L2 over x",
            "of ‖p_ref‖",
            (_L2, _POINTS),
            "pressure",
            partial(_traction, name="pressure"),
            signed=False,
        ),
        _row(
            "shear",
            "Shear traction, L2: ‖q − q_ref‖/(f ‖p_ref‖), L2 over x, since q changes sign in the"
            " cycle",
            "of f ‖p_ref‖",
            (_L2, _POINTS),
            "shear",
            lambda pair: _traction(pair, "shear", pair.scales.friction),
            signed=False,
        ),
        _row(
            "contact_edge",
            "Contact edge: outward shift of the worse edge",
            "of a_ref",
            _AT_INSTANTS,
            "",
            _contact_edge,
        ),
        _row(
            "stick_edge",
            "Stick edge: outward shift of the worse edge, where both have one (in full stick: the"
            " contact edge)",
            "of a_ref",
            (_WORST_INSTANT, _STICK),
            "stick_edges",
            _stick_edge,
        ),
        _row(
            "state",
            "Stick/slip map: share of the length in contact whose state (open, stick, forward or"
            " reverse slip) differs",
            "of the contact",
            ("mean over the cycle", "points in contact in either; instants in contact"),
            "state",
            _state,
            signed=False,
        ),
        _row(
            "tangential_displacement",
            "Tangential displacement: U − U_ref over the range of U_ref in the cycle",
            "of U_ref's stroke",
            _AT_INSTANTS,
            "tangential_displacement",
            partial(_displacement, centred=False),
        ),
        _row(
            "dissipation_polygon",
            "Dissipation, steps' error out: W − W_ref, both on the straight lines between the"
            " instants: all errors except that of the steps",
            "of W_ref",
            _ONE_VALUE,
            "dissipation whole_cycle",
            partial(_steps, out=True),
            absolute_unit=_WORK,
            exists=_has_polygon,
        ),
        _row(
            "dissipation_step",
            "Dissipation, steps' error only: W_ref on the straight lines between the instants, with"
            " what finite elements add for a curve, − W_ref",
            "of W_ref",
            _ONE_VALUE,
            "",
            partial(_steps, out=False),
            absolute_unit=_WORK,
            exists=_has_polygon,
        ),
        _row(
            "hysteresis",
            "Hysteresis loop: closed integral of Q dU − that of the reference, trapezoidal rule"
            " over the same instants",
            "of its area",
            _ONE_VALUE,
            "tangential_displacement whole_cycle",
            partial(_loop, bulk=False),
            absolute_unit=_WORK,
        ),
        _row(
            "hysteresis_with_bulk",
            "Hysteresis loop with its bulk term: closed integral of Q dU − m_q dε − that of the"
            " reference; with bulk stress Q dU alone is not the dissipation",
            "of its area",
            _ONE_VALUE,
            "tangential_displacement whole_cycle",
            partial(_loop, bulk=True),
            absolute_unit=_WORK,
            exists=_PULLED,
        ),
        _row(
            "bulk_work",
            "Bulk term of the loop: −closed integral of m_q dε − that of the reference; m_q = ∫x q"
            " dx, ε = σ/E′, lower − upper body",
            "of W_ref",
            _ONE_VALUE,
            "shear dissipation whole_cycle",
            _bulk_work,
            absolute_unit=_WORK,
            judged_by="dissipation",
            exists=_PULLED,
        ),
        _row(
            "dissipation_drift",
            "Drift of the dissipation: change of W in the last cycle over W, result − reference; 0"
            " where it is steady",
            "of W",
            ("one value", "last two cycles"),
            "dissipation whole_cycle",
            _drift,
            exists=lambda pair: pair.periodic and pair.unsymmetric,
        ),
        _row(
            "contact_centre",
            "Contact centre: middle of the contact edges, result − reference",
            "of a_ref",
            _AT_INSTANTS,
            "",
            _contact_centre,
            exists=_TURNED,
        ),
        _row(
            "moment",
            "Moment: M = ∫x p dx, result − reference",
            "of P_ref a_ref",
            _AT_INSTANTS,
            "pressure",
            partial(_moved, name="moment", unit=lambda s: s.normal_load * s.half_width),
            exists=_TURNED,
        ),
        _row(
            "tilt",
            "Tilt: that of the upper body, result − reference",
            "of A P_ref/a_ref",
            _AT_INSTANTS,
            "",
            partial(
                _moved, name="tilt", unit=lambda s: s.compliance * s.normal_load / s.half_width
            ),
            exists=_TURNED,
        ),
        _row(
            "dissipation_density",
            "Pointwise dissipation: w(x) − w_ref(x) over the largest w_ref; with its place",
            "of largest w_ref",
            ("value at the worst point", "every point, edges included; last cycle"),
            "dissipation_density whole_cycle",
            _density,
            absolute_unit=f"{_WORK}/a_ref",
        ),
        _row(
            "pressure_maximum",
            "Pressure, maximum: largest |p − p_ref|, with its sign, over the largest p_ref of the"
            " instant; with its place",
            "of peak p_ref",
            (_WORST_POINT, _POINTS),
            "pressure",
            partial(_traction_maximum, name="pressure"),
        ),
        _row(
            "pressure_peak_place",
            f"Place of peak pressure: x of the largest p − x of the largest p_ref, {_NEAREST}",
            "of a_ref",
            _AT_POINTS,
            "pressure",
            lambda pair: _place_of_peak(pair, lambda c: c.pressure, -math.inf),
        ),
        _row(
            "shear_maximum",
            "Shear traction, maximum: largest |q − q_ref|, with its sign, over f times the largest"
            " p_ref of the instant; with its place",
            "of f peak p_ref",
            (_WORST_POINT, _POINTS),
            "shear",
            lambda pair: _traction_maximum(pair, "shear", pair.scales.friction),
        ),
        _row(
            "peak_shear",
            "Peak shear traction: largest |q| − largest |q_ref|, over f times the largest p_ref of"
            " the instant",
            "of f peak p_ref",
            _AT_POINTS,
            "shear",
            _peak_shear,
        ),
        _row(
            "shear_peak_place",
            "Place of peak shear traction: x of the largest |q| − x of the largest |q_ref|,"
            f" {_NEAREST}",
            "of a_ref",
            (_WORST_INSTANT, f"{_POINTS} that carry shear"),
            "shear",
            lambda pair: _place_of_peak(
                pair, lambda c: np.abs(c.shear), _NO_SHEAR * pair.scales.shear
            ),
        ),
        _row(
            "resultant_normal",
            "Normal resultant: (resultant − P)/P, by the result's own weights and normals (needs no"
            " reference), otherwise by the trapezoidal rule, minus the error of that rule for the"
            " reference",
            "of P",
            _AT_INSTANTS,
            "pressure",
            partial(_resultant, component=0),
        ),
        _row(
            "resultant_tangential",
            "Tangential resultant: (resultant − Q)/P, as the normal resultant",
            "of P",
            _AT_INSTANTS,
            "shear",
            partial(_resultant, component=1),
        ),
        *(
            _row(
                f"contact_edge_{side}",
                f"Contact edge, {side}: outward shift of the {side} {_OF_SIDE}",
                "of a_ref",
                _AT_INSTANTS,
                "",
                partial(_edge_of_side, kind="contact", side=side),
            )
            for side in _SIDES
        ),
        *(
            _row(
                f"stick_edge_{side}",
                f"Stick edge, {side}: outward shift of the {side} {_OF_SIDE}",
                "of a_ref",
                (_WORST_INSTANT, _STICK),
                "stick_edges friction",
                partial(_edge_of_side, kind="stick", side=side),
            )
            for side in _SIDES
        ),
        _row(
            "stick_set",
            "Stick set, not shared: 1 − (what sticks in both)/(what sticks in either), measured by"
            " length times time",
            "of the union",
            ("Jaccard distance over x and time", "points that stick in either; last cycle"),
            "state whole_cycle friction",
            _stick_set,
            signed=False,
        ),
        _row(
            "full_stick_start",
            "Start of full stick: first instant of full stick, result − reference, to a step; full"
            " stick: at least two instants whose stick edges are the contact edges; the nearest"
            " start is compared",
            "of the period",
            _IN_CYCLE,
            "state whole_cycle friction",
            partial(_full_stick, ends=False),
        ),
        _row(
            "full_stick_end",
            "End of full stick: last instant of full stick, result − reference, as its start",
            "of the period",
            _IN_CYCLE,
            "state whole_cycle friction",
            partial(_full_stick, ends=True),
        ),
        _row(
            "slip_reversal",
            "Reversal of slip: first instant of slip in the new sense, result − reference, to a"
            " step; the sense is that of the longer slip zone",
            "of the period",
            _IN_CYCLE,
            "state whole_cycle friction",
            _slip_reversal,
        ),
        _row(
            "slip",
            "Slip, L2: root mean square over x of s − s_ref, over the range of s_ref in the cycle",
            "of the range of s_ref",
            (_L2, _IN_CONTACT),
            "slip friction",
            partial(_slip, maximum=False),
            signed=False,
            absolute_unit="f p_ref a_ref/E*",
        ),
        _row(
            "slip_maximum",
            "Slip, maximum: largest |s − s_ref|, with its sign, over the range of s_ref in the"
            " cycle; with its place",
            "of the range of s_ref",
            (_WORST_POINT, _IN_CONTACT),
            "slip friction",
            partial(_slip, maximum=True),
            absolute_unit="f p_ref a_ref/E*",
        ),
        _row(
            "dissipation_absolute",
            "Dissipation, absolute: (W − W_ref)/(A f² P_ref²): of use near full stick, where W_ref"
            " goes to 0",
            f"of {_WORK}",
            _ONE_VALUE,
            "dissipation whole_cycle",
            lambda pair: _Measured(
                value=(pair.result.dissipation - pair.reference.dissipation)
                / pair.scales.dissipation
            ),
        ),
        _row(
            "hysteresis_distance",
            "Hysteresis loop, distance: U − U_ref, without its mean over time: distance of the"
            " loops in U at the same phase",
            "of U_ref's stroke",
            _AT_INSTANTS,
            "tangential_displacement whole_cycle",
            partial(_displacement, centred=True),
        ),
        _row(
            "dissipation_density_norm",
            "Pointwise dissipation, L2: ‖w − w_ref‖/‖w_ref‖, L2 over x",
            "of ‖w_ref‖",
            ("L2 over x", "every point, edges included; last cycle"),
            "dissipation_density whole_cycle",
            _density_norm,
            signed=False,
            absolute_unit=f"{_WORK}/√a_ref",
        ),
        _row(
            "dissipation_density_peak_place",
            "Pointwise dissipation, place of peak: x of the largest w − x of the largest w_ref, "
            f"{_NEAREST}",
            "of a_ref",
            _POINTS_OF_CYCLE,
            "dissipation_density whole_cycle",
            _place_of_density,
        ),
        _row(
            "energy_balance",
            "Energy balance: work of the loads − stored energy − dissipation, step by step, over"
            " the largest work of the loads so far, as the result's record states it; needs no"
            " reference",
            "of the work of the loads",
            _IN_CYCLE,
            "",
            _energy_balance,
            signed=False,
        ),
    )
}
