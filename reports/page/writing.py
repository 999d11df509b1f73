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
import subprocess
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reports import input_words
from reports.charts.plate import STATE_KEYS, Panel, Plate, write_tables
from reports.charts.templating import script, template
from reports.comparison import Comparison, budget_words, words
from reports.comparison.cycles import Cycle, last_cycle
from reports.comparison.metrics import reason_by_missing_field
from reports.comparison.pairs import engine_in_words
from reports.comparison.words import headline_sentence, verdict_in_sentences
from reports.comparison.work_of_loads import bulk_work, normal_work
from reports.field_output.files import with_bodies, write_fields
from reports.folder import results_folder
from reports.inputs import input_effects
from reports.measured import page_section
from reports.page.body_figures import fit_residuals, sketch
from reports.page.budget_figures import (
    budget_bars,
    mesh_refinement,
    study_convergence,
    waterfall,
)
from reports.page.content import as_json, common_content
from reports.page.cycle_view import CycleView, sheared_displacement, slip_points
from reports.page.field_figures import (
    dissipation_density,
    moving_instant,
    state_map,
    traction_keys,
    traction_panels,
    tractions,
)
from reports.page.history_figures import (
    cumulative_work,
    discrepancies,
    half_widths,
    hysteresis,
    load_path,
    slip_histories,
)
from reports.profile_fit import findings_on_fit
from reports.report import Report, ThirdAnswer
from reports.units import load_unit, minus, units
from scenes import InputError
from scenes.array_types import Array
from scenes.errors import require_class

if TYPE_CHECKING:
    from reports.field_output.files import Instant

# Files of the solutions in a folder of a report: of the reference, of the result.
SOLUTIONS = ("reference.nc", "result.nc")
# Level of compression of the tables on the page: half the time of the usual one, 5 % more letters.
_COMPRESSION = 4
# Work of P over W below which it is round-off error.
_ROUND_OFF = 1e-12


def write(
    report: Comparison | Report,
    out: str | Path,
    *,
    vtu_instants: Sequence[float] | None = None,
    command: str = "",
    seconds: Mapping[str, float] | None = None,
    stress_instants: Sequence[Instant] = (),
    log: Sequence[str] = (),
) -> Path:
    """Write the report to a folder: both solutions, the page, the figures' tables and the JSON;
    returns the path of the page.

    Both solutions are written first. Where the page fails they are in the folder, and a note of the
    error names their files.

    Parameters
    ----------
    report
        a `Report`, or a comparison that `compare` or `score` returned
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
        If the folder can't be written to, or VTU or stress is requested of a result without bodies.
    """
    _require_report(report, "write")
    report = _with_input_effects(report)
    comparison = report.comparison
    # a temporary folder, whose files move to `out` at the end; after an error the solutions alone
    # SOLUTIONS: names of the files, reference.nc and result.nc
    with results_folder(out, solutions=SOLUTIONS) as folder:
        # before the page: one that fails must not cost what took long to solve
        comparison.reference.save(folder / SOLUTIONS[0])
        comparison.result.save(folder / SOLUTIONS[1])
        # figures, and name -> CSV of each
        drawings = draw(report)
        if stress_instants:
            drawings += (_figure_of_stress(comparison, stress_instants),)
        tables = write_tables(drawings, folder)
        _write_json(report, folder, command, seconds)
        if vtu_instants is not None and len(vtu_instants):
            _write_vtu(comparison, vtu_instants, folder / "fields")
        # what the page states of the answer of a third solver
        third_content = _write_third(comparison, report.third, folder) if report.third else None
        # values at the instants of the page's slider, and the CSV of the figures
        script_data = _data_of_slider(CycleView(comparison)) | {"tables": _tables(tables)}
        page_text = render(report, drawings, command, seconds or {}, script_data, third_content)
        (folder / "report.html").write_text(page_text, encoding="utf-8")
        if log:
            _write_log(comparison, log, folder)
    return Path(out) / "report.html"


def _require_report(report: object, caller: str) -> None:
    """Raise InputError, one sentence, where what a Python caller passes to the public function
    `caller` is neither a comparison nor a report.
    """
    require_class(report, (Comparison, Report), caller, "compare and score return one")


