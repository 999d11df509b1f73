"""The paper's two examples as the engine solves them, with the units in which the paper draws them.

`Case` has the engine's answers, `Formulas` the paper's own equations, mended, written out in plain
numbers: what its misprints are held against.

# notation: a0 = a(P0), A = 2/E*, unit load P0/3, so that the loads are 3, 1.1, 1, 1 as the paper
prints them; in the formulas # t is the time of the ellipse, u = Q - f P, v = Q + f P, A = (1 +
kappa)/(2 mu), x, c, a lengths of the scene
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import semi_analytic
from scenes import ContactSolution, EllipseLoad, InputError, Scene, load_scene, read_only_copy
from scenes.array_types import Array
from semi_analytic.elasticity import composite_modulus
from semi_analytic.friction_work import pointwise_dissipation, slip_times
from semi_analytic.history import Span, history_of
from semi_analytic.profiles import Contact, contact_of
from semi_analytic.quadrature import graded_nodes

# Names of both examples in the library.
_HERTZ = "hertz-paper"
_ROUNDED = "flat-rounded-paper"
FRICTIONS = (1.0, 0.8, 0.6, 0.4)
"""Coefficients of friction of figure 4b, used in the grids of figures 7 and 10 as well."""
POINTS = (0.77, 0.82, 1.0, 1.13)
"""x/a0 of figure 5."""
LETTERS = "ABCDEFGHIJKLM"


@dataclass(frozen=True, eq=False)
class Case:
    """One of the paper's ellipses on one of its profiles. Scaled: loads over P0/3, lengths over a0,
    slips over A P0/3.
    """

    scene: Scene

    @property
    def load_ellipse(self) -> EllipseLoad:
        """The ellipse of loads: means and amplitudes of P and Q, and the phase. InputError where
        the scene has loads of another kind.
        """
        load = self.scene.load
        if not isinstance(load, EllipseLoad):
            raise InputError(
                f"{self.scene.name}: the paper's figures are about an ellipse, not {load.kind}"
            )
        return load

    @property
    def friction(self) -> float:
        """Coefficient of friction f."""
        return self.scene.friction.coefficient

    @cached_property
    def contact(self) -> Contact:
        """Normal contact of the profile."""
        return contact_of(self.scene.profile, self.scene.material)

    @property
    def unit_load(self) -> float:
        """P0/3 [force per thickness]; unit of scaled loads."""
        return self.load_ellipse.mean_normal_load / 3

    @property
    def unit_length(self) -> float:
        """a0 = a(P0) [length], the contact half-width at the mean load; unit of scaled lengths."""
        return float(self.contact.half_width(self.load_ellipse.mean_normal_load))

    @property
    def compliance(self) -> float:
        """A = 2/E* [1/stress]."""
        return 2 / composite_modulus(self.scene.material)

    @property
    def unit_slip(self) -> float:
        """A P0/3 [length]; unit of scaled slips."""
        return self.compliance * self.unit_load

    @property
    def unit_work(self) -> float:
        """A f^2 P0^2 [energy per thickness], the unit of a cycle's dissipation."""
        return self.compliance * (self.friction * self.load_ellipse.mean_normal_load) ** 2

    def scaled_half_width(self, load: ArrayLike) -> Array:
        """a(P)/a0 from normal loads P [force per thickness]."""
        return np.asarray(self.contact.half_width(load)) / self.unit_length

    def solve(
        self,
        time: ArrayLike | None = None,
        x: ArrayLike = (0.0,),
        fields: Iterable[str] = (),
        *,
        steady: bool = False,
    ) -> ContactSolution:
        """Solve this ellipse of loads by half-plane theory.

        Parameters
        ----------
        time
            instants of the load path; those of the engine by default
        x
            places on the surface, in units of the half-width a0 at the mean load
        fields
            names of the fields that are wanted, such as "shear"; all by default
        steady
            whether only the steady cycle is followed
        """
        places = np.asarray(x, dtype=float) * self.unit_length
        return semi_analytic.solve(
            self.scene, x=places, time=time, fields=fields, cycles="steady" if steady else "all"
        )

    @cached_property
    def events(self) -> Mapping[str, semi_analytic.Event]:
        """Letter A to M of the paper -> its event of the load path: `time` [rad], `normal_load`,
        `tangential_load`, and `front_load`, the normal load whose contact is the stick zone.
        """
        return {
            letter: event for event in semi_analytic.events(self.scene) for letter in event.letter
        }

    def time_of(self, letter: str) -> float:
        """Time [rad] of the event that the paper calls by a letter."""
        return self.events[letter].time

    def half_width_at(self, letter: str) -> float:
        """Contact half-width over a0 at the event that the paper calls by a letter."""
        return float(self.scaled_half_width(self.events[letter].normal_load))

    def scaled_loads(self, time: ArrayLike) -> tuple[Array, Array]:
        """P and Q over P0/3 at instants of the load path."""
        normal_load, tangential_load = self.scene.load.path().at(time)
        return normal_load / self.unit_load, tangential_load / self.unit_load

    def cycle_times(self, n_instants: int = 361) -> Array:
        """(n_instants,) instants of one steady revolution that starts at M, and ends there."""
        return self.time_of("M") + np.linspace(0.0, 2 * math.pi, n_instants)

    @cached_property
    def steady_cycle(self) -> ContactSolution:
        """Solution of the steady cycle: dissipation W, its value as a closed integral of Q dU
        (`loop_work`), and the permanent stick zone.
        """
        return self.solve(fields=("loop_work",), steady=True)

    @property
    def permanent_stick_half_width(self) -> float:
        """Half-width of the permanent stick zone over a0."""
        return self.steady_cycle.permanent_stick_half_width / self.unit_length

    @property
    def largest_half_width(self) -> float:
        """Largest contact half-width over a0."""
        return float(
            self.scaled_half_width(
                self.load_ellipse.mean_normal_load + self.load_ellipse.normal_amplitude
            )
        )

    @cached_property
    def slip_spans(self) -> Mapping[str, tuple[Span, ...]]:
        """Spans of time in which points slip in the steady cycle, by the paper's phases: reverse
        slip EG, forward slip IJ and JM, each named by the events at its two ends.

        Of a span, `direction` is +1 in forward slip, −1 in reverse slip, 0 in full stick; `begin`
        and `end` are its instants.
        """
        # spans of the last cycle, in which slip keeps its direction
        spans = history_of(self.scene.load.path(), self.friction, self.scene.cycles).cycles[-1]
        # Times of the spans may be a cycle before those of the events: J is as long after the begin
        # of forward slip as the event J is after I.
        start_of_forward = min(span.begin.time for span in spans if span.direction > 0)
        time_of_j = start_of_forward + self.time_of("J") - self.time_of("I")
        spans_by_phase: dict[str, list[Span]] = {"EG": [], "IJ": [], "JM": []}
        for span in spans:
            middle_time = (span.begin.time + span.end.time) / 2
            if span.direction < 0:
                spans_by_phase["EG"].append(span)
            elif span.direction > 0 and middle_time < time_of_j:
                spans_by_phase["IJ"].append(span)
            elif span.direction > 0:
                spans_by_phase["JM"].append(span)
        return {phase: tuple(phase_spans) for phase, phase_spans in spans_by_phase.items()}

    def density_of_phases(self, x: ArrayLike) -> dict[str, Array]:
        """Part of the pointwise dissipation W(x), the friction work per area of a steady cycle, in
        each phase of slip: "EG" reverse, "IJ" and "JM" forward. `x` (n,) is over a0, each part (n,)
        over A f^2 P0^2/a0.

        # notation: a0 contact half-width at the mean normal load P0 (`unit_length`), f friction,
        #           A = 2/E*, `unit_work` A f^2 P0^2
        """
        points = np.asarray(x, dtype=float) * self.unit_length
        modulus = composite_modulus(self.scene.material)  # E*
        # slip_spans: phase -> its spans of time
        parts = {
            phase: pointwise_dissipation(self.contact, modulus, spans, points)
            for phase, spans in self.slip_spans.items()
        }
        return {
            # total: of forward and reverse slip together
            phase: self.unit_length / self.unit_work * part.total
            for phase, part in parts.items()
        }

    def batch_arguments(self, **changes: Any) -> dict[str, Any]:
        """Keyword arguments for the dissipation of many load ellipses at once: profile, material,
        coefficient of friction and loads of this case, with `changes` in place of some. Loads and
        friction may be arrays. They fit `semi_analytic.dissipation` and `peak_dissipation`.
        """
        load_names = (
            "mean_normal_load",
            "normal_amplitude",
            "mean_tangential_load",
            "tangential_amplitude",
            "phase_radians",
        )
        contact_arguments = {
            "profile": self.scene.profile,
            "material": self.scene.material,
            "friction_coefficient": self.friction,
        }
        return (
            contact_arguments
            | {name: getattr(self.load_ellipse, name) for name in load_names}
            | changes
        )

    def circle_arguments(
        self, friction: ArrayLike, ratio: ArrayLike, **changes: Any
    ) -> dict[str, Any]:
        """Keyword arguments for the dissipation of loads that go round circles about Q = 0 in the
        plane of P and Q. Both amplitudes Q1 = P1 are P0/3 of this case, and the mean normal load is
        `ratio` times P1. `friction` and `ratio` may be arrays; `changes` replace further arguments.
        They fit `semi_analytic.dissipation` and `peak_dissipation`.
        """
        loads = {
            "mean_normal_load": np.asarray(ratio) * self.unit_load,
            "normal_amplitude": self.unit_load,
            "tangential_amplitude": self.unit_load,
        }
        return self.batch_arguments(
            friction_coefficient=friction, mean_tangential_load=0.0, **loads, **changes
        )

    def with_load(self, friction: float | None = None, **changes: Any) -> Case:
        """The case with another coefficient of friction, or other parameters of the load ellipse
        (`changes`).
        """
        return Case(
            self.scene.vary(load=changes, friction=self.friction if friction is None else friction)
        )

    def scaled_ten_times(self) -> Case:
        """The case with the profile's radius and all loads (per thickness) times ten: half-widths
        and loads grow tenfold, stresses stay as they are. For a parabola, whose radius is its only
        length.
        """
        load_names = (
            "mean_normal_load",
            "normal_amplitude",
            "mean_tangential_load",
            "tangential_amplitude",
        )
        radius = 10 * self.scene.profile.model_dump()["radius"]
        return Case(
            self.scene.vary(
                profile={"radius": radius},
                load={name: 10 * getattr(self.load_ellipse, name) for name in load_names},
            )
        )

    def with_zero_mean_shear(self, friction: float) -> Case:
        """The case with the same amplitudes about Q0 = 0 and another f: the widest range of f
        before gross sliding.
        """
        return self.with_load(
            friction=friction, mean_tangential_load=0.0, initial_loading="straight"
        )


