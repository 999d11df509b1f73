"""The commands that judge results: an external one against the reference, two runs against each
other.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import (
    EXIT_NOT_CONVERGED,
    EXIT_OUTSIDE,
    EXIT_WITHIN,
    TEMPLATES,
    Answer,
    Options,
    requested_tolerances,
)
from reports.cli.solving import exit_code, read, verdict_shown
from reports.console import Part, Sheet, Stages, complain
from reports.units import minus

if TYPE_CHECKING:
    from reports.comparison import Comparison
    from reports.comparison.findings import Difference, ValueRow
    from reports.report import Report
    from reports.scoring.loops import LoopScore
    from reports.scoring.mapping import Mapping
    from scenes import Scene


# ------------------------------------------------------------------------------- an external result
def score(result: str | None, options: Options) -> Answer:
    """The command `score`: compare an external result with the reference solution of a scene. The
    answer has the verdict, likely causes of the difference, and the page.

    `result` is the path of a file of tractions, of a folder of such files from several meshes, or
    of a measured loop of Q over U (--as loop). None with --mapping-example alone. A file given as
    --mapping names columns and units. The exit code is 3 where the reference is not converged.
    """
    from scenes import ConvergenceError, InputError

    if options.mapping_example:
        # TEMPLATES: folder of the texts that commands print
        example_file = TEMPLATES / "mapping.toml"
        return Answer(EXIT_WITHIN, [example_file.read_text("utf-8").rstrip()])
    if result is None:
        raise InputError("score: name the result to score, a file or a folder of files")
    if options.scene is None:
        raise InputError(
            f"{result}: --scene is missing: name the scene that it answers; `halfplane scenes`"
            " lists the library"
        )
    from reports.folder import usable_folder
    from reports.scoring.mapping import load_mapping

    path = Path(result)
    is_loop = options.as_ == "loop"
    scene = read(options.scene)
    mapping = load_mapping(options.mapping)  # columns, units and signs; usual ones without a file
    if not path.exists():
        raise InputError(f"{result}: there is no such file or folder")
    _check_loop_options(path, options)
    tolerances = requested_tolerances(options.tolerance)
    folder = usable_folder(options.out or _folder_of(path, is_loop))
    command = options.command("score", result, folder)
    try:
        if is_loop:
            return _score_loop(path, mapping, scene, options, folder, command)
        return _score_tractions(path, mapping, scene, options, tolerances, folder, command)
    except ConvergenceError as failure:
        sentence = f"the reference is not converged: {failure}"
        # `complain` prints a line on stderr
        complain(f"halfplane: {scene.name}: {sentence}")
        return Answer(
            EXIT_NOT_CONVERGED,
            (),
            lambda: {"passed": False, "error": sentence, "file": None},
            scene.name,
        )


def _check_loop_options(path: Path, options: Options) -> None:
    """InputError where the options of `score` don't go together: some are for a measured loop of
    load over displacement alone (`as_` is "loop"), others for tractions alone. `path` is the
    result. The compliance of the rig is in 1/stress.
    """
    from scenes import InputError

    is_loop = options.as_ == "loop"
    if is_loop and not path.is_file():
        raise InputError(f"{path}: a loop is one file, a table with the columns U and Q")
    if is_loop and options.tolerance:
        raise InputError("--tolerance: a loop has none, its own scatter judges it; leave this out")
    if not is_loop and options.rig_compliance is not None:
        raise InputError(
            "--rig-compliance: it goes with --as loop; say that too, or leave this out"
        )
    if options.rig_compliance is not None and not math.isfinite(options.rig_compliance):
        raise InputError(
            f"--rig-compliance {options.rig_compliance:g} is refused: it is a finite number,"
            " 1/stress"
        )


def _folder_of(path: Path, is_loop: bool) -> Path:
    """The default output folder of the command `score`: out/score-NAME for a result file NAME.csv.
    `path` is the result file; `is_loop`: whether it is a measured loop.

    Raises
    ------
    InputError
        Where the folder holds the score of another file already: x.csv and x.rpt have one stem, and
        so have a/x.csv and b/x.csv.
    """
    from reports.folder import default_folder
    from scenes import InputError
    from scenes.files import parsed_json, text_of

    folder = default_folder(f"score-{path.resolve().stem}")
    for name, holds_loop in (("comparison.json", False), ("loop.json", True)):
        try:
            earlier_score = parsed_json(text_of(folder / name, "the score"))
            command_words = shlex.split(earlier_score["command"])
            # the operand of `score` is its result file
            earlier_path = Path(command_words[command_words.index("score") + 1])
        except (OSError, InputError, ValueError, KeyError, IndexError, TypeError):
            continue  # not there, or not of a score
        if holds_loop != is_loop or earlier_path.resolve() != path.resolve():
            kind = "the loop" if holds_loop else "the score"
            raise InputError(
                f"{folder}: it holds {kind} of {earlier_path}, which this one would replace; name a"
                f" folder for {path} by --out"
            )
    return folder


def _score_tractions(
    path: Path,
    mapping: Mapping,
    scene: Scene,
    options: Options,
    tolerances: dict[str, float],
    folder: Path,
    command: str,
) -> Answer:
    """The answer on an external result, the file or folder at `path`: values against the
    reference, likely causes of the difference, uncertainties of the inputs, page. The files of a
    folder are results on several meshes, which are compared as a mesh study.

    `mapping` names columns and units of the file, `tolerances` are relative, by metric, and
    `command` is the command line that the page states. `options.against` chooses the reference:
    half-plane theory or finite elements. `folder` is that of the page.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    stages = Stages(options.quiet)  # progress on stderr, and the seconds of each stage
    with stages.stage("loading"):
        from reports.page.content import whole_content
        from reports.page.writing import write
        from reports.scoring.against import report_with_diagnoses, score_file
        from reports.scoring.mesh_folder import score_folder
    if path.is_dir():
        report = score_folder(
            path, mapping, scene, stages, against=options.against, tolerances=tolerances
        )
    else:
        with stages.stage("reading and scoring"):
            report = score_file(
                path, mapping, scene, against=options.against, tolerances=tolerances
            )
        with stages.stage("diagnosis"):
            report = report_with_diagnoses(report)  # likely causes of the difference
    report = _with_inputs(report, mapping, stages)
    with stages.stage("report"):
        page = str(write(report, folder, command=command, seconds=dict(stages.seconds)))
    return Answer(
        exit_code(report.comparison),
        _score_shown(report, page),
        lambda: whole_content(report, command, stages.seconds) | {"page": page},
        scene.name,
    )


