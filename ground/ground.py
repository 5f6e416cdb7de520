"""Layers, bonded to each other and to what is below them: thicknesses and elastic constants."""

from dataclasses import dataclass, replace

import numpy as np

from ..meshes.radial import Array, Indices


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
