"""What is wrong with a result's units and signs, told from the scales of the scene: each guess is a sentence.

# notation: a half-width and P normal load, of half-plane theory at the largest load of the path
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reports.scoring.mapping import Mapping
from reports.scoring.surface import SurfaceResult
from scenes import ContactSolution, InputError, Scene, freeze

Array = NDArray[np.float64]

# A figure of the result over that of theory may lie between these and be right: a frame near unloading, a coarse mesh, a wrong
# body. They are less than a factor of 1000 apart, so that at most one factor brings a figure between them.
LEAST, MOST = 0.03, 10.0
FACTORS = (1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9)
# Of the largest pressure; below it a point counts as open.
TOUCHES = 1e-3
# Of the half-width: a contact whose middle is farther from x = 0 was measured from elsewhere.
OFF_CENTRE = 0.5


@dataclass(frozen=True)
class Expected:
    """Scales of half-plane theory: largest a and P of the path, and P/(2 a) there, the mean pressure."""

    half_width: float
    normal_load: float
    pressure: float


def whole_path(scene: Scene) -> ContactSolution:
    """Half-widths and loads of half-plane theory through the whole path, at the engine's own instants."""
    import semi_analytic

    return semi_analytic.solve(scene, x=[0.0], fields=())


def expected_scales(whole: ContactSolution) -> Expected:
    """The scales of a scene, of its `whole_path`."""
    half_width, load = float(np.nanmax(whole.contact_half_width)), float(np.max(whole.normal_load))
    return Expected(half_width, load, load / (2 * half_width))


def guessed(result: SurfaceResult, mapping: Mapping, whole: ContactSolution) -> tuple[SurfaceResult, tuple[str, ...]]:
    """`result` in the scene's units and our signs, and a sentence for each guess that took.

    What the mapping states is never guessed at. `whole` is the `whole_path` of the scene.

    Raises
    ------
    InputError
        For a pressure that is zero everywhere, or nowhere compression by the sign that the mapping states.
    """
    if not np.any(result.pressure):
        raise InputError(f"{result.source}: the pressure is zero at every point and instant: nothing to score")
    if mapping.signs.pressure is not None and result.pressure.max() <= 0:
        raise InputError(
            f"{result.source}: by signs.pressure = {mapping.signs.pressure!r} of the mapping no point is in compression: state the "
            "other sign, or leave it out"
        )
    scales = expected_scales(whole)
    said: list[str] = []
    for step in (_pressure_sign, _load_sign, _length, _stress, _loads, _middle):
        result, sentence = step(result, mapping, scales)
        said += [sentence] if sentence else []
    return result, tuple(said)


Guess = tuple[SurfaceResult, str]


def _pressure_sign(result: SurfaceResult, mapping: Mapping, _scales: Expected) -> Guess:
    """A pressure that is nowhere above 0 counts compression as negative."""
    if mapping.signs.pressure is not None or result.pressure.max() > TOUCHES * -result.pressure.min():
        return result, ""
    turned = replace(result, pressure=freeze(0.0 - result.pressure))
    return (
        turned,
        'the pressure is negative throughout: compression was taken to be negative (signs.pressure = "compression negative")',
    )


def _load_sign(result: SurfaceResult, _mapping: Mapping, _scales: Expected) -> Guess:
    load = result.normal_load
    if load is None or load.max() > 1e-9 * -load.min():
        return result, ""
    return replace(
        result, normal_load=freeze(0.0 - load)
    ), "the normal load is negative throughout and was turned: here P > 0 presses"


def _length(result: SurfaceResult, mapping: Mapping, scales: Expected) -> Guess:
    if mapping.factors.length is not None:
        return result, ""
    left, right = extent(result)
    own = (right - left) / 2
    factor = _factor(own / scales.half_width) if own > 0 else 1.0
    if factor == 1.0:
        return result, ""
    slip = None if result.slip is None else freeze(result.slip * factor)
    sentence = _sentence("x", factor, "length", f"the contact's half-width is {own:.4g}", f"{scales.half_width:.4g}")
    return replace(result, x=freeze(result.x * factor), slip=slip), sentence


