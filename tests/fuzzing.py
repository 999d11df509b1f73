"""Doors of the program, good files for each, and how a good file is spoilt: shared by the fuzz tests and benchmarks/faults.py."""

from __future__ import annotations

import json
import random
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from field_files import mesh, pressure_at, shear_at

import halfplane_fe.store
from reports.checking import require_admissible
from reports.cli import findings
from reports.comparison.content import solution_content, strict
from reports.folder import MANIFEST, claim
from reports.scoring.against import own_solution
from reports.scoring.guesses import whole_path
from reports.scoring.mapping import Mapping as ScoreMapping
from reports.scoring.mapping import load_mapping
from reports.scoring.reading import read
from reports.scoring.solution import contact_solution
from reports.sweep.store import read_index
from reports.sweep.study import load_study, study_of
from scenes import InputError, load_scene, scene_text
from score_results import exact, rows, written

DATA = Path(__file__).parent / "data"
# What breaks parsers: signs of their grammars, numbers at the ends, bytes that are no text, paths, markup, depth.
TOKENS = (
    *(b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"1e-320", b"9" * 400, b"1e308", b"99999999999999999999", b"0x7", b"1_0"),
    *(b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b"\n\n", b",", b";", b"\t", b"=", b'"', b"'", b"#", b"{", b"}", b"[", b"]"),
    *(
        b"[" * 3000,
        b'{"a":' * 2000,
        b"a." * 3000,
        b"../../x",
        b"/dev/zero",
        b"=HYPERLINK(1)",
        b"<script>",
        b"&x;",
        b"true",
        b"null",
    ),
    *(b"<!DOCTYPE a [<!ENTITY b 'b'>]>", b" -1", b" -3\n", b"9999\n", b"1.46685-100", b"\xd9\xa1", b"1979-05-27", b"-0.0"),
)
_NUMBERS = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


@dataclass(frozen=True)
class Door:
    """Where a file comes in: its name there, good files, and what takes it."""

    name: str
    seeds: Callable[[Path], list[bytes]]
    enter: Callable[[Path], object]


def spoilt(seed: bytes, chance: random.Random) -> bytes:
    """`seed` after one to four accidents; one time in twenty, nothing but noise."""
    if chance.random() < 0.05:
        return chance.randbytes(chance.randrange(200))
    accidents = (_number,) if chance.random() < 0.4 else _ACCIDENTS
    for _ in range(chance.choice((1, 1, 2, 4))):
        seed = chance.choice(accidents)(seed, chance)
    return seed


def _cut(seed: bytes, chance: random.Random) -> bytes:
    return seed[: chance.randrange(len(seed) + 1)]


def _lose(seed: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(seed) + 1)
    return seed[:at] + seed[at + chance.choice((1, 1, 8, 100)) :]


def _twice(seed: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(seed) + 1)
    part = seed[at : at + chance.choice((1, 8, 100))]
    return seed[:at] + part + seed[at:]


def _insert(seed: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(seed) + 1)
    return seed[:at] + chance.choice(TOKENS) + seed[at:]


def _flip(seed: bytes, chance: random.Random) -> bytes:
    if not seed:
        return seed
    spoiled = bytearray(seed)
    for _ in range(chance.choice((1, 1, 5))):
        spoiled[chance.randrange(len(seed))] = chance.randrange(256)
    return bytes(spoiled)


def _number(seed: bytes, chance: random.Random) -> bytes:
    found = list(_NUMBERS.finditer(seed))
    if not found:
        return seed
    one = chance.choice(found)
    other = chance.choice(found)[0] if chance.random() < 0.3 else chance.choice(TOKENS)
    return seed[: one.start()] + other + seed[one.end() :]


def _lines(seed: bytes, chance: random.Random) -> bytes:
    lines = seed.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


_ACCIDENTS = (_cut, _lose, _twice, _insert, _flip, _number, _number, _lines)


def outcome(door: Door, path: Path) -> str:
    """ "read", or the sentence of the refusal; any other error passes through. A sentence is one line of decent length."""
    try:
        door.enter(path)
    except InputError as refusal:
        sentence = str(refusal)
        assert sentence.strip(), f"{door.name}: an empty sentence"
        assert len(sentence) - len(str(path)) * sentence.count(str(path)) < 2100, f"{door.name}: {len(sentence)} characters"
        return sentence
    return "read"


def _scene(path: Path) -> object:
    scene = load_scene(path)
    require_admissible(scene, str(path))
    return scene


def _series(path: Path) -> object:
    scene = path.with_name("of-series.toml")
    scene.write_text(scene_text("time-series").replace("time-series.csv", path.name), encoding="utf-8")
    return load_scene(scene)


