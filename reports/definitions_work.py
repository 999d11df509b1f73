"""What the metrics of rigid motion, hysteresis and dissipation are."""

from __future__ import annotations

from reports.definition import FIGURE, INSTANTS, MAXIMUM_IN_TIME, WHOLE, Definition

_SCALE = "A f² P_ref²"
_POINTS = "every point, edges kept; last cycle"

HEADLINES = (
    Definition(
        key="tangential_displacement",
        label="Tangential displacement",
        unit="of U_ref's stroke",
        norm=MAXIMUM_IN_TIME,
        region=INSTANTS,
        text="U less U_ref over the range of U_ref in the cycle",
        headline=True,
    ),
    Definition(
        key="dissipation",
        label="Dissipation",
        unit="of W_ref",
        norm=FIGURE,
        region=WHOLE,
        text="W less W_ref",
        absolute_unit=_SCALE,
        headline=True,
    ),
    Definition(
        key="dissipation_polygon",
        label="Dissipation, steps' error out",
        unit="of W_ref",
        norm=FIGURE,
        region=WHOLE,
        text="W less the reference's W on the straight lines between the instants: every error but that of the steps",
        absolute_unit=_SCALE,
        headline=True,
    ),
    Definition(
        key="dissipation_step",
        label="Dissipation, steps' error only",
        unit="of W_ref",
        norm=FIGURE,
        region=WHOLE,
        text="the reference's W on the straight lines between the instants less its W on the smooth path",
        absolute_unit=_SCALE,
        headline=True,
    ),
    Definition(
        key="hysteresis",
        label="Hysteresis loop",
        unit="of its area",
        norm=FIGURE,
        region=WHOLE,
        text="closed integral of Q dU less that of the reference, both by the trapezoidal rule over the same instants",
        absolute_unit=_SCALE,
        headline=True,
    ),
    Definition(
        key="dissipation_density",
        label="Pointwise dissipation",
        unit="of largest w_ref",
        norm="value at the worst point",
        region=_POINTS,
        text="w(x) less w_ref(x) over the largest w_ref; with its place",
        absolute_unit=f"{_SCALE}/a_ref",
        headline=True,
    ),
    Definition(
        key="permanent_stick",
        label="Permanent stick",
        unit="of a_ref",
        norm=FIGURE,
        region=WHOLE,
        text="half-width that sticks through the whole last cycle less the reference's",
        headline=True,
    ),
)

WORK = (
    Definition(
        key="dissipation_absolute",
        label="Dissipation, absolute",
        unit=f"of {_SCALE}",
        norm=FIGURE,
        region=WHOLE,
        text="W less W_ref over A f² P_ref², which stays of use near full stick, where W_ref goes to 0",
    ),
    Definition(
        key="hysteresis_distance",
        label="Hysteresis loop, distance",
        unit="of U_ref's stroke",
        norm=MAXIMUM_IN_TIME,
        region=INSTANTS,
        text="U less U_ref less the mean of that over time: how far the loops are apart in U at the same phase (and so at the same "
        "Q), laid on each other",
    ),
    Definition(
        key="dissipation_density_norm",
        label="Pointwise dissipation, L2",
        unit="of ‖w_ref‖",
        norm="L2 over x",
        region=_POINTS,
        text="L2 norm over x of w less w_ref, over the norm of w_ref",
        signed=False,
        absolute_unit=f"{_SCALE}/√a_ref",
    ),
    Definition(
        key="dissipation_density_peak",
        label="Pointwise dissipation, peak",
        unit="of largest w_ref",
        norm=FIGURE,
        region=_POINTS,
        text="largest w less largest w_ref, over largest w_ref, both over the same points",
        absolute_unit=f"{_SCALE}/a_ref",
    ),
    Definition(
        key="dissipation_density_peak_place",
        label="Pointwise dissipation, place of peak",
        unit="of a_ref",
        norm=FIGURE,
        region=_POINTS,
        text="x of the largest w less x of the largest w_ref, to a point; where several peaks of the reference lie within 5 % of "
        "its largest, the nearest of them",
    ),
    Definition(
        key="energy_balance",
        label="Energy balance",
        unit="of the work of the loads",
        norm=MAXIMUM_IN_TIME,
        region=WHOLE,
        text="what the loads put in less what the bodies store and friction takes, step by step, over the "
        "largest that the loads have put in so far, as the result's record states it; needs no reference",
        signed=False,
    ),
)
