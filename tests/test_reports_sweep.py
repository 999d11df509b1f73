"""Sweeps: studies refused in sentences, points and figures that are a study's, losses; in processes
of their own and on dask.
"""

import errno
import importlib.util
import json
import math
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Future
from functools import partial
from itertools import pairwise, product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape

import semi_analytic
from command_line import ROOT, raising, start
from faulty import copy_the_code
from halfplane_fe import SolverSettings, interface
from halfplane_fe import solve as solve_fe
from halfplane_fe.condensed_bodies import CondensedBodies
from meshes import MeshSettings
from refusals import refused_for, require_facts
from reports.charts.plate import panel_stacks_of
from reports.cli import main
from reports.comparison import compare
from reports.studies.sweep import running, solving
from reports.studies.sweep.page import draw_figures, sweep_state, table_in_words, write_page
from reports.studies.sweep.running import Processes, prepare, run, worker_pool
from reports.studies.sweep.solving import code_versions, solve_task
from reports.studies.sweep.store import (
    STATUS_COLUMNS,
    PlannedPoint,
    Store,
    StoreError,
    read_index,
    solved_rows_of,
)
from reports.studies.sweep.study import (
    Axis,
    Study,
    grid_points,
    load_study,
    points_of_study,
    study_of,
    value_of_expression,
)
from scenes import ConvergenceError, InputError, load_scene
from scenes.files import source_digest
from semi_analytic.elasticity import composite_modulus

F = {"name": "f", "key": "friction.coefficient"}
PAPER = {
    "scene": "hertz-paper",
    "engines": ["exact"],
    "figures": ["exact.dissipation"],
    "axes": [F | {"values": [1.0, 2.0]}],
}
COARSE = {
    "mesh.element_size": 0.25,
    "mesh.edge_element_size": 0.125,
    "mesh.order": 1,
    "mesh.growth": 1.0,
}
BLOCKS = {
    "scene": "blocks",
    "engines": ["fe", "exact"],
    "set": COARSE | {"solver.steps_per_cycle": 12},
}
BLOCKS_FE = {"scene": "blocks", "engines": ["fe"], "figures": ["fe.dissipation"]}
WORK_ALONE = {"figures": ["fe.dissipation"]}


SPAN = {"start": 1, "stop": 2, "count": 300}
# a quarter of the time of hertz-paper
SEVEN = {"scene": "cattaneo-mindlin", "axes": [F | {"linear": {"start": 1, "stop": 2, "count": 7}}]}


def study(**changes: Any) -> Study:
    """Half-plane theory on hertz-paper over two frictions, changed."""
    return study_of(PAPER | changes, "study.toml")


def blocks(**changes: Any) -> Study:
    return study(**BLOCKS | changes)


# ------------------------------------------------------------------------------------------ studies


def axis(**keys: Any) -> Axis:
    return Axis.model_validate_json(json.dumps({"name": "a"} | keys))


def test_values_of_axes() -> None:
    steps = [
        point["a"] for point in axis(logarithmic={"start": 2, "stop": 32, "count": 5}).points()
    ]
    assert steps == pytest.approx([2, 4, 8, 16, 32], rel=1e-15)
    product = grid_points([axis(values=[1, 2]), axis(name="b", values=["x", "y"])])
    assert [tuple(point.values()) for point in product] == [(1, "x"), (1, "y"), (2, "x"), (2, "y")]
    pairs = axis(name="", names=["base", "sides"], pairs=[["fixed", "free"], ["rollers", "guided"]])
    assert list(grid_points([pairs])) == [
        {"base": "fixed", "sides": "free"},
        {"base": "rollers", "sides": "guided"},
    ]


REFUSED_ARITHMETIC = (
    *(
        "__import__('os')",
        "a.real",
        "[1]",
        "1 if a else 2",
        "b",
        "1/0",
        "10**400",
        "sqrt(-1)",
        "lambda: 1",
        "a if",
        "'x'",
    ),
    *("9**9**9**9", "a" * 501, "c", "True", "(-1)**0.5"),
)


@pytest.mark.parametrize("text", REFUSED_ARITHMETIC)
def test_arithmetic_and_nothing_else(text: str) -> None:
    assert value_of_expression("-2**2 + sqrt(a)*max(1, b)/4", {"a": 16.0, "b": 3}) == pytest.approx(
        -1.0
    )
    with pytest.raises(InputError):
        value_of_expression(text, {"a": 1.0, "c": "word"})


def moved(key: str, *values: Any) -> dict[str, Any]:
    """Changes of a study: one axis, over the values of a key."""
    return {"axes": [{"name": "f", "key": key, "values": list(values)}]}


# Every point is checked before anything starts.
@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"axess": []}, ["unknown key axess"]),
        # `engine` is a key of the scene's tables
        ({"engine": ["fe"]}, ["unknown key engine", "engines?"]),
        ({"samples": 3}, ["unknown key samples"]),
        ({"axes": [F]}, ["exactly one of"]),
        ({"axes": [{"name": "f", "values": [1.0]}]}, ["moves nothing"]),
        ({"axes": [{"names": ["f", "n"], "keys": ["cycles"], "pairs": [[1, 2]]}]}, ["pairs"]),
        ({"figures": ["error.dissipation"]}, ["error.dissipation", "needs engines"]),
        ({"figures": ["exact.nothing"]}, ["exact.nothing", "is none"]),
        ({"figures": ["exact.dissipation", "exact.dissipation"]}, ["figures", "twice"]),
        ({"uncertainty": "cheap"}, ["exact to rounding"]),
        (
            BLOCKS | {"uncertainty": "budget", "figures": ["error.p0"]},
            ["error.p0", "is no metric"],
        ),
        ({"scene": "hertz-papr"}, ["hertz-papr"]),
        ({"set": {"friction.coefficient": 1.0}}, ["friction.coefficient", "given twice"]),
        ({"axes": [F | {"logarithmic": {"start": 0, "stop": 1, "count": 2}}]}, ["start > 0"]),
        (moved("friction.coefficient", 1.0, 0.1), ["point 1 (f = 0.1)", "gross sliding"]),
        (moved("friction.coefficient", 1.0, -1.0), ["point 1 (f = -1)", "friction.coefficient"]),
        (moved("friction.coefficient", 1.0, 1), ["point 1", "the same as point 0"]),
        (moved("friktion.coefficient", 1.0), ["no friktion", "friction"]),
        (moved("friction.coeff", 1.0), ["friction.coeff = 1.0", "coefficient?"]),
        (moved("profile.radius", "x"), ["profile.radius = 'x'", "number"]),
        (moved("mesh.size", 1.0), ["mesh.size", "no such setting"]),
        (moved("mesh.element_size", 7.0), ["element_size = 7.0"]),
        (moved("solver.steps_per_cycle", 7.5), ["whole number"]),
        (
            BLOCKS_FE | moved("bodies.lower.base", "fixed", "rollers"),
            ["nothing holds the block"],
        ),
    ],
)
def test_a_wrong_study_is_refused(changes: dict[str, Any], facts: list[str]) -> None:
    with refused_for(*facts):
        points_of_study(study(**changes))


