"""Other people's codes beside ours on the same scene in the same run: normal Hertz contact, and Cattaneo and Mindlin's at 0.6 f P.

A code that is not installed is left out, and the page says so; `make peers` installs them. Finite element codes get the nodes,
elements and loads of the deck that `halfplane export` writes. Times are CPU times with all set-up and without imports.
"""

from __future__ import annotations

import statistics
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fe_peers
import numpy as np
from numpy.typing import NDArray
from performance_codes import (
    EDGES,
    PER_HALF_WIDTH,
    PERIOD,
    Answer,
    calculix,
    cut,
    getfem,
    has,
    hertz,
    kratos,
    lines_by_hand,
    naive_hertz,
    our_model,
    our_theory,
    periodic,
    versions,
)

from halfplane_fe import SolverSettings
from meshes import MeshSettings
from reports.charts.publication import canvas, label_axes
from reports.charts.style import COLOURS
from scenes import Scene, load_scene

Array = NDArray[np.float64]
TITLE = "Beside other codes"
RUNS = 3


def closed_form(scene: Scene, x: Array) -> tuple[Array, Array]:
    """p of Hertz (1882) and q of Cattaneo (1938) at the end of the path; shares nothing with either engine."""
    modulus, radius, _ = hertz()
    load, shear = scene.load.initial_loading[-1]
    a, f = float(np.sqrt(4 * load * radius / (np.pi * modulus))), scene.friction.coefficient

    def ellipse(half_width: float) -> Array:
        return np.sqrt(np.maximum(half_width**2 - x**2, 0.0))

    slope = 2 * load / (np.pi * a**2)
    return slope * ellipse(a), f * slope * (ellipse(a) - ellipse(a * float(np.sqrt(1 - shear / (f * load))))) if shear else 0 * x


def judged_answer(answer: Answer, scene: Scene) -> dict[str, float | None]:
    """L2 errors over those of the closed form at the code's own points, weighted by their spacing; peak pressure."""
    near = np.abs(answer.x) < 1.5
    x = answer.x[near]
    p, q = closed_form(scene, x)
    weight = np.gradient(x)

    def norm(values: Array) -> float:
        return float(np.sqrt(weight @ values**2))

    largest = float(closed_form(scene, np.zeros(1))[0][0])
    shear = norm(answer.q[near] - q) / norm(q) if answer.q is not None and q.any() else None
    return {"p": norm(answer.p[near] - p) / norm(p), "q": shear, "peak": float(np.max(answer.p)) / largest - 1}


Entry = tuple[str, str, str, Callable[[], Answer]]  # code, size, key of its lines by hand, how


def normal_entries() -> Iterator[Entry]:
    """Hertz, normal load alone."""
    scene = load_scene("hertz-normal")
    few = SolverSettings(steps_per_cycle=8)
    yield "halfplane, theory", "200 points", "ours", lambda: our_theory(scene, 1.0)
    for edge in EDGES:
        yield "halfplane, finite elements", f"a/{edge}", "ours", lambda edge=edge: our_model(scene, cut(edge), few)
    for n in PER_HALF_WIDTH:
        yield "naive discretised half-plane", f"a/{n}", "naive", lambda n=n: naive_hertz(n)
        if has("tamaas"):
            yield "tamaas", f"a/{n}", "tamaas", lambda n=n: periodic("performance_peer_tamaas.py", n)
        if has("ContactMechanics") and n in (40, 160):
            yield "ContactMechanics", f"a/{n}", "contactmechanics", lambda n=n: periodic("performance_peer_contactmechanics.py", n)


def shear_entries() -> Iterator[Entry]:
    """Cattaneo and Mindlin, first loading up to Q = 0.6 f P."""
    scene = fe_peers.cattaneo_mindlin((0.6,))
    yield "halfplane, theory", "200 points", "ours", lambda: our_theory(scene, 2.0)
    yield "halfplane, finite elements", "coarse", "ours", lambda: our_model(scene, MeshSettings.coarse(), fe_peers.FEW_STEPS)
    for edge in EDGES:
        yield "halfplane, finite elements", f"a/{edge}", "ours", lambda edge=edge: our_model(scene, cut(edge), fe_peers.FEW_STEPS)
    for edge in EDGES:
        if has("getfem"):
            yield "GetFEM", f"a/{edge}", "getfem", lambda edge=edge: getfem(scene, edge)
        if has("KratosMultiphysics") and edge < 160:
            yield "Kratos", f"a/{edge}", "kratos", lambda edge=edge: kratos(scene, edge)
    if has("ccx"):
        yield "CalculiX", "a/40", "calculix", lambda: calculix(scene, 40)


