"""Profiles and faces: symmetric, rising from zero, arcs to the last digit; curves through noisy
rows, and the W of these.
"""

from __future__ import annotations

import json

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import semi_analytic
from command_line import refused
from reports.checking import largest_contact
from reports.cli import scene_files
from reports.page.body_figures import fit_residuals
from reports.profile_fit import (
    content,
    findings_on_fit,
    fit_in_words,
    fit_uncertainty,
    fit_warnings,
)
from scenes import (
    CallableProfile,
    Compound,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    PowerLaw,
    Scene,
    Tabulated,
    Wedge,
    fit_profile,
    load_scene,
)
from scenes.bodies import arc_depth
from scenes.fitting import FitRequest, fitted_again, fitted_keys

PROFILES = [
    Hertz(radius=2.0),
    FlatRounded(radius=2.0, flat_half_length=0.5),
    PowerLaw(exponent=1.7, length=2.0, rise=0.5),
    Compound(inner_radius=1.0, outer_radius=3.0, inner_half_length=0.5),
    Wedge(tip_radius=2.0, tip_half_length=0.5),
    EvenPolynomial(length=2.0, rises=(0.5, 0.2)),
    Tabulated(points=[[0, 0], [1, 0.3], [2, 1.3]]),
    CallableProfile(slope_function=np.sinh, extent=3.0),
]


@pytest.mark.parametrize("profile", PROFILES, ids=lambda profile: profile.kind)
def test_a_profile_is_symmetric_rises_from_zero_and_survives_json(profile):
    x = np.linspace(0, 4, 401)
    height = profile.height(x)
    assert height[0] == 0
    assert np.all(np.diff(height) >= -1e-15)
    np.testing.assert_array_equal(profile.height(-x), height)
    assert np.ndim(profile.height(1.0)) == 0
    assert profile.height(np.ones((2, 3))).shape == (2, 3)
    assert profile.datum_length > 0
    assert isinstance(profile, (Hertz, FlatRounded)) or "mm" in profile.in_words("mm")
    if not isinstance(profile, CallableProfile):
        scene = load_scene("hertz-paper").vary(profile=profile)
        reloaded = Scene.model_validate_json(scene.model_dump_json())
        assert reloaded == scene
        np.testing.assert_array_equal(reloaded.profile.height(x), height)


def test_heights_by_hand():
    assert Hertz(radius=2.0).height([0.0, 1.0, -2.0]).tolist() == [0.0, 0.25, 1.0]
    assert FlatRounded(radius=2.0, flat_half_length=1.0).height([0.0, 1.0, -3.0]).tolist() == [
        0.0,
        0.0,
        1.0,
    ]
    # of which the mean counts
    sides = Tabulated(points=[[-2, 4.001], [-1, 1.0], [0, 0.0], [1, 1.001], [2, 4.0]])
    np.testing.assert_allclose(sides.height([1.0, 2.0]), [1.0005, 4.0005])
    assert FlatRounded(radius=2.0, flat_half_length=1e-12).height(1.0) == pytest.approx(
        Hertz(radius=2.0).height(1.0)
    )


# -------------------------------------------------------------------------------------------- faces
@pytest.mark.parametrize("radius", [1e-3, 5.0, 1e6])
def test_depth_of_an_arc_to_the_last_digit_and_beside_a_flat(radius):
    """R - sqrt(R^2 - s^2) loses all digits at s = 1e-9 R; mpmath has them. Past the end by
    round-off is the end.
    """
    for share in (1e-9, 1e-4, 0.3, 0.99, 1 - 1e-9, 1.0):
        s = share * radius
        with mpmath.workdps(50):
            exact = float(
                mpmath.mpf(radius) - mpmath.sqrt(mpmath.mpf(radius) ** 2 - mpmath.mpf(s) ** 2)
            )
        assert float(arc_depth(np.array(s), radius)) == pytest.approx(exact, rel=1e-14)
        assert arc_depth(
            radius * np.array([-0.3 - share, 0.2, 0.3 + share]), radius, 0.3 * radius
        ) == pytest.approx([exact, 0, exact], rel=1e-6)
    assert float(arc_depth(np.array(radius * (1 + 4e-16)), radius)) == pytest.approx(
        radius, rel=1e-15
    )


