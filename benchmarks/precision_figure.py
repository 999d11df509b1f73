"""The figure of `semi_analytic_precision.py`: error against time, one panel a case."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt

if TYPE_CHECKING:
    from semi_analytic_precision import Point

# Okabe and Ito's colours, told apart by marker and line as well.
STYLES = {
    "plain Gauss": ("#0072B2", "o", "-"),
    "the engine's rule": ("#000000", "*", ""),
    "straight steps": ("#D55E00", "s", "--"),
    "discretised": ("#009E73", "^", ":"),
}
LABELS = {
    "plain Gauss": "Gauss, 4 to 32 nodes a phase",
    "the engine's rule": "the engine's rule",
    "straight steps": "memory curve, 50 to 3200 straight steps",
    "discretised": "discretised half-plane, 20 to 160 elements",
}


def draw(found: dict[str, dict[str, list[Point]]], folder: Path) -> None:
    """Write precision.svg and precision.png."""
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.6), sharex=True, sharey=True, layout="constrained")
    for ax, (name, methods) in zip(axes.flat, found.items(), strict=False):
        for method, points in methods.items():
            colour, marker, line = STYLES[method]
            size = 13 if marker == "*" else 6
            ax.loglog(
                [point.seconds for point in points],
                [point.error for point in points],
                color=colour,
                marker=marker,
                linestyle=line or "none",
                markersize=size,
                label=LABELS[method],
            )
        ax.set_title(name, fontsize=11)
        ax.grid(visible=True, which="major", color="0.88", linewidth=0.6)
    for ax in axes[:, 0]:
        ax.set_ylabel("relative error of W")
    for ax in (*axes[1, :2], axes[0, 2]):
        ax.set_xlabel("process time of one figure, s")
        ax.tick_params(labelbottom=True)
    rest = axes.flat[len(found)]
    rest.axis("off")
    rest.legend(*axes.flat[0].get_legend_handles_labels(), loc="center left", frameon=False, fontsize=10)
    folder.mkdir(exist_ok=True)
    for kind in ("svg", "png"):
        figure.savefig(folder / f"precision.{kind}", dpi=130)
    plt.close(figure)
