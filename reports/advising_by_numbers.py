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
from reports.comparison.laws import QUANTITIES, Verdict, verdict_on
from reports.comparison.pairs import has_coupled_tractions
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
    from reports.comparison.metrics import JudgedPair

# Change of the dissipation in the second order of tilt and bulk strain: factors of (strain/f)^2,
# strain x tilt, (tilt f)^2. They are the largest of six load cycles, and give a size alone. Below
# the least size no grid is solved.
_STRAIN_SQUARED = 1.4
_STRAIN_BY_TILT = 4.4
_TILT_SQUARED = 3.5
_LEAST_ODD_PART = 1e-4
# Change of the dissipation by coupling of unlike materials: factors of (beta/f)^2 for half-planes,
# of beta strain/f^2 and beta tilt for bodies, with Dundurs' beta. They give a size alone: at least
# 1.1 times what 38 random pairs leave, and 4 times at the median (benchmarks/unlike.py, seed 301).
_COUPLING_SQUARED = 1.6
_STRAIN_BY_COUPLING = 7.0
_TILT_BY_COUPLING = 5.0
# Relative error of the permanent stick half-width with tilt and bulk strain in the first order:
# 0.4 % against grids.
_RELATIVE_ERROR_OF_STICK = 5e-3
# The uncertainty of corrected theory was checked against finite elements up to these values: of the
# uncertainty itself, and of the change of the dissipation by tilt and bulk strain.
_LARGEST_CHECKED_UNCERTAINTY = 0.01
_LARGEST_CHECKED_ODD_PART = 0.05
# Size of the elements that explain the difference, over that of the finite elements.
_ELEMENT_SIZE_RATIO = 2.0
WORK = "dissipation"
ODD_PART = "tilt and bulk strain"
HIGHER_ORDERS = "higher orders"
COUPLING = "coupling"
FINITE_BODIES = "finite bodies"


class Change(NamedTuple):
    """What the bodies make of a value of half-plane theory.

    Attributes
    ----------
    name
        of the value, in words
    theory_value
        of half-planes, theory's own [energy / length, stress or length]
    relative_change
        finite bodies over half-planes, minus 1: over theory's value of itself, also of permanent
        stick, which the metrics of a comparison state over a_ref
    """

    name: str
    theory_value: float
    relative_change: Estimate


@dataclass(frozen=True)
class Advice:
    """What is expected of finite elements of the bodies of a scene, over half-plane theory.

    Attributes
    ----------
    effects
        elastic responses that the bodies add to half-planes
    changes
        quantity -> its change with its whole uncertainty; "dissipation" is the first. NaN where
        there is no estimate: of the permanent stick half-width, where tilt and bulk strain move it
        by an amount that is not known; of all but the dissipation where the materials are unlike,
        or tilt and bulk strain change it by more than 5 %
    parts
        cause -> its part of the change of the dissipation; they add up to it
    neglected_part
        size of the change of the dissipation by tilt and bulk strain where they were not followed:
        the size is below 1e-4, or no method takes the profile. For unlike materials it holds the
        size of the change by coupling too. It is counted as uncertainty
    limit
        of |change of the dissipation| up to which theory may be used
    refusal_of_kernels
        why the kernel solve does not take the scene, where corrected theory gives a size alone; ""
        where it was not tried
    """

    scene: Scene
    effects: BodyEffects
    changes: dict[str, Change]
    parts: dict[str, Estimate]
    neglected_part: float
    limit: float
    refusal_of_kernels: str = ""

    def __repr__(self) -> str:
        """The sentence that `halfplane advise` begins with, and the other changes in per cent."""
        changes = [
            f"{change.name} {in_percent(change.relative_change.value)} ± "
            f"{in_percent(change.relative_change.uncertainty).lstrip('+')} %"
            for key, change in self.changes.items()
            if key != WORK and math.isfinite(change.relative_change.value)
        ]
        return f"{advice_in_words(self)}\n  {', '.join(changes)}"

    @property
    def work(self) -> Estimate:
        """Change of the dissipation."""
        return self.changes[WORK].relative_change

    @property
    def reason_for_size_alone(self) -> str:
        """The reason why corrected theory gives only the size of the change by finite bodies, and
        no uncertainty that was checked against finite elements. "" where it gives one.

        `parts` holds the change by tilt and bulk strain, where it is known, under ODD_PART;
        `neglected_part` is its estimated size where it is not known; `work` is the change of the
        dissipation.
        """
        if has_coupled_tractions(self.scene):
            return "the materials are unlike (Dundurs' beta is not 0)"
        # Checked up to a change of 5 % by tilt and bulk strain, and an uncertainty of 1 %.
        # Estimate: a value with its uncertainty
        size_of_odd_part = max(
            abs(self.parts.get(ODD_PART, Estimate(0.0)).value), self.neglected_part
        )
        if size_of_odd_part > _LARGEST_CHECKED_ODD_PART:
            return (
                f"tilt and bulk strain make more than {100 * _LARGEST_CHECKED_ODD_PART:g} % of it"
            )
        if self.work.uncertainty > _LARGEST_CHECKED_UNCERTAINTY:
            return f"the uncertainty is above {100 * _LARGEST_CHECKED_UNCERTAINTY:g} %"
        return ""

    @property
    def verdict(self) -> Verdict:
        """Whether the change of the dissipation is within the limit; undecided in place of within
        where only its size is known.
        """
        verdict = verdict_on(self.work.value, self.limit, self.work.uncertainty)
        if self.reason_for_size_alone and verdict is Verdict.WITHIN:
            return Verdict.UNDECIDED
        return verdict