def _stress(result: SurfaceResult, mapping: Mapping, scales: Expected) -> Guess:
    if mapping.factors.stress is not None:
        return result, ""
    own = float(result.pressure.max())
    factor = _factor(own / scales.pressure)
    if factor == 1.0:
        return result, ""
    scaled = replace(result, pressure=freeze(result.pressure * factor), shear=freeze(result.shear * factor))
    words = f"the largest pressure is {own:.4g}", f"at least the mean one, {scales.pressure:.4g},"
    return scaled, _sentence("pressure and shear", factor, "stress", *words)


def _loads(result: SurfaceResult, mapping: Mapping, scales: Expected) -> Guess:
    if mapping.factors.load is not None or result.normal_load is None or not np.any(result.normal_load):
        return result, ""
    own = float(np.max(result.normal_load))
    factor = _factor(own / scales.normal_load)
    if factor == 1.0:
        return result, ""
    tangential = None if result.tangential_load is None else freeze(result.tangential_load * factor)
    scaled = replace(result, normal_load=freeze(result.normal_load * factor), tangential_load=tangential)
    return scaled, _sentence("P and Q", factor, "load", f"the largest P is {own:.4g}", f"{scales.normal_load:.4g}")


def _middle(result: SurfaceResult, mapping: Mapping, scales: Expected) -> Guess:
    """The place of the contact's middle, by the centroid of the pressure, where x is not counted from there."""
    if mapping.x_offset:
        return result, ""
    left, right = extent(result)
    if abs(left + right) / 2 <= OFF_CENTRE * scales.half_width or right - left > 4 * scales.half_width:
        return result, ""
    row = result.pressure[int(np.argmax(result.pressure.max(axis=1)))]
    middle = float(np.trapezoid(row * result.x, result.x) / np.trapezoid(row, result.x))
    sentence = f"x was counted from {middle:.6g}, the centroid of the largest pressure, where the file has it from 0 (x_offset)"
    return replace(result, x=freeze(result.x - middle)), sentence


def _factor(ratio: float) -> float:
    """The factor that brings `ratio` between the limits; 1 where it is there already, or where none does."""
    if LEAST <= ratio <= MOST:
        return 1.0
    return next((factor for factor in FACTORS if LEAST <= ratio * factor <= MOST), 1.0)


def _sentence(what: str, factor: float, key: str, own: str, theirs: str) -> str:
    return f"{what} multiplied by {factor:g}, for {own} and theory has {theirs} (factors.{key} = {factor:g} says it for certain)"


def extent(result: SurfaceResult) -> tuple[float, float]:
    """Leftmost and rightmost x that carries pressure at any instant."""
    touched = result.x[(result.pressure > TOUCHES * result.pressure.max()).any(axis=0)]
    return float(touched[0]), float(touched[-1])


def resultants(result: SurfaceResult) -> tuple[Array, Array]:
    """int p dx and int q dx by the trapezoidal rule, (n_steps,) each [force / thickness]."""
    normal, tangential = (np.asarray(np.trapezoid(field, result.x, axis=1)) for field in (result.pressure, result.shear))
    return normal, tangential


def oddities(result: SurfaceResult, tangential: Array, scene: Scene) -> Iterator[str]:
    """Signs that look wrong and are scored as they are; `tangential` is Q of the scene at the result's instants."""
    if result.pressure.min() < -TOUCHES * result.pressure.max():
        row, column = np.unravel_index(np.argmin(result.pressure), result.pressure.shape)
        yield (
            f"the pressure is tension at some points, down to {result.pressure[row, column]:.4g} at x = {result.x[column]:.4g} "
            f"of instant {row + 1}; it is scored as it is"
        )
    force = resultants(result)[1]
    if float(force @ tangential) < -0.5 * float(np.linalg.norm(force) * np.linalg.norm(tangential)):
        yield (
            "the shear is opposite to Q in the mean: it looks like the shear on the upper body; it is scored as it is "
            '(signs.shear = "on upper" turns it)'
        )
    if result.slip is not None and scene.friction.coefficient and len(result.slip) > 1:
        increments = np.diff(result.slip, axis=0)
        middle = (result.shear[1:] + result.shear[:-1]) / 2
        work, size = float(np.sum(middle * increments)), float(np.sum(np.abs(middle * increments)))
        if work < -0.5 * size:
            yield (
                "the slip goes against the shear, so that friction would feed energy in: it looks like lower over upper; it is "
                'scored as it is (signs.slip = "lower over upper" turns it)'
            )
