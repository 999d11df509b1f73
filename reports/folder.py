"""The folder that results go to: checked before any solving, then filled in one go, never half.

Files and folders have a hidden name until they are complete. The name holds the machine and the
process that writes, so that the next run can remove what a killed process left.
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
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from meshes.interrupts import interrupts_wait
from scenes import InputError, files
from scenes.files import parsed_json, text_of

# ------------------------------------------------------------------------------- hidden until whole
# None on Windows, which has other locks.
fcntl = import_module("fcntl") if find_spec("fcntl") else None

# A container numbers its processes itself: a process of another container may have the same number.
_PROCESS_NAMESPACE = Path("/proc/self/ns/pid")
_CONTAINER = _PROCESS_NAMESPACE.readlink() if _PROCESS_NAMESPACE.is_symlink() else ""
_MACHINE_CODE = hashlib.sha256(f"{platform.node()} {_CONTAINER}".encode()).hexdigest()[:6]
_HIDDEN_NAME = re.compile(r"\.halfplane-([0-9a-f]{6})-(?:(\d+)-)?\w{8}")
# Seconds without a change after which a hidden folder counts as abandoned, where it is not known
# whether its process lives.
_SECONDS_UNTIL_ABANDONED = 86400.0


def _hidden_folder(writable_parent: Path, preferred_parent: Path) -> Path:
    """A new hidden folder that only this user can read, made in `writable_parent` and then moved to
    `preferred_parent` where that is possible.

    Raises
    ------
    OSError
        Where it can't be made.
    """
    # Ctrl-C waits until the folder is where it belongs.
    with interrupts_wait():
        path = Path(tempfile.mkdtemp(prefix=_prefix_of_hidden_names(), dir=writable_parent))
        if writable_parent != preferred_parent:
            with suppress(OSError):  # another disk, or a folder of another user
                path = path.rename(preferred_parent / path.name)
    return path


def _prefix_of_hidden_names() -> str:
    """Start of a hidden name: the program, the machine, and the number of this process."""
    return f".halfplane-{_MACHINE_CODE}-{os.getpid()}-"


def _remove_hidden(path: Path) -> None:
    """Remove a hidden file or folder."""
    with interrupts_wait():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def replace_file(path: str | Path, content: bytes | memoryview) -> None:
    """Write the bytes `content` to the file at `path` in one go: a reader sees the old file or the
    new one, never a part.

    Raises
    ------
    OSError
        Where it can't be written; the old file stays.
    """
    file_handle, hidden_file_name = tempfile.mkstemp(
        prefix=_prefix_of_hidden_names(), dir=Path(os.path.realpath(path)).parent
    )
    os.close(file_handle)
    files.replace_file(path, content, Path(hidden_file_name))


def replace_text(path: Path, text: str) -> None:
    """Write a text file at `path` in one go: a reader sees the old file or the new one, never a
    part.

    Raises
    ------
    InputError
        Where it can't be written.
    """
    try:
        remove_left_behind(path.parent)
        with _existing_folder(path.parent):
            replace_file(path, text.encode())
    except OSError as reason:
        raise InputError(
            f"{path}: the file can't be written: {reason.strerror or reason}; name another place"
        ) from reason


@contextmanager
def _existing_folder(folder: Path) -> Generator[None, None, None]:
    """A context in which `folder` exists, with all folders above it. After an error the folders
    that had to be made are removed again, except those that hold something.
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
    """Remove hidden files and folders that killed processes of this program left in `folder`.

    Their names match _HIDDEN_NAME: the program, a code of the machine, and the number of the
    process.
    """
    with suppress(OSError), os.scandir(folder) as entries:
        hidden_paths = [
            Path(entry.path)
            for entry in entries
            if _HIDDEN_NAME.fullmatch(entry.name) and not entry.is_symlink()
        ]
        for path in hidden_paths:
            with suppress(OSError):
                if _is_abandoned(path):
                    _remove_hidden(path)


def _is_abandoned(path: Path) -> bool:
    """Whether the process that made a hidden file or folder has ended. A process of this machine is
    looked up. For another machine, a day without a change counts as the end.
    """
    match = _HIDDEN_NAME.fullmatch(path.name)
    if match and sys.platform != "win32":
        machine, process = match.groups()
        if machine == _MACHINE_CODE and process:
            return _has_ended(int(process))
    last_change = max(inner_path.stat().st_mtime for inner_path in (path, *path.rglob("*")))
    return time.time() - last_change > _SECONDS_UNTIL_ABANDONED


