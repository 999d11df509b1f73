"""The pages that are made from files and from the engines, and the numbers that pages quote. Part of `make pages`.

    python docs/pages.py

verification.md, gallery.md, misprints.md, architecture.svg, the tables of third.md and scene-keys.md, and the numbers in the text
of every page. Tests make all of it again.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import architecture
import quoting
import reference

from reports.comparison.metrics import are_half_planes, tolerances_of
from reports.paper.cases import Paper, paper
from reports.paper.page import misprints
from reports.paper.tables import proven_in_words
from scenes import load_scene, scene_names

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent
PUBLISHED = ROOT / "reports" / "published"
WRITTEN = "<!-- written by `make pages` -->"
THIRD = ROOT / "benchmarks" / "third.json"
ROUNDING = re.compile(r"(?<![\w.])(?:0|\d(?:\.\d+)?e-1[3-9])(?!\w|\.\d)")


def published() -> dict[str, Any]:
    """What both engines gave for every scene of the library: reports/published/values.json."""
    return json.loads((PUBLISHED / "values.json").read_text(encoding="utf-8"))["scenes"]


def made(examples: Paper | None = None) -> dict[str, str]:
    """File name under docs/ -> content."""
    examples = examples or paper()
    written = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md")}
    generated = {
        "verification.md": "\n".join([*verification()]) + "\n",
        "gallery.md": "\n".join([*gallery()]) + "\n",
        "misprints.md": "\n".join([*misprint_page(examples)]) + "\n",
        "third.md": third_solver(written["third.md"]),
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
    known |= quoting.claim_values(json.loads((FOLDER / "numbers.json").read_text(encoding="utf-8")))
    for path in sorted((PUBLISHED / "maps").glob("*.md")):
        known |= quoting.map_values(path.stem, path.read_text(encoding="utf-8"))
    return known


def third() -> dict[str, Any]:
    """What CalculiX gave, by case: benchmarks/third.json."""
    return json.loads(THIRD.read_text(encoding="utf-8"))


def third_solver(text: str) -> str:
    """The page with its two tables: CalculiX' figures as benchmarks/third.py measured them, ours as published."""
    cases = third()
    for words, of in (("two revolutions", ", 2 revolutions"), ("one revolution", "")):
        begin, end = f"<!-- {words}: written by `make pages` -->", f"<!-- end of {words} -->"
        table = _third_table({name: case for name, case in cases.items() if name.partition(",")[0] + of == name})
        before, _, rest = text.partition(begin)
        text = "\n".join([f"{before}{begin}", "", *table, "", f"{end}{rest.partition(end)[2]}"])
    return text


def _third_table(cases: Mapping[str, Any]) -> Iterator[str]:
    """A row for each case: size, cost, each error beside ours, and when it was measured."""
    scenes = published()
    days = sorted({f"{case['code']} on {case['day']}" for case in cases.values()})
    yield from (f"Measured with {' and '.join(days)}.", "")
    errors = "peak p: CalculiX | ours | q, L2: CalculiX | ours | W: CalculiX | ours"
    yield f"| scene | nodes, instants | time [s] | {errors} | commit |"
    yield f"|{'---|' * 10}"
    for name, case in sorted(cases.items()):
        scene = name.partition(",")[0]
        cells = [scene, f"{case['nodes']}, {case['instants']}", f"{case['seconds']:.0f}"]
        for key in ("peak_pressure", "shear", "dissipation"):
            theirs, ours = case["errors"].get(key), quoting.published_share(scenes[scene], key)
            cells += [quoting.share(scenes[scene], key, theirs) or case["failure"] or "–", ours or "–"]
        yield f"| {' | '.join([*cells, case['commit']])} |".replace(" %", "\u00a0%")


# ----------------------------------------------------------------------------------------------------------- verification


