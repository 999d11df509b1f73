"""What both engines skip, scene by scene, and what that saves: with and without, and whether the answers agree."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import halfplane_fe
import semi_analytic
from halfplane_fe.active_subsets import NestedFactor
from halfplane_fe.systems import Systems
from meshes import MeshSettings
from scenes import ContactSolution, ConvergenceError, InadmissibleLoadError, InputError, Scene, load_scene, scene_names

TITLE = "What is skipped"
RUNS = 2


# Plain functions: a mock's own bookkeeping would count in the times.
def _no(*_: Any) -> bool:
    return False


def _yes(*_: Any) -> bool:
    return True


def module(name: str) -> Any:
    """A module of the FE model by name: the package's `solve` is its function."""
    return import_module(f"halfplane_fe.{name}")


def whole_faces() -> contextlib.AbstractContextManager[Any]:
    """Both halves of mirror-symmetric faces are solved."""
    return mock.patch.object(module("solve"), "mirrored", _no)


def factors_anew() -> contextlib.AbstractContextManager[Any]:
    """A new Cholesky factor for each set of equations."""

    def nested(self: Systems, name: str) -> NestedFactor:
        return NestedFactor(getattr(self, name), self.interface.x, self.interface.normals[1], Counter())

    return mock.patch.object(Systems, "_nested", nested)


def every_revolution() -> contextlib.AbstractContextManager[Any]:
    """No revolution counts as a repetition of the one before."""
    return mock.patch.object(module("run"), "REPEATS", -1.0)


def both_bodies() -> contextlib.AbstractContextManager[Any]:
    """Like bodies are meshed and condensed one by one."""
    pair = module("interface")
    own = pair.build

    def twice(scene: Scene, mesh: MeshSettings, grading: Callable[[float], Any]) -> tuple[Any, Any]:
        return tuple(
            own(name, body, scene.profile, grading(1.0), mesh)
            for name, body in (("lower", scene.bodies.lower), ("upper", scene.bodies.upper))
        )  # type: ignore[return-value]

    return mock.patch.object(module("solve"), "meshed_pair", twice)


@contextlib.contextmanager
def kept_bodies() -> Iterator[None]:
    """A store of condensed bodies that has those of the scene already."""
    with tempfile.TemporaryDirectory() as folder:
        before = os.environ.get("HALFPLANE_CACHE", "")
        os.environ["HALFPLANE_CACHE"] = folder
        try:
            halfplane_fe.solve(load_scene("hertz-paper"), MeshSettings.coarse())
            yield
        finally:
            os.environ["HALFPLANE_CACHE"] = before


def finite_elements(name: str, **more: Any) -> Callable[[], ContactSolution]:
    scene = load_scene(name)
    return lambda: halfplane_fe.solve(scene, MeshSettings.coarse(), **more)


def theory(scene: Scene, **more: Any) -> Callable[[], ContactSolution]:
    return lambda: semi_analytic.solve(scene, **more)


def difference(one: ContactSolution, other: ContactSolution) -> dict[str, float]:
    """Dissipation, relative; p and q over the largest p and f times that, where both have the same points and instants."""
    found = {"dissipation": abs(other.dissipation / one.dissipation - 1) if one.dissipation else abs(other.dissipation)}
    if one.pressure.shape == other.pressure.shape and np.isfinite(one.pressure).all() and np.isfinite(other.pressure).all():
        largest = float(np.max(one.pressure))
        found["pressure"] = float(np.abs(other.pressure - one.pressure).max()) / largest
        shear = float(np.abs(other.shear - one.shear).max())
        found["shear"] = shear / (one.scene.friction.coefficient * largest) if one.scene.friction.coefficient else 0.0
    return found


