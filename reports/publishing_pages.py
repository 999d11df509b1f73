"""The pages of the published reports, in Markdown: every number on them is one of values.json, every word one of the scene."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from reports.cli.findings import COUNTS
from reports.comparison.metrics import METRICS, Metric, are_half_planes, name_of, tolerances_of, verdict_on
from reports.comparison.words import (
    CLAIM,
    accuracy_of,
    bodies_in_words,
    idealisation,
    question,
    sentence,
    tolerance_of,
    unlike_materials,
    value_of,
)
from reports.publishing import ROLLER, External, error_of
from reports.units import energy_unit, units
from scenes import Scene, load_scene

_QUANTITIES = {
    "dissipation": "dissipation of the last cycle",
    "loop_work": "closed integral of Q dU",
    "permanent_stick_half_width": "permanent stick half-width",
    "largest_half_width": "largest contact half-width",
    "largest_pressure": "largest pressure at the points",
    "lower_face_displacement": "displacement of the lower face's middle along y",
}
_HEADS = ("metric", "discrepancy", "as a share", "tolerance", "accurate")
_ENGINES = ("semi_analytic", "halfplane_fe")


def page(name: str, stored: Mapping[str, Any]) -> str:
    """The page of a scene."""
    scene = load_scene(name)
    found = metrics(scene, stored)
    parts = [
        f"# {scene.title or name}",
        "<!-- written by `make publish`: edit the code, not this page -->",
        sentence(scene.purpose) + (f" Source: {sentence(scene.source)}" if scene.source else ""),
        question(scene),
        " ".join(filter(None, (bodies_in_words(scene), unlike_materials(scene), idealisation(scene)))),
        f"**{_lead(scene, found, stored)}**",
        f"![Tractions at the largest load and the loop of the last cycle, both engines]({name}.svg)",
        f"Largest normal load {stored['largest_normal_load']:.6g}; left, where it acts; right, the last cycle. "
        "Broad pale lines: half-plane theory, at the points of the finite elements; thin dark ones: finite elements.",
        "## Finite elements against half-plane theory",
        _table(_HEADS, _metric_rows([metric for metric in found if metric.tolerance is not None])),
        "<details><summary>Metrics without a tolerance</summary>",
        _table(_HEADS[:3], [row[:3] for row in _metric_rows([m for m in found if m.tolerance is None])]),
        "</details>",
        "## Against others: closed forms and published values",
        _table(("figure", "ours", "theirs", "difference", "tolerance", "verdict", "source"), _external_rows(scene, stored)),
        *_causes(scene, stored["frozen"]),
        "## Our own frozen values",
        "They say that nothing moved, not that it is right.",
        _table(("figure", *map(name_of, _ENGINES)), _frozen_rows(scene, stored["frozen"])),
        f"`halfplane run {name}` makes the whole report. {CLAIM}",
        "[All scenes](README.md)",
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def index(scenes: Mapping[str, Mapping[str, Any]]) -> str:
    """The page that lists all."""
    rows = []
    for name, stored in scenes.items():
        scene = load_scene(name)
        found = {metric.key: metric for metric in metrics(scene, stored)}
        met = [metric.accurate for metric in found.values() if metric.tolerance is not None and metric.accurate is not None]
        cells = [f"{value_of(found[key])}" for key in ("peak_pressure", "shear", "dissipation")]
        bodies = "half-planes" if scene.bodies.half_planes else "real bodies"
        missed = [e["key"] for e in stored["external"] if _off(scene, stored, External(**e)) == "outside"]
        rows.append((f"[{name}]({name}.md)", scene.title, bodies, *cells, f"{sum(met)} of {len(met)}", str(len(missed))))
    heads = ("scene", "title", "bodies", "peak p", "q, L2", "dissipation", "tolerances met", "external values missed")
    intro = (
        "Every scene of the library through both engines, with their default settings. The columns in per cent are finite elements "
        "against half-plane theory, worst instant of the last cycle; dissipation in A f² P_ref² where the reference has none. With "
        "real bodies the two answer different questions on purpose, and a tolerance missed is a finding about the idealisation.\n\n"
        "`make publish` writes this folder anew; [values.json](values.json) holds every number on these pages, and a test fails "
        "where the code gives another one. No uncertainty was requested, so each verdict is by |E| alone. "
        "What the two columns *external* and *frozen* are is told in "
        "[regression.md](../../docs/regression.md)."
    )
    return f"# Published reports\n\n<!-- written by `make publish` -->\n\n{intro}\n\n{_table(heads, rows)}\n"


def metrics(scene: Scene, stored: Mapping[str, Any]) -> list[Metric]:
    """The metrics with their values and tolerances; a published run has no budget, so |E| alone is judged."""
    found, tolerances = [], tolerances_of(scene, are_half_planes(scene))
    for key, value in stored["frozen"].items():
        part, _, name = key.partition(".")
        if part == "metric" and not name.endswith(".finite"):
            number = math.nan if f"{key}.finite" in stored["frozen"] else value
            tolerance = tolerances.get(name, tolerances.get(METRICS[name].judged_by))
            absolute, unmatched = name in stored["absolute"], name not in stored["accurate"]
            found.append(
                Metric(definition=METRICS[name], value=number, tolerance=tolerance, absolute=absolute, unmatched=unmatched)
            )
    return found


def _lead(scene: Scene, found: Sequence[Metric], stored: Mapping[str, Any]) -> str:
    outside = [f"{m.label[:1].lower()}{m.label[1:]} ({value_of(m)} {m.unit})" for m in found if m.accurate is False]
    laws = "both answers obey every law of contact" if stored["admissible"] else "a law of contact is violated"
    if not outside:
        return f"Within all tolerances of the scene; {laws}."
    why = "" if are_half_planes(scene) else ": a finding about the idealisation"
    return f"Outside tolerance in {', '.join(outside)}{why}; {laws}."


def _metric_rows(found: Sequence[Metric]) -> Iterator[tuple[str, ...]]:
    for metric in found:
        yield metric.label, value_of(metric), metric.unit, tolerance_of(metric), accuracy_of(metric)


def _external_rows(scene: Scene, stored: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    for entry in stored["external"]:
        external = External(**entry)
        engine, _, quantity = external.key.partition(".")
        off = error_of(external, stored["frozen"], scene, stored["largest_normal_load"])
        yield (
            f"{_QUANTITIES[quantity]}, {name_of(engine)}",
            _number(stored["frozen"][external.key]),
            external.value if len(external.value) < 20 else f"{external.value[:20]}…",
            f"{off:+.1e}",
            f"{external.tolerance:.3g}",
            _off(scene, stored, external),
            external.source,
        )


def _causes(scene: Scene, figures: Mapping[str, float | None]) -> Iterator[str]:
    """Why the published values of the roller differ from ours, as benchmarks/roller.py measured it with CalculiX; else nothing."""
    kept = json.loads(ROLLER.read_text(encoding="utf-8"))
    cases = {name.partition(": ")[2]: case for name, case in kept.items() if name.partition(": ")[0] == scene.name}
    if not cases:
        return
    base, large, coarse = (cases[name] for name in ("as exported", "large displacements", "elements of 1.5 mm"))
    keys = {"displacement": "lower_face_displacement", "stress": "largest_pressure"}

    def change(case: Mapping[str, float], key: str, of: Mapping[str, float] = base) -> float:
        return case[key] / of[key] - 1

    yield "### Why they differ"
    yield (
        "The published values are the references of Code_Aster's test SSNP154. Its manual V6.03.154 names Konter's benchmark 1 as "
        "their source and finds the quadratic ones in agreement with MSC.Marc; Konter's own tables we have not seen. Their model: "
        "the whole cylinder, a point force at its top, the base of the block fixed, elements of 1.5 mm on its face, large "
        "displacements, two increments. They give the displacement of the block's face under the roller, and the Cauchy stress "
        "σ_yy there, extrapolated from the elements. Our model: half a cylinder, bonded to a rigid plane at its middle, small "
        "displacements, the pressure of the contact itself."
    )
    yield f"{base['code']} on the exported deck (linear elements of a/40), one change at a time, at the same point:"
    heads = ("change", "displacement [mm]", "by", "σ_yy [MPa]", "by")
    rows = [
        (
            name,
            f"{case['displacement']:.4f}".replace("-", "−"),
            "" if case is base else _per_cent(change(case, "displacement")),
            f"{-case['stress']:.0f}".replace("-", "−"),
            "" if case is base else _per_cent(change(case, "stress")),
        )
        for name, case in cases.items()
    ]
    yield _table(heads, rows)
    ours = {key: figures[f"halfplane_fe.{quantity}"] or math.nan for key, quantity in keys.items()}
    mended = {key: value * (1 + change(large, key)) for key, value in ours.items()}
    published = {
        (key, kind): next(one.value for one in scene.expected if one.quantity == quantity and f"{kind} elements" in one.source)
        for key, quantity in keys.items()
        for kind in ("quadratic", "linear")
    }
    left = {key: _per_cent(value / published[key, "quadratic"] - 1) for key, value in mended.items()}
    apart = published["stress", "linear"] / published["stress", "quadratic"] - 1
    yield (
        f"Large displacements change the displacement by {_per_cent(change(large, 'displacement'))} and the stress by "
        f"{_per_cent(change(large, 'stress'))}. With these changes ours are {mended['displacement']:.4f} mm and "
        f"{mended['stress']:.0f} MPa, {left['displacement']} and {left['stress']} from the published quadratic elements. ".replace(
            "-", "−"
        )
        + f"Linear elements of 1.5 mm change the stress by {_per_cent(change(coarse, 'stress'))}; the published linear elements "
        f"differ from the quadratic ones by {_per_cent(apart)}. The contact pressure that CalculiX prints changes by "
        f"{_per_cent(change(large, 'pressure per undeformed length'))} with large displacements: it is per undeformed length, and "
        "the face is shortened."
    )


def _per_cent(share: float) -> str:
    return f"{round(share, 4) + 0.0:+.2%}".replace("%", " %").replace("-", "−")


def _off(scene: Scene, stored: Mapping[str, Any], external: External) -> str:
    off = error_of(external, stored["frozen"], scene, stored["largest_normal_load"])
    return verdict_on(off, external.tolerance)


def _frozen_rows(scene: Scene, figures: Mapping[str, float | None]) -> Iterator[tuple[str, ...]]:
    _, length, stress = units(scene)
    unit = {"dissipation": energy_unit(scene), "loop_work": energy_unit(scene), "largest_pressure": stress}
    for quantity, words in _QUANTITIES.items():
        keys = [f"{engine}.{quantity}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            yield f"{words} [{unit.get(quantity, length)}]", *(_number(figures.get(key)) for key in keys)
    for count in COUNTS:
        keys = [f"{engine}.counts.{count.replace(' ', '_')}" for engine in _ENGINES]
        if any(key in figures for key in keys):
            yield count, *(f"{figures[key]:,}" if key in figures else "–" for key in keys)


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.10g}"


def _table(heads: Sequence[str], rows: Iterator[tuple[str, ...]] | Sequence[tuple[str, ...]]) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
