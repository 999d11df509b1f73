"""The store of a sweep: one file for each result, under the address of its question; its table.

DIR/sweep.json           the study as it was asked, the address and coordinates of every point
DIR/results/<address>.json
DIR/results/<address>.bad       a result whose checksum is wrong, set aside
DIR/index.csv            one row for each point that has a result; made again from the above

No pickle, never half a file, and right whoever writes: two writers of one address write the same.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import re
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pandas as pd

from reports.charts.templating import table_text
from reports.folder import remove_left_behind, replace_file
from scenes import InputError
from scenes.errors import shortened_repr
from scenes.files import parsed_json

_FORMAT = "halfplane sweep 1"  # name of the format in each file
_ADDRESS = re.compile("[0-9a-f]{64}")
# Columns of the table on how each point went, behind those of coordinates and quantities.
STATUS_COLUMNS = ("status", "seconds", "reason", "notes", "address")


class StoreError(InputError):
    """The store can't be written to: one sentence; what was stored before stays."""


@dataclass(frozen=True)
class PlannedPoint:
    """What a store holds of a point: number, address of its result, coordinates."""

    number: int
    address: str
    coordinates: Mapping[str, Any]


@dataclass(frozen=True)
class Store:
    """A folder of results."""

    folder: Path

    @property
    def result_folder(self) -> Path:
        """Folder of the results."""
        return self.folder / "results"

    def path(self, address: str) -> Path:
        """Path of the file with the result of an address."""
        return self.result_folder / f"{address}.json"

    def _result_names(self, pattern: str) -> list[str]:
        """Names of the files of results that match a pattern such as "*.json"; their stem is an
        address.
        """
        paths = self.result_folder.glob(pattern)
        return sorted(path.name for path in paths if _ADDRESS.fullmatch(path.stem))

    def addresses(self) -> set[str]:
        """Addresses of all stored results, whether their files are whole or not."""
        return {name[:64] for name in self._result_names("*.json")}

    def damaged(self) -> list[str]:
        """Names of the files of results that were damaged and set aside."""
        return self._result_names("*.bad")

    def prepare(self) -> None:
        """Make the folders, and remove what killed sweeps left in them; StoreError where that can't
        be.
        """
        with self._writing():
            self.result_folder.mkdir(parents=True, exist_ok=True)
            remove_left_behind(self.result_folder)

    def write(self, answer: Mapping[str, Any]) -> None:
        """Store the result of a point under its address, with format and checksum; the last of two
        writers wins, and both wrote the same.
        """
        body = canonical_json(answer)
        content = {"format": _FORMAT, "sha256": checksum(body), "result": json.loads(body)}
        text = json.dumps(content, indent=1) + "\n"
        self.write_text(self.path(str(answer["address"])), text)

    def write_text(self, path: Path, text: str) -> None:
        """Write a file of text in one go; StoreError where that can't be."""
        with self._writing():
            replace_file(path, text.encode())

    @contextmanager
    def _writing(self) -> Generator[None, None, None]:
        """A context in which an error of the system becomes a StoreError with the reason: results
        can't be stored.
        """
        try:
            yield
        except OSError as reason:
            cause = reason.strerror or str(reason)
            if reason.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
                cause = "there is no room left on the disk"
            raise StoreError(
                f"{self.folder}: results can't be stored: {cause}; what was stored before stays"
            ) from reason

    def read(self, address: str) -> dict[str, Any] | None:
        """The stored result of an address, which is a hash of the scene and settings that were
        solved; None where there is no result.

        A file with another format (`_FORMAT`), checksum or address is damaged: it is set aside
        under a name that ends in .bad, and None is returned. StoreError where the file is there and
        can't be read.
        """
        path = self.path(address)
        try:
            # {"format": ..., "sha256": checksum of the result as text, "result": ...}
            content = parsed_json(path.read_text(encoding="utf-8"))
            stored_result = content["result"]
            checksum_fits = content["sha256"] == checksum(canonical_json(stored_result))
            if (
                content["format"] == _FORMAT
                and checksum_fits
                and stored_result["address"] == address
            ):
                return dict(stored_result)
        except FileNotFoundError:
            return None
        except OSError as fault:
            cause = fault.strerror or fault
            raise StoreError(
                f"{path}: this result can't be read: {cause}; mend that, or name another --out"
            ) from fault
        except (ValueError, KeyError, TypeError):
            pass

        # set the damaged file aside; it is missing where another sweep was faster
        with self._writing(), suppress(FileNotFoundError):
            os.replace(path, path.with_suffix(".bad"))
        return None

    def write_plan(self, study: Mapping[str, Any], points: Sequence[PlannedPoint]) -> None:
        """Store what is asked in sweep.json: the study (as keys and values), and number, address
        (the name of its result's file) and coordinates of each of its points.
        """
        rows = [
            {
                "number": point.number,
                "address": point.address,
                "coordinates": dict(point.coordinates),
            }
            for point in points
        ]
        # _FORMAT: name and version of the format
        self.write_text(
            self.folder / "sweep.json",
            json.dumps({"format": _FORMAT, "study": study, "points": rows}) + "\n",
        )

    def read_plan(self) -> tuple[dict[str, Any], tuple[PlannedPoint, ...]]:
        """The study (as keys and values) and its points, as stored in sweep.json, the file that
        every sweep writes first; InputError where there is no such file, or it can't be read.

        A point has its number, its coordinates on the axes of the study, and its address: 64
        hexadecimal digits, the name of the file of its result.
        """
        path = self.folder / "sweep.json"
        try:
            stored_plan = parsed_json(path.read_text(encoding="utf-8"))
            points = [
                PlannedPoint(int(row["number"]), str(row["address"]), dict(row["coordinates"]))
                for row in stored_plan["points"]
            ]
            for point in points:  # an address becomes the name of a file
                # _ADDRESS: 64 hexadecimal digits
                if not _ADDRESS.fullmatch(point.address):
                    raise ValueError(f"{shortened_repr(point.address)} is no address of a result")
            # keys that an earlier version stored are left out
            return _without_unused_keys(stored_plan["study"]), tuple(points)
        except FileNotFoundError:
            cure = f"`halfplane sweep STUDY.toml --out {self.folder}` starts one"
            raise InputError(f"{self.folder}: no sweep is stored here; {cure}") from None
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as fault:
            raise InputError(
                f"{path}: can't be read ({fault}); start the sweep again: results are kept"
            ) from fault

    def table(self, points: Sequence[PlannedPoint]) -> pd.DataFrame:
        """The stored results as a table: a row for each of `points` that has a result, in the order
        of the study; NaN where there is no value.

        Columns: number, the axes, the quantities and their uncertainties ("figures" of a stored
        result), then status, seconds, reason, notes and address. A result has further keys: "notes"
        on quantities by their names, and "record", how the solution came about.
        """
        rows = []
        column_types: dict[str, type] = {}  # of the quantities, in the order in which they come
        for point in points:
            stored_result = self.read(point.address)
            if stored_result is None:
                continue
            # the first stores have neither notes of the record nor notes on quantities
            notes = [*stored_result.get("record", {}).get("notes", ())]
            for name, note in stored_result.get("notes", {}).items():
                # a note without a name is on all quantities
                notes.append(f"{name}: {note}" if name else note)
            rows.append(
                {
                    "number": point.number,
                    **point.coordinates,
                    **stored_result["figures"],
                    "status": stored_result["status"],
                    "seconds": stored_result["seconds"],
                    "reason": stored_result["reason"],
                    "notes": "; ".join(notes),
                    "address": point.address,
                }
            )
            column_types |= dict.fromkeys(stored_result["figures"], float)

        # the columns in their order, each once; STATUS_COLUMNS: the last ones, from status on
        axis_columns = points[0].coordinates if points else ()
        columns = list(dict.fromkeys(("number", *axis_columns, *column_types, *STATUS_COLUMNS)))
        return pd.DataFrame(rows, columns=columns).astype(column_types)

    def write_table(self, table: pd.DataFrame) -> None:
        """Write the table of results to index.csv, and to index.parquet where pyarrow is installed,
        each in one go.
        """
        self.write_text(
            self.folder / "index.csv",
            table_text({name: table[name].tolist() for name in table.columns}),
        )
        if find_spec("pyarrow"):
            with self._writing():
                replace_file(self.folder / "index.parquet", table.to_parquet(index=False))


