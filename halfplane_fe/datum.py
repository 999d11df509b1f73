"""Normal approach and shift of half-planes counted from another datum; the tractions know nothing of it.

# notation: L distance from a force at which the surface counts as unmoved; P, Q loads; 1/E* = sum of (1 - nu^2)/E
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from halfplane_fe.run import PathRun
from halfplane_fe.scales import contact_modulus
from scenes import HalfPlane, Scene


def from_datum(scene: Scene, run: PathRun, ratio: float) -> PathRun:
    """The run with approach and shift counted from a datum length `ratio` times that of its bodies.

    Each half-plane moves by (2/pi) (1 - nu^2)/E ln(ratio) of P and Q less, as a rigid body; blocks, pads and cylinders stand on
    something and have no datum. The energies of the record stay those of the datum that the run had.
    """
    bodies = ((scene.bodies.lower, scene.material.lower), (scene.bodies.upper, scene.material.upper))
    half_planes = [material for shape, material in bodies if isinstance(shape, HalfPlane)]
    soft = sum((1 - material.poisson_ratio**2) / material.young_modulus for material in half_planes)
    modulus = contact_modulus(scene.material.lower, scene.material.upper)
    by_load = 2 / np.pi * soft * modulus * float(np.log(ratio))
    moved = [
        replace(
            state,
            approach=state.approach + by_load * state.normal_load,
            shift=state.shift + by_load * state.tangential_load,
        )
        for state in run.states
    ]
    return replace(run, states=moved)
