"""Refuse unknown arguments of calls in Python with a line that says what to write instead."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar, cast

from ..problem.suggestions import did_you_mean
from ..problem.written import shown
from .explain import key_meant
from .keys import dotted
from .scene import Scene

Call = TypeVar("Call", bound=Callable[..., Any])


def naming_arguments(call: Call) -> Call:
    """Return a function that refuses unknown arguments, and says what to write instead.

    The error is a TypeError, like Python's own.
    """
    names = list(signature(call).parameters)

    @wraps(call)
    def refusing(*positional: Any, **keywords: Any) -> Any:
        for name, value in keywords.items():
            if name not in names:
                raise TypeError(_refusal(call.__name__, name, value, names))
        return call(*positional, **keywords)

    return cast(Call, refusing)


def _refusal(call: str, name: str, value: object, names: list[str]) -> str:
    """Return the error message for an unknown argument, which may be the key of a scene."""
    message, key = f"{call}() has no argument {name!r}", key_meant(dotted(name), Scene)
    if f".{key}".endswith(f".{dotted(name)}"):
        changes = f"{{{key!r}: {shown(value)}}}"
        changed = f"{names[0]}, {changes}" if call == "sweep" else f"scene.changed({changes})"
        return f"{message}: write {call}({changed})"
    return message + did_you_mean(name, names, f"it has {', '.join(names)}", "")
