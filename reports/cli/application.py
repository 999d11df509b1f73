"""The command line `halfplane`: the tables of options and of commands, exit codes, sentences on
faults, streams and signals.

A command is a row of `_COMMANDS`, and a function in a module of its own that is imported by its
name when the command is called: so the command line reaches the studies without importing them.
"""

# Annotations are evaluated here: no `from __future__`.
import gc
import io
import json
import math
import os
import shlex
import signal
import sys
import textwrap
import time
import traceback
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from contextvars import Context
from dataclasses import dataclass, field, fields, replace
from importlib import import_module
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from cyclopts import (
    App,
    CycloptsError,
    Group,
    MissingArgumentError,
    Token,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)
from cyclopts import Parameter as CommandLineParameter

from reports.console import Console, Part, complain, say, show

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

# --------------------------------------------------------------------------------------- the tables
FORMAT = "halfplane answer 2"
TEMPLATES = Path(__file__).parents[1] / "templates"
"""Folder of the texts that commands and pages are made from."""

_MESH = Group(
    "Mesh (lengths over the contact half-width; what is left out is the engine's own)", sort_key=2
)
_SOLVER = Group("Solver (what is left out is the engine's own)", sort_key=3)


def _whole_number(_: type, tokens: Sequence[Token]) -> int:
    """The whole number in an option; ValueError for anything else, which the command-line library
    would round.
    """
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r} is no whole number") from None


# A number of things: nothing is rounded.
_Count = Annotated[int, CommandLineParameter(converter=_whole_number)]


def _option(words: str, *names: str) -> CommandLineParameter:
    """An option: its help text `words`, and its `names` where they are not that of its field."""
    return CommandLineParameter(*names, help=words)


def _flag(words: str) -> CommandLineParameter:
    """A switch that has no opposite."""
    return CommandLineParameter(negative="", help=words)


def _several(words: str) -> CommandLineParameter:
    """An option with one value or many: `--vtu 1 2`, or the option again."""
    return CommandLineParameter(consume_multiple=True, negative="", help=words)


def _mesh(words: str) -> CommandLineParameter:
    """An option of the group on the mesh, with its help text."""
    return CommandLineParameter(group=_MESH, help=words)


def _solver(words: str) -> CommandLineParameter:
    """An option of the group on the solver, with its help text."""
    return CommandLineParameter(group=_SOLVER, help=words)


