"""A profile fitted to measured rows: in words what was fitted to which rows, and the uncertainty of
W, a and p0 by the noise of the rows.
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

# Number of simulated measurements. They give twice the standard deviation to 7 %, within which 95 %
# of normal values lie.
_N_RESAMPLES = 100
# Fewer where W takes a march along the load path for each; no W for records of more rows.
_MOST_MARCHED_RESAMPLES = 30
_MOST_ROWS_FOR_WORK = 2_000
# A test value of white noise exceeds its expectation by so many of its standard deviations in one
# case of 1,000.
_MOST_SIGMAS_BY_CHANCE = 3.3
# Factor on the change by a smoothing spline, which follows other shapes to some per cent only.
_FACTOR_ON_SPLINE_CHANGE = 1.25
# Residuals over the range of h below which they are round-off error of the fit, which has a pattern
# of its own.
_LEAST_RELATIVE_RESIDUAL = 1e-9
# Spikes, rows that stand out from the fit, that a sentence names.
_MOST_SHOWN_SPIKES = 5


@dataclass(frozen=True)
class Spread:
    """A value and its 95 % uncertainty from the noise of the rows."""

    value: float
    uncertainty: float


@dataclass(frozen=True)
class FitUncertainty:
    """Values under a fitted profile, each with its uncertainty by the noise of the rows.

    Attributes
    ----------
    dissipation
        W of the last whole cycle; None where it was not computed, for long records
    half_width, peak_pressure
        a and p0 at the largest load
    resamples, failed
        number of simulated measurements that were fitted, and of those among them whose fit cannot
        carry the load: it does not bend up, or is too narrow
    seed
        of the random numbers
    """

    dissipation: Spread | None
    half_width: Spread
    peak_pressure: Spread
    resamples: int
    failed: int
    seed: int


def profile_fit_of(scene: Scene) -> Fitted | None:
    """How the numbers of a scene's profile were fitted to measured rows [x, h]: kind of the fit,
    rows, noise. None for a profile that was not fitted.
    """
    return getattr(scene.profile, "fitted", None)


def fit_uncertainty(scene: Scene, resamples: int = _N_RESAMPLES, seed: int = 0) -> FitUncertainty:
    """Dissipation W, half-width a and peak pressure p0 under a profile that was fitted to measured
    rows, each with the 95 % uncertainty that the noise of the rows leaves.

    Measurements are simulated: random noise is added to the fitted curve, and the curve is fitted
    again. The uncertainty is twice the standard deviation of the values under these fits, plus a
    bias, the size of their mean change. For a smoothing spline the bias is at least the change
    under a tenth of the smoothing: the fitted curve, from which measurements are simulated, is
    smoothed already.

    Residuals with a pattern along x are no noise. Then each simulated measurement gets this pattern
    too, moved along x. Of other fits than a smoothing spline, 1.25 times the change by such a
    spline through the same rows is added: a spline follows shapes that the fitted kind cannot take.

    Parameters
    ----------
    scene
        whose profile was fitted
    resamples
        largest number of simulated measurements; fewer where W takes a solution along the load path
        for each
    seed
        seed of the random numbers

    Raises
    ------
    InputError
        For a scene whose profile is not fitted, and where too few of the other fits, or no
        smoothing spline that is needed, carry the load.
    """
    fit_record = profile_fit_of(scene)  # measured rows, kind of the fit, noise
    if fit_record is None:
        raise InputError(
            f"{scene.name}: its profile is not fitted to rows, so that there is no noise to follow"
        )
    # How W is computed, number of simulated measurements, and pattern of the residuals (None:
    # noise).
    work_method = _work_method_of(scene)
    # _MOST_MARCHED_RESAMPLES: 30; MARCHED: W by a solution along the load path
    n_resamples = (
        min(resamples, _MOST_MARCHED_RESAMPLES) if work_method is _WorkMethod.MARCHED else resamples
    )
    pattern = _pattern_of_residuals(scene)

    # W, a and p0 under the fitted profile, (3,), and under each simulated one, (n, 3).
    values_of_fit = _values_under_fit(scene, work_method)
    values_of_resamples = _values_with_other_noise(
        scene, fit_record, pattern, work_method, n_resamples, seed
    )
    changes = values_of_resamples - values_of_fit
    bias = _bias_of_fit(scene, values_of_fit, changes, work_method)
    uncertainty = 2 * np.std(changes, axis=0) + bias
    if pattern is not None and fit_record.kind != "smoothing_spline":
        # _FACTOR_ON_SPLINE_CHANGE: 1.25, since a spline follows other shapes to some per cent only
        uncertainty += _FACTOR_ON_SPLINE_CHANGE * _change_by_spline(
            scene, values_of_fit, work_method
        )
    # `Spread`: a value with its uncertainty; LEFT_OUT: no W is computed for long records
    work, half_width, peak_pressure = map(Spread, values_of_fit.tolist(), uncertainty.tolist())
    return FitUncertainty(
        dissipation=None if work_method is _WorkMethod.LEFT_OUT else work,
        half_width=half_width,
        peak_pressure=peak_pressure,
        resamples=n_resamples,
        failed=n_resamples - len(values_of_resamples),
        seed=seed,
    )


def _bias_of_fit(
    scene: Scene,
    values_of_fit: NDArray[np.float64],
    changes: NDArray[np.float64],
    work_method: _WorkMethod,
) -> NDArray[np.float64]:
    """The error that a fit makes by itself at the noise of its rows, of dissipation, half-width and
    peak pressure, (3,), never negative: a curve that may not bend down, or is smoothed, has one.

    It is the size of the mean change under other noise. For a smoothing spline it is at least the
    change under a tenth of the smoothing.

    Parameters
    ----------
    scene
        whose profile was fitted
    values_of_fit
        (3,) the values under the fitted profile
    changes
        (n, 3) their changes under fits to n simulated measurements
    work_method
        how the dissipation is computed, or that it is left out
    """
    from scenes.fitting import fitted_again

    bias = np.abs(np.mean(changes, axis=0))
    fit_record = profile_fit_of(scene)
    # `weight` is that of the smoothing of a spline, 0 for other kinds
    if fit_record is not None and fit_record.weight:
        # Keys of the profile fitted again; None where there is no such fit.
        less_smoothed_profile = fitted_again(scene.profile, smoothing_factor=0.1)
        values_of_less_smoothing = _values_under_other_fit(
            scene, less_smoothed_profile, work_method
        )
        if values_of_less_smoothing is not None:
            bias = np.maximum(bias, np.abs(values_of_less_smoothing - values_of_fit))
    return np.asarray(bias)


def _change_by_spline(
    scene: Scene, values_of_fit: NDArray[np.float64], work_method: _WorkMethod
) -> NDArray[np.float64]:
    """Sizes of the changes of dissipation, half-width and peak pressure, (3,), from the values of
    the fit (3,) to those under a smoothing spline through the same rows. InputError where no such
    spline carries the load.

    `values_of_fit` are those of the fit. `work_method` says how the dissipation is computed, or
    that it is left out.
    """
    from scenes.fitting import fitted_by_spline

    values_of_spline = _values_under_other_fit(scene, fitted_by_spline(scene.profile), work_method)
    if values_of_spline is None:
        raise InputError(
            f"{scene.name}: the residuals have a pattern, and no smoothing spline through these"
            " rows carries the load: state another kind of fit, or fewer rows by its key"
            " extent"
        )
    return np.abs(values_of_spline - values_of_fit)


class _WorkMethod(Enum):
    """How the dissipation under another fit of the profile is computed, and for which loads."""

    IN_BATCH = "an ellipse without bulk stress or tilt"
    MARCHED = "along its path"
    LEFT_OUT = "the record is too long"


def _work_method_of(scene: Scene) -> _WorkMethod:
    """How the dissipation under another fit of a scene's profile is computed: by the quick formula
    for elliptical load paths, by marching along the path, or not at all for long records.
    """
    load_record = scene.load
    if isinstance(load_record, EllipseLoad) and not load_record.has_bulk_or_tilt:
        return _WorkMethod.IN_BATCH
    if isinstance(load_record, TimeSeriesLoad) and len(load_record.rows) > _MOST_ROWS_FOR_WORK:
        return _WorkMethod.LEFT_OUT
    return _WorkMethod.MARCHED


def _values_under_other_fit(
    scene: Scene, profile_keys: dict[str, Any] | None, work_method: _WorkMethod
) -> NDArray[np.float64] | None:
    """Dissipation, largest half-width and peak pressure, (3,), of the scene with another fit of its
    profile, whose keys are `profile_keys`. None where there is no such fit (`profile_keys` None),
    and where the scene then has no solution: its contact would be wider than the rows.

    `work_method` says how the dissipation is computed, or that it is left out, as 0.
    """
    if profile_keys is None:
        return None
    try:
        # The new profile is no longer a fitted one.
        return _values_under_fit(scene.vary(profile={**profile_keys, "fitted": None}), work_method)
    except InputError:
        return None


def _values_with_other_noise(
    scene: Scene,
    fit_record: Fitted,
    pattern: NDArray[np.float64] | None,
    work_method: _WorkMethod,
    n_measurements: int,
    seed: int,
) -> NDArray[np.float64]:
    """Dissipation, half-width and peak pressure, (n, 3), under fits to `n_measurements` simulated
    measurements: the fitted curve with other noise.

    n is less than `n_measurements` where fits cannot carry the load; InputError where fewer than
    half of them can.

    Parameters
    ----------
    scene
        whose profile was fitted; its name stands in the message
    fit_record
        record of the fit, with the standard deviation of the noise of h
    pattern
        residuals (m,) of the m fitted rows where they have a pattern along x, which is added at
        another place; None: they are noise
    work_method
        how the dissipation is computed, or that it is left out
    seed
        seed of the random numbers
    """
    from scenes.fitting import fitted_again

    random = np.random.default_rng(seed)
    values_of_resamples = []
    for _ in range(n_measurements):
        # Heights of standard deviation 1 for each row; keys of the profile fitted to them, or None.
        simulated_noise = _simulated_noise(random, fit_record, pattern)
        profile_keys = fitted_again(scene.profile, simulated_noise)
        values = _values_under_other_fit(scene, profile_keys, work_method)
        if values is not None:
            values_of_resamples.append(values)
    if len(values_of_resamples) < max(2, n_measurements // 2):
        raise InputError(
            f"{scene.name}: of {n_measurements} other measurements with this noise only"
            f" {len(values_of_resamples)} can carry the load: measure a wider stretch, or more"
            " closely"
        )
    return np.array(values_of_resamples)


def _pattern_of_residuals(scene: Scene) -> NDArray[np.float64] | None:
    """Residuals of a profile's n fitted rows about their mean, (n,) row minus curve [length], where
    they have a pattern along x; None where they may be white noise.

    White noise has two properties. Neighbouring values are not correlated, and the mean of m of
    them has a variance m times smaller. A pattern is a correlation, or a variance of such means, so
    far above these that noise shows it by chance in one case of 1,000.
    """
    # Record of the fit: measured rows, and the fitted offset, tilt and middle.
    fit_record = profile_fit_of(scene)
    assert fit_record is not None
    # Numbers of the fitted rows; residuals are row minus curve.
    used_rows = fit_record.used_rows()
    residuals = fit_record.residuals(scene.profile.height)[used_rows]
    residuals = residuals - np.mean(residuals)
    sum_of_squares = float(residuals @ residuals)
    range_of_heights = float(np.ptp(fit_record.rows.values[used_rows, 1]))
    # _LEAST_RELATIVE_RESIDUAL: 1e-9; smaller residuals are round-off
    if np.sqrt(sum_of_squares / len(residuals)) <= _LEAST_RELATIVE_RESIDUAL * range_of_heights:
        return None

    # Correlation of neighbours, and variance of the means of blocks of sqrt(n) rows.
    n_rows = len(residuals)
    correlation = float(residuals[1:] @ residuals[:-1]) / sum_of_squares
    block_size = int(np.sqrt(n_rows))
    n_blocks = n_rows // block_size
    block_means = residuals[: n_blocks * block_size].reshape(n_blocks, block_size).mean(axis=1)
    # variance of the means of blocks over that of white noise, minus 1
    excess_variance = block_size * float(np.mean(block_means**2)) / (sum_of_squares / n_rows) - 1
    # _MOST_SIGMAS_BY_CHANCE: 3.3 standard deviations
    is_correlated = correlation * np.sqrt(n_rows) > _MOST_SIGMAS_BY_CHANCE
    varies_over_blocks = excess_variance > _MOST_SIGMAS_BY_CHANCE * np.sqrt(2 / n_blocks)
    has_pattern = is_correlated or varies_over_blocks
    return residuals if has_pattern else None


def _simulated_noise(
    random: np.random.Generator, fit_record: Fitted, pattern: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Noise (n,) of a simulated measurement, over the standard deviation of the measured noise.

    `pattern` (n,) are the residuals where they have a pattern along x, else None. It is added moved
    along x, and at random reversed in x and in sign. `fit_record` has the indices of the fitted
    rows, and the standard deviation of their noise.
    """
    standard_noise = random.standard_normal(len(fit_record.used_rows()))
    if pattern is None:
        return standard_noise
    moved_pattern = np.roll(pattern, random.integers(len(pattern)))[:: random.choice([-1, 1])]
    return np.asarray(
        standard_noise + random.choice([-1.0, 1.0]) * moved_pattern / fit_record.noise
    )


