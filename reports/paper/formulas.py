"""The paper's own formulas for its ellipse, mended, written out in plain numbers: what its misprints are held against.

# notation: t time of the ellipse, u = Q - f P, v = Q + f P, A = 2/E* = (1 + kappa)/(2 mu), x, c, a lengths of the scene
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reports.paper.cases import Case
from semi_analytic.friction_work import slip_times
from semi_analytic.quadrature import graded

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Formulas:
    """Loads, tractions of the first cycle, fronts and slip of the steady one: equations (3) to (8), (14) and (16) to (19)."""

    case: Case

    def loads(self, t: ArrayLike) -> tuple[Array, Array]:
        """P and Q, equations (3) and (4)."""
        load, time = self.case.load, np.asarray(t, dtype=float)
        return (
            load.mean_normal_load + load.normal_amplitude * np.cos(time),
            load.mean_tangential_load + load.tangential_amplitude * np.cos(time - load.phase),
        )

    def rates(self, t: ArrayLike) -> tuple[Array, Array]:
        """dP/dt and dQ/dt."""
        load, time = self.case.load, np.asarray(t, dtype=float)
        return -load.normal_amplitude * np.sin(time), -load.tangential_amplitude * np.sin(time - load.phase)

    def level(self, letter: str, sign: int) -> float:
        """Q + sign f P at a letter."""
        event = self.case.events[letter]
        return event.tangential_load + sign * self.case.friction * event.normal_load

    def initial(self) -> tuple[float, float]:
        """alpha and beta of the initial loading Q = alpha P + beta P^2, a parabola from (0, 0) tangent to the ellipse at A."""
        a, (dp, dq) = self.case.events["A"], self.rates(self.case.time("A"))
        beta = (float(dq / dp) * a.normal_load - a.tangential_load) / a.normal_load**2
        return float(dq / dp) - 2 * beta * a.normal_load, beta

    def initial_meeting(self, t: float) -> float:
        """P_Y of equation (6), at E P_Z of (7): where the line of gradient f through the point at t meets the path O-A-B."""
        case, (alpha, beta) = self.case, self.initial()
        mirrored = 2 * case.time("B") - t
        if mirrored >= case.time("A"):
            return float(self.loads(mirrored)[0])
        p, q = self.loads(t)
        level, slope = float(q - case.friction * p), alpha - case.friction
        # The root of beta P^2 + slope P = level that stays finite for beta = 0; slope < 0.
        return 2 * level / (slope - math.sqrt(slope * slope + 4 * beta * level))

    def stuck(self, x: Array, load: float) -> Array:
        """int_0^P p'(x, eta) dQ/d eta d eta along O-A and the ellipse after A, the integral in equations (5) to (7).

        By parts, for p' has an inverse root where the contact reaches x: dQ/dP p(x, P) - int p(x, eta) d2Q/d eta2 d eta.
        """
        case, (alpha, beta) = self.case, self.initial()
        first, edge = case.events["A"].normal_load, np.asarray(case.contact.load(x))

        def ellipse(p: Array) -> tuple[Array, Array]:
            """dQ/dP and its derivative on the rising half of the ellipse."""
            turn = 2 * math.pi - np.arccos((p - case.load.mean_normal_load) / case.load.normal_amplitude)
            (dp, dq), (ddp, ddq) = self.rates(turn), self.rates(turn + math.pi / 2)
            return dq / dp, (ddq * dp - dq * ddp) / dp**3

        total = (alpha + 2 * beta * load if load <= first else ellipse(np.asarray(load))[0]) * case.contact.pressure(x, load)
        for begin, end, onwards in ((0.0, min(load, first), False), (first, max(load, first), True)):
            p, weights = graded(np.clip(edge, begin, end), np.full(len(x), end))
            bend = ellipse(p)[1] if onwards else np.full_like(p, 2 * beta)
            total = total - np.sum(weights * bend * case.contact.pressure(x[:, None], p), axis=-1)
        return np.asarray(total)

    def twin(self, t: ArrayLike) -> Array:
        """Time of Y of the paper: where the line of gradient f through t meets the stretch G-I of the loop."""
        return 2 * self.case.time("I") - np.asarray(t, dtype=float)

    def front(self, phase: str, t: ArrayLike) -> Array:
        """P_c: P_S of equation (8) in EG, P_Y in IJ, what the paper calls P_K in JM."""
        f, (p, q) = self.case.friction, self.loads(t)
        if phase == "IJ":
            return self.loads(self.twin(t))[0]
        return (q + f * p - self.level("E", -1)) / (2 * f) if phase == "EG" else (self.level("G", 1) - q + f * p) / (2 * f)

    def front_rate(self, phase: str, t: ArrayLike) -> Array:
        """dP_c/dt."""
        f, (dp, dq) = self.case.friction, self.rates(t)
        if phase == "IJ":
            return -self.rates(self.twin(t))[0]
        return (f * dp + dq) / (2 * f) if phase == "EG" else (f * dp - dq) / (2 * f)

    def multiplier(self, phase: str, t: ArrayLike) -> Array:
        """C of equation (14), as printed."""
        dp, dq = self.rates(self.twin(t) if phase == "IJ" else t)
        return dq / dp / self.case.friction + (1 if phase == "EG" else -1)

    def driving(self, phase: str, t: ArrayLike) -> Array:
        """C dP/dt with the sign of slip: dv/f in EG, du/f in IJ and JM (where C dP is C dP_Y)."""
        f, (dp, dq) = self.case.friction, self.rates(t)
        return dq / f + (dp if phase == "EG" else -dp)

    def reach(self, x: float | Array, load: ArrayLike) -> Array:
        """arccosh(x/a(P)), 0 inside: int_a^x dx / sqrt(x^2 - a^2)."""
        return np.arccosh(np.maximum(x / np.asarray(self.case.contact.half_width(load)), 1.0))

    def slip_rate(self, phase: str, x: float, t: ArrayLike) -> Array:
        """ds/dt, equations (16), (18) and (19) mended; x in or out of contact.

        ds = (A/pi) f [C dP arccosh(x/c) - sign dP arccosh(x/a)], the sign being + in EG and - in IJ and JM.
        """
        own = self.driving(phase, t) * self.reach(x, self.front(phase, t))
        outside = (1 if phase == "EG" else -1) * self.rates(t)[0] * self.reach(x, self.loads(t)[0])
        return self.case.compliance * self.case.friction / math.pi * (own - outside)

    def moved(self, x: float, begin: float, end: float) -> float:
        """The engine's change of s at x between two times in which the steady cycle is marched along."""
        return float(np.diff(self.case.solve(time=[begin, end], x=[x / self.case.length], fields=("slip",)).slip[:, 0])[0])

    def rubbing(self, phase: str, x: float, rate: Callable[[Array], ArrayLike]) -> float:
        """Integral of a rate over the times at which x rubs in a phase."""
        edge_load, whole = np.asarray(self.case.contact.load(np.array([x]))), 0.0
        for span in self.case.slipping[phase]:
            begin, end = (float(time[0]) for time in slip_times(span, edge_load))
            if end > begin:
                whole += integral(rate, begin + span.delay, end + span.delay)
        return whole


def integral(rate: Callable[[Array], ArrayLike], begin: float, end: float) -> float:
    """Integral of a function that may have roots at both ends."""
    t, weights = graded(begin, end)
    return float(np.sum(np.asarray(rate(t)) * weights))
