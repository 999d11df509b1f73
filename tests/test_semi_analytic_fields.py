"""Tractions, slip and shift at extreme points of extreme scenes, by brute force in more digits (`semi_analytic_oracle`)."""

import numpy as np
import pytest

from semi_analytic import solve
from semi_analytic_draws import LOADS, PROFILES, extreme
from semi_analytic_oracle import LONG, Oracle
from semi_analytic_truth import slip_of_an_arc

FEW = [
    ("hertz", "ellipse to 1e-4"),
    ("long flat", "polygon"),
    ("short flat", "ellipse"),
    ("|x|^1.01", "ellipse to 1e-4"),
    ("|x|^3.5", "harmonics to 1e-3"),
    ("|x|^20", "ellipse"),
    ("compound", "harmonics to 1e-3"),
    ("compound", "ellipse to 1e-4"),
    ("wedge", "harmonics"),
    ("polynomial", "rows"),
    ("hardly growing", "harmonics to 1e-3"),
    ("hardly growing", "tilted ellipse"),
    ("table", "ellipse"),
    ("function", "ellipse"),
]
ALL = [(profile, load) for profile in PROFILES for load in LOADS if (profile, load) not in FEW]


def astray(profile, load):
    """Of every field the largest deviation from brute force over its largest value, and what the record says of it."""
    scene = extreme(profile, load)
    whole = solve(scene, x=[0.0], fields=())
    half = float(np.max(whole.contact_half_width))
    last = np.flatnonzero(whole.last_cycle)
    sticks = last[whole.stick_half_width[last] == whole.contact_half_width[last]]
    chosen = [*last[[len(last) // 5, len(last) * 4 // 7]], *sticks[-2 - len(sticks) // 8 :][:1]]
    times = np.unique(whole.time[chosen])
    edges = solve(scene, x=[0.0], time=times, fields=())
    near = [float(values[0]) * (1 + d) for values in (edges.contact_half_width, edges.stick_half_width) for d in (-1e-3, 1e-3)]
    corners = [b * (1 + d) for b in PROFILES[profile].kinks[:2] for d in (-1e-9, 1e-9)]
    x = np.unique(np.concatenate([half * np.array([1e-8, 0.1, 0.63, 0.93, 1.1, 3.0]), near, corners]))
    found = solve(scene, x=x, time=times, fields=("pressure", "shear", "slip", "tangential_displacement", "normal_approach"))
    oracle = Oracle(scene, times)
    exact = [oracle.at(k, x) for k in range(len(times))]
    size = max(float(each["pressure"][1:].max()) for each in exact)
    tops = {"pressure": size, "shear": 0.5 * size}
    worst = {}
    for name in exact[0]:
        truth = np.array([each[name] for each in exact])
        off = np.abs(getattr(found, name).astype(LONG) - truth).astype(float)
        told = max((error for key, error in found.record.errors.items() if key.startswith(name)), default=0.0)
        worst[name] = float(np.max(off)) / tops.get(name, float(np.max(np.abs(truth)))), told
    return worst


def agrees(profile, load):
    for name, (off, told) in astray(profile, load).items():
        assert off <= max(told, 5e-12), name


@pytest.mark.parametrize(("profile", "load"), FEW)
def test_fields_by_brute_force(profile, load):
    """Tractions over f p, slips and shifts over their largest. Measured: 8e-14; shear on arcs of harmonics was 2e-9 off for two
    curvatures, 2e-11 for |x|^3.5, where the root of the traction lies ahead of the arc; slip 7e-9 where P(a) hardly grows.
    There the tangential displacement of an ellipse was 1e-8 off, its slip 6e-9.
    """
    agrees(profile, load)


@pytest.mark.slow
@pytest.mark.parametrize(("profile", "load"), ALL)
def test_fields_of_every_profile_and_load_by_brute_force(profile, load):
    agrees(profile, load)


@pytest.mark.parametrize("n", [2.0, 7.0, 20.0, 40.0])
@pytest.mark.parametrize("place", [1.01, 3.0, 10.0])
def test_slip_of_an_arc_where_the_load_to_reach_it_is_far_above_all(n, place):
    """The sine part of an arc at thirty digits, P_x being up to 10^40 times P: a short arc was lost in the last digits of a large
    logarithm, 1e-5 of it at 3 a of |x|^40, all of it at 10 a. Measured: 3e-14 at 1.01 a, 5e-16 farther out.
    """
    found, exact = slip_of_an_arc(n, place)
    assert found == pytest.approx(exact, rel=1e-13, abs=0)
