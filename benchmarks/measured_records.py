"""Synthetic records of P and Q in the files that instruments write, through `halfplane check` and
`halfplane exact`: the right answer, or a question.

    python benchmarks/measured_records.py RECORDS [SEED]     (the seed is drawn, and printed)

Each draw takes a history (rest, ramp of P, run-in, cycles), an instrument, a language, an encoding,
a way to write time and units, channels that are missing and faults of the file at random. The scene
states the thickness alone. Where a command refuses the file, what its sentence asks for is added as
a user would who knows the rig, and the command is run again. A record is misread where rows or W
that are answered are not those of the history.

# notation: f friction coefficient, P and Q loads, U displacement, W dissipation
"""

from __future__ import annotations

import contextlib
import csv
import datetime
import io
import json
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import semi_analytic
from reports.cli import main as halfplane
from scenes import Scene, TimeSeriesLoad, load_scene

Array = NDArray[np.float64]

SEEDS = 2**32
SCENE = "hertz-paper"
LARGEST_LOAD = 160.0  # P, N/mm
THICKNESS = 8.0  # mm
VOLT = 250.0  # N a volt
# A user who is asked more often gives up.
MOST_QUESTIONS = 6
# Of the largest P and Q: what digits and noise of the file may leave in a row, and in W where
# `check` does not warn of noise.
ROW_ERROR = 0.03
WORK_ERROR = 0.02

HEADINGS = {
    "English": ("Time", "Normal force", "Tangential force", "Displacement"),
    "English load cell": ("Elapsed Time", "Load", "Shear load", "Stroke"),
    "German": ("Zeit", "Normalkraft", "Reibkraft", "Weg"),
    "French": ("Temps", "Effort normal", "Force tangentielle", "Déplacement"),
    "Italian": ("Tempo", "Carico normale", "Forza di attrito", "Spostamento"),
    "Spanish": ("Tiempo", "Fuerza normal", "Fuerza de fricción", "Desplazamiento"),
    # not in the table of languages, or of channels: asked for
    "Dutch": ("Tijd", "Normaalkracht", "Wrijvingskracht", "Weg"),
    "channels": ("Time", "CH1", "CH2", "CH3"),
    "set and actual": ("Time", "Normal force actual", "Friction force actual", "U actual"),
}
UNITS_OF_FORCE = {"N": 1.0, "kN": 1e3, "daN": 10.0, "Newton": 1.0, "lbf": 4.4482216152605}
UNITS_OF_TIME = {"s": 1.0, "ms": 1e-3, "min": 60.0}
FORMATS = ("numbers", "clock", "date", "ISO", "none")
SEPARATORS = ("comma", "semicolon", "tab")
MARKS = {"comma": ",", "semicolon": ";", "tab": "\t"}
ENCODINGS = ("utf-8", "utf-8-sig", "cp1252", "utf-16", "utf-16-le")
FAULTS = ("", "", "", "", "empty cell", "thousands", "headings once more", "tension is positive")


@dataclass(frozen=True)
class Draw:
    """One record and how it is written."""

    seed: int
    friction: float
    language: str
    separator: str
    decimal: str
    encoding: str
    times: str
    time_unit: str
    force_unit: str
    units_in: str  # "headings", "a line", "volts"
    preamble: int
    footer: bool
    quoted: bool
    with_displacement: bool
    with_normal: bool
    shuffled: bool
    fault: str
    noise: float
    cycles: int
    rows_of_cycle: int
    no_load: bool
    run_in: bool
    drift: float

    @property
    def words(self) -> str:
        """For a line of the report."""
        channels = "P, Q" if self.with_normal else "Q"
        fault = f", {self.fault}" if self.fault else ""
        return (
            f"{self.language}, {self.encoding}, {self.separator}, decimal {self.decimal}, times:"
            f" {self.times}, units in {self.units_in}, {channels}, {self.cycles} cycles of"
            f" {self.rows_of_cycle} rows, noise {self.noise:.2g}{fault}"
        )


@dataclass(frozen=True)
class Outcome:
    """What became of a record: "right", "asked", "refused" or "misread", with the last sentence."""

    draw: Draw
    kind: str
    questions: tuple[str, ...]
    sentence: str = ""


