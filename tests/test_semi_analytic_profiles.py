"""Normal contact of every profile: P(a), a(P), p, slip, logarithm and friction work of one load,
against h'' alone in more digits.

Measured quantities M of a superposition of flat punches are M = int m(alpha) dP; `law_of` has dP/d
alpha of each profile from the numbers of the scene (its own test: 30 digits of h'), and the
integrals are taken here in extended precision.
"""

import contextlib
import math
import signal

import mpmath as mp
import numpy as np
import pytest

from scenes import (
    CallableProfile,
    Compound,
    Elastic,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Materials,
    PowerLaw,
    Tabulated,
    Wedge,
    load_scene,
)
from semi_analytic import punch_superposition
from semi_analytic.elasticity import composite_modulus, coupling_constant
from semi_analytic.hertz import log_excess
from semi_analytic.profiles import contact_of, law_of_power
from semi_analytic.punch_superposition import PunchSuperposition, primitive_of
from semi_analytic_cases import UNIT
from semi_analytic_oracle import LONG, Punches, integrate, law_of


def contact_on(profile, modulus=1.0):
    """The contact of a profile between bodies of that composite modulus."""
    material = Elastic(young_modulus=2 * modulus, poisson_ratio=0.0)
    return contact_of(profile, Materials(upper=material, lower=material))


def table(height, extent, count, sides=1):
    """Rows of a function, on one side or on both."""
    x = np.linspace(-extent if sides == 2 else 0.0, extent, sides * (count - 1) + 1)
    return Tabulated(points=np.stack([x, height(x)], axis=1))


def cosh_less_one(x):
    return np.cosh(x) - 1


# Name to profile and the half-widths that are tried: next to its corners, far from them, and small.
CASES = {
    "hertz": (Hertz(radius=2.0), (1e-6, 1.3, 40.0)),
    "flat and rounded": (
        FlatRounded(radius=1.0, flat_half_length=1.0),
        (1.01, 1.044, 1.3, 40.0, 1e6),
    ),
    "compound, blunter": (
        Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=1.0),
        (0.9, 1 + 1e-5, 1.1, 1e4),
    ),
    "compound, sharper": (
        Compound(inner_radius=3.0, outer_radius=0.5, inner_half_length=1.0),
        (1e-3, 0.9, 1 + 1e-5, 1.1, 3.0, 1e4),
    ),
    "compound, flat": (
        Compound(inner_radius=1.0, outer_radius=1e4, inner_half_length=1.0),
        (0.9, 1 + 1e-5, 3.0, 1e4),
    ),
    "wedge": (Wedge(tip_radius=2.0, tip_half_length=1.0), (1e-3, 0.9, 1 + 1e-8, 1.1, 3.0, 1e4)),
    "table": (table(cosh_less_one, 1.0, 5), (1e-6, 0.4, 0.9)),
    "table with a flat": (
        table(lambda x: np.maximum(x - 0.5, 0) ** 2 + np.maximum(x - 1, 0) ** 2, 2.0, 9),
        (0.75, 1.01, 1.9),
    ),
    "table of a parabola": (table(lambda x: x * x / 4, 3.0, 13, 2), (0.2, 1.01, 2.9)),
    "function h": (CallableProfile(extent=3.0, height_function=cosh_less_one), (1e-6, 0.9, 2.9)),
    "function h'": (CallableProfile(extent=3.0, slope_function=np.sinh), (1e-6, 0.9, 2.9)),
}
CASES |= {
    f"polynomial {rises}": (EvenPolynomial(length=2.0, rises=rises), (1e-8, 0.7, 40.0))
    for rises in ((0.5,), (0.0, 0.3), (0.5, 0.25, 0.1), (1.0, -0.9, 0.5))
}
CASES |= {
    f"|x|^{n}": (PowerLaw(exponent=n, length=2.0, rise=0.5), (1e-6, 40.0))
    for n in (1.0, 1.01, 1.3, 2.0, 3.0, 3.5, 6.0, 20.0)
}
EVERY = pytest.mark.parametrize("name", CASES)
BOUNDED = ("tabulated", "callable")

# Relative errors admitted; measured 7e-13 of p at 0.999 a, where a last digit of a counts 500
# times, 1e-12 by a derivative.
LIMITS = {
    "pressure": 2e-12,
    "pressure_moment": 2e-12,
    "dissipation_kernel": 3e-11,
    "function h": 1e-11,
}