# ------------------------------------------------------------------------ curves through noisy rows
KINDS = ("hertz", "flat_rounded", "even_polynomial", "smoothing_spline")
TRUTHS = {
    "hertz": Hertz(radius=1000.0),
    "flat_rounded": FlatRounded(radius=300.0, flat_half_length=0.5),
    "even_polynomial": EvenPolynomial(length=1.0, rises=(5e-4, -5e-5, 5e-5, 2e-6)),
    "smoothing_spline": EvenPolynomial(length=1.0, rises=(5e-4, 1e-4)),
}
LOAD = {
    "mean_normal_load": 70.0,
    "normal_amplitude": 20.0,
    "mean_tangential_load": 0.0,
    "tangential_amplitude": 25.0,
}


def rows_of(truth, count=101, noise=0.0, middle=0.1, seed=0):
    random = np.random.default_rng(seed)
    x = np.sort(random.uniform(-1.4, 1.6, count))
    return np.column_stack(
        [x, 0.3 + truth.height(x - middle) + noise * random.standard_normal(count)]
    )


def scene_of(rows, kind, noise=None, **fit):
    fit |= {"kind": kind} | ({"noise": noise} if noise else {})
    return load_scene("hertz-paper").vary(
        load=LOAD, profile={"kind": "tabulated", "points": rows, "fit": fit}
    )


@pytest.mark.parametrize("kind", KINDS)
def test_exact_rows_give_the_truth_its_middle_and_its_offset(kind):
    truth = TRUTHS[kind]
    s = np.linspace(0, 1.3, 201)
    fit = fit_profile(rows_of(truth), kind, noise=1e-9)
    close = 3e-5 if kind == "smoothing_spline" else 1e-9  # knots 0.06 mm apart
    np.testing.assert_allclose(
        fit.height(s), truth.height(s), atol=close * float(truth.height(1.3))
    )
    assert fit.fitted.centre == pytest.approx(0.1, abs=1e-5 if kind == "smoothing_spline" else 1e-8)
    assert fit.fitted.offset == pytest.approx(0.3, abs=1e-7)
    assert fit.fitted.extent == pytest.approx(min(1.6 - 0.1, 1.4 + 0.1), abs=0.1)
    if kind == "flat_rounded":
        assert (fit.radius, fit.flat_half_length) == (
            pytest.approx(300.0, rel=1e-6),
            pytest.approx(0.5, rel=1e-6),
        )
    if kind == "even_polynomial":  # which bends down nowhere although a power of it is negative
        np.testing.assert_allclose(
            np.array(fit.rises) / fit.length ** (2.0 * np.arange(1, 5)), truth.rises, rtol=1e-4
        )


@settings(max_examples=5, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from(KINDS),
    st.sampled_from(list(TRUTHS)),
    st.floats(1e-7, 3e-4),
)
def test_a_fit_is_convex_or_one_sentence_whatever_the_noise(seed, kind, truth, noise):
    rows = rows_of(TRUTHS[truth], 12 + seed % 60, noise, seed=seed)
    try:
        fit = fit_profile(rows, kind)
    except InputError as fault:
        rule = str(fault)
        fit = None
    if fit is None:
        assert "do not bend up" in rule
        return
    s = np.linspace(0, fit.fitted.extent, 400)
    assert np.all(np.diff(fit.height(s), 2) >= -1e-12 * float(fit.height(s[-1])))
    assert float(fit.height(s[-1])) > 0


