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
from typing import TYPE_CHECKING, Any, NamedTuple

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
        replaced
    vtu_instants : times at which both bodies are written for ParaView; none by default
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
        # before the page: one that fails must not cost what took long to solve
        comparison.reference.save(folder / SOLUTIONS[0])
        comparison.result.save(folder / SOLUTIONS[1])
        drawings = draw(report)
        if stress_instants:
            drawings += (_stress(comparison, stress_instants),)
        tables = {drawing.name: drawing.csv() for drawing in drawings}
        (folder / "figures").mkdir()
        for name, text in tables.items():
            (folder / "figures" / f"{name}.csv").write_text(text, encoding="utf-8")
        scene_text = comparison.scene.model_dump_json(indent=1) + "\n"
        (folder / "scene.json").write_text(scene_text, encoding="utf-8")
        comparison_text = as_json(report, command, seconds) + "\n"
        (folder / "comparison.json").write_text(comparison_text, encoding="utf-8")
        if vtu_instants is not None and len(vtu_instants):
            _write_vtu(comparison, vtu_instants, folder / "fields")
        third = _write_third(comparison, report.third, folder) if report.third else None
        live = _cycle_data(_Shown(comparison)) | {"tables": _tables(tables)}
        page = render(report, drawings, command, seconds or {}, live, third)
        (folder / "report.html").write_text(page, encoding="utf-8")
        if log:
            log_text = "\n".join([*log, headline(report), verdict(report)]) + "\n"
            (folder / "run.log").write_text(log_text, encoding="utf-8")
    return Path(out) / "report.html"


def _stress(comparison: Comparison, instants: Sequence[Instant]) -> Plate:
    """Von Mises' stress of the result's bodies at these instants."""
    import halfplane_fe
    from reports.field_output.pictures import scales_of, stress

    answer = with_bodies(comparison.result, "--stress")
    snapshots = halfplane_fe.fields(answer, [instant.time for instant in instants])
    return stress(answer, snapshots, instants, scales_of(snapshots))