@dataclass(frozen=True, kw_only=True)
class Options:
    """Every option; one that is left out, or that the command does not take, has its default, None
    being the engine's own.
    """

    out: Annotated[
        Path | None, _option("Folder for the results; out/<scene name> if left out.")
    ] = None
    json: Annotated[bool, _flag("As JSON on stdout, and nothing else there.")] = False
    quiet: Annotated[bool, _flag("No progress on stderr.")] = False
    verbose: Annotated[
        bool, _flag("Also where the difference comes from, expected numbers and times.")
    ] = False
    corrected: Annotated[
        bool,
        _flag(
            "Theory with what the finite bodies add: one linear solve a body, no contact solved."
        ),
    ] = False
    # finite elements
    preset: Annotated[
        Literal["default", "coarse", "fine"],
        _mesh("Mesh to start from: coarse for a first look, fine for a result to rely on."),
    ] = "default"
    element_size: Annotated[
        float | None, _mesh("Surface elements where the tractions are smooth.")
    ] = None
    edge_element_size: Annotated[
        float | None, _mesh("Surface elements where the contact and stick edges travel.")
    ] = None
    far_radius: Annotated[
        float | None, _mesh("Radius of the half-disc that stands for a half-plane.")
    ] = None
    growth: Annotated[float | None, _mesh("Growth of the elements away from the contact.")] = None
    order: Annotated[_Count | None, _mesh("Order of the elements, 1 or 2.")] = None
    method: Annotated[
        Literal["active_set", "augmented_lagrangian", "penalty"] | None,
        _solver(
            "Active set or augmented Lagrangian: the contact law met exactly. Penalty: an elastic"
            " layer between the faces."
        ),
    ] = None
    steps_per_cycle: Annotated[
        _Count | None, _solver("Steps of a revolution; turning points come on top.")
    ] = None
    step_tolerance: Annotated[
        float | None, _solver("Error of a revolution's steps over W above which steps are halved.")
    ] = None
    max_iterations: Annotated[
        _Count | None, _solver("Of one step, before it counts as not converged.")
    ] = None
    # run, score, diff
    tolerance: Annotated[
        tuple[str, ...],
        _several(
            "5%: of dissipation, peak pressure and both half-widths; KEY=VALUE: of one metric."
        ),
    ] = ()
    budget: Annotated[
        bool | None,
        _option("Measure where the difference comes from: coarser meshes, other far fields."),
    ] = None
    vtu: Annotated[
        tuple[str, ...], _several('Write both bodies for ParaView at these times, or at "events".')
    ] = ()
    stress: Annotated[
        tuple[str, ...],
        _several('Show von Mises stress on the page at these times, or at "events".'),
    ] = ()
    third: Annotated[
        Literal["calculix"] | None, _option("A third solver: runs `ccx` on the exported deck.")
    ] = None
    picture: Annotated[
        Path | None,
        _option("Of a fitted profile: trace, fit and residuals, as a new file ending in .svg."),
    ] = None
    loop: Annotated[
        Path | None,
        _option("A rig's loop to score against this scene: how each of its columns is read."),
    ] = None
    scene: Annotated[
        str | None, _option("The scene that it answers: a library name, or a .toml or .json file.")
    ] = None
    as_: Annotated[
        Literal["tractions", "loop"],
        _option(
            "What the file holds: tractions, or a rig's loop of tangential load over displacement.",
            "--as",
        ),
    ] = "tractions"
    rig_compliance: Annotated[
        float | None,
        _option(
            "Of a loop: displacement of the rig per tangential load, 1/stress; fitted if left out."
        ),
    ] = None
    mapping: Annotated[
        Path | None, _option("TOML file: names of columns, units, signs. Usual ones need none.")
    ] = None
    against: Annotated[
        Literal["exact", "fe"], _option("Half-plane theory, or the project's own finite elements.")
    ] = "exact"
    mapping_example: Annotated[bool, _flag("Print a commented mapping file and stop.")] = False
    accept: Annotated[
        bool, _flag("Make B a baseline of A; the tolerances given are kept in it.")
    ] = False
    limit: Annotated[
        str, _option("Error of dissipation up to which half-plane theory may be used: 5% or 0.05.")
    ] = "5%"
    # fields, export
    at: Annotated[
        tuple[str, ...],
        _several('Times of the path, or "events" of the last cycle, the default without a series.'),
    ] = ()
    every: Annotated[
        _Count | None, _option("A series over the last cycle: every Nth stored step.")
    ] = None
    frames: Annotated[
        _Count | None, _option("A series over the last cycle: N instants evenly in time.")
    ] = None
    pictures: Annotated[
        bool, _option("Draw the meshes and the von Mises stress at the instants of --at as SVG.")
    ] = True
    fatigue: Annotated[
        bool,
        _flag(
            "Stress through the last cycle by both engines: ranges, Smith-Watson-Topper, Crossland;"
            " fields/fatigue.csv."
        ),
    ] = False
    fatemi_socie: Annotated[
        tuple[float, float] | None, _option("k and yield stress: Fatemi and Socie's measure too.")
    ] = None
    findley: Annotated[float | None, _option("k: Findley too.")] = None
    critical_distance: Annotated[
        float | None, _option("Depth over which the stress is averaged for --fatigue.")
    ] = None
    cycles: Annotated[_Count | None, _option("Revolutions at most.")] = None
    # sweep
    executor: Annotated[
        Literal["processes", "dask"], _option("Processes of this machine, or a dask cluster.")
    ] = "processes"
    scheduler: Annotated[
        str,
        _option("Address of your dask scheduler; without one a cluster starts on this machine."),
    ] = ""
    workers: Annotated[
        _Count | None, _option("Processes, or tasks at once; all cores if left out.")
    ] = None
    resume: Annotated[
        bool, _flag("What every run does: the results that the folder holds are used.")
    ] = False
    # map
    remake: Annotated[bool, _flag("Start afresh: drop the tables first.")] = False
    pages: Annotated[bool, _flag("Figures and pages alone, from the tables that are there.")] = (
        False
    )
    # init, scenes, schema
    library_scene: Annotated[
        str,
        _option(
            "Copy this library scene, with the files it reads, instead of the commented example.",
            "--from",
        ),
    ] = ""
    bodies: Annotated[
        bool, _flag("The example with a block and a pad in place of half-planes.")
    ] = False
    profile: Annotated[
        Literal["hertz", "flat_rounded"],
        _option("Profile of the example: a parabola, or flat with rounded edges."),
    ] = "hertz"
    tag: Annotated[
        tuple[str, ...],
        _option("Only scenes that have this tag; again for scenes that have all of them."),
    ] = ()

    def values_given(self, names: Iterable[str]) -> dict[str, Any]:
        """Name -> value of the options `names` that are not None."""
        values = {name: getattr(self, name) for name in names}
        return {name: value for name, value in values.items() if value is not None}

    def command(self, name: str, operand: str, out: Path) -> str:
        """The command line that repeats this run: command `name`, its operand, the options that
        differ from their defaults, and the folder `out`. --json, --quiet and --verbose are left
        out, for they change no result. The operand is a scene or a file; "" where there is none.

        >>> Options(order=1, quiet=True).command("run", "hertz-paper", Path("out/first"))
        'halfplane run hertz-paper --order 1 --out out/first'
        """
        command_words = ["halfplane", name]
        if operand:
            command_words.append(operand)
        for option in fields(self):  # in the order of their declaration
            value = getattr(self, option.name)
            if value == option.default or option.name in ("out", "json", "quiet", "verbose"):
                continue
            # as_ is written --as, and element_size --element-size
            option_word = option.name.strip("_").replace("_", "-")
            if isinstance(value, bool):
                command_words.append(f"--{option_word}" if value else f"--no-{option_word}")
            else:
                values = value if isinstance(value, tuple) else (value,)
                command_words += [f"--{option_word}", *map(str, values)]
        return shlex.join([*command_words, "--out", str(out)])

    def settings(self) -> "tuple[MeshSettings, SolverSettings]":
        """Settings of mesh and solver: the options that were given, and the defaults of the preset
        and of the solver for all others. InputError for a value out of range. The preset is a mesh
        by name: default, coarse or fine.

        >>> mesh, _ = Options(preset="coarse", growth=0.2).settings()
        >>> mesh.edge_element_size, mesh.growth
        (0.03125, 0.2)
        """
        from halfplane_fe import SolverSettings
        from meshes import MeshSettings

        # names of the options that are settings of the mesh, and of the solver
        mesh_options = _FINITE_ELEMENT_OPTIONS & MeshSettings.__dataclass_fields__.keys()
        solver_options = _FINITE_ELEMENT_OPTIONS & SolverSettings.__dataclass_fields__.keys()
        mesh = replace(MeshSettings.preset(self.preset), **self.values_given(mesh_options))
        return mesh, SolverSettings(**self.values_given(solver_options))