def _has_ended(process: int) -> bool:
    """Whether this machine has no process of that number."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # a process of another user
        return False
    return False


MANIFEST = "manifest.json"
_PAGE_NAME = "report.html"
# Longest wait for another process that moves files to the folder [s]. Files are moved in
# milliseconds: a process that takes longer is stopped.
_LONGEST_WAIT_SECONDS = 60.0
NAMES_OF_RESULTS = (
    MANIFEST,
    _PAGE_NAME,
    "run.log",
    "comparison.json",
    "scene.json",
    "reference.nc",
    "result.nc",
)


def names_of_solution_files(name: str) -> tuple[str, ...]:
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
    """Ctrl-C that came too late: all files had been moved to the folder already."""


def default_folder(name: str) -> Path:
    """out/<name> in the current folder, the name made fit for a file system.

    >>> default_folder("hertz-paper").as_posix(), default_folder("../my scene").as_posix()
    ('out/hertz-paper', 'out/my-scene')
    """
    return Path("out") / (re.sub(r"[^\w.-]+", "-", name).strip("-.") or "scene")


def usable_folder(out: str | Path, names: Iterable[str] = NAMES_OF_RESULTS) -> Path:
    """`out` as a path, once it is sure that results can be written to that folder. The folder
    itself is not made yet. What killed runs left in it and beside it is removed.

    Parameters
    ----------
    out
        the folder as the user named it
    names
        the files that will be written to the folder

    Raises
    ------
    InputError
        Where `out` is a file, can't be made or written to, or holds a file with one of `names` that
        halfplane did not write; where such a file would be written outside through a link, or
        another process holds the folder for a minute.
    """
    folder = Path(out)
    try:
        if folder.exists() and not folder.is_dir():
            raise InputError(
                f"--out {out}: this is a file; results go to a folder, so name another"
            )
        for parent in (folder, _nearest_folder_above(folder)):
            remove_left_behind(parent)
        _remove_hidden(_new_staging_folder(folder))  # proves that files can be written
        # A folder that does not exist yet holds no file of somebody else.
        with suppress(FileNotFoundError), _locked_folder(folder, out):
            _refuse_foreign_files(folder, names, out)
    except OSError as reason:
        raise _error_of_unwritable_folder(out, reason) from reason
    output_folder.set(folder)  # where an internal error writes its log
    return folder


def add_to_log(folder: Path, text: str) -> Path:
    """Append `text` to run.log in `folder`, whose other files stay; returns the path of run.log."""
    with results_folder(folder, stale_prefixes=()) as staging_folder:
        log_file = folder / "run.log"
        text_before = log_file.read_text("utf-8", errors="replace") if log_file.is_file() else ""
        (staging_folder / "run.log").write_text(text_before + text, encoding="utf-8")
    return log_file


@contextmanager
def results_folder(
    out: str | Path, *, stale_prefixes: tuple[str, ...] = ("",), solutions: tuple[str, ...] = ()
) -> Generator[Path, None, None]:
    """A context that yields a temporary folder to write results in. At its end all files move to
    `out`; after an error none does, but for `solutions`.

    Files in `out` that halfplane did not write stay; the manifest in `out` lists those that it
    wrote. Files of an earlier run that are not written again are removed if their names start with
    one of `stale_prefixes`: a page must not stand beside figures of another run. Where two runs
    fill one folder at once, `out` holds the files of the run that moves its own last. If the move
    fails, `out` stays as it was, the new files are kept beside it, and the error names their place.

    Parameters
    ----------
    out
        the folder
    stale_prefixes
        beginnings of the names of earlier files that are removed unless written again; by default
        all of them
    solutions
        names of solution files. After an error other than an InputError or Ctrl-C those written are
        moved to `out`, and a note of the error names them. Where the disk itself fails they are
        kept beside `out`

    Raises
    ------
    InputError
        Where `out` is a file, can't be made or written to, or holds a file that halfplane did not
        write: under a usual name of results (at the start), or a name that was written (at the
        end).
    FilledBefore
        For a Ctrl-C that came while files were moved: all of them have been moved.
    """
    # The folder as a path, checked; and a hidden folder beside it, from which files can be moved to
    # it.
    folder = usable_folder(out)
    is_moving = False
    try:
        staging_folder = _new_staging_folder(folder)
    except OSError as reason:
        raise _error_of_unwritable_folder(out, reason) from reason

    new_results_folder = staging_folder / "results"
    with ExitStack() as cleanup:
        cleanup.callback(_remove_hidden, staging_folder)
        try:
            new_results_folder.mkdir(mode=0o700)
            yield new_results_folder
            is_moving = True
            _move_results(staging_folder, folder, stale_prefixes, out)
        except InputError as fault:
            if not is_moving:
                raise
            cleanup.pop_all()  # nothing is removed
            raise InputError(f"{fault}{_place_of_rescued_files(staging_folder)}") from fault
        except OSError as fault:
            # An error of the disk: of the results' folder, or of a file somewhere else.
            is_about_folder = is_moving or not _is_about_another_file(fault, staging_folder)
            if not is_about_folder:
                _move_solutions(staging_folder, folder, stale_prefixes, out, solutions, fault)
                raise
            sentence = ""
            # `_remove_all_except`: names of the solutions that were written; other files are
            # removed
            if is_moving or _remove_all_except(new_results_folder, solutions):
                cleanup.pop_all()  # nothing is removed
                sentence = _place_of_rescued_files(staging_folder)
            raise InputError(f"{_error_of_unwritable_folder(out, fault)}{sentence}") from fault
        except Exception as fault:
            if not is_moving:
                _move_solutions(staging_folder, folder, stale_prefixes, out, solutions, fault)
            raise


def _place_of_rescued_files(staging_folder: Path) -> str:
    """End of a sentence: the place of the files that could not be moved. The hidden folder
    `staging_folder` becomes visible.
    """
    return f"; what did not get there is kept in {_visible_folder(staging_folder) / 'results'}"


def _remove_all_except(results: Path, names: Iterable[str]) -> list[str]:
    """Remove all files in `results` except those called `names`; returns the names that exist."""
    written_names = [name for name in names if (results / name).is_file()]
    for name in set(_names_of_files(results)) - set(written_names):
        (results / name).unlink()
    return written_names


def _move_solutions(
    staging_folder: Path,
    folder: Path,
    stale_prefixes: tuple[str, ...],
    out: str | Path,
    solutions: tuple[str, ...],
    fault: Exception,
) -> None:
    """After an error (`fault`) save at least the solutions that were written: move them from the
    temporary folder `staging_folder` to `folder`, and add a note to the error that names them.

    Parameters
    ----------
    stale_prefixes
        beginnings of the names of an earlier run's files that are removed
    out
        the folder as the user named it, for messages
    solutions
        names of the files to save
    """
    # a second error must not hide the first
    with suppress(OSError, InputError):
        # Names of the solutions that exist; all other files are removed.
        if written_names := _remove_all_except(staging_folder / "results", solutions):
            _move_results(staging_folder, folder, stale_prefixes, out)
            fault.add_note(
                "the solutions are saved:"
                f" {' and '.join(str(folder / name) for name in written_names)}"
            )


def _is_about_another_file(fault: OSError, staging_folder: Path) -> bool:
    """Whether an error names a file that does not lie in the temporary folder `staging_folder`."""
    return isinstance(fault.filename, str) and not Path(fault.filename).is_relative_to(
        staging_folder
    )


def _visible_folder(staging_folder: Path) -> Path:
    """Rename the hidden temporary folder `staging_folder` so that users see it and no later run
    removes it. Manifests and empty folders in it are removed first.

    Returns the new path, or the old one where the folder can't be renamed.
    """
    try:
        for path in staging_folder.iterdir():
            if path.is_file():
                path.unlink()
            elif not _names_of_files(path):
                shutil.rmtree(path)
        return staging_folder.rename(
            staging_folder.with_name(f"halfplane-kept-{staging_folder.name[-8:]}")
        )
    except OSError:
        return staging_folder


def _error_of_unwritable_folder(out: str | Path, reason: OSError) -> InputError:
    """The error for a folder `out` that can't be written to."""
    return InputError(
        f"--out {out}: the folder can't be written to: {reason.strerror or reason}; name another"
    )


