"""Claims of the finite elements: errors against theory, error and time, growth of the cost, real
bodies.

Times are CPU times of one thread with everything in them: the coarse run, mesh, condensation, every
increment; every body is condensed anew.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import must_fail
import numpy as np
from claims import ROOT, Row, cold, seconds, stored

import halfplane_fe
import semi_analytic
from halfplane_fe import FiniteElementSolution, SolverSettings
from meshes import MeshSettings
from reports.comparison.work_of_loads import solution_on_straight_steps
from scenes import Block, Bodies, ContactSolution, PolygonLoad, Scene, load_scene

FREE = float("inf")


# ----------------------------------------------------------------------------------- against theory
def against_theory() -> Iterator[Row]:
    """Every check of the planted faults on the healthy model."""
    answer = halfplane_fe.solve(load_scene("hertz-paper"))
    settings = MeshSettings()
    counts = answer.work.counts
    how = (
        f"default mesh: h = a/{1 / settings.element_size:.0f},"
        f" a/{1 / settings.edge_element_size:.0f} at the edges, {counts['degrees of freedom']} dof,"
        f" {counts['steps solved']} increments"
    )
    for name, value in must_fail.figures(answer).items():
        yield Row(f"hertz-paper, FE: {name}", value, must_fail.LIMITS[name], how)


def mindlin() -> Iterator[Row]:
    """Q = 0.6 f P on first loading, and over the cycle; and the other profile of the paper."""
    answer = halfplane_fe.solve(load_scene("cattaneo-mindlin"))
    exact = semi_analytic.solve(answer.scene, x=answer.x, time=answer.time)
    at = int(np.argmin(np.abs(answer.time - 2.0)))
    weights = answer.face_lengths
    f = answer.scene.friction.coefficient

    def norm(values: np.ndarray) -> float:
        return float(np.sqrt(weights @ values[at] ** 2))

    p_off = norm(answer.pressure - exact.pressure)
    q_off = norm(answer.shear - exact.shear)
    edge = (
        np.abs(answer.stick_edges[at] - exact.stick_edges[at]).max()
        / answer.settings["element_size"]
    )
    peak = answer.pressure[at].max() / exact.pressure[at].max() - 1
    how = (
        f"default mesh, {answer.work.counts['degrees of freedom']} dof, Q = 0.6 f P on first"
        " loading"
    )
    for claim, value, limit, unit in (
        ("peak pressure", peak, 1e-4, ""),
        ("pressure, L2 over ||p||", p_off / norm(exact.pressure), 1e-3, ""),
        ("shear, L2 over f ||p||", q_off / (f * norm(exact.pressure)), 2e-3, ""),
        ("shear, L2 over ||q||", q_off / norm(exact.shear), None, ""),
        ("stick edge", edge, 0.2, "elements"),
    ):
        yield Row(f"cattaneo-mindlin, FE: {claim}", value, limit, how, unit)
    work = answer.dissipation / exact.dissipation - 1
    yield Row("cattaneo-mindlin, FE: dissipation of a cycle", work, 1e-4, "Q between +-0.6 f P")
    error = measure("flat-rounded-paper", DEFAULT)["error"]
    yield Row("flat-rounded-paper, FE: dissipation", error, 1.5e-4, "default mesh")


# ------------------------------------------------------------------------------- work and precision
@dataclass(frozen=True)
class Setting:
    """How the bodies are cut and the path is followed."""

    text: str
    mesh: MeshSettings = field(default_factory=MeshSettings)
    solver: SolverSettings = field(default_factory=SolverSettings)


COARSE = Setting("coarse", MeshSettings.coarse())
DEFAULT = Setting("default")
FINE = Setting("fine", MeshSettings.fine(), SolverSettings(steps_per_cycle=192))


@functools.cache
def measure(name: str, setting: Setting, truth: float | None = None) -> dict[str, float]:
    """CPU seconds of a scene of the library and its errors, against theory or against the
    dissipation `truth`.

    The error of W is split by the exact W of the polygon that the increments are: FE on it is the
    mesh's part, it against the path the increments' part, with what FE adds for the curve. `loop`:
    the closed integral of Q dU over the instants of the last cycle, against that of theory at these
    instants; `corners`: that against the loop without corners. `shear`: rms over the last cycle of
    the L2 error of q over f ||p||. With `truth` all of an error is the mesh's, and there is no
    `shear`.
    """
    scene = load_scene(name)
    begun = time.process_time()
    answer = halfplane_fe.solve(scene, setting.mesh, setting.solver)
    errors = {
        "seconds": time.process_time() - begun,
        "nodes": len(answer.x),
        "increments": answer.work.counts["steps solved"],
    }
    if truth is not None:
        error = answer.dissipation / truth - 1
        return errors | {
            "error": error,
            "mesh": error,
            "steps": 0.0,
            "loop": answer.loop_work / truth - 1,
            "corners": 0.0,
        }
    truth = semi_analytic.solve(scene).dissipation
    last = answer.last_cycle
    fields = ("dissipation", "tangential_displacement")
    stepped = semi_analytic.solve(
        scene, x=[0.0], time=answer.time, straight_steps=True, fields=fields
    )
    loop = np.trapezoid(answer.tangential_load[last], stepped.tangential_displacement[last])
    instants = last[:: max(1, len(last) // 60)]
    exact = semi_analytic.solve(
        scene, x=answer.x, time=answer.time[: instants[-1] + 1], fields=("pressure", "shear")
    )
    off = np.trapezoid((answer.shear[instants] - exact.shear[instants]) ** 2, answer.x, axis=1)
    size = (
        np.trapezoid(exact.pressure[instants] ** 2, answer.x, axis=1)
        * scene.friction.coefficient**2
    )
    return errors | {
        "error": answer.dissipation / truth - 1,
        "mesh": (straight := solution_on_straight_steps(answer).dissipation) / stepped.dissipation
        - 1,
        "steps": stepped.dissipation / straight * answer.dissipation / truth - 1,
        "shear": float(np.sqrt(np.mean(off / size))),
        "loop": float(answer.loop_work - loop) / truth,
        "corners": float(loop / truth - 1),
    }


def precision() -> Iterator[Row]:
    """The promised errors and times, and the error in its two parts."""
    for name, setting, within, most in (
        ("hertz-paper", DEFAULT, 1e-4, 5.0),
        ("flat-rounded-paper", DEFAULT, 1.5e-4, 10.0),
        ("hertz-paper", FINE, 1e-4, 60.0),
    ):
        errors = measure(name, setting)
        size = f"a/{1 / setting.mesh.edge_element_size:.0f}"
        how = (
            f"h = {size} at the edges, {errors['nodes']} contact nodes, {errors['increments']}"
            " increments"
        )
        for claim, value, limit, words, unit in (
            ("dissipation", errors["error"], within, how, ""),
            (
                "... of that by the mesh",
                errors["mesh"],
                None,
                "against the exact polygon of its own increments",
                "",
            ),
            (
                "... of that by the increments",
                errors["steps"],
                None,
                "that polygon, with what FE adds for the ellipse, against it",
                "",
            ),
            (
                "CPU time, set-up included",
                errors["seconds"],
                most,
                "mesh, condensation, revolutions",
                "s",
            ),
        ):
            yield Row(f"{name}, FE, {size}: {claim}", value, limit, words, unit)


# -------------------------------------------------------------------------------------------- peers
KRATOS_ERROR = 9.6e-3  # of q, elements of a/80 in the middle and at the edges
FEW_STEPS = SolverSettings(steps_per_cycle=8, step_tolerance=FREE)


def cattaneo_mindlin(shares: Sequence[float] = (0.6,)) -> Scene:
    """Press, then shear up to each of `shares` of f P in turn: the library's scene without its
    cycle.
    """
    scene = load_scene("cattaneo-mindlin")
    load = scene.load.cycle[0][0]
    f = scene.friction.coefficient
    return scene.vary(
        load=PolygonLoad(initial_loading=[(load, 0.0), *((load, k * f * load) for k in shares)])
    )


def shear_errors(answer: FiniteElementSolution, exact: ContactSolution) -> np.ndarray:
    """L2 of the shear's error over ||q|| at the end of each line that shears."""
    ends = [int(np.argmin(np.abs(answer.time - t))) for t in range(2, round(answer.time[-1]) + 1)]
    off, size = (
        (values[ends] ** 2) @ answer.face_lengths
        for values in (answer.shear - exact.shear, exact.shear)
    )
    return np.sqrt(off / size)


