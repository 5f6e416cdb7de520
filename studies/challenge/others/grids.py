"""Solve the starts of the flat punch and the sphere (problems 1 and 7) by two other programs.

ContactMechanics and tamaas discretise the half-space by a square grid of points. Each problem is
solved on three grids.
"""

from time import perf_counter

import numpy as np
import tamaas as tm
from ContactMechanics import FreeFFTElasticHalfSpace, make_system
from SurfaceTopography import Topography


def contact_mechanics(heights, size, force):
    """Return the pressures and displacements that ContactMechanics computes at the grid points.

    The plane strain modulus and the punch radius are 1.

    Parameters
    ----------
    heights : (n, n) heights of the face
    size : side of the grid
    force : normal force

    Returns
    -------
    pressures, displacements : (n, n)
    """
    half_space = FreeFFTElasticHalfSpace(heights.shape, 1, (size, size))
    system = make_system(substrate=half_space, surface=Topography(-heights, (size, size)))
    system.minimize_proxy(external_force=force, pentol=1e-8)
    return system.force * heights.size / size**2, system.disp


def tamaas(heights, size, force):
    """Return the pressures and displacements that tamaas computes at the grid points.

    Arguments and results are those of `contact_mechanics`.
    """
    model_type = tm.model_type.basic_2d
    model = tm.ModelFactory.createModel(model_type, [size, size], heights.shape)
    model.E, model.nu = 1, 0
    tm.ModelFactory.registerNonPeriodic(model, "free")
    solver = tm.PolonskyKeerRey(model, -heights, 1e-10)
    solver.setIntegralOperator("free")
    solver.solve(force / size**2)
    model.operators["free"](model.traction, model.displacement)
    return model.traction, model.displacement


for points in 64, 128, 256:
    for problem, size, force in ("01", 2, 2), ("07", 0.5, 0.01):
        x = ((np.arange(points) + 0.5) / points - 0.5) * size
        radii = np.hypot(*np.meshgrid(x, x))
        heights = (radii > 1) * 1e3 if problem == "01" else radii**2 / 2
        # the half of the middle row that begins at the axis
        half_row = points // 2, slice(points // 2, points)
        for solve in contact_mechanics, tamaas:
            start = perf_counter()
            pressure, displacement = (values[half_row] for values in solve(heights, size, force))
            head = (
                f"# {perf_counter() - start:.2f} s\ntime,radius,pressure,displacement,indentation"
            )
            depth = displacement[0] + heights[half_row][0]
            rows = np.broadcast_arrays(0, radii[half_row], pressure, displacement, depth)
            name = f"{problem}_{solve.__name__}_{points:03}.csv"
            np.savetxt(name, np.transpose(rows), "%.6g", ",", header=head, comments="")
