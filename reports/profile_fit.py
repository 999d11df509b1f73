"""A profile fitted to measured rows: what it rests on in words, and what the noise of the rows
leaves open in W, a and p0.
"""

from __future__ import annotations

import contextlib
from dataclasses import asdict, dataclass
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
from scenes.fitting import fitted_again, fitted_by_spline
from scenes.profiles import Fitted

# Other measurements that the noise could have given. Twice their standard deviation is known to 7
# %, and a normal spread lies within it in 95 %.
_RESAMPLES = 100
# Fewer of a load that is no ellipse, each of which takes a march of its own; none of a longer
# record.
_MARCHES, _MOST_ROWS = 30, 2_000
# Of residuals over the noise: chance alone gives so much in one case of 1,000, as a share of the
# expected spread.
_CHANCE = 3.3
# Of the change by a spline: it follows other shapes, but for some per cent of them.
_SPLINE = 1.25
# Residuals over the range of h below which they are round-off error of the fit, which has a pattern
# of its own.
_ROUND_OFF = 1e-9


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
    """What the scene's profile was fitted to, if it was."""
    return getattr(scene.profile, "fitted", None)


def fit_uncertainty(scene: Scene, resamples: int = _RESAMPLES, seed: int = 0) -> FitUncertainty:
    """W, a and p0 with their 95 % uncertainty: of what other noise on the fitted curve changes, 2
    standard deviations and the mean.

    In place of the mean, if it is more: the change by a tenth of the smoothing. The curve that gets
    the noise has lost already what smoothing takes from the rows.

    Residuals with a pattern are no noise. Then each other measurement has them too, moved along x,
    and the change by a smoothing spline through the same rows, with a tilt of its own, is added: it
    follows shapes that this kind of profile does not have.

    Raises
    ------
    InputError
        For a scene whose profile is not fitted.
    """
    if (fitted := fit_of(scene)) is None:
        raise InputError(
            f"{scene.name}: its profile is not fitted to rows, so that there is no noise to follow"
        )
    marched = not isinstance(scene.load, EllipseLoad) or scene.load.has_bulk_or_tilt
    skipped = (
        marched and isinstance(scene.load, TimeSeriesLoad) and len(scene.load.rows) > _MOST_ROWS
    )
    count = min(resamples, _MARCHES) if marched and not skipped else resamples

    def others(keys: dict[str, Any] | None) -> NDArray[np.float64] | None:
        with contextlib.suppress(InputError):  # a contact wider than the rows
            return (
                None
                if keys is None
                else _values(scene.vary(profile={**keys, "fitted": None}), marched, skipped)
            )
        return None

    first, random = _values(scene, marched, skipped), np.random.default_rng(seed)
    closer = others(fitted_again(scene.profile, smoothing=0.1)) if fitted.weight else None
    pattern = _pattern(scene)
    noises = (_noise(random, fitted, pattern) for _ in range(count))
    rows = [
        found
        for noise in noises
        if (found := others(fitted_again(scene.profile, noise))) is not None
    ]
    if len(rows) < max(2, count // 2):
        raise InputError(
            f"{scene.name}: of {count} other measurements with this noise only {len(rows)} can"
            " carry the load: measure a wider stretch, or more closely"
        )
    changes = np.array(rows) - first
    # The mean is what the fit itself errs by at this noise: a curve that may not bend down, or is
    # smoothed, has some.
    own = np.abs(np.mean(changes, axis=0))
    spread = 2 * np.std(changes, axis=0) + (
        own if closer is None else np.maximum(own, np.abs(closer - first))
    )
    if pattern is not None and fitted.kind != "smoothing_spline":
        spline = others(fitted_by_spline(scene.profile))
        if spline is None:
            raise InputError(
                f"{scene.name}: the residuals have a pattern, and no smoothing spline through these"
                " rows carries the load: state another kind of fit, or fewer rows by its key"
                " extent"
            )
        spread += _SPLINE * np.abs(spline - first)
    work, half, peak = (
        Spread(value, float(size)) for value, size in zip(first.tolist(), spread, strict=True)
    )
    return FitUncertainty(None if skipped else work, half, peak, count, count - len(rows), seed)


def _pattern(scene: Scene) -> NDArray[np.float64] | None:
    """Residuals (n,) of the rows that count where they are no noise; None where they may be.

    Of white noise neighbouring residuals are not correlated, and the mean of m of them has a
    variance m times less. Chance alone misses either in one case of 1,000.
    """
    fitted = fit_of(scene)
    assert fitted is not None
    used = fitted.used_rows()
    residuals = fitted.residuals(scene.profile.height)[used]
    residuals = residuals - np.mean(residuals)
    square = float(residuals @ residuals)
    if np.sqrt(square / len(residuals)) <= _ROUND_OFF * float(np.ptp(fitted.rows.values[used, 1])):
        return None
    count = len(residuals)
    correlation = float(residuals[1:] @ residuals[:-1]) / square
    size = int(np.sqrt(count))
    blocks = count // size
    means = residuals[: blocks * size].reshape(blocks, size).mean(axis=1)
    excess = size * float(np.mean(means**2)) / (square / count) - 1
    alike = correlation * np.sqrt(count) > _CHANCE or excess > _CHANCE * np.sqrt(2 / blocks)
    return residuals if alike else None


def _noise(
    random: np.random.Generator, fitted: Fitted, pattern: NDArray[np.float64] | None
) -> NDArray[np.float64]:
    """Noise (n,) of another measurement over that of the fit, with the pattern of the residuals
    moved along x.
    """
    noise = random.standard_normal(len(fitted.rows) - fitted.left_out)
    if pattern is None:
        return noise
    moved = np.roll(pattern, random.integers(len(pattern)))[:: random.choice([-1, 1])]
    return np.asarray(noise + random.choice([-1.0, 1.0]) * moved / fitted.noise)


def _values(scene: Scene, marched: bool, skipped: bool) -> NDArray[np.float64]:
    """W, a, p0."""
    contact = largest_contact(scene, scene.name)
    work = 0.0
    if marched and not skipped:
        work = semi_analytic.solve(scene, x=0.0, fields="dissipation").dissipation
    elif not marched:
        load = scene.load
        names = (
            "mean_normal_load",
            "normal_amplitude",
            "mean_tangential_load",
            "tangential_amplitude",
            "phase",
        )
        batch = semi_analytic.dissipation(
            profile=scene.profile,
            material=scene.material,
            friction_coefficient=scene.friction.coefficient,
            **{name: getattr(load, name) for name in names},
        )
        if batch.reason:
            raise InputError(
                f"{scene.name}: the dissipation has no value:"
                f" {semi_analytic.Reason(int(batch.reason)).name.lower()}"
            )
        work = float(batch.value)
    return np.array([work, contact.half_width, contact.peak_pressure])


def fit_in_words(scene: Scene, half_width: float) -> list[str]:
    """What was fitted to which rows, how well, and how far they reach; none for another profile.

    Parameters
    ----------
    half_width : of the largest contact
    """
    fitted, profile = fit_of(scene), scene.profile
    if fitted is None:
        return []
    _, length, _ = units(scene)
    match profile:
        case Hertz(radius=radius):
            shape = f"a parabola of radius {number(radius)} {length}"
        case FlatRounded(radius=radius, flat_half_length=half):
            shape = (
                f"a flat of half-length {number(half)} {length} with edges of radius"
                f" {number(radius)} {length}"
            )
        case EvenPolynomial(rises=rises):
            shape = f"an even polynomial of {np.count_nonzero(rises)} terms"
        case _:
            shape = "a smoothing spline"
    centre = (
        f"Its middle, {'fitted' if fitted.centre_fitted else 'given'}, is x ="
        f" {number(fitted.centre)} {length}"
    )
    more = f", {fitted.left_out} beyond the extent left out" if fitted.left_out else ""
    if fitted.tilt_fitted:
        centre += f", and its tilt, fitted and taken out, is {number(fitted.tilt)} rad"
    elif fitted.tilt:
        centre += f", and a tilt of {number(fitted.tilt)} rad was taken out, as stated"
    stated = "stated" if fitted.noise_stated else "taken from these residuals"
    return [
        (
            f"The profile is {shape}, fitted to {len(fitted.rows) - fitted.left_out} rows of"
            f" {fitted.source}{more}. {centre}. Residuals are {fitted.residual:.3g} {length} (root"
            f" mean square), the noise is {fitted.noise:.3g} {length} ({stated})."
        ),
        *fit_warnings(scene, half_width),
    ]


def fit_warnings(scene: Scene, half_width: float) -> list[str]:
    """What is wrong with a fit: residuals that are no noise, or not that stated, a contact wider
    than the rows; none, if nothing.

    Parameters
    ----------
    half_width : of the largest contact
    """
    fitted = fit_of(scene)
    if fitted is None:
        return []
    length = units(scene)[1]
    warnings = []
    pattern = _pattern(scene)
    if pattern is not None:
        warnings.append(
            "The residuals are no noise: they have a pattern along x. Rows that are"
            f" {fitted.kind.replace('_', ' ')} do not leave one: take another kind of fit, or a"
            " smaller extent. The uncertainty is widened: by this pattern moved along x, and by"
            " the change that a smoothing spline makes."
        )
    excess = (
        (fitted.residual / fitted.noise) ** 2
        * (len(fitted.rows) - fitted.left_out)
        / fitted.freedom
    )
    if fitted.noise_stated and abs(excess - 1) > _CHANCE * np.sqrt(2 / fitted.freedom):
        more = "this kind of profile does not describe the rows, or the noise is larger"
        if pattern is None:
            more += ". The uncertainty does not cover that"
        less = "the noise is smaller than stated, or the rows were smoothed before"
        warnings.append(
            f"The residuals are {np.sqrt(excess):.2g} times what the stated noise explains:"
            f" {more if excess > 1 else less}."
        )
    if half_width > fitted.extent:
        warnings.append(
            f"The largest contact, a = {half_width:.4g} {length}, is wider than the rows, which"
            f" reach {fitted.extent:.4g} {length} from the middle: beyond them the fit is an"
            " extrapolation."
        )
    return warnings


def _uncertainty_in_words(scene: Scene, found: FitUncertainty) -> str:
    """The three values, with what makes them uncertain."""
    _, length, stress = units(scene)

    def share(one: Spread) -> str:
        return f"{one.value:.6g} ± {100 * one.uncertainty / one.value:.2g} %" if one.value else "0"

    work = f"W = {share(found.dissipation)}, " if found.dissipation else ""
    failed = f", {found.failed} of them unfit" if found.failed else ""
    return (
        f"The noise of the rows leaves open (95 %): {work}a = {share(found.half_width)} {length},"
        f" p0 = {share(found.peak_pressure)} {stress}. That is by {found.resamples} other"
        f" measurements with this noise{failed}."
    )


@lru_cache(maxsize=4)
def findings(scene: Scene) -> tuple[tuple[str, ...], FitUncertainty | None]:
    """The sentences about a fitted profile and what its noise leaves open; none, and None, of
    another scene.

    The page, its JSON and the terminal ask for the same, which takes up to some seconds: it is
    worked out once.
    """
    if fit_of(scene) is None:
        return (), None
    half_width = 0.0
    try:
        half_width = largest_contact(scene, scene.name).half_width
        found = fit_uncertainty(scene)
    except InputError as fault:
        return (
            *fit_in_words(scene, half_width),
            f"The uncertainty from the noise has no value: {fault}.",
        ), None
    return (*fit_in_words(scene, half_width), _uncertainty_in_words(scene, found)), found


def content(scene: Scene) -> dict[str, Any] | None:
    """The same for JSON; None of a scene whose profile is not fitted."""
    fitted = fit_of(scene)
    if fitted is None:
        return None
    said, found = findings(scene)
    fit = fitted.model_dump(mode="json", exclude={"rows"}) | {
        "count": len(fitted.rows) - fitted.left_out
    }
    return {"sentences": said, "fit": fit, "uncertainty_95": asdict(found) if found else None}
