"""Condensed bodies on disk: found by content, safe to lose, bounded, and never the reason for another answer."""

from __future__ import annotations

import os
import threading
from collections import Counter
from collections.abc import Callable
from dataclasses import fields, replace
from functools import cache
from importlib.metadata import version
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
import skfem
from numpy.typing import NDArray

import halfplane_fe
from halfplane_fe import SolverSettings, store
from halfplane_fe.elasticity import CondensedBody, condense
from meshes import BodyMesh, MeshSettings, SurfaceGrading, half_disc
from scenes import Elastic, load_scene
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
# Two of (body, material, datum).
UNLIKE: dict[str, Callable[[], tuple[BodyMesh, Elastic, float]]] = {
    **{name: lambda name=name: (BODY[name](), STEEL, 7.0) for name in BODY},
    **{f"grading, {name}": lambda name=name: (graded(name), STEEL, 7.0) for name in GRADING},
    **{
        name: lambda name=name: (body(), STEEL.model_copy(update={name: 1.1 * getattr(STEEL, name)}), 7.0)
        for name in Elastic.model_fields
    },
    "datum": lambda: (body(), STEEL, 7.0 * (1 + 1e-15)),
    "boundary": lambda: (with_mesh(_boundaries={**body().mesh.boundaries, "free": longer(body().mesh)}), STEEL, 7.0),
    "name of a boundary": lambda: (with_mesh(_boundaries={**body().mesh.boundaries, "side": longer(body().mesh)}), STEEL, 7.0),
    "elements": lambda: (with_mesh(t=body().mesh.t[:, ::-1]), STEEL, 7.0),
}


def graded(name: str) -> BodyMesh:
    return replace(body(), grading=replace(body().grading, **{name: GRADING[name]}))


def longer(mesh: skfem.Mesh) -> Array:
    """The facets of a boundary, the last one a second time."""
    return np.concatenate([mesh.boundaries["free"], mesh.boundaries["free"][-1:]])


def test_the_tables_of_inputs_are_whole() -> None:
    """A new field of a body, or a new argument of `condense`, fails here until the key is shown to change with it."""
    assert BODY.keys() == {field.name for field in fields(BodyMesh)}
    assert list(signature(condense).parameters) == ["body", "material", "datum_length"]


@pytest.mark.parametrize("name", UNLIKE)
def test_another_input_is_another_entry(folder: Path, name: str) -> None:
    assert entries(folder, (body(), STEEL, 7.0), UNLIKE[name]()) == 2


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


def refused_once(folder: Path, good: CondensedBody) -> None:
    """The file of this body is refused, condensed again, replaced, and found the next time."""
    work: Counter[str] = Counter()
    np.testing.assert_array_equal(store.condensed(good.body, good.material, 7.0, work).compliance, good.compliance)
    (sentence,) = store.refusals(work)
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


SPOILT: dict[str, Callable[[Path], object]] = {
    "empty": lambda file: file.write_bytes(b""),
    "no archive": lambda file: file.write_bytes(b"not an archive"),
    "half of one": lambda file: file.write_bytes(file.read_bytes()[:-200]),
    "another compliance": lambda file: rewritten(file, compliance=twofold),
    "another figure": lambda file: rewritten(file, figures=twofold),
    "of another body": exchanged,
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_file_is_refused_and_replaced(folder: Path, how: str) -> None:
    good = store.condensed(body(), STEEL, 7.0, Counter())
    (file,) = folder.iterdir()
    SPOILT[how](file)
    refused_once(folder, good)


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
        assert sentence.endswith("condensed again, and not replaced: remove it")
        assert work["condensations not stored"] == 1
        return
    watched = threading.Thread(target=refused_once, args=(folder, good), daemon=True)
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


def test_what_another_process_removes_meanwhile_is_no_fault(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between the list of files and the look at each: what was stored counts as stored."""
    real, work = Path.glob, Counter[str]()
    monkeypatch.setattr(Path, "glob", lambda path, pattern: [*[path / "gone.npz"] * (pattern == "*.npz"), *real(path, pattern)])
    store.condensed(body(), STEEL, 7.0, work)
    assert (work["condensations not stored"], store.stored_bytes()[0]) == (0, 1)


def test_a_store_that_others_own_is_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of last use can't be noted there: what was read stands all the same."""

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    monkeypatch.setattr("os.utime", refuse)
    store.condensed(body(), STEEL, 7.0, work)
    assert (work["condensations"], work["condensations from the store"], len(list(store.refusals(work)))) == (1, 1, 0)
