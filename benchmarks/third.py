"""CalculiX on the exported decks, against half-plane theory: error in p, q and W, and time. docs/third.md shows the results.

    python benchmarks/third.py                      (every case that has not been measured yet)
    python benchmarks/third.py hertz-paper ...      (these cases again; the others stay as measured)

A minute or two a case; `make peers` installs CalculiX. Results are stored in third.json, case by case, with day, commit and
version; `make pages` writes the page from it. Times are wall times of one thread.
"""

from __future__ import annotations

import json
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from claim import commit

from reports.console import Stages
from reports.third.calculix import solve_with_calculix
from reports.third.deck import DeckSettings
from scenes import load_scene, scene_names

STORED = Path(__file__).with_suffix(".json")
# The library in one revolution, but for the two whose time series make decks of many hundred instants; those that take two
# revolutions to become steady in two; a stiffer stick.
CASES = {name: (name, DeckSettings(cycles=1)) for name in scene_names() if name not in ("flight", "time-series")}
CASES |= {f"{name}, 2 revolutions": (name, DeckSettings()) for name in ("hertz-paper", "cattaneo-mindlin", "flat-pad-on-block")}
CASES["cattaneo-mindlin, stick slope 50"] = ("cattaneo-mindlin", DeckSettings(cycles=1, stick_stiffness=50.0))


def measured(scene: str, settings: DeckSettings) -> dict[str, Any]:
    """What CalculiX gives for a case, for JSON; a metric that has no value is null."""
    begun = time.perf_counter()
    third = solve_with_calculix(load_scene(scene), settings, 1800.0, Stages(quiet=True))
    done, errors = third.done, {}
    for key in ("peak_pressure", "pressure", "shear", "dissipation") if third.comparison else ():
        value = third.comparison.metric(key).value
        errors[key] = None if value is None else float(f"{value:.4g}")
    return {
        "code": third.code,
        "nodes": third.deck.reference,
        "instants": len(third.deck.time) - 1,
        "seconds": round(done.seconds if done else time.perf_counter() - begun, 1),
        "increments": done.increments if done else None,
        "iterations": done.iterations if done else None,
        "failure": third.failure,
        "errors": errors,
        "day": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
    }


if __name__ == "__main__":
    stored = json.loads(STORED.read_text(encoding="utf-8"))
    if unknown := set(sys.argv[1:]) - set(CASES):
        sys.exit(f"no case is called {' or '.join(unknown)}; there are: {'; '.join(CASES)}")
    for name in sys.argv[1:] or [name for name in CASES if name not in stored]:
        stored[name] = measured(*CASES[name])
        STORED.write_text(json.dumps(dict(sorted(stored.items())), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        print(f"{stored[name]['seconds']:6.1f} s  {name}: {stored[name]['failure'] or stored[name]['errors']}", flush=True)
