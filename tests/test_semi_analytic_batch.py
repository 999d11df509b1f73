"""Batches: thirty-digit references, extremes, agreement with the engine that marches, what happens to bad members."""

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from scenes import FlatRounded, Hertz, InputError, Materials
from semi_analytic import Reason, dissipation, peak_dissipation, solve
from semi_analytic.profiles import contact_of
from semi_analytic.steady_ellipse import density_of, ellipses_of
from semi_analytic_cases import EXTREMES, REFERENCE, UNIT, ellipse, make_scene

MATERIAL = Materials(upper=UNIT, lower=UNIT)
PAPER = {"mean_normal_load": 3.0, "normal_amplitude": 1.0, "mean_tangential_load": 1.1, "tangential_amplitude": 1.0}
PROFILES = {0.0: Hertz(radius=1.0), 0.7: FlatRounded(radius=1.0, flat_half_length=0.7)}


def arguments(rows):
    columns = {key: np.array([float(row[key]) for row in rows]) for key in ("mean", "amplitude", "tangential", "phase", "friction")}
    radians = np.array([bool(row.get("radians")) for row in rows])
    return {
        "material": MATERIAL,
        "friction_coefficient": columns["friction"],
        "mean_normal_load": columns["mean"],
        "normal_amplitude": columns["amplitude"],
        "tangential_amplitude": columns["tangential"],
        "phase": np.where(radians, columns["phase"], np.radians(columns["phase"])),
    }


@pytest.mark.parametrize("batch", [dissipation, peak_dissipation])
def test_neglected_coupling_of_unlike_materials_is_noted_as_solve_does(batch):
    soft = UNIT.vary(young_modulus=UNIT.young_modulus / 1e9, poisson_ratio=0.0)
    unlike = Materials(upper=soft, lower=UNIT)  # beta = 0.5
    scene = make_scene(ellipse(3.0, 1.0, 1.1, 1.0), 1.0)
    noted = solve(scene.vary(material=unlike), x=[0.0], fields=()).record.notes
    assert batch(profile=scene.profile, material=unlike, friction_coefficient=1.0, **PAPER).notes == noted
    assert noted[0].startswith("Dundurs' beta = 0.5: ")
    assert batch(profile=scene.profile, material=MATERIAL, friction_coefficient=1.0, **PAPER).notes == ()


@pytest.mark.parametrize("flat", PROFILES)
def test_batch_is_that_of_thirty_digits(flat):
    """Worst measured 3e-13 relative."""
    rows = [row for row in REFERENCE if row["flat"] == flat]
    batch = dissipation(profile=PROFILES[flat], **arguments(rows))
    np.testing.assert_allclose(batch.value, [float(row["dissipation"]) for row in rows], rtol=1e-12, atol=0)
    assert np.all(batch.reason == Reason.NONE)
    np.testing.assert_allclose(batch.forward + batch.reverse, batch.value, rtol=1e-15)


@pytest.mark.parametrize(
    "row", EXTREMES, ids=lambda row: f"b{row['flat']}-P1 {row['amplitude']:g}-Q1 {row['tangential']:.1e}-{row['phase']:g}"
)
def test_extremes_keep_ten_relative_digits(row):
    """Slip of 1e-9, sliding at 1 - 1e-12, full unloading at 1 - 1e-9, a line within 1e-9: worst measured 1.3e-11."""
    batch = dissipation(profile=PROFILES[row["flat"]], **arguments([row]))
    assert batch.value[0] == pytest.approx(float(row["dissipation"]), rel=1e-10, abs=0)


def test_extremes_through_solve_keep_ten_digits_as_far_as_the_phase_in_degrees_does():
    for row in EXTREMES:
        if row["phase"] in (1.0, math.pi / 2):
            load = ellipse(row["mean"], row["amplitude"], 0.0, row["tangential"], math.degrees(row["phase"]))
            solution = solve(make_scene(load, row["friction"], row["flat"]), x=[0.0], fields=("dissipation",))
            assert solution.dissipation == pytest.approx(float(row["dissipation"]), rel=1e-10, abs=0)


