"""The examples of a page, run: code blocks in order, in one empty folder, with one namespace.

    python docs/executed.py PAGE.md ...      (part of `make pages`)

- a `python` block runs; a `text` block right behind it is what it prints
- a `console` block runs: `$ halfplane ...` lines are commands, the lines below each are what it prints (no lines: not compared)
- a `{code-block}` with a `:caption:` is a file of that name, there for the blocks behind it
- pictures that a block saves as SVG are kept in docs/figures

Running gives the page again, with what was really printed: where that is another page, the page is stale.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).parent
FIGURES = FOLDER / "figures"
_FENCE = re.compile(
    r"^```(?P<directive>\{code-block\} )?(?P<language>\w+)\n(?P<options>(?::\w+:[^\n]*\n)*)(?P<body>.*?)^```$", re.M | re.S
)
_CAPTION = re.compile(r"^:caption: (?P<name>\S+)$", re.M)
_STYLE = {"svg.hashsalt": "halfplane", "svg.fonttype": "none", "figure.dpi": 100, "savefig.bbox": "tight"}
_LIMIT = 120


@dataclass(frozen=True)
class Block:
    """A fenced block: where its body stands in the page, its language, and the file that it is, if any."""

    language: str
    file: str
    body: str
    begin: int
    end: int


class StaleError(Exception):
    """A command of a page ended with another exit code than 0 without saying so."""


def blocks(text: str) -> list[Block]:
    """Every fenced block with a language, in order."""
    found = []
    for match in _FENCE.finditer(text):
        caption = _CAPTION.search(match["options"])
        file = caption["name"] if match["directive"] and caption else ""
        found.append(Block(match["language"], file, match["body"], match.start("body"), match.end("body")))
    return found


def run(text: str, folder: Path) -> str:
    """The page with what its blocks print when they are run in `folder`; pictures are left there."""
    pieces, done = [], 0
    with _ready(folder):
        for block, body in _results(text, folder):
            pieces += [text[done : block.begin], body]
            done = block.end
    return "".join([*pieces, text[done:]])


def _results(text: str, folder: Path) -> Iterator[tuple[Block, str]]:
    """Blocks whose body is an output, with the output."""
    names: dict[str, Any] = {}
    printed, behind = None, 0
    for block in blocks(text):
        if block.language == "text" and printed is not None and not re.sub(r"[\s`]|text", "", text[behind : block.begin]):
            yield block, printed
        printed, behind = None, block.end
        if block.file:
            (folder / block.file).write_text(block.body.lstrip("\n"), encoding="utf-8")
        elif block.language == "python":
            printed = _python(block.body, names)
        elif block.language == "console":
            yield block, _console(block.body, folder)


def _python(body: str, names: dict[str, Any]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(body, "a page", "exec"), names)
    return out.getvalue()


def _console(body: str, folder: Path) -> str:
    """`$ command` lines with what they print; `# ends with N` at the end of a command is its exit code."""
    lines: list[str] = []
    for part in re.split(r"^(?=\$ )", body, flags=re.M):
        if not part.startswith("$ "):
            lines.append(part)
            continue
        command, _, shown = part.partition("\n")
        expected = re.search(r"# ends with (\d)$", command)
        said = _command(shlex.split(command[2:], comments=True), folder, int(expected[1]) if expected else 0)
        lines.append(f"{command}\n{said if shown.strip() else shown}")
    return "".join(lines)


def _command(words: list[str], folder: Path, expected: int) -> str:
    program = {"halfplane": [sys.executable, "-m", "reports"], "python": [sys.executable]}[words[0]]
    environment = os.environ | {"COLUMNS": "120", "NO_COLOR": "1"}
    done = subprocess.run(
        [*program, *words[1:]], cwd=folder, env=environment, capture_output=True, text=True, timeout=_LIMIT, check=False
    )
    if done.returncode != expected:
        raise StaleError(f"{shlex.join(words)} ended with {done.returncode}: {done.stdout}{done.stderr}")
    return "\n".join(line.rstrip() for line in done.stdout.splitlines()) + "\n"


@contextlib.contextmanager
def _ready(folder: Path) -> Iterator[None]:
    """The folder as the current one, pictures in the project's style, without dates, and closed afterwards."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    from reports.charts.publication import STYLE

    before = os.environ.get("SOURCE_DATE_EPOCH")
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    try:
        with contextlib.chdir(folder), mpl.rc_context(STYLE | _STYLE):
            yield
    finally:
        pyplot.close("all")
        if before is None:
            del os.environ["SOURCE_DATE_EPOCH"]
        else:
            os.environ["SOURCE_DATE_EPOCH"] = before


def runnable(text: str) -> bool:
    """Whether a page has anything to run."""
    return any(block.language in {"python", "console"} for block in blocks(text))


def main(names: list[str]) -> int:
    """Run the pages (all, if none is named), write what they print and keep their pictures."""
    for path in [FOLDER / name for name in names] or sorted(FOLDER.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        if not runnable(text):
            continue
        with tempfile.TemporaryDirectory() as folder:
            now = run(text, Path(folder))
            for picture in Path(folder).glob("*.svg"):
                (FIGURES / picture.name).write_bytes(picture.read_bytes())
        if now != text:
            path.write_text(now, encoding="utf-8")
        print(f"{path.name}: {'written' if now != text else 'as it was'}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
