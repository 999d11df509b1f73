"""Faults planted in the FE model, and the checks that catch each: a check that nothing trips proves nothing.

Each fault is planted by argument or by replacing one function, the paper's cycle is solved with it, and every check that the
project has for an answer is asked: errors against half-plane theory, the laws of contact, energy, symmetry. W is nearly stationary
in f at f = 1, so it is the shear that sees a wrong friction; and increments that land on each touch and turning point keep W within
its limit however few they are, so it takes the step's own error to see that they are too long.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any
from unittest import mock

import numpy as np
from claim import Row

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings, elasticity
from halfplane_fe.contact import ContactProblem, InterfaceState
from meshes import MeshSettings
from scenes import ConvergenceError, InputError, SurfaceState, load_scene

SOLVE = import_module("halfplane_fe.solve")
EQUILIBRIUM = ContactProblem.equilibrium
Planted = contextlib.AbstractContextManager[Any]

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


@dataclass(frozen=True)
class Fault:
    """What is planted, how, and the checks that shall catch it."""

    name: str
    caught_by: tuple[str, ...]
    plant: Callable[[], Planted] = contextlib.nullcontext
    settings: dict[str, Any] = field(default_factory=dict)


# ------------------------------------------------------------------------------------------------------------------ the faults
def gap(change: Callable[[ContactProblem], Any]) -> Planted:
    """The initial gap of the contact problem changed; scaled, like the problem."""
    make = SOLVE.ContactProblem

    def planted(*given: Any) -> ContactProblem:
        problem = make(*given)
        return make(problem.interface, change(problem), *given[2:])

    return mock.patch.object(SOLVE, "ContactProblem", planted)


def tenth_of_an_element(problem: ContactProblem) -> float:
    """h/10 as a gap: lengths are scaled by a, gaps by P/E*, and both bodies' rise over a is pi/2 P/E* on a Hertz contact."""
    x = problem.interface.x
    element = 2 * float(np.min(np.diff(x)))
    rise = float(np.interp(1.0, x, problem.height) - np.min(problem.height))
    return element / 10 * rise


def moved(problem: ContactProblem) -> np.ndarray:
    """The profile h/10 off along x."""
    x = problem.interface.x
    return np.interp(x + 2 * float(np.min(np.diff(x))) / 10, x, problem.height)


def rough(problem: ContactProblem, element: float | None = None) -> np.ndarray:
    """Every second node, the mid-side ones, h/10 off; with `element` (element over a) as h^2, h/10 on a mesh of that size.

    In proportion to h the pressure is wrong by the same amount on every mesh, which no study of meshes can see.
    """
    share = 1.0 if element is None else 2 * float(np.min(np.diff(problem.interface.x))) / element
    return np.asarray(problem.height + share * tenth_of_an_element(problem) * (np.arange(len(problem.height)) % 2))


def friction(factor: float) -> Planted:
    make = SOLVE.ContactProblem
    return mock.patch.object(SOLVE, "ContactProblem", lambda sides, height, f, *rest: make(sides, height, factor * f, *rest))


def equilibrium(planted: Callable[..., tuple[InterfaceState, int]]) -> Planted:
    return mock.patch.object(ContactProblem, "equilibrium", planted)


def forgetting(
    self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]
) -> tuple[InterfaceState, int]:
    """Each increment starts from faces that have never slipped."""
    state = np.where(history.closed, SurfaceState.STICK, SurfaceState.OPEN)
    rest = np.zeros_like(history.slip)
    return EQUILIBRIUM(self, history.changed(slip=rest, shear=rest, state=state), time, loads)


def turned_round(
    self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]
) -> tuple[InterfaceState, int]:
    """Q has the wrong sign, in the law's eyes alone."""
    state, iterations = EQUILIBRIUM(self, history, time, (loads[0], -loads[1]))
    return replace(state, loads=loads), iterations


def short_slip(
    self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]
) -> tuple[InterfaceState, int]:
    """The slip of each increment is recorded one per cent short."""
    state, iterations = EQUILIBRIUM(self, history, time, loads)
    return state.changed(slip=history.slip + 0.99 * (state.slip - history.slip)), iterations


def sticky(self: ContactProblem, history: InterfaceState, time: float, loads: tuple[float, float]) -> tuple[InterfaceState, int]:
    """Sliding nodes are left with one per cent too little pressure for their shear."""
    state, iterations = EQUILIBRIUM(self, history, time, loads)
    sliding = np.isin(state.state, [SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE])
    return state.changed(pressure=np.where(sliding, 0.99 * state.pressure, state.pressure)), iterations


@contextlib.contextmanager
def blind() -> Iterator[None]:
    """Increments end at regular instants alone: not where a node touches or lets go, nor where the path turns."""
    with (
        mock.patch.object(
            import_module("halfplane_fe.stepping"), "next_event", lambda _problem, _history, _at, end: ("regular", end)
        ),
        mock.patch.object(import_module("halfplane_fe.path"), "turning_points", return_value=[]),
    ):
        yield


