"""The store of a sweep: one file for each result, under the address of its question. No pickle, no lock, never half a file.

DIR/sweep.json           the study as it was asked, the address and coordinates of every point
DIR/results/<address>.json
DIR/results/<address>.bad-<n>   results whose checksum is wrong, set aside
DIR/claims/<address>     who is at work on a point
DIR/index.csv            one row for each point that has a result; made anew from the above
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reports.staging import remove_left_behind, replace_file
from scenes import InputError
from scenes.errors import shown
from scenes.files import parsed_json

_FORMAT = "halfplane sweep 1"
_ADDRESS = re.compile("[0-9a-f]{64}")
_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_NO_ROOM_WORDS = "there is no room left on the disk"


class StoreError(InputError):
    """The store can't be written to: one sentence; what was stored before stays."""


@dataclass(frozen=True)
class Planned:
    """What a store says of a point: number, address, coordinates."""

    number: int
    address: str
    coordinates: Mapping[str, Any]


@dataclass(frozen=True)
class Store:
    """A folder of results; what is set aside is reported through `damaged`."""

    folder: Path

    @property
    def results(self) -> Path:
        """Folder of the results."""
        return self.folder / "results"

    @property
    def claims(self) -> Path:
        """Folder of the claims."""
        return self.folder / "claims"

    def path(self, address: str) -> Path:
        """Where the result of an address is."""
        return self.results / f"{address}.json"

    def addresses(self) -> set[str]:
        """Of all results, whole or not."""
        return {name.removesuffix(".json") for name in names(self.results) if name.endswith(".json") and len(name) == 69}

    def damaged(self) -> list[str]:
        """Names of the results that were set aside."""
        return sorted(name for name in names(self.results) if ".bad-" in name)

    def prepare(self) -> None:
        """Make the folders, and remove what killed sweeps left in them half-written; StoreError where that can't be."""
        with _writing(self.folder):
            for folder in (self.results, self.claims):
                folder.mkdir(parents=True, exist_ok=True)
                remove_left_behind(folder)

    def write(self, result: Mapping[str, Any]) -> None:
        """Store a result under its address; the last of two writers wins, and both wrote the same."""
        body = canonical(result)
        text = json.dumps({"format": _FORMAT, "sha256": _sum(body), "result": json.loads(body)}, indent=1) + "\n"
        self.write_text(self.path(str(result["address"])), text)

    def write_text(self, path: Path, text: str) -> None:
        """Write a file of text in one go, as `write_bytes` does."""
        self.write_bytes(path, text.encode())

    def write_bytes(self, path: Path, content: bytes) -> None:
        """Write a file in one go; StoreError where that can't be."""
        with _writing(self.folder):
            replace_file(path, content)

    def stored_at(self, address: str) -> float | None:
        """When a result was stored, in seconds of the epoch; None where there is none any more."""
        try:
            return self.path(address).stat().st_mtime
        except FileNotFoundError:
            return None

    def read(self, address: str) -> dict[str, Any] | None:
        """The result of an address; None where there is none. A file that is damaged is set aside, and there is none.

        Raises
        ------
        StoreError
            Where the file is there and can't be read.
        """
        path = self.path(address)
        try:
            stored = parsed_json(path.read_text(encoding="utf-8"))
            result = stored["result"]
            whole = stored["format"] == _FORMAT and stored["sha256"] == _sum(canonical(result)) and result["address"] == address
        except FileNotFoundError:
            return None
        except OSError as reason:
            why = reason.strerror or reason
            raise StoreError(f"{path}: this result can't be read: {why}; mend that, or name another --out") from reason
        except (ValueError, KeyError, TypeError, UnicodeDecodeError):
            whole = False
        if whole:
            return dict(result)
        self._set_aside(path)
        return None

    def _set_aside(self, path: Path) -> None:
        number = sum(name.startswith(f"{path.stem}.bad-") for name in names(self.results))
        with _writing(self.folder):
            try:
                os.replace(path, path.with_suffix(f".bad-{number}"))
            except FileNotFoundError:
                return  # another sweep was faster

    def write_plan(self, study: Mapping[str, Any], points: Sequence[Planned]) -> None:
        """Store what is asked: the study and its points."""
        rows = [{"number": p.number, "address": p.address, "coordinates": dict(p.coordinates)} for p in points]
        self.write_text(self.folder / "sweep.json", json.dumps({"format": _FORMAT, "study": study, "points": rows}) + "\n")

    def read_plan(self) -> tuple[dict[str, Any], tuple[Planned, ...]]:
        """The study and the points that were asked.

        Raises
        ------
        InputError
            Where the folder holds no sweep, or its sweep.json can't be read.
        """
        path = self.folder / "sweep.json"
        try:
            stored = parsed_json(path.read_text(encoding="utf-8"))
            points = tuple(Planned(int(p["number"]), _address(p["address"]), dict(p["coordinates"])) for p in stored["points"])
            return dict(stored["study"]), points
        except FileNotFoundError:
            raise InputError(
                f"{self.folder}: no sweep is stored here; `halfplane sweep STUDY.toml --out {self.folder}` starts one"
            ) from None
        except (OSError, ValueError, KeyError, TypeError) as reason:
            raise InputError(f"{path}: can't be read ({reason}); start the sweep again with --resume: results are kept") from reason


def _address(text: Any) -> str:
    """An address out of a file: 64 hexadecimal digits, for it becomes the name of one."""
    if not isinstance(text, str) or not _ADDRESS.fullmatch(text):
        raise ValueError(f"{shown(text)} is no address of a result")
    return text


def unwritable(folder: Path, reason: OSError) -> StoreError:
    """The sentence of an OSError."""
    why = _NO_ROOM_WORDS if reason.errno in _NO_ROOM else reason.strerror or str(reason)
    return StoreError(f"{folder}: results can't be stored: {why}; what was stored before stays")


def canonical(value: Any) -> str:
    """JSON with sorted keys and no NaN: the same text for the same value."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def _sum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def names(folder: Path) -> Iterator[str]:
    """Of the files in a folder of the store; of none where it is gone."""
    with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        yield from [entry.name for entry in entries]


class _writing:
    """Turns an OSError into the sentence of a StoreError."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def __enter__(self) -> None:
        return None

    def __exit__(self, _kind: object, reason: BaseException | None, _trace: object) -> None:
        if isinstance(reason, OSError):
            raise unwritable(self._folder, reason) from reason
