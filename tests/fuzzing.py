"""Doors of the program, good files for each, and how a good file is spoilt: shared by the fuzz
tests and benchmarks/jobs.py.
"""

from __future__ import annotations

import json
import random
import re
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import get_args

import numpy as np

from reports.checking import require_admissible
from reports.comparison import findings
from reports.comparison.json_values import solution_content, strict_json_values
from reports.folder import MANIFEST, usable_folder
from reports.profile_fit import fit_in_words
from reports.scoring.against import stored_solution
from reports.scoring.mapping import Mapping, load_mapping
from reports.scoring.reading import read_result
from reports.scoring.solution import solution_of_surface, theory_of_whole_path
from reports.studies.sweep.store import canonical_json, checksum, read_index
from reports.studies.sweep.study import load_study, study_of
from scenes import InputError, Scene, load_scene, scene_text
from scenes.profiles import FitKind
from score_results import exact, mesh, pressure_at, rows, shear_at, written

DATA = Path(__file__).parent / "data"
# What breaks parsers: signs of their grammars, numbers at the ends, bytes that are no text, paths,
# markup, depth.
TOKENS = (
    *(
        b"nan",
        b"inf",
        b"-inf",
        b"1e999",
        b"-1",
        b"0",
        b"1e-320",
        b"9" * 400,
        b"1e308",
        b"99999999999999999999",
        b"0x7",
        b"1_0",
    ),
    *(
        b"\x00",
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"\r",
        b"\n\n",
        b",",
        b";",
        b"\t",
        b"=",
        b'"',
        b"'",
        b"#",
        b"{",
        b"}",
        b"[",
        b"]",
    ),
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
    ),
    *(
        b"<!DOCTYPE a [<!ENTITY b 'b'>]>",
        b" -1",
        b" -3\n",
        b"9999\n",
        b"1.46685-100",
        b"\xd9\xa1",
        b"1979-05-27",
        b"-0.0",
        b"null",
    ),
)
NUMBERS = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
ACCIDENTS = ("cut", "lose", "twice", "insert", "flip", "number", "number", "lines")


# ---------------------------------------------------------------------------------------- accidents
def spoilt(seed: bytes, chance: random.Random) -> bytes:
    """`seed` after one to four accidents; one time in twenty, nothing but noise."""
    if chance.random() < 0.05:
        return chance.randbytes(chance.randrange(200))
    kinds = ("number",) if chance.random() < 0.4 else ACCIDENTS
    for _ in range(chance.choice((1, 1, 2, 4))):
        seed = _accident(chance.choice(kinds), seed, chance)
    return seed


def _accident(kind: str, seed: bytes, chance: random.Random) -> bytes:
    place = chance.randrange(len(seed) + 1)
    size = chance.choice((1, 1, 8, 100))
    head = seed[:place]
    tail = seed[place:]
    match kind:
        case "cut":
            return head
        case "lose":
            return head + tail[size:]
        case "twice":
            return head + tail[:size] + tail
        case "insert":
            return head + chance.choice(TOKENS) + tail
        case "flip":
            return head + chance.randbytes(size) + tail[size:]
        case "lines":
            lines = seed.split(b"\n")
            first = chance.randrange(len(lines))
            second = chance.randrange(len(lines))
            lines[first], lines[second] = lines[second], lines[first]
            return b"\n".join(lines)
    numbers = list(NUMBERS.finditer(seed))
    if not numbers:
        return seed
    number = chance.choice(numbers)
    successor = chance.choice(numbers)[0] if chance.random() < 0.3 else chance.choice(TOKENS)
    return seed[: number.start()] + successor + seed[number.end() :]


# -------------------------------------------------------------------------------------------- doors
@dataclass(frozen=True)
class Door:
    """Where a file comes in: its name there, and what takes it."""

    name: str
    enter: Callable[[Path], object]

    def seeds(self, folder: Path) -> list[bytes]:
        """Good files; what they need beside them is written to `folder`."""
        return good_files(self.name, folder)


def outcome(door: Door, path: Path) -> str:
    """ "read", or the sentence of the refusal; any other error passes through. A sentence is one
    line of decent length.
    """
    try:
        door.enter(path)
    except InputError as refusal:
        sentence = str(refusal)
        assert sentence.strip(), f"{door.name}: an empty sentence"
        assert len(sentence) - len(str(path)) * sentence.count(str(path)) < 2100, (
            f"{door.name}: {len(sentence)} characters"
        )
        return sentence
    return "read"


def attempt(door: Door, seed: bytes, number: int, folder: Path) -> tuple[bytes, str]:
    """The file of that number, and what came of it."""
    content = spoilt(seed, random.Random(f"{door.name} {number}"))
    home = folder / door.name
    home.mkdir(exist_ok=True)
    (home / door.name).write_bytes(content)
    return content, outcome(door, home / door.name)


def _scene(path: Path) -> object:
    scene = load_scene(path)
    require_admissible(scene, str(path))
    return scene


