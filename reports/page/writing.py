"""From a comparison or a report to a folder: the page, comparison.json, a CSV for each figure,
NetCDF, and VTU only when asked.

The page is one self-contained HTML file that works offline; its words are in templates/report.html,
those of its figures in templates/figures.txt. Its slider moves through the last cycle at a few
instants and points, as whole numbers of 16 bits: the reference, and the difference in a scale of
its own.
"""

from __future__ import annotations

import base64
import json
import math
import subprocess
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports.charts.plate import (
    STATE_KEYS,
    Arrow,
    Axis,
    Band,
    Bitmap,
    Block,
    Cell,
    Curve,
    Dot,
    Frame,
    Group,
    Key,
    Mark,
    Note,
    Panel,
    Plate,
    Rule,
    Scale,
    Segments,
    limits,
    worded,
)
from reports.charts.templating import STATE_NAMES, Table, script, template
from reports.comparison import Comparison, Report, ThirdAnswer, words
from reports.comparison.budget import ROUNDING, Budget, ErrorBudget, Refinement, extrapolate
from reports.comparison.cycles import Cycle, Event, events, last_cycle
from reports.comparison.metrics import missing
from reports.comparison.pairs import are_half_planes, name_of
from reports.comparison.words import (
    as_json,
    bodies_in_words,
    bulk_and_tilt,
    headline,
    value_of,
    verdict,
)
from reports.comparison.work_of_loads import bulk_strain, bulk_work, loop_work, normal_work
from reports.field_output.files import with_bodies, write_fields
from reports.folder import filled
from reports.measured import section
from reports.profile_fit import findings, fit_of
from reports.units import energy_unit, load_unit, minus, number, signed, units
from scenes import ContactSolution, Cylinder, HalfPlane, InputError, Scene, Shape, sampled
from scenes.bodies import face_of
from scenes.scene import OWN_TOLERANCES

if TYPE_CHECKING:
    from reports.field_output.files import Instant
    from reports.scoring.study import Study

# Files of the solutions in a folder of a report: of the reference, of the result.
SOLUTIONS = ("reference.nc", "result.nc")


def write(
    found: Comparison | Report,
    out: str | Path,
    *,
    vtu_instants: Sequence[float] | None = None,
    command: str = "",
    seconds: Mapping[str, float] | None = None,
    stress_instants: Sequence[Instant] = (),
    log: Sequence[str] = (),
) -> Path:
    """Write the report and return the path of the page.

    Both solutions are written first. Where the page fails they are in the folder, and a note of the
    error names their files.

    Parameters
    ----------
    found : what `compare` or `score` returned, or a `Report` of more
    out : folder; made if need be; of what is in it already only an earlier run's own files are
    replaced vtu_instants : times at which both bodies are written for ParaView; none by default
    command : what reproduces the report
    seconds : stage -> wall time, for the page
    stress_instants : where the page shows von Mises' stress; nowhere by default
    log : lines of run.log; without any there is none

    Raises
    ------
    InputError
        If the folder can't be written to, or VTU or stress is asked of a result without bodies.
    """
    report = found if isinstance(found, Report) else Report(found)
    comparison = report.comparison
    with filled(out, solutions=SOLUTIONS) as folder:
        for name, solution in zip(
            SOLUTIONS, (comparison.reference, comparison.result), strict=True
        ):
            # before the page: one that fails must not cost what took long to solve
            solution.save(folder / name)
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
        (folder / "scene.json").write_text(
            comparison.scene.model_dump_json(indent=1) + "\n", encoding="utf-8"
        )
        (folder / "comparison.json").write_text(
            as_json(report, command, seconds) + "\n", encoding="utf-8"
        )
        if vtu_instants is not None and len(vtu_instants):
            import halfplane_fe

            answer = with_bodies(comparison.result, "--vtu")
            write_fields(answer, halfplane_fe.fields(answer, vtu_instants), folder / "fields")
        words = _write_third(comparison, report.third, folder) if report.third else None
        live = _cycle_data(_Shown(comparison)) | {"tables": _tables(texts)}
        page = render(report, drawings, command, seconds or {}, live, words)
        (folder / "report.html").write_text(page, encoding="utf-8")
        if log:
            (folder / "run.log").write_text(
                "\n".join([*log, headline(report), verdict(report)]) + "\n", encoding="utf-8"
            )
    return Path(out) / "report.html"


def _write_third(comparison: Comparison, third: ThirdAnswer, folder: Path) -> dict[str, Any]:
    """Files of a third solver; returns what the page states of it."""
    (folder / "third.inp").write_text(third.text, encoding="utf-8")
    (folder / "third.json").write_text(third.as_json(comparison), encoding="utf-8")
    if third.comparison is not None:
        third.comparison.result.save(folder / "third.nc")
    return third.page_words(comparison)


# ----------------------------------------------------------------------------------------- the page
def render(
    report: Report,
    drawings: Sequence[Plate],
    command: str,
    seconds: Mapping[str, float],
    live: Mapping[str, Any] | None = None,
    third: Mapping[str, Any] | None = None,
) -> str:
    """The HTML text; every word that came from outside is escaped, and no script but the page's own
    may run.

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
        units=import_module("reports.units"),
        budget=words.budget_table(report.budget) if report.budget else None,
        notes=_notes(comparison),
        dissipations=list(_dissipations(comparison)),
        stretch=words.stretch(scene),
        measured=section(scene, (comparison.reference, comparison.result)),
        figures={drawing.name: drawing for drawing in drawings},
        engines=[
            (name_of(solution.engine), solution)
            for solution in (comparison.reference, comparison.result)
        ],
        flat=_flat,
        command=command,
        commit=_commit(),
        third=third,
        script=program,
        script_hash=digest,
        live=_as_script(dict(live) if live else {"instants": 0}),
        carried=_carried(dict(live)) if live else "",
        states=STATE_KEYS,
        uncertain_work=words.uncertain_work(comparison),
        seconds=seconds,
    )


def _commit() -> str:
    """The commit of the checkout that this package lies in, "with changes" where files differ from
    it; or why there is none.
    """
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
    own = [
        words.sentence(note if note.lower().startswith(label.lower()) else f"{label}: {note}")
        for label, note in named
    ]
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
            "name": (
                name_of(solution.engine)
                + (", on the polygon of the steps" if solution is polygon else "")
            ),
            "value": shown(work),
            "scaled": shown(work / comparison.scales.dissipation),
            "loop": shown(loop),
            # of the instants that the solution has
            "bulk": shown(bulk_work(last_cycle(solution), solution.scene.material)),
            "normal": shown(normal),
            "apart": (
                "–"
                if np.isnan(loop) or not work
                else minus(f"{abs((loop + (normal or 0.0)) / work - 1):.1e}")
            ),
            "cycles": ", ".join(shown(one, 6) for one in solution.cycle_dissipation),
        }


def _flat(settings: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """Nested settings as one list, names joined by dots, numbers to six digits.

    >>> _flat({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    found: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{above}{name}.")
        else:
            found[above + name] = f"{value:.6g}" if isinstance(value, float) else str(value)
    return found


# ---------------------------------------------------------------------------- what the slider moves
# Largest number of instants, and of instants times points, that a page carries: 1.6 MB.
_MOST_INSTANTS, _MOST_VALUES = 200, 100_000
# Letters of the longest CSV that a page carries.
_LETTERS = 1_500_000
_STEPS, _NOTHING = 32766, -32768


def _quantised(values: Array) -> dict[str, Any]:
    """Numbers as 16-bit whole numbers of a step, little-endian in base64; what is not finite is a
    number of its own.

    >>> _quantised(np.array([0.0, 2.0, -1.0]))["step"] * 32766
    2.0
    """
    finite = np.isfinite(values)
    step = float(np.max(np.abs(values[finite]), initial=0.0)) / _STEPS or 1.0
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), _NOTHING).astype("<i2")
    return {"step": step, "data": base64.b64encode(whole.tobytes()).decode()}


