"""Condensed bodies on disk: found by content, safe to lose, bounded, and never the reason for another answer."""

from __future__ import annotations

import os
import threading
from collections import Counter
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import fields, replace
from functools import cache, partial
from importlib.metadata import version
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skfem
from numpy.typing import NDArray

import halfplane_fe
from halfplane_fe import SolverSettings, store
from halfplane_fe.elasticity import CondensedBody, condense
from halfplane_fe.interface import meshed_pair
from halfplane_fe.scales import Scales
from halfplane_fe.solve import surface_grading
from meshes import BodyMesh, MeshSettings, SurfaceGrading, build, half_disc
from scenes import Block, Cylinder, Elastic, Hertz, Pad, load_scene
from scenes.files import source_digest

Array = NDArray[np.float64]
ROOT = Path(__file__).parents[1]
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
MESH = MeshSettings(element_size=1 / 10, edge_element_size=1 / 20)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HALFPLANE_CACHE", str(tmp_path / "store"))
    return tmp_path / "store"


@cache
def body() -> BodyMesh:
    return half_disc("lower", SurfaceGrading(inner=0.0, outer=1.0, size=0.2, edge_size=0.2, radius=5.0))


def test_the_second_run_condenses_nothing_and_answers_the_same_bits(folder: Path) -> None:
    settings = SolverSettings(steps_per_cycle=8, step_tolerance=np.inf)
    first, second = (halfplane_fe.solve(load_scene("cattaneo-mindlin"), MESH, settings) for _ in range(2))
    assert first.work.counts["condensations"] == 1
    assert second.work.counts["condensations"] == second.work.counts["sparse factorisations"] == 0
    assert second.work.skipped["condensations, stored"][0] == 1
    np.testing.assert_array_equal(first.shear, second.shear)
    assert len(list(folder.iterdir())) == 2  # the body and the coarse one


def entries(folder: Path, *asked: tuple[BodyMesh, Elastic, float]) -> int:
    """How many files the store keeps of these; a file that was found and refused fails."""
    work: Counter[str] = Counter()
    for one in asked:
        store.condensed(*one, work)
    assert not list(store.refusals(work))
    return len(list(folder.iterdir()))


def with_mesh(**changes: object) -> BodyMesh:
    return replace(body(), mesh=replace(body().mesh, **changes))


def longer(array: Array) -> Array:
    """The last node of a boundary, or of a table of elements, a second time."""
    return np.concatenate([array, array[..., -1:]], axis=-1)


def moved(mesh: skfem.Mesh) -> Array:
    """Places of the nodes with one inside the body moved by a rounding."""
    places = mesh.doflocs.copy()
    places[:, np.argmin(np.abs(places[0] - 0.1) + np.abs(places[1] + 2.0))] *= 1 + 1e-15
    return places


# Every input of the condensation with another value: of each field of a body, of its grading, its mesh, its material.
BODY = {
    "name": lambda: replace(body(), name="upper"),
    "mesh": lambda: with_mesh(doflocs=moved(body().mesh)),
    "grading": lambda: replace(body(), grading=replace(body().grading, inner=0.1)),
    "quality": lambda: replace(body(), quality={**body().quality, "worst": 1.0}),
    "supports": lambda: replace(body(), supports={"far_field": "fixed"}),
}
GRADING = {field.name: 1.25 * getattr(body().grading, field.name) + 0.01 for field in fields(SurfaceGrading)}
SETTINGS: dict[str, Any] = {
    "element_size": 0.2,
    "edge_element_size": 0.04,
    "upper_ratio": 1.5,
    "far_radius": 6.0,
    "growth": 0.3,
    "order": 1,
    "cells": "quadrilaterals",
}
SHAPES: dict[type, dict[str, Any]] = {
    Block: {"kind": None, "width": 9.0, "height": 4.0, "base": "fixed", "sides": "free"},
    Pad: {"kind": None, "width": 9.0, "height": 4.0, "base": "fixed", "sides": "free"},
    Cylinder: {"kind": None, "radius": 50.0},
}
START: dict[type, dict[str, Any]] = {
    Block: {"width": 8.0, "height": 5.0, "base": "rollers", "sides": "guided"},
    Pad: {"width": 8.0, "height": 5.0, "base": "rollers", "sides": "guided"},
    Cylinder: {"radius": 60.0},
}