class _SolvedTheory(NamedTuple):
    """Half-plane theory of a scene, and theory corrected with the curvatures of the bodies' faces.

    Attributes
    ----------
    theory, corrected
        both solutions, at the same points and instants
    largest_pressure, half_width
        largest values by theory over all x and instants [stress], [length]
    uncertain_fraction_by_curvature
        "curvature under P" or "curvature under Q" -> relative uncertainty of the change by it
    """

    theory: ContactSolution
    corrected: ContactSolution
    largest_pressure: float
    half_width: float
    uncertain_fraction_by_curvature: Mapping[str, float]


class _PartsOfWork(NamedTuple):
    """The relative change of the dissipation by its causes, as far as they are known.

    Attributes
    ----------
    by_cause
        cause -> its part of the change, with its uncertainty
    neglected_part
        size of the change by causes that were not followed
    size_of_odd_part
        about the change by tilt and bulk strain, followed or not
    """

    by_cause: dict[str, Estimate]
    neglected_part: float
    size_of_odd_part: float


def advise_by_numbers(
    scene: Scene | str | Path, limit: float = 0.05, effects: BodyEffects | None = None
) -> Advice:
    """How far finite bodies are from half-plane theory, by theory that is corrected with the
    elastic responses that bodies add to half-planes (`effects`): curvatures of the faces per load,
    tilt, bulk strain.

    The displacements by curvature are even in x (a parabola), those by tilt and bulk strain odd (a
    straight line): hence the even and the odd part of a change.

    Parameters
    ----------
    scene
        a scene, the name of one in the library, or a file
    limit
        of |change of the dissipation|, relative, up to which theory may be used
    effects
        the responses, where they are known already; None: they are computed

    Raises
    ------
    InputError
        Where the responses are of no use: curved faces, unlike half-planes, bulk stress, profiles
        that are not symmetric; where theory dissipates nothing.
    """
    import halfplane_fe

    scene = scene_of(scene)
    # Unlike materials: pressure and shear depend on each other.
    if has_coupled_tractions(scene) and scene.bodies.half_planes:
        raise InputError(
            f"{scene.name}: the bodies are half-planes of unlike materials (Dundurs' beta is not"
            " 0), to which no body adds anything; solve the scene with finite elements"
            " (`halfplane run`)"
        )
    if effects is None:
        effects = halfplane_fe.body_effects(scene)
    solved_theory = _theory_and_corrected(scene, effects)
    parts = _parts_of_work(scene, effects, solved_theory)
    changes = _changes_of_values(scene, effects, solved_theory, parts)
    return Advice(scene, effects, changes, parts.by_cause, parts.neglected_part, limit)


