"""Refuse unknown arguments of calls in Python with a line that says what to write instead."""

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar, cast

from ..problem.suggestions import did_you_mean
from ..problem.written import shown
from .explain import place_of
from .keys import dotted
from .scene import Scene

Call = TypeVar("Call", bound=Callable[..., Any])
# arguments of ringwear by the names that other packages use
OTHER_ARGUMENTS = {
    "method": "methods",
    "solver": "methods",
    "solvers": "methods",
    "tol": "rtol",
    "tolerance": "rtol",
    "accuracy": "rtol",
    "quantity": "quantities",
    "variables": "keep",
    "sigma": "noise",
    "error": "noise",
    "params": "parameters",
    "n_jobs": "workers",
    "processes": "workers",
}
# what to write instead of arguments of `sweep` that it had in the last release
OF_SWEEPS = {
    "base": "sweep({}, ...), the scene without a name",
    "out": "store={}",
    "scheduler": "executor=distributed.Client({}).get_executor()",
}


def naming_arguments(call: Call) -> Call:
    """Return a function that refuses unknown arguments, and says what to write instead.

    The error is a TypeError, like Python's own.
    """
    parameters = signature(call).parameters
    names = [name for name, kind in parameters.items() if kind.kind != kind.VAR_KEYWORD]
    takes_any = len(names) < len(parameters)

    @wraps(call)
    def refusing(*positional: Any, **keywords: Any) -> Any:
        for name, value in keywords.items():
            if name not in names and (not takes_any or name in OTHER_ARGUMENTS):
                raise TypeError(_refusal(call.__name__, name, value, names))
        return call(*positional, **keywords)

    return cast(Call, refusing)


def _refusal(call: str, name: str, value: object, names: list[str]) -> str:
    """Return the error message for an unknown argument."""
    message = f"{call}() has no argument {name!r}: "
    argument = OTHER_ARGUMENTS.get(name, "")
    if argument in (*names, "methods"):
        return f"{message}write {argument}={shown(value)}"
    key = dotted(name) if "__" in name else place_of(name, Scene, Scene)
    if key.endswith(f".{name}") or "__" in name:
        changes = f"{{{key!r}: {shown(value)}}}"
        if call == "sweep":
            return f"{message}write {call}({names[0]}, {changes})"
        return f"{message}write {call}(scene.changed({changes}))"
    if call == "sweep" and name in OF_SWEEPS:
        return f"{message}write {OF_SWEEPS[name].format(shown(value))}"
    if name in ("out", "folder", "path", "save"):
        return f"{message}write {call}(...).save({shown(value)})"
    if name in ("plot", "show"):
        return f"{message}write {call}(...).plot()"
    if name in ("verbose", "quiet", "progress", "silent"):
        return f"{message}leave it out; progress is reported to logging.getLogger('ringwear')"
    hint = did_you_mean(name, names, f"it has {', '.join(names)}", "")
    return message + hint.removeprefix(": ")
