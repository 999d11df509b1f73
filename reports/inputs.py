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
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from reports.checking import nearest_to_sliding
from reports.comparison.laws import ratio_of_answer
from reports.comparison.pairs import coupled
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
    sampled,
)
from scenes.array_types import Array

if TYPE_CHECKING:
    pass

WORK = "dissipation"
PEAK = "peak_pressure"
STICK = "permanent_stick"
RATIO = "sliding_ratio"
# Shares of a standard uncertainty by which an input is moved: the first that leaves the loads below
# gross sliding on both sides.
_STEPS = (1.0, 0.25, 0.0625)
# Standard uncertainties between the loads and gross sliding, below which draws are taken: beyond,
# fewer than 2 draws in 1,000 slide.
_NEAR_SLIDING = 3.0
# The same below which the bodies may slide, at the usual level of 95 %.
_IN_REACH = 2.0
# Of the limit of friction: within it the bodies slide already.
_AT_LIMIT = 1e-9
# Of the uncertainty: what the second order may be for derivatives to be enough.
_NEARLY_LINEAR = 0.1
# Share of P or Q by which it is moved where no uncertainty of it is stated, but that of an input
# whose derivative follows from it.
_STEP_OF_LOAD = 0.01
DRAWS = 100_000
# Where each draw is a solve of its own, or has a profile of its own shape.
FEW_DRAWS = 200
_SEED = 20_2009  # of V&V 20-2009: any number, but the same in each run
# Rows of a record above which slip and edge tension, which are searched for, are left out.
_LONG_RECORD = 500

_Values = dict[str, float]


class Quantity(NamedTuple):
    """A value of theory: its words, symbol and unit, and its exponents in the scaling laws."""

    words: str
    unit: str
    of_stress: int
    of_shear: int
    of_heights: int
    of_lengths: int


QUANTITIES_OF_THEORY = {
    WORK: Quantity("dissipation W", "energy", 1, 2, 2, 0),
    PEAK: Quantity("largest pressure", "stress", 1, 0, 1, -1),
    "half_width": Quantity("largest contact half-width", "length", 0, 0, 0, 1),
    "permanent_stick": Quantity("permanent stick half-width", "length", 0, 0, 0, 1),
    "slip": Quantity("largest slip", "length", 0, 1, 1, 0),
    "edge_tension": Quantity("largest edge tension", "stress", 1, 1, 1, -1),
}
"""Of the last cycle, or of the whole path where nothing repeats."""
OF_DRIVEN = {
    WORK: QUANTITIES_OF_THEORY[WORK],
    PEAK: QUANTITIES_OF_THEORY[PEAK],
    "half_width": QUANTITIES_OF_THEORY["half_width"],
    "permanent_stick": QUANTITIES_OF_THEORY["permanent_stick"],
    "largest_tangential_load": Quantity("largest tangential load", "load", 1, 1, 1, 0),
    RATIO: Quantity("largest |Q|/(f P)", "ratio", 0, 0, 0, 0),
}
"""Where a displacement is prescribed in the place of Q."""


@dataclass(frozen=True)
class Propagated:
    """A value, and what the inputs make of it.

    Attributes
    ----------
    words, unit
        what it is, and the kind of its unit; "share" of a difference
    value
        at the inputs as stated; NaN where there is none
    changes
        key of an input -> change of the value for one standard uncertainty, with its error
    second_order
        root of the summed squares of the second order
    uncertainty
        standard uncertainty, correlations counted
    """

    words: str
    unit: str
    value: float
    changes: Mapping[str, Estimate]
    second_order: float
    uncertainty: float

    @property
    def relative(self) -> float:
        """Standard uncertainty over the value; NaN of 0."""
        return self.uncertainty / abs(self.value) if self.value else math.nan

    @property
    def is_nearly_linear(self) -> bool:
        """Whether derivatives are enough."""
        return self.second_order <= _NEARLY_LINEAR * self.uncertainty

    @property
    def ranking(self) -> list[str]:
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
    def distance(self) -> float:
        """Standard uncertainties between the ratio and 1; infinite where no input moves it."""
        return (1 - self.ratio) / self.uncertainty if self.uncertainty > 0 else math.inf

    @property
    def is_in_reach(self) -> bool:
        """Whether bodies that do not slide may do so within two standard uncertainties."""
        return self.ratio < 1 - _AT_LIMIT and self.distance <= _IN_REACH


class Drawn(NamedTuple):
    """A value over the draws that have one: its mean, standard deviation, and between which 95 % of
    them lie.
    """

    mean: float
    uncertainty: float
    low: float
    high: float

    @property
    def relative(self) -> float:
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
    values: Mapping[str, Drawn]
    reason: str


@dataclass(frozen=True)
class InputEffects:
    """What the stated uncertainties of the inputs make of a scene's answer.

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
    no_difference
        why it is not known, in a sentence; empty where it is
    draws
        of W, where derivatives are not enough; else None
    sliding
        how near the loads come to gross sliding; None without friction or where it is not known
    notes
        what is left out, in sentences
    unknown
        why nothing of it is known, in a sentence; empty where `values` has entries
    """

    inputs: tuple[Input, ...]
    correlations: tuple[tuple[str, str, float], ...]
    values: Mapping[str, Propagated] = field(default_factory=dict)
    difference: Mapping[str, Propagated] = field(default_factory=dict)
    no_difference: str = ""
    draws: Draws | None = None
    sliding: NearSliding | None = None
    notes: tuple[str, ...] = ()
    unknown: str = ""

    @property
    def work_uncertainty(self) -> float:
        """Standard uncertainty of W over W, of the draws where there are any; NaN where it is not
        known.
        """
        if WORK not in self.values:
            return math.nan
        work = self.values[WORK]
        if self.draws is not None and math.isfinite(self.draws.values[WORK].relative):
            return self.draws.values[WORK].relative
        return work.relative


