"""Files and folders that are under a hidden name until they are whole, and locked: a lock of the system ends with its process.

So what a killed process left under such a name is locked by nobody, and the next run removes it.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from meshes.interrupts import interrupts_wait
from scenes import InputError, files

# None on Windows, which locks no folders.
fcntl = import_module("fcntl") if find_spec("fcntl") else None

# The machine is part of the name: some network disks lock for one machine alone, and there a run on another looks dead.
_HERE = hashlib.sha256(platform.node().encode()).hexdigest()[:6]
_PREFIX = f".halfplane-{_HERE}-"
_OURS = re.compile(r"\.halfplane-[0-9a-f]{6}-\w{8}")
# Seconds: where no lock says whether its process lives, what did not change for a day is left behind.
_LEFT_BEHIND = 86400.0
# A run that cleans up takes a name only between its birth and its lock, which is microseconds.
_TRIALS = 100


class CannotLock(OSError):
    """The system has no locks here."""


def lock(path: Path) -> int | None:
    """A handle that locks a file or folder until it is closed; None while another process does, or where `path` was just replaced.

    Raises
    ------
    CannotLock
        On Windows, and on some network disks.
    OSError
        Where `path` is not there, or can't be opened.
    """
    if fcntl is None:
        raise CannotLock("folders can't be locked")
    with interrupts_wait():
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.exists(path) and os.path.samestat(os.fstat(handle), os.stat(path)):
                return handle
        except BlockingIOError:
            pass
        except OSError as reason:
            os.close(handle)
            raise CannotLock(str(reason)) from reason
        os.close(handle)
        return None


def hidden_folder(place: Path, better: Path) -> tuple[Path, int | None]:
    """A new folder for this user alone, made in `place` and moved to `better` where that can be, and its lock; for `remove`.

    Raises
    ------
    OSError
        Where it can't be made.
    """
    with interrupts_wait():
        path, held = _locked(lambda: Path(tempfile.mkdtemp(prefix=_PREFIX, dir=place)))
        if place != better:
            with suppress(OSError):  # another disk, or a folder of others
                path = path.rename(better / path.name)
    return path, held


def remove(path: Path, held: int | None) -> None:
    """Remove a hidden file or folder, then let go of its lock."""
    with interrupts_wait():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)
        if held is not None:
            os.close(held)


def replace_file(path: str | Path, content: bytes | memoryview) -> None:
    """Write a file in one go: a reader sees the old one or the new one, whole.

    Raises
    ------
    OSError
        Where it can't be written; the old one stays.
    """
    new, held = _locked(lambda: _new_file(Path(os.path.realpath(path)).parent))
    try:
        files.replace_file(path, content, new)
    finally:
        remove(new, held)  # after an error; else it has its other name


def replace_text(path: Path, text: str) -> None:
    """Write a file in one go: a reader sees the old one or the new one; InputError where that is not possible."""
    try:
        remove_left_behind(path.parent)
        with made(path.parent):
            replace_file(path, text.encode())
    except OSError as reason:
        raise InputError(f"{path}: the file can't be written: {reason.strerror or reason}; name another place") from reason


@contextmanager
def made(folder: Path) -> Generator[None, None, None]:
    """`folder` is there, with all above it; what had to be made for that goes again after an error, unless something lies in it."""
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise


def remove_left_behind(folder: Path) -> None:
    """Remove what killed processes left in `folder` under a hidden name of ours."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in [entry for entry in entries if _OURS.fullmatch(entry.name) and not entry.is_symlink()]:
            with suppress(OSError), interrupts_wait():
                _remove_if_dead(Path(entry.path))


def _remove_if_dead(path: Path) -> None:
    try:
        held = lock(path)
        if held is None:
            return
    except CannotLock:
        held = None
    known = held is not None and path.name.startswith(_PREFIX)
    if known or time.time() - max(found.stat().st_mtime for found in (path, *path.rglob("*"))) > _LEFT_BEHIND:
        remove(path, held)
    elif held is not None:
        os.close(held)


def _locked(make: Callable[[], Path]) -> tuple[Path, int | None]:
    """What `make` makes, and the handle that locks it; None where the system has no locks."""
    for _ in range(_TRIALS):
        path = make()
        try:
            held = lock(path)
        except CannotLock:
            return path, None
        except FileNotFoundError:
            continue
        if held is not None:
            return path, held
    raise OSError(f"{path.parent}: whatever is made there is taken away at once")


def _new_file(folder: Path) -> Path:
    handle, name = tempfile.mkstemp(prefix=_PREFIX, dir=folder)
    os.close(handle)
    return Path(name)
