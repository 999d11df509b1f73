"""The command line as a person uses it: a process of its own, started in an empty folder."""

import json
import os
import re
import signal
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from reports.cli import main
from reports.cli.application import app
from reports.folder import claim
from scenes import ContactSolution, ConvergenceError, Record, freeze, load_scene, scene_names
from test_reports_synthetic import cattaneo_mindlin

ROOT = Path(__file__).parents[1]
# The slightest mesh and steps that still go through both engines: a second, and far outside every tolerance.
COARSE = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.25", "--steps-per-cycle", "8")


def environment() -> dict[str, str]:
    """This checkout on the path, whether it is installed or not; tables so wide that nothing is broken."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return os.environ | {"PYTHONPATH": path, "COLUMNS": "400", "NO_COLOR": "1"}


def halfplane(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "reports", *arguments]
    return subprocess.run(command, cwd=folder, env=environment(), capture_output=True, text=True, timeout=120, check=False)


def everything(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


def refused(folder: Path, *arguments: str) -> str:
    """The one sentence on stderr of a command that must end with 2, print nothing else and leave no new file."""
    before = everything(folder)
    done = halfplane(folder, *arguments)
    assert done.returncode == 2, done
    assert done.stdout == ""
    lines = done.stderr.strip().splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("halfplane: ")
    assert "Traceback" not in done.stderr
    assert everything(folder) == before
    return lines[0]


def interrupt(process: subprocess.Popen[str]) -> str:
    """What stderr says after Ctrl-C; pressed again as a person would where the process goes on (a library may drop the first)."""
    for _ in range(4):
        process.send_signal(signal.SIGINT)
        try:
            return process.communicate(timeout=15)[1]
        except subprocess.TimeoutExpired:
            continue
    process.kill()
    return process.communicate()[1]


class TestHelp:
    def test_help_names_every_command_with_examples(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "--help")
        assert done.returncode == 0
        for command in ("run", "exact", "fe", "fields", "scenes", "init", "check", "schema", "doctor"):
            assert f" {command} " in done.stdout
        assert "halfplane run hertz-paper" in done.stdout
        assert "130 interrupted" in done.stdout

    def test_help_loads_nothing_heavy(self, tmp_path: Path) -> None:
        """What makes help fast, of every command too: none of these is imported. A time would depend on the machine."""
        heavy = {"numpy", "scipy", "pydantic", "xarray", "matplotlib", "skfem", "gmsh", "jinja2", "pyvista", "pandas"}
        program = (
            "import sys\nfrom reports.cli import main\nfrom reports.cli.application import app\n"
            "code = main(['--help']) + sum(main([*name.split(), '--help']) for name in [*app, 'sweep status'] if name[0] != '-')\n"
            f"print('loaded:', *sorted({heavy!r} & set(sys.modules)))\nsys.exit(code)"
        )
        done = subprocess.run(
            [sys.executable, "-c", program], cwd=tmp_path, env=environment(), capture_output=True, text=True, check=True
        )
        assert done.stdout.splitlines()[-1] == "loaded:"

    def test_options_of_run_are_explained(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "run", "--help")
        assert done.returncode == 0
        for option in ("--out", "--vtu", "--element-size", "--steps-per-cycle", "--method", "--quiet"):
            assert option in done.stdout

    def test_version(self, tmp_path: Path) -> None:
        assert halfplane(tmp_path, "--version").stdout.strip()


class TestScenes:
    def test_library(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "scenes")
        assert done.returncode == 0
        for name in scene_names():
            assert name in done.stdout
            assert load_scene(name).title in done.stdout

    def test_a_new_scene_is_admissible_and_complete(self, tmp_path: Path) -> None:
        """init, then check; the file shows every table of a scene and is never overwritten."""
        assert halfplane(tmp_path, "init", "my.toml").returncode == 0
        written = (tmp_path / "my.toml").read_text(encoding="utf-8")
        assert {"material", "profile", "friction", "load"} <= tomllib.loads(written).keys()
        stated = re.sub(r"(?m)^# ", "", written[written.index("# [tolerances]") :].split("\n\n")[0])
        assert set(tomllib.loads(stated)["tolerances"]) == set(load_scene(tmp_path / "my.toml").tolerances.model_dump())
        assert halfplane(tmp_path, "check", "my.toml").returncode == 0
        assert "my.toml: the file is there already" in refused(tmp_path, "init", "my.toml")
        assert (tmp_path / "my.toml").read_text(encoding="utf-8") == written

    def test_what_the_example_has_in_comments_is_right_too(self, tmp_path: Path) -> None:
        """The flat face and the polygon that the file only mentions: comment signs moved, still a scene."""
        halfplane(tmp_path, "init", "my.toml")
        text = (tmp_path / "my.toml").read_text(encoding="utf-8")
        text = text.replace('kind = "hertz"', '# kind = "hertz"').replace('# kind = "flat_rounded"', 'kind = "flat_rounded"')
        text = text.replace("# flat_half_length", "flat_half_length")
        start, end = text.index('kind = "ellipse"'), text.index('# kind = "polygon"')
        tail = (
            text[end:]
            .replace("# kind", "kind", 1)
            .replace("# initial_loading", "initial_loading", 1)
            .replace("# cycle", "cycle", 1)
        )
        (tmp_path / "other.toml").write_text(text[:start] + tail, encoding="utf-8")
        scene = load_scene(tmp_path / "other.toml")
        assert (scene.profile.kind, scene.load.kind) == ("flat_rounded", "polygon")

    def test_the_example_with_bodies(self, tmp_path: Path) -> None:
        """--bodies takes the comment signs away before the tables of bodies, and nothing else."""
        assert halfplane(tmp_path, "init", "plain.toml").returncode == 0
        assert halfplane(tmp_path, "init", "bodies.toml", "--bodies").returncode == 0
        plain, real = load_scene(tmp_path / "plain.toml"), load_scene(tmp_path / "bodies.toml")
        assert plain.bodies.half_planes
        assert (real.bodies.lower.kind, real.bodies.upper.kind) == ("block", "pad")
        assert real.vary(bodies=plain.bodies, name=plain.name) == plain
        assert "goes with the commented example" in refused(tmp_path, "init", "x.toml", "--bodies", "--from", "hertz-paper")

    def test_schema_explains_the_keys_of_bodies(self, tmp_path: Path) -> None:
        defined = json.loads(halfplane(tmp_path, "schema").stdout)["$defs"]
        assert set(defined["Block"]["properties"]) == {"kind", "width", "height", "base", "sides"}
        for kind in ("Block", "Pad", "Cylinder"):
            keys = defined[kind]["properties"]
            assert all(keys[key].get("description") for key in keys if key != "kind")

    @pytest.mark.parametrize("name", scene_names())
    def test_library_scenes_can_be_started_from(self, tmp_path: Path, name: str) -> None:
        assert halfplane(tmp_path, "init", "my.toml", "--from", name).returncode == 0
        assert load_scene(tmp_path / "my.toml").load == load_scene(name).load

    def test_init_wants_toml_and_a_folder(self, tmp_path: Path) -> None:
        assert "my.json: a commented scene is written as .toml" in refused(tmp_path, "init", "my.json")
        assert "can't be written: No such file or directory" in refused(tmp_path, "init", "nowhere/my.toml")
        assert "no such scene" in refused(tmp_path, "init", "my.toml", "--from", "hertz-papr")

    def test_check_says_how_near_gross_sliding_is(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "check", "cattaneo-mindlin")
        assert done.returncode == 0
        assert "|Q|/(f P) is at most 0.6, in the cycle at time 2 " in done.stdout

    def test_schema_is_json_with_every_table(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "schema")
        assert done.returncode == 0
        assert {"material", "profile", "friction", "load", "tolerances"} <= json.loads(done.stdout)["properties"].keys()

    def test_doctor_looks_at_everything(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "doctor")
        assert done.returncode == 0, done.stdout
        for check in ("Python", "packages", "gmsh", "off-screen rendering", "output folder", "threads"):
            assert check in done.stdout
        assert everything(tmp_path) == set()


GOOD = """
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[profile]
kind = "hertz"
radius = 1000.0
[friction]
coefficient = 0.5
[load]
kind = "ellipse"
mean_normal_load = 90.0
normal_amplitude = 30.0
tangential_amplitude = 20.0
"""

# fault -> (text to replace, its replacement, words that the sentence must hold: the key, the value, the rule)
BAD = {
    "unknown key": ("radius", "radias", ("profile.radias", "1000.0", "unknown key")),
    "unknown table": ("[friction]", "[fiction]", ("fiction", "unknown key")),
    "missing key": ("poisson_ratio = 0.3", "", ("poisson_ratio", "missing")),
    "missing table": ("[friction]\ncoefficient = 0.5", "", ("friction", "missing")),
    "wrong type": ("210e3", '"stiff"', ("young_modulus", "'stiff'", "number")),
    "negative friction": (
        "coefficient = 0.5",
        "coefficient = -0.1",
        ("friction.coefficient", "-0.1", "greater than or equal to 0"),
    ),
    "nu too large": ("0.3", "0.5", ("poisson_ratio", "0.5", "less than 0.5")),
    "nu too small": ("0.3", "-1.0", ("poisson_ratio", "-1.0", "greater than -1")),
    "not a number": ("210e3", "nan", ("young_modulus", "nan", "finite")),
    "gross sliding": (
        "tangential_amplitude = 20.0",
        "tangential_amplitude = 60.0",
        ("gross sliding from time", "P = ", "friction.coefficient"),
    ),
    "separation": ("normal_amplitude = 30.0", "normal_amplitude = 95.0", ("separation from time", "P is not positive")),
    "shear without friction": ("coefficient = 0.5", "coefficient = 0.0", ("gross sliding", "f = 0")),
    "not TOML": ("[load]", "[load", ("not valid TOML",)),
    "empty": (GOOD, " \n", ("is empty",)),
}


class TestBadInput:
    @pytest.mark.parametrize("fault", BAD)
    def test_scene_is_refused_in_a_sentence(self, tmp_path: Path, fault: str) -> None:
        text, replacement, words = BAD[fault]
        assert text in GOOD
        (tmp_path / "bad.toml").write_text(GOOD.replace(text, replacement), encoding="utf-8")
        sentence = refused(tmp_path, "run", "bad.toml")
        assert sentence.startswith("halfplane: bad.toml: ")
        for word in words:
            assert word in sentence

    def test_the_scene_that_they_start_from_is_good(self, tmp_path: Path) -> None:
        (tmp_path / "good.toml").write_text(GOOD, encoding="utf-8")
        assert halfplane(tmp_path, "check", "good.toml").returncode == 0

    def test_files_that_can_not_be_read(self, tmp_path: Path) -> None:
        (tmp_path / "folder.toml").mkdir()
        (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00scene")
        assert "folder.toml: the scene file can't be read" in refused(tmp_path, "run", "folder.toml")
        assert "binary.toml: the scene file can't be read" in refused(tmp_path, "run", "binary.toml")
        assert "nowhere.toml: the scene file can't be read: No such file" in refused(tmp_path, "run", "nowhere.toml")

    def test_unknown_scene_command_option(self, tmp_path: Path) -> None:
        assert "did you mean hertz-paper?" in refused(tmp_path, "run", "hertz-papr")
        assert "there is no command 'rum'; did you mean run? " in refused(tmp_path, "rum", "hertz-paper")
        assert "--elment-size" in refused(tmp_path, "run", "hertz-paper", "--elment-size", "0.1")
        assert "extra" in refused(tmp_path, "run", "hertz-paper", "extra")
        assert "run: SCENE is missing" in refused(tmp_path, "run")

    def test_option_values(self, tmp_path: Path) -> None:
        assert "element_size = 0.5 is refused" in refused(tmp_path, "run", "hertz-paper", "--quiet", "--element-size", "0.5")
        assert "--order" in refused(tmp_path, "run", "hertz-paper", "--order", "two")
        assert "--method" in refused(tmp_path, "run", "hertz-paper", "--method", "magic")
        assert "--vtu soon" in refused(tmp_path, "run", "hertz-paper", "--vtu", "soon")

    def test_options_that_go_with_another(self, tmp_path: Path) -> None:
        """It was ignored."""
        assert "it goes with --third calculix" in refused(tmp_path, "run", "hertz-paper", "--third-limit", "10")

    def test_out_is_found_unusable_before_any_solving(self, tmp_path: Path) -> None:
        """No stage is announced on stderr: the sentence comes first and alone."""
        (tmp_path / "file").write_text("mine", encoding="utf-8")
        (tmp_path / "taken").mkdir()
        (tmp_path / "taken" / "report.html").write_text("mine", encoding="utf-8")
        for command in ("run", "exact", "fe", "fields"):
            assert "--out file: this is a file" in refused(tmp_path, command, "hertz-paper", "--out", "file")
        assert "can't be written to" in refused(tmp_path, "run", "hertz-paper", "--out", "/proc/halfplane")
        assert "can't be written to" in refused(tmp_path, "run", "hertz-paper", "--out", "file/below")
        assert "report.html is there already" in refused(tmp_path, "run", "hertz-paper", "--out", "taken")


class TestExitCodes:
    def test_outside_tolerance_is_1_and_the_report_is_there(self, tmp_path: Path) -> None:
        done = halfplane(tmp_path, "run", "hertz-paper", *COARSE)
        assert done.returncode == 1, done.stderr
        page = done.stdout.strip().splitlines()[-1]
        assert page == "out/hertz-paper/report.html"
        stored = json.loads((tmp_path / "out" / "hertz-paper" / "comparison.json").read_text(encoding="utf-8"))
        assert stored["verdict"]["passed"] is False
        assert "outside" in done.stdout
        assert stored["command"] == (
            "halfplane run hertz-paper --element-size 0.25 --edge-element-size 0.25 --order 1 --steps-per-cycle 8 "
            "--out out/hertz-paper"
        )
        assert everything(tmp_path) >= {"out/hertz-paper/report.html", "out/hertz-paper/result.nc"}

    def test_within_tolerance_is_0(self, tmp_path: Path) -> None:
        """The same coarse run, with tolerances that it meets, stated in the scene."""
        (tmp_path / "wide.toml").write_text(
            GOOD + "[tolerances]\n" + "\n".join(f"{name} = 10.0" for name in load_scene("hertz-paper").tolerances.model_dump()),
            encoding="utf-8",
        )
        done = halfplane(tmp_path, "run", "wide.toml", "--quiet", *COARSE)
        assert done.returncode == 0, done.stdout + done.stderr
        assert done.stderr == ""
        assert "within all 8 tolerances" in done.stdout

    @pytest.mark.parametrize("command", ["run", "fe"])
    def test_not_converged_is_3_and_keeps_what_was_solved(
        self, command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """An engine that fails after the first revolution's first steps, whatever would make it fail."""
        partial = cattaneo_mindlin(
            steps_per_leg=4, points=21, record=Record(False, "not converged", "stuck", freeze([0] * 13, int))
        )
        self.fail_with(ConvergenceError("stuck at time 2.5", partial), monkeypatch)
        monkeypatch.chdir(tmp_path)
        assert main([command, "cattaneo-mindlin", "--quiet"]) == 3
        shown = capsys.readouterr()
        assert "halfplane: cattaneo-mindlin: not converged: stuck at time 2.5" in shown.err
        assert "stuck" in shown.out
        folder = tmp_path / "out" / "cattaneo-mindlin"
        assert shown.out.strip().splitlines()[-1] == "out/cattaneo-mindlin/partial.nc"
        assert {path.name for path in folder.iterdir()} >= {"partial.nc", "partial.json", "partial.csv", "scene.json"}
        assert not (folder / "report.html").exists()
        assert json.loads((folder / "partial.json").read_text(encoding="utf-8"))["converged"] is False
        assert ContactSolution.load(folder / "partial.nc").time[-1] == partial.time[-1]

    def test_not_converged_at_the_first_step(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        self.fail_with(ConvergenceError("stuck at once"), monkeypatch)
        monkeypatch.chdir(tmp_path)
        assert main(["run", "cattaneo-mindlin", "--quiet"]) == 3
        assert "no step was solved, so nothing was written" in capsys.readouterr().err
        assert everything(tmp_path) == set()

    def fail_with(self, failure: ConvergenceError, monkeypatch: pytest.MonkeyPatch) -> None:
        def solve(*_: object, **__: object) -> None:
            raise failure

        monkeypatch.setattr("halfplane_fe.solve", solve)

    def test_interrupted_is_130_and_leaves_nothing_half_written(self, tmp_path: Path) -> None:
        command = [sys.executable, "-m", "reports", "run", "hertz-paper", "--steps-per-cycle", "20000"]
        with subprocess.Popen(
            command, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith("finite elements"):
                    break
            rest = interrupt(process)
        assert process.returncode == 130
        assert "Traceback" not in rest
        # Before the first step there is nothing to keep; after it the steps are.
        if "interrupted; nothing was written" in rest:
            assert everything(tmp_path) == set()
        else:
            assert (tmp_path / "out" / "hertz-paper" / "partial.nc").exists()

    def test_one_engine_alone(self, tmp_path: Path) -> None:
        exact = halfplane(tmp_path, "exact", "cattaneo-mindlin", "--quiet")
        assert exact.returncode == 0, exact.stderr
        assert exact.stdout.strip().splitlines()[-1] == "out/cattaneo-mindlin/semi_analytic.nc"
        alone = halfplane(tmp_path, "fe", "cattaneo-mindlin", "--quiet", *COARSE)
        # Admissible, but on so coarse a mesh a number that the scene expects of the default one is missed, and said to be.
        assert alone.returncode == 1, alone.stderr
        assert "of 3 expected numbers are missed" in alone.stdout
        files = {path.name for path in (tmp_path / "out" / "cattaneo-mindlin").iterdir()}
        assert files >= {"semi_analytic.nc", "semi_analytic.json", "semi_analytic.csv", "halfplane_fe.nc", "scene.json"}


class TestInternalErrors:
    """An exception that nobody expected: exit code 70, one sentence, and the traceback in a file that the sentence names."""

    SENTENCE = "halfplane: internal error, a fault of halfplane: ZeroDivisionError: planted; the traceback is in "

    @pytest.fixture(autouse=True)
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    @staticmethod
    def planted(*_: object, **__: object) -> None:
        raise ZeroDivisionError("planted")

    def told(self, capsys: pytest.CaptureFixture[str]) -> str:
        """The file that the one sentence on stderr names, and that holds the traceback."""
        shown = capsys.readouterr()
        (line,) = shown.err.splitlines()
        assert line.startswith(self.SENTENCE)
        name = line.removeprefix(self.SENTENCE).removesuffix(": please report it")
        text = Path(name).read_text(encoding="utf-8")
        assert "Traceback (most recent call last):" in text
        assert text.rstrip().endswith("ZeroDivisionError: planted")
        return name

    @pytest.mark.parametrize("name", [name for name in app if not name.startswith("-")])
    def test_at_every_command(self, name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
        def fails() -> None:
            self.planted()

        monkeypatch.setattr(app[name], "default_command", fails)
        assert main([name]) == 70
        kept = Path(self.told(capsys))
        assert kept.parent == Path.cwd()
        assert f"  halfplane {name}\n" in kept.read_text(encoding="utf-8")

    def test_the_output_folder_has_it_and_is_used_again(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """Beside what an earlier run left there, one below the other; a later run takes the folder as before."""
        asked = ["exact", "cattaneo-mindlin", "--quiet", "--out", "here"]
        assert main(asked) == 0
        before = everything(Path("here"))
        capsys.readouterr()
        with monkeypatch.context() as patch:
            patch.setattr("semi_analytic.solve", self.planted)
            for count in (1, 2):
                assert main(asked) == 70
                assert self.told(capsys) == "here/run.log"
                assert Path("here/run.log").read_text(encoding="utf-8").count("Traceback") == count
        assert everything(Path("here")) == before | {"run.log"}
        assert everything(Path.cwd()) == {"here", *(f"here/{name}" for name in everything(Path("here")))}
        assert main(asked) == 0

    def test_the_folder_of_another_command_is_left_alone(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        """One that a script claimed before it called the command line: it got the traceback of a command without a folder."""
        claim("other")
        monkeypatch.setattr("reports.cli.machine.examine", self.planted)
        assert main(["doctor"]) == 70
        assert Path(self.told(capsys)).parent == Path.cwd()
        assert not Path("other").exists()

    @pytest.mark.parametrize("words", ["run", "fe", "fields --at 1 --no-pictures"])
    def test_no_answer_is_left_half_written(
        self, words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setattr("halfplane_fe.solve", self.planted)
        command, *options = words.split()
        assert main([command, "cattaneo-mindlin", *options, "--quiet"]) == 70
        assert self.told(capsys) == "out/cattaneo-mindlin/run.log"
        assert {path.name for path in Path("out/cattaneo-mindlin").iterdir()} == {"run.log", "manifest.json"}

    def test_where_no_file_can_be_written_it_is_on_stderr(
        self, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
    ) -> None:
        def full(*_: object, **__: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("semi_analytic.solve", self.planted)
        monkeypatch.setattr("reports.folder.filled", full)
        assert main(["exact", "cattaneo-mindlin", "--quiet", "--out", "here"]) == 70
        assert Path(self.told(capsys)).parent == Path.cwd()
        monkeypatch.setattr("tempfile.mkstemp", full)
        assert main(["exact", "cattaneo-mindlin", "--quiet", "--out", "here"]) == 70
        shown = capsys.readouterr().err
        assert "Traceback (most recent call last):" in shown
        assert shown.splitlines()[-1].endswith("ZeroDivisionError: planted; the traceback is above: please report it")

    def test_of_a_process(self, tmp_path: Path) -> None:
        """No traceback on the terminal, nothing on stdout; a message of many lines is one short one."""
        program = (
            "import sys, semi_analytic, reports.cli\n"
            "def fails(*_, **__): raise KeyError('many\\nlines ' * 99)\n"
            "semi_analytic.solve = fails\n"
            "sys.argv = ['halfplane', 'exact', 'cattaneo-mindlin', '--quiet']\n"
            "sys.exit(reports.cli.main())\n"
        )
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=120, check=False)
        assert (done.returncode, done.stdout) == (70, "")
        (line,) = done.stderr.splitlines()
        assert len(line) < 400
        assert "; the traceback is in out/cattaneo-mindlin/run.log: please report it" in line
        assert "KeyError" in (tmp_path / "out" / "cattaneo-mindlin" / "run.log").read_text(encoding="utf-8")
