"""The discrepancy of a result as one vector, how much of it a fault would explain, and the faults that have a closed form.

Every fault is a hypothesis: "the result is the reference, but for this". A hypothesis predicts tractions p*, q* on the result's
points and instants, its free figure fitted by least squares, and explains the share

    e = 1 - |found - predicted|^2 / |found - expected|^2

of the discrepancy. The norm is that of p/p_ref and q/(f p_ref) over x and time, so that errors of pressure and shear that are
the same share of their scales count alike. A prediction is taken rather than a linear mode, since large faults are not linear:
a sign, a factor of a thousand, a contact half as wide.

Closed forms: faults of the file (a sign, two columns swapped, a factor) act on the reference's arrays. Faults of the question
(wrong modulus or friction, no memory, not yet steady, other instants) have the exact answer of a neighbouring scene. A mesh too
coarse at the edges and bodies that are not alike are recognised by where the discrepancy lies.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.comparison import Comparison
from reports.comparison.metrics import Verdict, norm, over, shares, verdict_on
from scenes import EllipseLoad, InputError, LineOfAction, Materials, PolygonLoad, Scene, Wave, WaveSum
from semi_analytic.profiles import contact_of

Array = NDArray[np.float64]
Tractions = tuple[Array, Array]
"""Pressure and shear, (k, n) each [stress]."""

# A steady cycle has some ten features (turning points, ends of full stick); three instants to each are enough to tell faults apart.
MOST_INSTANTS = 32
# A fitted factor counts as the round one that it is near: a mesh does not move a resultant by more. A factor of a hundred or more
# is one of units even farther off: what is left of it is another fault.
NEAR, NEAR_OF_UNITS = 0.02, 0.25
# How a figure is fitted to the pressure, which costs nothing.
FINELY: Any = {"rounds": 30, "close": 1e-6}
# Below this a factor is no fault of a file: modulus, radius or loads explain it better. A factor of p alone has no rival: no
# elastic contact has another pressure and the same width and shear.
LEAST_FACTOR, LEAST_OF_PRESSURE = 0.01, 1e-3
# f at which next to nothing slips, over the scene's: a mesh keeps the infinite shear of bonded faces finite, as a large f does.
NO_SLIP = (15.0, 50.0, 300.0)
# Longest cycle, in steps, whose steps may be too long.
MOST_STEPS = 64
# Loads that differ by less than this share of the largest P are one: those of one revolution and the next differ by rounding.
SAME_LOAD = 1e-9
# Spacings to each side of an edge that a mesh can get wrong: the element with the edge in it, and its neighbour.
REACH = 2.0
# A traction that leaves the edge as a root has an error of about sqrt(2 h/a) of its peak over the element with the edge: shear, at
# stick edges, up to 1.2 of that on meshes of a/5 to a/24, pressure up to 0.36, its edge being found to a part of an element. A soft
# layer or a short body moves the pressure's edge by 0.7 to 1.5 of that.
MOST = (0.4, 1.0)


@dataclass(frozen=True, eq=False)
class Discrepancy:
    """What is to be explained: some instants of the last cycle, all points."""

    comparison: Comparison
    rows: NDArray[np.intp]  # (k,), the instants taken, of the last cycle's
    expected: Tractions  # of the reference
    found: Tractions  # of the result; where it has no number, the reference's
    weight: Array  # (k, n) of the squares, 0 where the result has no number
    missing: float  # share of the result's tractions that are no numbers
    scene: Scene  # the question that `expected` answers: the comparison's, or with a fault in it that was found before
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
        """(k,) of the cycle."""
        return self.comparison.found.fraction[self.rows]

    @property
    def unsymmetric(self) -> bool:
        """Whether bulk stress, tilt or unequal sides make tractions that are not even in x."""
        return self.comparison.pulled or self.comparison.turned

    @property
    def of_pressure(self) -> Discrepancy:
        """That of the pressure alone: between like bodies it knows nothing of friction, and tells the rest apart."""
        return replace(self, sheared=False)

    @cached_property
    def beyond_theory(self) -> Tractions:
        """What is expected less half-plane theory of the scene; 0 where it is that."""
        if self.exact:
            return np.zeros((1, len(self.x))), np.zeros((1, len(self.x)))
        found = semi_analytic.solve(self.scene, x=self.x, time=self.time, fields=("pressure", "shear"))
        return self.expected[0] - found.pressure, self.expected[1] - found.shear

    def product(self, one: Tractions, other: Tractions) -> float:
        """Weighted scalar product of two pairs of tractions over their scales."""
        scales = self.comparison.scales
        products = one[0] * other[0] / scales.pressure**2 + self.sheared * (one[1] * other[1] / scales.shear**2)
        return float(np.sum(self.weight * products))

    def apart(self, predicted: Tractions) -> float:
        """Weighted square of found less predicted; infinite where the prediction holds a NaN."""
        off = self.found[0] - predicted[0], self.found[1] - predicted[1]
        value = self.product(off, off)
        return value if np.isfinite(value) else float("inf")

    def explained(self, predicted: Tractions) -> float:
        """Share of the discrepancy that `predicted` explains: 1 is all, 0 none, below 0 makes it worse."""
        whole = self.apart(self.expected)
        return 1 - self.apart(predicted) / whole if whole > 0 else 0.0

    def errors(self) -> tuple[float, float]:
        """||p - p_ref||/||p_ref|| and ||q - q_ref||/(f ||p_ref||) at the worst of the instants."""
        size = norm(self.x, self.expected[0])
        p, q = (norm(self.x, found - expected) for found, expected in zip(self.found, self.expected, strict=True))
        sizes = (size, self.comparison.scales.friction * size)
        worst = [float(np.nanmax(over(off, unit), initial=0.0)) for off, unit in zip((p, q), sizes, strict=True)]
        return worst[0], worst[1]

    def within(self, times: float = 1.0) -> bool:
        """Whether both errors are within so many tolerances of the scene."""
        limits = [times * (self.comparison.scene.tolerances.limit(key) or 0.0) for key in ("pressure", "shear")]
        return all(verdict_on(*pair) is Verdict.WITHIN for pair in zip(self.errors(), limits, strict=True))


def discrepancy(comparison: Comparison) -> Discrepancy | None:
    """The discrepancy of `comparison`; None where the result has no instant with a contact or not one number."""
    usable = np.flatnonzero(comparison.judged if comparison.judged.any() else comparison.touching)
    if not len(usable):
        return None
    rows = usable[np.unique(np.linspace(0, len(usable) - 1, min(len(usable), MOST_INSTANTS)).round().astype(int))]
    expected, found = ((side.pressure[rows], side.shear[rows]) for side in (comparison.expected, comparison.found))
    sheared = not np.isnan(found[1]).all()
    if not sheared:  # a file without shear: it counts for nothing
        found = found[0], np.nan_to_num(expected[1])
    known = np.all([np.isfinite(field) for field in (*expected, *found)], axis=0)
    if not known.any():
        return None
    weight = known * shares(comparison.found.time[rows])[:, None] * shares(comparison.found.x)
    expected = np.nan_to_num(expected[0]), np.nan_to_num(expected[1])
    filled = np.where(known, found[0], expected[0]), np.where(known, found[1], expected[1])
    exact = comparison.reference.engine == "semi_analytic"
    left_out = float(1 - known.mean())
    return Discrepancy(comparison, rows, expected, filled, weight / weight.sum(), left_out, comparison.scene, exact, sheared)


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One fault, fitted."""

    fault: str  # its key, see `diagnosis.FAULTS`
    predicted: Tractions  # of a result that has just this fault
    figures: Mapping[str, float] = field(default_factory=dict)  # what was fitted or measured, by name
    # Takes the fault out of the tractions found; None where the next fault is looked for beyond what this one predicts.
    mend: Callable[[Tractions], Tractions] | None = None
    scene: Scene | None = None  # the question that `predicted` is the exact answer of; None where there is no such scene

    def mended(self, what: Discrepancy) -> Discrepancy:
        """What is left to explain without this fault."""
        if self.mend is not None:
            mended = [np.where(what.weight > 0, *pair) for pair in zip(self.mend(what.found), what.expected, strict=True)]
            return replace(what, found=(mended[0], mended[1]))
        if self.scene is None or not what.exact:
            return replace(what, expected=self.predicted, exact=False)
        return replace(what, expected=self.predicted, scene=self.scene)


