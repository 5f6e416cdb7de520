"""Mistakes in what another program models: material, load, geometry, ground."""

import math

from .cause import Cause, Factor, Sizes
from .model import STIFFNESSES, THICKNESSES, Model
from .setting import Setting

# logarithm of a factor on the load, below which it is none
NEAR = 0.06


class WearCoefficient(Factor):
    """Time runs faster or slower, while pressures and displacements begin and end the same."""

    name = "wear coefficient"
    group = "time"
    prior = 0.15
    greatest = 1e7
    remedy = (
        "k and v in the input, and their units; with all times multiplied by it the error is gone"
    )

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return bool((model.times > 0).any()) and not model.problem.loading.varies

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(wear=setting.wear * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return (
            f"time runs {sizes[0]:.4g} times as fast: a wear coefficient, or a sliding speed, of "
            f"{sizes[0]:.4g} times ours"
        )


class TruncatedHalfSpace(Cause):
    """Displacements are too low by one length, or forces too high for a given indentation."""

    name = "truncated half-space"
    group, searched = "box", True
    prior = 0.1
    fitted = 1
    remedy = "a half-space twice as large has half the error"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        if model.problem.ground is not None:
            return False
        if model.pressed_by_force:
            return bool({"displacement", "indentation"} & {*model.comparison.names})
        return model.flat

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        return [(0.05,), (0.2,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(box=sizes[0])

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        return 1e-3 < sizes[0] < 0.5

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that people know it by."""
        return 1 / sizes[0]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        reach = f"a half-space that is clamped at about {1 / sizes[0]:.4g} radii"
        if model.pressed_by_force:
            low = "displacements are too low by one length"
            return f"{low}: {reach}, which takes about 1.1 a/R of the indentation"
        high = "forces are too high for the indentation"
        return f"{high}: {reach}, which adds about 1.1 a/R to the first force"


class Load(Factor):
    """All pressures, displacements and worn heights are the same multiple of ours."""

    name = "normal force"
    group = "load"
    prior = 0.05
    remedy = "the sum of 2 pi r p dr beside the load of the scene"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return model.flat and model.pressed_by_force

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(force=setting.force * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"a load of {sizes[0]:.4g} times ours, by which all results are multiplied"


class ForcePerLength(Load):
    """The load counts for a length or an angle: a radian, the rim, a radius, the area."""

    searched = False
    name = "force per length"
    fitted = 0
    remedy = "the sum of 2 pi r p dr beside the load: what an axisymmetric load counts for"

    @staticmethod
    def known(model: Model) -> dict[float, str]:
        """Return what a load may count for, by its factor on the force."""
        radius = model.problem.units.length
        lengths = {
            2 * math.pi: "per radian: 1/(2 pi) of it",
            2 * math.pi * radius: "per length of the rim: 1/(2 pi a) of it",
            math.pi * radius**2: "per area: 1/(pi a^2) of it",
            2 * radius: "per length of the diameter: 1/(2a) of it",
            radius: "per length of the radius: 1/a of it",
            4.0: "of a quarter of the punch",
            2.0: "of half the punch",
        }
        near = {1 / factor: words for factor, words in lengths.items()}
        over = {factor: f"{words}, the wrong way round" for factor, words in lengths.items()}
        known = over | near
        return {factor: words for factor, words in known.items() if abs(math.log(factor)) > NEAR}

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        return [(factor,) for factor in self.known(model)]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return (
            f"a load of {sizes[0]:.4g} times ours, by which all results are multiplied: a force "
            f"{self.known(model)[sizes[0]]}"
        )


class Stiffness(Factor):
    """Displacements by pressures are a multiple of ours, and running-in is faster by it."""

    name = "modulus"
    group = "modulus"
    prior = 0.04
    remedy = "the modulus in the input; F / (2 a E*) beside the first indentation"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return model.flat

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(stiffness=setting.stiffness * sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"a half-space {sizes[0]:.4g} times as stiff"


class PoissonsRatio(Stiffness):
    """The half-space has E for E/(1 - nu^2), or the reverse."""

    searched = False
    name = "Poisson's ratio"
    prior, choices = 0.03, 2
    fitted = 0
    remedy = "with a Poisson's ratio of 0 the error is gone"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return model.problem.ground is None and abs(model.problem.poisson_ratio) > 0.1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        plane = 1 - model.problem.poisson_ratio**2
        return [(plane,), (1 / plane,)]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"a half-space {sizes[0]:.4g} times as stiff: E for E/(1 - nu^2), or the reverse"


class Diameter(Cause):
    """The model has twice or half the radius: a diameter for a radius, or the reverse."""

    name = "radius for diameter"
    group, choices = "radius", 2
    prior = 0.06
    remedy = "the radius in the model where pressures end"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        # layers would be thinner, over the radius
        return model.problem.ground is None

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        return [(2.0,), (0.5,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(radius=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"a punch of {sizes[0]:g} times the radius: a diameter for a radius, or the reverse"


class SwappedMaterials(Cause):
    """The wear coefficients of two materials are exchanged."""

    name = "swapped materials"
    group = "swapped"
    prior = 0.05
    remedy = "late pressures are greatest where wear is least"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        wear = (model.problem.graded or model.problem.rings).wear_coefficients
        return bool((model.times > 0).any()) and wear.min() < wear.max()

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(swapped=True)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return "the wear coefficients of two materials are swapped"


class PlaneStrain(Cause):
    """The half-space is one of plane strain under a strip, not of an axisymmetric punch."""

    name = "plane strain"
    group, searched = "ground", True
    prior = 0.05
    fitted = 2
    remedy = (
        "an axisymmetric element type, and a load for the whole circle; in plane strain the "
        "indentation grows with the logarithm of the depth of the mesh"
    )

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return model.flat and model.pressed_by_force and model.problem.ground is None

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        # under F / 2a, under the mean pressure, and under F over one unit of length
        unit = min(max(2 * model.problem.units.length, 1e-6), 1e6)
        return [(1.0, 0.5), (4 / math.pi, 2.0), (unit, 0.5)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(
            ground="plane strain", force=setting.force * sizes[0], depth=sizes[1]
        )

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        return 1e-9 < sizes[0] < 1e9

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
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
    remedy = "the materials by depth in the model"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return model.flat and model.problem.ground is not None

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        ground = model.problem.ground
        assert ground is not None  # it applies
        # plane strain moduli over that of the first layer
        moduli = [
            2 * shear / (1 - ratio)
            for shear, ratio in zip(ground.shear_moduli, ground.poisson_ratios, strict=True)
        ]
        return [(of / moduli[0],) for of in moduli if math.isfinite(of)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        stiffness = setting.stiffness * sizes[0]
        return setting._replace(ground="homogeneous", stiffness=stiffness)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return (
            f"a homogeneous half-space {sizes[0]:.4g} times as stiff as the first layer, without "
            "the layers of the scene"
        )


class Layer(Cause):
    """The half-space of the scene is covered by a layer that is softer or stiffer."""

    name = "layer"
    group, searched = "ground", True
    prior = 0.03
    fitted = 2
    remedy = "the indentation and the pressures of a model that is homogeneous"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        homogeneous = model.problem.ground is None and model.problem.poisson_ratio < 0.5
        return model.flat and model.pressed_by_force and homogeneous

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        return [(thickness, modulus) for thickness in THICKNESSES for modulus in STIFFNESSES]

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        inside = THICKNESSES[0] <= sizes[0] <= THICKNESSES[-1]
        return inside and STIFFNESSES[0] <= sizes[1] <= STIFFNESSES[-1]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(ground="layer", layer=(sizes[0], sizes[1]))

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that people know it by."""
        return sizes[1]

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        kind = "soft" if sizes[1] < 1 else "stiff"
        return (
            f"a half-space under a {kind} layer, about {sizes[0]:.2g} a thick and {sizes[1]:.2g} "
            "times as stiff, which the scene does not have"
        )
