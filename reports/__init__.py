"""Comparison of two solutions, the page about it, and the command line.

`compare`, `score` and `write` are all that a script needs. The names are loaded when they are first asked for:
`halfplane --help` must not wait for matplotlib.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports import score
    from reports.certificates import Certificate
    from reports.comparison import Comparison, compare
    from reports.verdicts import Metric
    from reports.writing import write

__all__ = ["Certificate", "Comparison", "Metric", "compare", "score", "write"]

_HOME = {
    "Certificate": "reports.certificates",
    "Comparison": "reports.comparison",
    "Metric": "reports.verdicts",
    "compare": "reports.comparison",
    "score": "reports.score",
    "write": "reports.writing",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'reports' has no attribute {name!r}")
    module = import_module(_HOME[name])
    # `score` is a package that can be called; Python gives it this name as soon as anything in it is imported.
    return module if name == "score" else getattr(module, name)


def __dir__() -> list[str]:
    return sorted(__all__)