# ----------------------------------------------------------------------------------- what is drawn
def draw_of(seed: int, number: int) -> Draw:
    """A record and a way to write it."""
    random = np.random.default_rng([seed, number])

    def one_of(*choices: str) -> str:
        return str(random.choice(choices))

    separator = one_of(*SEPARATORS)
    units_in = one_of("headings", "headings", "a line", "a line", "volts")
    return Draw(
        seed=number,
        friction=float(random.uniform(0.4, 0.8)),
        language=one_of(*HEADINGS),
        separator=separator,
        decimal="point" if separator == "comma" else one_of("point", "comma"),
        encoding=one_of(*ENCODINGS),
        times=one_of(*FORMATS),
        time_unit=one_of(*UNITS_OF_TIME),
        force_unit=one_of(*UNITS_OF_FORCE),
        units_in=units_in,
        preamble=int(random.integers(0, 6)),
        footer=bool(random.random() < 0.3),
        quoted=bool(random.random() < 0.2),
        with_displacement=bool(random.random() < 0.5),
        with_normal=bool(random.random() < 0.8),
        shuffled=bool(random.random() < 0.3),
        fault=one_of(*FAULTS),
        noise=float(random.choice([0.0, 0.002 * random.random()])),
        cycles=int(random.integers(3, 12)),
        rows_of_cycle=int(random.integers(24, 120)),
        no_load=bool(random.random() < 0.4),
        run_in=bool(random.random() < 0.4),
        drift=float(random.choice([0.0, 0.1])),
    )


def history_of(draw: Draw) -> Array:
    """Rows of time, P and Q without noise, in s and N/mm."""
    rows = draw.rows_of_cycle
    phase = np.arange(draw.cycles * rows + 1) / rows
    amplitude = np.full(len(phase), 0.7 * draw.friction * LARGEST_LOAD)
    if draw.run_in:
        amplitude *= np.clip(0.5 + 0.25 * np.floor(phase), 0.0, 1.0)
    wave = amplitude * np.sin(2 * np.pi * phase) + draw.drift * 30 * phase / draw.cycles
    normal = np.full(len(wave), LARGEST_LOAD)
    tangential = np.asarray(wave)
    if draw.with_normal:  # a ramp, and perhaps rows before it without a load
        ramp = LARGEST_LOAD * np.arange(1, 11) / 10
        before = np.zeros(20 * draw.no_load)
        normal = np.concatenate([before, ramp, normal])
        tangential = np.concatenate([0 * before, 0 * ramp, tangential])
    return np.column_stack([0.02 * np.arange(len(normal)), normal, tangential])


# ------------------------------------------------------------------------------ how it is written
def number_in_words(draw: Draw, value: float, digits: int = 8) -> str:
    """A number in the file's decimal sign; with marks between thousands where that is the fault."""
    text = f"{value:.{digits}g}"
    if draw.fault == "thousands" and abs(value) >= 1000:
        text = f"{value:,.3f}"
        if draw.decimal == "comma":
            return text.translate(str.maketrans(",.", ".,"))
        return text
    return text.replace(".", ",") if draw.decimal == "comma" else text


def time_in_words(draw: Draw, seconds: float) -> str:
    """A time as the instrument writes it; the record begins two seconds before midnight."""
    instant = datetime.datetime(2026, 11, 29, 23, 59, 58) + datetime.timedelta(
        milliseconds=round(1000 * seconds)
    )
    clock = f"{instant:%H:%M:%S}.{instant.microsecond // 1000:03d}"
    if draw.decimal == "comma":
        clock = clock.replace(".", ",")
    if draw.times == "clock":
        return clock
    if draw.times == "date":
        return f"{instant:%d.%m.%Y} {clock}"
    if draw.times == "ISO":
        return f"{instant:%Y-%m-%dT%H:%M:%S}.{instant.microsecond // 1000:03d}Z"
    return number_in_words(draw, seconds / UNITS_OF_TIME[draw.time_unit])


