"""How the contact problem is iterated and the load path divided into increments. Bodies, loads and
meshes are set elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, get_args

from scenes import InputError

Method = Literal["active_set", "augmented_lagrangian", "penalty"]

# Over E*/h. The layer of the penalty method, or the weight of the trials of the active set.
_STIFFNESS = 1e3
# Over E*/h. The penalty of the augmented Lagrangian. With 30 it takes twice the multiplier updates
# (14 for 7) and Newton steps (22 for 11) of an increment; with 1000 its inner loop cycles
# between unlike bodies.
_PENALTY = 300.0


@dataclass(frozen=True)
class SolverSettings:
    """Method of the contact solver, and control of its increments.

    Attributes
    ----------
    method
        "active_set" (semismooth Newton, the law is met exactly), "augmented_lagrangian"
        (return mapping of the tractions, multipliers updated until the law is met) or
        "penalty" (one return mapping, an elastic layer between the faces)
    normal_stiffness, tangential_stiffness
        over E*/h, h being the size of the surface elements at the contact edges; by default 1000,
        and 300 for augmented_lagrangian.

        - penalty: stiffness of the layer. Pressure per penetration is normal_stiffness E*/h
          [stress/length]. The cost is a penetration p h/(stiffness E*), an elastic slip, and creep
          where the faces should stick, see `FiniteElementSolution.penalty`.
        - active_set: weights of gap and slip in the trial tractions; the answer does not depend on
          them.
        - augmented_lagrangian: the penalty; the answer does not depend on it.
    steps_per_cycle
        regular increments of one revolution or of the longest side of a polygon; instants at
        which a node touches or lets go, and the turning points of the path, come on top, and so
        do halved increments
    step_tolerance
        step error of a revolution, over its dissipation, above which increments are halved;
        "inf" for never
    max_iterations
        of one increment, before it counts as not converged
    """

    method: Method = "active_set"
    normal_stiffness: float | None = None
    tangential_stiffness: float | None = None
    steps_per_cycle: int = 24
    step_tolerance: float = 5e-4
    max_iterations: int = 100

    def __post_init__(self) -> None:
        """Refuse settings of the contact solver outside their ranges.

        A stiffness is traction per gap or per slip, over E*/h: that of a penalty layer between the
        faces, or of the trial tractions that an iteration is driven by; None for the method's
        default.

        # notation: E* contact modulus, h size of the surface elements at the contact edges

        Raises
        ------
        InputError
            With what is allowed, for the first at fault: method, stiffnesses, steps per cycle, step
            tolerance, iterations of an increment.
        """
        if self.method not in get_args(Method):
            raise InputError(
                f"solver: method = {self.method!r} is refused: it is active_set,"
                " augmented_lagrangian or penalty"
            )
        for name in ("normal_stiffness", "tangential_stiffness"):
            stiffness = getattr(self, name)
            if stiffness is not None and not 1e-3 <= stiffness <= 1e9:
                raise InputError(
                    f"solver: {name} = {stiffness!r} is refused: it lies in [0.001, 1e9], over E*/h"
                )
        if not 4 <= self.steps_per_cycle <= 100_000:
            raise InputError(
                f"solver: steps_per_cycle = {self.steps_per_cycle!r} is refused: it lies in [4,"
                " 100000]"
            )
        if not self.step_tolerance >= 1e-8:
            raise InputError(
                f"solver: step_tolerance = {self.step_tolerance!r} is refused: it must be at least"
                " 1e-8"
            )
        if self.max_iterations < 2:
            raise InputError(
                f"solver: max_iterations = {self.max_iterations!r} is refused: it must be at least"
                " 2"
            )

    @property
    def stiffnesses(self) -> tuple[float, float]:
        """Normal and tangential stiffness, over E*/h, as they are set, or by the method's default:
        traction per gap and per slip, in a penalty layer or in the trials of an iteration.

        # notation: E* contact modulus, h size of the surface elements at the contact edges

        >>> SolverSettings().stiffnesses
        (1000.0, 1000.0)
        >>> SolverSettings("augmented_lagrangian", tangential_stiffness=3.0).stiffnesses
        (300.0, 3.0)
        """
        # _PENALTY: 300; _STIFFNESS: 1000, for the methods "active_set" and "penalty"
        default_stiffness = _PENALTY if self.method == "augmented_lagrangian" else _STIFFNESS
        normal_stiffness = (
            default_stiffness if self.normal_stiffness is None else self.normal_stiffness
        )
        tangential_stiffness = (
            default_stiffness if self.tangential_stiffness is None else self.tangential_stiffness
        )
        return normal_stiffness, tangential_stiffness

    def with_stiffnesses(self) -> SolverSettings:
        """These settings with both stiffnesses written out, where they were left to the method's
        default.
        """
        normal_stiffness, tangential_stiffness = self.stiffnesses
        return replace(
            self, normal_stiffness=normal_stiffness, tangential_stiffness=tangential_stiffness
        )