def compared(what: str, where: str, skipping: Any, not_skipping: Any) -> dict[str, Any]:
    """Two ways to one answer, in turn; each a (context, work) pair. Least CPU times, ratios of the pairs, difference."""
    (within, work), (without, full) = skipping, not_skipping
    times: list[tuple[float, float]] = []
    answers: list[ContactSolution] = []
    for _ in range(RUNS):
        pair = []
        for context, solve in ((within, work), (without, full)):
            with context():
                begun = time.process_time()
                answers.append(solve())
                pair.append(time.process_time() - begun)
        times.append((pair[0], pair[1]))
    ratios = [other / one for one, other in times]
    print(f"    {what}: {min(ratios):.2f} to {max(ratios):.2f}", flush=True)
    return {
        "what": what,
        "scene": where,
        "with": min(one for one, _ in times),
        "without": min(other for _, other in times),
        "ratios": ratios,
        "difference": difference(answers[-2], answers[-1]),
    }


def switches() -> Iterator[dict[str, Any]]:
    """Every kind of work that can be done all the same, in a scene where there is much of it."""
    plain, paper = contextlib.nullcontext, "hertz-paper"
    fe, known = finite_elements(paper), halfplane_fe.solve(load_scene(paper), MeshSettings.coarse()).scales
    yield compared("one half of mirror-symmetric faces", paper, (plain, fe), (whole_faces, fe))
    yield compared("Cholesky factors kept for all sets of nodes", paper, (plain, fe), (factors_anew, fe))
    yield compared("one of two like bodies meshed and condensed", paper, (plain, fe), (both_bodies, fe))
    yield compared("condensed bodies read from the store", paper, (kept_bodies, fe), (plain, fe))
    yield compared("coarse run, its scales given", paper, (plain, finite_elements(paper, scales=known)), (plain, fe))
    yield compared("revolutions after the steady one", paper, (plain, fe), (every_revolution, fe))
    yield compared("tangential problem where nothing can shear", "hertz-normal", *_normal_alone())
    scene = load_scene(paper)
    own = theory(scene)
    yield compared("theory: fields not asked for (W alone)", paper, (plain, theory(scene, fields=("dissipation",))), (plain, own))
    yield compared("theory: points at -x copied from x", paper, (plain, own), (every_point, own))
    yield compared("theory: cycles after the steady one", paper, (plain, own), (every_cycle, own))


def _normal_alone() -> tuple[Any, Any]:
    solve = finite_elements("hertz-normal")
    return (contextlib.nullcontext, solve), (lambda: mock.patch.object(module("solve"), "needs_shear", _yes), solve)


