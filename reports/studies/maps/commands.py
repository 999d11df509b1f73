"""The commands of the idealisation error: its maps, and advice on a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.application import EXIT_OUTSIDE, EXIT_WITHIN, Answer, Options, share_of
from reports.cli.solving import read
from reports.console import Part, Sheet, Stages

if TYPE_CHECKING:
    from reports.advising_by_kernels import KernelAdvice
    from reports.advising_by_numbers import Advice, Change
    from reports.studies.maps.families import Kind
    from reports.studies.maps.pages import Tables
    from scenes import Estimate, Scene

_MODEL_ITSELF = (
    "both bodies are half-planes of like materials (Dundurs' β is 0): half-plane theory is the very"
    " model"
)


def make_map(name: str, options: Options) -> Answer:
    """The command `map`: compute what is missing of a map of errors, write tables and pages, and
    show from which height of the bodies on half-plane theory holds.

    `name` is that of a kind of bodies, with one map each, or "all". Of the `options`, `out` is the
    folder, `pages` stands for pages alone without computing, `remake` for all points again. Returns
    exit code 0, a table for the terminal, and the content of the JSON output.
    """
    from reports.studies.maps.families import KINDS, kind_named
    from reports.studies.maps.pages import require_free, stored_maps, write

    folder = options.out or Path("out/maps")
    # KINDS: the kinds of bodies by name
    kinds = list(KINDS.values()) if name == "all" else [kind_named(name)]
    require_free(folder)  # InputError if a file of another program would be replaced
    if not options.pages:
        folder.mkdir(parents=True, exist_ok=True)
        stages = Stages(options.quiet)
        for kind in kinds:
            _complete_tables(kind, folder, stages, remakes=options.remake)

    # figures and pages of all maps in the folder; of those asked for, kind, errors and heights
    write(folder)
    shown_tables = [tables for tables in stored_maps(folder) if tables.kind in kinds]
    return _answer_of_maps(shown_tables, str(folder / "README.md"))


def _complete_tables(kind: Kind, folder: Path, stages: Stages, *, remakes: bool) -> None:
    """Compute what is missing of both tables of a map: errors of half-plane theory at its points,
    and heights of the bodies from which theory holds. `kind` is the kind of bodies that the map is
    for; both tables are CSV files of the `folder`. With `remakes` all points are computed again.
    """
    from reports.folder import replace_text
    from reports.studies.maps import pages
    from reports.studies.maps.errors import (
        compute_missing_rows,
        least_heights_of,
        rows_in,
        table_of_heights,
    )

    file_of_errors, file_of_heights = (folder / file for file in pages.table_names(kind))
    if remakes:
        file_of_errors.unlink(missing_ok=True)
    with stages.stage(kind.title, "points") as report_progress:
        has_new_rows = compute_missing_rows(kind, file_of_errors, report_progress)
        if has_new_rows or not file_of_heights.exists():
            least_heights = least_heights_of(kind, rows_in(file_of_errors), report_progress)
            replace_text(file_of_heights, table_of_heights(least_heights))


def _answer_of_maps(shown_tables: list[Tables], page: str) -> Answer:
    """The answer of the command `map`, with exit code 0: for the terminal a table of the least
    heights from which theory holds, and the path of the `page`; the same as JSON content.
    `shown_tables` are kind of bodies, errors and least heights of each map.
    """
    from reports.studies.maps import pages

    def terminal_output() -> Iterator[Part]:
        """What the terminal shows: the table of least heights, and the path of the page."""
        title = "height/a from which theory is within 1; 5; 10 %"
        # Sheet: a table on the terminal, of title, heads and rows
        yield Sheet(title, pages.HEADS_OF_HEIGHTS, pages.rows_of_heights(shown_tables))
        yield page

    def content() -> dict[str, Any]:
        """The content of the JSON output."""
        heights = {
            tables.kind.name: [row._asdict() for row in tables.least_heights]
            for tables in shown_tables
        }
        return {"passed": True, "heights": heights, "page": page}

    # EXIT_WITHIN: exit code 0
    return Answer(EXIT_WITHIN, terminal_output(), content)


def advise(scene: str, options: Options) -> Answer:
    """The command `advise`: how wrong half-plane theory is for the finite bodies of a scene, and
    why. Exit code 1 where the error of the dissipation may exceed the limit, or is not known.

    `scene` names a file or a scene of the library; `options.limit` is the error of the dissipation
    up to which theory may be used.
    """
    from reports import advising
    from reports.advising_by_numbers import Advice
    from reports.comparison.laws import Verdict
    from reports.comparison.pairs import are_half_planes
    from scenes import InputError

    limit = share_of(options.limit)  # 0.05 for "5%"
    if not 0 < limit < 1:
        raise InputError(
            f"--limit {options.limit} is refused: it is a share above 0 and below 1, such as 0.05"
            " for 5 %"
        )

    # Half-planes have no such error, as the sentence `_MODEL_ITSELF` states. Else the advice is by
    # elastic responses of the bodies, or by half-planes with their compliance (kernels).
    scene_read = read(scene)
    if are_half_planes(scene_read) and scene_read.friction.coefficient:
        return _answer_in_words(scene_read, limit, Verdict.WITHIN, _MODEL_ITSELF)
    try:
        advice = advising.advise(scene_read, limit)
    except advising.NoAdvice as no_advice:
        return _answer_in_words(scene_read, limit, None, str(no_advice))
    if isinstance(advice, Advice):
        return _answer_by_numbers(advice)
    return _answer_by_kernels(advice)


def _answer_in_words(scene: Scene, limit: float, verdict: str | None, sentence: str) -> Answer:
    """The answer of the command `advise`, on the error of half-plane theory for a scene, where no
    error is computed. It is one sentence, with exit code 0 if the `verdict` is that theory is
    within the `limit`, else 1. The JSON content has the same.
    """
    from reports.comparison.laws import Verdict

    is_within = verdict is Verdict.WITHIN
    content = {
        "by": None,
        "passed": is_within,
        "sentence": sentence,
        "limit": limit,
        "verdict": verdict,
    }
    # EXIT_WITHIN, EXIT_OUTSIDE: exit codes 0 and 1
    code = EXIT_WITHIN if is_within else EXIT_OUTSIDE
    return Answer(code, [f"{scene.name}: {sentence}"], lambda: content, scene.name)


def _answer_by_numbers(advice: Advice) -> Answer:
    """The answer of the command `advise`, on the error of half-plane theory for a scene, by theory
    that is corrected with elastic responses of the bodies. It has the sentence of the advice, a
    table of what the bodies change, and a table of the causes. Exit code 0 if the verdict is that
    theory is within the limit, else 1.

    `advice.changes` is quantity -> change of theory's value by the bodies, `parts` is cause -> its
    part of the change of the dissipation, `effects` are the elastic responses. `neglected_part` is
    the size of the change by tilt, bulk strain and coupling that were not followed.
    `refusal_of_kernels` is why the kernel solve, half-planes with the bodies' compliance, does not
    take the scene, or "". `reason_for_size_alone` is why only the size of the change is known, or
    "".
    """
    from reports.advising_by_numbers import advice_in_words
    from reports.comparison.laws import Verdict
    from reports.comparison.pairs import has_coupled_tractions

    def terminal_output() -> Iterator[Part]:
        """What the terminal shows of advice on half-plane theory for finite bodies: sentences, a
        table of what the bodies change, and a table of the causes. Each is a `Part` of the output.

        `advice.parts` are cause -> its part of the change of the dissipation;
        `neglected_part` is the size of the change by tilt, bulk strain and coupling that were not
        followed.
        """
        yield advice_in_words(advice)
        if advice.refusal_of_kernels:
            yield f"The kernel solve does not take this scene: {advice.refusal_of_kernels}"
        yield _sheet_of_changes(advice.scene, advice.changes, "corrected theory, no contact solved")
        causes = [(cause, _percent(change)) for cause, change in advice.parts.items()]
        if advice.neglected_part:
            name_of_rest = "tilt and bulk strain, a size"
            if has_coupled_tractions(advice.scene):
                name_of_rest = "coupling, tilt and bulk strain, a size"
            causes.append((name_of_rest, f"± {100 * advice.neglected_part:.2g} %"))
        yield Sheet("What makes the change of the dissipation", ("cause", "share of it"), causes)

    def content() -> dict[str, Any]:
        """The content of the JSON output: verdict, sentence, limit and changes; causes of the
        change of the dissipation, each with its part; why a better method does not take the scene
        ("declined"); the elastic responses of the bodies (`effects`).
        """
        return {
            **_shared_content(advice, "corrected theory", advice_in_words(advice)),
            "parts": {
                cause: _change_and_uncertainty(change) for cause, change in advice.parts.items()
            },
            "left_out": advice.neglected_part,
            "declined": "; ".join(
                filter(None, (advice.reason_for_size_alone, advice.refusal_of_kernels))
            ),
            "effects": asdict(advice.effects),
        }

    # EXIT_WITHIN, EXIT_OUTSIDE: exit codes 0 and 1
    code = EXIT_WITHIN if advice.verdict is Verdict.WITHIN else EXIT_OUTSIDE
    return Answer(code, terminal_output(), content, advice.scene.name)


def _answer_by_kernels(advice: KernelAdvice) -> Answer:
    """The answer of the command `advise`, on the error of half-plane theory for a scene, by
    half-planes with the compliance of the bodies added (kernels). It has the sentence of the
    advice, and a table of what the bodies change. Exit code 0 if the verdict is that theory is
    within the limit, else 1.

    `advice.changes` holds for each quantity the change of theory's value by the bodies. The key
    "declined" of the JSON content is why corrected theory, which is quicker, does not answer.
    """
    from reports.advising_by_kernels import advice_in_words
    from reports.comparison.laws import Verdict

    def terminal_output() -> Iterator[Part]:
        """What the terminal shows: the sentence and the table."""
        yield advice_in_words(advice)
        yield _sheet_of_changes(advice.scene, advice.changes, "the kernel solve of the bodies")

    def content() -> dict[str, Any]:
        """The content of the JSON output."""
        return {
            **_shared_content(advice, "kernel solve", advice_in_words(advice)),
            "declined": advice.reason_for_kernels,
        }

    # EXIT_WITHIN, EXIT_OUTSIDE: exit codes 0 and 1
    code = EXIT_WITHIN if advice.verdict is Verdict.WITHIN else EXIT_OUTSIDE
    return Answer(code, terminal_output(), content, advice.scene.name)


def _sheet_of_changes(scene: Scene, changes: Mapping[str, Change], source_in_words: str) -> Sheet:
    """A table of half-plane theory's values for a scene, and of the relative changes that finite
    bodies make in them. `source_in_words` says how the changes were found.

    `changes` holds for each quantity, such as "dissipation", its words, theory's value, and the
    relative change (bodies/theory − 1) with its uncertainty, NaN where it is not known.
    """
    from reports.units import energy_unit, units

    # the other quantities are lengths
    _, unit_of_length, unit_of_stress = units(scene)
    unit_by_quantity = {
        "dissipation": energy_unit(scene),
        "peak_pressure": unit_of_stress,
        "edge_tension": unit_of_stress,
    }
    rows = []
    for quantity, (quantity_in_words, theory_value, change) in changes.items():
        change_in_words = "no estimate" if math.isnan(change.value) else _percent(change)
        rows.append(
            (
                quantity_in_words,
                f"{theory_value:.6g} {unit_by_quantity.get(quantity, unit_of_length)}",
                change_in_words,
            )
        )
    heads = ("quantity", "half-plane theory", "bodies/theory − 1")
    # Sheet: a table on the terminal, of title, heads and rows
    return Sheet(f"{scene.title or scene.name}: by {source_in_words}", heads, rows)


def _shared_content(advice: Advice | KernelAdvice, method: str, sentence: str) -> dict[str, Any]:
    """The JSON content that both kinds of advice on a scene share. It states how the advice was
    found (`method`), whether half-plane theory is within the limit, the verdict in one word, the
    `sentence` of the advice, and the limit. For each quantity it has theory's value and the
    relative change that the bodies make. The limit is the largest size of the relative change of
    the dissipation up to which theory may be used.
    """
    from reports.comparison.laws import Verdict

    return {
        "by": method,
        "passed": advice.verdict is Verdict.WITHIN,
        "sentence": sentence,
        "limit": advice.limit,
        "verdict": advice.verdict,
        "changes": {
            name: {
                "theory": change.theory_value,
                **_change_and_uncertainty(change.relative_change),
            }
            for name, change in advice.changes.items()
        },
    }


def _change_and_uncertainty(estimate: Estimate) -> dict[str, float]:
    return {"change": estimate.value, "uncertainty": estimate.uncertainty}


def _percent(change: Estimate) -> str:
    """A relative change with its uncertainty, as text in per cent; with "not resolved" where the
    uncertainty is not smaller.
    """
    from reports.comparison.words import with_uncertainty

    value, uncertainty = change
    change_in_words = f"{with_uncertainty(100 * value, 100 * uncertainty)} %"
    if not change_in_words.startswith("−"):
        change_in_words = f"+{change_in_words}"
    return change_in_words if abs(value) > uncertainty else f"{change_in_words} (not resolved)"
