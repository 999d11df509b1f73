"""What the commands that solve do, once their options are read: solve, write, show, and choose the exit code."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from reports import jobs
from reports.application import INTERRUPTED, NOT_CONVERGED, OUTSIDE, WITHIN
from reports.console import Stages, complain, say, show_table
from reports.folder import claim, default_folder
from reports.largest_contact import largest_contact
from reports.options import FiniteElementOptions
from reports.series import Wish, check_series
from reports.tables import exit_code, show_budget, show_expected, show_fields, show_notes, show_third, show_verdict
from scenes import ContactSolution, ConvergenceError, InputError, Interrupted, Scene

if TYPE_CHECKING:
    from reports.paper.page import PaperReport


def run(
    source: str,
    out: Path | None,
    vtu: tuple[str, ...],
    quiet: bool,
    options: FiniteElementOptions,
    *,
    budget: bool = False,
    third_limit: float | None = None,
    stress: tuple[str, ...] = (),
    pdf: bool = False,
    coarse_mesh: bool = True,
    as_json: bool = False,
) -> int:
    """Both engines, the verdict, the page; with `budget`, where the errors come from."""
    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    _times(vtu, "--vtu", scene)
    _times(stress, "--stress", scene)
    if stress:
        _can_draw(stages)
    jobs.load_engines(stages)
    largest_contact(scene, source)  # what theory refuses, before the finite elements are solved
    options.settings()
    third = () if third_limit is None else ("--third", "calculix", "--third-limit", f"{third_limit:g}")
    asked = (("--vtu", *vtu) if vtu else (), ("--stress", *stress) if stress else (), ("--pdf",) if pdf else ())
    more = (*asked, ("--budget",) if budget else (), () if coarse_mesh else ("--no-coarse-mesh",), third)
    command = options.command("run", source, folder, *more)
    try:
        with jobs.naming(source):
            report = jobs.run(
                scene,
                folder,
                options,
                stages,
                vtu=vtu,
                budget=budget,
                command=command,
                third_limit=third_limit,
                stress=stress,
                pdf=pdf,
                coarse_mesh=coarse_mesh,
            )
    except Interrupted as stop:
        return _interrupted(stop, folder)
    except ConvergenceError as failure:
        return _not_converged(failure, scene, folder, as_json)
    if as_json:
        return _say_json(report)
    show_verdict(report.found)
    show_notes(report.comparison)
    show_budget(report.found)
    show_third(report)
    met = show_expected(scene, (report.comparison.reference, report.comparison.result))
    show_table("Time", ("stage", "seconds"), [(name, f"{t:.2f}") for name, t in report.seconds.items()], right=(1,))
    say(str(report.page))
    return _outcome(report, met=met)


def _outcome(report: jobs.Report, *, met: bool) -> int:
    """The exit code of a run; a third opinion that failed, and a verdict that is left open, are said on the last line."""
    if report.third is not None and report.third.failure:
        complain(f"halfplane: {report.comparison.scene.name}: {report.third.failure}")
        return NOT_CONVERGED
    code = exit_code(report.comparison)
    return code if met else OUTSIDE


def _say_json(report: jobs.Report) -> int:
    """The verdict for programs, alone on stdout."""
    from reports import expected
    from reports.machine import verdict_json

    comparison = report.comparison
    findings = list(expected.check(comparison.scene, (comparison.reference, comparison.result)))
    code = _outcome(report, met=all(finding.met for finding in findings))
    say(verdict_json(report, findings, code))
    return code


def exact(source: str, out: Path | None, quiet: bool, as_json: bool = False) -> int:
    """Half-plane theory alone."""
    return _alone(source, out, quiet, as_json, jobs.solve_half_plane)


def fe(
    source: str, out: Path | None, quiet: bool, options: FiniteElementOptions, as_json: bool = False, *, coarse_mesh: bool = True
) -> int:
    """Finite elements alone."""
    return _alone(
        source,
        out,
        quiet,
        as_json,
        lambda scene, stages: jobs.solve_finite_elements(scene, options, stages, coarse_mesh=coarse_mesh),
    )


def fields(source: str, wish: Wish, out: Path | None, quiet: bool, options: FiniteElementOptions, as_json: bool = False) -> int:
    """Finite elements, and both bodies at chosen instants or over the cycle: for ParaView, as pictures, as a film."""
    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    _times(wish.named, "--at", scene)
    check_series(wish.every, wish.frames)
    if wish.pictures and wish.named:
        _can_draw(stages)
    jobs.load_engines(stages)
    command = options.command("fields", source, folder, *wish.words())
    try:
        with jobs.naming(source):
            from reports import fields_job

            solution = jobs.solve_finite_elements(scene, options, stages)
            report = fields_job.fields(solution, folder, wish, stages, command=command)
    except Interrupted as stop:
        return _interrupted(stop, folder)
    except ConvergenceError as failure:
        return _not_converged(failure, scene, folder, as_json)
    file = folder / "fields" / "fields.pvd"
    if as_json:
        from reports.machine import fields_json

        say(fields_json(scene, report, file))
        return WITHIN
    show_fields(scene, report)
    say(str(file))
    return WITHIN


def _times(words: tuple[str, ...], option: str, scene: Scene) -> None:
    """InputError for a word that is neither a time of the path nor "events", before anything is solved."""
    if not words:
        return
    from reports.fields import instant_of

    legs = list(scene.load.path().legs(scene.cycles))
    for word in words:
        if word != "events":
            instant_of(word, option, float(legs[0].start), float(legs[-1].end))


def _can_draw(stages: Stages) -> None:
    """InputError where nothing can be drawn: found in a process of its own, for some libraries bring theirs down."""
    from reports.doctor import drawing

    with stages.stage("can pictures be drawn?"):
        finding = drawing()
    if not finding.good:
        raise InputError(f"pictures can't be drawn here: {finding.found}; --no-pictures leaves them out")


def _alone(source: str, out: Path | None, quiet: bool, as_json: bool, solve: Callable[[Scene, Stages], ContactSolution]) -> int:
    from reports.single import is_admissible, summary_rows, write_solution

    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    jobs.load_engines(stages)
    try:
        with jobs.naming(source):
            solution = solve(scene, stages)
    except Interrupted as stop:
        return _interrupted(stop, folder)
    except ConvergenceError as failure:
        return _not_converged(failure, scene, folder, as_json)
    path = write_solution(solution, folder)
    if as_json:
        return _say_solution(solution, path, stages)
    show_table(scene.title or scene.name, ("quantity", "value"), summary_rows(solution))
    met = show_expected(scene, (solution,))
    say(str(path))
    return WITHIN if is_admissible(solution) and met else OUTSIDE


def _say_solution(solution: ContactSolution, path: Path, stages: Stages) -> int:
    """One engine's answer for programs, alone on stdout."""
    from reports import expected
    from reports.machine import solution_json
    from reports.single import is_admissible

    findings = list(expected.check(solution.scene, (solution,)))
    code = WITHIN if is_admissible(solution) and all(finding.met for finding in findings) else OUTSIDE
    say(solution_json(solution, findings, path, stages.seconds, code))
    return code


