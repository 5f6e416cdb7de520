"""Prediction of the memory of a run, before anything is meshed or a library is loaded."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from .....meshes.errors import SceneError
from ...methods.base import Method
from ...problem.problem import Problem
from ...problem.quantities import FIELDS, GROUPS, HISTORIES, QUANTITIES
from ...problem.written import shown
from ...scene.scene import Scene
from ...sizes.cells import cells_of, graded_to_worn_layers
from ...sizes.radial import radial_sizes
from ..scope import chosen_methods
from .machine import GIB, machine_memory

# Memory of the loaded libraries, in GiB.
LIBRARIES = 0.23
# Copies of the results over time of each method that are in memory at once: its own, the one in the
# table, and differences to other methods. Measured on five rings at thousands of times: 2 for one
# method alone, 3.1 for each of two.
COPIES_ALONE, COPIES = 2.5, 3.5
# Memory of a time in lists, texts and figures, in numbers. Measured on five rings, without fields.
NUMBERS_OF_LISTS = 200.0
# Least number of pressures on a ring, and number of pressures from which on the memory is predicted
# from this first: a space with so many takes seconds to make.
LEAST_PRESSURES, MANY_PRESSURES = 2, 20_000
# Part of the memory from which on results over time, and not matrices, are what is too large.
LARGE_PART = 0.5
# What to give for a run whose results have no fields over time.
WITHOUT_FIELDS = "output.quantities without fields over time, as in ['history', 'steady']"


@dataclass(frozen=True)
class MemoryNeed:
    """The memory that a run will need, in GiB.

    Parameters
    ----------
    fixed : memory of libraries and matrices
    over_time : memory of the results at all times, which is proportional to their number
    over_radii : the part of it that is also proportional to the number of radii of the output
    """

    fixed: float
    over_time: float
    over_radii: float

    @property
    def total(self) -> float:
        """The memory in all."""
        return self.fixed + self.over_time


def memory_need(
    scene: Scene, methods: Collection[Method] | None = None, others: float = 0.0
) -> MemoryNeed:
    """Return about how much memory a run will need.

    Parameters
    ----------
    scene : Scene
        The scene.
    methods : collection of Method, optional
        Methods in place of those of the scene.
    others : float
        Numbers at each time that the results of other programs need, in a check.

    Notes
    -----
    The memory is that of libraries, of the matrices of each method, and of results over time. All
    methods have about as many pressures as dimensionality reduction.
    """
    problem, entries = scene.problem, _methods(scene, methods)
    on_cells = not problem.full_contact and len(problem.times) > 0
    if on_cells:
        # where contact begins is not known before the run; without free edges, cells are the most
        space = graded_to_worn_layers(problem, cells_of(problem)).space()
    else:
        space = radial_sizes(problem).space(problem)
    marching = [entry for entry in entries if "history" not in entry.lacks]
    copies = len(marching) * (COPIES if len(marching) > 1 else COPIES_ALONE)
    in_fields, in_others = (copies * numbers for numbers in _results_at_each_time(problem))
    in_others += NUMBERS_OF_LISTS + others
    in_others += sum(entry.numbers_at_each_time(problem, space.size) for entry in marching)
    at_all_times = 8 * len(problem.times) / GIB
    return MemoryNeed(
        _memory_of_matrices(problem, entries, space.size),
        at_all_times * (in_fields + in_others),
        at_all_times * in_fields,
    )


def _methods(scene: Scene, methods: Collection[Method] | None) -> list[Method]:
    return list(chosen_methods(scene).values() if methods is None else methods)


def _memory_of_matrices(problem: Problem, methods: Collection[Method], pressures: int) -> float:
    """Return the memory of libraries and of the matrices of all methods, in GiB."""
    numbers = sum(entry.numbers_in_memory(problem, pressures) for entry in methods)
    return LIBRARIES + float(8 * numbers / GIB)


def _results_at_each_time(problem: Problem) -> tuple[float, float]:
    """Return how many numbers the results of a method contain at each time: in fields, and else."""
    wanted = [name for name in HISTORIES if problem.wants(name)]
    fields = sum(name in FIELDS for name in wanted)
    ring_quantities = sum("ring" in QUANTITIES[name].dims for name in wanted)
    rings = len(problem.wear_coefficients)
    return fields * len(problem.radii), len(wanted) + ring_quantities * rings


def predict_memory(scene: Scene) -> float:
    """Return about how many GiB a run will need."""
    return memory_need(scene).total


def why_beyond_memory(
    scene: Scene,
    methods: Collection[Method] | None = None,
    limit: float | None = None,
    others: float = 0.0,
    without_fields: str = WITHOUT_FIELDS,
) -> str:
    """Return why a run does not fit into memory, with the remedy; empty if it fits.

    Parameters
    ----------
    scene, methods, others
        As for `memory_need`.
    limit : float, optional
        Memory that may be used, in GiB; by default that of the machine.
    without_fields : str
        What to give for a run without fields over time.

    Raises
    ------
    SceneError
        if the limit is not a positive number
    """
    problem, entries = scene.problem, _methods(scene, methods)
    limit = machine_memory() if limit is None else limit
    if not (isinstance(limit, float | int) and limit > 0):
        raise SceneError(f"memory = {shown(limit)}: give GiB as a positive number, such as 8")
    more = "--memory GIB (memory=GIB in Python) if there is more"
    fewer = f"give fewer punch.rings, times and output.radii, or a greater accuracy.rtol, or {more}"
    least_pressures = LEAST_PRESSURES * len(problem.merged.widths)
    if least_pressures > MANY_PRESSURES:
        least = _memory_of_matrices(problem, entries, least_pressures)
        if least > limit:
            return f"at least {least:.2g} GiB are needed, and {limit:.2g} are allowed: {fewer}"
    need = memory_need(scene, entries, others)
    if need.total <= limit:
        return ""
    needed = f"about {need.total:.2g} GiB are needed, and {limit:.2g} are allowed"
    times, radii = len(problem.times), len(problem.radii)
    fitting_times = times * (limit - need.fixed) / (need.over_time or 1.0)
    if need.over_time < LARGE_PART * need.total or fitting_times < 1:
        return f"{needed}: {fewer}"
    remedies = [f"at most {_rounded_down(fitting_times)} of the {times} times"]
    if need.over_radii > LARGE_PART * need.over_time:
        fitting_radii = radii * (1 - (need.total - limit) / need.over_radii)
        if fitting_radii >= 1:
            remedies.append(f"at most {_rounded_down(fitting_radii)} of the {radii} output.radii")
    if any(map(problem.wants, GROUPS["fields"])):
        remedies.append(without_fields)
    return f"{needed}: give {', or '.join([*remedies, more])}"


def refuse_beyond_memory(
    scene: Scene,
    methods: Collection[Method] | None = None,
    limit: float | None = None,
    others: float = 0.0,
    without_fields: str = WITHOUT_FIELDS,
) -> None:
    """Refuse a run that would not fit into memory, before any work.

    The parameters are those of `why_beyond_memory`.

    Raises
    ------
    SceneError
        with the memory that is needed, and with the number of times that would fit
    """
    if reason := why_beyond_memory(scene, methods, limit, others, without_fields):
        raise SceneError(reason)


def _rounded_down(count: float) -> int:
    """Return the greatest number with at most two digits other than 0 that is at most `count`."""
    unit = 10 ** max(0, int(np.log10(count)) - 1)
    return int(count // unit) * unit
