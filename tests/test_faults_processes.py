"""Kills, signals, lost streams, full disks, shared folders: files whole or absent, one sentence,
the same numbers in the end.
"""

from __future__ import annotations

import errno
import fcntl
import itertools
import json
import os
import re
import shutil
import signal
import sys
import threading
import time
from ast import literal_eval
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import halfplane_fe
import reports
import semi_analytic
from command_line import COARSE, everything, forked, raising, sentence
from faulty import (
    JOBS,
    half_files,
    numbers,
    survive,
    undisturbed,
)
from halfplane_fe import FiniteElementSolution
from halfplane_fe.contact import ContactProblem
from meshes import MeshSettings
from reports import folder as folders
from reports.folder import MANIFEST, FilledBefore, replace_text, results_folder, usable_folder
from reports.studies.sweep.store import Store
from scenes import ContactSolution, InputError, Interrupted, load_scene
from test_reports_synthetic import cattaneo_mindlin

MESH = MeshSettings(element_size=0.25, edge_element_size=0.25, order=1)


@pytest.fixture(scope="module")
def old(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a report in it, of another comparison."""
    folder = tmp_path_factory.mktemp("old")
    solution = cattaneo_mindlin(steps_per_leg=10, points=41)
    reports.write(reports.compare(solution, solution), folder / "x")
    return folder


def fill(
    out: Path,
    *names: str,
    meanwhile: Callable[[], object] = lambda: None,
    fresh: tuple[str, ...] = ("",),
) -> None:
    """Files that hold all their names, written as a report is."""
    with results_folder(out, stale_prefixes=fresh) as folder:
        for name in names:
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_text(f"{names}")
        meanwhile()


def no_room(reason: int = errno.ENOSPC) -> OSError:
    return OSError(reason, os.strerror(reason))


def content(folder: Path) -> dict[str, bytes | None]:
    """Everything in a folder: bytes of files, None for folders."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else None
        for path in folder.rglob("*")
    }


def listed(out: Path) -> set[str]:
    """The files of a folder, which must be those of its manifest."""
    files = {name for name in everything(out) if (out / name).is_file()}
    assert set(json.loads((out / MANIFEST).read_text(encoding="utf-8"))["files"]) == files
    return files


# -------------------------------------------------------------------------------------------- kills
@pytest.mark.slow
@pytest.mark.parametrize("job", JOBS)
def test_killed_sixty_seven_times_a_job_leaves_whole_files_and_ends_with_the_same_bits(
    job: str, tmp_path: Path
) -> None:
    truth, seconds = undisturbed(tmp_path / "truth", job)
    assert len(truth) > 2
    (tmp_path / "killed").mkdir()
    assert survive(tmp_path / "killed", job, 67, 3, seconds, truth) == 67


def again(report: Path, out: Path) -> None:
    """A report written as it is written: its files, by the door that all writers take."""
    with results_folder(out) as folder:
        shutil.copytree(report, folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns(MANIFEST))


def dying_after(moves: int, out: Path) -> None:
    """From now on this process is killed when it moves another file there or away; hidden folders
    do not count.
    """
    count = itertools.count()

    def dying(real: Callable[..., None], *paths: Path) -> None:
        if (
            any(
                path.is_relative_to(out) and ".halfplane" not in path.name
                for path in map(Path, paths)
            )
            and next(count) == moves
        ):
            os.kill(os.getpid(), signal.SIGKILL)
        real(*paths)

    for name in ("replace", "rename"):
        setattr(os, name, partial(dying, getattr(os, name)))


@pytest.mark.parametrize(
    ("moves", "before"),
    [(0, False), (1, False), (-1, False), (2, True), (25, True)],
)
def test_killed_between_two_moves_every_file_is_whole_or_absent(
    moves: int, before: bool, old: Path, tmp_path: Path
) -> None:
    """SIGKILL while finished files go to their names, into a new folder or over an earlier report,
    whose page goes first.

    The manifest comes first and last; the page comes after all other files: -1 is the moment before
    it does.
    """
    out = tmp_path / "out"
    files = listed(old / "x")
    moves = len(files) - 1 if moves == -1 else moves
    if before:
        again(old / "x", out)
    assert (
        forked(tmp_path, act=lambda: (dying_after(moves, out), again(old / "x", out))).returncode
        == -signal.SIGKILL
    )
    assert half_files(tmp_path) == []
    assert not (out / "report.html").exists()
    assert before or len([name for name in everything(out) if "." in name]) == moves
    assert [name for name in os.listdir(tmp_path) if name.startswith(".")] != []
    again(old / "x", out)
    assert os.listdir(tmp_path) == ["out"]
    assert listed(out) == files


