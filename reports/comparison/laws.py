"""The verdict on an error; and what needs no second solution: the laws of contact that an answer
obeys, and the numbers that its scene expects.

Laws have two sources: what can be read off the fields of any ContactSolution (tension, cone,
loads), and what only the engine could see while it solved (equilibrium in its own weights,
penetration, energy balance), which it wrote in its record.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from operator import attrgetter
from typing import Any

import numpy as np

from reports.comparison.cycles import last_cycle
from reports.comparison.pairs import energy_scale, engine_in_words, is_corrected
from reports.comparison.work_of_loads import bulk_work
from reports.units import PythonNumbers, minus
from scenes import SLIP_FORWARD, SLIP_REVERSE, ContactSolution, Expected, Scene
from scenes.array_types import Array
from scenes.segments import largest_ratio_of

# Algebra in double precision over some hundred steps leaves 1e-12 to 1e-10; a law that is broken
# shows above 1e-6.
_LIMIT_OF_DOUBLES = 1e-9
# Limit for an external result: a file of four printed digits leaves such a violation of a law that
# its code satisfied to round-off.
_LIMIT_OF_PRINTED_DIGITS = 1e-3
# Least limit for the loads of a solution. Half-plane theory takes an instant within 1e-9 of the
# path behind the end of its last cycle as that end: loads that change by a third of the largest P
# differ by 2e-9 of it for each cycle of the path. Times printed with nine digits lie there.
_LEAST_LIMIT_OF_LOADS = 1e-8
# Limit for theory corrected by responses of finite bodies: it satisfies the laws at the ends of its
# straight load steps.
_LIMIT_OF_STRAIGHT_STEPS = 1e-6
# Key in `settings` of an external result: names of the fields that were derived from other fields.
# A law that such a field satisfies by construction is not checked.
DERIVED = "derived"


class Verdict(StrEnum):
    """Whether an error is within a tolerance, by its uncertainty."""

    WITHIN = "within"
    OUTSIDE = "outside"
    UNDECIDED = "undecided"


def verdict_on(error: float, tolerance: float, uncertainty: float | None = None) -> Verdict:
    """Whether the size of an error E lies within `tolerance`, both in one unit.

    Within if |E| + u <= tolerance, outside if |E| - u > tolerance, else undecided. Where no
    uncertainty u is known, |E| alone decides. An error that is not finite is outside; an
    uncertainty that is not finite decides nothing.

    >>> print(verdict_on(-0.016, 0.05), verdict_on(-0.016, 0.05, 0.75), verdict_on(0.9, 0.05, 0.75))
    within undecided outside
    """
    if not math.isfinite(error):
        return Verdict.OUTSIDE
    known_uncertainty = 0.0 if uncertainty is None else uncertainty
    if abs(error) + known_uncertainty <= tolerance:
        return Verdict.WITHIN
    if abs(error) - known_uncertainty > tolerance:
        return Verdict.OUTSIDE
    return Verdict.UNDECIDED


@dataclass(frozen=True, eq=False)
class Certificate(PythonNumbers):
    """One law of contact, checked at every instant of the whole path.

    Attributes
    ----------
    name, source
        the law; "fields" if computed from the fields of the solution, "record" if stated by it
    series
        (n_instants,), dimensionless violation, 0 where the law holds exactly
    value, time
        the largest violation and its instant
    limit
        largest admitted violation
    """

    name: str
    source: str
    series: Array
    value: float
    time: float
    limit: float = _LIMIT_OF_DOUBLES

    @property
    def label(self) -> str:
        """The law with its source, "fields" or "record": one law may be seen in both."""
        return f"{self.name} ({self.source})"

    @property
    def holds(self) -> bool:
        """Whether the law is obeyed; a NaN does not hold."""
        return bool(self.value <= self.limit)


def names_of_derived_fields(solution: ContactSolution) -> frozenset[str]:
    """Names of the fields of an external result that were derived from its other fields."""
    return frozenset(solution.settings.get(DERIVED, ()))


def certificates(solution: ContactSolution) -> tuple[Certificate, ...]:
    """How far a solution violates each law of contact, with the largest admitted violation.

    From its fields: no tension, |q| <= f p ("cone"; left out where the solution has no shear), slip
    along the shear, loads as in the scene. From its record: the residuals that the engine reports.
    For an external result a law is left out if the fields were derived from it; loads are checked
    if its file has P or Q. A certificate holds the violation of one law at every instant, the
    largest, its instant, and the largest admitted one.

    The largest admitted violation is 1e-9; for loads 1e-7, for printed digits of an external result
    1e-3, and for straight load steps of theory corrected by responses of finite bodies 1e-6. A
    violation is (n_instants,), dimensionless.
    """
    violations_in_fields = {"tension": _violation_by_tension(solution)}
    if not np.isnan(solution.shear).all():
        violations_in_fields["cone"] = _violation_of_coulomb_limit(solution)
    derived_fields = names_of_derived_fields(solution)
    # stick and slip states that were derived from the tractions obey the law by construction;
    # loads that are the scene's likewise
    if "state" not in derived_fields:
        violations_in_fields["slip"] = _violation_in_slip(solution)
    if not derived_fields >= {"normal_load", "tangential_load"}:
        violations_in_fields["loads"] = _difference_of_loads(solution)
    # 1e-9 for double precision, 1e-3 for printed digits, 1e-6 for straight load steps
    admitted_violation = _LIMIT_OF_DOUBLES
    if derived_fields:
        admitted_violation = _LIMIT_OF_PRINTED_DIGITS
    elif is_corrected(solution):
        admitted_violation = _LIMIT_OF_STRAIGHT_STEPS
    # name of a law -> (n_instants,) residual, as the engine reports it; no `Certificate` yet
    residuals_of_laws = solution.record.certificates
    violations_by_source = {"fields": violations_in_fields, "record": residuals_of_laws}
    certificates_of_laws = []
    for source, violations in violations_by_source.items():
        for name, violation in violations.items():
            sizes = np.abs(np.asarray(violation, dtype=float))
            admitted_by_law = admitted_violation
            if name == "loads":
                admitted_by_law = max(admitted_violation, _LEAST_LIMIT_OF_LOADS)
            certificates_of_laws.append(
                _certificate(name, source, sizes, solution.time, admitted_by_law)
            )
    return tuple(certificates_of_laws)


def _certificate(
    name: str, source: str, violation: Array, time: Array, admitted_violation: float
) -> Certificate:
    """The check of a law from its violation over `time`, (n_instants,) each: the largest counts,
    and a NaN as largest. It holds if that is at most `admitted_violation`. `source` is "fields"
    where the violation is computed from the fields of a solution, "record" where the engine states
    it.

    `name` is that of the law, such as "tension".
    """
    worst_instant = int(np.argmax(np.where(np.isnan(violation), np.inf, violation)))
    return Certificate(
        name.replace("_", " "),
        source,
        violation,
        float(violation[worst_instant]),
        float(time[worst_instant]),
        admitted_violation,
    )


def _violation_by_tension(solution: ContactSolution) -> Array:
    """Largest tension −p of any point over the largest pressure of the path, (n_instants,)."""
    return np.maximum(-solution.pressure.min(axis=1), 0.0) / _largest_pressure(solution)


def _violation_of_coulomb_limit(solution: ContactSolution) -> Array:
    """Violation of the Coulomb limit, (n_instants,): the largest |q| − f p of any point, 0 where
    none exceeds the limit, over f times the largest pressure of the path; over that pressure itself
    where f = 0.
    """
    friction_coefficient = solution.scene.friction.coefficient
    excess = np.max(np.abs(solution.shear) - friction_coefficient * solution.pressure, axis=1)
    return np.maximum(excess, 0.0) / ((friction_coefficient or 1.0) * _largest_pressure(solution))


def _violation_in_slip(solution: ContactSolution) -> Array:
    """Violation of Coulomb's law in slip, (n_instants,): the largest |q − f p| of points in forward
    slip, and |q + f p| in reverse slip, over f times the largest pressure of the path; over that
    pressure itself where f = 0. 0 at an instant at which no point slips.
    """
    friction_coefficient = solution.scene.friction.coefficient
    # 1 forward, -1 reverse, 0 no slip
    slip_direction = (solution.state == SLIP_FORWARD) * 1.0 - (solution.state == SLIP_REVERSE)
    largest_excess = np.max(
        np.abs(slip_direction * solution.shear - friction_coefficient * solution.pressure),
        axis=1,
        where=slip_direction != 0,
        initial=0.0,
    )
    return np.asarray(
        largest_excess / ((friction_coefficient or 1.0) * _largest_pressure(solution))
    )


def _difference_of_loads(solution: ContactSolution) -> Array:
    """Largest of |P - P(t)| and |Q - Q(t)| over the largest P, P(t) and Q(t) being the scene's,
    (n_instants,).
    """
    normal_load, tangential_load = solution.scene.load.path().at(solution.time)
    largest_difference = np.maximum(
        np.abs(solution.normal_load - normal_load),
        np.abs(solution.tangential_load - tangential_load),
    )
    return np.asarray(largest_difference / np.max(normal_load))


def _largest_pressure(solution: ContactSolution) -> float:
    """Largest pressure of the path; 1 where there is none."""
    return float(np.max(solution.pressure)) or 1.0


# --------------------------------------------------------------------------------- expected numbers
@dataclass(frozen=True)
class ExpectedNumber(PythonNumbers):
    """A number that a scene expects of an engine, beside the engine's own value."""

    expected: Expected  # the number, its tolerance, engine and source
    value: float  # the engine's own; NaN where it has no such thing
    difference: float  # (value - expected)/scale, the scale being that of the tolerance

    @property
    def is_met(self) -> bool:
        """Whether the difference lies within the tolerance; a NaN never does."""
        return verdict_on(self.difference, self.expected.tolerance) is Verdict.WITHIN


