"""Observed orders, each with an absolute cap: in the radial mesh and in time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.linalg import expm
from skfem import MeshTri

from ringwear import PressureSpace, SceneError, alternating_edges, press_flat
from ringwear.mdr.energy import compliance
from ringwear.mdr.uniform_grid import UniformGrid
from ringwear.studies.convergence.measures import PRESSURE_PART
from ringwear.studies.convergence.study import explain_d0_orders
from ringwear.studies.study.levels import Theory
from ringwear.studies.study.orders import Sequence
from ringwear.studies.study.own_mesh import named_meshes


def order(sizes, errors):
    """Return the order between the two finest levels."""
    return float(np.log(errors[-2] / errors[-1]) / np.log(sizes[-2] / sizes[-1]))


@pytest.mark.parametrize(("exponent", "cap"), [(1, 2e-3), (3, 2e-6)])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_indentation_by_graded_radii(degree, exponent, cap):
    """Radii ``1 - (1 - i/n)^m`` make the energy converge as ``n^-m``, from above.

    The reason is the root singularity of the pressure at the rim.
    """
    counts, errors = np.array([8, 16, 32]), []
    for count in counts:
        radii = 1 - (1 - np.arange(count + 1) / count) ** exponent
        space = PressureSpace(radii, np.full(count, degree), np.array([0.0, 1.0]))
        errors.append(press_flat(compliance(space)).indentation / 0.5 - 1)
    assert min(errors) > 0
    assert order(1 / counts, errors) == pytest.approx(exponent, abs=0.05)
    assert errors[-1] <= cap


def paper_grid(count):
    return UniformGrid(alternating_edges(5), np.array([0.1, 1, 0.1, 1, 0.1]), count)


def test_the_papers_march_is_first_order_in_time():
    """Errors in time against the exact solution on the same grid, by a matrix exponential."""
    grid, time = paper_grid(40), 1.0
    count = len(grid.radii)
    # df/dt = M f + c as one homogeneous system
    system = np.zeros((count + 1, count + 1))
    system[:-1, :-1] = grid.rate_matrix()
    system[:-1, -1] = grid.coefficients * grid.contact(np.zeros(count))[0]
    profile = expm(system * time)[:-1, -1]
    steps = grid.stability_limit() * np.array([0.4, 0.2, 0.1])
    marched = [grid.march(np.array([time]), step) for step in steps]
    heights = [abs(indentation[0] - grid.contact(profile)[1]) for *_, indentation in marched]
    profiles = [np.abs(worn[0] - profile).max() for _, worn, _ in marched]
    for errors, cap in ((heights, 1e-5), (profiles, 1e-4)):
        assert order(steps, errors) == pytest.approx(1, abs=0.05)
        assert errors[-1] <= cap


@pytest.mark.parametrize("count", [50, 100, 200])
def test_the_papers_march_blows_up_above_its_limit_only(count):
    """The limit is twice the shortest relaxation time of the grid, that of a wave of two cells."""
    grid = paper_grid(count)
    rates = np.linalg.eigvals(grid.rate_matrix())
    limit = 2 / np.abs(rates).max()
    assert rates.real.max() <= 1e-6
    assert limit == pytest.approx(grid.stability_limit(), rel=0.1)
    until = np.array([1000 * limit])
    pressures, *_ = grid.march(until, 0.95 * limit)
    assert 0 < pressures.min() < pressures.max() < 1
    with pytest.raises(SceneError, match=r"wear\.step"):
        grid.march(until, 1.05 * limit)


def test_the_papers_grid_is_first_order(reference):
    """The error at t = 0.1, when slopes at ring edges are steep, against the stored reference."""
    (state,) = [state for state in reference["states"] if state["time"] == 0.1]
    edges, wear = (np.array(reference[name]) for name in ("ring_edges", "wear_coefficients"))
    counts, errors = np.array([50, 100, 200]), []
    for count in counts:
        grid = UniformGrid(edges, wear / 10, count)
        _, profile, indentation = grid.march(np.array([1.0]), 0.5 * grid.stability_limit())
        errors.append(abs(2 * (indentation[0] - profile[0, 0]) / state["displacement_centre"] - 1))
    assert order(1 / counts, errors) >= 0.7
    assert errors[-1] <= 5e-3


def test_parts_of_opposite_signs_explain_an_order_that_differs():
    """Errors 0.01 h of pressures and -0.012 h^0.9 of displacements have a sum of lower order."""
    sizes = np.array([1.0, 0.5, 0.25])
    pressures, whole = 0.01 * sizes, 0.01 * sizes - 0.012 * sizes**0.9
    rows = {"family": "Q2", "size": sizes, "d0": whole, PRESSURE_PART: pressures}
    sequence = Sequence("Q2", "d0", Theory(1.0), sizes, whole)
    assert sequence.verdict == "no"
    (sentence,) = explain_d0_orders([sequence], pd.DataFrame(rows))
    assert "+2.5e-03 due to the pressures (order 1.00)" in sentence
    assert "-3.4e-03 due to the displacements (order 0.90)" in sentence


def test_meshes_of_one_name_in_two_folders_have_numbers():
    mesh = MeshTri()
    names = list(named_meshes(["a/x.msh", "b/x.msh", Path("y.msh"), mesh]))
    assert names == ["a/x.msh (1)", "b/x.msh (2)", "y.msh", "mesh 4"]
