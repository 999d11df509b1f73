"""Tractions that belong to a problem the suite does not solve, where the rows of a result show it.

Each problem has a signature of its own in the rows: a closed form of a textbook, its sizes fitted
at each instant, or a feature that no elastic contact of smooth faces has. It is judged as a cause
is: it must leave less than a third of the difference, not by chance, and so much less than a cause
of the suite that the file tells both apart.

# notation: p pressure, q shear, f friction coefficient, P and Q loads, a and c half-widths of
contact and stick, xi = x/a, p0 largest pressure of an ellipse
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, Mask, Residual, Tractions
from reports.scoring.fits import CHANCE, MOST_LEFT, Fit, are_apart, gain_by_chance, share_of_norm
from reports.scoring.traces import WORDS, Diagnosis
from scenes import SLIP_FORWARD, SLIP_REVERSE, Hertz
from scenes.array_types import Array
from semi_analytic.profiles import contact_of

# Over the outermost point that carries, the half-widths that are tried: a singular traction ends
# within a spacing of it.
_EDGES_TRIED = 60
# Of the largest pressure, a tension that extrapolation beyond an edge does not make; and points in
# tension on each side, one of which a mesh makes.
_TENSION = 0.05
_FEWEST_IN_TENSION = 2
# Of the largest pressure of an instant, below which a point is open; above which it is well inside
# the contact of the reference.
_OPEN = 1e-3
_WELL_INSIDE = 0.2
# Points of a gap between two zones of contact, gaps, and the share of P that the reference carries
# over them: one point may be a corner node, one gap a hole in the table.
_FEWEST_IN_GAP = 2
_FEWEST_GAPS = 2
_LEAST_OVER_GAPS = 0.1
# Over P, by which the sum of the pressures of another problem may differ from it.
_BALANCED = 0.1
# Points of an instant on which a pressure is at its limit; how far elastic theory exceeds it there.
_FEWEST_ON_LIMIT = 5
_ABOVE_LIMIT = 1.1
# Loads over P of the elastic pressure that a limit is put on: a contact with a limit is wider.
_WIDER = np.linspace(1.0, 2.5, 31)
# Of f p_ref, the constant of a law of friction that is no coefficient; points in slip that show it;
# what the law may leave of the shear that is not proportional to p.
_LEAST_CONSTANT = 0.05
_FEWEST_IN_SLIP = 8
_LEFT_OF_LAW = 0.1
# Slope of the pressure of a sphere over its half-width, over that of a cylinder: p0/a = 2 E*/(pi R)
# and E*/(2 R).
_SPHERE = 4 / np.pi
# Over P and over the pressure, by which two instants of one load may differ; of the pressure, what
# differs between them where the bodies are not elastic.
_SAME_LOAD = 0.01
_OTHER_PRESSURE = 0.05
# Of the square of that difference, what may change from point to point, and values that show it:
# of noise all does, but for 0.22 of it where 20 values and their mirror images are known.
_SMOOTH = 0.2
_FEWEST_SMOOTH = 40


@dataclass(frozen=True, eq=False)
class Shown:
    """What a problem makes of a result.

    Attributes
    ----------
    predicted
        tractions of the problem, its sizes fitted; those of the reference where it says nothing
    before
        tractions that it must do better than: the reference's, or those of the best cause that it
        could be taken for
    parameters
        sizes that were fitted beyond those of `before`
    where
        (k, n) points on which it is judged
    figures
        numbers of its sentence
    evidence
        measured values, in words
    """

    predicted: Tractions
    before: Tractions
    parameters: int
    where: Mask
    figures: dict[str, float | str] = field(default_factory=dict)
    evidence: tuple[str, ...] = ()


@dataclass(frozen=True)
class OtherProblem:
    """A problem that the suite does not solve.

    Attributes
    ----------
    key
        of its sentence in templates/faults.toml
    channel
        0 where the pressure shows it, 1 where the shear does
    shown
        what it makes of a result; None where the result does not have its signature
    """

    key: str
    channel: int
    shown: Callable[[Discrepancy], Shown | None]

    def residual(self, discrepancy: Discrepancy, tractions: Tractions, shown: Shown) -> Residual:
        """What tractions leave where the problem is judged."""
        whole = discrepancy.residual(tractions, self.channel)
        return replace(whole, inside=shown.where & (discrepancy.weight > 0))


# ------------------------------------------------------------------------- closed forms of pressure
def _in_contact(discrepancy: Discrepancy, pressure: Array) -> Mask:
    """(k, n) points that carry in the result, in the reference or in a problem."""
    predicted = _with(discrepancy, PRESSURE, pressure)
    return discrepancy.in_contact(predicted) | discrepancy.in_contact(discrepancy.expected)


def _with(discrepancy: Discrepancy, channel: int, traction: Array) -> Tractions:
    """The tractions expected with another pressure or shear."""
    tractions = discrepancy.expected.copy()
    tractions[channel] = traction
    return tractions


def _carrying(discrepancy: Discrepancy) -> Mask:
    """(k, n) points with a pressure or a tension in the result."""
    size = np.abs(discrepancy.found[PRESSURE])
    return np.asarray(size > _OPEN * size.max(axis=1, keepdims=True))


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """A sum of functions of xi, fitted to the pressure of each instant.

    Attributes
    ----------
    pressure
        (k, n) [stress]
    factors
        (k, number of functions) [stress]
    half_widths
        (k,) [length]
    """

    pressure: Array
    factors: Array
    half_widths: Array


def _closed_form(
    discrepancy: Discrepancy, functions: Callable[[Array], Array]
) -> ClosedForm | None:
    """The sum of functions of xi that leaves least of the pressure at each instant; None where a
    factor is negative, or fewer than three points carry.

    Parameters
    ----------
    functions
        xi (m,), |xi| < 1 -> (m, number of functions)
    """
    rows = []
    for pressure, carrying, weight in zip(
        discrepancy.found[PRESSURE], _carrying(discrepancy), discrepancy.weight, strict=True
    ):
        if carrying.sum() < 3:
            return None
        row = _fitted_row(discrepancy.x, pressure, carrying, weight, functions)
        if np.any(row[1] <= 0):
            return None
        rows.append(row)
    fields, factors, half_widths = zip(*rows, strict=True)
    return ClosedForm(np.array(fields), np.array(factors), np.array(half_widths))


def _fitted_row(
    x: Array, pressure: Array, carrying: Mask, weight: Array, functions: Callable[[Array], Array]
) -> tuple[Array, Array, float]:
    """Pressure, factors and half-width of one instant.

    The centre is the middle of what carries. Half-widths are tried from the outermost point that
    carries to a spacing beyond it; the functions are linear in their factors.
    """
    places = np.flatnonzero(carrying)
    first, last = places[0], places[-1]
    centre = (x[first] + x[last]) / 2
    outermost = (x[last] - x[first]) / 2
    before = x[first] - x[max(first - 1, 0)]
    after = x[min(last + 1, len(x) - 1)] - x[last]
    spacing = max(before, after, np.diff(x).min())
    root = np.sqrt(weight)
    least = np.inf
    for share in (np.arange(_EDGES_TRIED) + 0.5) / _EDGES_TRIED:
        half_width = float(outermost + share * spacing)
        xi = (x - centre) / half_width
        inside = np.abs(xi) < 1
        columns = np.zeros((len(x), functions(np.zeros(1)).shape[1]))
        columns[inside] = functions(xi[inside])
        solution = np.linalg.lstsq(root[:, None] * columns, root * pressure, rcond=None)
        factors: Array = np.asarray(solution[0], dtype=np.float64)
        fitted: Array = columns @ factors
        square = float(np.sum(weight * (pressure - fitted) ** 2))
        if square < least:
            least = square
            best = fitted, factors, half_width
    return best


def _adhesion(discrepancy: Discrepancy) -> Shown | None:
    """p = p0 sqrt(1 - xi^2) - p1/sqrt(1 - xi^2): a strip with adhesion (Johnson 1985, 5.5), in
    tension next to both edges.
    """
    pressure = discrepancy.found[PRESSURE]
    largest = pressure.max(axis=1, keepdims=True)
    tension = pressure < -_OPEN * largest
    deepest = float(np.max(-pressure / np.maximum(largest, 1e-300)))
    if deepest < _TENSION:
        return None
    for row, pulled in zip(pressure, tension, strict=True):
        top = int(np.argmax(row))
        if min(pulled[:top].sum(), pulled[top:].sum()) < _FEWEST_IN_TENSION:
            return None

    def strip(xi: Array) -> Array:
        root = np.sqrt(1 - xi**2)
        return np.column_stack([root, -1 / root])

    fitted = _closed_form(discrepancy, strip)
    if fitted is None:
        return None
    evidence = f"{int(tension.sum())} points are in tension, at both edges of contact"
    return Shown(
        _with(discrepancy, PRESSURE, fitted.pressure),
        discrepancy.expected,
        3 * len(pressure),
        _in_contact(discrepancy, fitted.pressure),
        {"tension": deepest},
        (evidence,),
    )


def _sharp_punch(discrepancy: Discrepancy) -> Shown | None:
    """p = P/(pi a sqrt(1 - xi^2)): a flat punch with sharp corners (Johnson 1985, 2.8), largest at
    the edges.
    """
    fitted = _closed_form(discrepancy, lambda xi: (1 / np.sqrt(1 - xi**2))[:, None])
    if fitted is None:
        return None
    a = float(fitted.half_widths.max())
    narrowest = float(fitted.half_widths.min())
    if narrowest < a - 2 * float(np.diff(discrepancy.x).max()):  # the edges of a punch do not move
        return None
    return Shown(
        _with(discrepancy, PRESSURE, fitted.pressure),
        discrepancy.expected,
        2 * len(fitted.half_widths),
        _in_contact(discrepancy, fitted.pressure),
        {"half_width": a},
    )


def _sphere(discrepancy: Discrepancy) -> Shown | None:
    """p = p0 sqrt(1 - xi^2) with p0/a = 2 E*/(pi R): a sphere, whose P = 2 pi a^2 p0/3 is a force
    (Johnson 1985, 4.2). A cylinder has p0/a = E*/(2 R).
    """
    profile = discrepancy.scene.profile
    if not isinstance(profile, Hertz):
        return None
    fitted = _closed_form(discrepancy, lambda xi: np.sqrt(1 - xi**2)[:, None])
    if fitted is None:
        return None
    scales = discrepancy.comparison.scales
    slope = _SPHERE * scales.pressure / scales.half_width
    xi = discrepancy.x / fitted.half_widths[:, None]
    pressure = slope * fitted.half_widths[:, None] * np.sqrt(np.maximum(1 - xi**2, 0.0))
    force = float(np.max(2 / 3 * np.pi * fitted.half_widths**3 * slope))
    return Shown(
        _with(discrepancy, PRESSURE, pressure),
        discrepancy.expected,
        len(pressure),
        _in_contact(discrepancy, pressure),
        {"force": force},
    )


def _limit_of_pressure(discrepancy: Discrepancy) -> Shown | None:
    """p = min(limit, elastic pressure of a larger load): plastic flow, or wear, flattens the
    middle; the limit is the same at all instants.
    """
    if discrepancy.unsymmetric:
        return None
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    found = discrepancy.found[PRESSURE]
    limit = float(np.median(found[found > 0.9 * found.max()]))
    rows = []
    count = 0
    for pressure, load, weight in zip(
        found, discrepancy.normal_load, discrepancy.weight, strict=True
    ):
        elastic = contact.pressure(discrepancy.x, load * _WIDER[:, None])
        limited = np.minimum(elastic, limit)
        best = int(np.argmin(np.sum(weight * (pressure - limited) ** 2, axis=1)))
        rows.append(limited[best])
        count = max(count, int(np.sum(elastic[best] > _ABOVE_LIMIT * limit)))
    if count < _FEWEST_ON_LIMIT:
        return None
    on_limit = discrepancy.expected[PRESSURE] > limit
    return Shown(
        _with(discrepancy, PRESSURE, np.array(rows)),
        discrepancy.expected,
        len(rows) + 1,
        _in_contact(discrepancy, np.array(rows)),
        {"limit": limit / discrepancy.comparison.scales.pressure},
        (
            f"{count} points of one instant have {limit:.4g}, and no point has more than"
            f" {found.max() / limit:.3g} times that, where the reference exceeds it at"
            f" {int(on_limit.sum())} points",
        ),
    )


# ------------------------------------------------------------------------------- features of rows
def _several_zones(discrepancy: Discrepancy) -> Shown | None:
    """Gaps inside the contact of the reference, whose load the zones between them carry: rough or
    wavy faces. Values that are missing from a table take their share of the load with them.
    """
    found, expected = discrepancy.found[PRESSURE], discrepancy.expected[PRESSURE]
    largest = found.max(axis=1, keepdims=True)
    is_open = (found <= _OPEN * largest) & (
        expected > _WELL_INSIDE * expected.max(axis=1, keepdims=True)
    )
    lengths = [length for row in is_open for length in _lengths_of_runs(row)]
    long_gaps = sum(length >= _FEWEST_IN_GAP for length in lengths)
    share = np.trapezoid(np.where(is_open, expected, 0.0), discrepancy.x, axis=1)
    share = share / np.maximum(np.trapezoid(expected, discrepancy.x, axis=1), 1e-300)
    if (
        long_gaps < _FEWEST_GAPS * len(found)
        or float(share[discrepancy.loaded].min()) < _LEAST_OVER_GAPS
    ):
        return None
    if abs(discrepancy.resultant_ratio - 1) > _BALANCED:
        return None
    # the gaps themselves: open in the result, and nothing else is claimed
    return Shown(
        _with(discrepancy, PRESSURE, np.where(is_open, 0.0, expected)),
        discrepancy.expected,
        1,
        is_open,
        {"gaps": long_gaps / len(found)},
        (
            f"over the gaps the reference carries {float(share.max()):.0%} of P; the sum of the"
            f" pressures is {discrepancy.resultant_ratio:.4g} P all the same",
        ),
    )


def _lengths_of_runs(row: NDArray[np.bool_]) -> list[int]:
    """Lengths of the runs of True.

    >>> _lengths_of_runs(np.array([True, True, False, True]))
    [2, 1]
    """
    ends = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    return [int(end - start) for start, end in ends.reshape(-1, 2)]


def _not_elastic(discrepancy: Discrepancy) -> Shown | None:
    """Two instants with the same P, by the scene and by the sum of the pressures, whose pressures
    differ: of elastic half-planes the pressure depends on P alone.

    What is odd in x is left out: unlike bodies and bodies that tilt make it.
    """
    if discrepancy.unsymmetric or len(discrepancy.rows) < 2:
        return None
    found = discrepancy.found[PRESSURE]
    even = (found + _mirrored(found, discrepancy.x)) / 2
    sums = np.trapezoid(found, discrepancy.x, axis=1)
    size = np.sqrt(np.mean(discrepancy.expected[PRESSURE] ** 2, axis=1))
    largest = (0.0, 0, 0)
    for i in range(len(found)):
        for j in range(i + 1, len(found)):
            same = abs(discrepancy.normal_load[i] / discrepancy.normal_load[j] - 1) < _SAME_LOAD
            balanced = abs(sums[i] / sums[j] - 1) < _SAME_LOAD
            if discrepancy.loaded[i] and discrepancy.loaded[j] and same and balanced:
                change = float(np.sqrt(np.mean((even[i] - even[j]) ** 2)))
                largest = max(largest, (change / float(size[i]), i, j))
    share, i, j = largest
    difference = (even[i] - even[j])[None] / discrepancy.comparison.scales.pressure
    between = Residual(difference, discrepancy.weight[[i]], (even[[i]] != 0) | (even[[j]] != 0))
    is_smooth = between.noise < _SMOOTH * between.square and between.count >= _FEWEST_SMOOTH
    if share < _OTHER_PRESSURE or not is_smooth:
        return None
    # The two instants, each of which the other one would predict.
    before = discrepancy.expected.copy()
    before[PRESSURE, i], before[PRESSURE, j] = even[j], even[i]
    where = np.zeros(found.shape, dtype=bool)
    where[[i, j]] = True
    return Shown(
        _with(discrepancy, PRESSURE, even),
        before,
        1,
        where,
        {"share": share, "first": float(discrepancy.time[i]), "second": float(discrepancy.time[j])},
        (f"the sums of both pressures agree to {abs(sums[i] / sums[j] - 1):.1%}",),
    )


def _mirrored(rows: Array, x: Array) -> Array:
    """Values at -x."""
    return np.array([np.interp(-x, x, row, left=0.0, right=0.0) for row in rows])


# ---------------------------------------------------------------------------------------- the shear
def _rolling(discrepancy: Discrepancy) -> Shown | None:
    """q = f [p(x, P) - p(x -+ (a - c), P - |Q|/f)] with the sign of Q: tractive rolling, whose
    stick zone begins at the leading edge (Carter 1926; Johnson 1985, 8.3).
    """
    friction = discrepancy.scene.friction.coefficient
    if discrepancy.unsymmetric or not friction or not discrepancy.sheared:
        return None
    normal, tangential = (
        np.asarray(load)[:, None] for load in discrepancy.scene.load.path().at(discrepancy.time)
    )
    stuck = normal - np.abs(tangential) / friction
    if np.any(stuck <= 0) or np.all(np.abs(tangential) < 1e-9 * normal):
        return None
    contact = contact_of(discrepancy.scene.profile, discrepancy.scene.material)
    distance = contact.half_width(normal) - contact.half_width(stuck)
    pressure = contact.pressure(discrepancy.x, normal)
    least = np.inf
    for direction in (1.0, -1.0):
        stick = np.array(
            [
                contact.pressure(discrepancy.x - direction * shift, load)
                for shift, load in zip(distance[:, 0], stuck[:, 0], strict=True)
            ]
        )
        shear = np.sign(tangential) * friction * (pressure - stick)
        square = float(np.sum(discrepancy.weight * (discrepancy.found[SHEAR] - shear) ** 2))
        if square < least:
            least = square
            best_shear = shear
            side = "right" if direction > 0 else "left"
    return Shown(
        _with(discrepancy, SHEAR, best_shear),
        discrepancy.expected,
        1,
        discrepancy.in_contact(discrepancy.expected),
        {"side": side},
    )


def _law_of_friction(discrepancy: Discrepancy) -> Shown | None:
    """|q| = constant + slope p where the reference slips: a law that is no coefficient of friction,
    such as a shear strength (slope 0) or cohesion (slope f).
    """
    friction = discrepancy.scene.friction.coefficient
    if not friction or not discrepancy.sheared:
        return None
    state = discrepancy.comparison.expected.state[discrepancy.rows]
    sense = (state == SLIP_FORWARD) * 1.0 - (state == SLIP_REVERSE)
    sense = np.where(sense == 0, 0.0, np.sign(discrepancy.expected[SHEAR]))
    pressure = discrepancy.found[PRESSURE]
    slips = (sense != 0) & (pressure > _OPEN * pressure.max()) & (discrepancy.weight > 0)
    shear = sense * discrepancy.found[SHEAR]
    if slips.sum() < _FEWEST_IN_SLIP:
        return None
    p, q = pressure[slips], shear[slips]
    slope_alone = float(p @ q / (p @ p))
    (constant, slope), *_ = np.linalg.lstsq(np.column_stack([np.ones_like(p), p]), q, rcond=None)
    left_alone = float(np.mean((q - slope_alone * p) ** 2))
    left = float(np.mean((q - constant - slope * p) ** 2))
    scale = discrepancy.comparison.scales.shear
    if constant < _LEAST_CONSTANT * scale or slope < -0.1 * friction:
        return None
    law = np.where(slips, sense * (constant + slope * pressure), discrepancy.expected[SHEAR])
    coefficient = np.where(slips, sense * slope_alone * pressure, discrepancy.expected[SHEAR])
    residual = discrepancy.residual(_with(discrepancy, SHEAR, law), SHEAR)
    noise = min(replace(residual, inside=slips).noise * scale**2, left)
    if left - noise > _LEFT_OF_LAW**2 * (left_alone - noise):
        return None
    return Shown(
        _with(discrepancy, SHEAR, law),
        _with(discrepancy, SHEAR, coefficient),
        1,
        slips,
        {"constant": float(constant), "slope": float(slope)},
        (
            f"{int(slips.sum())} points in slip; no coefficient of friction leaves less than"
            f" {left_alone**0.5 / scale:.2g} of f p_ref of their shear, this law leaves"
            f" {left**0.5 / scale:.2g}",
        ),
    )


PROBLEMS = (
    OtherProblem("several_zones", PRESSURE, _several_zones),
    OtherProblem("adhesion", PRESSURE, _adhesion),
    OtherProblem("sharp_punch", PRESSURE, _sharp_punch),
    OtherProblem("sphere", PRESSURE, _sphere),
    OtherProblem("limit_of_pressure", PRESSURE, _limit_of_pressure),
    OtherProblem("not_elastic", PRESSURE, _not_elastic),
    OtherProblem("rolling", SHEAR, _rolling),
    OtherProblem("law_of_friction", SHEAR, _law_of_friction),
)


def other_problems(discrepancy: Discrepancy, named: Fit | None) -> Iterator[Diagnosis]:
    """The problem that the tractions belong to, where the rows show one and the causes that are
    named leave so much more that they are out.
    """
    # Friction follows the pressure: where that is wrong, the shear shows no problem of its own.
    of_pressure = discrepancy.residual(discrepancy.expected, PRESSURE)
    is_pressure_right = discrepancy.is_within(PRESSURE) or of_pressure.is_noise
    candidates = []
    for problem in PROBLEMS:
        if problem.channel == SHEAR and not is_pressure_right:
            continue
        shown = problem.shown(discrepancy)
        if shown is None:
            continue
        after = problem.residual(discrepancy, shown.predicted, shown)
        before = problem.residual(discrepancy, shown.before, shown)
        noise = min(after.noise, after.square)
        left = share_of_norm(after.square, before.square, noise)
        chance = gain_by_chance(after.square, before.square, after.count, sizes=shown.parameters)
        if left >= MOST_LEFT or chance >= CHANCE:
            continue
        if named is not None:
            of_causes = problem.residual(discrepancy, named.predicted, shown)
            is_apart = are_apart(
                of_causes.square, after.square, after.count, is_noise=after.is_noise
            )
            if not is_apart:
                continue
        candidates.append((left, problem, shown))
    if not candidates:
        return
    left, problem, shown = min(candidates, key=lambda candidate: candidate[0])
    sentence = f"{WORDS['other_problem']} {WORDS['problems'][problem.key].format(**shown.figures)}"
    evidence = (
        *shown.evidence,
        f"tractions of that problem, its sizes fitted, leave {left:.1%} of the difference",
    )
    yield Diagnosis(problem.key, sentence, evidence, 1 - left)