def _values_under_fit(scene: Scene, work_method: _WorkMethod) -> NDArray[np.float64]:
    """Dissipation W, largest half-width a and peak pressure p0, (3,); W is 0 where left out."""
    contact = largest_contact(scene, scene.name)
    work = 0.0
    if work_method is _WorkMethod.MARCHED:
        work = semi_analytic.solve(scene, x=0.0, fields="dissipation").dissipation
    elif work_method is _WorkMethod.IN_BATCH:
        work = _work_of_ellipse(scene)
    return np.array([work, contact.half_width, contact.peak_pressure])


def _work_of_ellipse(scene: Scene) -> float:
    """Dissipation W of a cycle under an elliptical load path.

    Raises
    ------
    InputError
        Where it has no value, such as under gross sliding.
    """
    load_ellipse = scene.load
    keys_of_load = (
        "mean_normal_load",
        "normal_amplitude",
        "mean_tangential_load",
        "tangential_amplitude",
        "phase_radians",
    )
    # `value` is W; `reason` is 0 where W has a value.
    batch = semi_analytic.dissipation(
        profile=scene.profile,
        material=scene.material,
        friction_coefficient=scene.friction.coefficient,
        **{name: getattr(load_ellipse, name) for name in keys_of_load},
    )
    if batch.reason:
        reason = semi_analytic.Reason(int(batch.reason)).name.lower()
        raise InputError(f"{scene.name}: the dissipation has no value: {reason}")
    return float(batch.value)


