"""The closed forms of `problems.py` against brute force: surface integrals, the memory curve stepped on a grid, work summed up.

Nothing here shares a formula with what it tries: pressures are put back into the integral equation of the half-plane, shears also
into the stepping "append, then clip" of the theory, and energies come from the closed integral of Q dU.
"""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad

from problems import (
    PROBLEMS,
    contact_modulus,
    drawn_inwards,
    errors,
    hertz_approach,
    hertz_half_width,
    hertz_pressure,
    mindlin_dissipation,
    norm,
    pressed_in,
    problems,
)

HERTZ = [problem for problem in problems("tangential") if "hertz" in problem.tags]
SHEARED = pytest.mark.parametrize("problem", HERTZ, ids=lambda problem: problem.name)


def integral(function, a, kinks=()):
    """Integral over |x| < a, square roots at the ends taken away by x = a sin(theta)."""
    corners = [-math.pi / 2, *sorted(math.asin(kink / a) for kink in kinks), math.pi / 2]
    under = lambda theta: float(function(a * math.sin(theta))) * a * math.cos(theta)  # noqa: E731
    return sum(quad(under, start, end, epsabs=1e-13, epsrel=1e-11, limit=400)[0] for start, end in itertools.pairwise(corners))


def slope(traction, x, a, kinks=()):
    """Principal value of int traction(s)/(x - s) ds over |s| < a."""
    here = float(traction(x))
    regular = lambda s: (float(traction(s)) - here) / (x - s) if s != x else 0.0  # noqa: E731
    return integral(regular, a, (x, *kinks)) + here * math.log((a + x) / (a - x))


def kinks_of(problem):
    c, a = problem.exact["stick_half_width"], problem.exact["contact_half_width"]
    return (-c, c) if c < a else ()


class GridMemory:
    """M(eta) on a grid, stepped word for word as in the theory, section 3; fields by sums over the cells."""

    def __init__(self, problem, cells=3000):
        self.profile, self.f, self.E = problem.scene.profile, problem.scene.friction.coefficient, contact_modulus(problem.scene)
        path = problem.scene.load.path()
        times = np.concatenate([np.linspace(leg.start, leg.end, 1441) for leg in path.legs(2 if path.period else 0)])
        self.eta = np.linspace(0, float(path.at(times)[0].max()), cells + 1)
        self.M, self.load = np.zeros(cells + 1), (0.0, 0.0)

    def step(self, P, Q):
        before, last = self.load
        growth = P - before
        if growth > 0:
            self.M = np.where(self.eta > before, last + (Q - last) * (self.eta - before) / growth, self.M)
        low, high = Q - self.f * (P - self.eta), Q + self.f * (P - self.eta)
        self.M = np.where(self.eta <= P, np.clip(self.M, low, np.maximum(low, high)), Q)
        self.load = (P, Q)

    def cells(self):
        """(top, slope) of the cells up to P."""
        P, Q = self.load
        inside = self.eta < P * (1 - 1e-12)
        tops = np.append(self.eta[inside], P)
        return tops, np.diff(np.append(self.M[inside], Q)) / np.diff(tops)

    def half_width(self, load):
        return hertz_half_width(load, self.profile.radius, self.E)

    def shear(self, x):
        """Each cell: a slope times the pressure that the cell's flat punches make."""
        tops, slopes = self.cells()
        a = self.half_width(tops)
        # int d eta / (pi sqrt(a^2 - x^2)) over a cell, a^2 straight across it.
        root = np.sqrt(np.maximum(a[:, None] ** 2 - np.square(x), 0.0))
        gain = np.diff(a**2)
        return slopes * np.diff(tops) / gain @ (2 * np.diff(root, axis=0)) / math.pi

    def shift(self):
        """U = (2/pi E*) int M' ln(2 L/a) d eta, the midpoint rule in each cell."""
        tops, slopes = self.cells()
        middles = (tops[:-1] + tops[1:]) / 2
        logs = np.log(2 * self.profile.datum_length / self.half_width(middles))
        return 2 / (math.pi * self.E) * float(np.sum(slopes * np.diff(tops) * logs))


