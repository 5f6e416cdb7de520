"""The flat annulus: published stiffnesses, convergence, and layers."""

import numpy as np
import pytest
from closed_forms import ANNULI

from ringwear import Ground, PressureSpace, RunningIn, energy, press_flat
from ringwear.mdr.annulus import flat_annulus
from ringwear.mdr.flat_punch import flat_punch_of


@pytest.mark.parametrize(("inner_radius", "stiffness"), ANNULI.items())
def test_the_flat_annulus_has_the_known_stiffness(inner_radius, stiffness):
    assert 1 / flat_annulus(inner_radius).indentation == pytest.approx(stiffness, abs=6e-10)


@pytest.mark.parametrize("inner_radius", [1e-9, 1e-4, 0.01, 0.1, 0.3, 0.6, 0.9, 0.99, 0.999999])
def test_the_flat_annulus_converges(inner_radius):
    fine, coarse = (flat_annulus(inner_radius, points) for points in (100, 64))
    assert coarse.indentation == pytest.approx(fine.indentation, rel=2e-14)
    edges = np.linspace(inner_radius, 1.0, 5)
    np.testing.assert_allclose(
        coarse.ring_forces(edges), fine.ring_forces(edges), rtol=0, atol=1e-13
    )
    assert coarse.ring_forces(edges).sum() == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("inner_radius", [0.2, 0.6, 0.95])
@pytest.mark.parametrize(
    "ground",
    [
        Ground.from_youngs_moduli([0.5], [1.0, 10.0], [0.3, 0.2]),
        Ground.from_youngs_moduli([0.1, 0.3], [1.0, 0.2, 4.0], [0.3, 0.45, 0.0]),
        Ground.from_youngs_moduli([0.05], [1.0, np.inf], [0.3, 0.3]),
    ],
)
def test_the_flat_annulus_on_layers(ground, inner_radius):
    """Nystroem's method with the Hankel integral of the kernel against the energy of the MDR."""
    annulus = flat_annulus(inner_radius, ground=ground)
    finer = flat_annulus(inner_radius, 2 * len(annulus.coefficients), ground)
    assert annulus.indentation == pytest.approx(finer.indentation, rel=1e-13)
    space = PressureSpace.graded([inner_radius, 1.0], 1e-12, 0.15, 8)
    space = space.no_wider(ground.first_thickness)
    compliance = energy.compliance(space, ground)
    radii = inner_radius + (1 - inner_radius) * np.linspace(0.1, 0.9, 9)
    # polynomials that know nothing of the annulus, and its own functions
    for pressed, within in (
        (press_flat(compliance), 2e-3),
        (RunningIn(compliance, np.ones(1)).flat, 1e-7),
    ):
        assert pressed.indentation == pytest.approx(annulus.indentation, rel=1e-9)
        assert pressed.pressure_at(radii) == pytest.approx(annulus.pressure_at(radii), rel=within)


def test_a_small_hole_on_layers_is_none():
    ground = Ground.from_youngs_moduli([0.3], [1.0, 5.0], [0.3, 0.2])
    hollow, full = (flat_punch_of(inner_radius, ground) for inner_radius in (1e-4, 0.0))
    assert hollow.indentation == pytest.approx(full.indentation, rel=1e-9)