def fitted(
    what: Discrepancy,
    predict: Callable[[float], Tractions | None],
    tries: tuple[float, ...],
    *,
    rounds: int = 12,
    close: float = 1e-4,
) -> tuple[float, Tractions] | None:
    """The figure that leaves least of the discrepancy, and its prediction; None where no try has a solution.

    The best of `tries` (ascending), then parabolas through the best and its neighbours, each keeping the best three, until two are
    as `close` (of the range of the tries): the discrepancy left is a square, so a parabola is its own shape near the least.
    """
    seen: dict[float, tuple[float, Tractions]] = {}

    def look(figure: float) -> None:
        try:
            tractions = predict(figure)
        except InputError:  # gross sliding, separation
            return
        if tractions is not None:
            seen[figure] = what.apart(tractions), tractions

    for figure in tries:
        look(figure)
    for _ in range(rounds if len(seen) > 2 else 0):
        known = sorted((figure, left) for figure, (left, _) in seen.items())
        at = int(np.clip(np.argmin([left for _, left in known]), 1, len(known) - 2))
        (a, left), (b, middle), (c, right) = known[at - 1 : at + 2]
        down, up = (middle - left) / (b - a), (right - middle) / (c - b)
        bend = (up - down) / (c - a)
        lowest = (b + a) / 2 - down / (2 * bend) if np.isfinite(bend) and bend > 0 else (b + c) / 2
        figure = float(np.clip(lowest, a + 0.05 * (b - a), c - 0.05 * (c - b)))
        if any(abs(figure - other) <= close * np.ptp(tries) for other in seen):
            break
        look(figure)
    if not seen:
        return None
    best = min(seen, key=lambda figure: seen[figure][0])
    return best, seen[best][1]


