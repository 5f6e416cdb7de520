"""Layers, bonded to each other and to what is below them, and how the surface gives under a load.

A normal load ``p(s) J_0(s r)`` on the surface displaces it by ``2 Phi(s) / (E1* s) p(s) J_0(s r)``,
with ``Phi = 1`` for a half-space of the first layer's material. In each layer the solution is a sum
of four waves, two that decay downwards from its top, ``exp(-s z) (1, s z)`` with z the depth below
the top, and two that decay upwards from its bottom, ``exp(-s z) (1, s z)`` with z the height above
the bottom. An interface sends a part of the waves that come down back up. From the lowest interface
to the surface these parts are joined to one reflection matrix. No exponential grows, so that s may
be large and layers may be thin.

States are ``(u_r, u_z, t_rz / s, s_zz / s)``; u_r and t_rz go with J_1(s r), the others with
J_0(s r). Nothing is singular at Poisson's ratio 1/2.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

# exponents beyond which exponentials are below roundoff
NEGLIGIBLE_EXPONENT = 36.0
# part of the greatest depth over which nothing varies: panels of quadrature halve down to there
LEAST_WAVE_NUMBER = 1e-6
# periods, over 2 pi, that a panel of quadrature holds at most, and its Gauss points
PERIODS, POINTS = 20.0, 20


@dataclass(frozen=True)
class Ground:
    """Describe elastic layers on an elastic substrate or on a rigid base.

    All layers are isotropic and bonded, and strains are small. Lengths are in punch radii, moduli
    in plane strain moduli of the first layer.

    >>> pad = Ground.of_moduli([0.5], youngs_moduli=[1.0, np.inf], poisson_ratios=[0.3, 0.0])
    >>> pad.rigid, pad.shear_moduli[0]
    (True, 0.35)

    Parameters
    ----------
    thicknesses : (n,) of the layers, from the surface down
    shear_moduli : (n + 1,) of the layers and, last, of the substrate; infinite for a rigid base
    poisson_ratios : (n + 1,) of the same
    """

    thicknesses: tuple[float, ...]
    shear_moduli: tuple[float, ...]
    poisson_ratios: tuple[float, ...]

    @classmethod
    def of_moduli(
        cls, thicknesses: list[float], youngs_moduli: list[float], poisson_ratios: list[float]
    ) -> "Ground":
        """Return the ground by Young's moduli in any unit, the substrate's last.

        Parameters
        ----------
        thicknesses : (n,) in punch radii
        youngs_moduli : (n + 1,); infinite for a rigid base
        poisson_ratios : (n + 1,)
        """
        ratios = np.array(poisson_ratios, dtype=float)
        unit = youngs_moduli[0] / (1 - ratios[0] ** 2)
        shear = np.array(youngs_moduli) / unit / (2 * (1 + ratios))
        return cls(tuple(map(float, thicknesses)), tuple(shear.tolist()), tuple(ratios.tolist()))

    @property
    def rigid(self) -> bool:
        """Whether the base below the layers is rigid."""
        return bool(np.isinf(self.shear_moduli[-1]))

    @property
    def first(self) -> float:
        """Thickness of the first layer."""
        return self.thicknesses[0]

    @property
    def depths(self) -> Array:
        """(n,) depths of the interfaces."""
        return np.cumsum(self.thicknesses)

    @property
    def greatest_poisson_ratio(self) -> float:
        """The greatest Poisson's ratio of what is elastic."""
        return max(self.poisson_ratios[: len(self.thicknesses) + (not self.rigid)])

    def layer_at(self, depths: Array) -> Indices:
        """Return the number of the layer at each depth; that of the substrate is n."""
        return np.asarray(np.searchsorted(self.depths, depths, side="right"))

    def on(self, radius: float) -> "Ground":
        """Return the same ground in units of another radius, which is given in the present one."""
        return replace(self, thicknesses=tuple(each / radius for each in self.thicknesses))

    def with_poisson_ratios_below(self, highest: float) -> "Ground":
        """Return the ground with no Poisson's ratio above a highest one, and the same moduli G."""
        return replace(
            self, poisson_ratios=tuple(min(ratio, highest) for ratio in self.poisson_ratios)
        )


class Interface(NamedTuple):
    """What an interface does to waves that come down to it, by wave numbers.

    Parameters
    ----------
    reflected : (k, 2, 2) waves that go up from it
    transmitted : (k, 2, 2) waves that go down below it; None at a rigid base
    """

    reflected: Array
    transmitted: Array | None


