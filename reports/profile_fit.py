"""A profile fitted to measured rows: what it rests on in words, and what the noise of the rows
leaves open in W, a and p0.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import Enum
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.checking import largest_contact
from reports.units import number, units
from scenes import (
    EllipseLoad,
    EvenPolynomial,
    FlatRounded,
    Hertz,
    InputError,
    Scene,
    TimeSeriesLoad,
)
from scenes.profiles import Fitted

# Other measurements that the noise could have given. Twice their standard deviation is known to 7
# %, and a normal spread lies within it in 95 %.
_RESAMPLES = 100
# Fewer of a load that is no ellipse, each of which takes a march of its own; none of a longer
# record.
_MARCHES = 30
_MOST_ROWS = 2_000
# Of residuals over the noise: chance alone gives so much in one case of 1,000, as a share of the
# expected spread.
_CHANCE = 3.3
# Of the change by a spline: it follows other shapes, but for some per cent of them.
_SPLINE = 1.25
# Residuals over the range of h below which they are round-off error of the fit, which has a pattern
# of its own.
_ROUND_OFF = 1e-9
# Rows that stand out, in a sentence.
_SPIKES_SHOWN = 5


@dataclass(frozen=True)
class Spread:
    """A value and its 95 % uncertainty from the noise of the rows."""

    value: float
    uncertainty: float


@dataclass(frozen=True)
class FitUncertainty:
    """What the noise of the rows leaves open."""

    dissipation: Spread | None  # W of the last whole cycle; None where it was not resampled
    # half_width, peak_pressure: at the largest load
    half_width: Spread
    peak_pressure: Spread
    # resamples, failed: how many other measurements were fitted, and how many of those did not bend
    # up or were too narrow
    resamples: int
    failed: int
    seed: int  # of the random numbers


def fit_of(scene: Scene) -> Fitted | None:
    """How the numbers of a scene's profile were fitted to measured rows [x, h]: kind of the fit,
    rows, noise. None for a profile that was not fitted.
    """
    return getattr(scene.profile, "fitted", None)


def fit_uncertainty(scene: Scene, resamples: int = _RESAMPLES, seed: int = 0) -> FitUncertainty:
    """Dissipation W, half-width a and peak pressure p0 under a profile that was fitted to measured
    rows, each with the 95 % uncertainty that the noise of the rows leaves.

    The fit is repeated with other noise added to the fitted curve. The uncertainty is twice the
    standard deviation of the values so found, plus their mean change; or in place of the mean, if
    it is larger, the change by a tenth of the smoothing, since the fitted curve has lost already
    what smoothing takes from the rows.

    Residuals with a pattern along x are no noise. Then each repeated fit gets them too, moved along
    x, and the change by a smoothing spline through the same rows, with a tilt of its own, is added:
    it follows shapes that this kind of profile does not have.

    Parameters
    ----------
    resamples
        how many fits with other noise
    seed
        of the random numbers

    Raises
    ------
    InputError
        For a scene whose profile is not fitted.
    """
    fit = fit_of(scene)
    if fit is None:
        raise InputError(
            f"{scene.name}: its profile is not fitted to rows, so that there is no noise to follow"
        )
    from scenes.fitting import fitted_again, fitted_by_spline

    method_for_work = _way_to_work(scene)
    count = min(resamples, _MARCHES) if method_for_work is _Work.MARCHED else resamples
    pattern = _pattern(scene)
    values_of_fit = _values(scene, method_for_work)
    values_of_resamples = _values_with_other_noise(
        scene, fit, pattern, method_for_work, count, seed
    )
    changes = values_of_resamples - values_of_fit
    # The mean is what the fit itself errs by at this noise: a curve that may not bend down, or is
    # smoothed, has some.
    bias = np.abs(np.mean(changes, axis=0))
    # a smoothing spline: with less smoothing it loses less of the rows
    if fit.weight:
        less_smoothed = fitted_again(scene.profile, smoothing=0.1)
        values_less_smoothed = _values_of_another_fit(scene, less_smoothed, method_for_work)
        if values_less_smoothed is not None:
            bias = np.maximum(bias, np.abs(values_less_smoothed - values_of_fit))
    uncertainty = 2 * np.std(changes, axis=0) + bias
    if pattern is not None and fit.kind != "smoothing_spline":
        values_of_spline = _values_of_another_fit(
            scene, fitted_by_spline(scene.profile), method_for_work
        )
        if values_of_spline is None:
            raise InputError(
                f"{scene.name}: the residuals have a pattern, and no smoothing spline through these"
                " rows carries the load: state another kind of fit, or fewer rows by its key"
                " extent"
            )
        uncertainty += _SPLINE * np.abs(values_of_spline - values_of_fit)
    work, half_width, peak_pressure = map(Spread, values_of_fit.tolist(), uncertainty.tolist())
    return FitUncertainty(
        None if method_for_work is _Work.LEFT_OUT else work,
        half_width,
        peak_pressure,
        count,
        count - len(values_of_resamples),
        seed,
    )


class _Work(Enum):
    """How the dissipation of a resampled profile is computed."""

    IN_BATCH = "an ellipse without bulk stress or tilt"
    MARCHED = "along its path"
    LEFT_OUT = "the record is too long"


def _way_to_work(scene: Scene) -> _Work:
    """How the dissipation of another fit of a scene's profile is found: in one batch, by marching
    along the path, or left out for long records.
    """
    load = scene.load
    if isinstance(load, EllipseLoad) and not load.has_bulk_or_tilt:
        return _Work.IN_BATCH
    if isinstance(load, TimeSeriesLoad) and len(load.rows) > _MOST_ROWS:
        return _Work.LEFT_OUT
    return _Work.MARCHED


def _values_of_another_fit(
    scene: Scene, profile_keys: dict[str, Any] | None, method_for_work: _Work
) -> NDArray[np.float64] | None:
    """Dissipation, largest half-width and peak pressure, (3,), of the scene with another fit of its
    profile. None where there is no such fit (`profile_keys` None), or where its contact would be
    wider than the rows.

    `method_for_work` says how the dissipation is computed, or that it is left out.
    """
    if profile_keys is None:
        return None
    try:
        return _values(scene.vary(profile={**profile_keys, "fitted": None}), method_for_work)
    except InputError:
        return None


def _values_with_other_noise(
    scene: Scene,
    fit: Fitted,
    pattern: NDArray[np.float64] | None,
    method_for_work: _Work,
    count: int,
    seed: int,
) -> NDArray[np.float64]:
    """Dissipation, half-width and peak pressure, (n, 3), of fits to `count` simulated measurements:
    the fitted curve with other noise, and a `pattern` of the residuals moved along x.

    n is less than `count` where a fit can't carry the load; InputError where half of them can't.

    Parameters
    ----------
    method_for_work
        how the dissipation is computed, or that it is left out
    seed
        of the random numbers
    """
    from scenes.fitting import fitted_again

    random = np.random.default_rng(seed)
    values_of_resamples = []
    for _ in range(count):
        noise = _noise(random, fit, pattern)
        values = _values_of_another_fit(scene, fitted_again(scene.profile, noise), method_for_work)
        if values is not None:
            values_of_resamples.append(values)
    if len(values_of_resamples) < max(2, count // 2):
        raise InputError(
            f"{scene.name}: of {count} other measurements with this noise only"
            f" {len(values_of_resamples)} can carry the load: measure a wider stretch, or more"
            " closely"
        )
    return np.array(values_of_resamples)


def _pattern(scene: Scene) -> NDArray[np.float64] | None:
    """Residuals of a profile's fitted rows, (n,), row minus curve minus their mean, where they have
    a pattern along x; None where they may be noise.

    Of white noise neighbouring residuals are not correlated, and the mean of m of them has a
    variance m times less. Chance alone misses either in one case of 1,000.
    """
    fit = fit_of(scene)
    assert fit is not None
    used_rows = fit.used_rows()
    residuals = fit.residuals(scene.profile.height)[used_rows]
    residuals = residuals - np.mean(residuals)
    sum_of_squares = float(residuals @ residuals)
    range_of_heights = float(np.ptp(fit.rows.values[used_rows, 1]))
    if np.sqrt(sum_of_squares / len(residuals)) <= _ROUND_OFF * range_of_heights:
        return None
    n_rows = len(residuals)
    correlation = float(residuals[1:] @ residuals[:-1]) / sum_of_squares
    block_size = int(np.sqrt(n_rows))
    n_blocks = n_rows // block_size
    block_means = residuals[: n_blocks * block_size].reshape(n_blocks, block_size).mean(axis=1)
    # variance of the blocks' means over that of white noise, minus 1
    excess_variance = block_size * float(np.mean(block_means**2)) / (sum_of_squares / n_rows) - 1
    is_correlated = correlation * np.sqrt(n_rows) > _CHANCE
    varies_over_blocks = excess_variance > _CHANCE * np.sqrt(2 / n_blocks)
    has_pattern = is_correlated or varies_over_blocks
    return residuals if has_pattern else None


def _noise(
    random: np.random.Generator, fit: Fitted, pattern: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Noise (n,) of another measurement over that of the fit, with the pattern of the residuals
    moved along x.
    """
    noise = random.standard_normal(len(fit.used_rows()))
    if pattern is None:
        return noise
    shifted_pattern = np.roll(pattern, random.integers(len(pattern)))[:: random.choice([-1, 1])]
    return np.asarray(noise + random.choice([-1.0, 1.0]) * shifted_pattern / fit.noise)


