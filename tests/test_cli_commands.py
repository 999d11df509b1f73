"""The command line as a person or a program uses it: what is refused, exit codes, JSON, progress,
help, colours.
"""

from __future__ import annotations

import json
import re
import shlex
import tomllib
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pandas as pd
import pytest

import semi_analytic
from command_line import (
    COARSE,
    HERTZ_SCENE,
    ROOT,
    Done,
    answer_of,
    answer_schema,
    everything,
    halfplane,
    json_of,
    raising,
    refused,
    start,
)
from refusals import require_facts
from reports.cli.application import FORMAT, app
from reports.cli.machine import Finding, drawing
from reports.console import Stages, TimeLeft, show_table
from reports.folder import usable_folder
from reports.studies.paper.page import PaperReport
from reports.studies.paper.tables import Misprint, Statement, Verdict
from scenes import (
    ContactSolution,
    ConvergenceError,
    Record,
    load_scene,
    read_only_copy,
    scene_names,
    scene_text,
)
from score_results import exact, rows, written
from test_reports_sweep import Bench
from test_reports_synthetic import cattaneo_mindlin

NAMES = [name for name in app if not name.startswith("-")]
ABAQUS = ROOT / "docs" / "examples" / "score" / "abaqus"
GOOD = (
    HERTZ_SCENE
    + """[load]
kind = "ellipse"
mean_normal_load = 90.0
normal_amplitude = 30.0
tangential_amplitude = 20.0
"""
)
STUDY = """
title = "Friction"
scene = "hertz-paper"
engines = ["exact"]
figures = ["exact.dissipation"]
[[axes]]
name = "f"
key = "friction.coefficient"
values = [1.0, 1.2]
"""

