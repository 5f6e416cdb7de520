"""Compute blocks of scenes, in this process or by the workers of a Dask cluster.

Scenes that can share a discretisation do, and one that fails fails alone.
"""

import logging
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from threading import Lock
from typing import Any

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes.errors import SceneError, SolverError
from ...meshes.radial import Array
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import disagreement
from ..crosscheck.answer import answer
from ..crosscheck.table import in_units
from ..methods.base import Method, Solution, method
from ..methods.norms import common
from ..problem.problem import Problem
from ..problem.quantities import error_name
from ..problem.shared import groups
from ..progress import LOG, Stages
from ..versions import versions
from .axes import ANSWERS, Sweep
from .store import DONE, FAILED, template

# gmsh has one state for a whole process, whose threads a cluster may give several blocks
ONE_AT_A_TIME = Lock()
RESUME = "what is finished is there: go on with --resume"


def compute_blocks(
    blocks: dict[int, Sweep],
    blank: xarray.Dataset,
    workers: int,
    scheduler: str | None,
    memory: float | None,
) -> Iterator[tuple[int, dict[str, Array]]]:
    """Yield blocks of a sweep by number, and their values as `compute_block` gives them.

    Dask gives what a lost worker had to another, and starts a new one; what kills four is left out.

    Raises
    ------
    SolverError
        if the scheduler is lost, has no workers, or has one with another ringwear or none
    """
    workers = min(workers, len(blocks))
    if not blocks or (scheduler is None and workers == 1):
        for number, block in blocks.items():
            yield number, compute_block(block, blank)
        return
    from distributed import KilledWorker, wait

    rest, running, checked = iter(blocks.items()), dict[Any, int](), set[str]()
    with connect(scheduler, workers, memory) as client:
        while True:
            # none waits behind another, with which its worker might die
            threads = client.nthreads()
            if set(threads) - checked:
                _check_workers(client)
                checked |= set(threads)
            window = max(1, sum(threads.values()))
            for number, block in islice(rest, max(0, window - len(running))):
                future = client.submit(compute_block, block, blank, pure=False)
                running[future] = number
            if not running:
                return
            try:
                finished = wait(list(running), 30, "FIRST_COMPLETED").done
            except TimeoutError:
                LOG.warning("   sweep  nothing for 30 s from %d workers", len(client.nthreads()))
                continue
            for future in finished:
                number = running.pop(future)
                error = future.exception() if future.status == "error" else None
                if isinstance(error, KilledWorker):
                    count = blocks[number].count
                    LOG.warning("   sweep  %d scenes kill worker after worker: left out", count)
                elif error:
                    reason = f"{type(error).__name__}: {error}".splitlines()[0]
                    raise SolverError(f"a worker cannot compute ({reason}); {RESUME}") from error
                else:
                    yield number, future.result()


def _check_workers(client: Any) -> None:
    """Refuse workers with another ringwear, or none, before they are given anything."""
    for worker, reply in client.run(versions, on_error="return").items():
        if reply != versions():
            raise SolverError(
                f"{worker} has another ringwear or other libraries, {reply}; here are {versions()}:"
                f" install the same on it; {RESUME}"
            )


@contextmanager
def connect(scheduler: str | None, workers: int, memory: float | None) -> Iterator[Any]:
    """Connect to a Dask scheduler, or to so many processes of this machine.

    Processes that take more than their block of the memory (GiB; by default of the machine's) are
    ended, and started anew.
    """
    import dask
    from distributed import Client

    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    # results leave at once: there is nothing to spill, nor to wait for
    limits = {f"distributed.worker.memory.{at}": False for at in ("target", "spill", "pause")}
    processes: dict[str, Any] = {
        "n_workers": workers,
        "threads_per_worker": 1,
        "memory_limit": "auto" if memory is None else int(memory * 2**30 / workers),
        "dashboard_address": None,
        "silence_logs": logging.CRITICAL,
        # Ctrl-C is the affair of this process
        "preload": ["import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)"],
    }
    try:
        with (
            dask.config.set(limits),
            Client(scheduler, timeout=20, **({} if scheduler else processes)) as client,
        ):
            client.wait_for_workers(1, timeout=20)
            yield client
    except (CancelledError, OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
            f"start it by `dask scheduler`, and some `dask worker`; {RESUME}"
        ) from error


