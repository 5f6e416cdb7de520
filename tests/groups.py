"""Groups of parameters of tests, by when they are run."""

import pytest


def slow(*values):
    """Return parameters of slow tests; a tuple has the values of several arguments."""
    return marked("slow", values)


def nightly(*values):
    """Return parameters of tests that are run at night only."""
    return marked("nightly", values)


def nightly_but(chosen, values):
    """Return all values as parameters, of which those that are not chosen are run at night only."""
    return [value if value in chosen else nightly(value)[0] for value in values]


def marked(group, values):
    mark = getattr(pytest.mark, group)
    return [
        pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=mark)
        for value in values
    ]
