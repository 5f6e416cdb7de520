"""Mistakes in what another program prints: signs, units, factors, and in its steps of time."""

import math
from typing import ClassVar

import numpy as np

from .cause import Cause, Factor, Sizes
from .model import LENGTHS, Model
from .setting import Setting

# how near to a number that people know a fitted one has to be, to be called by it
EQUAL = 0.01


class Sign(Cause):
    """Some quantities are the negative of ours, as pressures are that are stresses."""

    name = "sign"
    group = "sign"
    prior = 0.1
    remedy = "p is positive in compression; u, d and f are positive into the half-space"

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(signs=True)

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that people know it by."""
        return -1.0

    def turned(self, model: Model, setting: Setting) -> list[str]:
        """Return quantities of opposite sign."""
        factors = model.factors_by_name(setting)
        return [name for name, factor in factors.items() if factor < 0]

    def named(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake of this size."""
        names = self.turned(model, setting)
        return f"sign of the {names[0].replace('_', ' ')}" if len(names) == 1 else "signs"

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        names = " and ".join(name.replace("_", " ") for name in self.turned(model, setting))
        return f"the opposite sign of {names}"


class Units(Cause):
    """Lengths, pressures or forces are a power of a thousand times ours."""

    name = "units"
    group = "units"
    prior = 0.06
    remedy = "--units, or the heading of the column, with the units of theirs"

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(units=True)

    def factors(self, model: Model, setting: Setting) -> dict[str, float]:
        """Return the powers of a thousand, by quantity, that are not 1."""
        found = model.factors_by_name(setting._replace(signs=False))
        return {name: factor for name, factor in found.items() if factor != 1}

    def size_in(self, model: Model, setting: Setting) -> float:
        """Return the power that is farthest from 1."""
        sizes = self.factors(model, setting).values()
        return max(sizes, key=lambda factor: abs(math.log(factor)), default=1.0)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        told = ", ".join(
            f"{name.replace('_', ' ')} {factor:.4g}"
            for name, factor in self.factors(model, setting).items()
        )
        return f"other units, by the factors over ours: {told}"


class UnitOfTime(Cause):
    """Times are in minutes, hours or milliseconds of those of the scene."""

    name = "units of time"
    group, choices = "time", 3
    prior = 0.03
    remedy = "--units, or the heading of the times, with the unit of theirs"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return bool((model.times > 0).any())

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        return [(1000.0,), (0.001,), (60.0,), (1 / 60,), (3600.0,), (1 / 3600,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(time=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"times in another unit, {sizes[0]:.4g} times that of the scene"


class UnitOfRadii(Cause):
    """Radii are diameters, or in metres in a scene of millimetres."""

    name = "units of radii"
    group, choices = "radius", 2
    prior = 0.03
    remedy = "the greatest radius in the table beside punch.radius; --units"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return len(model.comparison.radii) > 1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        greatest = model.comparison.radii.max() / model.problem.units.length
        near = 1000.0 ** -round(math.log10(greatest or 1.0) / 3)
        found: list[Sizes] = [(2.0,), (0.5,)]
        return [*found, (near,)] if near > 1 else found

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(radii=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        what = {2.0: "halves of the radii", 0.5: "diameters"}.get(sizes[0], "in another unit")
        return f"radii are {what}: a radius of the table is {sizes[0]:.4g} times as large in ours"


class ConstantFactor(Factor):
    """One kind of quantity is a multiple of ours at all times, and the others are right."""

    name = "constant factor"
    prior = 0.04
    kind: ClassVar[str]
    quantities: ClassVar[tuple[str, ...]]

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return bool({*self.quantities} & {*model.comparison.names})

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(**{self.kind: getattr(setting, self.kind) * sizes[0]})

    def named(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake of this size."""
        return known_factor(model, sizes[0]) or self.name

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        names = ", ".join(
            name.replace("_", " ") for name in self.quantities if name in model.comparison.names
        )
        return f"over ours, at all times and radii: {names} {sizes[0]:.4g}"


class PressureFactor(ConstantFactor):
    """Pressures alone are a multiple of ours."""

    group = "pressure factor"
    kind = "pressure"
    quantities = ("pressure",)
    remedy = "units; the sum of 2 pi r p dr beside the load"


class LengthFactor(ConstantFactor):
    """Displacements, worn heights and indentations are a multiple of ours."""

    group = "lengths factor"
    kind = "lengths"
    quantities = LENGTHS
    remedy = "units; results with a Poisson's ratio of 0"


class ForceFactor(ConstantFactor):
    """Normal forces alone are a multiple of ours."""

    group = "normal_force factor"
    kind = "normal_force"
    quantities = ("normal_force",)
    remedy = "units; what the force of an axisymmetric model counts for"


class LateStart(Cause):
    """The history begins after the first time."""

    name = "late start"
    group, searched = "late", True
    prior = 0.04
    fitted = 1
    remedy = "with this taken off the times the error is gone"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return len(model.times) > 1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        last = model.comparison.times.max()
        return [(last * share,) for share in (0.02, 0.1, 0.3, 0.6)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(late=sizes[0])

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        return 0 < sizes[0] < float(model.comparison.times.max())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        return f"a history that starts about {sizes[0]:.3g} too late"


class FirstOrderStep(Cause):
    """Long steps of first order in time, implicit or explicit."""

    name = "first-order time step"
    group, searched = "step", True
    prior = 0.05
    fitted = 1
    remedy = "half the time step has half the error"

    def applies(self, model: Model) -> bool:
        """Return whether the results could show it."""
        return len(model.times) > 1 and model.flat

    def candidates(self, model: Model) -> list[Sizes]:
        """Return sizes to try, or to begin a search from."""
        longest = float(np.diff(model.comparison.times, prepend=0.0).max())
        return [(longest / 20,), (-longest / 20,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return a setting with this mistake in it, of a size."""
        return setting._replace(step=sizes[0])

    def within(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes are possible."""
        return abs(sizes[0]) < float(model.comparison.times.max())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the results look like, with the number."""
        kind = "implicit" if sizes[0] > 0 else "explicit"
        return f"{kind} steps of first order, of about {abs(sizes[0]):.3g}"


def known_factor(model: Model, size: float) -> str:
    """Return the name of a mistake by a factor that people know; empty if it is none."""
    plane = 1 - model.problem.poisson_ratio**2
    labels = {1e3: "units", 1e6: "units", 2 * math.pi: "2 pi missing", plane: "Poisson's ratio"}
    for number, label in labels.items():
        if number != 1 and min(abs(size / number - 1), abs(size * number - 1)) < EQUAL:
            return label
    return ""
