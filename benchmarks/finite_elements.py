"""Claims of the finite elements on half-planes: errors against theory, edges, error and time, growth of the cost, page and run.

Times are CPU times of one thread with everything in them: the coarse run, mesh, condensation, every increment; nothing is read from
the store.
"""

from __future__ import annotations

import functools
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from claim import ROOT, Row, cold, rms, seconds
from threadpoolctl import threadpool_limits

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from halfplane_fe.elasticity import assemble, condense, factorise
from meshes import BodyMesh, MeshSettings, SurfaceGrading, solid
from reports import Comparison, compare, write
from reports.comparison.budget import theory_on_steps
from scenes import Block, Bodies, ContactSolution, Elastic, Hertz, PolygonLoad, Scene, load_scene

FREE = float("inf")
STEEL = Elastic(young_modulus=210e3, poisson_ratio=0.3)


# ----------------------------------------------------------------------------------------------------------- against theory
def beside_theory(result: ContactSolution) -> Comparison:
    """As `halfplane run` compares: theory on the points and instants of the result, and on the polygon of its increments."""
    reference = semi_analytic.solve(result.scene, x=result.x, time=result.time)
    return compare(reference, result, polygon_reference=theory_on_steps(result))


def against_theory() -> Iterator[Row]:
    """hertz-paper on the default mesh, against the half-plane engine; edges and laws are the healthy rows of must_fail.py."""
    answer, settings = halfplane_fe.solve(load_scene("hertz-paper")), MeshSettings()
    comparison = beside_theory(answer)
    how = (
        f"default mesh: h = a/{1 / settings.element_size:.0f}, a/{1 / settings.edge_element_size:.0f} at the edges, "
        f"{answer.work.counts['degrees of freedom']} dof, {answer.work.counts['steps solved']} increments"
    )
    for key, limit in {"dissipation": 1.5e-3, "peak_pressure": 2e-4, "pressure": 2.5e-3, "shear": 8e-3}.items():
        yield Row(f"hertz-paper, FE: {comparison.metric(key).label}", comparison.metric(key).value, limit, how)
    full = halfplane_fe.solve(load_scene("full-stick"))
    yield Row("full-stick, FE: dissipation", full.dissipation, 0.0, "exactly zero")
    increments = f"{full.work.counts['steps solved']} increments"
    yield Row("full-stick, FE: slip iterations", full.work.counts["slip iterations"], 0.0, increments)


def mindlin() -> Iterator[Row]:
    """Q = 0.6 f P on first loading, and over the cycle; and the other profile of the paper."""
    answer = halfplane_fe.solve(load_scene("cattaneo-mindlin"))
    exact = semi_analytic.solve(answer.scene, x=answer.x, time=answer.time)
    at, weights, f = int(np.argmin(np.abs(answer.time - 2.0))), answer.condensed[0].weights, answer.scene.friction.coefficient
    how = f"default mesh, {answer.work.counts['degrees of freedom']} dof, Q = 0.6 f P on first loading"

    def norm(values: np.ndarray) -> float:
        return float(np.sqrt(weights @ values**2))

    pressure, shear = exact.pressure[at], exact.shear[at]
    p_off, q_off = norm(answer.pressure[at] - pressure), norm(answer.shear[at] - shear)
    edge = np.abs(answer.stick_edges[at] - exact.stick_edges[at]).max() / answer.settings["element_size"]
    yield Row("cattaneo-mindlin, FE: peak pressure", float(answer.pressure[at].max() / pressure.max() - 1), 1e-4, how)
    yield Row("cattaneo-mindlin, FE: pressure, L2 over ||p||", p_off / norm(pressure), 1e-3, how)
    yield Row("cattaneo-mindlin, FE: shear, L2 over f ||p||", q_off / (f * norm(pressure)), 2e-3, how)
    yield Row("cattaneo-mindlin, FE: shear, L2 over ||q||", q_off / norm(shear), None, how)
    yield Row("cattaneo-mindlin, FE: stick edge", float(edge), 0.2, how, "elements")
    work = answer.dissipation / exact.dissipation - 1
    yield Row("cattaneo-mindlin, FE: dissipation of a cycle", work, 5e-4, "Q between +-0.6 f P")
    flat = halfplane_fe.solve(load_scene("flat-rounded-paper"))
    exact = semi_analytic.solve(flat.scene, x=[0.0], time=flat.time, fields=("dissipation",))
    yield Row("flat-rounded-paper, FE: dissipation", flat.dissipation / exact.dissipation - 1, 1e-3, "default mesh")


