"""The pairs of spaces that are compared: elements of the displacement, and contact pressures.

All pressures of one displacement lie in one space: polynomials of the degree k of the displacement
on each facet of the contact, broken at every vertex. It is singular as a whole. The half-space is
condensed to it once, and each pressure space is a basis within it.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
import skfem
from scipy.sparse import csr_matrix
from skfem import Element, Mesh, MeshQuad

from ...fem.elasticity import AxisymmetricElasticity
from ...fem.elements import degree_along_side, is_on_quadrilaterals
from ...fem.half_space import contact_breakpoints, pressure_space
from ...fem.weak_form import element_of_degree
from ...meshes import bisection
from ...meshes.by_gmsh import quads
from ...meshes.errors import MeshError, SceneError
from ...meshes.half_space import as_half_space, halved
from ...meshes.pressure_space import PressureSpace
from ...meshes.radial import Array
from ...meshes.sizes import SizeField
from ..problem.problem import Rings

TRUNCATION = 2.5
"""Radius of the half-space in punch radii; the poles beyond it err by less than 1e-9."""
RING_SIZE, RIM_SIZE, FACTOR, GROWTH = 0.06, 0.03, 0.5, 1.0
"""Of the coarsest mesh, in punch radii: few layers, so that all of it is refined by halving."""

Kind = Literal[
    "continuous",
    "broken at ring edges",
    "broken everywhere",
    "wear rate continuous",
    "as in ringwear run",
]


@dataclass(frozen=True)
class Displacement:
    """An element of the displacement.

    Parameters
    ----------
    name : in tables and figures
    element : of scikit-fem, or of the user's own
    """

    name: str
    element: Element

    @property
    def degree(self) -> int:
        """The polynomial degree along a side."""
        return degree_along_side(self.element)

    @property
    def on_quadrilaterals(self) -> bool:
        """Whether it is an element of quadrilaterals, not of triangles."""
        return is_on_quadrilaterals(self.element)


@dataclass(frozen=True)
class Pressures:
    """A space of contact pressures.

    Parameters
    ----------
    kind : where pressures may jump; ``as in ringwear run`` is the space that runs take
    degree : polynomial degree; that of what runs take is the highest
    """

    kind: Kind
    degree: int

    @property
    def name(self) -> str:
        """What it is called in tables."""
        return f"{self.kind}, degree {self.degree}"

    def is_singular_beneath(self, degree: int) -> bool:
        """Return whether some pressures displace nothing: there are more than displacements."""
        return self.kind.startswith("broken") and self.degree == degree

    def has_checkerboards_beneath(self, degree: int) -> bool:
        """Return whether the least eigenvalue falls with the size, as theory and trials say."""
        return self.kind == "broken everywhere" and self.degree == degree - 1


def displacements(given: Sequence[Element], quick: bool) -> list[Displacement]:
    """Return the displacements to compare: those given, or scikit-fem's of several degrees.

    Raises
    ------
    SceneError
        if the half-space cannot take an element that is given, or if one is given twice
    """
    own, called = list[Displacement](), Counter(type(element).__name__ for element in given)
    for element in given:
        degree, name = degree_along_side(element), type(element).__name__
        several = called[name] > 1
        own.append(Displacement(f"{name} of degree {degree}" if several else name, element))
    if len({each.name for each in own}) < len(own):
        raise SceneError("an element is given twice: give elements of other kinds or degrees")
    names = ("P1", "P2", "P4", "Q1", "Q2") if quick else ("P1", "P2", "P3", "P4", "Q1", "Q2", "Q4")
    return own or [of_name(name) for name in names]


def of_name(name: str) -> Displacement:
    """Return scikit-fem's element P1 to P4 on triangles, or Q1, Q2, ... on quadrilaterals."""
    mesh = skfem.MeshQuad() if name[0] == "Q" else skfem.MeshTri()
    return Displacement(name, element_of_degree(mesh, int(name[1:])))


