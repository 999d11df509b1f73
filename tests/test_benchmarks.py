"""The benchmarks themselves: the regression table, blame for planted faults, pages of numbers and
performance.
"""

from __future__ import annotations

import dataclasses
import json
import sys
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

import semi_analytic
from reports.charts.templating import markdown_table
from reports.comparison.budget import Budget, Term
from reports.comparison.metrics import METRICS
from reports.page.writing import code_commit
from scenes import HarmonicLoad, TimeSeriesLoad, load_scene, read_only_copy, unit_words
from semi_analytic import load_series
from semi_analytic.fields import KernelIntegrals
from semi_analytic.hertz import HertzContact
from semi_analytic_cases import make_scene

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
ELLIPSES = json.loads((BENCHMARKS / "semi_analytic_reference.json").read_text("utf-8"))
Tool = Callable[[str], ModuleType]


@pytest.fixture(scope="module")
def tool() -> Iterator[Tool]:
    """A module of the benchmarks by its name; afterwards none of these short names shadows
    another.
    """
    before = set(sys.modules)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCHMARKS))
        yield import_module
    for name in set(sys.modules) - before:
        if str(BENCHMARKS) in str(getattr(sys.modules[name], "__file__", "")):
            del sys.modules[name]


@pytest.fixture
def regress(tool: Tool) -> ModuleType:
    return tool("regress")


@pytest.fixture
def cases(tool: Tool) -> ModuleType:
    return tool("cases")


# ------------------------ the table of cases: complete, good now, and able to fail in either column
def test_every_scene_of_the_library_is_in_the_table_and_good(
    cases: ModuleType, regress: ModuleType
) -> None:
    lines = list(cases.lines("regress"))
    names = set(regress.NAMES)

    def scenes(quantity: str, at: str = "", *, known: bool) -> set[str]:
        return {
            line.scene
            for line in lines
            if line.key[1:] == (quantity, at) and (line.references or not known)
        }

    # Each scene's dissipation has a reference, of somebody else's making; W(x) where the table says
    # so.
    assert scenes("dissipation", known=True) == {line.scene for line in lines} == names
    assert scenes("dissipation_density", "slip zone", known=True) == set(regress.POINTWISE)
    # Each field has a baseline in each scene, and a reference in the Hertz scenes with friction
    # that are no rows.
    known = {
        scene.name
        for scene in map(load_scene, names)
        if scene.profile.kind == "hertz"
        and scene.friction.coefficient > 0
        and scene.load.kind != "time_series"
    }
    assert len(known) >= 12
    for quantity, at, _ in regress.FIELDS:
        assert scenes(quantity, at, known=False) == names
        assert scenes(quantity, at, known=True) == known
    assert not [line for line in lines if not line.good]


def hertz(name: str) -> Callable[[pytest.MonkeyPatch], None]:
    """A closed form of Hertz' contact by a hundredth."""
    right = getattr(HertzContact, name)

    def plant(patch: pytest.MonkeyPatch) -> None:
        patch.setattr(HertzContact, name, lambda *arguments: 1.01 * right(*arguments))

    return plant


def a_later_edge(patch: pytest.MonkeyPatch) -> None:
    """P - P_c by a thousandth too large."""
    follow = load_series.follow

    def wrong(*arguments):
        block = follow(*arguments)
        slipped = 1.001 * block.records.slip_zone_load_at_begin
        after = 1.001 * block.records.slip_zone_load_at_end
        return block._replace(
            records=block.records._replace(
                slip_zone_load_at_begin=slipped, slip_zone_load_at_end=after
            )
        )

    patch.setattr(load_series, "follow", wrong)


def an_arc(patch: pytest.MonkeyPatch, kernel: str) -> None:
    """The part that an arc of the memory curve has in a field, by a hundredth."""
    right = KernelIntegrals._curved_integrals

    def wrong(self, edges):
        return [part * (1.01 if self.kernel == kernel else 1.0) for part in right(self, edges)]

    patch.setattr(KernelIntegrals, "_curved_integrals", wrong)


