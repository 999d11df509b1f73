"""The application `halfplane`: its commands, its exit codes, and its start and end as a process."""

from __future__ import annotations

import os
import shlex
import sys
import tempfile
import textwrap
import time
import traceback
import warnings
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from contextvars import Context
from typing import Any

from cyclopts import (
    App,
    CycloptsError,
    Group,
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from reports.cli.process import BAD_INPUT, INTERNAL, INTERRUPTED, NOT_CONVERGED, WITHIN, settled

# The list of commands by use, and within a group in the order of the table below.
_SOLVE, JUDGE, SCENES, MACHINE = (Group(name, sort_key=k) for k, name in enumerate(("Solve", "Judge", "Scenes", "Machine")))
_COMMANDS = {
    _SOLVE: (
        ("run", "solving:run", "Both engines on one scene: verdict, page and data."),
        ("exact", "solving:exact", "Half-plane theory alone: summary, NetCDF and CSV, no page."),
        ("fe", "solving:fe", "Finite elements alone: summary, NetCDF and CSV, no page."),
        (
            "fields",
            "field_output:fields",
            "Displacement, stress and tractions in both bodies: files for ParaView, pictures, an animation.",
        ),
        ("sweep", "studies:sweep_app", "Run a study: a scene over axes of its keys, into a store; a later run resumes it."),
        ("export", "solving:export", "The bodies and the load history as an input deck for another code."),
    ),
    JUDGE: (
        ("score", "results:score", "Compare an external result with the reference: verdict, likely causes, page."),
        ("diff", "results:diff", "Two runs, or a run and a baseline, value by value: 0 the same within tolerance, 1 not."),
        (
            "advise",
            "results:advise",
            "May half-plane theory be used? Read off the published maps, without finite elements; exit code 1: better not.",
        ),
        ("map", "studies:make_map", "Run the studies of a map of the idealisation error, or resume them, and write its page."),
        ("paper", "solving:paper", "The paper again from half-plane theory: its figures, statements and misprints."),
    ),
    SCENES: (
        ("init", "scene_files:init", "Write a commented scene to start from, never over a file that exists."),
        (
            "check",
            "scene_files:check",
            "Refuse what `run` would refuse; state the contact's size and how near gross sliding is.",
        ),
        ("scenes", "scene_files:show", "The library of scenes, or all about one scene."),
        ("schema", "scene_files:schema", "The JSON schema of a scene file, for editors; or that of the answers of --json."),
    ),
    MACHINE: (
        ("doctor", "machine:doctor", "Can this machine do the work?"),
        (
            "completion",
            "machine:completion",
            'A script that completes commands and options: eval "$(halfplane completion bash)" in ~/.bashrc.',
        ),
    ),
}

_EXAMPLES = """\
Examples:
  halfplane scenes                          what the library has
  halfplane run hertz-paper                 both engines, verdict and page
  halfplane run hertz-paper --steps-per-cycle 320 --out out/fine
  halfplane run blocks --budget             where the discrepancy comes from
  halfplane init my.toml                    a commented scene to start from
  halfplane init my.toml --bodies           the same with a block and a pad
  halfplane check my.toml                   is it read, is it admissible?
  halfplane exact my.toml                   half-plane theory alone
  halfplane fe my.toml --method penalty     finite elements alone
  halfplane fields my.toml --at 12.6 14.1   both bodies for ParaView, pictures
  halfplane score my.csv --scene hertz-paper  an external result
  halfplane export my.toml --to calculix    a deck for another code
  halfplane diff out/a out/b                two runs, or a run and a baseline
  halfplane sweep study.toml                a scene over axes of its keys
  halfplane advise my.toml                  may half-plane theory be used?
  halfplane paper                           the paper's figures and statements
  halfplane completion bash                 a script that completes words
Exit codes: 0 within tolerance or nothing to judge, 1 outside or undecided,
            2 bad input, 3 not converged, 70 internal error, 130 interrupted
            (143 by SIGTERM, 129 by SIGHUP), 141 nobody read on.
"""


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("halfplane")
    except PackageNotFoundError:
        return "not installed: run from a checkout"


app = App(
    name="halfplane",
    help="How wrong is the half-plane idealisation? One scene, two engines, one report.",
    help_epilogue=_EXAMPLES,
    help_format="plaintext",
    version=_version,
    suppress_keyboard_interrupt=False,
    exit_on_error=False,
    print_error=False,
    result_action="return_value",
    group_commands=MACHINE,
)
for _group, _rows in _COMMANDS.items():
    for _order, (_name, _target, _help) in enumerate(_rows, start=1):
        # An application of its own, as that of `sweep`, has an epilogue of its own.
        _epilogue = {} if _target.endswith("_app") else {"help_epilogue": ""}
        app.command(f"reports.cli.{_target}", name=_name, help=_help, group=_group, sort_key=_order, **_epilogue)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code; without `arguments` the process is ours, its streams and signals too."""
    if arguments is not None:
        return Context().run(_run, list(arguments))
    with settled() as process:
        try:
            code = Context().run(_run, sys.argv[1:], process.received)
            if (fault := process.unwritten()) is not None:
                code = _refused(f"the answer could not be written to stdout: {fault.strerror}; see to that and ask again")
        except KeyboardInterrupt:  # a second one, while the first was told
            code = INTERRUPTED
        return process.exit_code(code)


def _run(tokens: list[str], received: Sequence[int] = ()) -> int:
    """The exit code of a command line; whatever is refused or goes wrong, in a sentence. `received`: signals until now."""
    try:
        if any(token == "" or (token.startswith("--") and token.endswith("=")) for token in tokens):
            return _refused("one of the arguments is empty: is a variable of the shell not set? Give a value, or leave it out")
        # A byte that could not be decoded stands as a lone surrogate, which no file of ours can hold.
        if strange := next((token for token in tokens if any("\ud800" <= sign <= "\udfff" for sign in token)), ""):
            encoding = sys.getfilesystemencoding()
            return _refused(f"{strange}: this is no text in {encoding}; name it otherwise, or set PYTHONUTF8=1 if it is UTF-8")
        with _old_names_shown():
            return int(app(tokens) or WITHIN)
    except KeyboardInterrupt as stop:
        return _interrupted(str(stop))
    except Exception as fault:  # noqa: BLE001 (the outermost door: nothing may leave it but an exit code)
        return _said(fault, tokens, received)


@contextmanager
def _old_names_shown() -> Generator[None, None, None]:
    """Each old name of a key that is read, in one line on stderr: Python itself shows no DeprecationWarning of a library."""
    shown: set[str] = set()
    with warnings.catch_warnings():
        others = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
            if not (issubclass(category, DeprecationWarning) and " is now called " in str(message)):
                others(message, category, *place, **more)
            elif str(message) not in shown:
                from reports.console import complain

                shown.add(str(message))
                complain(f"Note: {message}.")

        warnings.filterwarnings("always", ".* is now called ", DeprecationWarning)
        warnings.showwarning = show
        yield


def _said(fault: Exception, tokens: list[str], received: Sequence[int]) -> int:
    """The exit code of what went wrong, and its sentence on stderr."""
    # scenes is heavy: it is imported when it must have been imported already, never for --help.
    if isinstance(fault, ValueError | RuntimeError):
        from scenes import ConvergenceError, InputError

        if isinstance(fault, InputError):
            return _refused(_one_line(str(fault)))
        if isinstance(fault, ConvergenceError):
            _refused(f"not converged: {_one_line(str(fault))}")
            return NOT_CONVERGED
    if isinstance(fault, CycloptsError):
        return _refused(_misspelt(fault))
    if isinstance(fault, MemoryError):
        why = f" ({_one_line(str(fault))})" if str(fault) else ""
        return _refused(f"there is not enough memory for this{why}; ask for a coarser mesh, fewer steps or fewer instants")
    if isinstance(fault, OSError):  # that no door has words for
        where = f"{_one_line(os.fsdecode(fault.filename))}: " if isinstance(fault.filename, str | bytes) else "a file: "
        return _refused(
            f"cannot read or write {where}{fault.strerror or _one_line(str(fault))}; mend that and run the command again"
        )
    # Compiled modules and locks make another error of Ctrl-C.
    return _interrupted("") if received else _internal(fault, tokens)


def _interrupted(what: str) -> int:
    _refused(f"interrupted; {what or 'nothing was written'}")
    return INTERRUPTED


def _internal(fault: Exception, tokens: Sequence[str]) -> int:
    """A fault of the program: one sentence, and where its traceback is."""
    lines = [time.strftime("%Y-%m-%d %H:%M:%S %z  ") + shlex.join(["halfplane", *tokens]), *traceback.format_exception(fault)]
    place = _kept("\n".join(line.rstrip("\n") for line in lines) + "\n")
    what = ": ".join(filter(None, (type(fault).__name__, textwrap.shorten(str(fault), 200, placeholder=" ...").rstrip("."))))
    _refused(f"internal error, a fault of halfplane: {what}; the traceback is {place}: please report it")
    return INTERNAL


def _kept(text: str) -> str:
    """Keep a traceback in run.log of the output folder, else in the temporary folder, else on stderr; where that is, in words."""
    from reports.console import complain

    with suppress(Exception):  # where the folder can't take it, the next place does
        from reports.folder import add_to_log, output_folder

        if (folder := output_folder.get()) is not None:
            return f"in {add_to_log(folder, text)}"
    try:
        handle, name = tempfile.mkstemp(prefix="halfplane-", suffix=".log")
        with open(handle, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
        return f"in {name}"
    except OSError:
        complain(text)
        return "above"


def _refused(sentence: str) -> int:
    from reports.console import complain

    complain(f"halfplane: {sentence}")
    return BAD_INPUT


def _one_line(text: str) -> str:
    return " ".join(text.split()).rstrip(".")


def _misspelt(fault: CycloptsError) -> str:
    """What a command line that can't be read has wrong: one sentence, with the nearest known word and what to do."""
    from scenes.frozen import did_you_mean

    def nearest(word: str, known: Iterable[str]) -> str:
        return f"{did_you_mean(word.lower(), known).strip()} ".lstrip()

    if isinstance(fault, UnknownCommandError):
        words = list(fault.unused_tokens or [""])
        option = words[0].startswith("-")
        hint = nearest(words[0], [name for name in app if name.startswith("-") is option])
        return f"there is no {'option' if option else 'command'} {words[0]!r}; {hint}`halfplane --help` lists them"
    chain = list(fault.command_chain or ())
    command, shown = " ".join(chain) or "halfplane", f"`{' '.join(['halfplane', *chain])} --help`"
    if isinstance(fault, UnknownOptionError):
        word = (fault.token.keyword or fault.token.value).split("=", 1)[0]
        options = {name for argument in fault.argument_collection for name in argument.names if name.startswith("--")}
        return f"{command} has no option {word}; {nearest(word, options)}{shown} lists them"
    if isinstance(fault, UnusedCliTokensError):
        # `sweep` takes a misspelt command of its own for a study, and what follows is left over.
        first = (fault.root_input_tokens or [])[len(chain) :][:1]
        hint = nearest(first[0], [name for name in fault.app or () if not name.startswith("-")]) if first else ""
        return f"{command}: unexpected argument {' '.join(fault.unused_tokens or [])!r}; {hint}{shown} shows what it takes"
    if isinstance(fault, MissingArgumentError) and fault.argument is not None and not fault.argument.tokens:
        # A word of its own in capitals, as in the help; an option as it is written.
        in_place = fault.argument.field_info.kind is not fault.argument.field_info.KEYWORD_ONLY
        wanted = fault.argument.name.removeprefix("--").upper() if in_place else fault.argument.name
        return f"{command}: {wanted} is missing; {shown} shows what it takes"
    return f"{' '.join(str(fault).split()).rstrip('.')}; {shown} shows what it takes"
