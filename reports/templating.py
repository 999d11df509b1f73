"""The one way to fill a page: every word from outside is escaped, a name that is missing is an error."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape

from reports.units import minus


def template(name: str) -> Template:
    """The template `name` of `reports/templates`."""
    pages = Environment(
        loader=PackageLoader("reports"),
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    pages.filters["minus"] = minus
    return pages.get_template(name)
