"""Scenes of faces with given or random heights, on which a first contact is hard to find."""

import numpy as np

from ringwear import Scene

FLAT = Scene.load("flat_punch").changed(
    methods=["mdr"], wear__times=[0.0, 0.1], wear__steady=False, accuracy__rtol=1e-3
)


def with_heights(radii, heights, **load):
    """Return a scene whose face is linear between heights at radii."""
    table = {
        "kind": "table",
        "radii": list(map(float, radii)),
        "heights": list(map(float, heights)),
    }
    return FLAT.changed(punch__profile=table, load=load)


def rough(count, **load):
    """Return a scene whose face has random heights at even radii."""
    heights = np.random.default_rng(count).uniform(0, 0.5, count)
    return with_heights(np.linspace(0, 1, count), heights, **load)
