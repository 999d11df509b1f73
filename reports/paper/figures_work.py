"""Figures 6, 7, 9 and 10 of the paper: where and how much a cycle dissipates."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from reports.charts.marks import Mark
from reports.charts.plate import Panel, Plate
from reports.paper.cases import Paper, Sweep, total
from reports.paper.plots import FAMILY, axes, line, named, plate

_PHASES = {"IJ": "forward, I–J", "JM": "forward, J–M", "EG": "reverse, E–G"}


def figure_6(paper: Paper) -> Plate:
    """W(x) of the Hertzian contact."""
    return _pointwise(
        paper,
        0,
        "figure_06",
        "Figure 6. Pointwise dissipation W(x), Hertz",
        "W(x) leaves the stick edge with zero slope (as the distance to the power 3/2) and meets the outer edge with a finite one "
        "(as the distance).",
    )


def figure_9(paper: Paper) -> Plate:
    """W(x) of the flat and rounded contact."""
    return _pointwise(
        paper,
        1,
        "figure_09",
        "Figure 9. Pointwise dissipation W(x), flat and rounded (b/a(P₀) = 0.505)",
        "All work is done within the rounded edges, in a narrower band than for Hertz.",
    )


def _pointwise(paper: Paper, number: int, name: str, title: str, caption: str) -> Plate:
    case, peak = (paper.hertz, paper.rounded)[number], paper.peaks[number]
    inner, outer = case.stick_edge, case.outer_edge
    zone = inner + (outer - inner) * (1 - np.cos(np.linspace(0, np.pi, 241))) / 2
    x = np.concatenate([[0.95 * inner], zone, [outer + 0.05 * inner]])
    phases = case.density(x)
    whole = total(phases)
    place, top = float(peak.place) / case.length, float(peak.value) * case.length / case.work_unit
    parts: list[Mark] = [line(x, whole, "whole cycle", "bold")]
    for (phase, label), look in zip(_PHASES.items(), ("c1 dash", "c4 dashdot", "c0 dot"), strict=True):
        parts.append(line(x, phases[phase], label, look))
    parts += [line(np.full(2, edge), np.array([0.0, 1.12 * top]), "", "faint dot fine") for edge in (inner, outer)]
    share = float(peak.fraction)
    parts += [
        *named(inner, 1.12 * top, f"stick edge {inner:.3f}", (42.0, 6.0), css="tick"),
        *named(outer, 1.12 * top, f"edge of contact {outer:.3f}", (-50.0, 6.0), css="tick"),
        *named(place, top, f"{share:.1%} of the way", (0.0, 10.0), dot=True),
    ]
    across, up = axes((0.95 * inner, outer + 0.05 * inner, "x / a(P₀)"), (0.0, 1.22 * top, "W(x) · a(P₀) / (A f² P₀²)"))
    panel = Panel(name, across, up, parts, "Pointwise dissipation over x", 640.0, 400.0)
    return plate(
        name,
        title,
        f"{caption} The peak lies {share:.1%} of the way from the stick edge to the largest contact, at x = {place:.4f} a(P₀). "
        "Work of one steady cycle per area, A = 2/E*; the parts are the phases of slip between the letters of figure 2.",
        "Pointwise dissipation over x with its parts in forward and reverse slip and the place of the peak.",
        [panel],
        {"x / a(P0)": x, "W a(P0)/(A f^2 P0^2)": whole} | {f"in {phase}": phases[phase] for phase in _PHASES},
    )


def figure_7(paper: Paper) -> list[Plate]:
    """Global dissipation and peak of the Hertzian contact over P0/P1 and f."""
    return [
        _swept(
            paper.sweeps[0],
            "figure_07a",
            "Figure 7a. Global dissipation of a cycle, Hertz",
            "work",
        ),
        _swept(
            paper.sweeps[0],
            "figure_07b",
            "Figure 7b. Peak of the pointwise dissipation, Hertz",
            "peak",
        ),
    ]


def figure_10(paper: Paper) -> list[Plate]:
    """The same of the flat and rounded contact, Hertz in thin lines."""
    ratio = "(b/a(P₀) = 0.505)"
    hertz, rounded = paper.sweeps
    return [
        _swept(
            rounded,
            "figure_10a",
            f"Figure 10a. Global dissipation of a cycle, flat and rounded {ratio}",
            "work",
            hertz,
        ),
        _swept(
            rounded,
            "figure_10b",
            f"Figure 10b. Peak of the pointwise dissipation, flat and rounded {ratio}",
            "peak",
            hertz,
        ),
    ]


def _swept(sweep: Sweep, name: str, title: str, what: str, other: Sweep | None = None) -> Plate:
    """Curves of one quantity over P0/P1, one for each f; another sweep in pale lines beneath."""
    label = {"work": "W / (A P₁²)", "peak": "max W(x) · a(P₀) / (A P₁²)"}[what]
    parts: list[Mark] = []
    if other is not None:
        for number, ratio in enumerate(other.ratio):
            parts.append(line(ratio, getattr(other, what)[number], "" if number else "Hertz, same f", "faint solid fine"))
    parts += list(_family(sweep, what))
    values = [getattr(each, what) for each in (sweep, other) if each is not None]
    largest = max(float(value.max()) for value in values)
    across, up = axes((1.0, float(sweep.ratio.max()), "P₀ / P₁"), (0.0, 1.08 * largest, label))
    panel = Panel(name, across, up, parts, f"{label} over P₀/P₁", 620.0, 400.0)
    table = {f"P0/P1, f = {f:g}": sweep.ratio[k] for k, f in enumerate(sweep.frictions)}
    table |= {f"{what}, f = {f:g}": getattr(sweep, what)[k] for k, f in enumerate(sweep.frictions)}
    words = {
        "work": "Work of one steady cycle of the whole contact per thickness.",
        "peak": "Largest work of one steady cycle per area.",
    }[what]
    return plate(
        name,
        title,
        f"{words} Circles (Q₁ = P₁, φ = 90°) about Q₀ = 0, P₁ and a(P₀) constant, A = 2/E*. Dots: gross sliding, P₀/P₁ = √(1 + "
        "f²)/f.",
        f"{label} over P0/P1 for four coefficients of friction, falling from the sliding limit.",
        [panel],
        table,
    )


def _family(sweep: Sweep, what: str) -> Iterator[Mark]:
    for number, f in enumerate(sweep.frictions):
        values = getattr(sweep, what)[number]
        yield line(sweep.ratio[number], values, f"f = {f:g}", FAMILY[number])
        yield from named(float(sweep.ratio[number, 0]), float(values[0]), "", look=f"{number}", dot=True)
