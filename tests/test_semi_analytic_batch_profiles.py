"""Batches of every profile: their values are those of the engine that marches; parameters broadcast; the limit of sliding."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Tabulated,
    Wedge,
)
from semi_analytic import Reason, dissipation, peak_dissipation, solve, steady_ellipse
from semi_analytic.profiles import contact_of
from semi_analytic.steady_ellipse import (
    LamTable,
    corner_angles,
    dissipation_of,
    ellipses_of,
    phase_of,
    slip_moment,
    works_over_time,
)
from semi_analytic_cases import UNIT, ellipse, make_scene

MATERIAL = Materials(upper=UNIT, lower=UNIT)
# P0, P1, Q0, Q1, phase in degrees; E* = 1, R = 1: a runs through 0.9 to 1.6
LOADS = [
    (1.5, 0.5, 0.0, 0.5, 60.0),
    (1.5, 0.5, 0.3, 0.9, 90.0),
    (1.2, 0.9, 0.0, 0.2, 30.0),
    (1.5, 0.0, 0.0, 1.4, 90.0),
    (1.0, 0.6, 0.1, 0.3, -70.0),
]
PROFILES = {
    "power law": PowerLaw(exponent=3.3, length=1.0, rise=0.5),
    "compound, outside blunter": Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.2),
    "compound, outside sharper": Compound(inner_radius=3.0, outer_radius=0.5, inner_half_length=1.7),
    "wedge": Wedge(tip_radius=1.0, tip_half_length=0.9),
    "polynomial": EvenPolynomial(length=1.0, rises=(0.5, -0.05, 0.01)),
    "table of five rows": Tabulated(points=[[float(x), float(x * x / 2)] for x in (0.0, 1.0, 2.0, 3.0, 4.0)]),
    "function": CallableProfile(slope_function=np.sinh, extent=4.0),
}


def question(loads, friction=1.0, **changes):
    columns = np.array(loads, dtype=float).T
    keys = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude")
    arguments = dict(zip(keys, columns, strict=False)) | {"phase": np.radians(columns[4]), "friction_coefficient": friction}
    return {"material": MATERIAL} | arguments | changes


def solved(profile, row, friction=1.0, **asked):
    scene = make_scene(ellipse(*row), friction).vary(profile=profile)
    return solve(scene, **asked)


@pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES)
def test_works_over_time_every_profile_is_that_of_solve(profile):
    """Worst measured 4e-14."""
    rows = LOADS[:2] if profile.kind in ("tabulated", "callable") else LOADS
    batch = dissipation(profile=profile, **question(rows))
    alone = [solved(profile, row, x=[0.0], fields=("dissipation",)).dissipation for row in rows]
    np.testing.assert_allclose(batch.value, alone, rtol=1e-10)
    assert np.all(batch.reason == Reason.NONE)


@pytest.mark.parametrize("name", ["power law", "compound, outside blunter", "wedge", "polynomial"])
def test_peak_of_every_profile_is_the_largest_density_of_solve(name):
    profile, row = PROFILES[name], LOADS[1]
    peak = peak_dissipation(profile=profile, **question([row]))
    x = np.linspace(0.97, 1.03, 61) * peak.place[0]
    density = solved(profile, row, x=x, fields=("dissipation_density",)).dissipation_density
    assert peak.value[0] == pytest.approx(np.max(density), rel=1e-6, abs=0)


VARIED = {
    "power_law": (PowerLaw, {"exponent": [1.0, 2.5, 4.0], "length": 1.5, "rise": [0.4, 0.5, 0.6]}),
    "compound": (
        Compound,
        {"inner_radius": [1.0, 2.0, 1.5], "outer_radius": [3.0, 0.5, 1.5], "inner_half_length": [1.2, 1.4, 1.0]},
    ),
    "wedge": (Wedge, {"tip_radius": [1.0, 0.7, 2.0], "tip_half_length": [0.9, 0.5, 5.0]}),
    "polynomial": (EvenPolynomial, {"length": [1.0, 1.0, 2.0], "rises": (0.5, [0.01, 0.02, 0.03])}),
}


@pytest.mark.parametrize("kind", VARIED)
def test_parameters_of_every_kind_broadcast(kind):
    model, keys = VARIED[kind]
    loads = question([LOADS[1]])
    batch, peak = (call(profile={"kind": kind} | keys, **loads) for call in (dissipation, peak_dissipation))
    for k in range(3):
        numbers = {
            name: tuple(float(np.broadcast_to(rise, 3)[k]) for rise in value) if name == "rises" else np.broadcast_to(value, 3)[k]
            for name, value in keys.items()
        }
        one = model(**numbers)
        assert batch.value[k] == pytest.approx(dissipation(profile=one, **loads).value[0], rel=1e-12, abs=0)
        alone = peak_dissipation(profile=one, **loads)
        assert peak.value[k] == pytest.approx(alone.value[0], rel=1e-9, abs=0)
        assert peak.place[k] == pytest.approx(alone.place[0], rel=1e-6)


def test_power_laws_dissipate_as_two_over_n():
    """Lam = [P ln(P/P_c) - P + P_c]/n: neither the rise nor the length plays a part."""
    keys = {"kind": "power_law", "exponent": np.array([1.0, 2.0, 5.0]), "length": 3.0, "rise": [0.1, 1.0, 7.0]}
    batch = dissipation(profile=keys, **question([LOADS[0]]))
    hertz = dissipation(profile=Hertz(radius=1.0), **question([LOADS[0]]))
    np.testing.assert_allclose(batch.value * keys["exponent"] / 2, hertz.value[0], rtol=1e-14)


def test_compound_of_one_curvature_is_hertz_and_of_a_blunt_tip_flat():
    for row in LOADS:
        loads = question([row])
        hertz = dissipation(profile=Hertz(radius=2.0), **loads).value[0]
        same = dissipation(profile=Compound(inner_radius=2.0, outer_radius=2.0, inner_half_length=1.5), **loads).value[0]
        flat = dissipation(profile=FlatRounded(radius=1.0, flat_half_length=0.7), **loads).value[0]
        blunt = dissipation(profile=Compound(inner_radius=1e14, outer_radius=1.0, inner_half_length=0.7), **loads).value[0]
        assert (same, blunt) == pytest.approx((hertz, flat), rel=1e-11)


# Forward and reverse work for P0 = f = E* = 1 and (P1, Q1, phase), by int w' Lam dt in 25 digits, cut at the corners.
IN_DIGITS = {
    ("compound, outside blunter", 0.4, 0.35, 1.0): ("0.041398701088727516913", "0.00033343828903031071335"),
    ("compound, outside blunter", 0.75, 0.3, 2.2): ("0.037838382192384116972", "0.000061655928659698238722"),
    ("compound, outside sharper", 0.4, 0.35, 1.0): ("0.029191134879658040231", "0.00033343828810855715002"),
    ("wedge", 0.4, 0.35, 1.0): ("0.057673357622352524098", "0.00033393588535772295947"),
    ("wedge", 0.75, 0.3, 2.2): ("0.04919078848683133439", "0.000061655928659698238722"),
    ("polynomial", 0.4, 0.35, 1.0): ("0.044330880266846783043", "0.00036178788163388404561"),
    ("polynomial", 0.75, 0.3, 2.2): ("0.03900022605318732545", "0.000064305974208750242427"),
    ("function", 0.4, 0.35, 1.0): ("0.036844292700648033458", "0.00030906513202821172791"),
    ("function", 0.75, 0.3, 2.2): ("0.0331223052286074161", "0.000059541063769364606937"),
}


@pytest.mark.parametrize("case", IN_DIGITS, ids=str)
def test_work_is_that_of_twenty_five_digits(case):
    """Worst measured 6e-14 of the forward part, 2e-15 absolute of the reverse one."""
    name, *row = case
    amplitude, force, phase = (np.array([value]) for value in row)
    batch = dissipation(
        profile=PROFILES[name],
        material=MATERIAL,
        friction_coefficient=1.0,
        mean_normal_load=1.0,
        normal_amplitude=amplitude,
        tangential_amplitude=force,
        phase=phase,
    )
    found = [batch.forward[0], batch.reverse[0]]
    np.testing.assert_allclose(found, [float(value) for value in IN_DIGITS[case]], rtol=1e-12, atol=1e-14)


def test_work_where_a_polynomial_hardly_grows_is_that_of_twenty_five_digits():
    """By int w' Lam dt and a rule that took P(a) for smooth it was 6e-7 off, in batches without a word."""
    profile, row = EvenPolynomial(length=1.0, rises=(1.0, -1.0, 0.43)), (1.0, 0.6, 0.0, 0.3, math.degrees(1.2))
    exact = float("0.024993744493561726468") + float("0.00040938678395082994304")
    assert dissipation(profile=profile, **question([row])).value[0] == pytest.approx(exact, rel=1e-12, abs=0)
    assert solved(profile, row, x=[0.0], fields=("dissipation",)).dissipation == pytest.approx(exact, rel=1e-12, abs=0)


