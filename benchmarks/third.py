"""CalculiX on the exported decks, against half-plane theory: error in p, q and W, and time. docs/third.md shows what is found.

    python benchmarks/third.py                      (every case that has not been measured yet)
    python benchmarks/third.py hertz-paper ...      (these cases anew; the others stay as found)

A minute or two a case; `make peers` installs CalculiX, without which nothing is measured. What is found is kept in third.json, case
by case, with its day, commit and version; `make pages` writes the page from it. Times are wall times of one thread.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from claim import commit

from reports.console import Stages
from reports.third.opinion import ask_calculix
from reports.third.settings import DeckSettings
from scenes import load_scene, scene_names

KEPT = Path(__file__).with_suffix(".json")
LIMIT = 1800.0
QUANTITIES = ("peak_pressure", "pressure", "shear", "dissipation")
TWICE = ("hertz-paper", "cattaneo-mindlin", "flat-pad-on-block")
# Their time series make decks of many hundred instants.
UNTRIED = ("flight", "time-series")


@dataclass(frozen=True)
class Case:
    """A scene and how often it goes round; the stick slope of the contact where it is not the deck's own, over E*/h."""

    scene: str
    revolutions: int = 1
    stick_slope: float | None = None

    @property
    def name(self) -> str:
        words = [self.scene]
        words += [f"{self.revolutions} revolutions"] if self.revolutions > 1 else []
        words += [f"stick slope {self.stick_slope:g}"] if self.stick_slope is not None else []
        return ", ".join(words)

    @property
    def settings(self) -> DeckSettings:
        if self.stick_slope is None:
            return DeckSettings(cycles=self.revolutions)
        return DeckSettings(cycles=self.revolutions, stick_stiffness=self.stick_slope)


def cases() -> dict[str, Case]:
    """Name -> case: the library in one revolution, what takes two to settle in two, a stiffer stick."""
    library = [Case(name) for name in scene_names() if name not in UNTRIED]
    found = [*library, *(Case(name, revolutions=2) for name in TWICE), Case("cattaneo-mindlin", stick_slope=50.0)]
    return {case.name: case for case in found}


def measured(case: Case) -> dict[str, Any]:
    """What CalculiX says to a case, for JSON; a metric that has no value is null."""
    begun = time.perf_counter()
    opinion = ask_calculix(load_scene(case.scene), case.settings, LIMIT, Stages(quiet=True))
    deck, done = opinion.deck, opinion.done
    errors: Mapping[str, float | None] = {}
    if opinion.comparison is not None:
        errors = {key: opinion.comparison.metric(key).value for key in QUANTITIES}
    return {
        "code": opinion.code,
        "nodes": deck.reference,
        "instants": len(deck.time) - 1,
        "seconds": round(done.seconds if done else time.perf_counter() - begun, 1),
        "increments": done.increments if done else None,
        "iterations": done.iterations if done else None,
        "failure": opinion.failure,
        "errors": {key: None if value is None else float(f"{value:.4g}") for key, value in errors.items()},
        "day": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
    }


def kept() -> dict[str, dict[str, Any]]:
    """What was found before, by the name of the case."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def keep(name: str, found: dict[str, Any]) -> None:
    """Put one case beside the others, in the order of names."""
    text = json.dumps(dict(sorted((kept() | {name: found}).items())), indent=1, ensure_ascii=False)
    KEPT.write_text(text + "\n", encoding="utf-8")


def main(names: list[str]) -> int:
    known = cases()
    if unknown := [name for name in names if name not in known]:
        print(f"no case is called {' or '.join(unknown)}; there are: {'; '.join(known)}", file=sys.stderr)
        return 2
    before = kept()
    for name in names or [name for name in known if name not in before]:
        found = measured(known[name])
        keep(name, found)
        print(f"{found['seconds']:6.1f} s  {name}: {found['failure'] or found['errors']}", flush=True)
    missing = [name for name in known if name not in kept()]
    if missing:
        print(f"not run yet: {'; '.join(missing)}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
