"""Bodies with known tractions on their face, as meshes to be written in other programs' forms."""

from pathlib import Path

import meshio
import numpy as np

from reports.scoring.mapping import Mapping
from reports.scoring.reading import read

HALF = 2.0


def pressure_at(x):
    return 300 * np.sqrt(np.maximum(1 - x**2, 0.0))


def shear_at(x):
    return 0.25 * pressure_at(x) * (1 + 0.5 * x)


def bodies(deep=0.0):
    """A block below y = 0 and a pad above, of quadrangles or, where deep, of one layer of bricks; nodes shuffled."""
    x, heights = np.linspace(-HALF, HALF, 41), np.array([-0.5, 0.0])
    points, cells = [], []
    for bottom in (heights, heights + 0.5):
        grid = {}
        for z in (0.0, deep)[: 2 if deep else 1]:
            for k, y in enumerate(bottom):
                for i, place in enumerate(x):
                    grid[i, k, z] = len(points)
                    points.append((place, y, z))
        for i in range(40):
            corners = [(i, 0), (i + 1, 0), (i + 1, 1), (i, 1)]
            cells.append([grid[*c, z] for z in (0.0, deep)[: 2 if deep else 1] for c in corners])
    order = np.random.default_rng(1).permutation(len(points))
    return np.array(points)[np.argsort(order)], [("hexahedron" if deep else "quad", order[np.array(cells)])]


def fields(points, scale=1.0):
    """At every point, wherever it lies: what is not the surface must not be taken."""
    x, y = points[:, 0], points[:, 1]
    decay = scale * np.exp(-3 * np.abs(y))
    return pressure_at(x) * decay, shear_at(x) * decay


def mesh(deep=0.0, **named):
    points, cells = bodies(deep)
    return meshio.Mesh(points, cells, point_data={name: make(points) for name, make in named.items()})


def result(path, **mapping):
    return read(Path(path), Mapping.model_validate(mapping), None)


def check(found, scale=1.0, rtol=1e-12):
    assert len(found.x) == 41
    np.testing.assert_allclose(found.x, np.linspace(-HALF, HALF, 41), atol=1e-12)
    np.testing.assert_allclose(found.pressure[-1], scale * pressure_at(found.x), rtol=rtol, atol=1e-9)
    np.testing.assert_allclose(found.shear[-1], scale * shear_at(found.x), rtol=rtol, atol=1e-9)


def scalars():
    return {"CPRESS": lambda x: fields(x)[0], "CSHEAR1": lambda x: fields(x)[1], "CSLIP1": lambda x: 1e-3 * x[:, 0]}
