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
from reports.comparison import Comparison, budget_words, words
from reports.comparison.budget import ROUNDING, Budget, ErrorBudget, Refinement, extrapolate
from reports.comparison.cycles import Cycle, Event, events, last_cycle
from reports.comparison.metrics import missing
from reports.comparison.pairs import are_half_planes, name_of
from reports.comparison.words import bodies_in_words, bulk_and_tilt, headline, value_of, verdict
from reports.comparison.work_of_loads import bulk_strain, bulk_work, loop_work, normal_work
from reports.field_output.files import with_bodies, write_fields
from reports.folder import filled
from reports.measured import section
from reports.page.content import as_json, common_content
from reports.profile_fit import findings, fit_of
from reports.report import Report, ThirdAnswer
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
    found
        what `compare` or `score` returned, or a `Report` of more
    out
        folder; made if need be; of what is in it already only an earlier run's own files are
        replaced
    vtu_instants
        times at which both bodies are written for ParaView; none by default
    command
        what reproduces the report
    seconds
        stage -> wall time, for the page
    stress_instants
        where the page shows von Mises' stress; nowhere by default
    log
        lines of run.log; without any there is none

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
            log_text = "\n".join([*log, headline(comparison), verdict(comparison)]) + "\n"
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
    drawings
        the figures; one that is missing leaves its place empty
    command
        what reproduces the page
    seconds
        stage -> wall time
    live
        what the slider moves through; without it the page has none
    third
        words of the third solver, where it ran
    """
    comparison = report.comparison
    scene = comparison.scene
    sentences = common_content(comparison)
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
        budget_words=budget_words,
        units=import_module("reports.units"),
        budget=budget_words.budget_table(report.budget) if report.budget else None,
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
        commit=code_commit(),
        third=third,
        script=program,
        script_hash=digest,
        live=_as_script(dict(live) if live else {"instants": 0}),
        carried=_carried(dict(live)) if live else "",
        states=STATE_KEYS,
        uncertain_work=words.uncertain_work(comparison),
        seconds=seconds,
    )


def code_commit(files: str = ".") -> str:
    """The commit of the checkout that this package lies in, "with changes" where one of `files`
    (a pattern of git) differs from it; "unknown", and why, where there is no checkout or no git.
    """
    home = Path(__file__).parents[2]
    if not (home / ".git").exists():
        return "unknown: installed without its history"
    try:
        commit = _git(home, "describe", "--always", "--abbrev=12")
        changes = _git(home, "status", "--porcelain", "--untracked-files=no", "--", files)
    except (OSError, subprocess.SubprocessError):
        return "unknown: git does not answer"
    return f"{commit}, with changes" if changes else commit


def _git(home: Path, *words: str) -> str:
    """What git prints about the checkout in `home`."""
    command = ["git", "-C", str(home), *words]
    process = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    return process.stdout.strip()


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
_MOST_TOLERANCES = 8.0  # that an axis of discrepancies holds
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
    sides
        the reference and the result
    keys
        their entries of a legend
    chosen
        the instants that have a number in every figure
    start
        of these the one that a page shows first: with most points slipping, of equal ones the
        most loaded
    time, time_words
        the axis of figures through the last cycle
    stretch, noun
        what the values are of, "last cycle", "whole record" or "whole path", and its last word
    x, wide
        points over a_ref; the largest of them that is drawn, a little more than the largest
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
    shown = _Shown(comparison)
    half_width = comparison.scales.half_width
    right_edge = float(np.nanmax(comparison.expected.contact_edges))
    drawings: list[Plate | None] = [
        sketch(comparison.scene, half_width),
        fit_residuals(comparison.scene, right_edge),
        _load_path(shown),
        _now(shown),
        _hysteresis(shown),
        _state_map(shown),
        _half_widths(shown),
        _slip_histories(shown),
        _dissipation_density(shown),
        _errors(shown),
        _tractions(shown),
    ]
    if report.study is not None:
        drawings.append(_distances(report.study))
    if report.budget is not None:
        drawings += [_bars(report.budget), _mesh_refinement(report.budget)]
    meshes = getattr(comparison.result, "bodies", ())
    if meshes:
        from reports.field_output.pictures import mesh

        edge_of_result = float(np.nanmax(comparison.found.contact_edges))
        drawings.append(mesh(meshes, half_width, edge_of_result))

    left_out = set()
    for field, name in (
        ("slip", "slip_history"),
        ("dissipation_density", "dissipation_density"),
    ):
        if field in missing(comparison.result):
            left_out.add(name)
    if len(shown.time) < 2:
        left_out |= {"state_map", "half_widths", "slip_history", "errors"}
    return tuple(drawing for drawing in drawings if drawing and drawing.name not in left_out)


def figure(found: Comparison | Report, name: str) -> str:
    """One figure of the page as an SVG document that stands alone.

    Parameters
    ----------
    found
        what `compare` or `score` returned, or a `Report` of more
    name
        of the figure, as its CSV beside the page is called

    Raises
    ------
    InputError
        For a name that no figure of this comparison has.

    Examples
    --------
    >>> import reports, semi_analytic
    >>> exact = semi_analytic.solve("cattaneo-mindlin")
    >>> reports.figure(reports.compare(exact, exact), "hysteresis")[:11]
    '<svg xmlns='
    """
    report = found if isinstance(found, Report) else Report(found)
    figures = {plate.name: plate for plate in draw(report)}
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
    """Legend: p and q of each engine, then the differences."""
    keys = [
        Key(f"{side.look} {letter}", f"{letter}, {side.engine}")
        for side in shown.sides
        for letter in "pq"
    ]
    return (*keys, Key("d p", "difference of p"), Key("d q", "difference of q"))


def _tractions(shown: _Shown) -> Plate:
    """p and q of both engines at the chosen instants, the difference beneath."""
    instants = [event.index for event in shown.chosen]
    cells = []
    for count, event in enumerate(shown.chosen, start=1):
        panels = _traction_panels(
            shown,
            event.index,
            instants,
            f"event-{count}",
            (320.0, 220.0),
            f"{count}  {event.label}",
        )
        cells.append(Cell(panels, event.index))
    table = {
        "time": np.repeat(shown.found.time[instants], len(shown.x)),
        "x": np.tile(shown.found.x, len(instants)),
        "x/a_ref": np.tile(shown.x, len(instants)),
    }
    units_of = {"p": "p_ref", "q": "(f p_ref)"}
    for letter, (field, size) in _traction_fields(shown).items():
        for role, cycle in (("reference", shown.expected), ("result", shown.found)):
            column = f"{letter}_{role}/{units_of[letter]}"
            table[column] = (getattr(cycle, field)[instants] / size).ravel()
    return worded("tractions", cells, table, _traction_keys(shown), columns=3)


def _traction_fields(shown: _Shown) -> dict[str, tuple[str, float]]:
    """Letter -> name of the field, and what it is drawn over."""
    return {"p": ("pressure", shown.scales.pressure), "q": ("shear", shown.scales.shear)}


def _traction_panels(
    shown: _Shown,
    instant: int,
    instants: Sequence[int],
    name: str,
    size: tuple[float, float],
    title: str = "",
    *,
    live: bool = False,
) -> tuple[Panel, Panel]:
    """Tractions at an instant in a drawing of that size, and the difference; axes hold all
    `instants`.

    `live` if the slider moves them.
    """
    width, height = size
    drawn = np.abs(shown.x) <= shown.wide * 1.02
    x = shown.x[drawn]
    # The instant, which is drawn, before the others that the axes hold; a line copies its row, or
    # it would keep all in memory.
    rows = np.array(list(dict.fromkeys((instant, *instants))))
    grid = np.ix_(rows, np.flatnonzero(drawn))
    tractions: dict[str, tuple[Array, Array]] = {}  # of the reference, of the result
    for letter, (field, unit) in _traction_fields(shown).items():
        of_reference = getattr(shown.expected, field)[grid] / unit
        of_result = getattr(shown.found, field)[grid] / unit
        tractions[letter] = (of_reference, of_result)
    differences = {
        letter: 100 * (of_result - of_reference)
        for letter, (of_reference, of_result) in tractions.items()
    }

    def curve(values: Array, css: str, label: str, field: str) -> Curve:
        return Curve(x, values.copy(), css, label, {"field": field} if live else {})

    lines: list[Mark] = [_ZERO]
    for number_of_side, side in enumerate(shown.sides):
        for letter in "pq":
            values = tractions[letter][number_of_side][0]
            css = f"{side.look} {letter}"
            label = f"{letter}, {side.engine}"
            lines.append(curve(values, css, label, f"{letter}{number_of_side}"))
    difference_lines: list[Mark] = [_ZERO]
    for letter in "pq":
        values = differences[letter][0]
        label = f"difference of {letter}, %"
        difference_lines.append(curve(values, f"d {letter}", label, f"d{letter}"))

    pressures = tractions["p"]
    touching = (pressures[0][0] != 0) | (pressures[1][0] != 0)
    notes = []
    for letter in "pq":
        numbers = _measured(differences[letter][0], x, "x = {} a_ref", " %", touching)
        notes.append(f"{letter}: {numbers}")
    series = [values for pair in tractions.values() for values in pair]
    above = Panel(
        name,
        shown.over_x(""),
        Axis(*limits(*series, zero=True), "p/p_ref,  q/(f p_ref)"),
        lines,
        f"Pressure and shear over x. {title}".strip(),
        width,
        height,
        title,
        room=(72.0, 26.0 if title else 12.0, 20.0, 20.0),
    )
    below = Panel(
        f"{name}-difference",
        shown.over_x(),
        Axis(*limits(*differences.values(), zero=True, least=1e-9), "difference, %", count=3),
        difference_lines,
        f"Result less reference over x. {title}".strip(),
        width,
        0.56 * height + 56,
        notes=notes,
    )
    return above, below


def published(comparison: Comparison) -> str:
    """The picture of a published scene, two panels as SVG: tractions at the largest load, and the
    loop or the half-widths.
    """
    shown = _Shown(comparison)
    scene = comparison.scene
    expected = comparison.expected
    # Where P is largest, and of these instants where |Q| is.
    at_largest_load = expected.normal_load >= expected.normal_load.max() * (1 - 1e-9)
    shear_loads = np.where(at_largest_load, np.abs(expected.tangential_load), -1.0)
    instant = int(np.argmax(shear_loads))
    title = f"t = {expected.time[instant]:.4g}"
    tractions, _ = _traction_panels(shown, instant, [instant], "tractions", (440.0, 330.0), title)
    tractions = replace(tractions, x=shown.over_x(), room=None)

    moves = np.ptp(expected.tangential_displacement) > 1e-9 * comparison.scales.shift
    loop = _hysteresis(shown) if moves else None
    shown.time = shown.found.time
    shown.time_words = "time"
    second = loop.panels[1] if loop else _half_widths(shown).panels[0]
    keys = _traction_keys(shown)[:4]
    alt = f"Both engines on {scene.name}"
    plate = Plate(scene.name, scene.title or scene.name, "", alt, (tractions, second), {}, keys)
    return plate.svg() + "\n"


def _now(shown: _Shown) -> Plate:
    """Both engines at the chosen instant with most slip; axes hold the whole cycle, so that nothing
    leaves them as it moves.
    """
    width = 560.0
    every_instant = range(len(shown.found.time))
    tractions, difference = _traction_panels(
        shown, shown.start, every_instant, "now", (width, 300.0), live=True
    )
    marks: list[Mark] = []
    for strip, side in enumerate(shown.sides):
        marks += _strip_of_states(shown, side, strip)
    strips = Panel(
        "zones",
        shown.over_x(""),
        Axis(84.0, 0.0, ""),
        marks,
        "Open, stick and slip along x, a strip for each engine",
        width,
        84.0,
        css="zones",
        bare=True,
        room=(72.0, 0.0, 20.0, 0.0),
    )
    states_differ = shown.expected.state != shown.found.state
    table = {
        "time": shown.found.time,
        "fraction": shown.found.fraction,
        "P": shown.found.normal_load,
        "Q": shown.found.tangential_load,
        "U_reference": shown.expected.tangential_displacement,
        "U_result": shown.found.tangential_displacement,
        "points_where_states_differ": states_differ.sum(axis=1).astype(np.int64),
    }
    panels = (tractions, strips, difference)
    return worded("cycle", panels, table, _traction_keys(shown), columns=1)


def _strip_of_states(shown: _Shown, side: _Side, strip: int) -> Iterator[Mark]:
    """Open, stick and slip along x of one engine, which the slider recolours."""
    top = 20.0 + 40.0 * strip
    bottom = top + 16
    x = side.cycle.x / shown.scales.half_width
    state = side.cycle.state[shown.start]
    # A state ends midway between two points of different states.
    last_of_state = np.flatnonzero(np.diff(state))
    between = np.clip((x[last_of_state + 1] + x[last_of_state]) / 2, -shown.wide, shown.wide)
    ends = [-shown.wide, *between.tolist(), shown.wide]
    states = state[[0, *(last_of_state + 1).tolist()]].tolist()
    blocks = []
    for left, right, code in zip(ends[:-1], ends[1:], states, strict=True):
        if right > left:
            blocks.append(Block((left, right), (top, bottom), f"state-{code}"))
    yield Note(-shown.wide, top - 5, side.engine)
    yield Group(tuple(blocks), "strip", {"strip": strip, "top": f"{top:g}"})
    yield Block((-shown.wide, shown.wide), (top, bottom), "outline")


def _state_map(shown: _Shown) -> Plate:
    """Open, stick, forward and reverse slip over x and time, for both engines and where they
    differ.
    """
    expected, found = shown.expected, shown.found
    metric = shown.comparison.metric("state")
    # The metric's own number: points crowd at the edges, so that counting them would give another,
    # larger share.
    share = "" if metric.value is None else value_of(metric)
    maps = (
        ("map-reference", expected.state, _STATES, shown.sides[0].engine),
        ("map-result", found.state, _STATES, shown.sides[1].engine),
        (
            "map-difference",
            expected.state != found.state,
            ("#ffffff", "#111111"),
            f"they differ: {share}".rstrip(": "),
        ),
    )
    pixels = _pixels(shown)
    panels = []
    for name, states, palette, title in maps:
        marks = [Bitmap(states[pixels].astype(np.uint8), palette)]
        panels.append(
            Panel(
                name,
                shown.over_x(),
                shown.over_time(),
                marks,
                f"Map of states: {title}",
                340.0,
                320.0,
                title,
                time="y",
                css="pick",
            )
        )

    inside = np.flatnonzero(np.abs(shown.x) <= shown.wide)
    most = min(len(shown.time), max(_MOST_STATES // len(inside), 2))
    written = np.linspace(0, len(shown.time) - 1, most).round().astype(int)
    grid = np.ix_(written, inside)
    codes = ", ".join(f"{int(state)} {name}" for state, name in STATE_NAMES.items())
    table = {
        "time": np.repeat(found.time[written], len(inside)),
        "x": np.tile(found.x[inside], len(written)),
        f"state_reference ({codes})": expected.state[grid].ravel(),
        f"state_result ({codes})": found.state[grid].ravel(),
    }
    return worded(
        "state_map",
        panels,
        table,
        STATE_KEYS,
        columns=3,
        share=share,
        written=len(written),
        instants=len(shown.time),
        stretch=shown.stretch,
    )


def _pixels(shown: _Shown) -> tuple[NDArray[np.int_], ...]:
    """For each row and column of a map the instant and the point nearest to it; time goes up."""
    places = np.linspace(-shown.wide, shown.wide, _COLUMNS)
    points = np.abs(shown.x[:, None] - places).argmin(axis=0)
    times = np.linspace(shown.time[-1], shown.time[0], _ROWS)
    instants = np.abs(shown.time[:, None] - times).argmin(axis=0)
    return np.ix_(instants, points)


def _dissipation_density(shown: _Shown) -> Plate | None:
    """w(x) of the last cycle, both engines, the difference beside it; None where nothing is
    dissipated anywhere.
    """
    x, scales = shown.x, shown.scales
    unit = scales.dissipation / scales.half_width
    of_reference = shown.expected.dissipation_density / unit
    of_result = shown.found.dissipation_density / unit
    if not (np.any(of_reference) or np.any(of_result)):
        return None

    stick = _permanent_edges(shown.comparison.reference) / scales.half_width
    lines: list[Mark] = [
        Rule(float(edge), "stick-line", upright=True) for edge in stick if np.isfinite(edge)
    ]
    for density, key in zip((of_reference, of_result), shown.keys, strict=True):
        lines.append(Curve(x, density, key.css, key.text))
    peak = int(np.nanargmax(np.where(np.isfinite(of_result), of_result, -np.inf)))
    lines.append(Dot(float(x[peak]), float(of_result[peak]), "event"))
    densities = Panel(
        "work",
        shown.over_x(),
        Axis(*limits(of_reference, of_result, zero=True), "w / (A f² P_ref²/a_ref)"),
        lines,
        "Dissipation density over x",
        css="pick",
    )

    largest = float(np.nanmax(np.abs(of_reference), initial=0.0)) or 1.0
    difference = 100 * (of_result - of_reference) / largest
    dissipates = (of_reference != 0) | (of_result != 0)
    note = _measured(difference, x, "x = {} a_ref", " %", (np.abs(x) <= shown.wide) & dissipates)
    differences = Panel(
        "work-difference",
        shown.over_x(),
        Axis(*limits(difference, zero=True, least=1e-9), "difference, % of the largest"),
        [_ZERO, Curve(x, difference, "d p", "difference")],
        "Difference of the dissipation density",
        notes=[note],
    )
    columns = "(A f^2 P_ref^2/a_ref)"
    table = {
        "x": shown.found.x,
        "x/a_ref": x,
        f"w_reference/{columns}": of_reference,
        f"w_result/{columns}": of_result,
    }
    return worded(
        "dissipation_density",
        (densities, differences),
        table,
        (*shown.keys, Key("d p", "difference")),
        stretch=shown.stretch,
        peak=f"{of_result[peak]:.4g}",
        place=signed(float(x[peak])),
        stick=_ends_in_words(stick),
    )


def _ends_in_words(ends: Array) -> str:
    """Both ends of the permanent stick zone over a_ref; nothing where there is none."""
    left, right = ends
    if not np.isfinite(ends).all():
        return ""
    if left == -right:
        return f"±{right:.4g}"
    return minus(f"{left:.4g} and {right:.4g}")


# ---------------------------------------------------------------------------------------- over time
def _half_widths(shown: _Shown) -> Plate:
    """Contact and stick edges of both engines through the last cycle, the difference of the
    half-widths beside them.
    """
    half_width = shown.scales.half_width
    lines: list[Curve] = []
    keys: list[Key] = []
    table = {"time": shown.found.time}
    half_widths: dict[str, list[Array]] = {"contact": [], "stick": []}
    for role, side in zip(("reference", "result"), shown.sides, strict=True):
        for kind, css in (("contact", "p"), ("stick", "q")):
            edges = getattr(side.cycle, f"{kind}_edges")
            left, right = edges.T
            key = Key(f"{side.look} {css}", f"{kind} edge, {side.engine}")
            keys.append(key)
            lines.append(Curve(shown.time, left / half_width, key.css, key.text))
            lines.append(Curve(shown.time, right / half_width, key.css, key.text))
            half_widths[kind].append((right - left) / 2 / half_width)
            table[f"left_{kind}_edges_{role}"] = left
            table[f"right_{kind}_edges_{role}"] = right
    above = Panel(
        "edges",
        shown.over_time(),
        Axis(*limits(*(line.y for line in lines)), _X),
        lines,
        f"Contact and stick edges through the {shown.noun}",
        time="x",
    )

    differences = {
        kind: of_result - of_reference for kind, (of_reference, of_result) in half_widths.items()
    }
    difference_axis = Axis(
        *limits(*differences.values(), zero=True, least=1e-12),
        "difference of half-widths / a_ref",
    )
    below = Panel(
        "edges-difference",
        shown.over_time(),
        difference_axis,
        [
            _ZERO,
            Curve(shown.time, differences["contact"], "d p", "contact"),
            Curve(shown.time, differences["stick"], "d q", "stick"),
        ],
        "Difference of the half-widths",
        notes=[f"{kind}: {shown.largest(d, ' a_ref')}" for kind, d in differences.items()],
        time="x",
    )
    spacing = _spacing_at_the_edge(shown.found) / half_width
    legend = (*keys, Key("d p", "difference, contact"), Key("d q", "difference, stick"))
    return worded(
        "half_widths",
        (above, below),
        table,
        legend,
        stretch=shown.stretch,
        spacing=f"{spacing:.1g}" if np.isfinite(spacing) else "",
    )


def _spacing_at_the_edge(cycle: Cycle) -> float:
    """The middle distance of points about the contact edges [length]; NaN where nothing
    touches.
    """
    outer = float(np.nanmax(np.abs(cycle.contact_edges), initial=0.0))
    if not outer:
        return math.nan
    about_the_edge = np.abs(np.abs(cycle.x[1:]) - outer) < 0.3 * outer
    return float(np.median(np.diff(cycle.x)[about_the_edge]))


def _errors(shown: _Shown) -> Plate:
    """Metrics that have a value at each instant, at the instants that are judged: over their
    tolerances, where there are any.

    Where no tolerance was given, those that half-planes are judged by, in per cent.
    """
    metrics = [m for m in shown.comparison.metrics if m.series is not None]
    with_tolerance = [metric for metric in metrics if metric.tolerance is not None]
    judged = bool(with_tolerance)
    drawn = with_tolerance or [metric for metric in metrics if metric.key in OWN_TOLERANCES]
    lines: list[Mark] = []
    if judged:
        lines.append(Rule(1.0, "limit"))
    keys = []
    largest = 0.0
    for metric, css in zip(drawn, _LINES, strict=False):
        unit = (metric.tolerance or 1.0) if judged else 0.01
        shares = np.abs(np.asarray(metric.series)) / unit
        size = np.where(shown.comparison.judged, shares, np.nan)
        worst = int(np.nanargmax(size)) if np.isfinite(size).any() else 0
        largest = max(largest, float(np.nanmax(size, initial=0.0)))
        lines.append(Curve(shown.time, size, css, metric.label))
        per_cent = "" if judged else " %"
        text = f"{metric.label}: {size[worst]:.2g}{per_cent} at {shown.time[worst]:.3g}"
        keys.append(Key(css, minus(text)))
    if judged:
        end = float(shown.time[-1])
        lines.append(Note(end, 1.0, "tolerance", anchor="end", shift=(-4.0, -5.0)))
    top = min(max(1.0, largest), _MOST_TOLERANCES) if judged else largest or 1.0
    axis_words = "|discrepancy| / tolerance" if judged else "|discrepancy|, %"
    panel = _broad(
        "errors",
        shown.over_time(8),
        Axis(0.0, 1.08 * top, axis_words),
        lines,
        f"Discrepancy through the {shown.noun}",
        time="x",
    )
    table = {"time": shown.found.time}
    table |= {metric.key: np.asarray(metric.series) for metric in drawn}
    return worded(
        "errors",
        [panel],
        table,
        keys,
        columns=1,
        judged=judged,
        cut=judged and largest > _MOST_TOLERANCES,
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
    edges = comparison.expected.contact_edges
    x = comparison.found.x
    if comparison.turned:
        outer = float(np.nanmax(edges, initial=float(x[0])))
    else:
        outer = float(np.nanmax(np.abs(edges), initial=0.0)) or float(np.abs(x).max())
    inner = float(_permanent_edges(comparison.reference)[1])
    if not np.isfinite(inner) or inner >= outer:
        inner = min(0.0, outer)
    places = inner + np.linspace(0.12, 0.97, count) * (outer - inner)
    return sorted({int(np.abs(x - place).argmin()) for place in places})


def _slip_histories(shown: _Shown) -> Plate:
    """Slip of chosen points through the last cycle, both engines, from where each stood at the
    start of the cycle.
    """
    points = _places(shown.comparison)
    length = units(shown.scene)[1]
    names = [f"x = {shown.x[point]:.3f} a_ref" for point in points]
    slips = [side.cycle.slip[:, points] - side.cycle.slip[0, points] for side in shown.sides]
    lines = []
    for look, slip, side in zip(("wide", "thin"), slips, shown.sides, strict=True):
        for place, name in enumerate(names):
            css = f"{look} point-{place}"
            lines.append(Curve(shown.time, slip[:, place], css, f"{name}, {side.engine}"))
    of_reference, of_result = slips
    table = {"time": shown.found.time}
    for place, point in enumerate(points):
        where = f"(x = {shown.found.x[point]:.6g}) [{length}]"
        table[f"slip_reference{where}"] = of_reference[:, place]
        table[f"slip_result{where}"] = of_result[:, place]

    difference = of_result - of_reference
    worst = int(np.argmax(np.nanmax(np.abs(np.nan_to_num(difference)), axis=0)))
    notes = [
        f"result − reference at {names[worst]}, where it is largest:",
        shown.largest(difference[:, worst], f" {length}"),
    ]
    least = 1e-12 * shown.scales.half_width
    panel = _broad(
        "slip",
        shown.over_time(8),
        Axis(*limits(*slips, zero=True, least=least), f"slip since the start  [{length}]"),
        lines,
        "Slip of chosen points over time",
        320.0,
        notes=notes,
        time="x",
    )
    keys = [Key(f"point-{place}", name) for place, name in enumerate(names)]
    return worded("slip_history", [panel], table, keys, columns=1, stretch=shown.stretch)


# ------------------------------------------------------------------- the loads, and load over shift
def _load_path(shown: _Shown) -> Plate:
    """The path in the P-Q plane: initial loading, cycle, Coulomb limit, chosen instants, a ring at
    the instant shown.

    Beneath it bulk stress, tilt and moment over the cycle, where there are any.
    """
    cycle = shown.found
    friction = shown.comparison.result.scene.friction.coefficient
    unit = load_unit(shown.comparison.result.scene)
    parts = _parts_of_path(shown.comparison.result.scene)
    normal = np.concatenate([part.normal_load for part in parts])
    tangential = np.concatenate([part.tangential_load for part in parts])
    largest_normal = 1.08 * float(normal.max())
    largest_tangential = 1.25 * max(float(np.abs(tangential).max()), 0.15 * largest_normal)

    marks: list[Mark] = []
    if friction:
        for sign in (1, -1):
            limit = sign * largest_normal * friction
            marks.append(Curve([0, largest_normal], [0, limit], "cone", "|Q| = f P"))
    marks += [Curve(part.normal_load, part.tangential_load, part.look, part.name) for part in parts]
    lowest = min(-0.3 * largest_tangential, 1.25 * float(tangential.min()))
    panel = Panel(
        "load-path",
        Axis(0.0, largest_normal, f"normal load P  [{unit}]"),
        Axis(lowest, largest_tangential, f"tangential load Q  [{unit}]"),
        marks,
        "Load path in the plane of P and Q",
        height=330.0,
    )
    marks += _events(panel, cycle.normal_load, cycle.tangential_load, shown.chosen)
    start = shown.start
    marks.append(_follower("P", cycle.normal_load[start], cycle.tangential_load[start], "now"))

    keys = [Key(part.look, part.name) for part in reversed(parts)]
    if friction:
        keys.append(Key("cone", "|Q| = f P"))
    panels = [panel]
    for name, title, lines in _beside_the_forces(shown):
        series = [line.values for line in lines]
        curves: list[Mark] = [_ZERO]
        curves += [Curve(shown.time, line.values, line.css, line.text) for line in lines]
        panels.append(
            Panel(
                name,
                shown.over_time(),
                Axis(*limits(*series, zero=True, margin=0.12), title, count=3),
                curves,
                f"{title} over time",
                height=190.0,
                time="x",
            )
        )
        keys += [Key(line.css, line.text) for line in lines]
    table: Table = {
        "time": np.concatenate([part.time for part in parts]),
        "part": [part.name for part in parts for _ in part.time],
        "P": normal,
        "Q": tangential,
    }
    with_more = len(panels) > 1
    return worded(
        "load_path", panels, table, keys, columns=1, beside=with_more, stretch=shown.stretch
    )


class _PathPart(NamedTuple):
    """Initial loading or cycle of a load path, at many instants."""

    name: str
    look: str  # of its line
    time: Array
    normal_load: Array
    tangential_load: Array


def _parts_of_path(scene: Scene) -> list[_PathPart]:
    """Initial loading and cycle; one path where nothing repeats."""
    path = scene.load.path()
    named = [("path", "loop", path.initial_loading)]
    if path.cycle:
        named = [
            ("initial loading", "initial-loading", path.initial_loading),
            ("cycle", "loop", path.cycle),
        ]
    parts = []
    for name, look, legs in named:
        if legs:
            time = np.concatenate([sampled(leg, 257) for leg in legs])
            normal, tangential = path.at(time)
            loads = np.asarray(normal), np.asarray(tangential)
            parts.append(_PathPart(name, look, time, *loads))
    return parts


class _Line(NamedTuple):
    """A line of a figure over time."""

    css: str
    text: str
    values: Array


def _beside_the_forces(shown: _Shown) -> Iterator[tuple[str, str, list[_Line]]]:
    """Name, words of the axis and lines of what a scene has beside P and Q, each with its unit."""
    force, _, stress_unit = units(shown.scene)
    cycle = shown.found
    stresses: list[_Line] = []
    for body in ("lower", "upper"):
        stress = getattr(cycle, f"bulk_stress_{body}")
        if stress is not None and np.any(stress):
            stresses.append(_Line(f"line-{len(stresses)} fine", f"σ, {body} body", stress))
    if stresses:
        yield "bulk-stress", f"bulk stress σ  [{stress_unit}]", stresses
    if cycle.tilt is not None and np.any(cycle.tilt):
        yield "tilt", "tilt α  [rad]", [_Line("line-2 fine", "tilt of the upper body", cycle.tilt)]
    if cycle.moment is not None and np.any(cycle.moment) and shown.scene.load.moment_given:
        yield "moment", f"moment M  [{force}]", [_Line("line-3 fine", "moment", cycle.moment)]


def _events(panel: Panel, across: Array, up: Array, chosen: Sequence[Event]) -> Iterator[Mark]:
    """Numbered dots, numbers outside the loop that the dots lie on; a number that would stand on
    another one is left out.
    """
    x = panel.frame.x.place(across)
    y = panel.frame.y.place(up)
    numbers: list[Array] = []  # places of those that are drawn
    for count, event in enumerate(chosen, start=1):
        k = event.index
        index = {"event": k}
        shift = 13 * _outward(x, y, k)
        place = np.array([x[k], y[k]]) + shift
        yield Dot(float(across[k]), float(up[k]), "event", 3.4, data=index)
        if all(np.hypot(*(place - other)) > 11 for other in numbers):
            numbers.append(place)
            yield Note(
                float(across[k]),
                float(up[k]),
                str(count),
                "number",
                "middle",
                (float(shift[0]), float(shift[1]) + 4),
                index,
            )


def _outward(x: Array, y: Array, k: int) -> Array:
    """Unit vector across the line at its k-th place, away from the middle of all places."""
    before = max(k - 1, 0)
    after = min(k + 1, len(x) - 1)
    across = np.array([y[before] - y[after], x[after] - x[before]])
    from_middle = np.array([x[k] - x.mean(), y[k] - y.mean()])
    if not np.all(np.isfinite(across)) or not np.hypot(*across):
        across = from_middle
    if across @ from_middle < 0:
        across = -across
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
    comparison, scene = shown.comparison, shown.scene
    cycles = (shown.expected, shown.found)
    shifts = [cycle.tangential_displacement for cycle in cycles]
    moving = [shown.found.tangential_load, *shifts]
    nothing_moves = all(np.ptp(values) == 0 for values in moving)
    if "tangential_displacement" in missing(comparison.result) or nothing_moves:
        return None

    _, length, _ = units(scene)
    sheared = [_sheared_shift(cycle) for cycle in cycles]
    panels = [
        _loop_panel(shown, "hysteresis", ("U", shifts), f"tangential displacement U  [{length}]"),
        _loop_panel(
            shown, "hysteresis-sheared", ("V", sheared), f"U − k Q, about its mean  [{length}]"
        ),
    ]
    if comparison.pulled and all(cycle.shear_moment is not None for cycle in cycles):
        panels.append(_bulk_loop_panel(shown))

    works_in_words: list[str] = []
    if comparison.pulled:
        works = (
            [loop_work(cycle) for cycle in cycles],
            [bulk_work(cycle, scene.material) for cycle in cycles],
            [comparison.reference.dissipation, comparison.result.dissipation],
        )
        works_in_words += [
            f"{minus(f'{of_reference:.5g}')} and {minus(f'{of_result:.5g}')}"
            for of_reference, of_result in works
        ]
        works_in_words.append(energy_unit(scene))
    table = {
        "time": shown.found.time,
        "Q": shown.found.tangential_load,
        "U_reference": shifts[0],
        "U_result": shifts[1],
    }
    # P works too where it varies and the approach hangs on Q as well.
    constant_load = np.ptp(shown.found.normal_load) == 0 and shown.found.tilt is None
    return worded(
        "hysteresis",
        panels,
        table,
        shown.keys,
        stretch=shown.stretch,
        slopes=" and ".join(signed(_loop_compliance(cycle)) for cycle in cycles),
        unit=f"{length} per {load_unit(scene)}",
        periodic=scene.load.path().period is not None,
        alone=are_half_planes(scene) or constant_load,
        works=works_in_words or (),
    )


def _loop_panel(shown: _Shown, name: str, shift: tuple[str, list[Array]], title: str) -> Panel:
    """Tangential load over a shift of both engines.

    Parameters
    ----------
    shift
        letter of its series that the slider moves, U or V; its values of each engine
    title
        words of the axis
    """
    letter, (of_reference, of_result) = shift
    loads = [shown.expected.tangential_load, shown.found.tangential_load]
    stroke = float(np.ptp(of_reference)) or 1.0
    share = 100 * (of_result - of_reference) / stroke
    numbers = _measured(share, shown.found.fraction, "{}", " %").rpartition(" at ")[0]
    over = "stroke" if letter == "U" else "width"
    marks: list[Mark] = []
    for key, values, load in zip(shown.keys, (of_reference, of_result), loads, strict=True):
        marks.append(Curve(values, load, key.css, key.text))
    panel = Panel(
        name,
        Axis(*limits(of_reference, of_result, margin=0.12), title, count=4),
        Axis(*limits(*loads, margin=0.12), f"tangential load Q  [{load_unit(shown.scene)}]"),
        marks,
        f"Tangential load over {title}",
        height=330.0,
        notes=[f"{numbers}, of the {over}"] if numbers else [],
    )
    marks += _events(panel, of_result, loads[1], shown.chosen)
    start = shown.start
    marks.append(_follower(f"{letter}0", of_reference[start], loads[0][start], "now pale"))
    marks.append(_follower(f"{letter}1", of_result[start], loads[1][start], "now"))
    return panel


def _bulk_loop_panel(shown: _Shown) -> Panel:
    """Moment of the shear over the bulk strain, both engines: its loop is the work of the bulk
    stress.
    """
    force, _, _ = units(shown.scene)
    cycles = (shown.expected, shown.found)
    strains = [bulk_strain(cycle, shown.scene.material) for cycle in cycles]
    moments = [np.asarray(cycle.shear_moment) for cycle in cycles]
    marks: list[Mark] = []
    for key, strain, moment in zip(shown.keys, strains, moments, strict=True):
        marks.append(Curve(strain, moment, key.css, key.text))
    return Panel(
        "bulk-loop",
        Axis(*limits(*strains, margin=0.12), "bulk strain ε = σ/E′, lower − upper", count=4),
        Axis(*limits(*moments, margin=0.12), f"moment of the shear m_q  [{force}]"),
        marks,
        "Moment of the shear over bulk strain",
        height=330.0,
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
        if not line.metric.headline or line.found.kind != "monotone" or limit is None:
            continue
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
    axes
        words of the two axes
    distances
        label of a metric -> (element size, distance); one that is 0 everywhere is left out
    element_sizes
        of all meshes; None is returned for fewer than three
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
_SHOWN_OF_CONTACT = 6.0
_SHOWN_OF_BODY = 1.3
# Of the drawing: its width, its largest height, room above the bodies and on the other sides.
_WIDTH = 440.0
_MOST = 310.0
_ROOM = 76.0
_SIDE = 30.0
_FACE_POINTS = 181  # of an outline
# Rows of a measured profile that are drawn.
_MOST_DOTS = 400


def sketch(scene: Scene, half_width: float) -> Plate:
    """Both bodies to scale with supports, loads and the place of the contact.

    Parameters
    ----------
    half_width
        of the contact, drawn to scale [length]
    """
    _, length, _ = units(scene)
    outlines = {name: outline(scene, name, half_width) for name in ("lower", "upper")}
    frame = _frame(outlines)
    marks: list[Mark] = []
    for name, points in outlines.items():
        shape = getattr(scene.bodies, name)
        marks += _body(frame, points, shape, name)
        marks += _supports(frame, shape, points, 1.0 if name == "lower" else -1.0)
        height_of_label = 16.0 if name == "upper" else frame.height - 6
        marks.append(Note(6.0, height_of_label, _label(scene, name), "word"))
    level = float(frame.y.place(0.0))
    marks.append(Curve(frame.x.place([-half_width, half_width]), [level, level], "contact-line"))
    marks += _loads(frame, scene, outlines)

    alt = bodies_in_words(scene)
    # Places of the marks are those of the drawing: supports and arrows have no size in the scene.
    panel = Panel(
        "bodies",
        Axis(0.0, frame.width, ""),
        Axis(frame.height, 0.0, ""),
        marks,
        alt,
        frame.width,
        frame.height,
        bare=True,
        room=(0.0, 0.0, 0.0, 0.0),
    )
    columns: Table = {
        "body": [name for name in outlines for _ in outlines[name]],
        f"x [{length}]": np.concatenate([points[:, 0] for points in outlines.values()]),
        f"y [{length}]": np.concatenate([points[:, 1] for points in outlines.values()]),
    }
    bodies = (scene.bodies.lower, scene.bodies.upper)
    return worded(
        "bodies",
        [panel],
        columns,
        columns=1,
        cut=any(isinstance(body, HalfPlane) for body in bodies),
        width=number(2 * half_width),
        length=length,
        normal=_range(_normal_loads(scene)),
        tangential=_range(_tangential_loads(scene)),
        load=load_unit(scene),
        beside=bulk_and_tilt(scene),
        alt=alt,
    )


def fit_residuals(scene: Scene, half_width: float) -> Plate | None:
    """Rows minus the curve fitted to them, beside twice their noise; None of a profile that is not
    fitted.

    Parameters
    ----------
    half_width
        of the largest contact [length]
    """
    fit = fit_of(scene)
    if fit is None:
        return None
    _, length, _ = units(scene)
    x = fit.rows.values[:, 0] - fit.centre
    residuals = fit.residuals(scene.profile.height)
    largest_place = np.sort(np.abs(x))[len(x) - fit.left_out - 1]
    is_fitted = np.abs(x) <= largest_place
    count = int(is_fitted.sum())
    stride = -(-count // _MOST_DOTS)
    drawn = np.flatnonzero(is_fitted)[::stride]

    noise = np.full(count, 2 * fit.noise)
    marks: list[Mark] = [
        Band(x[is_fitted], -noise, noise, "band pale-stick"),
        Rule(0.0, "zero"),
        Rule(-half_width, "cycle-line", upright=True),
        Rule(half_width, "cycle-line", upright=True),
    ]
    for k in drawn:
        label = f"x = {x[k]:.4g}, {residuals[k]:.3g} {length}"
        marks.append(Dot(float(x[k]), float(residuals[k]), "p0", 2.2, label))
    largest = float(np.abs(residuals[is_fitted]).max())
    top = 1.1 * max(largest, 2.2 * fit.noise)
    panel = Panel(
        "profile-fit",
        Axis(*limits(x[is_fitted], margin=0.02), f"x from the middle  [{length}]"),
        Axis(-top, top, f"row − fit  [{length}]"),
        marks,
        "Residuals of the fit",
        height=260.0,
    )
    table = {
        f"x [{length}]": x,
        f"row - fit [{length}]": residuals,
        "fitted": is_fitted.astype(float),
    }
    return worded(
        "profile_fit",
        [panel],
        table,
        columns=1,
        rows=is_fitted.sum(),
        residual=f"{fit.residual:.3g}",
        noise=f"{fit.noise:.3g}",
        length=length,
        every=drawn[1] - drawn[0],
    )


def _frame(outlines: dict[str, Array]) -> Frame:
    """Both bodies with one scale in both directions, room above for the loads and all round for
    supports.
    """
    points = np.concatenate(list(outlines.values()))
    left, low = points.min(axis=0)
    right, high = points.max(axis=0)
    unit_across = (right - left) / (_WIDTH - 2 * _SIDE)
    unit_up = (high - low) / (_MOST - _ROOM - _SIDE)
    unit = max(unit_across, unit_up)
    height = float((high - low) / unit + _ROOM + _SIDE)
    middle = (left + right) / 2
    half = (_WIDTH / 2 - _SIDE) * unit
    across = Scale(float(middle - half), float(middle + half), _SIDE, _WIDTH - _SIDE)
    up = Scale(float(low), float(high), height - _SIDE, _ROOM)
    return Frame(across, up, _WIDTH, height)


def outline(scene: Scene, name: str, half_width: float) -> Array:
    """(n, 2) outline of a body in the common frame, from the left end of its face to the right one
    and round its base [length].

    A half-plane is drawn as a piece of itself: as wide as suits the other body, or the contact.
    """
    shape = getattr(scene.bodies, name)
    other = getattr(scene.bodies, "upper" if name == "lower" else "lower")
    side = 1.0 if name == "lower" else -1.0
    width = shape.face_half_width
    height = getattr(shape, "height", 0.0)
    if isinstance(shape, HalfPlane):
        width = _SHOWN_OF_BODY * other.face_half_width
        if isinstance(other, HalfPlane):
            width = _SHOWN_OF_CONTACT * half_width
        height = 0.5 * width
    # Finer towards the ends, where an arc is steep.
    x = width * np.sin(np.linspace(-np.pi / 2, np.pi / 2, _FACE_POINTS))
    face = np.column_stack([x, -side * face_of(shape, scene.profile).depth(x)])
    if isinstance(shape, Cylinder):
        return face
    base = np.array([[width, -side * height], [-width, -side * height]])
    return np.vstack([face, base])


def _body(frame: Frame, points: Array, shape: Shape, name: str) -> Iterator[Mark]:
    """A filled body; a half-plane has a line along its face alone, for it goes on everywhere
    else.
    """
    x = frame.x.place(points[:, 0])
    y = frame.y.place(points[:, 1])
    yield Curve(x, y, f"body {name}", closed=True)
    if not isinstance(shape, HalfPlane):
        yield Curve(x, y, "body-line", closed=True)
        return
    # From the right end of the face round the base to the left end.
    cut_edges = [_FACE_POINTS - 1, _FACE_POINTS, _FACE_POINTS + 1, 0]
    yield Curve(x[:_FACE_POINTS], y[:_FACE_POINTS], "body-line")
    yield Curve(x[cut_edges], y[cut_edges], "cut-line")


def _supports(frame: Frame, shape: Shape, points: Array, side: float) -> Iterator[Mark]:
    """A rigid plane along the base and along guided sides, rollers between it and the body where
    there are some.
    """
    if isinstance(shape, HalfPlane):
        return
    half_width = shape.face_half_width
    left, right = frame.x.place([-half_width, half_width]).tolist()
    top = float(frame.y.place(points[0, 1]))
    lowest = np.argmax(-side * points[:, 1])
    base = float(frame.y.place(points[lowest, 1]))
    base_rolls = getattr(shape, "base", "") == "rollers"
    yield from _plane((left, base), (right, base), (0.0, side), base_rolls)
    if getattr(shape, "sides", "") == "guided":
        yield from _plane((left, base), (left, top), (-1.0, 0.0), rollers=True)
        yield from _plane((right, base), (right, top), (1.0, 0.0), rollers=True)


def _plane(
    start: tuple[float, float],
    end: tuple[float, float],
    outward: tuple[float, float],
    rollers: bool,
) -> Iterator[Mark]:
    """A rigid plane with hatching from one end to the other; rollers between it and the body."""
    size = 10.0  # of the hatching, and three times the radius of a roller
    first = np.array(start)
    last = np.array(end)
    normal = np.array(outward)
    if rollers:
        parts = np.linspace(0.08, 0.92, 7)[:, None]
        for x, y in first + parts * (last - first) + normal * size / 3:
            yield Dot(float(x), float(y), "roller", size / 3)
        first = first + normal * 2 * size / 3
        last = last + normal * 2 * size / 3
    length = np.hypot(*(last - first))
    along = (last - first) / length
    count = max(int(length / 8), 4)
    feet = first + np.linspace(0, 1, count)[:, None] * (last - first)
    tips = feet + 0.7 * size * (normal - along)
    yield Curve([first[0], last[0]], [first[1], last[1]], "wall")
    yield Segments(np.stack([feet, tips], axis=1), "curve hatch")


def _label(scene: Scene, name: str) -> str:
    """Kind, sizes and material of a body."""
    shape = getattr(scene.bodies, name)
    material = getattr(scene.material, name)
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
    load = scene.load
    top = float(frame.y.place(outlines["upper"][:, 1].max())) - 8
    contact = float(frame.y.place(0.0))
    line = load.line_of_action
    # the words below say where it is
    x = float(np.clip(frame.x.place(line.x if line else 0.0), 80.0, frame.width - 80.0))
    if line is not None:
        yield Curve([x, x], [contact - 0.3 * (contact - top), contact], "cycle-line")
    yield Arrow((x, top - 42), (x, top))
    yield Note(x - 9, top - 28, "P", "load", "end")
    if np.any(_tangential_loads(scene) != 0):
        yield Arrow((x + 8, top - 8), (x + 58, top - 8))
        yield Note(x + 63, top - 3, "Q", "load")
    # A positive tilt opens the gap at x > 0; a positive moment presses there, and so turns the
    # other way.
    if load.tilt is not None:
        yield from _turning_arrow((x - 48.0, top - 17.0), 1.0, "α")
    elif load.moment is not None:
        yield from _turning_arrow((x - 48.0, top - 17.0), -1.0, "M")
    for name, stress in (("lower", load.bulk_stress_lower), ("upper", load.bulk_stress_upper)):
        if stress is not None:
            yield from _bulk_arrows(frame, outlines[name])


def _turning_arrow(middle: tuple[float, float], turn: float, letter: str) -> Iterator[Mark]:
    """An arrow along an arc about `middle`, with its letter there; turn is 1 or -1."""
    x, y = middle
    angle = np.linspace(-0.2, 1.2, 29) * np.pi
    arc_x = x + turn * 18 * np.cos(angle)
    arc_y = y - 18 * np.sin(angle)
    yield Curve(arc_x[:-3], arc_y[:-3], "arrow")
    yield Arrow((arc_x[-8], arc_y[-8]), (arc_x[-1], arc_y[-1]))
    yield Note(x, y + 5, letter, "load", "middle")


def _bulk_arrows(frame: Frame, points: Array) -> Iterator[Mark]:
    """Arrows of bulk stress away from both ends of a body, midway between face and base."""
    left, right = frame.x.place(points[[0, _FACE_POINTS - 1], 0]).tolist()
    level = float(np.mean(frame.y.place(points[[0, -1], 1])))
    for end, outward in ((left, -1.0), (right, 1.0)):
        yield Arrow((end + 3 * outward, level), (end + 23 * outward, level))
        yield Note(end + 13 * outward, level - 9, "σ", "load", "middle")


def _normal_loads(scene: Scene) -> Array:
    """P all along the path."""
    normal, _ = scene.load.path().at(_instants(scene))
    return np.asarray(normal)


def _tangential_loads(scene: Scene) -> Array:
    """Q all along the path."""
    _, tangential = scene.load.path().at(_instants(scene))
    return np.asarray(tangential)


def _instants(scene: Scene) -> Array:
    """Many instants of initial loading and first cycle."""
    return np.concatenate([sampled(leg, 181) for leg in scene.load.path().legs(1)])


def _range(loads: Array) -> str:
    """Least and largest of loads in words."""
    least = number(float(f"{loads.min():.4g}"))
    most = number(float(f"{loads.max():.4g}"))
    return f"= {most}" if least == most else f"from {least} to {most}"