def _theory_and_corrected(scene: Scene, effects: BodyEffects) -> _SolvedTheory:
    """Solve a scene by half-plane theory, and by theory with the curvatures that the bodies' faces
    take under load (`effects`). Tilt and bulk strain are left out. InputError where theory
    dissipates nothing, so that no change is relative to it.
    """
    import semi_analytic
    from semi_analytic.next_order import uncertain_fraction_of_curvatures

    # WORK: "dissipation"
    theory = semi_analytic.solve(scene, fields=(WORK, "pressure"))
    if not theory.dissipation:
        raise InputError(
            f"{scene.name}: half-plane theory dissipates nothing: no error is relative to it"
        )
    corrected_solution = semi_analytic.solve(
        scene,
        x=theory.x,
        time=theory.time,
        effects=_without_tilt_and_strain(effects),
        fields=(WORK, "pressure"),
    )
    # over all x and instants, not only on the points of the solution
    largest_values = semi_analytic.extremes(theory)
    half_width = largest_values.half_width
    return _SolvedTheory(
        theory,
        corrected_solution,
        largest_values.pressure,
        half_width,
        uncertain_fraction_of_curvatures(effects, half_width),
    )


def _parts_of_work(
    scene: Scene, effects: BodyEffects, solved_theory: _SolvedTheory
) -> _PartsOfWork:
    """The relative change of the dissipation by each curvature of the bodies' faces, by both
    together, and by tilt and bulk strain (the odd part).

    The odd part is neglected where it is below 1e-4, where theory cannot follow it in this scene,
    and for unlike materials. There the coupling of pressure and shear is neglected too. What is
    neglected is stated by its size. `effects` are the elastic responses that the bodies add to
    half-planes. `solved_theory` holds half-plane theory, and theory with the curvatures alone.
    """
    from semi_analytic.next_order import ratio_of_next_order

    half_width = solved_theory.half_width
    by_cause = _parts_by_curvatures(
        effects,
        solved_theory.theory,
        solved_theory.corrected,
        solved_theory.uncertain_fraction_by_curvature,
    )
    size_of_odd_part = _size_of_odd_part(effects, scene, half_width)
    neglected_part = size_of_odd_part  # unless the odd part is followed below
    if has_coupled_tractions(scene):
        neglected_part += _size_of_coupling(effects, scene, half_width)
    # _LEAST_ODD_PART: a change of 1e-4
    elif neglected_part > _LEAST_ODD_PART:
        even_part = sum(part.value for part in by_cause.values())
        # fourth order over curvature in the bodies' responses
        next_order_ratio = ratio_of_next_order(effects, half_width)
        odd_part = _odd_part_of_work(effects, scene, even_part, next_order_ratio)
        if odd_part is not None:
            # ODD_PART: "tilt and bulk strain"
            by_cause[ODD_PART] = odd_part
            neglected_part = 0.0
    return _PartsOfWork(by_cause, neglected_part, size_of_odd_part)


def _changes_of_values(
    scene: Scene, effects: BodyEffects, solved_theory: _SolvedTheory, parts: _PartsOfWork
) -> dict[str, Change]:
    """The changes by finite bodies of dissipation, largest pressure, largest half-width and
    permanent stick half-width, by key.

    That of the dissipation is the sum of its `parts`, one for each cause. The other changes are
    those by the curvatures of the faces; to the stick half-width tilt and bulk strain are added.
    They are NaN for unlike materials, and where tilt and bulk strain (the odd part) change the
    dissipation by more than 5 %: how much tilt and strain change the other values is not known
    then. `effects` are the elastic responses that the bodies add to half-planes. `solved_theory`
    holds half-plane theory, and theory with the curvatures alone.
    """
    from semi_analytic.next_order import LEAST_UNCERTAIN_FRACTION

    is_unknown = has_coupled_tractions(scene) or parts.size_of_odd_part > _LARGEST_CHECKED_ODD_PART
    uncertain_fraction = max(solved_theory.uncertain_fraction_by_curvature.values())
    exact_values = {
        "peak_pressure": solved_theory.largest_pressure,
        "half_width": solved_theory.half_width,
    }
    changes = {}
    # Key of each quantity, its name in a solution, and in words.
    # QUANTITIES: how the value of each is taken from a solution
    for key, (name, words) in _QUANTITIES_OF_ADVICE.items():
        value_of = QUANTITIES[name].value_of
        theory_value = value_of(solved_theory.theory)
        relative_change = value_of(solved_theory.corrected) / theory_value - 1
        uncertainty = abs(relative_change) * uncertain_fraction
        # Estimate: a value with its uncertainty
        if key == WORK:
            estimate = _sum_of_parts(parts)
        elif is_unknown:
            estimate = Estimate(math.nan, math.nan)
        elif parts.size_of_odd_part > 0 and key == "permanent_stick":
            estimate = _change_of_stick(scene, effects, theory_value, uncertainty)
        else:
            # LEAST_UNCERTAIN_FRACTION: 3e-5 of any value that the bodies change
            estimate = Estimate(relative_change, uncertainty + LEAST_UNCERTAIN_FRACTION)
        changes[key] = Change(words, exact_values.get(key, theory_value), estimate)
    return changes


