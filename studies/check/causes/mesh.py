"""Error patterns of the pressure that are typical of a mesh, by their place and their sign."""

from collections.abc import Iterator

import numpy as np

from ....meshes.radial import Array

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
