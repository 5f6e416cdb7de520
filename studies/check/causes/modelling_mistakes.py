"""Mistakes in what another program models: material, load, geometry and ground."""

import math

from .cause import Cause, Factor, Sizes
from .model import Model
from .setting import STIFFNESSES, THICKNESSES, Setting

# least logarithm of a factor on the load; a smaller one counts as no change
MIN_LOG_FACTOR = 0.06


class WearCoefficient(Factor):
    """A wrong wear coefficient or sliding speed: the same history in a shorter or longer time."""

    name = "wear coefficient"
    group = "time"
    prior = 0.15
    greatest_factor = 1e7
    remedy = (
        "compare k and v of the input, and their units; with all times multiplied by this factor "
        "the error disappears"
    )

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.has_later_times and not model.problem.loading.varies

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(wear=setting.wear * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a wear coefficient or a sliding speed of {sizes[0]:.4g} times ours: time runs "
            f"{sizes[0]:.4g} times as fast"
        )


class Load(Factor):
    """A wrong load: pressures, displacements and worn heights are the same multiple of ours."""

    name = "normal force"
    group = "load"
    prior = 0.05
    remedy = "compare the sum of 2 pi r p dr with the load of the scene"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat and model.pressed_by_force

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(force=setting.force * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a load of {sizes[0]:.4g} times ours, which multiplies all results"


class ForcePerLength(Load):
    """The load was entered per length, angle or area: a radian, the rim, a radius, the area."""

    searched = False
    name = "force per length"
    fitted_numbers = 0
    remedy = (
        "compare the sum of 2 pi r p dr with the load; look up whether an axisymmetric load counts "
        "for the whole circumference"
    )

    @staticmethod
    def descriptions(model: Model) -> dict[float, str]:
        """Return descriptions of the ways to enter a load wrongly, by their factor on the force."""
        radius = model.problem.units.length
        divisors = {
            2 * math.pi: "per radian, 1/(2 pi) of the whole",
            2 * math.pi * radius: "per length of the rim, 1/(2 pi a) of the whole",
            math.pi * radius**2: "per area, 1/(pi a^2) of the whole",
            2 * radius: "per length of the diameter, 1/(2a) of the whole",
            radius: "per length of the radius, 1/a of the whole",
            4.0: "of a quarter of the punch",
            2.0: "of half the punch",
        }
        divided = {1 / factor: words for factor, words in divisors.items()}
        multiplied = {
            factor: f"{words}, but multiplied instead of divided"
            for factor, words in divisors.items()
        }
        both = multiplied | divided
        return {
            factor: words
            for factor, words in both.items()
            if abs(math.log(factor)) > MIN_LOG_FACTOR
        }

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(factor,) for factor in self.descriptions(model)]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a load of {sizes[0]:.4g} times ours, which multiplies all results: a force "
            f"{self.descriptions(model)[sizes[0]]}"
        )


class Stiffness(Factor):
    """A wrong modulus: the compliance is divided by a factor, and running-in is faster by it."""

    name = "modulus"
    group = "modulus"
    prior = 0.04
    remedy = "compare the modulus of the input, and F / (2 a E*) with the first indentation"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(stiffness=setting.stiffness * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return f"a half-space {sizes[0]:.4g} times as stiff as ours"


class PoissonsRatio(Stiffness):
    """E was used in place of E/(1 - nu^2), or the reverse."""

    searched = False
    name = "Poisson's ratio"
    prior, choices = 0.03, 2
    fitted_numbers = 0
    remedy = "compute with a Poisson's ratio of 0: the error disappears"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return not model.problem.ground.layered and abs(model.problem.poisson_ratio) > 0.1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        plane = 1 - model.problem.poisson_ratio**2
        return [(plane,), (1 / plane,)]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a half-space {sizes[0]:.4g} times as stiff as ours: E in place of E/(1 - nu^2), or "
            "the reverse"
        )