_NAMES = [option.name for option in fields(Options)]
_OUTPUT = ("out", "json", "quiet")
# Sets of names, in their order above.
_FINITE_ELEMENT_OPTIONS = dict.fromkeys(
    _NAMES[_NAMES.index("preset") : _NAMES.index("max_iterations") + 1]
).keys()
WORKERS = ("executor", "scheduler", "workers")


class _Operand(NamedTuple):
    """A positional argument of a command, such as the scene that it solves."""

    name: str
    type: Any
    help: str
    default: Any = ...  # ...: it must be given
    positional_only: bool = False  # True: it can't be written as an option (--name VALUE)


@dataclass(frozen=True)
class _Command:
    """A row of the table of commands."""

    # group, name, help: in the list of commands
    group: str
    name: str
    help: str
    # the function that does its work, as "module:function" with the module below `reports`; its
    # arguments are the operands, then `Options`
    function: str
    # operands, options: what it takes; an option with "!" must be given
    operands: tuple[_Operand, ...]
    options: tuple[str, ...]
    # help texts of options that mean something else here than in `Options`
    help_of_option: Mapping[str, str] = field(default_factory=dict)
    quiet_hides_answer: bool = False  # True: --quiet prints nothing; else it hides progress alone


_SCENE_NAME = _Operand("scene", str, "Name of a library scene, or a .toml or .json file.")
_FOLDER = _Operand("folder", Path, "Folder of a sweep.", positional_only=True)
_SILENT = {"quiet": "Print nothing: the exit code is the answer."}
# The list of commands by use, and within a group in this order.
_COMMANDS = (
    _Command(
        "Solve",
        "run",
        "Both engines on one scene: verdict, page and data.",
        "cli.solving:run",
        (_SCENE_NAME,),
        (
            *_OUTPUT,
            "verbose",
            "tolerance",
            "budget",
            "vtu",
            "stress",
            "third",
            *_FINITE_ELEMENT_OPTIONS,
        ),
    ),
    _Command(
        "Solve",
        "exact",
        "Half-plane theory alone: summary, NetCDF and CSV, no page.",
        "cli.solving:exact",
        (_SCENE_NAME,),
        (*_OUTPUT, "corrected"),
    ),
    _Command(
        "Solve",
        "fe",
        "Finite elements alone: summary, NetCDF and CSV, no page.",
        "cli.solving:fe",
        (_SCENE_NAME,),
        (*_OUTPUT, *_FINITE_ELEMENT_OPTIONS),
    ),
    _Command(
        "Solve",
        "fields",
        "Displacement, stress and tractions in both bodies: files for ParaView, pictures.",
        "cli.field_output:fields",
        (_SCENE_NAME,),
        (
            *_OUTPUT,
            "at",
            "every",
            "frames",
            "pictures",
            "fatigue",
            "fatemi_socie",
            "findley",
            "critical_distance",
            *_FINITE_ELEMENT_OPTIONS,
        ),
    ),
    _Command(
        "Solve",
        "sweep",
        "Run a study: a scene over axes of its keys, into a store; a later run resumes it.",
        "studies.sweep.commands:sweep",
        (_Operand("study", str, "A study file, .toml or .json; see docs/sweeps.md."),),
        (*_OUTPUT, *WORKERS, "resume"),
        {"out": "Folder of the store; out/<study file> if left out."},
    ),
    _Command(
        "Solve",
        "sweep status",
        "How far a sweep is: done, failed, running, time left.",
        "studies.sweep.commands:status",
        (_FOLDER,),
        ("json",),
    ),
    _Command(
        "Solve",
        "sweep report",
        "The page of a sweep: its table and a figure of each quantity, also while it runs.",
        "studies.sweep.commands:report",
        (_FOLDER,),
        ("json",),
    ),
    _Command(
        "Solve",
        "export",
        "The bodies and the load history as an input deck for CalculiX.",
        "studies.third.commands:export",
        (_SCENE_NAME,),
        (*_OUTPUT, "steps_per_cycle", "cycles"),
        {"steps_per_cycle": "Instants of a revolution; turning points come on top."},
    ),
    _Command(
        "Judge",
        "score",
        "Compare an external result with the reference: verdict, likely causes, page.",
        "cli.results:score",
        (
            _Operand(
                "result",
                str | None,
                "An external result: a table (.csv, .txt, .rpt), fields, a solution (.nc); or a"
                " folder of meshes.",
                None,
            ),
        ),
        (
            *_OUTPUT,
            "scene",
            "as_",
            "rig_compliance",
            "mapping",
            "against",
            "tolerance",
            "mapping_example",
        ),
        {"out": "Folder for the results; out/score-<result> if left out."},
    ),
    _Command(
        "Judge",
        "diff",
        "Two runs, or a run and a baseline, value by value: 0 the same within tolerance, 1 not.",
        "cli.results:diff",
        (
            _Operand(
                "a", str, "Folder of a run, its comparison.json, a solution (.nc), or a baseline."
            ),
            _Operand("b", str, "The same; with --accept the baseline to write."),
        ),
        ("tolerance", "accept", "json", "quiet"),
        {"tolerance": 'KEY=VALUE of one value, or of many: "metric.*=1e-4".', **_SILENT},
        quiet_hides_answer=True,
    ),
    _Command(
        "Judge",
        "advise",
        "How wrong is half-plane theory for these bodies, and why? By their numbers or kernels;"
        " exit code 1: more than the limit, or not known.",
        "studies.maps.commands:advise",
        (_SCENE_NAME,),
        ("limit", "json"),
    ),
    _Command(
        "Judge",
        "map",
        "From which height on does theory hold for this kind of body? Table and page.",
        "studies.maps.commands:make_map",
        (_Operand("name", str, "Kind of body (docs/maps.md), or all."),),
        (*_OUTPUT, "remake", "pages"),
        {"out": "Folder of tables and pages; out/maps if left out."},
    ),
    _Command(
        "Judge",
        "paper",
        "The paper again from half-plane theory: its figures, statements and misprints.",
        "studies.paper.commands:paper",
        (),
        _OUTPUT,
        {"out": "Folder for the results; out/paper if left out."},
    ),
    _Command(
        "Scenes",
        "init",
        "Write a commented scene to start from, never over a file that exists.",
        "cli.scene_files:init",
        (_Operand("file", Path, "New file, ending in .toml."),),
        ("library_scene", "bodies", "profile", "quiet"),
        {"quiet": "Print nothing."},
        quiet_hides_answer=True,
    ),
    _Command(
        "Scenes",
        "check",
        "Validate a scene; print a, p0 and the margin to gross sliding.",
        "cli.scene_files:check",
        (_SCENE_NAME,),
        ("json", "quiet", "loop", "mapping", "picture"),
        _SILENT,
        quiet_hides_answer=True,
    ),
    _Command(
        "Scenes",
        "scenes",
        "The library of scenes, or all about one scene.",
        "cli.scene_files:show",
        (
            _Operand(
                "name",
                str,
                "Show this scene in detail: a name of the library, or a .toml or .json file.",
                "",
                positional_only=True,
            ),
        ),
        ("tag", "json"),
    ),
    _Command(
        "Scenes",
        "schema",
        "The JSON schema of a scene file, for editors.",
        "cli.scene_files:schema",
        (),
        (),
    ),
    _Command(
        "Machine",
        "doctor",
        "Can this machine do the work?",
        "cli.machine:doctor",
        (),
        _OUTPUT,
        {"out": "Folder whose disk and rights are checked; out if left out.", **_SILENT},
        quiet_hides_answer=True,
    ),
)