def test_work_that_has_not_converged_has_a_reason(monkeypatch):
    monkeypatch.setattr(steady_ellipse, "_SETTLED", (-1.0, -1.0))
    batch = dissipation(profile=PROFILES["polynomial"], **question(LOADS[:1]))
    assert batch.reason.tolist() == [Reason.UNSETTLED]
    assert np.isnan(batch.value[0])


def random_loops(count, seed, largest=1.0):
    """P0 = 1; P1/P0, Q1 up to a share `largest` of gross sliding and the phase at random."""
    rng = np.random.default_rng(seed)
    ratio, phase = rng.uniform(0.01, 0.95, count), rng.uniform(0, math.pi, count)
    cosine = np.abs(np.cos(phase))
    force = rng.uniform(0, largest, count) * (-ratio * cosine + np.sqrt(1 - ratio**2 * (1 - cosine**2)))
    return ellipses_of(np.ones(count), ratio, force, phase, np.ones(count))


@pytest.mark.parametrize("profile", [*PROFILES.values(), Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.7)])
def test_work_over_the_contact_is_that_over_time(profile):
    """int M da/a against int w' Lam dt, forward and reverse; worst measured 4e-12 of A f^2 P0^2, the error of the latter."""
    loops = random_loops(6 if profile.kind in ("tabulated", "callable") else 150, 3)
    contact = contact_of(profile, MATERIAL)
    for one, other in zip(dissipation_of(loops, contact), works_over_time(loops, contact), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=3e-11)