def kernels(contact, truth, a):
    """(name, arguments of the contact, exact value) at one half-width, the moments, weighted by
    P(alpha), too.
    """
    load = float(contact.load(a))
    a = LONG(a)
    least = truth.least
    for x in (float(a) * part for part in (0.0, 1e-3, 0.9, 0.999, 1 + 1e-9, 1 + 1e-3, 4.0)):
        at = LONG(x)
        for moment, weight in (("", None), ("_moment", truth.law.load)):
            # p of the tip of a wedge is infinite
            if x < a and (x > 0 or truth.law.rate(LONG(1e-9)) < 1e-7):
                yield "pressure" + moment, (x, load), truth.traction(at, least, a, weight)
            if at > least:
                yield "slip_integral" + moment, (x, load), truth.slip(at, least, a, weight)
    yield "approach_integral", (load,), truth.log(least, a)
    yield "approach_moment", (load,), truth.log(least, a, truth.law.load)
    for part in (0.999, 0.1):
        slipped = load - float(contact.load(float(least + part * (a - least))))
        if front := load - slipped:  # as P - P_c has it: for |x|^20 nothing is left of 1e-20 P
            c = LONG(float(contact.half_width(front)))
            yield (
                "dissipation_kernel",
                (load, slipped),
                truth.total(lambda alpha, c=c: np.log1p((alpha - c) / c), c, a),
            )


@EVERY
def test_every_kernel_is_its_integral_over_the_punches_and_its_error_is_honest(name):
    profile, widths = CASES[name]
    contact = contact_on(profile)
    truth = Punches(profile)
    for a in widths:
        assert float(contact.half_width(contact.load(a))) == pytest.approx(
            a, rel=3e-15 if profile.kind != "callable" else 1e-12
        )
        for kernel, arguments, true in kernels(contact, truth, a):
            moment = kernel.endswith("moment")
            if moment and profile.kind == "callable":
                continue
            value = float(getattr(contact, kernel)(*arguments))
            exact = float(true)
            limit = max(LIMITS.get(kernel, 4e-14), LIMITS.get(name, 0.0))
            assert value == pytest.approx(exact, rel=limit, abs=0), (kernel, a, arguments)
            if isinstance(contact, PunchSuperposition) and not moment:
                estimate = float(contact.quadrature_error(kernel, *arguments))
                close = arguments[0] / arguments[1] if kernel == "dissipation_kernel" else 1.0
                of_truth = 1e-14
                # the exact value is that between two half-widths of a last digit each
                if kernel == "dissipation_kernel":
                    inner = float(contact.half_width(arguments[0] - arguments[1]))
                    of_truth += 8 * np.finfo(float).eps * float(a) / (float(a) - inner)
                assert abs(value - exact) <= estimate + of_truth * abs(exact), (
                    kernel,
                    a,
                    arguments,
                )
                assert estimate <= 1e-9 * close * abs(exact) * (1 + abs(math.log(a))), (
                    kernel,
                    a,
                    arguments,
                )


@EVERY
def test_half_width_inverts_load_over_sixteen_decades(name):
    contact = contact_on(CASES[name][0])
    kind = CASES[name][0].kind
    load = 10.0 ** np.linspace(-16, 0, 161) * (
        float(contact.load(0.996 * contact.extent)) if kind in BOUNDED else 1e8
    )
    # On a flat face a itself keeps no more digits of a - b than a double leaves it: the advance of
    # the edge keeps all.
    load_again = (
        contact.law.load(contact.law.edge_advance(load))
        if contact.least_half_width
        else contact.load(contact.half_width(load))
    )
    np.testing.assert_allclose(load_again, load, rtol=2e-14)
    assert np.all(np.diff(contact.half_width(load)) >= 0)


