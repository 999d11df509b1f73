"""Von Mises' stress in both bodies at chosen instants, for a page that was asked for it."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING

from reports.charts.plate import Plate
from reports.units import number, units

if TYPE_CHECKING:
    from halfplane_fe import FiniteElementSolution
    from reports.fields import Instant

# Dots per inch in the page: six pictures are 1 to 2 MB.
_DOTS = 80


def stress(solution: FiniteElementSolution, asked: Sequence[Instant]) -> Plate:
    """A picture for each instant: whole bodies, deformed and drawn apart, and the contact to true scale."""
    import halfplane_fe
    from reports.fields import NO_PEAK, peak
    from reports.stress_pictures import look, stress_picture

    snapshots = halfplane_fe.fields(solution, [instant.time for instant in asked])
    shared, panels = look(snapshots), []
    for instant, snapshot in zip(asked, snapshots, strict=True):
        image = io.BytesIO()
        stress_picture(solution, snapshot, instant.label, shared).savefig(image, format="png", dpi=_DOTS)
        address = "data:image/png;base64," + base64.b64encode(image.getvalue()).decode()
        alt = f"Von Mises stress in both bodies at time {number(snapshot.time)}, {instant.label}"
        panels.append(f'<img src="{address}" alt="{escape(alt)}">')
    peaks = [peak(snapshot) for snapshot in snapshots]
    _, length, stress_unit = units(solution.scene)
    return Plate(
        "von_mises",
        "Von Mises stress",
        "Left: both bodies, drawn apart, displacements exaggerated by the factor stated. Right: the contact to true scale. "
        + NO_PEAK,
        "Von Mises stress in both bodies at the instants asked for.",
        tuple(panels),
        {
            "instant": [instant.label for instant in asked],
            "time": [snapshot.time for snapshot in snapshots],
            f"largest nodal value [{stress_unit}]": [one.value for one in peaks],
            "body": [one.body for one in peaks],
            f"x [{length}]": [one.place[0] for one in peaks],
            f"y [{length}]": [one.place[1] for one in peaks],
        },
        columns=1,
    )
