"""A check in three dimensions: boundary elements on a square grid, by the library tamaas (``ringwear[bem3d]``).

No axial symmetry and nothing of ringwear but the geometry goes in: Boussinesq's kernel integrated over square cells and
convolved by FFT without periodicity, the pressure found by conjugate gradients under ``p >= 0``. The disc and its rings
are staircases of cells, so every error is first order in the cell, and not smooth in it. Natural units, force 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from ringwear.mdr import direct
from ringwear.meshes.errors import SceneError
from ringwear.meshes.radial import Array, ring_areas
from ringwear.studies.figures.run import D0
from ringwear.studies.paper.gradients import odd_and_even
from ringwear.studies.paper.running_in import RINGS, WEAR_RATIO
from ringwear.studies.progress import Report

GRIDS = (48, 64, 96, 128, 192, 256)  # enough to see the order through the staircase
SIDE = 2.0  # the punch touches the sides of the grid
OUTSIDE = -1e3  # height beyond the rim, out of reach
SUBCELLS = 8  # cells that a ring edge cuts are shared between the rings by this many points in each direction


@dataclass(frozen=True, eq=False)
class GridErrors:
    """Relative errors on one grid: indentation of the flat punch, and ring forces of the flat and the steady state.

    Ring forces are relative to the whole force, the worst ring counts.
    """

    cells: int
    indentation: float
    flat_forces: float
    steady_forces: float


def library() -> Any:
    """The module tamaas.

    Raises
    ------
    SceneError
        if it is not installed
    """
    try:
        tamaas = import_module("tamaas")
    except ImportError as error:
        raise SceneError(f"--bem3d needs the library tamaas ({error}); pip install 'ringwear[bem3d]'") from error
    tamaas.set_log_level(tamaas.LogLevel.error)
    return tamaas


def press(cells: int, heights: Array) -> tuple[Array, Array]:
    """Pressure and displacement (cells, cells) under a rigid surface of given heights, force 1."""
    tamaas = library()
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [SIDE, SIDE], [cells, cells])
    model.E, model.nu = 1.0, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tamaas.PolonskyKeerRey(model, heights, 1e-10)
    solver.setIntegralOperator("dcfft")
    solver.solve(1 / SIDE**2)
    pressure = np.array(model.traction)
    displacement = np.zeros_like(pressure)
    model.operators["dcfft"](pressure, displacement)
    return pressure, displacement


def grid_errors(cells: int) -> GridErrors:
    """Press the flat punch and the worn punch of the paper's example on a grid."""
    edges = np.linspace(0, 1, RINGS + 1)
    pressures = direct.steady_pressures(edges, odd_and_even(RINGS) @ [1.0, WEAR_RATIO])
    radius = _radius(cells)
    inside = radius < 1
    flat_pressure, flat_displacement = press(cells, np.where(inside, 0.0, OUTSIDE))
    worn = np.full(radius.shape, OUTSIDE)
    worn[inside] = -direct.limiting_profile(edges, pressures, radius[inside])
    steady_pressure, _ = press(cells, worn)
    # the flat punch carries F (1 - sqrt(1 - r^2)) within r (Eq. 11)
    flat = -np.diff(np.sqrt(1 - edges**2))
    return GridErrors(
        cells,
        float(abs(flat_displacement[inside].mean() / D0 - 1)),
        float(np.abs(_ring_forces(flat_pressure, edges) - flat).max()),
        float(np.abs(_ring_forces(steady_pressure, edges) - pressures * ring_areas(edges)).max()),
    )


def _radius(cells: int) -> Array:
    middle = ((np.arange(cells) + 0.5) / cells - 0.5) * SIDE
    return np.hypot(*np.meshgrid(middle, middle, indexing="ij"))


def _ring_forces(pressure: Array, edges: Array) -> Array:
    cells = len(pressure)
    ring = np.clip(np.searchsorted(edges, _radius(cells * SUBCELLS), side="right") - 1, 0, len(edges) - 2)
    fine = np.kron(pressure, np.full((SUBCELLS, SUBCELLS), (SIDE / cells / SUBCELLS) ** 2))
    return np.bincount(ring.ravel(), fine.ravel(), minlength=len(edges) - 1).astype(float)


def table(report: Report, grids: tuple[int, ...] = GRIDS) -> str:
    """The errors on all grids and their order in the cell, as a table in Markdown."""
    library()
    found = []
    for cells in grids:
        report(f"  bem3d  {cells} x {cells} cells ...")
        found.append(grid_errors(cells))
    names = ("indentation", "flat_forces", "steady_forces")
    values = np.array([[getattr(errors, name) for name in names] for errors in found])
    orders = -np.polyfit(np.log(grids), np.log(values), 1)[0]
    lines = [
        "# A check in three dimensions",
        "",
        "Five rings by boundary elements on a square grid over the square about the punch (tamaas), against closed forms.",
        "Relative errors; of ring forces the worst ring, over the whole force. The order is a fit over the grids.",
        "",
        "| cells | indentation of the flat punch | ring forces, flat | ring forces, worn to the steady state |",
        "|---|---|---|---|",
        *(
            f"| {cells} x {cells} | " + " | ".join(f"{v:.1e}" for v in row) + " |"
            for cells, row in zip(grids, values, strict=True)
        ),
        "| observed order | " + " | ".join(f"{order:.2f}" for order in orders) + " |",
    ]
    return "\n".join(lines) + "\n"
