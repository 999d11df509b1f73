"""What the first page shows of `blocks`: its report as a browser shows it, and how wrong theory is,
with its uncertainty.

python docs/report_picture.py       (needs the extra `browser` and chromium; part of `make pages`)

One run makes both: docs/figures/report.png, and docs/uncertainty.json, which `docs/pages.py`
quotes.
"""

from __future__ import annotations

import io
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image
from PIL.PngImagePlugin import PngInfo

SCENE = "blocks"
HERE = Path(__file__).parent


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