# ----------------------------------------------------------------------------------------- refusals
# Files in the folder where the commands below are given; test_scenes_reading.py has every fault of
# a scene file.
SPOILT = {
    "sliding.toml": GOOD.replace("tangential_amplitude = 20.0", "tangential_amplitude = 60.0"),
    "separating.toml": GOOD.replace("= 30.0", "= 95.0").replace("= 20.0", "= 0.0"),
    "smooth.toml": GOOD.replace("coefficient = 0.5", "coefficient = 0.0"),
    "tilted.toml": GOOD + "tilt = 1e-4\n",
    "misspelt.toml": GOOD.replace("radius", "radias"),
    "broken.toml": GOOD.replace("[load]", "[load"),
    "good.toml": GOOD,
    "study.toml": STUDY,
    "file": "mine",
    "taken/report.html": "mine",
    "taken/README.md": "mine",
    "theory/semi_analytic.csv": "mine",
    "elements/halfplane_fe.nc": "mine",
    "stopped/partial.json": "mine",
    "deck/hertz-paper_calculix.inp": "mine",
    "folder.toml/empty": "",
    "far.toml": (ABAQUS / "mapping.toml").read_text(encoding="utf-8").replace("1.4978", "14.978"),
    "tiny.toml": "factors.load = 1e-300",
    "thick.toml": "thickness = 1e308",
    "pulled.toml": 'signs.pressure = "compression negative"',
    "path.rpt": (ABAQUS / "path.rpt").read_text(encoding="utf-8"),
}
FOREIGN = "halfplane did not write it"
# Words of a command -> what its refusal names; without --quiet a stage that is announced would be a
# second line, so nothing was begun.
REFUSED = {
    "rnu": ["there is no command 'rnu'", "did you mean run?"],
    "zzz": ["'zzz'", "`halfplane --help`"],
    "run blocks --elment-size 1": ["--elment-size", "--element-size?", "`halfplane run --help`"],
    "exact blocks --qiet": ["--qiet", "--quiet?", "`halfplane exact --help`"],
    "--zzz": ["there is no option '--zzz'"],
    "run blocks --zzz=1": ["no option --zzz"],
    "run": ["SCENE is missing", "`halfplane run --help`"],
    "run blocks more words": ["'more words'"],
    "sweep statsu out": ["'out'", "did you mean status?"],
    "sweep study.toml out": ["'out'"],
    "sweep run study.toml": ["'study.toml'", "`halfplane sweep study.toml`"],
    "export": ["SCENE is missing"],
    "run misspelt.toml": ["misspelt.toml", "profile.radias = 1000.0"],
    "run broken.toml": ["broken.toml", "not valid TOML"],
    "run sliding.toml": ["sliding.toml", "load", "gross sliding from time"],
    "exact separating.toml": ["separating.toml", "load", "separation from time"],
    "check smooth.toml": ["smooth.toml", "f = 0"],
    "run folder.toml": ["folder.toml", "can't be read"],
    "run binary.toml": ["binary.toml", "can't be read"],
    "run nowhere.toml": ["nowhere.toml", "No such file"],
    "run hertz-papr": ["hertz-papr", "did you mean hertz-paper?"],
    "run hertz-paper --quiet --element-size 0.5": ["element_size = 0.5"],
    "run hertz-paper --order two": ["--order"],
    "run hertz-paper --method magic": ["--method"],
    "run hertz-paper --vtu soon": ["--vtu soon"],
    "run hertz-paper --plots svg": ["--plots"],
    **{
        f"run hertz-paper --tolerance={word}": [word.removeprefix("shear="), "a share above 0"]
        for word in ("5_percent", "0", "-5%", "nan", "inf%", "shear=x")
    },
    "run hertz-paper --tolerance=5": ["--tolerance 5", "500 %", "5%"],
    "run hertz-paper --tolerance=dissipation=2": ["200 %", "dissipation=2%"],
    "run hertz-paper --tolerance==5%": ["unknown metric ''"],
    "run hertz-paper --tolerance=disipation=5%": ["'disipation'", "did you mean dissipation?"],
    **{
        f"{command} hertz-paper --out file": ["--out file", "a file"]
        for command in ("run", "exact", "fe", "fields")
    },
    "run hertz-paper --out /proc/halfplane": ["/proc/halfplane", "can't be written to"],
    "run hertz-paper --out file/below": ["file/below", "can't be written to"],
    "run hertz-paper --out taken": ["taken", "report.html", FOREIGN],
    "exact hertz-paper --out theory": ["semi_analytic.csv", FOREIGN],
    "fe hertz-paper --out elements": ["halfplane_fe.nc", FOREIGN],
    "fe hertz-paper --out stopped": ["partial.json", FOREIGN],
    "export hertz-paper --out deck": ["hertz-paper_calculix.inp", FOREIGN],
    # As of --out "$FOLDER" where that is not set: results went to the current folder.
    "exact hertz-paper --out=": ["arguments is empty"],
    "exact hertz-paper --out ''": ["arguments is empty"],
    f"exact hertz-paper --out {300 * 'x'}": ["File name too long"],
    f"check {300 * 'x'}": ["no such scene or file"],
    f"init {300 * 'x'}.toml": ["File name too long"],
    "init good.toml": ["good.toml", "there already"],
    "init my.json": ["my.json", ".toml"],
    "init nowhere/my.toml": ["nowhere/my.toml", "No such file or directory"],
    "init my.toml --from hertz-papr": ["hertz-papr", "no such scene"],
    "init my.toml --bodies --from hertz-paper": ["--bodies", "commented example"],
    "init my.toml --profile flat_rounded --from hertz-paper": ["--profile", "commented example"],
    "init link.toml": ["link.toml", "there already"],
    "advise blocks --limit 5": ["--limit 5", "0.05"],
    "advise blocks --limit 500%": ["--limit 500%"],
    "advise blocks --limit 0": ["--limit 0", "above 0 and below 1"],
    "fields blocks --frames 2.7": ["--frames", "'2.7'", "whole number"],
    "run blocks --steps-per-cycle 2.7": ["--steps-per-cycle", "'2.7'", "whole number"],
    "fields hertz-paper --at soon": ["--at soon", "times"],
    "fields hertz-paper --at 99": ["--at 99", "outside"],
    "fields hertz-paper --frames 1": ["--frames 1", "2 instants"],
    "fields hertz-paper --every 0": ["--every 0"],
    "fields hertz-paper --findley -1": ["--findley -1", "above 0"],
    "fields hertz-paper --critical-distance -1": ["--critical-distance -1", "above 0"],
    "fields hertz-paper --frames 9 --every 2": ["--frames", "--every", "one of the two"],
    "advise cylinder-roller-frictionless": ["nothing is dissipated", "friction.coefficient = 0"],
    "map atlantis": ["atlantis", "known: block"],
    # before anything is solved
    "map pair --out taken --quiet": ["README.md", FOREIGN],
    "map all --pages --out maps": ["no map has its tables here"],
    "paper --out taken --quiet": [FOREIGN],
    # it meant all cores, and said nothing
    "sweep study.toml --workers 0 --out out": ["--workers 0", "at least 1"],
    "sweep status nowhere --json": ["nowhere"],
    "scenes --tag papier": ["papier", "no such tag", "paper, "],
    "scenes hertz-papr": ["did you mean hertz-paper?"],
    "scenes hertz-paper --tag paper": ["one of the two"],
    "score": ["name the result to score"],
    "score mine.csv": ["mine.csv", "--scene"],
    "score none.csv --scene hertz-paper": ["none.csv", "no such file"],
    "score mine.csv --scene hertz-papr": ["did you mean hertz-paper"],
    "score mine.csv --quiet --scene cattaneo-mindlin": ["history is not the scene's"],
    "score mine.csv --scene hertz-paper --tolerance sheer=5%": ["'sheer'"],
    # What a mapping states of a whole file, where nothing is left to score. Ten times the offset
    # that is right was a division by zero that ended like a result outside tolerance; times of
    # another clock: the loads tell the instants.
    **{
        f"score {file} --quiet --mapping {mapping}.toml --scene cattaneo-mindlin": facts
        for file, mapping, facts in (
            ("path.rpt", "far", ["-14.978 to -11.9824", "from -1 to 1", "x_offset"]),
            ("late.csv", "tiny", ["late.csv", "instant 1 is at time"]),
            ("late.csv", "thick", ["thick.toml", "thickness", "1e+308"]),
            ("pushed.csv", "pulled", ["no point is in compression", "sign"]),
        )
    },
}


@pytest.fixture(scope="module")
def spoilt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("spoilt")
    for name, text in SPOILT.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "link.toml").symlink_to(folder / "nowhere")
    (folder / "binary.toml").write_bytes(b"\xff\xfe\x00scene")
    table = rows(exact("cattaneo-mindlin", 3, 21))
    written(rows(exact("hertz-paper", 13, 53)).drop(columns="time"), folder / "mine.csv")
    written(table, folder / "pushed.csv")
    written(table.assign(time=table["time"] + 1e3), folder / "late.csv")
    return folder


@pytest.mark.parametrize("words", REFUSED)
def test_what_is_refused_is_one_sentence_with_2_and_no_file(words: str, spoilt: Path) -> None:
    require_facts(refused(spoilt, *shlex.split(words)), *REFUSED[words])


# --------------------------------------------------------------------------------------------- help


