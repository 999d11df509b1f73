"""Maps of the idealisation error: studies of finite elements against half-plane theory, their laws,
corrections and pages.

The studies are in `studies/`, the published tables and pages in reports/published/maps;
docs/maps.md describes them.
"""

from __future__ import annotations

from reports.studies.maps.laws import Law, fit_law

__all__ = ["Law", "fit_law"]
