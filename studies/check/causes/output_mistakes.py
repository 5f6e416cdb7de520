"""Mistakes in what another program prints, such as signs, units and factors; errors in time."""

import math
from typing import ClassVar

import numpy as np

from .cause import Cause, Factor, Sizes
from .histories import LENGTHS
from .model import Model
from .setting import Setting

# greatest relative difference of a fitted factor to a well-known one whose name it is given
MAX_FACTOR_DIFFERENCE = 0.01


class Sign(Cause):
    """Some quantities have the opposite sign, such as pressures that are printed as stresses."""

    name = "sign"
    group = "sign"
    prior = 0.1
    remedy = (
        "compare the sign conventions: p is positive in compression; u, d and f are positive into "
        "the half-space"
    )

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(signs=True)

    def size(self, model: Model, sizes: Sizes) -> float:
        """Return the number that is reported for the mistake."""
        return -1.0

    def negated_quantities(self, model: Model, setting: Setting) -> list[str]:
        """Return the quantities whose sign is opposite to ours."""
        factors = model.factors_by_name(setting)
        return [name for name, factor in factors.items() if factor < 0]

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        names = self.negated_quantities(model, setting)
        return f"sign of the {names[0].replace('_', ' ')}" if len(names) == 1 else "signs"

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        names = " and ".join(
            name.replace("_", " ") for name in self.negated_quantities(model, setting)
        )
        return f"an opposite sign of {names}"


class Units(Cause):
    """Lengths, pressures or forces are in other units: a power of a thousand times ours."""

    name = "units"
    group = "units"
    prior = 0.06
    remedy = "give the units of the table by --units, or in the headings of its columns"

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(units="kinds")

    def factors(self, model: Model, setting: Setting) -> dict[str, float]:
        """Return the power of a thousand of each quantity where it is not 1."""
        factors = model.factors_by_name(setting._replace(signs=False))
        return {name: factor for name, factor in factors.items() if factor != 1}

    def size_in(self, model: Model, setting: Setting) -> float:
        """Return the power of a thousand that is farthest from 1, in a setting."""
        sizes = self.factors(model, setting).values()
        return max(sizes, key=lambda factor: abs(math.log(factor)), default=1.0)

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        multiples = ", ".join(
            f"the column {name} is {factor:.4g} times ours"
            for name, factor in self.factors(model, setting).items()
        )
        return f"other units than ours: {multiples}"


class ColumnUnits(Units):
    """Single columns are in other units, though other columns of the same kind are right."""

    prior = 0.05

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return len({*LENGTHS} & {*model.comparison.quantities}) > 1

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(units="columns")