@pytest.mark.parametrize(
    ("amplitude", "tangential", "phase"), [(0.3, 0.1, 0.0), (0.2, 0.1, 0.0), (0.3, 0.0, 1.0), (0.0, 0.0, 0.0), (0.2, 0.1, math.pi)]
)
def test_lines_within_the_cone_dissipate_nothing(amplitude, tangential, phase):
    """Phase 0 or pi with Q1 <= f P1, tangency Q1 = f P1 included; absolute in A f^2 P0^2."""
    batch = dissipation(
        profile=PROFILES[0.0],
        material=MATERIAL,
        friction_coefficient=0.5,
        mean_normal_load=1.0,
        normal_amplitude=amplitude,
        tangential_amplitude=tangential,
        phase=phase,
    )
    assert abs(float(batch.value)) <= 1e-20  # the phase is pi to 1e-16 only
    assert batch.reason == Reason.NONE


@settings(max_examples=30)
@given(
    st.floats(0, 0.97),
    st.floats(0.02, 0.98),
    st.floats(-math.pi, math.pi),
    st.floats(0.01, 5),
    st.sampled_from([0.0, 0.7]),
    st.floats(0, 1),
)
@example(ratio=1e-300, use=0.5, phase=0.0, friction=1.0, flat=0.0, part=0.5)  # P is as good as constant
@example(ratio=0.25, use=0.5, phase=-0.0, friction=1.0, flat=0.0, part=0.0)  # no loop, so none that goes round the other way
@example(ratio=3e-313, use=0.3, phase=2.0, friction=0.7, flat=0.7, part=1.0)
def test_batch_and_marching_agree(ratio, use, phase, friction, flat, part):
    """Forward, reverse, pointwise and global, both senses: one quadrature along a marched history, one in closed-form angles."""
    from semi_analytic.friction_work import global_dissipation, pointwise_dissipation
    from semi_analytic.history import history_of

    q1 = use * friction * (1 - ratio)
    scene = make_scene(ellipse(1.0, ratio, 0.0, q1, math.degrees(phase)), friction, flat)
    contact = contact_of(scene.profile, scene.material)
    spans = history_of(scene.load.path(), friction, 6).cycles[-1]
    angle = math.radians(math.degrees(phase))
    marched = global_dissipation(contact, 1.0, spans)
    batch = dissipation(
        profile=scene.profile,
        material=scene.material,
        friction_coefficient=friction,
        mean_normal_load=1.0,
        normal_amplitude=ratio,
        tangential_amplitude=q1,
        phase=angle,
    )
    floor = 1e-15 * friction**2
    assert float(batch.forward) == pytest.approx(float(marched.forward), rel=1e-9, abs=floor)
    assert float(batch.reverse) == pytest.approx(float(marched.reverse), rel=1e-9, abs=floor)
    loop = ellipses_of(*(np.array([value]) for value in (1.0, ratio, q1, angle, friction)))
    inner, outer = (float(contact.half_width(load)) for load in (loop.permanent[0], 1 + ratio))
    x = np.array([inner + part * (outer - inner)])
    here = sum(density_of(loop, contact, x)) * 2 * friction**2 / math.pi
    assert float(here[0]) == pytest.approx(
        float(pointwise_dissipation(contact, 1.0, spans, x).total[0]), rel=1e-8, abs=1e-13 * friction**2
    )


def test_profile_parameters_broadcast_too():
    keys = {"kind": "flat_rounded", "radius": np.array([[1.0], [2.0]]), "flat_half_length": np.array([0.4, 0.7, 1.0])}
    batch = dissipation(profile=keys, material=MATERIAL, friction_coefficient=1.0, **PAPER)
    peak = peak_dissipation(profile=keys, material=MATERIAL, friction_coefficient=1.0, **PAPER)
    assert batch.value.shape == peak.value.shape == (2, 3)
    for row, radius in enumerate((1.0, 2.0)):
        for column, flat in enumerate((0.4, 0.7, 1.0)):
            one = FlatRounded(radius=radius, flat_half_length=flat)
            alone = dissipation(profile=one, material=MATERIAL, friction_coefficient=1.0, **PAPER)
            alone_peak = peak_dissipation(profile=one, material=MATERIAL, friction_coefficient=1.0, **PAPER)
            assert batch.value[row, column] == pytest.approx(float(alone.value), rel=1e-13, abs=0)
            assert peak.place[row, column] == pytest.approx(float(alone_peak.place), rel=1e-9)


