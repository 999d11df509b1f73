"""Other people's codes beside ours on the same scene in the same run: normal Hertz contact, and
Cattaneo and Mindlin's at 0.6 f P.

A code that is not installed is left out, and the page states it; `make peers` installs them. Finite
element codes get the nodes, elements and loads of the deck that `halfplane export` writes. Times
are CPU times with all set-up and without imports.
"""

from __future__ import annotations

import functools
import io
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import textwrap
import time
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from claims import ROOT, markdown, stored, with_children
from finite_elements import FEW_STEPS, cattaneo_mindlin

import halfplane_fe
import semi_analytic
from halfplane_fe import SolverSettings
from meshes import MeshSettings
from scenes import Scene, load_scene

sys.path.insert(0, str(ROOT / "tests"))
from semi_analytic import grid as dense_grid

Array = np.ndarray
TITLE = "Beside other codes"
RUNS = 3
HERE = Path(__file__).parent
# Where `make peers` puts other people's Python packages; Debian's own interpreter has Debian's.
PEERS = Path(os.environ.get("HALFPLANE_PEERS", ROOT / ".peers")) / "bin" / "python"
DEBIAN = Path("/usr/bin/python3")
KRATOS = ROOT / "docs" / "examples" / "score" / "kratos" / "make.py"
PERIOD = 64.0
PER_HALF_WIDTH = (20, 40, 80, 160)
EDGES = (40, 80, 160)
# Growth of the bulk's elements in the peers' decks: coarser ones leave errors that no finer contact
# takes away.
GROWTH = {40: 0.4, 80: 0.2, 160: 0.1}
# Our least mesh whose shear is as good as that of Kratos on elements of a/80.
COARSER = MeshSettings(element_size=1 / 16, edge_element_size=1 / 24, far_radius=6.0, growth=0.5)
OURS = "halfplane, finite elements"
THEORY = "halfplane, theory"


class Answer(NamedTuple):
    """Tractions of a code at points, and the CPU seconds that they took."""

    x: Array
    p: Array
    q: Array | None
    seconds: float


# -------------------------------------------------------------------------------------------- codes
def hertz() -> tuple[float, float, float]:
    """E*, R and P of the library's hertz-normal, of which a = 1."""
    scene = load_scene("hertz-normal")
    steel = scene.material.lower
    modulus = steel.young_modulus / (1 - steel.poisson_ratio**2) / 2
    return modulus, scene.profile.radius, np.pi * modulus / (4 * scene.profile.radius)


def interpreted(python: Path, code: str, **question: Any) -> dict[str, Any]:
    """The answer of peer_codes.py in another interpreter."""
    with tempfile.TemporaryDirectory() as folder:
        asked = Path(folder) / "question.npz"
        answer = Path(folder) / "answer.npz"
        np.savez(asked, **question)
        command = [str(python), str(HERE / "peer_codes.py"), code, str(asked), str(answer)]
        subprocess.run(
            command, check=True, capture_output=True, env=os.environ | {"OMP_NUM_THREADS": "1"}
        )
        with np.load(answer) as arrays:
            return {name: arrays[name] for name in arrays.files}


def periodic(code: str, per_half_width: int) -> Answer:
    """Hertz by a code for periodic half-spaces."""
    modulus, radius, load = hertz()
    question = {
        "modulus": modulus,
        "radius": radius,
        "load": load,
        "period": PERIOD,
        "points": int(PERIOD * per_half_width),
    }
    arrays = interpreted(PEERS, code, **question)
    return Answer(arrays["x"], arrays["p"], None, float(arrays["seconds"]))


def naive_hertz(per_half_width: int) -> Answer:
    modulus, radius, load = hertz()
    begun = time.process_time()
    extent = (-1.1, 1.1)
    cells = round(2.2 * per_half_width)
    answer = dense_grid.follow_instants(
        lambda x: x**2 / (2 * radius), extent, cells, 1.0, [load], [0.0], modulus=modulus
    )
    return Answer(answer.x, answer.pressure[0], None, time.process_time() - begun)


def our_theory(scene: Scene, at: float) -> Answer:
    begun = time.process_time()
    answer = semi_analytic.solve(
        scene, x=np.linspace(-1.05, 1.05, 200), time=[at], fields=("pressure", "shear")
    )
    return Answer(answer.x, answer.pressure[0], answer.shear[0], time.process_time() - begun)


def our_model(scene: Scene, mesh: MeshSettings, solver: SolverSettings) -> Answer:
    begun = time.process_time()
    answer = halfplane_fe.solve(scene, mesh, solver)
    return Answer(answer.x, answer.pressure[-1], answer.shear[-1], time.process_time() - begun)


