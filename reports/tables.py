"""The tables of a run on the terminal: verdict, budget, third opinion, expected numbers, fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from reports.application import OUTSIDE, WITHIN
from reports.console import complain, say, show_table
from scenes import ContactSolution, Scene

if TYPE_CHECKING:
    from reports.comparison import Comparison
    from reports.comparison import Report as Found
    from reports.fields_job import FieldsReport
    from reports.jobs import Report

# A series of more instants than this is told by the one with the largest stress.
_ROWS = 12
_STYLES = {"within": "bold green", "outside": "bold red", "undecided": "bold yellow"}


def show_verdict(report: Found) -> None:
    """The headline, the table of absolute values, and the verdict in a sentence."""
    from reports.comparison.words import first_table, headline, how_judged, lead, standing, verdict

    scene = report.comparison.scene
    heads, rows = first_table(report)
    keys = ("label", "reference", "result", "difference", "verdict")
    say(headline(report), "bold")
    show_table(scene.title or scene.name, heads, [tuple(row[key] for key in keys) for row in rows], right=(1, 2, 3))
    say(f"{lead(report)} {verdict(report)}".strip(), _STYLES.get(standing(report.comparison) or "", ""))
    if words := how_judged(report):
        say(words)


def exit_code(comparison: Comparison) -> int:
    """0 if the comparison passed, else 1; where that is for undecided metrics alone, the last line on stderr says so."""
    from reports.comparison.words import standing

    if standing(comparison) == "undecided":
        keys = ", ".join(metric.key for metric in comparison.metrics if metric.verdict == "undecided")
        complain(f"halfplane: {comparison.scene.name}: undecided: {keys}; this counts as outside: exit code {OUTSIDE}")
    return WITHIN if comparison.passed else OUTSIDE


def show_notes(comparison: Comparison) -> None:
    """What the dissipation of the finite elements is uncertain by, and what these say of their answer."""
    from reports.comparison.words import uncertain_work

    if words := uncertain_work(comparison):
        say(words)
    for note in comparison.result.record.notes:
        say(f"Note: {note}.")


def show_budget(report: Found) -> None:
    """Where the errors come from, if that was measured."""
    if report.budget is None:
        return
    from reports.comparison.words import cost, heads, narrow, rows

    columns, lines = narrow(heads(report.budget, full=False), rows(report.budget, full=False))
    show_table("Where the discrepancy comes from", columns, lines, right=range(1, len(columns) - 1))
    say(f"Honest: {report.honest}")
    say(cost(report.budget))


def show_third(report: Report) -> None:
    """Theory, our finite elements and another code, if that was asked."""
    if report.third is None:
        return
    from reports.third.words import heads, rows, sentences

    show_table("A third opinion", heads(report.third), rows(report.comparison, report.third), right=(1, 2, 3))
    for sentence in sentences(report.third):
        say(sentence)


def show_expected(scene: Scene, solutions: Sequence[ContactSolution]) -> bool:
    """The numbers that the scene expects beside those found; whether all are met."""
    from reports.comparison import expected

    findings = list(expected.check(scene, solutions))
    if findings:
        show_table("Expected numbers", expected.HEADS, expected.rows(findings), right=(2, 3, 4, 5))
        missed = sum(not finding.met for finding in findings)
        say(
            f"{missed} of {len(findings)} expected numbers are missed."
            if missed
            else f"All {len(findings)} expected numbers are met."
        )
    return all(finding.met for finding in findings)


def show_fields(scene: Scene, report: FieldsReport) -> None:
    """The instants with their largest nodal stress, the largest of all where they are many, and what was written."""
    from reports.fields import NO_PEAK
    from reports.units import load_unit, number, units

    _, length, stress = units(scene)
    load = load_unit(scene)
    many = len(report.instants) > _ROWS
    shown = [max(report.instants, key=lambda one: one.von_mises.value)] if many else report.instants
    rows = []
    for one in shown:
        largest = [
            f"{number(found.value)} at ({', '.join(number(float(f'{place:.3g}')) for place in found.place)}), {found.body}"
            for found in (one.von_mises, one.tension)
        ]
        rows.append((one.instant.label, *map(number, (one.time, one.normal_load, one.tangential_load)), *largest))
    heads = ("instant", "time", f"P [{load}]", f"Q [{load}]", f"nodal von Mises [{stress}]", f"nodal tension, no peak [{stress}]")
    show_table(scene.title or scene.name, heads, rows, right=(1, 2, 3))
    say(f"places (x, y) in {length}, on the undeformed bodies; tension is the largest principal stress")
    say(NO_PEAK)
    if many:
        say(f"shown: of {len(report.instants)} instants the one with the largest stress; all are in fields/fields.json")
    for note in report.notes:
        say(note)
    counts = {kind: sum(name.endswith(kind) for name in report.files) for kind in (".vtu", ".png")}
    films = [name for name in report.files if name.startswith("animation/")]
    film = f", {' and '.join(films)}" if films else ""
    say(f"written: {counts['.vtu']} VTU files, {counts['.png']} pictures{film}, and what they are in fields/fields.json")
