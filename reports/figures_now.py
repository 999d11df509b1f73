"""The figure that the slider moves: tractions, zones along x, and where the loads and the shift stand at one instant."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from reports.charts.plate import Plate
from reports.comparison import Comparison
from reports.figures_fields import traction_keys, traction_panels, zones
from reports.figures_loops import first_shown, hysteresis_panel, load_panel, moves
from reports.instants import Event

_WIDTH = 560.0


def now(comparison: Comparison, chosen: Sequence[Event]) -> Plate:
    """Both engines at the chosen instant with most slip; axes hold the whole cycle, so that nothing leaves them as it moves."""
    expected, found = comparison.expected, comparison.found
    start, every = first_shown(found, chosen), range(len(found.time))
    tractions, difference = traction_panels(comparison, start, every, "now", (_WIDTH, 300.0), live=True)
    loops = [load_panel(comparison.result, found, chosen, "now-loads", 300.0)]
    if moves(comparison):
        loops.append(hysteresis_panel(comparison, chosen, "now-hysteresis", sheared=True))
    return Plate(
        "cycle",
        "The instant shown",
        "Tractions of both engines, what each point does, and result less reference. Then the loads and the loop of "
        "load over shift (less its mean slope, so that it opens); rings: the instant shown.",
        "Pressure and shear of both engines at one instant, zones of stick and slip, their difference, load path and loop.",
        (tractions, zones(comparison, start, _WIDTH), difference, *loops),
        {
            "time": found.time,
            "fraction": found.fraction,
            "P": found.normal_load,
            "Q": found.tangential_load,
            "U_reference": expected.tangential_displacement,
            "U_result": found.tangential_displacement,
            "points_where_states_differ": (expected.state != found.state).sum(axis=1).astype(np.int64),
        },
        traction_keys(comparison),
    )
