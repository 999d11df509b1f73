"""Every number of a scene, from a file or from Python: finite, its square too, or refused in one
sentence of one kind.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import BaseModel

import semi_analytic
from scenes import ContactSolution, FlatRounded, Friction, Hertz, InputError, Pad, Scene, load_scene
from scenes.arrays import real_numbers
from scenes.measured import Table

SCENES = ("hertz-paper", "flat-rounded-paper", "nowell-hills", "flat-pad-on-block")
# Not of physics: only these may be of any size.
FREE = {"cycles", "expected", "tolerances", "tags"}
IMPOSSIBLE = [
    1e160,
    -1e160,
    1e308,
    -1e308,
    math.nan,
    math.inf,
    -math.inf,
    10**400,
    1j,
    np.complex128(1 + 0j),
    np.float64(1e160),
]


def number_keys(table: Any, way: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """Ways to all keys of a table that hold one number."""
    ways = []
    for name, value in table:
        if isinstance(value, BaseModel):
            ways += number_keys(value, (*way, name))
        elif isinstance(value, float) and not isinstance(value, bool) and name not in FREE:
            ways.append((*way, name))
    return ways


def changed(way: tuple[str, ...], value: Any) -> dict[str, Any]:
    """Nested changes of one key."""
    for name in reversed(way):
        value = {name: value}
    return value


CASES = [
    (scene, way)
    for scene in SCENES
    for way in number_keys(load_scene(scene))
    if not FREE & set(way)
]


@pytest.mark.parametrize(("name", "way"), CASES, ids=str)
def test_a_number_that_cannot_be_squared_is_refused_in_one_sentence(
    name: str, way: tuple[str, ...]
) -> None:
    scene = load_scene(name)
    for value in IMPOSSIBLE:
        with pytest.raises(InputError) as caught:
            scene.vary(**changed(way, value))
        assert len(str(caught.value).splitlines()) == 1
        assert way[-1] in str(caught.value) or way[0] in str(caught.value)


@pytest.mark.parametrize(("name", "way"), CASES, ids=str)
def test_a_tiny_number_has_an_answer_or_is_refused(name: str, way: tuple[str, ...]) -> None:
    """A scale whose square is 0 is refused; a load or amplitude so small is as good as none."""
    scene = load_scene(name)
    if not scene.bodies.half_planes:
        return  # half-plane theory answers none of them
    try:
        solution = semi_analytic.solve(
            scene.vary(**changed(way, 1e-160)), x=[0.0], fields=("dissipation",)
        )
    except InputError as reason:
        assert len(str(reason).splitlines()) == 1  # noqa: PT017
    else:
        assert np.isfinite(solution.dissipation)


@pytest.mark.parametrize("value", [np.float64(2.0), np.float32(2.0), np.int64(2), np.array(2.0), 2])
def test_numpy_numbers_are_numbers(value: Any) -> None:
    assert (
        load_scene("hertz-paper").vary(friction=2).friction.coefficient
        == Friction(coefficient=value).coefficient
    )
    assert Hertz(radius=value).radius == 2.0


@pytest.mark.parametrize(
    "build",
    [
        lambda: Hertz(radius=-1.0),
        lambda: Hertz(radius=1e160),
        lambda: FlatRounded(radius=1.0, flat_half_length=1e-160),
        lambda: Friction(coefficient=1e160),
        lambda: Friction(coefficient=1e-160),
        lambda: Pad(width=-1.0, height=1.0),
        lambda: Pad(width=1j, height=1.0),
        lambda: Hertz(radios=1.0),
    ],
)
def test_constructors_refuse_as_files_do(build: Any) -> None:
    """`ValidationError` of pydantic in four lines with a link stood there."""
    with pytest.raises(InputError) as caught:
        build()
    assert len(str(caught.value).splitlines()) == 1


def test_a_scene_whose_parts_do_not_fit_is_refused_from_python_as_from_a_file() -> None:
    """A pad that is wider than its arcs."""
    scene = load_scene("flat-pad-on-block")
    keys = {name: getattr(scene, name) for name in ("material", "profile", "friction", "load")}
    wide = scene.bodies.vary(lower={"width": 1e4}, upper=Pad(width=1e3, height=10.0))
    with pytest.raises(
        InputError, match=r"^Scene: bodies\.upper\.width = 1000 goes past the end of the pad's arcs"
    ):
        Scene(**keys, bodies=wide)


def test_huge_bulk_stress_is_refused_and_no_raw_error() -> None:
    scene = load_scene("nowell-hills")
    for stress in (1e5, 1e50, -1e9):
        with pytest.raises(InputError, match="all cells slip"):
            semi_analytic.solve(scene.vary(load={"bulk_stress_lower": stress}), x=[0.0])


def test_complex_numbers_in_a_stored_solution_are_refused(tmp_path: Any) -> None:
    """Certificates were read by their real parts."""
    path = tmp_path / "complex.nc"
    dataset = semi_analytic.solve(load_scene("hertz-normal"), x=[0.0]).to_dataset()
    dataset["tilt"] = dataset["time"] * (1 + 1j)
    with pytest.warns(UserWarning, match="invalid netcdf"):
        dataset.to_netcdf(path, engine="h5netcdf", invalid_netcdf=True)
    with pytest.raises(InputError, match="tilt holds complex numbers"):
        ContactSolution.load(path)


def test_rows_of_complex_numbers_are_no_table() -> None:
    with pytest.raises(ValueError, match="rows of equally many numbers"):
        Table.of_rows([[0.0, 1j], [1.0, 2.0]])
    np.testing.assert_array_equal(real_numbers([1, 2.5], "load"), [1.0, 2.5])
