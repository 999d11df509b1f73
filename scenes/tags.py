"""The closed set of tags by which scenes are found."""

from __future__ import annotations

from typing import Literal, get_args

Tag = Literal[
    # where it comes from
    "paper",
    "benchmark",
    "made-up-record",
    # profile
    "hertz",
    "flat",
    "compound",
    "wedge",
    "profile",
    # bodies and materials
    "half-planes",
    "bodies",
    "block",
    "pad",
    "cylinder",
    "unlike",
    # loads
    "ellipse",
    "polygon",
    "harmonics",
    "time-series",
    "line",
    "constant-load",
    "normal-only",
    "other-sense",
    "unloading",
    # what happens
    "partial-slip",
    "full-stick",
    "near-sliding",
    "frictionless",
    # what its expected numbers rest on
    "closed-form",
]


def tags() -> tuple[str, ...]:
    """Every tag, in groups: origin, profile, bodies and materials, loads, what happens, proof.

    >>> "paper" in tags()
    True
    """
    return get_args(Tag)
