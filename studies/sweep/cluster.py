"""Connect to a Dask cluster, whose workers compute a sweep."""

import logging
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from contextlib import contextmanager
from typing import TYPE_CHECKING

from ...meshes import SolverError
from ..crosscheck import computed_with, signals_wait
from .extra import require
from .flags import RESUME_HINT

if TYPE_CHECKING:
    from distributed import Client

# seconds to wait for an answer of the scheduler, and for its first worker
TIMEOUT = 20.0


@contextmanager
def cluster(scheduler: str) -> Iterator[Executor]:
    """Connect to a Dask scheduler; the executor computes on its workers.

    Parameters
    ----------
    scheduler : its address

    Raises
    ------
    SceneError
        if the extra `sweep` is not installed
    SolverError
        if the scheduler does not answer, has no workers or is lost
    """
    require(("dask", "distributed"), "a sweep on a Dask cluster")
    # signals wait, because Dask would leave processes behind if it were interrupted while it is
    # loaded or connects
    with signals_wait():
        from distributed import Client

    client: Client | None = None
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)
    try:
        with signals_wait():
            client = Client(scheduler, timeout=TIMEOUT)
            client.wait_for_workers(1, timeout=TIMEOUT)
        # blocks of equal content are computed again, because a worker may have died in one
        yield client.get_executor(pure=False)
    except (CancelledError, OSError, ValueError) as error:
        raise SolverError(
            f"the scheduler {scheduler} does not answer, has no workers or is lost ({error}): "
            f"start it with `dask scheduler`, and workers with `dask worker`; {RESUME_HINT}"
        ) from error
    finally:
        if client is not None:
            with signals_wait():
                client.close()


def threads_of(client: "Client", checked: set[str]) -> dict[str, int]:
    """Return the number of threads of each worker of a cluster; check workers that are new.

    A worker without ringwear would lose its connection as soon as it gets a block, without saying
    why.

    Parameters
    ----------
    checked : addresses of the workers that have been checked; new ones are added

    Raises
    ------
    SolverError
        if a worker has other code or versions of ringwear, or no ringwear; its message names the
        worker and both versions
    """
    threads = client.nthreads()
    if new := set(threads) - checked:
        versions = client.run(computed_with, workers=sorted(new), on_error="return")
        for worker, versions_of_worker in versions.items():
            if versions_of_worker != computed_with():
                raise SolverError(
                    f"{worker} has another ringwear or other libraries, {versions_of_worker}, than "
                    f"this process, {computed_with()}: install the same code and versions on it; "
                    f"{RESUME_HINT}"
                )
        checked |= new
    return dict(threads)