def fit_in_words(scene: Scene, half_width: float) -> list[str]:
    """Sentences on a fitted profile: which curve was fitted to which rows, its residuals and noise,
    and warnings; none for a profile that is not fitted.

    Parameters
    ----------
    scene
        whose profile may be fitted
    half_width
        half-width of the largest contact [length]
    """
    # Record of the fit; None for a profile that is not fitted.
    fit_record = profile_fit_of(scene)
    if fit_record is None:
        return []
    _, unit_of_length, _ = units(scene)

    # Middle and tilt: stated, or fitted too.
    centre_source = "fitted" if fit_record.centre_fitted else "given"
    centre_in_words = (
        f"Its middle, {centre_source}, is x = {number(fit_record.centre)} {unit_of_length}"
    )
    if fit_record.tilt_fitted:
        centre_in_words += f", and its tilt, fitted and taken out, is {number(fit_record.tilt)} rad"
    elif fit_record.tilt:
        centre_in_words += f", and a tilt of {number(fit_record.tilt)} rad was taken out"

    # Rows that were left out, and where the noise comes from.
    omissions_in_words = (
        f", {fit_record.left_out} beyond the extent left out" if fit_record.left_out else ""
    )
    omissions_in_words += _spikes_in_words(fit_record)
    noise_source = "stated" if fit_record.noise_stated else "taken from these residuals"
    n_fitted_rows = len(fit_record.used_rows())
    return [
        (
            f"The profile is {_shape_in_words(scene)}, fitted to {n_fitted_rows} rows of"
            f" {fit_record.source}{omissions_in_words}. {centre_in_words}. Residuals are"
            f" {fit_record.residual:.3g} {unit_of_length}"
            f" (root mean square), the noise is {fit_record.noise:.3g} {unit_of_length}"
            f" ({noise_source})."
        ),
        *fit_warnings(scene, half_width),
    ]