def compute_block(sweep: Sweep, blank: xarray.Dataset) -> dict[str, Array]:
    """Compute all scenes of a block.

    Parameters
    ----------
    sweep : the block, as a sweep of its own
    blank : the template of a scene

    Returns
    -------
    values of each variable, in the shape that they have in the store
    """
    values = {
        str(name): np.stack([variable.values] * sweep.count)
        for name, variable in blank.data_vars.items()
    }
    values["status"][:] = DONE
    problems = dict[int, Problem]()
    for number, changes in enumerate(sweep.changes()):
        try:
            problems[number] = sweep.problem(changes)
        except SceneError as error:
            values["reason"][number], values["status"][number] = str(error), FAILED
    numbers, solvers = list(problems), blank["solver"].values.tolist()
    with ONE_AT_A_TIME, threadpool_limits(1):
        for group in groups(list(problems.values())):
            # solutions take memory: at most 64 at once
            for start in range(0, len(group), 64):
                together = {numbers[at]: problems[numbers[at]] for at in group[start : start + 64]}
                _compute_together(together, solvers, sweep.keep, values)
    shape = sweep.sizes.values()
    return {name: array.reshape(*shape, *array.shape[1:]) for name, array in values.items()}


def _compute_together(
    problems: dict[int, Problem],
    solvers: Sequence[str],
    keep: tuple[str, ...],
    values: dict[str, Array],
) -> None:
    """Put results of problems that share a discretisation in their places, in the scenes' units."""
    solutions: dict[int, list[Solution]] = {number: [] for number in problems}
    for place, name in enumerate(solvers):
        results = solve(method(name), list(problems.values()))
        for (number, problem), solution in zip(problems.items(), results, strict=True):
            if isinstance(solution, Exception):
                reason = f"{name}: {type(solution).__name__}: {solution}"
                values["reason"][number], values["status"][number] = reason, FAILED
                continue
            solutions[number].append(solution)
            given = solution.results
            if ANSWERS.keys() & set(keep):
                given = given | answer(problem, solution)
            errors = {error_name(name): error for name, error in solution.errors.items()}
            given = in_units(problem, given) | errors
            for quantity in given.keys() & values.keys():
                target, result = values[quantity][number, place, ...], np.asarray(given[quantity])
                # more modes may be there, and fewer rings
                both = common(target.shape, result.shape)
                target[both] = result[both]
    if "disagreement" in values:
        for number, problem in problems.items():
            values["disagreement"][number] = disagreement(problem, solutions[number], keep)


def solve(solver: Method, problems: Sequence[Problem]) -> list[Solution | Exception]:
    """Return each problem's solution, or why it has none.

    What fails together is tried again one by one.
    """
    try:
        for problem in problems:
            if refusal := solver.refusal(problem):
                raise SceneError(refusal)
        return list(solved_to_accuracy(solver, problems, Stages(solver.name)))
    except Exception as error:
        if len(problems) == 1:
            return [error]
        return [solution for problem in problems for solution in solve(solver, [problem])]


def estimate_cost(sweep: Sweep, workers: int) -> list[str]:
    """Say what a sweep will take, a line each, by computing its last scene as a probe."""
    blank = template(sweep)
    of_scene = blank.isel(dict.fromkeys(sweep.sizes, 0), drop=True)
    last = sweep.part(dict.fromkeys(sweep.sizes, slice(-1, None)))
    # the second time everything is loaded
    for _ in range(2):
        start = time.perf_counter()
        compute_block(last, of_scene)
        seconds = time.perf_counter() - start
    return [
        f"{sweep.count} scenes; a store of {blank.nbytes / 2**20:.3g} MiB before compression",
        f"a probe, the last scene alone, took {seconds:.2g} s: so at most about "
        f"{seconds * sweep.count / workers:.2g} s by {workers} processes, less where scenes share "
        "a discretisation",
    ]
