"""Three columns, theory, our finite elements and CalculiX, for the terminal, third.json and the page alike."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from reports.comparison import Comparison
from reports.comparison.content import strict
from reports.comparison.words import percent, value_of
from reports.third.opinion import ThirdOpinion
from reports.units import energy_unit, number, units
from scenes import ContactSolution

HEADLINES = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")
_MOST = "the largest of the last cycle"


def heads(opinion: ThirdOpinion) -> tuple[str, str, str, str]:
    """Titles of the columns."""
    return ("quantity", "half-plane theory", "our finite elements", opinion.code)


def figures(comparison: Comparison) -> list[tuple[str, str, Callable[[ContactSolution], float]]]:
    """Name, unit and function of the figures that all three have."""
    _, length, stress = units(comparison.scene)
    return [
        ("work of friction, last cycle", energy_unit(comparison.scene), lambda s: s.dissipation),
        (f"pressure, {_MOST}", stress, lambda s: float(s.pressure[s.last_cycle].max())),
        (f"shear, {_MOST}", stress, lambda s: float(np.abs(s.shear[s.last_cycle]).max())),
        (f"contact half-width, {_MOST}", length, lambda s: float(np.nanmax(s.contact_half_width[s.last_cycle]))),
    ]


def rows(comparison: Comparison, opinion: ThirdOpinion) -> list[tuple[str, str, str, str]]:
    """The lines of the table: figures of each, then how far each is from theory, then time."""
    theirs = opinion.comparison
    solutions = (comparison.reference, comparison.result, theirs.result if theirs else None)
    lines = []
    for name, unit, figure in figures(comparison):
        values = [None if solution is None else figure(solution) for solution in solutions]
        lines.append((f"{name} [{unit}]", *("–" if v is None or not math.isfinite(v) else number(v) for v in values)))
    for key in HEADLINES:
        metric = comparison.metric(key)
        theirs_too = value_of(theirs.metric(key)) if theirs else "–"
        lines.append((f"{metric.label}: off by", "reference", value_of(metric), theirs_too))
    seconds = (comparison.reference, comparison.result)
    spent = [f"{sum(s.work.seconds.values()):.2f}" if s.work.seconds else "–" for s in seconds]
    lines.append(("time [s]", *spent, f"{opinion.done.seconds:.1f}" if opinion.done else "–"))
    return lines  # type: ignore[return-value]


def sentences(opinion: ThirdOpinion) -> list[str]:
    """What must stand beside the numbers: failure or how the run went, then the limits."""
    size = f"{opinion.deck.reference} nodes, {len(opinion.deck.time) - 1} instants"
    if opinion.done is None:
        told = f"{opinion.code} gave no answer ({size}): {opinion.failure}."
    else:
        done = opinion.done
        told = f"{opinion.code} on the exported deck: {size}, {done.increments} increments, {done.iterations} iterations."
    return [told, *opinion.limits]


def page_words(comparison: Comparison, opinion: ThirdOpinion) -> dict[str, Any]:
    """What the page's block is filled with."""
    notes = list(opinion.comparison.result.record.notes) if opinion.comparison else []
    guesses = list(opinion.guesses)
    said = sentences(opinion)
    return {
        "heads": heads(opinion),
        "rows": rows(comparison, opinion),
        "told": said[0],
        "failed": bool(opinion.failure),
        "limits": said[1:],
        "notes": [*guesses, *notes],
    }


def as_json(comparison: Comparison, opinion: ThirdOpinion) -> str:
    """third.json: the table in numbers; strict JSON."""
    theirs = opinion.comparison
    known = {metric.key: metric.value for metric in theirs.metrics} if theirs else {}
    content = {
        "format": "halfplane third opinion 1",
        "code": opinion.code,
        "failure": opinion.failure or None,
        "deck": {
            "settings": asdict(opinion.deck.settings),
            "nodes": opinion.deck.reference,
            "instants": len(opinion.deck.time) - 1,
            "element_size": opinion.deck.element_size,
            "stiffness": opinion.deck.stiffness,
            "stick_slope": opinion.deck.stick_slope,
        },
        "run": asdict(opinion.done) if opinion.done else None,
        "figures": {
            name: {
                "unit": unit,
                "theory": figure(comparison.reference),
                "ours": figure(comparison.result),
                "third": figure(theirs.result) if theirs else None,
            }
            for name, unit, figure in figures(comparison)
        },
        "metrics": {metric.key: {"ours": metric.value, "third": known.get(metric.key)} for metric in comparison.metrics},
        "limits": opinion.limits,
        "notes": list(theirs.result.record.notes) + list(opinion.guesses) if theirs else [],
    }
    return json.dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False) + "\n"


def apart(comparison: Comparison, opinion: ThirdOpinion) -> str:
    """One sentence: how far both are from theory in the work of friction."""
    if opinion.comparison is None:
        return sentences(opinion)[0]
    ours, theirs = (c.metric("dissipation") for c in (comparison, opinion.comparison))
    if ours.value is None or theirs.value is None or ours.absolute:
        return sentences(opinion)[0]
    return f"Off theory's work of friction by {percent(ours.value)} (ours) and {percent(theirs.value)} ({opinion.code})."