def every_point() -> contextlib.AbstractContextManager[Any]:
    """Half-plane theory evaluates x and -x one by one."""

    def apart(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        order = np.argsort(np.abs(x), kind="stable")
        return np.abs(x)[order], np.argsort(order)

    return mock.patch.object(import_module("semi_analytic.solution"), "folded", apart)


def every_cycle() -> contextlib.AbstractContextManager[Any]:
    """Half-plane theory takes no cycle for a repetition of the one before."""
    return mock.patch.object(import_module("semi_analytic.history"), "same", _no)


def scene_work(name: str) -> dict[str, Any]:
    """Work done and skipped by both engines on a scene of the library, coarse mesh."""
    scene = load_scene(name)
    found: dict[str, Any] = {"scene": name}
    for engine, solve in (
        ("fe", lambda: halfplane_fe.solve(scene, MeshSettings.coarse())),
        ("theory", lambda: semi_analytic.solve(scene)),
    ):
        begun = time.process_time()
        try:
            work = solve().work
        except (InputError, InadmissibleLoadError, ConvergenceError) as refusal:
            found[engine] = {"refused": str(refusal)}
            continue
        skipped = {key: [int(count), why] for key, (count, why) in work.skipped.items()}
        counts = {key: int(count) for key, count in work.counts.items()}
        found[engine] = {"counts": counts, "skipped": skipped, "seconds": time.process_time() - begun}
    return found


def measure() -> dict[str, Any]:
    """Both tables."""
    scenes = [scene_work(name) for name in scene_names()]
    return {"switches": list(switches()), "scenes": scenes}


def draw(found: dict[str, Any], folder: Path) -> None:
    """No figure."""


# Work that is avoided with no way to do it all the same.
ALWAYS = (
    "Increments at the instants at which a node touches or lets go: the path is stepped from touch to touch, not in small equal "
    "steps, and there is no stepping without events. What equal steps alone would need is in the "
    "series of increments of the diagrams above.",
    "The bulk: both bodies are condensed to the nodes of the contact once; the increments never see the bulk. "
    "`python benchmarks/fe_scaling.py` reckons what it would cost otherwise.",
    "Slip iterations of increments in which no node left stick, and quadratures of phases in full stick: there is nothing to do.",
)


def page(found: dict[str, Any]) -> list[str]:
    """What skipping saves, what can't be switched off, and the scenes."""
    lines = [
        f"With and without, coarse mesh, {RUNS} pairs in turn in one run; the least time of each, the ratio of each pair (least to "
        "most), and how far the two answers are apart: W relative, p over the largest p, q over f times that. Where no setting "
        "switches the skipping off, the benchmark replaces the function that decides on it.",
        "",
        "| skipped | scene | with [s] | without [s] | times faster | W | p | q |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in found["switches"]:
        apart = (
            f"{row['difference'][key]:.1e}" if key in row["difference"] else "" for key in ("dissipation", "pressure", "shear")
        )
        times = f"{row['with']:.3g} | {row['without']:.3g} | {min(row['ratios']):.2f} to {max(row['ratios']):.2f}"
        lines.append(f"| {row['what']} | {row['scene']} | {times} | {' | '.join(apart)} |")
    lines += ["", *_agreement(found["switches"]), "", "Can't be switched off:", "", *(f"- {words}" for words in ALWAYS), ""]
    return [*lines, *_scene_tables(found["scenes"])]


def _agreement(rows: list[dict[str, Any]]) -> list[str]:
    """Which answers agree to rounding and which do not."""
    rounding = 1e-9
    off = [row for row in rows if max(row["difference"].values()) > rounding]
    if not off:
        return [f"All answers with and without agree to rounding, {rounding:g}."]
    names = "; ".join(f"“{row['what']}” ({max(row['difference'].values()):.1e})" for row in off)
    return [
        f"All answers agree to rounding, {rounding:g}, but for: {names}. A revolution of the finite elements counts as steady "
        "when no nodal force changed by more than 5e-4 of the largest: the rim of the permanent stick zone creeps on for ever, "
        "each time a tenth as far, and that is what is left out."
    ]


def _scene_tables(scenes: list[dict[str, Any]]) -> list[str]:
    """Work done and work avoided, one line a scene and engine."""
    lines = [
        "Work done and avoided scene by scene, finite elements on the coarse mesh (counts and reasons as every solution carries "
        "them in `work.counts` and `work.skipped`):",
        "",
        "| scene | CPU s | bodies condensed | nodes | increments | contact iterations | factorisations | solves | skipped |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    keys = ("condensations", "contact nodes", "steps solved", "contact iterations", "factorisations", "linear solves")
    lines += [_scene_line(one["scene"], one["fe"], keys) for one in scenes]
    lines += [
        "",
        "Half-plane theory, its own points and instants:",
        "",
        "| scene | CPU s | cycles solved | spans | instants | points, of them evaluated | quadratures | skipped |",
        "|---|---|---|---|---|---|---|---|",
    ]
    keys = ("cycles_solved", "spans", "instants", "points", "slip_quadratures")
    return [*lines, *(_scene_line(one["scene"], one["theory"], keys) for one in scenes)]


def _scene_line(name: str, work: dict[str, Any], keys: tuple[str, ...]) -> str:
    if "refused" in work:
        return f"| {name} |{' |' * (len(keys) + 1)} refused: {work['refused']} |"
    counts = work["counts"]
    cells = [str(counts.get(key, "")) for key in keys]
    if "points" in keys and "points_evaluated" in counts:
        cells[keys.index("points")] += f", {counts['points_evaluated']}"
    skipped = "; ".join(f"{key}: {count}" for key, (count, _) in work["skipped"].items())
    return f"| {name} | {work['seconds']:.3f} | {' | '.join(cells)} | {skipped or 'nothing'} |"
