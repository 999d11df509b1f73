"""Sweeps: a scene, axes over its keys, and the figures of every point in a store that outlives
whoever fills it.

    study.py     the study file, its axes and arithmetic, its points with the addresses of their
                 results
    solving.py   what can be kept of a point; what a worker does with it; how uncertain its figures
                 are
    running.py   processes or a dask cluster, and the loop that hands out points and stores results
    store.py     one file for each result, the table
    page.py      how far a sweep is; its page, with a figure of each quantity
    commands.py  `halfplane sweep`, `sweep status`, `sweep report`

from reports.studies import sweep

table = sweep.run("study.toml", "out/study")  # starts, or resumes
heights = table["height"]
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from reports.studies.sweep.running import run
    from reports.studies.sweep.store import read_index
    from reports.studies.sweep.study import Study, load_study

__all__ = ["Study", "load_study", "read_index", "run"]
_HOME = {"Study": "study", "load_study": "study", "read_index": "store", "run": "running"}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'reports.studies.sweep' has no attribute {name!r}")
    return getattr(import_module(f"reports.studies.sweep.{_HOME[name]}"), name)
