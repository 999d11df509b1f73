"""Between nodes: what W has from edges that go from node to node, by Hertz' compression and over
edges in many places.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from unittest import mock

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import between_nodes, scales
from halfplane_fe.between_nodes import Excess, excess
from halfplane_fe.contact import ContactProblem, InterfaceState, nodal
from halfplane_fe.mirror import half
from halfplane_fe.run import PathRun
from meshes import MeshSettings
from scenes import Scene, load_scene
from scenes.array_types import Array


def coarse_pair(scene: Scene) -> scales._CoarsePair:
    return scales._CoarsePair(
        scene,
        scales.largest_load(scene),
        scales.contact_modulus(*vars(scene.material).values()),
        Counter(),
    )


@pytest.fixture(scope="module")
def compression() -> tuple[ContactProblem, list[InterfaceState], Array]:
    """Hertz' contact through 15 to 29 elements of one size: the states at many loads, and by how
    much delta exceeds Hertz'.

    That is over h^2/R, the change of d(delta)/dP from one element to the next times that of P.
    """
    with mock.patch.object(scales, "_ELEMENTS", 40):
        pair = coarse_pair(load_scene("hertz-normal"))
        size = scales._fitting_size(pair)
        problem = pair.problem(size, half(pair.faces(size)), tangential=False)
    loads = np.linspace(0.5, 1.0, 400)
    states = [problem.at_rest()]
    for load in loads:
        states.append(problem.equilibrium(states[-1], 0.0, (load, 0.0))[0])
    radius = pair.scene.profile.radius
    load = loads * pair.load
    half_width = np.sqrt(4 * load * radius / (np.pi * pair.modulus))
    exact = -2 / (np.pi * pair.modulus) * load * (np.log(half_width) - 0.5)
    over = np.array([state.approach for state in states[1:]]) * pair.load / pair.modulus - exact
    over *= radius / (size / 40) ** 2
    return problem, states[1:], over


def test_the_chords_of_the_compression_are_those_of_the_formula(
    compression: tuple[ContactProblem, list[InterfaceState], Array],
) -> None:
    problem, states, over = compression
    chords = []
    for state in states:
        node = int(np.flatnonzero(state.closed)[-1])
        _, pressure, _, gap = nodal(state.values)
        by_load = nodal(problem.rates(state.state, 2)[0])
        way = pressure[node] / by_load[1][node], -gap[node + 1] / by_load[3][node + 1]
        chords.append(
            float(between_nodes._chord(problem, node, False, way[0] / sum(way), sum(way))[0])
        )
    # The line in P is the datum's; 30 elements that end are a little stiffer than a half-plane of
    # them.
    load = np.array([state.normal_load for state in states])
    left, all_of_it = (
        curve - np.polyval(np.polyfit(load, curve, 2), load)
        for curve in (over - np.array(chords), over)
    )
    assert np.ptp(all_of_it) > 0.05
    assert np.sqrt(np.mean(left**2)) < 0.05 * np.sqrt(np.mean(all_of_it**2))


def at_many_places(name: str, count: int = 9) -> Iterator[tuple[PathRun, float, float]]:
    """Coarse runs on elements of one size whose edges stand elsewhere in each: the run, (h/a)^2,
    and the unit of its energies.
    """
    pair = coarse_pair(load_scene(name))
    size = scales._fitting_size(pair)
    for larger in np.linspace(0.92, 1.06, count):
        problem, run = scales._coarse_run(pair, size * larger, scales._COARSE_STEPS)
        pressed = max(run.states, key=lambda state: state.normal_load)
        half_width = float(np.diff(scales._contact_edges(problem, [pressed]))[0, 0] / 2)
        yield run, (scales._ELEMENTS * half_width) ** -2.0, pair.load**2 / pair.modulus


@pytest.mark.parametrize(
    ("name", "left"),
    [("cattaneo-mindlin", 0.15), ("hertz-paper", 0.25), ("flat-rounded-paper", 0.4)],
)
def test_w_scatters_less_over_the_places_of_the_edges(name: str, left: float) -> None:
    """Measured over 21 places, rms over W (h/a)^2: 1.04 and 0.10, 0.81 and 0.11, 2.99 and 0.80."""
    exact = semi_analytic.solve(load_scene(name), x=[0.0], fields=("dissipation",)).dissipation
    before = []
    after = []
    scatter = []
    for run, square, unit in at_many_places(name):
        work = float(run.cycle_density[-1].sum()) * unit
        excess = run.excess[-1]
        assert excess.edges == 2  # of stick and of contact, on the half that is solved
        assert run.column("dissipation")[run.cycle_starts[-1] :].sum() * unit == pytest.approx(
            work, rel=1e-12
        )
        assert run.column("loop")[run.cycle_starts[-1] :].sum() * unit == pytest.approx(
            work, rel=1e-9
        )
        before.append(((work + excess.value * unit) / exact - 1) / square)
        after.append((work / exact - 1) / square)
        scatter.append(excess.scatter * unit / exact / square)
    rms_before, rms_after = (np.sqrt(np.mean(np.square(errors))) for errors in (before, after))
    assert rms_after < left * rms_before
    assert np.mean(scatter) == pytest.approx(rms_before, rel=0.4)  # told by each run alone


def test_edges_that_are_not_between_quadratic_nodes_of_one_size_are_left_alone() -> None:
    def counted(**options: object) -> list[int]:
        excesses: list[Excess] = []

        def spy(problem: ContactProblem, states: list[InterfaceState]) -> Excess:
            excesses.append(excess(problem, states))
            return excesses[-1]

        with mock.patch("halfplane_fe.run.excess", spy):
            halfplane_fe.solve("cattaneo-mindlin", **options)
        return [record.edges for record in excesses]

    # two revolutions of the coarse run, two of the answer
    assert counted(mesh=MeshSettings.coarse()) == [2] * 4
    assert counted(mesh=MeshSettings(element_size=0.05, edge_element_size=0.05, order=1)) == [
        2,
        2,
        0,
        0,
    ]
