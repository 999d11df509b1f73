"""Named problems with exact answers, and the finite-element runs of them that the tests share.

Hertz and Cattaneo-Mindlin stand here as plain functions of numbers, which the half-plane engine
meets to 1e-12 (`test_named_problems_have_their_closed_forms`); a flat and rounded face and the
paper's cycle take their truth from half-plane theory. Half-planes throughout, plane strain, like
bodies. Rigid displacements are counted from the datum length L of the profile.
"""

# notation: P, Q loads; R radius; E the modulus E*; f friction; a, c half-widths; b half-length of
# the flat face.

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from meshes import MeshSettings
from scenes import ContactSolution, EllipseLoad, PolygonLoad, Scene, SurfaceState, load_scene


def contact_modulus(scene: Scene) -> float:
    """E*, both bodies in plane strain."""
    bodies = (scene.material.upper, scene.material.lower)
    return 1 / sum((1 - body.poisson_ratio**2) / body.young_modulus for body in bodies)


# ----------------------------------------------------------------------------- Hertz, pressed alone
def hertz_half_width(P, R, E):
    """P = pi E* a^2 / (4 R)."""
    return np.sqrt(4 * P * R / (math.pi * E))


def hertz_pressure(x, P, R, E):
    """(E*/2R) sqrt(a^2 - x^2)."""
    return E / (2 * R) * np.sqrt(np.maximum(hertz_half_width(P, R, E) ** 2 - np.square(x), 0.0))


def hertz_approach(P, R, E, L):
    """(2 P / pi E*) [ln(2 L/a) + 1/2]: the pile of flat punches, each going in by (2 dP / pi E*)
    ln(2 L/a).
    """
    return 2 * P / (math.pi * E) * (np.log(2 * L / hertz_half_width(P, R, E)) + 0.5)


# ------------------------------------------------------ Cattaneo, Mindlin: constant P, Q to and fro
def mindlin_stick_half_width(P, Q, f, R, E):
    """c = a sqrt(1 - |Q|/fP); after a reversal Q is half of what has changed since."""
    return hertz_half_width(P, R, E) * np.sqrt(1 - abs(Q) / (f * P))


def mindlin_shear(x, P, turns: Sequence[float], f, R, E):
    """Shear after Q has gone 0 -> turns[0] -> turns[1] ... at constant P, no turn outside the two
    before it.

    The first branch is f [p(x, P) - p(x, P - Q/f)]; each reversal adds the same with twice the
    friction.
    """
    q = np.zeros_like(np.asarray(x, dtype=float))
    before = 0.0
    factor = 1.0
    for turn in turns:
        change = (turn - before) / factor
        stick = hertz_pressure(x, P - abs(change) / f, R, E)
        q = q + factor * math.copysign(f, change) * (hertz_pressure(x, P, R, E) - stick)
        before = turn
        factor = 2.0
    return q


def mindlin_dissipation(P, Q, f, E):
    """Energy of a cycle between +-Q: (4 f^2 P^2 / pi E*) [(1-k) ln(1-k) + k - k^2/2], k = Q/fP."""
    k = Q / (f * P)
    return 4 * (f * P) ** 2 / (math.pi * E) * ((1 - k) * math.log1p(-k) + k - k**2 / 2)


def mindlin_shift(P, Q, f, R, E, L):
    """Tangential displacement on the first branch: f [delta(P) - delta(P - Q/f)]."""
    return f * (hertz_approach(P, R, E, L) - hertz_approach(P - Q / f, R, E, L))


# ------------------------------------------ one body under a given traction (not a contact problem)
def pressed_in(x, b, young_modulus, nu, L):
    """Displacement into a half-plane under unit pressure on |x| < b (2 (1-nu^2)/(pi E) times int
    ln(L/|x-s|) ds).

    The same along the surface under unit shear.
    """
    ends = b + np.asarray(x, dtype=float), b - np.asarray(x, dtype=float)
    logs = sum(end * np.log(np.where(end > 0, end, 1.0)) for end in ends)
    return 2 * (1 - nu**2) / (math.pi * young_modulus) * (2 * b * (math.log(L) + 1) - logs)


