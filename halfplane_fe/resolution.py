"""What the mesh can't see, in sentences: contacts, slip zones and flanks of the pressure that are too few elements wide.

And the uncertainty of the dissipation, from the difference to the coarse run and from the steps.

# notation: h element at the edges of contact and stick, of the coarser side; a half-width; A = 2/E*; f coefficient of friction

Measured on Hertz at P0 : P1 = 3 : 1, quadratic elements, h = a/1.1 ... a/160, matching sides and sides of ratio 1.5 ... 20, the
worst instant with more than 0.3 of the largest load: the error in L2 is 0.3 to 0.62 h/a of f p for q, 0.1 to 0.25 h/a for p; linear
elements are 3.7 times worse. Where P and Q go along the limit of friction, so that nothing slips and all of it nearly does,
elements of a/16 to a/160 dissipate 0.024 to 0.04 (h/a)^2 A f^2 P^2.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from meshes import MeshSettings
from scenes import Scene

Array = NDArray[np.float64]

# Error in L2 over h/a, of q and of p; that of linear elements over that of quadratic ones.
_SHEAR, _PRESSURE, _LINEAR = 0.65, 0.25, 3.7
# Error above which there is a note.
_TOLD = 0.05
# Share of the largest load from which on instants count: below it tractions are off in a contact that carries next to nothing.
_LOADED = 0.3
# Exponent of a power law below which the peak at its tip is lost: x^1.1 has p 23 % off on a coarse mesh, x^1.3 less than 5 %.
_SHARP = 1.25
# Dissipation over A f^2 P^2 (h/a)^2 of a mesh on which nothing should slip.
_FLOOR = 0.04
# Elements below which the dissipation of a slip zone has an error of per cents: Cattaneo-Mindlin's cycle has 0.4 % at 3.4 elements,
# 3 % at 1.6, 34 % at 0.7, and is seven times too large or nothing at 0.2.
_FEW = 2.0


def resolution_notes(
    scene: Scene, load: Array, contact: Array, stick: Array, element: float, order: int, dissipation: float, sheared: bool
) -> Iterator[str]:
    """One sentence for whatever in the last revolution is too narrow for the surface elements.

    Contacts, or their flanks beyond a kink of the profile, and slip zones of few elements; dissipation not far above what the mesh
    alone makes.

    Parameters
    ----------
    load, contact, stick : (n,) normal load and half-widths at its instants [force per thickness, length]; stick NaN where nothing
        sticks
    element : at the edges of contact and stick, of the coarser side [length]
    order : of the elements
    dissipation : of the revolution over A f^2 P^2, P the largest load
    sheared : whether any shear can arise
    """
    worse = _LINEAR if order == 1 else 1.0
    enough = np.ceil(worse * _SHEAR / _TOLD)  # elements from which on the shear is right to what need not be told

    def off(elements: float) -> tuple[float, float, str]:
        """Expected errors of q and p in L2, over f p and p, and what to expect of the tractions."""
        shear, pressure = worse * _SHEAR / elements, worse * _PRESSURE / elements
        if (shear if sheared else pressure) > 0.5:
            return shear, pressure, "expect errors of tractions and dissipation of half their size and more"
        of_shear = f"of {shear:.0%} of f p in the shear and " if sheared else ""
        return shear, pressure, f"expect an error {of_shear}of {pressure:.0%} in the pressure (L2)"

    least = float(np.min(contact[load > _LOADED * np.max(load)], initial=np.inf)) / element
    shear, pressure, words = off(least)
    if shear > _TOLD and (sheared or pressure > _TOLD):
        yield (
            f"the contact is {least:.2g} elements from its middle to its edge where it is smallest (loads above {_LOADED:g} of the "
            f"largest), {element:.3g} each on the coarser side: {words}; make edge_element_size of that side less than "
            f"1/{enough:.0f} of the half-width there"
        )
    exponent = getattr(scene.profile, "exponent", 2.0)
    if exponent < _SHARP:
        yield (
            f"the profile rises as |x|^{exponent:g}, next to a wedge, whose pressure is infinite at the tip: no mesh here follows "
            "it, expect errors of 15% of f p in the shear and of 30% in the pressure (L2)"
        )
    for kink in scene.profile.kinks:
        # A flank is as steep as it is narrow beside what it ends: one that takes most of the contact is Hertz' own.
        width = least - kink / element
        shear, _, words = off(max(width, 1e-9) * max(least / (kink / element), 1.0))
        if width > -1 and shear > _TOLD:
            yield (
                f"the contact ends {max(width, 0.0):.2g} elements, {element:.3g} each, beyond x = {kink:.6g}, where the pressure "
                f"is steep: it is not resolved there, {words}; make edge_element_size {enough:.0f} times less than that distance"
            )
    if not sheared:
        return
    slip = float(np.max(contact - np.where(np.isfinite(stick), stick, 0.0), initial=0.0)) / element
    floor = _FLOOR * (element / float(np.max(contact, initial=element))) ** 2
    if not dissipation > 0:
        yield (
            f"no node slips: a slip zone narrower than an element, {element:.3g} at the edges, would not be seen, and its "
            "dissipation would be missing"
        )
    elif slip < _FEW:
        much = "some per cent or more" if slip > 1 else "a factor, up or down"
        yield (
            f"slip zones are {slip:.2g} elements wide at most, {element:.3g} each: the error of the dissipation is {much}; "
            "make edge_element_size several times less than their width"
        )
    elif floor > _TOLD * dissipation:
        yield (
            f"the dissipation is {dissipation:.2g} A f^2 P^2, and the mesh alone makes up to {floor:.2g} of that unit where "
            "all of the contact is next to slipping, even if nothing slips: take the figure for uncertain by that much"
        )


# Shares of the mesh in the uncertainty of W: of its difference from the coarse run's over the square of the refinement; of the rms
# of what edges between nodes add to W, which is taken off (`between_nodes`); of W (h/a)^2; of A f^2 P^2 (h/a)^2. By what is known
# of the edges: that some stand between nodes, and were corrected for it; that none stands; nothing, on linear elements, with a
# penalty layer, and under bulk stress or tilt. Fitted to 115 random scenes (benchmarks/covered.py, seeds 5 to 7), held to others.
_SHARES = {"corrected": (1.0, 0.15, 0.1, 0.0), "moving": (1.0, 0.0, 1.0, 1e-4), "unknown": (2.0, 0.0, 1.5, 5e-3)}
# Share of W over the fourth power of the growth of elements away from the edges, the order of quadratic elements: on four scenes
# 1e-6 to 3e-6 at 0.12, 1e-5 to 2.5e-5 at 0.2, 1e-4 to 3.3e-4 at 0.4.
_GROWN = 0.01875
# Refinement from the coarse run below which their difference says nothing.
_LEAST_REFINEMENT = 1.4


def uncertainty(
    dissipation: float, difference: float, coarse: float, mesh: MeshSettings, scatter: float | None, plain: bool
) -> float:
    """Share of the mesh in the uncertainty of W over A f^2 P^2; NaN on a mesh hardly finer than that of the coarse run.

    Parameters
    ----------
    dissipation, difference : W, and by how much that of the coarse run is off it, over A f^2 P^2
    coarse : element of the coarse run, over the half-width
    scatter : rms of what edges between nodes add to W, over A f^2 P^2; 0 where none stands, None where that is not known
    plain : linear elements or a penalty layer, whose errors are not of order 2: the whole difference counts

    >>> round(uncertainty(0.1, 0.01, 0.1, MeshSettings(edge_element_size=0.01), 1e-5, plain=False), 12)
    0.000106510101
    """
    element = mesh.edge_element_size * max(mesh.upper_ratio, 1.0)
    refinement = coarse / element
    if refinement < _LEAST_REFINEMENT:
        return float("nan")
    of_difference, of_scatter, of_work, of_unit = _SHARES["unknown" if scatter is None else "corrected" if scatter else "moving"]
    share = of_difference / (refinement**2 - 1)  # what an error of order 2 leaves of itself
    # Where no node slips, nothing scatters: a note says what may be unseen.
    placed = (of_work * dissipation + of_unit) * element**2 if dissipation else 0.0
    return (
        difference * (max(share, 1.0) if plain else share)
        + of_scatter * (scatter or 0.0)
        + placed
        + _GROWN * mesh.growth**4 * dissipation
    )


def uncertainty_note(dissipation: float, uncertain: float, tolerance: float, coarse: float) -> Iterator[str]:
    """That W is uncertain by more than its tolerance, or by an unknown amount; `coarse` is that of the coarse run, or NaN."""
    if np.isnan(dissipation):
        return
    if np.isnan(uncertain):
        why = (
            "its bodies are shared, without a coarse run of this scene"
            if np.isnan(coarse)
            else "the coarse run has elements like these"
        )
        yield f"the dissipation has no uncertainty estimate: {why}"
    elif uncertain > tolerance * dissipation and uncertain > 0:
        share = f" ({uncertain / dissipation:.2%}, for a tolerance of {tolerance:.2%})" if dissipation else ""
        yield f"the dissipation is uncertain by {uncertain:.3g}{share}: make edge_element_size or step_tolerance smaller"