def written(folder: Path, draw: Draw, rows: Array) -> dict[str, str]:
    """The file record.csv; returns the headings of its columns, by the names of a scene."""
    random = np.random.default_rng([draw.seed, 1])
    time, normal, tangential = rows.T
    size = VOLT if draw.units_in == "volts" else UNITS_OF_FORCE[draw.force_unit]
    forces = {"P": normal * THICKNESS / size, "Q": tangential * THICKNESS / size}
    for name, values in forces.items():
        scatter = draw.noise * np.max(np.abs(values)) * random.standard_normal(len(values))
        forces[name] = values + scatter
    if draw.fault == "tension is positive":
        forces["P"] = -forces["P"]
    names = dict(zip(("time", "P", "Q", "U"), HEADINGS[draw.language], strict=True))
    unit = "V" if draw.units_in == "volts" else draw.force_unit
    units = {"time": draw.time_unit if draw.times == "numbers" else "", "P": unit, "Q": unit}
    units["U"] = "µm"
    columns = {"time": [time_in_words(draw, second) for second in time.tolist()]}
    for name, values in forces.items():
        columns[name] = [number_in_words(draw, value) for value in values.tolist()]
    columns["U"] = [number_in_words(draw, value, 4) for value in (tangential / 9).tolist()]
    if draw.times == "none":
        del columns["time"]
    if not draw.with_normal:
        del columns["P"]
    if not draw.with_displacement:
        del columns["U"]
    order = list(columns)
    if draw.shuffled:
        random.shuffle(order)
    headings = [names[name] for name in order]
    if draw.units_in != "a line":
        headings = [
            f"{names[name]} [{units[name]}]" if units[name] else names[name] for name in order
        ]
    stream = io.StringIO()
    quoting = csv.QUOTE_ALL if draw.quoted else csv.QUOTE_MINIMAL
    table = csv.writer(stream, delimiter=MARKS[draw.separator], quoting=quoting)
    for line in range(draw.preamble):
        table.writerow([f"Item {line}", f"value {line}"])
    table.writerow(headings)
    if draw.units_in == "a line":
        table.writerow([f"({units[name]})" if draw.quoted else units[name] for name in order])
    middle = len(time) // 2
    for row, cells in enumerate(zip(*(columns[name] for name in order), strict=True)):
        cells_written = list(cells)
        if row == middle and draw.fault == "headings once more":
            table.writerow(headings)
        if row == middle and draw.fault == "empty cell":
            cells_written[order.index("Q")] = ""
        table.writerow(cells_written)
    if draw.footer:
        table.writerow(["End of test"])
    (folder / "record.csv").write_bytes(stream.getvalue().encode(draw.encoding, "replace"))
    return dict(zip(order, headings, strict=True))


# ------------------------------------------------------------------------------- what is answered
def scene_text(draw: Draw, keys: dict[str, str]) -> str:
    """The scene file with these keys of its load."""
    lines = "\n".join(f"{key} = {value}" for key, value in keys.items())
    return f"""
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[profile]
kind = "hertz"
radius = 1000.0
[friction]
coefficient = {draw.friction!r}
[load]
kind = "time_series"
file = "record.csv"
thickness = {THICKNESS}
{lines}
"""


def answer_to(draw: Draw, headings: dict[str, str], sentence: str) -> dict[str, str]:
    """Keys that a user adds who knows the rig, and does what a sentence asks for; none where it
    asks for a change of the file.
    """
    asked = {
        "none is known as": {
            "columns": "{"
            + ", ".join(f'{k} = "{v}"' for k, v in headings.items() if k != "U")
            + "}"
        },
        "constant_normal_load": {"constant_normal_load": repr(LARGEST_LOAD)},
        "interval =": {"interval": "0.02"},
        "units, such as": {},
        "factor by scale": {"scale": f"{{P = {VOLT}, Q = {VOLT}}}"},
        "turn its sign": {"sign": "{P = -1}"},
    }
    keys: dict[str, str] = {}
    for words, answer in asked.items():
        if words in sentence:
            keys |= answer
    if draw.with_normal:
        keys.pop("constant_normal_load", None)
    if draw.times != "none":
        keys.pop("interval", None)
    least_load = re.search(r"least_normal_load = ([\d.]+)", sentence)
    if least_load is not None:
        keys["least_normal_load"] = least_load[1]
    return keys


def run(*words: str) -> tuple[int, str, str]:
    """A command in this process: exit code, stdout, stderr."""
    out = io.StringIO()
    errors = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        code = halfplane(list(words))
    return code, out.getvalue(), " ".join(errors.getvalue().split())


