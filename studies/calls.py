"""What is told of arguments that a call in Python does not have: in one line, what to write."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar, cast

from .scene.explain import nearest, place_of, shown
from .scene.scene import Scene

Call = TypeVar("Call", bound=Callable[..., Any])
# arguments by the names that other packages give them
OTHER_ARGUMENTS = {
    "method": "methods",
    "solver": "methods",
    "solvers": "methods",
    "tol": "rtol",
    "tolerance": "rtol",
    "accuracy": "rtol",
    "quantity": "quantities",
    "variables": "keep",
}


def naming_arguments(call: Call) -> Call:
    """Return a call that refuses an argument that it does not have by what to write instead.

    The refusal is a TypeError, as Python's own is.
    """
    parameters = signature(call).parameters
    names = [name for name, kind in parameters.items() if kind.kind != kind.VAR_KEYWORD]
    takes_any = len(names) < len(parameters)

    @wraps(call)
    def refusing(*given: Any, **named: Any) -> Any:
        for name, value in named.items():
            if name not in names and (not takes_any or name in OTHER_ARGUMENTS):
                raise TypeError(_refusal(call.__name__, name, value, names))
        return call(*given, **named)

    return cast(Call, refusing)


def _refusal(call: str, name: str, value: object, names: list[str]) -> str:
    """Return what to write in place of an argument that a call does not have."""
    told = f"{call}() has no argument {name!r}: "
    other = OTHER_ARGUMENTS.get(name, "")
    if other in (*names, "methods"):
        return f"{told}write {other}={shown(value)}"
    key = place_of(name, Scene, Scene)
    if key.endswith(f".{name}"):
        changes = f"{{{key!r}: {shown(value)}}}"
        if call == "sweep":
            return f"{told}write {call}({names[0]}, {changes})"
        return f"{told}write {call}(scene.changed({changes}))"
    if name in ("out", "folder", "path"):
        return f"{told}write {call}(...).save({shown(value)})"
    near = nearest(name, names)
    return f"{told}{f'did you mean {near}? ' if near else ''}it has {', '.join(names)}"
