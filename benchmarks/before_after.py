"""Size and speed of two checkouts, side by side in one run.

    python benchmarks/before_after.py OTHER_CHECKOUT [REPEATS]

Times are of the processor. The two take turns, so that a busy machine slows both; the smallest of each is printed.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parents[1]
PACKAGES = ("scenes", "semi_analytic", "meshes", "halfplane_fe", "reports", "benchmarks", "tests", "docs")
PROFILES = {
    "hertz": '{"kind": "hertz", "radius": 1.0}',
    "flat_rounded": '{"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 0.5}',
    "power_law": '{"kind": "power_law", "exponent": 3.5, "length": 1.0, "rise": 0.6}',
    "compound": '{"kind": "compound", "inner_radius": 1.0, "outer_radius": 3.0, "inner_half_length": 0.4}',
    "polynomial": '{"kind": "polynomial", "length": 1.0, "rises": [0.5, 0.3]}',
    "table of 31": '{"kind": "tabulated", "points": [[k / 10, np.cosh(k / 20) - 1] for k in range(31)]}',
    "table of 1001": '{"kind": "tabulated", "points": [[k / 333, np.cosh(k / 666) - 1] for k in range(1001)]}',
}
LOADS = (
    "mean_normal_load=1.0, phase=1.57, normal_amplitude=draw.uniform(0, 0.8, n), tangential_amplitude=draw.uniform(0.01, 0.08, n)"
)
FRICTION = "friction_coefficient=draw.uniform(0.5, 1.0, n)"
BATCH = f"semi_analytic.dissipation(profile=scene.profile, material=scene.material, {FRICTION}, {LOADS})"
SOLVE = "import semi_analytic; from scenes import load_scene; scene = load_scene({name!r})"
ON = """
import json, numpy as np, semi_analytic
from scenes import Scene
load = {{"kind": "ellipse", "mean_normal_load": 1.0, "normal_amplitude": 0.4, "tangential_amplitude": 0.3}}
given = {{"material": {{"young_modulus": 2.0, "poisson_ratio": 0.0}}, "friction": {{"coefficient": 0.8}}, "load": load}}
given["profile"] = {profile}
scene, draw, n = Scene.model_validate_json(json.dumps(given)), np.random.default_rng(1), {members}
"""
# What is timed: the preparation, and the statement.
TIMED = {
    "import semi_analytic": ("", "import semi_analytic"),
    "import halfplane_fe": ("", "import halfplane_fe"),
    "solve(hertz-paper)": (SOLVE.format(name="hertz-paper"), "semi_analytic.solve(scene)"),
    "solve(harmonics)": (SOLVE.format(name="harmonics"), "semi_analytic.solve(scene)"),
    "halfplane_fe.solve(hertz-paper)": ("import halfplane_fe;" + SOLVE.format(name="hertz-paper"), "halfplane_fe.solve(scene)"),
}
for name, profile in PROFILES.items():
    TIMED[f"solve on {name}"] = (ON.format(profile=profile, members=0), "semi_analytic.solve(scene)")
    TIMED[f"batch of 1000 on {name}"] = (ON.format(profile=profile, members=1000), BATCH)
PROGRAM = """
import time
{prepare}
least, spent = float("inf"), 0.0
while spent < 0.5:  # ends: every call takes time
    begun = time.process_time()
    {statement}
    took = max(time.process_time() - begun, 1e-6)
    least, spent = min(least, took), spent + (took if {repeats} else 1.0)
print(least)
"""


def sizes(tree: Path) -> dict[str, int]:
    """Files, lines and statements of Python by package."""
    found: dict[str, int] = {}
    for package in PACKAGES:
        texts = [path.read_text(encoding="utf-8") for path in (tree / package).rglob("*.py")]
        nodes = sum(isinstance(node, ast.stmt) for text in texts for node in ast.walk(ast.parse(text)))
        lines = sum(len(text.splitlines()) for text in texts)
        found |= {f"{package}: files": len(texts), f"{package}: lines": lines, f"{package}: statements": nodes}
    return found


def once(tree: Path, name: str) -> float:
    """Least CPU seconds of a call within half a second, in a process of its own in a checkout."""
    prepare, statement = TIMED[name]
    text = PROGRAM.format(prepare=prepare, statement=statement, repeats=not name.startswith("import"))
    one_thread = {"PYTHONPATH": str(tree), "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "HALFPLANE_CACHE": "off"}
    command = [sys.executable, "-c", text]
    return float(subprocess.run(command, env=os.environ | one_thread, cwd=tree, check=True, capture_output=True, text=True).stdout)


def main() -> None:
    trees, repeats = (Path(sys.argv[1]).resolve(), HERE), int(sys.argv[2]) if len(sys.argv) > 2 else 3
    print(f"{'':45s} {'before':>12s} {'after':>12s} {'after/before':>12s}")
    before, after = (sizes(tree) for tree in trees)
    rows = [(key, before[key], after[key]) for key in before]
    for name in TIMED:
        turns = [[once(tree, name) for tree in trees] for _ in range(repeats)]
        rows.append((f"{name} [s]", *map(min, zip(*turns, strict=True))))
    for name, one, other in rows:
        print(f"{name:45s} {one:12.4g} {other:12.4g} {other / one if one else float('nan'):12.3f}", flush=True)


if __name__ == "__main__":
    main()
