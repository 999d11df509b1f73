"""Every door against spoilt, huge and hostile files: read, or refused in one sentence; nothing runs
or leaves its place.
"""

from __future__ import annotations

import itertools
import json
import os
import random
import resource
import stat
import sys
import tomllib
import tracemalloc
import zlib
from base64 import b64encode
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import h5py
import numpy as np
import pytest

from command_line import forked, raising, refused, sentence
from fuzzing import APART, DOORS, TOKENS, Door, attempt, outcome, spoilt
from halfplane_fe import SolverSettings
from meshes import MeshSettings, SurfaceGrading, half_disc
from meshes.bodies import number_of_body_nodes, number_of_contact_nodes, require_few_nodes
from refusals import refused_for, require_facts
from reports.console import say, show_table
from reports.folder import default_folder, replace_text, results_folder, usable_folder
from reports.scoring import field_files
from reports.studies.sweep.store import Store
from reports.studies.third.deck import Deck, DeckSettings, build_deck, deck_text
from scenes import InputError, load_scene, text_tables
from scenes.files import parsed_toml, within_memory
from score_results import exact


@contextmanager
def few_calls(most: int) -> Iterator[None]:
    """Fails once Python and C functions were called and left more often than that: a count,
    whatever the machine is doing.
    """
    calls = itertools.count()
    sys.setprofile(lambda *_: next(calls))
    try:
        yield
    finally:
        sys.setprofile(None)
    assert next(calls) < most


# Spoilt files for each door: in every test run, and under --slow.
QUICK = 8
THOROUGH = 2000


# ------------------------------------------------------------------------------------------- spoilt
@pytest.mark.parametrize("name", DOORS)
@pytest.mark.parametrize(
    ("first", "last"), [(0, QUICK), pytest.param(QUICK, QUICK + THOROUGH, marks=pytest.mark.slow)]
)
def test_good_files_are_read_and_spoilt_ones_read_or_refused(
    name: str, first: int, last: int, tmp_path: Path
) -> None:
    """So are files that hold nothing but the signs that break parsers: one at once, two in the slow
    tests.
    """
    door = DOORS[name]
    home = tmp_path / name
    home.mkdir()
    seeds = door.seeds(home)
    for seed in seeds:
        (home / name).write_bytes(seed)
        assert outcome(door, home / name) == "read"
    signs = (b"", *TOKENS) if first == 0 else tuple(map(b"".join, pairwise(TOKENS)))
    for content in () if name in APART else signs:
        (home / name).write_bytes(content)
        with few_calls(10_000_000):  # the most that were counted: 1.7 million
            outcome(door, home / name)
    for number in range(first, last, 20 if name in APART else 1):
        attempt(door, seeds[number % len(seeds)], number, tmp_path)


def test_accidents_spoil_files_and_repeat_and_a_door_that_breaks_is_seen(tmp_path: Path) -> None:
    """The testers tested. An error other than InputError, or a sentence that is none, fails."""
    seed = DOORS["study.json"].seeds(Path())[0]
    spoiled = [spoilt(seed, random.Random(number)) for number in range(100)]
    assert len({*spoiled}) > 70
    assert spoilt(seed, random.Random(3)) == spoiled[3]

    with pytest.raises(KeyError):
        outcome(Door("broken", raising(KeyError("x"))), tmp_path)
    with pytest.raises(AssertionError, match="empty"):
        outcome(Door("broken", raising(InputError())), tmp_path)


# --------------------------------------------------------------------------------------------- huge
ROOM = 2**29  # bytes of address space beyond what the libraries have
LIMITS = {
    ".toml": "1.05 MB",
    ".json": "268 MB",
    ".csv": "268 MB",
    ".rpt": "268 MB",
    ".frd": "537 MB",
    ".dat": "537 MB",
    ".nc": "2.15 GB",
} | dict.fromkeys((".vtu", ".vtk", ".pvd"), "537 MB")
# Files of our own that no user names: their doors take them for lost and go on.
OWN = ("stored.json", "sweep.json", "manifest.json")


def huge(path: Path, size: int) -> None:
    """A file that takes no room on the disk."""
    path.touch()
    os.truncate(path, size)


