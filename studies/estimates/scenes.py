"""Scenes drawn at random, far wider than what is usual.

For studies of errors and for tests. Any seed will do.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...meshes.radial import Array
from ..problem.scene import Scene

NARROWEST = 1e-4
LONGEST, SHORTEST = 1e3, 1e-8  # times, in natural units
COUNT = 7  # of them
SPECIAL = (0.5, 0.49, 0.3)


def random_scenes(seed: int, count: int, most_rings: int = 24, **changes: Any) -> Iterator[Scene]:
    """Rings 1 to `most_rings`, widths to 1e-4, wear ratios 1e-6 to 1e6, nu -0.5 to 0.5, rtol 1e-2
    to 1e-8.

    Times are from 1e-8 to 1e3 natural ones, about half with the start. `changes` are made to every
    scene.
    """
    generator = np.random.default_rng(seed)
    for number in range(count):
        rings = int(np.exp(generator.uniform(0, np.log(most_rings + 1))))
        widths = 10 ** generator.uniform(-generator.uniform(0, 4), 0, rings)
        edges = np.cumsum(np.maximum(widths / widths.sum(), NARROWEST))
        coefficients = _wear_coefficients(generator, rings)
        first = 10 ** generator.uniform(np.log10(SHORTEST), 1)
        times = np.geomspace(
            first, first * 10 ** generator.uniform(0.3, np.log10(LONGEST / first)), COUNT
        )
        if generator.random() < 0.5:
            times = np.append(0.0, times)
        usual = generator.random() < 0.7
        poisson_ratio = float(generator.uniform(-0.5, 0.5) if usual else generator.choice(SPECIAL))
        drawn = {
            "methods": ["mdr", "direct", "fem"],
            "punch": {
                "radius": 1.0,
                "ring_edges": (edges / edges[-1]).tolist(),
                "wear_coefficients": coefficients.tolist(),
            },
            "half_space__poisson_ratio": poisson_ratio,
            "wear": {"times": (times / coefficients.max()).tolist()},
            "accuracy__rtol": float(10 ** generator.uniform(-8, -2)),
        }
        yield Scene.load("five_rings").changed(
            title=f"random scene {number} of seed {seed}", **drawn | changes
        )


def _wear_coefficients(generator: np.random.Generator, rings: int) -> Array:
    """Two that alternate, or one for each ring."""
    power = generator.uniform(-6, 6)
    if rings == 1:
        return np.ones(1)
    if rings == 2 or generator.random() < 1 / 3:
        return np.resize([1.0, 10**power], rings)
    return np.asarray(10 ** generator.uniform(-abs(power), 0, rings))
