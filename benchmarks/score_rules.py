"""How far the rules and readers of `halfplane score` are off on results that are right: theory's own fields, our own, real decks.

python benchmarks/score_rules.py
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from claim import ROOT, Row, table
from reports.scoring.rule import UNTOLD
from reports.scoring.zones import TOUCHES, zones

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution
from reports.comparison.metrics import scales
from reports.field_output.files import instants_of, write_fields
from reports.scoring.against import score
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read
from reports.scoring.solution import friction_work
from reports.scoring.surface import SurfaceResult
from scenes import ContactSolution, Scene, load_scene

SCENE = "hertz-paper"
DECKS = ROOT / "tests" / "data"
DECK_LOAD = 400.0  # P of the decks [force / thickness]
DECK_RESULTS = {
    "node to surface": ("node-to-surface.frd", "node-to-surface.dat"),
    "mortar": ("mortar.frd",),
    "surface to surface": ("surface-to-surface.frd", "surface-to-surface.dat"),
}


def theory(instants: int, points: int = 105) -> ContactSolution:
    """The second cycle of the paper, at evenly spaced instants, both ends included."""
    scene = load_scene(SCENE)
    path = scene.load.path()
    assert path.period is not None
    time = path.cycle_start + path.period * np.linspace(1, 2, instants)
    return semi_analytic.solve(scene, x=np.linspace(-1.3, 1.3, points), time=time)


def on_theory() -> Iterator[Row]:
    """The rules on theory's own fields."""
    own = theory(25)
    found = score(own.x, own.pressure, own.shear, scene=own.scene)
    how = f"{SCENE}, 25 instants found from the integrals of p and q over 105 points"
    yield Row("instants from integrals: peak pressure", float(found.metric("peak_pressure").value or 0.0), 5e-5, how)
    few = theory(21)
    work = float(np.trapezoid(friction_work(few.shear, few.slip), few.x))
    how = f"{SCENE}, theory's own fields at 105 points"
    yield Row("sum of q ds over a cycle of 21 instants: too little by", 100 * (1 - work / few.dissipation), None, how, "%")


class _WithoutSlip:
    """Tractions of a solution, as a file without slip has them."""

    def __init__(self, solution: ContactSolution) -> None:
        self.x, self.pressure, self.shear, self.slip = solution.x, solution.pressure, solution.shear, None


def without_slip(fe: FiniteElementSolution) -> Iterator[Row]:
    """Stick edges told from tractions alone, on theory's own at the points and instants of finite elements."""
    steps = fe.last_cycle
    own = semi_analytic.solve(fe.scene, x=fe.x, time=fe.time[steps])
    found = zones(_WithoutSlip(own), fe.scene.friction.coefficient, own.time)
    off = np.max(np.abs(found.stick_edges - own.stick_edges), axis=1) / scales(own).half_width
    both = np.isnan(found.stick_edges[:, 0]) == np.isnan(own.stick_edges[:, 0])
    how = f"{SCENE}, theory at the {len(fe.x)} points and {len(steps)} instants of a cycle of the finite elements"
    yield Row("stick edge without slip, off by up to", float(np.nanmax(off)), None, how, "a")
    untold = int(np.sum(~both | (off > UNTOLD)))
    yield Row(f"instants at which it is off by more than {UNTOLD:g} a", float(untold), None, how)
    yield Row("... of so many", float(len(steps)), None, how)


def own_fields(fe: FiniteElementSolution) -> Iterator[Row]:
    """Our own fields as somebody else's files: the whole collection, and nodal stress alone, as files without tractions have it."""
    times = [instant.time for instant in instants_of(["events"], fe, "fields")]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        collection = folder / write_fields(fe, halfplane_fe.fields(fe, times), folder)[0]
        whole = read(collection, Mapping(), fe.scene)
        for file in folder.glob("contact_*.vtu"):
            file.unlink()
        bodies = [line for line in collection.read_text(encoding="utf-8").splitlines() if "contact_" not in line]
        collection.write_text("\n".join(bodies), encoding="utf-8")
        stress = read(collection, Mapping(), fe.scene)
    steps = [int(np.argmin(np.abs(fe.time - time))) for time in times]
    off = max(float(np.max(np.abs(a - b[steps]))) for a, b in ((whole.pressure, fe.pressure), (whole.shear, fe.shear)))
    how = f"{SCENE}, all three parts of the fields at {len(times)} events, against the run that wrote them; over the largest p"
    yield Row("fields.pvd of our own: tractions read back, off by", off / float(fe.pressure.max()), 0.0, how)
    yield from nodal_stress(stress, fe.scene)


def nodal_stress(found: SurfaceResult, scene: Scene) -> Iterator[Row]:
    """What stress taken for traction adds up to, over P and Q."""
    assert found.time is not None
    normal, tangential = scene.load.path().at(found.time)
    carries = np.abs(tangential) > 0.1 * normal
    touching = found.pressure > TOUCHES * found.pressure.max(axis=1, keepdims=True)
    inside, whole = (
        np.trapezoid(q, found.x, axis=1)[carries] / tangential[carries] for q in (np.where(touching, found.shear, 0.0), found.shear)
    )
    how = f"{SCENE}, fields of both bodies at {len(found.time)} events of a cycle, worst of them; Q where it is more than 0.1 P"
    pressure = np.trapezoid(found.pressure, found.x, axis=1) / normal
    yield Row("nodal stress: p adds up to P, off by", float(np.max(np.abs(pressure - 1))), None, how)
    yield Row("nodal stress: q within the contact adds up to Q, off by", float(np.max(np.abs(inside - 1))), None, how)
    yield Row("nodal stress: q over the whole face, over Q", float(whole[np.argmax(np.abs(whole - 1))]), None, how)


def decks(scene: Scene) -> Iterator[Row]:
    """What CalculiX wrote for the decks of tests/data: trapezia over the pressures, over P."""
    for kind, names in DECK_RESULTS.items():
        for name in names:
            found = read(DECKS / name, Mapping(), scene)
            share = np.trapezoid(found.pressure[-1], found.x) / DECK_LOAD
            how = f"tests/data/{name}, last instant; trapezia over the pressures"
            yield Row(f"{kind}, {Path(name).suffix}: adds up to P, off by", 100 * float(share - 1), None, how, "%")


def rows() -> Iterator[Row]:
    """All rows of this page."""
    fe = halfplane_fe.solve(load_scene(SCENE))
    yield from on_theory()
    yield from without_slip(fe)
    yield from own_fields(fe)
    yield from decks(fe.scene)


if __name__ == "__main__":
    print(table(list(rows())))
