"""Displacements and stresses under a uniform pressure on elastic layers, by Hankel's transform.

The derivation and the formulas are independent of those of ringwear's methods. In each layer, with
the depth z below its top, the potentials of Papkovich and Neuber are

    2 G u = grad(phi + z psi) - 4 (1 - nu) psi e_z,

where the harmonic phi and psi are sums of ``exp(-s z)`` and ``exp(-s (h - z))`` times ``J_0(s r)``.
For each wave number s one system of linear equations determines the amplitudes in all layers: the
pressure acts on the surface, displacements and tractions are continuous at interfaces, and
displacements are zero on a rigid base. The pressure 1 on ``r < 1`` is ``int J_1(s) J_0(s r) ds``.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.special import j0, j1


class Layer(NamedTuple):
    """Describe an elastic layer; one with an infinite thickness is a half-space."""

    thickness: float
    youngs_modulus: float
    poisson_ratio: float


def fields_under_uniform_pressure(layers, number, r, z):
    """Return displacements (n, 2) and stresses (n, 4: rr, zz, rz, hoop) in one of the layers.

    Parameters
    ----------
    layers : from the surface down; below the last one is a rigid base, unless it is a half-space
    number : of the layer that contains the points, which matters at an interface
    r, z : (n,) radii and depths; at the surface, the centre alone
    """
    layer, top = layers[number], sum(each.thickness for each in layers[:number])
    modulus, nu = layer.youngs_modulus, layer.poisson_ratio
    surface = z.min() == 0
    # reflected waves decay over the first layer's thickness
    least_depth = layers[0].thickness if surface else z.min()
    s, lengths = wave_numbers(layers[0].thickness, 1 + r.max(), least_depth)
    amplitudes = _amplitudes(layers, s)[:, None, 4 * number : 4 * number + 4]
    if surface:
        # integrals converge slowly there: a half-space is subtracted, and added in closed form
        # (Johnson, Contact Mechanics, 1985, section 3.4)
        amplitudes[:, 0, :2] -= np.stack([(1 - 2 * nu) / s**2, -1 / s], axis=1)
    displacement, stress = [], []
    for radius, depth in zip(r, z, strict=True):
        waves = (_states(layer, s, depth - top) * amplitudes).sum(axis=2).T * lengths * j1(s)
        bessel0, bessel1 = j0(s * radius), j1(s * radius)
        hoop = waves[0] @ (bessel1 / radius if radius else s / 2)
        u_r, u_z = waves[0] @ bessel1, waves[1] @ bessel0
        radial, zz = waves[0] @ (s * bessel0) - hoop, waves[3] @ bessel0
        if surface:
            u_z, zz = u_z + 2 * (1 - nu**2) / modulus, zz - 1
            strain = (nu - (1 - nu) * (1 + 2 * nu) / 2) / modulus
            radial, hoop = radial + strain, hoop + strain
        plane, pressed = modulus / (1 - nu**2), nu / (1 - nu) * zz
        displacement.append([u_r, u_z])
        rr, tt = plane * (radial + nu * hoop) + pressed, plane * (hoop + nu * radial) + pressed
        stress.append([rr, zz, waves[2] @ bessel1, tt])
    return np.array(displacement), np.array(stress)


def _states(layer, s, depth):
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
    # 2 G
    states[:, :2] /= layer.youngs_modulus / (1 + nu)
    return states


def _amplitudes(layers, s):
    """Return the amplitudes (k, m) of all potentials under the pressure ``J_0(s r)``."""
    base = layers[-1].thickness
    size = 4 * len(layers) - 2 * np.isinf(base)
    system, load = np.zeros((len(s), size, size)), np.zeros((len(s), size, 1))
    system[:, :2, :4] = _states(layers[0], s, 0.0)[:, 2:]
    load[:, 1] = -1.0
    for number, (above, below) in enumerate(pairwise(layers)):
        column = 4 * number
        rows = slice(column + 2, column + 6)
        system[:, rows, column : column + 4] = _states(above, s, above.thickness)
        system[:, rows, column + 4 : column + 8] = -_states(below, s, 0.0)
    if np.isfinite(base):
        system[:, -2:, -4:] = _states(layers[-1], s, base)[:, :2]
    # rows and columns are scaled, because displacements, tractions and potentials differ in size
    rows_scale = np.abs(system).max(axis=2, keepdims=True)
    columns_scale = np.abs(system / rows_scale).max(axis=1, keepdims=True)
    scaled = np.linalg.solve(system / rows_scale / columns_scale, load / rows_scale)
    return scaled[..., 0] / columns_scale[:, 0]


def surface_displacements(layers, s):
    """Return the displacements u_z (k,) of the surface under the pressures ``J_0(s r)``."""
    states = _states(layers[0], s, 0.0)[:, 1]
    return (states * _amplitudes(layers, s)[:, : states.shape[1]]).sum(axis=1)


def wave_numbers(thickness, reach, least_depth=None):
    """Return Gauss points and weights in the wave number.

    They end where a layer is unnoticeable at its surface, or where waves do not reach a depth.

    Parameters
    ----------
    thickness : of the layer
    reach : largest frequency of the integrand
    least_depth : the least depth of waves; the default is that of reflected ones, twice the
        thickness
    """
    end = 36 / (least_depth or 2 * thickness)
    edges = np.linspace(0, end, int(np.ceil(end * reach / 10)) + 1)
    edges = np.concatenate([[0.0], edges[1] * 0.5 ** np.arange(12, 0, -1), edges[1:]])
    return gauss(edges, 16)


def gauss(edges, count):
    """Return Gauss points and weights on the panels between edges."""
    node, weight = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()
