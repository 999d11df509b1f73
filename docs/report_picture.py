"""The picture of the first page: the report of `blocks` as a browser shows it, into docs/figures/report.png.

python docs/report_picture.py       (needs the extra `browser` and chromium; part of `make pages`)
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

PICTURE = Path(__file__).parent / "figures" / "report.png"
_WINDOW = {"width": 1280, "height": 905}


def main() -> int:
    """Run the scene, open the page, keep its first screen."""
    with tempfile.TemporaryDirectory() as folder:
        run = [sys.executable, "-m", "reports", "run", "blocks", "--quiet", "--out", folder + "/run"]
        if (code := subprocess.run(run, check=False, stdout=subprocess.DEVNULL).returncode) > 1:  # 1: a metric is undecided
            return code
        with sync_playwright() as player:
            browser = player.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
            page = browser.new_page(viewport=_WINDOW)
            page.goto((Path(folder) / "run" / "report.html").as_uri())
            page.wait_for_timeout(1500)
            page.screenshot(path=PICTURE)
            browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
