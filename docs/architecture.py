"""The picture of the architecture, drawn from the import contracts in pyproject.toml, and the map
of packages with their sizes.

A box for each package in the layer that the contract gives it; an arrow where an import is allowed
and no way round another package says the same; a barrier where the contract of independence stands;
under each name what a contract forbids it from outside.
"""

from __future__ import annotations

import importlib
import re
import sys
import textwrap
import tomllib
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
sys.path.append(str(ROOT / "benchmarks"))
sizes = importlib.import_module("sizes")

# Sizes of the drawing: its width, a box (width, height), from row to row, its margin above.
WIDTH = 760
BOX = (300, 104)
ROW = 164
TOP = 16
COLOURS = ("#f5dfb8", "#cfe3f2", "#e3e3e3", "#ffffff")


class Contracts(NamedTuple):
    """What pyproject.toml says: layers from the top, what each package may not import, who must not
    see whom.
    """

    layers: list[list[str]]
    forbidden: dict[str, set[str]]
    independent: list[list[str]]

    @property
    def depth(self) -> dict[str, int]:
        """Layer of each package, from the top."""
        return {package: index for index, layer in enumerate(self.layers) for package in layer}

    def arrows(self) -> list[tuple[str, str]]:
        """Allowed imports that do not follow from others."""
        depth = self.depth
        allowed = [
            (importer, imported)
            for importer in depth
            for imported in depth
            if depth[importer] < depth[imported]
            and imported not in self.forbidden.get(importer, ())
        ]
        arrows = []
        for importer, imported in allowed:
            between = [
                package
                for package in depth
                if (importer, package) in allowed and (package, imported) in allowed
            ]
            if not between:
                arrows.append((importer, imported))
        return arrows


def read(path: Path) -> Contracts:
    """The contracts of a pyproject.toml."""
    contracts = Contracts([], {}, [])
    tools = tomllib.loads(path.read_text(encoding="utf-8"))["tool"]
    for contract in tools["importlinter"]["contracts"]:
        if contract["type"] == "layers" and not contracts.layers:
            for layer in contract["layers"]:
                packages = layer.split("|")
                contracts.layers.append([package.strip() for package in packages])
        elif contract["type"] == "forbidden":
            for source in contract["source_modules"]:
                forbidden = contracts.forbidden.setdefault(source, set())
                forbidden.update(contract["forbidden_modules"])
        elif contract["type"] == "independence":
            contracts.independent.append(contract["modules"])
    return contracts


def svg(path: Path) -> str:
    """The drawing of a pyproject.toml."""
    contracts = read(path)
    arrows = contracts.arrows()
    # Middle of the top of each box; a package alone in its layer stands under the mean of those
    # that import it.
    places: dict[str, tuple[float, int]] = {}
    for row, layer in enumerate(contracts.layers):
        for column, name in enumerate(layer):
            importers_x = [places[importer][0] for importer, imported in arrows if imported == name]
            x = WIDTH / 2 + (column - (len(layer) - 1) / 2) * WIDTH / 2
            if len(layer) == 1 and importers_x:
                x = sum(importers_x) / len(importers_x)
            places[name] = (x, TOP + row * ROW)
    height = TOP * 2 + ROW * (len(contracts.layers) - 1) + BOX[1]
    words = "; ".join(f"{importer} imports {imported}" for importer, imported in arrows)
    lines = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}"'
            f' width="{WIDTH}" role="img" font-family="system-ui, sans-serif"'
            f' font-size="12"><title>{escape(words)}</title>'
        ),
        (
            '<defs><marker id="tip" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="8"'
            ' markerHeight="8" orient="auto"><path d="M0 0L10 5L0 10z"'
            ' fill="#333"/></marker></defs>'
        ),
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
    ]
    for importer, imported in arrows:
        x1, y1 = places[importer]
        x2, y2 = places[imported]
        ends = f'x1="{x1:.0f}" y1="{y1 + BOX[1]}" x2="{x2:.0f}" y2="{y2 - 3}"'
        lines.append(f'<line {ends} stroke="#333" stroke-width="1.5" marker-end="url(#tip)"/>')
    for group in contracts.independent:
        x = sum(places[name][0] for name in group) / len(group)
        _, y = places[group[0]]
        ends = f'x1="{x:.0f}" y1="{y - 14}" x2="{x:.0f}" y2="{y + BOX[1] + 2}"'
        lines.append(f'<line {ends} stroke="#B33A00" stroke-width="4"/>')
        words = "never import each other"
        lines.append(
            f'<text x="{x:.0f}" y="{y + BOX[1] + 18}" text-anchor="middle"'
            f' fill="#B33A00">{words}</text>'
        )
    for name, place in places.items():
        lines += box(name, place, contracts)
    return "\n".join([*lines, "</svg>"]) + "\n"


