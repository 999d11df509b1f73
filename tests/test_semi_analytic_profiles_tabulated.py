"""Tabulated profiles: exact for the spline that they are, Hertz for rows of a parabola, in the limit right for any curve."""

import contextlib
import io
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest

from reports.cli import main
from scenes import FlatRounded, Hertz, InputError, Tabulated
from semi_analytic import solve
from semi_analytic.hertz import HertzContact
from semi_analytic_cases import ellipse, make_scene
from semi_analytic_truth import Truth, profile_contact, worst


def table(height, extent, count, sides=1):
    x = np.linspace(-extent if sides == 2 else 0.0, extent, sides * (count - 1) + 1)
    return Tabulated(points=np.stack([x, height(x)], axis=1))


def test_kernels_of_the_spline_against_quadrature():
    """Measured: 4e-16, the slip area 3e-13."""
    profile = table(lambda x: np.cosh(x) - 1, 1.0, 5)
    contact, spline = profile_contact(profile), profile.spline()
    knots, bends = ([mp.mpf(float(v)) for v in values] for values in (spline.x, spline.curvature))
    pieces = list(zip(bends, knots[:-1], knots[1:], strict=True))

    def rate(a):
        return a * sum(k * (mp.asin(min(end / a, 1)) - mp.asin(begin / a)) for k, begin, end in pieces if begin < a)

    truth = Truth(1, lambda x: sum(k * (min(max(x, a), b) - a) for k, a, b in pieces), rate, contact.breaks)
    found = worst(contact, truth, (1e-6, 0.4, 0.9), relative_x=(0.0, 0.9, 1.05))
    for name, error in found.items():
        assert error < {"dissipation_kernel": 1e-11, "pressure": 1e-12, "pressure_moment": 1e-12}.get(name, 1e-13), name


def test_moments_of_many_rows():
    """P p - int p dP by Gauss' rule between the knots, p being a sum of tips: measured 3e-9, the roots being its limit."""
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 1.0, 41))
    half, x, knots = 0.9, np.array([0.1, 0.5, 0.85, 0.95]), np.array(contact.breaks)
    load = float(contact.load(half))
    node, weight = np.polynomial.legendre.leggauss(40)
    for at in x:
        marks = np.unique(np.concatenate([[min(at, half), half], knots[(knots > at) & (knots < half)]]))
        # a = mark + step^2: behind each knot everything is smooth in the root.
        step = np.sqrt(np.diff(marks))[:, None]
        inner = marks[:-1, None] + np.square(step * (1 + node) / 2)
        inside = np.sum(step**2 * (1 + node) / 2 * weight * contact.pressure(at, contact.load(inner)) * contact.stiffness(inner))
        exact = load * float(contact.pressure(at, load)) - inside
        assert float(contact.pressure_moment(at, load)) == pytest.approx(exact, rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("sides", [1, 2])
def test_rows_of_a_parabola_are_hertz(sides):
    contact = profile_contact(table(lambda x: x * x / 4, 3.0, 41, sides))
    hertz = HertzContact(modulus=1.0, radius=2.0, datum_length=3.0)
    x, load = np.array([0.0, 0.2, 0.9, 2.5]), 0.8
    for name in ("pressure", "slip_integral"):
        np.testing.assert_allclose(getattr(contact, name)(x, load), getattr(hertz, name)(x, load), rtol=1e-12, atol=1e-15)
    for name in ("half_width", "log_distance"):
        assert float(getattr(contact, name)(load)) == pytest.approx(float(getattr(hertz, name)(load)), rel=1e-13)
    for slipped in (1e-6, 0.01, 0.3):
        assert float(contact.dissipation_kernel(load, slipped)) == pytest.approx(
            float(hertz.dissipation_kernel(load, slipped)), rel=1e-9
        )


def test_more_rows_come_closer_with_the_square_of_the_step():
    """1 - sqrt(1 - x^2) against a fine table of itself: four times the rows, a sixteenth of the error at least."""
    half = np.linspace(0.3, 0.75, 40)
    fine = profile_contact(table(lambda x: 1 - np.sqrt(1 - x * x), 0.8, 641)).load(half)
    errors = []
    for count in (11, 41, 161):
        contact = profile_contact(table(lambda x: 1 - np.sqrt(1 - x * x), 0.8, count))
        errors.append(np.max(np.abs(contact.load(half) / fine - 1)))
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12
    assert errors[2] < 1e-5


def test_rows_of_a_flat_and_rounded_face_tend_to_it():
    profile = FlatRounded(radius=1.0, flat_half_length=0.5)
    flat = profile_contact(profile)
    contact = profile_contact(table(profile.height, 2.0, 401))
    load = np.array([1e-2, 0.1, 0.5])
    np.testing.assert_allclose(contact.half_width(load), flat.half_width(load), rtol=2e-4)
    assert float(contact.half_width(0.0)) == pytest.approx(0.5, abs=0.006)


def test_half_width_inverts_load_over_sixteen_decades():
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 3.0, 61))
    load = float(contact.load(2.99)) * 10.0 ** np.linspace(-16, 0, 161)
    np.testing.assert_allclose(contact.load(contact.half_width(load)), load, rtol=2e-14)