def _cycle_data(shown: _Shown) -> dict[str, Any]:
    """Everything that the slider moves, and how much of the cycle that is."""
    comparison, expected, found, scales = (
        shown.comparison,
        shown.expected,
        shown.found,
        shown.scales,
    )
    # All instants, or evenly many of them with the first, the last and the chosen ones; of the
    # points those that are drawn.
    last = len(found.time) - 1
    even = np.linspace(0, last, min(last + 1, _MOST_INSTANTS)).round().astype(int)
    rows = np.unique([*even.tolist(), 0, last, *(event.index for event in shown.chosen)])
    inside = np.flatnonzero(np.abs(shown.x) <= 1.02 * shown.wide)
    points = np.unique(
        [
            *inside[:: -(-len(inside) * len(rows) // _MOST_VALUES)].tolist(),
            inside[-1],
            *_places(comparison),
        ]
    )
    grid = np.ix_(rows, points)
    series = {
        "t": shown.time,
        "P": found.normal_load,
        "Q": found.tangential_load,
        "U0": expected.tangential_displacement,
        "U1": found.tangential_displacement,
        "V0": _sheared_shift(expected),
        "V1": _sheared_shift(found),
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
        "stretch": shown.stretch,
        "rows": rows.tolist(),
        "x": [float(f"{v:.7g}") for v in shown.x[points]],
        "series": {
            name: [float(f"{v:.7g}") if np.isfinite(v) else None for v in values[rows]]
            for name, values in series.items()
        },
        "fields": fields,
        "states": base64.b64encode(states.tobytes()).decode(),
        "events": [
            [int(np.flatnonzero(rows == event.index)[0]), event.label] for event in shown.chosen
        ],
        "start": int(np.flatnonzero(rows == shown.start)[0]),
        "slip_points": [int(np.flatnonzero(points == place)[0]) for place in _places(comparison)],
        "time_words": shown.time_words,
        "load_unit": load_unit(comparison.scene),
        "length": units(comparison.scene)[1],
        "engines": [name for _, _, name in shown.sides],
    }


def _carried(data: dict[str, Any]) -> str:
    """How much of the cycle the slider moves through, in a sentence."""
    instants, points = data["of"]
    if (data["instants"], data["points"]) == (instants, points):
        return f"The slider moves through every instant and point of the {data['stretch']}."
    return (
        f"The slider moves through {data['instants']} of the {instants} instants and"
        f" {data['points']} of the {points} points of the {data['stretch']} (those near the"
        " contact); figures that stand still, and the CSV, hold all of them, but where their"
        " captions say less."
    )


def _tables(texts: Mapping[str, str]) -> dict[str, str]:
    """Name -> the CSV of each figure, deflated; those over `_LETTERS` stay beside the page only."""
    short = {name: text for name, text in texts.items() if len(text) <= _LETTERS}
    return {
        name: base64.b64encode(zlib.compress(text.encode(), 9)).decode()
        for name, text in short.items()
    }


def _as_script(data: dict[str, Any]) -> str:
    """JSON that can stand in a script element: no "<" in it, so nothing in a name can end the
    element.

    >>> _as_script({"engine": "</script>"})
    '{"engine":"\\\\u003c/script>"}'
    """
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


# -------------------------------------------------------------------------------------- the figures
Array = NDArray[np.float64]
_X = "x / a_ref"
# Looks of lines, one after the other, then from the first again.
_LINES = tuple(f"line-{k}" for k in range(7)) * 3
# Open, stick, forward and reverse slip on a map, which has no style sheet.
_STATES = ("#ffffff", "#d2d2d2", "#e69f00", "#0072b2")
_COLUMNS, _ROWS = 440, 360
# Rows of the table of states: of a long path evenly many instants, 25 MB.
_MOST_STATES = 500_000
_ZERO = Rule(0.0, "zero")


class _Shown:
    """What the figures of a comparison share.

    Attributes
    ----------
    sides : look of its lines, last cycle and name, of the reference and of the result; keys : their
    entries of a legend chosen : the instants that have a number in every figure
    start : of these the one that a page shows first: with most points slipping, of equal ones the
    most loaded time, time_words : the axis of figures through the last cycle
    stretch, noun : what the values are of, "last cycle", "whole record" or "whole path", and its
        last word
    x, wide : points over a_ref; the largest of them that is drawn, a little more than the largest
        contact of either
    """

    def __init__(self, comparison: Comparison) -> None:
        expected, found = comparison.expected, comparison.found
        names = [name_of(solution.engine) for solution in (comparison.reference, comparison.result)]
        self.comparison, self.scene, self.scales = comparison, comparison.scene, comparison.scales
        self.stretch = words.stretch(comparison.scene)
        self.noun = self.stretch.split()[-1]
        self.expected, self.found = expected, found
        self.sides = (("r", expected, names[0]), ("f", found, names[1]))
        self.keys = [Key(f"{who} p", name) for who, _, name in self.sides]
        self.chosen = events(found, self.scene.friction.coefficient)
        self.start = max(
            (event.index for event in self.chosen),
            key=lambda k: (int((found.state[k] >= 2).sum()), float(found.normal_load[k])),
        )
        repeats = self.scene.load.path().period is not None and found.whole
        self.time, self.time_words = (
            (found.fraction, "time / period") if repeats else (found.time, "time")
        )
        self.x = found.x / self.scales.half_width
        outer = (
            max(float(np.nanmax(np.abs(c.contact_edges), initial=0.0)) for c in (expected, found))
            or np.inf
        )
        self.wide = min(1.12 * outer, float(np.abs(found.x).max())) / self.scales.half_width

    def over_time(self, count: int = 5) -> Axis:
        """The axis of time."""
        return Axis(*limits(self.time, margin=0), self.time_words, count=count)

    def over_x(self, words: str = _X) -> Axis:
        """The axis of x."""
        return Axis(-self.wide, self.wide, words)

    def largest(self, difference: Array, unit: str) -> str:
        """The numbers of a difference over time."""
        return _measured(
            difference, self.time, "t/T = {}" if "period" in self.time_words else "t = {}", unit
        )


def draw(report: Report) -> tuple[Plate, ...]:
    """Every figure of the report, in the order of the page; those left out that need what a foreign
    result does not hold.
    """
    comparison = report.comparison
    shown, result = _Shown(comparison), comparison.result
    drawings: list[Plate | None] = [
        sketch(comparison.scene, comparison.scales.half_width),
        fit_residuals(comparison.scene, float(np.nanmax(comparison.expected.contact_edges))),
        _load_path(shown),
        _now(shown),
        _hysteresis(shown),
        _state_map(shown),
        _half_widths(shown),
        _slip_histories(shown),
        _dissipation_density(shown),
        _errors(shown),
        _tractions(shown),
        _distances(report.study) if report.study is not None else None,
    ]
    if report.budget is not None:
        drawings += [_bars(report.budget), _mesh_refinement(report.budget)]
    if meshes := getattr(result, "bodies", ()):
        from reports.field_output.pictures import mesh

        drawings.append(
            mesh(
                meshes,
                comparison.scales.half_width,
                float(np.nanmax(comparison.found.contact_edges)),
            )
        )
    needed = {"slip": "slip_history", "dissipation_density": "dissipation_density"}
    left_out = {needed[name] for name in needed if name in missing(result)}
    if len(shown.time) < 2:
        left_out |= {"state_map", "half_widths", "slip_history", "errors"}
    return tuple(drawing for drawing in drawings if drawing and drawing.name not in left_out)


def figure(found: Comparison | Report, name: str) -> str:
    """One figure of the page as an SVG document that stands alone.

    Parameters
    ----------
    found : what `compare` or `score` returned, or a `Report` of more
    name : of the figure, as its CSV beside the page is called

    Raises
    ------
    InputError
        For a name that no figure of this comparison has.

    >>> import reports, semi_analytic
    >>> exact = semi_analytic.solve("cattaneo-mindlin")
    >>> reports.figure(reports.compare(exact, exact), "hysteresis")[:11]
    '<svg xmlns='
    """
    figures = {
        plate.name: plate for plate in draw(found if isinstance(found, Report) else Report(found))
    }
    if name not in figures:
        raise InputError(
            f"figure: {name!r} is no figure of this comparison; its figures are"
            f" {', '.join(figures)}"
        )
    return figures[name].svg()


def _measured(
    difference: Array,
    along: Array,
    where: str,
    unit: str = "",
    weight: NDArray[np.bool_] | None = None,
) -> str:
    """The numbers of a difference (n,) along x or time (n,): root mean square over the length, the
    largest value, its place.

    >>> _measured(np.array([0.0, -3.0, 0.0]), np.array([0.0, 1.0, 2.0]), "x = {} a_ref", " %")
    'rms 1.7 %, largest −3 % at x = 1 a_ref'
    """
    known = np.isfinite(difference) & (True if weight is None else weight)
    if not known.any():
        return "nothing to compare"
    lengths = np.gradient(along) if len(along) > 1 else np.ones(1)
    rms = np.sqrt(np.average(difference[known] ** 2, weights=np.maximum(lengths[known], 1e-300)))
    worst = int(np.argmax(np.where(known, np.abs(difference), -1.0)))
    place = where.format(minus(f"{along[worst] + 0.0:.3g}"))
    size, most = (
        f"{v:.2g}" if abs(v) < 100 else f"{v:.0f}" for v in (rms, difference[worst] + 0.0)
    )
    return minus(f"rms {size}{unit}, largest {most}{unit} at ") + place


def _broad(
    name: str, x: Axis, y: Axis, marks: Sequence[Mark], alt: str, height: float = 280.0, **more: Any
) -> Panel:
    """A panel as wide as the page."""
    return Panel(name, x, y, marks, alt, 900.0, height, css="broad", **more)


# ------------------------------------------------------------------------------------------- over x
def _traction_keys(shown: _Shown) -> tuple[Key, ...]:
    lines = [Key(f"{who} {key}", f"{key}, {name}") for who, _, name in shown.sides for key in "pq"]
    return (*lines, Key("d p", "difference of p"), Key("d q", "difference of q"))


def _tractions(shown: _Shown) -> Plate:
    """p and q of both engines at the chosen instants, the difference beneath."""
    rows, scales, points = [event.index for event in shown.chosen], shown.scales, len(shown.x)
    cells = [
        Cell(
            _traction_panels(
                shown, event.index, rows, f"event-{n}", (320.0, 220.0), f"{n}  {event.label}"
            ),
            event.index,
        )
        for n, event in enumerate(shown.chosen, start=1)
    ]
    table = {
        "time": np.repeat(shown.found.time[rows], points),
        "x": np.tile(shown.found.x, len(rows)),
    }
    table["x/a_ref"] = np.tile(shown.x, len(rows))
    for key, field, unit, size in (
        ("p", "pressure", "p_ref", scales.pressure),
        ("q", "shear", "(f p_ref)", scales.shear),
    ):
        for role, cycle in (("reference", shown.expected), ("result", shown.found)):
            table[f"{key}_{role}/{unit}"] = (getattr(cycle, field)[rows] / size).ravel()
    return worded("tractions", cells, table, _traction_keys(shown), columns=3)


def _traction_panels(
    shown: _Shown,
    k: int,
    rows: Sequence[int],
    name: str,
    size: tuple[float, float],
    title: str = "",
    *,
    live: bool = False,
) -> tuple[Panel, Panel]:
    """Tractions at instant k in a drawing of that size, and the difference; axes hold the instants
    of `rows`.

    `live` if the slider moves them.
    """
    (width, height), scales = size, shown.scales
    near = np.abs(shown.x) <= shown.wide * 1.02
    x, fields = shown.x[near], {"p": ("pressure", scales.pressure), "q": ("shear", scales.shear)}
    # Instant k, which is drawn, before the others that the axes hold; a line copies its row, or it
    # would keep all in memory.
    grid = np.ix_(np.array(list(dict.fromkeys((k, *rows)))), np.flatnonzero(near))
    both = {
        key: [getattr(cycle, field)[grid] / unit for _, cycle, _ in shown.sides]
        for key, (field, unit) in fields.items()
    }
    apart = {key: 100 * (pair[1] - pair[0]) for key, pair in both.items()}
    touching = (both["p"][0][0] != 0) | (both["p"][1][0] != 0)

    def curve(values: Array, css: str, label: str, field: str) -> Curve:
        return Curve(x, values.copy(), css, label, {"field": field} if live else {})

    lines: list[Mark] = [_ZERO]
    for n, (who, _, engine) in enumerate(shown.sides):
        lines += [
            curve(both[key][n][0], f"{who} {key}", f"{key}, {engine}", f"{key}{n}") for key in "pq"
        ]
    differences: list[Mark] = [
        _ZERO,
        *(curve(apart[key][0], f"d {key}", f"difference of {key}, %", f"d{key}") for key in "pq"),
    ]
    up = Axis(
        *limits(*(series for pair in both.values() for series in pair), zero=True),
        "p/p_ref,  q/(f p_ref)",
    )
    below = Axis(*limits(*apart.values(), zero=True, least=1e-9), "difference, %", count=3)
    notes = [
        f"{key}: {_measured(apart[key][0], x, 'x = {} a_ref', ' %', touching)}" for key in "pq"
    ]
    alts = [
        f"{what} over x. {title}".strip()
        for what in ("Pressure and shear", "Result less reference")
    ]
    room = (72.0, 26.0 if title else 12.0, 20.0, 20.0)
    return (
        Panel(name, shown.over_x(""), up, lines, alts[0], width, height, title, room=room),
        Panel(
            f"{name}-difference",
            shown.over_x(),
            below,
            differences,
            alts[1],
            width,
            0.56 * height + 56,
            notes=notes,
        ),
    )


def published(comparison: Comparison) -> str:
    """The picture of a published scene, two panels as SVG: tractions at the largest load, and the
    loop or the half-widths.
    """
    shown, scene, expected = _Shown(comparison), comparison.scene, comparison.expected
    # Where P is largest, and of these instants where |Q| is.
    largest = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    k = int(np.argmax(np.where(largest, np.abs(expected.tangential_load), -1.0)))
    first, _ = _traction_panels(
        shown, k, [k], "tractions", (440.0, 330.0), f"t = {expected.time[k]:.4g}"
    )
    first = replace(first, x=shown.over_x(), room=None)
    moves = np.ptp(expected.tangential_displacement) > 1e-9 * comparison.scales.shift
    loop = _hysteresis(shown) if moves else None
    shown.time, shown.time_words = shown.found.time, "time"
    beside = loop.panels[1] if loop else _half_widths(shown).panels[0]
    keys = _traction_keys(shown)[:4]
    return (
        Plate(
            scene.name,
            scene.title or scene.name,
            "",
            f"Both engines on {scene.name}",
            (first, beside),
            {},
            keys,
        ).svg()
        + "\n"
    )


def _now(shown: _Shown) -> Plate:
    """Both engines at the chosen instant with most slip; axes hold the whole cycle, so that nothing
    leaves them as it moves.
    """
    expected, found, width = shown.expected, shown.found, 560.0
    above, difference = _traction_panels(
        shown, shown.start, range(len(found.time)), "now", (width, 300.0), live=True
    )
    strips = list[Mark]()  # open, stick and slip along x, which the slider recolours
    for k, (_, cycle, engine) in enumerate(shown.sides):
        top, x, state = 20.0 + 40.0 * k, cycle.x / shown.scales.half_width, cycle.state[shown.start]
        turns = np.flatnonzero(np.diff(state))
        ends = [
            -shown.wide,
            *np.clip((x[turns + 1] + x[turns]) / 2, -shown.wide, shown.wide).tolist(),
            shown.wide,
        ]
        runs = zip(ends[:-1], ends[1:], state[[0, *(turns + 1).tolist()]].tolist(), strict=True)
        blocks = tuple(Block((a, b), (top, top + 16), f"state-{s}") for a, b, s in runs if b > a)
        strips += [
            Note(-shown.wide, top - 5, engine),
            Group(blocks, "strip", {"strip": k, "top": f"{top:g}"}),
        ]
        strips.append(Block((-shown.wide, shown.wide), (top, top + 16), "outline"))
    alt, room = "Open, stick and slip along x, a strip for each engine", (72.0, 0.0, 20.0, 0.0)
    zones = Panel(
        "zones",
        shown.over_x(""),
        Axis(84.0, 0.0, ""),
        strips,
        alt,
        width,
        84.0,
        css="zones",
        bare=True,
        room=room,
    )
    table = {
        "time": found.time,
        "fraction": found.fraction,
        "P": found.normal_load,
        "Q": found.tangential_load,
    }
    table |= {
        "U_reference": expected.tangential_displacement,
        "U_result": found.tangential_displacement,
    }
    table["points_where_states_differ"] = (
        (expected.state != found.state).sum(axis=1).astype(np.int64)
    )
    return worded("cycle", (above, zones, difference), table, _traction_keys(shown), columns=1)


def _state_map(shown: _Shown) -> Plate:
    """Open, stick, forward and reverse slip over x and time, for both engines and where they
    differ.
    """
    expected, found, time, wide = shown.expected, shown.found, shown.time, shown.wide
    inside = np.flatnonzero(np.abs(shown.x) <= wide)
    columns = np.abs(shown.x[:, None] - np.linspace(-wide, wide, _COLUMNS)).argmin(axis=0)
    rows = np.abs(time[:, None] - np.linspace(time[-1], time[0], _ROWS)).argmin(axis=0)
    written = (
        np.linspace(0, len(time) - 1, min(len(time), max(_MOST_STATES // len(inside), 2)))
        .round()
        .astype(int)
    )
    metric = shown.comparison.metric("state")
    # The metric's own number: points crowd at the edges, so that counting them would give another,
    # larger share.
    share = "" if metric.value is None else value_of(metric)
    differ = (
        "map-difference",
        expected.state != found.state,
        ("#ffffff", "#111111"),
        f"they differ: {share}".rstrip(": "),
    )
    panels = []
    for name, states, palette, title in (
        ("map-reference", expected.state, _STATES, shown.sides[0][2]),
        ("map-result", found.state, _STATES, shown.sides[1][2]),
        differ,
    ):
        marks = [Bitmap(states[np.ix_(rows, columns)].astype(np.uint8), palette)]
        axes = shown.over_x(), shown.over_time()
        panels.append(
            Panel(
                name,
                *axes,
                marks,
                f"Map of states: {title}",
                340.0,
                320.0,
                title,
                time="y",
                css="pick",
            )
        )
    codes, grid = (
        ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items()),
        np.ix_(written, inside),
    )
    table = {
        "time": np.repeat(found.time[written], len(inside)),
        "x": np.tile(found.x[inside], len(written)),
    }
    table |= {
        f"state_reference ({codes})": expected.state[grid].ravel(),
        f"state_result ({codes})": found.state[grid].ravel(),
    }
    kept, of = len(written), len(time)
    return worded(
        "state_map",
        panels,
        table,
        STATE_KEYS,
        columns=3,
        share=share,
        written=kept,
        instants=of,
        stretch=shown.stretch,
    )


def _dissipation_density(shown: _Shown) -> Plate | None:
    """w(x) of the last cycle, both engines, the difference beside it; None where nothing is
    dissipated anywhere.
    """
    x, scales = shown.x, shown.scales
    theirs, ours = (
        cycle.dissipation_density / (scales.dissipation / scales.half_width)
        for _, cycle, _ in shown.sides
    )
    if not (np.any(theirs) or np.any(ours)):
        return None
    stick = _permanent_edges(shown.comparison.reference) / scales.half_width
    lines: list[Mark] = [
        Rule(float(edge), "stick-line", upright=True) for edge in stick if np.isfinite(edge)
    ]
    lines += [
        Curve(x, w, key.css, key.text) for w, key in zip((theirs, ours), shown.keys, strict=True)
    ]
    peak = int(np.nanargmax(np.where(np.isfinite(ours), ours, -np.inf)))
    lines.append(Dot(float(x[peak]), float(ours[peak]), "event"))
    apart = 100 * (ours - theirs) / (float(np.nanmax(np.abs(theirs), initial=0.0)) or 1.0)
    note = _measured(
        apart, x, "x = {} a_ref", " %", (np.abs(x) <= shown.wide) & ((theirs != 0) | (ours != 0))
    )
    ends = (
        f"±{stick[1]:.4g}" if stick[0] == -stick[1] else minus(f"{stick[0]:.4g} and {stick[1]:.4g}")
    )
    up = Axis(*limits(theirs, ours, zero=True), "w / (A f² P_ref²/a_ref)")
    below = Axis(*limits(apart, zero=True, least=1e-9), "difference, % of the largest")
    marks: list[Mark] = [_ZERO, Curve(x, apart, "d p", "difference")]
    unit = "(A f^2 P_ref^2/a_ref)"
    return worded(
        "dissipation_density",
        (
            Panel("work", shown.over_x(), up, lines, "Dissipation density over x", css="pick"),
            Panel(
                "work-difference",
                shown.over_x(),
                below,
                marks,
                "Difference of the dissipation density",
                notes=[note],
            ),
        ),
        {"x": shown.found.x, "x/a_ref": x, f"w_reference/{unit}": theirs, f"w_result/{unit}": ours},
        (*shown.keys, Key("d p", "difference")),
        stretch=shown.stretch,
        peak=f"{ours[peak]:.4g}",
        place=signed(float(x[peak])),
        stick=ends if np.isfinite(stick).all() else "",
    )


# ---------------------------------------------------------------------------------------- over time
def _half_widths(shown: _Shown) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the
    half-widths beside them.
    """
    length, time = shown.scales.half_width, shown.time
    lines, keys, apart, table = (
        list[Curve](),
        list[Key](),
        dict[str, Array](),
        {"time": shown.found.time},
    )
    for role, (who, cycle, engine) in zip(("reference", "result"), shown.sides, strict=True):
        for kind, css in (("contact", "p"), ("stick", "q")):
            edges, key = (
                getattr(cycle, f"{kind}_edges"),
                Key(f"{who} {css}", f"{kind} edge, {engine}"),
            )
            lines += [Curve(time, edges[:, side] / length, key.css, key.text) for side in (0, 1)]
            keys.append(key)
            half = np.ptp(edges, axis=1) / 2 / length
            apart[kind] = half - apart[kind] if kind in apart else half
            table |= {
                f"{side}_{kind}_edges_{role}": edges[:, k]
                for k, side in enumerate(("left", "right"))
            }
    x = shown.found.x
    outer = float(np.nanmax(np.abs(shown.found.contact_edges), initial=0.0))
    spacing = (
        float(np.median(np.diff(x)[np.abs(np.abs(x[1:]) - outer) < 0.3 * (outer or np.inf)]))
        / length
        if outer
        else np.nan
    )
    up = Axis(*limits(*apart.values(), zero=True, least=1e-12), "difference of half-widths / a_ref")
    marks: list[Mark] = [
        _ZERO,
        *(
            Curve(time, apart[kind], css, kind)
            for kind, css in (("contact", "d p"), ("stick", "d q"))
        ),
    ]
    notes = [f"{kind}: {shown.largest(values, ' a_ref')}" for kind, values in apart.items()]
    edges, title = (
        Axis(*limits(*(line.y for line in lines)), _X),
        f"Contact and stick edges through the {shown.noun}",
    )
    return worded(
        "half_widths",
        (
            Panel("edges", shown.over_time(), edges, lines, title, time="x"),
            Panel(
                "edges-difference",
                shown.over_time(),
                up,
                marks,
                "Difference of the half-widths",
                notes=notes,
                time="x",
            ),
        ),
        table,
        (*keys, Key("d p", "difference, contact"), Key("d q", "difference, stick")),
        stretch=shown.stretch,
        spacing=f"{spacing:.1g}" if np.isfinite(spacing) else "",
    )


def _errors(shown: _Shown) -> Plate:
    """Metrics that have a value at each instant, at the instants that are judged: over their
    tolerances, where there are any.

    Where no tolerance was given, those that half-planes are judged by, in per cent.
    """
    time, series = shown.time, [m for m in shown.comparison.metrics if m.series is not None]
    judged = [m for m in series if m.tolerance is not None]
    drawn = judged or [m for m in series if m.key in OWN_TOLERANCES]
    lines, keys, largest = list[Mark]([Rule(1.0, "limit")] if judged else []), [], 0.0
    for m, css in zip(drawn, _LINES, strict=False):
        over = (m.tolerance or 1.0) if judged else 0.01
        size = np.where(shown.comparison.judged, np.abs(np.asarray(m.series)) / over, np.nan)
        worst = int(np.nanargmax(size)) if np.isfinite(size).any() else 0
        largest = max(largest, float(np.nanmax(size, initial=0.0)))
        lines.append(Curve(time, size, css, m.label))
        keys.append(
            Key(
                css,
                minus(f"{m.label}: {size[worst]:.2g}{'' if judged else ' %'} at {time[worst]:.3g}"),
            )
        )
    if judged:
        lines.append(Note(float(time[-1]), 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
    most = min(max(1.0, largest), 8.0) if judged else largest or 1.0
    up = Axis(0.0, 1.08 * most, "|discrepancy| / tolerance" if judged else "|discrepancy|, %")
    panel = _broad(
        "errors", shown.over_time(8), up, lines, f"Discrepancy through the {shown.noun}", time="x"
    )
    table = {"time": shown.found.time} | {m.key: np.asarray(m.series) for m in drawn}
    return worded(
        "errors",
        [panel],
        table,
        keys,
        columns=1,
        judged=bool(judged),
        cut=bool(judged) and largest > 8,
        stretch=shown.stretch,
    )


def _permanent_edges(solution: ContactSolution) -> Array:
    """(2,) ends of what sticks through the whole last cycle [length]; NaN if nothing does."""
    if solution.permanent_stick_edges is not None:
        return solution.permanent_stick_edges
    return solution.permanent_stick_half_width * np.array([-1.0, 1.0])


def _places(comparison: Comparison, count: int = 4) -> list[int]:
    """Points whose slip is worth a look: from the permanent stick zone (or the middle) to just
    outside the largest contact.

    Indices into the result's points, on the right-hand side, none twice.
    """
    expected, x = comparison.expected, comparison.found.x
    outer = float(np.nanmax(np.abs(expected.contact_edges), initial=0.0)) or float(np.abs(x).max())
    if comparison.turned:
        outer = float(np.nanmax(expected.contact_edges, initial=float(x[0])))
    inner = _permanent_edges(comparison.reference)[1]
    inner = float(inner) if np.isfinite(inner) and inner < outer else min(0.0, outer)
    wanted = inner + np.linspace(0.12, 0.97, count) * (outer - inner)
    return sorted({int(np.abs(x - place).argmin()) for place in wanted})


def _slip_histories(shown: _Shown) -> Plate:
    """Slip of chosen points through the last cycle, both engines, from where each stood at the
    start of the cycle.
    """
    rows, x, length = _places(shown.comparison), shown.found.x, units(shown.scene)[1]
    named = [f"x = {shown.x[row]:.3f} a_ref" for row in rows]
    slips = [cycle.slip[:, rows] - cycle.slip[0, rows] for _, cycle, _ in shown.sides]
    lines = [
        Curve(shown.time, slip[:, k], f"{look} point-{k}", f"{name}, {engine}")
        for look, slip, (_, _, engine) in zip(("wide", "thin"), slips, shown.sides, strict=True)
        for k, name in enumerate(named)
    ]
    table = {"time": shown.found.time}
    for k, row in enumerate(rows):
        for role, slip in zip(("reference", "result"), slips, strict=True):
            table[f"slip_{role}(x = {x[row]:.6g}) [{length}]"] = slip[:, k]
    apart = slips[1] - slips[0]
    point = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(apart)), axis=0)))
    notes = [
        f"result − reference at {named[point]}, where it is largest:",
        shown.largest(apart[:, point], f" {length}"),
    ]
    up = Axis(
        *limits(*slips, zero=True, least=1e-12 * shown.scales.half_width),
        f"slip since the start  [{length}]",
    )
    panel = _broad(
        "slip",
        shown.over_time(8),
        up,
        lines,
        "Slip of chosen points over time",
        320.0,
        notes=notes,
        time="x",
    )
    return worded(
        "slip_history",
        [panel],
        table,
        [Key(f"point-{k}", name) for k, name in enumerate(named)],
        columns=1,
        stretch=shown.stretch,
    )


# ------------------------------------------------------------------- the loads, and load over shift
def _load_path(shown: _Shown) -> Plate:
    """The path in the P-Q plane: initial loading, cycle, Coulomb limit, chosen instants, a ring at
    the instant shown.

    Beneath it bulk stress, tilt and moment over the cycle, where there are any.
    """
    solution, cycle = shown.comparison.result, shown.found
    friction, unit, path = (
        solution.scene.friction.coefficient,
        load_unit(solution.scene),
        solution.scene.load.path(),
    )
    parts = {"initial loading" if path.cycle else "path": path.initial_loading, "cycle": path.cycle}
    time = {
        name: np.concatenate([sampled(leg, 257) for leg in legs])
        for name, legs in parts.items()
        if legs
    }
    loads = {
        name: [np.asarray(load) for load in path.at(instants)] for name, instants in time.items()
    }
    normal, tangential = (np.concatenate([pair[k] for pair in loads.values()]) for k in (0, 1))
    top = 1.08 * float(normal.max())
    reached = 1.25 * max(float(np.abs(tangential).max()), 0.15 * top)
    looks = {name: "initial-loading" if name == "initial loading" else "loop" for name in loads}
    marks: list[Mark] = [
        Curve([0, top], [0, s * friction * top], "cone", "|Q| = f P") for s in (1, -1) if friction
    ]
    marks += [Curve(p, q, looks[name], name) for name, (p, q) in loads.items()]
    up = Axis(
        min(-0.3 * reached, 1.25 * float(tangential.min())), reached, f"tangential load Q  [{unit}]"
    )
    across, alt = Axis(0.0, top, f"normal load P  [{unit}]"), "Load path in the plane of P and Q"
    panel = Panel("load-path", across, up, marks, alt, height=330.0)
    marks += _events(panel, cycle.normal_load, cycle.tangential_load, shown.chosen)
    marks.append(
        _follower("P", cycle.normal_load[shown.start], cycle.tangential_load[shown.start], "now")
    )
    keys = [
        *(Key(looks[name], name) for name in reversed(loads)),
        *([Key("cone", "|Q| = f P")] if friction else []),
    ]
    panels = [panel]
    for name, title, lines in _beside_the_forces(shown):
        up = Axis(
            *limits(*(values for _, _, values in lines), zero=True, margin=0.12), title, count=3
        )
        over: list[Mark] = [
            _ZERO,
            *(Curve(shown.time, values, css, text) for css, text, values in lines),
        ]
        panels.append(
            Panel(name, shown.over_time(), up, over, f"{title} over time", height=190.0, time="x")
        )
        keys += [Key(css, text) for css, text, _ in lines]
    part = [name for name in time for _ in time[name]]
    table: Table = {
        "time": np.concatenate([*time.values()]),
        "part": part,
        "P": normal,
        "Q": tangential,
    }
    return worded(
        "load_path", panels, table, keys, columns=1, beside=len(panels) > 1, stretch=shown.stretch
    )


def _beside_the_forces(shown: _Shown) -> Iterator[tuple[str, str, list[tuple[str, str, Array]]]]:
    """Name, words of the axis and lines (look, words, values) of what a scene has beside P and Q,
    each with its unit.
    """
    (force, _, stress), cycle = units(shown.scene), shown.found
    pulled = [
        (f"σ, {name} body", getattr(cycle, f"bulk_stress_{name}")) for name in ("lower", "upper")
    ]
    pulled = [(words, values) for words, values in pulled if values is not None and np.any(values)]
    if pulled:
        yield (
            "bulk-stress",
            f"bulk stress σ  [{stress}]",
            [(f"line-{k} fine", *line) for k, line in enumerate(pulled)],
        )
    if cycle.tilt is not None and np.any(cycle.tilt):
        yield "tilt", "tilt α  [rad]", [("line-2 fine", "tilt of the upper body", cycle.tilt)]
    if cycle.moment is not None and np.any(cycle.moment) and shown.scene.load.moment_given:
        yield "moment", f"moment M  [{force}]", [("line-3 fine", "moment", cycle.moment)]


def _events(panel: Panel, across: Array, up: Array, chosen: Sequence[Event]) -> Iterator[Mark]:
    """Numbered dots, numbers outside the loop that the dots lie on; a number that would stand on
    another one is left out.
    """
    x, y = panel.frame.x.place(across), panel.frame.y.place(up)
    taken: list[Array] = []
    for count, event in enumerate(chosen, start=1):
        k, data = event.index, {"event": event.index}
        away = 13 * _outward(x, y, k)
        place = np.array([x[k], y[k]]) + away
        yield Dot(float(across[k]), float(up[k]), "event", 3.4, data=data)
        if all(np.hypot(*(place - other)) > 11 for other in taken):
            taken.append(place)
            yield Note(
                float(across[k]),
                float(up[k]),
                str(count),
                "number",
                "middle",
                (float(away[0]), float(away[1]) + 4),
                data,
            )


def _outward(x: Array, y: Array, k: int) -> Array:
    """Unit vector across the line at its k-th place, away from the middle of all places."""
    before, after = max(k - 1, 0), min(k + 1, len(x) - 1)
    across = np.array([y[before] - y[after], x[after] - x[before]])
    from_middle = np.array([x[k] - x.mean(), y[k] - y.mean()])
    if not np.all(np.isfinite(across)) or not np.hypot(*across):
        across = from_middle
    across = -across if across @ from_middle < 0 else across
    return np.asarray(across / (np.hypot(*across) or 1.0))


def _follower(x: str, across: float, up: float, css: str) -> Dot:
    """A ring that the slider moves along Q over another series."""
    return Dot(
        float(across), float(up), f"follow {css}", 6.5, data={"series_x": x, "series_y": "Q"}
    )


def _hysteresis(shown: _Shown) -> Plate | None:
    """Tangential load over tangential displacement in the last cycle, both engines; beside it
    sheared, so that the loop opens.

    None where neither load nor shift moves, or the result holds no shift.
    """
    comparison, scene, cycles = shown.comparison, shown.scene, (shown.expected, shown.found)
    series = (shown.found.tangential_load, *(cycle.tangential_displacement for cycle in cycles))
    if "tangential_displacement" in missing(comparison.result) or all(
        np.ptp(values) == 0 for values in series
    ):
        return None
    load, (force, length, _), loads, panels = (
        load_unit(scene),
        units(scene),
        [c.tangential_load for c in cycles],
        [],
    )
    for name, title, letter, of in (
        ("hysteresis", f"tangential displacement U  [{length}]", "U", "stroke"),
        ("hysteresis-sheared", f"U − k Q, about its mean  [{length}]", "V", "width"),
    ):
        shifts = [
            _sheared_shift(cycle) if letter == "V" else cycle.tangential_displacement
            for cycle in cycles
        ]
        stroke = float(np.ptp(shifts[0])) or 1.0
        note = _measured(
            100 * (shifts[1] - shifts[0]) / stroke, shown.found.fraction, "{}", " %"
        ).rpartition(" at ")[0]
        marks: list[Mark] = [
            Curve(u, q, key.css, key.text)
            for key, u, q in zip(shown.keys, shifts, loads, strict=True)
        ]
        across = Axis(*limits(*shifts, margin=0.12), title, count=4)
        up = Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load}]")
        notes = [f"{note}, of the {of}"] if note else []
        panel = Panel(
            name, across, up, marks, f"Tangential load over {title}", height=330.0, notes=notes
        )
        marks += _events(panel, shifts[1], loads[1], shown.chosen)
        for n, css in enumerate(("now pale", "now")):
            marks.append(
                _follower(f"{letter}{n}", shifts[n][shown.start], loads[n][shown.start], css)
            )
        panels.append(panel)
    bulk = [
        (bulk_strain(c, scene.material), c.shear_moment)
        for c in cycles
        if c.shear_moment is not None
    ]
    if comparison.pulled and len(bulk) == 2:
        marks = [
            Curve(strain, moment, key.css, key.text)
            for key, (strain, moment) in zip(shown.keys, bulk, strict=True)
        ]
        across = Axis(
            *limits(*(strain for strain, _ in bulk), margin=0.12),
            "bulk strain ε = σ/E′, lower − upper",
            count=4,
        )
        up = Axis(
            *limits(*(moment for _, moment in bulk), margin=0.12),
            f"moment of the shear m_q  [{force}]",
        )
        panels.append(
            Panel(
                "bulk-loop", across, up, marks, "Moment of the shear over bulk strain", height=330.0
            )
        )
    works = (
        [loop_work(cycle) for cycle in cycles],
        [bulk_work(cycle, scene.material) for cycle in cycles],
        [comparison.reference.dissipation, comparison.result.dissipation],
    )
    in_words = [" and ".join(minus(f"{work:.5g}") for work in pair) for pair in works]
    table = dict(
        zip(("time", "Q", "U_reference", "U_result"), (shown.found.time, *series), strict=True)
    )
    return worded(
        "hysteresis",
        panels,
        table,
        shown.keys,
        stretch=shown.stretch,
        slopes=" and ".join(signed(_loop_compliance(cycle)) for cycle in cycles),
        unit=f"{length} per {load}",
        periodic=scene.load.path().period is not None,
        # P works too where it varies and the approach hangs on Q as well.
        alone=are_half_planes(scene)
        or (np.ptp(shown.found.normal_load) == 0 and shown.found.tilt is None),
        works=[*in_words, energy_unit(scene)] if comparison.pulled else (),
    )


def _sheared_shift(cycle: Cycle) -> Array:
    """Shift less the mean slope times Q and less its mean: the loop keeps its area and opens."""
    shift = cycle.tangential_displacement - _loop_compliance(cycle) * cycle.tangential_load
    return np.asarray(shift - shift.mean())


def _loop_compliance(cycle: Cycle) -> float:
    """Slope dU/dQ of the straight line through the loop, least squares; 0 where Q stands still."""
    load = cycle.tangential_load - cycle.tangential_load.mean()
    square = float(load @ load)
    return float(load @ cycle.tangential_displacement) / square if square > 0 else 0.0


# ------------------------------------------------------------------- error budget, mesh convergence
# Height of a row [units of a drawing]; one that is so many times as long as the middle one is cut
# off, so that others can be read.
_ROW, _CUT = 44.0, 3.0


def _bars(budget: ErrorBudget) -> Plate | None:
    """The terms of every metric that has a tolerance as a stack over it; None where no metric has
    one.

    What adds to the metric lies right of zero, what takes from it left: the two stacks together are
    E. Where the scene states no tolerance at all, the metrics of the first table in per cent.
    """
    judged = [one for one in budget.budgets if one.metric.tolerance]
    drawn = judged or [one for one in budget.budgets if one.metric.headline]
    if not drawn:
        return None
    rest = "unexplained" if drawn[0].half_planes else "idealisation"
    names = [*(term.name for term in drawn[0].terms), rest]

    def over(one: Budget, *values: float | None) -> Array:
        found = np.array([value or 0.0 for value in values]) / (
            (one.metric.tolerance or 1.0) if judged else 0.01
        )
        return np.where(np.isfinite(found), found, 0.0)

    stacks = [over(one, *(term.value for term in one.terms), one.rest) for one in drawn]
    totals = [over(one, one.total, one.uncertainty) for one in drawn]
    reaches = [
        max(
            float(shares[shares > 0].sum()),
            float(-shares[shares < 0].sum()),
            float(np.abs(total).sum()),
        )
        for shares, total in zip(stacks, totals, strict=True)
    ]
    wide = 1.08 * max(
        1.05 if judged else 0.0, min(max(reaches), _CUT * float(np.median(reaches))) or 1.0
    )
    marks: list[Mark] = []
    for row, (one, shares) in enumerate(zip(drawn, stacks, strict=True)):
        low, ends = float(len(drawn) - row - 1), {True: 0.0, False: 0.0}
        # Zero and the limits are drawn beside the bars alone: on a phone labels reach across them.
        for place, css in ((0.0, "zero"), *(((-1.0, "limit"), (1.0, "limit")) if judged else ())):
            marks.append(Segments(np.array([[[place, low + 0.06], [place, low + 0.56]]]), css))
        for k, (share, name) in enumerate(zip(shares.tolist(), names, strict=True)):
            start = ends[share > 0]
            ends[share > 0] = start + share
            if share:
                label = minus(f"{name}: {share:+.3g} {'of the tolerance' if judged else '%'}")
                marks.append(
                    Block((start, start + share), (low + 0.14, low + 0.5), f"term-{k} edge", label)
                )
        marks += _total(low, float(totals[row][0]), float(totals[row][1]), wide)
        words = (
            f"{one.metric.label}:"
            f" {value_of(one.metric)}{', cut off' if reaches[row] > wide else ''}"
        )
        marks.append(Note(-wide, low + 0.7, words, "tick over", shift=(6.0, 0.0)))
    across = Axis(-wide, wide, "share of the tolerance" if judged else "per cent", count=8)
    up, room = Axis(0.0, float(len(drawn)), "", count=0), (20.0, 12.0, 20.0, 46.0)
    panel = _broad(
        "budget",
        across,
        up,
        marks,
        "Error budget as stacked bars",
        _ROW * len(drawn) + 60,
        room=room,
    )
    columns: dict[str, list[float | None]] = {
        "tolerance": [one.metric.tolerance for one in drawn],
        "E": [one.total for one in drawn],
    }
    columns |= {name: [one.terms[k].value for one in drawn] for k, name in enumerate(names[:-1])}
    columns |= {rest: [one.rest for one in drawn], "u": [one.uncertainty for one in drawn]}
    table = {
        name: [math.nan if value is None else value for value in values]
        for name, values in columns.items()
    }
    keys = [Key(f"term-{k}", name, patch=True) for k, name in enumerate(names)]
    return worded(
        "budget",
        [panel],
        {"metric": [one.metric.key for one in drawn], **table},
        keys,
        columns=1,
        judged=bool(judged),
    )


def _total(low: float, total: float, uncertainty: float, wide: float) -> Iterator[Mark]:
    """E as an upright mark with its uncertainty across it; a head at the edge where it goes on
    beyond.
    """
    middle = low + 0.32
    if abs(total) <= wide:
        yield Curve([total, total], [low + 0.06, low + 0.58], "total")
    left, right = max(total - uncertainty, -wide), min(total + uncertainty, wide)
    if right > left:
        yield Curve([left, right], [middle, middle], "whisker")
    for side in (-1, 1):
        if side * total + uncertainty > wide:
            tip, back = side * 0.998 * wide, side * 0.985 * wide
            yield Curve([back, tip, back], [middle - 0.1, middle, middle + 0.1], "whisker")


def _mesh_refinement(budget: ErrorBudget) -> Plate | None:
    """|phi(h) - phi(0)| of the headline metrics over the element size; None for two meshes or where
    no metric converges.
    """
    runs, curves = [run for run in budget.refinements.mesh if not run.failure], {}
    for one in budget.budgets:
        values = [(run.size, run.values.get(one.metric.key)) for run in runs]
        points = [
            (size, float(value))
            for size, value in values
            if value is not None and math.isfinite(value)
        ]
        if one.metric.headline and len(points) >= 3:
            found = extrapolate(
                Refinement(
                    tuple(size for size, _ in points),
                    tuple(value for _, value in points),
                    2.0,
                    ROUNDING,
                )
            )
            if found.kind == "monotone" and found.value is not None:
                curves[one.metric.label] = [
                    (size, abs(value - found.value))
                    for size, value in points
                    if value != found.value
                ]
    words = "element size, over that of the run", "distance from the value at size zero"
    return _convergence("mesh_refinement", words, curves, [run.size for run in runs])


def _distances(study: Study) -> Plate | None:
    """|E(h) - E(0)| of each headline metric that goes to a value, over the element size; None for
    two meshes or where none does.
    """
    sizes, curves = [level.size for level in study.levels], {}
    for line in study.lines:
        if (
            line.metric.headline
            and line.found.kind == "monotone"
            and (limit := line.found.value) is not None
        ):
            curves[line.metric.label] = [
                (size, abs(value - limit)) for size, value in zip(sizes, line.values, strict=True)
            ]
    return _convergence(
        "study", ("element size at the contact", "distance from the value at h = 0"), curves, sizes
    )


def _convergence(
    name: str,
    words: tuple[str, str],
    found: Mapping[str, list[tuple[float, float]]],
    used: Sequence[float],
) -> Plate | None:
    """Distances over the element size, both logarithmic, beside lines of order 1 and 2."""
    curves = {
        label: points for label, points in found.items() if any(height > 0 for _, height in points)
    }
    if len(used) < 3 or not curves:
        return None
    sizes, places = (
        np.array(sorted(used)),
        [point for points in curves.values() for point in points],
    )
    heights = [height for _, height in places if height > 0]
    top, marks, keys = max(heights), list[Mark](), []
    slopes = [Key(f"slope order-{order}", f"order {order}") for order in (1, 2)]
    marks += [
        Curve(sizes, top * (sizes / sizes[-1]) ** order, key.css, key.text)
        for order, key in enumerate(slopes, 1)
    ]
    for (label, points), css in zip(curves.items(), _LINES, strict=False):
        marks.append(Curve([h for h, _ in points], [height for _, height in points], css, label))
        marks += [Dot(h, height, f"{css} knot", 3.2) for h, height in points if height > 0]
        keys.append(Key(css, label))
    across = Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), words[0], log=True)
    # Below a millionth of the largest distance a curve is round-off.
    up = Axis(max(min(heights), 1e-6 * top) / 3, 3 * top, words[1], log=True)
    panel = _broad(
        name, across, up, marks, "Convergence with the mesh, both axes logarithmic", 360.0
    )
    table: dict[str, Any] = {"metric": [label for label, points in curves.items() for _ in points]}
    table |= {
        column: [point[k] for point in places] for k, column in enumerate(("size", "distance"))
    }
    return worded(name, [panel], table, [*keys, *slopes], columns=1)


# --------------------------------------------------------------------------------------- the bodies
# Half the width of a half-plane as drawn, over a or over the half-width of the body that it faces.
_SHOWN_OF_CONTACT, _SHOWN_OF_BODY = 6.0, 1.3
_WIDTH, _MOST, _ROOM, _SIDE = 440.0, 310.0, 76.0, 30.0
# Rows of a measured profile that are drawn.
_MOST_DOTS = 400


def sketch(scene: Scene, half_width: float) -> Plate:
    """Both bodies to scale with supports, loads and the place of the contact.

    Parameters
    ----------
    half_width : of the contact, drawn to scale [length]
    """
    length = units(scene)[1]
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    frame = _frame(outlines)
    level = float(frame.y.place(0.0))
    marks: list[Mark] = []
    for name, points in outlines.items():
        shape = getattr(scene.bodies, name)
        marks += [
            *_body(frame, points, shape, name),
            *_supports(frame, shape, points, 1.0 if name == "lower" else -1.0),
        ]
        marks.append(
            Note(6.0, 16.0 if name == "upper" else frame.height - 6, _label(scene, name), "word")
        )
    marks.append(Curve(frame.x.place([-half_width, half_width]), [level, level], "contact-line"))
    marks += _loads(frame, scene, outlines)
    columns: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    alt = bodies_in_words(scene)
    # Places of the marks are those of the drawing: supports and arrows have no size in the scene.
    axes = Axis(0.0, frame.width, ""), Axis(frame.height, 0.0, "")
    panel = Panel(
        "bodies", *axes, marks, alt, frame.width, frame.height, bare=True, room=(0.0, 0.0, 0.0, 0.0)
    )
    return worded(
        "bodies",
        [panel],
        columns,
        columns=1,
        cut=any(isinstance(body, HalfPlane) for body in (scene.bodies.lower, scene.bodies.upper)),
        width=number(2 * half_width),
        length=length,
        normal=_range(scene, 0),
        tangential=_range(scene, 1),
        load=load_unit(scene),
        beside=bulk_and_tilt(scene),
        alt=alt,
    )


def fit_residuals(scene: Scene, half_width: float) -> Plate | None:
    """Rows minus the curve fitted to them, beside twice their noise; None of a profile that is not
    fitted.

    Parameters
    ----------
    half_width : of the largest contact [length]
    """
    fitted = fit_of(scene)
    if fitted is None:
        return None
    length = units(scene)[1]
    x = fitted.rows.values[:, 0] - fitted.centre
    rest = fitted.residuals(scene.profile.height)
    used = np.abs(x) <= np.sort(np.abs(x))[len(x) - fitted.left_out - 1]
    shown = np.flatnonzero(used)[:: -(-int(used.sum()) // _MOST_DOTS)]
    most = 1.1 * max(float(np.abs(rest[used]).max()), 2.2 * fitted.noise)
    across = Axis(*limits(x[used], margin=0.02), f"x from the middle  [{length}]")
    wide = np.full(int(used.sum()), 2 * fitted.noise)
    marks: list[Mark] = [Band(x[used], -wide, wide, "band pale-stick")]
    marks += [
        Rule(0.0, "zero"),
        *(Rule(side * half_width, "cycle-line", upright=True) for side in (-1, 1)),
    ]
    marks += [
        Dot(float(x[k]), float(rest[k]), "p0", 2.2, f"x = {x[k]:.4g}, {rest[k]:.3g} {length}")
        for k in shown
    ]
    up = Axis(-most, most, f"row − fit  [{length}]")
    return worded(
        "profile_fit",
        [Panel("profile-fit", across, up, marks, "Residuals of the fit", height=260.0)],
        {f"x [{length}]": x, f"row - fit [{length}]": rest, "fitted": used.astype(float)},
        columns=1,
        rows=used.sum(),
        residual=f"{fitted.residual:.3g}",
        noise=f"{fitted.noise:.3g}",
        length=length,
        every=shown[1] - shown[0],
    )


def _frame(outlines: dict[str, Array]) -> Frame:
    """Both bodies with one scale in both directions, room above for the loads and all round for
    supports.
    """
    points = np.concatenate(list(outlines.values()))
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    unit = max((right - left) / (_WIDTH - 2 * _SIDE), (high - low) / (_MOST - _ROOM - _SIDE))
    height = (high - low) / unit + _ROOM + _SIDE
    middle, half = (left + right) / 2, (_WIDTH / 2 - _SIDE) * unit
    across = Scale(float(middle - half), float(middle + half), _SIDE, _WIDTH - _SIDE)
    return Frame(
        across, Scale(float(low), float(high), float(height - _SIDE), _ROOM), _WIDTH, float(height)
    )


def outline(scene: Scene, name: str, half_width: float) -> Array:
    """(n, 2) outline of a body in the common frame, from the left end of its face to the right one
    and round its base [length].

    A half-plane is drawn as a piece of itself: as wide as suits the other body, or the contact.
    """
    shape, other = (
        getattr(scene.bodies, name),
        getattr(scene.bodies, "upper" if name == "lower" else "lower"),
    )
    side = 1.0 if name == "lower" else -1.0
    width = shape.face_half_width
    if isinstance(shape, HalfPlane):
        width = (
            _SHOWN_OF_CONTACT * half_width
            if isinstance(other, HalfPlane)
            else _SHOWN_OF_BODY * other.face_half_width
        )
    # Finer towards the ends, where an arc is steep.
    x = width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 181))
    face = np.column_stack([x, -side * face_of(shape, scene.profile).depth(x)])
    height = 0.5 * width if isinstance(shape, HalfPlane) else getattr(shape, "height", 0.0)
    corners = np.array([[width, -side * height], [-width, -side * height]])
    return face if isinstance(shape, Cylinder) else np.vstack([face, corners])


def _body(frame: Frame, points: Array, shape: Shape, name: str) -> Iterator[Mark]:
    """A filled body; a half-plane has a line along its face alone, for it goes on everywhere
    else.
    """
    x, y = frame.x.place(points[:, 0]), frame.y.place(points[:, 1])
    yield Curve(x, y, f"body {name}", closed=True)
    if not isinstance(shape, HalfPlane):
        yield Curve(x, y, "body-line", closed=True)
        return
    corners = [180, 181, 182, 0]
    yield Curve(x[:181], y[:181], "body-line")
    yield Curve(x[corners], y[corners], "cut-line")


def _supports(frame: Frame, shape: Shape, points: Array, side: float) -> Iterator[Mark]:
    """A rigid plane along the base and along guided sides, rollers between it and the body where
    there are some.
    """
    if isinstance(shape, HalfPlane):
        return
    (left, right), top = (
        frame.x.place([-shape.face_half_width, shape.face_half_width]).tolist(),
        float(frame.y.place(points[0, 1])),
    )
    base = float(frame.y.place(points[np.argmax(-side * points[:, 1]), 1]))
    planes = [((left, base), (right, base), (0.0, side), getattr(shape, "base", "") == "rollers")]
    if getattr(shape, "sides", "") == "guided":
        planes += [
            ((x, base), (x, top), (outward, 0.0), True)
            for x, outward in ((left, -1.0), (right, 1.0))
        ]
    for start, end, outward, rollers in planes:
        first, last, normal, size = np.array(start), np.array(end), np.array(outward), 10.0
        if rollers:
            for x, y in (
                first + np.linspace(0.08, 0.92, 7)[:, None] * (last - first) + normal * size / 3
            ):
                yield Dot(float(x), float(y), "roller", size / 3)
            first, last = first + normal * 2 * size / 3, last + normal * 2 * size / 3
        along = (last - first) / np.hypot(*(last - first))
        feet = first + np.linspace(0, 1, max(int(np.hypot(*(last - first)) / 8), 4))[:, None] * (
            last - first
        )
        yield Curve([first[0], last[0]], [first[1], last[1]], "wall")
        yield Segments(
            np.stack([feet, feet + 0.7 * size * (normal - along)], axis=1), "curve hatch"
        )


def _label(scene: Scene, name: str) -> str:
    """Kind, sizes and material of a body."""
    shape, material = getattr(scene.bodies, name), getattr(scene.material, name)
    _, length, stress = units(scene)
    size = ""
    if isinstance(shape, Cylinder):
        size = f" R = {number(shape.radius)} {length}"
    elif not isinstance(shape, HalfPlane):
        size = f" {number(shape.width)} × {number(shape.height)} {length}"
    elastic = f"E = {number(material.young_modulus)} {stress}, ν = {number(material.poisson_ratio)}"
    return f"{name}: {shape.kind.replace('_', '-')}{size}, {elastic}"


def _loads(frame: Frame, scene: Scene, outlines: dict[str, Array]) -> Iterator[Mark]:
    """Arrows of P and Q at the top of the upper body; of its tilt or moment, and of bulk stress at
    both ends.
    """
    load, top = scene.load, float(frame.y.place(outlines["upper"][:, 1].max())) - 8
    line, contact = load.line_of_action, float(frame.y.place(0.0))
    # the words below say where it is
    x = float(np.clip(frame.x.place(line.x if line else 0.0), 80.0, frame.width - 80.0))
    if line is not None:
        yield Curve([x, x], [contact - 0.3 * (contact - top), contact], "cycle-line")
    yield Arrow((x, top - 42), (x, top))
    yield Note(x - 9, top - 28, "P", "load", "end")
    if np.any(_samples(scene, 1) != 0):
        yield Arrow((x + 8, top - 8), (x + 58, top - 8))
        yield Note(x + 63, top - 3, "Q", "load")
    if load.tilt is not None or load.moment is not None:
        # A positive tilt opens the gap at x > 0; a positive moment presses there, and so turns the
        # other way.
        middle, turn = (x - 48.0, top - 17.0), 1.0 if load.tilt is not None else -1.0
        angle = np.linspace(-0.2, 1.2, 29) * np.pi
        arc = np.column_stack(
            [middle[0] + turn * 18 * np.cos(angle), middle[1] - 18 * np.sin(angle)]
        )
        yield Curve(arc[:-3, 0], arc[:-3, 1], "arrow")
        yield Arrow((arc[-8, 0], arc[-8, 1]), (arc[-1, 0], arc[-1, 1]))
        yield Note(
            middle[0], middle[1] + 5, "α" if load.tilt is not None else "M", "load", "middle"
        )
    for name, stress in (("lower", load.bulk_stress_lower), ("upper", load.bulk_stress_upper)):
        if stress is not None:
            ends, level = (
                frame.x.place(outlines[name][[0, 180], 0]),
                float(np.mean(frame.y.place(outlines[name][[0, -1], 1]))),
            )
            for end, outward in zip(ends.tolist(), (-1.0, 1.0), strict=True):
                yield Arrow((end + 3 * outward, level), (end + 23 * outward, level))
                yield Note(end + 13 * outward, level - 9, "σ", "load", "middle")


def _samples(scene: Scene, which: int) -> Array:
    """P or Q all along the path."""
    path = scene.load.path()
    return np.asarray(path.at(np.concatenate([sampled(leg, 181) for leg in path.legs(1)]))[which])


def _range(scene: Scene, which: int) -> str:
    loads = _samples(scene, which)
    least, most = (number(float(f"{value:.4g}")) for value in (loads.min(), loads.max()))
    return f"= {most}" if least == most else f"from {least} to {most}"