@pytest.mark.parametrize(
    "name", [name for name, (profile, _) in CASES.items() if profile.kind != "callable"]
)
def test_close_half_widths_keep_their_digits(name):
    """arccosh(x/a) and 1/sqrt(a^2 - x^2) from the difference of the loads, against their
    definitions.
    """
    profile, widths = CASES[name]
    contact = contact_on(profile)
    for a in widths:
        load = float(contact.load(a))
        for part in (0.5, 1e-2, 1e-4, 1e-6):
            if load * (1 + part) > (
                0.99 * float(contact.load(contact.extent))
                if profile.kind == "tabulated"
                else np.inf
            ):
                continue
            excess = part * load
            advance = contact.edge_advance(load)
            outer, inner = (float(contact.half_width(load + sign * excess)) for sign in (1, -1))
            reach = (
                np.arccosh(outer / a)
                if part > 1e-3
                else np.arcsinh(np.sqrt((outer - a) * (outer + a)) / a)
            )
            limit = 1e-11 + 4e-14 / part * a / max(a - contact.least_half_width, 1e-9 * a)
            assert float(contact.arccosh_ratio(outer, excess, advance)) == pytest.approx(
                reach, rel=limit
            )
            root = np.sqrt(excess / ((a - inner) * (a + inner)))
            assert float(
                np.sqrt(excess) * contact.inverse_root(inner, excess, advance)
            ) == pytest.approx(root, rel=limit)


@EVERY
def test_the_law_of_the_oracle_is_that_of_the_slope_in_thirty_digits(name):
    """E* int_0^a x h'/sqrt(a^2 - x^2) dx, h' by hand of each profile; and dP/da, whose integral is
    P.
    """
    profile, widths = CASES[name]
    law = law_of(profile)
    a = LONG(widths[1])
    with mp.workdps(34):
        slope = slope_of(profile)
        exact_a = mp.mpf(widths[1])
        marks = sorted(
            {
                mp.mpf(0),
                mp.pi / 2,
                *(mp.asin(mp.mpf(str(b)) / exact_a) for b in law.breaks if 0 < b < a),
            }
        )
        exact = mp.quad(
            lambda angle: exact_a * mp.sin(angle) * slope(exact_a * mp.sin(angle)), marks
        )
        digits = abs(mp.mpf(str(law.load(a))) / exact - 1)
    assert digits < 1e-16
    parts = [law.breaks[0], *(b for b in law.breaks if law.breaks[0] < b < a), a]
    assert float(integrate(law.rate, parts) / law.load(a)) == pytest.approx(1, rel=1e-15)


def slope_of(profile):
    """h'(x), x > 0, in the digits of mpmath."""
    if profile.kind == "tabulated":
        spline = profile.spline()
        knots = list(map(mp.mpf, spline.x.tolist()))
        bends = list(map(mp.mpf, spline.curvature.tolist()))
        return lambda x: sum(
            k * (min(max(x, a), b) - a)
            for k, a, b in zip(bends, knots[:-1], knots[1:], strict=True)
        )
    if profile.kind == "callable":
        return mp.sinh
    k = {
        name: value if name == "rises" else mp.mpf(value)
        for name, value in profile.model_dump(exclude={"kind"}, exclude_none=True).items()
    }
    return {
        "hertz": lambda x: x / k["radius"],
        "flat_rounded": lambda x: max(x - k["flat_half_length"], 0) / k["radius"],
        "compound": lambda x: (
            min(x, k["inner_half_length"]) / k["inner_radius"]
            + max(x - k["inner_half_length"], 0) / k["outer_radius"]
        ),
        "wedge": lambda x: min(x, k["tip_half_length"]) / k["tip_radius"],
        "power_law": lambda x: (
            k["exponent"] * k["rise"] / k["length"] ** k["exponent"] * x ** (k["exponent"] - 1)
        ),
        "polynomial": lambda x: sum(
            2 * n * mp.mpf(c) * x ** (2 * n - 1) / k["length"] ** (2 * n)
            for n, c in enumerate(k["rises"], 1)
        ),
    }[profile.kind]


# --------------------------------------------------------------------------- one shape in two forms
def flattened(x, flat, bend):
    return np.sign(x) * np.maximum(np.abs(x) - flat, 0) * bend