def stepped(problem, until=None, count=720):
    """The grid's memory at `until` and, per step, (time, Q, U)."""
    memory, path, log = GridMemory(problem), problem.scene.load.path(), []
    for leg in path.legs(2 if path.period else 0):
        times = np.linspace(leg.start, leg.end, count + 1)[1:]
        for time in times:
            if until is not None and time > until + 1e-9:
                continue
            P, Q = (float(v) for v in leg.loads(time))
            memory.step(P, Q)
            if until is None:
                log.append((time, Q, memory.shift()))
    return memory, np.array(log)


CLOSED = [problem for problem in PROBLEMS.values() if "by theory" not in problem.tags]


@pytest.mark.parametrize("problem", CLOSED, ids=lambda problem: problem.name)
def test_pressure_carries_the_load_and_closes_the_gap(problem):
    """h'(x) = (2/pi E*) int p(s)/(x - s) ds inside the contact; and the peak is the largest."""
    kinks, a, E = kinks_of(problem), problem.exact["contact_half_width"], contact_modulus(problem.scene)
    P, Q = problem.loads()
    assert integral(problem.exact["pressure"], a, kinks) == pytest.approx(P, rel=1e-9)
    assert integral(problem.exact["shear"], a, kinks) == pytest.approx(Q, rel=1e-9, abs=1e-9 * P)
    h, step = problem.scene.profile.height, 1e-6 * a
    for x in (0.1 * a, 0.45 * a, 0.93 * a):
        gap_slope = float(h(x + step) - h(x - step)) / (2 * step)
        closed = 2 / (math.pi * E) * slope(problem.exact["pressure"], x, a, kinks)
        assert closed == pytest.approx(gap_slope, abs=1e-7 * a / problem.scene.profile.radius)
    if "peak_pressure" in problem.exact:
        assert problem.exact["pressure"](np.linspace(-1, 1, 401) * a).max() == problem.exact["peak_pressure"]


def test_approach_is_the_logarithm_integral():
    """delta = (2/pi E*) int p(s) ln(L/|s|) ds: what the middle of the contact goes in by."""
    P, R, E, L = 1.7, 30.0, 11.0, 5.0
    a = hertz_half_width(P, R, E)
    direct = 2 / (math.pi * E) * integral(lambda s: hertz_pressure(s, P, R, E) * math.log(L / abs(s)), a, (0.0,))
    assert hertz_approach(P, R, E, L) == pytest.approx(direct, rel=1e-9)


@pytest.mark.parametrize("x", [0.0, 0.4, -1.3])
def test_one_body_under_uniform_traction(x):
    b, young, nu, L = 1.4, 3.0, 0.2, 5.0
    down = sum(quad(lambda s: math.log(L / abs(x - s)), *ends)[0] for ends in ((-b, x), (x, b)))
    assert pressed_in(x, b, young, nu, L) == pytest.approx(2 * (1 - nu**2) / (math.pi * young) * down, rel=1e-9)
    # Strain along the surface under pressure p, plane strain: (1 - nu^2)/E sigma_xx - nu (1 + nu)/E sigma_yy, both -p there.
    strain = -(1 - nu**2) / young + nu * (1 + nu) / young
    assert drawn_inwards(x, young, nu) == pytest.approx(strain * x, rel=1e-14)


# ------------------------------------------------------------------------------------------------------- tangential contact
@SHEARED
def test_shear_is_in_the_cone_and_what_the_stepped_memory_leaves(problem):
    """On the cone where it slips; 1.1e-3 of the memory on this grid, which halves with its cells."""
    a, c, f = problem.exact["contact_half_width"], problem.exact["stick_half_width"], problem.scene.friction.coefficient
    x = np.linspace(-0.9999, 0.9999, 2001) * a
    p, q = problem.exact["pressure"](x), problem.exact["shear"](x)
    assert np.all(np.abs(q) <= f * p + 1e-12 * p.max())
    slipping = np.abs(x) > c * (1 + 1e-9)
    np.testing.assert_allclose(q[slipping], np.sign(q[slipping].sum()) * f * p[slipping], atol=1e-12 * p.max())
    # At the paper's point E the rim of the permanent stick zone lies on the cone as well, and sticks.
    inside = np.abs(x) < (0.5 if "varying P" in problem.tags else 0.98) * c
    assert np.all(np.abs(q[inside]) < f * p[inside] * (1 - 1e-6))
    memory, _ = stepped(problem, until=problem.time)
    x = np.linspace(-0.999, 0.999, 400) * a
    assert norm(x, memory.shear(x) - problem.exact["shear"](x)) < 2e-3 * norm(x, problem.exact["pressure"](x))


