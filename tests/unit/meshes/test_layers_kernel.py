"""The kernel of layered ground against another derivation, limits and published stiffnesses."""

from dataclasses import replace

import numpy as np
import pytest
from layered_disc import Layer, surface_displacements

from ringwear import Ground
from ringwear.meshes.ground.ground import relative_compliance
from ringwear.meshes.ground.line_energy import line_energy, relative_stiffness

WAVE_NUMBERS = np.geomspace(1e-4, 40, 60)


@pytest.mark.parametrize(
    "ground",
    [
        Ground((0.5,), (0.35, 3.5), (0.3, 0.25)),
        Ground((0.1,), (0.35, 35.0), (0.3, 0.2)),
        Ground((2.0,), (0.35, 3.5e-3), (0.3, 0.2)),
        Ground((0.2, 0.05, 0.6), (0.255, 5.0, 0.05, np.inf), (0.49, 0.2, 0.3, 0.0)),
        Ground((0.3, 1.0), (0.25, 2.5, 0.025), (0.5, 0.5, 0.0)),
    ],
    ids=["one layer", "a soft one", "a hard one", "three on a rigid base", "two, incompressible"],
)
def test_several_layers_by_displacement_potentials(ground):
    """The kernel is that of another derivation, one linear system for all layers."""
    at, thicknesses = WAVE_NUMBERS[10::7], [*ground.thicknesses, np.inf]
    solids = zip(thicknesses, ground.shear_moduli, ground.poisson_ratios, strict=True)
    layers = [Layer(h, 2 * shear * (1 + nu), nu) for h, shear, nu in solids if shear < np.inf]
    unit = ground.shear_moduli[0] / (1 - ground.poisson_ratios[0])
    exact = unit * at * surface_displacements(layers, at)
    assert relative_compliance(ground, at) == pytest.approx(exact, rel=2e-12)


def test_a_layer_that_is_split_stays_the_same():
    whole = Ground((0.6,), (0.35, 7.0), (0.3, 0.2))
    split = Ground((0.1, 0.2, 0.3), (0.35, 0.35, 0.35, 7.0), (0.3, 0.3, 0.3, 0.2))
    exact = relative_compliance(whole, WAVE_NUMBERS)
    assert relative_compliance(split, WAVE_NUMBERS) == pytest.approx(exact, rel=1e-12)


def test_thick_and_thin_layers():
    """Phi is one for waves shorter than the layer, and the substrate's for far longer ones."""
    ground = Ground((0.5,), (0.35, 3.5), (0.3, 0.1))
    assert relative_compliance(ground, np.array([60.0])) == pytest.approx(1.0, abs=1e-12)
    of_substrate = (0.9 / 3.5) / (0.7 / 0.35)
    assert relative_compliance(ground, np.array([1e-6])) == pytest.approx(of_substrate, rel=1e-5)
    # on a layer of thickness 50 a and 100 a, the effect of the substrate falls as a / h
    far = [relative_stiffness(replace(ground, thicknesses=(depth,))) - 1 for depth in (50.0, 100.0)]
    assert far[0] / far[1] == pytest.approx(2.0, rel=0.05)
    assert abs(far[1]) < 0.01


def test_a_thin_compressible_layer_is_a_foundation_of_springs():
    """Winkler's limit for thin layers: u = p h / (K + 4 G / 3) at each point of the face."""
    shear, nu = 0.35, 0.3
    off = []
    for thickness in (0.08, 0.04):
        ground = Ground((thickness,), (shear, np.inf), (nu, 0.0))
        springs = np.pi / 2 * 2 * shear * (1 - nu) / (1 - 2 * nu) / thickness
        off.append(relative_stiffness(ground) / springs - 1)
    assert off[1] == pytest.approx(off[0] / 2, rel=0.02)
    assert abs(off[1]) < 0.012


def test_the_energy_is_positive_definite():
    for contrast in (1e-3, 1e3):
        ground = Ground((0.2,), (0.35, 0.35 * contrast), (0.3, 0.3))
        assert np.linalg.eigvalsh(line_energy(ground))[0] > 0


def test_layers_by_depth():
    ground = Ground((0.2, 0.3), (0.35, 1.0, np.inf), (0.3, 0.4, 0.0))
    assert ground.layer_at(np.array([0.1, 0.3, 0.7])).tolist() == [0, 1, 2]
    assert ground.greatest_poisson_ratio == 0.4
    assert ground.in_units_of(0.5).thicknesses == (0.4, 0.6)
    assert ground.with_poisson_ratios_below(0.35).poisson_ratios == (0.3, 0.35, 0.0)
