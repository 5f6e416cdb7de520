"""Patterns of pressures that show a mesh: coarse elements at the rim, and a checkerboard.

They are no parameters of a scene or of a reading, because they depend on the mesh.
"""

from collections.abc import Iterator

import numpy as np

from ...meshes import Array

# radius, over the punch radius, beyond which errors count as errors at the rim
RIM = 0.8
PATTERNS = {
    "coarse rim": (
        "errors of pressure of about {:.2g} at the rim, which decrease as the rim wears",
        "halve the element size at the rim: the first pressures change most",
    ),
    "checkerboard": (
        "errors of pressure of about {:.2g} whose sign alternates from radius to radius",
        "average neighbouring pressures: the errors disappear, because the pressure space is too "
        "rich for the displacements",
    ),
}
"""What each pattern looks like, with the size of the errors, and its remedy."""


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
