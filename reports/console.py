"""What the terminal shows: stages with progress on stderr, tables on stdout. Plain lines where there is no terminal."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.table import Table
from rich.text import Text

Report = Callable[[int, int | None, str], None]

# Without a terminal a line of progress every so many seconds: enough to see life in a log, not enough to fill it.
_LINE_EVERY = 2.0


class Stages:
    """Runs the stages of a job one after the other, shows each, and keeps their wall times in `seconds`."""

    def __init__(self, quiet: bool = False) -> None:
        self.console = Console(stderr=True, quiet=quiet, highlight=False)
        self.seconds: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Generator[Report, None, None]:
        """Times a stage; yields report(done, total or None, text)."""
        start = time.perf_counter()
        show = self._bar if self.console.is_terminal else self._lines
        with show(name) as report:
            yield report
        self.seconds[name] = time.perf_counter() - start
        self.console.print(Text(f"{name}: {self.seconds[name]:.2f} s"))

    @contextmanager
    def _bar(self, name: str) -> Generator[Report, None, None]:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=self.console, transient=True) as progress:
            task = progress.add_task(name, total=None)

            def report(done: int, total: int | None, text: str) -> None:
                from rich.markup import escape

                progress.update(task, completed=done, total=total, description=escape(f"{name}: {text}"))

            yield report

    @contextmanager
    def _lines(self, name: str) -> Generator[Report, None, None]:
        shown = time.perf_counter()
        self.console.print(Text(f"{name} ..."))

        def report(done: int, total: int | None, text: str) -> None:
            nonlocal shown
            if time.perf_counter() - shown >= _LINE_EVERY:
                shown = time.perf_counter()
                of = f" of {total}" if total else ""
                self.console.print(Text(f"  {name}: {text} {done}{of}"))

        yield report


def show_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], right: Sequence[int] = ()) -> None:
    """A table on stdout; columns whose numbers are in `right` are set flush right."""
    table = Table(title=title, title_justify="left", title_style="bold", pad_edge=False)
    for number, column in enumerate(columns):
        table.add_column(column, justify="right" if number in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(_coloured(cell) for cell in row))
    Console(highlight=False).print(table)


def _coloured(cell: str) -> Text:
    """Verdict words in colour, where the terminal has any; every cell taken literally, brackets and all."""
    style = {"within": "green", "yes": "green", "outside": "bold red", "no": "bold red"}.get(cell, "")
    return Text(cell, style=style)


def say(text: str) -> None:
    """A line on stdout, taken literally and never broken."""
    Console(highlight=False, soft_wrap=True).print(Text(text))


def complain(text: str) -> None:
    """A line on stderr, taken literally and never broken."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(Text(text))


def width() -> int:
    """Columns of stdout; 100 where it is no terminal and COLUMNS does not say."""
    console = Console()
    return console.width if console.is_terminal or "COLUMNS" in os.environ else 100
