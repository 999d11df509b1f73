"""What the inputs of a scene make of its answer: the standard uncertainties stated under
`[uncertainty]`, propagated to half-plane theory's values, and apart to the difference of theory and
finite elements.

A value V(x_1, x_2, ...) moves by c_i for one standard uncertainty of the input i. With the
correlations r_ij of the inputs its standard uncertainty is (GUM 5.2.2; ASME V&V 20, section 4)::

    u^2 = sum over i, j of c_i r_ij c_j

The c_i are central differences, c_i = (V(x_i + u_i) - V(x_i - u_i))/2, the step being one standard
uncertainty. Their error is estimated by the term of the second order, (V(x_i + u_i) + V(x_i - u_i)
- 2 V)/2, which bounds that of the third where such differences mean anything. Where it does not, or
where loads come near gross sliding, W is taken from random draws as well.

Of half-planes under given P and Q four scaling laws are exact, and give most derivatives from those
for Q and the phase. With D_x = x dV/dx, and w, p, l, s exponents of the value::

    unit of stress     D_E + D_P + D_Q = w V       E* in the place of E
    size of the shear  D_f + D_Q = s V
    unit of heights    -D_R + D_P + D_Q = p V      of a parabola x^2/(2 R)
    unit of x          2 D_R = l V                 of a parabola

**The difference** of two models at the same inputs, E = W(corrected)/W(theory) - 1, has an input
term of its own. The inputs are common to both models, so most of what they do cancels::

    c_i(E) = (E(x_i + u_i) - E(x_i - u_i))/2

It is taken from theory corrected by what the bodies add to half-planes
(`halfplane_fe.body_effects`), and is never mixed with the uncertainty of W itself, nor that with
the difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from reports.checking import nearest_to_sliding
from reports.comparison.laws import largest_load_ratio
from reports.comparison.pairs import has_coupled_tractions
from scenes import (
    NORMAL_LOAD,
    Block,
    BodyEffects,
    Compound,
    ConvergenceError,
    Cylinder,
    EllipseLoad,
    Estimate,
    Hertz,
    InadmissibleLoadError,
    Input,
    InputError,
    Pad,
    Scene,
    TimeSeriesLoad,
    sampled_times,
)
from scenes.array_types import Array
from scenes.frozen import validated

WORK = "dissipation"
PEAK = "peak_pressure"
STICK = "permanent_stick"
RATIO = "sliding_ratio"
# Shares of a standard uncertainty by which an input is moved: the first that leaves the loads below
# gross sliding on both sides.
_STEPS_OF_INPUT = (1.0, 0.25, 0.0625)
# Standard uncertainties between the loads and gross sliding, below which draws are taken: beyond,
# fewer than 2 draws in 1,000 slide.
_MOST_SIGMAS_NEAR_SLIDING = 3.0
# The same below which the bodies may slide, at the usual level of 95 %.
_MOST_SIGMAS_IN_REACH = 2.0
# Of the limit of friction: within it the bodies slide already.
_ROUND_OFF_AT_LIMIT = 1e-9
# Of the uncertainty: what the second order may be for derivatives to be enough.
_LARGEST_SHARE_OF_SECOND_ORDER = 0.1
# Share of P or Q by which it is moved where no uncertainty of it is stated, but that of an input
# whose derivative follows from it.
_RELATIVE_STEP_OF_LOAD = 0.01
N_DRAWS = 100_000
# Where each draw is a solve of its own, or has a profile of its own shape.
N_FEW_DRAWS = 200
_SEED = 20_2009  # of V&V 20-2009: any number, but the same in each run
# Rows of a record above which slip and edge tension, which are searched for, are left out.
_MOST_ROWS_FOR_SEARCH = 500

_ValueByName = dict[str, float]


class TheoryQuantity(NamedTuple):
    """A value of theory: its name in words, the kind of its unit, and its exponents in the scaling
    laws.
    """

    words: str
    unit: str
    stress_exponent: int
    shear_exponent: int
    height_exponent: int
    length_exponent: int


QUANTITIES_OF_THEORY = {
    WORK: TheoryQuantity("dissipation W", "energy", 1, 2, 2, 0),
    PEAK: TheoryQuantity("largest pressure", "stress", 1, 0, 1, -1),
    "half_width": TheoryQuantity("largest contact half-width", "length", 0, 0, 0, 1),
    "permanent_stick": TheoryQuantity("permanent stick half-width", "length", 0, 0, 0, 1),
    "slip": TheoryQuantity("largest slip", "length", 0, 1, 1, 0),
    "edge_tension": TheoryQuantity("largest edge tension", "stress", 1, 1, 1, -1),
}
"""Of the last cycle, or of the whole path where nothing repeats."""
QUANTITIES_UNDER_DISPLACEMENT = {
    WORK: QUANTITIES_OF_THEORY[WORK],
    PEAK: QUANTITIES_OF_THEORY[PEAK],
    "half_width": QUANTITIES_OF_THEORY["half_width"],
    "permanent_stick": QUANTITIES_OF_THEORY["permanent_stick"],
    "largest_tangential_load": TheoryQuantity("largest tangential load", "load", 1, 1, 1, 0),
    RATIO: TheoryQuantity("largest |Q|/(f P)", "ratio", 0, 0, 0, 0),
}
"""Where a displacement is prescribed instead of Q."""


@dataclass(frozen=True)
class UncertainValue:
    """A value of theory or a difference, and the uncertainty that the inputs give it.

    Attributes
    ----------
    words, unit
        what it is, and the kind of its unit; "share" of a difference
    value
        at the inputs as stated; NaN where it has none
    changes
        key of an input -> change of the value for one standard uncertainty, with its error
    second_order
        root of the summed squares of the second-order changes by each input
    uncertainty
        standard uncertainty, correlations counted; NaN where a change is not known
    """

    words: str
    unit: str
    value: float
    changes: Mapping[str, Estimate]
    second_order: float
    uncertainty: float

    @property
    def relative_uncertainty(self) -> float:
        """Standard uncertainty over |value|; NaN where that is 0."""
        return self.uncertainty / abs(self.value) if self.value else math.nan

    @property
    def is_nearly_linear(self) -> bool:
        """Whether derivatives are enough: the second order is at most a tenth of the
        uncertainty.
        """
        return self.second_order <= _LARGEST_SHARE_OF_SECOND_ORDER * self.uncertainty

    @property
    def keys_by_size_of_change(self) -> list[str]:
        """Keys of the inputs that change the value, that with the largest change first."""
        sizes = {key: abs(change.value) for key, change in self.changes.items()}
        moving_keys = [key for key, size in sizes.items() if size > 0]
        return sorted(moving_keys, key=lambda key: -sizes[key])


class NearSliding(NamedTuple):
    """How near the loads come to gross sliding, and how sure that is.

    Attributes
    ----------
    ratio
        largest |Q|/(f P); of the last cycle where a displacement is prescribed
    uncertainty
        standard uncertainty of it by the inputs, towards sliding
    """

    ratio: float
    uncertainty: float

    @property
    def sigmas_to_sliding(self) -> float:
        """Standard uncertainties from the ratio up to 1, negative beyond it; infinite where no
        input moves the ratio.
        """
        return (1 - self.ratio) / self.uncertainty if self.uncertainty > 0 else math.inf

    @property
    def is_in_reach(self) -> bool:
        """Whether bodies that do not slide may do so within two standard uncertainties."""
        return (
            self.ratio < 1 - _ROUND_OFF_AT_LIMIT and self.sigmas_to_sliding <= _MOST_SIGMAS_IN_REACH
        )


class DrawStatistics(NamedTuple):
    """A value over the draws that have one: its mean, standard deviation, and between which 95 % of
    them lie (`low`, `high`). All NaN where fewer than two draws have one.
    """

    mean: float
    uncertainty: float
    low: float
    high: float

    @property
    def relative_uncertainty(self) -> float:
        """Standard deviation over the mean; NaN of 0."""
        return self.uncertainty / abs(self.mean) if self.mean else math.nan


@dataclass(frozen=True)
class Draws:
    """Random draws of the inputs, and values of each.

    Attributes
    ----------
    count
        how many were drawn
    sliding
        share of them whose loads slide as a whole: they have no values
    impossible
        share that no scene can have, a negative load for one
    values
        W, and the permanent stick half-width where it is at hand, over the other draws
    reason
        why they were taken
    """

    count: int
    sliding: float
    impossible: float
    values: Mapping[str, DrawStatistics]
    reason: str


@dataclass(frozen=True)
class InputEffects:
    """The uncertainties that the stated uncertainties of the inputs give to a scene's answer.

    Attributes
    ----------
    inputs
        as stated
    correlations
        as stated
    values
        of half-plane theory: what a measurement with these inputs is uncertain by
    difference
        of finite bodies and half-planes, at the same inputs: W and the largest pressure; empty
        where it is not known
    reason_without_difference
        why it is not known, in a sentence; empty where it is
    draws
        of W, where derivatives are not enough and draws do not take too long; else None
    sliding
        how near the loads come to gross sliding; None without friction or where it is not known
    notes
        what is left out, in sentences
    reason_unknown
        why nothing of it is known, in a sentence; empty where `values` has entries
    """

    inputs: tuple[Input, ...]
    correlations: tuple[tuple[str, str, float], ...]
    values: Mapping[str, UncertainValue] = field(default_factory=dict)
    difference: Mapping[str, UncertainValue] = field(default_factory=dict)
    reason_without_difference: str = ""
    draws: Draws | None = None
    sliding: NearSliding | None = None
    notes: tuple[str, ...] = ()
    reason_unknown: str = ""

    @property
    def work_uncertainty(self) -> float:
        """Standard uncertainty of W over W, of the draws where there are any; NaN where it is not
        known.
        """
        if WORK not in self.values:
            return math.nan
        work = self.values[WORK]
        if self.draws is not None and math.isfinite(self.draws.values[WORK].relative_uncertainty):
            return self.draws.values[WORK].relative_uncertainty
        return work.relative_uncertainty


def uncertain_value(
    quantity: TheoryQuantity,
    value: float,
    changes_by_inputs: Sequence[_ChangeByInput],
    name: str,
    correlation: Array,
) -> UncertainValue:
    """A computed value with the standard uncertainty that all n uncertain inputs together give it:
    u^2 = c^T R c, c its changes by one standard uncertainty of each input, R their correlations.
    NaN where a change is not known.

    Parameters
    ----------
    quantity
        its name in words, and the kind of its unit
    value
        the computed value at the stated inputs
    changes_by_inputs
        for each input its `key`, and `changes`: an estimate for each computed value by name. Its
        `value` is the change by one standard uncertainty of the input, its `uncertainty` the change
        of second order
    name
        of the computed value in `changes`
    correlation
        (n, n) correlation matrix of the inputs
    """
    estimates = {
        change_by_input.key: change_by_input.changes[name] for change_by_input in changes_by_inputs
    }
    changes_of_value = np.array([estimate.value for estimate in estimates.values()])
    second_order = math.hypot(*(estimate.uncertainty for estimate in estimates.values()))

    # a correlation of -1 may leave a negative sum of squares by round-off
    variance = max(float(changes_of_value @ correlation @ changes_of_value), 0.0)
    if not np.all(np.isfinite(changes_of_value)):
        variance = math.nan
    return UncertainValue(
        quantity.words, quantity.unit, value, estimates, second_order, math.sqrt(variance)
    )


# ------------------------------------------------------------------------------- one scene's values
def values_of_theory(scene: Scene, effects: BodyEffects | None = None) -> _ValueByName:
    """Half-plane theory's values of the last cycle, or of the whole path where nothing repeats, by
    name: dissipation, largest pressure, largest contact half-width, half-width of permanent stick,
    largest slip and edge tension.

    Long records, and scenes whose bulk stress or tilt needs grids, have dissipation and half-widths
    only: the other values take too long. Under a prescribed displacement (`load.is_driven`) slip
    and edge tension are not among them. The largest |Q| is, and with friction the largest ratio
    |Q|/(f P).

    Parameters
    ----------
    scene
        with or without a prescribed displacement
    effects
        elastic responses that finite bodies add to half-planes, used under a prescribed
        displacement only; None for half-planes

    Raises
    ------
    InputError
        For a scene that theory does not take, such as one with gross sliding.
    """
    import semi_analytic

    if scene.load.is_driven:
        return _values_under_displacement(scene, effects)
    # P and Q are given: only the work and the half-widths follow from the solution itself.
    # WORK, PEAK: "dissipation" and "peak_pressure"
    solution = semi_analytic.solve(scene, x=0.0, fields=(WORK,))
    # pressure, slip and edge tension are found by a search, which takes too long for these scenes
    if _is_long_record(scene) or _needs_grids(scene):
        return {
            WORK: solution.dissipation,
            "half_width": float(np.max(solution.contact_half_width[solution.last_cycle])),
            "permanent_stick": solution.permanent_stick_half_width,
        }
    # Found by a search over all places and instants of the last cycle.
    largest_values = semi_analytic.extremes(solution, names=("slip", "edge_tension"))
    return {
        WORK: solution.dissipation,
        PEAK: largest_values.pressure,
        "half_width": largest_values.half_width,
        "permanent_stick": solution.permanent_stick_half_width,
        "slip": largest_values.slip,
        "edge_tension": largest_values.edge_tension,
    }


def _values_under_displacement(scene: Scene, effects: BodyEffects | None) -> _ValueByName:
    """Theory's values of the last cycle by name where a displacement is prescribed instead of Q:
    dissipation, largest pressure, half-widths, largest |Q|, and with friction the largest ratio
    |Q|/(f P).

    They are the largest among the instants and places x at which the solution is computed; a
    parabola has its largest pressure at x = 0. `effects` are the elastic responses that finite
    bodies add to half-planes, None for half-planes.
    """
    import semi_analytic

    places = 0.0 if isinstance(scene.profile, Hertz) else None  # the default places
    # WORK, PEAK, RATIO: "dissipation", "peak_pressure" and "sliding_ratio"
    solution = semi_analytic.solve(scene, x=places, effects=effects, fields=(WORK, "pressure"))
    # Indices of the solution's instants in the last cycle.
    cycle_indices = solution.last_cycle
    values = {
        WORK: solution.dissipation,
        PEAK: float(solution.pressure[cycle_indices].max()),
        "half_width": float(np.max(solution.contact_half_width[cycle_indices])),
        "permanent_stick": solution.permanent_stick_half_width,
        "largest_tangential_load": float(np.max(np.abs(solution.tangential_load[cycle_indices]))),
    }
    if scene.friction.coefficient:
        values[RATIO] = largest_load_ratio(solution)
    return values


def _is_long_record(scene: Scene) -> bool:
    """Whether the load is a record of more than 500 rows."""
    load_record = scene.load
    return (
        isinstance(load_record, TimeSeriesLoad)
        and len(load_record.kept_rows()) > _MOST_ROWS_FOR_SEARCH
    )


def _needs_grids(scene: Scene) -> bool:
    """Whether bulk stress and tilt leave no one memory curve, so that each solve takes seconds."""
    from semi_analytic.bulk_and_tilt import one_curve

    return scene.unsymmetric and one_curve(scene) is None


class _ChangeByInput(NamedTuple):
    """How much one standard uncertainty of an input (`key`) changes each value, by name, with the
    second order as error.
    """

    key: str
    changes: Mapping[str, Estimate]


def change_by_central_differences(
    values_at: Callable[[Scene], _ValueByName],
    scene: Scene,
    uncertain_input: Input,
    values_at_inputs: _ValueByName,
) -> _ChangeByInput:
    """How much one standard uncertainty of an input changes each value of theory, by central
    differences: the values are computed with the input moved up and down by its standard
    uncertainty.

    Where the moved loads make the bodies slide, a smaller step is tried: a quarter, then a
    sixteenth. The change is scaled to one standard uncertainty.

    Parameters
    ----------
    values_at
        computes the values of a scene
    scene
        as stated
    uncertain_input
        its `key`, and its `standard_uncertainty`: relative, of a phase in degrees
    values_at_inputs
        the values with the input as it is, by name

    Returns
    -------
    _ChangeByInput
        The key of the input and, for each value by name, the change, with the change of second
        order as its uncertainty.

    Raises
    ------
    InadmissibleLoadError
        Where even the smallest step makes the bodies slide.
    InputError
        Where no scene can have the moved input, or theory cannot solve that scene.
    """
    # Steps in standard uncertainties: 1, then 1/4 and 1/16 where the bodies slide.
    for step in _STEPS_OF_INPUT:
        input_change = step * uncertain_input.standard_uncertainty
        try:
            # A scene with this input moved up, and one with it moved down.
            values_above = values_at(scene.moved({uncertain_input.key: input_change}))
            values_below = values_at(scene.moved({uncertain_input.key: -input_change}))
        except InadmissibleLoadError:
            if step == _STEPS_OF_INPUT[-1]:
                raise
            continue
        changes = _changes_by_differences(values_at_inputs, values_above, values_below, step)
        return _ChangeByInput(uncertain_input.key, changes)
    raise AssertionError  # the last step returns or raises


def _changes_by_differences(
    values_at_inputs: _ValueByName,
    values_above: _ValueByName,
    values_below: _ValueByName,
    step: float,
) -> dict[str, Estimate]:
    """The change V' of each value V by one standard uncertainty of an input. It is the central
    difference; its error estimate is the second-order change, |V''|/2.

    Parameters
    ----------
    values_at_inputs, values_above, values_below
        values by name with the input as it is, moved up, and moved down
    step
        by how much the input was moved [standard uncertainties]

    Examples
    --------
    V = x^2 at x = 3, moved by 0.1: V' = 6 and V''/2 = 1.

    >>> change = _changes_by_differences({"V": 9.0}, {"V": 3.1**2}, {"V": 2.9**2}, step=0.1)["V"]
    >>> round(change.value, 9), round(change.uncertainty, 9)
    (6.0, 1.0)
    """
    changes = {}
    for name, value in values_at_inputs.items():
        change = (values_above[name] - values_below[name]) / (2 * step)
        second_order = abs(values_above[name] + values_below[name] - 2 * value) / (2 * step**2)
        # Estimate: a value with its uncertainty
        changes[name] = Estimate(change, second_order)
    return changes


def _change_of_modulus(scene: Scene, uncertain_input: Input) -> float:
    """Relative change of the composite modulus E* by one standard uncertainty of a constant of a
    material: a central difference of E*, divided by E*.

    # notation: 1/E* = (1 − nu_l^2)/E_l + (1 − nu_u^2)/E_u of the lower and the upper body

    `uncertain_input` is that constant, such as Young's modulus: `key` names it, and
    `standard_uncertainty` is relative.
    """
    from semi_analytic.elasticity import composite_modulus

    # `moved` is the scene with the input changed by this amount.
    modulus_above = composite_modulus(
        scene.moved({uncertain_input.key: uncertain_input.standard_uncertainty}).material
    )
    modulus_below = composite_modulus(
        scene.moved({uncertain_input.key: -uncertain_input.standard_uncertainty}).material
    )
    return (modulus_above - modulus_below) / (2 * composite_modulus(scene.material))


# ------------------------------------------------------------------- changes of theory's values
def changes_of_theory(
    scene: Scene, values_at_inputs: _ValueByName, effects_of: Callable[[Scene], BodyEffects | None]
) -> list[_ChangeByInput]:
    """For each uncertain input of a scene, how much one standard uncertainty of it changes theory's
    values (dissipation, largest pressure, ...).

    Where P and Q are given, without bulk stress and tilt on a symmetric profile, exact scaling laws
    give most of the changes, and sizes of bodies other than radii of cylinders change nothing.
    Central differences give all others.

    Parameters
    ----------
    scene
        `load.is_driven`: a displacement is prescribed instead of Q; `unsymmetric`: it has bulk
        stress, tilt or an unsymmetric profile; `inputs`: its uncertain inputs
    values_at_inputs
        theory's values by name at the stated inputs
    effects_of
        takes a scene with a changed input; returns the elastic responses that its finite bodies add
        to half-planes, or None where none count

    Returns
    -------
    list of _ChangeByInput
        For each input its key, and the change of each value by name with its uncertainty.
    """

    def values_at(changed_scene: Scene) -> _ValueByName:
        """Values of a changed scene, by name."""
        return values_of_theory(changed_scene, effects_of(changed_scene))

    have_scaling_laws = not (scene.load.is_driven or scene.unsymmetric)
    if not have_scaling_laws:
        return [
            change_by_central_differences(values_at, scene, uncertain_input, values_at_inputs)
            for uncertain_input in scene.inputs
        ]
    # The scaling laws of this scene: they give x dV/dx of each value V for an input x.
    laws = _ScalingLaws(scene, values_at_inputs, values_at)
    return [
        _change_by_laws(laws, scene, uncertain_input, values_at_inputs, values_at)
        for uncertain_input in scene.inputs
    ]


def _change_by_laws(
    laws: _ScalingLaws,
    scene: Scene,
    uncertain_input: Input,
    values_at_inputs: _ValueByName,
    values_at: Callable[[Scene], _ValueByName],
) -> _ChangeByInput:
    """How much one standard uncertainty of an input changes each value of half-plane theory: by a
    scaling law where there is one for its key, else by central differences. The changes by a size
    of a body are 0, but for a radius.

    Parameters
    ----------
    laws
        the scaling laws of this scene, which give x dV/dx of every value V for an input x
    scene
        as stated; a `Hertz` profile is a parabola
    uncertain_input
        the input: its key, such as "material.young_modulus", and its standard uncertainty, relative
        to the input (of a phase: in degrees)
    values_at_inputs
        the values by name with the input as it is
    values_at
        computes the values of a scene

    Returns
    -------
    _ChangeByInput
        The key and the change of each value by name, with its uncertainty.
    """
    key = uncertain_input.key
    standard_uncertainty = uncertain_input.standard_uncertainty
    if key.startswith("bodies.") and not key.endswith(".radius"):
        # half-plane theory has no size of a body; a radius belongs to the profile
        # Estimate: a value with its uncertainty, here 0
        return _ChangeByInput(key, dict.fromkeys(values_at_inputs, Estimate(0.0)))
    if key == "friction":
        return laws.change_by_input(key, standard_uncertainty, laws.derivative_by_friction())
    if key.startswith("material."):
        # Relative change of E* by this constant of a material.
        modulus_change = _change_of_modulus(scene, uncertain_input)
        return laws.change_by_input(key, modulus_change, laws.derivative_by_modulus())
    is_parabola = isinstance(scene.profile, Hertz)
    if key == "profile.radius" and is_parabola:
        return laws.change_by_input(key, standard_uncertainty, laws.derivative_by_radius())
    if key == "normal_load" and is_parabola:
        return laws.change_by_input(key, standard_uncertainty, laws.derivative_by_normal_load())
    if key in ("normal_load", "tangential_load"):
        return laws.change_by_load(key)  # central differences, taken once
    return change_by_central_differences(values_at, scene, uncertain_input, values_at_inputs)


class _ScalingLaws:
    """D_x = x dV/dx of half-plane theory by its scaling laws, from D_Q, and D_P of other profiles
    than a parabola, which are central differences taken once.
    """

    def __init__(
        self,
        scene: Scene,
        values_at_inputs: _ValueByName,
        values_at: Callable[[Scene], _ValueByName],
    ) -> None:
        self.scene = scene
        self.values_at_inputs = values_at_inputs
        self.values_at = values_at
        self._changes_by_loads: dict[str, _ChangeByInput] = {}
        self._derivatives: dict[str, _ValueByName] = {}

    def change_by_input(
        self, key: str, relative_uncertainty: float, derivatives: _ValueByName
    ) -> _ChangeByInput:
        """The change of each value V by one standard uncertainty of the input x called `key`:
        u x dV/dx, u being the `relative_uncertainty` of x.

        Its uncertainty is the change of second order, u^2 x^2 V''/2, for a power law V = c x^n.
        With the change u n V this is change (change - u V)/(2 V); 0 where V is 0.

        Parameters
        ----------
        derivatives
            x dV/dx by name of the value
        """
        changes = {}
        # `values_at_inputs`: each value V at the stated inputs, by name.
        for name, derivative in derivatives.items():
            value = self.values_at_inputs[name]
            change = relative_uncertainty * derivative
            second_order = 0.0
            if value:
                second_order = abs(change * (change - relative_uncertainty * value) / (2 * value))
            # Estimate: a value with its uncertainty
            changes[name] = Estimate(change, second_order)
        return _ChangeByInput(key, changes)

    def derivative_by_tangential_load(self) -> _ValueByName:
        """x dV/dx of every value V for the tangential load x, by central differences."""
        return self.derivative_by_load("tangential_load")

    def derivative_by_normal_load(self) -> _ValueByName:
        """x dV/dx of every value V for the normal load x = P: of a parabola by the scaling law of
        heights, of other profiles by central differences.

        Under that law V goes as c^n if P, Q and all heights of the profile are multiplied by c,
        that is if its radius R is divided by c. So D_P + D_Q − D_R = n V, with D_x = x dV/dx.
        """
        if not isinstance(self.scene.profile, Hertz):
            return self.derivative_by_load("normal_load")
        # n V of each value V
        terms_by_height = self._values_times_exponent("height_exponent")
        derivatives_by_radius = self.derivative_by_radius()
        derivatives_by_q = self.derivative_by_tangential_load()
        return {
            name: terms_by_height[name] + derivatives_by_radius[name] - derivatives_by_q[name]
            for name in self.values_at_inputs
        }

    def derivative_by_radius(self) -> _ValueByName:
        """x dV/dx of every value V for the radius x = R of a parabola, by the scaling law of
        lengths.

        Under that law V goes as c^n if all lengths along the surface are multiplied by c, under the
        same loads and heights. R is then multiplied by c^2, so that 2 R dV/dR = n V.
        """
        # n V of each value V
        terms_by_length = self._values_times_exponent("length_exponent")
        return {name: term / 2 for name, term in terms_by_length.items()}

    def derivative_by_friction(self) -> _ValueByName:
        """x dV/dx of every value V for the coefficient of friction x = f, by the scaling law of
        shear.

        Under that law V goes as c^n if f and Q are multiplied by c. So D_f + D_Q = n V, with
        D_x = x dV/dx.
        """
        # n V of each value V
        terms_by_shear = self._values_times_exponent("shear_exponent")
        derivatives_by_q = self.derivative_by_tangential_load()
        return {
            name: terms_by_shear[name] - derivatives_by_q[name] for name in self.values_at_inputs
        }

    def derivative_by_modulus(self) -> _ValueByName:
        """x dV/dx of every value V for the composite modulus x = E*, by the scaling law of
        stresses.

        Under that law V goes as c^n if E*, P and Q are multiplied by c. So D_E + D_P + D_Q = n V,
        with D_x = x dV/dx.
        """
        # n V of each value V
        terms_by_stress = self._values_times_exponent("stress_exponent")
        derivatives_by_p = self.derivative_by_normal_load()
        derivatives_by_q = self.derivative_by_tangential_load()
        return {
            name: terms_by_stress[name] - derivatives_by_p[name] - derivatives_by_q[name]
            for name in self.values_at_inputs
        }

    def _values_times_exponent(self, exponent_name: str) -> _ValueByName:
        """Exponent of each value V in a scaling law, times V: x dV/dx where the law's factor is x.
        `exponent_name` is the attribute of a `TheoryQuantity` that holds the exponent.
        """
        return {
            name: getattr(QUANTITIES_OF_THEORY[name], exponent_name) * value
            for name, value in self.values_at_inputs.items()
        }

    def change_by_load(self, key: str) -> _ChangeByInput:
        """The change of each value by one standard uncertainty of the load P or Q, found by central
        differences once and cached. `key` is "normal_load" or "tangential_load".

        Where the scene states no uncertainty of this load, the change is by 1 % of the load. The
        derivative x dV/dx of each value V by the load x is cached too.
        """
        # Both caches are by the key of the load.
        if key not in self._changes_by_loads:
            # An input with a relative standard uncertainty of 1 %, unless the scene states another.
            # _RELATIVE_STEP_OF_LOAD: 0.01
            uncertain_load = Input(key, "", "", None, _RELATIVE_STEP_OF_LOAD)
            for stated_input in self.scene.inputs:
                if stated_input.key == key:
                    uncertain_load = stated_input
            changes_of_values = change_by_central_differences(
                self.values_at, self.scene, uncertain_load, self.values_at_inputs
            )
            self._changes_by_loads[key] = changes_of_values
            self._derivatives[key] = {
                name: change.value / uncertain_load.standard_uncertainty
                for name, change in changes_of_values.changes.items()
            }
        return self._changes_by_loads[key]

    def derivative_by_load(self, key: str) -> _ValueByName:
        """x dV/dx of every value V for the load x, P or Q as `key` says, by central differences."""
        self.change_by_load(key)
        return self._derivatives[key]


# --------------------------------------------------------------------------------- the difference
def with_blocks(scene: Scene) -> Scene:
    """The scene with each pad replaced by a block of its size, where a displacement is prescribed:
    the profile then is the gap between flat faces. Else the scene itself.

    The extra compliance of the pads' arcs is left out, which hardly matters for changes of the
    dissipation W. With 5 % more friction W changes by -5.37 % for blocks by theory. It changes by
    -5.38 % by finite elements for a pad whose contact half-width is 0.014 of its radius.
    """
    # `is_driven`: a displacement is prescribed instead of Q.
    if not scene.load.is_driven:
        return scene
    # Bodies to be replaced, by name: each a block with all keys of the pad but "kind".
    blocks = {}
    for body_name in ("lower", "upper"):
        body = getattr(scene.bodies, body_name)
        if isinstance(body, Pad):
            blocks[body_name] = Block(**body.model_dump(exclude={"kind"}))
    return scene.vary(bodies=blocks) if blocks else scene


_BLOCKS_FOR_PADS = (
    "under a prescribed displacement pads are taken as blocks of their size here: what their arcs"
    " add is not in it"
)


def _reason_without_values(scene: Scene) -> str:
    """Why the effect of uncertain inputs cannot be computed for a scene, and what to do instead; ""
    where it can.

    It cannot where a displacement is prescribed (`load.is_driven`) and a face is modelled with its
    curve (`bodies.faces_are_true`): theory has the elastic responses of bodies with flat faces
    only.
    """
    if not (scene.load.is_driven and scene.bodies.faces_are_true):
        return ""
    # `_curved_kind`: the kind of the body whose face is curved, such as "pad"
    return (
        "under a prescribed displacement theory needs what the bodies add to half-planes, which is"
        f" known of flat faces, and that of a {_curved_kind(scene)} is curved. `halfplane sweep`"
        ' with engines = ["fe"], over an input moved by its uncertainty up and down, shows what it'
        " makes"
    )


def _curved_kind(scene: Scene) -> str:
    """Kind of the body with a curved face, in words."""
    bodies = (scene.bodies.upper, scene.bodies.lower)
    kinds = [body.kind for body in bodies if body.kind not in ("half_plane", "block", "t_shape")]
    return kinds[0].replace("_", " ")


def omissions_in_words(scene: Scene) -> str:
    """A sentence that warns, before a run, which effects of the uncertain inputs its report will
    not state, and why; "" where there is nothing to warn of.

    It is empty where the report will state all, without uncertain inputs, and for half-planes, for
    which theory has no error. Under a prescribed displacement no difference of the two models is
    expected, so that its absence gives no sentence.
    """
    if not scene.inputs or scene.bodies.half_planes:
        return ""
    # Under a prescribed displacement pads are taken as blocks; else the scene itself.
    solved_scene = with_blocks(scene)
    if reason_without_values := _reason_without_values(solved_scene):
        return f"What the inputs make of the answer will not be known: {reason_without_values}."
    if solved_scene is not scene:  # the warning then is that pads are taken as blocks
        # _BLOCKS_FOR_PADS: sentence part that pads are taken as blocks
        return f"What the inputs make of the answer: {_BLOCKS_FOR_PADS}."
    if scene.load.is_driven:
        return ""
    reason_without_difference = _reason_without_difference(scene)
    if not reason_without_difference:
        return ""
    return (
        "How far the inputs move the difference of the two models will not be stated, a"
        f" measurement's uncertainty will: {reason_without_difference.rstrip('.')}."
    )


def _reason_without_difference(scene: Scene) -> str:
    """Why the effect of the inputs on theory's error (finite bodies/half-planes − 1) cannot be
    computed, in words; "" where it can.

    `load.is_driven`: a displacement is prescribed instead of Q. `bodies.half_planes`: both
    bodies are half-planes. `bodies.faces_are_true`: a face is modelled with its curve.
    """
    if scene.load.is_driven:
        return (
            "under a prescribed displacement each engine finds loads of its own, and nothing is"
            " compared"
        )
    if scene.bodies.half_planes:
        return "both bodies are half-planes, for which theory is exact whatever the inputs are"
    if has_coupled_tractions(scene):
        return (
            "the materials are unlike (Dundurs' beta is not 0), and corrected theory does not"
            " follow that"
        )
    if scene.bodies.faces_are_true:
        return (
            "what the bodies add to half-planes is known of flat faces, and that of a"
            f" {_curved_kind(scene)} is curved. `halfplane sweep` of error.dissipation over an"
            " input, moved by its uncertainty up and down, shows it"
        )
    return ""


def changes_of_difference(
    scene: Scene, effects: BodyEffects
) -> tuple[_ValueByName, list[_ChangeByInput]]:
    """The difference of two models, finite bodies/half-planes − 1, in the work W and in the largest
    pressure; and how much one standard uncertainty of each uncertain input changes it.

    Both models get the changed input. Finite bodies are half-planes corrected by `effects`, the
    elastic responses that these bodies add.

    Returns
    -------
    tuple of dict and list
        The differences by name; then for each input its key, and the change of each difference by
        name with its uncertainty.

    Raises
    ------
    InputError
        Where the elastic responses of changed bodies cannot be computed, or changed loads slide.
    """
    import halfplane_fe

    # Whether W follows from the quick formula for elliptical load paths, not from a solution.
    by_quick_formula = quick_formula_holds(scene, effects)

    def values_at(changed_scene: Scene) -> _ValueByName:
        """Differences of the two models for a changed scene, by name."""
        # Elastic responses depend on the bodies and their materials alone.
        changed_effects = effects
        if changed_scene.bodies != scene.bodies or changed_scene.material != scene.material:
            changed_effects = halfplane_fe.body_effects(changed_scene)
        return difference_at(changed_scene, changed_effects, by_quick_formula=by_quick_formula)

    differences = difference_at(scene, effects, by_quick_formula=by_quick_formula)

    # Young's modulus by the scaling law, all else by central differences.
    law_of_modulus = _LawOfModulus(scene, differences, values_at)
    changes_by_inputs = []
    for uncertain_input in scene.inputs:
        if uncertain_input.key == "material.young_modulus":
            changes_by_inputs.append(law_of_modulus.change_by_modulus(uncertain_input))
        elif uncertain_input.key in ("normal_load", "tangential_load"):
            changes_by_inputs.append(law_of_modulus.change_by_load(uncertain_input.key))
        else:
            changes_by_inputs.append(
                change_by_central_differences(values_at, scene, uncertain_input, differences)
            )
    return differences, changes_by_inputs


class _LawOfModulus:
    """The scaling law D_E + D_P + D_Q = 0, with D_x = x dV/dx, of a difference V of finite bodies
    from half-planes. V has no unit, and all compliances go as 1/E, so V depends on P/E and Q/E.
    """

    def __init__(
        self,
        scene: Scene,
        values_at_inputs: _ValueByName,
        values_at: Callable[[Scene], _ValueByName],
    ) -> None:
        self.laws_of_loads = _ScalingLaws(scene, values_at_inputs, values_at)

    def change_by_load(self, key: str) -> _ChangeByInput:
        """The change of each difference by one standard uncertainty of P or Q, as `key` says."""
        return self.laws_of_loads.change_by_load(key)

    def change_by_modulus(self, modulus: Input) -> _ChangeByInput:
        """The change of each difference V of finite bodies from half-planes by one standard
        uncertainty of Young's modulus E, relative and the same for both bodies.

        V depends on P/E and Q/E alone, so that D_E = -(D_P + D_Q) with D_x = x dV/dx. D_P and D_Q
        are central differences. `modulus` is the uncertain input: its key and relative standard
        uncertainty.
        """
        # x dV/dx of every difference V for x = P, then for x = Q, by name.
        derivatives_by_p = self.laws_of_loads.derivative_by_load("normal_load")
        derivatives_by_q = self.laws_of_loads.derivative_by_load("tangential_load")
        relative_uncertainty = modulus.standard_uncertainty
        changes = {}
        for name in derivatives_by_p:
            change = -relative_uncertainty * (derivatives_by_p[name] + derivatives_by_q[name])
            # V is nearly linear in 1/E, whose change of second order is u times that of first
            # order, u being the relative uncertainty.
            # Estimate: a value with its uncertainty
            changes[name] = Estimate(change, abs(change) * relative_uncertainty)
        return _ChangeByInput(modulus.key, changes)


def quick_formula_holds(scene: Scene, effects: BodyEffects) -> bool:
    """Whether the quick formula for W (`semi_analytic.dissipation`) holds for both models, at the
    scene's inputs and at changed inputs.

    It holds for elliptical load paths without bulk stress and tilt, on a symmetric profile. No size
    of a body may be uncertain, and by `effects`, the elastic responses, faces neither tilt nor
    stretch.
    """
    from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES

    # Tilt and strain of the faces, which loads on finite bodies may cause.
    # TILT_AND_STRAIN_NAMES: names of the responses by which faces tilt and stretch
    faces_tilt_or_stretch = any(getattr(effects, name).value for name in TILT_AND_STRAIN_NAMES)
    has_uncertain_body = any(
        uncertain_input.key.startswith("bodies.") for uncertain_input in scene.inputs
    )
    is_ellipse = isinstance(scene.load, EllipseLoad) and not scene.unsymmetric
    return is_ellipse and not has_uncertain_body and not faces_tilt_or_stretch


def difference_at(scene: Scene, effects: BodyEffects, *, by_quick_formula: bool) -> _ValueByName:
    """The difference finite bodies/half-planes − 1 of the work W and of the largest pressure, by
    name; NaN where it is not known. Both come from theory, that of finite bodies with `effects`,
    the elastic responses that they add.

    Parameters
    ----------
    scene
        with finite bodies
    effects
        elastic responses that these add to half-planes
    by_quick_formula
        True: W by the quick formula for elliptical load paths, in a fifth of the time, from the
        curvatures that loads give the faces. False: W by a solution, with tilt and strain of the
        faces too
    """
    # WORK, PEAK: "dissipation" and "peak_pressure"
    return {
        WORK: _difference_of_work(scene, effects, by_quick_formula),
        PEAK: _difference_of_peak(scene, effects),
    }


def _difference_of_work(scene: Scene, effects: BodyEffects, by_quick_formula: bool) -> float:
    """W of finite bodies/W of half-planes − 1; NaN where nothing is dissipated."""
    compute_works = _works_by_quick_formula if by_quick_formula else _works_by_solving
    work_of_half_planes, work_of_bodies = compute_works(scene, effects)
    if not work_of_half_planes:
        return math.nan
    return work_of_bodies / work_of_half_planes - 1


def _works_by_quick_formula(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """Friction work W of a cycle for half-planes, then for finite bodies with elastic responses
    `effects`, by the quick formula for elliptical load paths.

    Raises
    ------
    InputError
        Where the loads have no W, such as under gross sliding.
    """
    import semi_analytic

    load_ellipse = scene.load
    assert isinstance(load_ellipse, EllipseLoad)  # for the type checker: see `quick_formula_holds`

    def work_with_effects(body_effects: BodyEffects | None) -> float:
        """Friction work W of a cycle with the elastic responses `body_effects` that finite bodies
        add to half-planes; that of half-planes for None. NaN where the loads have none.
        """
        batch = semi_analytic.dissipation(
            profile=scene.profile,
            material=scene.material,
            friction_coefficient=scene.friction.coefficient,
            mean_normal_load=load_ellipse.mean_normal_load,
            normal_amplitude=load_ellipse.normal_amplitude,
            mean_tangential_load=load_ellipse.mean_tangential_load,
            tangential_amplitude=load_ellipse.tangential_amplitude,
            phase_degrees=load_ellipse.phase_degrees,
            effects=body_effects,
        )
        # `value`: the dissipation W
        return float(batch.value)

    work_of_half_planes = work_with_effects(None)
    if math.isnan(work_of_half_planes):
        # WORK: "dissipation"
        semi_analytic.solve(scene, x=0.0, fields=(WORK,))  # raises the sentence that says why
    return work_of_half_planes, work_with_effects(effects)


def _works_by_solving(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """Friction work W of a cycle for half-planes and for finite bodies, each by a solution of
    theory.
    """
    import semi_analytic

    solution_of_half_planes = semi_analytic.solve(scene, x=0.0, fields=(WORK,))
    solution_of_bodies = semi_analytic.solve(scene, x=0.0, effects=effects, fields=(WORK,))
    return solution_of_half_planes.dissipation, solution_of_bodies.dissipation


def _difference_of_peak(scene: Scene, effects: BodyEffects) -> float:
    """Largest pressure of finite bodies over that of half-planes, minus 1, for a parabola; NaN for
    other profiles.

    By theory the largest pressure is p0 = sqrt(P E* (1/R + N P + N_Q Q)/pi), E* the composite
    modulus, R the radius of the parabola, N and N_Q the curvatures of the bodies' faces per normal
    and tangential load.
    `effects` are the elastic responses that finite bodies add to half-planes: N is
    `normal_curvature`, N_Q `normal_curvature_under_shear`.
    """
    profile = scene.profile
    if not isinstance(profile, Hertz):
        return math.nan
    normal_load, tangential_load = _loads_of_last_cycle(scene)
    added_curvature = effects.normal_curvature.value * normal_load
    added_curvature = added_curvature + effects.normal_curvature_under_shear.value * tangential_load
    # But for a common factor, the squared largest pressure of finite bodies at each instant.
    pressure_squared = normal_load * (1 + profile.radius * added_curvature)
    return math.sqrt(float(np.max(pressure_squared) / np.max(normal_load))) - 1


def _loads_of_last_cycle(scene: Scene) -> tuple[Array, Array]:
    """Normal and tangential loads P and Q, (n,) each, of the last cycle, or of the whole path where
    nothing repeats: at the rows of a record, else at the turning points of P and at samples between
    them.
    """
    if isinstance(scene.load, TimeSeriesLoad):
        rows = scene.load.series()  # (n, 3) time, P, Q
        return rows[:, 1], rows[:, 2]
    # Load segments of the cycle, or of the path where nothing repeats.
    path = scene.load.path()
    loads_of_segments = []
    for segment in path.cycle or path.initial_loading:
        # Times at which P turns, and 129 or more along the segment (of a straight one, its ends).
        # NORMAL_LOAD: P alone, as a combination of both loads
        times = np.union1d(sampled_times(segment, 129), segment.turning_points(NORMAL_LOAD))
        loads_of_segments.append(np.array(segment.loads(times)))
    normal_load, tangential_load = np.concatenate(loads_of_segments, axis=1)
    return normal_load, tangential_load


# ------------------------------------------------------------------------------------------- draws
def draws_of_work(scene: Scene, reason: str) -> Draws | None:
    """Mean, spread and 95 % range of the friction work W, and of the permanent stick half-width
    where it is known, over random draws of the inputs; with the fractions of draws that slide as a
    whole, and that no scene can have.

    The draws are from normal distributions with the stated correlations, the same in each run. None
    where a draw takes too long: long records, prescribed displacements (`load.is_driven`), bulk
    stress, tilt and unsymmetric profiles (`unsymmetric`). `reason` says why draws are needed.
    """
    if scene.load.is_driven or scene.unsymmetric or _is_long_record(scene):
        return None
    is_ellipse = isinstance(scene.load, EllipseLoad)
    has_uncertain_compound_profile = isinstance(scene.profile, Compound) and any(
        uncertain_input.key.startswith("profile.") for uncertain_input in scene.inputs
    )
    # N_DRAWS = 100,000 draws, or N_FEW_DRAWS = 200 where a draw takes longer: of loads other than
    # ellipses, which are solved one by one, and of changed profiles of several parts.
    n_draws = N_DRAWS if is_ellipse and not has_uncertain_compound_profile else N_FEW_DRAWS
    drawn_changes = drawn_changes_of(scene, n_draws)
    compute_values = values_of_ellipses if is_ellipse else values_one_by_one

    # W and more by name, (n_draws,) each; and which draws slide, (n_draws,).
    values, is_sliding = compute_values(scene, drawn_changes)
    # Fractions of the draws; WORK is "dissipation".
    sliding_share = float(np.mean(is_sliding))
    return Draws(
        count=n_draws,
        sliding=sliding_share,
        impossible=float(np.mean(~np.isfinite(values[WORK]))) - sliding_share,
        values={name: _statistics_of(drawn_values) for name, drawn_values in values.items()},
        reason=reason,
    )


def _statistics_of(values: Array) -> DrawStatistics:
    """Mean, deviation and 95 % range of the values of random draws (n,); those without a value
    (NaN) are left out.
    """
    known_values = values[np.isfinite(values)]
    if len(known_values) < 2:
        return DrawStatistics(math.nan, math.nan, math.nan, math.nan)
    lower_bound, upper_bound = np.quantile(known_values, (0.025, 0.975)).tolist()
    return DrawStatistics(
        float(known_values.mean()), float(known_values.std(ddof=1)), lower_bound, upper_bound
    )


def drawn_changes_of(scene: Scene, n_draws: int) -> dict[str, Array]:
    """Random changes of each uncertain input in `n_draws` draws, (n_draws,) by its key: relative to
    its value, those of a phase in degrees. They have normal distributions with the stated standard
    uncertainties and correlations.

    The correlation matrix is R = V D V^T, with its eigenvectors in V and its eigenvalues in the
    diagonal matrix D. Then V sqrt(D) z has these correlations, z being independent normal numbers
    of variance 1.
    """
    assert scene.uncertainty is not None  # there are inputs
    eigenvalues, eigenvectors = np.linalg.eigh(scene.uncertainty.correlation_matrix())
    # round-off can make an eigenvalue of 0 negative
    root_of_correlation = eigenvectors * np.sqrt(np.maximum(eigenvalues, 0.0))
    shape = (len(scene.inputs), n_draws)
    # _SEED: of the random numbers, the same in each run
    independent_normals = np.random.default_rng(_SEED).standard_normal(shape)
    correlated_normals = root_of_correlation @ independent_normals

    # Each input's normal numbers of variance 1, scaled to its standard uncertainty.
    return {
        uncertain_input.key: uncertain_input.standard_uncertainty * normals
        for uncertain_input, normals in zip(scene.inputs, correlated_normals, strict=True)
    }


def values_of_ellipses(
    scene: Scene, drawn_changes: Mapping[str, Array]
) -> tuple[dict[str, Array], Array]:
    """The dissipation W, and where known the permanent stick half-width, for n random draws of the
    inputs under an elliptical load path, computed all at once.

    One modulus E*_0 serves all draws: W(E*, P, Q) = r W(E*_0, P/r, Q/r) with r = E*/E*_0.
    Half-widths under these loads are the same. The half-width is known where the profile is a
    parabola or is not changed.

    Parameters
    ----------
    drawn_changes
        change of each input, (n,) by its key: relative, of a phase in degrees

    Returns
    -------
    tuple of dict and array
        Values by name, (n,) each, NaN where a draw has none; and which draws slide over the whole
        contact, (n,).
    """
    import semi_analytic
    from semi_analytic.elasticity import composite_modulus

    # r = E*/E*_0 of each draw
    modulus_factor = np.ones(len(next(iter(drawn_changes.values()))))
    if any(key.startswith("material.") for key in drawn_changes):
        modulus_factor = _composite_moduli(scene, drawn_changes) / composite_modulus(scene.material)

    # A changed profile as its numbers by name, each uncertain one an array (n,).
    drawn_profile: Any = scene.profile
    if any(key.startswith("profile.") or key.endswith(".radius") for key in drawn_changes):
        drawn_profile = _numbers_of_drawn_profiles(scene, drawn_changes)

    # W of a cycle for all draws, from W at the stated E*_0 to W at the modulus of the draw;
    # `permanent_stick_load` is the load whose contact is the permanent stick zone.
    batch = semi_analytic.dissipation(
        profile=drawn_profile,
        material=scene.material,
        **_drawn_friction_and_ellipses(scene, drawn_changes, modulus_factor),
    )
    # WORK, STICK: "dissipation" and "permanent_stick"
    values = {WORK: batch.value * modulus_factor}
    stick_half_width = _stick_half_widths(scene, drawn_profile, batch.permanent_stick_load)
    if stick_half_width is not None:
        values[STICK] = stick_half_width
    # `reason`: why a draw has no W
    return values, batch.reason == semi_analytic.Reason.SLIDING


def _drawn_friction_and_ellipses(
    scene: Scene, drawn_changes: Mapping[str, Array], modulus_factor: Array
) -> dict[str, Any]:
    """Friction coefficient and load ellipses of n random draws, (n,) each, by their names as
    arguments of `semi_analytic.dissipation`. The loads are over r = E*/E*_0, `modulus_factor` (n,),
    since one modulus E*_0 serves all draws.

    `drawn_changes` holds the change of each input, (n,) by its key: relative, of a phase in
    degrees.
    """
    load_ellipse = scene.load
    assert isinstance(load_ellipse, EllipseLoad)  # for the type checker: others take no batch
    unchanged = np.ones_like(modulus_factor)

    def factor_of_input(key: str) -> Array:
        """By what factor the draws change an input, (n,)."""
        return 1 + drawn_changes[key] if key in drawn_changes else unchanged

    normal_factor = factor_of_input("normal_load") / modulus_factor
    tangential_factor = factor_of_input("tangential_load") / modulus_factor
    return {
        "friction_coefficient": scene.friction.coefficient * factor_of_input("friction"),
        "mean_normal_load": load_ellipse.mean_normal_load * normal_factor,
        "normal_amplitude": load_ellipse.normal_amplitude * normal_factor,
        "mean_tangential_load": load_ellipse.mean_tangential_load * tangential_factor,
        "tangential_amplitude": load_ellipse.tangential_amplitude * tangential_factor,
        "phase_degrees": load_ellipse.phase_degrees + drawn_changes.get("phase_degrees", 0.0),
    }


def _stick_half_widths(scene: Scene, drawn_profile: Any, stick_load: Array) -> Array | None:
    """Permanent stick half-width of n random draws, (n,) [length]: the half-width of contact under
    the load `stick_load` (n,), NaN where that is NaN. None where the profile is changed and no
    parabola.

    `drawn_profile` is that of the scene, or its numbers by name where the draws change it. The
    loads are those that go with the stated modulus E*_0.
    """
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.profiles import contact_of

    if drawn_profile is scene.profile:
        # by the law of the profile
        contact = contact_of(scene.profile, scene.material)
        has_value = np.isfinite(stick_load)
        stick_half_width = contact.half_width(np.where(has_value, stick_load, 0.0))
        return np.where(has_value, stick_half_width, np.nan)
    if isinstance(scene.profile, Hertz):
        # Hertz: a^2 = 4 R P/(pi E*).
        half_width_squared_per_load = (
            4 * drawn_profile["radius"] / (math.pi * composite_modulus(scene.material))
        )
        return np.asarray(np.sqrt(half_width_squared_per_load * stick_load))
    return None


def _composite_moduli(scene: Scene, drawn_changes: Mapping[str, Array]) -> Array:
    """Composite modulus E* of n random draws, (n,): 1/E* = (1 − nu_l^2)/E_l + (1 − nu_u^2)/E_u, of
    the lower and the upper body. NaN where |nu| is not below 0.5.

    `drawn_changes` holds the relative change of each input, (n,) by its key. A key names a constant
    of both bodies (material.young_modulus) or of one body (material.lower.young_modulus).
    """
    compliance: Array = np.zeros(len(next(iter(drawn_changes.values()))))
    for body_name in ("lower", "upper"):
        material = getattr(scene.material, body_name)
        constants: dict[str, Array] = {}
        for name in ("young_modulus", "poisson_ratio"):
            change_of_body = drawn_changes.get(f"material.{body_name}.{name}", np.zeros(()))
            change = drawn_changes.get(f"material.{name}", change_of_body)
            constants[name] = getattr(material, name) * (1 + change)
        poisson_ratio = np.where(
            np.abs(constants["poisson_ratio"]) < 0.5, constants["poisson_ratio"], np.nan
        )
        compliance = compliance + (1 - poisson_ratio**2) / constants["young_modulus"]
    return np.asarray(1 / compliance)


def _numbers_of_drawn_profiles(scene: Scene, drawn_changes: Mapping[str, Array]) -> dict[str, Any]:
    """The scene's profile for n random draws at once: its numbers by name, each uncertain one as an
    array (n,).

    The relative radius of cylinders is that of the drawn radii: 1/R = 1/R_l + 1/R_u.
    `drawn_changes` holds the relative change of each input, (n,) by its key, such as
    "profile.radius".
    """
    numbers = scene.profile.model_dump()
    for key, change in drawn_changes.items():
        if key.startswith("profile."):
            name = key.removeprefix("profile.")
            numbers[name] = numbers[name] * (1 + change)

    # Sum of the curvatures of the cylinders, from which the profile's radius follows.
    sum_of_curvatures: Any = 0.0
    for body_name in ("lower", "upper"):
        cylinder = getattr(scene.bodies, body_name)
        if isinstance(cylinder, Cylinder):
            change = drawn_changes.get(f"bodies.{body_name}.radius", np.zeros(()))
            sum_of_curvatures = sum_of_curvatures + 1 / (cylinder.radius * (1 + change))
    if scene.bodies.relative_radius() is not None:
        numbers["radius"] = 1 / sum_of_curvatures
    return {name: value for name, value in numbers.items() if value is not None}


def values_one_by_one(
    scene: Scene, drawn_changes: Mapping[str, Array]
) -> tuple[dict[str, Array], Array]:
    """The dissipation W and the permanent stick half-width of n random draws, each solved on its
    own.

    Parameters
    ----------
    drawn_changes
        change of each input, (n,) by its key: relative, of a phase in degrees

    Returns
    -------
    tuple of dict and array
        Values by name, (n,) each, NaN where a draw has none; and which draws slide over the whole
        contact, (n,).
    """
    import semi_analytic

    n_draws = len(next(iter(drawn_changes.values())))
    # WORK, STICK: "dissipation" and "permanent_stick"
    values = {WORK: np.full(n_draws, np.nan), STICK: np.full(n_draws, np.nan)}
    is_sliding = np.zeros(n_draws, dtype=bool)
    for draw in range(n_draws):
        try:
            moved_scene = scene.moved(
                {key: float(changes[draw]) for key, changes in drawn_changes.items()}
            )
            solution = semi_analytic.solve(moved_scene, x=0.0, fields=(WORK,))
        except InadmissibleLoadError:
            is_sliding[draw] = True
        except InputError:  # no scene can have these inputs: counted by its NaN
            continue
        else:
            values[WORK][draw] = solution.dissipation
            values[STICK][draw] = solution.permanent_stick_half_width
    return values, is_sliding


# ---------------------------------------------------------------------------------- the whole of it
def input_effects(scene: Scene, effects: BodyEffects | None = None) -> InputEffects | None:
    """The uncertainties that the stated uncertainties of a scene's inputs give to theory's values,
    and to the difference of finite bodies from half-planes. None where none is stated.

    Where theory cannot solve the scene or does not converge, `reason_unknown` of what is returned
    says why.

    Parameters
    ----------
    scene
        `inputs` are its uncertain inputs, `uncertainty` their standard uncertainties and
        correlations
    effects
        elastic responses that finite bodies add to half-planes, where they are known already

    Examples
    --------
    2 % more tangential load gives 7.1 % more dissipation:

    >>> from scenes import load_scene
    >>> stated = {"friction": "5 %", "tangential_load": "2 %"}
    >>> scene = load_scene("cattaneo-mindlin").vary(uncertainty=stated)
    >>> dissipation = input_effects(scene).values["dissipation"]
    >>> change = dissipation.changes["tangential_load"].value
    >>> f"{100 * change / dissipation.value:.1f} %"
    '7.1 %'
    """
    scene = validated(scene, Scene)
    if not scene.inputs:
        return None
    assert scene.uncertainty is not None
    # Under a prescribed displacement pads are taken as blocks; else the scene itself.
    solved_scene = with_blocks(scene)
    if reason := _reason_without_values(solved_scene):
        return InputEffects(scene.inputs, scene.uncertainty.correlations, reason_unknown=reason)
    try:
        uncertainties_by_inputs = _input_effects(solved_scene, effects)
        # The note `_BLOCKS_FOR_PADS` says that pads were taken as blocks.
        if solved_scene is scene:
            return uncertainties_by_inputs
        return replace(
            uncertainties_by_inputs, notes=(*uncertainties_by_inputs.notes, _BLOCKS_FOR_PADS)
        )
    except (InputError, ConvergenceError) as fault:
        return InputEffects(
            scene.inputs,
            scene.uncertainty.correlations,
            sliding=None if scene.load.is_driven else nearness_to_sliding(scene),
            reason_unknown=str(fault),
        )


class _TheoryUnderInputs(NamedTuple):
    """Values of half-plane theory with the uncertainty that the inputs give them.

    Attributes
    ----------
    values
        by name, each with its standard uncertainty by all inputs
    nearness
        how near the loads come to gross sliding: the largest |Q|/(f P) with its standard
        uncertainty; None where it is not known
    reason_for_draws
        why no derivative by the inputs is known, so that random draws are needed; "" where they are
    """

    values: dict[str, UncertainValue]
    nearness: NearSliding | None
    reason_for_draws: str


def _input_effects(scene: Scene, effects: BodyEffects | None) -> InputEffects:
    """The uncertainties that the inputs give to theory's values and, where it can be computed, to
    the difference of finite bodies from half-planes.

    Random draws are added where derivatives are not enough: near gross sliding, or where the change
    of second order is large. Where draws take too long, a note says so instead.

    Parameters
    ----------
    scene
        with uncertain `inputs`
    effects
        elastic responses that the scene's bodies add to half-planes; None where they are not
        computed yet

    Raises
    ------
    InputError, ConvergenceError
        Where theory cannot solve the scene, or does not converge, at the stated inputs.
    """
    assert scene.uncertainty is not None
    correlation = scene.uncertainty.correlation_matrix()
    theory = _theory_under_inputs(scene, effects, correlation)
    draws, notes_on_draws = _draws_where_needed(scene, theory)
    # The difference of finite bodies from half-planes, or why it is not known.
    difference, reason_without_difference = _difference_or_reason(scene, effects, correlation)
    return InputEffects(
        inputs=scene.inputs,
        correlations=scene.uncertainty.correlations,
        values=theory.values,
        difference=difference,
        reason_without_difference=reason_without_difference,
        draws=draws,
        sliding=theory.nearness,
        # first those on values that are left out since they take too long
        notes=(*_notes_on_values(scene), *notes_on_draws),
    )


def _theory_under_inputs(
    scene: Scene, effects: BodyEffects | None, correlation: Array
) -> _TheoryUnderInputs:
    """The values of half-plane theory with the uncertainty that the inputs give them, by
    derivatives.

    Parameters
    ----------
    scene
        with n uncertain `inputs`; `load.is_driven`: a displacement is prescribed instead of Q
    effects
        elastic responses that the scene's bodies add to half-planes; None where they are not
        computed yet
    correlation
        (n, n) correlation matrix of the inputs
    """
    # QUANTITIES_UNDER_DISPLACEMENT, QUANTITIES_OF_THEORY: words and units of theory's values by
    # name
    quantities = QUANTITIES_UNDER_DISPLACEMENT if scene.load.is_driven else QUANTITIES_OF_THEORY

    def effects_of(changed_scene: Scene) -> BodyEffects | None:
        """Elastic responses of a changed scene's bodies; None where theory needs none."""
        return _effects_of_driven(changed_scene, scene, effects)

    # Theory's values by name, and their change by one standard uncertainty of each input.
    values_at_inputs = values_of_theory(scene, effects_of(scene))
    reason_for_draws = ""
    try:
        changes_by_inputs = changes_of_theory(scene, values_at_inputs, effects_of)
    except InadmissibleLoadError:
        changes_by_inputs = [
            _unknown_changes(uncertain_input, values_at_inputs) for uncertain_input in scene.inputs
        ]
        reason_for_draws = "a sixteenth of a standard uncertainty makes the loads slide"

    # Each value with its standard uncertainty by all inputs.
    uncertain_values = {
        name: uncertain_value(quantities[name], value, changes_by_inputs, name, correlation)
        for name, value in values_at_inputs.items()
    }
    # RATIO: the largest |Q|/(f P), one of the values under a prescribed displacement
    nearness = None if scene.load.is_driven else nearness_to_sliding(scene)
    if RATIO in uncertain_values:
        # Near sliding the larger of the changes up and down counts.
        changes_of_ratio = _changes_towards_sliding(changes_by_inputs)
        uncertain_ratio = uncertain_value(
            quantities[RATIO], values_at_inputs[RATIO], changes_of_ratio, RATIO, correlation
        )
        uncertain_values[RATIO] = uncertain_ratio
        # NearSliding: the ratio with its standard uncertainty
        nearness = NearSliding(uncertain_ratio.value, uncertain_ratio.uncertainty)
    return _TheoryUnderInputs(uncertain_values, nearness, reason_for_draws)