def _with_input_effects(report: Comparison | Report) -> Report:
    """The report, or a report of the comparison, with what the stated uncertainties of the scene's
    inputs do to the values of theory; as it is where none is stated or this is known already.
    """
    if not isinstance(report, Report):
        report = Report(report)
    comparison = report.comparison
    if report.inputs is None and comparison.scene.inputs:
        inputs = input_effects(comparison.scene, comparison.effects)
        report = replace(report, inputs=inputs)
    return report


def _write_json(
    report: Report, folder: Path, command: str, seconds: Mapping[str, float] | None
) -> None:
    """Write scene.json, the scene, and comparison.json, all that a report holds, to a folder.
    `command` reproduces the report; `seconds` is the wall time of each stage.
    """
    scene_text = report.comparison.scene.model_dump_json(indent=1) + "\n"
    (folder / "scene.json").write_text(scene_text, encoding="utf-8")
    comparison_text = as_json(report, command, seconds) + "\n"
    (folder / "comparison.json").write_text(comparison_text, encoding="utf-8")


def _write_log(comparison: Comparison, log: Sequence[str], folder: Path) -> None:
    """Write run.log to a folder: the lines of the run, the headline and the verdict."""
    lines = [*log, headline_sentence(comparison), verdict_in_sentences(comparison)]
    (folder / "run.log").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _figure_of_stress(comparison: Comparison, instants: Sequence[Instant]) -> Plate:
    """Von Mises' stress of the result's bodies at these instants."""
    import halfplane_fe
    from reports.field_output.pictures import scales_of, stress

    solution = with_bodies(comparison.result, "--stress")
    snapshots = halfplane_fe.fields(solution, [instant.time for instant in instants])
    return stress(solution, snapshots, instants, scales_of(snapshots))


def _write_vtu(comparison: Comparison, times: Sequence[float], folder: Path) -> None:
    """Both bodies of the result at these times, for ParaView."""
    import halfplane_fe

    solution = with_bodies(comparison.result, "--vtu")
    write_fields(solution, halfplane_fe.fields(solution, times), folder)


def _write_third(comparison: Comparison, third_answer: ThirdAnswer, folder: Path) -> dict[str, Any]:
    """Files of a third solver; returns what the page states of it."""
    (folder / "third.inp").write_text(third_answer.text, encoding="utf-8")
    (folder / "third.json").write_text(third_answer.as_json(comparison), encoding="utf-8")
    if third_answer.comparison is not None:
        third_answer.comparison.result.save(folder / "third.nc")
    return third_answer.page_words(comparison)


def render(
    report: Report,
    drawings: Sequence[Plate],
    command: str,
    seconds: Mapping[str, float],
    script_data: Mapping[str, Any] | None = None,
    third_content: Mapping[str, Any] | None = None,
) -> str:
    """The HTML text of a report's page. Text that came from outside is escaped, and no script but
    the page's own may run.

    Parameters
    ----------
    report
        `comparison` of two solutions, and the error `budget` where one was measured
    drawings
        the figures; one that is missing leaves its place empty
    command
        the command that reproduces the page
    seconds
        stage -> wall time
    script_data
        what the page's script shows: the values at each position of the slider, and the tables;
        None: the page has no slider
    third_content
        what the page states of the third solver; None where none ran
    """
    comparison = report.comparison
    scene = comparison.scene
    # texts by their names on the page: headline, question, bodies, ...
    sentences = common_content(report)
    sentences_on_fit: tuple[str, ...] = ()
    if scene.has_measured_rows:
        sentences_on_fit, _ = findings_on_fit(scene)
    bodies = [sentences["bodies"], sentences["unlike_materials"], *sentences_on_fit]
    # Names as in the template. `flat`: makes one mapping of nested settings; `states`: legend of
    # open, stick and slip.
    return template("report.html").render(
        sentences | {"bodies": bodies},
        title=scene.title or scene.name,
        scene=scene,
        comparison=comparison,
        report=report,
        in_words=words,
        units=import_module("reports.units"),
        input_words=input_words,
        figures={drawing.name: drawing for drawing in drawings},
        flat=_settings_by_name,
        command=command,
        commit=code_commit(),
        third=third_content,
        states=STATE_KEYS,
        seconds=seconds,
        **_budget_for_page(report),
        **_solutions_for_page(comparison),
        **_script_for_page(script_data),
    )


