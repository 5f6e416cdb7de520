"""From linear pressures and what they have worn to the quantities that are asked for, labelled.

Non-dimensional.
"""

import numpy as np
import xarray
from scipy.sparse.linalg import splu

from ....meshes.compliance import Compliance
from ....meshes.radial import Array
from ...problem.problem import Problem
from ...problem.profile import InitialProfile
from ...wear.contact_edges import nodes, worn_edges
from ...wear.contact_march import ContactHistory
from ...wear.fitted_press import FittedPress
from ...wear.unilateral import Interval
from ..quantities import labelled, radial_weight

Edges = list[tuple[float, float]]


class ContactSampler:
    """Turns a march on a compliance into the quantities of a problem with an initial profile."""

    def __init__(self, problem: Problem, profile: InitialProfile, compliance: Compliance) -> None:
        self.problem, self.profile, self.compliance, space = (
            problem,
            profile,
            compliance,
            compliance.space,
        )
        self.space = space
        self._wear = problem.wear_coefficients[nodes(space)[1]]
        self._mass = splu(space.mass().tocsc())
        self._ring_forces = space.ring_forces(problem.ring_edges)
        radii, weights, local = space.quadrature
        self._unworn_slopes = profile.slope(radii.ravel())
        self._slopes = space.on_elements(local, derivative=True)
        self._slope_weights = (weights * radial_weight(radii, problem.gradient_average)).ravel()

    def contact_history(
        self, history: ContactHistory, first: FittedPress | None, on_face: bool = False
    ) -> xarray.Dataset:
        """The quantities over time; a press fitted to its edges takes the place of the start.

        Parameters
        ----------
        history : of T times
        first : the press of the unworn face; None to leave the start as marched, or if it is not
            among the times
        on_face : fields on the face of the punch, not at the radii of the output; only what can be
            compared
        """
        radii = self.problem.face.radii if on_face else self.problem.radii
        at = self.space.matrix(radii)
        worn = history.integral * self._wear
        moved = self._displaced(history)
        pressure, heights = (at @ history.pressure.T).T, self.profile(radii) + (at @ worn.T).T
        carries, displacement = pressure > 0, (at @ moved.T).T
        indentation, forces = history.indentation.copy(), history.pressure @ self._ring_forces.T
        # linear pieces are greatest at a node
        centre, greatest = moved[:, 0].copy(), moved.max(axis=1)
        edges = [
            worn_edges(self.space, *one)
            for one in zip(history.contact, history.integral, strict=True)
        ]
        if first is not None:
            indentation[0], pressure[0] = first.indentation, first.pressure_at(radii)
            carries[0] = _within(first.intervals, radii)
            forces[0] = first.ring_forces(self.problem.ring_edges)
            edges[0] = [(one.inner, one.outer) for one in first.intervals]
            if first.intervals[0].inner == 0:
                centre[0] = first.indentation - self.profile(np.zeros(1))[0]
        displacement = np.where(carries, indentation[:, None] - heights, displacement)
        values = {
            "pressure": pressure,
            "profile": heights + self.profile.standoff,
            "displacement": displacement,
            "indentation": indentation + self.profile.standoff,
            "displacement_centre": centre,
            "displacement_max": greatest,
            "rms_slope": np.sqrt(
                self._slope_weights @ (self._unworn_slopes[:, None] + self._slopes @ worn.T) ** 2
            ),
            "ring_force": forces,
            "normal_force": forces.sum(axis=1),
            "ring_worn_volume": worn @ self._ring_forces.T,
            "contact_radius": np.array([one[-1][1] if one else 0.0 for one in edges]),
        }
        if on_face:
            return labelled(values, radii, history.times)
        values["contact"] = carries.astype(float)
        values["contact_edge"] = _padded(edges)
        return labelled(values, radii, history.times)

    def bent(self, history: ContactHistory) -> Array:
        """(T,) greatest change of a slope from a cell to the next, times the wider of them.

        Of the worn depth and of u.

        At the axis the next cell is the same on the other side.
        """
        space = self.space
        width = np.diff(space.breakpoints)
        wider = np.where(np.diff(space.ring) == 0, np.maximum(width[1:], width[:-1]), 0.0)
        greatest = np.zeros(len(history.times))
        for field in (history.integral * self._wear, self._displaced(history)):
            slope = (field[:, space.dofs[:, 1]] - field[:, space.dofs[:, 0]]) / width
            change = np.abs(np.diff(slope, axis=1, prepend=-slope[:, :1])) * np.append(
                width[0], wider
            )
            greatest = np.maximum(greatest, change.max(axis=1))
        return greatest

    def _displaced(self, history: ContactHistory) -> Array:
        """(T, size) u by its moments: outside the contact the half-space is known by them only."""
        return np.asarray(self._mass.solve((history.pressure @ self.compliance.matrix).T).T)


def _within(intervals: tuple[Interval, ...], radii: Array) -> Array:
    return np.asarray(
        np.any([(radii >= one.inner) & (radii <= one.outer) for one in intervals], axis=0)
    )


def _padded(edges: list[Edges]) -> Array:
    """(T, E) inner and outer radius of every part of the contact in turn, nan where there are no
    more.
    """
    out = np.full((len(edges), 2 * max((len(one) for one in edges), default=0)), np.nan)
    for row, one in zip(out, edges, strict=True):
        row[: 2 * len(one)] = np.ravel(one)
    return out
