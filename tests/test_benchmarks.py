"""The benchmarks themselves: the regression table, blame for planted faults, random mutants, the page of performance."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from reports.comparison.budget import Budget, Term
from reports.comparison.metrics import METRICS, Metric
from scenes import Friction, HarmonicLoad, Hertz, Scene, TimeSeriesLoad, freeze, load_scene
from semi_analytic import load_series
from semi_analytic.fields import Integrals
from semi_analytic.hertz import HertzContact

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def tool(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], ModuleType]:
    """A module of the benchmarks by its name."""
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return import_module


@pytest.fixture
def regress(tool: Callable[[str], ModuleType]) -> ModuleType:
    return tool("regress")


# -------------------------------------------------- the regression table: complete, good now, and able to fail in either column
def stored() -> dict[str, dict]:
    return json.loads((BENCHMARKS / "regress.json").read_text(encoding="utf-8"))


def test_every_scene_of_the_library_is_in_the_table_and_good(regress: ModuleType) -> None:
    lines = regress.lines(stored())
    assert {line.scene for line in lines} == set(regress.NAMES)
    # Each scene's dissipation has a 30-digit reference, of somebody else's making; W(x) where the table says so.
    assert {line.scene for line in lines if line.quantity == "dissipation" and line.reference is not None} == set(regress.NAMES)
    assert {line.scene for line in lines if line.quantity.startswith("density")} == set(regress.POINTWISE)
    # Each field is frozen in each scene, and has a reference in the Hertz scenes with friction that are no rows.
    known = {scene.name for scene in map(load_scene, regress.NAMES) if has_field_references(scene)}
    for field in regress.FIELDS:
        assert {line.scene for line in lines if line.quantity == field} == set(regress.NAMES)
        assert {line.scene for line in lines if line.quantity == field and line.reference is not None} == known
    assert len(known) >= 20
    # Other processors round otherwise: the table itself asks for less than this test.
    assert not [line for line in lines if line.drift is None or line.drift > 1e-11 or (line.error or 0.0) > 1e-12]


def has_field_references(scene: Scene) -> bool:
    return scene.profile.kind == "hertz" and scene.friction.coefficient > 0 and scene.load.kind != "time_series"


def hertz(name: str) -> Callable[[pytest.MonkeyPatch], None]:
    """A closed form of Hertz' contact by a hundredth."""
    right = getattr(HertzContact, name)
    return lambda patch: patch.setattr(HertzContact, name, lambda *asked: 1.01 * right(*asked))


def a_later_edge(patch: pytest.MonkeyPatch) -> None:
    """P - P_c by a thousandth too large."""
    follow = load_series.follow

    def wrong(*asked):
        block = follow(*asked)
        slipped, after = 1.001 * block.records.slipped, 1.001 * block.records.slipped_after
        return block._replace(records=block.records._replace(slipped=slipped, slipped_after=after))

    patch.setattr(load_series, "follow", wrong)


def an_arc(patch: pytest.MonkeyPatch, kernel: str) -> None:
    """The part that an arc of the memory curve has in a field, by a hundredth."""
    right = Integrals._curved
    patch.setattr(
        Integrals, "_curved", lambda self, edges: [part * (1.01 if self.kernel == kernel else 1.0) for part in right(self, edges)]
    )


def a_field(patch: pytest.MonkeyPatch, name: str) -> None:
    """A field of the answer as a whole."""
    right = semi_analytic.solve
    patch.setattr(semi_analytic, "solve", lambda *asked, **named: scaled(right(*asked, **named), name))


def scaled(answer, name):
    values = getattr(answer, name)
    return answer if values is None else dataclasses.replace(answer, **{name: freeze(1.01 * values)})


