"""Friction work W and W(x): 30-digit references, brute force, closed forms, independent routes;
stiffness and damping from it.
"""

import cmath
import json
import math
from pathlib import Path

import numpy as np
import pytest

from scenes import (
    BodyEffects,
    CallableLoad,
    Compound,
    EllipseLoad,
    Estimate,
    InputError,
    Tabulated,
    TimeSeriesLoad,
    Wedge,
    load_scene,
)
from scenes.loads import HarmonicLoad
from semi_analytic import compliance, friction_work, hysteresis, solve
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import (
    CONVERGED_CHANGE_SHARE,
    integrals_by_halving,
    pointwise_dissipation,
)
from semi_analytic.history import history_of
from semi_analytic.profiles import contact_of
from semi_analytic.quadrature import graded_nodes
from semi_analytic_cases import (
    CORNERS,
    LOADS,
    PROFILES,
    REFERENCE,
    ellipse,
    extreme,
    make_scene,
    mindlin,
    polygon,
    reference_scene,
)
from semi_analytic_oracle import Work

ONLY = ("dissipation",)


# ------------------------------------------------------------------------------------ thirty digits
@pytest.mark.parametrize(
    "row",
    REFERENCE,
    ids=lambda row: (
        f"b{row['flat']}-{row['phase']:.0f}-f{row['friction']:g}-{row['tangential']:.2g}"
    ),
)
def test_dissipation_is_that_of_thirty_digits(row):
    """Worst measured 7e-13 relative of W, 1e-12 of max W(x)."""
    answer = solve(reference_scene(row), x=row["x"], fields=("dissipation", "dissipation_density"))
    exact = [float(value) for value in row["density"]]
    assert answer.dissipation == pytest.approx(float(row["dissipation"]), rel=1e-12, abs=0)
    np.testing.assert_allclose(answer.dissipation_density, exact, rtol=0, atol=1e-11 * max(exact))
    assert len(REFERENCE) == 41


NASTY = json.loads(
    (Path(__file__).parents[1] / "benchmarks" / "exact_history.json").read_text(encoding="utf-8")
)


def nasty_scene(name):
    case = NASTY[name]
    load = HarmonicLoad(
        mean_normal_load=case["mean"][0],
        mean_tangential_load=case["mean"][1],
        normal_harmonics=case["normal"],
        tangential_harmonics=case["tangential"],
    )
    return make_scene(load, case["friction"])


@pytest.mark.parametrize("name", NASTY)
def test_nasty_harmonics_against_thirty_digits(name):
    """Odd harmonics up to the eleventh, 1e-6 from gross sliding: W to 1e-12, W(x) to 1e-11 of its
    largest.

    Measured 1e-15 and 1e-15; one pass of the rule without halving leaves 4e-8 in W(x) here, 3e-4
    with harmonics up to the 23rd.
    """
    case = NASTY[name]
    solution = solve(nasty_scene(name), x=case["x"], fields=("loop_work", "dissipation_density"))
    exact = np.array([float(value) for value in case["density"]])
    assert solution.dissipation == pytest.approx(float(case["dissipation"]), rel=1e-12, abs=0)
    assert solution.loop_work == pytest.approx(float(case["dissipation"]), rel=1e-11, abs=0)
    np.testing.assert_allclose(
        solution.dissipation_density, exact, rtol=0, atol=1e-11 * np.max(exact)
    )
    assert solution.record.notes == ()


def test_error_of_pointwise_work_is_honest(monkeypatch):
    """Halved once only, W(x) is out by 3e-13 and the estimate says 4e-8, what the first pass was
    out by; left to itself, 1e-15.
    """
    case = NASTY["square wave"]
    scene = nasty_scene("square wave")
    spans = history_of(scene.load.path(), scene.friction.coefficient, 6).cycles[-1]
    contact = contact_of(scene.profile, scene.material)
    exact = np.array([float(value) for value in case["density"]])
    for halvings, most, least in ((0, 1e-6, 1e-9), (17, 1e-11, 0.0)):
        monkeypatch.setattr(friction_work, "_MOST_HALVINGS", halvings)
        work = pointwise_dissipation(contact, 1.0, spans, np.array(case["x"]))
        assert np.all(np.abs(work.total - exact) <= work.error + 2e-15 * np.max(exact))
        assert least < np.max(work.error) / np.max(exact) < most


