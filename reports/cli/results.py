"""The commands that judge results: an external one against the reference, two runs against each other, a scene by the maps."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from reports.cli.options import Json, Output, SceneName, Silent, Tolerance, answer, flag, several, share_of, tolerances_of
from reports.cli.process import NOT_CONVERGED, OUTSIDE, WITHIN
from reports.cli.solving import exit_code, read, show_verdict
from reports.console import Stages, complain, say, show_table
from reports.units import minus

if TYPE_CHECKING:
    from reports.cli.findings import Difference, Row
    from reports.comparison import Report
    from reports.maps.advice import Advice


# --------------------------------------------------------------------------------------------------------- an external result
@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class ScoreOptions(Output):
    """What an external result is an answer to, and how its file is read."""

    scene: Annotated[str | None, Parameter(help="The scene that it answers: a library name, or a .toml or .json file.")] = None
    as_: Annotated[
        Literal["tractions", "loop"],
        Parameter("--as", help="What the file holds: tractions, or a rig's loop of tangential load over displacement."),
    ] = "tractions"
    rig_compliance: Annotated[
        float | None, Parameter(help="Of a loop: displacement of the rig per tangential load, 1/stress; fitted if left out.")
    ] = None
    mapping: Annotated[Path | None, Parameter(help="TOML file: names of columns, units, signs. Usual ones need none.")] = None
    against: Annotated[Literal["exact", "fe"], Parameter(help="Half-plane theory, or the project's own finite elements.")] = "exact"
    tolerance: Tolerance = ()
    out: Annotated[Path | None, Parameter(help="Folder for the results; out/score-<result> if left out.")] = None
    mapping_example: Annotated[bool, flag("Print a commented mapping file and stop.")] = False


_SCORE = ScoreOptions()


def score(
    result: Annotated[
        str | None,
        Parameter(help="An external result: a table (.csv, .txt, .rpt), fields, a solution (.nc); or a folder of meshes."),
    ] = None,
    *,
    options: ScoreOptions = _SCORE,
) -> int:
    """A file, or each file of a folder, against the reference: verdict, likely causes of the difference, page."""
    from scenes import ConvergenceError, InputError

    if options.mapping_example:
        say((resources.files("reports") / "templates" / "mapping.toml").read_text("utf-8").rstrip())
        return WITHIN
    if result is None:
        raise InputError("score: name the result to score, a file or a folder of files")
    if options.scene is None:
        raise InputError(f"{result}: --scene is missing: name the scene that it answers; `halfplane scenes` lists the library")
    from reports.folder import claim, default_folder
    from reports.scoring.mapping import load_mapping

    stages, path, loop = Stages(options.quiet), Path(result), options.as_ == "loop"
    scene, mapping = read(options.scene), load_mapping(options.mapping)
    if not path.exists():
        raise InputError(f"{result}: there is no such file or folder")
    if loop and not path.is_file():
        raise InputError(f"{path}: a loop is one file, a table with the columns U and Q")
    if loop and options.tolerance:
        raise InputError("--tolerance: a loop has none, its own scatter judges it; leave this out")
    if not loop and options.rig_compliance is not None:
        raise InputError("--rig-compliance: it goes with --as loop; say that too, or leave this out")
    if options.rig_compliance is not None and not math.isfinite(options.rig_compliance):
        raise InputError(f"--rig-compliance {options.rig_compliance:g} is refused: it is a finite number, 1/stress")
    tolerances = tolerances_of(options.tolerance)
    folder = claim(options.out or default_folder(f"score-{path.resolve().stem}"))
    command = options.command("score", result, folder).replace("--as-", "--as")

    def field() -> int:
        """Tractions and whatever else files hold, against the reference."""
        with stages.stage("loading"):
            from reports.page.writing import write
            from reports.scoring.against import diagnosed, score_file
            from reports.scoring.study import score_folder
        if path.is_dir():
            report = score_folder(path, mapping, scene, stages, against=options.against, tolerances=tolerances)
        else:
            with stages.stage("reading and scoring"):
                report = score_file(path, mapping, scene, against=options.against, tolerances=tolerances)
            with stages.stage("diagnosis"):
                report = diagnosed(report)
        with stages.stage("report"):
            page = write(report, folder, command=command, seconds=dict(stages.seconds))
        code = exit_code(report.comparison)
        if options.json:
            from reports.comparison.words import whole_content

            return answer("score", code, whole_content(report, command, stages.seconds) | {"page": str(page)}, scene.name)
        _show_score(report)
        say(str(page))
        return code

    def measured_loop() -> int:
        """A measured loop of Q over U as the reference: which f fits it, beside the engines' loops."""
        with stages.stage("loading"):
            from reports.scoring import loops
        with stages.stage("reading"):
            rows = loops.read_loop(path, mapping, scene)
        with stages.stage("fitting"):
            found = loops.score_loop(rows, scene, rig_compliance=options.rig_compliance, against=options.against)
        with stages.stage("report"):
            page = loops.write(found, folder, command)
        code = WITHIN if found.agrees else OUTSIDE
        if options.json:
            return answer("score", code, loops.content(found) | {"page": str(page), "seconds": stages.seconds}, scene.name)
        for sentence in found.said:
            say(f"Taken for granted: {sentence}.")
        heads, cells = loops.table(found)
        show_table(f"{scene.title or scene.name}: measured loop {path.name}", heads, cells, right=range(1, len(heads)))
        say(found.sentence)
        say(str(page))
        return code

    try:
        return measured_loop() if loop else field()
    except ConvergenceError as failure:
        sentence = f"the reference is not converged: {failure}"
        complain(f"halfplane: {scene.name}: {sentence}")
        failed: dict[str, Any] = {"passed": False, "error": sentence, "file": None}
        return answer("score", NOT_CONVERGED, failed, scene.name) if options.json else NOT_CONVERGED


