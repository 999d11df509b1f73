"""The commands that solve one scene: both engines with their comparison, or one engine alone."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import (
    INTERRUPTED,
    NOT_CONVERGED,
    OUTSIDE,
    WITHIN,
    Answer,
    Options,
    requested_tolerances,
)
from reports.console import Part, Sheet, Stages, complain

# All else is heavy, and imported in the functions: `halfplane run --help` waits for nothing.
if TYPE_CHECKING:
    from reports.comparison import Comparison, Report
    from reports.comparison.laws import Finding
    from scenes import ContactSolution, Scene

_STYLES = {"within": "bold green", "outside": "bold red", "undecided": "bold yellow"}


# -------------------------------------------------------------- what every command that solves does
def read(source: str) -> Scene:
    """The scene of `source`, its load path checked; InputError in a sentence otherwise."""
    from reports.checking import require_admissible
    from scenes import load_scene

    scene = load_scene(source)
    require_admissible(scene, source)
    return scene


@dataclass(frozen=True)
class Job:
    """What a command that solves is about: its scene, as the user named it and as it was read,
    options, folder and stages.
    """

    source: str
    scene: Scene
    options: Options
    folder: Path
    stages: Stages

    def command(self, name: str) -> str:
        """The command line that repeats this."""
        return self.options.command(name, self.source, self.folder)


def at_work(work: Callable[[Job], Answer]) -> Callable[[str, Options], Answer]:
    """A command that reads a scene, claims a folder and does its work; what was solved before a
    failure is kept there.

    A file of somebody else in the folder is refused before anything is solved: `_written_by` knows
    what the command will write.
    """

    @wraps(work)
    def command(scene: str, options: Options) -> Answer:
        from reports.comparison.words import summary_rows
        from reports.folder import claim, default_folder
        from scenes import ConvergenceError, InputError, Interrupted

        source, stages, found = scene, Stages(options.quiet), read(scene)
        folder = options.out or default_folder(found.name)
        folder = claim(folder, _written_by(work.__name__, found))
        try:
            return work(Job(source, found, options, folder, stages))
        except InputError as fault:
            # One about an option or the file names that already, one of an engine does not.
            if str(fault).startswith((source, "--")):
                raise
            named = InputError(f"{source}: {fault}")
            for note in getattr(fault, "__notes__", ()):  # of what was saved
                named.add_note(note)
            raise named from fault
        except Interrupted as stop:
            solved = stop.partial
            if solved is None or len(solved.time) < 2:
                raise KeyboardInterrupt from stop
            path = write_solution(solved, folder, name="" if solved.record.converged else "partial")
            complain(
                f"halfplane: {stop}; what was solved is kept in {path} ({len(solved.time) - 1}"
                " steps)"
            )
            return Answer(INTERRUPTED)
        except ConvergenceError as failure:
            complain(f"halfplane: {found.name}: not converged: {failure}")
            sentence, shown, file = str(failure), list[Part](), None
            if failure.partial is not None:
                file = str(write_solution(failure.partial, folder, name="partial"))
                shown = [
                    Sheet(
                        "Steps solved before it failed",
                        ("quantity", "value"),
                        summary_rows(failure.partial),
                    ),
                    file,
                ]
            elif not options.json:
                complain("halfplane: no step was solved, so nothing was written")
            return Answer(
                NOT_CONVERGED,
                shown,
                lambda: {"passed": False, "error": sentence, "file": file},
                found.name,
            )

    return command


def _written_by(command: str, scene: Scene) -> tuple[str, ...]:
    """Files that a command writes to its folder, whatever comes of it; what failed or was
    interrupted leaves "partial".
    """
    from reports.folder import RESULTS, files_of_a_solution

    partial = files_of_a_solution("partial")
    if command == "exact":
        return (*files_of_a_solution("semi_analytic"), *partial)
    if command == "fe":
        return (*files_of_a_solution("halfplane_fe"), *partial)
    if command == "export":
        return (deck_file(scene),)
    if command == "run":  # of a scene that one engine alone takes, the answer of that one
        return (
            *RESULTS,
            *files_of_a_solution("semi_analytic"),
            *files_of_a_solution("halfplane_fe"),
            *partial,
        )
    return (*RESULTS, *partial)


def deck_file(scene: Scene) -> str:
    """Name of the deck that `export` writes."""
    from reports.folder import default_folder

    return f"{default_folder(scene.name).name}_calculix.inp"


def load_engines(stages: Stages) -> None:
    """Import the engines as a stage of its own; InputError where a library can't be loaded."""
    from scenes import InputError

    with stages.stage("loading"):
        try:
            from meshes.interrupts import interrupts_wait

            with interrupts_wait():  # compiled modules make an ImportError of it
                import_module("halfplane_fe")
                import_module("semi_analytic")
        except (ImportError, OSError) as reason:
            raise InputError(
                f"the engines can't be loaded: {reason}; `halfplane doctor` says what is missing"
            ) from reason


