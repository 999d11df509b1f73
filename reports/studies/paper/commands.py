"""The command `halfplane paper`."""

from __future__ import annotations

from reports.cli.application import EXIT_OUTSIDE, EXIT_WITHIN, Answer, Options
from reports.console import Part, Sheet, Stages


def paper(options: Options) -> Answer:
    """The command `paper`: recompute the paper's figures, what it states in words, and its
    misprints, and write a page. Exit code 1 if a misprint is not proven.

    `options` are those of the command line: `out` is the folder for the results, `quiet` stands for
    no progress on stderr. Returns the exit code, tables and lines for the terminal, and the content
    of the JSON output.
    """
    from reports.folder import default_folder, usable_folder

    # compute, and write the page
    stages = Stages(options.quiet)
    folder = usable_folder(options.out or default_folder("paper"))
    with stages.stage("loading"):
        from reports.studies.paper import page
        from reports.studies.paper.tables import proven_in_words
    report = page.write(folder, stages, options.command("paper", "", folder))

    # for JSON: the rows of both tables (`statements`, `misprints`), and how many have each verdict
    code = EXIT_WITHIN if report.proven else EXIT_OUTSIDE  # exit codes 0 and 1
    verdicts = page.tally(report.statements)
    content = {
        "passed": code == EXIT_WITHIN,
        "verdicts": verdicts,
        "statements": [vars(statement) for statement in report.statements],
        "misprints": [vars(misprint) for misprint in report.misprints],
        "page": str(report.page),
        "seconds": stages.seconds,
    }

    # for the terminal: both tables, a summary, and the path of the page
    counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
    n_proven = sum(row.proven is True for row in report.misprints)
    heads_of_statements = ("statement", "where", "the paper", "computed", "verdict")
    rows_of_statements = [
        (row.key, row.where, row.words, row.computed, row.verdict.value)
        for row in report.statements
    ]
    heads_of_misprints = ("where", "printed", "right", "proof", "proven")
    rows_of_misprints = [
        (row.key, row.printed, row.right, row.proof, proven_in_words(row))
        for row in report.misprints
    ]
    summary = (
        f"{len(report.statements)} statements: {counts}; {len(report.misprints)} misprints:"
        f" {n_proven} proven by evaluation"
    )
    # Sheet: a table on the terminal, of title, heads and rows
    parts: list[Part] = [
        Sheet("What the paper states in words", heads_of_statements, rows_of_statements),
        Sheet("Misprints of the paper", heads_of_misprints, rows_of_misprints),
        summary,
        str(report.page),
    ]
    return Answer(code, parts, lambda: content)
