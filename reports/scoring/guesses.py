"""What is wrong with a result's units and signs, told from the scales of the scene: each guess is a sentence."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.scoring.history import resultants
from reports.scoring.mapping import Mapping
from reports.scoring.surface import TOUCHES, SurfaceResult
from scenes import ContactSolution, InputError, Scene, freeze

Array = NDArray[np.float64]

# A figure of the result over that of theory may lie between these and be right: a frame near unloading, a coarse mesh, a wrong
# body. They are less than a factor of 1000 apart, so that at most one factor brings a figure between them.
LEAST, MOST = 0.03, 10.0
FACTORS = (1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9)
# Of the half-width: a contact whose middle is farther from x = 0 was measured from elsewhere.
OFF_CENTRE = 0.5


def whole_path(scene: Scene) -> ContactSolution:
    """Half-widths and loads of half-plane theory through the whole path, at the engine's own instants."""
    import semi_analytic

    return semi_analytic.solve(scene, x=[0.0], fields=())


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
    half_width, load = float(np.nanmax(whole.contact_half_width)), float(np.max(whole.normal_load))
    said: list[str] = []
    if mapping.signs.pressure is None and result.pressure.max() <= TOUCHES * -result.pressure.min():
        result = replace(result, pressure=freeze(0.0 - result.pressure))
        said.append(
            'the pressure is negative throughout: compression was taken to be negative (signs.pressure = "compression negative")'
        )
    if result.normal_load is not None and result.normal_load.max() <= 1e-9 * -result.normal_load.min():
        result = replace(result, normal_load=freeze(0.0 - result.normal_load))
        said.append("the normal load is negative throughout and was turned: here P > 0 presses")

    left, right = _extent(result)
    pressure = load / (2 * half_width)  # the mean one at the largest load
    largest = 0.0 if result.normal_load is None else float(np.max(result.normal_load))
    for key, fields, what, own, expected, quantity in (
        ("length", ("x", "slip"), "x", (right - left) / 2, half_width, "the contact's half-width is"),
        ("stress", ("pressure", "shear"), "pressure and shear", float(result.pressure.max()), pressure, "the largest pressure is"),
        ("load", ("normal_load", "tangential_load"), "P and Q", largest, load, "the largest P is"),
    ):
        known = {name: values for name in fields if (values := getattr(result, name)) is not None}
        factor = next((one for one in (1.0, *FACTORS) if LEAST <= own / expected * one <= MOST), 1.0)
        if getattr(mapping.factors, key) is not None or not known or not own or factor == 1.0:
            continue
        scaled: dict[str, Any] = {name: freeze(values * factor) for name, values in known.items()}
        result = replace(result, **scaled)
        theirs = f"at least the mean one, {expected:.4g}," if key == "stress" else f"{expected:.4g}"
        said.append(
            f"{what} multiplied by {factor:g}, for {quantity} {own:.4g} and theory has {theirs} "
            f"(factors.{key} = {factor:g} says it for certain)"
        )

    left, right = _extent(result)
    sides = np.nanmin(whole.contact_edges[:, 0]), np.nanmax(whole.contact_edges[:, 1])
    centre = float(sides[0] + sides[1]) / 2 if whole.tilt is not None else 0.0
    if not mapping.x_offset and abs((left + right) / 2 - centre) > OFF_CENTRE * half_width and right - left <= 4 * half_width:
        row = result.pressure[int(np.argmax(result.pressure.max(axis=1)))]
        middle = float(np.trapezoid(row * result.x, result.x) / np.trapezoid(row, result.x))
        middle -= centre
        result = replace(result, x=freeze(result.x - middle))
        said.append(
            f"x was counted from {middle:.6g}, by the centroid of the largest pressure, where the file has it from 0 (x_offset)"
            if centre
            else f"x was counted from {middle:.6g}, the centroid of the largest pressure, where the file has it from 0 (x_offset)"
        )
    return result, tuple(said)


def _extent(result: SurfaceResult) -> tuple[float, float]:
    """Leftmost and rightmost x that carries pressure at any instant."""
    touched = result.x[(result.pressure > TOUCHES * result.pressure.max()).any(axis=0)]
    return float(touched[0]), float(touched[-1])


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
        work = (result.shear[1:] + result.shear[:-1]) / 2 * np.diff(result.slip, axis=0)
        if float(np.sum(work)) < -0.5 * float(np.sum(np.abs(work))):
            yield (
                "the slip goes against the shear, so that friction would feed energy in: it looks like lower over upper; it is "
                'scored as it is (signs.slip = "lower over upper" turns it)'
            )
