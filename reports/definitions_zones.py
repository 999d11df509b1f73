"""What the metrics of contact, stick and slip are."""

from __future__ import annotations

from reports.definition import INSTANTS, L2_IN_SPACE, MAXIMUM, MAXIMUM_IN_TIME, WHOLE, Definition

_BOTH = f"{INSTANTS} at which both have one"
_RESOLUTION = "known to the step between two instants"
_IN_CONTACT = "points in contact in both; judged instants"
_STRETCHES = (
    "full stick is a stretch of at least two instants whose stick edges are the contact edges; each of the reference's is compared "
    "with the one of the result that shares most instants with it"
)

HEADLINES = (
    Definition(
        key="contact_edge",
        label="Contact edge",
        unit="of a_ref",
        norm=MAXIMUM_IN_TIME,
        region=INSTANTS,
        text="outward shift of the worse edge",
        headline=True,
    ),
    Definition(
        key="stick_edge",
        label="Stick edge",
        unit="of a_ref",
        norm=MAXIMUM_IN_TIME,
        region=_BOTH,
        text="outward shift of the worse edge, where both have one (in full stick: the contact edge)",
        headline=True,
    ),
    Definition(
        key="state",
        label="Stick/slip map",
        unit="of the contact",
        norm="mean over the cycle",
        region="points in contact in either; instants in contact",
        text="share of the length in contact whose state (open, stick, forward or reverse slip) differs",
        signed=False,
        headline=True,
    ),
)

ZONES = (
    *(
        Definition(
            key=f"{kind}_edge_{side}",
            label=f"{kind.capitalize()} edge, {side}",
            unit="of a_ref",
            norm=MAXIMUM_IN_TIME,
            region=INSTANTS if kind == "contact" else _BOTH,
            text=f"outward shift of the {side} edge; also over the local spacing h of the result's points, and with the "
            "uncertainty that the result states",
        )
        for kind in ("contact", "stick")
        for side in ("left", "right")
    ),
    Definition(
        key="stick_set",
        label="Stick set, not shared",
        unit="of the union",
        norm="Jaccard distance over x and time",
        region="points that stick in either; last cycle",
        text="1 less the quotient of what sticks in both and what sticks in either, each measured by length times time",
        signed=False,
    ),
    Definition(
        key="full_stick_start",
        label="Start of full stick",
        unit="of the period",
        norm=MAXIMUM_IN_TIME,
        region=WHOLE,
        text=f"first instant of full stick less that of the reference, {_RESOLUTION}; {_STRETCHES}",
    ),
    Definition(
        key="full_stick_end",
        label="End of full stick",
        unit="of the period",
        norm=MAXIMUM_IN_TIME,
        region=WHOLE,
        text=f"last instant of full stick less that of the reference, {_RESOLUTION}; {_STRETCHES}",
    ),
    Definition(
        key="slip_reversal",
        label="Reversal of slip",
        unit="of the period",
        norm=MAXIMUM_IN_TIME,
        region=WHOLE,
        text="first instant of slip in the new sense less that of the reference, the sense being that of the longer slip zone, "
        f"{_RESOLUTION}",
    ),
    Definition(
        key="slip",
        label="Slip, L2",
        unit="of the range of s_ref",
        norm=L2_IN_SPACE,
        region=_IN_CONTACT,
        text="root of the mean square over x of s less s_ref, over the range of s_ref in the cycle",
        signed=False,
        absolute_unit="f p_ref a_ref/E*",
    ),
    Definition(
        key="slip_maximum",
        label="Slip, maximum",
        unit="of the range of s_ref",
        norm=MAXIMUM,
        region=_IN_CONTACT,
        text="s less s_ref where it is largest in size, over the range of s_ref in the cycle; with its place",
        absolute_unit="f p_ref a_ref/E*",
    ),
)