def _draws_where_needed(scene: Scene, theory: _TheoryUnderInputs) -> tuple[Draws | None, list[str]]:
    """Random draws of the inputs where derivatives are not enough for the uncertainty of the
    dissipation, and notes: near gross sliding, or where the second order is large. Where the draws
    take too long they are None, and a note says so. Without a reason they are None too.

    `theory` holds the values by derivatives with their uncertainty, and how near the loads come to
    sliding.
    """
    reason_by_sliding = theory.reason_for_draws or _reason_by_sliding(theory.nearness)
    reason_by_second_order = _reason_by_second_order(theory.values)
    if not (reason_by_sliding or reason_by_second_order):
        return None, []
    draws = draws_of_work(scene, reason_by_sliding or reason_by_second_order)
    if draws is not None:
        return draws, []
    return None, [
        _note_on_missing_draws(reason_by_sliding, reason_by_second_order, theory.nearness)
    ]


def _note_on_missing_draws(
    reason_by_sliding: str, reason_by_second_order: str, nearness: NearSliding | None
) -> str:
    """A note that random draws are needed but take too long, with the reason why they are needed
    where no other sentence of the report states it.

    Parameters
    ----------
    reason_by_sliding, reason_by_second_order
        why draws are needed, "" where not
    nearness
        how near the loads come to gross sliding; `is_in_reach`: within two standard uncertainties,
        which the report says elsewhere; None where it is not known
    """
    note = "draws of this load take too long"
    if reason_by_sliding and not (nearness is not None and nearness.is_in_reach):
        note = f"{reason_by_sliding}; {note}"
    # A large second order stands in the list of rough values.
    return note if reason_by_second_order else f"derivatives may not be enough: {note}"


