"""The published reports, reports/published/: one page for each scene of the library, their figures,
and the numbers of both.

    make publish            (python benchmarks/publishing.py, some minutes)
    make publish PAGES=1    (... --pages: the pages alone, from the numbers that are there)
    python benchmarks/publishing.py NAME ...   (the named scenes; all others stay as they are)

Two columns, kept apart. *External*: a closed form, a value with 30 digits or a published one, with
its tolerance; nothing that we compute goes into it. *Frozen*: our own figures of last time, of both
engines with their default settings; they say that nothing moved, not that anything is right.
values.json holds both, and every number on the pages is one of it.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.charts.templating import markdown_table, template
from reports.comparison import words
from reports.comparison.findings import COUNTS, SAME, Findings, difference, of_content, of_solution
from reports.comparison.laws import QUANTITIES
from reports.comparison.metrics import (
    METRICS,
    Metric,
    are_half_planes,
    name_of,
    tolerances_of,
    verdict_on,
)
from reports.console import say
from reports.folder import replace_text
from reports.units import minus
from scenes import Expected, InputError, Scene, load_scene, scene_names

if TYPE_CHECKING:
    from reports.comparison import Comparison

FOLDER = Path(__file__).parents[1] / "reports" / "published"
_TRUTHS = Path(__file__).with_name("regress.json")
ROLLER = _TRUTHS.with_name("roller.json")
# Largest difference from the frozen values before they count as stale, before the defaults of
# `difference`.
_STALE = {"*.counts.*": 0.05, "semi_analytic.*": 1e-10}
_EXACT = 1e-12  # tolerance of half-plane theory


@dataclass(frozen=True)
class External:
    """A figure that somebody else's mathematics gives."""

    key: str  # the figure of ours that it judges
    value: str  # as text, with every digit there is
    tolerance: float  # of the difference over the value; over A f^2 P^2 where the value is 0
    source: str  # where it comes from


# Rigid parabola on a bonded layer (no half-plane): tests/layer_truth.py, Fourier integrals; a is 1
# mm by the choice of the load. Tolerances: two elements of the contact edge (a/160), and what the
# library's Hertz scenes state for a peak.
_BY_FOURIER = "Fourier integrals for a bonded layer (Johnson 1985, section 5.8)"
_LAYER = (
    External("halfplane_fe.largest_half_width", "1.0", 0.0125, _BY_FOURIER),
    External("halfplane_fe.largest_pressure", "15.14298214", 2e-4, _BY_FOURIER),
)


def compute(name: str) -> Comparison:
    """Both engines on a scene of the library with their default settings, compared."""
    import halfplane_fe
    import semi_analytic
    from reports.comparison import compare
    from reports.comparison.budget import theory_on_steps

    scene = load_scene(name)
    result = halfplane_fe.solve(scene)
    reference = semi_analytic.solve(scene, x=result.x, time=result.time)
    return compare(reference, result, polygon_reference=theory_on_steps(result))


def half_plane_findings(name: str) -> Findings:
    """The figures of the half-plane engine on its own points and instants: no mesh, so quick enough
    for every test run.
    """
    import semi_analytic

    return of_solution(
        semi_analytic.solve(
            load_scene(name), fields=("dissipation", "pressure", "tangential_displacement")
        ),
        name,
    )


