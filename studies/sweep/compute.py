"""Compute blocks of scenes, in this process or by the workers of a Dask cluster.

Scenes that can share a discretisation do, and one that fails fails alone.
"""

import logging
import time
from collections import defaultdict
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager
from itertools import islice
from math import prod
from resource import RUSAGE_SELF, getrusage
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
import xarray
from threadpoolctl import threadpool_limits

from ...meshes.errors import RingwearError, SceneError, SolverError
from ...meshes.radial import Array
from ..crosscheck.accuracy import solved_to_accuracy
from ..crosscheck.agreement import worst
from ..crosscheck.answer import answer
from ..methods.base import Method, Solution, method
from ..methods.quantities import ANSWER, QUANTITIES, error_name
from ..problem.problem import Problem
from ..problem.scene import Scene
from ..problem.shared import groups
from ..progress import LOG, Stages
from ..versions import differing, fingerprint
from .axes import ANSWERS, Sweep
from .store import DONE, FAILED, PENDING

# of the code that this process has loaded: files may change later
FINGERPRINT = fingerprint()
# gmsh has one state for a whole process, whose threads a cluster may give several blocks
ONE_AT_A_TIME = Lock()
RESUME = "what is finished is there: go on with --resume"


class Failure(NamedTuple):
    """Why a scene has no solution, and what that makes of it."""

    reason: str
    status: int


class Outcome(NamedTuple):
    """What a block has become.

    Parameters
    ----------
    values : (scenes, ...) of each variable of the store
    computed_by : fingerprint of the ringwear that computed it
    """

    values: dict[str, Array]
    computed_by: str


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
    if not blocks or (scheduler is None and min(workers, len(blocks)) == 1):
        for number, block in blocks.items():
            yield number, _checked(compute_block(block, blank))
        return
    from distributed import KilledWorker, wait

    rest, running, checked = iter(blocks.items()), dict[Any, int](), set[str]()
    with connect(scheduler, min(workers, len(blocks)), memory) as client:
        while True:
            # none waits behind another, with which its worker might die
            threads = client.nthreads()
            if set(threads) - checked:
                _check_workers(client)
                checked |= set(threads)
            window = max(1, sum(threads.values()))
            for number, block in islice(rest, max(0, window - len(running))):
                running[client.submit(compute_block, block, blank, pure=False)] = number
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
                    raise SolverError(
                        f"the cluster cannot compute ({reason}): install the same ringwear on its "
                        f"scheduler and workers; {RESUME}"
                    ) from error
                else:
                    yield number, _checked(future.result())


def _check_workers(client: Any) -> None:
    """Refuse workers with another ringwear, or none, before they are given anything."""
    for worker, reply in client.run(fingerprint, on_error="return").items():
        if reply != fingerprint():
            other = differing(reply) if isinstance(reply, str) else f"ringwear ({reply})"
            raise SolverError(f"{worker} has another {other}: install the same on it; {RESUME}")


def _checked(outcome: Outcome) -> dict[str, Array]:
    """Return the values of an outcome, if the code that is here computed them."""
    if outcome.computed_by != fingerprint():
        raise SolverError(
            f"a worker has another {differing(outcome.computed_by)} than this process: install the "
            f"same on it; {RESUME}"
        )
    return outcome.values


@contextmanager
def connect(scheduler: str | None, workers: int, memory: float | None) -> Iterator[Any]:
    """Connect to a Dask scheduler, or to so many processes of this machine.

    Processes that take more than their block of the memory (GiB; by default of the machine's) are
    ended, and started anew.
    """
    import dask
    from distributed import Client, LocalCluster

    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    # results leave at once: there is nothing to spill, nor to wait for
    limits = {f"distributed.worker.memory.{at}": False for at in ("target", "spill", "pause")}
    with ExitStack() as stack:
        stack.enter_context(dask.config.set(limits))
        try:
            address: Any = scheduler or stack.enter_context(
                LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    memory_limit="auto" if memory is None else int(memory * 2**30 / workers),
                    host="127.0.0.1",
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                    # Ctrl-C is the affair of this process
                    preload=["import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)"],
                )
            )
            client = stack.enter_context(Client(address, timeout=20))
            client.wait_for_workers(1, timeout=20)
            yield client
        except (CancelledError, OSError, ValueError) as error:
            raise SolverError(
                f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
                f"start it by `dask scheduler`, and some `dask worker`; {RESUME}"
            ) from error