@pytest.mark.parametrize(
    "kind",
    [
        "flat_rounded",
        "smoothing_spline",
        pytest.param("hertz", marks=pytest.mark.slow),
        pytest.param("even_polynomial", marks=pytest.mark.slow),
    ],
)
def test_a_saved_scene_gives_the_same_answer_without_the_file(kind, tmp_path):
    np.savetxt(
        tmp_path / "trace.csv",
        rows_of(TRUTHS["flat_rounded"], 61, 20e-6),
        delimiter=",",
        header="x,h",
        comments="",
    )
    keys = json.loads(load_scene("hertz-paper").vary(load=LOAD).model_dump_json(exclude_none=True))
    profile = {"kind": "tabulated", "file": "trace.csv", "fit": {"kind": kind}}
    (tmp_path / "scene.json").write_text(json.dumps(keys | {"profile": profile, "expected": []}))
    first = load_scene(tmp_path / "scene.json")
    assert first.profile.fitted.source == "trace.csv"
    first.save(tmp_path / "saved.toml")
    (tmp_path / "trace.csv").unlink()
    reloaded = load_scene(tmp_path / "saved.toml")
    assert reloaded.profile == first.profile
    assert Scene.model_validate_json(first.model_dump_json()).profile == first.profile
    assert fit_uncertainty(reloaded, 3) == fit_uncertainty(first, 3)


def test_other_numbers_are_fitted_to_nothing():
    scene = scene_of(rows_of(TRUTHS["hertz"], noise=20e-6), "hertz", 20e-6)
    assert scene.vary(friction=0.5).profile.fitted == scene.profile.fitted
    assert scene.vary(profile={"radius": 900.0}).profile.fitted is None
    with pytest.raises(InputError, match=r"take scenes\.fit_profile"):
        Tabulated(points=rows_of(TRUTHS["hertz"]), fit={"kind": "hertz"}).spline()
    with pytest.raises(InputError, match="is not fitted"):
        fit_uncertainty(scene.vary(profile={"radius": 900.0}))


def test_extent_and_centre_are_respected():
    rows = rows_of(TRUTHS["flat_rounded"], 301)
    inner = fit_profile(rows, "flat_rounded", extent=0.9)
    assert inner.flat_half_length == pytest.approx(0.5, rel=1e-5)
    assert 0.8 < inner.fitted.extent <= 0.9
    assert inner.fitted.left_out == np.count_nonzero(np.abs(rows[:, 0] - 0.1) > 0.9)
    off_centre = fit_profile(rows, "hertz", centre=0.3)
    assert (off_centre.fitted.centre, off_centre.fitted.centre_fitted) == (0.3, False)
    right = rows_of(TRUTHS["hertz"], 301, middle=0.0)
    right = fit_profile(right[right[:, 0] >= 0], "hertz")
    assert (right.fitted.centre, right.fitted.centre_fitted) == (0.0, False)
    assert right.fitted.extent > 1.5
    for kind in KINDS:  # a trace that is counted from its first row has both sides
        shifted = fit_profile(
            rows_of(TRUTHS["flat_rounded"], 61, 20e-6) + np.array([1.5, 0.0]), kind
        )
        assert shifted.fitted.centre_fitted
        assert shifted.fitted.centre == pytest.approx(1.6, abs=0.05)
    sentences = fit_in_words(scene_of(rows, "flat_rounded", 1e-6, extent=0.9), 1.2)
    assert "reach 0.8" in sentences[-1]
    assert "extrapolation" in sentences[-1]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda rows: rows * [1, -1], "the rows do not bend up"),
        (lambda rows: rows * [1, 0], "the rows are flat from end to end"),
        (lambda rows: rows[:7], "7 rows .* at least 8"),
        (lambda rows: np.round(rows * [2, 1], 0) / [2, 1], "7 rows within the extent are too few"),
        (lambda rows: rows[::-1], "row 2: x = .* does not ascend"),
        (lambda rows: rows + np.array([5.0, 0.0]), "the middle, x = 0, is not among the rows"),
        (lambda rows: np.where(np.arange(len(rows))[:, None] == 40, np.nan, rows), "row 41"),
    ],
)
def test_rows_that_can_not_be_fitted_are_one_sentence(change, sentence):
    rows = change(rows_of(TRUTHS["hertz"]))
    with pytest.raises(InputError, match=sentence):
        fit_profile(rows, "hertz", centre=0.0)


