"""The command line `halfplane`: the tables of options and of commands, exit codes, what is said of
a fault, streams and signals.

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
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
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
from cyclopts import Parameter as Words

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
        # what reads options would round it
        raise ValueError(f"{tokens[0].value!r} is no whole number") from None


# A number of things: nothing is rounded.
_Count = Annotated[int, Words(converter=_whole_number)]


def _option(words: str, *names: str) -> Words:
    """An option with its words; with names other than that of its field."""
    return Words(*names, help=words)


def _flag(words: str) -> Words:
    """A switch that has no opposite."""
    return Words(negative="", help=words)


def _several(words: str) -> Words:
    """An option with one value or many: `--vtu 1 2`, or the option again."""
    return Words(consume_multiple=True, negative="", help=words)


def _mesh(words: str) -> Words:
    return Words(group=_MESH, help=words)


def _solver(words: str) -> Words:
    return Words(group=_SOLVER, help=words)


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
    start: Annotated[
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

    def stated(self, names: Iterable[str]) -> dict[str, Any]:
        """Name -> value, of those that are not None."""
        values = {name: getattr(self, name) for name in names}
        return {name: value for name, value in values.items() if value is not None}

    def command(self, name: str, operand: str, out: Path) -> str:
        """The command line that repeats this run: command `name`, its operand, every option that
        differs from its default but --json and --quiet, and the folder `out`.

        >>> Options(order=1, quiet=True).command("run", "hertz-paper", Path("out/first"))
        'halfplane run hertz-paper --order 1 --out out/first'
        """
        command_words = ["halfplane", name, *([operand] if operand else [])]
        for option in fields(self):
            value = getattr(self, option.name)
            if value == option.default or option.name in ("out", "json", "quiet", "verbose"):
                continue
            name = option.name.strip("_").replace("_", "-")
            if isinstance(value, bool):
                command_words.append(f"--{name}" if value else f"--no-{name}")
            else:
                values = value if isinstance(value, tuple) else (value,)
                command_words += [f"--{name}", *map(str, values)]
        return shlex.join([*command_words, "--out", str(out)])

    def settings(self) -> "tuple[MeshSettings, SolverSettings]":
        """Settings of mesh and solver from these options; InputError for a value out of range.

        >>> mesh, _ = Options(preset="coarse", growth=0.2).settings()
        >>> mesh.edge_element_size, mesh.growth
        (0.03125, 0.2)
        """
        from halfplane_fe import SolverSettings
        from meshes import MeshSettings

        mesh_values = self.stated(_FINITE_ELEMENTS & MeshSettings.__dataclass_fields__.keys())
        solver_values = self.stated(_FINITE_ELEMENTS & SolverSettings.__dataclass_fields__.keys())
        mesh = replace(MeshSettings.preset(self.preset), **mesh_values)
        return mesh, SolverSettings(**solver_values)


_NAMES = [option.name for option in fields(Options)]
_OUTPUT = ("out", "json", "quiet")
# Sets of names, in their order above.
_FINITE_ELEMENTS = dict.fromkeys(
    _NAMES[_NAMES.index("preset") : _NAMES.index("max_iterations") + 1]
).keys()
WORKERS = ("executor", "scheduler", "workers")


class _Operand(NamedTuple):
    """What a command is about: its name, kind, words and default (... where it must be given);
    `alone`: never as an option.
    """

    name: str
    kind: Any
    words: str
    default: Any = ...
    alone: bool = False


@dataclass(frozen=True)
class _Command:
    """A row of the table of commands."""

    # group, name, help: in the list of commands
    group: str
    name: str
    help: str
    does: str  # module of `reports` and its function, of the operands and of `Options`
    # operands, options: what it takes; an option with "!" must be given
    operands: tuple[_Operand, ...]
    options: tuple[str, ...]
    # of options that mean something else than in the table
    words: Mapping[str, str] = field(default_factory=dict)
    silent: bool = False  # what --quiet prints: nothing at all


_SCENE_NAME = _Operand("scene", str, "Name of a library scene, or a .toml or .json file.")
_FOLDER = _Operand("folder", Path, "Folder of a sweep.", alone=True)
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
            *_FINITE_ELEMENTS,
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
        (*_OUTPUT, *_FINITE_ELEMENTS),
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
            *_FINITE_ELEMENTS,
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
        silent=True,
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
        ("start", "bodies", "profile", "quiet"),
        {"quiet": "Print nothing."},
        silent=True,
    ),
    _Command(
        "Scenes",
        "check",
        "Validate a scene; print a, p0 and the margin to gross sliding.",
        "cli.scene_files:check",
        (_SCENE_NAME,),
        ("json", "quiet", "loop", "mapping", "picture"),
        _SILENT,
        silent=True,
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
                alone=True,
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
        silent=True,
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
_COMMON = ("dissipation", "largest_pressure", "largest_half_width", "permanent_stick")


def share_of(text: str) -> float:
    """The share that a user writes as 5% or 0.05; NaN where it is no number."""
    try:
        return float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return math.nan


def requested_tolerances(option_texts: Sequence[str]) -> dict[str, float]:
    """Metric key -> tolerance, from the texts that the user wrote after `--tolerance`.

    `5%` sets that of W, p0, a and c together, `KEY=VALUE` that of one metric; the last text for a
    key counts. `KEY=none` makes it infinite: the metric is not judged.

    Raises
    ------
    InputError
        For a key that is none, for what is no share above 0, and for 1 or more without the sign %:
        5 may be meant as 5 %.

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
        key, equals, share_in_words = option_text.rpartition("=")
        if equals and key not in METRICS:
            known_names = list(METRICS)
            raise InputError(
                f"--tolerance {option_text}: unknown metric"
                f" {key!r};{did_you_mean(key, known_names)}"
                f" there are {', '.join(known_names)}"
            )
        is_unjudged = bool(equals) and share_in_words.strip() == "none"
        share = math.inf if is_unjudged else share_of(share_in_words)
        if not is_unjudged and not 0 < share < math.inf:
            raise InputError(
                f"--tolerance {option_text}: write a share above 0, such as 5% or 0.05, or one of a"
                " metric: dissipation=3%; dissipation=none leaves it unjudged"
            )
        if not is_unjudged and share >= 1 and not share_in_words.endswith("%"):
            alternatives = f"{key}{equals}{share:g}%, or {key}{equals}{100 * share:g}%"
            raise InputError(
                f"--tolerance {option_text}: a number without % is a share, and this is"
                f" {100 * share:g} %; write {alternatives}"
            )
        tolerances |= dict.fromkeys([key] if equals else _COMMON, share)
    return tolerances


