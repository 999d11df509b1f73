"""What each metric is: one row for each, the same words on the page, in the terminal and in comparison.json."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Definition:
    """The words of a metric.

    Attributes
    ----------
    key, label : for programs and for people; a key that is a field of the scene's Tolerances is judged by it
    unit : what its value is a share of
    text : how it is computed
    signed : whether its sign has a meaning (result less reference); a norm has none
    absolute_unit : unit where the reference's own figure is 0 and nothing can be relative to it
    """

    key: str
    label: str
    unit: str
    text: str
    signed: bool = True
    absolute_unit: str = ""


_ROWS = (
    Definition(
        "peak_pressure",
        "Peak pressure",
        "of peak p_ref",
        "largest p less largest p_ref, over largest p_ref, both over the same points; worst instant",
    ),
    Definition(
        "pressure",
        "Pressure, L2",
        "of ‖p_ref‖",
        "L2 norm over x of p less p_ref, over the norm of p_ref; worst instant",
        signed=False,
    ),
    Definition(
        "shear",
        "Shear traction, L2",
        "of f ‖p_ref‖",
        "L2 norm over x of q less q_ref, over f times the norm of p_ref; worst instant",
        signed=False,
    ),
    Definition("contact_edge", "Contact edge", "of a_ref", "outward shift of the worse edge; worst instant"),
    Definition("stick_edge", "Stick edge", "of a_ref", "outward shift of the worse edge, where both have one; worst instant"),
    Definition(
        "state",
        "Stick/slip map",
        "of the contact",
        "share of the length in contact whose state (open, stick, forward or reverse slip) differs, mean over the cycle",
        signed=False,
    ),
    Definition(
        "rigid_shift",
        "Rigid shift",
        "of U_ref's stroke",
        "U less U_ref over the range of U_ref in the cycle; worst instant",
    ),
    Definition("dissipation", "Dissipation", "of W_ref", "W less W_ref, both of the last cycle", absolute_unit="A f² P_ref²"),
    Definition(
        "dissipation_polygon",
        "Dissipation, steps' error out",
        "of W_ref",
        "W less the reference's W on the straight lines between the instants: every error but that of the steps",
        absolute_unit="A f² P_ref²",
    ),
    Definition(
        "dissipation_step",
        "Dissipation, steps' error only",
        "of W_ref",
        "the reference's W on the straight lines between the instants less its W on the smooth path",
        absolute_unit="A f² P_ref²",
    ),
    Definition(
        "hysteresis",
        "Hysteresis loop",
        "of its area",
        "closed integral of Q dU less that of the reference, both by the trapezoidal rule over the same instants",
        absolute_unit="A f² P_ref²",
    ),
    Definition(
        "dissipation_density",
        "Pointwise dissipation",
        "of largest w_ref",
        "w(x) less w_ref(x) over the largest w_ref; worst point",
        absolute_unit="A f² P_ref²/a_ref",
    ),
    Definition(
        "permanent_stick",
        "Permanent stick",
        "of a_ref",
        "half-width that sticks through the whole last cycle less the reference's",
    ),
)
DEFINITIONS = {row.key: row for row in _ROWS}

_ENGINES = {"semi_analytic": "half-plane theory", "halfplane_fe": "finite elements"}


def name_of(engine: str) -> str:
    """What an engine is called on the page.

    >>> name_of("halfplane_fe"), name_of("somebody's code")
    ('finite elements', "somebody's code")
    """
    return _ENGINES.get(engine, engine)