# ---------------------------------------------------------------------------------------- every input is in the key
def of_setting(name: str) -> list[BodyMesh]:
    """The upper body cut with one mesh setting or the other."""
    start = MeshSettings(element_size=1 / 8, edge_element_size=1 / 20, far_radius=5.0, growth=0.5)
    scales = Scales(half_width=1.0, inner=0.5, reach=1.0, load=1.0, modulus=1.0, element=0.1, dissipation=0.0, largest_pressure=1.0)
    settings = (start, replace(start, **{name: SETTINGS[name]}))
    return [meshed_pair(load_scene("hertz-paper"), mesh, partial(surface_grading, mesh, scales))[1] for mesh in settings]


def of_shape(kind: type, name: str) -> list[BodyMesh]:
    """Supports among them: rollers had the numbers of a fixed base when these were not in the key."""
    grading = SurfaceGrading(inner=0.0, outer=1.0, size=0.2, edge_size=0.2)
    shapes = [kind(**START[kind] | change) for change in ({}, {name: SHAPES[kind][name]})]
    return [build("lower", shape, Hertz(radius=50.0), grading, MeshSettings(growth=0.5)) for shape in shapes]


def other_part(**parts: Callable[[skfem.Mesh], object]) -> Callable[[], object]:
    return lambda: [body(), with_mesh(**{name: part(body().mesh) for name, part in parts.items()})]


# Two bodies, or two of (body, material, datum).
UNLIKE: dict[str, Callable[[], Any]] = {
    **{name: lambda name=name: [body(), BODY[name]()] for name in BODY},
    **{
        f"grading, {name}": lambda name=name: [body(), replace(body(), grading=replace(body().grading, **{name: GRADING[name]}))]
        for name in GRADING
    },
    **{
        name: lambda name=name: [(body(), STEEL, 7.0), (body(), STEEL.model_copy(update={name: 1.1 * getattr(STEEL, name)}), 7.0)]
        for name in Elastic.model_fields
    },
    "datum": lambda: [(body(), STEEL, 7.0), (body(), STEEL, 7.0 * (1 + 1e-15))],
    "boundary": other_part(_boundaries=lambda mesh: {**mesh.boundaries, "free": longer(mesh.boundaries["free"])}),
    "name of a boundary": other_part(_boundaries=lambda mesh: {**mesh.boundaries, "side": mesh.boundaries["free"]}),
    "elements": other_part(t=lambda mesh: mesh.t[:, ::-1]),
    **{f"setting, {name}": partial(of_setting, name) for name in SETTINGS},
    **{f"{kind.__name__}, {name}": partial(of_shape, kind, name) for kind in SHAPES for name in SHAPES[kind] if name != "kind"},
}


def test_the_tables_of_inputs_are_whole() -> None:
    """A new field of any of them, or a new argument of `condense`, fails here until the key is shown to change with it."""
    assert BODY.keys() == {field.name for field in fields(BodyMesh)}
    assert SETTINGS.keys() == {field.name for field in fields(MeshSettings)}
    assert {kind: set(values) for kind, values in SHAPES.items()} == {kind: set(kind.model_fields) for kind in SHAPES}
    assert list(signature(condense).parameters) == ["body", "material", "datum_length"]


@pytest.mark.parametrize("name", UNLIKE)
def test_another_input_is_another_entry(folder: Path, name: str) -> None:
    asked = [one if isinstance(one, tuple) else (one, STEEL, 7.0) for one in UNLIKE[name]()]
    assert entries(folder, *asked) == 2


@pytest.mark.parametrize("name", ["numpy", "scipy", "scikit-fem"])
def test_another_library_is_another_entry(folder: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    entries(folder, (body(), STEEL, 7.0))
    monkeypatch.setattr(store, "version", lambda one: "0.1" if one == name else version(one))
    assert entries(folder, (body(), STEEL, 7.0)) == 2


def test_a_kind_that_has_no_place_in_the_key_is_refused(folder: Path) -> None:
    with pytest.raises(TypeError, match="no place"):
        store.condensed(replace(body(), quality={"new": object()}), STEEL, 7.0, Counter())


def files_that_count() -> list[Path]:
    """All of the finite-element engine, of the meshes and of the scenes, listed without the code that is tested."""
    return [path for name in ("halfplane_fe", "meshes", "scenes") for path in sorted((ROOT / name).rglob("*.py"))]


def test_any_other_line_of_code_is_another_entry(monkeypatch: pytest.MonkeyPatch) -> None:
    read, edited = Path.read_bytes, Path()
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + (b"# one line more" if path == edited else b""))
    keys = set()
    for edited in [Path(), *files_that_count()]:  # noqa: B007 (the reader looks at it)
        source_digest.cache_clear()
        keys.add(store._key(body(), STEEL, 7.0))
    source_digest.cache_clear()
    assert len(keys) == len(files_that_count()) + 1


