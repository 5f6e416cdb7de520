"""A method whose solution is given, so that a run compares and judges it like any other."""

from typing import ClassVar

from ringwear import Method, run


class Given(Method):
    """Return one solution for every problem; it is not refined.

    Parameters
    ----------
    name : name of the method
    solution : the solution, for example that of another method with a fault
    """

    refused: ClassVar = {}
    knows_layers = True

    def __init__(self, name, solution):
        self.name, self.solution = name, solution

    def solve(self, problem, stages):
        return self.solution

    def sizes_given(self, problem):
        return True

    def remedy(self, problem):
        return self.solution.remedy


def judge(scene, **solutions):
    """Return the result of a run whose methods have these solutions, by their names."""
    return run(scene, methods=[Given(name, solution) for name, solution in solutions.items()])
