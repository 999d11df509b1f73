"""Scene files to scenes, with errors that name file, key, value and rule."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from scenes.errors import InputError
from scenes.files import keys_of, parsed_toml
from scenes.frozen import did_you_mean, refusal, validated
from scenes.scene import Scene

_LIBRARY = resources.files("scenes") / "library"


def scene_names() -> tuple[str, ...]:
    """Names of the scenes in the library, in alphabetical order.

    >>> "hertz-paper" in scene_names()
    True
    """
    return tuple(sorted(entry.name.removesuffix(".toml") for entry in _LIBRARY.iterdir() if entry.name.endswith(".toml")))


def scene_text(name: str) -> str:
    """The text of a library scene, to start an own one from; InputError for an unknown name."""
    if name not in scene_names():
        raise InputError(_unknown_scene(name))
    return (_LIBRARY / f"{name}.toml").read_text(encoding="utf-8")


def scene_companions(name: str) -> dict[str, str]:
    """File name and text of what a library scene reads besides its own file.

    >>> list(scene_companions("time-series"))
    ['time-series.csv']
    """
    files = [entry for entry in _LIBRARY.iterdir() if entry.name.startswith(f"{name}.") and not entry.name.endswith(".toml")]
    return {entry.name: entry.read_text(encoding="utf-8") for entry in files}


def scene_schema() -> dict[str, Any]:
    """JSON schema of a scene file, for editors."""
    return Scene.model_json_schema()


def load_scene(source: str | Path) -> Scene:
    """The scene of a library name or of a file (.toml or .json).

    Raises
    ------
    InputError
        One sentence that names file, key, value and rule.

    >>> load_scene("hertz-paper").friction.coefficient
    1.0
    """
    path, name = Path(source), str(source)
    if name in scene_names():
        data, folder = parsed_toml(scene_text(name)), Path(str(_LIBRARY))
    elif not path.suffix and not path.exists():
        raise InputError(_unknown_scene(name))
    elif path.suffix not in (".toml", ".json"):
        if path.is_dir():
            raise InputError(f"{path}: this is a folder; name the scene file in it, which ends in .toml or .json")
        raise InputError(f"{path}: a scene file ends in .toml or .json, not in {path.suffix or 'nothing'!r}")
    else:
        data = keys_of(path, "the scene file", "put long tables into a CSV file beside it, named by the key `file`")
        if not data:
            raise InputError(f"{path}: the scene file is empty; `halfplane init FILE.toml` writes one to start from")
        name, folder = path.stem, path.parent
    try:
        # Strict, so that "1.0" and true are no numbers; as JSON, where strict still lets 1 be a float and a list a tuple.
        text = json.dumps({"name": name} | data, default=str)
        return Scene.model_validate_json(text, strict=True, context={"folder": folder, "units": data.get("units")})
    except ValidationError as faults:
        raise InputError(f"{path}: {refusal(faults, data, Scene)}") from faults
    except RecursionError as reason:  # JSON with brackets by the hundred
        raise InputError(f"{path}: its tables are nested too deeply") from reason


def scene_of(scene: Scene | str | Path) -> Scene:
    """A scene as its own check leaves it, or read from a library name or a path: the door of functions that take either.

    Raises
    ------
    InputError
        As `load_scene`; for what is no scene, or does not pass its check.

    >>> scene_of("hertz-paper") == load_scene("hertz-paper")
    True
    """
    return load_scene(scene) if isinstance(scene, str | Path) else validated(scene, Scene)


def _unknown_scene(name: str) -> str:
    hint = did_you_mean(name, scene_names()) or f" the library has {', '.join(scene_names())};"
    return f"{name}: no such scene or file;{hint} `halfplane init FILE.toml` writes one to start from"
