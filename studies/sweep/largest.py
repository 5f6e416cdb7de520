"""Find the scene of a sweep that needs most memory."""

import numpy as np

from ...meshes import SceneError
from ..crosscheck import TomlTable, predict_memory
from .axes import Sweep

# greatest number of values of an axis that are tried
MOST_TRIED = 40


def find_largest(sweep: Sweep) -> tuple[dict[str, int], float]:
    """Return the place of the scene that needs most memory, by dimension, and its memory in GiB.

    The search maximises the predicted memory over one dimension after the other, with the places
    along all other dimensions fixed.
    """
    largest_places, greatest_needs = dict.fromkeys(sweep.sizes, 0), (-1.0, 0)
    for dim, size in sweep.sizes.items():
        tried_places = np.unique(
            np.linspace(0, size - 1, min(size, MOST_TRIED)).round().astype(int)
        )
        for place in tried_places.tolist():
            needs = _memory_and_rings(sweep, sweep.changes_at(largest_places | {dim: place}))
            if needs > greatest_needs:
                largest_places, greatest_needs = largest_places | {dim: place}, needs
    return largest_places, greatest_needs[0]


def _memory_and_rings(sweep: Sweep, changes: TomlTable) -> tuple[float, int]:
    """Return the memory in GiB that a scene needs, and its number of rings.

    They are -1 and 0 if there is no such scene.
    """
    try:
        scene = sweep.scene(changes)
        return predict_memory(scene), len(scene.problem.wear_coefficients)
    except SceneError:
        return -1.0, 0
