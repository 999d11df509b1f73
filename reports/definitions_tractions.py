"""What the metrics of pressure and shear are."""

from __future__ import annotations

from reports.definition import INSTANTS, L2_IN_SPACE, MAXIMUM, MAXIMUM_IN_TIME, POINTS, Definition

_NEAREST = "where several peaks of the reference lie within 5 % of its largest, the nearest of them"

TRACTIONS = (
    Definition(
        key="peak_pressure",
        label="Peak pressure",
        unit="of peak p_ref",
        norm=MAXIMUM_IN_TIME,
        region=POINTS,
        text="largest p less largest p_ref, over largest p_ref, both over the same points",
        headline=True,
    ),
    Definition(
        key="pressure",
        label="Pressure, L2",
        unit="of ‖p_ref‖",
        norm=L2_IN_SPACE,
        region=POINTS,
        text="L2 norm over x of p less p_ref, over the norm of p_ref",
        signed=False,
        headline=True,
    ),
    Definition(
        key="shear",
        label="Shear traction, L2",
        unit="of f ‖p_ref‖",
        norm=L2_IN_SPACE,
        region=POINTS,
        text="L2 norm over x of q less q_ref, over f times the norm of p_ref, since q changes sign on the way",
        signed=False,
        headline=True,
    ),
    Definition(
        key="pressure_maximum",
        label="Pressure, maximum",
        unit="of peak p_ref",
        norm=MAXIMUM,
        region=POINTS,
        text="p less p_ref where it is largest in size, over the largest p_ref of the instant; with its place",
    ),
    Definition(
        key="pressure_peak_place",
        label="Place of peak pressure",
        unit="of a_ref",
        norm=MAXIMUM_IN_TIME,
        region=POINTS,
        text=f"x of the largest p less x of the largest p_ref, to a point; {_NEAREST}",
    ),
    Definition(
        key="shear_maximum",
        label="Shear traction, maximum",
        unit="of f peak p_ref",
        norm=MAXIMUM,
        region=POINTS,
        text="q less q_ref where it is largest in size, over f times the largest p_ref of the instant; with its place",
    ),
    Definition(
        key="peak_shear",
        label="Peak shear traction",
        unit="of f peak p_ref",
        norm=MAXIMUM_IN_TIME,
        region=POINTS,
        text="largest size of q less that of q_ref, over f times the largest p_ref of the instant",
    ),
    Definition(
        key="shear_peak_place",
        label="Place of peak shear traction",
        unit="of a_ref",
        norm=MAXIMUM_IN_TIME,
        region=f"{POINTS} that carry shear",
        text=f"x where q is largest in size less that of q_ref, to a point; {_NEAREST}",
    ),
    Definition(
        key="resultant_normal",
        label="Normal resultant",
        unit="of P",
        norm=MAXIMUM_IN_TIME,
        region=INSTANTS,
        text="resultant of the result's tractions less P, over P: with the result's own weights and normals where it has them "
        "(needs no reference), else by the trapezoidal rule less what the same rule misses of the reference",
    ),
    Definition(
        key="resultant_tangential",
        label="Tangential resultant",
        unit="of P",
        norm=MAXIMUM_IN_TIME,
        region=INSTANTS,
        text="resultant of the result's tractions less Q, over P: by the rule of the normal resultant",
    ),
)
