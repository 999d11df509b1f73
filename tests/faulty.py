"""The program killed, doubled, and on a disk whose k-th write fails: for the tests of faults and
benchmarks/jobs.py.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import gc
import json
import os
import platform
import random
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

from command_line import COARSE, ROOT, start
from reports.studies.sweep.store import Store
from scenes import ContactSolution

# ---------------------------------------------------------------------- killed, starved and doubled
# What is timed, and what the cache of bodies saved: all else of two runs must be the same to the
# last bit.
TIMED = ("seconds", "command", "condensations", "sparse factorisations")
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports")
STUDY = """scene = "hertz-paper"\nengines = ["exact"]
figures = ["exact.dissipation", "exact.peak_dissipation"]
[[axes]]\nname = "f"\nkey = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 40}\n"""
JOBS = {
    "run": ("run", "hertz-paper", *COARSE, "--out", "out"),
    "sweep": ("sweep", "study.toml", "--workers", "1", "--out", "out", "--resume"),
}


def started(folder: Path, job: str) -> subprocess.Popen[str]:
    """A job in a session of its own, so that its workers can be killed with it."""
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return start(
        folder, *JOBS[job], "--quiet", session=True, PYTHONPATH=str(folder.parent / "code")
    )


def finished(folder: Path, job: str) -> int:
    with started(folder, job) as process:
        _, errors = process.communicate(timeout=3600)
    assert "Traceback" not in errors, errors
    return process.returncode


def half_files(folder: Path) -> list[str]:
    """Files under a name that a reader would open, and that are not whole; what is hidden or ends
    in .part has no such name.
    """
    found = []
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        seen = (
            path.is_file()
            and path.suffix != ".part"
            and not any(part.startswith(".") for part in parts)
        )
        if seen and not _whole(path):
            found.append("/".join(parts))
    store = Store(folder / "out")
    return found + [address for address in store.addresses() if store.read(address) is None]


def _whole(path: Path) -> bool:
    try:
        match path.suffix:
            case ".json":
                json.loads(path.read_text(encoding="utf-8"))
            case ".nc":
                ContactSolution.load(path)
            case ".html":
                return path.read_text(encoding="utf-8").rstrip().endswith("</html>")
            case ".csv" | ".toml" | ".log":
                return path.read_text(encoding="utf-8").endswith("\n")
    except (ValueError, OSError):
        return False
    return True


def numbers(folder: Path) -> dict[str, str]:
    """Everything computed that lies in `folder`, by file; what is timed taken out."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.suffix == ".json" and path.name != "manifest.json":
            content = json.loads(path.read_text(encoding="utf-8"))
            found[name] = json.dumps(
                _untimed(content.get("result", content) if "sha256" in content else content),
                sort_keys=True,
            )
        elif path.suffix == ".csv" and path.name != "index.csv":
            found[name] = path.read_text(encoding="utf-8")
        elif path.suffix == ".nc":
            data = ContactSolution.load(path).to_dataset()
            found[name] = "".join(
                str(data[key].values.tobytes()) for key in sorted(map(str, data.variables))
            )
    return found


def _untimed(value: object) -> object:
    if isinstance(value, dict):
        return {
            key: _untimed(entry)
            for key, entry in value.items()
            if not any(word in key for word in TIMED)
        }
    return [_untimed(entry) for entry in value] if isinstance(value, list) else value


def survive(
    folder: Path, job: str, kills: int, seed: int, longest: float, truth: dict[str, str]
) -> int:
    """Kill the job and its workers `kills` times at random moments, then let it end; returns how
    often it held.

    After each kill every file is whole or absent, and in the end the numbers are those of an
    undisturbed run bit for bit.
    """
    chance = random.Random(seed)
    for _ in range(kills):
        process = started(folder, job)
        try:
            process.communicate(timeout=chance.uniform(0.2, longest))
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        assert half_files(folder) == []
    assert finished(folder, job) in (0, 1)
    assert half_files(folder) == []
    assert numbers(folder / "out") == truth
    return kills


def copy_the_code(folder: Path) -> None:
    """The packages, which nobody edits there while jobs run; once."""
    for package in PACKAGES:
        if not (folder / package).exists():
            shutil.copytree(
                ROOT / package,
                folder / package,
                ignore=shutil.ignore_patterns("published", "__pycache__"),
            )


