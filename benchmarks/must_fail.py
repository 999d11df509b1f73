"""Faults planted in the FE model, in theory of rigs and in what inputs make of an answer, and the
checks that catch each: a check that nothing trips proves nothing.

Each fault is planted by argument or by replacing one function, the paper's cycle is solved with it,
and every check that the project has for an answer is asked: errors against half-plane theory, the
laws of contact, energy, symmetry. W is nearly stationary in f at f = 1, so it is the shear that
sees a wrong friction; and increments that land on each touch and turning point keep W within its
limit however few they are, so it takes the step's own error to see that they are too long.
tests/test_halfplane_fe_mutations.py holds each fault to its checks.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings, elasticity, far_field
from halfplane_fe.condensed_bodies import BODY_CACHE
from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.law import slip_sign
from halfplane_fe.run import PathRun
from halfplane_fe.stepping import Increment
from meshes import MeshSettings
from reports import inputs
from scenes import (
    BodyEffects,
    ConvergenceError,
    InputError,
    Scene,
    Uncertainty,
    load_scene,
    uncertainty,
)
from semi_analytic import driven
from semi_analytic.corrected_memory import FrictionMemory, MemoryState, MemoryStep, Row
from semi_analytic.driven import DrivenPath

SOLVE = import_module("halfplane_fe.solution")
EQUILIBRIUM = ContactProblem.equilibrium
Planted = contextlib.AbstractContextManager[Any]
Step = tuple[InterfaceState, int]

# Limits of the promised figures on the default mesh; what needs no reference holds to 1e-9 on any.
LIMITS = {
    "dissipation": 1.5e-3,
    "peak pressure": 2e-4,
    "pressure, L2": 2.5e-3,
    "shear, L2": 8e-3,
    "contact edge, elements": 1.0,
    "stick edge, elements": 1.0,
    "normal approach": 3e-5,
    "tangential displacement": 1e-4,
    "laws of contact": 1e-9,
    "energy balance": 1e-9,
    "step error": 2e-4,
    "symmetry of the contact, elements": 1e-6,
    "overlap of the faces": 1e-4,
    "creep": 1e-4,
}


class Fault(NamedTuple):
    """What is planted, the checks that shall catch it, and how."""

    name: str
    caught_by: tuple[str, ...]
    plant: Callable[[], Planted] = contextlib.nullcontext
    settings: dict[str, Any] = {}  # noqa: RUF012 (never changed)


# --------------------------------------------------------------------------------------- the faults
def problem(change: Callable[..., tuple[Any, ...]]) -> Planted:
    """The contact problem made from changed arguments: interface, initial gap, friction and the
    rest; lengths are scaled by a.
    """
    make = SOLVE.ContactProblem
    return mock.patch.object(
        SOLVE, "ContactProblem", lambda *arguments, **named: make(*change(*arguments), **named)
    )


def gap(change: Callable[[np.ndarray, np.ndarray], Any]) -> Planted:
    """The initial gap changed, by its places and values; gaps are scaled by P/E*."""
    return problem(lambda sides, height, *rest: (sides, change(sides.x, height), *rest))


def friction(factor: float) -> Planted:
    return problem(lambda sides, height, f, *rest: (sides, height, factor * f, *rest))


def element(x: np.ndarray) -> float:
    """Least length of an element, of two spacings of nodes."""
    return 2 * float(np.min(np.diff(x)))


def lifted(x: np.ndarray, height: np.ndarray) -> np.ndarray:
    """h/10 as a gap everywhere: both bodies' rise over a is pi/2 P/E* on a Hertz contact."""
    return height + element(x) / 10 * float(np.interp(1.0, x, height) - np.min(height))


def rough(x: np.ndarray, height: np.ndarray, size: float | None = None) -> np.ndarray:
    """Every second node, the mid-side ones, h/10 off; with `size` (element over a) as h^2, h/10 on
    a mesh of that size.

    In proportion to h the pressure is wrong by the same amount on every mesh, which no study of
    meshes can see.
    """
    share = 1.0 if size is None else element(x) / size
    return np.where(np.arange(len(x)) % 2, height + share * (lifted(x, height) - height), height)


@contextlib.contextmanager
def off_centre() -> Iterator[None]:
    """The profile h/10 off along x, and solved whole: a mirrored half would hide it."""
    moved = gap(lambda x, height: np.interp(x + element(x) / 10, x, height))
    with mock.patch("halfplane_fe.scales.is_mirrored", return_value=False), moved:
        yield


def equilibrium(planted: Callable[..., Step]) -> Planted:
    return mock.patch.object(ContactProblem, "equilibrium", planted)


def forgetting(
    self: ContactProblem,
    history: InterfaceState,
    time: float,
    loads: tuple[float, float],
    *_expected: Any,
) -> Step:
    """Each increment starts from faces that have never slipped."""
    return EQUILIBRIUM(self, self.unloaded_state(history.time), time, loads)


