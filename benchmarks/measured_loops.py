"""Synthetic measured loops of known f and W through `halfplane score --as loop`: what is covered,
and what is refused.

    python benchmarks/measured_loops.py LOOPS [SEED]     (the seed is drawn, and printed)

Each draw takes a scene, f, a rig, a wave of U or of Q, rows, cycles, noise, digits, a drift of U
and a run-in at random, and writes the table that a rig would write. In a third of the draws the
rows are of something else than the model: loops that grow or shrink, that walk, that harden, or
whose period is two cycles. Loops of the model are of half-plane theory at constant P, partial or
gross.

# notation: f friction coefficient, P and Q loads, U displacement, W area of the loop
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

import semi_analytic
from reports.scoring.loops import LoopScore, read_loop, score_loop
from reports.scoring.mapping import Mapping
from scenes import InputError, Scene, load_scene

Array = NDArray[np.float64]

SCENES = ("cattaneo-mindlin", "flat-rounded-paper")
LOAD = 160.0
FEWEST_ROWS = 20
MOST_ROWS = 600
FEWEST_ROWS_OF_CYCLE = 20
MOST_CYCLES = 8
# Shares of the range of U and of Q.
LARGEST_NOISE = 0.05
LARGEST_DRIFT = 0.02
# Q over f P of partial loops.
AMPLITUDES = (0.3, 0.97)
# A loop that slides as a whole comes so near to f P before it does.
NEAR_SLIDING = 1 - 1e-9
INSTANTS = 4001
SEEDS = 2**32

FOREIGN = ("grows", "shrinks", "walks", "hardens", "period of two cycles")
FORMS = ("sine", "triangle", "measured-like")


@dataclass(frozen=True)
class Draw:
    """One table: its scene, what is true of it, and how it was written. `foreign` is what does not
    fit the model, "" if nothing; noise and drift are shares of the ranges.
    """

    scene: Scene
    gross: bool
    control: str
    form: str
    rows: int
    cycles: float
    noise: float
    digits: int
    drift: float
    run_in: str
    foreign: str

    @property
    def words(self) -> str:
        """For a line of the report."""
        kind = "gross" if self.gross else "partial"
        rest = "".join(f", {word}" for word in (self.foreign, self.run_in) if word)
        return (
            f"{self.scene.name}, f = {self.scene.friction.coefficient:.3g}, {kind}, {self.form} of"
            f" {self.control}, {self.rows} rows, {self.cycles:.3g} cycles, noise"
            f" {self.noise:.2g}, {self.digits} digits, drift {self.drift:.2g}{rest}"
        )


@dataclass(frozen=True)
class Outcome:
    """What was answered: `refusal` is the sentence of a refusal, else the errors and what was
    stated of them, all over the true values. `half_interval` is the wider side of the interval of
    f, `side_of_truth` that on which the true f lies: few digits of f leave no upper limit.
    """

    draw: Draw
    refusal: str = ""
    friction_error: float = 0.0
    half_interval: float = 0.0
    side_of_truth: float = 0.0
    friction_covered: bool = False
    work_error: float = 0.0
    work_uncertainty: float = 0.0
    seconds: float = 0.0

    @property
    def work_covered(self) -> bool:
        """Whether W lies within its own uncertainty."""
        return abs(self.work_error) <= self.work_uncertainty


# ----------------------------------------------------------------------------------- what is drawn
def draw_of(random: np.random.Generator) -> Draw:
    """A scene and a way to measure it."""
    friction = float(random.uniform(0.2, 0.9))
    gross = bool(random.random() < 0.25)
    share = NEAR_SLIDING if gross else float(random.uniform(*AMPLITUDES))
    largest = share * friction * LOAD
    scene = load_scene(str(random.choice(SCENES))).vary(
        friction=friction,
        load={
            "kind": "polygon",
            "initial_loading": [(LOAD, 0.0), (LOAD, largest)],
            "cycle": [(LOAD, -largest)],
        },
    )
    foreign = str(random.choice(FOREIGN)) if random.random() < 1 / 3 else ""
    rows = round(float(np.exp(random.uniform(np.log(FEWEST_ROWS), np.log(MOST_ROWS)))))
    fewest = 3.0 if foreign else 1.0
    most = max(min(rows / FEWEST_ROWS_OF_CYCLE, MOST_CYCLES), fewest)
    rows = max(rows, round(fewest * FEWEST_ROWS_OF_CYCLE) if foreign else FEWEST_ROWS)
    run_in = ""
    if not foreign and most >= 3 and random.random() < 0.5:
        run_in = str(random.choice(["first loading", "f rises"]))
        most = max(most, 4.0)
        fewest = 3.0
    return Draw(
        scene=scene,
        gross=gross,
        control="U" if gross else str(random.choice(["U", "Q"])),
        form=str(random.choice(FORMS)),
        rows=rows,
        cycles=float(random.uniform(fewest, most)),
        noise=float(random.choice([0.0, LARGEST_NOISE * random.random() ** 2])),
        digits=int(random.choice([3, 4, 5, 7])),
        drift=float(random.choice([0.0, LARGEST_DRIFT * random.uniform(-1, 1)])),
        run_in=run_in,
        foreign=foreign,
    )


def steady_cycle(draw: Draw) -> tuple[Array, Array, float]:
    """U and Q of a cycle by theory from the highest Q on, and its W; a gross one slides at f P by
    a third of its range of U at each end.
    """
    path = draw.scene.load.path()
    assert path.period is not None
    shares = np.linspace(0.0, 1.0, INSTANTS)
    times = path.cycle_start + path.period * (1 + shares)
    solution = semi_analytic.solve(
        draw.scene, x=0.0, time=times, fields="tangential_displacement", cycles="steady"
    )
    shift = np.asarray(solution.tangential_displacement)
    load = np.asarray(solution.tangential_load)
    if draw.gross:
        slide = float(np.ptp(shift)) / 3
        half = INSTANTS // 2
        part = np.linspace(0.0, 1.0, INSTANTS // 4)
        shift = np.concatenate(
            [
                shift[: half + 1],
                shift[half] - slide * part,
                shift[half:] - slide,
                shift[-1] - slide * (1 - part),
            ]
        )
        at_end = np.ones(len(part))
        load = np.concatenate(
            [load[: half + 1], load[half] * at_end, load[half:], load[-1] * at_end]
        )
    return shift, load, float(np.sum((load[1:] + load[:-1]) / 2 * np.diff(shift)))


def wave_of(form: str, share: Array, random: np.random.Generator) -> Array:
    """Between 1 and -1, from its highest value at share 0 to the lowest at 0.5."""
    place = np.mod(share, 1.0)
    if form == "triangle":
        return 4 * np.abs(place - 0.5) - 1
    if form == "sine":
        return np.cos(2 * np.pi * place)
    # A servo's: rounded corners, and slower on one way than on the other.
    bend = random.uniform(0.0, 0.15)
    triangle = np.arcsin(0.97 * np.cos(2 * np.pi * (place + bend * np.sin(2 * np.pi * place) / 6)))
    return triangle / np.arcsin(0.97)


def ascending(values: Array, others: Array) -> tuple[Array, Array]:
    """Where values that ascend do more than stand still."""
    moves = np.concatenate([[True], np.diff(values) > 0])
    return values[moves], others[moves]


def rows_of(draw: Draw, random: np.random.Generator) -> tuple[Array, Array, float]:
    """U and Q of the rows without noise, and W of a cycle."""
    shift, load, work = steady_cycle(draw)
    turn = int(np.argmin(shift)) if draw.control == "U" else int(np.argmin(load))
    place = random.random() + draw.cycles * np.arange(draw.rows) / draw.rows
    share = np.mod(place, 1.0)
    driving, other = (shift, load) if draw.control == "U" else (load, shift)
    middle = (driving.max() + driving.min()) / 2
    driven = middle + np.ptp(driving) / 2 * wave_of(draw.form, place, random)
    # Straight lines between instants would be an error of a few digits' steps.
    falling = PchipInterpolator(*ascending(driving[turn::-1], other[turn::-1]))(driven)
    rising = PchipInterpolator(*ascending(driving[turn:], other[turn:]))(driven)
    answer = np.where(share < 0.5, falling, rising)
    u, q = (driven, answer) if draw.control == "U" else (answer, driven)
    cycle = (place - place[0]) / draw.cycles
    if draw.foreign in ("grows", "shrinks"):
        change = random.uniform(0.2, 0.6)
        size = 1 + change * (cycle if draw.foreign == "grows" else -cycle)
        u, q = u * size, q * size
    elif draw.foreign == "walks":
        u = u + random.choice([-1, 1]) * random.uniform(0.1, 0.5) * np.ptp(u) * (place - place[0])
    elif draw.foreign == "hardens":
        u, q, work = hardening_loop(share, float(np.ptp(u)), float(np.ptp(q)), random)
    elif draw.foreign == "period of two cycles":
        size = 1 + random.uniform(0.1, 0.3) * np.cos(np.pi * place)
        u, q = u * size, q * size
    if draw.run_in == "f rises":
        size = 1 - 0.4 * np.exp(-(place - place[0]) / 0.5)
        u, q = (u, q * size) if draw.control == "U" else (u / size, q)
    elif draw.run_in == "first loading":
        part = np.linspace(0.0, 1.0, max(draw.rows // 20, 3))
        u = np.concatenate([u[0] * part**1.2, u])
        q = np.concatenate([q[0] * part, q])
    rig = random.uniform(0.0, 1.0) * np.ptp(shift) / np.ptp(load)
    u = u + rig * q + random.uniform(-1.0, 1.0) * np.ptp(shift)
    u = u + draw.drift * np.ptp(u) * np.linspace(0.0, 1.0, len(u))
    return u, q, work


def hardening_loop(
    share: Array, range_of_u: float, range_of_q: float, random: np.random.Generator
) -> tuple[Array, Array, float]:
    """Rows of a bilinear elastic-plastic loop under a triangle of U: elastic, then plastic with a
    tenth to a third of the stiffness; and its area.
    """
    wave = 4 * np.abs(share - 0.5) - 1
    yields = random.uniform(0.15, 0.5)
    hardening = random.uniform(0.1, 0.3)
    passed = np.where(share < 0.5, 1 - wave, 1 + wave)  # of U since the turning point, 0 to 2
    force = np.where(passed < 2 * yields, passed, 2 * yields + hardening * (passed - 2 * yields))
    most = 2 * yields + hardening * (2 - 2 * yields)
    q = np.where(share < 0.5, most / 2 - force, force - most / 2) * range_of_q / most
    area = 2 * yields * (2 - 2 * yields) * (1 - hardening)
    return wave * range_of_u / 2, q, 2 * area * range_of_q / most * range_of_u / 4


def written(folder: Path, draw: Draw, u: Array, q: Array, random: np.random.Generator) -> Path:
    """The table with noise and the digits that an instrument of this range has."""
    columns = []
    for values in (u, q):
        noisy = values + draw.noise * np.ptp(values) / 2 * random.standard_normal(len(values))
        place = int(np.floor(np.log10(np.max(np.abs(noisy))))) + 1 - draw.digits
        step = 10.0**place
        columns.append([f"{number * step:.12g}" for number in np.round(noisy / step).tolist()])
    path = folder / "loop.csv"
    rows = [",".join(row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(["U,Q", *rows]) + "\n", encoding="utf-8")
    return path


# ------------------------------------------------------------------------------- what is answered
def outcome_of(seed: int, number: int, folder: Path) -> Outcome:
    """The answer to one table."""
    random = np.random.default_rng([seed, number])
    draw = draw_of(random)
    u, q, work = rows_of(draw, random)
    path = written(folder, draw, u, q, random)
    begin = time.process_time()
    try:
        score = score_loop(read_loop(path, Mapping(), draw.scene), draw.scene)
    except InputError as error:
        return Outcome(draw, refusal=str(error).replace(str(path), "FILE"))
    return compared(draw, score, work, time.process_time() - begin)


def compared(draw: Draw, score: LoopScore, work: float, seconds: float) -> Outcome:
    """An answer beside what is true."""
    friction = draw.scene.friction.coefficient
    high = np.inf if score.highest_friction is None else score.highest_friction
    measured = score.loops[0]
    above = float(high - score.friction)
    below = score.friction - score.lowest_friction
    return Outcome(
        draw=draw,
        friction_error=score.friction / friction - 1,
        half_interval=max(above, below) / friction,
        side_of_truth=(above if friction > score.friction else below) / friction,
        friction_covered=bool(score.lowest_friction <= friction <= high),
        work_error=measured.area / work - 1,
        work_uncertainty=measured.area_uncertainty / work,
        seconds=seconds,
    )


def line_of(outcome: Outcome) -> str:
    """One outcome."""
    if outcome.refusal:
        return f"refused: {outcome.refusal}"
    return (
        f"f {100 * outcome.friction_error:+.3g} % ± {100 * outcome.half_interval:.2g} %"
        f" {'' if outcome.friction_covered else 'OUTSIDE'}; W {100 * outcome.work_error:+.3g} % ±"
        f" {100 * outcome.work_uncertainty:.2g} % {'' if outcome.work_covered else 'OUTSIDE'}"
    )


def median_ratio(pairs: list[tuple[float, float]]) -> float:
    """Of what is stated over the true error; 2.9 for an exact interval of 95 %, NaN of none."""
    if not pairs:
        return np.nan
    return float(np.median([stated / max(abs(error), 1e-12) for stated, error in pairs]))


def report(outcomes: list[Outcome]) -> None:
    """The table of all."""
    groups = {
        "partial": [o for o in outcomes if not (o.draw.foreign or o.draw.run_in or o.draw.gross)],
        "gross": [o for o in outcomes if o.draw.gross and not (o.draw.foreign or o.draw.run_in)],
        "run-in": [o for o in outcomes if o.draw.run_in],
        "all that fit": [o for o in outcomes if not o.draw.foreign],
    }
    print(
        "\nloops          n  refused  answered  f covered  W covered"
        "  interval/error: side of the true f  wider side  W stated/error  seconds"
    )
    for name, group in groups.items():
        answered = [o for o in group if not o.refusal]
        print(
            f"{name:13}{len(group):4}{len(group) - len(answered):9}{len(answered):10}"
            f"{sum(o.friction_covered for o in answered):11}"
            f"{sum(o.work_covered for o in answered):11}"
            f"{median_ratio([(o.side_of_truth, o.friction_error) for o in answered]):35.2f}"
            f"{median_ratio([(o.half_interval, o.friction_error) for o in answered]):12.2f}"
            f"{median_ratio([(o.work_uncertainty, o.work_error) for o in answered]):16.2f}"
            f"{np.mean([o.seconds for o in answered]) if answered else np.nan:9.2f}"
        )
    print("\nnot of the model        n  refused")
    for name in FOREIGN:
        group = [o for o in outcomes if o.draw.foreign == name]
        print(f"{name:22}{len(group):4}{sum(bool(o.refusal) for o in group):9}")
    print("\nrefusals")
    reasons = Counter(
        ("foreign: " if o.draw.foreign else "of the model: ") + o.refusal[:110]
        for o in outcomes
        if o.refusal
    )
    for reason, count in reasons.most_common():
        print(f"{count:4}  {reason}")


def main() -> None:
    """Draw, score, print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else int(np.random.default_rng().integers(SEEDS))
    print(f"{count} loops, seed {seed}")
    outcomes = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            outcome = outcome_of(seed, number, Path(folder))
            print(f"{number:4} {outcome.draw.words}\n     {line_of(outcome)}", flush=True)
            outcomes.append(outcome)
    report(outcomes)


if __name__ == "__main__":
    main()