class Diameter(Cause):
    """A diameter was used as the radius of the punch, or the reverse."""

    name = "radius for diameter"
    group, choices = "radius", 2
    prior = 0.06
    remedy = "look up the radius in the model beyond which pressures are zero"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        # not on layers: their thickness over the radius would change, too
        return not model.problem.ground.layered

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(2.0,), (0.5,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(radius=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a punch of {sizes[0]:g} times the radius: a diameter in place of a radius, or the "
            "reverse"
        )


class SwappedMaterials(Cause):
    """The wear coefficients of two materials are exchanged."""

    name = "swapped materials"
    group = "swapped"
    prior = 0.05
    remedy = "look at the latest pressures: they must be greatest on rings that wear least"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        rings = model.problem.graded or model.problem.rings
        two_materials = not rings.linear and len(set(rings.wear_coefficients[0])) == 2
        return model.has_later_times and two_materials

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(swapped=True)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return "swapped wear coefficients of two materials"


class PlaneStrain(Cause):
    """The program models a strip in plane strain in place of an axisymmetric punch."""

    name = "plane strain"
    group, searched = "ground", True
    prior = 0.05
    fitted_numbers = 2
    remedy = (
        "look up whether the element type is axisymmetric, and the load that of the whole circle; "
        "in plane strain the indentation grows with the logarithm of the depth of the mesh"
    )

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat and model.pressed_by_force and not model.problem.ground.layered

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        # the force per length is F / 2a, that of the mean pressure, or F over one unit of length
        unit = min(max(2 * model.problem.units.length, 1e-6), 1e6)
        return [(1.0, 0.5), (4 / math.pi, 2.0), (unit, 0.5)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(
            ground="plane strain", force=setting.force * sizes[0], depth_offset=sizes[1]
        )

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return 1e-9 < sizes[0] < 1e9

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        force = sizes[0] / (2 * model.problem.units.length)
        return (
            "a strip in plane strain in place of an axisymmetric punch, under a force per length "
            f"of {force:.3g} F (mean pressure: {sizes[0] * math.pi / 4:.3g} times ours)"
        )


class NoLayers(Cause):
    """The layers of the scene are left out."""

    name = "layers left out"
    group, choices = "ground", 2
    prior = 0.06
    remedy = "compare the material of the model at each depth with the layers of the scene"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.flat and model.problem.ground.layered

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        ground = model.problem.ground
        # plane strain moduli, which are divided by that of the first layer below
        moduli = [
            2 * shear / (1 - ratio)
            for shear, ratio in zip(ground.shear_moduli, ground.poisson_ratios, strict=True)
        ]
        return [(modulus / moduli[0],) for modulus in moduli if math.isfinite(modulus)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        stiffness = setting.stiffness * sizes[0]
        return setting._replace(ground="homogeneous", stiffness=stiffness)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a homogeneous half-space {sizes[0]:.4g} times as stiff as the first layer, without "
            "the layers of the scene"
        )


class Layer(Cause):
    """The program has a softer or stiffer layer on the half-space, and the scene has none."""

    name = "layer"
    group, searched = "ground", True
    prior = 0.03
    fitted_numbers = 2
    remedy = "compute with a homogeneous half-space, and compare indentation and pressures"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        homogeneous = not model.problem.ground.layered and model.problem.poisson_ratio < 0.5
        return model.flat and model.pressed_by_force and homogeneous

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(thickness, modulus) for thickness in THICKNESSES for modulus in STIFFNESSES]

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        inside = THICKNESSES[0] <= sizes[0] <= THICKNESSES[-1]
        return inside and STIFFNESSES[0] <= sizes[1] <= STIFFNESSES[-1]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(ground="layer", layer=(sizes[0], sizes[1]))

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that is reported for the mistake."""
        return sizes[1]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        kind = "soft" if sizes[1] < 1 else "stiff"
        return (
            f"a {kind} layer on the half-space, about {sizes[0]:.2g} a thick and {sizes[1]:.2g} "
            "times as stiff as the half-space, which the scene does not have"
        )
