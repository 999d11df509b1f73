"""CalculiX' answer to a scene: its program run on the deck, its result judged by the metrics of our
own finite elements.

The table of three columns, theory, our finite elements and CalculiX, is the same on the terminal,
in third.json and on the page.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from halfplane_fe.scales import Scales
from halfplane_fe.solution import versions
from reports.charts.templating import words_of
from reports.comparison import Comparison
from reports.comparison.json_values import strict_json_values
from reports.comparison.words import part_of_path, value_in_words
from reports.console import Stages
from reports.report import Report
from reports.scoring.against import score_solution
from reports.scoring.mapping import Mapping
from reports.scoring.reading import read_result
from reports.scoring.solution import solution_of_surface, theory_of_whole_path
from reports.studies.third.deck import Deck, DeckSettings, build_deck, deck_text
from reports.units import energy_unit, number, units
from scenes import ContactSolution, ConvergenceError, InputError, Scene, read_only_copy

# Seconds between two looks at the status file.
_SECONDS_BETWEEN_LOOKS = 0.25
# Last lines of the log that a failure shows.
_N_SHOWN_LOG_LINES = 6
# CalculiX prints times to six digits.
_RELATIVE_ERROR_OF_PRINTED_TIME = 1e-5


@dataclass(frozen=True)
class RunRecord:
    """How a run of CalculiX that reached its end went: wall time [s], number of accepted
    increments, iterations of all increments, those not accepted among them.
    """

    seconds: float
    n_increments: int
    n_iterations: int


@dataclass(frozen=True, eq=False)
class ThirdSolver:
    """The answer of CalculiX, a third solver, to a scene; or why it has none.

    Attributes
    ----------
    code
        with its version
    deck, text
        its input, as a value and as written
    comparison
        its answer against half-plane theory; None where it failed
    run_record
        how the run went; None where it failed
    failure
        the sentence, "" where it did not
    guesses
        what was assumed in reading its answer
    """

    code: str
    deck: Deck
    text: str
    comparison: Comparison | None = None
    run_record: RunRecord | None = None
    failure: str = ""
    guesses: tuple[str, ...] = ()

    @property
    def heads(self) -> tuple[str, str, str, str]:
        """Titles of the columns."""
        return ("quantity", "half-plane theory", "our finite elements", self.code)

    def rows(self, comparison_of_elements: Comparison) -> list[tuple[str, ...]]:
        """Rows of the table of three solvers: half-plane theory, our finite elements and CalculiX.
        They have a few values of each, errors against theory, and the time of the run; "–" where
        there is no value.

        `comparison_of_elements` is that of our finite elements with theory (`reference`);
        `self.comparison` is that of CalculiX with theory, None where it failed.
        """
        # values, each with a function that takes it from a solution
        third_comparison = self.comparison
        solutions = [comparison_of_elements.reference, comparison_of_elements.result]
        if third_comparison:
            solutions.append(third_comparison.result)
        table_rows: list[tuple[str, ...]] = []
        for name, unit, value_of_solution in _compared_values(comparison_of_elements.scene):
            values = [value_of_solution(solution) for solution in solutions]
            values += [math.nan] * (3 - len(values))
            cells = [number(value) if math.isfinite(value) else "–" for value in values]
            table_rows.append((f"{name} [{unit}]", *cells))

        # errors: metrics of both comparisons
        for key in (
            "dissipation",
            "peak_pressure",
            "pressure",
            "shear",
            "contact_edge",
            "stick_edge",
        ):
            metric = comparison_of_elements.metric(key)
            table_rows.append(
                (
                    f"{metric.label}: error",
                    "reference",
                    value_in_words(metric),
                    value_in_words(third_comparison.metric(key)) if third_comparison else "–",
                )
            )

        # times; `work.seconds`: of each stage of a solution
        time_cells = []
        for solution in (comparison_of_elements.reference, comparison_of_elements.result):
            seconds = sum(solution.work.seconds.values())
            time_cells.append(f"{seconds:.2f}" if seconds else "–")
        time_cells.append(f"{self.run_record.seconds:.1f}" if self.run_record else "–")
        table_rows.append(("time [s]", *time_cells))
        return table_rows

    @property
    def sentences(self) -> list[str]:
        """Sentences beside the numbers of CalculiX: why it failed or how the run went, then known
        limits of its numbers.

        `code` is CalculiX with its version, `run_record` has the counts of increments and
        iterations, None where the run failed.
        """
        size = f"{self.deck.node_count} nodes, {len(self.deck.time) - 1} instants"
        if self.run_record is None:
            first_sentence = f"{self.code} gave no answer ({size}): {self.failure}."
        else:
            first_sentence = (
                f"{self.code} on the exported deck: {size}, {self.run_record.n_increments}"
                f" increments, {self.run_record.n_iterations} iterations."
            )
        return [first_sentence, *_limits_in_words(self.deck)]

    @property
    def _notes(self) -> list[str]:
        return [*self.guesses, *self.comparison.result.record.notes] if self.comparison else []

    def page_words(self, comparison_of_elements: Comparison) -> dict[str, Any]:
        """The texts that the block of a page on CalculiX is filled with, by name.
        `comparison_of_elements` is that of our finite elements with theory.
        """
        # why it failed, or how the run went; then known limits
        first_sentence, *limits = self.sentences
        table = {"heads": self.heads, "rows": self.rows(comparison_of_elements)}
        return {
            **table,
            "told": first_sentence,
            "failed": bool(self.failure),
            "limits": limits,
            "notes": self._notes,
        }

    def as_json(self, comparison_of_elements: Comparison) -> str:
        """The content of the file third.json: values and metrics of theory, our finite elements and
        CalculiX side by side, the deck, the run, known limits and notes; strict JSON.

        `comparison_of_elements` is that of our finite elements with theory (`reference`);
        `self.comparison` is that of CalculiX with theory, None where it failed. The deck is
        CalculiX' input: `node_count` is that of both meshes, `stiffness` is pressure per
        penetration, `stick_slope` shear per elastic slip.
        """
        deck = self.deck
        third_comparison = self.comparison
        third_metrics: dict[str, float | None] = {}
        if third_comparison is not None:
            third_metrics = {metric.key: metric.value for metric in third_comparison.metrics}

        # a few values, each with a function that takes it from a solution
        values_by_name = {}
        for name, unit, value_of_solution in _compared_values(comparison_of_elements.scene):
            values_by_name[name] = {
                "unit": unit,
                "theory": value_of_solution(comparison_of_elements.reference),
                "ours": value_of_solution(comparison_of_elements.result),
                "third": value_of_solution(third_comparison.result) if third_comparison else None,
            }
        content = {
            "format": "halfplane third opinion 1",
            "code": self.code,
            "failure": self.failure or None,
            "deck": {
                "settings": asdict(deck.settings),
                "nodes": deck.node_count,
                "instants": len(deck.time) - 1,
                "element_size": deck.element_size,
                "stiffness": deck.stiffness,
                "stick_slope": deck.stick_slope,
            },
            "run": _run_content(self.run_record) if self.run_record else None,
            "figures": values_by_name,
            "metrics": {
                metric.key: {"ours": metric.value, "third": third_metrics.get(metric.key)}
                for metric in comparison_of_elements.metrics
            },
            "limits": _limits_in_words(deck),
            "notes": self._notes,
        }
        return (
            json.dumps(strict_json_values(content), allow_nan=False, indent=1, ensure_ascii=False)
            + "\n"
        )


def _run_content(run_record: RunRecord) -> dict[str, float]:
    """How a run of CalculiX went, as content of the file third.json: wall time [s], and the numbers
    of increments and iterations.
    """
    return {
        "seconds": run_record.seconds,
        "increments": run_record.n_increments,
        "iterations": run_record.n_iterations,
    }


def find_calculix() -> Path:
    """Path of `ccx`, the program of CalculiX; InputError, with how to install it, where it is not
    found.
    """
    program = shutil.which("ccx")
    if program is None:
        raise InputError(
            "--third calculix: ccx is not on PATH; `make peers` installs it (Debian package"
            " calculix-ccx)"
        )
    return Path(program)


def calculix_version(program: Path) -> str:
    """The version of CalculiX that a program is, such as "2.20"; "of unknown version" where it
    prints none.
    """
    output = subprocess.run(
        [str(program), "-v"], capture_output=True, text=True, check=False, timeout=20
    ).stdout
    version_match = re.search(r"[Vv]ersion\s+([\w.]+)", output)
    return version_match[1] if version_match else "of unknown version"


# Seconds after which CalculiX is stopped.
TIME_LIMIT = 1800.0


def solve_with_calculix(
    scene: Scene,
    settings: DeckSettings,
    stages: Stages,
    scales: Scales | None = None,
    command: str = "",
) -> ThirdSolver:
    """Solve a scene with the finite-element program CalculiX: write its input deck into a temporary
    folder, run the program, read the result, and compare it with half-plane theory. A run that
    fails is reported in `failure` of what is returned.

    Parameters
    ----------
    settings
        of the deck: element sizes, increments
    stages
        shows and measures the stages of the job
    scales
        length and load scales of the contact from an earlier solution; spares a coarse solve
    command
        command line that is stated in the deck

    Returns
    -------
    ThirdSolver
        the deck and its text; the comparison, what was assumed in reading the result (`guesses`)
        and the record of the run, where it did not fail

    Raises
    ------
    InputError
        Where there is no CalculiX, or the scene can't be made a deck.
    """
    program = find_calculix()
    code = f"CalculiX {calculix_version(program)}"
    with stages.stage("deck"):
        deck = build_deck(scene, settings, scales)
        third_solver = ThirdSolver(code, deck, deck_text(deck, command, versions()))

    # TIME_LIMIT: 1800 s
    with tempfile.TemporaryDirectory(prefix="halfplane-third-") as folder_name:
        folder = Path(folder_name)
        (folder / "third.inp").write_text(third_solver.text, encoding="utf-8")
        try:
            with stages.stage(code, "per cent of the load path") as show_progress:
                run_record = run_calculix(
                    program, folder, "third", float(deck.deck_time[-1]), TIME_LIMIT, show_progress
                )
        except ConvergenceError as failure:
            return replace(third_solver, failure=str(failure))
        with stages.stage("reading CalculiX"):
            report_on_answer = score_deck(folder / "third.frd", deck, code)

    return replace(
        third_solver,
        comparison=report_on_answer.comparison,
        guesses=report_on_answer.guesses,
        run_record=run_record,
    )


def run_calculix(
    program: Path,
    folder: Path,
    name: str,
    end_time: float,
    time_limit: float,
    show_progress: Callable[[int, int | None, str], None] | None = None,
) -> RunRecord:
    """Run the finite-element program CalculiX on the input deck `name`.inp of a folder, with one
    thread, until it ends.

    Parameters
    ----------
    program
        path of CalculiX
    end_time
        total time of the deck's last instant, in the scene's unit of time
    time_limit
        wall time [s]
    show_progress
        called again and again with the time reached in per cent of `end_time`, 100, and a text

    Returns
    -------
    RunRecord
        wall time [s], number of accepted increments, iterations of all attempts

    Raises
    ------
    ConvergenceError
        With the last lines of its log where it stopped early, by itself or by the limit. The
        process has ended in any case.
    """
    start_of_run = time.monotonic()
    log_file = folder / f"{name}.log"
    # a line for each attempt to solve an increment, which may be accepted or not
    status_file = folder / f"{name}.sta"
    with log_file.open("w", encoding="utf-8") as stream:
        process = subprocess.Popen(
            [str(program), "-i", name],
            cwd=folder,
            env={**os.environ, "OMP_NUM_THREADS": "1", "CCX_NPROC_RESULTS": "1"},
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
        )

        def show_attempts() -> None:
            """Report how far the run is, by its status file."""
            if show_progress is not None:
                _show_time_reached(attempts_in(status_file), end_time, show_progress)

        is_late = _wait_for_end(process, start_of_run + time_limit, show_attempts)

    # did it reach the end? (_RELATIVE_ERROR_OF_PRINTED_TIME: 1e-5)
    attempts = attempts_in(status_file)
    accepted_attempts = [attempt for attempt in attempts if attempt.is_accepted]
    time_reached = max((attempt.time_reached for attempt in accepted_attempts), default=0.0)
    is_at_end = time_reached >= end_time * (1 - _RELATIVE_ERROR_OF_PRINTED_TIME)
    if is_late or process.returncode != 0 or not is_at_end:
        cause = f"ended with exit code {process.returncode}"
        if is_late:
            cause = f"was stopped at the time limit of {time_limit:g} s"
        raise ConvergenceError(
            f"CalculiX {cause} at time {time_reached:.6g} of {end_time:.6g}, in increment"
            f" {len(accepted_attempts) + 1} after {len(attempts)} attempts;"
            f" the last lines of its log: {_last_words_of(log_file)}"
        )
    return RunRecord(
        time.monotonic() - start_of_run,
        len(accepted_attempts),
        sum(attempt.n_iterations for attempt in attempts),
    )


def _wait_for_end(
    process: subprocess.Popen[bytes], deadline: float, show_attempts: Callable[[], None]
) -> bool:
    """Wait until a process ends, and call `show_attempts` four times a second meanwhile. At the
    `deadline`, a time of the monotonic clock [s], or on an exception the process is ended. Returns
    whether the deadline was reached.
    """
    is_late = False
    try:
        while process.poll() is None and not is_late:
            is_late = time.monotonic() > deadline
            show_attempts()
            time.sleep(0.0 if is_late else _SECONDS_BETWEEN_LOOKS)
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
    return is_late


def _show_time_reached(
    attempts: list[Attempt], end_time: float, show_progress: Callable[[int, int | None, str], None]
) -> None:
    """Report how far a run of CalculiX is: the time that its last attempt at an increment reached,
    in per cent of the deck's `end_time`, 100, and the number of the increment being solved as text.
    """
    time_fraction = attempts[-1].time_reached / end_time if attempts else 0.0
    percent = round(100 * min(time_fraction, 1.0))
    n_accepted = sum(attempt.is_accepted for attempt in attempts)
    show_progress(percent, 100, f"increment {n_accepted + 1}")


def _last_words_of(log_file: Path) -> str:
    """The last six lines with words of a log (`_N_SHOWN_LOG_LINES`), joined by bars; "nothing" for
    an empty one. Lines that only part others, of dashes or stars, are left out.
    """
    log_lines = [
        line.strip() for line in log_file.read_text(encoding="utf-8", errors="replace").splitlines()
    ]
    lines_with_words = [line for line in log_lines if not set(line) <= set("_-* ")]
    return " | ".join(lines_with_words[-_N_SHOWN_LOG_LINES:]) or "nothing"


@dataclass(frozen=True)
class Attempt:
    """A line of the status file: an attempt to solve an increment."""

    is_accepted: bool
    n_iterations: int
    time_reached: float  # time reached, or that of its start where it was not accepted


def attempts_in(status_file: Path) -> list[Attempt]:
    """The attempts to solve increments in CalculiX' status file (.sta) so far; a line that is
    half-written is left out.
    """
    text = status_file.read_text(encoding="utf-8", errors="replace") if status_file.exists() else ""
    # step, increment, attempt (with U where it was not accepted), iterations, time reached, ...
    line_matches = (
        re.match(r"\s*\d+\s+\d+\s+\d+(U?)\s+(\d+)\s+(\S+)\s+\S+\s+\S+\s*$", line)
        for line in text.splitlines()
    )
    return [
        Attempt(not match[1], int(match[2]), float(match[3])) for match in line_matches if match
    ]


def score_deck(path: Path, deck: Deck, code: str) -> Report:
    """The report on CalculiX' result of an input deck, the .frd file at `path`, compared with
    half-plane theory at the points and instants of the result. `code` is CalculiX with its version.

    CalculiX does not write the unloaded instant: it is put before the others, with all fields 0.
    `deck.time` (n + 1,) has the unloaded instant first.
    """
    # tractions, slip and loads of the result; the mapping states what the file does not
    mapping = Mapping(
        code=code, times=tuple(deck.time[1:].tolist()), element_size=deck.element_size
    )
    surface = read_result(path, mapping)

    # put the unloaded instant before them
    series_with_unloaded_instant: dict[str, Any] = {}
    for name in ("pressure", "shear", "slip", "normal_load", "tangential_load"):
        values = getattr(surface, name)
        if values is not None:
            series_with_unloaded_instant[name] = read_only_copy(
                np.concatenate([np.zeros_like(values[:1]), values])
            )
    source = f"{path.name}, the deck of scene {deck.scene.name}"
    surface = replace(
        surface, **series_with_unloaded_instant, time=read_only_copy(deck.time), source=source
    )

    # as a solution, with sentences on what was guessed, compared with theory
    theory_of_path = theory_of_whole_path(deck.scene)
    return score_solution(*solution_of_surface(surface, mapping, theory_of_path), theory_of_path)


def _limits_in_words(deck: Deck) -> list[str]:
    """Sentences on known limits of CalculiX' numbers for this input deck: from its documentation,
    from the deck, and measured (docs/third.md).

    Of the deck, `mean_pressure` is P/(2 a) at the largest load, a the half-width of contact.
    `stiffness` is the pressure per penetration, `stick_slope` the shear per elastic slip, with
    which CalculiX replaces rigid contact and stick.
    """
    friction_coefficient = deck.scene.friction.coefficient
    path = deck.scene.load.path()
    # over a, so that penetration and creep are in a
    mean_pressure_over_a = deck.mean_pressure / deck.scales.half_width
    load_of_cycle = deck.normal_load[deck.time >= path.cycle_start]
    has_friction_under_varying_load = (
        friction_coefficient
        and path.period is not None
        and np.ptp(load_of_cycle) > 1e-9 * load_of_cycle.max()
    )
    kinds = (deck.scene.bodies.lower.kind, deck.scene.bodies.upper.kind)
    # radius of the half-discs that stand for half-planes, over a; False without half-planes
    far_radius = "half_plane" in kinds and deck.settings.far_radius
    penetration = mean_pressure_over_a / deck.stiffness
    creep = friction_coefficient * mean_pressure_over_a / deck.stick_slope
    # a template of sentences, one a line
    limits_in_words = words_of("limits_of_calculix")(
        penetration, creep, has_friction_under_varying_load, far_radius
    )
    return [line.strip() for line in str(limits_in_words).split("\n") if line.strip()]


def _compared_values(scene: Scene) -> list[tuple[str, str, Callable[[ContactSolution], float]]]:
    """The values by which theory, finite elements and CalculiX are compared: for each its label,
    its unit, and a function that takes it from a solution. They are of the last cycle, or of the
    whole path where nothing repeats.
    """
    _, length_unit, stress_unit = units(scene)
    path_in_words = part_of_path(scene)  # such as "last cycle" or "whole path"
    largest_in_words = f"the largest of the {path_in_words}"

    def largest_pressure(solution: ContactSolution) -> float:
        return float(solution.pressure[solution.last_cycle].max())

    def largest_shear(solution: ContactSolution) -> float:
        return float(np.abs(solution.shear[solution.last_cycle]).max())

    def largest_half_width(solution: ContactSolution) -> float:
        return float(np.nanmax(solution.contact_half_width[solution.last_cycle]))

    return [
        (
            f"work of friction, {path_in_words}",
            energy_unit(scene),
            lambda solution: solution.dissipation,
        ),
        (f"pressure, {largest_in_words}", stress_unit, largest_pressure),
        (f"shear, {largest_in_words}", stress_unit, largest_shear),
        (f"contact half-width, {largest_in_words}", length_unit, largest_half_width),
    ]