def drawn_inwards(x, young_modulus, nu):
    """Displacement along x of a half-plane under unit pressure between 0 and x: -(1-2 nu)(1+nu)/E
    times the force there.
    """
    return -(1 - 2 * nu) * (1 + nu) / young_modulus * np.asarray(x, dtype=float)


# ---------------------------------------------------------------------------------------- the table
@dataclass(frozen=True, eq=False)
class Problem:
    """A scene, an instant of it, and what is true there; a figure that has no closed form is left
    out.

    `exact` holds pressure and shear (of x) and, as numbers, contact_half_width, stick_half_width,
    peak_pressure, normal_approach, tangential_displacement, and the dissipation of the last cycle.
    """

    name: str
    tags: frozenset[str]
    scene: Scene
    time: float
    exact: Mapping[str, float | Callable]

    def loads(self) -> tuple[float, float]:
        P, Q = self.scene.load.path().at(self.time)
        return float(P), float(Q)


def _zero(x):
    return np.zeros_like(np.asarray(x, dtype=float))


def _hertz(name, tags, scene, time, **further) -> Problem:
    """What every Hertz contact has, and `further`."""
    R = scene.profile.radius
    E = contact_modulus(scene)
    P = float(scene.load.path().at(time)[0])
    a = float(hertz_half_width(P, R, E))
    exact = {
        "pressure": lambda x: hertz_pressure(x, P, R, E),
        "peak_pressure": float(hertz_pressure(0.0, P, R, E)),
        "contact_half_width": a,
        "stick_half_width": a,
        "normal_approach": float(hertz_approach(P, R, E, scene.profile.datum_length)),
    }
    return Problem(name, frozenset(tags), scene, time, exact | further)


def _hertz_normal() -> Problem:
    return _hertz(
        "hertz",
        {"normal", "hertz"},
        load_scene("hertz-normal"),
        1.0,
        shear=_zero,
        tangential_displacement=0.0,
        dissipation=0.0,
    )


def _mindlin(name, time, turns_over_amplitude, tags) -> Problem:
    """The library's scene at `time` in the second revolution, after the given turns of Q."""
    scene = load_scene("cattaneo-mindlin")
    f = scene.friction.coefficient
    R = scene.profile.radius
    E = contact_modulus(scene)
    L = scene.profile.datum_length
    P, amplitude = scene.load.cycle[0]
    turns = [share * amplitude for share in turns_over_amplitude]
    last = turns[0] if len(turns) == 1 else (turns[-1] - turns[-2]) / 2
    further = {
        "shear": lambda x: mindlin_shear(x, P, turns, f, R, E),
        "stick_half_width": float(mindlin_stick_half_width(P, last, f, R, E)),
        "dissipation": mindlin_dissipation(P, amplitude, f, E),
    }
    if len(turns) == 1:
        further["tangential_displacement"] = float(mindlin_shift(P, amplitude, f, R, E, L))
    return _hertz(name, {"tangential", "hertz", "cycle", *tags}, scene, time, **further)


def _full_stick() -> Problem:
    """P and Q in proportion: q = (Q/P) p for ever, at the largest load."""
    scene = load_scene("full-stick")
    slope = scene.load.mean_tangential_load / scene.load.mean_normal_load
    base = _hertz(
        "full-stick", {"tangential", "hertz", "cycle"}, scene, 2 * math.pi, dissipation=0.0
    )
    shear = {
        "shear": lambda x: slope * base.exact["pressure"](x),
        "tangential_displacement": slope * base.exact["normal_approach"],
    }
    return Problem(base.name, base.tags | {"full stick"}, scene, base.time, {**base.exact, **shear})


def _by_theory(name, tags, scene, time) -> Problem:
    """The truth is that of half-plane theory, whose kernels and W have their own thirty digits and
    M(eta) its own brute force.
    """
    solution = semi_analytic.solve(scene, x=[0.0], time=[time], fields=())

    def exact(field):
        return lambda x: getattr(
            semi_analytic.solve(scene, x=x, time=[time], fields=(field,)), field
        )[0]

    truth = {field: exact(field) for field in ("pressure", "shear")}
    truth |= {
        name: float(getattr(solution, name)[0])
        for name in ("contact_half_width", "stick_half_width")
    }
    return Problem(name, frozenset({*tags, "by theory"}), scene, time, truth)


