"""Full disks: whichever write fails, one sentence and exit code 2, no half-written file, and what was there before stays."""

from __future__ import annotations

import errno
import os
import re
import resource
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest

import faulty_disk
import halfplane_fe
import reports
from command_line import COARSE, process
from faulty_processes import STUDY, half_files, in_a_child
from meshes import MeshSettings
from reports.folder import MANIFEST, filled
from reports.sweep.store import Store
from scenes import ContactSolution, InputError, load_scene
from test_reports_synthetic import cattaneo_mindlin

# An old run lies in x; each of these writes there, or beside it, every kind of file that the command writes.
JOBS = {
    "run with a PDF": ("run", "cattaneo-mindlin", *COARSE, "--pdf", "--out", "x", "--quiet"),
    "exact": ("exact", "cattaneo-mindlin", "--out", "x", "--quiet"),
    "fe": ("fe", "cattaneo-mindlin", *COARSE, "--out", "x", "--quiet"),
    "fields": ("fields", "blocks", *COARSE, "--at", "2.0", "--out", "x", "--quiet"),
    "film": ("fields", "blocks", *COARSE, "--frames", "2", "--animate", "--no-pictures", "--out", "x", "--quiet"),
    "score": ("score", "x/reference.nc", "--scene", "cattaneo-mindlin", "--out", "x", "--quiet"),
    "export": ("export", "blocks", "--to", "calculix", "--out", "x", "--quiet"),
    "diff": ("diff", "x", "new/baseline.json", "--accept", "--quiet"),
    "init": ("init", "scene.toml", "--from", "flight", "--quiet"),
    "paper": ("paper", "--out", "x", "--quiet"),
    "map": ("map", "all", "--out", "maps", "--pages", "--quiet"),
}
_MOST = 2000  # calls that a command writes with


