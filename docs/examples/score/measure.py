"""Score the examples, and write what was found into numbers.json and between the marks of each README.

    python docs/examples/score/measure.py

The one place where these numbers come from; `tests/test_reports_score_examples.py` scores the files again and compares.
"""

from __future__ import annotations

import json
import lzma
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reports.comparison import Comparison
from reports.score.mapping import load_mapping
from reports.score.scoring import diagnosed, score_file
from reports.wording import tolerance_of, value_of
from scenes import load_scene

HERE = Path(__file__).parent
NUMBERS = HERE / "numbers.json"
SCENE = "cattaneo-mindlin"
HEADLINES = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")
MARKS = re.compile(r"(?<=<!-- numbers -->\n).*?(?=<!-- end -->)", re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A result file, in the folder `name`, and what it needs beside it (compressed files are unpacked together)."""

    name: str
    result: str
    beside: tuple[str, ...] = ()
    mapping: str | None = None


EXAMPLES = (
    Example("calculix", f"{SCENE}_calculix.frd.xz", beside=(f"{SCENE}_calculix.dat.xz",)),
    Example("kratos", "result.csv"),
    Example("abaqus", "path.rpt", mapping="mapping.toml"),
)


def scored(example: Example) -> Comparison:
    """The result against half-plane theory, with diagnoses."""
    folder = HERE / example.name
    mapping = load_mapping(folder / example.mapping if example.mapping else None)
    with tempfile.TemporaryDirectory() as name:
        for file in (example.result, *example.beside):
            content = (folder / file).read_bytes()
            packed = file.endswith(".xz")
            (Path(name) / file.removesuffix(".xz")).write_bytes(lzma.decompress(content) if packed else content)
        path = Path(name) / example.result.removesuffix(".xz")
        return diagnosed(score_file(path, mapping, load_scene(SCENE)))


def numbers(comparison: Comparison) -> dict[str, Any]:
    """The headline figures (None: not in the result), whether all keep their tolerance, and what the result suffers from."""
    return {
        "metrics": {key: comparison.metric(key).value for key in HEADLINES},
        "passed": comparison.passed,
        "diagnoses": [one.fault for one in comparison.diagnoses],
    }


def told(comparison: Comparison, made: dict[str, Any]) -> str:
    """The block of a README."""
    lines = [f"{made['code']}, {made['increments']} increments, {made['seconds']:.3g} s of CPU on one thread.", ""]
    lines += ["| against half-plane theory | off by | tolerance of the scene |", "|---|---|---|"]
    for key in HEADLINES:
        metric = comparison.metric(key)
        lines.append(f"| {metric.label} | {value_of(metric)} | {tolerance_of(metric)} |")
    lines += ["", "What it most likely suffers from:", ""]
    for one in comparison.diagnoses:
        lines += [f"- {one.sentence}", *(f"  - {evidence}" for evidence in one.evidence)]
    return "\n".join(lines) + "\n"


def main() -> None:
    found = {}
    for example in EXAMPLES:
        comparison = scored(example)
        found[example.name] = numbers(comparison)
        made = json.loads((HERE / example.name / "made.json").read_text("utf-8"))
        readme = HERE / example.name / "README.md"
        block = told(comparison, made).replace("\\", r"\\")
        readme.write_text(MARKS.sub(lambda _, text=block: text, readme.read_text("utf-8")), encoding="utf-8")
        print(f"{example.name}: {found[example.name]}")
    NUMBERS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
