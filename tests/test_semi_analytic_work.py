"""W(x), W, fronts and the memory curve of extreme scenes by brute force in more digits, without the engine's rules or its march."""

import math
from itertools import pairwise

import numpy as np
import pytest

from scenes import CallableLoad
from semi_analytic import solve
from semi_analytic.history import history_of
from semi_analytic.memory import values
from semi_analytic_cases import brute_force_curve, make_scene, polygon
from semi_analytic_draws import LOADS, PROFILES, extreme
from semi_analytic_fronts import LONG, memory
from semi_analytic_work import Work

# Parts of a span, where P(a) hardly grows or harmonics drive the front.
PARTS = {"hardly growing": 4, "harmonics": 3, "harmonics to 1e-3": 4}
FEW = [
    ("hertz", "ellipse to 1e-4"),
    ("hertz", "harmonics"),
    ("long flat", "polygon"),
    ("short flat", "ellipse to 1e-4"),
    ("|x|^1.01", "tilted ellipse"),
    ("compound", "ellipse"),
    ("wedge", "rows"),
    ("table", "tilted ellipse"),
    ("polynomial", "ellipse"),
    ("hardly growing", "polygon"),
    ("function", "ellipse to 1e-4"),
]
ALL = [(profile, load) for profile in PROFILES for load in LOADS if (profile, load) not in FEW]


def work_of(profile, load):
    """The scene, the engine's spans and the same cycle by brute force."""
    scene = extreme(profile, load)
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    parts = max(PARTS.get(profile, 1), PARTS.get(load, 1))
    return scene, history, Work(scene, history.covered[-1], parts=parts)


def edges_of(work):
    """Half-widths of contact and of stick at the ends of all spans of slip, ascending."""
    ends = [(slip, time) for slip in work.slips for time in (slip.begin, slip.end)]
    return np.unique(work.half([load for slip, time in ends for load in (slip.front(time), slip.phase.loads(time)[0])]))


