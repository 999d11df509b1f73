"""Cases of numerical stress for the finite-element model: degenerate triangles in the bulk, bodies of absurd proportions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from unittest import mock

import numpy as np
from numpy.typing import NDArray
from stress_case import Case, Found, Trial, broken_by, ellipse, scene_of
from stress_fe import COARSE, ENGINE, FEW, LOOP, TOLD, against_theory

import halfplane_fe
import meshes
from meshes import BodyMesh, mesh_quality
from scenes import Block, Bodies

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

# Half-width a of `LOOP` at its largest load on half-planes, in the scene's lengths; above which a law is broken.
HALF_WIDTH, BROKEN = 22.6, 1e-7


def squeezed(body: BodyMesh, share: float, count: int = 30) -> BodyMesh:
    """The body with `count` slivers: as many inner nodes, far and near, moved towards the opposite side of one of their triangles,
    of whose distance they keep that `share`.
    """
    mesh = body.mesh
    places, corners = mesh.doflocs.copy(), mesh.t
    taken = set(mesh.facets[:, mesh.boundary_facets()].ravel().tolist())
    moved: list[int] = []
    for number in np.random.default_rng(0).permutation(corners.shape[1]):
        node, *side = corners[:, number].tolist()
        if len(moved) == count or not taken.isdisjoint((node, *side)):
            continue
        star = corners[:, np.any(corners == node, axis=0)]
        trial, middle = places.copy(), np.mean(places[:, side], axis=1)
        trial[:, node] = middle + share * (places[:, node] - middle)
        if np.all(_areas(trial, star) * _areas(places, star) > 0):
            places, moved = trial, [*moved, node]
            taken.update(star.ravel().tolist())
    bent = np.flatnonzero(np.isin(mesh.facets, moved).any(axis=0))
    places[:, mesh.dofs.facet_dofs[0, bent]] = np.mean(places[:, mesh.facets[:, bent]], axis=1)
    if len(moved) < count:
        raise ValueError(f"only {len(moved)} nodes can be moved")
    made = replace(mesh, doflocs=places)
    return replace(body, mesh=made, quality=mesh_quality(made, 1.0))


def _areas(places: Array, corners: Indices) -> Array:
    """Twice the signed areas of triangles (3, n)."""
    (x0, y0), (x1, y1), (x2, y2) = (places[:, row] for row in corners)
    return np.asarray((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0))


def aspect(angle: float) -> float:
    """Length over height of a sliver with that least angle [degrees]."""
    return float(1 / np.tan(np.radians(angle)))


def with_slivers(share: float) -> Found:
    """Against the half-plane engine, both bodies squeezed; the worst aspect stands beside the errors."""
    angles = []

    def build(*arguments: object) -> BodyMesh:
        body = squeezed(meshes.solids(*arguments), share)  # type: ignore[arg-type]
        angles.append(body.quality["least_angle"])
        return body

    with mock.patch("halfplane_fe.interface.build", build):
        found = against_theory(scene_of(ellipse(*LOOP)))
    return replace(found, shown={**found.shown, "aspect": aspect(min(angles))})


def sliver_trials(*shares: float) -> Iterator[Trial]:
    for share in shares:
        yield f"heights times {share:g}", partial(with_slivers, share)


def on_block(width: float, height: float) -> Found:
    """Largest p and W on a block, sizes over the half-width, against elements half as long; NaN where a law is broken."""
    block = Block(width=width * HALF_WIDTH, height=height * HALF_WIDTH)
    scene = scene_of(ellipse(*LOOP)).vary(bodies=Bodies(lower=block))
    finer = replace(COARSE, element_size=COARSE.element_size / 2, edge_element_size=COARSE.edge_element_size / 2)
    answer, better = (halfplane_fe.solve(scene, mesh, FEW) for mesh in (COARSE, finer))
    off = {
        "p": abs(float(answer.pressure.max() / better.pressure.max()) - 1),
        "W": abs(answer.dissipation / better.dissipation - 1),
    }
    if max(broken_by(answer), broken_by(better)) > BROKEN:
        off = dict.fromkeys(off, float("nan"))
    return Found(off, answer.record.notes, {"aspect": aspect(answer.bodies[0].quality["least_angle"])})


def block_trials(*sizes: tuple[float, float]) -> Iterator[Trial]:
    for width, height in sizes:
        yield f"{width:g} a by {height:g} a", partial(on_block, width, height)


def cases() -> Iterator[Case]:
    """All of them."""
    measure = "p, q in L2 and W, against the half-plane engine"
    tried = "30 triangles a body squeezed to {} of their height"
    yield Case(ENGINE, "slivers", tried.format("1e-2 ... 1e-6"), measure, TOLD, partial(sliver_trials, 1e-2, 1e-4, 1e-6))
    yield Case(
        ENGINE,
        "slivers next to rounding",
        tried.format("1e-8 ... 1e-14"),
        "refused",
        0.0,
        partial(sliver_trials, 1e-8, 1e-10, 1e-12, 1e-14),
        may_refuse=True,
        must_refuse=True,
    )
    yield Case(
        ENGINE,
        "bodies of absurd proportions",
        "lower body a block, 1e6 a wide and a high, 4 a wide and 1e-4 a high, and between",
        "largest p, W, against elements half as long",
        TOLD,
        partial(block_trials, (1e3, 1.0), (1e6, 1.0), (4.0, 1e-2), (4.0, 1e-4)),
    )
    yield Case(
        ENGINE,
        "bodies like needles",
        "lower body a block, 4 a wide, 4e3 a and 4e6 a high",
        "refused",
        0.0,
        partial(block_trials, (4.0, 4e3), (4.0, 4e6)),
        may_refuse=True,
        must_refuse=True,
    )
