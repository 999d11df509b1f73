"""Edges of the finite elements: is their stated uncertainty honest, and what halving increments at constant load buys.

python benchmarks/fe_edges.py
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
from claim import Row, table

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from scenes import load_scene

# Half-planes with friction, on which theory's edges are exact.
SCENES = (
    *("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper", "phase-45", "near-sliding"),
    *("motor", "harmonics", "tiny-slip", "compound-curvature"),
)
STEPPED = "cattaneo-mindlin"


def honesty() -> Iterator[Row]:
    """Over the scenes: share of instants outside the stated uncertainty at the worst scene, and how large it is."""
    shares: dict[str, dict[str, float]] = {"contact": {}, "stick": {}}
    sizes: dict[str, list[float]] = {"contact": [], "stick": []}
    for name in SCENES:
        fe = halfplane_fe.solve(load_scene(name))
        exact = semi_analytic.solve(fe.scene, x=[0.0], time=fe.time)
        for edge, honest in shares.items():
            error = np.abs(getattr(fe, f"{edge}_edges") - getattr(exact, f"{edge}_edges"))[1:]
            stated = getattr(fe, f"{edge}_edge_uncertainty")[1:]
            honest[name] = float(np.mean(np.all(error <= stated, axis=1)))
            sizes[edge] += [float(np.median(stated / fe.settings["element_size"]))]
    for edge, of in shares.items():
        worst = min(of, key=lambda name: of[name])
        how = f"{len(of)} scenes with the default mesh, the worst of them {worst}"
        yield Row(f"{edge} edges within their uncertainty, instants", 100 * of[worst], None, how, "%")
        how = "of its median in each scene; element at the edges"
        yield Row(f"uncertainty of {edge} edges, median", float(np.median(sizes[edge])), None, how, "elements")


def halving() -> Iterator[Row]:
    """What halving of increments by their step error buys at constant load: the same scene with and without."""
    found = {}
    for words, settings in (("halved", SolverSettings()), ("not halved", SolverSettings(step_tolerance=float("inf")))):
        fe = halfplane_fe.solve(load_scene(STEPPED), settings=settings)
        found[words] = fe, semi_analytic.solve(fe.scene, x=fe.x, time=fe.time)
    for words, (fe, exact) in found.items():
        yield Row(f"{STEPPED}, increments {words}: their number", float(len(fe.time) - 1), None, "default mesh")
        off = abs(fe.loop_work / exact.loop_work - 1)
        yield Row(f"{STEPPED}, increments {words}: closed integral of Q dU, off by", off, None, "default mesh")
    work = [fe.dissipation for fe, _ in found.values()]
    yield Row(f"{STEPPED}: dissipation, not halved against halved", work[1] / work[0] - 1, None, "default mesh")


def rows() -> Iterator[Row]:
    """All rows of this page."""
    yield from honesty()
    yield from halving()


if __name__ == "__main__":
    os.environ["HALFPLANE_CACHE"] = "off"
    print(table(list(rows())))