def _flat_rounded(name, share, tags) -> Problem:
    """A flat face with rounded edges pressed to about a = 2 b, then sheared by `share` of f P."""
    motor = load_scene("motor")
    P = 1.22837 * contact_modulus(motor) * motor.profile.flat_half_length**2 / motor.profile.radius
    loading = [(P, 0.0), *([(P, share * motor.friction.coefficient * P)] if share else [])]
    scene = motor.vary(name=name, load=PolygonLoad(initial_loading=loading))
    return _by_theory(name, {"flat and rounded", *tags}, scene, float(len(loading)))


def _paper(name, letter) -> Problem:
    """The paper's Hertz cycle at its point E or G, where forward or reverse slip ends, in the
    second revolution.
    """
    scene = load_scene("hertz-paper")
    start = scene.load.path().cycle_start
    period = scene.load.path().period
    time = start + period + (semi_analytic.event(scene, letter).time - start) % period
    theory = _by_theory(name, {"tangential", "hertz", "cycle", "varying P"}, scene, time)
    steady = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",))
    further = {
        "stick_half_width": steady.permanent_stick_half_width,
        "dissipation": steady.dissipation,
    }
    return _hertz(name, theory.tags, scene, time, shear=theory.exact["shear"], **further)


PROBLEMS = {
    problem.name: problem
    for problem in (
        _hertz_normal(),
        _mindlin("mindlin, Q largest", 2.0, [1], ["first branch"]),
        _mindlin("mindlin, half-way back", 5.5, [1, 0], []),
        _mindlin("mindlin, reversed", 6.0, [1, -1], []),
        _mindlin("mindlin, end of cycle", 7.0, [1, -1, 0], []),
        _full_stick(),
        _flat_rounded("flat and rounded", 0.0, ["normal"]),
        _flat_rounded("flat and rounded, sheared", 0.6, ["tangential", "first branch"]),
        _paper("paper, forward slip ends", "E"),
        _paper("paper, reverse slip ends", "G"),
    )
}


def problems(*tags: str) -> list[Problem]:
    """The problems that have all of `tags`."""
    return [problem for problem in PROBLEMS.values() if problem.tags.issuperset(tags)]


# ------------------------------------------------------------------------ answers against the truth
COARSE = MeshSettings(element_size=1 / 12, edge_element_size=1 / 16, far_radius=6.0, growth=0.3)
FEW_STEPS = SolverSettings(steps_per_cycle=48)


@functools.cache
def fe_run(
    scene: Scene, mesh: MeshSettings = COARSE, settings: SolverSettings = FEW_STEPS
) -> FiniteElementSolution:
    """The finite-element answer, computed once however many tests look at it."""
    return halfplane_fe.solve(scene, mesh, settings)


def layer_run(name: str, method: str, stiffness: float) -> FiniteElementSolution:
    """A scene of the library with both stiffnesses of the layer (or weights) alike, in regular
    increments.
    """
    settings = SolverSettings(
        method=method,
        normal_stiffness=stiffness,
        tangential_stiffness=stiffness,
        steps_per_cycle=24,
        step_tolerance=np.inf,
    )
    return fe_run(load_scene(name), COARSE, settings)


def stepped_run(method: str, steps: int) -> FiniteElementSolution:
    """Two revolutions of an ellipse in regular increments alone, none halved for its step error."""
    load = EllipseLoad(
        mean_normal_load=90, normal_amplitude=30, tangential_amplitude=25, phase_degrees=90
    )
    friction = load_scene("cattaneo-mindlin").friction
    settings = SolverSettings(
        method=method,
        normal_stiffness=10,
        tangential_stiffness=10,
        steps_per_cycle=steps,
        step_tolerance=np.inf,
    )
    mesh = replace(COARSE, element_size=1 / 8, edge_element_size=1 / 8)
    return fe_run(
        load_scene("hertz-paper").vary(load=load, cycles=2, friction=friction), mesh, settings
    )


