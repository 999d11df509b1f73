"""Which code and which packages computed a result: part of its address, and checked on every worker."""

from __future__ import annotations

import ast
import platform
from functools import cache
from importlib.metadata import version

from scenes.files import source_digest, source_files

# What numbers depend on: the engines and what they stand on, all of it; of `reports` what a worker's task imports.
_PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe")
_TASK = "reports.sweep.solving"
# How a comparison shows itself moves no number.
_SHOWN = ("reports.comparison.words", "reports.notebook")
_LIBRARIES = ("numpy", "scipy", "scikit-fem", "gmsh", "pydantic")


@cache
def code_versions() -> dict[str, str]:
    """Digest of the code and versions of the packages that numbers depend on, as this process found them when it first asked."""
    code = source_digest(*_PACKAGES, *task_modules())[:16]
    return {"code": code, "python": ".".join(platform.python_version_tuple()[:2])} | {name: version(name) for name in _LIBRARIES}


def difference(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """What differs, in words; "" where nothing does.

    >>> difference({"code": "a", "numpy": "2.0"}, {"code": "a", "numpy": "1.9"})
    'numpy is 2.0 here and 1.9 there'
    """
    names = sorted(ours.keys() | theirs.keys())
    return ", ".join(
        f"{name} is {ours.get(name, 'missing')} here and {theirs.get(name, 'missing')} there"
        for name in names
        if ours.get(name) != theirs.get(name)
    )


@cache
def task_modules() -> tuple[str, ...]:
    """Modules of `reports` that the figures of a point depend on: what its task imports, what these import, and so on."""
    source_files(*_SHOWN)  # what is left out has this name still
    found: set[str] = set()
    waiting = {_TASK}
    while waiting:  # each turn finds one module more, and there are so many files
        name = waiting.pop()
        found.add(name)
        waiting |= _imported(name) - found - {*_SHOWN}
    return tuple(sorted(found))


def _imported(name: str) -> set[str]:
    """Modules of `reports` that a module imports anywhere in it, but for the checker of types."""
    (file,) = source_files(name)
    parts = [part for part in ast.parse(file.read_bytes()).body if not ast.unparse(part).startswith("if TYPE_CHECKING:")]
    names: set[str] = set()
    for node in (node for part in parts for node in ast.walk(part)):
        match node:
            case ast.Import(names=imported):
                names |= {one.name for one in imported}
            case ast.ImportFrom(module=str(module), names=imported):  # `from a import b`: b may be a module or a name in a
                names |= {module, *(f"{module}.{one.name}" for one in imported)}
    root = source_files(_TASK)[0].parents[2]
    found = set()
    for one in names:
        place = root.joinpath(*one.split("."))
        if one.startswith("reports.") and place.with_suffix(".py").is_file():
            found.add(one)
        elif one.startswith("reports.") and (place / "__init__.py").is_file():
            found.add(f"{one}.__init__")  # the file alone: of what else is in the package, only what is imported
    return found
