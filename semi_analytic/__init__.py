"""The half-plane engine: partial slip of any profile under any history of P and Q, with bulk stress
and tilt, exact to rounding.

Normal contact::

    elasticity.py           composite modulus E*, Dundurs' beta
    hertz.py                Hertz law: the parabola in closed form
    profiles.py             P(a) of every profile: flat and rounded, power law, two curvatures; Abel
                            transform of tables
    punch_superposition.py  Ciavarella-Jaeger superposition of flat punches: p, outer displacement
                            and slip kernel of any P(a)
    tilted_profile.py       normal contact with tilt and bulk strain, also with unequal sides:
                            families of nested contact intervals
    opposite_slip.py        large bulk stress at constant P: ends that slip opposite ways (Nowell
                            and Hills)

The history of P and Q::

    memory.py               memory curve M(eta): full stick, slip up to the Coulomb limit, reversal
                            (Masing rule), unloading
    history.py              curved paths: spans of stick and slip, the steady cycle, gross sliding
                            and separation
    loops_in_phase.py       the steady cycle of P, Q, bulk and tilt in phase: W, W(x), stick zone
                            (Andresen, Hills and Moore)
    grid.py                 any other, on a grid: stick in any number of pieces, with the error of
                            the grid
    load_series.py          straight paths of any length: knots of the memory curve, slip of each
                            step
    event_times.py          events: the instants A to M
    bulk_and_tilt.py        bulk stress and tilt: which paths have one memory curve; eccentricity of
                            stick (Nowell and Hills)

From a request to an answer::

    fields.py               shear traction q (Cattaneo-Mindlin), slip s, relative tangential
                            displacement U by superposition
    friction_work.py        global and pointwise dissipation W and W(x), the area of the loop of Q
                            over U
    quadrature.py           Gauss' rule; trapezoidal rule for singular ends
    solution.py             `solve`: which method answers a scene
    answer.py               the question, what is found, the record of a ContactSolution
    answer_by_memory.py     one memory curve: states, fields, dissipations
    stated_errors.py        how far its values may be from exact ones: an estimate for each kernel
    answer_in_phase.py      loads in phase: the steady cycle alone
    answer_on_grids.py      all other loads, on grids
    corrected.py            theory with what finite bodies add to the compliance of half-planes:
                            curvatures that follow the loads, c_n and c_t
    corrected_memory.py     its memory curve: clipped between two bounds that follow the loads
    inner_slip.py           slip zones inside the contact, where that curve breaks Coulomb's law
    driven.py               rigs: Q and P that follow from prescribed displacements, gross sliding,
                            the spring of the rig, separation
    answer_of_rig.py        the answer to a scene of a rig, under the loads that were found
    odd_part_of_rig.py      what tilt and bulk strain of the bodies add to W there
    regimes.py              fretting map: partial slip, mixed, gross sliding over stroke and P
    next_order.py           how large the order after the curvatures is, and what is left after it
    body_numbers.py         the numbers of finite bodies, and their check at the door
    odd_memory.py           what tilt and bulk strain of the bodies add to W of a parabola, in the
                            second order, beside the memory curve; centres of contact and stick
    stroke_end.py           what the smooth end of a stroke leaves there
    tilt_and_strain.py      what tilt and bulk strain of the bodies add to W of any profile: in the
                            second order, or on grids
    subsurface.py           stress inside the bodies (McEwen), tension at the trailing edge
    largest_values.py       largest pressure, slip, W(x) and tension of a cycle, to 1e-9 of
                            themselves
    damping.py              hysteresis: secant stiffness, damping ratio, tangential compliance

Arrays of ellipses in one call::

    batches.py              `dissipation` and `peak_dissipation` of arrays of loads and profiles,
                            the maxima of W(x)
    corrected_batches.py    W of ellipses with the effects of bodies: a play operator for each punch
    phases.py               the lag of Q behind P, in degrees or in radians
    steady_ellipse.py       W and W(x) of a steady ellipse, its permanent stick zone
    measured_friction.py    `friction_from`: every coefficient of friction that gives a measured W
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from semi_analytic.answer import FIELDS
    from semi_analytic.batches import (
        DissipationBatch,
        PeakBatch,
        Reason,
        dissipation,
        peak_dissipation,
    )
    from semi_analytic.bulk_and_tilt import Eccentricity, eccentricity
    from semi_analytic.damping import Hysteresis, compliance, hysteresis
    from semi_analytic.event_times import Event, event, events
    from semi_analytic.largest_values import Extremes, extremes
    from semi_analytic.measured_friction import FrictionBatch, NoFriction, friction_from
    from semi_analytic.regimes import FrettingMap, Regime, fretting_map
    from semi_analytic.solution import solve
    from semi_analytic.subsurface import edge_tension, stress
    from semi_analytic.tilt_and_strain import change_by_tilt_and_strain

__all__ = [
    "FIELDS",
    "DissipationBatch",
    "Eccentricity",
    "Event",
    "Extremes",
    "FrettingMap",
    "FrictionBatch",
    "Hysteresis",
    "NoFriction",
    "PeakBatch",
    "Reason",
    "Regime",
    "change_by_tilt_and_strain",
    "compliance",
    "dissipation",
    "eccentricity",
    "edge_tension",
    "event",
    "events",
    "extremes",
    "fretting_map",
    "friction_from",
    "hysteresis",
    "peak_dissipation",
    "solve",
    "stress",
]

_HOME = {
    "FIELDS": "semi_analytic.answer",
    "DissipationBatch": "semi_analytic.batches",
    "Eccentricity": "semi_analytic.bulk_and_tilt",
    "Event": "semi_analytic.event_times",
    "Extremes": "semi_analytic.largest_values",
    "FrettingMap": "semi_analytic.regimes",
    "FrictionBatch": "semi_analytic.measured_friction",
    "Hysteresis": "semi_analytic.damping",
    "NoFriction": "semi_analytic.measured_friction",
    "PeakBatch": "semi_analytic.batches",
    "Reason": "semi_analytic.batches",
    "Regime": "semi_analytic.regimes",
    "change_by_tilt_and_strain": "semi_analytic.tilt_and_strain",
    "compliance": "semi_analytic.damping",
    "dissipation": "semi_analytic.batches",
    "eccentricity": "semi_analytic.bulk_and_tilt",
    "edge_tension": "semi_analytic.subsurface",
    "event": "semi_analytic.event_times",
    "events": "semi_analytic.event_times",
    "extremes": "semi_analytic.largest_values",
    "fretting_map": "semi_analytic.regimes",
    "friction_from": "semi_analytic.measured_friction",
    "hysteresis": "semi_analytic.damping",
    "peak_dissipation": "semi_analytic.batches",
    "solve": "semi_analytic.solution",
    "stress": "semi_analytic.subsurface",
}


def __getattr__(name: str) -> Any:
    # What a name needs is loaded where it is first used.
    if name not in _HOME:
        raise AttributeError(f"module 'semi_analytic' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
