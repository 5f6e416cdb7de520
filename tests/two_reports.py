"""Two reports of uniform fields that differ in one value, for tests of their comparison."""

import numpy as np

from ringwear import Scene

TIMES = [0.0, 1e3, 2e4, 3e5]
# with one ring, the weight of the norm of the pressure is the area
SCENE = Scene.load("rubber").changed(
    punch__ring_edges=[0.005], punch__wear_coefficients=[1e-15, 1e-15], wear__times=TIMES
)
RADII = np.linspace(0.0, 0.005, 101)


def report(**changed):
    """Return a report of uniform fields in SI units, some of which are replaced."""
    shape = len(TIMES), len(RADII)
    fields = {
        "time": np.array(TIMES),
        "radius": RADII,
        "pressure": np.full(shape, 3e5),
        "profile": np.full(shape, 1e-5) * (RADII > 0),
        "displacement": np.full(shape, 2e-5),
        "indentation": np.array([2e-4, 1e-4, 3e-4, 3e-4]),
        "pressure_error": np.full(len(TIMES), 1e-6),
        "profile_error": np.full(len(TIMES), 2e-6),
    }
    return fields | changed


def differing(quantity, row, at, amount):
    """Return a report in which one value is changed by an amount."""
    values = report()[quantity].copy()
    values[row, at] += amount
    return report(**{quantity: values})
