r"""What the pages need of Sphinx beyond its own extensions.

- formulas become MathML, which browsers draw by themselves: pages need neither a network nor a
  script
- docstrings are prose with `code` and |Q|, not reStructuredText: marks that would mean something
  there are escaped
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx

_TITLES = (
    "Attributes",
    "Parameters",
    "Returns",
    "Yields",
    "Raises",
    "Notes",
    "Examples",
    "See Also",
    "Warns",
    "References",
)
PUBLISHED = Path(__file__).parents[1] / "reports" / "published"
_LISTS = ("Attributes", "Parameters", "Raises")
_CODE = re.compile(r"(``.+?``|`[^`\n]+`|:\w+:`[^`]+`)")


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


def plain(_app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Turn a docstring into what reStructuredText reads: prose escaped, sections as lists; doctests
    stay as they are.
    """
    lines[:] = [
        *_sections([_prose(line) for line in _example_first(lines)]),
        *(_fields(obj) if what == "class" and hasattr(obj, "model_fields") else ()),
    ]


def _example_first(lines: list[str]) -> list[str]:
    """The doctests of a docstring behind its first paragraph, so that they are on the first
    screen.
    """
    paragraphs = [part.split("\n") for part in re.split(r"\n\s*\n", "\n".join(lines).strip("\n"))]
    examples = [part for part in paragraphs[1:] if part[0].startswith(">>>")]
    ordered = [
        *paragraphs[:1],
        *examples,
        *(part for part in paragraphs[1:] if part not in examples),
    ]
    return [line for part in ordered for line in (*part, "")]


def _prose(line: str) -> str:
    if line.lstrip().startswith((">>>", "...", "..", ":")):
        return line
    return "".join(
        _as_code(part) if part.startswith("`") else part if part.startswith(":") else _escaped(part)
        for part in _CODE.split(line)
    )


def _fields(model: Any) -> Iterator[str]:
    """The keys of a part of a scene, with the words that its JSON schema has for them."""
    yield from ("", ".. rubric:: Keys", "")
    for name, field in model.model_fields.items():
        default = (
            ""
            if field.is_required() or field.default_factory
            else f" (default ``{field.default!r}``)"
        )
        yield _prose(
            f"- **{name}**{default}" + (f": {field.description}" if field.description else "")
        ).replace("\\*\\*", "**")
    yield ""


def _sections(lines: list[str]) -> Iterator[str]:
    """Under a title with a line of dashes that announces items each unindented line starts one:
    `names : what they are`.
    """
    title, doctest = "", False
    for index, line in enumerate(lines):
        after = lines[index + 1] if index + 1 < len(lines) else ""
        if line in _TITLES and after and set(after) == {"-"}:
            title = line
            yield from ("", f".. rubric:: {line}", "")
        elif not (line and set(line) == {"-"} and lines[index - 1] in _TITLES):
            doctest = line.startswith(">>>") or (doctest and bool(line.strip()))
            yield from (
                _items(line, title) if title in _LISTS and line.strip() and not doctest else (line,)
            )


def _items(line: str, title: str) -> Iterator[str]:
    """One line may hold several items: `key : short name; where : place in the paper`. An indented
    one goes on with the last.
    """
    if line.startswith(" "):
        yield f"  {line.strip()}"
        return
    for item in re.split(r"; (?=\w+(?:, \w+)* : )", line):
        names, colon, rest = item.partition(" : ")
        yield f"- **{names}**: {rest}" if colon or title == "Raises" else f"- {item}"


def _as_code(part: str) -> str:
    return part if part.startswith("``") else f"`{part}`"


def _escaped(text: str) -> str:
    return re.sub(r"(?<!\\)([*|])", r"\\\1", re.sub(r"(\w)_(?=\W|$)", r"\1\\_", text))


def signature(
    _app: Sphinx,
    what: str,
    name: str,
    obj: Any,
    options: Any,
    arguments: str | None,
    result: str | None,
) -> Any:
    """Names of types as they stand in the source; of a scene's parts and of results the fields
    alone, explained below.
    """
    if what == "class" and hasattr(obj, "model_fields"):
        keys = (
            name if field.is_required() else f"{name}=..."
            for name, field in obj.model_fields.items()
        )
        return f"(*, {', '.join(keys)})", ""
    if what == "class" and is_dataclass(obj):
        return f"({', '.join(_field(one) for one in fields(obj) if one.init)})", ""
    return tuple(
        re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", text) if text else text
        for text in (arguments, result)
    )


def _field(one: Field[Any]) -> str:
    if one.default is MISSING and one.default_factory is MISSING:
        return one.name
    shown = f"{one.default:.4g}" if isinstance(one.default, float) else repr(one.default)
    return f"{one.name}={shown if isinstance(one.default, str | int | float | None) else '...'}"


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
        path, now = folder / name, f"---\norphan: true\n---\n\n{moved}"
        if not path.is_file() or path.read_text(encoding="utf-8") != now:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(now, encoding="utf-8")
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
    app.connect("autodoc-process-docstring", plain, priority=100)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
