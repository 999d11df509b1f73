"""The folder that results go to: found usable before any solving, filled in one go, never half.

Files and folders have a hidden name until they are whole; it holds the machine and the process that
writes, so that the next run finds what a killed process left, and removes it.
"""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Generator, Iterable
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from meshes.interrupts import interrupts_wait
from scenes import InputError, files
from scenes.files import parsed_json, text_of

# ------------------------------------------------------------------------------- hidden until whole
# None on Windows, which has other locks.
fcntl = import_module("fcntl") if find_spec("fcntl") else None

# Of a container its own processes: one of another with the same name and number may live.
_SPACE = Path("/proc/self/ns/pid")
_HERE = hashlib.sha256(
    f"{platform.node()} {_SPACE.readlink() if _SPACE.is_symlink() else ''}".encode()
).hexdigest()[:6]
_OURS = re.compile(r"\.halfplane-([0-9a-f]{6})-(?:(\d+)-)?\w{8}")
# Seconds: where nobody says whether its process lives, what did not change for a day is left
# behind.
_LEFT_BEHIND = 86400.0


def _hidden_folder(place: Path, better: Path) -> Path:
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


def _remove(path: Path) -> None:
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
    """Write a text file in one go, so that a reader sees the old one or the new one. InputError
    where that is not possible.
    """
    try:
        remove_left_behind(path.parent)
        with _made(path.parent):
            replace_file(path, text.encode())
    except OSError as reason:
        raise InputError(
            f"{path}: the file can't be written: {reason.strerror or reason}; name another place"
        ) from reason


@contextmanager
def _made(folder: Path) -> Generator[None, None, None]:
    """Within this context `folder` exists, with all folders above it. Folders that had to be made
    are removed again after an error, unless they hold something.
    """
    missing_folders = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in missing_folders:
            with suppress(OSError):
                path.rmdir()
        raise


def remove_left_behind(folder: Path) -> None:
    """Remove what killed processes of this program left in `folder`, under hidden names that only
    it uses.
    """
    with suppress(OSError), os.scandir(folder) as entries:
        hidden_folders = [
            Path(entry.path)
            for entry in entries
            if _OURS.fullmatch(entry.name) and not entry.is_symlink()
        ]
        for path in hidden_folders:
            with suppress(OSError):
                if _is_dead(path):
                    _remove(path)


def _is_dead(path: Path) -> bool:
    """Whether the process that made a hidden file or folder has ended: one of this machine is asked
    for, of others age counts.
    """
    name = _OURS.fullmatch(path.name)
    if name and sys.platform != "win32":
        machine, process = name.groups()
        if machine == _HERE and process:
            return _has_ended(int(process))
    last_change = max(inner_path.stat().st_mtime for inner_path in (path, *path.rglob("*")))
    return time.time() - last_change > _LEFT_BEHIND


