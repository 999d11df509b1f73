"""The command `halfplane` as the tests call it: in this process, or as a process of its own where the process is the matter."""

from __future__ import annotations

import contextlib
import io
import os
import resource
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from reports.cli import main

ROOT = Path(__file__).parents[1]
# The coarsest mesh and steps that still go through both engines: a second, and far outside every tolerance.
COARSE = ("--order", "1", "--element-size", "0.25", "--edge-element-size", "0.25", "--steps-per-cycle", "8")


@dataclass(frozen=True)
class Done:
    """What became of a command: exit code and streams."""

    returncode: int
    stdout: str
    stderr: str


def environment(**own: str) -> dict[str, str]:
    """This checkout on the path, whether it is installed or not; tables so wide that no line is broken."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return os.environ | {"PYTHONPATH": path, "COLUMNS": "400", "NO_COLOR": "1"} | own


def halfplane(folder: Path, *words: str, **own: str) -> Done:
    """A command in this process, its current folder `folder`, with variables of its own."""
    out, errors = io.StringIO(), io.StringIO()
    streams = (contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors))
    with contextlib.chdir(folder), mock.patch.dict(os.environ, environment(**own)), streams[0], streams[1]:
        code = main(list(words))
    return Done(code, out.getvalue(), errors.getvalue())


def start(
    folder: Path,
    *words: str | bytes,
    program: tuple[str, ...] = ("-m", "reports"),
    stdout: int = subprocess.PIPE,
    stderr: int = subprocess.PIPE,
    closed: bool = False,
    file_size: int = resource.RLIM_INFINITY,
    memory: int = resource.RLIM_INFINITY,
    session: bool = False,
    **own: str,
) -> subprocess.Popen[str]:
    """A command as a process: streams of its own or closed, its files and its address space limited, in bytes; `own` variables.

    With `session` in a session of its own, so that its workers can be killed with it.
    """

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
        for handle in range(3) if closed else ():
            os.close(handle)

    streams = {"stdin": subprocess.DEVNULL, "stdout": stdout, "stderr": stderr, "text": True}
    how = {"cwd": folder, "env": environment(**own), "preexec_fn": prepare, "start_new_session": session}
    return subprocess.Popen([sys.executable, *program, *words], **streams, **how)


def process(folder: Path, *words: str | bytes, **how: Any) -> Done:
    """What became of a command as a process, started as `start` does."""
    with start(folder, *words, **how) as running:
        try:
            out, errors = running.communicate(timeout=300)
        except subprocess.TimeoutExpired:
            running.kill()
            raise
    return Done(running.returncode, out, errors)


def everything(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")}


def sentence(done: Done) -> str:
    """The one line of a refusal."""
    assert done.returncode == 2, done
    assert not done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith("halfplane: ")
    return line


def refused(folder: Path, *words: str) -> str:
    """The one sentence on stderr of a command that must end with 2, print nothing else and leave no new file."""
    before = everything(folder)
    line = sentence(halfplane(folder, *words))
    assert everything(folder) == before
    return line


def raising(fault: BaseException) -> Callable[..., None]:
    """What takes the place of a function that must fail."""

    def act(*_: object, **__: object) -> None:
        raise fault

    return act
