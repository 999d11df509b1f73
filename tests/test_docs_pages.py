"""The manual and the README: examples run and print what pages say, made pages are current, what
pages name exists, plain words.
"""

from __future__ import annotations

import ast
import hashlib
import html
import importlib
import io
import json
import os
import re
import sys
import tokenize
import tomllib
import unicodedata
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import nbclient
import nbformat
import numpy as np
import pytest
from PIL import Image

import semi_analytic
from command_line import COARSE, HERTZ_SCENE, halfplane
from fuzzing import DOORS
from reports.cli.application import app
from scenes import Scene, Tolerances, load_scene, rig_names, scene_names, scene_text
from scenes.loads import BULK_AND_TILT_KEYS
from semi_analytic.elasticity import composite_modulus
from semi_analytic.hertz import HertzContact

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
sys.path.append(str(DOCS))
pages: Any = importlib.import_module("pages")
quoting: Any = importlib.import_module("quoting")
reference: Any = importlib.import_module("reference")
architecture: Any = importlib.import_module("architecture")
executed: Any = importlib.import_module("executed")
report_picture: Any = importlib.import_module("report_picture")

FILES = sorted([*DOCS.glob("*.md"), *DOCS.glob("api/*.md")])
TEXTS = {str(path.relative_to(DOCS)): path.read_text(encoding="utf-8") for path in FILES}
RUNNABLE = [name for name, text in TEXTS.items() if "/" not in name and executed.runnable(text)]
PACKAGES = {"scenes", "semi_analytic", "meshes", "halfplane_fe", "reports"}
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)
NOTEBOOK = DOCS / "first-steps.ipynb"
NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
ROLE = re.compile(r"\{py:\w+\}`(?:[^`<]*<)?~?([\w.]+)>?`")
HUNDREDTH = 0.02  # of a point; another processor turns a last digit round
RENEW = "run `make pages`, and look at what moved"


# ----------------------------------------------------------------------------------------- examples
def parts_of_drawing(svg: str) -> tuple[list[tuple[str, str | None]], np.ndarray]:
    """Elements with their words; all numbers but those of references."""
    elements = [(element.tag, element.text) for element in ET.fromstring(svg).iter()]
    plain = re.sub(r'(id|href)="[^"]*"|url\([^)]*\)', "", svg)
    return elements, np.array([float(word) for word in NUMBER.findall(plain)])


def same_drawing(drawing: str, copy: str) -> bool:
    """Whether two drawings have the same elements and words, with numbers that differ by no more
    than is seen.
    """
    elements, numbers = parts_of_drawing(drawing)
    elements_again, numbers_again = parts_of_drawing(copy)
    same = elements == elements_again and len(numbers) == len(numbers_again)
    return same and bool(np.all(np.abs(numbers - numbers_again) <= HUNDREDTH))


@pytest.mark.parametrize("name", RUNNABLE)
def test_a_page_says_what_its_blocks_print(name: str, tmp_path: Path) -> None:
    assert executed.run(TEXTS[name], tmp_path) == TEXTS[name], f"docs/{name} is stale: {RENEW}"
    for picture in tmp_path.glob("*.svg"):
        stored = (DOCS / "figures" / picture.name).read_text(encoding="utf-8")
        assert same_drawing(stored, picture.read_text(encoding="utf-8")), (
            f"docs/figures/{picture.name} is stale: {RENEW}"
        )
        assert f"figures/{picture.name}" in TEXTS[name]


@pytest.mark.slow
def test_loops_of_rigs_are_those_of_theory() -> None:
    stored = (DOCS / pages.LOOPS).read_text(encoding="utf-8")
    assert same_drawing(stored, pages.loops_of_rigs()), f"docs/{pages.LOOPS} is stale: {RENEW}"


def test_how_tos_have_examples_and_every_picture_and_figure_is_shown() -> None:
    expected = {
        "quick-start",
        "tutorial",
        "theory",
        "score-abaqus",
        "own-profile",
        "measured-loads",
        "sweeps",
    }
    assert {
        f"{name}.md" for name in (*expected, "read-the-error-budget", "penalty-or-lagrangian")
    } <= set(RUNNABLE)
    pictures = {
        target
        for name, text in TEXTS.items()
        if "/" not in name
        for target in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)
    }
    assert not [target for target in pictures if not (DOCS / target).is_file()]
    assert {f"figures/{path.name}" for path in (DOCS / "figures").iterdir()} <= pictures