def _changes_towards_sliding(changes_by_inputs: Sequence[_ChangeByInput]) -> list[_ChangeByInput]:
    """The change of the largest |Q|/(f P) by one standard uncertainty of each input, the larger of
    the changes with the input up and down: the central difference plus the second order.

    The ratio cannot pass 1, where the bodies slide, so near 1 its changes up and down differ.
    `changes_by_inputs` holds for each input its key, and (central change, second order) of each
    value by name; RATIO is the name of the largest |Q|/(f P).
    """
    changes_towards_sliding = []
    for change_by_input in changes_by_inputs:
        central_change, second_order = change_by_input.changes[RATIO]
        larger_change = math.copysign(abs(central_change) + second_order, central_change)
        # Estimate: a value with its uncertainty
        changes_towards_sliding.append(
            _ChangeByInput(change_by_input.key, {RATIO: Estimate(larger_change, second_order)})
        )
    return changes_towards_sliding


def _unknown_changes(uncertain_input: Input, values_at_inputs: _ValueByName) -> _ChangeByInput:
    """Not-a-number in place of the changes of all values by one uncertain input, which could not be
    found.
    """
    return _ChangeByInput(
        uncertain_input.key, dict.fromkeys(values_at_inputs, Estimate(math.nan, math.nan))
    )