# Modules that make what needs none of them fast: not one is imported. A time would depend on the
# machine.
HEAVY = {"numpy", "scipy", "pydantic", "xarray", "matplotlib", "skfem", "gmsh", "jinja2", "pyvista"}
NOT_FOR_BOTH_ENGINES = {f"scipy.{part}" for part in ("optimize", "interpolate", "special", "fft")}
NOT_FOR_BOTH_ENGINES |= {"xarray", "pandas", "h5py", "meshio", "rich", "matplotlib", "jinja2"}
OF_OTHER_SCENES = {"semi_analytic.grid", "semi_analytic.odd_memory", "halfplane_fe.mortar"}
OF_OTHER_SCENES |= {"halfplane_fe.kernel_bodies", "halfplane_fe.return_mapping"}
OF_OTHER_SCENES |= {"scenes.text_tables", "scenes.fitting", "scenes.height_slopes"}
# What importing theory, importing both engines, and then solving, saving and reading load of what
# they do not need: to import xarray takes longer than a solve and its file.
ENGINES = f"""
import sys
def print_loaded(names):
    print("loaded:", *sorted(names & set(sys.modules)))
import semi_analytic
print_loaded({{"scipy.linalg", "skfem", "gmsh"}})
import halfplane_fe, scenes
print_loaded({NOT_FOR_BOTH_ENGINES!r})
semi_analytic.solve("hertz-paper", x=[0.0], time=[2.0], fields="pressure").save("a.nc")
scenes.ContactSolution.load("a.nc")
halfplane_fe.solve
print_loaded({{"xarray", "pandas", "dask", "scipy.optimize"}} | {OF_OTHER_SCENES!r})
"""
HELP_OF_ALL = f"""
import sys
from reports.cli import main
from reports.cli.application import app
assert main(["--version"]) == main(["--help"]) == 0
names = [name for name in [*app, "sweep status"] if name[0] != "-"]
assert not any(main([*name.split(), "--help"]) for name in names)
print("loaded:", *sorted({HEAVY | {"pandas"}!r} & set(sys.modules)))
"""


@pytest.mark.parametrize(
    ("program", "count"), [(HELP_OF_ALL, 1), (ENGINES, 3)], ids=["help", "engines"]
)
def test_help_and_engines_load_nothing_that_they_do_not_need(
    program: str, count: int, tmp_path: Path
) -> None:
    with start(tmp_path, program=("-c", program)) as running:
        printed, _ = running.communicate()
    assert running.returncode == 0
    assert printed.splitlines()[-count:] == ["loaded:"] * count


COLLECTED = """
import gc, sys
found = []
gc.callbacks.append(lambda phase, state: found.append(phase))
sys.argv[1:] = ["check", "hertz-paper"]
from reports.cli import main
before = len(found)
code = main()
print("collected:", code, len(found) - before, gc.get_freeze_count() > 50_000)
"""


def test_a_command_looks_for_no_garbage_among_modules(tmp_path: Path) -> None:
    """Going through all of them took a twentieth of a run, half of it at its very end."""
    with start(tmp_path, program=("-c", COLLECTED)) as running:
        printed, _ = running.communicate()
    assert printed.splitlines()[-1] == "collected: 0 0 True"


# ------------------------------------------------------------------------------------------- scenes
def test_init_check_and_what_the_example_mentions(tmp_path: Path) -> None:
    """The commented example is a whole scene; with its comment signs moved it is another, with
    --bodies a third.
    """
    assert halfplane(tmp_path, "init", "my.toml").returncode == 0
    text = (tmp_path / "my.toml").read_text(encoding="utf-8")
    assert "FILE.toml" not in text
    assert {"material", "profile", "friction", "load"} <= tomllib.loads(text).keys()
    stated = re.sub(r"(?m)^# ", "", text[text.index("# [tolerances]") :].split("\n\n")[0])
    assert set(tomllib.loads(stated)["tolerances"]) == set(
        load_scene(tmp_path / "my.toml").tolerances.model_dump()
    )
    assert halfplane(tmp_path, "check", "my.toml").returncode == 0

    assert halfplane(tmp_path, "init", "flat.toml", "--profile", "flat_rounded").returncode == 0
    flat = (tmp_path / "flat.toml").read_text(encoding="utf-8")
    assert load_scene(tmp_path / "flat.toml").profile.flat_half_length == 0.5
    start = flat.index('kind = "ellipse"')
    end = flat.index('# kind = "polygon"')
    tail = flat[end:]
    for key in ("kind", "initial_loading", "cycle"):
        tail = tail.replace(f"# {key}", key, 1)
    (tmp_path / "other.toml").write_text(flat[:start] + tail, encoding="utf-8")
    scene = load_scene(tmp_path / "other.toml")
    assert (scene.profile.kind, scene.load.kind) == ("flat_rounded", "polygon")

    assert halfplane(tmp_path, "init", "bodies.toml", "--bodies").returncode == 0
    plain = load_scene(tmp_path / "my.toml")
    real = load_scene(tmp_path / "bodies.toml")
    assert (real.bodies.lower.kind, real.bodies.upper.kind) == ("block", "pad")
    assert real.vary(bodies=plain.bodies, name=plain.name) == plain


def test_every_scene_of_the_library_is_listed_and_can_be_started_from(tmp_path: Path) -> None:
    outcome = halfplane(tmp_path, "scenes", COLUMNS="100")
    lines = outcome.stdout.splitlines()
    assert max(map(len, lines)) <= 120
    for name in scene_names():
        assert name in lines
        assert load_scene(name).title in " ".join(outcome.stdout.split())
        (tmp_path / name).mkdir()
        assert halfplane(tmp_path / name, "init", "my.toml", "--from", name).returncode == 0
        assert load_scene(tmp_path / name / "my.toml").load == load_scene(name).load
    record = tmp_path / "time-series"
    assert everything(record) == {"my.toml", "time-series.csv"}
    assert "time-series.csv: the file is there already" in refused(
        record, "init", "other.toml", "--from", "time-series"
    )