PRINTS_TOML = """```{code-block} toml
:caption: a.toml

x = 1
```

```python
from pathlib import Path

print(Path("a.toml").read_text(), end="")
```

```text
?
```
"""
# A page -> as it must be after a run: another number, text that is no output, a command that ends
# as the page says, a file.
RUN_PAGES = {
    "```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n": ("3", "2"),
    "```python\nprint(1)\n```\n\nLook:\n\n```text\nanything\n```\n": ("", ""),
    "```console\n$ halfplane rnu # ends with 2\n```\n": ("", ""),
    PRINTS_TOML: ("?", "x = 1"),
}


@pytest.mark.parametrize("page", RUN_PAGES)
def test_a_page_that_is_run_has_what_its_blocks_print(page: str, tmp_path: Path) -> None:
    assert executed.run(page, tmp_path) == page.replace(*RUN_PAGES[page])


def test_planted_faults_of_a_page_are_seen(tmp_path: Path) -> None:
    """A block that fails, a command that ends otherwise, a curve that moved."""
    with pytest.raises(ZeroDivisionError):
        executed.run("```python\n1 / 0\n```\n", tmp_path)
    with pytest.raises(executed.StaleError, match="ended with 2"):
        executed.run("```console\n$ halfplane rnu\n```\n", tmp_path)
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 1.00 2.00 L 3 4"/><text>a</text></svg>'
    )
    assert same_drawing(drawing, drawing.replace("1.00", "1.001"))
    assert not same_drawing(drawing, drawing.replace("1.00", "1.10"))
    assert not same_drawing(drawing, drawing.replace(">a<", ">b<"))


