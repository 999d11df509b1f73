"""Figures that need no reference: energy and the laws of contact over the whole path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reports.charts.marks import Axis, Curve, Mark, Note, Rule
from reports.charts.plate import Key, Panel, Plate
from reports.charts.scale import limits
from reports.comparison.laws import LIMIT, Certificate
from reports.comparison.metrics import name_of
from reports.figures_cycle import LINES
from reports.units import energy_unit, minus
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
    large = ("external", "external_end_of_step", "elastic")
    groups = [{name: series for name, series in recorded.items() if (name in large) is wanted} for wanted in (True, False)]
    panels = [
        Panel(
            f"energy-{number}",
            Axis(*limits(solution.time, margin=0), "time"),
            Axis(*limits(*group.values()), f"energy since the start  [{energy_unit(solution.scene)}]"),
            [*_cycles(solution), *(Curve(solution.time, s, styles[n], n.replace("_", " ")) for n, s in group.items())],
            "Energies over time",
            height=280.0,
        )
        for number, group in enumerate(groups)
        if group
    ]
    return Plate(
        "energy",
        f"Energy, {name_of(solution.engine)}",
        "Summed up from the start, per unit thickness; that external work = elastic energy + interface work at every step is "
        "one of the certificates. Friction work with the tractions at the end of each step (end of step) instead of "
        "their mean (interface) shows the error of the steps themselves.",
        "Energies over time.",
        tuple(panels),
        {"time": solution.time} | dict(solution.record.energy),
        tuple(Key(styles[name], name.replace("_", " ")) for group in groups for name in group),
    )


def certificates(role: str, solution: ContactSolution, checks: Sequence[Certificate]) -> Plate:
    """Violation of each law of contact at each instant of the whole path; those that are exactly 0 are only named.

    `role` is "reference" or "result": engines have names that no file could have.
    """
    shown = [check for check in checks if np.any(check.series != 0)]
    exact = [check.label for check in checks if check not in shown]
    finite = [float(s) for check in shown for s in check.series if np.isfinite(s)]
    keys = tuple(Key(f"{css} fine", check.label) for check, css in zip(shown, LINES * 3, strict=False))
    lines: list[Mark] = [*_cycles(solution), Rule(LIMIT, "limit")]
    lines += [Curve(solution.time, check.series, key.css, check.label) for check, key in zip(shown, keys, strict=True)]
    lines.append(Note(float(solution.time[-1]), LIMIT, "limit", anchor="end", shift=(-4.0, -5.0)))
    title = f"Certificates, {name_of(solution.engine)}"
    return Plate(
        f"certificates_{role}",
        title,
        "How far each law of contact is violated, where it is at all."
        + (f" Exactly 0 throughout: {', '.join(exact)}." if exact else ""),
        "Violations of the laws of contact over time on a logarithmic axis.",
        (
            Panel(
                f"certificates-{role}",
                Axis(*limits(solution.time, margin=0), "time", count=8),
                Axis(1e-18, 30 * max([LIMIT, *finite]), "violation, dimensionless", log=True),
                lines,
                title,
                900.0,
                280.0,
                notes=[minus(f"largest {max(finite):.1e}, limit {LIMIT:.0e}")] if finite else [],
                css="broad",
            ),
        ),
        {"time": solution.time} | {check.label: check.series for check in checks},
        keys,
        columns=1,
    )


def _cycles(solution: ContactSolution) -> list[Mark]:
    """A thin line where each cycle starts."""
    path = solution.scene.load.path()
    if path.period is None:
        return []
    starts = np.arange(path.cycle_start, solution.time[-1] + 1e-9 * path.period, path.period)
    return [Rule(float(start), "cycle-line", upright=True) for start in starts]
