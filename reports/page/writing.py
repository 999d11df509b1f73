"""From a comparison or a report to a folder: the page, comparison.json, a CSV for each figure, NetCDF, and VTU only when asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import Plate
from reports.comparison import Comparison, Report
from reports.comparison.content import as_json
from reports.comparison.cycles import Event, events
from reports.comparison.metrics import missing
from reports.comparison.words import headline, verdict
from reports.field_output.files import with_bodies, write_fields
from reports.folder import filled
from reports.page import bodies, figures
from reports.page.content import render
from reports.page.live import cycle_data, tables

if TYPE_CHECKING:
    from reports.field_output.files import Instant
    from reports.third.calculix import ThirdSolver


def write(
    found: Comparison | Report,
    out: str | Path,
    *,
    vtu_instants: Sequence[float] | None = None,
    command: str = "",
    seconds: Mapping[str, float] | None = None,
    stress_instants: Sequence[Instant] = (),
    plots: Sequence[str] = (),
    log: Sequence[str] = (),
) -> Path:
    """Write the report and return the path of the page.

    Parameters
    ----------
    found : what `compare` or `score` returned, or a `Report` of more
    out : folder; made if need be; of what is in it already only an earlier run's own files are replaced
    vtu_instants : times at which both bodies are written for ParaView; none by default
    command : what reproduces the report
    seconds : stage -> wall time, for the page
    stress_instants : where the page shows von Mises' stress; nowhere by default
    plots : formats of which every figure is written too, in plots/: "pdf", "svg", "png"
    log : lines of run.log; without any there is none

    Raises
    ------
    InputError
        If the folder can't be written to, or VTU or stress is asked of a result without bodies.
    """
    report = found if isinstance(found, Report) else Report(found)
    comparison = report.comparison
    with filled(out) as folder:
        drawings = draw(report)
        if stress_instants:
            import halfplane_fe
            from reports.field_output.pictures import scales_of, stress

            answer = with_bodies(comparison.result, "--stress")
            snapshots = halfplane_fe.fields(answer, [instant.time for instant in stress_instants])
            drawings += (stress(answer, snapshots, stress_instants, scales_of(snapshots)),)
        (folder / "figures").mkdir()
        texts = {drawing.name: drawing.csv() for drawing in drawings}
        for name, text in texts.items():
            (folder / "figures" / f"{name}.csv").write_text(text, encoding="utf-8")
        comparison.reference.save(folder / "reference.nc")
        comparison.result.save(folder / "result.nc")
        (folder / "scene.json").write_text(comparison.scene.model_dump_json(indent=1) + "\n", encoding="utf-8")
        (folder / "comparison.json").write_text(as_json(report, command, seconds) + "\n", encoding="utf-8")
        if vtu_instants is not None and len(vtu_instants):
            import halfplane_fe

            answer = with_bodies(comparison.result, "--vtu")
            write_fields(answer, halfplane_fe.fields(answer, vtu_instants), folder / "fields")
        words = _write_third(comparison, report.third, folder) if report.third else None
        live = cycle_data(comparison, chosen_instants(comparison), *time_axis(comparison)) | {"tables": tables(texts)}
        page = render(report, drawings, command, seconds or {}, live, words)
        (folder / "report.html").write_text(page, encoding="utf-8")
        if log:
            (folder / "run.log").write_text("\n".join([*log, headline(report), verdict(report)]) + "\n", encoding="utf-8")
        if plots:
            from reports.charts.publication import write_plots

            write_plots(drawings, folder / "plots", plots)
    return Path(out) / "report.html"


def _write_third(comparison: Comparison, third: ThirdSolver, folder: Path) -> dict[str, Any]:
    """Files of a third solver; returns what the page states of it."""
    from reports.third.calculix import as_json, page_words

    (folder / "third.inp").write_text(third.text, encoding="utf-8")
    (folder / "third.json").write_text(as_json(comparison, third), encoding="utf-8")
    if third.comparison is not None:
        third.comparison.result.save(folder / "third.nc")
    return page_words(comparison, third)


def time_axis(comparison: Comparison) -> tuple[NDArray[np.float64], str]:
    """What figures through the last cycle have along their axis of time, and its words."""
    if comparison.scene.load.path().period is not None and comparison.found.whole:
        return comparison.found.fraction, "time / period"
    return comparison.found.time, "time"


def chosen_instants(comparison: Comparison) -> tuple[Event, ...]:
    """The instants that have a number in every figure."""
    return events(comparison.found, comparison.scene.friction.coefficient)


def draw(report: Report) -> tuple[Plate, ...]:
    """Every figure of the report, in the order of the page."""
    comparison = report.comparison
    chosen, (time, words) = chosen_instants(comparison), time_axis(comparison)
    drawings: list[Plate | None] = [
        bodies.sketch(comparison.scene, comparison.scales.half_width),
        bodies.fit_residuals(comparison.scene, float(np.nanmax(comparison.expected.contact_edges))),
        figures.load_path(comparison.result, comparison.found, chosen),
        figures.now(comparison, chosen),
        figures.hysteresis(comparison, chosen),
        figures.state_map(comparison, time, words),
        figures.half_widths(comparison, time, words),
        figures.slip_histories(comparison, time, words),
        figures.dissipation_density(comparison),
        figures.errors(comparison, time, words),
        figures.tractions(comparison, chosen),
        figures.energy(comparison.result),
        figures.certificates("result", comparison.result, comparison.result_certificates),
        figures.certificates("reference", comparison.reference, comparison.reference_certificates),
    ]
    if report.study is not None:
        drawings.append(figures.distances(report.study))
    if report.budget is not None:
        drawings += [figures.bars(report.budget), figures.ladders(report.budget)]
    if meshes := getattr(comparison.result, "bodies", ()):
        from reports.field_output.pictures import mesh

        drawings.append(mesh(meshes, comparison.scales.half_width, float(np.nanmax(comparison.found.contact_edges))))
    # What a foreign result does not hold: slip, dissipation, more than one instant.
    needed = {"slip": "slip_history", "dissipation_density": "dissipation_density"}
    left_out = {needed[name] for name in needed if name in missing(comparison.result)}
    if len(comparison.found.time) < 2:
        left_out |= {"state_map", "half_widths", "slip_history", "errors", "certificates_result", "certificates_reference"}
    return tuple(drawing for drawing in drawings if drawing and drawing.name not in left_out)
