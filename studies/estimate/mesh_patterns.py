"""Patterns in one column of a table: of a mesh, and of a column that is written wrongly.

They are no parameters of a scene or of a reading, because they belong to single radii.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ...meshes import Array
from ..crosscheck import FIELDS
from .compared import RIM_MARGIN, USUAL_ERROR, Comparison
from .diagnosis import EXPLAINS, REDUCES, Diagnosis

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


def in_columns(comparison: Comparison) -> Iterator[tuple[str, Diagnosis]]:
    """Yield each column of fields, and a way in which it may be written wrongly: what remains then.

    A column may be shifted by a node, or have the wrong sign on one ring.
    """
    edges = comparison.scene.problem.ring_edges * comparison.scene.problem.units.length
    ring = np.clip(np.searchsorted(edges, comparison.radii) - 1, 0, len(edges) - 2)
    # pressures at the rim are those of the mesh
    inside = comparison.radii < edges[-1] * (1 - RIM_MARGIN)
    for name in comparison.quantities:
        if name not in FIELDS or len(ring) < 2:
            continue
        theirs, words = comparison.theirs[name], name.replace("_", " ")
        # with the errors of their mesh, where these are known
        ours = comparison.mesh_results.get(name, comparison.ours[name])
        ways = [
            (
                "shifted column",
                shift,
                f"a column {name} that is shifted {side} by one node",
                f"compare the rows of radius and {words}: do both begin at the same node?",
                pd.DataFrame(ours).shift(shift, axis="columns").to_numpy(),
            )
            for shift, side in ((1, "outward"), (-1, "inward"))
        ]
        ways += [
            (
                f"sign of the {words}",
                number + 1,
                f"an opposite sign of {words} on ring {number + 1}",
                "compare the sign of this column on this ring with that on the others",
                np.where(ring == number, -ours, ours),
            )
            for number in range(len(edges) - 1)
        ]
        before = relative_size(theirs, ours, inside)
        for mistake, size, looks_like, confirm, wrong in ways:
            remaining = relative_size(theirs, wrong, inside)
            judgement = EXPLAINS if remaining <= USUAL_ERROR else REDUCES
            yield (
                name,
                Diagnosis(mistake, size, judgement, looks_like, before, remaining, confirm),
            )


def relative_size(theirs: Array, ours: Array, inside: NDArray[np.bool_]) -> float:
    """Return the mean difference of two fields (T, R) at some radii (R,), over their mean size."""
    both = np.isfinite(theirs) & np.isfinite(ours) & inside
    size = np.abs(ours[both]).sum()
    return float(np.abs(theirs - ours)[both].sum() / size) if size else 0.0
