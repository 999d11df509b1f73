"""What `halfplane run` tells: progress with steps and time left, the log in the folder, the verdict for programs."""

import json
import re
from pathlib import Path

import jsonschema
import pytest

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.cli import main, solving
from reports.cli.answers import FORMAT, answer_schema
from reports.cli.machine import Finding
from reports.cli.options import tolerances_of
from reports.cli.process import NOT_CONVERGED
from reports.cli.solving import LONG, cost_of
from reports.console import Stages, TimeLeft
from scenes import ContactSolution, ConvergenceError, Record, TimeSeriesLoad, freeze, load_scene, scene_names, scene_text
from test_cli_commands import COARSE, ROOT, halfplane
from test_reports_synthetic import cattaneo_mindlin


class TestMachine:
    def test_stdout_is_one_json_document_and_the_folder_has_a_log(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "run", "cattaneo-mindlin", "--json", *COARSE)
        envelope = json.loads(done.stdout)
        told = envelope["result"]
        assert done.returncode == envelope["exit_code"] == 1
        assert (envelope["format"], envelope["command"], envelope["scene"]) == (FORMAT, "run", "cattaneo-mindlin")
        assert told["passed"] is False
        assert told["metrics"]["dissipation"]["accurate"] is False
        whole = json.loads((tmp_path / "out" / "cattaneo-mindlin" / "comparison.json").read_text(encoding="utf-8"))
        assert told["metrics"]["shear"]["value"] == whole["metrics"]["shear"]["value"]
        assert (tmp_path / told["page"]).is_file()
        log = (tmp_path / "out" / "cattaneo-mindlin" / "run.log").read_text(encoding="utf-8")
        assert "halfplane run cattaneo-mindlin --element-size 0.25" in log.splitlines()[0]
        assert "revolution 1, " in log
        assert " contact iterations" in log
        assert whole["verdict"]["sentence"] in log
        assert "finite elements: " in done.stderr

    def test_no_convergence_is_json_too(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        partial = cattaneo_mindlin(
            steps_per_leg=4, points=21, record=Record(False, "not converged", "stuck", freeze([0] * 13, int))
        )

        def fails(*arguments: object, **options: object) -> None:
            raise ConvergenceError("step 3 does not converge", partial)

        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(solving, "solve_finite_elements", fails)
        assert main(["run", "cattaneo-mindlin", "--quiet", "--json"]) == NOT_CONVERGED
        told = json.loads(capsys.readouterr().out)
        jsonschema.validate(told, answer_schema())
        assert told["exit_code"] == NOT_CONVERGED
        assert "step 3" in told["result"]["error"]
        assert ContactSolution.load(tmp_path / told["result"]["file"]).time[-1] == partial.time[-1]
        monkeypatch.setattr(solving, "solve_half_plane", fails)
        assert main(["exact", "cattaneo-mindlin", "--quiet", "--json"]) == NOT_CONVERGED
        assert json.loads(capsys.readouterr().out) == told | {"command": "exact"}

    def test_one_engine_alone_has_its_figures(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        """Those of its file, to the digit; the exit code inside is the one outside."""
        out = tmp_path / "out"
        for engine, arguments in (("semi_analytic", ["exact"]), ("halfplane_fe", ["fe", *COARSE])):
            code = main([arguments[0], "cattaneo-mindlin", "--out", str(out), "--quiet", "--json", *arguments[1:]])
            envelope = json.loads(capsys.readouterr().out)
            told = envelope["result"]
            whole = json.loads((out / f"{engine}.json").read_text(encoding="utf-8"))
            assert (envelope["format"], envelope["scene"], told["engine"]) == (FORMAT, "cattaneo-mindlin", engine)
            assert envelope["exit_code"] == code
            assert told["passed"] is (code == 0)
            assert told["admissible"] is True
            assert Path(told["file"]) == out / f"{engine}.nc"
            for name in ("dissipation", "largest_pressure", "largest_half_width", "certificates", "notes"):
                assert told[name] == whole[name]
            stated = {one.quantity for one in load_scene("cattaneo-mindlin").expected}
            assert {"dissipation"} <= {one["quantity"] for one in told["expected"]} <= stated
            assert all(one["met"] for one in told["expected"]) is told["passed"]

    def test_check_and_doctor(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        assert main(["check", "cattaneo-mindlin", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)["result"]
        assert told["nearest_to_sliding"]["ratio"] == pytest.approx(0.6)
        findings = (Finding("gmsh", True, "there"), Finding("off-screen rendering", False, "no screen"))
        monkeypatch.setattr("reports.cli.machine.examine", lambda _out: findings)
        assert main(["doctor", "--json"]) == 1
        told = json.loads(capsys.readouterr().out)
        assert (told["exit_code"], told["result"]["passed"]) == (1, False)
        assert told["result"]["checks"]["off-screen rendering"] == {"good": False, "found": "no screen"}
        assert main(["doctor", "--quiet"]) == 1
        assert main(["check", "cattaneo-mindlin", "--quiet"]) == 0
        assert capsys.readouterr().out == ""

    def test_how_far_a_sweep_is(self, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
        """Two points of theory, done: told by the store alone, and nothing on stdout where there is none."""
        study = tmp_path / "study.toml"
        axis = '[[axes]]\nname = "f"\nkey = "friction.coefficient"\nvalues = [0.9, 1.2]\n'
        study.write_text(f'title = "Two"\nscene = "hertz-paper"\nengines = ["exact"]\nfigures = ["exact.dissipation"]\n{axis}')
        folder = tmp_path / "store"
        assert main(["sweep", str(study), "--out", str(folder), "--workers", "1", "--quiet"]) == 0
        capsys.readouterr()
        assert main(["sweep", "status", str(folder), "--json"]) == 0
        told = json.loads(capsys.readouterr().out)["result"]
        assert told["points"] == {"done": 2, "failed": 0, "running": 0, "waiting": 0, "total": 2}
        assert (told["title"], told["seconds_left"], told["failures"], told["damaged"]) == ("Two", None, [], [])
        assert main(["sweep", "status", str(tmp_path / "nowhere"), "--json"]) == 2
        assert capsys.readouterr().out == ""


class TestProgress:
    def test_time_left_is_that_of_the_part_and_starts_anew_with_the_next(self) -> None:
        clock = iter([0.0, 10.0, 12.0, 14.0, 20.0, 21.0]).__next__
        left = TimeLeft(clock)
        assert left.words(0, 5) == ""
        assert left.words(1, 5) == "8 s left"
        assert left.words(2, 5) == "6 s left"
        assert left.words(0, 5) == ""
        assert left.words(1, 5) == "4 s left"

    def test_nothing_is_said_of_work_without_a_total(self) -> None:
        assert TimeLeft(iter([0.0, 1.0]).__next__).words(3, None) == ""

    def test_piped_lines_are_plain_and_whole(self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        monkeypatch.setattr("reports.console._LINE_EVERY", 0.0)
        stages = Stages()
        with stages.stage("finite elements") as report:
            for done in range(4):
                report(done, 3, f"revolution 1, {100 * done} steps, {250 * done} contact iterations, " + "and more words " * 6)
        lines = capsys.readouterr().err.splitlines()
        assert lines[0] == "finite elements ..."
        assert lines[3].startswith("  finite elements: revolution 1, 200 steps, 500 contact iterations")
        assert "2 of 3 stretches" in lines[3]
        assert len(lines) == 6
        assert not [line for line in lines if "\x1b" in line]
        assert stages.log[0][10:] == "finite elements ..."
        assert "300 steps" in stages.log[1]


class TestTolerance:
    def test_a_share_is_for_four_metrics_and_a_key_for_one(self) -> None:
        assert tolerances_of(()) == {}
        assert tolerances_of(["5%"]) == dict.fromkeys(
            ("dissipation", "largest_pressure", "largest_half_width", "permanent_stick"), 0.05
        )
        assert tolerances_of(["0.1", "shear=3%", "dissipation=0.02"])["shear"] == pytest.approx(0.03)
        assert tolerances_of(["0.1", "dissipation=0.02"])["dissipation"] == 0.02
        assert tolerances_of(["dissipation=0.02", "0.1"])["dissipation"] == 0.1  # the last counts

    @pytest.mark.parametrize(
        ("word", "sentence"),
        [
            ("5 percent", "write a share above 0"),
            ("0", "write a share above 0"),
            ("-5%", "write a share above 0"),
            ("nan", "write a share above 0"),
            ("inf%", "write a share above 0"),
            ("=5%", "unknown metric ''"),
            ("disipation=5%", "unknown metric 'disipation'; did you mean dissipation?"),
            ("shear=x", "write a share above 0"),
        ],
    )
    def test_what_is_none_is_refused_before_anything_is_solved(
        self, word: str, sentence: str, capsys: pytest.CaptureFixture[str]
    ) -> None:
        assert main(["run", "hertz-paper", f"--tolerance={word}"]) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert sentence in line

    def test_a_run_is_judged_by_it_and_says_how_to_repeat_that(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """The coarse mesh is outside the scene's own tolerances; the same mesh, the user's tolerances: within."""
        monkeypatch.chdir(tmp_path)
        given = [
            "--tolerance",
            "50%",
            "pressure=50%",
            "peak_pressure=50%",
            "--tolerance",
            "shear=0.5",
            "contact_edge=1",
            "stick_edge=1",
        ]
        text = scene_text("cattaneo-mindlin").split("[[expected]]")[0]
        Path("mine.toml").write_text(text, encoding="utf-8")
        assert main(["run", "mine.toml", "--quiet", "--json", *COARSE]) == 1
        assert main(["run", "mine.toml", "--quiet", "--json", *COARSE, *given]) == 0
        capsys.readouterr()
        whole = json.loads(Path("out/mine/comparison.json").read_text(encoding="utf-8"))
        assert whole["metrics"]["shear"]["tolerance"] == whole["metrics"]["dissipation"]["tolerance"] == 0.5
        assert "--tolerance 50% pressure=50% peak_pressure=50% shear=0.5 contact_edge=1 stick_edge=1" in whole["command"]


def test_figures_are_written_in_the_formats_that_are_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run", "cattaneo-mindlin", "--quiet", "--plots", "svg", "pdf", *COARSE]) == 1
    plots = {path.name for path in Path("out/cattaneo-mindlin/plots").iterdir()}
    drawn = {path.stem for path in Path("out/cattaneo-mindlin/figures").glob("*.csv")}
    assert plots == {f"{name}.{kind}" for name in drawn for kind in ("svg", "pdf")}
    assert Path("out/cattaneo-mindlin/plots/hysteresis.pdf").read_bytes().startswith(b"%PDF")
    assert "--plots svg pdf" in json.loads(Path("out/cattaneo-mindlin/comparison.json").read_text(encoding="utf-8"))["command"]
    assert main(["run", "cattaneo-mindlin", "--quiet", *COARSE]) == 1
    assert not Path("out/cattaneo-mindlin/plots").exists()  # of an earlier run
    capsys.readouterr()
    assert main(["run", "cattaneo-mindlin", "--plots", "gif"]) == 2
    assert '"pdf", "svg", "png"' in capsys.readouterr().err


class TestCost:
    @pytest.mark.parametrize("name", ["hertz-paper", "cattaneo-mindlin", "unload-reload"])
    def test_increments_are_those_of_the_solution(self, name: str) -> None:
        """To a quarter: how often increments are halved is measured, not known."""
        scene, mesh, settings = load_scene(name), MeshSettings.coarse(), SolverSettings()
        solved = halfplane_fe.solve(scene, mesh=mesh, settings=settings).work.counts["steps solved"]
        assert cost_of(scene, mesh, settings).increments == pytest.approx(solved, rel=0.25)

    def test_the_published_runs_of_the_library_have_the_increments_that_are_stated(self) -> None:
        published = json.loads((ROOT / "reports" / "published" / "values.json").read_text(encoding="utf-8"))["scenes"]
        solved = {name: published[name]["frozen"]["halfplane_fe.counts.steps_solved"] for name in scene_names()}
        stated = {name: cost_of(load_scene(name), MeshSettings(), SolverSettings()).increments for name in solved}
        over = {name: stated[name] / solved[name] for name in solved}
        assert not {name: ratio for name, ratio in over.items() if not 0.45 < ratio < 3}
        assert sum(3 / 4 < ratio < 4 / 3 for ratio in over.values()) >= 27
        assert over["hertz-normal"] == over["cylinder-roller-frictionless"] == 1  # nothing is halved: they can be counted

    def test_it_follows_steps_mesh_and_rows(self) -> None:
        scene = load_scene("hertz-paper")
        plain = cost_of(scene, MeshSettings(), SolverSettings())
        fine = cost_of(scene, MeshSettings.fine(), SolverSettings())
        many = cost_of(scene, MeshSettings(), SolverSettings(steps_per_cycle=960))
        assert plain.seconds < LONG < fine.seconds
        assert many.increments > plain.increments + 1500
        assert fine.memory > 2 * plain.memory
        # A record keeps 4,000 instants, whatever its length; ten times the rows take ten times the seconds, not the memory.
        long, longer = (
            cost_of(scene.vary(load=TimeSeriesLoad(rows=rows)), MeshSettings(), SolverSettings())
            for rows in ([[k, 90 + k % 2, 0] for k in range(n)] for n in (1000, 10_000))
        )
        assert longer.seconds > 8 * long.seconds
        assert longer.memory < 4 * long.memory

    def test_a_long_run_of_real_bodies_measures_no_uncertainty_unless_asked_and_says_so(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        """Before the work on the terminal, after it in the notes; never where the budget was asked for or left out by the user."""
        scene = tmp_path / "pad.toml"
        main(["init", str(scene), "--bodies", "--quiet"])
        monkeypatch.setattr("halfplane_fe.solve", lambda *_, **__: semi_analytic.solve(scene))
        monkeypatch.setattr("reports.comparison.budget.climb", lambda *_: pytest.fail("a budget was measured"))
        capsys.readouterr()
        for seconds, words, said in ((120.0, ["--no-budget"], False), (0.0, ["--no-budget"], False), (0.0, [], True)):
            monkeypatch.setattr("reports.cli.solving._LONG_FOR_A_BUDGET", seconds)
            main(["run", str(scene), "--out", str(tmp_path / "out"), "--no-coarse-mesh", "--json", *words])
            shown = capsys.readouterr()
            pattern = r"no uncertainty was measured: it would take about \d+ s more; --budget measures it"
            assert bool(re.search(pattern, shown.err)) is said
            notes = json.loads(shown.out)["result"]["notes"]
            assert any(re.fullmatch(rf"N{pattern[1:]}\.", note) for note in notes) is said
            assert ("No uncertainty was measured: it would take" in (tmp_path / "out" / "report.html").read_text("utf-8")) is said
        for seconds, words in ((120.0, []), (0.0, ["--budget"])):
            monkeypatch.setattr("reports.cli.solving._LONG_FOR_A_BUDGET", seconds)
            with pytest.raises(pytest.fail.Exception, match="a budget was measured"):
                main(["run", str(scene), "--out", str(tmp_path / "out"), "--no-coarse-mesh", "--quiet", *words])

    def test_long_work_is_announced_and_short_work_is_not(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
    ) -> None:
        monkeypatch.setattr("halfplane_fe.solve", lambda *_, **__: semi_analytic.solve(load_scene("hertz-normal")))
        for words, announced in (([], False), (["--edge-element-size", "0.0002"], True)):
            main(["fe", "hertz-normal", "--out", str(tmp_path / "out"), *words])
            told = [line for line in capsys.readouterr().err.splitlines() if " increments, " in line]
            assert bool(told) is announced
        assert re.fullmatch(
            r"finite elements: about [\d,]+ increments, \d+ (s|min), .* of memory \(an order of magnitude\)", told[0]
        )