def _sum_of_parts(parts: _PartsOfWork) -> Estimate:
    """The whole relative change of the dissipation with its uncertainty, to which what is neglected
    is added, and 3e-5 (`LEAST_UNCERTAIN_FRACTION`) of any value that the bodies change.
    """
    from semi_analytic.next_order import LEAST_UNCERTAIN_FRACTION

    change = sum(part.value for part in parts.by_cause.values())
    uncertainty = sum(part.uncertainty for part in parts.by_cause.values()) + parts.neglected_part
    return Estimate(change, uncertainty + LEAST_UNCERTAIN_FRACTION)


def _odd_part_of_work(
    effects: BodyEffects, scene: Scene, even_part: float, next_order_ratio: float
) -> Estimate | None:
    """The change of the dissipation W by the tilt and the bulk strain of finite bodies under the
    loads, relative to W of half-plane theory, with its uncertainty. None where theory can't follow
    them in this scene, such as for its profile.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    even_part
        relative change of W by the curvatures of the faces
    next_order_ratio
        how large the term of fourth order in x is beside the curvature, at the edge of contact, in
        the deflections that loads give the faces
    """
    import semi_analytic
    from semi_analytic.next_order import uncertain_fraction_of_tilt_and_strain

    try:
        # Relative change of W by tilt and bulk strain, with its uncertainty.
        odd_change = semi_analytic.change_by_tilt_and_strain(scene, effects)
    except InputError:
        return None
    # Relative uncertainty by orders that are left out.
    uncertain_fraction = uncertain_fraction_of_tilt_and_strain(even_part, next_order_ratio)
    uncertainty_of_order = uncertain_fraction * abs(odd_change.value)
    # Estimate: a value with its uncertainty
    return Estimate(odd_change.value, odd_change.uncertainty + uncertainty_of_order)


def _change_of_stick(
    scene: Scene, effects: BodyEffects, theory_value: float, uncertainty: float
) -> Estimate:
    """Relative change of the permanent stick half-width by finite bodies, with tilt and bulk strain
    in the first order; NaN where theory in that order does not take the scene.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    theory_value
        the half-width by half-plane theory [length]
    uncertainty
        of that relative change by the curvatures of the faces alone
    """
    import semi_analytic
    from semi_analytic.odd_memory import DeclinedError, second_order_answer

    # Whether theory takes the scene with tilt and bulk strain; what `second_order_answer` returns
    # (the friction work that they add) is not needed here.
    try:
        second_order_answer(scene, effects)
    except DeclinedError:
        # Estimate: a value with its uncertainty
        return Estimate(math.nan, math.nan)
    # the edges alone are needed, not the dissipation
    corrected_half_width = semi_analytic.solve(
        scene, x=0.0, cycles="steady", effects=effects, fields="pressure"
    ).permanent_stick_half_width
    # An error of 0.5 % by tilt and bulk strain is added.
    # _RELATIVE_ERROR_OF_STICK: 0.005
    return Estimate(corrected_half_width / theory_value - 1, uncertainty + _RELATIVE_ERROR_OF_STICK)


def words_of_refusal(refusal: Exception) -> str:
    """Why theory does not take a scene, without the name of the argument `effects`, which only
    callers from Python state.

    >>> words_of_refusal(InputError("effects: the contact would split"))
    'the contact would split'
    """
    return str(refusal).removeprefix("effects: ")