def require_drawing(stages: Stages) -> None:
    """InputError where nothing can be drawn: found in a process of its own, for some libraries
    bring theirs down.
    """
    from reports.cli.machine import drawing
    from scenes import InputError

    with stages.stage("can pictures be drawn?"):
        good, found = drawing()
    if not good:
        raise InputError(f"pictures can't be drawn here: {found}; --no-pictures leaves them out")


def require_times(words: Iterable[str], option: str, scene: Scene) -> None:
    """InputError for a word that is neither a time of the path nor "events", before anything is
    solved.
    """
    from reports.field_output.files import instant_of

    segments = list(scene.load.path().legs(scene.cycles)) if words else []
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
    """The half-plane answer, at the x and time of `where` if it has them."""
    import semi_analytic

    with job.stages.stage("half-plane theory"):
        return semi_analytic.solve(job.scene, **where)


# Rows of a record above which the uncertainty of real bodies is measured on request only: every row
# is an increment of each of two coarser meshes too.
_LONG_RECORD = 200


def _reason_for_no_budget(scene: Scene) -> str:
    """Why the uncertainty of real bodies is measured on request only; empty where it is measured
    anyway.
    """
    from scenes import TimeSeriesLoad

    rows = len(scene.load.kept_rows()) if isinstance(scene.load, TimeSeriesLoad) else 0
    if rows <= _LONG_RECORD:
        return ""
    return (
        f"no uncertainty was measured: the record has {rows:,} rows, more than {_LONG_RECORD};"
        " --budget measures it"
    )


# ------------------------------------------------------------------------------------- both engines
@at_work
def run(job: Job) -> Answer:
    """Both engines on one scene, their comparison, its page; the exit code is that of the verdict.

    A scene that one engine alone takes gets that one's answer, as of `exact` or `fe`.
    """
    from reports.checking import engines_for
    from scenes import InputError

    options, scene, source = job.options, job.scene, job.source
    tolerances = requested_tolerances(options.tolerance)
    require_times(options.vtu, "--vtu", scene)
    require_times(options.stress, "--stress", scene)
    if options.stress:
        require_drawing(job.stages)
    load_engines(job.stages)
    taken = engines_for(scene, source)  # what theory refuses, before the finite elements are solved
    options.settings()
    if alone := taken.in_words(source):
        for name in ("tolerance", "budget", "vtu", "stress", "third"):
            if getattr(options, name):
                raise InputError(
                    f"{source}: --{name} goes with a comparison of both engines: leave it out."
                    f" {alone}"
                )
        complain(f"halfplane: {scene.name}: no comparison. {alone}")
        solve, name = (
            (solve_finite_elements, "fe") if taken.half_plane else (_solve_half_plane, "exact")
        )
        return replace(_answer_alone(job, solve(job), alone), command=name)
    if options.third:
        _third_solver(options.third).require()
    return _answer_of_both(_compared(job, tolerances), job.folder / "report.html", job.stages)


# Third solvers by the name that --third takes: modules of studies, loaded when they are asked for.
_THIRD_SOLVERS = {"calculix": "reports.studies.third.commands"}


def _third_solver(name: str) -> Any:
    """The module of a third solver: `require()` refuses where its program is missing, `answer(job,
    result)` runs it.
    """
    return import_module(_THIRD_SOLVERS[name])


