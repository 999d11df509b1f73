"""What each command does, once its options are read: solve, write, show, and choose the exit code."""

from __future__ import annotations

import json
import re
import shlex
import sys
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from reports import checking, jobs
from reports.application import NOT_CONVERGED, OUTSIDE, WITHIN
from reports.console import Stages, complain, say, show_table
from reports.folder import claim, default_folder
from reports.options import FiniteElementOptions
from scenes import (
    ContactSolution,
    ConvergenceError,
    InputError,
    Scene,
    scene_companions,
    scene_schema,
    scene_text,
)

if TYPE_CHECKING:
    from reports.comparison import Comparison


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
    options.settings()
    third = () if third_limit is None else ("--third", "calculix", "--third-limit", f"{third_limit:g}")
    asked = (("--vtu", *vtu) if vtu else (), ("--stress", *stress) if stress else (), ("--pdf",) if pdf else ())
    more = (*asked, ("--budget",) if budget else (), third)
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
            )
    except ConvergenceError as failure:
        if as_json:
            from reports.machine import failure_json

            say(failure_json(scene.name, str(failure), NOT_CONVERGED))
            return NOT_CONVERGED
        return _not_converged(failure, scene, folder)
    if as_json:
        return _say_json(report)
    _show_verdict(report.comparison)
    _show_budget(report.comparison)
    _show_third(report)
    met = _show_expected(scene, (report.comparison.reference, report.comparison.result))
    show_table("Time", ("stage", "seconds"), [(name, f"{t:.2f}") for name, t in report.seconds.items()], right=(1,))
    say(str(report.page))
    return _outcome(report, met=met)


def _outcome(report: jobs.Report, *, met: bool) -> int:
    """The exit code of a run; a third opinion that failed is told."""
    if report.third is not None and report.third.failure:
        complain(f"halfplane: {report.comparison.scene.name}: {report.third.failure}")
        return NOT_CONVERGED
    return WITHIN if report.comparison.passed and met else OUTSIDE


def _say_json(report: jobs.Report) -> int:
    """The verdict for programs, alone on stdout."""
    from reports import expected
    from reports.machine import verdict_json

    comparison = report.comparison
    findings = list(expected.check(comparison.scene, (comparison.reference, comparison.result)))
    code = _outcome(report, met=all(finding.met for finding in findings))
    say(verdict_json(report, findings, code))
    return code


def exact(source: str, out: Path | None, quiet: bool) -> int:
    """Half-plane theory alone."""
    return _alone(source, out, quiet, jobs.solve_half_plane)


def fe(source: str, out: Path | None, quiet: bool, options: FiniteElementOptions) -> int:
    """Finite elements alone."""
    return _alone(source, out, quiet, lambda scene, stages: jobs.solve_finite_elements(scene, options, stages))


def fields(source: str, at: tuple[str, ...], out: Path | None, pictures: bool, quiet: bool, options: FiniteElementOptions) -> int:
    """Finite elements, and both bodies at chosen instants for ParaView and as pictures."""
    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    at = at or ("events",)
    _times(at, "--at", scene)
    if pictures:
        _can_draw(stages)
    jobs.load_engines(stages)
    command = options.command("fields", source, folder, ("--at", *at), () if pictures else ("--no-pictures",))
    try:
        with jobs.naming(source):
            solution = jobs.solve_finite_elements(scene, options, stages)
            report = jobs.fields(solution, folder, at, stages, pictures=pictures, command=command)
    except ConvergenceError as failure:
        return _not_converged(failure, scene, folder)
    _show_fields(scene, report)
    say(str(folder / "fields" / "fields.pvd"))
    return WITHIN


def _times(words: tuple[str, ...], option: str, scene: Scene) -> None:
    """InputError for a word that is neither a time of the path nor "events", before anything is solved."""
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


