"""What the page's slider needs: the last cycle at a few instants and points, as whole numbers of 16 bits.

The result is kept as reference plus difference, each in its own scale, so that a difference of a thousandth has four digits too.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reports.page.figures import Shown, places, sheared_shift
from reports.units import load_unit, units

Array = NDArray[np.float64]
# Largest number of instants, and of instants times points, that a page carries: 1.6 MB.
_MOST_INSTANTS, MOST_VALUES = 200, 100_000
# Letters of the longest CSV that a page carries.
_LETTERS = 1_500_000
_STEPS, _NOTHING = 32766, -32768


def _quantised(values: Array) -> dict[str, Any]:
    """Numbers as 16-bit whole numbers of a step, little-endian in base64; what is not finite is a number of its own.

    >>> _quantised(np.array([0.0, 2.0, -1.0]))["step"] * 32766
    2.0
    """
    finite = np.isfinite(values)
    step = float(np.max(np.abs(values[finite]), initial=0.0)) / _STEPS or 1.0
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), _NOTHING).astype("<i2")
    return {"step": step, "data": base64.b64encode(whole.tobytes()).decode()}


def cycle_data(shown: Shown) -> dict[str, Any]:
    """Everything that the slider moves, and how much of the cycle that is."""
    comparison, expected, found, scales = shown.comparison, shown.expected, shown.found, shown.scales
    # All instants, or evenly many of them with the first, the last and the chosen ones; of the points those that are drawn.
    last = len(found.time) - 1
    even = np.linspace(0, last, min(last + 1, _MOST_INSTANTS)).round().astype(int)
    rows = np.unique([*even.tolist(), 0, last, *(event.index for event in shown.chosen)])
    inside = np.flatnonzero(np.abs(shown.x) <= 1.02 * shown.wide)
    points = np.unique([*inside[:: -(-len(inside) * len(rows) // MOST_VALUES)].tolist(), inside[-1], *places(comparison)])
    grid = np.ix_(rows, points)
    series = {
        "t": shown.time,
        "P": found.normal_load,
        "Q": found.tangential_load,
        "U0": expected.tangential_displacement,
        "U1": found.tangential_displacement,
        "V0": sheared_shift(expected),
        "V1": sheared_shift(found),
    }
    sizes = {"p": ("pressure", scales.pressure), "q": ("shear", scales.shear), "s": ("slip", 1.0)}
    fields = {}
    for key, (name, size) in sizes.items():
        theirs, ours = getattr(expected, name)[grid] / size, getattr(found, name)[grid] / size
        fields[key] = _quantised(theirs)
        fields[f"d{key}"] = _quantised(ours - theirs)
    states = expected.state[grid].astype(np.uint8) + 4 * found.state[grid].astype(np.uint8)
    return {
        "instants": len(rows),
        "points": len(points),
        "of": [len(found.time), len(found.x)],
        "rows": rows.tolist(),
        "x": [float(f"{v:.7g}") for v in shown.x[points]],
        "series": {name: [_short(v) for v in values[rows]] for name, values in series.items()},
        "fields": fields,
        "states": base64.b64encode(states.tobytes()).decode(),
        "events": [[int(np.flatnonzero(rows == event.index)[0]), event.label] for event in shown.chosen],
        "start": int(np.flatnonzero(rows == shown.start)[0]),
        "slip_points": [int(np.flatnonzero(points == place)[0]) for place in places(comparison)],
        "time_words": shown.time_words,
        "load_unit": load_unit(comparison.scene),
        "length": units(comparison.scene)[1],
        "engines": [name for _, _, name in shown.sides],
    }


def _short(value: float) -> float | None:
    return float(f"{value:.7g}") if np.isfinite(value) else None


def carried(data: dict[str, Any]) -> str:
    """How much of the cycle the slider moves through, in a sentence."""
    instants, points = data["of"]
    if (data["instants"], data["points"]) == (instants, points):
        return "The slider moves through every instant and point of the last cycle."
    return (
        f"The slider moves through {data['instants']} of the {instants} instants and {data['points']} of the {points} points of "
        "the last cycle (those near the contact); figures that stand still, and the CSV, hold all of them, but where their "
        "captions say less."
    )


def tables(texts: Mapping[str, str]) -> dict[str, str]:
    """Name -> the CSV of each figure, deflated; those over `_LETTERS` stay beside the page only."""
    short = {name: text for name, text in texts.items() if len(text) <= _LETTERS}
    return {name: base64.b64encode(zlib.compress(text.encode(), 9)).decode() for name, text in short.items()}


def as_script(data: dict[str, Any]) -> str:
    """JSON that can stand in a script element: no "<" in it, so nothing in a name can end the element.

    >>> as_script({"engine": "</script>"})
    '{"engine":"\\\\u003c/script>"}'
    """
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
