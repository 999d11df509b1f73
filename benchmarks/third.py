"""CalculiX on the exported decks: error in p, q and W against half-plane theory, and why the NAFEMS
roller differs from its values.

    python benchmarks/third.py                      (every case that has not been measured yet)
    python benchmarks/third.py hertz-paper ...      (these cases again; the others stay as measured)

A minute or two a case; `make peers` installs CalculiX. Results are stored case by case with day,
commit and version: those of the decks in third.json, for docs/third.md (`make pages`), those of the
roller in roller.json (`make publish PAGES=1`). Times are wall times of one thread.

The roller's reference values are those of Code_Aster's test SSNP154 (a to d), whose manual
V6.03.154 names A. W. A. Konter's benchmark 1 as its source: half of the model by symmetry, the
whole cylinder with a point force of 17.5 kN at its top, the base of the block fixed, linear or
quadratic elements of 1.5 mm on the block's face, large displacements, two increments; the vertical
displacement and the Cauchy stress sigma_yy, extrapolated from the elements, of the block's face
under the roller. Ours is half a cylinder, bonded to a rigid plane at its middle, in small
displacements, with the pressure of the contact itself. A case changes the deck in one way, or two.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from claims import chosen, commit, measure, stored, write_json

from reports.console import Stages
from reports.scoring.calculix_files import read_frd
from reports.studies.third.calculix import (
    calculix_version,
    find_calculix,
    run_calculix,
    solve_with_calculix,
)
from reports.studies.third.deck import Deck, DeckSettings, build_deck, deck_text
from scenes import load_scene, read_only_copy, scene_names

STORED = Path(__file__).with_suffix(".json")
ROLLER = STORED.with_name("roller.json")
LIMIT = 3600.0
COARSE = 1.5
"""Length of the published elements on the block's face [mm]."""


def measured(scene: str, settings: DeckSettings) -> dict[str, Any]:
    """What CalculiX gives for a deck, for JSON; a metric that has no value is null."""
    begun = time.perf_counter()
    third = solve_with_calculix(load_scene(scene), settings, Stages(quiet=True))
    run_record = third.run_record
    errors = {}
    for key in ("peak_pressure", "pressure", "shear", "dissipation") if third.comparison else ():
        value = third.comparison.metric(key).value
        errors[key] = None if value is None else float(f"{value:.4g}")
    return {
        "code": third.code,
        "nodes": third.deck.node_count,
        "instants": len(third.deck.time) - 1,
        "seconds": round(run_record.seconds if run_record else time.perf_counter() - begun, 1),
        "increments": run_record.n_increments if run_record else None,
        "iterations": run_record.n_iterations if run_record else None,
        "failure": third.failure,
        "errors": errors,
    }


# --------------------------------------------------------------------------------------- the roller
def whole_cylinder(deck: Deck) -> Deck:
    """The half cylinder and its mirror image in its middle; the load acts at the top, on a cap as
    wide as the contact.

    A force on a single node would crush the small elements there. Nodes at x = 0 move along x
    together: no rolling.
    """
    upper = deck.upper
    y = upper.nodes[:, 1]
    first = upper.first_node
    middle = y.max()
    on_axis = y > middle * (1 - 1e-9)
    number = np.where(on_axis, np.arange(len(y)), len(y) + np.cumsum(~on_axis) - 1)
    mirrored = np.stack([upper.nodes[~on_axis, 0], 2 * middle - y[~on_axis]], axis=1)
    nodes = np.concatenate([upper.nodes, mirrored])
    turned = number[upper.elements - first][:, [0, 3, 2, 1]] + first
    top = np.flatnonzero(nodes[:, 1] >= 2 * middle - deck.scales.half_width**2 / (2 * middle))
    axis = np.flatnonzero(np.abs(nodes[:, 0]) < 1e-9 * middle)
    held = {1: read_only_copy(axis + first, np.int64), 2: read_only_copy(top + first, np.int64)}
    elements = read_only_copy(np.concatenate([upper.elements, turned]), np.int64)
    return replace(
        deck, upper=replace(upper, nodes=read_only_copy(nodes), elements=elements, held=held)
    )


def two_increments(deck: Deck) -> Deck:
    """The load in two halves."""
    half = (len(deck.time) - 1) // 2
    time, normal, tangential = (
        read_only_copy(series[::half])
        for series in (deck.time, deck.normal_load, deck.tangential_load)
    )
    return replace(deck, time=time, normal_load=normal, tangential_load=tangential)