class UnitOfTime(Cause):
    """Times are in another unit than those of the scene, such as minutes, hours or milliseconds."""

    name = "units of time"
    group, choices = "time", 3
    prior = 0.15
    remedy = (
        "give the unit of time of the table by --units, or in the heading of its times; a wear "
        "coefficient or a sliding speed in another unit has the same effect"
    )

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return model.has_later_times

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        return [(1000.0,), (0.001,), (60.0,), (1 / 60,), (3600.0,), (1 / 3600,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(table_time=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"another unit of time, {sizes[0]:.4g} times that of the scene: the column time is "
            f"{1 / sizes[0]:.4g} times ours"
        )


class UnitOfRadii(Cause):
    """Radii in the table are diameters, or in another unit, such as metres for millimetres."""

    name = "units of radii"
    group, choices = "radius", 2
    prior = 0.03
    remedy = "compare the greatest radius of the table with punch.radius; give --units"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return len(model.comparison.radii) > 1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        greatest = model.comparison.radii.max() / model.problem.units.length
        power = 1000.0 ** -round(math.log10(greatest or 1.0) / 3)
        sizes: list[Sizes] = [(2.0,), (0.5,)]
        return [*sizes, (power,)] if power > 1 else sizes

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(table_radii=sizes[0])

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        kind = {2.0: "halves of the radii", 0.5: "diameters"}.get(sizes[0], "in another unit")
        return (
            f"radii that are {kind}: the right ones are {sizes[0]:.4g} times those of the table: "
            f"the column radius is {1 / sizes[0]:.4g} times ours"
        )


class ConstantFactor(Factor):
    """One kind of quantity is a multiple of ours at all times, and the others are correct.

    Attributes
    ----------
    kind : field of the setting that has the factor
    quantities : the quantities that are multiplied
    """

    name = "constant factor"
    prior = 0.04
    kind: ClassVar[str]
    quantities: ClassVar[tuple[str, ...]]

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return bool({*self.quantities} & {*model.comparison.quantities})

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(**{self.kind: getattr(setting, self.kind) * sizes[0]})

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        return known_factor(model, sizes[0]) or self.name

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        present = [name for name in self.quantities if name in model.comparison.quantities]
        names = ", ".join(name.replace("_", " ") for name in present)
        verb = "is" if len(present) == 1 else "are"
        return f"a constant factor: {names} {verb} {sizes[0]:.4g} times ours at all times and radii"


class PressureFactor(ConstantFactor):
    """Only pressures are a multiple of ours."""

    group = "pressure factor"
    kind = "pressure"
    quantities = ("pressure",)
    remedy = "compare the units, and the sum of 2 pi r p dr with the load"


class LengthFactor(ConstantFactor):
    """Only displacements, worn heights and indentations are a multiple of ours."""

    group = "lengths factor"
    kind = "lengths"
    quantities = LENGTHS
    remedy = "compare the units; compute with a Poisson's ratio of 0"


class ForceFactor(ConstantFactor):
    """Only normal forces are a multiple of ours."""

    group = "normal_force factor"
    kind = "normal_force"
    quantities = ("normal_force",)
    remedy = (
        "compare the units; look up whether the force of an axisymmetric model acts on the whole "
        "circumference"
    )


class ColumnFactor(Factor):
    """One length alone is a multiple of ours, and the other lengths are correct.

    Parameters
    ----------
    column : the name of its quantity
    """

    name = "constant factor"
    prior = 0.03
    group = "column factor"
    remedy = "compare the unit and the definition of this column with those of the others"

    def __init__(self, column: str) -> None:
        self.column = column

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        lengths = {*LENGTHS} & {*model.comparison.quantities}
        return self.column in lengths and len(lengths) > 1

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(column=(self.column, sizes[0]))

    def name_of(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return the name of the mistake at these sizes."""
        return known_factor(model, sizes[0]) or self.name

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a constant factor: the column {self.column} alone is {sizes[0]:.4g} times ours at "
            "all times"
        )


class LateStart(Cause):
    """The history of the program begins later than time 0."""

    name = "late start"
    group, searched = "late", True
    prior = 0.04
    fitted_numbers = 1
    remedy = "subtract this from all times: the error disappears"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return len(model.times) > 1

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        last = model.comparison.times.max()
        return [(last * fraction,) for fraction in (0.02, 0.1, 0.3, 0.6)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(start_delay=sizes[0])

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return 0 < sizes[0] < float(model.comparison.times.max())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        return (
            f"a history that starts too late, at about t = {model.names.write(sizes[0], 'time', 3)}"
        )


class FirstOrderStep(Cause):
    """Time steps of first order, implicit or explicit, that are too long."""

    name = "first-order time step"
    group, searched = "step", True
    prior = 0.05
    fitted_numbers = 1
    remedy = "compute with half the time step: the error is halved"

    def applies(self, model: Model) -> bool:
        """Return whether the mistake could be recognised in these results."""
        return len(model.times) > 1 and model.flat

    def candidates(self, model: Model) -> list[Sizes]:
        """Return the sizes to try or to begin a search at."""
        longest = float(np.diff(model.comparison.times, prepend=0.0).max())
        return [(longest / 20,), (-longest / 20,)]

    def change(self, setting: Setting, sizes: Sizes) -> Setting:
        """Return the setting with this mistake added."""
        return setting._replace(step=sizes[0])

    def is_possible(self, model: Model, sizes: Sizes) -> bool:
        """Return whether sizes lie in the range that is considered."""
        return abs(sizes[0]) < float(model.comparison.times.max())

    def sentence(self, model: Model, setting: Setting, sizes: Sizes) -> str:
        """Return what the error looks like, with its number, as a noun phrase."""
        kind = "implicit" if sizes[0] > 0 else "explicit"
        length = model.names.write(abs(sizes[0]), "time", 3)
        return f"{kind} time steps of first order, about {length} long"


def known_factor(model: Model, size: float) -> str:
    """Return the name of the mistake that has a well-known factor; empty if there is none."""
    plane = 1 - model.problem.poisson_ratio**2
    labels = {1e3: "units", 1e6: "units", 2 * math.pi: "2 pi missing", plane: "Poisson's ratio"}
    for number, label in labels.items():
        if (
            number != 1
            and min(abs(size / number - 1), abs(size * number - 1)) < MAX_FACTOR_DIFFERENCE
        ):
            return label
    return ""
