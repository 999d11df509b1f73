"""Condensed bodies on disk, by content: mesh, material, support and the code that condensed them.

The folder is $HALFPLANE_CACHE, else `halfplane` in $XDG_CACHE_HOME or ~/.cache; HALFPLANE_CACHE=off keeps nothing. Files are npz
without pickle, written to a temporary name and moved, so that a reader never sees half of one; the oldest give way once the folder
outgrows its bound. A file that can't be read is made anew, a folder that can't be written to is done without: `work` counts both.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from halfplane_fe import assembly, elasticity, far_field
from halfplane_fe.elasticity import CondensedBody, condense
from meshes import BodyMesh
from scenes import Elastic, freeze

_BOUND_BYTES = 1_000_000_000
_LEFT_BEHIND = 3600.0  # seconds: no write takes an hour
# What is raised over a file that was cut off, spoilt, or says that it holds more than there is memory.
_SPOILT = (OSError, ValueError, KeyError, EOFError, MemoryError, NotImplementedError, RuntimeError, zipfile.BadZipFile, zlib.error)
SOURCES = (assembly, elasticity, far_field)  # what a condensed body follows from
_ARRAYS = ("x", "y", "weights", "compliance")


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
    if path is not None and (found := _read(path, body, material, work)):
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


def _key(body: BodyMesh, material: Elastic, datum_length: float) -> str:
    """Digest of everything that the answer depends on, the code included."""
    digest = hashlib.sha256()
    mesh = body.mesh
    for array in (mesh.p, mesh.t, *(mesh.boundaries[name] for name in sorted(mesh.boundaries))):
        digest.update(np.ascontiguousarray(array).tobytes())
    for module in SOURCES:
        digest.update(Path(str(module.__file__)).read_bytes())
    words = [material.model_dump_json(), repr(float(datum_length)), *sorted(mesh.boundaries), repr(sorted(body.supports.items()))]
    words += [version(name) for name in ("numpy", "scipy", "scikit-fem")]
    digest.update("|".join(words).encode())
    return digest.hexdigest()


def _read(path: Path, body: BodyMesh, material: Elastic, work: Counter[str]) -> CondensedBody | None:
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: freeze(stored[name]) for name in _ARRAYS}
            names, values = stored["diagnostic_names"], stored["diagnostic_values"]
        diagnostics = {str(name): float(value) for name, value in zip(names, values, strict=True)}
        _check_form(arrays)
    except FileNotFoundError:
        return None
    except _SPOILT:
        work["stored condensations unreadable"] += 1
        return None
    with suppress(OSError):  # somebody else's store, or gone since; what was read stands
        os.utime(path)  # the store forgets what was used longest ago
    return CondensedBody(body, material, **arrays, diagnostics=diagnostics)


def _check_form(arrays: Mapping[str, NDArray[np.float64]]) -> None:
    """ValueError for arrays that are not those of a condensed body: the store is a folder that others may write to."""
    count = len(arrays["x"])
    shapes = {"x": (count,), "y": (count,), "weights": (count,), "compliance": (2, count, 2, count)}
    for name, shape in shapes.items():
        if arrays[name].shape != shape or not np.isfinite(arrays[name]).all():
            raise ValueError(f"{name} is not finite of shape {shape}")


def _write(path: Path, made: CondensedBody, work: Counter[str]) -> None:
    arrays = {name: getattr(made, name) for name in _ARRAYS}
    arrays["diagnostic_names"] = np.array(list(made.diagnostics))
    arrays["diagnostic_values"] = np.array(list(made.diagnostics.values()))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(suffix=".part", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                np.savez(file, **arrays)
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
                    found.append((Path(entry.path), status.st_mtime, status.st_size))
    return found


def _remove(path: Path) -> None:
    with suppress(OSError):  # another process was faster, or it is another user's: then that user's processes prune it
        path.unlink()


def stored_bytes() -> tuple[int, int]:
    """Number of stored bodies, and their bytes."""
    folder = cache_folder()
    sizes = [size for _, _, size in _listed(folder, ".npz")] if folder is not None else []
    return len(sizes), sum(sizes)