def propagated(
    quantity: Quantity,
    value: float,
    changes_by_inputs: Sequence[_ChangeByInput],
    key: str,
    correlation: Array,
) -> Propagated:
    """A computed value with the standard uncertainty that all n uncertain inputs together give it:
    u^2 = c^T R c, c its changes by one standard uncertainty of each input, R their correlations.

    Parameters
    ----------
    quantity, value
        its name with unit, and its size
    changes_by_inputs
        for each input, how much one standard uncertainty of it changes every value
    key
        key of this value in these changes
    correlation
        (n, n) correlation matrix of the inputs
    """
    changes = {change.key: change.changes[key] for change in changes_by_inputs}
    change_by_input = np.array([change.value for change in changes.values()])
    second_order = math.hypot(*(change.uncertainty for change in changes.values()))
    # a correlation of -1 may leave a negative sum of squares by round-off
    variance = max(float(change_by_input @ correlation @ change_by_input), 0.0)
    if not np.all(np.isfinite(change_by_input)):
        variance = math.nan
    return Propagated(
        quantity.words, quantity.unit, value, changes, second_order, math.sqrt(variance)
    )


# ------------------------------------------------------------------------------- one scene's values
def values_of_theory(scene: Scene, effects: BodyEffects | None = None) -> _Values:
    """Half-plane theory's values of the last cycle by name: dissipation, largest pressure,
    half-widths, largest slip and edge tension; fewer for long records.

    Under a prescribed displacement the largest Q and the largest |Q|/(f P) are among them, and
    `effects` are the elastic responses that finite bodies add to half-planes.

    Raises
    ------
    InputError
        For a scene that theory does not take, such as one with gross sliding.
    """
    import semi_analytic

    if scene.load.is_driven:
        solution = semi_analytic.solve(scene, x=0.0, effects=effects, fields=(WORK, "pressure"))
        steps = solution.last_cycle
        values = {
            WORK: solution.dissipation,
            PEAK: float(solution.pressure[steps].max()),
            "half_width": float(np.max(solution.contact_half_width[steps])),
            "permanent_stick": solution.permanent_stick_half_width,
            "largest_tangential_load": float(np.max(np.abs(solution.tangential_load[steps]))),
        }
        if scene.friction.coefficient:
            values[RATIO] = ratio_of_answer(solution)
        return values
    solution = semi_analytic.solve(scene, x=0.0, fields=(WORK,))
    # largest values are searched for, which takes too long there
    if _is_long(scene) or _needs_grids(scene):
        return {
            WORK: solution.dissipation,
            "half_width": float(np.max(solution.contact_half_width[solution.last_cycle])),
            "permanent_stick": solution.permanent_stick_half_width,
        }
    largest_values = semi_analytic.extremes(solution, names=("slip", "edge_tension"))
    return {
        WORK: solution.dissipation,
        PEAK: largest_values.pressure,
        "half_width": largest_values.half_width,
        "permanent_stick": solution.permanent_stick_half_width,
        "slip": largest_values.slip,
        "edge_tension": largest_values.edge_tension,
    }


def _is_long(scene: Scene) -> bool:
    load = scene.load
    return isinstance(load, TimeSeriesLoad) and len(load.kept_rows()) > _LONG_RECORD


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


def central_differences(
    values_at: Callable[[Scene], _Values],
    scene: Scene,
    uncertain_input: Input,
    values_at_inputs: _Values,
) -> _ChangeByInput:
    """How much one standard uncertainty of an input changes each value of theory, by central
    differences: the values are computed with the input moved up and down by its standard
    uncertainty.

    Where the loads would then slide a smaller step is taken, down to a sixteenth.

    Parameters
    ----------
    values_at
        computes the values of a scene
    uncertain_input
        the input: its key and its standard uncertainty
    values_at_inputs
        the values with the input as it is

    Raises
    ------
    InputError
        Where the smallest step slides.
    """
    for share_of_uncertainty in _STEPS:
        step = share_of_uncertainty * uncertain_input.standard
        try:
            values_above = values_at(scene.moved({uncertain_input.key: step}))
            values_below = values_at(scene.moved({uncertain_input.key: -step}))
        except InadmissibleLoadError:
            if share_of_uncertainty == _STEPS[-1]:
                raise
            continue
        return _ChangeByInput(
            uncertain_input.key,
            _differences(values_at_inputs, values_above, values_below, share_of_uncertainty),
        )
    raise AssertionError  # the last step returns or raises


def _differences(
    values_at_inputs: _Values, values_above: _Values, values_below: _Values, share: float
) -> dict[str, Estimate]:
    """For each value of theory its change by one standard uncertainty of an input, by the central
    difference, and as error of that the second-order change.

    Parameters
    ----------
    values_at_inputs, values_above, values_below
        values by name with the input as it is, moved up, and moved down
    share
        by how many standard uncertainties it was moved
    """
    changes = {}
    for key, value in values_at_inputs.items():
        change = (values_above[key] - values_below[key]) / (2 * share)
        second_order = abs(values_above[key] + values_below[key] - 2 * value) / (2 * share**2)
        changes[key] = Estimate(change, second_order)
    return changes


def _change_of_modulus(scene: Scene, uncertain_input: Input) -> float:
    """Share by which E* changes for one standard uncertainty of a constant of a material."""
    from semi_analytic.elasticity import composite_modulus

    modulus_above = composite_modulus(
        scene.moved({uncertain_input.key: uncertain_input.standard}).material
    )
    modulus_below = composite_modulus(
        scene.moved({uncertain_input.key: -uncertain_input.standard}).material
    )
    return (modulus_above - modulus_below) / (2 * composite_modulus(scene.material))