def half_far_field() -> Planted:
    """The work of the arc's tractions in the half-plane's own displacement left out."""
    work = elasticity.arc_work

    def planted(*given: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        by_nodes, tractions, displacements = work(*given)
        return by_nodes, tractions, 0.0 * displacements

    return mock.patch.object(elasticity, "arc_work", planted)


@contextlib.contextmanager
def off_centre() -> Iterator[None]:
    """The profile h/10 off along x, and solved whole: a mirrored half would hide it."""
    with mock.patch.object(SOLVE, "mirrored", return_value=False), gap(moved):
        yield


FAULTS = (
    Fault("gap off by h/10 everywhere", ("normal approach",), lambda: gap(lambda p: p.height + tenth_of_an_element(p))),
    Fault("gap off by h/10 at mid-side nodes", ("peak pressure", "pressure, L2", "shear, L2"), lambda: gap(rough)),
    Fault("profile off by h/10 along x", ("symmetry of the contact, elements",), off_centre),
    Fault(
        "penalty too soft (1 E*/h)",
        ("pressure, L2", "overlap of the faces", "creep"),
        settings={"method": "penalty", "normal_stiffness": 1.0, "tangential_stiffness": 1.0},
    ),
    Fault("steps too long (8 a revolution)", ("step error",), settings={"steps_per_cycle": 8, "step_tolerance": np.inf}),
    Fault(
        "the same, and no event landed on",
        ("dissipation", "step error"),
        blind,
        settings={"steps_per_cycle": 8, "step_tolerance": np.inf},
    ),
    Fault("history dropped", ("shear, L2", "dissipation"), lambda: equilibrium(forgetting)),
    Fault("sign of Q flipped", ("shear, L2", "laws of contact"), lambda: equilibrium(turned_round)),
    Fault("friction 3 % low", ("shear, L2",), lambda: friction(0.97)),
    Fault("friction 3 % high", ("shear, L2",), lambda: friction(1.03)),
    Fault("slip recorded 1 % short", ("energy balance",), lambda: equilibrium(short_slip)),
    Fault("pressure of sliding nodes 1 % short", ("laws of contact", "energy balance"), lambda: equilibrium(sticky)),
    Fault("far field by halves", ("normal approach", "tangential displacement"), half_far_field),
)


# ------------------------------------------------------------------------------------------------------------------ the checks
def figures(answer: FiniteElementSolution) -> dict[str, float]:
    """Every check of an answer, in the order of LIMITS; the last cycle against half-plane theory at the same instants."""
    scene, cycle = answer.scene, answer.last_cycle
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    weights, f, element = answer.condensed[0].weights, scene.friction.coefficient, answer.settings["element_size"]

    def norm(values: np.ndarray) -> np.ndarray:
        return np.sqrt(values**2 @ weights)

    def worst(name: str) -> float:
        here, there = getattr(answer, name)[cycle], getattr(exact, name)[cycle]
        return float(np.max(np.abs(here - there)) / np.max(np.abs(there)))

    def edges(name: str) -> float:
        off = np.abs(getattr(answer, name) - getattr(exact, name))[cycle].max(axis=1) / element
        return float(np.max(np.nan_to_num(off, nan=np.inf)))

    size = norm(exact.pressure[cycle])
    checks = dict(answer.record.certificates)
    energy = checks.pop("energy_balance")
    found = (
        answer.dissipation / exact.dissipation - 1,
        np.max(np.abs(answer.pressure[cycle].max(axis=1) / exact.pressure[cycle].max(axis=1) - 1)),
        np.max(norm(answer.pressure[cycle] - exact.pressure[cycle]) / size),
        np.max(norm(answer.shear[cycle] - exact.shear[cycle]) / (f * size)),
        edges("contact_edges"),
        edges("stick_edges"),
        worst("normal_approach"),
        worst("tangential_displacement"),
        max(float(np.max(values)) for values in checks.values()),
        np.max(energy),
        answer.record.energy["step_error"][cycle[1:]].sum() / answer.dissipation,
        np.max(np.abs(answer.contact_edges.sum(axis=1))) / element,
        answer.penalty.penetration_share,
        answer.penalty.creep_share,
    )
    return {name: abs(float(value)) for name, value in zip(LIMITS, found, strict=True)}


def solved(fault: Fault | None, mesh: MeshSettings | None = None, scene: str = "hertz-paper") -> FiniteElementSolution | str:
    """The answer with the fault in it, or what the engine itself says and stops."""
    settings = SolverSettings(**(fault.settings if fault else {}))
    # Bodies of the store were condensed without the fault.
    with mock.patch.dict(os.environ, HALFPLANE_CACHE="off"), fault.plant() if fault else contextlib.nullcontext():
        try:
            return halfplane_fe.solve(load_scene(scene), mesh, settings)
        except (ConvergenceError, InputError, ArithmeticError) as reason:
            return str(reason)


def must_fail() -> Iterator[Row]:
    """The healthy model passes every check; each fault is missed by none of the checks that shall catch it."""
    healthy = solved(None)
    if isinstance(healthy, str):
        raise SystemExit(f"the healthy model does not solve the scene: {healthy}")
    fine = figures(healthy)
    for name, limit in LIMITS.items():
        yield Row(f"healthy: {name}", fine[name], limit, "hertz-paper, default mesh and steps")
    for fault in FAULTS:
        answer = solved(fault)
        found = dict.fromkeys(LIMITS, float("inf")) if isinstance(answer, str) else figures(answer)
        caught = [name for name, limit in LIMITS.items() if not found[name] <= limit]
        told = "; ".join(f"{name} {found[name]:.1e} (healthy {fine[name]:.1e})" for name in caught)
        how = f"the engine stops: {answer}" if isinstance(answer, str) else told
        yield Row(
            f"{fault.name}: missed by {', '.join(fault.caught_by)}", len(set(fault.caught_by) - set(caught)), 0, how, "checks"
        )
