"""The page: one self-contained HTML file that works offline. Its words are in templates/report.html."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from reports import units
from reports.charts.plate import STATE_KEYS, Plate
from reports.charts.templating import script, template
from reports.comparison import Comparison, Report, words
from reports.comparison.cycles import last_cycle
from reports.comparison.metrics import bulk_work, name_of, normal_work
from reports.measured import section
from reports.page.live import as_script, carried
from reports.profile_fit import findings
from reports.units import minus


def render(
    report: Report,
    drawings: Sequence[Plate],
    command: str,
    seconds: Mapping[str, float],
    live: Mapping[str, Any] | None = None,
    third: Mapping[str, Any] | None = None,
) -> str:
    """The HTML text; every word that came from outside is escaped, and no script but the page's own may run.

    Parameters
    ----------
    drawings : the figures; one that is missing leaves its place empty
    command : what reproduces the page
    seconds : stage -> wall time
    live : what the slider moves through; without it the page has none
    third : words of the third solver, where it ran
    """
    comparison = report.comparison
    scene, said = comparison.scene, words.said(report)
    program, digest = script()
    return template("report.html").render(
        said | {"bodies": [said["bodies"], said["unlike_materials"], *findings(scene)[0]]},
        title=scene.title or scene.name,
        scene=scene,
        comparison=comparison,
        report=report,
        in_words=words,
        units=units,
        budget=_budget(report),
        notes=_notes(comparison),
        dissipations=list(_dissipations(comparison)),
        measured=section(scene, (comparison.reference, comparison.result)),
        figures={drawing.name: drawing for drawing in drawings},
        engines=[(name_of(solution.engine), solution) for solution in (comparison.reference, comparison.result)],
        flat=flat,
        command=command,
        commit=commit(),
        own=partial(words.without_cycle, scene=scene),
        third=third,
        script=program,
        script_hash=digest,
        live=as_script(dict(live) if live else {"instants": 0}),
        carried=carried(dict(live)) if live else "",
        states=STATE_KEYS,
        step_errors=list(_step_errors(comparison)),
        seconds=seconds,
    )


def commit() -> str:
    """The commit of the checkout that this package lies in, "with changes" where files differ from it; or why there is none."""
    home = Path(__file__).parents[2]
    if not (home / ".git").exists():
        return "installed without its history"
    words = ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown: git does not answer"
    return done.stdout.strip().replace("-dirty", ", with changes")


def _budget(report: Report) -> dict[str, Any] | None:
    """Where the errors come from: the columns that say something, of the headlines and of the rest."""
    if report.budget is None:
        return None
    first, others = words.rows(report.budget), words.rows(report.budget, headline=False)
    columns, both = words.narrow(words.heads(report.budget), [*first, *others])
    return {"heads": columns, "rows": both[: len(first)], "others": both[len(first) :]}


def _notes(comparison: Comparison) -> list[str]:
    """What a reader must not miss: of the metrics, then of the solutions."""
    named = [(m.label, m.note) for m in comparison.headlines if m.note]
    own = [words.sentence(note if note.lower().startswith(label.lower()) else f"{label}: {note}") for label, note in named]
    return [*own, *comparison.notes]


def _dissipations(comparison: Comparison) -> Iterator[dict[str, str]]:
    """Dissipation of each solution: both routes and every cycle."""

    def shown(value: float | None, digits: int = 8) -> str:
        """A dash for what a solution does not hold."""
        return "–" if value is None or np.isnan(value) else minus(f"{value:.{digits}g}")

    polygon = comparison.polygon_reference
    for solution in filter(None, (comparison.reference, polygon, comparison.result)):
        normal, loop, work = normal_work(solution), solution.loop_work, solution.dissipation
        yield {
            "name": name_of(solution.engine) + (", on the polygon of the steps" if solution is polygon else ""),
            "value": shown(work),
            "scaled": shown(work / comparison.scales.dissipation),
            "loop": shown(loop),
            "bulk": shown(bulk_work(last_cycle(solution), solution.scene.material)),  # of the instants that the solution has
            "normal": shown(normal),
            "apart": "–" if np.isnan(loop) or not work else minus(f"{abs((loop + (normal or 0.0)) / work - 1):.1e}"),
            "cycles": ", ".join(shown(one, 6) for one in solution.cycle_dissipation),
        }


def _step_errors(comparison: Comparison) -> Iterator[str]:
    """What W is uncertain by at least, and what friction work at the end of each step would make of it: the step's own error."""
    if said := words.uncertain_work(comparison):
        yield said
    for solution in (comparison.reference, comparison.result):
        energy = solution.record.energy
        if {"interface", "end_of_step"} <= energy.keys() and solution.dissipation > 0:
            steps = solution.last_cycle[1:]
            excess = float((energy["end_of_step"] - energy["interface"])[steps].sum()) / solution.dissipation
            yield (
                f"{name_of(solution.engine).capitalize()}: with the tractions at the end of each step instead of their mean "
                f"the interface work of the cycle would differ by {words.shown(excess)} of W."
            )


def flat(settings: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """Nested settings as one list, names joined by dots, numbers to six digits.

    >>> flat({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    found: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{above}{name}.")
        else:
            found[above + name] = f"{value:.6g}" if isinstance(value, float) else str(value)
    return found
