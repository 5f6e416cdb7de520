"""Exit statuses of the command line."""

from enum import IntEnum


class Status(IntEnum):
    """What the command line returns."""

    DONE = 0
    FAILED = 1
    BAD_INPUT = 2
    DISAGREE = 3