def table(entries: Iterator[Entry], scene: Scene) -> list[dict[str, Any]]:
    """Each entry once to warm up, where it is quick, then all of them in turn: least, median and most CPU seconds."""
    known = list(entries)
    times: dict[int, list[float]] = {place: [] for place in range(len(known))}
    errors: dict[int, dict[str, Any]] = {}
    for turn in range(RUNS):
        for place, (code, size, _, work) in enumerate(known):
            if turn and min(times[place], default=0.0) > 2.0 and turn > 1:
                continue  # twice is enough of the slow ones
            try:
                answer = work()
            except (subprocess.CalledProcessError, RuntimeError, ValueError) as failure:
                said = getattr(failure, "stderr", b"") or str(failure).encode()
                errors[place] = {"failure": said.decode(errors="replace").strip().splitlines()[-1][:300]}
                print(f"    {code} {size}: {errors[place]['failure']}", flush=True)
                times[place].append(float("nan"))
                continue
            times[place].append(answer.seconds)
            errors[place] = judged_answer(answer, scene)
    return [
        {"code": code, "size": size, "lines": key, "seconds": times[place], **errors[place]}
        for place, (code, size, key, _) in enumerate(known)
    ]


def measure() -> dict[str, Any]:
    """Both scenes."""
    needed = ("tamaas", "ContactMechanics", "getfem", "KratosMultiphysics", "ccx")
    return {
        "normal": table(normal_entries(), load_scene("hertz-normal")),
        "shear": table(shear_entries(), fe_peers.cattaneo_mindlin((0.6,))),
        "lines": lines_by_hand(),
        "versions": versions(),
        "missing": [name for name in needed if not has(name)],
    }


