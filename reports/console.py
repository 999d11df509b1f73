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

# Least time between two lines of progress in a file or a pipe [s]: a log shows progress and stays
# short.
_SECONDS_BETWEEN_LINES = 2.0
# The time left is estimated after a twentieth of the steps, or after this time [s].
_SECONDS_OF_SLOW_START = 60.0


class Console(_RichConsole):
    """Rich's console. If the reader of the output has ended, BrokenPipeError is raised, for the
    command line to choose the exit code.
    """

    def on_broken_pipe(self) -> None:
        """Raise the error; rich itself would end the program."""
        raise BrokenPipeError


class TimeLeft:
    """Estimates the time that the remaining steps of a stage take, if they are as fast as those
    before. A stage may count several times from 0 to a total, once for each revolution.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._start = clock()
        self._n_done = 0
        self._total = 0

    def words(self, n_done: int, total: int | None) -> str:
        """Time that the remaining steps take, in words ("9 s left"), after `n_done` of `total`
        steps. Empty while too few steps are done for an estimate, or where `total` is None.

        >>> clock = iter([0.0, 0.0, 3.0]).__next__
        >>> left = TimeLeft(clock)
        >>> left.words(0, 4), left.words(1, 4)
        ('', '9 s left')
        """
        present_time = self._clock()  # seconds
        # another series of steps has begun
        if total is None or n_done < self._n_done or total != self._total or not n_done:
            self._start = present_time
        self._n_done = n_done
        self._total = total or 0
        elapsed_seconds = present_time - self._start
        if not n_done or not total or elapsed_seconds <= 0:
            return ""
        # The first steps are slower: in a stage of one minute they gave an estimate of 23 minutes.
        # _SECONDS_OF_SLOW_START: 60 s
        if 20 * n_done < total and elapsed_seconds < _SECONDS_OF_SLOW_START:
            return ""
        seconds_left = elapsed_seconds / n_done * (total - n_done)
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
        """A context for one stage of a job: its time is measured, its progress shown and logged.

        Yields report(n_done, total or None, text), to be called with the number of steps that are
        done.

        Parameters
        ----------
        name
            of the stage
        steps_noun
            what the steps are, for messages
        """
        start = time.perf_counter()
        self.note(f"{name} ...")
        # A bar on a terminal, else a line every two seconds; `show_step` displays one step.
        progress_display = (
            self._progress_bar(name)
            if self.console.is_terminal
            else self._progress_lines(name, steps_noun)
        )
        last_text = ""

        with progress_display as show_step:

            def report(n_done: int, total: int | None, text: str) -> None:
                """Show a step; the last step of a total goes into the log too."""
                nonlocal last_text
                if total and n_done == total and text != last_text:
                    last_text = text
                    self.note(f"  {text}")
                show_step(n_done, total, text)

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
        """A context that shows the progress of a stage called `name` on a terminal, as a bar that
        vanishes at the end. Yields report(n_done, total or None, text): steps done, number of
        steps, present step.
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

            def report(n_done: int, total: int | None, text: str) -> None:
                """Show a step: how many are done, of how many (None: unknown), and the present one
                in words.
                """
                from rich.markup import escape

                progress_in_words = ", ".join(filter(None, (text, time_left.words(n_done, total))))
                progress.update(
                    task,
                    completed=n_done,
                    total=total,
                    description=escape(f"{name}: {progress_in_words}"),
                )

            yield report

    @contextmanager
    def _progress_lines(self, name: str, steps_noun: str) -> Generator[_Report, None, None]:
        """A context that shows the progress of a stage called `name` where output goes to a file or
        a pipe: a line every two seconds with steps done and time left. Yields report(n_done, total
        or None, text), to be called after each step. `steps_noun` says what the steps are.
        """
        time_of_last_line = time.perf_counter()
        time_left = TimeLeft()
        self.console.print(Text(f"{name} ..."))

        def report(n_done: int, total: int | None, text: str) -> None:
            """Print a line, unless the last one is less than two seconds old: how many steps are
            done, of how many (None: unknown), and the present one in words.
            """
            nonlocal time_of_last_line
            words_on_time_left = time_left.words(n_done, total)
            # _SECONDS_BETWEEN_LINES: 2 s
            if time.perf_counter() - time_of_last_line >= _SECONDS_BETWEEN_LINES:
                time_of_last_line = time.perf_counter()
                steps_in_words = f"{n_done} of {total} {steps_noun}" if total else ""
                phrases = ", ".join(filter(None, (text, steps_in_words, words_on_time_left)))
                self.console.print(Text(f"  {name}: {phrases}"))

        yield report


