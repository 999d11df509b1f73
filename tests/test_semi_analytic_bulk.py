"""Bulk stress and tilt in the half-plane engine, against closed values, a dense grid, mirrors and the energy balance."""

import math

import numpy as np
import pytest

import bulk_oracle

A0 = math.sqrt(12 / math.pi)  # Hertz with E* = R = 1 and P = 3


def parabola(x):
    return x**2 / 2


def ramp(increments, *values):
    """Loads in proportion from 0 to `values`."""
    return [np.linspace(0, value, increments + 1) for value in values]


# ------------------------------------------------------------------------------------------------------------- the oracle
# From P = 3 alone: (Q, eps) in proportion, increments, edges of stick. Cattaneo-Mindlin; Nowell and Hills 1987; opposite slip at
# the ends without and with Q.
STICK = {
    "cattaneo-mindlin": (1.8, 0.0, 1, (-1.2360774475, 1.2360774475)),
    "moderate bulk": (1.8, 0.2, 1, (0.2 - 1.2360774475, 0.2 + 1.2360774475)),
    "bulk alone, c = 0.9 a": (0.0, 0.2007250992650, 1, (-0.9 * A0, 0.9 * A0)),
    "bulk alone, c = 0.5 a": (0.0, 1.1763560617531, 8, (-0.5 * A0, 0.5 * A0)),
    "bulk alone, c = 0.1 a": (0.0, 3.3340559259752, 8, (-0.1 * A0, 0.1 * A0)),
    "large bulk": (0.9, 1.0, 8, (-0.7063363748151722, 1.4493185287005215)),
}


@pytest.mark.parametrize(("force", "strain", "increments", "edges"), STICK.values(), ids=STICK)
def test_the_grid_finds_the_stick_zones_of_closed_solutions(force, strain, increments, edges):
    shear, eps = ramp(increments, force, strain)
    found = bulk_oracle.solve(parabola, (-2.3, 2.3), 230, 1.0, 3.0, shear, eps)
    assert found.edges(-1) == pytest.approx((-A0, A0), abs=found.step)
    assert found.edges(-1, stick=True) == pytest.approx(edges, abs=found.step)


def test_the_grid_finds_the_traction_of_cattaneo_and_mindlin():
    found = bulk_oracle.solve(parabola, (-2.3, 2.3), 230, 1.0, 3.0, [0.0, 1.8])
    stick = math.sqrt(12 / math.pi * 0.4)
    expected = [np.sqrt(np.maximum(half**2 - found.x**2, 0)) / 2 for half in (A0, stick)]
    assert found.pressure[1] == pytest.approx(expected[0], abs=0.02)
    assert found.shear[1] == pytest.approx(expected[0] - expected[1], abs=0.02)
    assert np.sqrt(np.mean((found.shear[1] - expected[0] + expected[1]) ** 2)) < 3e-3


def test_the_work_of_the_grid_is_its_loop_with_the_bulk_term():
    """Discretely exact over a steady cycle; without the term of bulk the loop is 0.27 away."""
    way = np.concatenate([np.linspace(0, 1, 21), np.linspace(1, -1, 41)[1:], np.linspace(-1, 1, 41)[1:]])
    way = np.concatenate([way, way[21:]])
    found = bulk_oracle.solve(parabola, (-2.3, 2.3), 230, 1.0, 3.0, 1.8 * way, 0.3 * way)
    works = found.cycle_work(80)
    assert works == pytest.approx(0.9368781396315213, rel=1e-3)
    assert found.cycle_work(80, loop=True) == pytest.approx(works, rel=1e-10)


def test_the_grid_finds_a_tilted_punch():
    def flat(x):
        return np.maximum(np.abs(x) - 0.5, 0) ** 2 / 2

    found = bulk_oracle.solve(flat, (-2.0, 2.0), 200, 1.0, 1.0, 0.0, tilt=0.2)
    assert found.edges(0) == pytest.approx((-1.7331629996, 1.2194927292), abs=found.step)
    assert found.moment[0] == pytest.approx(-0.3444188480137, rel=1e-3)
    back = bulk_oracle.solve(flat, (-2.0, 2.0), 200, 1.0, 1.0, 0.0, moment=-0.3444188480137)
    assert back.tilt[0] == pytest.approx(0.2, rel=1e-3)
