"""Condensed bodies on disk: found by content, safe to lose, bounded, and never the reason for another answer."""

from __future__ import annotations

import ast
from collections import Counter
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import halfplane_fe
from halfplane_fe import store
from halfplane_fe.elasticity import condense
from meshes import BodyMesh, MeshSettings, SurfaceGrading, half_disc
from scenes import Elastic, load_scene

STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)
MESH = MeshSettings(element_size=1 / 10, edge_element_size=1 / 20)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("HALFPLANE_CACHE", str(tmp_path / "store"))
    return tmp_path / "store"


def body(size: float = 0.2) -> BodyMesh:
    return half_disc("lower", SurfaceGrading(inner=0.0, outer=1.0, size=size, edge_size=size, radius=5.0))


def test_the_second_run_condenses_nothing_and_answers_the_same_bits(folder: Path) -> None:
    first, second = (halfplane_fe.solve(load_scene("cattaneo-mindlin"), MESH) for _ in range(2))
    assert first.work.counts["condensations"] == 1
    assert second.work.counts["condensations"] == second.work.counts["sparse factorisations"] == 0
    assert second.work.skipped["condensations, stored"][0] == 1
    np.testing.assert_array_equal(first.shear, second.shear)
    assert len(list(folder.iterdir())) == 2  # the body and the coarse one


@pytest.mark.parametrize(
    ("material", "datum", "size"),
    [(Elastic(young_modulus=210e3, poisson_ratio=0.31), 7.0, 0.2), (STEEL, 8.0, 0.2), (STEEL, 7.0, 0.1)],
)
def test_another_material_datum_or_mesh_is_another_entry(folder: Path, material: Elastic, datum: float, size: float) -> None:
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    store.condensed(body(size), material, datum, work)
    assert work["condensations"] == 2
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("module", store.SOURCES, ids=lambda module: module.__name__)
def test_other_code_is_another_entry(module: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = store._key(body(), STEEL, 7.0)
    other = tmp_path / "other.py"
    other.write_bytes(Path(str(module.__file__)).read_bytes() + b"# one line more\n")
    monkeypatch.setattr(module, "__file__", str(other))
    assert store._key(body(), STEEL, 7.0) != before


def test_the_code_that_condenses_is_all_in_the_key() -> None:
    """Whatever of the engine these files import is one of them, so that no part of the condensation is left out."""
    imported = {
        node.module
        for source in store.SOURCES
        for node in ast.walk(ast.parse(Path(str(source.__file__)).read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("halfplane_fe")
    }
    assert imported | {condense.__module__} == {source.__name__ for source in store.SOURCES}


@pytest.mark.parametrize("rubbish", [b"", b"not an archive", b"PK\x03\x04 half of one"])
def test_a_spoilt_file_is_counted_and_made_anew(folder: Path, rubbish: bytes) -> None:
    work: Counter[str] = Counter()
    good = store.condensed(body(), STEEL, 7.0, work)
    (file,) = folder.iterdir()
    file.write_bytes(rubbish)
    again = store.condensed(body(), STEEL, 7.0, work)
    assert work["stored condensations unreadable"] == 1
    np.testing.assert_array_equal(again.compliance, good.compliance)
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations from the store"] == 1


def test_a_folder_that_cannot_be_made_is_done_without_and_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    monkeypatch.setenv("HALFPLANE_CACHE", str(tmp_path / "file" / "store"))
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations not stored"] == 1


def test_the_oldest_give_way(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    monkeypatch.setattr(store, "_BOUND_BYTES", 1)
    store.condensed(body(), STEEL, 8.0, work)
    assert store.stored_bytes() == (0, 0)


def test_off_keeps_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HALFPLANE_CACHE", "off")
    assert store.cache_folder() is None
    assert store.stored_bytes() == (0, 0)


def test_a_store_that_others_own_is_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The time of last use can't be noted there: what was read stands all the same."""

    def refuse(*_: object) -> None:
        raise PermissionError(1, "Operation not permitted")

    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    monkeypatch.setattr("os.utime", refuse)
    store.condensed(body(), STEEL, 7.0, work)
    assert (work["condensations"], work["condensations from the store"], work["stored condensations unreadable"]) == (1, 1, 0)


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


def test_a_user_without_a_home_is_done_without_a_store_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in ("HALFPLANE_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    work: Counter[str] = Counter()
    store.condensed(body(), STEEL, 7.0, work)
    assert work["condensations not stored"] == 1