def test_noise_that_is_not_that_of_the_rows_is_said():
    rows = rows_of(TRUTHS["flat_rounded"], 301, 20e-6)
    requests = (("flat_rounded", 20e-6), ("hertz", 20e-6), ("flat_rounded", 1e-4))
    sentences_of_each = [fit_in_words(scene_of(rows, kind, noise), 0.5) for kind, noise in requests]
    assert [len(sentences) for sentences in sentences_of_each] == [1, 3, 2]
    assert "The residuals are no noise" in sentences_of_each[1][1]
    assert "does not describe the rows" in sentences_of_each[1][2]
    assert "the noise is smaller than stated" in sentences_of_each[2][1]


# A trace of a flat pad as it lies in the instrument: x counted from its left end, noise of 0, 60
# and 300 nm.
TRACED = FlatRounded(radius=25.0, flat_half_length=1.2)
TRACE = np.linspace(-2.4, 2.4, 201)
TILTS = [(tilt, noise) for tilt in (-5e-3, 0.0, 1e-3, 3e-3, 5e-3) for noise in (0.0, 6e-5, 3e-4)]


def traced(tilt, noise, seed=0):
    h = (
        0.01
        + tilt * TRACE
        + TRACED.height(TRACE - 0.08)
        + noise * np.random.default_rng(seed).standard_normal(len(TRACE))
    )
    return np.column_stack([TRACE + 2.4, h])


@pytest.mark.parametrize(("tilt", "noise"), TILTS)
def test_the_tilt_of_a_trace_is_fitted_with_the_shape_and_taken_out(tilt, noise):
    """b, R, middle, offset and tilt are those of the trace, within four standard deviations by
    linear theory.
    """
    rows = traced(tilt, noise)
    fit = fit_profile(rows, "flat_rounded")
    s = np.abs(TRACE - 0.08) - 1.2
    edge = np.maximum(s, 0.0)
    bend = 1 / 25.0
    side = np.sign(TRACE - 0.08)
    # Changes of h with offset, tilt, middle, half-length and curvature.
    slopes = np.column_stack(
        [np.ones(len(s)), TRACE - 0.08, -bend * edge * side, -bend * edge, edge**2 / 2]
    )
    deviations = noise * np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
    fitted = fit.fitted
    errors = np.abs(
        [
            fitted.offset - (0.01 + 0.08 * tilt),
            fitted.tilt - tilt,
            fitted.centre - 2.48,
            fit.flat_half_length - 1.2,
            1 / fit.radius - bend,
        ]
    )
    assert np.all(errors <= 4 * deviations + 2e-6)
    assert fitted.tilt_fitted
    scene = load_scene("hertz-paper").vary(load=LOAD, profile=fit)
    assert not fit_warnings(scene, 1.0)


def test_w_of_a_tilted_trace_lies_within_what_is_stated():
    keys = {"kind": "tabulated", "points": traced(3e-3, 6e-5), "fit": {"kind": "flat_rounded"}}
    load = {
        "kind": "polygon",
        "initial_loading": [[120.0, 0.0], [120.0, 35.0]],
        "cycle": [[120.0, -35.0]],
    }
    scene = load_scene("hertz-paper").vary(load=load, friction=0.5, profile=keys, expected=())
    truth = semi_analytic.solve(scene.vary(profile=TRACED), x=0.0, fields="dissipation").dissipation
    work = fit_uncertainty(scene, 10).dissipation
    assert abs(work.value - truth) <= work.uncertainty <= 0.02 * truth
    # A tilt that is stated, and is not that of the trace, leaves residuals with a pattern: said,
    # and covered.
    level = scene.vary(
        profile={
            "kind": "tabulated",
            "points": traced(3e-3, 6e-5),
            "fit": {"kind": "flat_rounded", "tilt": 0.0},
        }
    )
    wide = fit_uncertainty(level, 10).dissipation
    assert 0.15 * truth < abs(wide.value - truth) <= wide.uncertainty
    assert "no noise" in fit_warnings(level, 0.0)[0]
    assert "tilt, fitted and taken out, is 0.00" in fit_in_words(scene, 0.0)[0]