def test_a_study_file_finds_its_scene_beside_it_and_comes_back_from_its_own_json(
    tmp_path: Path,
) -> None:
    (tmp_path / "own.json").write_text(
        load_scene("hertz-paper").model_dump_json(), encoding="utf-8"
    )
    pairs = {
        "names": ["f", "n"],
        "keys": ["friction.coefficient", "cycles"],
        "pairs": [[1.0, 3], [2.0, 4]],
    }
    (tmp_path / "study.json").write_text(
        json.dumps(PAPER | {"scene": "own.json", "axes": [pairs]}), encoding="utf-8"
    )
    loaded = load_study(tmp_path / "study.json")
    assert loaded.scene.profile == load_scene("hertz-paper").profile
    assert study_of(json.loads(loaded.model_dump_json()), "again") == loaded


def test_axes_set_and_derived_reach_the_scene_and_the_settings() -> None:
    axes = [
        {"name": "r", "values": [500.0]},
        {"name": "n", "key": "solver.steps_per_cycle", "values": [48]},
    ]
    derived = {"k": "1000/r", "profile.radius": "r", "load.mean_normal_load": "90*k"}
    settings = {"mesh.element_size": 0.1, "load.initial_loading": "straight"}
    [point] = points_of_study(
        study(
            **BLOCKS_FE | {"scene": "hertz-paper"},
            axes=axes,
            set=settings,
            derived=derived,
            preset="coarse",
        )
    )
    assert point.question.scene.profile == load_scene("hertz-paper").profile.vary(radius=500.0)
    load = point.question.scene.load.model_dump()
    assert (load["mean_normal_load"], load["initial_loading"]) == (180.0, "straight")
    assert (
        point.question.mesh.element_size,
        point.question.mesh.growth,
        point.question.solver.steps_per_cycle,
    ) == (0.1, 0.5, 48)


def test_a_key_of_one_material_is_that_of_both_bodies() -> None:
    axes = [{"key": "material.young_modulus", "values": [7e4]}]
    [point] = points_of_study(study(axes=axes, set={"material.poisson_ratio": 0.2}))
    material = point.question.scene.material
    assert (material.upper.young_modulus, material.lower.young_modulus) == (7e4, 7e4)
    assert (material.upper.poisson_ratio, material.lower.poisson_ratio) == (0.2, 0.2)
    with refused_for("material.lower.young_module"):
        points_of_study(study(axes=[axes[0] | {"key": "material.young_module"}]))


def test_an_address_is_of_what_numbers_depend_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def address(**changes: Any) -> str:
        return points_of_study(study(**changes))[0].address

    plain = address()
    of_both = partial(address, engines=["exact", "fe"])
    assert plain == address(title="other", set={"title": "other", "tolerances.shear": 1.0})
    assert plain == address(set={"mesh.element_size": 0.1})  # theory alone has no mesh
    changed = [
        address(figures=["exact.peak_pressure"]),
        address(set={"load.mean_tangential_load": 1.0}),
        of_both(),
        of_both(set={"mesh.element_size": 0.1}),
        of_both(share_condensations=False),
    ]
    monkeypatch.setattr("reports.studies.sweep.solving.code_versions", lambda: {"code": "other"})
    assert len({plain, *changed, address()}) == 7