# ------------------------------------------------------------------- changes of theory's values
def changes_of_theory(
    scene: Scene, values_at_inputs: _Values, effects_of: Callable[[Scene], BodyEffects | None]
) -> list[_ChangeByInput]:
    """For each uncertain input of a scene, how much one standard uncertainty of it changes theory's
    values `values_at_inputs`: by scaling laws where they hold, else by central differences.

    `effects_of` gives the elastic responses of the bodies of a scene with a changed input.
    """

    def values_at(changed_scene: Scene) -> _Values:
        return values_of_theory(changed_scene, effects_of(changed_scene))

    laws_hold = not (scene.load.is_driven or scene.unsymmetric)
    if not laws_hold:
        return [
            central_differences(values_at, scene, uncertain_input, values_at_inputs)
            for uncertain_input in scene.inputs
        ]
    laws = _ScalingLaws(scene, values_at_inputs, values_at)
    return [
        _by_laws(laws, scene, uncertain_input, values_at_inputs, values_at)
        for uncertain_input in scene.inputs
    ]


def _by_laws(
    laws: _ScalingLaws,
    scene: Scene,
    uncertain_input: Input,
    values_at_inputs: _Values,
    values_at: Callable[[Scene], _Values],
) -> _ChangeByInput:
    """How much one standard uncertainty of an input changes each value of half-plane theory: by a
    scaling law where there is one for its key, else by central differences.

    Parameters
    ----------
    laws
        the scaling laws of this scene
    uncertain_input
        the input: its key and its standard uncertainty, a share of its value
    values_at_inputs
        the values with the input as it is
    values_at
        computes the values of a scene
    """
    key = uncertain_input.key
    if key.startswith("bodies.") and not key.endswith(".radius"):
        # half-plane theory has no bodies
        return _ChangeByInput(key, dict.fromkeys(values_at_inputs, Estimate(0.0)))
    if key == "friction":
        return laws.change(key, uncertain_input.standard, laws.of_friction())
    if key.startswith("material."):
        return laws.change(key, _change_of_modulus(scene, uncertain_input), laws.of_modulus())
    is_parabola = isinstance(scene.profile, Hertz)
    if key == "profile.radius" and is_parabola:
        return laws.change(key, uncertain_input.standard, laws.of_radius())
    if key == "normal_load" and is_parabola:
        return laws.change(key, uncertain_input.standard, laws.of_normal_load())
    if key in ("normal_load", "tangential_load"):
        return laws.by_differences(key)
    return central_differences(values_at, scene, uncertain_input, values_at_inputs)


class _ScalingLaws:
    """D_x = x dV/dx of half-plane theory by its scaling laws, from D_Q, and D_P of other profiles
    than a parabola, which are central differences taken once.
    """

    def __init__(
        self, scene: Scene, values_at_inputs: _Values, values_at: Callable[[Scene], _Values]
    ) -> None:
        self.scene = scene
        self.values_at_inputs = values_at_inputs
        self.values_at = values_at
        self._changes_by_loads: dict[str, _ChangeByInput] = {}
        self._derivatives: dict[str, _Values] = {}

    def change(self, key: str, share: float, derivatives: _Values) -> _ChangeByInput:
        """The change of each value by one standard uncertainty of an input: `share` of the input x,
        times x dV/dx (`derivatives`, by name of the value V). `key` names the input.

        The values are powers of one input: the second order of x^n is about half of the first
        squared over the value.
        """
        changes = {}
        for name, derivative in derivatives.items():
            value = self.values_at_inputs[name]
            change = share * derivative
            second_order = abs(change * (change - share * value) / (2 * value)) if value else 0.0
            changes[name] = Estimate(change, second_order)
        return _ChangeByInput(key, changes)

    def of_tangential_load(self) -> _Values:
        """x dV/dx of every value V for the tangential load x, by central differences."""
        return self.derivative("tangential_load")

    def of_normal_load(self) -> _Values:
        """x dV/dx of every value V for the normal load x: measured, or of a parabola by a scaling
        law.
        """
        if not isinstance(self.scene.profile, Hertz):
            return self.derivative("normal_load")
        heights = self._exponents("of_heights")
        radius = self.of_radius()
        of_force = self.of_tangential_load()
        return {key: heights[key] + radius[key] - of_force[key] for key in self.values_at_inputs}

    def of_radius(self) -> _Values:
        """x dV/dx of every value V for the radius x of a parabola, by a scaling law."""
        return {key: law / 2 for key, law in self._exponents("of_lengths").items()}

    def of_friction(self) -> _Values:
        """x dV/dx of every value V for the coefficient of friction x, by a scaling law."""
        shear = self._exponents("of_shear")
        of_force = self.of_tangential_load()
        return {key: shear[key] - of_force[key] for key in self.values_at_inputs}

    def of_modulus(self) -> _Values:
        """x dV/dx of every value V for the composite modulus x = E*, by a scaling law."""
        stress = self._exponents("of_stress")
        of_load = self.of_normal_load()
        of_force = self.of_tangential_load()
        return {key: stress[key] - of_load[key] - of_force[key] for key in self.values_at_inputs}

    def _exponents(self, law: str) -> _Values:
        """Exponent of each value V in a scaling law, times V: x dV/dx where the law's factor is x.
        `law` is the attribute of a quantity that holds the exponent.
        """
        return {
            key: getattr(QUANTITIES_OF_THEORY[key], law) * value
            for key, value in self.values_at_inputs.items()
        }

    def by_differences(self, key: str) -> _ChangeByInput:
        """The change of each value by one standard uncertainty of a load, P or Q as `key` says,
        found by central differences once and kept. Where the scene states no uncertainty of it a
        small step is taken for one.
        """
        if key not in self._changes_by_loads:
            stated_inputs = [
                uncertain_input
                for uncertain_input in self.scene.inputs
                if uncertain_input.key == key
            ]
            uncertain_input = (
                stated_inputs[0] if stated_inputs else Input(key, "", "", None, _STEP_OF_LOAD)
            )
            change_by_load = central_differences(
                self.values_at, self.scene, uncertain_input, self.values_at_inputs
            )
            self._changes_by_loads[key] = change_by_load
            self._derivatives[key] = {
                name: change.value / uncertain_input.standard
                for name, change in change_by_load.changes.items()
            }
        return self._changes_by_loads[key]

    def derivative(self, key: str) -> _Values:
        """x dV/dx of every value V for the load x, P or Q as `key` says, by central differences."""
        self.by_differences(key)
        return self._derivatives[key]


