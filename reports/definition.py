"""The words of a metric as a value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Definition:
    """The words of a metric.

    Attributes
    ----------
    key, label : for programs and for people; a key that is a field of the scene's Tolerances is judged by it
    unit : what its value is a share of
    norm : how the differences at points and instants become one figure
    region : which points and instants count
    text : how it is computed
    signed : whether its sign has a meaning (result less reference); a norm has none
    absolute_unit : unit where the reference's own figure is 0 and nothing can be relative to it
    headline : whether it stands in the first table; the others follow in a second one
    """

    key: str
    label: str
    unit: str
    norm: str
    region: str
    text: str
    signed: bool = True
    absolute_unit: str = ""
    headline: bool = False


POINTS = "every point, edges kept; judged instants"
INSTANTS = "judged instants"
WHOLE = "last cycle"
MAXIMUM_IN_TIME = "value at the worst instant"
MAXIMUM = "value at the worst point and instant"
L2_IN_SPACE = "L2 over x; worst instant"
FIGURE = "one figure"