def on_roller(
    scene: str,
    *,
    large: bool = False,
    element_size: float | None = None,
    change: Callable[[Deck], Deck] = lambda deck: deck,
) -> dict[str, Any]:
    """What CalculiX gives for the block's face under the roller, for JSON; pressures in MPa,
    displacements in mm.

    Changed of the deck: large displacements, elements of `element_size` [mm] on the contact faces,
    or what `change` does.
    """
    settings = DeckSettings()
    program = find_calculix()
    if element_size is not None:
        half_width = next(
            expected.value
            for expected in load_scene(scene).expected
            if expected.quantity == "largest_half_width"
        )
        settings = replace(
            settings,
            element_size=element_size / half_width,
            edge_element_size=element_size / half_width,
        )
    deck = change(build_deck(load_scene(scene), settings))
    middle = int(deck.lower.first_node + np.argmin(np.hypot(*deck.lower.nodes.T)))
    text = deck_text(deck).replace("*CONTACT FILE", "*NODE FILE\nU\n*EL FILE\nS\n*CONTACT FILE", 1)
    if large:
        text = text.replace("NLGEOM=NO", "NLGEOM=YES")
    with tempfile.TemporaryDirectory(prefix="halfplane-roller-") as name:
        folder = Path(name)
        (folder / "roller.inp").write_text(text, encoding="utf-8")
        process = run_calculix(program, folder, "roller", float(deck.deck_time[-1]), LIMIT)
        frd = read_frd(folder / "roller.frd", ("DISP", "STRESS", "CONTACT"))

    def last(block: str, component: str) -> float:
        """A nodal value in the last frame, under the middle of the roller."""
        frame = [expected for expected in frd.blocks if expected.name == block][-1]
        return float(frame.column(component)[np.flatnonzero(frame.nodes == middle)[0]])

    return {
        "code": f"CalculiX {calculix_version(program)}",
        "nodes": deck.node_count,
        "seconds": round(process.seconds, 1),
        "displacement": round(last("DISP", "D2"), 6),
        "stress": round(-last("STRESS", "SYY"), 2),
        "pressure per undeformed length": round(last("CONTACT", "CPRESS"), 2),
    }


# ---------------------------------------------------------------------------------------- the cases
# The library in one revolution, but for the two whose time series make decks of many hundred
# instants; those that take two
# revolutions to become steady in two; a stiffer stick.
CASES = {
    name: partial(measured, name, DeckSettings(cycles=1))
    for name in sorted(scene_names())
    if name != "time-series"
}
CASES |= {
    f"{name}, 2 revolutions": partial(measured, name, DeckSettings())
    for name in ("hertz-paper", "cattaneo-mindlin", "flat-pad-on-block")
}
CASES["cattaneo-mindlin, stick slope 50"] = partial(
    measured, "cattaneo-mindlin", DeckSettings(cycles=1, stick_stiffness=50.0)
)
CHANGES: dict[str, dict[str, Any]] = {
    "as exported": {},
    "large displacements": {"large": True},
    "whole cylinder, force at its top": {"change": whole_cylinder},
    "two increments": {"change": two_increments},
    "elements of 1.5 mm": {"element_size": COARSE},
    "elements of 1.5 mm, large displacements": {"element_size": COARSE, "large": True},
}
ROLLERS = {
    f"{scene}: {words}": partial(on_roller, scene, **change)
    for scene in ("cylinder-roller", "cylinder-roller-frictionless")
    for words, change in CHANGES.items()
}


def dated(case: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    row = case() | {"day": datetime.now(UTC).date().isoformat(), "commit": commit()}
    print(
        row.get("failure") or row.get("errors") or f"{row['displacement']} mm, {row['stress']} MPa",
        flush=True,
    )
    return row


def main(words: list[str]) -> int:
    asked = chosen(words, CASES | ROLLERS)
    for file, cases in ((STORED, CASES), (ROLLER, ROLLERS)):
        for name in [
            name for name in cases if name in asked and (words or name not in stored(file))
        ]:
            measure(file, {name: partial(dated, cases[name])}, [name])
            known = stored(file)
            write_json(
                file,
                {
                    each: known[each]
                    for each in (sorted(known) if file == STORED else cases)
                    if each in known
                },
            )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