def _lower_face_displacement(solution: ContactSolution) -> float:
    """Displacement along y of the middle of the lower face at the largest load of the last cycle
    [length]; NaN for a half-plane, whose displacement has no datum, and for a solution that is not
    of finite elements.
    """
    from halfplane_fe import FiniteElementSolution, fields

    if (
        not isinstance(solution, FiniteElementSolution)
        or solution.scene.bodies.lower.kind == "half_plane"
    ):
        return math.nan
    # displacements at the nodes of the lower body; the node nearest to x = y = 0 is the middle
    lower_body = fields(solution, [solution.time[_index_of_largest_load(solution)]])[0].bodies[0]
    return float(lower_body.displacement[np.argmin(np.hypot(*lower_body.points.T)), 1])


def _index_of_largest_load(solution: ContactSolution) -> int:
    """Index of the instant of the last cycle with the largest P."""
    return int(solution.last_cycle[np.argmax(solution.normal_load[solution.last_cycle])])


def _largest_half_width(solution: ContactSolution) -> float:
    """Largest half-width of the contact in the last cycle [length]."""
    return float(np.nanmax(solution.contact_half_width[solution.last_cycle]))


def _stick_edges(solution: ContactSolution) -> list[float]:
    """Left and right end of the zone that sticks through the whole last cycle [length]; NaN without
    such a zone.
    """
    edges = solution.permanent_stick_edges
    return [math.nan, math.nan] if edges is None else [float(edge) for edge in edges]