# --------------------------------------------------------------------- streams, signals, exit codes
# 0: within tolerance, or nothing to judge; 1: outside or undecided. As shells count: 130 is 128 +
# SIGINT, 141 128 + SIGPIPE.
WITHIN = 0
OUTSIDE = 1
_BAD_INPUT = 2
NOT_CONVERGED = 3
_INTERNAL = 70
INTERRUPTED = 130
_UNREAD = 141


@contextmanager
def ended_by_signals() -> Generator[list[int], None, None]:
    """Within this context SIGTERM and SIGHUP end the program as Ctrl-C does. Yields the list of
    signals received, in their order. A signal that was to be ignored (nohup) stays ignored.
    """
    signals_received: list[int] = []

    def end_program(number: int, _frame: object) -> None:
        signals_received.append(number)
        raise KeyboardInterrupt

    numbers = [
        number
        for name in ("SIGINT", "SIGTERM", "SIGHUP")
        if (number := getattr(signal, name, None)) is not None
    ]
    for number in numbers:
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, end_program)
    try:
        yield signals_received
    finally:
        for number in numbers:
            if signal.getsignal(number) is end_program:
                signal.signal(number, signal.SIG_DFL)  # nothing is left to keep


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
    default_parameter=Words(negative_iterable=()),  # no --empty-tag
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
    table of commands. Its signature has the command's operands, then its options as keywords; its
    help texts are annotations. It calls the command's work, prints the answer and returns the exit
    code.
    """
    option_by_name = {option.name: option for option in fields(Options)}
    parameters = []
    for operand in command_row.operands:
        kind = Parameter.POSITIONAL_ONLY if operand.alone else Parameter.POSITIONAL_OR_KEYWORD
        default = Parameter.empty if operand.default is ... else operand.default
        help_words = Words(help=operand.words)
        parameters.append(
            Parameter(
                operand.name, kind, default=default, annotation=Annotated[operand.kind, help_words]
            )
        )
    for option_name in command_row.options:
        option = option_by_name[option_name.rstrip("!")]
        default = Parameter.empty if option_name.endswith("!") else option.default
        annotation: Any = option.type
        if option.name in command_row.words:
            help_words = Words(help=command_row.words[option.name], group="Parameters")
            annotation = Annotated[option.type, help_words]
        parameters.append(
            Parameter(option.name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        )
    signature = Signature(parameters)

    def command(*operands: Any, **options: Any) -> int:
        """Do what the command line asks for, print its answer, and return the exit code."""
        bound_arguments = signature.bind(*operands, **options)
        bound_arguments.apply_defaults()
        values = dict(bound_arguments.arguments)
        subjects = [values.pop(operand.name) for operand in command_row.operands]
        chosen_options = Options(**values)
        module, _, name = command_row.does.partition(":")
        do_command = getattr(import_module(f"reports.{module}"), name)
        return _print_answer(command_row, do_command(*subjects, chosen_options), chosen_options)

    command.__signature__ = signature  # type: ignore[attr-defined]
    return command


def _print_answer(command_row: _Command, answer: Answer, options: Options) -> int:
    """Print the answer of a command and return its exit code: lines and tables for the terminal, or
    with --json one document whose numbers are finite or null. No other function prints answers.
    """
    if options.json and answer.content is not None:
        from reports.comparison.json_values import strict

        content = {
            "format": FORMAT,
            "command": answer.command or command_row.name,
            "exit_code": answer.code,
            "scene": answer.scene,
            "result": answer.content(),
        }
        say(json.dumps(strict(content), allow_nan=False, indent=1))
    elif not (options.quiet and command_row.silent):
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
    """Run the command line and return its exit code. Without `arguments` they are those of the
    process, whose streams and signals are then handled too.
    """
    if arguments is not None:
        return Context().run(_run, list(arguments))
    gc.set_threshold(_NEW_OBJECTS, *gc.get_threshold()[1:])
    # No plugin of pydantic has a use here: to look for them reads the files of all packages.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # of signs that the terminal's encoding lacks
            stream.reconfigure(errors="backslashreplace")
    with ended_by_signals() as signals_received:
        code = WITHIN
        try:
            code = Context().run(_run, sys.argv[1:], signals_received)
            sys.stdout.flush()
        except BrokenPipeError:
            _drop_unwritten()
            return _UNREAD
        except OSError as reason:
            _drop_unwritten()
            if code == WITHIN:  # nothing has been reported yet
                code = _refused(
                    f"the answer could not be written to stdout: {reason.strerror}; see to that and"
                    " ask again"
                )
        except KeyboardInterrupt:  # a second one, while the first was reported
            code = INTERRUPTED
        finally:
            gc.freeze()  # the process ends here: looking for garbage once more is left out
        return 128 + signals_received[0] if code == INTERRUPTED and signals_received else code


def _drop_unwritten() -> None:
    """Send what could not be written to stdout nowhere: the end of the process would try it
    again.
    """
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _run(tokens: list[str], signals_received: Sequence[int] = ()) -> int:
    """Exit code of a command line given as `tokens`; whatever is refused or goes wrong is printed
    as one sentence. `signals_received` holds the signals until now.
    """
    try:
        if any(token == "" or (token.startswith("--") and token.endswith("=")) for token in tokens):
            return _refused(
                "one of the arguments is empty: is a variable of the shell not set? Give a value,"
                " or leave it out"
            )
        with _warnings_in_sentences():
            return int(app(tokens) or WITHIN)
    except KeyboardInterrupt as stop:
        return _interrupted(str(stop))
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
        sentence = f"halfplane: warning: {_one_line(str(message))} ({category.__name__})"
        if sentence not in sentences_printed:
            sentences_printed.add(sentence)
            complain(sentence)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def _report_fault(fault: Exception, tokens: list[str], signals_received: Sequence[int]) -> int:
    """Print what went wrong in a command line (`tokens`), the exception `fault`, as one sentence on
    stderr, and return the exit code for it. `signals_received` holds the signals until now.
    """
    # scenes is heavy: it is imported when it must have been imported already, never for --help.
    if isinstance(fault, ValueError | RuntimeError):
        from scenes import ConvergenceError, InputError

        if isinstance(fault, InputError):
            return _refused(f"{_one_line(str(fault))}{_notes_of(fault)}")
        if isinstance(fault, ConvergenceError):
            _refused(f"not converged: {_one_line(str(fault))}")
            return NOT_CONVERGED
    if isinstance(fault, CycloptsError):
        return _refused(_misspelt(fault))
    if isinstance(fault, MemoryError):
        cause = f" ({_one_line(str(fault))})" if str(fault) else ""
        cure = "ask for a coarser mesh, fewer steps or fewer instants"
        return _refused(f"there is not enough memory for this{cause}; {cure}{_notes_of(fault)}")
    if isinstance(fault, OSError):  # that no door has words for
        place = "a file: "
        if isinstance(fault.filename, str | bytes):
            place = f"{_one_line(os.fsdecode(fault.filename))}: "
        return _refused(
            f"cannot read or write {place}{fault.strerror or _one_line(str(fault))}; mend that and"
            f" run the command again{_notes_of(fault)}"
        )
    # Compiled modules and locks make another error of Ctrl-C.
    return _interrupted("") if signals_received else _internal(fault, tokens)


def _interrupted(sentence: str) -> int:
    _refused(f"interrupted; {sentence or 'nothing was written'}")
    return INTERRUPTED


def _internal(fault: Exception, tokens: Sequence[str]) -> int:
    """Report an exception that is a fault of the program itself: one sentence, and where its
    traceback was written. `tokens` are the words of the command line. Returns the exit code.
    """
    lines = [
        time.strftime("%Y-%m-%d %H:%M:%S %z  ") + shlex.join(["halfplane", *tokens]),
        *traceback.format_exception(fault),
    ]
    place = _keep_traceback("\n".join(line.rstrip("\n") for line in lines) + "\n")
    message = textwrap.shorten(str(fault), 200, placeholder=" ...").rstrip(".")
    kind = type(fault).__name__
    error = f"{kind}: {message}" if message else kind
    _refused(
        f"internal error, a fault of halfplane: {error}{_notes_of(fault)}; the traceback is"
        f" {place}: please report it"
    )
    return _INTERNAL


def _notes_of(fault: Exception) -> str:
    """The notes of a fault, on what was saved before it, to end a sentence with; empty without
    any.
    """
    return "".join(f"; {_one_line(note)}" for note in getattr(fault, "__notes__", ()))


def _keep_traceback(text: str) -> str:
    """Write a traceback to run.log of the output folder; where that fails, to a file in the
    temporary folder; else to stderr. Returns a phrase that says where it is, such as "in
    out/run.log".
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


