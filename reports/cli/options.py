"""The tables of the command line: every option, of which a command takes some, and every command; and what a command answers."""

# Annotations are evaluated here: no `from __future__`.
import math
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from importlib import resources
from json import loads
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

from cyclopts import Group, Parameter, Token

from reports.console import Part

if TYPE_CHECKING:
    from halfplane_fe import SolverSettings
    from meshes import MeshSettings

FORMAT = "halfplane answer 2"
_MESH = Group("Mesh (lengths over the contact half-width; what is left out is the engine's own)", sort_key=2)
_SOLVER = Group("Solver (what is left out is the engine's own)", sort_key=3)
_SCENE = Group("Scene (what is left out stays as in the example; N, mm, MPa)", sort_key=2)


def _whole(_: type, tokens: Sequence[Token]) -> int:
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"{tokens[0].value!r} is no whole number") from None  # what reads options would round it


# A number of things: nothing is rounded.
_Count = Annotated[int, Parameter(converter=_whole)]


def _says(words: str, *names: str, **more: Any) -> Parameter:
    return Parameter(*names, help=words, **more)


def _flag(words: str) -> Parameter:
    """A switch that has no opposite."""
    return Parameter(negative="", help=words)


def _several(words: str) -> Parameter:
    """An option with one value or many: `--vtu 1 2`, or the option again."""
    return Parameter(consume_multiple=True, negative="", help=words)


def _mesh(words: str) -> Parameter:
    return Parameter(group=_MESH, help=words)


def _solver(words: str) -> Parameter:
    return Parameter(group=_SOLVER, help=words)


def _key(words: str) -> Parameter:
    return Parameter(group=_SCENE, help=words)