@dataclass(frozen=True, eq=False)
class Formulas:
    """The paper's equations (3) to (8), (14) and (16) to (19), mended: loads, tractions of the
    first cycle, stick edges and slip of the steady cycle.

    All values are in units of the scene; times are in radians of the ellipse.
    """

    case: Case

    def loads(self, t: ArrayLike) -> tuple[Array, Array]:
        """P and Q at times t, equations (3) and (4)."""
        ellipse = self.case.load_ellipse
        time = np.asarray(t, dtype=float)
        normal_load = ellipse.mean_normal_load + ellipse.normal_amplitude * np.cos(time)
        tangential_load = ellipse.mean_tangential_load + ellipse.tangential_amplitude * np.cos(
            time - ellipse.phase_radians
        )
        return normal_load, tangential_load

    def rates(self, t: ArrayLike) -> tuple[Array, Array]:
        """dP/dt and dQ/dt at times t."""
        ellipse = self.case.load_ellipse
        time = np.asarray(t, dtype=float)
        normal_rate = -ellipse.normal_amplitude * np.sin(time)
        tangential_rate = -ellipse.tangential_amplitude * np.sin(time - ellipse.phase_radians)
        return normal_rate, tangential_rate

    def q_plus_f_p(self, letter: str, sign: int) -> float:
        """Q + f P at the event that the paper calls by a letter; Q - f P if `sign` is -1."""
        event = self.case.events[letter]
        return event.tangential_load + sign * self.case.friction * event.normal_load

    def initial_parabola(self) -> tuple[float, float]:
        """alpha and beta of the initial loading Q = alpha P + beta P^2. This parabola from no load
        is tangent to the ellipse of loads at the event A, where the ellipse begins.
        """
        event_a = self.case.events["A"]
        normal_rate, tangential_rate = self.rates(self.case.time_of("A"))
        slope = float(tangential_rate / normal_rate)
        beta = (slope * event_a.normal_load - event_a.tangential_load) / event_a.normal_load**2
        return slope - 2 * beta * event_a.normal_load, beta

    def intersection_with_initial_loading(self, t: float) -> float:
        """The normal load at which the line of gradient f through the loads at time t meets the
        path of full stick, in the plane of P and Q. This path is the initial loading up to the
        event A, where the ellipse begins, and the ellipse from there to B, where slip begins. The
        paper calls the load P_Y in equation (6), and P_Z in (7), where t is the time of E, the end
        of forward slip.
        """
        case = self.case  # the ellipse of loads on its profile, with its events by letter
        alpha, beta = self.initial_parabola()  # Q = alpha P + beta P^2

        # On the ellipse: Q - f P is a cosine of time that is least at B. It has the same value as
        # long before B as after.
        mirrored_time = 2 * case.time_of("B") - t
        if mirrored_time >= case.time_of("A"):
            return float(self.loads(mirrored_time)[0])

        # On the parabola.
        normal_load, tangential_load = self.loads(t)
        q_minus_f_p = float(tangential_load - case.friction * normal_load)
        alpha_minus_f = alpha - case.friction
        # The root P of beta P^2 + (alpha - f) P = Q - f P at t: the one that stays finite for
        # beta = 0; alpha - f < 0.
        return (
            2
            * q_minus_f_p
            / (alpha_minus_f - math.sqrt(alpha_minus_f * alpha_minus_f + 4 * beta * q_minus_f_p))
        )

    def shear_of_full_stick(self, x: Array, end_load: float) -> Array:
        """Shear traction q, (n,), at points x (n,) after loading without slip up to the normal load
        `end_load`. It is the integral of p'(x, P) dQ/dP over P, in the paper's equations (5) to
        (7), where p' = dp/dP. The loads follow the initial parabola Q = alpha P + beta P^2 up to
        the event A, and the ellipse of loads after A.

        By parts it is dQ/dP p(x, P) − int p(x, P) d2Q/dP2 dP: p' itself has an inverse root at the
        load whose contact reaches x.

        # notation: P normal load, p pressure, Q tangential load
        """
        load_at_a = self.case.events["A"].normal_load
        # dQ/dP at the end of loading, times the pressure there
        derivatives_at_end = self._derivatives_on_parabola
        if end_load > load_at_a:
            derivatives_at_end = self._derivatives_on_ellipse
        slope, _ = derivatives_at_end(np.asarray(end_load))
        shear = slope * self.case.contact.pressure(x, end_load)
        # the integral, on the parabola and on the ellipse
        ranges_of_load = (
            (0.0, min(end_load, load_at_a), self._derivatives_on_parabola),
            (load_at_a, max(end_load, load_at_a), self._derivatives_on_ellipse),
        )
        for first_load, last_load, derivatives in ranges_of_load:
            shear = shear - self._integral_over_loads(x, first_load, last_load, derivatives)
        return np.asarray(shear)

    def _integral_over_loads(
        self,
        x: Array,
        first_load: float,
        last_load: float,
        derivatives: Callable[[Array], tuple[Array, Array]],
    ) -> Array:
        """Integral of p(x, P) d2Q/dP2 over P between two normal loads, at points x (n,) [stress].
        It begins at the load at which the edge of contact reaches x, where that is larger.

        `derivatives` gives dQ/dP and d2Q/dP2 at normal loads.

        # notation: P normal load, p pressure, Q tangential load
        """
        contact = self.case.contact
        edge_load = np.asarray(contact.load(x))
        # nodes and weights of quadrature, (n, nodes), nodes closer together at both ends
        normal_loads, weights = graded_nodes(
            np.clip(edge_load, first_load, last_load), np.full(len(x), last_load)
        )
        _, second_derivative = derivatives(normal_loads)
        pressure = contact.pressure(x[:, None], normal_loads)
        return np.asarray(np.sum(weights * second_derivative * pressure, axis=-1))

    def _derivatives_on_parabola(self, normal_loads: Array) -> tuple[Array, Array]:
        """dQ/dP and d2Q/dP2 of the initial loading Q = alpha P + beta P^2, at normal loads P.

        # notation: Q tangential load
        """
        alpha, beta = self.initial_parabola()
        return (
            np.asarray(alpha + 2 * beta * normal_loads),
            np.full_like(normal_loads, 2 * beta, dtype=float),
        )

    def _derivatives_on_ellipse(self, normal_loads: Array) -> tuple[Array, Array]:
        """dQ/dP and d2Q/dP2 at normal loads P, on the half of the load ellipse on which P rises.

        # notation: Q tangential load
        """
        ellipse = self.case.load_ellipse
        # P is the mean load plus the amplitude times cos(time)
        time = 2 * math.pi - np.arccos(
            (normal_loads - ellipse.mean_normal_load) / ellipse.normal_amplitude
        )
        rate_of_p, rate_of_q = self.rates(time)  # dP/dt, dQ/dt
        # They are sines of time: their derivatives now are their values a quarter turn later.
        second_rate_of_p, second_rate_of_q = self.rates(time + math.pi / 2)
        return rate_of_q / rate_of_p, (
            second_rate_of_q * rate_of_p - rate_of_q * second_rate_of_p
        ) / rate_of_p**3

    def mirrored_time(self, t: ArrayLike) -> Array:
        """Time of the paper's point Y: where the line of gradient f through the loads at time t
        meets the ellipse again, between G (end of reverse slip) and I (begin of forward slip).

        Q - f P is a cosine of time that is least at I, so that it has the same value as long before
        I as after.
        """
        return 2 * self.case.time_of("I") - np.asarray(t, dtype=float)

    def stick_edge_load(self, phase: str, t: ArrayLike) -> Array:
        """The normal load whose contact half-width is that of the stick zone. The times `t` lie in
        a phase of slip, "EG" reverse, "IJ" or "JM" forward, each from event to event. The paper
        calls it P_S in EG, P_Y in IJ, and P_K in JM.

        `q_plus_f_p(letter, sign)` is Q + sign f P at an event.
        """
        if phase == "IJ":
            # P where Q - f P had the same value before I, the begin of forward slip
            return self.loads(self.mirrored_time(t))[0]
        friction_coefficient = self.case.friction
        normal_load, tangential_load = self.loads(t)
        if phase == "EG":
            return (
                tangential_load + friction_coefficient * normal_load - self.q_plus_f_p("E", -1)
            ) / (2 * friction_coefficient)
        return (self.q_plus_f_p("G", 1) - tangential_load + friction_coefficient * normal_load) / (
            2 * friction_coefficient
        )

    def stick_edge_load_rate(self, phase: str, t: ArrayLike) -> Array:
        """Rate in time of the normal load whose contact half-width is that of the stick zone. The
        times `t` lie in a phase of slip, "EG" reverse, "IJ" or "JM" forward, each from event to
        event.
        """
        if phase == "IJ":
            # minus dP/dt at a time as long before I, the begin of forward slip, as t is after it
            return -self.rates(self.mirrored_time(t))[0]
        friction_coefficient = self.case.friction
        normal_rate, tangential_rate = self.rates(t)
        if phase == "EG":
            return (friction_coefficient * normal_rate + tangential_rate) / (
                2 * friction_coefficient
            )
        return (friction_coefficient * normal_rate - tangential_rate) / (2 * friction_coefficient)

    def multiplier_c(self, phase: str, t: ArrayLike) -> Array:
        """C of the paper's equation (14), as printed, the factor of dP in the increment of slip. It
        is (dQ/dP)/f, plus 1 in the phase EG of reverse slip, minus 1 in IJ and JM of forward slip.
        `t` are times in that phase; in IJ dQ/dP is taken as long before I, the begin of forward
        slip, as t is after it.
        """
        normal_rate, tangential_rate = self.rates(self.mirrored_time(t) if phase == "IJ" else t)
        return tangential_rate / normal_rate / self.case.friction + (1 if phase == "EG" else -1)

    def multiplied_load_rate(self, phase: str, t: ArrayLike) -> Array:
        """C dP/dt of the paper's equation (14), mended; it has the sign of the slip. It is d(Q + f
        P)/dt / f in the phase EG of reverse slip, d(Q - f P)/dt / f in IJ and JM of forward slip.
        In IJ it is C dP_Y/dt.
        """
        normal_rate, tangential_rate = self.rates(t)
        sign = 1 if phase == "EG" else -1
        return tangential_rate / self.case.friction + sign * normal_rate

    def arccosh_ratio(self, x: float | Array, load: ArrayLike) -> Array:
        """arccosh(x/a), 0 for x < a, where a is the contact half-width at a normal load: int_a^x
        dx' / sqrt(x'^2 - a^2), with which slip outside a stick zone grows.
        """
        return np.arccosh(np.maximum(x / np.asarray(self.case.contact.half_width(load)), 1.0))

    def slip_rate(self, phase: str, x: float, t: ArrayLike) -> Array:
        """Rate of slip ds/dt at x, in or out of contact, by the paper's equations (16), (18) and
        (19), mended. The phases of slip are EG (reverse), IJ and JM (forward). ds = (A f/pi) [C dP
        arccosh(x/c) - sign dP arccosh(x/a)], the sign being + in EG and - in IJ and JM.

        # notation: a, c half-widths of contact and stick zone, A = 2/E* the compliance, f friction,
        #           C the multiplier of the paper's equation (14), (dQ/dP)/f + sign; in IJ C dP is
        #           taken at an earlier load P_Y
        """
        sign = 1 if phase == "EG" else -1
        normal_load, _ = self.loads(t)
        normal_load_rate, _ = self.rates(t)
        # C dP/dt arccosh(x/c), c being the contact half-width under `stick_edge_load`
        part_by_stick_edge = self.multiplied_load_rate(phase, t) * self.arccosh_ratio(
            x, self.stick_edge_load(phase, t)
        )
        part_by_load = sign * normal_load_rate * self.arccosh_ratio(x, normal_load)
        return (
            self.case.compliance
            * self.case.friction
            / math.pi
            * (part_by_stick_edge - part_by_load)
        )

    def engine_slip(self, x: float, start: float, end: float) -> float:
        """The slip s that a point at `x` [length] gains between two times (later minus earlier), by
        the numerical solution of half-plane theory.
        """
        # `solve` takes places over the contact half-width at the mean load
        solution = self.case.solve(
            time=[start, end], x=[x / self.case.unit_length], fields=("slip",)
        )
        slip_at_begin, slip_at_end = solution.slip[:, 0]
        return float(slip_at_end - slip_at_begin)

    def integral_while_slipping(
        self, phase: str, x: float, rate: Callable[[Array], ArrayLike]
    ) -> float:
        """Integral of `rate`, a function of time, over the times at which the point `x` [length]
        slips inside contact in a phase of slip: "EG" reverse, "IJ" and "JM" forward.
        """
        # the normal load at which the edge of contact is at the point
        edge_load = np.asarray(self.case.contact.load(np.array([x])))
        sum_over_spans = 0.0
        for span in self.case.slip_spans[phase]:
            # when the point begins and ends to slip in this span of time; no later end if never
            start_time, end_time = (float(time[0]) for time in slip_times(span, edge_load))
            if end_time > start_time:
                # `delay`: what times of the load path are later than those of the span
                sum_over_spans += integral(rate, start_time + span.delay, end_time + span.delay)
        return sum_over_spans


