"""The commands that solve one scene: both engines with their comparison, or one engine alone."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import (
    EXIT_INTERRUPTED,
    EXIT_NOT_CONVERGED,
    EXIT_OUTSIDE,
    EXIT_WITHIN,
    Answer,
    Options,
    requested_tolerances,
)
from reports.console import Part, Sheet, Stages, complain

# All else is heavy, and imported in the functions: `halfplane run --help` waits for nothing.
if TYPE_CHECKING:
    from reports.checking import EngineRefusals
    from reports.comparison import Comparison
    from reports.comparison.budget import ErrorBudget
    from reports.comparison.laws import Certificate, ExpectedNumber
    from reports.inputs import InputEffects
    from reports.report import Report
    from scenes import (
        BodyEffects,
        ContactSolution,
        ConvergenceError,
        InputError,
        Interrupted,
        Scene,
    )

_STYLES = {"within": "bold green", "outside": "bold red", "undecided": "bold yellow"}


# -------------------------------------------------------------- what every command that solves does
def read(source: str, *, may_prescribe_displacements: bool = False) -> Scene:
    """The scene that `source` names, in the library or as a file.

    InputError where it can't be read, where P is negative or |Q| exceeds f P anywhere on the path,
    and for prescribed displacements (`load.is_driven`) unless `may_prescribe_displacements`.
    """
    from reports.checking import require_admissible
    from scenes import InputError, load_scene
    from scenes.loads import REFUSAL_OF_DISPLACEMENTS

    scene = load_scene(source)
    if scene.load.is_driven and not may_prescribe_displacements:
        # REFUSAL_OF_DISPLACEMENTS: a sentence
        raise InputError(f"{source}: {REFUSAL_OF_DISPLACEMENTS}")
    require_admissible(scene, source)
    return scene


@dataclass(frozen=True)
class Job:
    """What a command that solves is about."""

    source: str  # the scene as the user named it
    scene: Scene
    options: Options
    folder: Path  # of the output
    stages: Stages  # progress on stderr, and seconds of each stage

    def command(self, name: str) -> str:
        """The command line that repeats this job by the command `name`."""
        return self.options.command(name, self.source, self.folder)


def solving_command(solve_job: Callable[[Job], Answer]) -> Callable[[str, Options], Answer]:
    """Make a command out of `solve_job`: the command reads the scene, claims the output folder,
    calls `solve_job`, and turns non-convergence and interruptions into answers with their exit
    codes. Bad input stays an InputError, with the source in front.

    What was solved before a failure or an interruption is kept in the folder; an interruption
    before two instants were solved ends as KeyboardInterrupt, and keeps nothing. Where the folder
    holds a file of another program that the command would write over, it is refused before anything
    is solved.

    An answer has the exit code (130 after an interruption, 3 without convergence), what the
    terminal shows, and the content for --json. The command is named as `solve_job`.
    """

    @wraps(solve_job)
    def command(source: str, options: Options) -> Answer:
        """Solve the scene that `source` names, with the command-line options `options`; keep what
        was solved if it fails.
        """
        from reports.folder import default_folder, usable_folder
        from scenes import ConvergenceError, InputError, Interrupted

        name = solve_job.__name__
        scene = read(source, may_prescribe_displacements=name in ("exact", "fe", "run"))
        folder = usable_folder(
            options.out or default_folder(scene.name), _file_names_of(name, scene)
        )
        job = Job(source, scene, options, folder, Stages(options.quiet))
        try:
            return solve_job(job)
        except InputError as fault:
            # An error about an option or the file names it already, an error of an engine does not.
            if str(fault).startswith((source, "--")):
                raise
            raise _error_with_source(fault, source) from fault
        except Interrupted as stop:
            if stop.partial is None or len(stop.partial.time) < 2:
                raise KeyboardInterrupt from stop
            return _answer_of_interruption(stop, stop.partial, folder)
        except ConvergenceError as failure:
            return _answer_without_convergence(failure, job)

    return command


def _error_with_source(fault: InputError, source: str) -> InputError:
    """The error with the name of the scene, as the user gave it, before its message; and with its
    notes, such as which file was saved.
    """
    from scenes import InputError

    error_with_source = InputError(f"{source}: {fault}")
    for note in getattr(fault, "__notes__", ()):
        error_with_source.add_note(note)
    return error_with_source


def _answer_of_interruption(
    stop: Interrupted, partial_solution: ContactSolution, folder: Path
) -> Answer:
    """Save the steps that were solved before an interruption (Ctrl-C) in the folder; the answer has
    the exit code 130 alone. A line on stderr names the file.

    `stop` is the interruption, whose message begins that line. `partial_solution` holds the solved
    steps.
    """
    # a solution that converged gets the file name of its engine, which "" stands for
    stem = "" if partial_solution.record.converged else "partial"
    path = write_solution(partial_solution, folder, name=stem)
    # `complain` prints a line on stderr
    complain(
        f"halfplane: {stop}; what was solved is kept in {path}"
        f" ({len(partial_solution.time) - 1} steps)"
    )
    return Answer(EXIT_INTERRUPTED)


def _answer_without_convergence(failure: ConvergenceError, job: Job) -> Answer:
    """The answer of a command whose solver did not converge, with exit code 3. The steps solved
    before are saved in the job's folder; without one nothing is. The table sums them up, and --json
    has the reason and the name of the file. A line on stderr has the reason too.

    `failure` is the error, with its reason and the solution up to the last converged step, None
    without one.
    """
    from reports.comparison.words import summary_rows

    # `complain` prints a line on stderr
    complain(f"halfplane: {job.scene.name}: not converged: {failure}")
    json_content = {"passed": False, "error": str(failure), "file": None}
    parts: list[Part] = []
    if failure.partial is not None:
        path = write_solution(failure.partial, job.folder, name="partial")
        json_content["file"] = str(path)
        rows = summary_rows(failure.partial)
        parts = [
            Sheet("What was solved before it failed", ("quantity", "value"), rows),
            str(path),
        ]
    elif not job.options.json:
        complain("halfplane: no step was solved, so nothing was written")
    return Answer(EXIT_NOT_CONVERGED, parts, lambda: json_content, job.scene.name)


def _file_names_of(command: str, scene: Scene) -> tuple[str, ...]:
    """Names of all files that the command named `command` may write to its folder: those of its
    answer, and those named "partial" that a failure or an interruption leaves. Solution files of an
    engine are named after it.
    """
    from reports.folder import NAMES_OF_RESULTS, names_of_solution_files

    # NAMES_OF_RESULTS: the files of a comparison, its page among them
    partial_files = names_of_solution_files("partial")
    if command == "exact":
        return (*names_of_solution_files("semi_analytic"), *partial_files)
    if command == "fe":
        return (*names_of_solution_files("halfplane_fe"), *partial_files)
    if command == "export":
        return (deck_file(scene),)
    if command == "run":  # of a scene that one engine alone takes, the answer of that one
        return (
            *NAMES_OF_RESULTS,
            *names_of_solution_files("semi_analytic"),
            *names_of_solution_files("halfplane_fe"),
            *partial_files,
        )
    return (*NAMES_OF_RESULTS, *partial_files)


def deck_file(scene: Scene) -> str:
    """Name of the deck that `export` writes."""
    from reports.folder import default_folder

    return f"{default_folder(scene.name).name}_calculix.inp"


_ENGINES = ("halfplane_fe.solution", "semi_analytic.solution")


def load_engines(stages: Stages, engines: Sequence[str] = _ENGINES) -> None:
    """Import the modules `engines`, by default those of theory and of finite elements, timed as the
    stage "loading". InputError where a library that they need can't be loaded.
    """
    from scenes import InputError

    with stages.stage("loading"):
        try:
            from meshes.interrupts import interrupts_wait

            # Ctrl-C waits meanwhile: compiled modules would make an ImportError of it
            with interrupts_wait():
                for engine in engines:
                    import_module(engine)
        except (ImportError, OSError) as reason:
            raise InputError(
                f"the engines can't be loaded: {reason}; `halfplane doctor` says what is missing"
            ) from reason


def require_drawing(stages: Stages) -> None:
    """InputError where no picture can be drawn on this machine. That is tried in a process of its
    own, since some libraries end their process.
    """
    from reports.cli.machine import drawing
    from scenes import InputError

    with stages.stage("can pictures be drawn?"):
        can_draw, reason = drawing()
    if not can_draw:
        raise InputError(f"pictures can't be drawn here: {reason}; --no-pictures leaves them out")


def require_times(words: Iterable[str], option: str, scene: Scene) -> None:
    """InputError for a word that is neither a time of the path nor "events", before anything is
    solved.
    """
    from reports.field_output.files import instant_of

    # of the load path; `instant_of` refuses a time outside it
    segments = list(scene.load.path().segments(scene.cycles)) if words else []
    for word in words:
        if word != "events":
            instant_of(word, option, float(segments[0].start), float(segments[-1].end))


def solve_finite_elements(job: Job) -> ContactSolution:
    """The finite-element answer."""
    import halfplane_fe

    mesh, settings = job.options.settings()
    with job.stages.stage("finite elements") as report:
        return halfplane_fe.solve(job.scene, mesh=mesh, settings=settings, progress=report)


def _solve_half_plane(job: Job, **where: Any) -> ContactSolution:
    """The half-plane answer, at the x and time, and with the effects of bodies, of `where` if it
    has them.
    """
    import semi_analytic

    with job.stages.stage("half-plane theory"):
        return semi_analytic.solve(job.scene, **where)


def _effects_of_bodies(job: Job) -> BodyEffects:
    """What the bodies of the job's scene add to half-planes, by finite elements; timed as a
    stage.
    """
    import halfplane_fe

    with job.stages.stage("numbers of the bodies"):
        return halfplane_fe.body_effects(job.scene)


def _solve_rig(job: Job) -> ContactSolution:
    """The answer of corrected theory to prescribed displacements; half-planes have no effects."""
    if job.scene.bodies.half_planes:
        return _solve_half_plane(job)
    return _solve_half_plane(job, effects=_effects_of_bodies(job))


# Rows of a record above which the uncertainty of real bodies is measured on request only: every row
# is an increment of each of two coarser meshes too.
_LONG_RECORD = 200


def _reason_for_no_budget(scene: Scene) -> str:
    """The reason why the uncertainty of the answer for real bodies is not measured without
    --budget: the scene's record of loads has more than 200 rows. "" where it is measured.
    """
    from scenes import TimeSeriesLoad

    # 0 for loads that are no table over time
    n_rows = len(scene.load.kept_rows()) if isinstance(scene.load, TimeSeriesLoad) else 0
    if n_rows <= _LONG_RECORD:
        return ""
    return (
        f"no uncertainty was measured: the record has {n_rows:,} rows, more than {_LONG_RECORD};"
        " --budget measures it"
    )


# ------------------------------------------------------------------------------------- both engines
@solving_command
def run(job: Job) -> Answer:
    """The command `run`: solve a scene by half-plane theory and finite elements, compare the two,
    write the page. The exit code is 0 where the comparison passed and the scene's expected numbers
    are met, else 1; 3 where a third solver failed.

    A scene that one of the two alone takes gets the answer of the command `exact` or `fe`. One
    that prescribes displacements gets the answers of both, without a comparison.

    A job has the scene, its name as the user gave it (`source`), the command-line options, the
    output folder, and the stages whose progress is shown.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    from reports.checking import engine_refusals

    options = job.options
    tolerances = requested_tolerances(options.tolerance)
    require_times(options.vtu, "--vtu", job.scene)
    require_times(options.stress, "--stress", job.scene)
    if options.stress:
        require_drawing(job.stages)
    load_engines(job.stages)  # imports the modules of theory and finite elements
    # Why theory or finite elements refuse the scene is known before anything is solved.
    refusals = engine_refusals(job.scene, job.source)
    options.settings()  # values out of range are refused before anything is solved
    if no_comparison := refusals.in_words(job.source):  # the reason, in a sentence
        _require_no_option_of_both(job, no_comparison)
        # `complain` prints a line on stderr
        complain(f"halfplane: {job.scene.name}: no comparison. {no_comparison}")
        if job.scene.load.is_driven:  # a displacement is prescribed in place of the load Q
            return _answer_of_rig(job, refusals, no_comparison)
        if refusals.refusal_of_theory:
            solution = solve_finite_elements(job)
            command = "fe"
        else:
            solution = _solve_half_plane(job)
            command = "exact"
        return replace(_answer_of_one_engine(job, solution, no_comparison), command=command)
    if options.third:
        _third_solver(options.third).require()  # InputError where its program is missing
    return _answer_of_both(job, _compare_engines(job, tolerances))


