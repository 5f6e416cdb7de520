"""Accept the scene and the options of a study, or refuse them with the remedy."""

from ...meshes import SceneError
from ..crosscheck import Scene, Source, numbers, shown
from .draw import ABSCISSAS

OF_ANY_PUNCH = "convergence, extremes and tradeoff"
OF_LAYERS = "extremes, tradeoff and truncation"
"""Names of the studies that accept any punch, and layers."""
DEFAULT_TIMES = (0.0, 0.01, 0.1, 1.0)
"""Times of scenes without any, in a / (E* k_max v0)."""


def accept(name: str, source: Source, any_punch: bool = False, layered: bool = False) -> Scene:
    """Return the scene of a study, if the study accepts it.

    Parameters
    ----------
    name : name of the study
    source : a scene, a file, the name of a bundled scene, or nested dictionaries
    any_punch : whether the study accepts any punch, not only flat punches under a force
    layered : whether it accepts a layered half-space

    Raises
    ------
    SceneError
        if it does not; the message names the studies that do
    """
    scene = Scene.of(source)
    problem = scene.problem
    if not (any_punch or (problem.full_contact and problem.indentation is None)):
        raise SceneError(
            f"study {name} accepts only flat punches under a force, whose contact edges are fixed: "
            "leave out punch.recess and punch.profile, and give load.normal_force; the "
            f"studies {OF_ANY_PUNCH} accept any punch"
        )
    if problem.ground.layered and not layered:
        raise SceneError(
            f"study {name} accepts only a homogeneous half-space: leave out half_space.layers; "
            f"studies {OF_LAYERS} accept them"
        )
    return scene


def refuse_degree_without_mesh(degree: int | None, has_meshes: bool) -> None:
    """Raise an error if a degree is given, but no meshes for it."""
    if degree is not None and not has_meshes:
        raise SceneError(
            "degree is that of the finite elements on meshes of your own: give --mesh FILE, in "
            "Python meshes=[...], or leave it out"
        )


def refuse_abscissa(against: object) -> None:
    """Raise an error if figures have no such abscissa."""
    if against not in ABSCISSAS:
        raise SceneError(
            f"against = {shown(against)} is not an abscissa of the figures: give one of "
            f"{', '.join(ABSCISSAS)}"
        )


def steps_of(scene: Scene, steps: object) -> list[float]:
    """Return time steps of a user without units, exactly as given.

    Raises
    ------
    SceneError
        if the scene has no history or a load that varies, if something is not a number, or if a
        step is not positive or longer than the last time
    """
    given = numbers("steps", steps)
    if given and (not scene.problem.earliest or scene.problem.loading.varies):
        raise SceneError(
            "--steps: a march in equal steps needs a scene with wear.times under a constant load"
        )
    longest = max(scene.wear.times, default=0.0)
    for step in given:
        if not 0 < step <= longest:
            raise SceneError(f"--steps {step:g}: give steps above 0, up to {longest:.3g}")
    return [step / scene.problem.units.time for step in given]


def with_times(scene: Scene) -> Scene:
    """Return a scene with times of wear: its own, or `DEFAULT_TIMES` if it has none."""
    if scene.problem.earliest:
        return scene
    times = [time * scene.problem.units.time for time in DEFAULT_TIMES]
    return scene.changed({"wear.times": times})
