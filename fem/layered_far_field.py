"""The far field on layers: the fields of loads on ``r < 1``, exact in every layer.

Far away, an axisymmetric load acts as a sum of a few simple loads. On a homogeneous half-space
these are poles at the origin (`far_field.py`), whose Hankel transforms grow with the wave number s.
On layers they are pressures whose line densities (`meshes.ground.line_energy`) are Legendre
polynomials ``P_2j(x)``, because their transforms do not grow. A line density q(x) has the transform
``int_0^1 q(x) cos(s x) dx``. The field of a homogeneous half-space is therefore an integral over
point loads at imaginary depths ``i x``, in closed form. The part that layers add is an integral
over s that decays as ``exp(-s h)`` with the thickness h of the first layer.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import j0, j1

from ..meshes.ground.ground import Ground, interfaces, loaded_waves, travel, wave_numbers, waves
from ..meshes.ground.line_energy import even_legendre
from ..meshes.radial import Array, unit_gauss
from .far_field import fields_of_waves

# decay exponent (depth times wave number) at which a wave is zero in double precision
ZERO_EXPONENT = 700.0
# Smallest eigenvalue of the energy matrix, with each load scaled to energy 1, at which the loads
# count as linearly independent.
LEAST_INDEPENDENT_EIGENVALUE = 1e-8
# smallest energy beyond the boundary of a load that is used, relative to the smallest shear modulus
LEAST_ENERGY = 1e-12


def loaded_fields(points: Array, count: int, ground: Ground, outer: float) -> tuple[Array, Array]:
    """Return displacements (count, n, 2) and stresses (count, n, 4: rr, zz, rz, hoop) of loads.

    Parameters
    ----------
    points : (n, 2) radius and depth, on or near the outer boundary
    count : number of loads; load number j is scaled by ``outer^2j``
    ground : layers; a point on an interface belongs to the layer below it, unless that is a rigid
        base
    outer : radius of the outer boundary
    """
    imaginary_depths, weight = unit_gauss(2 * count + 2)
    scales = outer ** np.arange(0.0, 2 * count, 2)
    sources = even_legendre(imaginary_depths, count) * weight[:, None] * scales
    layer = ground.layer_at(points[:, 1])
    if ground.rigid:
        layer = np.minimum(layer, len(ground.thicknesses) - 1)
    fields = _homogeneous(
        points, imaginary_depths, ground.poisson_ratios[0], ground.shear_moduli[0]
    )
    in_first = (layer == 0)[:, None, None]
    displacement, stress = (np.einsum("nxc,xk->knc", field * in_first, sources) for field in fields)
    s, lengths = wave_numbers(ground, outer + 1, travelled=ground.first_thickness)
    spectrum = lengths[:, None] * (np.cos(np.outer(s, imaginary_depths)) @ sources)
    for number, amplitudes in enumerate(_added_waves(ground, s)):
        in_layer = np.flatnonzero(layer == number)
        layer_displacement, layer_stress = _waves_at(
            points[in_layer], ground, number, s, amplitudes, spectrum
        )
        displacement[:, in_layer] += layer_displacement
        stress[:, in_layer] += layer_stress
    return displacement, stress


def independent_count(energies: Array, least_modulus: float) -> int:
    """Return how many of the first loads have fields that are neither negligible nor dependent.

    On a rigid base fields decay exponentially with the distance, and what remains of them has the
    same shape for all loads. On an elastic substrate the loads always remain independent.

    Parameters
    ----------
    energies : (k, k) energies of the loads beyond the outer boundary
    least_modulus : smallest shear modulus of the ground
    """
    diagonal, count = np.diag(energies), 0
    while count < len(diagonal) and diagonal[count] > LEAST_ENERGY * least_modulus:
        leading = slice(count + 1)
        sizes = np.sqrt(np.abs(diagonal[leading]))
        if (
            np.linalg.eigvalsh(energies[leading, leading] / np.outer(sizes, sizes))[0]
            < LEAST_INDEPENDENT_EIGENVALUE
        ):
            break
        count += 1
    return count


def _added_waves(ground: Ground, s: Array) -> Sequence[tuple[Array, Array]]:
    """Return the waves in each layer and in the substrate under the unit load.

    For each layer these are the downward waves (k, 2) at its top and the upward waves (k, 2) at its
    bottom, at the k wave numbers s. In the first layer, the waves of a homogeneous half-space are
    subtracted.
    """
    all_interfaces, reflection = interfaces(ground, s)
    down, _ = loaded_waves(ground, s, reflection)
    nu, shear = ground.poisson_ratios[0], ground.shear_moduli[0]
    homogeneous = np.array([-(1 - 2 * nu), 1.0]) / (2 * shear)
    out = []
    for number, (interface, thickness) in enumerate(
        zip(all_interfaces, ground.thicknesses, strict=True)
    ):
        at_bottom = travel(s * thickness) @ down[..., None]
        up = (interface.reflected @ at_bottom)[..., 0]
        out.append((down - homogeneous if number == 0 else down, up))
        if interface.transmitted is None:
            return out
        down = (interface.transmitted @ at_bottom)[..., 0]
    return [*out, (down, np.zeros_like(down))]


def _waves_at(
    points: Array,
    ground: Ground,
    number: int,
    s: Array,
    amplitudes: tuple[Array, Array],
    spectrum: Array,
) -> tuple[Array, Array]:
    """Return displacements (k, n, 2) and stresses (k, n, 4) of the waves in layer `number`."""
    (r, z), (down, up) = points.T, amplitudes
    tops = np.append(0.0, ground.depths)
    from_top = s * np.maximum(z - tops[number], 0.0)[:, None]
    from_bottom = np.full_like(from_top, ZERO_EXPONENT)
    if number < len(ground.thicknesses):
        from_bottom = s * np.maximum(tops[number + 1] - z, 0.0)[:, None]
    downward_decay, upward_decay = np.exp(-from_top), np.exp(-from_bottom)
    wave_values = (
        downward_decay * (down[:, 0] + from_top * down[:, 1]),
        downward_decay * down[:, 1],
        upward_decay * (up[:, 0] + from_bottom * up[:, 1]),
        upward_decay * up[:, 1],
    )
    nu, shear = ground.poisson_ratios[number], ground.shear_moduli[number]
    states = np.hstack(waves(nu, shear))
    u_r, u_z, t_rz, s_zz = (
        sum(factor * wave for factor, wave in zip(row, wave_values, strict=True)) for row in states
    )
    bessel0, bessel1 = j0(s * r[:, None]), j1(s * r[:, None])
    radial, axial = (u_r * bessel1) @ spectrum, (u_z * bessel0) @ spectrum
    zz, rz = (s * s_zz * bessel0) @ spectrum, (s * t_rz * bessel1) @ spectrum
    # `spread` is 2 G (du_r/dr + u_r/r). By Hooke's law, `dilatation_part`, which is lambda times
    # the dilatation, follows from it and s_zz.
    spread = 2 * shear * (s * u_r * bessel0) @ spectrum
    dilatation_part = nu / (1 - nu) * (zz + spread)
    on_axis = r[:, None] == 0
    hoop = np.where(on_axis, spread / 2, 2 * shear * radial / np.where(on_axis, 1.0, r[:, None]))
    displacement = np.stack([radial.T, axial.T], axis=-1)
    stress = [(dilatation_part + spread - hoop).T, zz.T, rz.T, (dilatation_part + hoop).T]
    return displacement, np.stack(stress, axis=-1)


def _homogeneous(
    points: Array, imaginary_depths: Array, poisson_ratio: float, shear_modulus: float
) -> tuple[Array, Array]:
    """Return displacements (n, x, 2) and stresses (n, x, 4) of point loads at imaginary depths.

    They are the real parts of the fields of `far_field.poles` of order 0 at the depth ``z + i x``,
    where the factor ``exp(-s z)`` becomes ``exp(-s z) cos(s x)``. A factor z that multiplies a wave
    is not changed.

    Parameters
    ----------
    points : (n, 2) radius and depth
    imaginary_depths : (x,) imaginary depths of the loads
    poisson_ratio, shear_modulus : elastic constants of the half-space
    """
    r, z = points.T[..., None]
    deep = z + 1j * imaginary_depths
    rho = np.sqrt(r * r + deep * deep)
    cosine = deep / rho
    cosines = (1 / rho).real, (cosine / rho**2).real, ((3 * cosine**2 - 1) / rho**3).real
    sines = (1 / (rho * (rho + deep))).real, (1 / rho**3).real, (3 * cosine / rho**4).real
    displacement, stress = fields_of_waves(r, z, cosines, sines, poisson_ratio)
    return displacement / (2 * shear_modulus), stress
