"""A ContactSolution in closed form, without an engine: Cattaneo-Mindlin, P constant, Q cycling.
What planted faults start from.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from reports.comparison import Comparison, compare
from reports.comparison.cycles import last_cycle
from reports.comparison.pairs import compliance_of_materials
from reports.comparison.work_of_loads import loop_work
from scenes import ContactSolution, Record, Scene, SurfaceState, Work, load_scene, read_only_copy

LOAD_RATIO = 0.6
HALF_WIDTH = 1.0
SCRIPT = "<script>document.title='run'</script>"
EVIL = f"""{SCRIPT}</script><img src=x onerror="document.title='run'"> " onmouseover="x" \
$\\frac{{ {{{{ 7*7 }}}} &amp; ]]> <!--"""


def closed_form_dissipation(scene: Scene) -> float:
    """W = (4 f^2 P^2/(pi E*)) [(1-k) ln(1-k) + k - k^2/2], k = Q/(fP): theory.md's constant-P loop,
    anchors' formula.
    """
    f = scene.friction.coefficient
    load = scene.load.path().at(1.0)[0]
    k = LOAD_RATIO
    return float(
        2
        * compliance_of_materials(scene.material)
        * (f * load) ** 2
        / np.pi
        * ((1 - k) * np.log(1 - k) + k - k**2 / 2)
    )


def cattaneo_mindlin(steps_per_leg: int = 40, points: int = 161, **changed: Any) -> ContactSolution:
    """The steady cycle of the library's cattaneo-mindlin scene, times 1 to 4, with named fields
    replaced by `changed`.
    """
    scene = load_scene("cattaneo-mindlin")
    f = scene.friction.coefficient
    a = HALF_WIDTH
    time = np.linspace(1.0, 4.0, 3 * steps_per_leg + 1)
    normal, tangential = scene.load.path().at(time)
    load = float(normal[0])
    x = np.linspace(-1.3 * a, 1.3 * a, points)
    # Share of the full amplitude since the last turn of Q, which is what slips anew: Mindlin's
    # superposition.
    turn = np.where(time <= 2.0, -1.0, np.where(time <= 3.0, 1.0, -1.0)) * LOAD_RATIO * f * load
    since = np.abs(tangential - turn) / (2 * f * load)
    sense = np.sign(tangential - turn)
    pressure = np.tile(_hertz(x, a, load, a), (len(time), 1))
    shear = -sense[:, None] * _shear(x, a, load, f, np.array([LOAD_RATIO]))
    shear = shear + 2 * sense[:, None] * _shear(x, a, load, f, since)
    shift = -sense * _shift(scene, load, LOAD_RATIO) + 2 * sense * _shift(scene, load, since)
    stick = a * np.sqrt(1 - since)
    slips = np.where(sense > 0, SurfaceState.SLIP_FORWARD, SurfaceState.SLIP_REVERSE)[:, None]
    state = np.where(np.abs(x) < stick[:, None], SurfaceState.STICK, slips)
    state = np.where(np.abs(x) < a, state, SurfaceState.OPEN)
    work = closed_form_dissipation(scene)
    inner = a * np.sqrt(1 - LOAD_RATIO)
    density = np.where((np.abs(x) > inner) & (np.abs(x) < a), 1.0, 0.0)
    fields = {
        "time": time,
        "normal_load": normal,
        "tangential_load": tangential,
        "x": x,
        "pressure": pressure,
        "shear": shear,
        "slip": np.zeros_like(shear),
        "contact_edges": np.tile([-a, a], (len(time), 1)),
        "stick_edges": np.column_stack([-stick, stick]),
        "contact_half_width": np.full_like(time, a),
        "stick_half_width": stick,
        "tangential_displacement": shift,
        "normal_approach": np.full_like(time, 0.01),
        "dissipation_density": density * work / np.trapezoid(density, x),
        "cycle_dissipation": [work],
    }
    solution = ContactSolution(
        engine="closed form",
        scene=scene,
        state=read_only_copy(state, np.int8),
        dissipation=work,
        permanent_stick_half_width=inner,
        steady_from=0,
        record=Record(
            True, "steady", "in closed form", read_only_copy(np.ones(len(time)), np.int64)
        ),
        work=Work(),
        **{name: read_only_copy(values) for name, values in fields.items()},
    )
    return with_fields(solution, **changed)


