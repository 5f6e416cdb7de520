"""The face of a punch whose contact moves, and the displacement of the half-space under it.

What has worn is ``k H`` with the time integral H of the pressure. On cells H is linear, and it is
found by moments: at single points the face keeps ripples of the size of ``h^2 f0''`` and of the
variation of k within a cell, long after wear has smoothed it. Well inside the contact there is a
better way: the face follows the half-space, ``f = d - u``, and the displacement u of the pressure
is smooth. Beside a free edge, u bends more than the face does, and the worn depth is the better
one. Non-dimensional.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu

from ...meshes.compliance import Compliance
from ...meshes.radial import Array
from ..problem.profile import InitialProfile
from ..wear.history import History
from ..wear.unilateral import Mask
from .moments import moments

# cells between an edge of the contact and where the face is taken from the displacement: its
# projection on linear functions rings over about so many
CELLS_FROM_EDGES = 4


class WornFace:
    """A worn face and the half-space under it, at the T times of a history.

    Parameters
    ----------
    profile : of the unworn face
    compliance : on continuous piecewise linear pressures
    history : of the march
    """

    def __init__(self, profile: InitialProfile, compliance: Compliance, history: History) -> None:
        self.profile, self.history = profile, history
        self.compliance, self.space = compliance, compliance.space

    @cached_property
    def displacement(self) -> Array:
        """(T, size) coefficients of the displacement of the half-space.

        By the pressure; where nothing has worn yet, by ``u = d - f + gap``, which is exact on any
        face, and needs no pressure that may be infinite.
        """
        history, project = self.history, self._project
        by_pressure = project(self.compliance.matrix @ history.pressure.T).T
        of_face = project((history.gap - moments(self.profile, self.space)).T).T
        uniform = self.space.uniform
        unworn = history.indentation[:, None] * uniform - history.profile + of_face
        return np.where(self._has_worn[:, None], by_pressure, unworn)

    @cached_property
    def _project(self) -> Callable[[Array], Array]:
        return splu(self.space.mass().tocsc()).solve

    @property
    def _has_worn(self) -> Mask:
        return np.asarray(self.history.distances > 0)

    @cached_property
    def follows_half_space(self) -> Mask:
        """(T, E) in which cells the face is taken from the displacement, ``f = d - u``.

        These are well inside the contact, and u bends less in them than the worn depth does: linear
        functions miss as much of either as it bends.
        """
        # the axis, the edge of a hole and the rim are no free edges
        contact = np.pad(self.history.contact, ((0, 0), (0, 1)), constant_values=True)
        touches = contact[:, self.space.dofs].all(axis=2)
        apart = np.pad(~touches, ((0, 0), (CELLS_FROM_EDGES, CELLS_FROM_EDGES)))
        window = 2 * CELLS_FROM_EDGES + 1
        near_edge = sliding_window_view(apart, window, axis=1).any(axis=2)
        worn, displaced = map(self._bends, (self.history.profile, self.displacement))
        return self._has_worn[:, None] & ~near_edge & (displaced < worn)

    def _bends(self, functions: Array) -> Array:
        """Return by how much functions change their slope at the ends of each cell (T, E).

        The functions are (T, size). The change at each end is multiplied by the width of the wider
        cell there, and the greater of both ends is returned.
        """
        space = self.space
        width = np.diff(space.breakpoints)
        # in a hole there is nothing to bend
        functions = np.pad(functions, ((0, 0), (0, 1)))
        slope = (functions[:, space.dofs[:, 1]] - functions[:, space.dofs[:, 0]]) / width
        # at the axis the next cell is the same on the other side
        change = np.abs(np.diff(slope, axis=1, prepend=-slope[:, :1]))
        # at ring edges fields may have kinks, which cells do not lose
        same_ring = np.diff(space.ring) == 0
        wider = np.where(same_ring, np.maximum(width[1:], width[:-1]), 0.0)
        change = change * np.append(width[0], wider)
        return np.maximum(change, np.pad(change[:, 1:], ((0, 0), (0, 1))))

    @property
    def lost_bends(self) -> Array:
        """(T,) greatest bend of the face, or of the displacement, that linear functions miss."""
        worn, displaced = map(self._bends, (self.history.profile, self.displacement))
        worn = np.where(self.follows_half_space, 0.0, worn)
        return np.asarray(np.maximum(worn, displaced).max(axis=1))

    def heights(self, at_radii: csr_matrix, radii: Array) -> Array:
        """Return heights of the face (T, R) at radii, by the matrix of the basis there."""
        worn = self.profile(radii) + (at_radii @ self.history.profile.T).T
        cells = np.searchsorted(self.space.breakpoints, radii, side="right") - 1
        follows = self.follows_half_space[:, np.minimum(cells, len(self.space.degrees) - 1)]
        below = self.history.indentation[:, None] - (at_radii @ self.displacement.T).T
        return np.where(follows, below, worn)

    def slopes(self, at_points: csr_matrix, radii: Array) -> Array:
        """Return the slopes of the face (T, E Q) at Q points in each of E cells.

        `at_points` is the matrix of the slopes of the basis at these points, `radii` (E, Q) are
        their radii.
        """
        worn = self.profile.slope(radii.ravel()) + (at_points @ self.history.profile.T).T
        follows = np.repeat(self.follows_half_space, radii.shape[1], axis=1)
        return np.where(follows, -(at_points @ self.displacement.T).T, worn)

    def displacements(self, at_radii: csr_matrix, radii: Array, carries: Mask) -> Array:
        """Return displacements (T, R) at radii of which some carry (T, R).

        Before any wear, u = d - f there, which needs no projection.
        """
        touches = carries & ~self._has_worn[:, None]
        touching = self.history.indentation[:, None] - self.profile(radii)
        return np.where(touches, touching, (at_radii @ self.displacement.T).T)