@dataclass(frozen=True)
class Answer:
    """What a command answers."""

    code: int  # exit code
    parts: Iterable[Part] = ()  # lines and tables for the terminal, made when they are printed
    # what --json prints as "result", not finite numbers among it, made when it is printed; None:
    # there is no JSON of it
    content: Callable[[], Mapping[str, Any]] | None = None
    scene: str | None = None  # name of the scene; None where a command is about none
    command: str = ""  # whose answer it is, where not that of the command given


# What a tolerance without a key is for: W, p0, a and c.
_MAIN_METRICS = ("dissipation", "largest_pressure", "largest_half_width", "permanent_stick")


def share_of(text: str) -> float:
    """The share that a user writes as 5% or 0.05; NaN where it is no number."""
    try:
        return float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return math.nan


def requested_tolerances(option_texts: Sequence[str]) -> dict[str, float]:
    """Metric key -> relative tolerance (0.05 for 5 %), from the texts after `--tolerance`.

    `5%` sets the tolerance of the four main metrics together: dissipation, peak pressure,
    half-width of the contact, half-width of the permanent stick zone. `KEY=VALUE` sets that of one
    metric, KEY being one of the table `METRICS`; the last text for a key counts. `KEY=none` makes
    it infinite: the metric is not judged.

    Raises
    ------
    InputError
        For an unknown key, for a value that is not a number above 0, and for a value of 1 or more
        without the sign %: 5 may be meant as 5 %.

    Examples
    --------
    >>> requested_tolerances(["5%", "dissipation=0.03"])
    {'dissipation': 0.03, 'largest_pressure': 0.05, 'largest_half_width': 0.05, 'permanent_stick':
    0.05}
    """
    if not option_texts:
        return {}
    from reports.comparison.metrics import METRICS
    from scenes import InputError
    from scenes.frozen import did_you_mean

    tolerances: dict[str, float] = {}
    for option_text in option_texts:
        key, equals_sign, tolerance_text = option_text.rpartition("=")
        if equals_sign and key not in METRICS:
            known_names = list(METRICS)
            raise InputError(
                f"--tolerance {option_text}: unknown metric"
                f" {key!r};{did_you_mean(key, known_names)}"
                f" there are {', '.join(known_names)}"
            )
        is_unjudged = bool(equals_sign) and tolerance_text.strip() == "none"
        # 0.05 for "5%" and "0.05"; NaN where it is no number
        tolerance = math.inf if is_unjudged else share_of(tolerance_text)
        if not is_unjudged and not 0 < tolerance < math.inf:
            raise InputError(
                f"--tolerance {option_text}: write a share above 0, such as 5% or 0.05, or one of a"
                " metric: dissipation=3%; dissipation=none leaves it unjudged"
            )
        if not is_unjudged and tolerance >= 1 and not tolerance_text.endswith("%"):
            beginning = f"{key}{equals_sign}"  # "" or "KEY="
            alternatives = f"{beginning}{tolerance:g}%, or {beginning}{100 * tolerance:g}%"
            raise InputError(
                f"--tolerance {option_text}: a number without % is a share, and this is"
                f" {100 * tolerance:g} %; write {alternatives}"
            )
        # _MAIN_METRICS: keys of the four main metrics
        keys = [key] if equals_sign else _MAIN_METRICS
        tolerances |= dict.fromkeys(keys, tolerance)
    return tolerances


