"""One solution without a reference: its summary and its files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from reports.certificates import certificates
from reports.comparison.metrics import normal_work
from reports.definitions import name_of
from reports.drawing import table_text
from reports.folder import filled
from reports.summary import solution_content, strict
from reports.units import energy_unit, load_unit, units
from scenes import ContactSolution


def is_admissible(solution: ContactSolution) -> bool:
    """Whether every law of contact that can be checked without a reference holds."""
    return solution.record.converged and all(check.holds for check in certificates(solution))


def summary_rows(solution: ContactSolution) -> list[tuple[str, str]]:
    """What a person wants to know first, as (quantity, value)."""
    load, (_, length, stress), work = load_unit(solution.scene), units(solution.scene), energy_unit(solution.scene)
    checks = certificates(solution)
    broken = [f"{check.label} ({check.value:.1e} at time {check.time:.4g})" for check in checks if not check.holds]
    rows = [
        ("engine", name_of(solution.engine)),
        ("how it ended", solution.record.message),
        ("instants, surface points", f"{len(solution.time)}, {len(solution.x)}"),
        (
            "last instant",
            f"time {solution.time[-1]:.6g}, P {solution.normal_load[-1]:.6g}, Q {solution.tangential_load[-1]:.6g} {load}",
        ),
        (f"largest pressure at the points [{stress}]", f"{np.max(solution.pressure):.8g}"),
        (f"largest contact half-width [{length}]", f"{np.nanmax(solution.contact_half_width):.8g}"),
        (f"permanent stick half-width [{length}]", _or_none(solution.permanent_stick_half_width)),
        (f"dissipation {_of_the_last_cycle(solution)} [{work}]", dissipation_words(solution)),
    ]
    if solution.dissipation_drift and np.isfinite(solution.dissipation_drift):
        rows.append(("dissipation, change from the cycle before", f"{solution.dissipation_drift:+.2e} of it"))
    if np.isfinite(solution.loop_work):
        rows.append((f"closed integral of Q dU [{work}]", f"{solution.loop_work:.10g}"))
        if (normal := normal_work(solution)) is not None:
            rows.append((f"closed integral of P dV, V the approach [{work}]", f"{normal:.10g}"))
    rows.append(("laws of contact", f"violated: {', '.join(broken)}" if broken else f"all {len(checks)} hold"))
    rows.extend(("note", note) for note in solution.record.notes)
    rows.extend((f"{name.replace('_', ' ')} (work)", str(count)) for name, count in solution.work.counts.items())
    rows.extend((f"{name.replace('_', ' ')} (skipped)", f"{count}: {why}") for name, (count, why) in solution.work.skipped.items())
    return rows


def dissipation_words(solution: ContactSolution) -> str:
    """W, and what it is uncertain by at least where that was looked for."""
    value, apart = _or_none(solution.dissipation), solution.dissipation_uncertainty
    if np.isnan(apart):
        return value
    share = f" ({apart / solution.dissipation:.2%})" if solution.dissipation else ""
    return f"{value} ± at least {apart:.2g}{share}, the difference from a coarse mesh"


def _of_the_last_cycle(solution: ContactSolution) -> str:
    """A path that does not repeat is one cycle."""
    return "of the whole path" if solution.scene.load.path().period is None else "of the last cycle"


def _or_none(value: float) -> str:
    return "none" if np.isnan(value) else f"{value:.10g}"


def write_solution(solution: ContactSolution, out: Path, name: str = "") -> Path:
    """NetCDF, the summary as JSON, a CSV of the instants and the scene; returns the path of the NetCDF file."""
    stem = name or solution.engine
    with filled(out, fresh=()) as folder:
        solution.save(folder / f"{stem}.nc")
        content = {
            "format": "halfplane solution 1",
            **solution_content(solution, certificates(solution)),
            "scene": solution.scene.model_dump(mode="json"),
        }
        (folder / f"{stem}.json").write_text(json.dumps(strict(content), allow_nan=False, indent=1) + "\n", encoding="utf-8")
        (folder / f"{stem}.csv").write_text(_instants(solution), encoding="utf-8")
        (folder / "scene.json").write_text(solution.scene.model_dump_json(indent=1) + "\n", encoding="utf-8")
    return out / f"{stem}.nc"


def _instants(solution: ContactSolution) -> str:
    """One line for each instant."""
    columns = (
        "time",
        "normal_load",
        "tangential_load",
        "contact_half_width",
        "stick_half_width",
        "tangential_displacement",
        "normal_approach",
    )
    return table_text({name: getattr(solution, name) for name in columns} | {"iterations": solution.record.iterations})
