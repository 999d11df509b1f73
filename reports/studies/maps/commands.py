"""The commands of the maps of the idealisation error: run their studies, and advise by what is
published.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from reports.cli.application import OUTSIDE, WITHIN, Answer, Options, share_of
from reports.cli.solving import read
from reports.console import Part, Sheet
from reports.studies.sweep.commands import swept

if TYPE_CHECKING:
    from reports.advising import Advice as AdviceByNumbers
    from reports.studies.maps.advice import Advice
    from scenes import Estimate


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
    """How wrong half-plane theory is for the bodies of a scene, and why: by corrected theory, and
    where the numbers of the bodies say nothing by the published maps. Outside where the error of
    the dissipation may exceed the limit, or is not known.
    """
    from reports.advising import advise as advise_by_numbers
    from reports.comparison.pairs import are_half_planes
    from reports.comparison.verdicts import Verdict
    from reports.studies.maps.advice import Advice, parts_of
    from scenes import InputError

    limit = share_of(options.limit)
    if not 0 < limit < 1:
        raise InputError(
            f"--limit {options.limit} is refused: it is a share above 0 and below 1, such as 0.05"
            " for 5 %"
        )
    problem = read(scene)
    reason = ""
    if not are_half_planes(problem):
        try:
            of_bodies = advise_by_numbers(problem, limit)
        except InputError as declined:
            reason = str(declined)
        else:
            code = WITHIN if of_bodies.verdict is Verdict.WITHIN else OUTSIDE
            return Answer(
                code,
                _parts_by_numbers(of_bodies),
                lambda: _numbers_content(of_bodies),
                problem.name,
            )
    advice = Advice(problem, *parts_of(problem), limit)
    code = WITHIN if advice.may_be_used else OUTSIDE

    def parts() -> Iterator[Part]:
        if reason:
            yield f"By the published maps, as corrected theory does not take this scene: {reason}"
        yield from _advice_parts(advice, scene)

    def content() -> dict[str, Any]:
        return {"by": "maps", "declined": reason or None, **_advice_content(advice)}

    return Answer(code, parts(), content, problem.name)


def _parts_by_numbers(advice: AdviceByNumbers) -> Iterator[Part]:
    """Sentence, changes with theory's values, and what makes that of the dissipation."""
    from reports.advising import sentence
    from reports.comparison.pairs import coupled
    from reports.studies.maps.advice import percent
    from reports.units import energy_unit, units

    yield sentence(advice)
    scene = advice.scene
    _, length, stress = units(scene)
    unit_of = {"dissipation": energy_unit(scene), "peak_pressure": stress}
    rows = []
    for name, (words, theory, change) in advice.changes.items():
        unit = unit_of.get(name, length)
        changed = "no estimate" if math.isnan(change.value) else percent(*change)
        rows.append((words, f"{theory:.6g} {unit}", changed))
    heads = ("quantity", "half-plane theory", "bodies/theory − 1")
    yield Sheet(f"{scene.title or scene.name}: by corrected theory, no contact solved", heads, rows)
    causes = [(words, percent(*part)) for words, part in advice.parts.items()]
    if advice.left_out:
        what = "tilt and bulk strain, a size"
        if coupled(scene):
            what = "coupling, tilt and bulk strain, a size"
        causes.append((what, f"± {100 * advice.left_out:.2g} %"))
    yield Sheet("What makes the change of the dissipation", ("cause", "share of it"), causes)


def _numbers_content(advice: AdviceByNumbers) -> dict[str, Any]:
    """The numbers of the bodies, the changes that they make, the parts of that of the
    dissipation, and the answer.
    """
    from reports.advising import sentence
    from reports.comparison.verdicts import Verdict

    def pair(estimate: Estimate) -> dict[str, float]:
        return {"change": estimate.value, "uncertainty": estimate.uncertainty}

    changes = {
        name: {"theory": change.theory, **pair(change.change)}
        for name, change in advice.changes.items()
    }
    return {
        "by": "corrected theory",
        "passed": advice.verdict is Verdict.WITHIN,
        "sentence": sentence(advice),
        "limit": advice.limit,
        "verdict": advice.verdict,
        "changes": changes,
        "parts": {words: pair(part) for words, part in advice.parts.items()},
        "left_out": advice.left_out,
        "declined": advice.declined,
        "effects": asdict(advice.effects),
    }


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
