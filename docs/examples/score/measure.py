"""Score the examples, and write what was found into numbers.json and between the marks of each
README.

    python docs/examples/score/measure.py

The one place where these numbers come from; `tests/test_reports_score.py` scores the files again
and compares.
"""

from __future__ import annotations

import json
import lzma
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reports.comparison.words import tolerance_of, value_of
from reports.report import Report
from reports.scoring.against import diagnosed, score_file
from reports.scoring.mapping import load_mapping
from scenes import load_scene

HERE = Path(__file__).parent
NUMBERS = HERE / "numbers.json"
SCENE = "cattaneo-mindlin"
HEADLINES = ("dissipation", "peak_pressure", "pressure", "shear", "contact_edge", "stick_edge")
MARKS = re.compile(r"(?<=<!-- numbers -->\n).*?(?=<!-- end -->)", re.DOTALL)


@dataclass(frozen=True)
class Example:
    """A result file, in the folder `name`, and what it needs beside it (compressed files are
    unpacked together).
    """

    name: str
    result: str
    beside: tuple[str, ...] = ()
    mapping: str | None = None


EXAMPLES = (
    Example("calculix", f"{SCENE}_calculix.frd.xz", beside=(f"{SCENE}_calculix.dat.xz",)),
    Example("kratos", "result.csv"),
    Example("abaqus", "path.rpt", mapping="mapping.toml"),
)


def scored(example: Example) -> Report:
    """The result against half-plane theory, with diagnoses."""
    folder = HERE / example.name
    mapping = load_mapping(folder / example.mapping if example.mapping else None)
    with tempfile.TemporaryDirectory() as name:
        for file in (example.result, *example.beside):
            content = (folder / file).read_bytes()
            packed = file.endswith(".xz")
            (Path(name) / file.removesuffix(".xz")).write_bytes(
                lzma.decompress(content) if packed else content
            )
        path = Path(name) / example.result.removesuffix(".xz")
        return diagnosed(score_file(path, mapping, load_scene(SCENE)))


def numbers(report: Report) -> dict[str, Any]:
    """The headline figures (None: not in the result), whether all keep their tolerance, and what
    the result suffers from.
    """
    return {
        "metrics": {key: report.metric(key).value for key in HEADLINES},
        "passed": report.passed,
        "diagnoses": [one.fault for one in report.diagnoses],
    }


def told(report: Report, made: dict[str, Any]) -> str:
    """The block of a README."""
    lines = [
        (
            f"{made['code']}, {made['increments']} increments, {made['seconds']:.3g} s of CPU on"
            " one thread."
        ),
        "",
    ]
    lines += ["| against half-plane theory | difference | tolerance |", "|---|---|---|"]
    for key in HEADLINES:
        metric = report.metric(key)
        lines.append(f"| {metric.label} | {value_of(metric)} | {tolerance_of(metric)} |")
    lines += ["", "Likely faults of the result:", ""]
    for one in report.diagnoses:
        lines += [f"- {one.sentence}", *(f"  - {evidence}" for evidence in one.evidence)]
    return "\n".join(lines) + "\n"


def main() -> None:
    found = {}
    for example in EXAMPLES:
        report = scored(example)
        found[example.name] = numbers(report)
        made = json.loads((HERE / example.name / "made.json").read_text("utf-8"))
        readme = HERE / example.name / "README.md"
        block = told(report, made).replace("\\", r"\\")
        readme.write_text(
            MARKS.sub(lambda _, text=block: text, readme.read_text("utf-8")), encoding="utf-8"
        )
        print(f"{example.name}: {found[example.name]}")
    NUMBERS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
