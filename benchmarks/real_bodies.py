"""Blocks, pads and cylinders: mesh error, the limit in which they become half-planes, a layer without them, stiffness ratios.

python benchmarks/real_bodies.py            (about three minutes)

Every figure is of the FE model on real bodies. Truth is a finer mesh, the half-plane engine in the limit of small a/size and
a/R, or Fourier integrals for the layer (tests/layer_truth.py): never a half-plane where bodies are finite.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from claim import Row, slope, table, with_children

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution
from meshes import MeshSettings
from scenes import Block, Bodies, Cylinder, Elastic, Hertz, Materials, Pad, PolygonLoad, Scene, load_scene

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
import layer_truth

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


def pad_on_block(size: float) -> Bodies:
    """A square pad on a square block."""
    return Bodies(lower=Block(width=size, height=size), upper=Pad(width=size, height=size))


def mindlin(bodies: Bodies, radius: float = 1000.0, half_width: float = 1.0) -> Scene:
    """P constant, Q between +-0.6 f P, a = `half_width` if the bodies were half-planes."""
    like = load_scene("cattaneo-mindlin")
    compliance = sum((1 - m.poisson_ratio**2) / m.young_modulus for m in (like.material.lower, like.material.upper))
    normal = np.pi * half_width**2 / (4 * radius * compliance)
    tangential = 0.6 * like.friction.coefficient * normal
    load = PolygonLoad(initial_loading=((normal, 0.0), (normal, tangential)), cycle=((normal, -tangential),))
    return like.vary(bodies=bodies, profile=Hertz(radius=radius), load=load)


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


def idealisation(scene: Scene) -> tuple[dict[str, float], int]:
    """What half-plane theory is off by on the bodies of a scene, as FE less theory, and degrees of freedom."""
    answer = halfplane_fe.solve(scene)
    theory = semi_analytic.solve(scene, x=answer.x, time=answer.time)
    largest = int(np.argmax(answer.normal_load))
    found = {
        "peak pressure": float(answer.pressure[largest].max() / theory.pressure[largest].max() - 1),
        "contact half-width": float(answer.contact_half_width[largest] / theory.contact_half_width[largest] - 1),
        "dissipation": answer.dissipation / theory.dissipation - 1,
    }
    return found, int(answer.work.counts["degrees of freedom"])


def limits() -> Iterator[Row]:
    """Bodies that grow become half-planes: at the rate (a/size)^2, (a/R)^2, and how near they are at the far end."""
    ladders = {
        "blocks": [(size, blocks(size), 1000.0) for size in (10.0, 20.0, 40.0, 80.0)],
        "cylinders": [
            (2 * r, Bodies(lower=Cylinder(radius=2 * r), upper=Cylinder(radius=2 * r)), r) for r in (5.0, 10.0, 20.0, 40.0)
        ],
        "pad on block": [(r, pad_on_block(r), r) for r in (10.0, 20.0, 40.0, 80.0)],
    }
    # What is left when the bodies are half-planes: error of the default mesh, the same on every rung.
    floor, _ = idealisation(mindlin(Bodies()))
    for name, rungs in ladders.items():
        errors = [idealisation(mindlin(bodies, radius))[0] for _, bodies, radius in rungs]
        sizes = np.array([size for size, _, _ in rungs])
        for figure in ("peak pressure", "dissipation"):
            values = np.abs([error[figure] - floor[figure] for error in errors])
            order = -slope(sizes, values)
            how = f"errors {', '.join(f'{v:.1e}' for v in values)} at sizes {', '.join(f'{s:g}' for s in sizes)} a"
            yield Row(f"{name}, {figure}: order in a/size, less 2", order - 2, 0.3, how)
    for name, bodies, radius in (
        ("blocks of 320 a", blocks(320.0), 1000.0),
        ("pad of R = 400 a on a block of 320 a", pad_on_block(320.0), 400.0),
    ):
        for figure, error in idealisation(mindlin(bodies, radius))[0].items():
            yield Row(f"{name}: {figure} against half-plane theory", error, 5e-4, "the far end of the ladder")


def layer_scene(thickness: float, nu: float, stiffness: float, load: float, width: float = 8.0) -> Scene:
    """A stiff parabola of radius 100 on a layer of unit modulus on a rigid base."""
    like = load_scene("hertz-normal")
    upper, lower = Elastic(young_modulus=stiffness, poisson_ratio=0.3), Elastic(young_modulus=1.0, poisson_ratio=nu)
    changes = {
        "material": Materials(upper=upper, lower=lower),
        "profile": Hertz(radius=100.0),
        "friction": 0.0,
        "load": PolygonLoad(initial_loading=((load, 0.0),)),
        "bodies": Bodies(lower=Block(width=width, height=thickness), upper=Block(width=width, height=4.0)),
    }
    return like.vary(**changes)


def layer_errors(thickness: float, nu: float = 0.3, stiffness: float = 1e6, width: float = 8.0) -> dict[str, float]:
    """Half-width, peak and L2 of the pressure against Fourier integrals."""
    layer = layer_truth.Layer(1.0, nu, thickness, 100.0)
    load = layer_truth.load_on(layer, 1.0)
    answer = halfplane_fe.solve(layer_scene(thickness, nu, stiffness, load, width))
    truth = layer_truth.pressure(layer, 1.0, answer.x)
    difference = answer.pressure[-1] - truth
    return {
        "half-width": float(answer.contact_half_width[-1]) - 1.0,
        "peak pressure": float(answer.pressure[-1].max() / truth.max() - 1),
        "pressure, L2": float(np.sqrt(np.trapezoid(difference**2, answer.x) / np.trapezoid(truth**2, answer.x))),
    }


def layers() -> Iterator[Row]:
    """A layer on a rigid base, thick to thin; then nearly incompressible; then under punches that get stiffer."""
    for thickness in (1.0, 0.5, 0.2, 0.1):
        for name, error in layer_errors(thickness).items():
            yield Row(f"layer of a/t = {1 / thickness:g}: {name}", error, 5e-3, "against Fourier integrals")
    for nu in (0.49, 0.4999):
        error = layer_errors(0.5, nu, width=16.0)["pressure, L2"]
        yield Row(f"layer of a/t = 2, nu = {nu}: pressure, L2", error, 5e-3, "against Fourier integrals; nothing locks")
    errors = [layer_errors(1.0, stiffness=ratio)["peak pressure"] for ratio in (1e1, 1e2, 1e3, 1e6)]
    order = np.log10(abs((errors[0] - errors[3]) / (errors[2] - errors[3]))) / 2
    how = f"off by {', '.join(f'{error:.1e}' for error in errors)} at E2/E1 = 10, 100, 1000, 10^6"
    yield Row("a stiff punch becomes a rigid one: order in E1/E2, less 1", order - 1, 0.15, how)


def stiffness_ratios() -> Iterator[Row]:
    """Any E1/E2: the answer of the upper body a million times stiffer, and softer, is the mirror image of the other."""
    scene, found = mindlin(blocks(10.0)), []
    soft = scene.material.lower
    stiff = soft.vary(young_modulus=1e6 * soft.young_modulus)
    for lower, upper in ((stiff, soft), (soft, stiff)):
        found.append(halfplane_fe.solve(scene.vary(material=Materials(lower=lower, upper=upper))))
    yield Row("E1/E2 = 10^-6 against 10^6: dissipation", found[0].dissipation / found[1].dissipation - 1, 1e-3, "both converge")


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
    for part in (mesh_error, limits, layers, stiffness_ratios, roller, costs):
        yield from part()


if __name__ == "__main__":
    print(table(rows()))
