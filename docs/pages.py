"""The pages that are made from files and from the engines, and the numbers that pages quote. Part
of `make pages`.

    python docs/pages.py

verification.md, gallery.md, misprints.md, expected.csv, headings.csv, third.csv, architecture.svg,
the tables of scenes.md, third.md, maps.md, metrics.md and scene-keys.md, the maps of packages, and
the numbers in the text of every page. Tests make all of it again.
"""

from __future__ import annotations

import csv
import io
import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import architecture
import numpy as np
import quoting
import reference

import halfplane_fe
import semi_analytic
from reports.comparison.metrics import markdown
from reports.comparison.pairs import are_half_planes
from reports.page.rig import RigMotion, loops
from reports.studies.maps import pages as maps
from reports.studies.paper.cases import Paper, paper
from reports.studies.paper.page import misprints
from reports.studies.paper.tables import proven_in_words
from scenes import Scene, load_scene, rig_names, scene_names

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent
PUBLISHED = ROOT / "reports" / "published"
sys.path.append(str(ROOT / "benchmarks"))  # the table of cases
WRITTEN = "<!-- written by `make pages` -->"
THIRD = ROOT / "benchmarks" / "third.json"
TWICE = ", 2 revolutions"
THIRD_METRICS = ("peak_pressure", "shear", "dissipation")
BOUND = ROOT / "benchmarks" / "bound.json"
CURVED = ROOT / "benchmarks" / "curved.json"
COVERED = ROOT / "benchmarks" / "covered.json"
LOOPS = "figures/rigs.svg"
ROUNDING = re.compile(r"(?<![\w.])(?:0|\d(?:\.\d+)?e-1[3-9])(?!\w|\.\d)")


def published() -> dict[str, Any]:
    """What both engines gave for every scene of the library: baselines of the table of cases."""
    import publishing

    return publishing.published()


