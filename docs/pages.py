"""The pages that are made from files and from the engines, and the numbers that pages quote. Part of `make pages`.

    python docs/pages.py

verification.md, gallery.md, misprints.md, expected.csv, architecture.svg, the tables of scenes.md, third.md, metrics.md and
scene-keys.md, and the numbers in the text of every page. Tests make all of it again.
"""

from __future__ import annotations

import csv
import io
import json
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import architecture
import quoting
import reference

from reports.comparison.metrics import markdown
from reports.paper.cases import Paper, paper
from reports.paper.page import misprints
from reports.paper.tables import proven_in_words
from scenes import Scene, load_scene, scene_names

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent
PUBLISHED = ROOT / "reports" / "published"
WRITTEN = "<!-- written by `make pages` -->"
WIDE = '<div class="wide">'  # a table whose numbers are not broken; on a phone it scrolls in a box of its own
THIRD = ROOT / "benchmarks" / "third.json"
ROUNDING = re.compile(r"(?<![\w.])(?:0|\d(?:\.\d+)?e-1[3-9])(?!\w|\.\d)")


def published() -> dict[str, Any]:
    """What both engines gave for every scene of the library: reports/published/values.json."""
    return json.loads((PUBLISHED / "values.json").read_text(encoding="utf-8"))["scenes"]


def made(examples: Paper | None = None) -> dict[str, str]:
    """File name under docs/ -> content."""
    examples = examples or paper()
    written = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md")}
    written["../README.md"] = (ROOT / "README.md").read_text(encoding="utf-8")
    generated = {
        "verification.md": "\n".join([*verification()]) + "\n",
        "gallery.md": "\n".join([*gallery()]) + "\n",
        "misprints.md": "\n".join([*misprint_page(examples)]) + "\n",
        "scenes.md": library(written["scenes.md"]),
        "expected.csv": expected(),
        "third.md": third_solver(written["third.md"]),
        "metrics.md": _between(written["metrics.md"], "the metrics", markdown().splitlines()),
        "scene-keys.md": reference.page(written["scene-keys.md"]),
        "architecture.svg": architecture.svg(ROOT / "pyproject.toml"),
    }
    known = values(examples)
    with_numbers = {name: quoting.with_numbers(text, known) for name, text in (written | generated).items()}
    return {name: text for name, text in with_numbers.items() if name in generated or quoting.NUMBER.search(text)}


def without_rounding(text: str) -> str:
    """Discrepancies of rounding, which another processor has in other digits, as one sign."""
    return ROUNDING.sub("~0", text)


def values(examples: Paper) -> dict[str, str]:
    """Key -> number, of all that a page can quote."""
    known = quoting.paper_values(examples) | quoting.published_values(published())
    known |= quoting.limit_values() | quoting.third_values(third(), published())
    known |= quoting.uncertain_values(json.loads((FOLDER / "uncertainty.json").read_text(encoding="utf-8")))
    known |= quoting.claim_values(json.loads((FOLDER / "numbers.json").read_text(encoding="utf-8")))
    for path in sorted((PUBLISHED / "maps").glob("*.md")):
        known |= quoting.map_values(path.stem, path.read_text(encoding="utf-8"))
    return known


def third() -> dict[str, Any]:
    """What CalculiX gave, by case: benchmarks/third.json."""
    return json.loads(THIRD.read_text(encoding="utf-8"))


def third_solver(text: str) -> str:
    """The page with its two tables: CalculiX' values as benchmarks/third.py measured them, ours as published."""
    cases = third()
    for words, of in (("two revolutions", ", 2 revolutions"), ("one revolution", "")):
        text = _between(
            text, words, _third_table({name: case for name, case in cases.items() if name.partition(",")[0] + of == name})
        )
    return text


def _between(text: str, words: str, lines: Iterable[str]) -> str:
    """The page with these lines between the two marks of a table."""
    begin, end = f"<!-- {words}: written by `make pages` -->", f"<!-- end of {words} -->"
    before, _, rest = text.partition(begin)
    return "\n".join([f"{before}{begin}", "", *lines, "", f"{end}{rest.partition(end)[2]}"])