def _compared(job: Job, tolerances: dict[str, float]) -> Report:
    """Solve by both engines, compare, measure the uncertainties and ask the third solver as asked,
    and write the page.
    """
    from reports.comparison.budget import climb, error_budget, theory_on_steps, with_budget
    from reports.comparison.pairs import are_half_planes

    scene, options, stages, command = job.scene, job.options, job.stages, job.command("run")
    # Of real bodies theory is wrong by some amount, which is worth its uncertainty: two coarser
    # meshes measure that.
    measured, left_out = bool(options.budget), ""
    if options.budget is None and not are_half_planes(scene):
        left_out = _reason_for_no_budget(scene)
        measured = not left_out
    if left_out:
        stages.remark(left_out)
    begun = time.process_time()
    result = solve_finite_elements(job)
    with _kept_if_interrupted(result):
        with _saved_if_it_fails(result, job.folder):
            reference = _solve_half_plane(job, x=result.x, time=result.time)
            # Of a thinned answer the steps are those of the path itself.
            polygon: ContactSolution | None = reference
            if not result.thinned:
                with stages.stage("half-plane theory, on the polygon of the steps"):
                    polygon = theory_on_steps(result)
            with stages.stage("comparison"):
                from reports.comparison import Report, compare

                found = compare(reference, result, polygon_reference=polygon, tolerances=tolerances)
                report = Report(
                    replace(found, notes=(*found.notes, f"{left_out[:1].upper()}{left_out[1:]}."))
                    if left_out
                    else found
                )
            if measured:
                plain = time.process_time() - begun
                # Every run is a stage of its own.
                refinements = climb(
                    found, *options.settings(), stages.stage, 3 if options.budget else 2
                )
                report = with_budget(
                    report.comparison, error_budget(report.comparison, refinements, plain)
                )
            if options.third:
                report = replace(report, third=_third_solver(options.third).answer(job, result))
        with stages.stage("report"):
            from reports.field_output.files import instants_of
            from reports.page.writing import write

            write(
                report,
                job.folder,
                vtu_instants=[
                    instant.time for instant in instants_of(options.vtu, result, "--vtu")
                ],
                command=command,
                seconds=dict(stages.seconds),
                stress_instants=instants_of(options.stress, result, "--stress"),
                log=(f"{time.strftime('%Y-%m-%d %H:%M:%S %z')}  {command}", *stages.log),
            )
    return report


@contextmanager
def _kept_if_interrupted(result: ContactSolution) -> Generator[None, None, None]:
    """Ctrl-C after the finite elements are solved hands on what they found, but where the whole
    report was written already.
    """
    from reports.folder import FilledBefore
    from scenes import Interrupted

    try:
        yield
    except FilledBefore:
        raise
    except KeyboardInterrupt as stop:
        raise Interrupted("interrupted after the finite elements were solved", result) from stop


@contextmanager
def _saved_if_it_fails(result: ContactSolution, folder: Path) -> Generator[None, None, None]:
    """After a fault between the finite elements and the report their answer is saved, and a note of
    the fault names its file.
    """
    try:
        yield
    except Exception as fault:
        with suppress(Exception):  # the fault itself is what has to be said
            fault.add_note(
                f"the finite elements' answer is saved: {write_solution(result, folder)}"
            )
        raise


_OF_A_METRIC = ("value", "uncertainty", "unit", "tolerance", "accurate", "verdict", "honest")


