"""The one way to fill a page: every word from outside is escaped, a name that is missing is an error."""

from __future__ import annotations

import base64
import hashlib
import re
from functools import cache
from importlib import resources

from jinja2 import Environment, PackageLoader, StrictUndefined, Template, select_autoescape
from markupsafe import Markup

from reports.charts.style import marked
from reports.units import minus, number, signed


@cache
def _pages() -> Environment:
    pages = Environment(
        loader=PackageLoader("reports"),
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    pages.filters |= {"minus": minus, "number": number, "signed": signed, "marked": marked, "contents": _contents}
    return pages


def template(name: str) -> Template:
    """The template `name` of `reports/templates`."""
    return _pages().get_template(name)


def _contents(page: str) -> Markup:
    """Links to every section of a page that has a name and a heading, in their order.

    >>> _contents('<section id="mesh"><h2>The mesh</h2>')
    Markup('<ul><li><a href="#mesh">The mesh</a></li></ul>')
    """
    found = re.findall(r'<section id="([\w-]+)"[^>]*>\s*<h2>(.*?)</h2>', page, re.DOTALL)
    return Markup("<ul>" + "".join(f'<li><a href="#{place}">{words}</a></li>' for place, words in found) + "</ul>")


def script() -> tuple[Markup, str]:
    """The script of all pages without its indents and notes, and what a page's policy calls it: no other may run."""
    text = (resources.files("reports") / "templates" / "report.js").read_text("utf-8")
    text = re.sub(r"^ +(// .*\n|/\*.*\*/\n)?", "", text, flags=re.MULTILINE)
    return Markup(text), "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