def _values(scene: Scene, way: _Work) -> NDArray[np.float64]:
    """W, a, p0; 0 in place of W where that is left out."""
    contact = largest_contact(scene, scene.name)
    work = 0.0
    if way is _Work.MARCHED:
        work = semi_analytic.solve(scene, x=0.0, fields="dissipation").dissipation
    elif way is _Work.IN_BATCH:
        work = _work_of_ellipse(scene)
    return np.array([work, contact.half_width, contact.peak_pressure])


def _work_of_ellipse(scene: Scene) -> float:
    """Dissipation W of a cycle under an elliptical load path. InputError where it has no value."""
    load = scene.load
    names = (
        "mean_normal_load",
        "normal_amplitude",
        "mean_tangential_load",
        "tangential_amplitude",
        "phase_radians",
    )
    batch = semi_analytic.dissipation(
        profile=scene.profile,
        material=scene.material,
        friction_coefficient=scene.friction.coefficient,
        **{name: getattr(load, name) for name in names},
    )
    if batch.reason:
        reason = semi_analytic.Reason(int(batch.reason)).name.lower()
        raise InputError(f"{scene.name}: the dissipation has no value: {reason}")
    return float(batch.value)


def fit_in_words(scene: Scene, half_width: float) -> list[str]:
    """Sentences on a fitted profile: what was fitted to which rows, how well, and how far the rows
    reach; none for a profile that is not fitted.

    Parameters
    ----------
    half_width
        of the largest contact
    """
    fit = fit_of(scene)
    if fit is None:
        return []
    _, unit_of_length, _ = units(scene)
    how_centred = "fitted" if fit.centre_fitted else "given"
    centre = f"Its middle, {how_centred}, is x = {number(fit.centre)} {unit_of_length}"
    if fit.tilt_fitted:
        centre += f", and its tilt, fitted and taken out, is {number(fit.tilt)} rad"
    elif fit.tilt:
        centre += f", and a tilt of {number(fit.tilt)} rad was taken out"
    left_out_in_words = f", {fit.left_out} beyond the extent left out" if fit.left_out else ""
    left_out_in_words += _spikes_in_words(fit)
    noise_source = "stated" if fit.noise_stated else "taken from these residuals"
    # the rows that were fitted
    rows = len(fit.used_rows())
    return [
        (
            f"The profile is {_shape_in_words(scene)}, fitted to {rows} rows of"
            f" {fit.source}{left_out_in_words}. {centre}. Residuals are {fit.residual:.3g}"
            f" {unit_of_length}"
            f" (root mean square), the noise is {fit.noise:.3g} {unit_of_length} ({noise_source})."
        ),
        *fit_warnings(scene, half_width),
    ]


