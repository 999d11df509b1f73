"""The paper again from the engine: its figures, its statements with verdicts, its misprints with
their proofs, on one page.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from reports.charts.templating import script, table_text, template
from reports.console import Stages
from reports.folder import results_folder
from reports.studies.paper.cases import Paper, paper
from reports.studies.paper.figures import all_figures
from reports.studies.paper.misprints import prove_misprints
from reports.studies.paper.statements import judge_statements
from reports.studies.paper.tables import (
    PAPER_WORDS,
    Misprint,
    Statement,
    Verdict,
    as_columns,
    proven_in_words,
    table_row,
)

AUTHORS = "Davies, Barber and Hills"
SOURCE = (
    "“Energy dissipation in a frictional incomplete contact with varying normal load”,"
    " International Journal of Mechanical Sciences, doi:10.1016/j.ijmecsci.2011.11.006"
)


@dataclass(frozen=True)
class PaperReport:
    """What the command `halfplane paper` leaves: both tables and the path of the page."""

    statements: tuple[Statement, ...]
    misprints: tuple[Misprint, ...]
    page: Path

    @property
    def proven(self) -> bool:
        """Whether no misprint that can be evaluated failed to be proven."""
        return all(row.proven is not False for row in self.misprints)


def statements(examples: Paper) -> tuple[Statement, ...]:
    """Every statement of the paper, in the order of the file paper.toml, with its verdict and
    numbers. `examples` are the paper's two profiles, with their solutions.
    """
    verdict_by_key = judge_statements(examples)  # verdict and numbers, by key of the statement
    return tuple(
        table_row(Statement, words, verdict_by_key[words["key"]])
        for words in PAPER_WORDS["statement"]
    )


def misprints(examples: Paper) -> tuple[Misprint, ...]:
    """Every misprint of the paper, in the order of the file paper.toml, with its proof and numbers.
    `examples` are the paper's two profiles, with their solutions.
    """
    # whether a misprint is proven, and numbers, by its key
    proof_by_key = prove_misprints(examples)
    return tuple(
        table_row(Misprint, words, proof_by_key[words["key"]]) for words in PAPER_WORDS["misprint"]
    )


def tally(rows: Sequence[Statement]) -> dict[str, int]:
    """How many statements got each verdict."""
    counts = Counter(row.verdict.value for row in rows)
    return {verdict.value: counts[verdict.value] for verdict in Verdict}


def write(out: str | Path, stages: Stages, command: str = "halfplane paper") -> PaperReport:
    """Compute all that the project recomputes of the paper, and fill the folder `out`: a page,
    tables of the paper's statements and misprints as CSV, each figure as SVG and CSV. Returns the
    rows of both tables and the path of the page.

    `stages` shows and measures the stages of the job; `command`, the command that was run, is
    stated on the page.

    Raises
    ------
    InputError
        If the folder can't be written to.
    """
    examples = paper()  # the paper's two profiles, with their solutions
    with stages.stage("statements and misprints"):
        statement_rows = statements(examples)
        misprint_rows = misprints(examples)
    with stages.stage("figures"):
        figures = all_figures(examples)

    # a temporary folder, whose files move to `out` at the end
    with results_folder(out) as folder:
        statement_table = table_text(as_columns(statement_rows, "statement"))
        (folder / "statements.csv").write_text(statement_table, encoding="utf-8")
        misprint_table = table_text(as_columns(misprint_rows, "misprint"))
        (folder / "misprints.csv").write_text(misprint_table, encoding="utf-8")
        figure_folder = folder / "figures"
        figure_folder.mkdir()
        with stages.stage("SVG and CSV"):
            for figure in figures:
                svg_path = figure_folder / f"{figure.name}.svg"
                svg_path.write_text(figure.svg(), encoding="utf-8")
                csv_path = figure_folder / f"{figure.name}.csv"
                csv_path.write_text(figure.csv(), encoding="utf-8")
        with stages.stage("page"):
            # the script of the page, and its hash, which the page's security policy names
            page_script, script_hash = script()
            # AUTHORS, SOURCE: of the paper, as texts
            page_text = template("paper.html").render(
                authors=AUTHORS,
                source=SOURCE,
                figures=figures,
                statements=statement_rows,
                misprints=misprint_rows,
                tally=tally(statement_rows),
                proven=sum(row.proven is True for row in misprint_rows),
                by_reading=sum(row.proven is None for row in misprint_rows),
                proven_in_words=proven_in_words,
                script=page_script,
                script_hash=script_hash,
                command=command,
            )
            (folder / "report.html").write_text(page_text, encoding="utf-8")
    return PaperReport(statement_rows, misprint_rows, Path(out) / "report.html")