def _show_fields(scene: Scene, report: jobs.FieldsReport) -> None:
    """The instants with their largest stress, and what was written."""
    from reports.fields import peak
    from reports.units import load_unit, number, units

    _, length, stress = units(scene)
    rows = []
    for instant, snapshot in report.instants:
        most = peak(snapshot)
        values = (snapshot.time, snapshot.normal_load, snapshot.tangential_load, most.value)
        place = f"{most.body} ({most.place[0]:.3g}, {most.place[1]:.3g})"
        rows.append((instant.label, *map(number, values), place))
    load = load_unit(scene)
    heads = ("instant", "time", f"P [{load}]", f"Q [{load}]", f"largest von Mises [{stress}]", f"where (x, y) [{length}]")
    show_table(scene.title or scene.name, heads, rows, right=(1, 2, 3, 4))
    counts = {kind: sum(name.endswith(kind) for name in report.files) for kind in (".vtu", ".png")}
    say(f"written: {counts['.vtu']} VTU files, {counts['.png']} pictures, and what they are in fields/fields.json")


def _alone(source: str, out: Path | None, quiet: bool, solve: Callable[[Scene, Stages], ContactSolution]) -> int:
    from reports.single import is_admissible, summary_rows, write_solution

    stages = Stages(quiet)
    scene = jobs.read(source)
    folder = claim(out or default_folder(scene.name))
    jobs.load_engines(stages)
    try:
        with jobs.naming(source):
            solution = solve(scene, stages)
    except ConvergenceError as failure:
        return _not_converged(failure, scene, folder)
    path = write_solution(solution, folder)
    show_table(scene.title or scene.name, ("quantity", "value"), summary_rows(solution))
    met = _show_expected(scene, (solution,))
    say(str(path))
    return WITHIN if is_admissible(solution) and met else OUTSIDE


def _not_converged(failure: ConvergenceError, scene: Scene, folder: Path) -> int:
    """Show the record, keep the steps solved so far."""
    from reports.single import summary_rows, write_solution

    complain(f"halfplane: {scene.name}: not converged: {failure}")
    if failure.partial is None:
        complain("halfplane: no step was solved, so nothing was written")
        return NOT_CONVERGED
    path = write_solution(failure.partial, folder, name="partial")
    show_table("Steps solved before it failed", ("quantity", "value"), summary_rows(failure.partial))
    say(str(path))
    return NOT_CONVERGED


def _show_verdict(comparison: Comparison) -> None:
    from reports.wording import accuracy_of, tolerance_of, unit_of, value_of, verdict

    scene = comparison.scene
    show_table(
        scene.title or scene.name,
        ("metric", "discrepancy", "as a share", "tolerance", "accurate"),
        [(m.label, value_of(m), unit_of(m), tolerance_of(m), accuracy_of(m)) for m in comparison.headlines],
        right=(1, 3),
    )
    say(verdict(comparison), "bold green" if comparison.passed else "bold red")


def _show_budget(comparison: Comparison) -> None:
    """Where the errors come from, if that was measured."""
    if comparison.budget is None:
        return
    from reports.budget_words import cost, heads, rows

    columns = heads(comparison.budget, full=False)
    show_table("Where the discrepancy comes from", columns, rows(comparison.budget, full=False), right=range(1, len(columns) - 2))
    say(f"Honest: {comparison.honest}")
    say(cost(comparison.budget))


def _show_third(report: jobs.Report) -> None:
    """Theory, our finite elements and another code, if that was asked."""
    if report.third is None:
        return
    from reports.third.words import heads, rows, sentences

    show_table("A third opinion", heads(report.third), rows(report.comparison, report.third), right=(1, 2, 3))
    for sentence in sentences(report.third):
        say(sentence)


def _show_expected(scene: Scene, solutions: Sequence[ContactSolution]) -> bool:
    """The numbers that the scene expects beside those found; whether all are met."""
    from reports import expected

    findings = list(expected.check(scene, solutions))
    if findings:
        show_table("Expected numbers", expected.HEADS, expected.rows(findings), right=(2, 3, 4, 5))
        missed = sum(not finding.met for finding in findings)
        say(
            f"{missed} of {len(findings)} expected numbers are missed."
            if missed
            else f"All {len(findings)} expected numbers are met."
        )
    return all(finding.met for finding in findings)