def test_height_goes_through_the_rows_and_is_the_initial_gap():
    rows = [[0.0, 0.0], [0.3, 0.01], [0.5, 0.08], [1.1, 0.2], [1.5, 1.0]]
    profile = Tabulated(points=rows)
    np.testing.assert_allclose(profile.height([row[0] for row in rows]), [row[1] for row in rows], atol=1e-16)
    fine = profile.height(np.linspace(-2, 2, 4001))
    assert np.all(np.diff(fine[2000:]) >= 0)
    np.testing.assert_array_equal(profile.height(-np.linspace(-2, 2, 4001)), fine)
    smooth = table(lambda x: np.cosh(x) - 1, 2.0, 21)
    x = np.array([0.33, 1.0, 1.9])
    contact = profile_contact(smooth)
    np.testing.assert_allclose(2 / np.pi * contact.slip_integral(x, float(contact.load(1.99))), smooth.height(x), rtol=1e-13)
    np.testing.assert_allclose(smooth.height(x), np.cosh(x) - 1, rtol=1e-3)
    np.testing.assert_allclose(
        Tabulated(points=[[0, 0], [1, 0.5], [2, 2.0]]).height([0.7, 1.5]), Hertz(radius=1.0).height([0.7, 1.5])
    )


def test_a_contact_wider_than_the_table_is_refused():
    contact = profile_contact(table(lambda x: x * x / 2, 1.0, 11))
    with pytest.raises(InputError, match=r"normal load 2 needs a contact wider than the table, whose last x = 1 carries 0\.785"):
        contact.half_width(2.0)


def test_rows_under_which_the_contact_splits_are_refused():
    rows = [[0, 0], [0.2, 0.2], [0.4, 0.4], [0.6, 0.4], [0.8, 0.4], [1.0, 0.41]]
    with pytest.raises(InputError, match=r"split near a half-width of"):
        profile_contact(Tabulated(points=rows))


def test_dissipation_of_a_table_by_two_routes():
    """Quadrature over time and along arcs is cut where an edge passes a knot: 4e-6 apart where it was not, measured 1e-14."""
    profile = table(lambda x: np.cosh(x) - 1, 3.0, 31)
    scene = make_scene(ellipse()).vary(profile=profile)
    solution = solve(scene, x=[0.0], fields=("dissipation",))
    assert solution.loop_work == pytest.approx(solution.dissipation, rel=1e-11, abs=0)


@pytest.mark.parametrize("load", [1e-12, 1e-6, 1e-2])
def test_beside_a_flat_small_loads_keep_their_digits(load):
    """Rows with a flat middle: the exact P(a) of a rounded flat up to the second knot."""
    profile = Tabulated(points=[[0, 0], [0.5, 0], [0.75, 0.03], [1, 0.12], [1.5, 0.5]])
    contact = profile_contact(profile)
    curvature = profile.spline().curvature
    bend = float(curvature[np.flatnonzero(curvature)[0]])
    flat = profile_contact(FlatRounded(radius=1 / bend, flat_half_length=contact.least))
    small = load * float(contact.load(contact.breaks[0]))
    x = np.array([0.0, 0.4, 0.499])
    np.testing.assert_allclose(contact.half_width(small) - contact.least, flat.half_width(small) - contact.least, atol=4e-16)
    # What the last digit of a is worth over a - b: all that half-widths can tell.
    digits = 1e-11 + 4e-16 / (float(flat.half_width(small)) - contact.least)
    np.testing.assert_allclose(contact.pressure(x, small), flat.pressure(x, small), rtol=digits)
    assert float(contact.dissipation_kernel(small, 0.3 * small)) == pytest.approx(
        float(flat.dissipation_kernel(small, 0.3 * small)), rel=10 * digits
    )


