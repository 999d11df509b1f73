"""Error against CPU time of half-plane theory: its rule, plain quadrature, straight steps, and a naive discretised half-plane."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mpmath as mp
import semi_analytic_precision as theory
from semi_analytic_reference import Case

from reports.charts.publication import canvas, label_axes
from reports.charts.style import COLOURS

TITLE = "Error against time: half-plane theory"
SHARE, FRICTION = 0.6, 0.5
MINDLIN = Case(0.0, 1.0, 0.0, SHARE * FRICTION, math.pi / 2, FRICTION, True)
CASES = {
    "hertz-paper": "hertz-paper",
    "flat face, the paper's loads": "flat and rounded, b/a = 0.7",
    "Cattaneo-Mindlin": "Cattaneo-Mindlin",
    "1e-6 from gross sliding": "1e-6 from gross sliding",
    "slip of 1e-6 of f P": "slip of 1e-6 of f P",
}


def mindlin() -> mp.mpf:
    """W of a cycle between +-k f P at constant P = 1, E* = 1, by the closed form of docs/theory.md."""
    k, f = mp.mpf(SHARE), mp.mpf(FRICTION)
    return 4 * f**2 / mp.pi * ((1 - k) * mp.log(1 - k) + k - k**2 / 2)


def study(name: str) -> dict[str, list[theory.Point]]:
    """Every method on a case."""
    return theory.methods_on(MINDLIN, mindlin()) if name == "Cattaneo-Mindlin" else theory.study(name)


def measure() -> dict[str, Any]:
    """Every case."""
    return plain({title: study(name) for name, title in CASES.items()})


def plain(found: dict[str, dict[str, list[theory.Point]]]) -> dict[str, Any]:
    """The points of every case and method as JSON has them."""
    return {
        title: {method: [point._asdict() for point in points] for method, points in methods.items()}
        for title, methods in found.items()
    }


METHODS = {
    "plain Gauss": "Gauss, 4 to 32 nodes a phase",
    "the engine's rule": "the engine's rule (default)",
    "straight steps": "memory curve, 50 to 3200 straight steps",
    "discretised": "naive discretised half-plane, 20 to 160 elements",
}


def draw(cases: dict[str, Any], folder: Path) -> None:
    """Error over time, a panel a case."""
    with canvas(13.0, 3.6) as figure:
        axes = figure.subplots(1, len(cases), sharex=True, sharey=True)
        for one, (title, methods) in zip(axes, cases.items(), strict=True):
            for (method, points), colour, mark in zip(methods.items(), ("#0072B2", "#111111", *COLOURS[1:3]), "o*s^", strict=True):
                one.loglog(
                    [point["seconds"] for point in points],
                    [point["error"] for point in points],
                    color=colour,
                    marker=mark,
                    ls="-" if len(points) > 1 else "none",
                    ms=11 if mark == "*" else 5,
                    label=METHODS[method],
                )
            label_axes(one, "CPU time of one W [s]", "error of W" if one is axes[0] else "", title)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="lower center", ncols=4, frameon=False, fontsize=8)
        figure.tight_layout(rect=(0, 0.08, 1, 1))
        figure.savefig(folder / "precision_half_plane.svg", metadata={"Date": None})


def page(cases: dict[str, Any]) -> list[str]:
    """Figure and table."""
    lines = [
        "![Error of W over CPU time, theory and the naive peer, five cases](performance/precision_half_plane.svg)",
        "",
        "One W of a steady cycle at a time, one thread, against 30 digits. The engine's rule has no setting: it takes the nodes "
        "that it needs. Plain Gauss is faster to few digits where nothing is extreme, and does not arrive near gross "
        "sliding or with tiny slip. The naive discretised half-plane is `benchmarks/discretised_half_plane.py`.",
        "",
        "| case | engine: error | time [ms] | best of Gauss | time [ms] | best of straight steps | time [ms] | best of the naive "
        "peer | time [ms] |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for title, methods in cases.items():
        cells = []
        for method in ("the engine's rule", "plain Gauss", "straight steps", "discretised"):
            points = methods[method]
            best = min(points, key=lambda point: point["error"], default=None)
            cells += [f"{best['error']:.1e} | {1e3 * best['seconds']:.2g}" if best else "no answer | "]
        lines.append(f"| {title} | {' | '.join(cells)} |")
    return lines