def _drawn(found: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    yield "normal", "p", "Hertz, normal load: pressure"
    yield "shear", "q", "Cattaneo-Mindlin, Q = 0.6 f P: shear"


def draw(found: dict[str, Any], folder: Path) -> None:
    """Error over time, a panel a scene."""
    with canvas(9.6, 4.2) as figure:
        axes = figure.subplots(1, 2)
        codes = list(dict.fromkeys(row["code"] for name in ("normal", "shear") for row in found[name]))
        for one, (name, key, title) in zip(axes, _drawn(found), strict=True):
            for number, code in enumerate(codes):
                rows = [row for row in found[name] if row["code"] == code and row.get(key) is not None]
                if not rows:
                    continue
                one.loglog(
                    [statistics.median(row["seconds"]) for row in rows],
                    [max(row[key], 1e-16) for row in rows],
                    marker="*osv^DPX"[number],
                    color=("#111111", *COLOURS)[number],
                    ms=10 if number == 0 else 5,
                    ls="-" if len(rows) > 1 else "none",
                    label=code,
                )
            label_axes(one, "CPU time, set-up included [s]", f"relative L2 error of {key}", title)
            one.set_ylim(5e-17, 0.5)
        handles = {text: mark for one in axes for mark, text in zip(*one.get_legend_handles_labels(), strict=True)}
        figure.legend(handles.values(), handles.keys(), loc="lower center", ncols=4, frameon=False)
        figure.tight_layout(rect=(0, 0.12, 1, 1))
        figure.savefig(folder / "peers.svg", metadata={"Date": None})


def page(found: dict[str, Any]) -> list[str]:
    """Two tables, the ratios, what is missing."""
    names = ", ".join(f"{name} {number}" for name, number in found["versions"].items())
    lines = [
        "![Error of the codes over CPU time](performance/peers.svg)",
        "",
        f"{names}. {RUNS} runs of each in turn, one thread; those slower than 2 s twice.",
    ]
    if found["missing"]:
        lines += ["", f"Not installed, so not measured: {', '.join(found['missing'])} (`make peers`)."]
    share = (np.pi / PERIOD) ** 2 / 12
    lines += [
        "",
        "### Hertz, normal load",
        "",
        f"tamaas and ContactMechanics solve a row of equal contacts, here {PERIOD:g} a apart. By the first term of the periodic "
        f"kernel that makes the peak pressure (π a/L)²/12 = {share:.1e} too high and the contact as much too narrow. "
        "What is above that is the grid.",
        "",
        *_table(found, "normal"),
        "",
        "### Cattaneo-Mindlin, Q = 0.6 f P, first loading",
        "",
        "The finite element codes have the bodies of the same deck, half-discs of 50 a cut into linear quadrilaterals, ours its "
        "own half-planes and quadratic triangles. Set-up is meshing (ours, in every row), reading, and all increments.",
        "",
        *_table(found, "shear"),
        "",
        "CalculiX on the whole cycles of the paper is on the page [A third opinion](third.md), with its times, which are too "
        "long for `make bench`. Peak p of theory is that of the 200 points, of which none is the middle.",
        "",
        "### Where ours loses",
        "",
        *_defeats(found),
    ]
    return lines


def _defeats(found: dict[str, Any]) -> list[str]:
    """Codes that are faster than our finite elements at no smaller error of theirs, and by how much at best."""
    lines = []
    for name, key, title in _drawn(found):
        faster: dict[str, tuple[float, dict[str, Any]]] = {}
        for row in found[name]:
            best = _rival(row, found[name], key)
            if best is None:
                continue
            times = statistics.median(best["seconds"]) / statistics.median(row["seconds"])
            if times > max(1.0, faster.get(row["code"], (0.0, row))[0]):
                faster[row["code"]] = times, row
        words = [f"{code} up to {times:.0f} times (at {row['size']})" for code, (times, row) in faster.items()]
        said = (
            f"faster than our finite elements at their own error are {', '.join(words)}"
            if words
            else "none is faster at its own error"
        )
        lines.append(f"- {title}: {said}.")
    return [
        *lines,
        "",
        "Half-space codes need no bulk: where the bodies are half-planes and the load is normal, they are the tool, or theory, "
        "which is ours too and whose error is rounding at the time of the first row. tamaas and ContactMechanics also take "
        "fewer lines by hand than our scene file has.",
    ]


def _table(found: dict[str, Any], name: str) -> list[str]:
    rows = found[name]
    lines = [
        "| code | h | p, L2 | peak p | q, L2 | CPU time: least, median, most [s] | over our finite elements at no larger error | "
        "lines by hand |",
        "|---|---|---|---|---|---|---|---|",
    ]
    key = "p" if name == "normal" else "q"
    for row in rows:
        if "failure" in row:
            lines.append(
                f"| {row['code']} | {row['size']} | | | | no answer: {row['failure']} | | {found['lines'][row['lines']]} |"
            )
            continue
        times = row["seconds"]
        spread = (
            f"{min(times):.3g}, {statistics.median(times):.3g}, {max(times):.3g}" if len(times) > 1 else f"{times[0]:.3g} (once)"
        )
        q = "" if row["q"] is None else f"{row['q']:.1e}"
        lines.append(
            f"| {row['code']} | {row['size']} | {row['p']:.1e} | {row['peak']:+.1e} | {q} | {spread} | {_ratio(row, rows, key)} | "
            f"{found['lines'][row['lines']]} |"
        )
    return lines


def _rival(row: dict[str, Any], rows: list[dict[str, Any]], key: str) -> dict[str, Any] | None:
    """Our quickest setting that is at least as exact as another code's row; None for our own rows or where there is none."""
    if row["code"].startswith("halfplane") or row.get(key) is None:
        return None
    own = [other for other in rows if other["code"] == "halfplane, finite elements" and other[key] <= row[key]]
    return min(own, key=lambda other: statistics.median(other["seconds"]), default=None)


def _ratio(row: dict[str, Any], rows: list[dict[str, Any]], key: str) -> str:
    """Time over that of our rival: least, median, most, of the runs of both."""
    best = _rival(row, rows, key)
    if best is None:
        return "" if row["code"].startswith("halfplane") else "ours is nowhere as exact"
    ratios = [one / other for one in row["seconds"] for other in best["seconds"]]
    return f"{min(ratios):.2g}, {statistics.median(ratios):.2g}, {max(ratios):.2g} ({best['size']})"