def split_difference_of_work(comparison: JudgedPair, budget: ErrorBudget | None) -> Why:
    """Split the difference of the dissipation W between finite elements of real bodies and
    half-plane theory into its causes.

    What is returned (`Why`) holds the difference and its parts by cause. It has a reason instead of
    the parts where W was not compared, or where no method finds the causes for these bodies. It has
    one, too, where a part does not converge or has no error estimate.

    Parameters
    ----------
    comparison
        of finite elements with half-plane theory: `metric(WORK)` is the relative difference of W
        with its uncertainty (`absolute` where it is not relative); `effects` are the elastic
        responses of the bodies
    budget
        error budget that states the parts by mesh and load steps; None: these parts stay in the
        rest that no cause explains
    """
    # WORK: "dissipation"
    metric = comparison.metric(WORK)
    if metric.value is None or metric.absolute or not math.isfinite(metric.value):
        # Estimate: a value with its uncertainty
        return Why(
            Estimate(math.nan, math.nan), reason_not_split="the dissipation was not compared"
        )
    uncertainty = math.nan if metric.uncertainty is None else metric.uncertainty
    total_change = Estimate(metric.value, uncertainty)

    # The part by mesh and load steps, and those by each cause.
    numerical_part = 0.0
    if budget is not None:
        # The budget's terms for W: its parts by mesh and load steps.
        terms = next(row.terms for row in budget.budgets if row.metric.key == WORK)
        numerical_part = sum(term.value or 0.0 for term in terms)
    try:
        parts = _parts_of_bodies(comparison)
    except (InputError, ConvergenceError) as reason:
        return Why(total_change, reason_not_split=words_of_refusal(reason))
    causes_without_estimate = [
        cause for cause, part in parts.items() if math.isnan(part.uncertainty)
    ]
    if causes_without_estimate:
        return Why(
            total_change,
            reason_not_split=(
                f"on this mesh the error of {' and of '.join(causes_without_estimate)} has no"
                " estimate; a finer mesh splits it"
            ),
        )
    return Why(total_change, parts, Estimate(numerical_part))


def _parts_of_bodies(comparison: JudgedPair) -> dict[str, Estimate]:
    """The causes of the change of the dissipation by real bodies: cause -> relative change with its
    uncertainty. The method depends on the bodies: unlike materials, curved faces (as of a
    cylinder), or flat faces of like materials.

    Raises
    ------
    InputError, ConvergenceError
        For bodies that no method takes, and where a solve does not converge.
    """
    # unlike materials: pressure and shear depend on each other
    if has_coupled_tractions(comparison.scene):
        return _parts_of_unlike_materials(comparison)
    if comparison.scene.bodies.faces_are_true:
        return _parts_of_curved_faces(comparison)
    advice = advise_by_numbers(comparison.scene, effects=comparison.effects)
    return _parts_of_flat_faces(advice, comparison)


def _parts_of_flat_faces(advice: Advice, comparison: JudgedPair) -> dict[str, Estimate]:
    """The causes of the change of the dissipation for bodies of like materials with flat faces:
    cause -> relative change with its uncertainty.

    They are those of theory corrected by the bodies' elastic responses. Where that gives sizes
    without a checked uncertainty, half-planes with the entire compliance of the bodies (kernels)
    are solved by finite elements. Their change beyond the sum of the causes is a further cause,
    HIGHER_ORDERS, which has the uncertainty of all.

    Parameters
    ----------
    advice
        of corrected theory: `parts` by cause; `reason_for_size_alone`, "" where its uncertainty was
        checked; `neglected_part`: size of the change by tilt and bulk strain where they were not
        followed
    comparison
        of finite elements with half-plane theory
    """
    parts = dict(advice.parts)
    if not advice.reason_for_size_alone:
        if advice.neglected_part:
            # ODD_PART: "tilt and bulk strain"
            # Estimate: a value with its uncertainty
            parts[ODD_PART] = Estimate(0.0, advice.neglected_part)
        return parts

    # W of theory: WORK is "dissipation".
    theory_work = advice.changes[WORK].theory_value
    # W [energy / thickness] with its uncertainty.
    work_by_kernels = _work_by_kernels(comparison)
    sum_of_parts = sum(part.value for part in parts.values())
    parts = {cause: Estimate(part.value) for cause, part in parts.items()}
    change_beyond_parts = work_by_kernels.value / theory_work - 1 - sum_of_parts
    parts[HIGHER_ORDERS] = Estimate(change_beyond_parts, work_by_kernels.uncertainty / theory_work)
    return parts


