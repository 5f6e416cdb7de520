"""Classes that users combine have a short example in their docstring, and it runs."""

import doctest
import importlib

import pytest

# upper limit of the lines of an example
MOST_LINES = 6


@pytest.mark.parametrize(
    ("module", "name"),
    [
        ("meshes.pressure_space", "PressureSpace"),
        ("meshes.compliance", "Compliance"),
        ("fem.half_space", "HalfSpace"),
        ("studies.crosscheck.wear.full_contact", "RunningIn"),
        ("studies.crosscheck.wear.wearing_punch", "WearingPunch"),
    ],
)
def test_a_class_has_a_short_example_that_runs(module, name):
    of_class = getattr(importlib.import_module(f"ringwear.{module}"), name)
    (test,) = doctest.DocTestFinder(recurse=False).find(of_class, name)
    lines = "".join(example.source for example in test.examples).splitlines()
    assert 1 < len(lines) <= MOST_LINES
    # the example prints its last result
    assert test.examples[-1].want
    done = doctest.DocTestRunner().run(test)
    assert done.attempted == len(test.examples)
    assert not done.failed
