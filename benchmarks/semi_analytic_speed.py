"""How fast the half-plane engine is: whole solutions, straight steps, batches. Ratios in one run count.

Batches against bare numpy, their errors and memory: semi_analytic_batch.py.

python benchmarks/semi_analytic_speed.py
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from clock import seconds

from scenes import Elastic, FlatRounded, Hertz, Materials, load_scene
from semi_analytic import dissipation, peak_dissipation, solve

MEMBERS = 100_000
STEEL = Elastic(young_modulus=2.0, poisson_ratio=0.0)


def random_ellipses(count: int, seed: int = 0) -> dict[str, Any]:
    """P1/P0 in 0.01-0.9, phase in 0-pi, f log-uniform in 0.05-2, Q1 up to gross sliding, all uniform."""
    rng = np.random.default_rng(seed)
    ratio, phase = rng.uniform(0.01, 0.9, count), rng.uniform(0, np.pi, count)
    friction = np.exp(rng.uniform(np.log(0.05), np.log(2), count))
    cosine = np.abs(np.cos(phase))
    limit = -ratio * cosine + np.sqrt(1 - ratio**2 * (1 - cosine**2))
    return {
        "material": Materials(upper=STEEL, lower=STEEL),
        "friction_coefficient": friction,
        "mean_normal_load": 1.0,
        "normal_amplitude": ratio,
        "tangential_amplitude": rng.uniform(0, 1, count) * limit * friction,
        "phase": phase,
    }


def rows() -> Iterator[tuple[str, str]]:
    for name in ("hertz-paper", "cattaneo-mindlin", "motor"):
        scene = load_scene(name)
        own = solve(scene)
        yield f"solve({name}), {own.shear.shape[0]} instants x 200", f"{1e3 * seconds(lambda s=scene: solve(s), 3):.1f} ms"
        yield f"solve({name}), steady cycle only", f"{1e3 * seconds(lambda s=scene: solve(s, cycles='steady'), 3):.1f} ms"
        straight = seconds(lambda s=scene, o=own: solve(s, x=o.x, time=o.time, straight_steps=True), 2)
        yield f"solve({name}), {len(own.time) - 1} straight steps", f"{1e3 * straight:.0f} ms"
    members = random_ellipses(MEMBERS)
    hertz = seconds(lambda: dissipation(profile=Hertz(radius=1.0), **members), 3)
    flat = seconds(lambda: dissipation(profile=FlatRounded(radius=1.0, flat_half_length=0.7), **members), 3)
    yield "batch of Hertz ellipses", f"{MEMBERS / hertz:,.0f} a second"
    yield "batch of flat-and-rounded ellipses", f"{MEMBERS / flat:,.0f} a second, {flat / hertz:.1f} x Hertz"
    few = random_ellipses(1000)
    yield (
        "peaks of Hertz ellipses",
        f"{1000 / seconds(lambda: peak_dissipation(profile=Hertz(radius=1.0), **few), 2):,.0f} a second",
    )


def main() -> None:
    for name, figure in rows():
        print(f"{name:60s} {figure}")


if __name__ == "__main__":
    main()