def _show_score(report: Report) -> None:
    """Guesses, verdict, likely causes, and the mesh study where it is one."""
    for sentence in report.guesses:
        say(f"Taken for granted: {sentence}.")
    show_verdict(report)
    reasons: dict[str, list[str]] = {}  # headlines without a value, those with one reason in one line
    for metric in report.comparison.headlines:
        if metric.value is None and metric.note:
            reasons.setdefault(metric.note, []).append(metric.label)
    for reason, labels in reasons.items():
        say(f"Not scored: {', '.join(labels)} ({reason}).")
    for note in report.comparison.notes:
        if note.startswith("Not scored: "):  # a file of the folder
            say(note)
    if report.diagnoses:
        say("Likely causes:")
    for number, one in enumerate(report.diagnoses, 1):
        say("\n   - ".join((f"{number}. {one.sentence}", *one.evidence)))
    if report.study is not None:
        heads = report.study.heads
        show_table("Mesh study", heads, report.study.rows, right=range(1, len(heads)))
        for sentence in report.study.sentences:
            say(sentence)


# ------------------------------------------------------------------------------------------------- two runs, or one and a baseline
@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class DiffOptions:
    """How far two runs may be apart, and whether one becomes the baseline."""

    tolerance: Annotated[tuple[str, ...], several('KEY=VALUE of one value, or of many: "metric.*=1e-4".')] = ()
    accept: Annotated[bool, flag("Make B a baseline of A; the tolerances given are kept in it.")] = False
    json: Json = False
    quiet: Silent = False


_DIFF = DiffOptions()


def diff(
    a: Annotated[str, Parameter(help="Folder of a run, its comparison.json, a solution (.nc), or a baseline.")],
    b: Annotated[str, Parameter(help="The same; with --accept the baseline to write.")],
    *,
    options: DiffOptions = _DIFF,
) -> int:
    """The table of A and B; with --accept B becomes a baseline of A."""
    from reports.cli.findings import difference, is_baseline, read_findings, tolerances_of, write_baseline
    from scenes import InputError

    given, path, first = tolerances_of(options.tolerance), Path(b), read_findings(a)
    if not options.accept:
        if not path.exists():
            raise InputError(f"{b}: there is no such file or folder; `halfplane diff {a} {b} --accept` writes it as a baseline")
        found = difference(first, read_findings(b), given)
        return _show_diff(found, WITHIN if found.same else OUTSIDE, options)
    if path.exists() and not is_baseline(path):
        raise InputError(f"{b}: this is not a baseline, and --accept writes over nothing else; name another file")
    before = read_findings(b) if path.exists() else None
    # Compared with itself where there is nothing yet: that is how an unknown key of --tolerance is found.
    found = difference(first, before or first, given)
    write_baseline(first, path, {**(before.tolerances if before else {}), **given})
    if before or options.json:
        _show_diff(found, WITHIN, options)
    if not options.json and not options.quiet:
        say(f"{b}: {len(first.figures)} values of {first.scene.name or first.source} accepted")
    return WITHIN


