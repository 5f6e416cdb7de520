"""The one definition of the error of a quantity, for all studies.

The names of quantities are those of results.nc, and the norm of each is the one that its
declaration names. Errors are taken at the times of the scene. There are three kinds of rows, by the
column `when`:

- ``start``: at t = 0. A flat start is solved in the pressure space of the level itself
  (`ways/wear.py`). A run solves it in functions that fit its singularity, and its error would not
  show the mesh.
- ``later``: the greatest error over the times after the start.
- ``all``: quantities that do not depend on time.

Some quantities belong to finite elements only, and are not in results.nc: `energy`, the error of
the displacement in the energy norm, `stress_on_axis`, and `least_eigenvalue`, the least ratio of
the energies of a pressure by finite elements and by MDR. A function of a result that the user
defines is a quantity, too.

The error of a single number has a sign. All other errors are norms.
"""

from collections.abc import Collection, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from ...mdr import energy
from ...meshes import Array, Compliance, PressureSpace, RingwearError
from ..crosscheck import (
    COMPARED_MODES,
    DESCRIBED,
    QUANTITIES,
    History,
    Problem,
    Result,
    Results,
    Solution,
    Stages,
    differences,
    judged,
    unresolved,
)
from .own import Named, Quantity
from .way import ALL, LATER, START, Case, Part
from .ways.axis_stresses import element_stresses

ENERGY, STRESS, EIGENVALUE = "energy", "stress_on_axis", "least_eigenvalue"
"""Quantities of finite elements that are not in results.nc."""
ITSELF = (ENERGY, EIGENVALUE)
"""Quantities whose entry in the column `error` is the value itself."""
DEFAULT = (
    *("indentation", "normal_force", "pressure", "profile", "ring_force", "rms_slope"),
    *("contact_radius", "ring_worn_volume", "running_in_time"),
    *("steady_rms_slope", "steady_profile"),
)
"""Quantities of results.nc that studies tabulate by default; the others follow from them."""
AT_START = ("indentation", "normal_force", "pressure", "contact_radius")
"""Quantities whose error at the start is a row of its own."""
STABLE = 0.01
"""Least ratio of energies by finite elements over MDR at which multipliers count as stable."""
MOST_PRESSURES = 1500
"""Largest pressure space of which this ratio is computed; larger ones would take too long."""
MOST_STATES_INSIDE = 3
"""Greatest number of times at which stresses inside the half-space are compared."""
MOST_UNKNOWNS_INSIDE = 60_000
"""Greatest number of unknowns for which stresses inside are computed, a second factorisation."""


def parts_of(case: Case, exact: Results, names: Iterable[str]) -> list[Part]:
    """Return the rows that a case has, for quantities by their names.

    Quantities that the load prescribes have no error, and are left out.

    Parameters
    ----------
    case : what is solved
    exact : reference values, by quantity
    names : names of quantities
    """
    names, problem = tuple(names), case.problem
    prescribed = {problem.prescribed}
    if "normal_force" in prescribed and len(problem.wear_coefficients) == 1:
        # a single ring carries the prescribed force, which determines its worn volume
        prescribed |= {"ring_force", "ring_worn_volume"}
    if problem.full_contact:
        prescribed.add("contact_radius")
    parts = []
    for name in names:
        if name not in exact or name in prescribed or name not in (case.only or names):
            continue
        if name not in QUANTITIES or not QUANTITIES[name].over_time:
            parts.append(Part(name))
            continue
        if name in AT_START and at(problem, START).any():
            parts.append(Part(name, START))
        if at(problem, LATER).any():
            parts.append(Part(name, LATER))
    return parts


def at(problem: Problem, when: str) -> NDArray[np.bool_]:
    """Return a mask (T,) of the compared times: the loaded start, or the times after t = 0."""
    times = problem.times[problem.compared_rows]
    if when == LATER:
        return times > 0
    loaded = problem.indentation is not None or problem.loading.forces[0] > 0
    return (times == 0) & loaded


def error(
    part: Part,
    values: Results,
    exact: Results,
    problem: Problem,
    among: NDArray[np.bool_] | bool = True,
) -> float:
    """Return the relative error of a quantity; NaN if the values lack it.

    Parameters
    ----------
    part : quantity, at the start or later
    values, exact : values of a solution and of the reference, by quantity; fields are on the face
    problem : problem of the case
    among : (T,) mask of the times to take into account; True for all

    Returns
    -------
    error : signed for a single number, otherwise a norm, the greatest over the times
    """
    name = part.quantity
    if name not in values or name not in exact:
        return np.nan
    value, reference = np.asarray(values[name]), np.asarray(exact[name])
    if name in ITSELF:
        return float(value.max())
    if name == STRESS:
        # relative to the greatest stress of each state, the greatest over depths and states
        axes = tuple(range(1, value.ndim))
        gaps = np.abs(value - reference).max(axis=axes)
        return float((gaps / np.abs(reference).max(axis=axes)).max())
    if name not in DESCRIBED:
        # a function of the user: relative, or absolute if the reference is zero
        return float(value / reference - 1) if reference else float(value)
    with np.errstate(over="ignore", invalid="ignore"):  # a naive march may overflow
        sizes = differences({name: value}, exact, problem.face)[name]
    selected: Any = ...
    if part.when != ALL:
        selected = at(problem, part.when) & among
    elif "mode" in DESCRIBED[name].dims:
        selected = slice(COMPARED_MODES)
    chosen = np.atleast_1d(sizes[selected])
    # numbers of the answer are NaN in parts that a method does not give
    chosen = chosen if part.when != ALL else chosen[~np.isnan(chosen)]
    if not chosen.size:
        return np.nan
    if chosen.size == 1 and sizes.shape == reference.shape:
        return float(chosen[0] * np.sign((value - reference)[selected]).ravel()[0])
    return float(chosen.max())