def verification() -> Iterator[str]:
    """The verification manual: requirements with their tests, then every scene with figures, tolerances and verdicts."""
    scenes, table = published(), requirements()
    yield from ("# Verification manual", "", WRITTEN, "")
    yield (
        "What is promised, which tests hold it, and what both engines give for every scene of the library. "
        "Written by `make pages` from `docs/requirements.toml`, `reports/published/values.json` and the expected "
        "numbers in the scenes; "
        "a test fails where a test named here does not exist, or where this page is not what the files say."
    )
    yield from ("", "## From requirement to test", "")
    for area, rows in table.items():
        yield from (f"### {area}", "", "| requirement | tests |", "|---|---|")
        for row in rows:
            yield f"| {cell(row['requirement'])} | {'<br>'.join(f'`{test}`' for test in row['tests'])} |"
        yield ""
    yield from ("## Scenes", "")
    met = sum(all(_kept(content).values()) for content in scenes.values())
    yield (
        f"{len(scenes)} scenes, both engines with their default settings. {met} keep every tolerance; in the others finite "
        "bodies or unlike materials are asked about on purpose, and a tolerance missed is a finding about the half-plane. "
        "*External* numbers come from elsewhere (closed forms, arithmetic of 30 digits, publications); *frozen* ones "
        "are our own of last time."
    )
    for name, content in scenes.items():
        yield from _scene(name, content)


def requirements() -> dict[str, list[dict[str, Any]]]:
    """Area -> requirements with their tests: docs/requirements.toml."""
    table = tomllib.loads((FOLDER / "requirements.toml").read_text(encoding="utf-8"))
    return {area["title"]: area["requirements"] for area in table["area"]}


def _kept(content: Mapping[str, Any]) -> Mapping[str, bool]:
    return {key: kept for key, kept in content["accurate"].items() if kept is not None}


def _scene(name: str, content: Mapping[str, Any]) -> Iterator[str]:
    scene = load_scene(name)
    yield from ("", f"### {name}", "", f"{scene.title}. {_verdict(content)} [Its page](published/{name}.md).", "")
    yield from ("| figure | finite elements less theory | tolerance | verdict |", "|---|---|---|---|")
    tolerances = tolerances_of(scene, are_half_planes(scene))
    for key, kept in content["accurate"].items():
        value = content["frozen"].get(f"metric.{key}")
        shown = "does not apply" if value is None else f"{value:+.3g}".replace("-", "−")
        limit = tolerances.get(key)
        verdict = {True: "kept", False: "**missed**", None: "not judged"}[kept]
        yield f"| {key.replace('_', ' ')} | {shown} | {'' if limit is None else f'{limit:g}'} | {verdict} |"
    yield from ("", "| expected | value | tolerance | of | source |", "|---|---|---|---|---|")
    for one in scene.expected:
        words = one.quantity.replace("_", " ")
        yield f"| {words} | {one.value:.9g} | {one.tolerance:g} | {one.engine} | {cell(one.source)} |"


def _verdict(content: Mapping[str, Any]) -> str:
    kept = _kept(content)
    laws = "Every law of contact is kept." if content["admissible"] else "**A law of contact is broken.**"
    return f"{laws} {sum(kept.values())} of {len(kept)} tolerances are kept."


def cell(text: str) -> str:
    """Words that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ").replace("*", "\\*").replace("_", "\\_")


# ------------------------------------------------------------------------------------------------------ gallery, misprints


def gallery() -> Iterator[str]:
    """The published picture of every scene."""
    yield from ("# Gallery", "", WRITTEN, "")
    yield (
        "What both engines give for every scene of the library, as published in the repository (`make publish`). "
        "Each title leads to the page of the scene with all its figures; a run with `halfplane run NAME` makes the "
        "full interactive page."
    )
    for name in scene_names():
        scene = load_scene(name)
        yield from ("", f"## [{name}](published/{name}.md)", "", f"{scene.title}: {scene.purpose}.", "")
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
