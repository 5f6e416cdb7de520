"""Elastic layers bonded to each other and to a substrate, and their surface displacement.

A ground without layers is a homogeneous half-space, to which all formulas apply: nothing is
reflected, and the integrals over what layers add have no points.

A normal load ``p(s) J_0(s r)`` on the surface displaces it by ``2 Phi(s) / (E1* s) p(s) J_0(s r)``,
with ``Phi = 1`` for a half-space of the first layer's material. In each layer the solution is a sum
of four waves. Two decay downwards from its top, ``exp(-s z) (1, s z)`` with z the depth below the
top. Two decay upwards from its bottom, ``exp(-s z) (1, s z)`` with z the height above the bottom.
An interface reflects a part of the waves that arrive from above. The reflections of all interfaces,
from the lowest one up, are combined in one reflection matrix at the surface. Only decaying
exponentials occur, so that s may be large and layers may be thin.

The state vector is ``(u_r, u_z, t_rz / s, s_zz / s)``; u_r and t_rz are multiplied by J_1(s r), u_z
and s_zz by J_0(s r). Nothing is singular at Poisson's ratio 1/2.
"""

from dataclasses import dataclass, replace
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]
Indices = NDArray[np.int64]

# decay exponent at which exponentials count as zero: exp(-36) = 2e-16 is roundoff
NEGLIGIBLE_EXPONENT = 36.0
# Smallest panel of the quadrature in s, times the greatest depth (or the punch radius if that is
# larger). The integrand is practically constant below it.
LEAST_WAVE_NUMBER = 1e-6
# largest phase of the oscillating integrand on one panel of the quadrature, in radians
MAX_PHASE = 20.0
# number of Gauss points on each panel
POINTS = 20


@dataclass(frozen=True)
class Ground:
    """Describe elastic layers on an elastic substrate or on a rigid base.

    Without layers, the substrate is a homogeneous half-space. All layers are isotropic and bonded,
    and strains are small. Lengths are in punch radii, moduli in units of the plane strain modulus
    of the first layer.

    >>> pad = Ground.from_youngs_moduli([0.5], [1.0, np.inf], poisson_ratios=[0.3, 0.0])
    >>> pad.rigid, pad.shear_moduli[0]
    (True, 0.35)
    >>> relative_compliance(Ground.half_space(0.3), np.array([1.0, 10.0]))
    array([1., 1.])

    Parameters
    ----------
    thicknesses : (n,) thicknesses of the layers, from the surface down; empty for a half-space
    shear_moduli : (n + 1,) shear moduli of the layers and, last, of the substrate; infinite for a
        rigid base
    poisson_ratios : (n + 1,) Poisson's ratios in the same order
    share : the part of the compliance of the contact that is of the ground, to short waves; the
        rest is that of an elastic punch, which is a homogeneous half-space. It scales what layers
        add. It is 1 under a rigid punch, and also without layers, where one modulus describes both
    """

    thicknesses: tuple[float, ...]
    shear_moduli: tuple[float, ...]
    poisson_ratios: tuple[float, ...]
    share: float = 1.0

    @classmethod
    def half_space(cls, poisson_ratio: float) -> "Ground":
        """Return the homogeneous half-space of plane strain modulus 1."""
        return cls((), ((1 - poisson_ratio) / 2,), (poisson_ratio,))

    @classmethod
    def from_youngs_moduli(
        cls, thicknesses: list[float], youngs_moduli: list[float], poisson_ratios: list[float]
    ) -> "Ground":
        """Return the ground with given Young's moduli, which may be in any unit.

        Parameters
        ----------
        thicknesses : (n,) thicknesses of the layers in punch radii
        youngs_moduli : (n + 1,) Young's moduli of the layers and, last, of the substrate; infinite
            for a rigid base
        poisson_ratios : (n + 1,) Poisson's ratios in the same order
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
    def layered(self) -> bool:
        """Whether there are layers."""
        return bool(self.thicknesses)

    @property
    def first_thickness(self) -> float:
        """Thickness of the first layer; infinite for a half-space."""
        return min(self.thicknesses[:1], default=np.inf)

    @property
    def depths(self) -> Array:
        """(n,) depths of the interfaces."""
        return np.cumsum(np.array(self.thicknesses))

    @property
    def greatest_poisson_ratio(self) -> float:
        """Greatest Poisson's ratio of the layers and, unless it is rigid, the substrate."""
        return max(self.poisson_ratios[: len(self.thicknesses) + (not self.rigid)])

    def layer_at(self, depths: Array) -> Indices:
        """Return the number of the layer at each depth, counted from 0; the substrate is n."""
        return np.searchsorted(self.depths, depths, side="right")

    def in_units_of(self, radius: float) -> "Ground":
        """Return the same ground in units of another radius, given in units of the present one."""
        return replace(
            self, thicknesses=tuple(thickness / radius for thickness in self.thicknesses)
        )

    def with_poisson_ratios_below(self, highest: float) -> "Ground":
        """Return the ground with Poisson's ratios of at most `highest`."""
        return self.with_poisson_ratios([min(ratio, highest) for ratio in self.poisson_ratios])

    def with_poisson_ratios(self, ratios: list[float]) -> "Ground":
        """Return the ground with other Poisson's ratios (n + 1,).

        The shear moduli of layers stay as they are. A half-space keeps its plane strain modulus, on
        which alone its surface compliance depends.
        """
        if not self.layered:
            return Ground.half_space(ratios[0])
        return replace(self, poisson_ratios=tuple(ratios))