@dataclass(frozen=True, kw_only=True)
class Options:
    """Every option; one that is left out, or that the command does not take, has its default, None being the engine's own."""

    out: Annotated[Path | None, _says("Folder for the results; out/<scene name> if left out.")] = None
    json: Annotated[bool, _flag("As JSON on stdout, and nothing else there.")] = False
    quiet: Annotated[bool, _flag("No progress on stderr.")] = False
    # finite elements
    preset: Annotated[
        Literal["default", "coarse", "fine"],
        _mesh("Mesh to start from: coarse for a first look, fine for a result to rely on."),
    ] = "default"
    element_size: Annotated[float | None, _mesh("Surface elements where the tractions are smooth.")] = None
    edge_element_size: Annotated[float | None, _mesh("Surface elements where the contact and stick edges travel.")] = None
    far_radius: Annotated[float | None, _mesh("Radius of the half-disc that stands for a half-plane.")] = None
    growth: Annotated[float | None, _mesh("Growth of the elements away from the contact.")] = None
    order: Annotated[_Count | None, _mesh("Order of the elements, 1 or 2.")] = None
    method: Annotated[
        Literal["augmented_lagrangian", "penalty"] | None,
        _solver("The contact law met exactly, or an elastic layer between the faces."),
    ] = None
    steps_per_cycle: Annotated[_Count | None, _solver("Steps of a revolution; turning points come on top.")] = None
    step_tolerance: Annotated[float | None, _solver("Error of a revolution's steps over W above which steps are halved.")] = None
    normal_stiffness: Annotated[float | None, _solver("Of the penalty layer, over E*/h; without one no answer depends on it.")] = (
        None
    )
    tangential_stiffness: Annotated[
        float | None, _solver("Of the penalty layer, over E*/h; without one no answer depends on it.")
    ] = None
    max_iterations: Annotated[_Count | None, _solver("Of one step, before it counts as not converged.")] = None
    # run, score, diff
    tolerance: Annotated[
        tuple[str, ...], _several("5%: of dissipation, peak pressure and both half-widths; KEY=VALUE: of one metric.")
    ] = ()
    budget: Annotated[bool | None, _says("Measure where the difference comes from: coarser meshes, other far fields.")] = None
    vtu: Annotated[tuple[str, ...], _several('Write both bodies for ParaView at these times, or at "events".')] = ()
    stress: Annotated[tuple[str, ...], _several('Show von Mises stress on the page at these times, or at "events".')] = ()
    pdf: Annotated[bool, Parameter(negative="", show=False)] = False
    plots: Annotated[
        tuple[Literal["pdf", "svg", "png"], ...],
        _several("Every figure as a file of publication quality too, in plots/: pdf svg png."),
    ] = ()
    third: Annotated[Literal["calculix"] | None, _says("A third solver: runs `ccx` on the exported deck.")] = None
    third_limit: Annotated[float | None, _says("Seconds until the third solver is stopped; 1800 if left out.")] = None
    scene: Annotated[str | None, _says("The scene that it answers: a library name, or a .toml or .json file.")] = None
    as_: Annotated[
        Literal["tractions", "loop"],
        _says("What the file holds: tractions, or a rig's loop of tangential load over displacement.", "--as"),
    ] = "tractions"
    rig_compliance: Annotated[
        float | None, _says("Of a loop: displacement of the rig per tangential load, 1/stress; fitted if left out.")
    ] = None
    mapping: Annotated[Path | None, _says("TOML file: names of columns, units, signs. Usual ones need none.")] = None
    against: Annotated[Literal["exact", "fe"], _says("Half-plane theory, or the project's own finite elements.")] = "exact"
    mapping_example: Annotated[bool, _flag("Print a commented mapping file and stop.")] = False
    accept: Annotated[bool, _flag("Make B a baseline of A; the tolerances given are kept in it.")] = False
    limit: Annotated[str, _says("Error of dissipation up to which half-plane theory may be used: 5% or 0.05.")] = "5%"
    # fields, export
    at: Annotated[tuple[str, ...], _several('Times of the path, or "events" of the last cycle, the default without a series.')] = ()
    every: Annotated[_Count | None, _says("A series over the last cycle: every Nth stored step.")] = None
    frames: Annotated[_Count | None, _says("A series over the last cycle: N instants evenly in time.")] = None
    animate: Annotated[
        bool, _flag("The cycle as GIF and MP4: the instants of the series, 60 without one. MP4: halfplane[animation].")
    ] = False
    pictures: Annotated[bool, _says("Draw the meshes and the von Mises stress at the instants of --at as PNG.")] = True
    fatigue: Annotated[
        bool, _flag("Stress through the last cycle by both engines: ranges, Smith-Watson-Topper, Crossland; fields/fatigue.csv.")
    ] = False
    fatemi_socie: Annotated[tuple[float, float] | None, _says("k and yield stress: Fatemi and Socie's measure too.")] = None
    findley: Annotated[float | None, _says("k: Findley too.")] = None
    critical_distance: Annotated[float | None, _says("Depth over which the stress is averaged for --fatigue.")] = None
    to: Annotated[Literal["calculix", "abaqus"], _says("The dialect of the deck.")] = "calculix"
    cycles: Annotated[_Count | None, _says("Revolutions at most.")] = None
    # sweep, map
    executor: Annotated[Literal["processes", "dask"], _says("Processes of this machine, or a dask cluster.")] = "processes"
    scheduler: Annotated[str, _says("Address of your dask scheduler; without one a cluster starts on this machine.")] = ""
    workers: Annotated[_Count | None, _says("Processes, or tasks at once; all cores if left out.")] = None
    tls_ca_file: Annotated[Path | None, _says("Certificates trusted, of a tls:// scheduler (PEM).")] = None
    tls_cert: Annotated[Path | None, _says("Our own certificate (PEM).")] = None
    tls_key: Annotated[Path | None, _says("Its private key (PEM).")] = None
    resume: Annotated[bool, _flag("What every run does: the results that the folder holds are used.")] = False
    stores: Annotated[Path, _says("Folder of the sweeps' stores.")] = Path("out/maps")
    remake: Annotated[bool, _flag("Start afresh: drop the sweeps' results first.")] = False
    pages: Annotated[bool, _flag("Laws, figures and pages alone, from the tables that are there.")] = False
    # init, scenes, schema
    start: Annotated[
        str, _says("Copy this library scene, with the files it reads, instead of the commented example.", "--from")
    ] = ""
    bodies: Annotated[bool, _flag("The example with a block and a pad in place of half-planes.")] = False
    title: Annotated[str | None, _key("A line about the scene.")] = None
    profile: Annotated[Literal["hertz", "flat_rounded"] | None, _key("A parabola, or flat with rounded edges.")] = None
    radius: Annotated[float | None, _key("Relative radius of the profile or its edges, mm.")] = None
    flat_half_length: Annotated[float | None, _key("Half the flat of flat_rounded, mm.")] = None
    young_modulus: Annotated[float | None, _key("Of both bodies, MPa.")] = None
    poisson_ratio: Annotated[float | None, _key("Of both bodies.")] = None
    friction: Annotated[float | None, _key("Coulomb's coefficient.")] = None
    mean_normal_load: Annotated[float | None, _key("P0 of P0 + P1 cos t, N/mm.")] = None
    normal_amplitude: Annotated[float | None, _key("P1, N/mm.")] = None
    mean_tangential_load: Annotated[float | None, _key("Q0 of Q0 + Q1 cos(t - phase), N/mm.")] = None
    tangential_amplitude: Annotated[float | None, _key("Q1, N/mm.")] = None
    phase_degrees: Annotated[float | None, _key("Lag of Q behind P.")] = None
    tag: Annotated[tuple[str, ...], _says("Only scenes that have this tag; again for scenes that have all of them.")] = ()
    answers: Annotated[bool, _flag("That of what --json prints, in place of a scene file's.")] = False

    def given(self, names: Iterable[str]) -> dict[str, Any]:
        """Name -> value, of those that are not None."""
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def command(self, name: str, operand: str, out: Path) -> str:
        """The command line that repeats this: every option that differs from its default but --json and --quiet.

        >>> Options(order=1, quiet=True).command("run", "hertz-paper", Path("out/first"))
        'halfplane run hertz-paper --order 1 --out out/first'
        """
        words = ["halfplane", name, *([operand] if operand else [])]
        for one in fields(self):
            value, option = getattr(self, one.name), one.name.strip("_").replace("_", "-")
            if value == one.default or one.name in ("out", "json", "quiet"):
                continue
            if isinstance(value, bool):
                words.append(f"--{option}" if value else f"--no-{option}")
            else:
                words += [f"--{option}", *(map(str, value) if isinstance(value, tuple) else [str(value)])]
        return shlex.join([*words, "--out", str(out)])

    def settings(self) -> "tuple[MeshSettings, SolverSettings]":
        """How the finite elements are meshed and iterated; InputError for a value out of range.

        >>> mesh, _ = Options(preset="coarse", growth=0.2).settings()
        >>> mesh.edge_element_size, mesh.growth
        (0.03125, 0.2)
        """
        from halfplane_fe import SolverSettings
        from meshes import MeshSettings

        mesh, solver = (self.given(_FINITE_ELEMENTS & kind.__dataclass_fields__.keys()) for kind in (MeshSettings, SolverSettings))
        return replace(MeshSettings.preset(self.preset), **mesh), SolverSettings(**solver)


