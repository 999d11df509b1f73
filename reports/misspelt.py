"""What the command line says of words that it does not know: one sentence, with the nearest word that it does."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from cyclopts import Argument, CycloptsError, MissingArgumentError, UnknownCommandError, UnknownOptionError, UnusedCliTokensError

from reports.application import app


def sentence(fault: CycloptsError) -> str:
    """The fault in one sentence that ends in what to do."""
    if isinstance(fault, UnknownCommandError):
        return _command(fault)
    command = " ".join(fault.command_chain or ["halfplane"])
    where = " ".join(["halfplane", *(fault.command_chain or ())])
    if isinstance(fault, UnknownOptionError):
        return _option(fault, command, where)
    if isinstance(fault, UnusedCliTokensError):
        unused = " ".join(fault.unused_tokens or [])
        return f"{command} has no use for {unused!r}; {_subcommand(fault)}`{where} --help` shows what it takes"
    if isinstance(fault, MissingArgumentError) and fault.argument is not None and not fault.argument.tokens:
        return f"{command}: {_wanted(fault.argument)} is missing; `{where} --help` shows what it takes"
    return f"{' '.join(str(fault).split()).rstrip('.')}; `{where} --help` shows what it takes"


def _subcommand(fault: UnusedCliTokensError) -> str:
    """The question after a command's own command: `sweep` takes a misspelt one for a study, and what follows has no use."""
    first = (fault.root_input_tokens or [])[len(fault.command_chain or ()) :][:1]
    names = [name for name in fault.app or () if not name.startswith("-")]
    return nearest(first[0], names) if first else ""


def _wanted(argument: Argument) -> str:
    """A word of its own in capitals, as in the help; an option as it is written."""
    in_place = argument.field_info.kind is not argument.field_info.KEYWORD_ONLY
    return argument.name.removeprefix("--").upper() if in_place else argument.name


def _command(fault: UnknownCommandError) -> str:
    words = list(fault.unused_tokens or [""])
    option = words[0].startswith("-")
    names = [name for name in app if name.startswith("-") is option]
    return f"there is no {'option' if option else 'command'} {words[0]!r}; {nearest(words[0], names)}`halfplane --help` lists them"


def _option(fault: UnknownOptionError, command: str, where: str) -> str:
    word = (fault.token.keyword or fault.token.value).split("=", 1)[0]
    names = {name for argument in fault.argument_collection for name in argument.names if name.startswith("--")}
    return f"{command} has no option {word}; {nearest(word, names)}`{where} --help` lists them"


def nearest(word: str, known: Iterable[str]) -> str:
    """A question after the known word that is most like `word`; empty where none is.

    >>> nearest("rnu", ["run", "exact"]), nearest("zzz", ["run", "exact"])
    ('did you mean run? ', '')
    """
    near = difflib.get_close_matches(word.lower(), sorted(known), n=1)
    return f"did you mean {near[0]}? " if near else ""
