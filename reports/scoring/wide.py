"""Tables as a path through the surface exports them: a column of places, then columns of pressure and shear for each frame."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from reports.scoring.mapping import ALIASES, Mapping, Quantity, converted, plain, stated_times
from reports.scoring.surface import SurfaceResult
from reports.scoring.tidying import surface_result
from scenes import InputError

if TYPE_CHECKING:
    from reports.scoring.reading_csv import TextTable

Array = NDArray[np.float64]
_FIELDS: tuple[Quantity, ...] = ("x", "pressure", "shear", "slip")
_TIMES = ("time", "t", "steptime", "totaltime")
# "CPRESS Frame 12", "CSHEAR1 at t=0.5", "p_3": the name, then perhaps a word for what the figure counts, then the figure.
_TAGGED = re.compile(
    r"^(?P<base>.+?)[\s_:@,.;\-(\[]+(?:at\s+)?(?P<word>step[\s_]?time|total[\s_]?time|time|frame|increment|inc|f|t|step)?[\s_:=#]*"
    r"(?P<figure>\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)\s*s?[)\]]?$",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class _Head:
    """What a column's name says: which quantity, and of which frame (None: not said), which is a time where `timed`."""

    quantity: Quantity
    frame: float | None
    timed: bool


def frames_of(path: Path, table: TextTable, mapping: Mapping) -> SurfaceResult | None:
    """The frames that stand beside each other in `table`; None where its names don't look like that.

    Each frame has a pressure and a shear, perhaps a slip and places of its own; its number or time stands in the names, or the
    frames are taken in the order of the columns.

    Raises
    ------
    InputError
        Where a frame lacks a field.
    """
    heads = [_head(name, mapping) for name in table.names]
    grouped: dict[Quantity, list[tuple[float, Array]]] = {quantity: [] for quantity in _FIELDS}
    for number, head in enumerate(heads):
        if head is not None:
            order = head.frame if head.frame is not None else float(len(grouped[head.quantity]))
            grouped[head.quantity].append((order, converted(mapping, head.quantity, table.values[:, number])))
    if not grouped["pressure"] or not grouped["x"]:
        return None
    frames = sorted(order for order, _ in grouped["pressure"])
    fields = {name: _stack(path, name, grouped[name], frames) for name in ("pressure", "shear", "slip")}
    if fields["shear"] is None:
        raise InputError(f"{path}: the frames have a pressure and no shear; a column such as CSHEAR1 is needed for each of them")
    own_places = _stack(path, "x", grouped["x"], frames) if len(grouped["x"]) > 1 else None
    places = grouped["x"][0][1] if own_places is None else own_places
    return surface_result(
        str(path), mapping.code, places, dict(fields), {"time": _times(path, mapping, heads, frames)}, _notes(heads, frames)
    )


def _head(name: str, mapping: Mapping) -> _Head | None:
    """What `name` says; None where it is none of the fields."""
    tagged = _TAGGED.match(name.strip())
    quantity = quantity_of(tagged["base"], mapping) if tagged else None
    if tagged is None or quantity is None:
        whole = quantity_of(name, mapping)
        return None if whole is None else _Head(whole, None, timed=False)
    word = plain(tagged["word"] or "")
    return _Head(quantity, float(tagged["figure"]), timed=word in _TIMES or (not word and "." in tagged["figure"]))


def has_frames(names: Sequence[str], mapping: Mapping) -> bool:
    """Whether `names` are those of frames beside each other: several pressures, or one with the frame in its name."""
    pressures = [head for head in (_head(name, mapping) for name in names) if head is not None and head.quantity == "pressure"]
    return len(pressures) > 1 or any(head.frame is not None for head in pressures)


def quantity_of(name: str, mapping: Mapping) -> Quantity | None:
    """Which of the fields a column of that very name holds; None for none of them."""
    for quantity in _FIELDS:
        stated = getattr(mapping.columns, quantity)
        known = (stated,) if stated is not None else ALIASES[quantity]
        if plain(name) in map(plain, known):
            return quantity
    return None


def _stack(path: Path, name: str, columns: list[tuple[float, Array]], frames: list[float]) -> Array | None:
    """(n_frames, n_points) in the order of `frames`; None where there is no such column."""
    if not columns:
        return None
    found = dict(columns)
    if len(found) < len(columns):
        raise InputError(f"{path}: two columns hold {name} of the same frame; leave one out or rename it")
    lacking = sorted({*frames} ^ found.keys())
    if lacking:
        raise InputError(f"{path}: frame {lacking[0]:g} has no {name}, or no pressure; every frame needs both pressure and shear")
    return np.array([found[frame] for frame in frames])


def _times(path: Path, mapping: Mapping, heads: list[_Head | None], frames: list[float]) -> Array | None:
    if mapping.times is not None:
        return stated_times(str(path), mapping, len(frames), "frames")
    timed = any(head is not None and head.timed for head in heads)
    return converted(mapping, "time", np.array(frames)) if timed else None


def _notes(heads: list[_Head | None], frames: list[float]) -> tuple[str, ...]:
    named = any(head is not None and head.frame is not None for head in heads)
    how = "by the figures in their names" if named else "in the order of the columns"
    return (f"{len(frames)} frames were found beside each other, told apart {how}",)