def pressures_beneath(displacement: Displacement, rings: Rings) -> list[Pressures]:
    """Return the pressure spaces that go with a displacement of a degree k.

    Degrees k, k - 1 and k - 2 where they are 1 at the least, continuous or not; constants on each
    facet; those with a continuous wear rate; and what runs take. A punch of one ring has no edge at
    which pressures could break.
    """
    degree = displacement.degree
    degrees = [lower for lower in (degree - 1, degree, degree - 2) if lower >= 1]
    kinds: tuple[Kind, ...] = ("continuous", "broken everywhere")
    worn = list[Pressures]()
    if len(rings.wear_coefficients) > 1:
        kinds = ("continuous", "broken at ring edges", "broken everywhere")
        worn = [Pressures("wear rate continuous", max(degree - 1, 1))]
    spaces = [Pressures(kind, each) for kind in kinds for each in degrees]
    return [*spaces, Pressures("broken everywhere", 0), *worn, of_runs(displacement)]


def of_runs(displacement: Displacement) -> Pressures:
    """Return the pressure space that runs take beneath a displacement (`pressure_space`)."""
    lower = 2 if displacement.on_quadrilaterals else 1
    return Pressures("as in ringwear run", max(displacement.degree - lower, 1))


@dataclass(frozen=True, eq=False)
class Meshes:
    """One graded mesh, halved again and again: quadrilaterals, and the same cut into triangles.

    Parameters
    ----------
    rings : of the punch
    """

    rings: Rings

    @cached_property
    def coarsest(self) -> Mesh:
        """The coarsest mesh; triangles by bisection where gmsh cannot be used."""
        edges = self.rings.ring_edges
        at_edges = np.minimum(RING_SIZE, 0.3 * self.rings.narrower)
        at_rim = min(RIM_SIZE, 0.15 * float(self.rings.widths[-1]))
        try:
            return quads.graded(edges, at_edges, at_rim, FACTOR, GROWTH, TRUNCATION).mesh
        except MeshError:
            sizes = tuple(float(size) for size in at_edges)
            field = SizeField(tuple(edges.tolist()), at_rim, sizes, GROWTH, TRUNCATION)
            return bisection.mesh(field)

    @property
    def has_quadrilaterals(self) -> bool:
        """Whether there are quadrilaterals."""
        return isinstance(self.coarsest, MeshQuad)

    def halved(self, count: int, on_quadrilaterals: bool) -> Mesh:
        """Return the mesh with every element halved so many times, new points put on the arc."""
        mesh = halved(self.coarsest, self.rings.ring_edges, count)
        if isinstance(mesh, MeshQuad) and not on_quadrilaterals:
            return as_half_space(mesh.to_meshtri(), self.rings.ring_edges)
        return mesh


def whole_space(mesh: Mesh, ring_edges: Array, degree: int) -> PressureSpace:
    """Return the space of all pressures of a degree on the facets, broken at every vertex."""
    breakpoints, _ = contact_breakpoints(mesh, ring_edges)
    return PressureSpace(breakpoints, np.full(len(breakpoints) - 1, degree), breakpoints)


def basis(
    whole: PressureSpace, pressures: Pressures, rings: Rings, solid: AxisymmetricElasticity
) -> csr_matrix:
    """Return a basis (whole size, n) of a pressure space within the whole one.

    Parameters
    ----------
    whole : of `whole_space`
    pressures : which space
    rings : of the punch, with their wear coefficients
    solid : the displacement, to which the space of a run is chosen
    """
    if pressures.kind == "as in ringwear run":
        chosen = replace(pressure_space(solid, rings.ring_edges), low_parts=None)
        return whole.embedding(chosen)
    if pressures.degree == 0:
        return csr_matrix(whole.ring_indicator())
    edges = {
        "continuous": rings.ring_edges[[0, -1]],
        "broken everywhere": whole.breakpoints,
    }.get(pressures.kind, rings.ring_edges)
    degrees = np.full(len(whole.degrees), pressures.degree)
    space = PressureSpace(whole.breakpoints, degrees, edges)
    embedded = whole.embedding(space)
    if pressures.kind == "wear rate continuous":
        return embedded @ space.joined(rings.wear_coefficients)
    return embedded