def a_field(patch: pytest.MonkeyPatch, name: str) -> None:
    """A field of the answer as a whole."""
    right = semi_analytic.solve

    def wrong(*arguments, **keywords):
        answer = right(*arguments, **keywords)
        values = getattr(answer, name)
        return (
            answer
            if values is None
            else dataclasses.replace(answer, **{name: read_only_copy(1.01 * values)})
        )

    patch.setattr(semi_analytic, "solve", wrong)


# fault: (how, scene, quantities that move with it)
FAULTS = {
    "moment of the slip kernel": (
        hertz("slip_integral_moment"),
        "hertz-paper",
        ["slip at slipping place"],
    ),
    "slip kernel": (
        hertz("slip_integral"),
        "cattaneo-mindlin",
        ["slip at slipping place", "rms slip"],
    ),
    "moment of the pressure": (hertz("pressure_moment"), "hertz-paper", ["shear at instant"]),
    "moment of the log": (
        hertz("approach_moment"),
        "hertz-paper",
        ["tangential_displacement at instant"],
    ),
    "log of the distance": (
        hertz("approach_integral"),
        "unload-reload",
        ["tangential_displacement at instant", "rms displacement"],
    ),
    "stick edge": (a_later_edge, "unload-reload", ["stick_half_width at instant"]),
    "shear of an arc": (partial(an_arc, kernel="shear"), "hertz-paper", ["rms shear"]),
    "slip of an arc": (partial(an_arc, kernel="slip"), "hertz-paper", ["rms slip"]),
    "slip as a whole": (
        partial(a_field, name="slip"),
        "hertz-paper",
        ["slip at slipping place", "rms slip"],
    ),
    "shear as a whole": (
        partial(a_field, name="shear"),
        "flat-rounded-paper",
        ["shear at instant", "rms shear"],
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_field_that_is_wrong_by_a_hundredth_is_seen(
    cases: ModuleType, monkeypatch: pytest.MonkeyPatch, fault: str
) -> None:
    """The dissipation moves with none of these; a value that has a reference leaves that too."""
    plant, scene, quantities = FAULTS[fault]
    plant(monkeypatch)
    lines = {line.quantity: line for line in cases.lines("regress", (scene,))}
    assert fault == "stick edge" or lines["dissipation"].drift < 1e-11
    for quantity in quantities:
        assert lines[quantity].drift > 1e-6
        assert lines[quantity].error is None or lines[quantity].error > 1e-6
        assert not lines[quantity].good


def test_each_column_sees_its_own_fault_only(
    cases: ModuleType, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A baseline that drifted by 1e-10; a reference with a wrong digit; a scene without cases."""
    (line,) = (
        line for line in cases.lines("regress", ("hertz-paper",)) if line.quantity == "dissipation"
    )
    assert line.good
    drifted = dataclasses.replace(line.baseline, value=line.baseline.value * (1 + 1e-10))
    (exact,) = line.references
    wrong = dataclasses.replace(exact, value="0.0020575001840")
    for planted, error, drift in (
        (line._replace(baseline=drifted), (0, 1e-13), (0.99e-10, 1.01e-10)),
        (line._replace(references=(wrong,)), (1e-11, 1), (0, 1e-11)),
    ):
        assert not planted.good
        assert error[0] <= planted.error <= error[1]
        assert drift[0] <= planted.drift <= drift[1]
    new = line._replace(baseline=None, references=())
    assert not new.good  # a scene that is new is not good until it is accepted
    assert (new.error, new.drift) == (None, None)


def test_a_baseline_moves_only_where_it_is_named(
    cases: ModuleType, tool: Tool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    """Two baselines of a copy of the table drift; one is accepted, and printed beside the other."""
    table = tool("case_table")
    written: list[Any] = []
    before = table.sheet("full-stick")
    planted = [
        dataclasses.replace(before.baseline("theory", quantity), value=3.0)
        for quantity in ("stroke", "largest_half_width")
    ]
    monkeypatch.setattr(table, "sheet", lambda _: before.with_cases(planted))
    monkeypatch.setattr(table, "write", written.append)
    command = ["regress", "--scenes", "full-stick"]
    assert cases.main(command) == 1
    assert written == []
    assert cases.main([*command, "--accept", "full-stick:stroke"]) == 1
    (renewed,) = written
    was = before.baseline("theory", "stroke")
    now = renewed.baseline("theory", "stroke")
    assert table.agrees(was, now.value)
    assert now.commit == code_commit("*.py")
    assert renewed.baseline("theory", "largest_half_width").value == 3.0
    row_of_stroke = next(row for row in capsys.readouterr().out.splitlines() if " stroke " in row)
    assert row_of_stroke.split()[1:3] == ["stroke", "3.0"]
    assert cases.main(["regress", "--accept", "no-such:stroke"]) == 2


@pytest.mark.slow
def test_the_reference_of_a_time_series_sees_the_physics(regress: ModuleType) -> None:
    """Brute force in extended precision, on the same scene and on two that are 1e-9 beside it."""
    regress.mp.mp.dps = 20
    scene = load_scene("time-series")
    known = {case.quantity: case for case in regress.case_table.expected("time-series")}
    exact = regress.mp.mpf(known["dissipation"].value)
    assert abs(regress.truth(scene) / exact - 1) < 1e-15
    rows = [(t, p, q * (1 + 1e-9)) for t, p, q in scene.load.series().tolist()]
    for change in (
        {"friction": scene.friction.coefficient * (1 + 1e-9)},
        {"load": TimeSeriesLoad(rows=rows)},
    ):
        assert abs(regress.truth(scene.vary(**change)) / exact - 1) > 1e-10


@pytest.mark.parametrize(
    "name",
    [
        "cattaneo-mindlin",
        *(pytest.param(scene, marks=pytest.mark.slow) for scene in ("harmonics", "near-sliding")),
    ],
)
def test_references_evaluated_again_are_those_that_are_stored(
    regress: ModuleType, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """They have 30 digits and stay; a wrong one is replaced, and so is none that is no number."""
    for scene in (name, "full-stick"):
        known = regress.case_table.sheet(scene)
        changed, distance, _ = regress.references(known)
        assert changed == known
        assert distance < 1e-12
    known = regress.case_table.sheet(name)
    wrong = {
        case.key: dataclasses.replace(case, value=_with_first_entry(case.value, "1e-3"))
        for case in known.references("theory")
        if case.quantity in ("dissipation_density", "tangential_displacement")
    }
    assert len(wrong) == 2
    planted = dataclasses.replace(
        known,
        cases=tuple(
            wrong[case.key] if case.is_reference and case.key in wrong else case
            for case in known.cases
        ),
    )
    changed, _, _ = regress.references(planted)
    right = {case.key: case for case in known.references("theory") if case.key in wrong}
    evaluated = {case.key: case for case in changed.references("theory") if case.key in wrong}
    for key, case in right.items():
        assert regress.case_table.difference(case, evaluated[key].value).share < 1e-14
    monkeypatch.setattr(regress, "field_truth", lambda *_: ["nan"] * 6)
    with pytest.raises(ArithmeticError, match="no number"):
        regress.references(known)


def _with_first_entry(value: list[Any], entry: str) -> list[Any]:
    return [entry, *value[1:]]


@pytest.mark.parametrize(
    "row", [ELLIPSES[0], *(pytest.param(row, marks=pytest.mark.slow) for row in ELLIPSES[20:41:20])]
)
def test_the_table_of_ellipses_has_its_digits_by_two_routes(tool: Tool, row: dict) -> None:
    """W in closed phases of slip, to 28 digits; W(x) by brute force. Of the extremes W takes 90
    digits and minutes.
    """
    truth = tool("regress_truth")
    half_plane = tool("half_plane")
    with truth.mp.workdps(38):
        exact = truth.ellipse_dissipation(truth.Case(*(row[name] for name in truth.Case._fields)))
        assert abs(exact / truth.mp.mpf(row["dissipation"]) - 1) < 1e-28
    exact = list(map(float, row["density"]))
    density = truth.density_truth(half_plane.scene_of(row), row["x"])
    assert list(map(float, density)) == pytest.approx(exact, rel=0, abs=1e-14 * max(exact))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "within"), [("square wave", 1e-6), ("near sliding", 1e-13)])
def test_the_harmonics_of_the_other_table_are_repeated_by_brute_force(
    tool: Tool, name: str, within: float
) -> None:
    """W(x) to 1e-12. W of the square wave converges slowly: the stick edge has ripples at no corner
    of the path.
    """
    truth = tool("regress_truth")
    case = json.loads(truth.NASTY_FILE.read_text("utf-8"))[name]
    means = dict(zip(("mean_normal_load", "mean_tangential_load"), case["mean"], strict=True))
    load = HarmonicLoad(
        **means, normal_harmonics=case["normal"], tangential_harmonics=case["tangential"]
    )
    scene = make_scene(load, case["friction"])
    exact = list(map(float, case["density"]))
    assert float(truth.truth(scene)) == pytest.approx(float(case["dissipation"]), rel=within, abs=0)
    assert list(map(float, truth.density_truth(scene, case["x"]))) == pytest.approx(
        exact, rel=0, abs=1e-12 * max(exact)
    )


# - faults planted in either engine: seen by a metric, and the right term of the error budget blamed
@pytest.fixture
def blame(tool: Tool) -> ModuleType:
    return tool("covered")


def found_by(blame: ModuleType, value: float, *terms: Term) -> Any:
    budget = Budget(
        dataclasses.replace(METRICS["dissipation"], value=value), terms, are_half_planes=True
    )
    return blame.Found({"dissipation": value, blame.STEP: 0.0}, {"dissipation": budget})


def mesh(value: float | None, uncertainty: float) -> Term:
    return Term("mesh", value, uncertainty, "planted")


SOLVER, LOUD = (Term("solver", None, size, "planted", is_bound=True) for size in (1e-12, 0.5))
HEALTHY = (1e-3, mesh(0.9e-3, 0.2e-3), SOLVER)
# value and terms, and what is blamed: what is large, and the model only beyond doubt; within its
# band a metric sees nothing.
BLAMED = [
    (HEALTHY, None),
    ((1.1e-3, mesh(1e-3, 0.2e-3), SOLVER), None),
    ((1e-2, mesh(1e-3, 0.2e-3), SOLVER), "model"),
    ((1e-2, mesh(0.9e-2, 2e-3), SOLVER), "mesh"),
    ((1e-2, mesh(None, 2e-2), SOLVER), "mesh"),
    ((1e-2, mesh(1e-3, 0.2e-3), LOUD), "solver"),
]


@pytest.mark.parametrize(("faulty", "blamed"), BLAMED)
def test_blamed_is_what_is_large_and_steps_are_a_metric_by_themselves(
    blame: ModuleType, faulty: Any, blamed: str | None
) -> None:
    bad = found_by(blame, *faulty)
    good = found_by(blame, *HEALTHY)
    assert list(blame.seen(bad, good)) == (["dissipation"] if blamed else [])
    assert blamed is None or bad.blamed("dissipation") == blamed
    long = blame.Found({blame.STEP: -1e-2}, {})
    assert blame.seen(long, blame.Found({blame.STEP: -1e-4}, {})) == {
        blame.STEP: pytest.approx(50.0)
    }
    assert long.blamed(blame.STEP) == "step"


@pytest.mark.slow
def test_every_planted_fault_is_seen_and_blamed_on_the_right_term(blame: ModuleType) -> None:
    rows = list(blame.blame())
    assert len(rows) == 1 + len(blame.FAULTS)
    assert [row.what for row in rows if row.met is not True] == []


# ------------------------------- the page of numbers says what docs/numbers.json holds, in few rows
def body(page: str) -> str:
    """The page below its head, which names the machine."""
    return page.partition("\n\n## ")[2]


def rows_of(page: str) -> int:
    return sum(line.startswith("| ") for line in page.splitlines()) - page.count("|---|\n")


def test_the_page_of_numbers_is_what_was_measured_and_a_row_changed_by_hand_or_missed_is_seen(
    tool: Tool,
) -> None:
    claims = tool("claims")
    stored = json.loads(claims.STORE.read_text("utf-8"))
    page = claims.PAGE.read_text("utf-8")
    assert body(page) == body(claims.page_of(stored))
    assert len(claims.TEN) == 10
    assert rows_of(page) <= claims.MOST_ROWS
    assert set(stored) == set(claims.SECTIONS)
    assert all(callable(claims.section(title)) for title in claims.SECTIONS)
    count = sum(len(section["rows"]) for section in stored.values())
    assert f"has all {count} rows" in page

    _, title, claim = claims.TEN[0]
    next(row for row in stored[title]["rows"] if row["what"] == claim)["measured"] = 1e-3
    forged = claims.page_of(stored)
    assert "\n".join(claims.ten_of(stored)) not in page
    assert body(forged) != body(page)
    assert f"| {title} | {claim} | 0.001 | 1e-12 | **no** |" in forged
    for section in stored.values():  # all missed: the page says how many it does not show
        section["rows"] = [row | {"measured": 2.0, "limit": 1.0} for row in section["rows"]]
    forged = claims.page_of(stored)
    assert rows_of(forged) == claims.MOST_ROWS
    shown = claims.MOST_ROWS - len(claims.TEN)
    assert f"Missed, {count} in all, the first {shown}" in forged


def test_the_page_of_stress_has_its_cases_and_its_table_every_note(tool: Tool) -> None:
    stress = tool("stress")
    outcomes = json.loads(stress.STORE.read_text("utf-8"))
    assert set(outcomes) == set(stress.cases())
    judged = {name: stress.Outcome(**row) for name, row in outcomes.items()}
    assert stress.PAGE.read_text("utf-8") == stress.page(judged)
    table = stress.TABLE.read_text("utf-8")
    assert table == stress.table_of_trials(judged)
    sentences = [note for one in judged.values() for note in one.told + one.refused]
    assert len(sentences) > 20
    assert all(sentence in table.replace('""', '"') for sentence in sentences)
    judged["Finite elements: friction"].broken.append("f = 1: wrong, silent: W 0.2")
    assert "| **broken** |" in stress.page(judged)
    assert "wrong, silent: W 0.2" in stress.table_of_trials(judged)


# ----------------------------------------------- the page of performance: its judges are right
def test_peers_are_judged_by_closed_forms_that_theory_meets(tool: Tool) -> None:
    peers = tool("peers")
    models = tool("finite_elements")
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


def test_a_row_of_a_table_is_cells_as_many_as_its_head_has(tool: Tool) -> None:
    """A text in the place of a row would be printed letter by letter."""
    markdown = tool("claims").markdown
    assert markdown("a | b", [("0.2", "x")])[-1] == "| 0.2 | x |"
    for row in ("0.21", "ab", ("0.2",), ("0.2", "x", "y")):
        with pytest.raises(ValueError, match="a row of 2 cells"):
            markdown("a | b", [("0.1", "w"), row])
        with pytest.raises(ValueError, match="a row of 2 cells"):
            markdown_table(("a", "b"), [("0.1", "w"), row])


# --------------------------------------------------- records in the files that instruments write
# What becomes of records of the script's seed 7, by number.
RECORDS = {1: "refused", 3: "asked", 4: "right"}


@pytest.mark.parametrize("number", RECORDS)
def test_a_record_in_the_file_of_an_instrument_gets_the_right_answer_or_a_question(
    tool: Tool, number: int, tmp_path: Path
) -> None:
    outcome = tool("measured_records").outcome_of(7, number, tmp_path)
    assert outcome.kind == RECORDS[number], outcome


def test_a_record_that_is_misread_is_found(
    tool: Tool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for word, size in unit_words._UNITS_OF_FILES["load"].items():
        monkeypatch.setitem(unit_words._UNITS_OF_FILES["load"], word, 1.1 * size)
    outcome = tool("measured_records").outcome_of(7, 4, tmp_path)
    assert outcome.kind == "misread"
    assert "P differs by 10 % of its largest" in outcome.sentence
