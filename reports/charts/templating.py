"""The text of pages: templates, what marks look like by the page's style sheet, words with
subscripts, tables as CSV and Markdown.

Every word from outside is escaped, a name that is missing is an error.
"""

from __future__ import annotations

import base64
import hashlib
import re
import zlib
from collections.abc import Callable, Iterable, Mapping, MutableMapping, Sequence
from functools import cache
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple, TypeAlias

import jinja2
import numpy as np
from jinja2 import (
    ChoiceLoader,
    Environment,
    FunctionLoader,
    PackageLoader,
    StrictUndefined,
    Template,
    select_autoescape,
)
from markupsafe import Markup
from numpy.typing import ArrayLike, NDArray

from reports.units import minus, number, signed
from scenes import SurfaceState

_TEMPLATES = Path(__file__).parents[1] / "templates"

# -------------------------------------------------------------------------------------------- looks
STATE_NAMES = {
    SurfaceState.OPEN: "open",
    SurfaceState.STICK: "stick",
    SurfaceState.SLIP_FORWARD: "forward slip",
    SurfaceState.SLIP_REVERSE: "reverse slip",
}
# Eleven points of matplotlib's maps of these names; between them by straight lines the largest
# error of a channel is 6 of 255.
_MAPS = {
    "viridis": "440154 482475 414487 355f8d 2a788e 21918c 22a884 44bf70 7ad151 bddf26 fde725",
    "RdBu_r": "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f",
}


def colours_of(values: ArrayLike, name: str = "viridis") -> list[str]:
    """Colours #rrggbb of numbers from 0 to 1 on a scale of colours called `name`; numbers outside
    take the colour of the end.

    >>> colours_of([0.0, 0.05, 2.0])
    ['#440154', '#461264', '#fde725']
    """
    # red, green and blue at eleven points of the scale, (11, 3), straight lines between them
    # _MAPS: name of a scale -> the colours at its points, as one text
    knots = np.array([list(bytes.fromhex(code)) for code in _MAPS[name].split()])
    places = np.clip(np.asarray(values, dtype=float), 0.0, 1.0) * (len(knots) - 1)
    channels = [np.interp(places, np.arange(len(knots)), knots[:, k]) for k in range(3)]
    colours = np.stack(channels, axis=-1).reshape(-1, 3).astype(np.uint8)
    return ["#" + bytes(colour.tolist()).hex() for colour in colours]


def parts_with_subscripts(text: str) -> list[tuple[str, bool]]:
    """The parts of a text, in order, each with whether it is a subscript: the letters and digits
    behind "_" after a symbol of one letter, such as ref in p_ref. The names of files, such as
    r_fine.csv, have none.

    >>> parts_with_subscripts("p/p_ref, q/(f p_ref)")
    [('p/p', False), ('ref', True), (', q/(f p', False), ('ref', True), (')', False)]
    >>> parts_with_subscripts("r_fine.csv beside a_ref.")
    [('r_fine.csv beside a', False), ('ref', True), ('.', False)]
    """
    # text, symbol, subscript, text, symbol, subscript, ..., text
    pieces = re.split(r"(?<![^\W_])([^\W\d_])_([A-Za-z0-9]+)(?![A-Za-z0-9_]|\.[A-Za-z0-9])", text)
    parts: list[tuple[str, bool]] = []
    for index in range(0, len(pieces) - 2, 3):
        text_before, symbol, subscript = pieces[index : index + 3]
        parts += [(text_before + symbol, False), (subscript, True)]
    if pieces[-1]:
        parts.append((pieces[-1], False))
    return parts


def marked(text: object) -> Markup:
    """A text as HTML for a page: what stands between backticks becomes code, and the letters behind
    "_" after a symbol of one letter become a subscript. Everything else is escaped.

    >>> print(marked("p_max; `--budget` gives it"))
    p<sub>max</sub>; <code>--budget</code> gives it
    """
    markup = Markup("")
    # pieces outside and inside of backticks alternate
    for index, piece in enumerate(re.split("`([^`]+)`", str(text))):
        is_code = index % 2 == 1
        if is_code:
            markup += Markup("<code>{}</code>").format(piece)
            continue
        for part, is_subscript in parts_with_subscripts(piece):
            markup += Markup("<sub>{}</sub>").format(part) if is_subscript else part
    return markup


