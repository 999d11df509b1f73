"""The folder that results go to: found usable before any solving, filled in one go, never half."""

from __future__ import annotations

import json
import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path

from scenes import InputError
from scenes.bounded import parsed_json, text_of
from scenes.interrupts import interrupts_wait

if sys.platform != "win32":
    import fcntl

MANIFEST = "manifest.json"
_PAGE = "report.html"
# Files are moved in milliseconds: who has not done so after so many seconds is stopped.
_PATIENCE = 60.0
_RESULTS = (MANIFEST, _PAGE, "report.pdf", "run.log", "comparison.json", "scene.json", "reference.nc", "result.nc")


class FilledBefore(KeyboardInterrupt):
    """Ctrl-C that came too late: the folder was filled, and all in it is whole."""


def default_folder(name: str) -> Path:
    """out/<name> in the current folder, the name made fit for a file system.

    >>> default_folder("hertz-paper").as_posix(), default_folder("../my scene").as_posix()
    ('out/hertz-paper', 'out/my-scene')
    """
    return Path("out") / (re.sub(r"[^\w.-]+", "-", name).strip("-.") or "scene")


def claim(out: str | Path) -> Path:
    """`out` as a path that results can be written to; it is not made yet.

    Raises
    ------
    InputError
        Where it is a file, can't be made or written to, or holds a report that is not ours.
    """
    folder = Path(out)
    try:
        if folder.exists() and not folder.is_dir():
            raise InputError(f"--out {out}: this is a file; results go to a folder, so name another")
        with interrupts_wait():
            _staging(folder, out).rmdir()
        with _alone_in(folder, out):
            _refuse_foreign(folder, _RESULTS, out)
    except OSError as reason:
        raise _unwritable(out, reason) from reason
    return folder


@contextmanager
def filled(out: str | Path, *, fresh: tuple[str, ...] = ("",)) -> Generator[Path, None, None]:
    """A temporary folder beside `out` to write in; its files move to `out` at the end, or nothing does after an error.

    Whatever lies in `out` and is not ours (the manifest lists what is) stays. Our own files of an earlier run that this
    one did not write again are removed where their names start with one of `fresh` (all do by default), since a page must
    not stand beside figures of another run; the others stay too. Of two runs that fill one folder at once, the one that
    moves its files last leaves all of them. Where `out` can't be filled in the end, the files stay in the temporary folder,
    and the error says where that is.

    Raises
    ------
    InputError
        As `claim`, also where that comes to pass only while the work is done.
    FilledBefore
        For a Ctrl-C that came while files were moved: they are whole.
    """
    folder = claim(out)
    staging = _staging(folder, out)
    results, kept = staging / "results", ""
    try:
        results.mkdir(mode=0o700)
        yield results
        kept = f"; what did not get there is kept in {results}"
        _move(staging, folder, fresh, out)
        kept = ""
    except KeyboardInterrupt:
        kept = ""
        raise
    except OSError as reason:
        if isinstance(reason.filename, str) and not kept and not Path(reason.filename).is_relative_to(staging):
            raise  # it is about another file
        raise InputError(f"{_unwritable(out, reason)}{kept}") from reason
    except InputError as fault:
        if not kept:
            raise
        raise InputError(f"{fault}{kept}") from fault
    finally:
        if not kept:
            with interrupts_wait():
                shutil.rmtree(staging, ignore_errors=True)


def _unwritable(out: str | Path, reason: OSError) -> InputError:
    return InputError(f"--out {out}: the folder can't be written to: {reason.strerror or reason}; name another")


def _refuse_foreign(folder: Path, names: Iterable[str], out: str | Path) -> None:
    """InputError if one of `names` is in `folder` already and no manifest of ours lists it."""
    for name in sorted(set(names) - set(_owned(folder))):
        if not _lies_in(folder, name):
            raise InputError(f"--out {out}: {name} would be written outside, through a link; name another folder")
        if os.path.lexists(folder / name):
            raise InputError(f"--out {out}: {name} is there already and halfplane did not write it; name another folder or move it")