# --------------------------------------------------------------------------------- the difference
def with_blocks(scene: Scene) -> Scene:
    """The scene with a block for each pad where a displacement is prescribed, the profile being the
    gap between flat faces; else the scene itself.

    What the arcs of the pads add is left out. Changes of W are near: by 5 % of the friction -5.37 %
    for blocks by theory, -5.38 % for a pad with a/R = 0.014 by finite elements.
    """
    if not scene.load.is_driven:
        return scene
    blocks = {}
    for name in ("lower", "upper"):
        body = getattr(scene.bodies, name)
        if isinstance(body, Pad):
            blocks[name] = Block(**body.model_dump(exclude={"kind"}))
    return scene.vary(bodies=blocks) if blocks else scene


_BLOCKS_FOR_PADS = (
    "under a prescribed displacement pads are taken as blocks of their size here: what their arcs"
    " add is not in it"
)


def _no_values(scene: Scene) -> str:
    """Why nothing can be said of the inputs of a scene, and what to do instead; "" where theory
    takes the scene.
    """
    if not (scene.load.is_driven and scene.bodies.faces_are_true):
        return ""
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


def not_stated(scene: Scene) -> str:
    """A sentence on what a run will not state of the effect of the inputs, and why. Empty where it
    states all, and for half-planes, for which theory has no error.
    """
    if not scene.inputs or scene.bodies.half_planes:
        return ""
    scene_solved = with_blocks(scene)
    if reason := _no_values(scene_solved):
        return f"What the inputs make of the answer will not be known: {reason}."
    if scene_solved is not scene:
        return f"What the inputs make of the answer: {_BLOCKS_FOR_PADS}."
    reason = "" if scene.load.is_driven else _no_difference(scene)
    if not reason:
        return ""
    return (
        "How far the inputs move the difference of the two models will not be stated, a"
        f" measurement's uncertainty will: {reason.rstrip('.')}."
    )


def _no_difference(scene: Scene) -> str:
    """Why the effect of the inputs on the difference of theory and real bodies is not known; ""
    where it can be found.
    """
    if scene.load.is_driven:
        return (
            "under a prescribed displacement each engine finds loads of its own, and nothing is"
            " compared"
        )
    if scene.bodies.half_planes:
        return "both bodies are half-planes, for which theory is exact whatever the inputs are"
    if coupled(scene):
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
) -> tuple[_Values, list[_ChangeByInput]]:
    """The error of half-plane theory in the work W and the largest pressure, as a share (finite
    bodies/half-planes − 1); and how much one standard uncertainty of each uncertain input changes
    that error.

    Both models get the changed input. Finite bodies are half-planes corrected by the elastic
    responses of these bodies, `effects`.

    Raises
    ------
    InputError
        Where the responses of changed bodies are not known.
    """
    import halfplane_fe

    def values_at(changed_scene: Scene) -> _Values:
        changed_effects = effects
        if changed_scene.bodies != scene.bodies or changed_scene.material != scene.material:
            changed_effects = halfplane_fe.body_effects(changed_scene)
        return difference_at(changed_scene, changed_effects, by_batch=by_batch)

    by_batch = takes_batch(scene, effects)  # W by the quick formula for ellipses of loads
    errors_at_inputs = difference_at(scene, effects, by_batch=by_batch)
    laws = _LawOfModulus(scene, errors_at_inputs, values_at)
    changes_by_inputs = []
    for uncertain_input in scene.inputs:
        if uncertain_input.key == "material.young_modulus":
            changes_by_inputs.append(laws.change(uncertain_input))
        elif uncertain_input.key in ("normal_load", "tangential_load"):
            changes_by_inputs.append(laws.by_differences(uncertain_input.key))
        else:
            changes_by_inputs.append(
                central_differences(values_at, scene, uncertain_input, errors_at_inputs)
            )
    return errors_at_inputs, changes_by_inputs


class _LawOfModulus:
    """D_E + D_P + D_Q = 0 of a difference, a number without a unit: what bodies add to half-planes
    goes as 1/E, as half-planes do.
    """

    def __init__(
        self, scene: Scene, values_at_inputs: _Values, values_at: Callable[[Scene], _Values]
    ) -> None:
        self.loads = _ScalingLaws(scene, values_at_inputs, values_at)

    def by_differences(self, key: str) -> _ChangeByInput:
        return self.loads.by_differences(key)

    def change(self, uncertain_input: Input) -> _ChangeByInput:
        """How much one standard uncertainty of Young's modulus changes the error of theory in each
        value, where both bodies are of one material: the error depends on loads over E, so the
        derivatives by the loads give it.
        """
        derivative_by_p = self.loads.derivative("normal_load")
        derivative_by_q = self.loads.derivative("tangential_load")
        changes = {}
        for key in derivative_by_p:
            change = -uncertain_input.standard * (derivative_by_p[key] + derivative_by_q[key])
            # E is linear in small 1/E: the second order is the first times the share
            changes[key] = Estimate(change, abs(change) * uncertain_input.standard)
        return _ChangeByInput(uncertain_input.key, changes)