@pytest.fixture(scope="module")
def old(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a report in it, of another comparison."""
    folder = tmp_path_factory.mktemp("old")
    reports.write(reports.compare(cattaneo_mindlin(), cattaneo_mindlin()), folder / "x")
    return folder


def content(folder: Path) -> dict[str, bytes | None]:
    """Everything in a folder: bytes of files, None for folders."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


def kept(folder: Path, told: str) -> dict[str, bytes | None]:
    """What lies in a folder but for the whole results that `told` says are kept beside it."""
    place = told.rsplit("kept in ", 1)[1].strip().rstrip(".") if "kept in " in told else ""
    there = content(folder)
    assert not place or content(Path(place))
    above = Path(place).parent.name
    return {name: found for name, found in there.items() if not place or name.split("/")[0] != above}


def check(code: int, errors: str, disk: Path, before: dict[str, bytes | None]) -> None:
    """What must hold after a write that failed."""
    assert code == 2, (code, errors)
    (line,) = errors.splitlines()
    assert line.startswith("halfplane: "), errors
    assert kept(disk, line) == before, errors
    assert half_files(disk) == []


@pytest.mark.parametrize(("job", "limit"), [("exact", 3_072_000), ("diff", 1000), ("init", 1000)], ids=str)
def test_a_file_that_may_not_grow_is_a_sentence_and_leaves_all_as_it_was(job: str, limit: int, old: Path, tmp_path: Path) -> None:
    """HDF5 ended the process by a segmentation fault when it closed a file that found no room."""
    disk = tmp_path / "disk"
    shutil.copytree(old, disk)
    before = content(disk)
    done = process(disk, *JOBS[job], file_size=limit)
    check(done.returncode, done.stderr, disk, before)
    assert "File too large" in done.stderr


@pytest.fixture(scope="module")
def watched() -> None:
    """The calls of other processes can be answered here."""
    if not faulty_disk.possible():
        pytest.skip("this machine lets nobody answer the calls of other processes")


def each_write_fails(
    words: Sequence[str], disk: Path, prepare: Callable[[Path], object], for_ever: bool
) -> Iterator[tuple[faulty_disk.Starved, str, dict[str, bytes | None]]]:
    """For each call of a command that writes: what became of the command, the call that failed, what lay there before."""
    for fails in range(1, _MOST):
        shutil.rmtree(disk, ignore_errors=True)
        prepare(disk)
        before = content(disk)
        done = faulty_disk.starved(words, disk, fails, for_ever=for_ever)
        if len(done.calls) < fails:
            assert fails > 2
            assert done.code in (0, 1), done.errors
            assert content(disk) != before
            return
        yield done, done.calls[fails - 1], before
    pytest.fail("the command never ends")


@pytest.mark.slow
@pytest.mark.usefixtures("watched")
@pytest.mark.parametrize(
    ("job", "for_ever"),
    [*((job, False) for job in JOBS), *((job, True) for job in ("exact", "film", "diff", "init"))],
    ids=lambda value: value if isinstance(value, str) else ("full" if value else "once"),
)
def test_whichever_write_fails_it_is_a_sentence_and_leaves_all_as_it_was(
    job: str, for_ever: bool, old: Path, tmp_path: Path
) -> None:
    def prepare(disk: Path) -> None:
        shutil.copytree(old, disk)
        if job == "map":
            shutil.copytree(Path(reports.__file__).parent / "published" / "maps", disk / "maps")

    disk = tmp_path / "disk"
    for done, call, before in each_write_fails(JOBS[job], disk, prepare, for_ever):
        if re.fullmatch(r"rename \.halfplane-[^/]*", call) and done.code != 2:
            continue  # the hidden folder could not be moved out of x, and served its purpose there
        try:
            check(done.code, done.errors, disk, before)
        except AssertionError as fault:
            raise AssertionError(call) from fault


@pytest.mark.slow
@pytest.mark.usefixtures("watched")
@pytest.mark.parametrize("for_ever", [True, False], ids=["full", "once"])
def test_whichever_write_of_a_sweep_fails_its_store_holds_whole_results_and_it_resumes(for_ever: bool, tmp_path: Path) -> None:
    def prepare(disk: Path) -> None:
        disk.mkdir()
        (disk / "study.toml").write_text(STUDY.replace("count = 40", "count = 3"), encoding="utf-8")

    disk, words = tmp_path / "disk", ("sweep", "study.toml", "--workers", "1", "--out", "x", "--quiet")
    for done, call, _ in each_write_fails(words, disk, prepare, for_ever):
        assert done.code == 2, (call, done)
        (line,) = done.errors.splitlines()
        assert "there is no room left on the disk" in line or "No space left on device" in line
        store = Store(disk / "x")
        assert (half_files(disk), store.damaged()) == ([], [])
        assert not [name for name in content(disk) if ".halfplane-" in name or name.startswith("x/claims/")]
        if len(store.addresses()) == 2:  # one is lost
            assert faulty_disk.starved((*words, "--resume"), disk, 0).code == 0
            assert len(store.addresses()) == 3


@pytest.mark.slow
def test_a_small_disk_is_a_sentence_keeps_what_was_there_and_stores_no_body(
    small_disk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match="can't be written to"):
        reports.write(reports.compare(cattaneo_mindlin(), cattaneo_mindlin()), small_disk / "out")
    assert content(small_disk) == {}
    with filled(small_disk / "out") as folder:
        (folder / "report.html").write_text("<html></html>")
    before = content(small_disk)
    with pytest.raises(InputError), filled(small_disk / "out") as folder:
        (folder / "report.html").write_bytes(bytes(10**6))
    assert content(small_disk) == before
    monkeypatch.setenv("HALFPLANE_CACHE", str(small_disk / "cache"))
    answer = halfplane_fe.solve(load_scene("cattaneo-mindlin"), MeshSettings(element_size=0.1, edge_element_size=0.008, order=1))
    assert answer.work.counts["condensations not stored"] > 0
    assert half_files(small_disk) == []
    assert not list(small_disk.rglob("*.part"))


@pytest.mark.parametrize("name", ["replace", "rename"])
def test_whichever_move_fails_the_folder_is_as_before_and_what_is_new_is_kept(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, real, moves = tmp_path / "out", getattr(os, name), 0

    def fill(*names: str) -> None:
        with filled(out) as there:
            for entry in names:
                (there / entry).parent.mkdir(exist_ok=True)
                (there / entry).write_text(f"{names}")

    def move(source: Path, target: Path) -> None:
        nonlocal moves
        moves += Path(source).is_file()  # not the hidden folder, which may stay where it is
        if moves == fails:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(source, target)

    fill("a.json", "old/b.json", "report.html")
    before, fails = content(out), 0
    monkeypatch.setattr(os, name, move)
    while content(out) == before:
        moves, fails = 0, fails + 1
        told = ""
        try:
            fill("a.json", "new/c.json", "report.html")
        except InputError as fault:
            told = str(fault)
        if moves < fails:
            break
        assert "No space left on device" in told
        place = Path(told.rsplit("kept in ", 1)[1])
        assert set(content(place)) == {"a.json", "new", "new/c.json", "report.html"}
        assert {path.name for path in tmp_path.iterdir()} == {"out", place.parent.name}
        shutil.rmtree(place.parent)
    assert fails > 3
    assert set(content(out)) == {"a.json", "new", "new/c.json", "report.html", MANIFEST}


def test_a_folder_that_is_read_only_is_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Root may write anywhere, so the refusal of the system is played."""

    def refuse(**_: object) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", refuse)
    with (
        pytest.raises(InputError, match="the folder can't be written to: Permission denied; name another"),
        filled(tmp_path / "out"),
    ):
        pass


def test_a_solution_that_finds_no_room_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "answer.nc"
    cattaneo_mindlin().save(path)
    before = content(tmp_path)

    def save() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000))
        with pytest.raises(OSError, match="File too large"):
            cattaneo_mindlin().save(path)

    assert in_a_child(save) == 0  # HDF5 would take the tests with it
    assert content(tmp_path) == before
    assert ContactSolution.load(path).scene.name == "cattaneo-mindlin"
