"""What was compared: two solutions of one scene side by side, every metric with its uncertainty and
verdict.

Offered to the rest of reports, `Comparison` `Report` `ThirdAnswer` `UnscoredFile` `compare`
first:

    metrics.py      the last cycle of a solution, on the points of another: `Cycle` `last_cycle`
                    `Event` `events` `OF_BULK`; the metrics, one table of words, needs, functions,
                    tolerances: `METRICS` `Metric` `missing` `norm` `over` `shares` `scales`
                    `tolerances_of` `WHOLE_CYCLE`; `Verdict` `verdict_on`; `are_half_planes`
                    `name_of` `compliance` `energy_scale` `bulk_strain` `bulk_strains` `bulk_work`
                    `loop_work` `normal_work`
    laws.py         the laws of contact that an answer obeys, whoever is right: `Certificate`
                    `certificates` `LIMIT` `DERIVED` `derived`; the numbers of a solution:
                    `QUANTITIES` `OF_UNSYMMETRIC`; those that its scene expects: `Finding`
                    `expected_numbers` `expected_content` `expected_rows` `EXPECTED_HEADS`
    budget.py       where the error of each metric comes from: mesh, steps, penalty, far field,
                    idealisation: `ErrorBudget` `Budget` `error_budget` `with_budget` `climb`
                    `coarser` `finer_steps` `mesh_ratio` `theory_on_steps` `ROUNDING`; the
                    mesh-refinement study of one value, its order and value at size zero:
                    `Refinement` `Extrapolation` `extrapolate`
    words.py        all of that in sentences, whose words are in templates/words.txt: `headline`
                    `lead` `verdict` `how_judged` `standing` `uncertain_work` `question`
                    `bodies_in_words` `bulk_and_tilt` `unlike_materials` `idealisation`
                    `SUPPORT_WORDS` `sentence` `read_in_words` `cost` `stretch`; in cells:
                    `amount` `value_of` `with_uncertainty` `shown_unit` `first_cells` `first_rows`
                    `summary_rows` `budget_table`; and as JSON: `as_json` `whole_content`
                    `solution_content` `strict`
    findings.py     what two runs, or a run and a baseline, differ by: `Findings` `read_findings`
                    `of_content` `of_solution` `difference` `Difference` `Row` `SAME` `COUNTS`
                    `SOLUTION` `is_baseline` `write_baseline` `patterned_tolerances`
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from reports.comparison.cycles import last_cycle, sample, sample_instants
from reports.comparison.dimensionless import scales
from reports.comparison.laws import Certificate, certificates
from reports.comparison.metrics import METRICS, Metric, judge, missing, tolerances_of
from reports.comparison.pairs import LIGHT, Pair, are_half_planes, name_of
from reports.comparison.verdicts import Verdict
from scenes import ContactSolution, InputError, Scene

if TYPE_CHECKING:
    from reports.comparison.budget import ErrorBudget
    from reports.scoring.diagnosis import Diagnosis
    from reports.scoring.study import Study


@dataclass(frozen=True, eq=False)
class Comparison(Pair):
    """Reference and result side by side, with the verdict.

    Attributes
    ----------
    reference, result : the two solutions
    polygon_reference : the reference's answer on the very polygon that the result stepped through,
    or None plain_reference : the reference as it is, where `reference` follows a rule of the
    result; else the same scales : what makes it dimensionless
    expected, found : last cycle of the reference (on the result's points and instants) and of the
    result metrics : in the order of the table
    reference_certificates, result_certificates : the laws of contact, needing no reference
    notes : everything that a reader must not miss
    """

    metrics: tuple[Metric, ...]
    reference_certificates: tuple[Certificate, ...]
    result_certificates: tuple[Certificate, ...]
    notes: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The question."""
        return self.result.scene

    @property
    def verdict(self) -> Verdict | None:
        """Outside if one metric is, else undecided if one is, else within; None where no tolerance
        judges any.
        """
        found = {metric.verdict for metric in self.metrics}
        return next(
            (one for one in (Verdict.OUTSIDE, Verdict.UNDECIDED, Verdict.WITHIN) if one in found),
            None,
        )

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
        """The metrics that have a tolerance and no value, for want of what they need."""
        return tuple(
            metric for metric in self.metrics if metric.lacking and metric.tolerance is not None
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

    def __repr__(self) -> str:
        """Who was compared, and the table of `summary`."""
        return f"Comparison of {self.result.engine} with {self.reference.engine}\n{self.summary()}"

    def _repr_html_(self) -> str:
        """For a notebook."""
        return Report(self)._repr_html_()

    def metric(self, key: str) -> Metric:
        """The metric of that key; KeyError for an unknown one."""
        return {metric.key: metric for metric in self.metrics}[key]

    def summary(self) -> str:
        """The first table of the page as text: theory, finite elements, difference with its
        uncertainty, verdict; in units.
        """
        return Report(self).summary()


@dataclass(frozen=True)
class UnscoredFile:
    """A file of a folder of results that could not be scored.

    Attributes
    ----------
    name : of the file, as it lies in the folder
    reason : why, naming the file
    """

    name: str
    reason: str

    @property
    def sentence(self) -> str:
        """The sentence for a reader."""
        return f"Not scored: {self.reason}."


class ThirdAnswer(Protocol):
    """What a page and the command line ask of the answer of a third solver, or of its failure.

    Attributes
    ----------
    text : the input that it was run on
    comparison : its answer against half-plane theory; None where it failed
    failure : the sentence, "" where it did not
    heads : titles of the columns of its table, of which `rows` gives the lines
    sentences : what must stand beside the table
    """

    @property
    def text(self) -> str: ...
    @property
    def comparison(self) -> Comparison | None: ...
    @property
    def failure(self) -> str: ...
    @property
    def heads(self) -> tuple[str, ...]: ...
    @property
    def sentences(self) -> list[str]: ...

    def rows(self, comparison: Comparison) -> list[tuple[str, ...]]:
        """The table: values of all three solvers, then errors, then time."""
        ...

    def page_words(self, comparison: Comparison) -> dict[str, Any]:
        """What the page's block is filled with."""
        ...

    def as_json(self, comparison: Comparison) -> str:
        """The table in numbers, as strict JSON."""
        ...


@dataclass(frozen=True, eq=False)
class Report:
    """What a page is written of: a comparison, and what was worked out from it.

    Attributes
    ----------
    comparison : what was compared; its metrics have the uncertainties of the budget
    budget : where the error of every metric comes from, where that was measured
    guesses : what was taken for granted of somebody else's result, to be read before anything else
    diagnoses : the likely causes of somebody else's difference, the strongest first
    study : what the result's own coarser meshes say, where it came as a folder of them
    third : the answer of another code to the same scene
    unscored : files of the folder of results that could not be scored
    """

    comparison: Comparison
    budget: ErrorBudget | None = None
    guesses: tuple[str, ...] = ()
    diagnoses: tuple[Diagnosis, ...] = ()
    study: Study | None = None
    third: ThirdAnswer | None = None
    unscored: tuple[UnscoredFile, ...] = ()

    def __repr__(self) -> str:
        """Who was compared, and the table of `summary`."""
        comparison = self.comparison
        return (
            f"Report on {comparison.result.engine} against"
            f" {comparison.reference.engine}\n{self.summary()}"
        )

    @property
    def honest(self) -> str:
        """Whether the stated uncertainties cover the known errors, in words."""
        return (
            "not assessed: the run was made without a budget"
            if self.budget is None
            else self.budget.honest
        )

    @property
    def passed(self) -> bool:
        """Whether the comparison is accurate and admissible, and nothing with a tolerance is
        unscored.
        """
        return self.comparison.passed

    def metric(self, key: str) -> Metric:
        """The metric of that key; KeyError for an unknown one."""
        return self.comparison.metric(key)

    def summary(self) -> str:
        """The first table of the page as text."""
        from reports.comparison.words import summary

        return summary(self)

    def _repr_html_(self) -> str:
        """For a notebook."""
        from reports.charts.templating import template
        from reports.comparison import words

        heads, rows = words.first_cells(self)
        scene, last = (
            self.comparison.scene,
            " ".join((words.lead(self), words.verdict(self), words.how_judged(self))),
        )
        answer = {"headline": words.headline(self), "heads": heads, "rows": rows, "last": last}
        return template("notebook.html").render(answer, title=scene.title or scene.name)


def compare(
    reference: ContactSolution,
    result: ContactSolution,
    *,
    polygon_reference: ContactSolution | None = None,
    scales_from: ContactSolution | None = None,
    plain_reference: ContactSolution | None = None,
    tolerances: Mapping[str, float] | None = None,
) -> Comparison:
    """How far `result` is from `reference` in the last cycle, metric by metric.

    Parameters
    ----------
    reference : the answer taken for true; best on the points and instants of `result`, otherwise it
        is interpolated and the interpolation error stated in the notes
    result : the answer judged
    polygon_reference : the reference on the straight steps between the result's instants, which
        sets the error of the steps apart from all others
    plain_reference : the reference as it is, where `reference` has states, edges and dissipation by
        the rule of the result: what the first table shows of it; `reference` if None
    scales_from : what the scales are read off, where the reference holds few instants; the
    reference if None tolerances : key of a metric -> largest |E| admitted, before those of the
    scene; where neither says anything, the tolerances
        of the project's own engines judge bodies for which half-plane theory is exact, and real
        bodies are not judged

    Raises
    ------
    InputError
        If the two (or three) answer different questions or hold no whole cycle, or a tolerance is
        of no metric.

    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> exact = semi_analytic.solve(load_scene("cattaneo-mindlin"))
    >>> compare(exact, exact).metric("dissipation").value
    0.0
    """
    for key in tolerances or {}:
        if key not in METRICS:
            raise InputError(
                f"tolerances: {key!r} is no metric; the metrics are {', '.join(METRICS)}"
            )
    for other in (reference, *([polygon_reference] if polygon_reference else [])):
        _refuse_other_question(other, result)
    found = last_cycle(result)
    expected = (
        sample(last_cycle(reference), found, reference.engine)
        if found.whole
        else sample_instants(reference, found)
    )
    pair = Pair(
        reference,
        result,
        polygon_reference,
        plain_reference or reference,
        scales(scales_from or reference),
        expected,
        found,
    )
    return Comparison(
        **{name: getattr(pair, name) for name in Pair.__dataclass_fields__},
        metrics=judge(pair, tolerances_of(result.scene, are_half_planes(result.scene), tolerances)),
        reference_certificates=certificates(reference),
        result_certificates=certificates(result),
        notes=tuple(_notes(pair)),
    )


def _refuse_other_question(reference: ContactSolution, result: ContactSolution) -> None:
    for part in ("material", "profile", "friction", "load"):
        theirs, ours = getattr(reference.scene, part), getattr(result.scene, part)
        if theirs != ours:
            raise InputError(
                f"{reference.engine} and {result.engine} answer different questions: {part} is"
                f" {theirs!r} in the one and {ours!r} in the other; solve both from one scene"
            )


def _notes(pair: Pair) -> Iterator[str]:
    """What a reader must not miss, as sentences."""
    from reports.charts.templating import in_template

    scene, solutions = pair.result.scene, (pair.reference, pair.result)
    if errors := pair.expected.interpolation:
        yield in_template("interpolated", errors)
    if light := int((pair.touching & ~pair.judged).sum()):
        yield in_template("light", light, int(pair.touching.sum()), LIGHT)
    for solution in solutions:
        name = name_of(solution.engine)
        if not solution.record.converged:
            yield f"{name}: not converged: {solution.record.message}"
        # Our finite elements note it themselves, with how the dissipation changes.
        if (
            solution.steady_from is None
            and pair.periodic
            and solution.engine != "halfplane_fe"
            and not missing(solution)
        ):
            yield in_template("not_steady", name)
        yield from (f"{name}: {note}" for note in solution.record.notes)
    if not scene.bodies.half_planes and "tangential_displacement" not in missing(pair.result):
        yield in_template("displacements")
    if pair.unsymmetric and pair.result.engine == "halfplane_fe" and pair.polygon_reference is None:
        yield in_template("steps_not_apart")
    if not scene.friction.coefficient:
        yield in_template("frictionless")
