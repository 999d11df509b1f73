"""Bulk stress and tilt: known values beside both engines and a dense grid solver, in one table.

    python benchmarks/bulk_stress.py                (a quarter of an hour)
    python benchmarks/bulk_stress.py 1 2 9 --coarse (some rows, on coarse meshes: seconds a row)
    python benchmarks/bulk_stress.py --loops        (loops out of phase by half-plane theory,
                                                    against twice the order: 2 minutes)
    python benchmarks/bulk_stress.py --steady       (the same loops: all cycles beside the steady
                                                    one alone, one after the other)

E* = R = 1 and two like bodies with E = 2, nu = 0, so that a stress of 2 eps in the lower one is the
strain eps. A line has the known value (docs/bulk-stress.md; W of rows 7 and 8 is a limit of fine
grids, to 3e-5) and what was found minus the known value: by half-plane theory, by finite elements
and on a grid (semi_analytic/grid.py, errors of a cell of 0.023 at edges). Rows 10 and 11 couple
pressure and shear: finite elements alone. Rows that an engine refuses are listed below the table
with the reason.

# notation: W dissipation of the last cycle; stick, always, contact: edges of stick at the end, of
#           permanent stick, of contact at the end; M moment of the pressure; c/a share of stick;
#           P/P_H load over that of Hertz for the same half-width
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import halfplane_fe
import semi_analytic
from meshes import MeshSettings
from scenes import ContactSolution, ConvergenceError, InputError, Scene, load_scene

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from semi_analytic import grid as dense_grid
from semi_analytic.bulk_and_tilt import path_loads_and_contact

# a at P = 3; c of Cattaneo and Mindlin at Q = 1.8
A0 = math.sqrt(12 / math.pi)
STUCK = math.sqrt(4.8 / math.pi)
# of the grid; increments a segment of the load path (an ellipse: four times as many)
CELLS_ACROSS_CONTACT = 240
INCREMENTS_PER_CYCLE = 24
CYCLES = 4
Values = dict[str, float]


class Row(NamedTuple):
    """One case: its scene, its known values by name, and whether pressure and shear are coupled."""

    number: str
    words: str
    scene: Scene
    known: Mapping[str, float]
    coupled: bool = False


def case(
    number: str, words: str, load: dict[str, Any], known: Mapping[str, float], **parts: Any
) -> Row:
    """A row from its load and from what differs from two like half-planes with f = 1."""
    if "scene" in parts:
        return Row(number, words, parts["scene"], known)
    keys = {
        "material": {"young_modulus": 2.0, "poisson_ratio": 0.0},
        "profile": {"kind": "hertz", "radius": 1.0},
        "friction": 1.0,
    }
    if "mean_normal_load" in load:
        kind = "ellipse"
    elif "rows" in load:
        kind = "time_series"
    else:
        kind = "polygon"
    return Row(
        number,
        words,
        Scene.model_validate(keys | {"load": {"kind": kind} | load} | parts),
        known,
        "material" in parts,
    )


def ellipse(
    p: tuple[float, float],
    q: tuple[float, float],
    phase: float,
    **waves: tuple[float, float, float],
) -> dict[str, Any]:
    """P, Q as (mean, amplitude), waves as (mean, amplitude, phase)."""
    names = ("mean_normal_load", "normal_amplitude", "mean_tangential_load", "tangential_amplitude")
    turning = {
        key: dict(zip(("mean", "amplitude", "phase_degrees"), wave, strict=True))
        for key, wave in waves.items()
    }
    return dict(zip(names, (*p, *q), strict=True)) | {"phase_degrees": phase} | turning


def pulled(q: float, eps: float) -> dict[str, Any]:
    """P = 3 alone, then Q and eps in proportion."""
    return {"rows": [(0, 0, 0), (1, 3, 0), (2, 3, q)], "bulk_stress_lower": [0, 0, 2 * eps]}


def unlike(beta: float) -> dict[str, Any]:
    """Two bodies with nu = 0, E* = 1 and this Dundurs constant; at 0.5 the lower one is rigid."""
    sides = {"upper": 1 + 2 * beta, "lower": 1 - 2 * beta}
    return {
        side: {"young_modulus": 2 / max(share, 1e-9), "poisson_ratio": 0.0}
        for side, share in sides.items()
    }


def edges(name: str, left: float, right: float) -> Values:
    return {f"{name} left": left, f"{name} right": right}


PAPER = ((3.0, 1.0), (1.1, 1.0), 90.0)
IN_PHASE = ellipse((3, 0.6), (0.2, 1.4), 0, bulk_stress_lower=(0.2, 0.3, 0), tilt=(0.1, 0.08, 0))
FLAT = {"profile": {"kind": "flat_rounded", "radius": 1.0, "flat_half_length": 0.5}}
GOODMAN = {0.5: 0.9851714310094, 1: math.sqrt(0.5), 2: 3 - 2 * math.sqrt(2)}
BONDED = {0.1: 1.0074974191, 0.2: 1.0309017851, 0.3: 1.0732603237, 0.5: 1.2464188563}
# Half-plane theory takes bulk in proportion to Q: row 3 has Q = 1e-9, which moves nothing that is
# printed.
BULK_ALONE = {0.9: 0.2007250992650, 0.5: 1.1763560617531, 0.1: 3.3340559259752}
ROWS = (
    case("1", "moderate bulk", pulled(1.8, 0.2), edges("stick", 0.2 - STUCK, 0.2 + STUCK)),
    case(
        "2",
        "constant P, Q and bulk in phase",
        {
            "initial_loading": [(3, 0), (3, 1.8)],
            "cycle": [(3, -1.8)],
            "bulk_stress_lower": [0, 0.6, -0.6],
        },
        {"W": 0.9368781396315213} | edges("always", 0.3 - STUCK, 0.3 + STUCK),
    ),
    *(
        case("3", f"bulk alone, c = {c} a", pulled(1e-9, eps), edges("stick", -c * A0, c * A0))
        for c, eps in BULK_ALONE.items()
    ),
    case(
        "4", "large bulk", pulled(0.9, 1.0), edges("stick", -0.7063363748151722, 1.4493185287005215)
    ),
    case(
        "5",
        "tilt 0.1 P, strain 0.1 Q",
        ellipse(*PAPER, bulk_stress_lower=(0.22, 0.2, 90), tilt=(0.3, 0.1, 0)),
        {"W": 0.32380811606118304}
        | edges("always", -0.1585786438 - 1.4209454606, -0.1585786438 + 1.4209454606),
    ),
    case(
        "6",
        "all in phase",
        IN_PHASE,
        {"W": 0.25922505566470} | edges("always", -0.704713575642 * A0, 0.755879911039 * A0),
    ),
    case(
        "7",
        "C1: bulk out of phase",
        ellipse(*PAPER, bulk_stress_lower=(0, 0.5, 90)),
        {"W": 0.38682} | edges("always", -0.62681 * A0, 0.80026 * A0),
    ),
    case(
        "8",
        "tilt out of phase",
        ellipse(*PAPER, tilt=(0, 0.06, 90)),
        {"W": 0.25985} | edges("always", -0.72632 * A0, 0.72632 * A0),
    ),
    case(
        "9",
        "tilted flat",
        {"initial_loading": [(1, 0)], "tilt": [0.2]},
        edges("contact", -1.7331629996, 1.2194927292) | {"M": -0.3444188480137},
        **FLAT,
    ),
    *(
        case(
            "10",
            f"Goodman, beta/f = {ratio}",
            {"initial_loading": [(3, 0)]},
            {"c/a": c},
            material=unlike(0.01),
            friction=0.01 / ratio,
        )
        for ratio, c in GOODMAN.items()
    ),
    *(
        case(
            "11",
            f"bonded, beta = {beta}",
            {"initial_loading": [(3, 0)]},
            {"P/P_H": load},
            material=unlike(beta),
            friction=100.0,
        )
        for beta, load in BONDED.items()
    ),
)


def of_engine(answer: ContactSolution) -> Values:
    """What a solution has of the table's quantities."""
    nothing = (math.nan, math.nan)
    stick = answer.stick_edges[-1].tolist()
    contact = answer.contact_edges[-1].tolist()
    quantities = {
        "W": float(answer.dissipation),
        "M": math.nan if answer.moment is None else float(answer.moment[-1]),
    }
    quantities |= {
        "c/a": float(np.ptp(stick) / np.ptp(contact)),
        "P/P_H": float(answer.normal_load[-1] * 16 / (math.pi * np.ptp(contact) ** 2)),
    }
    always = (
        nothing if answer.permanent_stick_edges is None else answer.permanent_stick_edges.tolist()
    )
    return (
        quantities | edges("stick", *stick) | edges("contact", *contact) | edges("always", *always)
    )


