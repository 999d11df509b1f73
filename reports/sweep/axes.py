"""The axes of a study: lists, even and logarithmic steps, Latin hypercubes, and rows of values that go together."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from scenes.frozen import Frozen

Value = bool | int | float | str
Coordinates = dict[str, Value]


class Steps(Frozen):
    """`count` values from `start` to `stop`, both included."""

    start: float
    stop: float
    count: int = Field(ge=1, le=100_000)


class Span(Frozen):
    """Where a Latin hypercube draws from."""

    start: float
    stop: float
    logarithmic: bool = False


class Axis(Frozen):
    """One axis: a name for the table, the keys that its values go to, and the values in one of five ways.

    >>> Axis(name="height", linear=Steps(start=2, stop=6, count=3)).settings()
    [{'height': 2.0}, {'height': 4.0}, {'height': 6.0}]
    """

    name: str = Field("", pattern=r"^([A-Za-z_]\w*)?$", description="column of the table, and the name in [derived]")
    names: tuple[str, ...] = Field((), description="of rows of values: one column for each")
    label: str = Field("", description="for figures; the name where it is left out")
    unit: str = ""
    key: str = Field("", description="dotted key of the scene, or mesh.* or solver.*")
    keys: tuple[str, ...] = Field((), description="several keys that take the same value; of rows of values: one key for each")
    values: tuple[Value, ...] = ()
    linear: Steps | None = None
    logarithmic: Steps | None = None
    latin_hypercube: Span | None = None
    pairs: tuple[tuple[Value, ...], ...] = Field((), description="rows of values that go together")

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        ways = [name for name in _WAYS if getattr(self, name)]
        if len(ways) != 1:
            raise ValueError(
                f"an axis has its values in exactly one of {', '.join(_WAYS)}; this one has {' and '.join(ways) or 'none'}"
            )
        if self.key and self.keys:
            raise ValueError("key and keys: give one of the two")
        if self.pairs:
            widths = {len(row) for row in self.pairs}
            if len(widths) != 1 or widths != {len(self.names)} or (self.keys and len(self.keys) != len(self.names)):
                raise ValueError("pairs: each row has one value for each of names, and keys (if given) are as many")
        elif not self.name or self.names:
            raise ValueError("an axis has a name; names go with pairs")
        for scale in (
            self.logarithmic,
            self.latin_hypercube if self.latin_hypercube and self.latin_hypercube.logarithmic else None,
        ):
            if scale is not None and not (scale.start > 0 and scale.stop > 0):
                raise ValueError("a logarithmic axis needs start > 0 and stop > 0")
        return self

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of its columns."""
        return self.names or (self.name,)

    @property
    def targets(self) -> list[tuple[str, str]]:
        """(key, column) of every key that it sets."""
        if self.pairs:
            return list(zip(self.keys, self.names, strict=False))
        return [(key, self.name) for key in (self.keys or ((self.key,) if self.key else ()))]

    def settings(self) -> list[Coordinates]:
        """What it sets its columns to, value by value; not for a Latin hypercube."""
        if self.pairs:
            return [dict(zip(self.names, row, strict=True)) for row in self.pairs]
        found: Sequence[Value] = self.values
        if self.linear:
            found = np.linspace(self.linear.start, self.linear.stop, self.linear.count).tolist()
        if self.logarithmic:
            found = np.geomspace(self.logarithmic.start, self.logarithmic.stop, self.logarithmic.count).tolist()
        return [{self.name: value} for value in found]


_WAYS = ("values", "linear", "logarithmic", "latin_hypercube", "pairs")


def grid(axes: Sequence[Axis], samples: int, seed: int) -> Iterator[Coordinates]:
    """Every point: each setting of each axis with each other, and with each sample of the Latin hypercube; the last axis first."""
    whole = [axis.settings() for axis in axes if not axis.latin_hypercube]
    drawn = hypercube([axis for axis in axes if axis.latin_hypercube], samples, seed)
    for parts in itertools.product(*whole, *([drawn] if drawn else [])):
        found: dict[str, Any] = {}
        for part in parts:
            found |= part
        yield {column: found[column] for axis in axes for column in axis.columns}


def hypercube(axes: Sequence[Axis], samples: int, seed: int) -> list[Coordinates]:
    """Latin hypercube samples: on each axis one in each of `samples` equal parts, their order drawn by `seed`.

    >>> [drawn] = [hypercube([Axis(name="f", latin_hypercube=Span(start=0, stop=4))], 4, seed=1)]
    >>> sorted(int(point["f"]) for point in drawn)
    [0, 1, 2, 3]
    """
    if not axes:
        return []
    columns = []
    for number, axis in enumerate(axes):
        span = axis.latin_hypercube
        assert span is not None
        random = np.random.default_rng([seed, number])
        place = (random.permutation(samples) + random.random(samples)) / samples
        if span.logarithmic:
            columns.append((span.start * (span.stop / span.start) ** place).tolist())
        else:
            columns.append((span.start + (span.stop - span.start) * place).tolist())
    return [dict(zip((axis.name for axis in axes), row, strict=True)) for row in zip(*columns, strict=True)]