def _effects_of_driven(
    changed_scene: Scene, scene: Scene, effects: BodyEffects | None
) -> BodyEffects | None:
    """Elastic responses of the bodies of `changed_scene` beyond those of half-planes, which theory
    of a prescribed displacement needs; None where loads are given, or for half-planes.

    They are `effects` where the bodies and materials are those of `scene`; else they are computed.
    `changed_scene` is `scene` with other values of its uncertain inputs. `load.is_driven`: a
    displacement is prescribed instead of Q.
    """
    if not changed_scene.load.is_driven or changed_scene.bodies.half_planes:
        return None
    import halfplane_fe

    has_same_bodies = (
        changed_scene.bodies == scene.bodies and changed_scene.material == scene.material
    )
    if effects is not None and has_same_bodies:
        return effects
    return halfplane_fe.body_effects(changed_scene)


def _uncertain_differences(
    scene: Scene, effects: BodyEffects | None, correlation: Array
) -> dict[str, UncertainValue]:
    """The difference finite bodies/half-planes − 1 in the dissipation and in the largest pressure,
    by name, each with the standard uncertainty that the inputs give it.

    Parameters
    ----------
    scene
        with uncertain inputs and finite bodies
    effects
        elastic responses of the bodies beyond those of half-planes; solved for here where None
    correlation
        (n, n) correlation matrix of the inputs

    Returns
    -------
    dict
        The differences that are known, each by the name of its value.
    """
    import halfplane_fe

    if effects is None:
        effects = halfplane_fe.body_effects(scene)
    # The differences by name, and their changes by one standard uncertainty of each input.
    values_at_inputs, changes_by_inputs = changes_of_difference(scene, effects)
    differences = {}
    for name, value in values_at_inputs.items():
        # NaN: not known for this scene.
        if math.isfinite(value):
            # QUANTITIES_OF_THEORY: words and units of theory's values by name
            difference_in_words = f"difference of the {QUANTITIES_OF_THEORY[name].words}"
            quantity = QUANTITIES_OF_THEORY[name]._replace(words=difference_in_words, unit="share")
            differences[name] = uncertain_value(
                quantity, value, changes_by_inputs, name, correlation
            )
    return differences


