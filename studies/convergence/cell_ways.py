"""Ways to refine the cells of a face on which contact opens, closes and spreads.

MDR, boundary elements, and finite elements of degree 1 to 4 on triangles and of degree 1 and 2 on
quadrilaterals, all with pressures that are linear on ever smaller cells; with displacements of
degree 1 they are linear on pairs of facets, which is stable. Left out are higher degrees of the
pressure: their sign is asked for at nodes, and an edge within an element spoils them.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...fem.contact_meshes import TRIANGLE_GROWTH, even_half_space
from ...fem.elasticity import AxisymmetricElasticity
from ...fem.far_field import enough_poles
from ...fem.half_space import HalfSpace, pressure_space
from ...mdr import energy, ring_kernel
from ...meshes import bisection
from ...meshes.contact_cells import ContactCells
from ...meshes.sizes import SizeField
from ..methods.base import Discretised
from ..methods.spaces import first_contact
from ..numerics.subdivision import subdivided
from ..problem.problem import Problem
from ..progress import Stages
from . import theories
from .way import Way

FINER, QUICK_FINER = (0.25, 0.5, 1.0, 2.0), (0.125, 0.25, 0.5)
"""How many times as many cells as rtol 1e-4 asks for, from coarse to fine."""
CELLS = "size of cells over that of rtol 1e-4"
ON_PRESSURES, ON_TRIANGLES, ON_QUADS = "cells", "cells, triangles", "cells, quadrilaterals"
"""Groups of ways, each drawn in a figure of its own."""
REACH, NEGLIGIBLE = 5.0, 1e-10
"""Truncation of quadrilaterals, and the energy that the poles beyond may leave out."""


def ways_of_cells(problem: Problem, quick: bool) -> Iterator[Way]:
    """Yield every way to refine the cells of a face, from coarse to fine."""
    sizes = {finer: 1 / finer for finer in (QUICK_FINER if quick else FINER)}

    def way(
        name: str, group: str, method: str, seconds: float, degree: int = 0, quads: bool = False
    ) -> Way:
        def discretise(setting: float, stages: Stages) -> Discretised:
            cells = first_contact(problem, setting)[1]
            with stages("condensing"):
                if method == "fem":
                    return elements_on(problem, cells, setting, degree, quads)
                kernel = ring_kernel if method == "bem" else energy
                compliance = kernel.compliance(cells.space())
                return Discretised(compliance, lambda: compliance)

        def work(setting: float) -> float:
            return seconds * (0.2 + setting**2)

        return Way(name, name, group, method, sizes, discretise, theories.of_cells, CELLS, work)

    yield way("MDR", ON_PRESSURES, "mdr", 3.0)
    yield way("BEM", ON_PRESSURES, "bem", 3.0)
    for degree in (1, 2, 3, 4):
        yield way(f"FEM P{degree}", ON_TRIANGLES, "fem", 3.0 + degree, degree=degree, quads=False)
    for degree in (1, 2):
        yield way(f"FEM Q{degree}", ON_QUADS, "fem", 4.0 + degree, degree=degree, quads=True)


def elements_on(
    problem: Problem, cells: ContactCells, finer: float, degree: int, quads: bool
) -> Discretised:
    """Return finite elements whose facets on the contact are no larger than cells, condensed.

    A triangle becomes three quadrilaterals, and a facet of it two: their triangles are those of
    cells twice as large.
    """
    if not quads:
        half_space = even_half_space(cells, problem.poisson_ratio, degree=degree)
    else:
        larger = first_contact(problem, finer / 2)[1]
        edges, size = larger.ring_edges, larger.edge_size
        field = SizeField(edges, size, size, TRIANGLE_GROWTH, REACH, larger.largest, 0.125, larger)
        mesh = subdivided(
            bisection.mesh(field), 1, np.array(edges), into_quads=True, log_polar=False
        )
        solid = AxisymmetricElasticity(mesh, degree, problem.poisson_ratio)
        space = pressure_space(solid, np.array(edges), larger.hollow)
        linear = replace(space, degrees=np.minimum(space.degrees, 1))
        half_space = HalfSpace(solid, linear, enough_poles(REACH, NEGLIGIBLE))
    if degree == 1:
        # broken at ring edges, there are more linear pressures on facets than contact nodes
        half_space = replace(half_space, space=half_space.space.coarser())
    compliance = half_space.compliance()
    return Discretised(compliance, lambda: compliance, half_space.unknowns, half_space=half_space)