# --------------------------------------------------------------------- streams, signals, exit codes
# 0: within tolerance, or nothing to judge; 1: outside or undecided; 70: a fault of the program
# itself. As shells count: 130 is 128 + SIGINT, 141 (nobody reads the output) 128 + SIGPIPE.
EXIT_WITHIN = 0
EXIT_OUTSIDE = 1
_EXIT_BAD_INPUT = 2
EXIT_NOT_CONVERGED = 3
_EXIT_PROGRAM_FAULT = 70
EXIT_INTERRUPTED = 130
_READER_GONE = 141


@contextmanager
def ended_by_signals() -> Generator[list[int], None, None]:
    """Within this context SIGTERM and SIGHUP end the program as Ctrl-C does. Yields the list of
    signals received, in their order. A signal that was to be ignored (nohup) stays ignored.
    """
    signals_received: list[int] = []  # by their numbers

    def end_program(signal_number: int, _frame: object) -> None:
        """Append the number of a signal to the list, and raise KeyboardInterrupt."""
        signals_received.append(signal_number)
        raise KeyboardInterrupt

    signal_names = ("SIGINT", "SIGTERM", "SIGHUP")  # not every system has SIGHUP
    signal_numbers = [getattr(signal, name) for name in signal_names if hasattr(signal, name)]
    for signal_number in signal_numbers:
        if signal.getsignal(signal_number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(signal_number, end_program)
    try:
        yield signals_received
    finally:
        for signal_number in signal_numbers:
            if signal.getsignal(signal_number) is end_program:
                signal.signal(signal_number, signal.SIG_DFL)  # nothing is left to keep


# ---------------------------------------------------------------------------------- the application
def _version() -> str:
    """The installed version of this program."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("halfplane")
    except PackageNotFoundError:
        return "not installed: run from a checkout"


_GROUP_NAMES = dict.fromkeys(row.group for row in _COMMANDS)
_GROUPS = {name: Group(name, sort_key=place) for place, name in enumerate(_GROUP_NAMES)}
app = App(
    name="halfplane",
    help="How wrong is the half-plane idealisation? One scene, two engines, one report.",
    help_epilogue=(TEMPLATES / "help.txt").read_text("utf-8"),
    help_format="plaintext",
    default_parameter=CommandLineParameter(negative_iterable=()),  # no --empty-tag
    version=_version,
    suppress_keyboard_interrupt=False,
    exit_on_error=False,
    print_error=False,
    result_action="return_value",
    group_commands=_GROUPS["Machine"],
    console=Console(),
)


def _function_of(command_row: _Command) -> Callable[..., int]:
    """The function that the command-line library calls for one command, made from its row in the
    table of commands. Its signature is what the library reads: operands (positional arguments, such
    as the scene), then options as keywords, with the help texts as annotations. The function does
    the command's work, prints the answer and returns the exit code.

    A row names, among others, the function that does the work, as "module:function".
    """
    signature = Signature(
        [*_parameters_of_operands(command_row), *_parameters_of_options(command_row)]
    )

    def command(*operands: Any, **options: Any) -> int:
        """Do the work of the command, print its answer, and return the exit code."""
        bound_arguments = signature.bind(*operands, **options)
        bound_arguments.apply_defaults()
        values = dict(bound_arguments.arguments)
        operand_values = [values.pop(operand.name) for operand in command_row.operands]
        option_values = Options(**values)
        module, _, function_name = command_row.function.partition(":")
        do_command = getattr(import_module(f"reports.{module}"), function_name)
        answer = do_command(*operand_values, option_values)
        return _print_answer(command_row, answer, option_values)

    command.__signature__ = signature  # type: ignore[attr-defined]
    return command


def _parameters_of_operands(command_row: _Command) -> Iterator[Parameter]:
    """Parameters for the operands of a command (positional arguments, such as the scene): name,
    type with help text, and default; an operand whose default is `...` must be given.
    """
    for operand in command_row.operands:
        kind: Any = Parameter.POSITIONAL_OR_KEYWORD
        if operand.positional_only:
            kind = Parameter.POSITIONAL_ONLY
        default = Parameter.empty if operand.default is ... else operand.default
        annotation: Any = Annotated[operand.type, CommandLineParameter(help=operand.help)]
        yield Parameter(operand.name, kind, default=default, annotation=annotation)


def _parameters_of_options(command_row: _Command) -> Iterator[Parameter]:
    """Keyword parameters for the options of a command, from the fields of `Options`: name, type
    with help text, and default. In `command_row.options` a "!" behind a name marks an option that
    must be given; `help_of_option` has the help texts that differ from the usual ones.
    """
    option_by_name = {option.name: option for option in fields(Options)}
    for option_name in command_row.options:
        option = option_by_name[option_name.rstrip("!")]
        default = Parameter.empty if option_name.endswith("!") else option.default
        annotation: Any = option.type
        if option.name in command_row.help_of_option:
            help_text = command_row.help_of_option[option.name]
            parameter_with_help = CommandLineParameter(help=help_text, group="Parameters")
            annotation = Annotated[option.type, parameter_with_help]
        yield Parameter(option.name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)


def _print_answer(command_row: _Command, answer: Answer, options: Options) -> int:
    """Print the answer of a command and return its exit code. It prints lines and tables, or with
    --json one JSON object on stdout, in which numbers that are not finite are null. No other
    function prints answers.

    `command_row` is the row of the command in the table of commands. An answer has the exit code,
    the lines and tables (`parts`), and a function that makes the content for --json, or None.
    """
    if options.json and answer.content is not None:
        from reports.comparison.json_values import strict_json_values

        # FORMAT: name and version of the form of answers, "halfplane answer 2"
        content = {
            "format": FORMAT,
            "command": answer.command or command_row.name,
            "exit_code": answer.code,
            "scene": answer.scene,
            "result": answer.content(),
        }
        say(json.dumps(strict_json_values(content), allow_nan=False, indent=1))
    elif not (options.quiet and command_row.quiet_hides_answer):
        show(answer.parts)
    return answer.code


for _order, _row in enumerate(_COMMANDS):
    _above, _, _name = _row.name.rpartition(" ")
    _place: dict[str, Any] = {
        "help": _row.help,
        "group": _GROUPS[_row.group],
        "sort_key": _order,
        "help_epilogue": "",
    }
    if _above:
        app[_above].command(_function_of(_row), name=_name, help=_row.help, help_epilogue="")
    elif any(row.name.startswith(f"{_name} ") for row in _COMMANDS):  # with commands of its own
        _group = Group(f"Of a {_name} that is there")
        _commands = App(name=_name, group_commands=_group, **_place)
        app.command(_commands)
        _commands.default(_function_of(_row))
    else:
        app.command(_function_of(_row), name=_name, **_place)


# New objects after which the collector looks for garbage, more than the 150,000 of all modules. At
# its usual 700 it goes through them again and again, a twentieth of a run, which leaves little
# garbage.
_NEW_OBJECTS = 200_000


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code. `arguments` are the words after `halfplane`.
    Without them those of the process are taken, and its streams and signals are handled too.

    The exit code is 141 where nobody reads the output. After a signal it is 128 plus the number of
    that signal.
    """
    if arguments is not None:
        return Context().run(_run, list(arguments))
    # the collector of garbage runs after 200,000 new objects, not 700
    gc.set_threshold(_NEW_OBJECTS, *gc.get_threshold()[1:])
    # No plugin of pydantic has a use here: to look for them reads the files of all packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # signs that the terminal's encoding lacks are printed as escapes
            stream.reconfigure(errors="backslashreplace")
    with ended_by_signals() as signals_received:
        code = EXIT_WITHIN
        try:
            code = Context().run(_run, sys.argv[1:], signals_received)
            sys.stdout.flush()
        except BrokenPipeError:
            _drop_unwritten()
            # _READER_GONE: exit code 141
            return _READER_GONE
        except OSError as reason:
            _drop_unwritten()
            if code == EXIT_WITHIN:  # nothing has been reported yet
                code = _print_refusal(
                    f"the answer could not be written to stdout: {reason.strerror}; see to that and"
                    " ask again"
                )
        except KeyboardInterrupt:  # a second Ctrl-C, while the first was reported
            code = EXIT_INTERRUPTED
        finally:
            gc.freeze()  # the process ends here: looking for garbage once more is left out
        if code == EXIT_INTERRUPTED and signals_received:
            return 128 + signals_received[0]  # the convention of shells
        return code


def _drop_unwritten() -> None:
    """Send what could not be written to stdout nowhere: the end of the process would try it
    again.
    """
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run(tokens: list[str], signals_received: Sequence[int] = ()) -> int:
    """Run the command line `tokens` and return its exit code. What is refused or goes wrong is
    printed as one sentence on stderr. `signals_received` is filled when a signal comes, with its
    number.
    """
    try:
        if any(token == "" or (token.startswith("--") and token.endswith("=")) for token in tokens):
            return _print_refusal(
                "one of the arguments is empty: is a variable of the shell not set? Give a value,"
                " or leave it out"
            )
        with _warnings_in_sentences():
            return int(app(tokens) or EXIT_WITHIN)
    except KeyboardInterrupt as stop:
        return _print_interruption(str(stop))
    except BrokenPipeError:
        raise
    # The outermost door: nothing may leave it but an exit code.
    except Exception as fault:  # noqa: BLE001
        return _report_fault(fault, tokens, signals_received)


@contextmanager
def _warnings_in_sentences() -> Generator[None, None, None]:
    """Within this context each warning of a library is printed once, as one line on stderr without
    the path and the line of its source.
    """
    sentences_printed: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *_place: Any, **_names: Any) -> None:
        """Print a warning, unless the same sentence was printed before; `warnings` calls it."""
        sentence = f"halfplane: warning: {_one_line(str(message))} ({category.__name__})"
        if sentence not in sentences_printed:
            sentences_printed.add(sentence)
            complain(sentence)  # on stderr

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _report_fault(fault: Exception, tokens: list[str], signals_received: Sequence[int]) -> int:
    """Print the exception `fault` of the command line `tokens` as one sentence on stderr, and
    return the exit code for it: 2 for bad input, 3 without convergence, 130 after an interruption,
    70 for a fault of the program itself. `signals_received` holds the signals until now.

    Notes of the fault, on what was saved before it, end the sentence.
    """
    # scenes is heavy: it is imported when it must have been imported already, never for --help.
    if isinstance(fault, ValueError | RuntimeError):
        from scenes import ConvergenceError, InputError

        if isinstance(fault, InputError):
            return _print_refusal(f"{_one_line(str(fault))}{_notes_of(fault)}")
        if isinstance(fault, ConvergenceError):
            _print_refusal(f"not converged: {_one_line(str(fault))}")
            return EXIT_NOT_CONVERGED
    if isinstance(fault, CycloptsError):
        return _print_refusal(_sentence_on_command_line(fault))
    if isinstance(fault, MemoryError):
        cause = f" ({_one_line(str(fault))})" if str(fault) else ""
        cure = "ask for a coarser mesh, fewer steps or fewer instants"
        return _print_refusal(
            f"there is not enough memory for this{cause}; {cure}{_notes_of(fault)}"
        )
    if isinstance(fault, OSError):  # that no door has words for
        place = "a file: "
        if isinstance(fault.filename, str | bytes):
            place = f"{_one_line(os.fsdecode(fault.filename))}: "
        return _print_refusal(
            f"cannot read or write {place}{fault.strerror or _one_line(str(fault))}; mend that and"
            f" run the command again{_notes_of(fault)}"
        )
    # Compiled modules and locks make another error of Ctrl-C.
    return _print_interruption("") if signals_received else _print_program_fault(fault, tokens)


