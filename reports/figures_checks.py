"""Figures that need no reference: energy and the laws of contact over the whole path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from reports.certificates import LIMIT, Certificate
from reports.charts import marks
from reports.charts.panel import Axis, frame, panel
from reports.charts.plate import Key, Plate
from reports.charts.scale import limits
from reports.definitions import name_of
from reports.figures_cycle import LINES
from reports.units import energy_unit
from scenes import ContactSolution


def energy(solution: ContactSolution) -> Plate | None:
    """Every energy that the engine recorded, summed up over the path; None if it recorded none.

    `record.energy` holds what each step adds. The large ones (work of the loads, elastic energy) stand apart from the
    friction work, which would be a flat line beside them.
    """
    recorded = {name: np.cumsum(series) for name, series in solution.record.energy.items()}
    if not recorded:
        return None
    styles = dict(zip(recorded, LINES * 3, strict=False))
    groups = [
        {name: series for name, series in recorded.items() if (name in ("external", "external_end_of_step", "elastic")) is large}
        for large in (True, False)
    ]
    return Plate(
        "energy",
        f"Energy, {name_of(solution.engine)}",
        "Summed up from the start, per unit thickness; that external work = elastic energy + interface work at every step is "
        "one of the certificates. Friction work with the tractions at the end of each step (end of step) instead of "
        "their mean (interface) shows the error of the steps themselves.",
        "Energies over time.",
        tuple(_energies(solution, group, styles, number) for number, group in enumerate(groups) if group),
        {"time": solution.time} | dict(solution.record.energy),
        tuple(Key(styles[name], name.replace("_", " ")) for group in groups for name in group),
    )


def _energies(solution: ContactSolution, group: Mapping[str, NDArray[np.float64]], styles: Mapping[str, str], number: int) -> str:
    axes = (
        Axis(*limits(solution.time, margin=0), "time"),
        Axis(*limits(*group.values()), f"energy since the start  [{energy_unit(solution.scene)}]"),
    )
    area = frame(*axes, height=280.0)
    lines = [
        *_cycles(area, solution),
        *(marks.curve(area, solution.time, s, styles[n], n.replace("_", " ")) for n, s in group.items()),
    ]
    return panel(area, *axes, lines, "Energies over time", clip=f"energy-{number}")


def certificates(role: str, solution: ContactSolution, checks: Sequence[Certificate]) -> Plate:
    """Violation of each law of contact at each instant of the whole path; those that are exactly 0 are only named.

    `role` is "reference" or "result": engines have names that no file could have.
    """
    shown = [check for check in checks if np.any(check.series != 0)]
    exact = [check.label for check in checks if check not in shown]
    finite = [float(s) for check in shown for s in check.series if np.isfinite(s)]
    axes = (
        Axis(*limits(solution.time, margin=0), "time", count=8),
        Axis(1e-18, 30 * max([LIMIT, *finite]), "violation, dimensionless", log=True),
    )
    area = frame(*axes, width=900.0, height=280.0)
    lines = [*_cycles(area, solution), marks.horizontal(area, LIMIT, "limit")]
    lines += [
        marks.curve(area, solution.time, check.series, f"{css} fine", check.label)
        for check, css in zip(shown, LINES * 3, strict=False)
    ]
    lines.append(marks.words(area.x.end - 4, float(area.y.place(LIMIT)) - 5, "limit", class_="tick", text_anchor="end"))
    title = f"Certificates, {name_of(solution.engine)}"
    return Plate(
        f"certificates_{role}",
        title,
        "How far each law of contact is violated, where it is at all."
        + (f" Exactly 0 throughout: {', '.join(exact)}." if exact else ""),
        "Violations of the laws of contact over time on a logarithmic axis.",
        (panel(area, *axes, lines, title, clip=f"certificates-{role}", css="broad"),),
        {"time": solution.time} | {check.label: check.series for check in checks},
        tuple(Key(f"{css} fine", check.label) for check, css in zip(shown, LINES * 3, strict=False)),
        columns=1,
    )


def _cycles(area: marks.Frame, solution: ContactSolution) -> list[str]:
    """A thin line where each cycle starts."""
    path = solution.scene.load.path()
    if path.period is None:
        return []
    starts = np.arange(path.cycle_start, solution.time[-1] + 1e-9 * path.period, path.period)
    return [marks.vertical(area, float(start), "cycle-line") for start in starts]