def undisturbed(folder: Path, job: str) -> tuple[dict[str, str], float]:
    """The numbers of a run that nothing happened to, and how long it took."""
    copy_the_code(folder.parent / "code")
    folder.mkdir()
    begun = time.monotonic()
    assert finished(folder, job) in (0, 1)
    return numbers(folder / "out"), time.monotonic() - begun


# ------------------------------------------------------------- a disk on which the k-th write fails
# For a whole process and its children: libraries in C, ffmpeg and workers included. The kernel asks
# us about every call that
# writes (seccomp's user notification: Linux 5.5 and later, no rights needed), so nothing is
# compiled or patched. Tests that need it
# are slow ones, for in CI nothing else may be skipped.
_O_CREAT = 0o100
# Numbers of system calls; 0 where the machine has no such call.
_MACHINES = {
    "x86_64": (
        0xC000003E,
        317,
        {
            "write": 1,
            "pwrite64": 18,
            "writev": 20,
            "pwritev": 296,
            "ftruncate": 77,
            "fallocate": 285,
            "fsync": 74,
            "fdatasync": 75,
            "open": 2,
            "openat": 257,
            "mkdir": 83,
            "mkdirat": 258,
            "rename": 82,
            "renameat": 264,
            "renameat2": 316,
        },
    ),
    "aarch64": (
        0xC00000B7,
        277,
        {
            "write": 64,
            "pwrite64": 68,
            "writev": 66,
            "pwritev": 70,
            "ftruncate": 46,
            "fallocate": 47,
            "fsync": 82,
            "fdatasync": 83,
            "openat": 56,
            "mkdirat": 34,
            "renameat": 38,
            "renameat2": 276,
        },
    ),
}
# Of a call: the argument that is the path of what is written, and that of the folder it is relative
# to.
_PATHS = {
    "open": (0, None),
    "openat": (1, 0),
    "mkdir": (0, None),
    "mkdirat": (1, 0),
    "rename": (1, None),
    "renameat": (3, 2),
    "renameat2": (3, 2),
}
_FLAGS = {"open": 1, "openat": 2}
_ASK, _NEW_LISTENER, _RECEIVE, _ANSWER, _GO_ON = 0x7FC00000, 8, 0xC0502100, 0xC0182101, 1
_libc = ctypes.CDLL(None, use_errno=True)
_WARM = get_context("forkserver")
_COMMANDS = ["cli.solving", "cli.field_output", "studies.sweep.commands", "page.writing"]
_LIBRARIES = ["gmsh", "h5netcdf", "jinja2", "matplotlib.pyplot", "meshio", "pandas"]
_WARM.set_forkserver_preload(
    ["semi_analytic", "halfplane_fe", *(f"reports.{name}" for name in _COMMANDS), *_LIBRARIES]
)


@dataclass(frozen=True)
class Starved:
    """What became of a process: exit code (minus the signal that killed it), streams, the calls
    that wrote below the folder.
    """

    code: int
    out: str
    errors: str
    calls: tuple[str, ...]


def starved(words: Sequence[str], disk: Path, fails: int, *, for_ever: bool = True) -> Starved:
    """`halfplane` with `words`, in the folder `disk`; its call number `fails` that writes there
    ends in "No space left on device".

    Calls count from 1, and 0 is none. With `for_ever` all later ones end so too, but for moves: a
    full disk still lets a file go back to where it was.
    """
    calls: list[str] = []
    with tempfile.TemporaryDirectory() as name, socket.socket(socket.AF_UNIX) as door:
        here = Path(name)
        door.bind("")  # the system finds an address
        door.listen()
        keeper = threading.Thread(
            target=_answer, args=(door, disk, fails, for_ever, calls), daemon=True
        )
        keeper.start()
        process = _WARM.Process(
            target=_halfplane, args=(tuple(words), disk, here, door.getsockname())
        )
        process.start()
        process.join(600)
        process.kill()
        process.join()
        door.shutdown(socket.SHUT_RDWR)
        keeper.join(30)
        out, errors = ((here / stream).read_text(encoding="utf-8") for stream in ("out", "errors"))
    assert process.exitcode is not None
    return Starved(process.exitcode, out, errors, tuple(calls))


def possible() -> bool:
    """Whether this machine lets us."""
    return platform.machine() in _MACHINES and starved(["--version"], Path("/"), 0).code == 0


