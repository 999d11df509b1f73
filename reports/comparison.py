"""From two solutions to a verdict: every metric with its tolerance, its worst instant and its definition."""

from __future__ import annotations

from dataclasses import dataclass

from reports import metrics
from reports.certificates import Certificate, certificates
from reports.metrics import Scales
from reports.sampling import Cycle, last_cycle, sample
from reports.verdicts import Metric, of_the_cycle, through_the_cycle
from scenes import ContactSolution, InputError, Scene


@dataclass(frozen=True, eq=False)
class Comparison:
    """Reference and result side by side, with the verdict.

    Attributes
    ----------
    reference, result : the two solutions
    polygon_reference : the reference's answer on the very polygon that the result stepped through, or None
    scales : what makes it dimensionless
    expected, found : last cycle of the reference (on the result's points and instants) and of the result
    metrics : in the order of the table
    reference_certificates, result_certificates : the laws of contact, needing no reference
    honest : what can be said of the stated uncertainty
    notes : everything that a reader must not miss
    """

    reference: ContactSolution
    result: ContactSolution
    polygon_reference: ContactSolution | None
    scales: Scales
    expected: Cycle
    found: Cycle
    metrics: tuple[Metric, ...]
    reference_certificates: tuple[Certificate, ...]
    result_certificates: tuple[Certificate, ...]
    notes: tuple[str, ...]
    honest: str = "not assessed: no error estimate yet"

    @property
    def scene(self) -> Scene:
        """The question."""
        return self.result.scene

    @property
    def accurate(self) -> bool:
        """Whether no metric is outside its tolerance."""
        return all(metric.accurate is not False for metric in self.metrics)

    @property
    def admissible(self) -> bool:
        """Whether both solutions obey every law of contact that was checked."""
        return all(check.holds for check in (*self.reference_certificates, *self.result_certificates))

    @property
    def passed(self) -> bool:
        """Accurate and admissible."""
        return self.accurate and self.admissible

    def metric(self, key: str) -> Metric:
        """The metric of that key; KeyError for an unknown one."""
        return {metric.key: metric for metric in self.metrics}[key]


def compare(reference: ContactSolution, result: ContactSolution, *, polygon_reference: ContactSolution | None = None) -> Comparison:
    """How far `result` is from `reference` in the last cycle, metric by metric, against the scene's tolerances.

    Parameters
    ----------
    reference : the answer taken for true; best on the points and instants of `result`, otherwise it is interpolated
        and the interpolation error stated in the notes
    result : the answer judged
    polygon_reference : the reference on the straight steps between the result's instants, which sets the error of
        the steps apart from all others

    Raises
    ------
    InputError
        If the two (or three) answer different questions or hold no whole cycle.

    >>> import semi_analytic
    >>> from scenes import load_scene
    >>> exact = semi_analytic.solve(load_scene("cattaneo-mindlin"))
    >>> compare(exact, exact).metric("dissipation").value
    0.0
    """
    for other in (reference, *([polygon_reference] if polygon_reference else [])):
        _refuse_other_question(other, result)
    found = last_cycle(result)
    expected = sample(last_cycle(reference), found, reference.engine)
    scales = metrics.scales(reference)
    return Comparison(
        reference=reference,
        result=result,
        polygon_reference=polygon_reference,
        scales=scales,
        expected=expected,
        found=found,
        metrics=(
            *through_the_cycle(expected, found, scales, result),
            *of_the_cycle(reference, result, polygon_reference, expected, found, scales),
        ),
        reference_certificates=certificates(reference),
        result_certificates=certificates(result),
        notes=_notes(reference, result, expected),
    )


def _refuse_other_question(reference: ContactSolution, result: ContactSolution) -> None:
    for part in ("material", "profile", "friction", "load"):
        theirs, ours = getattr(reference.scene, part), getattr(result.scene, part)
        if theirs != ours:
            raise InputError(
                f"{reference.engine} and {result.engine} answer different questions: {part} is {theirs!r} in the one "
                f"and {ours!r} in the other; solve both from one scene"
            )


def _notes(reference: ContactSolution, result: ContactSolution, expected: Cycle) -> tuple[str, ...]:
    notes: list[str] = []
    if expected.interpolation:
        errors = ", ".join(f"{name.replace('_', ' ')} {value:.1e}" for name, value in expected.interpolation.items())
        notes.append(
            f"The reference is not on the result's points and instants and was interpolated; error of the "
            f"interpolation, at most, over the largest value: {errors}."
        )
    for solution in (reference, result):
        if not solution.record.converged:
            notes.append(f"{solution.engine} did not converge: {solution.record.message}")
        if solution.steady_from is None and solution.scene.load.path().period is not None:
            notes.append(f"{solution.engine}: no cycle repeats yet, so the last cycle still holds some of the way in.")
        notes.extend(f"{solution.engine}: {note}" for note in solution.record.notes)
    if not result.scene.friction.coefficient:
        notes.append("Frictionless scene: shear and dissipation are over p and A P^2, without f.")
    return tuple(notes)