def _print_interruption(sentence: str) -> int:
    """Print on stderr that the command was interrupted, and what is left of it (`sentence`; ""
    where nothing was written). Returns the exit code, 130.
    """
    _print_refusal(f"interrupted; {sentence or 'nothing was written'}")
    return EXIT_INTERRUPTED


def _print_program_fault(fault: Exception, tokens: Sequence[str]) -> int:
    """Print an exception that is a fault of the program itself: one sentence on stderr, which says
    where its traceback was written: run.log of the output folder, or a temporary file. `tokens` are
    the words of the command line. Returns the exit code, 70.
    """
    command_line = shlex.join(["halfplane", *tokens])
    log_lines = [
        time.strftime("%Y-%m-%d %H:%M:%S %z  ") + command_line,
        *traceback.format_exception(fault),
    ]
    place_in_words = _keep_traceback(
        "\n".join(log_line.rstrip("\n") for log_line in log_lines) + "\n"
    )
    message = textwrap.shorten(str(fault), 200, placeholder=" ...").rstrip(".")
    error = type(fault).__name__
    if message:
        error += f": {message}"
    _print_refusal(
        f"internal error, a fault of halfplane: {error}{_notes_of(fault)}; the traceback is"
        f" {place_in_words}: please report it"
    )
    return _EXIT_PROGRAM_FAULT