def test_radius_plays_no_part_in_the_global_dissipation_of_hertz():
    keys = {"kind": "hertz", "radius": np.array([1e-3, 1.0, 1e6])}
    batch = dissipation(profile=keys, material=MATERIAL, friction_coefficient=1.0, **PAPER)
    np.testing.assert_allclose(batch.value, batch.value[1], rtol=1e-14)


def test_bad_members_get_a_reason_and_the_rest_their_values():
    batch = dissipation(
        profile=Hertz(radius=1.0),
        material=MATERIAL,
        friction_coefficient=[1.0, 1.0, 1.0, -1.0, 1.0, 0.0, 0.0],
        mean_normal_load=[3.0, 3.0, 1.0, 3.0, np.nan, 3.0, 3.0],
        normal_amplitude=[1.0, 1.0, 2.0, 1.0, 1.0, 1.0, 1.0],
        mean_tangential_load=[1.1, 2.5, 0.0, 0.0, 0.0, 0.0, 0.0],
        tangential_amplitude=[1.0, 1.0, 0.0, 0.1, 0.1, 0.0, 0.1],
    )
    expected = [Reason.NONE, Reason.SLIDING, Reason.SEPARATION, Reason.INVALID, Reason.INVALID, Reason.NONE, Reason.SLIDING]
    np.testing.assert_array_equal(batch.reason, expected)
    np.testing.assert_array_equal(np.isnan(batch.value), batch.reason != Reason.NONE)
    assert batch.value[5] == 0
    assert not batch.value.flags.writeable


def test_reasons_are_those_of_the_sampled_loops():
    """|Q| <= f P at 2,000 instants of 4,000 random loops, both senses, any Q0."""
    rng, count = np.random.default_rng(7), 4000
    ratio, mean, force, phase = (rng.uniform(*ends, count) for ends in ((0, 1), (-0.3, 0.3), (0, 0.5), (-7, 7)))
    friction = rng.choice([0.3, 0.8], count)
    t = np.linspace(0, 2 * math.pi, 2001)[:, None]
    over = np.max(np.abs(mean + force * np.cos(t - phase)) - friction * (1 + ratio * np.cos(t)), axis=0)
    batch = dissipation(
        profile=PROFILES[0.0],
        material=MATERIAL,
        friction_coefficient=friction,
        mean_normal_load=1.0,
        normal_amplitude=ratio,
        mean_tangential_load=mean,
        tangential_amplitude=force,
        phase=phase,
    )
    clear = np.abs(over) > 1e-5
    np.testing.assert_array_equal(batch.reason[clear], np.where(over > 0, Reason.SLIDING, Reason.NONE)[clear])


def test_a_batch_of_nothing_and_shapes_that_do_not_fit():
    empty = dissipation(profile=Hertz(radius=1.0), material=MATERIAL, friction_coefficient=np.empty(0), **PAPER)
    assert empty.value.shape == (0,)
    with pytest.raises(InputError, match="must broadcast"):
        dissipation(
            profile=Hertz(radius=1.0), material=MATERIAL, friction_coefficient=[1.0, 1.0], **PAPER | {"normal_amplitude": [1, 1, 1]}
        )
    with pytest.raises(InputError, match="with all its keys"):
        dissipation(profile={"kind": "hertz"}, material=MATERIAL, friction_coefficient=1.0, **PAPER)


@pytest.mark.parametrize("flat", [0.0, 0.7])
def test_peak_is_the_largest_value_of_the_density(flat):
    """Against a grid of 2,001 points next to it, between which W rises by 1e-9 of its value at most."""
    scene = make_scene(ellipse(), 1.0, flat)
    peak = peak_dissipation(profile=scene.profile, material=MATERIAL, friction_coefficient=1.0, **PAPER)
    x = np.linspace(0.99, 1.01, 2001) * float(peak.place)
    density = solve(scene, x=x, fields=("dissipation_density",)).dissipation_density
    assert 0 < peak.value_error < 1e-9 * peak.value
    assert np.max(density) <= peak.value + peak.value_error
    assert float(peak.value) == pytest.approx(np.max(density), rel=1e-9, abs=0)
    assert float(peak.place) == pytest.approx(x[np.argmax(density)], rel=2e-4)
    # The shoulder that figures 6 and 9 have as well.
    least = float(contact_of(scene.profile, MATERIAL).half_width(2.0))
    assert peak.second_value < 0.5 * peak.value
    assert 0.99 * least < peak.second_place < least


