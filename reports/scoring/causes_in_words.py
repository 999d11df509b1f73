"""A cause in a sentence: what it is, how large, and what to do.

# notation: p pressure
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from halfplane_fe.dundurs import dundurs
from reports.scoring.causes import COUPLING, Cause, nearest_power_of_ten
from reports.scoring.discrepancy import PRESSURE, Discrepancy
from reports.scoring.fits import Fit
from reports.scoring.judgement import NEGLIGIBLE_BETA
from reports.scoring.traces import FAULTS, WORDS
from reports.scoring.variants import BLOCK_HEIGHT
from reports.units import minus

# A factor of the loads this near to one half or two is that of a symmetric model.
_NEARNESS_TO_HALF = 0.03
# Elements over the half-width that an engineer should take.
_ENOUGH_ELEMENTS = 10


def key_of_sentence(cause: Cause, size: float) -> str:
    """The key of the sentence on a cause, a known fault of a result, in the templates. Factors of 2
    or 1/2, and powers of ten, have sentences of their own. `size` is that of the fault; of a factor
    it is the logarithm.
    """
    factor = float(np.exp(size))
    if cause.key == "loads" and min(abs(factor / 2 - 1), abs(2 * factor - 1)) < _NEARNESS_TO_HALF:
        return "half_model"
    if cause.key == "traction_factor" and nearest_power_of_ten(factor) is not None:
        return "units"
    return cause.key


def size_in_words(cause: Cause, size: float) -> str:
    """The size of a cause in a few words; empty of a cause without one."""
    key = key_of_sentence(cause, size)
    if key not in WORDS["sizes"]:
        return ""
    template = WORDS["sizes"][key]
    return minus(str(template.format(**_numbers_of_size(cause, size), late=_late_or_early(size))))


def _numbers_of_size(cause: Cause, size: float) -> dict[str, float]:
    """The numbers that a template on the size of a cause (known fault) is filled with: the factor,
    whose logarithm the size is, or the distance or delay, which the size is itself.

    >>> from reports.scoring.causes import CAUSES
    >>> loads = next(cause for cause in CAUSES if cause.key == "loads")
    >>> _numbers_of_size(loads, 0.0)["factor"]
    1.0
    """
    factor = float(np.exp(size))
    if key_of_sentence(cause, size) == "units":
        factor = nearest_power_of_ten(factor) or factor
    return {"factor": factor, "distance": size, "delay": abs(size)}


def _late_or_early(delay: float) -> str:
    """The word for the sign of a delay."""
    return "early" if delay < 0 else "late"


def sentence_on_cause(discrepancy: Discrepancy, cause: Cause, size: float, fit: Fit) -> str:
    """The sentence of a page that names a known fault of a result and says what to do about it.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at some instants and all points
    cause
        the fault
    size
        fitted size of the fault; of a factor it is the logarithm
    fit
        the fit with this cause and perhaps another one

    # notation: a_ref half-width of contact of the reference, E* composite modulus
    """
    numbers_in_sentence = {
        **_numbers_of_size(cause, size),
        "steps": float(len(discrepancy.comparison.result_cycle.time) - 1),
        # of blocks that are too small, over a_ref
        "height": _height_of_blocks(size),
        # of the points, over a_ref
        "spacing": 1 / discrepancy.elements_per_half_width,
    }
    # unlike materials, nodal forces, a wrong E*/R (R: radius of the profile): sentences of their
    # own
    if cause.key == COUPLING.key:
        return coupling_sentence(discrepancy)
    if cause.key == "coarse_edge":
        return _coarse_mesh_sentence(discrepancy, is_only_cause=len(fit.causes) == 1)
    words_in_sentence = {"likely": "", "late": _late_or_early(size)}
    if cause.key == "stiffness":
        words_in_sentence["likely"] = _origin_of_stiffness_factor(discrepancy, float(np.exp(size)))
    # key of the sentence: some sizes, such as a power of ten, have one of their own
    template = FAULTS[key_of_sentence(cause, size)]
    return template.format(**numbers_in_sentence, **words_in_sentence)


def _height_of_blocks(size: float) -> float:
    """Height [a_ref] of two equal blocks whose response is `size` times that of blocks of
    `BLOCK_HEIGHT`: the response goes as the inverse square of the height.
    """
    return BLOCK_HEIGHT / max(abs(size), 1e-12) ** 0.5


def _coarse_mesh_sentence(discrepancy: Discrepancy, *, is_only_cause: bool) -> str:
    """The sentence for a result that has nodal forces of a coarse mesh in place of tractions, with
    the number of elements over the contact and the size that they should have.

    `discrepancy` holds the result's pressure; `is_only_cause` is whether no other cause is named.
    """
    # template of the sentence
    sentence = WORDS["others"]["coarse_mesh"].format(**_numbers_of_mesh(discrepancy))
    if is_only_cause:
        return f"{sentence} {WORDS['others']['coarse_mesh_alone']}"
    return str(sentence)


def sentence_on_few_points(discrepancy: Discrepancy) -> Iterator[str]:
    """A sentence on a result with fewer than ten points over the half-width: so coarse a mesh may
    make a difference that no known fault makes. Nothing with more points.
    """
    if discrepancy.elements_per_half_width < _ENOUGH_ELEMENTS:
        yield WORDS["others"]["few_points"].format(**_numbers_of_mesh(discrepancy))


def _numbers_of_mesh(discrepancy: Discrepancy) -> dict[str, float]:
    """Numbers for a sentence on a coarse mesh: elements over the half-width, nodes that carry load
    at an instant, enough elements, and the size that these have [length].
    """
    pressure = discrepancy.result_tractions[PRESSURE]
    carries_load = pressure > 1e-3 * np.max(pressure)
    return {
        "elements": discrepancy.elements_per_half_width,
        "carrying": int(np.max(np.sum(carries_load, axis=1))),
        "enough": _ENOUGH_ELEMENTS,
        "wanted": discrepancy.half_width / _ENOUGH_ELEMENTS,
    }


def _origin_of_stiffness_factor(discrepancy: Discrepancy, factor: float) -> str:
    """In words, the likely origin of a wrong `factor` of E*/R in a result: plane stress, another
    modulus, or the like. `discrepancy` holds the tractions of result and reference, and the scene.

    # notation: E* composite modulus, R radius of the profile
    """
    material = discrepancy.comparison.scene.material
    nu = material.upper.poisson_ratio
    if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
        return f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"
    # known factors of E*/R, with a cause and how near one must be
    for known_factor in WORDS["stiffness"]:
        if abs(factor / known_factor["factor"] - 1) < known_factor["within"]:
            return str(known_factor["cause"])
    return "contact widths go as the square root of its inverse for a Hertz contact"


def coupling_sentence(discrepancy: Discrepancy) -> str:
    """The sentence on a shear difference that is odd in x, as by the coupling of unlike materials.
    It is a fault of the result, unless the scene's materials are unlike and the reference is
    half-plane theory, which leaves their coupling out.
    """
    # Dundurs' constant, 0 for like materials
    beta = dundurs(discrepancy.comparison.scene.material).beta
    if abs(beta) <= NEGLIGIBLE_BETA:
        return FAULTS["coupling"]
    reference_has_coupling = discrepancy.comparison.reference.engine == "halfplane_fe"
    # WORDS: templates of sentences
    key = "coupling_of_reference" if reference_has_coupling else "own_coupling"
    return str(WORDS["others"][key].format(own=beta))
