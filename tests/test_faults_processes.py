"""Kills, Ctrl-C, full and read-only disks, two processes at once: every file whole or absent, the same numbers in the end."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from ast import literal_eval
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import halfplane_fe
import reports
import semi_analytic
from faulty_processes import JOBS, finished, half_files, in_a_child, numbers, started, survive, undisturbed
from halfplane_fe import store
from meshes import MeshSettings
from reports import staging
from reports.comparison import Comparison
from reports.folder import MANIFEST, claim, filled
from reports.staging import replace_text
from reports.sweep.store import Store
from scenes import ContactSolution, InputError, Interrupted, load_scene
from test_cli_commands import COARSE, environment, everything
from test_reports_synthetic import cattaneo_mindlin

MESH = MeshSettings(element_size=0.25, edge_element_size=0.25, order=1)


@pytest.mark.slow
@pytest.mark.parametrize("job", JOBS)
def test_killed_sixty_seven_times_a_job_leaves_whole_files_and_ends_with_the_same_bits(job: str, tmp_path: Path) -> None:
    truth, seconds = undisturbed(tmp_path / "truth", job)
    assert len(truth) > 2
    (tmp_path / "killed").mkdir()
    assert survive(tmp_path / "killed", job, 67, 3, seconds, truth) == 67


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return reports.compare(cattaneo_mindlin(), cattaneo_mindlin())


def writing(comparison: Comparison, folder: Path, done: int) -> None:
    """What a process does that is killed while it writes: `done` of the moves, then the end."""
    moves = 0
    real = os.replace

    def replace(source: Path, target: Path) -> None:
        nonlocal moves
        moves += Path(target).is_relative_to(folder / "out")
        if moves > done:
            os.kill(os.getpid(), signal.SIGKILL)
        real(source, target)

    os.replace = replace  # type: ignore[assignment]
    reports.write(comparison, folder / "out")


@pytest.mark.parametrize("done", [0, 1, 3, 7, 11, 15])
def test_killed_between_two_moves_every_file_is_whole_or_absent(done: int, comparison: Comparison, tmp_path: Path) -> None:
    """SIGKILL at the one place where it can hurt: while finished files go to their names. The page and the manifest come last."""
    assert in_a_child(lambda: writing(comparison, tmp_path, done)) == -signal.SIGKILL
    assert half_files(tmp_path) == []
    assert not (tmp_path / "out" / "report.html").exists()
    assert len([name for name in everything(tmp_path / "out") if "." in name]) == done if done else True
    assert [name for name in os.listdir(tmp_path) if name.startswith(".")] != []
    reports.write(comparison, tmp_path / "out")
    assert os.listdir(tmp_path) == ["out"]
    reports.write(comparison, tmp_path / "undisturbed")
    assert everything(tmp_path / "out") == everything(tmp_path / "undisturbed")
    manifest = json.loads((tmp_path / "out" / MANIFEST).read_text(encoding="utf-8"))
    assert set(manifest["files"]) == {name for name in everything(tmp_path / "out") if (tmp_path / "out" / name).is_file()}


@pytest.mark.parametrize("done", [1, 3])
def test_killed_between_two_moves_no_page_stands_beside_other_figures(done: int, comparison: Comparison, tmp_path: Path) -> None:
    reports.write(comparison, tmp_path / "out")
    assert in_a_child(lambda: writing(comparison, tmp_path, done)) == -signal.SIGKILL
    assert not (tmp_path / "out" / "report.html").exists()
    assert half_files(tmp_path) == []


def test_half_a_file_is_seen(tmp_path: Path) -> None:
    """The tester tested."""
    (tmp_path / "out").mkdir()
    for name in ("a.json", "b.html", "c.csv", "d.nc", "e.npz"):
        (tmp_path / "out" / name).write_text('{"half": ')
    assert len(half_files(tmp_path)) == 5


def interrupted(folder: Path, *words: str, which: signal.Signals = signal.SIGINT) -> tuple[int, str]:
    """Exit code and stderr of a command that gets Ctrl-C, or another signal, once it tells of its steps."""
    command = [sys.executable, "-m", "reports", *words]
    with subprocess.Popen(
        command, cwd=folder, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        told = ""
        for line in process.stderr:
            told += line
            if re.search(r"[1-9]\d* steps", line):  # on a busy machine the first line comes before the first step is done
                break
        process.send_signal(which)
        _, rest = process.communicate(timeout=120)
    return process.returncode, told + rest


@pytest.mark.parametrize("command", ["fe", pytest.param("run", marks=pytest.mark.slow)])
def test_an_interrupt_is_130_and_what_was_solved_is_kept_and_said(command: str, tmp_path: Path) -> None:
    code, told = interrupted(tmp_path, command, "hertz-paper", *COARSE[:-1], "4000", "--out", "out")
    assert code == 130, told
    assert "Traceback" not in told
    assert "interrupted at time" in told
    assert "what was solved is kept in out/partial.nc" in told
    kept = ContactSolution.load(tmp_path / "out" / "partial.nc")
    assert not kept.record.converged
    assert kept.record.termination == "interrupted"
    assert len(kept.time) > 1
    assert np.isfinite(kept.pressure).all()
    assert half_files(tmp_path) == []


def test_an_interrupt_between_two_lists_leaves_them_of_one_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps, their checks and states are three lists: Ctrl-C may fall between two of them."""
    real, calls = halfplane_fe.run.certificates, 0

    def certificates(*given: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 60:
            raise KeyboardInterrupt
        return real(*given)

    scene = load_scene("cattaneo-mindlin")
    whole = halfplane_fe.solve(scene, MESH)
    monkeypatch.setattr(halfplane_fe.run, "certificates", certificates)
    with pytest.raises(Interrupted, match=r"after \d+ steps") as stop:
        halfplane_fe.solve(scene, MESH, scales=whole.scales)
    kept = stop.value.partial
    assert kept is not None
    assert len(kept.time) == 60
    np.testing.assert_array_equal(kept.shear, whole.shear[:60])


@pytest.mark.parametrize("engine", ["fe", "theory"])
def test_numpy_searches_no_member_of_an_enumeration(engine: str) -> None:
    """numpy drops whatever is raised in that search, a Ctrl-C too: five of sixty were lost when engines compared with members."""
    scene, searched = load_scene("cattaneo-mindlin"), []

    def profile(frame: FrameType, event: str, _argument: object) -> None:
        if event == "call" and frame.f_code.co_name == "__getattr__" and frame.f_code.co_filename.endswith("enum.py"):
            searched.append(frame.f_back)

    sys.setprofile(profile)
    try:
        halfplane_fe.solve(scene, MESH) if engine == "fe" else semi_analytic.solve(scene)
    finally:
        sys.setprofile(None)
    assert not [f"{place.f_code.co_filename}:{place.f_lineno}" for place in searched if place is not None]


@pytest.mark.slow
def test_a_full_disk_is_a_sentence_and_leaves_nothing(comparison: Comparison, small_disk: Path) -> None:
    with pytest.raises(InputError, match="can't be written to"):
        reports.write(comparison, small_disk / "out")
    assert everything(small_disk) == set()


@pytest.mark.slow
def test_a_full_disk_keeps_what_an_earlier_run_left(small_disk: Path) -> None:
    with filled(small_disk / "out") as folder:
        (folder / "report.html").write_text("<html></html>")
    before = everything(small_disk)
    with pytest.raises(InputError), filled(small_disk / "out") as folder:
        (folder / "report.html").write_bytes(bytes(10**6))
    assert everything(small_disk) == before
    assert (small_disk / "out" / "report.html").read_text() == "<html></html>"


@pytest.mark.slow
def test_a_full_disk_under_the_store_of_bodies_is_done_without(small_disk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HALFPLANE_CACHE", str(small_disk / "cache"))
    answer = halfplane_fe.solve(load_scene("cattaneo-mindlin"), MeshSettings(element_size=0.1, edge_element_size=0.008, order=1))
    assert answer.work.counts["condensations not stored"] > 0
    assert half_files(small_disk) == []
    assert not list(small_disk.rglob("*.part"))


def test_a_folder_that_is_read_only_is_a_sentence(comparison: Comparison, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Root may write anywhere, so the refusal of the system is played."""

    def refuse(**_: object) -> str:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.mkdtemp", refuse)
    with pytest.raises(InputError, match="the folder can't be written to: Permission denied; name another"):
        reports.write(comparison, tmp_path / "out")


def test_many_at_once_on_one_folder_leave_one_whole_report(tmp_path: Path) -> None:
    """Whoever moves last leaves its files and no others, and the manifest lists what is there."""
    runs = [("a.json", "b.json", "report.html"), ("a.json", "c.json", "tables/d.csv", "report.html")]

    def fill(k: int) -> None:
        with filled(tmp_path / "out") as folder:
            (folder / "tables").mkdir()
            for name in runs[k % 2]:
                (folder / name).write_text(f'"{k % 2}"\n')
                time.sleep(0.005)

    for _ in range(20):
        with ThreadPoolExecutor(8) as crowd:
            list(crowd.map(fill, range(8)))
        there = {path.relative_to(tmp_path / "out").as_posix() for path in (tmp_path / "out").rglob("*") if path.is_file()}
        last = int((tmp_path / "out" / "report.html").read_text().strip('"\n'))
        assert there == {*runs[last], MANIFEST}
        assert {(tmp_path / "out" / name).read_text() for name in runs[last]} == {f'"{last}"\n'}
        assert set(json.loads((tmp_path / "out" / MANIFEST).read_text())["files"]) == there
    assert everything(tmp_path) - {"out"} == {f"out/{name}" for name in everything(tmp_path / "out")}


def test_another_first_run_at_any_moment_is_no_stranger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One whole run comes between any two lines of another, or waits for it: three of 163 took its page for somebody else's."""
    real, waits = time.sleep, threading.Event()
    lines, moment, others = 0, 0, list[Future[None]]()

    def fill(*names: str) -> None:
        with filled(tmp_path / str(moment) / "out") as folder:
            for name in names:
                (folder / name).write_text(f"{names}")

    def sleep(seconds: float) -> None:
        waits.set()  # the one of us has locked what the other needs
        real(seconds)

    def watch(frame: FrameType, event: str, _argument: object) -> Callable[..., Any] | None:
        nonlocal lines
        if not frame.f_code.co_filename.endswith(("folder.py", "staging.py")):
            return None
        lines += event == "line"
        if lines == moment and not others:
            others.append(crowd.submit(fill, "a.json", "b.json", "report.html"))
            others[0].add_done_callback(lambda _: waits.set())
            assert waits.wait(60)
        return watch

    monkeypatch.setattr(time, "sleep", sleep)
    with ThreadPoolExecutor(1) as crowd:
        while lines >= moment:
            moment, lines = moment + 1, 0
            (tmp_path / str(moment)).mkdir()
            others.clear()
            waits.clear()
            sys.settrace(watch)
            try:
                fill("a.json", "c.json", "report.html")
            finally:
                sys.settrace(None)
            for other in others:
                other.result(60)
            place = tmp_path / str(moment)
            (names,) = {path.read_text() for path in (place / "out").iterdir() if path.name != MANIFEST}
            assert {"out", "out/manifest.json", *(f"out/{name}" for name in literal_eval(names))} == everything(place)
    assert moment > 100


def dying(folder: Path) -> None:
    with filled(folder / "dead") as results:
        (results / "a.json").write_text("{}")
        os.kill(os.getpid(), signal.SIGKILL)


def test_a_folder_of_a_run_that_lives_stays_and_one_of_a_dead_run_goes(tmp_path: Path) -> None:
    assert in_a_child(lambda: dying(tmp_path)) == -signal.SIGKILL
    (dead,) = os.listdir(tmp_path)
    with filled(tmp_path / "alive") as folder:
        assert dead not in os.listdir(tmp_path)
        (folder / "a.json").write_text("{}")
        with filled(tmp_path / "other") as other:
            (other / "b.json").write_text("{}")
    assert everything(tmp_path) == {
        "alive",
        "other",
        *(f"{n}/{MANIFEST}" for n in ("alive", "other")),
        "alive/a.json",
        "other/b.json",
    }


@pytest.mark.parametrize("locks", ["of one machine", "none"])
def test_a_folder_that_no_lock_says_is_dead_goes_after_a_day(locks: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run on another machine may hold a lock that this one does not see."""
    with monkeypatch.context() as elsewhere:
        if locks == "of one machine":
            elsewhere.setattr(staging, "_PREFIX", ".halfplane-0123ab-")
        assert in_a_child(lambda: dying(tmp_path)) == -signal.SIGKILL
    (name,) = os.listdir(tmp_path)
    if locks == "none":

        def flock(*_: object) -> None:
            raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

        monkeypatch.setattr(fcntl, "flock", flock)
    claim(tmp_path / "out")
    assert os.listdir(tmp_path) == [name]
    for path in (tmp_path / name, *(tmp_path / name).rglob("*")):
        os.utime(path, (time.time() - 90_000, time.time() - 90_000))
    claim(tmp_path / "out")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("writer", ["baseline", "sweep"])
def test_a_file_of_a_killed_process_goes_too(writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path / "store")
    store.prepare()

    def write() -> None:
        if writer == "baseline":
            replace_text(tmp_path / "baseline.json", "{}")
        else:
            store.prepare()
            store.write({"address": "a"})

    with monkeypatch.context() as killing:
        killing.setattr(os, "replace", lambda *_: os.kill(os.getpid(), signal.SIGKILL))
        assert in_a_child(write) == -signal.SIGKILL
    assert [path for path in tmp_path.rglob(".*") if path.is_file()] != []
    write()
    assert [path for path in tmp_path.rglob(".*") if path.is_file()] == []


@pytest.mark.slow
def test_two_processes_on_one_folder_and_one_store(tmp_path: Path) -> None:
    truth, _ = undisturbed(tmp_path / "truth", "run")
    home = tmp_path / "both"
    home.mkdir()
    both = [started(home, "run") for _ in range(2)]
    for process in both:
        _, errors = process.communicate(timeout=300)
        assert process.returncode in (0, 1, 2), errors
        assert "Traceback" not in errors
    assert half_files(home) == []
    assert finished(home, "run") in (0, 1)
    assert numbers(home / "out") == truth


def test_the_same_scene_twice_is_the_same_files(comparison: Comparison, tmp_path: Path) -> None:
    """Timestamps and wall times apart, the bytes of every table and the numbers of every answer."""
    for name in ("first", "second"):
        folder = tmp_path / name
        folder.mkdir()
        reports.write(comparison, folder / "out")
    first, second = (numbers(tmp_path / name / "out") for name in ("first", "second"))
    assert first == second
    assert len(first) > 10
    pages = [(tmp_path / name / "out" / "report.html").read_text(encoding="utf-8") for name in ("first", "second")]
    assert len(pages[0]) == len(pages[1])


def test_the_same_scene_solved_twice_is_the_same_bits(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """With an empty store, then with a full one."""
    monkeypatch.setattr(store, "cache_folder", lambda: tmp_path)
    first, second = (halfplane_fe.solve(load_scene("blocks"), MESH) for _ in range(2))
    for name in ("pressure", "shear", "slip", "contact_edges", "stick_edges", "dissipation_density"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_one_or_two_threads_of_blas_agree_to_rounding() -> None:
    """Whatever the user's machine allows: the finite elements hold BLAS to one thread themselves, theory does without it.

    With that hold undone, two threads moved nodal shear by 4.6e-12 of the largest pressure.
    """
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads, "blas"):
            answer = halfplane_fe.solve(load_scene("blocks"), MeshSettings(element_size=0.1, edge_element_size=0.05))
            found.append((answer, semi_analytic.solve(answer.scene, x=answer.x, time=answer.time)))
    for one, two in zip(*found, strict=True):
        scale = float(np.max(one.pressure))
        for name in ("pressure", "shear"):
            assert np.max(np.abs(getattr(one, name) - getattr(two, name))) <= 1e-12 * scale
        assert abs(two.dissipation / one.dissipation - 1) <= 1e-12
