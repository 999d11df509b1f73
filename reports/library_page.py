"""The library in docs/scenes.md: one table, and a sketch with the expected numbers for each scene; docs/scenes/ holds the sketches.

    python -m reports.library_page          (part of `make publish`)

All between the two marks of the page is written anew, all else stays as it is.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from reports.baseline import replace_text
from reports.console import say
from reports.library_sketches import svg
from scenes import Scene, load_scene, scene_names

_ROOT = Path(__file__).parents[1]
PAGE = _ROOT / "docs" / "scenes.md"
FOLDER = _ROOT / "docs" / "scenes"
_TRUTHS = _ROOT / "benchmarks" / "regress.json"
BEGIN, END = "<!-- the library: written by `python -m reports.library_page` -->", "<!-- end of the library -->"


def page(before: str) -> str:
    """The page with its part on the library written anew.

    Raises
    ------
    ValueError
        Where one of the marks is missing.
    """
    start, end = before.index(BEGIN), before.index(END)
    return before[:start] + "\n".join([BEGIN, "", *_library(), ""]) + before[end:]


def sketches() -> dict[str, str]:
    """File name -> drawing of every scene."""
    return {f"{name}.svg": svg(load_scene(name)) for name in scene_names()}


def _library() -> Iterator[str]:
    truths = json.loads(_TRUTHS.read_text(encoding="utf-8"))
    found = [load_scene(name) for name in scene_names()]
    yield "| scene | what it is for | numbers from | dissipation, N |"
    yield "|---|---|---|---|"
    for scene in found:
        yield f"| `{scene.name}` | {_cell(scene.purpose)} | {_cell(scene.source)} | {_dissipation(scene, truths)} |"
    yield "\nSketches: the gap between flat faces is exaggerated; dashed is the initial loading, dotted the limit |Q| = f P."
    for scene in found:
        yield from _section(scene)


def _dissipation(scene: Scene, truths: Mapping[str, Mapping[str, str]]) -> str:
    return f"{float(truths[scene.name]['reference']):.9g}"


def _section(scene: Scene) -> Iterator[str]:
    """Title, sketch, tags, and the expected numbers."""
    yield f"\n### {scene.name}\n"
    yield f"{scene.title}. Tags: {', '.join(f'`{tag}`' for tag in scene.tags)}.\n"
    yield f"![Bodies of {scene.name}, and its tangential over its normal load](scenes/{scene.name}.svg)\n"
    yield "| expected | value | tolerance | of | source |"
    yield "|---|---|---|---|---|"
    for one in scene.expected:
        yield f"| {one.quantity.replace('_', ' ')} | {one.value:.9g} | {one.tolerance:g} | {one.engine} | {_cell(one.source)} |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def main() -> int:
    """Write the page and the sketches; sketches of scenes that are gone go too."""
    replace_text(PAGE, page(PAGE.read_text(encoding="utf-8")))
    drawn = sketches()
    for name, text in drawn.items():
        replace_text(FOLDER / name, text)
    for path in FOLDER.glob("*.svg"):
        if path.name not in drawn:
            path.unlink()
    say(f"{PAGE.name}: {len(drawn)} scenes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