def test_work_across_knots_is_cut_at_those_between_alone():
    """Cut at every knot that any instant crosses, 60 knots took twenty times the nodes for the same W."""
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 1.2, 61), 100.0)
    nodes = []

    def advance(load):
        nodes.append(np.size(load))
        return contact.law.advance(load)

    seen = replace(contact, law=replace(contact.law, advance=advance))
    load, slipped = np.linspace(20.0, 60.0, 40), 0.3
    between = np.searchsorted(contact.break_loads, load) - np.searchsorted(contact.break_loads, load - slipped)
    assert np.max(between) > 0
    np.testing.assert_allclose(seen.dissipation_kernel(load, slipped), contact.dissipation_kernel(load, slipped), rtol=1e-14)
    assert sum(nodes) < 13 * np.sum(between + 1)


def test_slip_across_many_knots_keeps_its_digits():
    """arccosh(|x|/c) with several knots between c and x: from the rise of P over one mean rate it was 1e-7 off, W(x) 5e-8."""
    contact = profile_contact(table(lambda x: np.cosh(x) - 1, 1.2, 601), 100.0)
    half = contact.half_width(40.0)
    x = half * (1 + np.geomspace(1e-4, 1e-1, 200))
    found = contact.arccosh_ratio(x, contact.load(x) - 40.0, contact.advance(40.0))
    np.testing.assert_allclose(found, np.arccosh(x / half), rtol=1e-11)


# ------------------------------------------------------------------------------------------------------------- quantised rows
# Seconds of CPU after which a child that does the work of a few is killed: it is in a loop that never ends.
WATCHDOG = 300
SHAPES = {
    "hertz": lambda x: x**2 / 2000,
    "flat": lambda x: np.maximum(x - 1, 0) ** 2 / 2000,
    "cosh": lambda x: (np.cosh(x) - 1) / 1000,
    "straight flanks": lambda x: np.maximum(x - 0.3, 0) / 100,
    "two curvatures": lambda x: (x**2 + 4 * np.maximum(x - 1, 0) ** 2) / 2000,
    "stairs": lambda x: np.floor(7 * x) / 1000,
}


def rows_of(chance):
    """Rows of a shape with 2 to 6 decimals, evenly spaced or not, a third of them with noise that is made to rise: plateaus."""
    name = str(chance.choice(list(SHAPES)))
    count, decimals = int(chance.choice([5, 11, 31, 101, 301])), int(chance.integers(2, 7))
    x = np.linspace(0, 3, count)
    if chance.random() < 0.3:
        x = np.unique(np.round(np.append(chance.uniform(0, 3, count), 0), int(chance.integers(2, 9))))
    h = SHAPES[name](x)
    if chance.random() < 0.3:
        h = np.maximum.accumulate(np.maximum(h + 10.0**-decimals * chance.standard_normal(len(x)), h[0]))
    return x, np.round(h - h[0], decimals)


def judged(x, h):
    """What becomes of rows: "door", "split", "solved", or a fault in words."""
    try:
        profile = Tabulated(points=np.stack([x, h], axis=1))
    except ValueError:
        return "door"
    if not np.allclose(profile.height(x), h, rtol=0, atol=1e-12 * h[-1]):
        return "the curve misses the rows"
    try:
        contact = profile_contact(profile)
    except InputError as refusal:
        said = str(refusal)
        named = "row" in said and "near a half-width of" in said and "\n" not in said
        return "split" if named else f"refused in other words: {said}"
    half = np.linspace(contact.least, contact.extent, 3001)[1:]
    loads = contact.load(half)
    if np.min(np.diff(loads)) < -1e-13 * loads[-1]:
        return "P falls"
    load = loads[-1] * np.geomspace(1e-4, 1, 40)
    if np.max(np.abs(contact.load(contact.half_width(load)) / load - 1)) > 1e-10:
        return "a(P) is not the inverse of P(a)"
    return "solved" if np.all(contact.pressure(x[:20], load[-2]) >= 0) else "no pressure"


def in_a_child(call):
    """What `call`, of a function of this module, gives (JSON), in a process whose CPU time is bounded."""
    bound = f"import resource; resource.setrlimit(resource.RLIMIT_CPU, ({WATCHDOG}, {WATCHDOG + 5}))"
    path = os.pathsep.join([str(Path(__file__).parent), str(Path(__file__).parents[1])])
    code = f"{bound}; import json, {Path(__file__).stem} as here; print(json.dumps(here.{call}))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"ended with {done.returncode} (-24: it never returns): {done.stderr[-500:]}"
    return json.loads(done.stdout)


def fuzzed(seed, count):
    """How often each thing becomes of `count` quantised tables."""
    chance = np.random.default_rng(seed)
    found = [judged(*rows_of(chance)) for _ in range(count)]
    return {what: found.count(what) for what in sorted(set(found))}


