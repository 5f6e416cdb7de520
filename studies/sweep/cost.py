"""What a sweep will take, by computing its largest scene."""

import time

import numpy as np

from ...meshes.errors import SceneError
from ..predictions.memory import machine_memory, predict_memory
from ..problem.fields import TomlTable
from .axes import Sweep
from .compute import compute_block
from .store import template

# values of an axis that are tried for the largest scene
TRIED = 40


def estimate_cost(sweep: Sweep, workers: int, memory: float | None) -> list[str]:
    """Say what a sweep will take, a line each, by computing its largest scene as a probe.

    Parameters
    ----------
    workers : processes of this machine
    memory : GiB that they may take together; None for those of the machine
    """
    blank = template(sweep)
    of_scene = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
    places, needed = find_largest(sweep)
    probe = sweep.part({dim: slice(place, place + 1) for dim, place in places.items()})
    # the second time everything is loaded
    for _ in range(2):
        start = time.perf_counter()
        compute_block(probe, of_scene)
        seconds = time.perf_counter() - start
    names = [f"{key} = {str(value)[:40]}" for key, value in sweep.changes_at(places).items()]
    limit = (machine_memory() if memory is None else memory) / workers
    fits = "" if needed <= limit else ": too little, give --memory GIB or fewer --workers"
    return [
        f"{sweep.count} scenes; a store of {blank.nbytes / 2**20:.3g} MiB before compression",
        f"a probe, the largest scene alone ({', '.join(names)}), took {seconds:.2g} s; if all took "
        f"as long, the sweep would take {seconds * sweep.count / workers:.2g} s by {workers} "
        "processes; smaller scenes, and scenes that share a discretisation, take less",
        f"memory: about {needed:.2g} GiB for the largest scene, of the {limit:.2g} GiB that each "
        f"process has{fits}; scenes that share a discretisation take more together, and are split "
        "if that is too much",
    ]


def find_largest(sweep: Sweep) -> tuple[dict[str, int], float]:
    """Return where the scene is that needs most memory, and how many GiB.

    One dimension after the other is followed to its largest, the others being where they were.
    """
    best, most = dict.fromkeys(sweep.sizes, 0), (-1.0, 0)
    for dim, size in sweep.sizes.items():
        tried = np.unique(np.linspace(0, size - 1, min(size, TRIED)).round().astype(int))
        for place in tried.tolist():
            needed = _size(sweep, sweep.changes_at(best | {dim: place}))
            if needed > most:
                best, most = best | {dim: place}, needed
    return best, most[0]


def _size(sweep: Sweep, changes: TomlTable) -> tuple[float, int]:
    """Return the GiB that a scene needs, and its rings; less than nothing if there is none."""
    try:
        scene = sweep.scene(changes)
        return predict_memory(scene), len(scene.problem.wear_coefficients)
    except SceneError:
        return -1.0, 0
