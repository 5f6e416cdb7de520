"""Exit statuses of the command line."""

from enum import IntEnum


class Status(IntEnum):
    """Exit status of the command line (`studies/cli.py` lists the cases)."""

    DONE = 0
    FAILED = 1
    BAD_INPUT = 2
    DISAGREE = 3