def _refuse_foreign_files(folder: Path, names: Iterable[str], out: str | Path) -> None:
    """Refuse (InputError) a folder that holds a file with one of `names` which no manifest of this
    program lists. Refuse one, too, in which a link would lead such a file out of the folder.

    `out` is the folder as the user named it, for the message.
    """
    # Where folders can't be locked, another run may move its files now. It moves its manifest
    # first: so the manifest is read last.
    existing_names = {name for name in names if os.path.lexists(folder / name)}
    for name in sorted(set(names) - set(_files_in_manifest(folder))):
        if not _lies_inside(folder, name):
            raise InputError(
                f"--out {out}: {name} would be written outside, through a link; name another folder"
            )
        if name in existing_names:
            raise InputError(
                f"--out {out}: {name} is there already and halfplane did not write it; name another"
                " folder or move it"
            )


def _nearest_folder_above(folder: Path) -> Path:
    """The nearest folder above `folder` that exists."""
    return next(path for path in Path(os.path.abspath(folder)).parents if path.exists())


def _new_staging_folder(folder: Path) -> Path:
    """A new empty hidden folder, from which files can be moved to `folder`; OSError if it can't be
    made.

    It lies beside `folder` where possible. Else it lies in it: the folder above may be on another
    disk or belong to another user.
    """
    folder_above = _nearest_folder_above(folder)
    writable_parent = folder if folder.is_dir() else folder_above
    return _hidden_folder(writable_parent, folder_above)


