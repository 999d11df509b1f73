"""Cases of numerical stress for the finite-element model, on coarse meshes, against the half-plane engine."""

from __future__ import annotations

import functools
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from stress_case import Case, Found, Trial, broken_by, ellipse, like, scene_of, to_and_fro

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from scenes import Elastic, FlatRounded, Hertz, Materials, PolygonLoad, PowerLaw, Scene, Wedge
from semi_analytic.elasticity import composite_modulus
from semi_analytic.profiles import contact_of

ENGINE = "Finite elements"
COARSE, FEW = MeshSettings.coarse(), SolverSettings(steps_per_cycle=32)
ROUGH = replace(COARSE, element_size=1 / 4, edge_element_size=1 / 8)
COARSEST = replace(ROUGH, edge_element_size=1 / 4)
LOOP = (3.0, 1.0, 0.2, 0.8, 70.0)


# Limit of the errors of p, q and W, each for itself: above it the solver has to say so. A few times what a coarse mesh promises of
# the shear (about 1 % in L2): what a reader of a first look takes for good if nothing is said.
TOLD = 0.05
# Instants at which tractions are compared, of the last revolution and with more than this share of the largest load.
INSTANTS, LOADED = 16, 0.3


def against_theory(scene: Scene, mesh: MeshSettings = COARSE, settings: SolverSettings = FEW) -> Found:
    """Errors of p over ||p||, of q over f ||p||, in L2 at the worst instant, of W over W (infinite where nothing should slip).

    `shown` has that of W in A f^2 P^2 as well. NaN where a law is broken by 1e-7.
    """
    answer = halfplane_fe.solve(scene, mesh, settings)
    chosen = last_instants(answer)
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time[chosen], fields=("pressure", "shear"))
    work = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",)).dissipation
    size, friction = l2(exact.pressure, answer.weights), scene.friction.coefficient
    unit = 2 / composite_modulus(scene.material) * (friction * answer.normal_load.max()) ** 2
    off = abs(answer.dissipation - work)
    errors = {
        "p": float(np.max(l2(answer.pressure[chosen] - exact.pressure, answer.weights) / size)),
        "q": float(np.max(l2(answer.shear[chosen] - exact.shear, answer.weights) / (friction * size))),
        "W": off / work if work else (np.inf if off else 0.0),
    }
    if max(float(values.max()) for values in answer.record.certificates.values()) > 1e-7:
        errors = dict.fromkeys(errors, float("nan"))
    return Found(errors, answer.record.notes, {"W in A f² P²": off / unit})


def last_instants(answer: halfplane_fe.FiniteElementSolution) -> np.ndarray:
    """Indices of some loaded instants of the last revolution, or of the whole path."""
    period = answer.scene.load.path().period
    start = answer.time[-1] - period * (1 - 1e-9) if period is not None else -np.inf
    loaded = np.flatnonzero((answer.normal_load > LOADED * answer.normal_load.max()) & (answer.time > start))
    return loaded[np.unique(np.linspace(0, len(loaded) - 1, INSTANTS).astype(int))]