def _refused(sentence: str) -> int:
    complain(f"halfplane: {sentence}")
    return _BAD_INPUT


def _one_line(text: str) -> str:
    return " ".join(text.split()).rstrip(".")


def _misspelt(fault: CycloptsError) -> str:
    """One sentence on what is wrong with a command line that can't be read, for the exception
    `fault` of the command-line library: the unknown word, the nearest known one, and what to do.
    """
    if isinstance(fault, UnknownCommandError):
        unused_words = list(fault.unused_tokens or [""])
        is_option = unused_words[0].startswith("-")
        suggestion = _nearest_word(
            unused_words[0],
            [known_word for known_word in app if known_word.startswith("-") is is_option],
        )
        return (
            f"there is no {'option' if is_option else 'command'} {unused_words[0]!r};"
            f" {suggestion}`halfplane --help` lists them"
        )
    chain = list(fault.command_chain or ())
    command = " ".join(chain) or "halfplane"
    help_of_command = f"`{' '.join(['halfplane', *chain])} --help`"
    if isinstance(fault, UnknownOptionError):
        word = (fault.token.keyword or fault.token.value).split("=", 1)[0]
        options = {
            option
            for argument in fault.argument_collection
            for option in argument.names
            if option.startswith("--")
        }
        return (
            f"{command} has no option {word}; {_nearest_word(word, options)}{help_of_command}"
            " lists them"
        )
    if isinstance(fault, UnusedCliTokensError):
        words_left_over = " ".join(fault.unused_tokens or [])
        suggestion = _suggestion_for_unused(fault, chain)
        return (
            f"{command}: unexpected argument {words_left_over!r}; {suggestion}{help_of_command}"
            " shows what it takes"
        )
    if (
        isinstance(fault, MissingArgumentError)
        and fault.argument is not None
        and not fault.argument.tokens
    ):
        # A word of its own in capitals, as in the help; an option as it is written.
        field_info = fault.argument.field_info
        name = fault.argument.name
        if field_info.kind is not field_info.KEYWORD_ONLY:
            name = name.removeprefix("--").upper()
        return f"{command}: {name} is missing; {help_of_command} shows what it takes"
    return f"{' '.join(str(fault).split()).rstrip('.')}; {help_of_command} shows what it takes"


def _suggestion_for_unused(fault: UnusedCliTokensError, chain: Sequence[str]) -> str:
    """A suggestion for an error message on words that a command does not take ("did you mean ...?
    "), ending in a blank; "" where no known word is near.

    `chain` is the command with the names of its subcommands. The command `sweep` takes a misspelt
    subcommand for the name of a study, so that the words behind it are what is left over.
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
