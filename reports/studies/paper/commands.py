"""The command `halfplane paper`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from reports.cli.application import EXIT_OUTSIDE, EXIT_WITHIN, Answer, Options
from reports.console import Part, Sheet, Stages

if TYPE_CHECKING:
    from reports.studies.paper.page import PaperReport
    from reports.studies.paper.tables import Misprint, Statement


def paper(options: Options) -> Answer:
    """The command `paper`: recompute the paper's figures, what it states in words, and its
    misprints, and write a page. Exit code 1 if a misprint is not proven.

    `options` are those of the command line: `out` is the folder for the results, `quiet` stands for
    no progress on stderr. Returns the exit code, tables and lines for the terminal, and the content
    of the JSON output.
    """
    from reports.folder import default_folder, usable_folder

    stages = Stages(options.quiet)
    folder = usable_folder(options.out or default_folder("paper"))
    with stages.stage("loading"):
        from reports.studies.paper.page import tally, write
    report = write(folder, stages, options.command("paper", "", folder))

    # exit codes 0 and 1
    code = EXIT_WITHIN if report.proven else EXIT_OUTSIDE
    content = {
        "passed": code == EXIT_WITHIN,
        "verdicts": tally(report.statements),
        "statements": [vars(statement) for statement in report.statements],
        "misprints": [vars(misprint) for misprint in report.misprints],
        "page": str(report.page),
        "seconds": stages.seconds,
    }
    parts: list[Part] = [
        _sheet_of_statements(report.statements),
        _sheet_of_misprints(report.misprints),
        _summary(report),
        str(report.page),
    ]
    return Answer(code, parts, lambda: content)


def _sheet_of_statements(statements: Sequence[Statement]) -> Sheet:
    """The table, for the terminal, of what the paper states in words: where, in which words, what
    was computed, and the verdict.
    """
    heads = ("statement", "where", "the paper", "computed", "verdict")
    rows = [(row.key, row.where, row.words, row.computed, row.verdict.value) for row in statements]
    # Sheet: title, heads and rows
    return Sheet("What the paper states in words", heads, rows)


def _sheet_of_misprints(misprints: Sequence[Misprint]) -> Sheet:
    """The table, for the terminal, of misprints of the paper: where, what is printed, what is
    right, the proof by evaluation, and whether it succeeded.
    """
    from reports.studies.paper.tables import proven_in_words

    heads = ("where", "printed", "right", "proof", "proven")
    rows = [(row.key, row.printed, row.right, row.proof, proven_in_words(row)) for row in misprints]
    # Sheet: title, heads and rows
    return Sheet("Misprints of the paper", heads, rows)


def _summary(report: PaperReport) -> str:
    """How many statements of the paper have each verdict, and how many of its misprints are
    proven.
    """
    from reports.studies.paper.page import tally

    counts = ", ".join(f"{count} {verdict}" for verdict, count in tally(report.statements).items())
    n_proven = sum(row.proven is True for row in report.misprints)
    return (
        f"{len(report.statements)} statements: {counts}; {len(report.misprints)} misprints:"
        f" {n_proven} proven by evaluation"
    )