def dying(folder: Path) -> None:
    fill(folder / "dead", "a.json", meanwhile=lambda: os.kill(os.getpid(), signal.SIGKILL))


@pytest.mark.parametrize("where", ["here", "on another machine"])
def test_what_a_dead_run_left_goes_and_the_folder_of_one_that_lives_stays(
    where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a day where nobody knows whether it is dead."""
    with monkeypatch.context() as elsewhere:
        if where != "here":
            elsewhere.setattr("reports.folder._MACHINE_CODE", "0123ab")
        assert forked(tmp_path, act=lambda: dying(tmp_path)).returncode == -signal.SIGKILL
    (dead,) = os.listdir(tmp_path)
    with results_folder(tmp_path / "alive") as folder:
        assert (dead in os.listdir(tmp_path)) is (where != "here")
        for path in (tmp_path / dead, *(tmp_path / dead).rglob("*")) if where != "here" else ():
            os.utime(path, (time.time() - 90_000, time.time() - 90_000))
        (folder / "a.json").write_text("{}")
        fill(tmp_path / "other", "b.json")
    assert listed(tmp_path / "alive") | listed(tmp_path / "other") == {"a.json", "b.json", MANIFEST}
    assert set(os.listdir(tmp_path)) == {"alive", "other"}


@pytest.mark.parametrize("writer", ["baseline", "sweep"])
def test_a_file_of_a_killed_process_goes_too(
    writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
        assert forked(tmp_path, act=write).returncode == -signal.SIGKILL
    assert [path for path in tmp_path.rglob(".*") if path.is_file()] != []
    write()
    assert [path for path in tmp_path.rglob(".*") if path.is_file()] == []


# ------------------------------------------------------------------------------------------ signals
@pytest.fixture(scope="module")
def full_solution() -> FiniteElementSolution:
    return halfplane_fe.solve(load_scene("cattaneo-mindlin"), MESH)


SIGNALS = [
    ("run", signal.SIGINT, 130),
    ("fe", signal.SIGTERM, 143),
    ("fe", signal.SIGHUP, 129),
]


@pytest.mark.parametrize(("command", "sent", "code"), SIGNALS)
def test_a_signal_to_end_keeps_what_was_solved_and_says_so(
    command: str,
    sent: signal.Signals,
    code: int,
    full_solution: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It comes amid increment number 60, on any machine; the size of the contact is known, so that
    none of a coarse run counts.
    """
    solve = partial(halfplane_fe.solve, scales=full_solution.scales)
    monkeypatch.setattr(halfplane_fe, "solve", solve)
    real = ContactProblem.equilibrium
    calls = itertools.count(1)

    def equilibrium(*arguments: object) -> object:
        if next(calls) == 60:
            os.kill(os.getpid(), sent)
        return real(*arguments)

    monkeypatch.setattr(ContactProblem, "equilibrium", equilibrium)
    outcome = forked(tmp_path, command, "cattaneo-mindlin", *COARSE[:-1], "96", "--out", "out")
    assert outcome.returncode == code, outcome
    assert "Traceback" not in outcome.stderr
    assert "interrupted at time" in outcome.stderr
    assert "what was solved is kept in out/partial.nc" in outcome.stderr
    saved = ContactSolution.load(tmp_path / "out" / "partial.nc")
    assert not saved.record.converged
    assert saved.record.termination == "interrupted"
    assert len(saved.time) > 1
    assert np.isfinite(saved.pressure).all()
    assert half_files(tmp_path) == []
    assert not [name for name in everything(tmp_path) if name.startswith(".")]


def test_an_interrupt_within_a_stretch_keeps_the_steps_solved_so_far(
    full_solution: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Energies and checks are taken of all increments of a stretch at once: of those before Ctrl-C
    too.
    """
    real = ContactProblem.equilibrium
    calls = 0

    def equilibrium(*arguments: object) -> object:
        nonlocal calls
        calls += 1
        if calls == 60:
            raise KeyboardInterrupt
        return real(*arguments)

    monkeypatch.setattr(ContactProblem, "equilibrium", equilibrium)
    with pytest.raises(Interrupted, match=r"after \d+ steps") as stop:
        halfplane_fe.solve(full_solution.scene, MESH, scales=full_solution.scales)
    solved = stop.value.partial
    assert len(solved.time) == 60
    np.testing.assert_array_equal(solved.shear, full_solution.shear[:60])


IGNORED = (
    "from reports.cli.application import ended_by_signals",
    "signal.signal(signal.SIGHUP, signal.SIG_IGN)",
    "with ended_by_signals(): os.kill(os.getpid(), signal.SIGHUP); print('goes on')",
)
TWICE = (
    "from reports.cli import application as cli",
    "def stop(*_): os.kill(os.getpid(), signal.SIGINT)",
    "cli.app = cli._print_refusal = stop",
    "sys.exit(cli.main())",
)


def swallowed(fault: str, attempt: str = "os.kill(os.getpid(), signal.SIGINT)") -> tuple[str, ...]:
    """Compiled modules and locks make another error of a Ctrl-C."""
    inside = (
        "def app(_):",
        f"    try: {attempt}",
        "    except KeyboardInterrupt: pass",
        f"    raise {fault}",
    )
    return (
        "from reports.cli import application as cli",
        *inside,
        "cli.app = app",
        "sys.exit(cli.main())",
    )


SAID = r"halfplane: interrupted; nothing was written\n"
SCRIPTS = {
    "a signal that nohup ignores stays ignored": (IGNORED, (0, "goes on\n"), ""),
    "a second Ctrl-C while the first is reported": (TWICE, (130, ""), ""),
    "Ctrl-C in a compiled module": (
        swallowed("ImportError('initialization failed')"),
        (130, ""),
        SAID,
    ),
    "Ctrl-C in a lock": (swallowed("RuntimeError('release unlocked lock')"), (130, ""), SAID),
    "the same error without a signal": (
        swallowed("ImportError('x')", "pass"),
        (70, ""),
        r"halfplane: internal error.*\n",
    ),
}


@pytest.mark.parametrize("case", SCRIPTS)
def test_signals_at_odd_moments(case: str, tmp_path: Path) -> None:
    lines, code_and_output, message = SCRIPTS[case]
    outcome = forked(tmp_path, act=lambda: exec("\n".join(["import os, signal, sys", *lines]), {}))
    assert (outcome.returncode, outcome.stdout) == code_and_output
    assert re.fullmatch(message, outcome.stderr)


@pytest.mark.parametrize("move", [1, 2, 4])
def test_ctrl_c_while_files_are_moved_waits_until_all_are(
    move: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.replace
    moves = 0

    def replace(source: Path, target: Path) -> None:
        nonlocal moves
        moves += 1
        if moves == move:
            os.kill(os.getpid(), signal.SIGINT)
        real(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(FilledBefore, match=r"the results in .*out are whole"):
        fill(tmp_path / "out", "a.json", "report.html")
    assert set(os.listdir(tmp_path)) == {"out"}
    assert listed(tmp_path / "out") == {"a.json", "report.html", MANIFEST}


# ------------------------------------------------------------------------------------------ streams
@pytest.fixture
def unread() -> Iterator[int]:
    """A pipe that nobody reads any more."""
    read, write = os.pipe()
    os.close(read)
    yield write
    os.close(write)


@pytest.fixture
def full() -> Iterator[int]:
    """A disk that is full."""
    with open("/dev/full", "w") as stream:
        yield stream.fileno()


@pytest.mark.parametrize("words", [("scenes", "--json"), ("--help",)])
def test_an_answer_that_nobody_reads_is_141_and_one_without_room_a_sentence(
    words: tuple[str, ...], unread: int, full: int, tmp_path: Path
) -> None:
    """As in `halfplane scenes | head -1`; 1 would mean that a verdict is bad."""
    outcome = forked(tmp_path, *words, stdout=unread)
    assert (outcome.returncode, outcome.stderr) == (141, "")
    line = sentence(forked(tmp_path, *words, stdout=full))
    assert "No space left on device" in line


def test_json_is_plain_ascii_for_any_terminal(tmp_path: Path) -> None:
    outcome = forked(tmp_path, "check", "hertz-paper", "--json", PYTHONIOENCODING="ascii")
    assert (outcome.returncode, outcome.stderr, outcome.stdout.isascii()) == (0, "", True)
    assert any("ν = 0.3" in note for note in json.loads(outcome.stdout)["result"]["notes"])


# --------------------------------------------------------------------------------------- full disks
# An old run lies in x; each of these writes there, or beside it, every kind of file that the
# command writes.
DISK_JOBS = {
    "run": ("run", "cattaneo-mindlin", *COARSE, "--out", "x", "--quiet"),
    "exact": ("exact", "cattaneo-mindlin", "--out", "x", "--quiet"),
    "fe": ("fe", "cattaneo-mindlin", *COARSE, "--out", "x", "--quiet"),
    "fields": ("fields", "blocks", *COARSE, "--at", "2.0", "--out", "x", "--quiet"),
    "score": ("score", "x/reference.nc", "--scene", "cattaneo-mindlin", "--out", "x", "--quiet"),
    "export": ("export", "blocks", "--out", "x", "--quiet"),
    "diff": ("diff", "x", "new/baseline.json", "--accept", "--quiet"),
    "init": ("init", "scene.toml", "--from", "time-series", "--quiet"),
    "paper": ("paper", "--out", "x", "--quiet"),
    "map": ("map", "all", "--out", "maps", "--pages", "--quiet"),
}
# Bytes at which no file may grow: the first write of a text fails, a later one, that of a table.
LIMITS = (1, 1000, 100_000)


def kept(folder: Path, message: str) -> dict[str, bytes | None]:
    """What lies in a folder but for the whole results that `told` says are kept beside it."""
    place = message.rsplit("kept in ", 1)[1].strip().rstrip(".") if "kept in " in message else ""
    in_folder = content(folder)
    assert not place or content(Path(place))
    above = Path(place).parent.name
    return {
        name: held for name, held in in_folder.items() if not place or name.split("/")[0] != above
    }


def check(code: int, errors: str, disk: Path, before: dict[str, bytes | None]) -> None:
    """What must hold after a write that failed."""
    assert code == 2, (code, errors)
    (line,) = errors.splitlines()
    assert line.startswith("halfplane: "), errors
    assert kept(disk, line) == before, errors
    assert half_files(disk) == []


def prepare_disk(job: str, old: Path, disk: Path) -> None:
    """An old run; for `map` the published maps, one with a page to be written again."""
    shutil.copytree(old, disk)
    if job == "map":
        shutil.copytree(Path(reports.__file__).parent / "published" / "maps", disk / "maps")
        (disk / "maps" / "pair.md").write_text("a page to be written again", encoding="utf-8")


@pytest.mark.parametrize(
    ("job", "limit"),
    [
        ("diff", 1000),
        ("init", 1000),
        *(
            pytest.param(job, limit, marks=pytest.mark.slow)
            for job in DISK_JOBS
            for limit in (*LIMITS, 3_072_000)
        ),
    ],
)
def test_a_file_that_may_not_grow_is_a_sentence_and_leaves_all_as_it_was(
    job: str, limit: int, old: Path, tmp_path: Path
) -> None:
    """HDF5 ended the process by a segmentation fault when it closed a file that found no room."""
    disk = tmp_path / "disk"
    prepare_disk(job, old, disk)
    before = content(disk)
    outcome = forked(disk, *DISK_JOBS[job], file_size=limit)
    if outcome.returncode in (0, 1):  # no file became so large
        assert content(disk) != before
        assert half_files(disk) == []
    else:
        check(outcome.returncode, outcome.stderr, disk, before)
        assert "File too large" in outcome.stderr


@pytest.mark.parametrize("name", ["replace", "rename"])
def test_whichever_move_fails_the_folder_is_as_before_and_what_is_new_is_kept(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    real = getattr(os, name)
    moves = 0
    fails = 0

    def move(source: Path, target: Path) -> None:
        nonlocal moves
        moves += Path(source).is_file()  # not the hidden folder, which may stay where it is
        if moves == fails:
            raise no_room()
        real(source, target)

    fill(out, "a.json", "old/b.json", "report.html")
    before = content(out)
    monkeypatch.setattr(os, name, move)
    while content(out) == before:
        moves = 0
        fails += 1
        message = ""
        try:
            fill(out, "a.json", "new/c.json", "report.html")
        except InputError as fault:
            message = str(fault)
        if moves < fails:
            break
        assert "No space left on device" in message
        place = Path(message.rsplit("kept in ", 1)[1])
        assert set(content(place)) == {"a.json", "new", "new/c.json", "report.html"}
        assert {path.name for path in tmp_path.iterdir()} == {"out", place.parent.name}
        shutil.rmtree(place.parent)
    assert fails > 3
    assert set(content(out)) == {"a.json", "new", "new/c.json", "report.html", MANIFEST}


# ---------------------------------------------------------- folders filled, lost, shared and locked
@pytest.mark.parametrize(
    "fault",
    [
        RuntimeError("half-way"),
        KeyboardInterrupt("stop"),
        FileNotFoundError(2, "a program is missing", "/typst"),
    ],
)
def test_an_error_on_the_way_leaves_nothing_or_the_earlier_report(
    fault: BaseException, tmp_path: Path
) -> None:
    """It passes through: one about another file is not one of the folder."""
    for earlier in (False, True):
        if earlier:
            fill(tmp_path / "out", "report.html")
        before = content(tmp_path)
        with pytest.raises(type(fault), match=re.escape(str(fault))):
            fill(tmp_path / "out", "report.html", "a.json", meanwhile=raising(fault))
        assert content(tmp_path) == before


def test_own_files_are_replaced_and_stale_ones_removed_but_by_a_lesser_run(tmp_path: Path) -> None:
    fill(tmp_path, "report.html", "fields/old.vtu")
    (tmp_path / "mine.txt").write_text("mine")
    for names, fresh, expected in (
        (("report.html",), ("",), {"report.html"}),
        (("semi_analytic.nc",), (), {"report.html", "semi_analytic.nc"}),
        (("report.html",), ("",), {"report.html"}),
    ):
        fill(tmp_path, *names, fresh=fresh)
        assert everything(tmp_path) == {*expected, "mine.txt", MANIFEST}
        assert (tmp_path / names[0]).read_text() == f"{names}"


@pytest.mark.parametrize("name", ["report.html", "scene.json", "manifest.json", "odd.csv"])
def test_files_of_others_are_never_replaced(name: str, tmp_path: Path) -> None:
    """Nor where only the writer knows the name."""
    (tmp_path / name).write_text("mine")
    refusal = pytest.raises(InputError, match=f"{name} is there already")
    with nullcontext() if name == "odd.csv" else refusal:
        usable_folder(tmp_path)
    with refusal:
        fill(tmp_path, "report.html", "odd.csv")
    assert content(tmp_path) == {name: b"mine"}


def locked(folder: Path) -> int:
    """A handle of a process that was stopped while it moved files."""
    handle = os.open(folder, os.O_RDONLY)
    fcntl.flock(handle, fcntl.LOCK_EX)
    return handle


def test_a_folder_that_a_stopped_process_holds_is_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders, "_LONGEST_WAIT_SECONDS", 0.0)
    handle = locked(tmp_path)
    with pytest.raises(InputError, match="another process has held this folder for 0 s"):
        usable_folder(tmp_path)
    os.close(handle)
    assert usable_folder(tmp_path) == tmp_path


def replaced_by_a_file(out: Path) -> None:
    out.rmdir()
    out.write_text("mine")


SPOILS: dict[str, Callable[[Path], object]] = {
    "locked": locked,
    "a file": replaced_by_a_file,
    "a name taken": lambda out: (out / "a.json").write_text("mine"),
}


@pytest.mark.parametrize("spoil", SPOILS)
def test_what_was_computed_is_kept_where_its_folder_is_lost(
    spoil: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Hours of work must not go because of what somebody did to the folder meanwhile."""
    monkeypatch.setattr(folders, "_LONGEST_WAIT_SECONDS", 0.0)
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(InputError, match="what did not get there is kept in ") as fault:
        fill(out, "a.json", "b.json", meanwhile=lambda: SPOILS[spoil](out))
    usable_folder(tmp_path / "later")
    assert (Path(str(fault.value).rsplit("kept in ", 1)[1]) / "b.json").is_file()
    assert not (out / MANIFEST).exists()
    assert out.is_dir() or out.read_text() == "mine"


def test_many_at_once_on_one_folder_leave_one_whole_report(tmp_path: Path) -> None:
    """Whoever moves last leaves its files and no others, and the manifest lists what is there."""
    runs = [
        ("a.json", "b.json", "report.html"),
        ("a.json", "c.json", "tables/d.csv", "report.html"),
    ]

    def fill_slowly(number: int) -> None:
        fill(tmp_path / "out", *runs[number % 2], meanwhile=lambda: time.sleep(0.01))

    for _ in range(10):
        with ThreadPoolExecutor(8) as crowd:
            list(crowd.map(fill_slowly, range(8)))
        last = (tmp_path / "out" / "report.html").read_text()
        assert listed(tmp_path / "out") == {*literal_eval(last), MANIFEST}
        assert {(tmp_path / "out" / name).read_text() for name in literal_eval(last)} == {last}
    assert os.listdir(tmp_path) == ["out"]


@pytest.mark.slow
def test_another_first_run_at_any_moment_is_no_stranger(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One whole run comes between any two lines of another, or waits for it: three of 163 took its
    page for somebody else's.
    """
    real = time.sleep
    waits = threading.Event()
    lines = 0
    moment = 0
    rivals: list[Future[None]] = []

    def sleep(seconds: float) -> None:
        waits.set()  # the one of us has locked what the other needs
        real(seconds)

    def watch(frame: FrameType, event: str, _argument: object) -> Callable[..., Any] | None:
        nonlocal lines
        if not frame.f_code.co_filename.endswith("folder.py"):
            return None
        lines += event == "line"
        if lines == moment and not rivals:
            rivals.append(
                crowd.submit(
                    fill, tmp_path / str(moment) / "out", "a.json", "b.json", "report.html"
                )
            )
            rivals[0].add_done_callback(lambda _: waits.set())
            assert waits.wait(60)
        return watch

    monkeypatch.setattr(time, "sleep", sleep)
    with ThreadPoolExecutor(1) as crowd:
        while lines >= moment:
            moment += 1
            lines = 0
            place = tmp_path / str(moment)
            place.mkdir()
            rivals.clear()
            waits.clear()
            sys.settrace(watch)
            try:
                fill(place / "out", "a.json", "c.json", "report.html")
            finally:
                sys.settrace(None)
            for rival in rivals:
                rival.result(60)
            (names,) = {
                path.read_text() for path in (place / "out").iterdir() if path.name != MANIFEST
            }
            assert listed(place / "out") == {MANIFEST, *literal_eval(names)}
            assert os.listdir(place) == ["out"]
    assert moment > 100


# ---------------------------------------------------------------------------------------- same bits
def test_the_same_scene_twice_is_the_same_files(old: Path, tmp_path: Path) -> None:
    """Timestamps and wall times apart, the bytes of every table and the numbers of every answer."""
    solution = cattaneo_mindlin(steps_per_leg=10, points=41)
    page = reports.write(reports.compare(solution, solution), tmp_path / "x")
    assert numbers(page.parent) == numbers(old / "x")
    assert len(numbers(page.parent)) > 10
    assert page.stat().st_size == (old / "x" / "report.html").stat().st_size


@pytest.mark.slow
def test_one_or_two_threads_of_blas_agree_to_rounding() -> None:
    """Whatever the user's machine allows: the finite elements hold BLAS to one thread themselves,
    theory does without it.

    With that hold undone, two threads moved nodal shear by 4.6e-12 of the largest pressure.
    """
    answers = []
    mesh = MeshSettings(element_size=0.1, edge_element_size=0.05)
    for threads in (1, 2):
        with threadpool_limits(threads, "blas"):
            fe = halfplane_fe.solve(load_scene("blocks"), mesh)
            theory = semi_analytic.solve(fe.scene, x=fe.x, time=fe.time)
            answers.append((fe, theory))
    for single, two in zip(*answers, strict=True):
        scale = float(np.max(single.pressure))
        for name in ("pressure", "shear"):
            assert np.max(np.abs(getattr(single, name) - getattr(two, name))) <= 1e-12 * scale
        assert abs(two.dissipation / single.dissipation - 1) <= 1e-12