def turned_round(
    self: ContactProblem,
    history: InterfaceState,
    time: float,
    loads: tuple[float, float],
    *_expected: Any,
) -> Step:
    """Q has the wrong sign, in the law's eyes alone."""
    before = replace(history, loads=(history.normal_load, -history.tangential_load))
    state, iterations = EQUILIBRIUM(self, before, time, (loads[0], -loads[1]))
    return replace(state, loads=loads), iterations


def short_slip(self: ContactProblem, history: InterfaceState, *arguments: Any) -> Step:
    """The slip of each increment is recorded one per cent short."""
    state, iterations = EQUILIBRIUM(self, history, *arguments)
    return state.changed(slip=history.slip + 0.99 * (state.slip - history.slip)), iterations


def sticky() -> Planted:
    """Sliding nodes are recorded with one per cent too little pressure for their shear; what comes
    next follows the right state.
    """
    append = PathRun.append

    def short(increment: Increment) -> Increment:
        sliding = slip_sign(increment.state.node_states) != 0
        pressure = increment.state.pressure
        return replace(
            increment,
            state=increment.state.changed(pressure=np.where(sliding, 0.99 * pressure, pressure)),
        )

    def planted(
        self: PathRun, problem: ContactProblem, increments: list[Increment], *rest: Any
    ) -> None:
        append(self, problem, [short(increment) for increment in increments], *rest)
        if increments:
            self.states[-1] = increments[-1].state

    return mock.patch.object(PathRun, "append", planted)


@contextlib.contextmanager
def blind() -> Iterator[None]:
    """Increments end at regular instants alone: not where a node touches or lets go, nor where the
    path turns.
    """
    stepping, path = (import_module(f"halfplane_fe.{name}") for name in ("stepping", "path"))
    regular = mock.patch.object(
        stepping, "next_event", lambda _problem, _history, _at, end, _states: ("regular", end)
    )
    with regular, mock.patch.object(path, "turning_points", return_value=[]):
        yield