# ----------------------------------------------------------------------------------------------- spoilt and mistaken files


def rewritten(file: Path, **changes: object) -> None:
    with np.load(file) as stored:
        arrays = dict(stored)
    np.savez(file, **{**arrays, **{name: change(arrays[name]) for name, change in changes.items()}})  # type: ignore[operator]


def refused_once(folder: Path, why: str, good: CondensedBody) -> None:
    """The file of this body is refused for that reason, condensed again, replaced, and found the next time."""
    work: Counter[str] = Counter()
    np.testing.assert_array_equal(store.condensed(good.body, good.material, 7.0, work).compliance, good.compliance)
    (sentence,) = store.refusals(work)
    assert why in sentence
    assert str(folder) in sentence
    assert work["condensations"] == 1
    np.testing.assert_array_equal(store.condensed(good.body, good.material, 7.0, work).compliance, good.compliance)
    assert (work["condensations"], work["condensations from the store"]) == (1, 1)


def twofold(array: Array) -> Array:
    return np.asarray(1.02 * array)


def exchanged(file: Path) -> None:
    """The file of another body: whole, but under a key that is not its own."""
    store.condensed(body(), STEEL, 8.0, Counter())
    (other,) = set(file.parent.iterdir()) - {file}
    file.write_bytes(other.read_bytes())


