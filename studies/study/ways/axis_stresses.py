"""Compute stresses on the axis of the half-space by finite elements and by Boussinesq's solution.

A point force Q on the surface at the distance s from the axis causes, at the depth z on the axis,
the stresses

    sigma_zz = -3 Q z^3 / (2 pi R^5),
    sigma_rr = sigma_hoop = Q ((1 - 2 nu) z / R^3 - 3 s^2 z / R^5) / (4 pi),   R^2 = s^2 + z^2,

averaged over the circle of all points at that distance (Johnson, Contact Mechanics, 1985, section
3.2). The integral of these stresses over the contact pressures is the exact solution with which
finite elements are compared; it needs no mesh of the half-space. All quantities are
non-dimensional.
"""

import numpy as np

from ....fem import HalfSpace, stresses_in
from ....meshes import Array, PressureSpace, gauss

DEPTHS = np.array([0.3, 0.7, 1.3, 2.1])
"""Depths on the axis at which stresses are compared, in punch radii.

They are chosen so that no depth is a vertex of a mesh.
"""
POINTS = 24
"""Number of Gauss points on each element; the largest elements are wider than the least depth."""


def boussinesq_stresses(space: PressureSpace, pressures: Array, poisson_ratio: float) -> Array:
    """Return the exact stresses zz and rr (states, depths, 2) due to pressures (states, size)."""
    local, weights = gauss(POINTS)
    half = space.widths[:, None] / 2
    radii = space.breakpoints[:-1, None] + half * (1 + local)
    areas = (2 * np.pi * radii * half * weights).ravel()
    forces = (space.on_elements(local) @ pressures.T).T * areas
    s, z = radii.ravel()[:, None], DEPTHS
    distance = np.hypot(s, z)
    axial = -3 * z**3 / (2 * np.pi * distance**5)
    radial = (1 - 2 * poisson_ratio) * z / distance**3 - 3 * s**2 * z / distance**5
    return np.stack([forces @ axial, forces @ radial / (4 * np.pi)], axis=-1)


def element_stresses(half_space: HalfSpace, pressures: Array) -> Array:
    """Return the stresses zz and rr (states, depths, 2) of finite elements due to pressures.

    Raises
    ------
    SolverError
        if the stiffness of the half-space is singular
    """
    solid, mesh = half_space.solid, half_space.solid.mesh
    reference, facets = solid.element.refdom, mesh.boundaries["axis"]
    coefficients = half_space.displacements(pressures)
    depths = np.sort(mesh.p[1, mesh.facets[:, facets]], axis=0)
    stress_of_depths = []
    for depth in DEPTHS:
        facet = facets[np.flatnonzero((depths[0] <= depth) & (depth <= depths[1]))[0]]
        element = mesh.f2t[:1, facet]
        # sides of triangles and quadrilaterals are straight, so that the depth is linear along them
        ends = np.array(reference.facets)[(mesh.t2f[:, element[0]] == facet).argmax()]
        first, second = mesh.p[1, mesh.t[ends, element[0]]]
        start, end = reference.p[:, ends].T
        point = start + (depth - first) / (second - first) * (end - start)
        _, stress = stresses_in(solid, coefficients, element, point[:, None])
        stress_of_depths.append(stress[:, 0, 0, [1, 0]])
    return np.stack(stress_of_depths, axis=1)
