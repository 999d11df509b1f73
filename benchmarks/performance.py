"""docs/performance.md: error against CPU time, peers, growth of the cost, start-up, and work that is skipped, measured now.

    make bench              (python benchmarks/performance.py [SECTION ...] [--pages], a quarter of an hour)

Each section measures, writes what it found to docs/performance/SECTION.json with machine and versions, draws its figures, and has
its part of the page. With names of sections only those are measured anew; with --pages none is, and the page is written from the
files. The machine may be busy: ratios are of one run, times are CPU times unless they say otherwise.
"""

from __future__ import annotations

import datetime
import json
import os
import platform
import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import performance_growth
import performance_half_plane
import performance_peers
import performance_precision
import performance_skipping
import performance_start

ROOT = Path(__file__).parent.parent
PAGE, FOLDER = ROOT / "docs" / "performance.md", ROOT / "docs" / "performance"
PACKAGES = ("halfplane", "numpy", "scipy", "scikit-fem", "gmsh")


class Section(Protocol):
    """What the modules of the sections have."""

    TITLE: str

    def measure(self) -> dict[str, Any]:
        """What was found, for JSON."""

    def draw(self, found: dict[str, Any], folder: Path) -> None:
        """Figures into the folder."""

    def page(self, found: dict[str, Any]) -> list[str]:
        """Lines of Markdown."""


SECTIONS: dict[str, Section] = {
    "precision": performance_precision,
    "half-plane": performance_half_plane,
    "peers": performance_peers,
    "growth": performance_growth,
    "start": performance_start,
    "skipping": performance_skipping,
}


def processor() -> str:
    """Its name, where the system tells it."""
    file = Path("/proc/cpuinfo")
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())


def circumstances() -> dict[str, Any]:
    """Machine, versions, and how busy the machine is."""
    return {
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "processor": processor(),
        "cores": os.cpu_count(),
        "load before": round(os.getloadavg()[0], 1),
        "versions": {"python": platform.python_version()} | {name: version(name) for name in PACKAGES},
    }


def measure(name: str) -> None:
    """Measure a section, draw, and keep what it found."""
    print(f"==> {name}", flush=True)
    about, begun, spent = circumstances(), time.perf_counter(), time.process_time()
    found = SECTIONS[name].measure()
    about["load after"] = round(os.getloadavg()[0], 1)
    about["seconds"] = {"wall": round(time.perf_counter() - begun), "process": round(time.process_time() - spent)}
    text = json.dumps({"made": about, "found": found}, indent=1)
    (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")
    print(f"    {about['seconds']['wall']} s", flush=True)


def words(made: dict[str, Any]) -> str:
    """The circumstances as a sentence."""
    versions = ", ".join(f"{name} {number}" for name, number in made["versions"].items())
    return (
        f"*Measured {made['date']} on {made['cores']} cores, {made['processor']}; load {made['load before']} before and "
        f"{made['load after']} after, {made['seconds']['wall']} s in all; {versions}.*"
    )


def page_text() -> str:
    """The page, from the files of the sections."""
    lines = [
        "# Performance",
        "",
        "Error against time, other codes, growth of the cost, start-up, and work that is skipped. Written by `make bench` and by "
        "nothing else; the numbers behind every table and figure are in `docs/performance/*.json`. Times are CPU times of one "
        "thread unless they say otherwise, with everything in them: the coarse run, mesh, condensation, every increment, nothing "
        "read from the store. They vary by some ten per cent, on a busy machine by more: ratios within one run count.",
    ]
    for name, section in SECTIONS.items():
        file = FOLDER / f"{name}.json"
        if not file.exists():
            continue
        kept = json.loads(file.read_text(encoding="utf-8"))
        lines += ["", f"## {section.TITLE}", "", words(kept["made"]), "", *section.page(kept["found"])]
    return "\n".join(lines) + "\n"


def write_page() -> None:
    """The page and its figures, from the files of the sections."""
    for name, section in SECTIONS.items():
        if (file := FOLDER / f"{name}.json").exists():
            section.draw(json.loads(file.read_text(encoding="utf-8"))["found"], FOLDER)
    PAGE.write_text(page_text(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))


def main() -> None:
    os.environ["HALFPLANE_CACHE"] = "off"  # every run condenses its bodies itself
    FOLDER.mkdir(exist_ok=True)
    asked = [name for name in sys.argv[1:] if name != "--pages"]
    if unknown := [name for name in asked if name not in SECTIONS]:
        sys.exit(f"no section {', '.join(unknown)}: there are {', '.join(SECTIONS)}")
    if "--pages" not in sys.argv:
        for name in asked or SECTIONS:
            measure(name)
    write_page()


if __name__ == "__main__":
    main()