def _parts_of_curved_faces(comparison: JudgedPair) -> dict[str, Estimate]:
    """The one cause of the change of the dissipation for bodies with curved faces, their finite
    size: cause -> relative change with its uncertainty. It is found by finite elements of
    half-planes with the compliance of the bodies added (kernels). `comparison` is that of finite
    elements with theory.

    Raises
    ------
    InputError
        For bodies whose compliance is not known, before anything is solved.
    """
    import semi_analytic

    # W [energy / thickness] with its uncertainty.
    work_by_kernels = _work_by_kernels(comparison)
    # WORK: "dissipation"
    theory_work = semi_analytic.solve(comparison.scene, fields=WORK).dissipation
    change = work_by_kernels.value / theory_work - 1
    # FINITE_BODIES: "finite bodies"
    # Estimate: a value with its uncertainty
    return {FINITE_BODIES: Estimate(change, work_by_kernels.uncertainty / theory_work)}


def _parts_of_unlike_materials(comparison: JudgedPair) -> dict[str, Estimate]:
    """The causes of the change of the dissipation for bodies of unlike materials: cause -> relative
    change with its uncertainty.

    Coupling of pressure and shear is the change from theory to half-planes of these materials, by
    finite elements. Finite size is the further change to half-planes with the compliance of the
    bodies added (kernels). `comparison` is that of finite elements with theory.

    Raises
    ------
    InputError
        For bodies whose compliance is not known, before anything is solved.
    """
    import halfplane_fe
    import semi_analytic

    scene = comparison.scene
    # W [energy / thickness] with its uncertainty.
    work_by_kernels = _work_by_kernels(comparison)
    # Half-planes by finite elements twice as large as in the comparison.
    mesh, settings = _coarser_mesh_and_settings(comparison)
    solution_of_half_planes = halfplane_fe.solve(scene.vary(bodies=Bodies()), mesh, settings)
    # WORK: "dissipation"
    theory_work = semi_analytic.solve(scene, fields=WORK).dissipation

    change_by_coupling = solution_of_half_planes.dissipation / theory_work - 1
    uncertainty_of_coupling = solution_of_half_planes.dissipation_uncertainty / theory_work
    change_by_bodies = (work_by_kernels.value - solution_of_half_planes.dissipation) / theory_work
    uncertainty_of_kernels = work_by_kernels.uncertainty / theory_work
    # COUPLING, FINITE_BODIES: "coupling" and "finite bodies"
    # Estimate: a value with its uncertainty
    return {
        COUPLING: Estimate(change_by_coupling, uncertainty_of_coupling),
        FINITE_BODIES: Estimate(change_by_bodies, uncertainty_of_kernels + uncertainty_of_coupling),
    }


def _work_by_kernels(comparison: JudgedPair) -> Estimate:
    """W of half-planes with the compliance of the bodies added (kernels), by finite elements of
    twice the size. InputError for bodies whose compliance is not known.
    """
    import halfplane_fe

    mesh, settings = _coarser_mesh_and_settings(comparison)
    solution = halfplane_fe.solve(comparison.scene, mesh, settings, bodies="kernel")
    return Estimate(solution.dissipation, solution.dissipation_uncertainty)


def _coarser_mesh_and_settings(comparison: JudgedPair) -> tuple[MeshSettings, SolverSettings]:
    """Settings of a mesh with elements twice as large as in the comparison, and of its load steps:
    it takes a third of the time, and the parts are uncertain by some 1e-3.
    """
    from halfplane_fe import SolverSettings
    from reports.comparison.budget import coarser_mesh_and_settings

    mesh = MeshSettings(**comparison.result.settings["mesh"])
    return coarser_mesh_and_settings(mesh, SolverSettings(), _ELEMENT_SIZE_RATIO)


# Key of an answer -> key of the quantity in `laws.QUANTITIES`, which has it on the points that
# both solutions have; and its name in words.
_QUANTITIES_OF_ADVICE = {
    WORK: ("dissipation", "dissipation"),
    "peak_pressure": ("largest_pressure", "largest pressure"),
    "half_width": ("largest_half_width", "largest contact half-width"),
    "permanent_stick": ("permanent_stick_half_width", "permanent stick half-width"),
}