def _answer_of_both(report: Report, page: Path, stages: Stages) -> Answer:
    """The verdict; the exit code, whose reason is the last line on stderr."""
    from reports.comparison import laws
    from reports.comparison.words import lead, whole_content

    comparison, third = report.comparison, report.third
    scene = comparison.scene
    findings = list(laws.expected_numbers(scene, (comparison.reference, comparison.result)))
    if third is not None and third.failure:
        complain(f"halfplane: {scene.name}: {third.failure}")
        code = NOT_CONVERGED
    else:
        code = max(
            exit_code(comparison), WITHIN if all(finding.met for finding in findings) else OUTSIDE
        )

    def shown() -> Iterator[Part]:
        yield from verdict_shown(report)
        yield from _uncertainty_shown(report)
        if third is not None:
            yield Sheet("A third solver", third.heads, third.rows(comparison), (1, 2, 3))
            yield from third.sentences
        yield from _expected_shown(findings)
        yield Sheet(
            "Time",
            ("stage", "seconds"),
            [(name, f"{t:.2f}") for name, t in stages.seconds.items()],
            (1,),
        )
        yield str(page)

    def result() -> dict[str, Any]:
        whole = whole_content(report, "", stages.seconds)
        return {
            **{name: whole[name] for name in ("headline", "table")},
            **whole["verdict"],
            "lead": lead(report),
            "metrics": {
                key: {name: metric[name] for name in _OF_A_METRIC}
                for key, metric in whole["metrics"].items()
            },
            **{
                name: whole["result"][name]
                for name in ("dissipation", "dissipation_uncertainty", "dissipation_drift")
            },
            **{name: whole[name] for name in ("expected", "profile_fit", "notes", "seconds")},
            "page": str(page),
        }

    return Answer(code, shown(), result, scene.name)


def verdict_shown(report: Report) -> Iterator[Part]:
    """The headline, the table of absolute values, and the verdict in a sentence."""
    from reports.comparison.words import first_cells, headline, how_judged, lead, standing, verdict

    scene = report.comparison.scene
    heads, rows = first_cells(report)
    yield headline(report), "bold"
    yield Sheet(scene.title or scene.name, heads, rows, (1, 2, 3))
    yield (
        f"{lead(report)} {verdict(report)}".strip(),
        _STYLES.get(standing(report.comparison) or "", ""),
    )
    if words := how_judged(report):
        yield words


def _uncertainty_shown(report: Report) -> Iterator[Part]:
    """What the dissipation is uncertain by, what the finite elements note, and where the errors
    come from if that was measured.
    """
    from reports.comparison.words import budget_table, cost, uncertain_work
    from reports.measured import check_record, record_in_words

    scene, budget = report.comparison.scene, report.budget
    if words := uncertain_work(report.comparison):
        yield words
    yield from (f"Note: {note}." for note in report.comparison.result.record.notes)
    if record := check_record(scene):
        yield from (
            f"{'Warning' if warning else 'Note'}: {said}"
            for said, warning in record_in_words(scene, record)
        )
    if budget is not None:
        # Without what is nothing but bounds of rounding in nearly every run.
        heads, rows, _ = budget_table(budget, without=("solver", "half-plane theory"))
        yield Sheet("Where the difference comes from", heads, rows, range(1, len(heads) - 1))
        yield f"Covered by the stated uncertainty: {report.honest}"
        yield cost(budget)


def _expected_shown(findings: Sequence[Finding]) -> Iterator[Part]:
    """The numbers that the scene expects beside those found."""
    from reports.comparison.laws import EXPECTED_HEADS, expected_rows

    if findings:
        yield Sheet("Expected numbers", EXPECTED_HEADS, expected_rows(findings), (2, 3, 4, 5))
        missed, of = sum(not finding.met for finding in findings), len(findings)
        yield (
            f"{missed} of {of} expected numbers are missed."
            if missed
            else f"All {of} expected numbers are met."
        )


def exit_code(comparison: Comparison) -> int:
    """0 if the comparison passed, else 1; where that is for undecided or unscored metrics, the last
    lines on stderr say so.
    """
    if comparison.unscored:
        keys = ", ".join(metric.key for metric in comparison.unscored)
        complain(
            f"halfplane: {comparison.scene.name}: not scored, though a tolerance judges it: {keys}:"
            f" exit code {OUTSIDE} (--tolerance KEY=none leaves a metric out)"
        )
    if comparison.admissible and comparison.verdict == "undecided":
        keys = ", ".join(
            metric.key for metric in comparison.metrics if metric.verdict == "undecided"
        )
        complain(
            f"halfplane: {comparison.scene.name}: undecided: {keys}; this counts as outside: exit"
            f" code {OUTSIDE}"
        )
    return WITHIN if comparison.passed else OUTSIDE