def test_one_scene_in_detail(tmp_path: Path) -> None:
    printed = halfplane(tmp_path, "scenes", "flat-pad-on-block").stdout
    rows = ("purpose", "source", "tags", "question", "bodies", "tolerances", "expected")
    assert not [word for word in rows if not re.search(rf"(?m)^{word} ", printed)]
    listed = json.loads(
        halfplane(tmp_path, "scenes", "--tag", "paper", "--tag", "flat", "--json").stdout
    )["result"]["scenes"]
    assert [row["name"] for row in listed] == ["flat-rounded-paper", "motor"]
    assert listed[0]["expected"][0]["source"]


def test_schemas_have_every_table_and_explain_the_keys_of_bodies(tmp_path: Path) -> None:
    schema = json.loads(halfplane(tmp_path, "schema").stdout)
    assert {"material", "profile", "friction", "load", "tolerances"} <= schema["properties"].keys()
    assert set(schema["$defs"]["Block"]["properties"]) == {
        "kind",
        "width",
        "height",
        "base",
        "sides",
    }
    for kind in ("Block", "Pad", "Cylinder"):
        keys = schema["$defs"][kind]["properties"]
        assert all(keys[key].get("description") for key in keys if key != "kind")


def test_a_missed_number_ends_with_1(tmp_path: Path) -> None:
    text = scene_text("hertz-normal").split("[[expected]]")[0]
    number = (
        '[[expected]]\nquantity = "largest_half_width"\nvalue = {}\ntolerance = 1e-9\nsource ='
        ' "Hertz (1882)"\n'
    )
    for value, code, word in ((1.0, 0, "yes"), (1.001, 1, "no")):
        (tmp_path / "mine.toml").write_text(text + number.format(value), encoding="utf-8")
        outcome = halfplane(tmp_path, "exact", "mine.toml", "--quiet")
        assert outcome.returncode == code, outcome
        assert "quadrature nodes" not in outcome.stdout  # counters are in the file
        row = next(line for line in outcome.stdout.splitlines() if "largest half width" in line)
        assert re.search(rf"\b{word}\b", row)


# ---------------------------------------------------------------------------------- answers as JSON
@pytest.fixture
def answer_to(tmp_path: Path) -> Callable[..., tuple[int, dict[str, Any]]]:
    """Runs a command with --json: its exit code and what the document that is its whole stdout
    holds as `result`.
    """

    def run(*words: str) -> tuple[int, dict[str, Any]]:
        return answer_of(halfplane(tmp_path, *words, "--json"), *words)

    return run


def test_a_run_outside_its_tolerances_is_1_with_page_files_log_and_one_document(
    tmp_path: Path,
) -> None:
    outcome = halfplane(tmp_path, "run", "cattaneo-mindlin", "--json", *COARSE)
    code, answer = answer_of(outcome, "run", "cattaneo-mindlin")
    assert (code, answer["passed"]) == (1, False)
    assert answer["metrics"]["dissipation"]["accurate"] is False
    assert answer["page"] == "out/cattaneo-mindlin/report.html"
    assert everything(tmp_path) >= {answer["page"], "out/cattaneo-mindlin/result.nc"}
    stored = json_of(tmp_path / "out/cattaneo-mindlin/comparison.json")
    assert answer["metrics"]["shear"]["value"] == stored["metrics"]["shear"]["value"]
    assert stored["verdict"]["passed"] is False
    assert (
        stored["command"]
        == "halfplane run cattaneo-mindlin --element-size 0.25 --edge-element-size 0.25 --order 1"
        " --steps-per-cycle 8 --out out/cattaneo-mindlin"
    )
    log = (tmp_path / "out/cattaneo-mindlin/run.log").read_text(encoding="utf-8")
    assert "halfplane run cattaneo-mindlin --element-size 0.25" in log.splitlines()[0]
    assert all(
        words in log
        for words in ("revolution 1, ", " contact iterations", stored["verdict"]["sentence"])
    )
    assert "finite elements: " in outcome.stderr


def test_one_engine_alone_has_its_values_and_misses_what_so_coarse_a_mesh_misses(
    answer_to: Any, tmp_path: Path
) -> None:
    for engine, words, expected_code in (
        ("semi_analytic", ["exact"], 0),
        ("halfplane_fe", ["fe", *COARSE], 1),
    ):
        code, answer = answer_to(words[0], "cattaneo-mindlin", "--quiet", *words[1:])
        stored = json_of(tmp_path / f"out/cattaneo-mindlin/{engine}.json")
        assert (answer["engine"], answer["admissible"]) == (engine, True)
        assert answer["passed"] is (code == 0)
        assert (code, answer["file"]) == (expected_code, f"out/cattaneo-mindlin/{engine}.nc")
        for name in (
            "dissipation",
            "largest_pressure",
            "largest_half_width",
            "certificates",
            "notes",
        ):
            assert answer[name] == stored[name]
        stated = {number.quantity for number in load_scene("cattaneo-mindlin").expected}
        assert {"dissipation"} <= {number["quantity"] for number in answer["expected"]} <= stated
        assert all(number["met"] for number in answer["expected"]) is answer["passed"]
    assert {
        path.suffix for path in (tmp_path / "out/cattaneo-mindlin").glob("semi_analytic.*")
    } == {".nc", ".json", ".csv"}


@pytest.mark.slow
def test_doctor_examines_this_machine(answer_to: Any, tmp_path: Path) -> None:
    code, answer = answer_to("doctor")
    assert (code, everything(tmp_path)) == (0, set())
    examined = {"Python", "packages", "gmsh", "off-screen rendering", "output folder"}
    assert answer["checks"].keys() >= examined