@pytest.mark.parametrize(
    "name", [name for name in DOORS if Path(name).suffix in LIMITS and name not in OWN]
)
def test_a_file_beyond_the_limit_is_refused(name: str, tmp_path: Path) -> None:
    huge(tmp_path / name, 3 * 10**9 if name.endswith(".nc") else 10**9)
    refusal = outcome(DOORS[name], tmp_path / name)
    require_facts(refusal, name, f"at most {LIMITS[Path(name).suffix]}")


@pytest.mark.parametrize("case", ["rows.csv", "dots.toml", "an answer.nc"])
def test_what_is_too_large_is_refused_by_a_process_with_little_memory(
    case: str, tmp_path: Path
) -> None:
    score = ("score", case, "--scene", "hertz-paper", "--quiet")
    match case:
        case "rows.csv":
            huge(tmp_path / case, 10**9)
            words = score
            fact = "268 MB"
        case "dots.toml":  # the parser took 2 GB for 45 kB of them
            (tmp_path / case).write_text("a." * 22_500 + "a = 1\n", encoding="utf-8")
            words = ("check", case)
            fact = "deeper than 8"
        case _:
            bomb(tmp_path / case, (2**20, 2**20))
            words = score
            fact = "8.8e+03 GB"
    require_facts(sentence(forked(tmp_path, *words, memory=ROOM)), case, fact)


def bomb(path: Path, shape: tuple[int, int]) -> None:
    """An answer of ours in which one array says that it is enormous, and takes a few kilobytes
    packed.
    """
    exact(steps=3, points=5).save(path)
    with h5py.File(path, "a") as file:
        del file["pressure"]
        file.create_dataset(
            "pressure", shape, "f8", chunks=(1, 2**17), compression="gzip", fillvalue=0.0
        )
        for axis, name in enumerate(("time", "x")):
            file["pressure"].dims[axis].label = name
    assert path.stat().st_size < 10**6


DOTS = "a." * 6000 + "b"
NESTED = {
    "a key": f"{DOTS} = 1\n",
    "a key in quotes": DOTS.replace("a", "'a'").replace("b", '"b"') + " = 1\n",
    "a key with blanks": DOTS.replace(".", " . ") + " = 1\n",
    "the head of a table": f"[{DOTS}]\n",
    "the head of a list of tables": f"[[{DOTS}]]\n",
    "an inline table": f"x = {{ {DOTS} = 1 }}\n",
    "tables in tables": "x = " + "{a = " * 6000,
    "behind words": f'r = "\'\'\'"\ns = \'"""\'\nt = """\\"""\n# \'\'\'\n""""\n{DOTS} = 1\n',
}


@pytest.mark.parametrize("text", NESTED.values(), ids=NESTED)
@pytest.mark.parametrize("name", [name for name in DOORS if name.endswith(".toml")])
def test_toml_is_bounded_before_it_is_parsed(name: str, text: str, tmp_path: Path) -> None:
    """The parser takes memory with the square of the dots: 150 MB for each of these, 2 GB for 45
    kB.
    """
    (tmp_path / name).write_text(text, encoding="utf-8")
    tracemalloc.start()
    try:
        refusal = outcome(DOORS[name], tmp_path / name)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    require_facts(refusal, name, "deeper than 8", "at line")
    assert peak < 2e7


def test_what_is_not_nested_is_read() -> None:
    for text in (
        f"# {DOTS}\ns = '{DOTS} = 1'\n",
        f's = "\\"{DOTS} = 1"\n',
        f's = """\\""""\nt = """\n{DOTS} = 1\n[{DOTS}]\n"""""\nu = 1\n',
        f"s = ''''\n{DOTS} = 1\n'''''\n",
        "a.b.c.d.e.f.g.h = [[1.5, -2.5e-3], [0.25, 1e5]] # 1.2.3.4.5.6.7.8.9\n",
        "[[a.'b.b'.c]]\nd = [{e = {f = [1979-05-27T07:32:00.5Z]}}]\n",
        "".join(f"k{number} = 1\n" for number in range(10_000)),
        "rows = [" + "[0.5, 1.5],\n" * 20_000 + "]\n",
    ):
        assert parsed_toml(text) == tomllib.loads(text)