def _require_no_option_of_both(job: Job, no_comparison: str) -> None:
    """InputError for an option that goes with a comparison, of a scene that one engine takes.
    `no_comparison` is the reason, in a sentence.
    """
    from scenes import InputError

    for name in ("tolerance", "budget", "vtu", "stress", "third"):
        if getattr(job.options, name):
            raise InputError(
                f"{job.source}: --{name} goes with a comparison of both engines: leave it out."
                f" {no_comparison}"
            )


# Third solvers by the name that --third takes: modules of studies, loaded when they are asked for.
_THIRD_SOLVERS = {"calculix": "reports.studies.third.commands"}


def _third_solver(name: str) -> Any:
    """The module of a third solver: `require()` refuses where its program is missing, `answer(job,
    result)` runs it.
    """
    return import_module(_THIRD_SOLVERS[name])


def _compare_engines(job: Job, tolerances: dict[str, float]) -> Report:
    """Solve a scene by both engines, compare them, and write the page.

    The budget of the errors (those of mesh, load steps and far field) is measured on request. For
    real bodies it is measured by default too, unless the record of loads is long. A third solver
    runs on request. The finite elements' solution is saved if anything after it fails.

    A job has the scene, the command-line options, the output folder, and the stages whose progress
    is shown. `tolerances`: key of a metric -> largest relative difference.
    """
    from reports.comparison.pairs import are_half_planes
    from reports.report import Report

    # By how much theory is wrong for real bodies means little without an uncertainty.
    measures_budget = bool(job.options.budget)
    reason_for_no_budget = ""
    if job.options.budget is None and not are_half_planes(job.scene):
        reason_for_no_budget = _reason_for_no_budget(job.scene)
        measures_budget = not reason_for_no_budget
    if reason_for_no_budget:
        job.stages.remark(reason_for_no_budget)
    seconds_before = time.process_time()
    fe_solution = solve_finite_elements(job)  # the solution
    with _solution_kept_on_interrupt(fe_solution):
        with _solution_saved_on_failure(fe_solution, job.folder):
            comparison = _comparison_with_theory(job, fe_solution, tolerances, measures_budget)
            if reason_for_no_budget:
                note = f"{reason_for_no_budget[:1].upper()}{reason_for_no_budget[1:]}."
                comparison = replace(comparison, notes=(*comparison.notes, note))
            report = Report(comparison)
            if measures_budget:
                report = _report_with_budget(job, comparison, seconds_before)
            # what the uncertainties of the inputs do to the values; None where none is stated
            inputs = _effects_of_inputs(job, comparison.effects)
            report = replace(report, inputs=inputs)
            if job.options.third:
                third_answer = _third_solver(job.options.third).answer(job, fe_solution)
                report = replace(report, third=third_answer)
        _write_page(job, report)
    return report