def circle_on_flat(ratio):
    """Figure 10b: Q1 = P1 = 1, f = 0.4, phase 90 degrees, a(P0) = 1 and b = 0.505 for any P0/P1 = `ratio`; E* = 1."""
    load = float(contact_of(FlatRounded(radius=1.0, flat_half_length=0.505), MATERIAL).load(1.0))
    return make_scene(ellipse(ratio, 1.0, 0.0, 1.0, 90.0), 0.4, 0.505, radius=load / ratio)


@pytest.mark.parametrize(("ratio", "shoulder"), [(4.5, True), (4.97, True), (5.0, True), (5.5, True), (6.0, False)])
def test_peak_is_the_larger_of_two_maxima(ratio, shoulder):
    """The shoulder just inside a(P_min) and the outer maximum, each against 81 points next to it."""
    scene = circle_on_flat(ratio)
    peak = peak_dissipation(
        profile=scene.profile,
        material=MATERIAL,
        friction_coefficient=0.4,
        mean_normal_load=ratio,
        normal_amplitude=1.0,
        tangential_amplitude=1.0,
    )
    least = float(contact_of(scene.profile, MATERIAL).half_width(ratio - 1.0))
    one, other = float(peak.place), float(peak.second_place)
    assert (one < least < other) if shoulder else (other < least < one)
    x = np.outer([one, other], np.linspace(0.998, 1.002, 81))
    density = solve(scene, x=x.ravel(), fields=("dissipation_density",)).dissipation_density.reshape(x.shape)
    found = np.array([float(peak.value), float(peak.second_value)])
    assert np.all(np.max(density, axis=1) <= found + float(peak.value_error))
    np.testing.assert_allclose(np.max(density, axis=1), found, rtol=1e-5)
    if ratio == 5.0:
        # In units of the paper, A P1^2/a(P0) with A = 2: the smaller one was returned.
        np.testing.assert_allclose(found / 2, [0.168558, 0.167181], atol=1e-6)
        assert float(peak.fraction) == pytest.approx(0.4826, abs=1e-4)


def test_peak_is_continuous_along_fifty_random_paths():
    """The place jumps from one maximum to another where both are equal: the value changes by 1e-4 there, what is left of a step."""
    rng, paths = np.random.default_rng(16), 50
    # P1/P0, f, Q1 over f (P0 - P1), phase, b/R; four in five on Hertz.
    low, high = np.array([[0.1, 0.1, 0.3, 0.7, 0.1], [0.4, 1.0, 1.0, 2.2, 0.95]])
    ends = low + (high - low) * rng.uniform(size=(2, paths, 5))
    ends[:, np.arange(paths) % 5 > 0, 4] = 0

    def peaks(where):
        """Value and fraction at (m, 5) parameters: (2, m)."""
        found = np.empty((2, len(where)))
        for here, kind in ((where[:, 4] == 0, "hertz"), (where[:, 4] > 0, "flat_rounded")):
            ratio, friction, use, phase, flat = where[here].T
            peak = peak_dissipation(
                profile={"kind": kind, "radius": 1.0} | ({} if kind == "hertz" else {"flat_half_length": flat}),
                material=MATERIAL,
                friction_coefficient=friction,
                mean_normal_load=1.0,
                normal_amplitude=ratio,
                tangential_amplitude=use * friction * (1 - ratio),
                phase=phase,
            )
            found[:, here] = peak.value, peak.fraction
        return found

    along = ends[0] + (ends[1] - ends[0]) * np.linspace(0, 1, 9)[:, None, None]
    value, fraction = peaks(along.reshape(-1, 5)).reshape(2, 9, paths)
    assert np.all(np.isfinite(value))
    jumps = np.abs(np.diff(fraction, axis=0)) > 0.05
    assert np.sum(jumps) >= 10
    one, other, first, last = along[:-1][jumps], along[1:][jumps], fraction[:-1][jumps], fraction[1:][jumps]
    for _ in range(12):
        middle = (one + other) / 2
        place = peaks(middle)[1]
        near = np.abs(place - first) < np.abs(place - last)
        one, other = np.where(near[:, None], middle, one), np.where(near[:, None], other, middle)
        first, last = np.where(near, place, first), np.where(near, last, place)
    np.testing.assert_allclose(peaks(one)[0], peaks(other)[0], rtol=5e-4)


