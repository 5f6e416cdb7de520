"""Prediction of the memory of a run, before anything is meshed or a library is loaded."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..methods.spaces import radial_space
from ..outcome.scope import chosen_methods
from ..scene.scene import Scene
from ..sizes.cells import cells_of, graded_to_worn_layers
from ..sizes.defaults import mdr_sizes

if TYPE_CHECKING:
    import xarray

GIB = 2.0**30
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
    methods = chosen_methods(scene)
    numbers = sum(entry.numbers_in_memory(problem, space.size) for entry in methods.values())
    numbers += 6.0 * len(problem.times) * len(problem.radii) * len(methods)
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


def machine_memory() -> float:
    """Return the memory of this machine, in GiB."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB


def refuse_large(path: Path, data: "xarray.Dataset") -> None:
    """Raise if a dataset would not fit into memory; it is opened, but not loaded yet.

    A compressed file may be far smaller than its contents.

    Raises
    ------
    ValueError
        with the size of the dataset and the limit
    """
    # the data are copied a few times after reading
    max_bytes = machine_memory() * GIB / 8
    if data.nbytes > max_bytes:
        raise ValueError(
            f"its contents are {data.nbytes / 1e9:.3g} GB by its header (the file has "
            f"{path.stat().st_size / 1e6:.3g} MB); give at most {max_bytes / 1e9:.2g} GB"
        )