def on_grid(scene: Scene) -> Values:
    """The same by the grid, along the path and its first cycles."""
    path = scene.load.path()
    columns = []
    per_cycle = 0
    for leg in path.segments(CYCLES):
        count = INCREMENTS_PER_CYCLE * (
            4 if scene.load.kind == "ellipse" and leg.start >= path.cycle_start else 1
        )
        times = np.linspace(leg.start, leg.end, count + 1)[1:]
        nothing = np.zeros((2, count))
        stress, turn = (
            np.asarray(nothing if part is None else part.loads(times))
            for part in (leg.bulk, leg.tilt_and_moment)
        )
        columns.append(np.stack([*leg.loads(times), stress[0] / 2, turn[0]]))
        per_cycle += (
            count if path.cycle_start <= leg.start < path.cycle_start + (path.period or 0) else 0
        )
    loads = np.concatenate(columns, axis=1)
    answer = dense_grid.follow_instants(
        scene.profile.height, (-2.8, 2.8), CELLS_ACROSS_CONTACT, scene.friction.coefficient, *loads
    )
    always = (
        answer.permanent_stick_edges(len(loads[0]) - per_cycle, 1e-3)
        if per_cycle
        else (math.nan, math.nan)
    )
    values = {
        "W": float(answer.cycle_work(per_cycle)[-1]) if per_cycle else math.nan,
        "M": float(answer.moment[-1]),
    }
    return (
        values
        | edges("stick", *answer.edges(-1, stick=True))
        | edges("contact", *answer.edges(-1))
        | edges("always", *always)
    )


