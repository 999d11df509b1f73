"""What the terminal shows: stages with progress on stderr, tables on stdout. Plain lines where
there is no terminal.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from contextlib import contextmanager
from typing import Literal, NamedTuple, TypeAlias

from rich.cells import cell_len
from rich.console import Console as _RichConsole
from rich.table import Table
from rich.text import Text

_Report = Callable[[int, int | None, str], None]

# Without a terminal a line of progress every so many seconds: enough to see life in a log, not
# enough to fill it.
_LINE_EVERY = 2.0
# Seconds after which the first twentieth of a part is enough to foretell the rest.
_FORETOLD = 60.0


class Console(_RichConsole):
    """Rich's console; a reader that has gone away is an error for the outermost door, which knows
    the exit code.
    """

    def on_broken_pipe(self) -> None:
        """Raise what rich would end the program for."""
        raise BrokenPipeError


class TimeLeft:
    """How long the rest of a part takes if it goes on as it began; a part is one count from 0 to
    its total: a revolution.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._start = clock()
        self._count = 0
        self._total = 0

    def words(self, count: int, total: int | None) -> str:
        """How long a part of a job will still take, in words ("9 s left"), after `count` of `total`
        steps. Empty while too few steps are done to foretell it, or where `total` is None.

        >>> clock = iter([0.0, 0.0, 3.0]).__next__
        >>> left = TimeLeft(clock)
        >>> left.words(0, 4), left.words(1, 4)
        ('', '9 s left')
        """
        now = self._clock()
        if total is None or count < self._count or total != self._total or not count:
            self._start = now
        self._count = count
        self._total = total or 0
        elapsed = now - self._start
        if not count or not total or elapsed <= 0:
            return ""
        # The first steps of a part are no measure of the rest: for a work of one minute they
        # foretold 23.
        if 20 * count < total and elapsed < _FORETOLD:
            return ""
        seconds_left = elapsed / count * (total - count)
        if seconds_left < 100:
            return f"{seconds_left:.0f} s left"
        return f"{seconds_left / 60:.0f} min left"


class Stages:
    """Runs the stages of a job one after the other, shows each, and keeps their wall times in
    `seconds`, every line in `log`.
    """

    def __init__(self, quiet: bool = False) -> None:
        self.console = Console(stderr=True, quiet=quiet, highlight=False, soft_wrap=True)
        self.seconds: dict[str, float] = {}
        self.log: list[str] = []

    @contextmanager
    def stage(self, name: str, steps_noun: str = "stretches") -> Generator[_Report, None, None]:
        """Run a stage of a job: time it, show its progress, log it. Yields report(count, total or
        None, text), which the stage calls with the number of steps that are done.

        Parameters
        ----------
        steps_noun
            what the steps are, for the terminal
        """
        start = time.perf_counter()
        self.note(f"{name} ...")
        progress_display = (
            self._progress_bar(name) if self.console.is_terminal else self._lines(name, steps_noun)
        )
        last_text = ""

        with progress_display as show:

            def report(count: int, total: int | None, text: str) -> None:
                """Shows every step; the last one of a total goes into the log too."""
                nonlocal last_text
                if total and count == total and text != last_text:
                    last_text = text
                    self.note(f"  {text}")
                show(count, total, text)

            yield report
        self.seconds[name] = time.perf_counter() - start
        self.note(f"{name}: {self.seconds[name]:.2f} s")
        self.console.print(Text(f"{name}: {self.seconds[name]:.2f} s"))

    def remark(self, text: str) -> None:
        """A line on stderr and of the log."""
        self.note(text)
        self.console.print(Text(text))

    def note(self, text: str) -> None:
        """A line of the log, with the time of the day."""
        self.log.append(f"{time.strftime('%H:%M:%S')}  {text}")

    @contextmanager
    def _progress_bar(self, name: str) -> Generator[_Report, None, None]:
        """Show the progress of a stage on a terminal, as a bar that vanishes at the end. Yields
        report(count, total, text), which the stage calls with the number of steps done, how many
        there are, and what it is at.
        """
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
        )

        columns = (
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
        )
        time_left = TimeLeft()
        with Progress(*columns, console=self.console, transient=True) as progress:
            task = progress.add_task(name, total=None)

            def report(count: int, total: int | None, text: str) -> None:
                from rich.markup import escape

                progress_in_words = ", ".join(filter(None, (text, time_left.words(count, total))))
                progress.update(
                    task,
                    completed=count,
                    total=total,
                    description=escape(f"{name}: {progress_in_words}"),
                )

            yield report

    @contextmanager
    def _lines(self, name: str, steps_noun: str) -> Generator[_Report, None, None]:
        """Show the progress of a stage where output goes to a file or a pipe: a line now and then
        with the steps done and the time left. Yields report(count, total, text), which the stage
        calls after each step. `steps_noun` says what the steps are.
        """
        time_of_last_line = time.perf_counter()
        time_left = TimeLeft()
        self.console.print(Text(f"{name} ..."))

        def report(count: int, total: int | None, text: str) -> None:
            nonlocal time_of_last_line
            words_on_time_left = time_left.words(count, total)
            if time.perf_counter() - time_of_last_line >= _LINE_EVERY:
                time_of_last_line = time.perf_counter()
                steps_in_words = f"{count} of {total} {steps_noun}" if total else ""
                phrases = ", ".join(filter(None, (text, steps_in_words, words_on_time_left)))
                self.console.print(Text(f"  {name}: {phrases}"))

        yield report


