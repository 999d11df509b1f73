"""Files and folders that are under a hidden name until they are whole; the name holds the machine and the process that writes.

So the next run finds what a killed process left, and removes it.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from meshes.interrupts import interrupts_wait
from scenes import InputError, files

# None on Windows, which has other locks.
fcntl = import_module("fcntl") if find_spec("fcntl") else None

# Of a container its own processes: one of another with the same name and number may live.
_SPACE = Path("/proc/self/ns/pid")
_HERE = hashlib.sha256(f"{platform.node()} {_SPACE.readlink() if _SPACE.is_symlink() else ''}".encode()).hexdigest()[:6]
_OURS = re.compile(r"\.halfplane-([0-9a-f]{6})-(?:(\d+)-)?\w{8}")
# Seconds: where nobody says whether its process lives, what did not change for a day is left behind.
_LEFT_BEHIND = 86400.0


def hidden_folder(place: Path, better: Path) -> Path:
    """A new folder for this user alone, made in `place` and moved to `better` where that can be.

    Raises
    ------
    OSError
        Where it can't be made.
    """
    with interrupts_wait():
        path = Path(tempfile.mkdtemp(prefix=_prefix(), dir=place))
        if place != better:
            with suppress(OSError):  # another disk, or a folder of others
                path = path.rename(better / path.name)
    return path


def _prefix() -> str:
    return f".halfplane-{_HERE}-{os.getpid()}-"


def remove(path: Path) -> None:
    """Remove a hidden file or folder."""
    with interrupts_wait():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def replace_file(path: str | Path, content: bytes | memoryview) -> None:
    """Write a file in one go: a reader sees the old one or the new one, whole.

    Raises
    ------
    OSError
        Where it can't be written; the old one stays.
    """
    handle, name = tempfile.mkstemp(prefix=_prefix(), dir=Path(os.path.realpath(path)).parent)
    os.close(handle)
    files.replace_file(path, content, Path(name))


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
            with suppress(OSError):
                if _is_dead(Path(entry.path)):
                    remove(Path(entry.path))


def _is_dead(path: Path) -> bool:
    """Whether the process that made a hidden file or folder has ended: one of this machine is asked for, of others age counts."""
    found = _OURS.fullmatch(path.name)
    if found and found[1] == _HERE and found[2] and sys.platform != "win32":
        try:
            os.kill(int(found[2]), 0)
        except ProcessLookupError:
            return True
        except PermissionError:  # somebody else's
            pass
        return False
    return time.time() - max(there.stat().st_mtime for there in (path, *path.rglob("*"))) > _LEFT_BEHIND
