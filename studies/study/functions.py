"""Quantities of the user: functions that take the result of a run and return a number."""

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np

from ...meshes import RingwearError
from ..crosscheck import Result, Results, Solution, Stages, judged
from .own import Quantity
from .way import Case

Named: TypeAlias = Mapping[str, Quantity]
"""Functions of a result that the user defines, by the names of their quantities."""


def values_of_functions(case: Case, method: str, solution: Solution, functions: Named) -> Results:
    """Return the values of the functions of the user; none if the case is not their scene.

    Raises
    ------
    RingwearError
        if one of them fails
    """
    if not functions or case.scene is None:
        return {}
    result = judged(case.scene, {}, {method: solution}, {method: Stages(method)})
    return {name: np.asarray(call(name, each, result)) for name, each in functions.items()}


def call(name: str, function: Quantity, result: Result) -> float:
    """Return the value of a function of the user for a result.

    Raises
    ------
    RingwearError
        if the function fails, or does not return a finite number
    """
    try:
        value = float(function(result))
    except Exception as failure:
        raise RingwearError(
            f"quantity {name} fails: {type(failure).__name__}: {failure}; the function has to "
            "accept the result of a run, whose dataset has one solver, and to return a number"
        ) from failure
    if not np.isfinite(value):
        raise RingwearError(
            f"quantity {name} is {value}: the function has to return a finite number"
        )
    return value
