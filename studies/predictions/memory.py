"""About how much memory a run will need, before anything is meshed and any library loaded."""

import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..methods.base import method
from ..methods.spaces import radial_space
from ..scene.scene import Scene
from ..sizes.defaults import cells_of, mdr_sizes

if TYPE_CHECKING:
    import xarray

GIB = 2.0**30
# GiB that libraries take
LIBRARIES = 0.23


def predict_memory(scene: Scene) -> float:
    """Return about how many GiB a run will need.

    They are for libraries, the matrices of each method, and fields over time. All methods have
    about as many pressures as dimensionality reduction.
    """
    problem = scene.problem
    on_cells = not problem.full_contact and len(problem.times) > 0
    space = cells_of(problem).space() if on_cells else radial_space(problem, **mdr_sizes(problem))
    numbers = sum(method(name).numbers_in_memory(problem, space.size) for name in scene.methods)
    numbers += 6.0 * len(problem.times) * len(problem.radii) * len(scene.methods)
    return LIBRARIES + float(8 * numbers / GIB)


def beyond_memory(needed: float, limit: float) -> str:
    """Say why a run would not fit into so many GiB; empty if it fits."""
    if needed <= limit:
        return ""
    return (
        f"about {needed:.2g} GiB are needed, and {limit:.2g} are allowed: ask for fewer "
        "punch.rings, wear.times and output.radii, or a greater accuracy.rtol, or give --memory "
        "GIB if there is more"
    )


def machine_memory() -> float:
    """Return the GiB of this machine."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / GIB


def refuse_large(path: Path, data: "xarray.Dataset") -> None:
    """Refuse a dataset that would not fit into the memory; it is opened, and not loaded yet.

    A compressed file may declare far more than it holds.

    Raises
    ------
    ValueError
        naming its size
    """
    # what is read is copied a few times
    most = machine_memory() * GIB / 8
    if data.nbytes > most:
        raise ValueError(
            f"it declares {data.nbytes / 1e9:.3g} GB, and {path.stat().st_size / 1e6:.3g} MB are "
            f"there; give at most {most / 1e9:.2g} GB"
        )