def test_what_doctor_finds_amiss_is_1(
    answer_to: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    findings = (Finding("gmsh", True, "there"), Finding("off-screen rendering", False, "no screen"))
    monkeypatch.setattr("reports.cli.machine.examine", lambda _out: findings)
    code, answer = answer_to("doctor")
    assert (code, answer["passed"]) == (1, False)
    assert answer["checks"]["off-screen rendering"] == {"good": False, "found": "no screen"}
    assert halfplane(tmp_path, "doctor", "--quiet") == Done(1, "", "")


def test_a_check_that_ends_early_is_no_good_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that ends its process without an error, before the check has printed a line."""
    monkeypatch.setattr("reports.cli.machine._SCREEN", "raise SystemExit(0)")
    assert drawing() == (False, "ended before its check was done; only field pictures need it")


# of the dissipation, ± 0.0006: a limit of the error itself is undecided
ERROR = 0.0273
ADVICE = {
    "blocks": (0, "within", "theory may be used"),
    f"blocks --limit {ERROR}": (1, "undecided", "undecided"),
    "hertz-paper": (0, "within", "both bodies are half-planes of like materials"),
}


def test_advice_is_yes_or_not_sure(answer_to: Any) -> None:
    for words, (code, verdict, fact) in ADVICE.items():
        code_of_advice, answer = answer_to("advise", *words.split())
        assert (code_of_advice, answer["passed"], answer["verdict"]) == (code, code == 0, verdict)
        assert fact in answer["sentence"], words
        if "blocks" in words:
            change = answer["changes"]["dissipation"]["change"]
            assert change == pytest.approx(-ERROR, abs=0.005)


def test_the_answers_of_the_other_commands(
    answer_to: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code, answer = answer_to("fields", "hertz-normal", "--no-pictures", "--quiet", *COARSE)
    assert code == 0
    assert all((tmp_path / "out/hertz-normal" / name).exists() for name in answer["files"])
    assert (tmp_path / answer["file"]).exists()
    assert answer["instants"]
    assert all(
        instant[name]["value"] > 0
        for instant in answer["instants"]
        for name in ("largest_nodal_von_mises", "largest_nodal_tension")
    )
    assert "not peaks" in answer["largest nodal stresses"]

    code, answer = answer_to("export", "hertz-normal", "--quiet")
    deck = (tmp_path / answer["file"]).read_text(encoding="utf-8")
    assert answer["nodes"] > answer["elements"] / 2 > 100
    assert (code, f"** size: {answer['nodes']} nodes, " in deck) == (0, True)

    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    monkeypatch.setattr("reports.studies.sweep.running.worker_pool", lambda **_: Bench())
    code, answer = answer_to("sweep", "study.toml", "--workers", "1", "--quiet")
    assert (code, answer["points"]) == (0, {"done": 2, "failed": 0, "waiting": 0, "total": 2})
    assert (tmp_path / answer["file"]).read_text(encoding="utf-8").count("\n") == 3
    printed = halfplane(tmp_path, "sweep", "study.toml", "--workers", "1", "--quiet").stdout
    # a row for each point: number, f, W
    assert len(re.findall(r"│\s*[01] │ +1(?:\.2)? │ +0\.002\d+", printed)) == 2
    status = answer_to("sweep", "status", "out/study")[1]
    page = answer_to("sweep", "report", "out/study")[1]
    assert status["points"] == page["points"] == answer["points"]
    assert (status["title"], status["seconds_left"], status["failures"], status["damaged"]) == (
        "Friction",
        None,
        [],
        [],
    )
    assert (tmp_path / page["page"]).exists()

    written: list[Path] = []
    monkeypatch.setattr("reports.studies.maps.pages.write", written.append)
    code, answer = answer_to("map", "pair", "--pages", "--out", "maps")
    # pages alone solve nothing
    assert (code, answer["heights"], [Path(answer["page"]).parent]) == (0, {}, written)

    statement = Statement("key", "where", "words", "computed", Verdict.REFINED, {"a": 1.0})
    misprint = Misprint("key", "where", "printed", "right", "proof", None, {})
    report = PaperReport((statement,), (misprint,), Path("out/report.html"))
    monkeypatch.setattr("reports.studies.paper.page.write", lambda *_: report)
    _, answer = answer_to("paper", "--quiet")
    assert answer["verdicts"] == {"confirmed": 0, "refined": 1, "contradicted": 0}
    assert answer["statements"][0]["verdict"] == "refined"
    assert answer["misprints"][0]["proven"] is None

    assert answer_to("scenes", "time-series")[1]["scenes"][0]["files"] == ["time-series.csv"]
    semi_analytic.solve("cattaneo-mindlin").save(tmp_path / "result.nc")
    assert answer_to("diff", "result.nc", "result.nc")[1]["same"] is True


def test_the_schema_has_every_command_and_another_envelope_is_refused() -> None:
    schema = answer_schema()
    commands = {rule["if"]["properties"]["command"]["const"] for rule in schema["allOf"]}
    assert commands == set(NAMES) - {"init", "schema"} | {"sweep status", "sweep report"}
    text = (ROOT / "docs" / "json.md").read_text(encoding="utf-8")
    assert "reports/templates/answer.schema.json" in text
    answer = {
        "format": FORMAT,
        "command": "doctor",
        "exit_code": 0,
        "scene": None,
        "result": {"passed": True, "checks": {}},
    }
    jsonschema.validate(answer, schema)
    for wrong in (
        {**answer, "format": "halfplane verdict 1"},
        {**answer, "result": {"passed": True}},
        {**answer, "more": 1},
    ):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(wrong, schema)


# --------------------------------------------------------------------------- somebody else's result
TABLE = rows(exact("hertz-paper", 13, 53)).drop(columns=["P", "Q"])


@pytest.fixture
def score(tmp_path: Path) -> Callable[..., Done]:
    """Runs `score` in the folder on what a table holds, against hertz-paper."""

    def run(table: pd.DataFrame, *words: str) -> Done:
        written(table, tmp_path / "mine.csv")
        return halfplane(tmp_path, "score", "mine.csv", "--scene", "hertz-paper", "--quiet", *words)

    return run


def test_a_wrong_result_has_likely_causes_and_a_stated_tolerance_judges_first(
    score: Callable[..., Done], tmp_path: Path
) -> None:
    """Shear 0.05 % too large is within the engines' own tolerance, and outside one of 1e-5."""
    wrong = score(TABLE.assign(shear=-TABLE["shear"]), "--out", "here")
    assert (wrong.returncode, "Likely causes:" in wrong.stdout) == (1, True)
    assert "Likely causes of the difference" in (tmp_path / "here/report.html").read_text(
        encoding="utf-8"
    )
    near = TABLE.assign(shear=1.0005 * TABLE["shear"])
    assert score(near).returncode == 0
    outcome = score(near, "--tolerance", "shear=0.001%")
    assert (
        outcome.returncode,
        "tolerance in shear traction, L2" in " ".join(outcome.stdout.split()),
    ) == (1, True)


def test_one_frame_of_a_path_is_scored_and_drawn_with_the_example_of_a_mapping(
    score: Callable[..., Done], tmp_path: Path
) -> None:
    frame = TABLE[TABLE["time"] == TABLE["time"][53 * 5]][["x", "pressure", "shear"]]
    (tmp_path / "mapping.toml").write_text(
        halfplane(tmp_path, "score", "--mapping-example").stdout, encoding="utf-8"
    )
    outcome = score(
        frame.rename(columns={"pressure": "CPRESS", "shear": "CSHEAR1"}),
        "--json",
        "--mapping",
        "mapping.toml",
    )
    # the dissipation has a tolerance, and one frame has none
    assert outcome.returncode == 1, outcome.stderr
    answer = json.loads(outcome.stdout)["result"]
    assert answer["metrics"]["pressure"]["accurate"] is True
    assert "not in the result" in answer["metrics"]["dissipation"]["note"]
    assert (tmp_path / "out/score-mine/report.html").exists()


def test_a_folder_is_a_mesh_study_whose_sizes_come_from_the_points(tmp_path: Path) -> None:
    """Of results that are wrong by 0.3 h^2."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "notes.md").write_text("not a result", encoding="utf-8")
    for points in (27, 53, 105):
        table = rows(exact("hertz-paper", 9, points)).drop(columns=["P", "Q"])
        table["pressure"] *= 1 + 0.3 * (2.6 / (points - 1)) ** 2
        written(table, tmp_path / "meshes" / f"run{points}.csv")
    outcome = halfplane(tmp_path, "score", "meshes", "--scene", "hertz-paper", "--quiet")
    assert (outcome.returncode, "Mesh study" in outcome.stdout) == (0, True), outcome.stderr
    assert "own mesh study" in (tmp_path / "out/score-meshes/report.html").read_text(
        encoding="utf-8"
    )
    mesh_study = json_of(tmp_path / "out/score-meshes/comparison.json")["study"]
    sizes = [level["element_size"] for level in mesh_study["levels"]]
    assert sizes == pytest.approx([0.025, 0.05, 0.1])
    assert mesh_study["metrics"]["peak_pressure"]["order"] == pytest.approx(2.0, abs=0.02)
    assert any("Left out of the folder: notes.md" in note for note in mesh_study["notes"])


# -------------------------------------------------------------------------------------- exit code 3
@pytest.fixture
def partial() -> ContactSolution:
    """The first revolution's steps of a solution that then failed."""
    return cattaneo_mindlin(
        steps_per_leg=4,
        points=21,
        record=Record(False, "not converged", "stuck", read_only_copy([0] * 13, int)),
    )


@pytest.mark.parametrize("command", ["run", "fe", "exact"])
def test_not_converged_is_3_and_keeps_what_was_solved(
    command: str, partial: ContactSolution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for engine in ("halfplane_fe", "semi_analytic"):
        monkeypatch.setattr(
            f"{engine}.solve", raising(ConvergenceError("stuck at time 2.5", partial))
        )
    outcome = halfplane(tmp_path, command, "cattaneo-mindlin", "--quiet")
    assert outcome.returncode == 3
    assert "halfplane: cattaneo-mindlin: not converged: stuck at time 2.5" in outcome.stderr
    assert "stuck" in outcome.stdout
    assert outcome.stdout.splitlines()[-1] == "out/cattaneo-mindlin/partial.nc"
    folder = tmp_path / "out" / "cattaneo-mindlin"
    assert everything(folder) >= {"partial.nc", "partial.json", "partial.csv", "scene.json"}
    assert not (folder / "report.html").exists()
    assert json_of(folder / "partial.json")["converged"] is False
    assert ContactSolution.load(folder / "partial.nc").time[-1] == partial.time[-1]
    code, answer = answer_of(
        halfplane(tmp_path, command, "cattaneo-mindlin", "--quiet", "--json"), command
    )
    assert (code, answer["file"]) == (3, "out/cattaneo-mindlin/partial.nc")
    assert "stuck at time 2.5" in answer["error"]


def test_not_converged_at_once_and_a_reference_that_does_not(
    answer_to: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halfplane_fe.solve", raising(ConvergenceError("step 3 does not converge")))
    outcome = halfplane(tmp_path, "run", "cattaneo-mindlin", "--quiet")
    assert outcome.returncode == 3
    assert "no step was solved, so nothing was written" in outcome.stderr
    assert everything(tmp_path) == set()
    semi_analytic.solve("cattaneo-mindlin").save(tmp_path / "result.nc")
    code, answer = answer_to(
        "score", "result.nc", "--scene", "cattaneo-mindlin", "--against", "fe", "--quiet"
    )
    assert (code, answer["passed"], answer["file"]) == (3, False, None)
    assert answer["error"] == "the reference is not converged: step 3 does not converge"


def test_a_warning_of_a_library_is_one_line_without_its_source(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However often it is given; the command goes on."""
    solve = semi_analytic.solve

    def warned(*arguments: Any, **keywords: Any) -> Any:
        for _ in range(2):
            warnings.warn("invalid value encountered\nin something", RuntimeWarning, stacklevel=1)
        return solve(*arguments, **keywords)

    monkeypatch.setattr("semi_analytic.solve", warned)
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        outcome = halfplane(tmp_path, "exact", "full-stick", "--quiet")
    assert outcome.returncode == 0
    assert (
        outcome.stderr
        == "halfplane: warning: invalid value encountered in something (RuntimeWarning)\n"
    )


# ------------------------------------------------------------------------------------- exit code 70
PLANTED = (
    "halfplane: internal error, a fault of halfplane: ZeroDivisionError: planted; the traceback is "
)


def traceback_file(outcome: Done) -> str:
    """The file that the one sentence on stderr names, and that holds the traceback."""
    assert outcome.returncode == 70
    (line,) = outcome.stderr.splitlines()
    assert line.startswith(PLANTED + "in ")
    return line.removeprefix(PLANTED + "in ").removesuffix(": please report it")


class TestInternalErrors:
    """An exception that nobody expected: exit code 70, one sentence, and the traceback in a file
    that the sentence names.
    """

    @pytest.fixture(autouse=True)
    def here(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("tempfile.tempdir", str(tmp_path))

    def test_at_every_command(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """One whose folder another claimed before in the same process among them: that folder is
        left alone.
        """
        usable_folder(tmp_path / "other")
        for name in NAMES:
            monkeypatch.setattr(app[name], "default_command", raising(ZeroDivisionError("planted")))
            file = Path(traceback_file(halfplane(tmp_path, name)))
            text = file.read_text(encoding="utf-8")
            assert file.parent == tmp_path
            assert f"  halfplane {name}\n" in text
            assert "Traceback (most recent call last):" in text
            assert text.rstrip().endswith("ZeroDivisionError: planted")
        assert not (tmp_path / "other").exists()

    @pytest.mark.parametrize("words", ["run", "fe", "fields --at 1 --no-pictures", "exact"])
    def test_the_output_folder_has_it_no_half_answer_and_is_used_again(
        self, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        command, *options = words.split()
        solve = "semi_analytic.solve" if command == "exact" else "halfplane_fe.solve"
        line = [command, "cattaneo-mindlin", *options, "--quiet", "--out", "here"]
        before: set[str] = set()
        if command == "exact":
            assert halfplane(tmp_path, *line).returncode == 0
            before = everything(tmp_path / "here")
        with monkeypatch.context() as patch:
            patch.setattr(solve, raising(ZeroDivisionError("planted")))
            for count in (1, 2):
                assert traceback_file(halfplane(tmp_path, *line)) == "here/run.log"
                log = (tmp_path / "here/run.log").read_text(encoding="utf-8")
                assert log.count("Traceback") == count
        assert everything(tmp_path / "here") == before | {"run.log", "manifest.json"}
        assert command != "exact" or halfplane(tmp_path, *line).returncode == 0

    def test_where_no_file_can_be_written_it_is_on_stderr(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("semi_analytic.solve", raising(ZeroDivisionError("planted")))
        full = raising(OSError(28, "No space left on device"))
        monkeypatch.setattr("reports.folder.results_folder", full)
        command = ["exact", "cattaneo-mindlin", "--quiet", "--out", "here"]
        assert Path(traceback_file(halfplane(tmp_path, *command))).parent == tmp_path
        monkeypatch.setattr("tempfile.mkstemp", full)
        outcome = halfplane(tmp_path, *command)
        assert outcome.returncode == 70
        assert "Traceback (most recent call last):" in outcome.stderr
        assert outcome.stderr.splitlines()[-1] == PLANTED + "above: please report it"


# ------------------------------------------------------------------------ tables, progress and cost
HEADS = ("metric", "E", "mesh", "step", "far field", "idealisation", "± u", "verdict")
ROWS = [
    (
        "Peak pressure",
        "+0.691 %",
        "± 0.033 %",
        "0 ± 0",
        "± 0.0045 %",
        "+0.69 %",
        "0.033 %",
        "resolved",
    ),
    (
        "Contact edge",
        "−0.759 %",
        "± 3.4 %",
        "0 ± 0",
        "+0.0089 % ± 0.0036 %",
        "−0.77 %",
        "3.4 %",
        "not resolved",
    ),
    ("Pointwise dissipation", "0", "0 ± 0", "0 ± 0", "0 ± 0", "0", "0", "not resolved"),
]


def printed(
    capsys: pytest.CaptureFixture[str],
    columns: int,
    heads: tuple[str, ...],
    rows: list[tuple[str, ...]],
) -> list[str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(columns))
        show_table("Where the discrepancy comes from", heads, rows)
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines[1:])) <= columns
    return lines


def test_a_budget_fits_80_columns_with_its_words_whole_and_a_long_word_is_folded(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It was "penal|ty", "ideal|isati|on", "Dissip|ation"."""
    pieces = {
        word for line in printed(capsys, 80, HEADS, ROWS) for word in re.split(r"[\s│┃]+", line)
    }
    assert {word for row in (HEADS, *ROWS) for cell in row for word in cell.split()} <= pieces
    folded = printed(capsys, 30, ("file", "size"), [("a" * 60, "1")])
    assert sum(line.count("a") for line in folded[5:]) == 60
    assert any(
        "│two words │ 3    │" in line
        for line in printed(capsys, 80, ("what", "value"), [("two words", "3")])
    )


def test_time_left_is_that_of_the_part_and_starts_anew_with_the_next() -> None:
    left = TimeLeft(iter([0.0, 10.0, 12.0, 14.0, 20.0, 21.0]).__next__)
    words_left = [left.words(step, 5) for step in (0, 1, 2, 0, 1)]
    assert words_left == ["", "8 s left", "6 s left", "", "4 s left"]
    early, late = (TimeLeft(iter([0.0, 0.0, seconds]).__next__) for seconds in (50.0, 70.0))
    assert [(clock.words(0, 100), clock.words(1, 100)) for clock in (early, late)] == [
        ("", ""),
        ("", "116 min left"),
    ]
    # nothing is said of work without a total
    assert TimeLeft(iter([0.0, 1.0]).__next__).words(3, None) == ""


def test_piped_lines_are_plain_and_whole(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("reports.console._SECONDS_BETWEEN_LINES", 0.0)
    stages = Stages()
    with stages.stage("finite elements") as report:
        for step in range(4):
            report(
                step,
                3,
                f"revolution 1, {100 * step} steps, {250 * step} contact iterations, "
                + "and more words " * 6,
            )
    lines = capsys.readouterr().err.splitlines()
    assert (len(lines), lines[0], stages.log[0][10:]) == (6, *["finite elements ..."] * 2)
    assert lines[3].startswith("  finite elements: revolution 1, 200 steps, 500 contact iterations")
    assert "2 of 3 stretches" in lines[3]
    assert not [line for line in lines if "\x1b" in line]
    assert "300 steps" in stages.log[1]


@pytest.mark.parametrize(
    ("rows", "words", "measured", "is_stated"),
    [
        (200, [], True, False),
        (201, [], False, True),
        (201, ["--budget"], True, False),
        (201, ["--no-budget"], False, False),
    ],
)
def test_a_long_record_of_real_bodies_measures_no_uncertainty_unless_asked_and_says_so(
    rows: int,
    words: list[str],
    measured: bool,
    is_stated: bool,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    """Before the work on the terminal, after it in the notes of the answer and of the page."""
    record = "".join(f"{k},{90 + k % 2},0\n" for k in range(rows))
    (tmp_path / "record.csv").write_text(f"time,P,Q\n{record}", encoding="utf-8")
    text = scene_text("blocks").split("[[expected]]")[0]
    head, _, rest = text.partition("[load]")
    after = rest.partition("\n[")
    load = '[load]\nkind = "time_series"\nfile = "record.csv"\n'
    (tmp_path / "long.toml").write_text(f"{head}{load}{after[1]}{after[2]}", encoding="utf-8")
    times = np.arange(0.0, rows, 20.0)
    solved = semi_analytic.solve(tmp_path / "long.toml", x=np.linspace(-1.2, 1.2, 41), time=times)
    for engine in ("halfplane_fe", "semi_analytic"):
        monkeypatch.setattr(f"{engine}.solve", lambda *_, **__: solved)
    monkeypatch.setattr(
        "reports.comparison.budget.solve_refinements",
        lambda *_: pytest.fail("a budget was measured"),
    )
    command = ("run", "long.toml", "--out", "out", "--json", *words)
    if measured:
        with pytest.raises(pytest.fail.Exception, match="a budget was measured"):
            halfplane(tmp_path, *command)
        return
    outcome = halfplane(tmp_path, *command)
    sentence = (
        f"no uncertainty was measured: the record has {rows} rows, more than 200; --budget"
        " measures it"
    )
    assert (sentence in outcome.stderr) is is_stated
    noted = f"N{sentence[1:]}."
    assert (noted in json.loads(outcome.stdout)["result"]["notes"]) is is_stated
    assert (noted in (tmp_path / "out" / "report.html").read_text("utf-8")) is is_stated


def test_a_run_fits_a_screen_and_counts_what_it_leaves_to_the_page(tmp_path: Path) -> None:
    """25 lines of 80 columns, no cell of the table wrapped; the path comes last."""
    done = halfplane(tmp_path, "run", "blocks", "--preset", "coarse", "--quiet", COLUMNS="80")
    shown = done.stdout.splitlines()
    places = sum(max(1, -(-len(line) // 80)) for line in shown)
    assert places <= 25
    assert sum("│" in line for line in shown) == 7
    assert shown[-1].endswith("report.html")
    assert shown[-2] == "On the page, and with --verbose: all 4 expected numbers met."


@pytest.mark.parametrize("scene", ["blocks", "hertz-paper"])
def test_no_cell_of_the_budget_wraps_on_80_columns(scene: str, tmp_path: Path) -> None:
    words = ("--preset", "coarse", "--quiet", "--budget", "--verbose")
    shown = halfplane(tmp_path, "run", scene, *words, COLUMNS="80").stdout
    table = shown[shown.index("Where the difference comes from") :].partition("└")[0]
    names = [line[1:].partition("│")[0].strip() for line in table.splitlines() if line[0] == "│"]
    assert names == [
        "Peak pressure",
        "Half-width",
        "Permanent stick",
        "Largest slip",
        "Dissipation",
        "Peak W(x)",
        "Edge tension",
    ]


def test_a_run_in_short_says_where_size_alone_judges(tmp_path: Path) -> None:
    """Half-planes without a budget."""
    words = ("--preset", "coarse", "--quiet", "--no-budget")
    done = halfplane(tmp_path, "run", "hertz-paper", *words, COLUMNS="80")
    assert "Each verdict is by |E| alone." in done.stdout
    assert sum(max(1, -(-len(line) // 80)) for line in done.stdout.splitlines()) <= 25
