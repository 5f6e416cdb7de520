"""Ways to refine the cells of a face on which contact opens, closes and spreads.

The ways are MDR, boundary elements, and finite elements of degree 1 to 4 on triangles and of degree
1 and 2 on quadrilaterals. Pressures are linear on cells, which become smaller from level to level.
With displacements of degree 1, pressures are linear on pairs of facets, which is stable. Higher
degrees of the pressure are left out, because the sign of the pressure is enforced only at nodes and
a contact edge inside an element makes them inaccurate.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...fem.contact_meshes import TRIANGLE_GROWTH
from ...fem.far_field import enough_poles
from ...fem.half_space import pressure_space
from ..crosscheck import (
    AxisymmetricElasticity,
    ContactCells,
    Discretised,
    HalfSpace,
    Problem,
    SizeField,
    Stages,
    bisection,
    energy,
    even_half_space,
    ring_kernel,
)
from ..crosscheck.methods.spaces import scaled_cells
from ..numerics.subdivision import subdivided
from . import theories
from .way import Way

CELL_FACTORS, QUICK_CELL_FACTORS = (0.25, 0.5, 1.0, 2.0), (0.125, 0.25, 0.5)
"""Number of cells over the number for rtol 1e-4, from coarse to fine (`cells_of`)."""
CELL_SIZE_LABEL = "cell size over that for rtol 1e-4"
ON_PRESSURES, ON_TRIANGLES, ON_QUADS = "cells", "cells, triangles", "cells, quadrilaterals"
"""Groups of ways; each group is drawn in one figure."""
TRUNCATION, NEGLIGIBLE_ENERGY = 5.0, 1e-10
"""Truncation radius of quadrilaterals in punch radii; relative energy error of the far field."""


def ways_of_cells(problem: Problem, quick: bool) -> Iterator[Way]:
    """Yield all ways to refine the cells of a face, each from coarse to fine."""
    sizes = {factor: 1 / factor for factor in (QUICK_CELL_FACTORS if quick else CELL_FACTORS)}

    def way(
        name: str, group: str, method: str, seconds: float, degree: int = 0, quads: bool = False
    ) -> Way:
        def discretise(setting: float, stages: Stages) -> Discretised:
            cells = scaled_cells(problem, setting)
            with stages("condensing"):
                if method == "fem":
                    return elements_on(problem, cells, setting, degree, quads)
                kernel = ring_kernel if method == "bem" else energy
                compliance = kernel.compliance(cells.space())
                return Discretised(compliance, lambda: compliance)

        def work(setting: float) -> float:
            return seconds * (0.2 + setting**2)

        return Way(
            name, name, group, method, sizes, discretise, theories.for_cells, CELL_SIZE_LABEL, work
        )

    yield way("MDR", ON_PRESSURES, "mdr", 3.0)
    yield way("BEM", ON_PRESSURES, "bem", 3.0)
    for degree in (1, 2, 3, 4):
        yield way(f"FEM P{degree}", ON_TRIANGLES, "fem", 3.0 + degree, degree=degree, quads=False)
    for degree in (1, 2):
        yield way(f"FEM Q{degree}", ON_QUADS, "fem", 4.0 + degree, degree=degree, quads=True)


def elements_on(
    problem: Problem, cells: ContactCells, cell_factor: float, degree: int, quads: bool
) -> Discretised:
    """Return condensed finite elements whose facets on the contact are no larger than the cells.

    Each quadrilateral mesh is made from triangles: a triangle becomes three quadrilaterals, and
    each of its facets two facets. These triangles are therefore made for cells twice as large.

    Parameters
    ----------
    problem : problem with its ring edges and Poisson's ratio
    cells : cells of the contact
    cell_factor : number of cells over the number for rtol 1e-4
    degree : polynomial degree of the displacement
    quads : whether the elements are quadrilaterals, not triangles
    """
    if not quads:
        half_space = even_half_space(cells, problem.ground, degree=degree)
    else:
        larger = scaled_cells(problem, cell_factor / 2)
        edges, size = larger.ring_edges, larger.edge_size
        field = SizeField(
            edges, size, size, TRIANGLE_GROWTH, TRUNCATION, larger.largest, 0.125, larger
        )
        mesh = subdivided(
            bisection.mesh(field), 1, np.array(edges), into_quads=True, log_polar=False
        )
        solid = AxisymmetricElasticity(mesh, degree, problem.ground)
        space = pressure_space(solid, np.array(edges))
        linear = replace(space, degrees=np.minimum(space.degrees, 1))
        half_space = HalfSpace(solid, linear, enough_poles(TRUNCATION, NEGLIGIBLE_ENERGY))
    if degree == 1:
        # linear pressures on single facets, discontinuous at ring edges, would outnumber the nodes
        # on the contact, and so be unstable
        half_space = replace(half_space, space=half_space.space.coarser())
    compliance = half_space.compliance()
    return Discretised(compliance, lambda: compliance, half_space.unknowns, half_space=half_space)
