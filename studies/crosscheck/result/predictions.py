"""Prediction of the seconds and of the memory of a run, before anything is meshed or solved.

A sparse factor costs unknowns^1.5, dense algebra pressures^2, and pressures^3 once matrices are
large, a march its steps times pressures^2, modes times times pressures^2. A method whose error
estimates are too large is solved again with finer sizes, which a prediction cannot know.
"""

from collections.abc import Collection, Sequence
from pathlib import Path

from ....meshes.errors import SceneError
from ..methods.base import Method, SystemSize
from ..problem.problem import Problem
from ..problem.quantities import FIELDS, GROUPS, HISTORIES, QUANTITIES
from ..problem.written import shown
from ..scene.calls import naming_arguments
from ..scene.scene import Scene, Source
from ..sizes.cells import cells_of, graded_to_worn_layers
from ..sizes.radial import radial_sizes
from ..wear.step_control import steps_between
from .scope import Methods, chosen_methods, methods_of, refuse

GIB = 2.0**30
# Memory that every machine has, in GiB.
LEAST_MEMORY = 0.5
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
# What to give for results without fields over time, in a run and in a check.
WITHOUT_FIELDS = "output.quantities as in ['history', 'steady'], and tables without fields"


def most_memory(needed: float) -> float:
    """Return the memory of this machine, in GiB, or what every machine has if no more is needed."""
    if needed <= LEAST_MEMORY:
        return LEAST_MEMORY
    import psutil  # most runs need little memory

    return float(psutil.virtual_memory().total / GIB)


def refuse_large(path: Path, size: float) -> None:
    """Raise if the contents of a netCDF file, `size` in bytes by its header, are too large.

    A compressed file may be far smaller than its contents.

    Raises
    ------
    ValueError
        with the size of the dataset and the limit
    """
    # the data are copied a few times after reading
    max_bytes = most_memory(8 * size / GIB) * GIB / 8
    if size > max_bytes:
        raise ValueError(
            f"its contents are {size / 1e9:.3g} GB by its header (the file has "
            f"{path.stat().st_size / 1e6:.3g} MB); give at most {max_bytes / 1e9:.2g} GB"
        )


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


def why_beyond_memory(
    scene: Scene,
    methods: Collection[Method] | None = None,
    limit: float | None = None,
    others: float = 0.0,
    at_once: int = 1,
) -> str:
    """Return why a run does not fit into memory, with the remedy; empty if it fits.

    Parameters
    ----------
    scene, methods, others
        As for `memory_need`.
    limit : float, optional
        Memory that may be used, in GiB; by default that of the machine.
    at_once : int
        Number of processes that solve at the same time, and share the libraries.

    Raises
    ------
    SceneError
        if the limit is not a positive number
    """
    problem, (fixed, over_time) = scene.problem, memory_need(scene, methods, others)
    fixed, over_time = LIBRARIES + at_once * (fixed - LIBRARIES), at_once * over_time
    limit = most_memory(fixed + over_time) if limit is None else limit
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
            remedies += [f"fewer than {len(problem.radii)} output.radii", WITHOUT_FIELDS]
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
) -> None:
    """Refuse a run that would not fit into memory, before any work.

    The parameters are those of `why_beyond_memory`.

    Raises
    ------
    SceneError
        with the memory that is needed, and with the number of times that would fit
    """
    if reason := why_beyond_memory(scene, methods, limit, others):
        raise SceneError(reason)


def accepted_methods(
    scene: Scene, entries: Sequence[str | Method] = (), memory: float | None = None
) -> Methods:
    """Return methods that solve a scene, by their names: given ones, or those of the scene.

    Raises
    ------
    SceneError
        if one of them cannot, or if memory does not suffice
    """
    methods = methods_of(entries) if entries else chosen_methods(scene)
    refuse(scene, methods)
    refuse_beyond_memory(scene, methods.values(), memory)
    return methods


def _seconds_of_modes(problem: Problem, order: float) -> float:
    # a steady state or relaxation times alone need no modes
    modes = (0.5 if len(problem.times) else 0.1) * order**2 * (1 + order / 3)
    # fields at the requested times, and amplitudes at the knots of the load
    sampling = 1.2e-3 * len(problem.times) + 4e-4 * len(problem.loading.times)
    return modes + sampling * order**2


def _seconds_of_steps(problem: Problem, order: float) -> float:
    # the number of adaptive steps grows as rtol^(-1/3), by a few for each end of a step that the
    # scene requires
    steps = 0.15 * problem.rtol ** (-1 / 3) + 0.1 * problem.least_steps
    return float(steps * order**2)


def predict_seconds(method: Method, problem: Problem, size: SystemSize) -> float:
    """Return about how many seconds of one processor a method needs for a problem.

    The constants were measured on the bundled scenes.
    """
    if not size.pressures:
        # a closed form
        return 0.02
    order, step = size.pressures / 1e3, method.step(problem)
    steps = float(steps_between(problem.times, step).sum()) if step else 0.0
    sparse = 0.1 * (size.unknowns / 1e4) ** 1.5
    equal_steps = 6e-4 * steps * order**2
    if problem.full_contact:
        return 0.05 + _seconds_of_modes(problem, order) + sparse + equal_steps
    # the first contact is searched for
    return 0.3 + 1.5 * (_seconds_of_steps(problem, order) + sparse) + equal_steps


@naming_arguments
def plan_run(source: Source, memory: float | None = None) -> list[str]:
    """Predict the unknowns, the seconds and the memory of a run, by each method.

    Nothing is solved. Seconds are those of a run that needs no finer sizes.

    Parameters
    ----------
    source : Scene, str, Path or dict
        The scene that would be computed.
    memory : float, optional
        Largest memory that a run may use, in GiB; by default that of the machine.

    Returns
    -------
    list of str
        Lines of text: sizes, seconds of one processor, GiB, refusals and notes.
    """
    scene = Scene.of(source)
    try:
        methods = accepted_methods(scene, memory=memory)
    except SceneError as error:
        return [f"refused: {error}"]
    sizes = {name: entry.system_size(scene.problem) for name, entry in methods.items()}
    seconds = {
        name: predict_seconds(methods[name], scene.problem, size) for name, size in sizes.items()
    }
    return [
        *(
            f"{name}: {size.unknowns} unknowns, {size.pressures} pressures, "
            f"about {seconds[name]:.2g} s"
            for name, size in sizes.items()
        ),
        f"in all: about {sum(seconds.values()):.2g} s, to a factor of three, and a few seconds for "
        "loading, files and figures",
        f"memory: about {sum(memory_need(scene)):.2g} GiB",
        *(f"note: {note}" for size in sizes.values() for note in size.notes),
    ]
