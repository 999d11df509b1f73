"""Why the published values of the NAFEMS roller differ from ours: CalculiX on the exported deck, one change at a time.

    python benchmarks/roller.py                 (every case that has not been measured yet)
    python benchmarks/roller.py NAME ...        (these cases again; the others stay as found)

The reference values are those of Code_Aster's test SSNP154 (a to d), whose manual V6.03.154 names A. W. A. Konter's benchmark 1 as
its source: half of the model by symmetry, the whole cylinder with a point force of 17.5 kN at its top, the base of the block fixed,
linear or quadratic elements of 1.5 mm on the block's face, large displacements, two increments; the vertical displacement and the
Cauchy stress sigma_yy, extrapolated from the elements, of the block's face under the roller. Ours is half a cylinder, bonded to a
rigid plane at its middle, in small displacements, with the pressure of the contact itself.

Half a minute a case; `make peers` installs CalculiX. What is found is kept in roller.json; `make publish PAGES=1` writes the pages.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from claim import commit

from reports.scoring.calculix_files import FrdFile, read_frd
from reports.third.calculix import calculix_version, find_calculix, run_calculix
from reports.third.deck import Deck, DeckSettings, build_deck
from reports.third.dialects import deck_text
from scenes import freeze, load_scene

KEPT = Path(__file__).with_suffix(".json")
LIMIT = 3600.0
SCENES = ("cylinder-roller", "cylinder-roller-frictionless")
COARSE = 1.5
"""Length of the published elements on the block's face [mm]."""


@dataclass(frozen=True)
class Case:
    """The deck of a scene with one change or two.

    Attributes
    ----------
    change : in words
    large : large displacements
    element_size : of the contact faces [mm]; the deck's own where it is None
    model : what else is changed of the deck
    """

    scene: str
    change: str
    large: bool = False
    element_size: float | None = None
    model: Callable[[Deck], Deck] = lambda deck: deck

    @property
    def name(self) -> str:
        return f"{self.scene}: {self.change}"

    def deck(self) -> Deck:
        """The deck, changed."""
        settings = DeckSettings()
        if self.element_size is not None:
            share = self.element_size / _half_width(self.scene)
            settings = replace(settings, element_size=share, edge_element_size=share)
        return self.model(build_deck(load_scene(self.scene), settings))


def _half_width(scene: str) -> float:
    """a at the largest load, by Hertz, as the scene expects it [length]."""
    return next(one.value for one in load_scene(scene).expected if one.quantity == "largest_half_width")


def whole_cylinder(deck: Deck) -> Deck:
    """The half cylinder and its mirror image in its middle; the load acts at the top, on a cap as wide as the contact.

    A force on a single node would crush the small elements there. Nodes at x = 0 move along x together: no rolling.
    """
    upper = deck.upper
    y, first = upper.nodes[:, 1], upper.first_node
    middle = y.max()
    own = y > middle * (1 - 1e-9)
    number = np.where(own, np.arange(len(y)), len(y) + np.cumsum(~own) - 1)
    mirrored = np.stack([upper.nodes[~own, 0], 2 * middle - y[~own]], axis=1)
    nodes = np.concatenate([upper.nodes, mirrored])
    turned = number[upper.elements - first][:, [0, 3, 2, 1]] + first
    top = np.flatnonzero(nodes[:, 1] >= 2 * middle - deck.scales.half_width**2 / (2 * middle))
    axis = np.flatnonzero(np.abs(nodes[:, 0]) < 1e-9 * middle)
    held = {1: freeze(axis + first, np.int64), 2: freeze(top + first, np.int64)}
    elements = freeze(np.concatenate([upper.elements, turned]), np.int64)
    return replace(deck, upper=replace(upper, nodes=freeze(nodes), elements=elements, held=held))


def two_increments(deck: Deck) -> Deck:
    """The load in two halves."""
    half = (len(deck.time) - 1) // 2
    time, normal, tangential = (freeze(series[::half]) for series in (deck.time, deck.normal_load, deck.tangential_load))
    return replace(deck, time=time, normal_load=normal, tangential_load=tangential)


def cases() -> dict[str, Case]:
    """Name -> case."""
    found = []
    for scene in SCENES:
        found += [
            Case(scene, "as exported"),
            Case(scene, "large displacements", large=True),
            Case(scene, "whole cylinder, force at its top", model=whole_cylinder),
            Case(scene, "two increments", model=two_increments),
            Case(scene, "elements of 1.5 mm", element_size=COARSE),
            Case(scene, "elements of 1.5 mm, large displacements", element_size=COARSE, large=True),
        ]
    return {case.name: case for case in found}


def measured(case: Case) -> dict[str, Any]:
    """What CalculiX gives for the block's face under the roller, for JSON; pressures in MPa, displacements in mm."""
    deck, program = case.deck(), find_calculix()
    middle = int(deck.lower.first_node + np.argmin(np.hypot(*deck.lower.nodes.T)))
    text = deck_text(deck, "calculix").replace("*CONTACT FILE", "*NODE FILE\nU\n*EL FILE\nS\n*CONTACT FILE", 1)
    if case.large:
        text = text.replace("NLGEOM=NO", "NLGEOM=YES")
    with tempfile.TemporaryDirectory(prefix="halfplane-roller-") as name:
        folder = Path(name)
        (folder / "roller.inp").write_text(text, encoding="utf-8")
        done = run_calculix(program, folder, "roller", float(deck.deck_time[-1]), LIMIT)
        result = read_frd(folder / "roller.frd", ("DISP", "STRESS", "CONTACT"))
    return {
        "code": f"CalculiX {calculix_version(program)}",
        "nodes": len(deck.lower.nodes) + len(deck.upper.nodes),
        "seconds": round(done.seconds, 1),
        "displacement": round(_last(result, "DISP", "D2", middle), 6),
        "stress": round(-_last(result, "STRESS", "SYY", middle), 2),
        "pressure per undeformed length": round(_last(result, "CONTACT", "CPRESS", middle), 2),
        "day": datetime.now(UTC).date().isoformat(),
        "commit": commit(),
    }


def _last(result: FrdFile, block: str, component: str, node: int) -> float:
    """A nodal value in the last frame."""
    found = [one for one in result.blocks if one.name == block][-1]
    return float(found.column(component)[np.flatnonzero(found.nodes == node)[0]])


def kept() -> dict[str, dict[str, Any]]:
    """What was found before, by the name of the case."""
    return json.loads(KEPT.read_text(encoding="utf-8")) if KEPT.exists() else {}


def main(names: list[str]) -> int:
    known = cases()
    if unknown := [name for name in names if name not in known]:
        print(f"no case is called {' or '.join(unknown)}; there are: {'; '.join(known)}", file=sys.stderr)
        return 2
    before = kept()
    for name in names or [name for name in known if name not in before]:
        found = measured(known[name])
        content = kept() | {name: found}
        text = json.dumps({each: content[each] for each in known if each in content}, indent=1, ensure_ascii=False)
        KEPT.write_text(text + "\n", encoding="utf-8")
        print(f"{found['seconds']:6.1f} s  {name}: {found['displacement']} mm, {found['stress']} MPa", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