def purpose(name: str) -> str:
    """The first sentence of a package's docstring, without its full stop."""
    summary = (importlib.import_module(name).__doc__ or "").split("\n\n")[0]
    return " ".join(summary.split()).split(". ")[0].rstrip(".")


def box(name: str, place: tuple[float, int], contracts: Contracts) -> Iterator[str]:
    """A package: its name, the first sentence of its docstring or what stands before its colon,
    what it does without.
    """
    middle, y = place
    x = middle - BOX[0] / 2
    fill = COLOURS[contracts.depth[name] % len(COLOURS)]
    outside = ", ".join(sorted(contracts.forbidden.get(name, set()) - set(contracts.depth)))
    words = purpose(name).split(": ", 1)[-1].split("; ")[0]
    yield (
        f'<rect x="{x:.0f}" y="{y}" width="{BOX[0]}" height="{BOX[1]}" rx="6" fill="{fill}"'
        ' stroke="#333"/>'
    )
    yield (
        f'<text x="{x + 12:.0f}" y="{y + 21}" font-weight="bold"'
        f' font-size="15">{escape(name)}</text>'
    )
    for index, line in enumerate(textwrap.wrap(words, 44)[:2]):
        yield f'<text x="{x + 12:.0f}" y="{y + 38 + 15 * index}">{escape(line)}</text>'
    for index, line in enumerate(textwrap.wrap(f"without {outside}", 48)[:3] if outside else []):
        yield (
            f'<text x="{x + 12:.0f}" y="{y + 70 + 13 * index}" font-size="10.5"'
            f' fill="#555">{escape(line)}</text>'
        )


# ------------------------------------------------------------------------------ the map of packages
class Part(NamedTuple):
    """A row of the map: its name, what it holds, what it imports, and its files or folders."""

    name: str
    holds: str
    imports: str
    paths: tuple[str, ...]


CORE = ("charts", "cli", "comparison", "field_output", "page", "scoring")
STUDIES = ("maps", "paper", "sweep", "third")


def packages() -> list[Part]:
    """The rows of the map of packages: engines, and the two floors of reports."""
    core = tuple(
        str(path.relative_to(ROOT))
        for path in sorted((ROOT / "reports").iterdir())
        if path.name != "studies" and (path.suffix == ".py" or path.name in CORE)
    )
    return [
        Part("scenes", "scene files, library, form of an answer", "none", ("scenes",)),
        Part(
            "semi_analytic",
            "half-plane theory: contact, memory of friction, dissipation",
            "`scenes`",
            ("semi_analytic",),
        ),
        Part("meshes", "bodies meshed by gmsh, mesh and field files", "`scenes`", ("meshes",)),
        Part(
            "halfplane_fe",
            "plane-strain finite elements, Coulomb friction",
            "`scenes`, `meshes`",
            ("halfplane_fe",),
        ),
        Part(
            "reports",
            "the core: one question about one scene",
            "all above",
            core,
        ),
        Part(
            "reports.studies",
            "sweeps, maps, the paper, a third solver",
            "all above",
            ("reports/studies",),
        ),
    ]


def folders() -> list[Part]:
    """The rows of the map of reports: a folder each, and the single files of the core."""
    files = sorted((ROOT / "reports").glob("*.py"))
    names = ", ".join(f"`{path.stem}`" for path in files if not path.stem.startswith("_"))
    return [
        *(Part(name, purpose(f"reports.{name}"), "", (f"reports/{name}",)) for name in CORE),
        Part(
            "single files",
            names,
            "",
            tuple(str(path.relative_to(ROOT)) for path in files),
        ),
        *(
            Part(
                f"studies.{name}",
                purpose(f"reports.studies.{name}"),
                "",
                (f"reports/studies/{name}",),
            )
            for name in STUDIES
        ),
    ]


def rows(parts: Sequence[Part], page: str) -> Iterator[list[str]]:
    """The cells of a map: name, what it holds, what it imports where it says, statements to
    hundreds.

    The size on the page stays while it is right to a hundred, so that few commits change it.
    """
    for part in parts:
        statements = sum(sizes.size(path).statements for path in part.paths)
        name = part.name if part.name == "single files" else f"`{part.name}`"
        cells = [name, part.holds, part.imports] if part.imports else [name, part.holds]
        stored = re.search(rf"^\| {re.escape(name)} \|.* ([\d,]+) \|$", page, re.MULTILINE)
        printed_size = int(stored[1].replace(",", "")) if stored else 0
        if abs(statements - printed_size) > 100:
            printed_size = round(statements, -2)
        yield [*cells, f"{printed_size:,}"]