def test_whatever_numbers_depend_on_is_in_the_address(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engines, and what a process loads of `reports` that works as a worker does; that each
    line counts is the store's test.
    """
    words = "import sys, reports.studies.sweep.solving, reports.comparison.budget\n"
    words += "print(*(name for name in sys.modules if name.startswith('reports.')))"
    process = subprocess.run(
        [sys.executable, "-c", words], capture_output=True, text=True, check=True, cwd=ROOT
    )
    loaded = process.stdout.split()
    counted: list[str] = []
    monkeypatch.setattr(
        solving, "source_digest", lambda *names: "".join(counted.extend(names) or ())
    )
    code_versions.__wrapped__()
    needed = {"scenes", "semi_analytic", "meshes", "halfplane_fe", *loaded} - {
        "reports.studies",
        "reports.studies.sweep",
    }
    assert {
        "reports.comparison.metrics",
        "reports.comparison.budget",
        "reports.studies.sweep.solving",
    } <= needed
    parts = tuple(f"{name}." for name in counted)
    assert not [name for name in needed if not f"{name}.".startswith(parts)]


@pytest.mark.parametrize("name", ["reports.gone", "gone", "reports.studies.sweep.gone"])
def test_a_module_that_is_missing_has_no_digest(name: str) -> None:
    with refused_for(name, "lacks the module's source file"):
        source_digest(name)


# ------------------------------------------------------------------------------- figures of a point


def task(of: Study, **changes: Any) -> str:
    points = [point.question.as_json() for point in points_of_study(of)]
    return json.dumps({"versions": code_versions(), "points": points} | changes)


def answers(of: Study) -> list[dict[str, Any]]:
    answered: list[dict[str, Any]] = json.loads(solve_task(task(of)))["answers"]
    return answered


RIG = BLOCKS | {"scene": "rig-blocks", "axes": [F | {"values": [0.5, 0.6]}]}


def test_the_finite_elements_of_a_rig_are_swept() -> None:
    """Figures at the mean load are there at P0 of the rig, though its answer states found loads."""
    figures = ["fe.dissipation", "error.dissipation", "exact.dissipation", "exact.p0", "fe.p0"]
    scene = load_scene("rig-blocks")
    modulus = composite_modulus(scene.material)
    mean_load = scene.load.model_dump()["mean_normal_load"]
    radius = scene.profile.model_dump()["radius"]
    # The blocks change it by 4e-3; at the largest P it is 15 % more.
    peak_of_half_planes = math.sqrt(mean_load * modulus / (math.pi * radius))
    for answer in answers(study(**RIG, figures=figures, uncertainty="cheap")):
        assert answer["status"] == "done", answer["reason"]
        values = answer["figures"]
        work, of_theory = values["fe.dissipation"], values["exact.dissipation"]
        assert math.isclose(values["error.dissipation"], work / of_theory - 1, rel_tol=1e-12)
        assert abs(work / of_theory - 1) < values["error.dissipation.uncertainty"] < 1
        assert math.isclose(values["exact.p0"], peak_of_half_planes, rel_tol=6e-3)


def test_what_is_not_known_of_a_rig_is_refused_in_a_sentence() -> None:
    with refused_for("stick_edge", "each finds loads of its own", "error. before"):
        points_of_study(study(**RIG, figures=["stick_edge"]))


def test_the_approach_of_a_rig_leaves_nothing_to_share() -> None:
    [answer] = answers(
        study(**RIG | {"scene": "rig-cylinders", "axes": [F | {"values": [0.5]}]}, **WORK_ALONE)
    )
    assert answer["status"] == "done", answer["reason"]
    assert "follows from the approach" in answer["notes"][""]


def test_the_figures_are_those_of_the_engines() -> None:
    """Also what theory neglects of unlike bodies is noted beside them."""
    names = [
        "error.dissipation",
        "fe.peak_pressure",
        "exact.permanent_stick_half_width",
        "stick_edge",
    ]
    unlike = F | {"key": "material.lower.young_modulus", "values": [7e4]}
    [answer] = answers(blocks(axes=[unlike], figures=names, share_condensations=False))
    scene = load_scene("blocks")
    scene = scene.vary(
        material=scene.material.vary(lower=scene.material.lower.vary(young_modulus=7e4))
    )
    mesh = MeshSettings(element_size=0.25, edge_element_size=0.125, order=1, growth=1.0)
    fe = solve_fe(scene, mesh, SolverSettings(steps_per_cycle=12))
    exact = semi_analytic.solve(scene, x=fe.x, time=fe.time)
    assert answer["figures"] == {
        "error.dissipation": fe.dissipation / exact.dissipation - 1,
        "fe.peak_pressure": float(fe.pressure[fe.last_cycle].max()),
        "exact.permanent_stick_half_width": exact.permanent_stick_half_width,
        "stick_edge": compare(exact, fe).metric("stick_edge").value,
    }
    assert answer["record"]["converged"]
    assert [
        note
        for note in answer["record"]["notes"]
        if note.startswith("half-plane theory: Dundurs' beta = -0.14")
    ]


def test_points_that_share_their_bodies_condense_them_once_and_answer_as_if_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(interface, "BODY_CACHE", CondensedBodies(10**9))
    variant = partial(blocks, figures=["fe.dissipation", "error.permanent_stick_half_width"])
    solving._scales_of.cache_clear()
    three = variant(axes=[F | {"values": [0.9, 1.5, 3.0]}])
    middle = variant(axes=[F | {"values": [1.5]}])
    together = answers(three)
    assert solving._scales_of.cache_info().misses == 1  # and one coarse run for all
    assert [answer["record"]["counts"]["condensations"] for answer in together] == [1, 0, 0]
    [alone] = answers(middle)
    assert together[1]["figures"] == alone["figures"]
    assert points_of_study(three)[1].address == points_of_study(middle)[0].address
    [with_its_own_mesh] = answers(variant(axes=[F | {"values": [1.5]}], share_condensations=False))
    # The coarse run of the group dissipates nothing: what a point states of its W must not come
    # from it.
    assert any(
        "no uncertainty estimate: its bodies are shared" in note
        for note in alone["record"]["notes"]
    )
    assert not any("uncertain by" in note for note in alone["record"]["notes"])
    # Another mesh of the same size: coarse, so a few per cent.
    assert alone["figures"]["fe.dissipation"] == pytest.approx(
        with_its_own_mesh["figures"]["fe.dissipation"], rel=0.03
    )


def test_a_cheap_uncertainty_covers_the_error_of_half_planes() -> None:
    """Between half-planes the error is that of the mesh, the steps and the far field: known, for
    theory has none.
    """
    names = ["error.dissipation", "error.p0", "error.contact_half_width", "exact.dissipation"]
    settings = {"uncertainty": "cheap", "preset": "coarse", "set": {"solver.steps_per_cycle": 48}}
    for answer in answers(study(engines=["fe", "exact"], figures=names, **settings)):
        assert "exact.dissipation.uncertainty" not in answer["figures"]
        for name in names[:3]:
            assert 0 < abs(answer["figures"][name]) <= answer["figures"][f"{name}.uncertainty"], (
                name
            )


# Constant P and bulk in phase with Q: W of Cattaneo and Mindlin and 2 R em^2 Qm/f for the amplitude
# em of the bulk strain.
PULLED: dict[str, Any] = {
    "material": {"young_modulus": 2.0, "poisson_ratio": 0.0},
    "profile": {"kind": "hertz", "radius": 1.0},
    "friction": 1.0,
    "load": {
        "kind": "ellipse",
        "mean_normal_load": 3.0,
        "tangential_amplitude": 1.8,
        "phase_degrees": 90.0,
        "initial_loading": [[3.0, 0.0]],
        "bulk_stress_lower": {"amplitude": 0.0, "phase_degrees": 90.0, "initial_loading": [0.0]},
    },
}
CONSTANT = PULLED | {
    "load": {"kind": "polygon", "initial_loading": [[3.0, 0.0], [3.0, 1.8]], "cycle": [[3.0, -1.8]]}
}


@pytest.mark.parametrize(
    ("scene", "key", "values", "works"),
    [
        (
            PULLED,
            "load.bulk_stress_lower.amplitude",
            [0.2, 0.6],
            [0.6128781396315213 + 0.036, 0.9368781396315213],
        ),
        (
            PULLED | {"load": PULLED["load"] | {"bulk_stress_lower": None}},
            "load.tilt",
            [0.0],
            [0.6128781396315213],
        ),
        (CONSTANT, "load.tilt", [0.0, 0.1], [0.6128781396315213] * 2),
    ],
    ids=["amplitude", "tilt of an ellipse", "tilt of a polygon"],
)
def test_a_sweep_goes_over_bulk_stress_and_tilt(
    scene: dict[str, Any], key: str, values: list[float], works: list[float]
) -> None:
    keys = {
        "scene": scene,
        "axes": [{"name": "s", "key": key, "values": values}],
        "engines": ["exact"],
    }
    answered = answers(study_of(keys | {"figures": ["exact.dissipation"]}, "here"))
    assert {answer["reason"] for answer in answered} == {""}
    assert [answer["figures"]["exact.dissipation"] for answer in answered] == pytest.approx(
        works, rel=1e-9
    )


def test_a_point_without_a_figure_says_why_and_one_that_fails_has_its_record(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # |Q| = f P at the ends of the cycle: the stick zone has just closed.
    scene = load_scene("cattaneo-mindlin")
    load, shear = next(corner for corner in scene.load.model_dump()["cycle"] if corner[1])
    at_the_limit = F | {"values": [abs(shear) / load]}
    [answer] = answers(
        study(
            figures=["exact.permanent_stick_half_width"],
            axes=[at_the_limit],
            scene="cattaneo-mindlin",
        )
    )
    assert answer["figures"] == {"exact.permanent_stick_half_width": None}
    assert "there is none" in answer["notes"]["exact.permanent_stick_half_width"]
    partial_solution = semi_analytic.solve(scene)

    fault = ConvergenceError("residual 0.3 after 100 iterations", partial_solution)
    monkeypatch.setattr(solving, "_solve_finite_elements", raising(fault))
    [answer] = answers(blocks(axes=[F | {"values": [1.0]}], figures=["fe.dissipation"]))
    assert (answer["status"], answer["figures"]) == ("failed", {})
    assert answer["reason"] == "not converged: residual 0.3 after 100 iterations"
    assert answer["record"]["steps"] == len(partial_solution.time)


# -------------------------------------------------------------------------- the loop and its losses


class Bench(Processes):
    """Works at once, in this process; `fault` sees the frictions of a task and may let its worker
    die.

    With `at_once` the pool is found broken as a task is handed out.
    """

    def __init__(
        self,
        fault: Callable[[list[float]], BaseException | None] = lambda _frictions: None,
        *,
        at_once: bool = False,
    ) -> None:
        super().__init__(2)
        self.fault = fault
        self.at_once = at_once
        self.started = 0
        self.handed: list[list[float]] = []
        self.executor = self  # type: ignore[assignment]

    def start(self) -> None:
        self.started += 1

    def stop(self, *, at_once: bool) -> None:
        pass

    def submit(self, _solve: object, text: str) -> "Future[str]":
        frictions = [
            point["scene"]["friction"]["coefficient"] for point in json.loads(text)["points"]
        ]
        self.handed.append(frictions)
        future: Future[str] = Future()
        fault = self.fault(frictions)
        if fault is None:
            future.set_result(solve_task(text))
        elif self.at_once:
            raise fault
        else:
            future.set_exception(fault)
        return future


Sweep = Callable[..., pd.DataFrame]


@pytest.fixture
def sweep(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Sweep:
    """Runs seven points into `out`, by a pool."""

    def go(pool: Bench | None = None, folder: str = "out", **changes: Any) -> pd.DataFrame:
        monkeypatch.setattr(running, "worker_pool", lambda **_: pool or Bench())
        return run(study(**SEVEN | changes), tmp_path / folder)

    return go


def values(folder: Path) -> dict[float, float]:
    """Friction -> dissipation of every row; a point that is there twice fails."""
    table = solved_rows_of(read_index(folder))
    assert table["address"].is_unique
    return dict(zip(table["f"].tolist(), table["exact.dissipation"].tolist(), strict=True))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of a sweep that nothing happened to: each result is that of its point."""
    folder = tmp_path_factory.mktemp("truth") / "truth"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(running, "worker_pool", lambda **_: Bench())
        run(study(**SEVEN), folder)
    assert len(values(folder)) == 7
    for friction, work in values(folder).items():
        scene = load_scene("cattaneo-mindlin").vary(friction=friction)
        assert (
            work
            == semi_analytic.solve(
                scene, cycles="steady", x=[0.0], fields="dissipation"
            ).dissipation
        )
    return folder


@pytest.fixture
def truth(tmp_path: Path, undisturbed: Path) -> dict[float, float]:
    """What a sweep must find in the end; its store is copied to `truth`."""
    shutil.copytree(undisturbed, tmp_path / "truth")
    return values(undisturbed)


def dying(
    at: float,
    times: int,
    fault: Callable[[], BaseException] = BrokenExecutor,
    *,
    at_once: bool = False,
) -> Bench:
    deaths = iter([True] * times)
    return Bench(
        lambda frictions: fault() if at in frictions and next(deaths, False) else None,
        at_once=at_once,
    )


@pytest.mark.parametrize("fault", [BrokenExecutor, CancelledError])
def test_a_worker_that_dies_costs_its_own_points_which_are_named_and_solved_by_the_next_run(
    fault: Callable[[], BaseException], tmp_path: Path, truth: dict[float, float], sweep: Sweep
) -> None:
    """However often it dies with them: the others have their results."""
    for _ in range(3):
        with refused_for("a worker died", "without a result: f = 1.5", "others are stored"):
            sweep(dying(1.5, 99, fault))
        assert values(tmp_path / "out") == {f: w for f, w in truth.items() if f != 1.5}
    # and no row says that it failed
    assert read_index(tmp_path / "out")["status"].tolist() == ["done"] * 6
    pool = Bench()
    sweep(pool)
    assert (values(tmp_path / "out"), pool.handed) == (truth, [[1.5]])


@pytest.mark.parametrize("deaths", [3, 99])
def test_a_pool_that_is_found_broken_is_replaced_three_times(
    deaths: int, tmp_path: Path, truth: dict[float, float], sweep: Sweep
) -> None:
    """More deaths in a row are those of a script without a guard: its workers end as they start."""
    pool = dying(1.5, deaths, at_once=True)
    if deaths > 3:
        with refused_for("4 pools of workers died", "__main__"):
            sweep(pool)
    else:
        sweep(pool)
        assert values(tmp_path / "out") == truth
    assert pool.started == 4


def test_what_can_not_go_on_ends_in_a_sentence(
    tmp_path: Path, sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(OSError, match="no such fault"):  # what is nobody's death passes through
        sweep(dying(1.0, 1, partial(OSError, "no such fault")))
    monkeypatch.setattr(solving, "code_versions", lambda: {"code": "other"})
    with refused_for("code is", "here and other there"):
        sweep(folder="mixed")
    assert Store(tmp_path / "mixed").addresses() == set()


def test_a_rerun_resumes(tmp_path: Path, truth: dict[float, float], sweep: Sweep) -> None:
    """After an interrupt, and with more values on an axis."""
    with pytest.raises(KeyboardInterrupt):
        sweep(dying(2.0, 1, KeyboardInterrupt))
    assert (tmp_path / "out" / "index.csv").exists()
    before = values(tmp_path / "out")
    assert 0 < len(before) < 7
    pool = Bench()
    sweep(pool)
    assert sum(map(len, pool.handed)) == 7 - len(before)
    idle = Bench()
    sweep(idle)
    assert idle.handed == []
    assert values(tmp_path / "out") == truth
    wider = Bench()
    sweep(wider, axes=[F | {"linear": {"start": 1, "stop": 2, "count": 13}}])
    assert sum(map(len, wider.handed)) == 6
    assert truth.items() <= values(tmp_path / "out").items()


def test_a_failed_point_is_a_row_with_its_reason(
    sweep: Sweep, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = solving.evaluate

    def evaluate(point: Any, fe: Any) -> Any:
        if point.scene.friction.coefficient == 1.5:
            raise ArithmeticError("no root")
        return original(point, fe)

    monkeypatch.setattr(solving, "evaluate", evaluate)
    table = sweep()
    assert table["reason"][table["status"] == "failed"].tolist() == ["ArithmeticError: no root"]
    assert len(solved_rows_of(table)) == 6


def test_tasks_hold_each_point_once_and_leave_every_worker_some_until_the_end(
    tmp_path: Path,
) -> None:
    for of, most in (
        (blocks(**SEVEN | {"figures": ["fe.dissipation"]}), 4),
        (study(axes=[F | {"linear": SPAN}]), 50),
    ):
        for width in (1, 2, 100):
            prepared = prepare(of, tmp_path)
            handed = running.tasks_of(prepared, width)
            assert [point for part in handed for point in part] == list(prepared.points)
            assert len(handed) >= min(len(prepared.points), 4 * width - 3)
            assert max(map(len, handed)) <= most


DAMAGES: dict[str, Callable[[bytes, bytes], bytes]] = {
    "digit": lambda stored, _: re.sub(rb'("exact.dissipation": 0\.0*)\d', rb"\g<1>0", stored),
    "cut": lambda stored, _: stored[:200],
    "empty": lambda *_: b"",
    "binary": lambda *_: b"\xff\x00\xfe" * 50,
    "swapped": lambda _, neighbour: neighbour,
}


@pytest.mark.parametrize("how", DAMAGES)
def test_a_damaged_result_is_set_aside_and_made_again(
    how: str, tmp_path: Path, truth: dict[float, float], sweep: Sweep
) -> None:
    store = Store(tmp_path / "truth")
    first, second, *_ = (store.path(address) for address in sorted(store.addresses()))
    spoilt = DAMAGES[how](first.read_bytes(), second.read_bytes())
    assert spoilt != first.read_bytes()
    first.write_bytes(spoilt)
    assert (len(values(tmp_path / "truth")), len(store.damaged())) == (6, 1)
    pool = Bench()
    sweep(pool, folder="truth")
    assert (values(tmp_path / "truth"), sum(map(len, pool.handed))) == (truth, 1)


@pytest.mark.usefixtures("truth")
def test_a_result_that_can_not_be_read_is_a_sentence_and_stays(tmp_path: Path) -> None:
    """What is no damage is not made again over it: no right to read, a folder in its place."""
    store = Store(tmp_path / "truth")
    path = store.path(min(store.addresses()))
    path.unlink()
    path.mkdir()
    with refused_for(str(path), "Is a directory", error=StoreError):
        store.read(path.stem)
    assert path.is_dir()


@pytest.mark.parametrize(
    "number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG], ids=errno.errorcode.get
)
def test_a_full_disk_is_a_sentence_and_loses_nothing(
    number: int,
    tmp_path: Path,
    truth: dict[float, float],
    sweep: Sweep,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    real = os.fsync
    room = iter(range(4))  # the plan, then three results
    out = tmp_path / "out"
    (tmp_path / "study.json").write_text(json.dumps(PAPER | SEVEN), encoding="utf-8")

    def fsync(handle: int) -> None:
        if next(room, None) is None:
            raise OSError(number, os.strerror(number))
        real(handle)

    monkeypatch.setattr(running, "worker_pool", lambda **_: Bench())
    monkeypatch.setattr(os, "fsync", fsync)
    assert main(["sweep", str(tmp_path / "study.json"), "--out", str(out), "--quiet"]) == 2
    facts = ("no room left on the disk", "3 of 7 points are stored", "halfplane sweep")
    require_facts(capsys.readouterr().err, *facts)
    monkeypatch.setattr(os, "fsync", real)
    assert len(values(out)) == 3
    assert not list(out.rglob(".halfplane-*"))
    sweep()
    assert values(out) == truth


# ------------------------------------------------------------------------------------ how far it is


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """Three points done."""
    filled = Store(tmp_path / "out")
    filled.prepare()
    filled.write_plan(
        {"title": "t"},
        [PlannedPoint(number, f"{number:064x}", {"f": number}) for number in range(3)],
    )
    for number in range(3):
        filled.write(
            {
                "address": f"{number:064x}",
                "status": "done",
                "figures": {"W": 1.0},
                "seconds": 1.0,
                "reason": "",
            }
        )
    return filled


def test_time_left_is_that_of_the_points_that_wait_at_the_rate_of_the_last_ones(
    store: Store,
) -> None:
    assert sweep_state(store)["seconds_left"] is None  # nothing waits
    planned = [PlannedPoint(number, f"{number:064x}", {"f": number}) for number in range(8)]
    store.write_plan({"title": "t"}, planned)
    for number in range(3):
        os.utime(store.path(f"{number:064x}"), (0, 1000 + 10 * number))
    state = sweep_state(store)
    assert state["points"] == {"done": 3, "failed": 0, "waiting": 5, "total": 8}
    assert state["seconds_left"] == pytest.approx(5 * 10)


# ------------------------------------------------------------------------------- workers and Ctrl-C


@pytest.mark.parametrize(
    ("options", "facts"),
    [
        ({"scheduler": "tcp://node1:8786"}, ["--scheduler", "--executor dask"]),
        ({"workers": 0}, ["--workers 0", "at least 1"]),
    ],
)
def test_options_that_do_not_fit_are_refused(options: dict[str, Any], facts: list[str]) -> None:
    with refused_for(*facts):
        worker_pool(**options)


def test_workers_hear_no_ctrl_c_from_birth() -> None:
    """A terminal sends it to them too: one that came while they were born ended in their
    tracebacks.
    """
    pool = Processes(1)
    pool.start()
    try:
        assert signal.SIGINT in pool.executor.submit(
            signal.pthread_sigmask, signal.SIG_BLOCK, []
        ).result(600)
    finally:
        pool.stop(at_once=True)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def test_ctrl_c_in_a_round_ends_the_sweep_after_it_with_its_workers_gone(sweep: Sweep) -> None:
    """Raised amid the locks of a pool, it left one locked now and then: the program never ended."""
    stopped = []
    rounds = []

    class Busy(Bench):
        def start(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)  # while the workers are born
            rounds.append("born")

        def submit(self, _solve: object, text: str) -> "Future[str]":
            rounds.append("handed out")
            return Future()

        def stop(self, *, at_once: bool) -> None:
            os.kill(os.getpid(), signal.SIGINT)
            stopped.append(at_once)

    with pytest.raises(KeyboardInterrupt):
        sweep(Busy())
    assert (rounds, stopped) == (["born"], [True])


# --------------------------------------------------------------------------- pages, pictures, notes


def test_neglected_coupling_is_noted_in_store_table_and_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(running, "worker_pool", lambda **_: Bench())
    axes = [F | {"key": "material.lower.young_modulus", "values": [7e4, 210e3]}]
    (tmp_path / "study.json").write_text(json.dumps(PAPER | {"axes": axes}), encoding="utf-8")
    note = (
        "Dundurs' beta = -0.142857: the bodies are unlike, and the coupling of normal and shear"
        " tractions is neglected"
    )
    out = str(tmp_path / "out")
    assert main(["sweep", str(tmp_path / "study.json"), "--out", out, "--quiet"]) == 0
    assert f"note on 1 of 2 points: {note}" in " ".join(capsys.readouterr().out.split())
    assert read_index(out)["notes"].tolist() == [note, ""]
    assert f'"{note}"' in (tmp_path / "out" / "index.csv").read_text(encoding="utf-8")
    assert str(escape(note)) in write_page(Store(Path(out))).read_text(encoding="utf-8")
    assert main(["sweep", "status", out, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["result"]["notes"] == [{"note": note, "points": 1}]


def picture(x: Sequence[float], y: Sequence[float] = (), **keys: Any) -> str:
    """The SVG of the first panel of a figure over `x`, or over the product of `x` and `y`."""
    names = ("x", "y")[: 1 + bool(y)]
    points = [dict(zip(names, (a, b), strict=False)) for a in x for b in y or [0.0]]
    table = pd.DataFrame(
        [
            {"number": n, **point, "error.p0": 1.0 + n, "status": "done"}
            for n, point in enumerate(points)
        ]
    )
    axes = [axis(name="x", **keys or {"values": list(x)}), axis(name="y", values=[1.0])][
        : len(names)
    ]
    [drawn] = draw_figures(table, axes, load_scene("hertz-paper"))
    return panel_stacks_of(drawn)[0][0].__html__()


def ticks(svg: str, name: str) -> list[str]:
    """Labels of the ticks along x (`across`) or y (`upright`)."""
    return re.findall(rf'<text[^>]*class="tick {name}"[^>]*>([^<]+)</text>', svg)


def test_a_map_has_a_coloured_cell_for_each_value_and_ticks_at_the_values_of_the_study() -> None:
    svg = picture([0.4, 0.6, 0.8], [0.3, 0.6, 0.9])
    assert len(re.findall(r'<rect[^>]*fill="#[0-9a-f]{6}"[^>]*data-label="[^"]*: \d+ %"', svg)) == 9
    numbers = re.findall(r'text-anchor="middle" dy="4">([^<]+)</text>', svg)
    assert numbers == [str(100 * (1 + n)) for n in range(9)]  # per cent
    assert (ticks(svg, "across"), ticks(svg, "upright")) == (
        ["0.4", "0.6", "0.8"],
        ["0.3", "0.6", "0.9"],
    )
    factors = picture([1.0, 4.0, 16.0, 64.0], logarithmic={"start": 1.0, "stop": 64.0, "count": 4})
    assert ticks(factors, "across") == ["1", "4", "16", "64"]
    for values in ([0.1, 0.11, 1.0, 5.0], [float(n) for n in range(1, 20)]):  # too near, too many
        labels = [float(tick) for tick in ticks(picture(values, [1.0, 2.0]), "across")]
        assert len(labels) > 2
        assert max(abs(b - a - labels[1] + labels[0]) for a, b in pairwise(labels)) < 1e-9


def test_of_two_axes_there_is_a_line_with_bars_along_each() -> None:
    table = pd.DataFrame(
        [
            {"number": n, "x": x, "y": y, "error.p0": x * y, "error.p0.uncertainty": 0.1}
            for n, (x, y) in enumerate(product([1.0, 2.0, 3.0], [1.0, 2.0]))
        ]
    ).assign(status="done")
    axes = [axis(name="x", values=[1.0, 2.0, 3.0]), axis(name="y", values=[1.0, 2.0], unit="mm")]
    [drawn] = draw_figures(table, axes, load_scene("hertz-paper"))
    _, along_x, along_y = panel_stacks_of(drawn)
    of_x = along_x[0].__html__()
    of_y = along_y[0].__html__()
    assert (of_x.count("bar-line"), of_y.count("bar-line")) == (2, 3)
    assert all(f">y = {number}<" in of_x for number in (1, 2))
    assert all(f">x = {number}<" in of_y for number in (1, 2, 3))
    heads, rows = table_in_words(table.assign(seconds=1.0), axes, load_scene("hertz-paper"))
    assert heads[1:3] == ["x", "y [mm]"]
    assert rows[3][3] == "400 ± 10"  # per cent


def test_values_that_differ_by_round_off_have_numbers_of_their_own_beside_the_axis() -> None:
    table = pd.DataFrame(
        [
            {"number": n, "x": x, "error.p0": 2.22446e-5 * (1 + 1e-8 * n), "status": "done"}
            for n, x in enumerate([1.0, 2.0, 3.0])
        ]
    )
    axes = [axis(name="x", values=[1.0, 2.0, 3.0])]
    [drawn] = draw_figures(table, axes, load_scene("hertz-paper"))
    labels = ticks(panel_stacks_of(drawn)[0][0].__html__(), "upright")
    assert len(labels) == len(set(labels)) > 1
    assert max(len(label) for label in labels) <= 9


def test_an_axis_without_a_name_has_that_of_its_key() -> None:
    assert Axis(key="friction.coefficient", values=(0.5,)).columns == ("friction_coefficient",)
    with pytest.raises(ValueError, match="an axis has a name"):
        Axis(values=(0.5,))


def test_an_axis_of_pairs_has_no_name_of_its_own() -> None:
    axis_of_pairs = {"names": ("a", "b"), "pairs": ((1, 2), (3, 4))}
    assert Axis(**axis_of_pairs).columns == ("a", "b")
    with pytest.raises(ValueError, match="names head their columns; leave name out"):
        Axis(**axis_of_pairs, name="zzz")
    # One key would take the values of the first column alone, without a word.
    with pytest.raises(ValueError, match="one key for each of names; leave key out"):
        Axis(**axis_of_pairs, key="load.mean_normal_load")


# ---------------------------------------------------------------------- killed, starved and doubled
needs_dask = pytest.mark.skipif(
    not importlib.util.find_spec("distributed"), reason="distributed is missing: halfplane[cluster]"
)
POINTS = 500
STUDY = f"""scene = "hertz-paper"\nengines = ["exact"]
figures = ["exact.dissipation", "exact.peak_dissipation"]
[[axes]]\nname = "f"\nkey = "friction.coefficient"
linear = {{start = 1.0, stop = 2.0, count = {POINTS}}}\n"""
LIGHT = STUDY.replace("hertz-paper", "cattaneo-mindlin")  # a quarter of the time
BLOCKS_FILE = """scene = "blocks"\nfigures = ["error.dissipation", "stick_edge"]
[set]\n"mesh.element_size" = 0.25\n"mesh.edge_element_size" = 0.125
"mesh.order" = 1\n"mesh.growth" = 1.0
"solver.steps_per_cycle" = 24\n[[axes]]\nname = "f"\nkey = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 8}
"""


def sweeping(
    home: Path, *words: str, session: bool = False, **environment: str
) -> subprocess.Popen[str]:
    return start(
        home, "sweep", *words, session=session, PYTHONPATH=str(home / "code"), **environment
    )


def finish(client: subprocess.Popen[str], code: int = 0) -> tuple[str, str]:
    out, err = client.communicate(timeout=3600)
    assert client.returncode == code, err
    assert "Traceback" not in err
    return out, err


def children(pid: int) -> list[int]:
    """Workers of a client: processes below it that were spawned."""
    psutil = importlib.import_module("psutil")
    return [
        process.pid
        for process in psutil.Process(pid).children()
        if "spawn_main" in " ".join(process.cmdline())
    ]


def until(true: Callable[[], bool], client: subprocess.Popen[str]) -> None:
    end = time.monotonic() + 1800
    while not true():
        assert client.poll() is None, client.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)


def results(folder: Path) -> int:
    return len(Store(folder).addresses())


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the studies are, with the stores `true-...` of undisturbed sweeps."""
    home = tmp_path_factory.mktemp("sweeps")
    copy_the_code(home / "code")
    for name, text in (("study", STUDY), ("light", LIGHT), ("blocks", BLOCKS_FILE)):
        (home / f"{name}.toml").write_text(text, encoding="utf-8")
        finish(sweeping(home, f"{name}.toml", "--out", f"true-{name}"))
    return home


def same(home: Path, name: str, study: str = "study") -> None:
    """All points are there, once, with the figures of the undisturbed sweep, in the results and in
    index.csv.
    """
    columns = [name for name in read_index(home / name).columns if name not in STATUS_COLUMNS]
    rows, true_rows = (
        solved_rows_of(read_index(home / folder))[columns].values.tolist()
        for folder in (name, f"true-{study}")
    )
    assert len(columns) == 4
    assert rows == true_rows
    assert len(rows) == (8 if study == "blocks" else POINTS)
    lines = (home / name / "index.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[0] for line in lines[1:]] == [
        str(number) for number in range(len(true_rows))
    ]
    assert Store(home / name).damaged() == []


@pytest.mark.slow
def test_nine_interruptions_of_500_points(home: Path) -> None:
    """Killed, by Ctrl-C, by a batch system: workers end too, what is stored stays, and the last run
    ends with the truth.
    """
    store = home / "nine"
    chance = random.Random(19)
    before = 0
    for how in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM) * 3:
        client = sweeping(home, "study.toml", "--out", "nine", "--workers", "2")
        enough = before + chance.randrange(10, 40)
        until(lambda enough=enough: results(store) >= enough, client)  # type: ignore[misc]
        workers = children(client.pid)
        assert workers
        client.send_signal(how)
        _, err = finish(client, -how if how == signal.SIGKILL else 128 + how)
        end = time.monotonic() + 600
        # they notice that their client is gone
        while any(Path(f"/proc/{pid}").exists() for pid in workers):
            assert how == signal.SIGKILL
            assert time.monotonic() < end
            time.sleep(0.1)
        if how != signal.SIGKILL:
            assert f"halfplane sweep study.toml --workers 2 --out {store.name}" in err
        assert before < results(store) < POINTS
        before = results(store)
    out, _ = finish(sweeping(home, "study.toml", "--out", "nine"))
    assert f"{before} points have results already" in out
    same(home, "nine")


@pytest.mark.slow
def test_a_worker_killed_in_mid_point_loses_nothing(home: Path) -> None:
    client = sweeping(home, "blocks.toml", "--out", "worker", "--workers", "2")
    until(lambda: results(home / "worker") >= 1, client)
    os.kill(children(client.pid)[0], signal.SIGKILL)
    assert "a worker died (killed, or out of memory)" in finish(client, code=2)[1]
    finish(sweeping(home, "blocks.toml", "--out", "worker", "--workers", "2"))
    same(home, "worker", "blocks")


class Cluster:
    """`dask scheduler` and two `dask worker`, as a batch system would keep them; with TLS where
    `tls` has its options.
    """

    def __init__(self, home: Path, tls: tuple[str, ...] = ()) -> None:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = str(probe.getsockname()[1])
        self.home = home
        self.tls = tls
        self.address = f"{'tls' if tls else 'tcp'}://127.0.0.1:{self.port}"
        self.scheduler = self.schedule()
        self.workers = [self.work() for _ in range(2)]

    def begin(self, program: str, *words: str) -> subprocess.Popen[str]:
        return start(
            self.home,
            *words,
            *self.tls,
            "--no-dashboard",
            program=("-m", f"distributed.cli.{program}"),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            PYTHONPATH=str(self.home / "code"),
            OPENBLAS_NUM_THREADS="1",
        )

    def schedule(self) -> subprocess.Popen[str]:
        protocol = ("--protocol", "tls") if self.tls else ()
        return self.begin("dask_scheduler", "--host", "127.0.0.1", "--port", self.port, *protocol)

    def work(self) -> subprocess.Popen[str]:
        return self.begin("dask_worker", self.address, "--nthreads", "1", "--no-nanny")

    def client(
        self, out: str, study: str = "light.toml", **environment: str
    ) -> subprocess.Popen[str]:
        return sweeping(
            self.home,
            study,
            "--out",
            out,
            "--executor",
            "dask",
            "--scheduler",
            self.address,
            **environment,
        )

    def tended(self, client: subprocess.Popen[str]) -> tuple[str, str]:
        """What the client prints; workers that end with their scheduler begin again meanwhile."""
        end = time.monotonic() + 600
        while client.poll() is None and time.monotonic() < end:
            self.workers = [
                self.work() if worker.poll() is not None else worker for worker in self.workers
            ]
            time.sleep(0.5)
        return finish(client)

    def end(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(home: Path) -> Iterator[Cluster]:
    running_cluster = Cluster(home)
    yield running_cluster
    running_cluster.end()


@pytest.mark.slow
@needs_dask
@pytest.mark.parametrize("killed", ["scheduler", "worker"])
def test_a_scheduler_or_a_worker_of_a_cluster_killed_loses_nothing(
    killed: str, cluster: Cluster
) -> None:
    """A scheduler that is gone ends the sweep in a sentence, and the next run resumes it."""
    client = cluster.client(killed)
    until(lambda: results(cluster.home / killed) >= 50, client)
    if killed == "worker":
        cluster.workers[0].kill()
    else:
        cluster.scheduler.kill()
        cluster.scheduler.wait()
        assert (
            "the scheduler is gone; see to it, then start the sweep again"
            in finish(client, code=2)[1]
        )
        assert 50 <= results(cluster.home / killed) < POINTS
        cluster.scheduler = cluster.schedule()
        client = cluster.client(killed)
    cluster.tended(client)
    same(cluster.home, killed, "light")


def listening(pid: int) -> set[str]:
    """Addresses that a process listens at."""
    psutil = importlib.import_module("psutil")  # there with distributed
    return {
        connection.laddr.ip
        for connection in psutil.Process(pid).net_connections("inet")
        if connection.status == psutil.CONN_LISTEN
    }


@pytest.mark.slow
@needs_dask
def test_a_cluster_without_an_address_is_of_this_machine_alone_and_outlives_a_worker_and_ctrl_c(
    home: Path,
) -> None:
    words = ("study.toml", "--out", "local", "--executor", "dask", "--workers", "2")
    client = sweeping(home, *words, session=True)
    until(lambda: results(home / "local") >= 50, client)
    workers = children(client.pid)
    assert {address for pid in (client.pid, *workers) for address in listening(pid)} == {
        "127.0.0.1"
    }
    os.kill(workers[0], signal.SIGKILL)
    until(lambda: results(home / "local") >= 150, client)
    os.killpg(client.pid, signal.SIGINT)  # as a terminal does, to all
    _, err = finish(client, 130)
    assert "resume with: halfplane sweep study.toml --executor dask" in err
    finish(sweeping(home, *words))
    same(home, "local")


@pytest.mark.slow
@needs_dask
def test_a_scheduler_with_tls_takes_our_certificate_and_nobody_without(home: Path) -> None:
    """And an address where nobody answers is a sentence."""
    make = [
        "openssl",
        "req",
        "-x509",
        "-newkey",
        "rsa:2048",
        "-nodes",
        "-days",
        "2",
        "-subj",
        "/CN=sweep",
    ]
    subprocess.run(
        [*make, "-keyout", home / "key.pem", "-out", home / "cert.pem"],
        check=True,
        capture_output=True,
    )
    tls = (
        "--tls-ca-file",
        str(home / "cert.pem"),
        "--tls-cert",
        str(home / "cert.pem"),
        "--tls-key",
        str(home / "key.pem"),
    )
    cluster = Cluster(home, tls)
    try:
        # of dask itself
        config = {"CA_FILE": "cert.pem", "CLIENT__CERT": "cert.pem", "CLIENT__KEY": "key.pem"}
        ours = {
            f"DASK_DISTRIBUTED__COMM__TLS__{name}": str(home / file)
            for name, file in config.items()
        }
        cluster.tended(cluster.client("tls", study="blocks.toml", **ours))
        same(home, "tls", "blocks")
        plain = ("--executor", "dask", "--scheduler", f"tcp://127.0.0.1:{cluster.port}")
        for where in (plain, (*plain[:-1], "tcp://127.0.0.1:9")):
            assert (
                "no dask scheduler answers there"
                in finish(sweeping(home, "study.toml", "--out", "none", *where), code=2)[1]
            )
    finally:
        cluster.end()


def test_an_edge_without_an_estimate_does_not_hide_that_of_the_other_one() -> None:
    """And a pressure peak, of which finite elements have such an attribute too, is no edge."""
    result = SimpleNamespace(
        time=np.array([0.0, 1.0]),
        stick_edge_uncertainty=np.array([[0.5, 0.5], [np.nan, 0.02]]),
        contact_edge_uncertainty=np.full((2, 2), np.nan),
        peak_pressure_uncertainty=np.array([1.0, 2.0]),
    )
    comparison = SimpleNamespace(result=result, scales=SimpleNamespace(half_width=2.0))
    stated = {
        key: solving._stated_uncertainty(
            SimpleNamespace(key=key, time=1.0, uncertainty=1e-3),  # type: ignore[arg-type]
            comparison,  # type: ignore[arg-type]
        )
        for key in ("stick_edge", "contact_edge", "peak_pressure", "dissipation")
    }
    assert stated == {
        "stick_edge": 0.01,
        "contact_edge": 1e-3,
        "peak_pressure": 1e-3,
        "dissipation": 1e-3,
    }


def test_an_instant_with_one_estimate_counts_in_the_uncertainty_of_a_half_width() -> None:
    """Of three instants the first has one estimate, the last none: the median is that of two."""
    solution = SimpleNamespace(
        last_cycle=np.arange(3),
        contact_edge_uncertainty=np.array([[np.nan, 0.5], [0.1, 0.2], [np.nan, np.nan]]),
    )
    uncertainty = solving._uncertainty_of_edges(
        "fe.contact_half_width",
        load_scene("hertz-paper"),
        solution,  # type: ignore[arg-type]
        None,
    )
    assert uncertainty == pytest.approx(0.35)


@needs_dask
def test_a_local_cluster_has_tls_of_its_own_and_no_dashboard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    distributed = importlib.import_module("distributed")
    options_of_dask: dict[str, Any] = {}

    def cluster(**options: Any) -> None:
        options_of_dask.update(
            options,
            routes=importlib.import_module("dask.config").get("distributed.scheduler.http.routes"),
        )
        raise OSError("enough")

    monkeypatch.setattr(distributed, "LocalCluster", cluster)
    for _ in range(2):
        with pytest.raises(InputError, match="enough"):
            worker_pool("dask", workers=1).start()
    security = options_of_dask["security"]
    assert security.require_encryption
    assert "BEGIN CERTIFICATE" in security.tls_scheduler_cert == security.tls_ca_file
    assert options_of_dask["host"] == "127.0.0.1"
    assert options_of_dask["scheduler_kwargs"] == {"dashboard": False}
    assert options_of_dask["routes"] == []