def _halfplane(words: Sequence[str], disk: Path, here: Path, address: bytes) -> None:
    """In a process of its own, with all that takes long to import there already."""
    from reports.cli import main

    os.chdir(disk)
    for stream, handle in (("out", 1), ("errors", 2)):
        os.dup2(os.open(here / stream, os.O_CREAT | os.O_WRONLY), handle)
    os.environ |= {"COLUMNS": "400", "NO_COLOR": "1"}
    sys.argv = ["halfplane", *words]
    with socket.socket(socket.AF_UNIX) as door:
        door.connect(address)
        listener = _install()
        socket.send_fds(door, [b" "], [listener])
        os.close(listener)
    code = main()
    gc.collect()  # what could end the process while it goes
    sys.exit(code)


def _install() -> int:
    """The filter, in the child, from now on; a handle that says what it asks."""
    _, seccomp, numbers = _MACHINES[platform.machine()]
    program = [
        (0x20, 0, 0, 0),
        *((0x15, len(numbers) - k, 0, number) for k, number in enumerate(numbers.values())),
    ]
    program += [(6, 0, 0, 0x7FFF0000), (6, 0, 0, _ASK)]
    code = ctypes.create_string_buffer(b"".join(struct.pack("HBBI", *line) for line in program))
    whole = ctypes.create_string_buffer(
        struct.pack("HxxxxxxP", len(program), ctypes.addressof(code))
    )
    if (
        _libc.prctl(38, 1, 0, 0, 0)
        or (listener := _libc.syscall(seccomp, 1, _NEW_LISTENER, whole)) < 0
    ):
        raise OSError(ctypes.get_errno(), "this system lets nobody watch its calls")
    return int(listener)


def _answer(door: socket.socket, disk: Path, fails: int, for_ever: bool, calls: list[str]) -> None:
    try:
        with door.accept()[0] as visitor:
            handles = socket.recv_fds(visitor, 1, 1)[1]
    except OSError:  # nobody came
        return
    if not handles:
        return
    names = {number: name for name, number in _MACHINES[platform.machine()][2].items()}
    waiting = select.poll()
    waiting.register(handles[0], select.POLLIN)
    try:
        while not (waiting.poll()[0][1] & select.POLLHUP):
            asked = bytearray(80)
            try:
                fcntl.ioctl(handles[0], _RECEIVE, asked, True)
            except OSError:  # who asked was killed
                continue
            number, process, _, call, _, _, *given = struct.unpack("QIIiIQ6Q", asked)
            name, fault = names[call], 0
            if place := _written(name, process, given, disk):
                calls.append(f"{name} {place}")
                moves = name.startswith("rename")
                fault = (
                    errno.ENOSPC
                    if len(calls) == fails or (for_ever and not moves and 0 < fails < len(calls))
                    else 0
                )
            answer = struct.pack("QqiI", number, 0, -fault, 0 if fault else _GO_ON)
            with suppress(OSError):
                fcntl.ioctl(handles[0], _ANSWER, bytearray(answer))
    finally:
        os.close(handles[0])


def _written(name: str, process: int, given: Sequence[int], disk: Path) -> str:
    """What below `disk` a call writes to, relative to it; "" where it writes elsewhere, or
    nothing.
    """
    try:
        if name in _PATHS:
            if name in _FLAGS and not given[_FLAGS[name]] & _O_CREAT:
                return ""
            where, folder = _PATHS[name]
            with open(f"/proc/{process}/mem", "rb", buffering=0) as memory:
                memory.seek(given[where])
                path = os.fsdecode(memory.read(4096).split(b"\0", 1)[0])
            start = ctypes.c_int(given[folder] & 0xFFFFFFFF).value if folder is not None else -100
            path = os.path.join(
                os.readlink(
                    f"/proc/{process}/cwd" if start == -100 else f"/proc/{process}/fd/{start}"
                ),
                path,
            )
        else:
            path = os.readlink(f"/proc/{process}/fd/{given[0]}")
        if name.startswith("mkdir") and os.path.isdir(path):  # the disk is not asked
            return ""
        relative = os.path.relpath(
            os.path.realpath(os.path.dirname(path)) + "/" + os.path.basename(path),
            os.path.realpath(disk),
        )
    except OSError:
        return ""
    return "" if relative.startswith("..") else relative
