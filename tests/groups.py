"""Groups of parameters of tests, by when they are run."""

import pytest


def slow(*values):
    """Return parameters of slow tests; a tuple has the values of several arguments."""
    return marked("slow", values)


def nightly(*values):
    """Return parameters of tests that are run at night only."""
    return marked("nightly", values)


def marked(group, values):
    mark = getattr(pytest.mark, group)
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=mark)
        for value in values
    ]
