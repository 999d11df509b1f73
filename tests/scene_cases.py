"""Scenes that only tests ask: one load history or one body more, each with its expected numbers and
their sources.

They are files of tests/scenes, in the form of the library's.
"""

from __future__ import annotations

from pathlib import Path

from scenes import Scene, load_scene

FOLDER = Path(__file__).parent / "scenes"
CASES = tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def scene_of(name: str) -> Scene:
    """The scene of this name: of the tests if they have it, else of the library."""
    if name in CASES:
        return load_scene(FOLDER / f"{name}.toml")
    return load_scene(name)
