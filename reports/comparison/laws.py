"""What needs no second solution: the laws of contact that an answer obeys, and the numbers that its
scene expects.

Laws have two sources: what can be read off the fields of any ContactSolution (tension, cone,
loads), and what only the engine could see while it solved (equilibrium in its own weights,
penetration, energy balance), which it wrote in its record.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from reports.comparison.cycles import last_cycle
from reports.comparison.dimensionless import energy_scale
from reports.comparison.pairs import name_of
from reports.comparison.verdicts import Verdict, verdict_on
from reports.comparison.work_of_loads import bulk_work
from reports.python_numbers import PythonNumbers
from reports.units import minus
from scenes import SLIP_FORWARD, SLIP_REVERSE, ContactSolution, Expected, Scene
from scenes.array_types import Array
from scenes.segments import largest_ratio_of

# Algebra in double precision over some hundred steps leaves 1e-12 to 1e-10; a law that is broken
# shows above 1e-6.
_LIMIT = 1e-9
# Of a foreign result: what a file of four printed digits leaves of a law that its code kept to
# rounding.
_PRINTED = 1e-3
# Of theory corrected by what bodies add: paths of straight steps keep the laws at their ends.
_BY_STEPS = 1e-6
# Name of what was worked out from other fields of a foreign result -> nothing is checked with it
# that only repeats how.
DERIVED = "derived"


@dataclass(frozen=True, eq=False)
class Certificate(PythonNumbers):
    """One law, checked at every instant of the whole path.

    Attributes
    ----------
    name, source
        what was checked, and "fields" or "record"
    series
        (n_steps,), dimensionless violation, 0 is perfect
    value, time
        its largest value and when
    limit
        largest admitted value
    """

    name: str
    source: str
    series: Array
    value: float
    time: float
    limit: float = _LIMIT

    @property
    def label(self) -> str:
        """The law with its source, "fields" or "record": one law may be seen in both."""
        return f"{self.name} ({self.source})"

    @property
    def holds(self) -> bool:
        """Whether the law is obeyed; a NaN does not hold."""
        return bool(self.value <= self.limit)


def derived(solution: ContactSolution) -> frozenset[str]:
    """Names of the fields that were worked out from others."""
    return frozenset(solution.settings.get(DERIVED, ()))


def is_corrected(solution: ContactSolution) -> bool:
    """Whether it is theory with what finite bodies add to half-planes."""
    return "effects" in solution.settings


def certificates(solution: ContactSolution) -> tuple[Certificate, ...]:
    """How far a solution violates each law of contact (no tension, |q| <= f p, slip with the shear,
    equilibrium), from its fields and from its record, with the limit admitted.

    Of an external result only those laws are checked that rest on fields of its own, with the limit
    that printed digits allow. Theory corrected by responses of finite bodies has the limit of its
    straight load steps.
    """
    violations_in_fields = {"tension": _tension(solution)}
    if not np.isnan(solution.shear).all():
        violations_in_fields["cone"] = _cone(solution)  # |q| <= f p
    # states that were derived from the tractions obey the law by construction; loads likewise
    if "state" not in derived(solution):
        violations_in_fields["slip"] = _slip(solution)
    if "normal_load" not in derived(solution):
        violations_in_fields["loads"] = _loads(solution)
    limit = _LIMIT
    if derived(solution):
        limit = _PRINTED
    elif is_corrected(solution):
        limit = _BY_STEPS
    sources = (("fields", violations_in_fields), ("record", solution.record.certificates))
    return tuple(
        _certificate(name, source, np.abs(np.asarray(series, dtype=float)), solution.time, limit)
        for source, residuals in sources
        for name, series in residuals.items()
    )


def _certificate(name: str, source: str, series: Array, time: Array, limit: float) -> Certificate:
    """The check of a law, judged at the instant of its largest residual."""
    worst_step = int(np.argmax(np.where(np.isnan(series), np.inf, series)))
    return Certificate(
        name.replace("_", " "),
        source,
        series,
        float(series[worst_step]),
        float(time[worst_step]),
        limit,
    )


def _tension(solution: ContactSolution) -> Array:
    """max(-p) over the largest pressure of the path, (n_steps,)."""
    return np.maximum(-solution.pressure.min(axis=1), 0.0) / _largest_pressure(solution)


def _cone(solution: ContactSolution) -> Array:
    """max(|q| - f p) over f times the largest pressure (over the pressure itself where f = 0),
    (n_steps,).
    """
    friction = solution.scene.friction.coefficient
    excess = np.max(np.abs(solution.shear) - friction * solution.pressure, axis=1)
    return np.maximum(excess, 0.0) / ((friction or 1.0) * _largest_pressure(solution))


def _slip(solution: ContactSolution) -> Array:
    """Violation of Coulomb's law in slip, (n_steps,): the largest |q − f p| of points in forward
    slip, and |q + f p| in reverse slip, over f times the largest pressure.
    """
    friction = solution.scene.friction.coefficient
    slip_direction = (solution.state == SLIP_FORWARD) * 1.0 - (solution.state == SLIP_REVERSE)
    violation = np.max(
        np.abs(slip_direction * solution.shear - friction * solution.pressure),
        axis=1,
        where=slip_direction != 0,
        initial=0.0,
    )
    return np.asarray(violation / ((friction or 1.0) * _largest_pressure(solution)))


def _loads(solution: ContactSolution) -> Array:
    """Largest of |P - P(t)| and |Q - Q(t)| over the largest P, P(t) and Q(t) being the scene's,
    (n_steps,).
    """
    normal_load, tangential_load = solution.scene.load.path().at(solution.time)
    off = np.maximum(
        np.abs(solution.normal_load - normal_load),
        np.abs(solution.tangential_load - tangential_load),
    )
    return np.asarray(off / np.max(normal_load))


def _largest_pressure(solution: ContactSolution) -> float:
    return float(np.max(solution.pressure)) or 1.0


# --------------------------------------------------------------------------------- expected numbers
@dataclass(frozen=True)
class Finding(PythonNumbers):
    """An expected number and what was found in its place."""

    expected: Expected  # the number, its tolerance, engine and source
    found: float  # the engine's own; NaN where it has no such thing
    difference: float  # found less expected, in the measure of the tolerance

    @property
    def met(self) -> bool:
        """Whether the difference lies within the tolerance; a NaN never does."""
        return verdict_on(self.difference, self.expected.tolerance) is Verdict.WITHIN


def _lower_face_displacement(solution: ContactSolution) -> float:
    """At the largest load; NaN for a half-plane, whose displacement has no datum."""
    from halfplane_fe import FiniteElementSolution, fields

    if (
        not isinstance(solution, FiniteElementSolution)
        or solution.scene.bodies.lower.kind == "half_plane"
    ):
        return math.nan
    lower_body = fields(solution, [solution.time[_when_largest(solution)]])[0].bodies[0]
    return float(lower_body.displacement[np.argmin(np.hypot(*lower_body.points.T)), 1])


def _when_largest(solution: ContactSolution) -> int:
    """The step of the last cycle with the largest P."""
    return int(solution.last_cycle[np.argmax(solution.normal_load[solution.last_cycle])])


def _largest_half_width(solution: ContactSolution) -> float:
    """Largest half-width of the contact in the last cycle [length]."""
    return float(np.nanmax(solution.contact_half_width[solution.last_cycle]))


def _stick_edges(solution: ContactSolution) -> list[float]:
    """Ends of what sticks through the whole last cycle [length]; NaN if nothing does."""
    edges = solution.permanent_stick_edges
    return [math.nan, math.nan] if edges is None else [float(edge) for edge in edges]


def _moment(solution: ContactSolution) -> float:
    """At the largest load."""
    return math.nan if solution.moment is None else float(solution.moment[_when_largest(solution)])


def _bulk_work(solution: ContactSolution) -> float:
    """-closed integral of m_q d(eps) by the trapezoidal rule over the instants, the part of
    `loop_work` that is the bulk term.
    """
    if "whole_cycle" in solution.work.skipped or len(solution.last_cycle) < 2:
        return math.nan
    return bulk_work(last_cycle(solution), solution.scene.material)


@dataclass(frozen=True)
class _Quantity:
    """A number of a solution's last cycle: its words, its kind ("energy", "length", "stress",
    "moment", "share"), its function.
    """

    words: str
    kind: str
    of: Callable[[ContactSolution], float]


# In the scene's units; NaN where there is no such thing. Pressures are those at the solution's own
# points. A scene may expect each.
QUANTITIES = {
    "dissipation": _Quantity(
        "dissipation of the last cycle", "energy", lambda s: float(s.dissipation)
    ),
    "loop_work": _Quantity("closed integral of Q dU", "energy", lambda s: float(s.loop_work)),
    "bulk_work": _Quantity(
        "of it by bulk stress, −closed integral of m_q dε", "energy", _bulk_work
    ),
    "permanent_stick_half_width": _Quantity(
        "permanent stick half-width", "length", attrgetter("permanent_stick_half_width")
    ),
    "permanent_stick_left": _Quantity(
        "left end of permanent stick", "length", lambda s: _stick_edges(s)[0]
    ),
    "permanent_stick_right": _Quantity(
        "right end of permanent stick", "length", lambda s: _stick_edges(s)[1]
    ),
    "largest_half_width": _Quantity("largest contact half-width", "length", _largest_half_width),
    "largest_pressure": _Quantity(
        "largest pressure at the points",
        "stress",
        lambda s: float(np.max(s.pressure[s.last_cycle])),
    ),
    "stick_centre": _Quantity(
        "middle of the permanent stick zone", "length", lambda s: float(np.mean(_stick_edges(s)))
    ),
    "contact_left": _Quantity(
        "left edge of the contact",
        "length",
        lambda s: float(np.nanmin(s.contact_edges[s.last_cycle, 0])),
    ),
    "contact_right": _Quantity(
        "right edge of the contact",
        "length",
        lambda s: float(np.nanmax(s.contact_edges[s.last_cycle, 1])),
    ),
    "moment": _Quantity("moment of the pressure about x = 0", "moment", _moment),
    "lower_face_displacement": _Quantity(
        "displacement of the lower face's middle along y", "length", _lower_face_displacement
    ),
    "least_half_width": _Quantity(
        "least half-width", "length", lambda s: float(np.nanmin(s.contact_half_width[s.last_cycle]))
    ),
    "stick_share": _Quantity(
        "stick half-width over largest",
        "share",
        lambda s: s.permanent_stick_half_width / _largest_half_width(s),
    ),
}
# What solutions with bulk stress, tilt or unequal sides have beside the others.
OF_UNSYMMETRIC = ("bulk_work", "permanent_stick_left", "permanent_stick_right")


def of_unsymmetric(solution: ContactSolution) -> dict[str, float]:
    """Further values, by name, of a solution with bulk stress, tilt or unequal sides; empty without
    these.
    """
    if solution.permanent_stick_edges is None:
        return {}
    return {key: QUANTITIES[key].of(solution) for key in OF_UNSYMMETRIC}


def _scale(expected: Expected, solution: ContactSolution) -> float:
    """What the tolerance of an expected number is relative to: the number, or where that is 0 the
    scale of its kind.
    """
    if expected.value:
        return abs(expected.value)
    match QUANTITIES[expected.quantity].kind:
        case "energy":
            return energy_scale(
                solution.scene, float(solution.normal_load[solution.last_cycle].max())
            )
        case "stress":
            return float(np.max(solution.pressure))
        case "share":
            return 1.0
    return _largest_half_width(solution)


def ratio_of_answer(solution: ContactSolution) -> float:
    """Largest |Q|/(f P) of the last cycle of an answer, whose loads may follow from displacements;
    NaN without friction.
    """
    friction = solution.scene.friction.coefficient
    if not friction:
        return math.nan
    rows = solution.last_cycle
    return largest_ratio_of(solution.normal_load[rows], solution.tangential_load[rows]) / friction


def expected_numbers(scene: Scene, solutions: Iterable[ContactSolution]) -> Iterator[Finding]:
    """The numbers that a scene states as expected of theory or finite elements, each with what
    `solutions` have instead, in the scene's order. None is expected of theory corrected by
    responses of finite bodies.
    """
    solution_by_engine = {
        name_of(solution.engine): solution for solution in solutions if not is_corrected(solution)
    }
    for expected in scene.expected:
        if expected.engine in solution_by_engine:
            solution = solution_by_engine[expected.engine]
            value = QUANTITIES[expected.quantity].of(solution)
            yield Finding(expected, value, (value - expected.value) / _scale(expected, solution))


def expected_rows(findings: Iterable[Finding]) -> list[tuple[str, ...]]:
    """Cells of the table of expected numbers that the terminal shows: quantity, engine, expected,
    found, difference, tolerance, whether it is met.
    """
    return [
        (
            finding.expected.quantity.replace("_", " "),
            finding.expected.engine,
            f"{finding.expected.value:.5g}",
            "none" if math.isnan(finding.found) else f"{finding.found:.5g}",
            "–" if math.isnan(finding.difference) else minus(f"{finding.difference:+.1e}"),
            f"{finding.expected.tolerance:.3g}",
            "yes" if finding.met else "no",
        )
        for finding in findings
    ]


EXPECTED_HEADS = ("quantity", "engine", "expected", "found", "off", "limit", "met")


def expected_content(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    """The expected numbers of a scene with what was found in their place, for JSON."""
    return [
        {
            **finding.expected.model_dump(mode="json"),
            "found": finding.found,
            "difference": finding.difference,
            "met": finding.met,
        }
        for finding in findings
    ]
