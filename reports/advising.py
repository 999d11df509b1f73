"""How wrong half-plane theory is for the bodies of a scene, and why: by the numbers of the bodies,
and where these do not say it by the kernel solve of the bodies.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from reports.advising_by_kernels import KernelAdvice, advise_by_kernels
from reports.advising_by_numbers import Advice, advise_by_numbers, words_of_refusal
from scenes import ConvergenceError, InputError, Scene, scene_of

if TYPE_CHECKING:
    from scenes import BodyEffects


class NoAdvice(InputError):
    """Neither the numbers of the bodies nor their kernels take the scene."""


def advise(
    scene: Scene | str | Path, limit: float = 0.05, effects: BodyEffects | None = None
) -> Advice | KernelAdvice:
    """How far half-plane theory is wrong for the finite bodies of a scene, in seconds, without
    solving these by finite elements.

    Theory corrected by elastic responses of the bodies answers where its uncertainty was checked
    against finite elements: flat faces, like materials, small tilt and bulk strain. Else
    half-planes with the compliance of the bodies added (kernels) are solved, in some seconds more.
    Where that is not possible, the answer is the size of the change by corrected theory, without a
    checked uncertainty.

    Parameters
    ----------
    scene
        a scene, the name of one in the library, or a file
    limit
        of |change of the dissipation|, relative, up to which theory may be used
    effects
        elastic responses of the bodies, where they are known already; None: they are computed

    Returns
    -------
    Advice or KernelAdvice
        of both: `work`, the change of the dissipation (finite elements/theory − 1) with its
        uncertainty; `verdict` on the limit; `changes` of other quantities; the sentence as `repr`

    Raises
    ------
    InputError
        Where the scene has no friction.
    NoAdvice
        An InputError too: where neither corrected theory nor kernels take the scene, also because
        theory dissipates nothing.

    Examples
    --------
    >>> from scenes import load_scene
    >>> advice = advise(load_scene("blocks"))
    >>> round(advice.work.value, 3)
    -0.027
    """
    stated_scene = scene_of(scene)
    if not stated_scene.friction.coefficient:
        raise InputError(
            f"{stated_scene.name}: friction.coefficient = 0: nothing is dissipated, so no error is"
            " relative to it"
        )

    # Corrected theory first; `reason_for_size_alone` is "" where its uncertainty was checked.
    advice = None
    try:
        advice = advise_by_numbers(stated_scene, limit, effects)
        reason_for_kernels = advice.reason_for_size_alone
    except InputError as refusal:
        reason_for_kernels = words_of_refusal(refusal)
    if advice is not None and not reason_for_kernels:
        return advice
    try:
        return advise_by_kernels(stated_scene, limit, reason_for_kernels)
    except (InputError, ConvergenceError) as refusal:
        if advice is not None:
            return replace(advice, refusal_of_kernels=str(refusal))
        raise NoAdvice(
            f"Not known: neither the numbers of the bodies ({reason_for_kernels.rstrip('.')}) nor"
            f" their kernel solve ({str(refusal).rstrip('.')}) take this scene. Solve it"
            " (`halfplane run`)."
        ) from refusal
