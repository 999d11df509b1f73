"""What the inputs of the paper's cycle between two blocks make of W and of the difference, how long
that takes, and whether finite elements of moved scenes say the same.
"""

from __future__ import annotations

from collections.abc import Iterator

from claims import Row, seconds

import halfplane_fe
import semi_analytic
from reports.inputs import WORK, draws_of_work, input_effects
from scenes import Scene, load_scene

KNOWN = {
    "friction": "5 %",
    "normal_load": "2 %",
    "tangential_load": "2 %",
    "phase_degrees": "0.05 rad",
    "profile": {"radius": "1 %"},
    "material": {"young_modulus": "1 %"},
}
WORDS = "f known to 5 %, P and Q to 2 %, R and E to 1 %, phase to 0.05 rad"


def difference_by_elements(scene: Scene) -> float:
    """E of W: finite elements over theory, minus 1."""
    theory = semi_analytic.solve(scene, x=0.0, fields=(WORK,)).dissipation
    return float(halfplane_fe.solve(scene).dissipation / theory - 1)


def of_blocks() -> Iterator[Row]:
    scene = load_scene("blocks").vary(uncertainty=KNOWN)
    effects = halfplane_fe.body_effects(scene)
    found = input_effects(scene, effects)
    assert found is not None
    work = found.values[WORK]
    yield Row("blocks: W, inputs", 100 * work.relative_uncertainty, None, WORDS, "%")
    for key, name in (("tangential_load", "Q"), ("phase_degrees", "phase")):
        share = 100 * abs(work.changes[key].value) / work.value
        yield Row(f"blocks: W, {name} alone", share, None, WORDS, "%")
    difference = found.difference[WORK]
    points = 100 * difference.uncertainty
    yield Row("blocks: difference of W, inputs", points, None, WORDS, "points")
    worst = 0.0
    for entry in scene.inputs:
        above = difference_by_elements(scene.moved({entry.key: entry.standard_uncertainty}))
        below = difference_by_elements(scene.moved({entry.key: -entry.standard_uncertainty}))
        worst = max(worst, abs((above - below) / 2 - difference.changes[entry.key].value))
    yield Row(
        "blocks: what an input moves the difference by, off finite elements",
        100 * worst,
        0.0015,
        "the worst of six inputs, each moved both ways in finite elements and theory",
        "points",
    )
    drawn = draws_of_work(scene, "asked for")
    assert drawn is not None
    off = drawn.values[WORK].uncertainty / work.uncertainty - 1
    yield Row("blocks: u(W) by 100,000 draws over that by derivatives, minus 1", off, 0.02, WORDS)
    others = iter([scene.vary(friction=0.98 + 0.001 * k) for k in range(4)])
    by_draws, by_derivatives = seconds(
        lambda: draws_of_work(scene, "asked for"),
        lambda: input_effects(next(others), effects),
        times=3,
    )
    yield Row("100,000 draws of an ellipse: time", by_draws, 1.0, "W of each, in one call", "s")
    yield Row("what six inputs do, within a run: time", by_derivatives, 1.0, "of blocks", "s")