def _notes_of(fault: Exception) -> str:
    """The notes of a fault, on what was saved before it, to end a sentence with; empty without
    any.
    """
    return "".join(f"; {_one_line(note)}" for note in getattr(fault, "__notes__", ()))


def _keep_traceback(text: str) -> str:
    """Write a traceback to run.log of the output folder; where that fails, to a file in the
    temporary folder; where that fails too, to stderr. Returns where it is, for a sentence: "in
    out/run.log", or "above" on stderr.
    """
    with suppress(Exception):  # where the folder can't take it, the next place does
        from reports.folder import add_to_log, output_folder

        if (folder := output_folder.get()) is not None:
            return f"in {add_to_log(folder, text)}"
    import tempfile

    try:
        handle, name = tempfile.mkstemp(prefix="halfplane-", suffix=".log")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
        return f"in {name}"
    except OSError:
        complain(text)
        return "above"


def _print_refusal(sentence: str) -> int:
    """Print a sentence on bad input on stderr, after the name of the program. Returns the exit
    code, 2.
    """
    complain(f"halfplane: {sentence}")
    return _EXIT_BAD_INPUT


def _one_line(text: str) -> str:
    """A text in one line, with single blanks and without a full stop at its end."""
    return " ".join(text.split()).rstrip(".")


