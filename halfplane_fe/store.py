"""Condensed bodies on disk, by content: mesh, material, support and the code that condensed them.

The folder is $HALFPLANE_CACHE, else `halfplane` in $XDG_CACHE_HOME or ~/.cache; HALFPLANE_CACHE=off keeps nothing. Files are npz
without pickle, whole or not there; the longest unused give way once the folder outgrows its bound. A file without the digest that
was written with it is refused with a note, condensed again and replaced; a folder that can't be written to is done without. `work`
counts both.
"""

from __future__ import annotations

import hashlib
import io
import os
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import skfem
from numpy.typing import NDArray

from halfplane_fe.elasticity import CondensedBody, condense
from meshes import BodyMesh
from scenes import Elastic, InputError, freeze
from scenes.files import check_size, replace_file, source_digest

_BOUND_BYTES = 1_000_000_000
_LEFT_BEHIND = 3600.0  # seconds: no write takes an hour
# What is raised over a file that was cut off, spoilt, or says that it holds more than there is memory.
_SPOILT = (OSError, InputError, ValueError, KeyError, EOFError, MemoryError, RuntimeError, zipfile.BadZipFile, zlib.error)
_ARRAYS = ("x", "y", "weights", "compliance", "by_stress")
# What `work` counts a refused file, and one that could not be written, under.
_REFUSED, _NOT_STORED = "stored condensations refused", "condensations not stored"


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
        work[_NOT_STORED] += 1
    return made


def refusals(work: Mapping[str, int]) -> Iterator[str]:
    """A sentence about stored bodies that were refused."""
    for run in ("", "coarse "):
        if count := work.get(f"{run}{_REFUSED}"):
            yield (
                f"the store of condensed bodies ({cache_folder()}): {count} of the {run}condensations read there "
                f"{'was' if count == 1 else 'were'} refused, since the file can't be read or has not the content that was written; "
                f"condensed again, and {'not replaced: remove it' if work.get(f'{run}{_NOT_STORED}') else 'replaced'}"
            )


def _key(body: BodyMesh, material: Elastic, datum_length: float) -> str:
    """Digest of every input of the condensation, whatever fields it has, and of the code that it follows from."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "scikit-fem")}
    code = source_digest("halfplane_fe", "meshes", "scenes")
    return _digest({"body": body, "material": material, "datum_length": float(datum_length), "code": code, **libraries})


def _digest(value: Any) -> str:
    digest = hashlib.sha256()
    for part in _parts(value):
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


def _read(path: Path, body: BodyMesh, material: Elastic, work: Counter[str]) -> CondensedBody | None:
    """The condensed body of a file; None where there is none, or one that has not the digest that was written."""
    try:
        check_size(path, "a stored body", _BOUND_BYTES)  # and no FIFO, which would wait for a writer
        with path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in (*_ARRAYS, "names", "figures")}
            if str(stored["digest"]) != _digest({"key": path.stem, **arrays}):
                raise ValueError("another content")
        figures = dict(zip(arrays["names"].tolist(), arrays["figures"].tolist(), strict=True))
        found = CondensedBody(body, material, **{name: freeze(arrays[name]) for name in _ARRAYS}, diagnostics=figures)
    except FileNotFoundError:
        return None
    except _SPOILT:
        work[_REFUSED] += 1
        return None
    with suppress(OSError):  # somebody else's store, or gone since; what was read stands
        os.utime(path)  # the store forgets what was used longest ago
    return found


def _write(path: Path, made: CondensedBody, work: Counter[str]) -> None:
    arrays: dict[str, NDArray[Any]] = {name: getattr(made, name) for name in _ARRAYS}
    arrays |= {"names": np.array(list(made.diagnostics)), "figures": np.array(list(made.diagnostics.values()))}
    content = io.BytesIO()
    np.savez(content, **arrays, digest=np.array(_digest({"key": path.stem, **arrays})))  # type: ignore[arg-type]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.unlink(missing_ok=True)  # what is refused may be a link to anywhere
        replace_file(path, content.getbuffer())
    except OSError:
        work[_NOT_STORED] += 1
    else:
        _prune(path.parent)


def _prune(folder: Path) -> None:
    """Remove the longest unused files until the folder is within its bound, and what killed processes left half-written."""
    files = sorted(_listed(folder), key=lambda file: file[1])
    total = sum(size for path, _, size in files if path.suffix == ".npz")
    for path, used, size in files:
        if path.suffix == ".npz" and total > _BOUND_BYTES:
            total -= size
        elif path.suffix == ".npz" or time.time() - used <= _LEFT_BEHIND:
            continue
        with suppress(OSError):  # another process was faster, or it is another user's: then that user's processes prune it
            path.unlink()


def _listed(folder: Path) -> list[tuple[Path, float, int]]:
    """Files of the store, and what writers have left, as (path, time of last use, bytes)."""
    found = []
    with suppress(OSError):
        for path in (*folder.glob("*.npz"), *folder.glob(".halfplane-*")):
            with suppress(FileNotFoundError):  # removed meanwhile
                status = path.lstat()
                found.append((path, status.st_mtime, status.st_size))
    return found


def stored_bytes() -> tuple[int, int]:
    """Number of stored bodies, and their bytes."""
    folder = cache_folder()
    sizes = [size for path, _, size in _listed(folder) if path.suffix == ".npz"] if folder is not None else []
    return len(sizes), sum(sizes)