@pytest.mark.slow
def test_the_notebook_runs_and_shows_scene_solution_and_comparison(tmp_path: Path) -> None:
    os.environ.setdefault("PYDEVD_DISABLE_FILE_VALIDATION", "1")
    book = nbformat.read(NOTEBOOK, as_version=4)
    nbclient.NotebookClient(
        book, timeout=1200, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    outputs = [output for cell in book.cells if cell.cell_type == "code" for output in cell.outputs]
    tables = [
        output["data"]["text/html"] for output in outputs if "text/html" in output.get("data", {})
    ]
    assert any("Cattaneo-Mindlin" in html for html in tables)
    assert any("tolerance" in html for html in tables)
    streams = [output for output in outputs if output["output_type"] == "stream"]
    assert "0.0012117117" in "".join(
        output["text"] for output in streams if output["name"] == "stdout"
    )
    assert not [output for output in streams if output["name"] == "stderr"]


def test_the_picture_of_the_readme_shows_the_run_whose_numbers_the_readme_quotes() -> None:
    """Both are written by one run, and the picture carries the numbers of its run."""
    with Image.open(DOCS / "figures" / "report.png") as picture:
        values = json.loads(picture.text["values"])
    assert values == json.loads((DOCS / "uncertainty.json").read_text(encoding="utf-8"))


def test_the_notebook_is_kept_without_outputs() -> None:
    book = nbformat.read(NOTEBOOK, as_version=4)
    assert not [
        cell
        for cell in book.cells
        if cell.cell_type == "code" and (cell.outputs or cell.execution_count)
    ]


# ------------------------------------------------------------------------------------------- README
def blocks(language: str) -> list[str]:
    return [text for kind, text in BLOCKS if kind == language]


@pytest.mark.parametrize(
    "options", [COARSE, pytest.param((), marks=pytest.mark.slow)], ids=["coarse", "as it stands"]
)
def test_the_scene_of_the_readme_runs_through_both_engines(
    options: tuple[str, ...], tmp_path: Path
) -> None:
    (text,) = blocks("toml")
    (tmp_path / "roller.toml").write_text(text, encoding="utf-8")
    assert halfplane(tmp_path, "check", "roller.toml").returncode == 0
    run = halfplane(tmp_path, "run", "roller.toml", *options)
    assert run.returncode == (1 if options else 0), run
    assert (tmp_path / "out" / "roller" / "report.html").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("text", blocks("python"))
def test_python_blocks_of_the_readme_run(
    text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(text, "README.md", "exec"), {})


def test_the_names_in_the_readme_are_there() -> None:
    """Targets of make, commands, linked files; CI installs what it says and calls make test."""
    called = {
        word
        for text in blocks("sh")
        for word in re.findall(r"^make (\w+)", text, flags=re.MULTILINE)
    }
    targets = set(
        re.findall(
            r"^([a-z-]+):.*##", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE
        )
    )
    assert {"run", "test"} <= called <= targets
    named = set(re.findall(r"^\| `halfplane (\w+)", README, flags=re.MULTILINE))
    assert named
    assert named <= set(app)
    links = [target for target in re.findall(r"\]\(([^)#]+)\)", README) if "://" not in target]
    assert links
    assert all((ROOT / target).exists() for target in links)
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    assert "README.md" in script
    assert re.search(r"^(exec )?make test$", script, flags=re.MULTILINE)


# --------------------------------------------------------------------------------------- made pages
def uncertainty() -> dict[str, dict[str, float]]:
    return json.loads((DOCS / "uncertainty.json").read_text(encoding="utf-8"))["blocks"]


def test_the_first_result_and_its_uncertainty_are_those_of_a_run() -> None:
    """Values as published; no page states an uncertainty of theory on `blocks` by hand."""
    frozen = pages.published()["blocks"]["frozen"]
    *metrics, cause = uncertainty()
    assert cause == "curvature under Q"
    for key, number in uncertainty().items():
        if key in metrics:
            assert number["value"] == pytest.approx(frozen[f"metric.{key}"], rel=1e-6)
        assert 0 < number["uncertainty"] < abs(number["value"])
        words = quoting.uncertain_values({"blocks": uncertainty()})[
            f"± u: {key.replace('_', ' ')}, blocks"
        ]
        for name in ("README.md", "docs/index.md"):
            text = (DOCS.parent / name).read_text(encoding="utf-8")
            assert f"-->{words}<!-- /n --> %" in text
            assert not re.search(r"<!-- /n -->\s*±", text)


def test_the_first_page_shows_tractions_and_causes_of_the_run_that_it_quotes() -> None:
    """Stored figures: the waterfall has the quoted values, words fit the column of a phone."""
    for name in report_picture.FIGURES.values():
        assert f"](figures/{name})" in TEXTS["index.md"]
        drawing = ET.parse(DOCS / "figures" / name).getroot()
        assert float(drawing.attrib["width"]) == report_picture.WIDTH <= 390 - 2 * 16
    waterfall = (DOCS / "figures" / report_picture.FIGURES["waterfall"]).read_text(encoding="utf-8")
    for key in ("dissipation", "curvature under Q"):
        value = f"{100 * uncertainty()[key]['value']:.2f}".replace("-", "−")
        assert f": {value} ± " in waterfall


@pytest.mark.slow
def test_the_figures_of_the_first_page_are_drawn_again() -> None:
    for name, drawing in report_picture.drawn().items():
        stored = (DOCS / "figures" / name).read_text(encoding="utf-8")
        assert same_drawing(stored, drawing), f"docs/figures/{name} is stale: {RENEW}"


@pytest.mark.slow
def test_the_uncertainty_of_the_first_result_is_measured_again(tmp_path: Path) -> None:
    """To 5 %: counts of increments differ between processors."""
    for key, number in report_picture.measured(tmp_path).items():
        assert number["uncertainty"] == pytest.approx(uncertainty()[key]["uncertainty"], rel=0.05)


@pytest.fixture(scope="module")
def made_pages() -> dict[str, str]:
    return dict(pages.made())


MARKED = {
    name: text for name, text in {**TEXTS, "../README.md": README}.items() if "<!-- n:" in text
}
GENERATED = {
    *(
        f"{name}.md"
        for name in ("verification", "scenes", "gallery", "misprints", "third", "metrics")
    ),
    "expected.csv",
    "headings.csv",
    "misprints.csv",
    "third.csv",
}
GENERATED |= {"architecture.svg"}


@pytest.mark.parametrize("name", sorted(MARKED.keys() | GENERATED))
def test_pages_are_what_files_and_engines_say(made_pages: dict[str, str], name: str) -> None:
    stored = (DOCS / name).read_text(encoding="utf-8")
    assert pages.without_rounding(stored) == pages.without_rounding(made_pages[name]), (
        f"docs/{name} is stale: {RENEW}"
    )


def test_each_number_in_a_text_has_a_key_two_marks_and_no_mark_at_the_start_of_a_line() -> None:
    """A line that starts with a comment is HTML to Markdown, and what follows on it would be shown
    raw.
    """
    assert len(MARKED) > 8
    assert all(
        len(quoting.NUMBER.findall(text)) == text.count("<!-- n:") == text.count("<!-- /n -->")
        for text in MARKED.values()
    )
    assert not [
        name
        for name, text in MARKED.items()
        if re.search(r"^[ >]*(?:[-*]|\d+\.)? *<!-- n:", text, re.M)
    ]


def test_values_are_quoted_by_keys_with_two_digits_and_a_unit_and_rounding_is_forgiven() -> None:
    """Planted: a number changed by hand, a key that is not there."""
    page = "a <!-- n:scenes -->34<!-- /n -->, <!-- n:scenes -->0<!-- /n --> b"
    assert quoting.with_numbers(page, {"scenes": "33"}) == page.replace("34", "33").replace(
        "0<", "33<"
    )
    with pytest.raises(KeyError, match="no such key"):
        quoting.with_numbers("<!-- n:no such key -->1<!-- /n -->", {"scenes": "33"})
    assert pages.without_rounding("off by 3e-16 and 0") == pages.without_rounding(
        "off by 0 and 2.5e-15"
    )
    assert pages.without_rounding("off by 3e-06, 0.7270") == "off by 3e-06, 0.7270"


def test_the_third_solver_is_what_was_measured_and_published() -> None:
    """Every case of benchmarks/third.json is in the page, its CSV file or quoted, and a value
    changed by hand does not stay.
    """
    page = TEXTS["third.md"]
    cases = pages.third()
    rows = [
        line
        for line in page.splitlines()
        if line.count(" | ") == 6 and not line.startswith("| scene |")
    ]
    forged = page.replace(rows[0], " | ".join([*rows[0].split(" | ")[:-1], "+99 %"]))
    assert forged != page
    assert pages.third_solver(forged) == page
    twice = sum(name.endswith(pages.TWICE) for name in cases)
    in_the_file = pages.third_file().splitlines()[1:]
    assert len(in_the_file) > 24
    assert len(cases) == twice + len(in_the_file) + 1
    single_rows = sum(not pages.is_exact(name) for name in pages.once_around(cases))
    assert len(rows) == twice + 2 + single_rows
    assert "<!-- n:CalculiX, cattaneo-mindlin, stick slope 50: shear -->" in page
    # The report's sentence on CalculiX' friction history quotes the second revolutions.
    source = (ROOT / "reports" / "templates" / "words.txt").read_text(encoding="utf-8")
    varying, constant = (
        cases[f"{name}, 2 revolutions"]["errors"]["dissipation"]
        for name in ("hertz-paper", "cattaneo-mindlin")
    )
    assert f"{100 * varying:+.0f} % of the dissipation of" in source
    assert f"{100 * constant:+.0f} % of cattaneo-mindlin's" in source


def test_the_page_on_faults_states_how_many_file_kinds_were_counted_and_how_many_there_are() -> (
    None
):
    """A kind that is new in tests/fuzzing.py, and a new count of `make numbers`, change the
    sentence.
    """
    rows = json.loads((DOCS / "numbers.json").read_text(encoding="utf-8"))["Faults and bad input"][
        "rows"
    ]
    (counted,) = re.findall(r"for each of (\d+) kinds", rows[0]["how"])
    assert (
        f"on {counted} file kinds; `tests/fuzzing.py` has {len(DOORS)} now" in TEXTS["security.md"]
    )


def test_every_test_of_a_requirement_exists() -> None:
    rows = [row for area in pages.requirements().values() for row in area]
    assert len(rows) > 20
    assert all(row["tests"] for row in rows)
    for file, _, name in (test.partition("::") for row in rows for test in row["tests"]):
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert not name or f"def {name.split('::')[-1]}(" in text, f"{file} has no {name}"


def test_the_architecture_is_that_of_the_contracts(tmp_path: Path) -> None:
    contracts = architecture.read(ROOT / "pyproject.toml")
    assert set(contracts.depth) == PACKAGES
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    moved_up = text.replace(
        '"reports", "semi_analytic | halfplane_fe"', '"reports | halfplane_fe", "semi_analytic"'
    )
    (tmp_path / "pyproject.toml").write_text(moved_up, encoding="utf-8")
    assert architecture.svg(tmp_path / "pyproject.toml") != architecture.svg(
        ROOT / "pyproject.toml"
    )


# ----------------------------------------------------------------------------------------- formulas
FORMULAS = (
    *(
        "Hertz law",
        "flat-and-rounded law",
        "power law",
        "Ciavarella-Jaeger superposition",
        "Cattaneo-Mindlin traction",
    ),
    *(
        "memory curve",
        "Masing reversal",
        "Coulomb limit",
        "permanent stick zone",
        "slip outside the stick zone",
    ),
    *(
        "relative tangential displacement",
        "pointwise dissipation",
        "global dissipation",
        "W of a steady ellipse",
    ),
    *(
        "hysteresis damping",
        "gross-sliding check",
        "separation",
        "Abel transform",
        "events",
        "return mapping",
    ),
    *("static condensation (Schur complement)", "Flamant far field", "dual mortar", "active set"),
)
TABLE = [
    re.split(r" *(?<!\\)\| *", line)[1:-1]
    for line in TEXTS["api/formulas.md"].splitlines()
    if line.startswith("| ") and not line.startswith("| formula")
]
TARGETS = sorted({target for row in TABLE for target in ROLE.findall(row[2])})


def example(target: str) -> str | None:
    """The docstring that a dotted name leads to; None where there is no such thing."""
    with suppress(ImportError, AttributeError):
        return str(resolve_name(target).__doc__)
    return None


def test_the_table_of_formulas_holds_each_with_source_function_and_example() -> None:
    """The examples themselves are run where they stand, with the modules."""
    assert all(len(row) == 4 and all(row) and ROLE.search(row[2]) for row in TABLE)
    first_column = "\n" + "\n".join(row[0] for row in TABLE)
    assert not [name for name in FORMULAS if f"\n{name}" not in first_column]
    assert not [target for target in TARGETS if ">>> " not in (example(target) or "")]
    linked = set(ROLE.findall(TEXTS["theory.md"]))
    assert len(linked) > 15
    assert not [target for target in linked if example(target) is None]
    page = TEXTS["api/formulas.md"]
    assert not [
        target for target in linked if target not in page and target.rpartition(".")[0] not in page
    ]


# Words under which a contact engineer looks.
USUAL_WORDS = (
    *("equivalent", "reduced", "contact, effective", "half-width", "peak pressure"),
    *("rounded corners", "constant normal load", "stick half-width", "gross slip"),
    *("Smith-Watson-Topper", "Fatemi-Socie", "Findley"),
)


def test_everyday_formulas_come_first_under_their_usual_words() -> None:
    page = TEXTS["api/formulas.md"]
    everyday = page[page.index("## Everyday formulas") : page.index("## All formulas")]
    assert not [words for words in USUAL_WORDS if words not in everyday]


def test_everyday_formulas_are_what_the_functions_give() -> None:
    """The closed forms of a Hertz contact at constant P, as the page prints them."""
    scene = load_scene("cattaneo-mindlin")
    modulus = composite_modulus(scene.material)
    radius = scene.profile.radius
    path = scene.load.path()
    normal, tangential = (float(np.max(load)) for load in path.at([path.cycle_start, 2.0]))
    contact = HertzContact(modulus, radius, datum_length=scene.profile.datum_length)
    half_width = np.sqrt(4 * normal * radius / (np.pi * modulus))
    assert contact.half_width(normal) == pytest.approx(half_width, rel=1e-14)
    peaks = (
        2 * normal / (np.pi * half_width),
        modulus * half_width / (2 * radius),
        np.sqrt(normal * modulus / (np.pi * radius)),
    )
    assert peaks == pytest.approx([float(contact.pressure(0.0, normal))] * 3, rel=1e-14)
    f = scene.friction.coefficient
    share = tangential / (f * normal)
    answer = semi_analytic.solve(scene)
    stick = answer.stick_half_width[np.argmin(np.abs(answer.time - 2.0))]
    assert stick == pytest.approx(half_width * np.sqrt(1 - share), rel=1e-9)
    work = 2 * share - share**2 + 2 * (1 - share) * np.log(1 - share)
    work *= 2 * f**2 * normal**2 / (np.pi * modulus)
    assert answer.dissipation == pytest.approx(work, rel=1e-9)


def test_each_package_has_its_page_and_the_citation_is_of_this_version() -> None:
    assert {name[len("api/") : -len(".md")] for name in TEXTS if name.startswith("api/")} - {
        "formulas"
    } == PACKAGES
    assert all(f".. automodule:: {package}\n" in TEXTS[f"api/{package}.md"] for package in PACKAGES)
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f'version: "{version("halfplane")}"' in citation
    pyproject = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert f"license: {pyproject['project']['license']}\n" in citation


# ---------------------------------------------------------------------------- the paper's own words
def runs(text: str) -> dict[bytes, str]:
    """Digest, as in tests/data/paper.bin -> nine words or numbers that follow each other, in lower
    case.

    Tags, escapes, LaTeX commands and the prefixes of Python's strings are no words.
    """
    text = re.sub(r"<[^<>]{0,300}>|\\n|\\[a-zA-Z]+|\b[fr]{1,2}(?=[\"'])", " ", html.unescape(text))
    words = re.findall(r"[a-z0-9]+", unicodedata.normalize("NFKD", text).lower())
    each = (" ".join(words[k : k + 9]) for k in range(len(words) - 8))
    return {hashlib.blake2b(run.encode(), digest_size=5).digest(): run for run in each}


def test_the_paper_is_quoted_nowhere() -> None:
    """No nine words in a row are the paper's, but for its title; formulas and numbers are left
    out.
    """
    stored = (ROOT / "tests" / "data" / "paper.bin").read_bytes()
    paper = {stored[k : k + 5] for k in range(0, len(stored), 5)}
    assert len(paper) > 4000
    # what people wrote, and the pages that are made from it
    kinds = {".py", ".md", ".html", ".toml", ".txt", ".ipynb"}
    below = [
        path
        for name in (*PACKAGES, "halfplane", "benchmarks", "docs", "tests")
        for path in (ROOT / name).rglob("*")
    ]
    files = [
        path
        for path in (*ROOT.glob("*.md"), *below)
        if path.suffix in kinds and "_build" not in path.parts
    ]
    assert {
        ROOT / "README.md",
        DOCS / "misprints.md",
        *(ROOT / "reports" / "studies" / "paper").glob("*.py"),
    } <= set(files)
    texts = {str(path.relative_to(ROOT)): runs(path.read_text(encoding="utf-8")) for path in files}
    assert not {name: text[key] for name, text in texts.items() for key in text.keys() & paper}
    # A quotation is seen through line breaks, markup and the joints of strings.
    planted = runs("one two three four five six seven eight nine").keys()
    assert (
        runs('("zero One two, *three*, four "\n f"five <b>six</b> seven-eight nine ten")').keys()
        & planted
    )
    assert not runs("one two three four five six seven eight ten").keys() & planted


# ---------------------------------------------------------------------------------- keys of a scene
SCENE_KEYS = TEXTS["scene-keys.md"]
# Numbers without a dimension.
PLAIN = {
    "poisson_ratio",
    "coefficient",
    "friction",
    "exponent",
    "asymmetry",
    "value",
    "tolerance",
    "cycles",
    "average",
}
PLAIN |= {*Tolerances.model_fields, "freedom", "weight", "left_out"}
PLAIN |= {"mean", "amplitude"}  # of a wave, in the unit of its key
PLAIN |= {"row"}  # a count


def test_the_table_of_scene_keys_is_what_the_models_say() -> None:
    """A key, a default and a range changed by hand do not stay."""
    assert reference.page(SCENE_KEYS) == SCENE_KEYS, f"docs/scene-keys.md is stale: {RENEW}"
    forgeries = {
        "| `ellipse` | `phase_degrees` |": "| `ellipse` | `phase` |",
        "| `90.0` | ≥": "| `0.0` | ≥",
        "| `90.0` | ≥ −180, ≤ 180 |": "| `90.0` | any number |",
    }
    for old, new in forgeries.items():
        assert SCENE_KEYS.count(old) == 1
        assert reference.page(SCENE_KEYS.replace(old, new)) == SCENE_KEYS


def numeric_keys(schema: Any) -> Iterator[tuple[str, str]]:
    """(key, description) of every key that is a number; what a table states of a column is in the
    unit of that column.
    """
    for model in (
        schema,
        *(
            model
            for name, model in schema["$defs"].items()
            if not name.startswith(("OfLoads", "OfProfile"))
        ),
    ):
        for key, rule in model["properties"].items():
            kinds = {rule.get("type"), *(option.get("type") for option in rule.get("anyOf", ()))}
            if kinds & {"number", "integer"}:
                yield key, rule.get("description", "")


def test_every_number_with_a_dimension_states_its_unit() -> None:
    keys = list(numeric_keys(Scene.model_json_schema()))
    assert len(keys) > 30
    assert not [
        key for key, words in keys if key not in PLAIN and reference.unit(key, words) == "–"
    ]


def test_every_key_of_the_library_is_in_its_table() -> None:
    """From the files, not from the models: a key that the schema hides would be missed
    otherwise.
    """
    for name in (*scene_names(), *rig_names()):
        scene = tomllib.loads(scene_text(name))
        tables = [scene["profile"], scene["load"], *scene.get("bodies", {}).values()]
        missing = []
        for table in tables:
            keys = table.keys() - {"kind", *BULK_AND_TILT_KEYS}
            of_kind = rf"\| [^|]*`{table['kind']}`[^|]* \| `{{}}` \|"
            missing += [key for key in keys if not re.search(of_kind.format(key), SCENE_KEYS)]
        missing += [
            key
            for key in scene["load"]
            if key in BULK_AND_TILT_KEYS and f"| `{key}` |" not in SCENE_KEYS
        ]
        missing += [key for key in scene if not re.search(rf"\| `{key}` \||`\[+{key}", SCENE_KEYS)]
        assert not missing, name


# ---------------------------------------------------------------------------------- troubleshooting
TROUBLE = TEXTS["troubleshooting.md"].replace("\\|", "|")
SCENE = (
    HERTZ_SCENE
    + """[load]
kind = "polygon"
initial_loading = [[90.0, 0.0]]
cycle = [[90.0, 27.0], [90.0, -27.0]]
"""
)
BLOCK = '[bodies.lower]\nkind = "block"\nwidth = 20.0\nheight = 5.0\n'
RECORD = (
    '"polygon"\ninitial_loading = [[90.0, 0.0]]\ncycle = [[90.0, 27.0], [90.0, -27.0]]',
    '"time_series"\nfile = "rec.csv"',
)
FOOT = ('"hertz"\nradius = 1000.0', '"tabulated"\nfile = "foot.csv"')
# Key of the scene that is spoilt, what it becomes, parts of the message.
SPOILT = [
    (("radius", "radus"), ["unknown key profile.radus = 1000.0; did you mean radius?"]),
    (("cycle =", "wear_rate = 10.0\ncycle ="), ["wear is not modelled"]),
    (("90.0, 27.0", "90.0, 47.0"), ["gross sliding from time ", "|Q| exceeds f P"]),
    (("90.0, -27.0", "-10.0, -3.0"), ["separation from time ", "P is negative there"]),
    (
        (SCENE, SCENE + BLOCK.replace("20.0", "1.0")),
        ["the contact ", "reaches past the end of the narrower face"],
    ),
    (
        (SCENE, SCENE + BLOCK + 'base = "rollers"\n'),
        ["nothing holds the block against the tangential load"],
    ),
    (RECORD, ["rec.csv, line 4: P = 'x' is not a finite number"]),
    (FOOT, ["foot.csv, line 4: h = 0.4 falls: the profile must rise"]),
    (
        ("210e3", "210"),
        [
            "material.young_modulus = 210 MPa is as soft as a weak plastic; steel has 210000 MPa."
            " Is E in GPa?"
        ],
    ),
]
# Parts of messages that take a whole run, and the file that prints them.
OF_RUNS = {
    "halfplane_fe/contact.py": ["nodes still change state after ", "iterations at time "],
    "halfplane_fe/solution.py": ["the contact reached the end of the meshed side"],
    "halfplane_fe/resolution.py": [
        "elements from its middle to its edge where it is smallest",
        "elements wide at most",
    ],
    "meshes/bodies.py": ["nodes on its contact, and the limit is "],
    "reports/cli/application.py": [
        "there is not enough memory for this",
        "ask for a coarser mesh, fewer steps or fewer instants",
    ],
    "reports/cli/solving.py": [
        "pictures can't be drawn here: ",
        "--no-pictures leaves them out",
        "this counts as outside: exit code ",
        "no uncertainty was measured: the record has ",
        "--budget measures it",
    ],
    "reports/folder.py": ["is there already and halfplane did not write it"],
}


@pytest.mark.parametrize(("edit", "parts"), SPOILT, ids=[parts[0][:30] for _, parts in SPOILT])
def test_check_prints_what_the_page_quotes(
    edit: tuple[str, str], parts: list[str], tmp_path: Path
) -> None:
    (tmp_path / "rec.csv").write_text("time,P,Q\n0,0,0\n1,90,0\n2,x,3\n", encoding="utf-8")
    (tmp_path / "foot.csv").write_text("x,h\n0,0\n1,0.5\n2,0.4\n", encoding="utf-8")
    (tmp_path / "my.toml").write_text(SCENE.replace(*edit), encoding="utf-8")
    outcome = halfplane(tmp_path, "check", "my.toml")
    assert outcome.returncode == (0 if "Is E in GPa?" in parts[0] else 2)
    assert not [
        part
        for part in parts
        if part not in " ".join((outcome.stdout + outcome.stderr).split()) or part not in TROUBLE
    ]


def test_messages_of_long_runs_are_in_the_code_and_on_the_page() -> None:
    for file, parts in OF_RUNS.items():
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)]
        source = "\n".join(text for text in texts if isinstance(text, str))
        assert not [part for part in parts if part not in source or part not in TROUBLE], file


