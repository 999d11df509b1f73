"""Scenes to scene files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from scenes.bounded import TEXT, TOML, in_words
from scenes.errors import InputError


def write_keys(path: Path, keys: Mapping[str, Any]) -> None:
    """Write a table of keys as .toml or .json, whole or not at all.

    Raises
    ------
    InputError
        One sentence: for another suffix, for more than the reader would take back, for what can't be written.
    """
    if path.suffix not in (".toml", ".json"):
        raise InputError(f"{path}: a scene file ends in .toml or .json, not in {path.suffix or 'nothing'!r}")
    is_json = path.suffix == ".json"
    content = (json.dumps(keys, ensure_ascii=False, indent=1) if is_json else toml_text(keys)).encode()
    most = TEXT if is_json else TOML
    if len(content) > most:
        more = "" if is_json else "; save it as .json"
        raise InputError(f"{path}: the scene takes {in_words(len(content))}, and at most {in_words(most)} would be read{more}")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    except OSError as reason:
        raise InputError(f"{path}: the scene can't be written: {reason.strerror or reason}") from reason
    finally:
        with suppress(OSError):
            part.unlink()


def toml_text(keys: Mapping[str, Any]) -> str:
    """Keys as TOML: numbers, words and lists first, then tables and lists of tables.

    >>> print(toml_text({"load": {"way_in": [[1.0, 0.0]], "kind": "polygon"}, "cycles": 6}))
    cycles = 6
    <BLANKLINE>
    [load]
    way_in = [[1.0, 0.0]]
    kind = "polygon"
    <BLANKLINE>
    """
    return "\n".join(_lines(keys, "")).lstrip("\n") + "\n"


def _lines(keys: Mapping[str, Any], inside: str) -> Iterator[str]:
    tables = {key: value if isinstance(value, list) else [value] for key, value in keys.items() if _is_table(value)}
    for key in keys:
        if key not in tables:
            # Words, numbers and lists of JSON are those of TOML, but for one control character.
            yield f"{key} = {json.dumps(keys[key], ensure_ascii=False)}".replace("\x7f", "\\u007f")
    for key, each in tables.items():
        for table in each:
            if isinstance(keys[key], list):
                yield from ("", f"[[{inside}{key}]]")
            elif not table or not all(map(_is_table, table.values())):
                yield from ("", f"[{inside}{key}]")
            yield from _lines(table, f"{inside}{key}.")


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or (isinstance(value, list) and bool(value) and isinstance(value[0], dict))