# -------------------------------------------------------------------------------------- brute force


# Parts of a span, where P(a) hardly grows or harmonics drive the front.
PARTS = {"hardly growing": 8, "harmonics": 3, "harmonics to 1e-3": 8}
FEW = [
    ("hertz", "ellipse to 1e-4"),
    ("hertz", "harmonics"),
    ("long flat", "polygon"),
    ("short flat", "ellipse to 1e-4"),
    ("|x|^1.01", "tilted ellipse"),
    ("compound", "ellipse"),
    ("wedge", "rows"),
    ("table", "tilted ellipse"),
    ("polynomial", "polygon"),
    ("hardly growing", "polygon"),
    ("function", "ellipse to 1e-4"),
]
ALL = [(profile, load) for profile in PROFILES for load in LOADS if (profile, load) not in FEW]


def edges_of(work):
    """Half-widths of contact and of stick at the ends of all spans of slip, ascending."""
    ends = [(slip, time) for slip in work.slips for time in (slip.begin, slip.end)]
    return np.unique(
        work.half(
            [load for slip, time in ends for load in (slip.front(time), slip.phase.loads(time)[0])]
        )
    )


def points_of(work):
    """In the middle, next to the edges and on fronts."""
    edges = edges_of(work)
    low = edges[0]
    high = edges[-1]
    corners = [b * (1 + 1e-9) for b in work.corners[:1] if low < b < high]
    spread = [low + (high - low) * part for part in (1e-3, 0.42, 0.77)]
    return np.array([*spread, high * (1 - 1e-6), edges[len(edges) // 2], *corners], dtype=float)


@pytest.mark.parametrize(
    ("profile", "load"), [*FEW, *(pytest.param(*pair, marks=pytest.mark.slow) for pair in ALL)]
)
def test_work_by_brute_force(profile, load):
    """W to 1e-12, W(x) to 2e-12 of its largest, or to what the record says; it was 4.2e-8 off where
    P hardly grows.
    """
    scene = extreme(profile, load)
    history = history_of(scene.load.path(), scene.friction.coefficient, scene.cycles)
    work = Work(scene, history.covered[-1], parts=max(PARTS.get(profile, 1), PARTS.get(load, 1)))
    x = points_of(work)
    solution = solve(scene, x=x, fields=("dissipation_density", "dissipation"))
    stated = solution.record.errors
    work_of_cycle = np.sum(work.whole())
    exact = np.sum(work.density(x), axis=0)
    assert (
        abs(solution.dissipation - work_of_cycle)
        <= max(1e-12, stated.get("dissipation", 0.0)) * work_of_cycle
    )
    off = np.max(np.abs(solution.dissipation_density - exact))
    assert off <= max(2e-12, stated.get("dissipation_density", 0.0)) * np.max(exact)


@pytest.mark.parametrize("parts", [3, 300])
@pytest.mark.parametrize("profile", ["hertz", "long flat", "wedge", "table"])
def test_pointwise_work_of_a_straight_path_is_that_of_its_parts(profile, parts):
    """W(x) of rows, one of them next to gross sliding, and of each line between them cut in parts:
    worst measured 1e-14 of the largest.
    """
    corners = [(0.0, 0.0), CORNERS[0], (1.5, 0.75 * (1 - 1e-9)), *CORNERS[1:]]
    rows = np.array([[float(k), *corner] for k, corner in enumerate(corners)])
    times = np.unique([np.linspace(k, k + 1, parts + 1) for k in range(len(rows) - 1)])
    many_rows = np.column_stack([np.interp(times, rows[:, 0], column) for column in rows.T])
    scene = extreme(profile, "rows").vary(load=TimeSeriesLoad(rows=rows.tolist()))
    edges = solve(scene, x=0.0, time=rows[:, 0], fields=()).contact_edges
    x = np.linspace(0.0, 1.01 * float(np.max(edges)), 150)
    whole = solve(scene, x=x, fields=("dissipation_density",)).dissipation_density
    scene_of_parts = scene.vary(load=TimeSeriesLoad(rows=many_rows.tolist()))
    of_parts = solve(scene_of_parts, x=x, fields=("dissipation_density",)).dissipation_density
    np.testing.assert_allclose(of_parts, whole, rtol=0, atol=5e-14 * np.max(whole))


def test_no_point_misses_an_instant_in_which_the_load_hardly_grows():
    """Of a Python function the load turns at 1e-11, not at 0; by their last digits both loads fell
    there, and W(x) lacked 9e-12.
    """
    load = CallableLoad(
        normal_load=lambda t: 0.34 + 0.34 * 0.3 * math.cos(t),
        tangential_load=lambda t: 0.8 * 2.0 * 0.7 * 0.34 * math.cos(t - 0.5),
        duration=2 * math.pi,
        repeats=True,
    )
    scene = make_scene(load, friction=2.0)
    x = np.array([0.55, 0.6])
    exact = np.sum(Work(scene, 1).density(x), axis=0).astype(float)
    density = solve(scene, x=x, fields=("dissipation_density",)).dissipation_density
    np.testing.assert_allclose(density, exact, rtol=0, atol=1e-13 * np.max(exact))


# ------------------------------------------------------------------------------------- closed forms
def to_and_fro(use):
    """Q between +-use f P at constant P, by straight lines and as a wave."""
    q = use * 0.5 * 90.0
    return polygon([(90.0, 0.0)], [(90.0, q), (90.0, -q)]), ellipse(90.0, 0.0, 0.0, q)


def swinging(size):
    """P that swings by less than any number holds still: amplitudes without an inverse were a
    warning of overflow.
    """
    return HarmonicLoad(
        mean_normal_load=1.0, normal_harmonics=[(size, 20.0)], tangential_harmonics=[[0.2, 30.0]]
    )


def in_phase(phase):
    """Initial loading slips farther in than the cycle does, whose loop closes at a turning point
    inside a leg.
    """
    line = {
        "mean_normal_load": 3,
        "normal_amplitude": 0.3,
        "mean_tangential_load": 0.2,
        "tangential_amplitude": 1.4,
    }
    return EllipseLoad(
        **line, phase_degrees=0, bulk_stress_lower={"amplitude": 0.3, "phase_degrees": phase}
    )


# Scene, W, relative error.
CLOSED = {
    f"constant P, {use}, {load.kind}": (
        make_scene(load, 0.5, modulus=7.0),
        mindlin(use, 0.5, 90.0) / 7,
        1e-10 if use < 1e-3 else 1e-12,
    )
    for use in (1e-9, 1e-4, 0.3, 0.6, 0.99, 1 - 1e-9)
    for load in to_and_fro(use)
}
CLOSED |= {
    f"swings by {p}": (make_scene(swinging(p), 0.5), mindlin(0.4, 0.5, 1.0), 1e-13)
    for p in (1e-17, 1e-280, 2.2e-311, 5e-324)
}
# by quadrature
CLOSED |= {
    f"bulk at {phase}": (make_scene(in_phase(phase)), 0.3095379341715581, 1e-8)
    for phase in (0, 180)
}
# P_min/P0 = 1e-12: sixty digits by integrals over ever shorter parts, given here to twenty.
CLOSED["all but leaves"] = (
    make_scene(ellipse(1.0, 1 - 1e-12, 0.0, 0.2e-12), 0.5, radius=100.0),
    5.0929581788030931689e-26,
    1e-14,
)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * ("bulk" in name)) for name in CLOSED]
)
def test_work_has_its_closed_form(name):
    scene, exact, close = CLOSED[name]
    answer = solve(scene, x=[0.0], fields=ONLY)
    assert answer.dissipation == pytest.approx(float(exact), rel=close, abs=0)
    assert answer.steady_from == 1 or "bulk" in name


