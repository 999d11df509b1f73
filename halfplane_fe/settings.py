"""How the contact problem is iterated and stepped: never what is true, never how the bodies are
cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from scenes import InputError


@dataclass(frozen=True)
class SolverSettings:
    """Method and step control.

    Attributes
    ----------
    method
        "augmented_lagrangian" (the law is met exactly) or "penalty" (an elastic layer between
        the faces)
    normal_stiffness, tangential_stiffness
        over E*/h, h being the surface element of the contact edges. Of the penalty layer:
        pressure per penetration is normal_stiffness E*/h [stress/length]; the cost is a
        penetration p h/(stiffness E*), an elastic slip and creep where the faces should stick,
        see `FiniteElementSolution.penalty`. For augmented_lagrangian the weights of gap and
        slip in the trial tractions: the answer does not depend on them
    steps_per_cycle
        regular increments of one revolution or of the longest leg of a polygon; instants at
        which a node touches or lets go, and the turning points of the path, come on top, and so
        do halved increments
    step_tolerance
        step error of a revolution, over its dissipation, above which increments are halved;
        "inf" for never
    max_iterations
        of one increment, before it counts as not converged
    """

    method: Literal["augmented_lagrangian", "penalty"] = "augmented_lagrangian"
    normal_stiffness: float = 1e3
    tangential_stiffness: float = 1e3
    steps_per_cycle: int = 24
    step_tolerance: float = 5e-4
    max_iterations: int = 100

    def __post_init__(self) -> None:
        if self.method not in ("augmented_lagrangian", "penalty"):
            raise InputError(
                f"solver: method = {self.method!r} is refused: it is augmented_lagrangian or"
                " penalty"
            )
        for name in ("normal_stiffness", "tangential_stiffness"):
            if not 1e-3 <= getattr(self, name) <= 1e9:
                raise InputError(
                    f"solver: {name} = {getattr(self, name)!r} is refused: it lies in [0.001, 1e9],"
                    " over E*/h"
                )
        if not 4 <= self.steps_per_cycle <= 100_000:
            raise InputError(
                f"solver: steps_per_cycle = {self.steps_per_cycle!r} is refused: it lies in [4,"
                " 100000]"
            )
        if not self.step_tolerance >= 1e-8:
            raise InputError(
                f"solver: step_tolerance = {self.step_tolerance!r} is refused: it is at least 1e-8"
            )
        if self.max_iterations < 2:
            raise InputError(
                f"solver: max_iterations = {self.max_iterations!r} is refused: it is at least 2"
            )
