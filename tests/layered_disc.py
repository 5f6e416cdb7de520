"""Displacements and stresses on the axis under a uniform pressure on layers, by Hankel's transform.

The derivation and the formulas are independent of those of ringwear's methods. In each layer, with
the depth z below its top,

    2 G u = grad(phi + z psi) - 4 (1 - nu) psi e_z,

where the harmonic potentials phi and psi are sums of ``exp(-s z)`` and ``exp(-s (h - z))`` times
``J_0(s r)``. For each wave number s one system of linear equations determines the amplitudes in all
layers: the pressure acts on the surface, and displacements and tractions are continuous at
interfaces. The pressure 1 on ``r < 1`` is ``int J_1(s) J_0(s r) ds``. Close to the surface the
integrals converge slowly, so the solution for a half-space of the first layer's material, in closed
form, is subtracted.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from independent_layer import gauss
from scipy.special import j1

NEGLIGIBLE_EXPONENT = 40.0
"""Exponent at which ``exp(-x)`` counts as zero."""
PANELS, HALVINGS, POINTS = 40, 16, 20
"""Number of equal panels of the quadrature in s; how often the first one is halved towards zero,
because long waves in a stiff layer depend strongly on s; and number of Gauss points on each."""


class Layer(NamedTuple):
    """Describe an elastic layer; the lowest one is a half-space and has an infinite thickness."""

    thickness: float
    youngs_modulus: float
    poisson_ratio: float

    @property
    def shear_modulus(self) -> float:
        """Shear modulus."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))


class OnAxis(NamedTuple):
    """Contain the fields at a point on the axis."""

    displacement: float
    stress_zz: float
    stress_rr: float


def fields_on_axis(layers: Sequence[Layer], layer: int, depth: float) -> OnAxis:
    """Return the fields at a depth on the axis under the pressure 1 on the disc of radius 1.

    Parameters
    ----------
    layers : from the surface down; the last one is a half-space
    layer : index of the layer that contains the point, which matters at an interface
    depth : below the surface, in radii of the disc

    Returns
    -------
    fields : displacement into the ground, and stresses, positive in tension
    """
    # all waves that the first layer's lower side reflects decay as exp(-s h)
    even = np.linspace(0.0, NEGLIGIBLE_EXPONENT / layers[0].thickness, PANELS + 1)
    panels = np.concatenate([[0.0], even[1] * 0.5 ** np.arange(HALVINGS, 0, -1), even[1:]])
    s, weights = gauss(panels, POINTS)
    pressure = j1(s) * weights
    amplitudes = _amplitudes(layers, s)
    if layer == 0:
        amplitudes[:, :2] -= _half_space_amplitudes(layers[0].poisson_ratio, s)
    top = float(sum(each.thickness for each in layers[:layer]))
    here = layers[layer]
    states = _states(here, s, depth - top)
    columns = slice(4 * layer, 4 * layer + states.shape[2])
    u_r, u_z, _, s_zz = (states * amplitudes[:, None, columns]).sum(axis=2).T
    # the radial and the hoop strain are equal on the axis: J_1(s r) / r tends to s / 2
    displacement, stress, strain = u_z @ pressure, s_zz @ pressure, (u_r * s / 2) @ pressure
    if layer == 0:
        added = _under_disc_on_half_space(here, depth)
        displacement, stress, strain = np.array([displacement, stress, strain]) + added
    nu, modulus = here.poisson_ratio, here.youngs_modulus
    return OnAxis(displacement, stress, (modulus * strain + nu * stress) / (1 - nu))


def _states(layer: Layer, s: np.ndarray, depth: float) -> np.ndarray:
    """Return u_r, u_z, t_rz and s_zz (k, 4, 2 or 4) of each potential, at a depth below the top.

    The potentials are phi and psi that decay downwards and, unless the layer is a half-space, phi
    and psi that decay upwards.
    """
    nu, columns = layer.poisson_ratio, []
    waves = [(-s, np.exp(-s * depth))]
    if np.isfinite(layer.thickness):
        waves.append((s, np.exp(-s * (layer.thickness - depth))))
    for d, e in waves:
        columns.append([-s * e, d * e, -s * d * e, d**2 * e])
        columns.append(
            [
                -s * depth * e,
                (depth * d - (3 - 4 * nu)) * e,
                -s * (depth * d - (1 - 2 * nu)) * e,
                (depth * d**2 - 2 * (1 - nu) * d) * e,
            ]
        )
    states = np.moveaxis(np.array(columns), 2, 0).swapaxes(1, 2)
    states[:, :2] /= 2 * layer.shear_modulus
    return states


def _amplitudes(layers: Sequence[Layer], s: np.ndarray) -> np.ndarray:
    """Return the amplitudes (k, m) of all potentials under the pressure ``J_0(s r)``."""
    size = 4 * len(layers) - 2
    system, load = np.zeros((len(s), size, size)), np.zeros((len(s), size, 1))
    system[:, :2, :4] = _states(layers[0], s, 0.0)[:, 2:]
    load[:, 1] = -1.0
    for number, layer in enumerate(layers[:-1]):
        rows = slice(2 + 4 * number, 6 + 4 * number)
        below = _states(layers[number + 1], s, 0.0)
        start = 4 * number
        system[:, rows, start : start + 4] = _states(layer, s, layer.thickness)
        system[:, rows, start + 4 : start + 4 + below.shape[2]] = -below
    # rows and columns are scaled, because displacements, tractions and potentials differ in size
    rows_scale = np.abs(system).max(axis=2, keepdims=True)
    columns_scale = np.abs(system / rows_scale).max(axis=1, keepdims=True)
    scaled = np.linalg.solve(system / rows_scale / columns_scale, load / rows_scale)
    return scaled[..., 0] / columns_scale[:, 0]


def _half_space_amplitudes(poisson_ratio: float, s: np.ndarray) -> np.ndarray:
    """Return the amplitudes (k, 2) of phi and psi for a half-space without layers."""
    return np.stack([(1 - 2 * poisson_ratio) / s**2, -1 / s], axis=1)


def _under_disc_on_half_space(layer: Layer, depth: float) -> np.ndarray:
    """Return u_z, s_zz and the radial strain on the axis of a half-space of the layer's material.

    Notes
    -----
    The formulas are those of Johnson (Contact Mechanics, 1985, section 3.4) for the pressure 1 on
    the disc of radius 1.
    """
    nu, modulus, distance = layer.poisson_ratio, layer.youngs_modulus, np.hypot(1.0, depth)
    s_zz = (depth / distance) ** 3 - 1
    s_rr = -(1 + 2 * nu) / 2 + (1 + nu) * depth / distance - (depth / distance) ** 3 / 2
    u_z = (1 + nu) / modulus * (1 / distance + (1 - 2 * nu) * (distance - depth))
    return np.array([u_z, s_zz, ((1 - nu) * s_rr - nu * s_zz) / modulus])
