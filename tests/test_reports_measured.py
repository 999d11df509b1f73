"""Measured loads: cycles of the standard, work that adds up, noise that is seen and measured, what is said of a record."""

from __future__ import annotations

import importlib.util
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rainflow import count_cycles

import reports
import semi_analytic
from command_line import halfplane
from reports.measured import check_record, counted, load_cycles, noise_of, record_in_words, with_work
from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read
from scenes import InputError, PolygonLoad, Scene, TimeSeriesLoad, load_scene

ROOT = Path(__file__).parents[1]
SCRIPT = ROOT / "docs" / "examples" / "measured" / "make.py"
BASE = load_scene("hertz-paper").vary(friction=0.6)
# ASTM E1049-85, 5.4.4, figure 6: the history and the table of counts.
HISTORY = [-2.0, 1, -3, 5, -1, 3, -4, 4, -2]
COUNTS = {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def of_rows(rows: Any, **keys: Any) -> Scene:
    return BASE.vary(load=TimeSeriesLoad(rows=np.asarray(rows).tolist(), **keys))


def test_cycles_are_those_of_the_standard_and_lie_within_one_another() -> None:
    assert dict(count_cycles(HISTORY)) == COUNTS
    time, so_far = np.arange(9.0), np.abs(np.diff(HISTORY, prepend=-2.0)).cumsum()  # a work of 1 for each unit of the way
    found = list(with_work(counted(time, np.array(HISTORY)), time, so_far))
    own: dict[float, float] = {}
    for cycle in found:
        own[cycle.range] = own.get(cycle.range, 0.0) + cycle.count
        assert cycle.dissipation == pytest.approx(2 * cycle.count * cycle.range)  # there and back for a closed one
    assert own == COUNTS
    (closed,) = [cycle for cycle in found if cycle.count == 1]
    assert (closed.start, closed.end) == (4.0, 5 + 4 / 7)  # from -1 to 3 and back to -1 on the way to -4


def test_the_work_of_a_closed_cycle_is_that_of_the_cycle_alone() -> None:
    """At constant P: the memory of the outer swing does not change what a swing within it dissipates (Masing)."""
    rows = [[0, 90, 0], [1, 90, 30], [2, 90, -25], [3, 90, 20], [4, 90, -5], [5, 90, 25], [6, 90, -25]]
    found = load_cycles(semi_analytic.solve(of_rows(rows)))
    assert found is not None
    (inner,) = [cycle for cycle in found.cycles if cycle.count == 1 and cycle.range == 25]
    alone = BASE.vary(load=PolygonLoad(initial_loading=[(90, 0), (90, 30), (90, 20)], cycle=[(90, -5)]))
    assert inner.dissipation == pytest.approx(semi_analytic.solve(alone).dissipation, rel=1e-9)
    assert (inner.start, inner.end) == (3.0, pytest.approx(4 + 25 / 30))


@pytest.mark.parametrize("name", ["time-series", "flight"])
def test_the_work_of_all_cycles_adds_up(name: str) -> None:
    solution = semi_analytic.solve(load_scene(name))
    found = load_cycles(solution)
    assert found is not None
    assert sum(cycle.dissipation for cycle in found.cycles) == pytest.approx(solution.dissipation, rel=1e-12)
    assert min(cycle.dissipation for cycle in found.cycles) >= 0
    assert found.per_cycle * found.counted == pytest.approx(solution.dissipation, rel=1e-12)
    assert np.all(np.diff(found.cumulative) >= 0)


def test_a_record_that_repeats_has_the_cycles_of_its_last_round() -> None:
    rows = [[0, 90, 0], [1, 90, 30], [2, 90, 10], [3, 90, 20], [4, 90, -30], [5, 90, 0]]
    solution = semi_analytic.solve(of_rows(rows, repeats=True))
    found = load_cycles(solution)
    assert found is not None
    assert found.cumulative[-1] == pytest.approx(solution.dissipation, rel=1e-12)
    assert sorted((cycle.range, cycle.count) for cycle in found.cycles)[0] == (10, 1)
    assert load_cycles(semi_analytic.solve("hertz-paper")) is None


def noisy(size: float, rows: int = 4000, seed: int = 1) -> np.ndarray:
    time = np.linspace(0, 10, rows)
    loads = np.column_stack([90 + 10 * np.sin(2 * np.pi * time + 0.4), 20 * np.sin(2 * np.pi * time)])
    return np.column_stack([time, loads + size * np.random.default_rng(seed).normal(size=(rows, 2))])


@pytest.mark.parametrize(("size", "warned"), [(0.0, False), (0.02, False), (0.2, True), (0.5, True)])
def test_what_noise_makes_of_the_work_is_found_and_warned_of(size: float, warned: bool) -> None:
    """Against the same record without noise; the share is that of the means, so a little less than all of it."""

    def work(rows: np.ndarray) -> float:
        return semi_analytic.solve(of_rows(rows), x=[0.0], time=rows[[0, -1], 0], fields=("dissipation",)).dissipation

    scene = of_rows(noisy(size))
    found, true = check_record(scene), work(noisy(size)) / work(noisy(0.0)) - 1
    assert found is not None
    if size:
        assert found.noise == (pytest.approx(size, rel=0.1), pytest.approx(size, rel=0.1))
        assert found.by_noise == pytest.approx(true, rel=0.25, abs=2e-3)
    else:
        assert (found.noise, found.by_noise) == ((0.0, 0.0), None)
    assert any(warning for _, warning in record_in_words(scene, found)) is warned
    if warned:
        mended = check_record(scene.vary(load={"average": found.average}))
        assert mended is not None
        assert mended.dissipation is not None
        assert mended.dissipation == pytest.approx(work(noisy(0.0)), rel=0.02)
        assert not any(warning for _, warning in record_in_words(scene.vary(load={"average": found.average}), mended))


def test_coarse_or_clean_rows_are_not_taken_for_noise() -> None:
    time = np.arange(400.0)
    for clean in (
        np.sin(0.05 * time),
        np.sin(2.5 * time),
        np.sign(np.sin(0.3 * time)),
        0.0 * time,
        np.round(np.sin(0.05 * time), 2),
    ):
        assert noise_of(clean) <= 0.01  # a little of rounded rows: their step


def test_a_threshold_that_changes_the_work_is_warned_of() -> None:
    scene = of_rows(noisy(0.0), reduce="tolerance", threshold={"P": 3, "Q": 3})
    found = check_record(scene)
    assert found is not None
    said = dict(record_in_words(scene, found))
    (first, second) = said
    assert f"The path goes through {found.kept:,} of 4,000 rows: by half-plane theory W = " in first
    assert second.startswith("With half the threshold W changes by +")
    assert list(said.values()) == [True, True]
    fine = of_rows(noisy(0.0), reduce="tolerance", threshold={"P": 0.01, "Q": 0.01})
    record = check_record(fine)
    assert record is not None
    assert not any(warning for _, warning in record_in_words(fine, record))


def examples() -> Any:
    spec = importlib.util.spec_from_file_location("make_measured", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_example_file_is_read_as_the_record_that_it_holds(tmp_path: Path) -> None:
    made = examples()
    made.main(tmp_path)
    shutil.copy(ROOT / "scenes" / "library" / "time-series.csv", tmp_path)
    text = (ROOT / "scenes" / "library" / "time-series.toml").read_text("utf-8")
    for name, keys in made.SCENES.items():
        table = "profile" if "tabulated" in keys else "load"
        start = text.index(f"[{table}]")
        end = text.find("\n[", start + 1)
        own = f'{text[:start]}[{table}]\nfile = "{name}"\n{keys}\n{text[end:] if end > 0 else ""}'
        (tmp_path / "scene.toml").write_text(own.partition("\n[[expected]]")[0], encoding="utf-8")
        scene = load_scene(tmp_path / "scene.toml")
        if table == "profile":
            x = np.linspace(-1.5, 1.5, 61)
            np.testing.assert_allclose(scene.profile.points.values, np.column_stack([x, x**2 / 2000]), atol=1e-9)
        elif name == "noisy.csv":
            assert np.std(scene.load.rows.values - made.record(2000), axis=0)[1:] == pytest.approx([0.3, 0.3], rel=0.05)
        else:
            np.testing.assert_allclose(scene.load.rows.values, made.record(161), atol=6e-3, err_msg=name)
        assert dict(getattr(scene, table).read_as)["file"].startswith(name)


def test_reports_of_abaqus_are_scored_as_the_theory_that_they_hold(tmp_path: Path) -> None:
    """One made like those of its users: both parts, nodes within them, three frames."""
    made = examples()
    made.main(tmp_path)
    scene = load_scene(made.RESULT)
    x = np.linspace(-1.2, 1.2, 61)
    exact = semi_analytic.solve(scene, x=x, time=made.TIMES, fields=("pressure", "shear"))
    for name in made.REPORTS:
        found = read(tmp_path / name, Mapping(times=made.TIMES))
        for quantity in ("x", "time", "pressure", "shear"):
            np.testing.assert_allclose(getattr(found, quantity), getattr(exact, quantity), rtol=1e-5, atol=1e-5, err_msg=name)
        report = score_file(tmp_path / name, Mapping(times=made.TIMES), scene)
        assert report.comparison.passed
        assert abs(report.metric("peak_pressure").value) < 1e-5
    field = read(tmp_path / "field.rpt", Mapping())
    assert field.time.tolist() == list(made.TIMES)
    assert field.notes[:2] == (
        "the nodal values of BLOCK-1 were taken, at 3 frames",
        "61 nodes that do not lie on the contact surface were left out",
    )


REPORTED = {
    "two surfaces": (("PAD-1", "BLOCK-1"), "'BLOCK-1', 'PAD-1' carry pressure, master and slave perhaps: say which by surface"),
    "elements": (("at nodes for part", "at integration points for part"), "its values are reported at integration points"),
    "no places": (("COORD.COORD1", "S.S11"), "the nodes of BLOCK-1 have no places: report COORD with COORD1 beside CPRESS"),
    "no pressure": (("CPRESS", "S.S22"), "no pressure that is not zero everywhere (looked for CPRESS)"),
    "a word": (("-1.16000", "NoValue"), "COORD1 = 'NoValue' is not a finite number"),
    "a short row": (("          -1.16000", ""), "5 values (Node Label, COORD1, COORD2, CPRESS, CSHEAR1) are needed, not"),
    "no table": (("-" * 90, "="), "the report holds no table of values below a line of dashes"),
}


@pytest.mark.parametrize("fault", REPORTED)
def test_each_fault_of_a_report_is_one_sentence(fault: str, tmp_path: Path) -> None:
    examples().main(tmp_path)
    path = tmp_path / "field.rpt"
    (old, new), words = REPORTED[fault]
    text = path.read_text("utf-8")
    # Of two surfaces: what is the block's at the first frame is the pad's.
    path.write_text(text.replace(new, old, 1) if fault == "two surfaces" else text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read(path, Mapping())
    assert words in str(caught.value)
    assert str(caught.value).startswith(str(path))


def test_check_exact_json_and_page_say_how_a_record_was_read_and_what_its_cycles_dissipate(tmp_path: Path) -> None:
    scene = of_rows(noisy(0.5, 800), reduce="turning_points", threshold={"P": 1, "Q": 1})
    path = tmp_path / "noisy.json"
    rows = "\n".join(f"{t:.4f};{p:.4f};{q:.4f}".replace(".", ",") for t, p, q in scene.load.rows.values)
    (tmp_path / "noisy.csv").write_text(f"Time [s];FN [N/mm];FT [N/mm]\n{rows}\n", encoding="utf-8")
    keys = json.loads(scene.vary(load={"rows": [[0, 1, 0], [1, 1, 0]]}).model_dump_json(exclude_none=True))
    keys["load"] = {"kind": "time_series", "file": "noisy.csv", "reduce": "turning_points", "threshold": {"P": 1, "Q": 1}}
    path.write_text(json.dumps(keys), encoding="utf-8")
    done = json.loads(halfplane(tmp_path, "check", str(path), "--json").stdout)["result"]
    (read,) = [note for note in done["notes"] if "as it was read" in note]
    assert "columns separated by: semicolon; decimal sign: comma; time: 'Time [s]', s (in its heading)" in read
    assert any("The path goes through" in words for words in done["remarks"])
    done = json.loads(halfplane(tmp_path, "exact", str(path), "--json", "--quiet", "--out", str(tmp_path / "exact")).stdout)[
        "result"
    ]
    cycles = done["load_cycles"]
    assert cycles["cumulative"]["dissipation"][-1] == pytest.approx(done["dissipation"], rel=1e-12)
    assert cycles["dissipation_per_cycle"] * cycles["counted"] == pytest.approx(done["dissipation"], rel=1e-12)
    loaded = load_scene(path)
    exact = semi_analytic.solve(loaded, x=np.linspace(-1.2, 1.2, 41), time=loaded.load.series()[::40, 0])
    page = reports.write(reports.compare(exact, exact), tmp_path / "out")
    html, content = page.read_text("utf-8"), json.loads((page.parent / "comparison.json").read_text("utf-8"))
    assert 'id="measured"' in html
    assert "Dissipation of each load cycle" in html
    assert content["measured"]["read_as"]["load.file"][1] == ["columns separated by", "semicolon"]
    assert content["measured"]["loads"]["kept"] == len(loaded.load.kept_rows())
    assert content["reference"]["load_cycles"]["counted"] == cycles["counted"]
