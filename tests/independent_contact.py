"""An independent solution of contact that opens, closes and spreads, on a homogeneous half-space.

It shares no code with any method. Pressures are uniform on narrow rings, and their energies are
differences of the closed-form energies of discs (`closed_forms.disc_energies`). The contact is
found by an active set, and wear is marched by Alexander's method of second order, in steps that are
proportional to the time. Radii are in punch radii, and the plane strain modulus is 1.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from closed_forms import disc_energies
from numpy.polynomial.legendre import leggauss
from scipy.linalg import cho_factor, cho_solve

Array = np.ndarray
# diagonal coefficient of Alexander's method
GAMMA = 1 - np.sqrt(0.5)


def graded_rings(edges, size):
    """Return the edges of narrow rings whose widths follow `size`, a function of the radius."""
    radii = [np.array(edges[:1])]
    for inner, outer in pairwise(edges):
        near = np.geomspace(1e-8, 0.5, 800)
        fractions = np.unique(np.concatenate([np.linspace(0, 1, 2001), near, 1 - near]))
        grid = inner + (outer - inner) * fractions
        density = 1 / size(grid)
        parts = np.diff(grid) * (density[1:] + density[:-1]) / 2
        integral = np.append(0.0, np.cumsum(parts))
        count = max(2, int(np.ceil(integral[-1])))
        radii.append(np.interp(np.arange(1, count) * integral[-1] / count, integral, grid))
        radii.append(np.array([outer]))
    return np.concatenate(radii)


@dataclass
class State:
    """Pressures, worn depths and contact (n,) of the narrow rings at a time, and indentation."""

    time: float
    pressure: Array
    worn: Array
    contact: Array
    indentation: float


class WornPunch:
    """A shaped punch on narrow rings.

    Parameters
    ----------
    edges : edges of the narrow rings, from 0 or from the radius of a hole to 1
    wear : function of the radius that returns the wear coefficient
    height : function of the radius that returns the height of the unworn face
    """

    def __init__(self, edges, wear, height):
        self.edges, self.middles = edges, (edges[1:] + edges[:-1]) / 2
        self.areas, self.wear = np.pi * np.diff(edges**2), wear(self.middles)
        discs = edges if edges[0] else edges[1:]
        energies = disc_energies(discs)
        if not edges[0]:
            energies = np.pad(energies, ((1, 0), (1, 0)))
        self.matrix = np.diff(np.diff(energies, axis=0), axis=1)
        node, weight = leggauss(6)
        radii = self.middles[:, None] + np.diff(edges)[:, None] / 2 * node
        self.moments = (height(radii) * np.pi * radii) @ weight * np.diff(edges)

    def _press(self, force, step, moments, contact):
        """Return pressures, indentation and contact under a force, with wear for `step`."""
        contact = contact.copy()
        for count in range(500):
            inside = np.flatnonzero(contact)
            block = self.matrix[np.ix_(inside, inside)]
            block[np.diag_indices(len(inside))] += step * (self.wear * self.areas)[inside]
            factor = cho_factor(block, overwrite_a=True)
            of_areas, of_moments = (
                cho_solve(factor, values[inside]) for values in (self.areas, moments)
            )
            depth = (force + self.areas[inside] @ of_moments) / (self.areas[inside] @ of_areas)
            pressure = np.zeros(len(contact))
            pressure[inside] = depth * of_areas - of_moments
            gap = self.matrix @ pressure + moments - depth * self.areas
            roundoff = 1e-14 * (np.abs(moments) + abs(depth) * self.areas)
            wrong = np.where(contact, pressure < 0, gap < -roundoff)
            if not wrong.any():
                return pressure, depth, contact
            if count > 60:
                wrong[np.flatnonzero(wrong)[0] + 1 :] = False
            contact ^= wrong
        raise AssertionError("the active set cycles")

    def march(self, force, times, steps_per_decade=20, first=0.01):
        """Return the states at increasing times, the first of which may be 0."""
        integral, time, contact = np.zeros(len(self.areas)), 0.0, np.ones(len(self.areas), bool)
        pressure, depth, contact = self._press(force, 0.0, self.moments, contact)
        shortest = first * min((t for t in times if t > 0), default=1.0)
        states = []
        for end in times:
            while time < end * (1 - 1e-12):
                step = min(end - time, max(shortest, time * (10 ** (1 / steps_per_decade) - 1)))
                for last in (False, True):
                    part = GAMMA * step
                    moments = self.moments + self.wear * self.areas * integral
                    pressure, depth, contact = self._press(force, part, moments, contact)
                    # the first stage acts for the rest of the step
                    integral = integral + (part if last else step - part) * pressure
                time += step
            worn = self.wear * integral
            states.append(State(end, pressure, worn, contact.copy(), float(depth)))
        return states

    def contact_radius(self, state):
        """Return the outermost radius of contact."""
        return float(self.edges[np.flatnonzero(state.contact)[-1] + 1])

    def by_ring(self, values, ring_edges):
        """Return sums over the rings of the punch of values times areas."""
        ring = np.searchsorted(ring_edges, self.middles) - 1
        return np.bincount(ring, values * self.areas, minlength=len(ring_edges) - 1)