_NAMES = [one.name for one in fields(Options)]
_OUTPUT = ("out", "json", "quiet")
# Sets of names, in their order above.
_FINITE_ELEMENTS = dict.fromkeys(_NAMES[_NAMES.index("preset") : _NAMES.index("max_iterations") + 1]).keys()
KEYS = dict.fromkeys(_NAMES[_NAMES.index("title") : _NAMES.index("phase_degrees") + 1]).keys()
WORKERS = ("executor", "scheduler", "workers", "tls_ca_file", "tls_cert", "tls_key")


class _Operand(NamedTuple):
    """What a command is about: its name, kind, words and default (... where it must be given); `alone`: never as an option."""

    name: str
    kind: Any
    words: str
    default: Any = ...
    alone: bool = False


@dataclass(frozen=True)
class Command:
    """A row of the table of commands."""

    # group, name, help: in the list of commands
    group: str
    name: str
    help: str
    does: str  # module and function, of the operands and of `Options`
    # operands, options: what it takes; an option with "!" must be given
    operands: tuple[_Operand, ...]
    options: tuple[str, ...]
    words: Mapping[str, str] = field(default_factory=dict)  # of options that mean something else than in the table
    silent: bool = False  # what --quiet prints: nothing at all


_SCENE_NAME = _Operand("scene", str, "Name of a library scene, or a .toml or .json file.")
_FOLDER = _Operand("folder", Path, "Folder of a sweep.", alone=True)
_SILENT = {"quiet": "Print nothing: the exit code is the answer."}
# The list of commands by use, and within a group in this order.
COMMANDS = (
    Command(
        "Solve", "run", "Both engines on one scene: verdict, page and data.",
        "solving:run", (_SCENE_NAME,),
        (*_OUTPUT, "tolerance", "budget", "vtu", "stress", "pdf", "plots", "third", "third_limit", *_FINITE_ELEMENTS),
    ),
    Command(
        "Solve", "exact", "Half-plane theory alone: summary, NetCDF and CSV, no page.", "solving:exact", (_SCENE_NAME,), _OUTPUT
    ),
    Command(
        "Solve", "fe", "Finite elements alone: summary, NetCDF and CSV, no page.",
        "solving:fe", (_SCENE_NAME,), (*_OUTPUT, *_FINITE_ELEMENTS),
    ),
    Command(
        "Solve", "fields", "Displacement, stress and tractions in both bodies: files for ParaView, pictures, an animation.",
        "field_output:fields", (_SCENE_NAME,),
        (*_OUTPUT, "at", "every", "frames", "animate", "pictures", "fatigue", "fatemi_socie", "findley", "critical_distance",
         *_FINITE_ELEMENTS),
    ),
    Command(
        "Solve", "sweep", "Run a study: a scene over axes of its keys, into a store; a later run resumes it.",
        "studies:sweep", (_Operand("study", str, "A study file, .toml or .json; see docs/sweeps.md."),),
        (*_OUTPUT, *WORKERS, "resume"), {"out": "Folder of the store; out/<study file> if left out."},
    ),
    Command(
        "Solve", "sweep status", "How far a sweep is: done, failed, running, time left.",
        "studies:status", (_FOLDER,), ("json",),
    ),
    Command(
        "Solve", "sweep report", "The page of a sweep: its table and a figure of each quantity, also while it runs.",
        "studies:report", (_FOLDER,), ("json",),
    ),
    Command(
        "Solve", "export", "The bodies and the load history as an input deck for another code.",
        "solving:export", (_SCENE_NAME,), (*_OUTPUT, "to!", "steps_per_cycle", "cycles"),
        {"steps_per_cycle": "Instants of a revolution; turning points come on top."},
    ),
    Command(
        "Judge", "score", "Compare an external result with the reference: verdict, likely causes, page.",
        "results:score",
        (_Operand("result", str | None, "An external result: a table (.csv, .txt, .rpt), fields, a solution (.nc); or a folder of "
                 "meshes.", None),),
        (*_OUTPUT, "scene", "as_", "rig_compliance", "mapping", "against", "tolerance", "mapping_example"),
        {"out": "Folder for the results; out/score-<result> if left out."},
    ),
    Command(
        "Judge", "diff", "Two runs, or a run and a baseline, value by value: 0 the same within tolerance, 1 not.",
        "results:diff",
        (_Operand("a", str, "Folder of a run, its comparison.json, a solution (.nc), or a baseline."),
         _Operand("b", str, "The same; with --accept the baseline to write.")),
        ("tolerance", "accept", "json", "quiet"),
        {"tolerance": 'KEY=VALUE of one value, or of many: "metric.*=1e-4".', **_SILENT}, silent=True,
    ),
    Command(
        "Judge", "advise",
        "May half-plane theory be used? Read off the published maps, without finite elements; exit code 1: better not.",
        "results:advise", (_SCENE_NAME,), ("limit", "json"),
    ),
    Command(
        "Judge", "map", "Run the studies of a map of the idealisation error, or resume them, and write its page.",
        "studies:make_map", (_Operand("name", str, "Name of a map (docs/maps.md), or all."),),
        (*_OUTPUT, "stores", "workers", "remake", "pages"),
        {"out": "Folder of tables and pages; a checkout's reports/published/maps if left out.",
         "workers": "Processes; all cores if left out."},
    ),
    Command(
        "Judge", "paper", "The paper again from half-plane theory: its figures, statements and misprints.",
        "solving:paper", (), _OUTPUT, {"out": "Folder for the results; out/paper if left out."},
    ),
    Command(
        "Scenes", "init", "Write a commented scene to start from, never over a file that exists.",
        "scene_files:init", (_Operand("file", Path, "New file, ending in .toml."),), ("start", "bodies", "quiet", *KEYS),
        {"quiet": "Print nothing."}, silent=True,
    ),
    Command(
        "Scenes", "check", "Refuse what `run` would refuse; state the contact's size and how near gross sliding is.",
        "scene_files:check", (_SCENE_NAME,), ("json", "quiet"), _SILENT, silent=True,
    ),
    Command(
        "Scenes", "scenes", "The library of scenes, or all about one scene.",
        "scene_files:show",
        (_Operand("name", str, "Show this scene in detail: a name of the library, or a .toml or .json file.", "", alone=True),),
        ("tag", "json"),
    ),
    Command(
        "Scenes", "schema", "The JSON schema of a scene file, for editors; or that of the answers of --json.",
        "scene_files:schema", (), ("answers",),
    ),
    Command(
        "Machine", "doctor", "Can this machine do the work?", "machine:doctor", (), _OUTPUT,
        {"out": "Folder whose disk and rights are checked; out if left out.", **_SILENT}, silent=True,
    ),
    Command(
        "Machine", "completion",
        'A script that completes commands and options: eval "$(halfplane completion bash)" in ~/.bashrc.',
        "machine:completion", (_Operand("shell", Literal["bash", "zsh", "fish"], "The shell that is to complete words."),), (),
    ),
)  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """What a command found."""

    code: int  # exit code
    shown: Iterable[Part] = ()  # lines and tables for the terminal, made when they are printed
    # what --json prints as "result", not finite numbers among it, made when it is printed; None: there is no JSON of it
    result: Callable[[], Mapping[str, Any]] | None = None
    scene: str | None = None  # name of the scene; None where a command is about none
    command: str = ""  # whose answer it is, where not that of the command given