# -------------------------------------------------------------------------------------------------------------------- edges
# Half-planes with friction, on which theory's edges are exact.
EDGED = (
    *("hertz-paper", "cattaneo-mindlin", "flat-rounded-paper", "phase-45", "near-sliding"),
    *("motor", "harmonics", "tiny-slip", "compound-curvature"),
)


def edges() -> Iterator[Row]:
    """Instants within the stated uncertainty of the edges at the worst scene; what halving increments at constant P buys."""
    shares: dict[str, dict[str, float]] = {"contact": {}, "stick": {}}
    sizes: dict[str, list[float]] = {"contact": [], "stick": []}
    for name in EDGED:
        fe = halfplane_fe.solve(load_scene(name))
        exact = semi_analytic.solve(fe.scene, x=[0.0], time=fe.time)
        for edge, covered in shares.items():
            error = np.abs(getattr(fe, f"{edge}_edges") - getattr(exact, f"{edge}_edges"))[1:]
            stated = getattr(fe, f"{edge}_edge_uncertainty")[1:]
            covered[name] = float(np.mean(np.all(error <= stated, axis=1)))
            sizes[edge].append(float(np.median(stated / fe.settings["element_size"])))
    for edge, covered in shares.items():
        worst = min(covered, key=covered.__getitem__)
        how = f"{len(covered)} scenes with the default mesh, the worst of them {worst}"
        yield Row(f"{edge} edges within their uncertainty, instants", 100 * covered[worst], None, how, "%")
        how = "of its median in each scene; element at the edges"
        yield Row(f"uncertainty of {edge} edges, median", float(np.median(sizes[edge])), None, how, "elements")


# ------------------------------------------------------------------------------------------------------- work and precision
@dataclass(frozen=True)
class Setting:
    """How the bodies are cut and the path is followed."""

    text: str
    mesh: MeshSettings = field(default_factory=MeshSettings)
    solver: SolverSettings = field(default_factory=SolverSettings)


COARSE = Setting("coarse", MeshSettings.coarse())
DEFAULT = Setting("default")
FINE = Setting("fine", MeshSettings.fine(), SolverSettings(steps_per_cycle=192))


@dataclass(frozen=True)
class Measured:
    """What one run cost and its errors, dissipations relative; where theory has no answer, all of an error is the mesh's.

    Attributes
    ----------
    seconds : CPU time
    error, mesh_part, increment_part : of the dissipation; the first is the sum of the others to first order
    shear : rms over the instants of the last cycle of the L2 error of q over f ||p||; None where theory has no answer
    loop_mesh_part, loop_corners : of the closed integral of Q dU over the instants of the last cycle, against that of theory at
        these instants, and of that against the loop without corners
    """

    seconds: float
    error: float
    mesh_part: float
    increment_part: float
    shear: float | None
    loop_mesh_part: float
    loop_corners: float
    nodes: int
    increments: int


