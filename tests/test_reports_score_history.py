"""Instants found by their loads where the path goes to and fro on one line, so that each is passed more than once."""

from __future__ import annotations

import numpy as np
import pytest

from reports.score.history import matched
from reports.score.surface import SurfaceResult
from scenes import load_scene


@pytest.mark.parametrize("count", [22, 23, 26, 28, 34, 40, 56])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
@pytest.mark.parametrize("name", ["cattaneo-mindlin"])
def test_instants_stay_on_their_branch_in_one_cycle(name: str, count: int, noise: float) -> None:
    """Between equally near places the earliest is taken, and not the one that is next to a sample of the path."""
    scene = load_scene(name)
    path = scene.load.path()
    assert path.period is not None
    time = path.cycle_start + (scene.cycles - 1) * path.period + np.linspace(0, path.period, count)
    draw = np.random.default_rng(count).standard_normal((2, count))
    normal, tangential = path.at(time)
    normal, tangential = normal * (1 + noise * draw[0]), tangential + noise * np.max(normal) * draw[1]
    x = np.linspace(-1.0, 1.0, 3)
    empty = np.zeros((count, 3))
    result = SurfaceResult("loads.csv", "", x, empty, empty, normal_load=normal, tangential_load=tangential)
    off = np.diff(matched(result, scene).time) - np.diff(time)
    # Next to a turn of the loads, noise of 1e-3 moves an instant by some hundredths of the period; a branch is a third or a half.
    assert np.max(np.abs(off)) < (0.1 if noise else 0.01) * path.period
