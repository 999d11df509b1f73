"""Size and speed of the half-plane engine in two checkouts, side by side in one run.

    python benchmarks/before_after.py OTHER_CHECKOUT [REPEATS]

Times are of the processor. The two take turns, so that a busy machine slows both; the smallest of each is printed.
"""

from __future__ import annotations

import ast
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parents[1]
MEMBERS = {"hertz": 400_000, "flat_rounded": 200_000, "power_law": 200_000}  # the others: as many as take about a second
LOADS = {"mean_normal_load": 1.0, "phase": math.pi / 2}


def best(function: Callable[[], Any], least: float = 0.5) -> float:
    """The smallest time of a call [s]: at least three, for about half a second."""
    times: list[float] = []
    while len(times) < 3 or (sum(times) < least and len(times) < 50):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)


def rows(count: int) -> list[list[float]]:
    """A measured profile, x = 0 to 3, that is nearly a parabola."""
    x = np.linspace(0, 3, count)
    return np.column_stack([x, np.cosh(x / 2) - 1]).tolist()


def measured(entry: str) -> float:
    """One row of the table, in this process."""
    from scenes import Elastic, Materials, Scene, load_scene

    if entry == "import semi_analytic [s]":
        begin = time.process_time()
        import semi_analytic

        return time.process_time() - begin
    import semi_analytic

    paper = load_scene("hertz-paper")
    if entry.startswith("files opened") or entry.startswith("lines of"):
        return _entered(paper, entry.startswith("files opened"))
    if entry == "solve(hertz-paper) [s]":
        return best(lambda: semi_analytic.solve(paper))
    if entry == "solve(harmonics) [s]":
        scene = load_scene("harmonics")
        return best(lambda: semi_analytic.solve(scene))
    steel = Elastic(young_modulus=2.0, poisson_ratio=0.0)
    profiles: dict[str, dict[str, Any]] = {
        "hertz": {"kind": "hertz", "radius": 1.0},
        "flat_rounded": {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 0.5},
        "power_law": {"kind": "power_law", "exponent": 3.5, "length": 1.0, "rise": 0.6},
        "compound": {"kind": "compound", "inner_radius": 1.0, "outer_radius": 3.0, "inner_half_length": 0.4},
        "polynomial": {"kind": "polynomial", "length": 1.0, "rises": [0.5, 0.3]},
        "table of 31": {"kind": "tabulated", "points": rows(31)},
        "table of 1001": {"kind": "tabulated", "points": rows(1001)},
    }
    load = {"kind": "ellipse", "mean_normal_load": 1.0, "normal_amplitude": 0.4, "tangential_amplitude": 0.3}
    material = Materials(upper=steel, lower=steel)

    def scene_on(kind: str) -> Scene:
        given = {"material": material.model_dump(), "profile": profiles[kind], "friction": {"coefficient": 0.8}, "load": load}
        return Scene.model_validate_json(json.dumps(given))

    if entry.startswith("solve on "):
        scene = scene_on(entry.removeprefix("solve on ").removesuffix(" [s]"))
        return best(lambda: semi_analytic.solve(scene))
    kind = entry.removeprefix("batch on ").removesuffix(" [1/s]")
    profile = scene_on(kind).profile
    count = MEMBERS.get(kind, 300)
    while True:  # ends: the count grows until a call takes a third of a second
        draw = np.random.default_rng(1)
        arrays = {
            "friction_coefficient": draw.uniform(0.5, 1.0, count),
            "normal_amplitude": draw.uniform(0.0, 0.8, count),
            "tangential_amplitude": draw.uniform(0.01, 0.08, count),
        }
        begin = time.process_time()
        semi_analytic.dissipation(profile=profile, material=material, **LOADS, **arrays)
        seconds = time.process_time() - begin
        if seconds > 0.3 or count >= 400_000:
            return count / seconds
        count = min(4 * count, 400_000)


def _entered(scene: Any, files: bool) -> float:
    """Files of the project that a solve enters, or lines of the functions entered."""
    import semi_analytic

    codes = set()

    def see(frame: Any, event: str, _: Any) -> None:
        if event == "call":
            codes.add(frame.f_code)

    sys.setprofile(see)
    try:
        semi_analytic.solve(scene)
    finally:
        sys.setprofile(None)
    own = [code for code in codes if f"{os.sep}semi_analytic{os.sep}" in code.co_filename]
    if files:
        return len({code.co_filename for code in own})
    named = [code for code in own if not code.co_name.startswith("<")]
    return sum(max((line or 0) for _, _, line in code.co_lines()) - code.co_firstlineno + 1 for code in named)


ENTRIES = (
    *("files opened by solve(hertz-paper)", "lines of the functions entered", "import semi_analytic [s]"),
    *(
        "solve(hertz-paper) [s]",
        "solve(harmonics) [s]",
        "solve on hertz [s]",
        "solve on flat_rounded [s]",
        "solve on power_law [s]",
    ),
    *("solve on compound [s]", "solve on polynomial [s]", "solve on table of 31 [s]", "solve on table of 1001 [s]"),
    *("batch on hertz [1/s]", "batch on flat_rounded [1/s]", "batch on power_law [1/s]", "batch on compound [1/s]"),
    *("batch on polynomial [1/s]", "batch on table of 31 [1/s]"),
)


def sizes(tree: Path) -> dict[str, float]:
    """Files, lines and statements of the two packages."""
    found: dict[str, float] = {}
    for package in ("scenes", "semi_analytic"):
        texts = [path.read_text(encoding="utf-8") for path in (tree / package).glob("*.py")]
        nodes = sum(isinstance(node, ast.stmt) for text in texts for node in ast.walk(ast.parse(text)))
        found |= {f"{package}: files": len(texts), f"{package}: lines": sum(len(text.splitlines()) for text in texts)}
        found[f"{package}: statements"] = nodes
    return found


def main() -> None:
    other, repeats = Path(sys.argv[1]).resolve(), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    trees = {"before": other, "after": HERE}
    size = {name: sizes(tree) for name, tree in trees.items()}
    print(f"{'':45s} {'before':>12s} {'after':>12s} {'after/before':>12s}")
    for key in size["before"]:
        _line(key, size["before"][key], size["after"][key])
    for entry in ENTRIES:
        found: dict[str, list[float]] = {name: [] for name in trees}
        for _ in range(1 if entry.startswith(("files", "lines")) else repeats):
            for name, tree in trees.items():
                command = [sys.executable, __file__, "--one", entry]
                environment = os.environ | {"PYTHONPATH": str(tree), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
                text = subprocess.run(command, env=environment, cwd=tree, check=True, capture_output=True, text=True).stdout
                found[name].append(float(text))
        pick = max if entry.endswith("[1/s]") else min
        _line(entry, pick(found["before"]), pick(found["after"]))


def _line(name: str, before: float, after: float) -> None:
    print(f"{name:45s} {before:12.4g} {after:12.4g} {after / before:12.3f}", flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "--one":
        print(measured(sys.argv[2]))
    else:
        main()
