"""The scales that make a comparison dimensionless, all from the reference.

# notation: P_ref load, a_ref half-width, p_ref pressure, f friction, A compliance
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reports.python_numbers import PythonNumbers
from scenes import ContactSolution, EllipseLoad, Materials, Scene


@dataclass(frozen=True)
class Scales(PythonNumbers):
    """The quantities by which a comparison is divided."""

    # P_ref, mean load of an ellipse, else the largest load of the last cycle [force / thickness]
    normal_load: float
    half_width: float  # a_ref = a(P_ref) of the reference [length]
    pressure: float  # p_ref = 2 P_ref/(pi a_ref) [stress], the peak of a Hertz contact of that size
    # f, or 1 for a frictionless scene, so that a shear that should not be there still shows
    friction: float
    compliance: float  # A = 2/E* [1/stress]

    @property
    def shear(self) -> float:
        """f p_ref [stress]."""
        return self.friction * self.pressure

    @property
    def displacement(self) -> float:
        """A f P_ref, a typical size of U [length]."""
        return self.compliance * self.friction * self.normal_load

    @property
    def dissipation(self) -> float:
        """A f^2 P_ref^2 [energy / thickness]."""
        return self.compliance * (self.friction * self.normal_load) ** 2

    @property
    def dissipation_density(self) -> float:
        """A f^2 P_ref^2/a_ref [energy / area]."""
        return self.dissipation / self.half_width

    @property
    def slip(self) -> float:
        """f p_ref a_ref/E* [length]."""
        return self.compliance * self.shear * self.half_width / 2

    @property
    def moment(self) -> float:
        """P_ref a_ref [force]."""
        return self.normal_load * self.half_width

    @property
    def tilt(self) -> float:
        """A P_ref/a_ref [rad]."""
        return self.compliance * self.normal_load / self.half_width


def compliance_of_materials(materials: Materials) -> float:
    """A = 2/E*, 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 [1/stress].

    >>> steel = Materials.model_validate({"young_modulus": 210e3, "poisson_ratio": 0.3})
    >>> round(2 / compliance_of_materials(steel), 1)
    115384.6
    """
    return 2 * sum(
        (1 - m.poisson_ratio**2) / m.young_modulus for m in (materials.upper, materials.lower)
    )


def energy_scale(scene: Scene, normal_load: float) -> float:
    """A f^2 P^2, f being 1 for a frictionless scene [energy / thickness]."""
    return (
        compliance_of_materials(scene.material)
        * ((scene.friction.coefficient or 1.0) * normal_load) ** 2
    )


def scales_of_reference(reference: ContactSolution) -> Scales:
    """The scales that make a comparison dimensionless, from the reference solution:

    - P_ref, the mean normal load where P and Q go round an ellipse, else the largest normal load of
      the last cycle;
    - a_ref, the half-width of contact at P_ref, interpolated linearly between the instants;
    - p_ref = 2 P_ref/(pi a_ref), the largest pressure of a Hertz contact of that load and width;
    - f, the friction coefficient, 1 for a frictionless scene;
    - A = 2/E*, the compliance of the materials, E* their contact modulus.
    """
    load_history = reference.scene.load
    if isinstance(load_history, EllipseLoad):  # P and Q go round an ellipse
        reference_load = load_history.mean_normal_load
    else:
        reference_load = float(np.max(reference.normal_load[reference.last_cycle]))
    indices_by_load = np.argsort(reference.normal_load, kind="stable")
    # a at the reference load
    half_width = float(
        np.interp(
            reference_load,
            reference.normal_load[indices_by_load],
            reference.contact_half_width[indices_by_load],
        )
    )
    return Scales(
        normal_load=reference_load,
        half_width=half_width,
        pressure=2 * reference_load / (np.pi * half_width),
        friction=reference.scene.friction.coefficient or 1.0,
        compliance=compliance_of_materials(reference.scene.material),
    )
