"""The metrics: one table, `METRICS`, of which words, JSON, terminal and manual are made; and the
pair of solutions with all that was measured of it.

A row has its words, why it is there, what it needs, the function that measures it (measures.py) and
its tolerance. Every metric is dimensionless: result − reference over a scale.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np

from reports.comparison import measures
from reports.comparison.laws import Certificate, Verdict, verdict_on
from reports.comparison.measures import MetricValue
from reports.comparison.pairs import Pair, engine_in_words
from reports.comparison.why import Why
from scenes import ContactSolution, Scene
from scenes.scene import OWN_TOLERANCES

# Names in `Metric.needs` that are no field of a solution.
WHOLE_CYCLE = "whole_cycle"
FRICTION = "friction"
# Fields that are 0 or have no meaning where a contact carries no shear.
FIELDS_OF_FRICTION = ("shear", "slip", "state", "stick_edges", "dissipation", "dissipation_density")
# A shear of the reference below this share of f p_ref is round-off.
_NEGLIGIBLE_SHARE_OF_SHEAR = 1e-9


@dataclass(frozen=True, eq=False, kw_only=True)
class Metric(MetricValue):
    """One metric: its row of the table and, in a comparison, the value that was measured.

    Attributes
    ----------
    key, label
        name in JSON and on the command line; name on the page
    short
        label for a narrow table; "" where the label itself is short
    how
        how the metric is computed
    why
        why the metric is there
    unit
        the number that the difference is divided by, in words
    norm
        how the differences at points and instants become one value
    region
        which points and instants count
    needs
        fields that a solution must have, also `WHOLE_CYCLE` and `FRICTION`
    measure
        the function that computes it from a `Pair`
    absolute_unit
        `unit` where the reference's own value is 0
    quantity
        kind of the two amounts: "stress", "length", "slip", "energy", "energy density"; "" where
        there are none. A metric with amounts stands in the page's first table
    signed
        whether its sign has a meaning (result − reference); a norm has none
    judged_by
        key of the metric whose tolerance judges this one; "" for its own tolerance
    exists
        whether a pair has this metric at all, for example only with bulk stress; None: always
    tolerance
        largest |value| admitted; None: not judged. In `METRICS` that of the project's own engines
    lacks_field
        whether a solution lacks a field that the metric needs; with a tolerance it is then
        unscored
    """

    key: str
    label: str
    how: str
    why: str
    unit: str
    norm: str
    region: str
    needs: tuple[str, ...]
    measure: Callable[[Pair], MetricValue] = field(repr=False)
    absolute_unit: str = ""
    quantity: str = ""
    short: str = ""
    signed: bool = True
    judged_by: str = ""
    exists: Callable[[Pair], bool] | None = field(default=None, repr=False)
    tolerance: float | None = None
    lacks_field: bool = False

    @property
    def headline(self) -> bool:
        """Whether the metric stands in the page's first table."""
        return bool(self.quantity)

    @property
    def verdict(self) -> Verdict | None:
        """Whether the value of the metric lies within its tolerance, by its uncertainty; None
        without a tolerance or a value. A value that is not finite is outside, with or without a
        tolerance.
        """
        if self.value is None:
            return None
        if self.tolerance is None:
            return None if np.isfinite(self.value) else Verdict.OUTSIDE
        return verdict_on(self.value, self.tolerance, self.uncertainty)

    @property
    def accurate(self) -> bool | None:
        """Whether the verdict is "within": undecided counts as outside; None where there is no
        verdict.
        """
        return None if self.verdict is None else self.verdict is Verdict.WITHIN

    def with_value(self, measured: MetricValue, tolerance: float | None) -> Metric:
        """The metric with its value and the tolerance that judges it. The amounts in reference and
        result, and their stated uncertainties, are kept for metrics of the first table only.
        """
        measured_fields = dict(vars(measured))
        if not self.headline:
            measured_fields["amounts"] = None
            measured_fields["stated"] = (None, None)
        # absolute: not over the amount of the reference, which is 0
        unit = self.absolute_unit if measured.absolute else self.unit
        return replace(self, unit=unit, tolerance=tolerance, **measured_fields)

    def tolerance_from(self, tolerances: Mapping[str, float]) -> float | None:
        """The tolerance that judges the metric: its own, else that of the metric `judged_by`; None
        where `tolerances` (key -> |E| admitted) has neither.
        """
        return tolerances.get(self.key, tolerances.get(self.judged_by))


# ----------------------------------------------------------------------------- judging by the table