@functools.cache
def measure(name: str, setting: Setting, truth: float | None = None) -> Measured:
    """A scene of the library against theory, or against the dissipation `truth` where theory has no exact answer.

    The error of W is split by the exact W of the polygon that the increments are: FE against it is the mesh's part, it against the
    path the increments' part.
    """
    scene, begun = load_scene(name), time.process_time()
    answer = halfplane_fe.solve(scene, setting.mesh, setting.solver)
    spent, counts = time.process_time() - begun, (len(answer.x), answer.work.counts["steps solved"])
    if truth is not None:
        error = answer.dissipation / truth - 1
        return Measured(spent, error, error, 0.0, None, answer.loop_work / truth - 1, 0.0, *counts)
    truth, last = semi_analytic.solve(scene).dissipation, answer.last_cycle
    fields = ("dissipation", "tangential_displacement")
    stepped = semi_analytic.solve(scene, x=[0.0], time=answer.time, straight_steps=True, fields=fields)
    loop = np.trapezoid(answer.tangential_load[last], stepped.tangential_displacement[last])
    some = last[:: max(1, len(last) // 60)]
    exact = semi_analytic.solve(scene, x=answer.x, time=answer.time[: some[-1] + 1], fields=("pressure", "shear"))
    off = np.trapezoid((answer.shear[some] - exact.shear[some]) ** 2, answer.x, axis=1)
    size = np.trapezoid(exact.pressure[some] ** 2, answer.x, axis=1) * scene.friction.coefficient**2
    parts = answer.dissipation / truth - 1, answer.dissipation / stepped.dissipation - 1, stepped.dissipation / truth - 1
    return Measured(
        spent, *parts, rms(np.sqrt(off / size)), float(answer.loop_work - loop) / truth, float(loop / truth - 1), *counts
    )


def precision() -> Iterator[Row]:
    """The promised errors and times, and the error in its two parts."""
    promised = (("hertz-paper", DEFAULT, 5e-4, 5.0), ("flat-rounded-paper", DEFAULT, 1e-3, 10.0), ("hertz-paper", FINE, 1e-4, 60.0))
    for name, setting, within, most in promised:
        found, size = measure(name, setting), f"a/{1 / setting.mesh.edge_element_size:.0f}"
        what = f"{name}, FE, {size}"
        how = f"h = {size} at the edges, {found.nodes} contact nodes, {found.increments} increments"
        yield Row(f"{what}: dissipation", found.error, within, how)
        yield Row(f"{what}: ... of that by the mesh", found.mesh_part, None, "against the exact polygon of its own increments")
        yield Row(f"{what}: ... of that by the increments", found.increment_part, None, "that polygon against the ellipse")
        yield Row(f"{what}: CPU time, set-up included", found.seconds, most, "mesh, condensation, revolutions", "s")


# -------------------------------------------------------------------------------------------------------------------- peers
# What other codes reached, of another day on a machine like this one, one thread: seconds, error.
KRATOS, CALCULIX = (
    ("Kratos 10.4", 11.0, "dual mortar, h = a/80, 96k dof, one step"),
    ("CalculiX 2.20", 36.0, "penalty, h = a/40, 25 increments"),
)
KRATOS_ERROR = 9.6e-3
FEW_STEPS = SolverSettings(steps_per_cycle=8, step_tolerance=FREE)


def cattaneo_mindlin(shares: Sequence[float] = (0.6,)) -> Scene:
    """Press, then shear up to each of `shares` of f P in turn: the library's scene without its cycle."""
    scene = load_scene("cattaneo-mindlin")
    load, f = scene.load.cycle[0][0], scene.friction.coefficient
    return scene.vary(load=PolygonLoad(initial_loading=[(load, 0.0), *((load, k * f * load) for k in shares)]))


def shear_errors(answer: FiniteElementSolution, exact: ContactSolution) -> np.ndarray:
    """L2 of the shear's error over ||q|| at the end of each line that shears."""
    ends = [int(np.argmin(np.abs(answer.time - t))) for t in range(2, round(answer.time[-1]) + 1)]

    def norm(values: np.ndarray) -> np.ndarray:
        return np.sqrt(np.sum(answer.condensed[0].weights * values[ends] ** 2, axis=1))

    return norm(answer.shear - exact.shear) / norm(exact.shear)


def peers() -> Iterator[Row]:
    """Beside the best values found for other codes, on the same problems; they are stated here, not measured again."""
    mesh, answers = MeshSettings.coarse(), []
    # Q/(f P) around the peers' 0.6: one stick edge may happen to suit a mesh, eleven don't.
    for shares in ((0.6,), tuple(np.linspace(0.55, 0.65, 11))):
        answer = halfplane_fe.solve(cattaneo_mindlin(shares), mesh, FEW_STEPS)
        answers.append((answer, shear_errors(answer, semi_analytic.solve(answer.scene, x=answer.x, time=answer.time))))
    (answer, single), (_, around) = answers
    spent = seconds(lambda: halfplane_fe.solve(cattaneo_mindlin(), mesh, FEW_STEPS), 5)
    how = f"h = a/{1 / mesh.edge_element_size:.0f}, {answer.work.counts['degrees of freedom']} dof, {len(answer.x)} contact nodes"
    what = "Cattaneo-Mindlin, Q = 0.6 f P: shear, L2 over ||q||"
    yield Row(what, float(single[-1]), KRATOS_ERROR, f"{how}; {KRATOS[0]}: 0.96 %")
    yield Row("... rms over eleven Q around it", rms(around), KRATOS_ERROR, f"worst {around.max():.2g}, Q from 0.55 to 0.65 f P")
    yield Row("... CPU time, set-up included", spent, None, f"{how}; least of 5 runs", "s")
    for name, theirs, words in (KRATOS, CALCULIX):
        yield Row(f"... over {name}'s {theirs:g} s", spent / theirs, 1 / 50, f"{theirs / spent:.0f} times faster; {words}")


# ------------------------------------------------------------------------------------------------------------------- growth
def growth() -> Iterator[Row]:
    """1,000 nodes, 400 steps, two revolutions; what condensation by elimination is worth. Exponents are on docs/performance.md."""
    mesh, solver = "MeshSettings(edge_element_size=1 / 320)", "SolverSettings(steps_per_cycle=400)"
    imports = "from halfplane_fe import SolverSettings, solve; from meshes import MeshSettings; from scenes import load_scene"
    answer = f"answer = solve(load_scene('hertz-paper'), {mesh}, {solver})"
    spent, peak, found = cold(f"{imports}; {answer}; found = len(answer.x), answer.work.counts['steps solved']")
    nodes, increments = map(int, found)
    how = f"{nodes} contact nodes a side, 400 regular steps a cycle, {increments} increments in two cycles, imports included"
    yield Row("hertz-paper, large: CPU time", spent, 120.0, how, "s")
    yield Row("hertz-paper, large: peak memory", peak, 2.0, how, "GiB")
    with threadpool_limits(limits=1, user_api="blas"):
        yield from condensation_ways()


def condensation_ways() -> Iterator[Row]:
    """Elimination with the contact nodes last against one sparse solve for each unit force, and against no condensation."""
    # A block on a fixed base, so that there is no arc and only the algebra differs.
    mesh = solid("lower", Block(width=20.0, height=10.0), Hertz(radius=1000.0), SurfaceGrading(0.4, 1.1, 1 / 24, 1 / 160), 0.2)
    begun = time.process_time()
    found = condense(mesh, STEEL, 1.0)
    eliminated = time.process_time() - begun
    begun = time.process_time()
    compliance, once = compliance_by_unit_forces(mesh)
    solved = time.process_time() - begun
    dof = int(found.diagnostics["degrees_of_freedom"])
    how = f"{len(found.x)} contact nodes, {dof} dof: {eliminated:.2f} s against {solved:.2f} s"
    what = "elimination with the contact nodes last: times faster than a solve for each unit force"
    yield Row(what, solved / eliminated, None, how)
    apart = float(np.abs(compliance - found.compliance).max() / np.abs(found.compliance).max())
    yield Row("... the two compliances differ by", apart, 1e-9, "over the largest entry; both symmetric parts")
    work = halfplane_fe.solve(load_scene("hertz-paper")).work
    iterations, own = work.counts["contact iterations"], eliminated + work.seconds["load path"]
    how = f"{iterations} contact iterations, each a sparse factorisation and solve of both bodies ({2 * once:.2f} s), reckoned"
    yield Row("condensed: times faster than without condensation", 2 * iterations * once / own, None, how)


def compliance_by_unit_forces(mesh: BodyMesh) -> tuple[np.ndarray, float]:
    """The compliance of a body on fixed supports by unit forces; and the CPU time of a factorisation with one solve."""
    system = assemble(mesh, STEEL)  # the model's own assembly, so that only the algebra differs
    begun = time.process_time()
    factors = factorise(system.stiffness[system.free][:, system.free].tocsc())
    factors.solve(np.ones(len(system.free)))
    once, n = time.process_time() - begun, system.contact.size
    place = np.full(system.stiffness.shape[0], -1)
    place[system.free] = np.arange(len(system.free))
    contact = place[system.contact.ravel()]
    compliance = np.empty((n, n))
    for first in range(0, n, 64):
        columns = np.arange(first, min(first + 64, n))
        right = np.zeros((len(system.free), len(columns)))
        right[contact[columns], np.arange(len(columns))] += 1.0
        compliance[:, columns] = factors.solve(right)[contact]
    return ((compliance + compliance.T) / 2).reshape(2, n // 2, 2, n // 2), once


# ------------------------------------------------------------------------------------------------------------- page and run
def page() -> Iterator[Row]:
    """What the page adds to a run, and how large it is."""
    code = (
        "import halfplane_fe, semi_analytic, reports.comparison, time\n"
        "begun = time.process_time()\nimport reports.page.writing\nprint(time.process_time() - begun)\n"
        "import sys\nassert not {'matplotlib', 'pyvista'} & set(sys.modules)"
    )
    took = float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)
    yield Row("importing what writes the page, no drawing library among it", took, 1.0, "process time after the engines", "s")
    with tempfile.TemporaryDirectory() as folder:
        for name in ("hertz-paper", "flat-rounded-paper", "flat-pad-on-block", "motor", "time-series"):
            comparison, out = beside_theory(halfplane_fe.solve(load_scene(name))), Path(folder) / name
            took = seconds(lambda c=comparison, o=out: write(c, o), times=3)
            yield Row(f"{name}: page, tables and NetCDF after a run", took, 3.0, "process time, least of three", "s")
            size = (out / "report.html").stat().st_size / 1e6
            yield Row(f"{name}: size of report.html", size, 8.0, "with the slider's data and the tables in it", "MB")


def main_job() -> Iterator[Row]:
    """Cold run of the main job, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        command = [sys.executable, "-m", "reports", "run", "hertz-paper", "--out", f"{folder}/report"]
        subprocess.run(command, check=True, capture_output=True, cwd=ROOT)
        total = time.perf_counter() - begun
        took: dict[str, Any] = json.loads((Path(folder) / "report" / "comparison.json").read_text())["seconds"]
    yield Row("cold `halfplane run hertz-paper` with the page", total, 30.0, "a process of its own", "s")
    yield Row("... of that the FE model", took["finite elements"], 6.0, "mesh, condensation and two revolutions", "s")
    how = "on the points and instants of the FE model"
    yield Row("... of that the half-plane engine", took["half-plane theory"], 0.1, how, "s")


# -------------------------------------------------------------------------------------------------------------- real bodies
# Limits of real bodies, half-planes and a layer on a rigid base, are in tests/test_halfplane_fe_accuracy.py.
BODY_SCENES = (
    *("blocks", "cylinder-roller", "cylinder-roller-frictionless", "flat-pad-on-block"),
    *("layer", "pad-on-block", "two-cylinders"),
)
FINER, FINEST = MeshSettings(element_size=1 / 48, edge_element_size=1 / 320), MeshSettings.fine()


@dataclass(frozen=True)
class Figures:
    """What is compared of a solution: at the largest load, at common instants of the last cycle, over the cycle."""

    peak: float
    half_width: float
    stick: np.ndarray
    dissipation: float


def figures(answer: FiniteElementSolution, instants: Sequence[float]) -> Figures:
    """Figures of a solution; the instants are among its steps."""
    largest = int(np.argmax(answer.normal_load))
    steps = [int(np.argmin(np.abs(answer.time - instant))) for instant in instants]
    if max(abs(answer.time[step] - instant) for step, instant in zip(steps, instants, strict=True)) > 1e-9:
        raise ValueError("an instant is not among the steps")
    return Figures(
        float(answer.pressure[largest].max()),
        float(answer.contact_half_width[largest]),
        answer.stick_half_width[steps],
        answer.dissipation,
    )


def off(one: Figures, other: Figures) -> dict[str, float]:
    """Relative differences; the stick edge over the contact half-width, worst instant."""
    return {
        "peak pressure": one.peak / other.peak - 1,
        "contact half-width": one.half_width / other.half_width - 1,
        "stick half-width": float(np.abs(one.stick - other.stick).max()) / other.half_width,
        "dissipation": one.dissipation / other.dissipation - 1,
    }


def mesh_error() -> Iterator[Row]:
    """Blocks of 4, 10 and 40 half-widths, half the default sizes against the finest mesh, P constant and Q cycling."""
    for size in (4.0, 10.0, 40.0):
        like, block = load_scene("cattaneo-mindlin"), Block(width=size, height=size)
        normal, tangential = like.load.cycle[0]
        load = PolygonLoad(initial_loading=((normal, 0.0), (normal, tangential)), cycle=((normal, -tangential),))
        scene = like.vary(bodies=Bodies(lower=block, upper=block), load=load)
        instants = (2.0, 3.0, 4.0)  # Q at its largest and least: the stick zone is at its smallest
        default, finer, finest = (figures(halfplane_fe.solve(scene, mesh), instants) for mesh in (MeshSettings(), FINER, FINEST))
        for name, error in off(finer, finest).items():
            how = f"elements of a/320 at the edges against a/640; default mesh {off(default, finest)[name]:.1e}"
            yield Row(f"blocks {size:g} a high and wide, mesh error: {name}", error, 5e-4, how)


def roller() -> Iterator[Row]:
    """The NAFEMS roller beside Hertz, as the published benchmark compares it."""
    for name, limit in (("cylinder-roller-frictionless", 5e-3), ("cylinder-roller", 3e-2)):
        answer = halfplane_fe.solve(load_scene(name))
        hertz = semi_analytic.solve(load_scene(name), x=answer.x, time=answer.time)
        peak, width = float(answer.pressure[-1].max()), float(answer.contact_half_width[-1])
        how = f"{peak:.0f} MPa and {width:.3f} mm; Hertz 3585 MPa and 6.215 mm; a/R = 0.124"
        yield Row(f"{name}: peak pressure against Hertz", peak / float(hertz.pressure[-1].max()) - 1, limit, how)
        yield Row(f"{name}: half-width against Hertz", width / float(hertz.contact_half_width[-1]) - 1, limit, how)


def real_bodies() -> Iterator[Row]:
    """Mesh error against a finer mesh, the NAFEMS roller, cost of cold runs."""
    yield from mesh_error()
    yield from roller()
    for name in BODY_SCENES:
        spent, peak, _ = cold(f"import halfplane_fe; from scenes import load_scene; halfplane_fe.solve(load_scene({name!r}))")
        yield Row(f"{name}, cold: CPU", spent, 20.0, "a process of its own", "s")
        yield Row(f"{name}, cold: peak memory", peak, 2.0, "resident", "GiB")