def _parts_by_curvatures(
    effects: BodyEffects,
    theory: ContactSolution,
    corrected_solution: ContactSolution,
    uncertain_fraction_by_curvature: Mapping[str, float],
) -> dict[str, Estimate]:
    """Relative change of the dissipation by each of two curvatures that finite bodies add to
    half-planes, with the other one absent: that of the gap under P, and that of the tangential
    displacement under Q. The part "both together" is the change by both minus these two.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    theory, corrected_solution
        half-plane theory, and theory with all curvatures
    uncertain_fraction_by_curvature
        relative uncertainty of the change by each curvature

    Returns
    -------
    dict
        Cause -> relative change with its uncertainty.
    """
    import semi_analytic
    from semi_analytic.next_order import CURVATURES, with_one_group_alone

    parts = {}
    remaining_change = corrected_solution.dissipation / theory.dissipation - 1
    # CURVATURES: "curvature under P" and "curvature under Q", with the responses of each
    for curvature in CURVATURES:
        # The responses of the bodies with this curvature alone.
        effects_of_curvature = with_one_group_alone(effects, curvature)
        # WORK: "dissipation"
        solution = semi_analytic.solve(
            theory.scene, x=0.0, time=theory.time, effects=effects_of_curvature, fields=WORK
        )
        change = solution.dissipation / theory.dissipation - 1
        # Estimate: a value with its uncertainty
        parts[curvature] = Estimate(
            change, abs(change) * uncertain_fraction_by_curvature[curvature]
        )
        remaining_change -= change
    parts["both together"] = Estimate(
        remaining_change, abs(remaining_change) * sum(uncertain_fraction_by_curvature.values())
    )
    return parts


def _without_tilt_and_strain(effects: BodyEffects) -> BodyEffects:
    """The elastic responses of the bodies without the odd ones, tilt and bulk strain."""
    from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES

    zero_by_name: dict[str, Any] = dict.fromkeys(TILT_AND_STRAIN_NAMES, Estimate(0.0))
    return replace(effects, **zero_by_name)


def _size_of_odd_part(effects: BodyEffects, scene: Scene, half_width: float) -> float:
    """Rough size of the relative change of the dissipation by tilt and bulk strain of finite
    bodies, c_1 (strain/f)^2 + c_2 strain tilt + c_3 (tilt f)^2 with the friction coefficient f.
    They count in their second order alone: with both signs turned the dissipation is the same, by
    symmetry.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    scene
        for materials and friction
    half_width
        largest half-width of the contact [length]
    """
    # both dimensionless: sums of the sizes of the responses to P and to Q
    tilt, strain = _tilt_and_strain(effects, scene, half_width)
    friction_coefficient = scene.friction.coefficient
    # _STRAIN_SQUARED, _STRAIN_BY_TILT, _TILT_SQUARED: c_1 = 1.4, c_2 = 4.4 and c_3 = 3.5
    return (
        _STRAIN_SQUARED * (strain / friction_coefficient) ** 2
        + _STRAIN_BY_TILT * strain * tilt
        + _TILT_SQUARED * (tilt * friction_coefficient) ** 2
    )


def _size_of_coupling(effects: BodyEffects, scene: Scene, half_width: float) -> float:
    """Rough size of the relative change of the dissipation by the coupling of pressure and shear in
    unlike materials,

        c_1 (beta/f)^2 + c_2 beta strain/f^2 + c_3 beta tilt

    with Dundurs' beta and the friction coefficient f: the first term for half-planes, the others
    with the bulk strain and the tilt of finite bodies.

    Parameters
    ----------
    effects
        elastic responses that the bodies add to half-planes
    scene
        for materials and friction
    half_width
        largest half-width of the contact [length]
    """
    from halfplane_fe.dundurs import dundurs

    # both dimensionless: sums of the sizes of the responses to P and to Q
    tilt, strain = _tilt_and_strain(effects, scene, half_width)
    beta = abs(dundurs(scene.material).beta)
    friction_coefficient = scene.friction.coefficient
    # _COUPLING_SQUARED, _STRAIN_BY_COUPLING, _TILT_BY_COUPLING: c_1 = 1.6, c_2 = 7 and c_3 = 5
    return (
        _COUPLING_SQUARED * (beta / friction_coefficient) ** 2
        + _STRAIN_BY_COUPLING * beta * strain / friction_coefficient**2
        + _TILT_BY_COUPLING * beta * tilt
    )