def deck_of(scene: Scene, edge: int) -> tuple[Any, str, float]:
    """The bodies as CalculiX gets them, with few increments, on which the answer does not depend;
    its text; CPU seconds.
    """
    from reports.studies.third.deck import DeckSettings, build_deck, deck_text

    begun = time.process_time()
    sizes = {
        "edge_element_size": 1 / edge,
        "element_size": min(1 / 20, 2 / edge),
        "growth": GROWTH[edge],
    }
    deck = build_deck(scene, DeckSettings(steps_per_cycle=4, **sizes))
    return deck, deck_text(deck), time.process_time() - begun


def getfem(scene: Scene, edge: int) -> Answer:
    """By GetFEM: augmented Lagrangian, both bodies of the deck, P in one step and Q in another."""
    deck, _, meshed = deck_of(scene, edge)
    question: dict[str, Any] = {
        "normal": deck.normal_load[[-1, -1]],
        "tangential": np.array([0.0, deck.tangential_load[-1]]),
    }
    for name, body in (("lower", deck.lower), ("upper", deck.upper)):
        question[f"{name}_nodes"] = body.nodes
        question[f"{name}_elements"] = body.elements - body.first_node
        question[f"{name}_contact"] = body.nodes[body.contact_nodes - body.first_node]
        question[f"{name}_held"] = body.nodes[body.held[1] - body.first_node]
    steel = scene.material.lower
    question["numbers"] = [
        steel.young_modulus,
        steel.poisson_ratio,
        scene.friction.coefficient,
        4 * deck.touch_approach,
    ]
    arrays = interpreted(DEBIAN, "getfem", **question)
    order = np.argsort(arrays["x"])
    return Answer(
        arrays["x"][order],
        arrays["p"][order],
        arrays["q"][order],
        float(arrays["seconds"]) + meshed,
    )


def kratos(scene: Scene, edge: int) -> Answer:
    """By Kratos: dual mortar, augmented Lagrangian, on the deck as written."""
    _, text, meshed = deck_of(scene, edge)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "deck.inp").write_text(text, encoding="utf-8")
        command = [str(PEERS), str(KRATOS), str(folder / "deck.inp"), str(folder / "result.csv")]
        subprocess.run(
            command,
            check=True,
            capture_output=True,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
            cwd=folder,
        )
        rows = np.loadtxt(folder / "result.csv", delimiter=",", skiprows=1)
        spent = stored(folder / "made.json")["seconds"]
    last = rows[rows[:, 0] == rows[-1, 0]]
    return Answer(last[:, 3], last[:, 4], last[:, 5], spent + meshed)


def calculix(scene: Scene, edge: int) -> Answer:
    """By CalculiX: penalty, on the deck as written; its own process and ours that writes the
    deck.
    """
    from reports.console import Stages
    from reports.studies.third.calculix import find_calculix, run_calculix, score_deck

    deck, text, meshed = deck_of(scene, edge)
    with tempfile.TemporaryDirectory() as name, Stages(quiet=True).stage("CalculiX") as report:
        folder = Path(name)
        (folder / "third.inp").write_text(text, encoding="utf-8")
        run = (find_calculix(), folder, "third", float(deck.deck_time[-1]), 600.0, report)
        spent, _ = with_children(lambda: run_calculix(*run))
        answer = score_deck(folder / "third.frd", deck, "CalculiX").comparison.result
    return Answer(answer.x, answer.pressure[-1], answer.shear[-1], spent + meshed)


# How each code is found: a program, a package of Debian's interpreter, or one of `make peers`'
# interpreter.
CODES = {
    "tamaas": PEERS,
    "ContactMechanics": PEERS,
    "KratosMultiphysics": PEERS,
    "GetFEM": DEBIAN,
    "CalculiX": Path("ccx"),
}
VERSION = "from importlib.metadata import version as v; print(v({!r}))"


@functools.cache
def version_of(code: str) -> str | None:
    """The version of a code; None where it is not there."""
    where = CODES[code]
    command = [str(where), "-c", VERSION.format(code)]
    if code == "CalculiX":
        command = ["ccx", "-v"]
    elif code == "GetFEM":
        command = ["dpkg-query", "-W", "-f", "${Version}", "python3-getfem"]
    if shutil.which(command[0]) is None:
        return None
    words = subprocess.run(command, check=False, capture_output=True, text=True).stdout.split()
    return words[-1] if words else None


def lines_by_hand() -> dict[str, int]:
    """Lines of code that a user writes for the scene: logical ones, however they are broken."""

    def count(text: str) -> int:
        readline = io.StringIO(textwrap.dedent(text)).readline
        return sum(token.type == tokenize.NEWLINE for token in tokenize.generate_tokens(readline))

    def read(file: Path) -> str:
        return file.read_text(encoding="utf-8")

    codes = read(HERE / "peer_codes.py")
    lines = {
        name: count(codes.partition(f"# by hand: {name}\n")[2].partition("# so far")[0])
        for name in ("tamaas", "contactmechanics", "getfem")
    }
    # The scene file is what is written for ours, without what it expects of itself.
    scene = read(ROOT / "scenes" / "library" / "cattaneo-mindlin.toml").partition("[[expected]]")[0]
    written = sum(map(bool, map(str.strip, scene.splitlines())))
    lines |= {"kratos": count(read(KRATOS)), "naive": count(read(Path(dense_grid.__file__)))}
    return lines | {"ours": written, "calculix": written}


