"""Theory's own largest values: independent of the points and instants of what stands beside
them.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import reports
import semi_analytic
from reports.comparison import compare
from scenes import ContactSolution, Scene, load_scene
from semi_analytic import largest_values

FIRST_TABLE = (
    "largest_pressure",
    "largest_half_width",
    "largest_slip",
    "dissipation",
    "dissipation_density_peak",
)

# A layer under a block of a few tenths of its contact: the points of a mesh of these bodies all lie
# inside theory's stick zone.
THIN_LAYERS = {
    "name": "thin-layers",
    "material": {
        "lower": {"young_modulus": 20e3, "poisson_ratio": 0.45},
        "upper": {"young_modulus": 210e3, "poisson_ratio": 0.3},
    },
    "profile": {"kind": "hertz", "radius": 1000.0},
    "bodies": {
        "lower": {"kind": "block", "width": 10.0, "height": 0.3},
        "upper": {"kind": "block", "width": 10.0, "height": 5.0},
    },
    "friction": {"coefficient": 0.5},
    "load": {"kind": "polygon", "initial_loading": [[60.0, 0.0], [60.0, 18.0]]},
}


# Functions on [0, 1] that are largest at 0.31234, or at the rim, their largest value, and how often
# a search may evaluate them: a smooth one takes the first places and three rounds, of which the
# last changes nothing.
SEARCHED_FUNCTIONS = {
    "smooth": (lambda x: np.cos(3 * (x - 0.31234)), 1.0, 4),
    "kink": (lambda x: 1 - np.abs(x - 0.31234), 1.0, 12),
    "skew kink": (lambda x: 1 - np.where(x < 0.31234, 1e-3, 5.0) * np.abs(x - 0.31234), 1.0, 12),
    "root": (lambda x: 1 - np.sqrt(np.abs(x - 0.31234)), 1.0, 17),
    "rim": (lambda x: x, 1.0, 3),
}


@pytest.mark.parametrize("name", SEARCHED_FUNCTIONS)
def test_search_for_a_largest_value_ends_once_it_is_found(name: str) -> None:
    function, largest, most_calls = SEARCHED_FUNCTIONS[name]
    calls = []

    def counted(x: np.ndarray) -> np.ndarray:
        calls.append(x)
        return function(x)

    found, _ = largest_values._largest_value_and_place(counted, np.array([0.0, 1.0]))
    assert found == pytest.approx(largest, rel=1e-10, abs=0)
    assert len(calls) <= most_calls


def on_points(scene: Scene, x: np.ndarray, steps: int) -> ContactSolution:
    """What stands in for a finite-element answer: theory on the points and instants of some
    mesh.
    """
    path = scene.load.path()
    end = path.initial_loading[-1].end
    initial = np.linspace(path.start, end, 9)[1:]
    if path.period is None:
        time = initial
    else:
        time = np.concatenate(
            [initial, path.cycle_start + path.period * np.linspace(0.0, 2.0, 2 * steps + 1)[1:]]
        )
    return dataclasses.replace(semi_analytic.solve(scene, x=x, time=time), engine="halfplane_fe")


def theory_values(scene: Scene, x: np.ndarray, steps: int) -> dict[str, float]:
    """Key of a metric of the first table -> theory's value in it beside a result on the points
    x.
    """
    points_answer = on_points(scene, x, steps)
    reference = dataclasses.replace(points_answer, engine="semi_analytic")
    comparison = compare(reference, points_answer)
    values = {key: comparison.metric(key).amounts[0] for key in FIRST_TABLE}
    values["edge_tension"] = semi_analytic.extremes(reference).edge_tension
    return values


@pytest.mark.parametrize("name", ["hertz-paper", "nowell-hills"])
def test_theory_has_the_same_largest_values_beside_any_mesh(name: str) -> None:
    scene = load_scene(name)
    beside_coarse = theory_values(scene, np.linspace(-1.31, 1.27, 24), 16)
    beside_fine = theory_values(scene, np.linspace(-1.2, 1.23, 61), 24)
    assert beside_fine == pytest.approx(beside_coarse, rel=1e-9, abs=0.0)
    assert min(beside_fine.values()) > 0


def test_largest_slip_is_that_of_theorys_contact_where_every_point_sticks() -> None:
    """Slip at the edge of contact at constant P: (A f/pi) int arccosh(a/a(eta)) d eta from P - Q/f
    to P.
    """
    scene = Scene.model_validate(THIN_LAYERS)
    points_answer = on_points(scene, np.linspace(-0.9, 0.9, 31), 0)  # theory sticks within 1.16 mm
    comparison = compare(
        semi_analytic.solve(scene, x=points_answer.x, time=points_answer.time), points_answer
    )
    theory, measured = comparison.metric("largest_slip").amounts
    modulus = 1 / ((1 - 0.45**2) / 20e3 + (1 - 0.3**2) / 210e3)
    load = 60.0
    friction = 0.5
    nodes, weights = np.polynomial.legendre.leggauss(40)
    # eta = P (1 - u^2) takes the root out of the arccosh at the edge.
    largest = math.sqrt(18.0 / friction / load)
    u = largest * (1 + nodes) / 2
    integral = largest / 2 * np.sum(weights * np.arccosh(1 / np.sqrt(1 - u**2)) * 2 * load * u)
    assert theory == pytest.approx(2 / modulus * friction / math.pi * integral, rel=1e-9)
    assert theory == pytest.approx(3.0557e-4, rel=1e-4)
    assert measured < 1e-12


def test_largest_slip_agrees_with_a_fine_grid_of_points_and_instants() -> None:
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    time = path.cycle_start + path.period * np.linspace(1.0, 2.0, 8001)
    x = np.array([1.0205, 1.021, 1.0215])
    answer = semi_analytic.solve(scene, x=x, time=time, fields=("slip", "state"))
    touching = answer.state != 0
    low = np.min(answer.slip, axis=0, where=touching, initial=np.inf)
    high = np.max(answer.slip, axis=0, where=touching, initial=-np.inf)
    sampled = float(np.max(high - low))
    extremum = semi_analytic.extremes(answer).slip
    assert sampled <= extremum * (1 + 1e-12)
    assert extremum == pytest.approx(sampled, rel=3e-4)


def test_score_of_few_points_shows_theorys_half_width() -> None:
    """Elements far larger than the contact: its edges by these points say nothing of theory."""
    scene = load_scene("hertz-normal")
    solution = semi_analytic.solve(scene)
    half_width = semi_analytic.extremes(solution).half_width
    load = solution.normal_load.max()
    for spacing in (60.0, 6.0, 0.04):
        x = spacing * half_width * np.arange(-40, 41)
        if spacing > 1:
            pressure = np.where(x == 0, load / (spacing * half_width), 0.0)
        else:
            pressure = (
                2
                * load
                / (math.pi * half_width)
                * np.sqrt(np.maximum(1 - (x / half_width) ** 2, 0))
            )
        report = reports.score(x, pressure, None, scene=scene, loads=([load], [0.0]))
        assert report.metric("largest_half_width").amounts[0] == pytest.approx(half_width, rel=1e-9)
        if spacing > 1:
            assert "too few" in report.metric("largest_half_width").note


def test_on_many_straight_steps_the_largest_values_are_those_about_the_place_on_the_path(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As by a search between the edges of all steps; only the edges nearby are looked at."""
    scene = load_scene("hertz-paper")
    path = scene.load.path()
    cycle = np.linspace(path.cycle_start, path.cycle_start + path.period, 241)
    time = np.concatenate([[path.start], cycle, cycle[1:] + path.period])
    steps = semi_analytic.solve(scene, x=[0.0], time=time, straight_steps=True)
    with monkeypatch.context() as everywhere_looked_at:
        everywhere_looked_at.setattr(largest_values, "_PLACES_AT_FIRST", 10_000)
        everywhere = semi_analytic.extremes(steps)
    looked_at: list[int] = []
    search = largest_values._largest_value_and_place

    def counted(values: Any, marks: Any, *arguments: Any, **keywords: Any) -> Any:
        looked_at.append(len(marks))
        return search(values, marks, *arguments, **keywords)

    monkeypatch.setattr(largest_values, "_largest_value_and_place", counted)
    nearby = semi_analytic.extremes(steps)
    assert min(looked_at) < 30
    assert nearby.dissipation_density == pytest.approx(everywhere.dissipation_density, rel=1e-9)
    assert nearby.slip == pytest.approx(everywhere.slip, rel=1e-9)


