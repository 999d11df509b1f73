"""What `score` says beside its verdict: what could not be scored, spikes in the table, causes with a trace of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command_line import halfplane

import semi_analytic
from reports.scoring.against import score_file
from reports.scoring.mapping import Mapping
from scenes import ContactSolution, Scene, load_scene
from scenes.solution import last_whole_cycle

STEPS = 20
CATTANEO = load_scene("cattaneo-mindlin")


def cycle_from(start: float, scene: Scene = CATTANEO, steps: int = STEPS) -> ContactSolution:
    """A steady cycle of theory that starts at this share of a period after the start of the path's."""
    path = scene.load.path()
    time = path.cycle_start + path.period * (2 + start + np.linspace(0, 1, steps + 1))
    return semi_analytic.solve(scene, x=np.linspace(-1.1, 1.1, 61), time=time)


def frames(solution: ContactSolution, form: str, *names: str) -> pd.DataFrame:
    """Rows of frames without their times, each number printed in the form."""
    points = len(solution.x)
    known = {
        "P": np.repeat(solution.normal_load, points),
        "Q": np.repeat(solution.tangential_load, points),
        "CSLIP1": solution.slip.ravel(),
    }
    columns = {
        "frame": np.repeat(np.arange(len(solution.time)), points),
        "X": np.tile(solution.x, len(solution.time)),
        "CPRESS": solution.pressure.ravel(),
        "CSHEAR1": solution.shear.ravel(),
    } | {name: known[name] for name in names}
    printed = {name: [form % value for value in values] for name, values in columns.items() if name != "frame"}
    return pd.DataFrame({**columns, **printed})


def written(table: pd.DataFrame, path: Path) -> Path:
    table.to_csv(path, index=False)
    return path


# ------------------------------------------------------------------------------------------------ a cycle from any instant
@pytest.mark.parametrize("start", [0.0, 1 / 3, 0.42])
@pytest.mark.parametrize("form", ["%.5g", "%.6g", "%.9g"])
def test_a_whole_cycle_has_its_dissipation_wherever_it_starts_and_however_it_is_printed(
    tmp_path: Path, start: float, form: str
) -> None:
    solution = cycle_from(start)
    for names in (("CSLIP1",), ("CSLIP1", "P", "Q")):
        found = score_file(written(frames(solution, form, *names), tmp_path / "cycle.csv"), Mapping(), CATTANEO)
        assert found.metric("dissipation").value == pytest.approx(0.0, abs=1e-3), names
        for key in ("permanent_stick", "largest_slip", "dissipation_density"):
            assert found.metric(key).value == pytest.approx(0.0, abs=1e-3), (key, names)
        assert found.passed


def test_a_cycle_that_starts_at_the_top_of_a_sine_is_whole(tmp_path: Path) -> None:
    """There the loads stand still, and a small error of a load is a large one of the time."""
    scene = load_scene("hertz-paper")
    top = float(scene.load.phase_degrees) / 360
    found = score_file(written(frames(cycle_from(top, scene, 24), "%.5g", "CSLIP1"), tmp_path / "top.csv"), Mapping(), scene)
    assert found.metric("dissipation").value is not None


def test_finite_elements_on_their_own_instants_are_a_reference_for_a_cycle_from_elsewhere() -> None:
    """The reference is put on the result's instants by the phase of the path, not by the time since the first of them."""
    from reports.comparison import compare

    reference, result = cycle_from(0.0, steps=600), cycle_from(0.4)
    found = compare(reference, result)
    assert found.metric("shear").value < 0.02
    np.testing.assert_allclose(found.expected.tangential_load, found.found.tangential_load, atol=1e-9 * 90)


def test_the_last_whole_cycle_of_instants() -> None:
    """The path's own where it is there, else the last period, else a part that is called one."""
    period, start = 1.0, 1.0
    own = np.linspace(1.0, 3.0, 21)
    indices, whole = last_whole_cycle(own, period, start)
    assert (indices.tolist(), whole) == ([*range(10, 21)], True)
    indices, whole = last_whole_cycle(own[:15], period, start)  # from 1 to 2.4
    assert (indices.tolist(), whole) == ([*range(11)], True)
    indices, whole = last_whole_cycle(own[3:15], period, start)  # from 1.3 to 2.4
    assert (indices.tolist(), whole) == ([*range(1, 12)], True)
    indices, whole = last_whole_cycle(own[3:12], period, start)  # from 1.3 to 2.1
    assert not whole
    off = own[3:14].copy()
    off[-1] += 0.001  # a hundredth of a step
    assert last_whole_cycle(off, period, start)[1]
    off[-1] += 0.009
    assert not last_whole_cycle(off, period, start)[1]


# ------------------------------------------------------------------------------------------- what could not be scored
def test_what_has_a_tolerance_and_no_value_is_said_beside_the_verdict_and_ends_with_1(tmp_path: Path) -> None:
    solution = cycle_from(0.0)
    table = frames(solution, "%.6g", "CSLIP1", "P", "Q")
    written(table[table["frame"] < STEPS - 2], tmp_path / "part.csv")
    asked = ["score", "part.csv", "--scene", "cattaneo-mindlin", "--quiet"]
    done = halfplane(tmp_path, *asked)
    assert done.returncode == 1
    words = " ".join(done.stdout.split())
    assert "Within tolerance as far as it was scored." in words
    assert "Not scored, though a tolerance judges it: dissipation." in words
    assert "not scored, though a tolerance judges it: dissipation: exit code 1" in done.stderr
    left_out = halfplane(tmp_path, *asked, "--tolerance", "dissipation=none")
    assert left_out.returncode == 0
    assert "Within tolerance. " in left_out.stdout
