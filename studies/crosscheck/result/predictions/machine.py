"""The memory of this machine, and the refusal of files whose contents would not fit into it."""

import os
from pathlib import Path

import numpy as np

GIB = 2.0**30
# memory that every machine has, in GiB
LEAST_MEMORY = 0.5


def machine_memory(needed: float = np.inf) -> float:
    """Return the memory of this machine, in GiB; or only that it has at least what is needed."""
    if needed <= LEAST_MEMORY:
        return LEAST_MEMORY
    import psutil  # most runs need little memory

    return float(psutil.virtual_memory().total / GIB)


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def refuse_large(path: Path, size: float) -> None:
    """Raise if the contents of a netCDF file, `size` in bytes by its header, are too large.

    A compressed file may be far smaller than its contents.

    Raises
    ------
    ValueError
        with the size of the dataset and the limit
    """
    # the data are copied a few times after reading
    max_bytes = machine_memory(8 * size / GIB) * GIB / 8
    if size > max_bytes:
        raise ValueError(
            f"its contents are {size / 1e9:.3g} GB by its header (the file has "
            f"{path.stat().st_size / 1e6:.3g} MB); give at most {max_bytes / 1e9:.2g} GB"
        )