def estimate(
    part: Part,
    solution: Solution,
    problem: Problem,
    among: NDArray[np.bool_] | bool = True,
) -> float:
    """Return the method's own error estimate of a quantity, at the same times; NaN without one."""
    name = part.quantity
    if name not in solution.errors:
        return np.nan
    if name not in DESCRIBED:
        return float(np.max(solution.errors[name]))
    errors = np.atleast_1d(solution.compared_error(problem, name))
    if part.when != ALL:
        errors = errors[(at(problem, part.when) & among)[: len(errors)]]
    elif "mode" in DESCRIBED[name].dims:
        errors = errors[:COMPARED_MODES]
    errors = errors[~np.isnan(errors)]
    return float(np.max(errors)) if errors.size else np.nan


def promised_times(
    problem: Problem, quantity: str, method: str, solution: Solution
) -> NDArray[np.bool_] | bool:
    """Return a mask (T,) of the times at which a solution promises the accuracy of a quantity.

    It is True if the quantity does not depend on time.
    """
    if quantity not in QUANTITIES or not QUANTITIES[quantity].over_time:
        return True
    times = range(len(problem.compared_rows))
    return np.array([not unresolved(problem, quantity, {method: solution}, row) for row in times])


def values_of(case: Case, solution: Solution, names: Collection[str]) -> Results:
    """Return the values of a solution: those of results.nc, and those that a study asks for.

    Parameters
    ----------
    case : what is solved
    solution : the solution
    names : names of quantities that the study asks for
    """
    values, half_space = dict(solution.compared), solution.half_space
    if half_space is not None and solution.wear is not None and not {*ITSELF}.isdisjoint(names):
        compliance = solution.wear.compliance
        # the energy of a pressure is exact by MDR; by elements with the displacement u_h it is too
        # small by that of u - u_h, because u_h is the best approximation in their space
        exact = energy.compliance(compliance.space)
        gaps = energy_differences(exact, compliance, states(case.problem, solution))
        values[ENERGY] = np.sqrt(np.maximum(gaps, 0.0))
        if EIGENVALUE in names and compliance.space.size <= MOST_PRESSURES:
            values[EIGENVALUE] = energy_ratios(compliance.factor, exact.factor)[-1]
    if half_space is not None and STRESS in names and solution.unknowns <= MOST_UNKNOWNS_INSIDE:
        inside = states_inside(case.problem, solution)
        if len(inside):
            values[STRESS] = element_stresses(half_space, inside)
    return values


def energy_ratios(first: Array, second: Array) -> Array:
    """Return the generalised ratios (n,) of the energies by two compliances, decreasing.

    A ratio is the first energy over the second. They are computed from singular values, because an
    eigensolver for the energies themselves cannot resolve ratios below 1e-15.

    Parameters
    ----------
    first, second : factors (m, n) of the compliances
    """
    scale = np.linalg.norm(second, axis=0)
    triangle = np.linalg.qr(second / scale, mode="r")
    image = solve_triangular(triangle, (first / scale).T, trans="T").T
    ratios = np.zeros(len(scale))
    values = np.linalg.svd(image, compute_uv=False) ** 2
    ratios[: len(values)] = values
    return ratios


def energy_differences(exact: Compliance, ours: Compliance, pressures: Array) -> Array:
    """Return the exact energies of pressures (m, n) minus ours, over the exact ones (m,).

    At a fixed indentation the pressure decays to zero: the difference is then 0.
    """
    reference, found = (
        np.sum((pressures @ compliance.factor.T) ** 2, axis=1) for compliance in (exact, ours)
    )
    gaps = np.zeros(len(reference))
    return np.divide(reference - found, reference, out=gaps, where=reference > 0)


def history_of(problem: Problem, solution: Solution) -> History:
    """Return the history of a solution at the compared times, with coefficients of pressures."""
    if solution.evolution is not None:
        return solution.evolution.at(problem.times[problem.compared_rows])
    assert solution.wear is not None
    return solution.wear.modal(problem.times[problem.compared_rows])


def pressure_space(solution: Solution) -> PressureSpace:
    """Return the space of the pressures of `history_of`."""
    if solution.evolution is not None:
        return solution.evolution.punch.space
    assert solution.wear is not None
    return solution.wear.compliance.space


def states(problem: Problem, solution: Solution) -> Array:
    """Return the pressures (states, size) of the history and, in full contact, the steady state."""
    pressures = history_of(problem, solution).pressure
    if solution.wear is None:
        return pressures
    return np.concatenate([pressures, solution.wear.steady.pressure[None]])


def states_inside(problem: Problem, solution: Solution) -> Array:
    """Return pressures (states, size) at a few times at which the contact is loaded and worn.

    Before any wear the pressure is singular, so that the start is left out.
    """
    history = history_of(problem, solution)
    rows = (history.distances > 0) & (history.force > 0)
    if history.pressed is not None:
        rows &= history.pressed.force == 0
    chosen = np.flatnonzero(rows)
    if len(chosen) > MOST_STATES_INSIDE:
        chosen = chosen[np.linspace(0, len(chosen) - 1, MOST_STATES_INSIDE).round().astype(int)]
    return history.pressure[chosen]


def in_units(part: Part, values: Results, problem: Problem) -> float:
    """Return the value of a quantity in the unit of the scene; NaN if it is not a single number."""
    value = np.asarray(values.get(part.quantity, np.nan))
    if part.when == START and value.ndim == 1:
        value = value[at(problem, START)]
    if value.size != 1:
        return np.nan
    described = DESCRIBED.get(part.quantity)
    unit = getattr(problem.units, described.unit) if described else 1.0
    return float(value.ravel()[0] * unit)


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
