"""Edges and what is said of their uncertainty: honest against half-plane theory, and not absurdly large."""

import functools

import numpy as np
import pytest

import semi_analytic
from halfplane_fe import SolverSettings
from halfplane_fe.edges import contact_edge, contact_edges, contact_uncertainty, stick_edges, stick_uncertainty
from halfplane_fe.visible import _slow_rim
from meshes import MeshSettings
from problems import fe_run
from scenes import SurfaceState, load_scene
from tolerances import check

MESH = MeshSettings(element_size=1 / 16, edge_element_size=1 / 60)
SCENES = ("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper")
EDGES = ("contact", "stick")
EVERY = pytest.mark.parametrize("edge", EDGES)


@functools.cache
def errors_and_uncertainties(name, edge, mesh=MESH):
    """Both (n_steps - 1, 2), in surface elements."""
    answer = fe_run(load_scene(name), mesh, SolverSettings(steps_per_cycle=48))
    exact = semi_analytic.solve(answer.scene, x=[0.0], time=answer.time)
    error = np.abs(getattr(answer, f"{edge}_edges") - getattr(exact, f"{edge}_edges"))
    element = answer.settings["element_size"]
    return error[1:] / element, getattr(answer, f"{edge}_edge_uncertainty")[1:] / element


def share_honest(error, uncertainty):
    """Share of the instants at which both edges are within their uncertainty."""
    return float(np.mean(np.all(error <= uncertainty, axis=1)))


@EVERY
@pytest.mark.parametrize("name", SCENES)
def test_uncertainty_is_honest_and_not_absurd(name, edge):
    error, uncertainty = errors_and_uncertainties(name, edge)
    assert share_honest(error, uncertainty) >= 0.95
    check(f"{edge} edge uncertainty", float(np.median(uncertainty)))
    assert np.all(uncertainty > 0)


@EVERY
def test_a_fifth_of_it_would_fail_that_test(edge):
    assert (
        min(
            share_honest(error, uncertainty / 5) for error, uncertainty in (errors_and_uncertainties(name, edge) for name in SCENES)
        )
        < 0.95
    )


@pytest.mark.slow
@EVERY
@pytest.mark.parametrize("name", [*SCENES, "phase-45", "near-sliding", "motor", "harmonics", "tiny-slip", "compound-curvature"])
def test_uncertainty_is_honest_on_the_default_mesh(name, edge):
    assert share_honest(*errors_and_uncertainties(name, edge, MeshSettings())) >= 0.95


def test_nothing_sticks_nothing_is_said():
    x = np.linspace(-1, 1, 41)
    closed = np.abs(x) < 0.91
    none = np.zeros_like(closed)
    assert np.isnan(stick_uncertainty(x, (none, none), closed, (-0.92, 0.92), (np.nan, np.nan), (0.01, 0.01))).all()


@pytest.mark.parametrize("share", [0.02, 0.3, 0.5, 0.77, 0.98])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_form_that_every_smooth_edge_has_is_found_exactly(share, side):
    """p = (E*/2) beta sqrt(d) inside, g = (2/3) beta d^(3/2) outside, from the two nodes around the edge."""
    modulus, beta, spacing = 3.0, 0.7, 0.01
    inside, outside = share * spacing, (1 - share) * spacing
    pressure, gap = modulus / 2 * beta * np.sqrt(inside), 2 / 3 * beta * outside**1.5
    found = contact_edge(side * 1.0, pressure, side * (1.0 + spacing), gap, modulus)
    assert found == pytest.approx(side * (1.0 + inside), abs=1e-12)


def test_a_known_contact_edge_lies_within_its_uncertainty_wherever_it_falls():
    """Exact nodal values of Hertz: pressure sqrt(a^2 - x^2)/2, gap from a on."""
    x = np.linspace(-1.5, 1.5, 121)
    for a in np.linspace(0.9, 0.95, 23):
        closed = np.abs(x) < a
        outside = np.maximum(np.abs(x), a)
        gap = (outside * np.sqrt(outside**2 - a**2) - a**2 * np.arccosh(outside / a)) / 2
        pressure = np.sqrt(np.maximum(a**2 - x**2, 0.0)) / 2
        found = contact_edges(x, pressure, gap, closed, 1.0)
        uncertainty = contact_uncertainty(x, pressure, closed, found)
        assert np.all(np.abs(np.array(found) - [-a, a]) <= uncertainty)
        assert max(uncertainty) < 0.6 * (x[1] - x[0])


def test_few_nodes_are_the_whole_contact_uncertain():
    x = np.linspace(-1, 1, 41)
    closed = np.abs(x) < 0.11
    assert contact_uncertainty(x, closed * 1.0, closed, (-0.12, 0.12)) == (0.24, 0.24)


def test_creep_and_narrow_slip_zones_widen_the_uncertainty():
    x = np.linspace(-1, 1, 81)
    contact, of_contact = (-0.91, 0.91), (0.004, 0.004)
    closed = np.abs(x) < 0.91

    def uncertainty(seen, law):
        edges = stick_edges(x, seen, closed, contact)
        return stick_uncertainty(x, (seen, law), closed, contact, edges, of_contact)

    wide, wider, narrow = (np.abs(x) < width for width in (0.51, 0.31, 0.86))
    step = x[1] - x[0]
    assert uncertainty(wide, wide) == pytest.approx((step, step))
    assert uncertainty(wide, wider) == pytest.approx((step + 0.2, step + 0.2))  # the law has nodes sliding from 0.31 on
    assert uncertainty(narrow, narrow) == pytest.approx((0.91 - 0.8625 + 0.004,) * 2)  # two nodes slide: perhaps none does
    assert uncertainty(closed, closed) == pytest.approx((step, step))


OPEN, STICK, FORWARD = SurfaceState.OPEN, SurfaceState.STICK, SurfaceState.SLIP_FORWARD


@pytest.mark.parametrize(
    ("sliding", "fast", "sticks"),
    [
        pytest.param([17, 18], [], [17, 18], id="slow rim"),
        pytest.param([17, 18], [18], [], id="fast rim"),
        pytest.param([14, 15, 17], [17], [14, 15, 17], id="one fast of three, with gaps"),
        pytest.param([15, 16, 17], [17], [], id="one fast of three, without"),
        pytest.param([10, 18], [], [], id="slow, and not at the rim alone"),
        pytest.param([1, 17, 18], [1], [17, 18], id="fast on the other side"),
        pytest.param([13], [], [], id="slow, too far inside"),
    ],
)
def test_a_slow_rim_sticks(sliding, fast, sticks):
    """Just past the end of forward slip, where theory has no slip, the mesh's error keeps the outermost nodes sliding slowly."""
    law = np.full(20, STICK, dtype=np.int8)
    law[[0, 19]], law[sliding] = OPEN, FORWARD
    moved, quick = (np.isin(np.arange(20), nodes) for nodes in (sliding, fast))
    assert sorted(_slow_rim(law, moved, quick)) == sticks


@pytest.mark.slow
def test_worst_stick_edge_of_the_paper_is_within_an_element():
    answer = fe_run(load_scene("hertz-paper"), MeshSettings(), SolverSettings())
    exact = semi_analytic.solve(answer.scene, x=[0.0], time=answer.time)
    cycle = answer.last_cycle
    off = np.abs(answer.stick_edges - exact.stick_edges)[cycle] / answer.settings["element_size"]
    assert off.max() < 1.0
