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

    legs.py                                P, Q and Q -+ f P along a load segment: changes, turning points, inverses
    memory.py                              the memory curve M(eta), and what a load does to it
    history.py, sides.py                   the march: stick, slip, unloading, the steady cycle, gross sliding
    route.py                               the scene's path or straight steps, its cycles and instants
    rounding.py                            what the last digits of P cost
    letters.py                             the instants A to M

From a question to an answer::

    question.py, snapshot.py               what is asked; the memory curves of many instants as arrays
    evaluation.py, fields.py               half-widths, p, q, s and the rigid shift U
    arcs.py, curved.py                     q, s and U of arcs of ellipses, of other legs
    friction_work.py                       W, W(x), the closed integral of Q dU
    over_points.py                         W as the integral of W(x)
    corners.py, settling.py                where integrals are cut, and when they are done
    quadrature.py, panels.py               the rules of quadrature
    solution.py                            all of it together: `solve`
    bookkeeping.py, proofs.py, errors.py   what a solution says of itself
    damping.py                             stiffness and damping of the loop

Long measured series, row by row::

    time_series.py, rows.py, stack.py      rows through a stack of knots
    row_work.py, row_solution.py           their W and W(x), and the answer

Arrays of ellipses in one call::

    batches.py                             `dissipation` and `peak_dissipation`: arguments in blocks, profiles in units of their own
    steady_ellipse.py                      angles and loads of steady ellipses; W and W(x) of each, however small the slip
    slip_work.py                           W of many: over the contact (slip moment), or by Lam and one Gauss rule for each phase
    density_peaks.py                       the maxima of W(x)
"""

from semi_analytic.batches import DissipationBatch, PeakBatch, Reason, dissipation, peak_dissipation
from semi_analytic.damping import Hysteresis, compliance, hysteresis
from semi_analytic.letters import Event, event, events
from semi_analytic.question import FIELDS
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
