"""Estimate the time and memory of a sweep by computing its largest scene by each method."""

import time

import numpy as np

from ..crosscheck import LOG, cores, machine_memory
from .axes import Sweep
from .compute import compute_block
from .flags import FAILED
from .largest import find_largest
from .template import one_scene, template


def estimate_cost(sweep: Sweep, workers: int | None, memory: float | None) -> list[str]:
    """Return lines of text about the time, memory and size of a sweep.

    The largest scene is computed as a probe.

    Parameters
    ----------
    sweep : sweep that is to be computed
    workers : number of processes on this machine; None for as many as it has cores
    memory : memory in GiB that they may use together; None for all memory of the machine
    """
    workers = workers or cores()
    places, needed_memory = find_largest(sweep)
    probe = sweep.part({dim: slice(place, place + 1) for dim, place in places.items()})
    seconds, complete, failures = dict[str, float](), list[str](), list[str]()
    for method in sweep.methods:
        LOG.info("   sweep  computing the largest scene by %s ...", method)
        alone = probe.by([method])
        blank = one_scene(alone, template(alone))
        # the second time is measured, when all libraries are loaded
        for _ in range(2):
            start = time.perf_counter()
            values = compute_block(alone, blank)
            seconds[method] = time.perf_counter() - start
        if values["status"].item() == FAILED:
            failures.append(str(values["reason"].item()))
        if all(np.isfinite(values[name].astype(float)).any() for name in sweep.keep):
            complete.append(method)
    total = sum(seconds.values())
    scene = ", ".join(
        f"{key} = {str(value)[:40]}" for key, value in sweep.changes_at(places).items()
    )
    lines = [
        f"{sweep.count} scenes; a store of {template(sweep).nbytes / 2**20:.3g} MiB before "
        "compression",
        f"a probe, the largest scene alone ({scene}), took {total:.2g} s; if every scene took as "
        f"long, the sweep would take {_in_words(total * sweep.count / workers)} by {workers} "
        "processes; smaller scenes and scenes that share a discretisation take less time",
    ]
    if failures:
        lines[1] = f"the largest scene alone ({scene}) fails, so that the time is not known: "
        lines[1] += "; ".join(failures)
    elif len(seconds) > 1:
        shares = ", ".join(
            f"{name} {100 * share / total:.0f} %"
            for name, share in sorted(seconds.items(), key=lambda each: -each[1])
        )
        lines.append(f"of this time, the methods take: {shares}")
        if complete:
            fastest = min(complete, key=seconds.__getitem__)
            lines[-1] += f"; for a ranking, one method suffices: --methods {fastest}"
    limit = (machine_memory() if memory is None else memory) / workers
    remark = "" if needed_memory <= limit else ": too little, give --memory GIB or fewer --workers"
    return [
        *lines,
        f"memory: about {needed_memory:.2g} GiB for the largest scene, of the {limit:.2g} GiB "
        f"that each process has{remark}; scenes that share a discretisation need more memory "
        "together; if it is too much, they are split into smaller groups",
    ]


def _in_words(seconds: float) -> str:
    """Return a time in seconds, hours or days."""
    for unit, name in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2 * unit:
            return f"{seconds / unit:.2g} {name}"
    return f"{seconds:.2g} s"
