"""Observed orders of convergence agree with the theory of the studies, and errors have caps."""

import numpy as np
import pandas as pd
import pytest

from ringwear import Ground, Scene
from ringwear.studies.convergence.flat_start import (
    FACTOR_PER_DEGREE,
    GRADINGS,
    QUAD_DEGREES,
    RIM_SIZE,
    RING_EDGE_SIZE,
    convergence_rates,
    discretise_by_mdr,
    discretise_by_quads,
    ring_quantities,
)
from ringwear.studies.numerics.core import FLAT, flat_d0_error
from ringwear.studies.numerics.layered_truncation import move_outwards_on_layers
from ringwear.studies.numerics.truncation import move_outwards
from ringwear.studies.study.levels import Theory
from ringwear.studies.study.orders import ORDER_TOLERANCE, Sequence, sequences_of


def assert_order(fitted, cap):
    """Assert the order by least squares and between the last levels, as in the studies."""
    assert fitted.order == pytest.approx(fitted.theory.order, abs=ORDER_TOLERANCE)
    assert fitted.last_order == pytest.approx(fitted.theory.order, abs=ORDER_TOLERANCE)
    assert fitted.errors[-1] <= cap


def d0_error(discretised):
    """Return the relative error of the indentation of the flat start."""
    return flat_d0_error(discretised[0])


@pytest.mark.parametrize(("degree", "cap"), [(1, 2e-8), (2, 2e-12), (3, 5e-11), (4, 2e-13)])
def test_indentation_by_mdr_on_meshes_graded_to_the_rim(degree, cap):
    """The orders are 2 degree + 3; with degree 4, the order approaches 11 until roundoff."""
    sizes = convergence_rates(GRADINGS[degree])
    errors = [d0_error(discretise_by_mdr(FLAT, RIM_SIZE, degree, grading)) for grading in sizes]
    theory = Theory(2 * degree + 3)
    fitted = Sequence("", "", theory, np.array(list(sizes.values())), np.array(errors))
    assert min(errors) > 0
    if degree < 4:
        assert_order(fitted, cap)
    else:
        orders = fitted.orders
        assert 10.5 < orders[0] < orders[1] < orders[2] < 11
        assert errors[-1] <= cap


def assert_factor(errors, cap):
    """Assert exponential convergence with the degree.

    Two more degrees reduce the error by 20 or more. The mean reduction per degree is at least 0.7
    times that of the theory, which assumes the same degree everywhere.
    """
    assert (errors[:-2] / errors[2:]).min() >= 20
    assert (errors[0] / errors[-1]) ** (1 / (len(errors) - 1)) >= 0.7 * FACTOR_PER_DEGREE
    assert errors[-1] <= cap


@pytest.mark.gmsh
@pytest.mark.parametrize(("ratio", "cap"), [(0.0, 3e-12), (0.3, 3e-12), (0.45, 5e-12)])
def test_indentation_on_quadrilaterals_by_the_degree(ratio, cap):
    errors = [
        d0_error(discretise_by_quads(FLAT, 0.0, ratio, degree))
        for degree in QUAD_DEGREES
        if degree > 4
    ]
    # finite elements are always too stiff
    assert max(errors) < 0
    assert_factor(np.abs(errors), cap)


@pytest.mark.gmsh
def test_rings_on_quadrilaterals_by_the_degree():
    """Degrees 4 to 8 against MDR; the study continues up to roundoff."""
    problem = Scene.load("five_rings").problem
    edges = problem.ring_edges
    exact = ring_quantities(problem, discretise_by_mdr(edges, RING_EDGE_SIZE, 10, 0.15)[0])
    degrees = [
        ring_quantities(problem, discretise_by_quads(edges, RING_EDGE_SIZE, 0.3, degree)[0])
        for degree in range(4, 9)
    ]
    for name in ("d(1)", "slowest relaxation time"):
        assert_factor(np.array([abs(values[name] / exact[name] - 1) for values in degrees]), 2e-9)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.5])
def test_truncation_by_every_far_field(ratio):
    """Far fields at R = 4 a to 7 a against six poles on the same mesh."""
    family = move_outwards((4, 5, 6, 7), ratio)
    rows = [
        {"family": family.name, "size": size} | family.solve(outer)
        for outer, size in family.sizes.items()
    ]
    fitted = {
        sequence.quantity: sequence for sequence in sequences_of([family], pd.DataFrame(rows))
    }
    caps = {"fixed": 0.3, "1 pole": 7e-5, "2 poles": 3e-8, "3 poles": 2e-11}
    for far_field, cap in caps.items():
        assert_order(fitted.pop(far_field), cap)
    assert not fitted


@pytest.mark.gmsh
def test_truncation_on_layers():
    """Stiffness against the theory; far from the layers, loads have the orders of poles."""
    film = Scene.load("hard_film").problem.ground
    family = move_outwards_on_layers((2.5, 4.0, 8.0, 16.0), film)
    rows = {outer: family.solve(outer) for outer in family.sizes}
    first, *_, last = (pd.Series(row) for row in rows.values())
    assert abs(first["1 load"] / last["1 load"]) > (16 / 2.5) ** 4.5
    assert 0.9 < np.log(rows[8.0]["fixed"] / rows[16.0]["fixed"]) / np.log(2) < 1
    assert abs(first["2 loads"]) < 1e-7
    assert max(abs(row["4 loads"]) for row in rows.values()) < 1e-9
    # a clamped boundary causes no error on a rigid base
    pad = Scene.load("polishing_pad").problem.ground
    assert abs(move_outwards_on_layers((4.0,), pad).solve(4.0)["fixed"]) < 1e-9
    # incompressible layers are extrapolated for each far field
    rubber = Ground.from_youngs_moduli([0.2], [1.0, np.inf], [0.5, 0.0])
    assert abs(move_outwards_on_layers((4.0,), rubber).solve(4.0)["fixed"]) < 5e-8