# --------------------------------------------------------------------------------------------------------- faults of the file
def file_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """A sign, two columns swapped, a factor of both or of the pressure alone: k = <found, expected>/<expected, expected>.

    Widths set a factor apart from loads k times too large: no elastic contact carries k times the load on the same width.
    """
    p, q = what.expected
    sheared = bool(np.any(q))
    yield Hypothesis("pressure_sign", (-p, q), mend=lambda found: (-found[0], found[1]))
    if sheared:
        yield Hypothesis("shear_sign", (p, -q), mend=lambda found: (found[0], -found[1]))
        yield Hypothesis("swapped", (q, p), mend=lambda found: (found[1], found[0]))
        yield Hypothesis("frictionless", (p, np.zeros_like(q)))
    k = what.product(what.found, what.expected) / what.product(what.expected, what.expected)
    if k > 0 and abs(k - 1) >= LEAST_FACTOR:
        order = round(np.log10(k))
        off = abs(k / 10.0**order - 1)
        unit = order != 0 and off < (NEAR_OF_UNITS if abs(order) >= 2 else NEAR)
        factor = 10.0**order if unit and off >= NEAR else k
        yield Hypothesis(
            "units" if unit else "traction_factor",
            (factor * p, factor * q),
            {"factor": 10.0**order if unit else k},
            mend=lambda found: (found[0] / factor, found[1] / factor),
        )
    alone = what.of_pressure
    of_p = alone.product(what.found, what.expected) / alone.product(what.expected, what.expected)
    if sheared and of_p > 0 and abs(of_p - 1) > LEAST_OF_PRESSURE:
        yield Hypothesis("pressure_factor", (of_p * p, q), {"factor": of_p}, mend=lambda found: (found[0] / of_p, found[1]))


# ----------------------------------------------------------------------------------------------------- faults of the question
def theory(what: Discrepancy, scene: Scene, time: Array | None = None, *, offset: float = 0.0) -> Tractions:
    """p and q of half-plane theory for another scene, at other times (in any order), or with its centre at x = offset.

    Where what is expected is not half-plane theory of the present scene, what the two differ by is added: the fault is then what
    the change of the scene changes.
    """
    times, places = np.unique(what.time if time is None else time, return_inverse=True)
    found = semi_analytic.solve(scene, x=what.x - offset, time=times, fields=("pressure", "shear"))
    p0, q0 = what.beyond_theory
    return found.pressure[places] + p0, found.shear[places] + q0


def stiffer(scene: Scene, factor: float) -> Scene:
    """E* times `factor`."""
    upper, lower = (body.vary(young_modulus=factor * body.young_modulus) for body in (scene.material.upper, scene.material.lower))
    return scene.vary(material=Materials(upper=upper, lower=lower))


