"""Faults of the question: half-plane theory asked another one. Its exact answer to that is the prediction.

A result with the wrong modulus or friction, without memory, not yet steady, at other times or on the straight lines between its
instants is the exact solution of a neighbouring scene, so nothing has to be modelled but what was asked.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import semi_analytic
from reports.scoring.diagnosis_discrepancy import Array, Discrepancy, Tractions
from reports.scoring.diagnosis_hypothesis import Hypothesis, fitted
from scenes import EllipseLoad, Materials, Scene
from semi_analytic.profiles import contact_of

# f at which next to nothing slips, over the scene's: a mesh keeps the infinite shear of bonded faces finite, as a large f does.
NO_SLIP = (15.0, 50.0, 200.0, 1e3)


def theory_faults(what: Discrepancy) -> Iterator[Hypothesis]:
    """Every fault of the question that the discrepancy may have."""
    yield from _stiffness(what)
    yield from _offset(what)
    if what.scene.friction.coefficient and np.any(what.expected[1]):
        yield from _friction(what)
        yield from _memoryless(what)
        yield from _first_cycle(what)
        yield from _polygon(what)
    yield from _other_times(what)


def answer(what: Discrepancy, scene: Scene, time: Array | None = None, *, offset: float = 0.0) -> Tractions:
    """p and q of half-plane theory for another scene, at other times (in any order), or with its centre at x = offset.

    Where what is expected is not half-plane theory of the present scene, what the two differ by is added: the fault is then what
    the change of the scene changes.
    """
    p, q = _theory(what, scene, what.time if time is None else time, offset)
    if what.exact:
        return p, q
    base = _theory(what, what.scene, what.time, 0.0)
    return p + what.expected[0] - base[0], q + what.expected[1] - base[1]


def _theory(what: Discrepancy, scene: Scene, time: Array, offset: float) -> Tractions:
    times, places = np.unique(time, return_inverse=True)
    found = semi_analytic.solve(scene, x=what.x - offset, time=times, fields=("pressure", "shear"))
    return found.pressure[places], found.shear[places]


def stiffer(scene: Scene, factor: float) -> Scene:
    """E* times `factor`."""
    material = {
        name: body.vary(young_modulus=factor * body.young_modulus)
        for name, body in (("upper", scene.material.upper), ("lower", scene.material.lower))
    }
    return scene.vary(material=Materials(**material))


def _stiffness(what: Discrepancy) -> Iterator[Hypothesis]:
    """E*/R times m: tractions know no more, since the gap scales with 1/R and the displacements with 1/E*.

    For Hertz a goes as m^-1/2 and p as m^1/2 at the same resultants. Loads k times too large are the same with m = 1/k and every
    traction times k, by linearity: their resultants are k times too large.
    """
    scene = what.scene
    tries = tuple(np.log([0.2, 0.5, 0.75, 0.9, 0.97, 1.0, 1.03, 1.1, 1.33, 2.0, 5.0]))
    if fit := fitted(what.of_pressure, lambda m: answer(what, stiffer(scene, np.exp(m))), tries):
        m = float(np.exp(fit[0]))
        yield Hypothesis("stiffness", fit[1], {"factor": m}, scene=stiffer(scene, m))

    def loaded(k: float) -> Tractions:
        p, q = answer(what, stiffer(scene, np.exp(-k)))
        return np.exp(k) * p, np.exp(k) * q

    if fit := fitted(what.of_pressure, loaded, tries):
        k = float(np.exp(fit[0]))
        half = min(abs(k / 2 - 1), abs(2 * k - 1)) < 0.03
        yield Hypothesis("half_model" if half else "loads", fit[1], {"factor": k})


def _offset(what: Discrepancy) -> Iterator[Hypothesis]:
    """p(x - d), q(x - d); d is looked for around what the centroid of the pressure has moved by."""
    half = what.comparison.scales.half_width
    centres = [
        float(np.sum(what.weight * p * what.x) / total) if (total := float(np.sum(what.weight * p))) > 0 else 0.0
        for p in (what.found[0], what.expected[0])
    ]
    centre = float(np.clip(centres[0] - centres[1], -2 * half, 2 * half))
    tries = tuple(centre + half * step for step in (-0.1, -0.02, 0.0, 0.02, 0.1))
    fit = fitted(what.of_pressure, lambda d: answer(what, what.scene, offset=d), tries)
    if fit and abs(fit[0]) > 1e-4 * half:
        d = fit[0]
        yield Hypothesis("offset", fit[1], {"distance": d / half})


def with_friction(scene: Scene, coefficient: float) -> Scene:
    """The scene with another f."""
    return scene.vary(friction=coefficient)


def _friction(what: Discrepancy) -> Iterator[Hypothesis]:
    """Another f; and one at which nothing slips, where q is that of bonded faces, infinite at the edges."""
    scene = what.scene
    f = scene.friction.coefficient
    tries = tuple(np.log([0.4, 0.6, 0.8, 0.9, 0.97, 1.0, 1.03, 1.1, 1.25, 1.7, 2.5, 4.0]))
    if fit := fitted(what, lambda factor: answer(what, with_friction(scene, f * np.exp(factor))), tries):
        factor = float(np.exp(fit[0]))
        yield Hypothesis("friction", fit[1], {"factor": factor}, scene=with_friction(scene, f * factor))
    if fit := fitted(what, lambda factor: answer(what, with_friction(scene, f * np.exp(factor))), tuple(np.log(NO_SLIP))):
        yield Hypothesis("full_stick", fit[1])


def _memoryless(what: Discrepancy) -> Iterator[Hypothesis]:
    """Cattaneo's first loading at every instant: q = sign(Q) f [p(x, P) - p(x, P - |Q|/f)]."""
    scene = what.scene
    contact, f = contact_of(scene.profile, scene.material), scene.friction.coefficient
    normal, tangential = (np.asarray(load)[:, None] for load in scene.load.path().at(what.time))
    stuck = normal - np.abs(tangential) / f
    if np.all(stuck > 0):
        shear = np.sign(tangential) * f * (contact.pressure(what.x, normal) - contact.pressure(what.x, stuck))
        yield Hypothesis("memoryless", (what.expected[0], shear))