def peers() -> Iterator[Row]:
    """Beside other codes on the same problem; ratios of times are those of one run of all codes,
    `make bench`.
    """
    import peers as side_by_side  # which imports this file

    mesh = MeshSettings.coarse()
    found = []
    # Q/(f P) around the peers' 0.6: one stick edge may happen to suit a mesh, eleven don't.
    for shares in ((0.6,), tuple(np.linspace(0.55, 0.65, 11))):
        answer = halfplane_fe.solve(cattaneo_mindlin(shares), mesh, FEW_STEPS)
        found.append(
            shear_errors(answer, semi_analytic.solve(answer.scene, x=answer.x, time=answer.time))
        )
    single, around = found
    (spent,) = seconds(lambda: halfplane_fe.solve(cattaneo_mindlin(), mesh, FEW_STEPS), times=5)
    how = (
        f"h = a/{1 / mesh.edge_element_size:.0f}, {answer.work.counts['degrees of freedom']} dof,"
        f" {len(answer.x)} contact nodes"
    )
    claim = "Cattaneo-Mindlin, Q = 0.6 f P: shear, L2 over ||q||"
    yield Row(claim, float(single[-1]), KRATOS_ERROR, f"{how}; Kratos 10.4 on a/80: 0.96 %")
    words = f"worst {around.max():.2g}, Q from 0.55 to 0.65 f P"
    yield Row(
        "... rms over eleven Q around it", float(np.sqrt(np.mean(around**2))), KRATOS_ERROR, words
    )
    yield Row("... CPU time, set-up included", spent, None, f"{how}; least of 5 runs", "s")
    rows = stored(ROOT / "docs" / "performance" / "peers.json")["found"]["shear"]
    for code, least in (("Kratos", 60), ("GetFEM", None), ("CalculiX", None)):
        ratios = [
            (side_by_side.times_faster(row, rows, "q"), row)
            for row in rows
            if row["code"] == code and row.get("q")
        ]
        for times, row in ratios[-1:]:  # on its finest mesh
            words = (
                f"{times:.0f} times faster, q no worse than its {row['q']:.1e} on {row['size']}:"
                " docs/performance.md"
            )
            yield Row(
                f"... time over {code}'s, side by side",
                1 / times,
                1 / least if least else None,
                words,
            )


