"""A flat punch on one layer bonded to a rigid base, by formulas that ringwear does not use.

The kernel is the closed form for one bonded layer. The start follows from the Fredholm equation of
Lebedev and Ufliand (J. Appl. Math. Mech. 22, 1958, 442) by Nystroem's method; the relaxation times
from Galerkin's method on Legendre polynomials of ``1 - 2 r^2``, whose Hankel transforms are Bessel
functions. Lengths are in punch radii, moduli in units of the layer's plane strain modulus.
"""

import numpy as np
from scipy.linalg import eigh
from scipy.special import gammaln, jv


def kernel(x, poisson_ratio):
    """Return the compliance of a bonded layer to waves, relative to a half-space.

    Parameters
    ----------
    x : wave number times thickness, positive
    poisson_ratio : up to and including 1/2
    """
    kappa, e = 3 - 4 * poisson_ratio, np.exp(-2 * x)
    # sinh and cosh times 2 exp(-2 x), so that they do not overflow
    above = kappa * (1 - e * e) - 4 * x * e
    below = kappa * (1 + e * e) + (4 * x * x + 1 + kappa**2) * e
    # the numerator cancels for long waves: 2 kappa sinh(2 x) - 4 x by its series
    long = x < 0.3
    y = 2 * x[long]
    sinh_remainder = sum(y**n / np.exp(gammaln(n + 1)) for n in range(3, 24, 2))
    above[long] = (2 * (kappa - 1) * y + 2 * kappa * sinh_remainder) * e[long]
    return above / below


def start(thickness, poisson_ratio, points=600):
    """Return the indentation of a flat punch under the force 1.

    The line density phi of the pressure, whose Hankel transform is ``int phi(t) cos(s t) dt``,
    satisfies ``phi(x) - 1/pi int (K(x - t) + K(x + t)) phi(t) dt = d / pi`` with ``K(t) = int (1 -
    kernel(s h)) cos(s t) ds``; the force is ``2 pi int phi dt``.
    """
    node, weight = _graded(thickness, points)
    s, lengths = wave_numbers(thickness, 2.0)
    cosines = np.cos(np.outer(node, s))
    added = (cosines * (lengths * (1 - kernel(s * thickness, poisson_ratio)))) @ cosines.T
    root = np.sqrt(weight)
    system = np.eye(len(node)) - 2 / np.pi * added * root * root[:, None]
    density = np.linalg.solve(system, root) / np.pi
    return 1 / (2 * np.pi * root @ density)


def relaxation_times(thickness, poisson_ratio, count=8, functions=400):
    """Return the slowest relaxation times (count,) for the wear coefficient 1 on the whole face."""
    s, lengths = wave_numbers(thickness, 2.0)
    order = np.arange(functions)
    weights = lengths * (kernel(s * thickness, poisson_ratio) - 1) / s**2
    bessel = jv(2 * order[:, None] + 1, s)
    total, lag = np.add.outer(order, order), np.subtract.outer(order, order)
    # int J_2m+1 J_2n+1 / s^2 ds (Weber and Schafheitlin)
    half_space = np.where(lag % 2, -1, 1) / (
        4 * np.pi * (total + 0.5) * (total + 1.5) * (0.25 - lag**2)
    )
    energies = 4 * np.pi * (half_space + (bessel * weights) @ bessel.T)
    root = np.sqrt((2 * order + 1) / np.pi)
    # the first function carries all of the force, which does not change
    return eigh((energies * root * root[:, None])[1:, 1:], eigvals_only=True)[::-1][:count]


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


def _graded(thickness, points):
    """Return Gauss points and weights on the radius, with panels of at most the thickness."""
    count = max(int(np.ceil(1 / thickness)), 8)
    return gauss(np.linspace(0, 1, count + 1), max(points // count, 8))


def gauss(edges, count):
    """Return Gauss points and weights on the panels between edges."""
    node, weight = np.polynomial.legendre.leggauss(count)
    half = np.diff(edges)[:, None] / 2
    return (edges[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


def fields_under_uniform_pressure(r, z, thickness, poisson_ratio):
    """Return displacements (n, 2) and stresses (n, 4: rr, zz, rz, hoop) inside a bonded layer.

    The pressure is 1 / pi on the disc of radius 1, so that the force is 1. In ``2 G u = grad(phi +
    z psi) - 4 (1 - nu) psi e_z``, the potentials of Papkovich and Neuber are sums of ``exp(-s z)``
    and ``exp(-s (h - z))`` times ``J_0(s r)``. Four equations for each wave number s determine
    their amplitudes.

    Parameters
    ----------
    r, z : (n,) radii and depths, which are positive
    """
    nu, shear = poisson_ratio, (1 - poisson_ratio) / 2
    s, lengths = wave_numbers(thickness, 1 + r.max(), least_depth=z.min())

    def waves(depth):
        """Return u_r, u_z, t_rz, s_zz and lambda div u (5, ..., 4) of the four potentials."""
        down, up = np.exp(-s * depth), np.exp(-s * (thickness - depth))
        rows = []
        for sign, e in ((-1, down), (1, up)):
            d = sign * s
            rows.append([-s * e, d * e, -s * d * e, d * d * e, 0 * e])
            rows.append(
                [
                    -s * depth * e,
                    (depth * d - (3 - 4 * nu)) * e,
                    -s * (depth * d - (1 - 2 * nu)) * e,
                    (depth * d * d - 2 * (1 - nu) * d) * e,
                    -2 * nu * d * e,
                ]
            )
        return np.moveaxis(np.array(rows), 0, -1)

    top, bottom = waves(np.zeros_like(s)), waves(np.full_like(s, thickness))
    system = np.stack([top[2], top[3], bottom[0], bottom[1]], axis=1)
    scale = np.abs(system).max(axis=1, keepdims=True)
    load = np.zeros((len(s), 4, 1))
    load[:, 1] = -1.0
    amplitudes = np.linalg.solve(system / scale, load) / scale.swapaxes(1, 2)
    # the Hankel transform of the pressure, times s ds
    spectrum = lengths * jv(1, s) / np.pi
    displacement, stress = [], []
    for radius, depth in zip(r, z, strict=True):
        state = (waves(np.full_like(s, depth)) * amplitudes[..., 0]).sum(axis=-1) * spectrum
        bessel0, bessel1 = jv(0, s * radius), jv(1, s * radius)
        over_radius = s / 2 if radius == 0 else bessel1 / radius
        u_r, hoop, u_z = state[0] @ bessel1, state[0] @ over_radius, state[1] @ bessel0
        zz, rz, dilatation = state[3] @ bessel0, state[2] @ bessel1, state[4] @ bessel0
        radial = state[0] @ (s * bessel0) - hoop
        displacement.append([u_r / (2 * shear), u_z / (2 * shear)])
        stress.append([dilatation + radial, zz, rz, dilatation + hoop])
    return np.array(displacement), np.array(stress)
