"""Which code and which packages computed a result: part of its address, and checked on every worker."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

# What numbers depend on: the engines, what they stand on, and the comparison. Pages and the command line are not among it.
_PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe")
_COMPARISON = (
    "budget", "certificates", "comparison", "convergence", "definition", "definitions", "judging", "ladders", "metrics", "sampling",
    "verdicts",
)  # fmt: skip
_SWEEP = ("batching", "evaluating", "figures", "solving", "uncertainty")
_LIBRARIES = ("numpy", "scipy", "scikit-fem", "gmsh", "pydantic")


@cache
def code_versions() -> dict[str, str]:
    """Digest of the code and versions of the packages that numbers depend on, as this process found them when it first asked."""
    return {"code": _digest(), "python": ".".join(platform.python_version_tuple()[:2])} | {
        name: version(name) for name in _LIBRARIES
    }


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


def _digest() -> str:
    digest = hashlib.sha256()
    reports = Path(str(files("reports")))
    paths = [path for name in _PACKAGES for path in sorted(Path(str(files(name))).glob("*.py"))]
    paths += [path for stem in _COMPARISON for path in sorted(reports.glob(f"{stem}*.py"))]
    paths += [reports / "sweep" / f"{stem}.py" for stem in _SWEEP]
    for path in paths:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]
