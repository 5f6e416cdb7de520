"""Prediction of the memory of a run, before anything is meshed or a library is loaded."""

from ..methods.base import method
from ..methods.spaces import radial_space
from ..scene.scene import Scene
from ..sizes.cells import cells_of, graded_to_worn_layers
from ..sizes.defaults import mdr_sizes
from .machine import GIB

# Memory of the loaded libraries, in GiB.
LIBRARIES = 0.23


def predict_memory(scene: Scene) -> float:
    """Return about how many GiB a run will need.

    This is the sum of libraries, the matrices of each method, and fields over time. All methods
    have about as many pressures as dimensionality reduction.
    """
    problem = scene.problem
    on_cells = not problem.full_contact and len(problem.times) > 0
    if on_cells:
        # where contact begins is not known before the run; without free edges, cells are the most
        space = graded_to_worn_layers(problem, cells_of(problem)).space()
    else:
        space = radial_space(problem, **mdr_sizes(problem))
    numbers = sum(method(name).numbers_in_memory(problem, space.size) for name in scene.methods)
    numbers += 6.0 * len(problem.times) * len(problem.radii) * len(scene.methods)
    return LIBRARIES + float(8 * numbers / GIB)


def beyond_memory(needed: float, limit: float) -> str:
    """Return why a run does not fit into `limit` GiB; empty if it fits."""
    if needed <= limit:
        return ""
    return (
        f"about {needed:.2g} GiB are needed, and {limit:.2g} are allowed: give fewer "
        "punch.rings, wear.times and output.radii, or a greater accuracy.rtol, or give --memory "
        "GIB if there is more"
    )
