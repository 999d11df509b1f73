"""From a Comparison to a folder: the page, comparison.json, a CSV for each figure, NetCDF, and VTU only when asked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from reports import figures_bodies, figures_checks, figures_cycle, figures_fields
from reports.comparison import Comparison
from reports.drawing import Drawing
from reports.fields import with_bodies, write_fields
from reports.folder import filled
from reports.instants import events
from reports.page import render
from reports.summary import as_json


def write(
    comparison: Comparison,
    out: str | Path,
    *,
    vtu_instants: Sequence[float] | None = None,
    command: str = "",
    seconds: Mapping[str, float] | None = None,
) -> Path:
    """Write the report and return the path of the page.

    Parameters
    ----------
    comparison : what `compare` returned
    out : folder; made if need be; of what is in it already only an earlier run's own files are replaced
    vtu_instants : times at which both bodies are written for ParaView; none by default
    command : what reproduces the report
    seconds : stage -> wall time, for the page

    Raises
    ------
    InputError
        If the folder can't be written to, or VTU is asked of a result without bodies.
    """
    with filled(out) as folder:
        drawings = draw(comparison)
        (folder / "figures").mkdir()
        for drawing in drawings:
            (folder / "figures" / f"{drawing.name}.csv").write_text(drawing.csv(), encoding="utf-8")
        comparison.reference.save(folder / "reference.nc")
        comparison.result.save(folder / "result.nc")
        (folder / "scene.json").write_text(comparison.scene.model_dump_json(indent=1) + "\n", encoding="utf-8")
        (folder / "comparison.json").write_text(as_json(comparison, command, seconds) + "\n", encoding="utf-8")
        if vtu_instants is not None and len(vtu_instants):
            import halfplane_fe

            write_fields(halfplane_fe.fields(with_bodies(comparison.result, "--vtu"), vtu_instants), folder / "fields")
        page = render(comparison, drawings, command, seconds or {})
        (folder / "report.html").write_text(page, encoding="utf-8")
    return Path(out) / "report.html"


def draw(comparison: Comparison) -> tuple[Drawing, ...]:
    """Every figure of the report, in the order of the page."""
    chosen = events(comparison.found, comparison.scene.friction.coefficient)
    periodic = comparison.scene.load.path().period is not None
    time = comparison.found.fraction if periodic else comparison.found.time
    label = "time, as a fraction of the last cycle" if periodic else "time"
    drawings: list[Drawing | None] = [
        figures_bodies.sketch(comparison.scene, comparison.scales.half_width),
        figures_fields.tractions(comparison, chosen),
        figures_cycle.load_path(comparison.result, comparison.found, chosen),
        figures_cycle.hysteresis(comparison, chosen),
        figures_cycle.half_widths(comparison, time, label),
        figures_fields.state_map(comparison, time, label),
        figures_fields.dissipation_density(comparison),
        figures_cycle.errors(comparison, time, label),
        figures_checks.energy(comparison.result),
        figures_checks.certificates("result", comparison.result, comparison.result_certificates),
        figures_checks.certificates("reference", comparison.reference, comparison.reference_certificates),
    ]
    if bodies := getattr(comparison.result, "bodies", ()):
        drawings.append(figures_fields.mesh(comparison, bodies))
    return tuple(drawing for drawing in drawings if drawing)