def _show_diff(found: Difference, code: int, options: DiffOptions) -> int:
    from reports.cli.findings import SAME

    if options.json:
        return answer("diff", code, found.content(), found.scene)
    if options.quiet:
        return code
    shown = [_cells(row) for row in found.rows if not (row.verdict == SAME and (row.difference == 0 or row.a == row.b))]
    title = f"{found.scene}: A = {found.a}, B = {found.b}"
    if shown:
        show_table(title, ("value", "A", "B", "B − A", "tolerance", "verdict"), shown, right=(1, 2, 3, 4))
    else:
        say(title)
    if identical := len(found.rows) - len(shown):
        say(f"{identical} values are the same to the last digit and not listed (--json has them)")
    for note in found.notes:
        say(note)
    apart = [row.key for row in found.rows if row.verdict != SAME]
    all_of = f"all {len(found.rows)} values are the same within tolerance"
    say(f"{len(found.rows)} values, {len(apart)} differ: {', '.join(apart)}" if apart else all_of)
    return code


def _cells(row: Row) -> tuple[str, ...]:
    value_a, value_b = ("none" if value is None else f"{value:.10g}" for value in (row.a, row.b))
    apart = "–" if row.difference is None else minus(f"{row.difference:+.1e} {'' if row.kind == 'absolute' else 'rel.'}".rstrip())
    return row.key, value_a, value_b, "0" if row.difference == 0 else apart, f"{row.tolerance:g}", row.verdict


# ---------------------------------------------------------------------------------------------------------- a scene by the maps
@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class AdviseOptions:
    """Up to which error half-plane theory may be used."""

    limit: Annotated[str, Parameter(help="Error of dissipation up to which half-plane theory may be used: 5% or 0.05.")] = "5%"
    json: Json = False


_ADVISE = AdviseOptions()


def advise(scene: SceneName, *, options: AdviseOptions = _ADVISE) -> int:
    """What the published maps say of a scene; outside where the error of dissipation may exceed the limit, or is not known."""
    from reports.maps.advice import Advice, parts_of, sentence
    from scenes import InputError

    limit = share_of(options.limit)
    if not 0 < limit < 1:
        raise InputError(f"--limit {options.limit} is refused: it is a share above 0 and below 1, such as 0.05 for 5 %")
    found = read(scene)
    advice = Advice(found, *parts_of(found), limit)
    code = WITHIN if advice.may_be_used else OUTSIDE
    if options.json:
        return answer("advise", code, _advice_content(advice), found.name)
    if advice.parts:
        _show_advice(advice, scene)
    say(sentence(advice) if advice.parts else f"{scene}: {sentence(advice)}")
    return code


def _advice_content(advice: Advice) -> dict[str, Any]:
    """Every departure (`errors` null where the maps know nothing), the sum of what is known, and the answer."""
    from reports.comparison.metrics import Verdict
    from reports.maps.advice import FIGURES, sentence, total

    def pair(error: float, uncertainty: float) -> dict[str, float]:
        return {"error": error, "uncertainty": uncertainty}

    names = {figure: figure.removeprefix("error.") for figure in FIGURES}
    return {
        "passed": advice.may_be_used,
        "sentence": sentence(advice),
        "limit": advice.limit,
        "verdict": advice.verdict,
        "within_limit": None if advice.verdict is None else advice.verdict is Verdict.WITHIN,
        "extrapolated": advice.extrapolated,
        "contact_half_width": advice.half_width,
        "departures": [
            {
                "what": part.what,
                "errors": None if part.values is None else {names[name]: pair(*part.values[name]) for name in FIGURES},
                "extrapolated": part.extrapolated,
                "from": part.how,
            }
            for part in advice.parts
        ],
        "sum_of_known": {names[name]: pair(*total(advice.known, name)) for name in FIGURES} if advice.known else None,
    }


def _show_advice(advice: Advice, source: str) -> None:
    from reports.maps.advice import FIGURES, cell, cells, total
    from reports.maps.laws import WORDS
    from reports.units import units

    rows = [(part.what, *cells(part), part.how) for part in advice.parts]
    if len(rows) > 1 and advice.known:
        name = "sum" if len(advice.known) == len(rows) else "sum of what is known"
        rows.append((name, *(cell(*total(advice.known, figure), advice.extrapolated) for figure in FIGURES), "all added up"))
    heads = ("departure", *(WORDS[figure] for figure in FIGURES), "where from")
    title = advice.scene.title or source
    load = "mean" if advice.scene.load.kind == "ellipse" else "largest"
    size = f"a = {advice.half_width:.4g} {units(advice.scene)[1]} at the {load} load"
    show_table(f"{title}: bodies/half-plane theory − 1; {size}", heads, rows)