def takes_batch(scene: Scene, effects: BodyEffects) -> bool:
    """Whether `semi_analytic.dissipation` has the difference of W at the scene's inputs and where
    they are moved: of an ellipse between bodies without tilt and strain, which stay alike.
    """
    from semi_analytic.odd_memory import ODD_NUMBERS

    has_odd_part = any(getattr(effects, name).value for name in ODD_NUMBERS)
    stay_alike = not any(
        uncertain_input.key.startswith("bodies.") for uncertain_input in scene.inputs
    )
    is_ellipse = isinstance(scene.load, EllipseLoad) and not scene.unsymmetric
    return is_ellipse and stay_alike and not has_odd_part


def difference_at(scene: Scene, effects: BodyEffects, *, by_batch: bool) -> _Values:
    """Work W and largest pressure of finite bodies over those of half-planes, minus 1, by theory
    with the elastic responses of the bodies (`effects`).

    Parameters
    ----------
    by_batch
        whether W is taken from the curvatures of the faces alone, in a fifth of the time; else with
        the next order of the bodies, tilt and strain
    """
    return {
        WORK: _difference_of_work(scene, effects, by_batch),
        PEAK: _difference_of_peak(scene, effects),
    }


def _difference_of_work(scene: Scene, effects: BodyEffects, by_batch: bool) -> float:
    """NaN where nothing is dissipated."""
    works = _works_by_batch if by_batch else _works_by_solving
    theory, corrected_work = works(scene, effects)
    return corrected_work / theory - 1 if theory else math.nan


