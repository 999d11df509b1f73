"""The examples of a page, run: code blocks in order, in one empty folder, with one namespace.

    python docs/executed.py PAGE.md ...      (part of `make pages`)

- a `python` block runs; a `text` block right behind it is what it prints
- a `console` block runs: `$ halfplane ...` lines are commands, the lines below each are what it
  prints (no lines: not compared); `# ends with N` at the end of a command is its exit code
- a `{code-block}` with a `:caption:` is a file of that name, there for the blocks behind it
- pictures that a block saves as SVG are kept in docs/figures

Running gives the page again, with what was really printed: where that is another page, the page is
stale.
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
from pathlib import Path
from typing import Any
from unittest import mock

from reports import cli

FOLDER = Path(__file__).parent
FIGURES = FOLDER / "figures"
OPTIONS = r"(?P<options>(?::\w+:[^\n]*\n)*)"
FENCE = re.compile(
    rf"^```(?P<directive>\{{code-block\}} )?(?P<language>\w+)\n{OPTIONS}(?P<body>.*?)^```$",
    re.M | re.S,
)
# Of the pictures that pages draw by matplotlib; the salt and no date: the same numbers give the
# same file.
STYLE = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "figure.facecolor": "white",
    "figure.dpi": 100,
    "savefig.bbox": "tight",
    "svg.fonttype": "none",
    "svg.hashsalt": "halfplane",
}
LIMIT = 120


class StaleError(Exception):
    """A command of a page ended with another exit code than 0 without saying so."""


def run(text: str, folder: Path) -> str:
    """The page with what its blocks print when they are run in `folder`; pictures are left
    there.
    """
    names: dict[str, Any] = {}
    pieces: list[str] = []
    position = 0  # the end of what was taken
    printed = None  # by the Python block before
    with ready(folder):
        for block in FENCE.finditer(text):
            language = block["language"]
            body = block["body"]
            new_body = body
            between = re.sub(r"[\s`]", "", text[position : block.start()])
            if language == "text" and printed is not None and not between:
                new_body = printed
            printed = None
            caption = re.search(r"^:caption: (\S+)$", block["options"], re.M)
            if block["directive"] and caption:
                (folder / caption[1]).write_text(body.lstrip("\n"), encoding="utf-8")
            elif language == "python":
                with contextlib.redirect_stdout(io.StringIO()) as out:
                    exec(compile(body, "a page", "exec"), names)
                printed = out.getvalue()
            elif language == "console":
                new_body = console(body, folder)
            pieces += [text[position : block.start("body")], new_body]
            position = block.end("body")
    return "".join([*pieces, text[position:]])


def console(body: str, folder: Path) -> str:
    """`$ command` lines with what they print."""
    lines: list[str] = []
    for part in re.split(r"^(?=\$ )", body, flags=re.M):
        command, _, old_output = part.partition("\n")
        if not command.startswith("$ "):
            lines.append(part)
            continue
        program, *words = shlex.split(command[2:], comments=True)
        expected = re.search(r"# ends with (\d)$", command)
        code, out, errors = ended(program, words, folder)
        if code != (int(expected[1]) if expected else 0):
            raise StaleError(f"{command[2:]} ended with {code}: {out}{errors}")
        output = old_output
        if old_output.strip():
            output = "".join(f"{line.rstrip()}\n" for line in out.splitlines())
        lines.append(f"{command}\n{output}")
    return "".join(lines)


def ended(program: str, words: list[str], folder: Path) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command; `halfplane` in this process, which has imported
    it.
    """
    terminal = {"COLUMNS": "120", "NO_COLOR": "1"}
    if program != "halfplane":
        process = subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            env=os.environ | terminal,
            capture_output=True,
            text=True,
            timeout=LIMIT,
            check=False,
        )
        return process.returncode, process.stdout, process.stderr
    out = io.StringIO()
    errors = io.StringIO()
    with (
        mock.patch.dict(os.environ, terminal),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(errors),
    ):
        code = cli.main(words)
    return code, out.getvalue(), errors.getvalue()


@contextlib.contextmanager
def ready(folder: Path) -> Iterator[None]:
    """The folder as the current one, pictures in the project's style, without dates, and closed
    afterwards.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    undated = mock.patch.dict(os.environ, SOURCE_DATE_EPOCH="0")
    with undated, contextlib.chdir(folder), mpl.rc_context(STYLE):
        yield
    pyplot.close("all")


def runnable(text: str) -> bool:
    """Whether a page has anything to run."""
    return any(block["language"] in {"python", "console"} for block in FENCE.finditer(text))


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
