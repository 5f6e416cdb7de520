"""The far field on layers: the fields of loads on ``r < 1``, exact in every layer.

An axisymmetric load is seen from afar as the sum of a few simple ones. On a homogeneous half-space
those are poles at the origin (`far_field.py`), whose Hankel transforms grow with the wave number s.
Here they are the pressures whose line densities (`meshes.ground.line_energy`) are Legendre's
``P_2j(x)``, whose transforms do not grow. A line density q(x) has the transform ``int_0^1 q(x)
cos(s x) dx``; so the field of a homogeneous half-space is an integral over point loads at imaginary
depths ``i x``, in closed form, and what layers add is an integral over s that decays as ``exp(-s
h)`` with the thickness h of the first layer.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import j0, j1

from ..meshes.ground.ground import Ground, interfaces, loaded_waves, travel, wave_numbers, waves
from ..meshes.ground.line_energy import even_legendre
from ..meshes.radial import Array, unit_gauss

# a depth, over the wave length, at which nothing is left of a wave
FAR = 700.0
# least eigenvalue of the energies of loads, each scaled to 1, of which no two are alike
INDEPENDENT = 1e-8
# energy beyond the boundary of a load that matters, over the least modulus
LEAST_ENERGY = 1e-12


def loaded_fields(points: Array, count: int, ground: Ground, outer: float) -> tuple[Array, Array]:
    """Return displacements (count, n, 2) and stresses (count, n, 4: rr, zz, rz, hoop).

    Parameters
    ----------
    points : (n, 2) radius and depth, on or about the outer boundary
    count : number of loads; that of number j is scaled by ``outer^2j``
    ground : layers; at an interface a point belongs to what is below it, but not to a rigid base
    outer : radius of the outer boundary
    """
    at, weight = unit_gauss(2 * count + 2)
    scales = outer ** np.arange(0.0, 2 * count, 2)
    sources = even_legendre(at, count) * weight[:, None] * scales
    layer = ground.layer_at(points[:, 1])
    if ground.rigid:
        layer = np.minimum(layer, len(ground.thicknesses) - 1)
    fields = _homogeneous(points, at, ground.poisson_ratios[0], ground.shear_moduli[0])
    in_first = (layer == 0)[:, None, None]
    displacement, stress = (np.einsum("nxc,xk->knc", field * in_first, sources) for field in fields)
    s, lengths = wave_numbers(ground, outer + 1, travelled=ground.first)
    spectrum = lengths[:, None] * (np.cos(np.outer(s, at)) @ sources)
    for number, amplitudes in enumerate(_added_waves(ground, s)):
        here = np.flatnonzero(layer == number)
        moved, stressed = _waves_at(points[here], ground, number, s, amplitudes, spectrum)
        displacement[:, here] += moved
        stress[:, here] += stressed
    return displacement, stress


def independent_count(energies: Array, least_modulus: float) -> int:
    """Return how many of the first loads are neither next to nothing nor all alike.

    On a rigid base fields decay exponentially with the distance, and what is left of them is the
    same for all loads; on an elastic substrate they never are.

    Parameters
    ----------
    energies : (k, k) of the loads beyond the outer boundary
    least_modulus : least shear modulus of the ground
    """
    own, count = np.diag(energies), 0
    while count < len(own) and own[count] > LEAST_ENERGY * least_modulus:
        few = slice(count + 1)
        sizes = np.sqrt(np.abs(own[few]))
        if np.linalg.eigvalsh(energies[few, few] / np.outer(sizes, sizes))[0] < INDEPENDENT:
            break
        count += 1
    return count


def _added_waves(ground: Ground, s: Array) -> Sequence[tuple[Array, Array]]:
    """Return the waves in each layer and in the substrate under the load 1, by wave numbers (k,).

    They are (k, 2) waves that go down, at the top, and (k, 2) that go up, at the bottom. Those of a
    homogeneous half-space are taken away in the first layer.
    """
    parts, reflection = interfaces(ground, s)
    down, _ = loaded_waves(ground, s, reflection)
    nu, shear = ground.poisson_ratios[0], ground.shear_moduli[0]
    homogeneous = np.array([-(1 - 2 * nu), 1.0]) / (2 * shear)
    out = []
    for number, (part, thickness) in enumerate(zip(parts, ground.thicknesses, strict=True)):
        at_bottom = travel(s * thickness) @ down[..., None]
        up = (part.reflected @ at_bottom)[..., 0]
        out.append((down - homogeneous if number == 0 else down, up))
        if part.transmitted is None:
            return out
        down = (part.transmitted @ at_bottom)[..., 0]
    return [*out, (down, np.zeros_like(down))]


def _waves_at(
    points: Array,
    ground: Ground,
    number: int,
    s: Array,
    amplitudes: tuple[Array, Array],
    spectrum: Array,
) -> tuple[Array, Array]:
    """Return displacements (k, n, 2) and stresses (k, n, 4) of the waves in a layer."""
    (r, z), (down, up) = points.T, amplitudes
    tops = np.append(0.0, ground.depths)
    from_top = s * np.maximum(z - tops[number], 0.0)[:, None]
    from_bottom = np.full_like(from_top, FAR)
    if number < len(ground.thicknesses):
        from_bottom = s * np.maximum(tops[number + 1] - z, 0.0)[:, None]
    near, far = np.exp(-from_top), np.exp(-from_bottom)
    each = (
        near * (down[:, 0] + from_top * down[:, 1]),
        near * down[:, 1],
        far * (up[:, 0] + from_bottom * up[:, 1]),
        far * up[:, 1],
    )
    nu, shear = ground.poisson_ratios[number], ground.shear_moduli[number]
    states = np.hstack(waves(nu, shear))
    u_r, u_z, t_rz, s_zz = (
        sum(factor * wave for factor, wave in zip(row, each, strict=True)) for row in states
    )
    bessel0, bessel1 = j0(s * r[:, None]), j1(s * r[:, None])
    radial, axial = (u_r * bessel1) @ spectrum, (u_z * bessel0) @ spectrum
    zz, rz = (s * s_zz * bessel0) @ spectrum, (s * t_rz * bessel1) @ spectrum
    # 2 G (du_r/dr + u_r/r), and by Hooke's law the part of all stresses that comes with s_zz
    spread = 2 * shear * (s * u_r * bessel0) @ spectrum
    shared = nu / (1 - nu) * (zz + spread)
    on_axis = r[:, None] == 0
    hoop = np.where(on_axis, spread / 2, 2 * shear * radial / np.where(on_axis, 1.0, r[:, None]))
    moved = np.stack([radial.T, axial.T], axis=-1)
    stressed = [(shared + spread - hoop).T, zz.T, rz.T, (shared + hoop).T]
    return moved, np.stack(stressed, axis=-1)


def _homogeneous(
    points: Array, at: Array, poisson_ratio: float, shear_modulus: float
) -> tuple[Array, Array]:
    """Return displacements (n, x, 2) and stresses (n, x, 4) of point loads at imaginary depths.

    They are the real parts of those of `far_field.poles` of order 0 at the depth ``z + i x``, whose
    factor ``exp(-s z)`` becomes ``exp(-s z) cos(s x)``; the factor z of a wave stays as it is.

    Parameters
    ----------
    points : (n, 2) radius and depth
    at : (x,) imaginary depths
    """
    nu, (r, z) = poisson_ratio, points.T[..., None]
    deep = z + 1j * at
    rho = np.sqrt(r * r + deep * deep)
    cosine = deep / rho
    l0, l1, l2 = (part.real for part in (1 / rho, cosine / rho**2, (3 * cosine**2 - 1) / rho**3))
    m0_r, m1_r, m2_r = (
        part.real for part in (1 / (rho * (rho + deep)), 1 / rho**3, 3 * cosine / rho**4)
    )
    hoop = z * m1_r - (1 - 2 * nu) * m0_r
    displacement = np.stack([r * hoop, 2 * (1 - nu) * l0 + z * l1], axis=-1)
    shared = -2 * nu * l1
    rr = z * (l2 - m1_r) - (1 - 2 * nu) * (l1 - m0_r)
    zz = -(1 - 2 * nu) * l1 - z * l2
    stress = [shared + rr, shared + zz, -z * r * m2_r, shared + hoop]
    return displacement / (2 * shear_modulus), np.stack(stress, axis=-1)