def _interrupted(stop: Interrupted, folder: Path) -> int:
    """Keep what was solved until Ctrl-C, and say what that is."""
    from reports.single import write_solution

    solved = stop.partial
    if solved is None or len(solved.time) < 2:
        raise KeyboardInterrupt from stop
    path = write_solution(solved, folder, name="" if solved.record.converged else "partial")
    complain(f"halfplane: {stop}; what was solved is kept in {path} ({len(solved.time) - 1} steps)")
    return INTERRUPTED


def _not_converged(failure: ConvergenceError, scene: Scene, folder: Path, as_json: bool = False) -> int:
    """Show the record, keep the steps solved so far."""
    from reports.single import summary_rows, write_solution

    if as_json:
        from reports.machine import failure_json

        kept = None if failure.partial is None else write_solution(failure.partial, folder, name="partial")
        say(failure_json(scene.name, str(failure), NOT_CONVERGED, kept))
        return NOT_CONVERGED
    complain(f"halfplane: {scene.name}: not converged: {failure}")
    if failure.partial is None:
        complain("halfplane: no step was solved, so nothing was written")
        return NOT_CONVERGED
    path = write_solution(failure.partial, folder, name="partial")
    show_table("Steps solved before it failed", ("quantity", "value"), summary_rows(failure.partial))
    say(str(path))
    return NOT_CONVERGED


def paper(out: Path | None, quiet: bool, as_json: bool = False) -> int:
    """The paper's figures and both tables; outside if a misprint is not proven."""
    stages = Stages(quiet)
    folder = claim(out or default_folder("paper"))
    with stages.stage("loading"):
        from reports.paper import page
    command = shlex.join(["halfplane", "paper", "--out", str(folder)])
    report = page.write(folder, stages, command)
    code = WITHIN if report.proven else OUTSIDE
    if as_json:
        from reports.machine import paper_json

        say(paper_json(report, code, stages.seconds))
    else:
        _show_paper(report)
    return code


def _show_paper(report: PaperReport) -> None:
    """Both tables, and how many of each verdict."""
    from reports.paper.page import tally
    from reports.paper.tables import proven_in_words

    show_table(
        "What the paper states in words",
        ("statement", "where", "the paper", "computed", "verdict"),
        [(row.key, row.where, row.words, row.computed, row.verdict.value) for row in report.statements],
    )
    show_table(
        "Misprints of the paper",
        ("where", "printed", "right", "proof", "proven"),
        [(row.key, row.printed, row.right, row.proof, proven_in_words(row)) for row in report.misprints],
    )
    counts = ", ".join(f"{count} {verdict}" for verdict, count in tally(report.statements).items())
    proven = sum(row.proven is True for row in report.misprints)
    say(f"{len(report.statements)} statements: {counts}; {len(report.misprints)} misprints: {proven} proven by evaluation")
    say(str(report.page))