def _first_cycle(what: Discrepancy) -> Iterator[Hypothesis]:
    """The first revolution in place of a steady one."""
    path = what.scene.load.path()
    if path.period is not None:
        time = path.cycle_start + np.minimum(what.fraction, 1 - 1e-12) * path.period
        yield Hypothesis("not_steady", answer(what, what.scene, time))


def _polygon(what: Discrepancy) -> Iterator[Hypothesis]:
    """The straight lines between the result's instants, in place of the path."""
    comparison = what.comparison
    if isinstance(comparison.scene.load, EllipseLoad):
        polygon = comparison.polygon_reference
        if polygon is None or len(polygon.x) != len(what.x):
            polygon = semi_analytic.solve(comparison.scene, x=what.x, time=comparison.result.time, straight_steps=True)
        rows = polygon.last_cycle
        if len(rows) == len(comparison.found.time):
            picked = rows[what.rows]
            base = comparison.expected.pressure[what.rows], comparison.expected.shear[what.rows]
            p = polygon.pressure[picked] + what.expected[0] - base[0]
            q = polygon.shear[picked] + what.expected[1] - base[1]
            yield Hypothesis("steps", (p, q), {"steps": float(len(rows) - 1)})


def _other_times(what: Discrepancy) -> Iterator[Hypothesis]:
    """The right cycle, so much of a period late; tractions of a later instant are those of the reference there."""
    path = what.scene.load.path()
    if path.period is None or len(what.rows) < 4:
        return
    start, period = path.cycle_start + 2 * path.period, path.period

    def late(delay: float) -> Tractions:
        return answer(what, what.scene, start + np.mod(what.fraction - delay, 1.0) * period)

    tries = (*np.linspace(-0.5, -0.04, 12), -0.01, 0.01, *np.linspace(0.04, 0.5, 12))
    if (fit := fitted(what, late, tuple(tries))) and abs(fit[0]) > 1e-3:
        yield Hypothesis("other_times", fit[1], {"delay": fit[0]})
