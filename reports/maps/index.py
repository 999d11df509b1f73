"""The first page of the published maps: the designer's question answered from the tables, and what is where."""

from __future__ import annotations

import math
from pathlib import Path

from reports.comparison.metrics import compliance
from reports.maps.advice import cells, total
from reports.maps.advising import FIGURES, parts
from reports.maps.answers import answer, percent
from reports.maps.atlas import WORDS, Map
from reports.maps.readings import read
from reports.maps.tabling import table
from scenes import Block, Bodies, Cylinder, Elastic, Hertz, Materials, PolygonLoad, Scene, load_scene


def page(folder: Path, there: list[Map]) -> str:
    """Markdown of reports/published/maps/README.md."""
    words = (
        "Finite elements on real bodies against half-plane theory, everything else equal; each error is finite elements over "
        "theory, less 1, with its uncertainty. `halfplane advise SCENE` reads a scene's own groups off these maps. docs/maps.md "
        "tells the theory."
    )
    made = ["# Where the half-plane holds, and by how much it fails", "<!-- written by `halfplane map all` -->"]
    made += [_question(folder), words]
    for asked in there:
        points = sum(len(read(folder, study).rows) for study in asked.studies)
        made += [f"## [{asked.title}]({asked.name}.md)", f"*{asked.question}* {answer(asked, folder)} ({points} points.)"]
    return "\n\n".join(made) + "\n"


def designers_scene() -> Scene:
    """A block 4 a high and 8 a wide, steel, under a titanium cylinder of radius 8 a; f = 0.5, P constant, Q between +-0.6 f P."""
    steel, titanium = Elastic(young_modulus=210e3, poisson_ratio=0.3), Elastic(young_modulus=115e3, poisson_ratio=0.33)
    materials = Materials(lower=steel, upper=titanium)
    load = math.pi / (2 * 8.0 * compliance(materials))
    changes = {
        "material": materials,
        "profile": Hertz(radius=8.0),
        "bodies": Bodies(lower=Block(width=8.0, height=4.0), upper=Cylinder(radius=8.0)),
        "load": PolygonLoad(initial_loading=((load, 0.0), (load, 0.3 * load)), cycle=((load, -0.3 * load),)),
    }
    return load_scene("two-cylinders").vary(**changes, name="designer")


def _question(folder: Path) -> str:
    """The answer, its parts and their sum."""
    _, found = parts(designers_scene(), folder)
    known = [part for part in found if part.values is not None]
    error, doubt = total(known, "error.dissipation")
    missing = "" if len(known) == len(found) else f" (without {len(found) - len(known)} departures that no map here has)"
    says = "no" if abs(error) + doubt > 0.05 else "not known" if missing else "yes"
    words = (
        "*My block is 4 a high, the pad's radius is 8 a, the disc is titanium on steel: may I use half-plane theory?* "
        f"For dissipation within 5 %: **{says}**; it is off by {percent(error, doubt)}{missing}, p0 by "
        f"{percent(*total(known, 'error.p0'))}, at f = 0.5, the block 8 a wide on a fixed base. Errors add up, cross "
        "terms left out."
    )
    rows = [[part.what, *cells(part), part.how] for part in found]
    return words + "\n\n" + table(["departure", *(WORDS[figure] for figure in FIGURES), "where from"], rows)
