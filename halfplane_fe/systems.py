"""Linear systems of the active set: forces that meet the equalities of given node states, factors kept and counted."""

from __future__ import annotations

import warnings
from collections import Counter, OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve

from halfplane_fe.interface import Interface
from halfplane_fe.law import slip_sign
from halfplane_fe.nested import NestedFactor
from scenes import SurfaceState

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
States = NDArray[np.int8]

# Bytes of factorised matrices of unlike bodies kept: a cycle meets the same sets of nodes again and again.
_KEPT_BYTES = 400_000_000


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
    """Compliance of interface and layer, with their factors: nested for like bodies, else those of the sets met so far."""

    interface: Interface
    layer: Layer
    friction: float
    work: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.normal = self.interface.normal + np.diag(self.layer.normal)
        self.tangential = self.interface.tangential + np.diag(self.layer.tangential)
        self._nests: dict[str, NestedFactor] = {}
        self._kept: OrderedDict[tuple[str, bytes], tuple[Array, Array]] = OrderedDict()
        self._bytes = 0

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
        stick = states == SurfaceState.STICK
        known = -known_slip - self.tangential @ sliding
        held, shift = self._bordered("tangential", stick, known, load - float(sliding.sum()))
        return held + sliding, shift

    def both(self, states: States, height: Array, slip_before: Array, loads: tuple[float, float]) -> Forces:
        """Normal and tangential problem of unlike bodies in one system: p of closed nodes, q of sticking ones, approach, shift."""
        closed, stick = states != SurfaceState.OPEN, states == SurfaceState.STICK
        traction: Array = np.asarray(slip_sign(states) * self.friction, dtype=np.float64)  # q = traction * p where a node slides
        n, m = int(closed.sum()), int(stick.sum())
        factors = self._factors(("both", states.tobytes()), lambda: _lu(self._matrix(closed, stick, traction)))
        right = np.concatenate([-height[closed], slip_before[stick], loads])
        found = lu_solve(factors, right, check_finite=False)
        pressure, shear = np.zeros(len(states)), np.zeros(len(states))
        pressure[closed] = found[:n]
        shear[stick] = found[n : n + m]
        return Forces(pressure, shear + traction * pressure, float(found[n + m]), float(found[n + m + 1]))

    def _matrix(self, closed: Mask, stick: Mask, traction: Array) -> Array:
        """Rows: gap of closed nodes, slip of sticking ones, the two loads; columns: p, q, approach, shift."""
        coupling = self.interface.coupling
        if coupling is None:
            raise ValueError("like bodies have no coupled system")
        by_pressure = self.normal - coupling.T * traction  # gap by p, sliding nodes taking their q along
        slip_by_pressure = coupling - self.tangential * traction
        n, m = int(closed.sum()), int(stick.sum())
        n_x, n_y = self.interface.normals
        matrix = np.zeros((n + m + 2, n + m + 2))
        matrix[:n, :n] = by_pressure[np.ix_(closed, closed)]
        matrix[:n, n : n + m] = -coupling.T[np.ix_(closed, stick)]
        matrix[:n, n + m], matrix[:n, n + m + 1] = -n_y[closed], n_x[closed]
        matrix[n : n + m, :n] = slip_by_pressure[np.ix_(stick, closed)]
        matrix[n : n + m, n : n + m] = -self.tangential[np.ix_(stick, stick)]
        matrix[n : n + m, n + m], matrix[n : n + m, n + m + 1] = n_x[stick], n_y[stick]
        matrix[n + m, :n], matrix[n + m, n : n + m] = (n_y + traction * n_x)[closed], n_x[stick]
        matrix[n + m + 1, :n], matrix[n + m + 1, n : n + m] = (traction * n_y - n_x)[closed], n_y[stick]
        return matrix

    def held(self, stick: Mask, known: Array) -> Array:
        """Shear (n_stick,) of the sticking nodes with T_SS q = known there."""
        return self._nested("tangential").solve(stick, known)

    def _bordered(self, name: str, active: Mask, known: Array, total: float) -> tuple[Array, float]:
        """Forces f on the active nodes and rigid displacement d with matrix f - n_y d = known there, n_y f = total."""
        if not active.any():
            raise SingularSet(f"no node holds the {name} load")
        nested, border = self._nested(name), self.interface.normals[1][active]
        by_known, by_border = nested.solve(active, known[active]), nested.by_border(active)
        displacement = (total - float(border @ by_known)) / float(border @ by_border)
        forces = np.zeros(len(active))
        forces[active] = by_known + displacement * by_border
        return forces, displacement

    def _nested(self, name: str) -> NestedFactor:
        if name not in self._nests:
            self._nests[name] = NestedFactor(getattr(self, name), self.interface.x, self.interface.normals[1], self.work)
        return self._nests[name]

    def _factors(self, key: tuple[str, bytes], make: Callable[[], tuple[Array, Array]]) -> tuple[Array, Array]:
        """The factors of a set of nodes: from store, or made now; the longest unused give way."""
        self.work["linear solves"] += 1
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        factors = make()
        self.work["factorisations"] += 1
        self._kept[key] = factors
        self._bytes += factors[0].nbytes
        while self._bytes > _KEPT_BYTES and len(self._kept) > 1:
            self._bytes -= self._kept.popitem(last=False)[1][0].nbytes
        return factors


def _lu(matrix: Array) -> tuple[Array, Array]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", LinAlgWarning)
            return lu_factor(matrix, check_finite=False)
    except LinAlgWarning as reason:
        raise SingularSet(str(reason)) from reason


class SingularSet(ArithmeticError):
    """A set of node states that leaves the bodies free to move: no answer, try another set."""
