"""The picture of the architecture, drawn from the import contracts in pyproject.toml.

A box for each package in the layer that the contract gives it; an arrow where an import is allowed and no way round another package
says the same; a barrier where the contract of independence stands; under each name what a contract forbids it from outside.
"""

from __future__ import annotations

import importlib
import textwrap
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

_WIDTH, _BOX, _ROW, _TOP = 760, (300, 104), 164, 16
_COLOURS = ("#f5dfb8", "#cfe3f2", "#e3e3e3", "#ffffff")
_LINE = 44


@dataclass(frozen=True)
class Contracts:
    """What pyproject.toml says: layers from the top, what each package may not import, who must not see whom."""

    layers: tuple[tuple[str, ...], ...]
    forbidden: dict[str, frozenset[str]]
    independent: tuple[tuple[str, ...], ...]

    @property
    def packages(self) -> tuple[str, ...]:
        """Every package, from the top."""
        return tuple(package for layer in self.layers for package in layer)

    def allowed(self, importer: str, imported: str) -> bool:
        """Whether no contract stands against it."""
        depth = {package: index for index, layer in enumerate(self.layers) for package in layer}
        return depth[importer] < depth[imported] and imported not in self.forbidden.get(importer, frozenset())

    def arrows(self) -> list[tuple[str, str]]:
        """Allowed imports that do not follow from others."""
        pairs = [(one, other) for one in self.packages for other in self.packages if self.allowed(one, other)]
        return [
            (one, other) for one, other in pairs if not any((one, via) in pairs and (via, other) in pairs for via in self.packages)
        ]


def read(path: Path) -> Contracts:
    """The contracts of a pyproject.toml.

    Raises
    ------
    ValueError
        Where there is no contract of layers: then there is nothing to draw.
    """
    table = tomllib.loads(path.read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    layers = [contract for contract in table if contract["type"] == "layers"]
    if not layers:
        raise ValueError(f"{path.name}: no contract of layers")
    forbidden: dict[str, frozenset[str]] = {}
    for contract in _of(table, "forbidden"):
        for source in contract["source_modules"]:
            forbidden[source] = forbidden.get(source, frozenset()) | frozenset(contract["forbidden_modules"])
    return Contracts(
        layers=tuple(tuple(part.strip() for part in layer.split("|")) for layer in layers[0]["layers"]),
        forbidden=forbidden,
        independent=tuple(tuple(contract["modules"]) for contract in _of(table, "independence")),
    )


def _of(table: list[dict[str, Any]], kind: str) -> Iterator[dict[str, Any]]:
    return (contract for contract in table if contract["type"] == kind)


def svg(path: Path) -> str:
    """The drawing of a pyproject.toml."""
    contracts = read(path)
    places = _places(contracts)
    height = _TOP * 2 + _ROW * (len(contracts.layers) - 1) + _BOX[1]
    words = "; ".join(f"{one} imports {other}" for one, other in contracts.arrows())
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" width="{_WIDTH}" role="img" '
        f'font-family="system-ui, sans-serif" font-size="12"><title>{escape(words)}</title>',
        '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0L10 5L0 10z" fill="#333"/></marker></defs>',
        f'<rect width="{_WIDTH}" height="{height}" fill="white"/>',
        *(_arrow(places[one], places[other]) for one, other in contracts.arrows()),
        *(line for group in contracts.independent for line in _barrier([places[name] for name in group])),
        *(line for name in contracts.packages for line in _box(name, places[name], contracts)),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _places(contracts: Contracts) -> dict[str, tuple[float, float]]:
    """Middle of the top of each box; a package alone in its layer stands under the mean of those that import it."""
    found: dict[str, tuple[float, float]] = {}
    for row, layer in enumerate(contracts.layers):
        for column, name in enumerate(layer):
            above = [found[one][0] for one, other in contracts.arrows() if other == name]
            spread = (column - (len(layer) - 1) / 2) * _WIDTH / 2
            found[name] = (_WIDTH / 2 + spread if len(layer) > 1 or not above else sum(above) / len(above), _TOP + row * _ROW)
    return found


def _arrow(one: tuple[float, float], other: tuple[float, float]) -> str:
    x, top = other
    ends = f'x1="{one[0]:.0f}" y1="{one[1] + _BOX[1]}" x2="{x:.0f}" y2="{top - 3}"'
    return f'<line {ends} stroke="#333" stroke-width="1.5" marker-end="url(#tip)"/>'


def _barrier(places: list[tuple[float, float]]) -> Iterator[str]:
    x, y = sum(place[0] for place in places) / len(places), places[0][1]
    yield f'<line x1="{x:.0f}" y1="{y - 14}" x2="{x:.0f}" y2="{y + _BOX[1] + 2}" stroke="#B33A00" stroke-width="4"/>'
    yield f'<text x="{x:.0f}" y="{y + _BOX[1] + 18}" text-anchor="middle" fill="#B33A00">never import each other</text>'


def _box(name: str, place: tuple[float, float], contracts: Contracts) -> Iterator[str]:
    x, y = place[0] - _BOX[0] / 2, place[1]
    layer = next(index for index, packages in enumerate(contracts.layers) if name in packages)
    outside = sorted(contracts.forbidden.get(name, frozenset()) - set(contracts.packages))
    said = textwrap.wrap(_purpose(name), _LINE)[:2]
    never = textwrap.wrap(f"without {', '.join(outside)}", _LINE + 4)[:3] if outside else []
    fill = _COLOURS[layer % len(_COLOURS)]
    yield f'<rect x="{x:.0f}" y="{y}" width="{_BOX[0]}" height="{_BOX[1]}" rx="6" fill="{fill}" stroke="#333"/>'
    yield f'<text x="{x + 12:.0f}" y="{y + 21}" font-weight="bold" font-size="15">{escape(name)}</text>'
    for index, line in enumerate(said):
        yield f'<text x="{x + 12:.0f}" y="{y + 38 + 15 * index}">{escape(line)}</text>'
    for index, line in enumerate(never):
        yield f'<text x="{x + 12:.0f}" y="{y + 70 + 13 * index}" font-size="10.5" fill="#555">{escape(line)}</text>'


def _purpose(name: str) -> str:
    """The first sentence of the package's docstring, or what stands before its colon."""
    text = (importlib.import_module(name).__doc__ or "").split("\n")[0]
    return text.split(". ")[0].split(": ", 1)[-1].split("; ")[0].rstrip(".")
