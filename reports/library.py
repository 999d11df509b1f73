"""The library of scenes in the terminal: a list with small sketches, the details of one scene, and both as JSON."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from reports.comparison.metrics import are_half_planes, tolerances_of
from reports.comparison.words import bodies_in_words, idealisation, question, unlike_materials
from reports.console import width
from reports.thumbnails import font_for, thumbnail
from scenes import InputError, Scene, load_scene, scene_companions, scene_names, tags


def tagged(wanted: Sequence[str]) -> list[Scene]:
    """The scenes of the library that have all these tags; InputError for a word that is no tag."""
    for tag in wanted:
        if tag not in tags():
            raise InputError(f"--tag {tag}: there is no such tag; there are {', '.join(tags())}")
    return [scene for name in scene_names() if set(wanted) <= set((scene := load_scene(name)).tags)]


def listing(found: Sequence[Scene]) -> Iterator[str]:
    """Lines: four for each scene, sketch to the left, name, title, purpose and tags to the right."""
    font = font_for(sys.stdout.encoding)
    if not found:
        yield "no scene has all of these tags"
    for scene in found:
        yield from _beside(thumbnail(scene, font), _words(scene))
        yield ""
    if found:
        yield f"{len(found)} scenes. Bodies to scale, gaps between flat faces exaggerated; Q up over P, initial loading dotted."
        yield "`halfplane scenes NAME` tells all about one, `halfplane init FILE.toml --from NAME` copies it to edit."


def _words(scene: Scene) -> Sequence[str]:
    return scene.name, scene.title, scene.purpose, " ".join(f"#{tag}" for tag in scene.tags)


def _beside(sketch: Sequence[str], texts: Iterable[str]) -> Iterator[str]:
    """The sketch with paragraphs to its right, each wrapped by itself."""
    room = max(width() - len(sketch[0]) - 3, 24)
    words = [line for text in texts for line in textwrap.wrap(text, room)]
    blank = " " * len(sketch[0])
    for number in range(max(len(sketch), len(words))):
        left = sketch[number] if number < len(sketch) else blank
        right = words[number] if number < len(words) else ""
        yield f"{left}   {right}".rstrip()


def details(scene: Scene) -> Iterator[str]:
    """Lines: the sketch, then what the scene is, what it asks, and the numbers that it expects."""
    yield from _beside(thumbnail(scene, font_for(sys.stdout.encoding)), (scene.name, scene.title))
    yield ""
    sections = (
        ("purpose", scene.purpose),
        ("source", scene.source),
        ("tags", ", ".join(scene.tags)),
        ("question", question(scene)),
        ("bodies", " ".join(filter(None, (bodies_in_words(scene), unlike_materials(scene), idealisation(scene))))),
        (
            "tolerances",
            ", ".join(f"{key.replace('_', ' ')} {value:g}" for key, value in tolerances_of(scene, are_half_planes(scene)).items())
            or "none: nothing is judged",
        ),
        *(("files", ", ".join(files)) for files in [list(_companions(scene))] if files),
        *(("expected", text) for text in expected_in_words(scene) or ["no number"]),
    )
    for head, text in sections:
        yield from textwrap.wrap(text, max(width(), 40), initial_indent=f"{head:<12}", subsequent_indent=" " * 12)


def _companions(scene: Scene) -> dict[str, str]:
    """What a scene of the library reads besides its own file."""
    return scene_companions(scene.name) if scene.name in scene_names() else {}


def expected_in_words(scene: Scene) -> list[str]:
    """One sentence for each expected number."""
    return [
        f"{one.quantity.replace('_', ' ')} = {one.value:.9g} to {one.tolerance:g}, {one.engine}: {one.source}"
        for one in scene.expected
    ]


def record(scene: Scene) -> dict[str, Any]:
    """A scene as JSON: what it is, what it expects, what it asks."""
    content = scene.model_dump(mode="json")
    first = ("name", "title", "purpose", "source", "tags", "expected", "tolerances")
    return {
        **{key: content[key] for key in first},
        "question": question(scene),
        "files": list(_companions(scene)),
        "scene": {key: value for key, value in content.items() if key not in first},
    }