class Sheet(NamedTuple):
    """A table for the terminal; columns whose numbers are in `right` are set flush right."""

    title: str
    columns: Sequence[str]
    rows: Iterable[Sequence[str]]
    right: Sequence[int] = ()


# A line, a line with its style, or a table.
Part: TypeAlias = str | tuple[str, str] | Sheet


def show(parts: Iterable[Part]) -> None:
    """Lines and tables on stdout."""
    for part in parts:
        if isinstance(part, Sheet):
            show_table(*part)
        elif isinstance(part, str):
            say(part)
        else:
            say(*part)


def show_table(
    title: str,
    columns: Sequence[str],
    rows: Iterable[Sequence[str]],
    flush_right: Sequence[int] = (),
) -> None:
    """Print a table on stdout, so narrow that no word is broken where the terminal is wide enough.

    Parameters
    ----------
    columns
        heads of the columns
    rows
        cells, as many as columns
    flush_right
        numbers of the columns, from 0 on, that are set flush right
    """
    console = Console(highlight=False)
    table_rows = [list(row) for row in rows]
    layout = _layout([columns, *table_rows], console.width)
    table = Table(
        title=Text(_printable(title)),
        title_justify="left",
        title_style="bold",
        pad_edge=False,
        padding=(0, layout.blanks),
        show_edge=layout.has_outer_rules,
    )
    widths: Sequence[int | None] = layout.widths or [None] * len(columns)
    for column_number, (head, column_width) in enumerate(zip(columns, widths, strict=True)):
        justify: Literal["right", "left"] = "right" if column_number in flush_right else "left"
        table.add_column(head, justify=justify, overflow="fold", width=column_width)
    for row in table_rows:
        cells_of_row = map(_wrapped, row, widths)
        table.add_row(*map(_coloured, cells_of_row))
    console.print(table)


class _Layout(NamedTuple):
    """How wide a table for the terminal is drawn.

    `blanks` is the number of blanks on both sides of a rule between columns; `widths` are those of
    the columns, empty where there is no room without breaking words.
    """

    blanks: int
    has_outer_rules: bool
    widths: list[int]


def _layout(rows: Sequence[Sequence[str]], total_width: int) -> _Layout:
    """The most generous layout of a table, heads among its `rows`, in which no cell takes a second
    line within `total_width`; where none is wide enough, the one with the fewest lines.

    >>> _layout([("a head", "b"), ("12 words", "c")], 12)
    _Layout(blanks=0, has_outer_rules=True, widths=[8, 1])
    >>> _layout([("a head", "b"), ("12 words", "c")], 10)
    _Layout(blanks=0, has_outer_rules=False, widths=[8, 1])
    """
    n_columns = len(rows[0])
    rules_between = n_columns - 1
    layouts = []
    for blanks, outer_rules in ((1, 2), (0, 2), (0, 0)):
        taken = rules_between * (1 + 2 * blanks) + outer_rules
        widths = _widths(rows, total_width - taken)
        if widths:
            layouts.append(_Layout(blanks, bool(outer_rules), widths))
    if not layouts:
        return _Layout(1, True, [])
    return min(layouts, key=lambda layout: _line_count(rows, layout.widths))