def with_fields(solution: ContactSolution, **changed: Any) -> ContactSolution:
    """`solution` with fields replaced, arrays frozen."""
    return replace(
        solution,
        **{
            name: read_only_copy(v, v.dtype) if isinstance(v, np.ndarray) else v
            for name, v in changed.items()
        },
    )


def evil() -> Comparison:
    """A result that is wrong everywhere, and every word from outside is an attack."""
    truth = cattaneo_mindlin(steps_per_leg=12, points=61)
    words = dict.fromkeys(("name", "title", "purpose", "source"), EVIL)
    record = replace(truth.record, notes=(EVIL,), message=EVIL)
    hostile = {"record": record, "settings": {EVIL: EVIL}, "versions": {EVIL: EVIL}, "engine": EVIL}
    truth = replace(truth, scene=truth.scene.vary(**words, units=f"{EVIL}, {EVIL}, MPa"), **hostile)
    wrong = {
        "pressure": 1.01 * truth.pressure,
        "shear": 0.99 * truth.shear,
        "slip": truth.slip + 1e-4,
    }
    return replace(
        compare(truth, with_fields(truth, **wrong), polygon_reference=truth), notes=(EVIL,)
    )


def _hertz(x: np.ndarray, a: float, load: float, size: Any) -> np.ndarray:
    """(2P/(pi a^2)) sqrt(size^2 - x^2), 0 outside: Hertz's pressure for size = a."""
    return 2 * load / (np.pi * a**2) * np.sqrt(np.maximum(np.square(size) - np.square(x), 0.0))


def _shear(x: np.ndarray, a: float, load: float, f: float, share: np.ndarray) -> np.ndarray:
    """First loading to Q = share f P: f p(x) less the same over the stick zone c = a sqrt(1 -
    share).
    """
    stick = a * np.sqrt(1 - share)[:, None]
    return f * (_hertz(x, a, load, a) - _hertz(x, a, load, stick))


def _shift(scene: Scene, load: float, share: Any) -> np.ndarray:
    """U = (A f/pi) int_{P_c}^{P} ln(2L/a(eta)) d eta, P_c = P (1 - share), a^2 proportional to
    eta.
    """
    f = scene.friction.coefficient
    length = scene.profile.datum_length
    start = load * (1 - np.asarray(share))

    def primitive(eta: np.ndarray) -> np.ndarray:
        return eta * (np.log(2 * length / HALF_WIDTH) + 0.5 * np.log(load)) - 0.5 * (
            eta * np.log(eta) - eta
        )

    return (
        compliance_of_materials(scene.material)
        * f
        / np.pi
        * (primitive(np.asarray(load)) - primitive(start))
    )


def test_tractions_carry_the_loads() -> None:
    solution = cattaneo_mindlin(points=4001)
    p = np.trapezoid(solution.pressure, solution.x, axis=1)
    q = np.trapezoid(solution.shear, solution.x, axis=1)
    assert p == pytest.approx(solution.normal_load, rel=1e-5)
    assert q == pytest.approx(solution.tangential_load, abs=1e-4 * solution.normal_load[0])


def test_loop_work_is_the_closed_form_and_converges_at_second_order() -> None:
    """Two independent ways to W: the loop of the closed-form shift, and the closed form of the
    dissipation.
    """
    expected = closed_form_dissipation(load_scene("cattaneo-mindlin"))
    errors = [loop_work(last_cycle(cattaneo_mindlin(steps))) / expected - 1 for steps in (40, 80)]
    assert abs(errors[1]) < 1e-3
    assert 1.8 < np.log2(errors[0] / errors[1]) < 2.1