def outcome_of(seed: int, number: int, folder: Path) -> Outcome:
    """What `check` and `exact` make of one record, with the user's answers to their questions."""
    draw = draw_of(seed, number)
    rows = history_of(draw)
    headings = written(folder, draw, rows)
    scene = folder / "record.toml"
    keys: dict[str, str] = {}
    questions: list[str] = []
    while True:
        scene.write_text(scene_text(draw, keys), encoding="utf-8")
        code, _, sentence = run("check", str(scene), "--json")
        if code == 0:
            break
        question = sentence.replace(str(folder), "")
        answers = answer_to(draw, headings, sentence)
        new_keys = {key: value for key, value in answers.items() if keys.get(key) != value}
        if code != 2 or not new_keys or len(questions) == MOST_QUESTIONS:
            kind = "refused" if code == 2 else "misread"
            return Outcome(draw, kind, tuple(questions), question)
        questions.append(question)
        keys |= new_keys
    code, text, sentence = run("exact", str(scene), "--json")
    if code != 0:
        return Outcome(draw, "misread", tuple(questions), f"exact ends with {code}: {sentence}")
    fault = fault_of(load_scene(scene), rows, json.loads(text), draw.noise > 0)
    kind = "asked" if questions else "right"
    if fault:
        kind = "misread"
    return Outcome(draw, kind, tuple(questions), fault)


def fault_of(scene: Scene, rows: Array, content: dict, is_noisy: bool) -> str:
    """What of an answer is not that of the history; empty for a right one."""
    load = scene.load
    assert isinstance(load, TimeSeriesLoad)
    read = load.rows.values
    if read.shape != rows.shape:
        return f"{len(read)} rows for {len(rows)}"
    times = read[:, 0] - read[0, 0]
    if np.max(np.abs(times - rows[:, 0])) > 1e-3 * rows[-1, 0]:
        return f"time goes to {times[-1]:g} s, not to {rows[-1, 0]:g}"
    for name, column in (("P", 1), ("Q", 2)):
        error = np.max(np.abs(read[:, column] - rows[:, column])) / np.max(np.abs(rows[:, column]))
        if error > ROW_ERROR:
            return f"{name} differs by {100 * error:.2g} % of its largest"
    true_load = TimeSeriesLoad(rows=rows[np.argmax(rows[:, 1] > 0) :])
    truth = semi_analytic.solve(
        scene.vary(load=true_load), x=[0.0], time=rows[[-1], 0], fields=("dissipation",)
    ).dissipation
    work = content["result"]["dissipation"]
    error = work / truth - 1
    if abs(error) > (3 * WORK_ERROR if is_noisy else WORK_ERROR):
        return f"W differs by {100 * error:.2g} %"
    return ""


def report(outcomes: list[Outcome], print_line: Callable[[str], object] = print) -> None:
    """The table of all, by what was drawn."""
    kinds = ("right", "asked", "refused", "misread")
    groups: dict[str, Callable[[Draw], str]] = {
        "headings": lambda draw: draw.language,
        "encoding": lambda draw: draw.encoding,
        "times": lambda draw: draw.times,
        "units in": lambda draw: draw.units_in,
        "P": lambda draw: "recorded" if draw.with_normal else "not recorded",
        "fault": lambda draw: draw.fault or "none",
        "all": lambda _draw: "",
    }
    print_line(f"\n{'':30}" + "".join(f"{kind:>10}" for kind in kinds))
    for group, word_of in groups.items():
        for word in dict.fromkeys(word_of(outcome.draw) for outcome in outcomes):
            count = Counter(o.kind for o in outcomes if word_of(o.draw) == word)
            cells = "".join(f"{count[kind]:10}" for kind in kinds)
            print_line(f"{group:10}{word:20}{cells}")
    asked = Counter(len(outcome.questions) for outcome in outcomes if outcome.kind == "asked")
    print_line(f"\nquestions before the right answer: {dict(sorted(asked.items()))}")


def main() -> None:
    """Draw, run, print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else int(np.random.default_rng().integers(SEEDS))
    print(f"{count} records, seed {seed}")
    outcomes = []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count):
            outcome = outcome_of(seed, number, Path(folder))
            print(f"{number:4} {outcome.kind:8}{outcome.draw.words}", flush=True)
            for sentence in (*outcome.questions, outcome.sentence):
                if sentence:
                    print(f"       {sentence[:300]}")
            outcomes.append(outcome)
    report(outcomes)


if __name__ == "__main__":
    main()
