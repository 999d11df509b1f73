"""The report as PDF, set by typst: the verdict, its tables and the figures of the page. An extra: nothing else needs typst."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from reports.charts.plate import Plate
from reports.comparison import Report
from reports.comparison.metrics import name_of
from reports.comparison.words import (
    THEORY,
    heads,
    honest_of,
    how_judged,
    lead,
    open_value_of,
    rows,
    said,
    standing,
    tolerance_of,
    unit_of,
    verdict,
    without_cycle,
)
from reports.page.content import commit
from scenes import InputError

_TEMPLATES = resources.files("reports") / "templates"


def require_typst() -> None:
    """InputError in a sentence where typst is not installed."""
    if find_spec("typst") is None:
        raise InputError("--pdf: it needs typst, which is not installed here; `pip install halfplane[pdf]` brings it")


def write_pdf(report: Report, plates: Sequence[Plate], path: Path, command: str) -> None:
    """Write the PDF; InputError where typst is missing.

    Words from outside go to typst as data, never as text of its language.
    """
    require_typst()
    import typst

    with tempfile.TemporaryDirectory(prefix="halfplane-") as name:
        folder = Path(name)
        figures = []
        for plate in plates:
            if plate.name != "cycle":  # it is for who can move it
                (folder / f"{plate.name}.svg").write_text(plate.svg(), encoding="utf-8")
                small = "55%" if plate.name in ("bodies", "load_path") else "100%"
                title, caption = (without_cycle(words, report.comparison.scene) for words in (plate.title, plate.caption))
                figures.append({"file": f"{plate.name}.svg", "title": title, "caption": caption, "width": small})
        content = json.dumps(_content(report, figures, command), ensure_ascii=False)
        (folder / "data.json").write_text(content, encoding="utf-8")
        (folder / "report.typ").write_text((_TEMPLATES / "report.typ").read_text("utf-8"), encoding="utf-8")
        typst.compile(str(folder / "report.typ"), output=str(path), root=str(folder))


def _content(report: Report, figures: Sequence[Mapping[str, Any]], command: str) -> dict[str, Any]:
    """Everything that the document says."""
    comparison, budget = report.comparison, report.budget
    scene, words, admissible = comparison.scene, said(report), "yes" if comparison.admissible else "no"
    metrics = [
        [m.label, open_value_of(m), unit_of(m), tolerance_of(m), m.verdict or "–", admissible, honest_of(report, m)]
        for m in comparison.headlines
    ]
    return {
        "title": scene.title or scene.name,
        "name": scene.name,
        "claim": words["claim"],
        "standing": standing(comparison) or "",
        "judged": how_judged(report),
        "lead": lead(report),
        "verdict": verdict(report),
        "words": [words[one] for one in ("question", "bodies", "unlike_materials", "idealisation") if words[one]],
        "metrics": metrics,
        "notes": list(comparison.notes),
        "budget": {"heads": heads(budget), "rows": rows(budget)} if budget else None,
        "figures": list(figures),
        "command": command,
        "commit": commit(),
        "paper": THEORY,
        "engines": [
            [name_of(solution.engine), ", ".join(f"{name} {version}" for name, version in solution.versions.items())]
            for solution in (comparison.reference, comparison.result)
        ],
    }
