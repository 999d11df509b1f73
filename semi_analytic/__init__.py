"""The half-plane engine: partial slip of any symmetric profile under any history of P and Q, exact to rounding.

Normal contact, one profile a file, `Contact` being what the rest asks of each::

    contact.py                             what is asked of a profile, and who answers for which
    elasticity.py                          E*, Dundurs' beta
    hertz.py, power_law.py, polynomial.py  closed forms
    flat_rounded.py                        with flat_law.py (load and logarithm) and flat_integrals.py
    compound.py, wedge.py                  two curvatures, with tip.py (the rounded tip)
    tabulated.py, callable_profile.py      measured rows, Python functions
    pile.py, sheets.py                     any P(a) by quadrature, where there is no closed form

The history of P and Q::

    legs.py, turning.py                    P, Q and Q -+ f P along a leg: changes, turning points, inverses
    memory.py                              the memory curve M(eta), Masing's rule: what a load does to it
    load_series.py                         straight paths of any length: knots of the curve, W and W(x) of each step
    history.py                             curved paths: spans of stick, slip and unloading, the steady cycle, gross sliding
    event_times.py                         the instants A to M
    roundoff.py                            what the last digits of P cost

From a request to an answer::

    request.py                             points, instants and fields that are asked for
    fields.py                              q, s and the relative tangential displacement U: Ciavarella-Jaeger superposition
    arcs.py, curved.py                     q, s and U of arcs of ellipses, of other legs
    friction_work.py                       W, W(x), the closed integral of Q dU, W as the integral of W(x); convergence by halving
    quadrature.py, panels.py               the rules of quadrature
    solution.py                            all of it together: `solve`, and what a solution says of itself
    errors.py                              estimated errors
    damping.py                             stiffness and damping of the loop

Arrays of ellipses in one call::

    batches.py                             `dissipation` and `peak_dissipation`: arguments in blocks, profiles in units of their own
    steady_ellipse.py                      angles and loads of steady ellipses; W and W(x) of each, however small the slip
    slip_work.py                           W of many: over the contact (slip moment), or by Lam and one Gauss rule for each phase
    density_peaks.py                       the maxima of W(x)
"""

from semi_analytic.batches import DissipationBatch, PeakBatch, Reason, dissipation, peak_dissipation
from semi_analytic.damping import Hysteresis, compliance, hysteresis
from semi_analytic.event_times import Event, event, events
from semi_analytic.request import FIELDS
from semi_analytic.solution import solve

__all__ = [
    "FIELDS",
    "DissipationBatch",
    "Event",
    "Hysteresis",
    "PeakBatch",
    "Reason",
    "compliance",
    "dissipation",
    "event",
    "events",
    "hysteresis",
    "peak_dissipation",
    "solve",
]


def __dir__() -> list[str]:
    return sorted(__all__)
