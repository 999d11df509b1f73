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

from reports.comparison.words import tolerance_in_words, value_in_words
from reports.report import Report
from reports.scoring.against import report_with_diagnoses, score_file
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
    result_file: str
    other_files: tuple[str, ...] = ()
    mapping: str | None = None


EXAMPLES = (
    Example("calculix", f"{SCENE}_calculix.frd.xz", other_files=(f"{SCENE}_calculix.dat.xz",)),
    Example("kratos", "result.csv"),
    Example("abaqus", "path.rpt", mapping="mapping.toml"),
)


def scored(example: Example) -> Report:
    """The result against half-plane theory, with diagnoses."""
    folder = HERE / example.name
    mapping = load_mapping(folder / example.mapping if example.mapping else None)
    with tempfile.TemporaryDirectory() as name:
        for file in (example.result_file, *example.other_files):
            content = (folder / file).read_bytes()
            packed = file.endswith(".xz")
            (Path(name) / file.removesuffix(".xz")).write_bytes(
                lzma.decompress(content) if packed else content
            )
        path = Path(name) / example.result_file.removesuffix(".xz")
        return report_with_diagnoses(score_file(path, mapping, load_scene(SCENE)))


def numbers(report: Report) -> dict[str, Any]:
    """The headline figures (None: not in the result), whether all keep their tolerance, and what
    the result suffers from.
    """
    return {
        "metrics": {key: report.metric(key).value for key in HEADLINES},
        "passed": report.passed,
        "diagnoses": [diagnosis.fault for diagnosis in report.diagnoses],
    }


def block_of(report: Report, origin: dict[str, Any]) -> str:
    """The block of a README."""
    lines = [
        (
            f"{origin['code']}, {origin['increments']} increments, {origin['seconds']:.3g} s of"
            " CPU on one thread."
        ),
        "",
    ]
    lines += ["| against half-plane theory | difference | tolerance |", "|---|---|---|"]
    for key in HEADLINES:
        metric = report.metric(key)
        lines.append(
            f"| {metric.label} | {value_in_words(metric)} | {tolerance_in_words(metric)} |"
        )
    lines += ["", "Likely faults of the result:", ""]
    for diagnosis in report.diagnoses:
        lines.append(f"- {diagnosis.sentence}")
        lines += [f"  - {evidence}" for evidence in diagnosis.evidence]
    return "\n".join(lines) + "\n"


def main() -> None:
    numbers_of = {}
    for example in EXAMPLES:
        report = scored(example)
        numbers_of[example.name] = numbers(report)
        origin = json.loads((HERE / example.name / "made.json").read_text("utf-8"))
        readme = HERE / example.name / "README.md"
        block = block_of(report, origin).replace("\\", r"\\")
        readme.write_text(
            MARKS.sub(lambda _, text=block: text, readme.read_text("utf-8")), encoding="utf-8"
        )
        print(f"{example.name}: {numbers_of[example.name]}")
    NUMBERS.write_text(json.dumps(numbers_of, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
