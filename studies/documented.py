"""Read purpose and parameters of a function from its source, without loading its module.

The help of a command is the docstring of its function. Help and refusals are fast in this way: most
modules load numerical libraries.
"""

import ast
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

# beginning of a description that states a type, as numpydoc has it
TYPE = re.compile(r"(str|int|float|bool|dict|list|sequence|Scene|Result|Path)\b[^.;]*")


class Parameter(NamedTuple):
    """A parameter of a function: its description, and its default value (None without one)."""

    text: str
    default: Any


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
    spec = find_spec(f"{__package__}.{module}")
    assert spec is not None
    assert spec.origin is not None
    tree = ast.parse(Path(spec.origin).read_text("utf-8"))
    (function,) = (
        node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name
    )
    docstring = ast.get_docstring(function) or ""
    arguments = function.args
    listed = arguments.posonlyargs + arguments.args
    missing: list[ast.expr | None] = [None] * (len(listed) - len(arguments.defaults))
    defaults = [*missing, *arguments.defaults, *arguments.kw_defaults]
    names = [each.arg for each in (*listed, *arguments.kwonlyargs)]
    texts = _texts(docstring)
    return Documented(
        docstring.partition("\n")[0].rstrip("."),
        {
            each: Parameter(texts.get(each, ""), _value(default))
            for each, default in zip(names, defaults, strict=True)
        },
    )


def _value(default: ast.expr | None) -> Any:
    """Return a default value if it is a literal; None otherwise."""
    try:
        return None if default is None else ast.literal_eval(default)
    except ValueError:
        return None


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
