"""Blocks, pads and cylinders: mesh error against a finer mesh, the NAFEMS roller, cost of a run.

Their limits, half-planes and a layer on a rigid base, are in tests/test_halfplane_fe_accuracy.py.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from claim import Row, with_children

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution
from meshes import MeshSettings
from scenes import Block, Bodies, Hertz, PolygonLoad, Scene, load_scene

FINER = MeshSettings(element_size=1 / 48, edge_element_size=1 / 320)
FINEST = MeshSettings.fine()
BODY_SCENES = (
    "blocks",
    "cylinder-roller",
    "cylinder-roller-frictionless",
    "flat-pad-on-block",
    "layer",
    "pad-on-block",
    "two-cylinders",
)


@dataclass(frozen=True)
class Figures:
    """What is compared of a solution: at the largest load, at common instants of the last cycle, over the cycle."""

    peak: float
    half_width: float
    stick: np.ndarray
    dissipation: float


def blocks(size: float) -> Bodies:
    """Two square blocks."""
    return Bodies(lower=Block(width=size, height=size), upper=Block(width=size, height=size))


def mindlin(bodies: Bodies) -> Scene:
    """P constant, Q between +-0.6 f P, a = 1 if the bodies were half-planes."""
    like = load_scene("cattaneo-mindlin")
    compliance = sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (like.material.lower, like.material.upper))
    normal = np.pi / (4 * 1000.0 * compliance)
    tangential = 0.6 * like.friction.coefficient * normal
    load = PolygonLoad(initial_loading=((normal, 0.0), (normal, tangential)), cycle=((normal, -tangential),))
    return like.vary(bodies=bodies, profile=Hertz(radius=1000.0), load=load)


def figures(answer: FiniteElementSolution, instants: Sequence[float]) -> Figures:
    """Figures of a solution; the instants are among its steps."""
    largest = int(np.argmax(answer.normal_load))
    steps = [int(np.argmin(np.abs(answer.time - instant))) for instant in instants]
    if max(abs(answer.time[step] - instant) for step, instant in zip(steps, instants, strict=True)) > 1e-9:
        raise ValueError("an instant is not among the steps")
    return Figures(
        float(answer.pressure[largest].max()),
        float(answer.contact_half_width[largest]),
        answer.stick_half_width[steps],
        answer.dissipation,
    )


def off(one: Figures, other: Figures) -> dict[str, float]:
    """Relative differences; the stick edge over the contact half-width, worst instant."""
    return {
        "peak pressure": one.peak / other.peak - 1,
        "contact half-width": one.half_width / other.half_width - 1,
        "stick half-width": float(np.abs(one.stick - other.stick).max()) / other.half_width,
        "dissipation": one.dissipation / other.dissipation - 1,
    }


def mesh_error() -> Iterator[Row]:
    """Blocks of 4, 10 and 40 half-widths, half the default sizes against the finest mesh, P constant and Q cycling."""
    for size in (4.0, 10.0, 40.0):
        scene = mindlin(blocks(size))
        instants = (2.0, 3.0, 4.0)  # Q at its largest and least: the stick zone is at its smallest
        default, finer, finest = (figures(halfplane_fe.solve(scene, mesh), instants) for mesh in (MeshSettings(), FINER, FINEST))
        for name, error in off(finer, finest).items():
            how = f"elements of a/320 at the edges against a/640; default mesh {off(default, finest)[name]:.1e}"
            yield Row(f"blocks {size:g} a high and wide, mesh error: {name}", error, 5e-4, how)


def roller() -> Iterator[Row]:
    """The NAFEMS roller beside Hertz, as the published benchmark compares it."""
    for name, limit in (("cylinder-roller-frictionless", 5e-3), ("cylinder-roller", 3e-2)):
        answer = halfplane_fe.solve(load_scene(name))
        hertz = semi_analytic.solve(load_scene(name), x=answer.x, time=answer.time)
        peak, width = float(answer.pressure[-1].max()), float(answer.contact_half_width[-1])
        how = f"{peak:.0f} MPa and {width:.3f} mm; Hertz 3585 MPa and 6.215 mm; a/R = 0.124"
        yield Row(f"{name}: peak pressure against Hertz", peak / float(hertz.pressure[-1].max()) - 1, limit, how)
        yield Row(f"{name}: half-width against Hertz", width / float(hertz.contact_half_width[-1]) - 1, limit, how)


def costs() -> Iterator[Row]:
    """Cold run of every body scene, in a process of its own: CPU seconds and peak memory."""
    for name in BODY_SCENES:
        # VmHWM is of this very process; ru_maxrss starts from its parent's.
        code = (
            "import os; os.environ['HALFPLANE_CACHE'] = 'off'; import halfplane_fe; from scenes import load_scene; "
            f"halfplane_fe.solve(load_scene({name!r})); "
            "print(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
        )
        command = [sys.executable, "-c", code]
        spent, done = with_children(lambda c=command: subprocess.run(c, check=True, capture_output=True, text=True))
        yield Row(f"{name}, cold: CPU", spent, 20.0, "a process of its own", "s")
        yield Row(f"{name}, cold: peak memory", int(done.stdout) / 2**20, 2.0, "resident", "GiB")


def rows() -> Iterator[Row]:
    """Everything, in the order of the docstring."""
    for part in (mesh_error, roller, costs):
        yield from part()