def _difference_or_reason(
    scene: Scene, effects: BodyEffects | None, correlation: Array
) -> tuple[dict[str, UncertainValue], str]:
    """The difference finite bodies/half-planes − 1 by name of the value, each with the standard
    uncertainty that the inputs give it, and ""; or an empty dictionary, and in words why it is not
    known.

    `correlation` (n, n) is that of the n inputs. `effects` are the elastic responses that finite
    bodies add to half-planes, None where they are not computed yet.
    """
    reason_without_difference = _reason_without_difference(scene)
    if reason_without_difference:
        return {}, reason_without_difference
    try:
        return _uncertain_differences(scene, effects, correlation), ""
    except InputError as fault:
        return {}, str(fault)


def _notes_on_values(scene: Scene) -> list[str]:
    """A note where some values of theory are left out, since they take too long; else none."""
    left_out_in_words = "the largest pressure, the slip and the edge tension are left out"
    if _is_long_record(scene):
        return [f"of a record of more than {_MOST_ROWS_FOR_SEARCH:,} rows {left_out_in_words}"]
    if _needs_grids(scene):
        return [f"where theory needs grids {left_out_in_words}"]
    return []


def _reason_by_sliding(sliding: NearSliding | None) -> str:
    """Why derivatives by the inputs are not enough for the uncertainty of the work W: gross sliding
    is nearer than three standard uncertainties; "" where it is not, or the bodies slide already.
    """
    if sliding is None or not 0 < sliding.sigmas_to_sliding < _MOST_SIGMAS_NEAR_SLIDING:
        return ""
    return (
        f"gross sliding is {sliding.sigmas_to_sliding:.2g} standard uncertainties of |Q|/(f P) away"
    )