def _comparison_with_theory(
    job: Job, fe_solution: ContactSolution, tolerances: dict[str, float], measures_budget: bool
) -> Comparison:
    """Compare the finite elements' solution `fe_solution` with half-plane theory, solved at its
    surface points and instants, to the relative `tolerances` by metric.

    Theory is also solved on the load path's polygon, whose vertices are the loads at these
    instants: that shows the error of the load steps. It has all fields if `measures_budget`, else
    those that the page shows. Stages of `job` show the progress.
    """
    from reports.comparison.budget import SHOWN_ON_STEPS, theory_on_steps

    reference = _solve_half_plane(job, x=fe_solution.x, time=fe_solution.time)
    # A thinned solution stores some of its instants only. The path is then a polygon itself, and
    # the reference follows it.
    theory_on_polygon: ContactSolution | None = reference
    if not fe_solution.thinned:
        with job.stages.stage("half-plane theory, on the polygon of the steps"):
            # SHOWN_ON_STEPS: the fields that the page shows of theory on the polygon
            fields = None if measures_budget else SHOWN_ON_STEPS
            theory_on_polygon = theory_on_steps(fe_solution, fields)
    with job.stages.stage("comparison"):
        from reports.comparison import compare
        from reports.comparison.datum import effects_between

        return compare(
            reference,
            fe_solution,
            polygon_reference=theory_on_polygon,
            tolerances=tolerances,
            # compliances of finite bodies, where displacements count from different places
            effects=effects_between(reference, fe_solution),
        )