def half_far_field() -> Planted:
    """The work of the arc's tractions in the half-plane's own displacement left out."""
    forces_on_arc = far_field.arc_forces

    def planted(*given: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nodal_forces, tractions, displacements = forces_on_arc(*given)
        return nodal_forces, tractions, 0.0 * displacements

    return mock.patch.object(elasticity, "arc_forces", planted)


SOFT = {"method": "penalty", "normal_stiffness": 1.0, "tangential_stiffness": 1.0}
LONG = {"steps_per_cycle": 8, "step_tolerance": np.inf}
FAULTS = (
    Fault("gap off by h/10 everywhere", ("normal approach",), lambda: gap(lifted)),
    Fault(
        "gap off by h/10 at mid-side nodes",
        ("peak pressure", "pressure, L2", "shear, L2"),
        lambda: gap(rough),
    ),
    Fault("profile off by h/10 along x", ("symmetry of the contact, elements",), off_centre),
    Fault(
        "penalty too soft (1 E*/h)",
        ("pressure, L2", "overlap of the faces", "creep"),
        settings=SOFT,
    ),
    Fault("steps too long (8 a revolution)", ("step error",), settings=LONG),
    Fault("the same, and no event landed on", ("dissipation", "step error"), blind, LONG),
    Fault("history dropped", ("shear, L2", "dissipation"), lambda: equilibrium(forgetting)),
    Fault("sign of Q flipped", ("shear, L2", "laws of contact"), lambda: equilibrium(turned_round)),
    Fault("friction 3 % low", ("shear, L2",), lambda: friction(0.97)),
    Fault("friction 3 % high", ("shear, L2",), lambda: friction(1.03)),
    Fault("slip recorded 1 % short", ("energy balance",), lambda: equilibrium(short_slip)),
    Fault("pressure of sliding nodes 1 % short", ("laws of contact", "energy balance"), sticky),
    Fault("far field by halves", ("normal approach", "tangential displacement"), half_far_field),
)


# ---------------------------------------------------------------------------------- faults of rigs
def slide_not_counted() -> Planted:
    """The work of gross sliding is left out."""
    nothing = property(lambda self: np.zeros(len(self.time)))
    return mock.patch.object(DrivenPath, "slide_work", nothing)


def spring_left_in() -> Planted:
    """U of the contact is taken for that of the actuator."""
    return mock.patch.object(
        DrivenPath, "displacement", property(lambda self: self.actuator_displacement)
    )


def limit_of_the_wrong_sign() -> Planted:
    """What slides as a whole slides against Q."""
    step = driven._StepSolver.solved_step

    def planted(self: driven._StepSolver, *arguments: Any) -> driven._SolvedStep:
        found = step(self, *arguments)
        return found._replace(slide_distance=-found.slide_distance)

    return mock.patch.object(driven._StepSolver, "solved_step", planted)


def memory_kept() -> Planted:
    """Bodies that part remember their shear."""
    step = FrictionMemory.step

    def planted(self: FrictionMemory, state: MemoryState, row: Row) -> MemoryStep:
        found = step(self, state, row)
        return found._replace(state=state) if self.is_unloaded(row.normal_load) else found

    return mock.patch.object(FrictionMemory, "step", planted)


# Of prescribed displacements, which half-plane theory follows: tests/test_semi_analytic_rig.py
# holds each to its closed forms.
FAULTS_OF_RIGS: dict[str, Callable[[], Planted]] = {
    "slide not counted": slide_not_counted,
    "spring left in the loop": spring_left_in,
    "sliding limit of the wrong sign": limit_of_the_wrong_sign,
    "memory kept through separation": memory_kept,
}


# -------------------------------------------------------------------------------- faults of inputs
def inputs_of_their_own() -> Planted:
    """Theory keeps the inputs that it had at first while those of the bodies are moved, as if each
    model had inputs of its own.
    """
    works = inputs._works_by_quick_formula
    first: list[float] = []

    def planted(scene: Scene, effects: BodyEffects) -> tuple[float, float]:
        theory, corrected = works(scene, effects)
        first.append(theory)
        return first[0], corrected

    return mock.patch.object(inputs, "_works_by_quick_formula", planted)


def covariance_ignored() -> Planted:
    """Every input errs on its own, whatever correlations are stated."""

    def planted(self: Uncertainty) -> np.ndarray:
        return np.eye(len(list(self.stated())))

    return mock.patch.object(Uncertainty, "correlation_matrix", planted)


def percent_read_as_a_share() -> Planted:
    """5 % counts as 5 times the value."""
    relative_uncertainty = uncertainty._relative_uncertainty

    def planted(key: str, stated: str, *rest: Any) -> float:
        return relative_uncertainty(key, stated, *rest) * (100 if "%" in stated else 1)

    return mock.patch.object(uncertainty, "_relative_uncertainty", planted)


# tests/test_reports_inputs.py holds each to what two scenes, one load cell and the text say.
FAULTS_OF_INPUTS: dict[str, Callable[[], Planted]] = {
    "inputs of their own in the difference": inputs_of_their_own,
    "covariance ignored": covariance_ignored,
    "per cent read as a share": percent_read_as_a_share,
}


# --------------------------------------------------------------------------------------- the checks
def figures(answer: FiniteElementSolution) -> dict[str, float]:
    """Every check of an answer, in the order of LIMITS; the last cycle against half-plane theory at
    the same instants.
    """
    scene = answer.scene
    cycle = answer.last_cycle
    element_size = answer.settings["element_size"]
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time)

    def pair(name: str) -> tuple[np.ndarray, np.ndarray]:
        return getattr(answer, name)[cycle], getattr(exact, name)[cycle]

    def norm(values: np.ndarray) -> np.ndarray:
        return np.sqrt(values**2 @ answer.face_lengths)

    def worst(name: str) -> float:
        values, reference = pair(name)
        return float(np.max(np.abs(values - reference)) / np.max(np.abs(reference)))

    def edges(name: str) -> float:
        values, reference = pair(name)
        return float(np.max(np.nan_to_num(np.abs(values - reference), nan=np.inf))) / element_size

    (p, true_p) = pair("pressure")
    (q, true_q) = pair("shear")
    checks = dict(answer.record.certificates)
    energy = checks.pop("energy_balance")
    edge_errors = (
        answer.dissipation / exact.dissipation - 1,
        np.max(np.abs(p.max(axis=1) / true_p.max(axis=1) - 1)),
        np.max(norm(p - true_p) / norm(true_p)),
        np.max(norm(q - true_q) / (scene.friction.coefficient * norm(true_p))),
        edges("contact_edges"),
        edges("stick_edges"),
        worst("normal_approach"),
        worst("tangential_displacement"),
        max(float(np.max(values)) for values in checks.values()),
        np.max(energy),
        answer.record.energy["step_error"][cycle[1:]].sum() / answer.dissipation,
        np.max(np.abs(answer.contact_edges.sum(axis=1))) / element_size,
        answer.penalty.penetration_share,
        answer.penalty.creep_share,
    )
    return {name: abs(float(value)) for name, value in zip(LIMITS, edge_errors, strict=True)}


def solved(fault: Fault | None, mesh: MeshSettings | None = None) -> FiniteElementSolution | str:
    """The answer with the fault in it, or what the engine itself says and stops."""
    fault = fault or Fault("none", ())
    # Cached bodies were condensed without the fault.
    with mock.patch.object(BODY_CACHE, "bound_bytes", 0), fault.plant():
        try:
            return halfplane_fe.solve(
                load_scene("hertz-paper"), mesh, SolverSettings(**fault.settings)
            )
        except (ConvergenceError, InputError, ArithmeticError) as reason:
            return str(reason)
