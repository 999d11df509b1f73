"""A loop that was fitted to rows: f with its interval, the rig, and where the rows lie.

# notation: C compliance of the rig, f friction coefficient, r factor of the file's Q over the
#           scene's, U relative displacement
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reports.scoring.loop_masing import MasingLoop
from reports.scoring.loop_masing_fit import MasingFit
from reports.scoring.loop_rows import MeasuredLoop
from reports.scoring.loop_steadiness import Misfit
from reports.scoring.loop_theory import SHARES_OF_CYCLE
from scenes import Scene
from scenes.array_types import Array

_NO_MISFIT = Misfit(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class FittedLoop:
    """A loop that was fitted to n measured rows: f with its interval, the rig, and where the rows
    lie on the scene's cycle.

    Attributes
    ----------
    scene
        the scene whose loop was fitted
    friction, lowest_friction, highest_friction
        f and its 95 % interval; the highest is None where the rows exclude no larger f
    compliance
        C of the rig [1/stress]
    share_of_cycle
        (n,) share of the scene's cycle that is over at each row, 0 to 1
    cycles_passed
        (n,) cycles that have passed at each row, from any instant on
    n_cycles
        number of cycles that the rows cover
    load_scale, offset
        r and Q0 with which the file's Q is r Q + Q0 of the scene
    displacement_noise, load_noise
        standard deviation of the noise of U and of Q
    sentences
        what was assumed or left out
    misfit
        correlation of the distances of neighbouring rows, and their systematic part; none where
        rows are placed over time
    masing_loop, masing_fit
        the fitted loop of Masing's rule, and its fit; None where P varies
    is_gross
        whether the contact slides as a whole at the ends of the loop
    """

    scene: Scene
    friction: float
    lowest_friction: float
    highest_friction: float | None
    compliance: float
    share_of_cycle: Array
    cycles_passed: Array
    n_cycles: float
    load_scale: float
    offset: float
    displacement_noise: float
    load_noise: float
    sentences: tuple[str, ...]
    misfit: Misfit = _NO_MISFIT
    masing_loop: MasingLoop | None = None
    masing_fit: MasingFit | None = None
    is_gross: bool = False


def sentences_on_scale(load_scale: float) -> list[str]:
    """A sentence that Q of the file is not that of the scene, where `load_scale`, the one over the
    other, is not 1.
    """
    if abs(load_scale - 1) <= 1e-3:
        return []
    return [
        f"Q of the file is {load_scale:.4g} times that of the scene: loads as in the file were"
        " taken, P as in the scene"
    ]


def fit_rig(
    measured_loop: MeasuredLoop,
    theory_displacement: Array,
    fraction_of_cycle: Array,
    load_of_cycle: Array,
    load_scale: float,
    rig_compliance: float | None,
) -> tuple[float, float, float]:
    """Fit the rig to the rows of a measured loop: compliance C and origin U0 of U = r U_theory + C
    r Q + U0, by linear least squares, with Q of the scene. Returns the sum of squared residuals of
    U [length^2], C [1/stress] and U0 [length].

    Parameters
    ----------
    measured_loop
        U and Q of the n rows
    theory_displacement, load_of_cycle
        (n_instants,) U of theory, and r Q(t) of the scene, through one cycle
    fraction_of_cycle
        (n,) fraction of the cycle that has passed at each row
    load_scale
        r, the file's Q over the scene's
    rig_compliance
        C [1/stress], where it is stated; None fits it

    # notation: Q tangential load, U relative tangential displacement
    """
    # SHARES_OF_CYCLE: the instants of the cycle, from 0 to 1
    load_at_rows = np.interp(fraction_of_cycle, SHARES_OF_CYCLE, load_of_cycle)
    scaled_theory_displacement = load_scale * np.interp(
        fraction_of_cycle, SHARES_OF_CYCLE, theory_displacement
    )
    displacement_of_rig = measured_loop.displacement - scaled_theory_displacement
    if rig_compliance is not None:
        displacement_of_rig = displacement_of_rig - rig_compliance * load_at_rows
        origin = float(np.mean(displacement_of_rig))
        return float(np.sum((displacement_of_rig - origin) ** 2)), rig_compliance, origin
    columns = np.column_stack([load_at_rows, np.ones(len(fraction_of_cycle))])
    compliance_and_origin = np.linalg.lstsq(columns, displacement_of_rig, rcond=None)[0]
    residuals = displacement_of_rig - columns @ compliance_and_origin
    return (
        float(np.sum(residuals**2)),
        float(compliance_and_origin[0]),
        float(compliance_and_origin[1]),
    )
