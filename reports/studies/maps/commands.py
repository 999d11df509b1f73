"""The commands of the maps of the idealisation error: run their studies, and advise by what is
published.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from reports.cli.application import OUTSIDE, WITHIN, Answer, Options, share_of
from reports.cli.solving import read
from reports.console import Part, Sheet
from reports.studies.sweep.commands import swept

if TYPE_CHECKING:
    from reports.studies.maps.advice import Advice


def make_map(name: str, options: Options) -> Answer:
    """Run the studies of a map, or of all, and write tables and pages; 3 where a point failed.

    Raises
    ------
    InputError
        Where `out` is left out in an installed copy, whose tables `halfplane advise` reads.
    """
    from reports.folder import replace_text
    from reports.studies.maps.laws import MAPS, PUBLISHED, STUDIES, as_csv, map_named
    from reports.studies.maps.pages import require_free, write
    from reports.studies.sweep.store import read_index
    from scenes import InputError

    if options.out is None and not (PUBLISHED / "README.md").exists():
        raise InputError(
            "the published maps are those of a checkout, and this is an installed copy: name a"
            " folder by --out"
        )
    folder = options.out or PUBLISHED
    code = WITHIN
    states: dict[str, Any] = {}
    maps = list(MAPS.values()) if name == "all" else [map_named(name)]
    require_free(folder)
    studies: list[str] = []
    if not options.pages:
        for error_map in maps:
            studies += error_map.studies
    for study in studies:
        store = options.stores / study
        if options.remake and store.exists():
            shutil.rmtree(store)
        of_sweep = Options(out=store, workers=options.workers, resume=True, quiet=options.quiet)
        answer = swept(str(STUDIES / f"{study}.toml"), of_sweep)
        if answer.content is None:
            return answer
        code = max(code, answer.code)
        replace_text(folder / f"{study}.csv", as_csv(read_index(store)))
        state = answer.content()
        states[study] = {key: state[key] for key in state if key not in ("title", "file")}
    write(folder)
    page = str(folder / "README.md")
    return Answer(code, [page], lambda: {"passed": code == WITHIN, "studies": states, "page": page})


def advise(scene: str, options: Options) -> Answer:
    """What the published maps say of a scene; outside where the error of dissipation may exceed the
    limit, or is not known.
    """
    from reports.studies.maps.advice import Advice, parts_of
    from scenes import InputError

    limit = share_of(options.limit)
    if not 0 < limit < 1:
        raise InputError(
            f"--limit {options.limit} is refused: it is a share above 0 and below 1, such as 0.05"
            " for 5 %"
        )
    problem = read(scene)
    advice = Advice(problem, *parts_of(problem), limit)
    code = WITHIN if advice.may_be_used else OUTSIDE
    return Answer(code, _advice_parts(advice, scene), lambda: _advice_content(advice), problem.name)


def _advice_content(advice: Advice) -> dict[str, Any]:
    """Every departure (`errors` null where the maps know nothing), the sum of what is known, and
    the answer.

    Within by values that are extrapolated is undecided: they have no uncertainty estimate.
    """
    from reports.comparison.verdicts import Verdict
    from reports.studies.maps.advice import FIGURES, sentence, total

    def pairs(values: Any) -> dict[str, dict[str, float]]:
        return {
            name.removeprefix("error."): dict(
                zip(("error", "uncertainty"), values(name), strict=True)
            )
            for name in FIGURES
        }

    verdict = advice.verdict
    if verdict is Verdict.WITHIN and advice.extrapolated:
        verdict = Verdict.UNDECIDED
    return {
        "passed": advice.may_be_used,
        "sentence": sentence(advice),
        "limit": advice.limit,
        "verdict": verdict,
        "within_limit": None if verdict is None else verdict is Verdict.WITHIN,
        "extrapolated": advice.extrapolated,
        "contact_half_width": advice.half_width,
        "departures": [
            {
                "what": part.what,
                "errors": None if part.values is None else pairs(part.values.__getitem__),
                "extrapolated": part.extrapolated,
                "from": part.how,
            }
            for part in advice.parts
        ],
        "sum_of_known": pairs(lambda name: total(advice.known, name)) if advice.known else None,
    }


def _advice_parts(advice: Advice, source: str) -> Iterator[Part]:
    from reports.studies.maps.advice import FIGURES, cell, cells, sentence, total
    from reports.studies.maps.laws import WORDS
    from reports.units import units

    if not advice.parts:
        yield f"{source}: {sentence(advice)}"
        return
    rows = [(part.what, *cells(part), part.how) for part in advice.parts]
    if len(rows) > 1 and advice.known:
        name = "sum" if len(advice.known) == len(rows) else "sum of what is known"
        rows.append(
            (
                name,
                *(cell(*total(advice.known, figure), advice.extrapolated) for figure in FIGURES),
                "all added up",
            )
        )
    heads = ("departure", *(WORDS[figure] for figure in FIGURES), "where from")
    load = "mean" if advice.scene.load.kind == "ellipse" else "largest"
    size = f"a = {advice.half_width:.4g} {units(advice.scene)[1]} at the {load} load"
    yield Sheet(
        f"{advice.scene.title or source}: bodies/half-plane theory − 1; {size}", heads, rows
    )
    yield sentence(advice)