def _spikes_in_words(fit_record: Fitted) -> str:
    """How many rows that stand out were left out of the fit, and the numbers of the first of them;
    "" where there are none.
    """
    if not fit_record.spikes:
        return ""
    n_spikes = len(fit_record.spikes)
    row_numbers = ", ".join(f"{row:,}" for row in fit_record.spikes[:_MOST_SHOWN_SPIKES])
    ellipsis = ", ..." if n_spikes > _MOST_SHOWN_SPIKES else ""
    spikes_in_words = "one that stands out" if n_spikes == 1 else f"{n_spikes} that stand out"
    return f", {spikes_in_words} left out (row {row_numbers}{ellipsis})"


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
    """Sentences on what is wrong with a fitted profile: residuals that have a pattern or do not
    agree with the stated noise, a contact wider than the rows. An empty list where all is well, and
    for a profile that is not fitted.

    Parameters
    ----------
    scene
        whose profile may be fitted
    half_width
        half-width of the largest contact [length]
    """
    # Record of the fit; None for a profile that is not fitted.
    fit_record = profile_fit_of(scene)
    if fit_record is None:
        return []
    _, unit_of_length, _ = units(scene)
    warnings = []
    # The residuals where they have a pattern along x; None where they may be noise.
    pattern = _pattern_of_residuals(scene)
    if pattern is not None:
        warnings.append(
            "The residuals are no noise: they have a pattern along x. Rows that are"
            f" {fit_record.kind.replace('_', ' ')} do not leave one: take another kind of fit, or a"
            " smaller extent. The uncertainty is widened: by this pattern moved along x, and by"
            " the change that a smoothing spline makes."
        )

    n_rows = len(fit_record.used_rows())
    # Variance of the residuals over that of the noise. With `freedom` degrees of freedom it is 1
    # with standard deviation sqrt(2/freedom). `residual` is the root mean square of the residuals,
    # `noise` a standard deviation.
    variance_ratio = (fit_record.residual / fit_record.noise) ** 2 * n_rows / fit_record.freedom
    # _MOST_SIGMAS_BY_CHANCE: 3.3 standard deviations
    largest_by_chance = _MOST_SIGMAS_BY_CHANCE * np.sqrt(2 / fit_record.freedom)
    if fit_record.noise_stated and abs(variance_ratio - 1) > largest_by_chance:
        cause = "the noise is smaller than stated, or the rows were smoothed before"
        if variance_ratio > 1:
            cause = "this kind of profile does not describe the rows, or the noise is larger"
            if pattern is None:
                cause += ". The uncertainty does not cover that"
        warnings.append(
            f"The residuals are {np.sqrt(variance_ratio):.2g} times what the stated noise explains:"
            f" {cause}."
        )

    # `extent`: how far the rows reach from the middle.
    if half_width > fit_record.extent:
        warnings.append(
            f"The largest contact, a = {half_width:.4g} {unit_of_length}, is wider than the rows,"
            f" which reach {fit_record.extent:.4g} {unit_of_length} from the middle: beyond them"
            " the fit is an extrapolation."
        )
    return warnings


