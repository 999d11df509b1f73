"""Who is at work on which point, so that two sweeps on one store don't compute the same. A claim only saves time: a result is right
whoever wrote it, and a claim whose owner is gone counts for nothing.
"""

from __future__ import annotations

import json
import os
import platform
import time
from contextlib import suppress
from pathlib import Path

from reports.sweep.store import Store, names, unwritable

# A claim of another machine is renewed every so many seconds, and given up as lost after so many without.
RENEWED_EVERY = 20.0
_LOST_AFTER = 180.0


class Claims:
    """The claims of one process on the points of a store."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._held: set[str] = set()
        self._renewed = time.monotonic()
        self._words = json.dumps({"host": platform.node(), "pid": os.getpid(), "born": _born(os.getpid())})

    def take(self, address: str) -> bool:
        """Whether the point is ours from now on; not where a sweep that lives has it."""
        if address in self._held:
            return True
        path = self._store.claims / address
        for _ in range(2):
            try:
                handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
            except FileExistsError:
                if alive(path):
                    return False
                path.unlink(missing_ok=True)
                continue
            except OSError as reason:
                raise unwritable(self._store.folder, reason) from reason
            self._held.add(address)
            try:
                os.write(handle, self._words.encode())
            except OSError as reason:
                self.drop(address)
                raise unwritable(self._store.folder, reason) from reason
            finally:
                os.close(handle)
            return True
        return False

    def drop(self, address: str) -> None:
        """Let go of a point."""
        if address in self._held:
            with suppress(OSError):  # the store is gone, or not ours any more: a claim counts for nothing once we end
                (self._store.claims / address).unlink()
            self._held.discard(address)

    def renew(self) -> None:
        """Say that we live, if it was a while ago."""
        if time.monotonic() - self._renewed < RENEWED_EVERY:
            return
        self._renewed = time.monotonic()
        for address in self._held:
            with suppress(OSError):  # another sweep took us for dead: both will write the same
                os.utime(self._store.claims / address)

    def drop_all(self) -> None:
        """Let go of everything."""
        for address in list(self._held):
            self.drop(address)


def alive(path: Path) -> bool:
    """Whether the owner of a claim is at work; on another machine: whether it said so of late."""
    try:
        written = path.stat().st_mtime
    except OSError:
        return False
    try:
        owner = json.loads(path.read_text(encoding="utf-8"))
        host, pid, born = owner["host"], int(owner["pid"]), owner["born"]
    except FileNotFoundError:
        return False
    except (ValueError, KeyError, TypeError):
        return time.time() - written < 5  # being written, or left half-written by a sweep that died
    except OSError:
        return time.time() - written < _LOST_AFTER  # another user's, who lets nobody read it
    if host == platform.node():
        return bool(_born(pid) == born)
    return time.time() - written < _LOST_AFTER


def running(store: Store) -> set[str]:
    """Addresses of the points that some sweep is at work on."""
    return {name for name in names(store.claims) if alive(store.claims / name)}


def _born(pid: int) -> str:
    """When a process started, as the system counts: tells it from a later one of the same number; "" where there is none."""
    try:
        state, *rest = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    except OSError:
        return _signal(pid)
    return "" if state == "Z" else rest[18]  # a zombie is dead, only not yet buried


def _signal(pid: int) -> str:
    """Where there is no /proc: whether the process exists is all that is known."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return ""
    except PermissionError:
        return "exists"
    return "exists"