def _with_inputs(report: Report, mapping: Mapping, stages: Stages) -> Report:
    """The report with the uncertainty that the scene's uncertain inputs give to theory, and with
    the comparison of an external result with theory within that uncertainty.

    The report is returned as it is where the scene states no uncertain input. The comparison is
    left out where the result is a solution of this program. `mapping.measured` holds the
    uncertainties of a measured result, and whether it is said to be measured.
    """
    from dataclasses import replace

    from reports.comparison.laws import names_of_derived_fields
    from reports.inputs import input_effects
    from reports.validation import result_against_theory

    comparison = report.comparison
    if not comparison.scene.inputs:
        return report
    with stages.stage("uncertainty of the inputs"):
        # what the uncertain inputs do to values of theory; `effects`: compliances of finite bodies
        effects_of_inputs = input_effects(comparison.scene, comparison.effects)
    report = replace(report, inputs=effects_of_inputs, is_measured=mapping.measured.is_stated)
    # fields derived from others: an external result has some, a solution of this program has none
    if not names_of_derived_fields(comparison.result):
        return report
    return replace(
        report, validation=result_against_theory(comparison, effects_of_inputs, mapping.measured)
    )


def _score_loop(
    path: Path, mapping: Mapping, scene: Scene, options: Options, folder: Path, command: str
) -> Answer:
    """The answer on a measured loop of Q over U, the table at `path`: which friction coefficient
    fits it, beside computed loops; and its page. Outside where f of the scene does not fit.

    `mapping` names columns and units of the table; `command` is the command line that the page
    states. Options: the compliance of the rig (fitted where it is not given), and whether loops of
    finite elements are computed beside those of theory (`against` is "fe").

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    stages = Stages(options.quiet)  # progress on stderr, and the seconds of each stage
    with stages.stage("loading"):
        from reports.scoring import loop_page
        from reports.scoring.loops import read_loop, score_loop
    with stages.stage("reading"):
        measured_loop = read_loop(path, mapping, scene)
    with stages.stage("fitting"):
        loop_score = score_loop(
            measured_loop, scene, rig_compliance=options.rig_compliance, against=options.against
        )
    sentences, content_on_uncertainty = _validation_of_loop(loop_score, scene, mapping, stages)
    with stages.stage("report"):
        page = str(loop_page.write(loop_score, folder, command, content_on_uncertainty, sentences))
    title = f"{scene.title or scene.name}: measured loop {path.name}"
    return Answer(
        EXIT_WITHIN if loop_score.is_scene_friction_within else EXIT_OUTSIDE,
        [*_parts_of_loop(loop_score, path.name, title), *sentences, page],
        lambda: (
            loop_page.content(loop_score)
            | content_on_uncertainty
            | {"page": page, "seconds": stages.seconds}
        ),
        scene.name,
    )


def _validation_of_loop(
    loop_score: LoopScore, scene: Scene, mapping: Mapping, stages: Stages
) -> tuple[list[str], dict[str, Any]]:
    """The area of a measured loop against those of computed loops, with the uncertainties of the
    measurement (stated in `mapping`) and of the scene's inputs: sentences, and entries for --json.
    What the inputs do is timed as one of the `stages`; it is left out where the scene states no
    uncertainty.

    `loop_score` holds the measured loop and the computed ones with their areas.
    """
    from reports import validation
    from reports.input_words import content as input_content
    from reports.inputs import input_effects

    effects_of_inputs = None
    if scene.inputs:
        with stages.stage("uncertainty of the inputs"):
            effects_of_inputs = input_effects(scene)
    loop_validation = validation.loop_area_against_models(
        loop_score, effects_of_inputs, mapping.measured
    )
    sentences = validation.sentences(loop_validation, is_measured=True)
    return sentences, {
        "validation": [entry.content() for entry in loop_validation],
        "inputs": input_content(effects_of_inputs, scene),
    }


def _parts_of_loop(loop_score: LoopScore, file_name: str, title: str) -> Iterator[Part]:
    """What the terminal shows of a measured loop: how its columns were read, what was assumed or
    left out, a table of the loops (measured and computed) under this title, and a sentence on the
    friction coefficient that fits.

    `loop_score` holds the loops, the fitted coefficient, and how the table was read; `file_name` is
    that of the table.
    """
    from reports.comparison.words import reading_in_words
    from reports.scoring import loop_page

    yield reading_in_words(file_name, loop_score.read_as)
    yield from (f"Assumed: {sentence}." for sentence in loop_score.notes)
    heads, cells = loop_page.table_of_loops(loop_score)
    # Sheet: title, heads, rows, and the columns that are flush right
    yield Sheet(title, heads, cells, range(1, len(heads)))
    yield loop_score.sentence


def _score_shown(report: Report, page: str) -> Iterator[Part]:
    """What the terminal shows of the report on an external result: assumptions, verdict, metrics
    without a value, what the rows of the result show, likely causes, and the mesh study if there is
    one. `page` is the path of the page. Of `report`: `guesses` are assumptions on the file,
    `read_as` how its columns were read, `unscored` files of a mesh study that were left out. A
    `Sheet` is a table: title, heads, rows, and the columns that are flush right.
    """
    from reports.comparison.words import reading_in_words

    yield from (f"Assumed: {sentence}." for sentence in report.guesses)
    if report.read_as:
        yield reading_in_words(report.comparison.result.engine, report.read_as)
    yield from verdict_shown(report)
    yield from _inputs_shown(report)
    labels_on_points = [
        metric.label for metric in report.comparison.headlines if metric.is_on_points_of_result
    ]
    if labels_on_points:
        yield (
            f"Differences at the points and instants of the result: {'; '.join(labels_on_points)}."
            " There the reference has other values than its own in the table."
        )
    yield from _metrics_without_value_shown(report.comparison)
    if report.study is None:  # a mesh study's own sentences name the files not scored
        yield from (file.sentence for file in report.unscored)
    yield from _causes_shown(report)
    if report.study is not None:
        heads = report.study.heads
        yield Sheet("Mesh study", heads, report.study.rows, range(1, len(heads)))
        yield from report.study.sentences
    yield page


def _metrics_without_value_shown(comparison: Comparison) -> Iterator[str]:
    """Lines on the metrics of the first table that have no value, each with the reason. Those with
    the same reason share a line.
    """
    labels_of_reason: dict[str, list[str]] = {}
    for metric in comparison.headlines:
        if metric.value is None and metric.note:
            labels_of_reason.setdefault(metric.note, []).append(metric.label)
    for reason, labels in labels_of_reason.items():
        yield f"Not scored: {', '.join(labels)} ({reason})."


def _causes_shown(report: Report) -> Iterator[str]:
    """Lines on the difference of an external result: numbered, what its rows show (`evidence`), and
    likely causes (`diagnoses`), each with its own evidence below it.
    """
    if report.evidence:
        yield "What the rows show:"
    for position, observation in enumerate(report.evidence, 1):
        yield f"{position}. {observation.sentence}"
    if report.diagnoses:
        yield "Likely causes:"
    for position, diagnosis in enumerate(report.diagnoses, 1):
        yield "\n   - ".join((f"{position}. {diagnosis.sentence}", *diagnosis.evidence))


def _inputs_shown(report: Report) -> Iterator[Part]:
    """A paragraph on what the uncertain inputs do to theory, and how the result stands against it;
    nothing without these.
    """
    from reports.input_words import sentences_of_report

    if input_sentences := sentences_of_report(report):
        yield " ".join(input_sentences)


# ------------------------------------------------------------------ two runs, or one and a baseline
def diff(a: str, b: str, options: Options) -> Answer:
    """The command `diff`: compare the values of two runs, A and B, value by value. `a` and `b` are
    their files or folders. With --accept the values of A are written to B as a baseline, the file
    that later runs are compared with.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    from reports.comparison.findings import (
        difference_of_runs,
        is_baseline,
        patterned_tolerances,
        read_run_values,
        write_baseline,
    )
    from scenes import InputError

    tolerances = patterned_tolerances(options.tolerance)  # pattern of keys -> largest difference
    path_b = Path(b)
    values_a = read_run_values(a)  # key -> value, with scene, settings and versions
    if not options.accept:
        if not path_b.exists():
            raise InputError(
                f"{b}: there is no such file or folder; `halfplane diff {a} {b} --accept` writes it"
                " as a baseline"
            )
        return _difference_answer(difference_of_runs(values_a, read_run_values(b), tolerances))
    if path_b.exists() and not is_baseline(path_b):
        raise InputError(
            f"{b}: this is not a baseline, and --accept writes over nothing else; name another file"
        )
    earlier_baseline = read_run_values(b) if path_b.exists() else None
    # A new baseline is compared with itself: that refuses an unknown key of --tolerance.
    difference_to_b = difference_of_runs(values_a, earlier_baseline or values_a, tolerances)
    earlier_tolerances = earlier_baseline.tolerances if earlier_baseline else {}
    write_baseline(values_a, path_b, {**earlier_tolerances, **tolerances})
    parts: list[Part] = []
    if earlier_baseline:
        parts += _difference_parts(difference_to_b)
    scene_name = values_a.scene.name or values_a.source
    parts.append(f"{b}: {len(values_a.values_by_key)} values of {scene_name} accepted")
    return Answer(EXIT_WITHIN, parts, difference_to_b.content, difference_to_b.scene)