def moderate(count: int = 10, seed: int = 23) -> Iterator[Row]:
    """Random loops at P = 3: Q and moderate bulk strain out of phase, in every second one tilt as
    well.
    """
    random = np.random.default_rng(seed)
    for k in range(count):
        normal, tangential, mean, phase = (
            random.uniform(*ends) for ends in ((0, 1.2), (0.3, 1.2), (-0.6, 0.6), (20, 160))
        )
        strain = random.uniform(0.2, 0.9) * 2 / (math.pi * A0) * tangential
        late = random.uniform(-180, 180)
        tilt = random.uniform(0, 0.08) * (k % 2), random.uniform(-180, 180)
        waves = {"bulk_stress_lower": (0.0, 2 * strain, late)} | (
            {"tilt": (0.0, *tilt)} if k % 2 else {}
        )
        yield case(
            "",
            f"loop {k} of seed {seed}",
            ellipse((3.0, normal), (mean, tangential), phase, **waves),
            {},
        )


def loops() -> int:
    """Loops out of phase on grids, and how far the second cycle is from the same at twice the
    order.
    """
    print(
        "case                             W, cycle 2   1 - W/(W at twice the order)  stated  closed"
        " integral / W - 1  CPU [s]"
    )
    out_of_phase = load_scene("dovetail-out-of-phase")
    rows = [
        *(row for row in ROWS if row.number in "678"),
        case("", out_of_phase.name, {}, {}, scene=out_of_phase),
        *moderate(),
    ]
    for row in rows:
        path = row.scene.load.path()
        friction = row.scene.friction.coefficient
        x = np.linspace(-1.5, 1.5, 50)
        instants = path.cycle_start + (path.period or 0.0) * np.linspace(1, 2, 400)
        arguments = (
            *path_loads_and_contact(row.scene),
            row.scene.profile.height,
            friction,
            x,
            instants,
        )
        answers = []
        seconds = []
        for n in (1, 2):
            begin = time.process_time()
            request = dense_grid.GridRequest(
                most_cycles=2,
                cells=n * dense_grid.CELLS_ACROSS_CONTACT,
                increments=n * dense_grid.INCREMENTS_PER_CYCLE,
            )
            answers.append(dense_grid.follow_on_grid(*arguments, request))
            seconds.append(time.process_time() - begin)
        coarse, fine = answers
        work = coarse.works[-1]
        stated = coarse.errors["dissipation"]
        numbers = (
            f"{work:.10f} {1 - work / fine.works[-1]:+.1e} {stated:.1e}"
            f" {coarse.loop_work / work - 1:+.1e} {seconds[0]:.1f}"
        )
        print(f"{row.words:32} {numbers}", flush=True)
    return 0