class _Rule(NamedTuple):
    """A rule of a style sheet."""

    classes: frozenset[str]  # all of them must be among those of an element
    for_texts: bool  # whether it is for text elements alone
    declarations: Mapping[str, str]  # name -> value


@cache
def _style_rules() -> list[_Rule]:
    """The rules of the style sheet charts.css, those with the fewest classes first. A rule has its
    classes, whether it is for text elements alone, and its declarations (name -> value). Colours
    are those of light pages, lengths are in pixels.
    """
    # the sheet without comments and @media rules (dark pages, print); colours by their names
    # _TEMPLATES: folder of the templates
    sheet = (_TEMPLATES / "charts.css").read_text("utf-8")
    sheet = re.sub(r"/\*.*?\*/", "", sheet, flags=re.DOTALL)
    sheet = re.sub(r"@media[^{]*\{(?:[^{}]*\{[^{}]*\})*[^{}]*\}", "", sheet)
    colours = dict(re.findall(r"--([\w-]+): (#\w+)", sheet))

    # each block of declarations, with its selectors; those that are no classes are left out
    rules = []
    for selectors, block in re.findall(r"([^{}]+)\{([^{}]*)\}", sheet):
        # each var(--NAME) replaced by its colour
        block_in_colours = re.sub(r"var\(--([\w-]+)\)", lambda use: colours[use[1]], block)
        declarations = {
            name: value.removesuffix("px")
            for name, value in re.findall(r"([\w-]+): ([^;]+);", block_in_colours)
        }
        for selector in selectors.split(","):
            match = re.fullmatch(r"(?:svg )?(text)?((?:\.[\w-]+)*)", selector.strip())
            if match:
                classes = frozenset(match[2].split(".")[1:])
                rules.append(_Rule(classes, bool(match[1]), declarations))
    return sorted(rules, key=lambda rule: len(rule.classes))


@cache
def style_of(css: str, *, text: bool = False) -> Mapping[str, str]:
    """The declarations of the style sheet charts.css (name -> value) for an element with the
    classes in `css`, on a light page. `text` says whether the element is a text.

    >>> style_of("curve f q")["stroke-dasharray"]
    '6 2.5'
    """
    classes = frozenset(css.split())
    style: dict[str, str] = {}
    for rule in _style_rules():
        fits_classes = rule.classes <= classes and (rule.classes or rule.for_texts)
        if fits_classes and (text or not rule.for_texts):
            style |= rule.declarations  # a rule of more classes overrides those before
    return style


# What a compiled template depends on beside its text.
_BLANKS = {"trim_blocks": True, "lstrip_blocks": True}
# Of macros of templates/words.txt: a template each, escaped as pages are.
_WORDS = "words of {}.html"


class _CompiledOnce(SourceFileLoader):
    """A template as a module of Python, whose code Python keeps beside the templates and under the
    same settings as that of any module: compiling templates takes half the time of a page.

    Its code is found by what it was compiled from, not by the age of a file. Where no file can be
    written it is compiled in each process.
    """

    def __init__(self, name: str, source: str, compile_source: Callable[[], CodeType]) -> None:
        """Take name and source of a template, and the function that compiles this source."""
        super().__init__(name, str(_TEMPLATES / f"{name}.py"))
        self.source = source.encode()
        self.compile_source = compile_source

    def get_data(self, path: str) -> bytes:
        """The source of the template; of another path, the file's content."""
        return self.source if path == self.path else super().get_data(path)

    def path_stats(self, path: str) -> Mapping[str, Any]:  # noqa: ARG002 there is no such file
        """Checksum of source and settings in place of a time of change, and the size."""
        compiled_by = f"{jinja2.__version__} {_BLANKS}".encode()
        return {"mtime": zlib.crc32(self.source + compiled_by), "size": len(self.source)}

    def source_to_code(self, *_: Any, **_options: Any) -> CodeType:  # type: ignore[override]
        """The compiled template; called where no stored code fits."""
        return self.compile_source()


