"""Condensed bodies on disk, by content: mesh, material, support and the code that condensed them.

The folder is $HALFPLANE_CACHE, else `halfplane` in $XDG_CACHE_HOME or ~/.cache; HALFPLANE_CACHE=off keeps nothing. Files are npz
without pickle, written to a temporary name and moved, so that a reader never sees half of one; the oldest give way once the folder
outgrows its bound. What is read is checked twice: it has the digest that was written with it, and it is the compliance of this very
mesh, material and support under a random load (`condensation_error`). A file that fails is refused with a note, condensed again and
replaced; a folder that can't be written to is done without. `work` counts both.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import skfem
from numpy.typing import NDArray

from halfplane_fe.elasticity import LARGEST_ERROR, CondensedBody, arc_loads, assemble, condensation_error, condense, condensed_body
from meshes import BodyMesh
from scenes import Elastic
from scenes.files import source_digest

_BOUND_BYTES = 1_000_000_000
_LEFT_BEHIND = 3600.0  # seconds: no write takes an hour
# What is raised over a file that was cut off, spoilt, or says that it holds more than there is memory.
_SPOILT = (OSError, ValueError, KeyError, EOFError, MemoryError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error)
_SOURCES = ("halfplane_fe", "meshes", "scenes")  # what a condensed body follows from, whatever part of it
_LIBRARIES = ("numpy", "scipy", "scikit-fem")
# What `work` counts a refused file under, before the reason.
_REFUSED = "stored condensations refused: "


def cache_folder() -> Path | None:
    """Where condensed bodies are kept; None where nothing shall or can be."""
    if switched_off():
        return None
    if asked := os.environ.get("HALFPLANE_CACHE"):
        return Path(asked)
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "halfplane"
    except RuntimeError:  # a user without a home
        return None


def switched_off() -> bool:
    """Whether the user wants none."""
    return os.environ.get("HALFPLANE_CACHE", "").lower() == "off"


def condensed(body: BodyMesh, material: Elastic, datum_length: float, work: Counter[str]) -> CondensedBody:
    """The condensed body, from the store or made now and stored; `work` counts which."""
    folder = cache_folder()
    path = None if folder is None else folder / f"{_key(body, material, datum_length)}.npz"
    if path is not None and (found := _read(path, body, material, datum_length, work)):
        work["condensations from the store"] += 1
        return found
    made = condense(body, material, datum_length)
    work["condensations"] += 1
    work["sparse factorisations"] += int(made.diagnostics["sparse_factorisations"])
    if path is not None:
        _write(path, made, work)
    elif not switched_off():
        work["condensations not stored"] += 1
    return made


def refusals(work: Mapping[str, int]) -> Iterator[str]:
    """A sentence for each reason for which stored bodies were refused."""
    for name, count in work.items():
        before, refused, why = name.partition(_REFUSED)
        if refused:
            replaced = "not replaced: remove it" if work.get(f"{before}condensations not stored") else "replaced"
            yield (
                f"the store of condensed bodies ({cache_folder()}): {count} of the {before}condensations read there "
                f"{'was' if count == 1 else 'were'} refused, since the file {why}; condensed again, and {replaced}"
            )


def _key(body: BodyMesh, material: Elastic, datum_length: float) -> str:
    """Digest of every input of the condensation, whatever fields it has, and of the code."""
    digest = hashlib.sha256()
    inputs = {"body": body, "material": material, "datum_length": float(datum_length)}
    for part in _parts({**inputs, "code": source_digest(*_SOURCES), **{name: version(name) for name in _LIBRARIES}}):
        digest.update(part)
    return digest.hexdigest()


def _parts(value: Any) -> Iterator[bytes]:
    """A value as bytes, field by field: others for any other value. TypeError for a kind that has no place in a key."""
    match value:
        case np.ndarray():
            yield from (repr((value.dtype.str, value.shape)).encode(), np.ascontiguousarray(value).tobytes())
        case skfem.Mesh():
            yield from _parts({"kind": type(value).__name__, "p": value.p, "t": value.t, "boundaries": dict(value.boundaries)})
        case Mapping():
            yield f"{len(value)} of a mapping".encode()
            for name in sorted(value):
                yield from (repr(name).encode(), *_parts(value[name]))
        case Elastic():
            yield value.model_dump_json().encode()
        case None | bool() | int() | float() | str():
            yield repr(value).encode()
        case _ if is_dataclass(value):
            yield from _parts({field.name: getattr(value, field.name) for field in fields(value)})
        case _:
            raise TypeError(f"the key of a stored body has no place for {value!r}")


def _read(path: Path, body: BodyMesh, material: Elastic, datum_length: float, work: Counter[str]) -> CondensedBody | None:
    """The condensed body of a file; None where there is none, or none that stands up to both checks."""
    try:
        with _opened(path) as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in ("compliance", "probe", "by_stress", "names", "figures")}
            if str(stored["digest"]) != _digest(path.stem, arrays):
                raise _RefusedError("has not the content that was written (its digest is another)")
        found = _checked(arrays, body, material, datum_length)
    except FileNotFoundError:
        return None
    except _RefusedError as reason:
        work[f"{_REFUSED}{reason}"] += 1
        return None
    except _SPOILT:
        work[f"{_REFUSED}can't be read"] += 1
        return None
    with suppress(OSError):  # somebody else's store, or gone since; what was read stands
        os.utime(path)  # the store forgets what was used longest ago
    return found


class _RefusedError(ValueError):
    """Why a stored file is not taken, as the end of a sentence."""


def _opened(path: Path) -> BinaryIO:
    """A regular file to read from; others are never opened: a FIFO would wait for a writer, a device may do anything."""
    if not stat.S_ISREG(path.stat().st_mode):
        raise _RefusedError("is no regular file")
    # Should it be one no more by now, this does not wait either.
    return os.fdopen(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb")


def _digest(key: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Of what a file holds, under its own key only."""
    digest = hashlib.sha256(key.encode())
    for part in _parts(arrays):
        digest.update(part)
    return digest.hexdigest()