# ---------------------------------------------------------------------------------------- measuring
def closed_form(scene: Scene, x: Array) -> tuple[Array, Array]:
    """p of Hertz (1882) and q of Cattaneo (1938) at the end of the path; shares nothing with either
    engine.
    """
    modulus, radius, _ = hertz()
    load, shear = scene.load.initial_loading[-1]
    a = float(np.sqrt(4 * load * radius / (np.pi * modulus)))
    f = scene.friction.coefficient

    def ellipse(half_width: float) -> Array:
        return 2 * load / (np.pi * a**2) * np.sqrt(np.maximum(half_width**2 - x**2, 0.0))

    return ellipse(a), (
        f * (ellipse(a) - ellipse(a * float(np.sqrt(1 - shear / (f * load))))) if shear else 0 * x
    )


def judged_answer(answer: Answer, scene: Scene) -> dict[str, float | None]:
    """L2 errors over those of the closed form at the code's own points, weighted by their spacing;
    peak pressure.
    """
    near = np.abs(answer.x) < 1.5
    x = answer.x[near]
    (p, q) = closed_form(scene, x)
    weight = np.gradient(x)

    def norm(values: Array) -> float:
        return float(np.sqrt(weight @ values**2))

    largest = float(closed_form(scene, np.zeros(1))[0][0])
    shear = norm(answer.q[near] - q) / norm(q) if answer.q is not None and q.any() else None
    return {
        "p": norm(answer.p[near] - p) / norm(p),
        "q": shear,
        "peak": float(np.max(answer.p)) / largest - 1,
    }


Entry = tuple[str, str, str, Callable[[], Answer]]  # code, size, key of its lines by hand, how


def ours(scene: Scene, solver: SolverSettings) -> list[Entry]:
    cut = {
        f"a/{edge}": MeshSettings(element_size=1 / 24, edge_element_size=1 / edge) for edge in EDGES
    }
    return [
        (OURS, size, "ours", lambda mesh=mesh: our_model(scene, mesh, solver))
        for size, mesh in cut.items()
    ]


def normal_entries() -> Iterator[Entry]:
    """Hertz, normal load alone."""
    scene = load_scene("hertz-normal")
    yield THEORY, "200 points", "ours", lambda: our_theory(scene, 1.0)
    yield from ours(scene, SolverSettings(steps_per_cycle=8))
    for n in PER_HALF_WIDTH:
        yield "naive discretised half-plane", f"a/{n}", "naive", lambda n=n: naive_hertz(n)
        for code in ("tamaas", *(["ContactMechanics"] if n in (40, 160) else [])):
            if version_of(code):
                yield code, f"a/{n}", code.lower(), lambda n=n, code=code: periodic(code.lower(), n)


def shear_entries() -> Iterator[Entry]:
    """Cattaneo and Mindlin, first loading up to Q = 0.6 f P."""
    scene = cattaneo_mindlin()
    yield THEORY, "200 points", "ours", lambda: our_theory(scene, 2.0)
    for size, mesh in {"a/24": COARSER, "coarse": MeshSettings.coarse()}.items():
        yield OURS, size, "ours", lambda mesh=mesh: our_model(scene, mesh, FEW_STEPS)
    yield from ours(scene, FEW_STEPS)
    codes = (
        ("GetFEM", getfem, EDGES),
        ("KratosMultiphysics", kratos, EDGES[:2]),
        ("CalculiX", calculix, EDGES[:1]),
    )
    for edge in EDGES:
        for code, solve, edges in codes:
            if version_of(code) and edge in edges:
                name = code.removesuffix("Multiphysics")
                yield (
                    name,
                    f"a/{edge}",
                    name.lower(),
                    lambda edge=edge, solve=solve: solve(scene, edge),
                )