def compute_block(sweep: Sweep, blank: xarray.Dataset) -> Outcome:
    """Compute all scenes of a block.

    Parameters
    ----------
    sweep : the block, as a sweep of its own
    blank : the template of a scene
    """
    values = {
        str(name): np.stack([variable.values] * sweep.count)
        for name, variable in blank.data_vars.items()
    }
    values["status"][:] = DONE
    scenes: dict[int, tuple[Scene, Problem]] = {}
    for number, index in enumerate(np.ndindex(sweep.shape)):
        try:
            scene = sweep.scene(index)
            scenes[number] = scene, sweep.problem(scene)
        except SceneError as error:
            values["reason"][number], values["status"][number] = str(error), FAILED
    numbers = list(scenes)
    with ONE_AT_A_TIME, threadpool_limits(1):
        for group in groups([problem for _, problem in scenes.values()]):
            # solutions take memory: at most 64 at once
            for start in range(0, len(group), 64):
                together = {numbers[at]: scenes[numbers[at]] for at in group[start : start + 64]}
                _compute_together(together, list(blank["solver"].values), sweep.keep, values)
    return Outcome(values, FINGERPRINT)


def _compute_together(
    scenes: dict[int, tuple[Scene, Problem]],
    solvers: Sequence[str],
    keep: tuple[str, ...],
    values: dict[str, Array],
) -> None:
    """Put results of scenes that share a discretisation in their places, in the scenes' units."""
    solutions: dict[int, dict[int, Solution]] = defaultdict(dict)
    for place, name in enumerate(solvers):
        numbers = [
            number
            for number, (scene, _) in scenes.items()
            if name in scene.methods and values["status"][number] == DONE
        ]
        results = solve(method(name), [scenes[number][1] for number in numbers])
        for number, solution in zip(numbers, results, strict=True):
            if isinstance(solution, Failure):
                values["reason"][number] = f"{name}: {solution.reason}"
                values["status"][number] = solution.status
            else:
                solutions[number][place] = solution
    for number, by_solver in solutions.items():
        if values["status"][number] != DONE:
            continue
        problem = scenes[number][1]
        for place, solution in by_solver.items():
            for name, result in _quantities(problem, solution, keep).items():
                target = values[name][number]
                # more modes may be there, and fewer rings
                result = result[tuple(map(slice, target.shape[1:]))]
                target[(place, *map(slice, result.shape))] = result
        if "disagreement" in values:
            for name, value in worst(problem, list(by_solver.values()), keep)._asdict().items():
                values[name][number] = value


def solve(solver: Method, problems: Sequence[Problem]) -> list[Solution | Failure]:
    """Return each problem's solution, or the reason why it has none.

    What fails together is tried again by halves. What the machine lacks today it may have
    tomorrow, so that leaves a scene pending.
    """
    if not problems:
        return []
    try:
        for problem in problems:
            if refusal := solver.refusal(problem):
                raise SceneError(refusal)
        return list(solved_to_accuracy(solver, problems, Stages(solver.name)))
    except Exception as error:
        expected = isinstance(error, RingwearError)
        reason = str(error) if expected else f"{type(error).__name__}: {error}"
        if len(problems) > 1:
            if not expected:
                LOG.warning("%8s  %d scenes: %s; by halves", solver.name, len(problems), reason)
            half = len(problems) // 2
            return [*solve(solver, problems[:half]), *solve(solver, problems[half:])]
        return [Failure(reason, PENDING if isinstance(error, MemoryError | OSError) else FAILED)]


def _quantities(problem: Problem, solution: Solution, keep: tuple[str, ...]) -> dict[str, Array]:
    """Return quantities to keep, their errors, and answers, in the scene's units."""
    results: dict[str, Array] = {}
    answers = answer(problem, solution) if ANSWERS.keys() & set(keep) else {}
    for name in keep:
        if name in answers:
            results[name] = answers[name] * getattr(problem.units, ANSWER[name].unit)
        elif name in solution.results:
            scale = getattr(problem.units, QUANTITIES[name].unit)
            results[name] = solution.results.variables[name].values * scale
            results[error_name(name)] = np.asarray(solution.errors[name])
    return results


def estimate_cost(sweep: Sweep, blank: xarray.Dataset, workers: int) -> list[str]:
    """Say what a sweep will take, a line each, by computing its last scene as a probe."""
    of_scene = blank.isel(dict.fromkeys(sweep.dims, 0), drop=True)
    seconds = []
    # the second time everything is loaded
    for _ in range(2):
        start = time.perf_counter()
        compute_block(sweep.last, of_scene)
        seconds.append(time.perf_counter() - start)
    geometries = prod(len(axis) for axis in sweep.axes if not axis.shares_discretisation)
    elapsed, peak = min(seconds) * sweep.count / workers, getrusage(RUSAGE_SELF).ru_maxrss
    return [
        f"{sweep.count} scenes in about {geometries} groups that share a discretisation",
        f"a store of {blank.nbytes / 2**20:.3g} MiB before compression",
        f"a probe, the last scene alone, took {min(seconds):.2g} s and {peak / 2**20:.2g} GiB",
        f"so at most about {elapsed:.2g} s by {workers} processes, less where scenes share",
    ]