def _names_of_files(folder: Path) -> list[str]:
    """Names of all files in `folder` and in the folders below, as paths relative to it, sorted."""
    return sorted(
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
    )


def _write_manifest(path: Path, names: Iterable[str]) -> Path:
    """Write a manifest that lists `names` and itself to `path`; returns `path`."""
    text = json.dumps({"written by": "halfplane", "files": sorted({*names, MANIFEST})}, indent=1)
    path.write_text(text + "\n", encoding="utf-8")
    return path


def _files_in_manifest(folder: Path) -> list[str]:
    """Names of files in `folder` that an earlier run listed in its manifest; none without a
    manifest of this program.

    The manifest is a JSON file with the keys "written by" and "files".
    """
    try:
        # MANIFEST: "manifest.json"
        manifest = parsed_json(text_of(folder / MANIFEST, "the manifest"))
    except (OSError, ValueError):
        return []
    if not isinstance(manifest, dict) or manifest.get("written by") != "halfplane":
        return []
    names = manifest.get("files")
    if not isinstance(names, list):
        return []
    return [name for name in names if isinstance(name, str) and _lies_inside(folder, name)]


def _lies_inside(folder: Path, name: str) -> bool:
    """Whether a file of that name lies in `folder` itself: not above it, and not behind a link that
    leads out of it.
    """
    try:
        return bool(name) and (folder / name).parent.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError):
        return False


@dataclass(frozen=True)
class _NamesOfFiles:
    """Names of the files of a folder that a run fills, as paths relative to the folder.

    Attributes
    ----------
    new
        files that the run wrote
    earlier
        files that earlier runs of this program wrote, and this run does not write again
    stale
        those of `earlier` that are removed
    replaced
        files in the folder that are moved away, `new` or `stale` by their names; the page first
    """

    new: list[str]
    earlier: set[str]
    stale: set[str]
    replaced: list[str]


def _names_of_exchange(
    folder: Path, new_names: list[str], stale_prefixes: tuple[str, ...]
) -> _NamesOfFiles:
    """Which files of a folder stay, go and are replaced when a run moves its files there. Files of
    earlier runs are known by the manifest of the folder; those whose names begin with one of
    `stale_prefixes` go.

    `new_names` are the names of the files that this run wrote.
    """
    # MANIFEST: "manifest.json"
    earlier_names = set(_files_in_manifest(folder)) - {*new_names, MANIFEST}
    stale_names = {name for name in earlier_names if name.startswith(stale_prefixes)}
    replaced_names = sorted(
        (name for name in {*new_names, *stale_names} if os.path.lexists(folder / name)),
        key=_page_first,
    )
    return _NamesOfFiles(new_names, earlier_names, stale_names, replaced_names)


def _page_first(name: str) -> tuple[bool, str]:
    """Key that sorts names of files: the page, report.html, then the others by their letters."""
    return name != _PAGE_NAME, name


