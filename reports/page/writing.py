"""From a comparison or a report to a folder: the page, comparison.json, a CSV for each figure, NetCDF, and VTU only when asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.comparison import Comparison, Report
from reports.comparison.content import as_json
from reports.comparison.words import headline, verdict
from reports.field_output.files import with_bodies, write_fields
from reports.folder import filled
from reports.page.content import render
from reports.page.figures import Shown, draw
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
        live = cycle_data(Shown(comparison)) | {"tables": tables(texts)}
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
