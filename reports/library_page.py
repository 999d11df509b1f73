"""The library in docs/scenes.md: one table, and the expected numbers of each scene.

    python -m reports.library_page          (part of `make publish`)

All between the two marks of the page is written again, all else stays as it is.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path

from reports.console import say
from reports.staging import replace_text
from scenes import load_scene, scene_names

_ROOT = Path(__file__).parents[1]
PAGE = _ROOT / "docs" / "scenes.md"
_TRUTHS = _ROOT / "benchmarks" / "regress.json"
BEGIN, END = "<!-- the library: written by `python -m reports.library_page` -->", "<!-- end of the library -->"


def page(before: str) -> str:
    """The page with its part on the library written again.

    Raises
    ------
    ValueError
        Where one of the marks is missing.
    """
    start, end = before.index(BEGIN), before.index(END)
    return before[:start] + "\n".join([BEGIN, "", *_library(), ""]) + before[end:]


def _library() -> Iterator[str]:
    truths = json.loads(_TRUTHS.read_text(encoding="utf-8"))
    found = [load_scene(name) for name in scene_names()]
    yield "| scene | what it is for | numbers from | dissipation, N |"
    yield "|---|---|---|---|"
    for scene in found:
        yield f"| `{scene.name}` | {_cell(scene.purpose)} | {_cell(scene.source)} | {float(truths[scene.name]['reference']):.9g} |"
    for scene in found:
        yield f"\n### {scene.name}\n"
        yield f"{scene.title}. Tags: {', '.join(f'`{tag}`' for tag in scene.tags)}.\n"
        yield "| expected | value | tolerance | of | source |"
        yield "|---|---|---|---|---|"
        for one in scene.expected:
            yield f"| {one.quantity.replace('_', ' ')} | {one.value:.9g} | {one.tolerance:g} | {one.engine} | {_cell(one.source)} |"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def main() -> int:
    """Write the page."""
    replace_text(PAGE, page(PAGE.read_text(encoding="utf-8")))
    say(f"{PAGE.name}: {len(scene_names())} scenes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