def with_friction(scene: Scene, coefficient: float) -> Scene:
    """The scene with another f."""
    return scene.vary(friction=coefficient)


def question_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Every fault of the question that the discrepancy may have."""
    scene, path = what.scene, what.scene.load.path()
    load = np.asarray(path.at(what.time)[0])[:, None]

    def pressed(scene: Scene, offset: float = 0.0) -> Tractions:
        """The pressure alone, which has no history."""
        if what.comparison.turned:
            p = semi_analytic.solve(scene, x=what.x - offset, time=what.time, fields="pressure").pressure
        else:
            p = contact_of(scene.profile, scene.material).pressure(what.x - offset, load)
        return p + what.beyond_theory[0], what.expected[1]

    # E*/R times m: tractions know no more, since the gap scales with 1/R and the displacements with 1/E*. Loads k times too large
    # are the same with m = 1/k and every traction times k, by linearity: their resultants are k times too large.
    tries = tuple(np.log([0.2, 0.5, 0.75, 0.9, 0.97, 1.0, 1.03, 1.1, 1.33, 2.0, 5.0]))
    if fit := fitted(what.of_pressure, lambda m: pressed(stiffer(scene, np.exp(m))), tries, **FINELY):
        m = float(np.exp(fit[0]))
        yield from _possible("stiffness", lambda: theory(what, stiffer(scene, m)), {"factor": m}, stiffer(scene, m))

    def loaded(solved: Callable[[Scene], Tractions], k: float) -> Tractions:
        p, q = solved(stiffer(scene, 1 / k))
        return k * p, k * q

    if fit := fitted(what.of_pressure, lambda k: loaded(pressed, np.exp(k)), tries, **FINELY):
        k = float(np.exp(fit[0]))
        half = min(abs(k / 2 - 1), abs(2 * k - 1)) < 0.03
        yield from _possible("half_model" if half else "loads", lambda: loaded(lambda scene: theory(what, scene), k), {"factor": k})
    # p(x - d), q(x - d); d is looked for around what the centroid of the pressure has moved by.
    half_width = what.comparison.scales.half_width
    total = [float(np.sum(what.weight * p)) for p in (what.found[0], what.expected[0])]
    moments = [float(np.sum(what.weight * p * what.x)) for p in (what.found[0], what.expected[0])]
    centres = [moment / sum_ if sum_ > 0 else 0.0 for moment, sum_ in zip(moments, total, strict=True)]
    centre = float(np.clip(centres[0] - centres[1], -2 * half_width, 2 * half_width))
    tries = tuple(centre + half_width * step for step in (-0.1, -0.02, 0.0, 0.02, 0.1))
    fit = fitted(what.of_pressure, lambda d: pressed(scene, d), tries, **FINELY)
    if fit and abs(d := fit[0]) > 1e-4 * half_width:
        yield from _possible("offset", lambda: theory(what, scene, offset=d), {"distance": d / half_width})
    yield from _bulk_faults(what)
    if scene.friction.coefficient and np.any(what.expected[1]):
        yield from _history_faults(what)
    if path.period is not None and len(what.rows) >= 4:  # so much of a period late
        start, period = path.cycle_start + 2 * path.period, path.period
        tries = tuple(np.linspace(-0.5, 0.5, 21))

        def late(delay: float) -> Tractions:
            return theory(what, scene, start + np.mod(what.fraction - delay, 1.0) * period)

        fit = fitted(what, late, tries, close=1e-5)
        if fit and abs(fit[0]) > 1e-3:
            yield Hypothesis("other_times", fit[1], {"delay": fit[0]})


def _bulk_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Bulk stress, or tilt, of the other sign; left out."""
    scene = what.scene
    for name, keys in (("bulk", ("bulk_stress_lower", "bulk_stress_upper")), ("tilt", ("tilt", "moment", "line_of_action"))):
        stated = {key: value for key in keys if (value := getattr(scene.load, key)) is not None}
        if not stated:
            continue
        for fault, changes in (
            (f"{name}_sign", {key: turned(value) for key, value in stated.items()}),
            (f"{name}_left_out", dict.fromkeys(stated)),
        ):
            with contextlib.suppress(InputError):
                other = scene.vary(load=changes)
                yield from _possible(fault, lambda other=other: theory(what, other), {}, other)  # type: ignore[misc]