@pytest.mark.parametrize("swing", [0.5, 1e-3, 1e-6, 1e-9])
def test_error_of_the_peak_covers_thirty_digits_of_constant_load(swing):
    """Hertz, P constant, Q between +- swing f P: W(x) = (8 f^2 P/(pi E*)) p int arccosh(x/(a sqrt(1 - z))) dz up to z = swing."""
    peak = peak_dissipation(
        profile=PROFILES[0.0],
        material=MATERIAL,
        friction_coefficient=0.3,
        mean_normal_load=1.0,
        normal_amplitude=0.0,
        tangential_amplitude=0.3 * swing,
    )
    with mp.workdps(40):
        # Of z_x = 1 - (x/a)^2 = part swing; p = (2 P/(pi a)) sqrt(z_x), a^2 = 4 P R/(pi E*).
        def density(part):
            edge = part * swing
            reach = mp.quad(lambda z: mp.acosh(mp.sqrt((1 - edge) / (1 - z))), [edge, swing])
            return 8 * mp.mpf("0.3") ** 2 / mp.pi * mp.sqrt(mp.pi) / mp.pi * mp.sqrt(edge) * reach

        part = mp.findroot(lambda part: mp.diff(density, part), (mp.mpf("0.24"), mp.mpf("0.26")), tol=1e-15)
        exact = density(part)
        error = float(abs(mp.mpf(float(peak.value)) - exact))
    assert np.isnan(peak.second_value)
    assert np.isnan(peak.second_place)
    assert error <= float(peak.value_error)
    assert float(peak.value_error) <= max(1e-9, 1e-14 / swing) * float(exact)


def test_figures_of_merit_of_the_two_geometries():
    """Theory, section 6: peak at 0.595 and 0.604 of the slip zone; global dissipation 0.557, peaks 0.97 of Hertz at equal a(P0)."""
    modulus = 1.0
    hertz, flat = Hertz(radius=1.0), FlatRounded(radius=1.0, flat_half_length=0.505)
    loads = {"normal": math.pi / 4 * modulus, "flat": float(contact_of(flat, MATERIAL).load(1.0))}
    # Equal loads and equal a(P0) = 1: the radius of the flat face follows from the load, its b does not.
    rounded = FlatRounded(radius=loads["flat"] / loads["normal"], flat_half_length=0.505)
    kind = {"material": MATERIAL, "friction_coefficient": 1.0}
    circle = {
        "mean_normal_load": loads["normal"],
        "normal_amplitude": loads["normal"] / 3,
        "mean_tangential_load": 1.1 * loads["normal"] / 3,
        "tangential_amplitude": loads["normal"] / 3,
    }
    works = [float(dissipation(profile=profile, **kind, **circle).value) for profile in (hertz, rounded)]
    peaks = [peak_dissipation(profile=profile, **kind, **circle) for profile in (hertz, rounded)]
    assert works[1] / works[0] == pytest.approx(0.557, abs=5e-4)
    assert float(peaks[1].value / peaks[0].value) == pytest.approx(0.97, abs=5e-3)
    assert [round(float(peak.fraction), 3) for peak in peaks] == [0.595, 0.604]
    assert works[1] / works[0] / float(peaks[1].value / peaks[0].value) == pytest.approx(0.574, abs=5e-4)


def test_damping_falls_faster_than_the_peak_with_the_mean_load_confirmed():
    """Figure 7: with P1 = Q1 = 1 the global dissipation loses more of itself from P0 = 2 to 4 than the peak does."""
    kind = {"profile": Hertz(radius=1.0), "material": MATERIAL, "friction_coefficient": 1.0}
    circle = {"mean_normal_load": [2.0, 4.0], "normal_amplitude": 1.0, "tangential_amplitude": 1.0}
    work, peak = dissipation(**kind, **circle).value, peak_dissipation(**kind, **circle).value
    assert work[1] / work[0] < peak[1] / peak[0] < 1


def test_full_stick_has_no_peak():
    peak = peak_dissipation(
        profile=Hertz(radius=1.0),
        material=MATERIAL,
        friction_coefficient=1.0,
        mean_normal_load=1.0,
        normal_amplitude=0.2,
        tangential_amplitude=0.0,
    )
    assert peak.value == 0
    assert np.isnan(peak.place)
    assert np.isnan(peak.fraction)