def _spikes_in_words(fit: Fitted) -> str:
    """Rows that stand out, some of them by number; empty without one."""
    if not fit.spikes:
        return ""
    count = len(fit.spikes)
    numbers = ", ".join(f"{row:,}" for row in fit.spikes[:_SPIKES_SHOWN])
    remainder = ", ..." if count > _SPIKES_SHOWN else ""
    rows = "one that stands out" if count == 1 else f"{count} that stand out"
    return f", {rows} left out (row {numbers}{remainder})"


def _shape_in_words(scene: Scene) -> str:
    """The curve that was fitted to a profile's rows, in words with its sizes: parabola, flat with
    rounded edges, even polynomial, or smoothing spline.
    """
    _, unit_of_length, _ = units(scene)
    match scene.profile:
        case Hertz(radius=radius):
            return f"a parabola of radius {number(radius)} {unit_of_length}"
        case FlatRounded(radius=radius, flat_half_length=half_length):
            return (
                f"a flat of half-length {number(half_length)} {unit_of_length} with edges of radius"
                f" {number(radius)} {unit_of_length}"
            )
        case EvenPolynomial(rises=rises):
            return f"an even polynomial of {np.count_nonzero(rises)} terms"
        case _:
            return "a smoothing spline"


def fit_warnings(scene: Scene, half_width: float) -> list[str]:
    """Sentences on what is wrong with a fit: residuals that are no noise or not the stated one, a
    contact wider than the rows; none if nothing is.

    Parameters
    ----------
    half_width
        of the largest contact
    """
    fit = fit_of(scene)
    if fit is None:
        return []
    _, unit_of_length, _ = units(scene)
    warnings = []
    pattern = _pattern(scene)
    if pattern is not None:
        warnings.append(
            "The residuals are no noise: they have a pattern along x. Rows that are"
            f" {fit.kind.replace('_', ' ')} do not leave one: take another kind of fit, or a"
            " smaller extent. The uncertainty is widened: by this pattern moved along x, and by"
            " the change that a smoothing spline makes."
        )
    n_rows = len(fit.used_rows())
    # of the residuals' variance over that of the noise
    variance_ratio = (fit.residual / fit.noise) ** 2 * n_rows / fit.freedom
    if fit.noise_stated and abs(variance_ratio - 1) > _CHANCE * np.sqrt(2 / fit.freedom):
        cause = "the noise is smaller than stated, or the rows were smoothed before"
        if variance_ratio > 1:
            cause = "this kind of profile does not describe the rows, or the noise is larger"
            if pattern is None:
                cause += ". The uncertainty does not cover that"
        warnings.append(
            f"The residuals are {np.sqrt(variance_ratio):.2g} times what the stated noise explains:"
            f" {cause}."
        )
    if half_width > fit.extent:
        warnings.append(
            f"The largest contact, a = {half_width:.4g} {unit_of_length}, is wider than the rows,"
            f" which reach {fit.extent:.4g} {unit_of_length} from the middle: beyond them the fit"
            " is an extrapolation."
        )
    return warnings


