"""What a page is written of: a comparison, and what was worked out from it beside it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

from reports.comparison import Comparison
from reports.comparison.laws import Verdict
from reports.comparison.words import headline_sentence, notebook_html, summary_in_five_lines
from scenes.measured import ReadAs

if TYPE_CHECKING:
    from reports.comparison.budget import ErrorBudget
    from reports.comparison.metrics import Metric
    from reports.inputs import InputEffects
    from reports.scoring.evidence import EvidenceStep
    from reports.scoring.study import MeshStudy, UnscoredFile
    from reports.scoring.traces import Diagnosis
    from reports.validation import AgainstMeasurement


class ThirdAnswer(Protocol):
    """What a page and the command line ask of the answer of a third solver, or of its failure.

    Attributes
    ----------
    text
        the input that it was run on
    comparison
        its answer against half-plane theory; None where it failed
    failure
        the sentence, "" where it did not
    heads
        titles of the columns of its table, of which `rows` gives the lines
    sentences
        what must stand beside the table
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

    def rows(self, comparison_of_elements: Comparison) -> list[tuple[str, ...]]:
        """The table: values of all three solvers, then errors, then time."""
        ...

    def page_words(self, comparison_of_elements: Comparison) -> dict[str, Any]:
        """What the page's block is filled with."""
        ...

    def as_json(self, comparison_of_elements: Comparison) -> str:
        """The table in numbers, as strict JSON."""
        ...


@dataclass(frozen=True, eq=False)
class Report:
    """What a page is written of: a comparison, and what was worked out from it.

    Attributes
    ----------
    comparison
        what was compared; its metrics have the uncertainties of the budget
    budget
        where the error of every metric comes from, where that was measured
    guesses
        what was assumed of an external result, to be read before anything else
    evidence
        what the rows of an external result show, in the order in which it is looked at
    diagnoses
        the likely causes of the difference of an external result, the strongest first
    study
        what the result's own coarser meshes show, where it came as a folder of them
    third
        the answer of another code to the same scene
    unscored
        files of the folder of results that could not be scored
    inputs
        what the stated uncertainties of the inputs make of theory and of the difference; None where
        none is stated
    validation
        values of a scored result, which may be measured, against theory
    is_measured
        whether the result was said to be a measurement
    """

    comparison: Comparison
    budget: ErrorBudget | None = None
    guesses: tuple[str, ...] = ()
    diagnoses: tuple[Diagnosis, ...] = ()
    study: MeshStudy | None = None
    third: ThirdAnswer | None = None
    unscored: tuple[UnscoredFile, ...] = ()
    inputs: InputEffects | None = None
    validation: tuple[AgainstMeasurement, ...] = ()
    is_measured: bool = False
    evidence: tuple[EvidenceStep, ...] = ()

    def __repr__(self) -> str:
        """Five lines, as those of its comparison."""
        return summary_in_five_lines(self.comparison, "Report")

    @property
    def read_as(self) -> ReadAs:
        """How the file of an external result was read, where it is a text table: its layout,
        then what became of each column.
        """
        pairs = self.comparison.result.settings.get("read_as", ())
        return tuple((name, words) for name, words in pairs)

    def is_covered(self, metric: Metric) -> bool | None:
        """Whether the stated uncertainty of a metric covers its known error; None where the error
        is not known, or there is no budget.
        """
        if self.budget is None:
            return None
        for budget_of_metric in self.budget.budgets:
            if budget_of_metric.metric.key == metric.key:
                return budget_of_metric.is_covered
        return None

    @property
    def are_headlines_covered(self) -> bool | None:
        """Whether every stated uncertainty of the page's first table covers the known error; None
        where no error is known, or there is no budget.
        """
        answers = {self.is_covered(metric) for metric in self.comparison.headlines}
        return None if answers == {None} else False not in answers

    @property
    def coverage_in_words(self) -> str:
        """Whether the stated uncertainties cover the known errors, in words."""
        return (
            "not assessed: the run was made without a budget"
            if self.budget is None
            else self.budget.coverage_in_words
        )

    @property
    def first_sentence(self) -> str:
        """The first sentence of a report: what differs and by how much. Of an external result also
        its likely causes, or that none was found, and then which metrics are within tolerance.

        `comparison.headlines` are its main metrics, each with its verdict; `diagnoses` are the
        likely causes, empty for other results.
        """
        sentence = headline_sentence(self.comparison)
        if not self.diagnoses:
            return sentence
        labels_within_tolerance = [
            metric.label.lower()
            for metric in self.comparison.headlines
            if metric.verdict is Verdict.WITHIN
        ]
        causes = " and ".join(diagnosis.name_and_size for diagnosis in self.diagnoses)
        agreement_in_words = ""
        if labels_within_tolerance:
            agreement_in_words = f"; within tolerance: {', '.join(labels_within_tolerance)}"
        return f"{sentence.removesuffix('.')}; cause: {causes}{agreement_in_words}."

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
        return self.comparison.summary()

    def _repr_html_(self) -> str:
        """For a notebook."""
        return notebook_html(self.comparison, has_budget=self.budget is not None)


def with_budget(comparison: Comparison, budget: ErrorBudget) -> Report:
    """A report of `comparison` with its budget, every metric with the uncertainty that it is judged
    with.
    """
    judged_by_key = {entry.metric.key: entry.metric_with_uncertainty for entry in budget.budgets}
    metrics = tuple(judged_by_key.get(metric.key, metric) for metric in comparison.metrics)
    return Report(replace(comparison, metrics=metrics), budget)