def test_a_tilt_that_the_rows_do_not_show_is_none():
    """A parabola with tilt is a parabola with another middle: no fit makes much tilt of it, and the
    curve is that of the rows.
    """
    rows = np.column_stack(
        [
            TRACE,
            TRACE**2 / 180
            + 3e-3 * TRACE
            + 6e-5 * np.random.default_rng(0).standard_normal(len(TRACE)),
        ]
    )
    for kind in ("hertz", "flat_rounded", "even_polynomial"):
        fit = fit_profile(rows, kind)
        assert fit.fitted.centre == pytest.approx(-90 * 3e-3, abs=0.05)
        assert float(fit.height(1.0)) == pytest.approx(1 / 180, rel=5e-3)
    right = rows_of(TRUTHS["flat_rounded"], 301, middle=0.0)
    one_side = fit_profile(right[right[:, 0] >= 0], "flat_rounded")
    assert not one_side.fitted.tilt_fitted
    stated = fit_profile(traced(3e-3, 6e-5), "flat_rounded", tilt=3e-3)
    assert (stated.fitted.tilt, stated.fitted.tilt_fitted) == (3e-3, False)
    assert stated.flat_half_length == pytest.approx(1.2, abs=5e-3)


def test_uncertainty_grows_with_the_noise_and_is_the_spread_of_other_measurements():
    truth = TRUTHS["flat_rounded"]
    small, large = (
        fit_uncertainty(scene_of(rows_of(truth, 101, noise), "flat_rounded", noise), 30)
        for noise in (2e-6, 20e-6)
    )
    for name in ("dissipation", "half_width", "peak_pressure"):
        first, second = (getattr(uncertainty, name).uncertainty for uncertainty in (small, large))
        assert second / first == pytest.approx(10.0, rel=0.35)
    # By real other measurements.
    scenes = [
        scene_of(rows_of(truth, 101, 20e-6, seed=seed), "flat_rounded", 20e-6) for seed in range(60)
    ]
    widths = [largest_contact(scene, "").half_width for scene in scenes]
    assert large.half_width.uncertainty == pytest.approx(2 * np.std(widths), rel=0.25)
    first, second = (fit_uncertainty(scenes[0], 4, seed) for seed in (1, 2))
    assert (first.resamples, first.failed) == (4, 0)
    assert first.half_width != second.half_width


def test_the_uncertainty_of_a_spline_covers_what_smoothing_takes_from_a_flat():
    """Ten times less of it changes the half-width more than the mean of other measurements does:
    these have lost it already.
    """
    scene = scene_of(rows_of(TRUTHS["flat_rounded"], 61, 50e-6, seed=1), "smoothing_spline", 50e-6)
    half_width = fit_uncertainty(scene, 10).half_width

    def change(keys):
        return (
            largest_contact(scene.vary(profile={**keys, "fitted": None}), "").half_width
            - half_width.value
        )

    random = np.random.default_rng(0)
    changes = [change(fitted_again(scene.profile, random.standard_normal(61))) for _ in range(10)]
    closer = abs(change(fitted_again(scene.profile, smoothing_factor=0.1)))
    assert closer > abs(np.mean(changes))
    assert half_width.uncertainty == pytest.approx(2 * np.std(changes) + closer, rel=1e-9)


