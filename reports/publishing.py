"""The published reports, reports/published/: one page for each scene of the library, their figures, and the numbers of both.

    make publish            (python -m reports.publishing, some minutes)
    make publish PAGES=1    (... --pages: the pages alone, from the numbers that are there)
    python -m reports.publishing NAME ...   (the named scenes; all others stay as they are)

Two columns, kept apart. *External*: a closed form, a value with 30 digits or a published one, with its tolerance; nothing
that we compute goes into it. *Frozen*: our own figures of last time, of both engines with their default settings; they say
that nothing moved, not that anything is right. values.json holds both, and every number on the pages is one of it.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.findings import SAME, Findings, difference, of_content, of_solution
from reports.console import say
from reports.staging import replace_text
from scenes import Expected, InputError, Scene, load_scene, scene_names

if TYPE_CHECKING:
    from reports.comparison import Comparison

FOLDER = Path(__file__).with_name("published")
TRUTHS = Path(__file__).parents[1] / "benchmarks" / "regress.json"
ROLLER = TRUTHS.with_name("roller.json")
# Largest difference from the frozen values before they count as stale, before the defaults of `difference`.
STALE = {"*.counts.*": 0.05, "semi_analytic.*": 1e-10}
EXACT, CLOSED = 1e-12, 1e-12


@dataclass(frozen=True)
class External:
    """A figure that somebody else's mathematics gives.

    Attributes
    ----------
    key : the figure of ours that it judges
    value : as text, with every digit there is
    tolerance : of the difference over the value; over A f^2 P^2 where the value is 0
    source : where it comes from
    """

    key: str
    value: str
    tolerance: float
    source: str


# Rigid parabola on a bonded layer (no half-plane): tests/layer_truth.py, Fourier integrals; a is 1 mm by the choice of the load.
# Tolerances: two elements of the contact edge (a/160), and what the library's Hertz scenes state for a peak.
_BY_FOURIER = "Fourier integrals for a bonded layer (Johnson 1985, section 5.8)"
LAYER = (
    External("halfplane_fe.largest_half_width", "1.0", 0.0125, _BY_FOURIER),
    External("halfplane_fe.largest_pressure", "15.14298214", 2e-4, _BY_FOURIER),
)


def compute(name: str) -> Comparison:
    """Both engines on a scene of the library with their default settings, compared."""
    import halfplane_fe
    import semi_analytic
    from reports.comparison import compare

    scene = load_scene(name)
    result = halfplane_fe.solve(scene)
    reference = semi_analytic.solve(scene, x=result.x, time=result.time)
    polygon = semi_analytic.solve(scene, x=result.x, time=result.time, straight_steps=not result.thinned)
    return compare(reference, result, polygon_reference=polygon)


def half_plane_findings(name: str) -> Findings:
    """The figures of the half-plane engine on its own points and instants: no mesh, so quick enough for every test run."""
    import semi_analytic

    return of_solution(semi_analytic.solve(load_scene(name), fields=("dissipation", "pressure", "tangential_displacement")), name)


def findings(comparison: Comparison) -> Findings:
    """The figures of a scene: the metrics, the finite elements', and the half-plane engine's on its own points."""
    from reports.comparison.content import as_json
    from reports.comparison.expected import measure

    name = comparison.scene.name
    both, alone = of_content(json.loads(as_json(comparison)), name), half_plane_findings(name)
    if both.unfinished:
        raise InputError(f"{name}: not converged, so not published: {'; '.join(both.unfinished)}")
    kept = {key: value for key, value in both.figures.items() if not key.startswith("semi_analytic.")}
    for one in published_by_others(comparison.scene):
        kept.setdefault(f"halfplane_fe.{one.quantity}", measure(comparison.result, one.quantity))
    return Findings(name, both.scene, kept | dict(alone.figures), {**both.engines, **alone.engines})


def published_by_others(scene: Scene) -> Iterator[Expected]:
    """What a benchmark of other codes expects of finite elements."""
    if "benchmark" in scene.tags:
        yield from (one for one in scene.expected if one.engine == "finite elements")


def externals(scene: Scene, largest_load: float) -> Iterator[External]:
    """Everything that is known of a scene from elsewhere.

    Parameters
    ----------
    largest_load : P at the instant at which it is largest [force / thickness]
    """
    from reports.comparison.metrics import compliance
    from scenes import Hertz

    truths = json.loads(TRUTHS.read_text(encoding="utf-8")).get(scene.name, {})
    real = not scene.bodies.half_planes
    if "reference" in truths:
        source = "half-plane theory in 30-digit arithmetic, an independent evaluation (benchmarks/regress.py)"
        yield External("semi_analytic.dissipation", truths["reference"], EXACT, source)
        if not real:
            yield External(
                "halfplane_fe.dissipation", truths["reference"], float(scene.tolerances.limit("dissipation") or 0.0), source
            )
    if isinstance(scene.profile, Hertz):
        # notation: P = pi E* a^2/(4 R), A = 2/E*
        half_width = math.sqrt(2 * compliance(scene.material) * largest_load * scene.profile.radius / math.pi)
        pressure = 2 * largest_load / (math.pi * half_width)
        yield External("semi_analytic.largest_half_width", repr(half_width), CLOSED, "Hertz: P = π E* a²/(4 R)")
        if not real:
            yield External(
                "halfplane_fe.largest_half_width",
                repr(half_width),
                float(scene.tolerances.limit("contact_edge") or 0.0),
                "Hertz: P = π E* a²/(4 R)",
            )
            yield External(
                "halfplane_fe.largest_pressure",
                repr(pressure),
                float(scene.tolerances.limit("peak_pressure") or 0.0),
                "Hertz: 2 P/(π a)",
            )
    if scene.name == "layer":
        yield from LAYER
    for one in published_by_others(scene):
        yield External(f"halfplane_fe.{one.quantity}", repr(one.value), one.tolerance, one.source)


def error_of(external: External, figures: Mapping[str, float | None], scene: Scene, largest_load: float) -> float:
    """Difference of our figure from an external one, in the measure of its tolerance."""
    from reports.comparison.metrics import compliance

    ours, theirs = figures[external.key], float(external.value)
    if ours is None:
        return math.inf
    size = abs(theirs) or compliance(scene.material) * ((scene.friction.coefficient or 1.0) * largest_load) ** 2
    return (ours - theirs) / size


def stored_content(comparison: Comparison) -> dict[str, Any]:
    """What values.json keeps of a scene."""
    found, scene = findings(comparison), comparison.scene
    largest_load = float(comparison.result.normal_load.max())
    return {
        "largest_normal_load": largest_load,
        "admissible": comparison.admissible,
        "absolute": [metric.key for metric in comparison.metrics if metric.absolute],
        "accurate": {metric.key: metric.accurate for metric in comparison.metrics if metric.accurate is not None},
        "external": [asdict(external) for external in externals(scene, largest_load)],
        "frozen": dict(found.figures),
    }


def frozen(name: str, stored: Mapping[str, Any]) -> Findings:
    """The frozen figures of a scene, for a comparison with those of now."""
    return Findings(f"values.json: {name}", load_scene(name), stored["frozen"], {}, tolerances=STALE)


def values() -> dict[str, Any]:
    """values.json as it is; empty scenes where there is none yet."""
    path = FOLDER / "values.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"scenes": {}}


def publish(names: Sequence[str]) -> int:
    """Compute, write, and say what moved; returns how many scenes did."""
    from reports.publishing_figures import picture

    before, moved = values()["scenes"], 0
    kept = {name: stored for name, stored in before.items() if name in scene_names()}
    for name in names:
        comparison = compute(name)
        kept[name] = json.loads(json.dumps(stored_content(comparison), allow_nan=False))
        replace_text(FOLDER / f"{name}.svg", picture(comparison))
        moved += _say_what_moved(name, before.get(name), kept[name])
    kept = dict(sorted(kept.items()))
    content = {"written by": "make publish", "settings": "both engines' defaults", "scenes": kept}
    replace_text(FOLDER / "values.json", json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False) + "\n")
    write_pages(kept)
    for path in FOLDER.iterdir():
        if path.suffix in (".md", ".svg") and path.stem not in (*kept, "README"):
            path.unlink()
    return moved


def write_pages(scenes: Mapping[str, Mapping[str, Any]]) -> None:
    """The pages and their index, from the stored numbers: enough where only words have changed."""
    from reports.publishing_pages import index, page

    for name, stored in scenes.items():
        replace_text(FOLDER / f"{name}.md", page(name, stored))
    replace_text(FOLDER / "README.md", index(scenes))


def _say_what_moved(name: str, before: Mapping[str, Any] | None, now: Mapping[str, Any]) -> bool:
    if before is None:
        say(f"{name}: new")
        return True
    rows = [row for row in difference(frozen(name, before), frozen(name, now)).rows if row.verdict != SAME]
    say(f"{name}: {len(rows)} figures moved" if rows else f"{name}: as it was")
    for row in rows:
        say(f"  {row.key}: {row.a!r} -> {row.b!r} ({row.verdict})")
    return bool(rows)


def main(arguments: Sequence[str]) -> int:
    """Publish the whole library or the scenes named; with --pages write the pages anew from values.json."""
    if not TRUTHS.exists():
        say("reports are published from a checkout: benchmarks/regress.json is not there")
        return 2
    if list(arguments) == ["--pages"]:
        write_pages(values()["scenes"])
        return 0
    if unknown := set(arguments) - set(scene_names()):
        say(f"no such scene in the library: {', '.join(sorted(unknown))}")
        return 2
    names = tuple(arguments) or scene_names()
    moved = publish(names)
    say(f"{FOLDER.name}: {len(names)} scenes, {moved} moved; look at `git diff` before you commit")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