def solved_rows_of(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the points that were solved, without those that failed."""
    return table[table["status"] == "done"]


def read_index(folder: str | Path) -> pd.DataFrame:
    """The table of the sweep stored in `folder`: a row for each point that has a result, with its
    coordinates, values and status. It is made from the results, whether index.csv is there or not.

    Raises
    ------
    InputError
        Where the folder holds no sweep.
    """
    store = Store(Path(folder))
    return store.table(store.read_plan()[1])


def canonical_json(value: Any) -> str:
    """JSON with sorted keys and no NaN: the same text for the same value."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def checksum(text: str) -> str:
    """SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


# Keys of the Latin hypercube, which version 0.3.0 had, as it stored them where they were not used.
_UNUSED_KEYS = {"samples": 0, "seed": 0}
_UNUSED_KEYS_OF_AXES = {"latin_hypercube": None}


def _without_unused_keys(study: Mapping[str, Any]) -> dict[str, Any]:
    """A stored study without the keys that are no longer used, where these have the value that
    means nothing.

    >>> _without_unused_keys({"samples": 0, "axes": [{"name": "f", "latin_hypercube": None}]})
    {'axes': [{'name': 'f'}]}
    """
    kept_study = _without(study, _UNUSED_KEYS)
    kept_study["axes"] = [_without(axis, _UNUSED_KEYS_OF_AXES) for axis in study.get("axes", ())]
    return kept_study


def _without(keys: Mapping[str, Any], value_of_unused_key: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of a stored study without those that are no longer used, where these have the value
    that means nothing (`value_of_unused_key`).
    """
    return {
        key: value
        for key, value in keys.items()
        if key not in value_of_unused_key or value != value_of_unused_key[key]
    }