def test_spikes_are_left_out_and_named_and_corners_are_none():
    rows = rows_of(TRUTHS["flat_rounded"], 201, 5e-6)
    without = scene_of(rows, "flat_rounded", 5e-6).profile
    assert without.fitted.spikes == ()
    spoilt = rows.copy()
    spoilt[[0, 40, 41, 120], 1] += [4e-4, 1e-4, -2e-4, 6e-5]
    scene = scene_of(spoilt, "flat_rounded", 5e-6)
    assert {1, 41, 42, 121} <= set(scene.profile.fitted.spikes)
    assert len(scene.profile.fitted.spikes) <= 6
    assert scene.profile.flat_half_length == pytest.approx(without.flat_half_length, abs=2e-3)
    assert len(scene.profile.fitted.used_rows()) == 201 - len(scene.profile.fitted.spikes)
    assert "that stand out left out (row 1, " in fit_in_words(scene, 0.9)[0]
    assert "large dots" in fit_residuals(scene, 0.9).caption
    # exact rows with corners, of the wrong kind too
    for kind in ("flat_rounded", "hertz"):
        exact = scene_of(rows_of(TRUTHS["flat_rounded"], 61, 0.0), kind, 1e-6)
        assert exact.profile.fitted.spikes == ()


@pytest.mark.parametrize("n_points", [8, 9, 19, 20, 40])
def test_a_spike_is_at_most_a_twentieth_of_the_points(n_points):
    """A fit takes 8 points; of fewer than 20 a single one is too many to be left out."""
    x = np.linspace(-1.0, 1.0, n_points)
    h = x**2 + 1e-6 * np.random.default_rng(0).standard_normal(n_points)
    spike_row = n_points // 2
    h[spike_row] += 1e-3
    fitted = fitted_keys(x, h, FitRequest(kind="hertz"))["fitted"]
    assert fitted.get("spikes", ()) == ((spike_row + 1,) if n_points >= 20 else ())


@pytest.mark.parametrize("tilt", [-5e-3, 3e-3])
@pytest.mark.parametrize("kind", ["hertz", "flat_rounded"])
def test_a_trace_that_falls_from_end_to_end_is_levelled(kind, tilt):
    truth = TRUTHS[kind]
    rows = rows_of(truth, 201, 5e-6)
    rows[:, 1] += tilt * rows[:, 0]
    profile = scene_of(rows, kind, 5e-6).profile
    assert profile.radius == pytest.approx(truth.radius, rel=0.02)
    assert profile.fitted.tilt == pytest.approx(tilt, abs=5e-4)


def test_check_draws_trace_fit_and_residuals(tmp_path):
    scene = scene_of(rows_of(TRUTHS["hertz"], 61, 5e-6), "hertz", 5e-6)
    scene.save(tmp_path / "trace.toml")
    scene_files._draw_fit(scene, tmp_path / "fit.svg")
    picture = (tmp_path / "fit.svg").read_text(encoding="utf-8")
    assert picture.startswith("<svg")
    assert picture.count("<circle") >= 2 * 61
    for name, file, fact in (
        ("trace.toml", "fit.svg", "is there already"),
        ("trace.toml", "fit.png", "written as .svg"),
        ("hertz-paper", "new.svg", "is not fitted"),
    ):
        assert fact in refused(tmp_path, "check", name, "--picture", file)


def test_page_and_json_state_the_fit():
    scene = scene_of(rows_of(TRUTHS["flat_rounded"], 301, 20e-6), "flat_rounded", 20e-6)
    sentences, uncertainty = findings_on_fit(scene)
    assert "W = 0.000" in sentences[-1]
    page_content = content(scene)
    assert page_content["uncertainty_95"]["dissipation"]["value"] == uncertainty.dissipation.value
    assert (page_content["fit"]["count"], page_content["sentences"]) == (301, sentences)
    assert content(load_scene("hertz-paper")) is None
    plate = fit_residuals(scene, 0.9)
    assert len(plate.table["x [mm]"]) == 301
    assert np.std(plate.table["row - fit [mm]"]) == pytest.approx(
        scene.profile.fitted.residual, rel=1e-6
    )
    assert fit_residuals(load_scene("hertz-paper"), 1.0) is None
