r"""What the pages need of Sphinx beyond its own extensions.

- formulas become MathML, which browsers draw by themselves: pages need neither a network nor a
  script. Sphinx has MathJax (a script from the network) and pictures (LaTeX); docutils has the
  conversion
- napoleon reads docstrings in numpydoc form; their prose holds |Q| and a_, which reStructuredText
  would read as marks: they are escaped
- classes show their fields without types, which are long unions in a scene, and types have the
  names of the source
- each page of reports/published has a place among the pages
"""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

PUBLISHED = Path(__file__).parents[1] / "reports" / "published"
SHARED = re.compile(r"\w+(, \w+)+")
CODE = re.compile(r"(`+[^`]+`+)")
ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")
MARK = re.compile(r"(?<!\\)([*|])|(?<=\w)_(?=\W|$)")


def inline_math(translator: Any, node: nodes.math) -> None:
    """A formula in a line of text."""
    translator.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def block_math(translator: Any, node: nodes.math_block) -> None:
    """A formula by itself; wide ones scroll on a phone."""
    translator.body.append('<div class="formula">')
    for line in node.astext().split("\n\n"):
        translator.body.append(tex2mathml(line, as_block=True))
    translator.body.append("</div>")
    raise nodes.SkipNode


def escape_prose(
    _app: Sphinx, _kind: str, _name: str, _object: Any, _options: Any, lines: list[str]
) -> None:
    """Escape what would be marks of reStructuredText in a docstring, beside `code` and doctests.

    Of attributes that share a description napoleon would take the first for a type, but for the
    blank between them.
    """
    in_doctest = False
    for index, line in enumerate(lines):
        if SHARED.fullmatch(line) and lines[index + 1].startswith("    "):
            lines[index] = line.replace(", ", ",")
            continue
        in_doctest = line.lstrip().startswith(">>>") or (in_doctest and bool(line.strip()))
        if not in_doctest:
            parts = CODE.split(line)
            parts[::2] = [MARK.sub(r"\\\g<0>", part) for part in parts[::2]]
            lines[index] = "".join(parts)


def signature(
    _app: Sphinx,
    kind: str,
    _name: str,
    documented: Any,
    _options: Any,
    arguments: str | None,
    returned: str | None,
) -> tuple[str, str] | None:
    """The signature of a class without types, that of a function with the names of types."""
    if kind == "class" and arguments:
        parameters = inspect.signature(documented).parameters.values()
        plain = [parameter.replace(annotation=inspect.Parameter.empty) for parameter in parameters]
        return str(inspect.Signature(plain)), ""
    if arguments is None:
        return None
    return ALIAS.sub(r"\1", arguments), ALIAS.sub(r"\1", returned or "")


def published_pages(app: Sphinx) -> None:
    """Give each page of reports/published a place among the pages, in docs/published, which is not
    kept.
    """
    folder = Path(app.srcdir) / "published"
    pages = {
        path.relative_to(PUBLISHED): path.read_text(encoding="utf-8")
        for path in PUBLISHED.rglob("*.md")
    }
    del pages[Path("README.md")]  # the gallery stands for it
    for name, text in pages.items():
        up = "../" * len(name.parts)
        files = f"{up}../reports/published/{name.parent.as_posix()}"
        moved = re.sub(r"\]\((\S+\.(?:svg|json|csv))\)", rf"]({files}/\1)", text)
        if len(name.parts) == 1:
            moved = moved.replace("](README.md)", "](../gallery.md)")
        path = folder / name
        page = f"---\norphan: true\n---\n\n{moved}"
        if not path.is_file() or path.read_text(encoding="utf-8") != page:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(page, encoding="utf-8")
    for path in folder.rglob("*.md"):
        if path.relative_to(folder) not in pages:
            path.unlink()


def links(_app: Sphinx, _name: str, source: list[str]) -> None:
    """Where a page links to the file of a published page, as in the repository, link to its copy
    among the pages.
    """
    source[0] = re.sub(r"\]\(\.\./reports/published/([\w/-]+\.md)\)", r"](published/\1)", source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.add_html_math_renderer("mathml", (inline_math, None), (block_math, None))
    app.connect("autodoc-process-signature", signature)
    app.connect("builder-inited", published_pages)
    app.connect("source-read", links)
    app.connect("autodoc-process-docstring", escape_prose, priority=100)  # before napoleon
    return {"parallel_read_safe": True, "parallel_write_safe": True}
