"""The contact at the largest load by half-plane theory: how large against everything else, and what looks like a slip of units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reports.checking import largest_normal_load
from reports.units import load_unit, number, units
from scenes import Block, Cylinder, InputError, Pad, Scene
from scenes.scene import stress_in_pascal

# Beyond these shares linear elasticity and half-planes mean little: hardened steel yields long before p0 = E*/10, and at a slope of
# 0.3 the parabola is 2 % off the circle that it stands for.
_STRAIN, _SLOPE = 0.1, 0.3
# Pa. What is softer than the first and no rubber (by Poisson's ratio) may be in GPa; nothing is stiffer than diamond.
_SOFT, _STEEL, _DIAMOND, _RUBBER = 1e9, 210e9, 1.3e12, 0.45
_RADII = {"radius": "R", "tip_radius": "R", "inner_radius": "R1", "outer_radius": "R2"}
_HALF_LENGTHS = ("flat_half_length", "tip_half_length", "inner_half_length")


@dataclass(frozen=True)
class LargestContact:
    """The contact at the largest normal load of the path, by half-plane theory.

    Attributes
    ----------
    normal_load : P [force per thickness]
    half_width : a [length]
    peak_pressure : p0 [stress]; infinite at the tip of a sharp wedge
    strain : p0/E*; the mean pressure over E* where p0 is infinite
    edge_slope : h'(a), which is a/R for Hertz
    ratios : a over the radii of the profile, its half-length over a, sizes of the bodies over a
    """

    normal_load: float
    half_width: float
    peak_pressure: float
    strain: float
    edge_slope: float
    ratios: dict[str, float]


def largest_contact(scene: Scene, source: str) -> LargestContact:
    """What theory says of the largest load; InputError naming `source` where it can't press the profile together with it.

    That is a table or a function which ends within the contact, or a shape under which the contact would split.
    """
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.profiles import contact_of

    load = largest_normal_load(scene)
    try:
        contact = contact_of(scene.profile, scene.material)
        half = float(contact.half_width(load))
    except InputError as fault:
        raise InputError(f"{source}: half-plane theory refuses it: {fault}") from fault
    # Close points at the edge, where a flat with rounded corners has its peak; then closer ones around the best.
    x = np.union1d(half * np.sin(np.linspace(0, np.pi / 2, 129)), [kink for kink in scene.profile.kinks if kink < half])
    pressure = contact.pressure(x, load)
    best = int(np.argmax(pressure))
    near = np.linspace(x[max(best - 1, 0)], x[min(best + 1, len(x) - 1)], 65)
    peak = max(float(pressure[best]), float(np.max(contact.pressure(near, load))))
    slope = float(np.diff(scene.profile.height(half * np.array([1 - 1e-6, 1 + 1e-6]))).item()) / (2e-6 * half)
    mean = load / (2 * half)
    strain = (peak if np.isfinite(peak) else mean) / composite_modulus(scene.material)
    return LargestContact(load, half, peak, strain, slope, _ratios(scene, half))


def _ratios(scene: Scene, half: float) -> dict[str, float]:
    """By name, such as "a/R" and "lower width/a"."""
    sizes = scene.profile.model_dump(include={*_RADII, *_HALF_LENGTHS})
    found = {f"a/{name}": half / sizes[key] for key, name in _RADII.items() if key in sizes}
    for key in _HALF_LENGTHS:
        if key in sizes:
            found["b/a"] = sizes[key] / half
    for name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper)):
        if isinstance(body, Block | Pad):
            found |= {f"{name} width/a": body.width / half, f"{name} height/a": body.height / half}
        elif isinstance(body, Cylinder):
            found[f"{name} radius/a"] = body.radius / half
    return found


def in_words(scene: Scene, found: LargestContact) -> str:
    """The same as a sentence."""
    _, length, stress = units(scene)
    shares = {**found.ratios, "p0/E*": found.strain} if np.isfinite(found.peak_pressure) else found.ratios
    listed = ", ".join(f"{name} = {value:.4g}" for name, value in shares.items())
    peak = f"{found.peak_pressure:.4g} {stress}" if np.isfinite(found.peak_pressure) else "infinite at the tip"
    return (
        f"At the largest load, P = {number(found.normal_load)} {load_unit(scene)}, half-plane theory gives the half-width "
        f"a = {found.half_width:.4g} {length} and the peak pressure p0 = {peak}: {listed}."
    )


def remarks(scene: Scene, found: LargestContact) -> list[str]:
    """Sentences about numbers that are no fault but look like one; none where all is as usual."""
    said, (force, length, stress) = [], units(scene)
    pascal = stress_in_pascal(stress)
    pair = {"material": scene.material.upper}
    if not scene.material.alike:
        pair = {"material.upper": scene.material.upper, "material.lower": scene.material.lower}
    for key, material in pair.items() if pascal else ():
        modulus, soft = material.young_modulus * pascal, material.poisson_ratio < _RUBBER
        if modulus > _DIAMOND or (modulus < _SOFT and soft):
            stiff = modulus > _DIAMOND
            kind = "stiffer than diamond" if stiff else "as soft as a weak plastic"
            said.append(
                f"{key}.young_modulus = {number(material.young_modulus)} {stress} is {kind}; steel has {number(_STEEL / pascal)} "
                f"{stress}. {'Is the body meant as rigid, or E in Pa?' if stiff else 'Is E in GPa?'}"
            )
    if found.strain > _STRAIN or found.edge_slope > _SLOPE:
        said.append(
            f"Linear elasticity and half-planes mean little here: p0/E* = {found.strain:.3g} (limit {_STRAIN:g}), slope at the "
            f"edge {found.edge_slope:.3g} (limit {_SLOPE:g}). Is E in {stress}? Are the loads {force} per {length} of thickness?"
        )
    return said