def _third_table(cases: Mapping[str, Any]) -> Iterator[str]:
    """A row for each case: size, cost, each error beside ours, and when it was measured."""
    scenes = published()
    days = sorted({f"{case['code']} on {case['day']}" for case in cases.values()})
    yield from (f"Measured with {' and '.join(days)}.", "")
    errors = "peak p: CalculiX | ours | q, L2: CalculiX | ours | W: CalculiX | ours"
    yield from (WIDE, "")
    yield f"| scene | nodes, instants | time [s] | {errors} | commit |"
    yield f"|{'---|' * 10}"
    for name, case in sorted(cases.items()):
        scene = name.partition(",")[0]
        cells = [scene, f"{case['nodes']}, {case['instants']}", f"{case['seconds']:.0f}"]
        for key in ("peak_pressure", "shear", "dissipation"):
            theirs, ours = case["errors"].get(key), quoting.published_share(scenes[scene], key)
            cells += [quoting.share(scenes[scene], key, theirs) or case["failure"] or "–", ours or "–"]
        yield f"| {' | '.join([*cells, case['commit']])} |".replace(" %", "\u00a0%")
    yield from ("", "</div>")


# ----------------------------------------------------------------------------------------------------------- verification


METRICS = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")


def verification() -> Iterator[str]:
    """Requirements with the names of their tests, then the errors of every scene."""
    scenes = published()
    yield from ("# Verification", "", WRITTEN, "")
    yield (
        "Each requirement with the tests that check it, then each scene of the library by finite elements against theory. "
        "A test fails if a test named here does not exist, or if this page is stale."
    )
    yield from ("", "## Requirements")
    for area, rows in requirements().items():
        yield from ("", f"### {area}", "", "| requirement | tests |", "|---|---|")
        for row in rows:
            yield f"| {cell(row['requirement'])} | {'<br>'.join(f'`{test}`' for test in row['tests'])} |"
    met = sum(all(_judged(content).values()) for content in scenes.values())
    laws = sum(content["admissible"] for content in scenes.values())
    yield from ("", "## Scenes", "")
    yield (
        "Error = finite elements/theory − 1, with default settings; of p and q in the L2 norm, of edges over the half-width; "
        "*abs.*: over A f² P², where theory has no dissipation. **Bold**: outside the tolerance of the scene. "
        f"{laws} of {len(scenes)} scenes satisfy every law of contact, {met} every tolerance. The others have finite bodies or "
        "unlike materials: there the error is that of the half-plane idealisation. The page of a scene has its tolerances and all "
        "metrics. "
        "[values.json](../reports/published/values.json) has every value, "
        "[expected.csv](expected.csv) each expected value with its source."
    )
    heads = "W | peak p | p | q | contact edge | stick edge | tolerances satisfied"
    yield from ("", WIDE, "", f"| scene | {heads} |", f"|{'---|' * 8}")
    for name, content in scenes.items():
        judged = _judged(content)
        errors = [
            _error(content, key) for key in ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")
        ]
        link = f"[{name}](../reports/published/{name}.md)"
        yield f"| {' | '.join([link, *errors, f'{sum(judged.values())} of {len(judged)}'])} |".replace(" %", "\u00a0%")
    yield from ("", "</div>")


def requirements() -> dict[str, list[dict[str, Any]]]:
    """Area -> requirements with their tests: docs/requirements.toml."""
    table = tomllib.loads((FOLDER / "requirements.toml").read_text(encoding="utf-8"))
    return {area["title"]: area["requirements"] for area in table["area"]}


def _judged(content: Mapping[str, Any]) -> Mapping[str, bool]:
    return {key: satisfied for key, satisfied in content["accurate"].items() if satisfied is not None}


def _error(content: Mapping[str, Any], key: str) -> str:
    """A metric of a published scene, bold if it is outside its tolerance."""
    value = content["frozen"].get(f"metric.{key}")
    if value is None:
        return "–"
    shown = quoting.published_share(content, key) or f"{value:.2g} abs.".replace("-", "−")
    return f"**{shown}**" if content["accurate"][key] is False else shown


# ---------------------------------------------------------------------------------------------------------------- scenes

