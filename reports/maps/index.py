"""The first page of the published maps: the designer's question answered from the tables, and what is where."""

from __future__ import annotations

from pathlib import Path

from reports.maps.answers import answer
from reports.maps.atlas import Map
from reports.maps.readings import read


def page(folder: Path, there: list[Map]) -> str:
    """Markdown of reports/published/maps/README.md."""
    parts = [
        "# Where the half-plane holds, and by how much it fails",
        "<!-- written by `halfplane map all` -->",
        "Finite elements on real bodies against half-plane theory, everything else equal; each error is finite elements over "
        "theory, less 1, with its uncertainty. `halfplane advise SCENE` reads a scene's own groups off these maps. docs/maps.md "
        "tells the theory.",
    ]
    for asked in there:
        points = sum(len(read(folder, study).rows) for study in asked.studies)
        parts += [f"## [{asked.title}]({asked.name}.md)", f"*{asked.question}* {answer(asked, folder)} ({points} points.)"]
    return "\n\n".join(parts) + "\n"