def measured(entries: Iterator[Entry], scene: Scene) -> list[dict[str, Any]]:
    """All entries in turn, those slower than 2 s twice: CPU seconds, errors against the closed
    form, or why there is no answer.
    """
    rows: list[tuple[dict[str, Any], Callable[[], Answer]]] = [
        ({"code": code, "size": size, "lines": key, "seconds": []}, work)
        for code, size, key, work in entries
    ]
    for turn in range(RUNS):
        for row, work in rows:
            if turn > 1 and min(row["seconds"], default=0.0) > 2.0:
                continue
            try:
                answer = work()
            except (subprocess.CalledProcessError, RuntimeError, ValueError) as failure:
                message = getattr(failure, "stderr", b"") or str(failure).encode()
                row["failure"] = message.decode(errors="replace").strip().splitlines()[-1][:300]
                row["seconds"].append(float("nan"))
                print(f"    {row['code']} {row['size']}: {row['failure']}", flush=True)
            else:
                row["seconds"].append(answer.seconds)
                row.update(judged_answer(answer, scene))
    return [row for row, _ in rows]


def measure() -> dict[str, Any]:
    """Both scenes."""
    return {
        "normal": measured(normal_entries(), load_scene("hertz-normal")),
        "shear": measured(shear_entries(), cattaneo_mindlin()),
        "lines": lines_by_hand(),
        "versions": {name: version_of(name) for name in CODES if version_of(name)},
        "missing": [name for name in CODES if not version_of(name)],
    }


# --------------------------------------------------------------------------------------------- page
SHOWN = (
    ("normal", "p", "Hertz, normal load: pressure"),
    ("shear", "q", "Cattaneo-Mindlin, Q = 0.6 f P: shear"),
)


def panels(stored_rows: dict[str, Any]) -> list[tuple]:
    """Error over time, a panel a scene."""
    drawn = []
    for name, key, title in SHOWN:
        lines: dict[str, list[tuple[float, float]]] = {}
        for row in stored_rows[name]:
            if row.get(key) is not None:
                lines.setdefault(row["code"], []).append(
                    (statistics.median(row["seconds"]), max(row[key], 1e-16))
                )
        drawn.append((title, "CPU time, set-up included [s]", f"relative L2 error of {key}", lines))
    return drawn


def rival(row: dict[str, Any], rows: list[dict[str, Any]], key: str) -> dict[str, Any] | None:
    """Our quickest setting that is at least as exact as another code's row; None for our own rows
    or where there is none.
    """
    if row["code"].startswith("halfplane") or row.get(key) is None:
        return None
    our_rows = [our_row for our_row in rows if our_row["code"] == OURS and our_row[key] <= row[key]]
    return min(our_rows, key=lambda our_row: statistics.median(our_row["seconds"]), default=None)


def times_faster(row: dict[str, Any], rows: list[dict[str, Any]], key: str) -> float:
    """Median time of another code's row over that of our quickest setting that is as exact; NaN
    where there is none.
    """
    best = rival(row, rows, key)
    return (
        statistics.median(row["seconds"]) / statistics.median(best["seconds"])
        if best
        else float("nan")
    )


def _rows(stored_rows: dict[str, Any], name: str, key: str) -> list[tuple[str, ...]]:
    """A row for each code: its finest setting."""
    finest = {row["code"]: row for row in stored_rows[name]}
    cells = []
    for code, row in finest.items():
        if "failure" in row:
            cells.append((code, row["size"], f"no answer: {row['failure']}", "–", "–"))
            continue
        spent = f"{statistics.median(row['seconds']):.2g}"
        ratio = "–"
        if not code.startswith("halfplane"):
            best = rival(row, stored_rows[name], key)
            ratio = "ours is nowhere as exact"
            if best:
                ratio = f"{times_faster(row, stored_rows[name], key):.2g}"
        cells.append((code, row["size"], f"{row[key]:.1e}", spent, ratio))
    return cells


def page(stored_rows: dict[str, Any]) -> list[str]:
    """Each code at its finest, the ratios, what is missing."""
    missing = (
        f" Not installed, so not measured: {', '.join(stored_rows['missing'])} (`make peers`)."
        if stored_rows["missing"]
        else ""
    )
    share = (np.pi / PERIOD) ** 2 / 12
    lines = [
        (
            "Medians, each code at its finest: p (tamaas, ContactMechanics: contacts in a row,"
            f" {share:.0e} too high), q at Q = 0.6 f P.{missing}"
        ),
        "",
    ]
    head = "code | h | error, L2 | time [s] | over ours as exact"
    cells = []
    for name, key, _ in SHOWN:
        cells += [(f"{row[0]}: {key}", *row[1:]) for row in _rows(stored_rows, name, key)]
    faster = []
    for name, key, _ in SHOWN:
        for code in dict.fromkeys(row["code"] for row in stored_rows[name]):
            ratios = [
                times_faster(row, stored_rows[name], key)
                for row in stored_rows[name]
                if row["code"] == code
            ]
            least = np.nanmin([*ratios, np.inf])
            if least < 1:
                faster.append(f"{code} {1 / least:.0f} times ({key})")
    losses = ", ".join(faster) or "none"
    return [
        *lines,
        *markdown(head, cells),
        "",
        f"Faster than our finite elements at its own error, by up to: {losses}.",
    ]
