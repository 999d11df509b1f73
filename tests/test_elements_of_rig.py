"""Finite elements under a prescribed displacement: their own U gives their own Q back."""

from __future__ import annotations

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import SolverSettings
from halfplane_fe.settings import Method
from meshes import MeshSettings
from reports.elements_of_rig import solve_rig
from scenes import InputError, PolygonLoad, Rig, Scene, load_scene
from semi_analytic.driven import ActuatorRows

MESH = MeshSettings.coarse()
SPRING = 4e-5
LOADS = [(60.0, 0.0), (90.0, 0.0), (90.0, 20.0), (75.0, 5.0), (90.0, -25.0), (100.0, 0.0)]


def blocks(load: PolygonLoad, rig: Rig) -> Scene:
    return load_scene("blocks").vary(
        load=load, rig=rig, friction=0.5, cycles=1, expected=(), tolerances={}
    )


def check_round_trip(method: Method) -> None:
    settings = SolverSettings(method=method, steps_per_cycle=4)
    times = tuple(float(k) for k in range(len(LOADS) + 1))
    given = halfplane_fe.solve(
        blocks(PolygonLoad(initial_loading=tuple(LOADS), times=times), Rig()), MESH, settings
    )
    at_rows = np.searchsorted(given.time, np.array(times) - 1e-9)
    force = given.tangential_load[at_rows]
    displacement = given.tangential_displacement[at_rows] + SPRING * force
    rows = ActuatorRows(
        np.array(times), given.normal_load[at_rows], displacement, (len(times) - 1,)
    )
    points = tuple(zip(rows.normal.tolist(), displacement.tolist(), strict=True))
    driven = PolygonLoad(initial_loading=points[1:], tangential_displacement=True)
    scene = blocks(driven, Rig(tangential_stiffness=1 / SPRING))
    found = solve_rig(scene, MESH, settings, rows=rows)
    assert len(found.residuals) < 8
    again = found.solution
    of_rows = np.searchsorted(again.time, np.array(times) - 1e-9)
    largest = float(np.max(np.abs(force)))
    assert again.tangential_load[of_rows] == pytest.approx(force, abs=1e-8 * largest)
    assert again.dissipation == pytest.approx(given.dissipation, rel=1e-7)


def test_their_own_displacements_give_their_loads_back() -> None:
    check_round_trip("active_set")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["penalty", "augmented_lagrangian"])
def test_the_other_methods_do_too(method: Method) -> None:
    check_round_trip(method)


def test_an_approach_is_refused() -> None:
    load = PolygonLoad(initial_loading=((0.01, 0.0),), tangential_displacement=True, approach=True)
    with pytest.raises(InputError, match=r"load\.approach: finite elements"):
        solve_rig(blocks(load, Rig()), MESH)