class Sheet(NamedTuple):
    """A table for the terminal."""

    title: str
    heads: Sequence[str]  # of the columns
    rows: Iterable[Sequence[str]]  # cells, as many as heads
    right_columns: Sequence[int] = ()  # indices of the columns that are set flush right


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
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    right_columns: Sequence[int] = (),
) -> None:
    """Print a table under its `title` on stdout. No word is broken if the terminal is wide enough.

    Parameters
    ----------
    heads
        of the columns
    rows
        cells, as many as heads
    right_columns
        indices of the columns that are aligned to the right
    """
    console = Console(highlight=False)
    table_rows = [list(row) for row in rows]
    # Blanks beside the rules (strokes between columns), whether there are outer rules, and
    # widths of the columns. `_printable_text`: control characters as escapes.
    layout = _layout([heads, *table_rows], console.width)
    table = Table(
        title=Text(_printable_text(title)),
        title_justify="left",
        title_style="bold",
        pad_edge=False,
        padding=(0, layout.blanks),
        show_edge=layout.has_outer_rules,
    )
    widths: Sequence[int | None] = layout.widths or [None] * len(heads)
    for column_number, (head, column_width) in enumerate(zip(heads, widths, strict=True)):
        justify: Literal["right", "left"] = "right" if column_number in right_columns else "left"
        table.add_column(head, justify=justify, overflow="fold", width=column_width)

    # Cells in lines of the column's width; words such as "within" have a colour.
    for row in table_rows:
        cells_of_row = map(_wrapped_cell, row, widths)
        table.add_row(*map(_coloured_cell, cells_of_row))
    console.print(table)


class _Layout(NamedTuple):
    """Widths of a table for the terminal."""

    blanks: int  # on both sides of a rule (a vertical line) between columns
    has_outer_rules: bool  # whether there is a rule at the left and the right end
    widths: list[int]  # of the columns; empty where words have to be broken


def _layout(rows: Sequence[Sequence[str]], total_width: int) -> _Layout:
    """The layout of a table within `total_width`, its first row being the heads, its rules the
    vertical strokes between columns and at both ends: the widest in which no cell needs a second
    line. Where there is none, the layout with the fewest lines; one whose `widths` are empty where
    words would have to be broken in each.

    >>> _layout([("a head", "b"), ("12 words", "c")], 12)
    _Layout(blanks=0, has_outer_rules=True, widths=[8, 1])
    >>> _layout([("a head", "b"), ("12 words", "c")], 10)
    _Layout(blanks=0, has_outer_rules=False, widths=[8, 1])
    """
    n_columns = len(rows[0])
    n_rules_between_columns = n_columns - 1
    layouts = []
    # From the widest layout to the narrowest: with blanks, without, without outer rules.
    for blanks, n_outer_rules in ((1, 2), (0, 2), (0, 0)):
        width_of_rules = n_rules_between_columns * (1 + 2 * blanks) + n_outer_rules
        # Widths in which no word is broken; none where there is no room.
        widths = _column_widths(rows, total_width - width_of_rules)
        if widths:
            layouts.append(_Layout(blanks, bool(n_outer_rules), widths))
    if not layouts:
        return _Layout(1, True, [])
    # `_n_lines`: lines that the rows take with these widths.
    return min(layouts, key=lambda layout: _n_lines(rows, layout.widths))


def _n_lines(rows: Iterable[Sequence[str]], widths: Sequence[int]) -> int:
    """Lines that the rows of a table take, each as many as its longest cell, wrapped."""
    return sum(
        max(
            1 + _wrapped_cell(cell, width).count("\n")
            for cell, width in zip(row, widths, strict=True)
        )
        for row in rows
    )


