"""The method of dimensionality reduction: its energy on a graded radial mesh."""

from functools import partial
from typing import Any

import numpy as np

from ...mdr import energy
from ...meshes.compliance import Compliance
from ...meshes.contact_cells import fitted_space
from ...meshes.pressure_space import PressureSpace
from ..problem.defaults import mdr_sizes
from ..problem.problem import Problem
from ..progress import Stages
from .base import Discretised
from .pipeline import ComplianceMethod
from .spaces import pressure_spaces


class AnySpaceMethod(ComplianceMethod):
    """A method whose compliance can be had on any pressure space."""

    def compliance(self, space: PressureSpace) -> Compliance:
        """Return the compliance on a space."""
        raise NotImplementedError

    def refusal(self, problem: Problem) -> str:
        if not problem.full_contact and problem.mdr.given:
            return (
                "accuracy.mdr sizes the mesh of a flat punch: with an initial profile or a fixed "
                "indentation leave it out"
            )
        return super().refusal(problem)

    def discretise(self, problem: Problem, stages: Stages) -> Discretised:
        fine, coarse = pressure_spaces(problem)

        def fitted(edges: tuple[float, ...], infinite: tuple[bool, ...], degree: int) -> Compliance:
            return self.compliance(fitted_space(edges, infinite, degree))

        with stages("assembling"):
            compliance = self.compliance(fine)
        return Discretised(
            compliance,
            lambda: self.compliance(coarse),
            settings=smallest(mdr_sizes(problem)) if problem.full_contact else {},
            fitted=(partial(fitted, degree=8), partial(fitted, degree=6)),
        )


def smallest(sizes: dict[str, Any]) -> dict[str, float]:
    """Return sizes of which each ring edge may have its own, by the smallest."""
    return {
        name: value if np.ndim(value) == 0 else float(np.min(value))
        for name, value in sizes.items()
        if np.size(value)
    }


class Mdr(AnySpaceMethod):
    """Exact for full contact, but for the pressure space."""

    name = "mdr"
    what = (
        "the half-space by dimensionality reduction, exact for full contact but for the pressure "
        "space"
    )

    def compliance(self, space: PressureSpace) -> Compliance:
        return energy.compliance(space)


METHOD = Mdr()
