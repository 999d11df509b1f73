"""Results to score, made from half-plane theory's own answer: exact but for the fault that a test plants."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd

import semi_analytic
from scenes import ContactSolution, load_scene

X = np.linspace(-1.3, 1.3, 105)


@cache
def exact(name: str = "hertz-paper", steps: int = 25, points: int = len(X)) -> ContactSolution:
    """A whole cycle of a scene (of a path that just ends: all of it), the second."""
    scene = load_scene(name)
    path = scene.load.path()
    if path.period is None:
        time = np.linspace(path.start, path.cycle_start, steps)
    else:
        time = path.cycle_start + path.period * np.linspace(1, 2, steps)
    return semi_analytic.solve(scene, x=np.linspace(-1.3, 1.3, points), time=time)


def rows(solution: ContactSolution) -> pd.DataFrame:
    """One row for each instant and point, in the project's own convention."""
    points = len(solution.x)
    columns = {
        "time": np.repeat(solution.time, points),
        "P": np.repeat(solution.normal_load, points),
        "Q": np.repeat(solution.tangential_load, points),
        "x": np.tile(solution.x, len(solution.time)),
        "pressure": solution.pressure.ravel(),
        "shear": solution.shear.ravel(),
        "slip": solution.slip.ravel(),
    }
    return pd.DataFrame(columns)


def written(table: pd.DataFrame, path: Path, **how: object) -> Path:
    """The table as CSV with every digit."""
    table.to_csv(path, index=False, **how)
    return path
