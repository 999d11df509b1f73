"""Condensed bodies cached in the process: known by content, bounded in bytes, counted, and never
the reason for another answer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from inspect import signature

import numpy as np
import pytest
import skfem

import halfplane_fe
from halfplane_fe import SolverSettings, condensed_bodies, elasticity
from halfplane_fe.condensed_bodies import CACHED, CondensedBodies
from halfplane_fe.elasticity import condense
from meshes import BodyMesh, MeshSettings, SurfaceGrading, half_disc
from scenes import Elastic, Hertz, Materials, Scene, load_scene
from scenes.array_types import Array
from shared_runs import SHARED, made_again

Body = tuple[BodyMesh, Elastic, float]
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
SOFTER = Elastic(young_modulus=70e3, poisson_ratio=0.33)
MESH = MeshSettings(element_size=1 / 10, edge_element_size=1 / 20)
LARGE = 10**9


@cache
def body() -> BodyMesh:
    return half_disc(
        "lower", SurfaceGrading(inner=0.0, outer=1.0, size=0.2, edge_size=0.2, radius=5.0)
    )


def condensations(bodies: CondensedBodies, *inputs: Body) -> list[int]:
    """0 for each body taken from the cache, 1 for each that was condensed."""
    counts = []
    for parts in inputs:
        work: Counter[str] = Counter()
        bodies.condensed_body(*parts, work)
        assert work["condensations"] + work[CACHED] == 1
        counts.append(work["condensations"])
    return counts


def test_the_second_solve_condenses_nothing_states_it_and_answers_the_same_bits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(condensed_bodies.BODY_CACHE, "bound_bytes", LARGE)
    monkeypatch.setattr(
        condensed_bodies.BODY_CACHE, "_cached", type(condensed_bodies.BODY_CACHE._cached)()
    )
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    with made_again():
        first, second = (
            halfplane_fe.solve(load_scene("cattaneo-mindlin"), MESH, settings) for _ in range(2)
        )
    assert (first.work.counts["condensations"], first.work.counts["coarse condensations"]) == (1, 1)
    assert second.work.counts["condensations"] == second.work.counts["sparse factorisations"] == 0
    assert second.work.counts[CACHED] == second.work.counts[f"coarse {CACHED}"] == 1
    assert "condensations, cached" not in first.work.skipped
    assert second.work.skipped["condensations, cached"] == (
        1,
        "this process condensed the body before: taken from the cache",
    )
    for name in ("pressure", "shear", "slip", "dissipation_density"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()


def hits(scene: Scene) -> list[int]:
    """How many coarse runs, meshes and bodies a solve takes from those that the tests share."""
    shared = SHARED[:3]
    before = [function.hits for function in shared]
    halfplane_fe.solve(scene, MESH, SolverSettings(steps_per_cycle=8, step_tolerance=np.inf))
    return [function.hits - count for function, count in zip(shared, before, strict=True)]


def test_what_tests_share_is_made_once_and_again_while_anything_is_replaced(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("hertz-normal")
    hits(scene)
    assert hits(scene.vary(name="by another name")) == [1, 1, 1]
    # Meshes follow the scales, which follow the radius; bodies follow Poisson's ratio. Both are of
    # this test alone.
    own = Elastic(young_modulus=70e3, poisson_ratio=0.3317)
    material = Materials(lower=own, upper=own)
    assert hits(scene.vary(profile=Hertz(radius=1001.0), material=material)) == [0, 0, 0]
    with made_again():
        assert hits(scene) == [0, 0, 0]
    for holder, name in ((elasticity, "split_lame"), (BodyMesh, "__repr__")):
        with monkeypatch.context() as patch:
            right = getattr(holder, name)
            patch.setattr(holder, name, lambda *arguments, right=right: right(*arguments))
            assert hits(scene) == [0, 0, 0], name
    assert hits(scene) == [1, 1, 1]


def with_mesh(**changes: object) -> BodyMesh:
    return replace(body(), mesh=replace(body().mesh, **changes))


def moved(mesh: skfem.Mesh) -> Array:
    """Places of the nodes with one inside the body moved by a rounding."""
    places = mesh.doflocs.copy()
    places[:, np.argmin(np.abs(places[0] - 0.1) + np.abs(places[1] + 2.0))] *= 1 + 1e-15
    return places


def longer(mesh: skfem.Mesh) -> Array:
    """The facets of a boundary, the last one a second time."""
    return np.concatenate([mesh.boundaries["free"], mesh.boundaries["free"][-1:]])


# Fields of a body that its compliance depends on, with another value, and those that it does not
# depend on.
BODY: dict[str, Callable[[], BodyMesh]] = {
    "mesh": lambda: with_mesh(doflocs=moved(body().mesh)),
    "grading": lambda: replace(body(), grading=replace(body().grading, inner=0.1)),
    "supports": lambda: replace(body(), supports={"far_field": "fixed"}),
}
FREE = {"name", "quality"}
# Two of (body, material, datum).
UNLIKE: dict[str, Callable[[], Body]] = {
    **{name: lambda name=name: (BODY[name](), STEEL, 7.0) for name in BODY},
    **{
        name: lambda name=name: (
            body(),
            STEEL.model_copy(update={name: getattr(STEEL, name) * (1 + 1e-15)}),
            7.0,
        )
        for name in Elastic.model_fields
    },
    "datum": lambda: (body(), STEEL, 7.0 * (1 + 1e-15)),
    "boundary": lambda: (
        with_mesh(_boundaries={**body().mesh.boundaries, "free": longer(body().mesh)}),
        STEEL,
        7.0,
    ),
    "name of a boundary": lambda: (
        with_mesh(_boundaries={**body().mesh.boundaries, "side": longer(body().mesh)}),
        STEEL,
        7.0,
    ),
    "elements": lambda: (with_mesh(t=body().mesh.t[:, ::-1]), STEEL, 7.0),
}


def test_the_tables_of_inputs_are_whole() -> None:
    """A new field of a body, or a new argument of `condense`, fails here until the key is shown to
    change with it.
    """
    assert BODY.keys() | FREE == {field.name for field in fields(BodyMesh)}
    assert list(signature(condense).parameters) == ["body", "material", "datum_length"]


@pytest.mark.parametrize("name", UNLIKE)
def test_another_input_is_another_body(name: str) -> None:
    same = (body(), STEEL, 7.0)
    assert condensations(CondensedBodies(LARGE), same, UNLIKE[name](), same) == [1, 1, 0]


def test_the_least_recently_used_body_gives_way_and_the_bound_holds() -> None:
    bodies = CondensedBodies(LARGE)
    first, second, third = ((body(), STEEL, datum) for datum in (7.0, 8.0, 9.0))
    condensations(bodies, first)
    one_body = bodies.nbytes
    compliance = bodies.condensed_body(*first, Counter()).compliance
    assert compliance.nbytes <= one_body <= 1.2 * compliance.nbytes
    bodies.bound_bytes = 2 * one_body
    # the third takes the place of the second
    assert condensations(bodies, second, first, third) == [1, 0, 1]
    assert bodies.nbytes == 2 * one_body
    assert condensations(bodies, first, third, second) == [0, 0, 1]
    assert bodies.nbytes == 2 * one_body


def test_a_body_beyond_the_bound_is_not_cached_and_removes_no_other() -> None:
    bodies = CondensedBodies(LARGE)
    small = (body(), STEEL, 7.0)
    large = (
        half_disc("lower", replace(body().grading, edge_size=0.1, size=0.1)),
        STEEL,
        7.0,
    )
    condensations(bodies, small)
    bodies.bound_bytes = bodies.nbytes
    assert condensations(bodies, large, large, small) == [1, 1, 0]
    bodies.bound_bytes = 0
    assert condensations(bodies, large, large) == [1, 1]
