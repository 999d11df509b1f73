"""`halfplane diff`: two runs, a run and a baseline, and everything that is neither."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from reports import compare
from reports.cli import findings as baseline
from reports.cli import main
from reports.cli.findings import DIFFERS, ONLY_A, ONLY_B, SAME, Difference, difference, tolerances_of
from reports.cli.solving import write_solution
from reports.comparison.content import as_json
from scenes import InputError, load_scene
from test_reports_synthetic import cattaneo_mindlin


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folders `a` (a comparison), `alone` (one engine), `failed` (its first steps only); solution.nc."""
    root = tmp_path_factory.mktemp("runs")
    exact, rough = cattaneo_mindlin(), cattaneo_mindlin(dissipation=1.25e-3)
    content = compare(replace(exact, engine="semi_analytic"), replace(rough, engine="halfplane_fe"))
    (root / "a").mkdir()
    (root / "a" / "comparison.json").write_text(as_json(content))
    write_solution(exact, root / "alone")
    write_solution(replace(exact, record=replace(exact.record, converged=False)), root / "failed", name="partial")
    exact.save(root / "solution.nc")
    return root


@pytest.fixture
def a(runs: Path) -> baseline.Findings:
    return baseline.read_findings(runs / "a")


def with_figures(findings: baseline.Findings, **figures: float | None) -> baseline.Findings:
    named = {key.replace("__", "."): value for key, value in figures.items()}
    assert named.keys() <= findings.figures.keys()
    return replace(findings, source="b", figures={**findings.figures, **named})


def verdicts(found: Difference) -> dict[str, str]:
    """Of the rows that are not the same."""
    return {row.key: row.verdict for row in found.rows if row.verdict != SAME}


def test_a_run_holds_the_metrics_and_the_figures_of_both_engines(a: baseline.Findings) -> None:
    exact = cattaneo_mindlin()
    assert a.figures["semi_analytic.dissipation"] == exact.dissipation
    assert a.figures["halfplane_fe.dissipation"] == 1.25e-3
    assert a.figures["metric.dissipation"] == pytest.approx(1.25e-3 / exact.dissipation - 1, rel=1e-14)
    assert a.figures["halfplane_fe.largest_half_width"] == 1.0
    assert a.figures["halfplane_fe.largest_pressure"] == exact.pressure.max()
    assert difference(a, a).same


def test_a_solution_says_the_same_as_the_summary_beside_it(runs: Path) -> None:
    stored, folder = baseline.read_findings(runs / "solution.nc"), baseline.read_findings(runs / "alone")
    assert stored.figures == folder.figures
    assert stored.scene == folder.scene
    assert len(stored.figures) >= 5


@pytest.mark.parametrize(
    ("key", "inside", "beyond"),
    [
        ("semi_analytic__dissipation", 0.9e-9, 1.1e-9),
        ("halfplane_fe__dissipation", 0.9e-6, 1.1e-6),
        ("halfplane_fe__largest_half_width", -0.9e-6, -1.1e-6),
    ],
)
def test_figures_of_engines_differ_relatively(a: baseline.Findings, key: str, inside: float, beyond: float) -> None:
    value = a.figures[key.replace("__", ".")]
    assert value is not None
    assert difference(a, with_figures(a, **{key: value * (1 + inside)})).same
    assert verdicts(difference(a, with_figures(a, **{key: value * (1 + beyond)}))) == {key.replace("__", "."): DIFFERS}


def test_metrics_differ_absolutely_and_none_is_no_number(a: baseline.Findings) -> None:
    value = a.figures["metric.pressure"]
    assert value == 0.0
    assert difference(a, with_figures(a, metric__pressure=0.9e-6)).same
    assert not difference(a, with_figures(a, metric__pressure=1.1e-6)).same
    assert not difference(a, with_figures(a, semi_analytic__permanent_stick_half_width=None)).same
    neither = with_figures(a, semi_analytic__permanent_stick_half_width=None)
    assert difference(neither, neither).same


def test_places_of_mirrored_peaks_are_the_same(a: baseline.Findings) -> None:
    one, other, apart = (
        replace(a, figures={**a.figures, "metric.pressure_peak_place": place, "metric.shear": place}) for place in (-0.1, 0.1, 0.11)
    )
    assert verdicts(difference(one, other)) == {"metric.shear": DIFFERS}
    assert verdicts(difference(one, apart)) == {"metric.shear": DIFFERS, "metric.pressure_peak_place": DIFFERS}