def _staging(folder: Path, out: str | Path) -> Path:
    """A new empty folder of the user alone, from which files can be moved to `out`; InputError if that can't be written to.

    Beside `out`, else in it: what is above may be another disk, or a folder of others.
    """
    try:
        above = Path(os.path.abspath(folder)).parent
        while not above.exists():
            above = above.parent
        if not folder.is_dir():
            return Path(tempfile.mkdtemp(prefix=".halfplane-", dir=above))
        inside = Path(tempfile.mkdtemp(prefix=".halfplane-", dir=folder))
    except OSError as reason:
        raise _unwritable(out, reason) from reason
    try:
        return inside.rename(above / inside.name)
    except OSError:
        return inside


def _files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _manifest(path: Path, names: Iterable[str]) -> Path:
    text = json.dumps({"written by": "halfplane", "files": sorted({*names, MANIFEST})}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def _owned(folder: Path) -> list[str]:
    """Files in `folder` that an earlier run listed as its own; a manifest that is not ours lists none."""
    try:
        stored = parsed_json(text_of(folder / MANIFEST, "the manifest"))
    except (OSError, ValueError):
        return []
    if not isinstance(stored, dict) or stored.get("written by") != "halfplane" or not isinstance(stored.get("files"), list):
        return []
    return [name for name in stored["files"] if isinstance(name, str) and _lies_in(folder, name)]


def _lies_in(folder: Path, name: str) -> bool:
    """Whether a file of that name lies in `folder` itself: not above it, and not behind a link that leads out of it."""
    try:
        return bool(name) and (folder / name).parent.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError):
        return False


def _move(staging: Path, folder: Path, fresh: tuple[str, ...], out: str | Path) -> None:
    """The results to `folder`: the old page goes first, the new one comes last.

    The manifest that goes there before any file lists what was there and what will be, so that a run killed between two
    moves leaves nothing that the next one takes for somebody else's; the one that goes there last, what is there.
    """
    results = staging / "results"
    new = _files(results)
    folder.mkdir(parents=True, exist_ok=True)
    with _alone_in(folder, out):
        _refuse_foreign(folder, new, out)
        others = set(_owned(folder)) - {*new, MANIFEST}
        stale = {name for name in others if name.startswith(fresh)}
        begun = _manifest(staging / "begun.json", {*new, *others})
        ended = _manifest(staging / "ended.json", {*new, *(others - stale)})
        try:
            with interrupts_wait():
                os.replace(begun, folder / MANIFEST)
                _remove(folder, stale.union({_PAGE} & {*new}))
                for name in sorted(new, key=lambda name: (name == _PAGE, name)):
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
                    os.replace(results / name, folder / name)
                os.replace(ended, folder / MANIFEST)
        except KeyboardInterrupt as stop:
            raise FilledBefore(f"the results in {out} are whole") from stop


@contextmanager
def _alone_in(folder: Path, out: str | Path) -> Generator[None, None, None]:
    """Wait for other processes that move files to `folder`; not where the system can't lock a folder (Windows, some networks)."""
    if sys.platform == "win32" or not folder.is_dir():
        yield
        return
    end = time.monotonic() + _PATIENCE
    while (handle := _locked(folder)) is None:
        if time.monotonic() > end:
            raise InputError(
                f"--out {out}: another process has held this folder for {_PATIENCE:g} s and moves no files (is it stopped?); "
                "end it, or name another folder"
            )
        time.sleep(0.01)
    try:
        yield
    finally:
        os.close(handle)


def _locked(folder: Path) -> int | None:
    """A handle that locks `folder` until it is closed; None while another process does, or where the folder was just replaced."""
    with interrupts_wait():
        handle = os.open(folder, os.O_RDONLY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            return None
        except OSError:
            return handle
        if os.path.exists(folder) and os.path.samestat(os.fstat(handle), os.stat(folder)):
            return handle
        os.close(handle)
        return None


def _remove(folder: Path, names: Iterable[str]) -> None:
    for name in names:
        (folder / name).unlink(missing_ok=True)
        above = (folder / name).parent
        if above != folder and above.is_dir() and not any(above.iterdir()):
            above.rmdir()
