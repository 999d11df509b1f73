"""Instants found by their loads where the path goes to and fro on one line, so that each is passed more than once."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from reports.scoring.history import matched
from reports.scoring.surface import SurfaceResult
from scenes import load_scene


@pytest.mark.parametrize(("count", "noise"), [*product([9, 14, 22, 25, 40, 59], [0.0, 1e-3]), (1000, 0.0)])
@pytest.mark.parametrize("name", ["cattaneo-mindlin", "phase-180"])
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


def test_the_initial_loading_and_three_cycles_come_one_after_the_other() -> None:
    scene = load_scene("cattaneo-mindlin")
    path = scene.load.path()
    assert path.period is not None
    cycles = path.cycle_start + np.linspace(0, 3 * path.period, 301)
    time = np.concatenate([np.linspace(path.start, path.cycle_start, 20)[:-1], cycles])
    normal, tangential = path.at(time)
    empty = np.zeros((len(time), 3))
    result = SurfaceResult("l.csv", "", np.linspace(-1, 1, 3), empty, empty, normal_load=normal, tangential_load=tangential)
    np.testing.assert_allclose(matched(result, scene).time, time, atol=1e-9)