class CompiledTemplates(ChoiceLoader):
    """Templates by the first loader that has them, each of them compiled once."""

    def load(
        self,
        environment: Environment,
        name: str,
        globals: MutableMapping[str, Any] | None = None,
    ) -> Template:
        """The page template called `name`: its code is compiled once, stored beside the package,
        and read from there the next time. `globals` are names that the template may use,
        `environment` has the settings and filters of all templates.
        """
        source, filename, uptodate = self.get_source(environment, name)
        module = _CompiledOnce(name, source, lambda: environment.compile(source, name, filename))
        code = module.get_code(name)
        assert code is not None  # for the type checker: there is always a source
        return Template.from_code(environment, code, globals or {}, uptodate)


@cache
def _pages() -> Environment:
    """The environment of the page templates of jinja2: where they lie, and the filters that they
    use. Texts in .html templates are escaped; a name that is missing is an error.
    """
    # templates of the package, compiled once, and single macros as templates (_source_of_macro)
    environment = Environment(
        loader=CompiledTemplates([PackageLoader("reports"), FunctionLoader(_source_of_macro)]),
        autoescape=select_autoescape(("html",)),
        undefined=StrictUndefined,
        trim_blocks=_BLANKS["trim_blocks"],
        lstrip_blocks=_BLANKS["lstrip_blocks"],
    )
    environment.filters |= {
        "minus": minus,
        "number": number,
        "signed": signed,
        "marked": marked,
        "contents": _contents,
    }
    return environment


def template(name: str) -> Template:
    """The template `name` of `reports/templates`."""
    return _pages().get_template(name)


def in_template(macro: str, *values: Any) -> str:
    """The text of a macro of templates/words.txt, filled in with `values`: a sentence or several,
    with single blanks between words.
    """
    return " ".join(str(words_of(macro)(*values)).split())


@cache
def words_of(macro: str) -> Any:
    """A macro of templates/words.txt by its name: a function that returns a text with its gaps
    filled in.
    """
    return getattr(template(_WORDS.format(macro)).module, macro)


def _source_of_macro(name: str) -> str | None:
    """The source of a page template with one macro (a text with gaps) of templates/words.txt, and
    the macros that it calls. None where there is no macro for that `name`, which is "words of
    MACRO.html" (`_WORDS`).

    To compile all macros together takes ten times as long.
    """
    # name of a macro -> its text
    sources = _macro_sources()
    first_macro = next((macro for macro in sources if _WORDS.format(macro) == name), None)
    if first_macro is None:
        return None

    # also those that it calls, and those that these call: the list grows
    needed_macros = [first_macro]
    for macro in needed_macros:
        text_of_macro = sources[macro].partition(")")[2]  # behind its parameters
        needed_macros += [
            called_name
            for called_name in re.findall(r"\b(\w+)\(", text_of_macro)
            if called_name in sources and called_name not in needed_macros
        ]
    return "".join(sources[macro] for macro in needed_macros)


@cache
def _macro_sources() -> Mapping[str, str]:
    """The macros of templates/words.txt by their names."""
    text = (_TEMPLATES / "words.txt").read_text("utf-8")
    macros = re.finditer(r"\{%-? macro (\w+).*?\{%-? endmacro -?%\}\n?", text, re.DOTALL)
    return {macro[1]: macro[0] for macro in macros}


def _contents(page: str) -> Markup:
    """A list of links to every section of a page (HTML) that has a name and a heading, in their
    order.

    >>> _contents('<section id="mesh"><h2>The mesh</h2>')
    Markup('<ul><li><a href="#mesh">The mesh</a></li></ul>')
    """
    heading = r"(?:<details><summary>)?<h2>(.*?)</h2>"
    sections = re.findall(rf'<section id="([\w-]+)"[^>]*>\s*{heading}', page, re.DOTALL)
    links = [f'<li><a href="#{place}">{words}</a></li>' for place, words in sections]
    return Markup(f"<ul>{''.join(links)}</ul>")


