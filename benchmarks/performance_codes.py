"""Other codes and ours on normal Hertz contact and on Cattaneo and Mindlin's: how each is asked, and what it takes by hand."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import discretised_half_plane as naive
import numpy as np
from numpy.typing import NDArray

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.console import Stages
from reports.third.calculix import calculix_version, find_calculix, judged, run_calculix
from reports.third.deck import Deck, DeckSettings, build_deck
from reports.third.dialects import deck_text
from scenes import Scene, load_scene

Array = NDArray[np.float64]
HERE = Path(__file__).parent
ROOT = HERE.parent
# Where `make peers` puts other people's Python packages; Debian's own interpreter has Debian's.
PEERS = Path(os.environ.get("HALFPLANE_PEERS", ROOT / ".peers")) / "bin" / "python"
DEBIAN = Path("/usr/bin/python3")
KRATOS = ROOT / "docs" / "examples" / "score" / "kratos" / "make.py"
PERIOD, PER_HALF_WIDTH = 64.0, (20, 40, 80, 160)
EDGES = (40, 80, 160)


@dataclass(frozen=True)
class Answer:
    """Tractions of a code at points, and the CPU seconds that they took."""

    x: Array
    p: Array
    q: Array | None
    seconds: float


def hertz() -> tuple[float, float, float]:
    """E*, R and P of the library's hertz-normal, of which a = 1."""
    scene = load_scene("hertz-normal")
    steel = scene.material.lower
    modulus = steel.young_modulus / (1 - steel.poisson_ratio**2) / 2
    return modulus, scene.profile.radius, np.pi * modulus / (4 * scene.profile.radius)