def reason_by_missing_field(solution: ContactSolution) -> dict[str, str]:
    """Fields that some metric needs and a solution lacks: name of the field -> reason.

    The solution states them in `work.skipped` (name -> count and reason). Such a field was not
    requested of its engine, or an external result does not have it. `METRICS` is the table of all
    metrics, by key; `needs` are the fields that a metric is computed from.
    """
    needed_fields: set[str] = set()
    for metric in METRICS.values():
        needed_fields.update(metric.needs)
    return {
        name: reason for name, (_, reason) in solution.work.skipped.items() if name in needed_fields
    }


def judged_metrics(pair: Pair, tolerances: Mapping[str, float]) -> tuple[Metric, ...]:
    """Every metric that a comparison has, in the order of the table, with its value and the
    tolerance that judges it. `tolerances`: key -> largest size of the value admitted.

    A metric that needs a field which a solution lacks has no value, and the reason as its note.
    Metrics of friction in a frictionless scene have neither value nor tolerance.

    A row of the table `METRICS` states by `exists` which pairs have the metric (None: all).
    """
    # name of the engine -> name of a field that its solution lacks -> why
    reasons_by_engine = {
        engine_in_words(solution.engine): reason_by_missing_field(solution)
        for solution in (pair.result, pair.reference)
    }
    # more shear than 1e-9 of f p_ref, which is round-off
    largest_shear = np.abs(np.nan_to_num(pair.reference_cycle.shear)).max()
    carries_shear = bool(largest_shear > _NEGLIGIBLE_SHARE_OF_SHEAR * pair.scales.shear)
    metrics = []
    for metric in METRICS.values():
        if metric.exists is not None and not metric.exists(pair):
            continue
        tolerance = metric.tolerance_from(tolerances)  # None: not judged
        reason = _reason_for_none(metric, reasons_by_engine)  # "" where all fields are there
        if FRICTION in metric.needs and not pair.result.scene.friction.coefficient:
            note = "frictionless: nothing sticks and nothing resists slip"
            metrics.append(replace(metric, note=note, tolerance=None))
        elif reason:
            metrics.append(_metric_without_field(metric, reason, tolerance, carries_shear))
        else:
            metrics.append(_measured_metric(metric, pair, tolerance))
    return tuple(metrics)


def _metric_without_field(
    metric: Metric, reason: str, tolerance: float | None, carries_shear: bool
) -> Metric:
    """A metric without a value, since a solution lacks a field that it needs, with the reason as
    its note. It keeps its `tolerance`, unless it is one of shear, slip, state or dissipation and
    the contact carries no shear: then there is nothing to judge.
    """
    # `needs`: the fields of a solution that the metric takes
    needs_shear = not set(metric.needs).isdisjoint(FIELDS_OF_FRICTION)
    tolerance_of_metric = tolerance if carries_shear or not needs_shear else None
    return replace(metric, note=reason, tolerance=tolerance_of_metric, lacks_field=True)


def _measured_metric(metric: Metric, pair: Pair, tolerance: float | None) -> Metric:
    """A metric with its value for a pair of solutions, as its function `measure` computes it. It
    keeps its `tolerance` where there is a value.
    """
    measurement = metric.measure(pair)
    tolerance_of_value = None if measurement.value is None else tolerance
    return metric.with_value(measurement, tolerance_of_value)


def _reason_for_none(metric: Metric, reasons_by_engine: Mapping[str, Mapping[str, str]]) -> str:
    """In words, the first field that the metric needs and a solution lacks, with the reason; ""
    where both solutions have all fields. `metric.needs` are the names of the fields;
    `reasons_by_engine` maps the name of an engine to field -> why it is absent.
    """
    for engine, reason_by_field in reasons_by_engine.items():
        for field_name in metric.needs:
            if field_name in reason_by_field:
                field_in_words = field_name.replace("_", " ")
                if field_name == "dissipation_density":
                    field_in_words = "pointwise dissipation"
                return f"{field_in_words}: {reason_by_field[field_name]} ({engine})"
    return ""