def parabola(count, decimals):
    x = np.linspace(0, 3, count)
    return np.stack([x, np.round(x * x / 2000, decimals)], axis=1)


def refusals(cases):
    """What is said of parabolas in steps."""
    said = []
    for count, decimals in cases:
        with pytest.raises(InputError) as refusal:
            profile_contact(Tabulated(points=parabola(count, decimals)))
        said.append(str(refusal.value))
    return said


def command(*words):
    """Exit code and stderr of the command line."""
    said = io.StringIO()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()):
        code = main(words)
    return code, " ".join(said.getvalue().split())


@pytest.mark.parametrize(("seed", "count"), [(14, 60), pytest.param(140, 1500, marks=pytest.mark.slow)])
def test_quantised_rows_are_solved_or_refused_with_their_row(seed, count):
    """Zero-width intervals, curvatures of 1e12 and a loop without end before; now rows either hold together or are refused."""
    found = in_a_child(f"fuzzed({seed}, {count})")
    assert set(found) <= {"door", "split", "solved"}, found
    assert found["solved"] > count / 5
    assert found["split"] > count / 5


def test_a_parabola_in_steps_is_refused_with_the_step():
    """h = x^2/2000 at 3/(count - 1) apart: a step of h is up to 200 times what the parabola bends by between two rows."""
    cases = [(101, 5), (301, 5), (1001, 6), (1001, 5)]
    for (_, decimals), said in zip(cases, in_a_child(f"refusals({cases})"), strict=True):
        assert said.startswith("profile.points, row ")
        assert f"h is written in steps of 1e-{decimals:02d}" in said
        assert "write h with more digits" in said


@pytest.mark.parametrize("name", ["check", "exact"])
def test_the_commands_end_on_quantised_rows(name, tmp_path):
    np.savetxt(tmp_path / "rows.csv", parabola(101, 5), delimiter=",", fmt="%.5f")
    base = make_scene(ellipse()).model_dump_json(exclude={"profile", "bodies"})
    scene = json.loads(base) | {"profile": {"kind": "tabulated", "file": "rows.csv"}}
    (tmp_path / "mine.json").write_text(json.dumps(scene), encoding="utf-8")
    words = (name, str(tmp_path / "mine.json"), "--quiet", *(() if name == "check" else ("--out", str(tmp_path / "out"))))
    code, said = in_a_child(f"command{words}")
    assert code == 2
    assert "profile.file = 'rows.csv', row " in said
    assert "h is written in steps of 1e-05" in said


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_bend_up_make_a_curve_that_does(seed):
    """Random convex rows, half of them with stretches on a line, which had a knee bent into them: none is refused."""
    chance = np.random.default_rng(seed)
    for _ in range(40):
        count = int(chance.choice([4, 11, 31]))
        bends = chance.exponential(size=count - 1) * (chance.random(count - 1) < chance.choice([0.3, 1.0]))
        bends[-1] += 0.1
        x = np.append(0, np.cumsum(chance.uniform(0.2, 1, count - 1)))
        h = np.append(0, np.cumsum(np.cumsum(bends) * np.diff(x)))
        profile = Tabulated(points=np.stack([x, h], axis=1))
        profile_contact(profile)
        curvature = profile.spline().curvature
        if np.all(bends > 0):
            assert np.min(curvature[1:]) > -1e-9 * np.max(curvature)


def test_rows_on_a_line_are_followed():
    """A chamfer: flat to 1, then straight from 1.5 on: its slope is met, without a knee, however the last digits fall."""
    x = np.arange(31) / 10
    h = np.where(x <= 1, 0, np.where(x <= 1.5, (x - 1) ** 2 / 10, 0.025 + (x - 1.5) / 10))
    profile = Tabulated(points=np.stack([x, h], axis=1))
    between = np.linspace(1.5, 3, 61)
    np.testing.assert_allclose(profile.height(between), 0.025 + (between - 1.5) / 10, rtol=1e-12)


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        ([[0, 0], [1, 1], [1 + 1e-10, 1.1], [2, 3]], r"row 3: x = 1.0000000001 is nearer to the row before than 1e-09 of itself"),
        ([[k, k * k] for k in range(2001)], r"row 2001: the profile has 2,001 rows of x >= 0, and at most 2,000 are taken"),
    ],
    ids=["close", "many"],
)
def test_rows_that_no_engine_can_take_are_refused_at_the_door(rows, why):
    with pytest.raises(ValueError, match=why):
        Tabulated(points=rows)