def _uncertainty_in_words(scene: Scene, fit_values: FitUncertainty) -> str:
    """A sentence on dissipation, half-width and peak pressure with their 95 % uncertainty by the
    noise of the rows.

    `fit_values` holds these values, each with its uncertainty (no dissipation for long records),
    and the numbers of simulated measurements and of those that cannot carry the load.
    """
    _, unit_of_length, unit_of_stress = units(scene)

    def with_per_cent(spread: Spread) -> str:
        """A value ± its uncertainty in per cent of it."""
        if not spread.value:
            return "0"
        return f"{spread.value:.6g} ± {100 * spread.uncertainty / spread.value:.2g} %"

    work_in_words = (
        f"W = {with_per_cent(fit_values.dissipation)}, " if fit_values.dissipation else ""
    )
    failures_in_words = f", {fit_values.failed} of them unfit" if fit_values.failed else ""
    return (
        f"The noise of the rows leaves open (95 %): {work_in_words}a ="
        f" {with_per_cent(fit_values.half_width)} {unit_of_length}, p0 ="
        f" {with_per_cent(fit_values.peak_pressure)} {unit_of_stress}. That is by"
        f" {fit_values.resamples}"
        f" other measurements with this noise{failures_in_words}."
    )


@lru_cache(maxsize=4)
def findings_on_fit(scene: Scene) -> tuple[tuple[str, ...], FitUncertainty | None]:
    """Sentences on a fitted profile, and the uncertainty of dissipation W, half-width a and peak
    pressure p0 by the noise of its rows.

    No sentences and None for a profile that is not fitted; None where the uncertainty has no value.
    It takes up to some seconds, and page, JSON and terminal all ask for it: it is computed once.
    """
    if profile_fit_of(scene) is None:
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
    fit_record = profile_fit_of(scene)
    if fit_record is None:
        return None
    # None for the uncertainty where it has no value.
    sentences, uncertainty = findings_on_fit(scene)
    content_of_fit = fit_record.model_dump(mode="json", exclude={"rows"})
    content_of_fit["count"] = len(fit_record.used_rows())
    return {
        "sentences": sentences,
        "fit": content_of_fit,
        "uncertainty_95": asdict(uncertainty) if uncertainty else None,
    }
