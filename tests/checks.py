"""What tests read from a check of another program's results, in one place."""


def errors(checked):
    """Return the errors of all programs, one for each quantity and time."""
    return checked.rows


def mistakes(checked, program=None):
    """Return the mistakes that may explain the errors of a program, the likeliest first.

    Without a name, the only program is meant.
    """
    if program is None:
        (program,) = checked.judged
    return checked.mistakes(program)
