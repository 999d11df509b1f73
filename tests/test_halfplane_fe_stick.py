"""Stick zones of finite elements: of unlike bodies by the law alone, permanent stick by one
definition.
"""

from __future__ import annotations

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import answer as answers
from halfplane_fe import answer_uncertainty
from halfplane_fe.between_nodes import NO_ZONE
from halfplane_fe.reported_states import law_states
from halfplane_fe.stick_by_slip import ends_by_slip
from meshes import MeshSettings
from scenes import (
    STICK,
    Elastic,
    Friction,
    Hertz,
    Materials,
    PolygonLoad,
    Scene,
    TimeSeriesLoad,
    load_scene,
)

RADIUS = 1000.0
LOAD = 1e-3
FINER = MeshSettings(edge_element_size=1 / 80)

# Goodman's limit of small f and beta: beta K(c/a) = f K(sqrt(1 - c^2/a^2)), K the complete elliptic
# integral. By beta/f.
GOODMAN = {0.5: 0.9851714310094, 1.0: 1 / np.sqrt(2), 2.0: 3 - 2 * np.sqrt(2)}


def on_rubber(beta: float) -> Materials:
    """A soft incompressible body, shear modulus 1, below one of Poisson's ratio 0, with Dundurs'
    constant beta.

    Plane strain, kappa = 3 - 4 nu: beta = [mu_u (kappa_l - 1) - mu_l (kappa_u - 1)]/[mu_u (kappa_l
    + 1) + mu_l (kappa_u + 1)], so that kappa_u = 3 and kappa_l = 1 + 4e leave -beta = (2 - 4 e
    mu)/(4 + (2 + 4 e) mu).
    """
    e = 1e-4
    mu = (2 - 4 * beta) / (4 * e + beta * (2 + 4 * e))
    stiff = Elastic(young_modulus=2 * mu, poisson_ratio=0.0)
    return Materials(lower=Elastic(young_modulus=2 * (1.5 - e), poisson_ratio=0.5 - e), upper=stiff)


def pressed(beta: float, friction: float) -> Scene:
    """Two unlike bodies pressed together without a tangential load."""
    load = TimeSeriesLoad(rows=[(0.0, LOAD / 2, 0.0), (1.0, LOAD, 0.0)], repeats=False)
    return Scene(
        name="pressed",
        material=on_rubber(beta),
        profile=Hertz(radius=RADIUS),
        friction=Friction(coefficient=friction),
        load=load,
    )


@pytest.mark.parametrize(
    ("beta", "friction", "expected"),
    [
        (0.05, 0.05, GOODMAN[1.0]),
        pytest.param(0.05, 0.1, GOODMAN[0.5], marks=pytest.mark.slow),
        pytest.param(0.05, 0.025, GOODMAN[2.0], marks=pytest.mark.slow),
        pytest.param(0.2, 0.12, 0.272, marks=pytest.mark.slow),
    ],
)
def test_stick_edge_of_unlike_bodies_that_are_only_pressed(
    beta: float, friction: float, expected: float
) -> None:
    answer = halfplane_fe.solve(pressed(beta, friction), mesh=FINER)
    assert abs(answer.settings["dundurs"]["beta"]) == pytest.approx(beta)
    np.testing.assert_array_equal(answer.state, law_states(answer.states))
    # Growing in proportion: all instants are one state in another size, and each is known to the
    # distance of two nodes.
    late = answer.normal_load > 0.5 * LOAD
    share = answer.stick_half_width[late] / answer.contact_half_width[late]
    assert float(np.median(share)) == pytest.approx(expected, abs=5e-3)
    uncertainty = answer.stick_edge_uncertainty[-1] / answer.contact_half_width[-1]
    assert np.all(
        np.abs(np.abs(answer.stick_edges[-1] / answer.contact_half_width[-1]) - expected)
        <= uncertainty
    )
    # A node in the slip zone is reported to stick only where it has not moved in its increment.
    by_law = np.stack([state.node_states for state in answer.states])
    overruled = (answer.state == STICK) & (by_law != STICK)
    slip = np.abs(np.diff(answer.slip, axis=0, prepend=answer.slip[:1]))
    assert slip[overruled].max(initial=0.0) <= 1e-8 * slip.max()


