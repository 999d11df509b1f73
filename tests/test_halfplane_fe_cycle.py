"""Whole load paths: certificates, energy balance, steady state, steps, scale, mirror, and the work that was and was not done."""

import functools
import math
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import SolverSettings
from problems import COARSE, FEW_STEPS, fe_run, law_violations
from scenes import (
    ConvergenceError,
    Elastic,
    EllipseLoad,
    Hertz,
    Materials,
    PolygonLoad,
    Scene,
    SurfaceState,
    load_scene,
    scene_names,
)
from tolerances import check, check_order

STEEL, ALUMINIUM = Elastic(young_modulus=210e3, poisson_ratio=0.3), Elastic(young_modulus=70e3, poisson_ratio=0.33)
UNLIKE = Materials(upper=ALUMINIUM, lower=STEEL)


def scene_of(name):
    """A library scene; "..., unlike" with an upper body of aluminium."""
    scene = load_scene(name.removesuffix(", unlike"))
    return scene.vary(material=UNLIKE) if name.endswith("unlike") else scene


EVERY = pytest.mark.parametrize("name", [*scene_names(), "hertz-paper, unlike", "cattaneo-mindlin, unlike", "hertz-normal, unlike"])


# ---------------------------------------------------------------------------------- admissible: what needs no reference at all
@EVERY
def test_every_scene_runs_with_all_certificates_small(name):
    answer = fe_run(scene_of(name))
    record = answer.record
    assert record.converged
    assert set(record.certificates) >= {
        *("equilibrium", "tension", "penetration", "gap_pressure", "cone", "slip_sign", "creep", "energy_balance"),
    }
    for values in record.certificates.values():
        assert values.shape == answer.time.shape
        check("certificates", float(np.abs(values).max()))


@EVERY
def test_answer_keeps_the_laws_as_it_stands(name):
    """From the arrays that a reader sees, not from the solver's own books."""
    answer = fe_run(scene_of(name))
    for violation, size in law_violations(answer).items():
        check("open pressure" if violation == "open pressure" else "certificates", size)
    assert np.all(np.diff(answer.time) > 0)
    assert np.all(answer.contact_edges[1:, 0] < answer.contact_edges[1:, 1])


@EVERY
def test_energy_balance_over_the_path(name):
    """Work of P and Q, from the answer's own loads and rigid displacements, is stored or rubbed away: nothing is lost."""
    answer = fe_run(scene_of(name))
    mean = lambda values: (values[1:] + values[:-1]) / 2  # noqa: E731
    external = mean(answer.normal_load) * np.diff(answer.normal_approach) + mean(answer.tangential_load) * np.diff(
        answer.tangential_displacement
    )
    np.testing.assert_allclose(answer.record.energy["external"][1:], external, atol=1e-12 * np.abs(external).max())
    energy = answer.record.energy
    rest = np.cumsum(external) - np.cumsum(energy["elastic"][1:]) - np.cumsum(energy["interface"][1:])
    check("certificates", float(np.abs(rest).max() / np.abs(np.cumsum(external)).max()))
    assert np.all(energy["dissipation"] >= 0)


@pytest.mark.parametrize("name", ["cattaneo-mindlin", "hertz-paper", "motor"])
def test_dissipation_has_one_value_however_it_is_summed(name):
    """Density times surface, steps of the cycle, hysteresis loop."""
    answer = fe_run(scene_of(name))
    cycle = answer.last_cycle
    assert answer.dissipation == answer.cycle_dissipation[-1]
    assert answer.dissipation_density @ answer.condensed[0].weights == pytest.approx(answer.dissipation, rel=1e-12)
    assert answer.record.energy["dissipation"][cycle[1:]].sum() == pytest.approx(answer.dissipation, rel=1e-9)
    loop = np.trapezoid(answer.tangential_load[cycle], answer.tangential_displacement[cycle])
    check("hysteresis loop", loop / answer.dissipation - 1)


# ------------------------------------------------------------------------------------------------------------- steady state
def test_stops_when_the_cycle_repeats_and_says_so():
    answer = fe_run(load_scene("cattaneo-mindlin"))
    assert answer.steady_from == 1
    assert len(answer.cycle_dissipation) == 2
    assert answer.record.termination == "steady"
    assert answer.record.message.startswith("revolution 2 ended in the state it started from")
    assert answer.work.skipped["revolutions"][0] == answer.scene.cycles - 2
    start, end = answer.last_cycle[[0, -1]]
    np.testing.assert_allclose(answer.shear[end], answer.shear[start], atol=1e-9 * answer.pressure.max())


def test_a_cycle_too_few_is_not_called_steady():
    scene = load_scene("cattaneo-mindlin").vary(cycles=1)
    answer = fe_run(scene)
    assert answer.steady_from is None
    assert answer.record.termination == "end of path"
    assert "without a revolution that repeats" in answer.record.message
    assert "revolutions" not in answer.work.skipped


def test_a_path_that_ends_is_one_cycle():
    answer = fe_run(load_scene("hertz-normal"))
    assert (answer.steady_from, answer.record.termination) == (None, "end of path")
    assert len(answer.cycle_dissipation) == 1
    assert answer.last_cycle.tolist() == list(range(len(answer.time)))