def _report_with_budget(job: Job, comparison: Comparison, seconds_before: float) -> Report:
    """The report on a comparison, with the budget of its errors, which is measured here, and for
    real bodies the causes of the difference.

    The budget states what each source of error (mesh, load steps, far field) adds to the difference
    from theory. `seconds_before` is the processor time before the finite elements were solved. From
    it follows what the budget costs over the run itself. `job` has the scene, the command-line
    options (of which mesh and solver have settings), and the stages whose progress is shown.
    """
    from reports.comparison.budget import error_budget, solve_refinements
    from reports.comparison.pairs import are_half_planes
    from reports.report import with_budget

    seconds_of_run = time.process_time() - seconds_before
    # Two coarser meshes are the least that shows an order of convergence; three on request.
    n_coarser_meshes = 3 if job.options.budget else 2
    mesh, settings = job.options.settings()
    # The solved runs on coarser meshes and with other far fields; each is a stage of its own.
    refinements = solve_refinements(comparison, mesh, settings, job.stages.stage, n_coarser_meshes)
    report = with_budget(comparison, error_budget(comparison, refinements, seconds_of_run))
    if are_half_planes(job.scene):
        return report
    with job.stages.stage("why"):
        from reports.advising_by_numbers import split_difference_of_work

        # the difference of the dissipation between theory and finite elements, by its causes
        causes = split_difference_of_work(report.comparison, report.budget)
    return replace(report, comparison=replace(report.comparison, why=causes))


def _effects_of_inputs(job: Job, effects: BodyEffects | None = None) -> InputEffects | None:
    """What the stated uncertainties of the inputs do to the answer, timed as a stage; None where
    none is stated. `effects` is what the bodies add, where it is known.
    """
    if not job.scene.inputs:
        return None
    from reports.inputs import input_effects

    with job.stages.stage("uncertainty of the inputs"):
        return input_effects(job.scene, effects)


def _inputs_shown(
    inputs: InputEffects | None, scene: Scene, comparison: Comparison | None = None
) -> Iterator[Part]:
    """What the terminal shows of `inputs`, what the uncertainties of the scene's inputs do to the
    answer: sentences, then tables. Nothing where it is None: the scene states no uncertainty.

    `inputs.values` are values of half-plane theory with their uncertainty. `inputs.difference` are
    those of the difference between theory corrected for the finite bodies and half-planes. Tables
    are left out where these have no entries. A `Sheet` is a table: title, heads, rows, and the
    columns that are flush right.
    """
    from reports import input_words

    if inputs is None:
        return
    yield " ".join(input_words.sentences(inputs, scene, comparison))
    if inputs.values:
        heads, rows = input_words.table_of_inputs(inputs)
        yield Sheet("Standard uncertainties of the inputs", heads, rows, range(1, len(heads)))
        heads = input_words.HEADS_OF_THEORY_VALUES
        yield Sheet(
            "What they make of theory",
            heads,
            input_words.rows_of_theory_values(inputs, scene),
            (1, 2, 3),
        )
    if inputs.difference:
        heads = input_words.HEADS_OF_DIFFERENCE
        rows = input_words.rows_of_difference(inputs)
        yield Sheet("What they make of the difference", heads, rows, (1, 2))


def _write_page(job: Job, report: Report) -> None:
    """Write the page of a run and its files to the job's folder, timed as the stage "report".

    The options --vtu and --stress name instants, at which both bodies are written for ParaView, and
    at which the page shows von Mises' stress.
    """
    fe_solution = report.comparison.result  # the solution by finite elements
    command = job.command("run")
    with job.stages.stage("report"):
        from reports.field_output.files import instants_of
        from reports.page.writing import write

        vtu_times = [instant.time for instant in instants_of(job.options.vtu, fe_solution, "--vtu")]
        write(
            report,
            job.folder,
            vtu_instants=vtu_times,
            command=command,
            seconds=dict(job.stages.seconds),
            stress_instants=instants_of(job.options.stress, fe_solution, "--stress"),
            log=(f"{time.strftime('%Y-%m-%d %H:%M:%S %z')}  {command}", *job.stages.log),
        )


@contextmanager
def _solution_kept_on_interrupt(solution: ContactSolution) -> Generator[None, None, None]:
    """Within this context Ctrl-C raises `Interrupted` with `solution` in it, so that the command
    saves it; unless the page was complete in its folder already (then `FilledBefore`, a kind of
    KeyboardInterrupt, comes instead).
    """
    from reports.folder import FilledBefore
    from scenes import Interrupted

    try:
        yield
    except FilledBefore:
        raise
    except KeyboardInterrupt as stop:
        raise Interrupted("interrupted after the finite elements were solved", solution) from stop


@contextmanager
def _solution_saved_on_failure(
    solution: ContactSolution, folder: Path
) -> Generator[None, None, None]:
    """Within this context an exception saves `solution`, that of the finite elements, in `folder`;
    a note on the exception names its file. The exception goes on.
    """
    try:
        yield
    except Exception as fault:
        with suppress(Exception):  # the fault itself is what has to be said
            path = write_solution(solution, folder)
            fault.add_note(f"the finite elements' answer is saved: {path}")
        raise


_METRIC_KEYS = ("value", "uncertainty", "unit", "tolerance", "accurate", "verdict", "honest")


def _answer_of_both(job: Job, report: Report) -> Answer:
    """The answer of `run` from its report: exit code, what the terminal shows, and the content for
    --json. Where the code is not 0 for a third solver, an undecided metric or one without a value,
    a line on stderr says so.

    `job` has the options, the seconds of each stage and the output folder.
    """
    from reports.comparison import laws

    comparison = report.comparison
    scene = comparison.scene
    # numbers that the scene expects, each with whether it is met
    findings = list(laws.expected_numbers(scene, (comparison.reference, comparison.result)))
    return Answer(
        _code_of_both(report, findings),
        _parts_of_both(job, report, findings),
        lambda: _json_of_both(job, report),
        scene.name,
    )