def _column_widths(rows: Sequence[Sequence[str]], total_width: int) -> list[int]:
    """Widths of the columns of a table (`rows`, the first its heads) in which no word is broken,
    `total_width` being the sum of all widths. Empty where there is no room for that.

    >>> (
    ...     _column_widths([("a long head", "b"), ("word", "c")], 80),
    ...     _column_widths([("a long head", "two words")], 12),
    ...     _column_widths([("words",)], 4),
    ... )
    ([11, 1], [6, 6], [])
    """
    columns = list(zip(*rows, strict=True))
    # Width of the longest cell of each column; below, that of the longest word.
    full_widths = [max(map(_width_of, column)) for column in columns]
    if sum(full_widths) <= total_width:
        return full_widths
    widths = [_width_of_longest_word(column) for column in columns]
    if sum(widths) > total_width:
        return []
    # one character more for each column that is too narrow, until all free ones are used
    while n_free_characters := total_width - sum(widths):
        narrow_columns = [
            column_number
            for column_number, width in enumerate(widths)
            if width < full_widths[column_number]
        ]
        for column_number in narrow_columns[:n_free_characters]:
            widths[column_number] += 1
    return widths


def _width_of(cell: str) -> int:
    """Places of the terminal that the text of a cell takes."""
    return cell_len(_printable_text(cell))


def _width_of_longest_word(column: Iterable[str]) -> int:
    """Places of the terminal that the longest word of a column takes, "± 12 %" being one word."""
    words = [word for cell in column for word in _words(_printable_text(cell))]
    return max(map(cell_len, words), default=0)


def _words(cell: str) -> list[str]:
    """Words of a cell, an uncertainty with its signs being one.

    >>> _words("-56 ± 74 % of a")
    ['-56', '± 74 %', 'of', 'a']
    """
    joined_text = cell.replace(" %", "\N{NO-BREAK SPACE}%").replace("± ", "±\N{NO-BREAK SPACE}")
    words = joined_text.split(" ")
    return [word.replace("\N{NO-BREAK SPACE}", " ") for word in words]


def _wrapped_cell(cell: str, width: int | None) -> str:
    """A cell in lines of at most `width` places, broken between its words; unchanged where `width`
    is None.

    >>> _wrapped_cell("-56 ± 74 %", 8)
    '-56\\n± 74 %'
    """
    if width is None or "\n" in cell or _width_of(cell) <= width:
        return cell
    # `cell_len`: places of the terminal that a text takes.
    lines = [""]
    for word in _words(cell):
        longer_line = f"{lines[-1]} {word}".lstrip()
        if cell_len(longer_line) <= width:
            lines[-1] = longer_line
        else:
            lines.append(word)
    return "\n".join(lines).lstrip("\n")


def _coloured_cell(cell: str) -> Text:
    """A cell of a table as text for the terminal: green, red or yellow where it is a verdict such
    as "within" or "no", else without colour. Brackets in it are not read as mark-up.
    """
    style = {
        "within": "green",
        "yes": "green",
        "outside": "bold red",
        "no": "bold red",
        "undecided": "bold yellow",
    }.get(cell, "")
    # Control characters become visible escapes.
    return Text(_printable_text(cell), style=style)


def _printable_text(text: str) -> str:
    """A text from a file with its control characters as escapes: it must not steer the terminal."""
    return "".join(c if c.isprintable() or c in "\n\t" else ascii(c)[1:-1] for c in text)


def say(text: str, style: str = "") -> None:
    """A line on stdout, taken literally and never broken; `style` where the terminal has
    colours.
    """
    Console(highlight=False, soft_wrap=True).print(Text(_printable_text(text), style=style))


def complain(text: str) -> None:
    """A line on stderr, taken literally and never broken."""
    Console(stderr=True, highlight=False, soft_wrap=True).print(Text(_printable_text(text)))


def width() -> int:
    """Columns of stdout; 100 where it is no terminal and COLUMNS does not say."""
    console = Console()
    return console.width if console.is_terminal or "COLUMNS" in os.environ else 100