def _moment_at_largest_load(solution: ContactSolution) -> float:
    """Moment M at the largest load of the last cycle [force]; NaN where the solution states
    none.
    """
    if solution.moment is None:
        return math.nan
    return float(solution.moment[_index_of_largest_load(solution)])


def _bulk_work(solution: ContactSolution) -> float:
    """Work of the bulk stress in the last cycle [energy / thickness], a part of `loop_work`:
    −(closed integral of m_q d(eps)) by the trapezoidal rule, m_q the moment of the shear, eps the
    bulk strain. NaN where the solution holds no whole cycle.
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
    value_of: Callable[[ContactSolution], float]


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
    "moment": _Quantity("moment of the pressure about x = 0", "moment", _moment_at_largest_load),
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
NAMES_OF_UNSYMMETRIC_VALUES = ("bulk_work", "permanent_stick_left", "permanent_stick_right")


def values_of_unsymmetric(solution: ContactSolution) -> dict[str, float]:
    """Values, by name, that only a solution with bulk stress, tilt or unequal sides has; empty for
    others.
    """
    if solution.permanent_stick_edges is None:
        return {}
    return {key: QUANTITIES[key].value_of(solution) for key in NAMES_OF_UNSYMMETRIC_VALUES}


def _scale_of_tolerance(expected: Expected, solution: ContactSolution) -> float:
    """The number that the tolerance of an expected number is relative to: the size of the expected
    number. Where that is 0, a typical size of its kind in the solution: of an energy A f^2 P^2 (A
    the compliance of the materials, f the friction coefficient), of a stress the largest p, of a
    length the largest half-width a, of a moment P a, P the largest load; 1 of a share.

    `expected.quantity` names the number, such as "dissipation"; `QUANTITIES` has its kind.
    """
    if expected.value:
        return abs(expected.value)
    largest_normal_load = float(solution.normal_load[solution.last_cycle].max())
    match QUANTITIES[expected.quantity].kind:
        case "energy":
            return energy_scale(solution.scene, largest_normal_load)
        case "stress":
            return float(np.max(solution.pressure))
        case "moment":
            return largest_normal_load * _largest_half_width(solution)
        case "share":
            return 1.0
    return _largest_half_width(solution)


def largest_load_ratio(solution: ContactSolution) -> float:
    """Largest |Q|/(f P) of the last cycle of a solution, 1 at gross sliding; NaN without friction.
    The loads are those of the solution, which under a prescribed displacement are found by solving.
    """
    friction_coefficient = solution.scene.friction.coefficient
    if not friction_coefficient:
        return math.nan
    indices = solution.last_cycle  # of the instants
    largest_q_over_p = largest_ratio_of(
        solution.normal_load[indices], solution.tangential_load[indices]
    )
    return largest_q_over_p / friction_coefficient


def expected_numbers(
    scene: Scene, solutions: Iterable[ContactSolution]
) -> Iterator[ExpectedNumber]:
    """The numbers that a scene expects of theory or finite elements, each beside the value of that
    engine's solution, in the order of the scene. Engines without a solution are left out, and so is
    theory corrected by responses of finite bodies.

    An entry of `scene.expected` has the engine's name in words, the name of the quantity, its value
    and tolerance. The difference is (engine's value − expected value)/scale of the tolerance.
    """
    # "half-plane theory", "finite elements" -> solution
    solution_by_engine = {
        engine_in_words(solution.engine): solution
        for solution in solutions
        if not is_corrected(solution)
    }
    for expected in scene.expected:
        if expected.engine in solution_by_engine:
            solution = solution_by_engine[expected.engine]
            # QUANTITIES: name of a quantity -> how its value is taken from a solution
            value_of_engine = QUANTITIES[expected.quantity].value_of(solution)
            difference = (value_of_engine - expected.value) / _scale_of_tolerance(
                expected, solution
            )
            yield ExpectedNumber(expected, value_of_engine, difference)


def expected_rows(findings: Iterable[ExpectedNumber]) -> list[tuple[str, ...]]:
    """Cells of the table of expected numbers that the terminal shows: quantity, engine, expected
    number, value of the engine, difference, tolerance, whether the difference is within it.

    A finding has the expected number (`expected`), the `value` of the engine (NaN: none), their
    relative `difference`, and `is_met`.
    """
    # `minus`: with a real minus sign
    return [
        (
            finding.expected.quantity.replace("_", " "),
            finding.expected.engine,
            f"{finding.expected.value:.5g}",
            "none" if math.isnan(finding.value) else f"{finding.value:.5g}",
            "–" if math.isnan(finding.difference) else minus(f"{finding.difference:+.1e}"),
            f"{finding.expected.tolerance:.3g}",
            "yes" if finding.is_met else "no",
        )
        for finding in findings
    ]


EXPECTED_HEADS = ("quantity", "engine", "expected", "found", "off", "limit", "met")


def expected_content(findings: Iterable[ExpectedNumber]) -> list[dict[str, Any]]:
    """The expected numbers of a scene beside the values of the engines, as mappings for JSON: the
    entries of the scene, then "found" (value of the engine), "difference" (over the scale of the
    tolerance), and "met" (whether that is within the tolerance).
    """
    return [
        {
            **finding.expected.model_dump(mode="json"),
            "found": finding.value,
            "difference": finding.difference,
            "met": finding.is_met,
        }
        for finding in findings
    ]
