"""Changes of results by name, in place, as faults: of the table, or of what a method has computed.

A change is a function of (values by name, radii of the fields, problem). Fields have the last index
over the radius, quantities of rings over the rings, and histories the first index over time.
"""

from collections.abc import Callable

import numpy as np

Change = Callable[[dict, np.ndarray, object], None]


def change(function: Callable) -> Callable[..., Change]:
    """Make a function of (values, radii, problem, *others) a change with the others given."""
    return lambda *others: lambda values, *where: function(values, *where, *others)


@change
def scale(values, _, _problem, name, size, *where):
    """Scale a quantity everywhere or at some times, rings or modes."""
    # the contact and its edges are not among the values on the face
    if name in values:
        values[name][where or ...] *= 1 + size


@change
def scale_together(values, _, _problem, names, size):
    """Scale several quantities by one factor, as a wrong unit would do."""
    for name in set(names) & values.keys():
        values[name][...] *= 1 + size


@change
def scale_on_ring(values, radii, problem, name, size, of_greatest=False):
    """Scale a field on the second ring, or add a fraction of its greatest value there."""
    on, field = (radii > problem.ring_edges[1]) & (radii < problem.ring_edges[2]), values[name]
    greatest = np.max(np.where(np.isfinite(field), np.abs(field), 0), axis=-1, keepdims=True)
    field[..., on] += size * (greatest if of_greatest else field[..., on])


@change
def offset(values, _, _problem, name, part):
    """Add a fraction of the indentation to a field everywhere."""
    values[name][...] += part * values["indentation"][:, None]


@change
def swap(values, _, _problem, name):
    """Exchange the values of the first two rings."""
    values[name][..., [0, 1]] = values[name][..., [1, 0]]


@change
def swap_states(values, _, _problem, name):
    """Exchange the values of the start and of the steady state."""
    values[name][...] = values[name][::-1].copy()


@change
def move_force(values, _, _problem, size):
    """Move a fraction of the total force from the first ring to the second."""
    forces = values["ring_force"]
    moved = size * forces.sum(axis=1)
    forces[:, 0] -= moved
    forces[:, 1] += moved


@change
def smear(values, radii, problem, width):
    """Average pressures over all radii within a distance from the first ring edge."""
    near = np.abs(radii - problem.ring_edges[1]) < width
    weights = radii[near] * np.gradient(radii)[near]
    mean = (values["pressure"][:, near] @ weights) / weights.sum()
    values["pressure"][:, near] = mean[:, None]


@change
def stretch(values, radii, _problem, name, size):
    """Stretch a field along the radius."""
    for row in values[name]:
        row[:] = np.interp(radii / (1 + size), radii, row)


@change
def shift_radii(values, _, _problem, name):
    """Shift a field by one radius."""
    values[name][..., 1:-1] = values[name][..., 2:].copy()


@change
def late(values, _, _problem, names, at=-1):
    """Replace the values at a time with those at the time before it."""
    for name in {*names} & values.keys():
        values[name][at] = values[name][at - 1]


@change
def tilt(values, radii, _problem, size):
    """Add opposite errors to profile and displacement, so that their sum stays right."""
    off = size * values["indentation"][:, None] * radii
    off[values["time"] == 0] = 0.0
    values["profile"] += off
    values["displacement"] -= off


@change
def take(values, _, _problem, name, other, *where):
    """Replace a number with another one."""
    values[name][...] = values[other][where or ...]