def _line_count(rows: Iterable[Sequence[str]], widths: Sequence[int]) -> int:
    """Lines that the rows of a table take, each as many as its longest cell, wrapped."""
    return sum(
        max(1 + _wrapped(cell, width).count("\n") for cell, width in zip(row, widths, strict=True))
        for row in rows
    )


def _widths(rows: Sequence[Sequence[str]], total_width: int) -> list[int]:
    """Widths of the columns of a table in which no word is broken; `rows` are its rows,
    `total_width` is the width of all its cells together. Empty where there is no room for that.

    >>> (
    ...     _widths([("a long head", "b"), ("word", "c")], 80),
    ...     _widths([("a long head", "two words")], 12),
    ...     _widths([("words",)], 4),
    ... )
    ([11, 1], [6, 6], [])
    """
    columns = list(zip(*rows, strict=True))
    full_widths = [max(map(_width_of, column)) for column in columns]
    if sum(full_widths) <= total_width:
        return full_widths
    widths = [_longest_word(column) for column in columns]
    if sum(widths) > total_width:
        return []
    while width_left := total_width - sum(widths):
        narrow_columns = [
            column_number
            for column_number, width in enumerate(widths)
            if width < full_widths[column_number]
        ]
        for column_number in narrow_columns[:width_left]:
            widths[column_number] += 1
    return widths


def _width_of(cell: str) -> int:
    """Places of the terminal that the text of a cell takes."""
    return cell_len(_printable(cell))


def _longest_word(column: Iterable[str]) -> int:
    """Cells of the terminal that the longest word of a column takes, "± 12 %" being one word."""
    words = [word for cell in column for word in _words(_printable(cell))]
    return max(map(cell_len, words), default=0)


def _words(cell: str) -> list[str]:
    """Words of a cell, an uncertainty with its signs being one.

    >>> _words("-56 ± 74 % of a")
    ['-56', '± 74 %', 'of', 'a']
    """
    joined_text = cell.replace(" %", "\N{NO-BREAK SPACE}%").replace("± ", "±\N{NO-BREAK SPACE}")
    words = joined_text.split(" ")
    return [word.replace("\N{NO-BREAK SPACE}", " ") for word in words]


def _wrapped(cell: str, width: int | None) -> str:
    """A cell in lines of at most `width`, broken between its words; as it is where no width is
    known.

    >>> _wrapped("-56 ± 74 %", 8)
    '-56\\n± 74 %'
    """
    if width is None or "\n" in cell or _width_of(cell) <= width:
        return cell
    lines = [""]
    for word in _words(cell):
        longer_line = f"{lines[-1]} {word}".lstrip()
        if cell_len(longer_line) <= width:
            lines[-1] = longer_line
        else:
            lines.append(word)
    return "\n".join(lines).lstrip("\n")


def _coloured(cell: str) -> Text:
    """A cell of a table as text for the terminal: green, red or yellow where it is a verdict such
    as "within" or "no", as it is otherwise. Brackets are no mark-up.
    """
    style = {
        "within": "green",
        "yes": "green",
        "outside": "bold red",
        "no": "bold red",
        "undecided": "bold yellow",
    }.get(cell, "")
    return Text(_printable(cell), style=style)


def _printable(text: str) -> str:
    """A text from a file with its control characters as escapes: it must not steer the terminal."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def say(text: str, style: str = "") -> None:
    """A line on stdout, taken literally and never broken; `style` where the terminal has
    colours.
    """
    Console(highlight=False, soft_wrap=True).print(Text(_printable(text), style=style))


def complain(text: str) -> None:
    """A line on stderr, taken literally and never broken."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(Text(_printable(text)))


def width() -> int:
    """Columns of stdout; 100 where it is no terminal and COLUMNS does not say."""
    console = Console()
    return console.width if console.is_terminal or "COLUMNS" in os.environ else 100