def _uncertainty_in_words(scene: Scene, uncertainty: FitUncertainty) -> str:
    """A sentence on dissipation, half-width and peak pressure with their 95 % uncertainty by the
    noise of the rows.
    """
    _, unit_of_length, unit_of_stress = units(scene)

    def with_share(spread: Spread) -> str:
        if not spread.value:
            return "0"
        return f"{spread.value:.6g} ± {100 * spread.uncertainty / spread.value:.2g} %"

    work_in_words = (
        f"W = {with_share(uncertainty.dissipation)}, " if uncertainty.dissipation else ""
    )
    words_of_failed = f", {uncertainty.failed} of them unfit" if uncertainty.failed else ""
    return (
        f"The noise of the rows leaves open (95 %): {work_in_words}a ="
        f" {with_share(uncertainty.half_width)} {unit_of_length}, p0 ="
        f" {with_share(uncertainty.peak_pressure)} {unit_of_stress}. That is by"
        f" {uncertainty.resamples}"
        f" other measurements with this noise{words_of_failed}."
    )


@lru_cache(maxsize=4)
def findings(scene: Scene) -> tuple[tuple[str, ...], FitUncertainty | None]:
    """Sentences on a fitted profile, and the uncertainty that the noise of its rows leaves; none,
    and None, for a profile that is not fitted.

    It takes up to some seconds, and page, JSON and terminal all ask for it: it is computed once.
    """
    if fit_of(scene) is None:
        return (), None
    half_width = 0.0
    try:
        half_width = largest_contact(scene, scene.name).half_width
        uncertainty = fit_uncertainty(scene)
    except InputError as fault:
        reason = f"The uncertainty from the noise has no value: {fault}."
        return (*fit_in_words(scene, half_width), reason), None
    sentence = _uncertainty_in_words(scene, uncertainty)
    return (*fit_in_words(scene, half_width), sentence), uncertainty


def content(scene: Scene) -> dict[str, Any] | None:
    """A fitted profile, its uncertainty by noise and sentences on both, for JSON; None for a
    profile that is not fitted.
    """
    profile_fit = fit_of(scene)
    if profile_fit is None:
        return None
    sentences, uncertainty = findings(scene)
    fit = profile_fit.model_dump(mode="json", exclude={"rows"})
    fit["count"] = len(profile_fit.used_rows())
    return {
        "sentences": sentences,
        "fit": fit,
        "uncertainty_95": asdict(uncertainty) if uncertainty else None,
    }
