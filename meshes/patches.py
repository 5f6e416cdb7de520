"""Sizes of the patches of geometric layers round ring edges and rim, and of what lies between: known before any mesh is."""

from __future__ import annotations

import numpy as np
from ringwear.meshes.radial import Array, Indices

# neighbouring patches are widened up to this to meet in the middle of a ring
WIDENED = 1.6
# greatest elements between the patches, over the truncation; those beside a patch, over its depth
LARGEST, BESIDE = 0.4, 1.4
# how far the degree of the displacement may fall from layer to layer, as there is ever less energy to lose (the rim's
# singularity is stronger), down to the least that goes with a stable linear pressure
FALL, FALL_AT_RIM, LOWEST = 1.0, 0.6, 3


def patch_widths(edges: Array) -> Array:
    """(N, 2) half-widths of the patch at each edge but the centre, towards the axis and away from it."""
    rings = np.diff(edges)
    half = np.minimum(rings, np.append(rings[1:], np.inf)) / 2
    widths = np.stack([half, half], axis=1)
    # in the rings between two patches
    stretch = rings[1:] / (half[:-1] + half[1:])
    stretch[stretch > WIDENED] = 1.0
    widths[:-1, 1] *= stretch
    widths[1:, 0] *= stretch
    return widths


def patch_layers(widths: Array, sizes: Array, factor: float) -> Indices:
    """(N,) layers that each patch needs for innermost elements no larger than its size."""
    return np.maximum(1, np.ceil(np.log(sizes / widths.max(axis=1)) / np.log(factor) - 1e-9)).astype(np.int64)


def falls(layers: Indices) -> list[Indices]:
    """For each patch (layers + 1,) how much lower the degree may be in each layer and, last, in the middle."""
    rates = np.append(np.full(len(layers) - 1, FALL), FALL_AT_RIM)
    return [(rate * np.arange(count + 1)).astype(np.int64) for rate, count in zip(rates, layers, strict=True)]


def beside(widths: Array) -> Array:
    """(N,) size of the elements beside each patch, in few distinct values, which is what a mesher digests."""
    return np.asarray(2.0 ** (np.round(4 * np.log2(BESIDE * widths.mean(axis=1))) / 4))
