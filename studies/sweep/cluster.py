"""Blocks of a sweep by a Dask cluster; what a lost worker had, Dask gives to another."""

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import islice
from typing import Any

from ...meshes.errors import SceneError, SolverError
from ..progress import LOG
from ..versions import differing, fingerprint
from .axes import Sweep
from .blocks import Block
from .compute import computed
from .layout import Layout, Outcome

# seconds that a scheduler has for an answer, and without a block after which workers are looked at
ANSWER, QUIET = 20, 30
Outcomes = Iterator[tuple[Block, Outcome]]
KEPT = "what is finished is kept: go on with --resume"


def compute_on_cluster(scheduler: str, whole: Sweep, layout: Layout, todo: list[Block]) -> Outcomes:
    """Yield blocks as they are finished, without those that kill their workers again and again.

    Raises
    ------
    SceneError
        if Dask is not installed
    SolverError
        if the scheduler does not answer or is lost, or has no workers or one with another ringwear
    """
    with _connected(scheduler) as client:
        # Dask is there
        from distributed import wait

        rest, running = iter(todo), dict[Any, Block]()
        try:
            while True:
                # none waits behind another, with which its worker might die
                window = max(1, sum(client.nthreads().values()))
                for block in islice(rest, max(0, window - len(running))):
                    part = whole.part(block.bounds)
                    running[client.submit(computed, part, layout, pure=False)] = block
                if not running:
                    return
                try:
                    with client.as_current():
                        done = wait(list(running), QUIET, "FIRST_COMPLETED").done
                except TimeoutError:
                    _check_workers(client)
                    continue
                for future in sorted(done, key=lambda future: running[future].number):
                    block = running.pop(future)
                    if (outcome := _outcome(future, block)) is not None:
                        yield block, outcome
        except (CancelledError, OSError) as error:
            logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
            raise SolverError(f"the scheduler {scheduler} is lost; {KEPT}") from error


def _outcome(future: Any, block: Block) -> Outcome | None:
    """Return what a block has become; None, and say so, if it killed its workers."""
    from distributed import KilledWorker

    if future.status != "error":
        return future.result()
    error = future.exception()
    if isinstance(error, KilledWorker):
        LOG.warning("   sweep  %d scenes killed worker after worker: left out", block.count)
        return None
    reason = f"{type(error).__name__}: {error}".splitlines()[0]
    remedy = "install the same ringwear on its scheduler and workers"
    raise SolverError(f"the cluster cannot compute ({reason}): {remedy}; {KEPT}") from error


def _check_workers(client: Any) -> None:
    """Say so if there are no workers; raise SolverError if one has another ringwear, or none."""
    answers = client.run(fingerprint, on_error="return")
    if not answers:
        LOG.warning("   sweep  no worker for %d s: waiting for one", QUIET)
    for address, answer in answers.items():
        if isinstance(answer, Exception):
            remedy = f"install ringwear on it; {KEPT}"
            raise SolverError(f"the worker {address} cannot compute ({answer}): {remedy}")
        check_fingerprint(answer, f"the worker {address}")


def check_fingerprint(other: str, worker: str) -> None:
    """Raise SolverError unless a worker computes with the ringwear and the libraries that
    are here.
    """
    if other != fingerprint():
        remedy = f"install the same on it; {KEPT}"
        raise SolverError(f"{worker} has another {differing(other)} than this process: {remedy}")


@contextmanager
def _connected(scheduler: str) -> Iterator[Any]:
    """Connect to a scheduler that has workers, all of which can compute."""
    try:
        from distributed import Client
    except ImportError:
        raise SceneError("--scheduler needs Dask: pip install 'ringwear[cluster]'") from None
    try:
        client = Client(scheduler, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer ({error}): start it by `dask scheduler`, "
            "or leave "
            "out --scheduler to compute here"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=ANSWER)
        except TimeoutError:
            start = f"start some by `dask worker {scheduler}`"
            raise SolverError(f"the scheduler {scheduler} has no workers: {start}") from None
        _check_workers(client)
        yield client
