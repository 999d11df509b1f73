"""CalculiX on the exported decks, against half-plane theory, ours beside it: error in p, q and W, and time, with versions.

    python benchmarks/third.py [SCENE ...]

A minute or two a scene; `make peers` installs CalculiX. Without it there are no rows but the one that says so. Times are wall times
of one thread each, everything included; they vary by 20-30 % from run to run.
"""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Iterator

from claim import Row, table

import halfplane_fe
import semi_analytic
from reports import compare
from reports.comparison import Comparison
from reports.console import Stages
from reports.third.opinion import ThirdOpinion, ask_calculix
from reports.third.settings import DeckSettings
from scenes import load_scene

SCENES = ("hertz-paper", "cattaneo-mindlin")
LIMIT = 1800.0
QUANTITIES = (
    ("dissipation", "work of friction of the last cycle"),
    ("pressure", "p, relative L2, worst instant"),
    ("shear", "q, relative L2 over f p, worst instant"),
    ("peak_pressure", "peak pressure"),
)


def beside(name: str) -> Iterator[Row]:
    """Both codes on one scene."""
    scene = load_scene(name)
    begun = time.perf_counter()
    ours = halfplane_fe.solve(scene)
    seconds = time.perf_counter() - begun
    own = compare(semi_analytic.solve(scene, x=ours.x, time=ours.time), ours)
    opinion = ask_calculix(scene, DeckSettings(), LIMIT, Stages(quiet=True), ours.scales)
    if opinion.comparison is None or opinion.done is None:
        yield Row(f"{name}: {opinion.code} gave no answer", float("nan"), None, opinion.failure)
        return
    yield from _errors(name, own, opinion, opinion.comparison)
    own_words = f"ours {seconds:.1f} s, default mesh, {len(ours.time)} instants"
    how = f"{opinion.done.increments} increments, {opinion.done.iterations} iterations; {own_words}"
    yield Row(f"{name}: {opinion.code}, wall time", opinion.done.seconds, None, how, "s")


def _errors(name: str, own: Comparison, opinion: ThirdOpinion, theirs: Comparison) -> Iterator[Row]:
    deck = opinion.deck
    size = f"a/{1 / deck.settings.edge_element_size:g}, {deck.reference} nodes, {len(deck.time) - 1} instants"
    for key, words in QUANTITIES:
        value, ours = theirs.metric(key).value, own.metric(key).value
        yield Row(f"{name}: {opinion.code}, {words}", float(value), None, f"{size}; ours {ours:.2g}")


def third() -> Iterator[Row]:
    """All rows of this page."""
    if shutil.which("ccx") is None:
        yield Row("CalculiX", float("nan"), None, "ccx is not on PATH: make peers installs it; nothing was measured")
        return
    for name in SCENES:
        yield from beside(name)


def main() -> None:
    os.environ["HALFPLANE_CACHE"] = "off"  # bodies are condensed anew
    names = sys.argv[1:]
    print(table([row for name in names for row in beside(name)] if names else list(third())))


if __name__ == "__main__":
    main()
