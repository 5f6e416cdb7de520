"""Errors that are typical of a mesh: its outer boundary, its elements at the rim, patterns."""

from collections.abc import Iterator

import numpy as np

from ....meshes import Array
from .cause import Cause, Sizes
from .model import Model
from .setting import Setting

# radius, over the punch radius, beyond which errors count as errors at the rim
RIM = 0.8


def patterns(errors: Array, radii: Array, radius: float) -> Iterator[tuple[str, float, float]]:
    """Yield each pattern: its name, the size of the errors, and the part of them that it explains.

    Parameters
    ----------
    errors : (T, R) relative errors of the pressure, 0 where none is known
    radii : (R,) in the same unit as `radius`
    radius : of the punch
    """
    size = float(np.linalg.norm(errors) / np.sqrt(errors.size or 1))
    error = errors / (np.linalg.norm(errors) or 1.0)
    early = error[: (len(error) + 1) // 2, radii > RIM * radius]
    yield "coarse rim", size, float(1 - np.sqrt(abs(1 - np.sum(early**2))))
    yield "checkerboard", size, float(-np.sum(error[:, 1:] * error[:, :-1]))


class TruncatedHalfSpace(Cause):
    """The half-space of the program ends at a clamped boundary.

    All displacements are too low by the same length, or forces are too high if the indentation is
    prescribed.
    """

    name = "truncated half-space"
    is_of_mesh = True
    group, searched = "truncation", True
    prior = 0.1
    fitted_numbers = 1
    remedy = "compute with a half-space twice as large: the error is halved"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        recognisable = model.flat or (model.pressed_by_force and not model.at_indentation)
        return recognisable and not model.problem.ground.layered

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(0.05,), (0.2,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(truncation=sizes[0])

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return 1e-3 < sizes[0] < 0.5

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that is reported for the mistake."""
        return 1 / sizes[0]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        reach = f"a half-space that is clamped at a distance R of about {1 / sizes[0]:.4g} radii"
        if not model.at_indentation:
            low = "all displacements are too low by the same length"
            return f"{reach}: {low}, about 1.1 a/R of the indentation"
        high = "forces are too high for the indentation"
        return f"{reach}: {high}, the first one by about 1.1 a/R"


class CoarseRim(Cause):
    """The elements at the rim are too large for the first pressures, which are infinite there.

    The first pressures are about those of a slightly greater punch, except in the last elements,
    where they oscillate. The error decreases as the rim wears.
    """

    name = "coarse rim"
    group, searched = "mesh", True
    prior = 0.1
    fitted_numbers = 2
    is_of_mesh = True
    remedy = "halve the size of the elements at the rim: the error is halved, or less"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat and 0 in model.times and "pressure" in model.comparison.quantities

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(0.01, 0.03), (0.01, -0.03)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(rim=(sizes[0], sizes[1]))

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return 1e-3 < sizes[0] < 0.1 and abs(sizes[1]) < 0.5

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        low = "forces are too high" if model.at_indentation else "displacements are too low"
        return (
            "elements that are too large at the rim: the first pressures are those of a punch of "
            f"{1 + sizes[0]:.4g} times the radius, those next to the rim err by {sizes[1]:.2g}, "
            f"and the first {low} by {sizes[0]:.2g}"
        )