# -------------------------------------------------------------------- plain words, and not too many
# Phrase -> what to write.
PHRASES = {
    "is told": "is reported, is stated",
    "are told": "are reported, are stated",
    "way in": "initial loading",
    "off by": "error of",
    "the system refuses": "cannot read FILE: reason",
    "has no use for": "unexpected argument",
    "suffers from": "likely cause",
    "goes on where": "resumes",
    "deaf to": "ignores",
    "anew": "again",
}
# Printed by benchmarks from stored results: words of the notes of that day.
PRINTED = ("docs/stress.md", "docs/numbers.md", "docs/performance.md")
PATTERN = re.compile(
    "|".join(rf"\b{phrase.replace(' ', chr(92) + 's+')}\b" for phrase in PHRASES), re.I
)
COMMENT = re.compile(r"<!--.*?-->", re.S)


def words_of(source: str) -> str:
    """Strings, docstrings and comments of Python code as one text. Names are no words: `way in
    ways`, `way_in`.
    """
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    kinds = {tokenize.STRING, tokenize.COMMENT}
    words = (token.string for token in tokens if token.type in kinds)
    return re.sub(r"(?m)\"\s*\"|^#|\n *#", " ", "\n".join(words))


def written() -> Iterator[tuple[str, str]]:
    """(path, text) of every page, template and library scene; (path, a string or all comments) of
    the packages.
    """
    yield "README.md", README
    folders = {
        "docs": {".md", ".ipynb"},
        "reports/templates": {".html", ".js", ".css", ".typ", ".toml", ".json"},
        "scenes/library": {".toml"},
        **{package: {".py"} for package in PACKAGES},
    }
    for folder, kinds in folders.items():
        for path in sorted((ROOT / folder).rglob("*")):
            name = path.relative_to(ROOT).as_posix()
            if (
                path.suffix not in kinds
                or "_build" in name
                or "docs/published" in name
                or name in PRINTED
            ):
                continue
            text = path.read_text(encoding="utf-8")
            if path.suffix != ".py":
                yield name, COMMENT.sub("", text)
            elif PATTERN.search(re.sub(r"\\n|[^a-zA-Z]+", " ", text)):  # a phrase, or a name
                yield name, words_of(text)