def integral(rate: Callable[[Array], ArrayLike], start: float, end: float) -> float:
    """Integral of a function between two limits, at which it may be singular as a root."""
    t, weights = graded_nodes(start, end)
    return float(np.sum(np.asarray(rate(t)) * weights))


def sliding_limit(friction: ArrayLike) -> Array:
    """Least P0/P1 of a circle about Q = 0 without gross sliding, sqrt(1 + f^2)/f: equation (25),
    mended.
    """
    f = np.asarray(friction, dtype=float)
    return np.sqrt(1 + f * f) / f


def sum_over_phases(parts: Mapping[str, Array]) -> Array:
    """Sum over the phases of slip."""
    return np.asarray(sum(parts.values(), start=np.zeros(1)))


@dataclass(frozen=True, eq=False)
class Sweep:
    """Circles about Q = 0 (phase 90 degrees, Q1 = P1) with a(P0) and P1 the same in all: figures 7
    and 10.
    """

    frictions: Array  # (m,) f
    load_ratio: Array  # (m, n) P0/P1, from the sliding limit on
    work: Array  # (m, n) W/(A P1^2)
    peak: Array  # (m, n) max W(x) a0/(A P1^2)
    # (m, n) place of the peak between permanent stick edge (0) and largest contact (1)
    peak_fraction: Array


