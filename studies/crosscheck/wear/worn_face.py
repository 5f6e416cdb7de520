"""Evaluate the face of a punch whose contact moves, and the displacement of the half-space.

Non-dimensional. The worn depth is ``k H`` with the integral H of the pressure over the sliding
distance. H is linear on each cell and determined by moments. At single points, the face ``f0 + k
H`` therefore has ripples of the size of ``h^2 f0''`` and of the variation of k within a cell, even
after wear has smoothed the true face. Well inside the contact, the displacement is more accurate:
the face follows the half-space, ``f = d - u``, and u is smooth. Near a free edge, u has more
curvature than the worn depth, so the worn depth is more accurate there.
"""

from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.sparse import csr_matrix

from ....meshes.compliance import Compliance
from ....meshes.radial import Array
from ..problem.profile import InitialProfile, moments
from .history import History
from .slope_integrals import SlopeIntegrals
from .unilateral import Mask

# number of cells between an edge of the contact and the cells whose face is computed from the
# displacement; the projection of u on linear functions oscillates over about that many cells
CELLS_FROM_EDGES = 4


class WornFace:
    """A worn face and the half-space under it, at the T times of a history.

    Parameters
    ----------
    profile : InitialProfile
        Unworn face.
    compliance : Compliance
        Compliance on continuous piecewise linear pressures.
    history : History
        History of the march.
    """

    def __init__(self, profile: InitialProfile, compliance: Compliance, history: History) -> None:
        self.profile, self.history = profile, history
        self.compliance, self.space = compliance, compliance.space

    @cached_property
    def displacement(self) -> Array:
        """(T, size) coefficients of the displacement of the half-space.

        They are computed from the pressure. Before any wear they are computed from ``u = d - f +
        gap`` instead, which is exact for any face and avoids pressures that may be infinite.
        """
        history, project = self.history, self.space.projected
        by_pressure = project(self.compliance.matrix @ history.pressure.T).T
        of_face = project((history.gap - moments(self.profile, self.space)).T).T
        uniform = self.space.uniform
        unworn = history.depth[:, None] * uniform - history.shape + of_face
        return np.where(self._has_worn[:, None], by_pressure, unworn)

    @property
    def _has_worn(self) -> Mask:
        return self.history.distances > 0

    @cached_property
    def follows_half_space(self) -> Mask:
        """(T, E) whether the face is computed from the displacement in each cell, ``f = d - u``.

        Such cells are well inside the contact, and u changes its slope less there than the worn
        depth does. The interpolation error of linear functions is proportional to that change.
        """
        # the axis, the edge of a hole and the rim are not free edges
        touches = self.history.contact[:, self.space.dofs].all(axis=2)
        outside = np.pad(~touches, ((0, 0), (CELLS_FROM_EDGES, CELLS_FROM_EDGES)))
        window = 2 * CELLS_FROM_EDGES + 1
        near_edge = sliding_window_view(outside, window, axis=1).any(axis=2)
        worn, displaced = map(self._bending, (self.history.shape, self.displacement))
        return self._has_worn[:, None] & ~near_edge & (displaced < worn)

    def _bending(self, functions: Array) -> Array:
        """Return the change of slope of functions (T, size) at the ends of each cell (T, E).

        The change at each end is multiplied by the width of the wider of the two cells there. The
        result is the greater value of both ends.
        """
        space = self.space
        width = np.diff(space.breakpoints)
        slope = (functions[:, space.dofs[:, 1]] - functions[:, space.dofs[:, 0]]) / width
        # at the axis the next cell is the mirror image
        change = np.abs(np.diff(slope, axis=1, prepend=-slope[:, :1]))
        # fields may have kinks at ring edges; these are breakpoints, so no accuracy is lost there
        same_ring = np.diff(space.ring) == 0
        wider = np.where(same_ring, np.maximum(width[1:], width[:-1]), 0.0)
        change = change * np.append(0.0 if space.inner_radius else width[0], wider)
        return np.maximum(change, np.pad(change[:, 1:], ((0, 0), (0, 1))))

    @property
    def unresolved_bending(self) -> Array:
        """(T,) greatest change of slope times cell width, of the face or of the displacement.

        It measures what linear functions do not resolve. In cells whose face is computed from the
        displacement, the worn depth is ignored.
        """
        worn, displaced = map(self._bending, (self.history.shape, self.displacement))
        worn = np.where(self.follows_half_space, 0.0, worn)
        return np.maximum(worn, displaced).max(axis=1)

    def heights(self, at_radii: csr_matrix, radii: Array) -> Array:
        """Return heights of the face (T, R) at radii (R,), less the even wear of the history.

        `at_radii` (R, size) is the matrix of the basis functions at these radii.
        """
        worn = self.profile(radii) + (at_radii @ self.history.shape.T).T
        cells = np.searchsorted(self.space.breakpoints, radii, side="right") - 1
        follows = self.follows_half_space[:, np.clip(cells, 0, len(self.space.degrees) - 1)]
        below = self.history.depth[:, None] - (at_radii @ self.displacement.T).T
        return np.where(follows, below, worn)

    def mean_square_slopes(self, unworn: SlopeIntegrals) -> Array:
        """Return the mean square (T,) of the slope of the face; infinite if that is not finite.

        `unworn` are the integrals of the slope of the unworn face over the E cells, with the weight
        of the mean.
        """
        slope_of = self.space.on_elements(np.zeros(1), derivative=True)
        worn, displaced = (
            (slope_of @ functions.T).T for functions in (self.history.shape, self.displacement)
        )
        # of f' + w', with the slope w' of the worn depth, which is the same in all of a cell
        with np.errstate(invalid="ignore"):  # an infinite slope where nothing is worn
            squares = unworn.square + 2 * worn * unworn.slope + worn**2 * unworn.weight
        squares = np.where(self.follows_half_space, displaced**2 * unworn.weight, squares)
        return np.maximum(squares.sum(axis=1), 0.0)

    def displacements(self, at_radii: csr_matrix, radii: Array, carries: Mask) -> Array:
        """Return displacements (T, R) at radii (R,); `carries` (T, R) says which are in contact.

        Before any wear, the displacement in contact is u = d - f, which needs no projection.
        """
        touches = carries & ~self._has_worn[:, None]
        touching = self.history.depth[:, None] - self.profile(radii)
        return np.where(touches, touching, (at_radii @ self.displacement.T).T)
