"""The report as PDF, set by typst: the verdict, its tables and the figures of the page. An extra: nothing else needs typst."""

from __future__ import annotations

import base64
import json
import re
import tempfile
from collections.abc import Mapping, Sequence
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from reports.body_words import bodies_in_words, unlike_materials
from reports.budget_words import heads, honest_of, rows
from reports.charts.plate import Plate
from reports.comparison import Report
from reports.definitions import name_of
from reports.provenance import commit
from reports.verdicts import Metric
from reports.wording import (
    CLAIM,
    accuracy_of,
    beyond_theory,
    how_judged,
    lead,
    open_value_of,
    question,
    standing,
    tolerance_of,
    unit_of,
    verdict,
)
from scenes import InputError

_TEMPLATES = resources.files("reports") / "templates"
# Largest width of a line of a mesh as drawn [units of a panel]: typst knows no lines that keep their width.
_MESH_LINE = 0.4


def require_typst(option: str) -> None:
    """InputError in a sentence where typst is not installed."""
    if find_spec("typst") is None:
        raise InputError(f"{option}: it needs typst, which is not installed here; `pip install halfplane[pdf]` brings it")


def write_pdf(report: Report, plates: Sequence[Plate], path: Path, command: str) -> None:
    """Write the PDF; InputError where typst is missing.

    Words from outside go to typst as data, never as text of its language.
    """
    require_typst("--pdf")
    import typst

    with tempfile.TemporaryDirectory(prefix="halfplane-") as name:
        folder = Path(name)
        figures = [_figure(plate, folder) for plate in plates if plate.name != "cycle"]  # it is for who can move it
        content = json.dumps(_content(report, figures, command), ensure_ascii=False)
        (folder / "data.json").write_text(content, encoding="utf-8")
        (folder / "report.typ").write_text((_TEMPLATES / "report.typ").read_text("utf-8"), encoding="utf-8")
        typst.compile(str(folder / "report.typ"), output=str(path), root=str(folder))


def _content(report: Report, figures: Sequence[Mapping[str, Any]], command: str) -> dict[str, Any]:
    """Everything that the document says."""
    comparison, budget = report.comparison, report.budget
    scene = comparison.scene
    return {
        "title": scene.title or scene.name,
        "name": scene.name,
        "claim": CLAIM,
        "standing": standing(comparison),
        "judged": how_judged(report),
        "lead": lead(report),
        "verdict": verdict(report),
        "words": [w for w in (question(scene), bodies_in_words(scene), unlike_materials(scene), beyond_theory(comparison)) if w],
        "metrics": [_metric(report, metric) for metric in comparison.headlines],
        "notes": list(comparison.notes),
        "budget": {"heads": heads(budget), "rows": rows(budget)} if budget else None,
        "figures": list(figures),
        "command": command,
        "commit": commit(),
        "engines": [
            [name_of(solution.engine), ", ".join(f"{name} {version}" for name, version in solution.versions.items())]
            for solution in (comparison.reference, comparison.result)
        ],
    }


def _metric(report: Report, metric: Metric) -> list[str]:
    """A row of the verdict table."""
    admissible = "yes" if report.comparison.admissible else "no"
    verdicts = [accuracy_of(metric), admissible, honest_of(report, metric)]
    return [metric.label, open_value_of(metric), unit_of(metric), tolerance_of(metric), *verdicts]


def _figure(plate: Plate, folder: Path) -> dict[str, Any]:
    """Writes the panels of a figure as files of their own; their names, and the figure's words."""
    names: list[list[str]] = []
    for panel in plate.panels:
        names.append([])
        for document in re.findall(r"<svg.*?</svg>", panel, flags=re.DOTALL):
            names[-1].append(f"{plate.name}-{len(names)}-{len(names[-1])}.svg")
            (folder / names[-1][-1]).write_text(standalone(document, plate.svg()), encoding="utf-8")
        for picture in re.findall(r'<img src="data:image/png;base64,([^"]*)"', panel):
            names[-1].append(f"{plate.name}-{len(names)}.png")
            (folder / names[-1][-1]).write_bytes(base64.b64decode(picture))
    legend = [[f"{plate.name}-key-{k}.svg", key.text] for k, key in enumerate(plate.keys)]
    for (name, _), key in zip(legend, plate.keys, strict=True):
        mark = f'<rect x="5" y="1" width="16" height="10" class="{key.css} patch"/>' if key.patch else ""
        mark = mark or f'<path d="M1 6L25 6" class="curve {key.css}"/>'
        sample = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 26 12">{mark}</svg>'
        (folder / name).write_text(standalone(sample, sample), encoding="utf-8")
    small = plate.name in ("bodies", "load_path")
    words = {"title": plate.title, "caption": plate.caption, "legend": legend}
    return words | {"panels": names, "columns": plate.columns, "small": small}


def standalone(document: str, page: str) -> str:
    """A panel of the page as a document of its own: its style inside, lines of other panels that it uses copied into it."""

    def copied(use: re.Match[str]) -> str:
        original = re.search(rf'<path[^>]*id="{use[1]}"[^>]*/>', page)
        return f'<g transform="{use[2]}">{_hairline(original[0], use[2])}</g>' if original else ""

    document = re.sub(r'<circle[^>]*class="follow[^>]*/>', "", document)
    document = re.sub(r'<path[^>]*id="mesh-\w+"[^>]*/>', lambda found: _hairline(found[0], ""), document)
    document = re.sub(r'<use href="#([\w-]+)" transform="([^"]*)"/>', copied, document)
    return re.sub(r"(<svg[^>]*>)", lambda opened: f"{opened[1]}<style>{_style()}</style>", document, count=1)


def _hairline(path: str, above: str) -> str:
    """A line of a mesh with a width that its own scale, and that of what is `above` it, leave as it is drawn."""
    factor = 1.0
    for scaled in re.findall(r"scale\((-?[\d.e+-]+)", path + above):
        factor *= abs(float(scaled))
    return path.replace("<path", f'<path style="stroke-width:{_MESH_LINE / factor:.4g}"', 1)


def _style() -> str:
    """The rules for figures of the page's style sheet, its colours written out, without what typst can't read."""
    sheet = (_TEMPLATES / "report.css").read_text("utf-8")
    colours = dict(re.findall(r"--([\w-]+): (#\w+)", sheet[: sheet.index("@media")]))
    figures = sheet[sheet.index("svg text {") : sheet.index("/* the slider")]
    figures = re.sub(r"var\(--([\w-]+)\)", lambda found: colours[found[1]], figures).replace("px", "")
    figures = re.sub(r"svg \.", ".", figures).replace("svg text", "text")
    rules = re.findall(r"[^{}]+\{[^{}]*\}", figures)
    return "".join(rule for rule in rules if not re.search(r"[\[:]\w*[\^=(]|:not|#|\.now|follow|cursor", rule.split("{")[0]))