@pytest.mark.parametrize("name", ["hertz-paper", "time-series", "compound-curvature"])
def test_no_value_next_to_the_largest_is_above_it(name: str) -> None:
    """Rounds that happen to find nothing larger end no search: a parabola's vertex is in each."""
    steady = semi_analytic.solve(name, x=0.0, fields=())
    found = semi_analytic.extremes(steady, ("dissipation_density",))
    widths = found.half_width * np.geomspace(1e-6, 1e-2, 60)
    places = found.dissipation_density_place + np.concatenate([-widths[::-1], widths])
    beside = semi_analytic.solve(
        name, x=places, time=steady.time[steady.last_cycle[[0, -1]]], fields="dissipation_density"
    )
    assert beside.dissipation_density.max() <= found.dissipation_density * (1 + 1e-11)


def test_kinks_that_differ_by_round_off_do_not_take_the_place_of_the_largest_value() -> None:
    """Two edges at turning points were one but for round-off. Places between them had one value,
    three local maxima, and the search ended there: W(x) was 0.27 % too small.
    """
    load = {
        "kind": "ellipse",
        "mean_normal_load": 10.840272967917176,
        "normal_amplitude": 10.232424823752282,
        "mean_tangential_load": 1.0389912466292215,
        "tangential_amplitude": 1.5732980198657127,
        "phase_degrees": 57.79881102042099,
    }
    wedge = {"kind": "wedge", "tip_radius": 1000.0, "tip_half_length": 0.18366797710424315}
    scene = load_scene("hertz-paper").vary(
        profile=wedge, load=load, friction={"coefficient": 0.6071221734730615}
    )
    solution = semi_analytic.solve(scene, x=np.linspace(-1.0, 1.0, 401))
    largest = semi_analytic.extremes(solution, ("dissipation_density",))
    assert largest.dissipation_density >= solution.dissipation_density.max()
    assert largest.dissipation_density == pytest.approx(3.034553e-05, rel=1e-6)