def test_first_branch_does_not_slip_in_the_stick_zone():
    """The slip's gradient, (2/pi E*) int q(s)/(x - s) ds, is 0 there and not beyond."""
    problem = PROBLEMS["mindlin, Q largest"]
    a, c, shear = problem.exact["contact_half_width"], problem.exact["stick_half_width"], problem.exact["shear"]
    for share in (0.0, 0.5, 0.95):
        assert abs(slope(shear, share * c, a, kinks_of(problem))) < 1e-7 * shear(0.9 * c)
    assert abs(slope(shear, (c + a) / 2, a, kinks_of(problem))) > 1e-2 * shear(0.9 * c)


@pytest.mark.parametrize("name", ["mindlin, end of cycle", "full-stick", "paper, forward slip ends"])
def test_dissipation_is_the_closed_integral_of_q_du(name):
    problem = PROBLEMS[name]
    _, log = stepped(problem)
    path = problem.scene.load.path()
    last = log[:, 0] >= path.cycle_start + path.period - 1e-9
    work = float(np.trapezoid(log[last, 1], log[last, 2]))
    scale = 4 * (problem.scene.friction.coefficient * problem.loads()[0]) ** 2 / (math.pi * contact_modulus(problem.scene))
    assert work == pytest.approx(problem.exact["dissipation"], rel=1e-3, abs=1e-6 * scale)


@pytest.mark.parametrize("name", ["mindlin, Q largest", "full-stick"])
def test_tangential_displacement_is_that_of_the_memory(name):
    memory, _ = stepped(PROBLEMS[name], until=PROBLEMS[name].time)
    assert memory.shift() == pytest.approx(PROBLEMS[name].exact["tangential_displacement"], rel=2e-4)


def test_little_slip_dissipates_with_the_cube_of_q():
    """W -> (2/3 pi) Q^3/(f P E*) as Q -> 0."""
    f, P, E = 0.7, 3.0, 2.5
    assert mindlin_dissipation(P, 1e-3, f, E) == pytest.approx(2 / (3 * math.pi) * 1e-9 / (f * P * E), rel=2e-3)


# ------------------------------------------------------------------------------------------------------------- the measure


PLANTED = (
    "pressure",
    "shear",
    "contact_half_width",
    "stick_half_width",
    "normal_approach",
    "tangential_displacement",
    "dissipation",
)


def test_errors_of_the_truth_itself_are_none():
    """`errors` on a made-up answer that is exact, and on the same with one planted fault each."""
    problem = PROBLEMS["mindlin, Q largest"]
    x = np.linspace(-1.05, 1.05, 401)
    exact = problem.exact

    def answer(**changed):
        numbers = ("contact_half_width", "stick_half_width", "normal_approach", "tangential_displacement")
        fields = {name: np.array([exact[name]]) for name in numbers}
        fields |= {"pressure": exact["pressure"](x)[None], "shear": exact["shear"](x)[None], "dissipation": exact["dissipation"]}
        fields |= changed
        return SimpleNamespace(scene=problem.scene, time=np.array([problem.time]), x=x, **fields)

    clean = errors(problem, answer())
    assert set(clean) == {*PLANTED, "peak_pressure"}
    assert max(clean.values()) == 0.0
    for name in PLANTED:
        wrong = errors(problem, answer(**{name: 1.01 * np.asarray(getattr(answer(), name))}))
        assert 2e-3 < wrong[name] < 0.02, name
        others = set(clean) - {name, "peak_pressure"}
        assert all(wrong[other] == 0.0 for other in others)
