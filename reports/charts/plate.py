"""A figure of the page: its panels, the key to its lines, its words and its numbers."""

from __future__ import annotations

import base64
import zlib
from dataclasses import dataclass

from reports.drawing import Table, table_text


@dataclass(frozen=True)
class Key:
    """An entry of a legend: class of the line or patch as the style sheet has it, and what it stands for."""

    css: str
    text: str
    patch: bool = False


@dataclass(frozen=True, eq=False)
class Plate:
    """A figure.

    Attributes
    ----------
    name : stem of its file; title, caption : for the page; alt : what it shows, for who can't see it
    panels : SVG documents, set side by side where there is room
    table : column heading (with unit) -> values, all of one length; what the figure draws
    keys : the legend, above the panels
    columns : panels side by side at most
    """

    name: str
    title: str
    caption: str
    alt: str
    panels: tuple[str, ...]
    table: Table
    keys: tuple[Key, ...] = ()
    columns: int = 2

    def svg(self) -> str:
        """The panels, one after the other."""
        return "\n".join(self.panels)

    def csv(self) -> str:
        """The table, numbers to the last digit; an empty cell stands for "no such thing"."""
        return table_text(self.table)


def packed(text: str) -> str:
    """Text deflated and in base64, for a page to carry it (RFC 1950)."""
    return base64.b64encode(zlib.compress(text.encode(), 6)).decode()