@pytest.mark.parametrize("phase", [3.58764470035453e-08, 1.3831076412129431e-09, -1e-7, 180 - 1e-7])
@pytest.mark.parametrize("load", [1.0, 183.45937329584282])
def test_what_sticks_for_ever_on_loads_next_to_a_line(phase, load):
    """P_T = P0 - (u + v)/2.

    P turns an instant before slip does, and the front stands on a knot: only rounding would take it
    beyond.
    """
    for ratio, use, friction in (
        (0.06, 0.25, 1.0),
        (0.12965094225905563, 0.6364538540831083, 1.0),
        (0.25, 0.63, 0.3),
    ):
        q1 = use * friction * (1 - ratio)
        solution = solve(
            make_scene(
                ellipse(load, ratio * load, 0.0, q1 * load, phase), friction, 0.0, 1 / load, 1.0
            ),
            x=[0.0],
            fields=ONLY,
        )
        r = q1 / friction * cmath.exp(-1j * math.radians(phase))
        permanent = 1 - (abs(r - ratio) + abs(r + ratio)) / 2
        assert solution.permanent_stick_half_width == pytest.approx(
            math.sqrt(4 * permanent / math.pi), rel=1e-9
        )


# --------------------------------------------------------------------------- corners of the profile
def table(count):
    x = np.linspace(0, 4, count)
    return Tabulated(points=np.column_stack([x, np.cosh(x) - 1]).tolist())


