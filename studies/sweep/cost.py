"""Estimate the time and memory of a sweep by computing its largest scene."""

import time

from ..crosscheck.result.predictions.machine import machine_memory
from .axes import Sweep
from .compute import compute_block
from .flags import FAILED
from .largest import find_largest
from .template import one_scene, template


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
    blank_scene = one_scene(sweep, blank)
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
