"""Figures that need no reference: energy and the laws of contact over the whole path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from reports.certificates import LIMIT, Certificate
from reports.definitions import name_of
from reports.drawing import COLOURS, LINES, QUIET, Drawing, canvas, label_axes, legend_above
from reports.units import energy_unit
from scenes import ContactSolution


def energy(solution: ContactSolution) -> Drawing | None:
    """Every energy that the engine recorded, summed up over the path; None if it recorded none.

    `record.energy` holds what each step adds. The large ones (work of the loads, elastic energy) stand apart from the
    friction work, which would be a flat line beside them.
    """
    recorded = {name: np.cumsum(series) for name, series in solution.record.energy.items()}
    if not recorded:
        return None
    large = {name: series for name, series in recorded.items() if name in ("external", "external_end_of_step", "elastic")}
    small = {name: series for name, series in recorded.items() if name not in large}
    with canvas(10.5, 3.3) as figure:
        panels = figure.subplots(1, 2)
        figure.subplots_adjust(left=0.075, right=0.985, top=0.88, bottom=0.145, wspace=0.16)
        for axes, group in zip(panels, (large, small), strict=True):
            for (name, series), line, colour in zip(group.items(), LINES, COLOURS, strict=False):
                axes.plot(solution.time, series, ls=line, color=colour, label=name.replace("_", " "))
            _mark_cycles(axes, solution)
            legend_above(axes, columns=4)
            label_axes(axes, "time", "")
        panels[0].set_ylabel(f"energy since the start  [{energy_unit(solution.scene)}]")
    return Drawing(
        "energy",
        f"Energy, {name_of(solution.engine)}",
        "Summed up from the start, per unit thickness; that external work = elastic energy + interface work at every step is "
        "one of the certificates. Friction work with the tractions at the end of each step (end of step) instead of "
        "their mean (interface) shows the error of the steps themselves.",
        "Energies over time.",
        figure,
        {"time": solution.time} | dict(solution.record.energy),
    )


def certificates(role: str, solution: ContactSolution, checks: Sequence[Certificate]) -> Drawing:
    """Violation of each law of contact at each instant of the whole path; those that are exactly 0 are only named.

    `role` is "reference" or "result": engines have names that no file could have.
    """
    shown = [check for check in checks if np.any(check.series != 0)]
    exact = [check.label for check in checks if check not in shown]
    with canvas(10.5, 3.6) as figure:
        axes = figure.subplots()
        rows = -(-len(shown) // 5)
        figure.subplots_adjust(left=0.075, right=0.985, top=0.95 - 0.055 * rows, bottom=0.13)
        finite = [float(s) for check in shown for s in check.series if np.isfinite(s)]
        axes.set_yscale("log")
        axes.set_ylim(1e-18, 30 * max([LIMIT, *finite]))
        for check, line, colour in zip(shown, LINES * 3, COLOURS * 3, strict=False):
            series = np.where(check.series > 0, check.series, np.nan)
            axes.plot(solution.time, series, scaley=False, ls=line, color=colour, lw=1.0, label=check.label)
        axes.axhline(LIMIT, color=QUIET, lw=1.0)
        axes.text(0.995, LIMIT, "limit", transform=axes.get_yaxis_transform(), ha="right", va="bottom", color=QUIET)
        _mark_cycles(axes, solution)
        if shown:
            legend_above(axes, columns=5)
        label_axes(axes, "time", "violation, dimensionless")
    return Drawing(
        f"certificates_{role}",
        f"Certificates, {name_of(solution.engine)}",
        "How far each law of contact is violated, where it is at all."
        + (f" Exactly 0 throughout: {', '.join(exact)}." if exact else ""),
        "Violations of the laws of contact over time on a logarithmic axis.",
        figure,
        {"time": solution.time} | {check.label: check.series for check in checks},
    )


def _mark_cycles(axes: Axes, solution: ContactSolution) -> None:
    """A thin line where each cycle starts."""
    path = solution.scene.load.path()
    if path.period is None:
        return
    starts = np.arange(path.cycle_start, solution.time[-1] + 1e-9 * path.period, path.period)
    for start in starts:
        axes.axvline(start, color="#bbbbbb", lw=0.8, zorder=0)
