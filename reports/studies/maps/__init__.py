"""Maps of the idealisation error: how far half-plane theory is off for each kind of body, over its
height, its width and friction.

    families    kinds of body, and their scenes
    errors      errors by numbers, kernels and finite elements; heights from which theory holds
    pages       figures, tables and pages from the tables of a folder
    commands    `halfplane map` and `halfplane advise`

docs/maps.md describes them; the published ones are in reports/published/maps.
"""

from __future__ import annotations

__all__: list[str] = []
