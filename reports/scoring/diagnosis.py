"""Why a result differs from its reference: causes that are shown, or the statement that none was
found, with what is excluded.

# notation: p pressure, q shear
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from halfplane_fe.dundurs import dundurs
from reports.comparison import Comparison
from reports.scoring.causes import (
    BLOCK_HEIGHT,
    COUPLING,
    SOFT_NORMAL,
    Cause,
    Predictions,
    round_power,
)
from reports.scoring.discrepancy import PRESSURE, SHEAR, Discrepancy, discrepancy
from reports.scoring.fits import CHANCE, MOST_LEFT, ROUND_OFF, Fit, Search, share_left
from reports.scoring.judgement import NO_COUPLING, Judge, Verdict
from reports.scoring.other_problems import other_problems
from reports.scoring.traces import (
    FAULTS,
    OWN_BODIES,
    UNKNOWN,
    WORDS,
    Diagnosis,
    coarse_edge,
    elastic_slip,
    full_slip,
    long_steps_by_work,
    outliers,
    scatter,
)

# A factor of the loads this near to one half or two is that of a symmetric model.
_HALF = 0.03
# Elements over the half-width that an engineer should take.
_ENOUGH_ELEMENTS = 10


def diagnose(comparison: Comparison) -> tuple[Diagnosis, ...]:
    """Findings on the difference, causes first; none for a result within tolerance."""
    what = discrepancy(comparison)
    if what is None:
        return ()
    cells = outliers(comparison)
    traces = [*full_slip(what), *elastic_slip(what)]
    if what.within:
        named = (*cells, *traces) or tuple(long_steps_by_work(comparison))
        if named or comparison.verdict == "within":
            return named
    judge = Judge(what, Search(what, Predictions(what)))
    verdict = judge.verdict()
    causes = list(_named(judge, verdict, is_traced=bool(traces)))
    if not traces and not (verdict.fit is not None and judge.is_whole(verdict.fit)):
        causes = list(other_problems(what, verdict.fit)) or causes
    if not causes and not traces:
        causes = [*_own_bodies(judge), *_mesh_at_edges(judge), *scatter(what)][:1]
    if not causes and not traces and not cells and not what.within:
        causes = [_not_found(judge, verdict)]
    return (*cells, *traces, *causes)


def _named(judge: Judge, verdict: Verdict, *, is_traced: bool) -> Iterator[Diagnosis]:
    """The causes of the verdict that no rival lacks."""
    fit = verdict.fit
    if fit is None:
        return
    shared = fit.keys.intersection(*(rival.keys for rival in verdict.rivals))
    for place, cause in enumerate(fit.causes):
        # What has a trace of its own in the shear needs no second explanation of it.
        if cause.key not in shared or (is_traced and cause.channel == SHEAR):
            continue
        before = _without_cause(judge, fit, cause)
        # a layer's effect on the shear is not predicted
        channels = (PRESSURE,) if cause is SOFT_NORMAL else judge.channels
        left = share_left(fit, before, channels)
        yield Diagnosis(
            _label(cause, fit.sizes[place]),
            _sentence(judge.what, cause, fit.sizes[place], fit),
            tuple(_evidence(judge, fit, left)),
            strength=1 - min(left, 1.0),
        )


def _without_cause(judge: Judge, fit: Fit, cause: Cause) -> Fit:
    """The fit of the other causes alone."""
    others = tuple(one for one in fit.causes if one is not cause)
    return judge.search.fit(others, judge.channels) or judge.without


def _label(cause: Cause, size: float) -> str:
    """The key of the sentence: round factors have their own."""
    factor = float(np.exp(size))
    if cause.key == "loads" and min(abs(factor / 2 - 1), abs(2 * factor - 1)) < _HALF:
        return "half_model"
    if cause.key == "traction_factor" and round_power(factor) is not None:
        return "units"
    return cause.key


def _sentence(what: Discrepancy, cause: Cause, size: float, fit: Fit) -> str:
    """The cause, and what to do."""
    factor = float(np.exp(size))
    figures = {
        "factor": factor,
        "distance": size,
        "delay": size,
        "steps": float(len(what.comparison.found.time) - 1),
        "height": _height(size),
        "spacing": 1 / what.elements,
        "likely": "",
    }
    if cause.key == COUPLING.key:
        return coupling_sentence(what)
    if cause.key == "coarse_edge":
        return _of_mesh(what, alone=len(fit.causes) == 1)
    label = _label(cause, size)
    if label == "units" and cause.sized:
        figures["factor"] = round_power(factor) or factor
    if cause.key == "stiffness":
        return FAULTS[label].format(**figures | {"likely": _likely_stiffness(what, factor)})
    return FAULTS[label].format(**figures)


def _height(share: float) -> float:
    """Height [a_ref] of two equal blocks that add this share of what `BLOCK_HEIGHT` adds."""
    return BLOCK_HEIGHT / max(abs(share), 1e-12) ** 0.5


def _of_mesh(what: Discrepancy, *, alone: bool) -> str:
    """The sentence of a mesh whose nodal forces are all that it shows."""
    carrying = int(np.max(np.sum(what.found[0] > 1e-3 * np.max(what.found[0]), axis=1)))
    sentence = WORDS["others"]["coarse_mesh"].format(
        elements=what.elements,
        carrying=carrying,
        wanted=what.half_width / _ENOUGH_ELEMENTS,
        enough=_ENOUGH_ELEMENTS,
    )
    return f"{sentence} {WORDS['others']['coarse_mesh_alone']}" if alone else str(sentence)


def _likely_stiffness(what: Discrepancy, factor: float) -> str:
    """What a factor of E*/R is likely to be, in words."""
    material = what.comparison.scene.material
    nu = material.upper.poisson_ratio
    if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
        return f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"
    for quotient in WORDS["stiffness"]:
        if abs(factor / quotient["factor"] - 1) < quotient["within"]:
            return str(quotient["cause"])
    return "contact widths go as the square root of its inverse for a Hertz contact"


def _evidence(judge: Judge, fit: Fit, left: float) -> Iterator[str]:
    """Measured values that speak for a cause, in the order of evidence."""
    what = judge.what
    ratio = what.resultant_ratio
    if np.isfinite(ratio):
        yield f"the sum of the pressures is {ratio:.4g} P"
    noise = fit.noise(judge.channels) ** 0.5
    yield (
        f"{fit.count((PRESSURE,))} values in contact; noise from point to point {noise:.2g} of the"
        " scales"
    )
    of_which = " of the pressure" if SOFT_NORMAL in fit.causes else ""
    yield f"a result with just this fault leaves {max(left, 0.0):.1%} of the difference{of_which}"
    pressure, shear = what.errors()
    after = replace(what, expected=fit.predicted).errors()
    yield (
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant; with the fault taken out, "
        f"{after[0]:.2g} and {after[1]:.2g}"
    )
    if what.missing:
        yield f"{what.missing:.1%} of the tractions are no numbers and were left out"
    if what.unsymmetric:
        yield (
            "with bulk stress, tilt or unequal sides not looked for: no memory, unlike bodies, soft"
            " penalties, bodies too small"
        )


def coupling_sentence(what: Discrepancy) -> str:
    """What a difference that is odd in x means: a fault of the result, unless its scene has unlike
    materials and the reference does not have their coupling.
    """
    beta = dundurs(what.comparison.scene.material).beta
    if abs(beta) <= NO_COUPLING:
        return FAULTS["coupling"]
    in_reference = what.comparison.reference.engine == "halfplane_fe"
    key = "coupling_of_reference" if in_reference else "own_coupling"
    return str(WORDS["others"][key].format(own=beta))


def _own_bodies(judge: Judge) -> Iterator[Diagnosis]:
    """The idealisation: theory with the numbers of the scene's own bodies leaves less than a third
    of what half-plane theory leaves.
    """
    what = judge.what
    if not what.has_bodies:
        return
    reference = what.comparison.expected
    half_planes = np.array([reference.pressure[what.rows], reference.shear[what.rows]])
    half_planes = np.where(np.isfinite(half_planes), half_planes, what.expected)
    before = Fit((), (), half_planes, what.residuals(half_planes))
    left = share_left(judge.without, before, judge.channels)
    if left < MOST_LEFT:
        evidence = tuple(_evidence(judge, judge.without, left))
        yield Diagnosis(OWN_BODIES, WORDS["others"][OWN_BODIES], evidence, 1 - left)


def _mesh_at_edges(judge: Judge) -> Iterator[Diagnosis]:
    """A difference that lies within two elements of the edges."""
    from scipy.stats import f as f_distribution

    what = judge.what
    edges = coarse_edge(what)
    if edges is None or judge.is_right(judge.without, PRESSURE):
        return  # a mesh that errs at stick edges errs at the edges of contact as well
    predicted, is_near = edges
    fit = Fit((), (), predicted, what.residuals(predicted))
    left = share_left(fit, judge.without, judge.channels)
    values = np.array([judge.without.residuals[channel].values for channel in judge.channels])
    contact = judge.without.residuals[PRESSURE].inside
    near = values[:, contact & is_near].ravel()
    far = values[:, contact & ~is_near].ravel()
    ratio = np.mean(near**2) / max(float(np.mean(far**2)), ROUND_OFF)
    chance = float(f_distribution.sf(ratio, len(near), len(far)))
    if left > MOST_LEFT or ratio < MOST_LEFT**-2 or chance > CHANCE:
        return
    sentence = FAULTS["coarse_edge"].format(spacing=1 / what.elements)
    yield Diagnosis("coarse_edge", sentence, tuple(_evidence(judge, fit, left)), 1 - left)


def _not_found(judge: Judge, verdict: Verdict) -> Diagnosis:
    """What is excluded, and by what."""
    what = judge.what
    pressure, shear = what.errors()
    lines = [
        f"error of the pressure {pressure:.2g} of its norm, of the shear {shear:.2g} of f times"
        " that, at the worst instant"
    ]
    if verdict.fit is not None and verdict.rivals:
        choices = [verdict.fit, *verdict.rivals]
        words = " or ".join(" with ".join(sorted(fit.keys)) for fit in choices)
        lines.insert(0, f"the file does not tell these apart: {words}")
    if judge.excluded:
        words = "; ".join(
            f"{WORDS['names'][key]}: {reason}" for key, reason in judge.excluded.items()
        )
        lines.append(f"excluded: {words}")
    lines += _left_by_each(judge)
    return Diagnosis(UNKNOWN, WORDS["others"][UNKNOWN], tuple(lines), 0.0)


def _left_by_each(judge: Judge) -> Iterator[str]:
    """What each cause that was tried alone leaves, the least first."""
    least: dict[str, float] = {}
    for fit in judge.search.done.values():
        if fit is None or len(fit.causes) != 1:
            continue
        (cause,) = fit.causes
        left = share_left(fit, judge.without, (cause.channel,))
        if left < 1:
            least[cause.key] = min(left, least.get(cause.key, 1.0))
    ranked = sorted(least.items(), key=lambda item: item[1])
    words = ", ".join(f"{WORDS['names'][key]} {left:.0%}" for key, left in ranked)
    if words:
        yield f"each alone leaves of the difference (pressure, or shear): {words}; all others all"