def _tilt_and_strain(effects: BodyEffects, scene: Scene, half_width: float) -> tuple[float, float]:
    """Sizes of the tilt |alpha_P| + |alpha_Q| and of the bulk strain |e_P| + |e_Q| of the bodies:
    dimensionless, each the sum of the response to P and of that to Q.

    `effects` are the elastic responses that the bodies add to half-planes, `half_width` is the
    largest of the contact [length].
    """
    from semi_analytic.corrected import dimensionless_tilt_and_strain
    from semi_analytic.elasticity import composite_modulus
    from semi_analytic.odd_memory import TILT_AND_STRAIN_NAMES

    # E* of both materials.
    modulus = composite_modulus(scene.material)
    # The four responses by name, made dimensionless with half-width and E*.
    dimensionless_responses = dimensionless_tilt_and_strain(effects, half_width, modulus)
    # TILT_AND_STRAIN_NAMES: names of these four responses
    sizes = {
        name: abs(number)
        for name, number in zip(TILT_AND_STRAIN_NAMES, dimensionless_responses, strict=True)
    }
    tilt = sizes["tilt_under_pressure"] + sizes["tilt_under_shear"]
    strain = sizes["strain_under_pressure"] + sizes["strain_under_shear"]
    return tilt, strain


def advice_in_words(advice: Advice) -> str:
    """The advice in sentences: by how much half-plane theory is expected to err in the dissipation,
    what makes the error, whether that is within the limit, and what to do.

    `advice.work` is the relative change of the dissipation, `parts` its parts by cause.
    `neglected_part` is the size of causes that were not followed. `reason_for_size_alone` says why
    the uncertainty was not checked, "" where it was.
    """
    change = advice.work
    causes_in_words = [f"{cause} {in_percent(part.value)}" for cause, part in advice.parts.items()]
    first_sentence = (
        f"Half-plane theory is expected to err by {in_percent(change.value)}"
        f" ± {in_percent(change.uncertainty).lstrip('+')} % in the dissipation"
        f" (finite elements/theory − 1): {', '.join(causes_in_words)}"
    )
    if advice.neglected_part:
        size = in_percent(advice.neglected_part).lstrip("+")
        neglected_causes = "tilt and bulk strain"
        if has_coupled_tractions(advice.scene):
            neglected_causes = "coupling of pressure and shear, tilt and bulk strain"
        first_sentence += f"; {neglected_causes} are left out, and counted as ± {size} %"
    if advice.reason_for_size_alone:
        first_sentence += f". That is no more than its size: {advice.reason_for_size_alone}"
    return f"{first_sentence}. {_sentence_on_limit(advice)}"


def _sentence_on_limit(advice: Advice) -> str:
    """A sentence on whether the expected error of half-plane theory is within the limit, and what
    to do: use theory, correct it, or solve the scene.

    Parameters
    ----------
    advice
        `verdict` on the `limit`; `reason_for_size_alone`: why the uncertainty was not checked, ""
        where it was; `refusal_of_kernels`: why half-planes with the compliance of the bodies added
        cannot be solved either, "" where that was not tried; `parts` of the change by cause;
        `neglected_part`: size of causes that were not followed
    """
    limit_in_words = f"the limit of {100 * advice.limit:g} %"
    words_to_solve = "solve the scene (`halfplane run`)"
    if advice.reason_for_size_alone and not advice.refusal_of_kernels:
        # The faces are flat, for corrected theory took the scene: kernels take flat faces too.
        words_to_solve += (
            ', or its kernels in 1 to 5 s (Python: `halfplane_fe.solve(scene, bodies="kernel")`)'
        )
    # `Verdict`: within the limit, outside, or undecided by its uncertainty.
    if advice.verdict is Verdict.WITHIN:
        return f"That is within {limit_in_words}: theory may be used."
    if advice.verdict is Verdict.UNDECIDED:
        return f"Whether it is within {limit_in_words} is undecided: {words_to_solve}."

    # Outside: theory can be corrected, unless tilt and bulk strain (ODD_PART) are large.
    # Estimate: a value with its uncertainty
    odd_part = advice.parts.get(ODD_PART, Estimate(0.0))
    size_of_odd_part = max(advice.neglected_part, abs(odd_part.value))
    if advice.reason_for_size_alone or size_of_odd_part > advice.limit / 2:
        return f"It is outside {limit_in_words}: {words_to_solve}."
    return (
        f"That is outside {limit_in_words}: correct theory (`halfplane exact --corrected`), or"
        " solve the scene (`halfplane run`)."
    )