def answer_schema() -> dict[str, Any]:
    """The JSON schema of every answer: the envelope, and for each command what `result` holds."""
    found: dict[str, Any] = loads((resources.files("reports") / "templates" / "answer.schema.json").read_text("utf-8"))
    return found


# What a tolerance without a key is for: W, p0, a and c.
_COMMON = ("dissipation", "largest_pressure", "largest_half_width", "permanent_stick")


def share_of(text: str) -> float:
    """The share that a user writes as 5% or 0.05; NaN where it is no number."""
    try:
        return float(text.removesuffix("%")) / (100 if text.endswith("%") else 1)
    except ValueError:
        return math.nan


def requested_tolerances(words: Sequence[str]) -> dict[str, float]:
    """Metric key -> tolerance, of `--tolerance 5%` (W, p0, a and c together) and `--tolerance KEY=VALUE`, the last of a key.

    Raises
    ------
    InputError
        For a key that is none, for what is no share above 0, and for 1 or more without the sign %: 5 may be meant as 5 %.

    >>> requested_tolerances(["5%", "dissipation=0.03"])
    {'dissipation': 0.03, 'largest_pressure': 0.05, 'largest_half_width': 0.05, 'permanent_stick': 0.05}
    """
    if not words:
        return {}
    from reports.comparison.metrics import METRICS
    from scenes import InputError
    from scenes.frozen import did_you_mean

    found: dict[str, float] = {}
    for word in words:
        key, equals, text = word.rpartition("=")
        if equals and key not in METRICS:
            known = list(METRICS)
            raise InputError(f"--tolerance {word}: unknown metric {key!r};{did_you_mean(key, known)} there are {', '.join(known)}")
        value = share_of(text)
        if not 0 < value < math.inf:
            raise InputError(f"--tolerance {word}: write a share above 0, such as 5% or 0.05, or one of a metric: dissipation=3%")
        if value >= 1 and not text.endswith("%"):
            ways = f"{key}{equals}{value:g}%, or {key}{equals}{100 * value:g}%"
            raise InputError(f"--tolerance {word}: a number without % is a share, and this is {100 * value:g} %; write {ways}")
        found |= dict.fromkeys([key] if equals else _COMMON, value)
    return found
