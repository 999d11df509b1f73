"""Which maps there are, from maps.toml: their studies, what each is drawn and fitted over, and what theory predicts."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scenes import InputError

STUDIES = Path(__file__).with_name("studies")
PUBLISHED = Path(__file__).parents[1] / "published" / "maps"

WORDS = {
    "error.dissipation": "dissipation",
    "error.peak_dissipation": "peak dissipation",
    "error.p0": "peak pressure p0",
    "error.contact_half_width": "contact half-width a",
    "error.permanent_stick_half_width": "permanent stick half-width",
    "error.stick_half_width": "stick half-width c",
}
AXES = {
    "height": "height / a",
    "aspect": "width / height",
    "curvature": "a / R",
    "flat": "b / a",
    "beta": "Dundurs' β",
    "f": "friction f",
    "phase": "phase, degrees",
    "margin": "distance from sliding",
    "amplitude": "P1/P0",
    "base": "base",
    "width": "width / a",
    "stress": "σ / (f p0)",
}


def place(at: Mapping[str, str], everywhere: str = "all") -> str:
    """The coordinates of a line in words; `everywhere` where it has none.

    >>> place({"aspect": "2", "base": "fixed"}), place({})
    ('width / height 2, base fixed', 'all')
    """
    return ", ".join(f"{AXES.get(name, name)} {value}" for name, value in at.items()) or everywhere


@dataclass(frozen=True)
class Chart:
    """One study as it is drawn and fitted; maps.toml describes each."""

    study: str
    across: str
    up: str = ""
    panels: str = ""
    small: str = ""
    inverse: bool = False
    expected: float | None = None
    prediction: str = ""
    within: str = ""
    step: float = 2.0
    others: Mapping[str, float] = field(default_factory=dict)
    sample: Mapping[str, Any] = field(default_factory=dict)

    def order(self, figure: str) -> float | None:
        """Exponent of s that theory predicts of an error; None where no law is sought."""
        return self.others.get(figure, self.expected)


@dataclass(frozen=True)
class Map:
    """A page: its charts, and studies of points that no law was fitted to."""

    name: str
    title: str
    question: str
    charts: tuple[Chart, ...]
    held_out: tuple[str, ...] = ()

    @property
    def studies(self) -> tuple[str, ...]:
        """Every study of the page."""
        return (*(chart.study for chart in self.charts), *self.held_out)


_CONTENT = tomllib.loads(Path(__file__).with_name("maps.toml").read_text(encoding="utf-8"))
PAGE_WORDS: dict[str, Any] = _CONTENT["words"]
MAPS = {
    row["name"]: Map(
        row["name"], row["title"], row["question"], tuple(Chart(**chart) for chart in row["charts"]), tuple(row.get("held_out", ()))
    )
    for row in _CONTENT["map"]
}


def map_named(name: str) -> Map:
    """A map by name; InputError names those that there are."""
    if name not in MAPS:
        raise InputError(f"map {name!r}: there is none; known: {', '.join(MAPS)}, or all")
    return MAPS[name]
