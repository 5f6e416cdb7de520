"""Orders of convergence of all quantities of a scene, and the stresses on the axis."""

import numpy as np
import pytest

from ringwear import PressureSpace, Scene, Stages, energy, press_flat
from ringwear.meshes.radial import graded_breakpoints
from ringwear.studies.convergence.axis_stresses import DEPTHS, boussinesq_stresses, element_stresses
from ringwear.studies.convergence.runs import StudiedScene
from ringwear.studies.convergence.scene_ways import (
    graded_way,
    radial_graded_way,
    radial_uniform_way,
    uniform_way,
)
from ringwear.studies.study.levels import Record
from ringwear.studies.study.orders import sequences_of


@pytest.fixture(scope="module")
def five_rings():
    return StudiedScene.of(Scene.load("five_rings"), {}, 1.0)


def orders(studied, way):
    """Return the order between the last levels, and the finest error, of each quantity."""
    family = studied.family(way)
    table = Record().solve("levels", [family], ["family", "setting", "size", *family.theory])
    return {
        sequence.quantity: (sequence.last_order, sequence.errors[-1])
        for sequence in sequences_of([family], table)
    }


@pytest.mark.parametrize(("quads", "counts"), [(False, (4, 6)), (True, (1, 2))])
def test_elements_of_degree_one_have_the_order_two_in_every_energy(five_rings, quads, counts):
    by_quantity = orders(five_rings, graded_way(five_rings.problem, 1, quads, counts))
    for quantity in ("d0", "d(t)", "relaxation time"):
        order, finest = by_quantity[quantity]
        assert order == pytest.approx(2, abs=0.15), quantity
        assert finest < 0.01


@pytest.mark.gmsh
def test_elements_of_degree_two_have_the_order_four_in_every_energy(five_rings):
    by_quantity = orders(five_rings, graded_way(five_rings.problem, 2, False, (2, 3)))
    for quantity in ("d0", "d(t)", "relaxation time"):
        order, finest = by_quantity[quantity]
        assert order == pytest.approx(4, abs=0.25), quantity
        assert finest < 1e-4


def test_cells_of_one_size_have_the_orders_of_the_singular_rim(five_rings):
    for method, degree in (("mdr", 1), ("mdr", 2), ("bem", 1)):
        by_quantity = orders(
            five_rings, radial_uniform_way(five_rings.problem, method, degree, (16, 32))
        )
        assert by_quantity["d0"][0] == pytest.approx(1, abs=0.02)
        assert by_quantity["pressure at start"][0] == pytest.approx(0.5, abs=0.02)


def test_quadrilaterals_of_one_size_have_the_order_of_the_rim(five_rings):
    by_quantity = orders(five_rings, uniform_way(five_rings.problem, 1, True, (1, 2)))
    assert by_quantity["d0"][0] == pytest.approx(1, abs=0.15)
    assert by_quantity["pressure at start"][0] == pytest.approx(0.5, abs=0.15)


def test_pressures_of_mdr_have_the_order_of_their_mean_square(five_rings):
    """With degree 2, pressures have the order 3, and the history the order 6."""
    by_quantity = orders(five_rings, radial_graded_way(five_rings.problem, "mdr", 2, (0.5, 0.6)))
    assert by_quantity["pressure"][0] == pytest.approx(3, abs=0.2)
    assert by_quantity["d(t)"][0] == pytest.approx(6, abs=0.3)


def flat_punch_on_axis(poisson_ratio):
    """Return stresses zz and rr on the axis under a flat punch of force 1 (Sneddon 1946)."""
    below = 1 + DEPTHS**2
    axial = -(1 + 3 * DEPTHS**2) / below**2 / (2 * np.pi)
    # rr = half of rr + hoop, by Hankel integrals of sin(s) exp(-s z) and s z sin(s) exp(-s z)
    plane = -(1 + 2 * poisson_ratio) / below + 2 * DEPTHS**2 / below**2
    return np.stack([axial, plane / (4 * np.pi)], axis=-1)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.5])
def test_stresses_on_the_axis_are_those_of_the_flat_punch(ratio):
    breakpoints = graded_breakpoints(np.array([0.0, 1.0]), 1e-13, 1e-13, 0.3)
    space = PressureSpace(breakpoints, np.full(len(breakpoints) - 1, 5), np.array([0.0, 1.0]))
    pressed = press_flat(energy.compliance(space))
    stresses = boussinesq_stresses(space, pressed.pressure[None], ratio)[0]
    np.testing.assert_allclose(stresses, flat_punch_on_axis(ratio), atol=1e-6)


def test_stresses_of_elements_on_the_axis_converge_to_them():
    studied = StudiedScene.of(Scene.load("flat_punch"), {}, 1.0)
    way = graded_way(studied.problem, 4, False, (1,))
    discretisation = way.discretise(1, Stages("fem"))
    pressed = press_flat(discretisation.compliance)
    stresses = element_stresses(discretisation.half_space, pressed.pressure[None])[0]
    np.testing.assert_allclose(stresses, flat_punch_on_axis(0.3), atol=2e-3 / np.pi)