def paper(out: Path | None, quiet: bool) -> int:
    """The paper's figures and both tables; outside if a misprint is not proven."""
    stages = Stages(quiet)
    folder = claim(out or default_folder("paper"))
    with stages.stage("loading"):
        from reports.paper import page
        from reports.paper.tables import proven_in_words
    command = shlex.join(["halfplane", "paper", "--out", str(folder)])
    report = page.write(folder, stages, command)
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
    counts = ", ".join(f"{count} {verdict}" for verdict, count in page.tally(report.statements).items())
    proven = sum(row.proven is True for row in report.misprints)
    say(f"{len(report.statements)} statements: {counts}; {len(report.misprints)} misprints: {proven} proven by evaluation")
    say(str(report.page))
    return WITHIN if report.proven else OUTSIDE


def scenes(name: str, tags: tuple[str, ...], as_json: bool) -> int:
    """The library, or one scene of it: text with small sketches, or JSON."""
    from reports import library

    if name and tags:
        raise InputError("--tag: it goes with the whole library, not with the name of one scene; leave one of the two out")
    if as_json:
        found = library.record(jobs.read(name)) if name else [library.record(scene) for scene in library.tagged(tags)]
        say(json.dumps(found, indent=1))
        return WITHIN
    for line in library.details(jobs.read(name)) if name else library.listing(library.tagged(tags)):
        say(library.legible(line, sys.stdout.encoding))
    return WITHIN


def init(file: Path, start: str, bodies: bool) -> int:
    """Write a scene file."""
    if start and bodies:
        raise InputError("--bodies: it goes with the commented example, not with --from; leave one of the two out")
    if file.suffix != ".toml":
        raise InputError(f"{file}: a commented scene is written as .toml; name the file so")
    text = scene_text(start) if start else _example(bodies)
    beside = {file.parent / name: content for name, content in (scene_companions(start) if start else {}).items()}
    if taken := next((path for path in beside if path.exists()), None):
        raise InputError(f"{taken}: the file is there already and stays as it is; choose another folder for {file.name}")
    for path, content in {file: text.replace("FILE.toml", str(file)), **beside}.items():
        _write_new(path, content)
    with_it = f" (with {', '.join(path.name for path in beside)})" if beside else ""
    if start:
        say(f"{file}: its expected numbers are those of {start}: change them, or take them out, when you change the question")
    say(f"{file}{with_it}: edit it, then `halfplane check {file}` and `halfplane run {file}`")
    return WITHIN


def _example(bodies: bool) -> str:
    """The commented example; with `bodies`, the comment signs before its tables of bodies are gone."""
    text = (resources.files("reports") / "templates" / "scene.toml").read_text("utf-8")
    start, end = text.index("# [bodies.lower]"), text.index("[tolerances]")
    return text[:start] + re.sub(r"(?m)^# ", "", text[start:end]) + text[end:] if bodies else text


def _write_new(path: Path, text: str) -> None:
    try:
        with path.open("x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError:
        raise InputError(f"{path}: the file is there already and stays as it is; name another") from None
    except OSError as reason:
        raise InputError(f"{path}: the file can't be written: {reason.strerror}; name another place") from reason


def check(source: str) -> int:
    """Read and check a scene, say how near it comes to gross sliding."""
    from reports.body_words import bodies_in_words, idealisation, unlike_materials
    from reports.wording import question

    scene = jobs.read(source)
    found = checking.check_path(scene)
    say(question(scene))
    for sentence in (bodies_in_words(scene), unlike_materials(scene), idealisation(scene)):
        if sentence:
            say(sentence)
    say(
        f"{source}: the scene is well formed and its load path admissible: |Q|/(f P) is at most {found.ratio:.4g}, "
        f"in the {found.part} at time {found.time:.6g} (P = {found.normal_load:.6g}, Q = {found.tangential_load:.6g}); "
        "gross sliding starts at 1"
    )
    return WITHIN


def schema() -> int:
    """The JSON schema on stdout."""
    say(json.dumps(scene_schema(), indent=2))
    return WITHIN


def doctor(out: Path | None) -> int:
    """The doctor's findings."""
    from reports.doctor import examine

    findings = examine(out or "out")
    show_table("Doctor", ("check", "good", "found"), [(f.name, "yes" if f.good else "no", f.found) for f in findings])
    return WITHIN if all(finding.good for finding in findings) else OUTSIDE
