"""From a comparison or a report to a folder: the page, comparison.json, a CSV for each figure, NetCDF, and VTU only when asked.

The page is one self-contained HTML file that works offline; its words are in templates/report.html. Its slider moves through the
last cycle at a few instants and points, as whole numbers of 16 bits: the reference, and the difference in a scale of its own.
"""

from __future__ import annotations

import base64
import json
import subprocess
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports import units
from reports.charts.plate import STATE_KEYS, Plate
from reports.charts.templating import script, template
from reports.comparison import Comparison, Report, words
from reports.comparison.metrics import bulk_work, last_cycle, name_of, normal_work
from reports.comparison.words import as_json, headline, verdict
from reports.field_output.files import with_bodies, write_fields
from reports.folder import filled
from reports.measured import section
from reports.page.figures import Shown, draw, places, sheared_shift
from reports.profile_fit import findings
from reports.units import minus

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
        live = _cycle_data(Shown(comparison)) | {"tables": tables(texts)}
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


# -------------------------------------------------------------------------------------------------------------- the page
def render(
    report: Report,
    drawings: Sequence[Plate],
    command: str,
    seconds: Mapping[str, float],
    live: Mapping[str, Any] | None = None,
    third: Mapping[str, Any] | None = None,
) -> str:
    """The HTML text; every word that came from outside is escaped, and no script but the page's own may run.

    Parameters
    ----------
    drawings : the figures; one that is missing leaves its place empty
    command : what reproduces the page
    seconds : stage -> wall time
    live : what the slider moves through; without it the page has none
    third : words of the third solver, where it ran
    """
    comparison = report.comparison
    scene, said = comparison.scene, words.said(report)
    program, digest = script()
    return template("report.html").render(
        said | {"bodies": [said["bodies"], said["unlike_materials"], *findings(scene)[0]]},
        title=scene.title or scene.name,
        scene=scene,
        comparison=comparison,
        report=report,
        in_words=words,
        units=units,
        budget=words.budget_table(report.budget) if report.budget else None,
        notes=_notes(comparison),
        dissipations=list(_dissipations(comparison)),
        measured=section(scene, (comparison.reference, comparison.result)),
        figures={drawing.name: drawing for drawing in drawings},
        engines=[(name_of(solution.engine), solution) for solution in (comparison.reference, comparison.result)],
        flat=flat,
        command=command,
        commit=commit(),
        third=third,
        script=program,
        script_hash=digest,
        live=_as_script(dict(live) if live else {"instants": 0}),
        carried=_carried(dict(live)) if live else "",
        states=STATE_KEYS,
        uncertain_work=words.uncertain_work(comparison),
        seconds=seconds,
    )


