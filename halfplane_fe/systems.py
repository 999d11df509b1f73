"""Linear systems of the active set: forces that meet the equalities of given node states, factors kept and counted."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from halfplane_fe.active_subsets import CoupledFactor, NestedFactor, SingularSet
from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from scenes import STICK

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Layer:
    """Elastic layer between the faces, the penalty method: compliance of each node; zero for the exact law.

    With it gap and slip in the law are those of the layer's inner faces, g + k_n p and s - k_t q.
    """

    normal: Array
    tangential: Array


class Forces(NamedTuple):
    """Nodal forces (n,) and rigid displacements that go with them."""

    pressure: Array
    shear: Array
    approach: float
    shift: float


@dataclass(eq=False)
class Systems:
    """Compliance of interface and layer, with the factors that serve every set of nodes."""

    interface: Interface
    layer: Layer
    friction: float
    work: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.normal = self.interface.normal + np.diag(self.layer.normal)
        self.tangential = self.interface.tangential + np.diag(self.layer.tangential)
        self._nests: dict[str, NestedFactor] = {}
        coupling, parts = self.interface.coupling, (self.interface, self.normal, self.tangential)
        self._coupled = None if coupling is None else CoupledFactor(*parts, coupling, self.friction, self.work)

    def gap(self, height: Array, forces: Forces) -> Array:
        """Gap of the law, h - n_y delta + n_x U + N p - K^T q."""
        gap = height + self.interface.moved(forces.approach, forces.shift)[0] + self.normal @ forces.pressure
        return gap if self.interface.coupling is None else gap - self.interface.coupling.T @ forces.shear

    def slip(self, forces: Forces) -> Array:
        """Slip of the law, n_y U + n_x delta + K p - T q."""
        slip = self.interface.moved(forces.approach, forces.shift)[1] - self.tangential @ forces.shear
        return slip if self.interface.coupling is None else slip + self.interface.coupling @ forces.pressure

    def pressure_alone(self, closed: Mask, height: Array, load: float) -> tuple[Array, float]:
        """Pressure with n_y p = load, and approach, that close the given nodes over `height`, in which a known shift is."""
        return self._bordered("normal", closed, -height, load)

    def shear_alone(self, states: States, pressure: Array, known_slip: Array, load: float) -> tuple[Array, float]:
        """Shear and shift of flat faces at known pressure: sticking nodes keep slip `known_slip`, sliding ones carry f p."""
        sliding = slip_sign(states) * self.friction * pressure
        stick = states == STICK
        known = -known_slip - self.tangential @ sliding
        held, shift = self._bordered("tangential", stick, known, load - float(sliding.sum()))
        return held + sliding, shift

    def both(self, states: States, height: Array, slip_before: Array, loads: tuple[float, float]) -> Forces:
        """Normal and tangential problem of unlike bodies in one system: p of closed nodes, q of sticking ones, approach, shift."""
        if self._coupled is None:
            raise ValueError("like bodies have no coupled system")
        return Forces(*self._coupled.solve(states, -height, slip_before, loads))

    def held(self, stick: Mask, known: Array) -> Array:
        """Shear (n_stick,) of the sticking nodes with T_SS q = known there."""
        return self._nested("tangential").solve(stick, known)

    def _bordered(self, name: str, active: Mask, known: Array, total: float) -> tuple[Array, float]:
        """Forces f on the active nodes and rigid displacement d with matrix f - n_y d = known there, n_y f = total."""
        if not active.any():
            raise SingularSet(f"no node holds the {name} load")
        nested, border = self._nested(name), self.interface.normals[1][active]
        by_border = nested.by_border(active)
        by_known = nested.solve(active, known[active]) if known[active].any() else np.zeros_like(by_border)
        displacement = (total - float(border @ by_known)) / float(border @ by_border)
        forces = np.zeros(len(active))
        forces[active] = by_known + displacement * by_border
        return forces, displacement

    def _nested(self, name: str) -> NestedFactor:
        if name not in self._nests:
            self._nests[name] = NestedFactor(getattr(self, name), self.interface.x, self.interface.normals[1], self.work)
        return self._nests[name]