def _sentence_on_command_line(fault: CycloptsError) -> str:
    """One sentence on what is wrong with a command line that can't be read: the unknown word, the
    nearest known word, and which help lists them. `fault` is the exception of the command-line
    library: its tokens are the words of the command line, its command chain the command with its
    subcommands.
    """
    if isinstance(fault, UnknownCommandError):
        return _sentence_on_unknown_command(fault)
    chain = list(fault.command_chain or ())
    command = " ".join(chain) or "halfplane"
    help_of_command = f"`{' '.join(['halfplane', *chain])} --help`"
    if isinstance(fault, UnknownOptionError):
        unknown_word, suggestion = _unknown_option_and_suggestion(fault)
        return f"{command} has no option {unknown_word}; {suggestion}{help_of_command} lists them"
    if isinstance(fault, UnusedCliTokensError):
        words_left_over = " ".join(fault.unused_tokens or [])
        suggestion = _suggestion_for_unused_words(fault, chain)
        return (
            f"{command}: unexpected argument {words_left_over!r}; {suggestion}{help_of_command}"
            " shows what it takes"
        )
    if (
        isinstance(fault, MissingArgumentError)
        and fault.argument is not None
        and not fault.argument.tokens
    ):
        # An operand in capitals, as in the help; an option (keyword only) as it is written.
        field_info = fault.argument.field_info
        name = fault.argument.name
        if field_info.kind is not field_info.KEYWORD_ONLY:
            name = name.removeprefix("--").upper()
        return f"{command}: {name} is missing; {help_of_command} shows what it takes"
    return f"{' '.join(str(fault).split()).rstrip('.')}; {help_of_command} shows what it takes"


def _sentence_on_unknown_command(fault: UnknownCommandError) -> str:
    """A sentence that the first word of a command line is no command or no option of the whole
    program, with the nearest known word. `app` holds all commands and such options by name.
    """
    unknown_word = next(iter(fault.unused_tokens or [""]))
    is_option = unknown_word.startswith("-")
    kind = "option" if is_option else "command"
    known_words = [word for word in app if word.startswith("-") is is_option]
    suggestion = _nearest_word(unknown_word, known_words)
    return f"there is no {kind} {unknown_word!r}; {suggestion}`halfplane --help` lists them"


def _unknown_option_and_suggestion(fault: UnknownOptionError) -> tuple[str, str]:
    """The option of a command line that its command does not have, and a suggestion for the error
    message, "did you mean ...? " with a blank at its end; "" where no option of the command is
    near.

    `fault` is the exception of the command-line library, with the option and those that the command
    has.
    """
    unknown_word = (fault.token.keyword or fault.token.value).split("=", 1)[0]
    known_options = {
        name
        for argument in fault.argument_collection
        for name in argument.names
        if name.startswith("--")
    }
    return unknown_word, _nearest_word(unknown_word, known_options)


def _suggestion_for_unused_words(fault: UnusedCliTokensError, chain: Sequence[str]) -> str:
    """A suggestion for an error message on words that a command does not take, ending in a blank:
    "did you mean ...? ", or the command line to write. "" where no known word is near.

    `chain` is the command with the names of its subcommands. The command `sweep` takes a misspelt
    subcommand for the name of a study, so that the words behind it are what is left over. `fault`
    holds the words of the whole command line, those left over, and the commands (`app`).
    """
    tokens_of_command = (fault.root_input_tokens or [])[len(chain) :]
    if not tokens_of_command:
        return ""
    first_token = tokens_of_command[0]
    commands = [name for name in fault.app or () if not name.startswith("-")]
    if suggestion := _nearest_word(first_token, commands):
        return suggestion
    words_left_over = " ".join(fault.unused_tokens or [])
    scene_endings = (".toml", ".json")
    if words_left_over.endswith(scene_endings) and not first_token.endswith(scene_endings):
        command = " ".join(chain) or "halfplane"
        return f"write `halfplane {command} {words_left_over}`; "
    return ""


def _nearest_word(word: str, known_words: Iterable[str]) -> str:
    """The question "did you mean ...?" with the known word nearest to a misspelt one, and a blank
    behind it; "" where none is near.
    """
    from scenes.frozen import did_you_mean

    return f"{did_you_mean(word.lower(), known_words).strip()} ".lstrip()