def _write_vtu(comparison: Comparison, times: Sequence[float], folder: Path) -> None:
    """Both bodies of the result at these times, for ParaView."""
    import halfplane_fe

    answer = with_bodies(comparison.result, "--vtu")
    write_fields(answer, halfplane_fe.fields(answer, times), folder)


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
    scene = comparison.scene
    sentences = words.said(report)
    profile_findings = findings(scene)[0]
    bodies = [sentences["bodies"], sentences["unlike_materials"], *profile_findings]
    program, digest = script()
    return template("report.html").render(
        sentences | {"bodies": bodies},
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
    of_metrics = []
    for metric in comparison.headlines:
        note, label = metric.note, metric.label
        if note and note.lower().startswith(label.lower()):
            of_metrics.append(words.sentence(note))
        elif note:
            of_metrics.append(words.sentence(f"{label}: {note}"))
    return [*of_metrics, *comparison.notes]


def _dissipations(comparison: Comparison) -> Iterator[dict[str, str]]:
    """Dissipation of each solution: both routes and every cycle."""

    def shown(value: float | None, digits: int = 8) -> str:
        """A dash for what a solution does not hold."""
        return "–" if value is None or np.isnan(value) else minus(f"{value:.{digits}g}")

    polygon = comparison.polygon_reference
    for solution in filter(None, (comparison.reference, polygon, comparison.result)):
        name = name_of(solution.engine)
        if solution is polygon:
            name += ", on the polygon of the steps"
        work = solution.dissipation
        loop = solution.loop_work
        normal = normal_work(solution)
        difference = "–"
        if work and not np.isnan(loop):
            difference = minus(f"{abs((loop + (normal or 0.0)) / work - 1):.1e}")
        yield {
            "name": name,
            "value": shown(work),
            "scaled": shown(work / comparison.scales.dissipation),
            "loop": shown(loop),
            # of the instants that the solution has
            "bulk": shown(bulk_work(last_cycle(solution), solution.scene.material)),
            "normal": shown(normal),
            "apart": difference,
            "cycles": ", ".join(shown(of_cycle, 6) for of_cycle in solution.cycle_dissipation),
        }


def _flat(settings: Mapping[str, Any], above: str = "") -> dict[str, str]:
    """Nested settings as one list, names joined by dots, numbers to six digits.

    >>> _flat({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    flat: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            flat |= _flat(value, f"{above}{name}.")
        else:
            flat[above + name] = f"{value:.6g}" if isinstance(value, float) else str(value)
    return flat


# ---------------------------------------------------------------------------- what the slider moves
# Largest number of instants, and of instants times points, that a page carries: 1.6 MB.
_MOST_INSTANTS = 200
_MOST_VALUES = 100_000
# Letters of the longest CSV that a page carries.
_LETTERS = 1_500_000
_STEPS = 32766
_NOTHING = -32768  # stands for what is no number


def _quantised(values: Array) -> dict[str, Any]:
    """Numbers as 16-bit whole numbers of a step, little-endian in base64; what is not finite is a
    number of its own.

    >>> _quantised(np.array([0.0, 2.0, -1.0]))["step"] * 32766
    2.0
    """
    finite = np.isfinite(values)
    step = float(np.max(np.abs(values[finite]), initial=0.0)) / _STEPS or 1.0
    steps = np.rint(np.where(finite, values, 0.0) / step)
    numbers = np.where(finite, steps, _NOTHING).astype("<i2")
    return {"step": step, "data": base64.b64encode(numbers.tobytes()).decode()}


def _cycle_data(shown: _Shown) -> dict[str, Any]:
    """Everything that the slider moves, and how much of the cycle that is."""
    comparison, scene = shown.comparison, shown.scene
    rows = _carried_instants(shown)
    points = _carried_points(shown, len(rows))
    series = {
        "t": shown.time,
        "P": shown.found.normal_load,
        "Q": shown.found.tangential_load,
        "U0": shown.expected.tangential_displacement,
        "U1": shown.found.tangential_displacement,
        "V0": _sheared_shift(shown.expected),
        "V1": _sheared_shift(shown.found),
    }
    fields, states = _carried_fields(shown, np.ix_(rows, points))
    places = _places(comparison)
    return {
        "instants": len(rows),
        "points": len(points),
        "of": [len(shown.found.time), len(shown.found.x)],
        "stretch": shown.stretch,
        "rows": rows.tolist(),
        "x": [_seven_digits(place) for place in shown.x[points]],
        "series": {name: list(map(_seven_digits, values[rows])) for name, values in series.items()},
        "fields": fields,
        "states": base64.b64encode(states.tobytes()).decode(),
        "events": [[_place_of(event.index, rows), event.label] for event in shown.chosen],
        "start": _place_of(shown.start, rows),
        "slip_points": [_place_of(place, points) for place in places],
        "time_words": shown.time_words,
        "load_unit": load_unit(scene),
        "length": units(scene)[1],
        "engines": [side.engine for side in shown.sides],
    }


def _carried_instants(shown: _Shown) -> NDArray[np.int_]:
    """All instants, or evenly many of them with the first, the last and the chosen ones."""
    last = len(shown.found.time) - 1
    even = np.linspace(0, last, min(last + 1, _MOST_INSTANTS)).round().astype(int)
    return np.unique([*even.tolist(), 0, last, *(event.index for event in shown.chosen)])


def _carried_points(shown: _Shown, instants: int) -> NDArray[np.int_]:
    """Of the points that are drawn as many as fit, with the last and those whose slip is shown."""
    inside = np.flatnonzero(np.abs(shown.x) <= 1.02 * shown.wide)
    stride = -(-len(inside) * instants // _MOST_VALUES)
    return np.unique([*inside[::stride].tolist(), inside[-1], *_places(shown.comparison)])


def _carried_fields(
    shown: _Shown, grid: tuple[NDArray[np.int_], ...]
) -> tuple[dict[str, Any], NDArray[np.uint8]]:
    """p, q and s of the reference with the differences of the result, and the states of both."""
    sizes = {
        "p": ("pressure", shown.scales.pressure),
        "q": ("shear", shown.scales.shear),
        "s": ("slip", 1.0),
    }
    fields = {}
    for key, (name, size) in sizes.items():
        of_reference = getattr(shown.expected, name)[grid] / size
        of_result = getattr(shown.found, name)[grid] / size
        fields[key] = _quantised(of_reference)
        fields[f"d{key}"] = _quantised(of_result - of_reference)
    state_of_result = shown.found.state[grid].astype(np.uint8)
    return fields, shown.expected.state[grid].astype(np.uint8) + 4 * state_of_result


def _seven_digits(value: float) -> float | None:
    """A number for the page; None for what is no number."""
    return float(f"{value:.7g}") if np.isfinite(value) else None


def _place_of(index: int, indices: NDArray[np.int_]) -> int:
    """Where an index stands among those that the page carries."""
    return int(np.flatnonzero(indices == index)[0])


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
_COLUMNS = 440
_ROWS = 360
# Rows of the table of states: of a long path evenly many instants, 25 MB.
_MOST_STATES = 500_000
_ZERO = Rule(0.0, "zero")


class _Side(NamedTuple):
    """One engine in the figures."""

    look: str  # of its lines
    cycle: Cycle
    engine: str  # its name


class _Shown:
    """What the figures of a comparison share.

    Attributes
    ----------
    sides : the reference and the result; keys : their entries of a legend
    chosen : the instants that have a number in every figure
    start : of these the one that a page shows first: with most points slipping, of equal ones the
    most loaded time, time_words : the axis of figures through the last cycle
    stretch, noun : what the values are of, "last cycle", "whole record" or "whole path", and its
        last word
    x, wide : points over a_ref; the largest of them that is drawn, a little more than the largest
        contact of either
    """

    def __init__(self, comparison: Comparison) -> None:
        self.comparison = comparison
        self.scene = comparison.scene
        self.scales = comparison.scales
        self.stretch = words.stretch(comparison.scene)
        self.noun = self.stretch.split()[-1]
        self.expected = comparison.expected
        self.found = comparison.found
        self.sides = (
            _Side("r", self.expected, name_of(comparison.reference.engine)),
            _Side("f", self.found, name_of(comparison.result.engine)),
        )
        self.keys = [Key(f"{side.look} p", side.engine) for side in self.sides]
        self.chosen = events(self.found, self.scene.friction.coefficient)
        self.start = max((event.index for event in self.chosen), key=self._slip_and_load)
        self.time = self.found.time
        self.time_words = "time"
        if self.scene.load.path().period is not None and self.found.whole:
            self.time = self.found.fraction
            self.time_words = "time / period"
        self.x = self.found.x / self.scales.half_width
        self.wide = self._largest_place() / self.scales.half_width

    def _slip_and_load(self, instant: int) -> tuple[int, float]:
        """How many points slip at an instant, and P there."""
        slipping = int((self.found.state[instant] >= 2).sum())
        return slipping, float(self.found.normal_load[instant])

    def _largest_place(self) -> float:
        """The largest |x| that is drawn [length]; every point where nothing touches."""
        edges = (self.expected.contact_edges, self.found.contact_edges)
        outer = max(float(np.nanmax(np.abs(edge), initial=0.0)) for edge in edges) or np.inf
        return min(1.12 * outer, float(np.abs(self.found.x).max()))

    def over_time(self, count: int = 5) -> Axis:
        """The axis of time."""
        return Axis(*limits(self.time, margin=0), self.time_words, count=count)

    def over_x(self, words: str = _X) -> Axis:
        """The axis of x."""
        return Axis(-self.wide, self.wide, words)

    def largest(self, difference: Array, unit: str) -> str:
        """The numbers of a difference over time."""
        where = "t/T = {}" if "period" in self.time_words else "t = {}"
        return _measured(difference, self.time, where, unit)


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
    largest = difference[worst] + 0.0
    return minus(f"rms {_short(rms)}{unit}, largest {_short(largest)}{unit} at ") + place


def _short(value: float) -> str:
    """Two digits, or all before the point."""
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"


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
_ROW = 44.0
_CUT = 3.0


def _bars(budget: ErrorBudget) -> Plate | None:
    """The terms of every metric that has a tolerance as a stack over it; None where no metric has
    one.

    What adds to the metric lies right of zero, what takes from it left: the two stacks together are
    E. Where the scene states no tolerance at all, the metrics of the first table in per cent.
    """
    with_tolerance = [row for row in budget.budgets if row.metric.tolerance]
    headlines = [row for row in budget.budgets if row.metric.headline]
    budgets = with_tolerance or headlines
    if not budgets:
        return None

    judged = bool(with_tolerance)
    rest_name = "unexplained" if budgets[0].half_planes else "idealisation"
    term_names = [term.name for term in budgets[0].terms]
    names = [*term_names, rest_name]
    stacks = [_stack(row, judged) for row in budgets]
    half_width = _half_width_of_bars(stacks, judged)

    marks: list[Mark] = []
    for row, stack in enumerate(stacks):
        low = float(len(stacks) - row - 1)
        marks += _limits_of_bar(low, judged)
        marks += _blocks_of_bar(low, stack, names, judged)
        marks += _total(low, stack.total, stack.uncertainty, half_width)
        cut_off = ", cut off" if stack.reach > half_width else ""
        text = f"{stack.budget.metric.label}: {value_of(stack.budget.metric)}{cut_off}"
        marks.append(Note(-half_width, low + 0.7, text, "tick over", shift=(6.0, 0.0)))

    panel = _broad(
        "budget",
        Axis(-half_width, half_width, _axis_of_bars(judged), count=8),
        Axis(0.0, float(len(budgets)), "", count=0),
        marks,
        "Error budget as stacked bars",
        _ROW * len(budgets) + 60,
        room=(20.0, 12.0, 20.0, 46.0),
    )
    keys = [Key(f"term-{place}", name, patch=True) for place, name in enumerate(names)]
    table = _budget_table(budgets, term_names, rest_name)
    return worded("budget", [panel], table, keys, columns=1, judged=judged)


def _axis_of_bars(judged: bool) -> str:
    """Words of the axis along the bars."""
    return "share of the tolerance" if judged else "per cent"


class _Stack(NamedTuple):
    """The budget of a metric as shares of its tolerance, or in per cent."""

    budget: Budget
    shares: Array  # (k,) of each term, then of what no term explains
    total: float  # E
    uncertainty: float  # of E

    @property
    def reach(self) -> float:
        """How far its bar goes from zero, on the longer side."""
        right = float(self.shares[self.shares > 0].sum())
        left = float(-self.shares[self.shares < 0].sum())
        return max(right, left, abs(self.total) + self.uncertainty)


def _stack(budget: Budget, judged: bool) -> _Stack:
    """The stack of a metric; what is unknown or infinite has no length."""
    unit = 0.01
    if judged:
        unit = budget.metric.tolerance or 1.0

    def share(value: float | None) -> float:
        length = (value or 0.0) / unit
        return length if math.isfinite(length) else 0.0

    shares = [share(term.value) for term in budget.terms]
    shares.append(share(budget.rest))
    total = share(budget.total)
    uncertainty = share(budget.uncertainty)
    return _Stack(budget, np.array(shares), total, uncertainty)


def _half_width_of_bars(stacks: Sequence[_Stack], judged: bool) -> float:
    """Half the width of the axis: the longest bar, or where one is far longer than the middle one
    a multiple of that; the limits at 1 are always on it.
    """
    reaches = [stack.reach for stack in stacks]
    longest = min(max(reaches), _CUT * float(np.median(reaches))) or 1.0
    return 1.08 * max(1.05 if judged else 0.0, longest)


def _limits_of_bar(low: float, judged: bool) -> Iterator[Mark]:
    """Zero, and the limits of the tolerance, beside the bar alone: on a phone labels reach across
    them.
    """
    lines = [(0.0, "zero")]
    if judged:
        lines += [(-1.0, "limit"), (1.0, "limit")]
    for place, css in lines:
        yield Segments(np.array([[[place, low + 0.06], [place, low + 0.56]]]), css)


def _blocks_of_bar(low: float, stack: _Stack, names: Sequence[str], judged: bool) -> Iterator[Mark]:
    """A block for each term, to the right of those that add, to the left of those that take."""
    right_end = 0.0
    left_end = 0.0
    unit = "of the tolerance" if judged else "%"
    for place, (share, name) in enumerate(zip(stack.shares.tolist(), names, strict=True)):
        if share > 0:
            start = right_end
            right_end += share
        else:
            start = left_end
            left_end += share
        if share:
            label = minus(f"{name}: {share:+.3g} {unit}")
            ends = (start, start + share)
            yield Block(ends, (low + 0.14, low + 0.5), f"term-{place} edge", label)


def _budget_table(budgets: Sequence[Budget], term_names: Sequence[str], rest_name: str) -> Table:
    """A row for each metric: tolerance, E, its terms, what is left, uncertainty."""
    columns: dict[str, list[float | None]] = {
        "tolerance": [row.metric.tolerance for row in budgets],
        "E": [row.total for row in budgets],
    }
    for place, name in enumerate(term_names):
        columns[name] = [row.terms[place].value for row in budgets]
    columns[rest_name] = [row.rest for row in budgets]
    columns["u"] = [row.uncertainty for row in budgets]
    table: dict[str, Any] = {"metric": [row.metric.key for row in budgets]}
    for name, values in columns.items():
        table[name] = [math.nan if value is None else value for value in values]
    return table


def _total(low: float, total: float, uncertainty: float, half_width: float) -> Iterator[Mark]:
    """E as an upright mark with its uncertainty across it; a head at the edge where it goes on
    beyond.
    """
    middle = low + 0.32
    if abs(total) <= half_width:
        yield Curve([total, total], [low + 0.06, low + 0.58], "total")
    left = max(total - uncertainty, -half_width)
    right = min(total + uncertainty, half_width)
    if right > left:
        yield Curve([left, right], [middle, middle], "whisker")
    for side in (-1, 1):
        if side * total + uncertainty > half_width:
            tip = side * 0.998 * half_width
            back = side * 0.985 * half_width
            yield Curve([back, tip, back], [middle - 0.1, middle, middle + 0.1], "whisker")


def _mesh_refinement(budget: ErrorBudget) -> Plate | None:
    """|phi(h) - phi(0)| of the headline metrics over the element size; None for two meshes or where
    no metric converges.
    """
    runs = [run for run in budget.refinements.mesh if not run.failure]
    curves: dict[str, list[tuple[float, float]]] = {}
    for row in budget.budgets:
        metric = row.metric
        points = [(run.size, run.values.get(metric.key)) for run in runs]
        known = [
            (size, float(value))
            for size, value in points
            if value is not None and math.isfinite(value)
        ]
        if not metric.headline or len(known) < 3:
            continue
        sizes = tuple(size for size, _ in known)
        values = tuple(value for _, value in known)
        limit = extrapolate(Refinement(sizes, values, 2.0, ROUNDING))
        if limit.kind == "monotone" and limit.value is not None:
            curves[metric.label] = [
                (size, abs(value - limit.value)) for size, value in known if value != limit.value
            ]
    axes = "element size, over that of the run", "distance from the value at size zero"
    return _convergence("mesh_refinement", axes, curves, [run.size for run in runs])


def _distances(study: Study) -> Plate | None:
    """|E(h) - E(0)| of each headline metric that goes to a value, over the element size; None for
    two meshes or where none does.
    """
    sizes = [level.size for level in study.levels]
    curves: dict[str, list[tuple[float, float]]] = {}
    for line in study.lines:
        limit = line.found.value
        converges = line.found.kind == "monotone" and limit is not None
        if line.metric.headline and converges:
            curves[line.metric.label] = [
                (size, abs(value - limit)) for size, value in zip(sizes, line.values, strict=True)
            ]
    axes = "element size at the contact", "distance from the value at h = 0"
    return _convergence("study", axes, curves, sizes)


def _convergence(
    name: str,
    axes: tuple[str, str],
    distances: Mapping[str, list[tuple[float, float]]],
    element_sizes: Sequence[float],
) -> Plate | None:
    """Distances over the element size, both logarithmic, beside lines of order 1 and 2.

    Parameters
    ----------
    axes : words of the two axes
    distances : label of a metric -> (element size, distance); one that is 0 everywhere is left out
    element_sizes : of all meshes; None is returned for fewer than three
    """
    curves = {
        label: points
        for label, points in distances.items()
        if any(distance > 0 for _, distance in points)
    }
    if len(element_sizes) < 3 or not curves:
        return None

    sizes = np.array(sorted(element_sizes))
    all_points = [point for points in curves.values() for point in points]
    positive = [distance for _, distance in all_points if distance > 0]
    top = max(positive)

    slopes = [Key(f"slope order-{order}", f"order {order}") for order in (1, 2)]
    marks: list[Mark] = []
    for order, key in enumerate(slopes, 1):
        marks.append(Curve(sizes, top * (sizes / sizes[-1]) ** order, key.css, key.text))
    keys = []
    for (label, points), css in zip(curves.items(), _LINES, strict=False):
        curve_sizes = [size for size, _ in points]
        curve_distances = [distance for _, distance in points]
        marks.append(Curve(curve_sizes, curve_distances, css, label))
        for size, distance in points:
            if distance > 0:
                marks.append(Dot(size, distance, f"{css} knot", 3.2))
        keys.append(Key(css, label))

    words_across, words_up = axes
    across = Axis(0.8 * float(sizes.min()), 1.25 * float(sizes.max()), words_across, log=True)
    # Below a millionth of the largest distance a curve is round-off.
    lowest = max(min(positive), 1e-6 * top)
    up = Axis(lowest / 3, 3 * top, words_up, log=True)
    alt = "Convergence with the mesh, both axes logarithmic"
    panel = _broad(name, across, up, marks, alt, 360.0)
    table: dict[str, Any] = {
        "metric": [label for label, points in curves.items() for _ in points],
        "size": [size for size, _ in all_points],
        "distance": [distance for _, distance in all_points],
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