def script() -> tuple[Markup, str]:
    """The script of all pages, without its indents and comments; and its hash, by which a page's
    security policy admits it and no other script.
    """
    text = (_TEMPLATES / "report.js").read_text("utf-8")
    text = re.sub(r"^ +(// .*\n|/\*.*\*/\n)?", "", text, flags=re.MULTILINE)
    return (
        Markup(text),
        "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode(),
    )


# ------------------------------------------------------------------------------------------- tables
# Column heading (with unit) -> values, all of one length.
Table: TypeAlias = Mapping[str, Sequence[Any] | NDArray[Any]]
_FORMULA = ("=", "+", "-", "@", "\t")


def without_formula(cell: str) -> str:
    """The text of a CSV cell, with an apostrophe before it where a spreadsheet would compute it as
    a formula: where it begins with one of =, +, -, @ or a tabulator. Numbers stay as they are.

    >>> (
    ...     without_formula("=HYPERLINK(A1)"),
    ...     without_formula("-1e-3"),
    ...     without_formula("pad"),
    ...     without_formula(" @SUM(A1)"),
    ... )
    ("'=HYPERLINK(A1)", '-1e-3', 'pad', "' @SUM(A1)")
    """
    cell = cell.replace("\r", " ")  # no writer of CSV quotes it, and some readers end the row there
    # _FORMULA: the characters with which a formula begins
    if not (cell.startswith(_FORMULA) or cell.lstrip().startswith(_FORMULA)):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def table_text(table: Table) -> str:
    """A table (name -> column, all of equal length) as CSV text, numbers to the last digit. A cell
    is empty where its number is NaN.

    >>> table_text({"x": [0.5, float("nan")], "state": ["stick", "open"]})
    'x,state\\n0.5,stick\\n,open\\n'
    """
    head = ",".join(_quoted(without_formula(name)) for name in table)
    rows = map(",".join, zip(*map(_cells, table.values()), strict=True))
    return "\n".join([head, *rows, ""])


def _cells(column: Sequence[Any] | NDArray[Any]) -> list[str]:
    """A column as cells of CSV; a number that stands in it often is written once and used again."""
    if isinstance(column, np.ndarray) and column.dtype.kind in "fiu":
        unique_values, value_indices = np.unique(column, return_inverse=True, equal_nan=True)
        texts = np.array([_number_cell(value) for value in unique_values.tolist()], dtype=object)
        return list(texts[value_indices.ravel()])
    return [_quoted(_cell(value)) for value in column]


def _cell(value: Any) -> str:
    """A value of a column as text that no spreadsheet takes for a formula."""
    if isinstance(value, str):
        return without_formula(value)
    return _number_cell(value.item() if hasattr(value, "item") else value)


def _number_cell(value: Any) -> str:
    """All digits of a number; "" for NaN, which alone differs from itself."""
    return "" if value != value else repr(value)  # noqa: PLR0124


def _quoted(cell: str) -> str:
    """A cell between quotation marks where it holds a comma, a quotation mark or a line break:
    `csv.writer` asks that of every number too, and takes five times as long.

    >>> _quoted("stick"), _quoted('a "b", c')
    ('stick', '"a ""b"", c"')
    """
    if not any(mark in cell for mark in ',"\n'):
        return cell
    doubled_quotes = cell.replace('"', '""')
    return f'"{doubled_quotes}"'


def markdown_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown with these column heads and rows of cells. ValueError for a row that has
    not as many cells as there are heads.

    >>> print(markdown_table(("x", "|q|"), [("0", "1")]))
    | x | \\|q\\| |
    | --- | --- |
    | 0 | 1 |
    """
    lines = [heads, ["---"] * len(heads), *rows]
    rows_of_text = []
    for line in lines:
        if isinstance(line, str) or len(line) != len(heads):
            raise ValueError(f"a row of {len(heads)} cells ({', '.join(heads)}) is not {line!r}")
        cells = [cell.replace("|", "\\|") for cell in line]
        rows_of_text.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows_of_text)