def test_a_value_that_is_no_number_is_not_one_that_is_none(runs: Path, a: baseline.Findings) -> None:
    content = json.loads((runs / "a" / "comparison.json").read_text())
    content["metrics"]["shear"].update(value=None)
    none = baseline.of_content(content, "none")
    content["metrics"]["shear"].update(finite=False)
    nan = baseline.of_content(content, "nan")
    assert verdicts(difference(none, nan)) == {"metric.shear.finite": ONLY_B}
    assert difference(nan, nan).same


def test_a_dissipation_that_is_rounding_of_zero_is_not_compared_with_itself(a: baseline.Findings) -> None:
    """A f^2 P^2 of the scene is 0.0356: 1e-18 is rounding of it, a thousandth of a thousandth of it is not."""
    nothing = with_figures(a, semi_analytic__dissipation=1e-18)
    assert difference(nothing, with_figures(a, semi_analytic__dissipation=-2e-18)).same
    assert not difference(nothing, with_figures(a, semi_analytic__dissipation=1e-15)).same


def test_a_figure_that_one_lacks_is_a_difference(a: baseline.Findings) -> None:
    less = replace(a, figures={key: value for key, value in a.figures.items() if key != "metric.state"})
    assert verdicts(difference(a, less)) == {"metric.state": ONLY_A}
    assert verdicts(difference(less, a)) == {"metric.state": ONLY_B}


def test_what_only_one_side_holds_at_all_is_told_and_not_compared(runs: Path, a: baseline.Findings) -> None:
    """The answer of one engine against a whole run: its own figures count, and any of these that the run lacks."""
    alone = baseline.read_findings(runs / "solution.nc")
    engine = {"semi_analytic" + key.removeprefix("closed_form"): value for key, value in alone.figures.items()}
    found = difference(replace(alone, figures=engine), a)
    assert found.same
    assert {row.key.partition(".")[0] for row in found.rows} == {"semi_analytic"}
    assert found.notes == ("not compared, for it is only in B: halfplane_fe.*", "not compared, for it is only in B: metric.*")
    less = replace(alone, figures={key: value for key, value in engine.items() if not key.endswith("dissipation")})
    assert verdicts(difference(less, a)) == {"semi_analytic.dissipation": ONLY_B}


def test_tolerances_of_the_command_line_come_first_then_those_kept(a: baseline.Findings) -> None:
    other = with_figures(a, metric__shear=1e-3)
    assert not difference(a, other).same
    assert difference(a, other, {"metric.*": 2e-3}).same
    kept = replace(other, tolerances={"metric.shear": 2e-3})
    assert difference(a, kept).same
    assert not difference(a, kept, {"metric.shear": 0.0}).same


@pytest.mark.parametrize("word", ["metric.shear", "=1", "metric.shear=", "metric.shear=-1", "metric.shear=nan", "metric.shear=x"])
def test_a_tolerance_is_a_key_and_a_number(word: str) -> None:
    with pytest.raises(InputError, match="KEY=VALUE"):
        tolerances_of([word])


def test_an_unknown_key_is_refused_with_the_keys_there_are(a: baseline.Findings) -> None:
    with pytest.raises(
        InputError, match=r"no figure is called so; there are metric\.largest_pressure, .*halfplane_fe\.dissipation"
    ):
        difference(a, a, {"metric.sheer": 1.0})


def test_different_scenes_are_named_key_by_key(a: baseline.Findings) -> None:
    scene = a.scene.vary(friction=0.4)
    with pytest.raises(InputError, match=r"different scenes: friction\.coefficient is 0\.5 and 0\.4$"):
        difference(a, replace(a, scene=scene))
    words = a.scene.vary(title="another title", name="other")
    assert difference(a, replace(a, scene=words)).same


def test_no_figure_in_common_is_refused(a: baseline.Findings) -> None:
    alone = replace(a, figures={"somebody.dissipation": 1.0}, engines={"somebody": {}})
    with pytest.raises(InputError, match="no figure in common"):
        difference(a, alone)


def test_settings_and_versions_that_differ_are_told(a: baseline.Findings) -> None:
    engines = {**a.engines, "halfplane_fe": {"settings": {"mesh": {"order": 1}}, "versions": {}}}
    found = difference(a, replace(a, engines=engines))
    assert found.same
    assert found.notes == ("halfplane_fe: settings.mesh.order is absent in A and 1 in B",)