HALF_SPACE = Ground.half_space(0.3)
"""A homogeneous half-space of plane strain modulus 1; its Poisson's ratio is that of steel."""


class Interface(NamedTuple):
    """Reflection and transmission of waves that arrive at an interface from above.

    Parameters
    ----------
    reflected : (k, 2, 2) matrices that give the waves that go up from the interface, for each wave
        number
    transmitted : (k, 2, 2) matrices that give the waves that go down below it; None at a rigid base
    """

    reflected: Array
    transmitted: Array | None


def waves(poisson_ratio: float, shear_modulus: float) -> tuple[Array, Array]:
    """Return the states (4, 2) of the two waves that decay downwards, at the top of a layer.

    The second array (4, 2) holds the states of the two waves that decay upwards, at its bottom.
    """
    nu = poisson_ratio
    down = np.array(
        [[1, 0], [1, 3 - 4 * nu], [-1, -(1 - 2 * nu)], [-1, -(2 - 2 * nu)]], dtype=float
    )
    mirrored = np.array([1.0, -1.0, -1.0, 1.0])[:, None]
    scale = np.array([1.0, 1.0, 2 * shear_modulus, 2 * shear_modulus])[:, None]
    return down * scale, down * mirrored * scale


def travel(distances: Array) -> Array:
    """Return matrices (k, 2, 2) that propagate both waves over distances (k,), in units of 1/s."""
    out = np.zeros((len(distances), 2, 2))
    out[:, 0, 0] = out[:, 1, 1] = np.exp(-distances)
    out[:, 0, 1] = distances * np.exp(-distances)
    return out


def interfaces(ground: Ground, s: Array) -> tuple[list[Interface], Array]:
    """Return every interface, from the surface down, at wave numbers s (k,).

    The second value (k, 2, 2) is the reflection matrix of all interfaces together, at the surface.
    """
    out: list[Interface] = []
    # reflection matrix of everything below, at the top of the layer below; a substrate reflects
    # nothing
    reflection_below = np.zeros((len(s), 2, 2))
    for number in reversed(range(len(ground.thicknesses))):
        down, up = waves(ground.poisson_ratios[number], ground.shear_moduli[number])
        if np.isinf(ground.shear_moduli[number + 1]):
            # the displacement is zero at a rigid base
            rigid_reflection = -np.linalg.solve(up[:2], down[:2])
            out.append(Interface(np.broadcast_to(rigid_reflection, (len(s), 2, 2)), None))
        else:
            down_below, up_below = waves(
                ground.poisson_ratios[number + 1], ground.shear_moduli[number + 1]
            )
            # displacements and tractions are continuous
            unknown_states = np.concatenate(
                [np.broadcast_to(up, (len(s), 4, 2)), -(down_below + up_below @ reflection_below)],
                axis=2,
            )
            outgoing = np.linalg.solve(unknown_states, np.broadcast_to(-down, (len(s), 4, 2)))
            out.append(Interface(outgoing[:, :2], outgoing[:, 2:]))
        propagation = travel(s * ground.thicknesses[number])
        reflection_below = propagation @ out[-1].reflected @ propagation
    return out[::-1], reflection_below


