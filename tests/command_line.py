"""The command `halfplane` as the tests call it: in this process, or as a process of its own where
the process is the matter.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import resource
import signal
import subprocess
import sys
import traceback
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any
from unittest import mock

import jsonschema

from reports.cli import main
from reports.cli.application import FORMAT

ROOT = Path(__file__).parents[1]
# The coarsest mesh and steps that still go through both engines: a second, and far outside every
# tolerance.
COARSE = (
    "--order",
    "1",
    "--element-size",
    "0.25",
    "--edge-element-size",
    "0.25",
    "--steps-per-cycle",
    "8",
)
# A scene up to its load: half-planes of steel in the library's units.
HERTZ_SCENE = """
[material]
young_modulus = 210e3
poisson_ratio = 0.3
[profile]
kind = "hertz"
radius = 1000.0
[friction]
coefficient = 0.5
"""


@dataclass(frozen=True)
class Done:
    """What became of a command: exit code and streams."""

    returncode: int
    stdout: str
    stderr: str


def environment(**variables: str) -> dict[str, str]:
    """This checkout on the path, whether it is installed or not; tables so wide that no line is
    broken.
    """
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return os.environ | {"PYTHONPATH": path, "COLUMNS": "400", "NO_COLOR": "1"} | variables


def halfplane(folder: Path, *words: str, **variables: str) -> Done:
    """A command in this process, its current folder `folder`, with variables of its own."""
    out = io.StringIO()
    errors = io.StringIO()
    with (
        contextlib.chdir(folder),
        mock.patch.dict(os.environ, environment(**variables)),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(errors),
    ):
        code = main(list(words))
    return Done(code, out.getvalue(), errors.getvalue())


def forked(
    folder: Path,
    *words: str | bytes,
    act: Callable[[], object] = main,
    stdout: int | None = None,
    stderr: int | None = None,
    file_size: int = resource.RLIM_INFINITY,
    memory: int = resource.RLIM_INFINITY,
    **variables: str,
) -> Done:
    """A command in a copy of this process that has the streams, signals, variables and limits of a
    new one, and imports nothing.

    Streams given, the others kept; its files limited, in bytes, and what it takes in
    memory beyond what is there. With `act` that is done instead. The exit code is minus the signal
    that ended it.
    """

    def as_a_process() -> None:
        os.chdir(folder)
        os.environ.update(environment(**variables))
        encoding = variables.get("PYTHONIOENCODING", "utf-8")
        no_input = os.open(os.devnull, os.O_RDONLY)
        for handle, number, name, mode in (
            (no_input, 0, "stdin", "r"),
            (stdout or output_end, 1, "stdout", "w"),
            (stderr or errors_end, 2, "stderr", "w"),
        ):
            os.dup2(handle, number)
            setattr(sys, name, os.fdopen(number, mode, encoding=encoding, closefd=False))
        for sent in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(
                sent, signal.default_int_handler if sent == signal.SIGINT else signal.SIG_DFL
            )
        signal.alarm(600)
        # Python keeps a compiled module cut off by the limit, and every later import of it fails.
        sys.dont_write_bytecode = True
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
        if memory != resource.RLIM_INFINITY:
            used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (used + memory, used + memory))
        sys.argv = ["halfplane", *map(os.fsdecode, words)]
        code = act()
        sys.stdout.flush()
        sys.exit(code if isinstance(code, int) else 0)

    # Pipes: a limit on files must not hold for the sentence that says so.
    output, output_end = os.pipe()
    errors, errors_end = os.pipe()
    number = child(as_a_process)
    os.close(output_end)
    os.close(errors_end)
    with ThreadPoolExecutor(2) as readers:
        texts = list(readers.map(text_of_pipe, (output, errors)))
    return Done(os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]), *texts)


def text_of_pipe(end: int) -> str:
    """All that is written into a pipe until its writers have closed it."""
    with os.fdopen(end, "rb") as stream:
        return stream.read().decode()


def child(act: Callable[[], object]) -> int:
    """The number of a copy of this process that does `act` and ends with its exit code, 1 where
    something was raised.
    """
    with warnings.catch_warnings():
        # of a fork beside the threads of pytest's own workers
        warnings.simplefilter("ignore", DeprecationWarning)
        number = os.fork()
    if number:
        return number
    code: object = 1
    try:
        act()
        code = 0
    except SystemExit as end:
        code = end.code or 0
    except BaseException:  # noqa: BLE001 (nothing may run on in the copy)
        traceback.print_exc()
    finally:
        with contextlib.suppress(Exception):
            sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)


def start(
    folder: Path,
    *words: str,
    program: tuple[str, ...] = ("-m", "reports"),
    session: bool = False,
    **how: Any,
) -> subprocess.Popen[str]:
    """A command as a process, its streams kept unless `how` says where they go, with variables that
    are named in capitals.

    With `session` in a session of its own, so that its workers can be killed with it.
    """
    variables = {name: how.pop(name) for name in list(how) if name.isupper()}
    streams = {
        "stdin": subprocess.DEVNULL,
        "stdout": subprocess.PIPE,
        "stderr": subprocess.PIPE,
        "text": True,
    } | how
    command = [sys.executable, *program, *words]
    return subprocess.Popen(
        command, cwd=folder, env=environment(**variables), start_new_session=session, **streams
    )


def json_of(path: Path) -> Any:
    """What a JSON file holds."""
    return json.loads(path.read_text(encoding="utf-8"))


def everything(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


def sentence(outcome: Done) -> str:
    """The one line of a refusal."""
    assert outcome.returncode == 2, outcome
    assert not outcome.stdout
    (line,) = outcome.stderr.splitlines()
    assert line.startswith("halfplane: ")
    return line


def refused(folder: Path, *words: str) -> str:
    """The one sentence on stderr of a command that must end with 2, print nothing else and leave no
    new file.
    """
    before = everything(folder)
    line = sentence(halfplane(folder, *words))
    assert everything(folder) == before
    return line


def answer_schema() -> dict[str, Any]:
    """The JSON schema of every answer: the envelope, and for each command what `result` holds."""
    schema: dict[str, Any] = json.loads(
        (resources.files("reports") / "templates" / "answer.schema.json").read_text("utf-8")
    )
    return schema


@cache
def answer_validator() -> Any:
    """Made once: to check the schema itself takes longer than a command."""
    schema = answer_schema()
    return jsonschema.validators.validator_for(schema)(schema)


def require_schema(document: Any) -> None:
    """The document is an answer as the schema has it."""
    answer_validator().validate(document)


def answer_of(outcome: Done, *words: str) -> tuple[int, dict[str, Any]]:
    """Exit code of a command with --json, and what the document that is its whole stdout holds as
    `result`.
    """
    document = json.loads(outcome.stdout)
    require_schema(document)
    assert (document["format"], document["exit_code"]) == (FORMAT, outcome.returncode)
    assert " ".join(words).startswith(document["command"])
    return outcome.returncode, document["result"]


def raising(fault: BaseException) -> Callable[..., None]:
    """What takes the place of a function that must fail."""

    def act(*_: object, **__: object) -> None:
        raise fault

    return act