class TestCommand:
    def test_same_differs_and_accept(self, runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        run, kept = str(runs / "a"), str(tmp_path / "kept" / "baseline.json")
        assert main(["diff", run, kept]) == 2
        assert "--accept` writes it" in capsys.readouterr().err
        assert main(["diff", run, kept, "--accept"]) == 0
        assert main(["diff", run, kept]) == 0
        assert main(["diff", kept, run]) == 0
        assert [path.name for path in (tmp_path / "kept").iterdir()] == ["baseline.json"]

        other = tmp_path / "b"
        shutil.copytree(runs / "a", other)
        content = json.loads((other / "comparison.json").read_text())
        content["result"]["dissipation"] *= 1.001
        (other / "comparison.json").write_text(json.dumps(content))
        before = Path(kept).read_text()
        capsys.readouterr()
        assert main(["diff", str(other), kept, "--json"]) == 1
        table = json.loads(capsys.readouterr().out)["result"]
        assert [row["key"] for row in table["rows"] if row["verdict"] != SAME] == ["halfplane_fe.dissipation"]
        assert table["same"] is False
        assert main(["diff", str(other), kept]) == 1
        words = capsys.readouterr().out
        assert f"{len(table['rows']) - 1} values are the same to the last digit and not listed" in words
        assert main(["diff", str(other), kept, "--quiet"]) == 1
        assert main(["diff", kept, str(tmp_path / "quiet.json"), "--accept", "--quiet"]) == 0
        assert capsys.readouterr().out == ""
        assert main(["diff", str(other), kept, "--tolerance", "halfplane_fe.dissipation=2e-3"]) == 0
        assert Path(kept).read_text() == before
        assert main(["diff", str(other), kept, "--accept", "--tolerance", "metric.*=1e-3"]) == 0
        assert main(["diff", str(other), kept]) == 0
        assert baseline.read_findings(kept).tolerances == {"metric.*": 1e-3}

    def test_accept_never_writes_over_what_is_no_baseline(self, runs: Path, tmp_path: Path) -> None:
        for content in ('{"format": "halfplane comparison 1"}', "# notes\n", ""):
            victim = tmp_path / "victim.json"
            victim.write_text(content)
            assert main(["diff", str(runs / "a"), str(victim), "--accept"]) == 2
            assert victim.read_text() == content
        assert main(["diff", str(runs / "a"), str(runs / "alone"), "--accept"]) == 2

    def test_accept_refuses_another_scene_and_what_did_not_converge(self, runs: Path, tmp_path: Path, a: baseline.Findings) -> None:
        kept = tmp_path / "baseline.json"
        baseline.write_baseline(replace(a, scene=load_scene("hertz-paper")), kept, {})
        before = kept.read_text()
        assert main(["diff", str(runs / "a"), str(kept), "--accept"]) == 2
        assert kept.read_text() == before
        with pytest.raises(InputError, match="not converged, so no baseline: halfplane_fe: stuck"):
            baseline.write_baseline(replace(a, unfinished=("halfplane_fe: stuck",)), kept, {})
        assert kept.read_text() == before

    @pytest.mark.parametrize(
        ("name", "content", "says"),
        [
            ("nothing", None, "no such file"),
            ("a.json", "{", "can't be read as JSON"),
            ("a.json", "[]", "neither a run nor a baseline"),
            ("a.json", '{"format": "halfplane baseline 0"}', "format is 'halfplane baseline 0'"),
            ("a.json", '{"format": "halfplane baseline 1"}', "can't be read as one: 'scene'"),
            ("a.json", '{"format": "halfplane baseline 3"}', "of a later version; update halfplane"),
            ("a.json", '{"format": "halfplane comparison 1", "metrics": 3}', "can't be read as one"),
            ("a.nc", "not a solution", "can't be read as a solution"),
        ],
    )
    def test_what_is_neither_is_refused_in_a_sentence(
        self, runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, content: str | None, says: str
    ) -> None:
        if content is not None:
            (tmp_path / name).write_text(content)
        for pair in ([str(tmp_path / name), str(runs / "a")], [str(runs / "a"), str(tmp_path / name)]):
            assert main(["diff", *pair]) == 2
            line = capsys.readouterr().err
            assert says in line
            assert len(line.strip().splitlines()) == 1

    def test_folders_without_an_answer(self, runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["diff", str(tmp_path), str(runs / "a")]) == 2
        assert "no folder of a run" in capsys.readouterr().err
        assert main(["diff", str(runs / "failed"), str(runs / "a")]) == 2
        assert "only the steps before an engine failed" in capsys.readouterr().err