def loaded_waves(ground: Ground, s: Array, reflection: Array) -> tuple[Array, Array]:
    """Return the downward waves (k, 2) at the surface under the unit load, at wave numbers s (k,).

    The second value is the displacement ``u_z`` (k,) of the surface.
    """
    down, up = waves(ground.poisson_ratios[0], ground.shear_moduli[0])
    state = down + up @ reflection
    load = np.broadcast_to(np.array([[0.0], [-1.0]]), (len(s), 2, 1))
    amplitudes = np.linalg.solve(state[:, 2:], load)
    return amplitudes[..., 0], (state[:, 1:2] @ amplitudes)[:, 0, 0]


def relative_compliance(ground: Ground, s: Array) -> Array:
    """Return ``Phi(s)``, (k,): the surface compliance relative to a half-space of the first layer.

    Parameters
    ----------
    s : (k,) positive wave numbers, in units of 1 / punch radius

    Notes
    -----
    The relative error is about the roundoff times the square of the ratio of neighbouring moduli:
    1e-12 for a ratio of 100 (tests/unit/meshes/test_layers_kernel.py).
    """
    _, displacement = loaded_waves(ground, s, interfaces(ground, s)[1])
    half_space = (1 - ground.poisson_ratios[0]) / ground.shear_moduli[0]
    return displacement / half_space


def wave_numbers(
    ground: Ground, reach: float, travelled: float | None = None
) -> tuple[Array, Array]:
    """Return Gauss points and weights (k,) on (0, infinity) for the part that layers add.

    Parameters
    ----------
    ground : the layers; a half-space has no points, because nothing is added to it
    reach : largest frequency of the integrand, which oscillates at most as ``cos(reach s)``
    travelled : distance in the decay of the integrand, ``exp(-s travelled)``; the default is twice
        the thickness of the first layer, because the waves that layers add to the surface
        compliance have travelled down to the first interface and back
    """
    if not ground.layered:
        return np.empty(0), np.empty(0)
    end = NEGLIGIBLE_EXPONENT / (2 * ground.first_thickness if travelled is None else travelled)
    widest = min(MAX_PHASE / reach, end)
    first_panel = LEAST_WAVE_NUMBER / max(float(ground.depths[-1]), 1.0)
    doubling = np.geomspace(first_panel, widest, int(np.log2(widest / first_panel)) + 2)
    even = np.linspace(widest, end, int(np.ceil((end - widest) / widest)) + 1)[1:]
    panels = np.concatenate([[0.0], doubling, even])
    node, weight = _gauss(POINTS)
    half = np.diff(panels)[:, None] / 2
    return (panels[:-1, None] + half * (1 + node)).ravel(), (half * weight).ravel()


@lru_cache(maxsize=64)
def spectrum(ground: Ground) -> tuple[Array, Array]:
    """Return wave numbers (k,), and what layers add to the compliance of the contact there.

    It is the ground's share of ``Phi - 1``, times the quadrature weights. The arrays are cached and
    must not be modified.
    """
    s, weights = wave_numbers(ground, reach=2.0)
    return s, ground.share * (relative_compliance(ground, s) - 1) * weights


@cache
def _gauss(count: int) -> tuple[Array, Array]:
    node, weight = np.polynomial.legendre.leggauss(count)
    return node, weight