def test_full_stick_dissipates_nothing_and_never_iterates_on_slip():
    answer = fe_run(load_scene("full-stick"))
    assert answer.dissipation == 0.0
    assert not answer.cycle_dissipation.any()
    assert not answer.dissipation_density.any()
    assert answer.work.counts["slip iterations"] == 0
    assert "slip iterations" in answer.work.skipped
    assert set(np.unique(answer.state)) == {SurfaceState.OPEN, SurfaceState.STICK}
    np.testing.assert_array_equal(answer.stick_edges, answer.contact_edges)


# ----------------------------------------------------------------------------------------------------------- work, counted
@pytest.mark.parametrize(
    ("name", "condensations", "tangential"),
    [
        ("hertz-normal", 1, False),
        ("cattaneo-mindlin", 1, True),
        ("hertz-normal, unlike", 2, True),
        ("hertz-paper, unlike", 2, True),
    ],
)
def test_work_counts(name, condensations, tangential):
    answer = fe_run(scene_of(name))
    counts, skipped = answer.work.counts, answer.work.skipped
    assert counts["condensations"] == condensations
    assert ("condensations" in skipped) == (condensations == 1)
    assert ("tangential problem" in skipped) == (not tangential)
    assert counts["steps solved"] == len(answer.time) - 1
    assert counts["contact nodes"] == len(answer.x)
    assert (
        counts["contact iterations"] >= answer.record.iterations.sum() >= counts["steps solved"]
    )  # the first counts rejected steps
    assert all(reason for _, reason in skipped.values())


def test_like_bodies_take_few_iterations():
    """Events landed on, an increment is one linear solve where no node changes between stick and slip; 1.0 to 1.5 on average."""
    for name in ("hertz-normal", "cattaneo-mindlin", "full-stick", "hertz-paper"):
        answer = fe_run(load_scene(name))
        assert answer.record.iterations.sum() <= 1.8 * answer.work.counts["steps solved"], name
        assert answer.work.counts["factorisations"] < 0.3 * answer.work.counts["linear solves"] + 60, name


# ------------------------------------------------------------------------------------------------------------------- steps
def test_constant_pressure_needs_no_steps():
    """q of a Mindlin cycle is the same in any number of increments: friction work of each is f p ds, p constant."""
    found = [
        fe_run(load_scene("cattaneo-mindlin"), COARSE, SolverSettings(steps_per_cycle=steps, step_tolerance=np.inf)).dissipation
        for steps in (8, 33, 100)
    ]
    np.testing.assert_allclose(found, found[0], rtol=1e-10)


@functools.cache
def varying(steps):
    """Nodal dissipation of the paper's second revolution with few elements, no increment halved."""
    scene = Scene(
        name="varying P",
        material=Materials(upper=STEEL, lower=STEEL),
        profile=Hertz(radius=1000.0),
        friction=load_scene("cattaneo-mindlin").friction,
        load=EllipseLoad(mean_normal_load=90, normal_amplitude=5, tangential_amplitude=25, phase_degrees=90),
        cycles=2,
    )
    mesh = replace(COARSE, element_size=1 / 8, edge_element_size=1 / 8)
    return fe_run(scene, mesh, SolverSettings(steps_per_cycle=steps, step_tolerance=np.inf))


def step_errors(steps, density):
    """Sum of the nodes' errors: with signs, single nodes that change between stick and slip at other instants hide each other."""
    weights = varying(8).condensed[0].weights
    fine = varying(1024).dissipation_density
    return [float(weights @ np.abs(density(varying(n)) - fine) / (weights @ fine)) for n in steps]


def end_of_step_density(answer):
    """Friction work of each node in the last cycle with the pressure at the end of each increment: the classical choice."""
    cycle = answer.last_cycle
    sliding = (answer.state[cycle[1:]] == SurfaceState.SLIP_FORWARD) | (answer.state[cycle[1:]] == SurfaceState.SLIP_REVERSE)
    path = np.abs(np.diff(answer.slip[cycle], axis=0))
    return answer.scene.friction.coefficient * np.sum(answer.pressure[cycle[1:]] * path * sliding, axis=0)


STEPS = (8, 16, 32, 64)


def test_step_error_is_of_second_order():
    check_order("step", [1 / n for n in STEPS], step_errors(STEPS, lambda answer: answer.dissipation_density))


def test_pressure_at_the_end_of_the_step_would_fail_that_test():
    errors = step_errors(STEPS, end_of_step_density)
    with pytest.raises(AssertionError, match="order"):
        check_order("step", [1 / n for n in STEPS], errors)


# ------------------------------------------------------------------------------------------------------- scale and mirror
def in_other_units(scene, stiffer, longer):
    """The scene with stresses and lengths in other units, and its loads with them."""
    amounts = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude")
    material = Elastic(young_modulus=210e3 * stiffer, poisson_ratio=0.3)
    return scene.vary(
        material=Materials(upper=material, lower=material),
        profile=Hertz(radius=1000.0 * longer),
        load=scene.load.vary(**{name: getattr(scene.load, name) * stiffer * longer for name in amounts}),
    )


