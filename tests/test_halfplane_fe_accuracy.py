"""Accurate: finite elements against closed forms, and the order at which they get there, asserted on both sides.

A single error says little about an order, since the edges of contact and stick fall anywhere inside an element: the sequences are
means over many loads, each with its edges elsewhere.
"""

import functools

import numpy as np
import pytest

from halfplane_fe import SolverSettings
from halfplane_fe.contact import ContactProblem
from halfplane_fe.edges import contact_edges, stick_edges
from halfplane_fe.elasticity import condense
from halfplane_fe.interface import couple
from halfplane_fe.run import Pace, run_path
from halfplane_fe.systems import Layer
from meshes import MeshSettings, SurfaceGrading, half_disc
from problems import (
    PROBLEMS,
    errors,
    fe_run,
    hertz_approach,
    hertz_half_width,
    hertz_pressure,
    mindlin_dissipation,
    mindlin_shear,
    mindlin_stick_half_width,
    problems,
)
from scenes import Elastic, PolygonLoad, SurfaceState
from tolerances import ORDERS, TOLERANCES, check, check_order, order_of

EVERY = pytest.mark.parametrize("problem", PROBLEMS.values(), ids=PROBLEMS.keys())
FRICTION, RADIUS, DATUM = 0.5, np.pi / 4, 1.0  # E* = 1: P = a^2


@EVERY
def test_answers_agree_with_the_closed_forms(problem):
    group = "hertz" if "hertz" in problem.tags else "flat and rounded"
    for metric, error in errors(problem, fe_run(problem.scene)).items():
        check(f"{group} {metric}", error)


@pytest.mark.parametrize("problem", problems("varying P"), ids=lambda problem: problem.name)
def test_default_settings_reach_the_promised_figures(problem):
    for metric, error in errors(problem, fe_run(problem.scene, MeshSettings(), SolverSettings())).items():
        check(f"default {metric}", error)


# ------------------------------------------------------------------------------------------------------------------- orders
@functools.cache
def interface(elements, order):
    """Like bodies with E* = 1, `elements` a unit of surface; the bulk refined with it."""
    body = half_disc("body", SurfaceGrading(0.0, 1.2, 1 / elements, 1 / elements, 6.0), min(1.0, 3.2 / elements), order)
    one = condense(body, Elastic(young_modulus=1.82, poisson_ratio=0.3), DATUM)
    return couple(one, one)


def states_of(elements, order, load, steps, friction=FRICTION):
    """States and revolutions' dissipations along a load path."""
    sides = interface(elements, order)
    zero = np.zeros_like(sides.x)
    contact = ContactProblem(sides, np.square(sides.x) / (2 * RADIUS), friction, Layer(zero, zero))
    run = run_path(contact, load.path(), Pace(1.0, steps, np.inf), 1, lambda *_: None)
    assert run.failure is None
    return sides, run


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@functools.cache
def hertz_errors(elements, order):
    """Over loads from half of the largest to the largest: pressure in the middle, in L2, contact edge, approach."""
    sides, run = states_of(elements, order, PolygonLoad(initial_loading=[(0.5, 0.0), (1.0, 0.0)]), 8 * 30)
    found = []
    for state in run.states:
        if state.time < 1:
            continue
        a = float(hertz_half_width(state.normal_load, RADIUS, 1.0))
        exact = hertz_pressure(sides.x, state.normal_load, RADIUS, 1.0)
        pressure = state.pressure / sides.weights
        edges = contact_edges(sides.x, pressure, state.gap, state.closed, 1.0)
        middle = np.abs(sides.x) < a / 4
        approach = hertz_approach(state.normal_load, RADIUS, 1.0, DATUM)
        found.append(
            (
                rms((pressure - exact)[middle]) / exact.max(),
                np.sqrt(sides.weights @ (pressure - exact) ** 2 / (sides.weights @ exact**2)),
                (edges[1] - edges[0]) / 2 / a - 1,
                state.approach / approach - 1,
            )
        )
    return dict(zip(("middle", "L2", "edge", "approach"), (rms(column) for column in zip(*found, strict=True)), strict=True))


@functools.cache
def mindlin_errors(elements, order=2):
    """Over cycles between +-0.4 and +-0.8 of f P: shear in L2, stick edge, dissipation."""
    found = []
    for share in np.linspace(0.4, 0.8, 9):
        q = share * FRICTION
        sides, run = states_of(elements, order, PolygonLoad(initial_loading=[(1.0, 0.0), (1.0, q)], cycle=[(1.0, -q)]), 8)
        pressure = hertz_pressure(sides.x, 1.0, RADIUS, 1.0)
        back = next(state for state in run.states if abs(state.time - 3) < 1e-9)
        half = next(state for state in run.states if abs(state.time - 2.5) < 1e-9)
        shear_error, edge_error = [], []
        for state, turns in ((half, (q, 0.0)), (back, (q, -q))):
            exact = mindlin_shear(sides.x, 1.0, turns, FRICTION, RADIUS, 1.0)
            error = state.shear / sides.weights - exact
            shear_error.append(np.sqrt(sides.weights @ error**2 / (sides.weights @ pressure**2)) / FRICTION)
            edges = stick_edges(sides.x, state.state == SurfaceState.STICK, state.closed, (-1.0, 1.0))
            c = mindlin_stick_half_width(1.0, (turns[1] - turns[0]) / 2, FRICTION, RADIUS, 1.0)
            edge_error.append((edges[1] - edges[0]) / 2 - c)
        dissipation = run.cycle_density[-1].sum() / mindlin_dissipation(1.0, q, FRICTION, 1.0) - 1
        found.append((rms(shear_error), rms(edge_error), dissipation))
    return dict(zip(("shear", "stick edge", "dissipation"), (rms(column) for column in zip(*found, strict=True)), strict=True))


