"""Estimate the time and memory of a sweep by computing its largest scene."""

import time

import numpy as np

from ...meshes.errors import SceneError
from ..predictions.machine import machine_memory
from ..predictions.memory import predict_memory
from ..problem.fields import TomlTable
from .axes import Sweep
from .compute import compute_block
from .store import FAILED, template

# greatest number of values of an axis that are tried in the search for the largest scene
MOST_TRIED = 40


def estimate_cost(sweep: Sweep, workers: int, memory: float | None) -> list[str]:
    """Return lines of text about the time, memory and size of a sweep.

    The largest scene is computed as a probe.

    Parameters
    ----------
    sweep : sweep that is to be computed
    workers : number of processes on this machine
    memory : memory in GiB that they may use together; None for all memory of the machine
    """
    blank = template(sweep)
    blank_scene = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
    places, needed_memory = find_largest(sweep)
    probe = sweep.part({dim: slice(place, place + 1) for dim, place in places.items()})
    # the second time is measured, when all libraries are loaded
    for _ in range(2):
        start = time.perf_counter()
        values = compute_block(probe, blank_scene)
        seconds = time.perf_counter() - start
    probe_changes = [
        f"{key} = {str(value)[:40]}" for key, value in sweep.changes_at(places).items()
    ]
    outcome = (
        f"took {seconds:.2g} s; if every scene took as long, the sweep would take "
        f"{seconds * sweep.count / workers:.2g} s by {workers} processes; smaller scenes and "
        "scenes that share a discretisation take less time"
    )
    if values["status"].item() == FAILED:
        outcome = f"fails, so that the time is not known: {values['reason'].item()}"
    limit = (machine_memory() if memory is None else memory) / workers
    remark = "" if needed_memory <= limit else ": too little, give --memory GIB or fewer --workers"
    return [
        f"{sweep.count} scenes; a store of {blank.nbytes / 2**20:.3g} MiB before compression",
        f"a probe, the largest scene alone ({', '.join(probe_changes)}), {outcome}",
        f"memory: about {needed_memory:.2g} GiB for the largest scene, of the {limit:.2g} GiB "
        f"that each process has{remark}; scenes that share a discretisation need more memory "
        "together; if it is too much, they are split into smaller groups",
    ]


def find_largest(sweep: Sweep) -> tuple[dict[str, int], float]:
    """Return the place of the scene that needs most memory, by dimension, and its memory in GiB.

    The search maximises the predicted memory over one dimension after the other, with the places
    along all other dimensions fixed.
    """
    largest_places, greatest_needs = dict.fromkeys(sweep.sizes, 0), (-1.0, 0)
    for dim, size in sweep.sizes.items():
        tried_places = np.unique(
            np.linspace(0, size - 1, min(size, MOST_TRIED)).round().astype(int)
        )
        for place in tried_places.tolist():
            needs = _memory_and_rings(sweep, sweep.changes_at(largest_places | {dim: place}))
            if needs > greatest_needs:
                largest_places, greatest_needs = largest_places | {dim: place}, needs
    return largest_places, greatest_needs[0]


def _memory_and_rings(sweep: Sweep, changes: TomlTable) -> tuple[float, int]:
    """Return the memory in GiB that a scene needs, and its number of rings.

    They are -1 and 0 if there is no such scene.
    """
    try:
        scene = sweep.scene(changes)
        return predict_memory(scene), len(scene.problem.wear_coefficients)
    except SceneError:
        return -1.0, 0
