"""Fields of loads on layers: continuous across interfaces, free at the surface, in equilibrium."""

import numpy as np
import pytest
from test_far_field import assert_elastic

from ringwear import Ground
from ringwear.fem.layered_far_field import independent_count, loaded_fields

OUTER = 2.5
GROUND = Ground((0.5, 0.4), (0.35, 3.0, 0.1), (0.3, 0.2, 0.45))


def at(radius, depth, ground=GROUND, count=3):
    points = np.stack(np.broadcast_arrays(np.asarray(radius, float), depth), axis=-1)
    return loaded_fields(np.atleast_2d(points), count, ground, OUTER)


def test_an_interface_between_equal_layers_changes_nothing():
    radii, depths = np.array([2.5, 1.5, 0.3]), np.array([0.1, 2.0, 2.6])
    fields = [
        at(radii, depths, Ground((thickness,), (0.35, 0.35), (0.3, 0.3)))
        for thickness in (0.2, 2.2)
    ]
    for first, second in zip(*fields, strict=True):
        assert second == pytest.approx(first, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("depth", [0.5, 0.9])
def test_fields_are_continuous_across_interfaces(depth):
    radii = np.array([1.5, 2.0, 2.4])
    (above, stress_above), (below, stress_below) = (
        at(radii, depth * (1 + sign * 1e-12)) for sign in (-1, 1)
    )
    assert above == pytest.approx(below, abs=1e-9)
    # zz and rz act across the interface
    assert stress_above[..., 1:3] == pytest.approx(stress_below[..., 1:3], abs=1e-9)
    assert np.abs(stress_above[..., 0] - stress_below[..., 0]).max() > 1e-4


def test_the_surface_beside_the_load_is_free():
    _, stress = at(np.array([2.0, 2.3, 2.5]), 0.0)
    assert np.abs(stress[..., 1:3]).max() < 1e-10


def test_a_rigid_base_does_not_move():
    rigid = Ground((0.5,), (0.35, np.inf), (0.3, 0.0))
    moved, _ = at(np.array([2.0, 2.4]), 0.5, rigid)
    assert np.abs(moved).max() < 1e-10


def test_equilibrium_and_hookes_law():
    """The place is below both interfaces."""
    below = GROUND.poisson_ratios[2], GROUND.shear_moduli[2]

    def fields(points):
        return loaded_fields(points, 3, GROUND, OUTER)

    assert_elastic(fields, np.array([[2.3, 1.4]]), *below)


def test_dependent_and_vanishing_fields_are_not_counted():
    alike = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-12]])
    assert independent_count(alike, 1.0) == 1
    assert independent_count(1e-20 * np.eye(3), 1.0) == 0
    assert independent_count(np.diag([1.0, 2.0, 0.5]), 1.0) == 3
