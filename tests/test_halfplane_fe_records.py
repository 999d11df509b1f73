"""A measured record has more increments than an answer can hold: some instants go, said, and W, W(x) and the checks are of all.

The record is that of the benchmark, on real bodies and a coarse mesh.
"""

import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import halfplane_fe
import halfplane_fe.run
import semi_analytic
from halfplane_fe import FiniteElementSolution
from problems import COARSE
from reports import compare, write
from reports.charts.plate import path_of
from scenes import ContactSolution, Scene, TimeSeriesLoad, load_scene

BENCHMARKS = Path(__file__).parent.parent / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))
import long_record  # noqa: E402

sys.path.remove(str(BENCHMARKS))

MOST = halfplane_fe.run.MOST_INSTANTS


@cache
def solved(rows: int, most: int, repeats: bool = False) -> FiniteElementSolution:
    """The first `rows` of the record, kept at `most` instants; as a cycle, with its first row again at the end."""
    record = long_record.rows_of(rows)
    if repeats:
        record = np.vstack([record, [record[-1, 0] + 0.01, *record[0, 1:]]])
    load = TimeSeriesLoad(rows=record.tolist(), repeats=repeats)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(halfplane_fe.run, "MOST_INSTANTS", most)
        return halfplane_fe.solve(scene().vary(load=load, cycles=2), COARSE)


@cache
def scene() -> Scene:
    """The example with a block and a pad, f = 0.7."""
    bodies = {"lower": {"kind": "block", "width": 40.0, "height": 20.0}, "upper": {"kind": "pad", "width": 20.0, "height": 15.0}}
    return load_scene("hertz-paper").vary(bodies=bodies, friction={"coefficient": 0.7}, tolerances={})


def assert_thinned(found: FiniteElementSolution, whole: FiniteElementSolution, most: int) -> None:
    """Fewer instants, each as in the whole answer; what is of the whole path is that of the whole answer to rounding."""
    assert len(found.time) == len(found.states) <= most < len(whole.time)
    assert found.thinned > whole.thinned
    rows = np.searchsorted(whole.time, found.time)
    for name in ("time", "normal_load", "pressure", "shear", "slip", "state", "contact_edges", "stick_edges"):
        np.testing.assert_array_equal(getattr(found, name), getattr(whole, name)[rows], err_msg=name)
    assert found.steady_from == whole.steady_from
    for name in ("dissipation", "dissipation_density", "cycle_dissipation", "permanent_stick_half_width", "loop_work"):
        assert getattr(found, name) == pytest.approx(getattr(whole, name), rel=1e-14, nan_ok=True), name
    for name, energy in whole.record.energy.items():
        assert found.record.energy[name].sum() == pytest.approx(energy.sum(), rel=1e-10, abs=1e-13), name
    for name, violation in whole.record.certificates.items():
        assert found.record.certificates[name].max() == violation.max(), name
    assert found.record.iterations.sum() == whole.record.iterations.sum()
    assert found.work.counts == whole.work.counts
    # Said: how many are missing, in the notes of the page and the terminal, and in the counts.
    missing = len(whole.time) - len(found.time)
    assert any(note.startswith(f"{missing} of {len(whole.time)} instants") for note in found.record.notes)
    assert found.work.skipped["instants"][0] == missing


def test_every_row_stays_and_everything_but_the_instants_is_of_the_whole_path() -> None:
    found, whole = solved(300, MOST), solved(300, 10**9)
    assert_thinned(found, whole, MOST)
    assert np.isin(long_record.rows_of(300)[:, 0], found.time).all()


def test_of_more_rows_than_there_is_room_for_some_stay() -> None:
    found = solved(30, 12)
    assert_thinned(found, solved(30, 10**9), 12)
    assert len(found.time) >= 6
    assert np.diff(found.time).max() < 0.1  # evenly many: no more than nine rows of 0.01 s between two


def test_a_cycle_that_repeats_keeps_its_start_and_its_end() -> None:
    found, whole = solved(11, 16, repeats=True), solved(11, 10**9, repeats=True)
    assert_thinned(found, whole, 16)
    assert found.time[found.last_cycle[[0, -1]]].tolist() == whole.time[whole.last_cycle[[0, -1]]].tolist()


def test_theory_on_the_kept_instants_has_the_work_of_the_path() -> None:
    """Rows that were left out must not count as straight lines: `thinned` spares the second theory."""
    found = solved(30, 12)
    own = semi_analytic.solve(found.scene, x=found.x, time=found.time)
    on_kept = semi_analytic.solve(found.scene, x=found.x, time=found.time, straight_steps=True)
    assert own.dissipation == pytest.approx(semi_analytic.solve(found.scene).dissipation, rel=1e-12)
    assert on_kept.dissipation < 0.995 * own.dissipation


def test_files_and_page_are_bounded_and_the_page_says_what_is_missing(tmp_path: Path) -> None:
    found = solved(300, MOST)
    exact = semi_analytic.solve(found.scene, x=found.x, time=found.time)
    page = write(compare(exact, found, polygon_reference=exact), tmp_path / "out").read_text(encoding="utf-8")
    assert len(page) < 4_000_000
    assert "instants of this long path are left out" in page
    assert sum(file.stat().st_size for file in (tmp_path / "out").glob("*.nc")) < 2.2 * 25 * MOST * len(found.x) + 2_000_000
    assert ContactSolution.load(tmp_path / "out" / "result.nc").thinned


def test_a_long_line_is_drawn_with_few_places_and_keeps_its_peaks() -> None:
    across, down = np.linspace(0.0, 400.0, 40_000), np.random.default_rng(1).uniform(0.0, 100.0, 40_000)
    down[12_345], down[23_456] = 300.0, -50.0
    drawn = path_of(across, down)
    assert len(drawn) < 25_000
    assert " 300L" in drawn
    assert " -50L" in drawn
    assert drawn.startswith(f"M0 {down[0]:.2f}".rstrip("0"))
    assert drawn.endswith(f"L400 {down[-1]:.2f}".rstrip("0"))
    down[5000:6000] = np.nan
    assert path_of(across, down).count("M") == 2