KNEE = Tabulated(points=[[0, 0], [0.5, 0], [0.75, 0.03], [1, 0.12], [1.5, 0.5]])
BEND = float(KNEE.spline().curvature[np.flatnonzero(KNEE.spline().curvature)[0]])
# One, the other, loads, relative error.
SAME = {
    "a corner of the slope is found": (
        CallableProfile(
            slope_function=lambda x: np.clip(x, -0.7, 0.7) + flattened(x, 0.7, 1 / 3), extent=5.0
        ),
        Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=0.7),
        (0.1, 0.4, 3.0),
        1e-11,
    ),
    "a flat middle is found": (
        CallableProfile(slope_function=lambda x: flattened(x, 0.5, 0.5), extent=3.0),
        FlatRounded(radius=2.0, flat_half_length=0.5),
        (0.1, 0.6),
        2e-9,
    ),
    "a tip is no corner": (
        CallableProfile(slope_function=np.sign, extent=2.0),
        PowerLaw(exponent=1.0, length=1.0, rise=1.0),
        (1.0,),
        1e-11,
    ),
    "a function of single numbers": (
        CallableProfile(
            height_function=lambda x: x * x / 2 if abs(x) < 0.3 else x * x / 2 + 0.0 * abs(x),
            extent=3.0,
        ),
        Hertz(radius=1.0),
        (0.1, 1.0),
        1e-10,
    ),
    "a blunt middle": (
        Compound(inner_radius=1e14, outer_radius=1.0, inner_half_length=1.0),
        FlatRounded(radius=1.0, flat_half_length=1.0),
        (1e-3, 20.0),
        1e-8,
    ),
    "far from the tip": (
        Wedge(tip_radius=2e-8, tip_half_length=1e-8),
        PowerLaw(exponent=1.0, length=1.0, rise=0.5),
        (0.5,),
        1e-7,
    ),
    # As much as the last digit of a leaves of a - b.
    "beside the flat of a table": (
        KNEE,
        FlatRounded(radius=1 / BEND, flat_half_length=contact_on(KNEE).least_half_width),
        tuple(
            share * float(contact_on(KNEE).load(contact_on(KNEE).corner_half_widths[0]))
            for share in (1e-2,)
        ),
        1e-10,
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_one_shape_in_two_forms(name):
    contact_one_form, contact_other_form, loads, limit = SAME[name]
    contact_one_form = contact_on(contact_one_form)
    contact_other_form = contact_on(contact_other_form)
    for load in loads:
        half = float(contact_other_form.half_width(load))
        assert float(contact_one_form.half_width(load)) == pytest.approx(half, rel=limit)
        x = half * np.array([0.01, 0.49, 0.69, 0.9, 1.2, 1.9])
        x = x[x < contact_one_form.extent]
        for kernel in ("pressure", "slip_integral"):
            values, expected = (
                getattr(each, kernel)(x, load) for each in (contact_one_form, contact_other_form)
            )
            np.testing.assert_allclose(
                values, expected, rtol=limit, atol=limit * load, err_msg=kernel
            )
        for slipped in (0.01 * load, 0.3 * load):
            values, expected = (
                float(each.dissipation_kernel(load, slipped))
                for each in (contact_one_form, contact_other_form)
            )
            assert values == pytest.approx(expected, rel=limit)


# ------------------------------------------------------------------------------ ends of single laws


FLAT = contact_on(FlatRounded(radius=1.0, flat_half_length=1.0), 2.0)  # E* b^2/(2 R) = 1


def tau_of_load(load):
    """sqrt(a^2 - b^2)/b by the engine."""
    d = float(FLAT.edge_advance(load))
    return math.sqrt(d * (2 + d))


def area_in_many_digits(flat, load, front):
    """int ln(a/c) dP of Hertz or of a flat with E* b^2/(2 R) = 1."""
    if not flat:
        return (load * mp.log(load / front) - load + front) / 2

    def tau_of(value):
        tau = mp.mpf(tau_of_load(float(value)))
        for _ in range(8):
            tau -= ((1 + tau**2) * mp.atan(tau) - tau - value) / (2 * tau * mp.atan(tau))
        return tau

    def primitive(tau):
        return ((1 + tau**2) * mp.atan(tau) - tau) / 2 - tau + mp.atan(tau)

    tau_load = tau_of(load)
    tau_front = tau_of(front)
    logarithm = mp.log((1 + tau_load**2) / (1 + tau_front**2))
    return load * logarithm / 2 - primitive(tau_load) + primitive(tau_front)


@pytest.mark.parametrize("load", [1e-9, 1e-3, 0.3, 1.0, 50.0, 1e9])
@pytest.mark.parametrize("flat", [False, True])
def test_friction_work_kernel_from_the_smallest_front_to_the_whole_contact(flat, load):
    """Lam(P, P_c) from P - P_c = 1e-14 P upwards, against 60 digits."""
    contact = FLAT if flat else contact_on(Hertz(radius=2.0), 3.0)
    with mp.workdps(60):
        for part in (1e-14, 1e-7, 1e-3, 0.29, 0.31, 0.7, 0.999):
            exact = float(
                area_in_many_digits(flat, mp.mpf(load), mp.mpf(load) - mp.mpf(load * part))
            )
            assert float(contact.dissipation_kernel(load, load * part)) == pytest.approx(
                exact, rel=1e-13
            ), part
        for ratio in (1e-18, 1e-12, 1e-5, 0.1, 0.3, 0.3001, 0.9, 1 - 1e-12):
            exact = float(-mp.log(1 - mp.mpf(ratio)) - mp.mpf(ratio))
            assert float(log_excess(ratio)) == pytest.approx(exact, rel=1e-15)


@pytest.mark.parametrize("load", [1e-5, 1e-3, 1e-2, 1.0])
def test_a_flat_given_by_its_slopes_has_a_finite_kernel_from_zero_load(load):
    """Its loads from round-off upwards are not monotonic in the half-width; gross sliding takes the
    inverse there. Against the closed form of the same flat.
    """
    by_slopes = contact_on(
        CallableProfile(
            extent=3.0, slope_function=lambda x: np.sign(x) * np.maximum(np.abs(x) - 0.5, 0.0)
        ),
        3.0,
    )
    closed_form = contact_on(FlatRounded(radius=1.0, flat_half_length=0.5), 3.0)
    assert np.isfinite(by_slopes.half_width(1e-20))
    kernel = float(by_slopes.dissipation_kernel(load, load))
    assert kernel == pytest.approx(float(closed_form.dissipation_kernel(load, load)), rel=1e-8)


def test_points_that_come_back_at_many_loads_are_integrated_once(monkeypatch):
    """Points so far apart that one primitive does not serve all of them; and more of them than one
    serves.
    """
    made = []

    def counted(*arguments):
        made.append(len(arguments[2]))
        return primitive_of(*arguments)

    monkeypatch.setattr(punch_superposition, "primitive_of", counted)
    law = law_of_power(modulus=1.0, exponent=1.3, length=1.0, rise=1.0)
    x = np.geomspace(1e-5, 1.0, 300)
    loads = np.linspace(0.1, 1.0, 60)[:, None]
    contact = PunchSuperposition(law, datum_length=1.0)
    slip = contact.slip_integral(x, loads)
    assert len(made) <= 3
    one_load = [PunchSuperposition(law, 1.0).slip_integral(x, load) for load in loads[::20, 0]]
    np.testing.assert_allclose(slip[::20], one_load, rtol=1e-13)

    many_x = np.geomspace(1e-2, 1.0, 5000)
    made.clear()
    np.testing.assert_allclose(
        contact.slip_integral(many_x, loads[:2])[:, ::100],
        contact.slip_integral(many_x[::100], loads[:2]),
        rtol=1e-13,
    )
    assert made[:2] == [4096, 904]


@pytest.mark.parametrize("n", [1.01, 1.3, 2.0, 3.0, 3.5, 6.0, 20.0])
def test_pressure_of_power_laws_to_the_very_middle(n):
    """Where its series change: 40 digits."""
    contact = PunchSuperposition(law_of_power(1.0, n, 1.0, 1.0), 3.0)
    m = mp.mpf(n)
    unit_load = float(contact.load(1.0))
    xi = np.array([0.0, 0.99e-11, 1.01e-11, 0.0999, 0.1001])
    with mp.workdps(50):

        def hyper(xi):
            return mp.sqrt(1 - xi**2) * mp.hyp2f1(1 - m / 2, 1, mp.mpf("1.5"), 1 - xi**2)

        exact = [1 / (n - 1), *(float(hyper(mp.mpf(value))) for value in xi[1:])]
    np.testing.assert_allclose(
        contact.pressure(xi, unit_load) * np.pi / (n * unit_load), exact, rtol=1e-11
    )


# ------------------------------------------------------------------------------------------- tables


# ----------------------------------------------------------------------------------- quantised rows


@pytest.mark.parametrize("seed", range(3))
def test_rows_that_bend_up_make_a_curve_that_does(seed):
    """Random convex rows, half of them with stretches on a line, which had a knee bent into them:
    none is refused.
    """
    chance = np.random.default_rng(seed)
    for _ in range(20):
        count = int(chance.choice([4, 11, 31]))
        bends = chance.exponential(size=count - 1) * (
            chance.random(count - 1) < chance.choice([0.3, 1.0])
        )
        bends[-1] += 0.1
        x = np.append(0, np.cumsum(chance.uniform(0.2, 1, count - 1)))
        profile = Tabulated(
            points=np.stack([x, np.append(0, np.cumsum(np.cumsum(bends) * np.diff(x)))], axis=1)
        )
        contact_on(profile)
        if np.all(bends > 0):
            assert np.min(profile.spline().curvature[1:]) > -1e-9 * np.max(
                profile.spline().curvature
            )


SHAPES = {
    "hertz": lambda x: x**2 / 2000,
    "flat": lambda x: np.maximum(x - 1, 0) ** 2 / 2000,
    "cosh": lambda x: (np.cosh(x) - 1) / 1000,
    "straight flanks": lambda x: np.maximum(x - 0.3, 0) / 100,
    "two curvatures": lambda x: (x**2 + 4 * np.maximum(x - 1, 0) ** 2) / 2000,
    "stairs": lambda x: np.floor(7 * x) / 1000,
}


def rows_of(chance):
    """Rows of a shape with 2 to 6 decimals, evenly spaced or not, a third of them with noise that
    is made to rise: plateaus.
    """
    name = str(chance.choice(list(SHAPES)))
    count = int(chance.choice([5, 11, 31, 101, 301]))
    decimals = int(chance.integers(2, 7))
    x = np.linspace(0, 3, count)
    if chance.random() < 0.3:
        x = np.unique(
            np.round(np.append(chance.uniform(0, 3, count), 0), int(chance.integers(2, 9)))
        )
    h = SHAPES[name](x)
    if chance.random() < 0.3:
        h = np.maximum.accumulate(
            np.maximum(h + 10.0**-decimals * chance.standard_normal(len(x)), h[0])
        )
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
        contact = contact_on(profile)
    except InputError as refusal:
        named = all(
            words in str(refusal) for words in ("row", "near a half-width of")
        ) and "\n" not in str(refusal)
        return "split" if named else f"refused in other words: {refusal}"
    loads = contact.load(np.linspace(contact.least_half_width, contact.extent, 3001)[1:])
    load = loads[-1] * np.geomspace(1e-4, 1, 40)
    if (
        np.min(np.diff(loads)) < -1e-13 * loads[-1]
        or np.max(np.abs(contact.load(contact.half_width(load)) / load - 1)) > 1e-10
    ):
        return "P falls, or a(P) is not its inverse"
    return "solved" if np.all(contact.pressure(x[:20], load[-2]) >= 0) else "no pressure"


@contextlib.contextmanager
def bounded(seconds):
    """CPU time after which a loop without end is broken off."""

    def stop(*_):
        raise AssertionError("a loop without end")

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


@pytest.mark.parametrize(
    ("seed", "count"), [(14, 60), pytest.param(140, 1500, marks=pytest.mark.slow)]
)
def test_quantised_rows_are_solved_or_refused_with_their_row(seed, count):
    """Zero-width intervals, curvatures of 1e12 and a loop without end before; now rows either hold
    together or are refused.
    """
    chance = np.random.default_rng(seed)
    with bounded(300):
        verdicts = [judged(*rows_of(chance)) for _ in range(count)]
    assert set(verdicts) <= {"door", "split", "solved"}, verdicts
    assert min(verdicts.count("solved"), verdicts.count("split")) > count / 5


# ----------------------------------------------------------------------------------------- refusals
def function(**keys):
    return lambda: CallableProfile(extent=2.0, **keys)


X = np.linspace(0, 3, 301)
SLOPE_X = CallableProfile(slope_function=lambda x: x, extent=1.0)
PARABOLA_ROWS = table(lambda x: x * x / 2, 1.0, 11)
REFUSED = {
    # of h, a step being up to 200 times what the parabola bends by between two rows
    "a parabola in steps": (
        lambda: contact_on(Tabulated(points=np.stack([X, np.round(X * X / 2000, 5)], axis=1))),
        r"^profile\.points, row .*h is written in steps of 1e-05.*more digits",
    ),
    "lopsided": (function(height_function=lambda x: x), "not symmetric"),
    "a step of the slope": (
        function(height_function=lambda x: np.maximum(np.abs(x) - 0.1, 0)),
        "no derivative",
    ),
    "a hollow": (function(height_function=lambda x: -x * x), "falls"),
    "falls later": (
        function(height_function=lambda x: x * x * (1 - x * x / 3)),
        r"falls at x = 1\.2",
    ),
    "stairs": (
        function(height_function=lambda x: np.floor(100 * x * x)),
        "too rough|no derivative",
    ),
    "flat": (function(height_function=lambda x: 0 * x), "flat from end to end"),
    "both": (function(height_function=lambda x: x * x, slope_function=lambda x: 2 * x), "not both"),
    "neither": (function(), "either height_function or slope_function"),
    "a word": (function(height_function="x*x"), "only be built in Python"),
    **{
        f"polynomial {rises}": (
            lambda rises=rises: EvenPolynomial(length=1.0, rises=rises),
            "must rise|must be positive",
        )
        for rises in ((0.5, -0.6, 1 / 6), (-0.1, 1.0), (0.5, -0.1), (0.0, 0.0))
    },
    "close rows": (
        lambda: Tabulated(points=[[0, 0], [1, 1], [1 + 1e-10, 1.1], [2, 3]]),
        r"row 3: x = 1.0000000001 .* than 1e-09",
    ),
    "rows that fall": (
        lambda: Tabulated(points=[[0, 0], [1, 1], [2, 0.1]]),
        r"points, row 3: h = 0\.1 falls",
    ),
    "many rows": (
        lambda: Tabulated(points=[[k, k * k] for k in range(2001)]),
        r"row 2001: .* 2,001 rows .* 2,000",
    ),
    # h' >= 0 everywhere, but not dP/da.
    "a contact that splits": (
        lambda: contact_on(EvenPolynomial(length=1.0, rises=(0.5, -0.49, 1 / 6))),
        "split near a half-width of",
    ),
    "rows that split": (
        lambda: contact_on(
            Tabulated(points=[[0, 0], [0.2, 0.2], [0.4, 0.4], [0.6, 0.4], [0.8, 0.4], [1.0, 0.41]])
        ),
        "split near a half-width of",
    ),
    "beyond the function": (
        lambda: contact_on(SLOPE_X).half_width(2.0),
        r"extent = 1: the normal load 2 needs a wider contact",
    ),
    "beyond the table": (
        lambda: contact_on(PARABOLA_ROWS).half_width(2.0),
        r"normal load 2 .* last x = 1 carries 0\.785",
    ),
    "unknown": (
        lambda: contact_on(type("Wedge", (), {"kind": "cone"})()),
        r"profile\.kind = 'cone'",
    ),
    "written down": (
        lambda: load_scene("hertz-paper").vary(profile=SLOPE_X).model_dump_json(),
        "holds a Python function",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_a_profile_is_refused_in_a_sentence(name):
    make, why = REFUSED[name]
    with pytest.raises(ValueError, match=why):
        make()


def test_unlike_bodies_have_a_modulus_and_a_coupling_constant():
    soft = Elastic(young_modulus=1.0, poisson_ratio=0.25)
    stiff = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    assert composite_modulus(Materials(upper=soft, lower=stiff)) == pytest.approx(
        1 / (0.9375 + 0.5)
    )
    pairs = [
        coupling_constant(Materials(upper=upper, lower=lower))
        for upper, lower in ((soft, stiff), (stiff, soft), (soft, soft))
    ]
    # Dundurs' beta with k = 2 (1 - 2 nu)(1 + nu)/E of either body, over the two 4 (1 - nu^2)/E.
    beta = ((1 - 2 * 0.25) * 1.25 / 1.0 - 0.5) / (2 * (0.9375 + 0.5))
    assert np.abs(pairs) == pytest.approx([abs(beta), abs(beta), 0.0])
    assert pairs[0] == -pairs[1]


# -------------------------------------------------------------------------------- at the boundaries
MATERIAL = Materials(upper=UNIT, lower=UNIT)


def test_a_wedge_has_no_pressure_before_first_touch_and_an_infinite_one_after():
    """At the tip, x = 0: 0 at P = 0, the logarithm's pole at any P > 0, beside it a finite
    pressure.
    """
    wedge = contact_of(PowerLaw(exponent=1.0, length=1.0, rise=0.5), MATERIAL)
    np.testing.assert_array_equal(
        wedge.pressure([0.0, 0.0, 0.1], [0.0, 1e-12, 0.0]), [0.0, np.inf, 0.0]
    )
    assert 0 < wedge.pressure(0.1, 1.0) < np.inf