def _sweep(case: Case, largest_ratio: float = 6.0, n_ratios: int = 33) -> Sweep:
    """The dissipation W of a steady cycle, and the peak over x of the dissipation per area W(x),
    for many circles of loads about Q = 0. They have all coefficients of friction f of the paper,
    and `n_ratios` ratios P0/P1 from gross sliding up to `largest_ratio`. P0 is the mean normal
    load, P1 the radius of the circle.

    `case` gives the profile, whose radius is changed with each ratio: the half-width a0 = a(P0) and
    the flat's half-length b stay what they are. Its `unit_load`, a third of its mean load, is P1,
    and `unit_length` is a0.
    """
    # Ratios, (m, n_ratios). The first is 1e-9, relative, above the limit of gross sliding: at the
    # limit itself round-off would decide whether the contact slides.
    # FRICTIONS: 1, 0.8, 0.6 and 0.4
    friction_coefficients = np.array(FRICTIONS)
    least_ratio = sliding_limit(friction_coefficients)[:, None] * (1 + 1e-9)
    ratio = least_ratio * (largest_ratio / least_ratio) ** (np.linspace(0, 1, n_ratios) ** 2)

    # P0 is `ratio` times P1: the radius falls as P0 grows, so that a(P0) stays
    profile = case.scene.profile.model_dump()
    arguments = case.circle_arguments(
        friction_coefficients[:, None],
        ratio,
        profile=profile | {"radius": profile["radius"] * 3 / ratio},
    )

    # W over A P1^2, max W(x) over A P1^2/a0
    work_scale = case.compliance * case.unit_load**2
    peak = semi_analytic.peak_dissipation(**arguments)
    work = semi_analytic.dissipation(**arguments).value / work_scale
    # the last one: place of the peak between permanent stick edge (0) and largest contact (1)
    arrays = (
        friction_coefficients,
        ratio,
        work,
        peak.value * case.unit_length / work_scale,
        peak.fraction,
    )
    return Sweep(*(read_only_copy(array) for array in arrays))