ELEMENTS = (8, 16, 32)
SIZES = [1 / n for n in ELEMENTS]


@pytest.mark.parametrize("quantity", ["middle", "L2", "edge", "approach"])
def test_hertz_converges_with_quadratic_elements(quantity):
    check_order(f"hertz {quantity}, quadratic", SIZES, [hertz_errors(n, 2)[quantity] for n in ELEMENTS])


@pytest.mark.parametrize("quantity", ["L2", "approach"])
def test_hertz_converges_with_linear_elements(quantity):
    sequence = [hertz_errors(n, 1)[quantity] for n in (8, 16, 32, 64)]
    check_order(f"hertz {quantity}, linear", [1 / 8, 1 / 16, 1 / 32, 1 / 64], sequence)


@pytest.mark.parametrize("quantity", ["shear", "stick edge", "dissipation"])
def test_mindlin_converges(quantity):
    check_order(f"mindlin {quantity}", SIZES, [mindlin_errors(n)[quantity] for n in ELEMENTS])


def test_quadratic_elements_are_better_by_far():
    for quantity in ("middle", "L2", "approach"):
        assert hertz_errors(16, 2)[quantity] < hertz_errors(16, 1)[quantity] / 3


# ------------------------------------------------------------------------------------------------------- testing the testers
def planted(order, noise=0.0):
    return [3.0 * h**order * (1 + noise * (-1) ** k) for k, h in enumerate(SIZES)]


def test_order_check_knows_a_right_sequence_and_its_order():
    assert order_of(SIZES, planted(1.9)) == pytest.approx(1.9)
    check_order("hertz middle, quadratic", SIZES, planted(1.9, noise=0.2))


@pytest.mark.parametrize(
    "sequence",
    [planted(1.0), planted(3.0), planted(0.0), [error + 0.1 for error in planted(1.9)], planted(-1.9), [1e-2, 1e-3, 0.0]],
    ids=["first order", "third order", "no convergence", "a floor", "divergence", "an error of nothing"],
)
def test_order_check_fails_on_both_sides(sequence):
    with pytest.raises(AssertionError):
        check_order("hertz middle, quadratic", SIZES, sequence)


def test_dissipation_with_a_first_order_fault_is_seen():
    """The measured sequence with three tenths of an element size added."""
    sequence = [mindlin_errors(n)["dissipation"] + 0.3 * h for n, h in zip(ELEMENTS, SIZES, strict=True)]
    with pytest.raises(AssertionError, match="mindlin dissipation: order"):
        check_order("mindlin dissipation", SIZES, sequence)


@pytest.mark.parametrize("name", TOLERANCES)
def test_every_tolerance_is_measured_reasoned_and_near_its_measurement(name):
    tolerance = TOLERANCES[name]
    assert tolerance.measured <= tolerance.limit
    near = tolerance.limit <= 10 * tolerance.measured or tolerance.limit <= 1e-9
    assert near or tolerance.reason.startswith("promised"), "a limit so far off sees nothing"
    assert len(tolerance.reason) > 10


@pytest.mark.parametrize("name", ORDERS)
def test_every_order_is_bounded_on_both_sides(name):
    order = ORDERS[name]
    assert order.least < order.measured < order.most
    assert order.most - order.least <= 1.6
    assert len(order.reason) > 10


def test_check_fails_above_its_limit_and_on_nan():
    check("hertz pressure", TOLERANCES["hertz pressure"].limit)
    for wrong in (TOLERANCES["hertz pressure"].limit * 1.01, -1.0, float("nan")):
        with pytest.raises(AssertionError, match="hertz pressure"):
            check("hertz pressure", wrong)


METRICS = ("pressure", "shear", "contact_half_width", "stick_half_width", "peak_pressure", "normal_approach", "dissipation")


FINER = [(problem, metric) for problem in problems("cycle") for metric in METRICS]


@pytest.mark.slow
@pytest.mark.parametrize(("problem", "metric"), FINER, ids=lambda value: getattr(value, "name", value))
def test_a_finer_mesh_than_the_default_is_better_than_the_coarse_one(problem, metric):
    fine = fe_run(problem.scene, MeshSettings(edge_element_size=1 / 320), SolverSettings(steps_per_cycle=384))
    assert errors(problem, fine)[metric] <= errors(problem, fe_run(problem.scene))[metric] + 1e-12
