"""The commands about scene files: write one to start from, check one, show the library, print the
schema.
"""

from __future__ import annotations

import json
import os
import re
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from reports.cli.application import EXIT_WITHIN, TEMPLATES, Answer, Options
from reports.cli.solving import load_engines, read
from reports.console import Part, Sheet, Stages, width

if TYPE_CHECKING:
    from reports.checking import BulkAndTilt, EngineRefusals, LargestContact, NearestToSliding
    from scenes import ContactSolution, Scene

# Rows of a load series up to which `check` asks the finite elements too: 10,000 take them a second
# to look at, and hours to solve.
_MOST_ROWS = 10_000
# Where the comments of the example stand.
_COLUMN_OF_COMMENTS = 32


# --------------------------------------------------------------------------------------------- init
def init(file: Path, options: Options) -> Answer:
    """The command `init`: write a scene file to edit. It is a copy of a library scene, with its
    companions (the tables that it reads), or the commented example as the options choose it.

    `file` is the new file. Options: `library_scene` (--from) is the scene to copy, `bodies` and
    `profile` choose the example. InputError where a file is there already, for another ending than
    .toml, and for --from with an option of the example.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    from scenes import InputError, scene_companions, scene_text

    copied_name = options.library_scene
    if copied_name and (options.bodies or options.profile != "hertz"):
        refused_option = "--bodies" if options.bodies else "--profile"
        raise InputError(
            f"{refused_option}: it goes with the commented example, not with --from; leave one of"
            " the two out"
        )
    if file.suffix != ".toml":
        raise InputError(f"{file}: a commented scene is written as .toml; name the file so")
    _refuse_existing_file(file)
    scene_file_text = (
        scene_text(copied_name) if copied_name else example(options.bodies, options.profile)
    )
    companions: dict[Path, str] = {}  # path -> text
    if copied_name:
        for name, companion_text in scene_companions(copied_name).items():
            companions[file.parent / name] = companion_text
    for companion in companions:
        if companion.exists():
            raise InputError(
                f"{companion}: the file is there already and stays as it is; choose another folder"
                f" for {file.name}"
            )
    _write_new_files({file: scene_file_text.replace("FILE.toml", str(file)), **companions})
    names_of_companions = ", ".join(companion.name for companion in companions)
    companions_in_words = f" (with {names_of_companions})" if names_of_companions else ""
    sentences = []
    if copied_name:
        sentences.append(
            f"{file}: its expected numbers are those of {copied_name}: change them, or take them"
            " out, when you change the question"
        )
    sentences.append(
        f"{file}{companions_in_words}: edit it, then `halfplane check {file}` and"
        f" `halfplane run {file}`"
    )
    return Answer(EXIT_WITHIN, sentences)


def _write_new_files(text_by_path: dict[Path, str]) -> None:
    """Write new text files, path -> text, all or none. InputError where a file is there already, or
    can't be written.
    """
    from scenes import InputError

    # an ExitStack calls its callbacks at the end: they remove what was written, unless all was
    with ExitStack() as undo:
        for path, text in text_by_path.items():
            try:
                with path.open("x", encoding="utf-8") as stream:
                    undo.callback(path.unlink, missing_ok=True)
                    stream.write(text)
            except OSError as reason:
                _refuse_existing_file(path, reason)
                raise InputError(
                    f"{path}: the file can't be written: {reason.strerror}; name another place"
                ) from reason
        undo.pop_all()


def _refuse_existing_file(path: Path, reason: OSError | None = None) -> None:
    """InputError where a file is at `path` already; after a failed write (`reason`) only if that
    was the reason.
    """
    from scenes import InputError

    if os.path.lexists(path) and (reason is None or isinstance(reason, FileExistsError)):
        raise InputError(f"{path}: the file is there already and stays as it is; name another")


def example(bodies: bool = False, profile: Literal["hertz", "flat_rounded"] = "hertz") -> str:
    """Text of the commented example of a scene file. With `bodies` its tables of bodies are valid
    lines, else they are comments, and the bodies half-planes. Of its two profiles `profile` is the
    valid one, the other a comment.
    """
    # TEMPLATES: folder of the texts that commands print
    text = (TEMPLATES / "scene.toml").read_text("utf-8")
    if bodies:
        # remove the sign of a comment from the lines of the bodies
        start_of_bodies = text.index("# [bodies.lower]")
        end_of_bodies = text.index("# What you admit")
        text = (
            text[:start_of_bodies]
            + re.sub(r"(?m)^# ", "", text[start_of_bodies:end_of_bodies])
            + text[end_of_bodies:]
        )
    if profile == "flat_rounded":
        # comments behind the lines start in column 32
        for old_line, new_line in (
            ('kind = "hertz"', '# kind = "hertz"'),
            ('# kind = "flat_rounded"', 'kind = "flat_rounded"'),
            ("# flat_half_length = 0.5", "flat_half_length = 0.5"),
        ):
            text = re.sub(
                rf"(?m)^{old_line} *", f"{new_line:<{_COLUMN_OF_COMMENTS}}", text, count=1
            )
    return text


# -------------------------------------------------------------------------------------------- check
class _CheckedScene(NamedTuple):
    """What `check` computes of a scene without solving it.

    Attributes
    ----------
    refusals
        why theory or finite elements refuse the scene, "" each where they take it
    nearest_instant
        the largest |Q|/(f P) of the load path, with its time and loads
    bulk_effects
        what bulk stress and tilt do to the contact; None without them
    contact
        half-width, pressure and sizes at the largest load by half-plane theory; None where theory
        does not take the scene
    """

    refusals: EngineRefusals
    nearest_instant: NearestToSliding
    bulk_effects: BulkAndTilt | None
    contact: LargestContact | None


def check(source: str, options: Options) -> Answer:
    """The command `check`: validate the scene that `source` names, without solving it. It prints
    half-width and pressure at the largest load, how near the loads come to gross sliding, and
    remarks on doubtful input.

    Options: `picture` is a file for a figure of a fitted profile, `loop` a measured loop whose
    columns are stated. InputError where the scene, the loop or the picture is refused.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.
    """
    from reports.checking import bulk_in_words
    from reports.measured import read_as_by_key

    scene = read(source, may_prescribe_displacements=True)
    if options.picture is not None:
        _draw_fit(scene, options.picture)
    if scene.load.is_driven:
        return _check_rig(scene, source, options)
    # how the table of a measured loop was read; empty without --loop
    columns_of_loop = _columns_of_loop(scene, options)
    checked = _checked_scene(scene, source)
    # table -> pairs of a quantity and words on the column that it was read from
    columns_of_table = read_as_by_key(scene) | columns_of_loop
    half_width = checked.contact.half_width if checked.contact else 0.0
    notes, further_remarks = _notes_and_remarks(scene, columns_of_table, half_width)
    remarks = [*_remarks_on_solving(scene, source, checked), *further_remarks]
    verdict = (
        f"{source}: the scene is well formed and its load path admissible. |Q|/(f P) is at most"
        f" {checked.nearest_instant.ratio:.4g}; gross sliding starts at 1."
    )
    bulk_sentences = bulk_in_words(checked.bulk_effects) if checked.bulk_effects else ""
    # how it was found out that the bodies have room for the contact, and on bulk stress and tilt
    sentences = filter(None, [checked.refusals.size_in_words, bulk_sentences])
    content = {
        "passed": True,
        "sentence": verdict,
        "notes": notes,
        "remarks": remarks,
        "read_as": columns_of_table,
        **_content_of_check(scene, checked),
    }
    marked_remarks = [f"Remark: {remark}" for remark in remarks]
    sheet = _sheet_of_check(scene, checked)
    parts: list[Part] = [verdict, sheet, *marked_remarks, *sentences, *notes]
    return Answer(EXIT_WITHIN, parts, lambda: content, scene.name)


def _rows_of_record(scene: Scene) -> int:
    """How many rows of a measured table of loads are solved; 0 for other loads."""
    from scenes import TimeSeriesLoad

    if isinstance(scene.load, TimeSeriesLoad):
        return len(scene.load.kept_rows())
    return 0


def _checked_scene(scene: Scene, source: str) -> _CheckedScene:
    """Ask which engines take a scene, and compute the contact at its largest load and the instant
    nearest to gross sliding. Finite elements are not asked about a record of more than 10,000 rows.
    `source` names the scene in messages.
    """
    from reports.checking import (
        bulk_and_tilt,
        engine_refusals,
        largest_contact,
        nearest_to_sliding,
    )
    from scenes import InputError

    load_engines(Stages(quiet=True), ["semi_analytic.solution"])
    # _MOST_ROWS: 10,000
    refusals = engine_refusals(scene, source, finite_elements=_rows_of_record(scene) <= _MOST_ROWS)
    nearest_instant = nearest_to_sliding(scene)
    bulk_effects = bulk_and_tilt(scene)
    contact = None
    with suppress(InputError):  # theory's refusal, where finite elements alone take the scene
        contact = largest_contact(scene, source)
    return _CheckedScene(refusals, nearest_instant, bulk_effects, contact)


def _remarks_on_solving(scene: Scene, source: str, checked: _CheckedScene) -> list[str]:
    """Sentences that warn: of doubtful input, of an engine that refuses the scene, and of a record
    so long that finite elements take hours.

    `source` names the scene. `checked` holds what was computed of it: the refusals of engines, and
    the contact at the largest load.
    """
    from reports.checking import remarks_on_input
    from scenes import InputError

    remarks: list[str] = []
    if checked.contact is not None:
        with suppress(InputError):
            remarks += remarks_on_input(scene, checked.contact)
    n_rows = _rows_of_record(scene)
    if refusals_in_words := checked.refusals.in_words(source):
        remarks.append(f"{refusals_in_words}.")
    elif n_rows > _MOST_ROWS:
        remarks.append(
            f"The record has {n_rows} rows, and finite elements take at least two increments a row."
            " Solve it by half-plane theory alone: `halfplane exact`."
        )
    return remarks


def _sheet_of_check(scene: Scene, checked: _CheckedScene) -> Sheet:
    """The table that `check` prints: the contact at the largest load by half-plane theory, where it
    is known, and how near the loads come to gross sliding.

    `checked` holds what was computed of the scene.
    """
    from reports.checking import rows_of_contact, rows_of_sliding

    rows = rows_of_contact(scene, checked.contact) if checked.contact else []
    rows += rows_of_sliding(scene, checked.nearest_instant)
    # Sheet: title, heads, rows, and the columns that are flush right
    return Sheet("By half-plane theory", ("", "value"), rows, (1,))


def _content_of_check(scene: Scene, checked: _CheckedScene) -> dict[str, Any]:
    """Entries of --json with what `check` computed: why engines refuse the scene, the contact at
    the largest load (None where it is not known), the instant nearest to gross sliding, the fit of
    a measured profile, the stated uncertainties, and the effects of bulk stress and tilt where
    there are any.

    `checked` holds what was computed of the scene.
    """
    from reports.input_words import stated_content
    from reports.profile_fit import content as fit_content

    content = {
        "engines": checked.refusals.reasons,
        "largest_contact": vars(checked.contact) if checked.contact else None,
        "nearest_to_sliding": vars(checked.nearest_instant),
        "profile_fit": fit_content(scene),
        "uncertainty_of_inputs": stated_content(scene),
    }
    if checked.bulk_effects:
        content["bulk_and_tilt"] = vars(checked.bulk_effects)
    return content


def _notes_and_remarks(
    scene: Scene, columns_of_table: Mapping[str, tuple[tuple[str, str], ...]], half_width: float
) -> tuple[list[str], list[str]]:
    """Sentences that `check` prints on a scene: notes (its question, its tables, its measured
    loads, its fitted profile, its stated uncertainties), and remarks, which warn.

    Parameters
    ----------
    columns_of_table
        how each table of the scene was read: name of the table -> pairs of a quantity and words on
        the column that it was read from
    half_width
        of the contact at the largest load [length]; 0 where it is not known
    """
    from reports.comparison.words import reading_in_words
    from reports.input_words import sliding_in_words, stated_in_words
    from reports.inputs import nearness_to_sliding, omissions_in_words
    from reports.measured import check_record, record_in_words
    from reports.profile_fit import findings_on_fit, fit_warnings

    notes = _question_in_words(scene)
    remarks: list[str] = []
    notes += [reading_in_words(table, columns) for table, columns in columns_of_table.items()]
    # what the rows of measured loads show; None: the loads are not a measured table
    if measured_loads := check_record(scene):
        for sentence, is_warning in record_in_words(scene, measured_loads):
            if is_warning:
                remarks.append(sentence)
            else:
                notes.append(sentence)
    # whether the bodies may slide by the uncertainty of the inputs
    sentence_on_sliding = sliding_in_words(nearness_to_sliding(scene))
    # and which inputs are left out of the uncertainties
    remarks += filter(None, [sentence_on_sliding, omissions_in_words(scene)])
    remarks += fit_warnings(scene, half_width)
    sentences_on_fit, _ = findings_on_fit(scene)
    notes += [sentence for sentence in sentences_on_fit if sentence not in remarks]
    notes += filter(None, [stated_in_words(scene)])
    return notes, remarks


def _question_in_words(scene: Scene) -> list[str]:
    """Sentences on a scene: its question, its bodies, what theory leaves out of them."""
    from reports.comparison.words import (
        bodies_in_words,
        idealisation_in_words,
        question_in_words,
        unlike_materials_in_words,
    )

    sentences = (
        bodies_in_words(scene),
        unlike_materials_in_words(scene),
        idealisation_in_words(scene),
    )
    return [question_in_words(scene), *filter(None, sentences)]


def _draw_fit(scene: Scene, file: Path) -> None:
    """Write a figure of a profile that is fitted to measured heights, trace and residuals, as an
    SVG file. Lines in it mark the edges of the largest contact.

    Raises
    ------
    InputError
        For a profile that is not fitted, another ending, a file that exists or can't be written.
    """
    from reports.checking import largest_contact
    from reports.page.body_figures import fit_residuals
    from scenes import InputError

    if file.suffix != ".svg":
        raise InputError(f"--picture {file}: it is written as .svg; name the file so")
    half_width = 0.0  # no contact is drawn
    with suppress(InputError):  # a contact wider than the measured rows: `check` says so
        half_width = largest_contact(scene, scene.name).half_width
    figure = fit_residuals(scene, half_width)
    if figure is None:
        raise InputError(
            f"--picture: the profile of {scene.name} is not fitted to rows: leave it out, or state"
            " profile.fit"
        )
    _refuse_existing_file(file)
    try:
        file.write_text(figure.svg(), encoding="utf-8")
    except OSError as reason:
        raise InputError(f"{file}: the file can't be written: {reason.strerror}") from reason


def _check_rig(scene: Scene, source: str, options: Options) -> Answer:
    """What the command `check` reports on a scene that prescribes displacements (a rig): the loads,
    sliding and dissipation that follow from them by half-plane theory, and remarks.

    An `Answer` holds the exit code, lines and tables for the terminal, and the content for --json.

    Parameters
    ----------
    source
        file or name of the scene, for messages
    options
        of the command line; `loop` is refused
    """
    from reports.checking import engine_refusals
    from reports.comparison.words import bodies_in_words, question_in_words, reading_in_words
    from reports.input_words import stated_content, stated_in_words
    from reports.inputs import omissions_in_words
    from reports.measured import read_as_by_key
    from scenes import InputError

    if options.loop is not None:
        raise InputError(
            "--loop: it goes with given loads, and this scene prescribes U; leave it out"
        )
    load_engines(Stages(quiet=True), ["semi_analytic.solution"])
    # why theory or finite elements refuse the scene, "" where they do not
    refusals = engine_refusals(scene, source)
    # table -> pairs of a quantity and words on the column that it was read from
    columns_of_table = read_as_by_key(scene)
    notes = [
        question_in_words(scene),
        *filter(None, [bodies_in_words(scene), stated_in_words(scene)]),
    ]
    notes += [reading_in_words(table, columns) for table, columns in columns_of_table.items()]
    remarks = [f"{refusals.in_words(source)}.", *filter(None, [omissions_in_words(scene)])]
    content = {
        "passed": True,
        "remarks": remarks,
        "read_as": columns_of_table,
        "engines": refusals.reasons,
        "largest_contact": None,
        "nearest_to_sliding": None,
        "profile_fit": None,
        "uncertainty_of_inputs": stated_content(scene),
    }
    if refusals.refusal_of_theory:
        verdict = f"{source}: the scene is well formed. `halfplane fe {source}` finds its loads."
    else:
        solution = _solution_of_theory(scene, source)
        verdict = _loads_in_words(solution, source)
        notes += [f"{note[:1].upper()}{note[1:]}." for note in solution.record.notes]
        content["rig"] = _values_of_rig(solution)
    content |= {"sentence": verdict, "notes": notes}
    parts = [verdict, *(f"Remark: {remark}" for remark in remarks), *notes]
    return Answer(EXIT_WITHIN, parts, lambda: content, scene.name)


def _loads_in_words(solution: ContactSolution, source: str) -> str:
    """The sentence of `check` on a scene with prescribed displacements: the range of Q, the largest
    P, and how near the contact comes to sliding. `source` is the file or name of the scene.
    """
    from reports.comparison.laws import largest_load_ratio
    from reports.units import number

    scene = solution.scene
    unit_of_force, unit_of_length, _ = scene.unit_words
    # `number`: as text, to six digits
    least_tangential_load = number(float(solution.tangential_load.min()))
    largest_tangential_load = number(float(solution.tangential_load.max()))
    largest_normal_load = number(float(solution.normal_load.max()))
    ratio_in_words = ""
    if scene.friction.coefficient:
        ratio_in_words = (
            f" |Q|/(f P) is at most {largest_load_ratio(solution):.4g}; all slides at 1."
        )
    return (
        f"{source}: the scene is well formed. Q goes from {least_tangential_load} to"
        f" {largest_tangential_load} {unit_of_force}/{unit_of_length}, and P up to"
        f" {largest_normal_load}.{ratio_in_words}"
        f" `halfplane exact {source}` writes the answer, and a scene with these loads."
    )


def _values_of_rig(solution: ContactSolution) -> dict[str, float | None]:
    """Values that `check` reports of half-plane theory under prescribed displacements, in the
    scene's units: the dissipation W of a cycle [force], the largest half-width [length], |Q|
    [force/length] and |Q|/(f P), which is NaN without friction.
    """
    import numpy as np

    from reports.comparison.laws import largest_load_ratio

    return {
        "dissipation": solution.dissipation,
        "largest_half_width": float(solution.contact_half_width.max()),
        "largest_tangential_load": float(np.abs(solution.tangential_load).max()),
        "largest_sliding_ratio": largest_load_ratio(solution),
    }


def _solution_of_theory(scene: Scene, source: str) -> ContactSolution:
    """Half-plane theory's dissipation and loads under the displacements that a scene prescribes.
    Where the bodies are no half-planes, theory is corrected by the elastic responses that they add.
    InputError naming `source` where theory refuses the scene.
    """
    import semi_analytic
    from scenes import InputError

    effects = None
    if not scene.bodies.half_planes:
        import halfplane_fe

        effects = halfplane_fe.body_effects(scene)
    try:
        # no field along the surface is reported: one point x is enough
        return semi_analytic.solve(scene, x=[0.0], fields=("dissipation",), effects=effects)
    except InputError as fault:
        raise InputError(f"{source}: {fault}") from fault


def _columns_of_loop(scene: Scene, options: Options) -> dict[str, tuple[tuple[str, str], ...]]:
    """How the table of the measured loop that --loop names was read: path -> pairs of a quantity
    and words on the column that it was read from. Empty without --loop. A file given as --mapping
    names the columns and their units. The scene must have a closed loop of Q over U.

    Raises
    ------
    InputError
        For a scene without a closed loop, for a mapping or a table that can't be read, and for
        --mapping without --loop.
    """
    from scenes import InputError

    if options.loop is None:
        if options.mapping is not None:
            raise InputError("--mapping: it says how a loop is read; name the loop by --loop")
        return {}
    from reports.scoring.loops import read_loop, require_loop
    from reports.scoring.mapping import load_mapping

    require_loop(scene)
    measured_loop = read_loop(options.loop, load_mapping(options.mapping), scene)
    return {str(options.loop): measured_loop.read_as}


# -------------------------------------------------------------------------- the library, the schema
def show(name: str, options: Options) -> Answer:
    """The command `scenes`: list the scenes of the library that have the requested tags (options
    --tag), or state all about the scene `name`, which may be a file; "" for the list. An answer has
    the exit code, lines for the terminal, and the content for --json.
    """
    from scenes import InputError

    if name and options.tag:
        raise InputError(
            "--tag: it goes with the whole library, not with the name of one scene; leave one of"
            " the two out"
        )
    if name:
        scene = read(name, may_prescribe_displacements=True)
        return Answer(
            EXIT_WITHIN, _details(scene), lambda: {"scenes": [_scene_content(scene)]}, scene.name
        )
    scenes = tagged(options.tag)
    return Answer(
        EXIT_WITHIN,
        _listing(scenes),
        lambda: {"scenes": [_scene_content(scene) for scene in scenes]},
    )


def tagged(chosen_tags: Sequence[str]) -> list[Scene]:
    """The scenes of the library that have all of `chosen_tags`; InputError for a word that is no
    tag.
    """
    from scenes import InputError, load_scene, rig_names, scene_names, tags

    for tag in chosen_tags:
        if tag not in tags():
            raise InputError(f"--tag {tag}: there is no such tag; there are {', '.join(tags())}")
    scenes = [load_scene(name) for name in (*scene_names(), *rig_names())]
    return [scene for scene in scenes if set(chosen_tags) <= set(scene.tags)]


def _listing(scenes: Sequence[Scene]) -> Iterator[str]:
    """Lines that list scenes of the library: name, title, purpose and tags of each. A line is as
    wide as the terminal (`width`), at least 40 columns.
    """
    if not scenes:
        yield "no scene has all of these tags"
        return
    for scene in scenes:
        yield scene.name
        for text in (scene.title, scene.purpose, " ".join(f"#{tag}" for tag in scene.tags)):
            yield from textwrap.wrap(
                text, max(width(), 40), initial_indent="    ", subsequent_indent="    "
            )
    yield (
        f"{len(scenes)} scenes. `halfplane scenes NAME` shows all about one, `halfplane init"
        " FILE.toml --from NAME` copies it."
    )


def _details(scene: Scene) -> Iterator[str]:
    """Lines that state all about one scene: question, bodies, tolerances, files, and the numbers
    that it expects. A line is as wide as the terminal, at least 40 columns.
    """
    from reports.comparison.metrics import tolerances_of
    from reports.comparison.pairs import are_half_planes
    from reports.comparison.words import (
        bodies_in_words,
        idealisation_in_words,
        question_in_words,
        unlike_materials_in_words,
    )

    # key of a metric -> largest relative difference of finite elements and theory
    tolerances = tolerances_of(scene, are_half_planes(scene))
    expected_lines = [
        f"{expected.quantity.replace('_', ' ')} = {expected.value:.9g} to {expected.tolerance:g},"
        f" {expected.engine}: {expected.source}"
        for expected in scene.expected
    ]
    sections = [(name, getattr(scene, name)) for name in ("name", "title", "purpose", "source")]
    sections += [("tags", ", ".join(scene.tags)), ("question", question_in_words(scene))]
    sentences = (
        bodies_in_words(scene),
        unlike_materials_in_words(scene),
        idealisation_in_words(scene),
    )
    sections.append(("bodies", " ".join(filter(None, sentences))))
    tolerance_texts = [f"{key.replace('_', ' ')} {value:g}" for key, value in tolerances.items()]
    sections.append(("tolerances", ", ".join(tolerance_texts) or "none: nothing is judged"))
    if companions := _companions(scene):
        sections.append(("files", ", ".join(companions)))
    sections += [("expected", text) for text in expected_lines or ["no number"]]
    for heading, text in sections:
        yield from textwrap.wrap(
            text, max(width(), 40), initial_indent=f"{heading:<12}", subsequent_indent=" " * 12
        )


def _companions(scene: Scene) -> list[str]:
    """Names of the files that a scene of the library reads besides its own."""
    from scenes import scene_companions

    return list(scene_companions(scene.name))


def _scene_content(scene: Scene) -> dict[str, Any]:
    """All about one scene as a JSON object: name, title, purpose, source, tags, expected numbers
    and tolerances first, then the question in words, its files, and what the scene states besides.
    """
    from reports.comparison.words import question_in_words

    content = scene.model_dump(mode="json")
    first_keys = ("name", "title", "purpose", "source", "tags", "expected", "tolerances")
    record = {key: content.pop(key) for key in first_keys}
    return {
        **record,
        "question": question_in_words(scene),
        "files": _companions(scene),
        "scene": content,
    }


def schema(_: Options) -> Answer:
    """The JSON schema on stdout."""
    from scenes import scene_schema

    return Answer(EXIT_WITHIN, [json.dumps(scene_schema(), indent=2)])
