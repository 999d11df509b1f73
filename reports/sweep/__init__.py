"""Sweeps: a scene, axes over its keys, and the figures of every point in a store that outlives whoever fills it.

from reports import sweep

table = sweep.run("study.toml", "out/study")  # starts, or goes on where it was left
heights = table.numbers("height")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports.sweep.index import Table, read_index
    from reports.sweep.running import run
    from reports.sweep.study import Study, load_study

__all__ = ["Study", "Table", "load_study", "read_index", "run"]

_HOME = {
    "Study": "reports.sweep.study",
    "Table": "reports.sweep.index",
    "load_study": "reports.sweep.study",
    "read_index": "reports.sweep.index",
    "run": "reports.sweep.running",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'reports.sweep' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
