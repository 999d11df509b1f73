"""What the first page shows of `blocks`: its report as a browser shows it, and how wrong theory is,
with its uncertainty.

python docs/report_picture.py       (needs the extra `browser` and chromium; part of `make pages`)

One run makes docs/figures/report.png and docs/uncertainty.json, which `docs/pages.py` quotes; two
figures of that page stand alone as docs/figures/blocks-*.svg.
"""

from __future__ import annotations

import io
import json
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.PngImagePlugin import PngInfo

import halfplane_fe
import reports
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.advising_by_numbers import split_difference_of_work
from reports.charts.plate import Cell, Plate, panel_stacks_of
from reports.comparison.budget import error_budget, solve_refinements, theory_on_steps
from reports.console import Stages
from reports.page.writing import draw
from reports.report import with_budget
from scenes import load_scene

SCENE = "blocks"
HERE = Path(__file__).parent
# Figures of the page that the first page of the manual shows -> their files. As wide as the column
# of a phone of 390 px, where words of 12 px stay readable.
FIGURES = {"tractions": "blocks-tractions.svg", "waterfall": "blocks-waterfall.svg"}
WIDTH = 350.0
INSTANT = "P largest"


def measured(folder: Path) -> dict[str, dict[str, float]]:
    """Finite elements/theory - 1 of two metrics and its uncertainty, and what the main cause makes
    of the dissipation, by a run into `folder`.
    """
    command = [
        sys.executable,
        "-m",
        "reports",
        "run",
        SCENE,
        "--quiet",
        "--json",
        "--out",
        str(folder),
    ]
    run = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)
    if run.returncode > 1:  # 1: a metric is undecided
        raise SystemExit(run.returncode)
    result = json.loads(run.stdout)["result"]
    numbers = {}
    for key in ("dissipation", "peak_pressure"):
        metric = result["metrics"][key]
        numbers[key] = {"value": metric["value"], "uncertainty": metric["uncertainty"]}
    why = result["why"]
    cause = why["main_cause"]
    step = next(step for step in why["steps"] if step["cause"] == cause)
    numbers[cause] = {"value": step["value"], "uncertainty": step["uncertainty"]}
    return numbers


def drawn() -> dict[str, str]:
    """The figures of `FIGURES`, of the run that the first page quotes: file name -> SVG."""
    scene = load_scene(SCENE)
    begun = time.process_time()
    elements = halfplane_fe.solve(scene)
    cost = time.process_time() - begun
    theory = semi_analytic.solve(scene, x=elements.x, time=elements.time)
    comparison = reports.compare(theory, elements, polygon_reference=theory_on_steps(elements))
    stage = Stages(quiet=True).stage
    meshes = solve_refinements(comparison, MeshSettings(), SolverSettings(), stage, coarsenings=2)
    report = with_budget(comparison, error_budget(comparison, meshes, cost))
    causes = split_difference_of_work(report.comparison, report.budget)
    report = replace(report, comparison=replace(report.comparison, why=causes))
    figures = {plate.name: plate for plate in draw(report)}
    return {file: narrow(figures[name]).svg() + "\n" for name, file in FIGURES.items()}


def narrow(plate: Plate) -> Plate:
    """The figure in the column of a phone: of the tractions the instant `INSTANT` alone."""
    stack = next(
        (panels for panels in panel_stacks_of(plate) if panels[0].title.endswith(INSTANT)),
        panel_stacks_of(plate)[0],
    )
    first, *others = stack
    panels = [replace(first, width=WIDTH, title=INSTANT if first.title else "")]
    panels += [replace(panel, width=WIDTH) for panel in others]
    return replace(plate, panels=(Cell(tuple(panels), None),), n_columns=1)


def main() -> None:
    """Run the scene, open the page, keep its numbers and its first screen."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as player:
        content = {SCENE: measured(Path(folder) / "run")}
        browser = player.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page(viewport={"width": 1280, "height": 905})
        page.goto((Path(folder) / "run" / "report.html").as_uri())
        page.wait_for_timeout(1500)
        picture = Image.open(io.BytesIO(page.screenshot()))
        browser.close()
    keep(picture, content)
    for name, svg in drawn().items():
        (HERE / "figures" / name).write_text(svg, encoding="utf-8")


def keep(picture: Image.Image, content: dict[str, Any]) -> None:
    """Write the numbers and the picture, the same numbers in both: a picture of another run is seen
    by a test.
    """
    text = json.dumps(content, indent=1)
    (HERE / "uncertainty.json").write_text(text + "\n", encoding="utf-8")
    words = PngInfo()
    words.add_text("values", text)
    picture.save(HERE / "figures" / "report.png", pnginfo=words)


if __name__ == "__main__":
    main()