def tolerances_of(
    scene: Scene, is_theory_exact: bool, tolerances: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Key of a metric -> largest size of its value admitted: that of `tolerances`, else that of the
    scene, else that of the project's own engines where theory is exact for the bodies.

    A metric whose tolerance is infinite is not judged, and is left out. `is_theory_exact`: whether
    the bodies are half-planes whose normal and shear tractions are not coupled.
    """
    # OWN_TOLERANCES: those of the project's own engines, by key
    engine_tolerances = OWN_TOLERANCES if is_theory_exact else {}
    scene_tolerances = {
        key: value for key, value in scene.tolerances.model_dump().items() if value is not None
    }
    tolerance_values = {**engine_tolerances, **scene_tolerances, **(tolerances or {})}
    return {key: value for key, value in tolerance_values.items() if value < math.inf}


def markdown() -> str:
    """The table of docs/metrics.md: one row for each metric, in the order of the table."""
    heads = ("Metric", "How", "Why", "Unit", "Norm; region", "Tolerance")
    return "\n".join((_markdown_row(heads), "|---" * len(heads) + "|", *_markdown_rows()))


def _markdown_row(cells: tuple[str, ...]) -> str:
    """A row of a Markdown table."""
    return f"| {' | '.join(cells)} |"


# Phrases of most rows, which docs/metrics.md explains before the table -> what the table has.
_SHORT_PHRASES = {
    "value at the worst": "worst",
    "; every point, edges included": "",
    "; every point": "",
    "; judged instants": "",
    "; last cycle": "",
    "one value; ": "",
    "one value": "–",
}


def _markdown_rows() -> Iterator[str]:
    """Rows of the manual's table of metrics as Markdown: name, method, reason, unit, norm and
    region, tolerance.

    Norm: how the differences at points and instants become one value; region: which points and
    instants count.
    """
    for metric in METRICS.values():
        norm_and_region = f"{metric.norm}; {metric.region}"
        # phrases of most rows, which the manual explains before the table
        for phrase, short_phrase in _SHORT_PHRASES.items():
            norm_and_region = norm_and_region.replace(phrase, short_phrase)
        if not metric.signed:
            norm_and_region += "; no sign"
        tolerance_in_words = "–"
        if metric.tolerance is not None:
            tolerance_in_words = f"{metric.tolerance:g}"
            if metric.judged_by:  # key of the metric that lends the tolerance
                tolerance_in_words += f" (`{metric.judged_by}`)"
        name = f"{metric.label}: `{metric.key}`"
        method = metric.how.replace("|", "\\|")
        yield _markdown_row(
            (name, method, metric.why, metric.unit, norm_and_region, tolerance_in_words)
        )


# ---------------------------------------------------------------------------------------- the table

_UNIT_OF_WORK = "A f² P_ref²"
_ONE_VALUE = "one value"
_WORST_INSTANT = "value at the worst instant"
_L2 = "L2 over x; worst instant"
_CYCLE = "last cycle"
_INSTANTS = "judged instants"
_POINTS = "every point, edges included; judged instants"
_POINTS_OF_CYCLE = "every point, edges included; last cycle"
_IN_CONTACT = "points in contact in both; judged instants"
_STICK = (
    f"{_INSTANTS} at which both have one, but for a single step by which full stick comes or goes"
    " apart"
)
_HAS_BULK_STRESS = attrgetter("has_bulk_stress")
_MAY_TILT = attrgetter("may_tilt")
_WITH_EFFECTS = attrgetter("has_effects")

# The first table, with absolute values of both; below it all others.
_ROWS = (
    Metric(
        key="largest_pressure",
        label="Peak pressure",
        how="max p / max p_ref − 1 over the cycle, each over its own points",
        why="the pressure that wear and yield are judged by",
        unit="of the reference",
        norm=_ONE_VALUE,
        region="every point; last cycle",
        needs=("pressure",),
        measure=measures.largest_pressure,
        quantity="stress",
        judged_by="peak_pressure",
    ),
    Metric(
        key="largest_half_width",
        label="Contact half-width",
        how="half-width where it is largest, over that of the reference, − 1",
        why="the scale of all lengths",
        unit="of the reference",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("pressure",),
        measure=measures.largest_half_width,
        quantity="length",
        short="Half-width",
        judged_by="contact_edge",
    ),
    Metric(
        key="permanent_stick",
        label="Stick half-width, permanent",
        how="half-width that sticks through the whole last cycle, result − reference",
        why="it divides worn from unworn surface",
        unit="of a_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("state", WHOLE_CYCLE, FRICTION),
        measure=measures.permanent_stick,
        quantity="length",
        short="Permanent stick",
    ),
    Metric(
        key="stick_eccentricity",
        label="Stick zone, centre",
        how="middle of what sticks through the whole last cycle, result − reference",
        why="bulk stress and tilt move it",
        unit="of a_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("state", WHOLE_CYCLE, FRICTION),
        measure=measures.stick_eccentricity,
        quantity="length",
        short="Stick centre",
        judged_by="permanent_stick",
        exists=attrgetter("is_unsymmetric"),
    ),
    Metric(
        key="largest_slip",
        label="Largest slip",
        how="largest range of s of a place through the cycle, over that of the reference, − 1, each"
        " over its own contact",
        why="the slip amplitude of a fretting map",
        unit="of the reference",
        norm=_ONE_VALUE,
        region="places while they are in contact; last cycle",
        needs=("slip", "state", WHOLE_CYCLE),
        measure=measures.largest_slip,
        quantity="slip",
        absolute_unit="f p_ref a_ref/E*",
    ),
    Metric(
        key="dissipation",
        label="Dissipation",
        how="W − W_ref",
        why="the friction work of a cycle: damping, heat, wear",
        unit="of W_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("dissipation", WHOLE_CYCLE),
        measure=measures.dissipation,
        quantity="energy",
        absolute_unit=_UNIT_OF_WORK,
    ),
    Metric(
        key="dissipation_density_peak",
        label="Largest pointwise dissipation",
        how="max w / max w_ref − 1, each over its own points; with its place",
        why="the point that wears most",
        unit="of largest w_ref",
        norm=_ONE_VALUE,
        region=_POINTS_OF_CYCLE,
        needs=("dissipation_density", WHOLE_CYCLE),
        measure=measures.largest_dissipation_density,
        quantity="energy density",
        short="Peak W(x)",
        absolute_unit=f"{_UNIT_OF_WORK}/a_ref",
    ),
    Metric(
        key="edge_tension",
        label="Tension at the trailing edge",
        how="largest stress along a face at an edge of contact, over that of the reference, − 1; of"
        " half-plane theory and finite elements alone",
        why="cracks start there",
        unit="of the reference",
        norm=_ONE_VALUE,
        region="both edges of contact, both bodies; last cycle",
        needs=("pressure", "shear", WHOLE_CYCLE),
        measure=measures.edge_tension,
        quantity="stress",
        short="Edge tension",
        absolute_unit="f p_ref",
    ),
    Metric(
        key="largest_slip_common",
        label="Largest slip, common points",
        how="the same, both over the result's points and instants",
        why="theory's own may lie between the result's points",
        unit="of the reference",
        norm=_ONE_VALUE,
        region="points in contact in both; last cycle",
        needs=("slip", "state", WHOLE_CYCLE, FRICTION),
        measure=measures.largest_slip_common,
        absolute_unit="f p_ref a_ref/E*",
    ),
    Metric(
        key="peak_pressure",
        label="Peak pressure, worst instant",
        how="max p / max p_ref − 1 of an instant, both over the same points",
        why="a wrong pressure at a light load hides behind the largest of the cycle",
        unit="of peak p_ref",
        norm=_WORST_INSTANT,
        region=_POINTS,
        needs=("pressure",),
        measure=measures.peak_pressure,
    ),
    Metric(
        key="pressure",
        label="Pressure, L2",
        how="‖p − p_ref‖/‖p_ref‖, L2 over x",
        why="the whole distribution, wherever it is wrong",
        unit="of ‖p_ref‖",
        norm=_L2,
        region=_POINTS,
        needs=("pressure",),
        measure=measures.pressure,
        signed=False,
    ),
    Metric(
        key="shear",
        label="Shear traction, L2",
        how="‖q − q_ref‖/(f ‖p_ref‖), L2 over x, since q changes sign in the cycle",
        why="the whole distribution: it holds the history of friction",
        unit="of f ‖p_ref‖",
        norm=_L2,
        region=_POINTS,
        needs=("shear",),
        measure=measures.shear,
        signed=False,
    ),
    Metric(
        key="contact_edge",
        label="Contact edge",
        how="outward shift of the worse edge",
        why="it moves with mesh, far field and bodies",
        unit="of a_ref",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=(),
        measure=measures.contact_edge,
    ),
    Metric(
        key="stick_edge",
        label="Stick edge",
        how=(
            "outward shift of the worse edge, where both have one (in full stick: the contact edge)"
        ),
        why="it shows an error of friction or history first",
        unit="of a_ref",
        norm=_WORST_INSTANT,
        region=_STICK,
        needs=("stick_edges",),
        measure=measures.stick_edge,
    ),
    Metric(
        key="state",
        label="Stick/slip map",
        how="share of the length in contact whose state (open, stick, forward or reverse slip)"
        " differs",
        why="slip in the wrong sense, or at the wrong time, has right edges",
        unit="of the contact",
        norm="mean over the cycle",
        region="points in contact in either; instants in contact",
        needs=("state",),
        measure=measures.state,
        signed=False,
    ),
    Metric(
        key="tangential_displacement",
        label="Tangential displacement",
        how="U − U_ref over the range of U_ref in the cycle",
        why="what a rig measures: the stiffness of contact and bodies",
        unit="of U_ref's stroke",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=("tangential_displacement",),
        measure=measures.tangential_displacement,
    ),
    Metric(
        key="displacement_amplitude",
        label="Amplitude of the displacement",
        how="half the range of U over that of the reference, − 1, that of half-planes as U + c_t Q",
        why="stroke and secant stiffness at the actuator",
        unit="of the reference",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("tangential_displacement", WHOLE_CYCLE),
        measure=measures.displacement_amplitude,
        exists=_WITH_EFFECTS,
    ),
    Metric(
        key="approach_amplitude",
        label="Amplitude of the approach",
        how="half the range of the normal approach over that of the reference, − 1, that of"
        " half-planes as approach + c_n P",
        why="the normal stiffness of contact and bodies",
        unit="of the reference",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=(WHOLE_CYCLE,),
        measure=measures.approach_amplitude,
        exists=_WITH_EFFECTS,
    ),
    Metric(
        key="dissipation_polygon",
        label="Dissipation, steps' error out",
        how="W − W_ref, both on the straight lines between the instants: all errors except that of"
        " the steps",
        why="what more steps can't mend",
        unit="of W_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("dissipation", WHOLE_CYCLE),
        measure=measures.dissipation_without_steps,
        absolute_unit=_UNIT_OF_WORK,
        exists=attrgetter("has_polygon"),
    ),
    Metric(
        key="dissipation_step",
        label="Dissipation, steps' error only",
        how="W_ref on the straight lines between the instants, with what finite elements add for a"
        " curve, − W_ref",
        why="what more steps can mend",
        unit="of W_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=(),
        measure=measures.dissipation_of_steps,
        absolute_unit=_UNIT_OF_WORK,
        exists=attrgetter("has_polygon"),
    ),
    Metric(
        key="hysteresis",
        label="Hysteresis loop",
        how="closed integral of Q dU − that of the reference, trapezoidal rule over the same"
        " instants",
        why="a second way to the friction work",
        unit="of its area",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("tangential_displacement", WHOLE_CYCLE),
        measure=measures.hysteresis,
        absolute_unit=_UNIT_OF_WORK,
    ),
    Metric(
        key="bulk_work",
        label="Bulk term of the loop",
        how="−closed integral of m_q dε − that of the reference; m_q = ∫x q dx, ε = σ/E′, lower −"
        " upper body",
        why="with bulk stress the loop of Q dU alone is not the friction work",
        unit="of W_ref",
        norm=_ONE_VALUE,
        region=_CYCLE,
        needs=("shear", "dissipation", WHOLE_CYCLE),
        measure=measures.bulk_term,
        absolute_unit=_UNIT_OF_WORK,
        judged_by="dissipation",
        exists=_HAS_BULK_STRESS,
    ),
    Metric(
        key="dissipation_drift",
        label="Drift of the dissipation",
        how="change of W in the last cycle over W, result − reference; 0 where it is steady",
        why="unsymmetric cycles settle slowly",
        unit="of W",
        norm=_ONE_VALUE,
        region="last two cycles",
        needs=("dissipation", WHOLE_CYCLE),
        measure=measures.drift,
        exists=attrgetter("may_drift"),
    ),
    Metric(
        key="moment",
        label="Moment",
        how="M = ∫x p dx, result − reference",
        why="a stated tilt has this answer",
        unit="of P_ref a_ref",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=("pressure",),
        measure=measures.moment,
        exists=_MAY_TILT,
    ),
    Metric(
        key="tilt",
        label="Tilt",
        how="that of the upper body, result − reference",
        why="a stated moment has this answer",
        unit="of A P_ref/a_ref",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=(),
        measure=measures.tilt,
        exists=_MAY_TILT,
    ),
    Metric(
        key="dissipation_density",
        label="Pointwise dissipation",
        how="w(x) − w_ref(x) over the largest w_ref; with its place",
        why="wear in the wrong place",
        unit="of largest w_ref",
        norm="value at the worst point",
        region=_POINTS_OF_CYCLE,
        needs=("dissipation_density", WHOLE_CYCLE),
        measure=measures.dissipation_density,
        absolute_unit=f"{_UNIT_OF_WORK}/a_ref",
    ),
    Metric(
        key="resultant_normal",
        label="Normal resultant",
        how="(resultant − P)/P, by the result's own weights and normals (needs no reference),"
        " otherwise by the trapezoidal rule, minus the error of that rule for the reference",
        why="equilibrium: a wrong unit, thickness or sign shows",
        unit="of P",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=("pressure",),
        measure=measures.normal_resultant,
    ),
    Metric(
        key="resultant_tangential",
        label="Tangential resultant",
        how="(resultant − Q)/P, as the normal resultant",
        why="likewise",
        unit="of P",
        norm=_WORST_INSTANT,
        region=_INSTANTS,
        needs=("shear",),
        measure=measures.tangential_resultant,
    ),
    Metric(
        key="slip",
        label="Slip, L2",
        how="root mean square over x of s − s_ref, over the range of s_ref in the cycle",
        why="the whole field of slip at each instant",
        unit="of the range of s_ref",
        norm=_L2,
        region=_IN_CONTACT,
        needs=("slip", FRICTION),
        measure=measures.slip,
        signed=False,
        absolute_unit="f p_ref a_ref/E*",
    ),
    Metric(
        key="energy_balance",
        label="Energy balance",
        how="work of the loads − stored energy − dissipation, step by step, over the largest work"
        " of the loads so far, as the result's record states it; needs no reference",
        why="a gap shows friction work that no load put in",
        unit="of the work of the loads",
        norm=_WORST_INSTANT,
        region=_CYCLE,
        needs=(),
        measure=measures.energy_balance,
        signed=False,
    ),
)

METRICS = {
    row.key: replace(row, tolerance=OWN_TOLERANCES.get(row.judged_by or row.key)) for row in _ROWS
}


@dataclass(frozen=True, eq=False)
class JudgedPair(Pair):
    """Reference and result, every metric of both with its verdict, and the laws that each obeys.

    Attributes
    ----------
    metrics
        in the order of the table, each with its value, uncertainty and verdict
    reference_certificates, result_certificates
        the laws of contact that each solution was checked for, with its largest violation
    notes
        sentences that a reader must not miss
    why
        the difference of the dissipation split by its causes; None where that was not asked for
    """

    metrics: tuple[Metric, ...]
    reference_certificates: tuple[Certificate, ...]
    result_certificates: tuple[Certificate, ...]
    notes: tuple[str, ...]
    why: Why | None = field(default=None, kw_only=True)

    @property
    def scene(self) -> Scene:
        """The scene that both solutions answer."""
        return self.result.scene

    @property
    def verdict(self) -> Verdict | None:
        """Verdict on the whole comparison: outside if one metric is outside, else undecided if one
        is undecided, else within. None where no metric is judged.
        """
        verdicts = {metric.verdict for metric in self.metrics}
        for candidate in (Verdict.OUTSIDE, Verdict.UNDECIDED, Verdict.WITHIN):
            if candidate in verdicts:
                return candidate
        return None

    @property
    def accurate(self) -> bool:
        """Whether every metric that is judged is within its tolerance: undecided counts as outside,
        nothing to judge as within.
        """
        return self.verdict in (Verdict.WITHIN, None)

    @property
    def admissible(self) -> bool:
        """Whether both solutions obey every law of contact that was checked."""
        return all(
            check.holds for check in (*self.reference_certificates, *self.result_certificates)
        )

    @property
    def unscored(self) -> tuple[Metric, ...]:
        """The metrics with a tolerance and no value, since a solution lacks a field they need."""
        return tuple(
            metric for metric in self.metrics if metric.lacks_field and metric.tolerance is not None
        )

    @property
    def passed(self) -> bool:
        """Accurate and admissible, with a value for every metric that has a tolerance."""
        return self.accurate and self.admissible and not self.unscored

    @property
    def headlines(self) -> tuple[Metric, ...]:
        """The metrics of the first table, those with absolute values."""
        return tuple(metric for metric in self.metrics if metric.headline)

    @property
    def others(self) -> tuple[Metric, ...]:
        """The metrics of the second table."""
        return tuple(metric for metric in self.metrics if not metric.headline)

    def metric(self, key: str) -> Metric:
        """The metric of that key; KeyError for an unknown one."""
        return {metric.key: metric for metric in self.metrics}[key]