def test_slip_moment_is_that_of_the_phases():
    """M(eta) against sums over 20,000 instants of each phase."""
    loops = random_loops(12, 8)
    above = np.linspace(0.02, 0.98, 7)[:, None] * ((loops.u + loops.v) / 2 + loops.amplitude)
    eta = loops.permanent + above
    sums = np.zeros((2, *eta.shape))
    for direction, name, length in ((1, "E-G", loops.turn), (0, "I-J", math.pi - loops.turn), (0, "J-M", loops.turn)):
        s = (np.arange(20_000)[:, None, None] + 0.5) / 20_000 * length
        rate, slipped, load = phase_of(name, loops, s)
        sums[direction] += np.sum(np.where(load - slipped < eta, rate * np.maximum(load - eta, 0.0), 0.0), axis=0) * length / 20_000
    np.testing.assert_allclose(slip_moment(loops, above), sums, rtol=0, atol=2e-4)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
def test_lam_of_the_table_is_that_of_the_contact(scale):
    """To 1e-14 of J(P), which is Lam of a front at 0; the careful one to 2e-11 of itself."""
    contact = contact_of(FlatRounded(radius=1.0, flat_half_length=1.0), MATERIAL)
    rng = np.random.default_rng(2)
    front, slipped = scale * rng.uniform(0.001, 1, (3, 700)), scale * 10 ** rng.uniform(-9, 0, (3, 700))
    table, load = LamTable(contact, *(math.frexp(share * scale)[1] - 1 for share in (1e-3, 2.0))), front + slipped
    exact = contact.dissipation_kernel(load, slipped)
    assert np.all(np.abs(table.quick(front, slipped, np.empty((3, 700))) - exact) <= 2e-14 * contact.dissipation_kernel(load, load))
    np.testing.assert_allclose(table.careful(front, slipped, np.empty((3, 700))), exact, rtol=2e-11)