def _profile(path: Path) -> object:
    scene = path.with_name("of-table.toml")
    text = scene_text("hertz-paper")
    start = text.index("[profile]")
    end = text.index("[", start + 1)
    scene.write_text(f'{text[:start]}[profile]\nkind = "tabulated"\nfile = "{path.name}"\n{text[end:]}', encoding="utf-8")
    return load_scene(scene)


def _read(path: Path) -> object:
    return read(path, ScoreMapping(), load_scene("hertz-paper"))


def _scored(path: Path) -> object:
    return contact_solution(_read(path), ScoreMapping(), whole_path(load_scene("hertz-paper")))


def _stored_result(path: Path) -> object:
    folder = path.parent / "store"
    (folder / "results").mkdir(parents=True, exist_ok=True)
    plan = {"study": json.loads(_study()), "points": [{"number": 0, "address": "0" * 64, "coordinates": {"f": 1.0}}]}
    (folder / "sweep.json").write_text(json.dumps(plan), encoding="utf-8")
    (folder / "results" / f"{'0' * 64}.json").write_bytes(path.read_bytes())
    return read_index(folder)


def _condensed(path: Path) -> object:
    """The store of condensed bodies takes what it can't read as not there: it is not a user's file."""
    body, material = condensed_body()
    return halfplane_fe.store._read(path, body, material, 1000.0, Counter())


@cache
def condensed_body() -> tuple[object, object]:
    """A body and its material, as the store of condensed bodies takes them."""
    return half_disc("lower", SurfaceGrading(0.0, 1.0, 0.5, 0.5, 4.0), 1.0, 1), load_scene("hertz-paper").material.lower


def _study() -> str:
    axis = {"name": "f", "key": "friction.coefficient", "values": [0.5, 1.0]}
    return json.dumps({"scene": "hertz-paper", "engines": ["exact"], "figures": ["exact.dissipation"], "axes": [axis]})


def _toml_study() -> bytes:
    text = """scene = "hertz-paper"\nengines = ["exact"]\nfigures = ["exact.dissipation"]\n[set]\n"mesh.order" = 1
[derived]\nradius = "2 * f ** 2"\n[[axes]]\nname = "f"\nkey = "friction.coefficient"
linear = {start = 1.0, stop = 2.0, count = 12}\n[[axes]]\nname = "g"\nkey = "cycles"\nvalues = [1, 2]\n"""
    return text.encode()


def _csv(folder: Path) -> list[bytes]:
    solution = exact(steps=9, points=15)
    return [written(rows(solution), folder / "seed.csv").read_bytes()]


def _netcdf(folder: Path) -> list[bytes]:
    exact(steps=3, points=5).save(folder / "seed.nc")
    return [(folder / "seed.nc").read_bytes()]


def _fields(suffix: str, **how: object) -> Callable[[Path], list[bytes]]:
    def seeds(folder: Path) -> list[bytes]:
        path = folder / f"field{suffix}"
        mesh(pressure=lambda p: pressure_at(p[:, 0]), shear=lambda p: shear_at(p[:, 0])).write(path, **how)
        return [path.read_bytes()]

    return seeds


def _vtu(folder: Path) -> list[bytes]:
    return _fields(".vtu")(folder) + _fields(".vtu", binary=False)(folder)


def _collection(folder: Path) -> list[bytes]:
    _vtu(folder)
    head = '<VTKFile type="Collection"><Collection>'
    return [f'{head}<DataSet timestep="1.0" file="field.vtu"/></Collection></VTKFile>'.encode()]


def _frame_series(folder: Path) -> list[bytes]:
    _vtu(folder)
    return [b'{"file-series-version": "1.0", "files": [{"name": "field.vtu", "time": 1.0}]}']


def _data(*names: str) -> Callable[[Path], list[bytes]]:
    """Files that CalculiX wrote."""
    return lambda _: [(DATA / name).read_bytes() for name in names]


def _printed(folder: Path) -> list[bytes]:
    (folder / "printed.frd").write_bytes((DATA / "node-to-surface.frd").read_bytes())
    return _data("node-to-surface.dat")(folder)


def _heavy(folder: Path) -> list[bytes]:
    """The HDF5 file beside an XDMF file, which holds the numbers."""
    mesh(pressure=lambda p: pressure_at(p[:, 0]), shear=lambda p: shear_at(p[:, 0])).write(folder / "heavy.xdmf")
    return [(folder / "heavy.h5").read_bytes()]