# --------------------------------------------------------------------------------- one engine alone
@at_work
def exact(job: Job) -> Answer:
    """Half-plane theory alone: summary and files; outside where a law of contact or an expected
    number is violated.
    """
    load_engines(job.stages)
    return _answer_alone(job, _solve_half_plane(job))


@at_work
def fe(job: Job) -> Answer:
    """Finite elements alone: summary and files; outside where a law of contact or an expected
    number is violated.
    """
    load_engines(job.stages)
    return _answer_alone(job, solve_finite_elements(job))


_OF_ONE_ENGINE = (
    *(
        "engine",
        "converged",
        "message",
        "notes",
        "dissipation",
        "dissipation_uncertainty",
        "dissipation_drift",
    ),
    *(
        "loop_work",
        "load_cycles",
        "permanent_stick_half_width",
        "largest_half_width",
        "largest_pressure",
        "certificates",
        "counts",
    ),
    *("bulk_work", "permanent_stick_left", "permanent_stick_right"),
)


def _answer_alone(job: Job, solution: ContactSolution, note: str = "") -> Answer:
    """Files and summary of one engine's answer; `note` is kept with the answer."""
    from reports import profile_fit
    from reports.comparison.laws import certificates, expected_content, expected_numbers
    from reports.comparison.words import solution_content, summary_rows

    if note:
        solution = replace(
            solution, record=replace(solution.record, notes=(*solution.record.notes, note))
        )
    scene, path = solution.scene, str(write_solution(solution, job.folder))
    findings, checks = list(expected_numbers(scene, (solution,))), certificates(solution)
    admissible = solution.record.converged and all(check.holds for check in checks)
    code = WITHIN if admissible and all(finding.met for finding in findings) else OUTSIDE

    def shown() -> Iterator[Part]:
        yield Sheet(scene.title or scene.name, ("quantity", "value"), summary_rows(solution))
        yield from profile_fit.findings(scene)[0]
        yield from _expected_shown(findings)
        yield path

    def result() -> dict[str, Any]:
        whole = solution_content(solution, checks)
        content = {
            "passed": code == WITHIN,
            "admissible": admissible,
            **{k: whole[k] for k in _OF_ONE_ENGINE if k in whole},
        }
        content |= {
            "expected": expected_content(findings),
            "file": path,
            "seconds": job.stages.seconds,
        }
        return content | {"profile_fit": profile_fit.content(scene)}

    return Answer(code, shown(), result, scene.name)


_INSTANTS = (
    *("time", "normal_load", "tangential_load", "contact_half_width", "stick_half_width"),
    *("tangential_displacement", "normal_approach"),
)


def write_solution(solution: ContactSolution, out: Path, name: str = "") -> Path:
    """NetCDF, the summary as JSON, a CSV of the instants and the scene; returns the path of the
    NetCDF file.
    """
    from reports.charts.templating import table_text
    from reports.comparison.cycles import OF_BULK
    from reports.comparison.findings import SOLUTION
    from reports.comparison.laws import certificates
    from reports.comparison.words import solution_content, strict
    from reports.folder import filled

    stem = name or solution.engine
    with filled(out, fresh=()) as folder:
        solution.save(folder / f"{stem}.nc")
        content = {
            "format": SOLUTION,
            **solution_content(solution, certificates(solution)),
            "scene": solution.scene.model_dump(mode="json"),
        }
        (folder / f"{stem}.json").write_text(
            json.dumps(strict(content), allow_nan=False, indent=1) + "\n", encoding="utf-8"
        )
        columns = {name: getattr(solution, name) for name in _INSTANTS} | {
            "iterations": solution.record.iterations
        }
        if solution.tilt is not None:
            columns |= {name: getattr(solution, name) for name in OF_BULK}
            for kind, edges in (
                ("contact", solution.contact_edges),
                ("stick", solution.stick_edges),
            ):
                columns |= {f"{kind}_left": edges[:, 0], f"{kind}_right": edges[:, 1]}
        (folder / f"{stem}.csv").write_text(table_text(columns), encoding="utf-8")
        (folder / "scene.json").write_text(
            solution.scene.model_dump_json(indent=1) + "\n", encoding="utf-8"
        )
    return out / f"{stem}.nc"
