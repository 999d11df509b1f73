"""What the commands about scenes do: list the library, write a scene file, check one, print the schema."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

from reports import checking, jobs, questions
from reports.answers import SceneAnswers, example
from reports.application import WITHIN
from reports.console import Stages, say
from scenes import InputError, Scene, TimeSeriesLoad, scene_companions, scene_schema, scene_text

# Rows of a load series up to which `check` asks the finite elements too: 10,000 take them a second to look at, and hours to solve.
_MOST_ROWS = 10_000


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
        say(line)
    return WITHIN


def init(file: Path, start: str, bodies: bool, answers: SceneAnswers, quiet: bool) -> int:
    """Write a scene file: a copy, the example with answers from options, or on a terminal with answers to questions."""
    given = answers.given()
    if start and (bodies or given):
        word = "--bodies" if bodies else "--" + next(iter(given)).replace("_", "-")
        raise InputError(f"{word}: it goes with the commented example, not with --from; leave one of the two out")
    if file.suffix != ".toml":
        raise InputError(f"{file}: a commented scene is written as .toml; name the file so")
    _refuse_taken(file)
    text = scene_text(start) if start else _new_scene(file, bodies, given, quiet)
    beside = {file.parent / name: content for name, content in (scene_companions(start) if start else {}).items()}
    if taken := next((path for path in beside if path.exists()), None):
        raise InputError(f"{taken}: the file is there already and stays as it is; choose another folder for {file.name}")
    with ExitStack() as undo:
        for path, content in {file: text.replace("FILE.toml", str(file)), **beside}.items():
            _write_new(path, content, undo)
        undo.pop_all()
    if quiet:
        return WITHIN
    with_it = f" (with {', '.join(path.name for path in beside)})" if beside else ""
    if start:
        say(f"{file}: its expected numbers are those of {start}: change them, or take them out, when you change the question")
    say(f"{file}{with_it}: edit it, then `halfplane check {file}` and `halfplane run {file}`")
    return WITHIN


def _new_scene(file: Path, bodies: bool, given: dict[str, Any], quiet: bool) -> str:
    """The text of a new scene; questions are asked only where somebody can answer and nothing was answered by options."""
    if not (given or bodies or quiet) and sys.stdin.isatty() and sys.stdout.isatty():
        say(f"A new scene in {file}. Enter takes what stands in brackets; Ctrl-C leaves nothing behind.")
        try:
            return questions.asked(partial(_check_text, file), input, say)
        except EOFError:
            raise InputError(f"{file}: the questions were not answered to their end, so nothing was written") from None
    if "flat_half_length" in given and given.get("profile") != "flat_rounded":
        raise InputError("--flat-half-length: it goes with --profile flat_rounded; say that too, or leave this out")
    text = example(bodies, given)
    _check_text(file, text)
    return text


def _check_text(file: Path, text: str) -> None:
    """InputError, in words that name `file`, if the text is no admissible scene."""
    with tempfile.TemporaryDirectory() as folder:
        trial = Path(folder) / file.name
        trial.write_text(text, encoding="utf-8")
        try:
            jobs.read(str(trial))
        except InputError as fault:
            raise InputError(str(fault).replace(str(trial), str(file))) from None


def _refuse_taken(path: Path) -> None:
    if os.path.lexists(path):
        raise InputError(f"{path}: the file is there already and stays as it is; name another")


def _write_new(path: Path, text: str, undo: ExitStack) -> None:
    try:
        with path.open("x", encoding="utf-8") as stream:
            undo.callback(path.unlink, missing_ok=True)
            stream.write(text)
    except FileExistsError:
        _refuse_taken(path)
        raise
    except OSError as reason:
        raise InputError(f"{path}: the file can't be written: {reason.strerror}; name another place") from reason


def check(source: str, as_json: bool, quiet: bool) -> int:
    """Refuse what `run` would refuse; say how large the contact gets, and how near it comes to gross sliding."""
    from reports.body_words import bodies_in_words, idealisation, unlike_materials
    from reports.largest_contact import in_words, largest_contact, remarks
    from reports.wording import question

    scene = jobs.read(source)
    largest = largest_contact(scene, source)
    doubts = remarks(scene, largest) + _refused_by_elements(scene, source)
    found = checking.check_path(scene)
    words = [sentence for sentence in (bodies_in_words(scene), unlike_materials(scene), idealisation(scene)) if sentence]
    last = (
        f"{source}: the scene is well formed and its load path admissible: |Q|/(f P) is at most {found.ratio:.4g}, "
        f"in the {found.part} at time {found.time:.6g} (P = {found.normal_load:.6g}, Q = {found.tangential_load:.6g}); "
        "gross sliding starts at 1"
    )
    if as_json:
        from reports.machine import check_json

        say(check_json(scene, found, largest, [question(scene), *words], doubts, last))
    elif not quiet:
        for sentence in (question(scene), *words, in_words(scene, largest), *(f"Remark: {doubt}" for doubt in doubts), last):
            say(sentence)
    return WITHIN


def _refused_by_elements(scene: Scene, source: str) -> list[str]:
    """InputError for what finite elements refuse; a remark where the load series is too long to ask them."""
    if isinstance(scene.load, TimeSeriesLoad) and len(scene.load.rows) > _MOST_ROWS:
        return [
            f"The record has {len(scene.load.rows)} rows, and finite elements take at least two increments a row: solve it by "
            "half-plane theory alone, `halfplane exact`."
        ]
    jobs.load_engines(Stages(quiet=True))
    import halfplane_fe

    with jobs.naming(source):
        halfplane_fe.require_solvable(scene)
    return []


def schema() -> int:
    """The JSON schema on stdout."""
    say(json.dumps(scene_schema(), indent=2))
    return WITHIN