def _found(kind: str) -> Callable[[Path], list[bytes]]:
    def seeds(folder: Path) -> list[bytes]:
        seed = findings.of_solution(exact(steps=3, points=5), "seed")
        if kind == "baseline":
            findings.write_baseline(seed, folder / "seed.json", {"semi_analytic.*": 1e-9})
            return [(folder / "seed.json").read_bytes()]
        solution = exact(steps=3, points=5)
        content = {**strict(solution_content(solution, ())), "scene": solution.scene.model_dump(mode="json")}
        if kind == "solution":
            return [json.dumps({"format": findings.SOLUTION, **content}).encode()]
        metric = {"dissipation": {"value": 0.1, "finite": True}}
        parts = {"reference": content, "result": {**content, "engine": "other"}}
        return [json.dumps({"format": "halfplane comparison 2", "scene": content["scene"], "metrics": metric, **parts}).encode()]

    return seeds


def _stored(_: Path) -> list[bytes]:
    from reports.sweep.store import canonical, checksum

    result = {"address": "0" * 64, "status": "done", "figures": {"exact.dissipation": 1.0}, "seconds": 1.0, "reason": ""}
    body = canonical(result)
    return [json.dumps({"format": "halfplane sweep 1", "sha256": checksum(body), "result": result}).encode()]


def _plan(_: Path) -> list[bytes]:
    study = json.loads(study_of(json.loads(_study()), "seed").model_dump_json())
    points = [{"number": 0, "address": "0" * 64, "coordinates": {"f": 0.5}}]
    return [json.dumps({"format": "halfplane sweep 1", "study": study, "points": points}).encode()]


def _npz(folder: Path) -> list[bytes]:
    body, material = condensed_body()
    made = halfplane_fe.store.condense(body, material, 4.0)
    halfplane_fe.store._write(folder / "seed.npz", made, Counter())
    return [(folder / "seed.npz").read_bytes()]


def _scenes(_: Path) -> list[bytes]:
    return [scene_text(name).encode() for name in ("hertz-paper", "blocks", "harmonics", "unlike-beta-fifth", "compound-curvature")]


MAPPING = b"""code = "mine"\nthickness = 2.0\ntimes = [0.0, 1.0]\n[columns]\npressure = "p"\n[factors]\nlength = 1000\n[signs]
shear = "on upper"\n[element_sizes]\n"a.csv" = 0.5\n"""
LISTED = b'{"written by": "halfplane", "files": ["report.html", "figures/a.csv", "manifest.json"]}'
DOORS: Mapping[str, Door] = {
    door.name: door
    for door in (
        Door("scene.toml", _scenes, _scene),
        Door("scene.json", lambda _: [load_scene(n).model_dump_json().encode() for n in ("hertz-paper", "time-series")], _scene),
        Door("series.csv", lambda _: [b"time,P,Q\n0,0,0\n1,2.5,0.5\n2,2,1\n3,1.5,-0.25\n"], _series),
        Door("profile.csv", lambda _: [b"x,h\n0,0\n0.5,0.1\n1,0.5\n2.0,2\n", b"-2,2\n-1,0.5\n0,0\n1,0.5\n2,2\n"], _profile),
        Door("mapping.toml", lambda _: [MAPPING], load_mapping),
        Door("result.csv", _csv, _scored),
        Door("result.vtu", _vtu, _read),
        Door("result.vtk", _fields(".vtk"), _read),
        Door("heavy.h5", _heavy, lambda path: _read(path.with_name("heavy.xdmf"))),
        Door("result.xdmf", _fields(".xdmf", data_format="XML"), _read),
        Door("result.pvd", _collection, _read),
        Door("result.series", _frame_series, _read),
        Door("result.frd", _data("mortar.frd"), _read),
        Door("printed.dat", _printed, _read),
        Door("result.nc", _netcdf, lambda path: own_solution(path, load_scene("hertz-paper"))),
        Door("study.toml", lambda _: [_toml_study()], load_study),
        Door("study.json", lambda _: [_study().encode()], load_study),
        Door("sweep.json", _plan, lambda path: read_index(path.parent)),
        Door("stored.json", _stored, _stored_result),
        Door("baseline.json", _found("baseline"), findings.read_findings),
        Door("solution.json", _found("solution"), findings.read_findings),
        Door("comparison.json", _found("comparison"), findings.read_findings),
        Door(
            MANIFEST,
            lambda _: [b'{"written by": "halfplane", "files": ["a.csv", "manifest.json"]}'],
            lambda path: claim(path.parent),
        ),
        Door("condensed.npz", _npz, _condensed),
    )
}


def attempt(door: Door, seed: bytes, number: int, folder: Path) -> tuple[bytes, str]:
    """The file of that number, and what came of it."""
    content = spoilt(seed, random.Random(f"{door.name} {number}"))
    home = folder / door.name
    home.mkdir(exist_ok=True)
    path = home / door.name
    path.write_bytes(content)
    return content, outcome(door, path)
