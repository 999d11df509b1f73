"""Stress in the half-planes: closed forms of the literature, quadrature of the tractions, laws of
elasticity, refusals.
"""

import math
from functools import cache

import numpy as np
import pytest
from random_theory import Tensions, _errors_of_tension, _tension_over_friction

import semi_analytic
from scenes import InputError, Scene, load_scene
from semi_analytic import edge_tension, grid, largest_values, stress, subsurface
from semi_analytic.answer_by_memory import memory_at
from semi_analytic.bulk_and_tilt import PathLoads, path_loads_and_contact
from semi_analytic.quadrature import graded_nodes
from semi_analytic.subsurface import (
    _curve_parts,
    _edge_tensions_of_solution,
    _solutions_with_tractions,
    _stress_by_sine_series,
    _tension_of_narrow_slip_zone,
)
from semi_analytic_cases import extreme


def mcewen(x, depth, a, p0):
    """s_xx, s_yy, s_xy (y upwards) below a Hertz contact: McEwen (1949), as Johnson (1985), (4.49),
    has it.
    """
    b = a * a - x * x + depth * depth
    root = np.hypot(b, 2 * x * depth)
    # The smaller of the two squares from their product, (x z)^2, without cancellation.
    larger = (root + np.abs(b)) / 2
    smaller = (x * depth) ** 2 / larger
    m2 = np.where(b >= 0, larger, smaller)
    n2 = np.where(b >= 0, smaller, larger)
    m = np.sqrt(m2)
    n = np.sign(x) * np.sqrt(n2)
    share = (depth**2 + n2) / (m2 + n2)
    return np.stack(
        [
            -p0 / a * (m * (1 + share) - 2 * depth),
            -p0 / a * m * (1 - share),
            p0 / a * n * (m2 - depth**2) / (m2 + n2),
        ],
        -1,
    )


def places(a):
    """Points at the face, next to it, next to the edges and deep, (n,) each."""
    rng = np.random.default_rng(7)
    x = np.concatenate(
        [rng.uniform(-3, 3, 200), 1 + rng.uniform(-1e-3, 1e-3, 50), np.full(12, -1.0)]
    )
    return a * x, -a * np.concatenate(
        [10 ** rng.uniform(-9, 0.7, 200), 10 ** rng.uniform(-9, -3, 50), 10.0 ** -np.arange(12)]
    )


def test_hertz_is_mcewen():
    """Measured 4e-12 of the peak pressure, from the face to six half-widths below it."""
    a = 1.0
    p0 = 2 * 90.62286500739786 / math.pi
    x, y = places(a)
    stresses = stress("hertz-normal", x, y, 1.0)[0]
    assert np.abs(stresses[:, :3] - mcewen(x, -y, a, p0)).max() < 1e-10 * p0
    np.testing.assert_allclose(stresses[:, 3], 0.3 * (stresses[:, 0] + stresses[:, 1]))


@pytest.mark.parametrize("share", [0.1, 0.6, 0.95])
def test_tension_at_the_trailing_edge_of_cattaneo_and_mindlin(share):
    """2 f p0 sqrt(Q/(f P)) at the left edge of the lower body and the right edge of the upper one;
    pressed by as much opposite.
    """
    scene = load_scene("cattaneo-mindlin")
    load = scene.load.cycle[0][0]
    f = scene.friction.coefficient
    scene = scene.vary(load={"cycle": [[load, share * f * load], [load, -share * f * load]]})
    pressed = semi_analytic.solve(scene, x=0.0, time=2.0)
    a = float(pressed.contact_half_width[0])
    p0 = float(pressed.pressure[0, 0])
    tension = 2 * f * p0 * math.sqrt(share)
    values, uncertain = edge_tension(scene, [2.0, 3.0])
    turned = tension * np.array([[1, -1], [-1, 1]])
    # after the reversal slip goes the other way
    np.testing.assert_allclose(values, [turned, -turned], rtol=1e-12)
    assert np.all(uncertain < 2e-11 * p0)
    np.testing.assert_array_equal(edge_tension(pressed, 2.0)[0], values[:1])
    for body, sign in (("lower", 1), ("upper", -1)):
        edges = stress(scene, [-a, a], 0.0, 2.0, body=body)[0]
        # a itself is rounded
        np.testing.assert_allclose(edges[:, 0], [sign * tension, -sign * tension], rtol=1e-7)