SPOILT: dict[str, tuple[Callable[[Path], object], str]] = {
    "empty": (lambda file: file.write_bytes(b""), "can't be read"),
    "no archive": (lambda file: file.write_bytes(b"not an archive"), "can't be read"),
    "half of one": (lambda file: file.write_bytes(file.read_bytes()[:-200]), "can't be read"),
    "another compliance": (lambda file: rewritten(file, compliance=twofold), "its digest is another"),
    "another figure": (lambda file: rewritten(file, figures=twofold), "its digest is another"),
    "of another body": (exchanged, "its digest is another"),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_file_is_refused_and_replaced(folder: Path, how: str) -> None:
    good = store.condensed(body(), STEEL, 7.0, Counter())
    (file,) = folder.iterdir()
    SPOILT[how][0](file)
    refused_once(folder, SPOILT[how][1], good)


def block(base: str) -> BodyMesh:
    shape = Block.model_validate({"width": 8.0, "height": 5.0, "base": base, "sides": "guided"})
    grading = SurfaceGrading(inner=0.0, outer=1.0, size=0.2, edge_size=0.2)
    return build("lower", shape, Hertz(radius=50.0), grading, MeshSettings(growth=0.5))


SOFT = Elastic(young_modulus=210e3 / 1.02, poisson_ratio=0.3)
MISTAKEN: dict[str, tuple[BodyMesh, Callable[..., CondensedBody]]] = {
    "compliance alone": (body(), lambda *one: replace(condense(*one), compliance=1.02 * condense(*one).compliance)),
    "one entry": (body(), lambda *one: replace(condense(*one), compliance=condense(*one).compliance * lopsided(condense(*one)))),
    "material": (body(), lambda body, _, datum: condense(body, SOFT, datum)),
    "nearly incompressible": (
        body(),
        lambda body, _, datum: condense(body, Elastic(young_modulus=210e3, poisson_ratio=0.31), datum),
    ),
    "datum": (body(), lambda body, material, _: condense(body, material, 7.1)),
    "mesh": (body(), lambda _, material, datum: condense(with_mesh(doflocs=moved_much()), material, datum)),
    "supports": (block("rollers"), lambda _, material, datum: condense(block("fixed"), material, datum)),
    "stretch by bulk stress": (
        replace(block("fixed"), supports={"base": "fixed", "sides": "pulled"}),
        lambda *one: replace(condense(*one), by_stress=1.001 * np.asarray(condense(*one).by_stress)),
    ),
    "free base": (block("fixed"), lambda _, material, datum: condense(block("rollers"), material, datum)),
}


def lopsided(one: CondensedBody) -> Array:
    factors = np.ones_like(one.compliance)
    factors[1, 3, 1, 3] = 1.02
    return factors


def moved_much() -> Array:
    places = body().mesh.doflocs.copy()
    places[:, np.argmin(np.abs(places[0] - 0.1) + np.abs(places[1] + 2.0))] *= 1.02
    return places


@pytest.mark.parametrize("how", MISTAKEN)
def test_what_is_not_the_compliance_of_the_mesh_is_refused(folder: Path, how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even where key and digest are in order, as they would be if an input were left out of the key."""
    one, mistaken = MISTAKEN[how]
    good = condense(one, STEEL, 7.0)
    with monkeypatch.context() as wrong:
        wrong.setattr(store, "condense", mistaken)
        store.condensed(one, STEEL, 7.0, Counter())
    refused_once(folder, "than that of the mesh", good)


@pytest.mark.parametrize("kind", ["fifo", "folder", "device", "link to a fifo"])
def test_what_is_no_regular_file_is_not_opened(folder: Path, kind: str) -> None:
    """A FIFO under a key waited for a writer for ever."""
    good = store.condensed(body(), STEEL, 7.0, Counter())
    (file,) = folder.iterdir()
    file.unlink()
    match kind:
        case "fifo":
            os.mkfifo(file)
        case "folder":
            file.mkdir()
        case "device":
            file.symlink_to("/dev/zero")
        case _:
            os.mkfifo(folder / "fifo")
            file.symlink_to(folder / "fifo")
    if kind == "folder":  # which no file replaces: done without, and said
        work: Counter[str] = Counter()
        store.condensed(body(), STEEL, 7.0, work)
        (sentence,) = store.refusals(work)
        assert sentence.endswith("is no regular file; condensed again, and not replaced: remove it")
        assert work["condensations not stored"] == 1
        return
    watched = threading.Thread(target=refused_once, args=(folder, "is no regular file", good), daemon=True)
    watched.start()
    watched.join(60.0)
    assert not watched.is_alive()
    assert file.is_file()
    assert not file.is_symlink()


def test_a_refused_file_is_said_in_the_answer(folder: Path) -> None:
    scene, mesh = load_scene("hertz-normal"), MeshSettings(element_size=1 / 6, edge_element_size=1 / 6, far_radius=5.0, growth=0.5)
    first = halfplane_fe.solve(scene, mesh)
    for file in folder.iterdir():
        rewritten(file, compliance=twofold)
    again = halfplane_fe.solve(scene, mesh)
    np.testing.assert_array_equal(first.pressure, again.pressure)
    found = [note for note in again.record.notes if "refused" in note]
    assert len(found) == 2  # the body and the coarse one
    assert all(note.endswith("condensed again, and replaced") for note in found)
    assert not any("refused" in note for note in halfplane_fe.solve(scene, mesh).record.notes)


# ------------------------------------------------------------------------------------------------- folders of all sorts
def test_a_store_that_cannot_be_had_is_done_without_and_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file in the way; a user without a home."""

    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    work: Counter[str] = Counter()
    monkeypatch.setenv("HALFPLANE_CACHE", str(tmp_path / "file" / "store"))
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations not stored"] == 1
    for name in ("HALFPLANE_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations not stored"] == 2
    monkeypatch.setenv("HALFPLANE_CACHE", "off")
    assert store.cache_folder() is None
    assert store.stored_bytes() == (0, 0)


def test_the_oldest_give_way(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    monkeypatch.setattr(store, "_BOUND_BYTES", 1)
    store.condensed(body(), STEEL, 8.0, work)
    assert store.stored_bytes() == (0, 0)


def test_a_store_that_others_own_is_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of last use can't be noted there: what was read stands all the same."""

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    monkeypatch.setattr("os.utime", refuse)
    store.condensed(body(), STEEL, 7.0, work)
    assert (work["condensations"], work["condensations from the store"], len(list(store.refusals(work)))) == (1, 1, 0)


def test_what_another_process_removes_meanwhile_is_no_fault(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the list of files and the look at each: what was stored counts as stored."""
    real = store.os.scandir

    def scandir(path: Path) -> object:
        (path / "gone.npz").touch()
        entries = real(path)
        found = list(entries)
        (path / "gone.npz").unlink()
        return nullcontext(found)

    monkeypatch.setattr(store.os, "scandir", scandir)
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations not stored"] == 0
    assert store.stored_bytes()[0] == 1