def turned(value: Any) -> Any:
    """A bulk stress, tilt or moment of the other sign, in the form that it was stated in.

    >>> turned(0.5), turned((0.0, 2.0)), turned(LineOfAction(x=1.0, height=3.0))
    (-0.5, (-0.0, -2.0), LineOfAction(x=-1.0, height=-3.0))
    """
    match value:
        case Wave():
            phase = value.phase_degrees + (180 if value.phase_degrees <= 0 else -180)
            return value.vary(mean=-value.mean, phase_degrees=phase, initial_loading=turned(value.initial_loading))
        case WaveSum():
            waves = tuple((amplitude, phase + 180) for amplitude, phase in value.harmonics)
            return value.vary(mean=-value.mean, harmonics=waves, initial_loading=turned(value.initial_loading))
        case LineOfAction():
            return value.vary(x=-value.x, height=-value.height)
        case tuple():
            return tuple(-one for one in value)
        case _ if callable(value):
            return lambda time: -value(time)
    return -value


def _possible(
    fault: str, predict: Callable[[], Tractions], figures: Mapping[str, float], scene: Scene | None = None
) -> Iterator[Hypothesis]:
    """The hypothesis, if the question with the fault has an answer: gross sliding and separation have none."""
    with contextlib.suppress(InputError):
        yield Hypothesis(fault, predict(), figures, scene=scene)


def _history_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Another f; nothing slips; no memory; not yet steady; steps too long."""
    scene, path, f = what.scene, what.scene.load.path(), what.scene.friction.coefficient
    tries = tuple(np.log([0.4, 0.7, 0.9, 1.0, 1.1, 1.4, 2.0, 4.0]))

    def of_friction(factor: float) -> Tractions:
        return theory(what, with_friction(scene, f * np.exp(factor)))

    if fit := fitted(what, of_friction, tries):
        factor = float(np.exp(fit[0]))
        yield Hypothesis("friction", fit[1], {"factor": factor}, scene=with_friction(scene, f * factor))
    if fit := fitted(what, of_friction, tuple(np.log(NO_SLIP))):
        yield Hypothesis("full_stick", fit[1])
    # Cattaneo's first loading at every instant: q = sign(Q) f [p(x, P) - p(x, P - |Q|/f)].
    normal, tangential = (np.asarray(load)[:, None] for load in path.at(what.time))
    stuck = normal - np.abs(tangential) / f
    if np.all(stuck > 0) and not what.unsymmetric:
        contact = contact_of(scene.profile, scene.material)
        shear = np.sign(tangential) * f * (contact.pressure(what.x, normal) - contact.pressure(what.x, stuck))
        yield Hypothesis("memoryless", (what.expected[0], shear))
    if path.period is not None:
        time = path.cycle_start + np.minimum(what.fraction, 1 - 1e-12) * path.period
        yield Hypothesis("not_steady", theory(what, scene, time))
    yield from _polygon(what)
    yield from _implicit(what)


def _polygon(what: Discrepancy) -> Iterator[Hypothesis]:
    """The straight lines between the result's instants, in place of the path."""
    comparison = what.comparison
    if not isinstance(comparison.scene.load, EllipseLoad):
        return
    polygon = comparison.polygon_reference
    if polygon is None or len(polygon.x) != len(what.x):
        try:
            polygon = semi_analytic.solve(comparison.scene, x=what.x, time=comparison.result.time, straight_steps=True)
        except InputError:  # which not every bulk stress and tilt has
            return
    rows = polygon.last_cycle
    if len(rows) == len(comparison.found.time):
        pairs = zip((polygon.pressure, polygon.shear), (comparison.expected.pressure, comparison.expected.shear), strict=True)
        p, q = (mine[rows[what.rows]] - base[what.rows] for mine, base in pairs)
        yield Hypothesis("steps", (what.expected[0] + p, what.expected[1] + q), {"steps": float(len(rows) - 1)})