def interpreted(python: Path, script: str, *arguments: str) -> dict[str, Any]:
    """What a peer's script leaves in its answer."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "answer.npz"
        command = [str(python), str(HERE / script), *arguments, str(file)]
        subprocess.run(command, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"})
        with np.load(file) as found:
            return {name: found[name] for name in found.files}


def periodic(script: str, per_half_width: int) -> Answer:
    """Hertz by a code for periodic half-spaces."""
    modulus, radius, load = hertz()
    asked = {"modulus": modulus, "radius": radius, "load": load, "period": PERIOD, "points": int(PERIOD * per_half_width)}
    found = interpreted(PEERS, script, json.dumps(asked))
    return Answer(found["x"], found["p"], None, float(found["seconds"]))


def naive_hertz(per_half_width: int) -> Answer:
    """The naive peer of our own benchmarks."""
    modulus, radius, load = hertz()
    begun = time.process_time()
    on = naive.grid(1.1, round(2.2 * per_half_width), modulus)
    pressure = naive.press(on, naive.hertz_gap(radius)(on.x), load, np.ones(len(on.x), dtype=bool))
    return Answer(on.x, pressure, None, time.process_time() - begun)


def our_theory(scene: Scene, at: float) -> Answer:
    begun = time.process_time()
    answer = semi_analytic.solve(scene, x=np.linspace(-1.05, 1.05, 200), time=[at], fields=("pressure", "shear"))
    return Answer(answer.x, answer.pressure[0], answer.shear[0], time.process_time() - begun)


def our_model(scene: Scene, mesh: MeshSettings, solver: SolverSettings) -> Answer:
    begun = time.process_time()
    answer = halfplane_fe.solve(scene, mesh, solver)
    seconds = time.process_time() - begun
    return Answer(answer.x, answer.pressure[-1], answer.shear[-1], seconds)


def cut(edge: int) -> MeshSettings:
    return MeshSettings(element_size=1 / 24, edge_element_size=1 / edge)


# Growth of the bulk's elements in the peers' decks: coarser ones leave errors that no finer contact takes away.
GROWTH = {40: 0.4, 80: 0.2, 160: 0.1}


def deck_of(scene: Scene, edge: int) -> Deck:
    """The bodies as CalculiX gets them, with few increments: the answer of this scene does not depend on them."""
    middle = min(1 / 20, 2 / edge)
    cut_as = DeckSettings(edge_element_size=1 / edge, element_size=middle, steps_per_cycle=4, growth=GROWTH[edge])
    return build_deck(scene, cut_as)


def getfem(scene: Scene, edge: int) -> Answer:
    """By GetFEM: augmented Lagrangian, both bodies of the deck, P in one step and Q in another."""
    begun = time.process_time()
    deck = deck_of(scene, edge)
    question: dict[str, Any] = {"normal": deck.normal_load[[-1, -1]], "tangential": np.array([0.0, deck.tangential_load[-1]])}
    for name, body in (("lower", deck.lower), ("upper", deck.upper)):
        question[f"{name}_nodes"], question[f"{name}_elements"] = body.nodes, body.elements - body.first_node
        question[f"{name}_contact"] = body.nodes[body.contact_nodes - body.first_node]
        question[f"{name}_held"] = body.nodes[body.held[1] - body.first_node]
    steel = scene.material.lower
    question["numbers"] = [steel.young_modulus, steel.poisson_ratio, scene.friction.coefficient, 4 * deck.touch_approach]
    meshed = time.process_time() - begun
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "question.npz"
        np.savez(file, **question)
        found = interpreted(DEBIAN, "performance_peer_getfem.py", str(file))
    order = np.argsort(found["x"])
    return Answer(found["x"][order], found["p"][order], found["q"][order], float(found["seconds"]) + meshed)


def kratos(scene: Scene, edge: int) -> Answer:
    """By Kratos: dual mortar, augmented Lagrangian, on the deck as written."""
    begun = time.process_time()
    deck = deck_of(scene, edge)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "deck.inp").write_text(deck_text(deck, "calculix"), encoding="utf-8")
        meshed = time.process_time() - begun
        command = [str(PEERS), str(KRATOS), str(folder / "deck.inp"), str(folder / "result.csv")]
        subprocess.run(command, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"}, cwd=folder)
        rows = np.loadtxt(folder / "result.csv", delimiter=",", skiprows=1)
        seconds = json.loads((folder / "made.json").read_text(encoding="utf-8"))["seconds"]
    last = rows[rows[:, 0] == rows[-1, 0]]
    return Answer(last[:, 3], last[:, 4], last[:, 5], seconds + meshed)


def calculix(scene: Scene, edge: int) -> Answer:
    """By CalculiX: penalty, on the deck as written; its own process and ours that writes the deck."""
    begun = time.process_time()
    deck = deck_of(scene, edge)
    program = find_calculix()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "third.inp").write_text(deck_text(deck, "calculix"), encoding="utf-8")
        meshed, before = time.process_time() - begun, _children()
        with Stages(quiet=True).stage("CalculiX") as report:
            run_calculix(program, folder, "third", float(deck.deck_time[-1]), 600.0, report)
        seconds = _children() - before
        found = judged(folder / "third.frd", deck, "CalculiX").result
    return Answer(found.x, found.pressure[-1], found.shear[-1], seconds + meshed)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def has(code: str) -> bool:
    """Whether a code is there."""
    if code == "ccx":
        return shutil.which("ccx") is not None
    python = DEBIAN if code == "getfem" else PEERS
    if not python.exists():
        return False
    find = f"import importlib.util as u, sys; sys.exit(u.find_spec({code!r}) is None)"
    return subprocess.run([str(python), "-c", find], check=False, capture_output=True).returncode == 0


def lines_by_hand() -> dict[str, int]:
    """Lines of code that a user writes for the scene, blank ones and comments left out."""

    def between(file: Path, start: str | None) -> int:
        lines = file.read_text(encoding="utf-8").splitlines()
        if start is not None:
            lines = lines[lines.index(start) + 1 : lines.index("# so far")]
        return sum(bool(line.strip()) and not line.strip().startswith("#") for line in lines)

    found = {name: between(HERE / f"performance_peer_{name}.py", "# by hand") for name in ("tamaas", "contactmechanics", "getfem")}
    # The scene file is what is written for ours, without what it expects of itself.
    scene = (ROOT / "scenes" / "library" / "cattaneo-mindlin.toml").read_text(encoding="utf-8").split("[[expected]]")[0]
    written = sum(bool(line.strip()) for line in scene.splitlines())
    return found | {
        "kratos": between(KRATOS, None),
        "naive": between(Path(naive.__file__), None),
        "ours": written,
        "calculix": written,
    }


def versions() -> dict[str, str]:
    """Of the codes that are there."""
    found = {"CalculiX": calculix_version(find_calculix())} if has("ccx") else {}
    for name in ("tamaas", "ContactMechanics", "KratosMultiphysics"):
        if has(name):
            command = [str(PEERS), "-c", f"from importlib.metadata import version; print(version({name!r}))"]
            found[name] = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    if has("getfem"):
        command = ["dpkg-query", "-W", "-f", "${Version}", "python3-getfem"]
        found["GetFEM"] = subprocess.run(command, check=False, capture_output=True, text=True).stdout.strip()
    return found