def made(examples: Paper | None = None) -> dict[str, str]:
    """File name under docs/ -> content."""
    examples = examples or paper()
    written = {path.name: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.md")}
    written["../README.md"] = (ROOT / "README.md").read_text(encoding="utf-8")
    generated = {
        "verification.md": "\n".join(verification()) + "\n",
        "gallery.md": "\n".join(gallery()) + "\n",
        "misprints.md": "\n".join(misprint_page(examples)) + "\n",
        "misprints.csv": misprint_proofs(examples),
        "scenes.md": scenes_page(written["scenes.md"]),
        "expected.csv": expected(),
        "third.md": third_solver(written["third.md"]),
        "third.csv": third_file(),
        "finite-elements.md": between(
            written["finite-elements.md"], "the coverage", coverage_tables()
        ),
        "maps.md": between(
            between(written["maps.md"], "the heights", table_of_heights()),
            "the bound",
            bound_in_words(),
        ),
        "metrics.md": between(written["metrics.md"], "the metrics", markdown().splitlines()),
        "scene-keys.md": reference.page(written["scene-keys.md"]),
        "headings.csv": reference.headings_file(),
        "architecture.svg": architecture.svg(ROOT / "pyproject.toml"),
        "architecture.md": with_maps(written["architecture.md"]),
        "../README.md": with_packages(written["../README.md"]),
    }
    known = quoting.values(examples, published(), third())
    with_numbers = {
        name: quoting.with_numbers(text, known) for name, text in (written | generated).items()
    }
    return {
        name: text
        for name, text in with_numbers.items()
        if name in generated or quoting.NUMBER.search(text)
    }


def without_rounding(text: str) -> str:
    """Discrepancies of rounding, which another processor has in other digits, as one sign."""
    return ROUNDING.sub("~0", text)


def third() -> dict[str, Any]:
    """What CalculiX gave, by case: benchmarks/third.json."""
    return json.loads(THIRD.read_text(encoding="utf-8"))


def third_solver(text: str) -> str:
    """The page with its two tables: CalculiX' values as benchmarks/third.py measured them, ours as
    published. Of one revolution every case stands in third.csv.
    """
    cases = third()
    two_revolutions = {name: case for name, case in cases.items() if name.endswith(TWICE)}
    text = between(text, "two revolutions", third_table(two_revolutions))
    return between(text, "one revolution", third_by_bodies(once_around(cases)))


def once_around(cases: Mapping[str, Any]) -> dict[str, Any]:
    """The cases of one revolution with the settings of every scene."""
    return {name: case for name, case in cases.items() if "," not in name}


def table_of_heights() -> Iterator[str]:
    """From which height on theory holds, as the published maps have it."""
    yield '<div class="wide">'
    yield ""
    yield maps.heights_of(maps.stored_maps(maps.PUBLISHED))
    yield ""
    yield "</div>"


def bound_in_words() -> Iterator[str]:
    """What advice leaves of finite elements on the drawn bodies, as benchmarks/bound.py and
    benchmarks/curved.py solved them.
    """
    content = json.loads(BOUND.read_text(encoding="utf-8"))
    yield (
        f"{len(content['rows'])} cases of seed {content['seed']}, in per cent of W:"
        f" {100 * content['covered']:.0f} % covered, {100 * content['left']:.2f} left at the"
        f" median, the uncertainty {content['bound_over_left']:.1f} times as much;"
        f" {100 * content['declined']:.0f} % declined: kernels."
    )
    curved = json.loads(CURVED.read_text(encoding="utf-8"))
    left = curved["most_left"]
    yield ""
    yield (
        f"Curved faces (`python benchmarks/curved.py 18 {curved['seed']}`), {curved['values']}"
        f" values of W, p0 and a: {100 * curved['covered']:.0f} % covered, at most"
        f" {100 * left['dissipation']:.2g}, {100 * left['peak_pressure']:.2g} and"
        f" {100 * left['half_width']:.2g} % left."
    )


def coverage_tables() -> Iterator[str]:
    """What the uncertainties of finite elements did on random scenes, as benchmarks/covered.py
    judged them: between half-planes, those that slip and those that hardly slip; real bodies.
    """
    content = json.loads(COVERED.read_text(encoding="utf-8"))
    of_half_planes = _runs_by_preset(content, "values")
    of_bodies = _runs_by_preset(content, "bodies")
    yield from _coverage_table(of_half_planes, "slip", "Half-planes that slip, against theory")
    yield ""
    yield from _coverage_table(of_bodies, "slip", "Real bodies that slip, against finer meshes")
    yield ""
    least, quantity = _least_covered(of_half_planes, "hardly slip")
    yield (
        "Half-planes that hardly slip (W below 1e-4 A f² P²) are covered to"
        f" {least} % or more, {quantity} the least: group `hardly slip` of"
        " `benchmarks/covered.json`."
    )
    for run in (run for name, run in content.items() if name.startswith("theory ")):
        yield ""
        yield from _theory_coverage(run)


def _least_covered(runs: dict[str, list[dict[str, Any]]], group: str) -> tuple[int, str]:
    """Share [per cent] of the quantity of a group that is covered least, and the quantity."""
    shares = []
    for run in (run for runs_of_preset in runs.values() for run in runs_of_preset):
        for quantity, coverage in run["groups"][group]["quantities"].items():
            shares.append((coverage["covered"], quantity))
    return min(shares)


def _theory_coverage(run: Mapping[str, Any]) -> Iterator[str]:
    """What half-plane theory stated of its own errors, of all quantities of each way, with a head
    line.
    """
    yield f"Half-plane theory's own errors (seed {run['seed']}):"
    yield ""
    rows = []
    for way, counts in run["counts"].items():
        coverages = [
            coverage
            for quantity, coverage in run["quantities"].items()
            if quantity.startswith(f"{way}: ") and coverage["shortfall"] is not None
        ]
        covered = min(coverage["covered"] for coverage in coverages)
        shortfall = max(coverage["shortfall"] for coverage in coverages)
        rows.append([f"{way} ({counts['scenes']})", f"{covered} %", f"{shortfall:g}"])
    yield from table("way (scenes) | covered, least of its quantities | true over stated", rows)


def _runs_by_preset(content: Mapping[str, Any], kind: str) -> dict[str, list[dict[str, Any]]]:
    """The runs of one kind, by the mesh they were made on."""
    runs: dict[str, list[dict[str, Any]]] = {}
    for name, run in content.items():
        if name.startswith(f"{kind} "):
            runs.setdefault(run["preset"], []).append(run)
    return runs


def _coverage_table(runs: dict[str, list[dict[str, Any]]], group: str, words: str) -> Iterator[str]:
    """What uncertainties did in one group of scenes, with a head line."""
    drawn_by_preset = {preset: _drawn(of_preset, group) for preset, of_preset in runs.items()}
    drawn = "; ".join(f"{preset} mesh: {scenes}" for preset, scenes in drawn_by_preset.items())
    if len(set(drawn_by_preset.values())) == 1:
        drawn = next(iter(drawn_by_preset.values()))
    head = "quantity"
    for preset in runs:
        head += f" | covered, {preset} mesh | stated over true | true over stated"
    has_several_seeds = any(len(of_preset) > 1 for of_preset in runs.values())
    yield f"{words} ({drawn}{'; the worst seed' if has_several_seeds else ''}):"
    yield ""
    yield from table(head, _coverage_rows(runs, group))


def _drawn(runs: list[dict[str, Any]], group: str) -> str:
    """Which scenes were judged."""
    scenes = ", ".join(str(run["groups"][group]["scenes"]) for run in runs)
    seeds = ", ".join(str(run["seed"]) for run in runs)
    word = "seeds" if len(runs) > 1 else "seed"
    return f"{scenes} scenes of {word} {seeds}"


def _coverage_rows(runs: dict[str, list[dict[str, Any]]], group: str) -> Iterator[list[str]]:
    """A row for each quantity: the worst of the seeds, which is the least share that is covered and
    the largest of all others.
    """
    first_run = next(iter(runs.values()))[0]
    for quantity in first_run["groups"][group]["quantities"]:
        cells = [quantity]
        for runs_of_preset in runs.values():
            cells += _coverage_cells(runs_of_preset, group, quantity)
        yield cells


def _coverage_cells(runs: list[dict[str, Any]], group: str, quantity: str) -> list[str]:
    """Covered (with the share without an estimate, if any), stated over true, true over stated of a
    quantity.
    """
    coverages = []
    for run in runs:
        quantities = run["groups"][group]["quantities"]
        if quantity in quantities:
            coverages.append(quantities[quantity])
    covered = min(coverage["covered"] for coverage in coverages)
    most_unknown = max(coverage["unknown"] for coverage in coverages)
    share = f"{covered} %"
    if most_unknown:
        share += f" ({most_unknown} % no estimate)"
    judged = [coverage for coverage in coverages if coverage["shortfall"] is not None]
    if not judged:
        return [share, "–", "–"]
    generosity = max(coverage["generosity"] for coverage in judged)
    return [share, f"{generosity:g}", f"{max(coverage['shortfall'] for coverage in judged):g}"]


def between(text: str, words: str, lines: Iterable[str]) -> str:
    """The page with these lines between the two marks of a table."""
    begin = f"<!-- {words}: written by `make pages` -->"
    end = f"<!-- end of {words} -->"
    before, _, rest = text.partition(begin)
    return "\n".join([f"{before}{begin}", "", *lines, "", f"{end}{rest.partition(end)[2]}"])


def table(head: str, rows: Iterable[Iterable[str]], wide: bool = True) -> Iterator[str]:
    """A table; a wide one keeps its numbers whole, and scrolls in a box of its own on a phone.

    A row that has not as many cells as the head is a `ValueError`.
    """
    columns = head.count(" | ") + 1
    yield from ('<div class="wide">', "") if wide else ()
    yield from (f"| {head} |", "|" + "---|" * columns)
    for row in rows:
        cells = list(row)
        if isinstance(row, str) or len(cells) != columns:
            raise ValueError(f"a row of {columns} cells ({head}) is not {row!r}")
        line = f"| {' | '.join(cells)} |"
        yield line.replace(" %", "\u00a0%") if wide else line
    yield from ("", "</div>") if wide else ()


def with_packages(text: str) -> str:
    """The page with the map of packages between its marks."""
    rows = architecture.rows(architecture.packages(), text)
    lines = table("package | what it holds | imports | statements", rows, wide=False)
    return between(text, "the packages", lines)


def with_maps(text: str) -> str:
    """The page with the map of packages, and that of the folders of reports."""
    rows = architecture.rows(architecture.folders(), text)
    lines = table("part of reports | what it holds | statements", rows, wide=False)
    return between(with_packages(text), "the folders", lines)


def third_table(cases: Mapping[str, Any]) -> Iterator[str]:
    """A row for each case: the errors of CalculiX, each beside ours."""
    contents = published()
    rows = []
    for name, case in cases.items():
        scene = name.partition(",")[0]
        rows.append([scene, *third_cells(contents[scene], case)])
    yield from third_rows(cases, rows)


def third_by_bodies(cases: Mapping[str, Any]) -> Iterator[str]:
    """Median and largest error where theory is exact; a row for each of the other cases."""
    contents = published()
    exact_cases = {name: case for name, case in cases.items() if is_exact(name)}
    count = len(exact_cases)
    rows = [
        [f"{count} of like half-planes, median", *third_sizes(contents, exact_cases, np.median)],
        ["the same, largest", *third_sizes(contents, exact_cases, np.max)],
    ]
    rows += [
        [name, *third_cells(contents[name], case)]
        for name, case in cases.items()
        if name not in exact_cases
    ]
    yield from third_rows(cases, rows)


def third_rows(cases: Mapping[str, Any], rows: list[list[str]]) -> Iterator[str]:
    """The table, under the versions and days of its cases."""
    days = sorted({f"{case['code']} on {case['day']}" for case in cases.values()})
    yield from (f"Measured with {', '.join(days)}.", "")
    errors = "peak p: CalculiX | ours | q, L2: CalculiX | ours | W: CalculiX | ours"
    yield from table(f"scene | {errors}", rows)


def third_cells(content: Mapping[str, Any], case: Mapping[str, Any]) -> list[str]:
    """Errors of CalculiX in a case, each beside ours of the scene, in the order of the table."""
    cells = []
    for key in THIRD_METRICS:
        of_calculix = quoting.share(content, key, case["errors"].get(key))
        of_ours = quoting.published_share(content, key)
        cells += [of_calculix or case["failure"] or "–", of_ours or "–"]
    return cells


def third_sizes(
    contents: Mapping[str, Any],
    cases: Mapping[str, Any],
    statistic: Callable[[list[float]], np.floating],
) -> list[str]:
    """A statistic of the sizes of errors of CalculiX and ours, in the order of the table."""
    cells = []
    for key in THIRD_METRICS:
        of_calculix = []
        of_ours = []
        for name, case in cases.items():
            content = contents[name]
            if quoting.share(content, key, case["errors"].get(key)) is None:
                continue
            of_calculix.append(abs(case["errors"][key]))
            of_ours.append(abs(content["frozen"][f"metric.{key}"]))
        cells += [f"{100 * statistic(sizes):.2g} %" for sizes in (of_calculix, of_ours)]
    return cells


def is_exact(name: str) -> bool:
    """Whether half-plane theory is exact for the bodies of a scene of the library."""
    return are_half_planes(load_scene(name))


def third_file() -> str:
    """Every case of one revolution, as CSV: the errors of CalculiX, each beside ours."""
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    columns = [f"{key}, {code}" for key in THIRD_METRICS for code in ("CalculiX", "ours")]
    rows.writerow(["scene", *columns])
    contents = published()
    for name, case in once_around(third()).items():
        rows.writerow([name, *third_cells(contents[name], case)])
    return written.getvalue()


# ------------------------------------------------------------------------------------- verification


METRICS = {
    "dissipation": "W",
    "peak_pressure": "peak p",
    "pressure": "p",
    "shear": "q",
    "stick_edge": "stick edge",
}


def verification() -> Iterator[str]:
    """Requirements, whose tests stand in docs/requirements.toml; then the errors of every scene."""
    scenes = published()
    yield from ("# Verification", "", WRITTEN, "")
    yield (
        "Requirements ([requirements.toml](requirements.toml) names their tests), then every scene"
        " of the library, finite elements against theory."
    )
    yield from ("", "## Requirements", "")
    for area, of_area in requirements().items():
        sentences = [f"{cell(row['requirement'])}." for row in of_area]
        yield f"- **{area}**: {' '.join(sentences)}"
    verdicts = [
        [is_met for is_met in content["accurate"].values() if is_met is not None]
        for content in scenes.values()
    ]
    laws = sum(content["admissible"] for content in scenes.values())
    met = sum(map(all, verdicts))
    yield from ("", "## Scenes", "")
    yield (
        "Error = finite elements/theory − 1, default settings; p and q in L2; stick edge over the"
        " half-width; *abs.*: over A f² P², where theory has no dissipation. **Bold**: outside the"
        f" tolerance. {laws} of {len(scenes)} scenes satisfy every law of contact, {met} every"
        " tolerance; the others have finite bodies or unlike materials."
    )
    yield ""
    rows = []
    for name, content in scenes.items():
        link = f"[{name}](../reports/published/{name}.md)"
        rows.append([link, *(error(content, key) for key in METRICS)])
    yield from table(f"scene | {' | '.join(METRICS.values())}", rows)


def requirements() -> dict[str, list[dict[str, Any]]]:
    """Area -> requirements with their tests: docs/requirements.toml."""
    table = tomllib.loads((FOLDER / "requirements.toml").read_text(encoding="utf-8"))
    return {area["title"]: area["requirements"] for area in table["area"]}


def error(content: Mapping[str, Any], key: str) -> str:
    """A metric of a published scene, bold if it is outside its tolerance."""
    value = content["frozen"].get(f"metric.{key}")
    if value is None:
        return "–"
    text = quoting.published_share(content, key) or f"{value:.2g} abs.".replace("-", "−")
    return f"**{text}**" if content["accurate"][key] is False else text


# ------------------------------------------------------------------------------------------- scenes
def scenes_page(text: str) -> str:
    """The page of scenes with its tables: scenes of given loads, and rigs."""
    with_scenes = between(text, "the library", library(scene_names()))
    return between(with_scenes, "the rigs", library(rig_names()))


def library(names: Iterable[str]) -> Iterator[str]:
    """The table of scenes: a line a scene."""
    rows = []
    for scene in map(load_scene, names):
        dissipations = [
            dissipation(scene, name) for name in ("half-plane theory", "finite elements")
        ]
        rows.append([f"`{scene.name}`", cell(scene.title), *dissipations])
    yield from table("scene | what it is | W, theory | W, finite elements", rows)


def dissipation(scene: Scene, engine: str) -> str:
    """W that one engine must have, in six digits; the first where several sources have one."""
    for entry in scene.expected:
        if entry.engine == engine and entry.quantity == "dissipation":
            return f"{entry.value:.6g}"
    return "–"


def expected() -> str:
    """Every expected number of the library, with its tolerance and source."""
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    rows.writerow(["scene", "quantity", "value", "tolerance", "engine", "source"])
    for scene in map(load_scene, (*scene_names(), *rig_names())):
        for entry in scene.expected:
            rows.writerow(
                [
                    scene.name,
                    entry.quantity,
                    f"{entry.value:.9g}",
                    f"{entry.tolerance:g}",
                    entry.engine,
                    entry.source,
                ]
            )
    return written.getvalue()


def cell(text: str) -> str:
    """Words that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ").replace("*", "\\*").replace("_", "\\_")


# ------------------------------------------------------------------------------- gallery, misprints


def gallery() -> Iterator[str]:
    """The published picture of every scene."""
    yield from ("# Gallery", "", WRITTEN, "")
    yield (
        "Both engines on every scene of the [library](scenes.md#the-library). A title leads to all"
        " values of the scene; `halfplane run NAME` makes the interactive page."
    )
    for name in scene_names():
        yield from ("", f"## [{name}](../reports/published/{name}.md)", "")
        yield f"![{name}](../reports/published/{name}.svg)"
    yield from (
        "",
        "## Rigs",
        "",
        "Loops of the [scenes that prescribe a displacement](scenes.md#rigs), by theory.",
        "",
        f"![Loops of the rigs]({LOOPS})",
    )


def loops_of_rigs() -> str:
    """The picture of the loops of all rigs of the library, by theory."""
    motions = []
    for scene in map(load_scene, rig_names()):
        effects = None if scene.bodies.half_planes else halfplane_fe.body_effects(scene)
        solution = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",), effects=effects)
        motions.append(RigMotion(scene, solution))
    return loops(motions).svg() + "\n"


def misprint_page(examples: Paper) -> Iterator[str]:
    """The paper's misprints: what is printed, what is right."""
    rows = misprints(examples)
    yield from ("# The paper's misprints", "", WRITTEN, "")
    yield (
        f"{sum(row.proven is True for row in rows)} of {len(rows)} are proven by a number"
        " ([misprints.csv](misprints.csv), `halfplane paper`), the rest by reading. The equations"
        " are those of the paper; [Theory](theory.md) derives the right ones."
    )
    yield ""
    cells = []
    for row in rows:
        place = row.where if row.key in row.where else f"{row.key}: {row.where}"
        cells.append([prose(place), prose(row.printed), prose(row.right)])
    yield from table("where | printed | right", cells, wide=False)


def misprint_proofs(examples: Paper) -> str:
    """The numbers that tell what is printed from what is right, as CSV."""
    written = io.StringIO()
    rows = csv.writer(written, lineterminator="\n")
    rows.writerow(["key", "where", "printed", "right", "proof", "proven"])
    for row in misprints(examples):
        cells = [row.key, row.where, row.printed, row.right, row.proof, proven_in_words(row)]
        rows.writerow(cells)
    return written.getvalue()


def prose(text: str) -> str:
    """Words as they are, where Markdown would read marks into them."""
    return re.sub(r"([*_|\[\]<>])", r"\\\1", text)


def main() -> int:
    """Write what is not as the files and engines say."""
    for name, text in (made() | {LOOPS: loops_of_rigs()}).items():
        path = FOLDER / name
        before = path.read_text(encoding="utf-8") if path.is_file() else ""
        stale = without_rounding(before) != without_rounding(text)
        if stale:
            path.write_text(text, encoding="utf-8")
        print(f"{name}: {'written' if stale else 'as it was'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
