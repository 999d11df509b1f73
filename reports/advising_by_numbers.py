"""How wrong half-plane theory is for the bodies of a scene, and why, with no contact solved:
corrected theory beside theory.

A linear solve of each body gives what it adds to the compliance of a half-plane
(`halfplane_fe.body_effects`). Theory with all of these numbers, with the curvature under P alone
and with that under Q alone gives the change of the dissipation and its parts::

    W(corrected)/W(theory) - 1 = part of N + part of T + both together

Tilt and bulk strain, which follow the loads, are in theory in the second order, or on grids
(`tilt_and_strain`): their part is added. So

    change = part of N + part of T + both together + part of tilt and bulk strain

Its uncertainty is the sum of

- what the numbers themselves, the steps and the second order or the grids are uncertain by;
- what the orders after the next leave of each part, the next order of tilt and bulk strain, and
  the product of their part with that of the curvatures (`semi_analytic.next_order`, as corrected
  theory states it).

Of unlike materials (Dundurs' beta is not 0) pressure and shear are coupled, which bodies change in
the first order of tilt and bulk strain. No number has that: its size is counted as uncertain, with
that of tilt and bulk strain, and nothing else is stated than a size.

Corrected theory shares mesher and elements with the finite elements: it explains what they give,
and is no check of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from meshes import MeshSettings
from reports.comparison.laws import QUANTITIES
from reports.comparison.pairs import coupled
from reports.comparison.verdicts import Verdict, verdict_on
from reports.comparison.why import Why, in_percent
from scenes import (
    Bodies,
    BodyEffects,
    ContactSolution,
    ConvergenceError,
    Estimate,
    InputError,
    Scene,
    scene_of,
)

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from reports.comparison.budget import ErrorBudget
    from reports.comparison.judged import JudgedPair

# Of the second order of what is not symmetric, by f: bulk strain / f^2, both, tilt x f^2. These are
# the largest of six load cycles, and give a size alone: below the least one no grid is solved.
_STRAIN_SQUARED = 1.4
_STRAIN_BY_TILT = 4.4
_TILT_SQUARED = 3.5
_LEAST_ODD_PART = 1e-4
# Of unlike materials, by Dundurs' beta: of half-planes beta^2/f^2, of bodies beta x strain/f^2 and
# beta x tilt. They give a size alone: at least 1.1 times what 38 random pairs leave, and 4 times at
# the median (benchmarks/unlike.py, seed 301).
_COUPLING_SQUARED = 1.6
_STRAIN_BY_COUPLING = 7.0
_TILT_BY_COUPLING = 5.0
# Of the half-width that always sticks, what edges of the first order leave: 0.4 % on grids.
_LEFT_OF_STICK = 5e-3
# Above these the uncertainty is not held to finite elements: its own size, and what tilt and bulk
# strain make.
_MOST_UNCERTAIN = 0.01
_MOST_ODD = 0.05
# Elements of what explains the difference, over those of the finite elements.
_COARSER = 2.0
WORK = "dissipation"
ODD = "tilt and bulk strain"
HIGHER_ORDERS = "higher orders"
COUPLING = "coupling"
FINITE_BODIES = "finite bodies"


class Change(NamedTuple):
    """What the bodies make of a value of half-plane theory.

    Attributes
    ----------
    words
        what the value is
    theory
        of half-planes, theory's own [energy / length, stress or length]
    change
        finite bodies over half-planes, minus 1
    """

    words: str
    theory: float
    change: Estimate


@dataclass(frozen=True)
class Advice:
    """What is expected of finite elements of the bodies of a scene, over half-plane theory.

    Attributes
    ----------
    effects
        the numbers of the bodies
    changes
        by the name of the quantity, all that is uncertain counted; "dissipation" is the first. NaN
        where there is no estimate: of what always sticks where tilt and bulk strain, which move it
        in the first order, are not known in that; of all but the dissipation where the materials
        are unlike, or the size of tilt and bulk strain is more than 5 % of it
    parts
        of the change of the dissipation, by what makes them: they add up to it
    left_out
        size of what tilt and bulk strain make of the dissipation where no grid was solved: where it
        is below 1e-4, or the profile is none that grids take; counted as uncertain. Of unlike
        materials the size of what coupling makes is in it
    limit
        of |change of the dissipation| up to which theory may be used
    declined_by_kernels
        why no kernel solve takes the place of a size alone; empty where none was tried
    """

    scene: Scene
    effects: BodyEffects
    changes: dict[str, Change]
    parts: dict[str, Estimate]
    left_out: float
    limit: float
    declined_by_kernels: str = ""

    def __repr__(self) -> str:
        """The sentence that `halfplane advise` begins with, and the other changes in per cent."""
        changes = [
            f"{change.words} {in_percent(change.change.value)} ± "
            f"{in_percent(change.change.uncertainty).lstrip('+')} %"
            for key, change in self.changes.items()
            if key != WORK and math.isfinite(change.change.value)
        ]
        return f"{sentence(self)}\n  {', '.join(changes)}"

    @property
    def work(self) -> Estimate:
        """Change of the dissipation."""
        return self.changes[WORK].change

    @property
    def declined(self) -> str:
        """Why corrected theory gives only the size of the change by finite bodies, and no
        uncertainty that was checked against finite elements. "" where it gives one.
        """
        if coupled(self.scene):
            return "the materials are unlike (Dundurs' beta is not 0)"
        odd_part = max(abs(self.parts.get(ODD, Estimate(0.0)).value), self.left_out)
        if odd_part > _MOST_ODD:
            return f"tilt and bulk strain make more than {100 * _MOST_ODD:g} % of it"
        if self.work.uncertainty > _MOST_UNCERTAIN:
            return f"the uncertainty is above {100 * _MOST_UNCERTAIN:g} %"
        return ""

    @property
    def verdict(self) -> Verdict:
        """Of the change of the dissipation on the limit; never within where `declined`."""
        verdict = verdict_on(self.work.value, self.limit, self.work.uncertainty)
        if self.declined and verdict is Verdict.WITHIN:
            return Verdict.UNDECIDED
        return verdict


def advise_by_numbers(
    scene: Scene | str | Path, limit: float = 0.05, effects: BodyEffects | None = None
) -> Advice:
    """How far finite bodies are from half-plane theory, by theory that is corrected with the
    elastic responses that bodies add to half-planes: curvatures of the faces per load, tilt, bulk
    strain.

    Tilt and bulk strain are the odd part: at -x they do the opposite of what they do at x. The
    curvatures are the even part.

    Parameters
    ----------
    scene
        a scene, the name of one in the library, or a file
    limit
        share of the dissipation up to which theory may be used
    effects
        the responses, where they are known already

    Raises
    ------
    InputError
        Where the responses are of no use: curved faces, unlike half-planes, bulk stress, profiles
        that are not symmetric; where theory dissipates nothing.
    """
    import halfplane_fe
    import semi_analytic
    from semi_analytic.next_order import (
        LEAST_UNCERTAIN_FRACTION,
        ratio_of_next_order,
        uncertain_fraction_of_curvatures,
    )

    scene = scene_of(scene)
    is_coupled = coupled(scene)
    if is_coupled and scene.bodies.half_planes:
        raise InputError(
            f"{scene.name}: the bodies are half-planes of unlike materials (Dundurs' beta is not"
            " 0), to which no body adds anything; solve the scene with finite elements"
            " (`halfplane run`)"
        )
    if effects is None:
        effects = halfplane_fe.body_effects(scene)
    theory = semi_analytic.solve(scene, fields=(WORK, "pressure"))
    if not theory.dissipation:
        raise InputError(
            f"{scene.name}: half-plane theory dissipates nothing: no error is relative to it"
        )
    corrected_solution = semi_analytic.solve(
        scene, x=theory.x, time=theory.time, effects=_even(effects), fields=(WORK, "pressure")
    )
    largest_values = semi_analytic.extremes(theory)
    half_width = largest_values.half_width
    own_values = {"peak_pressure": largest_values.pressure, "half_width": half_width}
    uncertainties = uncertain_fraction_of_curvatures(effects, half_width)
    ratio = ratio_of_next_order(effects, half_width)
    parts = _parts(effects, theory, corrected_solution, uncertainties)
    odd_share = _size_of_odd_part(effects, scene, half_width)
    left_out = odd_share  # until the odd part is followed itself
    if is_coupled:
        left_out += _size_of_coupling(effects, scene, half_width)
    elif left_out > _LEAST_ODD_PART:
        even_part = sum(part.value for part in parts.values())
        odd_change = _odd_part_of_work(effects, scene, even_part, ratio)
        if odd_change is not None:
            parts[ODD] = odd_change
            left_out = 0.0
    changes = {}
    for key, (name, words) in _VALUES.items():
        theory_value = QUANTITIES[name].of(theory)
        change = QUANTITIES[name].of(corrected_solution) / theory_value - 1
        uncertainty = abs(change) * max(uncertainties.values())
        if key == WORK:
            change = sum(part.value for part in parts.values())
            uncertainty = sum(part.uncertainty for part in parts.values()) + left_out
            estimate = Estimate(change, uncertainty + LEAST_UNCERTAIN_FRACTION)
        elif is_coupled or odd_share > _MOST_ODD:
            # coupling, or a large tilt, moves it by an amount that is not known
            estimate = Estimate(math.nan, math.nan)
        elif odd_share > 0 and key == "permanent_stick":
            estimate = _change_of_stick(scene, effects, theory_value, uncertainty)
        else:
            estimate = Estimate(change, uncertainty + LEAST_UNCERTAIN_FRACTION)
        changes[key] = Change(words, own_values.get(key, theory_value), estimate)
    return Advice(scene, effects, changes, parts, left_out, limit)


def _odd_part_of_work(
    effects: BodyEffects, scene: Scene, even_part: float, ratio: float
) -> Estimate | None:
    """The change of the dissipation W by the tilt and the bulk strain of finite bodies under the
    loads, relative to W of half-plane theory, with its uncertainty. None where no method of theory
    follows them in this scene.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    even_part
        relative change of W by what bends the faces symmetrically
    ratio
        size of the neglected next term in the series of the bodies' responses, over the first term
    """
    import semi_analytic
    from semi_analytic.next_order import uncertain_fraction_of_tilt_and_strain

    try:
        odd_change = semi_analytic.change_by_tilt_and_strain(scene, effects)
    except InputError:
        return None
    uncertainty_left = uncertain_fraction_of_tilt_and_strain(even_part, ratio) * abs(
        odd_change.value
    )
    return Estimate(odd_change.value, odd_change.uncertainty + uncertainty_left)


def _change_of_stick(
    scene: Scene, effects: BodyEffects, theory_value: float, uncertainty: float
) -> Estimate:
    """Relative change of the permanent stick half-width by finite bodies, with tilt and bulk strain
    to first order; NaN where that does not hold.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    theory_value
        the half-width by half-plane theory [length]
    uncertainty
        relative uncertainty of the change by the curvatures of the faces
    """
    import semi_analytic
    from semi_analytic.odd_memory import Declined, odd_answer

    try:
        odd_answer(scene, effects)
    except Declined:
        return Estimate(math.nan, math.nan)
    # edges alone: no work is followed again
    corrected_half_width = semi_analytic.solve(
        scene, x=0.0, cycles="steady", effects=effects, fields="pressure"
    ).permanent_stick_half_width
    return Estimate(corrected_half_width / theory_value - 1, uncertainty + _LEFT_OF_STICK)


def split(comparison: JudgedPair, budget: ErrorBudget | None) -> Why:
    """Split the difference of the dissipation W between finite elements of real bodies and
    half-plane theory into its causes. Not split, with the reason, where W was not compared, no
    method for these bodies finds the causes, or a part does not converge or has no error.

    Parameters
    ----------
    comparison
        of finite elements with half-plane theory, W with its uncertainty
    budget
        error budget that states the parts by mesh and load steps; without it they are in what is
        left
    """
    metric = comparison.metric(WORK)
    if metric.value is None or metric.absolute or not math.isfinite(metric.value):
        return Why(Estimate(math.nan, math.nan), not_split="the dissipation was not compared")
    uncertainty = math.nan if metric.uncertainty is None else metric.uncertainty
    total_change = Estimate(metric.value, uncertainty)
    numerical_part = 0.0
    if budget is not None:
        terms = next(row.terms for row in budget.budgets if row.metric.key == WORK)
        numerical_part = sum(term.value or 0.0 for term in terms)
    try:
        # unlike materials: pressure and shear depend on each other
        if coupled(comparison.scene):
            parts = _parts_of_unlike(comparison)
        elif comparison.scene.bodies.faces_are_true:
            parts = _parts_of_curved(comparison)
        else:
            advice = advise_by_numbers(comparison.scene, effects=comparison.effects)
            parts = _parts_of_alike(advice, comparison)
    except (InputError, ConvergenceError) as reason:
        return Why(total_change, not_split=str(reason))
    parts_without_estimate = [
        words for words, part in parts.items() if math.isnan(part.uncertainty)
    ]
    if parts_without_estimate:
        return Why(
            total_change,
            not_split=f"on this mesh the error of {' and of '.join(parts_without_estimate)} has no"
            " estimate; a finer mesh splits it",
        )
    return Why(total_change, parts, Estimate(numerical_part))


def _parts_of_alike(advice: Advice, comparison: JudgedPair) -> dict[str, Estimate]:
    """The causes of the change of the dissipation for bodies of like materials with flat faces:
    cause -> relative change with its uncertainty.

    They are those of theory corrected by the bodies' elastic responses (`advice`). Where that gives
    no more than their size, finite elements of half-planes with the whole compliance of the bodies
    are solved: what they find beyond the sum is a further cause.
    """
    parts = dict(advice.parts)
    if not advice.declined:
        if advice.left_out:
            parts[ODD] = Estimate(0.0, advice.left_out)
        return parts
    theory_work = advice.changes[WORK].theory
    work_by_kernels = _work_by_kernels(comparison)
    sum_of_parts = sum(part.value for part in parts.values())
    parts = {cause: Estimate(part.value) for cause, part in parts.items()}
    change_beyond_parts = work_by_kernels.value / theory_work - 1 - sum_of_parts
    parts[HIGHER_ORDERS] = Estimate(change_beyond_parts, work_by_kernels.uncertainty / theory_work)
    return parts


def _parts_of_curved(comparison: JudgedPair) -> dict[str, Estimate]:
    """The one cause of the change of the dissipation for bodies with curved faces, their finite
    size: cause -> relative change with its uncertainty. It is found by finite elements of
    half-planes with the compliance of the bodies added (kernels).

    Raises
    ------
    InputError
        For bodies whose compliance is not known, before anything is solved.
    """
    import semi_analytic

    work_by_kernels = _work_by_kernels(comparison)
    theory_work = semi_analytic.solve(comparison.scene, fields=WORK).dissipation
    change = work_by_kernels.value / theory_work - 1
    return {FINITE_BODIES: Estimate(change, work_by_kernels.uncertainty / theory_work)}


def _parts_of_unlike(comparison: JudgedPair) -> dict[str, Estimate]:
    """The causes of the change of the dissipation for bodies of unlike materials: cause -> relative
    change with its uncertainty.

    Coupling of pressure and shear: half-planes of these materials, by finite elements, against
    theory. Finite size: what half-planes with the compliance of the bodies added (kernels) have
    beyond that.

    Raises
    ------
    InputError
        For bodies whose compliance is not known, before anything is solved.
    """
    import halfplane_fe
    import semi_analytic

    scene = comparison.scene
    work_by_kernels = _work_by_kernels(comparison)
    mesh, settings = _coarser_than(comparison)
    solution_of_half_planes = halfplane_fe.solve(scene.vary(bodies=Bodies()), mesh, settings)
    theory_work = semi_analytic.solve(scene, fields=WORK).dissipation
    change_by_coupling = solution_of_half_planes.dissipation / theory_work - 1
    uncertainty_of_coupling = solution_of_half_planes.dissipation_uncertainty / theory_work
    change_by_bodies = (work_by_kernels.value - solution_of_half_planes.dissipation) / theory_work
    return {
        COUPLING: Estimate(change_by_coupling, uncertainty_of_coupling),
        FINITE_BODIES: Estimate(
            change_by_bodies, work_by_kernels.uncertainty / theory_work + uncertainty_of_coupling
        ),
    }


def _work_by_kernels(comparison: JudgedPair) -> Estimate:
    """W by the kernel solve of the bodies."""
    import halfplane_fe

    mesh, settings = _coarser_than(comparison)
    solution = halfplane_fe.solve(comparison.scene, mesh, settings, bodies="kernel")
    return Estimate(solution.dissipation, solution.dissipation_uncertainty)


def _coarser_than(comparison: JudgedPair) -> tuple[MeshSettings, SolverSettings]:
    """Elements twice as large as those of the finite elements that are compared, and their steps: a
    third of the time, and parts that are uncertain by some 1e-3.
    """
    from halfplane_fe import SolverSettings
    from reports.comparison.budget import coarser

    mesh = MeshSettings(**comparison.result.settings["mesh"])
    return coarser(mesh, SolverSettings(), _COARSER)


# Key of an answer -> the quantity of a solution, whose change is taken on common points, and its
# words.
_VALUES = {
    WORK: ("dissipation", "dissipation"),
    "peak_pressure": ("largest_pressure", "largest pressure"),
    "half_width": ("largest_half_width", "largest contact half-width"),
    "permanent_stick": ("permanent_stick_half_width", "permanent stick half-width"),
}


def _parts(
    effects: BodyEffects,
    theory: ContactSolution,
    corrected_solution: ContactSolution,
    uncertainties: Mapping[str, float],
) -> dict[str, Estimate]:
    """Relative change of the dissipation by each curvature that finite bodies add to half-planes,
    alone: of the gap under P, and of the faces under Q. Beside them what both together make beyond
    their sum.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    theory, corrected_solution
        half-plane theory, and theory with all curvatures
    uncertainties
        relative uncertainty of the change by each curvature
    """
    import semi_analytic
    from semi_analytic.next_order import CURVATURES, with_these_alone

    parts = {}
    change_left = corrected_solution.dissipation / theory.dissipation - 1
    for curvature in CURVATURES:
        effects_alone = with_these_alone(effects, curvature)
        solution = semi_analytic.solve(
            theory.scene, x=0.0, time=theory.time, effects=effects_alone, fields=WORK
        )
        change = solution.dissipation / theory.dissipation - 1
        parts[curvature] = Estimate(change, abs(change) * uncertainties[curvature])
        change_left -= change
    parts["both together"] = Estimate(change_left, abs(change_left) * sum(uncertainties.values()))
    return parts


def _even(effects: BodyEffects) -> BodyEffects:
    """The effects without tilt and bulk strain."""
    from semi_analytic.odd_memory import ODD_NUMBERS

    nothing: dict[str, Any] = dict.fromkeys(ODD_NUMBERS, Estimate(0.0))
    return replace(effects, **nothing)


def _size_of_odd_part(effects: BodyEffects, scene: Scene, half_width: float) -> float:
    """About what tilt and bulk strain make of the dissipation; they count by their squares."""
    tilt, strain = _tilt_and_strain(effects, scene, half_width)
    friction = scene.friction.coefficient
    return (
        _STRAIN_SQUARED * (strain / friction) ** 2
        + _STRAIN_BY_TILT * strain * tilt
        + _TILT_SQUARED * (tilt * friction) ** 2
    )


def _size_of_coupling(effects: BodyEffects, scene: Scene, half_width: float) -> float:
    """About how much the coupling of pressure and shear of unlike materials changes the
    dissipation, relative to it: by the square of Dundurs' beta over f for half-planes, and by its
    product with the bodies' bulk strain and tilt.

    Parameters
    ----------
    effects
        what the bodies add to half-planes
    half_width
        largest half-width of the contact [length]
    """
    from halfplane_fe.dundurs import dundurs

    tilt, strain = _tilt_and_strain(effects, scene, half_width)
    beta = abs(dundurs(scene.material).beta)
    friction = scene.friction.coefficient
    return (
        _COUPLING_SQUARED * (beta / friction) ** 2
        + _STRAIN_BY_COUPLING * beta * strain / friction**2
        + _TILT_BY_COUPLING * beta * tilt
    )


def _tilt_and_strain(effects: BodyEffects, scene: Scene, half_width: float) -> tuple[float, float]:
    """|alpha_P| + |alpha_Q| and |e_P| + |e_Q|, of no dimension."""
    from semi_analytic.corrected import odd_part
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.odd_memory import ODD_NUMBERS

    odd_estimate = odd_part(effects, half_width, composite_modulus(scene.material))
    sizes = {name: abs(size) for name, size in zip(ODD_NUMBERS, odd_estimate, strict=True)}
    tilt = sizes["tilt_under_pressure"] + sizes["tilt_under_shear"]
    strain = sizes["strain_under_pressure"] + sizes["strain_under_shear"]
    return tilt, strain


def sentence(advice: Advice) -> str:
    """The advice in sentences: by how much half-plane theory is expected to err in the dissipation,
    what makes the error, whether that is within the limit, and what to do.
    """
    change = advice.work
    causes_in_words = [
        f"{first_words} {in_percent(change_by_cause.value)}"
        for first_words, change_by_cause in advice.parts.items()
    ]
    first_words = (
        f"Half-plane theory is expected to err by {in_percent(change.value)}"
        f" ± {in_percent(change.uncertainty).lstrip('+')} % in the dissipation"
        f" (finite elements/theory − 1): {', '.join(causes_in_words)}"
    )
    if advice.left_out:
        size_left_out = in_percent(advice.left_out).lstrip("+")
        causes_left_out = "tilt and bulk strain"
        if coupled(advice.scene):
            causes_left_out = "coupling of pressure and shear, tilt and bulk strain"
        first_words += f"; {causes_left_out} are left out, and counted as ± {size_left_out} %"
    if advice.declined:
        first_words += f". That is no more than its size: {advice.declined}"
    return f"{first_words}. {_what_to_do(advice)}"


def _what_to_do(advice: Advice) -> str:
    """A sentence on whether the expected error of half-plane theory is within the limit, and what
    to do: use theory, correct it, or solve the scene.
    """
    limit_in_words = f"the limit of {100 * advice.limit:g} %"
    advice_to_solve = "solve the scene (`halfplane run`)"
    if advice.declined and not advice.declined_by_kernels:
        # flat faces, or the numbers would not be there: their kernels have every order
        advice_to_solve += (
            ', or its kernels in 1 to 5 s (Python: `halfplane_fe.solve(scene, bodies="kernel")`)'
        )
    if advice.verdict is Verdict.WITHIN:
        return f"That is within {limit_in_words}: theory may be used."
    if advice.verdict is Verdict.UNDECIDED:
        return f"Whether it is within {limit_in_words} is undecided: {advice_to_solve}."
    odd_estimate = advice.parts.get(ODD, Estimate(0.0))
    if advice.declined or max(advice.left_out, abs(odd_estimate.value)) > advice.limit / 2:
        return f"It is outside {limit_in_words}: {advice_to_solve}."
    return (
        f"That is outside {limit_in_words}: correct theory (`halfplane exact --corrected`), or"
        " solve the scene (`halfplane run`)."
    )