def waves(poisson_ratio: float, shear_modulus: float) -> tuple[Array, Array]:
    """Return the states (4, 2) of the two waves that decay downwards, at their top.

    The second array holds those of the waves that decay upwards, at their bottom.
    """
    nu = poisson_ratio
    down = np.array(
        [[1, 0], [1, 3 - 4 * nu], [-1, -(1 - 2 * nu)], [-1, -(2 - 2 * nu)]], dtype=float
    )
    mirrored = np.array([1.0, -1.0, -1.0, 1.0])[:, None]
    scale = np.array([1.0, 1.0, 2 * shear_modulus, 2 * shear_modulus])[:, None]
    return down * scale, down * mirrored * scale


def travel(distances: Array) -> Array:
    """Return what is left (k, 2, 2) of both waves after distances (k,), in units of 1/s."""
    out = np.zeros((len(distances), 2, 2))
    out[:, 0, 0] = out[:, 1, 1] = np.exp(-distances)
    out[:, 0, 1] = distances * np.exp(-distances)
    return out


def interfaces(ground: Ground, s: Array) -> tuple[list[Interface], Array]:
    """Return what every interface does at wave numbers s (k,), from the surface down.

    The second value (k, 2, 2) is the reflection matrix of all of them, at the surface.
    """
    out: list[Interface] = []
    # of what is below, at its top; a substrate sends nothing back
    below = np.zeros((len(s), 2, 2))
    for number in reversed(range(len(ground.thicknesses))):
        down, up = waves(ground.poisson_ratios[number], ground.shear_moduli[number])
        if np.isinf(ground.shear_moduli[number + 1]):
            # nothing moves there
            fixed = -np.linalg.solve(up[:2], down[:2])
            out.append(Interface(np.broadcast_to(fixed, (len(s), 2, 2)), None))
        else:
            down_below, up_below = waves(
                ground.poisson_ratios[number + 1], ground.shear_moduli[number + 1]
            )
            # displacements and tractions are continuous
            unknown = np.concatenate(
                [np.broadcast_to(up, (len(s), 4, 2)), -(down_below + up_below @ below)], axis=2
            )
            solved = np.linalg.solve(unknown, np.broadcast_to(-down, (len(s), 4, 2)))
            out.append(Interface(solved[:, :2], solved[:, 2:]))
        through = travel(s * ground.thicknesses[number])
        below = through @ out[-1].reflected @ through
    return out[::-1], below


def loaded_waves(ground: Ground, s: Array, reflection: Array) -> tuple[Array, Array]:
    """Return the waves that go down from the surface under the load 1, by wave numbers s (k,).

    They are (k, 2); the second value is the displacement ``u_z`` (k,) of the surface.
    """
    down, up = waves(ground.poisson_ratios[0], ground.shear_moduli[0])
    state = down + up @ reflection
    load = np.broadcast_to(np.array([[0.0], [-1.0]]), (len(s), 2, 1))
    amplitudes = np.linalg.solve(state[:, 2:], load)
    return amplitudes[..., 0], (state[:, 1:2] @ amplitudes)[:, 0, 0]


def relative_compliance(ground: Ground, s: Array) -> Array:
    """Return ``Phi(s)``, (k,): the surface compliance over that of the first layer's half-space.

    Parameters
    ----------
    s : (k,) positive wave numbers, over the punch radius

    Notes
    -----
    It errs by the square of the ratio of neighbouring moduli in units of roundoff: by 1e-12 at 100
    (tests/unit/meshes/test_layers_kernel.py).
    """
    _, displacement = loaded_waves(ground, s, interfaces(ground, s)[1])
    half_space = (1 - ground.poisson_ratios[0]) / ground.shear_moduli[0]
    return np.asarray(displacement / half_space)


def wave_numbers(
    ground: Ground, reach: float, travelled: float | None = None
) -> tuple[Array, Array]:
    """Return Gauss points and weights on (0, infinity), (k,) each, for what layers add.

    Parameters
    ----------
    reach : the integrand oscillates as ``cos(reach s)`` at most
    travelled : it decays as ``exp(-s travelled)``; by default as what the layers add to the surface
        compliance, which has gone down to the first interface and up again
    """
    end = NEGLIGIBLE_EXPONENT / (2 * ground.first if travelled is None else travelled)
    widest = min(PERIODS / reach, end)
    least = LEAST_WAVE_NUMBER / max(float(ground.depths[-1]), 1.0)
    doubling = np.geomspace(least, widest, int(np.log2(widest / least)) + 2)
    even = np.linspace(widest, end, int(np.ceil((end - widest) / widest)) + 1)[1:]
    panels = np.concatenate([[0.0], doubling, even])
    node, weight = _gauss(POINTS)
    half = np.diff(panels)[:, None] / 2
    return (panels[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


@cache
def _gauss(count: int) -> tuple[Array, Array]:
    node, weight = np.polynomial.legendre.leggauss(count)
    return node, weight
