"""Prediction of the seconds that a run will need, from the sizes of its systems.

Nothing is solved. A sparse factor costs unknowns^1.5, dense algebra pressures^2, and pressures^3
once matrices are large, a march its steps times pressures^2, modes times times pressures^2. A
method whose error estimates are too large is solved again with finer sizes, which a prediction
cannot know.
"""

from ...methods.base import Method, SystemSize
from ...problem.problem import Problem
from ...scene.calls import naming_arguments
from ...scene.scene import Scene, Source
from ...wear.step_control import steps_between
from ..scope import chosen_methods, refusals
from .memory import predict_memory, why_beyond_memory


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
    methods = chosen_methods(scene)
    reasons = refusals(scene, methods) or [why_beyond_memory(scene, methods.values(), memory)]
    if any(reasons):
        return [f"refused: {reason}" for reason in reasons]
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
        f"memory: about {predict_memory(scene):.2g} GiB",
        *(f"note: {note}" for size in sizes.values() for note in size.notes),
    ]
