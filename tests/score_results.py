"""Results to score: half-plane theory's answer, what CalculiX really wrote (tests/data/README.md),
bodies with known tractions.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pandas as pd

import semi_analytic
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read_result
from reports.scoring.surface import SurfaceResult
from scenes import ContactSolution, load_scene

X = np.linspace(-1.3, 1.3, 105)
DATA = Path(__file__).parent / "data"
HALF = 2.0


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


def written(table: pd.DataFrame, path: Path, **how: Any) -> Path:
    """The table as CSV with every digit."""
    table.to_csv(path, index=False, **how)
    return path


def result(source: str | Path, **mapping: Any) -> SurfaceResult:
    """The tractions of a file, by its name in tests/data or its whole path."""
    return read_result(DATA / source, Mapping.model_validate(mapping))


def edited(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """A copy of a data file with pieces of text replaced."""
    text = (DATA / name).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / name).write_text(text)
    return folder / name


# ---------------------------------------------------------------------- bodies with known tractions
def pressure_at(x: np.ndarray) -> np.ndarray:
    return 300 * np.sqrt(np.maximum(1 - x**2, 0.0))


def shear_at(x: np.ndarray) -> np.ndarray:
    return 0.25 * pressure_at(x) * (1 + 0.5 * x)


def bodies(deep: float = 0.0) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """A block below y = 0 and a pad above, of quadrangles or, where deep, of one layer of bricks;
    nodes shuffled.
    """
    x = np.linspace(-HALF, HALF, 41)
    planes = (0.0, deep) if deep else (0.0,)
    points = np.array(
        [
            (place, y, z)
            for low in (-0.5, 0.0)
            for z in planes
            for y in (low, low + 0.5)
            for place in x
        ]
    )
    corners = np.array([[k, k + 1, k + 42, k + 41] for k in range(40)])
    layers = [82 * len(planes) * body + 82 * np.arange(len(planes)) for body in (0, 1)]
    lower, upper = layers
    cells = np.concatenate(
        [
            np.concatenate([corners + start for start in lower], axis=1),
            np.concatenate([corners + start for start in upper], axis=1),
        ]
    )
    order = np.random.default_rng(1).permutation(len(points))
    return points[np.argsort(order)], [("hexahedron" if deep else "quad", order[cells])]


def fields(points: np.ndarray, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """At every point, wherever it lies: what is not the surface must not be taken."""
    decay = scale * np.exp(-3 * np.abs(points[:, 1]))
    return pressure_at(points[:, 0]) * decay, shear_at(points[:, 0]) * decay


def tractions(points: np.ndarray, scale: float = 1.0) -> dict[str, np.ndarray]:
    p, q = fields(points, scale)
    return {"CPRESS": p, "CSHEAR1": q, "CSLIP1": 1e-3 * points[:, 0]}


def mesh(deep: float = 0.0, **named: Any) -> meshio.Mesh:
    """The bodies, with tractions at their points unless others are named."""
    points, cells = bodies(deep)
    return meshio.Mesh(
        points, cells, {name: make(points) for name, make in named.items()} or tractions(points)
    )


def check(surface: SurfaceResult, scale: float = 1.0) -> None:
    np.testing.assert_allclose(surface.x, np.linspace(-HALF, HALF, 41), atol=1e-12)
    np.testing.assert_allclose(
        surface.pressure[-1], scale * pressure_at(surface.x), rtol=1e-12, atol=1e-9
    )
    np.testing.assert_allclose(
        surface.shear[-1], scale * shear_at(surface.x), rtol=1e-12, atol=1e-9
    )