def _code_of_both(report: Report, findings: Sequence[ExpectedNumber]) -> int:
    """The exit code of `run`: 3 where a third solver failed, with a line on stderr; 0 where the
    comparison passed and all numbers that the scene expects (`findings`) are met; else 1.
    """
    if report.third is not None and report.third.failure:
        # `complain` prints a line on stderr
        complain(f"halfplane: {report.comparison.scene.name}: {report.third.failure}")
        return EXIT_NOT_CONVERGED
    code = exit_code(report.comparison)
    if not all(finding.is_met for finding in findings):
        code = EXIT_OUTSIDE
    return code


def _parts_of_both(job: Job, report: Report, findings: Sequence[ExpectedNumber]) -> Iterator[Part]:
    """What the terminal shows of a report, from the headline to the path of the page: verdict,
    effect of uncertain inputs, error budget, a third solver (None where none ran). With --verbose
    also notes, numbers that the scene expects (`findings`) and seconds of the stages; else what was
    left out. A `Sheet` is a table: title, heads, rows, and the columns that are flush right.
    """
    comparison = report.comparison
    verbose = job.options.verbose
    third_results = report.third
    yield from verdict_shown(report, verbose)
    yield from _inputs_shown(report.inputs, comparison.scene, comparison)
    if verbose:
        yield from _notes_shown(report)
    if report.budget is not None and (verbose or job.options.budget):
        yield from _budget_shown(report, report.budget)
    if third_results is not None:
        yield Sheet(
            "A third solver", third_results.heads, third_results.rows(comparison), (1, 2, 3)
        )
        yield from third_results.sentences
    if verbose:
        yield from _expected_shown(findings)
        times = [(stage, f"{seconds:.2f}") for stage, seconds in job.stages.seconds.items()]
        yield Sheet("Time", ("stage", "seconds"), times, (1,))
    else:
        yield from _topics_left_out(report, findings)
    yield str(_page_of(job))


def _page_of(job: Job) -> Path:
    """The path of the page of a job that compares both engines."""
    return job.folder / "report.html"


def _json_of_both(job: Job, report: Report) -> dict[str, Any]:
    """The object "result" of --json for `run`, from the content of the report: headline, table,
    verdict in full and in a few words, values of each metric, causes of the difference, effects of
    uncertain inputs, dissipation of the finite elements, expected numbers, fit of the profile,
    notes, seconds of each stage, path of the page.
    """
    from reports.comparison.words import verdict_in_few_words
    from reports.page.content import whole_content

    # that of comparison.json; "": its command, which is not used here
    report_content = whole_content(report, "", job.stages.seconds)
    solution_of_elements = report_content["result"]
    metrics: dict[str, Any] = {}
    for key, metric in report_content["metrics"].items():
        # _METRIC_KEYS: the entries of a metric that --json states
        metrics[key] = {name: metric[name] for name in _METRIC_KEYS}
    work_keys = ("dissipation", "dissipation_uncertainty", "dissipation_drift")
    last_keys = ("expected", "profile_fit", "notes", "seconds")
    return {
        "headline": report_content["headline"],
        "table": report_content["table"],
        **report_content["verdict"],
        "lead": verdict_in_few_words(report.comparison),
        "metrics": metrics,
        "why": report_content["why"],
        "inputs": report_content["inputs"],
        **{name: solution_of_elements[name] for name in work_keys},
        **{name: report_content[name] for name in last_keys},
        "page": str(_page_of(job)),
    }


def verdict_shown(report: Report, verbose: bool = True) -> Iterator[Part]:
    """What the terminal shows first of a comparison: headline, table of the values of both
    solutions, causes of the difference and verdict; in short forms unless `verbose` (the option
    --verbose). A pair is a text and its style on a terminal; a `Sheet` is a table: title, heads,
    rows, and the columns that are flush right. `comparison.why` is the difference of the
    dissipation split by causes, None where it was not split.
    """
    from reports.comparison.words import (
        cells_of_first_table,
        labels_judged_by_size,
        sentence_on_judging,
        sentences_on_missing_values,
        verdict_for_colour,
        verdict_in_few_words,
        verdict_in_sentences,
        verdict_in_short,
    )

    comparison = report.comparison
    scene = comparison.scene
    # rows without a value in both solutions are left out
    heads, rows = cells_of_first_table(
        comparison, "label" if verbose else "short", with_empty_rows=False
    )
    yield report.first_sentence, "bold"
    yield Sheet(scene.title or scene.name, heads, rows, (1, 2, 3))
    if metrics_without_value := sentences_on_missing_values(comparison):
        yield metrics_without_value
    if comparison.why is not None:
        yield comparison.why.sentence
    # _STYLES: verdict -> style on a terminal
    style = _STYLES.get(verdict_for_colour(comparison) or "", "")  # green, red or yellow
    long_verdict = f"{verdict_in_few_words(comparison)} {verdict_in_sentences(comparison)}".strip()
    yield long_verdict if verbose else verdict_in_short(comparison), style
    # Without --verbose the rule of judging is stated only where the size of a difference decides
    # alone, without its uncertainty.
    if verbose or labels_judged_by_size(comparison):
        rule_of_judging = sentence_on_judging(comparison, has_budget=report.budget is not None)
        if rule_of_judging:
            yield rule_of_judging


def _topics_left_out(report: Report, findings: Sequence[ExpectedNumber]) -> Iterator[Part]:
    """What a terminal without --verbose shows last: warnings about the table of measured loads, and
    a line that lists what is only on the page: the notes of the finite elements by their first
    words, and how many of the scene's expected numbers (`findings`) are met.
    """
    from reports.measured import check_record, record_in_words

    scene = report.comparison.scene
    topics = [f"“{_beginning(note)} …”" for note in report.comparison.result.record.notes]
    # noise of a measured table of loads, and W with and without it; None of other loads
    if check_of_table := check_record(scene):
        for sentence, is_warning in record_in_words(scene, check_of_table):
            if is_warning:
                yield f"Warning: {sentence}"
        topics.append("what was read of the record")
    n_missed = sum(not finding.is_met for finding in findings)
    if n_missed:
        topics.append(f"{n_missed} of {len(findings)} expected numbers missed")
    elif findings:
        topics.append(f"all {len(findings)} expected numbers met")
    if topics:
        yield f"On the page, and with --verbose: {', '.join(topics)}."