def _move_results(
    staging_folder: Path, folder: Path, stale_prefixes: tuple[str, ...], out: str | Path
) -> None:
    """Move the results of a run from the hidden folder `staging_folder` to `folder`. The old page
    leaves first, the new page arrives last. After an error everything is as it was before.

    A manifest in the folder lists the files that this program wrote. The manifest that is moved
    before any file lists old and new files; the one that is moved last lists the new ones. So, if a
    run is killed between two moves, the next run still recognises every file as this program's own.

    Parameters
    ----------
    staging_folder
        its folder "results" holds the new files
    folder
        where they go
    stale_prefixes
        beginnings of the names of earlier files that are removed unless written again
    out
        the folder as the user named it, for messages

    Raises
    ------
    InputError
        Where the folder holds a file under a new name that this program did not write.
    FilledBefore
        For a Ctrl-C that came while files were moved: all of them have been moved.
    """
    new_names = _names_of_files(staging_folder / "results")
    # The folder exists and is locked against other runs; `inner_folders` makes folders in it.
    with (
        _existing_folder(folder),
        _locked_folder(folder, out, make=True),
        ExitStack() as inner_folders,
    ):
        _refuse_foreign_files(folder, new_names, out)
        names = _names_of_exchange(folder, new_names, stale_prefixes)
        for parent in {(folder / name).parent for name in names.new} - {folder}:
            inner_folders.enter_context(_existing_folder(parent))
        try:
            with interrupts_wait():
                _exchange_files(staging_folder, folder, names)
        except KeyboardInterrupt as stop:
            raise FilledBefore(f"the results in {out} are whole") from stop

        # Folders that hold nothing any more.
        for parent_folder in {(folder / name).parent for name in names.stale} - {folder}:
            with suppress(OSError):  # the folder is not empty
                parent_folder.rmdir()


def _exchange_files(staging_folder: Path, folder: Path, names: _NamesOfFiles) -> None:
    """Move the replaced files of a folder to `staging_folder`/"before", and the new ones from
    `staging_folder`/"results" to the folder, manifests around them. If a move fails, all those
    before it are undone, the last first.

    `names` are those of the new files, of earlier ones, and of those that are replaced.
    """
    new_results_folder = staging_folder / "results"
    old_results_folder = staging_folder / "before"
    first_manifest = _write_manifest(staging_folder / "begun.json", {*names.new, *names.earlier})
    last_manifest = _write_manifest(
        staging_folder / "ended.json", {*names.new, *(names.earlier - names.stale)}
    )
    for name in names.replaced:
        (old_results_folder / name).parent.mkdir(parents=True, exist_ok=True)
    # undo_steps: what is called if one of the moves fails
    with ExitStack() as undo_steps:
        if os.path.lexists(folder / MANIFEST):
            old_manifest = staging_folder / MANIFEST
            shutil.copyfile(folder / MANIFEST, old_manifest)
            undo_steps.callback(os.replace, old_manifest, folder / MANIFEST)
        else:
            undo_steps.callback((folder / MANIFEST).unlink, missing_ok=True)
        os.replace(first_manifest, folder / MANIFEST)
        for name in names.replaced:
            os.rename(folder / name, old_results_folder / name)
            undo_steps.callback(os.rename, old_results_folder / name, folder / name)
        for name in sorted(names.new, key=lambda name: (name == _PAGE_NAME, name)):
            os.replace(new_results_folder / name, folder / name)
            undo_steps.callback(os.replace, folder / name, new_results_folder / name)
        os.replace(last_manifest, folder / MANIFEST)
        undo_steps.pop_all()


@contextmanager
def _locked_folder(
    folder: Path, out: str | Path, *, make: bool = False
) -> Generator[None, None, None]:
    """A context in which no other process of this program moves files to `folder`: it waits for a
    lock on the folder, tried every 10 ms.

    Where the system can't lock a folder (Windows, some networks) there is no lock. If the folder is
    absent, it is made with `make`; without it FileNotFoundError. `out` is the folder as the user
    named it, for the message.

    Raises
    ------
    InputError
        Where another process holds the lock for a minute.
    """
    # _LONGEST_WAIT_SECONDS: 60 s
    latest_time = time.monotonic() + _LONGEST_WAIT_SECONDS
    folder_handle = None
    while fcntl is not None:
        if make:
            folder.mkdir(parents=True, exist_ok=True)
        folder_handle = os.open(folder, os.O_RDONLY | os.O_NONBLOCK)
        try:
            fcntl.flock(folder_handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # a folder that was just replaced by another one has to be opened again
            if os.path.exists(folder) and os.path.samestat(
                os.fstat(folder_handle), os.stat(folder)
            ):
                break
        except BlockingIOError:
            pass
        except OSError:  # this file system has no locks
            break
        os.close(folder_handle)
        if time.monotonic() > latest_time:
            raise InputError(
                f"--out {out}: another process has held this folder for {_LONGEST_WAIT_SECONDS:g} s"
                " and moves no files (is it stopped?); end it, or name another folder"
            )
        time.sleep(0.01)
    try:
        yield
    finally:
        if folder_handle is not None:
            os.close(folder_handle)