def _implicit(what: Discrepancy) -> Iterator[Hypothesis]:
    """The result's increments as a solver takes them whose law holds at their ends, exactly, in place of the path.

    While P rises such an increment is that of P first and then that of Q at the new pressure; while P falls it is a straight line.
    Finite elements in steps that end on no event follow it to 0.983 of the discrepancy at 48 steps a cycle, to 0.9999 at 4.
    """
    path, own, whole = what.scene.load.path(), what.comparison.found, what.comparison.result.time
    if path.period is None or what.unsymmetric or len(own.time) - 1 > MOST_STEPS:
        return
    times, wanted = whole[whole <= own.time[-1]], what.time
    if whole[0] > path.cycle_start:  # the cycle alone: twice, after the initial loading
        cycles = [path.cycle_start + (turn + own.fraction) * path.period for turn in (0, 1)]
        times = np.concatenate([np.linspace(path.start, path.cycle_start, 9), *cycles])
        wanted = path.cycle_start + (1 + what.fraction) * path.period
    times = np.unique(times[times > path.start])
    points, ends, least = [(0.0, 0.0)], [], SAME_LOAD * float(np.max(path.at(times)[0]))
    for normal, tangential in np.transpose(path.at(times)).tolist():
        rises = normal > points[-1][0]
        for point in ((normal, points[-1][1]), (normal, tangential)) if rises else ((normal, tangential),):
            if max(abs(point[0] - points[-1][0]), abs(point[1] - points[-1][1])) > least:
                points.append(point)
        ends.append(float(len(points) - 1))  # a polygon takes one unit of time a leg
    with contextlib.suppress(InputError):
        scene = what.scene.vary(load=PolygonLoad(initial_loading=tuple(points[1:])))
        at = np.array(ends)[np.abs(times[:, None] - wanted).argmin(axis=0)]
        yield Hypothesis("steps", theory(what, scene, at), {"steps": float(len(own.time) - 1)})


# ----------------------------------------------------------------------------------------- faults told by where they lie
def unlike_bodies(what: Discrepancy) -> Iterator[Hypothesis]:
    """The odd part of the discrepancy in x: of p and q of like, symmetric bodies there is none, whatever else is wrong.

    It is 0.73 to 0.99 of what unlike materials change, and 0 of every other fault of a model (measured on the planted faults).
    """
    if what.scene.friction.coefficient and np.any(what.found[1]) and not what.unsymmetric:
        off = [found - expected for found, expected in zip(what.found, what.expected, strict=True)]
        p, q = ((one - np.array([np.interp(-what.x, what.x, row) for row in one])) / 2 for one in off)
        yield Hypothesis("coupling", (what.expected[0] + p, what.expected[1] + q))


def coarse_edge(what: Discrepancy) -> Hypothesis:
    """The part of the discrepancy within two spacings of an edge, as far as the spacing can account for its size.

    An elastic traction leaves the edge of contact as (1 - x/a)^(1/2), and q the stick edge likewise. Interpolated on elements of
    length h its error is of the order of p_ref sqrt(2 h/a) over the element with the edge. What goes beyond that is not the mesh's.
    The edges are those of the instant, and those of the smallest stick zone: what a mesh gets wrong there stays locked in.
    """
    x, half = what.x, what.comparison.scales.half_width
    steps = np.diff(x)
    spacing = np.maximum(np.append(steps, steps[-1]), np.insert(steps, 0, steps[0]))
    cycle = what.comparison.expected
    near = np.zeros(what.expected[0].shape, dtype=bool)
    for edges in (cycle.contact_edges[what.rows], cycle.stick_edges[what.rows]):
        for side in (0, 1):
            with np.errstate(invalid="ignore"):
                near |= np.abs(x - edges[:, side][:, None]) <= REACH * spacing
    if what.unsymmetric and np.isfinite(cycle.stick_edges).any():
        for innermost in (np.nanmax(cycle.stick_edges[:, 0]), np.nanmin(cycle.stick_edges[:, 1])):
            near |= np.abs(x - innermost) <= REACH * spacing
    elif np.isfinite(cycle.stick_edges).any():
        near |= np.abs(np.abs(x) - np.nanmin(np.abs(cycle.stick_edges))) <= REACH * spacing
    root = np.sqrt(2 * spacing / half)
    parts = []
    units = what.comparison.scales.pressure, what.comparison.scales.shear
    for found, expected, unit, most in zip(what.found, what.expected, units, MOST, strict=True):
        off = np.clip(found - expected, -most * root * unit, most * root * unit)
        parts.append(expected + np.where(near, off, 0.0))
    edge = float(np.median(spacing[near.any(axis=0)])) / half if near.any() else float("nan")
    return Hypothesis("coarse_edge", (parts[0], parts[1]), {"spacing": edge})