SYMBOLS = {
    "dissipation": "W",
    "largest_half_width": "a",
    "largest_pressure": "p",
    "permanent_stick_half_width": "c",
    "stick_share": "c/a",
    "stick_centre": "m",
    "contact_left": "left",
    "contact_right": "right",
    "moment": "M",
    "lower_face_displacement": "u",
}


def library(text: str) -> str:
    """The page of scenes with its table: a row a scene."""
    return _between(text, "the library", _library())


def _library() -> Iterator[str]:
    yield from (WIDE, "")
    yield "| scene | purpose | source | theory | finite elements |"
    yield "|---|---|---|---|---|"
    for scene in map(load_scene, scene_names()):
        purpose = f"{scene.title}. {scene.purpose[0].upper()}{scene.purpose[1:]}."
        numbers = [_numbers(scene, engine, digits) for engine, digits in (("half-plane theory", 9), ("finite elements", 6))]
        yield f"| {' | '.join([f'`{scene.name}`', cell(purpose), cell(scene.source), *numbers])} |"
    yield from ("", "</div>")


def _numbers(scene: Scene, engine: str, digits: int) -> str:
    """Expected numbers of one engine, by their symbols; several of one quantity have several sources."""
    found: dict[str, list[str]] = {}
    for one in scene.expected:
        if one.engine == engine:
            found.setdefault(SYMBOLS[one.quantity], []).append(f"{one.value:.{digits}g}".replace("-", "−"))
    return "; ".join(f"{symbol}\u00a0{', '.join(values)}" for symbol, values in found.items()) or "–"


def expected() -> str:
    """Every expected number of the library, with its tolerance and source."""
    written = io.StringIO()
    table = csv.writer(written, lineterminator="\n")
    table.writerow(["scene", "quantity", "value", "tolerance", "engine", "source"])
    for scene in map(load_scene, scene_names()):
        rows = ([one.quantity, f"{one.value:.9g}", f"{one.tolerance:g}", one.engine, one.source] for one in scene.expected)
        table.writerows([scene.name, *row] for row in rows)
    return written.getvalue()


def cell(text: str) -> str:
    """Words that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ").replace("*", "\\*").replace("_", "\\_")


# ------------------------------------------------------------------------------------------------------ gallery, misprints


def gallery() -> Iterator[str]:
    """The published picture of every scene."""
    yield from ("# Gallery", "", WRITTEN, "")
    yield (
        "Both engines on every scene of the [library](scenes.md). A title leads to the page of the scene with all its values; "
        "`halfplane run NAME` makes the interactive page."
    )
    for name in scene_names():
        yield from ("", f"## [{name}](../reports/published/{name}.md)", "", f"{load_scene(name).title}.", "")
        yield f"![Both engines on {name}](../reports/published/{name}.svg)"


def misprint_page(examples: Paper) -> Iterator[str]:
    """The paper's misprints with what proves them."""
    rows = misprints(examples)
    yield from ("# The paper's misprints", "", WRITTEN, "")
    yield (
        "What is printed, what is right, and an evaluation of both that tells them apart; `halfplane paper` computes the same "
        f"table. {sum(row.proven is True for row in rows)} of {len(rows)} are proven by a number, the rest by reading. "
        "The equations are those of the paper; [Theory](theory.md) derives the right ones."
    )
    for row in rows:
        yield from (
            "",
            f"## {prose(row.key)}: {row.where}",
            "",
            f"**printed**: {prose(row.printed)}  ",
            f"**right**: {prose(row.right)}",
            "",
        )
        yield from (f"{prose(row.proof)}.", "", f"Proven: {proven_in_words(row)}.")


def prose(text: str) -> str:
    """Words as they are, where Markdown would read marks into them."""
    return re.sub(r"([*_|\[\]<>])", r"\\\1", text)


def main() -> int:
    """Write what is not as the files and engines say."""
    for name, text in made().items():
        path = FOLDER / name
        before = path.read_text(encoding="utf-8") if path.is_file() else ""
        stale = without_rounding(before) != without_rounding(text)
        if stale:
            path.write_text(text, encoding="utf-8")
        print(f"{name}: {'written' if stale else 'as it was'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