def _reason_by_second_order(values: Mapping[str, UncertainValue]) -> str:
    """Why derivatives by the inputs are not enough for the uncertainty of the work W: the second
    order is more than a tenth of it; "" where it is not.
    """
    work = values[WORK]
    if work.uncertainty and not work.is_nearly_linear:
        per_cent = 100 * work.second_order / work.uncertainty
        return f"the second order is {per_cent:.0f} % of the uncertainty of W"
    return ""


def nearness_to_sliding(scene: Scene) -> NearSliding | None:
    """The largest |Q|/(f P) of given loads with its standard uncertainty by the inputs; 1 is gross
    sliding. None without friction, and where no input has an uncertainty.

    The ratio goes as Q and as 1/(f P); its change by the phase of an ellipse is a central
    difference. No other input changes it.
    """
    if not (scene.friction.coefficient and scene.inputs):
        return None
    assert scene.uncertainty is not None
    # The largest |Q|/(f P) along the load path.
    ratio = nearest_to_sliding(scene).ratio

    # Its change by one standard uncertainty of each input.
    changes = []
    for uncertain_input in scene.inputs:
        key = uncertain_input.key
        standard_uncertainty = uncertain_input.standard_uncertainty
        change = 0.0
        # of loads and friction the standard uncertainty is a fraction of the value
        if key in ("friction", "normal_load"):
            change = -ratio * standard_uncertainty
        elif key == "tangential_load":
            change = ratio * standard_uncertainty
        elif key == "phase_degrees":
            ratio_above = nearest_to_sliding(scene.moved({key: standard_uncertainty})).ratio
            ratio_below = nearest_to_sliding(scene.moved({key: -standard_uncertainty})).ratio
            change = (ratio_above - ratio_below) / 2
        changes.append(change)

    # Variance by all inputs, with their correlations.
    changes_of_ratio = np.array(changes)
    variance = max(
        float(changes_of_ratio @ scene.uncertainty.correlation_matrix() @ changes_of_ratio), 0.0
    )
    # NearSliding: the ratio with its standard uncertainty
    return NearSliding(ratio, math.sqrt(variance))