def vtu_of_zeros(blocks: int, size: int) -> str:
    """Points that are zeros, as VTK packs them: 144 blocks of 17 MB are 2.4 GB in 4 MB."""
    packed = zlib.compress(bytes(size), 9)
    head = np.array([blocks, size, size, *([len(packed)] * blocks)], np.uint32).tobytes()
    text = (b64encode(head) + b64encode(packed * blocks)).decode()
    return (
        '<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="0.1"'
        ' byte_order="LittleEndian" compressor="vtkZLibDataCompressor"><UnstructuredGrid><Piece'
        f' NumberOfPoints="{blocks * size // 24}" NumberOfCells="1"><Points><DataArray'
        ' type="Float64" Name="Points" NumberOfComponents="3"'
        f' format="binary">{text}</DataArray></Points><Cells><DataArray type="Int64"'
        ' Name="connectivity" format="ascii">0</DataArray><DataArray type="Int64" Name="offsets"'
        ' format="ascii">1</DataArray><DataArray type="UInt8" Name="types"'
        ' format="ascii">1</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>'
    )


# A billion laughs.
ENTITIES = "".join(f"<!ENTITY a{k} '{f'&a{k - 1};' * 10}'>" for k in range(1, 10))
LAUGHS = f"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY a0 'lol'>{ENTITIES}]><VTKFile>&a9;</VTKFile>"
ENORMOUS = '{{"format": "halfplane baseline 1", "tolerances": {{"metric.peak": {}{}}}}}'
# What is wrong -> the door, the text of the file (or what it is), words of the refusal.
HOSTILE = {
    "keys": (
        "scene.toml",
        "".join(f"k{n} = 1\n" for n in range(10_001)),
        ["10,000 keys", "line 10001, column 8"],
    ),
    "tables": (
        "scene.toml",
        "".join(f"[k{n}]\n" for n in range(10_001)),
        ["10,000 keys", "line 10001, column 1"],
    ),
    "a hexadecimal number, of which no JSON could be written": (
        "scene.toml",
        "a = 1\ncycles = 0x" + "f" * 5000,
        ["250 characters", "line 2, column 10"],
    ),
    "rows": ("series.csv", "time,P,Q\n" + "1,2,3\n" * 100_001, ["100,000 rows"]),
    "a line of a table": (
        "series.csv",
        "1," * 10**6,
        ["line 1", "100,000 characters"],
    ),
    "a line of a result": (
        "result.csv",
        "x,pressure,shear\n" + "1," * 10**7,
        ["line 2", "10,000,000 characters"],
    ),
    "a field file that unpacks to gigabytes": (
        "result.vtu",
        vtu_of_zeros(144, 2**24),
        ["134 MB"],
    ),
    # JSON has whole numbers without end, and Python reads them: it was an OverflowError where one
    # was used.
    "a whole number": (
        "baseline.json",
        ENORMOUS.format("1", 400 * "0"),
        ["401 digits"],
    ),
    "a negative one": (
        "baseline.json",
        ENORMOUS.format("-1", 400 * "0"),
        ["402 digits"],
    ),
} | {
    f"{content} as {name}": (name, content, facts)
    for content, names, facts in (
        (LAUGHS, ("result.vtu", "result.pvd"), ["of another form"]),
        ("/dev/zero", ("scene.toml", "series.csv"), ["no regular file"]),
        ("a pipe", ("scene.toml", "series.csv"), ["no regular file"]),
    )
    for name in names
}


