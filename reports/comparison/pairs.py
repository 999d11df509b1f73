"""A reference and a result, the one put on the other's points and instants; the scales that make
their comparison dimensionless, all from the reference; what either is called and states of its own
error; and whether theory is exact for their bodies.

# notation: P_ref load, a_ref half-width, p_ref pressure, f friction, A compliance
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.comparison.cycles import Cycle
from reports.comparison.isolated import masks_of_isolated_values
from reports.units import PythonNumbers
from scenes import (
    BodyEffects,
    ContactSolution,
    EllipseLoad,
    Materials,
    Scene,
    TimeSeriesLoad,
)

if TYPE_CHECKING:
    from semi_analytic import Extremes

Mask = NDArray[np.bool_]

# Instants with less than this share of P_ref are shown and not judged: on its way from or to the
# unloaded state a contact passes through sizes of a few elements and of one, where an error
# relative to its own traction measures the mesh only.
LEAST_JUDGED_SHARE_OF_LOAD = 0.1
# Share of the time from the first row of a record to the second within which two times are one.
_ROUND_OFF_OF_TIME = 1e-9
# Of beta, at most 1/2: rounding of like moduli written with a few digits more or less.
_NEGLIGIBLE_BETA = 1e-9

_NAME_BY_ENGINE = {"semi_analytic": "half-plane theory", "halfplane_fe": "finite elements"}


def engine_in_words(engine: str) -> str:
    """The name of an engine on the page; of another code its own.

    >>> engine_in_words("halfplane_fe"), engine_in_words("somebody's code")
    ('finite elements', "somebody's code")
    """
    return _NAME_BY_ENGINE.get(engine, engine)


def has_coupled_tractions(scene: Scene) -> bool:
    """Whether normal and shear tractions of these materials are coupled: Dundurs' beta is not 0,
    and there is friction.
    """
    if scene.material.alike or not scene.friction.coefficient:
        return False
    from halfplane_fe.dundurs import dundurs

    return abs(dundurs(scene.material).beta) >= _NEGLIGIBLE_BETA


def is_corrected(solution: ContactSolution) -> bool:
    """Whether a solution is theory corrected by the responses of finite bodies."""
    return "effects" in solution.settings


def stated_uncertainty(
    solution: ContactSolution, amount: float, name: str, name_of_error: str
) -> float | None:
    """Uncertainty that a solution itself states of an amount, in the unit of the amount. NaN where
    it has no estimate, 0 where theory is exact; None for an external result, which states nothing.

    Parameters
    ----------
    amount
        value of the solution, such as its largest pressure
    name
        the quantity in `solution.uncertainties` (name -> uncertainty in the unit of the amount)
    name_of_error
        the quantity in `solution.record.errors` of half-plane theory (name -> relative error),
        where `uncertainties` has none; "" where theory is exact
    """
    if name in solution.uncertainties:
        return solution.uncertainties[name]
    if solution.engine == "semi_analytic":
        relative_error = solution.record.errors.get(name_of_error, 0.0)
        return relative_error * abs(amount)
    if solution.engine != "halfplane_fe":
        return None
    if name == "dissipation":
        return solution.dissipation_uncertainty
    return math.nan


def are_half_planes(scene: Scene) -> bool:
    """Whether theory is exact for the bodies of `scene`: half-planes whose normal and shear
    tractions are not coupled.

    Unlike materials couple the two by Dundurs' beta, which theory leaves out: that is an
    idealisation too.
    """
    return scene.bodies.half_planes and not has_coupled_tractions(scene)


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


@dataclass(frozen=True, eq=False)
class Pair:
    """Reference and result of a comparison, the one put on the other's points and instants.

    Attributes
    ----------
    reference, result
        the solution taken as true, and the one that is judged
    polygon_reference
        the reference for loads that run straight from one instant of the result to the next; None
        where it was not solved
    plain_reference
        the reference by its own rules, where `reference` follows those of an external result; else
        the same
    scales
        load, half-width, pressure, ... of the reference, which make the metrics dimensionless
    reference_cycle, result_cycle
        last cycle of each, on the points and instants of the result
    effects
        compliances of finite bodies by which displacements of half-planes are counted from the
        supports; None where that is not needed, or they are not known
    lacks_common_datum
        whether the displacements of the two are counted from different places
    """

    reference: ContactSolution
    result: ContactSolution
    polygon_reference: ContactSolution | None
    plain_reference: ContactSolution
    scales: Scales
    reference_cycle: Cycle
    result_cycle: Cycle
    effects: BodyEffects | None = field(default=None, kw_only=True)
    lacks_common_datum: bool = field(default=False, kw_only=True)

    @cached_property
    def theory_extremes(self) -> Extremes | None:
        """Largest pressure, slip, ... of half-plane theory over the whole surface and cycle, not
        only at the compared points. None where the reference is not theory, or is theory corrected
        by the responses of finite bodies, whose largest values are not searched for.
        """
        import semi_analytic

        if self.plain_reference.engine != "semi_analytic" or is_corrected(self.plain_reference):
            return None
        return semi_analytic.extremes(self.plain_reference)

    @property
    def has_external_result(self) -> bool:
        """Whether the result is no finite-element solution of this project: its points and instants
        are its own choice.
        """
        return self.result.engine != "halfplane_fe"

    @property
    def has_effects(self) -> bool:
        """Whether displacements of half-planes are given with what the bodies add."""
        return self.effects is not None

    @property
    def has_polygon(self) -> bool:
        """Whether the reference on the straight steps of the result is known."""
        return self.polygon_reference is not None

    @cached_property
    def is_in_contact(self) -> Mask:
        """(k,) whether any point carries pressure at an instant, in reference or result. A NaN
        counts as pressure, so that it is not overlooked.
        """
        has_pressure = (self.reference_cycle.pressure != 0) | (self.result_cycle.pressure != 0)
        return has_pressure.any(axis=1)

    @cached_property
    def is_too_light(self) -> Mask:
        """(k,) whether an instant is in contact, but P is less than 0.1 P_ref."""
        is_loaded = (
            self.reference_cycle.normal_load >= LEAST_JUDGED_SHARE_OF_LOAD * self.scales.normal_load
        )
        return self.is_in_contact & ~is_loaded

    @cached_property
    def is_judged(self) -> Mask:
        """(k,) whether a verdict is taken from an instant: in contact, P at least 0.1 P_ref, and
        not before the first row of a measured record. Where its rows start loaded, the path comes
        to them from P = Q = 0 on a straight line, which nobody measured.
        """
        is_judged = self.is_in_contact & ~self.is_too_light
        load = self.result.scene.load
        if isinstance(load, TimeSeriesLoad):
            first_time, second_time = load.kept_rows()[:2, 0].tolist()
            # _ROUND_OFF_OF_TIME: 1e-9 of the time between two rows
            start_time = first_time - _ROUND_OFF_OF_TIME * (second_time - first_time)
            is_judged &= self.result_cycle.time >= start_time
        return is_judged

    @cached_property
    def masks_of_isolated(self) -> dict[str, Mask]:
        """(k, n) of pressure, shear and slip: values of the result that no neighbour supports."""
        return masks_of_isolated_values(self.result_cycle, self.reference_cycle)

    @cached_property
    def is_periodic(self) -> bool:
        """Whether the load path repeats."""
        return self.result.scene.load.path().period is not None

    @cached_property
    def has_bulk_stress(self) -> bool:
        """Whether the scene states a bulk stress."""
        load_record = self.result.scene.load
        return (
            load_record.bulk_stress_lower is not None or load_record.bulk_stress_upper is not None
        )

    @cached_property
    def may_tilt(self) -> bool:
        """Whether the scene states a tilt, a moment or a line of action, or has two unequal
        sides.
        """
        scene = self.result.scene
        stated_tilts = (scene.load.tilt, scene.load.moment, scene.load.line_of_action)
        return any(value is not None for value in stated_tilts) or not scene.profile.symmetric

    @property
    def is_unsymmetric(self) -> bool:
        """Whether the scene states bulk stress, tilt, moment or unequal sides."""
        return self.has_bulk_stress or self.may_tilt

    @property
    def may_drift(self) -> bool:
        """Whether every cycle may differ from the one before: the load path repeats, and the scene
        is unsymmetric.
        """
        return self.is_periodic and self.is_unsymmetric
