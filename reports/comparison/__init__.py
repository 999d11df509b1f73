"""What was compared: two solutions of one scene side by side, every metric with its uncertainty and
verdict.

Offered to the rest of reports, `Comparison` `compare` first; each file imports those above it only:

    cycles.py       the last cycle of a solution, on the points of another: `Cycle` `last_cycle`
                    `Event` `events` `index_of_first_row` `NAMES_OF_BULK_SERIES`
    datum.py        what displacements count from, c_t and c_n of finite bodies:
                    `effects_between` `lacks_datum` `cycle_from_supports`
    isolated.py     single values that no neighbour supports: `spike_mask` `without_spikes`
    pairs.py        reference and result on common points: `Pair` `are_half_planes`
                    `has_coupled_tractions` `engine_in_words` `stated_uncertainty`; their scales:
                    `scales_of_reference` `Scales` `compliance_of_materials` `energy_scale`
    work_of_loads.py closed integrals of Q dU, P dV and the bulk term: `loop_work` `bulk_work`
                    `normal_work` `bulk_strain` `bulk_strains_per_stress`
    measures.py     one function for each metric: `l2_norm` `quotient` `trapezoidal_weights`
    laws.py         the laws of contact that an answer obeys, whoever is right: `Certificate`
                    `certificates` `DERIVED` `names_of_derived_fields`; the numbers of a solution:
                    `QUANTITIES` `NAMES_OF_UNSYMMETRIC_VALUES` `largest_load_ratio`; those that its
                    scene expects: `ExpectedNumber` `expected_numbers` `expected_content`
                    `expected_rows` `EXPECTED_HEADS`; the verdict on an error: `Verdict`
                    `verdict_on`
    why.py          the difference of W split by what makes it: `Why` `Step` `percent_of`
                    `in_percent`
    metrics.py      the metrics, one table of words, reasons, needs, functions, tolerances:
                    `METRICS` `Metric` `reason_by_missing_field` `tolerances_of` `WHOLE_CYCLE`;
                    a pair with all of that: `JudgedPair`
    words.py        all of that in sentences, whose words are in templates/words.txt:
                    `headline_sentence` `verdict_in_few_words` `verdict_in_sentences`
                    `verdict_in_short`
                    `sentence_on_judging` `labels_judged_by_size` `verdict_for_colour`
                    `sentence_on_work` `question_in_words` `bodies_in_words`
                    `bulk_and_tilt_in_words` `unlike_materials_in_words` `idealisation_in_words`
                    `sentence_beyond_theory` `SUPPORT_WORDS` `as_sentence` `reading_in_words`
                    `part_of_path` `text_on_part_of_path` `notebook_html`; in cells: `term_in_words`
                    `value_in_words` `with_uncertainty` `factor_and_unit_shown` `first_table`
                    `cells_of_first_table` `first_summary_rows` `sentences_on_missing_values`
                    `row_of_sliding` `summary_rows` `summary_text` `summary_csv` `summary_latex`
                    `summary_in_five_lines`
    json_values.py  as JSON: `strict_json_values` `solution_content` `metric_content`
    budget.py       where the error of each metric comes from: mesh, steps, penalty, far field,
                    idealisation: `ErrorBudget` `Budget` `error_budget` `solve_refinements`
                    `coarser_mesh_and_settings` `settings_with_halved_steps` `mesh_ratio`
                    `theory_on_steps` `SHOWN_ON_STEPS` `ROUND_OFF_OF_METRIC`
                    `uncertainty_of_edge`; the mesh-refinement study of one value, its order and
                    value at size zero: `Refinement` `Extrapolation` `extrapolate`
    budget_words.py a budget in sentences, cells and JSON: `budget_table` `negligible_terms`
                    `cost_in_words` `cell_of_term` `budget_content`
    findings.py     what two runs, or a run and a baseline, differ by: `ValuesOfRun`
                    `read_run_values` `run_values_of_content` `run_values_of_solution`
                    `difference_of_runs`
                    `Difference` `ValueRow` `SAME` `NAMES_OF_COUNTS` `FORMAT_OF_SOLUTION`
                    `is_baseline` `write_baseline` `patterned_tolerances`
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from reports.comparison.cycles import (
    Cycle,
    cycle_interpolated_by_time,
    interpolated_cycle,
    last_cycle,
)
from reports.comparison.datum import cycle_from_supports, lacks_datum
from reports.comparison.laws import certificates
from reports.comparison.metrics import (
    METRICS,
    WHOLE_CYCLE,
    JudgedPair,
    judged_metrics,
    reason_by_missing_field,
    tolerances_of,
)
from reports.comparison.pairs import (
    LEAST_JUDGED_SHARE_OF_LOAD,
    Pair,
    are_half_planes,
    engine_in_words,
    scales_of_reference,
)
from scenes import BodyEffects, ContactSolution, InputError
from scenes.solution import require_solution

_DISPLACEMENT = "tangential_displacement"


@dataclass(frozen=True, eq=False)
class Comparison(JudgedPair):
    """Reference and result side by side, with the verdict.

    Attributes
    ----------
    reference, result
        the two solutions
    polygon_reference
        the reference's answer on the very polygon that the result stepped through, or None
    plain_reference
        the reference as it is, where `reference` follows a rule of the result; else the same
    scales
        reference load, half-width, pressure, ... that make the metrics dimensionless
    reference_cycle, result_cycle
        last cycle of the reference (on the result's points and instants) and of the result; with
        `effects` the displacements of half-planes in them are counted from the supports
    effects
        what the bodies add to half-planes, where it was given and a solution needs it; else None
    lacks_common_datum
        whether the displacements of the two are counted from different places, and no effects
        lead from the one to the other
    metrics
        in the order of the table
    reference_certificates, result_certificates
        the laws of contact, needing no reference
    notes
        everything that a reader must not miss
    why
        the difference of W split by what makes it, where that was asked for; else None
    """

    def __repr__(self) -> str:
        """Five lines: who was compared on what, the headline, dissipation and largest pressure, the
        verdict.
        """
        from reports.comparison import words

        return words.summary_in_five_lines(self, "Comparison")

    def _repr_html_(self) -> str:
        """For a notebook."""
        from reports.comparison import words

        return words.notebook_html(self, has_budget=False)

    def summary(self) -> str:
        """The first table of the page as text: theory, finite elements, difference with its
        uncertainty, verdict; in units.
        """
        from reports.comparison import words

        return words.summary_text(self)

    def to_csv(self) -> str:
        """The table of `summary_text` as CSV with every digit: key, quantity, unit, both values,
        error E, its uncertainty, verdict; empty where a number is unknown.
        """
        from reports.comparison import words

        return words.summary_csv(self)

    def to_latex(self) -> str:
        """The table of `summary_text` as a `tabular` of LaTeX with the rules of booktabs."""
        from reports.comparison import words

        return words.summary_latex(self)


def compare(
    reference: ContactSolution,
    result: ContactSolution,
    *,
    polygon_reference: ContactSolution | None = None,
    scales_from: ContactSolution | None = None,
    plain_reference: ContactSolution | None = None,
    tolerances: Mapping[str, float] | None = None,
    effects: BodyEffects | None = None,
) -> Comparison:
    """Compare two solutions of one scene in the last cycle: every metric with its value, its
    uncertainty and its verdict, the laws of contact that each solution obeys, and notes.

    Parameters
    ----------
    reference
        the solution taken as true; best on the points and instants of `result`, otherwise it is
        interpolated and the interpolation error stated in the notes
    result
        the solution that is judged
    polygon_reference
        the reference for loads that run straight from one instant of the result to the next. With
        it the error of the load increments is measured apart from all others
    plain_reference
        the reference with its own states, edges and dissipation, which the first table shows.
        Needed where those of `reference` are found from its tractions, by the rule that gave those
        of an external result; `reference` if None
    scales_from
        a solution that the scales are taken from, where the reference holds few instants;
        `reference` if None
    tolerances
        key of a metric -> largest size of its value that is admitted; it has priority over those of
        the scene. Without either, bodies for which half-plane theory is exact are judged by the
        tolerances of the project's own engines, and real bodies are not judged
    effects
        what finite bodies add to half-planes, `halfplane_fe.body_effects(scene)`: the compliances
        c_t and c_n. The displacements of half-plane theory are then U + c_t Q and approach + c_n P,
        which can be compared with those of the bodies; without it they count from another place

    Raises
    ------
    InputError
        If the scenes of the solutions differ in material, profile, friction or load, if one should
        hold a whole cycle and does not, or if a key of `tolerances` is no metric.

    Examples
    --------
    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> exact = semi_analytic.solve(load_scene("cattaneo-mindlin"))
    >>> compare(exact, exact).metric("dissipation").value
    0.0
    """
    for solution in (reference, result):
        require_solution(solution, "compare")
    for optional_solution in (polygon_reference, scales_from, plain_reference):
        if optional_solution is not None:
            require_solution(optional_solution, "compare")
    _refuse_unknown_metrics(tolerances or {})
    _refuse_other_question(reference, result)
    if polygon_reference is not None:
        _refuse_other_question(polygon_reference, result)
    cycles = _comparable_cycles(reference, result, effects)
    # both solutions and their last cycles on common points and instants
    pair = Pair(
        reference,
        result,
        polygon_reference,
        plain_reference or reference,
        scales_of_reference(scales_from or reference),
        reference_cycle=cycles.reference_cycle,
        result_cycle=cycles.result_cycle,
        effects=cycles.effects,
        lacks_common_datum=cycles.lacks_common_datum,
    )
    # a comparison has all fields of the pair, then metrics, laws of contact and notes
    return Comparison(
        **{name: getattr(pair, name) for name in Pair.__dataclass_fields__},
        metrics=judged_metrics(
            pair, tolerances_of(result.scene, are_half_planes(result.scene), tolerances)
        ),
        reference_certificates=certificates(reference),
        result_certificates=certificates(result),
        notes=tuple(_notes_on_pair(pair)),
    )


def _refuse_unknown_metrics(tolerances: Iterable[str]) -> None:
    """InputError for a key of `tolerances` that is no metric."""
    for key in tolerances:
        # `METRICS`: the table of all metrics, by key
        if key not in METRICS:
            raise InputError(
                f"tolerances: {key!r} is no metric; the metrics are {', '.join(METRICS)}"
            )


class _ComparableCycles(NamedTuple):
    """The last cycles of reference and result, on the points and instants of the result."""

    reference_cycle: Cycle
    result_cycle: Cycle
    # compliances of finite bodies by which the displacements of one were counted from the supports,
    # as those of the other; None where that was not needed, or they are not known
    effects: BodyEffects | None
    lacks_common_datum: bool  # whether displacements still count from two places


def _comparable_cycles(
    reference: ContactSolution, result: ContactSolution, effects: BodyEffects | None
) -> _ComparableCycles:
    """The last cycle of the result, and that of the reference interpolated to its points and
    instants. `effects` are the compliances that finite bodies add to half-planes, None where they
    are not known: with them displacements of half-plane theory are counted from the supports.

    Instants are matched by the share of the period; those that are no whole cycle by their times.
    """
    result_cycle = last_cycle(result)
    if result_cycle.is_whole:
        reference_cycle = interpolated_cycle(last_cycle(reference), result_cycle, reference.engine)
    else:
        reference_cycle = cycle_interpolated_by_time(reference, result_cycle)
    # Displacements of one solution count from the supports of the bodies. Those of the other do
    # not: it is half-plane theory, which lacks a datum.
    has_other_datum = lacks_datum(reference) != lacks_datum(result)
    if not has_other_datum:
        effects = None
    elif effects is not None and lacks_datum(reference):
        reference_cycle = cycle_from_supports(reference_cycle, effects)
    elif effects is not None:
        result_cycle = cycle_from_supports(result_cycle, effects)
    lacks_common_datum = has_other_datum and effects is None
    return _ComparableCycles(reference_cycle, result_cycle, effects, lacks_common_datum)


def _refuse_other_question(reference: ContactSolution, result: ContactSolution) -> None:
    """InputError where two solutions differ in material, profile, friction or load."""
    for part in ("material", "profile", "friction", "load"):
        reference_part = getattr(reference.scene, part)
        result_part = getattr(result.scene, part)
        if reference_part != result_part:
            raise InputError(
                f"{reference.engine} and {result.engine} answer different questions: {part} is"
                f" {reference_part!r} in the one and {result_part!r} in the other; solve both from"
                " one scene"
            )


def _notes_on_pair(pair: Pair) -> Iterator[str]:
    """Sentences that a reader of a comparison must not miss: interpolation, instants with too light
    a load to be judged, no convergence, no steady cycle, the notes of both solutions, displacements
    that count from different places, errors of load steps that can't be told apart, no friction.

    `pair` holds reference and result. Its masks (k,): `is_in_contact` where a point carries
    pressure, `is_too_light` where also P is less than a tenth of the reference load. `effects` are
    the compliances that lead from one datum of displacements to the other, where one is needed and
    known.
    """
    from reports.charts.templating import in_template

    # field -> estimated largest error
    interpolation_errors = pair.reference_cycle.interpolation_errors
    if interpolation_errors:
        # `in_template`: the text of that name in a template, filled with these values
        yield in_template("interpolated", interpolation_errors)
    # instants in contact whose load is too light to be judged
    n_light_instants = int(pair.is_too_light.sum())
    if n_light_instants:
        # LEAST_JUDGED_SHARE_OF_LOAD: 0.1 of the reference load
        yield in_template(
            "light", n_light_instants, int(pair.is_in_contact.sum()), LEAST_JUDGED_SHARE_OF_LOAD
        )
    for solution in (pair.reference, pair.result):
        yield from _notes_on_solution(solution, is_periodic=pair.is_periodic)
    has_other_datum = pair.effects is not None or pair.lacks_common_datum
    # _DISPLACEMENT: name of the field, "tangential_displacement"
    if has_other_datum and _DISPLACEMENT not in reason_by_missing_field(pair.result):
        yield in_template("displacements", pair.effects is not None)
    if (
        pair.is_unsymmetric
        and pair.result.engine == "halfplane_fe"
        and pair.polygon_reference is None
    ):
        yield in_template("steps_not_apart")
    if not pair.result.scene.friction.coefficient:
        yield in_template("frictionless")


def _notes_on_solution(solution: ContactSolution, *, is_periodic: bool) -> Iterator[str]:
    """Sentences on one solution of a comparison: that it did not converge; that it did not reach a
    steady cycle, where the loads repeat (`is_periodic`); and its own notes, with its name.
    """
    from reports.charts.templating import in_template

    name = engine_in_words(solution.engine)
    if not solution.record.converged:
        yield f"{name}: not converged: {solution.record.message}"
    # Our finite elements note it themselves, with the change of the dissipation. An external
    # result, which has a source, holds one cycle: nothing shows whether that repeats. Theory at
    # the instants of a result that are no whole cycle has none either.
    is_noted_here = (
        solution.engine != "halfplane_fe"
        and "source" not in solution.settings
        and WHOLE_CYCLE not in solution.work.skipped
    )
    # steady_from: the first cycle that ends as it started; None if none does
    if is_periodic and solution.steady_from is None and is_noted_here:
        yield in_template("not_steady", name)
    yield from (f"{name}: {note}" for note in solution.record.notes)