def steady() -> int:
    """Loops out of phase: W, increments and CPU time of all cycles, and of the last one alone."""
    print(
        "case                             W, all cycles  1 - W/(W, last alone)  stated  increments "
        " CPU [s]  ratio of times"
    )
    rows = [row for row in ROWS if row.number in "78"]
    rows.append(
        case("", "dovetail-out-of-phase", {}, {}, scene=load_scene("dovetail-out-of-phase"))
    )
    for row in (*rows, *moderate()):
        answers = []
        seconds = []
        for cycles in ("all", "steady"):
            begin = time.process_time()
            answers.append(semi_analytic.solve(row.scene, cycles=cycles, fields="dissipation"))
            seconds.append(time.process_time() - begin)
        full_run, alone = answers
        increments = [answer.work.counts.get("increments", 0) for answer in answers]
        difference = 1 - full_run.dissipation / alone.dissipation
        stated = alone.record.errors.get("dissipation", 0.0)
        numbers = (
            f"{full_run.dissipation:.10f} {difference:+.1e} {stated:.1e}"
            f" {increments[0]} {increments[1]}"
        )
        print(
            f"{row.words:32} {numbers} {seconds[0]:.1f} {seconds[1]:.1f}"
            f" {seconds[0] / seconds[1]:.1f}",
            flush=True,
        )
    return 0


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", nargs="*", help="numbers of rows (default: all)")
    parser.add_argument(
        "--coarse", action="store_true", help="coarse meshes for the finite elements"
    )
    parser.add_argument(
        "--loops",
        action="store_true",
        help="loops out of phase by half-plane theory against twice the order",
    )
    parser.add_argument(
        "--steady",
        action="store_true",
        help="all cycles of loops out of phase beside the steady one alone",
    )
    arguments = parser.parse_args()
    if arguments.steady:
        return steady()
    if arguments.loops:
        return loops()
    mesh = MeshSettings.coarse() if arguments.coarse else MeshSettings()
    ways: dict[str, Callable[[Scene], Values]] = {
        "theory": lambda scene: of_engine(semi_analytic.solve(scene)),
        "elements": lambda scene: of_engine(halfplane_fe.solve(scene, mesh)),
        "grid": on_grid,
    }
    print(
        f"{'row':3} {'case':32} {'quantity':14} {'known':>16} "
        + " ".join(f"{name:>10}" for name in ways)
        + "  seconds"
    )
    refused: dict[str, list[str]] = {}
    for row in ROWS:
        if arguments.rows and row.number not in arguments.rows:
            continue
        values_of_solvers: dict[str, Values] = {}
        started = time.perf_counter()
        for name, way in ways.items():
            if not (row.coupled and name != "elements"):
                try:
                    values_of_solvers[name] = way(row.scene)
                except (InputError, ConvergenceError) as reason:
                    refused.setdefault(f"{name}: {reason}", []).append(row.words)
        seconds = time.perf_counter() - started
        for quantity, known in row.known.items():
            differences = {
                name: values.get(quantity, math.nan) - known
                for name, values in values_of_solvers.items()
            }
            cells = " ".join(
                f"{differences[name]:+10.1e}" if name in differences else f"{'–':>10}"
                for name in ways
            )
            print(
                f"{row.number:3} {row.words:32} {quantity:14} {known:16.10f} {cells} "
                f" {seconds:.0f}",
                flush=True,
            )
    for reason, words in refused.items():
        print(f"{'; '.join(words)}: refused by {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
