"""A cause in a sentence: what it is, how large, and what to do.

# notation: p pressure
"""

from __future__ import annotations

import numpy as np

from halfplane_fe.dundurs import dundurs
from reports.scoring.causes import COUPLING, Cause, round_power
from reports.scoring.discrepancy import Discrepancy
from reports.scoring.fits import Fit
from reports.scoring.judgement import NO_COUPLING
from reports.scoring.traces import FAULTS, WORDS
from reports.scoring.variants import BLOCK_HEIGHT
from reports.units import minus

# A factor of the loads this near to one half or two is that of a symmetric model.
_HALF = 0.03
# Elements over the half-width that an engineer should take.
_ENOUGH_ELEMENTS = 10


def key_of_sentence(cause: Cause, size: float) -> str:
    """The key of the sentence: round factors have their own."""
    factor = float(np.exp(size))
    if cause.key == "loads" and min(abs(factor / 2 - 1), abs(2 * factor - 1)) < _HALF:
        return "half_model"
    if cause.key == "traction_factor" and round_power(factor) is not None:
        return "units"
    return cause.key


def size_of(cause: Cause, size: float) -> str:
    """The size in a few words; empty of a cause without one."""
    label = key_of_sentence(cause, size)
    if label not in WORDS["sizes"]:
        return ""
    return minus(str(WORDS["sizes"][label].format(**_figures(cause, size))))


def _figures(cause: Cause, size: float) -> dict[str, float]:
    """The numbers that the sentence of a cause is filled with, from its fitted size."""
    factor = float(np.exp(size))
    if key_of_sentence(cause, size) == "units":
        factor = round_power(factor) or factor
    return {"factor": factor, "distance": size, "delay": size}


def sentence_of(discrepancy: Discrepancy, cause: Cause, size: float, fit: Fit) -> str:
    """The sentence of a page that names a known fault of a result and says what to do about it.

    Parameters
    ----------
    discrepancy
        tractions of result and reference at some instants and all points
    size
        fitted size of the fault; of a factor it is the logarithm
    fit
        the fit with this cause and perhaps another one
    """
    factor = float(np.exp(size))
    numbers_in_sentence = {
        **_figures(cause, size),
        "steps": float(len(discrepancy.comparison.result_cycle.time) - 1),
        "height": _height(size),
        "spacing": 1 / discrepancy.elements,
        "likely": "",
    }
    if cause.key == COUPLING.key:
        return coupling_sentence(discrepancy)
    if cause.key == "coarse_edge":
        return _of_mesh(discrepancy, alone=len(fit.causes) == 1)
    label = key_of_sentence(cause, size)
    if cause.key == "stiffness":
        return FAULTS[label].format(
            **numbers_in_sentence | {"likely": _likely_stiffness(discrepancy, factor)}
        )
    return FAULTS[label].format(**numbers_in_sentence)


def _height(share: float) -> float:
    """Height [a_ref] of two equal blocks that add this share of what `BLOCK_HEIGHT` adds."""
    return BLOCK_HEIGHT / max(abs(share), 1e-12) ** 0.5


def _of_mesh(discrepancy: Discrepancy, *, alone: bool) -> str:
    """The sentence for a result whose only visible fault is that it has nodal forces of a coarse
    mesh; `alone` if no other cause is named. `discrepancy` holds the tractions of result and
    reference.
    """
    pressure = discrepancy.result_tractions[0]
    carries_load = pressure > 1e-3 * np.max(pressure)
    most_carrying = int(np.max(np.sum(carries_load, axis=1)))
    sentence = WORDS["others"]["coarse_mesh"].format(
        elements=discrepancy.elements,
        carrying=most_carrying,
        wanted=discrepancy.half_width / _ENOUGH_ELEMENTS,
        enough=_ENOUGH_ELEMENTS,
    )
    return f"{sentence} {WORDS['others']['coarse_mesh_alone']}" if alone else str(sentence)


def _likely_stiffness(discrepancy: Discrepancy, factor: float) -> str:
    """In words, what makes a factor of E*/R likely: plane stress, another modulus, or the like."""
    material = discrepancy.comparison.scene.material
    nu = material.upper.poisson_ratio
    if material.alike and abs(factor / (1 - nu**2) - 1) < 0.2 * nu**2:
        return f"it is near 1 - nu^2 = {1 - nu**2:.3g}: plane stress"
    for quotient in WORDS["stiffness"]:
        if abs(factor / quotient["factor"] - 1) < quotient["within"]:
            return str(quotient["cause"])
    return "contact widths go as the square root of its inverse for a Hertz contact"


def coupling_sentence(discrepancy: Discrepancy) -> str:
    """The sentence on a difference that is odd in x: a fault of the result, unless its scene has
    unlike materials and the reference does not have their coupling.
    """
    beta = dundurs(discrepancy.comparison.scene.material).beta
    if abs(beta) <= NO_COUPLING:
        return FAULTS["coupling"]
    in_reference = discrepancy.comparison.reference.engine == "halfplane_fe"
    key = "coupling_of_reference" if in_reference else "own_coupling"
    return str(WORDS["others"][key].format(own=beta))
