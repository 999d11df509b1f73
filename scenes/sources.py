"""By which source files an answer was computed: part of the address of whatever is stored."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from scenes.errors import InputError


def source_files(*names: str) -> tuple[Path, ...]:
    """Source files of modules, and of packages with all that is in them.

    Raises
    ------
    InputError
        Where a module is missing, or is there without its source.

    >>> [path.name for path in source_files("scenes.sources")]
    ['sources.py']
    """
    found: list[Path] = []
    for name in names:
        try:
            spec = find_spec(name)
        except ModuleNotFoundError:
            spec = None
        files = [] if spec is None or spec.origin is None else [Path(spec.origin)]
        for folder in (spec and spec.submodule_search_locations) or ():
            files = sorted(Path(folder).rglob("*.py"))
        if not files or any(file.suffix != ".py" or not file.is_file() for file in files):
            raise InputError(f"{name}: this installation lacks the module's source file; install halfplane again")
        found += files
    return tuple(found)


@cache
def source_digest(*names: str) -> str:
    """SHA-256 of these files, names and contents, as this process found them when it first asked."""
    digest = hashlib.sha256()
    for path in source_files(*names):
        content = path.read_bytes()
        digest.update(f"{path.name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()
