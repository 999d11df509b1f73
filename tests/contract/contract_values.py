"""What the contract freezes of an answer, and the first value of an answer that is too far from
it.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import contract_scenes
import numpy as np

import halfplane_fe
import reports
import scene_cases
import semi_analytic
from meshes import MeshSettings
from scenes import ContactSolution, InadmissibleLoadError, InputError, Scene

HERE = Path(__file__).parent
GRIDS = ("pressure", "shear", "slip")
SERIES = ("tangential_displacement", "normal_approach", "contact_half_width", "stick_half_width")
# places, as shares of the largest half-width
SHARES = (0.0, 0.13, 0.37, 0.61, 0.745, 0.83, 0.91, 0.97, 1.02)
INSTANTS = 12
SOLVER_NODES, SOLVER_STEPS = 9, 8

# The finite elements: each kind of body, of load and of material once, on the coarse mesh.
FINITE_ELEMENTS = (
    *(
        "cattaneo-mindlin",
        "hertz-paper",
        "flat-rounded-paper",
        "full-stick",
        "tiny-slip",
        "harmonics",
    ),
    *(
        "blocks",
        "flat-pad-on-block",
        "layer",
        "row-of-contacts",
        "two-cylinders",
        "unlike-beta-fifth",
    ),
)
COMPARED = FINITE_ELEMENTS[:3] + FINITE_ELEMENTS[5:]
# Half-plane scenes of `make test`, a few of each sort; `make contract` has all.
QUICK = (
    *(
        "cattaneo-mindlin",
        "hertz-paper",
        "flat-rounded-paper",
        "harmonics",
        "time-series",
        "unload-reload",
        "tiny-slip",
    ),
    *(
        "short-flat, ellipse",
        "power-3.5, ellipse",
        "compound, polygon",
        "table, polygon",
        "rows 1500, repeated",
    ),
    *("nowell-hills", "line of action", "slip of 1e-9", "P to 1e-9", "metres and pascals"),
    *("separates", "slides", "slides on a line"),
)


@cache
def frozen(name: str) -> dict[str, Any]:
    """A frozen file: half_plane, finite_elements or comparison."""
    return json.loads((HERE / f"{name}.json").read_text(encoding="utf-8"))


def scene_of(name: str) -> Scene:
    """A scene of the contract: of a file, drawn (from the frozen file), or made of Python
    functions.
    """
    if name in contract_scenes.library():
        return scene_cases.scene_of(name)
    if name in (made := contract_scenes.functions()):
        return made[name]
    drawn = frozen("half_plane")[name]["scene"]
    return Scene.model_validate_json(json.dumps({"name": name} | drawn))


# -------------------------------------------------------------------------------- half-plane theory
def half_plane(scene: Scene, x: list[float], time: list[float]) -> dict[str, Any]:
    """Every value of one scene: numbers, lists and tables of numbers (NaN as null)."""
    answer = semi_analytic.solve(scene, x=x, time=time)
    values: dict[str, Any] = {
        name: getattr(answer, name)
        for name in (*GRIDS, *SERIES, "dissipation_density", "cycle_dissipation")
    }
    values |= {
        name: float(getattr(answer, name))
        for name in ("dissipation", "loop_work", "permanent_stick_half_width")
    }
    values |= {"state": answer.state, "steady_from": answer.steady_from}
    values["events"] = [
        [one.letter, one.time, one.normal_load, one.tangential_load, one.front_load]
        for one in events_of(scene)
    ]
    if scene.load.kind == "ellipse" and not scene.unsymmetric:
        values |= _batch(scene)
    return {
        "values": plain(values),
        "stated": {name: error for name, error in answer.record.errors.items() if error > AGREES},
    }


def events_of(scene: Scene) -> list[semi_analytic.Event]:
    """Events of a short path whose memory is one curve; none of others."""
    if len(getattr(scene.load, "rows", ())) > 100:
        return []
    try:
        return list(semi_analytic.events(scene))
    except InputError:
        return []


def _batch(scene: Scene) -> dict[str, float]:
    """The same ellipse through the calls for arrays of ellipses."""
    load = scene.load
    given = {
        "friction_coefficient": scene.friction.coefficient,
        "mean_normal_load": load.mean_normal_load,
        "normal_amplitude": load.normal_amplitude,
        "mean_tangential_load": load.mean_tangential_load,
        "tangential_amplitude": load.tangential_amplitude,
        "phase": load.phase,
    }
    work = semi_analytic.dissipation(profile=scene.profile, material=scene.material, **given)
    peak = semi_analytic.peak_dissipation(profile=scene.profile, material=scene.material, **given)
    return {
        "batch": float(work.value),
        "batch_stick_load": float(work.permanent_stick_load),
        "batch_peak": float(peak.value),
    }


AGREES = 1e-12
"""Share of the largest value of a field within which two answers agree; the stated error of the
answer where that is larger.
"""

# What other computations than the fields' own agree within: a quadrature settled to 1e-10, and a
# maximum of W(x) to 1e-9.
LOOSER = {"batch": 1e-10, "batch_peak": 2e-9, "loop_work": 1e-10}


def refusal(scene: Scene) -> list[Any] | None:
    """Instant and loads at which a path is refused, None where it is not."""
    try:
        semi_analytic.solve(scene, x=[0.0])
    except InadmissibleLoadError as reason:
        kind = "separation" if str(reason).startswith("separation") else "gross sliding"
        return [kind, reason.time, reason.normal_load, reason.tangential_load]
    return None


def reference(scene: Scene) -> str | None:
    """Dissipation of the last cycle by other means than the engine's: 30 digits where it is stored;
    None where it takes minutes.
    """
    benchmarks = HERE.parents[1] / "benchmarks"
    if scene.name in contract_scenes.library():
        return (
            json.loads((benchmarks / "regress.json").read_text(encoding="utf-8"))
            .get(scene.name, {})
            .get("reference")
        )
    stored = frozen("half_plane").get(scene.name, {})
    if stored.get("reference") and scene_of(scene.name) == scene:
        return stored["reference"]
    long = len(getattr(scene.load, "rows", ())) > 100
    if long or scene.unsymmetric or scene.profile.kind != "hertz" or scene.load.kind == "callable":
        return None
    sys.path.insert(0, str(benchmarks))
    import mpmath
    from regress_truth import DIGITS, truth

    mpmath.mp.dps = DIGITS + 10
    return mpmath.nstr(truth(scene), DIGITS)


def places_and_instants(scene: Scene) -> tuple[list[float], list[float]]:
    """Where and when a scene is looked at: clear of events, where a state may change with the last
    digit.
    """
    answer = semi_analytic.solve(scene, x=[0.0], fields=("dissipation",))
    start, end = float(answer.time[0]), float(answer.time[-1])
    named = np.array([one.time for one in events_of(scene)])
    draw = np.random.default_rng(20261122)
    chosen: list[float] = []
    while len(chosen) < INSTANTS:  # ends: nearly every instant is clear
        time = float(draw.uniform(start, end))
        if not len(named) or np.min(np.abs(named - time)) > 1e-3 * (end - start) / max(
            len(named), 10
        ):
            chosen.append(time)
    if len(getattr(scene.load, "rows", ())) > 100:
        chosen = [float(int(time) + 0.37) if time < end - 1 else time for time in chosen]
    half = float(np.nanmax(answer.contact_half_width))
    return [share * half for share in SHARES], [*sorted(chosen), end]


# ------------------------------------------------------------------------------ the finite elements
@cache
def finite_elements(name: str) -> ContactSolution:
    """The answer on the coarse mesh."""
    return halfplane_fe.solve(scene_cases.scene_of(name), mesh=MeshSettings.coarse())


def fe_values(answer: ContactSolution) -> dict[str, Any]:
    """Some steps of the last cycle at some nodes across the contact, and the numbers of the
    cycle.
    """
    cycle = answer.last_cycle
    steps = cycle[np.linspace(0, len(cycle) - 1, SOLVER_STEPS).astype(int)]
    half = float(np.nanmax(answer.contact_half_width))
    nodes = [
        int(np.argmin(np.abs(answer.x - share * half)))
        for share in np.linspace(-1, 1, SOLVER_NODES)
    ]
    values = {name: getattr(answer, name)[np.ix_(steps, nodes)] for name in GRIDS}
    values |= {
        name: getattr(answer, name)[steps]
        for name in (*SERIES, "time", "normal_load", "tangential_load")
    }
    values |= {"x": answer.x[nodes], "dissipation_density": answer.dissipation_density[nodes]}
    values |= {
        "dissipation": answer.dissipation,
        "cycle_dissipation": answer.cycle_dissipation,
        "loop_work": answer.loop_work,
    }
    return plain(
        values
        | {
            "permanent_stick_half_width": answer.permanent_stick_half_width,
            "steps": len(answer.time),
        }
    )


# ---------------------------------------------------------------------------------- comparison.json
def comparison_values(name: str, folder: Path) -> dict[str, Any]:
    """Metric to value, unit and verdict out of the comparison.json of a run: the one place that
    knows its layout.
    """
    result = finite_elements(name)
    reference = semi_analytic.solve(result.scene, x=result.x, time=result.time)
    reports.write(reports.compare(reference=reference, result=result), folder)
    content = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    return {
        key: [one["value"], one["unit"], one["accurate"]] for key, one in content["metrics"].items()
    }


# ---------------------------------------------------------------------------------------- agreement
def plain(values: Any) -> Any:
    """Arrays as lists, every NaN as None."""
    if isinstance(values, dict):
        return {name: plain(value) for name, value in values.items()}
    if isinstance(values, np.ndarray):
        return plain(values.tolist())
    if isinstance(values, list | tuple):
        return [plain(value) for value in values]
    return None if isinstance(values, float) and math.isnan(values) else values


def differences(
    kept: Any, now: Any, allowed: Callable[[str], float], rounding: float = 0.0
) -> Iterator[str]:
    """A line for each value that is further from the frozen one than `allowed(name)` of the largest
    of its field, or `rounding`.
    """
    if missing := set(kept) - set(now):
        yield f"missing: {', '.join(sorted(missing))}"
    for name in sorted(set(kept) & set(now)):
        before, after = (np.array(_flat(value), dtype=object) for value in (kept[name], now[name]))
        if len(before) != len(after):
            yield f"{name}: {len(after)} values, frozen are {len(before)}"
            continue
        numbers = np.array(
            [
                isinstance(a, float | int) and isinstance(b, float | int)
                for a, b in zip(before, after, strict=True)
            ],
            dtype=bool,
        )
        other = [k for k in np.flatnonzero(~numbers) if before[k] != after[k]]
        if other:
            yield f"{name}[{other[0]}]: {after[other[0]]!r}, frozen is {before[other[0]]!r}"
        old, new = before[numbers].astype(float), after[numbers].astype(float)
        finite = np.isfinite(old) & np.isfinite(new)
        if np.any(~finite & (old != new)):
            yield f"{name}: not finite where it was, or the other way round"
        old, new = old[finite], new[finite]
        if len(old):
            size = float(np.max(np.abs(old)))
            worst = int(np.argmax(np.abs(new - old)))
            apart = abs(new[worst] - old[worst])
            if apart > max(allowed(name) * size, rounding):
                share = apart / size if size else apart
                values = f"{new[worst]!r}, frozen is {old[worst]!r}"
                yield (
                    f"{name}: {values}; apart by {share:.1e} of the largest, allowed"
                    f" {allowed(name):.1e}"
                )


def _flat(value: Any) -> list[Any]:
    return (
        [entry for part in value for entry in _flat(part)] if isinstance(value, list) else [value]
    )


# ------------------------------------------------------------------------------------------- freeze
def main(kinds: list[str]) -> None:
    """Write the frozen files: python contract_values.py half_plane finite_elements comparison.

    Of half-plane theory only scenes that the file has not: its values never change. Delete a row to
    make it again.
    """
    import tempfile

    if "half_plane" in kinds:
        drawn, made = contract_scenes.drawn(), contract_scenes.functions()
        table = frozen("half_plane")
        for name in (*contract_scenes.library(), *drawn, *made):
            if name in table:
                continue
            scene = (
                Scene.model_validate_json(json.dumps({"name": name} | drawn[name]))
                if name in drawn
                else made.get(name) or scene_cases.scene_of(name)
            )
            kept: dict[str, Any] = {"scene": drawn[name]} if name in drawn else {}
            refused = refusal(scene)
            if refused:
                kept["refused"] = refused
            else:
                x, time = places_and_instants(scene)
                kept |= (
                    {"reference": reference(scene)}
                    | {"x": x, "time": time}
                    | half_plane(scene, x, time)
                )
            table[name] = kept
            print(name, flush=True)
        _store("half_plane", table)
    if "finite_elements" in kinds:
        _store(
            "finite_elements", {name: fe_values(finite_elements(name)) for name in FINITE_ELEMENTS}
        )
    if "comparison" in kinds:
        with tempfile.TemporaryDirectory() as folder:
            _store(
                "comparison",
                {name: comparison_values(name, Path(folder) / name) for name in COMPARED},
            )


def _store(name: str, table: dict[str, Any]) -> None:
    """One line a value, so that a change shows what moved."""
    lines = []
    for key, kept in table.items():
        inner = ",\n  ".join(
            f"{json.dumps(k)}: {json.dumps(v)}" for k, v in kept.items() if k != "values"
        )
        if "values" in kept:
            values = ",\n   ".join(
                f"{json.dumps(k)}: {json.dumps(v)}" for k, v in kept["values"].items()
            )
            inner = f'{inner},\n  "values": {{\n   {values}}}'
        lines.append(f"{json.dumps(key)}: {{\n  {inner}}}")
    (HERE / f"{name}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
