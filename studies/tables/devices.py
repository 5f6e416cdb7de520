"""Refuse devices as files to read. This loads no pandas, because every scene needs it."""

import os
from pathlib import Path


def refuse_device(path: Path) -> None:
    """Refuse a device such as /dev/zero, which may have no end; pipes and /dev/null are allowed.

    Raises
    ------
    ValueError
        with the path
    """
    if path.is_char_device() and not path.samefile(os.devnull):
        raise ValueError(f"'{path}' is a device, which may have no end: give a file")