@pytest.mark.parametrize("kind", ["compound", "wedge", "polynomial", "flat_rounded"])
def test_work_has_no_units(kind):
    """h(x) = H h1(x/l): loads in E* H, W in E* H^2, of profiles and loads over forty decades."""
    keys = {
        "compound": {"inner_radius": 1.0, "outer_radius": 3.0, "inner_half_length": 1.2},
        "wedge": {"tip_radius": 1.0, "tip_half_length": 0.9},
        "polynomial": {"length": 1.0, "rises": (0.5, 0.1)},
        "flat_rounded": {"radius": 1.0, "flat_half_length": 0.7},
    }[kind]
    length, height = (np.array(row) for row in ((1.0, 1e-20, 3e20, 1.0), (1.0, 1.0, 7.0, 1e-30)))
    units = {"length": length, "inner_half_length": length, "tip_half_length": length, "flat_half_length": length}
    varied = {
        name: [rise * height for rise in value] if name == "rises" else value * units.get(name, length**2 / height)
        for name, value in keys.items()
    }
    loads = {"mean_normal_load": 1.5, "normal_amplitude": 0.5, "tangential_amplitude": 0.4}
    batch = dissipation(
        profile={"kind": kind} | varied,
        material=MATERIAL,
        friction_coefficient=1.0,
        **{name: value * height for name, value in loads.items()},
    )
    np.testing.assert_allclose(batch.value / height**2, batch.value[0], rtol=1e-11)


@given(st.floats(0.02, 0.98), st.floats(0.05, 0.95), st.floats(0.05, 3.0), st.floats(0.1, 1.9))
def test_cuts_are_where_a_load_or_front_is_that_of_the_corner(ratio, use, phase, corner):
    e = ellipses_of(*(np.array([v]) for v in (1.0, ratio, use * (1 - ratio), phase, 1.0)))
    for name, marks in corner_angles(e, np.array([[corner]])).items():
        inside = marks[(marks > 1e-6) & (marks < marks[-1] - 1e-6)]
        _, slipped, load = phase_of(name, e.take(np.zeros(len(inside), dtype=int)), inside)
        touching = np.minimum(np.abs(load - corner), np.abs(load - slipped - corner)) < 1e-7
        # A corner beyond reach is answered by a cut at the greatest or least load.
        assert np.all(touching | (np.abs(np.abs(load - 1) - ratio) < 1e-7) | (np.abs(np.abs(load - slipped - 1) - ratio) < 1e-7))


# ---------------------------------------------------------------- the limit of gross sliding, and other ends


def limit(ratio, phase, friction, both):
    """Largest Q1, and Q0, for P0 = 1: 0, or such that both senses of slip are at their limit at once (P_T = 0)."""
    cosine = abs(math.cos(phase))
    if not both:
        return friction * (-ratio * cosine + math.sqrt(1 - ratio**2 * (1 - cosine**2))), 0.0
    r = math.sqrt((1 - ratio**2) / (1 - ratio**2 * cosine**2))
    u, v = (math.hypot(r * math.cos(phase) + sign * ratio, r * math.sin(phase)) for sign in (-1, 1))
    return friction * r, friction * (v - u) / 2


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize(
    "profile",
    [Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.7), *list(PROFILES.values())[:4]],
    ids=lambda profile: profile.kind,
)
def test_at_the_very_limit_of_sliding_the_work_is_finite_and_the_limit(profile, both):
    """|Q| = f P reached in one sense or both; from 1 - 1e-9 of it the work differs by less than 1e-7."""
    rows = [(ratio, phase) for ratio in (0.0, 0.3) for phase in (0.0, 1.0, math.pi / 2, math.pi, -math.pi / 2, -math.pi)]
    ratio, phase = (np.array(column)[:, None] for column in zip(*rows, strict=True))
    force, mean = (np.array(column)[:, None] for column in zip(*(limit(*row, 0.5, both) for row in rows), strict=True))
    batch = dissipation(
        profile=profile,
        material=MATERIAL,
        friction_coefficient=0.5,
        mean_normal_load=1.0,
        normal_amplitude=ratio,
        mean_tangential_load=mean,
        tangential_amplitude=force * [1.0, 1 - 1e-9],
        phase=phase,
    )
    assert np.all(batch.reason == Reason.NONE)
    assert np.all(batch.value > 0)
    np.testing.assert_allclose(batch.value[:, 0], batch.value[:, 1], rtol=1e-7)
    if both:
        assert np.all(batch.permanent_stick_load[:, 0] <= 1e-15)