@dataclass(frozen=True, eq=False)
class Paper:
    """The two examples, which figures, statements and misprints draw on; what is costly is done
    once.
    """

    hertz_case: Case
    rounded_case: Case

    @cached_property
    def sweeps(self) -> tuple[Sweep, Sweep]:
        """Dissipation and its peak over mean load and friction, of Hertz' contact and of the flat
        and rounded one.
        """
        return _sweep(self.hertz_case), _sweep(self.rounded_case)

    @cached_property
    def peaks(self) -> tuple[semi_analytic.PeakBatch, semi_analytic.PeakBatch]:
        """Place and size of the peak of W(x) in the two examples."""
        peak_of_hertz = semi_analytic.peak_dissipation(**self.hertz_case.batch_arguments())
        peak_of_rounded = semi_analytic.peak_dissipation(**self.rounded_case.batch_arguments())
        return peak_of_hertz, peak_of_rounded


@lru_cache(maxsize=1)
def paper() -> Paper:
    """The paper's two examples, from the library of scenes. They are made once in a process, since
    their solutions are costly.

    >>> round(paper().hertz_case.unit_length, 12)  # a(P0) = 1 mm
    1.0
    """
    return Paper(Case(load_scene(_HERTZ)), Case(load_scene(_ROUNDED)))
