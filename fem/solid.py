"""What the half-space asks of an elastic solid, whatever its elements."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from scipy.sparse import coo_matrix

from meshes.half_space import HalfSpaceMesh
from meshes.radial import Array, Indices
from meshes.stars import StarMesh

from .trace import Trace


class Solid(Protocol):
    """An axisymmetric elastic solid on a mesh; unknowns of its functions are all radial, then all axial."""

    @property
    def mesh(self) -> HalfSpaceMesh | StarMesh: ...

    @property
    def degree(self) -> int:
        """Highest degree of the displacement."""

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio that is modelled."""

    @property
    def nodes(self) -> int:
        """Number of functions that are not inside elements; there are twice as many unknowns to assemble."""

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns, those inside elements among them."""

    @property
    def parts(self) -> tuple[Indices, Indices]:
        """(p, m) corners and sides of each element, in one numbering, and (nodes,) the corner or side of each function."""

    def boundary(self, name: str) -> Indices:
        """Function numbers on a named boundary, in the order of the radius."""

    def interpolate(self, name: str, displacement: Callable[[Array], Array]) -> Array:
        """(functions, 2) coefficients on a named boundary, in its order, of a displacement (n, 2) at (n, 2) points."""

    def trace(self, breakpoints: Array) -> Trace:
        """Displacements on the contact facets between the breakpoints."""

    def lower_triangle(self, position: Indices) -> coo_matrix:
        """Lower triangle of the stiffness without the insides of elements; entries at one place are to be summed.

        Parameters
        ----------
        position : (2 nodes,) row of each unknown; that of an unknown held at zero is negative
        """

    def forces(self, displacement: Array) -> Array:
        """(2 nodes, k) forces that make the (2 nodes, k) displacements."""
