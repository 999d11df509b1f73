"""What the contract measures of an answer: values of the table of cases (`case_table`), by run,
quantity and points.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import case_table
import contract_scenes
import numpy as np

import halfplane_fe
import reports
import scene_cases
import semi_analytic
from meshes import MeshSettings
from reports.comparison.datum import effects_between
from scenes import ContactSolution, InadmissibleLoadError, InputError, Scene

Values = dict[case_table.Key, Any]
FIELDS = ("pressure", "shear", "slip")
SERIES = ("tangential_displacement", "normal_approach", "contact_half_width", "stick_half_width")
GRID, REFUSAL, STATED = "grid", "refusal", "stated error of "
SOLVER_NODES, SOLVER_STEPS = 9, 8

# Half-plane scenes of `make test`, a few of each sort; `make contract` has all.
QUICK = (
    "cattaneo-mindlin",
    "hertz-paper",
    "flat-rounded-paper",
    "harmonics",
    "time-series",
    "unload-reload",
    "tiny-slip",
    "short-flat, ellipse",
    "power-3.5, ellipse",
    "compound, polygon",
    "table, polygon",
    "rows 1500, repeated",
    "nowell-hills",
    "line of action",
    "slip of 1e-9",
    "P to 1e-9",
    "metres and pascals",
    "separates",
    "slides",
    "slides on a line",
)
COARSE, COMPARED = "coarse elements", "coarse comparison"
# Numbers of a whole path, and what else has one value a scene.
OF_PATH = ("cycle_dissipation", "dissipation", "loop_work", "permanent_stick_half_width")
OF_SCENE = (*OF_PATH, "steady_from", "events", "batch", "batch_stick_load", "batch_peak", REFUSAL)


@cache
def scenes_of(run: str) -> tuple[str, ...]:
    """The scenes that the contract has baselines of, by this run."""
    sheets = map(case_table.sheet, case_table.scenes())
    if run == case_table.THEORY:
        return tuple(one.scene for one in sheets if is_of_contract(one))
    return tuple(one.scene for one in sheets if one.baselines(run))


def is_of_contract(known: case_table.Sheet) -> bool:
    """Whether a sheet has half-plane theory on a grid, or its refusal."""
    refused = (case_table.THEORY, REFUSAL, "") in known.baselines(case_table.THEORY)
    return GRID in known.points or refused


def contract_baselines(known: case_table.Sheet) -> dict[case_table.Key, case_table.Case]:
    """The baselines of half-plane theory that `half_plane` must give."""
    baselines = known.baselines(case_table.THEORY)
    on_grid = {quantity for _, quantity, at in baselines if at == GRID}
    return {
        key: case
        for key, case in baselines.items()
        if case.at == GRID
        or (not case.at and case.quantity in OF_SCENE and case.quantity not in on_grid)
        or case.quantity.startswith(STATED)
    }


def scene_of(name: str) -> Scene:
    """A scene of the contract: of a file, with its keys in the table of cases, or made of Python
    functions.
    """
    if name in contract_scenes.library():
        return scene_cases.scene_of(name)
    made = contract_scenes.functions()
    if name in made:
        return made[name]
    keys = case_table.sheet(name).keys
    return Scene.model_validate_json(json.dumps({"name": name, **keys}))


# -------------------------------------------------------------------------------- half-plane theory
def half_plane(scene: Scene, points: dict[str, Any]) -> Values:
    """Every value of one scene on the grid of its points, or that its path is refused."""
    if GRID not in points:
        return {(case_table.THEORY, REFUSAL, ""): refusal(scene)}
    answer = semi_analytic.solve(scene, x=points[GRID]["x"], time=points[GRID]["time"])
    on_grid = {
        name: getattr(answer, name) for name in (*FIELDS, *SERIES, "state", "dissipation_density")
    }
    of_path: dict[str, Any] = {name: getattr(answer, name) for name in OF_PATH}
    if "grids" in answer.work.counts:  # the fineness of grids follows the points
        on_grid |= of_path
        of_path = {}
    of_path["steady_from"] = answer.steady_from
    of_path["events"] = [
        [one.letter, one.time, one.normal_load, one.tangential_load, one.front_load]
        for one in events_of(scene)
    ]
    if scene.load.kind == "ellipse" and not scene.unsymmetric:
        of_path |= _batch(scene)
    stated = {
        f"{STATED}{name}": answer.record.errors.get(name)
        for name in ("pressure at the edge", "shear at the edge")
    }
    of_path |= {name: error for name, error in stated.items() if error}
    values = {(case_table.THEORY, name, GRID): value for name, value in on_grid.items()}
    values |= {(case_table.THEORY, name, ""): value for name, value in of_path.items()}
    return case_table.plain(values)


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
        "phase_radians": load.phase_radians,
    }
    work = semi_analytic.dissipation(profile=scene.profile, material=scene.material, **given)
    peak = semi_analytic.peak_dissipation(profile=scene.profile, material=scene.material, **given)
    return {
        "batch": float(work.value),
        "batch_stick_load": float(work.permanent_stick_load),
        "batch_peak": float(peak.value),
    }


def refusal(scene: Scene) -> list[Any] | None:
    """Instant and loads at which a path is refused, None where it is not."""
    try:
        semi_analytic.solve(scene, x=[0.0])
    except InadmissibleLoadError as reason:
        kind = "separation" if str(reason).startswith("separation") else "gross sliding"
        return [kind, reason.time, reason.normal_load, reason.tangential_load]
    return None


# ------------------------------------------------------------------------------ the finite elements
@cache
def finite_elements(name: str) -> ContactSolution:
    """The answer on the coarse mesh."""
    return halfplane_fe.solve(scene_cases.scene_of(name), mesh=MeshSettings.coarse())


def coarse_values(answer: ContactSolution) -> Values:
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
    values = {name: getattr(answer, name)[np.ix_(steps, nodes)] for name in FIELDS}
    values |= {
        name: getattr(answer, name)[steps]
        for name in (*SERIES, "time", "normal_load", "tangential_load")
    }
    values |= {"x": answer.x[nodes], "dissipation_density": answer.dissipation_density[nodes]}
    values |= {name: getattr(answer, name) for name in OF_PATH}
    values["steps"] = len(answer.time)
    return case_table.plain({(COARSE, name, ""): value for name, value in values.items()})


# --------------------------------------------------------------------------------- the comparison
def comparison_metrics(name: str, folder: Path) -> dict[str, dict[str, Any]]:
    """Metric to value, unit and verdict out of the comparison.json of a run: the one place that
    knows its layout.
    """
    result = finite_elements(name)
    reference = semi_analytic.solve(result.scene, x=result.x, time=result.time)
    comparison = reports.compare(
        reference=reference, result=result, effects=effects_between(reference, result)
    )
    reports.write(comparison, folder)
    content = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    return {
        key: {column: metric[column] for column in ("value", "unit", "accurate")}
        for key, metric in content["metrics"].items()
    }
