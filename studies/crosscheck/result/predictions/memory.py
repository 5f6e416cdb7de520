"""Prediction of the memory of a run, before anything is meshed or a library is loaded."""

from collections.abc import Collection

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
# Number of dense matrices of the size of the compliance that are in memory at once.
DENSE_MATRICES = 14.0
# Copies of the results over time of each method that are in memory at once: its own, the one in the
# table, and differences to other methods. Measured on five rings at thousands of times: 3.1 for
# each of two methods. A march in steps also keeps its states: about 20 copies for a flat punch, and
# 50 for a sphere.
COPIES, COPIES_OF_MARCH = 3.5, 40.0
# Memory of a time in lists, texts and figures, in numbers. Measured on five rings, without fields.
NUMBERS_OF_LISTS = 200.0
# Least number of pressures on a ring, and number of pressures from which on the memory is predicted
# from this alone: a space with so many takes seconds to make.
LEAST_PRESSURES, MANY_PRESSURES = 2, 20_000
# What to give for a run whose results have no fields over time.
WITHOUT_FIELDS = "output.quantities without fields over time, as in ['history', 'steady']"


def memory_need(
    scene: Scene, methods: Collection[Method] | None = None, others: float = 0.0
) -> tuple[float, float]:
    """Return about how much memory a run will need, in GiB.

    Parameters
    ----------
    scene : Scene
        The scene.
    methods : collection of Method, optional
        Methods in place of those of the scene.
    others : float
        Numbers at each time that the results of other programs need, in a check.

    Returns
    -------
    fixed : float
        Memory of libraries and of the dense matrices of the largest method.
    over_time : float
        Memory of the results at all times, which is proportional to their number.
    """
    problem = scene.problem
    entries = chosen_methods(scene).values() if methods is None else methods
    marching = [entry for entry in entries if "history" not in entry.lacks]
    by_steps = not problem.full_contact or any(entry.step(problem) for entry in marching)
    wanted = [name for name in HISTORIES if problem.wants(name)]
    fields = sum(name in FIELDS for name in wanted)
    ring_quantities = sum("ring" in QUANTITIES[name].dims for name in wanted)
    results = fields * len(problem.radii) + len(wanted)
    results += ring_quantities * len(problem.wear_coefficients)
    copies = len(marching) * (COPIES_OF_MARCH if by_steps else COPIES)
    numbers = copies * results + NUMBERS_OF_LISTS + others
    pressures = float(_pressures(problem))
    if any(entry.name == "mdr-grid" for entry in entries):
        pressures = max(pressures, problem.mdr.grid)
    matrices = DENSE_MATRICES * pressures**2
    return LIBRARIES + 8 * matrices / GIB, 8 * len(problem.times) * numbers / GIB


def _pressures(problem: Problem) -> int:
    """Return the number of pressures of dimensionality reduction, or at least many."""
    least = LEAST_PRESSURES * len(problem.merged.widths)
    if least > MANY_PRESSURES:
        return least
    if not problem.full_contact and len(problem.times) > 0:
        # where contact begins is not known before the run; without free edges, cells are the most
        return graded_to_worn_layers(problem, cells_of(problem)).space().size
    return radial_sizes(problem).space(problem).size


def predict_memory(scene: Scene) -> float:
    """Return about how many GiB a run will need."""
    return sum(memory_need(scene))


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
    problem, (fixed, over_time) = scene.problem, memory_need(scene, methods, others)
    limit = machine_memory(fixed + over_time) if limit is None else limit
    if not (isinstance(limit, float | int) and limit > 0):
        raise SceneError(f"memory = {shown(limit)}: give GiB as a positive number, such as 8")
    if fixed + over_time <= limit:
        return ""
    times = len(problem.times)
    fitting_times = int(times * (limit - fixed) / (over_time or 1.0))
    if fitting_times < 1:
        remedies = ["fewer punch.rings, times and output.radii, or a greater accuracy.rtol"]
    else:
        remedies = [f"at most {fitting_times} of the {times} times"]
        if any(map(problem.wants, GROUPS["fields"])):
            remedies += [f"fewer than {len(problem.radii)} output.radii", without_fields]
    remedies.append("more --memory GIB (memory=GIB in Python) if there is more")
    return (
        f"about {fixed + over_time:.2g} GiB are needed, and {limit:.2g} are allowed: give "
        f"{', or '.join(remedies)}"
    )


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