def findings(comparison: Comparison) -> Findings:
    """The figures of a scene: the metrics, the finite elements', and the half-plane engine's on its
    own points.
    """
    from reports.comparison import Report
    from reports.comparison.words import as_json

    name = comparison.scene.name
    both, alone = (
        of_content(json.loads(as_json(Report(comparison))), name),
        half_plane_findings(name),
    )
    if both.unfinished:
        raise InputError(f"{name}: not converged, so not published: {'; '.join(both.unfinished)}")
    kept = {
        key: value for key, value in both.figures.items() if not key.startswith("semi_analytic.")
    }
    for one in comparison.scene.expected:
        if one.engine == "finite elements":
            kept.setdefault(
                f"halfplane_fe.{one.quantity}", QUANTITIES[one.quantity].of(comparison.result)
            )
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

    truths = json.loads(_TRUTHS.read_text(encoding="utf-8")).get(scene.name, {})
    # quantity, value, metric whose tolerance finite elements have, source
    known: list[tuple[str, str, str, str]] = []
    if "reference" in truths:
        source = (
            "half-plane theory in 30-digit arithmetic, an independent evaluation"
            " (benchmarks/regress.py)"
        )
        known.append(("dissipation", truths["reference"], "dissipation", source))
    if isinstance(scene.profile, Hertz):
        # notation: P = pi E* a^2/(4 R), A = 2/E*
        half_width = math.sqrt(
            2 * compliance(scene.material) * largest_load * scene.profile.radius / math.pi
        )
        known.append(
            ("largest_half_width", repr(half_width), "contact_edge", "Hertz: P = π E* a²/(4 R)")
        )
        known.append(
            (
                "largest_pressure",
                repr(2 * largest_load / (math.pi * half_width)),
                "peak_pressure",
                "Hertz: 2 P/(π a)",
            )
        )
    for quantity, value, metric, source in known:
        # of theory it is that of its points, which may miss the peak
        if quantity != "largest_pressure":
            yield External(f"semi_analytic.{quantity}", value, _EXACT, source)
        if scene.bodies.half_planes:
            yield External(
                f"halfplane_fe.{quantity}",
                value,
                float(scene.tolerances.limit(metric) or 0.0),
                source,
            )
    if scene.name == "layer":
        yield from _LAYER
    if scene.load.has_bulk_or_tilt:
        works = (one for one in scene.expected if one.quantity == "dissipation")
        yield from (
            External(_key(one), repr(one.value), one.tolerance, one.source) for one in works
        )
    for one in published_by_others(scene):
        yield External(_key(one), repr(one.value), one.tolerance, one.source)


def _key(one: Expected) -> str:
    """The figure that an expected number is of."""
    return (
        f"{'semi_analytic' if one.engine == 'half-plane theory' else 'halfplane_fe'}.{one.quantity}"
    )


def error_of(
    external: External, figures: Mapping[str, float | None], scene: Scene, largest_load: float
) -> float:
    """Difference of our figure from an external one, in the measure of its tolerance."""
    from reports.comparison.metrics import compliance

    ours, theirs = figures[external.key], float(external.value)
    if ours is None:
        return math.inf
    size = (
        abs(theirs)
        or compliance(scene.material) * ((scene.friction.coefficient or 1.0) * largest_load) ** 2
    )
    return (ours - theirs) / size


def stored_content(comparison: Comparison) -> dict[str, Any]:
    """What values.json keeps of a scene."""
    found, scene = findings(comparison), comparison.scene
    largest_load = float(comparison.result.normal_load.max())
    return {
        "largest_normal_load": largest_load,
        "admissible": comparison.admissible,
        "absolute": [metric.key for metric in comparison.metrics if metric.absolute],
        "accurate": {
            metric.key: metric.accurate
            for metric in comparison.metrics
            if metric.accurate is not None
        },
        "external": [asdict(external) for external in externals(scene, largest_load)],
        "frozen": dict(found.figures),
    }


def frozen(name: str, stored: Mapping[str, Any]) -> Findings:
    """The frozen figures of a scene, for a comparison with those of now."""
    return Findings(
        f"values.json: {name}", load_scene(name), stored["frozen"], {}, tolerances=_STALE
    )


def values() -> dict[str, Any]:
    """values.json as it is; empty scenes where there is none yet."""
    path = FOLDER / "values.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else {"scenes": {}}


# ---------------------------------------------------------------------------------------- the pages

_ENGINES = ("semi_analytic", "halfplane_fe")


def page(name: str, stored: Mapping[str, Any]) -> str:
    """The page of a scene."""
    scene = load_scene(name)
    found = metrics(scene, stored)
    cells = [
        (m.label, words.value_of(m), m.unit, words.tolerance_of(m), m.verdict or "–") for m in found
    ]
    return _written(
        scene=scene,
        stored=stored,
        found=found,
        half_planes=are_half_planes(scene),
        bodies=" ".join(
            filter(
                None,
                (
                    of(scene)
                    for of in (words.bodies_in_words, words.unlike_materials, words.idealisation)
                ),
            )
        ),
        heads=("metric", "discrepancy", "as a share", "tolerance", "accurate"),
        judged=[row for row, m in zip(cells, found, strict=True) if m.tolerance is not None],
        others=[row[:3] for row, m in zip(cells, found, strict=True) if m.tolerance is None],
        external=_external_rows(scene, stored),
        roller=_causes(scene, stored["frozen"]),
        engines=[name_of(engine) for engine in _ENGINES],
        frozen=_frozen_rows(scene, stored["frozen"]),
    )


