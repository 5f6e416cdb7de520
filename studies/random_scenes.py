"""Scenes drawn at random over everything that users may ask: for testing whether stated errors are honest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from ringwear.studies.problem.scene import Scene


def random_scenes(seed: int, count: int, most_rings: int = 64) -> Iterator[Scene]:
    """Rings 1 to `most_rings`, wear ratios 1e-3 to 1e3, width ratios 0.1 to 10, nu 0 to 0.5, rtol 1e-2 to 1e-7."""
    generator = np.random.default_rng(seed)
    for number in range(count):
        rings = int(np.exp(generator.uniform(0, np.log(most_rings + 1))))
        ratio, width = 10 ** generator.uniform(-3, 3), 10 ** generator.uniform(-1, 1)
        times = np.concatenate([[0.0], np.geomspace(1e-3, 10, 7) / max(1.0, ratio) * max(1.0, 1 / ratio)])
        yield Scene.from_table(
            {
                "title": f"random scene {number} of seed {seed}",
                "methods": ["mdr", "fem"],
                "punch": {
                    "radius": 1.0,
                    "rings": rings,
                    "width_ratio": float(width),
                    "wear_coefficients": [1.0, float(ratio)],
                },
                "half_space": {"plane_strain_modulus": 1.0, "poisson_ratio": float(generator.uniform(0, 0.5))},
                "load": {"normal_force": 1.0},
                "wear": {"times": [float(time) for time in times]},
                "accuracy": {"rtol": float(10 ** generator.uniform(-7, -2))},
            }
        )
