"""What the elastic layer of the penalty method costs: overlap of the faces, elastic slip, creep of nodes that should stick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.contact import ContactProblem, InterfaceState
from halfplane_fe.law import slip_sign
from halfplane_fe.scales import Scales
from scenes import STICK, Scene


@dataclass(frozen=True)
class PenaltyAudit:
    """The layer and what it does; without one (augmented Lagrangian) the stiffnesses are infinite and the rest is zero or rounding.

    Attributes
    ----------
    normal_stiffness, tangential_stiffness : pressure per overlap, shear per elastic slip [stress/length]
    penetration : largest overlap of the two faces on the whole path [length]
    penetration_share : the same over the rise h(a) - h(0) of the profile at the largest contact (a^2/2R for Hertz)
    elastic_slip : largest elastic slip of the layer [length]
    elastic_slip_share : the same over the largest slip of the last cycle; NaN where nothing slips
    creep : largest range, over the last cycle, of the relative displacement of a node that sticks all through it [length]
    creep_share : the same over the largest slip of the last cycle; NaN where nothing slips
    """

    normal_stiffness: float
    tangential_stiffness: float
    penetration: float
    penetration_share: float
    elastic_slip: float
    elastic_slip_share: float
    creep: float
    creep_share: float

    def note(self) -> str | None:
        """The costs as a sentence; None where there is no layer."""
        if np.isinf(self.normal_stiffness) and np.isinf(self.tangential_stiffness):
            return None
        stiffness = f"{self.normal_stiffness:.3g} normal and {self.tangential_stiffness:.3g} tangential [stress/length]"
        overlap = f"{self.penetration:.2g} [length], {self.penetration_share:.1e} of the profile's rise over the contact"
        slip = f"{self.elastic_slip:.2g}, {self.elastic_slip_share:.1e} of the largest slip"
        return (
            f"penalty layer, stiffness {stiffness}: the faces overlap by up to {overlap}; elastic slip up to {slip}; nodes "
            f"that stick through the whole cycle creep by up to {self.creep:.2g}, {self.creep_share:.1e} of it"
        )


def penalty_audit(
    scene: Scene, problem: ContactProblem, states: Sequence[InterfaceState], arrays: Mapping[str, Any], scales: Scales
) -> PenaltyAudit:
    """Read the costs off the arrays of an answer (see `answer_arrays`) and its interface states."""
    layer, weights = problem.layer, problem.interface.weights * scales.half_width
    compliance = {
        "normal": layer.normal / scales.modulus,
        "tangential": layer.tangential / scales.modulus,
    }  # length per nodal force
    stiffness = {name: _stiffness(values, weights) for name, values in compliance.items()}
    forces = {name: np.abs(arrays[name]) * weights for name in ("pressure", "shear")}
    penetration = float(np.max(compliance["normal"] * forces["pressure"], initial=0.0))
    elastic_slip = float(np.max(compliance["tangential"] * forces["shear"], initial=0.0))
    half_width = float(np.nanmax(arrays["contact_half_width"]))
    rise = float(np.ptp(scene.profile.height(np.array([0.0, half_width]))))
    creep, slip = _creep_and_slip(scene, np.array([state.state for state in states]), arrays)
    return PenaltyAudit(
        normal_stiffness=stiffness["normal"],
        tangential_stiffness=stiffness["tangential"],
        penetration=penetration,
        penetration_share=penetration / rise if rise else float("nan"),
        elastic_slip=elastic_slip,
        elastic_slip_share=elastic_slip / slip if slip else float("nan"),
        creep=creep,
        creep_share=creep / slip if slip else float("nan"),
    )


def _stiffness(compliance: np.ndarray, weights: np.ndarray) -> float:
    """Stress per length of a layer that has one stiffness everywhere."""
    largest = float(np.max(compliance * weights))
    return 1 / largest if largest else float("inf")


def _creep_and_slip(scene: Scene, law: NDArray[np.int8], arrays: Mapping[str, Any]) -> tuple[float, float]:
    """Largest range of relative displacement, in the last cycle, of nodes that stick throughout and of nodes that slip.

    By the law's own states (n_steps, n): those that a reader sees count a node that has hardly moved as sticking.
    """
    period, time = scene.load.path().period, arrays["time"]
    cycle = np.ones(len(time), dtype=bool) if period is None else time > time[-1] - period * (1 + 1e-9)
    state, slip = law[cycle], arrays["slip"][cycle]
    spread = np.ptp(slip, axis=0)
    sticks = np.all(state[1:] == STICK, axis=0)
    slips = np.any(slip_sign(state) != 0, axis=0)
    return float(np.max(spread[sticks], initial=0.0)), float(np.max(spread[slips], initial=0.0))