def commit() -> str:
    """The commit of the checkout that this package lies in, "with changes" where files differ from it; or why there is none."""
    home = Path(__file__).parents[2]
    if not (home / ".git").exists():
        return "installed without its history"
    words = ["git", "-C", str(home), "describe", "--always", "--dirty", "--abbrev=12"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown: git does not answer"
    return done.stdout.strip().replace("-dirty", ", with changes")


def _notes(comparison: Comparison) -> list[str]:
    """What a reader must not miss: of the metrics, then of the solutions."""
    named = [(m.label, m.note) for m in comparison.headlines if m.note]
    own = [words.sentence(note if note.lower().startswith(label.lower()) else f"{label}: {note}") for label, note in named]
    return [*own, *comparison.notes]


def _dissipations(comparison: Comparison) -> Iterator[dict[str, str]]:
    """Dissipation of each solution: both routes and every cycle."""

    def shown(value: float | None, digits: int = 8) -> str:
        """A dash for what a solution does not hold."""
        return "–" if value is None or np.isnan(value) else minus(f"{value:.{digits}g}")

    polygon = comparison.polygon_reference
    for solution in filter(None, (comparison.reference, polygon, comparison.result)):
        normal, loop, work = normal_work(solution), solution.loop_work, solution.dissipation
        yield {
            "name": name_of(solution.engine) + (", on the polygon of the steps" if solution is polygon else ""),
            "value": shown(work),
            "scaled": shown(work / comparison.scales.dissipation),
            "loop": shown(loop),
            "bulk": shown(bulk_work(last_cycle(solution), solution.scene.material)),  # of the instants that the solution has
            "normal": shown(normal),
            "apart": "–" if np.isnan(loop) or not work else minus(f"{abs((loop + (normal or 0.0)) / work - 1):.1e}"),
            "cycles": ", ".join(shown(one, 6) for one in solution.cycle_dissipation),
        }


def flat(settings: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """Nested settings as one list, names joined by dots, numbers to six digits.

    >>> flat({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    found: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{above}{name}.")
        else:
            found[above + name] = f"{value:.6g}" if isinstance(value, float) else str(value)
    return found


# ------------------------------------------------------------------------------------------------- what the slider moves
Array = NDArray[np.float64]
# Largest number of instants, and of instants times points, that a page carries: 1.6 MB.
_MOST_INSTANTS, _MOST_VALUES = 200, 100_000
# Letters of the longest CSV that a page carries.
_LETTERS = 1_500_000
_STEPS, _NOTHING = 32766, -32768


def _quantised(values: Array) -> dict[str, Any]:
    """Numbers as 16-bit whole numbers of a step, little-endian in base64; what is not finite is a number of its own.

    >>> _quantised(np.array([0.0, 2.0, -1.0]))["step"] * 32766
    2.0
    """
    finite = np.isfinite(values)
    step = float(np.max(np.abs(values[finite]), initial=0.0)) / _STEPS or 1.0
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), _NOTHING).astype("<i2")
    return {"step": step, "data": base64.b64encode(whole.tobytes()).decode()}


def _cycle_data(shown: Shown) -> dict[str, Any]:
    """Everything that the slider moves, and how much of the cycle that is."""
    comparison, expected, found, scales = shown.comparison, shown.expected, shown.found, shown.scales
    # All instants, or evenly many of them with the first, the last and the chosen ones; of the points those that are drawn.
    last = len(found.time) - 1
    even = np.linspace(0, last, min(last + 1, _MOST_INSTANTS)).round().astype(int)
    rows = np.unique([*even.tolist(), 0, last, *(event.index for event in shown.chosen)])
    inside = np.flatnonzero(np.abs(shown.x) <= 1.02 * shown.wide)
    points = np.unique([*inside[:: -(-len(inside) * len(rows) // _MOST_VALUES)].tolist(), inside[-1], *places(comparison)])
    grid = np.ix_(rows, points)
    series = {
        "t": shown.time,
        "P": found.normal_load,
        "Q": found.tangential_load,
        "U0": expected.tangential_displacement,
        "U1": found.tangential_displacement,
        "V0": sheared_shift(expected),
        "V1": sheared_shift(found),
    }
    sizes = {"p": ("pressure", scales.pressure), "q": ("shear", scales.shear), "s": ("slip", 1.0)}
    fields = {}
    for key, (name, size) in sizes.items():
        theirs, ours = getattr(expected, name)[grid] / size, getattr(found, name)[grid] / size
        fields[key] = _quantised(theirs)
        fields[f"d{key}"] = _quantised(ours - theirs)
    states = expected.state[grid].astype(np.uint8) + 4 * found.state[grid].astype(np.uint8)
    return {
        "instants": len(rows),
        "points": len(points),
        "of": [len(found.time), len(found.x)],
        "rows": rows.tolist(),
        "x": [float(f"{v:.7g}") for v in shown.x[points]],
        "series": {name: [float(f"{v:.7g}") if np.isfinite(v) else None for v in values[rows]] for name, values in series.items()},
        "fields": fields,
        "states": base64.b64encode(states.tobytes()).decode(),
        "events": [[int(np.flatnonzero(rows == event.index)[0]), event.label] for event in shown.chosen],
        "start": int(np.flatnonzero(rows == shown.start)[0]),
        "slip_points": [int(np.flatnonzero(points == place)[0]) for place in places(comparison)],
        "time_words": shown.time_words,
        "load_unit": units.load_unit(comparison.scene),
        "length": units.units(comparison.scene)[1],
        "engines": [name for _, _, name in shown.sides],
    }


def _carried(data: dict[str, Any]) -> str:
    """How much of the cycle the slider moves through, in a sentence."""
    instants, points = data["of"]
    if (data["instants"], data["points"]) == (instants, points):
        return "The slider moves through every instant and point of the last cycle."
    return (
        f"The slider moves through {data['instants']} of the {instants} instants and {data['points']} of the {points} points of "
        "the last cycle (those near the contact); figures that stand still, and the CSV, hold all of them, but where their "
        "captions say less."
    )


def tables(texts: Mapping[str, str]) -> dict[str, str]:
    """Name -> the CSV of each figure, deflated; those over `_LETTERS` stay beside the page only."""
    short = {name: text for name, text in texts.items() if len(text) <= _LETTERS}
    return {name: base64.b64encode(zlib.compress(text.encode(), 9)).decode() for name, text in short.items()}


def _as_script(data: dict[str, Any]) -> str:
    """JSON that can stand in a script element: no "<" in it, so nothing in a name can end the element.

    >>> _as_script({"engine": "</script>"})
    '{"engine":"\\\\u003c/script>"}'
    """
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