def _budget_for_page(report: Report) -> dict[str, Any]:
    """Values of the page's template on the error budget, by their names there: its table, None
    without a budget; the terms (sources of error) that the table leaves out, since they are
    negligible; and the module that puts a budget into words.
    """
    terms_left_out = budget_words.negligible_terms(report.budget) if report.budget else ()
    return {
        "budget_words": budget_words,
        "budget": (
            budget_words.budget_table(report.budget, terms_left_out) if report.budget else None
        ),
        "without_terms": terms_left_out,
    }


def _solutions_for_page(comparison: Comparison) -> dict[str, Any]:
    """Values of the page's template on the two solutions, by their names there: notes, the table of
    the friction work, the part of the path in words (`stretch`), what is shown of a measured record
    of loads, each solution with the name of its engine, and a sentence on the uncertainty of W.
    """
    scene = comparison.scene
    solutions = (comparison.reference, comparison.result)
    return {
        "notes": _notes(comparison),
        "dissipations": list(_dissipations(comparison)),
        "stretch": words.part_of_path(scene),
        "measured": page_section(scene, solutions) if scene.has_measured_rows else None,
        "engines": [(engine_in_words(solution.engine), solution) for solution in solutions],
        "uncertain_work": words.sentence_on_work(comparison),
    }


def _script_for_page(script_data: Mapping[str, Any] | None) -> dict[str, str]:
    """Values of the page's template on its script, by their names there: the script, its digest, by
    which a browser knows it, its data as JSON (`live`), and a sentence on the instants and points
    of the slider. `script_data` is None for a page without slider.
    """
    program, script_digest = script()
    return {
        "script": program,
        "script_hash": script_digest,
        "live": _as_script(dict(script_data) if script_data else {"instants": 0}),
        "carried": _extent_of_slider_in_words(script_data) if script_data else "",
    }


