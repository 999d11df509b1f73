"""Names that are read by string exist: attributes by `getattr` and its kin, targets of patches,
attributes and macros of templates, references of the manual. A rename leaves such strings behind,
and no type checker sees them.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pkgutil import resolve_name

import jinja2
from jinja2 import nodes
from sizes import PARTS, ROOT, parsed

TEXTS = {
    file: file.read_text(encoding="utf-8")
    for part in (*PARTS, "halfplane")
    for file in sorted((ROOT / part).rglob("*.py"))
}
TEMPLATES = {
    file.name: jinja2.Environment(autoescape=True).parse(file.read_text(encoding="utf-8"))
    for file in (ROOT / "reports" / "templates").iterdir()
    if file.is_file() and file.suffix not in (".css", ".js", ".json", ".py")
}
READ = re.compile(
    r"\b(?:getattr|hasattr|[sd]e[tl]attr|attrgetter|patch(?:\.object)?)\(\s*"
    r"""(?:[^,()"']+(?:\([^()]*\))?,\s*)?f?"([^"]+)\""""
)
FILLED = re.compile(r'\b(in_template|figure_with_texts)\(\s*"(\w+)"(?![^()]*\bwords=)')
DIRECTIVE = re.compile(r"\.\. auto\w+:: ([\w.]+)(?:\n +:members:(.*))?")
ROLE = re.compile(r"\{py:\w+\}`(?:[^`<]*<)?~?([\w.]+)>?`")
# Attributes of Python and of libraries.
FOREIGN = """
    __name__ __notes__ __file__ __version__ __spec__ SIGPIPE Popen ReadAllScalarsOn attr compile ctx
    default_command dont_write_bytecode fsync generate id item loader open _processes pycache_prefix
    read_text sched_getaffinity sleep stderr wasxfail
"""
OF_TEMPLATES = {*dir(str), *dir(dict), "first", "last", "index0", "tolist"}


def names_defined(tree: ast.Module) -> Iterator[str]:
    """Functions, classes, imports, variables of modules and classes, attributes that are set."""
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef() | ast.ClassDef():
                yield node.name
            case ast.Attribute(ctx=ast.Store()):
                yield node.attr
            case ast.alias():
                yield (node.asname or node.name).rpartition(".")[2]
        for statement in node.body if isinstance(node, ast.Module | ast.ClassDef) else ():
            if isinstance(statement, ast.Assign | ast.AnnAssign):
                words = [word for word in ast.walk(statement) if isinstance(word, ast.Name)]
                yield from (word.id for word in words if isinstance(word.ctx, ast.Store))


NAMES = {
    file: set(names_defined(parsed(text)))
    for file, text in TEXTS.items()
    if ROOT / "tests" not in file.parents
}
DEFINED = set(FOREIGN.split()).union(*NAMES.values())


def leads_nowhere(target: str) -> bool:
    """Whether a dotted name has no target; only a name that no file defines is imported."""
    module, _, name = target.rpartition(".")
    file = ROOT / module.replace(".", "/")
    if name in NAMES.get(file.with_suffix(".py"), NAMES.get(file / "__init__.py", ())):
        return False
    try:
        resolve_name(target)
    except (ImportError, AttributeError):
        return True
    return False


def unknown_names(texts: Iterable[str]) -> list[str]:
    """Names that are read by string in these texts and do not exist."""
    unknown = []
    for name in sorted({name for text in texts for name in READ.findall(text)}):
        if "{" in name:  # an f-string, its gaps being any words
            pattern = re.sub(r"\{[^}]*\}", r"\\w+", name).rpartition(".")[2]
            is_known = any(re.fullmatch(pattern, word) for word in DEFINED)
        else:
            is_known = name in DEFINED or ("." in name and not leads_nowhere(name))
        if not is_known:
            unknown.append(name)
    return unknown


def test_attributes_and_targets_of_patches_exist() -> None:
    assert unknown_names(TEXTS.values()) == []
    planted = """
        getattr(a, 'no_name') m.setattr('scenes.no_name', 1) getattr(b(), f'no_name_{c}')
        patch.object(a, 'no_name_either') attrgetter('no_name_here') getattr(a, 'scene')
    """
    assert len(unknown_names([planted.replace("'", '"')])) == 5


def test_attributes_and_macros_of_templates_exist() -> None:
    """Attributes, keys of mappings, and words that a template gives to a function of the code."""
    keys = {key for text in TEXTS.values() for key in re.findall(r'"(\w+)":', text)}
    macros = {
        name: {macro.name for macro in template.find_all(nodes.Macro)}
        for name, template in TEMPLATES.items()
    }
    for name, template in TEMPLATES.items():
        words = {node.attr for node in template.find_all(nodes.Getattr)}
        for call in template.find_all(nodes.Call):
            match call:
                case nodes.Call(node=nodes.Name(name=function), args=[nodes.Const(value=word), *_]):
                    if function not in set().union(*macros.values()):
                        words.add(word)
        assert sorted(words - DEFINED - keys - OF_TEMPLATES) == [], name
    filled = {pair for text in TEXTS.values() for pair in FILLED.findall(text)}
    files = {"in_template": "words.txt", "figure_with_texts": "figures.txt"}
    assert len(filled) > 30
    assert [pair for pair in filled if pair[1] not in macros[files[pair[0]]]] == []


def test_references_of_the_manual_exist() -> None:
    text = "\n".join(page.read_text("utf-8") for page in (ROOT / "docs").rglob("*.md"))
    targets = ROLE.findall(text)
    for target, members in DIRECTIVE.findall(text):
        targets += [target, *(f"{target}.{name}" for name in members.replace(",", " ").split())]
    assert len(targets) > 100
    assert [target for target in targets if leads_nowhere(target)] == []