def _works_by_batch(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """Friction work W of a cycle for half-planes and for finite bodies with elastic responses
    `effects`, by the quick formula for elliptical load paths. InputError where the loads have no W.
    """
    import semi_analytic

    load = scene.load
    assert isinstance(load, EllipseLoad)  # for the type checker: see `takes_batch`

    def work_with(body_effects: BodyEffects | None) -> float:
        """W with what these bodies add to half-planes; of half-planes for None."""
        batch = semi_analytic.dissipation(
            profile=scene.profile,
            material=scene.material,
            friction_coefficient=scene.friction.coefficient,
            mean_normal_load=load.mean_normal_load,
            normal_amplitude=load.normal_amplitude,
            mean_tangential_load=load.mean_tangential_load,
            tangential_amplitude=load.tangential_amplitude,
            phase_degrees=load.phase_degrees,
            effects=body_effects,
        )
        return float(batch.value)

    work_of_half_planes = work_with(None)
    if math.isnan(work_of_half_planes):
        semi_analytic.solve(scene, x=0.0, fields=(WORK,))  # raises the sentence that says why
    return work_of_half_planes, work_with(effects)


def _works_by_solving(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
    """Friction work W of a cycle for half-planes and for finite bodies, each by a solution of
    theory.
    """
    import semi_analytic

    solution_of_half_planes = semi_analytic.solve(scene, x=0.0, fields=(WORK,))
    solution_of_bodies = semi_analytic.solve(scene, x=0.0, effects=effects, fields=(WORK,))
    return solution_of_half_planes.dissipation, solution_of_bodies.dissipation


def _difference_of_peak(scene: Scene, effects: BodyEffects) -> float:
    """Largest pressure of finite bodies over that of half-planes, minus 1, for a parabola: p0 =
    sqrt(P E* (1/R + N P + N_Q Q)/pi), N and N_Q the curvatures of the bodies' faces per load. NaN
    for other profiles. `effects` are the elastic responses that finite bodies add to half-planes.
    """
    profile = scene.profile
    if not isinstance(profile, Hertz):
        return math.nan
    normal_load, tangential_load = _loads_of_last_cycle(scene)
    added_curvature = effects.normal_curvature.value * normal_load
    added_curvature = added_curvature + effects.normal_curvature_under_shear.value * tangential_load
    pressure_squared = normal_load * (1 + profile.radius * added_curvature)
    return math.sqrt(float(np.max(pressure_squared) / np.max(normal_load))) - 1


def _loads_of_last_cycle(scene: Scene) -> tuple[Array, Array]:
    """Normal and tangential loads P and Q of the last cycle, or of the whole path where nothing
    repeats: at the rows of a record, else at the turning points of P and at samples between them.
    """
    if isinstance(scene.load, TimeSeriesLoad):
        rows = scene.load.series()
        return rows[:, 1], rows[:, 2]
    path = scene.load.path()
    loads = []
    for segment in path.cycle or path.initial_loading:
        times = np.union1d(sampled(segment, 129), segment.turning_points(NORMAL_LOAD))
        loads.append(np.array(segment.loads(times)))
    normal_load, tangential_load = np.concatenate(loads, axis=1)
    return normal_load, tangential_load


# ------------------------------------------------------------------------------------------- draws
def draws_of_work(scene: Scene, reason: str) -> Draws | None:
    """Friction work W for random draws of the inputs: normal, with the stated correlations, the
    same in each run. None for long records, prescribed displacements, bulk stress and tilt, whose
    draws take too long.

    `reason` says why draws are needed.
    """
    entries = scene.inputs
    if scene.load.is_driven or scene.unsymmetric or _is_long(scene):
        return None
    is_ellipse = isinstance(scene.load, EllipseLoad)
    moves_compound_profile = isinstance(scene.profile, Compound) and any(
        uncertain_input.key.startswith("profile.") for uncertain_input in entries
    )
    # ellipses are solved in one batch; others, and profiles of several parts, one by one
    count = DRAWS if is_ellipse and not moves_compound_profile else FEW_DRAWS
    samples = samples_of(scene, count)
    values_of = values_of_ellipses if is_ellipse else values_one_by_one
    values, slides = values_of(scene, samples)
    sliding_share = float(np.mean(slides))
    return Draws(
        count=count,
        sliding=sliding_share,
        impossible=float(np.mean(~np.isfinite(values[WORK]))) - sliding_share,
        values={key: _statistics_of(drawn_values) for key, drawn_values in values.items()},
        reason=reason,
    )


def _statistics_of(values: Array) -> Drawn:
    """Mean, deviation and 95 % range of the values of random draws (n,); those without a value
    (NaN) are left out.
    """
    known_values = values[np.isfinite(values)]
    if len(known_values) < 2:
        return Drawn(math.nan, math.nan, math.nan, math.nan)
    lower_bound, upper_bound = np.quantile(known_values, (0.025, 0.975)).tolist()
    return Drawn(
        float(known_values.mean()), float(known_values.std(ddof=1)), lower_bound, upper_bound
    )


def samples_of(scene: Scene, count: int) -> dict[str, Array]:
    """Changes of the inputs, (count,) each, by key."""
    assert scene.uncertainty is not None  # there are inputs
    entries = scene.inputs
    values, vectors = np.linalg.eigh(scene.uncertainty.correlation_matrix())
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    independent = np.random.default_rng(_SEED).standard_normal((len(entries), count))
    samples = root @ independent
    return {
        uncertain_input.key: uncertain_input.standard * row
        for uncertain_input, row in zip(entries, samples, strict=True)
    }


def values_of_ellipses(
    scene: Scene, samples: Mapping[str, Array]
) -> tuple[dict[str, Array], Array]:
    """The dissipation, and where known the permanent stick half-width, for n random draws of the
    inputs under an elliptical load path, solved in one batch. Returned: values by name, (n,) each,
    NaN where a draw has none; and which draws slide as a whole, (n,).

    `samples` holds the relative change of each input, (n,) by its key. The half-width is known
    where the profile is a parabola or is not changed. W of E*, P and Q is W of E*_0, P E*_0/E* and
    Q E*_0/E*, times E*/E*_0; half-widths are the same.
    """
    import semi_analytic
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.profiles import contact_of

    n_draws = len(next(iter(samples.values())))
    ones = np.ones(n_draws)

    def factor(key: str) -> Array:
        return 1 + samples[key] if key in samples else ones

    modulus_factor = ones
    if any(key.startswith("material.") for key in samples):
        modulus_factor = _moduli(scene, samples) / composite_modulus(scene.material)
    load = scene.load
    assert isinstance(load, EllipseLoad)  # for the type checker: others take no batch
    normal_factor = factor("normal_load") / modulus_factor
    tangential_factor = factor("tangential_load") / modulus_factor
    profile: Any = scene.profile
    if any(key.startswith("profile.") or key.endswith(".radius") for key in samples):
        profile = _profiles(scene, samples)
    batch = semi_analytic.dissipation(
        profile=profile,
        material=scene.material,
        friction_coefficient=scene.friction.coefficient * factor("friction"),
        mean_normal_load=load.mean_normal_load * normal_factor,
        normal_amplitude=load.normal_amplitude * normal_factor,
        mean_tangential_load=load.mean_tangential_load * tangential_factor,
        tangential_amplitude=load.tangential_amplitude * tangential_factor,
        phase_degrees=load.phase_degrees + samples.get("phase_degrees", 0.0),
    )
    # W of the scaled loads at the stated E*, back to that of the draw
    values = {WORK: batch.value * modulus_factor}
    stick_load = batch.permanent_stick_load
    if profile is scene.profile:
        contact = contact_of(scene.profile, scene.material)
        has_value = np.isfinite(stick_load)
        stick_half_width = contact.half_width(np.where(has_value, stick_load, 0.0))
        values[STICK] = np.where(has_value, stick_half_width, np.nan)
    elif isinstance(scene.profile, Hertz):
        width_squared_per_load = (
            4 * profile["radius"] / (math.pi * composite_modulus(scene.material))
        )
        values[STICK] = np.sqrt(width_squared_per_load * stick_load)
    return values, batch.reason == semi_analytic.Reason.SLIDING


def _moduli(scene: Scene, samples: Mapping[str, Array]) -> Array:
    """Composite modulus E* of n random draws, (n,): 1/E* = (1 − nu_l^2)/E_l + (1 − nu_u^2)/E_u. NaN
    where nu is not below 0.5. `samples` holds the relative change of each input, (n,) by its key.
    """
    compliance: Array = np.zeros(len(next(iter(samples.values()))))
    for body in ("lower", "upper"):
        material = getattr(scene.material, body)
        constants: dict[str, Array] = {}
        for name in ("young_modulus", "poisson_ratio"):
            change_of_body = samples.get(f"material.{body}.{name}", np.zeros(()))
            change = samples.get(f"material.{name}", change_of_body)
            constants[name] = getattr(material, name) * (1 + change)
        poisson_ratio = np.where(
            np.abs(constants["poisson_ratio"]) < 0.5, constants["poisson_ratio"], np.nan
        )
        compliance = compliance + (1 - poisson_ratio**2) / constants["young_modulus"]
    return np.asarray(1 / compliance)


def _profiles(scene: Scene, samples: Mapping[str, Array]) -> dict[str, Any]:
    """The scene's profile for all random draws at once: its keys, with an array (n,) in place of
    the number of each key that is uncertain. `samples` holds the relative change of each input by
    key.
    """
    keys = scene.profile.model_dump()
    for key, change in samples.items():
        if key.startswith("profile."):
            name = key.removeprefix("profile.")
            keys[name] = keys[name] * (1 + change)
    curvature: Any = 0.0
    for body in ("lower", "upper"):
        shape = getattr(scene.bodies, body)
        if isinstance(shape, Cylinder):
            change = samples.get(f"bodies.{body}.radius", np.zeros(()))
            curvature = curvature + 1 / (shape.radius * (1 + change))
    if scene.bodies.relative_radius() is not None:
        keys["radius"] = 1 / curvature
    return {name: value for name, value in keys.items() if value is not None}


def values_one_by_one(scene: Scene, samples: Mapping[str, Array]) -> tuple[dict[str, Array], Array]:
    """W and permanent stick half-width of all draws, (n,) each, NaN where a draw has none; and
    which draws slide, (n,). Each draw is solved; `samples` holds the relative change of each input.
    """
    import semi_analytic

    n_draws = len(next(iter(samples.values())))
    values = {WORK: np.full(n_draws, np.nan), STICK: np.full(n_draws, np.nan)}
    slides = np.zeros(n_draws, dtype=bool)
    for draw in range(n_draws):
        try:
            moved_scene = scene.moved(
                {key: float(changes[draw]) for key, changes in samples.items()}
            )
            solution = semi_analytic.solve(moved_scene, x=0.0, fields=(WORK,))
        except InadmissibleLoadError:
            slides[draw] = True
        except InputError:  # no scene can have these inputs: counted by its NaN
            continue
        else:
            values[WORK][draw] = solution.dissipation
            values[STICK][draw] = solution.permanent_stick_half_width
    return values, slides


# ---------------------------------------------------------------------------------- the whole of it
def input_effects(scene: Scene, effects: BodyEffects | None = None) -> InputEffects | None:
    """What the stated uncertainties of the inputs do to a scene's answer; None where none is
    stated. Where theory does not take the scene the answer says why.

    Parameters
    ----------
    effects
        what the bodies add to half-planes, where it is known already

    Examples
    --------
    >>> from scenes import load_scene
    >>> known = {"friction": "5 %", "tangential_load": "2 %"}
    >>> found = input_effects(load_scene("cattaneo-mindlin").vary(uncertainty=known))
    >>> round(
    ...     100
    ...     * found.values["dissipation"].changes["tangential_load"].value
    ...     / found.values["dissipation"].value,
    ...     1,
    ... )
    7.1
    """
    if not scene.inputs:
        return None
    assert scene.uncertainty is not None
    scene_solved = with_blocks(scene)
    if reason := _no_values(scene_solved):
        return InputEffects(scene.inputs, scene.uncertainty.correlations, unknown=reason)
    try:
        effects_of_inputs = _input_effects(scene_solved, effects)
        if scene_solved is scene:
            return effects_of_inputs
        return replace(effects_of_inputs, notes=(*effects_of_inputs.notes, _BLOCKS_FOR_PADS))
    except (InputError, ConvergenceError) as fault:
        return InputEffects(
            scene.inputs,
            scene.uncertainty.correlations,
            sliding=None if scene.load.is_driven else sliding_of_loads(scene),
            unknown=str(fault),
        )


def _input_effects(scene: Scene, effects: BodyEffects | None) -> InputEffects:
    """What the uncertainties of the inputs do to the values of theory and, where it is known, to
    the difference that real bodies make. Random draws are added where derivatives are not enough.

    `effects` are elastic responses of the scene's bodies, None where they are not known yet.

    Raises
    ------
    InputError, ConvergenceError
        Where theory does not take the scene, or does not converge, at the stated inputs.
    """
    assert scene.uncertainty is not None
    correlation = scene.uncertainty.correlation_matrix()
    notes: list[str] = []
    quantities = OF_DRIVEN if scene.load.is_driven else QUANTITIES_OF_THEORY

    def effects_of(changed_scene: Scene) -> BodyEffects | None:
        return _effects_of_driven(changed_scene, scene, effects)

    values_at_inputs = values_of_theory(scene, effects_of(scene))
    values = {}
    reason_for_draws = ""
    try:
        changes_by_inputs = changes_of_theory(scene, values_at_inputs, effects_of)
    except InadmissibleLoadError:
        changes_by_inputs = [
            _unknown(uncertain_input, values_at_inputs) for uncertain_input in scene.inputs
        ]
        reason_for_draws = "a sixteenth of a standard uncertainty makes the loads slide"
    for key, value in values_at_inputs.items():
        values[key] = propagated(quantities[key], value, changes_by_inputs, key, correlation)
    notes += _notes_on_values(scene)
    sliding = None if scene.load.is_driven else sliding_of_loads(scene)
    if RATIO in values:
        ratio = propagated(
            quantities[RATIO], values_at_inputs[RATIO], _away(changes_by_inputs), RATIO, correlation
        )
        values[RATIO] = ratio
        sliding = NearSliding(ratio.value, ratio.uncertainty)
    reason_for_draws = reason_for_draws or _near_sliding(sliding)
    second_order = _large_second_order(values)
    draws = None
    if reason_for_draws or second_order:
        draws = draws_of_work(scene, reason_for_draws or second_order)
        if draws is None:
            notes.append(_no_draws(reason_for_draws, second_order, sliding))
    difference, no_difference = _difference_or_reason(scene, effects, correlation)
    return InputEffects(
        inputs=scene.inputs,
        correlations=scene.uncertainty.correlations,
        values=values,
        difference=difference,
        no_difference=no_difference,
        draws=draws,
        sliding=sliding,
        notes=tuple(notes),
    )


def _no_draws(reason: str, second_order: str, sliding: NearSliding | None) -> str:
    """The note of draws that are not taken; what other sentences say is left out."""
    words = "draws of this load take too long"
    if reason and not (sliding is not None and sliding.is_in_reach):
        words = f"{reason}; {words}"
    # A large second order stands in the list of rough values.
    return words if second_order else f"derivatives may not be enough: {words}"


def _away(changes_by_inputs: Sequence[_ChangeByInput]) -> list[_ChangeByInput]:
    """The change of |Q|/(f P), the nearness to gross sliding, by one standard uncertainty of each
    input. The ratio stops at 1, where the bodies slide, so each input counts by the larger of its
    changes up and down.
    """
    one_sided = []
    for change_by_input in changes_by_inputs:
        size, second_order = change_by_input.changes[RATIO]
        change = math.copysign(abs(size) + second_order, size)
        one_sided.append(
            _ChangeByInput(change_by_input.key, {RATIO: Estimate(change, second_order)})
        )
    return one_sided


def _unknown(uncertain_input: Input, values_at_inputs: _Values) -> _ChangeByInput:
    """Not-a-number in place of the changes of all values by one uncertain input, which could not be
    found.
    """
    return _ChangeByInput(
        uncertain_input.key, dict.fromkeys(values_at_inputs, Estimate(math.nan, math.nan))
    )


def _effects_of_driven(
    changed_scene: Scene, scene: Scene, effects: BodyEffects | None
) -> BodyEffects | None:
    """Elastic responses of the bodies of `changed_scene`, which theory of a prescribed displacement
    needs: `effects`, those of `scene`, where the bodies are the same; else solved for.

    `changed_scene` is `scene` with other values of its uncertain inputs. None where loads are
    given, or for half-planes.
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


def _difference(
    scene: Scene, effects: BodyEffects | None, correlation: Array
) -> dict[str, Propagated]:
    """The difference of real bodies from half-planes (bodies/half-planes - 1) in the dissipation
    and the largest pressure, by key, each with the standard uncertainty that the inputs give it.

    Parameters
    ----------
    effects
        elastic responses of the bodies beyond those of half-planes; solved for here where None
    correlation
        (n, n) matrix of the inputs
    """
    import halfplane_fe

    if effects is None:
        effects = halfplane_fe.body_effects(scene)
    values_at_inputs, changes_by_inputs = changes_of_difference(scene, effects)
    differences = {}
    for key, value in values_at_inputs.items():
        if math.isfinite(value):
            difference_in_words = f"difference of the {QUANTITIES_OF_THEORY[key].words}"
            quantity = QUANTITIES_OF_THEORY[key]._replace(words=difference_in_words, unit="share")
            differences[key] = propagated(quantity, value, changes_by_inputs, key, correlation)
    return differences


def _difference_or_reason(
    scene: Scene, effects: BodyEffects | None, correlation: Array
) -> tuple[dict[str, Propagated], str]:
    """The error of half-plane theory for the real bodies by name of the value, each with the
    uncertainty that the inputs give it, and ""; or an empty dictionary, and the reason why it is
    not known. `correlation` (n, n) is that of the n inputs. `effects` are the elastic responses
    that finite bodies add to half-planes, where known.
    """
    reason = _no_difference(scene)
    if reason:
        return {}, reason
    try:
        return _difference(scene, effects, correlation), ""
    except InputError as fault:
        return {}, str(fault)


def _notes_on_values(scene: Scene) -> list[str]:
    """A note where some values of theory are left out, since they take too long; else none."""
    left_out_in_words = "the largest pressure, the slip and the edge tension are left out"
    if _is_long(scene):
        return [f"of a record of more than {_LONG_RECORD:,} rows {left_out_in_words}"]
    if _needs_grids(scene):
        return [f"where theory needs grids {left_out_in_words}"]
    return []


def _near_sliding(sliding: NearSliding | None) -> str:
    """Why derivatives by the inputs are not enough for the uncertainty of the work W: gross sliding
    is near; "" where it is not.
    """
    if sliding is None or not 0 < sliding.distance < _NEAR_SLIDING:
        return ""
    return f"gross sliding is {sliding.distance:.2g} standard uncertainties of |Q|/(f P) away"


def _large_second_order(values: Mapping[str, Propagated]) -> str:
    """Why derivatives by the inputs are not enough for the uncertainty of the work W: the second
    order is a large share of it; "" where it is not.
    """
    work = values[WORK]
    if work.uncertainty and not work.is_nearly_linear:
        share = 100 * work.second_order / work.uncertainty
        return f"the second order is {share:.0f} % of the uncertainty of W"
    return ""


def sliding_of_loads(scene: Scene) -> NearSliding | None:
    """The largest |Q|/(f P) of given loads with its standard uncertainty by the inputs. None
    without friction, and where no input has an uncertainty.
    """
    if not (scene.friction.coefficient and scene.inputs):
        return None
    assert scene.uncertainty is not None
    ratio = nearest_to_sliding(scene).ratio
    changes = []
    for uncertain_input in scene.inputs:
        change = 0.0
        if uncertain_input.key in ("friction", "normal_load"):
            change = -ratio * uncertain_input.standard
        elif uncertain_input.key == "tangential_load":
            change = ratio * uncertain_input.standard
        elif uncertain_input.key == "phase_degrees":
            ratio_above = nearest_to_sliding(
                scene.moved({uncertain_input.key: uncertain_input.standard})
            ).ratio
            ratio_below = nearest_to_sliding(
                scene.moved({uncertain_input.key: -uncertain_input.standard})
            ).ratio
            change = (ratio_above - ratio_below) / 2
        changes.append(change)
    changes_of_ratio = np.array(changes)
    variance = max(
        float(changes_of_ratio @ scene.uncertainty.correlation_matrix() @ changes_of_ratio), 0.0
    )
    return NearSliding(ratio, math.sqrt(variance))