@pytest.mark.parametrize("case", HOSTILE.values(), ids=[case[:60] for case in HOSTILE])
def test_what_has_no_end_is_refused_at_its_door(
    case: tuple[str, str, list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rows, and memory for what is unpacked, with a smaller limit than the users', for the time
    goes with them.
    """
    assert text_tables.MOST_ROWS == 2_000_000
    monkeypatch.setattr(text_tables, "MOST_ROWS", 100_000)
    monkeypatch.setattr(field_files, "MOST_UNPACKED_BYTES", 2**27)
    name, content, facts = case
    match content:
        case "a pipe":
            os.mkfifo(tmp_path / name)
        case "/dev/zero":
            (tmp_path / name).symlink_to(content)
        case _:
            (tmp_path / name).write_text(content, encoding="utf-8")
    require_facts(outcome(DOORS[name], tmp_path / name), name, *facts)


# ------------------------------------------------------------------------------------------- meshes
def test_absurd_meshes_and_settings_are_refused_and_the_finest_of_the_project_are_not(
    tmp_path: Path,
) -> None:
    for options, facts in (
        ("--element-size 1e-4 --edge-element-size 1e-4", ["nodes", "8,000"]),
        ("--edge-element-size 5e-4 --growth 0.02 --far-radius 1000", ["nodes", "500,000"]),
    ):
        refusal = refused(tmp_path, "fe", "hertz-paper", "--quiet", *options.split())
        require_facts(refusal, *facts)
    with refused_for("element_size = 1e-09", "[0.0001, 0.25]"):
        MeshSettings(element_size=1e-9)
    with refused_for("[4, 100000]"):
        SolverSettings(steps_per_cycle=10**9)
    for mesh in (
        MeshSettings.fine(),
        MeshSettings(edge_element_size=1 / 1280),
        MeshSettings(far_radius=1000.0),
    ):
        require_few_nodes(
            "lower",
            SurfaceGrading(0.7, 1.06, mesh.element_size, mesh.edge_element_size, mesh.far_radius),
            mesh.growth,
            2,
        )


@pytest.mark.parametrize(
    ("grading", "growth", "order"),
    [
        (SurfaceGrading(0.7, 1.06, 1 / 24, 1 / 160, 10.0), 0.2, 2),  # the default
        (SurfaceGrading(0.0, 1.06, 1 / 24, 1 / 40, 10.0), 0.2, 2),  # no inner part
        (SurfaceGrading(0.7, 1.06, 1 / 24, 1 / 80, 100.0), 0.06, 1),  # far and slow growth
    ],
)
def test_the_count_taken_before_meshing_is_right(
    grading: SurfaceGrading, growth: float, order: int
) -> None:
    """Within a factor of 1.5 (measured: 0.83 to 1.33)."""
    mesh = half_disc("lower", grading, growth, order).mesh
    assert 1 / 1.5 < number_of_body_nodes(grading, growth, order) / mesh.p.shape[1] < 1.5
    assert (
        abs(number_of_contact_nodes(grading, order) - (len(mesh.boundaries["contact"]) * order + 1))
        <= 4
    )


def test_the_limit_on_memory_is_lifted_again(tmp_path: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_AS)
    with pytest.raises(InputError, match="takes more than 1 MB"), within_memory(tmp_path, 10**6):
        np.ones(10**8)
    assert resource.getrlimit(resource.RLIMIT_AS) == before
    assert np.ones(10**6).sum() == 10**6


# ------------------------------------------- nothing that comes in runs, steers or leaves its place
def test_a_name_can_not_bring_a_card_into_a_deck() -> None:
    evil = dict.fromkeys(("name", "title", "units"), "x\n*INCLUDE, INPUT=/etc/passwd\x85*STEP")
    settings = DeckSettings(
        element_size=0.25,
        edge_element_size=0.25,
        far_radius=10.0,
        growth=0.9,
        steps_per_cycle=4,
        cycles=1,
    )
    deck = build_deck(load_scene("hertz-normal"), settings)
    wrong = replace(deck, scene=deck.scene.vary(**evil))

    def cards(deck: Deck, command: str) -> list[str]:
        lines = deck_text(deck, command, {"halfplane": command}).splitlines()
        return [line for line in lines if line.startswith("*") and not line.startswith("**")]

    assert cards(wrong, "a\n*STEP") == cards(deck, "")


def test_the_terminal_is_not_steered(capsys: pytest.CaptureFixture[str]) -> None:
    say("title \x1b]0;owned\x07 \x1b[2J [bold]literal[/bold]")
    show_table("\x1b[2J", ("a",), [("\x1b[31m",)])
    out = capsys.readouterr().out
    assert not [sign for sign in "\x1b\x07" if sign in out]
    assert "[bold]literal[/bold]" in out
    assert "\x1b" not in str(InputError("x.toml: \x1b[2J"))


# -------------------------------------------------------------------------------------------- paths
@pytest.mark.parametrize(
    "name", ["../../x", "/etc/passwd", "..", ".", "", "a b/c", "a\x00b", "~/x", "CON", "x" * 20]
)
def test_names_never_lead_out_of_the_folder(name: str) -> None:
    folder = default_folder(name)
    assert folder.parent == Path("out")
    assert folder.name not in {"", ".", ".."}
    assert not [sign for sign in "/\x00" if sign in folder.name]


@pytest.mark.parametrize(
    "listed",
    [["../victim"], ["{out}/../victim"], ["link/victim"], ["a/../../victim"], 7, [7], [""], None],
)
def test_a_manifest_never_has_files_removed_outside(listed: object, tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("stays")
    out = tmp_path / "out"
    out.mkdir()
    (out / "link").symlink_to(tmp_path, target_is_directory=True)
    # One that lists itself is taken for ours, so that its other names count; what is no list is
    # somebody else's.
    files = [*listed, "manifest.json"] if isinstance(listed, list) else listed
    (out / "manifest.json").write_text(
        json.dumps({"written by": "halfplane", "files": files}).replace("{out}", str(out))
    )
    refusal = (
        nullcontext()
        if isinstance(listed, list)
        else pytest.raises(InputError, match=r"manifest\.json is there already")
    )
    with refusal, results_folder(out) as folder:
        (folder / "a.txt").write_text("new")
    assert (tmp_path / "victim").read_text() == "stays"


def test_nothing_is_written_through_a_link_that_leads_out(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out" / "figures").symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    refusal = pytest.raises(InputError, match="would be written outside, through a link")
    with refusal, results_folder(tmp_path / "out") as folder:
        (folder / "figures").mkdir()
        (folder / "figures" / "a.csv").write_text("x")
    assert list((tmp_path / "elsewhere").iterdir()) == []
    assert usable_folder(tmp_path / "out")


def test_an_address_in_a_plan_is_no_path(tmp_path: Path) -> None:
    victim = tmp_path / "victim.json"
    victim.write_text("{}")
    store = Store(tmp_path / "sweep")
    store.prepare()
    plan = {"study": {}, "points": [{"number": 0, "address": "../../victim", "coordinates": {}}]}
    (store.folder / "sweep.json").write_text(json.dumps(plan))
    with pytest.raises(InputError, match="no address of a result"):
        store.read_plan()
    assert victim.exists()


# ------------------------------------------------------------------------------------------- rights
@pytest.fixture
def generous() -> Iterator[None]:
    """An umask that gives every right to everybody."""
    before = os.umask(0)
    yield
    os.umask(before)


def rights(path: str | Path) -> int:
    return stat.S_IMODE(os.stat(path).st_mode)


@pytest.mark.usefixtures("generous")
def test_a_folder_that_is_being_filled_is_private_and_the_filled_one_is_not(tmp_path: Path) -> None:
    with results_folder(tmp_path / "out") as staging:
        (staging / "figures").mkdir()
        (staging / "figures" / "a.csv").write_text("x")
        assert rights(staging) == 0o700
    assert (rights(tmp_path / "out"), rights(tmp_path / "out" / "figures" / "a.csv")) == (
        0o777,
        0o666,
    )


WRITERS = {
    "store of a sweep": lambda folder: Store(folder).write_text(folder / "a.json", "{}"),
    "baseline": lambda folder: replace_text(folder / "a.json", "{}"),
}


@pytest.mark.usefixtures("generous")
@pytest.mark.parametrize("writer", WRITERS)
def test_a_file_that_is_being_written_is_private(
    writer: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Seen at the moment at which it gets its rights and its name."""
    modes = []
    for name in ("replace", "chmod"):

        def call(first: str, *rest: object, real: object = getattr(os, name)) -> None:
            modes.append(rights(first))
            real(first, *rest)

        monkeypatch.setattr(os, name, call)
    WRITERS[writer](tmp_path)
    assert modes[0] == 0o600
    assert len(list(tmp_path.iterdir())) == 1