def _beside_a_scene(table: str, *fits: str) -> Callable[[Path], Scene]:
    """A scene with the file beside it as its profile or load; one of `fits`, by the file's first
    bytes, goes through its rows.
    """
    kind = {"profile": "tabulated", "load": "time_series"}[table]

    def enter(path: Path) -> Scene:
        text = scene_text("hertz-paper")
        start = text.index(f"[{table}]")
        end = text.find("\n[", start + 1)
        scene = path.with_name("beside.toml")
        fit = (
            f'\nfit = {{kind = "{fits[zlib.crc32(_first_bytes(path)) % len(fits)]}"}}'
            if fits
            else ""
        )
        scene.write_text(
            f'{text[:start]}[{table}]\nkind = "{kind}"\nfile = "{path.name}"{fit}{text[end:]}',
            encoding="utf-8",
        )
        return load_scene(scene)

    return enter


def _first_bytes(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(4096)


def _fitted(path: Path) -> object:
    """What a fit leaves: a curve of finite numbers that rises from its middle on, words about it, a
    scene that is read again.
    """
    scene = _beside_a_scene("profile", *get_args(FitKind))(path)
    assert scene.profile.fitted is not None
    x = np.linspace(0.0, scene.profile.fitted.extent, 50)
    height = scene.profile.height(x)
    assert np.all(np.isfinite(height))
    assert np.all(np.diff(height) >= -1e-12 * height[-1])
    assert all(fit_in_words(scene, 1.0))
    assert Scene.model_validate_json(scene.model_dump_json()).profile == scene.profile
    return scene


def _read(path: Path) -> object:
    return read_result(path, Mapping())


def _scored(path: Path) -> object:
    return solution_of_surface(
        _read(path), Mapping(), theory_of_whole_path(load_scene("hertz-paper"))
    )


def _stored_result(path: Path) -> object:
    folder = path.parent / "store"
    (folder / "results").mkdir(parents=True, exist_ok=True)
    (folder / "sweep.json").write_text(
        json.dumps({"study": STUDY, "points": POINTS}), encoding="utf-8"
    )
    (folder / "results" / f"{ADDRESS}.json").write_bytes(path.read_bytes())
    return read_index(folder)


ENTRANCES: dict[str, Callable[[Path], object]] = {
    "scene.toml": _scene,
    "scene.json": _scene,
    "series.csv": _beside_a_scene("load"),
    "profile.csv": _beside_a_scene("profile"),
    "fit.csv": _fitted,
    "mapping.toml": load_mapping,
    "result.csv": _scored,
    **dict.fromkeys(
        (*(f"result.{kind}" for kind in ("vtu", "vtk", "pvd", "frd", "rpt")), "printed.dat"), _read
    ),
    "result.nc": lambda path: stored_solution(path, load_scene("hertz-paper")),
    "study.toml": load_study,
    "study.json": load_study,
    "sweep.json": lambda path: read_index(path.parent),
    "stored.json": _stored_result,
    "baseline.json": findings.read_run_values,
    "solution.json": findings.read_run_values,
    "comparison.json": findings.read_run_values,
    MANIFEST: lambda path: usable_folder(path.parent),
}
DOORS = {name: Door(name, enter) for name, enter in ENTRANCES.items()}
# What is read in a process of its own, a second each: few are tried.
APART = ("result.vtu", "result.vtk", "result.pvd")


# --------------------------------------------------------------------------------------- good files
ADDRESS = "0" * 64
AXIS = {"name": "f", "key": "friction.coefficient", "values": [0.5, 1.0]}
STUDY = {
    "scene": "hertz-paper",
    "engines": ["exact"],
    "figures": ["exact.dissipation"],
    "axes": [AXIS],
}
POINTS = [{"number": 0, "address": ADDRESS, "coordinates": {"f": 0.5}}]


# Field output of Abaqus: four nodes, two of them in contact, at two frames.
def report_frame(frame: int) -> str:
    """One frame of the report."""
    head = "".join(f"{name:>16}" for name in ("Node", "COORD.COORD1", "CPRESS", "CSHEAR1"))
    rows = ""
    for node in range(4):
        pressure = 95.0 if node in (1, 2) else 0.0
        shear = 1.5 * frame if node == 1 else 0.0
        rows += f"{node:>16}{node / 4:>16}{pressure:>16}{shear:>16}\n"
    return (
        f"{'*' * 80}\nField Output Report, written Tue Feb  3 2026\n\n   Step: Step-1\n   Frame:"
        f" Increment {frame}: Step Time = {frame}.5\n\nField Output reported at nodes for part:"
        f" BLOCK-1\n\n{head}\n           Label{'@Loc 1':>16}{'@Loc 1':>16}{'@Loc 1':>16}\n"
        f"{'-' * 64}\n{rows}"
    )


REPORT = report_frame(1) + "\n" + report_frame(2)
# Those that are the same every time.
PLAIN = {
    "series.csv": [
        "time,P,Q\n0,0,0\n1,2.5,0.5\n2,2,1\n3,1.5,-0.25\n",
        "Rig 1\nTime [s];FN [N/mm];FT [N/mm]\n0;0;0\n0,5;2,5;0,5\n2;2;1\n",
    ],
    "result.rpt": [REPORT],
    "profile.csv": ["x,h\n0,0\n0.5,0.1\n1,0.5\n2.0,2\n", "-2,2\n-1,0.5\n0,0\n1,0.5\n2,2\n"],
    "fit.csv": [
        "".join(
            [
                "x [mm];h [um]\n",
                *(f"{0.1 * k:.1f};{5.0 * k * k + k % 3:.0f}\n" for k in range(-12, 13)),
            ]
        ),
        "".join(
            [
                "x,h\n",
                *(
                    f"{0.05 * k:.4g},{0.005 * max(k - 4, 0) ** 2 + 1e-5 * (k % 2):.5g}\n"
                    for k in range(20)
                ),
            ]
        ),
        # few digits of x
        "".join(
            ["x;h\n", *(f"{k // 2 / 10:.1f};{(k // 2) ** 2 + k % 2}\n" for k in range(-24, 25))]
        ),
    ],
    "mapping.toml": [
        'code = "mine"\nthickness = 2.0\ntimes = [0.0, 1.0]\n[columns]\npressure ='
        ' "p"\n[factors]\nlength = 1000\n[signs]\nshear = "on upper"\n[element_sizes]\n"a.csv" ='
        " 0.5\n"
    ],
    "study.toml": [
        'scene = "hertz-paper"\nengines = ["exact"]\nfigures ='
        ' ["exact.dissipation"]\n[set]\n"mesh.order" = 1\n[derived]\nradius = "2 * f **'
        ' 2"\n[[axes]]\nname = "f"\nkey = "friction.coefficient"\nlinear = {start = 1.0, stop ='
        ' 2.0, count = 12}\n[[axes]]\nname = "g"\nkey = "cycles"\nvalues = [1, 2]\n'
    ],
    "study.json": [json.dumps(STUDY)],
    "result.pvd": [
        '<VTKFile type="Collection"><Collection><DataSet timestep="1.0"'
        ' file="field.vtu"/></Collection></VTKFile>'
    ],
    MANIFEST: [
        '{"written by": "halfplane", "files": ["report.html", "figures/a.csv", "manifest.json"]}'
    ],
}


def good_files(name: str, folder: Path) -> list[bytes]:
    """What the door of that name reads."""

    def field(file: str, **how: object) -> bytes:
        mesh(pressure=lambda p: pressure_at(p[:, 0]), shear=lambda p: shear_at(p[:, 0])).write(
            folder / file, **how
        )
        return (folder / file).read_bytes()

    solution = exact(steps=3, points=5)
    content = {
        **strict_json_values(solution_content(solution, ())),
        "scene": solution.scene.model_dump(mode="json"),
    }
    match name:
        case "result.pvd":
            field("field.vtu")
        case "scene.toml":
            names = (
                "hertz-paper",
                "blocks",
                "harmonics",
                "unlike-beta-fifth",
                "compound-curvature",
            )
            return [scene_text(scene).encode() for scene in names]
        case "scene.json":
            scenes = map(load_scene, ("hertz-paper", "time-series"))
            return [scene.model_dump_json().encode() for scene in scenes]
        case "result.csv":
            return [written(rows(exact(steps=9, points=15)), folder / "seed.csv").read_bytes()]
        case "result.vtu":
            return [field("field.vtu"), field("field.vtu", binary=False)]
        case "result.vtk":
            return [field("field.vtk")]
        case "result.frd":  # files that CalculiX wrote
            return [(DATA / "mortar.frd").read_bytes()]
        case "printed.dat":
            (folder / "printed.frd").write_bytes((DATA / "node-to-surface.frd").read_bytes())
            return [(DATA / "node-to-surface.dat").read_bytes()]
        case "result.nc":
            solution.save(folder / "seed.nc")
            return [(folder / "seed.nc").read_bytes()]
        case "sweep.json":
            study = json.loads(study_of(STUDY, "seed").model_dump_json())
            return [
                json.dumps(
                    {"format": "halfplane sweep 1", "study": study, "points": POINTS}
                ).encode()
            ]
        case "stored.json":
            answer = {
                "address": ADDRESS,
                "status": "done",
                "figures": {"exact.dissipation": 1.0},
                "seconds": 1.0,
                "reason": "",
            }
            stored = {
                "format": "halfplane sweep 1",
                "sha256": checksum(canonical_json(answer)),
                "result": answer,
            }
            return [json.dumps(stored).encode()]
        case "baseline.json":
            findings.write_baseline(
                findings.run_values_of_solution(solution, "seed"),
                folder / "seed.json",
                {"semi_analytic.*": 1e-9},
            )
            return [(folder / "seed.json").read_bytes()]
        case "solution.json":
            return [json.dumps({"format": findings.FORMAT_OF_SOLUTION, **content}).encode()]
        case "comparison.json":
            parts = {
                "reference": content,
                "result": {**content, "engine": "other"},
                "scene": content["scene"],
            }
            metrics = {"dissipation": {"value": 0.1, "finite": True}}
            return [
                json.dumps(
                    {"format": "halfplane comparison 2", "metrics": metrics, **parts}
                ).encode()
            ]
    return [text.encode() for text in PLAIN[name]]