CASES = [
    ("hertz", "ellipse"),
    ("hertz", "polygon"),
    ("long flat", "polygon"),
    ("polynomial", "rows"),
]
SLOW = [
    ("short flat", "ellipse"),
    ("|x|^3.5", "harmonics"),
    ("compound", "harmonics"),
    ("table", "ellipse"),
]


@pytest.mark.parametrize(
    ("profile", "load"), [*CASES, *(pytest.param(*case, marks=pytest.mark.slow) for case in SLOW)]
)
def test_stress_is_the_integral_of_the_tractions(profile, load):
    """Flamant's point forces below, principal value on the face: p and q by another route,
    quadrature graded to their roots.
    """
    scene = extreme(profile, load)
    all_times = semi_analytic.solve(scene, x=[0.0], fields=())
    for time in all_times.time[
        [len(all_times.time) // 5, len(all_times.time) * 4 // 7, len(all_times.time) - 9]
    ]:
        contact, snapshot = memory_at(scene, np.array([time]))
        a = float(contact.half_width(snapshot.load[0]))
        knots = [
            float(contact.half_width(end)) for line in _curve_parts(snapshot, 0) for end in line[:2]
        ]
        knots += [b for b in contact.corner_half_widths if b < a]
        x = a * np.array([-1.7, -0.93, -0.4, 0.1, 0.61, 0.87, 1.2])
        y = -a * np.array([0.2, 0.5, 0.11, 2.0, 0.3, 0.08, 0.15])
        stresses = stress(scene, x, y, time)[0]
        face = stress(scene, x, 0.0, time)[0]
        for k, (point, height) in enumerate(zip(x, y, strict=True)):
            marks = np.unique(np.clip([-a, a, point, *knots, *(-knot for knot in knots)], -a, a))
            t, weight = (part.ravel() for part in graded_nodes(marks[:-1], marks[1:]))
            t = t[weight > 0]
            weight = weight[weight > 0]
            at = semi_analytic.solve(
                scene, x=np.unique([*t, point]), time=time, fields=("pressure", "shear")
            )
            p, q = (np.interp(t, at.x, values[0]) for values in (at.pressure, at.shear))
            traction = [
                float(np.interp(point, at.x, values[0])) for values in (at.pressure, at.shear)
            ]
            size = float(at.pressure.max())
            across = point - t
            r2 = across**2 + height**2
            radial = -2 / math.pi * (-p * height + q * across) / r2**2 * weight
            expected = [
                np.sum(radial * across**2),
                np.sum(radial * height**2),
                np.sum(radial * across * height),
            ]
            assert np.abs(stresses[k, :3] - expected).max() < 1e-10 * size
            inside = abs(point) < a
            tangential = np.sum(
                weight * (q - traction[1] * inside) / np.where(across == 0, np.inf, -across)
            )
            tangential += traction[1] * math.log((a - point) / (a + point)) if inside else 0.0
            expected = [-traction[0] + 2 / math.pi * tangential, -traction[0], traction[1]]
            # the quotient of the principal value keeps no more
            assert np.abs(face[k, :3] - expected).max() < 2e-9 * size


def test_the_upper_body_is_the_mirror_image_with_opposite_shear():
    scene = load_scene("hertz-paper")
    x, y = places(1.0)
    lower = stress(scene, x, y, [9.0, 11.0])
    upper = stress(scene, -x, -y, [9.0, 11.0], body="upper")
    # Turned by half a circle the pair is itself again, loads included.
    np.testing.assert_allclose(upper, lower, atol=1e-12 * np.abs(lower).max())


@pytest.mark.parametrize(
    "name", ["hertz-paper", pytest.param("flat-rounded-paper", marks=pytest.mark.slow)]
)
def test_stress_from_tractions_is_that_of_the_memory_curve(name):
    """The way of bulk stress and tilt, on scenes that do not need it: the tension within its
    uncertainty, 1e-2 at most.
    """
    scene = load_scene(name)
    time = semi_analytic.solve(scene, x=0.0, fields=()).time[[30, 60, 90, 150, 210, 290]]
    pairs = _solutions_with_tractions(scene, time)
    x = np.array([-1.3, -0.4, 0.0, 0.6, 1.1, -1.5, 1.5])
    y = np.array([-0.2, -0.05, -2.0, -0.3, -0.01, 0.0, 0.0])
    exact = edge_tension(scene, time)[0]
    inside = stress(scene, x, y, time)
    profile = path_loads_and_contact(scene)[1]
    p0 = max(float(answer.pressure.max()) for answer, _ in pairs)
    for k, (answer, row) in enumerate(pairs):
        tensions, uncertain = _edge_tensions_of_solution(answer, row, profile)
        assert np.abs(tensions - exact[k, 0]).max() < uncertain.min() < 1e-2 * p0
        np.testing.assert_allclose(
            _stress_by_sine_series(answer, row, profile, x, y, 1.0),
            inside[k, :, :3],
            atol=2e-4 * p0,
        )


def test_with_bulk_stress_the_tension_is_that_of_two_pressures():
    """q = f p(x; a) less the pressure of the stick zone, moved by e = eps R/f: by hand; above it
    bulk stress alone.
    """
    load = 3.0
    shear = 1.8
    eps = 0.2
    f = 1.0
    scene = Scene.model_validate(
        {
            "material": {"young_modulus": 2.0, "poisson_ratio": 0.0},
            "profile": {"kind": "hertz", "radius": 1.0},
            "friction": f,
            "load": {
                "kind": "time_series",
                "rows": [(0, 0, 0), (1, load, 0), (2, load, shear)],
                "bulk_stress_lower": [0, 0, 2 * eps],
            },
        }
    )
    a = math.sqrt(4 * load / math.pi)
    c = a * math.sqrt(1 - shear / (f * load))
    p0 = 2 * load / (math.pi * a)
    e = eps / f
    left, right = (
        2 * f * p0 / a * (a - (far - math.sqrt(far**2 - c**2))) for far in (a + e, a - e)
    )
    values, uncertain = edge_tension(scene, [1.0, 2.0])
    assert np.all(uncertain < 2e-3 * p0)
    np.testing.assert_allclose(values[0], 0, atol=1e-12)
    np.testing.assert_allclose(
        values[1], [[left + 2 * eps, -right + 2 * eps], [-left, right]], atol=2e-4
    )
    # too few places to take the answer's own tractions
    sparse = semi_analytic.solve(scene, x=0.0, time=[1.0, 2.0])
    np.testing.assert_allclose(edge_tension(sparse, [1.0, 2.0])[0], values, rtol=1e-12, atol=1e-12)
    deep = [
        stress(scene, [5.0], [depth], 2.0, body=body)[0, 0, 0]
        for body, depth in (("lower", -1e3), ("upper", 1e3))
    ]
    np.testing.assert_allclose(deep, [2 * eps, 0], atol=1e-4)


@cache
def flat_pad_on_grids():
    """A scene of a flat pad under bulk stress, and its solution on grids."""
    scene = Scene.model_validate(
        {
            "material": {"young_modulus": 2.0, "poisson_ratio": 0.0},
            "profile": {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 2.0},
            "friction": 0.6,
            "load": {
                "kind": "ellipse",
                "mean_normal_load": 0.5,
                "tangential_amplitude": 0.12,
                "bulk_stress_lower": {"mean": 0.02, "amplitude": 0.05, "phase_degrees": 60.0},
            },
        }
    )
    answer = semi_analytic.solve(scene)
    assert answer.work.counts["grids"] > 0
    return scene, answer


def test_on_grids_the_tension_is_known_at_each_edge_and_does_not_hang_on_the_points():
    """A flat pad under bulk stress. Half to eight tenths of f times the largest pressure was stated
    of a solution's own 200 points at every edge. Where slip has just begun 0.22 is missing beside
    grids of three times the cells, also of points beside the edges: at most 0.15 was stated.
    """
    scene, answer = flat_pad_on_grids()
    time = answer.time[answer.last_cycle[[0, 40, 80, 120]]]
    of_answer, uncertainty_of_answer = edge_tension(answer, time)
    of_scene, uncertainty_of_scene = edge_tension(scene, time)
    largest_friction = scene.friction.coefficient * answer.pressure.max()
    np.testing.assert_array_less(np.abs(of_answer - of_scene), uncertainty_of_answer)
    assert np.median(np.abs(of_answer - of_scene)) < 9e-3 * largest_friction
    # the edge beside which slip has just begun is known least: each edge has its own uncertainty
    assert uncertainty_of_scene.min() < 0.005 * largest_friction
    assert 0.22 * largest_friction < uncertainty_of_scene.max() < 0.6 * largest_friction
    assert uncertainty_of_answer.min() < 0.005 * largest_friction


def test_a_slip_zone_within_a_cell_is_estimated_by_what_it_leaves_beside_it():
    """p = K sqrt(d) at the distance d from an edge; Q has turned, and a zone of width z slips back:
    the tension changes by 2 F sqrt(z), F = f K |s - r|. A cell that sticks has the mean of q.
    """
    cell_width = 0.01
    factor = 3.0  # f K
    ratio_before = 1.0
    places = np.linspace(0.0, 1.0, 200_001)[1:]
    friction_limit = factor * np.sqrt(places)
    tension_of_sliding = 2 / np.pi * friction_limit / places  # over a length of 1
    distances = cell_width * (np.arange(40) + 0.5)
    for width in (0.003, 0.03, 0.3) * np.array(cell_width):
        change = (
            -(1 + ratio_before)
            * factor
            * (np.sqrt(places) - np.sqrt(np.maximum(places - width, 0)))
        )
        ratio = ratio_before + change / friction_limit
        ratio_of_cells = [
            np.mean(ratio[np.abs(places - distance) < cell_width / 2]) for distance in distances
        ]
        tension = 2 * (1 + ratio_before) * factor * math.sqrt(width)
        tension_of_cells = np.mean(
            tension_of_sliding * (ratio_before - np.interp(places, distances, ratio_of_cells))
        )
        estimate = _tension_of_narrow_slip_zone(
            distances, np.array(ratio_of_cells), cell_width, places, tension_of_sliding
        )
        assert tension - tension_of_cells < estimate < 8 * (tension - tension_of_cells)
    # all sticks or slips alike, or the cell at the edge slips back already
    for ratio in (np.full(40, 0.3), np.full(40, 1.0), np.where(distances < cell_width, -1.0, 0.9)):
        estimate = _tension_of_narrow_slip_zone(distances, ratio, 0.0, places, tension_of_sliding)
        assert estimate == 0.0


def test_coarse_grids_follow_a_solution_once_and_the_contact_is_not_solved_for_its_edges(
    monkeypatch,
):
    """Whatever instants are asked for together, each has the same uncertainty."""
    scene, answer = flat_pad_on_grids()
    calls = []
    for name in ("friction_ratio_on_grids", "solve"):
        function = getattr(subsurface, name)
        monkeypatch.setattr(
            subsurface,
            name,
            lambda *given, name=name, function=function, **options: (
                calls.append(name) or function(*given, **options)
            ),
        )
    subsurface._coarse_ratio_by_solution.pop(answer, None)
    time = answer.time[answer.last_cycle[[0, 40, 80, 120]]]
    together = edge_tension(answer, time)
    apart = [edge_tension(answer, instant) for instant in time]
    assert calls == ["friction_ratio_on_grids"]
    for k in range(2):
        assert np.array_equal(together[k], np.concatenate([one[k] for one in apart]))
    calls.clear()
    stress(scene, 0.0, -0.1, time)
    assert calls == ["solve"]


def test_the_largest_values_of_an_answer_on_grids_are_found_without_a_second_solution(monkeypatch):
    """The points of an answer that was asked for nothing are those of its largest values; another
    answer of the scene has the same ones.
    """
    scene, answer = flat_pad_on_grids()
    elsewhere = semi_analytic.solve(scene, x=[0.0, 0.1], time=[2.0])
    solutions = []
    monkeypatch.setattr(
        largest_values,
        "solve",
        lambda *given, **options: solutions.append(given) or semi_analytic.solve(*given, **options),
    )
    largest_values._extremes_at_default_points.cache_clear()
    largest = semi_analytic.extremes(answer)
    assert not solutions
    assert largest == semi_analytic.extremes(elsewhere)
    assert solutions == [(scene,)]


def test_ratio_and_stick_edges_of_grids_are_those_of_each_grid_by_itself():
    """Linear between the cells in contact, constant beyond them, as `numpy.interp` has it; edges of
    stick from cell to cell. Of three instants on two grids, the last without contact.
    """
    random = np.random.default_rng(3)
    middles = np.array([[0.0, 1.0, 2.0, 3.0, 4.0], [-0.5, 0.5, 1.5, 2.5, 3.5]])
    places = np.sort(np.append(random.uniform(-2, 6, 40), middles.ravel()))
    states = np.full((3, 2, 5), grid.OPEN, dtype=np.int8)
    states[0, 0, 1:4] = [grid.STICK, grid.SLIP_FORWARD, grid.STICK]
    states[0, 1, 2:3] = grid.SLIP_REVERSE
    states[1, :, :] = grid.SLIP_FORWARD
    states[1, 0, 1:3] = grid.STICK
    values = np.where(states == grid.OPEN, 0.0, random.normal(size=states.shape))
    at_places = grid._between_cells(values, states != grid.OPEN, middles, places)
    edges, n_zones = grid._stick_edges_and_zones(states, middles, 1.0)
    for instant, number in np.ndindex(3, 2):
        in_contact = np.flatnonzero(states[instant, number] != grid.OPEN)
        expected = np.zeros(len(places))
        if len(in_contact):
            expected = np.interp(
                places, middles[number, in_contact], values[instant, number, in_contact]
            )
        assert np.array_equal(at_places[instant, number], expected)
    np.testing.assert_array_equal(edges[0], [[-np.inf, np.inf], [np.nan, np.nan]])
    np.testing.assert_array_equal(edges[1], [[0.5, 2.5], [np.nan, np.nan]])
    assert np.isnan(edges[2]).all()
    assert n_zones.tolist() == [[2, 0], [1, 0], [0, 0]]


def test_where_coarse_grids_do_not_follow_the_path_the_tension_has_no_uncertainty(monkeypatch):
    """Near sliding all of the coarse cells may slip; the tension of the fine ones is known."""
    _, answer = flat_pad_on_grids()
    time = answer.time[answer.last_cycle[:1]]
    values, uncertain = edge_tension(answer, time)
    assert np.isfinite(uncertain).all()

    def refuse(*_arguments):
        raise InputError("all cells slip")

    monkeypatch.setattr(subsurface, "friction_ratio_on_grids", refuse)
    monkeypatch.setattr(subsurface, "_coarse_ratio_by_solution", {})
    values_alone, unknown = edge_tension(answer, time)
    np.testing.assert_array_equal(values_alone, values)
    assert np.isnan(unknown).all()


def test_edges_of_contact_by_the_loads_are_those_of_the_solution():
    """From first touch to a later cycle; before the path they are those at its start."""
    scene, answer = flat_pad_on_grids()
    edges = subsurface._contact_edges_at(scene, answer.time)
    np.testing.assert_allclose(edges, answer.contact_edges, atol=1e-14)
    path = scene.load.path()
    before = subsurface._contact_edges_at(scene, np.array([path.start - 5.0, path.start]))
    assert np.array_equal(before[0], before[1])


def test_loads_at_any_times_are_gathered_once_for_each_segment(monkeypatch):
    """They were gathered one instant at a time."""
    scene, answer = flat_pad_on_grids()
    path_loads, _ = path_loads_and_contact(scene)
    path = path_loads.path
    in_order = answer.time[::7]
    times = np.concatenate([in_order[::-1], [path.start - 5.0]])
    calls = []
    loads_in_segment = PathLoads.loads_in_segment
    monkeypatch.setattr(
        PathLoads,
        "loads_in_segment",
        lambda *given: calls.append(1) or loads_in_segment(*given),
    )
    loads = path_loads.loads_at(times)
    # each cycle and each segment of the initial loading, and the ends that two of them share
    assert len(calls) <= 2 * (answer.work.counts["cycles_solved"] + len(path.initial_loading))
    one_by_one = [loads_in_segment(path_loads, time[None])[:, 0] for time in times[:-1]]
    one_by_one.append(loads_in_segment(path_loads, np.array([path.start]))[:, 0])
    np.testing.assert_allclose(loads, np.stack(one_by_one, axis=1), rtol=1e-13, atol=1e-16)


def test_a_time_outside_the_path_is_refused_on_grids_too():
    """It was answered as if nothing were in contact then."""
    scene, _ = flat_pad_on_grids()
    with pytest.raises(InputError, match="time: outside the load path, which runs from"):
        edge_tension(scene, scene.load.path().start - 1.0)
    once = scene.vary(
        load={
            "kind": "time_series",
            "rows": [(0, 0, 0), (1, 0.5, 0), (2, 0.5, 0.1), (3, 0.4, 0.0)],
            "bulk_stress_lower": [0, 0, 0.05, -0.05],
        }
    )
    assert "grids" in semi_analytic.solve(once, x=0.0, time=3.0).work.counts
    for ask in (
        lambda: stress(once, 0.0, 0.0, 3.5),
        lambda: edge_tension(once, 3.5),
        lambda: semi_analytic.solve(once, x=0.0, time=3.5),
    ):
        with pytest.raises(InputError, match="time: outside the load path, which runs from"):
            ask()


def test_random_theory_judges_an_edge_tension_only_by_a_reference_that_is_more_exact():
    """The limit of fine grids follows from answer and reference, and from the reference and coarser
    ones; values of which these differ by much are left out. Sliding has the tension 2 f p0.
    """
    edges = np.array([-0.3, 0.5])
    sliding = _tension_over_friction(np.array([-0.2, 0.4]), np.ones(2), edges)
    np.testing.assert_allclose(sliding, [2 * 0.2, -2 * 0.2], rtol=1e-12)

    def errors(answer, by_half_of_cells, by_half_of_points=0.01):
        values = np.zeros((1, 2, 2))
        reference = Tensions(values, values + by_half_of_points, values + by_half_of_cells)
        return _errors_of_tension(values + answer, np.full(values.shape, 0.05), reference)

    # errors of the first order: 0.3 of the answer, 0.15 and 0.1 of the reference's two grids
    in_order = errors(0.2, 0.1)
    np.testing.assert_allclose(in_order.error, 0.3)
    assert in_order.unjudged == 0
    # the reference is no more exact than the answer, between its cells or between its points
    for poor in (errors(0.2, 0.4), errors(0.2, 0.1, by_half_of_points=0.2)):
        assert (len(poor.error), poor.unjudged) == (0, 4)