def code_commit(files: str = ".") -> str:
    """The git commit of the checkout that this package lies in, followed by "with changes" where
    one of `files` (a pattern of git) differs from it. "unknown", and why, without a checkout or
    without git.
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
    """Output of a git command on the checkout in `home`."""
    command = ["git", "-C", str(home), *words]
    process = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    return process.stdout.strip()


def _notes(comparison: Comparison) -> list[str]:
    """Notes of a comparison as sentences: those of the metrics in the first table, which begin with
    the metric's label, then those of the solutions.
    """
    notes = []
    for metric in comparison.headlines:  # metrics of the first table
        note = metric.note
        label = metric.label
        if note and note.lower().startswith(label.lower()):
            notes.append(words.as_sentence(note))
        elif note:
            notes.append(words.as_sentence(f"{label}: {note}"))
    return [*notes, *comparison.notes]


def _dissipations(comparison: Comparison) -> Iterator[dict[str, str]]:
    """Texts of a table on the friction work W of each solution, by column; a dash stands for what a
    solution does not hold.

    The columns: "name"; "value" W, the sum of q times slip; "scaled" W over A f^2 P_ref^2; "loop"
    the closed integral of Q dU, under bulk stress of Q dU − m_q d(eps); "bulk" and "normal" work of
    bulk stress and of P; "apart" |(loop + normal work)/W − 1|; "cycles" W of every cycle. Work of P
    below 1e-12 W is round-off and shown as 0.

    # notation: q shear traction, A = 2/E* compliance of the materials (E* contact modulus), f
    # friction coefficient, P_ref reference load, m_q moment of the shear, eps bulk strain
    """

    def text_of_number(value: float | None, digits: int = 8) -> str:
        """A number to `digits` significant digits; a dash for None and NaN."""
        # `minus`: with a real minus sign
        return "–" if value is None or np.isnan(value) else minus(f"{value:.{digits}g}")

    # theory with straight loads between the instants of the result; may be None
    reference_on_steps = comparison.polygon_reference
    for solution in filter(None, (comparison.reference, reference_on_steps, comparison.result)):
        name = engine_in_words(solution.engine)
        if solution is reference_on_steps:
            name += ", on the polygon of the steps"
        dissipation = solution.dissipation
        loop_work = solution.loop_work
        # None where it is always 0 or not known
        work_of_normal_load = normal_work(solution)
        if work_of_normal_load is not None and abs(work_of_normal_load) < _ROUND_OFF * dissipation:
            work_of_normal_load = 0.0
        difference_in_words = "–"
        if dissipation and not np.isnan(loop_work):
            work_of_loads = loop_work + (work_of_normal_load or 0.0)
            difference_in_words = minus(f"{abs(work_of_loads / dissipation - 1):.1e}")
        yield {
            "name": name,
            "value": text_of_number(dissipation),
            "scaled": text_of_number(dissipation / comparison.scales.dissipation),
            "loop": text_of_number(loop_work),
            # of the instants that the solution has
            "bulk": text_of_number(bulk_work(last_cycle(solution), solution.scene.material)),
            "normal": text_of_number(work_of_normal_load),
            "apart": difference_in_words,
            "cycles": ", ".join(
                text_of_number(work_of_cycle, 6) for work_of_cycle in solution.cycle_dissipation
            ),
        }


def _settings_by_name(settings: Mapping[str, Any], prefix: str = "") -> dict[str, str]:
    """Nested settings as one dictionary of texts: names joined by dots, floats to six digits.
    `prefix` stands before each name.

    >>> _settings_by_name({"mesh": {"order": 2}, "element_size": 0.0144202817})
    {'mesh.order': '2', 'element_size': '0.0144203'}
    """
    settings_by_name: dict[str, str] = {}
    for name, value in settings.items():
        if isinstance(value, Mapping):
            settings_by_name |= _settings_by_name(value, f"{prefix}{name}.")
        else:
            settings_by_name[prefix + name] = (
                f"{value:.6g}" if isinstance(value, float) else str(value)
            )
    return settings_by_name


# Largest number of instants, and of instants times points, that a page carries: 1.6 MB.
_MOST_INSTANTS = 200
_MOST_VALUES = 100_000
# Length of the longest CSV that a page carries.
_MOST_LETTERS = 1_500_000
# Numbers are multiples, up to this one, of a step; another code stands for NaN and infinity.
_LARGEST_CODE = 32766
_CODE_OF_NO_NUMBER = -32768


def _in_16_bits(values: Array) -> dict[str, Any]:
    """Numbers packed for the page's script: "data" holds them as 16-bit multiples of a "step",
    little-endian, in base64. The largest finite magnitude is 32766 steps; the code of NaN and
    infinity is -32768. Where no number is finite, or all finite ones are 0, the step is 1.

    >>> _in_16_bits(np.array([0.0, 2.0, -1.0]))["step"] * 32766
    2.0
    """
    is_finite = np.isfinite(values)
    step = float(np.max(np.abs(values[is_finite]), initial=0.0)) / _LARGEST_CODE or 1.0
    multiples = np.rint(np.where(is_finite, values, 0.0) / step)
    codes = np.where(is_finite, multiples, _CODE_OF_NO_NUMBER).astype("<i2")
    return {"step": step, "data": base64.b64encode(codes.tobytes()).decode()}


def _data_of_slider(view: CycleView) -> dict[str, Any]:
    """What the page's script needs for its slider: loads, displacements, tractions and states at
    the instants and points that the page holds, and how many there are in all.

    `view` holds the last cycles of both solutions: loads and displacements (k,) at k instants,
    points `x` over the half-width at the reference load (n,), and the instants that figures mark
    (`chosen_events`).
    """
    scene = view.scene
    # indices of the instants and points that the page holds: about 200 instants at most, and
    # 100,000 instants times points
    instant_indices = _instants_of_slider(view)
    point_indices = _points_of_slider(view, len(instant_indices))
    # tractions and slip as packed numbers; states as codes (instants, points)
    fields, states = _fields_of_slider(view, np.ix_(instant_indices, point_indices))
    _, unit_of_length, _ = units(scene)
    return {
        "instants": len(instant_indices),
        "points": len(point_indices),
        "of": [len(view.result_cycle.time), len(view.result_cycle.x)],
        "stretch": view.part_of_path,
        "rows": instant_indices.tolist(),
        "x": [_seven_digits(x) for x in view.x[point_indices]],
        "series": _series_of_slider(view, instant_indices),
        "fields": fields,
        "states": base64.b64encode(states.tobytes()).decode(),
        "events": [
            [_position_of(event.index, instant_indices), event.label]
            for event in view.chosen_events
        ],
        "start": _position_of(view.shown_instant, instant_indices),
        "slip_points": [
            _position_of(point, point_indices) for point in slip_points(view.comparison)
        ],
        "time_words": view.time_words,
        "load_unit": load_unit(scene),
        "length": unit_of_length,
        "engines": [engine.name for engine in view.engines],
    }


def _series_of_slider(
    view: CycleView, instant_indices: NDArray[np.int_]
) -> dict[str, list[float | None]]:
    """Time, loads and displacements at the instants of the page's slider, to seven digits, by their
    names in the page's script: t; Q0, U0, V0 of the reference; P, Q, U1, V1 of the result.

    U is the tangential displacement. V is U without its elastic part: Q over V is a wide loop.
    `view` holds the last cycles of both solutions at all instants. `instant_indices` (m,) are those
    of the slider.
    """
    reference_cycle = view.reference_cycle
    result_cycle = view.result_cycle
    series = {
        "t": view.time,
        "P": result_cycle.normal_load,
        "Q": result_cycle.tangential_load,
        "Q0": reference_cycle.tangential_load,
        "U0": reference_cycle.tangential_displacement,
        "U1": result_cycle.tangential_displacement,
        "V0": sheared_displacement(reference_cycle),
        "V1": sheared_displacement(result_cycle),
    }
    return {
        name: list(map(_seven_digits, values[instant_indices])) for name, values in series.items()
    }


def _instants_of_slider(view: CycleView) -> NDArray[np.int_]:
    """Indices of the instants through which the page's slider moves: all, or 200 evenly spaced ones
    with the first, the last and those that have a number in figures (`view.chosen_events`, each
    with its index in the cycle).
    """
    last_index = len(view.result_cycle.time) - 1
    spaced_indices = (
        np.linspace(0, last_index, min(last_index + 1, _MOST_INSTANTS)).round().astype(int)
    )
    chosen_indices = [event.index for event in view.chosen_events]
    return np.unique([*spaced_indices.tolist(), 0, last_index, *chosen_indices])


def _points_of_slider(view: CycleView, n_instants: int) -> NDArray[np.int_]:
    """Indices of the points that the page holds for its slider: of those drawn evenly as many as
    fit for `n_instants` instants, with the last one and those whose slip is shown over time. `view`
    holds the points `x` over a_ref (n,), and the largest that is drawn; a page carries at most
    100,000 instants times points.
    """
    drawn_points = np.flatnonzero(np.abs(view.x) <= 1.02 * view.largest_x)
    stride = -(-len(drawn_points) * n_instants // _MOST_VALUES)
    spaced_points = drawn_points[::stride].tolist()
    return np.unique([*spaced_points, drawn_points[-1], *slip_points(view.comparison)])


def _fields_of_slider(
    view: CycleView, grid: tuple[NDArray[np.int_], ...]
) -> tuple[dict[str, Any], NDArray[np.uint8]]:
    """For the page's script, at the instants and points that `grid` picks: pressure p, shear q and
    slip s of the reference, packed, with the differences result minus reference (dp, dq, ds); and
    codes of the states, that of the reference (0 to 3) plus 4 times that of the result.

    `view` holds the last cycles of both solutions, with arrays (k instants, n points). Its scales
    divide p by p_ref, the reference pressure, and q by f p_ref, f the friction coefficient.
    """
    field_and_scale = {
        "p": ("pressure", view.scales.pressure),
        "q": ("shear", view.scales.shear),
        "s": ("slip", 1.0),
    }
    fields = {}
    for key, (name, scale) in field_and_scale.items():
        reference_values = getattr(view.reference_cycle, name)[grid] / scale
        result_values = getattr(view.result_cycle, name)[grid] / scale
        # whole multiples of a step, as text
        fields[key] = _in_16_bits(reference_values)
        fields[f"d{key}"] = _in_16_bits(result_values - reference_values)
    state_of_reference = view.reference_cycle.state[grid].astype(np.uint8)
    state_of_result = view.result_cycle.state[grid].astype(np.uint8)
    return fields, state_of_reference + 4 * state_of_result


def _seven_digits(value: float) -> float | None:
    """A number for the page, to seven digits; None for NaN and infinity."""
    return float(f"{value:.7g}") if np.isfinite(value) else None


def _position_of(index: int, indices: NDArray[np.int_]) -> int:
    """Position of an index among the indices (m,) that the page holds."""
    return int(np.flatnonzero(indices == index)[0])


def _extent_of_slider_in_words(script_data: Mapping[str, Any]) -> str:
    """A sentence on how many instants and points of the last cycle the page's slider moves through.
    `script_data` is what the page's script is given; all its numbers here are counts.
    """
    n_all_instants, n_all_points = script_data["of"]
    n_slider_instants = script_data["instants"]
    n_slider_points = script_data["points"]
    part_of_path = script_data["stretch"]  # such as "last cycle" or "whole record"
    if n_slider_instants == n_all_instants and n_slider_points == n_all_points:
        return f"The slider moves through every instant and point of the {part_of_path}."
    return (
        f"The slider moves through {n_slider_instants} of the {n_all_instants} instants and"
        f" {n_slider_points} of the {n_all_points} points of the {part_of_path} (those near the"
        " contact);"
        " figures that stand still, and the CSV, hold all of them, but where their captions say"
        " less."
    )


def _tables(texts: Mapping[str, str]) -> dict[str, str]:
    """Name -> the CSV of each figure, compressed and as text, for the page; those of more than a
    million and a half letters are left out, and stay beside the page.
    """
    short_texts = {name: text for name, text in texts.items() if len(text) <= _MOST_LETTERS}
    return {
        name: base64.b64encode(zlib.compress(text.encode(), _COMPRESSION)).decode()
        for name, text in short_texts.items()
    }


def _as_script(content: dict[str, Any]) -> str:
    """JSON that can stand in a script element: no "<" in it, so nothing in a name can end the
    element.

    >>> _as_script({"engine": "</script>"})
    '{"engine":"\\\\u003c/script>"}'
    """
    return json.dumps(content, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def draw(report: Report) -> tuple[Plate, ...]:
    """Every figure of a report, in the order of the page. Figures for which the result lacks the
    field (slip, dissipation) or the instants are left out.

    Of `report` are used: the comparison; the study of several meshes of an external result, and the
    error budget, each None where there is none. `comparison.why` is the difference of W split by
    its causes, or None.
    """
    comparison = report.comparison
    plates = _plates_of_cycle(comparison)
    if report.study is not None:
        plates.append(study_convergence(report.study))
    if comparison.why is not None:
        plates.append(waterfall(comparison.why))
    if report.budget is not None:
        plates += [budget_bars(report.budget), mesh_refinement(report.budget)]
    # of the finite elements; none in a solution that was read from a file
    meshes = getattr(comparison.result, "bodies", ())
    if meshes:
        from reports.field_output.pictures import mesh

        edge_of_result = float(np.nanmax(comparison.result_cycle.contact_edges))
        plates.append(mesh(meshes, comparison.scales.half_width, edge_of_result))
    names_left_out = _names_of_plates_without_values(comparison)
    return tuple(plate for plate in plates if plate and plate.name not in names_left_out)


def _plates_of_cycle(comparison: Comparison) -> list[Plate | None]:
    """The figures of the scene and of its last cycle, in the order of the page: both bodies; of
    measured rows the fit and the friction work; loads, tractions, slip and dissipation by both
    solutions. One is None where it does not apply.
    """
    # the last cycles of both solutions, with the axes that figures share
    view = CycleView(comparison)
    half_width = comparison.scales.half_width  # a_ref, at the reference load
    plates: list[Plate | None] = [sketch(comparison.scene, half_width)]
    if comparison.scene.has_measured_rows:
        contact_edge = float(np.nanmax(comparison.reference_cycle.contact_edges))  # at right
        plates += [fit_residuals(comparison.scene, contact_edge), cumulative_work(view)]
    return [
        *plates,
        load_path(view),
        moving_instant(view),
        hysteresis(view),
        state_map(view),
        half_widths(view),
        slip_histories(view),
        dissipation_density(view),
        discrepancies(view),
        tractions(view),
    ]


def _names_of_plates_without_values(comparison: Comparison) -> set[str]:
    """Names of the figures that the result has nothing to draw for: those of slip and of
    dissipation without that field, and those over time with fewer than two instants.
    """
    names = set()
    for field, name in (
        ("slip", "slip_history"),
        ("dissipation_density", "dissipation_density"),
    ):
        if field in reason_by_missing_field(comparison.result):
            names.add(name)
    if len(comparison.result_cycle.time) < 2:
        names |= {"state_map", "half_widths", "slip_history", "errors"}
    return names


def figure(report: Comparison | Report, name: str) -> str:
    """One figure of a report's page as an SVG document that stands alone.

    Parameters
    ----------
    report
        a `Report`, or a comparison that `compare` or `score` returned
    name
        of the figure, as its CSV beside the page is called

    Raises
    ------
    InputError
        For a name that no figure of this comparison has.

    Examples
    --------
    >>> import reports
    >>> import semi_analytic
    >>> exact = semi_analytic.solve("cattaneo-mindlin")
    >>> reports.figure(reports.compare(exact, exact), "hysteresis")[:11]
    '<svg xmlns='
    """
    _require_report(report, "figure")
    if not isinstance(report, Report):
        report = Report(report)
    figures = {plate.name: plate for plate in draw(report)}
    if name not in figures:
        raise InputError(
            f"figure: {name!r} is no figure of this comparison; its figures are"
            f" {', '.join(figures)}"
        )
    return figures[name].svg()


def published(comparison: Comparison) -> str:
    """The picture of a scene from a publication as SVG: tractions at the largest load, and beside
    them the loop of Q over U − k Q (k the mean slope dU/dQ), or the contact and stick edges where U
    does not move.
    """
    # the last cycles of both solutions, with the axes that figures share
    view = CycleView(comparison)
    scene = comparison.scene
    size = (440.0, 330.0)  # of each panel [pixels]
    instant = _instant_of_largest_loads(comparison.reference_cycle)
    title = f"t = {comparison.reference_cycle.time[instant]:.4g}"
    # without the panel of the differences; with words on the axis of x
    traction_panel, _ = traction_panels(view, instant, [instant], "tractions", size, title)
    traction_panel = replace(traction_panel, x=view.over_x(), room=None)
    second_panel = replace(_panel_of_loop_or_edges(view), height=size[1])
    keys = traction_keys(view)[:4]  # legend of p and q of both engines, without their differences
    alt = f"Both engines on {scene.name}"
    panels = (traction_panel, second_panel)
    plate = Plate(scene.name, scene.title or scene.name, "", alt, panels, {}, keys)
    return plate.svg() + "\n"


def _instant_of_largest_loads(cycle: Cycle) -> int:
    """Index of the instant of the largest P in a cycle, and of several with that P of the one with
    the largest |Q|.
    """
    has_largest_load = cycle.normal_load >= cycle.normal_load.max() * (1 - 1e-9)
    size_of_q = np.where(has_largest_load, np.abs(cycle.tangential_load), -1.0)
    return int(np.argmax(size_of_q))


def _panel_of_loop_or_edges(view: CycleView) -> Panel:
    """A panel of the loop of Q over U − k Q (k the mean slope dU/dQ); of the contact and stick
    edges over time where U does not move, or the result holds none. Changes the axis of time of
    `view` from shares of the period to times.
    """
    stroke = np.ptp(view.reference_cycle.tangential_displacement)
    is_moving = stroke > 1e-9 * view.scales.displacement
    # figure of the loops: Q over U, then Q over U − k Q
    loop_plate = hysteresis(view) if is_moving else None
    view.time = view.result_cycle.time
    view.time_words = "time"
    panel = loop_plate.panels[1] if loop_plate else half_widths(view).panels[0]
    assert isinstance(panel, Panel)
    return panel
