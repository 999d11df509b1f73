"""What the commands about scenes do: list the library, write a scene file, check one, print the schema."""

from __future__ import annotations

import json
import re
import sys
from importlib import resources
from pathlib import Path

from reports import checking, jobs
from reports.application import WITHIN
from reports.console import say
from scenes import InputError, scene_companions, scene_schema, scene_text


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
