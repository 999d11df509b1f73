"""The engines against theory and against themselves, and the time of the main job: the first rows of the page of numbers."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import mpmath
import numpy as np
from beside_theory import beside_theory
from claim import Row
from regress_truth import modulus, truth

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from scenes import Scene, load_scene

ROOT = Path(__file__).parents[1]


def half_plane_engine() -> Iterator[Row]:
    """The semi-analytic engine against 30-digit arithmetic and against itself."""
    for name in ("hertz-paper", "cattaneo-mindlin"):
        answer = semi_analytic.solve(load_scene(name))
        error = float(mpmath.mpf(answer.dissipation) / truth(load_scene(name)) - 1)
        yield Row(f"{name}: global dissipation, relative error", error, 1e-12, "against theory in 30-digit arithmetic")
        yield Row(f"{name}: closed integral of Q dU against it", answer.loop_work / answer.dissipation - 1, 1e-10, "two routes")
    answer = semi_analytic.solve(load_scene("hertz-paper"))
    a_mean = hertz_half_width(load_scene("hertz-paper"), load_scene("hertz-paper").load.mean_normal_load)
    yield Row(
        "hertz-paper: permanent stick a(P_T)/a(P0), less 0.72705",
        answer.permanent_stick_half_width / a_mean - 0.72705,
        5e-6,
        f"{answer.permanent_stick_half_width / a_mean:.6f}",
    )
    yield Row("full-stick: dissipation", semi_analytic.solve(load_scene("full-stick")).dissipation, 0.0, "exactly zero")


def hertz_half_width(scene: Scene, load: float) -> float:
    """a(P) of Hertz."""
    return float(mpmath.sqrt(4 * load * scene.profile.radius / (mpmath.pi * modulus(scene))))


def finite_elements() -> Iterator[Row]:
    """The FE model on its default mesh against the half-plane engine."""
    scene = load_scene("hertz-paper")
    answer = halfplane_fe.solve(scene)
    comparison = beside_theory(answer)
    exact, polygon = comparison.reference, comparison.polygon_reference
    settings = MeshSettings()
    how = (
        f"default mesh: h = a/{1 / settings.element_size:.0f}, a/{1 / settings.edge_element_size:.0f} at the edges, "
        f"{answer.work.counts['degrees of freedom']} dof, {answer.work.counts['steps solved']} increments"
    )
    limits = {"dissipation": 1.5e-3, "peak_pressure": 2e-4, "pressure": 2.5e-3, "shear": 8e-3}
    for key, limit in limits.items():
        yield Row(f"hertz-paper, FE: {comparison.metric(key).label}", comparison.metric(key).value, limit, how)
    yield Row(
        "hertz-paper, FE: dissipation against the polygon of its own increments",
        answer.dissipation / polygon.dissipation - 1,
        None,
        "the rest is the error of the increments",
    )
    steps = answer.last_cycle
    for key in ("contact_edges", "stick_edges"):
        off = np.abs(getattr(answer, key)[steps] - getattr(exact, key)[steps]).max(axis=1) / answer.settings["element_size"]
        name = f"hertz-paper, FE: {key.replace('_', ' ')}"
        yield Row(f"{name}, 99 of 100 instants of the cycle", float(np.quantile(off, 0.99)), 1.0, how, "elements")
        yield Row(f"{name}, worst instant", float(off.max()), 1.0, f"at t = {answer.time[steps[off.argmax()]]:.4g}", "elements")
    checks = answer.record.certificates
    for key in ("equilibrium", "tension", "cone", "slip_sign", "energy_balance"):
        yield Row(
            f"hertz-paper, FE: {key.replace('_', ' ')}, worst increment", float(checks[key].max()), 1e-9, "no reference needed"
        )
    energy = answer.record.energy
    cycle = steps[1:]
    step_error = float(energy["end_of_step"][cycle].sum() / energy["interface"][cycle].sum() - 1)
    yield Row("hertz-paper, FE: end-of-step work less trapezoidal", step_error, None, "what end-of-step work would cost")
    full = halfplane_fe.solve(load_scene("full-stick"))
    yield Row("full-stick, FE: dissipation", full.dissipation, 0.0, "exactly zero")
    yield Row(
        "full-stick, FE: slip iterations",
        full.work.counts["slip iterations"],
        0.0,
        f"{full.work.counts['steps solved']} increments",
    )


def cattaneo_mindlin() -> Iterator[Row]:
    """The FE model at Q = 0.6 f P, first loading, and over the cycle; and the other profile of the paper."""
    scene = load_scene("cattaneo-mindlin")
    answer = halfplane_fe.solve(scene)
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    at = int(np.argmin(np.abs(answer.time - 2.0)))
    weights, f = answer.condensed[0].weights, scene.friction.coefficient
    how = f"default mesh, {answer.work.counts['degrees of freedom']} dof, Q = 0.6 f P on first loading"

    def norm(values: np.ndarray) -> float:
        return float(np.sqrt(weights @ values**2))

    pressure, shear = exact.pressure[at], exact.shear[at]
    off = np.abs(answer.stick_edges[at] - exact.stick_edges[at]).max() / answer.settings["element_size"]
    yield Row("cattaneo-mindlin, FE: peak pressure", float(answer.pressure[at].max() / pressure.max() - 1), 1e-4, how)
    yield Row("cattaneo-mindlin, FE: pressure, L2 over ||p||", norm(answer.pressure[at] - pressure) / norm(pressure), 1e-3, how)
    yield Row("cattaneo-mindlin, FE: shear, L2 over f ||p||", norm(answer.shear[at] - shear) / (f * norm(pressure)), 2e-3, how)
    yield Row("cattaneo-mindlin, FE: shear, L2 over ||q||", norm(answer.shear[at] - shear) / norm(shear), None, how)
    yield Row("cattaneo-mindlin, FE: stick edge", float(off), 0.2, how, "elements")
    yield Row(
        "cattaneo-mindlin, FE: dissipation of a cycle", answer.dissipation / exact.dissipation - 1, 5e-4, "Q between +-0.6 f P"
    )
    flat = halfplane_fe.solve(load_scene("flat-rounded-paper"))
    truth = semi_analytic.solve(flat.scene, x=[0.0], time=flat.time, fields=("dissipation",)).dissipation
    yield Row("flat-rounded-paper, FE: dissipation", flat.dissipation / truth - 1, 1e-3, "default mesh")


def times() -> Iterator[Row]:
    """Cold run of the main job, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        command = [sys.executable, "-m", "reports", "run", "hertz-paper", "--out", f"{folder}/report"]
        subprocess.run(command, check=True, capture_output=True, cwd=ROOT)
        total = time.perf_counter() - start
        seconds = json.loads((Path(folder) / "report" / "comparison.json").read_text())["seconds"]
    yield Row("cold `halfplane run hertz-paper` with the page", total, 30.0, "a process of its own", "s")
    yield Row("... of that the FE model", seconds["finite elements"], 6.0, "mesh, condensation and two revolutions", "s")
    yield Row(
        "... of that the half-plane engine", seconds["half-plane theory"], 0.1, "on the points and instants of the FE model", "s"
    )