def _has_ended(process: int) -> bool:
    """Whether this machine has no process of that number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # somebody else's
        return False
    return False


MANIFEST = "manifest.json"
_PAGE = "report.html"
# Files are moved in milliseconds: who has not done so after so many seconds is stopped.
_PATIENCE = 60.0
RESULTS = (MANIFEST, _PAGE, "run.log", "comparison.json", "scene.json", "reference.nc", "result.nc")


def files_of_a_solution(name: str) -> tuple[str, ...]:
    """The files that hold one solution, `name` being that of its engine, or "partial"."""
    return (
        MANIFEST,
        "run.log",
        "scene.json",
        *(f"{name}.{kind}" for kind in ("nc", "json", "csv")),
    )


# The folder that the running command writes to, once it is known: run.log there takes the traceback
# of an internal error.
output_folder: ContextVar[Path | None] = ContextVar("output_folder", default=None)


class FilledBefore(KeyboardInterrupt):
    """Ctrl-C that came too late: the folder was filled, and all in it is whole."""


def default_folder(name: str) -> Path:
    """out/<name> in the current folder, the name made fit for a file system.

    >>> default_folder("hertz-paper").as_posix(), default_folder("../my scene").as_posix()
    ('out/hertz-paper', 'out/my-scene')
    """
    return Path("out") / (re.sub(r"[^\w.-]+", "-", name).strip("-.") or "scene")


def claim(out: str | Path, names: Iterable[str] = RESULTS) -> Path:
    """`out` as a path that results can be written to; it is not made yet. `names` are the files
    that will be written there. What killed runs left in it and beside it is removed.

    Raises
    ------
    InputError
        Where it is a file, can't be made or written to, or holds one of `names` that is not ours.
    """
    folder = Path(out)
    try:
        if folder.exists() and not folder.is_dir():
            raise InputError(
                f"--out {out}: this is a file; results go to a folder, so name another"
            )
        for place in (folder, _above(folder)):
            remove_left_behind(place)
        _remove(_staging(folder))
        with (
            suppress(FileNotFoundError),
            _alone_in(folder, out),
        ):  # what is in a folder that is not there yet, others put there rightly
            _refuse_foreign(folder, names, out)
    except OSError as reason:
        raise _unwritable(out, reason) from reason
    output_folder.set(folder)
    return folder


def add_to_log(folder: Path, text: str) -> Path:
    """Append `text` to run.log in `folder`, where all else stays; returns its path."""
    with filled(folder, fresh=()) as staging:
        log = folder / "run.log"
        log_before = log.read_text("utf-8", errors="replace") if log.is_file() else ""
        (staging / "run.log").write_text(log_before + text, encoding="utf-8")
    return log


@contextmanager
def filled(
    out: str | Path, *, fresh: tuple[str, ...] = ("",), solutions: tuple[str, ...] = ()
) -> Generator[Path, None, None]:
    """A temporary folder beside `out` to write in; its files move to `out` at the end, or nothing
    does after an error.

    Whatever lies in `out` and is not ours (the manifest lists what is) stays. Our own files of an
    earlier run that this one did not write again are removed where their names start with one of
    `fresh` (all do by default), since a page must not stand beside figures of another run; the
    others stay too. Of two runs that fill one folder at once, the one that moves its files last
    leaves all of them. Where `out` can't be filled in the end, all in it stays as it was, the new
    files are kept beside it, and the error says where that is.

    Parameters
    ----------
    out
        the folder
    fresh
        beginnings of the names of earlier files that are removed where they are not written
        again
    solutions
        names of files, each written in one go, that must outlive a fault in what is written
        after them. They move to `out` alone, and a note of the error says so; where the disk
        itself fails they are kept beside `out`

    Raises
    ------
    InputError
        Where `out` is a file, can't be made or written to, or holds a file of somebody else under
        a name that is to be written; also where that comes to pass only while the work is done.
    FilledBefore
        For a Ctrl-C that came while files were moved: they are whole.
    """
    folder = claim(out)
    is_moving = False
    try:
        staging = _staging(folder)
    except OSError as reason:
        raise _unwritable(out, reason) from reason
    results = staging / "results"
    with ExitStack() as cleanup:
        cleanup.callback(_remove, staging)
        try:
            results.mkdir(mode=0o700)
            yield results
            is_moving = True
            _move(staging, folder, fresh, out)
        except InputError as fault:
            if not is_moving:
                raise
            cleanup.pop_all()  # nothing is removed
            raise InputError(f"{fault}{_kept_beside(staging)}") from fault
        except OSError as fault:
            is_about_folder = is_moving or not _is_about_another_file(fault, staging)
            if not is_about_folder:
                _move_solutions(staging, folder, fresh, out, solutions, fault)
                raise
            sentence = ""
            if is_moving or _leave_only(results, solutions):
                cleanup.pop_all()  # nothing is removed
                sentence = _kept_beside(staging)
            raise InputError(f"{_unwritable(out, fault)}{sentence}") from fault
        except Exception as fault:
            if not is_moving:
                _move_solutions(staging, folder, fresh, out, solutions, fault)
            raise


def _kept_beside(staging: Path) -> str:
    """Where files are that did not get to their folder, as the end of a sentence."""
    return f"; what did not get there is kept in {_visible(staging) / 'results'}"


def _leave_only(results: Path, names: Iterable[str]) -> list[str]:
    """Remove all files in `results` but those called `names`; returns which of these were
    written.
    """
    written_names = [name for name in names if (results / name).is_file()]
    for name in set(_files(results)) - set(written_names):
        (results / name).unlink()
    return written_names


def _move_solutions(
    staging: Path,
    folder: Path,
    fresh: tuple[str, ...],
    out: str | Path,
    solutions: tuple[str, ...],
    fault: Exception,
) -> None:
    """After an error (`fault`) save at least the solutions that were written: move them from the
    temporary folder `staging` to `folder`, and add a note to the error that names them.

    Parameters
    ----------
    fresh
        beginnings of the names of an earlier run's files that are removed where they are not
        written again
    out
        the folder as the user named it, for messages
    solutions
        names of the files to save
    """
    with suppress(OSError, InputError):  # the fault itself is what has to be said
        if written_names := _leave_only(staging / "results", solutions):
            _move(staging, folder, fresh, out)
            fault.add_note(
                "the solutions are saved:"
                f" {' and '.join(str(folder / name) for name in written_names)}"
            )


def _is_about_another_file(fault: OSError, staging: Path) -> bool:
    return isinstance(fault.filename, str) and not Path(fault.filename).is_relative_to(staging)


def _visible(staging: Path) -> Path:
    """Rename a hidden temporary folder of results so that users see it and no later run removes it.
    Empty folders and the program's own bookkeeping files are removed from it first. Returns its
    path, the old one where it can't be renamed.
    """
    try:
        for path in staging.iterdir():
            if path.is_file():
                path.unlink()
            elif not _files(path):
                shutil.rmtree(path)
        return staging.rename(staging.with_name(f"halfplane-kept-{staging.name[-8:]}"))
    except OSError:
        return staging


def _unwritable(out: str | Path, reason: OSError) -> InputError:
    return InputError(
        f"--out {out}: the folder can't be written to: {reason.strerror or reason}; name another"
    )


def _refuse_foreign(folder: Path, names: Iterable[str], out: str | Path) -> None:
    """InputError if one of `names` is in `folder` already and no manifest of this program lists it,
    or would be written outside through a link.
    """
    # Where folders can't be locked another run may move its files now: the manifest goes there
    # before them, so it is read after.
    existing = {name for name in names if os.path.lexists(folder / name)}
    for name in sorted(set(names) - set(_owned(folder))):
        if not _lies_in(folder, name):
            raise InputError(
                f"--out {out}: {name} would be written outside, through a link; name another folder"
            )
        if name in existing:
            raise InputError(
                f"--out {out}: {name} is there already and halfplane did not write it; name another"
                " folder or move it"
            )


def _above(folder: Path) -> Path:
    """The nearest folder above that is there."""
    return next(path for path in Path(os.path.abspath(folder)).parents if path.exists())


def _staging(folder: Path) -> Path:
    """A new empty folder of the user alone, from which files can be moved to `folder`; OSError if
    that can't be.

    Beside `folder`, else in it: what is above may be another disk, or a folder of others.
    """
    return _hidden_folder(folder if folder.is_dir() else _above(folder), _above(folder))


def _files(folder: Path) -> list[str]:
    return sorted(
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
    )


def _manifest(path: Path, names: Iterable[str]) -> Path:
    text = json.dumps({"written by": "halfplane", "files": sorted({*names, MANIFEST})}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def _owned(folder: Path) -> list[str]:
    """Names of files in `folder` that an earlier run listed in its manifest; none without a
    manifest of this program.
    """
    try:
        manifest = parsed_json(text_of(folder / MANIFEST, "the manifest"))
    except (OSError, ValueError):
        return []
    if not isinstance(manifest, dict) or manifest.get("written by") != "halfplane":
        return []
    names = manifest.get("files")
    if not isinstance(names, list):
        return []
    return [name for name in names if isinstance(name, str) and _lies_in(folder, name)]


def _lies_in(folder: Path, name: str) -> bool:
    """Whether a file of that name lies in `folder` itself: not above it, and not behind a link that
    leads out of it.
    """
    try:
        return bool(name) and (folder / name).parent.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError):
        return False


def _move(staging: Path, folder: Path, fresh: tuple[str, ...], out: str | Path) -> None:
    """Move the results of a run from the hidden folder `staging` to `folder`: an old page goes
    first, the new one comes last. After an error everything is as it was before.

    A manifest in the folder lists the program's own files. One that goes there before any file
    lists what was there and what will be; the last one lists what is there. So a run killed between
    two moves leaves nothing that the next one takes for somebody else's.

    Parameters
    ----------
    fresh
        beginnings of the names of earlier files that are removed where they are not written again
    out
        the folder as the user named it, for messages
    """
    results = staging / "results"
    old_results = staging / "before"
    new_names = _files(results)
    with _made(folder), _alone_in(folder, out, make=True), ExitStack() as folders:
        _refuse_foreign(folder, new_names, out)
        other_names = set(_owned(folder)) - {*new_names, MANIFEST}
        stale_names = {name for name in other_names if name.startswith(fresh)}
        replaced_names = sorted(
            (name for name in {*new_names, *stale_names} if os.path.lexists(folder / name)),
            key=lambda name: (name != _PAGE, name),
        )
        first_manifest = _manifest(staging / "begun.json", {*new_names, *other_names})
        last_manifest = _manifest(
            staging / "ended.json", {*new_names, *(other_names - stale_names)}
        )
        for name in replaced_names:
            (old_results / name).parent.mkdir(parents=True, exist_ok=True)
        for parent in {(folder / name).parent for name in new_names} - {folder}:
            folders.enter_context(_made(parent))
        try:
            with interrupts_wait(), ExitStack() as undoing:
                if os.path.lexists(folder / MANIFEST):
                    shutil.copyfile(folder / MANIFEST, before_manifest := staging / MANIFEST)
                    undoing.callback(os.replace, before_manifest, folder / MANIFEST)
                else:
                    undoing.callback((folder / MANIFEST).unlink, missing_ok=True)
                os.replace(first_manifest, folder / MANIFEST)
                for name in replaced_names:
                    os.rename(folder / name, old_results / name)
                    undoing.callback(os.rename, old_results / name, folder / name)
                for name in sorted(new_names, key=lambda name: (name == _PAGE, name)):
                    os.replace(results / name, folder / name)
                    undoing.callback(os.replace, folder / name, results / name)
                os.replace(last_manifest, folder / MANIFEST)
                undoing.pop_all()
        except KeyboardInterrupt as stop:
            raise FilledBefore(f"the results in {out} are whole") from stop
        for parent_folder in {(folder / name).parent for name in stale_names} - {folder}:
            with suppress(OSError):  # something is left in it
                parent_folder.rmdir()


@contextmanager
def _alone_in(folder: Path, out: str | Path, *, make: bool = False) -> Generator[None, None, None]:
    """Within this context no other process of this program moves files to `folder`: wait for a lock
    on it.

    Without a lock where the system can't lock a folder (Windows, some networks). A folder that is
    removed meanwhile is made again with `make`, else FileNotFoundError.
    """
    latest_time = time.monotonic() + _PATIENCE
    handle = None
    while fcntl is not None:
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY | os.O_NONBLOCK)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # else it was just replaced
            if os.path.exists(folder) and os.path.samestat(os.fstat(handle), os.stat(folder)):
                break
        except BlockingIOError:
            pass
        except OSError:  # there are no locks here
            break
        os.close(handle)
        if time.monotonic() > latest_time:
            raise InputError(
                f"--out {out}: another process has held this folder for {_PATIENCE:g} s and moves"
                " no files (is it stopped?); end it, or name another folder"
            )
        time.sleep(0.01)
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)