@pytest.mark.parametrize(("stiffer", "longer"), [(1e12, 1e9), (1e-12, 1e-9), (7.0, 3.0), (2.0**40, 2.0**30)])
@pytest.mark.parametrize("tolerance", [np.inf, 2e-4])
def test_units_do_not_matter(stiffer, longer, tolerance):
    """E times 1e12, lengths times 1e9, loads as both: every number of the answer is the same but for its unit."""
    plain, settings = load_scene("hertz-paper"), replace(FEW_STEPS, step_tolerance=tolerance)
    one, other = fe_run(plain, COARSE, settings), fe_run(in_other_units(plain, stiffer, longer), COARSE, settings)
    units = {"time": 1.0, "x": longer, "pressure": stiffer, "shear": stiffer, "slip": longer, "contact_edges": longer}
    units |= {"normal_approach": longer, "tangential_displacement": longer, "dissipation_density": stiffer * longer}
    for name, unit in units.items():
        here = getattr(one, name)
        np.testing.assert_allclose(getattr(other, name) / unit, here, rtol=0, atol=1e-9 * np.abs(here).max(), err_msg=name)
    np.testing.assert_array_equal(other.state, one.state)
    assert other.dissipation == pytest.approx(one.dissipation * stiffer * longer**2, rel=1e-9)


def test_mirrored_shear_load_mirrors_the_answer():
    """Q -> -Q is phase -> phase - 180 degrees: p(x), -q(-x), -s(-x), and the same energy to the last bits."""
    plain = load_scene("hertz-paper")
    load = plain.load
    turned = {"mean_tangential_load": -load.mean_tangential_load, "phase_degrees": load.phase_degrees - 180}
    mirrored = plain.vary(load=turned)
    one, other = fe_run(plain), fe_run(mirrored)
    limit = 1e-9 * one.pressure.max()
    np.testing.assert_allclose(other.time - other.time[0], one.time - one.time[0], atol=1e-9)
    np.testing.assert_allclose(other.tangential_load, -one.tangential_load, atol=1e-9 * one.normal_load.max())
    np.testing.assert_allclose(other.pressure, one.pressure[:, ::-1], atol=limit)
    np.testing.assert_allclose(other.shear, -one.shear[:, ::-1], atol=limit)
    np.testing.assert_allclose(
        other.tangential_displacement, -one.tangential_displacement, atol=1e-9 * np.abs(one.tangential_displacement).max()
    )
    assert other.dissipation == pytest.approx(one.dissipation, rel=1e-9)


def test_symmetric_loading_has_a_symmetric_answer():
    answer = fe_run(load_scene("hertz-normal"))
    np.testing.assert_allclose(answer.pressure, answer.pressure[:, ::-1], atol=1e-9 * answer.pressure.max())
    np.testing.assert_allclose(answer.contact_edges.sum(axis=1), 0.0, atol=1e-9)


# ------------------------------------------------------------------------------------------------------------ the rest
def test_steady_cycle_does_not_depend_on_the_initial_loading():
    plain = load_scene("hertz-paper")
    found = [fe_run(plain.vary(load={"initial_loading": way})) for way in ("parabola", "straight")]
    check("initial loading", found[0].dissipation / found[1].dissipation - 1)


def test_friction_zero_is_frictionless_contact():
    scene = load_scene("hertz-normal").vary(friction=0.0)
    answer = fe_run(scene)
    np.testing.assert_array_equal(answer.shear, 0.0)
    np.testing.assert_allclose(answer.pressure[-1], fe_run(load_scene("hertz-normal")).pressure[-1], rtol=1e-12)


def test_contact_that_outgrows_the_meshed_side_is_an_error(monkeypatch):
    solve = import_module("halfplane_fe.solve")
    find = solve.find_scales
    monkeypatch.setattr(solve, "find_scales", lambda *given: replace(find(*given), reach=0.7 * find(*given).reach))
    with pytest.raises(ConvergenceError, match="reached the end of the meshed side") as caught:
        halfplane_fe.solve(load_scene("hertz-normal"), COARSE, FEW_STEPS)
    assert caught.value.partial is not None


def test_progress_is_told():
    told = []
    halfplane_fe.solve(load_scene("hertz-normal"), COARSE, FEW_STEPS, progress=lambda *what: told.append(what))
    assert [text for _, _, text in told][:2] == ["coarse run", "meshing and condensing the bodies"]
    done = [(done, total) for done, total, text in told if text.startswith("initial loading")]
    assert done[-1][0] == done[-1][1]


def test_polygon_and_ellipse_of_one_history_agree():
    """An ellipse without extent in P is a straight line there and back."""
    ellipse = EllipseLoad(mean_normal_load=90, tangential_amplitude=25)
    line = PolygonLoad(initial_loading=[(90, -25)], cycle=[(90, 25)])
    scenes = [load_scene("cattaneo-mindlin").vary(load=load) for load in (ellipse, line)]
    found = [fe_run(scene).dissipation for scene in scenes]
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert math.isfinite(found[0])
