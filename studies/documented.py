"""Read purpose and parameters of a function from its source, without loading its module.

The flags and the help of a command are the parameters and the docstring of its function. Help and
refusals are fast in this way: most modules load numerical libraries.
"""

import ast
import re
from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

# beginning of a description that states a type, as numpydoc has it
TYPE = re.compile(r"(str|int|float|bool|dict|list|sequence|Scene|Result|Path)\b[^.;]*")


class Parameter(NamedTuple):
    """A parameter of a function, as its source has it.

    Parameters
    ----------
    text : its description in the docstring
    type : its annotation
    default : its default value as an expression; empty without one
    by_position : whether it can be given without its name
    """

    text: str
    type: str
    default: str
    by_position: bool


class Documented(NamedTuple):
    """The first line of the docstring of a function, and its parameters by name."""

    purpose: str
    parameters: dict[str, Parameter]


@cache
def documented(place: str) -> Documented:
    """Return purpose and parameters of a function.

    Parameters
    ----------
    place : module within `studies`, a colon, and the name of the function
    """
    module, _, name = place.partition(":")
    function = _functions(module)[name]
    docstring = ast.get_docstring(function) or ""
    texts, arguments = _texts(docstring), function.args
    required = [None] * (len(arguments.args) - len(arguments.defaults))
    defaults = [*required, *arguments.defaults, *arguments.kw_defaults]
    parameters = {
        each.arg: Parameter(
            texts.get(each.arg, ""),
            ast.unparse(each.annotation) if each.annotation else "",
            ast.unparse(default) if default else "",
            each in arguments.args,
        )
        for each, default in zip([*arguments.args, *arguments.kwonlyargs], defaults, strict=True)
    }
    return Documented(docstring.partition("\n")[0].rstrip("."), parameters)


@cache
def _functions(module: str) -> dict[str, ast.FunctionDef]:
    """Return the functions in the source of a module within `studies`, by name."""
    spec = find_spec(f"{__package__}.{module}")
    assert spec is not None
    assert spec.origin is not None
    tree = ast.parse(Path(spec.origin).read_text("utf-8"))
    return {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}


def function_at(place: str) -> Callable[..., Any]:
    """Import the module of a function, whose place is as in `documented`; return the function."""
    module, _, name = place.partition(":")
    function: Callable[..., Any] = getattr(import_module(f".{module}", __package__), name)
    return function


def _texts(docstring: str) -> dict[str, str]:
    """Return the description of each parameter in a docstring."""
    _, _, section = docstring.partition("Parameters\n----------\n")
    section = re.split(r"\n\n\w[^\n]*\n-+\n", section)[0]
    texts = dict[str, str]()
    for entry in re.split(r"\n(?=\S)", section.strip()):
        heads, _, text = entry.partition(" : ")
        first, _, rest = text.partition("\n")
        if rest and TYPE.fullmatch(first):
            text = rest.partition("\n\n")[0]
        plain = re.sub(r"\s+", " ", text).replace("``", "").replace("`", "").strip()
        texts |= dict.fromkeys(re.split(r",\s*", heads), plain)
    return texts
