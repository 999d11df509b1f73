"""What the first page shows of `blocks`: its report as a browser shows it, and how wrong theory is, with its uncertainty.

python docs/report_picture.py       (needs the extra `browser` and chromium; part of `make pages`)

One run makes both: docs/figures/report.png, and docs/uncertainty.json, which `docs/pages.py` quotes.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE, HERE = "blocks", Path(__file__).parent


def measured(folder: Path) -> dict[str, dict[str, float]]:
    """Finite elements/theory - 1 of two metrics and its uncertainty, by a run into `folder`."""
    command = [sys.executable, "-m", "reports", "run", SCENE, "--quiet", "--json", "--out", str(folder)]
    run = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)
    if run.returncode > 1:  # 1: a metric is undecided
        raise SystemExit(run.returncode)
    metrics = json.loads(run.stdout)["result"]["metrics"]
    return {key: {name: metrics[key][name] for name in ("value", "uncertainty")} for key in ("dissipation", "peak_pressure")}


def main() -> None:
    """Run the scene, keep its numbers, open the page, keep its first screen."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as player:
        content = {SCENE: measured(Path(folder) / "run")}
        (HERE / "uncertainty.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
        browser = player.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 905})
        page.goto((Path(folder) / "run" / "report.html").as_uri())
        page.wait_for_timeout(1500)
        page.screenshot(path=HERE / "figures" / "report.png")
        browser.close()


if __name__ == "__main__":
    main()