def step_at(solution: ContactSolution, time: float) -> int:
    """The stored step at `time`."""
    step = int(np.argmin(np.abs(solution.time - time)))
    assert abs(solution.time[step] - time) < 1e-9, (
        f"no step at {time}; the nearest is at {solution.time[step]}"
    )
    return step


def norm(x, values) -> float:
    """L2 norm over the surface by the trapezoidal rule."""
    return math.sqrt(np.trapezoid(np.square(values), x))


def errors(problem: Problem, solution: ContactSolution) -> dict[str, float]:
    """How far an answer is from the truth, in the dimensionless forms of the comparison.

    pressure over ||p||, shear over f ||p||; edges over a; rigid displacements over the approach;
    peak and dissipation relative, but dissipation over W of sliding (4 f^2 P^2/pi E*) where the
    true one is 0.
    """
    exact = problem.exact
    step = step_at(solution, problem.time)
    x = solution.x
    true_pressure = exact["pressure"](x)
    size = norm(x, true_pressure)
    friction = solution.scene.friction.coefficient
    measured = {
        "pressure": norm(x, solution.pressure[step] - true_pressure) / size,
        "shear": norm(x, solution.shear[step] - exact["shear"](x)) / (friction * size),
    }
    for name in ("contact_half_width", "stick_half_width"):
        measured[name] = (
            abs(float(getattr(solution, name)[step]) - exact[name]) / exact["contact_half_width"]
        )
    if "peak_pressure" in exact:
        measured["peak_pressure"] = abs(
            float(solution.pressure[step].max()) / exact["peak_pressure"] - 1
        )
    for name in ("normal_approach", "tangential_displacement"):
        if name in exact:
            measured[name] = (
                abs(float(getattr(solution, name)[step]) - exact[name]) / exact["normal_approach"]
            )
    if "dissipation" in exact:
        sliding = (
            4 * (friction * problem.loads()[0]) ** 2 / (math.pi * contact_modulus(problem.scene))
        )
        measured["dissipation"] = abs(solution.dissipation - exact["dissipation"]) / (
            exact["dissipation"] or sliding
        )
    return measured


def law_violations(answer: FiniteElementSolution) -> dict[str, float]:
    """How far an answer is from the laws of contact, from the arrays that a reader sees; needs no
    reference, 0 is perfect.

    Over the largest pressure, the largest load, or the work of sliding, whichever applies.
    """
    f = answer.scene.friction.coefficient
    p = answer.pressure
    q = answer.shear
    state = answer.state
    across, along = answer.face_normals * answer.face_lengths
    largest = float(p.max())
    load = float(answer.normal_load.max())
    sense = np.select(
        [state == SurfaceState.SLIP_FORWARD, state == SurfaceState.SLIP_REVERSE], [1, -1], 0
    )
    path_p, path_q = answer.scene.load.path().at(answer.time)
    step = np.diff(answer.slip, axis=0)
    travel = float(np.abs(step).max()) or 1.0
    worst = lambda values: float(np.max(values, initial=0.0))  # noqa: E731
    return {
        "tension": worst(-p) / largest,
        "open pressure": worst(np.abs(p[state == SurfaceState.OPEN])) / largest,
        "cone": worst(np.abs(q) - f * p) / largest,
        "sliding off the cone": worst(np.abs(q - sense * f * p)[sense != 0]) / largest,
        "slip against friction": worst(-(q[1:] * step)[sense[1:] != 0]) / (largest * travel),
        "normal equilibrium": worst(np.abs(p @ along + q @ across - path_p)) / load,
        "tangential equilibrium": worst(np.abs(q @ along - p @ across - path_q)) / load,
        "loads": (
            worst(np.abs([answer.normal_load - path_p, answer.tangential_load - path_q])) / load
        ),
        "stick beyond contact": (
            worst(np.nan_to_num(answer.stick_half_width - answer.contact_half_width)) / answer.x[-1]
        ),
        "negative dissipation": (
            worst(-answer.dissipation_density) / (worst(np.abs(answer.dissipation_density)) or 1.0)
        ),
    }