def growth() -> Iterator[Row]:
    """1,000 nodes, 400 steps, two revolutions. Exponents are on docs/performance.md."""
    mesh = "MeshSettings(edge_element_size=1 / 320)"
    solver = "SolverSettings(steps_per_cycle=400)"
    imports = (
        "from halfplane_fe import SolverSettings, solve; from meshes import MeshSettings; from"
        " scenes import load_scene"
    )
    answer = f"answer = solve(load_scene('hertz-paper'), {mesh}, {solver})"
    spent, peak, numbers = cold(
        f"{imports}; {answer}; found = len(answer.x), answer.work.counts['steps solved']"
    )
    nodes, increments = map(int, numbers)
    how = (
        f"{nodes} contact nodes a side, 400 regular steps a cycle, {increments} increments in two"
        " cycles, imports included"
    )
    yield Row("hertz-paper, large: CPU time", spent, 120.0, how, "s")
    yield Row("hertz-paper, large: peak memory", peak, 2.0, how, "GiB")


# -------------------------------------------------------------------------------------- real bodies
BODY_SCENES = (
    *("blocks", "cylinder-roller", "cylinder-roller-frictionless", "flat-pad-on-block"),
    *("layer", "pad-on-block", "two-cylinders"),
)
FINER = MeshSettings(element_size=1 / 48, edge_element_size=1 / 320)
FINEST = MeshSettings.fine()


def on_blocks(size: float, mesh: MeshSettings) -> dict[str, np.ndarray]:
    """Blocks of `size` half-widths, P constant and Q cycling: the largest load, the cycle, three
    instants at which c is least.
    """
    like = load_scene("cattaneo-mindlin")
    block = Block(width=size, height=size)
    normal, tangential = like.load.cycle[0]
    load = PolygonLoad(
        initial_loading=((normal, 0.0), (normal, tangential)), cycle=((normal, -tangential),)
    )
    answer = halfplane_fe.solve(like.vary(bodies=Bodies(lower=block, upper=block), load=load), mesh)
    largest = int(np.argmax(answer.normal_load))
    steps = [int(np.argmin(np.abs(answer.time - t))) for t in (2.0, 3.0, 4.0)]
    return {
        "peak pressure": answer.pressure[[largest]].max(axis=1),
        "contact half-width": answer.contact_half_width[[largest]],
        "stick half-width": answer.stick_half_width[steps],
        "dissipation": np.array([answer.dissipation]),
    }


def real_bodies() -> Iterator[Row]:
    """Half the default sizes against the finest mesh; the NAFEMS roller beside Hertz; cost of cold
    runs.
    """
    for size in (4.0, 10.0, 40.0):
        default, finer, finest = (on_blocks(size, mesh) for mesh in (MeshSettings(), FINER, FINEST))
        for name, best in finest.items():
            unit = finest["contact half-width"] if name == "stick half-width" else best
            error, rough = (
                float(max((one[name] - best) / unit, key=abs)) for one in (finer, default)
            )
            how = f"elements of a/320 at the edges against a/640; default mesh {rough:.1e}"
            yield Row(f"blocks {size:g} a high and wide, mesh error: {name}", error, 5e-4, how)
    for name, limit in (("cylinder-roller-frictionless", 5e-3), ("cylinder-roller", 3e-2)):
        answer = halfplane_fe.solve(load_scene(name))
        hertz = semi_analytic.solve(load_scene(name), x=answer.x, time=answer.time)
        peak = float(answer.pressure[-1].max())
        width = float(answer.contact_half_width[-1])
        how = f"{peak:.0f} MPa and {width:.3f} mm; Hertz 3585 MPa and 6.215 mm; a/R = 0.124"
        yield Row(
            f"{name}: peak pressure against Hertz",
            peak / float(hertz.pressure[-1].max()) - 1,
            limit,
            how,
        )
        yield Row(
            f"{name}: half-width against Hertz",
            width / float(hertz.contact_half_width[-1]) - 1,
            limit,
            how,
        )
    for name in BODY_SCENES:
        spent, peak, _ = cold(
            "import halfplane_fe; from scenes import load_scene;"
            f" halfplane_fe.solve(load_scene({name!r}))"
        )
        yield Row(f"{name}, cold: CPU", spent, 20.0, "a process of its own", "s")
        yield Row(f"{name}, cold: peak memory", peak, 2.0, "resident", "GiB")