def _difference_answer(difference: Difference) -> Answer:
    """The answer of the command `diff` on two runs: exit code 0 where all values are the same
    within tolerance, else 1; and what the terminal and --json show of their difference.
    """
    code = EXIT_WITHIN if difference.are_same else EXIT_OUTSIDE
    return Answer(
        code,
        _difference_parts(difference),
        difference.content,
        difference.scene,
    )


def _difference_parts(difference_of_runs: Difference) -> Iterator[Part]:
    """What the terminal shows of the difference of two runs A and B: a table of the values that are
    not identical, how many are identical, and which differ by more than their tolerance. A row of
    `difference_of_runs` has a value of A and of B (`a`, `b`), their difference, and the verdict.
    """
    from reports.comparison.findings import SAME

    listed_rows = []
    for row in difference_of_runs.rows:
        is_identical = row.verdict == SAME and (row.difference == 0 or row.a == row.b)
        if not is_identical:
            listed_rows.append(_cells(row))
    title = f"{difference_of_runs.scene}: A = {difference_of_runs.a}, B = {difference_of_runs.b}"
    heads = ("value", "A", "B", "B − A", "tolerance", "verdict")
    yield Sheet(title, heads, listed_rows, (1, 2, 3, 4)) if listed_rows else title
    if n_identical := len(difference_of_runs.rows) - len(listed_rows):
        yield (
            f"{n_identical} values are the same to the last digit and not listed (--json has them)"
        )
    yield from difference_of_runs.notes
    different_keys = [row.key for row in difference_of_runs.rows if row.verdict != SAME]
    if different_keys:
        names = ", ".join(different_keys)
        yield f"{len(difference_of_runs.rows)} values, {len(different_keys)} differ: {names}"
    else:
        yield f"all {len(difference_of_runs.rows)} values are the same within tolerance"


def _cells(row: ValueRow) -> tuple[str, ...]:
    """Cells of one value of two runs A and B: name, A, B, B − A, tolerance, verdict. The difference
    is marked "rel." where it is over the larger of |A| and |B|.
    """
    value_a, value_b = ("none" if value is None else f"{value:.10g}" for value in (row.a, row.b))
    if row.difference is None:
        difference_text = "–"
    elif row.difference == 0:
        difference_text = "0"
    else:
        unit = "" if row.kind == "absolute" else " rel."
        # `minus`: with a real minus sign
        difference_text = minus(f"{row.difference:+.1e}{unit}")
    return (row.key, value_a, value_b, difference_text, f"{row.tolerance:g}", row.verdict)
