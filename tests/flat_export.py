"""A flat punch of radius 1 under the force 2, and its pressures, as other programs export them."""

import numpy as np

from ringwear import Scene

SCENE = Scene.from_table(
    {
        "units": "mm, N, MPa, s",
        "methods": ["mdr"],
        "punch": {"radius": 1.0, "wear_coefficient": 1.0},
        "half_space": {"plane_strain_modulus": 1.0},
        "load": {"normal_force": 2.0, "sliding_speed": 1.0},
        "wear": {"times": [0.0]},
    }
)
R = np.linspace(0, 0.95, 20)
PRESSURE = 1 / (np.pi * np.sqrt(1 - R**2))