def _beginning(note: str) -> str:
    """The first words of a note.

    >>> _beginning("shakedown: revolution 3 repeats to 2e-04 of the largest nodal force")
    'shakedown'
    """
    return re.split(r": |, | \(", note, maxsplit=1)[0]


def _notes_shown(report: Report) -> Iterator[Part]:
    """What a terminal with --verbose shows: the uncertainty of the dissipation W, and the notes of
    the finite elements; of a table of measured loads what was read of it, and how much its
    reduction, threshold and noise change W.
    """
    from reports.comparison.words import sentence_on_work
    from reports.measured import check_record, record_in_words

    scene = report.comparison.scene
    if work_in_words := sentence_on_work(report.comparison):
        yield work_in_words
    for note in report.comparison.result.record.notes:
        yield f"Note: {note}."
    # noise of a measured table of loads, and W with and without it; None of other loads
    if check_of_table := check_record(scene):
        for sentence, is_warning in record_in_words(scene, check_of_table):
            yield f"{'Warning' if is_warning else 'Note'}: {sentence}"


def _budget_shown(report: Report, budget: ErrorBudget) -> Iterator[Part]:
    """What the terminal shows of the budget of errors: a table, and sentences on it.

    The table has a row for each metric and a column for each source of error (mesh, load steps,
    far field): what it contributes to the difference E of the result from theory. Then come the
    rest of E that no source explains, and its uncertainty u. E stands in the table above. An entry
    of `budget.budgets` is the budget of one metric. A `Sheet` is a table: title, heads, rows, and
    the columns that are flush right.
    """
    from reports.comparison.budget_words import budget_table, cost_in_words, negligible_terms

    negligible_sources = negligible_terms(budget)
    heads, rows, _ = budget_table(budget, (*negligible_sources, "E"))
    column_of_rest = heads.index("± u") - 1  # its head becomes "left"
    heads = (*heads[:column_of_rest], "left", *heads[column_of_rest + 1 :])
    title = "Where the difference comes from"
    if _are_per_cent(rows):
        title += ", per cent"
        rows = [tuple(cell.replace(" %", "") for cell in row) for row in rows]
    yield Sheet(title, heads, rows, range(1, len(heads) - 1))
    if budget.budgets[0].are_half_planes:
        yield "Left: half-planes have no idealisation error, so u must cover it."
    else:
        yield "Left: the idealisation error."
    if negligible_sources:
        names = ", ".join(negligible_sources)
        yield f"Below a thousandth of every difference, and not shown: {names}."
    yield f"Covered by the stated uncertainty: {report.coverage_in_words}"
    yield cost_in_words(budget)


def _are_per_cent(rows: Sequence[tuple[str, ...]]) -> bool:
    """Whether all amounts of a budget's rows, between name and verdict, are in per cent."""
    amounts = [cell for row in rows for cell in row[1:-1]]
    return all(cell.endswith((" %", "not measured", "none")) for cell in amounts)


def _expected_shown(findings: Sequence[ExpectedNumber]) -> Iterator[Part]:
    """What the terminal shows of the numbers that a scene expects (`findings`): a table with the
    values of the engines (a `Sheet`: title, heads, rows, columns that are flush right), and how
    many are met. Nothing where it expects none.
    """
    from reports.comparison.laws import EXPECTED_HEADS, expected_rows

    if findings:
        n_missed = sum(not finding.is_met for finding in findings)
        # EXPECTED_HEADS: heads of the columns
        yield Sheet("Expected numbers", EXPECTED_HEADS, expected_rows(findings), (2, 3, 4, 5))
        if n_missed:
            yield f"{n_missed} of {len(findings)} expected numbers are missed."
        else:
            yield f"All {len(findings)} expected numbers are met."


def exit_code(comparison: Comparison) -> int:
    """Exit code of a comparison: 0 if it passed, else 1.

    Two kinds of metrics are named on stderr: those that have a tolerance but no value (`unscored`),
    and those that are undecided, because their uncertainty reaches over the tolerance. A comparison
    is admissible where both solutions obey the laws of contact.
    """
    if comparison.unscored:
        keys = ", ".join(metric.key for metric in comparison.unscored)
        complain(
            f"halfplane: {comparison.scene.name}: not scored, though a tolerance judges it: {keys}:"
            f" exit code {EXIT_OUTSIDE} (--tolerance KEY=none leaves a metric out)"
        )
    if comparison.admissible and comparison.verdict == "undecided":
        keys = ", ".join(
            metric.key for metric in comparison.metrics if metric.verdict == "undecided"
        )
        complain(
            f"halfplane: {comparison.scene.name}: undecided: {keys}; this counts as outside: exit"
            f" code {EXIT_OUTSIDE}"
        )
    return EXIT_WITHIN if comparison.passed else EXIT_OUTSIDE


# --------------------------------------------------------------------------------- one engine alone
@solving_command
def exact(job: Job) -> Answer:
    """Half-plane theory alone, or corrected by what the bodies add: summary and files; outside
    where a law of contact or an expected number is violated.
    """
    load_engines(job.stages)
    if job.scene.load.is_driven:
        return _answer_of_one_engine(job, _solve_rig(job))
    if not job.options.corrected:
        return _answer_of_one_engine(job, _solve_half_plane(job))
    return _answer_of_one_engine(job, _solve_half_plane(job, effects=_effects_of_bodies(job)))


