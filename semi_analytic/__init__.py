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

    sweeps.py                              `dissipation` and `peak_dissipation`
    batch_members.py, batch_profiles.py    arguments in blocks, profiles with arrays for parameters
    batch_compound.py                      two curvatures of them
    batch_ellipses.py                      angles and loads of steady ellipses
    batch.py, batch_kernel.py              W by one Gauss rule, which batch_rules.py chooses
    batch_flat.py                          slip area of the flat and rounded face in few passes
    batch_cuts.py                          W in pieces, for profiles with corners
    batch_density.py                       W(x) and its peak
"""

from semi_analytic.batch import Reason
from semi_analytic.damping import Hysteresis, compliance, hysteresis
from semi_analytic.letters import Event, event, events
from semi_analytic.question import FIELDS
from semi_analytic.solution import solve
from semi_analytic.sweeps import DissipationBatch, PeakBatch, dissipation, peak_dissipation

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