def faults(texts: Iterable[tuple[str, str]]) -> list[str]:
    """Each phrase with its place and what to write instead."""
    return [
        f"{name}: ...{text[max(0, hit.start() - 40) : hit.end() + 20]}...: write"
        f" {PHRASES[' '.join(hit[0].lower().split())]!r}"
        for name, text in texts
        for hit in PATTERN.finditer(text)
    ]


def test_no_page_template_string_docstring_or_comment_uses_them() -> None:
    """Each phrase is seen through line breaks, and names are not."""
    texts = list(written())
    assert len(texts) > 80
    expected = {
        "README.md",
        "docs/index.md",
        "reports/templates/scene.toml",
        "scenes/library/blocks.toml",
    }
    assert expected <= {name for name, _ in texts}
    assert not faults(texts)
    assert all(
        len(faults([("page", f"It {phrase.replace(' ', chr(10))} x.")])) == 1 for phrase in PHRASES
    )
    source = (
        'x = f"{x} is off "  "by {x}"\n# suffers\n# from it\nfor way in ways: way_in = "way_in"\n'
    )
    assert len(faults([("code", words_of(source))])) == 2


# Pages whose length is not a matter of writing: all public names, all changes.
NOT_COUNTED = ("api", "changelog")
EVIDENCE = ("performance", "stress", "security", "verification")
WORD = re.compile(r"[A-Za-z0-9][\w.\-−/×^]*")


def count(text: str) -> int:
    """Words of a page, numbers and tables among them, outside code blocks, comments and targets of
    links.
    """
    text = re.sub(r"<!--.*?-->|^```.*?^```", "", text, flags=re.S | re.M)
    return len(WORD.findall(re.sub(r"\]\([^)]*\)", "]", text)))


def test_the_manual_stays_short() -> None:
    """A page that grows needs another that shrinks."""
    counts = {
        name: count(text)
        for name, text in TEXTS.items()
        if "/" not in name and name.removesuffix(".md") not in NOT_COUNTED
    }
    assert len(counts) > 35
    assert sum(counts.values()) + count(README) <= 25_000, counts
    assert not [name for name in EVIDENCE if counts[f"{name}.md"] > 600], counts
    assert len(README.split()) <= 900
    assert count("a [b](c.md) | 1.5 % <!-- n:x y -->2e-3<!-- /n -->\n```sh\nd e\n```\n") == 4