def points_of(work):
    """In the middle, next to the edges and on fronts."""
    edges = edges_of(work)
    low, high = edges[0], edges[-1]
    corners = [b * (1 + 1e-9) for b in work.corners[:1] if low < b < high]
    spread = [low + (high - low) * part for part in (1e-3, 0.42, 0.77)]
    return np.array([*spread, high * (1 - 1e-6), edges[len(edges) // 2], *corners], dtype=float)


def agrees(profile, load):
    scene, _, work = work_of(profile, load)
    x = points_of(work)
    found = solve(scene, x=x, fields=("dissipation_density", "dissipation"))
    told = found.record.errors
    whole, exact = np.sum(work.whole()), np.sum(work.density(x), axis=0)
    assert abs(found.dissipation - whole) <= max(1e-12, told.get("dissipation", 0.0)) * whole
    off = np.max(np.abs(found.dissipation_density - exact))
    assert off <= max(2e-12, told.get("dissipation_density", 0.0)) * np.max(exact)


@pytest.mark.parametrize(("profile", "load"), FEW)
def test_work_by_brute_force(profile, load):
    """W to 1e-12, W(x) to 2e-12 of its largest, or to what the record says. W of a short flat face under an ellipse that unloads to
    1e-4 was 2.8e-12 off and said nothing; W(x) where P hardly grows was 4.2e-8 off and said 3.6e-8.
    """
    agrees(profile, load)


@pytest.mark.slow
@pytest.mark.parametrize(("profile", "load"), ALL)
def test_work_of_every_profile_and_load_by_brute_force(profile, load):
    agrees(profile, load)


@pytest.mark.parametrize("profile", ["hardly growing", "compound"])
def test_work_of_rows_by_brute_force(profile):
    """W was 1.7e-8 off where P hardly grows and W(x) 3.9e-8, and the record said 1.4e-12."""
    agrees(profile, "rows")


def test_no_point_misses_an_instant_in_which_the_load_hardly_grows():
    """Of a Python function the load turns at 1e-11, not at 0; by their last digits both loads fell there, and W(x) lacked 9e-12."""
    load = CallableLoad(
        normal_load=lambda t: 0.34 + 0.34 * 0.3 * math.cos(t),
        tangential_load=lambda t: 0.8 * 2.0 * 0.7 * 0.34 * math.cos(t - 0.5),
        duration=2 * math.pi,
        repeats=True,
    )
    scene, x = make_scene(load, friction=2.0), np.array([0.55, 0.6])
    exact = np.sum(Work(scene, 1).density(x), axis=0).astype(float)
    found = solve(scene, x=x, fields=("dissipation_density",)).dissipation_density
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13 * np.max(exact))


def slipped_at(work, span, time):
    """P - P_c by brute force."""
    phases = [k for k, phase in enumerate(work.phases) if phase.leg == span.leg and phase.begin <= time <= phase.end]
    slips = [slip for slip in work.slips if slip.phase.leg == span.leg and slip.begin <= time <= slip.end]
    # A path along the limit of friction moves no front: rounding of Q - f P says whether there is one.
    slips = [slip for slip in slips if np.diff(slip.growth(np.array([slip.begin, slip.end]))[0])[0] > 1e-15]
    return max((float(slip.phase.loads(time)[0] - slip.front(time)) for slip in slips), default=0.0), phases[-1]


@pytest.mark.parametrize("load", LOADS)
def test_fronts_and_the_memory_curve_straight_from_the_path(load):
    """P_c to 1e-14 of P, M(eta) to 1e-15 f P. Just after a turn on harmonics P_c was 1.2e-11 off, 1/5,000 of what had slipped."""
    _, history, work = work_of("hertz", load)
    top, checked = 2.0, 0
    for span in history.cycles[-1]:
        for part in (1e-4, 0.1, 0.6, 0.999):
            time = LONG(span.begin.time + (span.end.time - span.begin.time) * part)
            if time - span.begin.time < 1e-7:  # what brute force itself knows so soon after a turn has less digits
                continue
            slipped, number = slipped_at(work, span, time)
            assert abs(float(span.slipped(float(time))) - slipped) <= 1e-14 * top, (span.begin.time, part)
            eta = float(span.leg.loads(float(time))[0]) * np.array([1e-3, 0.3, 0.9])
            exact = [float(memory(work.phases, number, time, each, 0.5)) for each in eta]
            np.testing.assert_allclose(values(span.curve(float(time)), eta), exact, rtol=0, atol=1e-15 * 0.5 * top)
            checked += 1
    assert checked >= 12


def test_looking_back_is_append_and_clip():
    """Word for word as in the theory, on a grid: the same curve."""
    corners = [(1.9, 0.2), (1.0, 0.45), (1.6, 0.1), (1.3, -0.6), (1.7, 0.1), (1.2, 0.3)]
    work = Work(make_scene(polygon(corners), 0.5), 0)
    eta, held = brute_force_curve(corners, 0.5, 401)
    last = len(work.phases) - 1
    found = [float(memory(work.phases, last, work.phases[last].end, each, 0.5)) for each in eta[1:]]
    np.testing.assert_allclose(found, held[1:], rtol=0, atol=1e-15)


@pytest.mark.parametrize("use", [0.1, 0.7, 1 - 1e-6])
def test_brute_force_has_the_closed_form_of_constant_load(use):
    """W as in `test_semi_analytic_dissipation`; W(x) = (8 f^2/pi) p(x) K [x sqrt(x^2 - c^2) - c^2 arccosh(x/c)] where P = K a^2."""
    friction, load = 0.5, 1.0
    q = use * friction * load
    work = Work(make_scene(polygon([(load, 0.0)], [(load, q), (load, -q)]), friction), 1)
    bracket = (1 - use) * math.log1p(-use) + use - use**2 / 2
    assert float(np.sum(work.whole())) == pytest.approx(4 * friction**2 / math.pi * bracket, rel=1e-12, abs=0)
    half, stiffness = math.sqrt(4 / math.pi), math.pi / 4
    stick = half * math.sqrt((load - q / friction) / load)
    x = stick + (half - stick) * np.array([0.3, 0.8, 0.999])
    reach = x * np.sqrt((x - stick) * (x + stick)) - stick**2 * np.arccosh(x / stick)
    closed = 8 * friction**2 / math.pi * np.sqrt((half - x) * (half + x)) / 2 * stiffness * reach
    np.testing.assert_allclose(np.sum(work.density(x), axis=0).astype(float), closed, rtol=1e-12)


@pytest.mark.slow
def test_density_adds_up_to_the_work():
    """Both by brute force, by Gauss' rule between the edges at the ends of the spans: measured 1.6e-7 apart, 8e-5 with five."""
    work = Work(extreme("hertz", "polygon"), 1)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    t = (1 + nodes) / 2
    edges, total = edges_of(work).astype(float), 0.0
    for low, high in pairwise(edges[np.diff(edges, prepend=0.0) > 1e-9]):
        # Crowded to both ends: W(x) starts like d^(3/2).
        x, weight = low + (high - low) * t * t * (3 - 2 * t), (high - low) * weights / 2 * 6 * t * (1 - t)
        total += 2 * float(np.sum(weight * np.sum(work.density(x), axis=0)))
    assert total == pytest.approx(float(np.sum(work.whole())), rel=1e-6)