CORNERED = {
    "compound": Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.2),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=0.9),
    "table of 31 rows": table(31),
    "table of 301 rows": table(301),
}


@pytest.mark.parametrize("profile", CORNERED.values(), ids=CORNERED)
def test_an_arc_that_passes_corners_of_the_profile_keeps_its_digits(profile):
    """Q dU takes the logarithm along the arc, tractions and slips its kernels: 1e-12 and 4e-13;
    2e-6 and 2e-5 if not cut.
    """
    scene = make_scene(ellipse(1.0, 0.6, 0.1, 0.3, -70.0)).vary(profile=profile)
    answer = solve(scene, x=np.linspace(0.0, 1.6, 9), time=np.linspace(2.0, 20.0, 7))
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-11, abs=0)
    # The second rule of the estimate shares nothing but the kernel with the first.
    assert max(answer.record.errors[name] for name in ("shear", "slip")) < 1e-11


# ------------------------------------------------------------------------------ the rule of halving
@pytest.mark.parametrize(("width", "settles"), [(0.3, True), (1e-6, True), (0.0, False)])
def test_integrals_by_halving_and_what_they_say_of_themselves(width, settles):
    """int dx/(x^2 + w^2) and int sign(x - 1/3) dx over [-1, 1]; only the step is left unsettled,
    and says so.
    """

    def work(_, low, high):
        x, weights = graded_nodes(low, high)
        return np.sum(
            weights * (1 / (x * x + width * width) if width else np.sign(x - 1 / 3)), axis=-1
        )

    exact = 2 / width * math.atan(1 / width) if width else -2 / 3
    integral = integrals_by_halving(work, [-1.0], [1.0], CONVERGED_CHANGE_SHARE * abs(exact))
    # A pole beside an end of a part costs the rule 4e-12 however short the part: that it cannot
    # see.
    assert abs(integral.value[0] - exact) <= integral.error[0] + 3e-11 * abs(exact)
    assert bool(integral.error[0] <= 1e-10 * abs(exact)) is settles


# ---------------------------------------------------------------------------- stiffness and damping
def test_tangent_compliance_is_the_slope_of_the_loop_at_constant_load():
    """Central differences over 2e-4 of a leg, in slip both ways: 1e-7; and right after a reversal,
    in full stick.
    """
    scene = load_scene("cattaneo-mindlin")
    datum = scene.profile.datum_length
    for time, direction in ((1.5, 1), (2.5, -1), (3.7, 1)):
        near = solve(scene, x=[0.0], time=[time - 1e-4, time, time + 1e-4])
        slope = np.diff(near.tangential_displacement[[0, 2]]) / np.diff(
            near.tangential_load[[0, 2]]
        )
        assert slope[0] == pytest.approx(compliance(near, datum_length=datum)[0][1], rel=1e-6)
        assert np.sign(np.diff(near.tangential_load)[0]) == direction
    near = solve(scene, x=[0.0], time=[2.0, 2.0 + 1e-6])
    slope = np.diff(near.tangential_displacement) / np.diff(near.tangential_load)
    assert slope[0] == pytest.approx(compliance(near, datum_length=datum)[1][0], rel=1e-5)


