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
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager, suppress
from contextvars import Context
from dataclasses import fields
from importlib import import_module, resources
from inspect import Parameter, Signature
from json import dumps
from typing import Annotated, Any

from cyclopts import (
    App,
    CycloptsError,
    Group,
    MissingArgumentError,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)
from cyclopts import Parameter as Words

from reports.cli.options import COMMANDS, FORMAT, Answer, Command, Options
from reports.cli.process import BAD_INPUT, INTERNAL, INTERRUPTED, NOT_CONVERGED, WITHIN, settled
from reports.console import complain, say, show


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("halfplane")
    except PackageNotFoundError:
        return "not installed: run from a checkout"


_GROUPS = {name: Group(name, sort_key=k) for k, name in enumerate(dict.fromkeys(row.group for row in COMMANDS))}
app = App(
    name="halfplane",
    help="How wrong is the half-plane idealisation? One scene, two engines, one report.",
    help_epilogue=(resources.files("reports") / "templates" / "help.txt").read_text("utf-8"),
    help_format="plaintext",
    version=_version,
    suppress_keyboard_interrupt=False,
    exit_on_error=False,
    print_error=False,
    result_action="return_value",
    group_commands=_GROUPS["Machine"],
)


def _taken(row: Command) -> Callable[..., int]:
    """The function that the application calls for a command: with its operands, and its options one by one."""
    table, parameters = {one.name: one for one in fields(Options)}, []
    for operand in row.operands:
        kind = Parameter.POSITIONAL_ONLY if operand.alone else Parameter.POSITIONAL_OR_KEYWORD
        default = Parameter.empty if operand.default is ... else operand.default
        words = Words(help=operand.words)
        parameters.append(Parameter(operand.name, kind, default=default, annotation=Annotated[operand.kind, words]))
    for marked in row.options:
        one = table[marked.rstrip("!")]
        other = Words(help=row.words[one.name], group="Parameters") if one.name in row.words else None
        default = Parameter.empty if marked.endswith("!") else one.default
        parameters.append(
            Parameter(
                one.name, Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[one.type, other] if other else one.type
            )
        )
    signature = Signature(parameters)

    def command(*operands: Any, **options: Any) -> int:
        bound = signature.bind(*operands, **options)
        bound.apply_defaults()
        given = dict(bound.arguments)
        about = [given.pop(operand.name) for operand in row.operands]
        module, _, name = row.does.partition(":")
        asked = Options(**given)
        return _told(row, getattr(import_module(f"reports.cli.{module}"), name)(*about, asked), asked)

    command.__signature__ = signature  # type: ignore[attr-defined]
    return command


def _told(row: Command, found: Answer, options: Options) -> int:
    """The one place where commands print: lines and tables, or with --json one document whose numbers are finite or null."""
    if options.json and found.result is not None:
        from reports.comparison.words import strict

        content = {
            "format": FORMAT,
            "command": found.command or row.name,
            "exit_code": found.code,
            "scene": found.scene,
            "result": found.result(),
        }
        say(dumps(strict(content), allow_nan=False, indent=1, ensure_ascii=False))
    elif not (options.quiet and row.silent):
        show(found.shown)
    return found.code


for _order, _row in enumerate(COMMANDS):
    _above, _, _name = _row.name.rpartition(" ")
    _place: dict[str, Any] = {"help": _row.help, "group": _GROUPS[_row.group], "sort_key": _order, "help_epilogue": ""}
    if _above:
        app[_above].command(_taken(_row), name=_name, help=_row.help, help_epilogue="")
    elif any(one.name.startswith(f"{_name} ") for one in COMMANDS):  # with commands of its own
        app.command(_own := App(name=_name, group_commands=Group(f"Of a {_name} that is there"), **_place))
        _own.default(_taken(_row))
    else:
        app.command(_taken(_row), name=_name, **_place)


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
        left = " ".join(fault.unused_tokens or [])
        hint = nearest(first[0], [name for name in fault.app or () if not name.startswith("-")]) if first else ""
        if first and not hint and left.endswith((".toml", ".json")) and not first[0].endswith((".toml", ".json")):
            hint = f"write `halfplane {command} {left}`; "
        return f"{command}: unexpected argument {left!r}; {hint}{shown} shows what it takes"
    if isinstance(fault, MissingArgumentError) and fault.argument is not None and not fault.argument.tokens:
        # A word of its own in capitals, as in the help; an option as it is written.
        in_place = fault.argument.field_info.kind is not fault.argument.field_info.KEYWORD_ONLY
        wanted = fault.argument.name.removeprefix("--").upper() if in_place else fault.argument.name
        return f"{command}: {wanted} is missing; {shown} shows what it takes"
    return f"{' '.join(str(fault).split()).rstrip('.')}; {shown} shows what it takes"