# fault: (how, scene, quantities that move with it)
FAULTS = {
    "moment of the slip kernel": (hertz("slip_integral_moment"), "hertz-paper", ["slip at 3"]),
    "slip kernel": (hertz("slip_integral"), "cattaneo-mindlin", ["slip at 3", "rms slip"]),
    "moment of the pressure": (hertz("pressure_moment"), "hertz-paper", ["shear at 1"]),
    "moment of the log": (hertz("log_moment"), "hertz-paper", ["tangential displacement"]),
    "log of the distance": (hertz("log_distance"), "unload-reload", ["tangential displacement", "rms displacement"]),
    "stick edge": (a_later_edge, "unload-reload", ["stick half-width"]),
    "shear of an arc": (partial(an_arc, kernel="shear"), "hertz-paper", ["rms shear"]),
    "slip of an arc": (partial(an_arc, kernel="slip"), "hertz-paper", ["rms slip"]),
    "slip as a whole": (partial(a_field, name="slip"), "hertz-paper", ["slip at 3", "rms slip"]),
    "shear as a whole": (partial(a_field, name="shear"), "flat-rounded-paper", ["shear at 2", "rms shear"]),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_field_that_is_wrong_by_a_hundredth_is_seen(regress: ModuleType, monkeypatch: pytest.MonkeyPatch, fault: str) -> None:
    """The dissipation moves with none of these; a value that has a reference leaves that too."""
    plant, scene, quantities = FAULTS[fault]
    plant(monkeypatch)
    monkeypatch.setattr(regress, "NAMES", (scene,))
    lines = {line.quantity: line for line in regress.lines(stored())}
    assert fault == "stick edge" or lines["dissipation"].drift < 1e-11
    for quantity in quantities:
        assert lines[quantity].drift > 1e-6
        assert lines[quantity].error is None or lines[quantity].error > 1e-6
        assert not lines[quantity].good


def test_each_column_sees_its_own_fault_only(regress: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regress, "NAMES", ("hertz-paper",))
    table = stored()
    frozen = table["hertz-paper"]["frozen"]
    frozen["dissipation"] *= 1 + 1e-10
    drifted = {line.quantity: line for line in regress.lines(table)}["dissipation"]
    assert not drifted.good
    assert drifted.error < 1e-13
    assert drifted.drift == pytest.approx(1e-10, rel=1e-3)
    table = stored()
    table["hertz-paper"]["reference"] = "0.0020575001840"
    wrong = {line.quantity: line for line in regress.lines(table)}["dissipation"]
    assert not wrong.good
    assert wrong.drift == pytest.approx(0.0, abs=1e-11)
    assert wrong.error > 1e-11


@pytest.mark.slow
def test_the_reference_of_a_time_series_sees_the_physics(regress: ModuleType) -> None:
    """Brute force in extended precision, on the same scene and on two that are 1e-9 beside it."""
    regress.mp.mp.dps = 20
    scene = load_scene("time-series")
    exact = regress.mp.mpf(stored()["time-series"]["reference"])
    assert abs(regress.truth(scene) / exact - 1) < 1e-15
    rows = [(t, p, q * (1 + 1e-9)) for t, p, q in scene.load.series().tolist()]
    for beside in ({"friction": scene.friction.coefficient * (1 + 1e-9)}, {"load": TimeSeriesLoad(rows=rows)}):
        assert abs(regress.truth(scene.vary(**beside)) / exact - 1) > 1e-10


def test_references_evaluated_again_are_those_that_are_stored(regress: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    """They have 30 digits and stay; a wrong one is replaced, and so is none that is no number."""
    table, names = stored(), ["harmonics", "near-sliding", "full-stick"]
    monkeypatch.setattr(regress, "write", lambda _: None)
    regress.references(names, table)
    assert table == stored()
    table["harmonics"]["density"][1] = table["harmonics"]["fields"]["references"][0] = "1e-3"
    regress.references(names[:1], table)
    again = table["harmonics"]["density"] + table["harmonics"]["fields"]["references"]
    right = stored()["harmonics"]["density"] + stored()["harmonics"]["fields"]["references"]
    assert list(map(float, again)) == pytest.approx(list(map(float, right)), rel=1e-14, abs=0)
    with pytest.raises(ArithmeticError, match="no number: nan"):
        regress.renewed(["1.0"], ["nan"])


@pytest.mark.parametrize("row", json.loads((BENCHMARKS / "semi_analytic_reference.json").read_text("utf-8"))[:41:20])
def test_the_table_of_ellipses_has_its_digits_by_two_routes(regress: ModuleType, row: dict) -> None:
    """W in closed phases of slip, to 28 digits; W(x) by brute force. Of the extremes W takes 90 digits and minutes."""
    truth, half_plane = (import_module(name) for name in ("regress_truth", "half_plane"))
    case = truth.Case(*(row[name] for name in truth.Case._fields))
    with regress.mp.workdps(38):
        assert abs(truth.ellipse_dissipation(case) / regress.mp.mpf(row["dissipation"]) - 1) < 1e-28
    exact = list(map(float, row["density"]))
    found = truth.density_truth(half_plane.scene_of(row), row["x"])
    assert list(map(float, found)) == pytest.approx(exact, rel=0, abs=1e-14 * max(exact))


@pytest.mark.parametrize(("name", "within"), [pytest.param("square wave", 1e-6, marks=pytest.mark.slow), ("near sliding", 1e-13)])
def test_the_harmonics_of_the_other_table_are_repeated_by_brute_force(regress: ModuleType, name: str, within: float) -> None:
    """W(x) to 1e-12. W of the square wave converges slowly: the stick edge has ripples at no corner of the path."""
    truth, half_plane = (import_module(name) for name in ("regress_truth", "half_plane"))
    case = json.loads(truth.NASTY_FILE.read_text("utf-8"))[name]
    means = dict(zip(("mean_normal_load", "mean_tangential_load"), case["mean"], strict=True))
    load = HarmonicLoad(**means, normal_harmonics=case["normal"], tangential_harmonics=case["tangential"])
    friction = Friction(coefficient=case["friction"])
    scene = Scene(name=name, material=half_plane.like(1.0), profile=Hertz(radius=1.0), friction=friction, load=load)
    assert float(regress.truth(scene)) == pytest.approx(float(case["dissipation"]), rel=within, abs=0)
    exact = list(map(float, case["density"]))
    assert list(map(float, truth.density_truth(scene, case["x"]))) == pytest.approx(exact, rel=0, abs=1e-12 * max(exact))


def test_a_scene_that_is_new_is_not_good_until_it_is_accepted(regress: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(regress, "NAMES", ("full-stick",))
    assert not any(line.good for line in regress.lines({}))


# ----------------------------- faults planted in either engine: seen by a metric, and the right term of the error budget blamed
@pytest.fixture
def blame(tool: Callable[[str], ModuleType]) -> ModuleType:
    return tool("covered")


def found(blame: ModuleType, value: float, *terms: Term) -> Any:
    one = Budget(Metric(definition=METRICS["dissipation"], value=value), terms, half_planes=True)
    return blame.Found({"dissipation": value, blame.STEP: 0.0}, {"dissipation": one})


def mesh(value: float | None, uncertainty: float) -> Term:
    return Term("mesh", value, uncertainty, "planted")


SOLVER, LOUD = (Term("solver", None, size, "planted", bound=True) for size in (1e-12, 0.5))
HEALTHY = (1e-3, mesh(0.9e-3, 0.2e-3), SOLVER)
# value and terms, and what is blamed: what is large, and the model only beyond doubt; within its band a metric sees nothing.
BLAMED = [
    (HEALTHY, None),
    ((1.1e-3, mesh(1e-3, 0.2e-3), SOLVER), None),
    ((1e-2, mesh(1e-3, 0.2e-3), SOLVER), "model"),
    ((1e-2, mesh(0.9e-2, 2e-3), SOLVER), "mesh"),
    ((1e-2, mesh(None, 2e-2), SOLVER), "mesh"),
    ((1e-2, mesh(1e-3, 0.2e-3), LOUD), "solver"),
]


@pytest.mark.parametrize(("faulty", "blamed"), BLAMED)
def test_blamed_is_what_is_large_and_steps_are_a_metric_by_themselves(blame: ModuleType, faulty: Any, blamed: str | None) -> None:
    bad, good = found(blame, *faulty), found(blame, *HEALTHY)
    assert list(blame.seen(bad, good)) == (["dissipation"] if blamed else [])
    assert blamed is None or bad.blamed("dissipation") == blamed
    long = blame.Found({blame.STEP: -1e-2}, {})
    assert blame.seen(long, blame.Found({blame.STEP: -1e-4}, {})) == {blame.STEP: pytest.approx(50.0)}
    assert long.blamed(blame.STEP) == "step"


@pytest.mark.slow
def test_every_planted_fault_is_seen_and_blamed_on_the_right_term(blame: ModuleType) -> None:
    rows = list(blame.blame())
    assert len(rows) == 1 + len(blame.FAULTS)
    assert [row.what for row in rows if row.met is not True] == []


# ---------------------------------------------------- random mutants: other programs that compile, drawn again by the same seed
SOURCE = '''"""A module of six lines that operators fit."""
LIMIT: float = 2.0


def half(a, load):
    """3.0 in a text and in a message are left alone."""
    if load[0] < LIMIT:
        raise ValueError(f"{3.0 * LIMIT} is too small")
    return -a[1] + 0.5 * load[-1]
'''
MUTANTS = {
    ("constant x 1.01", "2.0", "(2.0 * 1.01)"),
    ("neighbouring index", "0", "1"),
    ("comparison", "load[0] < LIMIT", "(load[0] >= LIMIT)"),
    ("sign", "-a[1]", "(a[1])"),
    ("neighbouring index", "1", "2"),
    ("sign", "-a[1] + 0.5 * load[-1]", "(-a[1] - 0.5 * load[-1])"),
    ("dropped term", "-a[1] + 0.5 * load[-1]", "(-a[1])"),
    ("constant x 1.01", "0.5", "(0.5 * 1.01)"),
    ("dropped term", "0.5 * load[-1]", "(0.5)"),
    ("neighbouring index", "-1", "-2"),
}


@pytest.fixture
def mutants(tool: Callable[[str], ModuleType]) -> ModuleType:
    return tool("mutants")


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Two engines of one module each; only the first has a test, of one of its lines."""
    for engine in ("semi_analytic", "halfplane_fe"):
        (tmp_path / engine).mkdir()
        (tmp_path / engine / "part.py").write_text(SOURCE, encoding="utf-8")
    return tmp_path


def test_every_operator_fits_where_it_should_and_nowhere_else(mutants: ModuleType, tree: Path) -> None:
    found, executable = mutants.places(tree)
    rows = [row for rows in found.values() for row in rows if row["file"].startswith("semi_analytic")]
    assert {(row["operator"], mutants.cut(SOURCE, row["span"])[1], row["after"]) for row in rows} == MUTANTS
    assert len(found) == 2 * 3 < executable
    for row in rows:
        changed = mutants.mutated(SOURCE, row)
        compile(changed, row["file"], "exec")
        assert changed != SOURCE
        assert row["after"] in changed
    # The same seed draws the same, and more are added at the end.
    assert mutants.draw(found, 3, 1, tree) == mutants.draw(found, 6, 1, tree)[:3]
    assert mutants.draw(found, 6, 1, tree) != mutants.draw(found, 6, 2, tree)


@pytest.mark.parametrize(("code", "verdict"), [(0, "survived"), (1, "killed"), (None, "timeout")])
def test_a_verdict_is_what_the_tests_say_and_the_original_comes_back(
    mutants: ModuleType, tree: Path, monkeypatch: pytest.MonkeyPatch, code: int | None, verdict: str
) -> None:
    seen = []

    def run(stage: str, engine: str, place: Path, processes: int, limit: float | None) -> tuple[int | None, str]:
        changed = (place / engine / "part.py").read_text(encoding="utf-8") != SOURCE
        seen.append((stage, changed))
        return (code, "a test") if changed else (0, "")

    monkeypatch.setattr(mutants, "run_tests", run)
    row = mutants.draw(mutants.places(tree)[0], 1, 1, tree)[0]
    assert mutants.judge(row, ["contract", "engine"], tree, 1, {})["verdict"] == verdict
    assert (tree / row["file"]).read_text(encoding="utf-8") == SOURCE
    # The unchanged tree first, for the limit of time, then the mutant; the engine's own tests only if the contract lets it pass.
    assert seen == [("contract", False), ("contract", True), *([("engine", False), ("engine", True)] if code == 0 else [])]
    monkeypatch.setattr(mutants, "run_tests", lambda *_: (1, "tests/test_a.py::test_b"))
    with pytest.raises(SystemExit, match="the unchanged tree fails the stage 'contract'"):
        mutants.judge(row, ["contract"], tree, 1, {})


def test_equivalent_mutants_leave_the_count_only_with_a_reason(mutants: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    row = {"file": "a.py", "line": 1, "operator": "sign", "before": "a", "after": "(b)", "stages": ["contract"]}
    rows = [row | {"verdict": "killed"}, row | {"verdict": "survived"}, row | {"verdict": "timeout", "before": "c"}]
    assert "2 of 3 killed (67 %), 1 of them stopped" in mutants.report(rows)
    monkeypatch.setattr(mutants, "equivalents", lambda: {("a.py", "a", "(b)"): "rounds the same"})
    assert "1 equivalent, 2 of 2 killed" in mutants.report(rows)
    assert all(reason.strip() for reason in mutants.equivalents().values())


# ----------------------------------------------- the page of performance: its judges are right, what it switches off comes back
def test_peers_are_judged_by_closed_forms_that_theory_meets(tool: Callable[[str], ModuleType]) -> None:
    peers, models = tool("peers"), tool("finite_elements")
    scene = models.cattaneo_mindlin((0.6,))
    x = np.linspace(-1.2, 1.2, 241)
    theory = semi_analytic.solve(scene, x=x, time=[2.0], fields=("pressure", "shear"))
    pressure, shear = peers.closed_form(scene, x)
    # Measured 5e-14 and 4e-14 MPa of 58 and 18.
    assert np.abs(theory.pressure[0] - pressure).max() <= 1e-12
    assert np.abs(theory.shear[0] - shear).max() <= 1e-12
    exact = peers.judged_answer(peers.Answer(x, pressure, shear, 1.0), scene)
    tenth = peers.judged_answer(peers.Answer(x, 1.1 * pressure, 0.9 * shear, 1.0), scene)
    assert exact["p"] == exact["q"] == 0
    assert [tenth[key] for key in ("p", "q", "peak")] == pytest.approx([0.1] * 3)


def test_lines_by_hand_are_counted_in_each_code_and_the_page_says_what_its_files_hold(tool: Callable[[str], ModuleType]) -> None:
    found = tool("peers").lines_by_hand()
    assert found.keys() == {"tamaas", "contactmechanics", "getfem", "kratos", "naive", "ours", "calculix"}
    assert (found["tamaas"], found["contactmechanics"]) == (8, 6)
    performance = tool("performance")
    assert performance.PAGE.read_text(encoding="utf-8") == performance.page_text()


def test_a_rival_is_no_worse_in_time_and_error_and_better_in_one(tool: Callable[[str], ModuleType]) -> None:
    performance = tool("performance")
    default = {"text": "default", "seconds": 1.0, "work": 1.0, "shear": None, "loop": 1.0}
    for seconds, error, rivals in ((0.5, 0.5, 1), (0.7, 1.0, 1), (1.0, 0.7, 1), (0.9, 0.9, 0), (0.1, 1.1, 0), (2.0, 0.1, 0)):
        other = {"text": "other", "seconds": seconds, "work": error, "shear": None, "loop": 1.2}
        found = {"series": {"named settings": [default], "else": [other]}}
        assert len(performance.better(found, default, ["work", "shear"])) == rivals
        assert performance.better(found, default, ["work", "shear", "loop"]) == []


def test_what_is_switched_off_is_off_and_comes_back(tool: Callable[[str], ModuleType]) -> None:
    performance = tool("performance")
    scene, mesh = load_scene("full-stick"), MeshSettings.coarse()
    normal = halfplane_fe.solve(scene, mesh)
    with performance.whole_faces():
        whole = halfplane_fe.solve(scene, mesh)
    with performance.factors_anew():
        anew = halfplane_fe.solve(scene, mesh)
    again = halfplane_fe.solve(scene, mesh)
    assert ["contact nodes" in one.work.skipped for one in (normal, whole, again)] == [True, False, True]
    for answer in (whole, anew):
        # Round-off: measured 2e-13 of the largest pressure with whole faces, 0 with new factors.
        assert np.abs(answer.pressure - normal.pressure).max() <= 1e-11 * normal.pressure.max()
    own = semi_analytic.solve(scene)
    with performance.every_point():
        apart = semi_analytic.solve(scene)
    assert apart.work.counts["points_evaluated"] == 2 * own.work.counts["points_evaluated"]
    assert np.array_equal(apart.pressure, own.pressure)