def cattaneo_mindlin(share: float) -> Scene:
    """Constant P and Q between +-share f P."""
    friction = 0.3
    limit = share * friction * LOAD
    body = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    return Scene(
        name="cattaneo-mindlin",
        material=Materials(upper=body, lower=body),
        profile=Hertz(radius=RADIUS),
        friction=Friction(coefficient=friction),
        load=PolygonLoad(initial_loading=[(LOAD, 0.0), (LOAD, limit)], cycle=[(LOAD, -limit)]),
        cycles=3,
    )


@pytest.mark.parametrize(
    ("share", "mesh"),
    [(0.9, MeshSettings.coarse()), pytest.param(0.9, MeshSettings(), marks=pytest.mark.slow)],
)
def test_permanent_stick_is_the_intersection_of_the_stick_zones_of_the_last_cycle(
    share: float, mesh: MeshSettings
) -> None:
    answer = halfplane_fe.solve(cattaneo_mindlin(share), mesh=mesh)
    left, right = answer.stick_edges[answer.last_cycle].T
    assert answer.permanent_stick_half_width == pytest.approx(
        (right.min() - left.max()) / 2, rel=1e-12
    )
    expected = semi_analytic.solve(answer.scene).permanent_stick_half_width
    assert answer.permanent_stick_half_width == pytest.approx(
        expected, abs=0.05 * answer.settings["element_size"]
    )


def test_an_instant_whose_nodes_move_next_to_nothing_does_not_narrow_the_permanent_stick() -> None:
    """Between unlike bodies single increments label nodes slip that move by 1e-9 to 1e-5 of the
    largest range of slip.
    """
    answer = halfplane_fe.solve(load_scene("unlike-beta-fifth"), mesh=MeshSettings.coarse())
    cycle = answer.last_cycle
    range_of_slip = np.ptp(answer.slip[cycle], axis=0)
    always_closed = np.all(answer.state[cycle] > 0, axis=0)
    stand_still = always_closed & (range_of_slip <= 1e-5 * range_of_slip.max())
    outermost = np.abs(answer.x[stand_still]).max()
    assert answer.permanent_stick_half_width >= outermost
    # The stick zone of one of the instants is narrower.
    assert np.nanmin(answer.stick_edges[cycle][:, 1]) < outermost


@pytest.mark.parametrize(
    ("name", "mesh"),
    [
        ("cattaneo-mindlin", MeshSettings.coarse()),
        ("hertz-paper", MeshSettings.coarse()),
        ("flat-rounded-paper", MeshSettings.coarse()),
        pytest.param("flat-rounded-paper", MeshSettings(), marks=pytest.mark.slow),
    ],
)
def test_slip_beyond_the_permanent_stick_zone_places_its_ends_where_no_load_does(
    name: str, mesh: MeshSettings, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (answers, answer_uncertainty):
        monkeypatch.setattr(module, "permanent_stick_zone", lambda _run: NO_ZONE)
    answer = halfplane_fe.solve(name, mesh=mesh)
    expected = semi_analytic.solve(answer.scene, x=[0.0]).permanent_stick_half_width
    error = abs(answer.permanent_stick_half_width - expected)
    stated = answer.uncertainties["permanent_stick_half_width"]
    spacing = mesh.edge_element_size / 2
    # 19 of 20 are covered: the last of these misses by a fifth.
    assert error <= 1.25 * stated < 2 * spacing
    # The flat's end is near: its power of slip is no straight line on the coarse mesh.
    assert error < (1.1 if "flat" in name else 0.1) * spacing


def test_slip_tells_no_end_where_nodes_open_or_creep_goes_on_far_beyond_the_zone() -> None:
    x = np.arange(-12.0, 13.0)
    t = np.maximum(np.abs(x) / 3.2, 1.0)
    slip_range = t * np.sqrt(t**2 - 1) - np.arccosh(t)  # of Cattaneo and Mindlin
    by_states = np.array([-3.5, 3.5])
    ends = ends_by_slip(x, slip_range, by_states)
    np.testing.assert_allclose(ends.places, [-3.2, 3.2], rtol=1e-4)
    opens = np.where(x > 5, np.nan, slip_range)
    assert np.isnan(ends_by_slip(x, opens, by_states).places).tolist() == [False, True]
    shifted = np.array([-3.5, 6.5])
    assert np.isnan(ends_by_slip(x, slip_range, shifted).places).tolist() == [False, True]
    curved = np.maximum(np.abs(x) - 3.2, 0.0) ** 2
    assert np.all(ends_by_slip(x, curved, by_states).uncertainty > 2 * ends.uncertainty)
