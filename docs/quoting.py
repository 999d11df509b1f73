"""Numbers in the text of a page, each between two marks: `<!-- n:KEY -->0.412<!-- /n -->`. What
each key stands for.

- `peak pressure, SCENE` and the like: the published baselines of tests/cases
- `± u: dissipation, SCENE` and the like: finite elements/theory - 1 in %, unsigned, with its
  uncertainty, docs/uncertainty.json
- the paper's: its statements and misprints, computed again
- `CLAIM`, or `SECTION: CLAIM` where two sections share it: docs/numbers.json, by make numbers
- `limit: FILE`: how much of a file is read, from the code
- `CalculiX, CASE: METRIC`: benchmarks/third.json, by benchmarks/third.py
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from meshes import bodies
from reports.comparison.words import with_uncertainty
from reports.scoring import calculix_files, field_files
from reports.studies.paper.cases import Paper
from reports.studies.paper.page import misprints, statements, tally
from scenes import files, netcdf, text_tables
from scenes.errors import in_words

NUMBER = re.compile(r"(<!-- n:([^<>]+?) -->)[^<]*(<!-- /n -->)")
ROOT = Path(__file__).parents[1]


def with_numbers(page: str, known: Mapping[str, str]) -> str:
    """The page with the present number between each pair of marks. A KeyError names a key that
    nothing stands for.

    >>> with_numbers("half of <!-- n:scenes -->2<!-- /n --> scenes", {"scenes": "33"})
    'half of <!-- n:scenes -->33<!-- /n --> scenes'
    """
    return NUMBER.sub(lambda mark: f"{mark[1]}{known[mark[2]]}{mark[3]}", page)


def values(
    examples: Paper, published: Mapping[str, Any], third: Mapping[str, Any]
) -> dict[str, str]:
    """Key -> number, of all that a page can quote."""

    def stored(name: str) -> dict[str, Any]:
        return json.loads((ROOT / "docs" / name).read_text(encoding="utf-8"))

    known = (
        paper_values(examples)
        | published_values(published)
        | limit_values()
        | third_values(third, published)
    )
    known |= uncertain_values(stored("uncertainty.json")) | claim_values(stored("numbers.json"))
    return known


def paper_values(examples: Paper) -> dict[str, str]:
    """Key -> number of the paper's statements and misprints."""
    statement_rows = statements(examples)
    misprint_rows = misprints(examples)
    numbers = {
        f"permanent stick, {case.scene.name}": f"{case.permanent_stick_half_width:.4f}"
        for case in (examples.hertz_case, examples.rounded_case)
    }
    for row in statement_rows:
        for quantity, value in row.values.items():
            if abs(value) > 1e-6:  # below is rounded off
                numbers[f"{row.key}: {quantity}"] = _minus(f"{value:.4g}")
    counts = {f"statements {verdict}": count for verdict, count in tally(statement_rows).items()}
    counts |= {
        "statements": len(statement_rows),
        "misprints": len(misprint_rows),
        "misprints proven": sum(row.proven is True for row in misprint_rows),
    }
    return numbers | {key: str(count) for key, count in counts.items()}


def published_values(scenes: Mapping[str, Any]) -> dict[str, str]:
    """Key -> number of the published reports."""
    numbers = {"scenes": str(len(scenes))}
    for name, content in scenes.items():
        for key in ("peak_pressure", "pressure", "shear", "dissipation"):
            text = published_share(content, key)
            if text is not None:
                words = key.replace("_", " ")
                numbers[f"{words}, {name}"] = text
    return numbers


def uncertain_values(measured: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict[str, str]:
    """Key -> finite elements/theory - 1 in %, unsigned, with its uncertainty, of scenes whose
    uncertainty was measured.

    >>> uncertain_values({"blocks": {"dissipation": {"value": -0.0272, "uncertainty": 0.00042}}})
    {'± u: dissipation, blocks': '2.72 ± 0.04'}
    """
    numbers = {}
    for scene, metrics in measured.items():
        for key, metric in metrics.items():
            difference = 100 * abs(metric["value"])
            name = f"± u: {key.replace('_', ' ')}, {scene}"
            numbers[name] = with_uncertainty(difference, 100 * metric["uncertainty"])
    return numbers


def published_share(content: Mapping[str, Any], key: str) -> str | None:
    """A metric of a published scene in per cent; None where it has no value or is no share."""
    return share(content, key, content["frozen"].get(f"metric.{key}"))


def share(content: Mapping[str, Any], key: str, value: float | None) -> str | None:
    """A metric of a published scene, or of another code on it, in per cent, norms without a sign;
    None where it is no share.
    """
    if value is None or (key == "dissipation" and "dissipation" in content["absolute"]):
        return None
    sign = "" if key in {"pressure", "shear"} else "+"
    return f"{100 * value:{sign}.2g} %".replace("-", "−")


def claim_values(sections: Mapping[str, Any]) -> dict[str, str]:
    """Key -> value of every claim of docs/numbers.json: counts as they are, others to two
    digits.
    """
    rows = [(title, row) for title, section in sections.items() for row in section["rows"]]
    count_of = Counter(row["what"] for _, row in rows)
    numbers = {}
    for title, row in rows:
        claim = row["what"]
        key = claim if count_of[claim] == 1 else f"{title}: {claim}"
        value = row["measured"]
        digits = f"{value:.0f}" if value.is_integer() else f"{value:.2g}"
        unit = f" {row['unit']}".rstrip()
        numbers[key] = _minus(digits) + unit
    return numbers


def limit_values() -> dict[str, str]:
    """Key -> how large a file, how many rows or nodes are taken at most."""
    sizes = {
        "TOML": files.LARGEST_TOML_BYTES,
        "text": files.LARGEST_TEXT_BYTES,
        "NetCDF": netcdf.LARGEST_SOLUTION_BYTES,
        "fields": field_files.MOST_BYTES_OF_FILE,
        "unpacked": field_files.MOST_UNPACKED_BYTES,
        ".frd and .dat": calculix_files.MOST_BYTES_OF_FILE,
    }
    counts = {
        "rows": text_tables.MOST_ROWS,
        "contact nodes": bodies.MOST_CONTACT_NODES,
        "nodes": bodies.MOST_NODES,
    }
    texts = {key: in_words(size) for key, size in sizes.items()}
    texts |= {key: f"{count:,}" for key, count in counts.items()}
    return {f"limit: {key}": text for key, text in texts.items()}


def third_values(cases: Mapping[str, Any], scenes: Mapping[str, Any]) -> dict[str, str]:
    """Key -> value of CalculiX on a case of benchmarks/third.json, and how many scenes it was tried
    on and converged.
    """
    numbers: dict[str, str] = {}
    for name, case in cases.items():
        scene = name.partition(",")[0]
        for key, value in case["errors"].items():
            text = share(scenes[scene], key, value)
            if text is not None:
                numbers[f"CalculiX, {name}: {key}"] = text
    tried_cases = [case for name, case in cases.items() if name in scenes]
    converged = sum(not case["failure"] for case in tried_cases)
    numbers["CalculiX, scenes tried"] = str(len(tried_cases))
    numbers["CalculiX, scenes converged"] = str(converged)
    return numbers


def _minus(text: str) -> str:
    """The text with minus signs before its numbers."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", text)
