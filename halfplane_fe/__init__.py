"""The independent referent: a plane-strain finite-element contact model, condensed to the
interface.

In the order in which a scene passes through::

    settings.py                            method and step control
    path.py                                turning points of the loads, increments, inadmissible
                                           paths
    actuators.py                           movements that a rig prescribes in the place of loads
    scales.py                              the coarse run: half-width, innermost edge; datum of
                                           approach and displacement
    elasticity.py, far_field.py            elements that do not lock; static condensation (Schur
                                           complement) to the contact nodes, Flamant far field
    condensed_bodies.py                    least-recently-used cache of condensed bodies in the
                                           process
    supports.py, solvable.py               what is refused before anything is meshed: loads,
                                           supports, bodies too small for the contact
    interface.py, mortar.py                the two bodies as one compliance; dual mortar for sides
                                           that do not match, or are curved
    mirror.py                              symmetric faces on one half
    law.py                                 Signorini and Coulomb as one projection: return mapping;
                                           bound of the error of an increment's friction work
    contact.py                             one increment: active set, semismooth Newton
    systems.py                             its linear systems for many sets of node states: Woodbury
                                           updates of a few, cached
    tresca.py                              the two convex halves (Signorini, Tresca), where the sets
                                           do not settle
    return_mapping.py                      penalty method and augmented Lagrangian: return mapping
                                           of the tractions, multipliers
    stepping.py                            along a stretch of the path, to each touch and release
    run.py                                 over the whole path; shakedown and ratcheting: what
                                           revolutions have left to go
    energy.py                              balance, friction work, kinks in an increment,
                                           admissibility checks
    between_nodes.py                       edges between nodes: where the permanent stick zone ends,
                                           what they add to the dissipation, which is taken off
    edges.py                               edges of contact and stick at every instant, by fits
    stick_by_slip.py                       ends of the permanent stick zone by the slip beyond them
    slip_between_nodes.py                  largest slip, over all places up to the edges of contact
    reported_states.py                     states of the nodes as a reader sees them
    task.py, solution.py, answer.py        scene, mesh, settings and scales in one; `solve`; the
                                           arrays of the answer; cost of a penalty layer
    answer_uncertainty.py, answer_notes.py how uncertain each value is; what a reader must know of
                                           mesh and path, counts of work
    answer_of_rig.py                       the loads that a rig's movements lead to; gross sliding
    remainder.py                           what finite bodies add to half-planes: remainder of the
                                           Green's function, without contact
    kernel_bodies.py                       half-planes with these remainder kernels in the place of
                                           meshed bodies: `solve(..., bodies="kernel")`
    uncertainty.py                         how far each value may be from the true one: one rule
                                           from two meshes, Richardson
    resolution.py, dundurs.py              what the mesh can't see, how unlike the bodies are
    body_fields.py, face_stress.py         displacement and stress inside the bodies; stress next to
                                           the contact from the tractions
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from halfplane_fe.body_fields import (
        BodyFields,
        LargestTension,
        Snapshot,
        edge_tension,
        fields,
        largest_edge_tension,
        stress,
    )
    from halfplane_fe.path import check_admissible
    from halfplane_fe.remainder import body_effects
    from halfplane_fe.settings import SolverSettings
    from halfplane_fe.slip_between_nodes import LargestSlip, largest_slip, largest_slip_of_cycle
    from halfplane_fe.solution import FiniteElementSolution, KernelSolution, solve
    from halfplane_fe.solvable import require_solvable

__all__ = [
    "BodyFields",
    "FiniteElementSolution",
    "KernelSolution",
    "LargestSlip",
    "LargestTension",
    "Snapshot",
    "SolverSettings",
    "body_effects",
    "check_admissible",
    "edge_tension",
    "fields",
    "largest_edge_tension",
    "largest_slip",
    "largest_slip_of_cycle",
    "require_solvable",
    "solve",
    "stress",
]

_HOME = {
    "BodyFields": "halfplane_fe.body_fields",
    "FiniteElementSolution": "halfplane_fe.solution",
    "KernelSolution": "halfplane_fe.solution",
    "LargestSlip": "halfplane_fe.slip_between_nodes",
    "LargestTension": "halfplane_fe.body_fields",
    "Snapshot": "halfplane_fe.body_fields",
    "SolverSettings": "halfplane_fe.settings",
    "body_effects": "halfplane_fe.remainder",
    "check_admissible": "halfplane_fe.path",
    "edge_tension": "halfplane_fe.body_fields",
    "fields": "halfplane_fe.body_fields",
    "largest_edge_tension": "halfplane_fe.body_fields",
    "largest_slip": "halfplane_fe.slip_between_nodes",
    "largest_slip_of_cycle": "halfplane_fe.slip_between_nodes",
    "require_solvable": "halfplane_fe.solvable",
    "solve": "halfplane_fe.solution",
    "stress": "halfplane_fe.body_fields",
}


def __getattr__(name: str) -> Any:
    # What a name needs is loaded where it is first used: a check of a scene needs no elements.
    if name not in _HOME:
        raise AttributeError(f"module 'halfplane_fe' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
