"""References of the half-plane engine that share no code with it: steady ellipses with 30 digits,
every other load by brute force.

A steady ellipse has three phases of slip in closed form (`phases`): its friction work is an
integral over time in mpmath, to any number of digits. Every other load is answered by
`tests/semi_analytic_oracle.py` in extended precision, 18 digits: it looks back along the path for
the load at the stick edge. The stored references have 30 digits; up to commit 0cd0358 this file
followed the memory curve of every load in mpmath, and `make regress REFERENCES=1` shows that both
agree.

# notation: A = 2/E*; P_c load at the stick edge, c = a(P_c); eta load of a flat punch of the
superposition
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np

from scenes import Scene

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from semi_analytic_oracle import Bends, Oracle, Work

DIGITS = 30
HERE = Path(__file__).parent
TABLE = HERE / "semi_analytic_reference.json"
NASTY_FILE = HERE / "exact_history.json"
FIELDS = (
    "tangential displacement",
    "stick half-width",
    "shear at 1",
    "shear at 2",
    "shear at 3",
    "slip at 3",
)


# ----------------------------------------------------------------------------------- normal contact
class Contact(NamedTuple):
    """A parabola of radius R, or a flat of half-length b with edges of that radius; a = b sqrt(1 +
    tau^2).
    """

    modulus: mp.mpf
    radius: mp.mpf = mp.mpf(1)
    b: mp.mpf = mp.mpf(0)

    def load(self, tau: mp.mpf) -> mp.mpf:
        """P of a flat: section 4.2 of the paper with b^2 in place of a^2 (a misprint there)."""
        return self.modulus / self.radius * self.b**2 * ((1 + tau**2) * mp.atan(tau) - tau) / 2

    def depth(self, p: mp.mpf) -> mp.mpf:
        """tau of a flat: Newton from beyond the root; P(tau) is convex there."""
        tau = mp.mpf(1)
        while self.load(tau) < p:
            tau *= 2
        for _ in range(300):
            step = (self.load(tau) - p) / (
                self.modulus / self.radius * self.b**2 * tau * mp.atan(tau)
            )
            tau -= step
            if abs(step) < tau * mp.mpf(10) ** (2 - mp.mp.dps):
                break
        return tau

    def half_width(self, p: mp.mpf) -> mp.mpf:
        """a(P)."""
        return (
            self.b * mp.sqrt(1 + self.depth(p) ** 2)
            if self.b
            else mp.sqrt(4 * p * self.radius / (mp.pi * self.modulus))
        )

    def area(self, p: mp.mpf, front: mp.mpf) -> mp.mpf:
        """int ln(a(eta)/c) d eta over P_c < eta < P: P ln(a/c) - int P(alpha)/alpha d alpha from c
        to a.
        """
        if not self.b:
            return (p * mp.log(p / front) - p + front) / 2
        stiffness = self.modulus / self.radius * self.b**2
        tau = self.depth(p)
        inner = self.depth(front)

        def below(t: mp.mpf) -> mp.mpf:
            return stiffness / 2 * (((1 + t**2) * mp.atan(t) - t) / 2 - t + mp.atan(t))

        return p * mp.log((1 + tau**2) / (1 + inner**2)) / 2 - below(tau) + below(inner)


def contact_of(scene: Scene) -> Contact | None:
    """Of a parabola, or of a flat with rounded edges; None for other profiles."""
    profile = scene.profile
    if profile.kind not in {"hertz", "flat_rounded"}:
        return None
    return Contact(
        modulus(scene), mp.mpf(profile.radius), mp.mpf(getattr(profile, "flat_half_length", 0))
    )


def modulus(scene: Scene) -> mp.mpf:
    """E*."""
    bodies = scene.material.lower, scene.material.upper
    return 1 / sum((1 - mp.mpf(m.poisson_ratio) ** 2) / mp.mpf(m.young_modulus) for m in bodies)


# ---------------------------------------------------------------------------------- steady ellipses
class Case(NamedTuple):
    """A steady ellipse with E* = 1 and R = 1; `flat` is b, 0 for Hertz; `phase` in degrees, or in
    radians where it says so.
    """

    flat: float
    mean: float
    amplitude: float
    tangential: float
    phase: float
    friction: float
    radians: bool = False

    def contact(self) -> Contact:
        return Contact(mp.mpf(1), b=mp.mpf(self.flat))


class Phase(NamedTuple):
    """A phase of slip: times of begin and end, rate of Q - fP or Q + fP, load at the stick edge."""

    begin: mp.mpf
    end: mp.mpf
    rate: Callable[[mp.mpf], mp.mpf]
    front: Callable[[mp.mpf], mp.mpf]


def phases(case: Case) -> tuple[Callable[[mp.mpf], mp.mpf], list[Phase]]:
    """P(t), and the three phases of slip E-G, I-J, J-M of the steady cycle (0 < phase < 180
    degrees, Q0 = 0).

    E maximum of Q - fP, G minimum of Q + fP, I minimum of Q - fP, J where the edge has passed G, M
    = E a turn later.
    """
    p0, p1, q1, f = (mp.mpf(v) for v in (case.mean, case.amplitude, case.tangential, case.friction))
    phase = mp.mpf(case.phase) * (1 if case.radians else mp.pi / 180)
    z_u = q1 * mp.expj(-phase) - f * p1
    z_v = q1 * mp.expj(-phase) + f * p1
    t_e = -mp.arg(z_u)
    size_u = abs(z_u)
    size_v = abs(z_v)
    t_g = -mp.arg(z_v) + mp.pi
    t_g -= 2 * mp.pi * mp.floor((t_g - t_e) / (2 * mp.pi))
    t_i = t_e + mp.pi
    t_m = t_e + 2 * mp.pi
    t_j = 2 * t_i - t_g
    u_max = size_u - f * p0
    v_min = f * p0 - size_v

    def load(t: mp.mpf) -> mp.mpf:
        return p0 + p1 * mp.cos(t)

    def forward(t: mp.mpf) -> mp.mpf:
        return size_u * abs(mp.sin(t - t_e))

    return load, [
        Phase(
            t_e,
            t_g,
            lambda t: size_v * abs(mp.sin(t - t_g)),
            lambda t: (f * p0 - size_v * mp.cos(t - t_g) - u_max) / (2 * f),
        ),
        Phase(t_i, t_j, forward, lambda t: load(2 * t_i - t)),
        Phase(t_j, t_m, forward, lambda t: (v_min + f * p0 - size_u * mp.cos(t - t_e)) / (2 * f)),
    ]


def ellipse_dissipation(case: Case, contact: Contact | None = None) -> mp.mpf:
    """W of a steady cycle: (f A/pi) closed-int |u' or v'| int ln(a/c) d eta dt over the phases of
    slip.
    """
    contact = contact or case.contact()
    load, parts = phases(case)

    def power(part: Phase, t: mp.mpf) -> mp.mpf:
        p = load(t)
        front = part.front(t)
        return part.rate(t) * contact.area(p, front) if 0 < front < p else mp.mpf(0)

    total = mp.mpf(0)
    for part in parts:
        marks = (
            _towards_ends(part.begin, part.end)
            if case.radians
            else mp.linspace(part.begin, part.end, 4)
        )
        total += mp.quad(lambda t, part=part: power(part, t), marks)
    return mp.mpf(case.friction) * 2 / (mp.pi * contact.modulus) * total


def _towards_ends(begin: mp.mpf, end: mp.mpf) -> list[mp.mpf]:
    """Places ever closer to both ends."""
    steps = [(end - begin) * mp.mpf(10) ** -k / 2 for k in range(0, 14, 2)]
    return [
        begin,
        *(begin + step for step in reversed(steps)),
        *(end - step for step in steps[1:]),
        end,
    ]


# ------------------------------------------------------------------------------------------- scenes
def truth(scene: Scene) -> mp.mpf:
    """Dissipation of the last cycle: with 30 digits for an ellipse that is no line, else by brute
    force.
    """
    load = scene.load
    if (
        load.kind == "ellipse"
        and load.normal_amplitude
        and load.phase_degrees not in (0.0, 180.0, -180.0)
        and contact_of(scene)
    ):
        return steady_ellipse(scene)
    return _number(np.sum(_work(scene).whole()) / _long(modulus(scene)))


def steady_ellipse(scene: Scene) -> mp.mpf:
    """W of an ellipse scene by its three phases; Q mirrored where it turns the other way."""
    load = scene.load
    degrees = load.phase_degrees if load.phase_degrees > 0 else load.phase_degrees + 180
    amplitudes = load.mean_normal_load, load.normal_amplitude, load.tangential_amplitude
    return ellipse_dissipation(
        Case(0.0, *amplitudes, degrees, scene.friction.coefficient), contact_of(scene)
    )


def mindlin(k: mp.mpf, limit: mp.mpf) -> mp.mpf:
    """E* W of a cycle of Q between +-k f P at constant P, limit = f P: (4 f^2 P^2/pi) [(1-k)
    ln(1-k) + k - k^2/2].
    """
    log = (1 - k) * mp.log(1 - k) if k < 1 else mp.mpf(0)
    return 4 * limit**2 / mp.pi * (log + k - k**2 / 2)


def density_truth(scene: Scene, x: Sequence[float]) -> list[str]:
    """W(x) of the last cycle by brute force."""
    return [
        _text(value) for value in np.sum(_work(scene).density(x), axis=0) / _long(modulus(scene))
    ]


def field_truth(scene: Scene, time: float, x: Sequence[float]) -> list[str] | None:
    """The `FIELDS` at one time and three points of a Hertz scene by brute force; None for rows, and
    where there is no friction.

    The knots of the memory curve are the engine's own, which tests/test_semi_analytic_history.py
    holds against Coulomb's law.
    """
    if (
        scene.profile.kind != "hertz"
        or scene.load.kind not in ("ellipse", "polygon", "harmonics")
        or not scene.friction.coefficient
    ):
        return None
    oracle = Oracle(scene, [time])
    e_star = _long(modulus(scene))
    oracle.law = _stiff(oracle.law, e_star)
    fields = oracle.at(0, x)
    shift = fields["tangential_displacement"] / e_star
    slip = fields["slip"][-1] / e_star
    return [_text(value) for value in (shift, fields["stick_half_width"], *fields["shear"], slip)]


def _work(scene: Scene) -> Work:
    """The friction work of the second cycle, which is steady; of the whole path where there is no
    cycle. To be divided by E*.
    """
    work = Work(scene, 0 if scene.load.path().period is None else 1, parts=4)
    work.law = _stiff(work.law, _long(modulus(scene)))
    work.corner_loads = [work.law.load(corner) for corner in work.corners]
    return work


def _stiff(law: Any, e_star: np.longdouble) -> Any:
    """P(a) of bodies with that E* in place of 1."""
    if isinstance(law, Bends):
        return replace(law, jumps=tuple(e_star * jump for jump in law.jumps))
    return replace(law, terms=tuple((n, e_star * c) for n, c in law.terms))


def _long(value: mp.mpf) -> np.longdouble:
    return np.longdouble(mp.nstr(value, 25))


def _text(value: np.longdouble) -> str:
    return np.format_float_scientific(value, unique=True)


def _number(value: np.longdouble) -> mp.mpf:
    return mp.mpf(_text(value))