def index(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """The page that lists all."""
    rows = []
    for name, stored in scenes.items():
        scene = load_scene(name)
        found = {metric.key: metric for metric in metrics(scene, stored)}
        met = [
            metric.accurate
            for metric in found.values()
            if metric.tolerance is not None and metric.accurate is not None
        ]
        cells = [words.value_of(found[key]) for key in ("peak_pressure", "shear", "dissipation")]
        kind = "half-planes" if scene.bodies.half_planes else "real bodies"
        missed = [row for row in _external_rows(scene, stored) if row[5] == "outside"]
        rows.append(
            (
                f"[{name}]({name}.md)",
                scene.title,
                kind,
                *cells,
                f"{sum(met)} of {len(met)}",
                str(len(missed)),
            )
        )
    return _written(rows=rows)


def _written(rows: Sequence[Sequence[str]] = (), **content: Any) -> str:
    text = (
        template("publishing.md")
        .render(words=words, table=markdown_table, rows=rows, **content)
        .strip()
    )
    return re.sub(r"\n{3,}", "\n\n", text) + "\n"


def metrics(scene: Scene, stored: Mapping[str, Any]) -> list[Metric]:
    """The metrics with their values and tolerances; a published run has no budget, so |E| alone is
    judged.
    """
    found, tolerances = [], tolerances_of(scene, are_half_planes(scene))
    for key, value in stored["frozen"].items():
        part, _, name = key.partition(".")
        if part == "metric" and not name.endswith(".finite"):
            number = math.nan if f"{key}.finite" in stored["frozen"] else value
            tolerance = tolerances.get(name, tolerances.get(METRICS[name].judged_by))
            absolute, unmatched = name in stored["absolute"], name not in stored["accurate"]
            found.append(
                Metric(
                    definition=METRICS[name],
                    value=number,
                    tolerance=tolerance,
                    absolute=absolute,
                    unmatched=unmatched,
                )
            )
    return found


def _external_rows(scene: Scene, stored: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    for external in (External(**entry) for entry in stored["external"]):
        engine, _, quantity = external.key.partition(".")
        off = error_of(external, stored["frozen"], scene, stored["largest_normal_load"])
        yield (
            f"{QUANTITIES[quantity].words}, {name_of(engine)}",
            _number(stored["frozen"][external.key]),
            external.value if len(external.value) < 20 else f"{external.value[:20]}…",
            minus(f"{off:+.1e}"),
            f"{external.tolerance:.3g}",
            verdict_on(off, external.tolerance),
            external.source,
        )


def _causes(scene: Scene, figures: Mapping[str, float | None]) -> dict[str, Any] | None:
    """Why the published values of the roller differ from ours, as benchmarks/third.py measured it
    with CalculiX.
    """
    kept = json.loads(ROLLER.read_text(encoding="utf-8"))
    cases = {
        name.partition(": ")[2]: case
        for name, case in kept.items()
        if name.partition(": ")[0] == scene.name
    }
    if not cases:
        return None
    base, large, coarse = (
        cases[name] for name in ("as exported", "large displacements", "elements of 1.5 mm")
    )

    def change(case: Mapping[str, float], key: str) -> str:
        return "" if case is base else _per_cent(case[key] / base[key] - 1)

    found: dict[str, Any] = {"code": base["code"], "coarse": change(coarse, "stress")}
    found["pressure"] = change(large, "pressure per undeformed length")
    found["rows"] = [
        (
            name,
            minus(f"{case['displacement']:.4f}"),
            change(case, "displacement"),
            minus(f"{-case['stress']:.0f}"),
            change(case, "stress"),
        )
        for name, case in cases.items()
    ]
    for key, quantity in (
        ("displacement", "lower_face_displacement"),
        ("stress", "largest_pressure"),
    ):
        published = {one.source: one.value for one in scene.expected if one.quantity == quantity}
        quadratic, linear = (
            next(value for source, value in published.items() if f"{kind} elements" in source)
            for kind in ("quadratic", "linear")
        )
        mended = (figures[f"halfplane_fe.{quantity}"] or math.nan) * (
            1 + (large[key] / base[key] - 1)
        )
        found[key] = {
            "change": change(large, key),
            "mended": mended,
            "left": _per_cent(mended / quadratic - 1),
        }
        found["apart"] = _per_cent(linear / quadratic - 1)  # of the stress in the end
    return found


def _per_cent(share: float) -> str:
    return minus(f"{round(share, 4) + 0.0:+.2%}".replace("%", " %"))


def _frozen_rows(scene: Scene, figures: Mapping[str, float | None]) -> Iterator[tuple[str, ...]]:
    pulled = any(value for key, value in figures.items() if key.endswith(".bulk_work"))
    for name, quantity in QUANTITIES.items():
        keys = [f"{engine}.{name}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            named = (
                "closed integral of Q dU − m_q dε"
                if pulled and name == "loop_work"
                else quantity.words
            )
            yield (
                f"{named} [{words.shown_unit(scene, quantity.kind)[1]}]",
                *(_number(figures.get(key)) for key in keys),
            )
    for count in COUNTS:
        keys = [f"{engine}.counts.{count.replace(' ', '_')}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            yield count, *(f"{figures[key]:,}" if key in figures else "–" for key in keys)


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.10g}"


# -------------------------------------------------------------------------------------- the command


def _publish(names: Sequence[str]) -> int:
    """Compute, write, and say what moved; returns how many scenes did."""
    from reports.page.writing import published

    before, moved = values()["scenes"], 0
    kept = {name: stored for name, stored in before.items() if name in scene_names()}
    for name in names:
        comparison = compute(name)
        kept[name] = json.loads(json.dumps(stored_content(comparison), allow_nan=False))
        replace_text(FOLDER / f"{name}.svg", published(comparison))
        moved += _say_what_moved(name, before.get(name), kept[name])
    kept = dict(sorted(kept.items()))
    content = {"written by": "make publish", "settings": "both engines' defaults", "scenes": kept}
    replace_text(
        FOLDER / "values.json",
        json.dumps(content, allow_nan=False, indent=1, ensure_ascii=False) + "\n",
    )
    _write_pages(kept)
    for path in FOLDER.iterdir():
        if path.suffix in (".md", ".svg") and path.stem not in (*kept, "README"):
            path.unlink()
    return moved


def _write_pages(scenes: Mapping[str, Mapping[str, Any]]) -> None:
    """The pages and their index, from the stored numbers: enough where only words have changed."""

    for name, stored in scenes.items():
        replace_text(FOLDER / f"{name}.md", page(name, stored))
    replace_text(FOLDER / "README.md", index(scenes))


def _say_what_moved(name: str, before: Mapping[str, Any] | None, now: Mapping[str, Any]) -> bool:
    if before is None:
        say(f"{name}: new")
        return True
    rows = [
        row
        for row in difference(frozen(name, before), frozen(name, now)).rows
        if row.verdict != SAME
    ]
    say(f"{name}: {len(rows)} figures moved" if rows else f"{name}: as it was")
    for row in rows:
        say(f"  {row.key}: {row.a!r} -> {row.b!r} ({row.verdict})")
    return bool(rows)


def main(arguments: Sequence[str]) -> int:
    """Publish the whole library or the scenes named; with --pages write the pages again from
    values.json.
    """
    if list(arguments) == ["--pages"]:
        _write_pages(values()["scenes"])
        return 0
    if unknown := set(arguments) - set(scene_names()):
        say(f"no such scene in the library: {', '.join(sorted(unknown))}")
        return 2
    names = tuple(arguments) or scene_names()
    moved = _publish(names)
    say(f"{FOLDER.name}: {len(names)} scenes, {moved} moved; look at `git diff` before you commit")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