def test_constant_load_at_the_limit_is_the_closed_form():
    """W = (4 f^2 P^2/(pi E*)) [(1 - k) ln(1 - k) + k - k^2/2] at k = 1."""
    batch = dissipation(profile=Hertz(radius=1.0), **question([(1.0, 0.0, 0.0, 0.5, 90.0)], 0.5))
    assert batch.value[0] == pytest.approx(4 * 0.25 / math.pi / 2, rel=1e-13, abs=0)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_full_unloading_along_a_line_through_the_origin_dissipates_nothing(sense):
    """A phase of pi is one to 1.2e-16 only, and P_min = 0: that opens the loop by as much."""
    rows = [(1.0, 1.0, sense * share, share, 90.0 - sense * 90.0) for share in (0.0, 0.2, 0.5)]
    for profile in (Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.7), PROFILES["wedge"]):
        batch = dissipation(profile=profile, **question(rows, 0.5))
        assert batch.reason.tolist() == [Reason.NONE] * 3
        assert np.all(np.abs(batch.value) <= 1e-15)


@pytest.mark.parametrize("call", [dissipation, peak_dissipation])
def test_every_member_has_a_value_or_a_reason(call):
    """Nothing but numbers, each nan, negative, 0, subnormal or infinite in turn."""
    strange = [math.nan, math.inf, -math.inf, -1.0, 0.0, 5e-324, 1e-200, 1.0]
    good = {
        "mean_normal_load": 1.0,
        "normal_amplitude": 0.3,
        "mean_tangential_load": 0.0,
        "tangential_amplitude": 0.2,
        "phase": 1.0,
    }
    for name in (*good, "friction_coefficient", "radius"):
        loads = {"friction_coefficient": 0.5} | good
        keys = {"kind": "hertz", "radius": 1.0}
        (keys if name == "radius" else loads)[name] = strange
        batch = call(profile=keys, material=MATERIAL, **loads)
        np.testing.assert_array_equal(np.isfinite(batch.value), batch.reason == Reason.NONE)
        assert np.all(batch.reason[:3] == Reason.INVALID)
        assert (
            batch.reason[7] == (Reason.SLIDING if name in ("tangential_amplitude", "mean_tangential_load") else Reason.NONE)
            or name == "normal_amplitude"
        )


def test_bad_parameters_are_the_members_own():
    keys = {"kind": "flat_rounded", "radius": [1.0, -1.0, np.nan], "flat_half_length": 0.7}
    assert dissipation(profile=keys, **question([LOADS[0]])).reason.tolist() == [Reason.NONE, Reason.INVALID, Reason.INVALID]
    keys = {"kind": "power_law", "exponent": [0.5, 2.0], "length": 1.0, "rise": 1.0}
    assert dissipation(profile=keys, **question([LOADS[0]])).reason.tolist() == [Reason.INVALID, Reason.NONE]
    keys = {"kind": "polynomial", "length": 1.0, "rises": (0.5, [-0.5, 0.1, np.nan])}
    assert dissipation(profile=keys, **question([LOADS[0]])).reason.tolist() == [Reason.INVALID, Reason.NONE, Reason.INVALID]


@pytest.mark.parametrize("name", ["table of five rows", "function"])
def test_loads_beyond_the_end_of_a_profile_are_told_apart(name):
    rows = [LOADS[0], (1000.0, 0.5, 0.0, 0.5, 60.0)]
    batch = dissipation(profile=PROFILES[name], **question(rows))
    assert batch.reason.tolist() == [Reason.NONE, Reason.EXTENT]
    assert np.isfinite(batch.value[0])


def test_what_cannot_vary_is_refused_in_a_sentence():
    for keys, words in (
        ({"kind": "tabulated", "points": [[0, 0], [1, 1]]}, "give the profile itself"),
        ({"kind": "compound", "inner_radius": 1.0}, "all its keys"),
        ({"kind": "polynomial", "length": 1.0, "rises": 0.5}, "rises is a list"),
        ({"kind": "hertz", "radius": "one"}, "must broadcast, and be of numbers"),
    ):
        with pytest.raises(InputError, match=words):
            dissipation(profile=keys, **question([LOADS[0]]))