@solving_command
def fe(job: Job) -> Answer:
    """Finite elements alone: summary and files; outside where a law of contact or an expected
    number is violated.
    """
    load_engines(job.stages)
    return _answer_of_one_engine(job, solve_finite_elements(job))


_SOLUTION_KEYS = (
    "engine",
    "converged",
    "message",
    "notes",
    "dissipation",
    "dissipation_uncertainty",
    "uncertainties",
    "dissipation_drift",
    "loop_work",
    "load_cycles",
    "permanent_stick_half_width",
    "largest_half_width",
    "largest_pressure",
    "certificates",
    "counts",
    "bulk_work",
    "permanent_stick_left",
    "permanent_stick_right",
)


@dataclass(frozen=True)
class _EngineAnswer:
    """What one engine alone answers to a scene, with the checks of it.

    Attributes
    ----------
    solution
        its solution, with the notes of the command
    law_checks
        one check for each law of contact: the largest violation, and whether the law holds
    findings
        numbers that the scene expects, each with whether the solution meets it
    inputs
        what the uncertainties of the scene's inputs do to theory; None where none is stated
    file
        path of the file of the solution
    """

    solution: ContactSolution
    law_checks: tuple[Certificate, ...]
    findings: Sequence[ExpectedNumber]
    inputs: InputEffects | None
    file: str

    @property
    def is_admissible(self) -> bool:
        """Whether the run converged and every law of contact holds."""
        return self.solution.record.converged and all(check.holds for check in self.law_checks)

    @property
    def is_passed(self) -> bool:
        """Whether the solution is admissible and meets all numbers that the scene expects."""
        return self.is_admissible and all(finding.is_met for finding in self.findings)


def _answer_of_one_engine(
    job: Job, solution: ContactSolution, note: str = "", inputs: InputEffects | None = None
) -> Answer:
    """Save the solution of one engine and make the answer of its command: summary, JSON, exit code.

    `note` is added to the solution's notes. `inputs` is what the uncertainties of the scene's
    inputs do to theory; None: it is computed here. Exit code 0: the run converged, every law of
    contact holds, and all numbers that the scene expects are met. Else 1.
    """
    from reports.comparison.laws import certificates, expected_numbers

    if note:
        record = replace(solution.record, notes=(*solution.record.notes, note))
        solution = replace(solution, record=record)
    scene = solution.scene
    path = str(write_solution(solution, job.folder))
    findings = list(expected_numbers(scene, (solution,)))
    if inputs is None:
        inputs = _effects_of_inputs(job)
    engine_answer = _EngineAnswer(solution, certificates(solution), findings, inputs, path)
    return Answer(
        EXIT_WITHIN if engine_answer.is_passed else EXIT_OUTSIDE,
        _parts_of_one_engine(job, engine_answer),
        lambda: _json_of_one_engine(job, engine_answer),
        scene.name,
    )


def _parts_of_one_engine(job: Job, answer: _EngineAnswer) -> Iterator[Part]:
    """What the terminal shows of the answer of one engine: the summary of its solution, the effect
    of uncertain inputs, the fit of a measured profile, numbers that the scene expects, and the path
    of the file. A `Sheet` is a table: title, heads, rows.

    `answer` holds the solution, its checks, the expected numbers and the path of the file.
    """
    from reports import profile_fit
    from reports.comparison.words import summary_rows

    scene = answer.solution.scene
    rows = summary_rows(answer.solution, loads_are_found=job.scene.load.is_driven)
    yield Sheet(scene.title or scene.name, ("quantity", "value"), rows)
    yield from _inputs_shown(answer.inputs, job.scene)
    yield from profile_fit.findings_on_fit(scene)[0]
    yield from _expected_shown(answer.findings)
    yield answer.file


def _json_of_one_engine(job: Job, answer: _EngineAnswer) -> dict[str, Any]:
    """The object "result" of --json for one engine: whether the exit code is 0 (`passed`), whether
    the solution converged and obeys the laws of contact (`admissible`), values of the solution,
    numbers that the scene expects, effect of uncertain inputs, path of its file. Where the scene
    prescribes displacements, also the largest |Q|/(f P) of the loads that follow.

    `answer` holds the solution, its checks, the expected numbers and the path of the file.
    """
    from reports import profile_fit
    from reports.comparison.json_values import solution_content
    from reports.comparison.laws import expected_content, largest_load_ratio
    from reports.input_words import content as input_content

    values_of_rig = {}
    if job.scene.load.is_driven:
        values_of_rig["largest_sliding_ratio"] = largest_load_ratio(answer.solution)
    content_of_solution = solution_content(answer.solution, answer.law_checks)
    # _SOLUTION_KEYS: the values that --json states of a solution
    values_of_solution = {
        name: content_of_solution[name] for name in _SOLUTION_KEYS if name in content_of_solution
    }
    return {
        "passed": answer.is_passed,
        "admissible": answer.is_admissible,
        **values_of_solution,
        "expected": expected_content(answer.findings),
        "file": answer.file,
        "seconds": job.stages.seconds,
        "profile_fit": profile_fit.content(answer.solution.scene),
        "inputs": input_content(answer.inputs, job.scene),
        **values_of_rig,
    }


