"""Polygons that unload fully, P = Q = 0, on every kind of profile: theory takes them all, and W is
that of brute force.
"""

from functools import cache

import numpy as np
import pytest

import halfplane_fe
from reports.checking import engine_refusals
from scenes import InadmissibleLoadError, Scene
from semi_analytic import solve
from semi_analytic.load_series import follow, require_admissible_rows
from semi_analytic_cases import PROFILES, make_scene, polygon
from semi_analytic_oracle import Work

# Where P hardly grows the brute force needs shorter ranges.
PARTS = {"hardly growing": 4}
QUICK = ("hertz", "short flat", "|x|^3.5", "wedge")
# Tables and functions cost the brute force half a minute each.
COSTLY = tuple(name for name in PROFILES if name not in QUICK)


@cache
def random_polygons(count: int) -> tuple[Scene, ...]:
    """Scenes whose cycle of two to four points passes (0, 0) once; the profiles take turns."""
    rng = np.random.default_rng(43)
    names = list(PROFILES)
    scenes = []
    for number in range(count):
        friction = round(float(rng.uniform(0.1, 1.2)), 2)
        points = []
        for _ in range(int(rng.integers(2, 5))):
            load = round(float(rng.uniform(0.1, 4.0)), 2)
            points.append((load, round(float(load * friction * rng.uniform(-0.98, 0.98)), 4)))
        first, *cycle = points
        cycle.insert(int(rng.integers(0, len(cycle) + 1)), (0.0, 0.0))
        scene = make_scene(polygon([first], cycle), friction)
        scenes.append(scene.vary(profile=PROFILES[names[number % len(names)]]))
    return tuple(scenes)


def require_answer(scene: Scene) -> None:
    """The scene is solved with finite fields inside the Coulomb limit, and both ways to W agree."""
    answer = solve(scene, x=[0.2, 0.9], fields=("pressure", "shear", "slip", "loop_work"))
    assert np.all(np.isfinite(answer.pressure))
    assert np.all(np.isfinite(answer.slip))
    assert np.max(answer.record.certificates["cone"]) < 1e-9
    assert answer.steady_from in (0, 1), "the memory starts again at P = 0"
    stated = answer.record.errors.get("loop_work", 0.0)
    assert answer.loop_work == pytest.approx(answer.dissipation, rel=1e-11 + stated, abs=1e-300)


# as far apart as to meet all profiles but one
@pytest.mark.parametrize("number", range(0, 400, 37))
def test_full_unloading_has_an_answer(number):
    """It was refused, or not a number, where the lengths of the slipped lines add up to a last
    digit more than P.
    """
    scene = random_polygons(400)[number]
    if scene.profile.kind == "callable":
        pytest.skip("a function takes seconds: in the slow suite")
    require_answer(scene)


@pytest.mark.slow
def test_four_hundred_polygons_that_unload_fully_have_an_answer():
    for scene in random_polygons(400):
        require_answer(scene)


def test_the_front_stays_within_the_contact():
    """0 <= P_c <= P to the last digit, and a memory that is gone at P = 0: no profile is needed to
    see that.
    """
    for scene in random_polygons(400):
        points = [
            (0.0, 0.0),
            *scene.load.initial_loading,
            *scene.load.cycle,
            scene.load.initial_loading[-1],
        ]
        block = follow(None, np.array(points), scene.friction.coefficient)
        records = block.records
        assert np.all(records.slip_zone_load_at_begin <= records.load_at_begin)
        assert np.all(records.slip_zone_load_at_end <= records.load_at_end)
        unloaded = points.index((0.0, 0.0), 1)
        assert (
            follow(None, np.array(points[: unloaded + 1]), scene.friction.coefficient).curve_at_end
            is None
        )


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in COSTLY)]
)
def test_work_of_full_unloading_by_brute_force(name):
    scene = next(scene for scene in random_polygons(400) if scene.profile == PROFILES[name])
    exact = float(np.sum(Work(scene, 1, parts=PARTS.get(name, 1)).whole()))
    assert solve(scene, x=[0.0], fields="dissipation").dissipation == pytest.approx(
        exact, rel=1e-12
    )


def test_each_engine_says_whether_it_takes_full_unloading():
    scene = make_scene(polygon([(3.51, 0.02)], [(1.66, 0.77), (0.0, 0.0)]), friction=0.6)
    assert solve(scene, x=[0.0], fields="dissipation").dissipation > 0
    with pytest.raises(
        InadmissibleLoadError, match=r"finite elements need P > 0 .* theory takes full unloading"
    ):
        halfplane_fe.require_solvable(scene)
    engines = engine_refusals(scene, "unload.toml")
    assert not engines.refusal_of_theory
    assert "finite elements need P > 0" in engines.refusal_of_elements


@pytest.mark.parametrize("name", ["hertz", "short flat"])
def test_where_the_path_starts_or_turns_unloaded_nothing_sticks_through_all_of_it(
    name: str,
) -> None:
    """A flat face has its width without any load: it sticks no more than a parabola then."""
    unloaded = make_scene(polygon([(1.0, 0.2)], [(0.0, 0.0)]), 0.7)
    loaded = make_scene(polygon([(1.0, 0.2)], [(0.5, 0.0)]), 0.7)
    profile = PROFILES[name]
    stick = [
        solve(scene.vary(profile=profile), x=[0.0], fields=()).permanent_stick_half_width
        for scene in (unloaded, loaded)
    ]
    assert np.isnan(stick[0])
    assert stick[1] > 0


def test_rows_at_gross_sliding_but_for_rounding_are_taken():
    require_admissible_rows(
        np.array([[0.0, 0.0, 0.0], [1.0, 100.0, 30.0 * (1 + 4e-15)]]), friction=0.3
    )
    with pytest.raises(InadmissibleLoadError, match="gross sliding"):
        require_admissible_rows(
            np.array([[0.0, 0.0, 0.0], [1.0, 100.0, 30.0 * (1 + 4e-14)]]), friction=0.3
        )