def l2(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Norm over the surface, instant by instant."""
    return np.sqrt(values**2 @ weights)


@functools.cache
def dimensionless(length: float, stress: float, ratio: float = 1.0) -> dict[str, np.ndarray]:
    """Fields of one loop in units of length and stress."""
    scene = scene_of(ellipse(*(np.array(LOOP[:4]) * length * stress), LOOP[4]), 0.5, Hertz(radius=length), like(stress))
    answer = halfplane_fe.solve(scene, replace(COARSE, upper_ratio=ratio), FEW)
    units = {"pressure": stress, "shear": stress, "slip": length, "contact_edges": length, "dissipation_density": length * stress}
    return {name: getattr(answer, name) / unit for name, unit in units.items()}


def in_units(length: float, stress: float) -> float:
    one, other = dimensionless(1.0, 1.0), dimensionless(length, stress)
    return max(float(np.max(np.abs(other[name] - one[name])) / np.max(np.abs(one[name]))) for name in one)


def unit_trials() -> Iterator[Trial]:
    for length, stress in ((1e-12, 1e-12), (1e12, 1e12), (1e-12, 1e12), (1e12, 1e-12)):
        yield f"lengths {length:g}, stresses {stress:g}", partial(in_units, length, stress)


def friction_trials() -> Iterator[Trial]:
    for f in (1e-6, 1e-3, 1.0, 100.0):
        yield f"f = {f:g}", partial(against_theory, scene_of(ellipse(3, 1, 0.4 * f, 1.6 * f, 70), f))


def sliding_trials(*left: float) -> Iterator[Trial]:
    for part in left:
        yield f"1 - {part:g}", partial(against_theory, scene_of(to_and_fro(1 - part, 0.5)))


def narrow_trials() -> Iterator[Trial]:
    for share in (0.3, 0.1, 0.03, 0.01, 1e-3, 1e-6, 1e-12):
        yield f"{share:g} f P", partial(against_theory, scene_of(to_and_fro(share, 0.5)))


def little_load_trials(*left: float) -> Iterator[Trial]:
    for part in left:
        yield f"P_min/P0 = {part:g}", partial(against_theory, scene_of(ellipse(1, 1 - part, 0, 0.2 * part, 90)))


def poisson_trials() -> Iterator[Trial]:
    for nu in (-0.9, 0.0, 0.4999, 0.499999):
        yield f"nu = {nu:g}", partial(against_theory, scene_of(ellipse(*LOOP), material=like(1.0, nu)))


def pair(ratio: float, upper: float, lower: float) -> Materials:
    """E1/E2 = ratio with the two Poisson ratios, and E* = 1."""
    soft = (1 - upper**2) / ratio + (1 - lower**2)
    return Materials(
        upper=Elastic(young_modulus=ratio * soft, poisson_ratio=upper), lower=Elastic(young_modulus=soft, poisson_ratio=lower)
    )


def uncoupled_trials() -> Iterator[Trial]:
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        nus = (0.4999, 0.2) if ratio < 1 else (0.2, 0.4999)  # the soft one incompressible: beta next to 0
        yield f"E1/E2 = {ratio:g}", partial(against_theory, scene_of(ellipse(*LOOP), material=pair(ratio, *nus)))


def exchanged(ratio: float) -> float:
    """W with the bodies exchanged, which is the same scene seen from below."""
    works = [
        halfplane_fe.solve(scene_of(ellipse(*LOOP), material=material), COARSE, FEW).dissipation
        for material in (pair(ratio, 0.3, 0.3), _turned(pair(ratio, 0.3, 0.3)))
    ]
    return abs(works[1] / works[0] - 1)


def _turned(materials: Materials) -> Materials:
    return Materials(upper=materials.lower, lower=materials.upper)


def flat_trials() -> Iterator[Trial]:
    for part in (1e-9, 1e-6, 1e-3, 0.9, 0.999, 1 - 1e-6, 1 - 1e-9):
        profile = FlatRounded(radius=100.0, flat_half_length=part)
        load = float(contact_of(profile, like()).load(1.0))
        scene = scene_of(ellipse(0.75 * load, 0.25 * load, 0.05 * load, 0.2 * load, 70), 0.5, profile)
        yield f"b/a = {part:g}", partial(against_theory, scene)


def radius_trials() -> Iterator[Trial]:
    for radius in (1e-9, 1e-6, 1e-3, 1.0, 1e6):
        yield f"R = {radius:g}", partial(against_theory, scene_of(ellipse(*LOOP), profile=Hertz(radius=radius)))


def mesh_trials(*changes: dict[str, object]) -> Iterator[Trial]:
    for change in changes:
        words = ", ".join(f"{name} = {value}" for name, value in change.items())
        mesh = replace(COARSE, **change)  # type: ignore[arg-type]
        yield words, partial(against_theory, scene_of(ellipse(*LOOP)), mesh)


def step_trials(*counts: int) -> Iterator[Trial]:
    for count in counts:
        yield (
            f"{count}",
            lambda count=count: against_theory(scene_of(ellipse(*LOOP)), COARSE, SolverSettings(steps_per_cycle=count)),
        )


def many_steps(corners: int, count: int, mesh: MeshSettings = ROUGH) -> Found:
    """P, then Q to and fro between 0.6 and -0.6 f P over so many lines, `count` increments each: against 16 each, and the laws."""
    lines = tuple((1.0, 0.3 * (-1) ** number) for number in range(corners))
    scene = scene_of(PolygonLoad(initial_loading=((1.0, 0.0), *lines)))
    many, few = (
        halfplane_fe.solve(scene, mesh, SolverSettings(steps_per_cycle=8 * steps, step_tolerance=np.inf)) for steps in (count, 16)
    )
    if len(many.time) < count * (corners + 1):
        return Found({"increments missing": float("nan")})
    here, there = (np.searchsorted(answer.time, np.arange(1.0, corners + 1.5) - 1e-9) for answer in (many, few))
    off = {"W": abs(many.dissipation / few.dissipation - 1), "laws": max(broken_by(many), broken_by(few))}
    for symbol, name in (("p", "pressure"), ("q", "shear"), ("slip", "slip")):
        one, other = getattr(many, name)[here], getattr(few, name)[there]
        off[symbol] = float(np.max(np.abs(one - other)) / np.max(np.abs(other)))
    return Found(off, shown={"kB an increment": memory_of_each(scene, mesh)} if mesh is COARSEST else {})


def memory_of_each(scene: Scene, mesh: MeshSettings, counts: tuple[int, int] = (300, 600)) -> float:
    """Growth of the peak of memory with every increment more [kB]; fewer hide below what the condensation takes."""
    peaks, sizes = [], []
    for steps in counts:
        tracemalloc.start()
        answer = halfplane_fe.solve(scene, mesh, SolverSettings(steps_per_cycle=8 * steps, step_tolerance=np.inf))
        peaks.append(tracemalloc.get_traced_memory()[1])
        sizes.append(len(answer.time))
        tracemalloc.stop()
        del answer
    return (peaks[1] - peaks[0]) / (sizes[1] - sizes[0]) / 1000


def tangent_trials() -> Iterator[Trial]:
    for beyond in (-1e-12, -1e-15, 0.0, 1e-15, 1e-12):
        yield f"e = {beyond:g}", partial(against_theory, scene_of(ellipse(2, 1, 0.05, 0.5 * (1 + beyond), 0)))


def sizes(element: float, at_edges: float) -> dict[str, float]:
    return {"element_size": element, "edge_element_size": at_edges}


def cases() -> Iterator[Case]:
    """All of them."""
    yield from _of_scenes()
    yield from _of_meshes()
    yield from _of_steps()


def _against_theory(what: str, tried: str, trials: Callable[[], Iterator[Trial]], **further: bool) -> Case:
    """A case against the half-plane engine, where what is off by more is to be told."""
    measure = "p, q in L2 and W, against the half-plane engine"
    return Case(ENGINE, what, tried, measure, TOLD, trials, may_tell=True, **further)


def _refused(what: str, tried: str, trials: Callable[[], Iterator[Trial]]) -> Case:
    return Case(ENGINE, what, tried, "refused", 0.0, trials, may_refuse=True, must_refuse=True)


def _of_scenes() -> Iterator[Case]:
    yield Case(ENGINE, "units", "lengths and stresses times 1e-12 and 1e12", "any field over its largest value", 1e-9, unit_trials)
    yield _against_theory("friction", "f = 1e-6, 1e-3, 1, 100, Q in proportion", friction_trials)
    yield _against_theory(
        "near gross sliding", "1e-3 ... 1e-15 of f P left", partial(sliding_trials, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15)
    )
    yield _refused("at gross sliding", "Q = f P", partial(sliding_trials, 0.0))
    yield _against_theory("slip zones smaller than an element", "Q to 0.3 ... 1e-12 of f P: 5 to 2e-11 elements", narrow_trials)
    yield _against_theory("next to no load", "P_min/P0 = 1e-3, 1e-6, 1e-9", partial(little_load_trials, 1e-3, 1e-6, 1e-9))
    yield _refused("less than rounding of the load", "P_min/P0 = 1e-12", partial(little_load_trials, 1e-12))
    yield _against_theory("Poisson's ratio", "nu = -0.9, 0, 0.4999, 0.499999", poisson_trials)
    yield _against_theory("stiffness ratio, uncoupled", "E1/E2 = 1e-6 ... 1e6, the soft body incompressible", uncoupled_trials)
    yield Case(
        ENGINE,
        "stiffness ratio, coupled",
        "E1/E2 = 1e-6, 1e6, nu = 0.3",
        "W with the bodies exchanged",
        5e-3,
        lambda: ((f"{ratio:g}", partial(exchanged, ratio)) for ratio in (1e-6, 1e6)),
    )
    yield _against_theory("flat face", "b/a = 1e-9 ... 1 - 1e-9", flat_trials)
    yield _against_theory("a/R", "R = 1e-9 ... 1e6, a/R from 7e4 to 2e-3", radius_trials)
    yield _against_theory("sharp tips", "h as x^1.1 ... x^1.9, a rounded wedge", tip_trials)


def _of_meshes() -> Iterator[Case]:
    extremes = partial(mesh_trials, {"far_radius": 2.0}, {"far_radius": 1000.0}, {"growth": 0.05}, {"growth": 1.0})
    yield _against_theory("a/L and grading", "L = 2 a and 1000 a, growth 0.05 and 1", extremes)
    cut = partial(mesh_trials, sizes(0.25, 0.25), sizes(0.25, 1 / 128))
    yield _against_theory("coarse, and graded 1 : 32", "h = a/4; a/4 and a/128 at the edges", cut)
    yield _against_theory("linear elements", "coarse", partial(mesh_trials, {"order": 1}))
    ratios = partial(mesh_trials, *({"upper_ratio": ratio} for ratio in (0.25, 2.0, 4.0, 20.0)))
    yield _against_theory("mesh ratios", "upper over lower 1/4, 2, 4, 20", ratios)
    beyond = partial(bad_meshes, {"upper_ratio": 21.0}, {"far_radius": 1.0}, {"growth": 2.0}, {"element_size": 1.0})
    yield _refused("beyond the mesher's range", "ratio 21, L = a, growth 2, h = a", beyond)


def _of_steps() -> Iterator[Case]:
    yield _against_theory("step sizes", "4, 8, 1000 increments a cycle", partial(step_trials, 4, 8, 1000))
    yield _refused("too few or many steps", "1 and 10^6 a cycle", partial(step_trials, 1, 1_000_000))
    # Two lines on a mesh of 41 contact nodes, nine of 12,500 increments each on one of 25.
    trials = [("10^4", partial(many_steps, 1, 10_000, ROUGH)), ("10^5", partial(many_steps, 8, 12_500, COARSEST))]
    measure = "p, q, slip at the ends of lines and W, against 16 increments a line; laws, energy balance among them"
    yield Case(ENGINE, "many increments", "10^4 a line, 10^5 in all, Q to and fro", measure, 1e-9, lambda: trials)
    yield _against_theory("tangency within rounding", "dQ/dP = f (1 + e), e = -1e-12 ... 1e-12", tangent_trials)


def tip_trials() -> Iterator[Trial]:
    for exponent in (1.1, 1.3, 1.5, 1.9):
        profile = PowerLaw(exponent=exponent, length=1.0, rise=0.5)
        yield f"x^{exponent}", partial(against_theory, scene_of(ellipse(*LOOP), profile=profile))
    yield "wedge", partial(against_theory, scene_of(ellipse(*LOOP), profile=Wedge(tip_radius=1.0, tip_half_length=0.1)))


def bad_meshes(*changes: dict[str, float]) -> Iterator[Trial]:
    for change in changes:
        yield f"{change}", lambda change=change: float(replace(COARSE, **change).growth)