def test_damping_ratio_is_that_of_the_linear_oscillator():
    answer = solve(load_scene("hertz-paper"), x=[0.0])
    datum = answer.scene.profile.datum_length
    loop = hysteresis(answer, datum_length=datum)
    assert loop.damping_ratio == pytest.approx(
        answer.dissipation / (2 * math.pi * loop.force_amplitude * loop.shift_amplitude)
    )
    assert loop.force_amplitude == pytest.approx(answer.scene.load.tangential_amplitude, rel=1e-12)
    cycle = answer.last_cycle
    assert loop.shift_amplitude == pytest.approx(
        np.ptp(answer.tangential_displacement[cycle]) / 2, rel=1e-3
    )
    assert loop.secant_stiffness * loop.shift_amplitude == pytest.approx(loop.force_amplitude)
    assert 0.001 < loop.damping_ratio < 0.1
    stuck = solve(load_scene("full-stick"), x=[0.0])
    assert hysteresis(stuck, datum_length=datum).damping_ratio == 0


def test_stiffness_of_half_planes_needs_a_datum_length_or_the_compliance_of_bodies():
    """U + (A/pi) ln(L/L_0) Q, U + c_t Q, and corrected theory, which has c_t already."""
    scene = load_scene("blocks")
    answer = solve(scene, x=[0.0])
    for call in (hysteresis, compliance):
        with pytest.raises(InputError, match="U of half-planes has no datum: give datum_length"):
            call(answer)
        with pytest.raises(InputError, match="one of the two"):
            call(answer, datum_length=1.0, effects=BodyEffects(datum_length=1.0))
        with pytest.raises(InputError, match=r"datum_length = -1\.0 is refused"):
            call(answer, datum_length=-1.0)
    length = scene.profile.datum_length
    near = hysteresis(answer, datum_length=length)
    far = hysteresis(answer, datum_length=math.e * length)
    modulus = composite_modulus(scene.material)
    softer = 1 / far.secant_stiffness - 1 / near.secant_stiffness
    assert softer == pytest.approx(2 / (math.pi * modulus), rel=0.05)
    slopes = [
        compliance(answer, datum_length=stated)[1][-1] for stated in (length, math.e * length)
    ]
    assert np.diff(slopes) == pytest.approx(2 / (math.pi * modulus), rel=1e-9)

    effects = BodyEffects(datum_length=length, tangential_compliance=Estimate(1e-5))
    added = hysteresis(answer, effects=effects)
    corrected = hysteresis(solve(scene, x=[0.0], effects=effects))
    assert added.secant_stiffness == pytest.approx(corrected.secant_stiffness, rel=1e-3)
    assert added.damping_ratio == pytest.approx(corrected.damping_ratio, rel=1e-3)
    assert added.secant_stiffness < 0.9 * near.secant_stiffness
    slope_of_bodies = compliance(answer, effects=effects)[1][-1]
    assert slope_of_bodies - slopes[0] == pytest.approx(1e-5, rel=1e-9)
    with pytest.raises(InputError, match="count"):
        hysteresis(solve(scene, x=[0.0], effects=effects), datum_length=length)
    with pytest.raises(InputError, match="formula is that of half-planes"):
        compliance(solve(scene, x=[0.0], effects=effects))


@pytest.mark.parametrize("name", ["cattaneo-mindlin", "flat-rounded-paper", "rounded-wedge"])
def test_work_of_small_loops_is_the_cube_of_the_load(name):
    """-(2/3) Q^3 C'(P)/f at constant P with C the compliance, C' = -(A/pi) (da/dP)/a (Putignano,
    Ciavarella and Barber 2011); the next power of Q/(f P) is left.
    """
    load = 100.0
    share = 1e-3
    friction = 0.6
    force = share * friction * load
    cycle = [(load, force), (load, -force)]
    scene = load_scene(name).vary(
        friction=friction,
        load={"kind": "polygon", "initial_loading": [(load, 0.0)], "cycle": cycle},
        expected=[],
        tolerances={},
    )
    contact = contact_of(scene.profile, scene.material)
    half_width = float(contact.half_width(load))
    compliance_falls = 2 / (math.pi * composite_modulus(scene.material))
    compliance_falls /= half_width * float(contact.stiffness(half_width))
    work = solve(scene, x=0.0, fields="dissipation").dissipation
    assert work == pytest.approx(2 / 3 * force**3 * compliance_falls / friction, rel=share)