def _answer_of_rig(job: Job, refusals: EngineRefusals, no_comparison: str) -> Answer:
    """The answer of `run` to a scene that prescribes displacements (a rig), whose loads are found.

    Theory is solved and saved first, or finite elements where theory refuses the bodies. Then
    finite elements are solved beside theory, and the page of both is written.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.

    Parameters
    ----------
    refusals
        which of theory and finite elements take the scene; `refusal_of_theory` is the reason why
        theory does not, "" where it does
    no_comparison
        why the two are not compared, in a sentence
    """
    if refusals.refusal_of_theory:
        solution = solve_finite_elements(job)
        command_name = "fe"
    else:
        solution = _solve_rig(job)
        command_name = "exact"
    inputs = _effects_of_inputs(job)  # what the uncertainties of the inputs do to the values
    answer = _answer_of_one_engine(job, solution, no_comparison, inputs)
    # finite elements beside theory, and what JSON states of them
    solution_of_elements = None
    content_of_elements: dict[str, Any] = {}
    if not refusals.refusal_of_theory:
        solution_of_elements, content_of_elements = _elements_of_rig(job)
    with job.stages.stage("report"):
        from reports.page.rig import RigMotion, write

        # what rig and contact do, for the page
        rig_motion = RigMotion(job.scene, solution, inputs, solution_of_elements)
        refusal = content_of_elements.get("refused")
        remarks = (no_comparison, refusal) if refusal else (no_comparison,)
        page = write(rig_motion, job.folder, job.command("run"), remarks)

    def json_content() -> dict[str, Any]:
        """The object "result" of --json: that of one engine, of finite elements, and the page."""
        assert answer.content is not None  # for the type checker: an engine's answer has JSON
        further_content = {"finite_elements": content_of_elements} if content_of_elements else {}
        return {**answer.content(), **further_content, "page": str(page)}

    return replace(
        answer,
        code=answer.code if content_of_elements.get("admissible", True) else EXIT_OUTSIDE,
        parts=_parts_of_rig(answer, solution_of_elements, page),
        content=json_content,
        command=command_name,
    )


def _parts_of_rig(
    answer: Answer, solution_of_elements: ContactSolution | None, page: Path
) -> Iterator[Part]:
    """What the terminal shows of a rig: the `answer` of one engine, the summary of the finite
    elements' solution without its notes where they were solved beside theory (else None), and the
    path of the page.

    `page` is that path.
    """
    from reports.comparison.words import summary_rows

    yield from answer.parts
    if solution_of_elements is not None:
        rows = summary_rows(solution_of_elements, loads_are_found=True)
        rows = [row for row in rows if row[0] != "note"]
        # Sheet: title, heads, rows
        yield Sheet("the same by finite elements", ("quantity", "value"), rows)
    yield str(page)


def _elements_of_rig(job: Job) -> tuple[ContactSolution | None, dict[str, Any]]:
    """The finite elements' solution under prescribed displacements, which is saved in the job's
    folder, and what JSON states of it. Where they refuse the scene: None, and the refusal under the
    key "refused". A solution is admissible where it converged and every law of contact holds.
    """
    from reports.comparison.json_values import solution_content
    from reports.comparison.laws import certificates
    from scenes import InputError

    try:
        solution = solve_finite_elements(job)
    except InputError as reason:
        refusal = f"Finite elements do not take this scene: {reason}"
        # `complain` prints a line on stderr
        complain(f"halfplane: {job.scene.name}: {refusal}")
        return None, {"refused": refusal}
    path = write_solution(solution, job.folder, states_loads=False)
    law_checks = certificates(solution)
    content = solution_content(solution, law_checks)
    # _SOLUTION_KEYS: the values that --json states of a solution
    return solution, {
        "admissible": solution.record.converged and all(check.holds for check in law_checks),
        **{name: content[name] for name in _SOLUTION_KEYS if name in content},
        "file": str(path),
    }


# Fields of a solution with one value at each instant.
_COLUMNS_OF_INSTANTS = (
    "time",
    "normal_load",
    "tangential_load",
    "contact_half_width",
    "stick_half_width",
    "tangential_displacement",
    "normal_approach",
)


def write_solution(
    solution: ContactSolution, out: Path, name: str = "", *, states_loads: bool = True
) -> Path:
    """Save a solution in the folder `out`, and return the path of its NetCDF file.

    Beside the NetCDF file come the summary as JSON and a table of the instants as CSV, all three
    named `name`, by default after the engine. With `states_loads` the scene of the solution, with
    its loads, is written too, as scene.json.
    """
    from reports.charts.templating import table_text
    from reports.comparison.cycles import NAMES_OF_BULK_SERIES
    from reports.comparison.findings import FORMAT_OF_SOLUTION
    from reports.comparison.json_values import solution_content, strict_json_values
    from reports.comparison.laws import certificates
    from reports.folder import results_folder

    stem = name or solution.engine
    with results_folder(out, stale_prefixes=()) as folder:  # other files of the folder stay
        solution.save(folder / f"{stem}.nc")
        # FORMAT_OF_SOLUTION: name and version of the form of the file
        content = {
            "format": FORMAT_OF_SOLUTION,
            **solution_content(solution, certificates(solution)),
            "scene": solution.scene.model_dump(mode="json"),
        }
        summary = json.dumps(strict_json_values(content), allow_nan=False, indent=1) + "\n"
        (folder / f"{stem}.json").write_text(summary, encoding="utf-8")
        # loads, half-widths, displacements, ... at each instant, (n_instants,)
        columns = {key: getattr(solution, key) for key in _COLUMNS_OF_INSTANTS}
        columns["iterations"] = solution.record.iterations
        if solution.tilt is not None:  # bulk stress or tilt: the two edges of a zone differ
            # NAMES_OF_BULK_SERIES: bulk stresses, tilt and moments
            columns |= {key: getattr(solution, key) for key in NAMES_OF_BULK_SERIES}
            edges_of_zone = {"contact": solution.contact_edges, "stick": solution.stick_edges}
            for zone, edges in edges_of_zone.items():
                columns |= {f"{zone}_left": edges[:, 0], f"{zone}_right": edges[:, 1]}
        (folder / f"{stem}.csv").write_text(table_text(columns), encoding="utf-8")
        if states_loads:
            scene_text = solution.scene.model_dump_json(indent=1) + "\n"
            (folder / "scene.json").write_text(scene_text, encoding="utf-8")
    return out / f"{stem}.nc"