def _checked(arrays: Mapping[str, NDArray[Any]], body: BodyMesh, material: Elastic, datum_length: float) -> CondensedBody:
    """The condensed body, if it is the one of this mesh and material: the key and the digest are not all that speaks for it."""
    system = assemble(body, material)
    compliance, probe, by_stress, shape = arrays["compliance"], arrays["probe"], arrays["by_stress"], system.contact.shape
    forms = compliance.shape == (*shape, *shape) and probe.shape == (system.n_dofs,)
    forms &= by_stress.shape == (shape if system.around or system.pull.any() else (2, 1))
    if not (forms and all(np.isfinite(values).all() for values in (compliance, probe, by_stress))):
        raise _RefusedError("holds arrays of another form")
    error = condensation_error(system, arc_loads(system, datum_length), compliance, probe, by_stress)
    if not error <= LARGEST_ERROR:
        raise _RefusedError(f"holds another compliance than that of the mesh (by {error:.1e})")
    figures = {str(name): float(value) for name, value in zip(arrays["names"], arrays["figures"], strict=True)}
    return condensed_body(body, system, compliance, probe, by_stress, figures)


def _write(path: Path, made: CondensedBody, work: Counter[str]) -> None:
    names, figures = np.array(list(made.diagnostics)), np.array(list(made.diagnostics.values()))
    arrays: dict[str, Any] = {name: getattr(made, name) for name in ("compliance", "probe", "by_stress")}
    arrays |= {"names": names, "figures": figures}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(suffix=".part", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez(file, **arrays, digest=_digest(path.stem, arrays))
            os.replace(temporary, path)
        except BaseException:
            Path(temporary).unlink(missing_ok=True)
            raise
    except OSError:
        work["condensations not stored"] += 1
    else:
        _prune(path.parent)


def _prune(folder: Path) -> None:
    """Remove the longest unused files until the folder is within its bound, and what killed processes left half-written."""
    for left, used, _ in _listed(folder, ".part"):
        if time.time() - used > _LEFT_BEHIND:
            _remove(left)
    files = sorted(_listed(folder, ".npz"), key=lambda file: file[1])
    total = sum(size for _, _, size in files)
    for file, _, size in files:
        if total <= _BOUND_BYTES:
            return
        total -= size
        _remove(file)


def _listed(folder: Path, suffix: str) -> list[tuple[Path, float, int]]:
    """Files of the store as (path, time of last use, bytes); without those that another process removes meanwhile."""
    found = []
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith(suffix):
                with suppress(FileNotFoundError):
                    status = os.stat(entry.path)
                    found += [] if not stat.S_ISREG(status.st_mode) else [(Path(entry.path), status.st_mtime, status.st_size)]
    return found


def _remove(path: Path) -> None:
    with suppress(OSError):  # another process was faster, or it is another user's: then that user's processes prune it
        path.unlink()


def stored_bytes() -> tuple[int, int]:
    """Number of stored bodies, and their bytes."""
    folder = cache_folder()
    sizes = [size for _, _, size in _listed(folder, ".npz")] if folder is not None else []
    return len(sizes), sum(sizes)
